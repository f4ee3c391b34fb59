/* test_pivoting.c: block principal pivoting and the enumeration of all solutions. */
#include "cases.h"
#include "delassus/pivoting.h"
#include "lcp_of.h"
#include "run.h"

/* ---- problems -------------------------------------------------------------------------------- */

static uint64_t state = 1;

static double centred(void) { /* in (-1, 1) */
  state = state * 6364136223846793005u + 1442695040888963407u;
  return (double)(state >> 11) / 4503599627370496.0 - 1;
}

/* M := B B^T / n + I / 10 (+ a skew part), q in (-1, 1): positive definite, so a P-matrix */
static dls_lcp random_lcp(int n, double skew, double *M, double *q) {
  gram_and_skew(n, centred, 0.1, skew, M, q);
  return lcp_of(n, M, q);
}

/* Murty: 1 on the diagonal, 2 above, q_i = -(2^i + ... + 2^n); z = (0, ..., 0, 2^n) */
static void murty(int n, double *M, double *q) {
  for (int j = 0; j < n; j++) {
    for (int i = 0; i < n; i++)
      M[i + n * j] = i == j ? 1 : i < j ? 2 : 0;
    q[j] = 0;
    for (int k = j + 1; k <= n; k++)
      q[j] -= ldexp(1, k);
  }
}

static dls_principal *workspace(int n, const dls_principal_settings *settings) {
  dls_principal_settings s;
  dls_principal_settings_init(&s);
  dls_principal *w;
  ck_assert_int_eq(dls_principal_create(&w, n, settings ? settings : &s, NULL), DLS_OK);
  return w;
}

static dls_principal_info
solve_principal(const dls_lcp *lcp, const dls_principal_settings *settings, double *z, double *y) {
  dls_principal *w = workspace(lcp->n, settings);
  dls_principal_info info;
  const dls_status status = dls_principal_solve(w, lcp, z, y, &info, NULL);
  ck_assert_int_eq(status, info.status);
  dls_principal_destroy(w);
  return info;
}

/* ---- block principal pivoting ---------------------------------------------------------------- */

TEST(solves_by_hand) {
  const double M[4] = {2, 1, 1, 2};
  const struct {
    double q[2], z[2];
    int factorizations;
  } spd[] = {
      {{-5, -6}, {4.0 / 3, 7.0 / 3}, 1}, /* both at once */
      {{1, -1}, {0, 0.5}, 1},
      {{-1, 0.25}, {0.5, 0}, 1},
      {{-4, -1}, {2, 0}, 2}, /* both, then z_1 = -2/3 leaves */
      {{1, 0}, {0, 0}, 0},
      {{0, 0}, {0, 0}, 0},
  };
  for (size_t k = 0; k < sizeof spd / sizeof spd[0]; k++) {
    double z[2], y[2];
    const dls_lcp lcp = lcp_of(2, M, spd[k].q);
    const dls_principal_info info = solve_principal(&lcp, NULL, z, y);
    ck_assert_int_eq(info.status, DLS_OK);
    ck_assert_int_eq(info.factorizations, spd[k].factorizations);
    for (int i = 0; i < 2; i++) {
      ck_assert_double_eq_tol(z[i], spd[k].z[i], 1e-15);
      ck_assert_double_eq_tol(y[i], spd[k].q[i] + M[i] * spd[k].z[0] + M[i + 2] * spd[k].z[1],
                              4e-15);
    }
  }
  const double N[4] = {1, 2, -1, 1}, q[2] = {-1, -1}; /* y = (z_0 - z_1 - 1, 2 z_0 + z_1 - 1) */
  double z[2];
  const dls_lcp lcp = lcp_of(2, N, q);
  ck_assert_int_eq(solve_principal(&lcp, NULL, z, NULL).status, DLS_OK);
  ck_assert(z[0] == 1 && z[1] == 0);
}

TEST(agrees_with_enumeration) {
  enum { n = 8 };
  for (int trial = 0; trial < 200; trial++) {
    double M[n * n], q[n], z[n], list[n * 4];
    const dls_lcp lcp = random_lcp(n, trial % 2 ? 1 : 0, M, q);
    dls_enumeration found;
    ck_assert_int_eq(dls_lcp_enumerate(&lcp, 0, 4, list, &found, NULL), DLS_OK); /* 4 floor */
    ck_assert_int_eq(found.solutions, 1);
    ck_assert_int_eq(found.singular_bases, 0);
    ck_assert_int_eq(solve_principal(&lcp, NULL, z, NULL).status, DLS_OK);
    assert_near(z, list, n, 1e-12);
  }
}

