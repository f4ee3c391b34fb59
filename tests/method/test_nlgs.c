/* test_nlgs.c: projected Gauss-Seidel, on problems solved by hand, on random ones, on bad input. */
#include "cases.h"
#include "delassus.h"
#include "doors.h"
#include "fclib_file.h"
#include "made.h"
#include "reduced.h"
#include "rigid.h"
#include "run.h"
#include "solids.h"
#include "vi/vi_internal.h"

/* ---- by hand --------------------------------------------------------------------------------- */

/* Says whether the local problems had several solutions: of these, in C16 alone. */
TEST_EACH(several_solutions_are_told, 0, hand_count) {
  static model a;
  set_hand(&a, &hand[_i]);
  const dls_nlgs_settings s = nlgs_tol(1e-14);
  const int is_c16 = strcmp(hand[_i].name, "C16") == 0;
  double r[4];
  dls_info info;
  if (run_nlgs(&a.p, &s, r, NULL, &info) != DLS_OK) return; /* cycles */
  ck_assert_int_eq(info.ambiguous, is_c16);
  for (int k = 0; is_c16 && k < 3; k++)
    ck_assert(fabs(r[k] - hand[_i].r[k]) <= 1e-11);
}

TEST(ambiguous) {
  static model a;
  set_hand(&a, &ambiguous_case);
  dls_nlgs_settings s = nlgs_tol(1e-12);
  double r[2] = {2, -3}, u[2];
  dls_info info;
  ck_assert_int_eq(run_nlgs(&a.p, &s, r, u, &info), DLS_OK);
  ck_assert(r[0] == 0 && r[1] == 0);
  ck_assert_int_eq(info.ambiguous, 1);
  s.limits.warm_start = 1; /* from the sticking solution: it is one, and stays */
  r[0] = 2;
  r[1] = -3;
  ck_assert_int_eq(run_nlgs(&a.p, &s, r, u, &info), DLS_OK);
  ck_assert(r[0] == 2 && r[1] == -3 && info.iterations == 0 && info.ambiguous == 1);
}

/* One candidate has nobody to wait for: a second sweep that changes nothing is the end. */
TEST_EACH(one_jammed_candidate_stalls, 0, jammed_count) {
  static model a;
  if (jammed[_i].nc > 1) return;
  set_hand(&a, &jammed[_i]);
  const dls_nlgs_settings s = nlgs_tol(1e-8);
  double r[4];
  dls_info info;
  ck_assert_int_eq(run_nlgs(&a.p, &s, r, NULL, &info), DLS_STALLED);
}

/* C11: W SPD, one solution, and yet the sweeps repeat without end */
TEST(cycle) {
  static model a;
  set_hand(&a, hand_named("C11"));
  for (int cancel = 0; cancel < 2; cancel++) {
    dls_nlgs_settings s = nlgs_tol(1e-8);
    watch w = {"nlgs", 500, INFINITY, 0, cancel ? 7 : 0};
    s.limits.max_iterations = 500;
    s.limits.progress = look;
    s.limits.progress_data = &w;
    double r[4], u[4];
    dls_info info;
    ck_assert_int_eq(run_nlgs(&a.p, &s, r, u, &info), cancel ? DLS_CANCELLED : DLS_MAX_ITERATIONS);
    ck_assert_int_eq(info.iterations, cancel ? 7 : 500);
    ck_assert_int_eq(w.calls, info.iterations);
    ck_assert(info.certificate.residual > 0.01);
    ck_assert(info.certificate.residual <= w.least * (1 + 1e-12)); /* the best of them all */
  }
}

/* ---- random ---------------------------------------------------------------------------------- */

TEST_EACH(relaxation_keeps_the_answer, 0, 80) {
  dls_nlgs_settings s = nlgs_tol(1e-12);
  s.relaxation = _i % 2 ? 1.2 : 0.7;
  expect_same_answer(&the_nlgs, _i / 2, &s);
}

/* ---- acceleration ---------------------------------------------------------------------------- */

static const dls_acceleration accelerations[] = {DLS_ACCELERATION_AITKEN, DLS_ACCELERATION_ANDERSON,
                                                 DLS_ACCELERATION_MOMENTUM};

