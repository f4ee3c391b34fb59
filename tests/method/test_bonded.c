/* test_bonded.c: infinite friction, and outputs that overlap the problem. */
#include "delassus.h"
#include "made.h"
#include "run.h"

enum { most = 3 * 12 };

typedef struct random_problem {
  double W[most * most], q[most], mu[12];
  dls_contact p;
} random_problem;

static unsigned long long state_of_chance;

/* Returns a number in -1 .. 1. */
static double chance(void) {
  state_of_chance = state_of_chance * 6364136223846793005ull + 1442695040888963407ull;
  return ldexp((double)(state_of_chance >> 11), -52) - 1;
}

/* W = A A^T / m + 2 I; every second candidate is bonded, the others have mu = 0.3. */
static void fill(random_problem *a, int d, int nc, unsigned seed) {
  const int m = d * nc;
  static double A[most * most];
  state_of_chance = seed;
  for (int e = 0; e < m * m; e++)
    A[e] = chance();
  for (int i = 0; i < m; i++)
    for (int j = 0; j < m; j++) {
      double sum = i == j ? 2 : 0;
      for (int k = 0; k < m; k++)
        sum += A[i + k * m] * A[j + k * m] / m;
      a->W[i + j * m] = sum;
    }
  for (int i = 0; i < m; i++)
    a->q[i] = i % d ? 0.3 * chance() : chance() - 0.5;
  for (int c = 0; c < nc; c++)
    a->mu[c] = c % 2 ? 0.3 : INFINITY;
  a->p = (dls_contact){.d = d, .nc = nc, .W = {m, m, m, a->W}, .q = a->q, .mu = a->mu};
}

static dls_status solve(const dls_contact *p, dls_method method, double *r, double *u,
                        dls_info *info, dls_error *error) {
  dls_solver_settings settings = settings_with(method, 1e-10);
  return dls_solve(p, &settings, r, u, info, error);
}

static const dls_method able[] = {DLS_AUTO, DLS_NLGS, DLS_NEWTON, DLS_ADMM,
                                  DLS_AUGMENTED_LAGRANGIAN};

/* Each method that can gives the answer that meets the law: pressed and stuck, or r = 0. */
TEST_EACH(bonded_sticks_while_pressed, 0, 20) {
  const int d = _i % 2 ? 3 : 2, nc = 12, m = d * nc;
  static random_problem a;
  fill(&a, d, nc, (unsigned)_i + 1);
  double r[most], u[most], first[most];
  int pressed = 0;
  for (size_t k = 0; k < sizeof able / sizeof *able; k++) {
    dls_info info;
    dls_error error = {0};
    const dls_status status = solve(&a.p, able[k], r, u, &info, &error);
    ck_assert_msg(status == DLS_OK, "seed %d, %s: %s, residual %g %s", _i, dls_method_name(able[k]),
                  dls_status_text(status), info.certificate.residual, error.message);
    dls_contact_state state[12];
    ck_assert_int_eq(dls_contact_states(&a.p, r, u, state, NULL), DLS_OK);
    for (int c = 0; c < nc; c += 2) {
      const double *rc = r + d * c, *uc = u + d * c;
      ck_assert_int_ne(state[c], DLS_SLIP);
      pressed += state[c] == DLS_STICK;
      for (int i = 1; i < d; i++)
        ck_assert_double_le(fabs(state[c] == DLS_STICK ? uc[i] : rc[i]), 1e-8);
      ck_assert_double_ge(rc[0], -1e-8);
      ck_assert_double_ge(uc[0], -1e-8);
    }
    ck_assert(isfinite(info.certificate.cone_violation) &&
              isfinite(info.certificate.slip_direction));
    if (k == 0) memcpy(first, r, sizeof r);
    for (int i = 0; i < m; i++)
      ck_assert_msg(fabs(r[i] - first[i]) <= 1e-6, "seed %d, %s", _i, dls_method_name(able[k]));
  }
  ck_assert_int_gt(pressed, 0);
}

/* A friction that is large enough for none to slip has the same answer. */
TEST(as_a_large_friction) {
  static random_problem a;
  double r[most], large[most];
  fill(&a, 2, 4, 5);
  for (int c = 0; c < 4; c++)
    a.mu[c] = INFINITY;
  ck_assert_int_eq(solve(&a.p, DLS_AUTO, r, NULL, NULL, NULL), DLS_OK);
  for (int c = 0; c < 4; c++)
    a.mu[c] = 50;
  ck_assert_int_eq(solve(&a.p, DLS_AUTO, large, NULL, NULL, NULL), DLS_OK);
  assert_near(r, large, 8, 1e-8);
}

/* A wedge that jams (c03 of data/failures) beside two candidates apart, one of which is bonded: no
 * method of auto solves it, and nothing is denied, though Lemke's method, which sees a finite
 * friction, ends with a proof for that one. */
