/*
 * motion.c: makes a motion, starts it, changes its step, shows it. step.c has the scheme.
 *
 * Memory: that of the reduction of A; O(n + nnz); on W that of the solver and (d nc)^2 doubles.
 * Fails: settings or sizes that do not fit, a singular A, no memory.
 */
#include <float.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "contact/body.h"
#include "front/front.h"
#include "motion/motion_internal.h"

void dls_motion_settings_init(dls_motion_settings *settings) {
  if (!settings) return;
  *settings = (dls_motion_settings){.size = sizeof *settings,
                                    .law = DLS_MOTION_VELOCITY,
                                    .method = DLS_AUTO,
                                    .theta = 0.5,
                                    .forecast = 0.5};
  dlsi_limits_init(&settings->limits);
  settings->limits.tol = 1e-12;
  settings->limits.warm_start = 1;
}

/* ---- checks ---------------------------------------------------------------------------------- */

static dls_status motion_check_h(double h, dls_error *error) {
  const dlsi_setting own = {"h", h, 0, INFINITY, 1};
  return dlsi_check_each(1, &own, error);
}

static dls_status motion_check_settings(const dls_motion_settings *s, dls_error *error) {
  const int path = s->law == DLS_MOTION_PATH;
  const dlsi_setting own[] = {{"law", s->law, DLS_MOTION_VELOCITY, DLS_MOTION_PATH, 0},
                              {"theta", path ? 1 : s->theta, 0.5, 1, 0},
                              {"restitution", s->restitution, 0, 1, 0},
                              {"activation", s->activation, 0, DBL_MAX, 0},
                              {"forecast", s->forecast, 0, 1, 0},
                              {"energy_consistent", s->energy_consistent, 0, 1, 0}};
  dls_status status =
      dlsi_check_settings(&s->limits, s->size, sizeof *s, sizeof own / sizeof own[0], own, error);
  if (!status) status = motion_check_h(s->h, error);
  if (status) return status;
  if (s->law == DLS_MOTION_GAP && s->theta < 1)
    return dlsi_fail(
        error, DLS_E_ARGUMENT, "theta", -1, s->theta,
        "is %g, but the gap form needs 1: with less its impulses do not converge with h", s->theta);
  if (s->law != DLS_MOTION_VELOCITY && s->restitution > 0)
    return dlsi_fail(error, DLS_E_ARGUMENT, "restitution", -1, s->restitution,
                     "is %g, but only the velocity form has impacts", s->restitution);
  return DLS_OK;
}

/* Replaces Ks, the matrix of a reduction's model, by the caller's name for it in errors. */
static dls_status motion_name(dls_status status, const char *name, dls_error *error) {
  if (!status || !error || strcmp(error->argument, "Ks") != 0) return status;
  char text[sizeof error->message];
  const char *after = strstr(error->message, "Ks");
  (void)snprintf(text, sizeof text, "%s%s", name, after ? after + 2 : "");
  memcpy(error->message, text, sizeof text);
  error->argument = name;
  error->function = "";
  return status;
}

/* Makes a model for a reduction of the bodies, with the matrix Ks. */
static dls_model motion_reduced_model(const dls_motion_model *model, dls_sparse Ks) {
  return (dls_model){.d = model->d,
                     .n = model->n,
                     .nodes = model->nodes,
                     .operator_kind = DLS_STIFFNESS_SPARSE,
                     .factorization = model->factorization,
                     .Ks = Ks,
                     .HN = model->HN,
                     .HT = model->HT,
                     .P = model->P};
}

/* Checks a matrix that a law must have (1), may have (0) or must not have (-1), together with the
 * rest of the model. */
static dls_status motion_check_matrix(const char *name, const dls_motion_model *model,
                                      const dls_sparse *A, int wanted, dls_error *error) {
  if (!A->p && wanted > 0) return dlsi_is_null(error, name);
  if (!A->p) return DLS_OK;
  if (wanted < 0)
    return dlsi_fail(error, DLS_E_ARGUMENT, name, -1, 0, "is given, but a path has none");
  const dls_model with = motion_reduced_model(model, *A);
  return motion_name(dlsi_check_model(&with, error), name, error);
}

