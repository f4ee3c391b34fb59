/*
 * delassus/matrix.h: views of the host's matrices. A view owns nothing and copies nothing; its
 * arrays must outlive every call (and every object) that is given the view.
 * Indices are 0-based. Every value must be finite.
 */
#ifndef DELASSUS_MATRIX_H
#define DELASSUS_MATRIX_H

#include "delassus/status.h"

#ifdef __cplusplus
extern "C" {
#endif

/* Dense, column-major: A(i,j) = a[i + j*ld], ld >= max(1, rows). No call can see an ld beyond the
 * array, nor rows given in the place of columns: a row-major matrix is read as its transpose. */
typedef struct dls_dense {
  int rows, cols, ld;
  const double *a; /* ld * cols */
} dls_dense;

/* Compressed sparse columns: the entries of column j are x[k], in row i[k], for p[j] <= k < p[j+1].
 * p[0] = 0, p does not decrease. Rows may stand in any order; entries of the same place add up. */
typedef struct dls_sparse {
  int rows, cols;
  const int *p;    /* cols + 1 */
  const int *i;    /* p[cols], 0 <= i < rows */
  const double *x; /* p[cols] */
} dls_sparse;

/* Compressed block columns of d x d blocks: block k, p[c] <= k < p[c+1], stands in block row i[k]
 * of block column c and is stored column-major at x + d*d*k. Blocks of the same place add up. */
typedef struct dls_blocks {
  int d;           /* 1, 2 or 3 */
  int n;           /* block rows = block columns */
  const int *p;    /* n + 1 */
  const int *i;    /* p[n], 0 <= i < n */
  const double *x; /* d * d * p[n] */
} dls_blocks;

/* Counts the d x d blocks of A (square, d = 1, 2 or 3 times n rows) that are not all zeros.
 * DLS_E_ARGUMENT, DLS_E_NOT_FINITE; DLS_E_SIZE, also for more than INT_MAX blocks. */
DLS_API DLS_MUST_USE dls_status dls_blocks_count(const dls_dense *A, int d, int *count,
                                                 dls_error *error);

/* Copies the blocks that dls_blocks_count counts into p, i and x, block rows increasing, and sets
 * *B to a view of these arrays. p: n + 1, i: count, x: d d count; the caller owns them; they must
 * not overlap A. Errors of dls_blocks_count. */
DLS_API DLS_MUST_USE dls_status dls_blocks_from_dense(const dls_dense *A, int d, int *p, int *i,
                                                      double *x, dls_blocks *B, dls_error *error);

/* Writes B as a dense matrix of d n columns with leading dimension ld >= d n. a: ld d n doubles
 * of the caller, must not overlap B. DLS_E_ARGUMENT, DLS_E_SIZE, DLS_E_NOT_FINITE. */
DLS_API DLS_MUST_USE dls_status dls_blocks_to_dense(const dls_blocks *B, double *a, int ld,
                                                    dls_error *error);

#ifdef __cplusplus
}
#endif

#endif
