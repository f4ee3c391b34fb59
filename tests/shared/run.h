/*
 * run.h: what every test program includes. A program without a main of its own runs all its tests.
 */
#ifndef RUN_H
#define RUN_H

#include <check.h>
#include <float.h>
#include <limits.h>
#include <math.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "close.h"
#include "errors.h"
#include "malloc_fails.h"

/* TEST(name) { .. } is a test; TEST_EACH(name, first, last) { .. } one that is called with each
 * number first <= _i < last. Both put themselves on the list of tests, before main. */
#define TEST(name) TEST_EACH(name, 0, 1)
#define TEST_EACH(name, first, last)                                                               \
  static void name(int _i);                                                                        \
  static __attribute__((constructor)) void name##_enlists(void) {                                  \
    static const TTest test = {#name, name, __FILE__, __LINE__};                                   \
    enlist_test(&test, first, last);                                                               \
  }                                                                                                \
  static void name(int _i CK_ATTRIBUTE_UNUSED)

/* Puts a test on the list, which is in the order of lines. */
void enlist_test(const TTest *test, int first, int last);

/* Runs the tests of the list, setup before and teardown after each (NULL: none); returns what main
 * returns. */
int run_tests(const char *name, void (*setup)(void), void (*teardown)(void));

/* The list by hand, as older programs have it: RUN(name, setup, teardown, ONCE(test), ..). */
typedef struct test_row {
  const TTest *test;
  int first, last;
} test_row;
#define ONCE(test)                                                                                 \
  { test, 0, 1 }
#define EACH(test, first, last)                                                                    \
  { test, first, last }
int run_rows(const char *name, const test_row *row, void (*setup)(void), void (*teardown)(void));
#define RUN(name, setup, teardown, ...)                                                            \
  run_rows(name, (const test_row[]){__VA_ARGS__, {NULL, 0, 0}}, setup, teardown)

/* Runs one test alone, which is not on the list: START_TEST(name) { .. }. */
int run_alone(const TTest *test, int first, int last);

#endif