static dls_status motion_check_model(const dls_motion_model *model, int path, dls_error *error) {
  if (!model) return dlsi_is_null(error, "model");
  dls_status status = motion_check_matrix("M", model, &model->M, path ? -1 : 1, error);
  if (!status) status = motion_check_matrix("C", model, &model->C, path ? -1 : 0, error);
  if (!status) status = motion_check_matrix("K", model, &model->K, path ? 1 : 0, error);
  if (status || !model->gap) return status;
  return dlsi_check_vector("gap", model->gap, (size_t)model->nodes, error);
}

/* ---- create ---------------------------------------------------------------------------------- */

static void motion_carve_point(const dls_motion *motion, motion_point *point, dlsi_arena *arena) {
  const size_t d = (size_t)motion->model.d, n = motion->n, nc = motion->candidates;
  point->x = dlsi_take(arena, n, sizeof *point->x);
  point->v = dlsi_take(arena, n, sizeof *point->v);
  point->kx = dlsi_take(arena, n, sizeof *point->kx);
  point->p = dlsi_take(arena, motion->m, sizeof *point->p);
  point->u = dlsi_take(arena, motion->m, sizeof *point->u);
  point->gap = dlsi_take(arena, nc, sizeof *point->gap);
  point->slip = dlsi_take(arena, (d - 1) * nc, sizeof *point->slip);
  point->way = dlsi_take(arena, d * motion->nodes, sizeof *point->way);
  point->state = dlsi_take(arena, nc, sizeof *point->state);
  point->list = dlsi_take(arena, nc, sizeof *point->list);
}

static void motion_carve(dls_motion *motion, dlsi_arena *arena) {
  const size_t n = motion->n, m = motion->m, nc = motion->candidates;
  const size_t local = (size_t)motion->model.d * motion->nodes;
  motion_carve_point(motion, &motion->now, arena);
  motion_carve_point(motion, &motion->next, arena);
  double **const of_n[] = {&motion->b,  &motion->z,    &motion->dx,  &motion->sum,
                           &motion->yn, &motion->yabs, &motion->ways};
  for (size_t k = 0; k < sizeof of_n / sizeof of_n[0]; k++)
    *of_n[k] = dlsi_take(arena, n, sizeof **of_n[k]);
  double **const of_m[] = {&motion->uc, &motion->mc, &motion->r, &motion->w};
  for (size_t k = 0; k < sizeof of_m / sizeof of_m[0]; k++)
    *of_m[k] = dlsi_take(arena, m, sizeof **of_m[k]);
  motion->gap0 = dlsi_take(arena, motion->nodes, sizeof *motion->gap0);
  motion->local = dlsi_take(arena, local, sizeof *motion->local);
  motion->place = dlsi_take(arena, local, sizeof *motion->place);
  motion->zero = dlsi_take(arena, local > nc ? local : nc, sizeof *motion->zero);
  motion->weight = dlsi_take(arena, 2 * nc, sizeof *motion->weight);
  if (motion->on_K) return;
  /* m^2 + (d + 3) nc at most */
  motion->values = dlsi_take(arena, m + 3, m * sizeof *motion->values);
}

static dls_status motion_allocate(dls_motion *motion, dls_error *error) {
  dlsi_arena arena = {0};
  motion_carve(motion, &arena);
  const dls_status status = dlsi_arena_allocate(&arena, "nodes", motion->model.nodes, error);
  if (status) return status;
  motion->memory = arena.base;
  motion_carve(motion, &arena);
  const size_t local = (size_t)motion->model.d * motion->nodes;
  memset(motion->zero, 0,
         (local > motion->candidates ? local : motion->candidates) * sizeof *motion->zero);
  for (size_t k = 0; k < motion->nodes; k++)
    motion->gap0[k] = motion->model.gap ? motion->model.gap[k] : 0;
  return DLS_OK;
}

enum { expected_steps = 1000 }; /* with one A: one W serves all steps */

/* Sets *found := 1 if A has multipliers: joints make it indefinite. */
static dls_status motion_find_joints(const dls_model *model, int *found, dls_error *error) {
  int *joint = dlsi_alloc((size_t)model->n, sizeof *joint);
  if (!joint) return dlsi_no_memory(error);
  *found = dlsi_body_joints(model, NULL, joint) > 0;
  free(joint);
  return DLS_OK;
}

