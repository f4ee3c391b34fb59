/* test_lemke.c: Lemke's method against closed forms, enumeration of all bases, and theory. */
#include "delassus.h"
#include "lcp/lcp_internal.h"
#include "lcp_of.h"
#include "made.h"
#include "run.h"

/* A rounded answer of a well-conditioned problem: a few units in the last place per pivot */
static const double rounding = 1e-13;

static uint64_t seed = 1;
static double fraction(void) { /* [0, 1) */
  seed = seed * 6364136223846793005U + 1442695040888963407U;
  return (double)(seed >> 11) * 0x1p-53;
}
static int integer(int low, int high) {
  return low + (int)(fraction() * (high - low + 1));
}

static dls_lemke_settings path_alone(void) {
  dls_lemke_settings settings;
  dls_lemke_settings_init(&settings);
  settings.crash = 0;
  return settings;
}

/* Solves with a workspace of its own, settings NULL: by the path alone; whatever is said must be
 * true. */
static dls_status solved(int n, const double *M, const double *q,
                         const dls_lemke_settings *settings, double *z, dls_lemke_info *info) {
  const dls_lcp lcp = lcp_of(n, M, q);
  const dls_lemke_settings path = path_alone();
  if (!settings) settings = &path;
  dls_lemke *w;
  dls_error error;
  dls_lcp_certificate certificate;
  double *y = malloc((size_t)n * sizeof *y), *v = malloc((size_t)n * sizeof *v);
  double *dz = malloc((size_t)n * sizeof *dz), *d = malloc((size_t)n * sizeof *d);
  ck_assert(y && v && dz && d);
  ck_assert_int_eq(dls_lemke_create(&w, n, settings, &error), DLS_OK);
  const dls_status status = dls_lemke_solve(w, &lcp, z, y, info, &error);
  ck_assert_int_ge(status, 0);
  ck_assert_int_eq(status, info->status);
  ck_assert_int_eq(dls_lcp_certify(&lcp, z, v, &certificate, &error), DLS_OK);
  ck_assert_double_eq(certificate.residual, info->certificate.residual);
  for (int i = 0; i < n; i++) {
    ck_assert_double_ge(z[i], 0);
    ck_assert_double_eq(v[i], y[i]);
  }
  if (status == DLS_OK)
    ck_assert(dls_lcp_certificate_holds(&certificate, settings->limits.tol));
  else
    ck_assert(!dls_lcp_certificate_holds(&certificate, settings->limits.tol));
  double z0, dz0, violation;
  if (status == DLS_RAY || status == DLS_NO_SOLUTION) {
    ck_assert_int_eq(dls_lemke_ray(w, v, &z0, dz, &dz0, d, &error), DLS_OK);
    ck_assert_int_eq(dls_lcp_check_ray(&lcp, d, v, z0, dz, dz0, &violation, &error), DLS_OK);
    ck_assert_double_le(violation, 1e-14 * (n + 10));
  } else
    ck_assert_int_eq(dls_lemke_ray(w, v, &z0, dz, &dz0, d, &error), DLS_E_ARGUMENT);
  if (status == DLS_NO_SOLUTION) {
    ck_assert_int_eq(dls_lemke_farkas(w, v, &error), DLS_OK);
    ck_assert_int_eq(dls_lcp_check_farkas(&lcp, v, &violation, &error), DLS_OK);
    ck_assert_double_le(violation, 1e-14 * (n + 10));
  } else
    ck_assert_int_eq(dls_lemke_farkas(w, v, &error), DLS_E_ARGUMENT);
  dls_lemke_destroy(w);
  free(y);
  free(v);
  free(dz);
  free(d);
  return status;
}

/* ---- the oracle: all 2^n bases --------------------------------------------------------------- */

enum { small = 8 };

/* Solves the k x k system A x = b in place by Gauss with full search of the column; 0 if
 * singular. */
static int gauss(int k, double *A, double *x) {
  for (int p = 0; p < k; p++) {
    int r = p;
    for (int i = p + 1; i < k; i++)
      if (fabs(A[i + small * p]) > fabs(A[r + small * p])) r = i;
    if (fabs(A[r + small * p]) < 1e-9) return 0;
    for (int j = 0; j < k; j++) {
      const double t = A[p + small * j];
      A[p + small * j] = A[r + small * j];
      A[r + small * j] = t;
    }
    const double t = x[p];
    x[p] = x[r];
    x[r] = t;
    for (int i = p + 1; i < k; i++) {
      const double f = A[i + small * p] / A[p + small * p];
      for (int j = p; j < k; j++)
        A[i + small * j] -= f * A[p + small * j];
      x[i] -= f * x[p];
    }
  }
  for (int p = k - 1; p >= 0; p--) {
    for (int j = p + 1; j < k; j++)
      x[p] -= A[p + small * j] * x[j];
    x[p] /= A[p + small * p];
  }
  return 1;
}

/* Number of complementary bases (regular ones) that are feasible to `slack`; z := the last. */
static int enumerate(int n, const double *M, const double *q, double slack, double *z) {
  int found = 0;
  for (int set = 0; set < 1 << n; set++) {
    double A[small * small], x[small], trial[small] = {0};
    int at[small], k = 0, good = 1;
    for (int i = 0; i < n; i++)
      if (set >> i & 1) at[k++] = i;
    for (int j = 0; j < k; j++) {
      for (int i = 0; i < k; i++)
        A[i + small * j] = M[at[i] + n * at[j]];
      x[j] = -q[at[j]];
    }
    if (!gauss(k, A, x)) continue;
    for (int j = 0; j < k; j++) {
      trial[at[j]] = x[j];
      good = good && x[j] >= -slack;
    }
    for (int i = 0; i < n && good; i++) {
      double y = q[i];
      for (int j = 0; j < n; j++)
        y += M[i + n * j] * trial[j];
      good = y >= -slack;
    }
    if (!good) continue;
    found++;
    memcpy(z, trial, (size_t)n * sizeof *z);
  }
  return found;
}

/* ---- by hand --------------------------------------------------------------------------------- */

TEST(size_one) {
  static const struct {
    double M, q, z;
    dls_status status;
  } cases[] = {{2, -4, 2, DLS_OK},          {2, 4, 0, DLS_OK},
               {-1, 1, 0, DLS_OK},          {0, 0, 0, DLS_OK},
               {0, 3, 0, DLS_OK},           {1e-300, -1e-300, 1, DLS_OK},
               {0, -1, 0, DLS_NO_SOLUTION}, {-1, -1, 0, DLS_NO_SOLUTION}};
  for (size_t k = 0; k < sizeof cases / sizeof cases[0]; k++) {
    dls_lemke_info info;
    double z[1];
    ck_assert_int_eq(solved(1, &cases[k].M, &cases[k].q, NULL, z, &info), cases[k].status);
    ck_assert_double_eq(z[0], cases[k].z);
  }
}

TEST(feasible_q_is_answered_at_once) {
  const double M[4] = {-1, 5, 2, 0}, q[2] = {0, 3};
  double z[2];
  dls_lemke_info info;
  ck_assert_int_eq(solved(2, M, q, NULL, z, &info), DLS_OK);
  ck_assert_int_eq(info.pivots, 0);
  ck_assert_double_eq(info.certificate.residual, 0);
  assert_near(z, (double[]){0, 0}, 2, 0);
}

TEST(size_two) {
  static const struct {
    double M[4], q[2], z[2];
    dls_status status;
  } cases[] = {
      {{2, 1, 1, 2}, {-5, -6}, {4.0 / 3, 7.0 / 3}, DLS_OK},
      {{1, 0, 0, 1}, {-1, 2}, {1, 0}, DLS_OK},
      {{0, 1, -1, 0}, {1, -1}, {1, 1}, DLS_OK},            /* skew: a matrix game */
      {{0, -1, 1, 0}, {-1, -2}, {0, 0}, DLS_NO_SOLUTION},  /* y_1 = -z_0 - 2 */
      {{1, 1, 1, 1}, {-1, -2}, {0, 2}, DLS_OK},            /* singular; y = (1, 0) */
      {{1, -1, -1, 1}, {1, -1}, {0, 1}, DLS_OK},           /* singular, z = (t, 1 + t) */
      {{1, -1, -1, 1}, {-1, -1}, {0, 0}, DLS_NO_SOLUTION}, /* y_0 + y_1 = -2 */
  };
  for (size_t k = 0; k < sizeof cases / sizeof cases[0]; k++) {
    dls_lemke_info info;
    double z[2];
    ck_assert_int_eq(solved(2, cases[k].M, cases[k].q, NULL, z, &info), cases[k].status);
    if (info.status != DLS_OK) continue;
    assert_near(z, (double[]){cases[k].z[0], cases[k].z[1]}, 2, 1e-15);
  }
}

