/*
 * system.c: A = K + H R H^T + E on the ranks, factored by the parallel MUMPS for several R after
 * one analysis: global/system.c for a K that is spread.
 *
 *   (MY1)  each rank lists its entries of K, H R H^T of its contact nodes, E of its rows
 *   (MY2)  E = 0. If A is singular or not definite, or its condition is above 1e13 (scaled; one
 *          solve with a vector of +-1), E = 1e-8 diag(|K_jj|), with E x_old on the right side; if A
 *          with E is not definite, LDL^T with E = 0, then with E
 *   (MY3)  a solve: rows of b to the factor, rows of x from it
 *
 * No matrix of m rows is formed on any rank. Cost: an analysis on rank 0, a factorisation per R, a
 * solve per iteration. Fails: singular with E, no memory.
 */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "mpi_internal.h"

static const double soft = 1e-8, most_condition = 1e13;

/* ---- entries --------------------------------------------------------------------------------- */

/* Lists H R H^T of the nodes of this rank at row, col, x (NULL: only counts); one triangle if
 * `half`. R: of these nodes. Returns the number of entries. */
static size_t system_push(const dlsi_shares *of, int half, const double *R, int *row, int *col,
                          double *x) {
  const dlsi_triplets *H = &of->mine;
  size_t count = 0;
  for (int begin = 0, end; begin < H->count; begin = end) {
    for (end = begin; end < H->count && H->col[end] == H->col[begin];)
      end++;
    for (int a = begin; a < end; a++)
      for (int b = begin; b < end; b++) {
        if (half && H->row[a] < H->row[b]) continue;
        if (row) {
          row[count] = H->row[a];
          col[count] = H->row[b];
        }
        if (x) x[count] = R[H->col[a] - of->d * of->first] * H->x[a] * H->x[b];
        count++;
      }
  }
  return count;
}

/* e := |K_jj|, or the largest of them if it is 0. */
static void system_diagonal(dlsi_mpi_system *work) {
  const dlsi_mpi_body *K = work->K;
  const int rows = K->of->rows;
  double *sum = K->near;
  memset(sum, 0, (size_t)(rows + K->halo.ghosts) * sizeof *sum);
  for (int i = 0; i < rows + K->halo.ghosts; i++)
    for (size_t k = K->p[i]; k < K->p[i + 1]; k++)
      if (K->col[k] == i) sum[i] += K->x[k];
  dlsi_halo_give(&K->halo, DLSI_SUM, sum);
  double most = dlsi_max_abs(sum, (size_t)rows);
  dlsi_grid_join(&K->of->grid, DLSI_MOST, &most, 1);
  for (int j = 0; j < rows; j++) {
    work->e[j] = fabs(sum[j]);
    if (work->e[j] == 0) work->e[j] = most > 0 ? most : 1;
  }
}

dls_status dlsi_mpi_system_create(dlsi_mpi_system *work, const dlsi_mpi_body *K,
                                  dls_factorization kind, dls_mpi_info *info, dls_error *error) {
  const dlsi_shares *of = K->of;
  const size_t rows = (size_t)of->rows;
  work->K = K;
  work->info = info;
  work->of_H = system_push(of, of->symmetric, NULL, NULL, NULL, NULL);
  const size_t entries = K->entries + work->of_H + rows;
  int *row = dlsi_alloc(2 * entries, sizeof *row), *col = row ? row + entries : NULL;
  work->e = dlsi_alloc(2 * rows, sizeof *work->e);
  dls_status status = row && work->e ? DLS_OK : dlsi_no_memory(error);
  status = dlsi_agree(of->grid.all, status, error);
  if (!status) {
    work->b = work->e + rows;
    dlsi_mpi_body_entries(K, row, col); /* (MY1) */
    (void)system_push(of, of->symmetric, NULL, row + K->entries, col + K->entries, NULL);
    for (size_t k = 0; k < rows; k++)
      row[entries - rows + k] = col[entries - rows + k] = of->first_row + (int)k;
    system_diagonal(work);
    const dls_mpi_model model = {
        .d = of->d, .factorization = kind, .entries = entries, .row = row, .col = col};
    status = dlsi_condenser_begin(&work->condenser, of, &model, info, error);
  }
  free(row);
  return status;
}

void dlsi_mpi_system_free(dlsi_mpi_system *work) {
  dlsi_condenser_destroy(work->condenser);
  free(work->e);
}

/* ---- factor and solve ------------------------------------------------------------------------ */

/* x := A^-1 x. */
static dls_status system_solve(dlsi_mpi_system *work, double *x, dls_error *error) {
  const dls_status status = dlsi_condenser_condense(work->condenser, x, NULL, error);
  return status ? status : dlsi_condenser_expand(work->condenser, NULL, x, error);
}

/* Returns DLS_E_SINGULAR if the condition of A is above most_condition. */
static dls_status system_judge(dlsi_mpi_system *work, dls_error *error) {
  const dlsi_shares *of = work->K->of;
  const dlsi_scales scales = dlsi_condenser_scales(work->condenser);
  dlsi_shares_signs(of, scales.own_rows, work->b);
  const dls_status status = system_solve(work, work->b, error);
  if (status) return status;
  for (int i = 0; i < of->rows; i++)
    work->b[i] /= scales.own_cols[i];
  const double condition = scales.norm * dlsi_joined_norm(&of->ranks, work->b, (size_t)of->rows);
  if (condition <= most_condition) return DLS_OK; /* false for NaN */
  return dlsi_fail(error, DLS_E_SINGULAR, "model", -1, condition, "K + H R H^T is singular");
}

/* One factorisation for R with this E. */
static dls_status system_factor(dlsi_mpi_system *work, const double *R, double hold,
                                dls_error *error) {
  const dlsi_mpi_body *K = work->K;
  double *x = dlsi_condenser_values(work->condenser);
  work->hold = hold;
  memcpy(x, K->x, K->entries * sizeof *x);
  (void)system_push(K->of, K->of->symmetric, R, NULL, NULL, x + K->entries);
  for (int k = 0; k < K->of->rows; k++)
    x[K->entries + work->of_H + (size_t)k] = hold * work->e[k];
  const dls_status status = dlsi_condenser_refactor(work->condenser, work->info, error);
  return status ? status : system_judge(work, error);
}

/* (MY2) */
dls_status dlsi_mpi_system_prepare(void *data, const double *R, dls_error *error) {
  DLSI_DOOR; /* called back as a host's function is */
  dlsi_mpi_system *work = data;
  dls_status status = DLS_OK;
  for (int turn = 0; turn < 2; turn++) {
    status = system_factor(work, R, work->hold, error);
    const int fails = status == DLS_E_SINGULAR || status == DLS_E_NOT_POSITIVE_DEFINITE;
    if (fails && work->hold == 0) status = system_factor(work, R, soft, error);
    if (status != DLS_E_NOT_POSITIVE_DEFINITE) return status;
    work->hold = 0;
    const dls_status again = dlsi_condenser_again(work->condenser, DLS_LDLT, work->info, error);
    if (again) return again;
  }
  return status;
}

/* (MY3) */
dls_status dlsi_mpi_system_solve(void *data, const double *b, double *x, double accuracy,
                                 dls_error *error) {
  DLSI_DOOR;
  dlsi_mpi_system *work = data;
  const int rows = work->K->of->rows;
  (void)accuracy;
  for (int j = 0; j < rows; j++)
    work->b[j] = b[j] + work->hold * work->e[j] * x[j];
  const dls_status status = system_solve(work, work->b, error);
  if (!status) memcpy(x, work->b, (size_t)rows * sizeof *x);
  return status;
}
