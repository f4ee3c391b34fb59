/*
 * modes.c: the null space of a singular K, and springs that hold it.
 *
 *   (N1)  A = R K C, scaled (scale.c); R = C if K is symmetric
 *   (N2)  A + sqrt(eps) 1 is factored
 *   (N3)  V := orth((A + sqrt(eps) 1)^-1 V), a block of up to 28 vectors, a few times
 *   (N4)  A V = U s Y^T; the columns of V Y with s <= 50 eps |A|_1 are null vectors
 *   (N5)  reduced to echelon form by complete pivoting: a 1 in unknown[k] of mode k, where the others
 *         are 0; then x = C v
 *
 * (N3) shrinks what is not in the null space by sqrt(eps) / s each time. In echelon form the modes of a
 * body have their 1 and their zeros on that body, so that they vanish on others.
 *
 * Cost: a factorisation, 28 solves a time.
 */
#include <float.h>
#include <math.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include "linear/blas.h"
#include "linear/equilibrate.h"
#include "reduction_internal.h"

/* of a spring against K_jj: each turn of dls_reduction_balance shrinks the imbalance by about that
 * and the softness of the body; W is the worse conditioned for it (README.md) */
static const double soft = 1e-4;

enum { block = dlsi_most_modes + 4, times = 5 };

/* ---- A --------------------------------------------------------------------------------------- */

/* A, all entries of both triangles, by columns; owned. */
typedef struct scaled {
  int n;
  int *p, *i;
  double *x;
  double *R, *C; /* n */
  double norm;   /* |A|_1 */
} scaled;

static void free_scaled(scaled *A) {
  free(A->p);
  free(A->i);
  free(A->x);
  free(A->R);
}

/* Entry `at` of column j of the model's K, dense or sparse; 0 past the last. */
static int entry_of(const dls_model *model, int j, size_t at, int *row, double *value) {
  if (model->operator_kind == DLS_STIFFNESS_DENSE) {
    if (at >= (size_t)model->n) return 0;
    *row = (int)at;
    *value = model->K.a[at + (size_t)j * (size_t)model->K.ld];
  } else {
    const dls_sparse *Ks = &model->Ks;
    if (at >= (size_t)(Ks->p[j + 1] - Ks->p[j])) return 0;
    *row = Ks->i[(size_t)Ks->p[j] + at];
    *value = Ks->x[(size_t)Ks->p[j] + at];
  }
  return 1;
}

/* Entries counted in next[column], or put at next[column]; the first one of each column is a 0 on the
 * diagonal, the place of the shift. */
static void emit(scaled *A, const dls_model *model, int *next, int fill) {
  const int symmetric = model->factorization != DLS_LU;
  for (int j = 0; j < A->n; j++) {
    const int to = next[j]++;
    if (!fill) continue;
    A->i[to] = j;
    A->x[to] = 0;
  }
  for (int j = 0; j < A->n; j++) {
    int i;
    double v;
    for (size_t at = 0; entry_of(model, j, at, &i, &v); at++) {
      if (symmetric && i < j) continue;
      for (int mirror = 0; mirror < (symmetric && i > j ? 2 : 1); mirror++) {
        const int to = next[mirror ? i : j]++;
        if (!fill) continue;
        A->i[to] = mirror ? j : i;
        A->x[to] = v;
      }
    }
  }
}