TEST(needs_few_factorisations) {
  enum { n = 150 };
  static double M[n * n], q[n], z[n], y[n];
  for (int trial = 0; trial < 6; trial++) {
    const dls_lcp lcp = random_lcp(n, trial % 2 ? 0.1 : 0, M, q);
    const dls_principal_info info = solve_principal(&lcp, NULL, z, y);
    ck_assert_int_eq(info.status, DLS_OK);
    ck_assert_int_eq(info.single_exchanges, 0);
    ck_assert_int_le(info.factorizations, 10);
    ck_assert_double_le(info.certificate.residual, 1e-13);
    double residual = 0; /* independently */
    for (int i = 0; i < n; i++) {
      double s = q[i];
      for (int j = 0; j < n; j++)
        s += M[i + n * j] * z[j];
      ck_assert_double_eq_tol(y[i], s, 1e-13);
      ck_assert_double_ge(z[i], 0);
      residual = fmax(residual, fabs(fmin(z[i], s)));
    }
    ck_assert_double_le(residual, 1e-13);
  }
}

/* q such that every fourth z_i = y_i = 0: rounding must not send those to and fro */
TEST(degenerate_answers) {
  enum { n = 60 };
  static double M[n * n], q[n], z[n], exact[n];
  for (int trial = 0; trial < 40; trial++) {
    (void)random_lcp(n, trial % 2 ? 0.3 : 0, M, q);
    for (int i = 0; i < n; i++)
      exact[i] = i % 2 ? 0 : 1 + centred();
    for (int i = 0; i < n; i++) {
      q[i] = i % 4 == 1 ? 1 + centred() : 0;
      for (int j = 0; j < n; j++)
        q[i] -= M[i + n * j] * exact[j];
    }
    const dls_lcp lcp = lcp_of(n, M, q);
    const dls_principal_info info = solve_principal(&lcp, NULL, z, NULL);
    ck_assert_int_eq(info.status, DLS_OK);
    ck_assert_int_eq(info.single_exchanges, 0);
    ck_assert_int_le(info.factorizations, 10);
    assert_near(z, exact, n, 1e-12);
  }
}

TEST(single_exchanges_end_where_block_exchanges_cycle) {
  const double unsymmetric[9] = {1, 0, 3, 3, 2, 1, -3, -1, 1}, p[3] = {1, 2, -4};
  const double symmetric[9] = {6, -3, 5, -3, 2, -2, 5, -2, 5}, q[3] = {4, -3, 1};
  const double answer[2][3] = {{1.1, 0, 0.7}, {0, 13.0 / 6, 2.0 / 3}};
  for (int k = 0; k < 2; k++) {
    const dls_lcp lcp = k ? lcp_of(3, symmetric, q) : lcp_of(3, unsymmetric, p);
    dls_principal_settings settings;
    dls_principal_settings_init(&settings);
    settings.block_steps = 1000000;
    settings.limits.max_iterations = 1000;
    double z[3];
    dls_principal_info info = solve_principal(&lcp, &settings, z, NULL);
    ck_assert_int_eq(info.status, DLS_MAX_ITERATIONS);
    ck_assert_int_eq(info.iterations, 1000);
    ck_assert_int_eq(info.single_exchanges, 0);
    ck_assert_double_gt(info.certificate.residual, 0.01);

    info = solve_principal(&lcp, NULL, z, NULL);
    ck_assert_int_eq(info.status, DLS_OK);
    ck_assert_int_ge(info.single_exchanges, 1);
    ck_assert_int_le(info.iterations, 20);
    for (int i = 0; i < 3; i++)
      ck_assert_double_eq_tol(z[i], answer[k][i], 1e-14);
  }
}

TEST(murty_family) {
  double M[100], q[10], z[10];
  for (int n = 2; n <= 10; n++) {
    murty(n, M, q);
    const dls_lcp lcp = lcp_of(n, M, q);
    dls_principal_settings settings;
    dls_principal_settings_init(&settings);
    ck_assert_int_eq(solve_principal(&lcp, &settings, z, NULL).iterations, n);
    ck_assert(z[n - 1] == ldexp(1, n) && z[0] == 0);
    settings.block_steps = 0;
    const dls_principal_info info = solve_principal(&lcp, &settings, z, NULL);
    ck_assert_int_eq(info.status, DLS_OK);
    ck_assert_int_eq(info.iterations, (1 << n) - 1);
    ck_assert_int_eq(info.single_exchanges, info.iterations);
    ck_assert(z[n - 1] == ldexp(1, n) && z[0] == 0);
  }
}