TEST(nearly_impossible) {
  /* y_0 + y_1 = -2 + e z_1: no solution for e = 0; z = (1 + 2/e, 2/e) for e > 0, however small.
   * |M||z| = 8/e or so leaves 4 floor <= 1e-8 up to k = 20 */
  const double q[2] = {-1, -1};
  for (int k = 4; k <= 40; k += 4) {
    const double e = ldexp(1, -k), M[4] = {1, -1, -1, 1 + e};
    double z[2];
    dls_lemke_info info;
    ck_assert_int_eq(solved(2, M, q, NULL, z, &info), k <= 20 ? DLS_OK : DLS_STALLED);
    ck_assert_double_eq_tol(z[0] * e, 2 + e, 8 * 0x1p-52 / e);
    ck_assert_double_eq_tol(z[1] * e, 2, 8 * 0x1p-52 / e);
  }
}

TEST(catalogue_of_contact) {
  /* 2D contact problems with exact answers, r by hand or by rational enumeration */
  static const struct {
    int nc;
    double W[16], q[4], mu, r[4];
  } cases[] = {
      {1, {1, 1, 1, 1}, {-2, 0}, 0.5, {4, -2}}, /* jam, mu < 1: r = 2/(1-mu) (1, -mu) */
      {1, {1, -1, -1, 2}, {-1, -3}, 2, {5, 4}},
      {1, {2, -1, -1, 1}, {-1, 1}, 1, {1.0 / 3, -1.0 / 3}},
      {1, {2, -1, -1, 1}, {-1, 1}, 4, {1.0 / 6, -2.0 / 3}},
      {2,
       {1, 1, 0, -1, 1, 2, 1, -2, 0, 1, 3, 0, -1, -2, 0, 3},
       {-1, 1, -1, 0},
       1,
       {3, -3, 4.0 / 3, -1}},
      {2,
       {4, 1, 0, -1, 1, 1, -1, 0, 0, -1, 4, -1, -1, 0, -1, 1},
       {0, 1, -1, -1},
       2,
       {0.25, -0.5, 0.25, 0.5}},
      {2,
       {3, 0, -2, 0, 0, 2, 0, -1, -2, 0, 3, -2, 0, -1, -2, 3},
       {0, 0, -1, -2},
       1,
       {26, 16, 39, 32}},
      {2,
       {3, 0, -1, 1, 0, 3, -2, 1, -1, -2, 2, 0, 1, 1, 0, 4},
       {-2, 0, -2, -1},
       2,
       {34, 59, 77, -23}},
  };
  for (size_t k = 0; k < sizeof cases / sizeof cases[0]; k++) {
    const int nc = cases[k].nc, n = 3 * nc;
    const double mu[2] = {cases[k].mu, cases[k].mu};
    const dls_contact problem = {
        .d = 2, .nc = nc, .W = {2 * nc, 2 * nc, 2 * nc, cases[k].W}, .q = cases[k].q, .mu = mu};
    double M[36], q[6], z[6], r[4];
    dls_lemke_info info;
    ck_assert_int_eq(dls_contact_to_lcp(&problem, NULL, M, n, q, NULL), DLS_OK);
    ck_assert_int_eq(solved(n, M, q, NULL, z, &info), DLS_OK);
    ck_assert_int_eq(dls_contact_from_lcp(&problem, NULL, z, r, NULL), DLS_OK);
    for (int i = 0; i < 2 * nc; i++)
      ck_assert_double_eq_tol(r[i], cases[k].r[i], rounding * (1 + fabs(cases[k].r[i])));
    const dls_certificate certificate = certificate_of(&problem, r);
    ck_assert(dls_certificate_holds(&certificate, rounding));
  }
}

TEST(ray_of_large_friction) {
  /* mu > W_nn / W_nt: with d = 1 the 3 nc form ends in a ray, though r = (1, -2) is a solution */
  const double W[4] = {5, 2, 2, 1}, q[2] = {-1, 0}, mu[1] = {3}, ones[3] = {1, 1, 1};
  const dls_contact problem = {.d = 2, .nc = 1, .W = {2, 2, 2, W}, .q = q, .mu = mu};
  double M[9], ql[3], z[3];
  dls_lemke_settings settings = path_alone();
  dls_lemke_info info;
  settings.cover = ones;
  ck_assert_int_eq(dls_contact_to_lcp(&problem, NULL, M, 3, ql, NULL), DLS_OK);
  ck_assert_int_eq(solved(3, M, ql, &settings, z, &info), DLS_RAY); /* solved() checks the ray */
  ck_assert_int_eq(info.pivots, 1);
  /* with the default d: z = (r_n, phi_2, lambda_2) = (1, 1, 0) */
  ck_assert_int_eq(solved(3, M, ql, NULL, z, &info), DLS_OK);
  const double answer[3] = {1, 1, 0};
  assert_near(z, answer, 3, 1e-15);
}

TEST(bimatrix_game) {
  /* a ray at once for every d; but equilibria exist, so it must not be called impossible */
  const double M[16] = {0, 0, 10, 30, 0, 0, 20, 15, 10, 30, 0, 0, 20, 15, 0, 0};
  const double q[4] = {-1, -1, -1, -1};
  double z[4];
  dls_lemke_info info;
  ck_assert_int_eq(solved(4, M, q, NULL, z, &info), DLS_RAY);
  ck_assert_int_eq(enumerate(4, M, q, 1e-12, z) > 0, 1);
}

TEST(cycling_example) {
  /* Kostreva, Math. Programming 16 (1979) 127-130: pivoting rules cycle here; z = (1, 1, 1) / 3 */
  const double M[9] = {1, 0, 2, 2, 1, 0, 0, 2, 1}, q[3] = {-1, -1, -1}, ones[3] = {1, 1, 1};
  dls_lemke_settings settings = path_alone();
  dls_lemke_info info;
  double z[3];
  for (int own = 0; own < 2; own++) {
    settings.cover = own ? ones : NULL;
    ck_assert_int_eq(solved(3, M, q, &settings, z, &info), DLS_OK);
    for (int i = 0; i < 3; i++)
      ck_assert_double_eq_tol(z[i], 1.0 / 3, 4e-16);
  }
}

/* Small integers, q = -1: every row ties. Without (LE7) the path of problems 0 and 1 goes round,
 * without (LE8) that of 2 and 3. There are 2^n
 * complementary bases, and few more almost complementary ones. */
TEST_EACH(ties_that_cycle, 0, 4) {
  static const struct {
    int n, own; /* 1: with the cover 1 */
    double rows[25];
  } of[] = {
      {3, 0, {-1, -1, 1, 1, 0, 1, 1, 1, 0}},
      {3, 1, {-1, -1, 0, 2, 0, 2, -2, -2, -2}},
      {5, 1, {-1, -1, 0, -1, 1, -1, 1, -1, 0, 0, -1, -1, 0, 1, 0, -1, 1, 0, 0, -1, 1, -1, 1, 0, 0}},
      {5, 1, {-2, 1,  -1, -2, 1,  0, 2, 0,  0,  -2, -1, 1, -2,
              1,  -1, 0,  0,  -1, 0, 2, -1, -2, 0,  1,  2}}};
  const int n = of[_i].n;
  static const double ones[5] = {1, 1, 1, 1, 1}, q[5] = {-1, -1, -1, -1, -1};
  double M[25], z[5];
  for (int i = 0; i < n; i++)
    for (int j = 0; j < n; j++)
      M[i + n * j] = of[_i].rows[n * i + j];
  dls_lemke_settings settings = path_alone();
  settings.cover = of[_i].own ? ones : NULL;
  dls_lemke_info info;
  ck_assert_int_ne(solved(n, M, q, &settings, z, &info), DLS_MAX_ITERATIONS);
  ck_assert_int_le(info.pivots, 10 << n);
}

TEST(identical_rows) {
  /* all y equal: every ratio test is a tie of all rows */
  double M[36], q[6], z[6];
  dls_lemke_info info;
  for (int k = 0; k < 36; k++)
    M[k] = 1;
  for (int k = 0; k < 6; k++)
    q[k] = -3;
  ck_assert_int_eq(solved(6, M, q, NULL, z, &info), DLS_OK);
  double sum = 0;
  for (int k = 0; k < 6; k++)
    sum += z[k];
  ck_assert_double_eq_tol(sum, 3, 4e-16 * 6);
}

