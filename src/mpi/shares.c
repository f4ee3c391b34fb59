/*
 * shares.c: the model as the ranks have it: checks, the numbers of rows and contact nodes, H, and
 * vectors between one rank and all.
 *
 *   (SH1)  number rows and nodes through the ranks
 *   (SH2)  H goes to every rank, on the unknowns that it touches: for the weights, and for W
 *   (SH3)  a rank keeps the columns of its nodes, and the rows of its unknowns
 *
 * Memory of a rank: its part of H twice; all of H twice until shrink. Fails: sizes that do not fit
 * an int, no memory.
 */
#include <limits.h>
#include <stdlib.h>
#include <string.h>

#include "mpi_internal.h"

/* ---- checks ---------------------------------------------------------------------------------- */

dls_status dlsi_shares_check(const dls_mpi_model *model, dls_error *error) {
  if (!model) return dlsi_is_null(error, "model");
  dls_status status = dlsi_check_dimension("d", model->d, error);
  if (status) return status;
  if (model->factorization < DLS_CHOLESKY || model->factorization > DLS_LDLT)
    return dlsi_fail(error, DLS_E_ARGUMENT, "factorization", -1, model->factorization,
                     "is %d, no factorization", (int)model->factorization);
  if (model->rows < 0)
    return dlsi_fail(error, DLS_E_SIZE, "rows", -1, model->rows, "is %d, must be at least 0",
                     model->rows);
  if (model->nodes < 0)
    return dlsi_fail(error, DLS_E_SIZE, "nodes", -1, model->nodes, "is %d, must be at least 0",
                     model->nodes);
  if (!model->row && model->entries) return dlsi_is_null(error, "row");
  if (!model->col && model->entries) return dlsi_is_null(error, "col");
  return !model->x && model->entries ? dlsi_is_null(error, "x") : DLS_OK;
}

static dls_status model_check_index(const char *argument, const int *index, size_t entries, int n,
                                    dls_error *error) {
  for (size_t k = 0; k < entries; k++)
    if (index[k] < 0 || index[k] >= n)
      return dlsi_fail(error, DLS_E_ARGUMENT, argument, (long long)k, index[k],
                       "is %d, must be in 0 .. %d", index[k], n - 1);
  return DLS_OK;
}

static dls_status model_check_entries(const dls_mpi_model *model, int n, dls_error *error) {
  dls_status status = model_check_index("row", model->row, model->entries, n, error);
  if (!status) status = model_check_index("col", model->col, model->entries, n, error);
  if (!status && model->entries) status = dlsi_check_vector("x", model->x, model->entries, error);
  if (!status && model->nodes) status = dlsi_check_sparse("HN", &model->HN, n, model->nodes, error);
  if (!status && model->nodes)
    status = dlsi_check_sparse("HT", &model->HT, n, (model->d - 1) * model->nodes, error);
  return status;
}

/* ---- create: numbers and H ------------------------------------------------------------------- */

/* starts := sums of the previous counts; returns the total, -1 if it does not fit an int. */
static long long number_ranks(int ranks, const int *counts, int *starts) {
  long long sum = 0;
  for (int k = 0; k < ranks; k++) {
    starts[k] = sum <= INT_MAX ? (int)sum : 0;
    sum += counts[k];
  }
  return sum <= INT_MAX ? sum : -1;
}

/* (SH1) */
static dls_status shares_number(dlsi_shares *work, const dls_mpi_model *model, dls_error *error) {
  const int ranks = work->grid.ranks, rank = work->grid.rank;
  const MPI_Comm all = work->grid.all;
  int first[2] = {model->d, (int)model->factorization};
  (void)MPI_Bcast(first, 2, MPI_INT, 0, all);
  dls_status status = DLS_OK;
  if (first[0] != model->d)
    status = dlsi_fail(error, DLS_E_ARGUMENT, "d", -1, model->d, "is %d, on rank 0 %d", model->d,
                       first[0]);
  else if (first[1] != (int)model->factorization)
    status = dlsi_fail(error, DLS_E_ARGUMENT, "factorization", -1, model->factorization,
                       "is %d, on rank 0 %d", (int)model->factorization, first[1]);
  work->row_counts = dlsi_alloc((size_t)ranks, 4 * sizeof *work->row_counts);
  if (!status && !work->row_counts) status = dlsi_no_memory(error);
  status = dlsi_agree(all, status, error);
  if (status) return status;
  work->d = model->d;
  work->rows = model->rows;
  work->own = model->nodes;
  work->row_starts = work->row_counts + ranks;
  work->node_counts = work->row_counts + 2 * ranks;
  work->node_starts = work->row_counts + 3 * ranks;
  const int own = model->nodes > INT_MAX / model->d ? INT_MAX : model->d * model->nodes;
  (void)MPI_Allgather(&work->rows, 1, MPI_INT, work->row_counts, 1, MPI_INT, all);
  (void)MPI_Allgather(&own, 1, MPI_INT, work->node_counts, 1, MPI_INT, all);
  const long long n = number_ranks(ranks, work->row_counts, work->row_starts);
  const long long m = number_ranks(ranks, work->node_counts, work->node_starts);
  if (n < 1)
    return dlsi_fail(error, DLS_E_SIZE, "rows", -1, (double)n, "of all ranks must be from 1 to %d",
                     INT_MAX);
  if (m < 0 || m == INT_MAX)
    return dlsi_fail(error, DLS_E_SIZE, "nodes", -1, (double)m, "of all ranks are too many");
  work->n = (int)n;
  work->m = (int)m;
  work->nodes = work->m / work->d;
  work->first_row = work->row_starts[rank];
  work->first = work->node_starts[rank] / work->d;
  return DLS_OK;
}

