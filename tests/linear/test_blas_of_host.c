/* test_blas_of_host.c: a BLAS that the library cannot call is refused, and does no harm. */
#include <limits.h>
#include <stdint.h>
#include <string.h>

#include "errors.h"
#include "linear/blas.h"
#include "run.h"

/* 1: the first half of 64 bits is the low one, which 32 bits would be. */
#if !defined(__BYTE_ORDER__) || __BYTE_ORDER__ == __ORDER_LITTLE_ENDIAN__
#define LOW_HALF_FIRST 1
#else
#define LOW_HALF_FIRST 0
#endif

#if LOW_HALF_FIRST
static int64_t seen; /* n as a BLAS with integers of 64 bits reads it */

/* dscal_ with such integers. */
static void scale_64(const int *n, const double *alpha, double *x, const int *incx) {
  int64_t step;
  memcpy(&seen, n, sizeof seen);
  memcpy(&step, incx, sizeof step);
  for (int64_t k = 0; k < seen; k++)
    x[k * step] *= *alpha;
}
#endif

static void scale_32(const int *n, const double *alpha, double *x, const int *incx) {
  for (int k = 0; k < *n; k++)
    x[k * *incx] *= *alpha;
}

START_TEST(integers_of_64_bits) {
#if LOW_HALF_FIRST
  dls_error error = {0};
  expect_error(dlsi_check_scale(scale_64, &error), &error, DLS_E_UNSUPPORTED, "", "BLAS", -1);
  ck_assert(strstr(error.message, "ILP64") != NULL);
  ck_assert(seen < 0); /* so that it has touched nothing */
#endif
}
END_TEST

START_TEST(integers_of_32_bits) {
  ck_assert_int_eq(dlsi_check_scale(scale_32, NULL), DLS_OK);
  ck_assert_int_eq(dlsi_check_blas(NULL), DLS_OK);
  ck_assert_int_eq(dlsi_check_product(NULL), DLS_OK);
}
END_TEST

int main(void) {
  return RUN("blas of host", NULL, NULL, ONCE(integers_of_64_bits), ONCE(integers_of_32_bits));
}
