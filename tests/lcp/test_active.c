/* test_active.c: LCPs in compressed columns: dls_principal_solve, the certificate, refusals. */
#include "delassus/pivoting.h"
#include "run.h"

/* ---- problems -------------------------------------------------------------------------------- */

static uint64_t state = 1;

static double centred(void) { /* in (-1, 1) */
  state = state * 6364136223846793005u + 1442695040888963407u;
  return (double)(state >> 11) / 4503599627370496.0 - 1;
}

/* A matrix that is written column after column, and q. */
typedef struct columns {
  int n, count;
  int *p, *i;
  double *x, *q;
} columns;

static columns start(int n, int most) {
  columns c = {.n = n};
  c.p = calloc((size_t)n + 1, sizeof *c.p);
  c.i = calloc((size_t)most, sizeof *c.i);
  c.x = calloc((size_t)most, sizeof *c.x);
  c.q = calloc((size_t)n, sizeof *c.q);
  ck_assert(c.p && c.i && c.x && c.q);
  return c;
}

static void add(columns *c, int row, double x) {
  c->i[c->count] = row;
  c->x[c->count++] = x;
}

static void end_column(columns *c, int j) {
  c->p[j + 1] = c->count;
}

static dls_lcp view(const columns *c) {
  return (dls_lcp){.n = c->n, .q = c->q, .Ms = {c->n, c->n, c->p, c->i, c->x}};
}

static void drop(columns *c) {
  free(c->p);
  free(c->i);
  free(c->x);
  free(c->q);
}

/* M (n x n, column-major) := the dense form. */
static void fill_dense(const columns *c, double *M) {
  memset(M, 0, (size_t)c->n * (size_t)c->n * sizeof *M);
  for (int j = 0; j < c->n; j++)
    for (int k = c->p[j]; k < c->p[j + 1]; k++)
      M[c->i[k] + c->n * j] += c->x[k];
}

static columns from_dense(int n, const double *M, const double *q) {
  columns c = start(n, n * n);
  for (int j = 0; j < n; j++) {
    for (int i = n - 1; i >= 0; i--)
      if (M[i + n * j] != 0) add(&c, i, M[i + n * j]);
    end_column(&c, j);
    c.q[j] = q[j];
  }
  return c;
}

/* A membrane over steps on a side x side grid; `wind`: first-order upwind terms. */
static columns membrane(int side, double wind) {
  const double h = 2.0 / (side + 1);
  columns c = start(side * side, 5 * side * side);
  for (int b = 0; b < side; b++)
    for (int a = 0; a < side; a++) {
      const int j = a + side * b;
      add(&c, j, 4 + wind);
      if (a > 0) add(&c, j - 1, -1);
      if (a < side - 1) add(&c, j + 1, -1 - wind);
      if (b > 0) add(&c, j - side, -1);
      if (b < side - 1) add(&c, j + side, -1);
      end_column(&c, j);
    }
  for (int j = 0; j < c.n; j++)
    c.q[j] = 10 * h * h;
  for (int j = 0; j < c.n; j++) {
    const double x = -1 + h * (j % side + 1), obstacle = -.2 - .2 * floor(2 * x + 2);
    for (int k = c.p[j]; k < c.p[j + 1]; k++)
      c.q[c.i[k]] += c.x[k] * obstacle;
  }
  return c;
}

/* An American put, one long implicit step on n log-prices: an unsymmetric M-matrix. */
static columns stopping(int n) {
  const double h = 6.0 / (n - 1), dt = .05, sigma = .3, rate = .05;
  const double a = sigma * sigma / (2 * h * h), b = (rate - sigma * sigma / 2) / h;
  columns c = start(n, 3 * n);
  for (int j = 0; j < n; j++) {
    if (j > 0) add(&c, j - 1, -a - b);
    add(&c, j, 1 / dt + 2 * a + b + rate);
    if (j < n - 1) add(&c, j + 1, -a);
    end_column(&c, j);
  }
  for (int j = 0; j < n; j++) {
    const double paid = fmax(1 - exp(-3 + h * j), 0);
    c.q[j] -= paid / dt;
    for (int k = c.p[j]; k < c.p[j + 1]; k++)
      c.q[c.i[k]] += c.x[k] * paid;
  }
  return c;
}

static dls_principal_settings active_defaults(const columns *c) {
  dls_principal_settings settings;
  dls_principal_settings_init(&settings);
  settings.limits.blocks = c->count > 0 ? c->count : 1;
  return settings;
}

