/*
 * tiny.c: Lemke's method for LCP(M, q) of up to ten unknowns, where lemke.c spends most of its time on
 * preparations.
 *
 *   y = M z + d z0 + q,   y, z >= 0,  z0 >= 0,  y_i z_i = 0          (L1)-(L4) of lemke.c
 *
 * without scaling, and without a table: of x_B = b + A x_N only b and the entering columns are computed.
 * Exchange k of row r and the column c leaves
 *
 *   (P1)  p = v_r / c_r;   v_r := -p,   v_i := v_i - c_i p  else          (E2) of table.c
 *   (P2)  c / c_r, but 1 / c_r in row r: the column of the variable that left
 *
 * of b and of any other column v. The column of z_j is M_j followed by (P1) for all exchanges so far; of a
 * variable that has left, (P2) followed by those after. K exchanges take K^2 n flops, less than the
 * 2 K n^2 of a table while K < 2 n.
 *
 * Ratios b_i / -c_i of one column are compared with each other only, so that units of rows and columns do
 * not matter, but for what is kept here:
 *
 *   (S0)  before the path, every z with no more than two entries > 0
 *   (S1)  d_i = w_i |q_i|, 1 <= w_i < 2, no two w_i alike, of few digits. d_i = 0 where q_i = 0: y_i = 0 to begin with
 *   (S2)  a difference less than 1e-13 of the first term is 0
 *   (S3)  ratios are tied within 1e-12; z0 leaves within 1e-10, else the first of them
 *
 * Nothing is promised: (S3) may cycle, a ray means nothing with this d, rounding is not looked after.
 * After 4 n + 4 exchanges, or in a ray, it gives up, and the caller certifies z.
 */
#include <math.h>
#include <string.h>

#include "lcp_internal.h"

enum { most = dlsi_tiny_size, most_exchanges = 4 * most + 4 };
static const double rounding = 1e-13; /* (S2) */
static const double w[] = {1,     1.5,   1.25,  1.75,   1.125,
                           1.625, 1.375, 1.875, 1.0625, 1.5625}; /* (S1) */
static const double tie = 1e-12;                                 /* (S3) */
static const double tie_with_z0 = 1e-10;                         /* (S3) */

/* Variables are numbered as in table.c: y_i is i, z_i is n + i, z0 is 2 n. */
typedef struct path {
  int n, exchanges, z0; /* z0: its row */
  int basic[most];      /* variable of each row */
  int left
      [2 *
       most]; /* exchanges up to the one at which a variable left the basis; z: 0 if it has not */
  double b[most];
  /* of each exchange: */
  double c[most_exchanges][most], inverse[most_exchanges]; /* inverse: 1 / c_r */
  int row[most_exchanges];
} path;

/* 1 if D y = D q + m a + l b >= 0 but for rows i and j, where it is 0 */
static inline int is_feasible(const dls_lcp *lcp, int i, int j, double a, double b, double D) {
  const double *q = lcp->q, *m = lcp->M.a + (size_t)i * (size_t)lcp->M.ld,
               *l = lcp->M.a + (size_t)j * (size_t)lcp->M.ld;
  for (int k = 0; k < lcp->n; k++)
    if (!(q[k] * D + (m[k] * a + l[k] * b) >= 0) && k != i && k != j) return 0;
  return 1;
}

/* (S0) in z, by Cramer's rule: how many of its entries are not 0, or -1 if there is no such z */
static int try_few(const dls_lcp *lcp, double *z) {
  const int n = lcp->n;
  const double *q = lcp->q;
  int loaded = 0;
  for (int i = 0; i < n; i++) {
    z[i] = 0;
    loaded |= q[i] < 0;
  }
  if (!loaded) return 0;
  for (int i = 0; i < n; i++) {
    const double *m = lcp->M.a + (size_t)i * (size_t)lcp->M.ld;
    if (q[i] < 0 && m[i] > 0 && is_feasible(lcp, i, i, -q[i], 0, m[i])) {
      z[i] = -q[i] / m[i];
      return 1;
    }
    for (int j = 0; j < i; j++) {
      const double *l = lcp->M.a + (size_t)j * (size_t)lcp->M.ld;
      double D = m[i] * l[j] - l[i] * m[j], a = l[i] * q[j] - l[j] * q[i],
             b = m[j] * q[i] - m[i] * q[j];
      if (D < 0) {
        D = -D;
        a = -a;
        b = -b;
      }
      if (!(a >= 0 && b >= 0 && D > 0 && is_feasible(lcp, i, j, a, b, D))) continue;
      z[i] = a / D;
      z[j] = b / D;
      return 2;
    }
  }
  return -1;
}

