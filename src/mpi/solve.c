/*
 * solve.c: solves the contact problem of a reduction on several ranks.
 *
 *   (MS1)  up to settings.gather rows: W goes to rank 0, which calls dls_solve
 *   (MS2)  above: each rank runs the iteration of vi/admm.c on the same vectors, and only what
 *          takes the matrix is shared: A := (W + rho D)^-1 for each rho, one product with A an
 *          iteration, one with W and one with |W| for a certificate
 *
 * Numbers of (MS2) are equal on all ranks to the last bit (grid.c), so that all ranks stop at the
 * same place. What differs by rank, the clock and the callback, is rank 0's word (MS3).
 * Cost: per rho m^3 (2 m^3 by LU) over the ranks; per iteration 2 m^2 over the ranks and O(m).
 */
#include <limits.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "delassus/solve.h"
#include "mpi_internal.h"
#include "vi/vi_internal.h"

enum { gather_rows = 1000 };

void dls_mpi_settings_init(dls_mpi_settings *settings) {
  if (!settings) return;
  *settings = (dls_mpi_settings){.size = sizeof *settings, .gather = gather_rows};
  dlsi_limits_init(&settings->limits);
}

/* What a solve has on every rank: vectors of all ranks. */
typedef struct shared_solve {
  dls_mpi_reduction *work;
  dls_mpi_settings settings;
  double *mu, *r, *u, *blocks; /* nc, m, m, d m */
  int *p, *i;                  /* nc + 1, nc */
  /* (MS3) */
  dls_limits told; /* rank 0's own */
  double begun;
  int late; /* 1: stopped by the clock */
} shared_solve;

/* ---- A and W --------------------------------------------------------------------------------- */

/* A := W + rho D, both triangles. */
static void shared_build(dls_mpi_reduction *work, double rho, const double *w) {
  const dlsi_spread *s = &work->on_W;
  memcpy(work->A, work->W, dlsi_spread_size(s) * sizeof *work->A);
  for (int j = 0, i = 0; j < s->cols; j++) {
    while (i < s->rows && s->row[i] < s->col[j])
      i++;
    if (i < s->rows && s->row[i] == s->col[j])
      work->A[(size_t)i + (size_t)j * (size_t)s->rows] += rho * w[s->col[j] / work->d];
  }
}

static dls_status shared_factor(void *data, double rho, const double *w, dls_error *error) {
  dls_mpi_reduction *work = ((shared_solve *)data)->work;
  int failed = 1;
  work->A_symmetric = work->symmetric;
  if (work->symmetric) {
    shared_build(work, rho, w);
    failed = dlsi_spread_invert(&work->on_W, work->A, 1);
  }
  if (failed > 0) { /* not symmetric, or not definite */
    work->A_symmetric = 0;
    shared_build(work, rho, w);
    failed = dlsi_spread_invert(&work->on_W, work->A, 0);
  }
  if (failed < 0) return dlsi_no_memory(error);
  return failed ? DLS_E_SINGULAR : DLS_OK;
}

static void shared_apply(void *data, double *x) {
  const dls_mpi_reduction *work = ((shared_solve *)data)->work;
  dlsi_spread_multiply(&work->on_W, work->A, work->A_symmetric, 0, x, x);
}

static void shared_multiply(void *data, const double *r, double *u, double *a) {
  const dls_mpi_reduction *work = ((shared_solve *)data)->work;
  dlsi_spread_multiply(&work->on_W, work->W, work->symmetric, 0, r, u);
  for (int k = 0; k < work->m; k++)
    u[k] += work->q[k];
  if (a) dlsi_spread_multiply(&work->on_W, work->W, work->symmetric, 1, r, a);
}

/* blocks := the d x d blocks of W's diagonal. */
static void shared_diagonal(shared_solve *solve) {
  const dls_mpi_reduction *work = solve->work;
  const dlsi_spread *s = &work->on_W;
  const int d = work->d;
  memset(solve->blocks, 0, (size_t)d * (size_t)work->m * sizeof *solve->blocks);
  for (int j = 0, i = 0; j < s->cols; j++) {
    const int c = s->col[j] / d;
    while (i < s->rows && s->row[i] < d * c)
      i++;
    for (int k = i; k < s->rows && s->row[k] < d * c + d; k++)
      solve->blocks[d * s->col[j] + s->row[k] - d * c] =
          work->W[(size_t)k + (size_t)j * (size_t)s->rows];
  }
  (void)MPI_Allreduce(MPI_IN_PLACE, solve->blocks, d * work->m, MPI_DOUBLE, MPI_SUM,
                      work->grid.all);
}