static dls_principal_info active_solve(const columns *c, const dls_principal_settings *settings,
                                       double *z, double *y) {
  const dls_principal_settings own = active_defaults(c);
  const dls_lcp lcp = view(c);
  dls_principal *work;
  dls_principal_info info;
  ck_assert_int_eq(dls_principal_create(&work, c->n, settings ? settings : &own, NULL), DLS_OK);
  const dls_status status = dls_principal_solve(work, &lcp, z, y, &info, NULL);
  ck_assert_int_eq(status, info.status);
  dls_principal_destroy(work);
  return info;
}

/* |min(M_ii z_i, y_i)|_2 / |q|_2, by loops of the test's own; y = M z + q. */
static double residual(const columns *c, const double *z) {
  double *y = calloc(2 * (size_t)c->n, sizeof *y), *s = y + c->n, sum = 0, size = 0;
  for (int j = 0; j < c->n; j++)
    for (int k = c->p[j]; k < c->p[j + 1]; k++) {
      y[c->i[k]] += c->x[k] * z[j];
      if (c->i[k] == j) s[j] += c->x[k];
    }
  for (int i = 0; i < c->n; i++) {
    const double F = fmin(s[i] * z[i], y[i] + c->q[i]);
    sum += F * F;
    size += c->q[i] * c->q[i];
  }
  free(y);
  return sqrt(sum / size);
}

/* ---- answers --------------------------------------------------------------------------------- */

/* Random P-matrices, with unsorted and repeated entries: the only solution, for any
 * block_steps. */
TEST(agrees_with_the_dense_method) {
  enum { n = 40 };
  static double M[n * n], q[n], exact[n], z[n];
  for (int trial = 0; trial < 60; trial++) {
    columns c = start(n, 6 * n);
    for (int j = 0; j < n; j++) {
      add(&c, j, 3);
      for (int k = 0; k < 4; k++)
        add(&c, (int)((centred() + 1) * n / 2), centred());
      add(&c, j, .5 + centred() / 2);
      end_column(&c, j);
      c.q[j] = q[j] = centred();
    }
    /* diagonally dominant by columns: a P-matrix */
    for (int j = 0; j < n; j++)
      c.x[c.p[j]] = 5;
    fill_dense(&c, M);
    const dls_lcp dense = {.n = n, .M = {n, n, n, M}, .q = q};
    dls_principal *work;
    ck_assert_int_eq(dls_principal_create(&work, n, NULL, NULL), DLS_OK);
    ck_assert_int_eq(dls_principal_solve(work, &dense, exact, NULL, NULL, NULL), DLS_OK);
    dls_principal_destroy(work);
    dls_principal_settings settings = active_defaults(&c);
    for (int steps = 0; steps <= 10; steps += 10) {
      settings.block_steps = steps;
      const dls_principal_info info = active_solve(&c, &settings, z, NULL);
      ck_assert_int_eq(info.status, DLS_OK);
      ck_assert(steps > 0 || info.path_steps > 0);
      assert_near(z, exact, n, 1e-13);
    }
    drop(&c);
  }
}

/* The number of factorisations hardly grows with the mesh; without sweeps it is that of layers.
 * Without MUMPS factors are dense, and the meshes smaller. */
TEST(membranes) {
  for (int wind = 0; wind < 2; wind++)
    for (int side = 20; side <= (WITH_MUMPS ? 80 : TEST_SMALL ? 20 : 40); side *= 2) {
      columns c = membrane(side, wind * .3);
      double *z = calloc(2 * (size_t)c.n, sizeof *z), *y = z + c.n;
      const dls_principal_info info = active_solve(&c, NULL, z, y);
      ck_assert_int_eq(info.status, DLS_OK);
      ck_assert_int_eq(info.path_steps, 0);
      ck_assert_int_le(info.factorizations, 8);
      ck_assert_double_le(residual(&c, z), 1e-13);
      int touches = 0;
      for (int i = 0; i < c.n; i++) {
        ck_assert(z[i] >= 0 && y[i] >= -1e-12);
        touches += z[i] == 0;
      }
      ck_assert(touches > 0 && touches < c.n);
      free(z);
      drop(&c);
    }
}

/* Rounds would move each border by a node: the path takes their place. */
TEST(optimal_stopping) {
  for (int n = 500; n <= (WITH_MUMPS ? 8000 : 500); n *= 4) {
    columns c = stopping(n);
    double *z = calloc((size_t)n, sizeof *z);
    const dls_principal_info info = active_solve(&c, NULL, z, NULL);
    ck_assert_int_eq(info.status, DLS_OK);
    ck_assert_int_le(info.iterations, 60);
    ck_assert_double_le(residual(&c, z), 1e-13);
    int first = 0; /* stop below a price, go on above */
    while (first < n && z[first] == 0)
      first++;
    ck_assert(first > 0 && first < n);
    free(z);
    drop(&c);
  }
}

