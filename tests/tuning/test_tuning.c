/*
 * test_tuning.c: records what tuning may change: numbers of sweeps, steps, factorisations and
 * pivots, the stages of auto and the memory that it allocates for them, the bits of accelerated
 * sweeps. A change of tuning that breaks a test here needs a new figure; one that breaks a test
 * elsewhere is a defect.
 */
#include "cases.h"
#include "delassus.h"
#include "doors.h"
#include "failures.h"
#include "front_cases.h"
#include "half_space.h"
#include "made.h"
#include "run.h"
#include "vi/vi_internal.h"

/* ---- sweeps ---------------------------------------------------------------------------------- */

/* From r = 0: sweeps of Gauss-Seidel; steps of Newton without sweeps and eps = 0 (-1: it
 * cycles). */
static const struct {
  const char *name;
  int sweeps, steps;
} known[] = {
    {"separate", 0, 0},    {"q = 0", 0, 0},      {"stick", 1, 1},
    {"slip right", 1, 1},  {"slip left", 1, 1},  {"coupled stick", 1, 1},
    {"no friction", 1, 1}, {"slip in 3D", 1, 1}, {"coupled slip left", 1, 1},
    {"C7", 1, -1},         {"C7 in 3D", 1, -1},  {"coupled slip right", 1, 2} /* stick first */,
    {"C16", 1, -1},
};
enum { known_count = sizeof known / sizeof known[0] };

TEST_EACH(sweeps_by_hand, 0, known_count) {
  static model a;
  set_hand(&a, hand_named(known[_i].name));
  const dls_nlgs_settings s = nlgs_tol(1e-14);
  double r[4];
  dls_info info;
  ck_assert_int_eq(run_nlgs(&a.p, &s, r, NULL, &info), DLS_OK);
  ck_assert_int_eq(info.iterations, known[_i].sweeps);
}

TEST_EACH(fewer_sweeps, 0, 10) {
  static model a;
  slow_model(&a, _i);
  double r[most];
  dls_info none, aitken, anderson;
  dls_nlgs_settings s = nlgs_tol(1e-12);
  s.limits.max_iterations = 100000;
  ck_assert_int_eq(run_nlgs(&a.p, &s, r, NULL, &none), DLS_OK);
  s.acceleration = DLS_ACCELERATION_AITKEN;
  ck_assert_int_eq(run_nlgs(&a.p, &s, r, NULL, &aitken), DLS_OK);
  s.acceleration = DLS_ACCELERATION_ANDERSON;
  ck_assert_int_eq(run_nlgs(&a.p, &s, r, NULL, &anderson), DLS_OK);
  /* measured: 98-159, 52-80, 33-44 */
  ck_assert_int_le(5 * aitken.iterations, 4 * none.iterations);
  ck_assert_int_le(2 * anderson.iterations, none.iterations);
}

/* The candidates numbered backwards and visited in the same order, W singular, u afresh on the way:
 * as long as no residual is one of rounding, by which the best r is chosen, not a bit is another
 * one. */
TEST(same_visits_same_bits) {
  static model a, b;
  const dls_acceleration kinds[] = {DLS_ACCELERATION_AITKEN, DLS_ACCELERATION_ANDERSON,
                                    DLS_ACCELERATION_NONE};
  int compared = 0;
  for (int number = 0; number < 40; number++) {
    deficient_model(&a, number);
    reverse_model(&b, &a);
    const int d = a.p.d, nc = a.p.nc;
    int order[2][most];
    for (int c = 0; c < nc; c++) {
      order[0][c] = c;
      order[1][c] = nc - 1 - c;
    }
    for (int k = 0; k < 3; k++) {
      dls_nlgs_settings s = nlgs_tol(0);
      s.acceleration = kinds[k];
      s.limits.max_iterations = k < 2 ? 8 : 60;
      s.limits.warm_start = 1;
      double r[2][most];
      dls_certificate c;
      for (int side = 0; side < 2; side++) {
        for (int i = 0; i < d * nc; i++)
          r[side][i] = ((side ? reversed(&a, i) : i) % 7 - 3) * norm_of(a.q, d * nc);
        dls_nlgs *work;
        dls_info info;
        ck_assert_int_eq(dls_nlgs_create(&work, d, nc, &s, NULL), DLS_OK);
        (void)dlsi_nlgs_run(work, side ? &b.p : &a.p, order[side], NULL, r[side], NULL, &info);
        c = info.certificate;
        dls_nlgs_destroy(work);
      }
      if (c.residual < 1e-10) continue;
      compared++;
      for (int i = 0; i < d * nc; i++)
        ck_assert(r[1][i] == r[0][reversed(&a, i)]);
    }
  }
  ck_assert_int_ge(compared, 60);
}

