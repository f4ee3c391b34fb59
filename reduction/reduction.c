/*
 * reduction.c: W = H^T K^-1 H and q = H^T K^-1 f + P^T g, and back: x = K^-1 (f + H r).
 *
 * Source: [Jean 1988] (3.3)1-6, with the weighting of 4.4. His W_nn, W_nt, W_tn, W_tt come out
 * interleaved, in local order per candidate. The unknowns are M r, so that H = L P without his M.
 *
 *   for each part k of K                                                            (see factor.c)
 *     for each batch J of the columns of H that load it
 *       X := K_k^-1 H_kJ                                                                    (W1)
 *       W(:,J) += H_k^T X                                                                   (W2)
 *   W := (W + W^T) / 2 if K was factored by Cholesky                                        (W3)
 *
 * H is kept by rows, in the order of the parts, so that (W2) reads just the rows that H touches and
 * X never exists as a whole. (W3) leaves W exactly symmetric; flexibility matrices and the host's
 * solver are taken at their word.
 *
 * Cost, beside the factor: one solve per column of H in each part that it loads; (W2) nnz(H)
 * operations per column. Memory: m^2 + O(n + nnz H) doubles, while forming W also dlsi_batch
 * columns of the largest part. load and recover: one solve each.
 */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "reduction_internal.h"

struct dls_reduction {
  int d, nodes, candidates;
  size_t n, m;
  dlsi_factor *factor;
  /* H by rows: entry e, p[k] <= e < p[k+1], of the unknown at position k stands in column j[e] */
  size_t *p;
  int *j;
  double *h;
  /* P by columns as given; Pp = NULL for none */
  int *Pp, *Pi;
  double *Px;
  double *W;     /* m x m */
  double *q;     /* m */
  double *f;     /* n, by position: the last load */
  double *x, *y; /* n, by position: room for load and recover; y as scratch of the solve */
  double *v;     /* m: room for load */
  void *memory;  /* of all of these but the factor */
};

/* ---- H and P --------------------------------------------------------------------------------- */

/* Entries of H = L P, those of one place counted one by one. */
static size_t count_entries(const dls_model *model) {
  const int d = model->d, candidates = dlsi_model_candidates(model);
  size_t count = 0;
  for (int c = 0; c < candidates; c++) {
    const int begin = model->P.p ? model->P.p[c] : c, end = model->P.p ? model->P.p[c + 1] : c + 1;
    for (int k = begin; k < end; k++) {
      const int node = model->P.p ? model->P.i[k] : k;
      count += (size_t)(model->HN.p[node + 1] - model->HN.p[node]);
      count += (size_t)(model->HT.p[(d - 1) * (node + 1)] - model->HT.p[(d - 1) * node]);
    }
  }
  return count;
}

/* H = L P by rows; at[position of the row] moves on to the next free entry. With `fill` 0 only
 * counts: at[position] += 1. */
static void expand(dls_reduction *R, const dls_model *model, const int *position, size_t *at,
                   int fill) {
  const int d = R->d;
  for (int c = 0; c < R->candidates; c++) {
    const int begin = R->Pp ? R->Pp[c] : c, end = R->Pp ? R->Pp[c + 1] : c + 1;
    for (int k = begin; k < end; k++) {
      const int node = R->Pp ? R->Pi[k] : k;
      const double weight = R->Pp ? R->Px[k] : 1;
      for (int i = 0; i < d; i++) { /* local component: n, then the tangents */
        const dls_sparse *L = i == 0 ? &model->HN : &model->HT;
        const int column = i == 0 ? node : (d - 1) * node + i - 1;
        for (int e = L->p[column]; e < L->p[column + 1]; e++) {
          const size_t to = at[position[L->i[e]]]++;
          if (!fill) continue;
          R->j[to] = d * c + i;
          R->h[to] = weight * L->x[e];
        }
      }
    }
  }
}

/* position (n): room */
static void store_rows(dls_reduction *R, const dls_model *model, int *position) {
  for (size_t k = 0; k < R->n; k++)
    position[R->factor->unknown[k]] = (int)k;
  size_t *p = R->p; /* counts stand two places on, then starts one place on, which end as p */
  memset(p, 0, (R->n + 2) * sizeof *p);
  expand(R, model, position, p + 2, 0);
  for (size_t k = 1; k <= R->n; k++)
    p[k + 1] += p[k];
  expand(R, model, position, p + 1, 1);
}

