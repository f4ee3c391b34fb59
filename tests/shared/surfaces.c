/* surfaces.c: meshes, loads and contacts, as surfaces.h describes them. */
#include "surfaces.h"

#include <math.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

const char *const scene_kind_name[] = {"strip", "sheets", "rim", "plate", "tube"};
const char *const scene_support_name[] = {"soft", "held", "free"};
const char *const scene_load_name[] = {"press", "shear", "lift"};

static const double pi = 3.14159265358979323846;
static const double clamp = 1e3, pad = .05, pressure = 1e-2;

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

static void grid_add(scene *S, const grid *g) {
  for (int k = 0; k < (S->d == 3 ? g->count[2] : 1); k++)
    for (int j = 0; j < g->count[1]; j++)
      for (int i = 0; i < g->count[0]; i++) {
        int node[8];
        double x[24];
        for (int c = 0; c < 1 << S->d; c++) {
          const int at[3] = {i + (c & 1), j + (c >> 1 & 1), k + (c >> 2 & 1)};
          node[c] = grid_node(g, at[0], at[1], at[2]);
          grid_place(S, g, at[0], at[1], at[2], x + S->d * c);
        }
        solids_element(&S->body, node, x, 1);
      }
}

/* ---- supports, loads, contacts --------------------------------------------------------------- */

static void node_spring(scene *S, int node, double stiffness) {
  for (int k = 0; k < S->d; k++)
    solids_spring(&S->body, node, k, stiffness);
}

/* Loads the node at (s, t) of the surface, 0 to 1, by the normal and tangents of its contacts; area
 * that of its elements. */
static void node_load(scene *S, int node, const double *normal, double s, double t, double area) {
  const double *w = S->wave;
  const int d = S->d;
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
    S->body.f[2 * node] += area * (along * normal[1] - down * normal[0]);
    S->body.f[2 * node + 1] += area * (-along * normal[0] - down * normal[1]);
  } else { /* along: z x y; in a plate that is x */
    S->body.f[3 * node] += area * (along * normal[2] - down * normal[0]);
    S->body.f[3 * node + 1] += area * across;
    S->body.f[3 * node + 2] += area * (-along * normal[0] - down * normal[2]);
  }
}

/* Makes the contacts on the row j = 0, or the face k = 0, of a straight grid, and loads the one
 * opposite. */
static void straight(scene *S, const grid *g) {
  const int d = S->d, nx = g->count[0], ny = g->count[1];
  const double up[3] = {0, d == 2, d == 3};
  for (int i = 0; i <= nx; i++)
    for (int j = 0; j <= (d == 3 ? ny : 0); j++) {
      const int below = grid_node(g, i, j, 0);
      const int above = d == 3 ? grid_node(g, i, j, g->count[2]) : grid_node(g, i, ny, 0);
      node_load(S, above, up, (double)i / nx, d == 3 ? (double)j / ny : 0, g->width);
      if (S->support == SOFT) node_spring(S, above, g->width * pad);
      const int clamped = S->kind == STRIP && S->support != FREE ? i == nx
                          : S->support == HELD                   ? i == 0
                                                                 : 0;
      for (int k = 0; clamped && k <= (d == 3 ? g->count[2] : ny); k++)
        node_spring(S, d == 3 ? grid_node(g, i, j, k) : grid_node(g, i, k, 0), clamp);
      if (S->kind != SHEETS && !(S->kind == STRIP && clamped))
        solids_contact(&S->body, below, -1, up, 0);
    }
}

/* The upper sheet is g, the lower one `low`. */
static void sheets(scene *S, const grid *g, const grid *low) {
  const double up[2] = {0, 1};
  straight(S, g);
  for (int i = 0; i <= low->count[0]; i++)
    node_spring(S, grid_node(low, i, 0, 0), clamp);
  for (int i = 0; i <= g->count[0]; i++) {
    const double at = (double)i / g->count[0] * low->count[0];
    int segment = (int)at;
    if (segment == low->count[0]) segment--;
    const int other[2] = {grid_node(low, segment, low->count[1], 0),
                          grid_node(low, segment + 1, low->count[1], 0)};
    solids_contact_on(&S->body, grid_node(g, i, 0, 0), 2, other,
                      (double[]){1 - (at - segment), at - segment}, up, 0);
  }
}

