/*
 * body.c: the certificate of the body (base/body.c) for a K whose entries are spread.
 *
 *   (MB1)  K x and |K||x|: each rank adds up its entries, rank 0 the ranks, so that all have the
 *          same bits. |K||x| counts entries of one place separately
 *   (MB2)  connected bodies: each rank joins what its entries join, rank 0 the forests of all
 *   (MB3)  weights: every rank gets the entries between unknowns that one contact touches
 *
 * dlsi_body_measure runs on every rank with equal vectors of all unknowns. Memory of a rank: its
 * entries of K, about 12 vectors of n. Fails: no memory on one rank.
 */
#include <limits.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "mpi_internal.h"

/* (MB1) */
static void body_multiply(void *data, const double *x, double *y, double *a) {
  const dlsi_mpi_body *work = data;
  const int n = work->of->n, symmetric = work->of->symmetric;
  const MPI_Comm all = work->of->grid.all;
  memset(y, 0, (size_t)n * sizeof *y);
  if (a) memset(a, 0, (size_t)n * sizeof *a);
  for (size_t k = 0; k < work->entries; k++) {
    const int i = work->row[k], j = work->col[k];
    const double v = work->x[k], part = v * x[j];
    y[i] += part;
    if (a) a[i] += fabs(part);
    if (!symmetric || i == j) continue;
    y[j] += v * x[i];
    if (a) a[j] += fabs(v * x[i]);
  }
  double *const sums[] = {y, a};
  for (int k = 0; k < (a ? 2 : 1); k++) {
    (void)MPI_Reduce(work->of->grid.rank ? sums[k] : MPI_IN_PLACE, sums[k], n, MPI_DOUBLE, MPI_SUM,
                     0, all);
    (void)MPI_Bcast(sums[k], n, MPI_DOUBLE, 0, all);
  }
}

static int body_reads(const dlsi_shares *of, const dls_mpi_model *model, size_t k) {
  return !of->symmetric || model->row[k] >= model->col[k];
}

static void body_copy(dlsi_mpi_body *work, const dls_mpi_model *model) {
  size_t at = 0;
  for (size_t k = 0; k < model->entries; k++) {
    if (!body_reads(work->of, model, k)) continue;
    work->row[at] = model->row[k];
    work->col[at] = model->col[k];
    work->x[at++] = model->x[k];
  }
}

/* (MB2) other: scratch, n. */
static void body_join(dlsi_mpi_body *work, int *other) {
  const dlsi_grid *grid = &work->of->grid;
  const int n = work->of->n;
  for (int i = 0; i < n; i++)
    work->part[i] = i;
  for (size_t k = 0; k < work->entries; k++)
    if (work->x[k] != 0 && work->row[k] != work->col[k])
      dlsi_body_join(work->part, work->row[k], work->col[k]);
  if (grid->rank) (void)MPI_Send(work->part, n, MPI_INT, 0, 0, grid->all);
  for (int k = 1; grid->rank == 0 && k < grid->ranks; k++) {
    (void)MPI_Recv(other, n, MPI_INT, k, 0, grid->all, MPI_STATUS_IGNORE);
    for (int i = 0; i < n; i++)
      if (other[i] != i) dlsi_body_join(work->part, i, other[i]);
  }
  if (grid->rank == 0) work->body.parts = dlsi_body_number(n, work->part);
  (void)MPI_Bcast(&work->body.parts, 1, MPI_INT, 0, grid->all);
  (void)MPI_Bcast(work->part, n, MPI_INT, 0, grid->all);
}

/* Sets place[i] to the number of unknown i among those that H touches, -1 for others, and group to
 * numbers that are equal for unknowns tied by contacts. place: n; group: count. */
static void body_group(const dlsi_shares *of, int *place, int *group) {
  for (int i = 0; i < of->n; i++)
    place[i] = -1;
  for (int k = 0; k < of->count; k++) {
    place[of->keep[k]] = k;
    group[k] = k;
  }
  for (int c = 0; c < of->nodes; c++)
    for (int e = of->H.p[of->d * c]; e < of->H.p[of->d * (c + 1)]; e++)
      dlsi_body_join(group, of->H.i[of->H.p[of->d * c]], of->H.i[e]);
  (void)dlsi_body_number(of->count, group);
}

