/*
 * regret_nets.c: nets of springs, W dense: cloths on a ball, ropes around a bollard, bolted plates.
 *
 *   K = sum of springs + what holds the nodes = L L^T,   W = Y^T Y,   q = Y^T y + gaps
 *   Y = L^-1 H,   y = L^-1 f
 */
#include <math.h>
#include <stdlib.h>

#include "common.h"
#include "regret_kinds.h"

static const double pi = 3.14159265358979;

/* x: 3 a node; K: n x n, n = 3 nodes; f, then the columns of H: n each. */
typedef struct net {
  regret_problem *a;
  int nodes, n, contacts;
  double *x, *K, *f, mu;
  uint64_t state;
} net;

static int net_open(net *t, int nodes, int most_contacts) {
  const size_t n = 3 * (size_t)nodes, m = 3 * (size_t)most_contacts;
  t->nodes = nodes;
  t->n = (int)n;
  t->x = calloc(n, sizeof *t->x);
  t->K = calloc(n * n, sizeof *t->K);
  t->f = calloc(n * (m + 1), sizeof *t->f);
  return regret_room(t->a, 3, most_contacts) || !t->x || !t->K || !t->f ? -1 : 0;
}

/* Ties nodes a and b, with a little stiffness across. */
static void net_tie(net *t, int a, int b, double stiffness) {
  double e[3], l2 = 0;
  for (int i = 0; i < 3; i++) {
    e[i] = t->x[3 * a + i] - t->x[3 * b + i];
    l2 += e[i] * e[i];
  }
  for (int i = 0; i < 3; i++)
    for (int j = 0; j < 3; j++) {
      const double k = stiffness * (e[i] * e[j] / l2 + (i == j) * 1e-3);
      t->K[3 * a + i + t->n * (3 * a + j)] += k;
      t->K[3 * b + i + t->n * (3 * b + j)] += k;
      t->K[3 * a + i + t->n * (3 * b + j)] -= k;
      t->K[3 * b + i + t->n * (3 * a + j)] -= k;
    }
}

/* Ties all nodes from `first` to end - 1 that are at most `reach` apart. */
static void net_tie_near(net *t, int first, int end, double reach, double stiffness) {
  for (int a = first; a < end; a++)
    for (int b = a + 1; b < end; b++) {
      const double *x = t->x + 3 * a, *y = t->x + 3 * b;
      if (hypot(hypot(x[0] - y[0], x[1] - y[1]), x[2] - y[2]) < reach) net_tie(t, a, b, stiffness);
    }
}

static void net_hold(net *t, int a, double stiffness) {
  for (int i = 0; i < 3; i++)
    t->K[(size_t)(3 * a + i) * (size_t)(t->n + 1)] += stiffness;
}

/* Adds a contact of node a on node b (-1: fixed). normal: to a, not along x[1] alone. */
static void net_touch(net *t, int a, int b, const double *normal, double gap) {
  const int c = t->contacts++;
  const double side = hypot(normal[0], normal[2]);
  const double F[3][3] = {{normal[0], normal[1], normal[2]},
                          {normal[2] / side, 0, -normal[0] / side},
                          {normal[0] * normal[1] / side, -side, normal[1] * normal[2] / side}};
  for (int j = 0; j < 3; j++)
    for (int i = 0; i < 3; i++) {
      double *column = t->f + (size_t)t->n * (size_t)(3 * c + j + 1);
      column[3 * a + i] = F[j][i];
      if (b >= 0) column[3 * b + i] = -F[j][i];
    }
  t->a->own.q[3 * c] = gap;
  t->a->own.mu[c] = t->mu;
}

/* Forms W and q. */
static void net_close(net *t) {
  const int n = t->n, m = 3 * t->contacts;
  for (int j = 0; j < n; j++) { /* L below the diagonal of K */
    double *Kj = t->K + (size_t)n * (size_t)j;
    for (int k = 0; k < j; k++) {
      const double *Kk = t->K + (size_t)n * (size_t)k;
      for (int i = j; Kk[j] != 0 && i < n; i++)
        Kj[i] -= Kk[j] * Kk[i];
    }
    for (int i = n - 1; i >= j; i--)
      Kj[i] /= sqrt(Kj[j]);
  }
  for (int c = 0; c <= m; c++) {
    double *y = t->f + (size_t)n * (size_t)c;
    for (int j = 0; j < n; j++) {
      const double *Kj = t->K + (size_t)n * (size_t)j;
      y[j] /= Kj[j];
      for (int i = j + 1; y[j] != 0 && i < n; i++)
        y[i] -= Kj[i] * y[j];
    }
  }
  t->a->contact.nc = t->contacts;
  t->a->contact.W = (dls_dense){m, m, m, t->a->W};
  regret_multiply(t->a, n, m, t->f + n, t->f);
}

