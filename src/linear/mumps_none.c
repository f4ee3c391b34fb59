/*
 * mumps_none.c: replaces schur.c, sparse_lu.c and dissection.c in a build without MUMPS. create and
 * dlsi_dissection return DLS_E_UNSUPPORTED. No other function is ever reached: there is no object
 * to call it with.
 */
#pragma GCC diagnostic ignored "-Wunused-parameter"

#include "contact/contact.h"
#include "linear/dissection.h"
#include "linear/schur.h"
#include "linear/sparse_lu.h"

static dls_status mumps_missing(dls_error *error) {
  return dlsi_fail(error, DLS_E_UNSUPPORTED, "", -1, 0, "this build has no MUMPS");
}

int dlsi_schur_available(void) {
  return 0;
}

dls_status dlsi_schur_create(dlsi_schur **out, const dls_sparse *Ks,
                             dls_factorization factorization, int count, const int *keep,
                             dls_error *error) {
  *out = NULL;
  return mumps_missing(error);
}

const dlsi_schur_measures *dlsi_schur_measured(const dlsi_schur *work) {
  return NULL;
}

dls_status dlsi_schur_same(const dlsi_schur *work, const dls_sparse *Ks, dls_error *error) {
  return mumps_missing(error);
}

dls_status dlsi_schur_factor(dlsi_schur *work, const dls_sparse *Ks, dls_error *error) {
  return mumps_missing(error);
}

dls_status dlsi_schur_solve(dlsi_schur *work, double *X, int nrhs, dls_error *error) {
  return mumps_missing(error);
}

dls_status dlsi_schur_condense(dlsi_schur *work, double *x, double *z, dls_error *error) {
  return mumps_missing(error);
}

int dlsi_schur_holds(const dlsi_schur *work) {
  return 0;
}

dls_status dlsi_schur_expand(dlsi_schur *work, const double *h, double *x, dls_error *error) {
  return mumps_missing(error);
}

void dlsi_schur_watch(dlsi_schur *work, dlsi_watch *watch) {}

dls_status dlsi_schur_inverse(const dlsi_schur *work, double *Z) {
  return mumps_missing(NULL);
}

void dlsi_schur_destroy(dlsi_schur *work) {}

dls_status dlsi_sparse_lu_create(dlsi_sparse_lu **out, dls_error *error) {
  *out = NULL;
  return mumps_missing(error);
}

dls_status dlsi_sparse_lu_reserve(dlsi_sparse_lu *work, size_t entries, dls_error *error) {
  return mumps_missing(error);
}

dls_status dlsi_sparse_lu_factor(dlsi_sparse_lu *work, const dls_sparse *A, dls_error *error) {
  return mumps_missing(error);
}

dls_status dlsi_sparse_lu_solve(dlsi_sparse_lu *work, double *x, dls_error *error) {
  return mumps_missing(error);
}

dls_status dlsi_sparse_lu_solve_transposed(dlsi_sparse_lu *work, double *x, dls_error *error) {
  return mumps_missing(error);
}

void dlsi_sparse_lu_destroy(dlsi_sparse_lu *work) {}

dls_status dlsi_dissection(int n, size_t entries, const int *row, const int *col, int *order,
                           dls_error *error) {
  return mumps_missing(error);
}
