/*
 * border.c: a Newton step (newton.c, NE2) by the factors of an earlier one, some states of which
 * are others now.
 *
 * M = R W C + diag is factored for the base states: C has the directions of its n unknowns, R their
 * rows. Of a candidate c that has changed all d components of dr_c become unknowns: those that it
 * had, and the directions G that complete them. Its old rows are given up, by slacks. With y the d
 * new unknowns of each, slacks and components along G,
 *
 *   (BO1)  M z + B y = b             b: right side of those that have not changed, else 0
 *                                    B: a unit vector for a slack, R W g for a direction g
 *   (BO2)  dr = C z + G y            G y: y times g, 0 for slacks
 *   (BO3)  X = M^-1 B,  Q = the rows of (G - C X) of the changed ones:  dr = C M^-1 b + (G - C X) y
 *   (BO4)  V = (W C)^T on their rows,  T = W (G - C X) on their rows = -V^T X + W G
 *   (BO5)  S y = g: the d equations of each in its new state, in Q and T: its rows of (NE2), and that
 *          dr_c lies in its directions, times w_c; on the right C z and V^T z of z = M^-1 b
 *   (BO6)  z := z - X y
 *
 * X, V, Q and T do not depend on the new states: another change of the same candidates costs the
 * LU of S alone, and d more of them 2 d n^2 + 4 d n k operations. A solve costs M's and 4 n k + 2/3
 * k^3 more. Up to k = n / 6 that is less than the factorisation of a new M, 2/3 n^3.
 *
 * W may be another one than when M was factored: then the solution is inexact, which the caller
 * sees.
 */
#include "border.h"

#include <string.h>

#include "linear/blas.h"
#include "vi_internal.h"

enum { share = 6 };

void dlsi_branch_direction(const dlsi_branch *b, int j, double *e) {
  e[0] = e[1] = e[2] = 0;
  if (b->state == DLS_STICK)
    e[j] = 1;
  else if (j == 0) {
    e[0] = 1;
    e[1] = b->mu * b->t[0];
    e[2] = b->mu * b->t[1];
  } else {
    e[1] = -b->t[1];
    e[2] = b->t[0];
  }
}

double dlsi_branch_row(const dlsi_branch *b, int i, const double *v) {
  if (b->state == DLS_STICK) return i == 0 ? v[0] : i == 1 ? v[1] : v[2];
  return i == 0 ? v[0] : b->t[0] * v[2] - b->t[1] * v[1];
}

/* e (3) := direction j >= count of G: with those of the unknowns a basis. */
static void border_complement(int d, const dlsi_branch *b, int j, double *e) {
  e[0] = e[1] = e[2] = 0;
  if (d == 3 && b->count == 2) {
    e[1] = b->t[0];
    e[2] = b->t[1];
  } else
    e[j] = 1;
}

void dlsi_border_begin(dlsi_border *b, int d, int nc, const dlsi_branch *branch, int n,
                       double *spare, size_t size) {
  const size_t D = (size_t)d, N = (size_t)n, m = D * (size_t)nc,
               bases = (size_t)nc * sizeof *b->base / sizeof *spare;
  size_t most = N / share / D * D;
  while (most && bases + m + (size_t)nc + most * (4 + 2 * N + 3 * most) > size)
    most -= D;
  b->d = d;
  b->nc = nc;
  b->n = n;
  b->k = 0;
  b->most = (int)most;
  b->X = spare;
  b->V = b->X + N * most;
  b->Q = b->V + N * most;
  b->T = b->Q + most * most;
  b->S = b->T + most * most;
  b->v = b->S + most * most;
  b->y = b->v + most;
  b->changed = (int *)(b->y + most);
  b->pivot = (int *)(b->y + 2 * most);
  b->z = b->y + 3 * most;
  b->base = (dlsi_branch *)(b->z + m);
  b->slot = (int *)(b->base + nc);
  if (most) memcpy(b->base, branch, (size_t)nc * sizeof *branch);
  for (int c = 0; most && c < nc; c++)
    b->slot[c] = -1;
}

int dlsi_branch_is_same(const dlsi_branch *a, const dlsi_branch *b) {
  return a->state == b->state && a->count == b->count && a->mu == b->mu && a->t[0] == b->t[0] &&
         a->t[1] == b->t[1] && (a->count == 1 || a->l == b->l);
}

static int border_fits(const dlsi_border *b, int c, const dlsi_branch *branch) {
  return b->slot[c] >= 0 || dlsi_branch_is_same(&b->base[c], branch);
}

