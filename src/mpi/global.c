/*
 * global.c: the contact problem on a K that is spread, without W: global/splitting.c on every rank
 * with the rows and nodes of that rank.
 *
 *   (MG1)  factor and solve: system.c, or the host's solver
 *   (MG2)  the product with K of the certificate: body.c
 *   (MG3)  callback and clock of rank 0 (solve.c)
 *   (MG4)  a proof that nothing can hold a body: motion.c on rank 0, which takes all of K for it,
 *          unless the host brings a solver; without the memory nothing is proved
 *   (MG5)  one rank with a factor: the problem of global.h, faster and with all of its steps
 *
 * Norms, sums and maxima go through rank 0, so that all ranks have the same bits and take the same
 * branches (dlsi_ranks of contact.h). Newton steps need a host's preconditioner: their LU is that
 * of one process.
 * Memory of a rank: delassus/mpi.h; on rank 0, for (MG4), also all of K and its factor. Fails: no
 * memory on one rank, an error of the host's solver on one rank.
 */
#include <limits.h>
#include <stdlib.h>
#include <string.h>

#include "global/global_internal.h"
#include "mpi_internal.h"

struct dls_mpi_global {
  dlsi_shares of;
  dlsi_mpi_body body;
  dlsi_mpi_system system;
  dls_global_solver host; /* NULL functions: system */
  dls_global *global;
  int alone; /* 1: one rank, `global` has all */
  dls_factorization factorization;
  double *motion;  /* n, of a proof: on rank 0, NULL before the first */
  int mover;       /* its body; -1: nothing is proved */
  const double *f; /* rows, of the solve; NULL for 0 */
  const double *mu;
  dls_mpi_info info;
};

/* ---- a host's solver ------------------------------------------------------------------------- */

/* Makes the answer of this rank's function that of all: an error first, then a wish to cancel. */
static dls_status brought_agree(const dls_mpi_global *work, dls_status answer, dls_error *error) {
  const MPI_Comm all = work->of.grid.all;
  const dls_status status = dlsi_agree(all, answer, error);
  int cancelled = answer > 0;
  if (status) return status;
  (void)MPI_Allreduce(MPI_IN_PLACE, &cancelled, 1, MPI_INT, MPI_MAX, all);
  return cancelled ? DLS_CANCELLED : DLS_OK;
}

static dls_status brought_prepare(void *data, const double *R, dls_error *error) {
  DLSI_DOOR;
  dls_mpi_global *work = data;
  return brought_agree(work, dlsi_host_prepare(work->host.prepare, work->host.data, R, error),
                       error);
}

static dls_status brought_block(void *data, const double *R, dls_error *error) {
  DLSI_DOOR;
  dls_mpi_global *work = data;
  return brought_agree(work, dlsi_host_prepare(work->host.block, work->host.data, R, error), error);
}

static dls_status brought_by(dls_mpi_global *work, dls_global_solve_fn by, const double *b,
                             double *x, double accuracy, dls_error *error) {
  return brought_agree(work, dlsi_host_solve(by, work->host.data, b, x, accuracy, error), error);
}

static dls_status brought_solve(void *data, const double *b, double *x, double accuracy,
                                dls_error *error) {
  DLSI_DOOR;
  dls_mpi_global *work = data;
  return brought_by(work, work->host.solve, b, x, accuracy, error);
}

static dls_status brought_apply(void *data, const double *b, double *x, double accuracy,
                                dls_error *error) {
  DLSI_DOOR;
  dls_mpi_global *work = data;
  return brought_by(work, work->host.apply, b, x, accuracy, error);
}

/* ---- create ---------------------------------------------------------------------------------- */

/* Splits H, its entries in t, into normals and tangents. Frees t. */
static dls_status global_split(dlsi_triplets *t, int d, dlsi_columns *N, dlsi_columns *T,
                               dls_error *error) {
  dls_status status = dlsi_columns_compress(t, d, DLSI_NORMALS, N, error);
  if (!status) status = dlsi_columns_compress(t, d, DLSI_TANGENTS, T, error);
  dlsi_triplets_free(t);
  return status;
}

