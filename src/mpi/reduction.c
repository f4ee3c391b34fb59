/*
 * reduction.c: K, H -> W, q and back to x, on several ranks.
 *
 *   create  (MR1)  the model as the ranks have it (shares.c), its certificate (body.c)
 *           (MR2)  S, the Schur complement of K on the unknowns c that H touches (condense.c)
 *           (MR3)  Z := S^-1 = (K^-1)_cc (grid.c)
 *           (MR4)  W := H_c^T Z H_c; of a symmetric Z = L + L^T, L its lower triangle with half of
 *                  the diagonal, W := V + V^T, V := H_c^T L H_c
 *           (MR5)  |A^-1|_F from one solve with a vector of +-1: singular if 1 / (|A|_1 |A^-1|_F)
 *                  < 10 eps, as in linear/schur.c
 *   load    (MR6)  q := H_c^T (K^-1 f)_c + g
 *   recover (MR7)  x := K^-1 (f + H r)
 *
 * (MR4) goes by block columns: each rank multiplies its share of Z by the columns of H (one or few
 * entries each); process rows sum these panels on the process column that owns the block; that
 * column multiplies by H^T and sums. Cost: b^3 and (MR4) m b (entries of a column of H) over the
 * ranks, b^2 / pr + m^2 / pc numbers sent by each.
 */
#include <float.h>
#include <limits.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "mpi_internal.h"

/* ---- create: W ------------------------------------------------------------------------------- */

static dls_status settings_check(const dls_reduction_settings *s, dls_error *error) {
  if (s->size != sizeof *s)
    return dlsi_fail(error, DLS_E_SETTINGS, "settings", -1, 0, "not initialised");
  if (!(s->memory_limit >= 0 && s->memory_limit <= DBL_MAX))
    return dlsi_fail(error, DLS_E_ARGUMENT, "memory_limit", -1, s->memory_limit,
                     "is %g, must be finite and at least 0", s->memory_limit);
  if (!s->form_W) return dlsi_fail(error, DLS_E_UNSUPPORTED, "form_W", -1, 0, "on one rank");
  return DLS_OK;
}

/* Returns the place in the share of row (column) k of process p of P, -1 if it is not there. */
static int reduction_place(int k, int p, int P) {
  const int nb = dlsi_cyclic_block, block = k / nb;
  return block % P == p ? block / P * nb + k % nb : -1;
}

/* Y(:, l - j0) := the share of Z H(:,l), of L H(:,l) if Z is symmetric, l = j0 .. j1 - 1. */
static void form_right(const dls_mpi_reduction *work, int j0, int j1, double *Y) {
  const dlsi_spread *s = &work->on_kept;
  const size_t rows = (size_t)s->rows;
  memset(Y, 0, rows * (size_t)(j1 - j0) * sizeof *Y);
  for (int l = j0; l < j1; l++)
    for (int e = work->of.H.p[l]; e < work->of.H.p[l + 1]; e++) {
      const int k = work->of.H.i[e],
                at = reduction_place(k, work->of.grid.my_col, work->of.grid.cols);
      if (at < 0) continue;
      const double h = work->of.H.x[e], *a = work->Z + (size_t)at * rows;
      double *y = Y + (size_t)(l - j0) * rows;
      for (size_t i = 0; i < rows; i++) {
        const double part = !work->of.symmetric || s->row[i] > k ? 1 : s->row[i] == k ? 0.5 : 0;
        if (part > 0) y[i] += part * h * a[i];
      }
    }
}

/* T(:, l) := the share of H^T Y(:, l), width columns. T: m x width. */
static void form_left(const dls_mpi_reduction *work, int width, const double *Y, double *T) {
  const dlsi_spread *s = &work->on_kept;
  const size_t m = (size_t)work->of.m, rows = (size_t)s->rows;
  memset(T, 0, m * (size_t)width * sizeof *T);
  for (size_t l = 0; l < (size_t)width; l++)
    for (size_t i = 0; i < rows; i++)
      for (int e = work->of.Ht.p[s->row[i]]; e < work->of.Ht.p[s->row[i] + 1]; e++)
        T[m * l + (size_t)work->of.Ht.i[e]] += work->of.Ht.x[e] * Y[rows * l + i];
}

