/* reduced.c: implements reduced.h. */
#include "reduced.h"

#include <check.h>

#include "malloc_fails.h"

dls_contact contact_of(const dls_reduction *R) {
  static const double mu[1000];
  dls_contact problem;
  ck_assert_int_eq(dls_reduction_contact(R, mu, &problem, NULL), DLS_OK);
  ck_assert_int_le(problem.nc, 1000);
  ck_assert_int_eq(dls_contact_check(&problem, NULL), DLS_OK);
  return problem;
}

dls_reduction *create_by_failures(const dls_model *model, const dls_reduction_settings *settings,
                                  int singular, long *count) {
  dls_reduction *R = NULL;
  dls_status status;
  *count = 0;
  do {
    dls_error error = {0};
    malloc_fails_at(++*count);
    status = dls_reduction_create_with(&R, model, settings, &error);
    malloc_fails_at(0);
    if (!status) break;
    if (!singular || status != DLS_E_SINGULAR) ck_assert_int_eq(status, DLS_E_MEMORY);
    ck_assert_int_eq(error.status, status);
    ck_assert_ptr_null(R);
  } while (*count < 1000);
  ck_assert_int_eq(status, DLS_OK);
  return R;
}
