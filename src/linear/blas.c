/*
 * blas.c: refuses a BLAS that the library cannot call.
 *
 * A BLAS with integers of 64 bits reads 64 bits where an int is passed: its neighbour in memory
 * becomes the upper half. The result is a crash, or wrong numbers. The test calls a function that
 * does nothing for n <= 0, with n = 1 and INT_MIN next to it. 64 bits see a negative n, as the
 * lower half comes first in memory. Processors with the upper half first are not checked.
 */
#include "linear/blas.h"

#include <limits.h>

#include "contact/contact.h"

dls_status dlsi_check_scale(dlsi_scale *scale, dls_error *error) {
#if !defined(__BYTE_ORDER__) || __BYTE_ORDER__ == __ORDER_LITTLE_ENDIAN__
  const int n[2] = {1, INT_MIN}, incx[2] = {1, 0};
  const double two = 2;
  double x = 3;
  scale(n, &two, &x, incx);
  if (x != 6)
    return dlsi_fail(error, DLS_E_UNSUPPORTED, "BLAS", -1, x,
                     "has integers of 64 bits (ILP64); link one with 32 (LP64)");
#else
  (void)scale;
  (void)error;
#endif
  return DLS_OK;
}

dls_status dlsi_check_blas(dls_error *error) {
  return dlsi_check_scale(dscal_, error);
}

dls_status dlsi_check_product(dls_error *error) {
  const dls_status status = dlsi_check_blas(error);
  if (status) return status;
  const int one = 1;
  const double alpha = 2, a = 3, b = 5, beta = 7;
  double c = 11;
  dgemm_("T", "N", &one, &one, &one, &alpha, &a, &one, &b, &one, &beta, &c, &one, 1, 1);
  if (c == 2 * 3 * 5 + 7 * 11) return DLS_OK;
  return dlsi_fail(error, DLS_E_UNSUPPORTED, "BLAS", -1, c, "gives %g for a product that is 107",
                   c);
}
