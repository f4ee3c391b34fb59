/*
 * halo.c: vectors whose rows are spread: each rank has contiguous rows of its own, and behind them
 * copies of the rows of others that it reads or adds to (ghosts).
 *
 *   fetch  (HA1)  ghosts := the rows of their owners
 *   give   (HA2)  the owners' rows := their sum with, or maximum of, the ghosts of all ranks
 *
 * Each is one exchange between neighbours, on a graph that is set up once. Owners add in the order
 * of the ranks: the same bits each time. Memory: the ghosts, and the rows that are ghosts of
 * others. Fails: no memory on one rank.
 */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "mpi_internal.h"

/* ---- sorted numbers -------------------------------------------------------------------------- */

static int unique_compare(const void *a, const void *b) {
  const int x = *(const int *)a, y = *(const int *)b;
  return (x > y) - (x < y);
}

size_t dlsi_unique(int *x, size_t count) {
  size_t kept = 0;
  if (count) qsort(x, count, sizeof *x, unique_compare);
  for (size_t k = 0; k < count; k++)
    if (kept == 0 || x[k] != x[kept - 1]) x[kept++] = x[k];
  return kept;
}

/* ---- create ---------------------------------------------------------------------------------- */

/* Returns how many rows and columns of entries other ranks own; lists them, unless list is NULL. */
static size_t halo_others(const dlsi_halo *h, const dlsi_entries *of, int *list) {
  const int *const both[] = {of->row, of->col};
  size_t found = 0;
  for (size_t k = 0; k < of->count; k++) {
    if (of->lower && of->row[k] < of->col[k]) continue;
    for (int i = 0; i < (of->col ? 2 : 1); i++) {
      const int number = both[i][k];
      if (number >= h->first && number < h->first + h->rows) continue;
      if (list) list[found] = number;
      found++;
    }
  }
  return found;
}

/* Lists the ghosts. */
static dls_status halo_list(dlsi_halo *h, const dlsi_entries *of, dls_error *error) {
  int *list = dlsi_alloc(halo_others(h, of, NULL), sizeof *list);
  if (!list) return dlsi_no_memory(error);
  h->ghosts = (int)dlsi_unique(list, halo_others(h, of, list));
  h->ghost = dlsi_alloc((size_t)h->ghosts, sizeof *h->ghost);
  if (h->ghost) memcpy(h->ghost, list, (size_t)h->ghosts * sizeof *list);
  free(list);
  return h->ghost ? DLS_OK : dlsi_no_memory(error);
}

/* Joins ranks of which one has ghosts of the other, and tells owners which rows these are. all:
 * scratch, 3 for each rank. */
static dls_status halo_meet(dlsi_halo *h, const int *counts, const int *starts, int *all,
                            dls_error *error) {
  const int ranks = h->grid->ranks;
  int *wants = all, *gives = all + ranks, *near = all + 2 * ranks;
  for (int k = 0, g = 0; k < ranks; k++)
    for (wants[k] = 0; g < h->ghosts && h->ghost[g] < starts[k] + counts[k]; g++)
      wants[k]++;
  (void)MPI_Alltoall(wants, 1, MPI_INT, gives, 1, MPI_INT, h->grid->all);
  for (int k = 0; k < ranks; k++)
    if (wants[k] || gives[k]) {
      near[h->near++] = k;
      h->sent += gives[k];
    }
  h->out = dlsi_alloc((size_t)h->near, 4 * sizeof *h->out);
  h->row = dlsi_alloc((size_t)h->sent, sizeof *h->row);
  h->x = dlsi_alloc((size_t)h->sent, sizeof *h->x);
  const dls_status status = h->out && h->row && h->x ? DLS_OK : dlsi_no_memory(error);
  if (dlsi_agree(h->grid->all, status, error)) return error->status;
  h->out_start = h->out + h->near;
  h->in = h->out_start + h->near;
  h->in_start = h->in + h->near;
  for (int k = 0; k < h->near; k++) {
    h->out[k] = gives[near[k]];
    h->in[k] = wants[near[k]];
    h->out_start[k] = k ? h->out_start[k - 1] + h->out[k - 1] : 0;
    h->in_start[k] = k ? h->in_start[k - 1] + h->in[k - 1] : 0;
  }
  (void)MPI_Dist_graph_create_adjacent(h->grid->all, h->near, near, h->in, h->near, near, h->out,
                                       MPI_INFO_NULL, 0, &h->graph);
  h->open = 1;
  (void)MPI_Neighbor_alltoallv(h->ghost, h->in, h->in_start, MPI_INT, h->row, h->out, h->out_start,
                               MPI_INT, h->graph);
  for (int k = 0; k < h->sent; k++)
    h->row[k] -= h->first;
  return DLS_OK;
}

dls_status dlsi_halo_create(dlsi_halo *h, const dlsi_grid *grid, const int *counts,
                            const int *starts, const dlsi_entries *of, dls_error *error) {
  *h = (dlsi_halo){.grid = grid, .rows = counts[grid->rank], .first = starts[grid->rank]};
  int *all = dlsi_alloc((size_t)grid->ranks, 3 * sizeof *all);
  dls_status status = halo_list(h, of, error);
  if (!status && !all) status = dlsi_no_memory(error);
  status = dlsi_agree(grid->all, status, error);
  if (!status) status = halo_meet(h, counts, starts, all, error);
  free(all);
  return status;
}

void dlsi_halo_free(dlsi_halo *h) {
  if (h->open) (void)MPI_Comm_free(&h->graph);
  void *const owned[] = {h->ghost, h->out, h->row, h->x};
  for (size_t k = 0; k < sizeof owned / sizeof owned[0]; k++)
    free(owned[k]);
  *h = (dlsi_halo){.open = 0};
}

int dlsi_halo_place(const dlsi_halo *h, int number) {
  const int k = number - h->first;
  return k >= 0 && k < h->rows ? k : h->rows + dlsi_find(h->ghost, h->ghosts, number);
}

/* ---- exchange -------------------------------------------------------------------------------- */

void dlsi_halo_fetch(const dlsi_halo *h, double *x) {
  for (int k = 0; k < h->sent; k++)
    h->x[k] = x[h->row[k]];
  (void)MPI_Neighbor_alltoallv(h->x, h->out, h->out_start, MPI_DOUBLE, x + h->rows, h->in,
                               h->in_start, MPI_DOUBLE, h->graph);
}

void dlsi_halo_give(const dlsi_halo *h, dlsi_how how, double *x) {
  (void)MPI_Neighbor_alltoallv(x + h->rows, h->in, h->in_start, MPI_DOUBLE, h->x, h->out,
                               h->out_start, MPI_DOUBLE, h->graph);
  for (int k = 0; k < h->sent; k++) {
    double *own = &x[h->row[k]];
    if (how == DLSI_SUM)
      *own += h->x[k];
    else if (h->x[k] > *own || h->x[k] != h->x[k])
      *own = h->x[k];
  }
}
