/* test_sensitivity.c: the matrices of the predicted error by hand, borders between states. */

#include "cases.h"
#include "delassus/contact.h"
#include "delassus/solve.h"
#include "delassus/trust.h"
#include "facts/facts.h"
#include "run.h"

static double length_of(const double *x, int n) {
  double sum = 0;
  for (int i = 0; i < n; i++)
    sum += x[i] * x[i];
  return sqrt(sum);
}

/* Returns the least singular value of (a b; c d): of |A|^2 = s^2 + t^2 and det A = s t. */
static double least_of(double a, double b, double c, double d) {
  const double squares = a * a + b * b + c * c + d * d, det = a * d - b * c;
  return sqrt((squares - sqrt(squares * squares - 4 * det * det)) / 2);
}

static int is_close(double x, double y) {
  return fabs(x - y) <= 1e-12 * y;
}

/* q := u - W r, W m x m. */
static void set_load(int m, const double *W, const double *r, const double *u, double *q) {
  for (int i = 0; i < m; i++) {
    q[i] = u[i];
    for (int j = 0; j < m; j++)
      q[i] -= W[i + m * j] * r[j];
  }
}

/* Candidate 0 slips with mu = 3/4, E = (4/5, -3/5), candidate 1 has no friction:
 * A = (4 4/5 - 2 3/5, 1; 1/2 4/5 + 3/5, 3) = (2 1; 1 3); by w_n = (4, 3) A' = (1/2 1/4; 1/3 1). */
TEST(slip_beside_no_friction) {
  const double W[16] = {4, 1, 0.5, 7, 2, 4, -1, -7, 1, -5, 3, 2, 9, 8, -6, 1};
  const double r[4] = {1, -0.75, 2, 0}, u[4] = {0, 0.5, 0, 3}, mu[2] = {0.75, 0};
  double q[4];
  set_load(4, W, r, u, q);
  const dls_contact p = {.d = 2, .nc = 2, .W = {4, 4, 4, W}, .q = q, .mu = mu};
  dls_sensitivity s;
  dls_certificate c;
  ck_assert_int_eq(dls_contact_certify(&p, r, NULL, &c, NULL), DLS_OK);
  ck_assert_int_eq(dls_contact_sensitivity(&p, r, &s, NULL), DLS_OK);
  ck_assert(s.rows == 2 && s.rank == 2 && s.border == 0 && s.isolated == 1);
  ck_assert(is_close(s.amplification, length_of(q, 4) / length_of(r, 4) / least_of(2, 1, 1, 3)));
  ck_assert(is_close(s.amplification_r, 1 / least_of(0.5, 0.25, 1. / 3, 1)));
  const double by_u = s.amplification * fmax(c.residual_u, c.floor_u);
  ck_assert(s.error == fmin(by_u, s.amplification_r * fmax(c.residual_r, c.floor_r)));
}

/* 3D, W = diag(4, 1, 1), w = (4, 1), mu = 3/4, r_t = 3/4 (3/5, 4/5) and |u_t| = 3/8 against it:
 * along the cone A = 4 4/5, across it 1 + |u_t| / |r_t| = 3/2; turned into each quarter. */
TEST(slip_in_3d) {
  const double W[9] = {4, 0, 0, 0, 1, 0, 0, 0, 1}, mu[1] = {0.75};
  for (int turn = 0; turn < 4; turn++) {
    const double e[2] = {turn & 1 ? -0.6 : 0.6, turn & 2 ? -0.8 : 0.8};
    const double r[3] = {1, 0.75 * e[0], 0.75 * e[1]}, u[3] = {0, -0.375 * e[0], -0.375 * e[1]};
    double q[3];
    set_load(3, W, r, u, q);
    const dls_contact p = {.d = 3, .nc = 1, .W = {3, 3, 3, W}, .q = q, .mu = mu};
    dls_sensitivity s;
    ck_assert_int_eq(dls_contact_sensitivity(&p, r, &s, NULL), DLS_OK);
    ck_assert(s.rows == 2 && s.rank == 2 && s.border == 0 && s.isolated == 1);
    ck_assert(is_close(s.amplification, length_of(q, 3) / length_of(r, 3) / 1.5));
    ck_assert(is_close(s.amplification_r, 1 / 0.8));
  }
}

