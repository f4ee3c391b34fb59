/*
 * solve.c: solves the contact problem of a reduction on several ranks.
 *
 *   (MS1)  up to settings.gather rows: W goes to rank 0, which calls dls_solve
 *   (MS2)  above: each rank runs the iteration of admm.c on the same vectors. Only work with the
 *          matrix is shared: A := (W + rho D)^-1 for each rho, one product with A an iteration, one
 *          with W and one with |W| for a certificate
 *
 *   (MS4)  x := K^-1 (f + H r), and the certificate of (x, r) on the body decides, as in
 *          src/front/body.c
 *   (MS5)  if it does not hold, and r solves the problem on W: again from r, with the tolerance on
 *          W that the residual of the body requires, as long as that residual halves. The two
 *          residuals have different scales and weights: by a factor on ordinary bodies, by 1e8 on
 *          soft springs, where no tolerance helps
 *
 * Numbers of (MS2) are equal on all ranks to the last bit (grid.c), so that all ranks stop at the
 * same place. Clock and callback differ by rank: those of rank 0 count (MS3).
 * Cost: per rho m^3 (2 m^3 by LU) over the ranks; per iteration 2 m^2 over the ranks and O(m); per
 * turn of (MS5) a solve and a product with K.
 */
#include <limits.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "delassus/solve.h"
#include "front/front.h"
#include "mpi_internal.h"
#include "vi/vi_internal.h"

enum { gather_rows = 1000, most_turns = 4 }; /* most_turns: of (MS5) */

static const double least_tol = 1e-15;

void dls_mpi_settings_init(dls_mpi_settings *settings) {
  if (!settings) return;
  *settings = (dls_mpi_settings){.size = sizeof *settings, .gather = gather_rows};
  dlsi_limits_init(&settings->limits);
}

/* The data of a solve on every rank: vectors of all ranks. */
typedef struct shared_solve {
  dls_mpi_reduction *work;
  dls_mpi_settings settings;
  double *mu, *r, *u, *blocks; /* nc, m, m, d m */
  double *x;                   /* rows */
  int *p, *i;                  /* nc + 1, nc */
  dlsi_mpi_watch watch;        /* (MS3) */
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
      work->A[(size_t)i + (size_t)j * (size_t)s->rows] += rho * w[s->col[j] / work->of.d];
  }
}