/* (MR4) V: receives the share of H^T L H, or of W if Z is not symmetric. Y, T: scratch. */
static void form_panels(const dls_mpi_reduction *work, double *Y, double *T, double *V) {
  const dlsi_grid *grid = &work->of.grid;
  const dlsi_spread *s = &work->on_W;
  const int nb = dlsi_cyclic_block, m = work->of.m, rows = work->on_kept.rows;
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
  double *V = work->of.symmetric ? dlsi_alloc(size, sizeof *V) : NULL;
  double *T = dlsi_alloc((size_t)work->of.m + (size_t)work->on_kept.rows, nb * sizeof *T);
  work->W = dlsi_alloc(size, sizeof *work->W);
  dls_status status = T && work->W && (V || !work->of.symmetric) ? DLS_OK : dlsi_no_memory(error);
  status = dlsi_agree(work->of.grid.all, status, error);
  if (!status) {
    form_panels(work, T + nb * (size_t)work->of.m, T, work->W);
    if (work->of.symmetric) {
      memcpy(V, work->W, size * sizeof *V);
      dlsi_spread_add_transpose(&work->on_W, V, work->W);
    }
    const long long bad = dlsi_first_not_finite(work->W, size);
    if (bad >= 0) status = dlsi_fail(error, DLS_E_NOT_FINITE, "W", -1, work->W[bad], "overflow");
    status = dlsi_agree(work->of.grid.all, status, error);
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
  if (work->of.symmetric && !definite) { /* LU takes both triangles: (lower) + (lower)^T */
    full = dlsi_alloc(dlsi_spread_size(s), sizeof *full);
    status = dlsi_agree(work->of.grid.all, full ? DLS_OK : dlsi_no_memory(error), error);
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
                     work->of.keep[failed - 1], 0,
                     definite ? "not positive definite: a pivot <= 0" : "singular: a pivot of 0");
  for (int j = 0; j < s->cols; j++)
    for (int i = 0; i < s->rows; i++)
      work->Z[(size_t)i + (size_t)j * (size_t)s->rows] *=
          scales.col[s->row[i]] * scales.row[s->col[j]];
  return DLS_OK;
}

/* Solves b := K^-1 b. b: rows. */
static dls_status reduction_solve(dls_mpi_reduction *work, double *b, dls_error *error) {
  dls_status status = dlsi_condenser_condense(work->condenser, b, work->z, error);
  if (status) return status;
  if (work->of.count)
    dlsi_spread_multiply(&work->on_kept, work->Z, work->of.symmetric, 0, work->z, work->z);
  return dlsi_condenser_expand(work->condenser, work->z, b, error);
}

/* (MR5) */
static dls_status reduction_estimate(dls_mpi_reduction *work, dls_error *error) {
  const dlsi_shares *of = &work->of;
  const dlsi_scales scales = dlsi_condenser_scales(work->condenser);
  struct {
    double size;
    int at;
  } worst = {-1, 0};
  double *b = work->b;
  dlsi_shares_signs(of, scales.own_rows, b);
  const dls_status status = reduction_solve(work, b, error);
  if (status) return status;
  for (int i = 0; i < of->rows; i++) {
    b[i] /= scales.own_cols[i];
    if (!(fabs(b[i]) > worst.size)) continue;
    worst.size = fabs(b[i]);
    worst.at = of->first_row + i;
  }
  const double found = 1 / (scales.norm * dlsi_joined_norm(&of->ranks, b, (size_t)of->rows));
  (void)MPI_Allreduce(MPI_IN_PLACE, &worst, 1, MPI_DOUBLE_INT, MPI_MAXLOC, of->grid.all);
  work->condition = 1 / found;
  if (found >= 10 * DBL_EPSILON) return DLS_OK; /* false for NaN */
  return dlsi_fail(error, DLS_E_SINGULAR, "Ks", worst.at, found,
                   "singular: condition %.3g (scaled)", 1 / found);
}

static dls_status reduction_allocate(dls_mpi_reduction *work, dls_error *error) {
  const size_t m = (size_t)work->of.m, rows = (size_t)work->of.rows;
  dls_status status = dlsi_spread_create(&work->on_kept, &work->of.grid, work->of.count, error);
  if (!status) status = dlsi_spread_create(&work->on_W, &work->of.grid, work->of.m, error);
  work->q = calloc(3 * m + (size_t)work->of.count + 1, sizeof *work->q);
  work->f = calloc(2 * rows + 1, sizeof *work->f);
  if (!status && (!work->q || !work->f)) status = dlsi_no_memory(error);
  status = dlsi_agree(work->of.grid.all, status, error);
  if (status) return status;
  work->gap = work->q + m;
  work->local = work->gap + m;
  work->z = work->local + m;
  work->b = work->f + rows;
  return DLS_OK;
}

static dls_status reduction_build(dls_mpi_reduction *work, MPI_Comm comm,
                                  const dls_mpi_model *model,
                                  const dls_reduction_settings *settings, dls_error *error) {
  dls_mpi_info *info = &work->info;
  double memory_limit = settings->memory_limit;
  dls_status status = dlsi_shares_create(&work->of, comm, model, error); /* (MR1) */
  if (!status) status = dlsi_mpi_body_create(&work->body, &work->of, model, error);
  if (!status) status = reduction_allocate(work, error);
  if (status) return status;
  (void)MPI_Bcast(&memory_limit, 1, MPI_DOUBLE, 0, work->of.grid.all);
  status = dlsi_condenser_create(&work->condenser, &work->of, model, memory_limit, &work->on_kept,
                                 &work->Z, info, error);
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
  info->ranks = work->of.grid.ranks;
  info->rank = work->of.grid.rank;
  info->grid[0] = work->of.grid.rows;
  info->grid[1] = work->of.grid.cols;
  info->n = work->of.n;
  info->condensed = work->of.count;
  info->m = work->of.m;
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
  dls_status status = dlsi_shares_check(model, error);
  if (!status) status = settings_check(&s, error);
  if (!status && !out) status = dlsi_is_null(error, "out");
  if (!status && !work) status = dlsi_no_memory(error);
  status = dlsi_agree(comm, status, error);
  if (status || !work || !out) {
    free(work);
    return status;
  }
  status = reduction_build(work, comm, model, &s, error);
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

static dls_status reduction_load(dls_mpi_reduction *work, const double *f, const double *g,
                                 dls_error *error) {
  const size_t m = (size_t)work->of.m, rows = (size_t)work->of.rows;
  const MPI_Comm all = work->of.grid.all;
  const int own = work->of.d * work->of.own;
  dls_status status = dlsi_shares_check_vector("f", f, work->of.rows, 1, error);
  if (!status) status = dlsi_shares_check_vector("g", g, own, 1, error);
  double *mine = status ? NULL : calloc((size_t)own + 1, sizeof *mine);
  if (!status && !mine) status = dlsi_no_memory(error);
  status = dlsi_agree(all, status, error);
  if (!status) {
    if (g && own) memcpy(mine, g, (size_t)own * sizeof *mine);
    dlsi_shares_gather_nodes(&work->of, mine, work->local);
    for (size_t j = 0; j < rows; j++)
      work->b[j] = f ? f[j] : 0;
    status = dlsi_condenser_condense(work->condenser, work->b, work->z, error);
  }
  free(mine);
  if (status) return status;
  for (size_t j = 0; j < rows; j++)
    work->f[j] = f ? f[j] : 0;
  memcpy(work->gap, work->local, m * sizeof *work->gap);
  if (work->of.count)
    dlsi_spread_multiply(&work->on_kept, work->Z, work->of.symmetric, 0, work->z, work->z);
  for (size_t j = 0; j < m; j++) { /* (MR6) */
    work->q[j] = work->local[j];
    for (int e = work->of.H.p[j]; e < work->of.H.p[j + 1]; e++)
      work->q[j] += work->of.H.x[e] * work->z[work->of.H.i[e]];
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
  *problem = (dls_mpi_contact){.d = reduction->of.d,
                               .nc = reduction->of.nodes,
                               .m = reduction->of.m,
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
  const dlsi_grid *grid = &work->of.grid;
  const int nb = dlsi_cyclic_block, pr = k / grid->cols, pc = k % grid->cols;
  const size_t m = (size_t)work->of.m;
  const int column = (local / nb * grid->cols + pc) * nb + local % nb;
  for (int at = 0;; at++) {
    const int row = (at / nb * grid->rows + pr) * nb + at % nb;
    if (row >= work->of.m) return;
    W[(size_t)row + m * (size_t)column] = values[at];
  }
}

/* Sends each column of a share to rank 0. column: scratch on rank 0, m. */
static void reduction_gather(const dls_mpi_reduction *work, double *column, double *W) {
  const dlsi_grid *grid = &work->of.grid;
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
    for (int b = block_column, local = 0; b * nb < work->of.m; b += grid->cols)
      for (int i = 0; i < nb && b * nb + i < work->of.m; i++, local++) {
        (void)MPI_Recv(column, work->of.m, MPI_DOUBLE, k, 0, grid->all, MPI_STATUS_IGNORE);
        gather_place(work, k, local, column, W);
      }
  }
}

dls_status dls_mpi_reduction_gather(const dls_mpi_reduction *reduction, double *W,
                                    dls_error *error) {
  DLSI_DOOR;
  dls_error why = {0};
  if (!reduction) return dlsi_at(__func__, dlsi_is_null(error, "reduction"), error);
  const int root = reduction->of.grid.rank == 0;
  double *column = root ? dlsi_alloc((size_t)reduction->of.m, sizeof *column) : NULL;
  dls_status status = root && !W ? dlsi_is_null(&why, "W") : DLS_OK;
  if (!status && root && !column) status = dlsi_no_memory(&why);
  status = dlsi_agree(reduction->of.grid.all, status, &why);
  if (!status) reduction_gather(reduction, column, W);
  free(column);
  if (status && error) *error = why;
  return dlsi_at(__func__, status, error);
}

dls_status dlsi_mpi_recover(dls_mpi_reduction *work, const double *r, double *x, dls_error *error) {
  const dlsi_columns *Ht = &work->of.here;
  double *b = work->b;
  for (int j = 0; j < work->of.rows; j++) {
    b[j] = work->f[j];
    for (int e = Ht->p[j]; e < Ht->p[j + 1]; e++)
      b[j] += Ht->x[e] * r[dlsi_halo_number(&work->of.touched, Ht->i[e])];
  }
  const dls_status status = reduction_solve(work, b, error); /* (MR7) */
  if (!status && work->of.rows) memcpy(x, b, (size_t)work->of.rows * sizeof *x);
  return status;
}

dls_status dlsi_mpi_own(dls_mpi_reduction *work, dls_error *error) {
  memcpy(work->b, work->f, (size_t)work->of.rows * sizeof *work->b);
  return reduction_solve(work, work->b, error);
}

static dls_status reduction_recover(dls_mpi_reduction *work, const double *r, double *x,
                                    dls_error *error) {
  const int own = work->of.d * work->of.own;
  static const double nothing = 0;
  dls_status status = dlsi_shares_check_vector("r", r, own, 0, error);
  if (!status && !x && work->of.rows) status = dlsi_is_null(error, "x");
  status = dlsi_agree(work->of.grid.all, status, error);
  if (status) return status;
  dlsi_shares_gather_nodes(&work->of, own ? r : &nothing, work->local);
  return dlsi_mpi_recover(work, work->local, x, error);
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
  dlsi_spread_free(&reduction->on_kept);
  dlsi_spread_free(&reduction->on_W);
  dlsi_mpi_body_free(&reduction->body);
  dlsi_shares_free(&reduction->of);
  void *const owned[] = {reduction->Z, reduction->W, reduction->A,
                         reduction->q, reduction->f, reduction};
  for (size_t k = 0; k < sizeof owned / sizeof owned[0]; k++)
    free(owned[k]);
}
