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

/* TEST_ALONE(name) { .. } is on no list: main runs it by run_alone(name, first, last). */
#define TEST_ALONE(name)                                                                           \
  static void name##_runs(int _i);                                                                 \
  static const TTest name[] = {{#name, name##_runs, __FILE__, __LINE__}};                          \
  static void name##_runs(int _i CK_ATTRIBUTE_UNUSED)
#undef START_TEST /* of Check: no list would hold it */
int run_alone(const TTest *test, int first, int last);

#endif
