/*
 * sparse_lu.h: factors a sparse unsymmetric A = L U by MUMPS (sequential). In a build without MUMPS
 * (MUMPS=0) create returns DLS_E_UNSUPPORTED.
 *
 * MUMPS allocates inside factor and solve; only one thread at a time may call it (mumps.h). It
 * prints nothing.
 */
#ifndef DLSI_SPARSE_LU_H
#define DLSI_SPARSE_LU_H

#include "delassus/matrix.h"

typedef struct dlsi_sparse_lu dlsi_sparse_lu;

/* *out = NULL on error: DLS_E_UNSUPPORTED, DLS_E_MEMORY. */
dls_status dlsi_sparse_lu_create(dlsi_sparse_lu **out, dls_error *error);

/* Makes room for matrices with up to so many entries. DLS_E_MEMORY. */
dls_status dlsi_sparse_lu_reserve(dlsi_sparse_lu *work, size_t entries, dls_error *error);

/* Factors A = L U, square, not empty, entries <= reserved. A may change in size and pattern from
 * call to call; a change repeats the analysis. DLS_E_SINGULAR, DLS_E_MEMORY. */
dls_status dlsi_sparse_lu_factor(dlsi_sparse_lu *work, const dls_sparse *A, dls_error *error);

/* Solves x := A^-1 x with the A of the last factor, which must have succeeded. DLS_E_MEMORY. */
dls_status dlsi_sparse_lu_solve(dlsi_sparse_lu *work, double *x, dls_error *error);

/* Solves x := A^-T x in the same way. */
dls_status dlsi_sparse_lu_solve_transposed(dlsi_sparse_lu *work, double *x, dls_error *error);

/* NULL is fine. */
void dlsi_sparse_lu_destroy(dlsi_sparse_lu *work);

#endif