TEST(warm_start_gives_the_cold_answer) {
  enum { n = 40 };
  double M[n * n], q[n], cold[n], z[n];
  const dls_lcp lcp = random_lcp(n, 0, M, q);
  dls_principal_settings settings;
  dls_principal_settings_init(&settings);
  ck_assert_int_eq(solve_principal(&lcp, &settings, cold, NULL).status, DLS_OK);
  settings.limits.warm_start = 1;
  memcpy(z, cold, sizeof z);
  dls_principal_info info = solve_principal(&lcp, &settings, z, NULL);
  ck_assert_int_eq(info.status, DLS_OK);
  ck_assert_int_eq(info.iterations, 0);
  ck_assert_int_eq(info.factorizations, 1);
  ck_assert_mem_eq(z, cold, sizeof z);
  for (int i = 0; i < n; i++)
    z[i] = centred();
  info = solve_principal(&lcp, &settings, z, NULL);
  ck_assert_int_eq(info.status, DLS_OK);
  assert_near(z, cold, n, 1e-12);
}

TEST(units_do_not_matter) {
  enum { n = 30 };
  static double M[n * n], q[n], z[n], N[n * n], p[n], x[n];
  for (int k = 0; k < 2; k++) {
    const dls_lcp lcp = random_lcp(n, k ? 0.5 : 0, M, q);
    const dls_principal_info info = solve_principal(&lcp, NULL, z, NULL);
    ck_assert_int_eq(info.status, DLS_OK);
    const double factor[] = {1e-9, 1e-3, 1e3, 1e9};
    for (int f = 0; f < 4; f++)
      for (int l = 0; l < 4; l++) { /* z -> force z, y -> length y */
        const double force = factor[f], length = factor[l];
        scale_vector(N, M, length / force, n * n);
        scale_vector(p, q, length, n);
        const dls_lcp scaled = lcp_of(n, N, p);
        const dls_principal_info other = solve_principal(&scaled, NULL, x, NULL);
        ck_assert_int_eq(other.status, DLS_OK);
        ck_assert_int_eq(other.iterations, info.iterations);
        ck_assert_int_eq(other.factorizations, info.factorizations);
        for (int i = 0; i < n; i++)
          ck_assert_double_eq_tol(x[i] / force, z[i], 1e-12);
      }
  }
}

TEST(same_bits_twice) {
  enum { n = 50 };
  static double M[n * n], q[n], z[n], x[n];
  const dls_lcp lcp = random_lcp(n, 0.1, M, q);
  dls_principal *w = workspace(n + 7, NULL);
  ck_assert_int_eq(dls_principal_solve(w, &lcp, z, NULL, NULL, NULL), DLS_OK);
  const double small[1] = {2}, one[1] = {-1}; /* another problem in between */
  const dls_lcp other = lcp_of(1, small, one);
  ck_assert_int_eq(dls_principal_solve(w, &other, x, NULL, NULL, NULL), DLS_OK);
  ck_assert(x[0] == 0.5);
  malloc_fails_at(0);
  const dls_status status = dls_principal_solve(w, &lcp, x, NULL, NULL, NULL);
  const long calls = malloc_calls();
  ck_assert_int_eq(status, DLS_OK);
  ck_assert_int_eq(calls, 0);
  ck_assert_mem_eq(z, x, sizeof z);
  dls_principal_destroy(w);
}

TEST(leading_dimension_and_indices_outside) {
  double M[2 * 5] = {2, 1, NAN, NAN, NAN, 1, 2, NAN, NAN, NAN}, q[2] = {-5, -6}, z[2], list[4];
  const dls_lcp lcp = {.n = 2, .M = {2, 2, 5, M}, .q = q};
  dls_enumeration found;
  ck_assert_int_eq(solve_principal(&lcp, NULL, z, NULL).status, DLS_OK);
  ck_assert_int_eq(dls_lcp_enumerate(&lcp, 0, 2, list, &found, NULL), DLS_OK);
  ck_assert_int_eq(found.solutions, 1);
  for (int i = 0; i < 2; i++) {
    ck_assert_double_eq_tol(z[i], (4.0 + 3 * i) / 3, 1e-15);
    ck_assert_double_eq_tol(list[i], (4.0 + 3 * i) / 3, 1e-15);
  }
}