TEST(murty) {
  /* Murty's family: with d = 1, 2^n pivots; z_n-1 = .. the answer is found in the end */
  for (int n = 1; n <= 10; n++) {
    double M[100], q[10], z[10], ones[10];
    dls_lemke_settings settings = path_alone();
    dls_lemke_info info;
    settings.cover = ones;
    for (int i = 0; i < n; i++) {
      ones[i] = 1;
      q[i] = i == 0 ? -ldexp(1, n) : q[i - 1] - ldexp(1, n - i);
      for (int j = 0; j < n; j++)
        M[i + n * j] = i == j ? 1 : i > j ? 2 : 0;
    }
    ck_assert_int_eq(solved(n, M, q, &settings, z, &info), DLS_OK);
    ck_assert_int_eq(info.pivots, 1 << n);
    ck_assert_int_eq(info.refreshes, 0); /* whole numbers: every check of the table holds */
    ck_assert_double_eq(z[0], ldexp(1, n));
    for (int i = 1; i < n; i++)
      ck_assert_double_eq(z[i], 0);
  }
}

/* ---- against the oracle ---------------------------------------------------------------------- */

TEST(p_matrices) {
  for (int trial = 0; trial < 300; trial++) {
    const int n = integer(1, small);
    double M[small * small], q[small], z[small], expected[small];
    dls_lemke_info info;
    for (int i = 0; i < n; i++) { /* diagonal dominant by rows, unsymmetric: a P-matrix */
      double sum = 0;
      for (int j = 0; j < n; j++) {
        M[i + n * j] = fraction() - 0.5;
        if (j != i) sum += fabs(M[i + n * j]);
      }
      M[i + n * i] = sum + 0.1;
      q[i] = fraction() - 0.6;
    }
    ck_assert_int_eq(enumerate(n, M, q, 1e-12, expected), 1);
    dls_lemke_settings settings = path_alone();
    settings.crash = trial % 2;
    ck_assert_int_eq(solved(n, M, q, &settings, z, &info), DLS_OK);
    ck_assert(dls_lcp_certificate_holds(&info.certificate, 1e-14));
    for (int i = 0; i < n; i++)
      ck_assert_double_eq_tol(z[i], expected[i], rounding * (1 + fabs(expected[i])));
  }
}

/* Small integers: degenerate and singular at every turn. No claim may contradict the oracle. */
TEST(any_matrix) {
  int count[6] = {0};
  for (int trial = 0; trial < 3000; trial++) {
    const int n = integer(1, 6);
    double M[small * small], q[small], z[small], other[small];
    dls_lemke_info info;
    for (int k = 0; k < n * n; k++)
      M[k] = integer(-2, 2);
    for (int i = 0; i < n; i++)
      q[i] = integer(-2, 1);
    const dls_status status = solved(n, M, q, NULL, z, &info);
    ck_assert(status == DLS_OK || status == DLS_RAY || status == DLS_NO_SOLUTION);
    count[status]++;
    if (status == DLS_OK) ck_assert(dls_lcp_certificate_holds(&info.certificate, 1e-14));
    if (status == DLS_NO_SOLUTION) ck_assert_int_eq(enumerate(n, M, q, 1e-9, other), 0);
  }
  ck_assert_int_gt(count[DLS_OK], 0);
  ck_assert_int_gt(count[DLS_RAY], 0);
  ck_assert_int_gt(count[DLS_NO_SOLUTION], 0);
}

/* M positive semidefinite: a ray proves that there is no solution, so DLS_RAY is never right. */
TEST(semidefinite) {
  int count[6] = {0};
  for (int trial = 0; trial < 2000; trial++) {
    const int n = integer(2, small), rank = integer(0, n - 1);
    double A[small * small], M[small * small], q[small], z[small], other[small];
    dls_lemke_info info;
    for (int k = 0; k < rank * n; k++)
      A[k] = integer(-1, 1);
    for (int i = 0; i < n; i++)
      for (int j = 0; j < n; j++) {
        M[i + n * j] = i < j ? integer(-1, 1) : 0; /* + skew part */
        if (i > j) M[i + n * j] -= M[j + n * i];
      }
    for (int i = 0; i < n; i++)
      for (int j = 0; j < n; j++)
        for (int k = 0; k < rank; k++)
          M[i + n * j] += A[k + rank * i] * A[k + rank * j];
    /* the loop above filled M(i,j), i > j, before M(j,i) was known: make the skew part exact */
    for (int i = 0; i < n; i++)
      for (int j = 0; j < i; j++) {
        double symmetric = 0;
        for (int k = 0; k < rank; k++)
          symmetric += A[k + rank * i] * A[k + rank * j];
        M[i + n * j] = 2 * symmetric - M[j + n * i];
      }
    for (int i = 0; i < n; i++)
      q[i] = integer(-2, 1);
    const dls_status status = solved(n, M, q, NULL, z, &info);
    ck_assert(status == DLS_OK || status == DLS_NO_SOLUTION);
    count[status]++;
    if (status == DLS_OK) ck_assert(dls_lcp_certificate_holds(&info.certificate, 1e-14));
    if (status == DLS_NO_SOLUTION) ck_assert_int_eq(enumerate(n, M, q, 1e-9, other), 0);
  }
  ck_assert_int_gt(count[DLS_OK], 100);
  ck_assert_int_gt(count[DLS_NO_SOLUTION], 100);
}

/* ---- larger ---------------------------------------------------------------------------------- */

/* M = A A^T / n + 0.1 I + skew part */
static void spd_and_skew(int n, double *M, double *q) {
  double *A = malloc((size_t)(n * n) * sizeof *A);
  ck_assert(A != NULL);
  for (int k = 0; k < n * n; k++)
    A[k] = fraction() - 0.5;
  for (int j = 0; j < n; j++)
    for (int i = 0; i <= j; i++) {
      double sum = 0;
      for (int k = 0; k < n; k++)
        sum += A[i + n * k] * A[j + n * k];
      const double skew = i < j ? 0.02 * (fraction() - 0.5) : 0;
      M[i + n * j] = 12 * sum / n + (i == j ? 0.1 : 0) + skew;
      M[j + n * i] = M[i + n * j] - 2 * skew;
    }
  for (int i = 0; i < n; i++)
    q[i] = fraction() - 0.5;
  free(A);
}

static double big_M[300 * 300], big_M2[300 * 300], big_q[300], big_q2[300], big_z[300], big_z2[300];

TEST(hundred_unknowns) {
  for (int n = 20; n <= 180; n += 40) {
    dls_lemke_info info;
    spd_and_skew(n, big_M, big_q);
    ck_assert_int_eq(solved(n, big_M, big_q, NULL, big_z, &info), DLS_OK);
    ck_assert(dls_lcp_certificate_holds(&info.certificate, 1e-14));
    ck_assert_int_eq(info.starts, 1);
    ck_assert_int_lt(info.pivots, n);
  }
}

/* Rigid bodies: W = J^T J, q = J^T v, so that every problem has a solution, found by Lemke's
 * method [Cottle, Pang, Stone 4.4]. Columns: r_n, beta+, beta-, lambda per contact (Stewart and
 * Trinkle): y = (u_n, u_t + lambda, -u_t + lambda, mu r_n - beta+ - beta-). J of small integers:
 * degenerate. */