/* The other direction decides: W = diag(1, 4, 4): along the cone 4/5, across it 4 + 1/2; with
 * W_nt = 1/2, which the slip along (3/5, 4/5) feels as (1 - 1/2 3/4 3/5) 4/5. */
TEST(slip_in_3d_along_the_cone) {
  double W[9] = {1, 0, 0, 0, 4, 0, 0, 0, 4}, mu[1] = {0.75}, q[3];
  const double r[3] = {1, 0.45, 0.6}, u[3] = {0, -0.225, -0.3};
  const dls_contact p = {.d = 3, .nc = 1, .W = {3, 3, 3, W}, .q = q, .mu = mu};
  dls_sensitivity s;
  set_load(3, W, r, u, q);
  ck_assert_int_eq(dls_contact_sensitivity(&p, r, &s, NULL), DLS_OK);
  ck_assert(is_close(s.amplification, length_of(q, 3) / length_of(r, 3) / 0.8));
  W[3] = -0.5;
  set_load(3, W, r, u, q);
  ck_assert_int_eq(dls_contact_sensitivity(&p, r, &s, NULL), DLS_OK);
  /* A = (a b; 0 9/2), b = row n of p = (0, -4/5, 3/5) */
  const double a = 0.8 * (1 - 0.5 * 0.45), b = 0.5 * 0.8;
  ck_assert(is_close(s.amplification, length_of(q, 3) / length_of(r, 3) / least_of(a, b, 0, 4.5)));
}

/* The rank does not depend on the units: W = diag(1, 2^-80) has both rows, (1 1; 1 1) one. */
TEST(rank_in_any_units) {
  for (int coupled = 0; coupled < 2; coupled++) {
    const double s = 0x1p-40, W[4] = {1, coupled * s, coupled * s, s * s};
    const double r[2] = {1, 1 / s}, u[2] = {0, 0}, mu[2] = {0, 0};
    double q[2];
    set_load(2, W, r, u, q);
    const dls_contact p = {.d = 1, .nc = 2, .W = {2, 2, 2, W}, .q = q, .mu = mu};
    dls_sensitivity found;
    ck_assert_int_eq(dls_contact_sensitivity(&p, r, &found, NULL), DLS_OK);
    ck_assert(found.rows == 2 && found.rank == 2 - coupled);
  }
}

/* W = v v': what rounding leaves of the other two singular values is no rank. */
TEST(rank_one_but_for_rounding) {
  static const double v[3] = {1. / 3, .7, 1.9}, r[3] = {1, 2, 3}, u[3] = {0}, mu[3] = {0};
  double W[9], q[3];
  for (int k = 0; k < 9; k++)
    W[k] = v[k % 3] * v[k / 3];
  set_load(3, W, r, u, q);
  const dls_contact p = {.d = 1, .nc = 3, .W = {3, 3, 3, W}, .q = q, .mu = mu};
  dls_sensitivity found;
  ck_assert_int_eq(dls_contact_sensitivity(&p, r, &found, NULL), DLS_OK);
  ck_assert(found.rows == 3 && found.rank == 1);
}

/* Counts candidates on a border; candidate 1 sticks with r = (1, 0), and is the measure. */
static int borders(double mu, const double r[2], const double u[2]) {
  const double W[16] = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1};
  const double rs[4] = {r[0], r[1], 1, 0}, us[4] = {u[0], u[1], 0, 0}, friction[2] = {mu, 0.5};
  double q[4];
  set_load(4, W, rs, us, q);
  const dls_contact p = {.d = 2, .nc = 2, .W = {4, 4, 4, W}, .q = q, .mu = friction};
  dls_sensitivity s;
  ck_assert_int_eq(dls_contact_sensitivity(&p, rs, &s, NULL), DLS_OK);
  ck_assert_int_eq(s.isolated, s.border ? -1 : 1);
  return s.border;
}

/* Within 1e-6 of the largest w r and u: 2^-21 is, 2^-19 is not. */
TEST(borders_between_states) {
  const double none[2] = {0, 0};
  for (int far = 0; far < 2; far++) {
    const double e = far ? 0x1p-19 : 0x1p-21;
    ck_assert_int_eq(borders(0.5, none, (double[]){e, 0.25}), !far);    /* free, closing */
    ck_assert_int_eq(borders(4, (double[]){e, 0}, none), !far);         /* opening */
    ck_assert_int_eq(borders(0.5, (double[]){1, 0.5 - e}, none), !far); /* stick to slip */
    ck_assert_int_eq(borders(0.5, (double[]){1, e - 0.5}, none), !far);
    ck_assert_int_eq(borders(0.5, (double[]){1, 0.5}, (double[]){0, -e}), !far); /* slip to stick */
    ck_assert_int_eq(borders(0, (double[]){e, 0}, none), !far); /* no friction: opening alone */
    ck_assert_int_eq(borders(0, (double[]){1, 0}, (double[]){0, e}), 0);
  }
}

