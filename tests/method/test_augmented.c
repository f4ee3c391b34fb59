/* test_augmented.c: the augmented Lagrangian and the penalty method, on problems solved by hand, on
 * random ones, on ones without a solution, on bad input. */
#include "cases.h"
#include "delassus.h"
#include "doors.h"
#include "failures.h"
#include "made.h"
#include "run.h"
#include "vi/vi_internal.h"

static dls_augmented *new_augmented(const dls_contact *p, const dls_augmented_settings *settings) {
  dls_augmented *work;
  ck_assert_int_eq(dls_augmented_create(&work, p->d, p->nc, settings, NULL), DLS_OK);
  return work;
}

/* and within the limit; solved: no direction */
static dls_status solve_augmented(dls_augmented *work, const dls_contact *p,
                                  const dls_augmented_settings *settings, double *r, double *u,
                                  dls_info *info) {
  const dls_status status = run_in(&the_augmented, work, p, settings->limits.tol, r, u, info);
  const int given = settings->limits.max_iterations;
  ck_assert_int_le(info->iterations, given ? given : 400);
  if (status == DLS_OK) ck_assert_ptr_null(dlsi_augmented_direction(work));
  return status;
}

static dls_status solve_once(const dls_contact *p, const dls_augmented_settings *settings,
                             double *r, double *u, dls_info *info) {
  dls_augmented *work = new_augmented(p, settings);
  const dls_status status = solve_augmented(work, p, settings, r, u, info);
  dls_augmented_destroy(work);
  return status;
}

/* ---- springs: the augmentations themselves --------------------------------------------------- */

/* One candidate and k augmentations from lambda = 0. Sticking: (W + 1/eps) r_k = r_(k-1)/eps - q,
 * by Cramer; slipping: the same of r_n alone, r_t = -mu r_n. */
TEST(one_candidate) {
  static model a;
  const double eps[] = {0.5, 3, 50};
  for (int e = 0; e < 3; e++)
    for (int sliding = 0; sliding < 2; sliding++) {
      set_hand(&a, hand_named(sliding ? "slip right" : "coupled stick"));
      const double *W = a.W, E = 1 / eps[e];
      double n = 0, t = 0;
      for (int k = 1; k <= 6; k++) {
        const double bn = E * n - a.q[0], bt = E * t - a.q[1];
        const double det = (W[0] + E) * (W[3] + E) - W[1] * W[2];
        n = sliding ? bn / (W[0] + E) : ((W[3] + E) * bn - W[2] * bt) / det;
        t = sliding ? -n : ((W[0] + E) * bt - W[1] * bn) / det;
        ck_assert(sliding || fabs(t) < .5 * n);
        dls_augmented_settings s = augmented_tol(1e-14);
        s.penalty = &eps[e];
        s.adaptive = 0;
        s.limits.max_iterations = k;
        double r[2], u[2];
        dls_info info;
        const dls_status status = solve_once(&a.p, &s, r, u, &info);
        ck_assert(status == DLS_MAX_ITERATIONS && info.iterations == k);
        /* k solutions to 1e-15 |q| or the rounding of |W^-1| |q| */
        assert_near(r, (double[]){n, t}, 2, 1e-13);
      }
    }
}

/* without friction the error of the normal reaction falls by 1 / (1 + eps w) each time */
TEST(factor_of_convergence) {
  static model a;
  set_hand(&a, hand_named("slip right"));
  a.mu[0] = 0;
  for (int e = 0; e < 3; e++) {
    dls_augmented_settings s = augmented_tol(1e-14);
    s.factor = (double[]){0.3, 1, 20}[e];
    s.adaptive = 0;
    const double w = 1.5, eps = s.factor / w; /* w = trace(W) / 2 */
    double wrong = 1;                         /* r_n = 1 is the solution */
    for (int k = 1; k <= 8; k++) {
      wrong /= 1 + eps * 2;
      s.limits.max_iterations = k;
      double r[2];
      dls_info info;
      ck_assert_int_ge(solve_once(&a.p, &s, r, NULL, &info), 0);
      ck_assert_double_eq_tol(1 - r[0], wrong, 1e-14);
      ck_assert(r[1] == 0);
    }
  }
}

