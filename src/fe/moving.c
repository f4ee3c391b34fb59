/*
 * moving.c: takes the steps of a scene of moving bodies, and adds up the measures of a run:
 * impulses, the variation of the force, the distance from the closed form, cost.
 */
#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

#include "fe_internal.h"
#include "moving_internal.h"

struct dls_moving {
  dlsi_moving_scene scene;
  dls_motion_model model;
  dls_motion *motion;
  dls_solver *cold;      /* of the second solution; NULL without settings.measure */
  double *f;             /* n: loads of the step */
  double *y;             /* 2 * candidates: velocity of the obstacle */
  double *mu;            /* candidates */
  double *R;             /* 2 * candidates: r of data */
  double *force;         /* n: H r */
  double *displacement;  /* 2 * nodes of the mesh */
  double *reaction;      /* 2 * nodes */
  double *cold_r;        /* 2 * candidates */
  double error2, exact2; /* sums of squares of the gap: error, closed form */
  double normal;         /* sum of r_n of the previous step */
  dls_moving_data data;
  void *memory; /* of the arrays */
};

/* ---- making ---------------------------------------------------------------------------------- */

static void moving_carve(dlsi_arena *arena, dls_moving *m) {
  const size_t n = (size_t)m->scene.n, nc = (size_t)m->scene.candidates;
  const size_t mesh = 2 * (size_t)m->scene.mesh.nodes;
  m->f = dlsi_take(arena, n, sizeof *m->f);
  m->y = dlsi_take(arena, 2 * nc, sizeof *m->y);
  m->mu = dlsi_take(arena, nc, sizeof *m->mu);
  m->R = dlsi_take(arena, 2 * nc, sizeof *m->R);
  m->force = dlsi_take(arena, n, sizeof *m->force);
  m->displacement = dlsi_take(arena, mesh, sizeof *m->displacement);
  m->reaction = dlsi_take(arena, mesh, sizeof *m->reaction);
  m->cold_r = dlsi_take(arena, 2 * nc, sizeof *m->cold_r);
}

static dls_status moving_allocate(dls_moving *m, dls_error *error) {
  dlsi_arena arena = {0};
  moving_carve(&arena, m);
  const dls_status status = dlsi_arena_allocate(&arena, "nx", m->scene.settings.nx, error);
  if (status) return status;
  m->memory = memset(arena.base, 0, arena.size);
  moving_carve(&arena, m);
  for (int c = 0; c < m->scene.candidates; c++)
    m->mu[c] = m->scene.settings.mu;
  return DLS_OK;
}

static dls_status moving_start(dls_moving *m, dls_error *error) {
  const dlsi_moving_scene *s = &m->scene;
  m->model = (dls_motion_model){.d = 2,
                                .n = s->n,
                                .nodes = s->candidates,
                                .factorization = DLS_CHOLESKY,
                                .M = s->M.A,
                                .K = s->K.A,
                                .HN = dlsi_columns_view(&s->HN),
                                .HT = dlsi_columns_view(&s->HT),
                                .gap = s->gap};
  dls_motion_settings settings;
  dls_motion_settings_init(&settings);
  settings.limits = s->settings.limits;
  settings.law = s->settings.law;
  settings.method = s->settings.method;
  settings.h = s->h;
  settings.theta = s->settings.theta;
  settings.restitution = s->settings.restitution;
  dls_status status = dls_motion_create(&m->motion, &m->model, &settings, error);
  if (!status) status = dls_motion_start(m->motion, s->x, s->v, 0, error);
  if (status || !s->settings.measure) return status;
  dls_solver_settings cold;
  dls_solver_settings_init(&cold);
  cold.method = s->settings.method;
  cold.limits = s->settings.limits;
  cold.limits.warm_start = 0;
  cold.limits.progress = NULL;
  return dls_solver_create(&m->cold, 2, s->candidates, &cold, error);
}

