/*
 * influence.c: W = H^T K^-1 H.
 *
 *   for each part k of K                                                            (see factor.c)
 *     for each batch J of the columns of H that load it
 *       X := K_k^-1 H_kJ                                                                   (IN1)
 *       W(:,J) += H_k^T X                                                                  (IN2)
 *   W := (W + W^T) / 2 if K is symmetric                                                   (IN3)
 *
 * If the factor keeps a Schur complement S on the unknowns c that H touches, (IN4) replaces (IN1)
 * and (IN2):
 *
 *   Z := S^-1 = (K^-1)_cc,   W(:,j) := H_c^T (Z h_j) for each column h_j of H_c            (IN4)
 *
 * (IN2) reads just the rows that H touches, and X never exists as a whole. (IN3) makes W exactly
 * symmetric. It is not applied to flexibility matrices and the host's solver.
 *
 * Cost: (IN1) one solve per column of H in each part that it loads; (IN2) nnz(H) operations per
 * column. (IN4) b^3 (2 b^3 for LU) on b unknowns, then b nnz(H) + m nnz(H). Memory: dlsi_batch
 * columns of the largest part, or b^2.
 */
#include <float.h>
#include <stdlib.h>
#include <string.h>

#include "linear/dense.h"
#include "reduction_internal.h"

/* Fills X with `count` columns of H within a part, from number `start` of the part's list on.
 * slot: place of each column in this list, m; unknown: unknowns of the part, s; X: s x count. */
static void influence_gather(const dlsi_columns *Ht, const int *unknown, size_t s, const int *slot,
                             int start, int count, double *X) {
  memset(X, 0, s * (size_t)count * sizeof *X);
  for (size_t i = 0; i < s; i++)
    for (int e = Ht->p[unknown[i]]; e < Ht->p[unknown[i] + 1]; e++) {
      const int k = slot[Ht->i[e]] - start;
      if (k >= 0 && k < count) X[i + s * (size_t)k] += Ht->x[e];
    }
}

/* Lists the columns of H that load a part; returns their number. slot: -1 on entry, m; list: m. */
static int influence_list(const dlsi_columns *Ht, const int *unknown, size_t s, int *slot,
                          int *list) {
  int columns = 0;
  for (size_t i = 0; i < s; i++)
    for (int e = Ht->p[unknown[i]]; e < Ht->p[unknown[i] + 1]; e++)
      if (slot[Ht->i[e]] < 0) {
        slot[Ht->i[e]] = columns;
        list[columns++] = Ht->i[e];
      }
  return columns;
}

/* (IN1), (IN2) slot, list: scratch, m; X, work: scratch for a batch. */
static dls_status influence_by_columns(const dlsi_factor *factor, const dlsi_operator *H, int *slot,
                                       int *list, double *X, double *work, double *W,
                                       dls_error *error) {
  const size_t m = (size_t)H->Ht.rows;
  for (size_t j = 0; j < m; j++)
    slot[j] = -1;
  for (int k = 0; k < factor->parts; k++) {
    const int *unknown = factor->unknown + factor->first[k];
    const size_t s = (size_t)(factor->first[k + 1] - factor->first[k]);
    const int columns = influence_list(&H->Ht, unknown, s, slot, list);
    for (int start = 0; start < columns; start += dlsi_batch) {
      const int count = columns - start < dlsi_batch ? columns - start : dlsi_batch;
      influence_gather(&H->Ht, unknown, s, slot, start, count, X);
      const dls_status status = dlsi_factor_solve(factor, k, X, count, work, error); /* (IN1) */
      if (status) return status;
      if (dlsi_watch_stops(factor->watch, factor->parts > 1 ? k : start, DBL_MAX))
        return DLS_CANCELLED;
      for (int j = 0; j < count; j++) /* (IN2) */
        dlsi_operator_add(H, unknown, s, X + (size_t)j * s, W + (size_t)list[start + j] * m);
    }
    for (int j = 0; j < columns; j++)
      slot[list[j]] = -1;
  }
  return DLS_OK;
}

