/*
 * system.c: A = K + rho H H^T + E, factored for several rho after one analysis.
 *
 *   A is positive definite if K is semidefinite and each motion that K leaves free moves some
 *   contact: bodies that only contact holds need no springs. Supernodal Cholesky.
 *   E = hold diag(|K_jj|), hold = 0 or 1e-8, is for the other motions: a proximal term, with
 *   E x_old on the right side. It hardly changes elastic motions.
 *   LU if K is not symmetric or has multipliers, or A is not definite even with E. E is 0 at
 *   multipliers: redundant joints are not in K (linear/redundant.c).
 *
 * A pivot below 1e-13 of its diagonal entry counts as rounding. The order is METIS's; without it
 * the order of the unknowns.
 * Cost: a factorisation for each rho. Fails: singular with E, no memory.
 */
#include <limits.h>
#include <stdlib.h>
#include <string.h>

#include "linear/dissection.h"
#include "linear/system.h"

static const double soft = 1e-8;
static const double rounding = 1e-13;

/* Adds up the entries of column j that count into sum (n, 0 elsewhere), and lists their rows.
 * mark: n, j where a row is listed. Returns their number. */
static int column_gather(const dls_model *model, int j, double *sum, int *mark, int *rows) {
  const int lower = model->factorization != DLS_LU;
  const int dense = model->operator_kind == DLS_STIFFNESS_DENSE;
  const int from = dense ? 0 : model->Ks.p[j], end = dense ? model->n : model->Ks.p[j + 1];
  int count = 0;
  for (int k = from; k < end; k++) {
    const int i = dense ? k : model->Ks.i[k];
    if (lower && i < j) continue;
    const double v =
        dense ? model->K.a[(size_t)k + (size_t)j * (size_t)model->K.ld] : model->Ks.x[k];
    if (dense && v == 0) continue;
    if (mark[i] != j) {
      mark[i] = j;
      sum[i] = 0;
      rows[count++] = i;
    }
    sum[i] += v;
  }
  return count;
}

dls_status dlsi_stiffness_columns(const dls_model *model, dlsi_columns *out, dls_error *error) {
  const size_t n = (size_t)model->n;
  *out = (dlsi_columns){0};
  double *sum = dlsi_alloc(n, sizeof *sum);
  int *mark = dlsi_alloc(2 * n, sizeof *mark), *rows = mark ? mark + n : NULL;
  dls_status status = sum && mark ? DLS_OK : dlsi_no_memory(error);
  for (int turn = 0; !status && turn < 2; turn++) {
    size_t entries = 0;
    for (size_t k = 0; k < n; k++)
      mark[k] = -1;
    for (int j = 0; !status && j < model->n; j++) {
      const int count = column_gather(model, j, sum, mark, rows);
      for (int k = 0; turn && k < count; k++) {
        const size_t at = entries + (size_t)k;
        out->i[at] = rows[k];
        out->x[at] = sum[rows[k]];
        if (!(fabs(sum[rows[k]]) <= DBL_MAX))
          status = dlsi_fail(error, DLS_E_NOT_FINITE, "Ks", j, sum[rows[k]],
                             "entries of one place in this column add up to %g", sum[rows[k]]);
      }
      if (turn) out->p[j] = (int)entries;
      entries += (size_t)count;
    }
    if (status) break;
    if (turn)
      out->p[n] = (int)entries;
    else if (entries > INT_MAX)
      status = dlsi_fail(error, DLS_E_SIZE, "K", -1, (double)entries, "too many entries");
    else
      status = dlsi_columns_alloc(model->n, model->n, (int)entries, out, error);
  }
  free(sum);
  free(mark);
  return status;
}

/* Lists the entries of H M H^T, M block diagonal, at rows, columns, values (NULL: only counts); if
 * `half`, of one triangle, upper or lower. M couples the tangents of a contact, d = 3. M is as in
 * dlsi_system_factor_weighted; NULL: 1. Returns their number. */
static size_t system_list(const dls_sparse *H, int d, int half, const double *M, int *row, int *col,
                          double *h) {
  size_t count = 0;
  for (int k = 0; k < H->cols; k++) { /* the entry a is of column k, b of column l */
    const int first = k % d ? k - k % d + 1 : k, last = k % d ? k - k % d + d : k + 1;
    const double *of = M ? M + 4 * (k / d) : NULL;
    for (int a = H->p[k]; a < H->p[k + 1]; a++)
      for (int l = half ? k : first; l < last; l++)
        for (int b = half && l == k ? a : H->p[l]; b < H->p[l + 1]; b++, count++) {
          if (row) {
            row[count] = H->i[a] + 1;
            col[count] = H->i[b] + 1;
          }
          if (!h) continue;
          const double m = of ? of[k == l ? k % d : 3] : k == l;
          h[count] = m * H->x[a] * H->x[b] * (half && a != b && H->i[a] == H->i[b] ? 2 : 1);
        }
  }
  return count;
}