/* Puts x and the mean forces of the step on the mesh. */
static void moving_spread(dls_moving *m) {
  const dlsi_moving_scene *s = &m->scene;
  const dls_motion_state *state = &m->data.state;
  const double over = s->settings.law == DLS_MOTION_PATH ? 1 : 1 / s->h;
  memset(m->force, 0, (size_t)s->n * sizeof *m->force);
  for (int c = 0; c < s->candidates; c++)
    for (int k = 0; k < 2; k++) {
      const dls_sparse H = k ? m->model.HT : m->model.HN;
      m->R[2 * c + k] = over * state->p[2 * c + k];
      for (int e = H.p[c]; e < H.p[c + 1]; e++)
        m->force[H.i[e]] += H.x[e] * m->R[2 * c + k];
    }
  for (int k = 0; k < 2 * s->mesh.nodes; k++) {
    const int q = s->unknown[k];
    m->displacement[k] = q < 0 ? 0 : state->x[q];
    m->reaction[k] = q < 0 ? 0 : m->force[q];
  }
}

/* Reads state and energies of the motion into data. */
static dls_status moving_read(dls_moving *m, dls_error *error) {
  dls_status status = dls_motion_get_state(m->motion, &m->data.state, error);
  if (!status) status = dls_motion_get_energies(m->motion, &m->data.energy, error);
  if (!status) moving_spread(m);
  return status;
}

static dls_status moving_make(dls_moving **out, const char *name,
                              const dls_moving_settings *settings, dls_error *error) {
  dls_moving *m = dlsi_alloc(1, sizeof *m);
  if (!m) return dlsi_no_memory(error);
  *m = (dls_moving){0};
  dls_status status = dlsi_moving_build(&m->scene, name, settings, error);
  if (!status) status = moving_allocate(m, error);
  if (!status) status = moving_start(m, error);
  if (!status) status = moving_read(m, error);
  if (status) {
    dls_moving_destroy(m);
    return status;
  }
  const dlsi_moving_scene *s = &m->scene;
  dls_moving_data *d = &m->data;
  for (int k = 0; dls_moving_name(k); k++)
    if (strcmp(dls_moving_name(k), name) == 0) d->name = dls_moving_name(k);
  d->settings = s->settings;
  d->dynamic = s->settings.law != DLS_MOTION_PATH;
  d->has_exact = s->exact != NULL;
  d->obstacle_moves = s->shaken;
  d->h = s->h;
  d->element = s->exact ? s->mesh.xy[5] - s->mesh.xy[1] : 0;
  d->steps = s->steps;
  d->cycle = s->cycle;
  d->mesh = &s->mesh;
  d->E = s->E;
  d->nu = s->nu;
  d->rho = s->rho;
  d->model = &m->model;
  d->unknown = s->unknown;
  d->candidates = s->candidates;
  d->candidate_node = s->candidate_node;
  d->displacement = m->displacement;
  d->reaction = m->reaction;
  d->r = m->R;
  d->energy_start = d->energy.kinetic + d->energy.elastic;
  if (s->exact) s->exact(0, &d->exact_gap, &d->exact_force);
  *out = m;
  return DLS_OK;
}

dls_status dls_moving_create(dls_moving **out, const char *name,
                             const dls_moving_settings *settings, dls_error *error) {
  DLSI_DOOR;
  if (out) *out = NULL;
  const dls_status status = !out    ? dlsi_is_null(error, "out")
                            : !name ? dlsi_is_null(error, "name")
                                    : moving_make(out, name, settings, error);
  return dlsi_at(__func__, status, error);
}

void dls_moving_destroy(dls_moving *moving) {
  if (!moving) return;
  dls_solver_destroy(moving->cold);
  dls_motion_destroy(moving->motion);
  dlsi_moving_free(&moving->scene);
  free(moving->memory);
  free(moving);
}

void dls_moving_get(const dls_moving *moving, dls_moving_data *data) {
  if (data) *data = moving ? moving->data : (dls_moving_data){0};
}

dls_status dls_moving_problem(const dls_moving *moving, dls_contact *problem, dls_error *error) {
  DLSI_DOOR;
  const dls_status status = moving ? dls_motion_get_problem(moving->motion, problem, error)
                                   : dlsi_is_null(error, "moving");
  return dlsi_at(__func__, status, error);
}