/* ---- Newton's steps -------------------------------------------------------------------------- */

TEST_EACH(steps_by_hand, 0, known_count) {
  const hand_case *k = hand_named(known[_i].name);
  static model a;
  if (known[_i].steps < 0) return;
  set_hand(&a, k);
  dls_newton_settings s = newton_tol(1e-14);
  s.sweeps = 0;
  s.regularization = 0;
  double r[4];
  dls_info info;
  ck_assert_int_eq(run_newton(&a.p, &s, r, NULL, &info), DLS_OK);
  ck_assert_int_eq(info.iterations, known[_i].steps);
  ck_assert_int_eq(info.sweeps, 0);
  assert_near(r, k->r, k->d * k->nc, 1e-14);
}

TEST_EACH(few_steps_after_sweeps, 0, 40) {
  static model a;
  numbered_model(&a, _i);
  const dls_newton_settings s = newton_tol(1e-12);
  double r[most];
  dls_info info;
  ck_assert_int_eq(run_newton(&a.p, &s, r, NULL, &info), DLS_OK);
  ck_assert_int_le(info.iterations, 6);
}

/* ---- factorisations of ADMM ------------------------------------------------------------------ */

/* W + rho D is singular at first: w = 1, W_tt = -1. */
TEST(singular_sum_is_factorised_twice) {
  static model a;
  const hand_case k = {"singular", 2, 1, {3, 0, 0, -1}, {-3, 1}, 0, {1, 0}};
  set_hand(&a, &k);
  const dls_admm_settings s = admm_tol(1e-14);
  double r[2];
  dls_info info;
  ck_assert_int_eq(run_admm(&a.p, &s, r, NULL, &info), DLS_OK);
  ck_assert_int_eq(info.factorisations, 2);
}

/* data/failures from any rho: the rule changes it nine times at most. */
TEST_EACH(few_changes_of_rho, 0, 8) {
  const double rho[] = {0.01, 0.03, 0.1, 0.3, 1, 3, 10, 100};
  int count;
  const failure *f = contact_failures(&count);
  for (int k = 0; k < count; k++) {
    const dls_contact p = failure_contact(&f[k]);
    dls_admm_settings s = admm_tol(1e-12);
    s.rho = rho[_i];
    double r[FAILURE_N];
    dls_info info;
    (void)run_admm(&p, &s, r, NULL, &info);
    ck_assert_int_le(info.factorisations, 9);
  }
}

/* ---- pivots and limits ----------------------------------------------------------------------- */

enum { NC = 12, M = 2 * NC };

static double W[M * M], q[M], mu[NC];

static dls_contact twelve_candidates(unsigned seed) {
  return coupled(W, q, mu, 2, NC, 0.5, 0.3, seed);
}

/* Ten steps of a load that turns: from the states of the step before, one round of the crash start
 * is left. */
TEST(lemke_starts_from_the_last_step) {
  dls_contact p = twelve_candidates(6);
  double load[M], r[M], cold[M];
  int warm_pivots = 0, cold_pivots = 0;
  for (int k = 0; k < 10; k++) {
    for (int i = 0; i < M; i++)
      load[i] = q[i] + 0.02 * k * (i % 2 ? 1 : -1);
    p.q = load;
    dls_solver_settings s = settings_of(DLS_LEMKE);
    dls_info info;
    ck_assert_int_eq(dls_solve(&p, &s, cold, NULL, &info, NULL), DLS_OK);
    if (k > 0) cold_pivots += info.iterations;
    s.limits.warm_start = k > 0;
    ck_assert_int_eq(dls_solve(&p, &s, r, NULL, &info, NULL), DLS_OK);
    if (k > 0) warm_pivots += info.iterations;
    for (int i = 0; i < M; i++)
      ck_assert_double_eq_tol(r[i], cold[i], 1e-11 * (1 + fabs(cold[i])));
  }
  ck_assert_int_eq(warm_pivots, 9); /* one factorisation a step */
  ck_assert_int_gt(cold_pivots, 3 * warm_pivots);
  dls_solver_settings s = settings_of(DLS_LEMKE);
  s.limits.warm_start = 1;
  r[4] = INFINITY;
  REFUSES(NOT_FINITE, "r", 4, dls_solve, &p, &s, r, NULL, NULL);
}

