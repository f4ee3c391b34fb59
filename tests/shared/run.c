/* run.c: implements run.h. */
#include "run.h"

#include <stdlib.h>

int run_tests(const char *name, const test_row *rows, void (*setup)(void), void (*teardown)(void)) {
  Suite *suite = suite_create(name);
  TCase *all = tcase_create(name);
  tcase_set_timeout(all, 300); /* seconds for one test, under a sanitizer too */
  tcase_add_checked_fixture(all, setup, teardown);
  for (; rows->test; rows++)
    tcase_add_loop_test(all, rows->test, rows->first, rows->last);
  suite_add_tcase(suite, all);
  SRunner *runner = srunner_create(suite);
  srunner_run_all(runner, CK_ENV);
  const int failed = srunner_ntests_failed(runner);
  srunner_free(runner);
  return failed ? EXIT_FAILURE : EXIT_SUCCESS;
}
