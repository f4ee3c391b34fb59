/*
 * table.c: the condensed table of Lemke's method, and exchanges ("pivots") that are put off.
 *
 *   x_B = b + A x_N        the n basic variables by the n + 1 others; [Chabrand 1998] (40) has the
 *                          n x (2n+1) table (I, -M, -d); A is its columns that are not unit
 *
 * Exchanging x_B,r with x_N,s (pi = a_rs, c = column s, p = row r), [C] (47)-(48):
 *
 *   (E1)  a_ij := a_ij - c_i p_j / pi,   a_is := c_i / pi,   a_rj := -p_j / pi,   a_rs := 1 / pi
 *   (E2)  b_i  := b_i - c_i b_r / pi,    b_r  := -b_r / pi;  the same for g
 *
 * (E1) on the whole table is a rank-one update, bound by memory. Instead exchanges k = 0, 1, ..
 * are put off:
 *
 *   (E3)  A = T - U V,   u_k = c but 1 in row r_k;   v_k = p / pi_k but -1 / pi_k in column s_k
 *
 * where row r_k and column s_k of T, row r_k of the u before and column s_k of the v before
 * become 0. That is (E1) entry by entry, and has no cancellation where (E1) has none. V is not
 * formed while exchanges are put off: with L_kl = (u_l)_rk, l < k, taken before it became 0, and
 * L_kk = pi_k, (E3) says
 *
 *   (E4)  L V = rows r_0, r_1, .. of T, each as long as it was not 0 yet,  but -e_k in column s_k
 *
 * so that one column of A costs a triangular solve and a product with U. No row is read, which in
 * column-major order would be one cache line and one page per entry. When U is full, V for all
 * columns comes from (E4), the diagonal blocks of L of size 16 being inverted, and T := T - U V,
 * all by dgemm. (n = 1000, 64 exchanges: 2.7 ms for the update; 0.88 ms for (E4) by dtrsm, 0.16
 * ms like this.)
 */
#include <string.h>

#include "lcp_internal.h"
#include "linear/blas.h"

enum { part_size = 16 };
enum { small = 32 }; /* n below which a call of dgemv costs more than the product */
static const int unit = 1, block = dlsi_table_block, part = part_size;
static const double zero = 0, one = 1, minus_one = -1;

/* v_k := entry r_k of a combination of columns of T, 0 in its place: the right-hand side of (E4)
 * but for the columns of exchanges. */
static void take_rows(const dlsi_table *t, double *a, double *v) {
  for (int k = 0; k < t->pending; k++) {
    v[k] = a[t->row[k]];
    a[t->row[k]] = 0;
  }
}

/* a - U V of a combination a, v as from take_rows; by hand what is too small for BLAS */
static void subtract_pending(const dlsi_table *t, double *a, double *v) {
  const int n = t->n;
  for (int k = 0; k < t->pending; k++) {
    const double *L = t->L + k * block, x = v[k] / L[k];
    v[k] = x;
    for (int i = k + 1; i < t->pending; i++)
      v[i] -= L[i] * x;
  }
  if (n >= small) {
    dgemv_("N", &n, &t->pending, &minus_one, t->U, &n, v, &unit, &one, a, &unit, 1);
    return;
  }
  for (int k = 0; k < t->pending; k++) {
    const double *u = t->U + k * n, x = v[k];
    for (int i = 0; i < n; i++)
      a[i] -= u[i] * x;
  }
}

void dlsi_table_column(const dlsi_table *t, int s, double *c) {
  double v[dlsi_table_block];
  memcpy(c, t->T + (size_t)s * (size_t)t->ld, (size_t)t->n * sizeof *c);
  if (!t->pending) return;
  take_rows(t, c, v);
  if (t->born[s] >= 0) v[t->born[s]] = -1;
  subtract_pending(t, c, v);
}

void dlsi_table_move_y(const dlsi_table *t, const double *dy, double *dx) {
  const size_t n = (size_t)t->n;
  double v[dlsi_table_block];
  memset(dx, 0, n * sizeof *dx);
  for (size_t i = 0; i < n; i++) {
    if (t->where[i] >= 0 || dy[i] == 0) continue;
    const double *a = t->T + (size_t)(-1 - t->where[i]) * (size_t)t->ld;
    for (size_t k = 0; k < n; k++)
      dx[k] += dy[i] * a[k];
  }
  if (!t->pending) return;
  take_rows(t, dx, v);
  for (size_t i = 0; i < n; i++) {
    const int s = -1 - t->where[i];
    if (s >= 0 && t->born[s] >= 0) v[t->born[s]] -= dy[i];
  }
  subtract_pending(t, dx, v);
}

/* (E2), both at once */
static void exchange_values(int n, double *b, double *g, const double *c, int r) {
  const double step_b = -b[r] / c[r], step_g = -g[r] / c[r];
  for (int i = 0; i < n; i++) {
    b[i] += step_b * c[i];
    g[i] += step_g * c[i];
  }
  b[r] = step_b;
  g[r] = step_g;
}

/* T := A, nothing pending */
static void flush(dlsi_table *t) {
  const int n = t->n, m = n + 1, pending = t->pending;
  if (!pending) return;
  for (int j = 0; j < m; j++) {
    double *v = t->W + (size_t)j * dlsi_table_block;
    take_rows(t, t->T + (size_t)j * (size_t)t->ld, v);
    if (t->born[j] >= 0) v[t->born[j]] = -1;
    t->born[j] = -1;
  }
  for (int p = 0; p < pending; p += part) { /* (E4) */
    const int k = pending - p < part ? pending - p : part, rest = pending - p - k;
    const double *L = t->L + p * (block + 1);
    double inverse[part_size * part_size] = {0};
    for (int i = 0; i < k; i++)
      inverse[i * (part + 1)] = 1;
    dtrsm_("L", "L", "N", "N", &k, &k, &one, L, &block, inverse, &part, 1, 1, 1, 1);
    dgemm_("N", "N", &k, &m, &k, &one, inverse, &part, t->W + p, &block, &zero, t->V + p, &block, 1,
           1);
    if (rest > 0)
      dgemm_("N", "N", &rest, &m, &k, &minus_one, L + k, &block, t->V + p, &block, &one,
             t->W + p + k, &block, 1, 1);
  }
  dgemm_("N", "N", &n, &m, &pending, &minus_one, t->U, &n, t->V, &block, &one, t->T, &t->ld, 1, 1);
  t->pending = 0;
}

void dlsi_table_exchange(dlsi_table *t, int r, int s, const double *c) {
  const size_t n = (size_t)t->n, k = (size_t)t->pending;
  double *u = t->U + k * n;
  exchange_values(t->n, t->b, t->g, c, r);
  memset(t->T + (size_t)s * (size_t)t->ld, 0, n * sizeof *t->T);
  for (size_t l = 0; l < k; l++) {
    t->L[k + l * dlsi_table_block] = t->U[(size_t)r + l * n];
    t->U[(size_t)r + l * n] = 0;
  }
  t->L[k + k * dlsi_table_block] = c[r];
  memcpy(u, c, n * sizeof *u);
  u[r] = 1;
  t->row[k] = r;
  t->born[s] = (int)k;

  const int in = t->column[s], out = t->basic[r];
  t->basic[r] = in;
  t->where[in] = r;
  t->column[s] = out;
  t->where[out] = -1 - s;
  if (++t->pending == dlsi_table_block) flush(t);
}
