/* close.h: vectors that should agree. */
#ifndef CLOSE_H
#define CLOSE_H

/* max |x_i|; NaN stays */
double largest(const double *x, int n);

/* |x_i - y_i| <= tol max |y| */
void assert_close(const double *x, const double *y, int n, double tol);

#endif