static dls_status motion_reduce(dls_motion *motion, dls_error *error) {
  dls_status status = dlsi_motion_lay(motion, error);
  if (status) return status;
  dlsi_motion_form(motion, motion->settings.h);
  dls_reduction_settings settings;
  dls_reduction_settings_init(&settings);
  settings.loads = expected_steps;
  const int either = motion->settings.law == DLS_MOTION_PATH && motion->settings.method == DLS_AUTO;
  settings.on = either ? DLS_ON_EITHER : DLS_ON_W;
  const dls_model model = motion_reduced_model(&motion->model, dlsi_columns_view(&motion->A));
  status = motion_find_joints(&model, &settings.allow_indefinite, error);
  if (status) return status;
  status = dls_reduction_create(&motion->reduction, &model, &settings, error);
  if (status) return motion_name(status, motion->model.M.p ? "M" : "K", error);
  dls_reduction_info info;
  status = dls_reduction_get_info(motion->reduction, &info, error);
  if (status) return status;
  motion->on_K = info.on == DLS_ON_K;
  return DLS_OK;
}

static dls_solver_settings motion_solver_settings(const dls_motion *motion) {
  dls_solver_settings settings;
  dls_solver_settings_init(&settings);
  settings.limits = motion->settings.limits;
  settings.method = motion->settings.method;
  return settings;
}

/* Creates the solver of steps on W: on K it would never run, with memory for a dense W. */
static dls_status motion_prepare_solver(dls_motion *motion, dls_error *error) {
  if (motion->on_K) return DLS_OK;
  const dls_solver_settings settings = motion_solver_settings(motion);
  return dls_solver_create(&motion->solver, motion->model.d, (int)motion->candidates, &settings,
                           error);
}

static dls_status motion_start(dls_motion *motion, const double *x, const double *v, double t,
                               dls_error *error);

static dls_status motion_create(dls_motion **out, const dls_motion_model *model,
                                const dls_motion_settings *settings, dls_error *error) {
  if (!settings) return dlsi_is_null(error, "settings");
  dls_status status = motion_check_settings(settings, error);
  if (!status) status = motion_check_model(model, settings->law == DLS_MOTION_PATH, error);
  if (status) return status;
  dls_motion *motion = dlsi_alloc(1, sizeof *motion);
  if (!motion) return dlsi_no_memory(error);
  *motion = (dls_motion){.model = *model, .settings = *settings};
  motion->n = (size_t)model->n;
  motion->nodes = (size_t)model->nodes;
  motion->candidates = (size_t)(model->P.p ? model->P.cols : model->nodes);
  motion->m = (size_t)model->d * motion->candidates;
  const dls_solver_settings solver = motion_solver_settings(motion);
  status = dlsi_solver_check(&solver, error);
  if (!status) status = motion_reduce(motion, error);
  if (!status) status = motion_prepare_solver(motion, error);
  if (!status) status = motion_allocate(motion, error);
  if (!status) status = motion_start(motion, NULL, NULL, 0, error);
  if (status)
    dls_motion_destroy(motion);
  else
    *out = motion;
  return status;
}

dls_status dls_motion_create(dls_motion **out, const dls_motion_model *model,
                             const dls_motion_settings *settings, dls_error *error) {
  DLSI_DOOR;
  if (!out) return dlsi_at(__func__, dlsi_is_null(error, "out"), error);
  *out = NULL;
  return dlsi_at(__func__, motion_create(out, model, settings, error), error);
}

void dls_motion_destroy(dls_motion *motion) {
  if (!motion) return;
  dls_solver_destroy(motion->solver);
  dls_reduction_destroy(motion->reduction);
  dlsi_columns_free(&motion->A);
  free(motion->memory);
  free(motion);
}

/* ---- start, set ------------------------------------------------------------------------------ */

static dls_status motion_start(dls_motion *motion, const double *x, const double *v, double t,
                               dls_error *error) {
  dls_status status = x ? dlsi_check_vector("x", x, motion->n, error) : DLS_OK;
  if (!status && v) status = dlsi_check_vector("v", v, motion->n, error);
  if (!status) status = dlsi_check_vector("t", &t, 1, error);
  if (status) return status;
  if (v && motion->settings.law == DLS_MOTION_PATH)
    return dlsi_fail(error, DLS_E_ARGUMENT, "v", -1, 0, "is given, but a path has none");
  motion_point *now = &motion->now;
  const size_t d = (size_t)motion->model.d, nc = motion->candidates;
  for (size_t i = 0; i < motion->n; i++) {
    now->x[i] = x ? x[i] : 0;
    now->v[i] = v ? v[i] : 0;
  }
  memset(now->p, 0, motion->m * sizeof *now->p);
  memset(now->slip, 0, (d - 1) * nc * sizeof *now->slip);
  memset(now->way, 0, d * motion->nodes * sizeof *now->way);
  for (size_t c = 0; c < nc; c++)
    now->state[c] = DLS_FREE;
  now->active = 0;
  now->energies = (dls_motion_energies){0};
  dlsi_motion_measure_gap(motion, now);
  dlsi_motion_local(motion, now->v, motion->local);
  dlsi_motion_gather(motion, motion->local, now->u);
  dlsi_motion_weigh(motion, now);
  motion->problem = (dls_contact){.d = motion->model.d};
  motion->steps = 0;
  motion->t = t;
  motion->h_last = 0;
  return DLS_OK;
}

