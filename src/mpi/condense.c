/*
 * condense.c: the Schur complement of a K whose entries are spread over the ranks, by the parallel
 * MUMPS (Amestoy, Duff, L'Excellent, Koster, SIAM J. Matrix Anal. Appl. 23, 2001, 15-41). The steps
 * are those of linear/schur.c:
 *
 *   (MC1)  A = R K C, scaled: the largest entries of the rows and columns over all ranks
 *   (MC2)  rank 0 gathers the pattern, orders it by nested dissection, moves c to the end
 *   (MC3)  analysis, with the entries left in place (ICNTL(18) = 3)
 *   (MC4)  factor; S = A_cc - A_ci A_ii^-1 A_ic stays spread in blocks (ICNTL(19) = 2, 3)
 *   (MC5)  condense, expand: the rows of b and x go to rank 0 and come from there
 *
 * Without c it is the factor of a matrix, for one set of values after another: begin does (MC2) and
 * (MC3), refactor (MC1) and (MC4).
 *
 * MUMPS needs something to eliminate: if H touches every unknown, K gets one unknown more, coupled
 * to nothing, with 1 on the diagonal.
 *
 * Rank 0 holds the pattern for a while: two ints per entry and METIS's graph of the nodes, and two
 * n-vectors. All else is shared. MUMPS itself needs the pattern on one rank.
 * Cost: the ordering is not parallel. Fails: no memory on one rank.
 */
#include <float.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "linear/dense.h"
#include "linear/dissection.h"
#include "linear/mumps.h"
#include "mpi_internal.h"

#define INFO(k)  info[(k)-1]
#define RINFO(k) rinfo[(k)-1]

enum { condense = 1, expand = 2 };        /* ICNTL(26) */
enum { schur_lower = 2, schur_full = 3 }; /* ICNTL(19), by columns */
enum {
  spread_entries = 3,
  scale_turns = 5, /* ICNTL(18); (MC1) */
  relaxation = 20
}; /* ICNTL(14), per cent */

struct dlsi_condenser {
  const dlsi_shares *of;
  const dlsi_grid *grid;
  DMUMPS_STRUC_C mumps;
  int started, symmetric, n, count;
  int more;      /* 1: n counts one unknown more than K has */
  int more_here; /* 1: on this rank, its last entry */
  size_t entries;
  int *row, *col;  /* entries of this rank, counted from 1; gone after create */
  double *x;       /* ... of A */
  dlsi_halo halo;  /* unknowns: rows of this rank, others that these entries touch */
  int *keep;       /* count, counted from 1 */
  int *order;      /* n, on rank 0: place of each unknown, counted from 1; gone after create */
  double *R, *C;   /* of all places; behind them as much scratch */
  double *whole;   /* n, on rank 0: b and x */
  double *kept;    /* R and C on c: 2 count */
  double *reduced; /* count */
  double norm;
};

/* ---- entries and scales ---------------------------------------------------------------------- */

static int condenser_reads(const dlsi_condenser *work, const dls_mpi_model *model, size_t k) {
  return !work->symmetric || model->row[k] >= model->col[k];
}

