/*
 * moving_scene.c: builds the scenes of bodies that move.
 *
 *   bar-*             a column of nx elements, length L, above a wall; one candidate, its lower end
 *   jean-moving*      block, loads and candidates of scene.c; the wall moves a sin(2 pi t) along t
 *   block-drop        .2 x .1, thrown at (2, -1) from .01 above the ground
 *   two-blocks        below: .1 x .05 on a smooth support that holds in both directions; above: the
 *                     same, held only by the lower block. Pressure on the top grows, then shear of
 *                     equal and opposite tractions on the top and the bottom
 *
 *        p | | | | | |       s: half of the time later
 *          v v v v v v  -> s
 *         +-----------+
 *         |   upper   |       candidates: nodes of its lower edge, operators of mortar.c
 *         +-----------+
 *         |   lower   |
 *      s<-+-----------+
 *         o o o o o o o       u_y = 0; u_x = 0 at the left node, which carries nothing
 */
#include <float.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "fe_internal.h"
#include "moving_internal.h"

typedef dls_status moving_builder(dlsi_moving_scene *s, dls_error *error);

typedef struct moving_case {
  const char *name, *description;
  const char *block; /* jean-moving: scene of scene.c */
  moving_builder *build;
  dlsi_moving_exact *exact;
  dls_motion_law law;
  dls_fe_mass_kind mass;
  int nx, ny, upper;
  double mu;
  double E, nu, rho;
  double time;    /* whole; jean-moving: in cycles */
  double courant; /* bars; 0: steps */
  int steps, parts;
} moving_case;

static moving_builder bar_impact, bar_bounce, bar_fixed, jean_moving, block_drop, two_blocks;

static const moving_case moving_cases[] = {
    {"bar-impact", "a bar hits a wall at 10 and leaves it (Doyen, Ern, Piperno 2011)", NULL,
     bar_impact, dlsi_exact_impact, DLS_MOTION_VELOCITY, DLS_FE_CONSISTENT, 100, 0, 0, 0, 900, 0, 1,
     1.5, 0.9, 0, 1},
    {"bar-bounce", "a bar falls on a wall under gravity: two impacts in a period of 16/3", NULL,
     bar_bounce, dlsi_exact_bounce, DLS_MOTION_VELOCITY, DLS_FE_LUMPED, 100, 0, 0, 0, 900, 0, 1,
     16.0 / 3, 0.9, 0, 1},
    {"bar-fixed", "a bar held at the top knocks on a wall, four periods of 3", NULL, bar_fixed,
     dlsi_exact_fixed, DLS_MOTION_VELOCITY, DLS_FE_CONSISTENT, 100, 0, 0, 0, 1, 0, 1, 12, 0.9, 0,
     1},
    {"jean-moving", "jean-fig3 on an obstacle that goes to and fro, two cycles", "jean-fig3",
     jean_moving, NULL, DLS_MOTION_PATH, DLS_FE_CONSISTENT, 16, 8, 0, -1, 0, 0, 8960, 2, 0, 800, 2},
    {"jean-moving4", "jean-fig4 on an obstacle that goes to and fro, two cycles", "jean-fig4",
     jean_moving, NULL, DLS_MOTION_PATH, DLS_FE_CONSISTENT, 16, 8, 0, -1, 0, 0, 8960, 2, 0, 800, 2},
    {"block-drop", "an elastic block thrown on the ground: impact and sliding", NULL, block_drop,
     NULL, DLS_MOTION_VELOCITY, DLS_FE_CONSISTENT, 16, 8, 0, 0.3, 1e7, 0.3, 1000, 0.03, 0, 300, 1},
    {"two-blocks", "two deformable blocks, the upper one free, pressed, then sheared", NULL,
     two_blocks, NULL, DLS_MOTION_PATH, DLS_FE_CONSISTENT, 16, 8, 11, 0.25, 1e9, 0.3, 1000, 2, 0,
     40, 2},
};
enum { moving_case_count = sizeof moving_cases / sizeof moving_cases[0] };

