/*
 * forming_scene.c: builds the two scenes of [Chabrand 1998] section 5 (mm, N, MPa). The paper shows
 * supports and meshes in drawings only. This file reads them as:
 *
 *   indentation, plane strain             extrusion, axisymmetric
 *      way 10 |   rigid cylinder             | way 177.8 |
 *             v   radius 30                  v           v
 *   axis  +-------+                   axis  +-----------+ |         R = 50.8
 *   x = 0 |       |  40 x 40, half    r = 0 |           | | die:    cylinder r = R for z >= 0,
 *         |       |  of the block           |  254      | |         cone of 5 degrees below,
 *         +-------+                         +-----------+ |         the corner an arc tangent to
 *         u_y = 0; clamped: u_x = 0 too                  /          both at 0.5 from it
 *
 * Candidates: the nodes of the top, for the cylinder; of the lateral surface and of the front, for
 * the die. The ram holds the nodes of the top, and any node of the surface that meets it, until it
 * would have to pull (FO9). With friction at the ram, the nodes of the top except its edge are
 * candidates of the ram instead. A candidate whose tangent is supported, at the axis or by the ram,
 * is frictionless in the contact problem: friction does not move it.
 */
#include <float.h>
#include <limits.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "fe_internal.h"
#include "forming_internal.h"

typedef struct scene {
  const char *name, *description;
  int nx, ny, steps;
  double mu;
  void (*build)(dls_forming *f);
} scene;

/* ---- building -------------------------------------------------------------------------------- */

/* Returns the node in column i and row j. They are numbered along the side with fewer elements, so
 * that the band is narrow. */
static int node_at(const dls_forming *f, int i, int j) {
  const int nx = f->settings.nx, ny = f->settings.ny;
  return nx > ny ? i * (ny + 1) + j : i + j * (nx + 1);
}

/* Makes nx x ny rectangles on [0, lx] x [0, ly]. */
static void forming_grid(dls_forming *f, double lx, double ly) {
  const int nx = f->settings.nx, ny = f->settings.ny;
  int *node = f->mesh.node;
  for (int j = 0; j <= ny; j++)
    for (int i = 0; i <= nx; i++) {
      double *xy = f->mesh.xy + 2 * node_at(f, i, j);
      xy[0] = lx * ((double)i / nx); /* the last one is lx exactly */
      xy[1] = ly * ((double)j / ny);
      for (int k = 0; k < 4 && i < nx && j < ny; k++) /* counterclockwise */
        *node++ = node_at(f, i + (k == 1 || k == 2), j + (k > 1));
    }
}

static void build_indentation(dls_forming *f) {
  const int nx = f->settings.nx, ny = f->settings.ny;
  const dlsi_hardening power = {.factor = 593, .offset = 0.00384, .exponent = 0.202};
  forming_grid(f, 40, 40);
  f->solid = dlsi_solid_make(2e5, 0.3, power);
  dlsi_rigid *cylinder = &f->rigid[0];
  f->rigids = 1;
  cylinder->piece[0] = (dlsi_piece){.c = {0, 70}, .radius = 30, .side = 1};
  cylinder->profile = (dlsi_obstacle){1, cylinder->piece};
  f->whole = 10;
  cylinder->way[1] = -f->whole;
  for (int j = 0; j <= ny; j++)
    f->fixed[2 * node_at(f, 0, j)] = 1;
  for (int i = 0; i <= nx; i++) {
    const int bottom = 2 * node_at(f, i, 0);
    f->fixed[bottom + 1] = 1;
    if (f->settings.clamped) f->fixed[bottom] = 1;
    f->candidate[i] = node_at(f, i, ny);
  }
}

