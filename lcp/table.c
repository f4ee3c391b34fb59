/*
 * table.c: keeps the condensed table of Lemke's method and postpones its pivots.
 *
 *   x_B = b + A x_N        the n basic variables by the n + 1 others; [Chabrand 1998] (40) has the
 *                          n x (2n+1) table (I, -M, -d); A: its nonunit columns
 *
 * A pivot exchanges x_B,r and x_N,s (pi = a_rs, c = column s, p = row r), [C] (47)-(48):
 *
 *   (TA1)  a_ij := a_ij - c_i p_j / pi,   a_is := c_i / pi,   a_rj := -p_j / pi,   a_rs := 1 / pi
 *   (TA2)  b_i  := b_i - c_i b_r / pi,    b_r  := -b_r / pi;  the same for g
 *
 * (TA1) on the whole table is a rank-one update, limited by memory bandwidth. Instead, pivots
 * k = 0, 1, .. are postponed:
 *
 *   (TA3)  A = T - U V,   u_k = c with 1 in row r_k;  v_k = p / pi_k with -1 / pi_k in column s_k
 *
 * where row r_k and column s_k of T, row r_k of earlier u and column s_k of earlier v become 0.
 * (TA3) is (TA1) entry by entry, with no further cancellation. V is not formed while pivots are
 * postponed: with L_kl = (u_l)_rk, l < k, taken before it became 0, and L_kk = pi_k, (TA3) gives
 *
 *   (TA4)  L V = rows r_0, r_1, .. of T, each before it became 0, with -e_k in column s_k
 *
 * A column of A then costs a triangular solve and a product with U. No row is read: in column-major
 * order that would take one cache line and one page per entry. When U is full, (TA4) gives V for
 * all columns, with inverted 16 x 16 diagonal blocks of L, and T := T - U V, all by dgemm. For
 * n = 1000 and 64 pivots (TA4) takes 6 % of the time of T - U V; dtrsm on all of L would take a
 * third.
 */
#include <string.h>

#include "lcp_internal.h"
#include "linear/pieces.h"

enum { part = 16, block = dlsi_table_block };

static int table_alone(const dlsi_table *table) {
  return dlsi_is_small((size_t)table->n * (size_t)table->n);
}

void dlsi_table_carve(dlsi_table *table, dlsi_arena *arena, size_t n, size_t ld) {
  const size_t D = sizeof(double), m = n + 1;
  table->ld = (int)ld;
  table->T = dlsi_take(arena, m, ld * D);
  table->U = dlsi_take(arena, n, dlsi_table_block * D);
  table->V = dlsi_take(arena, m, dlsi_table_block * D);
  table->W = dlsi_take(arena, m, dlsi_table_block * D);
  table->L = dlsi_take(arena, dlsi_table_block, dlsi_table_block * D);
  table->b = dlsi_take(arena, ld, D);
  table->g = dlsi_take(arena, ld, D);
  table->row = dlsi_take(arena, dlsi_table_block, sizeof(int));
  table->basic = dlsi_take(arena, n, sizeof(int));
  table->column = dlsi_take(arena, m, sizeof(int));
  table->born = dlsi_take(arena, m, sizeof(int));
  table->where = dlsi_take(arena, 2 * n + 1, sizeof(int));
}

/* v_k := entry r_k of a, a combination of columns of T, and puts 0 in its place. v becomes the
 * right-hand side of (TA4), without the entries -e_k. */
static void table_take_rows(const dlsi_table *table, double *a, double *v) {
  for (int k = 0; k < table->pending; k++) {
    v[k] = a[table->row[k]];
    a[table->row[k]] = 0;
  }
}

/* a -= U V for a combination a of columns, with v from table_take_rows. */
static void table_subtract_pending(const dlsi_table *table, double *a, double *v) {
  const int n = table->n;
  for (int k = 0; k < table->pending; k++) {
    const double *L = table->L + k * block, x = v[k] / L[k];
    v[k] = x;
    for (int i = k + 1; i < table->pending; i++)
      v[i] -= L[i] * x;
  }
  dlsi_gemv(table_alone(table), n, table->pending, -1, table->U, v, 1, a);
}

