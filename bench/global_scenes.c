/* global_scenes.c: meshes, loads and contacts, as global_scenes.h describes them. */
#include "global_scenes.h"

#include <math.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include "common.h"
#include "reduction_boxes.h"

const char *const scene_kind_name[] = {"strip", "sheets", "rim", "plate", "tube"};
const char *const scene_support_name[] = {"soft", "held", "free"};
const char *const scene_load_name[] = {"press", "shear", "lift"};

static const double pi = 3.14159265358979323846;
static const double clamp = 1e3, pad = .05, pressure = 1e-2;

/* A body under work: nodes (i, j, k) of one or two grids. */
typedef struct mesh {
  scene *S;
  int d;
  dlsi_triplets K, N, T;
  double wave[6]; /* factors of wave numbers, and phases, of the loads */
} mesh;

/* ---- elements -------------------------------------------------------------------------------- */

static void element_add(mesh *M, const int *node, const double *x) {
  const int d = M->d, size = d << d;
  double A[24 * 24];
  box_element(d, x, .3, A);
  for (int a = 0; a < size; a++)
    for (int b = 0; b < size; b++) {
      const int i = d * node[a / d] + a % d, j = d * node[b / d] + b % d;
      if (i >= j) dlsi_triplets_add(&M->K, i, j, A[a + size * b]);
    }
}

/* ---- grids ----------------------------------------------------------------------------------- */

typedef struct grid {
  int first, count[3]; /* first node; elements */
  int closed;          /* 1: the last column of nodes is the first one */
  int along;           /* nodes along i */
  double width;        /* of an element along i, for straight grids */
} grid;

static int grid_node(const grid *g, int i, int j, int k) {
  return g->first + i % g->along + g->along * (j + (g->count[1] + 1) * k);
}

static int grid_nodes(const grid *g) {
  return g->along * (g->count[1] + 1) * (g->count[2] + 1);
}

/* Angle, and radius beside the one of the contacts, of a node of a round grid. */
static double round_angle(const grid *g, int i) {
  return 2 * pi * i / g->count[0];
}

/* RIM: the height of the teeth is 2 elements: 8 elements up, 8 down, inclined between. */
static double tooth(int i) {
  const int at = i % 16;
  return at < 2 ? at : at <= 8 ? 2 : at < 10 ? 10 - at : 0;
}

static void grid_place(const scene *S, const grid *g, int i, int j, int k, double *x) {
  const double radius = g->count[0] / (2 * pi), angle = round_angle(g, i);
  if (S->kind == RIM) { /* j = ny: outside */
    const double r = radius + j + tooth(i % g->count[0]) * j / g->count[1];
    x[0] = r * cos(angle);
    x[1] = r * sin(angle);
  } else if (S->kind == TUBE) { /* k = 0: outside */
    const double r = radius + g->count[2] - k;
    x[0] = r * cos(angle);
    x[1] = j;
    x[2] = r * sin(angle);
  } else {
    x[0] = g->width * i;
    x[1] = j;
    if (S->d == 3) x[2] = k;
  }
}

static void grid_add(mesh *M, const grid *g) {
  for (int k = 0; k < (M->d == 3 ? g->count[2] : 1); k++)
    for (int j = 0; j < g->count[1]; j++)
      for (int i = 0; i < g->count[0]; i++) {
        int node[8];
        double x[24];
        for (int c = 0; c < 1 << M->d; c++) {
          const int at[3] = {i + (c & 1), j + (c >> 1 & 1), k + (c >> 2 & 1)};
          node[c] = grid_node(g, at[0], at[1], at[2]);
          grid_place(M->S, g, at[0], at[1], at[2], x + M->d * c);
        }
        element_add(M, node, x);
      }
}

/* ---- supports, loads, contacts --------------------------------------------------------------- */

static void node_spring(mesh *M, int node, double stiffness) {
  for (int k = 0; k < M->d; k++)
    dlsi_triplets_add(&M->K, M->d * node + k, M->d * node + k, stiffness);
}

/* Adds a contact of a node; normal: d, the tangents follow. The other side is the ground, or the
 * segment from node other[0] to other[1] at `s` of its length. */
static void contact_add(mesh *M, int node, const double *normal, double gap, const int *other,
                        double s) {
  scene *S = M->S;
  const int d = M->d, c = S->nc++;
  const double n0 = normal[0], n1 = normal[1], n2 = d == 3 ? normal[2] : 0;
  double t[2][3] = {{d == 2 ? n1 : 0, d == 2 ? -n0 : 0, 0}};
  if (d == 3) { /* t1 along y, which lies in all surfaces here */
    t[0][1] = 1;
    t[1][0] = n1 * t[0][2] - n2 * t[0][1];
    t[1][1] = n2 * t[0][0] - n0 * t[0][2];
    t[1][2] = n0 * t[0][1] - n1 * t[0][0];
  }
  const int nodes[3] = {node, other ? other[0] : 0, other ? other[1] : 0};
  const double part[3] = {1, s - 1, -s};
  for (int a = 0; a < (other ? 3 : 1); a++)
    for (int k = 0; k < d; k++) {
      const int i = d * nodes[a] + k;
      if (normal[k] != 0 && part[a] != 0) dlsi_triplets_add(&M->N, i, c, part[a] * normal[k]);
      for (int l = 0; l < d - 1; l++)
        if (t[l][k] != 0 && part[a] != 0)
          dlsi_triplets_add(&M->T, i, (d - 1) * c + l, part[a] * t[l][k]);
    }
  S->g[d * c] = gap;
}

