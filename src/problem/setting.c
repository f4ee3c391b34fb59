/* setting.c: runs a scene of any kind at a setting; its one number (setting.h). */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "setting.h"

enum { REPEATS = 3 };
static const double graded = 3;       /* the grade of a graded mesh */
static const double short_run = 0.05; /* CPU seconds: a shorter run is timed again */
static const double rounding = 1e-12; /* of the energies: less work than that is none */

/* What stands for the answer of a scene. */
static const struct {
  const char *name, *answer, *unit;
  double exact; /* 0: none; of the bars the integral of the force of src/fe/moving_exact.c */
} answers[] = {{"jean-fig3", "friction force", "N/m", 0},
               {"jean-fig4", "friction force", "N/m", 0},
               {"indentation", "force on the cylinder", "N/mm", 0},
               {"extrusion", "force on the ram", "N/rad", 0},
               {"bar-impact", "impulse of the wall", "N s", 300 * 2. / 3},
               {"bar-bounce", "impulse of the wall", "N s", 1600. / 3},
               {"bar-fixed", "impulse of the wall", "N s", 4 * 0.5},
               {"jean-moving", "work of friction", "J/m", 0},
               {"jean-moving4", "work of friction", "J/m", 0},
               {"block-drop", "impulse of the ground", "N s/m", 0},
               {"two-blocks", "work of friction", "J/m", 0}};
enum { ANSWERS = sizeof answers / sizeof answers[0] };

/* Finds the sides a <= b of a lattice from its numbers of nodes and of rectangles. */
static void lattice_sides(int nodes, int rectangles, int *a, int *b) {
  const int sum = nodes - rectangles - 1;
  const double apart = sqrt(fmax(0, (double)sum * sum - 4.0 * rectangles));
  *a = (int)round((sum - apart) / 2);
  *b = (int)round((sum + apart) / 2);
}

/* Adds the way from (part0, value0) to (part1, value1) to the curve, linear in between. */
static void curve_add(scene_answer *a, double part0, double value0, double part1, double value1) {
  for (int k = 0; k < PIECES; k++) {
    const double part = (k + 1.0) / PIECES;
    if (part <= part0 || part > part1 + rounding) continue;
    a->field[OF_CURVE][k] = value0 + (value1 - value0) * (part - part0) / (part1 - part0);
  }
}

/* Returns the distance of node c of a list from the next one. */
static double between(const double *xy, const int *node, int c) {
  const double *a = xy + 2 * node[c], *b = xy + 2 * node[c + 1];
  return hypot(b[0] - a[0], b[1] - a[1]);
}

/* Adds `weight` times the fields of a surface, whose nodes stand for it half way to their
 * neighbours; beyond: its length behind the last node. */
static void surface_add(scene_answer *a, double weight, const double *xy, const int *node,
                        int count, double beyond, const double *r, const dls_contact_state *state) {
  double whole = beyond, at = 0, low = 0;
  for (int c = 0; c + 1 < count; c++)
    whole += between(xy, node, c);
  for (int c = 0; c < count && whole > 0; c++) {
    const double next = c + 1 < count ? between(xy, node, c) : 2 * beyond, high = at + next / 2;
    const double on[] = {r[2 * c] / (high - low), state[c] != DLS_FREE, state[c] == DLS_SLIP};
    for (int k = (int)(low / whole * PIECES); k < PIECES && k * whole < high * PIECES; k++) {
      const double part = fmin(high / whole * PIECES, k + 1) - fmax(low / whole * PIECES, k);
      for (int i = 0; i < 3; i++)
        a->field[OF_PRESSURE + i][k] += weight * fmax(0, part) * on[i];
    }
    at += next;
    low = high;
  }
}

double answer_distance(const scene_answer *a, const scene_answer *b, quantity_of of) {
  double sum = 0, norm = 0;
  const int zone = of == OF_EDGE || of == OF_SLIP;
  if (of == OF_FORCE) return fabs(a->value - b->value) / fabs(b->value);
  if (of == OF_DRIFT) return a->drift;
  for (int k = 0; k < PIECES; k++) {
    const double apart = a->field[of][k] - b->field[of][k];
    sum += zone ? fabs(apart) : apart * apart;
    norm += zone ? b->field[OF_EDGE][k] : b->field[of][k] * b->field[of][k];
  }
  return norm <= 0 ? 0 : zone ? sum / norm : sqrt(sum / norm);
}

