/* trails_problems.c: the problems of trails.h. */
#include <check.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "cases.h"
#include "failures.h"
#include "front_cases.h"
#include "half_space.h"
#include "trails.h"

enum { half_cells = 60, side = 7, surface_rows = 3 * side * side };

/* A surface of 7 x 7 points that move along by exp(-distance / 10), normals and tangents coupled,
 * under a load by chance: sweeps and Newton's method alone do not get far. */
static dls_contact trails_surface(double friction, unsigned seed) {
  static double W[surface_rows * surface_rows], q[surface_rows], mu[side * side];
  enum { nc = side * side, m = surface_rows };
  for (int c = 0; c < nc; c++) {
    mu[c] = friction;
    for (int i = 0; i < 3; i++)
      q[3 * c + i] = draw(&seed) - (i ? 0 : .5);
    for (int b = 0; b < nc; b++) {
      const double x = c % side - b % side, y = c / side - b / side, r = hypot(x, y);
      const double g = exp(-.1 * r), couple[3] = {0, .3 * x * g / (1 + r), .3 * y * g / (1 + r)};
      for (int i = 0; i < 3; i++)
        for (int j = 0; j < 3; j++)
          W[3 * c + i + (3 * b + j) * m] =
              (i == j ? g : 0) + (j == 0 ? couple[i] : 0) - (i == 0 ? couple[j] : 0);
    }
  }
  return (dls_contact){.d = 3, .nc = nc, .W = {m, m, m, W}, .q = q, .mu = mu};
}

/* W of 40 candidates and rank 84 but for 1e-3, much friction, most candidates lifted: Newton's
 * method fails where ADMM is forecast to cost more than the sweeps ahead. */
static dls_contact trails_low_rank(unsigned seed) {
  enum { nc = 40, m = 3 * nc, rank = 84 };
  static double W[m * m], q[m], mu[nc], G[m * rank];
  for (int k = 0; k < m * rank; k++)
    G[k] = draw(&seed);
  for (int j = 0; j < m; j++)
    for (int i = 0; i < m; i++) {
      double sum = 0;
      for (int k = 0; k < rank; k++)
        sum += G[i + k * m] * G[j + k * m];
      W[i + j * m] = sum / rank + (i == j ? 1e-3 : 0);
    }
  for (int i = 0; i < m; i++) {
    mu[i / 3] = 4;
    q[i] = draw(&seed) + (i % 3 ? 0 : .5);
  }
  return (dls_contact){.d = 3, .nc = nc, .W = {m, m, m, W}, .q = q, .mu = mu};
}

