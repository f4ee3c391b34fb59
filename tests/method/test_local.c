/* test_local.c: the exact solution of one contact. BLOCKS random blocks per dimension. */
#include <time.h>

#include "delassus/nlgs.h"
#include "run.h"
#include "vi/vi_internal.h"

#ifndef BLOCKS
#define BLOCKS 100000
#endif

static uint64_t seed = 88172645463325252u;

/* uniform in (0, 1) */
static double fraction(void) {
  seed ^= seed << 13;
  seed ^= seed >> 7;
  seed ^= seed << 17;
  return ((double)(seed >> 11) + 0.5) * 0x1p-53;
}

/* How far (r, u = W r + q) is from the laws as they are written in contact.h, over the size of the
 * terms of u: no projection, no certificate. */
static double violation(int d, const double *W, const double *q, double mu, const double *r) {
  double u[3] = {0}, size = 0, w = 0, worst = 0;
  for (int i = 0; i < d; i++) {
    u[i] = q[i];
    double row = fabs(q[i]);
    for (int j = 0; j < d; j++) {
      u[i] += W[i + d * j] * r[j];
      row += fabs(W[i + d * j] * r[j]);
      if (fabs(W[i + d * j]) > w) w = fabs(W[i + d * j]);
    }
    if (row > size) size = row;
  }
  const double rt = d == 2 ? fabs(r[1]) : hypot(r[1], r[2]);
  const double ut = d == 2 ? fabs(u[1]) : hypot(u[1], u[2]);
  const int free = r[0] == 0 && rt == 0;
  const int edge = w * (mu * r[0] - rt) <= 1e-11 * size;
  double v[6] = {-u[0], -w * r[0], w * (rt - mu * r[0]), 0, 0, 0};
  if (!free) v[3] = fabs(u[0]);
  if (!free && !edge) v[4] = ut;
  if (!free && edge && rt > 0)
    v[5] =
        d == 2 ? fabs(u[1] + ut * r[1] / rt) : hypot(u[1] + ut * r[1] / rt, u[2] + ut * r[2] / rt);
  for (int k = 0; k < 6; k++)
    if (!(v[k] <= worst)) worst = v[k];
  return size > 0 ? worst / size : worst;
}

typedef struct local_case {
  const char *name;
  int d;
  double W[9]; /* by rows, as one reads it */
  double q[3], mu;
  double r[3];
  dlsi_local_state state;
  int count;
} local_case;

