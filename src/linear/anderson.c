/*
 * anderson.c: Anderson acceleration of a fixed-point iteration x := g(x).
 *
 *   f_k = D (g(x_k) - x_k), D a diagonal of weights         the caller's
 *   (AN1)  df = f_k - f_k-1,  dg = g_k - g_k-1,  du = u_k - u_k-1      the last `window` of each
 *   (AN2)  gamma = argmin | f_k - DF gamma |_2
 *   (AN3)  x_k+1 = g_k - DG gamma,  u_k+1 = u_k - DU gamma
 *
 * u is any affine function of g, here W g + q: to combine it costs no product with W. u is
 * optional.
 *
 * (AN2) by the normal equations: one new row of DF^T DF per step, its columns scaled to length 1,
 * and L D L^T from the newest column to the oldest. A column that is a combination of newer ones up
 * to `dependent` of its length gets gamma = 0. DF^T f_k is the previous DF^T f_k-1 plus the new
 * row, as f_k = f_k-1 + df: one pass over DF computes both.
 *
 *   (AN4)  If |gamma|_1 > 1e4: gamma := 1e4 gamma / |gamma|_1 if the caller asks for it, else
 *          x := g_k without a history. Slow sweeps need (AN4): their f hardly changes from step to
 *          step, and gamma is about 1 / (1 - rate)
 *
 * Source: Anderson 1965; Walker and Ni, SIAM J. Numer. Anal. 49 (2011), type II. With window = 1 it
 * is Aitken's process for vectors in the form of Irons and Tuck 1969. Deviation: Walker and Ni
 * update a QR factorisation. The Gram matrix costs less. Its rounding, half of the digits of gamma,
 * is an error in the choice of x_k+1, not in the fixed point.
 *
 * Cost of a step: 3 window m multiplications, and window^3 / 6. The loops are those of products.c:
 * for small m a call of BLAS takes as long as the work, for large m it would use threads.
 */
#include "linear/anderson.h"

#include <float.h>
#include <math.h>
#include <string.h>

/* in the Gram matrix a sine of less than sqrt(eps) is only rounding */
static const double dependent = 1e-5;

/* (AN3) multiplies the rounding of u by up to 1 + 2 |gamma|_1. No later step removes that. Beyond
 * this bound gamma is shortened to it (a->shortens), or the history is forgotten. */
static const double largest = 1e4;

void dlsi_anderson_carve(dlsi_anderson *a, dlsi_arena *arena, size_t m, int window, size_t of_u) {
  const size_t k = (size_t)window;
  a->window = window;
  a->of_u = of_u;
  a->DF = dlsi_take(arena, k, m * sizeof *a->DF);
  a->DG = dlsi_take(arena, k, m * sizeof *a->DG);
  a->DU = of_u ? dlsi_take(arena, k, of_u * sizeof *a->DU) : NULL;
  a->f = dlsi_take(arena, m, sizeof *a->f);
  a->g = dlsi_take(arena, m, sizeof *a->g);
  a->u = of_u ? dlsi_take(arena, of_u, sizeof *a->u) : NULL;
  a->gram = dlsi_take(arena, k, k * sizeof *a->gram);
  a->L = dlsi_take(arena, k, k * sizeof *a->L);
  a->work = dlsi_take(arena, k, 3 * sizeof *a->work);
}

void dlsi_anderson_clear(dlsi_anderson *a) {
  a->started = a->columns = a->newest = 0;
}

/* (AN1) Replaces the oldest column by the differences to the last step; keeps f, g, u. */
static void anderson_remember(dlsi_anderson *a, size_t m, const double *f, const double *g,
                              const double *u) {
  if (a->started) {
    a->newest = a->columns ? (a->newest + 1) % a->window : 0;
    if (a->columns < a->window) a->columns++;
    double *df = a->DF + (size_t)a->newest * m, *dg = a->DG + (size_t)a->newest * m;
    for (size_t i = 0; i < m; i++) {
      df[i] = f[i] - a->f[i];
      dg[i] = g[i] - a->g[i];
    }
    for (size_t i = 0; i < a->of_u; i++)
      a->DU[(size_t)a->newest * a->of_u + i] = u[i] - a->u[i];
  }
  memcpy(a->f, f, m * sizeof *f);
  memcpy(a->g, g, m * sizeof *g);
  if (a->of_u) memcpy(a->u, u, a->of_u * sizeof *u);
  a->started = 1;
}

