/*
 * nlgs.c: projected Gauss-Seidel on the reactions (nonlinear Gauss-Seidel), [Jean 1988] 3.3.
 *
 *   u = W r + q,   0 <= u_n _|_ r_n >= 0,   |r_t| <= mu r_n,   u_t opposed to r_t where it slips
 *
 * A sweep visits the contacts one after the other and solves the problem of each alone, with the
 * present reactions of all others. Each file begins with the rules of its code:
 *
 *   nlgs_sweep.c     (NL0)-(NL4) a sweep; (NL11) a sweep of rigid bodies
 *   nlgs_estimate.c  the residual after a sweep
 *   nlgs_loop.c      (NL5) sweeps until the certificate holds, or until there is a reason to stop
 *   nlgs_ways.c      (NL6), (NL7) acceleration; (NL8), (NL10) momentum; (NL12) the two in turn
 *   nlgs_sets.c      (NL9) extra sweeps where the residual is large
 *   nlgs_active.c    (NL13) sweeps over the contacts that act
 *   nlgs_work.h      the workspace; functions that these files share
 *
 * This file makes the workspace, prepares it for the storage of W, and has the public functions and
 * the row in the table of methods.
 *
 * Source: [Jean 1988] 3.3 names Gauss-Seidel on (3.3)5-6; the form with exact local solutions is
 * Jourdan, Alart and Jean 1998. Deviation: u is updated by columns; the usual code recomputes row c
 * of W r. The arithmetic is the same, but contacts that do not change cost nothing, and the
 * residual is free.
 *
 * Cost of a sweep: one pass over the columns of W of the contacts that changed, and O(nc). What can
 * fail: convergence with friction is not guaranteed. Sweeps can cycle without end (W SPD and mu = 1
 * suffice, tests/method/test_nlgs.c), and are many if W is ill-conditioned. A contact without a
 * local solution (W_cc indefinite, or wedged by a large mu) gets the point of least |F|; the
 * certificate then does not hold.
 */
#include <stdlib.h>

#include "nlgs_work.h"

enum { most_window = 100 };
/* contacts: groups pay from there on, slabs: with fewer their groups are less full */
enum { least_grouped = 500, least_slabbed = 4000 };
enum { large_panel = 2000 }; /* rows: W is 32 MB then, and a panel takes longer than a barrier */

void dls_nlgs_settings_init(dls_nlgs_settings *settings) {
  if (!settings) return;
  *settings = (dls_nlgs_settings){.size = sizeof *settings, .relaxation = 1, .window = 10};
  dlsi_limits_init(&settings->limits);
}

static void nlgs_carve(void *workspace, dlsi_arena *arena) {
  dls_nlgs *work = workspace;
  const dls_nlgs_settings *s = &work->settings;
  const size_t n = (size_t)work->nc, m = (size_t)work->d * n;
  if (work->d == 1)
    work->block_1d = dlsi_take(arena, n, sizeof *work->block_1d);
  else if (work->d == 2)
    work->block_2d = dlsi_take(arena, n, sizeof *work->block_2d);
  else
    work->block_3d = dlsi_take(arena, n, sizeof *work->block_3d);
  dlsi_iterate_carve(&work->it, arena, work->d, work->nc, &work->settings.limits);
  if (work->stage) {
    work->own_order = dlsi_take(arena, n, sizeof *work->own_order);
    work->scratch = dlsi_take(arena, n, sizeof *work->scratch);
  }
  if (work->stage != 1) {
    work->visits = dlsi_take(arena, n, sizeof *work->visits);
    work->earlier = dlsi_take(arena, 2 * n, sizeof *work->earlier);
  }
  if (s->acceleration == DLS_ACCELERATION_MOMENTUM) {
    dlsi_momentum_carve(&work->momentum, arena, m);
    work->carved[0] = work->momentum.u;
    work->carved[1] = work->momentum.pu;
    work->near = dlsi_take(arena, n, sizeof *work->near);
    work->some = dlsi_take(arena, n, sizeof *work->some);
    work->rows = dlsi_take(arena, n, sizeof *work->rows);
    work->acts = dlsi_take(arena, n, sizeof *work->acts);
    work->acting = dlsi_take(arena, n, sizeof *work->acting);
    if (work->stage) work->left.r = dlsi_take(arena, m, sizeof *work->left.r);
  }
  if (!dlsi_nlgs_has_history(s) && !dlsi_nlgs_may_turn(work)) return;
  work->x = dlsi_take(arena, m, sizeof *work->x);
  dlsi_anderson_carve(&work->history, arena, m,
                      s->acceleration == DLS_ACCELERATION_AITKEN ? 1 : s->window, m);
  work->history.shortens = !work->stage; /* a stage of auto ends instead */
  work->carved[2] = work->history.u;
  work->carved[3] = work->history.DU;
}

