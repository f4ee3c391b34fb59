/*
 * exact.c: sums of products without any rounding, in one long fixed-point number, and the proof
 * that a contact problem has no solution.
 *
 * A double is an integer of 53 bits times a power of two from 2^-1074 to 2^971. A product of three
 * has 159 bits somewhere between 2^-3222 and 2^3072 (EX1). The sum keeps its digits in 64 bits each
 * and does the carries after 2^30 products, or when its sign is read.
 *
 * The proof is a Farkas vector. Every solution has r in the cones C_mu with u_n = (W r + q)_n >= 0.
 * A v with
 *
 *   v >= 0,   v.q_n < 0,   (W_n^T v).r <= 0 for all r in the cones                  (EX2)
 *
 * excludes that, since then 0 <= v.u_n = (W_n^T v).r + v.q_n < 0. With g_c = sum_a v_a (row n of
 * W_ac) the last condition is g_cn + mu_c |g_ct| <= 0 at each contact. g_n and mu g_t are sums of
 * products of three. In 2D their sum and difference have a sign; in 3D
 *
 *   g_n <= 0,   g_n^2 - (mu g_t)^2 - (mu g_s)^2 >= 0
 *
 * is decided in whole numbers of twice the length.
 *
 * A vector that a method computed satisfies (EX2) up to rounding. Conditions that are equations for
 * it hold exactly, if at all, near it (EX3): for v itself, v without its negligible entries, v in
 * whole numbers, v rounded to few binary digits.
 */
#include "exact.h"

#include <math.h>
#include <string.h>

enum { lowest = -3 * 1074, most_pending = 1 << 30 }; /* (EX1) */
static const double negligible = 1e-12; /* (EX3), of the largest entry: rounding of a few thousand
                                           unknowns */

void dlsi_exact_clear(dlsi_exact *sum) {
  memset(sum, 0, sizeof *sum);
}

static void exact_carry(dlsi_exact *sum) {
  int64_t carry = 0;
  for (int k = 0; k < dlsi_exact_digits; k++) {
    const int64_t x = sum->digit[k] + carry;
    const int64_t low = x & 0xffffffff; /* the digit, 0 .. 2^32 - 1 */
    carry = (x - low) / ((int64_t)1 << 32);
    sum->digit[k] = low;
  }
  sum->digit[dlsi_exact_digits - 1] += carry * ((int64_t)1 << 32);
  sum->pending = 0;
}

/* Splits |x| = m 2^e with an integer m of 53 bits. */
static uint64_t exact_split(double x, int *e) {
  const double f = frexp(fabs(x), e);
  *e -= 53;
  if (*e < -1074) { /* denormal: m has fewer bits */
    const int shift = -1074 - *e;
    *e = -1074;
    return (uint64_t)ldexp(f, 53) >> shift;
  }
  return (uint64_t)ldexp(f, 53);
}

void dlsi_exact_add(dlsi_exact *sum, double a, double b, double c) {
  if (a == 0 || b == 0 || c == 0) return;
  if (++sum->pending >= most_pending) exact_carry(sum);
  int ea, eb, ec;
  const uint64_t ma = exact_split(a, &ea), mb = exact_split(b, &eb), mc = exact_split(c, &ec);
  const int place = ea + eb + ec - lowest, shift = place % 32;
  const int negative = (a < 0) ^ (b < 0) ^ (c < 0);
  /* factors in digits of 32 bits; the product in columns that fit into 64 bits after each carry */
  const uint64_t x[2] = {ma & 0xffffffff, ma >> 32}, y[2] = {mb & 0xffffffff, mb >> 32};
  const uint64_t z[2] = {mc & 0xffffffff, mc >> 32};
  uint64_t p[4] = {0}, r[7] = {0};
  for (int i = 0; i < 2; i++) {
    uint64_t carry = 0;
    for (int j = 0; j < 2; j++) {
      const uint64_t t = x[i] * y[j] + p[i + j] + carry;
      p[i + j] = t & 0xffffffff;
      carry = t >> 32;
    }
    p[i + 2] += carry;
  }
  for (int i = 0; i < 4; i++) {
    uint64_t carry = 0;
    for (int j = 0; j < 2; j++) {
      const uint64_t t = p[i] * z[j] + r[i + j] + carry;
      r[i + j] = t & 0xffffffff;
      carry = t >> 32;
    }
    for (int k = i + 2; carry && k < 7; k++) {
      const uint64_t t = r[k] + carry;
      r[k] = t & 0xffffffff;
      carry = t >> 32;
    }
  }
  uint64_t carry = 0;
  for (int k = 0; k < 7; k++) {
    const uint64_t t = (r[k] << shift) | carry;
    const int64_t digit = (int64_t)(t & 0xffffffff);
    sum->digit[place / 32 + k] += negative ? -digit : digit;
    carry = t >> 32;
  }
}