/* Takes the places of the entries. */
static dls_status condenser_allocate(dlsi_condenser *work, const dls_mpi_model *model,
                                     dls_error *error) {
  const dlsi_shares *of = work->of;
  const size_t b = (size_t)work->count;
  size_t at = 0;
  for (size_t k = 0; k < model->entries; k++)
    work->entries += (size_t)condenser_reads(work, model, k);
  work->more_here = work->more && work->grid->rank == 0;
  work->entries += (size_t)work->more_here;
  work->row = dlsi_alloc(2 * work->entries, sizeof *work->row);
  work->x = dlsi_alloc(work->entries, sizeof *work->x);
  work->keep = dlsi_alloc(b, sizeof *work->keep);
  work->kept = calloc(3 * b + 1, sizeof *work->kept);
  if (work->grid->rank == 0) work->whole = dlsi_alloc((size_t)work->n, sizeof *work->whole);
  dls_status status =
      work->row && work->x && work->keep && work->kept && (work->whole || work->grid->rank)
          ? DLS_OK
          : dlsi_no_memory(error);
  status = dlsi_agree(work->grid->all, status, error);
  if (status) return status;
  work->col = work->row + work->entries;
  work->reduced = work->kept + 2 * b;
  for (size_t k = 0; k < model->entries; k++) {
    if (!condenser_reads(work, model, k)) continue;
    work->row[at] = model->row[k];
    work->col[at++] = model->col[k];
  }
  if (work->more_here) work->row[at] = work->col[at] = of->first_row; /* no ghost */
  const dlsi_entries all = {work->row, work->col, work->entries, 0};
  status = dlsi_halo_create(&work->halo, work->grid, of->row_counts, of->row_starts, &all, error);
  for (size_t k = 0; k < 2 * work->entries; k++)
    work->row[k]++;
  if (work->more_here) work->row[at] = work->col[at] = work->n;
  if (status) return status;
  const size_t places = (size_t)(work->halo.rows + work->halo.ghosts);
  work->R = dlsi_alloc(4 * places, sizeof *work->R);
  work->C = work->R ? work->R + places : NULL;
  return dlsi_agree(work->grid->all, work->R ? DLS_OK : dlsi_no_memory(error), error);
}

static void condenser_take_values(dlsi_condenser *work, const dls_mpi_model *model) {
  size_t at = 0;
  for (size_t k = 0; k < model->entries; k++)
    if (condenser_reads(work, model, k)) work->x[at++] = model->x[k];
  if (work->more_here) work->x[at] = 1;
}

/* Returns the place of a row or column that is counted from 1. */
static size_t condenser_place(const dlsi_condenser *work, int number) {
  return (size_t)dlsi_halo_place(&work->halo, number - 1);
}

/* (MC1) As linear/equilibrate.c. Entries that add up count separately: their sizes, not their sum,
 * are scaled to 1, which keeps scaling exact and symmetric. */
static void condenser_find_scales(dlsi_condenser *work) {
  const size_t places = (size_t)(work->halo.rows + work->halo.ghosts);
  const size_t entries = work->entries - (size_t)work->more_here;
  double *R = work->R, *C = work->C, *rows = C + places,
         *cols = work->symmetric ? rows : rows + places;
  for (size_t i = 0; i < places; i++)
    R[i] = C[i] = 1;
  for (int turn = 0; turn < scale_turns; turn++) {
    memset(rows, 0, 2 * places * sizeof *rows);
    for (size_t k = 0; k < entries; k++) {
      const size_t i = condenser_place(work, work->row[k]), j = condenser_place(work, work->col[k]);
      const double a = fabs(R[i] * work->x[k] * C[j]);
      if (a > rows[i]) rows[i] = a;
      if (a > cols[j]) cols[j] = a;
    }
    dlsi_halo_give(&work->halo, DLSI_MOST, rows);
    if (!work->symmetric) dlsi_halo_give(&work->halo, DLSI_MOST, cols);
    for (int i = 0; i < work->halo.rows; i++) {
      if (rows[i] > 0) R[i] /= sqrt(rows[i]);
      if (cols[i] > 0) C[i] /= sqrt(cols[i]);
    }
    dlsi_halo_fetch(&work->halo, R);
    dlsi_halo_fetch(&work->halo, C);
  }
  for (size_t i = 0; i < places; i++) {
    R[i] = ldexp(1, ilogb(R[i]));
    C[i] = ldexp(1, ilogb(C[i]));
  }
}

