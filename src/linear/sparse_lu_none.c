/* sparse_lu_none.c: sparse_lu.h in a build without MUMPS: there never is a dlsi_sparse_lu. */
#include "base/base.h"
#include "linear/sparse_lu.h"

static dls_status unsupported(dls_error *error) {
  return dlsi_fail(error, DLS_E_UNSUPPORTED, "", -1, 0, "this build has no MUMPS");
}

dls_status dlsi_sparse_lu_create(dlsi_sparse_lu **out, dls_error *error) {
  *out = NULL;
  return unsupported(error);
}

dls_status dlsi_sparse_lu_reserve(dlsi_sparse_lu *lu, size_t entries, dls_error *error) {
  (void)lu;
  (void)entries;
  return unsupported(error);
}

dls_status dlsi_sparse_lu_factor(dlsi_sparse_lu *lu, const dls_sparse *A, dls_error *error) {
  (void)lu;
  (void)A;
  return unsupported(error);
}

dls_status dlsi_sparse_lu_solve(dlsi_sparse_lu *lu, double *x, dls_error *error) {
  (void)lu;
  (void)x;
  return unsupported(error);
}

void dlsi_sparse_lu_destroy(dlsi_sparse_lu *lu) {
  (void)lu;
}
