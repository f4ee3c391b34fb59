/*
 * papers_grid.c: elasticity of boxes by tensor products. With N_I the product of the shape
 * functions N_i of each direction,
 *
 *   K_(Ia)(Jb) = l T_ab + G (T_ba + d_ab sum_c T_cc),   T_ab = int dN_I/dx_a dN_J/dx_b
 *
 * T_ab is a product over the directions of M = int N_i N_j, S = int N_i' N_j', C = int N_i' N_j or
 * its transpose. Supports as for the block of [Jean 1988]: u_x = 0, in 3D u_y = 0, on the face x =
 * L, where the bottom is held in the vertical, too, and has no candidates.
 */
#include "papers_grid.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>

#include "common.h"

static const double side = 4, young = 260, poisson = 0.2;
static const double pressure = 1, traction[2] = {1.8, 5}; /* at the bottom, on top */

typedef struct shape {
  double M[3][3], S[3][3], C[3][3];
} shape;

/* The integrals of one direction, element of length h. */
static shape shape_of(int order, double h) {
  static const double M1[3][3] = {{2, 1}, {1, 2}}, S1[3][3] = {{1, -1}, {-1, 1}};
  static const double C1[3][3] = {{-1, -1}, {1, 1}};
  static const double M2[3][3] = {{4, 2, -1}, {2, 16, 2}, {-1, 2, 4}};
  static const double S2[3][3] = {{7, -8, 1}, {-8, 16, -8}, {1, -8, 7}};
  static const double C2[3][3] = {{-3, -4, 1}, {4, 0, -4}, {-1, 4, 3}};
  shape s;
  for (int i = 0; i < 3; i++)
    for (int j = 0; j < 3; j++) {
      s.M[i][j] = h * (order == 1 ? M1[i][j] / 6 : M2[i][j] / 30);
      s.S[i][j] = (order == 1 ? S1[i][j] : S2[i][j] / 3) / h;
      s.C[i][j] = order == 1 ? C1[i][j] / 2 : C2[i][j] / 6;
    }
  return s;
}

/* Splits k into d digits, digit a below size[a]. */
static void split(int k, int d, const int *size, int *digit) {
  for (int a = 0; a < d; a++) {
    digit[a] = k % size[a];
    k /= size[a];
  }
}

double grid_coordinate(const grid *g, int node, int k) {
  int at[3] = {0};
  split(node, g->d, g->nodes, at);
  return side * at[k] / (g->nodes[k] - 1);
}

static int product(int d, const int *size) {
  int n = 1;
  for (int a = 0; a < d; a++)
    n *= size[a];
  return n;
}

/* Returns the node of local number k of the element with these first nodes. */
static int grid_node(const grid *g, const int *first, const int *local) {
  int node = 0;
  for (int a = g->d - 1; a >= 0; a--)
    node = node * g->nodes[a] + first[a] + local[a];
  return node;
}

static int grid_number(grid *g) {
  const int all = product(g->d, g->nodes);
  g->unknown = malloc((size_t)g->d * (size_t)all * sizeof *g->unknown);
  if (!g->unknown) return -1;
  g->line = product(g->d - 1, g->nodes);
  for (int node = 0; node < all; node++)
    for (int a = 0; a < g->d; a++) {
      const int held = node % g->nodes[0] == g->nodes[0] - 1;
      const int supported = held && (a < g->d - 1 || node < g->line);
      g->unknown[g->d * node + a] = supported ? -1 : g->unknowns++;
    }
  return 0;
}

/* Fills k ((d c) x (d c)), the stiffness of an element with c nodes. */
static void element_stiffness(const grid *g, int c, const shape *s, double *k) {
  const double G = young / (2 * (1 + poisson));
  const double l = young * poisson / ((1 + poisson) * (1 - 2 * poisson));
  const int d = g->d, local[3] = {g->order + 1, g->order + 1, g->order + 1};
  for (int I = 0; I < c; I++)
    for (int J = 0; J < c; J++) {
      int i[3], j[3];
      double T[3][3];
      split(I, d, local, i);
      split(J, d, local, j);
      for (int a = 0; a < d; a++)
        for (int b = 0; b < d; b++) {
          T[a][b] = 1;
          for (int e = 0; e < d; e++)
            T[a][b] *= e == a && e == b ? s[e].S[i[e]][j[e]]
                       : e == a         ? s[e].C[i[e]][j[e]]
                       : e == b         ? s[e].C[j[e]][i[e]]
                                        : s[e].M[i[e]][j[e]];
        }
      for (int a = 0; a < d; a++)
        for (int b = 0; b < d; b++) {
          double sum = l * T[a][b] + G * T[b][a];
          for (int e = 0; e < d && a == b; e++)
            sum += G * T[e][e];
          k[(d * I + a) + d * c * (d * J + b)] = sum;
        }
    }
}