/* Springs 2^-20 as stiff as the body. An r with a residual of 6e-11 sticks, next to its cone; the
 * right one, 8 % away, slips by little. */
TEST(error_beyond_the_cone) {
  static const double W[16] = {5242904,  -1572867, 5242893,  -1572860, -1572867, 1048614,
                               -1572848, 1048570,  5242893,  -1572848, 5242917,  -1572881,
                               -1572860, 1048570,  -1572881, 1048600};
  static const double right[4] = {1, 0.21875, 2, 1.75}, mu[2] = {0.875, 0.875};
  static const double u[4] = {0, 0, 0, -3};
  double q[4], r[4];
  set_load(4, W, right, u, q);
  const dls_contact p = {.d = 2, .nc = 2, .W = {4, 4, 4, W}, .q = q, .mu = mu};
  dls_info info;
  ck_assert_int_eq(dls_solve(&p, NULL, r, NULL, &info, NULL), DLS_OK);
  double far = 0;
  for (int i = 0; i < 4; i++)
    far = fmax(far, fabs(r[i] - right[i]));
  ck_assert(far <= 1e-3 || info.error >= far / 10);
  const double beside[4] = {0.8787449, 0.1126637, 2.1212566, 1.8560907};
  double w[4], J[16], x[4];
  dlsi_certificate_weights(&p, w);
  ck_assert_double_ge(dlsi_predict_error(&p, beside, w, J, x), 1e-3);
}

/* Contact 0 carries 1. Contact 1, of W_11 = (1 s; s 1) and by itself, is on the border of states:
 * r = u = 0, or r = (1, side mu). Returns info.error as each method predicts it of this r. Slip has
 * the determinant 1 + side mu s. */
static double error_at(double mu, double s, double side, double turn) {
  const double c = cos(turn), e = sin(turn);
  const double W[36] = {1, 0, 0, 0, 0,     0,     0, 1, 0, 0,     0, 0, 0, 0, 1, 0,     0, 0,
                        0, 0, 0, 1, s * c, s * e, 0, 0, 0, s * c, 1, 0, 0, 0, 0, s * e, 0, 1};
  const double r[6] = {1, 0, 0, side != 0, side * mu * c, side * mu * e}, u[6] = {0},
               f[2] = {1, mu};
  double q[6], w[4], J[36], x[6];
  set_load(6, W, r, u, q);
  const dls_contact p = {.d = 3, .nc = 2, .W = {6, 6, 6, W}, .q = q, .mu = f};
  dlsi_certificate_weights(&p, w);
  return dlsi_predict_error(&p, r, w, J, x);
}

/* The reactions are determined while the determinants of stick, 1 - s^2, free, 1, and slip have one
 * sign, in any tangent frame. */
TEST(one_sided_matrices) {
  for (int k = 0; k < 8; k++) {
    const double turn = 0.8 * k;
    ck_assert(fabs(error_at(1.5, 0.5, 0, turn)) <= 1e-14); /* apex: 1 - mu s = .25 */
    ck_assert(error_at(2.5, 0.5, 0, turn) == -1);          /* -.25 */
    ck_assert(error_at(2.5, -0.5, 0, turn) == -1);
    ck_assert(fabs(error_at(2.5, 0.5, 1, turn)) <= 1e-14); /* at the cone: 2.25 */
    ck_assert(error_at(2.5, 0.5, -1, turn) == -1);         /* -.25 */
    ck_assert(fabs(error_at(1.5, 0.5, -1, turn)) <= 1e-14);
  }
  /* without friction: free 1, touching -1 */
  const double W[4] = {1, 0, 0, -1}, q[2] = {-1, 0}, r[2] = {1, 0}, mu[2] = {0, 0};
  const dls_contact p = {.d = 1, .nc = 2, .W = {2, 2, 2, W}, .q = q, .mu = mu};
  double w[4], J[4], x[2];
  dlsi_certificate_weights(&p, w);
  ck_assert(dlsi_predict_error(&p, r, w, J, x) == -1);
}

