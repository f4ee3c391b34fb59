/*
 * scene.c: builds the scenes of [Jean 1988] 4.5, ready for the reduction.
 *
 *           | | | | | | |   top: pressure           the right half of the body is the mirror image:
 *           v v v v v v v                           u_x = 0 on x = L
 *        -> +-----------+ >|
 *        -> |           | >|                        nodes 1 .. 16 of the bottom edge are candidates
 *   side -> |           | >|   L = 4e-3 m           to contact with y <= 0: n = +y, t = +x, gap 0
 *        -> |           | >|
 *        -> +-----------+ >|                        node 17 (x = L, y = 0): u_y = 0 too, it is not
 *           1 2 3 . . 16 17                         a candidate
 *
 * The paper gives block, material, friction and results, and shows mesh and loads in drawings only.
 * The mesh and loads below follow from its printed tables (data/jean-1988/README.md).
 *
 * Weighted reactions: the dual cell of candidate 16 reaches half way to node 17, so that 1/8 of the
 * reaction of candidate 16 goes to that fixed node. All 17 nodes are contact nodes, P is 17 x 16,
 * and node 17 has empty columns in H_N and H_T. Concentrated: the 16 candidates are the contact
 * nodes, no P.
 */
#include <stdlib.h>
#include <string.h>

#include "fe_internal.h"

enum {
  nx = 16,
  ny = 8,
  line = nx + 1,   /* nodes of the bottom edge; they come first in the mesh */
  fixed_node = nx, /* node 17 */
  candidate_count = nx,
  unknowns = 2 * (nx + 1) * (ny + 1) - (ny + 1) - 1
};

static const double L = 4e-3, E = 0.13e12, nu = 0.2; /* m, Pa */

typedef struct jean_case {
  const char *name, *description;
  double mu;
  double top;             /* pressure on the top edge                               Pa */
  double side, side_step; /* traction +x on the k-th of the ny segments of x = 0:
                             side + k side_step, counted from the bottom            Pa */
} jean_case;

static const jean_case cases[] = {
    {"jean-fig3", "Jean (1988) Fig. 3: elastic block pressed and pushed on a rigid plane, mu = 1",
     1, 5e8, 10e8, 2e8},
    {"jean-fig4", "Jean (1988) Fig. 4: the same block, all candidates slide, mu = 0.1", 0.1, 5e8,
     5e8, 0},
};
enum { case_count = sizeof cases / sizeof cases[0] };

