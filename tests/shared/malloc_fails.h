/*
 * malloc_fails.h: make the k-th allocation of our own code fail. The test programs are linked with
 * --wrap=malloc, so that every malloc, calloc and realloc of libdelassus (not of MUMPS, BLAS,
 * HDF5 or Check) passes through here.
 */
#ifndef MALLOC_FAILS_H
#define MALLOC_FAILS_H

#include <check.h>
#include <stddef.h>

#include "delassus/status.h"

/* The k-th allocation from now on (k = 1, 2, ...) and no other fails; k = 0: none. */
void malloc_fails_at(long k);

/* Allocations since the last malloc_fails_at, and the bytes they asked for. */
long malloc_calls(void);
size_t malloc_bytes(void);

/* The most bytes that our own code has held since the last malloc_fails_at, over those of then. */
long malloc_most(void);

/* Makes a call again and again: its first allocation fails, then its second, .., then none. Each
 * failure has to answer DLS_E_MEMORY and leave `untouched` true; at least `least` fail; the call
 * that meets no failure answers `end`. Finds a call that passes over a failure, too. */
#define MALLOCS_FAIL(call, untouched, end, least)                                                  \
  do {                                                                                             \
    for (mallocs_failed = 0;; mallocs_failed++) {                                                  \
      malloc_fails_at(mallocs_failed + 1);                                                         \
      const dls_status answer_ = (call);                                                           \
      const long calls_ = malloc_calls(); /* Check allocates, too */                               \
      malloc_fails_at(0);                                                                          \
      if (answer_ != DLS_E_MEMORY) {                                                               \
        ck_assert_int_eq(answer_, end);                                                            \
        ck_assert_int_le(calls_, mallocs_failed);                                                  \
        break;                                                                                     \
      }                                                                                            \
      ck_assert(untouched);                                                                        \
    }                                                                                              \
    ck_assert_int_ge(mallocs_failed, least);                                                       \
  } while (0)
extern long mallocs_failed; /* of the last MALLOCS_FAIL */

#endif