/* H on the rows of this rank. */
static dls_status global_columns(const dlsi_shares *of, dlsi_columns *N, dlsi_columns *T,
                                 dls_error *error) {
  const dlsi_columns *Ht = &of->here;
  dlsi_triplets t;
  const dls_status status =
      dlsi_triplets_alloc(of->rows, Ht->rows, (size_t)Ht->p[of->rows], &t, error);
  for (int j = 0; !status && j < of->rows; j++)
    for (int e = Ht->p[j]; e < Ht->p[j + 1]; e++)
      dlsi_triplets_add(&t, j, Ht->i[e], Ht->x[e]);
  if (!status) return global_split(&t, of->d, N, T, error);
  dlsi_triplets_free(&t);
  return status;
}

static dls_model global_model(const dls_mpi_global *work, const dlsi_columns *N,
                              const dlsi_columns *T) {
  return (dls_model){.d = work->of.d,
                     .n = N->rows,
                     .nodes = N->cols,
                     .operator_kind = DLS_STIFFNESS_SPARSE,
                     .factorization = work->factorization,
                     .HN = dlsi_columns_view(N),
                     .HT = dlsi_columns_view(T)};
}

/* Gathers K on rank 0. */
static dls_status global_gather_K(const dls_mpi_global *work, dlsi_columns *K, dls_error *error) {
  const dlsi_mpi_body *body = &work->body;
  const MPI_Comm all = work->of.grid.all;
  const int ranks = work->of.grid.ranks, root = work->of.grid.rank == 0;
  const int mine = (int)body->entries;
  int *counts = calloc(2 * (size_t)ranks, sizeof *counts);
  int *row = dlsi_alloc(body->entries, 2 * sizeof *row), *col = row ? row + body->entries : NULL;
  dls_status status = dlsi_agree(all, counts && row ? DLS_OK : dlsi_no_memory(error), error);
  dlsi_triplets t = {0};
  if (!status) {
    int *const starts = counts + ranks;
    (void)MPI_Gather(&mine, 1, MPI_INT, counts, 1, MPI_INT, 0, all);
    for (int k = 1; k < ranks; k++)
      starts[k] = starts[k - 1] + counts[k - 1];
    const size_t entries = (size_t)starts[ranks - 1] + (size_t)counts[ranks - 1];
    if (root) status = dlsi_triplets_alloc(work->of.n, work->of.n, entries, &t, error);
    status = dlsi_agree(all, status, error);
    if (!status) {
      t.count = (int)entries;
      dlsi_mpi_body_entries(body, row, col);
      (void)MPI_Gatherv(row, mine, MPI_INT, t.row, counts, starts, MPI_INT, 0, all);
      (void)MPI_Gatherv(col, mine, MPI_INT, t.col, counts, starts, MPI_INT, 0, all);
      (void)MPI_Gatherv(body->x, mine, MPI_DOUBLE, t.x, counts, starts, MPI_DOUBLE, 0, all);
      if (root) status = dlsi_columns_compress(&t, 1, DLSI_ALL, K, error);
    }
  }
  dlsi_triplets_free(&t);
  free(row);
  free(counts);
  return status;
}

/* (MG4) on rank 0. H: spent; f, mu: of all ranks. */
static dls_status global_prove_here(dls_mpi_global *work, const dlsi_columns *K, dlsi_triplets *H,
                                    const double *f, const double *mu, int *proved,
                                    dls_error *error) {
  dlsi_columns N = {0}, T = {0};
  dls_global *alone = NULL;
  dls_status status = global_split(H, work->of.d, &N, &T, error);
  *H = (dlsi_triplets){.count = 0};
  if (!status) {
    dls_model model = global_model(work, &N, &T);
    model.Ks = dlsi_columns_view(K);
    status = dls_global_create(&alone, &model, error);
  }
  if (!status) status = dlsi_global_prove_for(alone, f, mu, proved, error);
  const double *motion = dls_global_motion(alone, &work->mover);
  if (!status && motion) memcpy(work->motion, motion, (size_t)work->of.n * sizeof *motion);
  dls_global_destroy(alone);
  dlsi_columns_free(&N);
  dlsi_columns_free(&T);
  return status;
}

