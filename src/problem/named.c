/*
 * named.c: the contact problem of a built-in scene. Of a scene in steps it is that of one step:
 * the step that is asked for, or the last of those with the most contacts that touch.
 *
 * Forming scenes and bodies that move with their mass hand over W and q. A path of equilibria hands
 * over its model and what the step has solved,
 *
 *   K x = f + H r,   u = H^T x + g,   f := K x - H r,   g := u - H^T x,
 *
 * u_n being the gap after the step, and u_t the slip of the step.
 */
#include <stdlib.h>
#include <string.h>

#include "matrices.h"

void shorten(const char *name, char *text, size_t size) {
  const char *slash = strrchr(name, '/');
  (void)snprintf(text, size, "%s", slash ? slash + 1 : name);
  char *dot = strrchr(text, '.');
  if (dot && dot != text) *dot = '\0';
}

/* The step that is kept of a scene. */
typedef struct pick {
  int wanted; /* 0: the last with the most contacts that touch */
  int step, touching, steps;
} pick;

/* Returns 1 if a step is to be kept, and notes it. r: 2 nc. */
static int pick_takes(pick *k, int step, int nc, const double *r) {
  int touching = 0;
  for (int c = 0; c < nc; c++)
    touching += r[2 * c] > 0;
  if (k->wanted ? step != k->wanted : touching < k->touching) return 0;
  k->step = step;
  k->touching = touching;
  return 1;
}

/* Makes room for `count` numbers that the problem owns. */
static dls_status own_room(problem *p, size_t count) {
  free(p->own);
  p->own = malloc((count ? count : 1) * sizeof *p->own);
  return p->own ? DLS_OK : DLS_E_MEMORY;
}

/* Copies a problem whose W is dense. */
static dls_status keep_contact(problem *p, const dls_contact *from) {
  const size_t m = (size_t)from->d * (size_t)from->nc, nc = (size_t)from->nc;
  if (own_room(p, m * m + m + nc)) return DLS_E_MEMORY;
  double *q = p->own + m * m, *mu = q + m;
  for (size_t j = 0; j < m; j++)
    memcpy(p->own + j * m, from->W.a + j * (size_t)from->W.ld, m * sizeof *q);
  if (m) memcpy(q, from->q, m * sizeof *q);
  if (nc) memcpy(mu, from->mu, nc * sizeof *mu);
  p->contact = *from;
  p->contact.W = (dls_dense){(int)m, (int)m, (int)m, p->own};
  p->contact.q = q;
  p->contact.mu = mu;
  return DLS_OK;
}

/* Keeps what a step of a path has solved. */
static dls_status keep_path(problem *p, const dls_moving_data *d) {
  const dls_motion_model *from = d->model;
  const size_t n = (size_t)from->n, nc = (size_t)from->nodes;
  if (own_room(p, n + 3 * nc)) return DLS_E_MEMORY;
  double *f = p->own, *g = f + n, *mu = g + 2 * nc;
  const double *x = d->state.x;
  memset(f, 0, n * sizeof *f);
  for (int j = 0; j < from->n; j++)
    for (int k = from->K.p[j]; k < from->K.p[j + 1]; k++)
      f[from->K.i[k]] += from->K.x[k] * x[j];
  for (int c = 0; c < from->nodes; c++) {
    mu[c] = d->settings.mu;
    for (int i = 0; i < 2; i++) {
      const dls_sparse *H = i ? &from->HT : &from->HN;
      double *at = &g[2 * c + i];
      *at = i ? d->state.u[2 * c + i] : d->state.gap[c];
      for (int k = H->p[c]; k < H->p[c + 1]; k++) {
        *at -= H->x[k] * x[H->i[k]];
        f[H->i[k]] -= H->x[k] * d->state.p[2 * c + i];
      }
    }
  }
  p->model = (dls_model){.d = 2,
                         .n = from->n,
                         .nodes = from->nodes,
                         .operator_kind = DLS_STIFFNESS_SPARSE,
                         .factorization = DLS_CHOLESKY,
                         .Ks = from->K,
                         .HN = from->HN,
                         .HT = from->HT};
  p->f = f;
  p->g = g;
  p->mu = mu;
  return DLS_OK;
}

