/*
 * tiny.c: Lemke's method for LCP(M, q) of up to ten unknowns, where lemke.c spends most of its time on
 * preparations.
 *
 *   y = M z + d z0 + q,   y, z >= 0,  z0 >= 0,  y_i z_i = 0          (L1)-(L4) of lemke.c
 *
 * on the whole table x_B = b + A x_N, without scaling. Ratios b_i / -c_i of one column are compared with each
 * other only, so units of rows and columns do not matter, but for what is kept here:
 *
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

enum { most = dlsi_tiny_size, most_rows = (most + 1) / 2 * 2 };
static const double rounding = 1e-13; /* (S2) */
static const double w[] = {1,     1.5,   1.25,  1.75,   1.125,
                           1.625, 1.375, 1.875, 1.0625, 1.5625}; /* (S1) */
static const double tie = 1e-12;                                 /* (S3) */
static const double tie_with_z0 = 1e-10;                         /* (S3) */

/* Variables are numbered as in table.c: y_i is i, z_i is n + i, z0 is 2 n. */
typedef struct table {
  int n, rows;                      /* rows: n, and zeros to fill up to a multiple of 2 */
  double A[most_rows * (most + 2)]; /* rows x (n+2): A, z0's column the last of it, then b */
  int basic[most], column[most + 1];
  int where[2 * most + 1]; /* row or column of a variable */
} table;

/* the basis y; returns the first row to leave, -1 if q >= 0 */
static int load(table *t, const dls_lcp *lcp) {
  const int n = lcp->n, rows = t->rows;
  double least = 2;
  int r = -1;
  memset(t->A, 0, (size_t)(rows * (n + 2)) * sizeof *t->A);
  double *d = t->A + n * rows, *b = d + rows;
  for (int i = 0; i < n; i++) {
    const double *m = lcp->M.a + (size_t)i * (size_t)lcp->M.ld, q = lcp->q[i];
    for (int k = 0; k < n; k++)
      t->A[k + i * rows] = m[k];
    d[i] = w[i] * fabs(q); /* (S1) */
    b[i] = q;
    if (q < 0 && w[i] < least) { /* (L1): q_i / d_i = -1 / w_i */
      least = w[i];
      r = i;
    }
    t->basic[i] = t->where[i] = t->where[n + i] = i;
    t->column[i] = n + i;
  }
  t->column[n] = 2 * n;
  t->where[2 * n] = n;
  return r;
}

/* a := a - f c, (S2) */
static void subtract(int rows, double f, const double *restrict c, double *restrict a) {
  for (int i = 0; i < rows; i += 2)
    for (int k = i; k < i + 2; k++) {
      const double x = a[k] - f * c[k];
      a[k] = fabs(x) > rounding * fabs(a[k]) ? x : 0;
    }
}

/* (L4) of row r and column s: (E1), (E2) of table.c; when z0 leaves, of b alone */
static void exchange(table *t, int r, int s) {
  const int rows = t->rows, in = t->column[s], out = t->basic[r];
  double *c = t->A + s * rows;
  const double pivot = c[r];
  for (int j = out == 2 * t->n ? t->n + 1 : 0; j < t->n + 2; j++) {
    double *a = t->A + j * rows;
    if (j == s || a[r] == 0) continue;
    const double f = a[r] / pivot;
    subtract(rows, f, c, a);
    a[r] = -f;
  }
  for (int i = 0; i < rows; i++)
    c[i] /= pivot;
  c[r] = 1 / pivot;
  t->basic[r] = in;
  t->where[in] = r;
  t->column[s] = out;
  t->where[out] = s;
}

/* (L3), (S3); -1 for a ray */
static int leaving_row(const table *t, int s) {
  const int n = t->n;
  const double *c = t->A + s * t->rows, *b = t->A + (n + 1) * t->rows;
  double least = INFINITY;
  int r = -1;
  for (int i = 0; i < n; i++) {
    if (!(c[i] < 0)) continue;
    const double ratio = b[i] / -c[i];
    if (!(ratio < (1 - tie) * least)) continue;
    least = ratio;
    r = i;
  }
  const int z0 = t->where[2 * n];
  return c[z0] < 0 && b[z0] / -c[z0] <= (1 + tie_with_z0) * least ? z0 : r;
}

int dlsi_lcp_tiny(const dls_lcp *lcp, double *z, int *exchanges) {
  const int n = lcp->n, limit = 4 * n + 4;
  table t;
  t.n = n;
  t.rows = (n + 1) / 2 * 2;
  int r = load(&t, lcp), s = n, k = 0;
  while (r >= 0 && k < limit) {
    exchange(&t, r, s); /* (L4) */
    k++;
    const int out = t.column[s];
    if (out == 2 * n) break;
    s = t.where[out < n ? out + n : out - n]; /* (L2) */
    r = leaving_row(&t, s);
    if (r < 0) k = limit;
  }
  *exchanges = k;
  const double *b = t.A + (n + 1) * t.rows;
  for (int i = 0; i < n; i++)
    z[i] = 0;
  for (int i = 0; i < n; i++)
    if (t.basic[i] >= n && t.basic[i] < 2 * n) z[t.basic[i] - n] = b[i];
  return k < limit;
}