/* (MG4) Gathers f and friction on rank 0, where vectors of n are needed for a while. */
static dls_status global_gather(dls_mpi_global *work, double **f, double **mu, dls_error *error) {
  const dlsi_shares *of = &work->of;
  const size_t n = of->grid.rank ? 0 : (size_t)of->n, rows = (size_t)of->rows;
  const size_t m = (size_t)of->m, own = (size_t)(of->d * of->own);
  *f = calloc(n + rows + m + own + 1, sizeof **f);
  if (!work->motion && n) work->motion = dlsi_alloc(n, sizeof *work->motion);
  dls_status status = *f && (work->motion || n == 0) ? DLS_OK : dlsi_no_memory(error);
  status = dlsi_agree(of->grid.all, status, error);
  if (status) return status;
  double *mine = *f + n, *all = mine + rows, *each = all + m;
  *mu = all;
  if (work->f) memcpy(mine, work->f, rows * sizeof *mine);
  for (size_t k = 0; work->mu && k < own; k++)
    each[k] = work->mu[k / (size_t)of->d];
  dlsi_shares_collect(of, mine, *f);
  dlsi_shares_gather_nodes(of, each, all);
  for (int c = 0; c < of->nodes; c++)
    all[c] = all[of->d * c];
  return DLS_OK;
}

/* (MG4) */
static dls_status global_prove(void *data, int *proved, dls_error *error) {
  dls_mpi_global *work = data;
  const MPI_Comm all = work->of.grid.all;
  dlsi_columns K = {0};
  dlsi_triplets H = {0};
  dls_error why = {0};
  double *f = NULL, *mu = NULL;
  *proved = 0;
  if (work->host.solve || work->factorization == DLS_LU) return DLS_OK;
  dls_status status = global_gather(work, &f, &mu, &why);
  if (!status) status = dlsi_shares_join(&work->of, &work->of.mine, &H, &why);
  if (!status) status = global_gather_K(work, &K, &why);
  if (!status && work->of.grid.rank == 0)
    status = global_prove_here(work, &K, &H, f, mu, proved, &why);
  dlsi_columns_free(&K);
  dlsi_triplets_free(&H);
  free(f);
  status = dlsi_agree(all, status, &why);
  (void)MPI_Bcast(proved, 1, MPI_INT, 0, all);
  (void)MPI_Bcast(&work->mover, 1, MPI_INT, 0, all);
  if (!status || status == DLS_E_MEMORY) return DLS_OK;
  if (error) *error = why;
  return status;
}

const double *dls_mpi_global_motion(const dls_mpi_global *global, int *body) {
  if (global && global->alone) return dls_global_motion(global->global, body);
  if (!global || global->mover < 0) return NULL;
  if (body) *body = global->mover;
  return global->motion;
}

/* Makes the problem on K. */
static dls_status global_join(dls_mpi_global *work, dls_error *error) {
  const dls_global_solver solver =
      work->host.solve ? (dls_global_solver){work, brought_prepare, brought_solve,
                                             work->host.block ? brought_block : NULL,
                                             work->host.apply ? brought_apply : NULL}
                       : (dls_global_solver){.data = &work->system,
                                             .prepare = dlsi_mpi_system_prepare,
                                             .solve = dlsi_mpi_system_solve};
  dlsi_columns N = {0}, T = {0};
  dls_status status = global_columns(&work->of, &N, &T, error);
  if (!status) {
    const dls_model model = global_model(work, &N, &T);
    status = dlsi_global_create_on(&work->global, &model, &work->body.body, &solver, error);
  }
  if (!status) {
    work->global->prove = global_prove;
    work->global->prover = work;
  }
  dlsi_columns_free(&N);
  dlsi_columns_free(&T);
  return dlsi_agree(work->of.grid.all, status, error);
}