/* The same at the apex of three rows of any W: det W, near 0, and with small friction the direction
 * that slips have one sign. By cofactors C of W, whose inverse is C^T / det W. */
TEST(one_sided_in_three_rows) {
  const double mu[2] = {1, 1e-6}, r[6] = {1};
  int kept[2] = {0, 0};
  set_seed(88172645463325252);
  for (int k = 0; k < 20000 && kept[1] < 20; k++) {
    double W[36] = {0}, C[3][3], q[6] = {-1}, w[4], J[36], x[6], det = 0;
    for (int i = 0; i < 6; i++)
      W[7 * i] = 1;
    for (int i = 0; i < 9; i++)
      if (i % 4) W[21 + i % 3 + 6 * (i / 3)] = uniform();
    const double *V = W + 21;
    for (int i = 0; i < 3; i++)
      for (int j = 0; j < 3; j++) {
        const int a = (i + 1) % 3, b = (i + 2) % 3, c = (j + 1) % 3, d = (j + 2) % 3;
        C[i][j] = V[a + 6 * c] * V[b + 6 * d] - V[a + 6 * d] * V[b + 6 * c];
      }
    for (int i = 0; i < 3; i++)
      det += V[i] * C[i][0];
    const double s = C[1][0], t = C[2][0];
    const double slips = s * s * C[1][1] + s * t * (C[1][2] + C[2][1]) + t * t * C[2][2];
    if (fabs(det) > .1 || fabs(det) < .02 || slips < .1 * (s * s + t * t) || s * s + t * t < .1)
      continue;
    const dls_contact p = {.d = 3, .nc = 2, .W = {6, 6, 6, W}, .q = q, .mu = mu};
    dlsi_certificate_weights(&p, w);
    const double error = dlsi_predict_error(&p, r, w, J, x);
    ck_assert_msg(det > 0 ? error >= 0 && error < 1e-12 : error == -1, "det %g: %g", det, error);
    kept[det > 0]++;
  }
  ck_assert_msg(kept[0] > 5 && kept[1] == 20, "%d and %d", kept[0], kept[1]);
}

/* (SN6) (tr S)^2 / |S|^2 of k equal eigenvalues and no others is k: of W = I + s 1 1^T, in either
 * storage, m (1 + s)^2 / (1 + 2 s + m s^2). */
TEST(few_large_eigenvalues) {
  enum { nc = 100, m = 2 * nc };
  static double W[m * m], x[m * m], q[m], mu[nc], w[2 * nc];
  static int start[nc + 1], row[nc * nc];
  for (int k = 0; k < 5; k++) {
    const double s = (double[]){0, .1, .5, 2, 10}[k];
    const double directions = m * (1 + s) * (1 + s) / (1 + 2 * s + m * s * s);
    for (int e = 0; e < m * m; e++)
      W[e] = s + (e % (m + 1) == 0);
    dls_contact p = {.d = 2, .nc = nc, .W = {m, m, m, W}, .q = q, .mu = mu};
    const dls_info info = {.iterations = 1};
    dlsi_certificate_weights(&p, w);
    ck_assert_int_eq(dlsi_may_hide_error(&p, w, &info), directions < 12.5);
    ck_assert_int_eq(dls_blocks_from_dense(&p.W, 2, start, row, x, &p.Wb, NULL), DLS_OK);
    p.W = (dls_dense){0};
    ck_assert_int_eq(dlsi_may_hide_error(&p, w, &info), directions < 12.5);
  }
}

/* A contact alone that W does not determine: any r with r_n + r_t = 1. Each method says so, auto
 * too, which solves it without a workspace. Nor is r determined where contact 0 touches without a
 * reaction: another solution is 111 % away, W has the condition 110. */