TEST(stewart_trinkle) {
  for (int trial = 0; trial < 400; trial++) {
    const int nc = integer(2, 12), n = 4 * nc, dof = integer(2, 2 * nc);
    double J[24 * 24] = {0}, v[24] = {0}, W[24 * 24] = {0}, p[24] = {0};
    dls_lemke_info info;
    for (int k = 0; k < dof * 2 * nc; k++)
      J[k] = integer(-1, 1);
    for (int k = 0; k < dof; k++)
      v[k] = integer(-1, 1);
    for (int a = 0; a < 2 * nc; a++) {
      p[a] = 0;
      for (int k = 0; k < dof; k++)
        p[a] += J[k + dof * a] * v[k];
      for (int b = 0; b < 2 * nc; b++) {
        W[a + 2 * nc * b] = 0;
        for (int k = 0; k < dof; k++)
          W[a + 2 * nc * b] += J[k + dof * a] * J[k + dof * b];
      }
    }
    memset(big_M, 0, sizeof big_M);
    memset(big_q, 0, sizeof big_q);
    static const double sign[3] = {1, 1, -1};
    static const int local[3] = {0, 1, 1};
    for (int a = 0; a < nc; a++) {
      for (int i = 0; i < 3; i++) {
        big_q[4 * a + i] = sign[i] * p[2 * a + local[i]];
        for (int b = 0; b < nc; b++)
          for (int j = 0; j < 3; j++)
            big_M[4 * a + i + n * (4 * b + j)] =
                sign[i] * sign[j] * W[2 * a + local[i] + 2 * nc * (2 * b + local[j])];
      }
      big_M[4 * a + 3 + n * (4 * a)] = integer(0, 2) / 2.0; /* mu */
      for (int i = 1; i < 3; i++) {
        big_M[4 * a + 3 + n * (4 * a + i)] = -1;
        big_M[4 * a + i + n * (4 * a + 3)] = 1;
      }
    }
    ck_assert_int_eq(solved(n, big_M, big_q, NULL, big_z, &info), DLS_OK);
    ck_assert(dls_lcp_certificate_holds(&info.certificate, 1e-12));
  }
}

/* M_ij = r^|i-j|, the inverse of a tridiagonal matrix, condition below ((1+r)/(1-r))^2: its tiny
 * entries say nothing of the size of a row. Scaled by their mean, rows differed by 1/r^(n/4). */
TEST(decaying_entries) {
  enum { n = 240 };
  static double M[n * n], q[n], z[n];
  for (double r = 0.2; r < 0.9; r += 0.3)
    for (int unit = 0; unit < 3; unit++) {
      const double a = unit == 1 ? 1e9 : 1, b = unit == 2 ? 1e-9 : 1;
      static int pivots;
      dls_lemke_info info;
      for (int j = 0; j < n; j++) {
        for (int i = 0; i < n; i++)
          M[i + j * n] = a / b * pow(r, abs(i - j));
        q[j] = a * (cos(0.9 * j) - 0.3);
      }
      ck_assert_int_eq(solved(n, M, q, NULL, z, &info), DLS_OK);
      ck_assert_int_eq(info.starts, 1);
      ck_assert_double_le(info.certificate.residual, rounding);
      if (unit == 0) pivots = info.pivots;
      ck_assert_int_eq(info.pivots, pivots);
    }
}

/* a contact problem of nc candidates, W symmetric positive definite */
static void contact_problem(int nc, double *W, double *q, double *mu) {
  spd_and_skew(2 * nc, W, q);
  for (int c = 0; c < nc; c++) {
    q[2 * c] -= 0.1;
    mu[c] = 0.2 + 0.6 * fraction();
  }
}

/* A contact problem with W symmetric positive definite has a solution; where the first d ends in
 * a ray, another one finds it. */
TEST(very_large_friction) {
  int restarted = 0;
  for (int trial = 0; trial < 300; trial++) {
    const int nc = integer(1, 4), n = 3 * nc;
    double A[64] = {0}, W[64] = {0}, q[8] = {0}, mu[4] = {0};
    for (int k = 0; k < 4 * nc * nc; k++)
      A[k] = fraction() - 0.5;
    for (int i = 0; i < 2 * nc; i++) {
      q[i] = fraction() - 0.7;
      mu[i / 2] = 5;
      for (int j = 0; j < 2 * nc; j++) {
        W[i + 2 * nc * j] = i == j ? 0.01 : 0;
        for (int k = 0; k < 2 * nc; k++)
          W[i + 2 * nc * j] += A[i + 2 * nc * k] * A[j + 2 * nc * k];
      }
    }
    const dls_contact problem = {
        .d = 2, .nc = nc, .W = {2 * nc, 2 * nc, 2 * nc, W}, .q = q, .mu = mu};
    dls_lemke_info info;
    ck_assert_int_eq(dls_contact_to_lcp(&problem, NULL, big_M, n, big_q, NULL), DLS_OK);
    ck_assert_int_eq(solved(n, big_M, big_q, NULL, big_z, &info), DLS_OK);
    ck_assert(dls_lcp_certificate_holds(&info.certificate, 1e-12));
    restarted += info.starts > 1;
  }
  ck_assert_int_gt(restarted, 0);
}

TEST(units) {
  enum { nc = 15, m = 2 * nc, n = 3 * nc };
  static const double factors[] = {1e-9, 1e-4, 1, 1e3, 1e9};
  double W[m * m] = {0}, q[m], mu[nc], W2[m * m], q2[m], s[nc], r[m], first[m] = {0};
  contact_problem(nc, W, q, mu);
  int pivots = 0, pivots_of_rows = 0;
  for (int a = 2; a < 2 + 5; a++) /* begin with 1 */
    for (int b = 2; b < 2 + 5; b++) {
      const double length = factors[a % 5], force = factors[b % 5];
      for (int k = 0; k < m * m; k++)
        W2[k] = W[k] * (length / force);
      for (int k = 0; k < m; k++)
        q2[k] = q[k] * length;
      for (int c = 0; c < nc; c++)
        s[c] = 1 / sqrt(0.5 * (W2[2 * c + m * (2 * c)] + W2[2 * c + 1 + m * (2 * c + 1)]));
      const dls_contact problem = {.d = 2, .nc = nc, .W = {m, m, m, W2}, .q = q2, .mu = mu};
      dls_lemke_info info;
      ck_assert_int_eq(dls_contact_to_lcp(&problem, s, big_M, n, big_q, NULL), DLS_OK);
      ck_assert_int_eq(solved(n, big_M, big_q, NULL, big_z, &info), DLS_OK);
      ck_assert_int_eq(dls_contact_from_lcp(&problem, s, big_z, r, NULL), DLS_OK);
      if (pivots == 0) {
        pivots = info.pivots;
        memcpy(first, r, sizeof r);
      }
      ck_assert_int_eq(info.pivots, pivots);
      for (int k = 0; k < m; k++)
        ck_assert_double_eq_tol(r[k] / force, first[k], rounding * (1 + fabs(first[k])));
      double size = 0;
      for (int i = 0; i < n; i++)
        size = fmax(size, big_z[i]);
      /* the rows of the LCP in any units */
      for (int i = 0; i < n; i++) {
        const double f = factors[(i + a) % 5] * factors[(i + b) % 4];
        big_q[i] *= f;
        for (int j = 0; j < n; j++)
          big_M[i + n * j] *= f;
      }
      ck_assert_int_eq(solved(n, big_M, big_q, NULL, big_z2, &info), DLS_OK);
      if (pivots_of_rows == 0) pivots_of_rows = info.pivots;
      ck_assert_int_eq(info.pivots, pivots_of_rows);
      assert_near(big_z2, big_z, n, rounding * size);
    }
}

TEST(permutations) {
  enum { n = 40 };
  int at[n];
  dls_lemke_info info;
  spd_and_skew(n, big_M, big_q);
  ck_assert_int_eq(solved(n, big_M, big_q, NULL, big_z, &info), DLS_OK);
  const int pivots = info.pivots;
  for (int trial = 0; trial < 10; trial++) {
    for (int i = 0; i < n; i++) {
      const int j = integer(0, i);
      at[i] = i;
      at[i] = at[j];
      at[j] = i;
    }
    for (int j = 0; j < n; j++) {
      big_q2[at[j]] = big_q[j];
      for (int i = 0; i < n; i++)
        big_M2[at[i] + n * at[j]] = big_M[i + n * j];
    }
    ck_assert_int_eq(solved(n, big_M2, big_q2, NULL, big_z2, &info), DLS_OK);
    ck_assert_int_eq(info.pivots, pivots); /* no ties here: the same path */
    for (int i = 0; i < n; i++)
      ck_assert_double_eq_tol(big_z2[at[i]], big_z[i], rounding);
  }
}