static void build_extrusion(dls_forming *f) {
  const int nx = f->settings.nx, ny = f->settings.ny;
  const dlsi_hardening linear = {.factor = 261.2, .offset = 0.11868, .exponent = 1};
  const double R = 50.8, L = 254, angle = 5 * acos(-1) / 180, reach = 0.5;
  const double radius = reach / tan(angle / 2), s = sin(angle), c = cos(angle);
  forming_grid(f, R, L);
  f->axisymmetric = 1;
  f->solid = dlsi_solid_make(6.8955e4, 0.32, linear);
  /* upwards, the body on the left: cone, arc, cylinder */
  const double end[2] = {R - reach * s, -reach * c};
  dlsi_rigid *die = &f->rigid[0], *ram = &f->rigid[1];
  f->rigids = 2;
  die->piece[0] = (dlsi_piece){.a = {end[0] - L * s, end[1] - L * c}, .b = {end[0], end[1]}};
  die->piece[1] = (dlsi_piece){.a = {end[0], end[1]},
                               .b = {R, reach},
                               .c = {R - radius, reach},
                               .radius = radius,
                               .side = -1};
  die->piece[2] = (dlsi_piece){.a = {R, reach}, .b = {R, L}};
  die->profile = (dlsi_obstacle){3, die->piece};
  ram->piece[0] = (dlsi_piece){.a = {R, L}, .b = {0, L}};
  ram->profile = (dlsi_obstacle){1, ram->piece};
  f->whole = 177.8;
  ram->way[1] = -f->whole;
  f->low[1] = -INFINITY;
  f->holds = 1;
  for (int j = 0; j <= ny; j++) {
    f->fixed[2 * node_at(f, 0, j)] = 1;
    f->candidate[j] = node_at(f, nx, j);
  }
  for (int i = 1; i < nx; i++)
    f->candidate[ny + i] = node_at(f, i, 0);
  for (int i = 0; i < nx && f->settings.ram_mu > 0; i++) {
    f->candidate[nx + ny + i] = node_at(f, i, ny);
    f->meets[nx + ny + i] = 1;
  }
}

static const scene scenes[] = {
    {"indentation",
     "Chabrand (1998) 5.1: an elastoplastic block indented by a rigid cylinder, plane strain", 20,
     20, 100, 0.2, build_indentation},
    {"extrusion",
     "Chabrand (1998) 5.2: an aluminium billet pushed into a conical die, axisymmetric", 4, 20, 300,
     0.1, build_extrusion},
};
enum { scene_count = sizeof scenes / sizeof scenes[0] };

const char *dls_forming_name(int index) {
  return index >= 0 && index < scene_count ? scenes[index].name : NULL;
}

const char *dls_forming_description(int index) {
  return index >= 0 && index < scene_count ? scenes[index].description : NULL;
}

/* ---- settings -------------------------------------------------------------------------------- */

void dls_forming_settings_init(dls_forming_settings *settings) {
  if (!settings) return;
  const dls_forming_settings s = {.size = sizeof s,
                                  .mu = -1,
                                  .relaxation = 1,
                                  .aitken = 1,
                                  .tol = 1e-9,
                                  .contact = DLS_FORMING_CONDENSED,
                                  .method = DLS_LEMKE};
  *settings = s;
}

static dls_status forming_check(const dls_forming_settings *s, dls_error *error) {
  if (s->size != sizeof *s)
    return dlsi_fail(error, DLS_E_SETTINGS, "settings", -1, (double)s->size,
                     "not filled by dls_forming_settings_init");
  if (!isfinite(s->mu)) return dlsi_fail(error, DLS_E_NOT_FINITE, "mu", -1, s->mu, "is %g", s->mu);
  const dlsi_setting each[] = {
      {"nx", s->nx, 0, INT_MAX, 0},
      {"ny", s->ny, 0, INT_MAX, 0},
      {"steps", s->steps, 0, INT_MAX, 0},
      {"clamped", s->clamped, 0, 1, 0},
      {"standard", s->standard, 0, 1, 0},
      {"keep_trace", s->keep_trace, 0, 1, 0},
      {"tol", s->tol, 0, 1, 1},
      {"penalty", s->penalty, 0, DBL_MAX, 0},
      {"augmentations", s->augmentations, 0, INT_MAX, 0},
      {"relaxation", s->relaxation, 0, 2, 1},
      {"aitken", s->aitken, 0, 1, 0},
      {"ram_mu", s->ram_mu, 0, DBL_MAX, 0},
      {"step_tol", s->step_tol, 0, 1, 0},
      {"cpu_seconds", s->cpu_seconds, 0, DBL_MAX, 0},
      {"contact", s->contact, DLS_FORMING_CONDENSED, DLS_FORMING_PENALTY, 0}};
  return dlsi_check_each((int)(sizeof each / sizeof each[0]), each, error);
}

