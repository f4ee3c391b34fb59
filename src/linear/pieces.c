/*
 * pieces.c: products and factors of small matrices, on the thread that calls.
 *
 *   product     C in blocks, each one dgemm with m n k <= 64^3 in runs of 64 terms
 *   triangles   (PC1)  halves T = (T_11, 0; T_21, T_22):
 *                      B_1 := T_11^-1 B_1,  B_2 := T_22^-1 (B_2 - T_21 B_1)
 *   Cholesky    (PC2)  L_11 := chol(A_11),  L_21 := A_21 L_11^-T,  L_22 := chol(A_22 - L_21 L_21^T)
 *   Gauss       (PC3)  (L_11; L_21) U_11 := P_1 (A_11; A_21),  U_12 := L_11^-1 (P_1 A)_12,
 *                      L_22 U_22 := P_2 ((P_1 A)_22 - L_21 U_12)
 *
 * where each half is halved again down to the sizes below (Toledo, SIAM J. Matrix Anal. Appl. 18,
 * 1997, 1065-1081). At these sizes OpenBLAS stays on the calling thread: up to 64^3 products in
 * dgemm, fewer than 96^2 entries in dgemv, fewer than 1024 in the B of dtrsm, fewer than 64 rows in
 * dpotrf, fewer than 100 in dsyrk; dgetf2 and dtrsv wake no thread. Cost on one thread: about that
 * of LAPACK (docs/threads.md).
 */
#include "linear/pieces.h"

#include <limits.h>

#include "linear/blas.h"

enum {
  small_rows = 1000,
  product_most = 64 * 64 * 64, /* m n k of one dgemm */
  product_side = 64,
  vector_most = 96 * 96 - 1, /* entries of A of one dgemv */
  triangle_most = 1023,      /* entries of B of one dtrsm */
  triangle_rows = 32,
  cholesky_rows = 48,
  gauss_columns = 16
};

int dlsi_is_small(size_t entries) {
  return entries <= (size_t)small_rows * small_rows;
}

static int least(int a, int b) {
  return a < b ? a : b;
}

/* Returns the size of a first half of n > 8: a multiple of 8, so that columns match the lines of
 * the cache. */
static int half(int n) {
  return (n / 2 + 7) / 8 * 8;
}

void dlsi_gemm(int alone, char transa, char transb, int m, int n, int k, double alpha,
               const double *A, int lda, const double *B, int ldb, double beta, double *C,
               int ldc) {
  const size_t a = (size_t)lda, b = (size_t)ldb, c = (size_t)ldc;
  const int terms = alone && k > 0 ? least(k, product_side) : k;
  const int columns = alone && n > 0 ? least(n, product_side) : n;
  const int rows = alone && n > 0 && k > 0 ? least(m, product_most / (columns * terms)) : m;
  int p = 0;
  do { /* once for k = 0, too: C := beta C */
    const int K = least(terms, k - p);
    const double add = p == 0 ? beta : 1;
    for (int j = 0; j < n; j += columns) {
      const int N = least(columns, n - j);
      const double *Bj =
          transb == 'N' ? B + (size_t)p + (size_t)j * b : B + (size_t)j + (size_t)p * b;
      for (int i = 0; i < m; i += rows) {
        const int M = least(rows, m - i);
        const double *Ai =
            transa == 'N' ? A + (size_t)i + (size_t)p * a : A + (size_t)p + (size_t)i * a;
        dgemm_(&transa, &transb, &M, &N, &K, &alpha, Ai, &lda, Bj, &ldb, &add,
               C + (size_t)i + (size_t)j * c, &ldc, 1, 1);
      }
    }
    p += terms;
  } while (p < k);
}