TEST(matrices_that_are_no_p_matrices) {
  const double ones[4] = {1, 1, 1, 1}, minus[2] = {-1, -1};
  double z[2], y[2];
  dls_lcp lcp = lcp_of(2, ones, minus);
  dls_principal_info info = solve_principal(&lcp, NULL, z, y); /* block step to a singular basis */
  ck_assert_int_eq(info.status, DLS_STALLED);
  ck_assert_int_eq(info.factorizations, 1);
  ck_assert(z[0] == 0 && z[1] == 0 && y[0] == -1);
  ck_assert_double_eq_tol(info.certificate.residual, 1, 1e-15);

  const double negative[1] = {-1}; /* y = -z - 1: no solution; the two bases alternate */
  lcp = lcp_of(1, negative, minus);
  info = solve_principal(&lcp, NULL, z, NULL);
  ck_assert_int_eq(info.status, DLS_MAX_ITERATIONS);
  ck_assert_int_eq(info.iterations, 1010);

  const double indefinite[4] = {1, 2, 2, 1}, q[2] = {-3, -3}; /* Cholesky fails, LU goes on */
  lcp = lcp_of(2, indefinite, q);
  info = solve_principal(&lcp, NULL, z, NULL);
  ck_assert_int_eq(info.status, DLS_OK);
  assert_near(z, (double[]){1, 1}, 2, 1e-15);
}

static int stop_at(void *data, const dls_progress *p) {
  int *calls = data;
  ck_assert_str_eq(p->method, "principal");
  if (p->last) return 0;
  ck_assert_int_eq(p->iteration, *calls);
  ck_assert_int_eq(p->max_iterations, 77);
  ck_assert_double_gt(p->residual, 0);
  return ++*calls == 3;
}

/* M = 4 I but for one entry, wherever it stands, and q = -M (1, 1, 1) end after a first basis of
 * all. M = I counts what is exchanged and factorised. */
TEST(counts_and_one_entry) {
  for (int j = 0; j < 3; j++)
    for (int i = 0; i < 3; i++) {
      double M[9] = {4, 0, 0, 0, 4, 0, 0, 0, 4}, q[3] = {-4, -4, -4}, z[3], y[3];
      M[i + 3 * j] += 2;
      q[i] -= 2;
      const dls_lcp lcp = {.n = 3, .M = {3, 3, 3, M}, .q = q};
      const dls_principal_info info = solve_principal(&lcp, NULL, z, y);
      ck_assert(info.status == DLS_OK && info.iterations == 1 && info.factorizations == 1);
      for (int l = 0; l < 3; l++)
        ck_assert(fabs(z[l] - 1) <= 2e-16 && fabs(y[l]) <= 2e-15);
    }
  static const double one[9] = {1, 0, 0, 0, 1, 0, 0, 0, 1}, q[2][3] = {{-1, 2, -3}, {1, 0, 3}};
  for (int single = 0; single < 2; single++)
    for (int k = 0; k < 2; k++) {
      double z[4] = {7, 7, 7, 7}, y[4] = {7, 7, 7, 7};
      const dls_lcp lcp = {.n = 3, .M = {3, 3, 3, one}, .q = q[k]};
      dls_principal_settings settings;
      dls_principal_settings_init(&settings);
      if (single) settings.block_steps = 0;
      const dls_principal_info info = solve_principal(&lcp, &settings, z, y);
      const int steps = k ? 0 : single ? 2 : 1;
      ck_assert(info.status == DLS_OK && info.iterations == steps);
      ck_assert(info.single_exchanges == single * steps && info.factorizations == steps);
      for (int l = 0; l < 3; l++)
        ck_assert(z[l] == fmax(-q[k][l], 0) && y[l] == fmax(q[k][l], 0));
      ck_assert(z[3] == 7 && y[3] == 7);
    }
}

/* The basis {0} of M = (1 0; .3 1), q = (-1, -.3 - eps / 4) has y_1 = -eps / 4, which is rounding
 * beside |q_1| + .3: no step from there. From no basis M = (1 -10; 0 1), q = (1, -1) goes to {1},
 * whose y_0 = -9 is worse than y_1 = -1 of z = 0: at a limit of one step that is the answer. */
