/* test_apart.c: candidates that provably cannot touch, which auto leaves out. */
#include "auto/auto.h"
#include "delassus/solve.h"
#include "made.h"
#include "run.h"

enum { count = 40, most = 3 * count };

static double W[most * most], q[most], mu[count];

/* A row of candidates on an elastic body: W_nn = W_tt = 1 / (1 + distance), W_nt = -W_tn = `skew`
 * of that times the sign of the distance. The middle is pressed, the others are far. */
static dls_contact row(int d, double skew) {
  const int m = d * count;
  memset(W, 0, sizeof W);
  for (int c = 0; c < count; c++) {
    for (int e = 0; e < count; e++)
      for (int i = 0; i < d; i++)
        for (int j = 0; j < d; j++) {
          const double far = 1. / (1 + abs(c - e)), sign = c > e ? 1 : c < e ? -1 : 0;
          const double across = i == 0 ? skew * sign : j == 0 ? -skew * sign : 0;
          W[d * c + i + m * (d * e + j)] = far * (i == j ? 1 : i + j == 1 ? across : 0);
        }
    const double x = (c - 19.5) / 20;
    q[d * c] = -0.1 + x * x;
    for (int i = 1; i < d; i++)
      q[d * c + i] = 0.05;
    mu[c] = 0.5;
  }
  return (dls_contact){.d = d, .nc = count, .W = {m, m, m, W}, .q = q, .mu = mu};
}

/* Returns how many may touch; list: count. */
static int touching(const dls_contact *p, int *list) {
  int *made;
  const int n = dlsi_list_touching(p, &made);
  ck_assert((n > 0) == (made != NULL));
  for (int k = 0; k < n; k++)
    list[k] = made[k];
  free(made);
  return n;
}

/* What has q_n <= 0 may touch; the rest is left out, but for a coupling that friction could use. */
TEST_EACH(proofs, 1, 4) {
  int list[count];
  const int d = _i;
  dls_contact p = row(d, d > 1 ? 0.3 : 0);
  const int n = touching(&p, list);
  ck_assert_int_eq(n, 12);
  for (int k = 0; k < n; k++)
    ck_assert_int_eq(list[k], 14 + k);
  if (d > 1) {
    p = row(d, 2.1); /* mu |W_nt| > W_nn */
    ck_assert_int_eq(touching(&p, list), 0);
    p = row(d, 0);
    for (int c = 0; c < count; c++)
      mu[c] = INFINITY;
    ck_assert_int_eq(touching(&p, list), 0);
  }
  p = row(d, 0);
  for (int c = 0; c < count; c++) /* candidate 20 pulls all others */
    W[d * c + d * count * (d * 20)] *= -1;
  ck_assert_int_eq(touching(&p, list), 0);
  p = row(d, 0);
  for (int c = 8; c < 32; c++)
    q[d * c] = -1;
  ck_assert_int_eq(touching(&p, list), 24);
  q[d * 32] = -1;
  ck_assert_int_eq(touching(&p, list), 0); /* the copy would not pay */
}

static int watch(void *data, const dls_progress *p) {
  int *calls = data;
  for (int c = 0; p->r && c < count; c++)
    if (c < 14 || c >= 26) ck_assert(p->r[3 * c] == 0);
  *calls += p->r != NULL;
  return 0;
}

/* auto finds the answer that sweeps over all candidates find; the caller sees all of r. */
TEST(answers) {
  const dls_contact p = row(3, 0.3);
  double r[most], s[most], u[most];
  int calls = 0;
  dls_info info;
  dls_solver_settings settings = settings_with(DLS_AUTO, 1e-10);
  settings.limits.progress = watch;
  settings.limits.progress_data = &calls;
  dls_solver *solver = solver_of(3, count, &settings);
  ck_assert_int_eq(dls_solver_solve(solver, &p, r, u, &info, NULL), DLS_OK);
  ck_assert_int_gt(calls, 1);
  const dls_certificate c = certificate_of(&p, r);
  ck_assert(dls_certificate_holds(&c, 1e-10));
  ck_assert_double_eq(c.residual, info.certificate.residual);
  for (int k = 0; k < count; k++) {
    if (k < 14 || k >= 26) ck_assert(r[3 * k] == 0 && u[3 * k] >= q[3 * k]);
  }
  ck_assert_ptr_null(dls_solver_direction(solver));
  memset(s, 0, sizeof s); /* warm: all candidates */
  dls_limits limits = {.tol = 1e-10, .warm_start = 1};
  ck_assert_int_eq(dls_solver_set_limits(solver, &limits, NULL), DLS_OK);
  ck_assert_int_eq(dls_solver_solve(solver, &p, s, NULL, NULL, NULL), DLS_OK);
  assert_near(r, s, most, 1e-8);
  dls_solver_destroy(solver);
}

/* The caller may end a solve on the copy; r is the best one, of all candidates. */
TEST(stops) {
  const dls_contact p = row(3, 0.3);
  double r[most];
  dls_info info;
  dls_solver_settings settings = settings_with(DLS_AUTO, 1e-12);
  settings.limits.max_iterations = 2;
  memset(r, 255, sizeof r);
  ck_assert_int_eq(dls_solve(&p, &settings, r, NULL, &info, NULL), DLS_MAX_ITERATIONS);
  ck_assert_int_eq(info.iterations, 2);
  for (int k = 0; k < count; k++)
    if (k < 14 || k >= 26) ck_assert(r[3 * k] == 0);
  ck_assert(r[3 * 19] > 0);
}

/* Without memory for the list or the copy the whole is solved. */
TEST(no_memory) {
  const dls_contact p = row(2, 0.3);
  double r[most];
  dls_solver_settings settings = settings_with(DLS_AUTO, default_tol);
  dls_solver *solver = solver_of(2, count, &settings);
  for (long k = 1; k <= 2; k++) {
    malloc_fails_at(k);
    const dls_status status = dls_solver_solve(solver, &p, r, NULL, NULL, NULL);
    ck_assert_int_eq(malloc_calls(), k);
    malloc_fails_at(0);
    ck_assert_int_eq(status, DLS_OK);
  }
  dls_solver_destroy(solver);
}

static int go_on(void *data, const dls_progress *progress) {
  (void)data;
  (void)progress;
  return 0;
}

/* The copy takes the caller's weights along, also while it shows r of all candidates. */
TEST_EACH(weights, 1, 4) {
  const int d = _i;
  static double given[2 * count], r[most], without[most];
  dls_contact p = row(d, d > 1 ? 0.3 : 0);
  for (int c = 0; c < count && d == 1; c++)
    mu[c] = 0;
  for (int c = 0; c < 2 * count; c++)
    given[c] = 1 + c % 3;
  dls_solver_settings settings = settings_with(DLS_AUTO, 1e-12);
  settings.limits.progress = go_on;
  dls_info info;
  ck_assert_int_eq(dls_solve(&p, &settings, without, NULL, &info, NULL), DLS_OK);
  p.weights = given;
  ck_assert_int_eq(dls_solve(&p, &settings, r, NULL, &info, NULL), DLS_OK);
  const dls_certificate certificate = certificate_of(&p, r);
  ck_assert(certificate.residual == info.certificate.residual);
  assert_near(r, without, d * count, 1e-10);
}
