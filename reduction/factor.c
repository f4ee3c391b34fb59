/*
 * factor.c: the back-ends behind X := K^-1 X.
 *
 *   dense K      K = S^-1 (L L^T) S^-1 or K = R^-1 (P^T L U) C^-1 (LAPACK), one part
 *   sparse K     the same for each connected part of its graph while all are small; else schur.c, one
 *                part
 *   flexibility  X := F X with F = K^-1 as given, one part
 *   host         the callback, one part
 *
 * Scaling. S, R, C are diagonal matrices of powers of two (no rounding): S brings the diagonal into
 * [1, 4), R and C the largest entry of each row, then column, near 1. The condition of what is
 * factored thus says whether K is singular, not in which units forces, moments, displacements and
 * rotations happen to be: the inertia of a sphere in tonnes and millimetres is no rigid-body mode.
 *
 * Singular: rcond = 1 / (|A|_1 |A^-1|_1) of the scaled matrix A, by dpocon or dgecon, below 10
 * eps. Of 2166 free chains and trusses (2 to 767 unknowns, one to three rigid-body modes,
 * stiffnesses of 1 to 400 side by side), by either factorisation, none came out above 0.4 eps
 * unless a pivot <= 0 had stopped it before. The smallest pivot is reported with its unknown.
 *
 * Small: see dlsi_small_part in reduction_internal.h. A dense K that is symmetric but not definite is
 * factored by LU.
 *
 * Cost: (1/3) s^3 (Cholesky) or (2/3) s^3 (LU) per part of s unknowns, s^2 doubles; 2 s^2
 * operations per right-hand side. Fails: singular, not positive definite, part too large, no
 * memory, callback.
 */
#include <float.h>
#include <math.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include "linear/blas.h"
#include "reduction_internal.h"

/* ---- parts ----------------------------------------------------------------------------------- */

/* The root of i: the smallest unknown of its tree; halves the path on the way. */
static int find_root(int *parent, int i) {
  while (parent[i] != i) {
    parent[i] = parent[parent[i]];
    i = parent[i];
  }
  return i;
}

/* Connected parts of the graph of Ks + Ks^T, in the order of their smallest unknown. part (n):
 * receives the part of each unknown. */
static void connect(const dls_sparse *Ks, dlsi_factor *factor, int *part) {
  const int n = factor->n;
  int *parent = factor->unknown, *first = factor->first;
  for (int i = 0; i < n; i++)
    parent[i] = i;
  for (int j = 0; j < n; j++)
    for (int k = Ks->p[j]; k < Ks->p[j + 1]; k++) {
      const int a = find_root(parent, j), b = find_root(parent, Ks->i[k]);
      if (a < b)
        parent[b] = a;
      else
        parent[a] = b;
    }
  int parts = 0;
  for (int i = 0; i < n; i++) { /* a root comes before the others of its tree */
    const int root = find_root(parent, i);
    part[i] = root == i ? parts++ : part[root];
  }
  memset(first, 0, ((size_t)n + 1) * sizeof *first);
  for (int i = 0; i < n; i++)
    first[part[i] + 1]++;
  for (int k = 0; k < parts; k++)
    first[k + 1] += first[k];
  for (int i = 0; i < n; i++) /* first[k] runs to the end of part k, ... */
    factor->unknown[first[part[i]]++] = i;
  for (int k = parts; k > 0; k--) /* ... which is where the next one begins */
    first[k] = first[k - 1];
  first[0] = 0;
  factor->parts = parts;
}

static void one_part(dlsi_factor *factor) {
  factor->parts = 1;
  factor->first[0] = 0;
  factor->first[1] = factor->n;
  for (int i = 0; i < factor->n; i++)
    factor->unknown[i] = i;
}

/* ---- one part -------------------------------------------------------------------------------- */

static size_t size_of(const dlsi_factor *factor, int part) {
  return (size_t)(factor->first[part + 1] - factor->first[part]);
}