/* Scales x and computes |A|_1, or an upper bound if entries add up. DLS_E_NOT_FINITE. */
static dls_status condenser_scale(dlsi_condenser *work, dls_error *error) {
  const size_t places = (size_t)(work->halo.rows + work->halo.ghosts);
  double *sum = work->C + places;
  memset(sum, 0, places * sizeof *sum);
  for (size_t k = 0; k < work->entries - (size_t)work->more_here; k++) {
    const size_t i = condenser_place(work, work->row[k]), j = condenser_place(work, work->col[k]);
    work->x[k] *= work->R[i] * work->C[j];
    sum[j] += fabs(work->x[k]);
    if (work->symmetric && i != j) sum[i] += fabs(work->x[k]);
  }
  dlsi_halo_give(&work->halo, DLSI_SUM, sum);
  work->norm = fmax(work->more, dlsi_max_abs(sum, (size_t)work->halo.rows));
  if (work->norm != work->norm) work->norm = INFINITY;
  dlsi_grid_join(work->grid, DLSI_MOST, &work->norm, 1);
  for (int k = 0; k < work->count; k++) {
    const int i = work->keep[k] - 1 - work->halo.first;
    if (i < 0 || i >= work->halo.rows) continue;
    work->kept[k] = work->R[i];
    work->kept[work->count + k] = work->C[i];
  }
  dlsi_grid_join(work->grid, DLSI_SUM, work->kept, 2 * (size_t)work->count);
  if (work->norm <= DBL_MAX) return DLS_OK; /* false for NaN */
  return dlsi_fail(error, DLS_E_NOT_FINITE, "x", -1, work->norm, "overflow");
}

/* ---- order ----------------------------------------------------------------------------------- */

/* Sends count ints to rank 0, or receives them from rank `from`, in pieces that MPI can count. */
static void condenser_pass(const dlsi_grid *grid, int from, int *x, size_t count) {
  enum { piece = 1 << 28 };
  for (size_t at = 0; at < count; at += piece) {
    const int size = count - at < piece ? (int)(count - at) : piece;
    if (grid->rank)
      (void)MPI_Send(x + at, size, MPI_INT, 0, 0, grid->all);
    else
      (void)MPI_Recv(x + at, size, MPI_INT, from, 0, grid->all, MPI_STATUS_IGNORE);
  }
}

/* Collects row and col of all ranks on rank 0, after its own. */
static void condenser_collect(const dlsi_condenser *work, const unsigned long long *entries,
                              int *row, int *col) {
  const dlsi_grid *grid = work->grid;
  if (grid->rank) {
    condenser_pass(grid, 0, work->row, work->entries);
    condenser_pass(grid, 0, work->col, work->entries);
    return;
  }
  memcpy(row, work->row, work->entries * sizeof *row);
  memcpy(col, work->col, work->entries * sizeof *col);
  size_t at = work->entries;
  for (int k = 1; k < grid->ranks; k++) {
    const size_t more = (size_t)entries[k];
    condenser_pass(grid, k, row + at, more);
    condenser_pass(grid, k, col + at, more);
    at += more;
  }
}

/* Fills order from the sequence of the dissection: c last. */
static void condenser_number(dlsi_condenser *work, const int *sequence) {
  const int n = work->n, b = work->count;
  int turn = 0;
  memset(work->order, 0, (size_t)n * sizeof *work->order);
  for (int k = 0; k < b; k++)
    work->order[work->keep[k] - 1] = n - b + k + 1;
  for (int k = 0; k < n; k++)
    if (work->order[sequence[k]] == 0) work->order[sequence[k]] = ++turn;
}

/* (MC2) */
static dls_status condenser_order(dlsi_condenser *work, dls_error *error) {
  const dlsi_grid *grid = work->grid;
  const int root = grid->rank == 0;
  const unsigned long long mine = work->entries;
  size_t total = 0;
  unsigned long long *entries = dlsi_alloc((size_t)grid->ranks, sizeof *entries);
  int *row = NULL, *sequence = NULL;
  dls_status status = dlsi_agree(grid->all, entries ? DLS_OK : dlsi_no_memory(error), error);
  if (!status) {
    (void)MPI_Gather(&mine, 1, MPI_UNSIGNED_LONG_LONG, entries, 1, MPI_UNSIGNED_LONG_LONG, 0,
                     grid->all);
    for (int k = 0; root && k < grid->ranks; k++)
      total += (size_t)entries[k];
    if (root) {
      row = dlsi_alloc(2 * total, sizeof *row);
      sequence = dlsi_alloc((size_t)work->n, sizeof *sequence);
      work->order = dlsi_alloc((size_t)work->n, sizeof *work->order);
      if (!row || !sequence || !work->order) status = dlsi_no_memory(error);
    }
    status = dlsi_agree(grid->all, status, error);
  }
  if (!status) {
    condenser_collect(work, entries, row, row + total);
    if (root) status = dlsi_dissection(work->n, total, row, row + total, sequence, error);
    if (root && !status) condenser_number(work, sequence);
    status = dlsi_agree(grid->all, status, error);
  }
  free(sequence);
  free(row);
  free(entries);
  return status;
}

