/*
 * grid.c: the ranks as a grid of pr x pc processes, and square matrices spread on it in blocks of
 * 64 rows and columns, block (I, J) on process (I mod pr, J mod pc), as ScaLAPACK has them.
 *
 *   multiply  (GR1)  every rank has all of x and multiplies its share
 *             (GR2)  the shares are summed on rank 0, and the sum goes to all: one order of
 *                    summation, equal bits on each rank, so that no two ranks branch differently in
 *                    an iteration. (MPI_Allreduce promises that only as advice to implementors.)
 *   invert    (GR3)  pdpotrf, pdpotri; or pdgetrf, pdgetri. An inverse, not a factor: its product
 *                    with a vector takes one message per rank, triangular solves one per block.
 *
 * Of a symmetric matrix only the lower triangle is read: half of the memory traffic, which decides
 * the time of a product. pr is the largest divisor of the number of ranks up to its root.
 */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "linear/blas.h"
#include "mpi_internal.h"
#include "scalapack.h"

static const int one = 1, zero = 0;

/* ---- the grid -------------------------------------------------------------------------------- */

static void join_most(void *from, void *to, int *count, MPI_Datatype *type) {
  const double *x = from;
  double *y = to;
  (void)type;
  for (int k = 0; k < *count; k++)
    if (x[k] > y[k] || x[k] != x[k]) y[k] = x[k];
}

static void join_norm(void *from, void *to, int *count, MPI_Datatype *type) {
  const double *x = from;
  double *y = to;
  (void)type;
  for (int k = 0; k < *count; k++)
    y[k] = hypot(x[k], y[k]);
}

void dlsi_grid_join(const dlsi_grid *grid, dlsi_how how, double *x, size_t count) {
  const MPI_Op op = how == DLSI_SUM ? MPI_SUM : how == DLSI_MOST ? grid->most : grid->norm;
  if (grid->ranks == 1) return;
  (void)MPI_Reduce(grid->rank ? x : MPI_IN_PLACE, x, (int)count, MPI_DOUBLE, op, 0, grid->all);
  (void)MPI_Bcast(x, (int)count, MPI_DOUBLE, 0, grid->all);
}

dls_status dlsi_grid_open(dlsi_grid *grid, MPI_Comm comm, dls_error *error) {
  *grid = (dlsi_grid){.all = MPI_COMM_NULL, .row = MPI_COMM_NULL, .column = MPI_COMM_NULL};
  if (MPI_Comm_dup(comm, &grid->all))
    return dlsi_fail(error, DLS_E_ARGUMENT, "comm", -1, 0, "cannot be duplicated");
  (void)MPI_Comm_rank(grid->all, &grid->rank);
  (void)MPI_Comm_size(grid->all, &grid->ranks);
  for (int k = 1; k * k <= grid->ranks; k++)
    if (grid->ranks % k == 0) grid->rows = k;
  grid->cols = grid->ranks / grid->rows;
  grid->my_row = grid->rank / grid->cols;
  grid->my_col = grid->rank % grid->cols;
  (void)MPI_Comm_split(grid->all, grid->my_row, grid->my_col, &grid->row);
  (void)MPI_Comm_split(grid->all, grid->my_col, grid->my_row, &grid->column);
  grid->handle = Csys2blacs_handle(grid->all);
  grid->context = grid->handle;
  Cblacs_gridinit(&grid->context, "R", grid->rows, grid->cols);
  (void)MPI_Op_create(join_most, 1, &grid->most);
  (void)MPI_Op_create(join_norm, 1, &grid->norm);
  grid->open = 1;
  return DLS_OK;
}

void dlsi_grid_close(dlsi_grid *grid) {
  if (grid->open) {
    Cblacs_gridexit(grid->context);
    Cfree_blacs_system_handle(grid->handle);
    (void)MPI_Op_free(&grid->most);
    (void)MPI_Op_free(&grid->norm);
    (void)MPI_Comm_free(&grid->row);
    (void)MPI_Comm_free(&grid->column);
    (void)MPI_Comm_free(&grid->all);
  }
  grid->open = 0;
}

