/*
 * scale.c: the scaling of an LCP. For positive diagonal R, C the problem (R M C, R q) has the
 * solutions C^-1 z, R^-1 y: complementarity does not see positive factors, the tolerances of a
 * pivoting method do.
 *
 * Least squares in the logarithms (Curtis and Reid, J. Inst. Maths Applics 10, 1972, 118-124):
 *
 *   min over rho, gamma of  sum over M_ij != 0 of ( log2|M_ij| + rho_i + gamma_j )^2
 *
 * by alternating rows and columns from gamma = 0:
 *   (S1) rho_i   = -mean_j( log2|M_ij| + gamma_j )
 *   (S2) gamma_j = -mean_i( log2|M_ij| + rho_i )
 *   (S3) rho_i += t, gamma_j -= t, so that both have the same mean
 * exact after one round if M has no zero, and after any number of rounds M -> a R M gives the
 * same R M C. Rows or columns of zeros get the mean of the others, so that a change of units
 * moves them along. One round if M has no zero, else two: one pass over M, or four. The
 * logarithms are taken of products of mantissas, one per row or column and 512 entries.
 */
#include <math.h>
#include <stdint.h>
#include <string.h>

#include "lcp_internal.h"

/* |x| = m 2^e with 1 <= m < 2 (for subnormal x: m is too large by less than 2); 1 2^0 for x = 0 */
static double split(double x, double *m) {
  uint64_t bits;
  memcpy(&bits, &x, sizeof bits);
  bits = x == 0 ? 0x3ff0000000000000 : bits;
  const int e = (int)(bits >> 52 & 0x7ff) - 1023;
  bits = (bits & 0xfffffffffffff) | 0x3ff0000000000000;
  memcpy(m, &bits, sizeof bits);
  return e;
}

/* L_i := sum_j log2|M_ij|, K_j := sum_i log2|M_ij| over the entries that are not 0, and how many
 * there are in each row and column; product: n doubles. Returns 1 if M has a zero, else 0. */
static int sum_logarithms(const dls_lcp *lcp, double *L, double *K, int *in_row, int *in_column,
                          double *product) {
  const int n = lcp->n;
  int zeros = 0;
  for (int i = 0; i < n; i++) {
    L[i] = 0;
    in_row[i] = 0;
    product[i] = 1;
  }
  for (int j = 0; j < n; j++) {
    const double *m = lcp->M.a + (size_t)j * (size_t)lcp->M.ld;
    double sum = 0;
    int count = 0;
    for (int first = 0; first < n; first += 512) {
      double exponents = 0, mantissas = 1;
      const int end = n - first < 512 ? n : first + 512;
      for (int i = first; i < end; i++) {
        double x;
        const double e = split(m[i], &x);
        const int some = m[i] != 0;
        L[i] += e;
        product[i] *= x;
        in_row[i] += some;
        exponents += e;
        mantissas *= x;
        count += some;
      }
      sum += exponents + log2(mantissas);
    }
    K[j] = sum;
    in_column[j] = count;
    zeros |= count < n;
    if (j % 512 == 511 || j == n - 1)
      for (int i = 0; i < n; i++) {
        L[i] += log2(product[i]);
        product[i] = 1;
      }
  }
  return zeros;
}

/* x_i := -( L_i + x_i ) / count_i; where count is 0, the mean of the others */
static void solve_one_side(int n, const double *L, const int *count, double *x) {
  double sum = 0;
  int filled = 0;
  for (int i = 0; i < n; i++)
    if (count[i]) {
      x[i] = -(L[i] + x[i]) / count[i];
      sum += x[i];
      filled++;
    }
  for (int i = 0; i < n; i++)
    if (!count[i]) x[i] = filled ? sum / filled : 0;
}

/* rho_i := sum of gamma_j over M_ij != 0 */
static void sum_over_rows(const dls_lcp *lcp, const double *gamma, double *rho) {
  const int n = lcp->n;
  for (int i = 0; i < n; i++)
    rho[i] = 0;
  for (int j = 0; j < n; j++) {
    const double *m = lcp->M.a + (size_t)j * (size_t)lcp->M.ld;
    for (int i = 0; i < n; i++)
      rho[i] += m[i] != 0 ? gamma[j] : 0;
  }
}

/* gamma_j := sum of rho_i over M_ij != 0 */
static void sum_over_columns(const dls_lcp *lcp, int zeros, const double *rho, double *gamma) {
  const int n = lcp->n;
  double total = 0;
  for (int i = 0; i < n; i++)
    total += rho[i];
  for (int j = 0; j < n; j++) {
    gamma[j] = total;
    if (!zeros) continue;
    const double *m = lcp->M.a + (size_t)j * (size_t)lcp->M.ld;
    for (int i = 0; i < n; i++)
      gamma[j] -= m[i] == 0 ? rho[i] : 0;
  }
}

void dlsi_lcp_equilibrate(const dls_lcp *lcp, double *rho, double *gamma, double *work,
                          int *counts) {
  const int n = lcp->n;
  double *L = work, *K = work + n;
  int *in_row = counts, *in_column = counts + n;
  const int zeros = sum_logarithms(lcp, L, K, in_row, in_column, gamma);
  for (int i = 0; i < n; i++)
    rho[i] = 0;
  for (int round = 0; round < (zeros ? 2 : 1); round++) {
    if (round > 0) sum_over_rows(lcp, gamma, rho);
    solve_one_side(n, L, in_row, rho); /* (S1) */
    sum_over_columns(lcp, zeros, rho, gamma);
    solve_one_side(n, K, in_column, gamma); /* (S2) */
  }
  double shift = 0; /* (S3): half of it on each side, so that neither overflows alone */
  for (int i = 0; i < n; i++)
    shift += (gamma[i] - rho[i]) / (2 * n);
  for (int i = 0; i < n; i++) {
    rho[i] += shift;
    gamma[i] -= shift;
  }
}