static dls_status influence_from_solves(const dlsi_factor *factor, const dlsi_operator *H,
                                        double *W, dls_error *error) {
  const size_t m = (size_t)H->Ht.rows, largest = (size_t)factor->largest;
  const size_t batch = m < dlsi_batch ? m : dlsi_batch;
  int *list = dlsi_alloc(2 * m, sizeof *list);
  double *X = dlsi_alloc((1 + factor->scratch) * largest, batch * sizeof *X);
  const dls_status status =
      list && X ? influence_by_columns(factor, H, list, list + m, X, X + largest * batch, W, error)
                : dlsi_no_memory(error);
  free(X);
  free(list);
  return status;
}

/* Transposes H^T to the columns of H_c: row k is the unknown keep[k]. */
static dls_status influence_columns(const dlsi_operator *H, dlsi_columns *Hc, dls_error *error) {
  const dlsi_columns *Ht = &H->Ht;
  dlsi_triplets t;
  dls_status status = dlsi_triplets_alloc(H->kept, Ht->rows, (size_t)Ht->p[Ht->cols], &t, error);
  for (int k = 0; !status && k < H->kept; k++)
    for (int e = Ht->p[H->keep[k]]; e < Ht->p[H->keep[k] + 1]; e++)
      dlsi_triplets_add(&t, k, Ht->i[e], Ht->x[e]);
  if (!status) status = dlsi_columns_compress(&t, 1, DLSI_ALL, Hc, error);
  dlsi_triplets_free(&t);
  return status;
}

/* (IN4) z: scratch, b. Returns 1 if the host cancels. */
static int influence_between(const dlsi_operator *H, const dlsi_columns *Hc, dlsi_watch *watch,
                             const double *Z, double *z, double *W) {
  const size_t b = (size_t)H->kept, m = (size_t)H->Ht.rows;
  for (size_t j = 0; j < m; j++) {
    if (Hc->p[j] == Hc->p[j + 1]) continue;
    memset(z, 0, b * sizeof *z);
    for (int e = Hc->p[j]; e < Hc->p[j + 1]; e++) {
      const double *column = Z + (size_t)Hc->i[e] * b, h = Hc->x[e];
      for (size_t i = 0; i < b; i++)
        z[i] += h * column[i];
    }
    dlsi_operator_add(H, H->keep, b, z, W + j * m);
    if (dlsi_watch_stops(watch, H->kept, 8.0 * (double)b)) return 1;
  }
  return 0;
}

static dls_status influence_from_schur(dlsi_factor *factor, const dlsi_operator *H, double *W,
                                       dls_error *error) {
  const size_t b = (size_t)factor->kept;
  dlsi_columns Hc = {0};
  double *Z = factor->Z ? factor->Z : dlsi_alloc(b + 1, b * sizeof *Z);
  dls_status status = Z ? influence_columns(H, &Hc, error) : dlsi_no_memory(error);
  if (!status && !factor->Z) status = dlsi_schur_inverse(factor->schur, Z);
  factor->Z = !status && factor->keeps_Z ? Z : NULL;
  if (!status && influence_between(H, &Hc, factor->watch, Z, Z + b * b, W)) status = DLS_CANCELLED;
  if (!factor->Z) free(Z);
  dlsi_columns_free(&Hc);
  return status;
}

dls_status dlsi_influence(dlsi_factor *factor, const dlsi_operator *H, double *W,
                          dls_error *error) {
  const size_t m = (size_t)H->Ht.rows;
  memset(W, 0, m * m * sizeof *W);
  const dls_status status = factor->kept > 0 ? influence_from_schur(factor, H, W, error)
                                             : influence_from_solves(factor, H, W, error);
  if (status == DLS_E_MEMORY)
    return dlsi_fail(error, DLS_E_MEMORY, "", -1, 0,
                     "out of memory; W alone takes %.3g GB; dls_primal works without it",
                     1e-9 * (double)m * (double)m * sizeof(double));
  if (status) return status;
  if (factor->symmetric) dlsi_make_symmetric(W, m, 1); /* (IN3) */
  const long long bad = dlsi_first_not_finite(W, m * m);
  if (bad < 0) return DLS_OK;
  return dlsi_fail(error, DLS_E_NOT_FINITE, "W", bad, W[bad], "overflow");
}
