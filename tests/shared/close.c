/* close.c: implements close.h. */
#include "close.h"

#include <check.h>
#include <math.h>

double largest(const double *x, int n) {
  double m = 0;
  for (int i = 0; i < n; i++)
    if (fabs(x[i]) > m || isnan(x[i])) m = fabs(x[i]);
  return m;
}

void assert_close(const double *x, const double *y, int n, double tol) {
  const double scale = largest(y, n);
  for (int i = 0; i < n; i++)
    ck_assert_msg(fabs(x[i] - y[i]) <= tol * scale, "[%d] %.17g, expected %.17g of %g", i, x[i],
                  y[i], scale);
}

void scale_vector(double *y, const double *x, double factor, int n) {
  for (int i = 0; i < n; i++)
    y[i] = factor * x[i];
}