TEST(rounding_and_the_best_basis) {
  static const double M[4] = {1, .3, 0, 1}, N[4] = {1, 0, -10, 1}, p[2] = {1, -1};
  const double q[2] = {-1, -nextafter(.3, 1)};
  const dls_lcp lcp = lcp_of(2, M, q), worse = lcp_of(2, N, p);
  dls_principal_settings settings;
  dls_principal_settings_init(&settings);
  settings.limits.warm_start = 1;
  double z[2] = {1, 0};
  dls_principal_info info = solve_principal(&lcp, &settings, z, NULL);
  ck_assert(info.status == DLS_OK && info.iterations == 0 && info.factorizations == 1);
  ck_assert(z[0] == 1 && z[1] == 0);
  const double seen[2] = {-1, -.3 - 64 * DBL_EPSILON}; /* no rounding: y_1 = -64 eps of 0.6 */
  const dls_lcp beyond = lcp_of(2, M, seen);
  info = solve_principal(&beyond, &settings, z, NULL);
  ck_assert(info.status == DLS_OK && info.iterations == 1 && z[1] > 0);
  settings.limits.warm_start = 0;
  for (int limit = 1; limit <= 2; limit++) {
    settings.limits.max_iterations = limit;
    info = solve_principal(&worse, &settings, z, NULL);
    ck_assert_int_eq(info.status, limit < 2 ? DLS_MAX_ITERATIONS : DLS_OK);
    ck_assert(info.iterations == limit && info.factorizations == limit);
    ck_assert(z[0] == (limit < 2 ? 0 : 9) && z[1] == (limit < 2 ? 0 : 1));
  }
}

static int keep_residual(void *data, const dls_progress *progress) {
  double *residual = data;
  if (!progress->last && *residual < 0) *residual = progress->residual;
  return 0;
}

/* M = I, q = (-1, 1/2): of no basis the negative part alone counts, 1 / |q|. */
TEST(residual_of_negative_parts) {
  static const double M[4] = {1, 0, 0, 1}, q[2] = {-1, 0.5};
  const dls_lcp lcp = lcp_of(2, M, q);
  dls_principal_settings settings;
  double z[2], residual = -1;
  dls_principal_settings_init(&settings);
  settings.limits.progress = keep_residual;
  settings.limits.progress_data = &residual;
  ck_assert_int_eq(solve_principal(&lcp, &settings, z, NULL).status, DLS_OK);
  ck_assert_double_eq_tol(residual, sqrt(0.8), 1e-15);
  ck_assert(z[0] == 1 && z[1] == 0);
}

TEST(progress_can_cancel) {
  double M[64], q[8], z[8];
  murty(8, M, q);
  const dls_lcp lcp = lcp_of(8, M, q);
  int calls = 0;
  dls_principal_settings settings;
  dls_principal_settings_init(&settings);
  settings.limits.max_iterations = 77;
  settings.limits.progress = stop_at;
  settings.limits.progress_data = &calls;
  const dls_principal_info info = solve_principal(&lcp, &settings, z, NULL);
  ck_assert_int_eq(info.status, DLS_CANCELLED);
  ck_assert_int_eq(info.iterations, 2);
  ck_assert_int_eq(calls, 3);
  dls_lcp_certificate c;
  ck_assert_int_eq(dls_lcp_certify(&lcp, z, NULL, &c, NULL), DLS_OK);
  ck_assert(c.residual == info.certificate.residual);
}

/* y = q, then z = (7, -2) / 3 with weights 2: |negative parts| / |q| is told, and z with it. */
static int watch_negative_parts(void *data, const dls_progress *progress) {
  int *calls = data;
  if (progress->last) return 0;
  const double residual[2] = {1, 4. / 3 / sqrt(17)}, z[2][2] = {{0, 0}, {7. / 3, -2. / 3}};
  ck_assert_int_lt(*calls, 2);
  ck_assert_int_eq(progress->iteration, *calls);
  ck_assert_double_eq_tol(progress->residual, residual[*calls], 1e-15);
  for (int i = 0; i < 2; i++)
    ck_assert_double_eq_tol(progress->r[i], z[*calls][i], 1e-15);
  ++*calls;
  return 0;
}