TEST(iteration_limit_is_honest) {
  static const dls_method methods[] = {DLS_NLGS, DLS_LEMKE, DLS_AUTO};
  const dls_contact p = twelve_candidates(3);
  for (int k = 0; k < 3; k++) { /* Newton is there after 2 */
    dls_solver_settings s = settings_of(methods[k]);
    s.limits.max_iterations = 2;
    double r[M];
    dls_info info;
    ck_assert_int_eq(dls_solve(&p, &s, r, NULL, &info, NULL), DLS_MAX_ITERATIONS);
    const int rounds = methods[k] == DLS_LEMKE ? 2 : 0; /* of the crash start, no pivots */
    ck_assert_int_eq(info.iterations, rounds + 2);
    ck_assert(info.certificate.residual > 1e-8 && isfinite(info.certificate.residual));
  }
}

/* ---- stages of auto -------------------------------------------------------------------------- */

/* Sweeps do not solve c11 (data/failures): dls_solve then allocates what the next stages need,
 * which dls_solver_create does at once for all of them. */
TEST(later_stages_are_allocated_when_needed) {
  const double a[16] = {1, 1, 0, -1, 1, 2, 1, -2, 0, 1, 3, 0, -1, -2, 0, 3}, b[4] = {-1, 1, -1, 0},
               friction[2] = {1, 1};
  const dls_contact p = {.d = 2, .nc = 2, .W = {4, 4, 4, a}, .q = b, .mu = friction};
  const dls_solver_settings s = settings_of(DLS_AUTO);
  double r[4], t[4];
  dls_info info;
  ck_assert_int_eq(dls_solve(&p, &s, r, NULL, &info, NULL), DLS_OK);
  ck_assert_int_gt(info.stages, 1);
  const long at_once = fail_in_turn(&p, &s, 1);
  ck_assert_int_gt(at_once, 1);
  ck_assert_int_le(at_once, fail_in_turn(&p, &s, 0) - 1);
  dls_solver *solver = solver_of(2, 2, &s);
  ck_assert_int_eq(dls_solver_solve(solver, &p, t, NULL, NULL, NULL), DLS_OK);
  dls_solver_destroy(solver);
  ck_assert_mem_eq(r, t, sizeof r);
}

/* Sweeps and steps end most of them, and all is solved. */
TEST(auto_solves_what_its_methods_do_not) {
  static planted_problem a;
  int ended_with[DLS_HOMOTOPY + 1] = {0}, failed[DLS_HOMOTOPY + 1] = {0};
  for (int k = 0; k < 120; k++) {
    const dls_contact p = planted_case(&a, k % 60);
    double r[3 * PLANTED];
    const dls_info info = solve_auto(&p, k < 60 ? 1e-10 : 1e-4, r);
    check_report(&info);
    ck_assert_msg(info.status == DLS_OK, "problem %d: residual %g", k, info.certificate.residual);
    ended_with[info.stage[info.stages - 1].method]++;
    for (dls_method m = DLS_NLGS; m <= DLS_NEWTON; m += DLS_NEWTON - DLS_NLGS) {
      dls_solver_settings s = settings_of(m);
      s.limits.tol = 1e-10;
      if (k < 60) failed[m] += dls_solve(&p, &s, r, NULL, NULL, NULL) != DLS_OK;
    }
  }
  ck_assert_int_ge(ended_with[DLS_NLGS], 10);
  ck_assert_int_ge(ended_with[DLS_NEWTON], 10);
  ck_assert(failed[DLS_NLGS] >= 1 && failed[DLS_NEWTON] >= 10);
}

/* W of condition 1e7: 1e-6 of regularisation is felt, and can be left out. */
TEST(positive_definite_saves_steps) {
  static planted_problem a;
  const dls_method which[] = {DLS_NEWTON, DLS_AUTO};
  for (int k = 0; k < 2; k++) {
    int steps[2] = {0};
    for (unsigned seed = 1; seed <= 10; seed++)
      for (int hint = 0; hint < 2; hint++) {
        const dls_contact p = planted(&a, 2, 20, 41, 0.5, seed);
        dls_solver_settings s = settings_of(which[k]);
        s.positive_definite = hint;
        double r[3 * PLANTED];
        dls_info info;
        const dls_status status = dls_solve(&p, &s, r, NULL, &info, NULL);
        ck_assert_int_ge(status, 0);
        if (k) ck_assert_int_eq(status, DLS_OK);
        if (!k) steps[hint] += info.iterations;
        for (int e = 0; e < info.stages; e++)
          if (info.stage[e].method == DLS_NEWTON) steps[hint] += info.stage[e].iterations;
      }
    ck_assert_msg(steps[1] < steps[0], "%d, %d", steps[0], steps[1]);
  }
}