TEST(same_bits_and_reuse) {
  enum { n = 90 };
  const double M1[1] = {2}, q1[1] = {-4};
  dls_lemke *w;
  dls_lemke_info info, again;
  ck_assert_int_eq(dls_lemke_create(&w, n, NULL, NULL), DLS_OK);
  spd_and_skew(n, big_M, big_q);
  const dls_lcp lcp = lcp_of(n, big_M, big_q), one = lcp_of(1, M1, q1);
  ck_assert_int_eq(dls_lemke_solve(w, &lcp, big_z, NULL, &info, NULL), DLS_OK);
  double z[1];
  ck_assert_int_eq(dls_lemke_solve(w, &one, z, NULL, NULL, NULL), DLS_OK); /* smaller, between */
  ck_assert_double_eq(z[0], 2);
  malloc_fails_at(1);
  const dls_status status = dls_lemke_solve(w, &lcp, big_z2, big_q2, &again, NULL);
  const long calls = malloc_calls();
  malloc_fails_at(0);
  ck_assert_int_eq(status, DLS_OK);
  ck_assert_int_eq(calls, 0); /* a solve allocates nothing */
  ck_assert(memcmp(big_z, big_z2, n * sizeof *big_z) == 0);
  ck_assert_int_eq(info.pivots, again.pivots);
  ck_assert_double_eq(info.certificate.residual, again.certificate.residual);
  dls_lemke_destroy(w);
}

/* ---- limits ---------------------------------------------------------------------------------- */

typedef struct watcher {
  int calls, stop_at, last;
  double residual;
} watcher;

static int watch(void *data, const dls_progress *progress) {
  watcher *w = data;
  ck_assert_str_eq(progress->method, "lemke");
  if (progress->last) return 0;
  ck_assert_int_eq(progress->iteration, 50 * ++w->calls);
  ck_assert_double_ge(progress->residual, 0);
  w->residual = progress->residual;
  w->last = progress->iteration;
  return w->calls == w->stop_at;
}

TEST(progress_and_limit) {
  enum { n = 300 };
  watcher seen = {0, 0, 0, 0}, cancels = {0, 2, 0, 0};
  dls_lemke_settings settings = path_alone();
  dls_lemke_info info;
  spd_and_skew(n, big_M, big_q);
  settings.limits.progress = watch;
  settings.limits.progress_data = &seen;
  ck_assert_int_eq(solved(n, big_M, big_q, &settings, big_z, &info), DLS_OK);
  ck_assert_int_eq(seen.calls, info.pivots / 50);
  ck_assert_int_gt(seen.calls, 1);
  settings.limits.progress_data = &cancels;
  ck_assert_int_eq(solved(n, big_M, big_q, &settings, big_z, &info), DLS_CANCELLED);
  ck_assert_int_eq(info.pivots, 100);
  ck_assert_double_gt(info.certificate.residual, 0);
  ck_assert_double_lt(info.certificate.residual, 1);
  settings.limits.progress = NULL;
  settings.limits.max_iterations = 60;
  ck_assert_int_eq(solved(n, big_M, big_q, &settings, big_z, &info), DLS_MAX_ITERATIONS);
  ck_assert_int_eq(info.pivots, 60);
}

TEST(bad_arguments) {
  double M[4] = {1, 0, 0, 1}, q[2] = {-1, -1}, z[3] = {7, 8, 9}, y[2] = {5, 6}, cover[2] = {1, 1};
  dls_lemke *w = (dls_lemke *)z;
  dls_lemke_settings settings;
  dls_lemke_info info = {.pivots = 77};
  dls_error e;
  dls_lemke_settings_init(NULL);
  dls_lemke_destroy(NULL);
  dls_lemke_settings_init(&settings);
  REFUSES(ARGUMENT, "out", -1, dls_lemke_create, NULL, 2, &settings);
  const int sizes[] = {0, -1, 0x7fffffff};
  for (int k = 0; k < 3; k++) {
    w = (dls_lemke *)z;
    REFUSES(SIZE, "n", -1, dls_lemke_create, &w, sizes[k], &settings);
    ck_assert_ptr_null(w);
  }
  settings.size--;
  REFUSES(SETTINGS, "settings", -1, dls_lemke_create, &w, 2, &settings);
  settings.size++;
  const double tols[] = {-1, NAN, INFINITY};
  for (int k = 0; k < 3; k++) {
    settings.limits.tol = tols[k];
    REFUSES(ARGUMENT, "tol", -1, dls_lemke_create, &w, 2, &settings);
  }
  settings.limits.tol = 1e-8;
  settings.limits.max_iterations = -1;
  REFUSES(ARGUMENT, "max_iterations", -1, dls_lemke_create, &w, 2, &settings);
  settings.limits.max_iterations = 0;
  settings.cover = cover;
  cover[1] = 0;
  REFUSES(ARGUMENT, "cover", 1, dls_lemke_create, &w, 2, &settings);
  cover[1] = NAN;
  ck_assert_int_eq(dls_lemke_create(&w, 2, &settings, &e), DLS_E_NOT_FINITE);
  ck_assert_int_eq(e.index, 1);
  ck_assert_ptr_null(w);
  cover[1] = 1;

  ck_assert_int_eq(dls_lemke_create(&w, 2, &settings, &e), DLS_OK);
  cover[1] = -1; /* copied */
  const double M3[9] = {1, 0, 0, 0, 1, 0, 0, 0, 1}, q3[3] = {-1, -1, -1};
  const dls_lcp lcp = lcp_of(2, M, q), large = lcp_of(3, M3, q3);
  REFUSES(ARGUMENT, "workspace", -1, dls_lemke_solve, NULL, &lcp, z, y, &info);
  REFUSES(ARGUMENT, "lcp", -1, dls_lemke_solve, w, NULL, z, y, &info);
  REFUSES(SIZE, "n", -1, dls_lemke_solve, w, &large, z, y, &info);
  REFUSES(ARGUMENT, "z", -1, dls_lemke_solve, w, &lcp, NULL, y, &info);
  M[2] = NAN;
  REFUSES(NOT_FINITE, "M", 2, dls_lemke_solve, w, &lcp, z, y, &info);
  M[2] = 0;
  q[0] = INFINITY;
  REFUSES(NOT_FINITE, "q", 0, dls_lemke_solve, w, &lcp, z, y, &info);
  q[0] = -1;
  double z0 = 3, v[2] = {1, 2};
  REFUSES(ARGUMENT, "workspace", -1, dls_lemke_ray, w, v, &z0, v, &z0, v);
  ck_assert_int_eq(dls_lemke_ray(NULL, v, &z0, v, &z0, v, &e), DLS_E_ARGUMENT);
  ck_assert_int_eq(dls_lemke_farkas(w, v, &e), DLS_E_ARGUMENT);
  ck_assert_int_eq(dls_lemke_farkas(NULL, v, &e), DLS_E_ARGUMENT);
  ck_assert_double_eq(z0, 3);
  ck_assert_double_eq(v[0], 1);
  ck_assert_double_eq(z[0], 7);
  ck_assert_double_eq(y[1], 6);
  ck_assert_int_eq(info.pivots, 77);
  const double none[4] = {0, 0, 0, 0};
  const dls_lcp impossible = lcp_of(2, none, q);
  ck_assert_int_eq(dls_lemke_solve(w, &impossible, z, y, &info, &e), DLS_NO_SOLUTION);
  REFUSES(ARGUMENT, "v", -1, dls_lemke_farkas, w, NULL);
  ck_assert_int_eq(dls_lemke_ray(w, NULL, NULL, NULL, NULL, NULL, &e), DLS_OK);
  ck_assert_int_eq(dls_lemke_solve(w, &lcp, z, y, &info, &e), DLS_OK);
  assert_near(z, (double[]){1, 1}, 2, 0);
  dls_lemke_destroy(w);
}

TEST(every_malloc_fails) {
  const double cover[3] = {1, 1, 1};
  dls_lemke_settings settings;
  dls_lemke *w = NULL;
  dls_error e;
  dls_lemke_settings_init(&settings);
  settings.cover = cover;
  MALLOCS_FAIL(dls_lemke_create(&w, 3, &settings, &e), !w, DLS_OK, 1);
  dls_lemke_destroy(w);
}

TEST(extreme_numbers) {
  /* answers that overflow, or nearly, are never called solved without a certificate */
  const double scales[] = {1e-300, 1e-150, 1e150, 1e300};
  for (int a = 0; a < 4; a++)
    for (int b = 0; b < 4; b++) {
      const double M[4] = {2 * scales[a], scales[a], scales[a], 2 * scales[a]};
      const double q[2] = {-5 * scales[b], -6 * scales[b]}, f = scales[b] / scales[a];
      double z[2];
      dls_lemke_info info;
      const dls_status status = solved(2, M, q, NULL, z, &info);
      if (f > 0 && f < 1e307) {
        ck_assert_int_eq(status, DLS_OK);
        ck_assert_double_eq_tol(z[0] / f, 4.0 / 3, 1e-14);
        ck_assert_double_eq_tol(z[1] / f, 7.0 / 3, 1e-14);
      } else
        ck_assert_int_ne(status, DLS_NO_SOLUTION);
    }
}

