/* test_alone.c: problems that auto answers from r = 0 without a workspace, and its report. */
#include "auto/auto.h"
#include "run.h"

enum { most_nc = 21, most_m = 3 * most_nc };

/* W = 2 I of nc candidates, dense and by blocks: one block a column, or with `halves` the first
 * column in two. */
typedef struct alone_problem {
  int p[most_nc + 1], i[most_nc + 1];
  double W[most_m * most_m], x[9 * (most_nc + 1)], q[most_m], mu[most_nc];
  dls_contact dense, blocks;
} alone_problem;

static alone_problem t;
static double r[most_m], u[most_m];
static dls_info info;

static void set_alone(int d, int nc, int halves) {
  const int m = d * nc;
  int k = 0;
  t = (alone_problem){.p = {0}};
  for (int c = 0; c < nc; c++) {
    for (int piece = 0; piece < (halves && c == 0 ? 2 : 1); piece++, k++) {
      t.i[k] = c;
      for (int e = 0; e < d; e++)
        t.x[d * d * k + e * (d + 1)] = halves && c == 0 ? 1 : 2;
    }
    t.p[c + 1] = k;
  }
  for (int e = 0; e < m; e++) {
    t.W[e * (m + 1)] = 2;
    r[e] = u[e] = 77;
  }
  t.dense = (dls_contact){.d = d, .nc = nc, .W = {m, m, m, t.W}, .q = t.q, .mu = t.mu};
  t.blocks = (dls_contact){.d = d, .nc = nc, .Wb = {d, nc, t.p, t.i, t.x}, .q = t.q, .mu = t.mu};
  memset(&info, 0x55, sizeof info);
}

static int solves(const dls_contact *problem) {
  const int answered = dlsi_alone_solve(problem, 1e-8, r, u, &info);
  const int m = problem->d * problem->nc;
  for (int k = 0; k < m && !answered; k++)
    ck_assert(r[k] == 77 && u[k] == 77); /* nothing has been written */
  return answered;
}

/* (AL1) r = 0 where nothing is pressed, of any size and storage. */
TEST(nothing_is_pressed) {
  set_alone(3, most_nc, 0);
  t.q[3] = 5;
  t.q[4] = -1;
  ck_assert(solves(&t.dense));
  for (int k = 0; k < most_m; k++)
    ck_assert(r[k] == 0 && u[k] == t.q[k]);
  ck_assert(info.status == DLS_OK && info.method == DLS_AUTO);
  ck_assert(info.iterations == 0 && info.stages == 0 && info.ambiguous == 0);
  ck_assert(info.certificate.residual == 0 && info.certificate.floor_u == 0);
  t.q[3] = t.q[4] = 0;
  ck_assert(solves(&t.blocks) && info.certificate.floor_u == 0);
  ck_assert(dlsi_alone_solve(&t.blocks, 1e-8, r, NULL, NULL));
}

/* (AL2) One is pressed by less than the rounding of what stands open beside it. */
TEST(pressed_by_rounding) {
  set_alone(2, 3, 0);
  t.q[0] = 1;
  t.q[4] = -1e-30;
  ck_assert(solves(&t.dense));
  for (int k = 0; k < 6; k++)
    ck_assert(k == 4 ? r[k] == 5e-31 && u[k] == 0 : r[k] == 0 && u[k] == t.q[k]);
  ck_assert(info.iterations == 1 && info.certificate.residual == 0);
  t.q[4] = -1e-3;
  t.W[4] = t.W[24] = 1; /* r of candidate 2 opens candidate 0 further */
  ck_assert(solves(&t.dense) && info.iterations == 1 && r[4] == 5e-4 && u[4] == 0);
}