/* Fills column j of candidate c in X with B, for (BO3). v: scratch, d nc. */
static void border_column(dlsi_border *b, const dls_contact *problem, int c, int j, double *x,
                          double *v) {
  const size_t m = (size_t)b->d * (size_t)b->nc;
  const dlsi_branch *own = &b->base[c];
  double e[3];
  memset(x, 0, (size_t)b->n * sizeof *x);
  if (j < own->count) {
    x[own->first + j] = 1;
    return;
  }
  border_complement(b->d, own, j, e);
  memset(v, 0, m * sizeof *v);
  dlsi_contact_add_panel(problem, 1, &c, e, v);
  for (int a = 0; a < b->nc; a++)
    for (int i = 0; i < b->base[a].count; i++) {
      double s[3] = {0};
      memcpy(s, v + b->d * a, (size_t)b->d * sizeof *s);
      x[b->base[a].first + i] = dlsi_branch_row(&b->base[a], i, s);
    }
}

/* Fills the columns of V for candidate c. */
static void border_rows(dlsi_border *b, const dls_contact *problem, int c, double *V) {
  const size_t d = (size_t)b->d, ld = (size_t)problem->W.ld, n = (size_t)b->n;
  for (int a = 0; a < b->nc; a++)
    for (int j = 0; j < b->base[a].count; j++) {
      const double *W = problem->W.a + d * (size_t)c + d * (size_t)a * ld;
      double e[3];
      dlsi_branch_direction(&b->base[a], j, e);
      double *at = V + b->base[a].first + j;
      for (size_t i = 0; i < d; i++)
        at[i * n] =
            W[i] * e[0] + (d > 1 ? W[i + ld] * e[1] : 0) + (d == 3 ? W[i + 2 * ld] * e[2] : 0);
    }
}

/* Q and T in rows row .. row + rows - 1 and columns col .. col + cols - 1. */
static void border_products(dlsi_border *b, const dls_contact *problem, int row, int rows, int col,
                            int cols) {
  const size_t d = (size_t)b->d, n = (size_t)b->n, most = (size_t)b->most,
               ld = (size_t)problem->W.ld;
  const double minus = -1, zero = 0;
  double *T = b->T + (size_t)row + most * (size_t)col, e[3];
  if (!rows || !cols) return;
  dgemm_("T", "N", &rows, &cols, &b->n, &minus, b->V + n * (size_t)row, &b->n,
         b->X + n * (size_t)col, &b->n, &zero, T, &b->most, 1, 1);
  for (int k = col; k < col + cols; k++) {
    const int of = b->changed[k / b->d], j = k % b->d;
    const int added = j >= b->base[of].count;
    const double *x = b->X + n * (size_t)k;
    double *t = b->T + most * (size_t)k, *q = b->Q + most * (size_t)k;
    if (added) border_complement(b->d, &b->base[of], j, e);
    for (int s = row / b->d; s < (row + rows) / b->d; s++) {
      const int c = b->changed[s];
      const dlsi_branch *base = &b->base[c];
      const double *W = problem->W.a + d * (size_t)c + d * (size_t)of * ld;
      double *ts = t + b->d * s, *qs = q + b->d * s;
      for (size_t i = 0; i < d; i++) {
        qs[i] = added && c == of ? e[i] : 0;
        for (size_t l = 0; added && l < d; l++)
          ts[i] += W[i + l * ld] * e[l];
      }
      for (int i = 0; i < base->count; i++) {
        double g[3];
        dlsi_branch_direction(base, i, g);
        for (size_t l = 0; l < d; l++)
          qs[l] -= x[base->first + i] * g[l];
      }
    }
  }
}

int dlsi_border_add(dlsi_border *b, const dls_contact *problem, const dlsi_dense *factors,
                    const dlsi_branch *branch) {
  const int before = b->k, d = b->d;
  const size_t n = (size_t)b->n;
  int k = before;
  for (int c = 0; b->most && c < b->nc; c++)
    if (!border_fits(b, c, &branch[c])) k += d;
  if (k == before) return 1;
  if (k > b->most) return 0;
  for (int c = 0; c < b->nc; c++) {
    if (border_fits(b, c, &branch[c])) continue;
    for (int j = 0; j < d; j++)
      border_column(b, problem, c, j, b->X + n * (size_t)(b->k + j), b->z);
    border_rows(b, problem, c, b->V + n * (size_t)b->k);
    b->slot[c] = b->k / d;
    b->changed[b->k / d] = c;
    b->k += d;
  }
  const int added = b->k - before;
  dlsi_dense_solve(factors, b->X + n * (size_t)before, b->n, added);
  border_products(b, problem, 0, before, before, added);
  border_products(b, problem, before, added, 0, b->k);
  return 1;
}

