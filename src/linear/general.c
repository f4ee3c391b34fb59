/*
 * general.c: LU of a square matrix given by triplets, dense or by MUMPS.
 *
 * The dense one is scaled by powers of two, so that the largest entry of each row and column is
 * near 1 and pivots do not depend on units. A pivot below 1e-14 is rounding: singular.
 */
#include "linear/general.h"

#include <stdlib.h>
#include <string.h>

#include "linear/equilibrate.h"

enum { dense_limit = 250, largest_dense = 8000 };

static const double rounding = 1e-14;

static dls_status general_reserve(dlsi_general *work, dls_error *error) {
  const size_t n = (size_t)work->n;
  if (n <= work->room) return DLS_OK;
  free(work->A);
  free(work->scale);
  free(work->pivot);
  work->A = dlsi_alloc(n, n * sizeof *work->A);
  work->scale = dlsi_alloc(4 * n, sizeof *work->scale);
  work->pivot = dlsi_alloc(n, sizeof *work->pivot);
  work->room = work->A && work->scale && work->pivot ? n : 0;
  return work->room ? DLS_OK : dlsi_no_memory(error);
}

static dls_status general_dense(dlsi_general *work, const dls_sparse *A, dls_error *error) {
  const size_t n = (size_t)work->n;
  const dls_status status = general_reserve(work, error);
  if (status) return status;
  double *R = work->scale, *C = R + n;
  dlsi_find_scales(A, 0, R, C, C + n);
  memset(work->A, 0, n * n * sizeof *work->A);
  for (size_t j = 0; j < n; j++)
    for (int k = A->p[j]; k < A->p[j + 1]; k++)
      work->A[(size_t)A->i[k] + j * n] += R[A->i[k]] * A->x[k] * C[j];
  work->of = (dlsi_dense){.n = work->n, .A = work->A, .pivot = work->pivot};
  int failed = dlsi_dense_lu(&work->of);
  for (size_t j = 0; !failed && j < n; j++)
    failed = !(fabs(work->A[j * (n + 1)]) > rounding);
  return failed ? DLS_E_SINGULAR : DLS_OK;
}

dls_status dlsi_general_factor(dlsi_general *work, const dlsi_triplets *t, dls_error *error) {
  dlsi_columns A = {0};
  dls_error why = {0};
  dls_status status = dlsi_columns_compress(t, 1, DLSI_ALL, &A, error);
  const dls_sparse view = dlsi_columns_view(&A);
  work->n = t->cols;
  work->dense = work->n <= dense_limit;
  if (!status && !work->dense) {
    if (!work->lu) status = dlsi_sparse_lu_create(&work->lu, &why);
    if (!status) status = dlsi_sparse_lu_reserve(work->lu, (size_t)t->count, &why);
    if (!status) status = dlsi_sparse_lu_factor(work->lu, &view, &why);
    work->dense = status == DLS_E_UNSUPPORTED && work->n <= largest_dense;
    if (work->dense)
      status = DLS_OK;
    else if (status && error)
      *error = why;
  }
  if (!status && work->dense) status = general_dense(work, &view, error);
  dlsi_columns_free(&A);
  return status;
}

dls_status dlsi_general_solve(const dlsi_general *work, int transposed, double *x,
                              dls_error *error) {
  const size_t n = (size_t)work->n;
  const double *R = work->scale, *C = R + n; /* R A C is factored */
  if (!work->dense)
    return (transposed ? dlsi_sparse_lu_solve_transposed : dlsi_sparse_lu_solve)(work->lu, x,
                                                                                 error);
  dlsi_scale_rows(transposed ? C : R, n, x, 1);
  if (transposed)
    dlsi_dense_solve_transposed(&work->of, x);
  else
    dlsi_dense_solve(&work->of, x, work->n, 1);
  dlsi_scale_rows(transposed ? R : C, n, x, 1);
  return DLS_OK;
}

void dlsi_general_free(dlsi_general *work) {
  dlsi_sparse_lu_destroy(work->lu);
  free(work->A);
  free(work->scale);
  free(work->pivot);
}