/* Returns the index of the i-th newest column. */
static int anderson_column(const dlsi_anderson *a, int i) {
  return a->newest >= i ? a->newest - i : a->newest - i + a->columns;
}

/* The new row of the scaled Gram matrix, with 1 / |df_j| instead of the diagonal; b := DF^T f */
static void anderson_new_row(dlsi_anderson *a, size_t m, double *row, double *b) {
  const int n = a->columns, new = a->newest;
  const size_t k = (size_t)a->window, at = (size_t) new;
  const double *df = a->DF + at * m;
  dlsi_panel_dot(m, n, a->DF, df, row);
  dlsi_join(a->ranks, DLSI_SUM, row, (size_t)n);
  for (int j = 0; j < n; j++)
    b[j] += row[j];
  dlsi_panel_dot(m, 1, df, a->f, b + new);
  dlsi_join(a->ranks, DLSI_SUM, b + new, 1);
  const double scale = 1 / sqrt(row[new]);
  for (size_t j = 0; j < (size_t)n; j++)
    if (j != at) a->gram[j + k * at] = a->gram[at + k * j] = row[j] * scale * a->gram[(k + 1) * j];
  a->gram[(k + 1) * at] = scale;
}

/* (AN2) Returns 0 if gamma is not finite, or too large and must not be shortened. */
static int anderson_minimise(dlsi_anderson *a, size_t m, double *gamma) {
  const int n = a->columns, k = a->window;
  double *L = a->L, *y = a->work + k, *b = a->work + 2 * (size_t)k;
  anderson_new_row(a, m, y, b);

  /* i = 0, 1, .. from the newest column to the oldest; L D L^T = the scaled Gram matrix, row by
   * row, 1 / D on the diagonal, 0 for a column left out; y := L^-1 b on the way */
  for (int i = 0; i < n; i++) {
    const int at = anderson_column(a, i);
    double *row = L + k * i, pivot = 1;
    for (int j = 0; j < i; j++) { /* the row of L D */
      const double *above = L + k * j;
      row[j] = a->gram[anderson_column(a, j) + k * at];
      for (int l = 0; l < j; l++)
        row[j] -= row[l] * above[l];
    }
    y[i] = b[at] * a->gram[at + k * at];
    for (int j = 0; j < i; j++) {
      const double l = row[j] * L[j + k * j];
      pivot -= l * row[j];
      y[i] -= l * y[j];
      row[j] = l;
    }
    row[i] = pivot > dependent * dependent ? 1 / pivot : 0;
  }
  double sum = 0;
  for (int i = n - 1; i >= 0; i--) { /* (L D)^-T */
    const int at = anderson_column(a, i);
    y[i] *= L[i + k * i];
    for (int j = i + 1; j < n; j++)
      y[i] -= L[i + k * j] * y[j];
    gamma[at] = y[i] * a->gram[at + k * at];
    sum += fabs(gamma[at]);
  }
  if (!a->shortens || !(sum > largest && sum <= DBL_MAX)) return sum <= largest;
  for (int i = 0; i < n; i++)
    gamma[i] *= largest / sum;
  return 1;
}

int dlsi_anderson_step(dlsi_anderson *a, int rows, const double *f, double *g, double *u) {
  const size_t m = (size_t)rows;
  anderson_remember(a, m, f, g, u);
  if (!a->columns) return 0;
  double *gamma = a->work;
  if (!anderson_minimise(a, m, gamma)) {
    dlsi_anderson_clear(a);
    return 0;
  }
  dlsi_panel_subtract(m, a->columns, a->DG, gamma, g); /* (AN3) */
  if (a->of_u) dlsi_panel_subtract(a->of_u, a->columns, a->DU, gamma, u);
  return 1;
}