/* ---- MUMPS ----------------------------------------------------------------------------------- */

/* (MC3) */
static dls_status condenser_analyse(dlsi_condenser *work, dls_factorization factorization,
                                    dls_error *error) {
  DMUMPS_STRUC_C *M = &work->mumps;
  const dlsi_grid *grid = work->grid;
  const int sym = factorization == DLS_CHOLESKY ? 1 : factorization == DLS_LDLT ? 2 : 0;
  const dls_status status = dlsi_mumps_start(M, sym, (int)MPI_Comm_c2f(grid->all), error);
  if (status) return status;
  work->started = 1;
  M->ICNTL(6) = 0;  /* no exchange of columns before the analysis */
  M->ICNTL(7) = 1;  /* the order is given ... */
  M->ICNTL(28) = 1; /* ... on rank 0 */
  M->ICNTL(8) = 0;  /* (MC1) replaces the scaling of MUMPS */
  M->ICNTL(14) = relaxation;
  M->ICNTL(18) = spread_entries;
  M->n = work->n;
  M->nnz_loc = (MUMPS_INT8)work->entries;
  M->irn_loc = work->row;
  M->jcn_loc = work->col;
  M->a_loc = work->x;
  M->perm_in = work->order;
  if (work->count > 0) {
    M->ICNTL(19) = work->symmetric ? schur_lower : schur_full;
    M->size_schur = work->count;
    M->listvar_schur = work->keep;
    M->nprow = grid->rows;
    M->npcol = grid->cols;
    M->mblock = M->nblock = dlsi_cyclic_block;
  }
  return dlsi_mumps_run(M, analyse, "Ks", error);
}

/* Factors the present values of M. */
static dls_status condenser_eliminate(dlsi_condenser *work, dls_error *error) {
  DMUMPS_STRUC_C *M = &work->mumps;
  const dls_status status = dlsi_mumps_factor(M, "Ks", error);
  if (status || M->sym != 1 || M->INFOG(12) == 0) return status;
  /* MUMPS counts negative pivots but does not return where they are */
  return dlsi_fail(error, DLS_E_NOT_POSITIVE_DEFINITE, "Ks", -1, M->INFOG(12),
                   "K is not positive definite: %d negative pivots", M->INFOG(12));
}

/* (MC4) */
static dls_status condenser_factor(dlsi_condenser *work, const dlsi_spread *spread, double **S,
                                   dls_error *error) {
  DMUMPS_STRUC_C *M = &work->mumps;
  const size_t size = dlsi_spread_size(spread);
  /* MUMPS clears a share without rows as if it had one */
  const size_t room = (size_t)(spread->rows + 1) * (size_t)(spread->cols + 1);
  *S = calloc(room, sizeof **S);
  dls_status status = *S ? DLS_OK : dlsi_no_memory(error);
  if (!status && work->count > 0 &&
      (M->schur_mloc != spread->rows || M->schur_nloc != spread->cols) && size > 0)
    status = dlsi_fail(error, DLS_E_UNSUPPORTED, "", -1, M->schur_mloc,
                       "MUMPS spreads the Schur complement otherwise");
  status = dlsi_agree(work->grid->all, status, error);
  if (status) return status;
  M->schur = *S;
  M->schur_lld = spread->rows > 0 ? spread->rows : 1;
  return condenser_eliminate(work, error);
}

/* Frees what only the factorisation needs. */
static void condenser_shrink(dlsi_condenser *work) {
  DMUMPS_STRUC_C *M = &work->mumps;
  free(work->row);
  free(work->x);
  free(work->order);
  work->row = work->col = work->order = NULL;
  work->x = NULL;
  M->irn_loc = M->jcn_loc = M->perm_in = NULL;
  M->a_loc = NULL;
}

