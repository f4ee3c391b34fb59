/* errors.h: an error that names its place. */
#ifndef ERRORS_H
#define ERRORS_H

#include "delassus/status.h"

/* `answer`, what a function returned, and the error it filled are `status`; the error names the
 * function, the argument and the index in it (-1: none). */
void expect_error(dls_status answer, const dls_error *error, dls_status status,
                  const char *function, const char *argument, long long index);

#endif
