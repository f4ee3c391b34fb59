/* errors.c: what errors.h says. */
#include "errors.h"

#include <check.h>

void expect_error(dls_status answer, const dls_error *error, dls_status status,
                  const char *function, const char *argument, long long index) {
  ck_assert_int_eq(answer, status);
  ck_assert_int_eq(error->status, status);
  ck_assert_str_eq(error->function, function);
  ck_assert_str_eq(error->argument, argument);
  ck_assert_int_eq(error->index, index);
}