/* ---- W --------------------------------------------------------------------------------------- */

/* X (s x count) := the columns J of H within the part; slot[j]: place of column j in the list */
static void gather(const dls_reduction *R, size_t first, size_t s, const int *slot, int start,
                   int count, double *X) {
  memset(X, 0, s * (size_t)count * sizeof *X);
  for (size_t i = 0; i < s; i++)
    for (size_t e = R->p[first + i]; e < R->p[first + i + 1]; e++) {
      const int k = slot[R->j[e]] - start;
      if (k >= 0 && k < count) X[i + s * (size_t)k] += R->h[e];
    }
}

/* y (m) += H^T x over the s unknowns from position `first` on; x begins with the first of these */
static void add_transposed(const dls_reduction *R, size_t first, size_t s, const double *x,
                           double *y) {
  for (size_t i = 0; i < s; i++)
    for (size_t e = R->p[first + i]; e < R->p[first + i + 1]; e++)
      y[R->j[e]] += R->h[e] * x[i];
}

/* slot (m), list (m): room; X, work: of a batch */
static dls_status form_W(dls_reduction *R, const char *function, int *slot, int *list, double *X,
                         double *work, dls_error *error) {
  const dlsi_factor *factor = R->factor;
  const size_t m = R->m;
  memset(R->W, 0, m * m * sizeof *R->W);
  for (size_t j = 0; j < m; j++)
    slot[j] = -1;
  for (int k = 0; k < factor->parts; k++) {
    const size_t first = (size_t)factor->first[k], s = (size_t)factor->first[k + 1] - first;
    int columns = 0;
    for (size_t e = R->p[first]; e < R->p[first + s]; e++)
      if (slot[R->j[e]] < 0) {
        slot[R->j[e]] = columns;
        list[columns++] = R->j[e];
      }
    for (int start = 0; start < columns; start += dlsi_batch) {
      const int count = columns - start < dlsi_batch ? columns - start : dlsi_batch;
      gather(R, first, s, slot, start, count, X);
      const dls_status status = dlsi_factor_solve(factor, function, k, X, count, work, error);
      if (status) return status; /* (W1) */
      for (int j = 0; j < count; j++)
        add_transposed(R, first, s, X + (size_t)j * s,
                       R->W + (size_t)list[start + j] * m); /* (W2) */
    }
    for (int j = 0; j < columns; j++)
      slot[list[j]] = -1;
  }
  if (factor->symmetric)
    for (size_t j = 0; j < m; j++)
      for (size_t i = 0; i < j; i++)
        R->W[i + j * m] = R->W[j + i * m] = R->W[i + j * m] / 2 + R->W[j + i * m] / 2; /* (W3) */
  const long long bad = dlsi_first_not_finite(R->W, m * m);
  if (bad >= 0)
    return dlsi_fail(error, DLS_E_NOT_FINITE, function, "W", bad, R->W[bad], "overflow");
  return DLS_OK;
}

/* ---- create, destroy ------------------------------------------------------------------------- */

static void carve(dls_reduction *R, const dls_model *model, dlsi_arena *arena) {
  const size_t n = R->n, m = R->m, entries = count_entries(model);
  const size_t weights = model->P.p ? (size_t)model->P.p[R->candidates] : 0;
  R->p = dlsi_take(arena, n + 2, sizeof *R->p);
  R->j = dlsi_take(arena, entries, sizeof *R->j);
  R->h = dlsi_take(arena, entries, sizeof *R->h);
  R->Pp = model->P.p ? dlsi_take(arena, (size_t)R->candidates + 1, sizeof *R->Pp) : NULL;
  R->Pi = dlsi_take(arena, weights, sizeof *R->Pi);
  R->Px = dlsi_take(arena, weights, sizeof *R->Px);
  R->q = dlsi_take(arena, m, sizeof *R->q);
  R->v = dlsi_take(arena, m, sizeof *R->v);
  R->f = dlsi_take(arena, n, sizeof *R->f);
  R->x = dlsi_take(arena, n, sizeof *R->x);
  R->y = dlsi_take(arena, R->factor->scratch * n, sizeof *R->y);
  R->W = dlsi_take(arena, m, m * sizeof *R->W);
}

