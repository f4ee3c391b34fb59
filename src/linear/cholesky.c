/*
 * cholesky.c: A = L L^T by supernodes, and its two halves (Ng and Peyton, SIAM J. Sci. Comput. 14,
 * 1993, 1034-1056).
 *
 *   factor   for each supernode s
 *   (CH8)      its panel := the entries of A
 *   (CH9)      for each d before s with rows among the columns of s, L_d in the order of its rows:
 *              panel -= (rows of L_d from the first of these on) (those rows of L_d)^T
 *   (CH10)     L_ss := chol(top of the panel), rows below := rows L_ss^-T
 *   solve    (CH11)  forward, s = 0, 1, ..: x_s := L_ss^-1 x_s, x_rows -= L_rows x_s
 *            (CH12)  backward, s = .., 1, 0: x_s := L_ss^-T (x_s - L_rows^T x_rows)
 *
 * condense stops (CH11) before c and keeps its state; expand starts (CH12) below c, with the x_c
 * that it is given. Together they are one solve.
 *
 * Why not a library: no sparse library with a permissive licence has both halves and a set of
 * unknowns at the end; loads and recoveries take some microseconds, less than the call of a general
 * library; and errors must be returned, not printed. Cost: 2 flops per entry of L and half solve.
 * Fails: a pivot that is not positive, no memory.
 */
#include "linear/cholesky.h"

#include <stdlib.h>
#include <string.h>

#include "linear/pieces.h"

/* A panel as BLAS takes it. */
typedef struct panel {
  int columns, rows, height; /* height: their sum */
  int first;                 /* position of the first column */
  const int *row;            /* positions of the rows */
  double *L;
} panel;

static panel panel_of(const dlsi_cholesky *work, int s) {
  panel p = {.first = work->first[s],
             .columns = work->first[s + 1] - work->first[s],
             .rows = (int)(work->start[s + 1] - work->start[s]),
             .row = work->row + work->start[s],
             .L = work->L + work->panel[s]};
  p.height = p.columns + p.rows;
  return p;
}

/* Returns 1 if the factor is small: its panels then stay on this thread. */
static int cholesky_alone(const dlsi_cholesky *work) {
  return dlsi_is_small(work->panel[work->count]);
}

/* ---- factor ---------------------------------------------------------------------------------- */

/* Puts d, with its next row row[todo[d]], on the list of the supernode that owns this row. */
static void cholesky_enlist(dlsi_cholesky *work, int d) {
  if (work->todo[d] == work->start[d + 1]) return;
  const int s = work->owner[work->row[work->todo[d]]];
  work->next[d] = work->head[s];
  work->head[s] = d;
}

/* (CH9) for one d, in pieces of columns. to: the panel of s. U: scratch, work->update. Returns 1 if
 * the host cancels. */
static int cholesky_update(dlsi_cholesky *work, int d, int s, const panel *to, double *U) {
  const panel of = panel_of(work, d);
  const int *row = work->row + work->todo[d];
  const int height = (int)(work->start[d + 1] - work->todo[d]);
  int width = 0;
  while (width < height && row[width] < to->first + to->columns)
    width++;
  const int alone = cholesky_alone(work);
  const double each = 2.0 * height * of.columns;
  const int some = dlsi_piece_columns(each);
  for (int at = 0; at < width; at += some) {
    const double *top = of.L + (of.height - height + at);
    const int tall = height - at, N = width - at < some ? width - at : some, below = tall - N;
    const int *own = row + at;
    dlsi_syrk(alone, N, of.columns, 1, top, of.height, 0, U, tall);
    if (below > 0)
      dlsi_gemm(alone, 'N', 'T', below, N, of.columns, 1, top + N, of.height, top, of.height, 0,
                U + N, tall);
    const double *u = U;
    for (int j = 0; j < N; j++, u += tall) {
      double *column = to->L + (size_t)(own[j] - to->first) * (size_t)to->height;
      for (int i = j; i < tall; i++)
        column[work->local[own[i]]] -= u[i];
    }
    if (dlsi_watch_stops(work->watch, s, each * N)) return 1;
  }
  work->todo[d] += (size_t)width;
  return 0;
}

