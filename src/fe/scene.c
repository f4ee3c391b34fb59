/*
 * scene.c: builds the scenes of [Jean 1988] 4.5, ready for the reduction.
 *
 *           | | | | | | |   top: pressure           the right half of the body is the mirror image:
 *           v v v v v v v                           u_x = 0 on x = L
 *        -> +-----------+ >|
 *        -> |           | >|                        all nodes of the bottom edge but the last one
 *   side -> |           | >|   L = 4e-3 m           are candidates to contact with y <= 0:
 *        -> |           | >|                        n = +y, t = +x, gap 0
 *        -> +-----------+ >|
 *           1 2 3 . . 16 17                         the last node (x = L, y = 0): u_y = 0 too, it
 *                                                   is not a candidate
 *
 * The paper gives block, material, friction and results, and shows mesh and loads in drawings only.
 * Its mesh, 16 x 8, and the loads below follow from its printed tables (data/jean-1988/README.md).
 * The traction on the side is linear in y and is taken at the middle of each segment: the resultant
 * does not depend on the mesh. A grade above 1 makes the elements small at the fixed node, where
 * symmetry makes the shear 0 and a zone sticks that an even mesh does not see (docs/jean.md).
 *
 * Weighted reactions: the dual cell of the last candidate reaches half way to the fixed node, so
 * that 1/8 of the reaction of that candidate goes to the fixed node. All nodes of the edge are
 * contact nodes, P is 17 x 16, and the fixed node has empty columns in H_N and H_T. Concentrated:
 * the 16 candidates are the contact nodes, no P.
 */
#include <float.h>
#include <limits.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "fe_internal.h"

/* Up to so many unknowns K is dense: the paper's mesh, 16 x 8, because a build without MUMPS
 * factors no sparse K. A sparse K takes 24 % of the instructions there, and 14 % at 23 x 11
 * (callgrind of `delassus scene jean-fig3 --mesh=23x11 --quiet`, less 27 M of the start). */
enum { most_dense = 300 };

static const double L = 4e-3; /* m */

typedef struct jean_case {
  const char *name, *description;
  double mu;
  double top;            /* pressure on the top edge                              Pa */
  double side, side_top; /* traction +x on x = 0, at its bottom and at its top    Pa */
} jean_case;

/* The 8 segments of Fig. 3 carry 10, 12, .. 24 times 1e8 Pa. */
static const jean_case cases[] = {
    {"jean-fig3", "Jean (1988) Fig. 3: elastic block pressed and pushed on a rigid plane, mu = 1",
     1, 5e8, 9e8, 25e8},
    {"jean-fig4",
     "Jean (1988) Fig. 4: the block of Fig. 3, mu = 0.1: on the paper's mesh all slide", 0.1, 5e8,
     5e8, 5e8},
};
enum { case_count = sizeof cases / sizeof cases[0] };

struct dls_fe_scene {
  dls_fe_scene_settings is; /* with all defaults filled in */
  dls_fe_mesh mesh;
  int line;     /* nodes of the bottom edge, first in the mesh; the last one is fixed */
  int unknowns; /* of the model */
  int *unknown; /* 2 * nodes of the mesh: number in the model, -1 if supported */
  double *K, *f, *f_first, *g, *mu, *one, *cell; /* K: NULL if sparse */
  dls_fe_matrix Ks;                              /* empty if dense */
  int *contact_node, *candidate_node;
  int *pn, *in, *pt, *it; /* H_N and H_T; their values are `one` */
  int *pp, *ip;           /* P */
  double *xp;
  dls_fe_scene_data data; /* views of the arrays above */
  void *memory;           /* of all arrays but the mesh's */
};

const char *dls_fe_scene_name(int index) {
  return index >= 0 && index < case_count ? cases[index].name : NULL;
}

const char *dls_fe_scene_description(int index) {
  return index >= 0 && index < case_count ? cases[index].description : NULL;
}

/* ---- settings -------------------------------------------------------------------------------- */

void dls_fe_scene_settings_init(dls_fe_scene_settings *settings) {
  if (settings) *settings = (dls_fe_scene_settings){.size = sizeof *settings, .mu = -1, .nu = -1};
}

