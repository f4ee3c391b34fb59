/* dense.c: Cholesky and LU of dense matrices by LAPACK; norms, scaling, symmetry. */
#include "linear/dense.h"

#include <math.h>
#include <string.h>

#include "linear/blas.h"
#include "linear/pieces.h"

static int dense_alone(const dlsi_dense *f) {
  return dlsi_is_small((size_t)f->n * (size_t)f->n);
}

/* Compares in tiles, so that both triangles stay in the cache. */
int dlsi_is_symmetric(const double *A, size_t n) {
  enum { tile = 32 };
  for (size_t j0 = 0; j0 < n; j0 += tile)
    for (size_t i0 = j0; i0 < n; i0 += tile)
      for (size_t j = j0; j < j0 + tile && j < n; j++)
        for (size_t i = i0; i < i0 + tile && i < n; i++)
          if (A[i + n * j] != A[j + n * i]) return 0;
  return 1;
}

/* Goes in tiles, too. */
void dlsi_make_symmetric(double *A, size_t n, int mean) {
  enum { tile = 32 };
  for (size_t J = 0; J < n; J += tile)
    for (size_t I = J; I < n; I += tile)
      for (size_t j = J; j < n && j < J + tile; j++)
        for (size_t i = I > j ? I : j + 1; i < n && i < I + tile; i++) {
          if (mean) A[i + j * n] = A[i + j * n] / 2 + A[j + i * n] / 2;
          A[j + i * n] = A[i + j * n];
        }
}

double dlsi_dense_norm(const double *A, size_t n, int symmetric, double *sums) {
  memset(sums, 0, n * sizeof *sums);
  for (size_t j = 0; j < n; j++)
    for (size_t i = symmetric ? j : 0; i < n; i++) {
      sums[j] += fabs(A[i + j * n]);
      if (symmetric && i > j) sums[i] += fabs(A[i + j * n]);
    }
  return dlsi_max_abs(sums, n);
}

void dlsi_scale_rows(const double *diagonal, size_t n, double *X, int nrhs) {
  for (int j = 0; j < nrhs; j++, X += n)
    for (size_t i = 0; i < n; i++)
      X[i] *= diagonal[i];
}

int dlsi_dense_cholesky_watched(dlsi_dense *f, dlsi_watch *watch) {
  f->cholesky = 1;
  return dlsi_panel(dense_alone(f), f->n, 0, f->A, f->n, watch, 0);
}

int dlsi_dense_cholesky(dlsi_dense *f) {
  return dlsi_dense_cholesky_watched(f, NULL);
}

int dlsi_dense_lu(dlsi_dense *f) {
  f->cholesky = 0;
  return dlsi_getrf(dense_alone(f), f->n, f->A, f->n, f->pivot);
}

/* Halves A if the exponent of its largest |diagonal entry| is odd. The square roots of Cholesky
 * then keep every bit if A is multiplied by a power of two. */
static void dense_halve(dlsi_dense *f) {
  const size_t n = (size_t)f->n;
  double most = 0;
  for (size_t j = 0; j < n; j++)
    most = fmax(most, fabs(f->A[j + n * j]));
  f->halved = most > 0 && isfinite(most) && ilogb(most) % 2 != 0;
  for (size_t k = 0; f->halved && k < n * n; k++)
    f->A[k] *= 0.5;
}

int dlsi_dense_factor(dlsi_dense *f, double *diagonal) {
  const size_t n = (size_t)f->n;
  double *A = f->A;
  f->halved = 0;
  if (!dlsi_is_symmetric(A, n)) return dlsi_dense_lu(f);
  dense_halve(f);
  for (size_t j = 0; j < n; j++)
    diagonal[j] = A[j + n * j];
  if (!dlsi_dense_cholesky(f)) return 0;
  for (size_t j = 0; j < n; j++) { /* the upper triangle is still A's */
    A[j + n * j] = diagonal[j];
    for (size_t i = j + 1; i < n; i++)
      A[i + n * j] = A[j + n * i];
  }
  return dlsi_dense_lu(f);
}

void dlsi_dense_solve(const dlsi_dense *f, double *X, int ld, int nrhs) {
  const int n = f->n, one = 1, alone = dense_alone(f);
  if (!n || !nrhs) return;
  for (int j = 0; f->halved && j < nrhs; j++)
    for (int i = 0; i < n; i++)
      X[(size_t)i + (size_t)j * (size_t)ld] *= 0.5;
  if (!f->cholesky)
    dlsi_getrs(alone, n, nrhs, f->A, n, f->pivot, X, ld);
  else if (nrhs > 1) {
    dlsi_trsm(alone, 'L', 'L', 'N', 'N', n, nrhs, f->A, n, X, ld);
    dlsi_trsm(alone, 'L', 'L', 'T', 'N', n, nrhs, f->A, n, X, ld);
  } else { /* dpotrs is made for many columns; for one, OpenBLAS takes three times as long */
    dtrsv_("L", "N", "N", &n, f->A, &n, X, &one, 1, 1, 1);
    dtrsv_("L", "T", "N", &n, f->A, &n, X, &one, 1, 1, 1);
  }
}

void dlsi_dense_solve_transposed(const dlsi_dense *f, double *x) {
  const int n = f->n, one = 1;
  int info;
  if (f->cholesky || !n) {
    dlsi_dense_solve(f, x, n, 1);
    return;
  }
  for (int i = 0; f->halved && i < n; i++)
    x[i] *= 0.5;
  dgetrs_("T", &n, &one, f->A, &n, f->pivot, x, &n, &info, 1);
}

/* Solves for unit columns: with L columns from j on need only rows from j on. */
int dlsi_dense_inverse(const dlsi_dense *f, double *Z, dlsi_watch *watch) {
  const size_t n = (size_t)f->n;
  const int alone = dense_alone(f), columns = alone ? 64 : 256;
  memset(Z, 0, n * n * sizeof *Z);
  for (size_t j = 0; j < n; j++)
    Z[j * (n + 1)] = f->halved ? 0.5 : 1; /* the factors are those of A / 2 */
  for (int j = 0; j < f->n; j += columns) {
    const int rows = f->n - j, some = rows < columns ? rows : columns;
    const size_t corner = (size_t)j * (n + 1);
    if (dlsi_watch_stops(watch, j, 2.0 * (f->cholesky ? rows : f->n) * f->n * some)) return 1;
    if (!f->cholesky) {
      dlsi_getrs(alone, f->n, some, f->A, f->n, f->pivot, Z + (size_t)j * n, f->n);
      continue;
    }
    dlsi_trsm(alone, 'L', 'L', 'N', 'N', rows, some, f->A + corner, f->n, Z + corner, f->n);
    dlsi_trsm(alone, 'L', 'L', 'T', 'N', rows, some, f->A + corner, f->n, Z + corner, f->n);
  }
  return 0;
}

double dlsi_dense_rcond(const dlsi_dense *f, double norm, double *work, int *iwork) {
  double rcond = 0;
  int info;
  if (f->halved) norm *= 0.5;
  if (f->cholesky)
    dpocon_("L", &f->n, f->A, &f->n, &norm, &rcond, work, iwork, &info, 1);
  else
    dgecon_("1", &f->n, f->A, &f->n, &norm, &rcond, work, iwork, &info, 1);
  return rcond;
}
