/*
 * influence.c: W = H^T K^-1 H.
 *
 *   for each part k of K                                                            (see factor.c)
 *     for each batch J of the columns of H that load it
 *       X := K_k^-1 H_kJ                                                                    (W1)
 *       W(:,J) += H_k^T X                                                                   (W2)
 *   W := (W + W^T) / 2 if K is symmetric                                                    (W3)
 *
 * and where the factor keeps a Schur complement on the unknowns c that H touches, instead of (W1), (W2)
 *
 *   Z := S^-1 = (K^-1)_cc,   W(:,j) := H_c^T (Z h_j) for each column h_j of H_c             (W4)
 *
 * H is kept by rows, in the order of the parts, so that (W2) reads just the rows that H touches and
 * X never exists as a whole. (W3) leaves W exactly symmetric; flexibility matrices and the host's
 * solver are taken at their word.
 *
 * Cost: (W1) one solve per column of H in each part that it loads; (W2) nnz(H) operations per
 * column. (W4) b^3 (2 b^3 for LU) on b unknowns, then b nnz(H) + m nnz(H). Memory: dlsi_batch columns of
 * the largest part, or b^2.
 */
#include <stdlib.h>
#include <string.h>

#include "reduction_internal.h"

static dls_status no_memory(size_t m, dls_error *error) {
  return dlsi_fail(error, DLS_E_MEMORY, "", -1, 0,
                   "out of memory; W alone takes %.3g GB; dls_primal works without it",
                   1e-9 * (double)m * (double)m * sizeof(double));
}

/* X (s x count) := the columns J of H within the part; slot[j]: place of column j in the list */
static void gather(const dlsi_rows *H, size_t first, size_t s, const int *slot, int start,
                   int count, double *X) {
  memset(X, 0, s * (size_t)count * sizeof *X);
  for (size_t i = 0; i < s; i++)
    for (size_t e = H->p[first + i]; e < H->p[first + i + 1]; e++) {
      const int k = slot[H->j[e]] - start;
      if (k >= 0 && k < count) X[i + s * (size_t)k] += H->h[e];
    }
}

void dlsi_rows_add(const dlsi_rows *H, size_t first, size_t s, const double *x, double *y) {
  for (size_t i = 0; i < s; i++)
    for (size_t e = H->p[first + i]; e < H->p[first + i + 1]; e++)
      y[H->j[e]] += H->h[e] * x[i];
}

/* (W1), (W2); slot (m), list (m): room; X, work: of a batch */
static dls_status by_columns(const dlsi_factor *factor, const dlsi_rows *H, int *slot, int *list,
                             double *X, double *work, double *W, dls_error *error) {
  for (size_t j = 0; j < H->m; j++)
    slot[j] = -1;
  for (int k = 0; k < factor->parts; k++) {
    const size_t first = (size_t)factor->first[k], s = (size_t)factor->first[k + 1] - first;
    int columns = 0;
    for (size_t e = H->p[first]; e < H->p[first + s]; e++)
      if (slot[H->j[e]] < 0) {
        slot[H->j[e]] = columns;
        list[columns++] = H->j[e];
      }
    for (int start = 0; start < columns; start += dlsi_batch) {
      const int count = columns - start < dlsi_batch ? columns - start : dlsi_batch;
      gather(H, first, s, slot, start, count, X);
      const dls_status status = dlsi_factor_solve(factor, k, X, count, work, error);
      if (status) return status; /* (W1) */
      for (int j = 0; j < count; j++)
        dlsi_rows_add(H, first, s, X + (size_t)j * s,
                      W + (size_t)list[start + j] * H->m); /* (W2) */
    }
    for (int j = 0; j < columns; j++)
      slot[list[j]] = -1;
  }
  return DLS_OK;
}

static dls_status from_solves(const dlsi_factor *factor, const dlsi_rows *H, double *W,
                              dls_error *error) {
  const size_t m = H->m, largest = (size_t)factor->largest;
  const size_t batch = m < dlsi_batch ? m : dlsi_batch;
  int *list = dlsi_alloc(2 * m, sizeof *list);
  double *X = dlsi_alloc((1 + factor->scratch) * largest, batch * sizeof *X);
  const dls_status status =
      list && X ? by_columns(factor, H, list, list + m, X, X + largest * batch, W, error)
                : no_memory(m, error);
  free(X);
  free(list);
  return status;
}

