/*
 * scale.c: scales an LCP. For positive diagonal R, C the problem (R M C, R q) has the solutions
 * C^-1 z, R^-1 y. Positive factors do not change complementarity, but they change what the
 * tolerances of a pivoting method mean.
 *
 * Least squares in the logarithms (Curtis and Reid, J. Inst. Maths Applics 10, 1972, 118-124):
 *
 *   min over rho, gamma of  sum over M_ij != 0 of ( log2|M_ij| + rho_i + gamma_j )^2
 *
 * by alternating rows and columns from gamma = 0:
 *   (SC1) rho_i   = -mean_j( log2|M_ij| + gamma_j )
 *   (SC2) gamma_j = -mean_i( log2|M_ij| + rho_i )
 *   (SC3) rho_i += t, gamma_j -= t, so that both have the same mean
 * One round is exact if M has no zero. After any number of rounds M -> a R M gives the same R M C.
 * A row or column of zeros gets the mean of the others, so that a change of units moves it along.
 * Rounds: one if M has no zero (two passes over M), else two (three passes).
 *
 * Negligible entries must not enter the mean. Example: in a flexibility 2^-|i-j|/L along a surface
 * of n points the mean of a row at the end is 2^(n/4L) smaller than in the middle, and Lemke fails
 * if the surface is long enough. Hence, while row maxima differ by more than 2^20, another round
 * uses the values
 *   (SC4) max( |M_ij|, 2^-10 sqrt(rowmax_i colmax_j) / 2^(rho_i + gamma_j) )
 * for each |M_ij| != 0, where rowmax and colmax are the largest 2^(rho_i + gamma_j) |M_ij| of row i
 * and column j. The bound changes with units as M_ij does. Such a round takes two passes over M.
 *
 * A round is one pass over M. While column j is in the cache it gives gamma_j of (SC2) and its
 * terms in the sums of the next (SC1) and in the row maxima of (SC4). A logarithm is taken of a
 * product of up to 512 mantissas. Sums and products of a column run in eight chains, which the
 * compiler can vectorise.
 */
#include <math.h>
#include <stdint.h>
#include <string.h>

#include "lcp_internal.h"

static const double negligible = 0x1p-10; /* (SC4) */
static const double uneven = 0x1p20;      /* (SC4): ratio of row maxima for another round */
enum { max_passes = 8 };                  /* (SC4) */
enum { chunk = 512 };                     /* mantissas in one product, which is less than 2^512 */

typedef enum scale_fold_kind { fold_sum, fold_product, fold_largest } scale_fold_kind;

static DLSI_INLINE double scale_combine(scale_fold_kind kind, double a, double b) {
  return kind == fold_sum ? a + b : kind == fold_product ? a * b : b > a ? b : a;
}

/* Returns the sum, the product or the largest of x_i >= 0 (n), eight chains at a time. */
static DLSI_INLINE double scale_fold(scale_fold_kind kind, int n, const double *x) {
  const double start = kind == fold_product;
  double f[8] = {start, start, start, start, start, start, start, start};
  int i = 0;
  for (; i + 8 <= n; i += 8)
    for (int k = 0; k < 8; k++)
      f[k] = scale_combine(kind, f[k], x[i + k]);
  for (; i < n; i++)
    f[0] = scale_combine(kind, f[0], x[i]);
  for (int k = 0; k < 4; k++)
    f[k] = scale_combine(kind, f[k], f[k + 4]);
  return scale_combine(kind, scale_combine(kind, f[0], f[1]), scale_combine(kind, f[2], f[3]));
}

static double scale_power(double e) {
  return exp2(e < -500 ? -500 : e > 500 ? 500 : e);
}

double dlsi_power_of_two(double e) {
  return scale_power(rint(e));
}

/* Splits x > 0 into m 2^(e - 1023), 1 <= m < 2, and returns e (subnormal x: m is too large by less
 * than 2); x = 0 gives m = 1, e = 0. The exponent becomes a double as the last digits of
 * 2^52 + e. */
static DLSI_INLINE double scale_split(double x, double *m) {
  uint64_t bits;
  double e;
  memcpy(&bits, &x, sizeof bits);
  const uint64_t exponent = bits >> 52 | 0x4330000000000000;
  bits = (bits & 0xfffffffffffff) | 0x3ff0000000000000;
  memcpy(&e, &exponent, sizeof e);
  memcpy(m, &bits, sizeof bits);
  return e - 0x1p52;
}

/* The state of the rounds; n doubles each. */
typedef struct scale_sums {
  double *L, *K;              /* sums of log2 v_ij over row i, column j */
  double *in_row, *in_column; /* number of entries that are not 0 */
  double *R, *a;              /* 2^rho_i; largest 2^(rho_i + gamma_j) |M_ij| of a row */
  double *next;               /* sums of gamma_j over row i */
  double *product, *scratch;
} scale_sums;

/* v_i := |M_ij|, raised to the least value a_i b of (SC4) unless a is NULL or M_ij is 0. */
static DLSI_INLINE void scale_take_values(int count, const double *m, const double *a, double b,
                                          double *v) {
  for (int i = 0; i < count; i++) {
    const double x = fabs(m[i]), least = a ? a[i] * b : 0;
    v[i] = ((x > 0) & (x < least)) ? least : x;
  }
}

/* Counts the entries of column j, m, in in_row and in_column. */
static DLSI_INLINE void scale_count(int n, const double *m, int j, const scale_sums *s) {
  for (int i = 0; i < n; i++) {
    s->scratch[i] = m[i] != 0 ? 1 : 0;
    s->in_row[i] += s->scratch[i];
  }
  s->in_column[j] = scale_fold(fold_sum, n, s->scratch);
}