int trails_make(int k, trails_problem *a) {
  static model m, copy;
  static bodies_storage storage;
  static planted_problem plant;
  static double W[4 * half_cells * half_cells], q[2 * half_cells], mu[half_cells];
  memset(a, 0, sizeof *a);
  int at = k;
#define TRAILS(count, ...)                                                                         \
  do {                                                                                             \
    if (at >= 0 && at < (count)) {                                                                 \
      __VA_ARGS__;                                                                                 \
      return 1;                                                                                    \
    }                                                                                              \
    at -= (count);                                                                                 \
  } while (0)
  TRAILS(8, numbered_model(&m, at < 6 ? 3 * at + 2 : normal_models + at);
         (void)snprintf(a->name, sizeof a->name, "random-%d", at); a->p = m.p);
  TRAILS(4, deficient_model(&m, at); (void)snprintf(a->name, sizeof a->name, "deficient-%d", at);
         a->p = m.p);
  TRAILS(2, slow_model(&m, at); (void)snprintf(a->name, sizeof a->name, "slow-%d", at); a->p = m.p);
  TRAILS(1, slow_model(&copy, 1); scale_model(&m, &copy, 1e-3, 1e6);
         (void)snprintf(a->name, sizeof a->name, "other-units"); a->p = m.p);
  TRAILS(7, a->p = planted_case(&plant, at);
         (void)snprintf(a->name, sizeof a->name, "planted-%d", at));
  TRAILS(2, a->p = half_plane(W, q, mu, at ? half_cells : 24, 2, at ? .3 : .8, at ? 3 : .5, .4);
         (void)snprintf(a->name, sizeof a->name, "half-plane-%d", at));
  TRAILS(3, bodies_model(&m, &storage, &a->p, at + 3);
         (void)snprintf(a->name, sizeof a->name, "bodies-%d", at));
  int count;
  const failure *f = contact_failures(&count);
  TRAILS(count, a->p = failure_contact(&f[at]);
         (void)snprintf(a->name, sizeof a->name, "%.50s", f[at].name));
  int kinds = 0;
  while (rigid_kind(kinds))
    kinds++;
  /* every kind by blocks, of bodies, larger */
  static const struct {
    const char *name;
    int of_bodies, candidates;
  } size[] = {{"", 0, 36},
              {"-of-bodies", 1, 36},
              {"-150", 0, 150},
              {"-150-of-bodies", 1, 150},
              {"-500", 0, 500}};
  enum { sizes = sizeof size / sizeof size[0] };
  TRAILS(sizes * kinds, const char *kind = rigid_kind(at / sizes); const int s = at % sizes;
         ck_assert_int_eq(rigid_create(&a->bodies, kind, size[s].candidates, .5, 7), 0);
         a->p = size[s].of_bodies ? a->bodies.factored : a->bodies.contact;
         (void)snprintf(a->name, sizeof a->name, "%s%s", kind, size[s].name));
  /* with slabs for several threads */
  static const char *const large[] = {"chain", "packing-flow", "wall-pushed"};
  TRAILS(6, const int of_bodies = at % 2;
         ck_assert_int_eq(rigid_create(&a->bodies, large[at / 2], 2000, .5, 7), 0);
         a->p = of_bodies ? a->bodies.factored : a->bodies.contact; (void)snprintf(
             a->name, sizeof a->name, "%s-2000%s", large[at / 2], of_bodies ? "-of-bodies" : ""));
  /* where the first path of the homotopy leads nowhere */
  TRAILS(2, a->p = at ? planted(&plant, 3, 3, 5, 3, 45) : planted(&plant, 2, 4, 4, 10, 14);
         (void)snprintf(a->name, sizeof a->name, "later-start-%d", at));
  TRAILS(8, a->p = trails_surface(1 << at / 2, (unsigned)at + 5);
         (void)snprintf(a->name, sizeof a->name, "surface-%d", at));
  TRAILS(1, a->p = trails_low_rank(619); (void)snprintf(a->name, sizeof a->name, "low-rank"));
#undef TRAILS
  return 0;
}

void trails_free(trails_problem *a) {
  if (a->bodies.p) rigid_free(&a->bodies);
}

/* ---- disturbed by rounding ------------------------------------------------------------------- */

/* Returns 1 + rounding, the same for row, col and col, row. */
static double rounding_of(int row, int col, unsigned seed) {
  const unsigned low = (unsigned)(row < col ? row : col), high = (unsigned)(row < col ? col : row);
  unsigned own = seed ^ (low * 7919u + high * 104729u);
  (void)draw(&own);
  return 1 + 2e-14 * draw(&own);
}

dls_contact trails_disturbed(const dls_contact *p, double *storage[2], unsigned *seed) {
  dls_contact a = *p;
  const int d = p->d, m = d * p->nc;
  const dls_blocks *B = &p->Wb;
  const double unit = 1.5 + draw(seed) / 2;
  double *q = storage[0] = malloc((size_t)m * sizeof *q);
  ck_assert_ptr_nonnull(q);
  for (int i = 0; i < m; i++)
    q[i] = p->q[i] * (1 + 2e-12 * draw(seed));
  a.q = q;
  const int rows = p->bodies.H ? 2 * p->bodies.n : p->W.ld;
  const int entries = B->x ? d * d * B->p[p->nc] : rows * m;
  double *x = storage[1] = malloc((size_t)entries * sizeof *x);
  ck_assert_ptr_nonnull(x);
  for (int k = 0; k < entries && p->bodies.H; k++)
    x[k] = unit * p->bodies.H[k] * rounding_of(0, k, *seed);
  for (int k = 0; k < entries && p->W.a; k++)
    x[k] = unit * p->W.a[k] * rounding_of(k % rows, k / rows, *seed);
  for (int c = 0; c < p->nc && B->x; c++)
    for (int k = B->p[c]; k < B->p[c + 1]; k++)
      for (int e = 0; e < d * d; e++)
        x[d * d * k + e] =
            unit * B->x[d * d * k + e] * rounding_of(d * B->i[k] + e % d, d * c + e / d, *seed);
  if (p->bodies.H) a.bodies.H = x;
  if (p->W.a) a.W.a = x;
  if (B->x) a.Wb.x = x;
  return a;
}
