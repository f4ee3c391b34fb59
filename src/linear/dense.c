/* dense.c: Cholesky and LU of dense matrices by LAPACK. */
#include "linear/dense.h"

#include "linear/blas.h"

/* Compares in tiles: both triangles then stay in the cache. */
int dlsi_is_symmetric(const double *A, size_t n) {
  enum { tile = 32 };
  for (size_t j0 = 0; j0 < n; j0 += tile)
    for (size_t i0 = j0; i0 < n; i0 += tile)
      for (size_t j = j0; j < j0 + tile && j < n; j++)
        for (size_t i = i0; i < i0 + tile && i < n; i++)
          if (A[i + n * j] != A[j + n * i]) return 0;
  return 1;
}

int dlsi_dense_cholesky(dlsi_dense *f) {
  int info;
  f->cholesky = 1;
  dpotrf_("L", &f->n, f->A, &f->n, &info, 1);
  return info;
}

int dlsi_dense_lu(dlsi_dense *f) {
  int info;
  f->cholesky = 0;
  dgetrf_(&f->n, &f->n, f->A, &f->n, f->pivot, &info);
  return info;
}

int dlsi_dense_factor(dlsi_dense *f, double *diagonal) {
  const size_t n = (size_t)f->n;
  double *A = f->A;
  if (!dlsi_is_symmetric(A, n)) return dlsi_dense_lu(f);
  for (size_t j = 0; j < n; j++)
    diagonal[j] = A[j + n * j];
  if (!dlsi_dense_cholesky(f)) return 0;
  for (size_t j = 0; j < n; j++) { /* the upper triangle still is A's */
    A[j + n * j] = diagonal[j];
    for (size_t i = j + 1; i < n; i++)
      A[i + n * j] = A[j + n * i];
  }
  return dlsi_dense_lu(f);
}

void dlsi_dense_solve(const dlsi_dense *f, double *X, int ld, int nrhs) {
  const int n = f->n, one = 1;
  int info;
  if (!n || !nrhs) return;
  if (!f->cholesky)
    dgetrs_("N", &n, &nrhs, f->A, &n, f->pivot, X, &ld, &info, 1);
  else if (nrhs > 1)
    dpotrs_("L", &n, &nrhs, f->A, &n, X, &ld, &info, 1);
  else { /* dpotrs, made for many columns, takes three times as long for one in OpenBLAS */
    dtrsv_("L", "N", "N", &n, f->A, &n, X, &one, 1, 1, 1);
    dtrsv_("L", "T", "N", &n, f->A, &n, X, &one, 1, 1, 1);
  }
}
