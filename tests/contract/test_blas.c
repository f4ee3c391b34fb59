/*
 * test_blas.c: a BLAS with two threads against a BLAS with one: every method, LCP solvers and
 * reductions have the same bits up to 1000 rows, and no thread of the BLAS wakes.
 * `test_blas CANDIDATES` prints CPU time and bits of each method instead (docs/threads.md).
 */
#define _POSIX_C_SOURCE 200809L /* CLOCK_PROCESS_CPUTIME_ID */

#include <time.h>

#include "cases.h"
#include "delassus.h"
#include "doors.h"
#include "made.h"
#include "reduced.h"
#include "run.h"

/* Is in OpenBLAS alone; with another BLAS the threads are those of its own variables. */
extern void openblas_set_num_threads(int count) __attribute__((weak));

static double blas_clock(clockid_t clock) {
  struct timespec t;
  (void)clock_gettime(clock, &t);
  return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

/* CPU time of all threads but this one */
static double seconds_of_others(void) {
  return blas_clock(CLOCK_PROCESS_CPUTIME_ID) - blas_clock(CLOCK_THREAD_CPUTIME_ID);
}

/* ---- problems -------------------------------------------------------------------------------- */

/* A dense problem with its storage. */
typedef struct dense_problem {
  dls_contact p;
  double *W, *q, *mu, *r, *u;
} dense_problem;

/* W = A A^T / m + I / 100, some candidates free, mu = 0.5. Returns 0 if there is no memory. */
static int dense_problem_make(dense_problem *a, int d, int nc) {
  const int m = d * nc;
  const size_t n = (size_t)m;
  double *A = malloc(n * n * sizeof *A);
  a->W = malloc(n * n * sizeof *a->W);
  a->q = calloc(4 * n, sizeof *a->q);
  if (!A || !a->W || !a->q) return 0;
  a->mu = a->q + n, a->r = a->q + 2 * n, a->u = a->q + 3 * n;
  set_seed(2);
  for (size_t k = 0; k < n * n; k++)
    A[k] = uniform();
  gram(m, A, 0.01, a->W);
  free(A);
  for (int k = 0; k < m; k++) {
    a->q[k] = uniform() - (k % d == 0 ? 0.4 : 0);
    a->mu[k] = 0.5;
  }
  a->p = (dls_contact){.d = d, .nc = nc, .W = {m, m, m, a->W}, .q = a->q, .mu = a->mu};
  return 1;
}

static void dense_problem_free(dense_problem *a) {
  free(a->W);
  free(a->q);
}

/* ---- the same bits --------------------------------------------------------------------------- */

/* Does a task, which writes `count` numbers of its outcome to `out`, with one thread and with two,
 * and asserts the same bits. asleep: the second thread may not take any time. */
typedef struct blas_task {
  const char *name;
  size_t (*run)(const struct blas_task *self, double *out);
  int method, d, nc;
} blas_task;

enum { most_numbers = 4000 };

static void expect_same_bits(const blas_task *task, int asleep) {
  static double out[2][most_numbers];
  const struct timespec rest = {0, 300000000};
  size_t count[2];
  if (!openblas_set_num_threads) return;
  for (int k = 0; k < 2; k++) {
    openblas_set_num_threads(1 + k);
    nanosleep(&rest, NULL); /* a new thread looks for work for a while */
    const double begun = seconds_of_others();
    count[k] = task->run(task, out[k]);
    const double woken = seconds_of_others() - begun;
    ck_assert_uint_le(count[k], most_numbers);
    ck_assert_msg(!asleep || woken < 1e-4, "%s, %d: %g s of other threads", task->name, task->nc,
                  woken);
  }
  openblas_set_num_threads(1);
  ck_assert_uint_eq(count[0], count[1]);
  ck_assert_msg(memcmp(out[0], out[1], count[0] * sizeof(double)) == 0, "%s, %d: other bits",
                task->name, task->nc);
}

static size_t do_method(const blas_task *self, double *out) {
  const size_t n = (size_t)(self->d * self->nc);
  dense_problem a;
  dls_info info;
  ck_assert(dense_problem_make(&a, self->d, self->nc));
  dls_solver_settings settings = settings_with((dls_method)self->method, default_tol);
  if (n > 300) settings.limits.max_iterations = 200;
  const dls_status status = dls_solve(&a.p, &settings, a.r, a.u, &info, NULL);
  ck_assert_int_ge(status, 0);
  memcpy(out, a.r, n * sizeof *out);
  memcpy(out + n, a.u, n * sizeof *out);
  out[2 * n] = info.certificate.residual;
  out[2 * n + 1] = status;
  dense_problem_free(&a);
  return 2 * n + 2;
}

/* Lemke's method, with its start by sets and without, and principal pivoting. */
static size_t do_pivoting(const blas_task *self, double *out) {
  const int n = self->nc;
  const size_t N = (size_t)n;
  dense_problem a;
  dls_lemke_settings settings;
  dls_lemke *lemke = NULL;
  dls_principal *principal = NULL;
  ck_assert(dense_problem_make(&a, 1, n));
  const dls_lcp lcp = {.n = n, .M = a.p.W, .q = a.q};
  dls_lemke_settings_init(&settings);
  for (int crash = 0; crash < 2; crash++) {
    settings.crash = crash;
    ck_assert_int_eq(dls_lemke_create(&lemke, n, &settings, NULL), DLS_OK);
    ck_assert_int_eq(dls_lemke_solve(lemke, &lcp, out + (size_t)crash * N, NULL, NULL, NULL),
                     DLS_OK);
    dls_lemke_destroy(lemke);
  }
  ck_assert_int_eq(dls_principal_create(&principal, n, NULL, NULL), DLS_OK);
  ck_assert_int_eq(dls_principal_solve(principal, &lcp, out + 2 * N, NULL, NULL, NULL), DLS_OK);
  dls_principal_destroy(principal);
  dense_problem_free(&a);
  return 3 * N;
}

enum { sheet = 22, cells = sheet * sheet };

/* K of a sheet of springs on soft ground, in 5-point form, whose first row of unknowns may touch;
 * kind: an operator, with a factorisation. */
static size_t reduce(dls_operator kind, dls_factorization factorization, double *out) {
  static int p[cells + 1], i[5 * cells], Hp[sheet / 2 + 1], Ni[sheet / 2], Ti[sheet / 2];
  static double x[5 * cells], dense[cells * cells], ones[sheet / 2], f[cells], r[sheet],
      back[cells];
  const double skew = factorization == DLS_LU ? 0.3 : 0;
  int e = 0;
  set_seed(3);
  memset(dense, 0, sizeof dense);
  for (int j = 0; j < cells; j++) {
    const int reach[5] = {-sheet, -1, 0, 1, sheet};
    for (int k = 0; k < 5; k++) {
      const int to = j + reach[k];
      if (to < 0 || to >= cells) continue;
      const double value = k == 2 ? 4.1 : k < 2 ? -1 - skew : -1 + skew;
      i[e] = to;
      x[e++] = dense[to + j * cells] = value;
    }
    p[j + 1] = e;
    f[j] = uniform() - 0.5;
  }
  for (int c = 0; c < sheet / 2; c++) {
    Ni[c] = 2 * c;
    Ti[c] = 2 * c + 1;
    Hp[c + 1] = c + 1;
    ones[c] = 1;
    r[2 * c] = 1;
    r[2 * c + 1] = 0.5;
  }
  const dls_model body = {.d = 2,
                          .n = cells,
                          .nodes = sheet / 2,
                          .operator_kind = kind,
                          .factorization = factorization,
                          .K = {cells, cells, cells, dense},
                          .Ks = {cells, cells, p, i, x},
                          .HN = {cells, sheet / 2, Hp, Ni, ones},
                          .HT = {cells, sheet / 2, Hp, Ti, ones}};
  dls_reduction *reduction = NULL;
  dls_contact problem;
  ck_assert_int_eq(reduce_on_W(&reduction, &body, NULL, NULL), DLS_OK);
  ck_assert_int_eq(dls_reduction_load(reduction, f, NULL, NULL), DLS_OK);
  ck_assert_int_eq(dls_reduction_contact(reduction, ones, &problem, NULL), DLS_OK);
  ck_assert_int_eq(dls_reduction_recover(reduction, r, back, NULL), DLS_OK);
  memcpy(out, problem.W.a, sheet * sheet * sizeof *out);
  memcpy(out + sheet * sheet, back, sizeof back);
  dls_reduction_destroy(reduction);
  return sheet * sheet + cells;
}

static size_t do_reduction(const blas_task *self, double *out) {
  return reduce((dls_operator)self->d, (dls_factorization)self->nc, out);
}

TEST_EACH(methods, 0, method_count()) {
  static const int sizes[][2] = {{3, 30}, {2, 90}, {3, 110}};
  const int method = _i % method_count();
  for (size_t k = 0; k < sizeof sizes / sizeof sizes[0]; k++) {
    const int d = sizes[k][0], nc = sizes[k][1];
    if (d * nc > 150 && (method == DLS_HOMOTOPY || method == DLS_LEMKE)) continue; /* slow */
    expect_same_bits(&(blas_task){dls_method_name((dls_method)method), do_method, method, d, nc},
                     1);
  }
}

TEST(pivoting) {
  expect_same_bits(&(blas_task){"pivoting", do_pivoting, 0, 1, 90}, 1);
  expect_same_bits(&(blas_task){"pivoting", do_pivoting, 0, 1, 310}, 1);
}

TEST_EACH(reductions, 0, 6) {
  static const int kinds[][2] = {
      {DLS_STIFFNESS_DENSE, DLS_CHOLESKY}, {DLS_STIFFNESS_DENSE, DLS_LU},
      {DLS_FLEXIBILITY, DLS_CHOLESKY},     {DLS_STIFFNESS_SPARSE, DLS_CHOLESKY},
      {DLS_STIFFNESS_SPARSE, DLS_LDLT},    {DLS_STIFFNESS_SPARSE, DLS_LU}};
  expect_same_bits(&(blas_task){"reduction", do_reduction, 0, kinds[_i][0], kinds[_i][1]}, 1);
}

/* ---- CPU time -------------------------------------------------------------------------------- */

/* Prints CPU time, of all threads of the process and least of five, and the last bits of r, of
 * each method on a dense problem in 3D with the given number of candidates. Waits after a solve,
 * so that threads of the BLAS that still wait for work are counted. */
static int print_blas(int nc) {
  enum { turns = 5 };
  const struct timespec rest = {0, 60000000};
  dense_problem a;
  if (!dense_problem_make(&a, 3, nc)) return 1;
  const int m = 3 * nc;
  for (int method = 0; method < method_count(); method++) {
    if (method == DLS_LEMKE || (method == DLS_HOMOTOPY && m > 150)) continue; /* slow */
    dls_solver_settings settings = settings_with((dls_method)method, default_tol);
    double least = 1e9;
    dls_status status = DLS_OK;
    for (int k = 0; k < turns; k++) {
      nanosleep(&rest, NULL);
      const double begun = blas_clock(CLOCK_PROCESS_CPUTIME_ID);
      status = dls_solve(&a.p, &settings, a.r, NULL, NULL, NULL);
      nanosleep(&rest, NULL);
      const double used = blas_clock(CLOCK_PROCESS_CPUTIME_ID) - begun;
      if (used < least) least = used;
    }
    unsigned long long bits = 0, word;
    for (int k = 0; k < m; k++) {
      memcpy(&word, a.r + k, sizeof word);
      bits = bits * 31 + word;
    }
    printf("%5d rows %-20s %7.2f ms of CPU, bits %04llx, %s\n", m,
           dls_method_name((dls_method)method), 1e3 * least, bits & 0xffff,
           dls_status_text(status));
  }
  dense_problem_free(&a);
  return 0;
}

/* test_blas [CANDIDATES] */
int main(int argc, char **argv) {
  if (argc == 2) return print_blas(atoi(argv[1]));
  return run_tests("blas", NULL, NULL);
}