static dls_nlgs_settings accelerated(double tol, dls_acceleration acceleration) {
  dls_nlgs_settings s = nlgs_tol(tol);
  s.acceleration = acceleration;
  return s;
}

TEST_EACH(accelerated_random_problem, 0, 40) {
  static model a;
  static block_storage B;
  numbered_model(&a, _i);
  const int m = a.p.d * a.p.nc;
  const double close = close_of(&a);
  double plain[most], r[most], r2[most];
  dls_info info, info2;
  const dls_nlgs_settings none = nlgs_tol(1e-12);
  ck_assert_int_eq(run_nlgs(&a.p, &none, plain, NULL, &info), DLS_OK);
  for (int k = 0; k < 3; k++) {
    dls_nlgs_settings s = accelerated(1e-12, accelerations[k]);
    ck_assert_int_eq(run_nlgs(&a.p, &s, r, NULL, &info), DLS_OK);
    assert_near(r, plain, m, close);

    /* again, and W by blocks: the same bits */
    ck_assert_int_eq(run_nlgs(&a.p, &s, r2, NULL, &info2), DLS_OK);
    ck_assert_mem_eq(r, r2, (size_t)m * sizeof *r);
    const dls_contact p = by_blocks(&a, &B);
    ck_assert_int_eq(run_nlgs(&p, &s, r2, NULL, &info2), DLS_OK);
    ck_assert_mem_eq(r, r2, (size_t)m * sizeof *r);
    ck_assert_int_eq(info.iterations, info2.iterations);

    /* from the answer: no sweep; from elsewhere, with other windows and relaxed: the same answer */
    s.limits.warm_start = 1;
    ck_assert_int_eq(run_nlgs(&a.p, &s, r2, NULL, &info2), DLS_OK);
    ck_assert_int_eq(info2.iterations, 0);
    for (int o = 0; o < 3; o++) {
      s.window = o ? 3 : 100;
      s.relaxation = o == 2 ? 0.8 : 1;
      for (int j = 0; j < m; j++)
        r2[j] = 5 * uniform();
      ck_assert_int_eq(run_nlgs(&a.p, &s, r2, NULL, &info2), DLS_OK);
      assert_near(r2, plain, m, close);
    }
  }
}

static const char *const files[] = {"Confeti-ex13-4contact-Fc3D-SBM",
                                    "FC2D_SliderCrankLagrangian00000",
                                    "FC3D_Example1",
                                    "GFC3D_Example0",
                                    "GFC3D_OneContact",
                                    "gfc2d_granularflowonwall_00069_00350"};

TEST_EACH(fclib_file, 0, sizeof files / sizeof files[0]) {
  dls_fclib *file = read_fclib_file(files[_i]);
  if (!file) return; /* built without HDF5 */
  dls_error error;
  dls_contact p;
  dls_reduction *reduction = NULL;
  if (dls_fclib_is_global(file)) {
    dls_model global;
    const double *f, *g, *mu;
    ck_assert_int_eq(dls_fclib_model(file, &global, &f, &g, &mu, &error), DLS_OK);
    ck_assert_int_eq(reduce_on_W(&reduction, &global, NULL, &error), DLS_OK);
    ck_assert_int_eq(dls_reduction_load(reduction, f, g, &error), DLS_OK);
    ck_assert_int_eq(dls_reduction_contact(reduction, mu, &p, &error), DLS_OK);
  } else
    ck_assert_int_eq(dls_fclib_contact(file, &p, &error), DLS_OK);
  for (int k = 0; k < 3; k++) {
    const dls_nlgs_settings s = accelerated(1e-12, accelerations[k]);
    double *r = calloc((size_t)p.d * (size_t)p.nc, sizeof *r);
    dls_nlgs *work;
    dls_info info;
    dls_certificate c;
    ck_assert_int_eq(dls_nlgs_create(&work, p.d, p.nc, &s, &error), DLS_OK);
    ck_assert_msg(dls_nlgs_solve(work, &p, r, NULL, &info, &error) == DLS_OK, "%s: %g", files[_i],
                  info.certificate.residual);
    ck_assert_int_eq(dls_contact_certify(&p, r, NULL, &c, &error), DLS_OK);
    ck_assert(dls_certificate_holds(&c, 1e-12));
    dls_nlgs_destroy(work);
    free(r);
  }
  dls_reduction_destroy(reduction);
  dls_fclib_destroy(file);
}

