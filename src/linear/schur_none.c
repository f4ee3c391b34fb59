/* schur_none.c: schur.h in a build without MUMPS: there never is a dlsi_schur. */
#include "base/base.h"
#include "linear/schur.h"

int dlsi_schur_available(void) {
  return 0;
}

static dls_status unsupported(dls_error *error) {
  return dlsi_fail(error, DLS_E_UNSUPPORTED, "", -1, 0, "this build has no MUMPS");
}

dls_status dlsi_schur_create(dlsi_schur **out, const dls_sparse *Ks,
                             dls_factorization factorization, int count, const int *keep,
                             dls_error *error) {
  (void)Ks;
  (void)factorization;
  (void)count;
  (void)keep;
  *out = NULL;
  return unsupported(error);
}

void dlsi_schur_estimate(const dlsi_schur *schur, double *factor_bytes, double *bytes,
                         double *flops) {
  (void)schur;
  *factor_bytes = *bytes = *flops = 0;
}

dls_status dlsi_schur_same(const dlsi_schur *schur, const dls_sparse *Ks, dls_error *error) {
  (void)schur;
  (void)Ks;
  return unsupported(error);
}

dls_status dlsi_schur_factor(dlsi_schur *schur, const dls_sparse *Ks, dls_error *error) {
  (void)schur;
  (void)Ks;
  return unsupported(error);
}

dls_status dlsi_schur_solve(dlsi_schur *schur, double *X, int nrhs, dls_error *error) {
  (void)schur;
  (void)X;
  (void)nrhs;
  return unsupported(error);
}

dls_status dlsi_schur_kept(dlsi_schur *schur, double *x, double *z, dls_error *error) {
  (void)schur;
  (void)x;
  (void)z;
  return unsupported(error);
}

dls_status dlsi_schur_inverse(const dlsi_schur *schur, double *Z, dls_error *error) {
  (void)schur;
  (void)Z;
  return unsupported(error);
}

double dlsi_schur_error(const dlsi_schur *schur) {
  (void)schur;
  return 0;
}

double dlsi_schur_rcond(const dlsi_schur *schur) {
  (void)schur;
  return 0;
}

void dlsi_schur_destroy(dlsi_schur *schur) {
  (void)schur;
}
