/* test_renumber.c: the copy of a problem in its own order and units, and auto on it. */
#include "auto/auto.h"
#include "cases.h"
#include "delassus/solve.h"
#include "run.h"

typedef struct copied {
  dlsi_renumber copy;
  dlsi_arena arena;
} copied;

static void make_copy(copied *c, const dls_contact *p) {
  c->arena = (dlsi_arena){0};
  dlsi_renumber_carve(&c->copy, &c->arena, p->d, p->nc);
  ck_assert_int_eq(dlsi_arena_allocate(&c->arena, "nc", p->nc, NULL), DLS_OK);
  dlsi_renumber_carve(&c->copy, &c->arena, p->d, p->nc);
  dlsi_renumber_set(&c->copy, p, INFINITY);
}

static void expect_same_copy(const copied *a, const copied *b) {
  const dls_contact *p = &a->copy.problem, *q = &b->copy.problem;
  const size_t m = (size_t)(p->d * p->nc);
  ck_assert_mem_eq(p->W.a, q->W.a, m * m * sizeof(double));
  ck_assert_mem_eq(p->q, q->q, m * sizeof(double));
  ck_assert_mem_eq(p->mu, q->mu, (size_t)p->nc * sizeof(double));
}

/* Candidates in reverse, odd powers of two, and blocks: the same copy, to the bit. */
TEST_EACH(copies_are_the_same, 0, 20) {
  static model a, b, c;
  static block_storage B;
  copied one, two, three;
  numbered_model(&a, _i);
  reverse_model(&b, &a);
  scale_model(&c, &b, 0x1p-7, 0x1p20);
  const dls_contact blocks = by_blocks(&c, &B);
  make_copy(&one, &a.p);
  make_copy(&two, &c.p);
  make_copy(&three, &blocks);
  expect_same_copy(&one, &two);
  expect_same_copy(&one, &three);
  const int m = a.p.d * a.p.nc;
  double x[most], back[most];
  for (int k = 0; k < m; k++) /* q, in the order of the problem again */
    x[k] = one.copy.q[k];
  dlsi_renumber_back(&one.copy, a.p.d, one.copy.power_q, x, back);
  ck_assert_mem_eq(back, a.q, (size_t)m * sizeof *back);
  free(one.arena.base);
  free(two.arena.base);
  free(three.arena.base);
}

/* The largest |W| and |q| lie between 1 and 2 in the copy; of 0 no power is divided out. */
TEST(powers_of_two) {
  static model a;
  set_model(&a, 2, 2);
  for (int k = 0; k < 3; k++) {
    copied c;
    a.W[1 + a.p.W.ld * 2] = k > 0 ? -24 : 0;
    a.q[3] = k > 1 ? -0.375 : 0;
    make_copy(&c, &a.p);
    ck_assert_int_eq(c.copy.power_W, k > 0 ? 4 : 0);
    ck_assert_int_eq(c.copy.power_q, k > 1 ? -2 : 0);
    double W = 0, q = 0;
    for (int e = 0; e < 16; e++)
      W += c.copy.W[e];
    for (int e = 0; e < 4; e++)
      q += c.copy.q[e];
    ck_assert(W == (k > 0 ? -1.5 : 0) && q == (k > 1 ? -1.5 : 0));
    free(c.arena.base);
  }
}

/* A ring of candidates that nothing tells apart but their neighbours, in two orders. */
TEST(equal_candidates_are_told_apart_by_neighbours) {
  enum { nc = 6 };
  static model a[2];
  static const int place[2][nc] = {{0, 1, 2, 3, 4, 5}, {3, 0, 5, 1, 4, 2}};
  copied c[2];
  for (int k = 0; k < 2; k++) {
    set_model(&a[k], 2, nc);
    for (int i = 0; i < nc; i++) {
      const int at = 2 * place[k][i], next = 2 * place[k][(i + 1) % nc];
      const double coupling = i < 3 ? 0.5 : 0.25;
      a[k].q[at] = -1;
      for (int e = 0; e < 2; e++) {
        a[k].W[at + e + a[k].p.W.ld * (at + e)] = 2;
        a[k].W[at + e + a[k].p.W.ld * (next + e)] = coupling;
        a[k].W[next + e + a[k].p.W.ld * (at + e)] = coupling;
      }
    }
    make_copy(&c[k], &a[k].p);
  }
  expect_same_copy(&c[0], &c[1]);
  free(c[0].arena.base);
  free(c[1].arena.base);
}

