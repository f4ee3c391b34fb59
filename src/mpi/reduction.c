/*
 * reduction.c: K, H -> W, q and back to x, on several ranks.
 *
 *   create  (MR1)  number rows and nodes through the ranks; H goes to every rank
 *           (MR2)  S, the Schur complement of K on the unknowns c that H touches (condense.c)
 *           (MR3)  Z := S^-1 = (K^-1)_cc (grid.c)
 *           (MR4)  W := H_c^T Z H_c; of a symmetric Z = L + L^T, L its lower triangle with half of
 *                  the diagonal, W := V + V^T, V := H_c^T L H_c
 *           (MR5)  |A^-1|_F from one solve with a vector of +-1: singular where 1 / (|A|_1
 *                  |A^-1|_F) < 10 eps, as in linear/schur.c
 *   load    (MR6)  q := H_c^T (K^-1 f)_c + g
 *   recover (MR7)  x := K^-1 (f + H r)
 *
 * (MR4) goes block column by block column: each rank multiplies its share of Z by the columns of H
 * (one or few entries each), process rows sum these panels on the process column that owns the
 * block, which multiplies by H^T and sums. Cost: b^3 and (MR4) m b (entries of a column of H) over
 * the ranks, b^2 / pr + m^2 / pc numbers sent by each.
 */
#include <float.h>
#include <limits.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "mpi_internal.h"

/* ---- checks ---------------------------------------------------------------------------------- */

