/*
 * modes.c: the null space of a singular K, and springs that hold it.
 *
 *   (MO1)  A = R K C, scaled (equilibrate.c); R = C if K is symmetric
 *   (MO2)  factor A + sqrt(eps) 1
 *   (MO3)  V := orth((A + sqrt(eps) 1)^-1 V), a block of up to 28 vectors, a few times
 *   (MO4)  A V = U s Y^T; the columns of V Y with s <= 50 eps |A|_1 are null vectors
 *   (MO5)  reduce them to echelon form: a 1 in unknown[k] of mode k, where the others are 0; then
 *          x = C v. unknown[k]: the row of largest norm among those of the null vectors that vanish
 *          in unknown[0..k-1] (QR of V^T with pivoting; Golub and Van Loan, Matrix Computations,
 *          5.4.2); the first of equal rows. The norm of a row depends only on the null space. An
 *          entry of V depends on the basis, which rounding chooses
 *   (MO6)  after each turn of dls_reduction_balance move the feet of the springs by Broyden's
 *          method (Math. Comp. 19, 1965, 577-593, the first one) to where nothing stretches them
 *
 * Each (MO3) multiplies what is not in the null space by sqrt(eps) / s. In echelon form the modes
 * of a body have their 1 and their zeros on that body, so that they vanish on others.
 *
 * Cost: one factorisation, 28 solves per turn of (MO3). Fails: no memory, over INT_MAX entries.
 */
#include <float.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "linear/blas.h"
#include "linear/equilibrate.h"
#include "linear/pieces.h"
#include "linear/redundant.h"
#include "reduction_internal.h"

/* The stiffness of a spring over K_jj. 0.01 and 1 take as many turns of (MO6). Softer springs cost
 * W digits: as many as they are softer than K. With stiffer springs the loads of the first turn are
 * far from balance. */
static const double soft = 0.1;

/* Rows of null vectors are equally large if their squared norms differ by less. Null vectors are
 * good to about 1e-10. */
static const double alike = 1e-6;

enum { block = dlsi_most_modes + 4, times = 5 };

/* ---- A --------------------------------------------------------------------------------------- */

typedef struct scaled {
  int n, symmetric;
  dlsi_columns
      K;         /* A, all entries of both triangles; each column begins with a 0 on the diagonal */
  double *R, *C; /* n; of one piece */
  double norm;   /* |A|_1 */
} scaled;

static void scaled_free(scaled *A) {
  dlsi_columns_free(&A->K);
  free(A->R);
}

/* Finds entry `at` of column j of the model's K, dense or sparse; returns 0 past the last. */
static int modes_entry(const dls_model *model, int j, int at, int *row, double *value) {
  if (model->operator_kind == DLS_STIFFNESS_DENSE) {
    if (at >= model->n) return 0;
    *row = at;
    *value = model->K.a[(size_t)at + (size_t)j * (size_t)model->K.ld];
    return 1;
  }
  const dls_sparse *Ks = &model->Ks;
  if (at >= Ks->p[j + 1] - Ks->p[j]) return 0;
  *row = Ks->i[Ks->p[j] + at];
  *value = Ks->x[Ks->p[j] + at];
  return 1;
}

/* Copies K to A->K, with the upper triangle of a symmetric K and a place for the shift. */
static dls_status scaled_copy(scaled *A, const dls_model *model, dls_error *error) {
  const size_t n = (size_t)A->n;
  const size_t entries =
      model->operator_kind == DLS_STIFFNESS_DENSE ? n * n : (size_t)model->Ks.p[n];
  dlsi_triplets t;
  dls_status status = dlsi_triplets_alloc(A->n, A->n, 2 * entries + n, &t, error);
  for (int j = 0; !status && j < A->n; j++)
    dlsi_triplets_add(&t, j, j, 0);
  for (int j = 0, i; !status && j < A->n; j++) {
    double v;
    for (int at = 0; modes_entry(model, j, at, &i, &v); at++) {
      if (A->symmetric && i < j) continue;
      dlsi_triplets_add(&t, i, j, v);
      if (A->symmetric && i > j) dlsi_triplets_add(&t, j, i, v);
    }
  }
  if (!status) status = dlsi_columns_compress(&t, 1, DLSI_ALL, &A->K, error);
  dlsi_triplets_free(&t);
  return status;
}