/* Columns of H_c: entry e, start[j] <= e < start[j+1], of the unknown keep[row[e]] is value[e]. */
typedef struct columns {
  size_t *start; /* m + 2 */
  int *row;
  double *value;
} columns;

static void turn(const dlsi_rows *H, const int *keep, int kept, const columns *to) {
  size_t *start = to->start;
  memset(start, 0, (H->m + 2) * sizeof *start);
  for (size_t e = 0; e < H->p[H->n]; e++)
    start[H->j[e] + 2]++;
  for (size_t j = 1; j <= H->m; j++)
    start[j + 1] += start[j];
  for (int k = 0; k < kept; k++)
    for (size_t e = H->p[keep[k]]; e < H->p[keep[k] + 1]; e++) {
      const size_t at = start[H->j[e] + 1]++;
      to->row[at] = k;
      to->value[at] = H->h[e];
    }
}

/* (W4); t (kept): room */
static void between(const dlsi_rows *H, const int *keep, size_t b, const double *Z,
                    const columns *Hc, double *t, double *W) {
  for (size_t j = 0; j < H->m; j++) {
    if (Hc->start[j] == Hc->start[j + 1]) continue;
    memset(t, 0, b * sizeof *t);
    for (size_t e = Hc->start[j]; e < Hc->start[j + 1]; e++) {
      const double *z = Z + (size_t)Hc->row[e] * b, h = Hc->value[e];
      for (size_t i = 0; i < b; i++)
        t[i] += h * z[i];
    }
    for (size_t k = 0; k < b; k++)
      dlsi_rows_add(H, (size_t)keep[k], 1, t + k, W + j * H->m);
  }
}

static dls_status from_schur(const dlsi_factor *factor, const dlsi_rows *H, const int *keep,
                             double *W, dls_error *error) {
  const size_t b = (size_t)factor->kept, entries = H->p[H->n];
  const columns Hc = {dlsi_alloc(H->m + 2, sizeof *Hc.start), dlsi_alloc(entries, sizeof *Hc.row),
                      dlsi_alloc(entries, sizeof *Hc.value)};
  double *Z = dlsi_alloc(b, b * sizeof *Z), *t = dlsi_alloc(b, sizeof *t);
  dls_status status;
  if (Hc.start && Hc.row && Hc.value && Z && t) {
    status = dlsi_schur_inverse(factor->schur, Z, error);
    if (!status) {
      turn(H, keep, factor->kept, &Hc);
      between(H, keep, b, Z, &Hc, t, W);
    }
  } else
    status = no_memory(H->m, error);
  free(t);
  free(Z);
  free(Hc.value);
  free(Hc.row);
  free(Hc.start);
  return status;
}

/* (W3), in tiles for the cache's sake */
static void make_symmetric(double *W, size_t m) {
  enum { tile = 32 };
  for (size_t J = 0; J < m; J += tile)
    for (size_t I = J; I < m; I += tile)
      for (size_t j = J; j < m && j < J + tile; j++)
        for (size_t i = I > j ? I : j + 1; i < m && i < I + tile; i++)
          W[i + j * m] = W[j + i * m] = W[i + j * m] / 2 + W[j + i * m] / 2;
}

dls_status dlsi_influence(const dlsi_factor *factor, const dlsi_rows *H, const int *keep, double *W,
                          dls_error *error) {
  const size_t m = H->m;
  memset(W, 0, m * m * sizeof *W);
  const dls_status status =
      factor->kept > 0 ? from_schur(factor, H, keep, W, error) : from_solves(factor, H, W, error);
  if (status) return status;
  if (factor->symmetric) make_symmetric(W, m);
  const long long bad = dlsi_first_not_finite(W, m * m);
  if (bad < 0) return DLS_OK;
  return dlsi_fail(error, DLS_E_NOT_FINITE, "W", bad, W[bad], "overflow");
}
