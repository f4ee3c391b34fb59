/*
 * model.c: from the host's model to its answer in one call:
 *
 *   K x = f + H r,   u = H^T x + g,   the law of contact and friction between u and r
 *
 * Cost and failures are those of dls_reduction_create and dls_reduction_solve.
 */
#include "delassus/solve.h"
#include "front/front.h"

dls_status dls_solve_model(const dls_model *model, const double *f, const double *g,
                           const double *mu, double *r, double *u, double *x, dls_info *info,
                           dls_error *error) {
  DLSI_DOOR;
  dls_reduction *reduction;
  dls_status status = dls_reduction_create(&reduction, model, NULL, error);
  if (!status) status = dls_reduction_load(reduction, f, g, error);
  if (!status) status = dls_reduction_solve(reduction, mu, NULL, r, u, x, info, error);
  dls_reduction_destroy(reduction);
  return dlsi_at(__func__, status, error);
}