TEST(not_determined) {
  static const double W[4] = {1, 1, 1, 1}, q[2] = {-1, -1}, mu[2] = {0.7, 0};
  static const double W2[16] = {
      1.7416077026731358,   -0.72732761419728531, -0.2130459987990192,  -2.7520171230633594,
      -0.72732761419728531, 5.1409375337731831,   5.6478916050269188,   1.2089856100466294,
      -0.2130459987990192,  5.6478916050269188,   8.2177312512164509,   -0.75118822279469466,
      -2.7520171230633594,  1.2089856100466294,   -0.75118822279469466, 5.5455460284271663};
  static const double q2[4] = {-2.5389711242643402, -6.4389059949802894, -8.9689194740111446,
                               8.29673425122186};
  static const double mu2[2] = {8, 1};
  const dls_contact p = {.d = 2, .nc = 1, .W = {2, 2, 2, W}, .q = q, .mu = mu};
  const dls_contact p2 = {.d = 2, .nc = 2, .W = {4, 4, 4, W2}, .q = q2, .mu = mu2};
  dls_solver_settings s;
  dls_solver_settings_init(&s);
  int solved = 0;
  for (int method = 0; dls_method_name((dls_method)method); method++) {
    double r[4];
    dls_info info;
    s.method = (dls_method)method;
    if (dls_solve(&p, &s, r, NULL, &info, NULL) != DLS_OK) continue;
    ck_assert_msg(info.error > 1e300, "%s: %g", dls_method_name(s.method), info.error);
    solved++;
  }
  ck_assert_int_ge(solved, 6);
  double r[4];
  dls_info info;
  ck_assert_int_eq(dls_solve(&p2, NULL, r, NULL, &info, NULL), DLS_OK);
  ck_assert(info.error > 1 || fabs(r[0] - 1.6734339040379422) < 1e-10);
}

/* W = (1 + e, 1; 1, 1 + e), e = 2^-30: rounding of 1e-16 in W r + q is an error of 1e-7 in r, also
 * where the residual is 0. r* = (-q_0 (1 + e) + q_1, ..) / (2 e + e^2) to 64 bits. */
TEST(error_of_rounding) {
  const double e = 0x1p-30, W[4] = {1 + e, 1, 1, 1 + e}, mu[2] = {0, 0};
  const dls_contact p = {.d = 1, .nc = 2, .W = {2, 2, 2, W}, .mu = mu};
  for (int k = 0; k < 60; k++) {
    const double q[2] = {-1 - 0x1p-33 * (k % 7), -1 - 0x1p-33 * (k % 5)};
    dls_contact of = p;
    double r[2];
    dls_info info;
    of.q = q;
    const dls_status status = dls_solve(&of, NULL, r, NULL, &info, NULL);
    ck_assert(status == DLS_OK || status == DLS_TO_ROUNDING);
    const long double under = 2 * (long double)e + (long double)e * e;
    double far[2], right[2];
    for (int i = 0; i < 2; i++) {
      right[i] = (double)((q[1 - i] - q[i] - (long double)e * q[i]) / under);
      far[i] = r[i] - right[i];
    }
    ck_assert(right[0] > 0 && right[1] > 0);
    ck_assert_double_le(length_of(far, 2), 30 * info.error * length_of(right, 2));
    ck_assert_double_le(info.error, 1e-6);
  }
}

/* 15 bodies on springs 2^-20 as stiff as they are, 19 contacts each, without friction: more soft
 * directions than few rows may have. A residual of 1e-6 says nothing of how a body shares its load
 * among its contacts. With dls_info auto
 * goes on until r is right to 100 tol. */
TEST(many_bodies_on_soft_springs) {
  enum { bodies = 15, each = 19, nc = bodies * each };
  static double W[nc * nc], right[nc], q[nc], u[nc], r[nc], mu[nc];
  for (int c = 0; c < nc; c++) {
    right[c] = 1 + (c * 7 % 11) / 8.;
    for (int e = 0; e < nc; e++)
      W[c + nc * e] = (c == e) + (c / each == e / each ? 0x1p20 : 0);
  }
  set_load(nc, W, right, u, q);
  const dls_contact p = {.d = 1, .nc = nc, .W = {nc, nc, nc, W}, .q = q, .mu = mu};
  dls_solver_settings s;
  dls_solver_settings_init(&s);
  s.limits.tol = 1e-4;
  dls_info info;
  ck_assert_int_eq(dls_solve(&p, &s, r, NULL, &info, NULL), DLS_OK);
  double far = 0, size = 0;
  for (int c = 0; c < nc; c++) {
    far += (r[c] - right[c]) * (r[c] - right[c]);
    size += right[c] * right[c];
  }
  ck_assert_double_le(far, 1e-4 * size); /* 100 tol, relative */
}