/* (MO1) The caller calls scaled_free, also after an error. */
static dls_status scaled_create(scaled *A, const dls_model *model, dls_error *error) {
  const size_t n = (size_t)model->n;
  *A = (scaled){.n = model->n, .symmetric = model->factorization != DLS_LU};
  A->R = dlsi_alloc(4 * n, sizeof *A->R);
  if (!A->R) return dlsi_no_memory(error);
  const dls_status status = scaled_copy(A, model, error);
  if (status) return status;
  A->C = A->R + n;
  double *sums = A->C + n;
  const dls_sparse K = dlsi_columns_view(&A->K);
  dlsi_find_scales(&K, A->symmetric, A->R, A->C, sums);
  for (int j = 0; j < A->n; j++) {
    sums[j] = 0;
    for (int k = K.p[j]; k < K.p[j + 1]; k++) {
      A->K.x[k] *= A->R[K.i[k]] * A->C[j];
      sums[j] += fabs(K.x[k]);
    }
  }
  A->norm = dlsi_max_abs(sums, n);
  return DLS_OK;
}

/* Computes Y := A V. V, Y: n x count. */
static void scaled_multiply(const scaled *A, const double *V, int count, double *Y) {
  const size_t n = (size_t)A->n;
  memset(Y, 0, n * (size_t)count * sizeof *Y);
  for (int c = 0; c < count; c++, V += n, Y += n)
    for (int j = 0; j < A->n; j++)
      for (int k = A->K.p[j]; k < A->K.p[j + 1]; k++)
        Y[A->K.i[k]] += A->K.x[k] * V[j];
}

/* ---- the block ------------------------------------------------------------------------------- */

/* Runs modified Gram-Schmidt twice: the first turn may leave only rounding in a column. */
static void modes_orthonormalise(double *V, size_t n, int count) {
  for (int c = 0; c < count; c++) {
    double *v = V + (size_t)c * n;
    for (int turn = 0; turn < 3; turn++) {
      const double length = dlsi_norm2(v, n);
      for (size_t i = 0; length > 0 && i < n; i++)
        v[i] /= length;
      for (int k = 0; turn < 2 && k < c; k++) {
        const double *w = V + (size_t)k * n;
        double s = 0;
        for (size_t i = 0; i < n; i++)
          s += v[i] * w[i];
        for (size_t i = 0; i < n; i++)
          v[i] -= s * w[i];
      }
    }
  }
}

/* (MO2), (MO3) V: n x count. */
static dls_status modes_iterate(scaled *A, double *V, int count, dls_error *error) {
  const size_t n = (size_t)A->n;
  for (size_t j = 0; j < n; j++)
    A->K.x[A->K.p[j]] = sqrt(DBL_EPSILON);
  const dls_model shifted = {.n = A->n,
                             .operator_kind = DLS_STIFFNESS_SPARSE,
                             .factorization = A->symmetric ? DLS_LDLT : DLS_LU,
                             .Ks = dlsi_columns_view(&A->K)};
  dlsi_factor *factor;
  dls_status status = dlsi_factor_create(&factor, &shifted, 0, NULL, error);
  if (!status) status = dlsi_factor_numeric(factor, &shifted, error);
  double *part = status ? NULL : dlsi_alloc(n, (size_t)count * sizeof *part);
  if (!status && !part) status = dlsi_no_memory(error);
  for (int turn = 0; !status && turn < times; turn++) {
    modes_orthonormalise(V, n, count);
    for (int k = 0; !status && k < factor->parts; k++) {
      const size_t first = (size_t)factor->first[k], s = (size_t)factor->first[k + 1] - first;
      for (size_t e = 0; e < s * (size_t)count; e++)
        part[e] = V[(size_t)factor->unknown[first + e % s] + e / s * n];
      status = dlsi_factor_solve(factor, k, part, count, NULL, error);
      for (size_t e = 0; e < s * (size_t)count; e++)
        V[(size_t)factor->unknown[first + e % s] + e / s * n] = part[e];
    }
  }
  if (!status) modes_orthonormalise(V, n, count);
  free(part);
  dlsi_factor_destroy(factor);
  for (size_t j = 0; j < n; j++)
    A->K.x[A->K.p[j]] = 0;
  return status;
}