TEST_EACH(nothing_is_denied_beside_a_bond, 0, 3) {
  static random_problem a;
  double r[most];
  dls_info info;
  fill(&a, 2, 3, 1);
  memset(a.W, 0, sizeof a.W);
  for (int k = 0; k < 6; k++) {
    a.W[7 * k] = 1;
    a.q[k] = k % 2 ? 0 : -2;
    a.mu[k / 2] = 2;
  }
  const int wedge = _i == 0; /* its friction stays finite */
  a.W[14 * wedge + 1] = a.W[14 * wedge + 6] = 1;
  ck_assert_int_gt(solve(&a.p, DLS_AUTO, r, NULL, &info, NULL), DLS_STALLED);
  a.mu[_i] = INFINITY;
  ck_assert_int_eq(solve(&a.p, DLS_AUTO, r, NULL, &info, NULL), DLS_STALLED);
  int pivoted = 0;
  for (int k = 0; k < info.stages; k++)
    pivoted += info.stage[k].method == DLS_LEMKE;
  ck_assert_int_ge(pivoted, 1);
}

/* The others say so. */
TEST(methods_that_cannot) {
  static random_problem a;
  static const dls_method unable[] = {DLS_LEMKE, DLS_HOMOTOPY};
  double r[most], M[1];
  dls_error error;
  fill(&a, 2, 3, 1);
  a.mu[0] = 0.1;
  for (size_t k = 0; k < 2; k++) {
    ck_assert_int_eq(solve(&a.p, unable[k], r, NULL, NULL, &error), DLS_E_UNSUPPORTED);
    ck_assert_str_eq(error.argument, "mu");
    ck_assert_int_eq(error.index, 2);
  }
  ck_assert_int_eq(dls_contact_to_lcp(&a.p, NULL, M, 12, M, &error), DLS_E_UNSUPPORTED);
  ck_assert_int_eq(dls_fclib_write_local("/nowhere", &a.p, "", NULL, NULL, &error),
                   WITH_HDF5 ? DLS_E_NOT_FINITE : DLS_E_UNSUPPORTED);
  dls_solution_set found;
  dls_fold fold;
  ck_assert_int_eq(dls_contact_enumerate(&a.p, 1e-8, 1, r, NULL, NULL, &found, &error),
                   DLS_E_UNSUPPORTED);
  ck_assert(strcmp(error.argument, "mu") == 0 && error.index == 2);
  ck_assert_int_eq(dls_contact_fold(&a.p, &fold, NULL, NULL, NULL, NULL, &error),
                   DLS_E_UNSUPPORTED);
  ck_assert(strcmp(error.argument, "mu") == 0 && error.index == 2);
  a.mu[2] = NAN;
  ck_assert_int_eq(dls_contact_check(&a.p, &error), DLS_E_NOT_FINITE);
  ck_assert_int_eq(error.index, 2);
}

/* Every method refuses r and u on top of each other or of the problem, and touches neither. */
static int methods(void) {
  int count = 0;
  while (dls_method_name((dls_method)count))
    count++;
  return count;
}

TEST_EACH(overlaps, 0, methods()) {
  static random_problem a;
  double apart[most] = {0}, both[2 * most] = {0};
  dls_error error;
  const dls_method method = (dls_method)_i;
  fill(&a, 2, 4, 3);
  for (int c = 0; c < 4; c++)
    a.mu[c] = 0.3;
  const random_problem before = a;
  double *const wrong[][2] = {{a.q, NULL},      {a.W + 63, NULL}, {a.mu + 3, NULL},
                              {apart, a.q + 7}, {apart, a.W},     {apart, a.mu},
                              {both, both},     {both, both + 7}, {both + 7, both}};
  static const char *const named[] = {"r", "r", "r", "u", "u", "u", "r", "r", "r"};
  for (size_t k = 0; k < sizeof wrong / sizeof *wrong; k++) {
    ck_assert_int_eq(solve(&a.p, method, wrong[k][0], wrong[k][1], NULL, &error), DLS_E_ARGUMENT);
    ck_assert_msg(strcmp(error.argument, named[k]) == 0, "%zu: %s", k, error.message);
    ck_assert(strstr(error.message, "overlaps") != NULL);
  }
  ck_assert_int_eq(memcmp(before.W, a.W, sizeof a.W), 0);
  ck_assert_int_eq(memcmp(before.q, a.q, sizeof a.q), 0);
  dls_certificate c;
  ck_assert_int_eq(dls_contact_certify(&a.p, both, both + 7, &c, &error), DLS_E_ARGUMENT);
  ck_assert_int_eq(dls_contact_certify(&a.p, apart, a.q, &c, &error), DLS_E_ARGUMENT);
}

/* A lower triangle of K under DLS_LU, dense and sparse. */
TEST(triangles) {
  const double full[] = {3, 1, 1, 2}, lower[] = {3, 1, 0, 2}, upper[] = {3, 0, 1, 2};
  const int p[] = {0, 2, 4}, i[] = {0, 1, 0, 1};
  const double *const K[] = {full, lower, upper};
  for (int k = 0; k < 6; k++) {
    dls_error error = {0};
    dls_model model = {.d = 2, .n = 2, .factorization = DLS_LU};
    model.operator_kind = k < 3 ? DLS_STIFFNESS_DENSE : DLS_STIFFNESS_SPARSE;
    model.K = (dls_dense){2, 2, 2, K[k % 3]};
    model.Ks = (dls_sparse){2, 2, p, i, K[k % 3]};
    ck_assert_int_eq(dls_model_check(&model, &error), k % 3 == 1 ? DLS_E_ARGUMENT : DLS_OK);
    if (k % 3 == 1) ck_assert(strstr(error.message, "a lower triangle") != NULL);
    model.triangular = 1;
    ck_assert_int_eq(dls_model_check(&model, &error), DLS_OK);
  }
}
