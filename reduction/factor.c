/*
 * factor.c: the back-ends behind X := K^-1 X.
 *
 *   dense K      K = S^-1 (L L^T) S^-1 or K = R^-1 (P^T L U) C^-1 (linear/dense.c), one part
 *   sparse K     as a dense K for each connected part of its graph while all are small; else
 *                linear/schur.c, one part
 *   flexibility  X := F X with F = K^-1 as given, one part
 *   host         the callback, one part
 *
 * Scaling. S, R, C are diagonal matrices of powers of two (no rounding): S brings the diagonal into
 * [1, 4), R and C the largest entry of each row, then column, near 1. The condition of the scaled
 * matrix thus shows whether K is singular. It does not depend on the units of forces, moments,
 * displacements and rotations: the inertia of a sphere in t and mm is no rigid-body mode.
 *
 * Singular: rcond = 1 / (|A|_1 |A^-1|_1) of the scaled matrix A, by dpocon or dgecon, below 10 eps.
 * Measured on 2166 free chains and trusses (2 to 767 unknowns, one to three rigid-body modes, ratio
 * of stiffnesses 1 to 400), by either factorisation: rcond is at most 0.4 eps, unless a pivot <= 0
 * stopped the factorisation before. The error names the unknown of the smallest pivot.
 *
 * Small: see dlsi_small_part in reduction_internal.h. LU factors a dense K that is symmetric but
 * not definite.
 *
 * Cost: (1/3) s^3 (Cholesky) or (2/3) s^3 (LU) per part of s unknowns, s^2 doubles; 2 s^2
 * operations per right-hand side. Fails: singular, not positive definite, part too large, no
 * memory, callback.
 * memory, callback.
 */
#include <float.h>
#include <math.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include "linear/blas.h"
#include "linear/dense.h"
#include "linear/pieces.h"
#include "reduction_internal.h"

/* ---- parts ----------------------------------------------------------------------------------- */

static size_t part_size(const dlsi_factor *factor, int part) {
  return (size_t)(factor->first[part + 1] - factor->first[part]);
}

/* Returns the root of i: the smallest unknown of its tree; halves the path on the way. */
static int part_root(int *parent, int i) {
  while (parent[i] != i) {
    parent[i] = parent[parent[i]];
    i = parent[i];
  }
  return i;
}

/* Finds the connected parts of the graph of Ks + Ks^T, in the order of their smallest unknown.
 * part: receives the part of each unknown, n. */
static void part_connect(const dls_sparse *Ks, dlsi_factor *factor, int *part) {
  const int n = factor->n;
  int *parent = factor->unknown, *first = factor->first;
  for (int j = 0; j < n; j++)
    for (int k = Ks->p[j]; k < Ks->p[j + 1]; k++) {
      const int a = part_root(parent, j), b = part_root(parent, Ks->i[k]);
      parent[a < b ? b : a] = a < b ? a : b;
    }
  factor->parts = 0;
  for (int i = 0; i < n; i++) { /* a root comes before the others of its tree */
    const int root = part_root(parent, i);
    part[i] = root == i ? factor->parts++ : part[root];
  }
  memset(first, 0, ((size_t)n + 1) * sizeof *first);
  for (int i = 0; i < n; i++)
    first[part[i] + 1]++;
  factor->largest = 0;
  for (int k = 0; k < factor->parts; k++) {
    if (first[k + 1] > factor->largest) factor->largest = first[k + 1];
    first[k + 1] += first[k];
  }
  for (int i = 0; i < n; i++) /* first[k] runs to the end of part k, ... */
    factor->unknown[first[part[i]]++] = i;
  for (int k = factor->parts; k > 0; k--) /* ... where the next one begins */
    first[k] = first[k - 1];
  first[0] = 0;
}

static void part_one(dlsi_factor *factor) {
  factor->parts = 1;
  factor->largest = factor->first[1] = factor->n;
  factor->first[0] = 0;
  for (int i = 0; i < factor->n; i++)
    factor->unknown[i] = i;
}

/* ---- one part -------------------------------------------------------------------------------- */

