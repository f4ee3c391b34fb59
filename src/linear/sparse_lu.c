/*
 * sparse_lu.c: sparse_lu.h by MUMPS (Amestoy, Duff, L'Excellent, Koster, SIAM J. Matrix Anal. Appl.
 * 23, 2001, 15-41): analysis, multifrontal factorisation with threshold pivoting, solve.
 */
#include "linear/sparse_lu.h"

#include <limits.h>
#include <stdlib.h>
#include <string.h>

#include "base/base.h"
#include "linear/mumps.h"

struct dlsi_sparse_lu {
  DMUMPS_STRUC_C mumps;
  int *row, *col; /* 1-based; of the last pattern */
  double *x;
  size_t room;
  int analysed;
};

dls_status dlsi_sparse_lu_create(dlsi_sparse_lu **out, dls_error *error) {
  *out = NULL;
  dlsi_sparse_lu *lu = dlsi_alloc(1, sizeof *lu);
  if (!lu) return dlsi_no_memory(error);
  memset(lu, 0, sizeof *lu);
  if (!dlsi_mumps_start(&lu->mumps, 0)) {
    free(lu);
    return dlsi_fail(error, DLS_E_MEMORY, "", -1, 0, "MUMPS does not start");
  }
  lu->mumps.ICNTL(7) = 0; /* approximate minimum degree: others draw random numbers */
  *out = lu;
  return DLS_OK;
}

dls_status dlsi_sparse_lu_reserve(dlsi_sparse_lu *lu, size_t entries, dls_error *error) {
  if (entries <= lu->room) return DLS_OK;
  free(lu->row);
  free(lu->col);
  free(lu->x);
  lu->row = dlsi_alloc(entries, sizeof *lu->row);
  lu->col = dlsi_alloc(entries, sizeof *lu->col);
  lu->x = dlsi_alloc(entries, sizeof *lu->x);
  const int got = lu->row && lu->col && lu->x;
  lu->room = got ? entries : 0;
  lu->analysed = 0;
  return got ? DLS_OK : dlsi_no_memory(error);
}

/* Takes over the entries of A; returns 1 if the pattern is the one that was analysed last. */
static int take_over(dlsi_sparse_lu *lu, const dls_sparse *A) {
  int same = lu->analysed && lu->mumps.n == A->cols && lu->mumps.nnz == A->p[A->cols];
  for (int j = 0; j < A->cols; j++)
    for (int k = A->p[j]; k < A->p[j + 1]; k++) {
      same = same && lu->row[k] == A->i[k] + 1 && lu->col[k] == j + 1;
      lu->row[k] = A->i[k] + 1;
      lu->col[k] = j + 1;
      lu->x[k] = A->x[k];
    }
  lu->mumps.n = A->cols;
  lu->mumps.nnz = A->p[A->cols];
  lu->mumps.irn = lu->row;
  lu->mumps.jcn = lu->col;
  lu->mumps.a = lu->x;
  return same;
}

dls_status dlsi_sparse_lu_factor(dlsi_sparse_lu *lu, const dls_sparse *A, dls_error *error) {
  int info = 0;
  if (!take_over(lu, A)) info = dlsi_mumps_run(&lu->mumps, analyse);
  lu->analysed = info >= 0;
  if (info >= 0) info = dlsi_mumps_factor(&lu->mumps);
  if (info >= 0) return DLS_OK;
  if (info == singular || info == singular_structure)
    return dlsi_fail(error, DLS_E_SINGULAR, "", -1, 0, "a matrix is singular");
  return dlsi_fail(error, DLS_E_MEMORY, "", -1, info, "out of memory in MUMPS, its code %d", info);
}

dls_status dlsi_sparse_lu_solve(dlsi_sparse_lu *lu, double *x, dls_error *error) {
  lu->mumps.rhs = x;
  lu->mumps.nrhs = 1;
  lu->mumps.lrhs = lu->mumps.n;
  const int info = dlsi_mumps_run(&lu->mumps, solve);
  lu->mumps.rhs = NULL;
  if (info >= 0) return DLS_OK;
  return dlsi_fail(error, DLS_E_MEMORY, "", -1, info, "out of memory in MUMPS, its code %d", info);
}

void dlsi_sparse_lu_destroy(dlsi_sparse_lu *lu) {
  if (!lu) return;
  (void)dlsi_mumps_run(&lu->mumps, end);
  free(lu->row);
  free(lu->col);
  free(lu->x);
  free(lu);
}