void dlsi_system_update(dlsi_system *work, const dls_model *K, const dls_sparse *H,
                        const int *joint) {
  work->K = K->Ks.x;
  work->H = *H;
  (void)system_list(H, work->d, work->symmetric, NULL, NULL, NULL, work->h);
  memset(work->e, 0, (size_t)work->n * sizeof *work->e);
  for (size_t k = 0; k < work->of_K; k++)
    if (work->row[k] == work->col[k]) work->e[work->row[k] - 1] += fabs(work->K[k]);
  for (int j = 0; j < work->n; j++)
    work->size[j] = work->e[j];
  for (size_t k = 0; k < work->of_K; k++) { /* a body without stiffness has no diagonal entry */
    const int i = work->row[k] - 1, j = work->col[k] - 1;
    const double v = fabs(work->K[k]);
    if (work->size[i] == 0 && v > work->e[i]) work->e[i] = v;
    if (work->size[j] == 0 && v > work->e[j]) work->e[j] = v;
  }
  double most = dlsi_max_abs(work->e, (size_t)work->n);
  for (int j = 0; j < work->n; j++)
    if (work->e[j] == 0) work->e[j] = most > 0 ? most : 1;
  for (int j = 0; joint && j < work->n; j++)
    if (joint[j]) work->e[j] = 0;
  work->definite = work->symmetric && !joint;
  work->hold = 0;
}

dls_status dlsi_system_analyse(const dlsi_system *work, dlsi_cholesky **out, dls_error *error) {
  dls_error why = {0};
  *out = NULL;
  int *order = dlsi_alloc((size_t)work->n, sizeof *order);
  int *turn = dlsi_alloc((size_t)work->n, sizeof *turn);
  dls_status status = order && turn ? DLS_OK : dlsi_no_memory(error);
  if (!status) {
    status = dlsi_dissection(work->n, work->entries, work->row, work->col, order, &why);
    for (int k = 0; k < work->n; k++)
      turn[status ? k : order[k]] = k + 1;
    if (status == DLS_E_UNSUPPORTED)
      status = DLS_OK;
    else if (status && error)
      *error = why;
  }
  if (!status)
    status =
        dlsi_cholesky_create(out, work->n, work->entries, work->row, work->col, turn, 0, error);
  free(order);
  free(turn);
  return status;
}

dls_status dlsi_system_create(dlsi_system **out, const dls_model *K, const dls_sparse *H, int d,
                              const int *joint, dls_error *error) {
  *out = NULL;
  dlsi_system *work = calloc(1, sizeof *work);
  if (!work) return dlsi_no_memory(error);
  const size_t n = (size_t)K->n;
  work->n = K->n;
  work->d = d;
  work->symmetric = K->factorization != DLS_LU;
  work->of_K = (size_t)K->Ks.p[K->n];
  work->of_H = system_list(H, d, work->symmetric, NULL, NULL, NULL, NULL);
  work->entries = work->of_K + work->of_H + n;
  work->row = dlsi_alloc(work->entries, sizeof *work->row);
  work->col = dlsi_alloc(work->entries, sizeof *work->col);
  work->x = dlsi_alloc(work->entries, sizeof *work->x);
  work->h = dlsi_alloc(work->of_H, sizeof *work->h);
  work->e = dlsi_alloc(2 * n, sizeof *work->e);
  dls_status status = DLS_OK;
  if (work->entries > INT_MAX)
    status = dlsi_fail(error, DLS_E_SIZE, "model", -1, (double)work->entries, "too many entries");
  else if (!work->row || !work->col || !work->x || !work->h || !work->e)
    status = dlsi_no_memory(error);
  if (!status && work->e) {
    work->size = work->e + n;
    for (int j = 0; j < work->n; j++)
      for (int k = K->Ks.p[j]; k < K->Ks.p[j + 1]; k++) {
        work->row[k] = K->Ks.i[k] + 1;
        work->col[k] = j + 1;
      }
    (void)system_list(H, d, work->symmetric, NULL, work->row + work->of_K, work->col + work->of_K,
                      NULL);
    for (size_t k = 0; k < n; k++)
      work->row[work->of_K + work->of_H + k] = work->col[work->of_K + work->of_H + k] = (int)k + 1;
    dlsi_system_update(work, K, H, joint);
    if (work->symmetric) status = dlsi_system_analyse(work, &work->cholesky, error);
  }
  if (status)
    dlsi_system_destroy(work);
  else
    *out = work;
  return status;
}