static double condenser_bytes(int megabytes) {
  return megabytes < 0 ? -1e12 * megabytes : 1e6 * megabytes;
}

/* Refuses more than memory_limit bytes on a rank: the estimate of MUMPS, and three dense shares. */
static dls_status condenser_limit(const dlsi_condenser *work, const dlsi_spread *spread,
                                  double memory_limit, dls_error *error) {
  const double dense = 3 * sizeof(double) * (double)dlsi_spread_size(spread);
  double foreseen = condenser_bytes(work->mumps.INFOG(16)) + dense;
  (void)MPI_Allreduce(MPI_IN_PLACE, &foreseen, 1, MPI_DOUBLE, MPI_MAX, work->grid->all);
  if (foreseen <= memory_limit) return DLS_OK;
  return dlsi_fail(error, DLS_E_MEMORY, "", -1, foreseen,
                   "%.3g GB are expected on a rank, memory_limit is %.3g GB", 1e-9 * foreseen,
                   1e-9 * memory_limit);
}

/* Adds the time since *from to a phase. */
static void condenser_end_phase(dls_mpi_info *info, dls_mpi_phase phase, dlsi_mpi_clock *from) {
  const dlsi_mpi_clock now = dlsi_mpi_now();
  info->wall[phase] = now.wall - from->wall;
  info->cpu[phase] = now.cpu - from->cpu;
  *from = now;
}

/* Allocates on every rank. count: that of `of`, or 0. *out is NULL on error. */
static dls_status condenser_allot(dlsi_condenser **out, const dlsi_shares *of,
                                  const dls_mpi_model *model, int count, dls_error *error) {
  *out = NULL;
  dlsi_condenser *work = calloc(1, sizeof *work);
  dls_status status = dlsi_agree(of->grid.all, work ? DLS_OK : dlsi_no_memory(error), error);
  if (!status && work) {
    work->of = of;
    work->grid = &of->grid;
    work->symmetric = model->factorization != DLS_LU;
    work->more = count == of->n;
    work->n = of->n + work->more;
    work->count = count;
    status = condenser_allocate(work, model, error);
  }
  if (status || !work) {
    dlsi_condenser_destroy(work);
    return status;
  }
  for (int k = 0; k < count; k++)
    work->keep[k] = of->keep[k] + 1;
  *out = work;
  return DLS_OK;
}

dls_status dlsi_condenser_create(dlsi_condenser **out, const dlsi_shares *of,
                                 const dls_mpi_model *model, double memory_limit,
                                 const dlsi_spread *spread, double **S, dls_mpi_info *info,
                                 dls_error *error) {
  dlsi_mpi_clock clock = dlsi_mpi_now();
  dlsi_condenser *work;
  *out = NULL;
  *S = NULL;
  dls_status status = condenser_allot(&work, of, model, of->count, error);
  if (status) return status;
  condenser_take_values(work, model);
  condenser_find_scales(work);
  status = condenser_scale(work, error);
  if (!status) status = condenser_order(work, error);
  condenser_end_phase(info, DLS_MPI_ORDER, &clock);
  if (!status) status = condenser_analyse(work, model->factorization, error);
  condenser_end_phase(info, DLS_MPI_ANALYSE, &clock);
  if (!status && memory_limit > 0) status = condenser_limit(work, spread, memory_limit, error);
  if (!status) status = condenser_factor(work, spread, S, error);
  condenser_end_phase(info, DLS_MPI_FACTOR, &clock);
  if (status) {
    free(*S);
    *S = NULL;
    dlsi_condenser_destroy(work);
    return status;
  }
  info->factor_bytes = condenser_bytes(work->mumps.INFO(22));
  info->flops = work->mumps.RINFO(3);
  condenser_shrink(work);
  *out = work;
  return DLS_OK;
}

dls_status dlsi_condenser_begin(dlsi_condenser **out, const dlsi_shares *of,
                                const dls_mpi_model *model, dls_mpi_info *info, dls_error *error) {
  dlsi_mpi_clock clock = dlsi_mpi_now();
  dlsi_condenser *work;
  *out = NULL;
  dls_status status = condenser_allot(&work, of, model, 0, error);
  if (status) return status;
  status = condenser_order(work, error);
  condenser_end_phase(info, DLS_MPI_ORDER, &clock);
  if (!status) status = condenser_analyse(work, model->factorization, error);
  condenser_end_phase(info, DLS_MPI_ANALYSE, &clock);
  if (status)
    dlsi_condenser_destroy(work);
  else
    *out = work;
  return status;
}