static const local_case cases[] = {
    /* W_nt = 0 */
    {"free", 2, {2, 0, 0, 1}, {1, -7}, 1, {0, 0}, DLS_LOCAL_FREE, 1},
    {"touching", 2, {2, 0, 0, 1}, {0, -7}, 1, {0, 0}, DLS_LOCAL_FREE, 1},
    {"stick", 2, {2, 0, 0, 1}, {-2, 0.5}, 1, {1, -0.5}, DLS_LOCAL_STICK, 1},
    {"stick on the edge", 2, {2, 0, 0, 1}, {-2, 1}, 1, {1, -1}, DLS_LOCAL_STICK, 1},
    {"slip right", 2, {2, 0, 0, 1}, {-2, 5}, 1, {1, -1}, DLS_LOCAL_SLIP, 1},
    {"slip left", 2, {2, 0, 0, 1}, {-2, -5}, 1, {1, 1}, DLS_LOCAL_SLIP, 1},
    /* W_nt = 1 */
    {"coupled stick", 2, {2, 1, 1, 2}, {-3.5, -1}, 0.5, {2, -0.5}, DLS_LOCAL_STICK, 1},
    {"coupled slip left", 2, {2, 1, 1, 2}, {-5, -6}, 0.5, {2, 1}, DLS_LOCAL_SLIP, 1},
    {"coupled slip right", 2, {2, 1, 1, 2}, {-3, 1}, 0.5, {2, -1}, DLS_LOCAL_SLIP, 1},
    {"unsymmetric slip", 2, {2, 1, -1, 3}, {-5, -2}, 0.5, {2, 1}, DLS_LOCAL_SLIP, 1},
    {"pivoting", 2, {0, 1, 1, 0}, {-1, -2}, 1, {2, 1}, DLS_LOCAL_STICK, 2}, /* and r = (1, 1) */
    {"frictionless", 2, {2, 1, 1, 2}, {-4, 3}, 0, {2, 0}, DLS_LOCAL_SLIP, 1},
    {"frictionless at rest", 2, {2, 1, 1, 2}, {-4, -2}, 0, {2, 0}, DLS_LOCAL_STICK, 1},
    {"frictionless, touching", 2, {2, 0, 0, 1}, {0, 3}, 0, {0, 0}, DLS_LOCAL_FREE, 1},
    {"frictionless, W_nn < 0", 2, {-1, 0, 0, 1}, {1, 0}, 0, {0, 0}, DLS_LOCAL_FREE, 2},
    {"C1: three solutions", 2, {1, 1, 1, 2}, {1, 4}, 2, {0, 0}, DLS_LOCAL_FREE, 3},
    {"C2: a continuum", 2, {1, 1, 1, 2}, {0, 1}, 1, {0, 0}, DLS_LOCAL_FREE, 2},
    {"indefinite: stick and two slips", 2, {1, 0, 0, -1}, {-1, 0}, 1, {1, 0}, DLS_LOCAL_STICK, 3},
    {"C3: below jamming", 2, {1, 1, 1, 1}, {-2, 0}, 0.5, {4, -2}, DLS_LOCAL_SLIP, 1},
    {"C6", 2, {2, -1, -1, 1}, {-1, 1}, 1, {1. / 3, -1. / 3}, DLS_LOCAL_SLIP, 1},
    {"C7", 2, {1, -1, -1, 2}, {-1, -3}, 2, {5, 4}, DLS_LOCAL_STICK, 1},
    {"C12a", 2, {5, 2, 2, 1}, {-1, 0}, 3, {1, -2}, DLS_LOCAL_STICK, 1},
    {"no tangential compliance", 2, {2, 0, 0, 0}, {-2, 3}, 0.5, {1, -0.5}, DLS_LOCAL_SLIP, 1},
    {"a line of sticks", 2, {2, 0, 0, 0}, {-2, 0}, 0.5, {1, 0}, DLS_LOCAL_STICK, 3},
    /* 3D */
    {"free", 3, {2, 0, 0, 0, 1, 0, 0, 0, 1}, {1, 3, 4}, 1, {0, 0, 0}, DLS_LOCAL_FREE, 1},
    {"stick", 3, {2, 0, 0, 0, 1, 0, 0, 0, 1}, {-2, .3, .4}, 1, {1, -.3, -.4}, DLS_LOCAL_STICK, 1},
    {"slip", 3, {2, 0, 0, 0, 1, 0, 0, 0, 1}, {-2, 3, 4}, 1, {1, -.6, -.8}, DLS_LOCAL_SLIP, 1},
    {"coupled slip", 3, {2, 1, 0, 1, 2, 0, 0, 0, 2}, {-5, -6, 0}, .5, {2, 1, 0}, DLS_LOCAL_SLIP, 1},
    {"frictionless", 3, {2, 1, 0, 1, 2, 0, 0, 0, 2}, {-4, 1, 1}, 0, {2, 0, 0}, DLS_LOCAL_SLIP, 1},
    {"at rest", 3, {2, 1, 1, 1, 2, 0, 1, 0, 2}, {-4, -2, -2}, 0, {2, 0, 0}, DLS_LOCAL_STICK, 1},
    {"along t", 3, {2, 1, 1, 1, 2, 0, 1, 0, 2}, {-4, 1, -2}, 0, {2, 0, 0}, DLS_LOCAL_SLIP, 1},
    {"along s", 3, {2, 1, 1, 1, 2, 0, 1, 0, 2}, {-4, -2, 1}, 0, {2, 0, 0}, DLS_LOCAL_SLIP, 1},
    {"bonded", 3, {2, 0, 0, 0, 1, 0, 0, 0, 1}, {-2, 3, 4}, INFINITY, {1, -3, -4}, 2, 1},
    {"no tangential compliance", 3, {2}, {-2, 3, 4}, .5, {1, -.3, -.4}, DLS_LOCAL_SLIP, 1},
    {"a plane of sticks", 3, {2}, {-2, 0, 0}, .5, {1, 0, 0}, DLS_LOCAL_STICK, 1},
    {"C7 in 3D", 3, {1, -1, 0, -1, 2, 0, 0, 0, 2}, {-1, -3, 0}, 2, {5, 4, 0}, DLS_LOCAL_STICK, 1},
    {"C1 in 3D", 3, {1, 1, 0, 1, 2, 0, 0, 0, 1}, {1, 4, 0}, 2, {0, 0, 0}, DLS_LOCAL_FREE, 3},
    {"u_t large", 3, {1, 2, 0, 2, 10, 0, 0, 0, 10}, {1, 50}, 1, {0}, DLS_LOCAL_FREE, 3},
    {"free, or a fast slip", 3, {1, 2, 0, 6, 10, 0, 0, 0, 10}, {1, 5e3}, 1, {0}, DLS_LOCAL_FREE, 2},
    /* W_nt beyond W_tt: stick is (20, -70), slip (2, -10) along the tangent that W_nt has */
    {"soft along t", 3, {1, .3, 0, .3, .1, 0, 0, 0, .1}, {1, 1}, 5, {0}, DLS_LOCAL_FREE, 3},
    {"soft along s", 3, {1, 0, .3, 0, .1, 0, .3, 0, .1}, {1, 0, 1}, 5, {0}, DLS_LOCAL_FREE, 3},
    {"C16", 3, {2, -1, 2, -1, 2, 0, 2, 0, 3}, {-1, 4, 3}, 1, {6, 1, -5}, DLS_LOCAL_STICK, 3},
};