/* Replaces the settings that stand for the scene's own values; checks that an int can count the
 * band's entries. */
static dls_status forming_complete(dls_forming_settings *s, const scene *chosen, dls_error *error) {
  if (!s->nx) s->nx = chosen->nx;
  if (!s->ny) s->ny = chosen->ny;
  if (!s->steps) s->steps = chosen->steps;
  if (s->mu < 0) s->mu = chosen->mu;
  /* entries of the band: (3 k + 1) n < (6 side + 20) * 2 (nx + 1) (ny + 1) */
  const double entries = (6 * fmin(s->nx, s->ny) + 20) * 2 * (s->nx + 1.0) * (s->ny + 1.0);
  if (entries > INT_MAX)
    return dlsi_fail(error, DLS_E_SIZE, s->nx > s->ny ? "nx" : "ny", -1, entries,
                     "%d x %d is too large", s->nx, s->ny);
  return DLS_OK;
}

/* ---- create, destroy ------------------------------------------------------------------------- */

void dlsi_forming_hold(dls_forming *f, int node, int on) {
  const dlsi_rigid *tool = &f->rigid[f->rigids - 1];
  const int i = 2 * node + 1, c = f->candidate_of[node];
  f->held[node] = f->fixed[i] = on;
  f->rest[i] = tool->piece[0].a[1];
  f->drive[i] = tool->way[1];
  if (c >= 0) f->mu[c] = on ? 0 : f->settings.mu;
}

static void forming_take(dlsi_arena *arena, size_t count, size_t size, double **const *list) {
  for (size_t k = 0; k < count; k++)
    *list[k] = dlsi_take(arena, size, sizeof(double));
}

static void forming_carve(dls_forming *f, dlsi_arena *a) {
  const size_t n = (size_t)f->n, nc = (size_t)f->nc, quads = (size_t)f->mesh.quads;
  const size_t I = sizeof(int), D = sizeof(double);
  double **const of_unknowns[] = {
      &f->mesh.xy, &f->rest, &f->drive,        &f->kept_before, &f->kept_x, &f->before,  &f->x0,
      &f->x,       &f->F,    &f->displacement, &f->reaction,    &f->rhs,    &f->start_x, &f->dx};
  double **const of_reactions[] = {
      &f->r0,      &f->r,        &f->normal,   &f->tangent,       &f->anchor,         &f->u,
      &f->next_r,  &f->kept_r,   &f->start_r,  &f->chosen.normal, &f->chosen.tangent, &f->lambda,
      &f->trial_u, &f->chosen.u, &f->chosen.r, &f->node_q,        &f->node_r};
  double **const of_candidates[] = {&f->mu,  &f->gap,   &f->bend,   &f->chosen.mu,
                                    &f->eps, &f->stiff, &f->node_mu};
  forming_take(a, sizeof of_unknowns / sizeof of_unknowns[0], n, of_unknowns);
  forming_take(a, sizeof of_reactions / sizeof of_reactions[0], 2 * nc, of_reactions);
  forming_take(a, sizeof of_candidates / sizeof of_candidates[0], nc, of_candidates);
  f->node_W = dlsi_take(a, 4 * nc, D);
  f->stress = dlsi_take(a, 16 * quads, D);
  f->plastic_strain = dlsi_take(a, 4 * quads, D);
  f->old = dlsi_take(a, 4 * quads, sizeof *f->old);
  f->now = dlsi_take(a, 4 * quads, sizeof *f->now);
  f->kept_points = dlsi_take(a, 4 * quads, sizeof *f->kept_points);
  f->mesh.node = dlsi_take(a, 4 * quads, I);
  f->fixed = dlsi_take(a, n, I);
  f->edge = dlsi_take(a, (size_t)f->edges, I);
  int **const of_nodes[] = {&f->held, &f->held0, &f->kept_held, &f->turns, &f->candidate_of};
  int **const of_contacts[] = {&f->candidate,   &f->meets,  &f->candidate_tool,
                               &f->chosen.mark, &f->branch, &f->node_i};
  for (size_t k = 0; k < sizeof of_nodes / sizeof of_nodes[0]; k++)
    *of_nodes[k] = dlsi_take(a, n / 2, I);
  for (size_t k = 0; k < sizeof of_contacts / sizeof of_contacts[0]; k++)
    *of_contacts[k] = dlsi_take(a, nc, I);
  f->chosen.p = dlsi_take(a, nc + 1, I);
  f->chosen.i = dlsi_take(a, 2 * nc, I);
  f->node_p = dlsi_take(a, nc + 1, I);
  if (f->settings.contact != DLS_FORMING_GAUSS_SEIDEL) return;
  const size_t entries = (2 * (size_t)f->band.k + 1) * n;
  f->Kp = dlsi_take(a, n + 1, I);
  f->Ki = dlsi_take(a, entries, I);
  f->Kx = dlsi_take(a, entries, D);
}

