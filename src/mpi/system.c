/*
 * system.c: A = K + H R H^T + E on the ranks, factored by the parallel MUMPS for several R after
 * one analysis: global/system.c for a K that is spread.
 *
 *   (MY1)  each rank lists its entries of K, H R H^T of its contact nodes, E of its rows
 *   (MY2)  E = 0. If A is singular or not definite, or its condition is above 1e13 (scaled; one
 *          solve with a vector of +-1), E = 1e-8 diag(|K_jj|), with E x_old on the right side; if A
 *          with E is not definite, LDL^T with E = 0, then with E
 *   (MY3)  a solve: b from rank 0 to the factor, x from rank 0 to all
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
 * `half`. R: m. Returns the number of entries. */
static size_t system_push(const dlsi_shares *of, int half, const double *R, int *row, int *col,
                          double *x) {
  const dlsi_columns *H = &of->H;
  size_t count = 0;
  for (int k = of->d * of->first; k < of->d * (of->first + of->own); k++)
    for (int a = H->p[k]; a < H->p[k + 1]; a++)
      for (int b = H->p[k]; b < H->p[k + 1]; b++) {
        const int i = of->keep[H->i[a]], j = of->keep[H->i[b]];
        if (half && i < j) continue;
        if (row) {
          row[count] = i;
          col[count] = j;
        }
        if (x) x[count] = R[k] * H->x[a] * H->x[b];
        count++;
      }
  return count;
}

/* e := |K_jj|, or the largest of them if it is 0. */
static void system_diagonal(dlsi_mpi_system *work) {
  const dlsi_mpi_body *K = work->K;
  const int n = K->of->n;
  memset(work->b, 0, (size_t)n * sizeof *work->b);
  for (size_t k = 0; k < K->entries; k++)
    if (K->row[k] == K->col[k]) work->b[K->row[k]] += K->x[k];
  (void)MPI_Reduce(work->b, work->e, n, MPI_DOUBLE, MPI_SUM, 0, K->of->grid.all);
  (void)MPI_Bcast(work->e, n, MPI_DOUBLE, 0, K->of->grid.all);
  const double most = dlsi_max_abs(work->e, (size_t)n);
  for (int j = 0; j < n; j++) {
    work->e[j] = fabs(work->e[j]);
    if (work->e[j] == 0) work->e[j] = most > 0 ? most : 1;
  }
}

dls_status dlsi_mpi_system_create(dlsi_mpi_system *work, const dlsi_mpi_body *K,
                                  dls_factorization kind, dls_mpi_info *info, dls_error *error) {
  const dlsi_shares *of = K->of;
  const size_t n = (size_t)of->n, rows = (size_t)of->rows;
  work->K = K;
  work->info = info;
  work->kind = kind;
  work->of_H = system_push(of, of->symmetric, NULL, NULL, NULL, NULL);
  const size_t entries = K->entries + work->of_H + rows;
  work->row = dlsi_alloc(2 * entries, sizeof *work->row);
  work->x = dlsi_alloc(entries, sizeof *work->x);
  work->e = dlsi_alloc(2 * n, sizeof *work->e);
  dls_status status = work->row && work->x && work->e ? DLS_OK : dlsi_no_memory(error);
  status = dlsi_agree(of->grid.all, status, error);
  if (status) return status;
  work->col = work->row + entries;
  work->b = work->e + n;
  memcpy(work->row, K->row, K->entries * sizeof *work->row); /* (MY1) */
  memcpy(work->col, K->col, K->entries * sizeof *work->col);
  (void)system_push(of, of->symmetric, NULL, work->row + K->entries, work->col + K->entries, NULL);
  for (size_t k = 0; k < rows; k++)
    work->row[entries - rows + k] = work->col[entries - rows + k] = of->first_row + (int)k;
  memset(work->x, 0, entries * sizeof *work->x);
  system_diagonal(work);
  work->model = (dls_mpi_model){.d = of->d,
                                .factorization = kind,
                                .rows = of->rows,
                                .entries = entries,
                                .row = work->row,
                                .col = work->col,
                                .x = work->x};
  return dlsi_condenser_begin(&work->condenser, &of->grid, of->n, &work->model, info, error);
}

void dlsi_mpi_system_free(dlsi_mpi_system *work) {
  dlsi_condenser_destroy(work->condenser);
  free(work->row);
  free(work->x);
  free(work->e);
}

