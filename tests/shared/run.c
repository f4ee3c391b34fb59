/* run.c: implements run.h. */
#include "run.h"

typedef struct test_row {
  const TTest *test;
  int first, last;
} test_row;

enum { most_rows = 100 };
static test_row rows[most_rows];
static int count;

void enlist_test(const TTest *test, int first, int last) {
  if (count == most_rows) abort();
  int k = count++;
  for (; k > 0 && rows[k - 1].test->line > test->line; k--)
    rows[k] = rows[k - 1];
  rows[k] = (test_row){test, first, last};
}

int run_tests(const char *name, void (*setup)(void), void (*teardown)(void)) {
  Suite *suite = suite_create(name);
  TCase *all = tcase_create(name);
  tcase_set_timeout(all, 300); /* seconds for one test, under a sanitizer too */
  tcase_add_checked_fixture(all, setup, teardown);
  for (int k = 0; k < count; k++)
    tcase_add_loop_test(all, rows[k].test, rows[k].first, rows[k].last);
  suite_add_tcase(suite, all);
  SRunner *runner = srunner_create(suite);
  srunner_run_all(runner, CK_ENV);
  const int failed = srunner_ntests_failed(runner);
  srunner_free(runner);
  return failed ? EXIT_FAILURE : EXIT_SUCCESS;
}

int run_alone(const TTest *test, int first, int last) {
  rows[0] = (test_row){test, first, last};
  count = 1;
  return run_tests(test->name, NULL, NULL);
}

/* The main of a program that has none. */
__attribute__((weak)) int main(int argc, char **argv) {
  (void)argc;
  const char *slash = strrchr(argv[0], '/');
  return run_tests(slash ? slash + 1 : argv[0], NULL, NULL);
}