/* (N1) */
static dls_status make_scaled(scaled *A, const dls_model *model, dls_error *error) {
  const int n = model->n, symmetric = model->factorization != DLS_LU;
  *A = (scaled){.n = n};
  const double entries =
      model->operator_kind == DLS_STIFFNESS_DENSE ? (double)n * n : (double)model->Ks.p[n];
  if (2 * entries + n > INT32_MAX) return dlsi_no_memory(error);
  A->p = dlsi_alloc((size_t)n + 2, sizeof *A->p);
  A->i = dlsi_alloc((size_t)(2 * entries) + (size_t)n, sizeof *A->i);
  A->x = dlsi_alloc((size_t)(2 * entries) + (size_t)n, sizeof *A->x);
  A->R = dlsi_alloc(4 * (size_t)n, sizeof *A->R);
  if (!A->p || !A->i || !A->x || !A->R) return dlsi_no_memory(error);
  A->C = A->R + n;
  memset(A->p, 0, ((size_t)n + 2) * sizeof *A->p);
  emit(A, model, A->p + 2, 0);
  for (int j = 1; j <= n; j++)
    A->p[j + 1] += A->p[j];
  emit(A, model, A->p + 1, 1);
  double *sums = A->C + n;
  const dls_sparse K = {n, n, A->p, A->i, A->x};
  dlsi_find_scales(&K, symmetric, A->R, A->C, sums);
  for (int j = 0; j < n; j++) {
    sums[j] = 0;
    for (int k = A->p[j]; k < A->p[j + 1]; k++) {
      A->x[k] *= A->R[A->i[k]] * A->C[j];
      sums[j] += fabs(A->x[k]);
    }
  }
  A->norm = dlsi_max_abs(sums, (size_t)n);
  return DLS_OK;
}

/* Y := A V, columns of length n */
static void multiply(const scaled *A, const double *V, int count, double *Y) {
  const size_t n = (size_t)A->n;
  memset(Y, 0, n * (size_t)count * sizeof *Y);
  for (int c = 0; c < count; c++, V += n, Y += n)
    for (int j = 0; j < A->n; j++)
      for (int k = A->p[j]; k < A->p[j + 1]; k++)
        Y[A->i[k]] += A->x[k] * V[j];
}

/* ---- the block ------------------------------------------------------------------------------- */

static double dot(const double *x, const double *y, size_t n) {
  double sum = 0;
  for (size_t i = 0; i < n; i++)
    sum += x[i] * y[i];
  return sum;
}

/* Modified Gram-Schmidt, twice: what is left of a column after the first turn may be rounding. */
static void orthonormalise(double *V, size_t n, int count) {
  for (int c = 0; c < count; c++) {
    double *v = V + (size_t)c * n;
    for (int turn = 0; turn < 2; turn++) {
      const double length = dlsi_norm2(v, n);
      for (size_t i = 0; length > 0 && i < n; i++)
        v[i] /= length;
      for (int k = 0; k < c; k++) {
        const double *w = V + (size_t)k * n, s = dot(v, w, n);
        for (size_t i = 0; i < n; i++)
          v[i] -= s * w[i];
      }
    }
    const double length = dlsi_norm2(v, n);
    for (size_t i = 0; length > 0 && i < n; i++)
      v[i] /= length;
  }
}

/* (N2), (N3): V (n x count) */
static dls_status iterate(scaled *A, int symmetric, double *V, int count, dls_error *error) {
  const size_t n = (size_t)A->n;
  for (size_t j = 0; j < n; j++)
    A->x[A->p[j]] = sqrt(DBL_EPSILON);
  const dls_model shifted = {.n = A->n,
                             .operator_kind = DLS_STIFFNESS_SPARSE,
                             .factorization = symmetric ? DLS_LDLT : DLS_LU,
                             .Ks = {A->n, A->n, A->p, A->i, A->x}};
  dlsi_factor *factor;
  dls_status status = dlsi_factor_create(&factor, &shifted, 0, NULL, error);
  if (!status) status = dlsi_factor_numeric(factor, &shifted, error);
  double *part = status ? NULL : dlsi_alloc(n, (size_t)count * sizeof *part);
  if (!status && !part) status = dlsi_no_memory(error);
  for (int turn = 0; !status && turn < times; turn++) {
    orthonormalise(V, n, count);
    for (int k = 0; !status && k < factor->parts; k++) {
      const size_t first = (size_t)factor->first[k], s = (size_t)factor->first[k + 1] - first;
      for (size_t e = 0; e < s * (size_t)count; e++)
        part[e] = V[(size_t)factor->unknown[first + e % s] + e / s * n];
      status = dlsi_factor_solve(factor, k, part, count, NULL, error);
      for (size_t e = 0; e < s * (size_t)count; e++)
        V[(size_t)factor->unknown[first + e % s] + e / s * n] = part[e];
    }
  }
  if (!status) orthonormalise(V, n, count);
  free(part);
  dlsi_factor_destroy(factor);
  for (size_t j = 0; j < n; j++)
    A->x[A->p[j]] = 0;
  return status;
}