TEST(residual_of_a_basis) {
  const double M[4] = {2, 1, 1, 2}, q[2] = {-4, -1};
  const dls_lcp lcp = lcp_of(2, M, q);
  int calls = 0;
  double z[2];
  dls_principal_settings settings;
  dls_principal_settings_init(&settings);
  settings.limits.progress = watch_negative_parts;
  settings.limits.progress_data = &calls;
  const dls_principal_info info = solve_principal(&lcp, &settings, z, NULL);
  ck_assert(info.status == DLS_OK && info.iterations == 2 && info.single_exchanges == 0);
  ck_assert(calls == 2 && z[0] == 2 && z[1] == 0);
  /* one basis less: the better one of two, whose z_1 < 0 is cut */
  settings.limits.max_iterations = 1;
  calls = 0;
  ck_assert_int_eq(solve_principal(&lcp, &settings, z, NULL).status, DLS_MAX_ITERATIONS);
  ck_assert(calls == 2 && z[1] == 0);
  ck_assert_double_eq_tol(z[0], 7. / 3, 1e-15);
}

/* ---- enumeration ----------------------------------------------------------------------------- */

TEST(enumerates_by_hand) {
  double z[64];
  dls_enumeration found;
  const struct {
    double M, q;
    int solutions, singular, continua;
  } one[] = {
      {1, -2, 1, 0, 0}, {1, 2, 1, 0, 0},  {-1, 2, 2, 0, 0}, {-1, -2, 0, 0, 0},
      {0, 2, 1, 1, 0},  {0, -2, 0, 1, 0}, {0, 0, 1, 1, 1},
  };
  for (size_t k = 0; k < sizeof one / sizeof one[0]; k++) {
    const dls_lcp lcp = lcp_of(1, &one[k].M, &one[k].q);
    ck_assert_int_eq(dls_lcp_enumerate(&lcp, 1e-12, 9, z, &found, NULL), DLS_OK);
    ck_assert_int_eq(found.solutions, one[k].solutions);
    ck_assert_int_eq(found.singular_bases, one[k].singular);
    ck_assert_int_eq(found.continua, one[k].continua);
    ck_assert_int_eq(found.undetermined[0], one[k].continua);
  }
  /* z_0 + z_1 = 1 with z_2 = 2 fixed: a segment */
  const double M[9] = {1, 1, 0, 1, 1, 0, 0, 0, 1}, q[3] = {-1, -1, -2};
  const dls_lcp lcp = lcp_of(3, M, q);
  ck_assert_int_eq(dls_lcp_enumerate(&lcp, 1e-12, 9, z, &found, NULL), DLS_OK);
  ck_assert_int_eq(found.solutions, 2);
  ck_assert_int_eq(found.singular_bases, 2);
  ck_assert_int_eq(found.continua, 1);
  ck_assert(found.undetermined[0] && found.undetermined[1] && !found.undetermined[2]);
  for (int k = 0; k < 2; k++) {
    ck_assert_double_eq_tol(z[3 * k] + z[3 * k + 1], 1, 1e-15);
    ck_assert_double_eq_tol(z[3 * k + 2], 2, 1e-15);
  }
}

/* M = -I, q = 1: every 0-1 vector is a solution. M: n x n, 0. */
static dls_lcp every_corner(int n, double *M, double *q) {
  for (int i = 0; i < n; i++) {
    M[i + n * i] = -1;
    q[i] = 1;
  }
  return lcp_of(n, M, q);
}

TEST(all_of_many_solutions_and_a_full_list) {
  enum { n = 8 };
  static double M[n * n], q[n], z[n << n];
  const dls_lcp lcp = every_corner(n, M, q);
  dls_enumeration found;
  malloc_fails_at(0);
  const dls_status status = dls_lcp_enumerate(&lcp, 0, 1 << n, z, &found, NULL);
  const long calls = malloc_calls();
  ck_assert_int_eq(status, DLS_OK);
  ck_assert_int_eq(calls, 0);
  ck_assert_int_eq(found.solutions, 1 << n);
  for (int k = 0; k < 1 << n; k++)
    for (int i = 0; i < n; i++)
      ck_assert(z[i + n * k] == (k >> i & 1));
  z[10 * n] = 99;
  ck_assert_int_eq(dls_lcp_enumerate(&lcp, 0, 10, z, &found, NULL), DLS_MAX_ITERATIONS);
  ck_assert_int_eq(found.solutions, 10);
  ck_assert(z[10 * n] == 99);
}

TEST(enumeration_takes_its_largest_size) {
  enum { n = DLS_ENUMERATE_MAX };
  double M[n * n] = {0}, q[n], z[3 * n];
  const dls_lcp lcp = every_corner(n, M, q); /* room for three */
  dls_enumeration found;
  ck_assert_int_eq(dls_lcp_enumerate(&lcp, 0, 3, z, &found, NULL), DLS_MAX_ITERATIONS);
  ck_assert_int_eq(found.solutions, 3);
  for (int k = 0; k < 3; k++)
    for (int i = 0; i < n; i++)
      ck_assert(z[i + n * k] == (k >> i & 1));
}