struct dls_fe_scene {
  dls_fe_mesh mesh;
  int *unknown; /* 2 * nodes of the mesh: number in the model, -1 if supported */
  double *K, *f, *g, *mu, *one;
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

/* ---- making a scene -------------------------------------------------------------------------- */

static void scene_carve(dlsi_arena *arena, dls_fe_scene *s) {
  s->unknown = dlsi_take(arena, 2 * (size_t)s->mesh.nodes, sizeof *s->unknown);
  s->K = dlsi_take(arena, (size_t)unknowns * unknowns, sizeof *s->K);
  s->f = dlsi_take(arena, unknowns, sizeof *s->f);
  s->g = dlsi_take(arena, 2 * line, sizeof *s->g);
  s->mu = dlsi_take(arena, candidate_count, sizeof *s->mu);
  s->one = dlsi_take(arena, line, sizeof *s->one);
  s->contact_node = dlsi_take(arena, line, sizeof *s->contact_node);
  s->candidate_node = dlsi_take(arena, candidate_count, sizeof *s->candidate_node);
  s->pn = dlsi_take(arena, line + 1, sizeof *s->pn);
  s->in = dlsi_take(arena, line, sizeof *s->in);
  s->pt = dlsi_take(arena, line + 1, sizeof *s->pt);
  s->it = dlsi_take(arena, line, sizeof *s->it);
  s->pp = dlsi_take(arena, line + 1, sizeof *s->pp);
  s->ip = dlsi_take(arena, 3 * line, sizeof *s->ip);
  s->xp = dlsi_take(arena, 3 * line, sizeof *s->xp);
}

static dls_status scene_allocate(dls_fe_scene *s, dls_error *error) {
  dlsi_arena arena = {0};
  scene_carve(&arena, s);
  s->memory = dlsi_alloc(arena.used, 1);
  if (!s->memory) return dlsi_no_memory(error);
  arena = (dlsi_arena){.base = s->memory, .size = arena.used};
  scene_carve(&arena, s);
  return DLS_OK;
}

/* Numbers the unknowns in the order of the mesh, u_x on x = L and u_y of node 17 left out. */
static void scene_number_unknowns(dls_fe_scene *s) {
  int n = 0;
  for (int i = 0; i < s->mesh.nodes; i++) {
    const int on_symmetry_face = i % (nx + 1) == nx;
    s->unknown[2 * i] = on_symmetry_face ? -1 : n++;
    s->unknown[2 * i + 1] = i == fixed_node ? -1 : n++;
  }
}

/* Adds the loads of the case to F (2 * nodes of the mesh). */
static dls_status scene_load(const dls_fe_mesh *mesh, const jean_case *c, double *F,
                             dls_error *error) {
  dls_status status = DLS_OK;
  const int top = ny * (nx + 1);
  for (int i = 0; !status && i < nx; i++)
    status = dls_fe_edge_load(mesh, top + i, top + i + 1, 0, -c->top, F, error);
  for (int k = 0; !status && k < ny; k++)
    status = dls_fe_edge_load(mesh, k * (nx + 1), (k + 1) * (nx + 1), c->side + k * c->side_step, 0,
                              F, error);
  return status;
}

/* Assembles K and f of the free unknowns. */
static dls_status scene_assemble(dls_fe_scene *s, const jean_case *c, dls_error *error) {
  const int N = 2 * s->mesh.nodes;
  double *K = dlsi_alloc((size_t)N * (size_t)(N + 1), sizeof *K);
  if (!K) return dlsi_no_memory(error);
  double *F = K + (size_t)N * (size_t)N;
  memset(F, 0, (size_t)N * sizeof *F);
  dls_status status = dls_fe_stiffness(&s->mesh, E, nu, K, N, error);
  if (!status) status = scene_load(&s->mesh, c, F, error);
  if (!status)
    for (int j = 0; j < N; j++) {
      const int q = s->unknown[j];
      if (q < 0) continue;
      s->f[q] = F[j];
      for (int i = 0; i < N; i++)
        if (s->unknown[i] >= 0) s->K[s->unknown[i] + q * unknowns] = K[i + j * N];
    }
  free(K);
  return status;
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
  return (dls_sparse){unknowns, nodes, p, i, s->one};
}

/* Makes contact nodes, candidates, H_N, H_T, P, g and mu; fills s->data. */
static dls_status scene_describe(dls_fe_scene *s, const jean_case *c, int weighted,
                                 dls_error *error) {
  const int nodes = weighted ? line : candidate_count;
  double abscissa[line];
  int candidate[line];
  for (int i = 0; i < line; i++) {
    s->contact_node[i] = i;
    s->one[i] = 1;
    s->g[2 * i] = s->g[2 * i + 1] = 0;
    abscissa[i] = s->mesh.xy[2 * i];
    candidate[i] = i != fixed_node;
  }
  for (int i = 0; i < candidate_count; i++) {
    s->candidate_node[i] = i;
    s->mu[i] = c->mu;
  }
  dls_model model = {.d = 2,
                     .n = unknowns,
                     .nodes = nodes,
                     .operator_kind = DLS_STIFFNESS_DENSE,
                     .factorization = DLS_CHOLESKY,
                     .K = {unknowns, unknowns, unknowns, s->K},
                     .HN = scene_pick(s, 1, nodes, s->pn, s->in),
                     .HT = scene_pick(s, 0, nodes, s->pt, s->it)};
  if (weighted) {
    int columns;
    const dls_status status =
        dls_weighting_line(line, abscissa, candidate, s->pp, s->ip, s->xp, NULL, &columns, error);
    if (status) return status;
    model.P = (dls_sparse){line, columns, s->pp, s->ip, s->xp};
  }
  s->data = (dls_fe_scene_data){.model = model,
                                .f = s->f,
                                .g = s->g,
                                .mu = s->mu,
                                .mesh = &s->mesh,
                                .candidates = candidate_count,
                                .contact_node = s->contact_node,
                                .candidate_node = s->candidate_node,
                                .E = E,
                                .nu = nu};
  return DLS_OK;
}

static dls_status scene_make(dls_fe_scene **out, const char *name, int weighted, dls_error *error) {
  const jean_case *c = NULL;
  for (int k = 0; k < case_count; k++)
    if (strcmp(cases[k].name, name) == 0) c = &cases[k];
  if (!c) return dlsi_fail(error, DLS_E_ARGUMENT, "name", -1, 0, "there is no scene %.60s", name);
  dls_fe_scene *s = dlsi_alloc(1, sizeof *s);
  if (!s) return dlsi_no_memory(error);
  *s = (dls_fe_scene){0};
  dls_status status = dls_fe_mesh_block(&s->mesh, L, L, nx, ny, error);
  if (!status) status = scene_allocate(s, error);
  if (!status) {
    scene_number_unknowns(s);
    status = scene_assemble(s, c, error);
  }
  if (!status) status = scene_describe(s, c, weighted, error);
  if (!status)
    *out = s;
  else
    dls_fe_scene_destroy(s);
  return status;
}

dls_status dls_fe_scene_create(dls_fe_scene **out, const char *name, int weighted,
                               dls_error *error) {
  if (out) *out = NULL;
  const dls_status status = !out    ? dlsi_is_null(error, "out")
                            : !name ? dlsi_is_null(error, "name")
                                    : scene_make(out, name, weighted, error);
  return dlsi_at(__func__, status, error);
}

void dls_fe_scene_destroy(dls_fe_scene *scene) {
  if (!scene) return;
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
  dls_status status =
      !scene ? dlsi_is_null(error, "scene") : dlsi_check_vector("x", x, unknowns, error);
  if (!status && !displacement) status = dlsi_is_null(error, "displacement");
  if (status) return dlsi_at(__func__, status, error);
  for (int i = 0; i < 2 * scene->mesh.nodes; i++)
    displacement[i] = scene->unknown[i] < 0 ? 0 : x[scene->unknown[i]];
  return DLS_OK;
}
