/* dense.h: factors of dense matrices. */
#ifndef DLSI_DENSE_H
#define DLSI_DENSE_H

#include "base/base.h"

/* Dense A, n x n (dense.c): does it equal its transpose to the last bit; and x := L^-1 x, L^-T x with
 * the factor L that dpotrf left in A, n >= 0. */
int dlsi_is_symmetric(const double *A, size_t n);
void dlsi_solve_lower(int n, const double *L, double *x);
void dlsi_solve_upper(int n, const double *L, double *x);

#endif
