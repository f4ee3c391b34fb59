/* dense.h: factors dense matrices, by Cholesky where that is possible, else by LU. */
#ifndef DLSI_DENSE_H
#define DLSI_DENSE_H

#include "contact/contact.h"

/* Returns 1 if A (n x n, column-major without gaps) equals its transpose to the last bit. */
int dlsi_is_symmetric(const double *A, size_t n);

/* Makes A (n x n, column-major without gaps) symmetric to the last bit: copies the lower triangle
 * to the upper one or, if mean is 1, gives both the mean of the two. */
void dlsi_make_symmetric(double *A, size_t n, int mean);

/* Returns |A|_1; symmetric: 1 if only the lower triangle of A is stored. sums: scratch, n. */
double dlsi_dense_norm(const double *A, size_t n, int symmetric, double *sums);

/* Multiplies row i of X (n x nrhs, column-major without gaps) by diagonal[i]. */
void dlsi_scale_rows(const double *diagonal, size_t n, double *X, int nrhs);

/* A matrix of the caller's and, after one of the calls below, its factors in the same place. */
typedef struct dlsi_dense {
  int n;
  double *A;    /* n x n, column-major without gaps */
  int *pivot;   /* n: row exchanges of LU; may be NULL for Cholesky alone */
  int cholesky; /* 1: A = L L^T, L in the lower triangle; 0: P A = L U */
  int halved;   /* 1: the factors are those of A / 2 */
} dlsi_dense;

/* Each returns 0, or k > 0 if pivot k, counted from 1, is not positive (Cholesky) or is 0 (LU).
 * Cholesky reads and writes the lower triangle only. */
int dlsi_dense_cholesky(dlsi_dense *f);
int dlsi_dense_lu(dlsi_dense *f);

/* Works as dlsi_dense_cholesky; returns dlsi_stopped (pieces.h) if the host cancels. */
int dlsi_dense_cholesky_watched(dlsi_dense *f, dlsi_watch *watch);

/* Tries Cholesky if A is symmetric, then LU; to the same bits if A is multiplied by a power of two.
 * diagonal: scratch, n. */
int dlsi_dense_factor(dlsi_dense *f, double *diagonal);

/* Solves X := A^-1 X. X: n x nrhs, column-major with leading dimension ld. */
void dlsi_dense_solve(const dlsi_dense *f, double *X, int ld, int nrhs);

/* Solves x := A^-T x, n. */
void dlsi_dense_solve_transposed(const dlsi_dense *f, double *x);

/* Z := A^-1; of Cholesky only the lower triangle, the upper one is lost. Z: n x n. Returns 1 if the
 * host cancels; watch may be NULL. */
int dlsi_dense_inverse(const dlsi_dense *f, double *Z, dlsi_watch *watch);

/* Returns 1 / (|A|_1 |A^-1|_1) by estimate. norm: |A|_1; work: scratch, 4 n; iwork: scratch, n. */
double dlsi_dense_rcond(const dlsi_dense *f, double norm, double *work, int *iwork);

#endif