/* Forms K, entries of a place repeated. */
static int grid_stiffness(grid *g, const shape *s) {
  const int d = g->d, local[3] = {g->order + 1, g->order + 1, g->order + 1};
  const int c = product(d, local), elements = product(d, g->cells), m = d * c, n = g->unknowns;
  double *k = calloc((size_t)(m * m), sizeof *k);
  int *row = calloc((size_t)m, sizeof *row);
  dlsi_triplets K = {0};
  int bad = !k || !row || dlsi_triplets_alloc(n, n, (size_t)elements * (size_t)(m * m), &K, NULL);
  if (!bad) element_stiffness(g, c, s, k);
  for (int e = 0; e < elements && !bad; e++) {
    int first[3], i[3];
    split(e, d, g->cells, first);
    for (int a = 0; a < d; a++)
      first[a] *= g->order;
    for (int I = 0; I < m; I++) {
      split(I / d, d, local, i);
      row[I] = g->unknown[d * grid_node(g, first, i) + I % d];
    }
    for (int b = 0; b < m; b++)
      for (int a = 0; a < m; a++)
        if (row[a] >= 0 && row[b] >= 0) dlsi_triplets_add(&K, row[a], row[b], k[a + m * b]);
  }
  bad = bad || dlsi_columns_compress(&K, 1, DLSI_ALL, &g->K, NULL);
  dlsi_triplets_free(&K);
  free(k);
  free(row);
  return bad ? -1 : 0;
}

/* Returns the integral of the shape function of place k along a side, times a linear function that
 * is `low` at 0 and `high` at the end. */
static double side_integral(const grid *g, const shape *s, int a, int k, double low, double high) {
  double sum = 0;
  for (int e = 0; e < g->cells[a]; e++)
    for (int j = 0; j <= g->order; j++) {
      const int i = k - e * g->order, at = e * g->order + j;
      if (i < 0 || i > g->order) continue;
      sum += s[a].M[i][j] * (low + (high - low) * at / (g->nodes[a] - 1));
    }
  return sum;
}

static int grid_loads(grid *g, const shape *s) {
  const int all = product(g->d, g->nodes), up = g->d - 1;
  g->f = calloc((size_t)g->unknowns, sizeof *g->f);
  if (!g->f) return -1;
  for (int node = 0; node < all; node++) {
    int at[3] = {0};
    split(node, g->d, g->nodes, at);
    const double deep = g->d == 3 ? side_integral(g, s, 1, at[1], 1, 1) : 1;
    const int x = g->unknown[g->d * node], y = g->unknown[g->d * node + up];
    if (at[up] == g->nodes[up] - 1 && y >= 0)
      g->f[y] -= pressure * deep * side_integral(g, s, 0, at[0], 1, 1);
    if (at[0] == 0 && x >= 0)
      g->f[x] += deep * side_integral(g, s, up, at[up], traction[0], traction[1]);
  }
  return 0;
}

/* Fills candidates, cells and P: that of the faces, or a selection. The last node of each row along
 * x is held. */
