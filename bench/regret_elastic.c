/*
 * regret_elastic.c: problems with dense W: matrices with given eigenvalues, a half-space, and
 * finite elements condensed by the library.
 */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "common.h"
#include "half_space.h"
#include "reduction_boxes.h"
#include "regret_kinds.h"
#include "solvers_scenes.h"

static const double pi = 3.14159265358979;

int regret_room(regret_problem *a, int d, int nc) {
  const size_t m = (size_t)d * (size_t)nc;
  a->W = calloc(m * m, sizeof *a->W);
  a->own.q = calloc(m, sizeof *a->own.q);
  a->own.mu = calloc((size_t)nc, sizeof *a->own.mu);
  if (!a->W || !a->own.q || !a->own.mu) return -1;
  a->contact = (dls_contact){
      .d = d, .nc = nc, .W = {(int)m, (int)m, (int)m, a->W}, .q = a->own.q, .mu = a->own.mu};
  return 0;
}

/* ---- W with given eigenvalues, and a planted answer ------------------------------------------ */

/* W := P W P, P = 1 - 2 v v^T / v^T v. w, v: m. */
static void reflect(int m, double *W, const double *v, double *w) {
  const size_t M = (size_t)m;
  double vv = 0, vWv = 0;
  for (size_t i = 0; i < M; i++) {
    w[i] = 0;
    for (size_t j = 0; j < M; j++)
      w[i] += W[j + M * i] * v[j];
    vv += v[i] * v[i];
    vWv += v[i] * w[i];
  }
  for (size_t j = 0; j < M; j++)
    for (size_t i = 0; i < M; i++)
      W[i + M * j] += 4 * vWv * v[i] * v[j] / (vv * vv) - 2 * (v[i] * w[j] + w[i] * v[j]) / vv;
}

/* Fills W (m x m, zeros) with `rank` eigenvalues from 1 to 1 / condition, spaced evenly in their
 * logarithm, and zeros. Returns 0, or -1 without memory. */
static int regret_spectrum(double *W, int m, int rank, double condition, uint64_t *state) {
  enum { reflections = 30 };
  double *v = calloc(2 * (size_t)m, sizeof *v);
  if (!v) return -1;
  for (int i = 0; i < rank; i++)
    W[(size_t)i * (size_t)(m + 1)] = pow(condition, -(1 + bench_draw(state)) / 2);
  W[0] = 1;
  W[(size_t)(rank - 1) * (size_t)(m + 1)] = 1 / condition;
  for (int k = 0; k < reflections && k < m; k++) {
    for (int i = 0; i < m; i++)
      v[i] = bench_draw(state);
    reflect(m, W, v, v + m);
  }
  free(v);
  return 0;
}

/* Draws r and u (d each) of one contact that obey the laws: free, stick or slip, one in three each.
 */
static void regret_plant(int d, double mu, uint64_t *state, double *r, double *u) {
  const double kind = bench_draw(state), angle = pi * bench_draw(state);
  const double t[2] = {d == 3 ? cos(angle) : angle < 0 ? -1 : 1, sin(angle)};
  for (int i = 0; i < d; i++)
    r[i] = u[i] = 0;
  if (kind < -1. / 3) {
    for (int i = 0; i < d; i++)
      u[i] = bench_draw(state);
    u[0] = fabs(u[0]);
    return;
  }
  r[0] = 1 + 0.9 * bench_draw(state);
  const double most = isinf(mu) ? 2 : mu, part = (1 + bench_draw(state)) / 2;
  const int slips = kind > 1. / 3 && !isinf(mu);
  for (int i = 1; i < d; i++) {
    r[i] = (slips ? -1 : 0.9 * part) * most * r[0] * t[i - 1];
    if (slips) u[i] = part * t[i - 1];
  }
}

/* Moves the drawn answer of contact c to the border of two states. */
static void put_on_border(int c, double mu, double *r, double *u) {
  const double size = hypot(r[1], r[2]);
  for (int i = 0; i < 3; i++)
    u[i] = 0;
  if (c % 3 == 0) r[0] = r[1] = r[2] = 0;
  if (c % 3 == 1 && size > 0) {
    r[1] *= mu * r[0] / size;
    r[2] *= mu * r[0] / size;
  }
}

