/*
 * global.c: the contact problem on a K that is spread, without W: global/splitting.c on every rank
 * with equal vectors of all unknowns.
 *
 *   (MG1)  factor and solve: system.c, or the host's solver with the rows and nodes of its rank
 *   (MG2)  the product with K of the certificate: body.c
 *   (MG3)  callback and clock of rank 0 (solve.c)
 *
 *   (MG4)  a proof that nothing can hold a body: motion.c on rank 0, which takes all of K for it,
 *          unless the host brings a solver; without the memory nothing is proved
 *
 * All ranks get x from rank 0 with the same bits, so that all take the same branches. Newton steps
 * need a host's preconditioner: their LU is that of one process.
 * Memory of a rank: its share of the factor, its entries of K twice, about 25 vectors of n and 40
 * of m; on rank 0, for (MG4), all of K and its factor. Fails: no memory on one rank, an error of
 * the host's solver on one rank.
 */
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
  dls_factorization factorization;
  double *motion;           /* n, of a proof: on rank 0 */
  int mover;                /* its body; -1: nothing is proved */
  double *f, *x, *part;     /* n, n, rows: of all ranks; a host's x */
  double *g, *mu, *r, *own; /* m each */
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
  const double *own = R + work->of.d * work->of.first;
  const dls_status status = dlsi_host_prepare(work->host.prepare, work->host.data, own, error);
  return brought_agree(work, status, error);
}

static dls_status brought_block(void *data, const double *R, dls_error *error) {
  DLSI_DOOR;
  dls_mpi_global *work = data;
  const double *own = R + work->of.d * work->of.d * work->of.first;
  const dls_status status = dlsi_host_prepare(work->host.block, work->host.data, own, error);
  return brought_agree(work, status, error);
}

static dls_status brought_by(dls_mpi_global *work, dls_global_solve_fn by, const double *b,
                             double *x, double accuracy, dls_error *error) {
  const int first = work->of.first_row;
  memcpy(work->part, x + first, (size_t)work->of.rows * sizeof *x);
  dls_status status = dlsi_host_solve(by, work->host.data, b + first, work->part, accuracy, error);
  status = brought_agree(work, status, error);
  if (!status) dlsi_shares_gather_rows(&work->of, work->part, x);
  return status;
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

/* Adds up numbers of all ranks, to the same bits on each. */
static void brought_sum(void *data, double *x, int count) {
  const dlsi_grid *grid = &((const dls_mpi_global *)data)->of.grid;
  (void)MPI_Reduce(grid->rank ? x : MPI_IN_PLACE, x, count, MPI_DOUBLE, MPI_SUM, 0, grid->all);
  (void)MPI_Bcast(x, count, MPI_DOUBLE, 0, grid->all);
}

static void brought_gather(void *data, double *x) {
  dls_mpi_global *work = data;
  memcpy(work->part, x + work->of.first_row, (size_t)work->of.rows * sizeof *x);
  dlsi_shares_gather_rows(&work->of, work->part, x);
}

/* ---- create ---------------------------------------------------------------------------------- */

/* Splits H into normals and tangents. */
static dls_status global_columns(const dlsi_shares *of, dlsi_columns *N, dlsi_columns *T,
                                 dls_error *error) {
  dlsi_triplets t;
  dls_status status = dlsi_triplets_alloc(of->n, of->m, (size_t)of->H.p[of->m], &t, error);
  for (int k = 0; !status && k < of->m; k++)
    for (int e = of->H.p[k]; e < of->H.p[k + 1]; e++)
      dlsi_triplets_add(&t, of->keep[of->H.i[e]], k, of->H.x[e]);
  if (!status) status = dlsi_columns_compress(&t, of->d, DLSI_NORMALS, N, error);
  if (!status) status = dlsi_columns_compress(&t, of->d, DLSI_TANGENTS, T, error);
  dlsi_triplets_free(&t);
  return status;
}

static dls_model global_model(const dls_mpi_global *work, const dlsi_columns *N,
                              const dlsi_columns *T) {
  return (dls_model){.d = work->of.d,
                     .n = work->of.n,
                     .nodes = work->of.nodes,
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
  dls_status status = dlsi_agree(all, counts ? DLS_OK : dlsi_no_memory(error), error);
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
      (void)MPI_Gatherv(body->row, mine, MPI_INT, t.row, counts, starts, MPI_INT, 0, all);
      (void)MPI_Gatherv(body->col, mine, MPI_INT, t.col, counts, starts, MPI_INT, 0, all);
      (void)MPI_Gatherv(body->x, mine, MPI_DOUBLE, t.x, counts, starts, MPI_DOUBLE, 0, all);
      if (root) status = dlsi_columns_compress(&t, 1, DLSI_ALL, K, error);
    }
  }
  dlsi_triplets_free(&t);
  free(counts);
  return status;
}

/* (MG4) on rank 0. */
static dls_status global_prove_here(dls_mpi_global *work, const dlsi_columns *K, int *proved,
                                    dls_error *error) {
  dlsi_columns N = {0}, T = {0};
  dls_global *alone = NULL;
  dls_status status = global_columns(&work->of, &N, &T, error);
  if (!status) {
    dls_model model = global_model(work, &N, &T);
    model.Ks = dlsi_columns_view(K);
    status = dls_global_create(&alone, &model, error);
  }
  if (!status) status = dlsi_global_prove_for(alone, work->f, work->mu, proved, error);
  const double *motion = dls_global_motion(alone, &work->mover);
  if (!status && motion) memcpy(work->motion, motion, (size_t)work->of.n * sizeof *motion);
  dls_global_destroy(alone);
  dlsi_columns_free(&N);
  dlsi_columns_free(&T);
  return status;
}

