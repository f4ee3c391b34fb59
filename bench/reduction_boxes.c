/* reduction_boxes.c: K and H of elastic boxes, entry by entry. */
#include "reduction_boxes.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "solids.h"

typedef struct grid {
  int d, back;  /* 1: clamped on the face above, 0: on x = 0 */
  int nodes[3]; /* of a side */
} grid;

/* Returns the number of the first unknown of the node at c, -1 if the node is clamped. */
static int box_unknown(const grid *g, const int *c) {
  if (g->back) {
    if (c[g->d - 1] == g->nodes[g->d - 1] - 1) return -1;
    return g->d * (c[0] + g->nodes[0] * (c[1] + g->nodes[1] * c[2]));
  }
  if (c[0] == 0) return -1;
  return g->d * (c[0] - 1 + (g->nodes[0] - 1) * (c[1] + g->nodes[1] * c[2]));
}

/* Sums an entry of K over the elements that have both nodes. `to`, i: its row; `from`, j: its
 * column. */
static double box_stiffness(const grid *g, const double *Ke, const int *to, int i, const int *from,
                            int j) {
  const int size = g->d << g->d;
  double sum = 0;
  for (int b = 0; b < 1 << g->d; b++) { /* `from` is node b of the element */
    int a = 0, inside = 1;
    for (int k = 0; k < g->d; k++) {
      const int corner = from[k] - (b >> k & 1), local = to[k] - corner;
      inside = inside && corner >= 0 && corner < g->nodes[k] - 1 && (local == 0 || local == 1);
      a |= local << k;
    }
    if (inside) sum += Ke[g->d * a + i + size * (g->d * b + j)];
  }
  return sum;
}

/* Writes the columns of the node at c from b->p on; only counts their entries while b->i is NULL.
 */
static void box_columns(box *b, const grid *g, const double *Ke, const int *c, double skew) {
  const int d = g->d, first = box_unknown(g, c), low = d == 3 ? -1 : 0;
  for (int j = 0; j < d; j++) {
    int at = b->p[first + j];
    int s[3];
    for (s[2] = low; s[2] <= -low; s[2]++)
      for (s[1] = -1; s[1] <= 1; s[1]++)
        for (s[0] = -1; s[0] <= 1; s[0]++) {
          const int to[3] = {c[0] + s[0], c[1] + s[1], c[2] + s[2]};
          if (to[0] < 0 || to[1] < 0 || to[2] < 0 || to[0] >= g->nodes[0] || to[1] >= g->nodes[1] ||
              to[2] >= g->nodes[2] || box_unknown(g, to) < 0)
            continue;
          for (int i = 0; i < d; i++) {
            const int row = box_unknown(g, to) + i, column = first + j;
            if (skew == 0 && row < column) continue;
            if (b->i) {
              b->i[at] = row;
              b->x[at] = box_stiffness(g, Ke, to, i, c, j);
              if (row != column) b->x[at] *= 1 + (row > column ? skew : -skew);
            }
            at++;
          }
        }
    b->p[first + j + 1] = at;
  }
}

static void box_matrix(box *b, const grid *g, const double *Ke, double skew) {
  int c[3];
  b->p[0] = 0;
  for (c[2] = 0; c[2] < g->nodes[2]; c[2]++)
    for (c[1] = 0; c[1] < g->nodes[1]; c[1]++)
      for (c[0] = 0; c[0] < g->nodes[0]; c[0]++)
        if (box_unknown(g, c) >= 0) box_columns(b, g, Ke, c, skew);
}