/* Loads the node at (s, t) of the surface, 0 to 1, by the normal and tangents of its contacts; area
 * that of its elements. */
static void node_load(mesh *M, int node, const double *normal, double s, double t, double area) {
  const double *w = M->wave;
  scene *S = M->S;
  const int d = M->d;
  double along, across = 0, down;
  if (d == 2) {
    const double wave = sin(11 * pi * w[0] * s + w[3]);
    along = 2.5e-3 * sin(9 * pi * w[1] * s + w[4]);
    down = pressure * (1 + .5 * cos(40 * w[2] * s + w[5]) * (sin(7 * s) > 0 ? 1 : -1));
    if (S->load == LIFT && wave <= -.6) down = -8e-3;
  } else {
    along = 2.5e-3 * sin(8 * w[0] * s + 3 * t + w[3]);
    across = 2e-3 * cos(6 * w[1] * s - 7 * t + w[4]);
    down = pressure * (1 + .5 * cos(13 * w[2] * s + 7 * t + w[5]));
    if (S->load == LIFT && sin(9 * s - 5 * t) < -.55) down -= 1.8e-2;
  }
  if (S->load != LIFT) along *= .2;
  if (S->load != LIFT) across *= .2;
  if (S->load == SHEAR) along += .5 * pressure;
  if (d == 2) {
    S->f[2 * node] += area * (along * normal[1] - down * normal[0]);
    S->f[2 * node + 1] += area * (-along * normal[0] - down * normal[1]);
  } else { /* along: z x y; in a plate that is x */
    S->f[3 * node] += area * (along * normal[2] - down * normal[0]);
    S->f[3 * node + 1] += area * across;
    S->f[3 * node + 2] += area * (-along * normal[0] - down * normal[2]);
  }
}

/* Makes the contacts on the row j = 0, or the face k = 0, of a straight grid, and loads the one
 * opposite. */
static void straight(mesh *M, const grid *g) {
  const scene *S = M->S;
  const int d = M->d, nx = g->count[0], ny = g->count[1];
  const double up[3] = {0, d == 2, d == 3};
  for (int i = 0; i <= nx; i++)
    for (int j = 0; j <= (d == 3 ? ny : 0); j++) {
      const int below = grid_node(g, i, j, 0);
      const int above = d == 3 ? grid_node(g, i, j, g->count[2]) : grid_node(g, i, ny, 0);
      node_load(M, above, up, (double)i / nx, d == 3 ? (double)j / ny : 0, g->width);
      if (S->support == SOFT) node_spring(M, above, g->width * pad);
      const int clamped = S->kind == STRIP && S->support != FREE ? i == nx
                          : S->support == HELD                   ? i == 0
                                                                 : 0;
      for (int k = 0; clamped && k <= (d == 3 ? g->count[2] : ny); k++)
        node_spring(M, d == 3 ? grid_node(g, i, j, k) : grid_node(g, i, k, 0), clamp);
      if (S->kind != SHEETS && !(S->kind == STRIP && clamped))
        contact_add(M, below, up, 0, NULL, 0);
    }
}

/* The upper sheet is g, the lower one `low`. */
static void sheets(mesh *M, const grid *g, const grid *low) {
  const double up[2] = {0, 1};
  straight(M, g);
  for (int i = 0; i <= low->count[0]; i++)
    node_spring(M, grid_node(low, i, 0, 0), clamp);
  for (int i = 0; i <= g->count[0]; i++) {
    const double at = (double)i / g->count[0] * low->count[0];
    int segment = (int)at;
    if (segment == low->count[0]) segment--;
    const int other[2] = {grid_node(low, segment, low->count[1], 0),
                          grid_node(low, segment + 1, low->count[1], 0)};
    contact_add(M, grid_node(g, i, 0, 0), up, 0, other, at - segment);
  }
}

/* Contacts of the nodes outside, loads inside. */
static void round_body(mesh *M, const grid *g) {
  const scene *S = M->S;
  const int d = M->d, nx = g->count[0], ny = g->count[1];
  for (int i = 0; i < nx; i++)
    for (int j = 0; j <= (d == 3 ? ny : 0); j++) {
      const double a = round_angle(g, i), c = cos(a), s = sin(a);
      const double in[3] = {-c, d == 2 ? -s : 0, -s}; /* out of the cavity */
      const int outer = d == 3 ? grid_node(g, i, j, 0) : grid_node(g, i, ny, 0);
      const int inner = d == 3 ? grid_node(g, i, j, g->count[2]) : grid_node(g, i, 0, 0);
      node_load(M, inner, in, (double)i / nx, d == 3 ? (double)j / ny : 0, 1);
      if (S->support == SOFT) node_spring(M, inner, pad);
      if (S->support == HELD) node_spring(M, inner, clamp);
      if (d == 2 && tooth(i) < 2) continue;
      contact_add(M, outer, in, S->support == FREE ? 0 : 1e-3 * (1 + cos(2 * a)), NULL, 0);
    }
}