static dls_status scene_check(const dls_fe_scene_settings *s, dls_error *error) {
  if (s->size != sizeof *s)
    return dlsi_fail(error, DLS_E_SETTINGS, "settings", -1, (double)s->size,
                     "not filled by dls_fe_scene_settings_init");
  const dlsi_setting each[] = {{"nx", s->nx, 0, INT_MAX, 0},
                               {"ny", s->ny, 0, INT_MAX, 0},
                               {"mu", s->mu, -DBL_MAX, DBL_MAX, 0},
                               {"E", s->E, 0, DBL_MAX, 0},
                               {"nu", s->nu, -1, 0.5, 0},
                               {"has_load", s->has_load, 0, 1, 0},
                               {"top", s->top, -DBL_MAX, DBL_MAX, 0},
                               {"side", s->side, -DBL_MAX, DBL_MAX, 0},
                               {"side_top", s->side_top, -DBL_MAX, DBL_MAX, 0},
                               {"order", s->order, 0, DLS_FE_SIDE_FIRST, 0},
                               {"grade", s->grade, 0, 10, 0}};
  return dlsi_check_each(sizeof each / sizeof each[0], each, error);
}

/* Replaces the settings that stand for values of the case. */
static void scene_settle(dls_fe_scene_settings *s, const jean_case *c) {
  if (!s->nx) s->nx = 16;
  if (!s->ny) s->ny = 8;
  if (s->mu < 0) s->mu = c->mu;
  if (s->E == 0) s->E = 0.13e12;
  if (s->nu == -1) s->nu = 0.2;
  if (s->grade == 0) s->grade = 1;
  if (s->has_load) return;
  s->top = c->top;
  s->side = c->side;
  s->side_top = c->side_top;
}

/* ---- making a scene -------------------------------------------------------------------------- */

static void scene_carve(dlsi_arena *arena, dls_fe_scene *s) {
  const size_t n = (size_t)s->unknowns, line = (size_t)s->line, nc = line - 1;
  s->unknown = dlsi_take(arena, 2 * (size_t)s->mesh.nodes, sizeof *s->unknown);
  if (s->unknowns <= most_dense) s->K = dlsi_take(arena, n * n, sizeof *s->K);
  s->f = dlsi_take(arena, n, sizeof *s->f);
  s->f_first = dlsi_take(arena, n, sizeof *s->f_first);
  s->g = dlsi_take(arena, 2 * line, sizeof *s->g);
  s->mu = dlsi_take(arena, nc, sizeof *s->mu);
  s->one = dlsi_take(arena, line, sizeof *s->one);
  s->cell = dlsi_take(arena, nc, sizeof *s->cell);
  s->contact_node = dlsi_take(arena, line, sizeof *s->contact_node);
  s->candidate_node = dlsi_take(arena, nc, sizeof *s->candidate_node);
  s->pn = dlsi_take(arena, line + 1, sizeof *s->pn);
  s->in = dlsi_take(arena, line, sizeof *s->in);
  s->pt = dlsi_take(arena, line + 1, sizeof *s->pt);
  s->it = dlsi_take(arena, line, sizeof *s->it);
  s->pp = dlsi_take(arena, line + 1, sizeof *s->pp);
  s->ip = dlsi_take(arena, 3 * line, sizeof *s->ip);
  s->xp = dlsi_take(arena, 3 * line, sizeof *s->xp);
}

/* Counts lines and unknowns of the mesh, and takes memory for them. */
static dls_status scene_allocate(dls_fe_scene *s, dls_error *error) {
  s->line = s->is.nx + 1;
  s->unknowns = 2 * s->mesh.nodes - (s->is.ny + 1) - 1;
  dlsi_arena arena = {0};
  scene_carve(&arena, s);
  s->memory = dlsi_alloc(arena.used, 1);
  if (!s->memory) return dlsi_no_memory(error);
  arena = (dlsi_arena){.base = s->memory, .size = arena.used};
  scene_carve(&arena, s);
  return DLS_OK;
}

/* Moves the nodes towards the fixed node (L, 0). */
static void scene_grade(dls_fe_scene *s) {
  if (s->is.grade == 1) return;
  for (int i = 0; i < s->mesh.nodes; i++) {
    double *at = s->mesh.xy + 2 * (size_t)i;
    at[0] = L * (1 - pow((double)(s->is.nx - i % s->line) / s->is.nx, s->is.grade));
    at[1] = L * pow((double)(i / s->line) / s->is.ny, s->is.grade);
  }
}

/* Numbers the unknowns in the order of the mesh, without u_x on x = L and u_y of the fixed node. */
static void scene_number_unknowns(dls_fe_scene *s) {
  int n = 0;
  for (int i = 0; i < s->mesh.nodes; i++) {
    const int on_symmetry_face = i % s->line == s->line - 1;
    s->unknown[2 * i] = on_symmetry_face ? -1 : n++;
    s->unknown[2 * i + 1] = i == s->line - 1 ? -1 : n++;
  }
}

