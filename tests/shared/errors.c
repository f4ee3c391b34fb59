/*
 * errors.c: implements errors.h. Also checks every error in a test program: it has an index if its
 * words are about one entry, and no index if not. The programs are linked with --wrap=dlsi_fail, so
 * that each report passes through here.
 */
#include "errors.h"

#include <check.h>
#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "contact/contact.h"

/* How messages begin that tell of one entry of their argument. */
static const char *const of_an_entry[] = {
    "is not finite",
    "is negative",
    "is not the middle",
    "is outside of",
    "is less than the one",
    "is a lower triangle",
    "is an upper triangle",
    "is infinite",
    "is %g, must be > 0",
    "is %g, must be 0",
    "is %g, but model.mu",
    "is %s",
    "is %d, as the other",
    "is %d, must be from -1",
    "is %d, must be in 0",
    "is %d, outside of -1",
    "is %d, outside of 0",
    "is %d, outside of %d",
    "is there twice",
    "face %d",
    "body %d",
    "must be 0",
    "must be positive",
    "line %lld",
    "%.150s", /* of problem k */
    "is a character that XML",
    "column %d",
    "element %d",
    "triangle %d",
    "does not ascend",
    "does not follow",
    "a connected part",
    "at the border of",
    "no unknown of an element",
    "edge of no finite length",
    "entries of one place",
    "gives a W",
    "left a result",
    "not positive definite:",
    "overflow",
    "singular: %d",
    "singular: condition",
    "singular: pivot",
    "the diagonal entry",
    "the pattern is not",
    "the pivot of",
};

/* Of an operator's column, or of all its columns: with an index or without. */
static const char either_way[] = "%s; condense this model";

dls_status __real_dlsi_fail(dls_error *error, dls_status status, const char *argument,
                            long long index, double value, const char *format, ...)
    DLSI_PRINTF(6, 7);
dls_status __wrap_dlsi_fail(dls_error *error, dls_status status, const char *argument,
                            long long index, double value, const char *format, ...)
    DLSI_PRINTF(6, 7);

/* Returns 1 if a message has this beginning of a table. */
static int tells_of_an_entry(const char *format) {
  for (size_t k = 0; k < sizeof of_an_entry / sizeof of_an_entry[0]; k++)
    if (strncmp(format, of_an_entry[k], strlen(of_an_entry[k])) == 0) return 1;
  return 0;
}

dls_status __wrap_dlsi_fail(dls_error *error, dls_status status, const char *argument,
                            long long index, double value, const char *format, ...) {
  char text[170];
  va_list args;
  va_start(args, format);
  const int wrote = vsnprintf(text, sizeof text, format, args);
  va_end(args);
  double said;
  int sound = wrote >= 0 && status < 0 && index >= -1;
  if (strcmp(format, either_way) != 0) sound &= (index >= 0) == tells_of_an_entry(format);
  /* a number that is said is the offending value */
  if (strncmp(format, "is %", 4) == 0 && sscanf(text, "is %lf", &said) == 1)
    sound &= said == value || said != said || fabs(said - value) <= 1e-5 * fabs(value);
  const char *const pivot = strstr(text, ": pivot ");
  if (pivot && sscanf(pivot, ": pivot %lf", &said) == 1)
    sound &= said == value || said != said || fabs(said - value) <= 1e-2 * fabs(value);
  if (!sound) {
    (void)fprintf(stderr,
                  "an error with another index or value than it tells of: %s[%lld] %g: %s\n",
                  argument, index, value, text);
    abort();
  }
  return __real_dlsi_fail(error, status, argument, index, value, "%s", text);
}

dls_error last_refusal;

void expect_error(dls_status answer, const dls_error *error, dls_status status,
                  const char *function, const char *argument, long long index) {
  ck_assert_int_eq(answer, status);
  ck_assert_int_eq(error->status, status);
  ck_assert_str_eq(error->function, function);
  ck_assert_str_eq(error->argument, argument);
  ck_assert_int_eq(error->index, index);
}
