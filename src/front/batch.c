/*
 * batch.c: solves many problems with one set of settings and one workspace.
 *
 *   (BT1)  up to dlsi_lanes consecutive small problems with the same number of contacts: swept side
 *          by side (vi/sweep/lanes.c), then measured one by one
 *   (BT2)  problems that are not small, and those whose certificate does not hold, from that r: the
 *          method's solve, in a workspace for the largest problem of its dimension, created at
 *          first use
 *
 * What can fail: what fails for the method. Each answer is independent of the other problems.
 */
#include <stdlib.h>
#include <string.h>

#include "front/front.h"
#include "vi/vi_internal.h"

enum { batch_rows = 3 * dlsi_lane_candidates };

/* Sizes of the problems of one dimension. */
typedef struct batch_sizes {
  int nc, blocks; /* the largest ones */
  dls_solver *solver;
} batch_sizes;

typedef struct batch {
  dls_solver_settings settings;
  const dls_contact *problem;
  double *const *r, *const *u;
  dls_info *info;
  batch_sizes of[4];     /* d = 1, 2, 3 */
  dlsi_lane_work *lanes; /* NULL: the settings exclude them */
} batch;

/* Checks problem k, and takes its size. */
static dls_status batch_look(batch *all, int k, dls_error *error) {
  const dls_contact *problem = &all->problem[k];
  dls_error why = {0};
  dls_status status = dlsi_check_contact(problem, &why);
  if (!status)
    status = dlsi_check_start(problem, all->r[k], all->u ? all->u[k] : NULL,
                              all->settings.limits.warm_start, &why);
  if (status) return dlsi_fail(error, status, "problem", k, why.value, "%.150s", why.message);
  batch_sizes *of = &all->of[problem->d];
  const int blocks = problem->nc && problem->Wb.x ? problem->Wb.p[problem->nc] : 0;
  if (problem->nc > of->nc) of->nc = problem->nc;
  if (blocks > of->blocks) of->blocks = blocks;
  return DLS_OK;
}

static int batch_has_lanes(const dls_solver_settings *s) {
  const dls_limits *limits = &s->limits;
  return s->method == DLS_AUTO && !s->plan && !s->without && !s->forces && !limits->warm_start &&
         !limits->progress && !limits->max_iterations && !(limits->cpu_seconds > 0);
}

/* Returns how many problems from k on go into the lanes together: 0 if problem k does not. */
static int batch_count(const batch *all, int k, int count) {
  const int nc = all->problem[k].nc;
  int found = 0;
  if (!all->lanes || nc < 1 || nc > dlsi_lane_candidates) return 0;
  while (found < dlsi_lanes && k + found < count && all->problem[k + found].nc == nc &&
         !all->problem[k + found].bodies.H && dlsi_has_plain_units(&all->problem[k + found]) &&
         dlsi_first_bonded(&all->problem[k + found]) < 0)
    found++;
  return found;
}

/* Copies the r of a lane to problem k. Returns 0 if its certificate does not hold, or if the caller
 * asks for contacts with several solutions, and there are some: *warm := 1 then if r is a good
 * start. */
static int batch_take(const batch *all, int lane, int k, int sweeps, int *warm) {
  const dls_contact *problem = &all->problem[k];
  const size_t m = (size_t)problem->d * (size_t)problem->nc;
  double x[batch_rows], v[batch_rows], a[batch_rows], F[batch_rows];
  double w[2 * dlsi_lane_candidates];
  dls_info info = {.method = DLS_AUTO, .iterations = sweeps, .stages = 1};
  dlsi_lane_get(all->lanes, lane, problem->d, x);
  dlsi_contact_multiply(problem, NULL, x, v, a);
  dlsi_certificate_weights(problem, w);
  dlsi_contact_measure(problem, x, v, a, w, F, &info.certificate);
  const int solved = dls_certificate_holds(&info.certificate, all->settings.limits.tol);
  *warm = solved || info.certificate.residual < 1; /* noise is solved with a residual of 1, too */
  if (*warm) memcpy(all->r[k], x, m * sizeof *x);
  if (!solved) return 0;
  if (all->info) {
    if (dlsi_count_ambiguous(problem, x, v, NULL)) return 0;
    info.stage[0] = (dls_stage){
        .method = DLS_NLGS, .iterations = sweeps, .residual = info.certificate.residual};
    all->info[k] = info;
  }
  if (all->u && all->u[k]) memcpy(all->u[k], v, m * sizeof *v);
  return 1;
}

/* (BT2) warm: 1 from r[k], 0 as in the settings. */
static dls_status batch_solve_one(batch *all, int k, int warm, dls_error *error) {
  const dls_contact *problem = &all->problem[k];
  batch_sizes *of = &all->of[problem->d];
  dls_status status = DLS_OK;
  if (!of->solver) {
    all->settings.limits.blocks = of->blocks;
    status = dlsi_solver_create(&of->solver, problem->d, of->nc, 1, &all->settings, error);
  }
  dls_limits limits = all->settings.limits;
  limits.warm_start |= warm;
  if (!status) status = dls_solver_set_limits(of->solver, &limits, error);
  if (status) return status;
  return dls_solver_solve(of->solver, problem, all->r[k], all->u ? all->u[k] : NULL,
                          all->info ? &all->info[k] : NULL, error);
}

/* Solves all problems, which have been checked. */
static dls_status batch_solve(batch *all, int count, dls_error *error) {
  dls_status first = DLS_OK;
  for (int k = 0; k < count;) {
    const int together = batch_count(all, k, count);
    const int sweeps =
        together ? dlsi_lane_solve(all->lanes, together, &all->problem[k], all->settings.limits.tol)
                 : 0;
    for (int end = k + (together ? together : 1), lane = 0; k < end; k++, lane++) {
      int warm = 0;
      if (together && batch_take(all, lane, k, sweeps, &warm)) continue;
      const dls_status status = batch_solve_one(all, k, warm, error);
      if (status < 0) return status;
      if (!first) first = status;
    }
  }
  return first;
}

static dls_status batch_run(batch *all, int count, const dls_solver_settings *settings,
                            dls_error *error) {
  dls_solver_settings_init(&all->settings);
  if (settings) all->settings = *settings;
  if (count < 0) return dlsi_fail(error, DLS_E_SIZE, "count", -1, count, "is %d", count);
  if (count > 0 && !all->problem) return dlsi_is_null(error, "problem");
  if (count > 0 && !all->r) return dlsi_is_null(error, "r");
  dls_status status = dlsi_solver_check(&all->settings, error);
  for (int k = 0; !status && k < count; k++)
    status = batch_look(all, k, error);
  if (status) return status;
  if (batch_has_lanes(&all->settings)) {
    all->lanes = dlsi_lane_create();
    if (!all->lanes) return dlsi_no_memory(error);
  }
  status = batch_solve(all, count, error);
  free(all->lanes);
  for (int d = 1; d <= 3; d++)
    dls_solver_destroy(all->of[d].solver);
  return status;
}

dls_status dls_solve_batch(int count, const dls_contact *problem,
                           const dls_solver_settings *settings, double *const *r, double *const *u,
                           dls_info *info, dls_error *error) {
  DLSI_DOOR;
  batch all = {.problem = problem, .r = r, .u = u, .info = info};
  return dlsi_at(__func__, batch_run(&all, count, settings, error), error);
}