TEST(accelerated_cycle) { /* C11 again: solved or not, what is said is true, and it is the best */
  static model a;
  set_hand(&a, hand_named("C11"));
  for (int k = 0; k < 3; k++) {
    dls_nlgs_settings s = accelerated(1e-8, accelerations[k]);
    watch w = {"nlgs", 500, INFINITY, 0, 0};
    s.limits.max_iterations = 500;
    s.limits.progress = look;
    s.limits.progress_data = &w;
    double r[4], u[4];
    dls_info info;
    const dls_status status = run_nlgs(&a.p, &s, r, u, &info);
    ck_assert(status == DLS_OK || status == DLS_MAX_ITERATIONS);
    ck_assert_int_eq(w.calls, info.iterations - (status == DLS_OK));
    ck_assert(info.certificate.residual <= w.least * (1 + 1e-12));
  }
}

TEST_EACH(accelerated_units, 0, 40) {
  static model a;
  numbered_model(&a, _i);
  const dls_nlgs_settings s = accelerated(1e-10, accelerations[_i / 2 % 3]);
  expect_any_units(&the_nlgs, &a, &s, 1e-10, 0);
  expect_any_units(&the_nlgs, &a, &s, 1e-10, 1);
}

static int stop(void *data, const dls_progress *progress) {
  const int *at = data;
  return progress->iteration == *at;
}

/* Solves in a workspace that another problem left half-way, cancelled: to the same bits. */
TEST(accelerated_workspace) {
  static model a, b;
  slow_model(&a, 0);
  numbered_model(&b, 10);
  ck_assert(a.p.d == b.p.d && a.p.nc > b.p.nc);
  for (int k = 0; k < 3; k++) {
    int at = 0;
    dls_nlgs_settings s = accelerated(1e-12, accelerations[k]);
    s.limits.progress = stop;
    s.limits.progress_data = &at;
    double r[most], r2[most];
    dls_info info;
    ck_assert_int_eq(run_nlgs(&b.p, &s, r, NULL, &info), DLS_OK);
    dls_nlgs *work;
    ck_assert_int_eq(dls_nlgs_create(&work, 2, a.p.nc, &s, NULL), DLS_OK);
    malloc_fails_at(0);
    at = 7;
    const dls_status first = dls_nlgs_solve(work, &a.p, r2, NULL, &info, NULL);
    at = 0;
    const dls_status second = dls_nlgs_solve(work, &b.p, r2, NULL, NULL, NULL);
    const long calls = malloc_calls();
    ck_assert(first == DLS_CANCELLED && second == DLS_OK && calls == 0);
    ck_assert_int_eq(info.iterations, 7);
    ck_assert_mem_eq(r, r2, (size_t)(b.p.d * b.p.nc) * sizeof *r);
    dls_nlgs_destroy(work);
  }
}

/* ---- bad input ------------------------------------------------------------------------------- */

/* |F|^2 overflows where the residual is looked for: the search has to end. */
TEST(squares_beyond_numbers) {
  enum { nc = 60 };
  static int p[nc + 1], i[3 * nc];
  static double x[4 * 3 * nc], q[2 * nc], mu[nc], r[2 * nc];
  int count = 0;
  for (int c = 0; c < nc; c++) {
    p[c] = count;
    for (int b = c > 0 ? c - 1 : 0; b <= c + 1 && b < nc; b++, count++) {
      i[count] = b;
      x[4 * count] = x[4 * count + 3] = b == c ? 2e170 : -0.9999e170;
    }
    q[2 * c] = -1e170 * (1 + c % 3);
    mu[c] = 0.3;
  }
  p[nc] = count;
  const dls_contact problem = {.d = 2, .nc = nc, .Wb = {2, nc, p, i, x}, .q = q, .mu = mu};
  dls_solver_settings s = settings_with(DLS_NLGS, default_tol);
  s.acceleration = DLS_ACCELERATION_MOMENTUM;
  s.limits.max_iterations = 400;
  ck_assert_int_ge(dls_solve(&problem, &s, r, NULL, NULL, NULL), DLS_OK);
}