/* Lists the entries of this rank's columns of H, in local order (n, t[, s]). */
static void shares_list(const dlsi_shares *work, const dls_mpi_model *model, dlsi_triplets *t) {
  const int d = work->d;
  for (int c = 0; c < model->nodes; c++)
    for (int i = 0; i < d; i++) {
      const dls_sparse *L = i == 0 ? &model->HN : &model->HT;
      const int column = i == 0 ? c : (d - 1) * c + i - 1;
      for (int e = L->p[column]; e < L->p[column + 1]; e++)
        dlsi_triplets_add(t, L->i[e], d * (work->first + c) + i, L->x[e]);
    }
}

dls_status dlsi_shares_join(const dlsi_shares *work, const dlsi_triplets *mine,
                            dlsi_triplets *whole, dls_error *error) {
  const MPI_Comm all = work->grid.all;
  int *counts = dlsi_alloc((size_t)work->grid.ranks, 2 * sizeof *counts);
  dls_status status = dlsi_agree(all, counts ? DLS_OK : dlsi_no_memory(error), error);
  if (status) {
    free(counts);
    return status;
  }
  int *starts = counts + work->grid.ranks;
  (void)MPI_Allgather(&mine->count, 1, MPI_INT, counts, 1, MPI_INT, all);
  const long long total = number_ranks(work->grid.ranks, counts, starts);
  status = total < 0 ? dlsi_fail(error, DLS_E_SIZE, "HN", -1, 0, "more than INT_MAX entries")
                     : dlsi_triplets_alloc(mine->rows, mine->cols, (size_t)total, whole, error);
  status = dlsi_agree(all, status, error);
  if (status) {
    free(counts);
    return status;
  }
  (void)MPI_Allgatherv(mine->row, mine->count, MPI_INT, whole->row, counts, starts, MPI_INT, all);
  (void)MPI_Allgatherv(mine->col, mine->count, MPI_INT, whole->col, counts, starts, MPI_INT, all);
  (void)MPI_Allgatherv(mine->x, mine->count, MPI_DOUBLE, whole->x, counts, starts, MPI_DOUBLE, all);
  whole->count = (int)total;
  free(counts);
  return DLS_OK;
}

/* Lists the unknowns that H touches and makes H and H^T on them. t: its rows become places in keep.
 */
static dls_status shares_compress(dlsi_shares *work, dlsi_triplets *t, dls_error *error) {
  work->keep = dlsi_alloc((size_t)t->count, sizeof *work->keep);
  if (!work->keep) return dlsi_no_memory(error);
  memcpy(work->keep, t->row, (size_t)t->count * sizeof *t->row);
  t->rows = work->count = (int)dlsi_unique(work->keep, (size_t)t->count);
  for (int k = 0; k < t->count; k++)
    t->row[k] = dlsi_find(work->keep, work->count, t->row[k]);
  const dls_status status = dlsi_columns_compress(t, 1, DLSI_ALL, &work->H, error);
  if (status) return status;
  const dlsi_triplets turned = {t->cols, t->rows, t->count, t->col, t->row, t->x};
  return dlsi_columns_compress(&turned, 1, DLSI_ALL, &work->Ht, error);
}

/* (SH3) */
static dls_status shares_take_rows(dlsi_shares *work, const dlsi_triplets *all, dls_error *error) {
  const int d = work->d;
  dlsi_triplets t;
  size_t count = 0;
  int *index = dlsi_alloc((size_t)all->count, (size_t)d * sizeof *index);
  dls_status status = dlsi_triplets_alloc(0, work->rows, (size_t)all->count, &t, error);
  if (!status && !index) status = dlsi_no_memory(error);
  status = dlsi_agree(work->grid.all, status, error);
  for (int k = 0; !status && k < all->count; k++) {
    const int row = all->row[k] - work->first_row;
    if (row < 0 || row >= work->rows) continue;
    dlsi_triplets_add(&t, all->col[k], row, all->x[k]);
    for (int i = 0; i < d; i++) /* all directions of a node */
      index[count++] = all->col[k] / d * d + i;
  }
  if (!status)
    status = dlsi_halo_create(&work->touched, &work->grid, work->node_counts, work->node_starts,
                              &(dlsi_entries){index, NULL, count, 0}, error);
  if (!status) {
    t.rows = work->touched.rows + work->touched.ghosts;
    for (int k = 0; k < t.count; k++)
      t.row[k] = dlsi_halo_place(&work->touched, t.row[k]);
    status = dlsi_columns_compress(&t, 1, DLSI_ALL, &work->here, error);
    work->ranks.scratch = dlsi_alloc((size_t)t.rows, sizeof(double));
    if (!status && !work->ranks.scratch) status = dlsi_no_memory(error);
    status = dlsi_agree(work->grid.all, status, error);
  }
  dlsi_triplets_free(&t);
  free(index);
  return status;
}

