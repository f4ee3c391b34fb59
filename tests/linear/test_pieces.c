/*
 * test_pieces.c: products and factors in pieces: against definitions and whole calls of BLAS, the
 * same bits with any number of threads of the BLAS, none of which wakes.
 */
#define _POSIX_C_SOURCE 200809L /* CLOCK_PROCESS_CPUTIME_ID */

#include <time.h>

#include "cases.h"
#include "linear/blas.h"
#include "linear/pieces.h"
#include "run.h"

enum { side = 150, gap = 3 }; /* gap: leading dimension beyond the rows */

/* below, at and above the sizes of pieces.c */
static const int sizes[] = {0, 1, 2, 15, 16, 17, 32, 33, 48, 49, 63, 64, 65, 100, 150};
enum { size_count = sizeof sizes / sizeof sizes[0] };

typedef struct matrices {
  double A[(side + gap) * side], B[(side + gap) * side], C[(side + gap) * side],
      D[(side + gap) * side];
} matrices;

static matrices *of;

static void pieces_begin(void) {
  of = malloc(sizeof *of);
  ck_assert_ptr_nonnull(of);
  set_seed(5);
  double *all = of->A;
  for (size_t k = 0; k < sizeof *of / sizeof(double); k++)
    all[k] = uniform();
}

static void pieces_end(void) {
  free(of);
}

static double at(const double *A, int ld, char trans, int i, int j) {
  return trans == 'N' ? A[i + ld * j] : A[j + ld * i];
}

/* Asserts that C is `expected` to rounding within rows x columns, and beyond it to the last bit. */
static void expect_close(const double *C, const double *expected, int rows, int columns, int lower,
                         double tol) {
  const size_t ld = side + gap;
  for (size_t j = 0; j < (size_t)side; j++) {
    const size_t first = lower ? j : 0, last = j < (size_t)columns ? (size_t)rows : first;
    const double *c = C + ld * j, *e = expected + ld * j;
    for (size_t i = first; i < last; i++) /* an assertion writes to a file */
      if (!(fabs(c[i] - e[i]) <= tol)) ck_abort_msg("(%zu, %zu): %g, not %g", i, j, c[i], e[i]);
    const size_t above = first < last ? first : 0, below = first < last ? last : 0;
    ck_assert(memcmp(c, e, above * sizeof *c) == 0);
    ck_assert(memcmp(c + below, e + below, (ld - below) * sizeof *c) == 0);
  }
}

TEST_EACH(products, 0, size_count *size_count) {
  const int m = sizes[_i % size_count], n = sizes[_i / size_count], ld = side + gap;
  static const int terms[] = {0, 1, 30, 64, 65, 150};
  for (int t = 0; t < 24; t++) {
    const int k = terms[t / 4];
    const char ta = t % 2 ? 'T' : 'N', tb = t % 4 / 2 ? 'T' : 'N';
    const double alpha = -0.5, beta = t % 3 == 0 ? 0 : 2;
    memcpy(of->C, of->B, sizeof of->C);
    memcpy(of->D, of->B, sizeof of->D);
    dlsi_gemm(1, ta, tb, m, n, k, alpha, of->A, ld, of->B, ld, beta, of->C, ld);
    dgemm_(&ta, &tb, &m, &n, &k, &alpha, of->A, &ld, of->B, &ld, &beta, of->D, &ld, 1, 1);
    expect_close(of->C, of->D, m, n, 0, 1e-12);
  }
}

TEST_EACH(products_of_one_matrix, 0, size_count) {
  const int n = sizes[_i], ld = side + gap;
  for (int k = 1; k <= side; k += 66) {
    memcpy(of->D, of->C, sizeof of->D);
    dlsi_syrk(1, n, k, -1, of->A, ld, 0.5, of->C, ld);
    for (int j = 0; j < n; j++)
      for (int i = j; i < n; i++) {
        double *d = &of->D[(size_t)i + (size_t)ld * (size_t)j], sum = 0;
        for (int l = 0; l < k; l++)
          sum += at(of->A, ld, 'N', i, l) * at(of->A, ld, 'N', j, l);
        *d = 0.5 * *d - sum;
      }
    expect_close(of->C, of->D, n, n, 1, 1e-12);
  }
  double y[side], expected[side];
  for (int i = 0; i < n; i++)
    y[i] = of->B[i];
  for (int k = 1; n > 0 && k <= side; k += 74) {
    for (int i = 0; i < n; i++) {
      expected[i] = 2 * y[i];
      for (int j = 0; j < k; j++)
        expected[i] -= of->A[i + n * j] * of->C[j];
    }
    dlsi_gemv(1, n, k, -1, of->A, of->C, 2, y);
    for (int i = 0; i < n; i++)
      ck_assert_double_le(fabs(y[i] - expected[i]), 1e-12);
  }
}