const char *dls_moving_name(int index) {
  return index >= 0 && index < moving_case_count ? moving_cases[index].name : NULL;
}

const char *dls_moving_description(int index) {
  return index >= 0 && index < moving_case_count ? moving_cases[index].description : NULL;
}

void dls_moving_settings_init(dls_moving_settings *settings) {
  dls_motion_settings motion;
  dls_motion_settings_init(&motion);
  if (settings)
    *settings = (dls_moving_settings){.limits = motion.limits,
                                      .size = sizeof *settings,
                                      .method = motion.method,
                                      .restitution = -1,
                                      .mu = -1,
                                      .amplitude = -1};
}

/* ---- parts of scenes ------------------------------------------------------------------------- */

/* Makes the arrays of the unknowns and candidates; unknown: -1 each, gap: 0. */
static dls_status moving_arrays(dlsi_moving_scene *s, int candidates, dls_error *error) {
  const size_t N = 2 * (size_t)s->mesh.nodes, nc = (size_t)candidates;
  s->candidates = candidates;
  s->unknown = dlsi_alloc(N, sizeof *s->unknown);
  s->candidate_node = dlsi_alloc(nc, sizeof *s->candidate_node);
  s->gap = dlsi_alloc(nc, sizeof *s->gap);
  if (!s->unknown || !s->candidate_node || !s->gap) return dlsi_no_memory(error);
  for (size_t k = 0; k < N; k++)
    s->unknown[k] = -1;
  for (size_t c = 0; c < nc; c++)
    s->gap[c] = 0;
  return DLS_OK;
}

/* Assembles K and, of a scene with mass, M. */
static dls_status moving_matrices(dlsi_moving_scene *s, dls_error *error) {
  dls_status status =
      dls_fe_sparse_stiffness(&s->mesh, s->E, s->nu, s->unknown, s->n, &s->K, error);
  if (!status && s->settings.law != DLS_MOTION_PATH)
    status = dls_fe_mass(&s->mesh, s->rho, s->settings.mass, s->unknown, s->n, &s->M, error);
  return status;
}

/* *out := n zeros. */
static dls_status moving_zeros(int n, double **out, dls_error *error) {
  *out = dlsi_alloc((size_t)n, sizeof **out);
  if (!*out) return dlsi_no_memory(error);
  for (int i = 0; i < n; i++)
    (*out)[i] = 0;
  return DLS_OK;
}

/* Makes operators that pick component y (H_N) and x (H_T) of the candidates' nodes. */
static dls_status moving_pick(dlsi_moving_scene *s, dls_error *error) {
  dls_status status = DLS_OK;
  for (int k = 0; !status && k < 2; k++) {
    dlsi_triplets t;
    status = dlsi_triplets_alloc(s->n, s->candidates, (size_t)s->candidates, &t, error);
    for (int c = 0; !status && c < s->candidates; c++) {
      const int q = s->unknown[2 * s->candidate_node[c] + 1 - k];
      if (q >= 0) dlsi_triplets_add(&t, q, c, 1);
    }
    if (!status) status = dlsi_columns_compress(&t, 1, DLSI_ALL, k ? &s->HT : &s->HN, error);
    dlsi_triplets_free(&t);
  }
  return status;
}

/* Adds the traction (tx, ty) on `count` edges between nodes first, first + 1, .. to load (n). */
static dls_status moving_traction(const dlsi_moving_scene *s, int first, int count, double tx,
                                  double ty, double *load, dls_error *error) {
  const int N = 2 * s->mesh.nodes;
  double *F;
  dls_status status = moving_zeros(N, &F, error);
  for (int e = 0; !status && e < count; e++)
    status = dls_fe_edge_load(&s->mesh, first + e, first + e + 1, tx, ty, F, error);
  for (int k = 0; !status && k < N; k++)
    if (s->unknown[k] >= 0) load[s->unknown[k]] += F[k];
  free(F);
  return status;
}