/* A dense part while it is factored, and its names for errors. */
typedef struct dense_part {
  const char *argument; /* "K" or "Ks" */
  const int *unknown;   /* s */
  dlsi_dense M;         /* s x s */
  double *row, *col;    /* s */
} dense_part;

static dense_part part_of(const dlsi_factor *factor, int part) {
  const int first = factor->first[part];
  return (dense_part){
      .argument = factor->kind == DLS_STIFFNESS_SPARSE ? "Ks" : "K",
      .unknown = factor->unknown + first,
      .M = {.n = factor->first[part + 1] - first,
            .A = factor->A + factor->start[part],
            .pivot = factor->pivot + first,
            .cholesky = factor->factorization == DLS_CHOLESKY},
      .row = factor->row + first,
      .col = factor->col + first,
  };
}

/* Copies the matrix of a part to A; for Cholesky its lower triangle over zeros. */
static void part_assemble(const dlsi_factor *factor, const dls_model *model, int part) {
  const size_t s = part_size(factor, part);
  const int *unknown = factor->unknown + factor->first[part];
  const int lower = factor->symmetric, full = factor->factorization == DLS_LDLT;
  double *A = factor->A + factor->start[part];
  memset(A, 0, s * s * sizeof *A);
  for (size_t j = 0; j < s; j++) {
    if (model->operator_kind == DLS_STIFFNESS_SPARSE) {
      const dls_sparse *Ks = &model->Ks;
      for (int k = Ks->p[unknown[j]]; k < Ks->p[unknown[j] + 1]; k++) {
        const size_t i = (size_t)(factor->place[Ks->i[k]] - factor->first[part]);
        if (i < j && lower) continue;
        A[i + j * s] += Ks->x[k];
        if (full && i != j) A[j + i * s] += Ks->x[k];
      }
      continue;
    }
    const size_t top = lower ? j : 0;
    memcpy(A + top + j * s, model->K.a + top + j * (size_t)model->K.ld, (s - top) * sizeof *A);
    for (size_t i = j + 1; full && i < s; i++)
      A[j + i * s] = A[i + j * s];
  }
}

/* Returns 2^-e, with |e| cut off so that it is a normal number. */
static double inverse_power(int e) {
  return ldexp(1, -(e < -1000 ? -1000 : e > 1000 ? 1000 : e));
}

static dls_status part_singular(const dense_part *part, int i, double pivot, double rcond,
                                dls_error *error) {
  return dlsi_fail(error, DLS_E_SINGULAR, part->argument, part->unknown[i], pivot,
                   "singular: pivot %.3g (scaled), condition %.3g; is a body free to move?", pivot,
                   1 / rcond);
}

/* Sets row = col to 1 / sqrt(k_ii), to a power of two, and scales the lower triangle. */
static dls_status part_scale_symmetric(const dense_part *part, dls_error *error) {
  const size_t s = (size_t)part->M.n;
  double *A = part->M.A;
  for (size_t i = 0; i < s; i++) {
    const double diagonal = A[i + i * s];
    if (!(diagonal > 0))
      return dlsi_fail(error, DLS_E_NOT_POSITIVE_DEFINITE, part->argument, part->unknown[i],
                       diagonal < 0 ? -1 : 0, "not positive definite: diagonal entry %.3g",
                       diagonal);
    const int e = ilogb(diagonal);
    part->row[i] = part->col[i] = inverse_power((e - (e & 1)) / 2);
  }
  for (size_t j = 0; j < s; j++)
    for (size_t i = j; i < s; i++)
      A[i + j * s] = part->row[i] * A[i + j * s] * part->col[j];
  return DLS_OK;
}

