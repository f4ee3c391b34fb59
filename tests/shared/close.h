/* close.h: vectors that should agree, in other units too. */
#ifndef CLOSE_H
#define CLOSE_H

/* max |x_i|; NaN stays */
double largest(const double *x, int n);

/* |x_i - y_i| <= tol max |y| */
void assert_close(const double *x, const double *y, int n, double tol);

/* |x_i - y_i| <= tol */
void assert_near(const double *x, const double *y, int n, double tol);

/* x_i = value */
void assert_all(const double *x, int n, double value);

/* y := factor x */
void scale_vector(double *y, const double *x, double factor, int n);

#endif