/* ---- one equilibrium ------------------------------------------------------------------------- */

static dls_status own_equilibrium(scene *s, dls_error *error) {
  dls_fe_scene *fe;
  dls_fe_scene_data d;
  const dls_status status = dls_fe_scene_create(&fe, s->name, 0, error);
  if (status) return status;
  dls_fe_scene_get(fe, &d);
  lattice_sides(d.mesh->nodes, d.mesh->triangles / 2, &s->own.ny, &s->own.nx);
  s->own.tol = scene_tol;
  s->friction = d.mu[0] > 0;
  s->grade = graded;
  s->has = 1 << OF_PRESSURE | 1 << OF_EDGE;
  dls_fe_scene_destroy(fe);
  return DLS_OK;
}

/* Solves the condensed problem; *value: the resultant of the tangential reactions. */
static dls_status solve_equilibrium(const dls_fe_scene_data *d, double tol, double limit,
                                    dls_reduction **reduction, double **r, scene_answer *out,
                                    dls_error *error) {
  dls_contact contact;
  dls_solver_settings settings;
  dls_info info;
  dls_solver_settings_init(&settings);
  settings.limits.tol = tol;
  settings.limits.cpu_seconds = limit;
  settings.limits.progress = show_progress;
  const double start = cpu_seconds();
  dls_status status = reduce_to_W(reduction, &d->model, error);
  out->reduction = cpu_seconds() - start;
  if (!status) status = dls_reduction_load(*reduction, d->f, d->g, error);
  if (!status) status = dls_reduction_contact(*reduction, d->mu, &contact, error);
  if (status) return status;
  const int m = 2 * contact.nc, *node = d->contact_node;
  *r = calloc((size_t)m, 2 * sizeof **r + sizeof(dls_contact_state));
  if (!*r) return no_memory(error);
  double *u = *r + m;
  dls_contact_state *state = (dls_contact_state *)(void *)(u + m);
  status = dls_solve(&contact, &settings, *r, u, &info, error);
  const dls_status states = status < 0 ? status : dls_contact_states(&contact, *r, u, state, error);
  if (states) return states;
  surface_add(out, 1, d->mesh->xy, node, contact.nc,
              between(d->mesh->xy, (int[]){node[contact.nc - 1], node[contact.nc - 1] + 1}, 0), *r,
              state); /* up to the fixed node */
  out->status = status == DLS_TO_ROUNDING ? DLS_OK : status;
  out->value = 0;
  for (int c = 0; c < contact.nc; c++)
    out->value += (*r)[2 * c + 1];
  out->value = fabs(out->value);
  return DLS_OK;
}

static dls_status run_equilibrium(const scene *s, const setting *at, double limit,
                                  scene_answer *out, dls_error *error) {
  dls_fe_scene *fe;
  dls_fe_scene_data d;
  dls_fe_scene_settings block;
  dls_reduction *reduction = NULL;
  double *r = NULL;
  dls_fe_scene_settings_init(&block);
  block.nx = at->nx;
  block.ny = at->ny;
  block.mu = at->mu;
  block.grade = at->grade;
  dls_status status = dls_fe_scene_create_with(&fe, s->name, at->weighted, &block, error);
  if (status) return status;
  dls_fe_scene_get(fe, &d);
  status = solve_equilibrium(&d, at->tol, limit, &reduction, &r, out, error);
  out->part = 1;
  free(r);
  dls_reduction_destroy(reduction);
  dls_fe_scene_destroy(fe);
  return status;
}

/* ---- forming --------------------------------------------------------------------------------- */

