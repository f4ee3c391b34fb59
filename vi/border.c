/*
 * border.c: a Newton step (newton.c, NE2) by the factors of an earlier one, some states of which
 * are others now.
 *
 * M = R W C + diag is factored for the base states: C has the directions of its n unknowns, R their
 * rows. Of a candidate c that has changed all components of dr_c become unknowns (without friction
 * the normal one alone): those that it had, and the directions G that complete them. Its old rows
 * are given up, by slacks. With y the new unknowns, slacks and components along G,
 *
 *   (BO1)  M z + B y = b             b: right side of those that have not changed, else 0
 *                                    B: a unit vector for a slack, R W g for a direction g
 *   (BO2)  dr = C z + G y            G y: y times g, 0 for slacks
 *   (BO3)  X = M^-1 B,  Q = the rows of (G - C X) of the changed ones:  dr = C M^-1 b + (G - C X) y
 *   (BO4)  V = (W C)^T on their rows,  T = W (G - C X) on their rows = -V^T X + W G
 *   (BO5)  S y = g: the equations of each in its new state, in Q and T: its rows of (NE2), and
 *          that dr_c lies in its directions, times w_c; on the right C z and V^T z of z = M^-1 b
 *   (BO6)  z := z - X y
 *
 * X, V, Q and T do not depend on the new states: another change of the same candidates costs the
 * LU of S alone, and each unknown more 2 n^2 + 4 n k operations. A solve costs M's and 4 n k + 2/3
 * k^3 more. Up to k = n / 6 that is less than the factorisation of a new M, 2/3 n^3.
 *
 * W may be another one than when M was factored: then the solution is inexact, which the caller
 * sees.
 */
#include "border.h"

#include <string.h>

#include "linear/pieces.h"
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
  const size_t N = (size_t)n, m = (size_t)d * (size_t)nc, bases = (size_t)nc * sizeof *b->base;
  const size_t fixed = m + (size_t)nc + bases / sizeof *spare;
  size_t rows = 0, most = N / share;
  for (int c = 0; c < nc; c++)
    rows += branch[c].mu > 0 ? (size_t)d : 1;
  /* what is left of a matrix of these rows: as much as in a problem without their tangents */
  const size_t left = rows * rows - N * N + (m - rows), room = size < left ? size : left;
  while (most && fixed + most * (4 + 2 * N + 3 * most) > room)
    most--;
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
  b->of = (int *)(b->y + most);
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

/* Fills the columns of V for the first components of candidate c. */
static void border_rows(dlsi_border *b, const dls_contact *problem, int c, int width, double *V) {
  const size_t d = (size_t)b->d, ld = (size_t)problem->W.ld, n = (size_t)b->n;
  for (int a = 0; a < b->nc; a++)
    for (int j = 0; j < b->base[a].count; j++) {
      const double *W = problem->W.a + d * (size_t)c + d * (size_t)a * ld;
      double e[3];
      dlsi_branch_direction(&b->base[a], j, e);
      double *at = V + b->base[a].first + j;
      for (size_t i = 0; i < (size_t)width; i++)
        at[i * n] =
            W[i] * e[0] + (d > 1 ? W[i + ld] * e[1] : 0) + (d == 3 ? W[i + 2 * ld] * e[2] : 0);
    }
}

static int border_alone(const dlsi_border *b) {
  return dlsi_is_small((size_t)b->n * (size_t)b->n);
}

/* Entries of Q and T in rows row .. row + rows - 1 and columns col .. col + cols - 1. */
static void border_products(dlsi_border *b, const dls_contact *problem, int row, int rows, int col,
                            int cols) {
  const size_t d = (size_t)b->d, n = (size_t)b->n, most = (size_t)b->most;
  double e[3], g[3];
  if (!rows || !cols) return;
  dlsi_gemm(border_alone(b), 'T', 'N', rows, cols, b->n, -1, b->V + n * (size_t)row, b->n,
            b->X + n * (size_t)col, b->n, 0, b->T + (size_t)row + most * (size_t)col, b->most);
  for (int k = col; k < col + cols; k++) {
    const int of = b->of[k], j = k - b->slot[of], added = j >= b->base[of].count;
    const double *x = b->X + n * (size_t)k;
    double *t = b->T + most * (size_t)k, *q = b->Q + most * (size_t)k;
    if (added) border_complement(b->d, &b->base[of], j, e);
    for (int i = row; i < row + rows; i++) {
      const int c = b->of[i], l = i - b->slot[c];
      const double *W = problem->W.a + d * (size_t)c + (size_t)l;
      for (size_t a = 0; added && a < d; a++)
        t[i] += W[(d * (size_t)of + a) * (size_t)problem->W.ld] * e[a];
      q[i] = added && c == of ? e[l] : 0;
      for (int a = 0; a < b->base[c].count; a++) {
        dlsi_branch_direction(&b->base[c], a, g);
        q[i] -= x[b->base[c].first + a] * g[l];
      }
    }
  }
}

/* Returns how many unknowns a candidate has that changes. */
static int border_width(const dlsi_border *b, int c) {
  return b->base[c].mu > 0 ? b->d : 1;
}

