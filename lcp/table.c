/*
 * table.c: the condensed table of Lemke's method, and exchanges ("pivots") that are put off.
 *
 *   x_B = b + A x_N        the n basic variables by the n + 1 others; [Chabrand 1998] (40) has the
 *                          n x (2n+1) table (I, -M, -d) of which A keeps the columns that are not unit
 *
 * Exchanging x_B,r with x_N,s (pi = a_rs, c = column s, p = row r), [C] (47)-(48):
 *
 *   (E1)  a_ij := a_ij - c_i p_j / pi,   a_is := c_i / pi,   a_rj := -p_j / pi,   a_rs := 1 / pi
 *   (E2)  b_i  := b_i - c_i b_r / pi,    b_r  := -b_r / pi;  the same for g
 *
 * (E1) on the whole table is a rank-one update, bound by memory. Instead A = T - U V^T: row r and
 * column s of T, row r of U and row s of V become 0, and
 *
 *   (E3)  u_i = c_i, u_r = 1;   v_j = p_j / pi, v_s = -1 / pi      is appended to U and V,
 *
 * which is (E1) entry by entry, with no cancellation where (E1) has none. An exchange needs one up-to-date
 * column and row, two products with U and V, O(n dlsi_table_block); every dlsi_table_block of
 * them T takes U V^T by one dgemm.
 */
#include <string.h>

#include "blas.h"
#include "lcp_internal.h"

static const int unit = 1;
static const double one = 1, minus_one = -1;

void dlsi_table_column(const dlsi_table *t, int s, double *c) {
  const int n = t->n, m = n + 1;
  memcpy(c, t->T + (size_t)s * (size_t)t->ld, (size_t)n * sizeof *c);
  if (t->pending)
    dgemv_("N", &n, &t->pending, &minus_one, t->U, &n, t->V + s, &m, &one, c, &unit, 1);
}

double dlsi_table_entry(const dlsi_table *t, int i, int j) {
  const size_t n = (size_t)t->n;
  double a = t->T[(size_t)i + (size_t)j * (size_t)t->ld];
  for (size_t k = 0; k < (size_t)t->pending; k++)
    a -= t->U[(size_t)i + k * n] * t->V[(size_t)j + k * (n + 1)];
  return a;
}

/* row r of A into p (n+1), row r of T := 0 */
static void take_row(dlsi_table *t, int r, double *p) {
  const int n = t->n, m = n + 1;
  double *row = t->T + r;
  for (int j = 0; j < m; j++) {
    double *a = row + (size_t)j * (size_t)t->ld;
    p[j] = *a;
    *a = 0;
  }
  if (t->pending)
    dgemv_("N", &m, &t->pending, &minus_one, t->V, &m, t->U + r, &n, &one, p, &unit, 1);
}

/* (E2) */
static void exchange_values(int n, double *b, const double *c, int r) {
  const double step = -b[r] / c[r];
  for (int i = 0; i < n; i++)
    b[i] += step * c[i];
  b[r] = step;
}

void dlsi_table_exchange(dlsi_table *t, int r, int s, const double *c) {
  const size_t n = (size_t)t->n;
  const double inverse = 1 / c[r];
  double *u = t->U + (size_t)t->pending * n, *v = t->V + (size_t)t->pending * (n + 1);
  take_row(t, r, v);
  memset(t->T + (size_t)s * (size_t)t->ld, 0, n * sizeof *t->T);
  for (size_t k = 0; k < (size_t)t->pending; k++) {
    t->U[(size_t)r + k * n] = 0;
    t->V[(size_t)s + k * (n + 1)] = 0;
  }
  memcpy(u, c, n * sizeof *u);
  u[r] = 1;
  for (size_t j = 0; j <= n; j++)
    v[j] *= inverse;
  v[s] = -inverse; /* (E3) */
  exchange_values(t->n, t->b, c, r);
  exchange_values(t->n, t->g, c, r);

  const int in = t->column[s], out = t->basic[r];
  t->basic[r] = in;
  t->where[in] = r;
  t->column[s] = out;
  t->where[out] = -1 - s;
  if (++t->pending == dlsi_table_block) dlsi_table_flush(t);
}

void dlsi_table_flush(dlsi_table *t) {
  const int n = t->n, m = n + 1;
  if (!t->pending) return;
  dgemm_("N", "T", &n, &m, &t->pending, &minus_one, t->U, &n, t->V, &m, &one, t->T, &t->ld, 1, 1);
  t->pending = 0;
}