/* ---- (MS3) ----------------------------------------------------------------------------------- */

/* The progress callback of each rank: does what rank 0's callback and clock say. */
static int shared_progress(void *data, const dls_progress *progress) {
  shared_solve *solve = data;
  const dls_limits *told = &solve->told;
  const int root = solve->work->grid.rank == 0;
  int stop = 0;
  if (root && told->progress) stop = told->progress(told->progress_data, progress) != 0;
  if (progress->last) return 0;
  if (root && !stop && dlsi_clock_is_over(told, solve->begun)) stop = 2;
  (void)MPI_Bcast(&stop, 1, MPI_INT, 0, solve->work->grid.all);
  solve->late = stop == 2;
  return stop != 0;
}

/* ---- the two ways ---------------------------------------------------------------------------- */

/* (MS1) */
static dls_status solve_gathered(shared_solve *solve, dls_info *info, dls_error *error) {
  dls_mpi_reduction *work = solve->work;
  const size_t m = (size_t)work->m;
  const int root = work->grid.rank == 0;
  double *W = root ? dlsi_alloc(m, m * sizeof *W) : NULL;
  dls_status status = root && !W ? dlsi_no_memory(error) : DLS_OK;
  status = dlsi_agree(work->grid.all, status, error);
  if (!status) status = dls_mpi_reduction_gather(work, W, error);
  if (!status && root) {
    const dls_contact problem = {.d = work->d,
                                 .nc = work->nodes,
                                 .W = {work->m, work->m, work->m, W},
                                 .q = work->q,
                                 .mu = solve->mu};
    dls_solver_settings s;
    dls_solver_settings_init(&s);
    s.limits = solve->settings.limits;
    status = dls_solve(&problem, &s, solve->r, solve->u, info, error);
  }
  free(W);
  int answer = (int)status;
  status = dlsi_agree(work->grid.all, status, error);
  if (status < 0) return status;
  (void)MPI_Bcast(&answer, 1, MPI_INT, 0, work->grid.all);
  (void)MPI_Bcast(solve->r, work->m, MPI_DOUBLE, 0, work->grid.all);
  (void)MPI_Bcast(solve->u, work->m, MPI_DOUBLE, 0, work->grid.all);
  (void)MPI_Bcast(info, (int)sizeof *info, MPI_BYTE, 0, work->grid.all);
  return (dls_status)answer;
}

/* (MS2) */
static dls_status solve_shared(shared_solve *solve, dls_info *info, dls_error *error) {
  dls_mpi_reduction *work = solve->work;
  const int nc = work->nodes;
  const MPI_Comm all = work->grid.all;
  dls_admm *admm = NULL;
  dls_admm_settings s;
  dls_admm_settings_init(&s);
  s.limits = solve->settings.limits;
  s.limits.blocks = nc;
  int watched = s.limits.progress || s.limits.cpu_seconds > 0;
  (void)MPI_Bcast(&watched, 1, MPI_INT, 0, all);
  solve->told = s.limits;
  solve->begun = dlsi_clock_start(&s.limits);
  s.limits.progress = watched ? shared_progress : NULL;
  s.limits.progress_data = solve;
  s.limits.cpu_seconds = 0;
  dls_status status = dls_admm_create(&admm, work->d, nc, &s, error);
  if (!status && !work->A) {
    work->A = dlsi_alloc(dlsi_spread_size(&work->on_W), sizeof *work->A);
    if (!work->A) status = dlsi_no_memory(error);
  }
  status = dlsi_agree(all, status, error);
  if (!status) {
    const dlsi_shared shared = {solve, shared_multiply, shared_factor, shared_apply};
    shared_diagonal(solve);
    const dls_blocks diagonal = {work->d, nc, solve->p, solve->i, solve->blocks};
    const dls_contact problem = {
        .d = work->d, .nc = nc, .Wb = diagonal, .q = work->q, .mu = solve->mu};
    dlsi_admm_share(admm, &shared);
    status = dls_admm_solve(admm, &problem, solve->r, solve->u, info, error);
    if (status == DLS_CANCELLED && solve->late) info->status = status = DLS_TIME_LIMIT;
  }
  dls_admm_destroy(admm);
  return status;
}

/* ---- the door -------------------------------------------------------------------------------- */