TEST_EACH(triangles, 0, size_count *size_count) {
  static const struct {
    char side, uplo, trans, diag;
  } kinds[] = {{'L', 'L', 'N', 'N'}, {'L', 'L', 'N', 'U'}, {'L', 'L', 'T', 'N'},
               {'L', 'U', 'N', 'N'}, {'L', 'U', 'T', 'N'}, {'R', 'L', 'T', 'N'}};
  const int rows = sizes[_i % size_count], other = sizes[_i / size_count], ld = side + gap;
  for (size_t k = 0; k < sizeof of->A / sizeof(double); k++)
    of->A[k] /= side;
  for (int k = 0; k < side; k++)
    of->A[(size_t)k * (size_t)(ld + 1)] = 1.5 + 0.5 * uniform();
  for (size_t k = 0; k < sizeof kinds / sizeof kinds[0]; k++) {
    const char s = kinds[k].side, uplo = kinds[k].uplo, trans = kinds[k].trans,
               diag = kinds[k].diag;
    const int m = s == 'L' ? rows : other, n = s == 'L' ? other : rows;
    const double one = 1;
    memcpy(of->C, of->B, sizeof of->C);
    memcpy(of->D, of->B, sizeof of->D);
    dlsi_trsm(1, s, uplo, trans, diag, m, n, of->A, ld, of->C, ld);
    dtrsm_(&s, &uplo, &trans, &diag, &m, &n, &one, of->A, &ld, of->D, &ld, 1, 1, 1, 1);
    expect_close(of->C, of->D, m, n, 0, 1e-13);
  }
}

/* Makes A definite, or unsymmetric. */
static void make_regular(int n, int definite) {
  const size_t ld = side + gap;
  for (size_t j = 0; j < (size_t)n; j++)
    for (size_t i = 0; i < (size_t)n; i++)
      if (definite && i > j) of->A[j + ld * i] = of->A[i + ld * j];
  for (size_t j = 0; definite && j < (size_t)n; j++)
    of->A[j * (ld + 1)] = n;
}

/* L L^T = A below the diagonal; the upper triangle stays, and the pivot that fails is told. */
TEST_EACH(cholesky, 0, size_count) {
  const int n = sizes[_i], ld = side + gap;
  make_regular(n, 1);
  memcpy(of->C, of->A, sizeof of->C);
  memcpy(of->D, of->A, sizeof of->D);
  ck_assert_int_eq(dlsi_potrf(1, n, of->C, ld), 0);
  ck_assert_int_eq(dlsi_potrf(0, n, of->D, ld), 0);
  expect_close(of->C, of->D, n, n, 1, 1e-13 * side);
  for (int k = 0; k < n; k += 1 + n / 9) {
    memcpy(of->C, of->A, sizeof of->C);
    of->C[(size_t)k * (size_t)(ld + 1)] = -1;
    ck_assert_int_eq(dlsi_potrf(1, n, of->C, ld), k + 1);
  }
}