static void transpose(int d, const double *rows, double *W) {
  for (int i = 0; i < d; i++)
    for (int j = 0; j < d; j++)
      W[i + d * j] = rows[d * i + j];
}

TEST_EACH(by_hand, 0, sizeof cases / sizeof cases[0]) {
  const local_case *k = &cases[_i];
  double W[9], r[3] = {7, 7, 7};
  int count = -1;
  transpose(k->d, k->W, W);
  const dlsi_local_state state = dlsi_nlgs_local(k->d, W, k->q, k->mu, r, &count);
  ck_assert_msg(state == k->state, "%s: state %d", k->name, state);
  ck_assert_msg(count == k->count, "%s: count %d", k->name, count);
  for (int i = 0; i < k->d; i++)
    ck_assert_msg(fabs(r[i] - k->r[i]) <= 4 * DBL_EPSILON * fabs(k->r[0]), "%s: r[%d] = %.17g",
                  k->name, i, r[i]);
  if (k->d == 2) ck_assert(r[2] == 7); /* not ours */
  ck_assert(violation(k->d, W, k->q, k->mu, r) <= 8 * DBL_EPSILON);
  ck_assert_int_eq(dlsi_nlgs_local(k->d, W, k->q, k->mu, r, NULL), state);
}

/* powers of two on force and length: the same bits */
TEST_EACH(units, 0, sizeof cases / sizeof cases[0]) {
  const local_case *k = &cases[_i];
  double W[9], V[9], q[3], r[3], s[3];
  transpose(k->d, k->W, W);
  (void)dlsi_nlgs_local(k->d, W, k->q, k->mu, r, NULL);
  for (int a = -30; a <= 30; a += 30)
    for (int b = -30; b <= 30; b += 30) {
      for (int e = 0; e < k->d * k->d; e++)
        V[e] = ldexp(W[e], a - b);
      for (int i = 0; i < k->d; i++)
        q[i] = ldexp(k->q[i], a);
      int count;
      ck_assert_int_eq(dlsi_nlgs_local(k->d, V, q, k->mu, s, &count), k->state);
      ck_assert_int_eq(count, k->count);
      for (int i = 0; i < k->d; i++)
        ck_assert(s[i] == ldexp(r[i], b));
    }
}

typedef struct bad_case {
  int d;
  double W[9], q[3], mu;
} bad_case;