/* Sets sizes and takes memory, all zero; returns 0 if there is none. */
static int forming_allocate(dls_forming *f, const scene *chosen) {
  const dls_forming_settings *s = &f->settings;
  f->mesh.nodes = (s->nx + 1) * (s->ny + 1);
  f->mesh.quads = s->nx * s->ny;
  f->n = 2 * f->mesh.nodes;
  f->nc =
      chosen->build == build_indentation ? s->nx + 1 : s->nx + s->ny + (s->ram_mu > 0 ? s->nx : 0);
  f->edges = 2 * (s->nx + s->ny);
  if (!dlsi_band_create(&f->band, f->n, 2 * ((s->nx < s->ny ? s->nx : s->ny) + 2) + 1)) return 0;
  dlsi_arena arena = {0};
  forming_carve(f, &arena);
  arena.base = arena.failed ? NULL : dlsi_alloc(arena.used, 1);
  if (!arena.base) {
    f->mesh.xy = NULL;
    return 0;
  }
  memset(arena.base, 0, arena.used);
  arena.size = arena.used;
  arena.used = 0;
  forming_carve(f, &arena); /* mesh.xy is its first piece */
  return 1;
}

/* Lists the nodes of the boundary, counterclockwise from the origin. */
static void forming_trace(dls_forming *f) {
  const int nx = f->settings.nx, ny = f->settings.ny;
  int *edge = f->edge;
  for (int i = 0; i < nx; i++)
    *edge++ = node_at(f, i, 0);
  for (int j = 0; j < ny; j++)
    *edge++ = node_at(f, nx, j);
  for (int i = nx; i > 0; i--)
    *edge++ = node_at(f, i, ny);
  for (int j = ny; j > 0; j--)
    *edge++ = node_at(f, 0, j);
}

/* Fills in what follows from the scene: states at rest, patterns, friction, views. */
static void forming_derive(dls_forming *f) {
  const dls_forming_settings *s = &f->settings;
  f->solid.keep_trace = s->keep_trace;
  for (int i = 0; i < f->n; i++)
    f->before[i] = f->x0[i] = f->x[i] = f->rest[i] = f->mesh.xy[i];
  for (int i = 0; i < f->mesh.nodes; i++)
    f->candidate_of[i] = -1;
  for (int k = 0; k < 4 * f->mesh.quads; k++)
    f->old[k] = dlsi_point_virgin();
  for (int c = 0; c <= f->nc; c++) {
    f->chosen.p[c] = 2 * c;
    f->node_p[c] = c;
    if (c == f->nc) break;
    const int i = 2 * f->candidate[c];
    const double mu = f->meets[c] ? s->ram_mu : s->mu;
    f->mu[c] = f->fixed[i] || f->fixed[i + 1] ? 0 : mu;
    f->candidate_of[f->candidate[c]] = c;
    f->node_i[c] = c;
  }
  for (int i = 0; f->holds && i <= s->nx; i++) { /* the ram holds the top */
    const int node = node_at(f, i, s->ny), c = f->candidate_of[node];
    if (c < 0 || !f->meets[c]) dlsi_forming_hold(f, node, 1);
    f->held0[node] = f->held[node];
  }
  f->data = (dls_forming_data){.mesh = &f->mesh,
                               .axisymmetric = f->axisymmetric,
                               .steps = s->steps,
                               .whole = f->whole,
                               .displacement = f->displacement,
                               .reaction = f->reaction,
                               .candidates = f->nc,
                               .candidate_node = f->candidate,
                               .candidate_tool = f->candidate_tool,
                               .normal = f->normal,
                               .u = f->u,
                               .r = f->r,
                               .stress = f->stress,
                               .plastic_strain = f->plastic_strain};
  f->good = f->data;
  dlsi_forming_move_tools(f);
}