/* Computes L, K and the counts of the values v_ij = |M_ij|; if `least`, L and K of the values
 * (SC4), with a_i := sqrt(rowmax_i) / 2^rho_i. Returns 1 if M has a zero, else 0. */
DLSI_CLONES static int scale_sum_logarithms(const dls_lcp *lcp, int least, const double *gamma,
                                            const scale_sums *s) {
  const int n = lcp->n;
  double *product = s->product, e[chunk], x[chunk];
  int zeros = 0;
  for (int i = 0; i < n; i++) {
    s->L[i] = 0;
    product[i] = 1;
    if (least)
      s->a[i] = sqrt(s->a[i]) / s->R[i];
    else
      s->in_row[i] = 0;
  }
  for (int j = 0; j < n; j++) {
    const double *m = dlsi_lcp_column(lcp, j);
    double b = 0, exponents = 0, logarithms = 0;
    if (least) {
      for (int i = 0; i < n; i++)
        s->scratch[i] = fabs(m[i]) * s->R[i];
      const double C = scale_power(gamma[j]);
      b = negligible * sqrt(scale_fold(fold_largest, n, s->scratch) * C) / C;
    } else
      scale_count(n, m, j, s);
    for (int first = 0; first < n; first += chunk) {
      const int length = n - first < chunk ? n - first : chunk;
      double *L = s->L + first, *p = product + first;
      scale_take_values(length, m + first, least ? s->a + first : NULL, b, x);
      for (int i = 0; i < length; i++) {
        e[i] = scale_split(x[i], &x[i]);
        L[i] += e[i];
        p[i] *= x[i];
      }
      exponents += scale_fold(fold_sum, length, e);
      logarithms += log2(scale_fold(fold_product, length, x));
    }
    s->K[j] = exponents - 1023 * s->in_column[j] + logarithms;
    zeros |= s->in_column[j] < n;
    if (j % chunk == chunk - 1 || j == n - 1)
      for (int i = 0; i < n; i++) {
        s->L[i] += log2(product[i]);
        product[i] = 1;
      }
  }
  for (int i = 0; i < n; i++)
    s->L[i] -= 1023 * s->in_row[i];
  return zeros;
}

/* x_i := the mean of the others where the count is 0. */
static void scale_fill_empty(int n, const double *count, double *x) {
  double sum = 0, filled = 0;
  for (int i = 0; i < n; i++)
    if (count[i] > 0) {
      sum += x[i];
      filled++;
    }
  for (int i = 0; filled < n && i < n; i++)
    if (!(count[i] > 0)) x[i] = filled > 0 ? sum / filled : 0;
}

/* (SC1) with `next` of the round before, then (SC2). */
DLSI_CLONES static void scale_alternate(const dls_lcp *lcp, const scale_sums *s, double *rho,
                                        double *gamma) {
  const int n = lcp->n;
  for (int i = 0; i < n; i++)
    rho[i] = -(s->L[i] + s->next[i]) / s->in_row[i];
  scale_fill_empty(n, s->in_row, rho);
  for (int i = 0; i < n; i++) {
    s->R[i] = scale_power(rho[i]);
    s->next[i] = s->a[i] = 0;
  }
  for (int j = 0; j < n; j++) {
    const double *m = dlsi_lcp_column(lcp, j);
    for (int i = 0; i < n; i++) {
      const double x = rho[i];
      s->scratch[i] = m[i] != 0 ? x : 0;
    }
    if (!(s->in_column[j] > 0)) continue;
    const double x = -(s->K[j] + scale_fold(fold_sum, n, s->scratch)) / s->in_column[j],
                 C = scale_power(x);
    gamma[j] = x;
    for (int i = 0; i < n; i++) {
      const double size = fabs(m[i]) * s->R[i] * C;
      s->next[i] += m[i] != 0 ? x : 0;
      s->a[i] = size > s->a[i] ? size : s->a[i];
    }
  }
  scale_fill_empty(n, s->in_column, gamma);
}

/* Returns the ratio of the largest to the smallest row maximum. */
static double scale_unevenness(int n, const double *a) {
  double least = INFINITY, most = 0;
  for (int i = 0; i < n; i++) {
    if (a[i] > most) most = a[i];
    if (a[i] > 0 && a[i] < least) least = a[i];
  }
  return most / least;
}

void dlsi_lcp_equilibrate(const dls_lcp *lcp, double *rho, double *gamma, double *work) {
  const size_t n = (size_t)lcp->n;
  const scale_sums s = {work,         work + n,     work + 2 * n, work + 3 * n, work + 4 * n,
                        work + 5 * n, work + 6 * n, work + 7 * n, work + 8 * n};
  const int zeros = scale_sum_logarithms(lcp, 0, gamma, &s);
  memset(s.next, 0, n * sizeof *s.next);
  scale_alternate(lcp, &s, rho, gamma);
  if (zeros) scale_alternate(lcp, &s, rho, gamma);
  for (int pass = 0; pass < max_passes && scale_unevenness(lcp->n, s.a) > uneven; pass++) {
    scale_sum_logarithms(lcp, 1, gamma, &s);
    scale_alternate(lcp, &s, rho, gamma);
  }
  double shift = 0; /* (SC3): half of it on each side, so that neither overflows alone */
  for (size_t i = 0; i < n; i++)
    shift += (gamma[i] - rho[i]) / (2 * (double)n);
  for (size_t i = 0; i < n; i++) {
    rho[i] += shift;
    gamma[i] -= shift;
  }
}