/* Sets row to 1 / max_j |a_ij| and col to 1 / max_i |row_i a_ij|, to powers of two, and scales. */
static dls_status part_scale_general(const dense_part *part, dls_error *error) {
  const size_t s = (size_t)part->M.n;
  double *A = part->M.A;
  memset(part->row, 0, s * sizeof *part->row);
  for (size_t j = 0; j < s; j++)
    for (size_t i = 0; i < s; i++)
      if (fabs(A[i + j * s]) > part->row[i]) part->row[i] = fabs(A[i + j * s]);
  for (size_t i = 0; i < s; i++) {
    if (part->row[i] == 0) return part_singular(part, (int)i, 0, 0, error);
    part->row[i] = inverse_power(ilogb(part->row[i]));
  }
  for (size_t j = 0; j < s; j++) {
    double *a = A + j * s;
    for (size_t i = 0; i < s; i++)
      a[i] *= part->row[i];
    const double largest = dlsi_max_abs(a, s);
    if (largest == 0) return part_singular(part, (int)j, 0, 0, error);
    part->col[j] = inverse_power(ilogb(largest));
    for (size_t i = 0; i < s; i++)
      a[i] *= part->col[j];
  }
  return DLS_OK;
}

/* Scales and factors a part; returns its rcond in *rcond. work: 4 s; iwork: s. */
static dls_status part_factor(dense_part *part, dlsi_watch *watch, double *rcond, double *work,
                              int *iwork, dls_error *error) {
  const size_t s = (size_t)part->M.n;
  const int symmetric = part->M.cholesky;
  double *A = part->M.A;
  const long long bad = dlsi_first_not_finite(A, s * s);
  if (bad >= 0)
    return dlsi_fail(error, DLS_E_NOT_FINITE, part->argument, part->unknown[(size_t)bad / s],
                     A[bad], "entries of one place in this column add up to %g", A[bad]);
  const dls_status status =
      symmetric ? part_scale_symmetric(part, error) : part_scale_general(part, error);
  if (status) return status;
  const double norm = dlsi_dense_norm(A, s, symmetric, work);
  const int failed =
      symmetric ? dlsi_dense_cholesky_watched(&part->M, watch) : dlsi_dense_lu(&part->M);
  if (failed == dlsi_stopped) return DLS_CANCELLED;
  if (failed && !symmetric) return part_singular(part, failed - 1, 0, 0, error);
  if (failed) {
    const double pivot = A[(size_t)(failed - 1) * (s + 1)];
    return dlsi_fail(error, DLS_E_NOT_POSITIVE_DEFINITE, part->argument, part->unknown[failed - 1],
                     pivot, "not positive definite: pivot %.3g (scaled); is a body free to move?",
                     pivot);
  }
  *rcond = dlsi_dense_rcond(&part->M, norm, work, iwork);
  if (*rcond >= 10 * DBL_EPSILON) return DLS_OK; /* false for NaN */
  size_t smallest = 0;
  for (size_t j = 1; j < s; j++)
    if (fabs(A[j * (s + 1)]) < fabs(A[smallest * (s + 1)])) smallest = j;
  const double pivot = A[smallest * (s + 1)];
  return part_singular(part, (int)smallest, symmetric ? pivot * pivot : pivot, *rcond, error);
}

/* ---- create, solve, destroy ------------------------------------------------------------------ */

/* Carves all arrays but A. The host's solver needs only the list of unknowns. */
static void factor_carve(dlsi_factor *factor, dlsi_arena *arena) {
  const size_t n = (size_t)factor->n, matrix = factor->kind == DLS_HOST_SOLVER ? 0 : n;
  factor->first = dlsi_take(arena, n + 1, sizeof *factor->first);
  factor->unknown = dlsi_take(arena, n, sizeof *factor->unknown);
  factor->place = dlsi_take(arena, n, sizeof *factor->place);
  factor->start = dlsi_take(arena, matrix, sizeof *factor->start);
  factor->row = dlsi_take(arena, matrix, sizeof *factor->row);
  factor->col = dlsi_take(arena, matrix, sizeof *factor->col);
  factor->pivot = dlsi_take(arena, matrix, sizeof *factor->pivot);
}