static dls_status own_forming(scene *s, dls_error *error) {
  dls_forming *forming;
  dls_forming_data d;
  dls_forming_settings settings;
  dls_forming_settings_init(&settings);
  const dls_status status = dls_forming_create(&forming, s->name, &settings, error);
  if (status) return status;
  dls_forming_get(forming, &d);
  lattice_sides(d.mesh->nodes, d.mesh->quads, &s->own.nx, &s->own.ny);
  s->own.steps = d.steps;
  s->whole = d.whole;
  s->own.tol = settings.tol;
  s->friction = 1;
  s->tall = !d.axisymmetric;
  s->has = 1 << OF_CURVE | 1 << OF_PRESSURE | 1 << OF_EDGE;
  dls_forming_destroy(forming);
  return DLS_OK;
}

/* Adds the surface at the end. A reaction on its cone, the widest of all, slips where it moves. */
static dls_status forming_surface(const dls_forming_data *d, double step, scene_answer *out,
                                  dls_error *error) {
  static const double border = 1e-3, still = 1e-6;
  const double *r = d->r;
  const int *node = d->candidate_node;
  dls_contact_state *state = calloc((size_t)d->candidates, sizeof *state);
  double mu = 0;
  int count = 2;
  if (!state) return no_memory(error);
  while (count < d->candidates && node[count] - node[count - 1] == node[1] - node[0])
    count++; /* the first ones follow each other on the surface */
  for (int c = 0; c < count; c++)
    if (r[2 * c] > 0) mu = fmax(mu, fabs(r[2 * c + 1]) / r[2 * c]);
  for (int c = 0; c < count; c++)
    state[c] =
        r[2 * c] <= 0 ? DLS_FREE
        : fabs(r[2 * c + 1]) >= (1 - border) * mu * r[2 * c] && fabs(d->u[2 * c + 1]) > still * step
            ? DLS_SLIP
            : DLS_STICK;
  surface_add(out, 1, d->mesh->xy, node, count, 0, r, state);
  free(state);
  return DLS_OK;
}

static dls_status run_forming_at(const scene *s, const setting *at, double limit, scene_answer *out,
                                 dls_error *error) {
  dls_forming *forming;
  dls_forming_data d;
  dls_forming_settings settings;
  dls_forming_settings_init(&settings);
  settings.progress = stop_step;
  if (!forming_method(at->method ? at->method : "auto", &settings)) return DLS_E_ARGUMENT;
  settings.nx = at->nx;
  settings.ny = at->ny;
  settings.steps = at->steps;
  settings.mu = at->mu;
  settings.tol = at->tol;
  settings.clamped = at->clamped;
  settings.cpu_seconds = limit;
  if (at->penalty > 0) {
    settings.contact = DLS_FORMING_PENALTY;
    settings.penalty = at->penalty;
  }
  dls_status status = dls_forming_create(&forming, s->name, &settings, error);
  if (status) return status;
  dls_forming_get(forming, &d);
  for (int step = 1; step <= d.steps && !status; step++) {
    const double part = d.travel / d.whole, force = d.force;
    status = dls_forming_step(forming, error);
    dls_forming_get(forming, &d);
    curve_add(out, part, force, d.travel / d.whole, d.force);
    if (!status && show_step(&d, step)) status = DLS_CANCELLED;
  }
  out->status = status;
  out->value = d.force;
  out->part = d.travel / d.whole;
  if (!status) status = forming_surface(&d, d.whole / d.steps, out, error);
  dls_forming_destroy(forming);
  return status < 0 ? status : DLS_OK;
}

/* ---- bodies that move ------------------------------------------------------------------------ */

static dls_status own_moving(scene *s, dls_error *error) {
  dls_moving *moving;
  dls_moving_data d;
  const dls_status status = dls_moving_create(&moving, s->name, NULL, error);
  if (status) return status;
  dls_moving_get(moving, &d);
  s->own = (setting){.tol = d.settings.limits.tol, .steps = d.steps, .mu = -1};
  if (!d.obstacle_moves) { /* the block on the moving obstacle has one mesh */
    s->own.nx = d.settings.nx;
    s->own.ny = d.settings.ny;
    s->own.upper = d.settings.upper;
  }
  s->dynamic = d.dynamic;
  s->whole = d.steps * d.h;
  s->friction = d.settings.mu > 0;
  s->own.mass = d.dynamic ? d.settings.mass : 0;
  s->has = 1 << OF_CURVE | 1 << OF_DRIFT;
  if (d.candidates > 1) s->has |= 1 << OF_PRESSURE | 1 << OF_EDGE;
  dls_moving_destroy(moving);
  return DLS_OK;
}