/* Lists the entries of this rank within a group; t NULL: only counts. */
static size_t body_list(const dlsi_mpi_body *work, const int *place, const int *group,
                        dlsi_triplets *t) {
  size_t count = 0;
  for (size_t k = 0; k < work->entries; k++) {
    const int i = place[work->row[k]], j = place[work->col[k]];
    if (i < 0 || j < 0 || group[i] != group[j]) continue;
    if (t) dlsi_triplets_add(t, i, j, work->x[k]);
    count++;
  }
  return count;
}

/* (MB3) place, group: scratch, n and count. */
static dls_status body_weigh(dlsi_mpi_body *work, dls_factorization factorization, int *place,
                             int *group, dls_error *error) {
  const dlsi_shares *of = work->of;
  dlsi_triplets mine = {0}, whole = {0};
  dlsi_columns K = {0};
  body_group(of, place, group);
  dls_status status =
      dlsi_triplets_alloc(of->count, of->count, body_list(work, place, group, NULL), &mine, error);
  status = dlsi_agree(of->grid.all, status, error);
  if (!status) {
    (void)body_list(work, place, group, &mine);
    status = dlsi_shares_join(of, &mine, &whole, error);
  }
  if (!status) {
    status = dlsi_columns_compress(&whole, 1, DLSI_ALL, &K, error);
    const dls_sparse H = dlsi_columns_view(&of->H);
    const dls_model model = {.n = of->count,
                             .operator_kind = DLS_STIFFNESS_SPARSE,
                             .factorization = factorization,
                             .Ks = dlsi_columns_view(&K)};
    if (!status && of->m) status = dlsi_body_weights(&model, &H, of->d, work->w, error);
    status = dlsi_agree(of->grid.all, status, error);
  }
  dlsi_columns_free(&K);
  dlsi_triplets_free(&whole);
  dlsi_triplets_free(&mine);
  return status;
}

dls_status dlsi_mpi_body_create(dlsi_mpi_body *work, const dlsi_shares *of,
                                const dls_mpi_model *model, dls_error *error) {
  const size_t n = (size_t)of->n;
  work->of = of;
  for (size_t k = 0; k < model->entries; k++)
    work->entries += (size_t)body_reads(of, model, k);
  work->row = dlsi_alloc(2 * work->entries, sizeof *work->row);
  work->x = dlsi_alloc(work->entries, sizeof *work->x);
  work->p = dlsi_alloc(2 * n + 1, sizeof *work->p);
  work->w = dlsi_alloc(2 * (size_t)of->nodes, sizeof *work->w);
  int *place = dlsi_alloc(n + (size_t)of->count, sizeof *place);
  dls_status status =
      work->row && work->x && work->p && work->w && place ? DLS_OK : dlsi_no_memory(error);
  status = dlsi_agree(of->grid.all, status, error);
  if (!status) {
    work->col = work->row + work->entries;
    work->part = work->p + n + 1;
    body_copy(work, model);
    body_join(work, place);
    status = body_weigh(work, model->factorization, place, place + n, error);
  }
  free(place);
  if (status) return status;
  for (int i = 0, k = 0; i <= of->n; i++) { /* the rows of H^T on all unknowns */
    work->p[i] = of->Ht.p[k];
    if (k < of->count && of->keep[k] == i) k++;
  }
  work->body = (dlsi_body){.n = of->n,
                           .multiply = body_multiply,
                           .data = work,
                           .Ht = {of->m, of->n, work->p, of->Ht.i, of->Ht.x},
                           .d = of->d,
                           .nc = of->nodes,
                           .w = work->w,
                           .part = work->part,
                           .parts = work->body.parts};
  work->scratch = dlsi_alloc(dlsi_body_scratch(&work->body), sizeof *work->scratch);
  return dlsi_agree(of->grid.all, work->scratch ? DLS_OK : dlsi_no_memory(error), error);
}

void dlsi_mpi_body_free(dlsi_mpi_body *work) {
  void *const owned[] = {work->row, work->x, work->p, work->w, work->scratch};
  for (size_t k = 0; k < sizeof owned / sizeof owned[0]; k++)
    free(owned[k]);
}