/* (32)-(34) as the paper prints them, each candidate with its penalty: after one augmentation from
 * lambda, r is the return mapping of lambda - eps u. */
TEST_EACH(return_mapping, 0, 40) {
  static model a;
  numbered_model(&a, _i);
  const int d = a.p.d, nc = a.p.nc, m = d * nc;
  double eps[most], lambda[most] = {0}, r[most], u[most];
  for (int c = 0; c < nc; c++)
    eps[c] = 2 + uniform();
  dls_augmented_settings s = augmented_tol(1e-13);
  s.penalty = eps;
  s.adaptive = 0;
  s.limits.max_iterations = 1;
  s.limits.warm_start = 1;
  double size_q = 0;
  for (int k = 0; k < m; k++)
    size_q += a.q[k] * a.q[k];
  for (int augmentation = 0; augmentation < 3; augmentation++) {
    dls_info info;
    memcpy(r, lambda, sizeof r);
    const dls_status status = solve_once(&a.p, &s, r, u, &info);
    ck_assert(status == DLS_MAX_ITERATIONS || (status == DLS_OK && a.q[0] > 0));
    for (int c = 0; c < nc; c++) {
      const double *l = lambda + d * c, *uc = u + d * c;
      double R[3] = {fmax(0, l[0] - eps[c] * uc[0])}; /* (32) */
      double trial = 0;
      for (int i = 1; i < d; i++) { /* (33) */
        R[i] = l[i] - eps[c] * uc[i];
        trial = hypot(trial, R[i]);
      }
      const double excess = trial - a.mu[c] * R[0]; /* (34), f_s */
      for (int i = 1; i < d && excess > 0; i++)
        R[i] -= excess * R[i] / trial;
      /* eps w < 3 times the residual, 1e-14 |q| or its floor */
      assert_near(r + d * c, R, d, 1e-12 * (1 + sqrt(size_q)));
    }
    memcpy(lambda, r, sizeof r);
  }
}

/* ---- by hand --------------------------------------------------------------------------------- */

TEST(other_solution) { /* C1 from nothing, and from its sticking solution: it stays */
  static model a;
  set_hand(&a, &ambiguous_case);
  dls_augmented_settings s = augmented_tol(1e-12);
  double r[2];
  dls_info info;
  ck_assert_int_eq(solve_once(&a.p, &s, r, NULL, &info), DLS_OK);
  ck_assert(r[0] == 0 && r[1] == 0);
  s.limits.warm_start = 1;
  r[0] = 2;
  r[1] = -3;
  ck_assert_int_eq(solve_once(&a.p, &s, r, NULL, &info), DLS_OK);
  ck_assert(r[0] == 2 && r[1] == -3 && info.iterations == 0);
}

TEST(start_too_far) { /* W r overflows */
  static model a;
  set_hand(&a, hand_named("stick"));
  dls_augmented_settings s = augmented_tol(1e-12);
  s.limits.warm_start = 1;
  double r[2] = {1.7e308, 1.7e308}, r2[2];
  dls_info info, info2;
  ck_assert_int_eq(solve_once(&a.p, &s, r, NULL, &info), DLS_OK);
  s.limits.warm_start = 0;
  ck_assert_int_eq(solve_once(&a.p, &s, r2, NULL, &info2), DLS_OK);
  ck_assert_mem_eq(r, r2, sizeof r);
}

/* ---- no solution ----------------------------------------------------------------------------- */