void dlsi_table_column(const dlsi_table *table, int s, double *c) {
  double v[dlsi_table_block];
  memcpy(c, table->T + (size_t)s * (size_t)table->ld, (size_t)table->n * sizeof *c);
  if (!table->pending) return;
  table_take_rows(table, c, v);
  if (table->born[s] >= 0) v[table->born[s]] = -1;
  table_subtract_pending(table, c, v);
}

void dlsi_table_move_y(const dlsi_table *table, const double *dy, double *dx) {
  const size_t n = (size_t)table->n;
  double v[dlsi_table_block];
  memset(dx, 0, n * sizeof *dx);
  for (size_t i = 0; i < n; i++) {
    if (table->where[i] >= 0 || dy[i] == 0) continue;
    const double *a = table->T + (size_t)(-1 - table->where[i]) * (size_t)table->ld;
    for (size_t k = 0; k < n; k++)
      dx[k] += dy[i] * a[k];
  }
  if (!table->pending) return;
  table_take_rows(table, dx, v);
  for (size_t i = 0; i < n; i++) {
    const int s = -1 - table->where[i];
    if (s >= 0 && table->born[s] >= 0) v[table->born[s]] -= dy[i];
  }
  table_subtract_pending(table, dx, v);
}

/* (TA2) */
static void table_exchange_values(int n, double *b, double *g, const double *c, int r) {
  const double step_b = -b[r] / c[r], step_g = -g[r] / c[r];
  for (int i = 0; i < n; i++) {
    b[i] += step_b * c[i];
    g[i] += step_g * c[i];
  }
  b[r] = step_b;
  g[r] = step_g;
}

/* T := A; nothing is pending afterwards. */
static void table_flush(dlsi_table *table) {
  const int n = table->n, m = n + 1, pending = table->pending, alone = table_alone(table);
  if (!pending) return;
  for (int j = 0; j < m; j++) {
    double *v = table->W + (size_t)j * dlsi_table_block;
    table_take_rows(table, table->T + (size_t)j * (size_t)table->ld, v);
    if (table->born[j] >= 0) v[table->born[j]] = -1;
    table->born[j] = -1;
  }
  for (int p = 0; p < pending; p += part) { /* (TA4) */
    const int k = pending - p < part ? pending - p : part, rest = pending - p - k;
    const double *L = table->L + p * (block + 1);
    double inverse[part * part] = {0};
    for (int i = 0; i < k; i++)
      inverse[i * (part + 1)] = 1;
    dlsi_trsm(alone, 'L', 'L', 'N', 'N', k, k, L, block, inverse, part);
    dlsi_gemm(alone, 'N', 'N', k, m, k, 1, inverse, part, table->W + p, block, 0, table->V + p,
              block);
    if (rest > 0)
      dlsi_gemm(alone, 'N', 'N', rest, m, k, -1, L + k, block, table->V + p, block, 1,
                table->W + p + k, block);
  }
  dlsi_gemm(alone, 'N', 'N', n, m, pending, -1, table->U, n, table->V, block, 1, table->T,
            table->ld);
  table->pending = 0;
}

void dlsi_table_exchange(dlsi_table *table, int r, int s, const double *c) {
  const size_t n = (size_t)table->n, k = (size_t)table->pending;
  double *u = table->U + k * n;
  table_exchange_values(table->n, table->b, table->g, c, r);
  memset(table->T + (size_t)s * (size_t)table->ld, 0, n * sizeof *table->T);
  for (size_t l = 0; l < k; l++) {
    table->L[k + l * dlsi_table_block] = table->U[(size_t)r + l * n];
    table->U[(size_t)r + l * n] = 0;
  }
  table->L[k + k * dlsi_table_block] = c[r];
  memcpy(u, c, n * sizeof *u);
  u[r] = 1;
  table->row[k] = r;
  table->born[s] = (int)k;

  const int in = table->column[s], out = table->basic[r];
  table->basic[r] = in;
  table->where[in] = r;
  table->column[s] = out;
  table->where[out] = -1 - s;
  if (++table->pending == dlsi_table_block) table_flush(table);
}