/* (BO5) Returns equation i of a candidate in this state for its components of dr and W dr. */
static double border_equation(int d, const dlsi_branch *now, int i, double w, double diagonal,
                              const double *dr, const double *Wdr) {
  double r[3] = {0}, u[3] = {0};
  memcpy(r, dr, (size_t)d * sizeof *r);
  memcpy(u, Wdr, (size_t)d * sizeof *u);
  if (i < now->count) {
    const double l = now->state == DLS_SLIP && i == 1 ? now->l : 0;
    const double own = now->state == DLS_SLIP && i == 1 ? dlsi_branch_row(now, 1, r) : r[i];
    return dlsi_branch_row(now, i, u) + (diagonal + l) * own;
  }
  if (now->state == DLS_FREE || !(now->mu > 0)) return w * r[i];
  return w * (now->t[0] * r[1] + now->t[1] * r[2] - now->mu * r[0]);
}

int dlsi_border_solve(dlsi_border *b, const dlsi_dense *factors, const dlsi_branch *branch,
                      const double *w, const double *E, double eps, double *x) {
  const int d = b->d, k = b->k, one = 1;
  const size_t n = (size_t)b->n, most = (size_t)b->most;
  const double unit = 1, minus = -1, zero = 0;
  int info = 0;
  if (!k) {
    dlsi_dense_solve(factors, x, b->n, 1);
    return 1;
  }
  memset(b->z, 0, n * sizeof *b->z);
  for (int c = 0; c < b->nc; c++)
    for (int i = 0; b->slot[c] < 0 && i < branch[c].count; i++)
      b->z[b->base[c].first + i] = x[branch[c].first + i];
  dlsi_dense_solve(factors, b->z, b->n, 1);
  dgemv_("T", &b->n, &k, &unit, b->V, &b->n, b->z, &one, &zero, b->v, &one, 1);
  for (int s = 0; s < k / d; s++) { /* (BO5) */
    const int c = b->changed[s];
    const dlsi_branch *now = &branch[c], *base = &b->base[c];
    const double diagonal = eps * w[c] + (E ? E[c] : 0);
    double own[3] = {0}, e[3];
    for (int i = 0; i < base->count; i++) {
      dlsi_branch_direction(base, i, e);
      for (int l = 0; l < 3; l++)
        own[l] += b->z[base->first + i] * e[l];
    }
    for (int i = 0; i < d; i++) {
      const int row = d * s + i;
      b->y[row] = (i < now->count ? x[now->first + i] : 0) -
                  border_equation(d, now, i, w[c], diagonal, own, b->v + d * s);
      for (int j = 0; j < k; j++)
        b->S[(size_t)row + (size_t)j * most] =
            border_equation(d, now, i, w[c], diagonal, b->Q + (size_t)(d * s) + (size_t)j * most,
                            b->T + (size_t)(d * s) + (size_t)j * most);
    }
  }
  dgetrf_(&k, &k, b->S, &b->most, b->pivot, &info);
  if (info) return 0;
  dgetrs_("N", &k, &one, b->S, &b->most, b->pivot, b->y, &b->most, &info, 1);
  dgemv_("N", &b->n, &k, &minus, b->X, &b->n, b->y, &one, &unit, b->z, &one, 1);
  for (int c = 0; c < b->nc; c++) {
    const dlsi_branch *now = &branch[c], *base = &b->base[c];
    const int s = b->slot[c];
    for (int i = 0; s < 0 && i < now->count; i++)
      x[now->first + i] = b->z[base->first + i];
    if (s < 0) continue;
    double dr[3] = {0}, e[3]; /* (BO2) */
    for (int j = 0; j < d; j++) {
      if (j < base->count)
        dlsi_branch_direction(base, j, e);
      else
        border_complement(d, base, j, e);
      const double a = j < base->count ? b->z[base->first + j] : b->y[d * s + j];
      for (int l = 0; l < 3; l++)
        dr[l] += a * e[l];
    }
    for (int i = 0; i < now->count; i++)
      x[now->first + i] = now->state == DLS_SLIP && i == 1 ? dlsi_branch_row(now, 1, dr) : dr[i];
  }
  return 1;
}
