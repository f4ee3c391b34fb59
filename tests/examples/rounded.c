/*
 * rounded.c: makes "solved to rounding" of each "solved" that an example is told, and NaN of what
 * its results hold before the call. The examples are linked with --wrap of these functions, and
 * have to print what they always print: that status comes with all results.
 */
#include <math.h>

#include "delassus/solve.h"

dls_status __real_dls_solve(const dls_contact *problem, const dls_solver_settings *settings,
                            double *r, double *u, dls_info *info, dls_error *error);
dls_status __wrap_dls_solve(const dls_contact *problem, const dls_solver_settings *settings,
                            double *r, double *u, dls_info *info, dls_error *error);
dls_status __real_dls_solver_solve(dls_solver *solver, const dls_contact *problem, double *r,
                                   double *u, dls_info *info, dls_error *error);
dls_status __wrap_dls_solver_solve(dls_solver *solver, const dls_contact *problem, double *r,
                                   double *u, dls_info *info, dls_error *error);
dls_status __real_dls_reduction_solve(dls_reduction *reduction, const double *mu,
                                      const dls_solver_settings *settings, double *r, double *u,
                                      double *x, dls_info *info, dls_error *error);
dls_status __wrap_dls_reduction_solve(dls_reduction *reduction, const double *mu,
                                      const dls_solver_settings *settings, double *r, double *u,
                                      double *x, dls_info *info, dls_error *error);
dls_status __real_dls_solve_model(const dls_model *model, const double *f, const double *g,
                                  const double *mu, double *r, double *u, double *x, dls_info *info,
                                  dls_error *error);
dls_status __wrap_dls_solve_model(const dls_model *model, const double *f, const double *g,
                                  const double *mu, double *r, double *u, double *x, dls_info *info,
                                  dls_error *error);

static dls_status rounded(dls_status status) {
  return status == DLS_OK ? DLS_TO_ROUNDING : status;
}

dls_status __wrap_dls_solve(const dls_contact *problem, const dls_solver_settings *settings,
                            double *r, double *u, dls_info *info, dls_error *error) {
  return rounded(__real_dls_solve(problem, settings, r, u, info, error));
}

dls_status __wrap_dls_solver_solve(dls_solver *solver, const dls_contact *problem, double *r,
                                   double *u, dls_info *info, dls_error *error) {
  return rounded(__real_dls_solver_solve(solver, problem, r, u, info, error));
}

dls_status __wrap_dls_reduction_solve(dls_reduction *reduction, const double *mu,
                                      const dls_solver_settings *settings, double *r, double *u,
                                      double *x, dls_info *info, dls_error *error) {
  x[0] = NAN;
  return rounded(__real_dls_reduction_solve(reduction, mu, settings, r, u, x, info, error));
}

dls_status __wrap_dls_solve_model(const dls_model *model, const double *f, const double *g,
                                  const double *mu, double *r, double *u, double *x, dls_info *info,
                                  dls_error *error) {
  for (int i = 0; i < model->n; i++)
    x[i] = NAN;
  for (int i = 0; i < model->d * model->nodes; i++)
    r[i] = NAN;
  return rounded(__real_dls_solve_model(model, f, g, mu, r, u, x, info, error));
}
