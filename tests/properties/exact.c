/*
 * exact.c: sums of products of doubles without rounding, and Farkas' proof checked by them.
 *
 * A double is an integer of 53 bits times a power of two, so a product of three is one of 159
 * bits times a power of two between 2^-3378 and 2^2913. The sum is kept in fixed point as limbs
 * of 32 bits in integers of 64: 2^31 products can be added before the carries must be passed on.
 */
#include <math.h>
#include <string.h>

#include "problem.h"

enum { lowest_power = -3392 }; /* of limb 0; a multiple of 32 */

void exact_clear(exact *sum) {
  memset(sum, 0, sizeof *sum);
}

/* product (count + 2 limbs) *= the integer that x is a multiple of; adds the exponent to *power. */
static void exact_multiply(uint32_t *product, int count, double x, int *power) {
  int exponent;
  const uint64_t integer = (uint64_t)ldexp(frexp(fabs(x), &exponent), 53);
  const uint64_t factor[2] = {integer & 0xffffffffu, integer >> 32};
  uint32_t out[8] = {0};
  for (int k = 0; k < 2; k++) {
    uint64_t carry = 0;
    for (int i = 0; i < count; i++) {
      const uint64_t t = factor[k] * product[i] + out[i + k] + carry;
      out[i + k] = (uint32_t)t;
      carry = t >> 32;
    }
    out[count + k] = (uint32_t)carry;
  }
  memcpy(product, out, sizeof out);
  *power += exponent - 53;
}

void exact_add(exact *sum, double a, double b, double c) {
  if (a == 0 || b == 0 || c == 0) return;
  uint32_t product[8] = {1};
  int power = 0;
  exact_multiply(product, 1, a, &power);
  exact_multiply(product, 3, b, &power);
  exact_multiply(product, 5, c, &power);
  const int negative = (a < 0) ^ (b < 0) ^ (c < 0);
  const int at = power - lowest_power, first = at / 32, shift = at % 32;
  for (int i = 0; i < 7; i++) {
    const uint64_t t = (uint64_t)product[i] << shift;
    const int64_t low = (int64_t)(t & 0xffffffffu), high = (int64_t)(t >> 32);
    sum->limb[first + i] += negative ? -low : low;
    sum->limb[first + i + 1] += negative ? -high : high;
  }
}

int exact_sign(exact *sum) {
  int64_t carry = 0, any = 0;
  for (int i = 0; i < EXACT_LIMBS; i++) {
    const int64_t x = sum->limb[i] + carry, low = (int64_t)((uint64_t)x & 0xffffffffu);
    carry = (x - low) / 4294967296;
    sum->limb[i] = low;
    any |= low;
  }
  sum->limb[EXACT_LIMBS - 1] += carry * 4294967296; /* keeps the value for further sums */
  return carry < 0 ? -1 : (any || carry) ? 1 : 0;
}

double exact_round(exact *sum) {
  const int negative = exact_sign(sum) < 0;
  exact size = *sum;
  if (negative) {
    for (int i = 0; i < EXACT_LIMBS; i++)
      size.limb[i] = -size.limb[i];
    (void)exact_sign(&size);
  }
  double out = 0; /* at most 97 bits of the largest limbs count, and each is added to less */
  int first = EXACT_LIMBS - 1;
  while (first > 0 && size.limb[first] == 0)
    first--;
  for (int i = first > 3 ? first - 3 : 0; i <= first; i++)
    out += ldexp((double)size.limb[i], lowest_power + 32 * i);
  return negative ? -out : out;
}

/* square += turn sum^2; square has twice the limbs, with carries put off. */
static void add_square(exact *sum, int turn, int64_t *square) {
  uint64_t limb[EXACT_LIMBS];
  const int negative = exact_sign(sum) < 0;
  uint64_t carry = (uint64_t)negative;
  for (int k = 0; k < EXACT_LIMBS; k++) { /* its magnitude */
    limb[k] = (uint64_t)sum->limb[k] & 0xffffffffu;
    if (!negative) continue;
    limb[k] = (limb[k] ^ 0xffffffffu) + carry;
    carry = limb[k] >> 32;
    limb[k] &= 0xffffffffu;
  }
  for (int i = 0; i < EXACT_LIMBS; i++)
    for (int j = 0; limb[i] && j < EXACT_LIMBS; j++) {
      const uint64_t product = limb[i] * limb[j];
      square[i + j] += turn * (int64_t)(product & 0xffffffffu);
      square[i + j + 1] += turn * (int64_t)(product >> 32);
    }
}

/* Returns 1 if g_n <= 0 and g_n^2 >= mu^2 |g_t|^2, g = column block c of W' y. */
static int farkas_column(const problem *p, const double *y, int c) {
  int64_t square[2 * EXACT_LIMBS + 1] = {0}, carry = 0;
  for (int k = 0; k < p->d; k++) {
    exact sum;
    exact_clear(&sum);
    for (int i = 0; i < p->nc; i++)
      exact_add(&sum, y[i], p->W[p->d * i + (p->d * c + k) * p->m],
                k && !isinf(p->mu[c]) ? p->mu[c] : 1);
    if (k == 0 && exact_sign(&sum) > 0) return 0;
    if (k && isinf(p->mu[c])) { /* the cone of r_n > 0: g_t = 0 */
      if (exact_sign(&sum) != 0) return 0;
      continue;
    }
    add_square(&sum, k ? -1 : 1, square);
  }
  for (int i = 0; i <= 2 * EXACT_LIMBS; i++) {
    const int64_t x = square[i] + carry;
    carry = (x - (int64_t)((uint64_t)x & 0xffffffffu)) / 4294967296;
  }
  return carry >= 0;
}

int farkas_holds(const problem *p, const double *y) {
  exact sum;
  exact_clear(&sum);
  for (int i = 0; i < p->nc; i++) {
    if (!(y[i] >= 0 && y[i] <= 1e300)) return 0;
    exact_add(&sum, y[i], p->q[p->d * i], 1);
  }
  if (exact_sign(&sum) >= 0) return 0;
  for (int c = 0; c < p->nc; c++)
    if (!farkas_column(p, y, c)) return 0;
  return 1;
}

/* out := y in units of `unit`, rounded to whole numbers. */
static void farkas_round(const problem *p, const double *y, double unit, double *out) {
  for (int c = 0; c < p->nc; c++)
    out[c] = nearbyint(y[c] / unit);
}

int farkas_rounded(const problem *p, double *y) {
  double most = 0, least = INFINITY, try[NC_MAX];
  for (int c = 0; c < p->nc; c++) {
    if (!(y[c] >= 0 && y[c] <= 1e300)) return 0;
    if (y[c] > most) most = y[c];
  }
  if (most == 0) return 0;
  for (int c = 0; c < p->nc; c++)
    if (y[c] > 1e-9 * most && y[c] < least) least = y[c];
  if (farkas_holds(p, y)) return 1;
  /* multiples of least / k, and bits after the largest entry */
  for (int k = 1; k <= 48 + 52; k++) {
    farkas_round(p, y, k <= 48 ? least / k : ldexp(most, 48 - k), try);
    if (!farkas_holds(p, try)) continue;
    memcpy(y, try, (size_t)p->nc * sizeof *y);
    return 1;
  }
  return 0;
}