/* Makes load[0] the weight under the gravity g, along -y. */
static dls_status moving_weight(dlsi_moving_scene *s, double g, dls_error *error) {
  const dls_status status = moving_zeros(s->n, &s->load[0], error);
  if (status || s->settings.law == DLS_MOTION_PATH) return status;
  double *up; /* 1 for unknowns along y */
  if (moving_zeros(s->n, &up, error)) return DLS_E_MEMORY;
  for (int i = 0; i < s->mesh.nodes; i++)
    if (s->unknown[2 * i + 1] >= 0) up[s->unknown[2 * i + 1]] = 1;
  for (int j = 0; j < s->n; j++)
    for (int k = s->M.A.p[j]; k < s->M.A.p[j + 1]; k++)
      s->load[0][s->M.A.i[k]] -= g * s->M.A.x[k] * up[j];
  free(up);
  return DLS_OK;
}

/* ---- bars ------------------------------------------------------------------------------------ */

/* Makes a column of nx elements of the length L, held at the top or not. */
static dls_status bar_make(dlsi_moving_scene *s, double L, double gap, int held, dls_error *error) {
  const int elements = s->settings.nx;
  dls_status status = dls_fe_mesh_quads(&s->mesh, 1, L, 1, elements, error);
  if (!status) status = moving_arrays(s, 1, error);
  if (status) return status;
  s->n = elements + !held;
  for (int j = 0; j < s->n; j++) /* both nodes of a height */
    s->unknown[4 * j + 1] = s->unknown[4 * j + 3] = j;
  s->candidate_node[0] = 0;
  s->gap[0] = gap;
  const double c = sqrt(s->E / s->rho);
  if (s->settings.steps == 0) s->h = s->settings.courant * L / elements / c;
  status = moving_matrices(s, error);
  if (!status) status = moving_pick(s, error);
  return status;
}

static dls_status bar_impact(dlsi_moving_scene *s, dls_error *error) {
  dls_status status = bar_make(s, 10, 5, 0, error);
  if (!status) status = moving_zeros(s->n, &s->v, error);
  for (int i = 0; !status && i < s->n; i++)
    s->v[i] = -10;
  return status;
}

static dls_status bar_bounce(dlsi_moving_scene *s, dls_error *error) {
  const dls_status status = bar_make(s, 10, 5, 0, error);
  return status ? status : moving_weight(s, 10, error);
}

static dls_status bar_fixed(dlsi_moving_scene *s, dls_error *error) {
  dls_status status = bar_make(s, 1, 0, 1, error);
  if (!status) status = moving_zeros(s->n, &s->x, error);
  for (int j = 0; !status && j < s->n; j++)
    s->x[j] = (1 - s->mesh.xy[4 * j + 1]) / 2;
  return status;
}

/* ---- blocks ---------------------------------------------------------------------------------- */

/* Takes mesh, supports and loads of [Jean 1988] from scene.c. */
static dls_status jean_take(dlsi_moving_scene *s, const dls_fe_scene *jean, dls_error *error) {
  dls_fe_scene_data d;
  dls_fe_scene_get(jean, &d);
  const int nodes = d.mesh->nodes;
  dls_status status =
      dls_fe_mesh_block(&s->mesh, d.mesh->xy[2 * nodes - 2], d.mesh->xy[2 * nodes - 1],
                        s->settings.nx, s->settings.ny, error);
  if (!status) status = moving_arrays(s, d.candidates, error);
  if (!status) status = moving_zeros(d.model.n, &s->load[0], error);
  double *number = NULL, *place = NULL; /* 1, 2, .. on the unknowns, which scene.c puts in place */
  if (!status) status = moving_zeros(d.model.n, &number, error);
  if (!status) status = moving_zeros(2 * nodes, &place, error);
  for (int k = 0; !status && k < d.model.n; k++)
    number[k] = k + 1;
  if (!status) status = dls_fe_scene_displacement(jean, number, place, error);
  if (!status) {
    s->n = d.model.n;
    s->E = d.E;
    s->nu = d.nu;
    if (s->settings.mu < 0) s->settings.mu = d.mu[0];
    for (int k = 0; k < 2 * nodes; k++)
      s->unknown[k] = (int)place[k] - 1;
    for (int c = 0; c < d.candidates; c++)
      s->candidate_node[c] = d.contact_node[d.candidate_node[c]];
    memcpy(s->load[0], d.f, (size_t)s->n * sizeof *s->load[0]);
  }
  free(number);
  free(place);
  return status;
}