/* (MO4) Moves the null vectors to the front of V; *found: their number. T: scratch, n x count. */
static dls_status modes_split(const scaled *A, double *V, int count, double *T, int *found,
                              dls_error *error) {
  const int n = A->n, ask = -1;
  double s[block], Y[block * block], best, unused;
  int info;
  scaled_multiply(A, V, count, T);
  *found = 0;
  if (dlsi_first_not_finite(T, (size_t)n * (size_t)count) >= 0) return DLS_OK;
  dgesvd_("N", "A", &n, &count, T, &n, s, &unused, &n, Y, &count, &best, &ask, &info, 1, 1);
  const int size = (int)best;
  double *work = dlsi_alloc((size_t)size, sizeof *work);
  if (!work) return dlsi_no_memory(error);
  dgesvd_("N", "A", &n, &count, T, &n, s, &unused, &n, Y, &count, work, &size, &info, 1, 1);
  free(work);
  while (info == 0 && *found < count && s[count - 1 - *found] <= 50 * DBL_EPSILON * A->norm)
    ++*found;
  if (*found == 0) return DLS_OK;
  /* the last rows of Y^T are the null vectors */
  dlsi_gemm(dlsi_is_small((size_t)n * (size_t)count), 'N', 'T', n, *found, count, 1, V, n,
            Y + count - *found, count, 0, T, n);
  memcpy(V, T, (size_t)n * (size_t)*found * sizeof *V);
  return DLS_OK;
}

/* Returns the square of the norm of row i of V (n x count). */
static double modes_row(const double *V, size_t n, int count, size_t i) {
  double sum = 0;
  for (size_t c = 0; c < (size_t)count; c++)
    sum += V[i + c * n] * V[i + c * n];
  return sum;
}

/* Returns the first row of V (n x count) whose norm is the largest up to rounding; *size: the
 * square of the largest. */
static size_t modes_largest_row(const double *V, size_t n, int count, double *size) {
  *size = 0;
  for (size_t i = 0; i < n; i++)
    *size = fmax(*size, modes_row(V, n, count, i));
  size_t first = 0;
  while (first < n - 1 && modes_row(V, n, count, first) < (1 - alike) * *size)
    first++;
  return first;
}

/* Reflects the columns of V (n x count) so that row `row` is 0 but in the first column. */
static void modes_reflect(double *V, size_t n, int count, size_t row) {
  double w[dlsi_most_modes];
  const size_t columns = (size_t)count;
  const double size = modes_row(V, n, count, row), length = sqrt(size);
  for (size_t c = 0; c < columns; c++)
    w[c] = V[row + c * n];
  const double pivot = -copysign(length, w[0]), half = size + fabs(w[0]) * length; /* |w|^2 / 2 */
  w[0] -= pivot;
  for (size_t i = 0; i < n; i++) {
    double sum = 0;
    for (size_t c = 0; c < columns; c++)
      sum += V[i + c * n] * w[c];
    for (size_t c = 0; c < columns; c++)
      V[i + c * n] -= sum / half * w[c];
  }
  for (size_t c = 0; c < columns; c++)
    V[row + c * n] = c == 0 ? pivot : 0;
}