/* x := the values of A, with M in place of rho if M is not NULL, without what H H^T adds between
 * two bodies if part is not NULL. */
static void system_values(dlsi_system *work, double rho, const double *M, const int *part) {
  memcpy(work->x, work->K, work->of_K * sizeof *work->x);
  if (M) (void)system_list(&work->H, work->d, work->symmetric, M, NULL, NULL, work->x + work->of_K);
  for (size_t k = 0; !M && k < work->of_H; k++)
    work->x[work->of_K + k] =
        part && part[work->row[work->of_K + k] - 1] != part[work->col[work->of_K + k] - 1]
            ? 0
            : rho * work->h[k];
  for (size_t k = 0; k < (size_t)work->n; k++)
    work->x[work->of_K + work->of_H + k] = work->hold * work->e[k];
}

/* Tries Cholesky; returns 0, a status, or 1 if a pivot is rounding or not positive. */
static int system_cholesky(dlsi_system *work, dls_error *error) {
  double pivot;
  const int failed = dlsi_cholesky_factor(work->cholesky, work->x, &pivot);
  if (failed < 0) return dlsi_no_memory(error);
  if (failed) return 1;
  memset(work->size, 0, (size_t)work->n * sizeof *work->size);
  for (size_t k = 0; k < work->entries; k++)
    if (work->row[k] == work->col[k]) work->size[work->row[k] - 1] += work->x[k];
  for (int k = 0; k < work->n; k++) {
    const double l = work->cholesky->pivot[work->cholesky->place[k]];
    if (!(l * l * work->size[k] * rounding < 1)) return 1;
  }
  return 0;
}

static dls_status system_lu(dlsi_system *work, dls_error *error) {
  dlsi_triplets t;
  dls_status status =
      dlsi_triplets_alloc(work->n, work->n, work->entries * (work->symmetric ? 2 : 1), &t, error);
  for (size_t k = 0; !status && k < work->entries; k++) {
    const int i = work->row[k] - 1, j = work->col[k] - 1;
    dlsi_triplets_add(&t, i, j, work->x[k]);
    if (work->symmetric && i != j) dlsi_triplets_add(&t, j, i, work->x[k]);
  }
  if (!status) status = dlsi_general_factor(&work->general, &t, error);
  dlsi_triplets_free(&t);
  return status;
}

dls_status dlsi_system_factor_apart(dlsi_system *work, double rho, const int *part,
                                    dls_error *error) {
  const double held = work->hold;
  for (int turn = 0; work->definite && turn < 2; turn++) {
    system_values(work, rho, NULL, part);
    const int answer = system_cholesky(work, error);
    if (answer <= 0) return (dls_status)answer;
    if (work->hold > 0) break;
    work->hold = soft;
  }
  if (work->definite) {
    work->definite = 0;
    work->hold = held;
  }
  system_values(work, rho, NULL, part);
  dls_error why = {0};
  dls_status status = system_lu(work, &why);
  if (status == DLS_E_SINGULAR && work->hold == 0) {
    work->hold = soft;
    system_values(work, rho, NULL, part);
    status = system_lu(work, &why);
  }
  if (status == DLS_E_SINGULAR)
    return dlsi_fail(error, DLS_E_SINGULAR, "model", -1, 0, "K + H R H^T is singular");
  if (status && error) *error = why;
  return status;
}

dls_status dlsi_system_factor(dlsi_system *work, double rho, dls_error *error) {
  return dlsi_system_factor_apart(work, rho, NULL, error);
}

dls_status dlsi_system_factor_weighted(dlsi_system *work, const double *M, dls_error *error) {
  const double held = work->hold;
  int answer = 1;
  for (int turn = 0; work->definite && answer > 0 && turn < 2; turn++) {
    if (turn) work->hold = soft;
    system_values(work, 1, M, NULL);
    answer = system_cholesky(work, error);
  }
  work->hold = held;
  return answer > 0 ? DLS_E_SINGULAR : (dls_status)answer;
}

dls_status dlsi_system_solve(dlsi_system *work, double *x, dls_error *error) {
  return work->definite ? dlsi_cholesky_solve(work->cholesky, x, 1, error)
                        : dlsi_general_solve(&work->general, 0, x, error);
}

void dlsi_system_destroy(dlsi_system *work) {
  if (!work) return;
  dlsi_cholesky_destroy(work->cholesky);
  dlsi_general_free(&work->general);
  free(work->row);
  free(work->col);
  free(work->x);
  free(work->h);
  free(work->e);
  free(work);
}
