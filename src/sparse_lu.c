/*
 * sparse_lu.c: sparse_lu.h by MUMPS (Amestoy, Duff, L'Excellent, Koster, SIAM J. Matrix Anal. Appl.
 * 23, 2001, 15-41): analysis, multifrontal factorisation with threshold pivoting, solve.
 */
#include "sparse_lu.h"

#include <dmumps_c.h>
#include <limits.h>
#include <stdlib.h>
#include <string.h>

#include "dlsi.h"

/* jobs, and the values of INFOG(1) that mean something here; users' guide of MUMPS 5.5 */
enum { start = -1, end = -2, analyse = 1, factorise = 2, solve = 3 };
enum { singular_structure = -6, singular = -10, small_integers = -8, small_reals = -9 };
enum { sequential_world = -987654, most_relaxation = 1000 };

/* ICNTL and INFOG as the guide numbers them */
#define ICNTL(k) icntl[(k)-1]
#define INFOG(k) infog[(k)-1]

struct dlsi_sparse_lu {
  DMUMPS_STRUC_C mumps;
  int *row, *col; /* 1-based; of the last pattern */
  double *x;
  size_t room;
  int analysed;
};

static int run(dlsi_sparse_lu *lu, int job) {
  lu->mumps.job = job;
  dmumps_c(&lu->mumps);
  return lu->mumps.INFOG(1);
}

dls_status dlsi_sparse_lu_create(const char *function, dlsi_sparse_lu **out, dls_error *error) {
  *out = NULL;
  dlsi_sparse_lu *lu = dlsi_alloc(1, sizeof *lu);
  if (!lu) return dlsi_fail(error, DLS_E_MEMORY, function, "", -1, 0, "out of memory");
  memset(lu, 0, sizeof *lu);
  lu->mumps.par = 1;
  lu->mumps.sym = 0;
  lu->mumps.comm_fortran = sequential_world;
  if (run(lu, start) < 0) {
    free(lu);
    return dlsi_fail(error, DLS_E_MEMORY, function, "", -1, 0, "MUMPS does not start");
  }
  for (int k = 1; k <= 3; k++)
    lu->mumps.ICNTL(k) = -1; /* no output unit for errors, warnings, statistics */
  lu->mumps.ICNTL(4) = 0;
  lu->mumps.ICNTL(7) = 0; /* approximate minimum degree: others draw random numbers */
  *out = lu;
  return DLS_OK;
}

dls_status dlsi_sparse_lu_reserve(const char *function, dlsi_sparse_lu *lu, size_t entries,
                                  dls_error *error) {
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
  return got ? DLS_OK : dlsi_fail(error, DLS_E_MEMORY, function, "", -1, 0, "out of memory");
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

dls_status dlsi_sparse_lu_factor(const char *function, dlsi_sparse_lu *lu, const dls_sparse *A,
                                 dls_error *error) {
  int info = 0;
  if (!take_over(lu, A)) info = run(lu, analyse);
  lu->analysed = info >= 0;
  const int usual = lu->mumps.ICNTL(14);
  while (info >= 0) {
    info = run(lu, factorise);
    /* pivoting took more room than was foreseen, by ICNTL(14) per cent: foresee more */
    if (info != small_integers && info != small_reals) break;
    if (lu->mumps.ICNTL(14) >= most_relaxation) break;
    lu->mumps.ICNTL(14) *= 2;
    info = 0;
  }
  lu->mumps.ICNTL(14) = usual;
  if (info >= 0) return DLS_OK;
  if (info == singular || info == singular_structure)
    return dlsi_fail(error, DLS_E_SINGULAR, function, "", -1, 0, "a matrix is singular");
  return dlsi_fail(error, DLS_E_MEMORY, function, "", -1, info,
                   "out of memory in MUMPS, its code %d", info);
}

dls_status dlsi_sparse_lu_solve(const char *function, dlsi_sparse_lu *lu, double *x,
                                dls_error *error) {
  lu->mumps.rhs = x;
  lu->mumps.nrhs = 1;
  lu->mumps.lrhs = lu->mumps.n;
  const int info = run(lu, solve);
  lu->mumps.rhs = NULL;
  if (info >= 0) return DLS_OK;
  return dlsi_fail(error, DLS_E_MEMORY, function, "", -1, info,
                   "out of memory in MUMPS, its code %d", info);
}

void dlsi_sparse_lu_destroy(dlsi_sparse_lu *lu) {
  if (!lu) return;
  (void)run(lu, end);
  free(lu->row);
  free(lu->col);
  free(lu->x);
  free(lu);
}