/* (N4): the null vectors come to the front of V, *found is their number. T (n x count): room */
static dls_status split(const scaled *A, double *V, int count, double *T, int *found,
                        dls_error *error) {
  const int n = A->n, ask = -1;
  double s[block], Y[block * block], best, unused;
  int info;
  multiply(A, V, count, T);
  dgesvd_("N", "A", &n, &count, T, &n, s, &unused, &n, Y, &count, &best, &ask, &info, 1, 1);
  const int size = (int)best;
  double *work = dlsi_alloc((size_t)size, sizeof *work);
  if (!work) return dlsi_no_memory(error);
  dgesvd_("N", "A", &n, &count, T, &n, s, &unused, &n, Y, &count, work, &size, &info, 1, 1);
  free(work);
  *found = 0;
  while (info == 0 && *found < count && s[count - 1 - *found] <= 50 * DBL_EPSILON * A->norm)
    ++*found;
  if (*found == 0) return DLS_OK;
  const double one = 1, zero = 0; /* the last rows of Y^T are the null vectors */
  dgemm_("N", "T", &n, found, &count, &one, V, &n, Y + count - *found, &count, &zero, T, &n, 1, 1);
  memcpy(V, T, (size_t)n * (size_t)*found * sizeof *V);
  return DLS_OK;
}

/* (N5) but for C; unknown (count). 0 if the columns are not independent. */
static int reduce(double *V, size_t n, int count, int *unknown) {
  for (int k = 0; k < count; k++) {
    size_t pivot = 0; /* over all entries of the columns that are left */
    const size_t first = (size_t)k * n, end = (size_t)count * n;
    double largest = 0;
    for (size_t e = first; e < end; e++)
      if (fabs(V[e]) > largest) {
        largest = fabs(V[e]);
        pivot = e;
      }
    if (!(largest > 1e-8 * dlsi_max_abs(V, first > 0 ? first : end))) return 0;
    const size_t row = pivot % n;
    double *v = V + first, *w = V + pivot / n * n;
    const double scale = w[row];
    for (size_t i = 0; i < n; i++) {
      const double old = v[i];
      v[i] = w[i] / scale;
      if (w != v) w[i] = old;
    }
    unknown[k] = (int)row;
    for (int c = 0; c < count; c++) {
      double *u = V + (size_t)c * n;
      const double s = u[row];
      for (size_t i = 0; c != k && i < n; i++)
        u[i] -= s * v[i];
      u[row] = c == k;
    }
  }
  return 1;
}

/* v := C v / C_unknown */
static void unscale(const scaled *A, dlsi_modes *modes) {
  const size_t n = (size_t)A->n;
  for (int c = 0; c < modes->count; c++)
    for (size_t i = 0; i < n; i++)
      modes->basis[i + (size_t)c * n] *= A->C[i] / A->C[modes->unknown[c]];
}

/* ---- find, given, free ----------------------------------------------------------------------- */

/* (N3) to (N5) from a start that is the same each time; V (n x 2 count) */
static dls_status search(scaled *A, int symmetric, double *V, int count, dlsi_modes *modes,
                         dls_error *error) {
  const size_t n = (size_t)A->n, entries = n * (size_t)count;
  unsigned long long seed = 1;
  for (size_t e = 0; e < entries; e++) {
    seed = seed * 6364136223846793005u + 1442695040888963407u;
    V[e] = (double)(seed >> 11) / 4503599627370496.0 - 1;
  }
  int found = 0;
  dls_status status = iterate(A, symmetric, V, count, error);
  if (!status) status = split(A, V, count, V + entries, &found, error);
  if (status) return status;
  if (found > dlsi_most_modes) found = dlsi_most_modes;
  if (!reduce(V, n, found, modes->unknown)) return DLS_OK;
  modes->count = found;
  unscale(A, modes);
  return DLS_OK;
}