/* A square cloth of side x side nodes sinks on a ball of radius 1, and is pulled along. */
static int put_cloth(net *t, int side, double stiffness) {
  const double h = 2. / side;
  if (net_open(t, side * side, side * side)) return -1;
  for (int a = 0; a < t->nodes; a++) {
    double *x = t->x + 3 * a;
    x[0] = h * (a % side - (side - 1) / 2.);
    x[1] = h * (a / side - (side - 1) / 2.);
    const double r = hypot(x[0], x[1]);
    x[2] = (r < 0.9 ? sqrt(1 - r * r) : 0.436 - 2 * (r - 0.9)) + 0.005 * h * bench_draw(&t->state);
    net_hold(t, a, 1);
    t->f[3 * a] = 0.03;
    t->f[3 * a + 2] = -0.1;
  }
  for (int a = 0; a < t->nodes; a++) {
    const int right = a % side + 1 < side, up = a + side < t->nodes;
    if (right) net_tie(t, a, a + 1, stiffness);
    if (up) net_tie(t, a, a + side, stiffness);
    if (right && up) net_tie(t, a, a + side + 1, 0.3 * stiffness);
    if (right && up) net_tie(t, a + 1, a + side, 0.3 * stiffness);
  }
  for (int a = 0; a < t->nodes; a++) {
    const double *x = t->x + 3 * a, r = hypot(hypot(x[0], x[1]), x[2]);
    const double normal[3] = {x[0] / r, x[1] / r, x[2] / r};
    if (hypot(x[0], x[1]) < 0.9)
      net_touch(t, a, -1, normal, 0.2 * (r - 1) + 0.01 * h * (1 + bench_draw(&t->state)));
  }
  return 0;
}

/* A rope over half a bollard, one end pulled twice as much as the other. */
static int put_rope(net *t, int nodes) {
  if (net_open(t, nodes, nodes)) return -1;
  for (int a = 0; a < nodes; a++) {
    const double angle = pi * (1.4 * a / (nodes - 1) - 0.2);
    t->x[3 * a] = -cos(angle);
    t->x[3 * a + 2] = sin(angle);
    net_hold(t, a, 1);
    t->f[3 * a + 2] = -0.1 - (a == 0 ? 3 : a == nodes - 1 ? 6 : 0);
    if (a) net_tie(t, a, a - 1, 1e4);
  }
  for (int a = 0; a < nodes; a++)
    if (t->x[3 * a + 2] > 0) net_touch(t, a, -1, t->x + 3 * a, 5e-4 * (1 + bench_draw(&t->state)));
  return 0;
}

/* Two plates of side x side x 2 nodes, pressed together by four bolts, the upper one pulled. */
static int put_plates(net *t, int side) {
  const int layer = side * side;
  if (net_open(t, 4 * layer, layer)) return -1;
  for (int a = 0; a < t->nodes; a++) {
    t->x[3 * a] = a % side;
    t->x[3 * a + 1] = a % layer / side;
    t->x[3 * a + 2] = a / layer;
    net_hold(t, a, a < layer ? 2 : 1e-3);
  }
  net_tie_near(t, 0, 2 * layer, 1.5, 1);
  net_tie_near(t, 2 * layer, 4 * layer, 1.5, 1);
  for (int bolt = 0; bolt < 4; bolt++) {
    const int a =
        side * (bolt & 1 ? 3 * side / 4 : side / 4) + (bolt & 2 ? 3 * side / 4 : side / 4);
    t->f[3 * a + 2] += 1;
    t->f[3 * (3 * layer + a) + 2] -= 1;
  }
  for (int row = 0; row < side; row++)
    t->f[3 * (3 * layer + row * side + side - 1)] += 1.6 * t->mu / side;
  for (int c = 0; c < layer; c++) {
    static const double up[3] = {0, 0, 1};
    net_touch(t, 2 * layer + c, layer + c, up, 0.01 * (1 + bench_draw(&t->state)));
  }
  return 0;
}

int regret_nets(regret_problem *a, const char *kind, int size, double mu, uint64_t seed) {
  net t = {.a = a, .mu = mu, .state = regret_state(seed, 7)};
  const int bad = kind[0] == 'r'   ? put_rope(&t, 4 * size / 3 + 2)
                  : kind[0] == 'p' ? put_plates(&t, (int)sqrt(size) + 1)
                                   : put_cloth(&t, (int)sqrt(size / 0.63) + 1, kind[5] ? 2e4 : 200);
  if (!bad) net_close(&t);
  free(t.x);
  free(t.K);
  free(t.f);
  return bad;
}