dls_status dlsi_condenser_again(dlsi_condenser *work, dls_factorization kind, dls_mpi_info *info,
                                dls_error *error) {
  dlsi_mpi_clock clock = dlsi_mpi_now();
  dlsi_mumps_end(&work->mumps);
  work->mumps = (DMUMPS_STRUC_C){.n = 0};
  work->started = 0;
  const dls_status status = condenser_analyse(work, kind, error);
  condenser_end_phase(info, DLS_MPI_ANALYSE, &clock);
  return status;
}

double *dlsi_condenser_values(dlsi_condenser *work) {
  return work->x;
}

dls_status dlsi_condenser_refactor(dlsi_condenser *work, dls_mpi_info *info, dls_error *error) {
  dlsi_mpi_clock clock = dlsi_mpi_now();
  condenser_find_scales(work);
  dls_status status = condenser_scale(work, error);
  if (!status) status = condenser_eliminate(work, error);
  const double wall = info->wall[DLS_MPI_FACTOR], cpu = info->cpu[DLS_MPI_FACTOR];
  condenser_end_phase(info, DLS_MPI_FACTOR, &clock);
  info->wall[DLS_MPI_FACTOR] += wall;
  info->cpu[DLS_MPI_FACTOR] += cpu;
  info->factor_bytes = condenser_bytes(work->mumps.INFO(22));
  info->flops = work->mumps.RINFO(3);
  return status;
}

dlsi_scales dlsi_condenser_scales(const dlsi_condenser *work) {
  return (dlsi_scales){work->kept, work->kept + work->count, work->R, work->C, work->norm};
}

/* ---- solve ----------------------------------------------------------------------------------- */

/* (MC5) */
static dls_status condenser_solve(dlsi_condenser *work, int half, dls_error *error) {
  DMUMPS_STRUC_C *M = &work->mumps;
  M->ICNTL(26) = half;
  M->redrhs = work->reduced;
  M->lredrhs = work->count;
  return dlsi_mumps_solve(M, work->whole, 1, error);
}

dls_status dlsi_condenser_condense(dlsi_condenser *work, double *b, double *z, dls_error *error) {
  const int root = work->grid->rank == 0, count = work->count;
  if (work->more_here) work->whole[work->n - 1] = 0;
  dlsi_scale_rows(work->R, (size_t)work->halo.rows, b, 1);
  dlsi_shares_collect(work->of, b, work->whole);
  if (count == 0) return DLS_OK;
  const dls_status status = condenser_solve(work, condense, error);
  if (status) return status;
  for (int k = 0; root && k < count; k++)
    z[k] = work->reduced[k] / work->kept[k];
  (void)MPI_Bcast(z, count, MPI_DOUBLE, 0, work->grid->all);
  return DLS_OK;
}

dls_status dlsi_condenser_expand(dlsi_condenser *work, const double *y, double *x,
                                 dls_error *error) {
  const int count = work->count;
  for (int k = 0; k < count; k++)
    work->reduced[k] = y[k] / work->kept[count + k];
  const dls_status status = condenser_solve(work, count > 0 ? expand : 0, error);
  if (status) return status;
  dlsi_shares_hand_out(work->of, work->whole, x);
  dlsi_scale_rows(work->C, (size_t)work->halo.rows, x, 1);
  return DLS_OK;
}

void dlsi_condenser_destroy(dlsi_condenser *work) {
  if (!work) return;
  if (work->started) dlsi_mumps_end(&work->mumps);
  dlsi_halo_free(&work->halo);
  void *const owned[] = {work->row, work->x,    work->keep,  work->order,
                         work->R,   work->kept, work->whole, work};
  for (size_t k = 0; k < sizeof owned / sizeof owned[0]; k++)
    free(owned[k]);
}