/* Contacts of the nodes outside, loads inside. */
static void round_body(scene *S, const grid *g) {
  const int d = S->d, nx = g->count[0], ny = g->count[1];
  for (int i = 0; i < nx; i++)
    for (int j = 0; j <= (d == 3 ? ny : 0); j++) {
      const double a = round_angle(g, i), c = cos(a), s = sin(a);
      const double in[3] = {-c, d == 2 ? -s : 0, -s}; /* out of the cavity */
      const int outer = d == 3 ? grid_node(g, i, j, 0) : grid_node(g, i, ny, 0);
      const int inner = d == 3 ? grid_node(g, i, j, g->count[2]) : grid_node(g, i, 0, 0);
      node_load(S, inner, in, (double)i / nx, d == 3 ? (double)j / ny : 0, 1);
      if (S->support == SOFT) node_spring(S, inner, pad);
      if (S->support == HELD) node_spring(S, inner, clamp);
      if (d == 2 && tooth(i) < 2) continue;
      solids_contact(&S->body, outer, -1, in, S->support == FREE ? 0 : 1e-3 * (1 + cos(2 * a)));
    }
}

/* ---- the whole ------------------------------------------------------------------------------- */

/* Adds up the entries of each place: hosts hand K over like that. */
static void columns_add_up(dlsi_columns *A) {
  int *at = malloc((size_t)A->rows * sizeof *at), end = 0;
  if (!at) abort();
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

void scene_create(scene *S) {
  const int closed = S->kind == RIM || S->kind == TUBE;
  S->d = S->kind == PLATE || S->kind == TUBE ? 3 : 2;
  if (S->d == 2) S->size[2] = 0;
  const int *s = S->size, along = closed ? s[0] : s[0] + 1, fewer = s[0] * 2 / 3;
  const grid g = {0, {s[0], s[1], s[2]}, closed, along, 1};
  const grid low = {grid_nodes(&g), {fewer, s[1], 0}, 0, fewer + 1, (double)s[0] / fewer};
  uint64_t draw = (uint64_t)S->seed;
  for (int k = 0; k < 6; k++) {
    draw = draw * 6364136223846793005u + 1442695040888963407u;
    const double by = S->seed ? (double)(draw >> 11) * 0x1p-52 - 1 : 0;
    S->wave[k] = k < 3 ? 1 + .2 * by : pi * by;
  }
  solids_new(&S->body, S->d, grid_nodes(&g) + (S->kind == SHEETS ? grid_nodes(&low) : 0),
             along * (S->d == 3 ? s[1] + 1 : 1));
  grid_add(S, &g);
  if (S->kind == SHEETS) {
    grid_add(S, &low);
    sheets(S, &g, &low);
  } else if (closed)
    round_body(S, &g);
  else
    straight(S, &g);
  S->body.nodes = S->body.K.rows / S->d;
  (void)solids_model(&S->body);
  columns_add_up(&S->body.Kc);
  S->body.model.Ks = dlsi_columns_view(&S->body.Kc);
  S->model = S->body.model;
  S->n = S->model.n;
  S->nc = S->model.nodes;
  S->f = S->body.f;
  S->g = S->body.g;
}

void scene_free(scene *S) {
  solids_free(&S->body);
}

/* Gives the body of a scene away. */
static void solids_surface(solids *S, scene_kind kind, scene_support support, int nx, int ny,
                           int nz) {
  scene made = {kind, support, LIFT, .size = {nx, ny, nz}};
  scene_create(&made);
  *S = made.body;
}

void solids_pad(solids *S, int nx, int ny) {
  solids_surface(S, STRIP, SOFT, nx, ny, 1);
}

void solids_plate(solids *S, int nx, int nz) {
  solids_surface(S, PLATE, SOFT, nx, nx, nz);
}

void solids_strip(solids *S, int nx, int ny) {
  solids_surface(S, STRIP, HELD, nx, ny, 1);
}