/* ---- warm start ------------------------------------------------------------------------------ */

/* M = A A^T / n + I / 10 + skew part, the q of a load that grows with time */
static void growing_problem(int n, double time, double *M, double *q) {
  double *A = malloc((size_t)(n * n) * sizeof *A);
  ck_assert_ptr_nonnull(A);
  seed = 77;
  for (int k = 0; k < n * n; k++)
    A[k] = fraction() - 0.5;
  for (int i = 0; i < n; i++)
    for (int j = 0; j < n; j++) {
      double sum = (i == j ? 0.1 : 0) + 0.01 * (A[i + n * j] - A[j + n * i]);
      for (int k = 0; k < n; k++)
        sum += A[i + n * k] * A[j + n * k] / n;
      M[i + n * j] = sum;
    }
  for (int i = 0; i < n; i++) {
    const double base = fraction() - 0.5, rate = fraction() - 0.5;
    q[i] = base + time * rate;
  }
  free(A);
}

TEST(warm_start_follows_a_load) {
  enum { n = 60, steps = 10 };
  static double M[n * n], q[n], z[n], cold[n];
  dls_lemke_settings settings = path_alone();
  dls_lemke_info info;
  int warm_pivots = 0, cold_pivots = 0;
  for (int k = 0; k < steps; k++) {
    growing_problem(n, 0.05 * k, M, q);
    settings.limits.warm_start = 0;
    ck_assert_int_eq(solved(n, M, q, &settings, cold, &info), DLS_OK);
    if (k > 0) cold_pivots += info.pivots;
    settings.limits.warm_start = k > 0;
    ck_assert_int_eq(solved(n, M, q, &settings, z, &info), DLS_OK);
    ck_assert_double_le(info.certificate.residual, 1e-13);
    ck_assert_int_eq(info.starts, 1);
    if (k > 0) warm_pivots += info.pivots;
    for (int i = 0; i < n; i++) /* M is positive definite: one solution */
      ck_assert_double_eq_tol(z[i], cold[i], 1e-11 * (1 + cold[i]));
    ck_assert_int_eq(solved(n, M, q, &settings, z, &info), DLS_OK);
    if (k > 0) ck_assert_int_eq(info.pivots, 0); /* the answer is its own start */
  }
  ck_assert_int_lt(5 * warm_pivots, cold_pivots);
}

TEST(warm_start_from_anywhere) {
  enum { n = 12 };
  double M[n * n], q[n], z[n], cold[n];
  dls_lemke_settings settings = path_alone();
  dls_lemke_info info;
  growing_problem(n, 0, M, q);
  ck_assert_int_eq(solved(n, M, q, &settings, cold, &info), DLS_OK);
  settings.limits.warm_start = 1;
  seed = 5;
  for (int k = 0; k < 500; k++) {
    for (int i = 0; i < n; i++)
      z[i] = integer(0, 1) ? 1e3 * fraction() : -fraction();
    ck_assert_int_eq(solved(n, M, q, &settings, z, &info), DLS_OK);
    ck_assert_int_eq(info.starts, 1);
    for (int i = 0; i < n; i++)
      ck_assert_double_eq_tol(z[i], cold[i], 1e-11 * (1 + cold[i]));
  }
}

/* A start whose basis is singular, and a problem without a solution: as if it had been cold. */
TEST(warm_start_that_leads_nowhere) {
  const double singular[4] = {1, 1, 1, 1}, q[2] = {-1, -2};
  double z[2] = {1, 1};
  dls_lemke_settings settings = path_alone();
  settings.limits.warm_start = 1;
  dls_lemke_info info;
  ck_assert_int_eq(solved(2, singular, q, &settings, z, &info), DLS_OK);
  ck_assert_double_eq_tol(z[1], 2, 4e-16);
  ck_assert_int_eq(info.starts, 2);
  const double none[4] = {0, -1, 1, 0}; /* y_2 = -z_1 - 2 */
  z[0] = z[1] = 1;
  ck_assert_int_eq(solved(2, none, q, &settings, z, &info), DLS_NO_SOLUTION);
  /* NaN in the start */
  const dls_lcp lcp = lcp_of(2, singular, q);
  dls_lemke *w;
  z[0] = 7, z[1] = NAN;
  ck_assert_int_eq(dls_lemke_create(&w, 2, &settings, NULL), DLS_OK);
  REFUSES(NOT_FINITE, "z", 1, dls_lemke_solve, w, &lcp, z, NULL, &info);
  ck_assert(z[0] == 7);
  dls_lemke_destroy(w);
  settings.limits.warm_start = 2;
  REFUSES(ARGUMENT, "warm_start", -1, dls_lemke_create, &w, 2, &settings);
}

/* M = -I, q < 0: no solution. The covering vector that is given stays beside a start, to the bit,
 * in any solve. */
/* M = 2^10 I, q = (-1, -3): z_0 covers with 3, then z_2 rises until y_1 = z_0 - 1 = 0. There
 * z = (0, 2) / 2^10 and y = (-1, -1), which is better than z = 0; the third pivot ends. In any
 * units. */
TEST(limit_on_the_path) {
  static const double M[4] = {0x1p10, 0, 0, 0x1p10};
  for (int e = -20; e <= 20; e += 10)
    for (int turned = 0; turned < 2; turned++) {
      const double unit = ldexp(1, e),
                   q[2] = {turned ? -3 * unit : -unit, turned ? -unit : -3 * unit};
      for (int most = 1; most <= 3; most++) {
        dls_lemke_settings settings = path_alone();
        dls_lemke_info info;
        double z[2];
        settings.limits.max_iterations = most;
        ck_assert_int_eq(solved(2, M, q, &settings, z, &info),
                         most < 3 ? DLS_MAX_ITERATIONS : DLS_OK);
        ck_assert_int_eq(info.pivots, most);
        ck_assert(z[turned] == (most < 3 ? 0 : unit * 0x1p-10));
        ck_assert(z[!turned] == (most < 2 ? 0 : most < 3 ? 2 : 3) * unit * 0x1p-10);
        const double residual = most < 2 ? 1 : most < 3 ? sqrt(0.2) : 0;
        ck_assert_double_eq_tol(info.certificate.residual, residual, 1e-15);
      }
    }
}

/* From the basis of the answer, M = I, q = (-1, x), there is no pivot where b = (1, x) is 0 up to
 * rounding, or larger. */
TEST(warm_start_on_the_border) {
  static const double M[4] = {1, 0, 0, 1}, last[] = {0, -1e-14, 1e-14, 1, -1e-8};
  for (int k = 0; k < 5; k++)
    for (int turned = 0; turned < 2; turned++) {
      const double q[2] = {turned ? last[k] : -1, turned ? -1 : last[k]};
      dls_lemke_settings settings = path_alone();
      dls_lemke_info info;
      double z[2] = {!turned, turned};
      settings.limits.warm_start = 1;
      settings.limits.tol = 1e-12;
      ck_assert_int_eq(solved(2, M, q, &settings, z, &info), DLS_OK);
      ck_assert_int_eq(info.pivots > 0, k == 4);
      ck_assert_double_eq_tol(z[turned], 1, 1e-14);
      ck_assert_double_eq_tol(z[!turned], k == 4 ? 1e-8 : 0, 2e-14);
    }
}

TEST(warm_start_keeps_the_cover) {
  enum { n = 16 }; /* n ints fill lines of memory: one more is the first number behind */
  double M[n * n] = {0}, q[n], z[n], given[n], cover[2][n];
  for (int i = 0; i < n; i++) {
    M[i + n * i] = q[i] = -1;
    given[i] = 1 + 0.25 / (i + 3);
  }
  dls_lemke_settings settings = path_alone();
  settings.limits.warm_start = 1;
  settings.cover = given;
  const dls_lcp lcp = lcp_of(n, M, q);
  dls_lemke *w;
  ck_assert_int_eq(dls_lemke_create(&w, n, &settings, NULL), DLS_OK);
  for (int k = 0; k < 2; k++) {
    for (int i = 0; i < n; i++)
      z[i] = i % 2;
    ck_assert_int_eq(dls_lemke_solve(w, &lcp, z, NULL, NULL, NULL), DLS_NO_SOLUTION);
    ck_assert_int_eq(dls_lemke_ray(w, NULL, NULL, NULL, NULL, cover[k], NULL), DLS_OK);
  }
  ck_assert_mem_eq(cover[0], cover[1], sizeof cover[0]);
  dls_lemke_destroy(w);
}