/* Candidates that nothing tells apart but their q_n, by less than an order by size sees, the sign
 * of their q_t, or their friction, in two orders. */
TEST_EACH(equal_candidates_are_told_apart_by_loads, 0, 3) {
  enum { nc = 4 };
  static model a[2];
  static const int place[2][nc] = {{0, 1, 2, 3}, {2, 3, 1, 0}};
  copied c[2];
  for (int k = 0; k < 2; k++) {
    set_model(&a[k], 2, nc);
    for (int i = 0; i < nc; i++) {
      const int at = place[k][i];
      for (int e = 0; e < 2; e++)
        a[k].W[2 * at + e + a[k].p.W.ld * (2 * at + e)] = 2;
      a[k].q[2 * at] = _i == 0 ? -1 - i * 0x1p-40 : -1;
      a[k].q[2 * at + 1] = _i == 1 && i % 2 ? -1 : 1;
      a[k].mu[at] = _i == 2 ? 0.125 * i : 0.5;
    }
    make_copy(&c[k], &a[k].p);
  }
  expect_same_copy(&c[0], &c[1]);
  free(c[0].arena.base);
  free(c[1].arena.base);
}

/* By hand, unsymmetric, with blocks of one place that add up and one that is missing: W over 2^2,
 * its largest entry being 7, q over 2^-2 (0.375), in the order that `from` tells, which names each
 * once. */
TEST(a_copy_by_hand) {
  const double W[3][3] = {{5, 0, -7}, {2, 3, 0.5}, {0, 6, 4}}, q[3] = {0.25, -0.375, 0.125};
  const int p[4] = {0, 2, 4, 7}, i[7] = {0, 1, 2, 1, 2, 0, 2};
  const double x[7] = {5, 2, 6, 3, 1, -7, 3}, mu[3] = {0, 0, 0};
  double dense[4 * 3];
  for (int e = 0; e < 9; e++)
    dense[e % 3 + 4 * (e / 3)] = e == 7 ? 0 : W[e % 3][e / 3];
  const dls_contact problem[2] = {{.d = 1, .nc = 3, .W = {3, 3, 4, dense}, .q = q, .mu = mu},
                                  {.d = 1, .nc = 3, .Wb = {1, 3, p, i, x}, .q = q, .mu = mu}};
  for (int k = 0; k < 2; k++) {
    copied c;
    int seen[3] = {0};
    double back[3];
    make_copy(&c, &problem[k]);
    const int *from = c.copy.from;
    ck_assert(c.copy.power_W == 2 && c.copy.power_q == -2);
    ck_assert(c.copy.problem.d == 1 && c.copy.problem.nc == 3 && c.copy.problem.W.ld == 3);
    for (int a = 0; a < 3; a++) {
      seen[from[a]]++;
      ck_assert(c.copy.q[a] == 4 * q[from[a]]);
      for (int b = 0; b < 3; b++) {
        const int is_none = from[a] == 1 && from[b] == 2;
        ck_assert(c.copy.W[a + 3 * b] == (is_none ? 0 : W[from[a]][from[b]] / 4));
      }
    }
    ck_assert(seen[0] == 1 && seen[1] == 1 && seen[2] == 1);
    dlsi_renumber_back(&c.copy, 1, -2, c.copy.q, back);
    ck_assert_mem_eq(back, q, sizeof back);
    free(c.arena.base);
  }
}

/* Nothing but zeros has no unit; a power of two is its own. */
TEST(units_of_the_copy) {
  static const double largest[3] = {0, 4, 0x1p-1074}, over[3] = {0, 2, -1074};
  for (int k = 0; k < 3; k++) {
    const double W[4] = {0, 0, 0, -largest[k]}, q[2] = {0, -largest[k]}, mu = 0.5;
    const dls_contact problem = {.d = 2, .nc = 1, .W = {2, 2, 2, W}, .q = q, .mu = &mu};
    copied c;
    make_copy(&c, &problem);
    ck_assert(c.copy.power_W == over[k] && c.copy.power_q == over[k]);
    ck_assert(c.copy.W[3] == (k ? -1 : 0) && c.copy.q[1] == (k ? -1 : 0) && c.copy.mu[0] == 0.5);
    free(c.arena.base);
  }
}

/* Candidates that one thing tells apart: u_n of one that moves another, or is moved by it; a
 * coupling of n and t in one block; the second tangent; in any order the same copy. */
