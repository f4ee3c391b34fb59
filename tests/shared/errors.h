/* errors.h: an error that names its place. */
#ifndef ERRORS_H
#define ERRORS_H

#include "delassus/status.h"

/* `answer`, what a function returned, and the error it filled are `status`; the error names the
 * function, the argument and the index in it (-1: none). */
void expect_error(dls_status answer, const dls_error *error, dls_status status,
                  const char *function, const char *argument, long long index);

/* Calls a function of the library with these arguments and an error, which is its last one: it has
 * to refuse. A row of bad input: DLS_E_status, the argument, its index (-1: none), the call. */
#define REFUSES(status, argument, index, function, ...)                                            \
  do {                                                                                             \
    last_refusal = (dls_error){0};                                                                 \
    const dls_status answer_ = function(__VA_ARGS__, &last_refusal);                               \
    expect_error(answer_, &last_refusal, DLS_E_##status, #function, argument, index);              \
  } while (0)
extern dls_error last_refusal; /* the error of the last REFUSES */

#endif