/* (MO5) Returns 0 if the columns of V (n x count) are not independent. unknown: count. */
static int modes_reduce(const scaled *A, double *V, int count, int *unknown) {
  const size_t n = (size_t)A->n;
  double largest = 0;
  for (int k = 0; k < count; k++) { /* V := V Q, lower triangular in the rows chosen */
    double *rest = V + (size_t)k * n, size;
    const size_t row = modes_largest_row(rest, n, count - k, &size);
    if (k == 0) largest = size;
    if (!(size > 1e-16 * largest)) return 0;
    modes_reflect(rest, n, count - k, row);
    unknown[k] = (int)row;
  }
  for (int k = 0; k < count; k++) { /* 1 in these rows */
    const size_t row = (size_t)unknown[k];
    double *v = V + (size_t)k * n;
    const double scale = v[row];
    for (size_t i = 0; i < n; i++)
      v[i] /= scale;
    for (int c = 0; c <= k; c++) {
      double *u = V + (size_t)c * n;
      const double s = u[row];
      for (size_t i = 0; c < k && i < n; i++)
        u[i] -= s * v[i];
      u[row] = c == k;
    }
  }
  for (int c = 0; c < count; c++)
    for (size_t i = 0; i < n; i++)
      V[i + (size_t)c * n] *= A->C[i] / A->C[unknown[c]];
  return 1;
}

/* ---- find, given, free ----------------------------------------------------------------------- */

/* (MO3) to (MO5) Starts from equal vectors each time. V: n x 2 count. */
static dls_status modes_find(scaled *A, double *V, int count, dlsi_modes *modes, dls_error *error) {
  const size_t entries = (size_t)A->n * (size_t)count;
  unsigned long long seed = 1;
  for (size_t e = 0; e < entries; e++) {
    seed = seed * 6364136223846793005u + 1442695040888963407u;
    V[e] = (double)(seed >> 11) / 4503599627370496.0 - 1;
  }
  int found = 0;
  dls_status status = modes_iterate(A, V, count, error);
  if (!status) status = modes_split(A, V, count, V + entries, &found, error);
  if (status) return status;
  if (found > dlsi_most_modes) found = dlsi_most_modes;
  if (modes_reduce(A, V, found, modes->unknown)) modes->count = found;
  return DLS_OK;
}

/* Takes the basis B, after checks. Its columns may have any length and unit. V: n x 2 columns. */
static dls_status modes_take(const scaled *A, const dls_dense *B, double *V, dlsi_modes *modes,
                             dls_error *error) {
  const size_t n = (size_t)A->n;
  double *AV = V + n * (size_t)B->cols;
  for (int c = 0; c < B->cols; c++)
    for (size_t i = 0; i < n; i++)
      V[i + (size_t)c * n] = B->a[i + (size_t)c * (size_t)B->ld] / A->C[i];
  scaled_multiply(A, V, B->cols, AV);
  for (int c = 0; c < B->cols; c++) {
    const size_t at = (size_t)c * n;
    const double left = dlsi_max_abs(AV + at, n), size = A->norm * dlsi_max_abs(V + at, n);
    if (!(left <= 1e-8 * size))
      return dlsi_fail(error, DLS_E_ARGUMENT, "modes", c, left / size,
                       "column %d is no null vector of K: |K x| = %.3g |K||x|", c, left / size);
  }
  for (int c = 0; c < B->cols; c++) {
    const double length = dlsi_norm2(V + (size_t)c * n, n);
    for (size_t i = 0; i < n && length > 0; i++)
      V[i + (size_t)c * n] /= length;
  }
  memcpy(AV, V, n * (size_t)B->cols * sizeof *AV);
  if (!modes_reduce(A, AV, B->cols, modes->unknown))
    return dlsi_fail(error, DLS_E_ARGUMENT, "modes", -1, 0, "the columns are not independent");
  modes_orthonormalise(V, n, B->cols);
  if (modes_reduce(A, V, B->cols, modes->unknown)) modes->count = B->cols;
  return DLS_OK;
}