/* (MG4) */
static dls_status global_prove(void *data, int *proved, dls_error *error) {
  dls_mpi_global *work = data;
  const MPI_Comm all = work->of.grid.all;
  dlsi_columns K = {0};
  dls_error why = {0};
  *proved = 0;
  if (work->host.solve || work->factorization == DLS_LU) return DLS_OK;
  dls_status status = global_gather_K(work, &K, &why);
  if (!status && work->of.grid.rank == 0) status = global_prove_here(work, &K, proved, &why);
  dlsi_columns_free(&K);
  status = dlsi_agree(all, status, &why);
  (void)MPI_Bcast(proved, 1, MPI_INT, 0, all);
  (void)MPI_Bcast(&work->mover, 1, MPI_INT, 0, all);
  if (!status || status == DLS_E_MEMORY) return DLS_OK;
  if (error) *error = why;
  return status;
}

const double *dls_mpi_global_motion(const dls_mpi_global *global, int *body) {
  if (!global || global->mover < 0) return NULL;
  if (body) *body = global->mover;
  return global->motion;
}

/* Makes the problem on K. */
static dls_status global_join(dls_mpi_global *work, dls_error *error) {
  const dlsi_shares *of = &work->of;
  const size_t n = (size_t)of->n, m = (size_t)of->m, rows = (size_t)of->rows;
  const dls_global_solver solver =
      work->host.solve ? (dls_global_solver){work, brought_prepare, brought_solve,
                                             work->host.block ? brought_block : NULL,
                                             work->host.apply ? brought_apply : NULL}
                       : (dls_global_solver){.data = &work->system,
                                             .prepare = dlsi_mpi_system_prepare,
                                             .solve = dlsi_mpi_system_solve};
  dlsi_columns N = {0}, T = {0};
  dls_status status = global_columns(of, &N, &T, error);
  const size_t of_motion = of->grid.rank == 0 ? n : 0;
  work->f = calloc(2 * n + of_motion + rows + 4 * m + 1, sizeof *work->f);
  if (!status && !work->f) status = dlsi_no_memory(error);
  if (!status) {
    work->x = work->f + n;
    work->part = work->x + n;
    work->g = work->part + rows;
    work->mu = work->g + m;
    work->r = work->mu + m;
    work->own = work->r + m;
    work->motion = work->own + m;
    const dls_model model = global_model(work, &N, &T);
    status = dlsi_global_create_on(&work->global, &model, &work->body.body, &solver, error);
  }
  if (!status) {
    work->global->prove = global_prove;
    work->global->prover = work;
    work->global->spread =
        (dlsi_spread_rows){of->first_row, of->rows, brought_sum, brought_gather, work};
  }
  dlsi_columns_free(&N);
  dlsi_columns_free(&T);
  return dlsi_agree(of->grid.all, status, error);
}

static dls_status global_build(dls_mpi_global *work, MPI_Comm comm, const dls_mpi_model *model,
                               dls_error *error) {
  work->factorization = model->factorization;
  work->mover = -1;
  dls_status status = dlsi_shares_create(&work->of, comm, model, error);
  if (!status) status = dlsi_mpi_body_create(&work->body, &work->of, model, error);
  if (!status && !work->host.solve)
    status = dlsi_mpi_system_create(&work->system, &work->body, model->factorization, &work->info,
                                    error);
  if (!status) status = global_join(work, error);
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
  free(global->f);
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
  if (status || !limits->warm_start) return status;
  status = dlsi_shares_check_vector("r", of->r, own, 0, error);
  return status ? status : dlsi_shares_check_vector("x", of->x, rows, 0, error);
}

/* all := the d values of each node of all ranks, 0 for NULL; one value per node if d = 1. */
static void global_gather(dls_mpi_global *work, int d, const double *own, double *all) {
  const dlsi_shares *of = &work->of;
  for (int k = 0; k < of->d * of->own; k++)
    work->own[k] = own ? own[d == 1 ? k / of->d : k] : 0;
  dlsi_shares_gather_nodes(of, work->own, all);
  for (int c = 0; d == 1 && c < of->nodes; c++)
    all[c] = all[of->d * c];
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
  dlsi_shares_gather_rows(&work->of, of->f, work->f);
  global_gather(work, work->of.d, of->g, work->g);
  global_gather(work, 1, of->mu, work->mu);
  global_gather(work, work->of.d, usual.warm_start ? of->r : NULL, work->r);
  dlsi_shares_gather_rows(&work->of, usual.warm_start ? of->x : NULL, work->x);
  status = dls_global_solve(work->global, work->f, work->g, work->mu, &usual, work->r, work->x,
                            &outcome, error);
  status = status < 0 ? status : outcome.status;
  if (status == DLS_CANCELLED && watch.late) outcome.status = status = DLS_TIME_LIMIT;
  if (status < 0) return status;
  const size_t own = (size_t)(work->of.d * work->of.own), rows = (size_t)work->of.rows;
  if (own) memcpy(of->r, work->r + work->of.d * work->of.first, own * sizeof *of->r);
  if (rows) memcpy(of->x, work->x + work->of.first_row, rows * sizeof *of->x);
  if (info) *info = outcome;
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