/* A := the part's matrix; for Cholesky its lower triangle over zeros. */
static void assemble(const dlsi_factor *factor, const dls_model *model, int part) {
  const size_t s = size_of(factor, part);
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

/* 2^-e with |e| small enough for this to be a normal number */
static double power_of_two(int e) {
  return ldexp(1, -(e < -1000 ? -1000 : e > 1000 ? 1000 : e));
}

/* One part on its way through the factorisation, and where to report it. */
typedef struct part_matrix {
  const char *name;   /* "K" or "Ks" */
  const int *unknown; /* s */
  size_t s;
  double *A, *row, *col; /* s x s, s, s */
  int *pivot;            /* s */
} part_matrix;

static dls_status singular(const part_matrix *M, size_t i, double pivot, double rcond,
                           dls_error *error) {
  return dlsi_fail(error, DLS_E_SINGULAR, M->name, M->unknown[i], pivot,
                   "singular: pivot %.3g (scaled), condition %.3g; is a body free to move?", pivot,
                   1 / rcond);
}

/* row = col: 1 / sqrt(k_ii), to a power of two */
static dls_status scale_symmetric(const part_matrix *M, dls_error *error) {
  const size_t s = M->s;
  for (size_t i = 0; i < s; i++) {
    const double diagonal = M->A[i + i * s];
    if (!(diagonal > 0))
      return dlsi_fail(error, DLS_E_NOT_POSITIVE_DEFINITE, M->name, M->unknown[i], diagonal,
                       "not positive definite: diagonal entry %.3g", diagonal);
    const int e = ilogb(diagonal);
    M->row[i] = M->col[i] = power_of_two((e - (e & 1)) / 2);
  }
  for (size_t j = 0; j < s; j++)
    for (size_t i = j; i < s; i++)
      M->A[i + j * s] = M->row[i] * M->A[i + j * s] * M->col[j];
  return DLS_OK;
}

/* row: 1 / max_j |a_ij|; col: 1 / max_i |row_i a_ij|, to powers of two */
static dls_status scale_general(const part_matrix *M, dls_error *error) {
  const size_t s = M->s;
  for (size_t i = 0; i < s; i++)
    M->row[i] = 0;
  for (size_t j = 0; j < s; j++)
    for (size_t i = 0; i < s; i++)
      if (fabs(M->A[i + j * s]) > M->row[i]) M->row[i] = fabs(M->A[i + j * s]);
  for (size_t i = 0; i < s; i++) {
    if (M->row[i] == 0) return singular(M, i, 0, 0, error);
    M->row[i] = power_of_two(ilogb(M->row[i]));
  }
  for (size_t j = 0; j < s; j++) {
    double *a = M->A + j * s;
    for (size_t i = 0; i < s; i++)
      a[i] *= M->row[i];
    const double largest = dlsi_max_abs(a, s);
    if (largest == 0) return singular(M, j, 0, 0, error);
    M->col[j] = power_of_two(ilogb(largest));
    for (size_t i = 0; i < s; i++)
      a[i] *= M->col[j];
  }
  return DLS_OK;
}

/* |A|_1; of a symmetric A from its lower triangle. sums (s) */
static double norm1(const double *A, size_t s, int symmetric, double *sums) {
  for (size_t j = 0; j < s; j++)
    sums[j] = 0;
  for (size_t j = 0; j < s; j++)
    for (size_t i = symmetric ? j : 0; i < s; i++) {
      sums[j] += fabs(A[i + j * s]);
      if (symmetric && i > j) sums[i] += fabs(A[i + j * s]);
    }
  return dlsi_max_abs(sums, s);
}

/* Scales and factors a part; *least := the smaller of it and the part's rcond. work (4 s), iwork (s). */
static dls_status factor_part(const part_matrix *M, int symmetric, double *work, int *iwork,
                              double *least, dls_error *error) {
  const size_t s = M->s;
  const int n = (int)s;
  double *A = M->A, rcond = 0;
  int info = 0;
  const long long bad = dlsi_first_not_finite(A, s * s);
  if (bad >= 0)
    return dlsi_fail(error, DLS_E_NOT_FINITE, M->name, M->unknown[(size_t)bad / s], A[bad],
                     "entries of one place in this column add up to %g", A[bad]);
  const dls_status status = symmetric ? scale_symmetric(M, error) : scale_general(M, error);
  if (status) return status;
  const double norm = norm1(A, s, symmetric, work);
  if (symmetric) {
    dpotrf_("L", &n, A, &n, &info, 1);
    if (info > 0) {
      const double pivot = A[(size_t)(info - 1) * (s + 1)];
      return dlsi_fail(error, DLS_E_NOT_POSITIVE_DEFINITE, M->name, M->unknown[info - 1], pivot,
                       "not positive definite: pivot %.3g (scaled); is a body free to move?",
                       pivot);
    }
    dpocon_("L", &n, A, &n, &norm, &rcond, work, iwork, &info, 1);
  } else {
    dgetrf_(&n, &n, A, &n, M->pivot, &info);
    if (info > 0) return singular(M, (size_t)info - 1, 0, 0, error);
    dgecon_("1", &n, A, &n, &norm, &rcond, work, iwork, &info, 1);
  }
  if (rcond < *least) *least = rcond;
  if (rcond >= 10 * DBL_EPSILON) return DLS_OK; /* false for NaN */
  size_t smallest = 0;
  for (size_t j = 1; j < s; j++)
    if (fabs(A[j * (s + 1)]) < fabs(A[smallest * (s + 1)])) smallest = j;
  const double pivot = A[smallest * (s + 1)];
  return singular(M, smallest, symmetric ? pivot * pivot : pivot, rcond, error);
}

/* ---- create, solve, destroy ------------------------------------------------------------------ */

/* The pieces of a factor but for A. The host's solver wants no more than the list of unknowns. */
static void carve(dlsi_factor *factor, dlsi_arena *arena) {
  const size_t n = (size_t)factor->n, matrix = factor->kind == DLS_HOST_SOLVER ? 0 : n;
  factor->first = dlsi_take(arena, n + 1, sizeof *factor->first);
  factor->unknown = dlsi_take(arena, n, sizeof *factor->unknown);
  factor->place = dlsi_take(arena, n, sizeof *factor->place);
  factor->start = dlsi_take(arena, matrix, sizeof *factor->start);
  factor->row = dlsi_take(arena, matrix, sizeof *factor->row);
  factor->col = dlsi_take(arena, matrix, sizeof *factor->col);
  factor->pivot = dlsi_take(arena, matrix, sizeof *factor->pivot);
}

/* Finds the largest part, sets start, entries and place. */
static dls_status lay_out(dlsi_factor *factor, dls_error *error) {
  factor->entries = 0;
  factor->largest = 0;
  for (int k = 0; k < factor->parts; k++) {
    const size_t s = size_of(factor, k);
    const int *unknown = factor->unknown + factor->first[k];
    if ((int)s > factor->largest) factor->largest = (int)s;
    for (size_t i = 0; i < s; i++)
      factor->place[unknown[i]] = factor->first[k] + (int)i;
    if (factor->kind == DLS_HOST_SOLVER || factor->schur) continue;
    if (factor->kind == DLS_STIFFNESS_SPARSE && s > dlsi_largest_part)
      return dlsi_fail(
          error, DLS_E_UNSUPPORTED, "Ks", unknown[0], (double)s,
          "a connected part of %zu unknowns; at most %d are factored as a dense matrix", s,
          dlsi_largest_part);
    if (s > SIZE_MAX / sizeof(double) / s || factor->entries > SIZE_MAX / sizeof(double) - s * s)
      return dlsi_fail(error, DLS_E_SIZE, "n", -1, factor->n, "too large to address");
    factor->start[k] = factor->entries;
    factor->entries += s * s;
  }
  return DLS_OK;
}

static int largest_part(const dlsi_factor *factor) {
  int largest = 0;
  for (int k = 0; k < factor->parts; k++)
    if ((int)size_of(factor, k) > largest) largest = (int)size_of(factor, k);
  return largest;
}

/* Parts, and the analysis of a sparse K with a large one. */
static dls_status divide(dlsi_factor *factor, const dls_model *model, int count, const int *keep,
                         dls_error *error) {
  one_part(factor);
  if (factor->kind != DLS_STIFFNESS_SPARSE) return DLS_OK;
  connect(&model->Ks, factor, factor->place);
  if (largest_part(factor) <= dlsi_small_part || !dlsi_schur_available()) return DLS_OK;
  one_part(factor);
  factor->kept = count;
  return dlsi_schur_create(&factor->schur, &model->Ks, factor->factorization, count, keep, error);
}

dls_status dlsi_factor_create(dlsi_factor **out, const dls_model *model, int count, const int *keep,
                              dls_error *error) {
  *out = NULL;
  dlsi_factor *factor = calloc(1, sizeof *factor);
  if (!factor) return dlsi_no_memory(error);
  const int stiffness =
      model->operator_kind == DLS_STIFFNESS_DENSE || model->operator_kind == DLS_STIFFNESS_SPARSE;
  factor->n = factor->largest = model->n;
  factor->kind = model->operator_kind;
  factor->factorization = model->factorization;
  factor->symmetric = stiffness && model->factorization != DLS_LU;
  factor->scratch = model->operator_kind == DLS_FLEXIBILITY;
  factor->solve = model->solve;
  factor->user = model->user;
  dlsi_arena arena = {0};
  carve(factor, &arena);
  arena.size = arena.used;
  arena.used = 0;
  arena.base = factor->memory = arena.failed ? NULL : dlsi_alloc(arena.size, 1);
  dls_status status = factor->memory ? DLS_OK : dlsi_no_memory(error);
  if (!status) {
    carve(factor, &arena);
    status = divide(factor, model, count, keep, error);
  }
  if (!status) status = lay_out(factor, error);
  if (status)
    dlsi_factor_destroy(factor);
  else
    *out = factor;
  return status;
}

void dlsi_factor_estimate(const dlsi_factor *factor, double *factor_bytes, double *bytes,
                          double *flops) {
  const double b = factor->kept;
  *factor_bytes = *bytes = (double)sizeof(double) * (double)factor->entries;
  *flops = 0;
  if (factor->schur) {
    dlsi_schur_estimate(factor->schur, factor_bytes, bytes, flops);
    *factor_bytes += sizeof(double) * b * b;
    return;
  }
  if (factor->kind != DLS_STIFFNESS_DENSE && factor->kind != DLS_STIFFNESS_SPARSE) return;
  for (int k = 0; k < factor->parts; k++) {
    const double s = (double)size_of(factor, k);
    *flops += (factor->factorization == DLS_CHOLESKY ? 1 : 2) * s * s * s / 3;
  }
}

/* An entry of Ks that ties two parts together: the pattern is not the one of create. */
static dls_status check_parts(const dlsi_factor *factor, const dls_sparse *Ks, dls_error *error) {
  for (int k = 0; k < factor->parts; k++)
    for (int e = factor->first[k]; e < factor->first[k + 1]; e++) {
      const int j = factor->unknown[e];
      for (int at = Ks->p[j]; at < Ks->p[j + 1]; at++) {
        const int place = factor->place[Ks->i[at]];
        if (place < factor->first[k] || place >= factor->first[k + 1])
          return dlsi_fail(error, DLS_E_ARGUMENT, "Ks", at, Ks->i[at],
                           "the pattern is not the one of create");
      }
    }
  return DLS_OK;
}

dls_status dlsi_factor_same(const dlsi_factor *factor, const dls_model *model, dls_error *error) {
  if (factor->kind != DLS_STIFFNESS_SPARSE) return DLS_OK;
  return factor->schur ? dlsi_schur_same(factor->schur, &model->Ks, error)
                       : check_parts(factor, &model->Ks, error);
}

static dls_status factor_parts(dlsi_factor *factor, const dls_model *model, double *work,
                               int *iwork, dls_error *error) {
  dls_status status = DLS_OK;
  factor->rcond = 1;
  for (int k = 0; !status && k < factor->parts; k++) {
    assemble(factor, model, k);
    const size_t first = (size_t)factor->first[k];
    const part_matrix M = {.name = factor->kind == DLS_STIFFNESS_SPARSE ? "Ks" : "K",
                           .unknown = factor->unknown + first,
                           .s = size_of(factor, k),
                           .A = factor->A + factor->start[k],
                           .row = factor->row + first,
                           .col = factor->col + first,
                           .pivot = factor->pivot + first};
    status =
        factor_part(&M, factor->factorization == DLS_CHOLESKY, work, iwork, &factor->rcond, error);
  }
  return status;
}

dls_status dlsi_factor_numeric(dlsi_factor *factor, const dls_model *model, dls_error *error) {
  if (factor->kind == DLS_HOST_SOLVER) return DLS_OK;
  if (factor->schur) {
    const dls_status status = dlsi_schur_factor(factor->schur, &model->Ks, error);
    if (!status) factor->rcond = dlsi_schur_rcond(factor->schur);
    return status;
  }
  if (!factor->A) factor->A = dlsi_alloc(factor->entries, sizeof *factor->A);
  if (!factor->A) return dlsi_no_memory(error);
  if (factor->kind == DLS_FLEXIBILITY) {
    assemble(factor, model, 0);
    return DLS_OK;
  }
  double *work = dlsi_alloc(4 * (size_t)factor->largest, sizeof *work);
  int *iwork = dlsi_alloc((size_t)factor->largest, sizeof *iwork);
  const dls_status status =
      work && iwork ? factor_parts(factor, model, work, iwork, error) : dlsi_no_memory(error);
  free(iwork);
  free(work);
  return status;
}

/* X := diag(scale) X */
static void scale_rows(const double *scale, int s, double *X, int nrhs) {
  for (int j = 0; j < nrhs; j++)
    for (int i = 0; i < s; i++)
      X[(size_t)i + (size_t)j * (size_t)s] *= scale[i];
}

dls_status dlsi_factor_solve(const dlsi_factor *factor, int part, double *X, int nrhs, double *work,
                             dls_error *error) {
  const int first = factor->first[part], s = factor->first[part + 1] - first;
  const size_t entries = (size_t)s * (size_t)nrhs;
  if (factor->kind == DLS_HOST_SOLVER) {
    const int answer = factor->solve(factor->user, X, s, nrhs);
    if (answer) return dlsi_fail(error, DLS_E_CALLBACK, "solve", -1, answer, "returned %d", answer);
    const long long bad = dlsi_first_not_finite(X, entries);
    if (bad >= 0)
      return dlsi_fail(error, DLS_E_CALLBACK, "solve", bad % s, X[bad],
                       "left a result that is not finite");
    return DLS_OK;
  }
  if (factor->schur) return dlsi_schur_solve(factor->schur, X, nrhs, error);
  const double *A = factor->A + factor->start[part];
  if (factor->kind == DLS_FLEXIBILITY) {
    const double one = 1, zero = 0;
    memcpy(work, X, entries * sizeof *work);
    dgemm_("N", "N", &s, &nrhs, &s, &one, A, &s, work, &s, &zero, X, &s, 1, 1);
    return DLS_OK;
  }
  int info = 0; /* can only be a wrong argument */
  scale_rows(factor->row + first, s, X, nrhs);
  if (factor->factorization == DLS_CHOLESKY)
    dpotrs_("L", &s, &nrhs, A, &s, X, &s, &info, 1);
  else
    dgetrs_("N", &s, &nrhs, A, &s, factor->pivot + first, X, &s, &info, 1);
  scale_rows(factor->col + first, s, X, nrhs);
  return DLS_OK;
}

void dlsi_factor_destroy(dlsi_factor *factor) {
  if (!factor) return;
  dlsi_schur_destroy(factor->schur);
  free(factor->A);
  free(factor->memory);
  free(factor);
}