int regret_planted(regret_problem *a, int d, int nc, double condition, double mu, planted_flaw flaw,
                   uint64_t *state) {
  const int m = d * nc;
  if (regret_room(a, d, nc)) return -1;
  double *r = calloc(2 * (size_t)m, sizeof *r), *u = r ? r + m : NULL;
  if (!r || regret_spectrum(a->W, m, flaw == FLAW_RANK ? m / 2 : m, condition, state)) {
    free(r);
    return -1;
  }
  for (int c = 0; c < nc; c++) {
    a->own.mu[c] = flaw == FLAW_BONDED && c % 2 ? INFINITY : mu;
    regret_plant(d, a->own.mu[c], state, r + d * c, u + d * c);
    if (flaw == FLAW_BORDER) put_on_border(c, mu, r + 3 * c, u + 3 * c);
  }
  for (int i = 0; i < m; i++)
    a->own.q[i] = u[i];
  for (int j = 0; j < m; j++)
    for (int i = 0; i < m; i++)
      a->own.q[i] -= a->W[(size_t)i + (size_t)m * (size_t)j] * r[j];
  free(r);
  return 0;
}

/* ---- half-space ------------------------------------------------------------------------------ */

/* scattered: at random places, each height for itself. */
static int make_rough(regret_problem *a, int size, double mu, int scattered, uint64_t *state) {
  const int side = (int)fmax(3, round(sqrt(size))), nc = side * side;
  double phase[12], *at = calloc(2 * (size_t)nc, sizeof *at);
  if (!at || regret_room(a, 3, nc)) {
    free(at);
    return -1;
  }
  for (int k = 0; k < 12; k++)
    phase[k] = pi * bench_draw(state);
  for (int c = 0; c < nc; c++) {
    at[2 * c] = (c % side + (scattered ? 0.25 * bench_draw(state) : 0)) / side;
    at[2 * c + 1] = ((double)(c / side) + (scattered ? 0.25 * bench_draw(state) : 0)) / side;
  }
  half_space(nc, at, (scattered ? 0.25 : 1) / side, a->W);
  for (int c = 0; c < nc; c++) {
    const double x = at[2 * c], y = at[2 * c + 1];
    double height = scattered ? bench_draw(state) + bench_draw(state) + bench_draw(state) : 0;
    for (int k = 0; !scattered && k < 6; k++)
      height += pow(0.7, k) *
                cos(2 * pi * (k + 1) * (x * cos(phase[k]) + y * sin(phase[k])) + phase[k + 6]);
    a->own.q[3 * c] = 0.1 * (0.6 * height - 1);
    a->own.q[3 * c + 1] = 0.04 * (1 - y / 2);
    a->own.q[3 * c + 2] = 0.02 * x;
    a->own.mu[c] = mu * (1 + 0.4 * bench_draw(state));
  }
  free(at);
  return 0;
}

/* ---- robots ---------------------------------------------------------------------------------- */

void regret_multiply(regret_problem *a, int n, int m, const double *H, const double *v) {
  for (int j = 0; j < m; j++) {
    for (int i = 0; i < m; i++) {
      double sum = 0;
      for (int k = 0; k < n; k++)
        sum += H[k + n * i] * H[k + n * j];
      a->W[(size_t)i + (size_t)m * (size_t)j] = sum;
    }
    for (int k = 0; k < n; k++)
      a->own.q[j] += H[k + n * j] * v[k];
  }
}

/* The feet of a robot, or a hand around a box: n motions; groups of four contacts share a link. A
 * link moves with the first six motions, the trunk's, and with joints of its own. */