TEST_EACH(no_solution_gives_a_direction, 0, jammed_count) {
  const hand_case *k = &jammed[_i];
  static model a;
  set_hand(&a, k);
  const dls_augmented_settings s = augmented_tol(1e-8);
  const int m = k->d * k->nc;
  dls_augmented *work = new_augmented(&a.p, &s);
  ck_assert_ptr_null(dlsi_augmented_direction(work));
  double r[4], u[4];
  dls_info info;
  ck_assert_int_eq(solve_augmented(work, &a.p, &s, r, u, &info), DLS_STALLED);
  ck_assert(info.certificate.residual > 0.1 && isfinite(info.certificate.residual));
  const double *delta = dlsi_augmented_direction(work);
  ck_assert_ptr_nonnull(delta);
  double gain = 0;
  for (int i = 0; i < m; i++) {
    double v = 0;
    for (int j = 0; j < m; j++)
      v += k->W[m * i + j] * delta[j];
    gain += k->q[i] * delta[i];
    ck_assert(fabs(v) < 1e-3);
    ck_assert_double_eq_tol(delta[i], k->r[i], 1e-3); /* (A5): 1e-4 |delta|, |delta| < 2 */
  }
  ck_assert(gain < -0.5);
  if (m == 2) { /* a problem with a solution in the same workspace: no direction */
    set_hand(&a, hand_named("stick"));
    ck_assert_int_eq(solve_augmented(work, &a.p, &s, r, u, &info), DLS_OK);
  }
  dls_augmented_destroy(work);
}

/* Reactions run away at a candidate however small its W is beside that of another one. */
TEST(a_light_candidate_runs_away) {
  static model a;
  const double w = 0x1p-40;
  set_model(&a, 2, 2);
  for (int k = 0; k < 2; k++) {
    a.mu[k] = 1;
    a.W[5 * k] = 1;
    for (int l = 0; l < 2; l++) /* C3 */
      a.W[10 + l + 4 * k] = w;
  }
  a.q[0] = -1;
  a.q[2] = -2;
  const dls_augmented_settings s = augmented_tol(1e-8);
  dls_augmented *work = new_augmented(&a.p, &s);
  double r[4];
  dls_info info;
  ck_assert_int_eq(solve_augmented(work, &a.p, &s, r, NULL, &info), DLS_STALLED);
  const double *delta = dlsi_augmented_direction(work);
  ck_assert_ptr_nonnull(delta);
  for (int k = 0; k < 4; k++)
    ck_assert_double_eq_tol(delta[k], k < 2 ? 0 : 5 - 2 * k, 1e-3);
  dls_augmented_destroy(work);
}

/* (AU5) by hand: two candidates that press each other, W = (1 -1; -1 1), q = (-1, -1), run away
 * along (1, 1), whose gain is -2. A third, free one of w = 2^-20 counts as q_3 2^10 in |q|: the
 * gain is too small where 1e-4 sqrt(2) sqrt(2 + (2^10 q_3)^2) > 2, from q_3 = 13.81 on. */
TEST(gain_of_a_direction) {
  static model a;
  static const double q3[] = {0.5, 13.7, 13.9, 100};
  for (int k = 0; k < 4; k++)
    for (int last = 0; last < 2; last++) {
      const int i = last ? 2 : 0, j = last ? 0 : 1, l = last ? 1 : 2; /* l: the free one */
      set_model(&a, 1, 3);
      a.W[i + 3 * i] = a.W[j + 3 * j] = 1;
      a.W[i + 3 * j] = a.W[j + 3 * i] = -1;
      a.W[l + 3 * l] = 0x1p-20;
      a.q[i] = a.q[j] = -1;
      a.q[l] = q3[k];
      const dls_augmented_settings s = augmented_tol(1e-12);
      double r[3];
      dls_info info;
      dls_augmented *work = new_augmented(&a.p, &s);
      const dls_status status = solve_augmented(work, &a.p, &s, r, NULL, &info);
      const double *direction = dlsi_augmented_direction(work);
      ck_assert_int_eq(status, DLS_STALLED);
      ck_assert_int_eq(direction != NULL, k < 2);
      for (int c = 0; direction && c < 3; c++)
        ck_assert_double_eq_tol(direction[c], c != l, 1e-6);
      dls_augmented_destroy(work);
    }
}

/* data/failures: solved where the line of the file says so; else a direction along which the
 * reactions run away, or, where there is a solution, it may only say that it stands still. */