static void copy_weighting(dls_reduction *R, const dls_model *model) {
  if (!model->P.p) return;
  const size_t columns = (size_t)R->candidates, weights = (size_t)model->P.p[columns];
  memcpy(R->Pp, model->P.p, (columns + 1) * sizeof *R->Pp);
  memcpy(R->Pi, model->P.i, weights * sizeof *R->Pi);
  memcpy(R->Px, model->P.x, weights * sizeof *R->Px);
}

/* Everything but the factor, which is there. */
static dls_status fill(dls_reduction *R, const char *function, const dls_model *model,
                       dls_error *error) {
  const size_t n = R->n, m = R->m, largest = (size_t)R->factor->largest;
  const size_t batch = m < dlsi_batch ? m : dlsi_batch;
  dlsi_arena arena = {0};
  carve(R, model, &arena);
  if (arena.failed)
    return dlsi_fail(error, DLS_E_SIZE, function, "nodes", -1, R->nodes,
                     "W of %zu rows is too large to address", m);
  arena.size = arena.used;
  arena.used = 0;
  arena.base = R->memory = dlsi_alloc(arena.size, 1);
  int *list = dlsi_alloc(n > 2 * m ? n : 2 * m, sizeof *list);
  double *X = dlsi_alloc((1 + R->factor->scratch) * largest, batch * sizeof *X);
  dls_status status = DLS_OK;
  if (R->memory && list && X) {
    carve(R, model, &arena);
    copy_weighting(R, model);
    store_rows(R, model, list);
    memset(R->q, 0, m * sizeof *R->q);
    memset(R->f, 0, n * sizeof *R->f);
    status = form_W(R, function, list, list + m, X, X + largest * batch, error);
  } else
    status =
        dlsi_fail(error, DLS_E_MEMORY, function, "", -1, 0, "out of memory; W alone takes %.3g GB",
                  1e-9 * (double)m * (double)m * sizeof(double));
  free(X);
  free(list);
  return status;
}

dls_status dls_reduction_create(dls_reduction **out, const dls_model *model, dls_error *error) {
  if (!out) return dlsi_fail(error, DLS_E_ARGUMENT, __func__, "out", -1, 0, "is NULL");
  *out = NULL;
  dls_status status = dlsi_check_model(__func__, model, error);
  if (status) return status;
  dls_reduction *R = calloc(1, sizeof *R);
  if (!R) return dlsi_fail(error, DLS_E_MEMORY, __func__, "", -1, 0, "out of memory");
  R->d = model->d;
  R->nodes = model->nodes;
  R->candidates = dlsi_model_candidates(model);
  R->n = (size_t)model->n;
  R->m = (size_t)R->d * (size_t)R->candidates;
  status = dlsi_factor_create(&R->factor, __func__, model, error);
  if (!status) status = fill(R, __func__, model, error);
  if (status)
    dls_reduction_destroy(R);
  else
    *out = R;
  return status;
}

void dls_reduction_destroy(dls_reduction *reduction) {
  if (!reduction) return;
  dlsi_factor_destroy(reduction->factor);
  free(reduction->memory);
  free(reduction);
}

/* ---- load, contact, recover, nodal ----------------------------------------------------------- */

/* R->x := K^-1 R->x, part by part */
static dls_status solve_x(dls_reduction *R, const char *function, dls_error *error) {
  dls_status status = DLS_OK;
  for (int k = 0; !status && k < R->factor->parts; k++)
    status = dlsi_factor_solve(R->factor, function, k, R->x + R->factor->first[k], 1, R->y, error);
  return status;
}