/* Picks normal and tangents of each node of the face below (y = 0 or z = 0). */
static int box_operators(box *b, const grid *g, int n) {
  const int d = g->d, first_x = !g->back, along = g->nodes[0] - first_x;
  const int nodes = along * (d == 3 ? g->nodes[1] : 1);
  b->hp = malloc((size_t)(d * nodes + 1) * sizeof *b->hp);
  b->hn = malloc((size_t)nodes * sizeof *b->hn);
  b->ht = malloc((size_t)(2 * nodes) * sizeof *b->ht);
  b->one = malloc((size_t)(d * nodes) * sizeof *b->one);
  if (!b->hp || !b->hn || !b->ht || !b->one) return -1;
  for (int k = 0; k <= d * nodes; k++)
    b->hp[k] = k;
  for (int k = 0; k < d * nodes; k++)
    b->one[k] = 1;
  for (int k = 0; k < nodes; k++) {
    const int c[3] = {first_x + k % along, d == 3 ? k / along : 0, 0}, first = box_unknown(g, c);
    b->hn[k] = first + d - 1;
    for (int t = 0; t < d - 1; t++)
      b->ht[(d - 1) * k + t] = first + t;
  }
  b->model.nodes = nodes;
  b->model.HN = (dls_sparse){n, nodes, b->hp, b->hn, b->one};
  b->model.HT = (dls_sparse){n, (d - 1) * nodes, b->hp, b->ht, b->one};
  return 0;
}

static int box_fill(box *b, const grid *g, double nu, double skew) {
  const int d = g->d, fixed = g->back ? d - 1 : 0;
  const int n =
      d * (g->nodes[0] * g->nodes[1] * g->nodes[2] / g->nodes[fixed]) * (g->nodes[fixed] - 1);
  double x[24], Ke[24 * 24];
  for (int k = 0; k < d << d; k++)
    x[k] = k / d >> k % d & 1;
  solids_stiffness(d, x, 1, nu, Ke);
  memset(b, 0, sizeof *b);
  b->model.d = d;
  b->model.n = n;
  b->model.operator_kind = DLS_STIFFNESS_SPARSE;
  b->model.factorization = skew == 0 ? DLS_CHOLESKY : DLS_LU;
  b->p = malloc(((size_t)n + 1) * sizeof *b->p);
  if (!b->p) return -1;
  box_matrix(b, g, Ke, skew);
  const size_t entries = (size_t)b->p[n];
  b->i = malloc(entries * sizeof *b->i);
  b->x = malloc(entries * sizeof *b->x);
  if (!b->i || !b->x || box_operators(b, g, n)) {
    box_free(b);
    return -1;
  }
  box_matrix(b, g, Ke, skew);
  b->model.Ks = (dls_sparse){n, n, b->p, b->i, b->x};
  return 0;
}

int box_create(box *b, int d, int cells, double skew) {
  const grid g = {d, 0, {cells + 1, cells + 1, d == 3 ? cells + 1 : 1}};
  return box_fill(b, &g, 0.3, skew);
}

int box_create_glued(box *b, int d, int cells, int height) {
  const grid g = {d, 1, {cells + 1, d == 3 ? cells + 1 : height + 1, d == 3 ? height + 1 : 1}};
  return box_fill(b, &g, 0.3, 0);
}

int box_create_cube(box *b, int n, double nu) {
  const grid g = {3, 1, {n + 1, n + 1, n + 1}};
  if (box_fill(b, &g, nu, 0)) return -1;
  for (int k = 0; k < b->p[b->model.n]; k++)
    b->x[k] /= n; /* the stiffness of a cube grows with its side */
  return 0;
}

double box_residual(const dls_model *model, const double *x, const double *b) {
  const dls_sparse *K = &model->Ks;
  const int n = model->n, lower = model->factorization == DLS_CHOLESKY;
  double *y = calloc(2 * (size_t)n, sizeof *y), *a = y + n, most[3] = {0}; /* y, a, x */
  if (!y) return NAN;
  for (int j = 0; j < n; j++)
    for (int k = K->p[j]; k < K->p[j + 1]; k++) {
      const int i = K->i[k];
      y[i] += K->x[k] * x[j];
      a[i] += fabs(K->x[k]);
      if (!lower || i == j) continue;
      y[j] += K->x[k] * x[i];
      a[j] += fabs(K->x[k]);
    }
  for (int i = 0; i < n; i++) {
    const double of[3] = {fabs(y[i] - b[i]), a[i], fabs(x[i])};
    for (int k = 0; k < 3; k++)
      if (!(of[k] <= most[k])) most[k] = of[k];
  }
  free(y);
  return most[0] / (most[1] * most[2]);
}

void box_free(box *b) {
  free(b->p);
  free(b->i);
  free(b->x);
  free(b->hp);
  free(b->hn);
  free(b->ht);
  free(b->one);
  memset(b, 0, sizeof *b);
}
