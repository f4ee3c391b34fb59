/* scenes.c: free random bodies with known statics. */
#include "scenes.h"

#include <math.h>
#include <string.h>

enum { bodies_most = 5, contacts_most = 8, nodes_most = 27 };

typedef struct random {
  uint64_t state;
} random;

/* Returns a number between a and b. */
static double scene_number(random *g, double a, double b) {
  g->state = g->state * 6364136223846793005u + 1442695040888963407u;
  uint64_t x = g->state;
  x ^= x >> 33;
  x *= 0xff51afd7ed558ccdu;
  x ^= x >> 33;
  return a + (b - a) * (double)(x >> 11) / 9007199254740992.;
}

static int draw_below(random *g, int most) {
  return (int)scene_number(g, 0, most);
}

/* e := a unit vector at random. */
static void draw_unit(random *g, int d, double *e) {
  double size = 0;
  while (!(size > 0.1 && size <= 1)) {
    size = 0;
    for (int i = 0; i < d; i++) {
      e[i] = scene_number(g, -1, 1);
      size = hypot(size, e[i]);
    }
  }
  for (int i = 0; i < d; i++)
    e[i] /= size;
}

typedef struct block {
  int count[3], first, nodes;
  double shift[3], turn[3]; /* rigid motion */
} block;

/* b := the motion of a node of the block. */
static void motion_at(const block *of, int d, int node, double *b) {
  const int k = node - of->first, w = of->count[0] + 1, h = of->count[1] + 1;
  const double x[3] = {k % w, k / w % h, d == 3 ? k / w / h : 0};
  for (int i = 0; i < d; i++) {
    const int j = (i + 1) % 3, l = (i + 2) % 3;
    b[i] = of->shift[i] + of->turn[j] * x[l] - of->turn[l] * x[j];
  }
}

static void draw_block(random *g, int d, block *of) {
  of->nodes = 1;
  for (int i = 0; i < 3; i++) {
    of->count[i] = i < d ? 1 + draw_below(g, 2) : 1;
    if (i < d) of->nodes *= of->count[i] + 1;
    of->shift[i] = of->turn[i] = 0;
  }
  if (draw_below(g, 3) == 0) return; /* stands still */
  draw_unit(g, d, of->shift);
  for (int i = d == 3 ? 0 : 2; i < 3; i++)
    of->turn[i] = scene_number(g, -0.5, 0.5);
}

/* Sets n such that h_n >= mu |h_t| for the motion h; at random where h = 0. */
static void normal_for(random *g, int d, double mu, const double *h, double *n) {
  double size = 0, t[3] = {0}, along = 0, turn = 0;
  for (int i = 0; i < d; i++)
    size = hypot(size, h[i]);
  draw_unit(g, d, n);
  if (size == 0) return;
  for (int i = 0; i < d; i++)
    along += n[i] * h[i] / size;
  for (int i = 0; i < d; i++) {
    t[i] = n[i] - along * h[i] / size;
    turn = hypot(turn, t[i]);
  }
  const double angle = scene_number(g, 0, 0.95) * atan(1 / mu); /* between n and h */
  for (int i = 0; i < d; i++)
    n[i] = cos(angle) * h[i] / size + (turn > 0 ? sin(angle) * t[i] / turn : 0);
}

/* f -= H r for r inside of the cones. */
static void load_by_reactions(random *g, solids *S, double mu) {
  const int d = S->d;
  for (int c = 0; c < S->contacts; c++) {
    double e[3], r[3];
    r[0] = pow(10, scene_number(g, -4, 0));
    draw_unit(g, d, e);
    const double part = scene_number(g, 0, 0.97) * mu * r[0];
    double size = 0;
    for (int i = 1; i < d; i++)
      size = hypot(size, e[i]);
    for (int i = 1; i < d; i++)
      r[i] = size > 0 ? part * e[i] / size : 0;
    for (int i = 0; i < d; i++) {
      const dls_sparse *L = i ? &S->model.HT : &S->model.HN;
      const int column = i ? (d - 1) * c + i - 1 : c;
      for (int k = L->p[column]; k < L->p[column + 1]; k++)
        S->f[L->i[k]] -= L->x[k] * r[i];
    }
  }
}

/* f at random with b^T f of at least a twentieth of |b||f|. */
static void load_by_motion(random *g, solids *S, const double *b) {
  double work = 0, size_b = 0, size_f = 0;
  for (int j = 0; j < S->model.n; j++) {
    S->f[j] = scene_number(g, -1, 1);
    work += b[j] * S->f[j];
    size_b = hypot(size_b, b[j]);
    size_f = hypot(size_f, S->f[j]);
  }
  const double wanted = scene_number(g, 0.05, 0.5) * size_b * size_f;
  for (int j = 0; j < S->model.n; j++)
    S->f[j] += (wanted - work) / (size_b * size_b) * b[j];
}

void scene_generate(uint64_t seed, int d, scene_kind kind, solids *S, double *mu) {
  random g = {seed * 2654435761u + (uint64_t)d};
  block of[bodies_most];
  double b[3 * nodes_most * bodies_most];
  const int bodies = 1 + draw_below(&g, bodies_most);
  int nodes = 0, moves = 0;
  *mu = pow(10, scene_number(&g, -1.3, 0.3));
  for (int k = 0; k < bodies; k++) {
    draw_block(&g, d, &of[k]);
    nodes += of[k].nodes;
    for (int i = 0; i < 3; i++)
      moves |= of[k].shift[i] != 0;
  }
  if (!moves) of[0].shift[0] = 1;
  solids_new(S, d, nodes, bodies * contacts_most);
  for (int k = 0; k < bodies; k++) {
    of[k].first = solids_block(S, of[k].count, pow(10, scene_number(&g, -2, 2)));
    for (int i = of[k].first; i < of[k].first + of[k].nodes; i++)
      motion_at(&of[k], d, i, b + d * i);
  }
  for (int k = 0; k < bodies; k++)
    for (int c = 2 + draw_below(&g, contacts_most - 1); c > 0; c--) {
      const int node = of[k].first + draw_below(&g, of[k].nodes);
      const int under = k ? draw_below(&g, k + 1) - 1 : -1; /* -1: the ground */
      const int other = under < 0 ? -1 : of[under].first + draw_below(&g, of[under].nodes);
      double normal[3] = {0}, h[3];
      for (int i = 0; i < d; i++)
        h[i] = b[d * node + i] - (other < 0 ? 0 : b[d * other + i]);
      if (kind == SCENE_FALLS)
        normal_for(&g, d, *mu, h, normal);
      else
        draw_unit(&g, d, normal);
      solids_contact(S, node, other, normal, 0);
    }
  (void)solids_model(S);
  if (kind == SCENE_FALLS)
    load_by_motion(&g, S, b);
  else
    load_by_reactions(&g, S, *mu);
}