TEST(catalogue) {
  int problems;
  const failure *f = contact_failures(&problems);
  for (const failure *end = f + problems; f < end; f++) {
    const dls_contact p = failure_contact(f);
    const dls_augmented_settings s = augmented_tol(1e-10);
    dls_augmented *work = new_augmented(&p, &s);
    double r[FAILURE_N];
    dls_info info;
    const dls_status status = solve_augmented(work, &p, &s, r, NULL, &info);
    const int solves = failure_says(f, "augmented-lagrangian", DLS_OK);
    ck_assert_msg(status == (solves ? DLS_OK : DLS_STALLED), "%s: %s", f->name,
                  dls_status_name(status));
    if (f->none || solves) ck_assert_int_eq(dlsi_augmented_direction(work) != NULL, f->none);
    dls_augmented_destroy(work);
  }
  ck_assert_int_ge(problems, 27);
}

/* C4 with springs too stiff for (A2), and none softer to try; and where they may soften */
TEST(too_stiff) {
  static model a;
  set_hand(&a, &jammed[2]);
  dls_augmented_settings s = augmented_tol(1e-8);
  s.adaptive = 0;
  s.factor = 1e9;
  dls_augmented *work = new_augmented(&a.p, &s);
  double r[4];
  dls_info info;
  ck_assert_int_eq(solve_augmented(work, &a.p, &s, r, NULL, &info), DLS_STALLED);
  ck_assert_int_eq(info.iterations, 1);
  ck_assert_ptr_null(dlsi_augmented_direction(work));
  dls_augmented_destroy(work);
  s.adaptive = 1;
  work = new_augmented(&a.p, &s);
  ck_assert_int_eq(solve_augmented(work, &a.p, &s, r, NULL, &info), DLS_STALLED);
  ck_assert_int_gt(info.iterations, 1);
  ck_assert_ptr_nonnull(dlsi_augmented_direction(work));
  dls_augmented_destroy(work);
}

/* ---- random ---------------------------------------------------------------------------------- */

TEST_EACH(rank_deficient, 0, 24) {
  static model a;
  deficient_model(&a, _i);
  const dls_augmented_settings s = augmented_tol(1e-12);
  double r[most];
  dls_info info;
  ck_assert_int_eq(solve_once(&a.p, &s, r, NULL, &info), DLS_OK);
}

TEST_EACH(units, 0, 12) {
  static model a, b;
  if (_i % 2)
    deficient_model(&a, _i);
  else
    numbered_model(&a, _i);
  dls_augmented_settings s = augmented_tol(1e-10);
  expect_any_units(&the_augmented, &a, &s, 1e-10, 0);
  expect_any_units(&the_augmented, &a, &s, 1e-10, 1);

  /* penalties have a unit */
  double r[most], eps[most], eps2[most];
  dls_info info, info2;
  for (int c = 0; c < a.p.nc; c++)
    eps[c] = 100 + 50 * uniform();
  s.penalty = eps;
  ck_assert_int_eq(solve_once(&a.p, &s, r, NULL, &info), DLS_OK);
  s.penalty = eps2;
  for (int length = -9; length <= 9; length += 9)
    for (int force = -9; force <= 9; force += 9) {
      const double al = pow(10, length), be = pow(10, force);
      scale_model(&b, &a, al, be);
      for (int c = 0; c < a.p.nc; c++)
        eps2[c] = eps[c] * (be / al);
      ck_assert_int_eq(solve_once(&b.p, &s, r, NULL, &info2), DLS_OK);
      ck_assert_int_eq(info2.iterations, info.iterations);
      ck_assert_int_eq(info2.factorisations, info.factorisations);
    }
}

TEST(smaller_problem) { /* both come to Newton's method */
  static model a, b;
  deficient_model(&a, 11);
  deficient_model(&b, 5);
  const dls_augmented_settings s = augmented_tol(1e-10);
  double r[most];
  dls_info info;
  ck_assert_int_eq(solve_once(&a.p, &s, r, NULL, &info), DLS_OK);
  ck_assert_int_gt(info.factorisations, 0);
  expect_reuse(&the_augmented, &a, &b);
}

/* A chain of candidates by blocks with more unknowns than are factorised dense, pressed and pushed:
 * as announced to create nothing is allocated, not announced the same bits. Sparse and dense
 * agree. */
