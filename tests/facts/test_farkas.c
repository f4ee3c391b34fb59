/* test_farkas.c: the linear problem that every solution solves: what it proves and excludes. */
#include "cases.h"
#include "delassus/solve.h"
#include "facts/facts.h"
#include "made.h"
#include "run.h"

/* Two candidates that a bar presses apart: W_nn = (1 -1; -1 1 + e), q_n = -1: no solution for e =
 * 0, one at a distance of 2 / e else. */
static void pressed(model *a, int d, double e) {
  set_model(a, d, 2);
  for (int c = 0; c < 2; c++) {
    a->q[d * c] = -1;
    a->mu[c] = 0.5;
    for (int i = 0; i < d; i++)
      a->W[d * c + i + a->p.W.ld * (d * c + i)] = 1;
  }
  a->W[a->p.W.ld * d] = a->W[d] = -1;
  a->W[d + a->p.W.ld * d] += e;
}

static dls_status solve_pressed(const model *a, dls_method method, int *has_proof) {
  double r[6];
  dls_solver_settings s = settings_with(method, default_tol);
  dls_solver *solver = solver_of(a->p.d, 2, &s);
  const dls_status status = dls_solver_solve(solver, &a->p, r, NULL, NULL, NULL);
  *has_proof = dls_solver_farkas(solver) != NULL;
  dls_solver_destroy(solver);
  return status;
}

TEST_EACH(no_solution_is_proved_in_2d_and_3d, 0, 4) {
  static model a;
  const dls_method method[] = {DLS_AUTO, DLS_LEMKE};
  int proof;
  pressed(&a, 2 + _i / 2, 0);
  ck_assert_int_eq(solve_pressed(&a, method[_i % 2], &proof), DLS_NO_SOLUTION);
  ck_assert_int_eq(proof, 1);
  pressed(&a, 2 + _i / 2, 0x1p-10); /* near enough */
  ck_assert_int_eq(solve_pressed(&a, method[_i % 2], &proof), DLS_OK);
  ck_assert_int_eq(proof, 0);
}

/* With e = 2^-40 the solution of size 2^41 exists and has a floor that no tolerance of 1e-8
 * allows: auto neither denies it nor searches beyond the 20 first iterations in 3D, but ends with a
 * run of Lemke's method, and proves it: within 7e-6, and within 1e-2, which is too much, where long
 * double has 53 bits. */
TEST_EACH(far_is_not_denied_nor_searched, 0, 2) {
  static model a;
  dls_info info;
  double r[6];
  const volatile long double one = 1, half = LDBL_EPSILON;
  const int extended = LDBL_MANT_DIG > DBL_MANT_DIG && one + half > one;
  pressed(&a, 2 + _i, 0x1p-40);
  ck_assert_int_eq(dls_solve(&a.p, NULL, r, NULL, &info, NULL),
                   extended ? DLS_TO_ROUNDING : DLS_STALLED);
  dls_proof proof;
  ck_assert_int_eq(dls_contact_prove(&a.p, r, &proof, NULL, NULL), DLS_OK);
  ck_assert_int_eq(proof.kind, DLS_PROVED);
  for (int k = 0; k < info.stages; k++)
    ck_assert(info.stage[k].method != DLS_HOMOTOPY || (_i == 1 && info.stage[k].iterations <= 20));
  ck_assert_int_eq(info.stage[info.stages - 1].method, DLS_LEMKE);
  ck_assert_int_le(info.stages, 6 + 3 * _i); /* 3D: the augmented Lagrangian, too */
}

/* Whatever v says: a problem whose answer is certified is never excluded. */
TEST_EACH(certified_is_never_excluded, 0, 10) {
  static model a;
  double r[most], w[most], v[most];
  dls_info info;
  deficient_model(&a, _i);
  ck_assert_int_eq(dls_solve(&a.p, NULL, r, NULL, &info, NULL), DLS_OK);
  dlsi_contact_weights(&a.p, w);
  for (int k = 0; k < 1000; k++) {
    for (int c = 0; c < a.p.nc; c++)
      v[c] = k % 3 && uniform() < 0 ? 0 : exp(5 * uniform());
    ck_assert_int_eq(dlsi_farkas_excludes(&a.p, w, v, 1e-8), 0);
  }
}