TEST_EACH(gauss, 0, size_count) {
  const int n = sizes[_i], ld = side + gap;
  int pivot[side], whole[side];
  make_regular(n, 0);
  memcpy(of->C, of->A, sizeof of->C);
  memcpy(of->D, of->A, sizeof of->D);
  ck_assert_int_eq(dlsi_getrf(1, n, of->C, ld, pivot), 0);
  ck_assert_int_eq(dlsi_getrf(0, n, of->D, ld, whole), 0);
  ck_assert(memcmp(pivot, whole, (size_t)n * sizeof *pivot) == 0);
  expect_close(of->C, of->D, n, n, 0, 1e-10);
  for (int nrhs = 1; nrhs < 12; nrhs += 5) { /* A (A^-1 B) = B */
    static double X[(side + gap) * 12];
    memcpy(X, of->B, sizeof X);
    dlsi_getrs(1, n, nrhs, of->C, ld, pivot, X, ld);
    for (int j = 0; j < nrhs; j++)
      for (int i = 0; i < n; i++) {
        double left = -of->B[i + ld * j];
        for (int l = 0; l < n; l++)
          left += at(of->A, ld, 'N', i, l) * X[l + ld * j];
        ck_assert_double_le(fabs(left), 1e-9);
      }
  }
  for (int k = 0; k < n; k += 1 + n / 9) { /* a column that the ones before it span: zero */
    memcpy(of->C, of->A, sizeof of->C);
    memset(of->C + (size_t)k * (size_t)ld, 0, (size_t)n * sizeof(double));
    ck_assert_int_eq(dlsi_getrf(1, n, of->C, ld, pivot), k + 1);
  }
  of->C[0] = NAN; /* no exchange leaves the matrix */
  for (int j = 1; j < n; j++)
    of->C[(size_t)j * (size_t)ld] = INFINITY;
  (void)dlsi_getrf(1, n, of->C, ld, pivot);
  for (int i = 0; i < n; i++)
    ck_assert(pivot[i] > i && pivot[i] <= n);
}

/* ---- threads --------------------------------------------------------------------------------- */

/* Is in OpenBLAS alone. */
extern void openblas_set_num_threads(int count) __attribute__((weak));

static double seconds_of(clockid_t clock) {
  struct timespec t;
  ck_assert_int_eq(clock_gettime(clock, &t), 0);
  return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

/* CPU time of all threads but this one */
static double others_seconds(void) {
  return seconds_of(CLOCK_PROCESS_CPUTIME_ID) - seconds_of(CLOCK_THREAD_CPUTIME_ID);
}

/* Every function on matrices of n rows; C and D := results. */
static void do_all(int alone, int n) {
  const int ld = side + gap;
  int pivot[side];
  make_regular(n, 1);
  dlsi_gemm(alone, 'N', 'T', n, n, n, 1, of->A, ld, of->B, ld, 0, of->D, ld);
  dlsi_syrk(alone, n, n, 1, of->B, ld, 1, of->D, ld);
  dlsi_gemv(alone, n, n, 1, of->A, of->B, 1, of->D);
  dlsi_trsm(alone, 'L', 'L', 'N', 'N', n, n, of->A, ld, of->D, ld);
  memcpy(of->C, of->A, sizeof of->C);
  ck_assert_int_eq(dlsi_potrf(alone, n, of->C, ld), 0);
  dlsi_trsm(alone, 'R', 'L', 'T', 'N', n, n, of->C, ld, of->D, ld);
  memcpy(of->C, of->A, sizeof of->C);
  ck_assert_int_eq(dlsi_getrf(alone, n, of->C, ld, pivot), 0);
  dlsi_getrs(alone, n, n, of->C, ld, pivot, of->D, ld);
}

TEST(threads_sleep) {
  const struct timespec rest = {0, 300000000};
  static matrices before, first;
  if (!openblas_set_num_threads) return;
  memcpy(&before, of, sizeof before);
  for (int n = 90; n <= side; n += 60) {
    for (int threads = 1; threads <= 2; threads++) {
      openblas_set_num_threads(threads);
      nanosleep(&rest, NULL);  /* new threads look for work for a while */
      double least = INFINITY; /* a switch between both clocks counts as work of others */
      for (int turn = 0; turn < 3; turn++) {
        memcpy(of, &before, sizeof before);
        const double begun = others_seconds();
        do_all(1, n);
        least = fmin(least, others_seconds() - begun);
      }
      ck_assert_double_le(least, 1e-4);
      if (threads == 1) memcpy(&first, of, sizeof first);
    }
    ck_assert(memcmp(&first, of, sizeof first) == 0);
  }
  openblas_set_num_threads(1);
}

TEST(small_is_a_thousand_rows) {
  ck_assert(dlsi_is_small(0) && dlsi_is_small(1000 * 1000) && !dlsi_is_small(1000 * 1000 + 1));
  for (int i = 0; i < size_count; i += 3) /* as a whole: whatever is large */
    do_all(0, sizes[i]);
}

int main(void) {
  return run_tests("pieces", pieces_begin, pieces_end);
}