/* ---- matrices on it -------------------------------------------------------------------------- */

/* index (count) := the numbers of the rows of process p of P. */
static void spread_number(int *index, int count, int p, int P) {
  const int nb = dlsi_cyclic_block;
  for (int l = 0; l < count; l++)
    index[l] = (l / nb * P + p) * nb + l % nb;
}

dls_status dlsi_spread_create(dlsi_spread *s, const dlsi_grid *grid, int n, dls_error *error) {
  const int nb = dlsi_cyclic_block;
  *s = (dlsi_spread){.grid = grid, .n = n};
  s->rows = numroc_(&n, &nb, &grid->my_row, &zero, &grid->rows);
  s->cols = numroc_(&n, &nb, &grid->my_col, &zero, &grid->cols);
  const size_t both = (size_t)s->rows + (size_t)s->cols;
  s->row = dlsi_alloc(both, sizeof *s->row);
  s->x = dlsi_alloc(2 * both + (size_t)n, sizeof *s->x);
  if (!s->row || !s->x) return dlsi_no_memory(error);
  s->col = s->row + s->rows;
  s->y = s->x + both;
  s->all = s->y + both;
  spread_number(s->row, s->rows, grid->my_row, grid->rows);
  spread_number(s->col, s->cols, grid->my_col, grid->cols);
  const int ld = s->rows > 0 ? s->rows : 1;
  int info = 0;
  if (n > 0) descinit_(s->desc, &n, &n, &nb, &nb, &zero, &zero, &grid->context, &ld, &info);
  return DLS_OK;
}

void dlsi_spread_free(dlsi_spread *s) {
  free(s->row);
  free(s->x);
  *s = (dlsi_spread){0};
}

/* Adds to a symmetric product the terms of columns j0 .. j0 + width - 1 of the share, which are one
 * block. y: sums by rows, then by columns of the share. */
static void spread_block(const dlsi_spread *s, const double *A, int j0, int width, int first) {
  const int nb = dlsi_cyclic_block, own = s->col[j0] / nb, rows = s->rows;
  int i = first; /* of the first block on or below the diagonal */
  const double *x_rows = s->x, *x_cols = s->x + rows, plain = 1;
  double *y_rows = s->y, *y_cols = s->y + rows;
  if (i < rows && s->row[i] / nb == own) { /* the block on the diagonal */
    for (int j = 0; j < width; j++) {
      const double *a = A + (size_t)(j0 + j) * (size_t)rows + i;
      y_rows[i + j] += a[j] * x_cols[j0 + j];
      for (int k = j + 1; k < width; k++) {
        y_rows[i + k] += a[k] * x_cols[j0 + j];
        y_cols[j0 + j] += a[k] * x_rows[i + k];
      }
    }
    i += width;
  }
  const int below = rows - i;
  if (below <= 0) return;
  const double *a = A + (size_t)j0 * (size_t)rows + i;
  dgemv_("N", &below, &width, &plain, a, &rows, x_cols + j0, &one, &plain, y_rows + i, &one, 1);
  dgemv_("T", &below, &width, &plain, a, &rows, x_rows + i, &one, &plain, y_cols + j0, &one, 1);
}

static void spread_symmetric(const dlsi_spread *s, const double *A) {
  const int nb = dlsi_cyclic_block;
  int first = 0;
  for (int j = 0; j < s->cols; j += nb) {
    const int width = s->cols - j < nb ? s->cols - j : nb;
    while (first < s->rows && s->row[first] / nb < s->col[j] / nb)
      first++;
    spread_block(s, A, j, width, first);
  }
}