/* Sets start, entries and place. */
static dls_status factor_lay_out(dlsi_factor *factor, dls_error *error) {
  for (int k = 0; k < factor->n; k++)
    factor->place[factor->unknown[k]] = k;
  if (factor->kind == DLS_HOST_SOLVER || factor->schur) return DLS_OK;
  for (int k = 0; k < factor->parts; k++) {
    const size_t s = part_size(factor, k);
    if (factor->kind == DLS_STIFFNESS_SPARSE && s > dlsi_largest_part)
      return dlsi_fail(
          error, DLS_E_UNSUPPORTED, "Ks", factor->unknown[factor->first[k]], (double)s,
          "a connected part of %zu unknowns; at most %d are factored as a dense matrix", s,
          dlsi_largest_part);
    if (s > SIZE_MAX / sizeof(double) / s || factor->entries > SIZE_MAX / sizeof(double) - s * s)
      return dlsi_fail(error, DLS_E_SIZE, "n", -1, factor->n, "too large to address");
    factor->start[k] = factor->entries;
    factor->entries += s * s;
  }
  return DLS_OK;
}

/* Returns 1 if every part is so small that a dense factor is faster than schur.c. */
static int factor_is_small(const dlsi_factor *factor) {
  const int quick = factor->factorization == DLS_CHOLESKY && factor->parts <= dlsi_few_parts;
  return factor->largest <= (quick ? dlsi_tiny_part : dlsi_small_part);
}

/* Finds the parts. Has schur.c analyse a sparse K with a large part. */
static dls_status factor_divide(dlsi_factor *factor, const dls_model *model, int count,
                                const int *keep, dls_error *error) {
  part_one(factor);
  if (factor->kind != DLS_STIFFNESS_SPARSE) return DLS_OK;
  part_connect(&model->Ks, factor, factor->place);
  if (factor_is_small(factor) || !dlsi_schur_available()) return DLS_OK;
  part_one(factor);
  factor->kept = count;
  return dlsi_schur_create(&factor->schur, &model->Ks, factor->factorization, count, keep, error);
}

dls_status dlsi_factor_create(dlsi_factor **out, const dls_model *model, int count, const int *keep,
                              dls_error *error) {
  *out = NULL;
  dls_status status = dlsi_check_product(error);
  if (status) return status;
  dlsi_factor *factor = calloc(1, sizeof *factor);
  if (!factor) return dlsi_no_memory(error);
  factor->n = model->n;
  factor->kind = model->operator_kind;
  factor->factorization = model->factorization;
  factor->symmetric = model->factorization != DLS_LU &&
                      (factor->kind == DLS_STIFFNESS_DENSE || factor->kind == DLS_STIFFNESS_SPARSE);
  factor->scratch = factor->kind == DLS_FLEXIBILITY;
  factor->solve = model->solve;
  factor->user = model->user;
  dlsi_arena arena = {0};
  factor_carve(factor, &arena);
  factor->memory = arena.failed ? NULL : dlsi_alloc(arena.used, 1);
  status = factor->memory ? DLS_OK : dlsi_no_memory(error);
  if (!status) {
    arena = (dlsi_arena){.base = factor->memory, .size = arena.used};
    factor_carve(factor, &arena);
    status = factor_divide(factor, model, count, keep, error);
  }
  if (!status) status = factor_lay_out(factor, error);
  if (status)
    dlsi_factor_destroy(factor);
  else
    *out = factor;
  return status;
}

void dlsi_factor_estimate(const dlsi_factor *factor, dls_reduction_info *info) {
  if (factor->schur) {
    const dlsi_schur_measures *schur = dlsi_schur_measured(factor->schur);
    const double b = factor->kept;
    info->factor_bytes = schur->factor_bytes + sizeof(double) * b * b;
    info->bytes = schur->bytes;
    info->flops = schur->flops;
    return;
  }
  info->factor_bytes = info->bytes = (double)sizeof(double) * (double)factor->entries;
  info->flops = 0;
  if (factor->kind != DLS_STIFFNESS_DENSE && factor->kind != DLS_STIFFNESS_SPARSE) return;
  for (int k = 0; k < factor->parts; k++) {
    const double s = (double)part_size(factor, k);
    info->flops += (factor->factorization == DLS_CHOLESKY ? 1 : 2) * s * s * s / 3;
  }
}