/* (AL2) One sweep: r = -q / 2 within the cone, of as many candidates as there may be. */
TEST(each_alone) {
  for (int d = 1; d <= 3; d++)
    for (int nc = 20; nc <= 21; nc++) {
      set_alone(d, nc, 0);
      for (int c = 0; c < nc; c++) {
        t.q[d * c] = c % 4 == 3 ? 8 : -2 - c;
        t.mu[c] = d > 1;
        for (int e = 1; e < d; e++)
          t.q[d * c + e] = c % 4 == 3 ? 0 : 0.5 * e;
      }
      ck_assert_int_eq(solves(&t.blocks), nc == 20);
      if (nc > 20) continue;
      for (int k = 0; k < d * nc; k++) {
        ck_assert(r[k] == (k / d % 4 == 3 ? 0 : -t.q[k] / 2));
        ck_assert(u[k] == t.q[k] + 2 * r[k]);
      }
      ck_assert(info.method == DLS_AUTO && info.iterations == 1 && info.stages == 1);
      ck_assert(info.stage[0].method == DLS_NLGS && info.stage[0].iterations == 1);
      ck_assert(info.certificate.residual == 0 && info.stage[0].residual == 0);
      ck_assert(info.certificate.floor_u > 0 && info.ambiguous == 0);
    }
}

/* Two that are pressed are answered only if each has its own block and no other: W dense, or a
 * column of two blocks, goes to the sweeps, whichever of both comes first. */
TEST(two_that_may_be_coupled) {
  for (int halves = 0; halves < 2; halves++)
    for (int first = 0; first < 2; first++)
      for (int second = 0; second < 2; second++) {
        set_alone(1, 3, halves);
        t.q[0] = first ? -1 : 1;
        t.q[1] = second ? -1 : 1;
        t.q[2] = first ? 1 : -1;
        ck_assert_int_eq(solves(&t.blocks), !(halves && first && second));
        set_alone(1, 3, 0);
        t.q[0] = first ? -1 : 1;
        t.q[1] = second ? -1 : 1;
        t.q[2] = first ? 1 : -1;
        ck_assert_int_eq(solves(&t.dense), !second);
      }
  set_alone(1, 2, 0); /* one block a column, but not its own */
  t.i[0] = 1, t.i[1] = 0;
  t.q[0] = -1;
  ck_assert(!solves(&t.blocks));
}

/* A reaction that presses another one; W_cc without a positive trace; bodies. */
TEST(left_to_the_sweeps) {
  set_alone(1, 2, 0);
  t.q[0] = -2;
  t.q[1] = 0.5;
  t.W[1] = -1;
  ck_assert(!solves(&t.dense)); /* u_1 = 0.5 - 1 */
  t.W[1] = -0.5;
  ck_assert(solves(&t.dense) && r[0] == 1 && u[1] == 0);
  set_alone(1, 2, 0);
  t.q[0] = -2;
  t.W[0] = -2;
  ck_assert(!solves(&t.dense));
  t.W[0] = 0;
  ck_assert(!solves(&t.dense));
  set_alone(2, 2, 0); /* r_n = 1 is a solution, in a block of trace 0 */
  t.q[0] = -2;
  t.W[5] = -2;
  ck_assert(!solves(&t.dense));
  const int body[2] = {0, -1};
  const double H[6] = {1};
  double work[6];
  set_alone(1, 1, 0);
  dls_contact of = t.dense;
  of.W = (dls_dense){0};
  of.bodies = (dls_bodies){3, 1, body, H, work};
  t.q[0] = 1;
  ck_assert(solves(&of) && r[0] == 0);
  r[0] = u[0] = 77;
  t.q[0] = -1;
  ck_assert(!solves(&of));
}

/* W_cc = (1 -1/2; -1/2 1), mu = 4, q_c = (1, -4): beside r_c = 0 there is r_c = (1, 4), u_c = (0,
 * -1/2). Told only where something is pressed. */
TEST(answers_are_counted) {
  static const double block[4] = {1, -0.5, -0.5, 1};
  for (int pressed = 0; pressed < 2; pressed++) {
    set_alone(2, 2, 0);
    t.q[0] = pressed ? -1 : 1;
    t.q[2] = 1, t.q[3] = -4;
    t.mu[1] = 4;
    memcpy(t.x + 4, block, sizeof block);
    ck_assert(solves(&t.blocks) && r[2] == 0);
    ck_assert_int_eq(info.ambiguous, pressed);
  }
}