static dls_status solve_check(const dls_mpi_reduction *work, const double *mu,
                              const dls_mpi_settings *s, const double *r, dls_error *error) {
  const dlsi_setting own[] = {{"gather", s->gather, 0, INT_MAX, 0}};
  dls_status status = dlsi_check_settings(&s->limits, s->size, sizeof *s, 1, own, error);
  if (status || work->own == 0) return status;
  if (!mu) return dlsi_is_null(error, "mu");
  if (!r) return dlsi_is_null(error, "r");
  status = dlsi_check_friction(mu, (size_t)work->own, error);
  if (!status && s->limits.warm_start)
    status = dlsi_check_vector("r", r, (size_t)(work->d * work->own), error);
  return status;
}

static dls_status solve_allocate(shared_solve *solve, dls_error *error) {
  const size_t d = (size_t)solve->work->d, m = (size_t)solve->work->m, nc = m / d;
  solve->mu = calloc(nc + (3 + d) * m + 1, sizeof *solve->mu);
  solve->p = dlsi_alloc(2 * nc + 1, sizeof *solve->p);
  if (!solve->mu || !solve->p) return dlsi_no_memory(error);
  solve->r = solve->mu + nc;
  solve->u = solve->r + m;
  solve->blocks = solve->u + m;
  solve->i = solve->p + nc + 1;
  for (size_t c = 0; c <= nc; c++) {
    solve->p[c] = (int)c;
    if (c < nc) solve->i[c] = (int)c;
  }
  return DLS_OK;
}

/* Takes rank 0's settings, and mu and the start of all ranks. own: scratch, m. */
static void solve_take(shared_solve *solve, const double *mu, const double *r, double *own) {
  const dls_mpi_reduction *work = solve->work;
  dls_limits *limits = &solve->settings.limits;
  double numbers[] = {limits->tol, limits->max_iterations, limits->warm_start,
                      solve->settings.gather};
  (void)MPI_Bcast(numbers, 4, MPI_DOUBLE, 0, work->grid.all);
  limits->tol = numbers[0];
  limits->max_iterations = (int)numbers[1];
  limits->warm_start = (int)numbers[2];
  solve->settings.gather = (int)numbers[3];
  for (int k = 0; k < work->d * work->own; k++)
    own[k] = mu[k / work->d];
  dlsi_mpi_gather_nodes(work, own, solve->u);
  for (int c = 0; c < work->nodes; c++)
    solve->mu[c] = solve->u[work->d * c];
  for (int k = 0; k < work->d * work->own; k++)
    own[k] = limits->warm_start ? r[k] : 0;
  dlsi_mpi_gather_nodes(work, own, solve->r);
}

static dls_status mpi_solve(dls_mpi_reduction *work, const double *mu,
                            const dls_mpi_settings *settings, double *r, double *u, dls_info *info,
                            dls_error *error) {
  shared_solve solve = {.work = work};
  dls_info outcome = {0};
  dls_mpi_settings_init(&solve.settings);
  if (settings) solve.settings = *settings;
  dls_status status = solve_check(work, mu, &solve.settings, r, error);
  if (!status) status = solve_allocate(&solve, error);
  status = dlsi_agree(work->grid.all, status, error);
  if (!status) {
    const size_t own = (size_t)(work->d * work->own), first = (size_t)(work->d * work->first);
    solve_take(&solve, mu, r, work->local);
    const dls_contact empty = {.d = work->d, .nc = work->nodes};
    const dls_limits silent = {.tol = solve.settings.limits.tol};
    if (!dlsi_is_empty(&empty, work->grid.rank ? &silent : &solve.settings.limits, DLS_ADMM, "admm",
                       &outcome))
      status = work->m <= solve.settings.gather ? solve_gathered(&solve, &outcome, error)
                                                : solve_shared(&solve, &outcome, error);
    if (status >= 0 && own) {
      memcpy(r, solve.r + first, own * sizeof *r);
      if (u) memcpy(u, solve.u + first, own * sizeof *u);
    }
    if (status >= 0 && info) *info = outcome;
  }
  free(solve.mu);
  free(solve.p);
  return status;
}

dls_status dls_mpi_solve(dls_mpi_reduction *reduction, const double *mu,
                         const dls_mpi_settings *settings, double *r, double *u, dls_info *info,
                         dls_error *error) {
  DLSI_DOOR;
  dls_error why = {0};
  const dls_status status = reduction ? mpi_solve(reduction, mu, settings, r, u, info, &why)
                                      : dlsi_is_null(&why, "reduction");
  if (status < 0 && error) *error = why;
  return dlsi_at(__func__, status, error);
}