int dlsi_exact_sign(dlsi_exact *sum) {
  exact_carry(sum);
  int64_t top = sum->digit[dlsi_exact_digits - 1];
  if (top < 0) return -1;
  for (int k = 0; k < dlsi_exact_digits; k++)
    if (sum->digit[k]) return 1;
  return 0;
}

/* sum := row `part` of the block of contact c in v.W_n, times `factor`. */
static void exact_row(const dlsi_block_column *W, int part, double factor, const double *v,
                      dlsi_exact *sum) {
  for (size_t k = W->begin; k < W->end; k++)
    dlsi_exact_add(sum, v[dlsi_row(W, k)], W->x[k * W->step + (size_t)part * W->ld], factor);
}

/* square := square + turn sum^2, digits of 32 bits with postponed carries. */
static void exact_add_square(dlsi_exact *sum, int turn, int64_t square[2 * dlsi_exact_digits + 1]) {
  enum { n = dlsi_exact_digits };
  const int negative = dlsi_exact_sign(sum) < 0;
  uint64_t digit[n];
  int first = n, end = 0;
  for (int k = 0, carry = negative; k < n; k++) { /* |sum|: two's complement by digits */
    const uint64_t low = (uint64_t)sum->digit[k] & 0xffffffff;
    digit[k] = negative ? (low ^ 0xffffffff) + (uint64_t)carry : low;
    carry = negative && carry && digit[k] >> 32;
    digit[k] &= 0xffffffff;
    if (!digit[k]) continue;
    first = k < first ? k : first;
    end = k + 1;
  }
  for (int i = first; i < end; i++)
    for (int j = first; j < end; j++) {
      const uint64_t p = digit[i] * digit[j];
      square[i + j] += turn * (int64_t)(p & 0xffffffff);
      square[i + j + 1] += turn * (int64_t)(p >> 32);
    }
}

/* Returns 1 if g_n <= 0 and g_n^2 >= h[0]^2 + h[1]^2. */
static int exact_in_cone(dlsi_exact *gn, dlsi_exact h[2]) {
  int64_t square[2 * dlsi_exact_digits + 1] = {0}, carry = 0;
  if (dlsi_exact_sign(gn) > 0) return 0;
  exact_add_square(gn, 1, square);
  exact_add_square(&h[0], -1, square);
  exact_add_square(&h[1], -1, square);
  for (int k = 0; k <= 2 * dlsi_exact_digits; k++) {
    const int64_t x = square[k] + carry;
    carry = (x - (x & 0xffffffff)) / ((int64_t)1 << 32);
  }
  return carry >= 0;
}