TEST(storage) {
  enum { nc = 200, m = 2 * nc };
  static double x[12 * nc], W[m * m], q[m], mu[nc], r[3][m];
  static int p[nc + 1], i[3 * nc];
  int k = 0;
  for (int b = 0; b < nc; b++) {
    for (int a = b - 1; a <= b + 1; a++) {
      if (a < 0 || a >= nc) continue;
      const double block[4] = {a == b ? 1 : .49, .1 * (a - b), .1 * (b - a), a == b ? 1 : .49};
      memcpy(x + 4 * k, block, sizeof block);
      i[k++] = a;
      for (int e = 0; e < 4; e++)
        W[2 * a + e % 2 + m * (2 * b + e / 2)] = block[e];
    }
    p[b + 1] = k;
    q[2 * b] = -1 + .2 * sin(b);
    q[2 * b + 1] = .3 * cos(3 * b);
    mu[b] = 1;
  }
  const dls_contact dense = {.d = 2, .nc = nc, .W = {m, m, m, W}, .q = q, .mu = mu};
  const dls_contact blocks = {.d = 2, .nc = nc, .Wb = {2, nc, p, i, x}, .q = q, .mu = mu};
  const double entries = 4. * k + m;
  for (int way = 0; way < 3; way++) { /* dense; by blocks, announced; not announced */
    dls_augmented_settings s = augmented_tol(1e-12);
    s.limits.blocks = way == 1 ? k : 0;
    const double matrix =
        way == 1 && WITH_MUMPS ? 8. * 250 * 250 + (16. + 3 * sizeof(int)) * entries : 8. * m * m;
    expect_memory(&the_augmented, 2, nc, &s, matrix, 8. * 60 * m + 16384);
    dls_augmented *work = new_augmented(&dense, &s);
    dls_info info;
    malloc_fails_at(0);
    const dls_status status =
        dls_augmented_solve(work, way ? &blocks : &dense, r[way], NULL, &info, NULL);
    const long calls = malloc_calls();
    ck_assert(status == DLS_OK && info.factorisations > 0);
    ck_assert_int_eq(calls > 0, way == 2 && WITH_MUMPS);
    dls_augmented_destroy(work);
  }
  ck_assert_mem_eq(r[1], r[2], sizeof r[1]);
  for (int e = 0; e < m; e++) /* |W^-1| < 60, |q| < 20 */
    ck_assert(fabs(r[0][e] - r[1][e]) <= 1e-9);
}

TEST(cancelled) {
  static model a;
  numbered_model(&a, 18);
  for (int cancel_at = 0; cancel_at < 3; cancel_at++) {
    watch w = {"augmented-lagrangian", 400, INFINITY, 0, cancel_at};
    dls_augmented_settings s = augmented_tol(1e-12);
    s.limits.progress = look;
    s.limits.progress_data = &w;
    double r[most];
    dls_info info;
    ck_assert_int_eq(solve_once(&a.p, &s, r, NULL, &info), cancel_at ? DLS_CANCELLED : DLS_OK);
    ck_assert_int_eq(info.iterations, w.calls);
    ck_assert(cancel_at == 0 || w.calls == cancel_at);
    ck_assert(info.certificate.residual == w.least); /* the best of them */
  }
}

/* ---- the front door -------------------------------------------------------------------------- */

TEST_EACH(by_name, 0, 20) {
  static model a;
  numbered_model(&a, _i);
  if (a.p.nc < 2) return;
  dls_solver_settings s = settings_with(DLS_AUTO, default_tol);
  double r[most], r2[most], u[most];
  dls_info info;
  ck_assert_int_eq(dls_method_find("augmented-lagrangian", &s.method), 1);
  ck_assert_int_eq(s.method, DLS_AUGMENTED_LAGRANGIAN);
  s.limits.tol = 1e-12;
  ck_assert_int_eq(dls_solve(&a.p, &s, r, NULL, &info, NULL), DLS_OK);
  ck_assert_int_eq(info.method, DLS_AUGMENTED_LAGRANGIAN);

  /* the penalty method has an error, says so, and is as good as its certificate */
  ck_assert_int_eq(dls_method_find("penalty", &s.method), 1);
  ck_assert_int_eq(s.method, DLS_PENALTY);
  ck_assert_int_eq(dls_solve(&a.p, &s, r2, u, &info, NULL), DLS_MAX_ITERATIONS);
  ck_assert(info.method == DLS_PENALTY && info.status == DLS_MAX_ITERATIONS);
  ck_assert(info.iterations == 1);
  ck_assert(info.certificate.residual > 1e-12 && info.certificate.residual < 1e-4);
  for (int k = 0; k < a.p.d * a.p.nc; k++)
    if (k % a.p.d == 0) ck_assert(u[k] <= 0 || r2[k] == 0); /* springs are pressed in */
  s.limits.tol = 1e-4;
  ck_assert_int_eq(dls_solve(&a.p, &s, r2, NULL, &info, NULL), DLS_OK);
}