/* (CH8) Returns 1 if the host cancels. Clears L in pieces: fresh memory takes a second for each
 * gigabyte. */
static int cholesky_scatter(dlsi_cholesky *work, const double *x) {
  const size_t all = work->panel[work->count], piece = (size_t)1 << 22;
  for (size_t k = 0; k < all; k += piece) {
    memset(work->L + k, 0, (all - k < piece ? all - k : piece) * sizeof *work->L);
    if (dlsi_watch_stops(work->watch, 0, 4.0 * (double)piece)) return 1;
  }
  for (size_t k = 0; k < work->entries; k++)
    work->L[work->where[k]] += x[k];
  return 0;
}

int dlsi_cholesky_factor(dlsi_cholesky *work, const double *x, double *pivot) {
  const size_t entries = work->panel[work->count];
  if (!work->L) work->L = dlsi_alloc(entries, sizeof *work->L);
  double *U = dlsi_alloc(work->update, sizeof *U);
  int failed = work->L && U ? 0 : -1;
  if (!failed && cholesky_scatter(work, x)) failed = dlsi_stopped;
  for (int s = 0; s < work->count; s++)
    work->head[s] = -1;
  for (int s = 0; !failed && s < work->count; s++) {
    const panel p = panel_of(work, s);
    for (int k = 0; k < p.columns; k++)
      work->local[p.first + k] = k;
    for (int k = 0; k < p.rows; k++)
      work->local[p.row[k]] = p.columns + k;
    for (int d = work->head[s], next; !failed && d >= 0; d = next) {
      next = work->next[d];
      if (cholesky_update(work, d, s, &p, U))
        failed = dlsi_stopped;
      else
        cholesky_enlist(work, d);
    }
    if (failed) break;
    const int info = dlsi_panel(cholesky_alone(work), p.columns, p.rows, p.L, p.height, work->watch,
                                s); /* (CH10) */
    if (info < 0) failed = info;
    if (info > 0) {
      failed = p.first + info;
      *pivot = p.L[(size_t)(info - 1) * ((size_t)p.height + 1)];
    }
    for (size_t k = 0; k < (size_t)p.columns; k++)
      work->pivot[(size_t)p.first + k] = 1 / p.L[k * ((size_t)p.height + 1)];
    work->todo[s] = work->start[s];
    cholesky_enlist(work, s);
  }
  free(U);
  return failed;
}

double *dlsi_cholesky_of_kept(const dlsi_cholesky *work) {
  return work->kept > 0 ? work->L + work->panel[work->count - 1] : NULL;
}

/* ---- solve ----------------------------------------------------------------------------------- */

/* Subtracts the n columns of A (m x n, leading dimension ld) times x from t. n is 1 to 4, a
 * constant when inlined. */
static DLSI_INLINE void panel_subtract(size_t n, size_t m, const double *restrict A, size_t ld,
                                       const double *x, double *restrict t) {
  const double x0 = x[0], x1 = n > 1 ? x[1] : 0, x2 = n > 2 ? x[2] : 0, x3 = n > 3 ? x[3] : 0;
  for (size_t i = 0; i < m; i++) {
    double sum = A[i] * x0;
    if (n > 1) sum += A[i + ld] * x1;
    if (n > 2) sum += A[i + 2 * ld] * x2;
    if (n > 3) sum += A[i + 3 * ld] * x3;
    t[i] -= sum;
  }
}

typedef double four __attribute__((vector_size(32), aligned(8), may_alias));

/* Computes y := A^T t, each product as four sums: the bits then do not depend on the width of the
 * machine's vectors. */
