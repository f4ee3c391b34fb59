/*
 * body.c: the certificate of the body (contact/body.c) for a K whose entries are spread.
 *
 *   (MB1)  K x and |K||x|: each rank multiplies its entries, with the x of other ranks' rows that
 *          they touch, and gives them their part (halo.c). |K||x| counts entries of one place
 *          separately
 *   (MB2)  connected bodies: each rank joins what its entries join; the least unknown of each part
 *          goes round until no label changes, once for each time that a body changes the rank
 *   (MB3)  weights: every rank gets the entries between unknowns that one contact touches
 *
 * dlsi_body_measure runs on every rank with the rows and nodes of the rank. Memory of a rank: its
 * entries of K, 3 vectors of its rows. Fails: no memory on one rank.
 */
#include <limits.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "mpi_internal.h"

static size_t body_places(const dlsi_mpi_body *work) {
  return (size_t)(work->halo.rows + work->halo.ghosts);
}

/* (MB1) */
static void body_multiply(void *data, const double *x, double *y, double *a) {
  const dlsi_mpi_body *work = data;
  const int symmetric = work->of->symmetric;
  const size_t places = body_places(work), rows = (size_t)work->of->rows;
  double *near = work->near, *sum = near + places, *size = sum + places;
  memcpy(near, x, rows * sizeof *x);
  dlsi_halo_fetch(&work->halo, near);
  memset(sum, 0, (a ? 2 : 1) * places * sizeof *sum);
  for (size_t i = 0; i < places; i++)
    for (size_t k = work->p[i]; k < work->p[i + 1]; k++) {
      const size_t j = (size_t)work->col[k];
      const double v = work->x[k], part = v * near[j];
      sum[i] += part;
      if (a) size[i] += fabs(part);
      if (!symmetric || i == j) continue;
      sum[j] += v * near[i];
      if (a) size[j] += fabs(v * near[i]);
    }
  dlsi_halo_give(&work->halo, DLSI_SUM, sum);
  memcpy(y, sum, rows * sizeof *y);
  if (!a) return;
  dlsi_halo_give(&work->halo, DLSI_SUM, size);
  memcpy(a, size, rows * sizeof *a);
}

/* Copies K by rows. */
static dls_status body_copy(dlsi_mpi_body *work, const dls_mpi_model *model, dls_error *error) {
  const dlsi_shares *of = work->of;
  const dlsi_entries all = {model->row, model->col, model->entries, of->symmetric};
  dls_status status =
      dlsi_halo_create(&work->halo, &of->grid, of->row_counts, of->row_starts, &all, error);
  if (status) return status;
  const size_t places = body_places(work);
  size_t *p = work->p = calloc(places + 1, sizeof *work->p);
  for (size_t k = 0; p && k < model->entries; k++) {
    if (of->symmetric && model->row[k] < model->col[k]) continue;
    p[dlsi_halo_place(&work->halo, model->row[k])]++;
    work->entries++;
  }
  work->col = dlsi_alloc(work->entries, sizeof *work->col);
  work->x = dlsi_alloc(work->entries, sizeof *work->x);
  status = p && work->col && work->x ? DLS_OK : dlsi_no_memory(error);
  status = dlsi_agree(of->grid.all, status, error);
  if (status) return status;
  p[places] = work->entries;
  for (size_t i = places; i > 0; i--) /* p[i]: the end of row i, then its begin */
    p[i - 1] = p[i] - p[i - 1];
  for (size_t i = 0; i < places; i++)
    p[i] = p[i + 1];
  for (size_t k = model->entries; k > 0; k--) {
    const int row = model->row[k - 1], col = model->col[k - 1];
    if (of->symmetric && row < col) continue;
    const size_t at = --p[dlsi_halo_place(&work->halo, row)];
    work->col[at] = dlsi_halo_place(&work->halo, col);
    work->x[at] = model->x[k - 1];
  }
  return DLS_OK;
}

void dlsi_mpi_body_entries(const dlsi_mpi_body *work, int *row, int *col) {
  for (size_t i = 0; i < body_places(work); i++)
    for (size_t k = work->p[i]; k < work->p[i + 1]; k++) {
      row[k] = dlsi_halo_number(&work->halo, (int)i);
      col[k] = dlsi_halo_number(&work->halo, work->col[k]);
    }
}

/* (MB2) Sets label to minus the least unknown of the body of each place. group: scratch; both of
 * all places. */
static void body_label(const dlsi_mpi_body *work, int *group, double *label) {
  const int places = (int)body_places(work);
  double *most = work->near + places;
  for (int i = 0; i < places; i++) {
    group[i] = i;
    label[i] = -dlsi_halo_number(&work->halo, i);
  }
  for (int i = 0; i < places; i++)
    for (size_t k = work->p[i]; k < work->p[i + 1]; k++)
      if (work->x[k] != 0 && i != work->col[k]) dlsi_body_join(group, i, work->col[k]);
  (void)dlsi_body_number(places, group);
  for (double changed = 1; changed > 0;) {
    changed = 0;
    for (int i = 0; i < places; i++)
      most[i] = -INFINITY;
    for (int i = 0; i < places; i++)
      most[group[i]] = fmax(most[group[i]], label[i]);
    for (int i = 0; i < places; i++) {
      if (label[i] != most[group[i]]) changed = 1;
      label[i] = most[group[i]];
    }
    dlsi_grid_join(&work->of->grid, DLSI_MOST, &changed, 1);
    dlsi_halo_give(&work->halo, DLSI_MOST, label);
    dlsi_halo_fetch(&work->halo, label);
  }
}