static const bad_case unsolvable[] = {
    {2, {1, 1, 1, 1}, {-2, 0}, 1},                   /* C3, jammed */
    {2, {1, 1, 1, 1}, {-2, 0}, 3},                   /* */
    {2, {0}, {-1, 1}, 1},                            /* W = 0 */
    {2, {-1, 0, 0, 1}, {-1, 0}, 1},                  /* W_nn < 0 */
    {2, {0}, {-1, 1}, 0},                            /* */
    {2, {1, 0, 0, 1}, {NAN, 0}, 1},                  /* */
    {2, {NAN, 0, 0, 1}, {-1, 0}, 1},                 /* */
    {2, {1e-300, 0, 0, 1e-300}, {-1e300, 1e300}, 1}, /* r overflows */
    {2, {1e-300, 0, 0, 1}, {-1e300, 0}, 0},          /* */
    {2, {1e-300, 0, 0, 1}, {-1e300, 0}, 1},          /* */
    {2, {1e-300, 0, 0, 0}, {-1e300, -1}, 1},         /* */
    {2, {1, 0, 0, 0}, {-1e300, -1}, 1e300},          /* */
    {3, {1e-300, 0, 0, 0, 1, 0, 0, 0, 1}, {-1e300, 0, 0}, 0},
    {3, {1e-300, 0, 0, 0, 1, 0, 0, 0, 1}, {-1e300, 0, 0}, 1},
    {3, {1}, {-1e300, -1, 0}, 1e300},                 /* */
    {3, {1, 1, 0, 1, 1, 0, 0, 0, 1}, {-2, 0, 0}, 1},  /* C3 */
    {3, {1, 1, 0, 1, 1, 0, 0, 0, 1}, {-2, 0, 0}, 3},  /* */
    {3, {0}, {-1, 1, 0}, 1},                          /* */
    {3, {-1, 0, 0, 0, 1, 0, 0, 0, 1}, {-1, 0, 0}, 1}, /* */
    {3, {0}, {-1, 1, 0}, 0},                          /* */
    {3, {1, 0, 0, 0, 1, 0, 0, 0, 1}, {NAN, 0, 0}, 1}, /* */
    {3, {NAN, 0, 0, 0, 1, 0, 0, 0, 1}, {-1, 0, 0}, 1},
    {3, {1, 0, 0, 0, NAN, 0, 0, 0, 1}, {-1, 0, 0}, 1},
    {3, {1e-300, 0, 0, 0, 1e-300, 0, 0, 0, 1e-300}, {-1e300, 1e300, 0}, 1},
};

TEST_EACH(no_solution, 0, sizeof unsolvable / sizeof unsolvable[0]) {
  const bad_case *k = &unsolvable[_i];
  double W[9], r[3] = {NAN, NAN, NAN};
  int count = -1;
  transpose(k->d, k->W, W);
  ck_assert_int_eq(dlsi_nlgs_local(k->d, W, k->q, k->mu, r, &count), DLS_LOCAL_NONE);
  ck_assert_int_eq(count, 0);
  for (int i = 0; i < k->d; i++)
    ck_assert(isfinite(r[i]));
}

/* W = Q diag(1 .. 1/cond) Q^T + a skew part, q_n < 0 */
static void random_block(int d, double skew, double *W, double *q, double *mu) {
  const double cond = pow(10, 8 * fraction());
  const double e[3] = {1, d == 2 ? 1 / cond : pow(cond, -fraction()), 1 / cond};
  double Q[9];
  for (int j = 0; j < d; j++) {
    double n = 0;
    for (int i = 0; i < d; i++)
      Q[i + d * j] = 2 * fraction() - 1;
    for (int k = 0; k < j; k++) {
      double s = 0;
      for (int i = 0; i < d; i++)
        s += Q[i + d * j] * Q[i + d * k];
      for (int i = 0; i < d; i++)
        Q[i + d * j] -= s * Q[i + d * k];
    }
    for (int i = 0; i < d; i++)
      n += Q[i + d * j] * Q[i + d * j];
    for (int i = 0; i < d; i++)
      Q[i + d * j] /= sqrt(n);
  }
  for (int i = 0; i < d; i++)
    for (int j = 0; j < d; j++) {
      W[i + d * j] = 0;
      for (int k = 0; k < d; k++)
        W[i + d * j] += Q[i + d * k] * e[k] * Q[j + d * k];
    }
  for (int i = 0; i < d; i++)
    for (int j = 0; j < i; j++) {
      const double s = skew * (2 * fraction() - 1);
      W[i + d * j] += s;
      W[j + d * i] -= s;
    }
  for (int i = 0; i < d; i++)
    q[i] = 2 * fraction() - 1;
  q[0] = -fabs(q[0]);
  *mu = 0.1 * pow(40, fraction());
}

