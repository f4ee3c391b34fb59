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

void assert_near(const double *x, const double *y, int n, double tol) {
  for (int i = 0; i < n; i++)
    ck_assert_msg(fabs(x[i] - y[i]) <= tol, "[%d] %.17g, expected %.17g within %g", i, x[i], y[i],
                  tol);
}

void assert_close(const double *x, const double *y, int n, double tol) {
  assert_near(x, y, n, tol * largest(y, n));
}

void assert_all(const double *x, int n, double value) {
  for (int i = 0; i < n; i++)
    ck_assert_msg(x[i] == value, "[%d] %.17g, expected %.17g", i, x[i], value);
}

void scale_vector(double *y, const double *x, double factor, int n) {
  for (int i = 0; i < n; i++)
    y[i] = factor * x[i];
}