/* (MB2) Numbers the bodies by their first unknown. first: scratch, rows; counts: 2 ranks. */
static dls_status body_number(dlsi_mpi_body *work, const double *label, int *first, int *counts,
                              dls_error *error) {
  const dlsi_shares *of = work->of;
  int mine = 0, parts = 0, *starts = counts + of->grid.ranks;
  for (int i = 0; i < of->rows; i++)
    if (-label[i] == of->first_row + i) first[mine++] = of->first_row + i;
  (void)MPI_Allgather(&mine, 1, MPI_INT, counts, 1, MPI_INT, of->grid.all);
  for (int k = 0; k < of->grid.ranks; k++) {
    starts[k] = parts;
    parts += counts[k];
  }
  int *all = dlsi_alloc((size_t)parts, sizeof *all);
  const dls_status status = dlsi_agree(of->grid.all, all ? DLS_OK : dlsi_no_memory(error), error);
  if (!status) {
    (void)MPI_Allgatherv(first, mine, MPI_INT, all, counts, starts, MPI_INT, of->grid.all);
    for (int i = 0; i < of->rows; i++)
      work->part[i] = dlsi_find(all, parts, (int)-label[i]);
    work->body.parts = parts;
  }
  free(all);
  return status;
}

/* Sets place to the number of each unknown of this rank's entries among those that H touches, -1
 * for others, and group to numbers that are equal for unknowns tied by contacts. group: count. */
static void body_group(const dlsi_mpi_body *work, int *place, int *group) {
  const dlsi_shares *of = work->of;
  for (size_t i = 0; i < body_places(work); i++)
    place[i] = dlsi_find(of->keep, of->count, dlsi_halo_number(&work->halo, (int)i));
  for (int k = 0; k < of->count; k++)
    group[k] = k;
  for (int c = 0; c < of->nodes; c++)
    for (int e = of->H.p[of->d * c]; e < of->H.p[of->d * (c + 1)]; e++)
      dlsi_body_join(group, of->H.i[of->H.p[of->d * c]], of->H.i[e]);
  (void)dlsi_body_number(of->count, group);
}

/* Lists the entries of this rank within a group; t NULL: only counts. */
static size_t body_list(const dlsi_mpi_body *work, const int *place, const int *group,
                        dlsi_triplets *t) {
  size_t count = 0;
  for (size_t row = 0; row < body_places(work); row++)
    for (size_t k = work->p[row]; k < work->p[row + 1]; k++) {
      const int i = place[row], j = place[work->col[k]];
      if (i < 0 || j < 0 || group[i] != group[j]) continue;
      if (t) dlsi_triplets_add(t, i, j, work->x[k]);
      count++;
    }
  return count;
}

/* (MB3) place, group: scratch, all places and count. */
static dls_status body_weigh(dlsi_mpi_body *work, dls_factorization factorization, int *place,
                             int *group, dls_error *error) {
  const dlsi_shares *of = work->of;
  dlsi_triplets mine = {0}, whole = {0};
  dlsi_columns K = {0};
  body_group(work, place, group);
  dls_status status =
      dlsi_triplets_alloc(of->count, of->count, body_list(work, place, group, NULL), &mine, error);
  double *w = dlsi_alloc((size_t)of->nodes, 2 * sizeof *w);
  if (!status && !w) status = dlsi_no_memory(error);
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
    if (!status && of->m) status = dlsi_body_weights(&model, &H, of->d, w, error);
    status = dlsi_agree(of->grid.all, status, error);
  }
  for (int k = 0; !status && k < of->here.rows / of->d; k++)
    memcpy(work->w + 2 * k, w + 2 * (dlsi_halo_number(&of->touched, of->d * k) / of->d),
           2 * sizeof *w);
  free(w);
  dlsi_columns_free(&K);
  dlsi_triplets_free(&whole);
  dlsi_triplets_free(&mine);
  return status;
}

dls_status dlsi_mpi_body_create(dlsi_mpi_body *work, const dlsi_shares *of,
                                const dls_mpi_model *model, dls_error *error) {
  const size_t rows = (size_t)of->rows, contacts = (size_t)(of->here.rows / of->d);
  work->of = of;
  dls_status status = body_copy(work, model, error);
  if (status) return status;
  const size_t places = body_places(work);
  work->near = dlsi_alloc(places, 3 * sizeof *work->near);
  work->part = dlsi_alloc(rows, sizeof *work->part);
  work->w = dlsi_alloc(contacts, 2 * sizeof *work->w);
  int *ints = dlsi_alloc(places + (size_t)of->count + 2 * (size_t)of->grid.ranks, sizeof *ints);
  status = work->near && work->part && work->w && ints ? DLS_OK : dlsi_no_memory(error);
  status = dlsi_agree(of->grid.all, status, error);
  if (!status) {
    body_label(work, ints, work->near);
    status = body_number(work, work->near, ints, ints + places, error);
  }
  if (!status) status = body_weigh(work, model->factorization, ints, ints + places, error);
  free(ints);
  if (status) return status;
  work->body = (dlsi_body){.n = of->rows,
                           .multiply = body_multiply,
                           .data = work,
                           .ranks = &of->ranks,
                           .Ht = dlsi_columns_view(&of->here),
                           .d = of->d,
                           .nc = of->own,
                           .w = work->w,
                           .part = work->part,
                           .parts = work->body.parts};
  work->scratch = dlsi_alloc(dlsi_body_scratch(&work->body), sizeof *work->scratch);
  return dlsi_agree(of->grid.all, work->scratch ? DLS_OK : dlsi_no_memory(error), error);
}

void dlsi_mpi_body_free(dlsi_mpi_body *work) {
  dlsi_halo_free(&work->halo);
  void *const owned[] = {work->p, work->col,  work->x,      work->part,
                         work->w, work->near, work->scratch};
  for (size_t k = 0; k < sizeof owned / sizeof owned[0]; k++)
    free(owned[k]);
}