static int make_robot(regret_problem *a, int n, int size, double mu, int hand, uint64_t *state) {
  enum { most = 30, least = 4, link = 4 };
  const int nc = size < least ? least : size, m = 3 * nc, own = n > 6 ? (n - 6) / 4 : 0;
  double T[6][most] = {{0}}, v[most];
  double *H = calloc((size_t)m * most, sizeof *H);
  if (!H || regret_room(a, 3, nc)) {
    free(H);
    return -1;
  }
  for (int k = 0; k < n; k++)
    v[k] = (k == 2 ? -1 : 0) + 0.3 * bench_draw(state);
  for (int c = 0; c < nc; c++) {
    const int l = c / link % 4;
    for (int i = 0; i < 6 && c % link == 0; i++)
      for (int k = 0; k < n; k++)
        T[i][k] = k < 6                            ? (i == k) * (k < 3 ? 1 : 2.4)
                  : (k - 6) / (own ? own : 1) == l ? bench_draw(state)
                                                   : 0;
    const double turn = hand ? 3.1416 * bench_draw(state) : 0;
    const double x[3] = {hand ? -0.5 * cos(turn) : (c & 1 ? 0.1 : -0.1) + 0.01 * bench_draw(state),
                         hand ? -0.5 * sin(turn) : (c & 2 ? 0.05 : -0.05),
                         hand ? 0.3 * bench_draw(state) : -0.5};
    const double e[3][3] = {{hand ? cos(turn) : 0, hand ? sin(turn) : 0, !hand},
                            {hand ? 0 : 1, 0, hand},
                            {hand ? sin(turn) : 0, hand ? -cos(turn) : 1, 0}};
    for (int j = 0; j < 3; j++) {
      const double row[6] = {e[j][0],
                             e[j][1],
                             e[j][2],
                             x[1] * e[j][2] - x[2] * e[j][1],
                             x[2] * e[j][0] - x[0] * e[j][2],
                             x[0] * e[j][1] - x[1] * e[j][0]};
      for (int k = 0; k < n; k++)
        for (int i = 0; i < 6; i++)
          H[k + n * (3 * c + j)] += row[i] * T[i][k];
    }
    a->own.mu[c] = mu;
    if (hand) a->own.q[3 * c] = -0.02 * (1 + 0.5 * bench_draw(state));
  }
  regret_multiply(a, n, m, H, v);
  for (int i = 0; hand && i < m; i++) /* finger tips give */
    a->W[(size_t)i * (size_t)(m + 1)] += i % 3 ? 0.015 : 0.01;
  free(H);
  return 0;
}

/* ---- pairs of bodies ------------------------------------------------------------------------- */

/*
 * Two elastic bodies, the upper one pressed down on the lower one and along. Both are boxes of the
 * same grid, glued to rigid bodies on their outer faces; their nodes meet. With F the flexibility
 * of the upper box on its lower face, the lower box, its mirror image and E2 times as stiff, has
 * D F D / E2, D = -1 for normals and 1 for tangents, so that W = F + D F D / E2. Without reactions
 * the upper body moves as its rigid part does: q_n is the gap of two crowned and slightly rough
 * faces less the motion down, q_t the motion along. About half the contacts touch.
 */
static const double stiffer = 2;           /* E2 */
static const double crown = 1.2;           /* at the edges, over the way down */
static const double rough = 0.02;          /* over the way down */
static const double along[2] = {0.4, 0.2}; /* over the way down */

/* Fills W of the pair from F of the upper box, and q of cells + 1 nodes a side. */
static void fill_pair(regret_problem *a, const dls_contact *F, int cells, double down,
                      uint64_t state) {
  const int d = F->d, m = d * F->nc;
  for (int j = 0; j < m; j++)
    for (int i = 0; i < m; i++)
      a->W[(size_t)i + (size_t)j * (size_t)m] =
          (1 + ((i % d == 0) == (j % d == 0) ? 1 : -1) / stiffer) *
          F->W.a[(size_t)i + (size_t)j * (size_t)F->W.ld];
  for (int k = 0; k < F->nc; k++) {
    const double x = 2. * (k % (cells + 1)) / cells - 1, y = 2. * (k / (cells + 1)) / cells - 1;
    const double far = d == 3 ? (x * x + y * y) / 2 : x * x;
    a->own.q[d * k] = down * (crown * far + rough * bench_draw(&state) - 1);
    for (int t = 1; t < d; t++)
      a->own.q[d * k + t] = down * along[t - 1];
  }
}

/* Puts W by blocks in place of W dense. */
static int make_blocks(regret_problem *a) {
  const size_t d = (size_t)a->contact.d, nc = (size_t)a->contact.nc;
  a->own.p = calloc(nc + 1, sizeof *a->own.p);
  a->own.i = calloc(nc * nc, sizeof *a->own.i);
  a->own.x = calloc(d * d * nc * nc, sizeof *a->own.x);
  if (!a->own.p || !a->own.i || !a->own.x) return -1;
  const dls_dense W = a->contact.W;
  a->contact.W = (dls_dense){0};
  return dls_blocks_from_dense(&W, (int)d, a->own.p, a->own.i, a->own.x, &a->contact.Wb, NULL) ? -1
                                                                                               : 0;
}