/* Bounds: 2D is all closed forms; in 3D the slip direction carries the conditioning of S + l I. */
TEST_EACH(random_blocks, 0, 4) {
  const int d = 2 + _i % 2;
  const double skew = _i < 2 ? 0 : 1e-3, bound = d == 2 ? 1e-14 : 1e-11;
  double worst = 0;
  int several = 0;
  clock_t spent = 0;
  enum { batch = 1000 };
  static double W[9 * batch], q[3 * batch], mu[batch], r[3 * batch];
  for (int n = 0; n < BLOCKS; n += batch) {
    for (int k = 0; k < batch; k++)
      random_block(d, skew, W + d * d * k, q + d * k, mu + k);
    int solved = 0;
    const clock_t start = clock();
    for (int k = 0; k < batch; k++)
      solved += dlsi_nlgs_local(d, W + d * d * k, q + d * k, mu[k], r + d * k, NULL) > 0;
    spent += clock() - start;
    ck_assert_int_eq(solved, batch);
    for (int k = 0; k < batch; k++) {
      const double v = violation(d, W + d * d * k, q + d * k, mu[k], r + d * k);
      if (!(v <= worst)) worst = v;
      double s[3];
      int count = 0;
      if (k % 10 == 0) (void)dlsi_nlgs_local(d, W + d * d * k, q + d * k, mu[k], s, &count);
      several += count > 1;
    }
  }
  printf("%dD, skew %g: %d blocks, worst %.1e, %.0f ns each, several solutions %.2f %%\n", d, skew,
         BLOCKS, worst, 1e9 * (double)spent / CLOCKS_PER_SEC / BLOCKS, 1000.0 * several / BLOCKS);
  ck_assert_msg(worst <= bound, "worst %g", worst);
  if (d == 2 && skew == 0) ck_assert_int_eq(several, 0); /* SPD, q_n < 0: unique in 2D */
}

/* r of a block in turned tangents is the turned r */
TEST(turned_tangents) {
  for (int k = 0; k < 2000; k++) {
    double W[9], q[3], mu, r[3], s[3];
    random_block(3, 0, W, q, &mu);
    for (int i = 0; i < 9; i += 4)
      W[i] += 0.1; /* so that r is well determined */
    const double angle = 6.28 * fraction(), c = cos(angle), t = sin(angle);
    const double Q[9] = {1, 0, 0, 0, c, t, 0, -t, c}; /* column-major */
    double V[9] = {0}, p[3] = {0};
    for (int i = 0; i < 3; i++)
      for (int j = 0; j < 3; j++) {
        p[i] += Q[i + 3 * j] * q[j];
        for (int a = 0; a < 3; a++)
          for (int b = 0; b < 3; b++)
            V[i + 3 * j] += Q[i + 3 * a] * W[a + 3 * b] * Q[j + 3 * b];
      }
    int count;
    const dlsi_local_state state = dlsi_nlgs_local(3, W, q, mu, r, &count);
    if (count > 1) continue; /* which slip is not said */
    ck_assert_int_eq(dlsi_nlgs_local(3, V, p, mu, s, NULL), state);
    for (int i = 0; i < 3; i++) {
      double turned = 0;
      for (int j = 0; j < 3; j++)
        turned += Q[i + 3 * j] * r[j];
      ck_assert(fabs(turned - s[i]) <= 1e-12 * (fabs(r[0]) + fabs(r[1]) + fabs(r[2])));
    }
  }
}

/* Reactions far below those of the neighbours are found as in another unit, and a hair's weight on
 * a candidate that slips fast along the slip. */
TEST(tiny_reactions) {
  for (int k = 0; k < 2000; k++) {
    double W[9], q[3], p[3], mu, r[3], s[3], least[3];
    random_block(3, 0, W, q, &mu);
    const dlsi_local_state state = dlsi_nlgs_local(3, W, q, mu, r, NULL);
    for (int i = 0; i < 3; i++)
      p[i] = ldexp(q[i], -400);
    ck_assert_int_eq(dlsi_nlgs_local(3, W, p, mu, s, NULL), state);
    for (int i = 0; i < 3; i++)
      ck_assert_double_eq_tol(ldexp(s[i], 400), r[i], 1e-11 * fabs(r[0]));
    if (state != DLS_LOCAL_SLIP || hypot(W[1], W[2]) * mu > 0.5 * W[0]) continue;
    p[0] = -1e-200;
    p[1] = q[1];
    p[2] = q[2];
    ck_assert_int_eq(dlsi_nlgs_local(3, W, p, mu, least, NULL), DLS_LOCAL_SLIP);
    const double slip = hypot(q[1], q[2]), e[2] = {-q[1] / slip, -q[2] / slip};
    const double n = 1e-200 / (W[0] + mu * (W[3] * e[0] + W[6] * e[1]));
    ck_assert_double_eq_tol(least[0] / n, 1, 1e-12);
    ck_assert_double_eq_tol(least[1] / n, mu * e[0], 1e-12 * mu);
    ck_assert_double_eq_tol(least[2] / n, mu * e[1], 1e-12 * mu);
  }
}