static dls_status nlgs_create(void **out, int d, int nc, int stage,
                              const dls_nlgs_settings *settings, dls_error *error) {
  dls_nlgs work = {.d = d, .nc = nc, .stage = stage};
  dls_nlgs_settings *s = &work.settings;
  dls_nlgs_settings_init(s);
  if (settings) *s = *settings;
  const dlsi_setting own[] = {{"relaxation", s->relaxation, 0, 2, 1},
                              {"acceleration", s->acceleration, 0, DLS_ACCELERATION_MOMENTUM, 0},
                              {"window", s->window, 1, most_window, 0}};
  *out = NULL;
  dls_status status = dlsi_check_sizes(d, nc, error);
  if (!status) status = dlsi_check_settings(&s->limits, s->size, sizeof *s, 3, own, error);
  return status ? status : dlsi_workspace(out, &work, sizeof work, nlgs_carve, nc, error);
}

dls_status dls_nlgs_create(dls_nlgs **out, int d, int nc, const dls_nlgs_settings *settings,
                           dls_error *error) {
  DLSI_DOOR;
  void *work = NULL;
  const dls_status status =
      out ? nlgs_create(&work, d, nc, 0, settings, error) : dlsi_is_null(error, "out");
  if (out) *out = work;
  return dlsi_at(__func__, status, error);
}

void dls_nlgs_destroy(dls_nlgs *workspace) {
  if (!workspace) return;
  dlsi_formed_free(&workspace->formed);
  dlsi_groups_free(&workspace->groups);
  dlsi_groups_free(&workspace->part);
  dlsi_groups_free(&workspace->active);
  dlsi_slabs_free(&workspace->slabs);
  free(workspace->bodies.moved);
  free(workspace->bodies.some);
  free(workspace);
}

/* ---- the solve ------------------------------------------------------------------------------- */

/* Makes room for the motions of bodies and what momentum needs of them. DLS_E_MEMORY. */
static dls_status nlgs_take_bodies(dls_nlgs *work, const dls_contact *problem, dls_error *error) {
  dlsi_nlgs_bodies *of = &work->bodies;
  const size_t count = (size_t)problem->bodies.count, all = (size_t)problem->bodies.n * count;
  const int pushed = work->settings.acceleration == DLS_ACCELERATION_MOMENTUM;
  work->motions = problem->bodies.n;
  work->v = problem->bodies.work;
  if (!pushed) return DLS_OK;
  const size_t columns = dlsi_nlgs_may_turn(work) ? (size_t)work->history.window + 1 : 0;
  double *moved = dlsi_make_room(of->moved, &of->moved_room, (2 + columns) * all, sizeof *moved);
  if (!moved) return dlsi_no_memory(error);
  of->moved = moved;
  int *some = dlsi_make_room(of->some, &of->some_room, 2 * count, sizeof *some);
  if (!some) return dlsi_no_memory(error);
  of->some = some;
  work->momentum.u = moved;
  work->momentum.pu = moved + all;
  if (columns) {
    work->history.of_u = all;
    work->history.u = moved + 2 * all;
    work->history.DU = moved + 3 * all;
  }
  return DLS_OK;
}

/* Prepares the workspace for the storage. Bodies stay factored (NL11), except for (NL6), which
 * combines u. Slabs follow from the problem, not from the threads. DLS_E_MEMORY, DLS_E_SIZE. */
static dls_status nlgs_prepare(dls_nlgs *work, const dls_contact **problem, const int *order,
                               dls_error *error) {
  work->motions = 0;
  work->momentum.u = work->carved[0];
  work->momentum.pu = work->carved[1];
  work->history.u = work->carved[2];
  work->history.DU = work->carved[3];
  work->history.of_u = (size_t)work->d * (size_t)(*problem)->nc;
  work->grouped = work->whole = 0;
  dls_status status = dlsi_nlgs_has_history(&work->settings)
                          ? dlsi_form_blocks(&work->formed, problem, error)
                          : dlsi_lend(&work->formed, problem, error);
  if (!status && dlsi_is_factored(*problem)) status = nlgs_take_bodies(work, *problem, error);
  if (status || order || (*problem)->W.a || (*problem)->nc < least_grouped ||
      work->settings.relaxation != 1)
    return status;
  const int known = work->knows && work->motions,
            slabbed = (*problem)->nc >= least_slabbed && !known;
  if (slabbed != (work->slabs.set.slabs > 0)) work->groups.kept_size = 0;
  if (!slabbed) /* as numbered */
    work->slabs.set = (dlsi_set){.list = work->visited == (*problem)->nc ? work->visits : NULL,
                                 .count = (*problem)->nc};
  else if (!dlsi_groups_are_of(&work->groups, *problem))
    status = dlsi_slabs_set(&work->slabs, *problem, error);
  work->grouped = known; /* (NL13) makes groups where it ends */
  if (!status && !known) {
    status = dlsi_groups_set(&work->groups, *problem, work->slabs.set, NULL, error);
    work->grouped = work->whole = !status && work->groups.count > 0;
  }
  if (work->grouped && !work->motions) work->history.of_u = 0;
  return status;
}

/* The arguments of dlsi_nlgs_run, for a team. */
typedef struct nlgs_run {
  dls_nlgs *work;
  const dls_contact *problem;
  const int *order;
  double *r, *u;
  dls_info *info;
  dls_status status;
} nlgs_run;

