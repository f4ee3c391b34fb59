/* reduced.c: implements reduced.h. */
#include "reduced.h"

#include <check.h>

#include "malloc_fails.h"

dls_status reduce_on_W(dls_reduction **out, const dls_model *model,
                       const dls_reduction_settings *settings, dls_error *error) {
  dls_reduction_settings s;
  dls_reduction_settings_init(&s);
  if (settings) s = *settings;
  if (s.on == DLS_ON_EITHER) s.on = DLS_ON_W;
  return dls_reduction_create(out, model, &s, error);
}

dls_contact contact_of(const dls_reduction *R) {
  static const double mu[1000];
  dls_contact problem;
  ck_assert_int_eq(dls_reduction_contact(R, mu, &problem, NULL), DLS_OK);
  ck_assert_int_le(problem.nc, 1000);
  ck_assert_int_eq(dls_contact_check(&problem, NULL), DLS_OK);
  return problem;
}

dls_reduction *create_by_failures(const dls_model *model, const dls_reduction_settings *settings,
                                  long *count) {
  dls_reduction *R = NULL;
  dls_error error = {0};
  MALLOCS_FAIL(reduce_on_W(&R, model, settings, &error), !R && error.status == DLS_E_MEMORY, DLS_OK,
               1);
  *count = mallocs_failed + 1;
  return R;
}