/* x - f c, (S2) */
static inline double difference(double x, double f, double c) {
  const double y = x - f * c;
  return fabs(y) > rounding * fabs(x) ? y : 0;
}

/* (P1) */
static inline void apply(const path *p, int exchange, double *v) {
  const int n = p->n, r = p->row[exchange];
  if (v[r] == 0) return;
  const double *c = p->c[exchange], f = v[r] * p->inverse[exchange];
  for (int i = 0; i < n; i++)
    v[i] = difference(v[i], f, c[i]);
  v[r] = -f;
}

/* (L1), some q_i < 0: the basis y, and z0's column; returns the row to leave */
static int begin(path *p, const dls_lcp *lcp) {
  const int n = lcp->n;
  double least = 2;
  int r = -1;
  p->n = n;
  p->exchanges = 0;
  for (int i = 0; i < n; i++) {
    const double q = lcp->q[i];
    p->b[i] = q;
    p->c[0][i] = w[i] * fabs(q); /* (S1) */
    p->basic[i] = i;
    p->left[n + i] = 0;
    if (q < 0 && w[i] < least) { /* q_i / d_i = -1 / w_i */
      least = w[i];
      r = i;
    }
  }
  p->z0 = r;
  return r;
}

/* (L2): the column of variable v, for the next exchange */
static void enter(path *p, const dls_lcp *lcp, int v) {
  const int n = p->n, k = p->left[v], r = p->row[k > 0 ? k - 1 : 0];
  const double *from = k ? p->c[k - 1] : lcp->M.a + (size_t)(v - n) * (size_t)lcp->M.ld;
  const double f = k ? p->inverse[k - 1] : 1;
  double *c = p->c[p->exchanges];
  for (int i = 0; i < n; i++)
    c[i] = f * from[i];
  if (k) c[r] = f; /* (P2) */
  for (int l = k; l < p->exchanges; l++)
    apply(p, l, c);
}

/* (L4): variable v in place of that of row r, which is returned */
static int exchange(path *p, int r, int v) {
  const int k = p->exchanges++, out = p->basic[r];
  p->row[k] = r;
  p->inverse[k] = 1 / p->c[k][r];
  apply(p, k, p->b);
  p->basic[r] = v;
  if (out < 2 * p->n) p->left[out] = p->exchanges;
  return out;
}

/* (L3), (S3); -1 for a ray */
static int leaving_row(const path *p) {
  const double *c = p->c[p->exchanges], *b = p->b;
  double least = INFINITY;
  int r = -1;
  for (int i = 0; i < p->n; i++) {
    if (!(c[i] < 0)) continue;
    const double ratio = b[i] / -c[i];
    if (!(ratio < (1 - tie) * least)) continue;
    least = ratio;
    r = i;
  }
  const int z0 = p->z0;
  return c[z0] < 0 && b[z0] / -c[z0] <= (1 + tie_with_z0) * least ? z0 : r;
}

int dlsi_lcp_tiny(const dls_lcp *lcp, int limit, double *z, int *exchanges) {
  const int n = lcp->n;
  *exchanges = try_few(lcp, z); /* (S0) */
  if (*exchanges >= 0) return 1;
  path p;
  int r = begin(&p, lcp), in = 2 * n;
  while (r >= 0) {
    const int out = exchange(&p, r, in);
    *exchanges = p.exchanges;
    if (out == 2 * n) break;
    if (p.exchanges == 4 * n + 4 || p.exchanges >= limit) return 0;
    in = out < n ? out + n : out - n;
    enter(&p, lcp, in);
    r = leaving_row(&p);
  }
  if (r < 0) return 0; /* a ray */
  for (int i = 0; i < n; i++)
    if (p.basic[i] >= n && p.b[i] > 0) z[p.basic[i] - n] = p.b[i];
  return 1;
}