TEST_EACH(one_entry_tells_apart, 0, 5) {
  static const int place[3][4] = {{0, 1, 2, 3}, {2, 3, 1, 0}, {1, 0, 3, 2}};
  static const int entry[5][4] = {/* candidate, row, candidate, column */
                                  {0, 0, 1, 0},
                                  {0, 0, 1, 2},
                                  {2, 1, 2, 0},
                                  {2, 2, 2, 2},
                                  {3, 0, 0, 1}};
  static model a;
  copied c[3];
  for (int k = 0; k < 3; k++) {
    set_model(&a, 3, 4);
    for (int e = 0; e < 12; e++) {
      a.W[e + a.p.W.ld * e] = 2;
      a.q[e] = e % 3 == 0 ? -1 : 0;
    }
    for (int b = 0; b < 4; b++)
      a.mu[b] = 0.5;
    const int *at = entry[_i], *to = place[k];
    a.W[3 * to[at[0]] + at[1] + a.p.W.ld * (3 * to[at[2]] + at[3])] += 0.25;
    make_copy(&c[k], &a.p);
    if (k) expect_same_copy(&c[0], &c[k]);
  }
  for (int k = 0; k < 3; k++)
    free(c[k].arena.base);
}

/* W = B B' of whole numbers and low rank, much friction; any q, so that some have no solution. */
static void hard_model(model *a, int i) {
  set_seed((uint64_t)i + 1);
  const int d = 2 + i % 2, nc = 2 + i % 4, m = d * nc, rank = 1 + m / 3;
  double B[20][20];
  set_model(a, d, nc);
  for (int e = 0; e < m; e++) {
    a->q[e] = floor(8 * uniform());
    for (int k = 0; k < rank; k++)
      B[e][k] = floor(4 * uniform());
  }
  for (int c = 0; c < nc; c++)
    a->mu[c] = 3 + floor(3 * uniform());
  for (int e = 0; e < m; e++)
    for (int f = 0; f < m; f++)
      for (int k = 0; k < rank; k++)
        a->W[e + a->p.W.ld * f] += B[e][k] * B[f][k];
}

/* Verdicts of auto do not depend on the order of the candidates, nor on odd powers of two. */
TEST_EACH(order_keeps_the_verdict, 0, 24) {
  static model a, b, c;
  double r[most];
  dls_info one, two, three;
  hard_model(&a, _i);
  reverse_model(&b, &a);
  scale_model(&c, &a, 0x1p-3, 0x1p8);
  ck_assert_int_ge(dls_solve(&a.p, NULL, r, NULL, &one, NULL), 0);
  ck_assert_int_ge(dls_solve(&b.p, NULL, r, NULL, &two, NULL), 0);
  ck_assert_int_ge(dls_solve(&c.p, NULL, r, NULL, &three, NULL), 0);
  ck_assert_int_eq(one.status, two.status);
  ck_assert_int_eq(one.status, three.status);
}

/* What auto gives back unsolved is the best r of all stages, those on the copy and those before:
 * problems of random numbers, of which some are not solved. Residuals of a copy are rounded, as the
 * floors say. */
TEST(unsolved_gives_the_best_of_all_stages) {
  static model a;
  int unsolved = 0;
  for (int k = 0; k < 30; k++) {
    double r[most];
    dls_info info;
    set_seed(101 + (uint64_t)k);
    set_model(&a, 2, 6);
    for (int e = 0; e < 144; e++)
      a.W[e] = uniform() + (e % 13 == 0 ? k % 2 : 0);
    for (int i = 0; i < 12; i++)
      a.q[i] = uniform();
    for (int c = 0; c < 6; c++)
      a.mu[c] = 0.75 + 0.75 * uniform();
    const dls_status status = dls_solve(&a.p, NULL, r, NULL, &info, NULL);
    if (status <= 0 || status == DLS_TO_ROUNDING) continue; /* the smaller rounding wins there */
    const dls_certificate *c = &info.certificate;
    const double rounding = 4 * fmax(c->floor_u, c->floor_r);
    ck_assert_double_le(rounding, 1e-6);
    unsolved++;
    for (int stage = 0; stage < info.stages; stage++)
      ck_assert_double_le(c->residual, (1 + 1e-9) * info.stage[stage].residual + rounding);
  }
  ck_assert_int_ge(unsolved, 5);
}