/* ---- bad input ------------------------------------------------------------------------------- */

/* The wedge that jams, c03 of data/failures: what one augmentation sees is told, and believed only
 * when others see it again. */
TEST(direction_of_an_early_end) {
  const double W[4] = {1, 1, 1, 1}, q[2] = {-2, 0}, mu[1] = {2};
  const dls_contact p = {.d = 2, .nc = 1, .W = {2, 2, 2, W}, .q = q, .mu = mu};
  for (int k = 1; k <= 3; k++) {
    double r[2];
    dls_augmented *work;
    dls_augmented_settings s = augmented_tol(1e-8);
    s.limits.max_iterations = k;
    ck_assert_int_eq(dls_augmented_create(&work, 2, 1, &s, NULL), DLS_OK);
    ck_assert_int_eq(dls_augmented_solve(work, &p, r, NULL, NULL, NULL), DLS_MAX_ITERATIONS);
    const double *delta = dlsi_augmented_direction(work);
    ck_assert_int_eq(delta != NULL, k > 1); /* the first one fills the gap */
    if (delta) ck_assert(delta[0] == 1 && fabs(delta[1] + 1) < 1e-4);
    dls_augmented_destroy(work);
  }
}

TEST(bad_create) {
  expect_bad_create(&the_augmented);
  const dls_augmented_settings good = augmented_tol(1e-8);
  dls_augmented_settings s = good;
  refuses_to_create(&the_augmented, DLS_E_SIZE, "nc", -1, 3, INT_MAX / 3, &s); /* m^2 doubles */
  const double bad[] = {0, -1, NAN, INFINITY, 1e-320};
  for (int k = 0; k < 5; k++) {
    s = good;
    s.factor = bad[k];
    refuses_to_create(&the_augmented, DLS_E_ARGUMENT, "factor", -1, 2, 1, &s);
    const double penalty[] = {1, 1e300, bad[k]};
    s = good;
    s.penalty = penalty;
    refuses_to_create(&the_augmented, isfinite(bad[k]) ? DLS_E_ARGUMENT : DLS_E_NOT_FINITE,
                      "penalty", 2, 2, 3, &s);
  }
  const double least = 0x1.8p-1024,
               both[] = {least, least}; /* 1 / least is a number, 2 / least not */
  dls_augmented *work;
  s = good;
  s.factor = least;
  s.penalty = both;
  ck_assert_int_eq(dls_augmented_create(&work, 2, 2, &s, NULL), DLS_OK);
  dls_augmented_destroy(work);
  s = good;
  s.adaptive = -1;
  refuses_to_create(&the_augmented, DLS_E_ARGUMENT, "adaptive", -1, 2, 1, &s);
  ck_assert_ptr_null(dlsi_augmented_direction(NULL));
}

TEST(no_memory) { /* by the front door */
  dls_solver_settings front = settings_with(DLS_AUTO, default_tol);
  for (int penalty = 0; penalty < 2; penalty++) {
    dls_error error;
    dls_solver *solver;
    front.method = penalty ? DLS_PENALTY : DLS_AUGMENTED_LAGRANGIAN;
    MALLOCS_FAIL(dls_solver_create(&solver, 3, 10, &front, &error), !solver, DLS_OK, 2);
    dls_solver_destroy(solver);
  }
}