/* (FA3) by hand, W = 1 but for e: v = (1, 1) has g = (0, e), so that R e / w < 2 excludes. */
TEST(exclusion_by_hand) {
  static model a;
  const double v[2] = {1, 1}, w[2] = {1, 1}, bad[2] = {1, 0};
  pressed(&a, 2, 0x1p-26);
  ck_assert_int_eq(dlsi_farkas_excludes(&a.p, w, v, 1e-8), 1);
  ck_assert_int_eq(dlsi_farkas_excludes(&a.p, w, v, 1e-6), 0); /* a larger floor is allowed */
  ck_assert_int_eq(dlsi_farkas_excludes(&a.p, w, bad, 1e-8), 0);
  pressed(&a, 2, 0x1p-20);
  ck_assert_int_eq(dlsi_farkas_excludes(&a.p, w, v, 1e-8), 0);
}

/* (FA3) of one candidate with v = 1, q = (-1, 0), at both sides of its edge: W_nn = 1, x = g / w,
 * excludes for x C / (4 eps) < 1 but for C = 1e-8, and W_nn = -1 for C (sqrt(1 + mu^2) + x + 1) <
 * 1. */
TEST(edge_of_exclusion) {
  static model a;
  const double v[] = {1}, far = 4 * DBL_EPSILON / 1e-8;
  for (int side = -1; side <= 1; side += 2) {
    set_model(&a, 2, 1);
    a.q[0] = -1;
    a.W[0] = 1;
    double w[] = {1 / ((1 + 0.01 * side) * far)};
    ck_assert_int_eq(dlsi_farkas_excludes(&a.p, w, v, 1e-8), side < 0);
    a.W[0] = -1;
    w[0] = 1 / (2 + 0.02 * side);
    ck_assert_int_eq(dlsi_farkas_excludes(&a.p, w, v, 0.25), side < 0);
    a.mu[0] = 0.75;
    w[0] = 1 / (1.75 + 0.02 * side);
    ck_assert_int_eq(dlsi_farkas_excludes(&a.p, w, v, 0.25), side < 0);
  }
}

/* (FA2) where rows n of W tell the edges: W_ab has row n e_a for each b. The middle candidate slips
 * freely. */
TEST_EACH(linear_problem_by_hand, 0, 2) {
  static model a;
  const int d = 2 + _i, edges = d == 2 ? 2 : 8, n = 3 + 2 * edges + 1;
  const double s[3] = {2, 0.5, 4}, unit = 8;
  double M[22 * 22], q[22], column[9];
  set_model(&a, d, 3);
  for (int b = 0; b < 3; b++) {
    a.mu[b] = b == 1 ? 0 : 0.5 + b;
    a.q[d * b] = b - 3;
    for (int i = 0; i < d; i++)
      a.W[d * i + a.p.W.ld * (d * b + i)] = 1;
  }
  ck_assert_int_eq(dlsi_farkas_size(&a.p), n);
  memset(M, 9, sizeof M);
  dlsi_farkas_lcp(&a.p, s, unit, M, q, column);
  for (int j = 0; j < n; j++) {
    const double own = j < 3 ? s[j] * (j - 3) / unit : 0.75; /* the largest of the first three */
    ck_assert_double_eq_tol(q[j], own, 1e-15);
    for (int i = 0; i < n; i++) {
      ck_assert(M[i + n * j] == -M[j + n * i]);
      if ((i < 3) == (j < 3)) ck_assert(M[i + n * j] == 0);
    }
  }
  for (int b = 0, j = 3; b < 3; b++) {
    const double mu = a.mu[b];
    double sum[3] = {0}, last[3] = {0};
    for (int k = 0; k < (b == 1 ? 1 : edges); k++, j++) {
      double edge[3] = {0}, middle[3] = {0};
      for (int i = 0; i < d; i++) {
        edge[i] = M[i + n * j] * unit / (s[i] * s[b]);
        middle[i] = (edge[i] + last[i]) / 2;
        sum[i] += edge[i];
        last[i] = edge[i];
      }
      ck_assert_double_eq_tol(edge[0], 1, 1e-15);
      if (d == 2) ck_assert_double_eq_tol(fabs(edge[1]), mu, 1e-15);
      if (d == 2 || k == 0) continue;
      /* the side between two edges touches the round cone, from without */
      ck_assert_double_ge(hypot(middle[1], middle[2]), mu * (1 - 4 * DBL_EPSILON));
      ck_assert_double_le(hypot(middle[1], middle[2]), mu * (1 + 1e-15));
    }
    ck_assert_double_eq_tol(hypot(sum[1], sum[2]), 0, 1e-14); /* they go all around */
  }
}
