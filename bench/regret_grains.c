/*
 * regret_grains.c: grains that are not round, or not at rest, made of the settled discs and balls
 * of tests/shared/rigid.h.
 *
 * A ball touches at the arm R n from its middle. For the frame F = (n, t, s) of a contact, H of a
 * ball is +- M^-1/2 (F; R n x F), so that
 *
 *   another normal at the same point      H Q, Q a small rotation of the frame
 *   another point, R n + R e t            adds +- e k (t x F) to the turning rows, k = R I^-1/2
 *   other inertias                        scale the turning rows
 *
 * e R differs between two grains of different radii: a contact of several points is no true plane.
 */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "common.h"
#include "regret_kinds.h"

typedef struct recipe {
  const char *kind, *of;
  int points; /* of each contact */
  double tilt, stretch;
  double along; /* velocity of the floor along itself; the other walls have no friction then */
  int impact;   /* 1: one grain in ten is fast, the others stand still */
} recipe;

static const recipe recipes[] = {{"ell3-rest", "balls-rest", 1, 0.3, 0.5, 0, 0},
                                 {"ell3-flow", "balls-flow", 1, 0.3, 0.5, 0, 0},
                                 {"poly2-rest", "discs-rest", 2, 0.1, 0, 0, 0},
                                 {"poly2-flow", "discs-flow", 2, 0.1, 0, 0, 0},
                                 {"poly3-flow", "balls-flow", 3, 0.1, 0.3, 0, 0},
                                 {"drum2", "discs-rest", 1, 0, 0, 0.2, 0},
                                 {"drum3", "balls-rest", 1, 0, 0, 0.2, 0},
                                 {"impact2", "discs-rest", 1, 0, 0, 0, 1},
                                 {"impact3", "balls-rest", 1, 0, 0, 0, 1},
                                 {"worn3-rest", "balls-rest", 1, 0.1, 0.5, 0, 0},
                                 {"drum3-sizes", "sizes3-flow", 1, 0, 0, 0.2, 0}};
enum { recipe_count = sizeof recipes / sizeof recipes[0] };

/* Turns the frame of H (n x d) by angle a in the plane of columns 0 and j. */
static void turn_frame(int n, double *H, int j, double a) {
  for (int l = 0; l < n; l++) {
    const double x = H[l], y = H[l + n * j];
    H[l] = cos(a) * x + sin(a) * y;
    H[l + n * j] = cos(a) * y - sin(a) * x;
  }
}

/* Moves the point of H (n x d) by e[0] R t + e[1] R s. */
static void move_point(int d, double *H, const double *e) {
  const int n = 3 * (d - 1);
  double F[3][3] = {{0}}, root = 0, k = 0, by[3] = {0};
  for (int i = 0; i < d; i++)
    root += H[i] * H[i];
  for (int l = d; l < n; l++)
    k += H[l + n] * H[l + n];
  root = sqrt(root);
  k = sqrt(k);
  for (int j = 0; j < d; j++)
    for (int i = 0; i < d; i++)
      F[j][i] = H[i + n * j] / root; /* with the sign of the side */
  for (int i = 0; i < 3; i++)
    by[i] = e[0] * F[1][i] + (d == 3 ? e[1] * F[2][i] : 0);
  for (int j = 0; j < d; j++) {
    double turn[3];
    rigid_cross(by, F[j], turn);
    for (int l = d; l < n; l++)
      H[l + n * j] += k * turn[d == 2 ? 2 : l - 3];
  }
}

