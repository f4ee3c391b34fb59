/* dense.h: factors of dense matrices: Cholesky's where there are any, else LU. */
#ifndef DLSI_DENSE_H
#define DLSI_DENSE_H

#include "base/base.h"

/* Returns 1 if A (n x n, column-major without gaps) equals its transpose to the last bit. */
int dlsi_is_symmetric(const double *A, size_t n);

/* A matrix of the caller's and, after one of the calls below, its factors in the same place. */
typedef struct dlsi_dense {
  int n;
  double *A;    /* n x n, column-major without gaps */
  int *pivot;   /* n: row exchanges of LU; may be NULL for Cholesky alone */
  int cholesky; /* 1: A = L L^T, L in the lower triangle; 0: P A = L U */
} dlsi_dense;

/* Each returns 0, or k > 0 if pivot k, counted from 1, is not positive (Cholesky) or is 0 (LU). Cholesky
 * reads and writes the lower triangle only. */
int dlsi_dense_cholesky(dlsi_dense *f);
int dlsi_dense_lu(dlsi_dense *f);

/* Tries Cholesky where A is symmetric, then LU. diagonal: scratch, n. */
int dlsi_dense_factor(dlsi_dense *f, double *diagonal);

/* X (n x nrhs, column-major, leading dimension ld) := A^-1 X. */
void dlsi_dense_solve(const dlsi_dense *f, double *X, int ld, int nrhs);

#endif