TEST(bad_create) {
  expect_bad_create(&the_nlgs);
  const dls_nlgs_settings good = nlgs_tol(1e-8);
  const double bad_relaxation[] = {0, 2, -1, NAN, INFINITY};
  for (int k = 0; k < 5; k++) {
    dls_nlgs_settings s = good;
    s.relaxation = bad_relaxation[k];
    refuses_to_create(&the_nlgs, DLS_E_ARGUMENT, "relaxation", -1, 2, 1, &s);
  }
  const int bad_window[] = {0, -1, 101, INT_MIN}, bad_acceleration[] = {-1, 4};
  for (int k = 0; k < 4; k++) {
    dls_nlgs_settings s = good;
    s.window = bad_window[k];
    refuses_to_create(&the_nlgs, DLS_E_ARGUMENT, "window", -1, 2, 1, &s);
  }
  for (int k = 0; k < 2; k++) {
    dls_nlgs_settings s = good;
    s.acceleration = (dls_acceleration)bad_acceleration[k];
    refuses_to_create(&the_nlgs, DLS_E_ARGUMENT, "acceleration", -1, 2, 1, &s);
  }
}

TEST(memory) { /* O(m), with Anderson O(window m) */
  for (int d = 2; d <= 3; d++)
    for (int nc = 10; nc <= 1000; nc *= 10)
      for (int window = 0; window <= 20; window += 10) {
        dls_nlgs_settings s = nlgs_tol(1e-8);
        const double m = d * nc;
        if (window) {
          s.acceleration = DLS_ACCELERATION_ANDERSON;
          s.window = window;
        }
        expect_memory(&the_nlgs, d, nc, &s, 8 * 3. * window * m,
                      8 * (40 * m + 4 * window * window) + 4096);
      }
}

/* Spheres that flow: twice as many plain sweeps as sweeps with momentum do not suffice, and auto
 * takes the latter. Where most of the residual is in few candidates, these are swept alone. */
TEST(momentum_on_a_packing) {
  rigid a;
  ck_assert_int_eq(rigid_create(&a, "packing-flow", 1200, 0.4, 2), 0);
  double *r = malloc((size_t)a.contact.d * (size_t)a.contact.nc * sizeof *r);
  dls_nlgs_settings s = accelerated(1e-6, DLS_ACCELERATION_MOMENTUM);
  dls_info info;
  s.limits.max_iterations = 3000;
  for (int plain = 0; plain < 2; plain++) {
    dls_nlgs *work;
    ck_assert_int_eq(dls_nlgs_create(&work, a.contact.d, a.contact.nc, &s, NULL), DLS_OK);
    const dls_status status = dls_nlgs_solve(work, &a.contact, r, NULL, &info, NULL);
    dls_nlgs_destroy(work);
    ck_assert_msg(status == (plain ? DLS_MAX_ITERATIONS : DLS_OK), "%d after %d, %g", (int)status,
                  info.iterations, info.certificate.residual);
    s.acceleration = DLS_ACCELERATION_NONE;
    s.limits.max_iterations = 2 * info.iterations;
  }
  dls_solver_settings any = settings_with(DLS_AUTO, 1e-6);
  ck_assert_int_eq(dls_solve(&a.contact, &any, r, NULL, &info, NULL), DLS_OK);
  ck_assert_int_eq(info.stage[0].method, DLS_NLGS);
  ck_assert_int_lt(info.stage[0].iterations, s.limits.max_iterations / 2);
  free(r);
  rigid_free(&a);
}

