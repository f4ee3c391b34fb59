#include "differences.h"

#include <check.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "cases.h"

double *numbers(size_t n) {
  double *x = calloc(n + 1, sizeof *x);
  ck_assert_ptr_nonnull(x);
  return x;
}

double scalar(const double *x, const double *y, size_t n) {
  double sum = 0;
  for (size_t i = 0; i < n; i++)
    sum += x[i] * y[i];
  return sum;
}

double *garbage(size_t n) {
  double *x = numbers(n);
  for (size_t i = 0; i < n; i++)
    x[i] = 7;
  return x;
}

int differentiate(answer_at *answer, void *data, int sign, int size, int nc, double *D) {
  enum { levels = 4, tries = 9 };
  const size_t states = (size_t)nc * sizeof(dls_contact_state);
  double *T[levels], *at[2] = {numbers((size_t)size), numbers((size_t)size)}, best = INFINITY;
  dls_contact_state *state = malloc(states + 1), *own = malloc(states + 1);
  for (int k = 0; k < levels; k++)
    T[k] = numbers((size_t)size);
  ck_assert(!sign || answer(data, sign * 1e-7, at[1], own));
  ck_assert(answer(data, 0, at[1], sign ? state : own));
  for (int try = 0; try < tries && best > 1e-10; try++) {
    double h = pow(8, -1 - try), change = 0, norm = 0;
    int kept = 1;
    for (int k = 0; kept && k < levels; k++, h /= 2) {
      const double power = sign ? 2 : 4;
      double factor = power;
      kept = answer(data, sign ? sign * h : h, at[0], state);
      kept = kept && !memcmp(state, own, states);
      if (kept && !sign) kept = answer(data, -h, at[1], state) && !memcmp(state, own, states);
      for (int i = 0; i < size; i++)
        T[k][i] = (at[0][i] - at[1][i]) / (sign ? sign * h : 2 * h);
      for (int l = k - 1; l >= 0; l--, factor *= power)
        for (int i = 0; i < size; i++)
          T[l][i] = T[l + 1][i] + (T[l + 1][i] - T[l][i]) / (factor - 1);
    }
    for (int i = 0; i < size; i++) {
      change = hypot(change, T[0][i] - T[1][i]);
      norm = hypot(norm, T[0][i]);
    }
    if (!kept || !(change < best * norm || best == INFINITY)) continue;
    best = norm > 0 ? change / norm : 0;
    memcpy(D, T[0], (size_t)size * sizeof *D);
  }
  for (int k = 0; k < levels; k++)
    free(T[k]);
  free(at[0]);
  free(at[1]);
  free(state);
  free(own);
  return best < INFINITY;
}

double apart(const double *x, const double *y, size_t n, double size) {
  double off = 0;
  for (size_t i = 0; i < n; i++)
    off = hypot(off, x[i] - y[i]);
  size = fmax(size, norm_of(y, (int)n));
  return size > 0 ? off / size : off;
}