/* f (model) := the loads, of the top or of the side or of both. F: scratch, 2 * nodes of the mesh.
 */
static dls_status scene_load(const dls_fe_scene *s, int top, int side, double *F, double *f,
                             dls_error *error) {
  const dls_fe_scene_settings *is = &s->is;
  dls_status status = DLS_OK;
  memset(F, 0, 2 * (size_t)s->mesh.nodes * sizeof *F);
  const int first = is->ny * s->line;
  for (int i = first; top && !status && i < first + is->nx; i++)
    status = dls_fe_edge_load(&s->mesh, i, i + 1, 0, -is->top, F, error);
  for (int k = 0; side && !status && k < is->ny; k++) {
    const int low = k * s->line, high = low + s->line;
    const double y = (s->mesh.xy[2 * low + 1] + s->mesh.xy[2 * high + 1]) / 2;
    status = dls_fe_edge_load(&s->mesh, low, high, is->side + (is->side_top - is->side) * (y / L),
                              0, F, error);
  }
  for (int i = 0; i < 2 * s->mesh.nodes; i++)
    if (s->unknown[i] >= 0) f[s->unknown[i]] = F[i];
  return status;
}

/* Makes f, and f_first if there are two steps. */
static dls_status scene_load_steps(dls_fe_scene *s, dls_error *error) {
  double *F = dlsi_alloc(2 * (size_t)s->mesh.nodes, sizeof *F);
  if (!F) return dlsi_no_memory(error);
  dls_status status = scene_load(s, 1, 1, F, s->f, error);
  if (!status && s->is.order) {
    const int top = s->is.order == DLS_FE_TOP_FIRST;
    status = scene_load(s, top, !top, F, s->f_first, error);
  }
  free(F);
  return status;
}

/* Assembles K of the free unknowns; a dense one from the sparse one. */
static dls_status scene_assemble(dls_fe_scene *s, dls_error *error) {
  const size_t n = (size_t)s->unknowns;
  const dls_status status =
      dls_fe_sparse_stiffness(&s->mesh, s->is.E, s->is.nu, s->unknown, s->unknowns, &s->Ks, error);
  if (status || !s->K) return status;
  const dls_sparse *A = &s->Ks.A;
  memset(s->K, 0, n * n * sizeof *s->K);
  for (size_t j = 0; j < n; j++)
    for (int k = A->p[j]; k < A->p[j + 1]; k++)
      s->K[(size_t)A->i[k] + j * n] = A->x[k];
  dls_fe_matrix_free(&s->Ks);
  return DLS_OK;
}

/* Returns the operator that picks component k (0: x, 1: y) of the contact nodes; a supported
 * unknown gives an empty column. p: out, nodes + 1; i: out, nodes. */
static dls_sparse scene_pick(const dls_fe_scene *s, int k, int nodes, int *p, int *i) {
  p[0] = 0;
  for (int c = 0; c < nodes; c++) {
    const int q = s->unknown[2 * s->contact_node[c] + k];
    p[c + 1] = p[c];
    if (q >= 0) i[p[c + 1]++] = q;
  }
  return (dls_sparse){s->unknowns, nodes, p, i, s->one};
}

/* Makes contact nodes, candidates, H_N, H_T, P, g and mu; fills s->data. */
static dls_status scene_describe(dls_fe_scene *s, int weighted, dls_error *error) {
  const int line = s->line, candidates = line - 1, nodes = weighted ? line : candidates;
  double *abscissa = dlsi_alloc((size_t)line, sizeof *abscissa + sizeof(int));
  if (!abscissa) return dlsi_no_memory(error);
  int *candidate = (int *)(void *)(abscissa + line), columns;
  for (int i = 0; i < line; i++) {
    s->contact_node[i] = i;
    s->one[i] = 1;
    s->g[2 * i] = s->g[2 * i + 1] = 0;
    abscissa[i] = s->mesh.xy[2 * i];
    candidate[i] = i < candidates;
  }
  for (int i = 0; i < candidates; i++) {
    s->candidate_node[i] = i;
    s->mu[i] = s->is.mu;
  }
  const dls_status status =
      dls_weighting_line(line, abscissa, candidate, s->pp, s->ip, s->xp, s->cell, &columns, error);
  free(abscissa);
  if (status) return status;
  const dls_sparse P = {line, columns, s->pp, s->ip, s->xp};
  const int n = s->unknowns;
  dls_model model = {.d = 2,
                     .n = n,
                     .nodes = nodes,
                     .operator_kind = s->K ? DLS_STIFFNESS_DENSE : DLS_STIFFNESS_SPARSE,
                     .factorization = DLS_CHOLESKY,
                     .HN = scene_pick(s, 1, nodes, s->pn, s->in),
                     .HT = scene_pick(s, 0, nodes, s->pt, s->it)};
  if (s->K)
    model.K = (dls_dense){n, n, n, s->K};
  else
    model.Ks = s->Ks.A;
  if (weighted) model.P = P;
  s->data = (dls_fe_scene_data){.model = model,
                                .f = s->f,
                                .g = s->g,
                                .mu = s->mu,
                                .mesh = &s->mesh,
                                .candidates = candidates,
                                .contact_node = s->contact_node,
                                .candidate_node = s->candidate_node,
                                .E = s->is.E,
                                .nu = s->is.nu,
                                .f_first = s->is.order ? s->f_first : NULL,
                                .weighting = P,
                                .cell = s->cell};
  return DLS_OK;
}