static dls_status jean_moving(dlsi_moving_scene *s, dls_error *error) {
  dls_fe_scene *jean;
  dls_status status = dls_fe_scene_create(&jean, s->block, 0, error);
  if (!status) status = jean_take(s, jean, error);
  dls_fe_scene_destroy(jean);
  if (!status) status = moving_matrices(s, error);
  if (!status) status = moving_pick(s, error);
  s->shaken = 1;
  return status;
}

static dls_status block_drop(dlsi_moving_scene *s, dls_error *error) {
  const int line = s->settings.nx + 1;
  dls_status status = dls_fe_mesh_block(&s->mesh, 0.2, 0.1, s->settings.nx, s->settings.ny, error);
  if (!status) status = moving_arrays(s, line, error);
  s->n = 2 * s->mesh.nodes;
  if (!status) status = moving_zeros(s->n, &s->v, error);
  if (status) return status;
  for (int k = 0; k < s->n; k++) {
    s->unknown[k] = k;
    s->v[k] = k % 2 ? -1 : 2;
  }
  for (int c = 0; c < line; c++) {
    s->candidate_node[c] = c;
    s->gap[c] = 0.01;
  }
  status = moving_matrices(s, error);
  if (!status) status = moving_pick(s, error);
  if (!status) status = moving_weight(s, 9.81, error);
  return status;
}

/* Joins the meshes of two blocks of four-node elements, the upper one moved up by the height. */
static dls_status blocks_join(dlsi_moving_scene *s, const dls_fe_mesh *lower,
                              const dls_fe_mesh *upper, double height, dls_error *error) {
  const int nodes = lower->nodes + upper->nodes, quads = lower->quads + upper->quads;
  s->mesh.xy = dlsi_alloc(2 * (size_t)nodes, sizeof *s->mesh.xy);
  s->mesh.quad = dlsi_alloc(4 * (size_t)quads, sizeof *s->mesh.quad);
  if (!s->mesh.xy || !s->mesh.quad) return dlsi_no_memory(error);
  s->mesh.nodes = nodes;
  s->mesh.quads = quads;
  for (int k = 0; k < 2 * nodes; k++) {
    const int at = k - 2 * lower->nodes;
    s->mesh.xy[k] = at < 0 ? lower->xy[k] : upper->xy[at] + (k % 2 ? height : 0);
  }
  for (int k = 0; k < 4 * quads; k++) {
    const int at = k - 4 * lower->quads;
    s->mesh.quad[k] = at < 0 ? lower->quad[k] : upper->quad[at] + lower->nodes;
  }
  return DLS_OK;
}

/* Makes H_N and H_T of the candidates on the first `na` nodes of the upper block above the last
 * `nb` nodes of the lower one. A, B: room of dlsi_mortar_line. */