dls_status dlsi_modes_create(dlsi_modes *modes, const dls_model *model, dls_dense given,
                             dls_error *error) {
  const int count = given.a ? given.cols : model->n < block ? model->n : block;
  *modes = (dlsi_modes){0};
  modes->basis = dlsi_alloc(2 * (size_t)model->n, (size_t)count * sizeof *modes->basis);
  modes->unknown = dlsi_alloc((size_t)count, sizeof *modes->unknown);
  if (!modes->basis || !modes->unknown) return dlsi_no_memory(error);
  scaled A;
  dls_status status = scaled_create(&A, model, error);
  if (!status)
    status = given.a ? modes_take(&A, &given, modes->basis, modes, error)
                     : modes_find(&A, modes->basis, count, modes, error);
  scaled_free(&A);
  return status;
}

void dlsi_modes_free(dlsi_modes *modes) {
  free(modes->basis);
  free(modes->unknown);
  *modes = (dlsi_modes){0};
}

static dls_status modes_of_model(const dls_model *model, int most, double *basis, int *unknown,
                                 int *count, dls_error *error) {
  dls_status status = dlsi_check_model(model, error);
  if (status) return status;
  if (most < 0) return dlsi_fail(error, DLS_E_SIZE, "most", -1, most, "is %d, negative", most);
  if (!count) return dlsi_is_null(error, "count");
  if (model->operator_kind != DLS_STIFFNESS_DENSE && model->operator_kind != DLS_STIFFNESS_SPARSE)
    return dlsi_fail(error, DLS_E_UNSUPPORTED, "operator_kind", -1, model->operator_kind,
                     "this operator has an inverse");
  dlsi_apart apart;
  dlsi_modes modes = {0};
  status = dlsi_apart_create(&apart, model, NULL, error);
  if (!status) status = dlsi_modes_create(&modes, &apart.model, (dls_dense){0}, error);
  dlsi_apart_free(&apart);
  const size_t n = (size_t)model->n;
  for (int c = 0; !status && c < modes.count && c < most; c++) {
    if (basis) memcpy(basis + (size_t)c * n, modes.basis + (size_t)c * n, n * sizeof *basis);
    if (unknown) unknown[c] = modes.unknown[c];
  }
  if (!status) *count = modes.count;
  dlsi_modes_free(&modes);
  return status;
}

dls_status dls_model_modes(const dls_model *model, int most, double *basis, int *unknown,
                           int *count, dls_error *error) {
  DLSI_DOOR;
  return dlsi_at(__func__, modes_of_model(model, most, basis, unknown, count, error), error);
}

/* ---- feet ------------------------------------------------------------------------------------ */

/* Returns a^T diag(spring) b. */
static double follow_product(int count, const double *spring, const double *a, const double *b) {
  double sum = 0;
  for (int k = 0; k < count; k++)
    sum += spring[k] * a[k] * b[k];
  return sum;
}

/* (MO6) After a move d that changed the stretch by e: M := M - (d + M e)(d^T S M) / (d^T S M e). If
 * the stretch has not shrunk, M := 1: the step of the proximal point method. */
static void follow_learn(dlsi_follow *follow, int count, const double *spring,
                         const double *stretch) {
  const size_t n = (size_t)count;
  double e[dlsi_most_modes], Me[dlsi_most_modes] = {0}, dM[dlsi_most_modes] = {0};
  const double *d = follow->move, *old = follow->stretch;
  if (follow_product(count, spring, stretch, stretch) >= follow_product(count, spring, old, old)) {
    follow->learnt = 0;
    return;
  }
  for (size_t k = 0; k < n; k++)
    e[k] = stretch[k] - old[k];
  for (size_t j = 0; j < n; j++)
    for (size_t i = 0; i < n; i++) {
      Me[i] += follow->M[i + j * n] * e[j];
      dM[j] += spring[i] * d[i] * follow->M[i + j * n];
    }
  const double size = follow_product(count, spring, d, d),
               slope = follow_product(count, spring, d, Me);
  if (!(slope < -1e-6 * size)) return; /* no spring feels this move */
  for (size_t j = 0; j < n; j++)
    for (size_t i = 0; i < n; i++)
      follow->M[i + j * n] -= (d[i] + Me[i]) * dM[j] / slope;
  follow->learnt = 1;
}