/* Returns the impulse or the work of friction so far. */
static double moving_value(const scene *s, const dls_moving_data *d) {
  const double work = fabs(d->energy.friction);
  return s->dynamic ? d->impulse[0] : work > rounding * d->energy.scale ? work : 0;
}

static dls_status run_moving_at(const scene *s, const setting *at, double limit, scene_answer *out,
                                dls_error *error) {
  dls_moving *moving;
  dls_moving_data d;
  dls_moving_settings settings;
  dls_moving_settings_init(&settings);
  if (!dls_method_find(at->method ? at->method : "auto", &settings.method)) return DLS_E_ARGUMENT;
  settings.nx = at->nx;
  settings.ny = at->ny;
  settings.upper = at->upper;
  settings.steps = at->steps;
  settings.mu = at->mu;
  settings.mass = at->mass;
  settings.limits.tol = at->tol;
  settings.limits.cpu_seconds = limit; /* of a contact problem, which may be without a solution */
  dls_status status = dls_moving_create(&moving, s->name, &settings, error);
  if (status) return status;
  const double start = cpu_seconds();
  dls_moving_get(moving, &d);
  while (d.step < d.steps && !status) {
    const double before = moving_value(s, &d);
    status = dls_moving_step(moving, error);
    dls_moving_get(moving, &d);
    curve_add(out, (d.step - 1.0) / d.steps, before, (double)d.step / d.steps, moving_value(s, &d));
    surface_add(out, 1. / d.steps, d.mesh->xy, d.candidate_node, d.candidates, 0, d.r,
                d.state.state);
    out->drift = fmax(out->drift, d.energy.residual / d.energy.scale);
    if (!status && show_moving_step(&d)) status = DLS_CANCELLED;
    if (!status && d.step < d.steps && cpu_seconds() - start > limit) status = DLS_TIME_LIMIT;
  }
  out->status = status;
  out->value = moving_value(s, &d);
  out->part = (double)d.step / d.steps;
  if (d.has_exact) out->gap = d.gap_error;
  dls_moving_destroy(moving);
  return status < 0 ? status : DLS_OK;
}

/* ---- all ------------------------------------------------------------------------------------- */

int scene_find(const char *name, scene *s, dls_status *status, dls_error *error) {
  *s = (scene){.name = name, .answer = "answer", .unit = "", .exact = NAN, .own = {.mu = -1}};
  s->kind = kind_of_scene(name);
  for (int k = 0; scene_name(k); k++)
    if (!strcmp(name, scene_name(k))) s->says = scene_description(k);
  for (int k = 0; k < ANSWERS; k++)
    if (!strcmp(name, answers[k].name)) {
      s->answer = answers[k].answer;
      s->unit = answers[k].unit;
      if (answers[k].exact > 0) s->exact = answers[k].exact;
    }
  if (s->kind)
    *status = (s->kind == SCENE_FORMING  ? own_forming
               : s->kind == SCENE_MOVING ? own_moving
                                         : own_equilibrium)(s, error);
  s->has |= 1 << OF_FORCE | (s->friction && s->has & 1 << OF_EDGE ? 1 << OF_SLIP : 0);
  return s->kind != NO_SCENE;
}

dls_status scene_run(const scene *s, const setting *at, double limit, scene_answer *out,
                     dls_error *error) {
  dls_status status = DLS_OK;
  double least = INFINITY, all = 0;
  for (int k = 0; k < REPEATS && !status && all < short_run; k++) {
    const double start = cpu_seconds();
    *out = (scene_answer){.value = NAN, .gap = NAN};
    status = (s->kind == SCENE_FORMING  ? run_forming_at
              : s->kind == SCENE_MOVING ? run_moving_at
                                        : run_equilibrium)(s, at, limit, out, error);
    const double seconds = cpu_seconds() - start;
    least = fmin(least, seconds);
    all += seconds;
  }
  progress_end();
  out->seconds = least;
  if (out->status) out->value = NAN;
  return status;
}