/* Returns 1 if g_n + mu |g_t| <= 0 holds at contact c (EX2). */
static int exact_holds_at(const dls_contact *problem, int c, const double *v) {
  const dlsi_block_column W = dlsi_contact_column(problem, (size_t)c);
  const double mu = problem->mu[c];
  dlsi_exact gn, h[2];
  for (int side = -1; problem->d == 2 && side <= 1; side += 2) {
    dlsi_exact_clear(&gn);
    exact_row(&W, 0, 1, v, &gn);
    exact_row(&W, 1, side * mu, v, &gn);
    if (dlsi_exact_sign(&gn) > 0) return 0;
  }
  if (problem->d == 2) return 1;
  dlsi_exact_clear(&gn);
  exact_row(&W, 0, 1, v, &gn);
  if (problem->d == 1) return dlsi_exact_sign(&gn) <= 0;
  for (int i = 0; i < 2; i++) {
    dlsi_exact_clear(&h[i]);
    exact_row(&W, i + 1, mu, v, &h[i]);
  }
  return exact_in_cone(&gn, h);
}

int dlsi_contact_is_infeasible(const dls_contact *problem, const double *v) {
  dlsi_exact sum;
  dlsi_exact_clear(&sum);
  for (int c = 0; c < problem->nc; c++) {
    if (!(v[c] >= 0 && isfinite(v[c]))) return 0;
    dlsi_exact_add(&sum, v[c], problem->q[(size_t)problem->d * (size_t)c], 1);
  }
  if (dlsi_exact_sign(&sum) >= 0) return 0;
  for (int c = 0; c < problem->nc; c++)
    if (!exact_holds_at(problem, c, v)) return 0;
  return 1;
}

/* ---- vectors near a proof -------------------------------------------------------------------- */

/* Returns the least k <= most with |x - h / k| <= within for a whole h, from the continued fraction
 * of x; 0 if there is none. */
static double exact_denominator(double x, double within, double most) {
  double rest = x - floor(x), h0 = 1, k0 = 0, h = floor(x), k = 1;
  while (fabs(x - h / k) > within) {
    const double whole = floor(1 / rest), h2 = whole * h + h0, k2 = whole * k + k0;
    if (!(k2 <= most)) return 0;
    rest = 1 / rest - whole;
    h0 = h;
    k0 = k;
    h = h2;
    k = k2;
  }
  return k;
}

/* whole := v times a factor that makes all entries whole numbers up to rounding; returns 0 if there
 * is none. */
static int exact_to_whole(size_t n, const double *v, double *whole) {
  const double largest = dlsi_max_abs(v, n), most = 0x1p31;
  double factor = 1;
  for (size_t i = 0; i < n; i++) {
    const double k = exact_denominator(v[i] / largest * factor, negligible * factor, most / factor);
    if (k == 0) return 0;
    factor *= k;
  }
  for (size_t i = 0; i < n; i++)
    whole[i] = nearbyint(v[i] / largest * factor);
  return 1;
}

/* Rounds v to `bits` binary digits of its largest entry. */
static void exact_round(int bits, size_t n, const double *v, double *rounded) {
  int e;
  (void)frexp(dlsi_max_abs(v, n), &e);
  for (size_t i = 0; i < n; i++)
    rounded[i] = ldexp(nearbyint(ldexp(v[i], bits - e)), e - bits);
}

int dlsi_find_exact(size_t n, double *v, double *work,
                    int (*holds)(const void *problem, const double *v), const void *problem) {
  static const int bits[] = {53, 40, 30, 20, 12, 8, 5, 3};
  const double largest = dlsi_max_abs(v, n);
  if (!(largest > 0 && isfinite(largest))) return 0;
  if (holds(problem, v)) return 1;
  for (size_t i = 0; i < n; i++)
    work[i] = v[i] < negligible * largest ? 0 : v[i];
  int found = holds(problem, work) || (exact_to_whole(n, v, work) && holds(problem, work));
  for (size_t k = 0; !found && k < sizeof bits / sizeof bits[0]; k++) {
    exact_round(bits[k], n, v, work);
    found = holds(problem, work);
  }
  if (found) memcpy(v, work, n * sizeof *v);
  return found;
}

static int exact_is_contact_proof(const void *problem, const double *v) {
  return dlsi_contact_is_infeasible(problem, v);
}

int dlsi_contact_find_proof(const dls_contact *problem, double *v, double *work) {
  return dlsi_find_exact((size_t)problem->nc, v, work, exact_is_contact_proof, problem);
}