TEST(enumeration_does_not_see_units) {
  enum { n = 6 };
  double M[n * n], q[n], N[n * n], p[n], z[n * 64], x[n * 64];
  for (int trial = 0; trial < 20; trial++) {
    for (int i = 0; i < n * n; i++)
      M[i] = centred();
    for (int i = 0; i < n; i++) {
      q[i] = centred();
      if (trial % 2) M[i + n * (n - 1)] = M[i]; /* rank n - 1 */
    }
    dls_lcp lcp = lcp_of(n, M, q);
    dls_enumeration found, other;
    ck_assert_int_eq(dls_lcp_enumerate(&lcp, 1e-12, 64, z, &found, NULL), DLS_OK);
    for (int k = 0; k < 4; k++) {
      const double force = k % 2 ? 1e-9 : 1e9, length = k / 2 ? 1e-9 : 1e9;
      scale_vector(N, M, length / force, n * n);
      scale_vector(p, q, length, n);
      lcp = lcp_of(n, N, p);
      ck_assert_int_eq(dls_lcp_enumerate(&lcp, 1e-12, 64, x, &other, NULL), DLS_OK);
      ck_assert_mem_eq(&other, &found, sizeof found);
      for (int i = 0; i < n * found.solutions; i++)
        ck_assert(fabs(x[i] / force - z[i]) <= 1e-9 * fabs(z[i]));
    }
  }
}

/* ---- bad input ------------------------------------------------------------------------------- */

TEST(create_refuses) {
  dls_error e;
  dls_principal_settings good, s;
  dls_principal_settings_init(NULL);
  dls_principal_settings_init(&good);
  dls_principal *w;
  const char *const f = "dls_principal_create";
#define REFUSED(status, argument)                                                                  \
  do {                                                                                             \
    w = (dls_principal *)&e;                                                                       \
    expect_error(dls_principal_create(&w, 3, &s, &e), &e, status, f, argument, -1);                \
    ck_assert_ptr_null(w);                                                                         \
    ck_assert_int_eq(dls_principal_create(&w, 3, &s, NULL), status);                               \
    s = good;                                                                                      \
  } while (0)
  REFUSES(ARGUMENT, "out", -1, dls_principal_create, NULL, 3, &good);
  w = (dls_principal *)&e;
  REFUSES(SIZE, "n", -1, dls_principal_create, &w, 0, &good);
  ck_assert_ptr_null(w);
  ck_assert_int_eq(dls_principal_create(&w, 3, NULL, &e), DLS_OK); /* the defaults */
  dls_principal_destroy(w);
  memset(&s, 0, sizeof s);
  REFUSED(DLS_E_SETTINGS, "settings");
  s.limits.tol = -1;
  REFUSED(DLS_E_ARGUMENT, "tol");
  s.limits.tol = NAN;
  REFUSED(DLS_E_ARGUMENT, "tol");
  s.limits.tol = INFINITY;
  REFUSED(DLS_E_ARGUMENT, "tol");
  s.limits.max_iterations = -1;
  REFUSED(DLS_E_ARGUMENT, "max_iterations");
  s.block_steps = -1;
  REFUSED(DLS_E_ARGUMENT, "block_steps");
  s.limits.warm_start = 2;
  REFUSED(DLS_E_ARGUMENT, "warm_start");
#undef REFUSED
}