int dlsi_border_add(dlsi_border *b, const dls_contact *problem, const dlsi_dense *factors,
                    const dlsi_branch *branch) {
  const int before = b->k;
  const size_t n = (size_t)b->n;
  int k = before;
  for (int c = 0; b->most && c < b->nc; c++) {
    if (branch[c].mu > 0 && !(b->base[c].mu > 0)) return 0;
    if (!border_fits(b, c, &branch[c])) k += border_width(b, c);
  }
  if (k == before) return 1;
  if (k > b->most) return 0;
  for (int c = 0; c < b->nc; c++) {
    if (border_fits(b, c, &branch[c])) continue;
    const int width = border_width(b, c);
    for (int j = 0; j < width; j++) {
      border_column(b, problem, c, j, b->X + n * (size_t)(b->k + j), b->z);
      b->of[b->k + j] = c;
    }
    border_rows(b, problem, c, width, b->V + n * (size_t)b->k);
    b->slot[c] = b->k;
    b->k += width;
  }
  const int added = b->k - before;
  dlsi_dense_solve(factors, b->X + n * (size_t)before, b->n, added);
  border_products(b, problem, 0, before, before, added);
  border_products(b, problem, before, added, 0, b->k);
  return 1;
}

/* (BO5) Returns equation i of a candidate in this state for `width` components of dr and W dr. */
static double border_equation(int width, const dlsi_branch *now, int i, double w, double diagonal,
                              const double *dr, const double *Wdr) {
  double r[3] = {0}, u[3] = {0};
  memcpy(r, dr, (size_t)width * sizeof *r);
  memcpy(u, Wdr, (size_t)width * sizeof *u);
  if (i < now->count) {
    const int across = now->state == DLS_SLIP && i == 1;
    const double own = across ? dlsi_branch_row(now, 1, r) : r[i];
    return dlsi_branch_row(now, i, u) + (diagonal + (across ? now->l : 0)) * own;
  }
  if (now->state == DLS_FREE || !(now->mu > 0)) return w * r[i];
  return w * (now->t[0] * r[1] + now->t[1] * r[2] - now->mu * r[0]);
}

/* dr (3) := (BO2) of candidate c from z and, if it has changed, its part of y. */
static void border_part(const dlsi_border *b, int c, const double *z, const double *y, double *dr) {
  const dlsi_branch *base = &b->base[c];
  const int count = y ? border_width(b, c) : base->count;
  double e[3];
  dr[0] = dr[1] = dr[2] = 0;
  for (int j = 0; j < count; j++) {
    if (j < base->count)
      dlsi_branch_direction(base, j, e);
    else
      border_complement(b->d, base, j, e);
    for (int l = 0; l < 3; l++)
      dr[l] += (j < base->count ? z[base->first + j] : y[j]) * e[l];
  }
}

int dlsi_border_solve(dlsi_border *b, const dlsi_dense *factors, const dlsi_branch *branch,
                      const double *w, const double *E, double eps, double *x) {
  const int k = b->k, alone = border_alone(b);
  const size_t n = (size_t)b->n, most = (size_t)b->most;
  double dr[3];
  if (!k) {
    dlsi_dense_solve(factors, x, b->n, 1);
    return 1;
  }
  memset(b->z, 0, n * sizeof *b->z);
  for (int c = 0; c < b->nc; c++)
    for (int i = 0; b->slot[c] < 0 && i < branch[c].count; i++)
      b->z[b->base[c].first + i] = x[branch[c].first + i];
  dlsi_dense_solve(factors, b->z, b->n, 1);
  dlsi_gemm(alone, 'T', 'N', k, 1, b->n, 1, b->V, b->n, b->z, b->n, 0, b->v, k);
  for (int row = 0; row < k; row++) { /* (BO5) */
    const int c = b->of[row], at = b->slot[c], i = row - at, width = border_width(b, c);
    const dlsi_branch *now = &branch[c];
    const double diagonal = eps * w[c] + (E ? E[c] : 0);
    border_part(b, c, b->z, NULL, dr);
    b->y[row] = (i < now->count ? x[now->first + i] : 0) -
                border_equation(width, now, i, w[c], diagonal, dr, b->v + at);
    for (size_t j = 0; j < (size_t)k; j++) {
      const double *Q = b->Q + at + j * most, *T = b->T + at + j * most;
      b->S[(size_t)row + j * most] = border_equation(width, now, i, w[c], diagonal, Q, T);
    }
  }
  if (dlsi_getrf(alone, k, b->S, b->most, b->pivot)) return 0;
  dlsi_getrs(alone, k, 1, b->S, b->most, b->pivot, b->y, b->most);
  dlsi_gemv(alone, b->n, k, -1, b->X, b->y, 1, b->z);
  for (int c = 0; c < b->nc; c++) {
    const dlsi_branch *now = &branch[c];
    const int s = b->slot[c];
    if (s >= 0) border_part(b, c, b->z, b->y + s, dr);
    for (int i = 0; i < now->count; i++)
      x[now->first + i] = s < 0                              ? b->z[b->base[c].first + i]
                          : now->state == DLS_SLIP && i == 1 ? dlsi_branch_row(now, 1, dr)
                                                             : dr[i];
  }
  return 1;
}