/* Where sweeps cycle or there is no solution, momentum ends, too, and says so. */
TEST_EACH(momentum_by_hand, 0, hand_count + jammed_count) {
  const hand_case *k = _i < hand_count ? &hand[_i] : &jammed[_i - hand_count];
  static model a;
  set_hand(&a, k);
  const dls_nlgs_settings s = accelerated(1e-12, DLS_ACCELERATION_MOMENTUM);
  double r[4];
  dls_info info;
  const dls_status status = run_nlgs(&a.p, &s, r, NULL, &info);
  ck_assert_int_ge(status, 0);
  ck_assert_int_eq(status == DLS_OK, dls_certificate_holds(&info.certificate, 1e-12));
  if (_i >= hand_count) ck_assert_int_ne(status, DLS_OK);
}

/* ---- several local solutions ----------------------------------------------------------------- */

/* Returns what dlsi_may_be_ambiguous says of one candidate, in units of W that do not matter. */
static int alone_may_be_ambiguous(int d, const double *W, double mu) {
  static const double q[3] = {-1};
  int said[3];
  for (int unit = -1; unit <= 1; unit++) {
    double V[9];
    for (int e = 0; e < d * d; e++)
      V[e] = ldexp(W[e], 40 * unit);
    const dls_contact p = {
        .d = d, .nc = 1, .W = {.rows = d, .cols = d, .ld = d, .a = V}, .q = q, .mu = &mu};
    said[unit + 1] = dlsi_may_be_ambiguous(&p);
  }
  ck_assert(said[0] == said[1] && said[2] == said[1]);
  return said[1];
}

/* The bound of one solution, by x = W_tt^-1 W_tn, s = W_nn - W_nt x, k^2 = s over the largest
 * eigenvalue of W_tt, h = |x|: h + k^2 / h if h < k, else 2 k. W_tt = 1, W_nt = 3: k = 4 for W_nn =
 * 25, 2 for 13. W_tt = (5 3; 3 5) of eigenvalues 8 and 2, W_nt = (11, 13): x = (1, 2), h = sqrt(5),
 * k = 2 for W_nn = 69, 3 for 109. */
TEST(bounds_of_one_solution) {
  static const struct {
    int d;
    double W[9], bound;
  } cases[] = {{2, {25, 3, 3, 1}, 3 + 16. / 3},
               {2, {13, -3, -3, 1}, 4},
               {3, {69, 11, 13, 11, 5, 3, 13, 3, 5}, 4},
               {3, {109, 11, 13, 11, 5, 3, 13, 3, 5}, 6.2609903369994111},
               {3, {109, -11, 13, -11, 5, -3, 13, -3, 5}, 6.2609903369994111}};
  for (int k = 0; k < 5; k++) {
    const int d = cases[k].d;
    const double *W = cases[k].W, mu = 0.99 * cases[k].bound;
    ck_assert_int_eq(alone_may_be_ambiguous(d, W, 0.9999 * mu), 0);
    ck_assert_int_eq(alone_may_be_ambiguous(d, W, 1.0001 * mu), 1);
    for (int j = 1; j < d; j++) /* each entry beside its transpose: 1e-9 s are rounding, s >= 4 */
      for (int i = 0; i < j; i++)
        for (int sign = -1; sign <= 1; sign += 2) {
          double V[9];
          memcpy(V, W, sizeof V);
          V[i + d * j] += sign * 1e-9;
          ck_assert_int_eq(alone_may_be_ambiguous(d, V, 1), 0);
          V[i + d * j] += sign * 2e-7;
          ck_assert_int_eq(alone_may_be_ambiguous(d, V, 1), 1);
        }
  }
  static const double one = 1, zero = 0, apart[4] = {2, 0, 0, 1}, soft[4] = {2, 0, 0, 0};
  static const double stiff[9] = {1, 0, 0, 0, 1, 3, 0, 3, 1}; /* W_tt has the eigenvalue -2 */
  static const double flat[4] = {9, 3, 3, 1}, round[9] = {2, 0, 0, 0, 1, 0, 0, 0, 1};
  ck_assert(!alone_may_be_ambiguous(1, &one, 7) && alone_may_be_ambiguous(1, &zero, 0));
  ck_assert(!alone_may_be_ambiguous(2, apart, 1e9) && !alone_may_be_ambiguous(3, round, 1e9));
  ck_assert(alone_may_be_ambiguous(2, soft, 0) && alone_may_be_ambiguous(2, flat, 0));
  ck_assert(alone_may_be_ambiguous(3, stiff, 0));
}