/* Block pivots alone cycle on these (data/failures l03, l04). */
TEST(where_block_pivots_cycle) {
  const double unsymmetric[9] = {1, 0, 3, 3, 2, 1, -3, -1, 1}, p[3] = {1, 2, -4};
  const double symmetric[9] = {6, -3, 5, -3, 2, -2, 5, -2, 5}, q[3] = {4, -3, 1};
  const double answer[2][3] = {{1.1, 0, 0.7}, {0, 13.0 / 6, 2.0 / 3}};
  for (int k = 0; k < 2; k++)
    for (int steps = 0; steps <= 10; steps += 5) {
      columns c = k ? from_dense(3, symmetric, q) : from_dense(3, unsymmetric, p);
      dls_principal_settings settings = active_defaults(&c);
      settings.block_steps = steps;
      double z[3];
      ck_assert_int_eq(active_solve(&c, &settings, z, NULL).status, DLS_OK);
      for (int i = 0; i < 3; i++)
        ck_assert_double_eq_tol(z[i], answer[k][i], 1e-14);
      drop(&c);
    }
}

/* min |x - c|^2 / 2, A x <= b, x >= 0 with its multipliers l: M = (I A^T; -A 0) is positive
 * semidefinite, and M_AA singular for most A. x is the only one, and what Lemke's method finds. */
TEST(quadratic_programs) {
  enum { x = 30, l = 12, n = x + l };
  static double M[n * n], q[n], z[n], other[n];
  for (int trial = 0; trial < 20; trial++) {
    memset(M, 0, sizeof M);
    for (int i = 0; i < x; i++) {
      M[i + n * i] = 1;
      q[i] = -1 - centred();
    }
    for (int k = 0; k < l; k++) {
      for (int i = 0; i < x; i++) {
        const double a = centred() > .4 ? 1 + centred() : 0;
        M[i + n * (x + k)] = a;
        M[x + k + n * i] = -a;
      }
      q[x + k] = 1 + centred() / 2;
    }
    columns c = from_dense(n, M, q);
    const dls_lcp dense = {.n = n, .M = {n, n, n, M}, .q = q};
    const dls_principal_info info = active_solve(&c, NULL, z, NULL);
    ck_assert_int_eq(info.status, DLS_OK);
    dls_lemke *lemke;
    ck_assert_int_eq(dls_lemke_create(&lemke, n, NULL, NULL), DLS_OK);
    ck_assert_int_eq(dls_lemke_solve(lemke, &dense, other, NULL, NULL, NULL), DLS_OK);
    dls_lemke_destroy(lemke);
    assert_near(z, other, x, 1e-7);
    drop(&c);
  }
}

TEST(matrices_that_are_no_p_matrices) {
  const double ones[4] = {1, 1, 1, 1}, negative[1] = {-1}, minus[2] = {-1, -1};
  double z[2];
  columns c = from_dense(2, ones, minus); /* z_0 + z_1 = 1: the path goes between */
  ck_assert_int_eq(active_solve(&c, NULL, z, NULL).status, DLS_OK);
  ck_assert_double_eq_tol(z[0] + z[1], 1, 1e-8);
  drop(&c);
  c = from_dense(1, negative, minus); /* y = -z - 1: no solution */
  const dls_principal_info info = active_solve(&c, NULL, z, NULL);
  ck_assert_int_eq(info.status, DLS_STALLED);
  ck_assert_double_eq_tol(info.certificate.residual, 1, 1e-15);
  ck_assert(z[0] == 0);
  drop(&c);
  c = start(2, 1); /* M = 0 */
  c.q[0] = 1;
  ck_assert_int_eq(active_solve(&c, NULL, z, NULL).status, DLS_OK);
  ck_assert(z[0] == 0 && z[1] == 0);
  c.q[1] = -1;
  ck_assert_int_eq(active_solve(&c, NULL, z, NULL).status, DLS_STALLED);
  drop(&c);
}

