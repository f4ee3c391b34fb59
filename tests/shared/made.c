/* made.c: implements made.h. */
#include "made.h"

#include <check.h>

dls_solver_settings settings_with(dls_method method, double tol) {
  dls_solver_settings settings;
  dls_solver_settings_init(&settings);
  ck_assert(settings.method == DLS_AUTO && settings.limits.tol == default_tol);
  settings.method = method;
  settings.limits.tol = tol;
  return settings;
}

dls_solver *solver_of(int d, int nc, const dls_solver_settings *settings) {
  dls_solver *solver;
  dls_error error = {0};
  ck_assert_msg(!dls_solver_create(&solver, d, nc, settings, &error), "%s", error.message);
  return solver;
}

dls_reduction *reduction_of(const dls_model *model, const dls_reduction_settings *settings) {
  dls_reduction *reduction;
  dls_error error = {0};
  ck_assert_msg(!dls_reduction_create(&reduction, model, settings, &error), "%s", error.message);
  return reduction;
}

dls_certificate certificate_of(const dls_contact *p, const double *r) {
  dls_certificate c;
  ck_assert_int_eq(dls_contact_certify(p, r, NULL, &c, NULL), DLS_OK);
  return c;
}