/* The surface of an elastic half-plane held far below, pressed and pushed: dense, ill-conditioned,
 * most candidates sticking (test_admm.c). Newton's first steps do not settle it. */
TEST(auto_splits_where_it_is_large_and_stiff) {
  enum { nc = 250, m = 2 * nc };
  static double plane[m * m], load[m], friction[nc], r[m];
  const dls_contact p = half_plane(plane, load, friction, nc, 100, 0.5, 0, 1);
  const dls_info info = solve_auto(&p, 1e-10, r);
  check_report(&info);
  ck_assert_int_eq(info.status, DLS_OK);
  int split = 0;
  for (int k = 0; k < info.stages; k++)
    split += info.stage[k].method == DLS_ADMM;
  ck_assert_int_eq(split, 1);
}

/* Square bricks one on the other, two candidates at the ends of each face that stands on something;
 * W by blocks, rank deficient. In one time step their weight gives them all the velocity (push,
 * -1), or, stirred, each candidate has a velocity of its own; unit of W, 1 / unit of velocities. */
static dls_contact column_of_bricks(int bricks, double push, int stirred, double unit) {
  enum { high = 100 };
  static double x[4 * 2 * 6 * high], load[4 * high], friction[2 * high];
  static int p[2 * high + 1], i[2 * 6 * high];
  unsigned seed = 7;
  int k = 0;
  for (int b = 0; b < 2 * bricks; b++) { /* face b / 2, between bricks b / 2 - 1 and b / 2 */
    for (int a = b / 2 * 2 - 2; a < b / 2 * 2 + 4; a++) {
      if (a < 0 || a >= 2 * bricks) continue;
      const double xa = a % 2 - 0.5, xb = b % 2 - 0.5, inertia = 1. / 6;
      memset(x + 4 * k, 0, 4 * sizeof *x);
      for (int brick = b / 2 - 1; brick <= b / 2; brick++) {
        const int above_a = brick == a / 2, above_b = brick == b / 2;
        if (brick < 0 || (!above_a && brick != a / 2 - 1)) continue;
        const double ya = above_a ? -0.5 : 0.5, yb = above_b ? -0.5 : 0.5;
        const double sign = above_a == above_b ? unit : -unit;
        x[4 * k] += sign * (1 + xa * xb / inertia);
        x[4 * k + 1] -= sign * ya * xb / inertia;
        x[4 * k + 2] -= sign * xa * yb / inertia;
        x[4 * k + 3] += sign * (1 + ya * yb / inertia);
      }
      i[k++] = a;
    }
    p[b + 1] = k;
    load[2 * b] = (stirred ? draw(&seed) - 0.5 : b < 2 ? -1 : 0) / unit;
    load[2 * b + 1] = (stirred ? draw(&seed) - 0.5 : b < 2 ? push : 0) / unit;
    friction[b] = 0.5;
  }
  return (dls_contact){
      .d = 2, .nc = 2 * bricks, .Wb = {2, 2 * bricks, p, i, x}, .q = load, .mu = friction};
}

/* At rest: sweeps would go up and down for long. In motion: no factorisation is risked before 200
 * sweeps. */
TEST_EACH(auto_splits_a_stack_at_rest, 0, 6) {
  const int bricks = _i % 2 ? 100 : 60; /* sparse and dense factors */
  dls_contact p = column_of_bricks(bricks, _i < 2 ? 0 : 0.002, _i >= 4, 1);
  double r[400];
  const dls_info info = solve_auto(&p, 1e-10, r);
  check_report(&info);
  ck_assert_int_eq(info.status, DLS_OK);
  if (_i >= 4)
    for (int k = 0; k < info.stages; k++)
      ck_assert(info.stage[k].method != DLS_ADMM || info.iterations > 200);
  else if (bricks == 60 || WITH_MUMPS) {
    ck_assert(info.stages == 2 && info.stage[1].method == DLS_ADMM);
    ck_assert_int_le(info.stage[1].iterations, 2); /* W is regular on the motions of the joints: */
    ck_assert_int_eq(info.stage[1].factorisations, 2); /* (AR5) takes a smaller rho */
    p = column_of_bricks(bricks, _i < 2 ? 0 : 0.002, 0, 0x1p30);
    const dls_info other_units = solve_auto(&p, 1e-10, r);
    same_stages(&info, &other_units);
  }
}