static int grid_weighting(grid *g, const shape *s, int weighted, double mu) {
  const int nx = g->nodes[0], ny = g->d == 3 ? g->nodes[1] : 1;
  const size_t count = (size_t)(nx - 1) * (size_t)ny, nodes = (size_t)g->line;
  double *at = calloc((size_t)(nx + ny), sizeof *at);
  int *candidate = calloc((size_t)nx, sizeof *candidate);
  g->area = calloc(nodes, sizeof *g->area);
  g->mu = calloc(count, sizeof *g->mu);
  g->node = calloc(count, sizeof *g->node);
  int bad = !at || !candidate || !g->area || !g->mu || !g->node ||
            dlsi_columns_alloc(g->line, g->line, 16 * g->line, &g->P, NULL);
  if (!bad) g->P.p[0] = 0;
  for (int k = 0; k < nx && !bad; k++) {
    at[k] = side * k / (nx - 1);
    candidate[k] = k < nx - 1;
  }
  for (int k = 1; k < ny && !bad; k++)
    at[nx + k] = side * k / (ny - 1);
  for (size_t c = 0; c < count && !bad; c++) {
    const int cx = (int)c % (nx - 1), cy = (int)c / (nx - 1);
    g->node[c] = g->P.i[c] = cx + nx * cy;
    g->mu[c] = mu;
    g->area[c] = side_integral(g, s, 0, cx, 1, 1) * (ny > 1 ? side_integral(g, s, 1, cy, 1, 1) : 1);
    g->P.x[c] = 1;
    g->P.p[c + 1] = (int)c + 1;
  }
  int columns;
  if (weighted && !bad)
    bad = dls_weighting_face(g->order, nx, at, candidate, ny, at + nx, NULL, g->P.p, g->P.i, g->P.x,
                             g->area, &columns, NULL) != DLS_OK;
  for (int e = 0; !bad && e < g->P.p[count]; e++)
    g->least = fmin(g->least, g->P.x[e]);
  g->candidates = g->P.cols = (int)count;
  free(at);
  free(candidate);
  return bad ? -1 : 0;
}

/* Fills H_N, H_T: contact node k is node k of the grid. Held unknowns have empty columns. */
static int grid_operators(grid *g) {
  const int line = g->line, d = g->d, n = g->unknowns;
  dlsi_triplets N = {0}, T = {0};
  int bad = dlsi_triplets_alloc(n, line, (size_t)line, &N, NULL) ||
            dlsi_triplets_alloc(n, (d - 1) * line, (size_t)((d - 1) * line), &T, NULL);
  for (int k = 0; k < d * line && !bad; k++) {
    const int node = k / d, a = k % d, row = g->unknown[k];
    if (row >= 0 && a == d - 1) dlsi_triplets_add(&N, row, node, 1);
    if (row >= 0 && a < d - 1) dlsi_triplets_add(&T, row, (d - 1) * node + a, 1);
  }
  bad = bad || dlsi_columns_compress(&N, 1, DLSI_ALL, &g->HN, NULL) ||
        dlsi_columns_compress(&T, 1, DLSI_ALL, &g->HT, NULL);
  dlsi_triplets_free(&N);
  dlsi_triplets_free(&T);
  return bad ? -1 : 0;
}

int grid_create(grid *g, int d, int order, int cells, int weighted, double mu) {
  *g = (grid){.d = d, .order = order, .least = INFINITY};
  shape s[3];
  for (int a = 0; a < d; a++) {
    g->cells[a] = a == d - 1 ? cells / 2 : cells;
    g->nodes[a] = order * g->cells[a] + 1;
    s[a] = shape_of(order, side / g->cells[a]);
  }
  dls_error error = {0};
  dls_status status = DLS_E_MEMORY;
  if (grid_number(g) || grid_stiffness(g, s) || grid_loads(g, s) ||
      grid_weighting(g, s, weighted, mu) || grid_operators(g))
    goto failed;
  g->model = (dls_model){.d = d,
                         .n = g->unknowns,
                         .nodes = g->line,
                         .operator_kind = DLS_STIFFNESS_SPARSE,
                         .factorization = DLS_CHOLESKY,
                         .Ks = dlsi_columns_view(&g->K),
                         .HN = dlsi_columns_view(&g->HN),
                         .HT = dlsi_columns_view(&g->HT),
                         .P = dlsi_columns_view(&g->P)};
  status = bench_reduce(&g->reduction, &g->model, &error);
  if (!status) status = dls_reduction_load(g->reduction, g->f, NULL, &error);
  if (!status) status = dls_reduction_contact(g->reduction, g->mu, &g->contact, &error);
  if (!status) return 0;
failed:
  fprintf(stderr, "grid: %s\n", status == DLS_E_MEMORY ? "no memory" : error.message);
  grid_free(g);
  return -1;
}

void grid_free(grid *g) {
  dls_reduction_destroy(g->reduction);
  free(g->unknown);
  free(g->f);
  free(g->mu);
  free(g->area);
  free(g->node);
  dlsi_columns_free(&g->K);
  dlsi_columns_free(&g->HN);
  dlsi_columns_free(&g->HT);
  dlsi_columns_free(&g->P);
  *g = (grid){0};
}