static DLSI_INLINE void panel_dot(size_t n, size_t m, const double *A, size_t ld, const double *t,
                                  double *y) {
  four sum[4] = {{0}};
  size_t i = 0;
  for (; i + 4 <= m; i += 4)
    for (size_t k = 0; k < n; k++)
      sum[k] += *(const four *)(A + i + k * ld) * *(const four *)(t + i);
  for (size_t k = 0; k < n; k++)
    y[k] = (sum[k][0] + sum[k][1]) + (sum[k][2] + sum[k][3]);
  for (; i < m; i++)
    for (size_t k = 0; k < n; k++)
      y[k] += A[i + k * ld] * t[i];
}

/* (CH11) for one panel, four columns at a time. t: x_s, then zeros; receives x_s and -L_rows x_s.
 * pivot: reciprocals of the diagonal. */
DLSI_CLONES static void panel_forward(size_t columns, size_t height, const double *L,
                                      const double *pivot, double *t) {
  for (size_t j = 0; j < columns; j += 4) {
    const size_t n = columns - j < 4 ? columns - j : 4, below = j + n;
    const double *A = L + j * height;
    for (size_t k = 0; k < n; k++) {
      t[j + k] *= pivot[j + k];
      for (size_t i = k + 1; i < n; i++)
        t[j + i] -= A[j + i + k * height] * t[j + k];
    }
    if (n == 4)
      panel_subtract(4, height - below, A + below, height, t + j, t + below);
    else if (n == 3)
      panel_subtract(3, height - below, A + below, height, t + j, t + below);
    else if (n == 2)
      panel_subtract(2, height - below, A + below, height, t + j, t + below);
    else
      panel_subtract(1, height - below, A + below, height, t + j, t + below);
  }
}

/* (CH12) for one panel. t: x_s, then x_rows. */
DLSI_CLONES static void panel_backward(size_t columns, size_t height, const double *L,
                                       const double *pivot, double *t) {
  for (size_t j = (columns - 1) / 4 * 4 + 4; j >= 4;) {
    j -= 4;
    const size_t n = columns - j < 4 ? columns - j : 4, below = j + n;
    const double *A = L + j * height;
    double y[4];
    if (n == 4)
      panel_dot(4, height - below, A + below, height, t + below, y);
    else if (n == 3)
      panel_dot(3, height - below, A + below, height, t + below, y);
    else if (n == 2)
      panel_dot(2, height - below, A + below, height, t + below, y);
    else
      panel_dot(1, height - below, A + below, height, t + below, y);
    for (size_t k = n; k-- > 0;) {
      double v = t[j + k] - y[k];
      for (size_t i = k + 1; i < n; i++)
        v -= A[j + i + k * height] * t[j + i];
      t[j + k] = v * pivot[j + k];
    }
  }
}

/* (CH11) for the first `count` supernodes. y: n, by positions. */
static void cholesky_forward(const dlsi_cholesky *work, int count, double *y) {
  double *t = work->x;
  for (int s = 0; s < count; s++) {
    const panel p = panel_of(work, s);
    const size_t columns = (size_t)p.columns;
    memcpy(t, y + p.first, columns * sizeof *t);
    memset(t + columns, 0, (size_t)p.rows * sizeof *t);
    panel_forward(columns, (size_t)p.height, p.L, work->pivot + p.first, t);
    memcpy(y + p.first, t, columns * sizeof *t);
    for (int k = 0; k < p.rows; k++)
      y[p.row[k]] += t[p.columns + k];
  }
}

/* (CH12) for the first `count` supernodes. */
static void cholesky_backward(const dlsi_cholesky *work, int count, double *y) {
  double *t = work->x;
  for (int s = count - 1; s >= 0; s--) {
    const panel p = panel_of(work, s);
    const size_t columns = (size_t)p.columns;
    memcpy(t, y + p.first, columns * sizeof *t);
    for (int k = 0; k < p.rows; k++)
      t[p.columns + k] = y[p.row[k]];
    panel_backward(columns, (size_t)p.height, p.L, work->pivot + p.first, t);
    memcpy(y + p.first, t, columns * sizeof *t);
  }
}