/* The start has one variable of each pair at -1, and with the cover a tie. The one with the smaller
 * part of the perturbation leaves: y of row 2, then z of row 2, whose part is that of a cold start.
 * M = [1 -2; 0 1] and its mirror image: z = (1, 1) after 2 exchanges if y leaves, 4 if z does. */
TEST(warm_start_breaks_ties_as_a_cold_one) {
  const double ones[2] = {1, 1};
  dls_lemke_settings settings = path_alone();
  settings.limits.warm_start = 1;
  settings.cover = ones;
  for (int k = 0; k < 2; k++) {
    const double M[2][4] = {{1, 0, -2, 1}, {1, -2, 0, 1}}, q[2][2] = {{1, -1}, {-1, 1}};
    double z[2] = {1 - k, k};
    dls_lemke_info info;
    ck_assert_int_eq(solved(2, M[k], q[k], &settings, z, &info), DLS_OK);
    ck_assert(z[0] == 1 && z[1] == 1);
    ck_assert_int_eq(info.pivots, k == 0 ? 2 : 4);
    ck_assert_int_eq(info.starts, 1);
  }
}

/* From z = 0 the path is that of a cold start, ties included, of which small integers have many. */
TEST(warm_start_from_zero) {
  double M[16], q[4], z[2][4];
  int paths = 0;
  dls_lemke_settings settings = path_alone();
  seed = 11;
  for (int k = 0; k < 200; k++) {
    dls_lemke_info info[2];
    const int n = 2 + k % 3;
    for (int e = 0; e < n * n; e++)
      M[e] = e % (n + 1) ? integer(-1, 1) : integer(1, 2);
    for (int i = 0; i < n; i++)
      q[i] = integer(-3, 0);
    memset(z, 0, sizeof z);
    for (int warm = 0; warm < 2; warm++) {
      settings.limits.warm_start = warm;
      (void)solved(n, M, q, &settings, z[warm], &info[warm]);
    }
    if (info[1].starts > 1) continue; /* after a ray it starts cold */
    ck_assert_int_eq(info[0].pivots, info[1].pivots);
    ck_assert_mem_eq(z[0], z[1], (size_t)n * sizeof **z);
    paths++;
  }
  ck_assert_int_gt(paths, 100);
}

/* The start is the solution but for a y of rounding beside z = (1, 0) or (0, 1): no exchange. */
TEST(warm_start_within_rounding) {
  const double M[4] = {1, 0, 0, 1}, ones[2] = {1, 1};
  dls_lemke_settings settings = path_alone();
  settings.limits.warm_start = 1;
  settings.cover = ones;
  for (int k = 0; k < 2; k++) {
    const double q[2] = {k ? -0x1p-45 : -1, k ? -1 : -0x1p-45};
    double z[2] = {1 - k, k};
    dls_lemke_info info;
    ck_assert_int_eq(solved(2, M, q, &settings, z, &info), DLS_OK);
    ck_assert(z[0] == 1 - k && z[1] == k);
    ck_assert_int_eq(info.pivots, 0);
  }
}

typedef struct path_watch {
  const dls_lcp *lcp;
  int calls;
} path_watch;

/* y = q + M z + z0 >= 0 with an equality, so that z tells z0; told is z0 |d| / |q|. */
static int watch_estimate(void *data, const dls_progress *progress) {
  path_watch *w = data;
  if (progress->last) return 0;
  const int n = w->lcp->n;
  double z0 = -INFINITY, size = 0;
  for (int i = 0; i < n; i++) {
    double y = w->lcp->q[i];
    for (int j = 0; j < n; j++)
      y += w->lcp->M.a[i + n * j] * progress->r[j];
    z0 = fmax(z0, -y);
    size += w->lcp->q[i] * w->lcp->q[i];
  }
  ck_assert_double_eq_tol(progress->residual / (z0 * sqrt(n / size)), 1, 1e-10);
  w->calls++;
  return 0;
}

/* M of 1 and -1, which no scales change, and the cover 1. */
TEST(residual_on_the_path) {
  enum { n = 101 };
  seed = 4;
  for (int j = 0; j < n; j++) {
    big_q[j] = -4 - fraction();
    for (int i = 0; i <= j; i++) {
      big_M[i + n * j] = i == j || fraction() < .5 ? 1 : -1;
      big_M[j + n * i] = i == j ? 1 : -big_M[i + n * j];
    }
  }
  const dls_lcp lcp = lcp_of(n, big_M, big_q);
  path_watch w = {&lcp, 0};
  double ones[n];
  for (int i = 0; i < n; i++)
    ones[i] = 1;
  dls_lemke_settings settings = path_alone();
  settings.cover = ones;
  settings.limits.progress = watch_estimate;
  settings.limits.progress_data = &w;
  dls_lemke_info info;
  ck_assert_int_eq(solved(n, big_M, big_q, &settings, big_z, &info), DLS_OK);
  ck_assert_int_gt(w.calls, 1);
}

/* ---- crash start ----------------------------------------------------------------------------- */

/* the default */
static dls_lemke_settings with_crash(void) {
  dls_lemke_settings settings;
  dls_lemke_settings_init(&settings);
  ck_assert_int_eq(settings.crash, 1);
  return settings;
}

/* Positive definite: the one solution without a pivot, in the rounds that every order and unit
 * takes. */
TEST(crash_finds_the_solution) {
  for (int n = 20; n <= 300; n += 70) {
    const dls_lemke_settings settings = with_crash();
    dls_lemke_info info, path;
    spd_and_skew(n, big_M, big_q);
    ck_assert_int_eq(solved(n, big_M, big_q, NULL, big_z2, &path), DLS_OK);
    ck_assert_int_eq(path.crash_rounds, 0);
    ck_assert_int_eq(solved(n, big_M, big_q, &settings, big_z, &info), DLS_OK);
    ck_assert(dls_lcp_certificate_holds(&info.certificate, 1e-14));
    ck_assert_int_eq(info.starts, 0);
    ck_assert_int_eq(info.pivots, 0);
    ck_assert_int_ge(info.crash_rounds, 3);
    ck_assert_int_le(info.crash_rounds, 10);
    double size = 0;
    for (int i = 0; i < n; i++)
      size = fmax(size, big_z2[i]);
    assert_near(big_z, big_z2, n, 10 * rounding * size);
    /* backwards, rows and columns in units of their own */
    const int rounds = info.crash_rounds;
    for (int j = 0; j < n; j++) {
      const double column = exp2(integer(-30, 30));
      for (int i = 0; i < n; i++)
        big_M2[i + n * j] = big_M[n - 1 - i + n * (n - 1 - j)] * column;
      big_q2[j] = big_q[n - 1 - j];
      big_z2[j] = column;
    }
    for (int i = 0; i < n; i++) {
      const double row = pow(10, integer(-9, 9));
      big_q2[i] *= row;
      for (int j = 0; j < n; j++)
        big_M2[i + n * j] *= row;
    }
    double column[300];
    memcpy(column, big_z2, sizeof column);
    ck_assert_int_eq(solved(n, big_M2, big_q2, &settings, big_z2, &info), DLS_OK);
    ck_assert_int_eq(info.crash_rounds, rounds);
    ck_assert_int_eq(info.starts, 0);
    for (int i = 0; i < n; i++)
      ck_assert_double_eq_tol(big_z2[i] * column[i], big_z[n - 1 - i], 1e3 * rounding * size);
  }
}

/* With friction M has zeros on its diagonal, and bases are singular that lack a partner. */
TEST(crash_with_friction) {
  enum { nc = 30, m = 2 * nc, n = 3 * nc };
  static double W[m * m], q[m], mu[nc];
  const dls_lemke_settings settings = with_crash();
  int without_path = 0;
  for (int trial = 0; trial < 10; trial++) {
    contact_problem(nc, W, q, mu);
    const dls_contact problem = {.d = 2, .nc = nc, .W = {m, m, m, W}, .q = q, .mu = mu};
    dls_lemke_info info, path;
    ck_assert_int_eq(dls_contact_to_lcp(&problem, NULL, big_M, n, big_q, NULL), DLS_OK);
    ck_assert_int_eq(solved(n, big_M, big_q, NULL, big_z2, &path), DLS_OK);
    ck_assert_int_eq(solved(n, big_M, big_q, &settings, big_z, &info), DLS_OK);
    ck_assert(dls_lcp_certificate_holds(&info.certificate, 1e-14));
    without_path += info.starts == 0;
  }
  ck_assert_int_ge(without_path, 8);
}