void dlsi_syrk(int alone, int n, int k, double alpha, const double *A, int lda, double beta,
               double *C, int ldc) {
  const int side = alone ? product_side : n;
  for (int j = 0; j < n; j += side) {
    const int N = least(side, n - j), below = n - j - N;
    double *Cj = C + (size_t)j * ((size_t)ldc + 1);
    dsyrk_("L", "N", &N, &k, &alpha, A + j, &lda, &beta, Cj, &ldc, 1, 1);
    if (below > 0)
      dlsi_gemm(alone, 'N', 'T', below, N, k, alpha, A + j + N, lda, A + j, lda, beta, Cj + N, ldc);
  }
}

void dlsi_gemv(int alone, int m, int n, double alpha, const double *A, const double *x, double beta,
               double *y) {
  const int one = 1, some = alone && m > 0 ? vector_most / m : n;
  const int columns = some > 0 ? some : 1;
  for (int j = 0; j < n; j += columns) {
    const int N = least(columns, n - j);
    const double add = j == 0 ? beta : 1;
    dgemv_("N", &m, &N, &alpha, A + (size_t)j * (size_t)m, &m, x + j, &one, &add, y, &one, 1);
  }
}

/* One triangle of at most triangle_rows rows; or of any size, if not alone. */
static void triangle_of_blas(int alone, char side, char uplo, char trans, char diag, int m, int n,
                             const double *T, int ldt, double *B, int ldb) {
  const double one = 1;
  const int left = side == 'L', across = left ? n : m;
  const int most = alone ? triangle_most / (left ? m : n) : across;
  const size_t step = left ? (size_t)ldb : 1;
  for (int j = 0; j < across; j += most) {
    const int some = least(most, across - j);
    dtrsm_(&side, &uplo, &trans, &diag, left ? &m : &some, left ? &some : &n, &one, T, &ldt,
           B + (size_t)j * step, &ldb, 1, 1, 1, 1);
  }
}

void dlsi_trsm(int alone, char side, char uplo, char trans, char diag, int m, int n,
               const double *T, int ldt, double *B, int ldb) {
  const int left = side == 'L', rows = left ? m : n; /* of T */
  if (m == 0 || n == 0) return;
  if (!alone || rows <= triangle_rows) {
    triangle_of_blas(alone, side, uplo, trans, diag, m, n, T, ldt, B, ldb);
    return;
  }
  /* B_2 comes before B_1 if T_12 or T_21^T is above the diagonal, on the left */
  const int backward = left && (uplo == 'L') != (trans == 'N');
  const int h = half(rows), one = backward ? rows - h : h, two = rows - one;
  const size_t H = (size_t)h, t = (size_t)ldt;
  const double *beside = uplo == 'L' ? T + H : T + H * t, *T22 = T + H * (t + 1);
  double *B2 = B + (left ? H : H * (size_t)ldb);
  double *from = backward ? B2 : B, *to = backward ? B : B2;
  const double *first = backward ? T22 : T, *second = backward ? T : T22;
  if (left) { /* (PC1) */
    dlsi_trsm(1, side, uplo, trans, diag, one, n, first, ldt, from, ldb);
    dlsi_gemm(1, trans, 'N', two, n, one, -1, beside, ldt, from, ldb, 1, to, ldb);
    dlsi_trsm(1, side, uplo, trans, diag, two, n, second, ldt, to, ldb);
  } else {
    dlsi_trsm(1, side, uplo, trans, diag, m, one, first, ldt, from, ldb);
    dlsi_gemm(1, 'N', trans, m, two, one, -1, from, ldb, beside, ldt, 1, to, ldb);
    dlsi_trsm(1, side, uplo, trans, diag, m, two, second, ldt, to, ldb);
  }
}

int dlsi_potrf(int alone, int n, double *A, int ld) {
  int info = 0;
  if (n == 0) return 0;
  if (!alone || n <= cholesky_rows) {
    dpotrf_("L", &n, A, &ld, &info, 1);
    return info;
  }
  const int h = half(n), rest = n - h; /* (PC2) */
  double *A21 = A + h, *A22 = A + (size_t)h * ((size_t)ld + 1);
  info = dlsi_potrf(1, h, A, ld);
  if (info) return info;
  dlsi_trsm(1, 'R', 'L', 'T', 'N', rest, h, A, ld, A21, ld);
  dlsi_syrk(1, rest, h, -1, A21, ld, 1, A22, ld);
  info = dlsi_potrf(1, rest, A22, ld);
  return info ? info + h : 0;
}