/* (MG5) */
static dls_status global_alone(dls_mpi_global *work, const dls_mpi_model *model, dls_error *error) {
  dlsi_columns K = {0}, N = {0}, T = {0};
  dlsi_triplets H = {0};
  const int n = work->of.n;
  const dlsi_triplets entries = {n,
                                 n,
                                 (int)model->entries,
                                 (int *)model->row, /* these are only read */
                                 (int *)model->col,
                                 (double *)model->x};
  dls_status status = dlsi_columns_compress(&entries, 1, DLSI_ALL, &K, error);
  if (!status) status = dlsi_shares_join(&work->of, &work->of.mine, &H, error);
  if (!status) status = global_split(&H, work->of.d, &N, &T, error);
  if (!status) {
    dls_model whole = global_model(work, &N, &T);
    whole.Ks = dlsi_columns_view(&K);
    status = dls_global_create(&work->global, &whole, error);
  }
  dlsi_columns_free(&K);
  dlsi_columns_free(&N);
  dlsi_columns_free(&T);
  return status;
}

static dls_status global_build(dls_mpi_global *work, MPI_Comm comm, const dls_mpi_model *model,
                               dls_error *error) {
  work->factorization = model->factorization;
  work->mover = -1;
  dls_status status = dlsi_shares_create(&work->of, comm, model, error);
  const int alone = work->alone =
      work->of.grid.ranks == 1 && !work->host.solve && model->entries <= INT_MAX;
  if (!status && !alone) status = dlsi_mpi_body_create(&work->body, &work->of, model, error);
  dlsi_shares_shrink(&work->of);
  if (!status && !alone && !work->host.solve)
    status = dlsi_mpi_system_create(&work->system, &work->body, model->factorization, &work->info,
                                    error);
  if (!status) status = alone ? global_alone(work, model, error) : global_join(work, error);
  work->info.ranks = work->of.grid.ranks;
  work->info.rank = work->of.grid.rank;
  work->info.grid[0] = work->of.grid.rows;
  work->info.grid[1] = work->of.grid.cols;
  work->info.n = work->of.n;
  work->info.m = work->of.m;
  return status;
}

static dls_status mpi_global_create(dls_mpi_global **out, MPI_Comm comm, const dls_mpi_model *model,
                                    const dls_global_solver *solver, dls_error *error) {
  dls_mpi_global *work = calloc(1, sizeof *work);
  dls_status status = dlsi_shares_check(model, error);
  if (!status && solver && (!solver->prepare || !solver->solve || !solver->block != !solver->apply))
    status = dlsi_is_null(error, "solver");
  if (!status && !out) status = dlsi_is_null(error, "out");
  if (!status && !work) status = dlsi_no_memory(error);
  status = dlsi_agree(comm, status, error);
  const int functions = !solver ? 0 : solver->apply ? 2 : 1;
  int mine[2] = {functions, -functions}, most[2];
  if (!status) { /* all ranks bring one, or none */
    (void)MPI_Allreduce(mine, most, 2, MPI_INT, MPI_MAX, comm);
    if (most[0] != -most[1])
      status =
          dlsi_fail(error, DLS_E_ARGUMENT, "solver", -1, 0, "or apply is NULL on some ranks alone");
  }
  if (status || !work || !out) {
    free(work);
    return status;
  }
  if (solver) work->host = *solver;
  status = global_build(work, comm, model, error);
  if (status)
    dls_mpi_global_destroy(work);
  else
    *out = work;
  return status;
}

