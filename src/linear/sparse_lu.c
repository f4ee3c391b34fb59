/*
 * sparse_lu.c: solves sparse unsymmetric systems by MUMPS (Amestoy, Duff, L'Excellent, Koster, SIAM
 * J. Matrix Anal. Appl. 23, 2001, 15-41): analysis, multifrontal factorisation with threshold
 * pivoting, solve. A is divided by a power of two near its largest entry: MUMPS scales by square
 * roots, which would round an odd power of two in A.
 */
#include "linear/sparse_lu.h"

#include <float.h>
#include <limits.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "contact/contact.h"
#include "linear/mumps.h"

struct dlsi_sparse_lu {
  DMUMPS_STRUC_C mumps;
  int *row, *col; /* 1-based; of the last pattern */
  double *x;
  double unit;     /* MUMPS factorises unit A */
  size_t reserved; /* entries */
  int analysed;    /* 1: this pattern */
};

dls_status dlsi_sparse_lu_create(dlsi_sparse_lu **out, dls_error *error) {
  *out = NULL;
  dlsi_sparse_lu *work = calloc(1, sizeof *work);
  if (!work) return dlsi_no_memory(error);
  const dls_status status = dlsi_mumps_start(&work->mumps, 0, mumps_alone, error);
  if (status) {
    free(work);
    return status;
  }
  work->mumps.ICNTL(7) = 0; /* approximate minimum degree: others draw random numbers */
  *out = work;
  return DLS_OK;
}

dls_status dlsi_sparse_lu_reserve(dlsi_sparse_lu *work, size_t entries, dls_error *error) {
  if (entries <= work->reserved) return DLS_OK;
  free(work->row);
  free(work->col);
  free(work->x);
  work->row = dlsi_alloc(entries, sizeof *work->row);
  work->col = dlsi_alloc(entries, sizeof *work->col);
  work->x = dlsi_alloc(entries, sizeof *work->x);
  const int got = work->row && work->col && work->x;
  work->reserved = got ? entries : 0;
  work->analysed = 0;
  return got ? DLS_OK : dlsi_no_memory(error);
}

/* Takes over the entries of unit A; returns 1 if the pattern is the one that was analysed last. */
static int sparse_lu_take_over(dlsi_sparse_lu *work, const dls_sparse *A) {
  int same = work->analysed && work->mumps.n == A->cols && work->mumps.nnz == A->p[A->cols];
  const double most = dlsi_max_abs(A->x, (size_t)A->p[A->cols]);
  work->unit = most >= DBL_MIN && most <= 0x1p1000 ? ldexp(1, -ilogb(most)) : 1;
  for (int j = 0; j < A->cols; j++)
    for (int k = A->p[j]; k < A->p[j + 1]; k++) {
      same = same && work->row[k] == A->i[k] + 1 && work->col[k] == j + 1;
      work->row[k] = A->i[k] + 1;
      work->col[k] = j + 1;
      work->x[k] = work->unit * A->x[k];
    }
  work->mumps.n = A->cols;
  work->mumps.nnz = A->p[A->cols];
  work->mumps.irn = work->row;
  work->mumps.jcn = work->col;
  work->mumps.a = work->x;
  return same;
}

dls_status dlsi_sparse_lu_factor(dlsi_sparse_lu *work, const dls_sparse *A, dls_error *error) {
  if (A->p[A->cols] == 0 && A->cols > 0) /* MUMPS refuses a matrix without entries */
    return dlsi_fail(error, DLS_E_SINGULAR, "", -1, 0, "singular: no entries");
  if (!sparse_lu_take_over(work, A)) {
    const dls_status status = dlsi_mumps_run(&work->mumps, analyse, "", error);
    work->analysed = !status;
    if (status) return status;
  }
  return dlsi_mumps_factor(&work->mumps, "", error);
}

dls_status dlsi_sparse_lu_solve(dlsi_sparse_lu *work, double *x, dls_error *error) {
  for (int i = 0; i < work->mumps.n; i++)
    x[i] *= work->unit;
  return dlsi_mumps_solve(&work->mumps, x, 1, error);
}

dls_status dlsi_sparse_lu_solve_transposed(dlsi_sparse_lu *work, double *x, dls_error *error) {
  work->mumps.ICNTL(9) = 0;
  const dls_status status = dlsi_sparse_lu_solve(work, x, error);
  work->mumps.ICNTL(9) = 1;
  return status;
}

void dlsi_sparse_lu_destroy(dlsi_sparse_lu *work) {
  if (!work) return;
  dlsi_mumps_end(&work->mumps);
  free(work->row);
  free(work->col);
  free(work->x);
  free(work);
}