/* ---- a step ---------------------------------------------------------------------------------- */

/* Returns the place of the obstacle at time t. */
static double moving_obstacle(const dlsi_moving_scene *s, double t) {
  const double pi = 3.14159265358979323846;
  return s->shaken ? s->settings.amplitude * sin(2 * pi * s->settings.frequency * t) : 0;
}

/* Fills the loads of the step that ends at t, and the obstacle's mean velocity during it. */
static void moving_loads(dls_moving *m, double t) {
  const dlsi_moving_scene *s = &m->scene;
  const double at = s->settings.law == DLS_MOTION_PATH ? t : t - s->h / 2;
  const double turn = at / (s->time / 2); /* 0 .. 1: load[0] grows; 1 .. 2: load[1] */
  const double part[2] = {s->ramped ? fmin(turn, 1) : 1, s->ramped ? fmax(turn - 1, 0) : 1};
  for (int i = 0; i < s->n; i++) {
    m->f[i] = 0;
    for (int k = 0; k < 2; k++)
      if (s->load[k]) m->f[i] += part[k] * s->load[k][i];
  }
  for (int c = 0; c < s->candidates; c++)
    m->y[2 * c + 1] = (moving_obstacle(s, t) - m->data.obstacle) / s->h;
}

/* Solves the contact problem of the step once more, from r = 0. */
static dls_status moving_measure(dls_moving *m, dls_error *error) {
  dls_contact problem;
  dls_info info;
  dls_status status = dls_motion_get_problem(m->motion, &problem, error);
  if (status || problem.nc == 0) return status;
  const clock_t start = clock();
  status = dls_solver_solve(m->cold, &problem, m->cold_r, NULL, &info, error);
  m->data.contact_seconds += (double)(clock() - start) / CLOCKS_PER_SEC;
  m->data.cold_iterations += info.iterations;
  return status < 0 ? status : DLS_OK;
}

/* Adds the step to the measures of a run. */
static void moving_judge(dls_moving *m) {
  const dlsi_moving_scene *s = &m->scene;
  dls_moving_data *d = &m->data;
  double normal = 0;
  for (int c = 0; c < s->candidates; c++) {
    normal += d->r[2 * c];
    for (int k = 0; k < 2; k++)
      if (d->dynamic) d->impulse[k] += d->state.p[2 * c + k];
  }
  d->variation += fabs(normal - m->normal);
  m->normal = normal;
  if (!s->exact) return;
  double unused;
  s->exact(d->state.t, &d->exact_gap, &unused);
  s->exact(d->state.t - s->h / 2, &unused, &d->exact_force);
  const double off = d->state.gap[0] - d->exact_gap;
  m->error2 += off * off;
  m->exact2 += d->exact_gap * d->exact_gap;
  d->gap_error = m->exact2 > 0 ? sqrt(m->error2 / m->exact2) : 0;
}

static dls_status moving_step(dls_moving *m, dls_error *error) {
  dls_moving_data *d = &m->data;
  if (d->step == d->steps)
    return dlsi_fail(error, DLS_E_ARGUMENT, "moving", -1, d->step, "has done its %d steps",
                     d->steps);
  const double t = (d->step + 1) * m->scene.h;
  moving_loads(m, t);
  const clock_t start = clock();
  dls_status status = dls_motion_step(m->motion, m->f, m->y, m->mu, &d->info, error);
  d->step_seconds += (double)(clock() - start) / CLOCKS_PER_SEC;
  if (status) return status;
  d->step++;
  d->iterations += d->info.iterations;
  d->obstacle = moving_obstacle(&m->scene, t);
  status = moving_read(m, error);
  if (!status && m->cold) status = moving_measure(m, error);
  if (!status) moving_judge(m);
  return status;
}

dls_status dls_moving_step(dls_moving *moving, dls_error *error) {
  DLSI_DOOR;
  const dls_status status = moving ? moving_step(moving, error) : dlsi_is_null(error, "moving");
  return dlsi_at(__func__, status, error);
}