void dlsi_follow_step(dlsi_follow *follow, int count, const double *spring, const double *stretch,
                      double *move) {
  const size_t n = (size_t)count;
  if (follow->turned) follow_learn(follow, count, spring, stretch);
  if (!follow->learnt)
    for (size_t e = 0; e < n * n; e++)
      follow->M[e] = e % (n + 1) == 0;
  for (size_t i = 0; i < n; i++)
    move[i] = 0;
  for (size_t j = 0; j < n; j++)
    for (size_t i = 0; i < n; i++)
      move[i] += follow->M[i + j * n] * stretch[j];
  memcpy(follow->stretch, stretch, n * sizeof *move);
  memcpy(follow->move, move, n * sizeof *move);
  follow->turned = 1;
}

/* ---- springs --------------------------------------------------------------------------------- */

/* Chooses spring_k := soft K_jj, or soft times the largest |K_ij|, or soft in an empty column. */
static void spring_choose(const dls_model *model, const dlsi_modes *modes, double *spring) {
  for (int k = 0; k < modes->count; k++) {
    const int j = modes->unknown[k];
    double diagonal = 0, largest = 0, v;
    for (int at = 0, i; modes_entry(model, j, at, &i, &v); at++) {
      if (i == j) diagonal += v;
      if (fabs(v) > largest) largest = fabs(v);
    }
    spring[k] = soft * (diagonal > 0 ? diagonal : largest > 0 ? largest : 1);
  }
}

static dls_status spring_add_dense(dlsi_stable *stable, const dlsi_modes *modes,
                                   const double *spring, dls_error *error) {
  dls_dense *K = &stable->model.K;
  const size_t n = (size_t)K->rows;
  double *x = stable->K.x = dlsi_alloc(n, n * sizeof *x);
  if (!x) return dlsi_no_memory(error);
  for (size_t j = 0; j < n; j++)
    memcpy(x + j * n, K->a + j * (size_t)K->ld, n * sizeof *x);
  for (int k = 0; k < modes->count; k++)
    x[(size_t)modes->unknown[k] * (n + 1)] += spring[k];
  *K = (dls_dense){K->rows, K->cols, K->rows, x};
  return DLS_OK;
}

static dls_status spring_add_sparse(dlsi_stable *stable, const dlsi_modes *modes,
                                    const double *spring, dls_error *error) {
  dls_sparse *Ks = &stable->model.Ks;
  const size_t entries = (size_t)Ks->p[Ks->cols] + (size_t)modes->count;
  dlsi_triplets t;
  dls_status status = dlsi_triplets_alloc(Ks->rows, Ks->cols, entries, &t, error);
  for (int k = 0; !status && k < modes->count; k++)
    dlsi_triplets_add(&t, modes->unknown[k], modes->unknown[k], spring[k]);
  for (int j = 0; !status && j < Ks->cols; j++)
    for (int e = Ks->p[j]; e < Ks->p[j + 1]; e++)
      dlsi_triplets_add(&t, Ks->i[e], j, Ks->x[e]);
  if (!status) status = dlsi_columns_compress(&t, 1, DLSI_ALL, &stable->K, error);
  dlsi_triplets_free(&t);
  if (!status) *Ks = dlsi_columns_view(&stable->K);
  return status;
}

dls_status dlsi_stable_create(dlsi_stable *stable, const dls_model *model, const dlsi_modes *modes,
                              double *spring, dls_error *error) {
  *stable = (dlsi_stable){.model = *model};
  if (modes->count == 0) return DLS_OK;
  spring_choose(model, modes, spring);
  return model->operator_kind == DLS_STIFFNESS_DENSE
             ? spring_add_dense(stable, modes, spring, error)
             : spring_add_sparse(stable, modes, spring, error);
}

void dlsi_stable_free(dlsi_stable *stable) {
  dlsi_columns_free(&stable->K);
}