static dls_status blocks_operators(dlsi_moving_scene *s, int na, int nb, double *A, double *B,
                                   double *abscissa, dls_error *error) {
  const int first_a = s->candidate_node[0], first_b = first_a - nb;
  for (int k = 0; k < na + nb; k++)
    abscissa[k] = s->mesh.xy[2 * (k < na ? first_a + k : first_b + k - na)];
  dlsi_mortar_line(na, abscissa, nb, abscissa + na, A, B);
  dls_status status = DLS_OK;
  for (int k = 0; !status && k < 2; k++) {
    dlsi_triplets t;
    status = dlsi_triplets_alloc(s->n, na, (size_t)na * (size_t)(na + nb), &t, error);
    for (int i = 0; !status && i < na; i++) {
      for (int j = 0; j < na; j++)
        if (A[i * na + j] != 0)
          dlsi_triplets_add(&t, s->unknown[2 * (first_a + j) + 1 - k], i, A[i * na + j]);
      for (int j = 0; j < nb; j++)
        if (B[i * nb + j] != 0)
          dlsi_triplets_add(&t, s->unknown[2 * (first_b + j) + 1 - k], i, -B[i * nb + j]);
    }
    if (!status) status = dlsi_columns_compress(&t, 1, DLSI_ALL, k ? &s->HT : &s->HN, error);
    dlsi_triplets_free(&t);
  }
  return status;
}

/* Numbers the unknowns and makes loads, operators and matrices on the joint mesh. */
static dls_status blocks_fill(dlsi_moving_scene *s, dls_error *error) {
  const double pressure = 1e6, shear = 0.2e6;
  const int nx = s->settings.nx, up = s->settings.upper, nodes = s->mesh.nodes;
  const int first = (nx + 1) * (s->settings.ny + 1), na = up + 1, nb = nx + 1;
  dls_status status = moving_arrays(s, na, error);
  if (status) return status;
  for (int i = 0; i < nodes; i++) { /* the support: y of the lowest line, x of its first node */
    if (i != 0) s->unknown[2 * i] = s->n++;
    if (i > nx) s->unknown[2 * i + 1] = s->n++;
  }
  for (int c = 0; c < na; c++)
    s->candidate_node[c] = first + c;
  for (int k = 0; !status && k < 2; k++)
    status = moving_zeros(s->n, &s->load[k], error);
  if (!status) status = moving_traction(s, nodes - na, up, 0, -pressure, s->load[0], error);
  if (!status) status = moving_traction(s, nodes - na, up, shear, 0, s->load[1], error);
  if (!status) status = moving_traction(s, 0, nx, -shear, 0, s->load[1], error);
  double *room = status ? NULL : dlsi_alloc((size_t)(na + 1) * (size_t)(na + nb), sizeof *room);
  if (!status && !room) status = dlsi_no_memory(error);
  if (!status)
    status = blocks_operators(s, na, nb, room, room + na * na, room + na * (na + nb), error);
  free(room);
  return status ? status : moving_matrices(s, error);
}

static dls_status two_blocks(dlsi_moving_scene *s, dls_error *error) {
  const double width = 0.1, height = 0.05;
  dls_fe_mesh lower = {0}, upper = {0};
  s->ramped = 1;
  dls_status status =
      dls_fe_mesh_quads(&lower, width, height, s->settings.nx, s->settings.ny, error);
  if (!status)
    status = dls_fe_mesh_quads(&upper, width, height, s->settings.upper, s->settings.ny, error);
  if (!status) status = blocks_join(s, &lower, &upper, height, error);
  dls_fe_mesh_free(&lower);
  dls_fe_mesh_free(&upper);
  return status ? status : blocks_fill(s, error);
}

/* ---- a scene --------------------------------------------------------------------------------- */