enum { iterations_each = 4 }; /* of auto, for each candidate */

/* Creates the solver of the condensed problems. Its tolerance is far below that of the step: q
 * holds the positions without reactions, so that the |q| of W's certificate is large. Sweeps
 * without acceleration do not converge in the extrusion. auto gives up after about as many
 * iterations as pivots take: a linearised problem far from the end of Newton's method may have no
 * solution, and another Newton step or method costs less than the search. */
static dls_status forming_create_solver(dls_forming *f, dls_solver **out, dls_method method,
                                        dls_error *error) {
  dls_solver_settings s;
  dls_solver_settings_init(&s);
  s.method = method;
  s.limits.tol = 1e-5 * f->settings.tol;
  s.limits.warm_start = 1;
  if (s.method == DLS_AUTO) s.limits.max_iterations = iterations_each * f->nc;
  if (s.method == DLS_NLGS) s.acceleration = DLS_ACCELERATION_ANDERSON;
  return dls_solver_create(out, 2, f->nc, &s, error);
}

static dls_status forming_make(dls_forming **out, const char *name,
                               const dls_forming_settings *settings, dls_error *error) {
  const scene *chosen = NULL;
  for (int k = 0; k < scene_count; k++)
    if (strcmp(scenes[k].name, name) == 0) chosen = &scenes[k];
  if (!chosen)
    return dlsi_fail(error, DLS_E_ARGUMENT, "name", -1, 0, "there is no scene %.60s", name);
  dls_status status = forming_check(settings, error);
  if (status) return status;
  dls_forming *f = dlsi_alloc(1, sizeof *f);
  if (!f) return dlsi_no_memory(error);
  memset(f, 0, sizeof *f);
  f->settings = *settings;
  status = forming_complete(&f->settings, chosen, error);
  if (!status && !forming_allocate(f, chosen)) status = dlsi_no_memory(error);
  if (!status) {
    chosen->build(f);
    forming_trace(f);
    forming_derive(f);
    if (f->settings.contact == DLS_FORMING_CONDENSED) {
      const dls_method method = f->settings.method;
      status = forming_create_solver(f, &f->solver, method, error);
      if (!status && method == DLS_AUTO)
        status = forming_create_solver(f, &f->last_resort, DLS_LEMKE, error);
    }
  }
  if (!status)
    *out = f;
  else
    dls_forming_destroy(f);
  return status;
}

dls_status dls_forming_create(dls_forming **out, const char *name,
                              const dls_forming_settings *settings, dls_error *error) {
  DLSI_DOOR;
  dls_forming_settings defaults;
  dls_forming_settings_init(&defaults);
  if (out) *out = NULL;
  const dls_status status = !out ? dlsi_is_null(error, "out")
                            : !name
                                ? dlsi_is_null(error, "name")
                                : forming_make(out, name, settings ? settings : &defaults, error);
  return dlsi_at(__func__, status, error);
}

void dls_forming_destroy(dls_forming *forming) {
  if (!forming) return;
  dls_solver_destroy(forming->solver);
  dls_reduction_destroy(forming->reduction);
  dls_solver_destroy(forming->last_resort);
  dlsi_band_free(&forming->band);
  free(forming->mesh.xy);
  free(forming);
}