static dls_status shared_factor(void *data, double rho, const double *w, dls_error *error) {
  dls_mpi_reduction *work = ((shared_solve *)data)->work;
  int failed = 1;
  work->A_symmetric = work->of.symmetric;
  if (work->of.symmetric) {
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
  dlsi_spread_multiply(&work->on_W, work->W, work->of.symmetric, 0, r, u);
  for (int k = 0; k < work->of.m; k++)
    u[k] += work->q[k];
  if (a) dlsi_spread_multiply(&work->on_W, work->W, work->of.symmetric, 1, r, a);
}

/* blocks := the d x d blocks of W's diagonal. */
static void shared_diagonal(shared_solve *solve) {
  const dls_mpi_reduction *work = solve->work;
  const dlsi_spread *s = &work->on_W;
  const int d = work->of.d;
  memset(solve->blocks, 0, (size_t)d * (size_t)work->of.m * sizeof *solve->blocks);
  for (int j = 0, i = 0; j < s->cols; j++) {
    const int c = s->col[j] / d;
    while (i < s->rows && s->row[i] < d * c)
      i++;
    for (int k = i; k < s->rows && s->row[k] < d * c + d; k++)
      solve->blocks[d * s->col[j] + s->row[k] - d * c] =
          work->W[(size_t)k + (size_t)j * (size_t)s->rows];
  }
  (void)MPI_Allreduce(MPI_IN_PLACE, solve->blocks, d * work->of.m, MPI_DOUBLE, MPI_SUM,
                      work->of.grid.all);
}

/* ---- (MS3) ----------------------------------------------------------------------------------- */

/* Called at the same iteration on every rank. */
static int watch_progress(void *data, const dls_progress *progress) {
  dlsi_mpi_watch *watch = data;
  const dls_limits *told = &watch->told;
  int stop = 0;
  if (watch->root && told->progress) stop = told->progress(told->progress_data, progress) != 0;
  if (progress->last) return 0;
  if (watch->root && !stop && dlsi_clock_is_over(told, watch->begun)) stop = 2;
  (void)MPI_Bcast(&stop, 1, MPI_INT, 0, watch->all);
  watch->late = stop == 2;
  return stop != 0;
}

void dlsi_mpi_watch_begin(dlsi_mpi_watch *watch, const dlsi_grid *grid, dls_limits *limits) {
  int watched = limits->progress || limits->cpu_seconds > 0;
  (void)MPI_Bcast(&watched, 1, MPI_INT, 0, grid->all);
  *watch = (dlsi_mpi_watch){.all = grid->all,
                            .root = grid->rank == 0,
                            .told = *limits,
                            .begun = dlsi_clock_start(limits)};
  limits->progress = watched ? watch_progress : NULL;
  limits->progress_data = watch;
  limits->cpu_seconds = 0;
}

void dlsi_mpi_take_limits(const dlsi_grid *grid, dls_limits *limits) {
  double numbers[] = {limits->tol, limits->max_iterations, limits->warm_start};
  (void)MPI_Bcast(numbers, 3, MPI_DOUBLE, 0, grid->all);
  limits->tol = numbers[0];
  limits->max_iterations = (int)numbers[1];
  limits->warm_start = (int)numbers[2];
}

/* ---- the two methods ------------------------------------------------------------------------- */

/* (MS1) */
static dls_status solve_gathered(shared_solve *solve, dls_info *info, dls_error *error) {
  dls_mpi_reduction *work = solve->work;
  const size_t m = (size_t)work->of.m;
  const int root = work->of.grid.rank == 0;
  double *W = root ? dlsi_alloc(m, m * sizeof *W) : NULL;
  dls_status status = root && !W ? dlsi_no_memory(error) : DLS_OK;
  status = dlsi_agree(work->of.grid.all, status, error);
  if (!status) status = dls_mpi_reduction_gather(work, W, error);
  if (!status && root) {
    const dls_contact problem = {.d = work->of.d,
                                 .nc = work->of.nodes,
                                 .W = {work->of.m, work->of.m, work->of.m, W},
                                 .q = work->q,
                                 .mu = solve->mu};
    dls_solver_settings s;
    dls_solver_settings_init(&s);
    s.limits = solve->settings.limits;
    status = dls_solve(&problem, &s, solve->r, solve->u, info, error);
  }
  free(W);
  int answer = (int)status;
  status = dlsi_agree(work->of.grid.all, status, error);
  if (status < 0) return status;
  (void)MPI_Bcast(&answer, 1, MPI_INT, 0, work->of.grid.all);
  (void)MPI_Bcast(solve->r, work->of.m, MPI_DOUBLE, 0, work->of.grid.all);
  (void)MPI_Bcast(solve->u, work->of.m, MPI_DOUBLE, 0, work->of.grid.all);
  (void)MPI_Bcast(info, (int)sizeof *info, MPI_BYTE, 0, work->of.grid.all);
  return (dls_status)answer;
}

/* (MS2) */
static dls_status solve_shared(shared_solve *solve, dls_info *info, dls_error *error) {
  dls_mpi_reduction *work = solve->work;
  const int nc = work->of.nodes;
  const MPI_Comm all = work->of.grid.all;
  dls_admm *admm = NULL;
  dls_admm_settings s;
  dls_admm_settings_init(&s);
  s.limits = solve->settings.limits;
  s.limits.blocks = nc;
  dlsi_mpi_watch_begin(&solve->watch, &work->of.grid, &s.limits);
  dls_status status = dls_admm_create(&admm, work->of.d, nc, &s, error);
  if (!status && !work->A) {
    work->A = dlsi_alloc(dlsi_spread_size(&work->on_W), sizeof *work->A);
    if (!work->A) status = dlsi_no_memory(error);
  }
  status = dlsi_agree(all, status, error);
  if (!status) {
    const dlsi_shared shared = {solve, shared_multiply, shared_factor, shared_apply};
    shared_diagonal(solve);
    const dls_blocks diagonal = {work->of.d, nc, solve->p, solve->i, solve->blocks};
    const dls_contact problem = {
        .d = work->of.d, .nc = nc, .Wb = diagonal, .q = work->q, .mu = solve->mu};
    dlsi_admm_share(admm, &shared);
    status = dls_admm_solve(admm, &problem, solve->r, solve->u, info, error);
    if (status == DLS_CANCELLED && solve->watch.late) info->status = status = DLS_TIME_LIMIT;
  }
  dls_admm_destroy(admm);
  return status;
}

/* ---- the certificate of the body ------------------------------------------------------------- */

static const double usual_tol = 1e-8; /* of dls_mpi_certify, which has none of its own */

/* Measures (x, r), or on the problem without the body's own deformation (linear/own.h) if only that
 * can tell: K is regular, so y = x - K^-1 f, f' = 0 and g' = q. mu, r, u: of this rank's nodes; x:
 * rows. Collective. */
static dls_status measure_pair(dls_mpi_reduction *work, const double *mu, const double *r,
                               const double *x, double tol, double *u, dls_certificate *found,
                               dls_error *error) {
  const dlsi_body *body = &work->body.body;
  const size_t own = (size_t)(work->of.d * work->of.own),
               first = (size_t)(work->of.d * work->of.first);
  dlsi_body_measure(body, work->f, work->gap + first, mu, r, x, u, work->body.scratch, found);
  if (dlsi_certificate_verdict(found, tol) != DLS_STALLED) return DLS_OK;
  dls_certificate loose = *found;
  dlsi_forces_loose(body, work->body.scratch, &loose);
  if (dlsi_certificate_verdict(&loose, tol) == DLS_STALLED) return DLS_OK;
  if (dlsi_joined_norm(body->ranks, r, own) == 0) {
    *found = loose;
    return DLS_OK;
  }
  const dls_status status = dlsi_mpi_own(work, error);
  if (status) return status;
  for (int j = 0; j < work->of.rows; j++)
    work->b[j] = x[j] - work->b[j];
  dlsi_body_measure(body, NULL, work->q + first, mu, r, work->b, u, work->body.scratch, found);
  return DLS_OK;
}

/* (MS4) */
static dls_status solve_judge(shared_solve *solve, double tol, dls_info *info, dls_error *error) {
  dls_mpi_reduction *work = solve->work;
  const size_t d = (size_t)work->of.d, first = (size_t)work->of.first;
  dls_certificate seen;
  dls_status status = dlsi_mpi_recover(work, solve->r, solve->x, error);
  if (!status)
    status = measure_pair(work, solve->mu + first, solve->r + d * first, solve->x, tol, work->local,
                          &seen, error);
  if (status) return status;
  dlsi_shares_gather_nodes(&work->of, work->local, solve->u);
  dlsi_body_judge(info, &seen, tol, work->condition);
  return info->status;
}

static dls_status mpi_certify(dls_mpi_reduction *work, const double *mu, const double *r,
                              const double *x, double *u, dls_certificate *certificate,
                              dls_error *error) {
  const dlsi_shares *of = &work->of;
  const int own = of->d * of->own;
  dls_status status = dlsi_shares_check_vector("r", r, own, 0, error);
  if (!status) status = dlsi_shares_check_vector("x", x, of->rows, 0, error);
  if (!status && of->own && !mu) status = dlsi_is_null(error, "mu");
  if (!status && of->own) status = dlsi_check_friction(mu, (size_t)of->own, error);
  if (!status && !certificate) status = dlsi_is_null(error, "certificate");
  status = dlsi_agree(of->grid.all, status, error);
  if (status) return status;
  static const double nothing = 0; /* of a rank without rows, or without nodes */
  status = measure_pair(work, mu, own ? r : &nothing, of->rows ? x : &nothing, usual_tol,
                        work->local, certificate, error);
  if (!status && u && own) memcpy(u, work->local, (size_t)own * sizeof *u);
  return status;
}

dls_status dls_mpi_certify(dls_mpi_reduction *reduction, const double *mu, const double *r,
                           const double *x, double *u, dls_certificate *certificate,
                           dls_error *error) {
  DLSI_DOOR;
  dls_error why = {0};
  const dls_status status = reduction ? mpi_certify(reduction, mu, r, x, u, certificate, &why)
                                      : dlsi_is_null(&why, "reduction");
  if (status && error) *error = why;
  return dlsi_at(__func__, status, error);
}

/* Solves on W within the limits of solve->settings. */
static dls_status solve_on_W(shared_solve *solve, dls_info *info, dls_error *error) {
  const dls_mpi_reduction *work = solve->work;
  const dls_contact empty = {.d = work->of.d, .nc = work->of.nodes};
  const dls_limits silent = {.tol = solve->settings.limits.tol};
  if (dlsi_is_empty(&empty, work->of.grid.rank ? &silent : &solve->settings.limits, DLS_ADMM,
                    "admm", info))
    return DLS_OK;
  return work->of.m <= solve->settings.gather ? solve_gathered(solve, info, error)
                                              : solve_shared(solve, info, error);
}

/* Shows a caller's callback the turns of (MS5) as one solve, with its last call at the very end. */
typedef struct turns {
  const dls_limits *asked;
  double before; /* CPU seconds of the previous turns */
} turns;

static int turns_progress(void *data, const dls_progress *progress) {
  turns *of = data;
  dls_progress now = *progress;
  now.cpu_seconds += of->before;
  if (progress->last) {
    of->before = now.cpu_seconds;
    return 0;
  }
  return of->asked->progress(of->asked->progress_data, &now);
}

/* Leaves the rest of the limits to the next turn of (MS5); returns 0 if nothing is left.
 * Collective: by the clock of rank 0. */
static int solve_goes_on(shared_solve *solve, const dls_limits *asked, double begun,
                         const dls_info *info) {
  dls_limits *limits = &solve->settings.limits;
  double left = 1;
  if (asked->max_iterations) limits->max_iterations = asked->max_iterations - info->iterations;
  if (asked->cpu_seconds > 0) left = limits->cpu_seconds = dlsi_clock_left(asked, begun);
  (void)MPI_Bcast(&left, 1, MPI_DOUBLE, 0, solve->work->of.grid.all);
  limits->tol *= asked->tol / info->certificate.residual / 2;
  limits->warm_start = 1;
  return left > 0 && limits->max_iterations >= 0 && limits->tol >= least_tol &&
         !(asked->max_iterations && limits->max_iterations == 0);
}

/* (MS5) */
static dls_status solve_body(shared_solve *solve, dls_info *info, dls_error *error) {
  const dls_limits asked = solve->settings.limits;
  const double begun = dlsi_clock_start(&asked);
  double best = INFINITY;
  dls_status status = DLS_OK;
  turns seen = {&asked, 0};
  if (asked.progress) {
    solve->settings.limits.progress = turns_progress;
    solve->settings.limits.progress_data = &seen;
  }
  for (int turn = 0; turn < most_turns; turn++) {
    const dls_info before = *info;
    status = solve_on_W(solve, info, error);
    if (status < 0) break;
    const int certified = dls_solved(status);
    status = solve_judge(solve, asked.tol, info, error);
    if (status < 0) break;
    info->iterations += before.iterations;
    info->factorisations += before.factorisations;
    const double residual = info->certificate.residual;
    const int helps = status == DLS_STALLED || status == DLS_NOT_IN_EQUILIBRIUM;
    if (!helps || !certified || !(residual <= best / 2)) break;
    best = residual;
    if (!solve_goes_on(solve, &asked, begun, info)) break;
  }
  solve->settings.limits = asked;
  if (status < 0) return status;
  if (solve->work->of.grid.rank == 0) {
    const char *name = dls_method_name(info->method);
    dlsi_tell_last(&asked, begun, name, name, info->iterations, info->certificate.residual,
                   solve->r);
  }
  return info->status;
}

/* ---- the door -------------------------------------------------------------------------------- */

static dls_status solve_check(const dls_mpi_reduction *work, const double *mu,
                              const dls_mpi_settings *s, const double *r, dls_error *error) {
  const dlsi_setting own[] = {{"gather", s->gather, 0, INT_MAX, 0}};
  dls_status status = dlsi_check_settings(&s->limits, s->size, sizeof *s, 1, own, error);
  if (status || work->of.own == 0) return status;
  if (!mu) return dlsi_is_null(error, "mu");
  if (!r) return dlsi_is_null(error, "r");
  status = dlsi_check_friction(mu, (size_t)work->of.own, error);
  if (!status && s->limits.warm_start)
    status = dlsi_check_vector("r", r, (size_t)(work->of.d * work->of.own), error);
  return status;
}

static dls_status solve_allocate(shared_solve *solve, dls_error *error) {
  const size_t d = (size_t)solve->work->of.d, m = (size_t)solve->work->of.m, nc = m / d;
  const size_t rows = (size_t)solve->work->of.rows;
  solve->mu = calloc(nc + (3 + d) * m + rows + 1, sizeof *solve->mu);
  solve->p = dlsi_alloc(2 * nc + 1, sizeof *solve->p);
  if (!solve->mu || !solve->p) return dlsi_no_memory(error);
  solve->r = solve->mu + nc;
  solve->u = solve->r + m;
  solve->blocks = solve->u + m;
  solve->x = solve->blocks + d * m;
  solve->i = solve->p + nc + 1;
  for (size_t c = 0; c <= nc; c++) {
    solve->p[c] = (int)c;
    if (c < nc) solve->i[c] = (int)c;
  }
  return DLS_OK;
}

/* Copies rank 0's settings, and mu and the start of all ranks. own: scratch, m. */
static void solve_take(shared_solve *solve, const double *mu, const double *r, double *own) {
  const dls_mpi_reduction *work = solve->work;
  dls_limits *limits = &solve->settings.limits;
  dlsi_mpi_take_limits(&work->of.grid, limits);
  (void)MPI_Bcast(&solve->settings.gather, 1, MPI_INT, 0, work->of.grid.all);
  for (int k = 0; k < work->of.d * work->of.own; k++)
    own[k] = mu[k / work->of.d];
  dlsi_shares_gather_nodes(&work->of, own, solve->u);
  for (int c = 0; c < work->of.nodes; c++)
    solve->mu[c] = solve->u[work->of.d * c];
  for (int k = 0; k < work->of.d * work->of.own; k++)
    own[k] = limits->warm_start ? r[k] : 0;
  dlsi_shares_gather_nodes(&work->of, own, solve->r);
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
  status = dlsi_agree(work->of.grid.all, status, error);
  if (!status) {
    const size_t own = (size_t)(work->of.d * work->of.own),
                 first = (size_t)(work->of.d * work->of.first);
    solve_take(&solve, mu, r, work->local);
    status = solve_body(&solve, &outcome, error);
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