/* Sums |a_ij| |x_j|. */
static void spread_magnitudes(const dlsi_spread *s, const double *A, int symmetric) {
  const double *x_rows = s->x, *x_cols = s->x + s->rows;
  double *y_rows = s->y, *y_cols = s->y + s->rows;
  int first = 0;
  for (int j = 0; j < s->cols; j++) {
    const double *a = A + (size_t)j * (size_t)s->rows, x = fabs(x_cols[j]);
    while (symmetric && first < s->rows && s->row[first] < s->col[j])
      first++;
    for (int i = first; i < s->rows; i++) {
      const double size = fabs(a[i]);
      y_rows[i] += size * x;
      if (symmetric && s->row[i] > s->col[j]) y_cols[j] += size * fabs(x_rows[i]);
    }
  }
}

void dlsi_spread_multiply(const dlsi_spread *s, const double *A, int symmetric, int magnitudes,
                          const double *x, double *y) {
  const int rows = s->rows, cols = s->cols;
  const double plain = 1, none = 0;
  for (int i = 0; i < rows; i++)
    s->x[i] = x[s->row[i]];
  for (int j = 0; j < cols; j++)
    s->x[rows + j] = x[s->col[j]];
  memset(s->y, 0, (size_t)(rows + cols) * sizeof *s->y);
  if (magnitudes) /* (GR1) */
    spread_magnitudes(s, A, symmetric);
  else if (symmetric)
    spread_symmetric(s, A);
  else if (rows > 0 && cols > 0)
    dgemv_("N", &rows, &cols, &plain, A, &rows, s->x + rows, &one, &none, s->y, &one, 1);
  memset(s->all, 0, (size_t)s->n * sizeof *s->all);
  for (int i = 0; i < rows; i++)
    s->all[s->row[i]] += s->y[i];
  for (int j = 0; j < cols; j++)
    s->all[s->col[j]] += s->y[rows + j];
  const MPI_Comm comm = s->grid->all; /* (GR2) */
  (void)MPI_Reduce(s->all, y, s->n, MPI_DOUBLE, MPI_SUM, 0, comm);
  (void)MPI_Bcast(y, s->n, MPI_DOUBLE, 0, comm);
}

/* Inverts by LU. Returns as dlsi_spread_invert. */
static int spread_invert_lu(const dlsi_spread *s, double *A) {
  int info = 0, ask = -1, integer = 0, lwork, have;
  double best = 0;
  pdgetri_(&s->n, A, &one, &one, s->desc, &integer, &best, &ask, &integer, &ask, &info);
  lwork = (int)best + 1;
  int *pivot = dlsi_alloc((size_t)s->rows + dlsi_cyclic_block, sizeof *pivot);
  int *numbers = dlsi_alloc((size_t)integer + 1, sizeof *numbers);
  double *work = dlsi_alloc((size_t)lwork, sizeof *work);
  const int mine = pivot && numbers && work;
  (void)MPI_Allreduce(&mine, &have, 1, MPI_INT, MPI_MIN, s->grid->all);
  if (have) {
    const int liwork = integer + 1;
    pdgetrf_(&s->n, &s->n, A, &one, &one, s->desc, pivot, &info);
    if (!info)
      pdgetri_(&s->n, A, &one, &one, s->desc, pivot, work, &lwork, numbers, &liwork, &info);
  }
  free(work);
  free(numbers);
  free(pivot);
  return have ? info : -1;
}

int dlsi_spread_invert(const dlsi_spread *s, double *A, int symmetric) {
  int info = 0, worst;
  if (s->n == 0) return 0;
  if (symmetric) {
    pdpotrf_("L", &s->n, A, &one, &one, s->desc, &info);
    if (!info) pdpotri_("L", &s->n, A, &one, &one, s->desc, &info);
  } else
    info = spread_invert_lu(s, A);
  if (info < 0) return -1;
  (void)MPI_Allreduce(&info, &worst, 1, MPI_INT, MPI_MAX, s->grid->all);
  return worst;
}

void dlsi_spread_add_transpose(const dlsi_spread *s, const double *A, double *C) {
  const double plain = 1;
  if (s->n > 0)
    pdtran_(&s->n, &s->n, &plain, A, &one, &one, s->desc, &plain, C, &one, &one, s->desc);
}
