/* test_unique.c: what W proves about other answers (vi/unique.c, dlsi_may_be_ambiguous of
 * vi/sweep/ambiguous.c), on both sides of bounds worked by hand, in any units. */
#include "cases.h"
#include "delassus/nlgs.h"
#include "run.h"
#include "vi/vi_internal.h"

static const double units[] = {0x1p-40, 1, 0x1p40};

/* W, mu of one candidate, w = 1, d from 1 to 3. */
static int one_is_unique(int d, const double *W, double mu) {
  const double q[3] = {-1, 0, 0}, w[1] = {1};
  double row[1];
  const dls_contact p = {.d = d, .nc = 1, .W = {d, d, d, W}, .q = q, .mu = &mu};
  return dlsi_is_unique(&p, w, row, NULL);
}

/* (UN3) W_cc = diag(4, 1, 9) and g, g' beside the diagonal: the tangents' least eigenvalue is > 0
 * for |g + g'| < 2 * 3, and that of n and the smaller tangent for |g + g'| < 2 * 2. */
TEST_EACH(each_pair_of_directions, 0, 3) {
  static const int pair[3][2] = {{0, 1}, {0, 2}, {1, 2}};
  const int i = pair[_i][0], j = pair[_i][1];
  const double bound = _i < 2 ? 2 : 3;
  for (int skew = -1; skew <= 1; skew++)
    for (int side = -1; side <= 1; side += 2) {
      double W[9] = {4, 0, 0, 0, 1, 0, 0, 0, 9};
      W[i + 3 * j] = bound * (1 + 0.01 * side) + skew;
      W[j + 3 * i] = bound * (1 + 0.01 * side) - skew;
      ck_assert_int_eq(one_is_unique(3, W, 0), side < 0);
      const double V[4] = {4, 2 * (1 + 0.01 * side) + skew, 2 * (1 + 0.01 * side) - skew, 1};
      ck_assert_int_eq(one_is_unique(2, V, 0), side < 0);
    }
}

/* (UN3) W_n coupled with both tangents; friction beside |W_t| = (2^2 + 1 + 9^2 + 5^2)^1/2. */
TEST(directions_together) {
  for (int side = -1; side <= 1; side += 2) {
    const double g = sqrt(2) * (1 + 0.01 * side);
    const double W[9] = {4, g, g, g, 1, 0, g, 0, 9};
    ck_assert_int_eq(one_is_unique(3, W, 0), side < 0);
    const double V[9] = {4, 2, -5, -2, 1, 0, 5, 0, 9};
    ck_assert_int_eq(one_is_unique(3, V, (1 + 0.01 * side) / sqrt(111)), side < 0);
  }
}

/* (UN3) of two candidates, I and 4 I, that a block of b couples: in scaled rows 1 - mu |I_t| and
 * (|B| + mu |B_t|) / 2. */
TEST_EACH(two_candidates, 0, 3) {
  const int d = 1 + _i;
  const double mu[2] = {0.1, 0.1}, q[6] = {0}, w[2] = {1, 4};
  const double bound = 2 * (1 - 0.1 * sqrt(d - 1)) / (d + 0.1 * sqrt(d * (d - 1)));
  for (int side = -1; side <= 1; side += 2) {
    double W[36] = {0}, row[2];
    const dls_contact p = {.d = d, .nc = 2, .W = {2 * d, 2 * d, 2 * d, W}, .q = q, .mu = mu};
    for (int i = 0; i < d; i++) {
      W[i + 2 * d * i] = 1;
      W[d + i + 2 * d * (d + i)] = 4;
      for (int j = 0; j < d; j++)
        W[i + 2 * d * (d + j)] = W[d + i + 2 * d * j] = bound * (1 + 0.01 * side);
    }
    ck_assert_int_eq(dlsi_is_unique(&p, w, row, NULL), side < 0);
  }
}

/* (UN2) 2 and g from one to the next, in whichever half: definite for |g| < 2 sqrt(2), where the
 * middle row is not dominant. */
TEST(definite_without_friction) {
  const double mu[3] = {0}, q[3] = {0}, w[3] = {2, 2, 2};
  for (int side = -1; side <= 1; side += 2) {
    const double g = 2 * sqrt(2) * (1 + 0.01 * side);
    const double W[9] = {2, g / 2, 0, g / 2, 2, 0, 0, g, 2};
    double row[3], J[9];
    const dls_contact p = {.d = 1, .nc = 3, .W = {3, 3, 3, W}, .q = q, .mu = mu};
    ck_assert_int_eq(dlsi_is_unique(&p, w, row, J), side < 0);
    ck_assert_int_eq(dlsi_is_unique(&p, w, row, NULL), 0);
  }
}

/* ---- one candidate whatever the others do ---------------------------------------------------- */

