/* number.c: computes norms that keep NaN, finds a value and numbers that are not finite, reads
 * whole numbers, and draws numbers. */
#include <float.h>
#include <math.h>
#include <string.h>

#include "base/base.h"

/* Takes four at a time; the sum is NaN if some x_i is. */
double dlsi_max_abs(const double *x, size_t n) {
  double m[4] = {0}, s[4] = {0};
  size_t i = 0;
  for (; i + 4 <= n; i += 4)
    for (size_t k = 0; k < 4; k++) {
      const double a = fabs(x[i + k]);
      m[k] = a > m[k] ? a : m[k];
      s[k] += a;
    }
  for (; i < n; i++) {
    const double a = fabs(x[i]);
    m[0] = a > m[0] ? a : m[0];
    s[0] += a;
  }
  const double sum = (s[0] + s[1]) + (s[2] + s[3]);
  for (size_t k = 1; k < 4; k++)
    m[0] = m[k] > m[0] ? m[k] : m[0];
  return sum == sum ? m[0] : sum;
}

double dlsi_norm2(const double *x, size_t n) {
  double plain = 0;
  for (size_t i = 0; i < n; i++)
    plain += x[i] * x[i];
  if (dlsi_is_plain(plain)) return sqrt(plain); /* to the same bits as the scaled sum */
  const double m = dlsi_max_abs(x, n);
  if (!(m > 0) || !isfinite(m)) return m;
  int e;
  (void)frexp(m, &e); /* a power of two scales exactly, unless it over- or underflows by itself */
  const double scale = ldexp(1, e < -1000 ? 1000 : e > 1000 ? -1000 : -e);
  double sum = 0;
  for (size_t i = 0; i < n; i++)
    sum += (scale * x[i]) * (scale * x[i]);
  const double norm = sqrt(sum) / scale;
  return norm <= DBL_MAX ? norm : DBL_MAX; /* a residual over infinity would be 0, and certify */
}

/* Returns the exponent of x plus 1: the sign bit is set if x is NaN or Inf. By bits, not
 * arithmetic: no flag of a compiler assumes the result, and no NaN reaches a trap of the host. */
static inline uint64_t exponent_plus_1(double x) {
  const uint64_t all = UINT64_C(0x7ff) << 52;
  uint64_t bits;
  memcpy(&bits, &x, sizeof bits);
  return (bits & all) + (UINT64_C(1) << 52);
}

long long dlsi_first_not_finite(const double *x, size_t n) {
  uint64_t found = 0;
  for (size_t i = 0; i < n; i++)
    found |= exponent_plus_1(x[i]);
  if (!(found >> 63)) return -1;
  size_t i = 0;
  while (!(exponent_plus_1(x[i]) >> 63))
    i++;
  return (long long)i;
}

int dlsi_read_whole(const char **text, int least, int most, int *value) {
  const char *at = *text;
  long long v = 0;
  for (; dlsi_is_digit(*at) && v <= most; at++)
    v = 10 * v + (*at - '0');
  if (at == *text || v < least || v > most) return 0;
  *value = (int)v;
  *text = at;
  return 1;
}

int dlsi_find(const int *x, int count, int value) {
  int low = 0, high = count;
  while (low < high) {
    const int middle = low + (high - low) / 2;
    if (x[middle] < value)
      low = middle + 1;
    else
      high = middle;
  }
  return low < count && x[low] == value ? low : -1;
}

uint64_t dlsi_mix(uint64_t x) {
  x = (x ^ (x >> 30)) * 0xbf58476d1ce4e5b9u;
  x = (x ^ (x >> 27)) * 0x94d049bb133111ebu;
  return x ^ (x >> 31);
}

double dlsi_draw(uint64_t x) {
  return ldexp((double)(dlsi_mix(x) >> 11), -53);
}

double dlsi_draw_entry(int k, int i) {
  return dlsi_draw(((uint64_t)k << 32 | (uint64_t)i) * DLSI_GOLDEN_BITS);
}
