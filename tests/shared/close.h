/* close.h: vectors that should agree, in other units too. */
#ifndef CLOSE_H
#define CLOSE_H

/* max |x_i|; NaN stays */
double largest(const double *x, int n);

/* |x_i - y_i| <= tol max |y| */
void assert_close(const double *x, const double *y, int n, double tol);

/* y := factor x */
void scale_vector(double *y, const double *x, double factor, int n);

#endif