dls_status dlsi_factor_same(const dlsi_factor *factor, const dls_model *model, dls_error *error) {
  const dls_sparse *Ks = &model->Ks;
  if (factor->kind != DLS_STIFFNESS_SPARSE) return DLS_OK;
  if (factor->schur) return dlsi_schur_same(factor->schur, Ks, error);
  for (int k = 0; k < factor->parts; k++) /* no entry may tie two parts together */
    for (int at = factor->first[k]; at < factor->first[k + 1]; at++) {
      const int j = factor->unknown[at];
      for (int e = Ks->p[j]; e < Ks->p[j + 1]; e++) {
        const int place = factor->place[Ks->i[e]];
        if (place < factor->first[k] || place >= factor->first[k + 1])
          return dlsi_fail(error, DLS_E_ARGUMENT, "Ks", e, Ks->i[e],
                           "the pattern is not the one of create");
      }
    }
  return DLS_OK;
}

dls_status dlsi_factor_numeric(dlsi_factor *factor, const dls_model *model, dls_error *error) {
  if (factor->kind == DLS_HOST_SOLVER) return DLS_OK;
  free(factor->Z);
  factor->Z = NULL;
  if (factor->schur) {
    dlsi_schur_watch(factor->schur, factor->watch);
    const dls_status status = dlsi_schur_factor(factor->schur, &model->Ks, error);
    if (!status) factor->rcond = dlsi_schur_measured(factor->schur)->rcond;
    return status;
  }
  if (!factor->A) factor->A = dlsi_alloc(factor->entries, sizeof *factor->A);
  double *work = dlsi_alloc(4 * (size_t)factor->largest, sizeof *work);
  int *iwork = dlsi_alloc((size_t)factor->largest, sizeof *iwork);
  dls_status status = factor->A && work && iwork ? DLS_OK : dlsi_no_memory(error);
  factor->rcond = factor->kind == DLS_FLEXIBILITY ? 0 : 1;
  for (int k = 0; !status && k < factor->parts; k++) {
    double rcond = 1;
    dense_part part = part_of(factor, k);
    part_assemble(factor, model, k);
    if (factor->kind != DLS_FLEXIBILITY)
      status = part_factor(&part, factor->watch, &rcond, work, iwork, error);
    const double s = part.M.n;
    if (!status && dlsi_watch_stops(factor->watch, k, s * s * s / 3)) status = DLS_CANCELLED;
    if (rcond < factor->rcond) factor->rcond = rcond;
  }
  free(iwork);
  free(work);
  return status;
}

static dls_status factor_host(const dlsi_factor *factor, double *X, int nrhs, dls_error *error) {
  const int n = factor->n;
  dlsi_host own;
  dlsi_go_out(&own);
  const int answer = factor->solve(factor->user, X, n, nrhs);
  dlsi_come_in(&own);
  if (answer) return dlsi_fail(error, DLS_E_CALLBACK, "solve", -1, answer, "returned %d", answer);
  const long long bad = dlsi_first_not_finite(X, (size_t)n * (size_t)nrhs);
  if (bad < 0) return DLS_OK;
  return dlsi_fail(error, DLS_E_CALLBACK, "solve", bad % n, X[bad],
                   "left a result that is not finite");
}

dls_status dlsi_factor_solve(const dlsi_factor *factor, int part, double *X, int nrhs, double *work,
                             dls_error *error) {
  if (factor->kind == DLS_HOST_SOLVER) return factor_host(factor, X, nrhs, error);
  if (factor->schur) return dlsi_schur_solve(factor->schur, X, nrhs, error);
  const dense_part of = part_of(factor, part);
  const size_t s = (size_t)of.M.n;
  if (factor->kind == DLS_FLEXIBILITY) {
    const int n = of.M.n;
    memcpy(work, X, s * (size_t)nrhs * sizeof *work);
    dlsi_gemm(dlsi_is_small(s * s), 'N', 'N', n, nrhs, n, 1, of.M.A, n, work, n, 0, X, n);
    return DLS_OK;
  }
  dlsi_scale_rows(of.row, s, X, nrhs);
  dlsi_dense_solve(&of.M, X, of.M.n, nrhs);
  dlsi_scale_rows(of.col, s, X, nrhs);
  return DLS_OK;
}

void dlsi_factor_destroy(dlsi_factor *factor) {
  if (!factor) return;
  dlsi_schur_destroy(factor->schur);
  free(factor->Z);
  free(factor->A);
  free(factor->memory);
  free(factor);
}