static dls_status model_check_size(const dls_mpi_model *model, dls_error *error) {
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

static dls_status settings_check(const dls_reduction_settings *s, dls_error *error) {
  if (s->size != sizeof *s)
    return dlsi_fail(error, DLS_E_SETTINGS, "settings", -1, 0, "not initialised");
  if (!(s->memory_limit >= 0 && s->memory_limit <= DBL_MAX))
    return dlsi_fail(error, DLS_E_ARGUMENT, "memory_limit", -1, s->memory_limit,
                     "is %g, must be finite and at least 0", s->memory_limit);
  if (s->stabilize) return dlsi_fail(error, DLS_E_UNSUPPORTED, "stabilize", -1, 1, "on one rank");
  if (!s->form_W) return dlsi_fail(error, DLS_E_UNSUPPORTED, "form_W", -1, 0, "on one rank");
  return DLS_OK;
}

/* ---- create: numbers and H ------------------------------------------------------------------- */

/* starts := sums of the counts before; returns the total, -1 if it is no int. */
static long long number_ranks(int ranks, const int *counts, int *starts) {
  long long sum = 0;
  for (int k = 0; k < ranks; k++) {
    starts[k] = sum <= INT_MAX ? (int)sum : 0;
    sum += counts[k];
  }
  return sum <= INT_MAX ? sum : -1;
}

/* (MR1) */
static dls_status reduction_number(dls_mpi_reduction *work, const dls_mpi_model *model,
                                   dls_error *error) {
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
static void reduction_list(const dls_mpi_reduction *work, const dls_mpi_model *model,
                           dlsi_triplets *t) {
  const int d = work->d;
  for (int c = 0; c < model->nodes; c++)
    for (int i = 0; i < d; i++) {
      const dls_sparse *L = i == 0 ? &model->HN : &model->HT;
      const int column = i == 0 ? c : (d - 1) * c + i - 1;
      for (int e = L->p[column]; e < L->p[column + 1]; e++)
        dlsi_triplets_add(t, L->i[e], d * (work->first + c) + i, L->x[e]);
    }
}

/* Joins the triplets of all ranks to `whole`. counts, starts: scratch, ranks. */
static dls_status reduction_join(const dls_mpi_reduction *work, const dlsi_triplets *mine,
                                 int *counts, int *starts, dlsi_triplets *whole, dls_error *error) {
  const MPI_Comm all = work->grid.all;
  (void)MPI_Allgather(&mine->count, 1, MPI_INT, counts, 1, MPI_INT, all);
  const long long total = number_ranks(work->grid.ranks, counts, starts);
  dls_status status = total < 0
                          ? dlsi_fail(error, DLS_E_SIZE, "HN", -1, 0, "more than INT_MAX entries")
                          : dlsi_triplets_alloc(work->n, work->m, (size_t)total, whole, error);
  status = dlsi_agree(all, status, error);
  if (status) return status;
  (void)MPI_Allgatherv(mine->row, mine->count, MPI_INT, whole->row, counts, starts, MPI_INT, all);
  (void)MPI_Allgatherv(mine->col, mine->count, MPI_INT, whole->col, counts, starts, MPI_INT, all);
  (void)MPI_Allgatherv(mine->x, mine->count, MPI_DOUBLE, whole->x, counts, starts, MPI_DOUBLE, all);
  whole->count = (int)total;
  return DLS_OK;
}

/* Lists the unknowns that H touches and makes H and H^T on them. */
static dls_status reduction_compress(dls_mpi_reduction *work, dlsi_triplets *t, dls_error *error) {
  const size_t n = (size_t)work->n;
  int *place = calloc(n, sizeof *place);
  if (!place) return dlsi_no_memory(error);
  for (int k = 0; k < t->count; k++)
    place[t->row[k]] = 1;
  for (size_t i = 0; i < n; i++)
    work->count += place[i];
  work->keep = dlsi_alloc((size_t)work->count, sizeof *work->keep);
  if (work->keep) {
    int at = 0;
    for (int i = 0; i < work->n; i++)
      if (place[i]) {
        place[i] = at;
        work->keep[at++] = i;
      }
    for (int k = 0; k < t->count; k++)
      t->row[k] = place[t->row[k]];
  }
  free(place);
  if (!work->keep) return dlsi_no_memory(error);
  t->rows = work->count;
  const dls_status status = dlsi_columns_compress(t, 1, DLSI_ALL, &work->H, error);
  if (status) return status;
  const dlsi_triplets turned = {t->cols, t->rows, t->count, t->col, t->row, t->x};
  return dlsi_columns_compress(&turned, 1, DLSI_ALL, &work->Ht, error);
}

static dls_status reduction_take_H(dls_mpi_reduction *work, const dls_mpi_model *model,
                                   dls_error *error) {
  const int nodes = model->nodes, ranks = work->grid.ranks;
  dlsi_triplets mine, whole = {0};
  const size_t most =
      nodes ? (size_t)model->HN.p[nodes] + (size_t)model->HT.p[(work->d - 1) * nodes] : 0;
  dls_status status = dlsi_triplets_alloc(work->n, work->m, most, &mine, error);
  int *counts = dlsi_alloc((size_t)ranks, 2 * sizeof *counts);
  if (!status && !counts) status = dlsi_no_memory(error);
  status = dlsi_agree(work->grid.all, status, error);
  if (!status) {
    reduction_list(work, model, &mine);
    status = reduction_join(work, &mine, counts, counts + ranks, &whole, error);
  }
  if (!status) status = dlsi_agree(work->grid.all, reduction_compress(work, &whole, error), error);
  free(counts);
  dlsi_triplets_free(&whole);
  dlsi_triplets_free(&mine);
  return status;
}

/* ---- create: W ------------------------------------------------------------------------------- */

/* Returns the place in the share of row (column) k of process p of P, -1 if another one has it. */
static int reduction_place(int k, int p, int P) {
  const int nb = dlsi_cyclic_block, block = k / nb;
  return block % P == p ? block / P * nb + k % nb : -1;
}

/* Y(:, l - j0) := the share of Z H(:,l), of L H(:,l) where Z is symmetric, l = j0 .. j1 - 1. */
static void form_right(const dls_mpi_reduction *work, int j0, int j1, double *Y) {
  const dlsi_spread *s = &work->on_kept;
  const size_t rows = (size_t)s->rows;
  memset(Y, 0, rows * (size_t)(j1 - j0) * sizeof *Y);
  for (int l = j0; l < j1; l++)
    for (int e = work->H.p[l]; e < work->H.p[l + 1]; e++) {
      const int k = work->H.i[e], at = reduction_place(k, work->grid.my_col, work->grid.cols);
      if (at < 0) continue;
      const double h = work->H.x[e], *a = work->Z + (size_t)at * rows;
      double *y = Y + (size_t)(l - j0) * rows;
      for (size_t i = 0; i < rows; i++) {
        const double part = !work->symmetric || s->row[i] > k ? 1 : s->row[i] == k ? 0.5 : 0;
        if (part > 0) y[i] += part * h * a[i];
      }
    }
}

/* T(:, l) := the share of H^T Y(:, l), width columns. T: m x width. */
static void form_left(const dls_mpi_reduction *work, int width, const double *Y, double *T) {
  const dlsi_spread *s = &work->on_kept;
  const size_t m = (size_t)work->m, rows = (size_t)s->rows;
  memset(T, 0, m * (size_t)width * sizeof *T);
  for (size_t l = 0; l < (size_t)width; l++)
    for (size_t i = 0; i < rows; i++)
      for (int e = work->Ht.p[s->row[i]]; e < work->Ht.p[s->row[i] + 1]; e++)
        T[m * l + (size_t)work->Ht.i[e]] += work->Ht.x[e] * Y[rows * l + i];
}

/* (MR4) V: receives the share of H^T L H, or of W where Z is not symmetric. Y, T: scratch. */
static void form_panels(const dls_mpi_reduction *work, double *Y, double *T, double *V) {
  const dlsi_grid *grid = &work->grid;
  const dlsi_spread *s = &work->on_W;
  const int nb = dlsi_cyclic_block, m = work->m, rows = work->on_kept.rows;
  for (int j0 = 0; j0 < m; j0 += nb) {
    const int width = m - j0 < nb ? m - j0 : nb, owner = j0 / nb % grid->cols;
    const int mine = owner == grid->my_col;
    form_right(work, j0, j0 + width, Y);
    (void)MPI_Reduce(mine ? MPI_IN_PLACE : Y, Y, rows * width, MPI_DOUBLE, MPI_SUM, owner,
                     grid->row);
    if (!mine) continue;
    form_left(work, width, Y, T);
    (void)MPI_Allreduce(MPI_IN_PLACE, T, m * width, MPI_DOUBLE, MPI_SUM, grid->column);
    const size_t at = (size_t)reduction_place(j0, grid->my_col, grid->cols);
    for (size_t l = 0; l < (size_t)width; l++)
      for (int i = 0; i < s->rows; i++)
        V[(size_t)i + (at + l) * (size_t)s->rows] = T[(size_t)m * l + (size_t)s->row[i]];
  }
}

static dls_status reduction_form(dls_mpi_reduction *work, dls_error *error) {
  const size_t size = dlsi_spread_size(&work->on_W), nb = dlsi_cyclic_block;
  double *V = work->symmetric ? dlsi_alloc(size, sizeof *V) : NULL;
  double *T = dlsi_alloc((size_t)work->m + (size_t)work->on_kept.rows, nb * sizeof *T);
  work->W = dlsi_alloc(size, sizeof *work->W);
  dls_status status = T && work->W && (V || !work->symmetric) ? DLS_OK : dlsi_no_memory(error);
  status = dlsi_agree(work->grid.all, status, error);
  if (!status) {
    form_panels(work, T + nb * (size_t)work->m, T, work->W);
    if (work->symmetric) {
      memcpy(V, work->W, size * sizeof *V);
      dlsi_spread_add_transpose(&work->on_W, V, work->W);
    }
    const long long bad = dlsi_first_not_finite(work->W, size);
    if (bad >= 0) status = dlsi_fail(error, DLS_E_NOT_FINITE, "W", -1, work->W[bad], "overflow");
    status = dlsi_agree(work->grid.all, status, error);
  }
  free(T);
  free(V);
  return status;
}

/* (MR3) */
static dls_status reduction_invert(dls_mpi_reduction *work, int definite, dls_error *error) {
  const dlsi_spread *s = &work->on_kept;
  const dlsi_scales scales = dlsi_condenser_scales(work->condenser);
  double *full = NULL;
  dls_status status = DLS_OK;
  if (work->symmetric && !definite) { /* LU takes both triangles: (lower) + (lower)^T */
    full = dlsi_alloc(dlsi_spread_size(s), sizeof *full);
    status = dlsi_agree(work->grid.all, full ? DLS_OK : dlsi_no_memory(error), error);
    for (int j = 0; !status && j < s->cols; j++)
      for (int i = 0; i < s->rows; i++) {
        double *a = work->Z + (size_t)i + (size_t)j * (size_t)s->rows;
        *a *= s->row[i] > s->col[j] ? 1 : s->row[i] == s->col[j] ? 0.5 : 0;
      }
    if (!status) {
      memcpy(full, work->Z, dlsi_spread_size(s) * sizeof *full);
      dlsi_spread_add_transpose(s, full, work->Z);
    }
    free(full);
    if (status) return status;
  }
  const int failed = dlsi_spread_invert(s, work->Z, definite);
  if (failed < 0) return dlsi_no_memory(error);
  if (failed)
    return dlsi_fail(error, definite ? DLS_E_NOT_POSITIVE_DEFINITE : DLS_E_SINGULAR, "Ks",
                     work->keep[failed - 1], 0,
                     definite ? "not positive definite: a pivot <= 0" : "singular: a pivot of 0");
  for (int j = 0; j < s->cols; j++)
    for (int i = 0; i < s->rows; i++)
      work->Z[(size_t)i + (size_t)j * (size_t)s->rows] *=
          scales.col[s->row[i]] * scales.row[s->col[j]];
  return DLS_OK;
}

/* Solves x := K^-1 b. b, x: n, on rank 0; b: spoilt. */
static dls_status reduction_solve(dls_mpi_reduction *work, double *b, dls_error *error) {
  dls_status status = dlsi_condenser_condense(work->condenser, b, work->z, error);
  if (status) return status;
  if (work->count)
    dlsi_spread_multiply(&work->on_kept, work->Z, work->symmetric, 0, work->z, work->z);
  return dlsi_condenser_expand(work->condenser, work->z, b, error);
}

/* (MR5) */
static dls_status reduction_estimate(dls_mpi_reduction *work, dls_error *error) {
  const size_t n = (size_t)work->n;
  const dlsi_scales scales = dlsi_condenser_scales(work->condenser);
  unsigned long long seed = 1; /* equal vectors each time */
  double *b = work->b, found[2] = {0, 0};
  for (size_t i = 0; b && i < n; i++) {
    seed = seed * 6364136223846793005u + 1442695040888963407u;
    b[i] = (seed >> 63 ? 1 : -1) / scales.all_rows[i];
  }
  const dls_status status = reduction_solve(work, b, error);
  if (status) return status;
  if (b) {
    size_t worst = 0;
    for (size_t i = 0; i < n; i++) {
      b[i] /= scales.all_cols[i];
      if (fabs(b[i]) > fabs(b[worst])) worst = i;
    }
    found[0] = 1 / (scales.norm * dlsi_norm2(b, n));
    found[1] = (double)worst;
  }
  (void)MPI_Bcast(found, 2, MPI_DOUBLE, 0, work->grid.all);
  if (found[0] >= 10 * DBL_EPSILON) return DLS_OK; /* false for NaN */
  return dlsi_fail(error, DLS_E_SINGULAR, "Ks", (long long)found[1], found[0],
                   "singular: condition %.3g (scaled)", 1 / found[0]);
}

static dls_status reduction_allocate(dls_mpi_reduction *work, dls_error *error) {
  const size_t m = (size_t)work->m, n = (size_t)work->n;
  const int root = work->grid.rank == 0;
  dls_status status = dlsi_spread_create(&work->on_kept, &work->grid, work->count, error);
  if (!status) status = dlsi_spread_create(&work->on_W, &work->grid, work->m, error);
  work->q = calloc(2 * m + (size_t)work->count + 1, sizeof *work->q);
  if (root) work->f = calloc(2 * n + 1, sizeof *work->f);
  if (!status && (!work->q || (root && !work->f))) status = dlsi_no_memory(error);
  status = dlsi_agree(work->grid.all, status, error);
  if (status) return status;
  work->local = work->q + m;
  work->z = work->local + m;
  if (root) work->b = work->f + n;
  return DLS_OK;
}

static dls_status reduction_build(dls_mpi_reduction *work, const dls_mpi_model *model,
                                  double memory_limit, dls_error *error) {
  dls_mpi_info *info = &work->info;
  dls_status status = reduction_number(work, model, error);
  if (!status)
    status = dlsi_agree(work->grid.all, model_check_entries(model, work->n, error), error);
  if (!status) status = reduction_take_H(work, model, error);
  if (!status) status = reduction_allocate(work, error);
  if (status) return status;
  work->symmetric = model->factorization != DLS_LU;
  status = dlsi_condenser_create(&work->condenser, &work->grid, work->n, model, memory_limit,
                                 work->count, work->keep, &work->on_kept, &work->Z, info, error);
  dlsi_mpi_clock from = dlsi_mpi_now();
  if (!status) status = reduction_invert(work, model->factorization == DLS_CHOLESKY, error);
  dlsi_mpi_clock now = dlsi_mpi_now();
  info->wall[DLS_MPI_INVERT] = now.wall - from.wall;
  info->cpu[DLS_MPI_INVERT] = now.cpu - from.cpu;
  if (!status) status = reduction_estimate(work, error);
  from = dlsi_mpi_now();
  if (!status) status = reduction_form(work, error);
  now = dlsi_mpi_now();
  info->wall[DLS_MPI_FORM] = now.wall - from.wall;
  info->cpu[DLS_MPI_FORM] = now.cpu - from.cpu;
  info->ranks = work->grid.ranks;
  info->rank = work->grid.rank;
  info->grid[0] = work->grid.rows;
  info->grid[1] = work->grid.cols;
  info->n = work->n;
  info->condensed = work->count;
  info->m = work->m;
  info->dense_bytes = (double)sizeof(double) *
                      (double)(dlsi_spread_size(&work->on_kept) + dlsi_spread_size(&work->on_W));
  return status;
}

static dls_status reduction_create(dls_mpi_reduction **out, MPI_Comm comm,
                                   const dls_mpi_model *model,
                                   const dls_reduction_settings *settings, dls_error *error) {
  dls_reduction_settings s;
  dls_reduction_settings_init(&s);
  if (settings) s = *settings;
  dls_mpi_reduction *work = calloc(1, sizeof *work);
  dls_status status = model_check_size(model, error);
  if (!status) status = settings_check(&s, error);
  if (!status && !out) status = dlsi_is_null(error, "out");
  if (!status && !work) status = dlsi_no_memory(error);
  status = dlsi_agree(comm, status, error);
  if (status || !work || !out) {
    free(work);
    return status;
  }
  status = dlsi_grid_open(&work->grid, comm, error);
  if (!status) {
    double limit = s.memory_limit;
    (void)MPI_Bcast(&limit, 1, MPI_DOUBLE, 0, work->grid.all);
    status = reduction_build(work, model, limit, error);
  }
  if (status)
    dls_mpi_reduction_destroy(work);
  else
    *out = work;
  return status;
}

dls_status dls_mpi_reduction_create(dls_mpi_reduction **out, MPI_Comm comm,
                                    const dls_mpi_model *model,
                                    const dls_reduction_settings *settings, dls_error *error) {
  DLSI_DOOR;
  dls_error why = {0};
  if (out) *out = NULL;
  if (comm == MPI_COMM_NULL) {
    (void)dlsi_fail(&why, DLS_E_ARGUMENT, "comm", -1, 0, "is MPI_COMM_NULL");
    if (error) *error = why;
    return dlsi_at(__func__, DLS_E_ARGUMENT, error);
  }
  const dls_status status = reduction_create(out, comm, model, settings, &why);
  if (status && error) *error = why;
  return dlsi_at(__func__, status, error);
}

/* ---- load, contact, recover, destroy --------------------------------------------------------- */

void dlsi_mpi_gather_nodes(const dls_mpi_reduction *work, const double *own, double *all) {
  (void)MPI_Allgatherv(own, work->d * work->own, MPI_DOUBLE, all, work->node_counts,
                       work->node_starts, MPI_DOUBLE, work->grid.all);
}

/* Checks a vector of this rank; NULL is as good as zeros where `optional`. */
static dls_status share_check(const char *argument, const double *x, int count, int optional,
                              dls_error *error) {
  if (count == 0 || (!x && optional)) return DLS_OK;
  return dlsi_check_vector(argument, x, (size_t)count, error);
}

/* all (n, on rank 0) := the shares of all ranks, zeros for NULL. own: as long as the share. */
static void share_collect(dls_mpi_reduction *work, const double *own, double *all) {
  static const double nothing = 0;
  const MPI_Comm comm = work->grid.all;
  const int count = own ? work->rows : 0;
  /* a rank without f says so by a share of length 0 */
  if (work->grid.rank) {
    (void)MPI_Send(&count, 1, MPI_INT, 0, 0, comm);
    if (count) (void)MPI_Send(own, count, MPI_DOUBLE, 0, 0, comm);
    return;
  }
  memset(all, 0, (size_t)work->n * sizeof *all);
  memcpy(all, own ? own : &nothing, (size_t)count * sizeof *all);
  for (int k = 1; k < work->grid.ranks; k++) {
    int size;
    (void)MPI_Recv(&size, 1, MPI_INT, k, 0, comm, MPI_STATUS_IGNORE);
    if (size)
      (void)MPI_Recv(all + work->row_starts[k], size, MPI_DOUBLE, k, 0, comm, MPI_STATUS_IGNORE);
  }
}

static dls_status reduction_load(dls_mpi_reduction *work, const double *f, const double *g,
                                 dls_error *error) {
  const size_t m = (size_t)work->m;
  const MPI_Comm all = work->grid.all;
  const int own = work->d * work->own;
  dls_status status = share_check("f", f, work->rows, 1, error);
  if (!status) status = share_check("g", g, own, 1, error);
  double *mine = status ? NULL : calloc((size_t)own + 1, sizeof *mine);
  if (!status && !mine) status = dlsi_no_memory(error);
  status = dlsi_agree(all, status, error);
  if (!status) {
    if (g && own) memcpy(mine, g, (size_t)own * sizeof *mine);
    dlsi_mpi_gather_nodes(work, mine, work->local);
    share_collect(work, f, work->b);
    status = dlsi_condenser_condense(work->condenser, work->b, work->z, error);
  }
  free(mine);
  if (status) return status;
  share_collect(work, f, work->f);
  if (work->count)
    dlsi_spread_multiply(&work->on_kept, work->Z, work->symmetric, 0, work->z, work->z);
  for (size_t j = 0; j < m; j++) { /* (MR6) */
    work->q[j] = work->local[j];
    for (int e = work->H.p[j]; e < work->H.p[j + 1]; e++)
      work->q[j] += work->H.x[e] * work->z[work->H.i[e]];
  }
  return DLS_OK;
}

dls_status dls_mpi_reduction_load(dls_mpi_reduction *reduction, const double *f, const double *g,
                                  dls_error *error) {
  DLSI_DOOR;
  dls_error why = {0};
  const dls_status status =
      reduction ? reduction_load(reduction, f, g, &why) : dlsi_is_null(&why, "reduction");
  if (status && error) *error = why;
  return dlsi_at(__func__, status, error);
}

dls_status dls_mpi_reduction_contact(const dls_mpi_reduction *reduction, dls_mpi_contact *problem,
                                     dls_error *error) {
  DLSI_DOOR;
  if (!reduction) return dlsi_at(__func__, dlsi_is_null(error, "reduction"), error);
  if (!problem) return dlsi_at(__func__, dlsi_is_null(error, "problem"), error);
  const dlsi_spread *s = &reduction->on_W;
  *problem = (dls_mpi_contact){.d = reduction->d,
                               .nc = reduction->nodes,
                               .m = reduction->m,
                               .block = dlsi_cyclic_block,
                               .rows = s->rows,
                               .cols = s->cols,
                               .row = s->row,
                               .col = s->col,
                               .W = reduction->W,
                               .q = reduction->q};
  return DLS_OK;
}

dls_status dls_mpi_reduction_get_info(const dls_mpi_reduction *reduction, dls_mpi_info *info,
                                      dls_error *error) {
  DLSI_DOOR;
  if (!reduction) return dlsi_at(__func__, dlsi_is_null(error, "reduction"), error);
  if (!info) return dlsi_at(__func__, dlsi_is_null(error, "info"), error);
  *info = reduction->info;
  return DLS_OK;
}

/* Puts the column `values` of rank k's share into W. */
static void gather_place(const dls_mpi_reduction *work, int k, int local, const double *values,
                         double *W) {
  const dlsi_grid *grid = &work->grid;
  const int nb = dlsi_cyclic_block, pr = k / grid->cols, pc = k % grid->cols;
  const size_t m = (size_t)work->m;
  const int column = (local / nb * grid->cols + pc) * nb + local % nb;
  for (int at = 0;; at++) {
    const int row = (at / nb * grid->rows + pr) * nb + at % nb;
    if (row >= work->m) return;
    W[(size_t)row + m * (size_t)column] = values[at];
  }
}

/* Sends each column of a share to rank 0. column: scratch on rank 0, m. */
static void reduction_gather(const dls_mpi_reduction *work, double *column, double *W) {
  const dlsi_grid *grid = &work->grid;
  const dlsi_spread *s = &work->on_W;
  const int nb = dlsi_cyclic_block;
  for (int j = 0; j < s->cols; j++) {
    double *a = work->W + (size_t)j * (size_t)s->rows;
    if (grid->rank)
      (void)MPI_Send(a, s->rows, MPI_DOUBLE, 0, 0, grid->all);
    else
      gather_place(work, 0, j, a, W);
  }
  for (int k = 1; grid->rank == 0 && k < grid->ranks; k++) {
    const int block_column = k % grid->cols;
    for (int b = block_column, local = 0; b * nb < work->m; b += grid->cols)
      for (int i = 0; i < nb && b * nb + i < work->m; i++, local++) {
        (void)MPI_Recv(column, work->m, MPI_DOUBLE, k, 0, grid->all, MPI_STATUS_IGNORE);
        gather_place(work, k, local, column, W);
      }
  }
}

dls_status dls_mpi_reduction_gather(const dls_mpi_reduction *reduction, double *W,
                                    dls_error *error) {
  DLSI_DOOR;
  dls_error why = {0};
  if (!reduction) return dlsi_at(__func__, dlsi_is_null(error, "reduction"), error);
  const int root = reduction->grid.rank == 0;
  double *column = root ? dlsi_alloc((size_t)reduction->m, sizeof *column) : NULL;
  dls_status status = root && !W ? dlsi_is_null(&why, "W") : DLS_OK;
  if (!status && root && !column) status = dlsi_no_memory(&why);
  status = dlsi_agree(reduction->grid.all, status, &why);
  if (!status) reduction_gather(reduction, column, W);
  free(column);
  if (status && error) *error = why;
  return dlsi_at(__func__, status, error);
}

static dls_status reduction_recover(dls_mpi_reduction *work, const double *r, double *x,
                                    dls_error *error) {
  const int root = work->grid.rank == 0, own = work->d * work->own;
  static const double nothing = 0;
  dls_status status = share_check("r", r, own, 0, error);
  if (!status && !x && work->rows) status = dlsi_is_null(error, "x");
  status = dlsi_agree(work->grid.all, status, error);
  if (status) return status;
  dlsi_mpi_gather_nodes(work, own ? r : &nothing, work->local);
  if (root) {
    memcpy(work->b, work->f, (size_t)work->n * sizeof *work->b);
    for (int j = 0; j < work->m; j++)
      for (int e = work->H.p[j]; e < work->H.p[j + 1]; e++)
        work->b[work->keep[work->H.i[e]]] += work->H.x[e] * work->local[j];
  }
  status = reduction_solve(work, work->b, error); /* (MR7) */
  if (!status)
    (void)MPI_Scatterv(work->b, work->row_counts, work->row_starts, MPI_DOUBLE, x, work->rows,
                       MPI_DOUBLE, 0, work->grid.all);
  return status;
}

dls_status dls_mpi_reduction_recover(dls_mpi_reduction *reduction, const double *r, double *x,
                                     dls_error *error) {
  DLSI_DOOR;
  dls_error why = {0};
  const dls_status status =
      reduction ? reduction_recover(reduction, r, x, &why) : dlsi_is_null(&why, "reduction");
  if (status && error) *error = why;
  return dlsi_at(__func__, status, error);
}

void dls_mpi_reduction_destroy(dls_mpi_reduction *reduction) {
  if (!reduction) return;
  dlsi_condenser_destroy(reduction->condenser);
  dlsi_columns_free(&reduction->H);
  dlsi_columns_free(&reduction->Ht);
  dlsi_spread_free(&reduction->on_kept);
  dlsi_spread_free(&reduction->on_W);
  dlsi_grid_close(&reduction->grid);
  void *const owned[] = {reduction->row_counts, reduction->keep, reduction->Z, reduction->W,
                         reduction->A,          reduction->q,    reduction->f, reduction};
  for (size_t k = 0; k < sizeof owned / sizeof owned[0]; k++)
    free(owned[k]);
}