dls_status dlsi_modes_find(const dls_model *model, dlsi_modes *modes, dls_error *error) {
  const int count = model->n < block ? model->n : block;
  *modes = (dlsi_modes){0};
  modes->basis = dlsi_alloc(2 * (size_t)model->n, (size_t)count * sizeof *modes->basis);
  modes->unknown = dlsi_alloc((size_t)count, sizeof *modes->unknown);
  if (!modes->basis || !modes->unknown) return dlsi_no_memory(error);
  scaled A;
  dls_status status = make_scaled(&A, model, error);
  if (!status)
    status = search(&A, model->factorization != DLS_LU, modes->basis, count, modes, error);
  free_scaled(&A);
  return status;
}

/* modes := B, checked and reduced; V (n x 2 columns) is their basis */
static dls_status take_given(const scaled *A, const dls_dense *B, double *V, dlsi_modes *modes,
                             dls_error *error) {
  const size_t n = (size_t)A->n;
  double *AV = V + n * (size_t)B->cols;
  for (int c = 0; c < B->cols; c++)
    for (size_t i = 0; i < n; i++)
      V[i + (size_t)c * n] = B->a[i + (size_t)c * (size_t)B->ld] / A->C[i];
  multiply(A, V, B->cols, AV);
  for (int c = 0; c < B->cols; c++) {
    const size_t at = (size_t)c * n;
    const double left = dlsi_max_abs(AV + at, n), size = A->norm * dlsi_max_abs(V + at, n);
    if (!(left <= 1e-8 * size))
      return dlsi_fail(error, DLS_E_ARGUMENT, "modes", c, left / size,
                       "column %d is no null vector of K: |K x| = %.3g |K||x|", c, left / size);
  }
  if (!reduce(V, n, B->cols, modes->unknown))
    return dlsi_fail(error, DLS_E_ARGUMENT, "modes", -1, 0, "the columns are not independent");
  modes->count = B->cols;
  unscale(A, modes);
  return DLS_OK;
}

dls_status dlsi_modes_given(const dls_model *model, dlsi_modes *modes, dls_error *error) {
  const size_t columns = (size_t)model->modes.cols;
  *modes = (dlsi_modes){0};
  modes->basis = dlsi_alloc(2 * (size_t)model->n, columns * sizeof *modes->basis);
  modes->unknown = dlsi_alloc(columns, sizeof *modes->unknown);
  if (!modes->basis || !modes->unknown) return dlsi_no_memory(error);
  scaled A;
  dls_status status = make_scaled(&A, model, error);
  if (!status) status = take_given(&A, &model->modes, modes->basis, modes, error);
  free_scaled(&A);
  return status;
}

void dlsi_modes_free(dlsi_modes *modes) {
  free(modes->basis);
  free(modes->unknown);
  *modes = (dlsi_modes){0};
}

dls_status dls_model_modes(const dls_model *model, int most, double *basis, int *unknown,
                           int *count, dls_error *error) {
  const dls_status bad = dlsi_check_model(model, error);
  if (bad) return dlsi_at(__func__, bad, error);
  if (most < 0)
    return dlsi_at(__func__, dlsi_fail(error, DLS_E_SIZE, "most", -1, most, "is negative"), error);
  if (!count) return dlsi_at(__func__, dlsi_is_null(error, "count"), error);
  if (model->operator_kind != DLS_STIFFNESS_DENSE && model->operator_kind != DLS_STIFFNESS_SPARSE)
    return dlsi_at(__func__,
                   dlsi_fail(error, DLS_E_UNSUPPORTED, "operator_kind", -1, model->operator_kind,
                             "this operator has an inverse"),
                   error);
  dlsi_modes modes;
  const dls_status status = dlsi_modes_find(model, &modes, error);
  const size_t n = (size_t)(status ? 0 : model->n);
  for (int c = 0; !status && c < modes.count && c < most; c++) {
    if (basis) memcpy(basis + (size_t)c * n, modes.basis + (size_t)c * n, n * sizeof *basis);
    if (unknown) unknown[c] = modes.unknown[c];
  }
  if (!status) *count = modes.count;
  dlsi_modes_free(&modes);
  return dlsi_at(__func__, status, error);
}