dls_status dls_reduction_load(dls_reduction *reduction, const double *f, const double *g,
                              dls_error *error) {
  dls_reduction *R = reduction;
  if (!R) return dlsi_fail(error, DLS_E_ARGUMENT, __func__, "reduction", -1, 0, "is NULL");
  const size_t n = R->n, m = R->m, d = (size_t)R->d;
  dls_status status = f ? dlsi_check_vector(__func__, "f", f, n, error) : DLS_OK;
  if (!status && g) status = dlsi_check_vector(__func__, "g", g, d * (size_t)R->nodes, error);
  if (status) return status;

  memset(R->v, 0, m * sizeof *R->v);
  for (size_t c = 0; g && c < (size_t)R->candidates; c++) /* v = P^T g */
    for (size_t i = 0; i < d; i++) {
      if (!R->Pp) R->v[d * c + i] = g[d * c + i];
      for (int k = R->Pp ? R->Pp[c] : 0; R->Pp && k < R->Pp[c + 1]; k++)
        R->v[d * c + i] += R->Px[k] * g[d * (size_t)R->Pi[k] + i];
    }
  if (f) { /* v += H^T K^-1 f */
    for (size_t k = 0; k < n; k++)
      R->x[k] = f[R->factor->unknown[k]];
    status = solve_x(R, __func__, error);
    if (status) return status;
    add_transposed(R, 0, n, R->x, R->v);
  }
  const long long bad = dlsi_first_not_finite(R->v, m);
  if (bad >= 0)
    return dlsi_fail(error, DLS_E_NOT_FINITE, __func__, "q", bad, R->v[bad], "overflow");
  memcpy(R->q, R->v, m * sizeof *R->q);
  for (size_t k = 0; k < n; k++)
    R->f[k] = f ? f[R->factor->unknown[k]] : 0;
  return DLS_OK;
}

dls_status dls_reduction_contact(const dls_reduction *reduction, const double *mu,
                                 dls_contact *problem, dls_error *error) {
  const dls_reduction *R = reduction;
  if (!R) return dlsi_fail(error, DLS_E_ARGUMENT, __func__, "reduction", -1, 0, "is NULL");
  const dls_status status = dlsi_check_vector(__func__, "mu", mu, (size_t)R->candidates, error);
  if (status) return status;
  for (int c = 0; c < R->candidates; c++)
    if (mu[c] < 0) return dlsi_fail(error, DLS_E_ARGUMENT, __func__, "mu", c, mu[c], "is negative");
  if (!problem) return dlsi_fail(error, DLS_E_ARGUMENT, __func__, "problem", -1, 0, "is NULL");
  const int m = (int)R->m;
  *problem =
      (dls_contact){.d = R->d, .nc = R->candidates, .W = {m, m, m, R->W}, .q = R->q, .mu = mu};
  return DLS_OK;
}

dls_status dls_reduction_recover(dls_reduction *reduction, const double *r, double *x,
                                 dls_error *error) {
  dls_reduction *R = reduction;
  if (!R) return dlsi_fail(error, DLS_E_ARGUMENT, __func__, "reduction", -1, 0, "is NULL");
  dls_status status = dlsi_check_vector(__func__, "r", r, R->m, error);
  if (status) return status;
  if (!x) return dlsi_fail(error, DLS_E_ARGUMENT, __func__, "x", -1, 0, "is NULL");
  for (size_t k = 0; k < R->n; k++) { /* f + H r */
    double sum = R->f[k];
    for (size_t e = R->p[k]; e < R->p[k + 1]; e++)
      sum += R->h[e] * r[R->j[e]];
    R->x[k] = sum;
  }
  status = solve_x(R, __func__, error);
  if (status) return status;
  const long long bad = dlsi_first_not_finite(R->x, R->n);
  if (bad >= 0)
    return dlsi_fail(error, DLS_E_NOT_FINITE, __func__, "x", R->factor->unknown[bad], R->x[bad],
                     "overflow");
  for (size_t k = 0; k < R->n; k++)
    x[R->factor->unknown[k]] = R->x[k];
  return DLS_OK;
}

dls_status dls_reduction_nodal(const dls_reduction *reduction, const double *r, double *R,
                               dls_error *error) {
  const dls_reduction *A = reduction;
  if (!A) return dlsi_fail(error, DLS_E_ARGUMENT, __func__, "reduction", -1, 0, "is NULL");
  const dls_status status = dlsi_check_vector(__func__, "r", r, A->m, error);
  if (status) return status;
  if (!R) return dlsi_fail(error, DLS_E_ARGUMENT, __func__, "R", -1, 0, "is NULL");
  if (!A->Pp) {
    memcpy(R, r, A->m * sizeof *R);
    return DLS_OK;
  }
  const size_t d = (size_t)A->d;
  memset(R, 0, d * (size_t)A->nodes * sizeof *R);
  for (size_t c = 0; c < (size_t)A->candidates; c++)
    for (int k = A->Pp[c]; k < A->Pp[c + 1]; k++)
      for (size_t i = 0; i < d; i++)
        R[d * (size_t)A->Pi[k] + i] += A->Px[k] * r[d * c + i];
  return DLS_OK;
}