/* Returns whether W may let a candidate have several solutions, which is the same in all units. */
static int is_ambiguous(int d, const double *W, double mu) {
  const double q[3] = {0};
  int found[3];
  for (int k = 0; k < 3; k++) {
    double V[9];
    for (int e = 0; e < d * d; e++)
      V[e] = units[k] * W[e];
    const dls_contact p = {.d = d, .nc = 1, .W = {d, d, d, V}, .q = q, .mu = &mu};
    found[k] = dlsi_may_be_ambiguous(&p);
  }
  ck_assert(found[0] == found[1] && found[1] == found[2]);
  return found[0];
}

/* W_tt with eigenvalues 1 and 4 (2D: 4), along its axes or between them; W_nt = W_tt x, W_nn so
 * that s = 1: k = 1/2, and |x| = 1/4 allows mu < 1/4 + 1, |x| = 1 allows mu < 1, but for the margin
 * of 1 %. */
TEST_EACH(one_candidate, 0, 2) {
  static const double x[2][2] = {{0.15, 0.2}, {0.6, -0.8}}, bound[2] = {1.25, 1};
  const double *y = x[_i];
  const double a[2] = {2.5 * y[0] + 1.5 * y[1], 1.5 * y[0] + 2.5 * y[1]}, h = hypot(y[0], y[1]);
  const double W3[9] = {1 + a[0] * y[0] + a[1] * y[1], a[0], a[1], a[0], 2.5, 1.5, a[1], 1.5, 2.5};
  const double D3[9] = {
      1 + 4 * y[0] * y[0] + y[1] * y[1], 4 * y[0], y[1], 4 * y[0], 4, 0, y[1], 0, 1};
  const double W2[4] = {1 + 4 * h * h, 4 * h, 4 * h, 4};
  for (int side = -1; side <= 1; side += 2) {
    const double mu = (0.99 + 0.005 * side) * bound[_i];
    ck_assert_int_eq(is_ambiguous(3, W3, mu), side > 0);
    ck_assert_int_eq(is_ambiguous(3, D3, mu), side > 0);
    ck_assert_int_eq(is_ambiguous(2, W2, mu), side > 0);
  }
  static const int pair[3][2] = {{0, 1}, {0, 2}, {1, 2}};
  for (int k = 0; k < 3; k++) { /* not symmetric */
    double W[9];
    memcpy(W, W3, sizeof W);
    W[pair[k][0] + 3 * pair[k][1]] += 1e-6;
    ck_assert_int_eq(is_ambiguous(3, W, 0.1), 1);
  }
}

/* Two candidates of c16, apart: with mu = 1 it sticks or slips in two ways, with less it slips. */
TEST(each_has_its_own_friction) {
  const double B[9] = {2, -1, 2, -1, 2, 0, 2, 0, 3}, mu[2] = {1, 0.5}, u[6] = {0};
  double W[36] = {0}, r[6] = {6, 1, -5, 6, 1, -5}, q[6], other[6];
  for (int c = 0; c < 2; c++)
    for (int i = 0; i < 3; i++) {
      q[3 * c + i] = 0;
      for (int j = 0; j < 3; j++) {
        W[3 * c + i + 6 * (3 * c + j)] = B[i + 3 * j];
        q[3 * c + i] -= B[i + 3 * j] * r[3 * c + j];
      }
    }
  const dls_contact p = {.d = 3, .nc = 2, .W = {6, 6, 6, W}, .q = q, .mu = mu};
  ck_assert_int_eq(dlsi_count_ambiguous(&p, r, u, other), 1);
  double own[3];
  ck_assert(dlsi_nlgs_local(3, B, q, mu[0], own, NULL) != DLS_LOCAL_NONE);
  ck_assert(memcmp(own, other, sizeof own) == 0 && memcmp(r + 3, other + 3, sizeof own) == 0);
}

TEST(not_definite) {
  const double indefinite[9] = {1, 0, 0, 0, 1, 1.5, 0, 1.5, 1};
  const double negative[9] = {1, 0, 0, 0, -1, 0.5, 0, 0.5, -1};
  const double one = 1, minus = -1, flat[4] = {1, 0, 0, -1}, below[4] = {1, 3, 3, 1};
  ck_assert_int_eq(is_ambiguous(3, indefinite, 0.1), 1);
  ck_assert_int_eq(is_ambiguous(3, negative, 0.1), 1);
  ck_assert_int_eq(is_ambiguous(2, flat, 0.1), 1);
  ck_assert_int_eq(is_ambiguous(2, below, 0.1), 1);
  ck_assert_int_eq(is_ambiguous(1, &minus, 0), 1);
  ck_assert_int_eq(is_ambiguous(1, &one, 0), 0);
}