/* (SH2) */
static dls_status shares_take_H(dlsi_shares *work, const dls_mpi_model *model, dls_error *error) {
  const int nodes = model->nodes;
  dlsi_triplets whole = {0};
  const size_t most =
      nodes ? (size_t)model->HN.p[nodes] + (size_t)model->HT.p[(work->d - 1) * nodes] : 0;
  dls_status status = dlsi_triplets_alloc(work->n, work->m, most, &work->mine, error);
  status = dlsi_agree(work->grid.all, status, error);
  if (!status) {
    shares_list(work, model, &work->mine);
    status = dlsi_shares_join(work, &work->mine, &whole, error);
  }
  if (!status) status = shares_take_rows(work, &whole, error);
  if (!status) status = dlsi_agree(work->grid.all, shares_compress(work, &whole, error), error);
  dlsi_triplets_free(&whole);
  return status;
}

static void ranks_join(void *data, dlsi_how how, double *x, size_t count) {
  dlsi_grid_join(&((const dlsi_shares *)data)->grid, how, x, count);
}

static void ranks_fetch(void *data, double *r) {
  dlsi_halo_fetch(&((const dlsi_shares *)data)->touched, r);
}

static void ranks_give(void *data, dlsi_how how, double *u) {
  dlsi_halo_give(&((const dlsi_shares *)data)->touched, how, u);
}

dls_status dlsi_shares_create(dlsi_shares *work, MPI_Comm comm, const dls_mpi_model *model,
                              dls_error *error) {
  dls_status status = dlsi_grid_open(&work->grid, comm, error);
  if (!status) status = shares_number(work, model, error);
  if (!status)
    status = dlsi_agree(work->grid.all, model_check_entries(model, work->n, error), error);
  if (!status) status = shares_take_H(work, model, error);
  work->symmetric = model->factorization != DLS_LU;
  work->ranks = (dlsi_ranks){.data = work,
                             .join = ranks_join,
                             .fetch = ranks_fetch,
                             .give = ranks_give,
                             .first = work->first,
                             .all = (size_t)work->m,
                             .reach = (size_t)work->here.rows,
                             .scratch = work->ranks.scratch};
  return status;
}

void dlsi_shares_shrink(dlsi_shares *work) {
  dlsi_columns_free(&work->H);
  dlsi_columns_free(&work->Ht);
  free(work->keep);
  work->H = work->Ht = (dlsi_columns){.p = NULL};
  work->keep = NULL;
  work->count = 0;
}

void dlsi_shares_free(dlsi_shares *work) {
  dlsi_shares_shrink(work);
  dlsi_columns_free(&work->here);
  dlsi_triplets_free(&work->mine);
  dlsi_halo_free(&work->touched);
  dlsi_grid_close(&work->grid);
  free(work->ranks.scratch);
  free(work->row_counts);
}

/* ---- vectors --------------------------------------------------------------------------------- */

dls_status dlsi_shares_check_vector(const char *argument, const double *x, int count, int optional,
                                    dls_error *error) {
  if (count == 0 || (!x && optional)) return DLS_OK;
  return dlsi_check_vector(argument, x, (size_t)count, error);
}

void dlsi_shares_gather_nodes(const dlsi_shares *work, const double *own, double *all) {
  (void)MPI_Allgatherv(own, work->d * work->own, MPI_DOUBLE, all, work->node_counts,
                       work->node_starts, MPI_DOUBLE, work->grid.all);
}

void dlsi_shares_collect(const dlsi_shares *work, const double *own, double *all) {
  (void)MPI_Gatherv(own, work->rows, MPI_DOUBLE, all, work->row_counts, work->row_starts,
                    MPI_DOUBLE, 0, work->grid.all);
}

void dlsi_shares_hand_out(const dlsi_shares *work, const double *all, double *own) {
  (void)MPI_Scatterv(all, work->row_counts, work->row_starts, MPI_DOUBLE, own, work->rows,
                     MPI_DOUBLE, 0, work->grid.all);
}

void dlsi_shares_signs(const dlsi_shares *work, const double *scale, double *b) {
  unsigned long long seed = 1; /* equal vectors each time */
  for (int i = 0; i < work->first_row + work->rows; i++) {
    seed = seed * 6364136223846793005u + 1442695040888963407u;
    const int k = i - work->first_row;
    if (k >= 0) b[k] = (seed >> 63 ? 1 : -1) / scale[k];
  }
}