/* Puts the scene's own values where the settings ask for them. */
static void moving_fill(dlsi_moving_scene *s, const moving_case *c) {
  dls_moving_settings *o = &s->settings;
  if (!o->law) o->law = c->law;
  if (!o->mass) o->mass = c->mass;
  if (o->theta == 0) o->theta = o->law == DLS_MOTION_VELOCITY ? 0.5 : 1;
  if (o->restitution < 0) o->restitution = 0;
  if (o->mu < 0) o->mu = c->mu;
  if (!o->nx) o->nx = c->nx;
  if (!o->ny) o->ny = c->ny;
  if (!o->upper) o->upper = c->upper;
  if (o->amplitude < 0) o->amplitude = 1e-5;
  if (o->frequency == 0) o->frequency = o->law == DLS_MOTION_PATH ? 1 : 1000;
  s->E = c->E;
  s->nu = c->nu;
  s->rho = c->rho;
  s->exact = c->exact;
  s->block = c->block;
  s->time = c->build == jean_moving ? c->time / o->frequency : c->time;
  if (o->steps == 0 && c->courant == 0) o->steps = c->steps;
  if (c->courant > 0 && o->steps == 0 && o->courant == 0) o->courant = c->courant;
  if (o->steps > 0) s->h = s->time / o->steps;
}

/* Checks what the motion does not check itself. */
static dls_status moving_check(const dls_moving_settings *o, dls_error *error) {
  const dlsi_setting own[] = {{"mass", o->mass, 0, 2, 0},
                              {"courant", o->courant, 0, DBL_MAX, 0},
                              {"steps", o->steps, 0, 1e9, 0},
                              {"nx", o->nx, 0, 1e6, 0},
                              {"ny", o->ny, 0, 1e6, 0},
                              {"upper", o->upper, 0, 1e6, 0},
                              {"mu", o->mu, -DBL_MAX, DBL_MAX, 0},
                              {"amplitude", o->amplitude, -DBL_MAX, DBL_MAX, 0},
                              {"frequency", o->frequency, 0, DBL_MAX, 0},
                              {"restitution", o->restitution, -DBL_MAX, 1, 0},
                              {"law", o->law, 0, 3, 0},
                              {"theta", o->theta, 0, 1, 0}};
  return dlsi_check_settings(&o->limits, o->size, sizeof *o, sizeof own / sizeof own[0], own,
                             error);
}

dls_status dlsi_moving_build(dlsi_moving_scene *scene, const char *name,
                             const dls_moving_settings *settings, dls_error *error) {
  dls_moving_settings own;
  dls_moving_settings_init(&own);
  *scene = (dlsi_moving_scene){.settings = settings ? *settings : own};
  dls_status status = moving_check(&scene->settings, error);
  if (status) return status;
  const moving_case *c = NULL;
  for (int k = 0; k < moving_case_count; k++)
    if (strcmp(moving_cases[k].name, name) == 0) c = &moving_cases[k];
  if (!c) return dlsi_fail(error, DLS_E_ARGUMENT, "name", -1, 0, "there is no scene %.60s", name);
  moving_fill(scene, c);
  if (c->block && (scene->settings.nx != c->nx || scene->settings.ny != c->ny))
    return dlsi_fail(error, DLS_E_ARGUMENT, "nx", -1, scene->settings.nx,
                     "the mesh of this scene is %d x %d", c->nx, c->ny);
  if (c->exact && scene->settings.law == DLS_MOTION_PATH)
    return dlsi_fail(error, DLS_E_ARGUMENT, "law", -1, scene->settings.law,
                     "a bar in flight has no equilibrium");
  status = c->build(scene, error);
  if (status) return status;
  scene->steps = scene->settings.steps;
  if (scene->steps == 0) scene->steps = (int)ceil(scene->time / scene->h * (1 - DBL_EPSILON));
  scene->cycle = scene->steps / c->parts;
  return DLS_OK;
}

void dlsi_moving_free(dlsi_moving_scene *s) {
  dls_fe_mesh_free(&s->mesh);
  dls_fe_matrix_free(&s->K);
  dls_fe_matrix_free(&s->M);
  dlsi_columns_free(&s->HN);
  dlsi_columns_free(&s->HT);
  free(s->unknown);
  free(s->candidate_node);
  free(s->gap);
  free(s->load[0]);
  free(s->load[1]);
  free(s->x);
  free(s->v);
}