/* ---- springs --------------------------------------------------------------------------------- */

/* spring_k := soft K_jj, of the largest |K_ij| if that is not positive, soft if there is none */
static void choose_springs(const dls_model *model, const dlsi_modes *modes, double *spring) {
  for (int k = 0; k < modes->count; k++) {
    const int j = modes->unknown[k];
    double diagonal = 0, largest = 0, v;
    int i;
    for (size_t at = 0; entry_of(model, j, at, &i, &v); at++) {
      if (i == j) diagonal += v;
      if (fabs(v) > largest) largest = fabs(v);
    }
    spring[k] = soft * (diagonal > 0 ? diagonal : largest > 0 ? largest : 1);
  }
}

static dls_status dense_with_springs(dlsi_stable *stable, const dlsi_modes *modes,
                                     const double *spring, dls_error *error) {
  dls_dense *K = &stable->model.K;
  const size_t n = (size_t)K->rows;
  stable->x = dlsi_alloc(n, n * sizeof *stable->x);
  if (!stable->x) return dlsi_no_memory(error);
  for (size_t j = 0; j < n; j++)
    memcpy(stable->x + j * n, K->a + j * (size_t)K->ld, n * sizeof *stable->x);
  for (int k = 0; k < modes->count; k++)
    stable->x[(size_t)modes->unknown[k] * (n + 1)] += spring[k];
  *K = (dls_dense){K->rows, K->cols, K->rows, stable->x};
  return DLS_OK;
}

static dls_status sparse_with_springs(dlsi_stable *stable, const dlsi_modes *modes,
                                      const double *spring, dls_error *error) {
  dls_sparse *Ks = &stable->model.Ks;
  const int n = Ks->cols;
  const size_t entries = (size_t)Ks->p[n] + (size_t)modes->count;
  if (entries > INT32_MAX)
    return dlsi_fail(error, DLS_E_SIZE, "Ks", -1, (double)entries, "too many entries");
  stable->p = dlsi_alloc((size_t)n + 1, sizeof *stable->p);
  stable->i = dlsi_alloc(entries, sizeof *stable->i);
  stable->x = dlsi_alloc(entries, sizeof *stable->x);
  if (!stable->p || !stable->i || !stable->x) return dlsi_no_memory(error);
  int to = 0;
  for (int j = 0; j < n; j++) {
    stable->p[j] = to;
    for (int k = 0; k < modes->count; k++)
      if (modes->unknown[k] == j) {
        stable->i[to] = j;
        stable->x[to++] = spring[k];
      }
    for (int k = Ks->p[j]; k < Ks->p[j + 1]; k++) {
      stable->i[to] = Ks->i[k];
      stable->x[to++] = Ks->x[k];
    }
  }
  stable->p[n] = to;
  *Ks = (dls_sparse){n, n, stable->p, stable->i, stable->x};
  return DLS_OK;
}

dls_status dlsi_stable_create(dlsi_stable *stable, const dls_model *model, const dlsi_modes *modes,
                              double *spring, dls_error *error) {
  *stable = (dlsi_stable){.model = *model};
  if (modes->count == 0) return DLS_OK;
  choose_springs(model, modes, spring);
  return model->operator_kind == DLS_STIFFNESS_DENSE
             ? dense_with_springs(stable, modes, spring, error)
             : sparse_with_springs(stable, modes, spring, error);
}

void dlsi_stable_free(dlsi_stable *stable) {
  free(stable->p);
  free(stable->i);
  free(stable->x);
}