/* The terms of a block: W = (4 1; 2 3) has the pivot 4, s = 3 - 2/4; (2 1; 4 3) the pivot 4 of its
 * second row, s = 1 - 2/4 3; of equal rows the first one is the pivot. mu = 2. */
TEST(blocks_2d) {
  static const double W[3][4] = {{4, 2, 1, 3}, {2, 4, 1, 3}, {2, -2, 1, 3}};
  static const double inv_pivot[] = {0.25, 0.25, 0.5}, f[] = {0.5, 0.5, -1};
  static const double inv_s[] = {1 / 2.5, -2, 0.25}, slip[3][2] = {{0.5, 1. / 6}, {0, 0.25}};
  for (int k = 0; k < 3; k++) {
    dlsi_block_2d b;
    dlsi_block_2d_set(&b, W[k], k == 0 ? 2 : 1);
    ck_assert_mem_eq(b.W, W[k], sizeof W[k]);
    ck_assert(b.p == (k == 1) && b.mu == (k == 0 ? 2 : 1));
    ck_assert(b.inv_pivot == inv_pivot[k] && b.f == f[k] && b.inv_s == inv_s[k]);
    ck_assert(b.inv_slip[0] == (k == 0 ? slip[0][0] : 1));
    ck_assert(b.inv_slip[1] == (k == 0 ? slip[0][1] : 1. / 3));
  }
}

/* The same in 3D: W_nn = 2, b = (1, 3), c W_nn = (4, 6), B = (5 8; 7 20) by rows, so that S = B - c
 * b^T / 2 = (3 2; 4 11), whose pivot is 4 of the second row; then a B whose S has equal entries in
 * its first column, and a B of zeros, where the size of l is W_nn. */
TEST(blocks_3d) {
  static const double W[3][9] = {
      {2, 4, 6, 1, 5, 7, 3, 8, 20}, {2, 4, 6, 1, 5, 6, 3, 8, 20}, {2, 4, 6, 1, 0, 0, 3, 0, 0}};
  static const double S[3][4] = {{3, 4, 2, 11}, {3, 3, 2, 11}, {-2, -3, -6, -9}};
  static const double det[] = {25, 27, 0}, trace[] = {14, 14, -11}, scale[] = {12.5, 12.5, 2};
  static const double f[] = {0.75, 1, 2. / 3}, u01[] = {11, 2, -9}, pivot[] = {4, 3, -3};
  for (int k = 0; k < 3; k++) {
    dlsi_block_3d b;
    dlsi_block_3d_set(&b, W[k], 0.5);
    ck_assert_mem_eq(b.W, W[k], sizeof W[k]);
    ck_assert_mem_eq(b.S, S[k], sizeof S[k]);
    ck_assert(b.mu == 0.5 && b.inv_a == 0.5 && b.c[0] == 2 && b.c[1] == 3);
    ck_assert(b.det == det[k] && b.trace == trace[k] && b.scale == scale[k]);
    ck_assert(b.p == (k != 1) && b.inv0 == 1 / pivot[k] && b.u01 == u01[k]);
    ck_assert(fabs(b.f - f[k]) <= DBL_EPSILON);
    if (k < 2) ck_assert(b.inv1 == 1 / (k == 0 ? 2 - 0.75 * 11 : 9));
  }
}

/* Without a solution r is the point of the smallest |F|. W = (1 1; c B), q = (-2, 0), mu = 1: r = 0
 * has |F| = 2; the slip r = (1, 1), which friction drives, has u = (0, c + B) and |F| = c + B, or
 * 2 w with w = (1 + B) / 2 if that is less. */
