/* run.h: runs a test program. */
#ifndef RUN_H
#define RUN_H

#include <check.h>
#include <stddef.h>

/* A test and the numbers first <= _i < last that it is called with. */
typedef struct test_row {
  const TTest *test;
  int first, last;
} test_row;

#define ONCE(test)                                                                                 \
  { test, 0, 1 }
#define EACH(test, first, last)                                                                    \
  { test, first, last }

/* Runs the rows up to the one without a test, setup before and teardown after each (NULL: none);
 * returns what main returns. RUN takes the rows as arguments. */
int run_tests(const char *name, const test_row *rows, void (*setup)(void), void (*teardown)(void));
#define RUN(name, setup, teardown, ...)                                                            \
  run_tests(name, (const test_row[]){__VA_ARGS__, {NULL, 0, 0}}, setup, teardown)

#endif