TEST(solve_refuses) {
  const char *const f = "dls_principal_solve";
  dls_error e;
  double M[4] = {2, 1, 1, 2}, q[2] = {-5, -6}, z[2] = {7, 8}, y[2] = {9, 10};
  dls_principal_info info, before;
  memset(&info, 42, sizeof info);
  before = info;
  dls_principal_settings settings;
  dls_principal_settings_init(&settings);
  settings.limits.warm_start = 1;
  dls_principal *w = workspace(2, &settings), *small = workspace(1, NULL);
  const dls_lcp good = lcp_of(2, M, q);
  dls_lcp bad = good;
#define REFUSED(workspace, lcp, status, argument, index)                                           \
  do {                                                                                             \
    expect_error(dls_principal_solve(workspace, lcp, z, y, &info, &e), &e, status, f, argument,    \
                 index);                                                                           \
    ck_assert(z[1] == 8 && y[0] == 9 && y[1] == 10);                                               \
    ck_assert_mem_eq(&info, &before, sizeof info);                                                 \
    bad = good;                                                                                    \
  } while (0)
  REFUSED(NULL, &good, DLS_E_ARGUMENT, "workspace", -1);
  REFUSED(w, NULL, DLS_E_ARGUMENT, "lcp", -1);
  REFUSED(small, &good, DLS_E_SIZE, "n", -1);
  bad.n = 0;
  REFUSED(w, &bad, DLS_E_SIZE, "n", -1);
  bad.M.a = NULL;
  REFUSED(w, &bad, DLS_E_ARGUMENT, "M", -1);
  bad.M.rows = 3;
  REFUSED(w, &bad, DLS_E_SIZE, "M", -1);
  bad.M.ld = 1;
  REFUSED(w, &bad, DLS_E_SIZE, "M", -1);
  bad.q = NULL;
  REFUSED(w, &bad, DLS_E_ARGUMENT, "q", -1);
  M[2] = NAN;
  REFUSED(w, &good, DLS_E_NOT_FINITE, "M", 2);
  M[2] = 1;
  q[1] = INFINITY;
  REFUSED(w, &good, DLS_E_NOT_FINITE, "q", 1);
  q[1] = -6;
  z[0] = NAN;
  REFUSED(w, &good, DLS_E_NOT_FINITE, "z", 0);
#undef REFUSED
  REFUSES(ARGUMENT, "z", -1, dls_principal_solve, w, &good, NULL, y, &info);
  ck_assert(y[0] == 9);
  dls_principal_destroy(w);
  dls_principal_destroy(small);
  dls_principal_destroy(NULL);
}

TEST(enumerate_refuses) {
  const char *const f = "dls_lcp_enumerate";
  static double large[21 * 21];
  dls_error e;
  double M[4] = {2, 1, 1, 2}, q[2] = {-5, -6}, z[4] = {7, 8, 9, 10};
  dls_enumeration found, before;
  memset(&found, 42, sizeof found);
  before = found;
  const dls_lcp good = lcp_of(2, M, q), too_large = lcp_of(21, large, large);
#define REFUSED(lcp, tol, capacity, status, argument, index)                                       \
  do {                                                                                             \
    expect_error(dls_lcp_enumerate(lcp, tol, capacity, z, &found, &e), &e, status, f, argument,    \
                 index);                                                                           \
    ck_assert(z[0] == 7 && z[1] == 8);                                                             \
    ck_assert_mem_eq(&found, &before, sizeof found);                                               \
  } while (0)
  REFUSED(NULL, 0, 2, DLS_E_ARGUMENT, "lcp", -1);
  REFUSED(&too_large, 0, 2, DLS_E_SIZE, "n", -1);
  REFUSED(&good, -1, 2, DLS_E_ARGUMENT, "tol", -1);
  REFUSED(&good, NAN, 2, DLS_E_ARGUMENT, "tol", -1);
  REFUSED(&good, INFINITY, 2, DLS_E_ARGUMENT, "tol", -1);
  REFUSED(&good, 0, 0, DLS_E_ARGUMENT, "capacity", -1);
  M[3] = -INFINITY;
  REFUSED(&good, 0, 2, DLS_E_NOT_FINITE, "M", 3);
  M[3] = 2;
  q[0] = NAN;
  REFUSED(&good, 0, 2, DLS_E_NOT_FINITE, "q", 0);
  q[0] = -5;
#undef REFUSED
  REFUSES(ARGUMENT, "z", -1, dls_lcp_enumerate, &good, 0, 2, NULL, &found);
  REFUSES(ARGUMENT, "found", -1, dls_lcp_enumerate, &good, 0, 2, z, NULL);
}

TEST(every_malloc_fails_in_turn) {
  dls_principal_settings settings;
  dls_principal_settings_init(&settings);
  dls_principal *w = NULL;
  dls_error e;
  int k = 1;
  for (;; k++) {
    malloc_fails_at(k);
    const dls_status status = dls_principal_create(&w, 5, &settings, &e);
    malloc_fails_at(0);
    if (status == DLS_OK) break;
    expect_error(status, &e, DLS_E_MEMORY, "dls_principal_create", "", -1);
    ck_assert_ptr_null(w);
  }
  ck_assert_int_eq(k, 2);
  dls_principal_destroy(w);
}
