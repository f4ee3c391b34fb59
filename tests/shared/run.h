/* run.h: the one way to run a test program. */
#ifndef RUN_H
#define RUN_H

#include <check.h>

/* Runs the suite, frees it and returns what main returns. */
int run_suite(Suite *suite);

#endif