int setting_is(const setting *a, const setting *b) {
  return a->tol == b->tol && a->nx == b->nx && a->grade == b->grade && a->ny == b->ny &&
         a->upper == b->upper && a->steps == b->steps && a->mu == b->mu &&
         a->weighted == b->weighted && a->penalty == b->penalty && a->clamped == b->clamped &&
         a->mass == b->mass;
}

static int scaled(int count, double factor, int least) {
  return count ? (int)fmax(least, round(count * factor)) : 0;
}

setting setting_scaled(const scene *s, int mesh, int steps, int tol) {
  setting at = s->own;
  const double size = pow(2, 0.5 * mesh);
  at.nx = scaled(at.nx, size, 2);
  at.ny = scaled(at.ny, size, 1);
  at.upper = scaled(at.upper, size, 2);
  at.steps = scaled(at.steps, pow(2, steps) * (s->dynamic ? size : 1), 1);
  at.tol = tol ? pow(10, round(log10(at.tol)) - tol) : at.tol;
  return at;
}

const char *setting_variant(const scene *s, int k, setting *at) {
  const int lumped = s->own.mass == DLS_FE_LUMPED;
  *at = s->own;
  switch (k) {
  case 0:
    at->tol = s->own.tol / 10;
    return "tolerance / 10";
  case 1:
    at->steps *= 2;
    return at->steps ? "steps * 2" : "";
  case 2:
    at->nx *= 2;
    at->ny *= 2;
    at->upper *= 2;
    return at->nx ? "mesh * 2" : "";
  case 3:
    at->mu = 0;
    return s->friction ? "no friction" : "";
  case 4:
    at->weighted = 1;
    return s->kind == SCENE_AT_ONCE ? "weighted reactions" : "";
  case 5:
    at->penalty = 1000;
    return s->kind == SCENE_FORMING ? "penalty, factor 1000" : "";
  case 6:
    at->penalty = 2000;
    return s->kind == SCENE_FORMING ? "penalty, factor 2000" : "";
  case 7:
    at->clamped = 1;
    return strcmp(s->name, dls_forming_name(0)) ? "" : "bottom clamped"; /* indentation */
  case 8:
    at->mass = lumped ? DLS_FE_CONSISTENT : DLS_FE_LUMPED;
    return !s->own.mass ? "" : lumped ? "consistent mass" : "lumped mass";
  default:
    return NULL;
  }
}

const char *setting_text(const scene *s, const setting *at, int options, char text[SETTING_ROOM]) {
  char mesh[60] = "", grade[40] = "", upper[40] = "", steps[40] = "", more[80] = "", mu[40] = "";
  if (at->nx && at->ny)
    (void)snprintf(mesh, sizeof mesh, options ? "--mesh=%dx%d " : "%d x %d, ", at->nx, at->ny);
  else if (at->nx)
    (void)snprintf(mesh, sizeof mesh, options ? "--mesh=%d " : "%d elements, ", at->nx);
  if (at->grade > 0)
    (void)snprintf(grade, sizeof grade, options ? "--grade=%g " : "grade %g, ", at->grade);
  if (at->upper)
    (void)snprintf(upper, sizeof upper, options ? "--upper=%d " : "upper %d, ", at->upper);
  if (at->steps)
    (void)snprintf(steps, sizeof steps, options ? "--steps=%d " : "%d steps, ", at->steps);
  if (options && at->mass != s->own.mass)
    (void)snprintf(more, sizeof more, " --mass=%s",
                   at->mass == DLS_FE_LUMPED ? "lumped" : "consistent");
  else if (options && at->penalty > 0)
    (void)snprintf(more, sizeof more, " --method=penalty --penalty=%g", at->penalty);
  if (options && at->mu >= 0) (void)snprintf(mu, sizeof mu, " --mu=%g", at->mu);
  (void)snprintf(text, SETTING_ROOM, "%s%s%s%s%s%.0e%s%s%s%s", mesh, grade, upper, steps,
                 options ? "--tol=" : "tol ", at->tol, options && at->weighted ? " --weighted" : "",
                 options && at->clamped ? " --clamped" : "", more, mu);
  return text;
}