/* Round friction on facets: some bases are singular, which rounding must not hide in some units. */
TEST(crash_in_any_unit) {
  enum { nc = 8, m = 3 * nc, facets = 8, n = (facets + 2) * nc };
  static const double factors[] = {1, 1e-9, 1e-3, 1e6, 1e9};
  const dls_lemke_settings settings = with_crash();
  double W[m * m], q[m], mu[nc], W2[m * m], q2[m], s[nc];
  for (int trial = 0; trial < 20; trial++) {
    spd_and_skew(m, W, q);
    dls_lemke_info info, first = {.starts = -1};
    for (int k = 0; k < 25; k++) {
      const double length = factors[k / 5], force = factors[k % 5];
      scale_vector(W2, W, length / force, m * m);
      scale_vector(q2, q, length, m);
      for (int c = 0; c < nc; c++) {
        mu[c] = 0.6;
        s[c] = 1 / sqrt(W2[3 * c + m * (3 * c)]);
      }
      const dls_contact problem = {.d = 3, .nc = nc, .W = {m, m, m, W2}, .q = q2, .mu = mu};
      ck_assert_int_eq(dls_contact_to_facets_lcp(&problem, facets, s, big_M, n, big_q, NULL),
                       DLS_OK);
      ck_assert_int_eq(solved(n, big_M, big_q, &settings, big_z, &info), DLS_OK);
      if (k == 0) first = info;
      ck_assert_int_eq(info.crash_rounds, first.crash_rounds);
      ck_assert_int_eq(info.pivots, first.pivots);
    }
  }
}

/* The factors and what is kept behind them stay in the n x n numbers they are given. */
TEST(crash_keeps_to_its_room) {
  enum { most_n = 60, canary = 8 * most_n };
  static double M[most_n * most_n], q[most_n], s[most_n], A[most_n * most_n + canary];
  int rounds = 0;
  for (int trial = 0; trial < 200; trial++) {
    const int n = integer(12, most_n);
    spd_and_skew(n, M, q);
    for (int i = 0; i < n; i++) { /* nearly all z_i basic, few of which change */
      s[i] = M[i + n * i];
      q[i] = fraction() < .08 ? 1 : -fabs(q[i]) - .02 * s[i];
    }
    const dls_lcp lcp = lcp_of(n, M, q);
    dlsi_crash work = {0};
    dlsi_arena arena = {0};
    dlsi_crash_carve(&work, &arena, (size_t)n, (size_t)n);
    ck_assert_int_eq(dlsi_arena_allocate(&arena, "n", n, NULL), DLS_OK);
    dlsi_crash_carve(&work, &arena, (size_t)n, (size_t)n);
    work.s = s;
    work.factors.A = A;
    for (int k = 0; k < canary; k++)
      A[n * n + k] = 7;
    double z[most_n];
    for (int i = 0; i < n; i++)
      z[i] = fraction() < .9;
    dlsi_crash_begin(&lcp, z, &work);
    while (work.rounds < 40 && dlsi_crash_round(&lcp, &work) == 0)
      ;
    rounds += work.rounds;
    assert_all(A + n * n, canary, 7);
    free(arena.base);
  }
  ck_assert_int_ge(rounds, 400);
}

/* A crash start that leads nowhere leaves no trace: the same pivots, the same bits, the same
 * ray. */
TEST(crash_that_leads_nowhere) {
  enum { most = 14 };
  const dls_lemke_settings settings = with_crash();
  int failed[6] = {0}, lucky = 0;
  for (int trial = 0; trial < 8000; trial++) {
    const int n = trial % 2 ? integer(1, 6) : integer(11, most);
    double M[most * most], q[most], z[most], other[most];
    dls_lemke_info info, path;
    for (int k = 0; k < n * n; k++)
      M[k] = integer(-2, 2);
    for (int i = 0; i < n; i++)
      q[i] = integer(-2, 1);
    const dls_status expected = solved(n, M, q, NULL, other, &path);
    const dls_status status = solved(n, M, q, &settings, z, &info);
    if (info.starts == 0) {
      ck_assert_int_eq(status, DLS_OK);
      ck_assert_int_ne(expected, DLS_NO_SOLUTION);
      ck_assert_int_eq(info.pivots, 0);
      lucky += expected == DLS_RAY;
      continue;
    }
    failed[status]++;
    ck_assert_int_eq(status, expected);
    ck_assert_int_eq(info.pivots, path.pivots);
    ck_assert_int_eq(info.starts, path.starts);
    ck_assert_int_gt(info.crash_rounds, 0);
    ck_assert(memcmp(z, other, (size_t)n * sizeof *z) == 0);
  }
  ck_assert_int_gt(failed[DLS_OK], 100);
  ck_assert_int_gt(failed[DLS_RAY], 10);
  ck_assert_int_gt(failed[DLS_NO_SOLUTION], 100);
  ck_assert_int_gt(lucky, 10);
}

/* The first basis is nearly singular: the second round, the first with factors, is the last. */
TEST(crash_does_not_insist) {
  enum { n = 60 };
  const dls_lemke_settings settings = with_crash();
  dls_lemke_info info;
  spd_and_skew(n, big_M, big_q);
  for (int k = 0; k < n * n; k++)
    big_M[k] = 1 + 1e-7 * big_M[k];
  ck_assert_int_eq(solved(n, big_M, big_q, &settings, big_z, &info), DLS_OK);
  ck_assert_int_eq(info.crash_rounds, 2);
  ck_assert_int_eq(info.starts, 1);
}

/* The answer is its own start; with a cover there is the path alone. */
TEST(crash_from_a_start_and_with_a_cover) {
  enum { n = 60 };
  dls_lemke_settings settings = with_crash();
  dls_lemke_info info;
  double ones[n];
  spd_and_skew(n, big_M, big_q);
  ck_assert_int_eq(solved(n, big_M, big_q, &settings, big_z, &info), DLS_OK);
  settings.limits.warm_start = 1;
  ck_assert_int_eq(solved(n, big_M, big_q, &settings, big_z, &info), DLS_OK);
  ck_assert_int_eq(info.crash_rounds, 1);
  ck_assert_int_eq(info.starts, 0);
  for (int i = 0; i < n; i++)
    ones[i] = 1;
  settings.cover = ones;
  ck_assert_int_eq(solved(n, big_M, big_q, &settings, big_z, &info), DLS_OK);
  ck_assert_int_eq(info.crash_rounds, 0);
  ck_assert_int_eq(info.starts, 1);
}

static int stop_at_second_round(void *data, const dls_progress *progress) {
  if (progress->last) return 0;
  ck_assert_int_eq(progress->iteration, ++*(int *)data);
  return *(int *)data == 2;
}

TEST(crash_can_be_cancelled) {
  enum { n = 60 };
  dls_lemke_settings settings = with_crash();
  dls_lemke_info info;
  int calls = 0;
  spd_and_skew(n, big_M, big_q);
  settings.limits.progress = stop_at_second_round;
  settings.limits.progress_data = &calls;
  ck_assert_int_eq(solved(n, big_M, big_q, &settings, big_z, &info), DLS_CANCELLED);
  ck_assert_int_eq(info.crash_rounds, 2);
  ck_assert_int_eq(info.pivots, 0);
  settings.crash = 2;
  dls_lemke *w;
  REFUSES(ARGUMENT, "crash", -1, dls_lemke_create, &w, n, &settings);
}

/* |q| overflows: nothing is certified against it, and z = 0 is no solution. */
TEST(a_norm_beyond_numbers) {
  enum { n = 8 };
  double M[n * n] = {0}, q[n], z[n];
  for (int i = 0; i < n; i++) {
    M[i + n * i] = -1;
    q[i] = -1.7e308;
  }
  const dls_lcp lcp = {.n = n, .M = {n, n, n, M}, .q = q};
  dls_lemke *lemke;
  dls_lemke_info info;
  ck_assert_int_eq(dls_lemke_create(&lemke, n, NULL, NULL), DLS_OK);
  ck_assert_int_gt(dls_lemke_solve(lemke, &lcp, z, NULL, &info, NULL), 0);
  ck_assert(!dls_lcp_certificate_holds(&info.certificate, 1e-8));
  dls_lemke_destroy(lemke);
}