static dls_status scene_make(dls_fe_scene **out, const char *name, int weighted,
                             const dls_fe_scene_settings *settings, dls_error *error) {
  const jean_case *c = NULL;
  for (int k = 0; k < case_count; k++)
    if (strcmp(cases[k].name, name) == 0) c = &cases[k];
  if (!c) return dlsi_fail(error, DLS_E_ARGUMENT, "name", -1, 0, "there is no scene %.60s", name);
  dls_fe_scene_settings is;
  dls_fe_scene_settings_init(&is);
  if (settings) is = *settings;
  dls_status status = scene_check(&is, error);
  if (status) return status;
  scene_settle(&is, c);
  if (is.ny > INT_MAX / 72 / is.nx) /* entries of the triangles are counted in int */
    return dlsi_fail(error, DLS_E_SIZE, "ny", -1, is.ny, "%d x %d is too large", is.nx, is.ny);
  dls_fe_scene *s = dlsi_alloc(1, sizeof *s);
  if (!s) return dlsi_no_memory(error);
  *s = (dls_fe_scene){.is = is};
  status = dls_fe_mesh_block(&s->mesh, L, L, is.nx, is.ny, error);
  if (!status) status = scene_allocate(s, error);
  if (!status) {
    scene_grade(s);
    scene_number_unknowns(s);
    status = scene_assemble(s, error);
  }
  if (!status) status = scene_load_steps(s, error);
  if (!status) status = scene_describe(s, weighted, error);
  if (!status)
    *out = s;
  else
    dls_fe_scene_destroy(s);
  return status;
}

/* Checks the pointers of both functions that make a scene. */
static dls_status scene_create(dls_fe_scene **out, const char *name, int weighted,
                               const dls_fe_scene_settings *settings, dls_error *error) {
  if (out) *out = NULL;
  return !out    ? dlsi_is_null(error, "out")
         : !name ? dlsi_is_null(error, "name")
                 : scene_make(out, name, weighted, settings, error);
}

dls_status dls_fe_scene_create(dls_fe_scene **out, const char *name, int weighted,
                               dls_error *error) {
  DLSI_DOOR;
  const dls_status status = scene_create(out, name, weighted, NULL, error);
  return dlsi_at(__func__, status, error);
}

dls_status dls_fe_scene_create_with(dls_fe_scene **out, const char *name, int weighted,
                                    const dls_fe_scene_settings *settings, dls_error *error) {
  DLSI_DOOR;
  const dls_status status = scene_create(out, name, weighted, settings, error);
  return dlsi_at(__func__, status, error);
}

void dls_fe_scene_destroy(dls_fe_scene *scene) {
  if (!scene) return;
  dls_fe_matrix_free(&scene->Ks);
  dls_fe_mesh_free(&scene->mesh);
  free(scene->memory);
  free(scene);
}

/* ---- views and results ----------------------------------------------------------------------- */

void dls_fe_scene_get(const dls_fe_scene *scene, dls_fe_scene_data *data) {
  if (data) *data = scene ? scene->data : (dls_fe_scene_data){0};
}

dls_status dls_fe_scene_displacement(const dls_fe_scene *scene, const double *x,
                                     double *displacement, dls_error *error) {
  DLSI_DOOR;
  dls_status status = !scene ? dlsi_is_null(error, "scene")
                             : dlsi_check_vector("x", x, (size_t)scene->unknowns, error);
  if (!status && !displacement) status = dlsi_is_null(error, "displacement");
  if (status) return dlsi_at(__func__, status, error);
  for (int i = 0; i < 2 * scene->mesh.nodes; i++)
    displacement[i] = scene->unknown[i] < 0 ? 0 : x[scene->unknown[i]];
  return DLS_OK;
}