/* Three candidates apart from each other. The first: r_n = r_t = 1 is one of two solutions for mu =
 * 1, (2, 1) is told first, and none is for the mu of the second. The third is C1, sticking, which
 * may as well be free. */
TEST(other_solutions) {
  static model a;
  static const double W[3][4] = {{0, 1, 1, 0}, {2, 0, 0, 1}, {1, 1, 1, 2}};
  static const double r[6] = {1, 1, 1, 0, 2, -3}, u[6] = {0, -1, 0, 0.5, 0, 0};
  static const double other[6] = {2, 1, 1, 0, 0, 0}, mu[3] = {1, 0, 2};
  double s[7] = {7, 7, 7, 7, 7, 7, 7};
  set_model(&a, 2, 3);
  for (int c = 0; c < 3; c++) {
    a.mu[c] = mu[c];
    for (int e = 0; e < 4; e++)
      a.W[2 * c + e % 2 + 6 * (2 * c + e / 2)] = W[c][e];
  }
  ck_assert_int_eq(dlsi_count_ambiguous(&a.p, r, u, s), 2);
  for (int i = 0; i < 6; i++)
    ck_assert(s[i] == other[i]);
  ck_assert(s[6] == 7);
  ck_assert_int_eq(dlsi_count_ambiguous(&a.p, r, u, NULL), 2);
  ck_assert_int_eq(dlsi_may_be_ambiguous(&a.p), 1);
  a.p.nc = 1; /* C1 in 3D, from stick and from free */
  static const double V[9] = {1, 1, 0, 1, 2, 0, 0, 0, 1}, zero[3] = {0}, q[3] = {1, 4, 0};
  const double stick[3] = {2, -3, 0}, two = 2;
  const dls_contact p = {
      .d = 3, .nc = 1, .W = {.rows = 3, .cols = 3, .ld = 3, .a = V}, .q = q, .mu = &two};
  for (int k = 0; k < 2; k++) {
    ck_assert_int_eq(dlsi_count_ambiguous(&p, k ? stick : zero, k ? zero : q, s), 1);
    ck_assert(s[0] == 0 && s[1] == 0 && s[2] == 0);
  }
}

/* (NL3) with omega = 1/2: r of a candidate that leaves, W = 1, q = 1, halves from 2^-10 to 2^-51,
 * and is 0 where it no longer moves u = 1. r_t = mu r_n goes with it. */
TEST(relaxed_candidate_leaves) {
  for (int d = 1; d <= 3; d++)
    for (int k = 0; k <= (d > 1); k++) {
      static model a;
      double r[3] = {0x1p-10, k ? 0x1p-10 : 0, 0}, u[3];
      dls_info info;
      set_model(&a, d, 1);
      for (int i = 0; i < d; i++)
        a.W[i * (d + 1)] = 1;
      a.q[0] = 1;
      a.mu[0] = d > 1;
      dls_nlgs_settings s = nlgs_tol(1e-12);
      s.relaxation = 0.5;
      s.limits.warm_start = 1;
      ck_assert_int_eq(run_nlgs(&a.p, &s, r, u, &info), DLS_OK);
      ck_assert_int_eq(info.iterations, 42);
      for (int i = 0; i < d; i++)
        ck_assert(r[i] == 0 && u[i] == a.q[i]);
    }
}

/* As a step of auto, in an order of its own, or with momentum: of candidates apart from each other
 * one sweep solves all, if it visits each of them. */
TEST(stages_visit_all) {
  for (int stage = 1; stage <= 2; stage++)
    for (int d = 1; d <= 3; d++)
      for (int nc = 1; nc <= 7; nc++) {
        static model a;
        double r[3 * 7] = {0};
        void *work;
        dls_info info;
        set_model(&a, d, nc);
        for (int i = 0; i < d * nc; i++) {
          a.W[i * (d * nc + 1)] = 1;
          a.q[i] = i % d ? 0.25 : -1 - (i * 5 + 2) % 7;
          a.mu[i / d] = d > 1;
        }
        const dlsi_options options = {.limits = {.tol = 1e-12, .max_iterations = 1},
                                      .stage = stage};
        ck_assert_int_eq(dlsi_nlgs_method.create(&work, d, nc, &options, NULL), DLS_OK);
        ck_assert_int_eq(dlsi_nlgs_method.solve(work, &a.p, r, NULL, &info, NULL), DLS_OK);
        ck_assert_int_eq(info.iterations, 1);
        for (int i = 0; i < d * nc; i++)
          ck_assert(r[i] == -a.q[i]);
        dlsi_nlgs_method.destroy(work);
      }
}