/* (CH11), (CH12) for several right-hand sides. Y: n x nrhs, by positions; x: longest x nrhs. */
static void cholesky_solve_many(const dlsi_cholesky *work, double *Y, int nrhs, double *x) {
  const int n = work->n, alone = cholesky_alone(work);
  const size_t N = (size_t)n;
  for (int s = 0; s < work->count; s++) {
    const panel p = panel_of(work, s);
    double *y = Y + p.first;
    dlsi_trsm(alone, 'L', 'L', 'N', 'N', p.columns, nrhs, p.L, p.height, y, n);
    if (p.rows == 0) continue;
    dlsi_gemm(alone, 'N', 'N', p.rows, nrhs, p.columns, 1, p.L + p.columns, p.height, y, n, 0, x,
              p.rows);
    for (size_t j = 0; j < (size_t)nrhs; j++)
      for (size_t k = 0; k < (size_t)p.rows; k++)
        Y[(size_t)p.row[k] + j * N] -= x[k + j * (size_t)p.rows];
  }
  for (int s = work->count - 1; s >= 0; s--) {
    const panel p = panel_of(work, s);
    double *y = Y + p.first;
    for (size_t j = 0; j < (size_t)nrhs; j++)
      for (size_t k = 0; k < (size_t)p.rows; k++)
        x[k + j * (size_t)p.rows] = Y[(size_t)p.row[k] + j * N];
    if (p.rows > 0)
      dlsi_gemm(alone, 'T', 'N', p.columns, nrhs, p.rows, -1, p.L + p.columns, p.height, x, p.rows,
                1, y, n);
    dlsi_trsm(alone, 'L', 'L', 'T', 'N', p.columns, nrhs, p.L, p.height, y, n);
  }
}

dls_status dlsi_cholesky_solve(dlsi_cholesky *work, double *X, int nrhs, dls_error *error) {
  const size_t n = (size_t)work->n, all = n * (size_t)nrhs;
  double *Y = work->y, *x = work->x;
  if (nrhs > 1) {
    Y = dlsi_alloc(n + (size_t)work->longest, (size_t)nrhs * sizeof *Y);
    if (!Y) return dlsi_no_memory(error);
    x = Y + all;
  }
  for (size_t e = 0; e < all; e++)
    Y[(size_t)work->place[e % n] + e / n * n] = X[e];
  if (nrhs > 1)
    cholesky_solve_many(work, Y, nrhs, x);
  else {
    cholesky_forward(work, work->count, Y);
    cholesky_backward(work, work->count, Y);
  }
  for (size_t e = 0; e < all; e++)
    X[e] = Y[(size_t)work->place[e % n] + e / n * n];
  if (nrhs > 1) free(Y);
  return DLS_OK;
}

void dlsi_cholesky_condense(dlsi_cholesky *work, const double *b, double *z) {
  const int n = work->n, inner = n - work->kept;
  for (int k = 0; k < n; k++)
    work->held[k] = b ? b[work->unknown[k]] : 0;
  if (b) cholesky_forward(work, work->count - (work->kept > 0), work->held);
  memcpy(z, work->held + inner, (size_t)work->kept * sizeof *z);
}

void dlsi_cholesky_expand(dlsi_cholesky *work, const double *xc, double *x) {
  const size_t inner = (size_t)(work->n - work->kept);
  memcpy(work->y, work->held, inner * sizeof *work->y);
  memcpy(work->y + inner, xc, (size_t)work->kept * sizeof *work->y);
  cholesky_backward(work, work->count - (work->kept > 0), work->y);
  for (int k = 0; k < work->n; k++)
    x[work->unknown[k]] = work->y[k];
}

void dlsi_cholesky_destroy(dlsi_cholesky *work) {
  if (!work) return;
  void *const owned[] = {work->unknown, work->where, work->y, work->start, work->panel,
                         work->row,     work->x,     work->L, work};
  for (size_t k = 0; k < sizeof owned / sizeof owned[0]; k++)
    free(owned[k]);
}