TEST(least_bad_points) {
  static const struct {
    double c, B, mu, r[2];
  } points[] = {{1, .5, 1, {1, 1}}, {2, 1.5, 1, {0, 0}}, {3, 2, 1, {0, 0}}, {1, .5, 3, {.5, 1.5}}};
  for (int k = 0; k < 4; k++)
    for (int side = -1; side <= 1; side += 2) {
      const double W[4] = {1, side * points[k].c, side, points[k].B}, q[2] = {-2, 0};
      double r[2];
      ck_assert_int_eq(dlsi_nlgs_local(2, W, q, points[k].mu, r, NULL), DLS_LOCAL_NONE);
      ck_assert(r[0] == points[k].r[0] && r[1] == side * points[k].r[1]);
    }
  /* W_nn <= 0: r = 0, also where the trace is negative, or all of W is 0 */
  const double V[3][9] = {{-1, 0, 0, 0, 2, 0, 0, 0, 2}, {-1, 0, 0, 0, -1, 0, 0, 0, 0}, {0}};
  for (int k = 0; k < 3; k++)
    for (int mu = 0; mu < 2; mu++) {
      const double p[3] = {-1, 0.5, 0};
      double s[3] = {7, 7, 7};
      ck_assert_int_eq(dlsi_nlgs_local(3, V[k], p, mu, s, NULL), DLS_LOCAL_NONE);
      ck_assert(s[0] == 0 && s[1] == 0 && s[2] == 0);
    }
}

/* r on the edge of the cone with u_t = 0 is stick and slip at once: rounding must not leave it
 * without a state, nor count it twice. */
TEST(edges_of_the_cone) {
  for (int k = 0; k < 4000; k++) {
    const int d = 2 + k % 2;
    double W[9], q[3], mu, r[3];
    int count;
    random_block(d, k % 4 < 2 ? 0 : 1e-3, W, q, &mu);
    for (int i = 0; i < d; i++)
      W[i + d * i] += 0.1;
    if (d == 3 && mu * hypot(W[3], W[6]) > 0.5 * W[0]) continue;
    const double angle = 6.28 * fraction(), sign = k % 8 < 4 ? 1 : -1;
    const double at[3] = {1, d == 2 ? sign * mu : mu * cos(angle), mu * sin(angle)};
    for (int i = 0; i < d; i++) {
      q[i] = 0;
      for (int j = 0; j < d; j++)
        q[i] -= W[i + d * j] * at[j];
    }
    if (!(q[0] < 0)) continue;
    const dlsi_local_state state = dlsi_nlgs_local(d, W, q, mu, r, &count);
    ck_assert_msg(state == DLS_LOCAL_STICK || state == DLS_LOCAL_SLIP, "%d: state %d", k, state);
    ck_assert_int_eq(count, 1);
    assert_near(r, at, d, 1e-12 * (1 + mu));
  }
}

/* u_t = (2.4, 3.2) = -4 r_t: from any guess of 4, and from what is none, the same r. */
TEST(guesses) {
  static const double W[9] = {2, 0, 0, 0, 1, 0, 0, 0, 1}, q[3] = {-2, 3, 4}, r[3] = {1, -.6, -.8};
  static const double guess[] = {0, 4, 4e-3, 4e3, 1e-300, 1e300, -4, NAN, INFINITY, -INFINITY};
  dlsi_block_3d b;
  dlsi_block_3d_set(&b, W, 1);
  for (int k = 0; k < 10; k++) {
    double s[3];
    ck_assert_int_eq(dlsi_local_3d(&b, q, guess[k], s), DLS_LOCAL_SLIP);
    assert_near(s, r, 3, 4 * DBL_EPSILON);
  }
}

/* One unknown: u = W r + q. */
TEST(one_dimension) {
  static const double W[] = {2, 2, 2, -1, -1, 2}, q[] = {-3, 3, 0, 1, -1, -INFINITY};
  static const double r[] = {1.5, 0, 0, 0, 0, 0};
  static const int count[] = {1, 1, 1, 2, 0, 0};
  static const dlsi_local_state state[] = {DLS_LOCAL_STICK, DLS_LOCAL_FREE, DLS_LOCAL_FREE,
                                           DLS_LOCAL_FREE,  DLS_LOCAL_NONE, DLS_LOCAL_NONE};
  for (int k = 0; k < 6; k++) {
    double s[2] = {7, 7};
    int n = -1;
    ck_assert_int_eq(dlsi_nlgs_local(1, W + k, q + k, 0, s, &n), state[k]);
    ck_assert(s[0] == r[k] && s[1] == 7);
    ck_assert_int_eq(n, count[k]);
  }
}