dls_status dls_motion_start(dls_motion *motion, const double *x, const double *v, double t,
                            dls_error *error) {
  DLSI_DOOR;
  dls_status status = dlsi_motion_enter(motion, error);
  if (!status) status = dlsi_leave(&motion->busy, motion_start(motion, x, v, t, error));
  return dlsi_at(__func__, status, error);
}

static dls_status motion_set_h(dls_motion *motion, double h, dls_error *error) {
  dls_status status = motion_check_h(h, error);
  if (status) return status;
  if (motion->settings.law != DLS_MOTION_PATH) {
    dlsi_motion_form(motion, h);
    const dls_model model = motion_reduced_model(&motion->model, dlsi_columns_view(&motion->A));
    status = dls_reduction_update(motion->reduction, &model, error);
    if (status) return motion_name(status, "M", error);
  }
  motion->settings.h = h;
  return DLS_OK;
}

dls_status dls_motion_set_h(dls_motion *motion, double h, dls_error *error) {
  DLSI_DOOR;
  dls_status status = dlsi_motion_enter(motion, error);
  if (!status) status = dlsi_leave(&motion->busy, motion_set_h(motion, h, error));
  return dlsi_at(__func__, status, error);
}

static dls_status motion_set_limits(dls_motion *motion, const dls_limits *limits,
                                    dls_error *error) {
  if (!limits) return dlsi_is_null(error, "limits");
  const dls_status status = motion->on_K ? dlsi_check_limits(limits, error)
                                         : dls_solver_set_limits(motion->solver, limits, error);
  if (!status) motion->settings.limits = *limits;
  return status;
}

dls_status dls_motion_set_limits(dls_motion *motion, const dls_limits *limits, dls_error *error) {
  DLSI_DOOR;
  dls_status status = dlsi_motion_enter(motion, error);
  if (!status) status = dlsi_leave(&motion->busy, motion_set_limits(motion, limits, error));
  return dlsi_at(__func__, status, error);
}

/* ---- views ----------------------------------------------------------------------------------- */

static dls_status motion_given(const dls_motion *motion, const char *argument, const void *out,
                               dls_error *error) {
  if (!motion) return dlsi_is_null(error, "motion");
  return out ? DLS_OK : dlsi_is_null(error, argument);
}

dls_status dls_motion_get_state(const dls_motion *motion, dls_motion_state *state,
                                dls_error *error) {
  DLSI_DOOR;
  const dls_status status = motion_given(motion, "state", state, error);
  if (status) return dlsi_at(__func__, status, error);
  const motion_point *now = &motion->now;
  *state = (dls_motion_state){.d = motion->model.d,
                              .n = motion->model.n,
                              .candidates = (int)motion->candidates,
                              .steps = motion->steps,
                              .t = motion->t,
                              .x = now->x,
                              .v = now->v,
                              .p = now->p,
                              .u = now->u,
                              .gap = now->gap,
                              .slip = now->slip,
                              .state = now->state,
                              .active = now->active,
                              .active_list = now->list,
                              .restitution = now->restitution};
  return DLS_OK;
}

dls_status dls_motion_get_energies(const dls_motion *motion, dls_motion_energies *energies,
                                   dls_error *error) {
  DLSI_DOOR;
  const dls_status status = motion_given(motion, "energies", energies, error);
  if (!status) *energies = motion->now.energies;
  return dlsi_at(__func__, status, error);
}

dls_status dls_motion_get_problem(const dls_motion *motion, dls_contact *problem,
                                  dls_error *error) {
  DLSI_DOOR;
  const dls_status status = motion_given(motion, "problem", problem, error);
  if (!status) *problem = motion->problem;
  return dlsi_at(__func__, status, error);
}