dls_status dls_mpi_global_create(dls_mpi_global **out, MPI_Comm comm, const dls_mpi_model *model,
                                 const dls_global_solver *solver, dls_error *error) {
  DLSI_DOOR;
  dls_error why = {0};
  if (out) *out = NULL;
  const dls_status status = comm == MPI_COMM_NULL
                                ? dlsi_fail(&why, DLS_E_ARGUMENT, "comm", -1, 0, "is MPI_COMM_NULL")
                                : mpi_global_create(out, comm, model, solver, &why);
  if (status && error) *error = why;
  return dlsi_at(__func__, status, error);
}

void dls_mpi_global_destroy(dls_mpi_global *global) {
  if (!global) return;
  dls_global_destroy(global->global);
  dlsi_mpi_system_free(&global->system);
  dlsi_mpi_body_free(&global->body);
  dlsi_shares_free(&global->of);
  free(global->motion);
  free(global);
}

dls_status dls_mpi_global_get_info(const dls_mpi_global *global, dls_mpi_info *info,
                                   dls_error *error) {
  DLSI_DOOR;
  if (!global) return dlsi_at(__func__, dlsi_is_null(error, "global"), error);
  if (!info) return dlsi_at(__func__, dlsi_is_null(error, "info"), error);
  *info = global->info;
  return DLS_OK;
}

/* ---- solve ----------------------------------------------------------------------------------- */

/* The arguments of one rank. */
typedef struct given {
  const double *f, *g, *mu;
  double *r, *x;
} given;

static dls_status given_check(const dls_mpi_global *work, const given *of, const dls_limits *limits,
                              dls_error *error) {
  const int rows = work->of.rows, own = work->of.d * work->of.own;
  dls_status status = dlsi_check_limits(limits, error);
  if (!status) status = dlsi_shares_check_vector("f", of->f, rows, 1, error);
  if (!status) status = dlsi_shares_check_vector("g", of->g, own, 1, error);
  if (!status && of->mu && own) status = dlsi_check_friction(of->mu, (size_t)work->of.own, error);
  if (!status && own && !of->r) status = dlsi_is_null(error, "r");
  if (!status && rows && !of->x) status = dlsi_is_null(error, "x");
  if (!status && rows && own && of->r < of->x + rows && of->x < of->r + own)
    status = dlsi_fail(error, DLS_E_ARGUMENT, "x", -1, 0, "overlaps r");
  if (status || !limits->warm_start) return status;
  status = dlsi_shares_check_vector("r", of->r, own, 0, error);
  return status ? status : dlsi_shares_check_vector("x", of->x, rows, 0, error);
}

static dls_status mpi_global_solve(dls_mpi_global *work, const given *of, const dls_limits *limits,
                                   dls_info *info, dls_error *error) {
  dls_limits usual;
  dls_info outcome = {0};
  dlsi_limits_init(&usual);
  if (limits) usual = *limits;
  dls_status status = dlsi_agree(work->of.grid.all, given_check(work, of, &usual, error), error);
  if (status) return status;
  dlsi_mpi_watch watch;
  work->mover = -1;
  dlsi_mpi_take_limits(&work->of.grid, &usual);
  dlsi_mpi_watch_begin(&watch, &work->of.grid, &usual);
  double nothing = 0; /* of a rank without rows */
  work->f = of->f;
  work->mu = of->mu;
  status = dls_global_solve(work->global, of->f, of->g, of->mu, &usual, of->r,
                            work->of.rows ? of->x : &nothing, &outcome, error);
  status = status < 0 ? status : outcome.status;
  if (status == DLS_CANCELLED && watch.late) outcome.status = status = DLS_TIME_LIMIT;
  if (status >= 0 && info) *info = outcome;
  return status;
}

dls_status dls_mpi_global_solve(dls_mpi_global *global, const double *f, const double *g,
                                const double *mu, const dls_limits *limits, double *r, double *x,
                                dls_info *info, dls_error *error) {
  DLSI_DOOR;
  dls_error why = {0};
  const given of = {f, g, mu, r, x};
  const dls_status status =
      global ? mpi_global_solve(global, &of, limits, info, &why) : dlsi_is_null(&why, "global");
  if (status < 0 && error) *error = why;
  return dlsi_at(__func__, status, error);
}