TEST(warm_starts_units_and_bits) {
  columns c = membrane(40, .2);
  const size_t bytes = (size_t)c.n * sizeof(double);
  double *cold = calloc(2 * (size_t)c.n, sizeof *cold), *z = cold + c.n;
  const dls_principal_info info = active_solve(&c, NULL, cold, NULL);
  ck_assert_int_eq(active_solve(&c, NULL, z, NULL).factorizations, info.factorizations);
  ck_assert_mem_eq(z, cold, bytes);
  dls_principal_settings settings = active_defaults(&c);
  settings.limits.warm_start = 1;
  const dls_principal_info warm = active_solve(&c, &settings, z, NULL);
  ck_assert(warm.status == DLS_OK && warm.iterations == 0 && warm.factorizations == 1);
  ck_assert_mem_eq(z, cold, bytes);
  const double factor[] = {1e-9, 1e-3, 1e9};
  for (int f = 0; f < 9; f++) {
    const double force = factor[f % 3], length = factor[f / 3];
    columns other = membrane(40, .2);
    for (int k = 0; k < c.count; k++)
      other.x[k] *= length / force;
    for (int i = 0; i < c.n; i++)
      other.q[i] *= length;
    const dls_principal_info same = active_solve(&other, NULL, z, NULL);
    ck_assert_int_eq(same.status, DLS_OK);
    ck_assert_int_eq(same.iterations, info.iterations);
    for (int i = 0; i < c.n; i++)
      ck_assert_double_eq_tol(z[i] / force, cold[i], 1e-12);
    drop(&other);
  }
  free(cold);
  drop(&c);
}

/* ---- limits ---------------------------------------------------------------------------------- */

static int stop_at_third(void *data, const dls_progress *p) {
  int *calls = data;
  ck_assert_str_eq(p->method, "principal");
  if (p->last) return 0;
  ck_assert_int_eq(p->iteration, *calls);
  return ++*calls == 3;
}

TEST(limits) {
  columns c = stopping(2000);
  double *z = calloc((size_t)c.n, sizeof *z);
  for (int steps = 0; steps <= 10; steps += 10) {
    int calls = 0;
    dls_principal_settings settings = active_defaults(&c);
    settings.block_steps = steps;
    settings.limits.max_iterations = 2;
    dls_principal_info info = active_solve(&c, &settings, z, NULL);
    ck_assert_int_eq(info.status, DLS_MAX_ITERATIONS);
    ck_assert_int_eq(info.iterations, 2);
    ck_assert_double_eq_tol(residual(&c, z), info.certificate.residual, 1e-12);
    ck_assert_double_gt(info.certificate.residual, 1e-8);
    settings.limits.max_iterations = 0;
    settings.limits.progress = stop_at_third;
    settings.limits.progress_data = &calls;
    info = active_solve(&c, &settings, z, NULL);
    ck_assert(info.status == DLS_CANCELLED && info.iterations == 2 && calls == 3);
    settings.limits.progress = NULL;
    settings.limits.cpu_seconds = 1e-9;
    ck_assert_int_eq(active_solve(&c, &settings, z, NULL).status, DLS_TIME_LIMIT);
  }
  free(z);
  drop(&c);
}

/* ---- the certificate ------------------------------------------------------------------------- */

TEST(certificate_is_that_of_the_dense_matrix) {
  enum { n = 12 };
  double M[n * n], z[n], y[n], other[n];
  for (int trial = 0; trial < 50; trial++) {
    columns c = start(n, 4 * n);
    for (int j = 0; j < n; j++) {
      if (j % 3) add(&c, j, centred()); /* each third diagonal entry is 0 */
      if (j % 5) add(&c, (j + 5) % n, centred());
      if (j % 2) add(&c, (j + 2) % n, centred());
      end_column(&c, j);
      c.q[j] = centred();
      z[j] = fmax(centred(), 0);
    }
    fill_dense(&c, M);
    const dls_lcp sparse = view(&c), dense = {.n = n, .M = {n, n, n, M}, .q = c.q};
    dls_lcp_certificate a, b;
    ck_assert_int_eq(dls_lcp_certify(&sparse, z, y, &a, NULL), DLS_OK);
    ck_assert_int_eq(dls_lcp_certify(&dense, z, other, &b, NULL), DLS_OK);
    ck_assert_double_eq_tol(a.residual, b.residual, 1e-15);
    ck_assert_double_eq_tol(a.floor, b.floor, 1e-30);
    ck_assert(a.worst == b.worst && a.negative_y == b.negative_y);
    ck_assert_mem_eq(y, other, sizeof y);
    drop(&c);
  }
}

/* ---- refusals -------------------------------------------------------------------------------- */

