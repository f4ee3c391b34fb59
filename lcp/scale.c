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
 * moves them along. One round if M has no zero, else two: one pass over M, or four.
 *
 * The mean must not hear of entries that do nothing: in a flexibility that decays along a surface
 * of n points, 2^-|i-j|/L, a row at the end would have a mean smaller than one in the middle by
 * 2^(n/4L), on which Lemke fails if the surface is long enough. Hence, as long as the largest
 * scaled entry of a row differs from row to row by more than 2^20, another round with the values
 *   (S4) max( |M_ij|, 2^-10 sqrt(rowmax_i colmax_j) / 2^(rho_i + gamma_j) )
 * in place of those |M_ij| that are not 0, where rowmax and colmax are the largest
 * 2^(rho_i + gamma_j) |M_ij| of row i and column j. The bound follows a change of units as M_ij
 * does.
 *
 * The logarithms are taken of products of mantissas, one per row or column and 512 entries.
 */
#include <math.h>
#include <stdint.h>
#include <string.h>

#include "lcp_internal.h"

static const double negligible = 0x1p-10; /* (S4) */
static const double uneven = 0x1p20;      /* (S4): row maxima that call for another round */
enum { max_passes = 8 };                  /* (S4) */

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

/* L_i := sum_j log2 v_ij, K_j := sum_i log2 v_ij over the entries that are not 0, v_ij = |M_ij| or,
 * if that is larger, a_i b_j (S4), and how many there are in each row and column; product: n doubles.
 * Returns 1 if M has a zero, else 0. */
static int sum_logarithms(const dls_lcp *lcp, const double *a, const double *b, double *L,
                          double *K, int *in_row, int *in_column, double *product) {
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
        const double least = a[i] * b[j];
        const int some = m[i] != 0;
        double x;
        const double e = split(some && fabs(m[i]) < least ? least : m[i], &x);
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

static double power(double e) {
  return exp2(e < -500 ? -500 : e > 500 ? 500 : e);
}

/* (S4): a, b of the least values; returns the ratio of the largest to the smallest row maximum */
static double least_values(const dls_lcp *lcp, const double *rho, const double *gamma, double *R,
                           double *a, double *b) {
  const int n = lcp->n;
  for (int i = 0; i < n; i++) {
    R[i] = power(rho[i]);
    a[i] = 0;
  }
  for (int j = 0; j < n; j++) {
    const double *m = lcp->M.a + (size_t)j * (size_t)lcp->M.ld, C = power(gamma[j]);
    double largest = 0;
    for (int i = 0; i < n; i++) {
      const double x = fabs(m[i]) * R[i] * C;
      a[i] = x > a[i] ? x : a[i];
      largest = x > largest ? x : largest;
    }
    b[j] = negligible * sqrt(largest) / C;
  }
  double least = INFINITY, most = 0;
  for (int i = 0; i < n; i++) {
    if (a[i] > most) most = a[i];
    if (a[i] > 0 && a[i] < least) least = a[i];
    a[i] = sqrt(a[i]) / R[i];
  }
  return most / least;
}

void dlsi_lcp_equilibrate(const dls_lcp *lcp, double *rho, double *gamma, double *work,
                          int *counts) {
  const int n = lcp->n;
  double *L = work, *K = work + n, *a = work + 2 * n, *b = work + 3 * n, *product = work + 4 * n;
  int *in_row = counts, *in_column = counts + n;
  for (int i = 0; i < n; i++)
    a[i] = b[i] = rho[i] = 0;
  const int zeros = sum_logarithms(lcp, a, b, L, K, in_row, in_column, product);
  for (int round = 0; round < (zeros ? 2 : 1); round++) {
    if (round > 0) sum_over_rows(lcp, gamma, rho);
    solve_one_side(n, L, in_row, rho); /* (S1) */
    sum_over_columns(lcp, zeros, rho, gamma);
    solve_one_side(n, K, in_column, gamma); /* (S2) */
  }
  for (int pass = 0; pass < max_passes; pass++) {
    if (!(least_values(lcp, rho, gamma, product, a, b) > uneven)) break;
    sum_logarithms(lcp, a, b, L, K, in_row, in_column, product); /* (S4) */
    sum_over_rows(lcp, gamma, rho);
    solve_one_side(n, L, in_row, rho);
    sum_over_columns(lcp, zeros, rho, gamma);
    solve_one_side(n, K, in_column, gamma);
  }
  double shift = 0; /* (S3): half of it on each side, so that neither overflows alone */
  for (int i = 0; i < n; i++)
    shift += (gamma[i] - rho[i]) / (2 * n);
  for (int i = 0; i < n; i++) {
    rho[i] += shift;
    gamma[i] -= shift;
  }
}