/* Writes contact `to` of a from contact c of the balls; both sides see one frame and one point. */
static void write_point(regret_problem *a, const recipe *how, int c, int to, const double *angle,
                        const double *e) {
  const int d = a->bodies.d, n = 3 * (d - 1), size = n * d;
  for (int side = 0; side < 2; side++) {
    double *H = a->own.H + (size_t)(2 * to + side) * (size_t)size;
    a->own.body[2 * to + side] = a->bodies.body[2 * c + side];
    memcpy(H, a->bodies.H + (size_t)(2 * c + side) * (size_t)size, (size_t)size * sizeof *H);
    if (a->own.body[2 * to + side] < 0) continue;
    /* F has the sign of the side twice in t x F, so the arm is turned back for the lower one. */
    const double turned[2] = {side ? -e[0] : e[0], side ? -e[1] : e[1]};
    if (how->points > 1) move_point(d, H, turned);
    for (int j = 1; j < d; j++)
      turn_frame(n, H, j, angle[j - 1]);
  }
}

/* Scales the turning rows of every body alike at all of its contacts. */
static void stretch_bodies(regret_problem *a, int nc, double stretch, uint64_t seed) {
  const int d = a->bodies.d, n = 3 * (d - 1);
  for (int k = 0; k < 2 * nc; k++) {
    uint64_t state = regret_state(seed, 100 + (uint64_t)(a->own.body[k] + 1));
    for (int l = d; l < n; l++) {
      const double by = 1 + stretch * bench_draw(&state);
      for (int j = 0; j < d && a->own.body[k] >= 0; j++)
        a->own.H[(size_t)(k * d + j) * (size_t)n + (size_t)l] *= by;
    }
  }
}

/* Sets the velocities of the grains, and what moving walls add to q. */
static void set_in_motion(regret_problem *a, const recipe *how, int nc, uint64_t *state) {
  const int d = a->bodies.d, n = 3 * (d - 1);
  memcpy(a->own.v, a->bodies.v, (size_t)a->bodies.bodies * (size_t)n * sizeof *a->own.v);
  for (int b = 0; how->impact && b < a->bodies.bodies; b++)
    for (int l = 0; l < n; l++)
      a->own.v[b * n + l] = b % 10 == 0 && l < d ? bench_draw(state) - (l == d - 1) : 0;
  for (int c = 0; how->along > 0 && c < nc; c++) {
    const double *H = a->own.H + (size_t)(2 * c) * (size_t)(n * d);
    if (a->own.body[2 * c + 1] >= 0) continue;
    if (H[d - 1] > fabs(H[0]))
      a->own.q[d * c + 1] = -how->along;
    else
      a->own.mu[c] = 0;
  }
}

int regret_grains(regret_problem *a, const char *kind, int size, double mu, uint64_t seed) {
  uint64_t state = regret_state(seed, 11);
  int k = 0;
  while (k < recipe_count && strcmp(kind, recipes[k].kind) != 0)
    k++;
  if (k == recipe_count) return -1;
  const recipe *how = &recipes[k];
  const int fewer = size / how->points > 4 ? size / how->points : 4;
  if (rigid_create(&a->bodies, how->of, fewer, mu, seed)) return -1;
  const int d = a->bodies.d, base = a->bodies.contact.nc, nc = base * how->points;
  if (rigid_room(&a->own, d, a->bodies.bodies, nc)) return -1;
  for (int c = 0; c < base; c++) {
    const double angle[2] = {how->tilt * bench_draw(&state), how->tilt * bench_draw(&state)};
    const double first = 3.14159265358979 * bench_draw(&state);
    for (int point = 0; point < how->points; point++) {
      const double at = first + 2 * 3.14159265358979 * point / how->points;
      const double e2[2] = {point ? 0.3 : -0.3, 0}, e3[2] = {0.3 * cos(at), 0.3 * sin(at)};
      const int to = how->points * c + point;
      write_point(a, how, c, to, angle, d == 2 ? e2 : e3);
      a->own.mu[to] = mu;
    }
  }
  if (how->stretch > 0) stretch_bodies(a, nc, how->stretch, seed);
  set_in_motion(a, how, nc, &state);
  if (rigid_assemble(&a->own)) return -1;
  a->contact = a->own.contact;
  return 0;
}