static void nlgs_run_in_team(dlsi_team *team, void *data) {
  nlgs_run *run = data;
  run->work->team = run->work->momentum.team = team;
  run->status = dlsi_nlgs_run(run->work, run->problem, run->order, NULL, run->r, run->u, run->info);
  run->work->team = run->work->momentum.team = NULL;
}

static dls_status nlgs_solve(void *workspace, const dls_contact *problem, double *r, double *u,
                             dls_info *info, dls_error *error) {
  dls_nlgs *work = workspace;
  double *const key[] = {work->it.u, work->it.a, work->it.F};
  /* momentum is for large problems, whose numbers put neighbours side by side */
  const int *order = work->stage == 1 ? work->own_order : NULL;
  dls_status status = nlgs_prepare(work, &problem, order, error);
  if (status) return status;
  if (order) dlsi_order_candidates(problem, key, work->scratch, work->own_order);
  nlgs_run run = {work, problem, order, r, u, info, DLS_OK};
  const int large = work->grouped ? work->slabs.set.slabs > 1
                                  : problem->W.a && problem->d * problem->nc >= large_panel;
  dlsi_team_run(large ? work->settings.limits.threads : 1, nlgs_run_in_team, &run);
  status = run.status;
  if (status == DLS_E_MEMORY) status = dlsi_no_memory(error);
  if (status < 0) return status;
  if (info && !work->stage) info->ambiguous = dlsi_count_ambiguous(problem, r, work->it.u, NULL);
  return status;
}

dls_status dls_nlgs_solve(dls_nlgs *workspace, const dls_contact *problem, double *r, double *u,
                          dls_info *info, dls_error *error) {
  DLSI_DOOR;
  dls_status status = dlsi_iterate_enter(workspace ? &workspace->it : NULL, problem, r, u, error);
  if (status) return dlsi_at(__func__, status, error);
  if (dlsi_is_empty(problem, &workspace->settings.limits, DLS_NLGS, "nlgs", info))
    return dlsi_leave(&workspace->it.busy, DLS_OK);
  status = nlgs_solve(workspace, problem, r, u, info, error);
  status = dlsi_iterate_leave(&workspace->it, "nlgs", status, r);
  return dlsi_at(__func__, status, error);
}

/* ---- in the table of methods ----------------------------------------------------------------- */

static dls_status nlgs_create_by(void **out, int d, int nc, const dlsi_options *options,
                                 dls_error *error) {
  dls_nlgs_settings s;
  dls_nlgs_settings_init(&s);
  s.limits = options->limits;
  s.acceleration = (dls_acceleration)options->acceleration;
  static const dls_acceleration of_stage[] = {
      [1] = DLS_ACCELERATION_ANDERSON, [2] = DLS_ACCELERATION_MOMENTUM};
  if (options->stage) s.acceleration = of_stage[options->stage];
  return nlgs_create(out, d, nc, options->stage, &s, error);
}

static void nlgs_destroy(void *work) {
  dls_nlgs_destroy(work);
}

/* Appends contact c to the visits, and the new ones that are numbered after it. */
static int nlgs_append(int *visits, int count, int c, int nc, const int *from) {
  do
    visits[count++] = c++;
  while (c < nc && from[c] < 0);
  return count;
}

void dlsi_nlgs_forget(void *work) {
  ((dls_nlgs *)work)->left.residual = 0;
}

const double *dlsi_nlgs_gap(const void *work) {
  return ((const dls_nlgs *)work)->it.u;
}

void dlsi_nlgs_map(void *workspace, int nc, const int *from) {
  dls_nlgs *work = workspace;
  work->knows = from && work->acts;
  if (!work->visits || (!from && !work->visited)) return;
  int *old = work->earlier, *now = old + work->nc, count = 0, moved = 0;
  const int had = work->visited;
  memcpy(old, work->visits, (size_t)had * sizeof *old);
  work->visited = 0;
  work->groups.kept_size = had ? 0 : work->groups.kept_size;
  if (!from) return;
  for (int k = 0; k < work->nc; k++) /* now[k]: what contact k of the last solve is called now */
    now[k] = -1;
  for (int c = 0; c < nc; c++)
    if (from[c] >= 0) now[from[c]] = c;
  if (nc > 0 && from[0] < 0) count = nlgs_append(work->visits, count, 0, nc, from);
  for (int k = 0; k < (had ? had : work->nc); k++) {
    const int c = now[had ? old[k] : k];
    if (c >= 0) count = nlgs_append(work->visits, count, c, nc, from);
  }
  for (int k = 0; k < nc; k++)
    moved |= work->visits[k] != k;
  if (count == nc && moved) work->visited = nc;
  if (work->visited) work->groups.kept_size = 0;
}

const dlsi_method dlsi_nlgs_method = {
    .method = DLS_NLGS,
    .name = "nlgs",
    .summary = "sweeps of Gauss-Seidel: any W, 1e-4 to 1e-8; accelerated, more",
    .create = nlgs_create_by,
    .solve = nlgs_solve,
    .destroy = nlgs_destroy,
    .limits = offsetof(dls_nlgs, settings.limits),
    .map = dlsi_nlgs_map,
    .takes_bodies = 1,
};
