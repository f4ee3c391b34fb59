/* test_cone.c: the algebra of the Lorentz cone, and the scales that make friction cones such. */
#include "vi/cone.h"

#include "cases.h"
#include "run.h"

/* x o y by hand, and back; x_0^2 - |x_1|^2. */
TEST(products) {
  const double x[3] = {4, 1, 2}, y[3] = {3, -1, 5}, of_3[3] = {21, -1, 26}, of_2[2] = {11, -1};
  double z[3] = {7, 7, 7}, back[3] = {7, 7, 7};
  ck_assert(dlsi_cone_dot(3, x, y) == 21 && dlsi_cone_dot(2, x, y) == 11);
  dlsi_cone_product(2, x, y, z);
  ck_assert(memcmp(z, of_2, sizeof of_2) == 0 && z[2] == 7);
  dlsi_cone_divide(2, x, z, back);
  ck_assert(back[0] == 3 && back[1] == -1 && back[2] == 7);
  dlsi_cone_product(3, x, y, z);
  ck_assert_mem_eq(z, of_3, sizeof z);
  dlsi_cone_divide(3, x, z, back);
  assert_near(back, y, 3, 1e-15);
  const double far[3] = {7, 3, 4};
  ck_assert(dlsi_cone_det(2, x) == 15 && dlsi_cone_det(3, far) == 24);
}

/* P x = P^-1 z, P^-1 P = 1, and P is eta [w_0, w_1'; w_1, I + w_1 w_1' / (1 + w_0)]. */
TEST(scaling_of_nesterov_and_todd) {
  set_seed(3);
  for (int trial = 0; trial < 50; trial++) {
    const int d = 2 + trial % 2;
    double x[3], z[3], w[3], eta, to[2][3], back[3];
    for (int k = 0; k < 2; k++) {
      double *v = k ? z : x;
      for (int i = 1; i < 3; i++)
        v[i] = uniform();
      v[0] = (d == 2 ? fabs(v[1]) : hypot(v[1], v[2])) + .1 + fabs(uniform());
      for (int i = 0; i < d; i++)
        v[i] *= exp2(k ? 3 : -2);
    }
    ck_assert_int_eq(dlsi_cone_between(d, x, z, &eta, w), 1);
    dlsi_cone_scale(d, eta, w, 0, x, to[0]);
    dlsi_cone_scale(d, eta, w, 1, z, to[1]);
    dlsi_cone_scale(d, eta, w, 1, to[0], back);
    for (int i = 0; i < d; i++) {
      double row = 0;
      for (int j = 0; j < d; j++)
        row += eta * x[j] * (i == 0 || j == 0 ? w[i + j] : (i == j) + w[i] * w[j] / (1 + w[0]));
      ck_assert_double_eq_tol(to[0][i], row, 1e-13);
      ck_assert_double_eq_tol(to[0][i], to[1][i], 1e-13);
      ck_assert_double_eq_tol(back[i], x[i], 1e-13);
    }
  }
}

/* On the border, and in the opposite cone, of either vector. */
TEST(not_inside) {
  static const double in[2] = {5, 3}, out[3][2] = {{5, 5}, {-5, 3}, {3, -5}};
  double eta, w[2];
  for (int k = 0; k < 3; k++)
    ck_assert(!dlsi_cone_between(2, in, out[k], &eta, w) &&
              !dlsi_cone_between(2, out[k], in, &eta, w));
  ck_assert(!dlsi_cone_between(2, out[1], out[1], &eta, w));
  ck_assert(dlsi_cone_between(2, in, in, &eta, w) && eta == 1 && w[0] == 1 && w[1] == 0);
}

/* From (2, 0): across the border, through the apex, along a side, out through it, never. */
TEST(largest_step) {
  static const double dx[8][2] = {{-1, 1}, {0, 1},   {1, 2}, {-1, 0},
                                  {1, 1},  {-1, -1}, {1, 0}, {-4, .5}};
  static const double step[8] = {1, 2, 2, 2, INFINITY, 1, INFINITY, 4 / 9.};
  for (int k = 0; k < 8; k++)
    for (int side = 1; side <= 2; side++) {
      const double x[3] = {2, 0, 0},
                   turned[3] = {dx[k][0], side == 1 ? dx[k][1] : 0, side == 2 ? -dx[k][1] : 0};
      const double found = dlsi_cone_step(3, x, turned);
      ck_assert_msg(found == step[k] || fabs(found - step[k]) <= 1e-15, "%d: %g", k, found);
      if (side == 1) ck_assert(dlsi_cone_step(2, x, turned) == found);
    }
  const double x[3] = {5, 3, 0}, to_4[3] = {0, .25, 0}, back[3] = {0, -1, 0}, up[3] = {0, 0, 1};
  ck_assert(dlsi_cone_step(3, x, to_4) == 8 && dlsi_cone_step(3, x, back) == 8);
  ck_assert(dlsi_cone_step(3, x, up) == 4);
}

/* (1/mu, 1, 1), or (1, 0, 0): the means of the scaled diagonals are 1, 4 and 0, of which the
 * first gets 4, too, and the last one, which has none, stays. */
TEST(scales_by_hand) {
  const double diagonal[9] = {.25, 1, 1, 12, 5, 6, 0, 0, 0}, mu[3] = {.5, 0, 2};
  static const double expected[9] = {4, 2, 2, 1, 0, 0, .5, 1, 1};
  double W[81], S[10], scratch[4];
  for (int k = 0; k < 81; k++)
    W[k] = k % 10 == 0 ? diagonal[k / 10] : 9;
  S[9] = scratch[3] = 7;
  const dls_contact problem = {.d = 3, .nc = 3, .W = {9, 9, 9, W}, .mu = mu};
  ck_assert_double_eq_tol(dlsi_cone_scales(&problem, scratch, S), 4, 1e-15);
  assert_near(S, expected, 9, 1e-15);
  ck_assert(S[9] == 7 && scratch[3] == 7);
}