static dls_status walk_forming(const char *name, pick *k, problem *p, dls_error *error) {
  dls_forming *forming;
  dls_forming_data d;
  dls_contact contact;
  dls_forming_settings settings;
  dls_forming_settings_init(&settings);
  settings.progress = stop_step;
  dls_status status = dls_forming_create(&forming, name, &settings, error);
  if (status) return status;
  dls_forming_get(forming, &d);
  k->steps = d.steps;
  for (int step = 1; step <= d.steps && !status && k->step != (k->wanted ? k->wanted : -1);
       step++) {
    status = dls_forming_step(forming, error);
    dls_forming_get(forming, &d);
    if (!status && show_step(&d, step)) status = DLS_CANCELLED;
    if (!status && pick_takes(k, step, d.candidates, d.r)) {
      status = dls_forming_problem(forming, &contact, error);
      if (!status) status = keep_contact(p, &contact);
    }
  }
  dls_forming_destroy(forming);
  return status;
}

static dls_status walk_moving(const char *name, pick *k, problem *p, dls_error *error) {
  dls_moving_data d;
  dls_contact contact;
  dls_status status = dls_moving_create(&p->moving, name, NULL, error);
  if (status) return status;
  dls_moving_get(p->moving, &d);
  k->steps = d.steps;
  while (d.step < d.steps && !status && k->step != (k->wanted ? k->wanted : -1)) {
    status = dls_moving_step(p->moving, error);
    dls_moving_get(p->moving, &d);
    if (!status && show_moving_step(&d)) status = DLS_CANCELLED;
    if (!status) status = dls_moving_problem(p->moving, &contact, error);
    if (status || (d.dynamic && !contact.nc) || !pick_takes(k, d.step, d.candidates, d.r)) continue;
    status = d.dynamic ? keep_contact(p, &contact) : keep_path(p, &d);
  }
  return status;
}

/* Takes the contact problem of a scene in steps; `what` walks through it. */
typedef dls_status (*walk_fn)(const char *, pick *, problem *, dls_error *);
static dls_status take_step(const char *name, const source *from, problem *p, walk_fn what,
                            dls_error *error) {
  pick k = {.wanted = from->step};
  const dls_status status = what(name, &k, p, error);
  progress_end();
  if (status == DLS_E_MEMORY) return no_memory(error);
  if (status < 0 || status == DLS_CANCELLED) return status;
  if (!k.step || (k.wanted && k.step != k.wanted)) {
    *error = (dls_error){.status = DLS_E_ARGUMENT};
    (void)snprintf(
        error->message, sizeof error->message, "step %d of %d has no contact problem%s%s", k.wanted,
        k.steps, status ? ": the scene ends before: " : "", status ? dls_status_text(status) : "");
    return DLS_E_ARGUMENT;
  }
  (void)snprintf(p->name, sizeof p->name, "%s, step %d", name, k.step);
  (void)snprintf(p->note, sizeof p->note, "the contact problem of step %d of %d, %d contact%s%s",
                 k.step, k.steps, k.touching, k.touching == 1 ? " touches" : "s touch",
                 k.wanted ? "" : ", the last step with so many; --step=N takes another one");
  return p->model.n ? problem_condense(p, from, error) : DLS_OK;
}

dls_status problem_of_scene(const char *name, const source *from, problem *p, dls_error *error) {
  const scene_kind kind = kind_of_scene(name);
  if (kind == SCENE_FORMING) return take_step(name, from, p, walk_forming, error);
  if (kind == SCENE_MOVING) return take_step(name, from, p, walk_moving, error);
  dls_fe_scene_data data;
  const dls_status status = dls_fe_scene_create(&p->scene, name, 0, error);
  if (status) return status;
  dls_fe_scene_get(p->scene, &data);
  p->model = data.model;
  p->f = data.f;
  p->g = data.g;
  p->mu = data.mu;
  return problem_condense(p, from, error);
}