/* ---- factor and solve ------------------------------------------------------------------------ */

/* x := A^-1 x, on rank 0. */
static dls_status system_solve(dlsi_mpi_system *work, double *x, dls_error *error) {
  const dls_status status = dlsi_condenser_condense(work->condenser, x, NULL, error);
  return status ? status : dlsi_condenser_expand(work->condenser, NULL, x, error);
}

/* Returns DLS_E_SINGULAR if the condition of A is above most_condition. */
static dls_status system_judge(dlsi_mpi_system *work, dls_error *error) {
  const size_t n = (size_t)work->K->of->n;
  const int root = work->K->of->grid.rank == 0;
  const dlsi_scales scales = dlsi_condenser_scales(work->condenser);
  unsigned long long seed = 1;
  double condition = 0;
  for (size_t i = 0; i < n; i++) {
    seed = seed * 6364136223846793005u + 1442695040888963407u;
    work->b[i] = (seed >> 63 ? 1 : -1) / scales.all_rows[i];
  }
  const dls_status status = system_solve(work, work->b, error);
  if (status) return status;
  for (size_t i = 0; root && i < n; i++)
    work->b[i] /= scales.all_cols[i];
  if (root) condition = scales.norm * dlsi_norm2(work->b, n);
  (void)MPI_Bcast(&condition, 1, MPI_DOUBLE, 0, work->K->of->grid.all);
  if (condition <= most_condition) return DLS_OK; /* false for NaN */
  return dlsi_fail(error, DLS_E_SINGULAR, "model", -1, condition, "K + H R H^T is singular");
}

/* One factorisation with this E. */
static dls_status system_factor(dlsi_mpi_system *work, double hold, dls_error *error) {
  const size_t rows = (size_t)work->K->of->rows, first = (size_t)work->K->of->first_row;
  work->hold = hold;
  for (size_t k = 0; k < rows; k++)
    work->x[work->model.entries - rows + k] = hold * work->e[first + k];
  const dls_status status =
      dlsi_condenser_refactor(work->condenser, &work->model, work->info, error);
  return status ? status : system_judge(work, error);
}

/* Analyses again, for LDL^T. */
static dls_status system_take_ldlt(dlsi_mpi_system *work, dls_error *error) {
  const dlsi_shares *of = work->K->of;
  dlsi_condenser_destroy(work->condenser);
  work->condenser = NULL;
  work->model.factorization = work->kind = DLS_LDLT;
  return dlsi_condenser_begin(&work->condenser, &of->grid, of->n, &work->model, work->info, error);
}

/* (MY2) */
dls_status dlsi_mpi_system_prepare(void *data, const double *R, dls_error *error) {
  DLSI_DOOR; /* called back as a host's function is */
  dlsi_mpi_system *work = data;
  const dlsi_mpi_body *K = work->K;
  dls_status status = DLS_OK;
  memcpy(work->x, K->x, K->entries * sizeof *work->x);
  (void)system_push(K->of, K->of->symmetric, R, NULL, NULL, work->x + K->entries);
  for (int turn = 0; turn < 2; turn++) {
    status = system_factor(work, work->hold, error);
    const int fails = status == DLS_E_SINGULAR || status == DLS_E_NOT_POSITIVE_DEFINITE;
    if (fails && work->hold == 0) status = system_factor(work, soft, error);
    if (status != DLS_E_NOT_POSITIVE_DEFINITE) return status;
    work->hold = 0;
    const dls_status again = system_take_ldlt(work, error);
    if (again) return again;
  }
  return status;
}

/* (MY3) */
dls_status dlsi_mpi_system_solve(void *data, const double *b, double *x, double accuracy,
                                 dls_error *error) {
  DLSI_DOOR;
  dlsi_mpi_system *work = data;
  const int n = work->K->of->n;
  (void)accuracy;
  for (int j = 0; j < n; j++)
    work->b[j] = b[j] + work->hold * work->e[j] * x[j];
  const dls_status status = system_solve(work, work->b, error);
  if (status) return status;
  (void)MPI_Bcast(work->b, n, MPI_DOUBLE, 0, work->K->of->grid.all);
  memcpy(x, work->b, (size_t)n * sizeof *x);
  return DLS_OK;
}