/* ---- the whole ------------------------------------------------------------------------------- */

static int scene_fill(mesh *M, const grid *g, const grid *low) {
  scene *S = M->S;
  grid_add(M, g);
  if (S->kind == SHEETS) {
    grid_add(M, low);
    sheets(M, g, low);
  } else if (S->kind == RIM || S->kind == TUBE)
    round_body(M, g);
  else
    straight(M, g);
  M->N.cols = S->nc;
  M->T.cols = (S->d - 1) * S->nc;
  if (dlsi_columns_compress(&M->K, 1, DLSI_ALL, &S->K, NULL) ||
      dlsi_columns_compress(&M->N, 1, DLSI_ALL, &S->N, NULL) ||
      dlsi_columns_compress(&M->T, 1, DLSI_ALL, &S->T, NULL))
    return -1;
  S->model = (dls_model){.d = S->d,
                         .n = S->n,
                         .nodes = S->nc,
                         .operator_kind = DLS_STIFFNESS_SPARSE,
                         .factorization = DLS_CHOLESKY,
                         .Ks = dlsi_columns_view(&S->K),
                         .HN = dlsi_columns_view(&S->N),
                         .HT = dlsi_columns_view(&S->T)};
  return 0;
}

/* Adds up the entries of each place: hosts hand K over like that. */
static void columns_add_up(dlsi_columns *A) {
  int *at = malloc((size_t)A->rows * sizeof *at), end = 0;
  if (!at) return;
  for (int i = 0; i < A->rows; i++)
    at[i] = -1;
  for (int j = 0; j < A->cols; j++) {
    const int from = A->p[j], begin = end;
    A->p[j] = begin;
    for (int k = from; k < A->p[j + 1]; k++) {
      const int i = A->i[k];
      if (at[i] < begin) {
        at[i] = end++;
        A->i[at[i]] = i;
        A->x[at[i]] = A->x[k];
      } else
        A->x[at[i]] += A->x[k];
    }
  }
  A->p[A->cols] = end;
  free(at);
}

int scene_create(scene *S) {
  const int closed = S->kind == RIM || S->kind == TUBE;
  S->d = S->kind == PLATE || S->kind == TUBE ? 3 : 2;
  if (S->d == 2) S->size[2] = 0;
  const int *s = S->size, along = closed ? s[0] : s[0] + 1;
  const grid g = {0, {s[0], s[1], s[2]}, closed, along, 1};
  const int fewer = s[0] * 2 / 3;
  const grid low = {grid_nodes(&g), {fewer, s[1], 0}, 0, fewer + 1, (double)s[0] / fewer};
  const int nodes = grid_nodes(&g) + (S->kind == SHEETS ? grid_nodes(&low) : 0);
  const int contacts = along * (S->d == 3 ? s[1] + 1 : 1);
  const size_t each = S->d == 2 ? 36 : 300; /* entries of an element; there are fewer than nodes */
  mesh M = {.S = S, .d = S->d};
  uint64_t draw = (uint64_t)S->seed;
  for (int k = 0; k < 6; k++) {
    const double by = S->seed ? bench_draw(&draw) : 0;
    M.wave[k] = k < 3 ? 1 + .2 * by : pi * by;
  }
  S->n = S->d * nodes;
  S->nc = 0;
  S->K = S->N = S->T = (dlsi_columns){0};
  S->f = calloc((size_t)S->n, sizeof *S->f);
  S->g = calloc((size_t)(S->d * contacts), sizeof *S->g);
  int bad = !S->f || !S->g;
  bad |= dlsi_triplets_alloc(S->n, S->n, each * (size_t)nodes + 2 * (size_t)S->n, &M.K, NULL) != 0;
  bad |= dlsi_triplets_alloc(S->n, contacts, 9 * (size_t)contacts, &M.N, NULL) != 0;
  bad |= dlsi_triplets_alloc(S->n, 2 * contacts, 18 * (size_t)contacts, &M.T, NULL) != 0;
  bad = bad || scene_fill(&M, &g, &low);
  dlsi_triplets_free(&M.K);
  dlsi_triplets_free(&M.N);
  dlsi_triplets_free(&M.T);
  if (bad)
    scene_free(S);
  else
    columns_add_up(&S->K);
  if (!bad) S->model.Ks = dlsi_columns_view(&S->K);
  return bad ? -1 : 0;
}

void scene_free(scene *S) {
  dlsi_columns_free(&S->K);
  dlsi_columns_free(&S->N);
  dlsi_columns_free(&S->T);
  free(S->f);
  free(S->g);
  S->f = S->g = NULL;
}