/* Kinds: elastic2, elastic3, W dense; elastic2-blocks, elastic3-blocks: the same by blocks. */
static int make_pair(regret_problem *a, const char *kind, int size, double mu, uint64_t seed) {
  const int d = kind[7] - '0', side = d == 2 ? size : (int)round(sqrt(size));
  const int cells = side > 2 ? side - 1 : 1, height = cells / 4 > 4 ? cells / 4 : 4;
  const int flat = d == 2 && height > 40 ? 40 : height;
  box b;
  dls_reduction *R = NULL;
  dls_contact F;
  if (size > regret_most_of_pair || box_create_glued(&b, d, cells, flat)) return -1;
  int bad = regret_room(a, d, b.model.nodes);
  for (int k = 0; !bad && k < b.model.nodes; k++)
    a->own.mu[k] = mu;
  bad = bad || bench_reduce(&R, &b.model, NULL) || dls_reduction_contact(R, a->own.mu, &F, NULL);
  if (!bad) fill_pair(a, &F, cells, 0.01 * flat, seed * 0x9E3779B97F4A7C15u + 1);
  dls_reduction_destroy(R);
  box_free(&b);
  return bad || (kind[8] && make_blocks(a)) ? -1 : 0;
}

/* ---- finite elements ------------------------------------------------------------------------- */

static int copy_contact(regret_problem *a, const dls_contact *from, double mu) {
  const int d = from->d, m = d * from->nc;
  if (regret_room(a, d, from->nc)) return -1;
  for (int j = 0; j < m; j++)
    memcpy(a->W + (size_t)j * (size_t)m, from->W.a + (size_t)j * (size_t)from->W.ld,
           (size_t)m * sizeof *a->W);
  memcpy(a->own.q, from->q, (size_t)m * sizeof *a->own.q);
  for (int c = 0; c < from->nc; c++)
    a->own.mu[c] = mu;
  return 0;
}

/* Keeps the scene numbered `wanted` of those that are visited. */
typedef struct choice {
  regret_problem *a;
  double mu;
  int wanted, seen, bad;
} choice;

static void keep_cube(void *data, const scene *s) {
  choice *k = data;
  if (k->seen++ == k->wanted) k->bad = copy_contact(k->a, &s->contact, k->mu);
}

/* Finds, of the scenes as near as any to a size, one that depends on skip. */
typedef struct nearest {
  int size, skip, seen, at, away;
} nearest;

static void look_at_block(void *data, const scene *s) {
  nearest *n = data;
  const int away = abs(s->contact.nc - n->size), k = n->seen++;
  if (n->at >= 0 && (away > n->away || (away == n->away && n->skip-- <= 0))) return;
  n->at = k;
  n->away = away;
}

/* Cubes come in four sizes, 49, 81, 121, 169, twelve of each; the load goes by the seed. */
static int make_cube(regret_problem *a, double nu, int size, double mu, uint64_t seed) {
  const int row = size < 65 ? 0 : size < 100 ? 1 : size < 145 ? 2 : 3;
  choice k = {a, mu, 12 * row + (int)(seed / 2 % 4), 0, -1};
  return scenes_cubes_of(nu, 1, keep_cube, &k) ? -1 : k.bad;
}

/* Blocks of solvers_scenes.c in 2D; the load goes by the seed, the size is the nearest. */
static int make_block(regret_problem *a, int size, double mu, uint64_t seed) {
  nearest n = {.size = size, .skip = (int)(seed / 2 % 4), .at = -1};
  if (scenes_blocks(0, look_at_block, &n) || n.at < 0) return -1;
  choice k = {a, mu, n.at, 0, -1};
  return scenes_blocks(0, keep_cube, &k) ? -1 : k.bad;
}

int regret_elastic(regret_problem *a, const char *kind, int size, double mu, uint64_t seed) {
  uint64_t state = regret_state(seed, 5);
  const int d = kind[strlen(kind) - 1] == '2' ? 2 : 3;
  if (regret_is_pair(kind)) return make_pair(a, kind, size, mu, seed);
  if (strncmp(kind, "cube", 4) == 0) return make_cube(a, strtod(kind + 4, NULL), size, mu, seed);
  if (strcmp(kind, "box") == 0) return make_robot(a, 6, size, mu, 0, &state);
  if (strcmp(kind, "feet") == 0) return make_robot(a, seed % 4 < 2 ? 18 : 30, size, mu, 0, &state);
  if (strcmp(kind, "hand") == 0) return make_robot(a, 6, size, mu, 1, &state);
  if (strcmp(kind, "rough3") == 0) return make_rough(a, size, mu, 0, &state);
  if (strcmp(kind, "asperities") == 0) return make_rough(a, size, mu, 1, &state);
  if (strncmp(kind, "ill", 3) == 0) return regret_planted(a, d, size, 1e4, mu, FLAW_NONE, &state);
  if (strncmp(kind, "bonded", 6) == 0)
    return regret_planted(a, d, size, 1e2, mu, FLAW_BONDED, &state);
  return make_block(a, size, mu, seed);
}