TEST(bad_input) {
  columns c = membrane(3, 0);
  double z[9] = {7}, dense[81] = {0};
  dls_error error;
  dls_lcp_certificate certificate;
  const double nan = NAN, kept = c.x[4];
  const int at = c.i[4];
  dls_lcp lcp = view(&c);
  dls_principal *work;
  dls_principal_settings settings = active_defaults(&c);
  ck_assert_int_eq(dls_principal_create(&work, c.n, &settings, NULL), DLS_OK);
#define REFUSED(status, argument, index)                                                           \
  do {                                                                                             \
    expect_error(dls_principal_solve(work, &lcp, z, NULL, NULL, &error), &error, status,           \
                 "dls_principal_solve", argument, index);                                          \
    expect_error(dls_lcp_check(&lcp, &error), &error, status, "dls_lcp_check", argument, index);   \
    ck_assert(z[0] == 7);                                                                          \
  } while (0)
  c.x[4] = nan;
  REFUSED(DLS_E_NOT_FINITE, "Ms", 4);
  c.x[4] = kept;
  c.i[4] = 9;
  REFUSED(DLS_E_ARGUMENT, "Ms", 4);
  c.i[4] = at;
  c.q[2] = nan;
  REFUSED(DLS_E_NOT_FINITE, "q", 2);
  c.q[2] = 1;
  lcp.Ms.cols = 8;
  REFUSED(DLS_E_SIZE, "Ms", -1);
  lcp.Ms.cols = 9;
  lcp.M = (dls_dense){9, 9, 9, dense};
  REFUSED(DLS_E_ARGUMENT, "Ms", -1);
  /* what create was told of */
  lcp.Ms = (dls_sparse){0};
  REFUSES(SIZE, "M", -1, dls_principal_solve, work, &lcp, z, NULL, NULL);
  dls_principal_destroy(work);
  lcp = view(&c);
  for (int few = 0; few < 2; few++) {
    settings.limits.blocks = few ? c.count - 1 : 0;
    ck_assert_int_eq(dls_principal_create(&work, c.n, &settings, NULL), DLS_OK);
    REFUSES(SIZE, "Ms", -1, dls_principal_solve, work, &lcp, z, NULL, NULL);
    dls_principal_destroy(work);
  }
  settings.limits.blocks = INT_MAX;
  REFUSES(SIZE, "blocks", -1, dls_principal_create, &work, 9, &settings);
  ck_assert(!work);
  /* functions of a dense M */
  dls_lemke *lemke;
  dls_enumeration found;
  ck_assert_int_eq(dls_lemke_create(&lemke, 9, NULL, NULL), DLS_OK);
  REFUSES(UNSUPPORTED, "Ms", -1, dls_lemke_solve, lemke, &lcp, z, NULL, NULL);
  dls_lemke_destroy(lemke);
  REFUSES(UNSUPPORTED, "Ms", -1, dls_lcp_enumerate, &lcp, 0, 1, z, &found);
  REFUSES(UNSUPPORTED, "Ms", -1, dls_lcp_check_farkas, &lcp, z, z);
  REFUSES(UNSUPPORTED, "Ms", -1, dls_lcp_check_ray, &lcp, z, z, 1, z, 1, z);
  ck_assert(z[0] == 7);
  ck_assert_int_eq(dls_lcp_certify(&lcp, dense, NULL, &certificate, NULL), DLS_OK);
  drop(&c);
}

/* Beyond 250 unknowns the factor is MUMPS', below it is ours. */
TEST(each_malloc_fails) {
  for (int side = 6; side <= 20; side += 14)
    for (int steps = 0; steps <= 10; steps += 10) {
      columns c = membrane(side, .1);
      const dls_lcp lcp = view(&c);
      dls_principal_settings settings = active_defaults(&c);
      settings.block_steps = steps;
      double *z = calloc((size_t)c.n, sizeof *z);
      dls_principal *work = NULL;
      dls_status status = DLS_E_MEMORY;
      long k = 0;
      while (status) {
        malloc_fails_at(++k);
        status = dls_principal_create(&work, c.n, &settings, NULL);
        malloc_fails_at(0);
        ck_assert(status == DLS_E_MEMORY ? !work : status == DLS_OK);
      }
      ck_assert_int_gt(k, 3);
      dls_error error = {0};
      for (k = 1, status = DLS_E_MEMORY; status && k < 5000; k++) {
        z[0] = 7;
        malloc_fails_at(k);
        status = dls_principal_solve(work, &lcp, z, NULL, NULL, &error);
        malloc_fails_at(0);
        if (!status) break;
        ck_assert(status == DLS_E_MEMORY && error.status == DLS_E_MEMORY && z[0] == 7);
      }
      ck_assert_int_eq(status, DLS_OK);
      ck_assert_int_gt(k, 3);
      ck_assert_double_le(residual(&c, z), 1e-13);
      dls_principal_destroy(work);
      free(z);
      drop(&c);
    }
}