int dlsi_piece_columns(double each) {
  const double columns = 4e9 / each;
  return columns >= INT_MAX ? INT_MAX : columns < 64 ? 64 : (int)columns;
}

/* From the left: all blocks of columns before a block update it. */
int dlsi_panel(int alone, int n, int rows, double *A, int ld, dlsi_watch *watch, int done) {
  const int height = n + rows, some = dlsi_piece_columns(2.0 * height * n);
  for (int j = 0; j < n; j += some) {
    const int N = least(some, n - j), below = height - j - N;
    double *Aj = A + (size_t)j * ((size_t)ld + 1);
    if (j > 0) {
      dlsi_syrk(alone, N, j, -1, A + j, ld, 1, Aj, ld);
      if (below > 0)
        dlsi_gemm(alone, 'N', 'T', below, N, j, -1, A + j + N, ld, A + j, ld, 1, Aj + N, ld);
    }
    const int info = dlsi_potrf(alone, N, Aj, ld);
    if (info) return j + info;
    dlsi_trsm(alone, 'R', 'L', 'T', 'N', below, N, Aj, ld, Aj + N, ld);
    if (dlsi_watch_stops(watch, done, 1.0 * N * below * (2.0 * j + N))) return dlsi_stopped;
  }
  return 0;
}

/* Exchanges the first `count` rows of A (n columns) with those in pivot. */
static void exchange_rows(int n, double *A, int ld, const int *pivot, int count) {
  for (int j = 0; j < n; j++, A += ld)
    for (int i = 0; i < count; i++) {
      const double a = A[i];
      A[i] = A[pivot[i] - 1];
      A[pivot[i] - 1] = a;
    }
}

/* (PC3) */
static int gauss_halves(int m, int n, double *A, int ld, int *pivot) {
  int info = 0;
  if (n <= gauss_columns) {
    dgetf2_(&m, &n, A, &ld, pivot, &info);
    return info;
  }
  const int h = half(n), rest = n - h;
  double *A21 = A + h, *A12 = A + (size_t)h * (size_t)ld, *A22 = A12 + h;
  info = gauss_halves(m, h, A, ld, pivot);
  exchange_rows(rest, A12, ld, pivot, h);
  dlsi_trsm(1, 'L', 'L', 'N', 'U', h, rest, A, ld, A12, ld);
  dlsi_gemm(1, 'N', 'N', m - h, rest, h, -1, A21, ld, A12, ld, 1, A22, ld);
  const int later = gauss_halves(m - h, rest, A22, ld, pivot + h);
  exchange_rows(h, A21, ld, pivot + h, rest);
  for (int i = h; i < n; i++)
    pivot[i] += h;
  return info ? info : later ? later + h : 0;
}

int dlsi_getrf(int alone, int n, double *A, int ld, int *pivot) {
  int info = 0;
  if (n == 0) return 0;
  if (alone) return gauss_halves(n, n, A, ld, pivot);
  dgetrf_(&n, &n, A, &ld, pivot, &info);
  return info;
}

void dlsi_getrs(int alone, int n, int nrhs, const double *A, int ld, const int *pivot, double *B,
                int ldb) {
  int info;
  if (!alone || nrhs == 1) {
    dgetrs_("N", &n, &nrhs, A, &ld, pivot, B, &ldb, &info, 1);
    return;
  }
  exchange_rows(nrhs, B, ldb, pivot, n);
  dlsi_trsm(1, 'L', 'L', 'N', 'U', n, nrhs, A, ld, B, ldb);
  dlsi_trsm(1, 'L', 'U', 'N', 'N', n, nrhs, A, ld, B, ldb);
}