/* ---- a cantilever ---------------------------------------------------------------------------- */

/* A cantilever of 40 x ny squares over the ground, each node of its lower side a contact. */
typedef struct beam {
  int ny;
  double gap, mu;
  double pressed[3]; /* downwards, at the upper nodes 13, 20 and 40 */
  double lifted;     /* upwards, at the upper node 26 */
  double top, end;   /* along: on each upper node; on all nodes of the free end together */
} beam;

/* Plain sweeps are slow here: |gamma|_1 is above 1e4, (AN4). On the last one accelerated sweeps are
 * taken back again and again, (NL7). */
static const beam beams[] = {{1, .05, 1, {0, 0, 4e-2}, 0, 0, 0},
                             {2, 0, .3, {0, 4e-2, 0}, 0, 0, 2e-2},
                             {2, 0, .1, {2e-2, 0, 2e-2}, 1.2e-2, 5e-4, 0}};

/* Solves a beam by Anderson's acceleration of sweeps, or by auto: r (80). */
static dls_status solve_beam(const beam *b, int automatic, double *r, dls_info *info) {
  enum { nx = 40 };
  static const int at[] = {13, 20, 40};
  const int ny = b->ny, up = (nx + 1) * ny;
  double mu[nx];
  solids S;
  solids_new(&S, 2, (nx + 1) * (ny + 1), nx);
  solids_block(&S, (int[]){nx, ny, 1}, 1);
  for (int k = 0; k < 2 * (ny + 1); k++)
    solids_spring(&S, (nx + 1) * (k / 2), k % 2, 1e3);
  for (int i = 0; i < 3; i++)
    S.f[2 * (at[i] + up) + 1] = -b->pressed[i];
  S.f[2 * (26 + up) + 1] = b->lifted;
  for (int i = 0; i <= nx; i++)
    S.f[2 * (i + up)] = b->top;
  for (int j = 0; j <= ny; j++)
    S.f[2 * (nx + (nx + 1) * j)] += b->end / (ny + 1);
  for (int i = 1; i <= nx; i++) {
    mu[i - 1] = b->mu;
    solids_contact(&S, i, -1, (double[]){0, 1}, b->gap);
  }
  dls_reduction *R;
  dls_contact p;
  ck_assert_int_eq(reduce_on_W(&R, solids_model(&S), NULL, NULL), DLS_OK);
  ck_assert_int_eq(dls_reduction_load(R, S.f, S.g, NULL), DLS_OK);
  ck_assert_int_eq(dls_reduction_contact(R, mu, &p, NULL), DLS_OK);
  dls_solver_settings s = settings_with(DLS_AUTO, default_tol);
  if (!automatic) {
    s.method = DLS_NLGS;
    s.acceleration = DLS_ACCELERATION_ANDERSON;
  }
  const dls_status status = dls_solve(&p, &s, r, NULL, info, NULL);
  dls_reduction_destroy(R);
  solids_free(&S);
  return status;
}

/* Anderson's acceleration takes a tenth of 10000 plain sweeps at most; r is that of auto. */
TEST_EACH(cantilever, 0, sizeof beams / sizeof beams[0]) {
  double r[80], other[80];
  dls_info info;
  if (!WITH_MUMPS) return;
  ck_assert_int_eq(solve_beam(&beams[_i], 0, r, &info), DLS_OK);
  ck_assert_int_le(info.iterations, 1000);
  ck_assert_int_eq(solve_beam(&beams[_i], 1, other, &info), DLS_OK);
  assert_near(r, other, 80, 1e-7);
}
