/* test_lcp.c: the LCP, its certificate, the checks of proofs, and the 2D contact problem as an
 * LCP. */
#include "../lcp/lcp_internal.h"
#include "delassus/pivoting.h"
#include "lcp_of.h"
#include "run.h"

static void check_error(const dls_error *error, dls_status status, const char *argument,
                        long long index) {
  ck_assert_int_eq(error->status, status);
  ck_assert_str_eq(error->argument, argument);
  ck_assert_int_eq(error->index, index);
}

/* ---- certificate ----------------------------------------------------------------------------- */

TEST(certificate_by_hand) {
  /* rows 0 and 1 have weights 2 and (zero diagonal) 3, row 2 is zero: 1 */
  const double M[9] = {2, -3, 0, 1, 0, 0, 0, 1, 0}, q[3] = {-4, 3, 12}, z[3] = {1, 2, -1};
  const dls_lcp lcp = lcp_of(3, M, q);
  double y[3];
  dls_lcp_certificate c;
  dls_error error;
  ck_assert_int_eq(dls_lcp_certify(&lcp, z, y, &c, &error), DLS_OK);
  /* y = (2 + 2 - 4, -3 - 1 + 3, 12); F = min(2 1, 0), min(3 2, -1), min(-1, 12) */
  assert_near(y, (double[]){0, -1, 12}, 3, 0);
  ck_assert_double_eq_tol(c.residual, sqrt(2.0) / 13, 1e-15);
  ck_assert_double_eq_tol(c.floor, 0x1p-52 * sqrt(16.0 + 16) / 13, 1e-30);
  ck_assert_double_eq(c.negative_z, 1);
  ck_assert_double_eq(c.negative_y, 1);
  ck_assert_double_eq(c.complementarity, 12);
  ck_assert(c.worst == 1 || c.worst == 2);
}

TEST(certificate_has_no_unit) {
  const double M[4] = {2, 1, -1, 3}, q[2] = {-4, 1}, z[2] = {1.5, 0.25};
  const double factors[] = {1e-9, 1e-3, 1, 1e9, 1e150};
  dls_lcp lcp = lcp_of(2, M, q);
  dls_lcp_certificate first, c;
  ck_assert_int_eq(dls_lcp_certify(&lcp, z, NULL, &first, NULL), DLS_OK);
  for (int a = 0; a < 5; a++)
    for (int b = 0; b < 5; b++) { /* z -> b z, y and q -> a q */
      double M2[4], q2[2], z2[2];
      for (int k = 0; k < 4; k++)
        M2[k] = M[k] * factors[a] / factors[b];
      for (int k = 0; k < 2; k++) {
        q2[k] = q[k] * factors[a];
        z2[k] = z[k] * factors[b];
      }
      lcp = lcp_of(2, M2, q2);
      ck_assert_int_eq(dls_lcp_certify(&lcp, z2, NULL, &c, NULL), DLS_OK);
      ck_assert_double_eq_tol(c.residual, first.residual, 8e-16 * first.residual);
      ck_assert_double_eq_tol(c.floor, first.floor, 8e-16 * first.floor);
      ck_assert_int_eq(c.worst, first.worst);
    }
}

TEST(certificate_of_q_zero_and_of_overflow) {
  const double M[1] = {1}, none[1] = {0}, z[1] = {3}, big[1] = {1e300};
  dls_lcp lcp = lcp_of(1, M, none);
  dls_lcp_certificate c;
  ck_assert_int_eq(dls_lcp_certify(&lcp, none, NULL, &c, NULL), DLS_OK);
  ck_assert_double_eq(c.residual, 0);
  ck_assert_int_eq(dls_lcp_certificate_holds(&c, 0), 1);
  ck_assert_int_eq(dls_lcp_certify(&lcp, z, NULL, &c, NULL), DLS_OK); /* F = 3, |M||z| = 3 */
  ck_assert_double_eq(c.residual, 1);
  lcp = lcp_of(1, big, none);
  ck_assert_int_eq(dls_lcp_certify(&lcp, big, NULL, &c, NULL), DLS_OK);
  ck_assert_int_eq(dls_lcp_certificate_holds(&c, 1e-8), 0);
  /* |q| overflows, and still z = 0 is no answer */
  const double I[4] = {1, 0, 0, 1}, far[2] = {-DBL_MAX, -DBL_MAX}, zero[2] = {0};
  lcp = lcp_of(2, I, far);
  ck_assert_int_eq(dls_lcp_certify(&lcp, zero, NULL, &c, NULL), DLS_OK);
  ck_assert_int_eq(dls_lcp_certificate_holds(&c, 1e-8), 0);
  /* |M||z| overflows, F = (-.5, 1.5) 2^1023 does not, and is small beside it */
  const double apart[4] = {1, 0, -1, 1}, x[2] = {0x1p1023, 0x1.8p1023};
  lcp = lcp_of(2, apart, zero);
  ck_assert_int_eq(dls_lcp_certify(&lcp, x, NULL, &c, NULL), DLS_OK);
  ck_assert_double_eq(c.residual, INFINITY);
}

TEST(holds) {
  dls_lcp_certificate c = {.residual = 1e-9, .floor = 1e-16};
  ck_assert_int_eq(dls_lcp_certificate_holds(&c, 1e-9), 1);
  ck_assert_int_eq(dls_lcp_certificate_holds(&c, 9e-10), 0);
  c.floor = 3e-10;
  ck_assert_int_eq(dls_lcp_certificate_holds(&c, 0), 1);
  c.residual = NAN;
  ck_assert_int_eq(dls_lcp_certificate_holds(&c, 1), 0);
  ck_assert_int_eq(dls_lcp_certificate_holds(NULL, 1), 0);
}

TEST(bad_lcp) {
  const double nan = NAN, inf = INFINITY;
  double M[6] = {1, 2, 7, 3, 4, 7}, q[2] = {-1, -2}, z[2] = {0, 0}, y[2] = {5, 6};
  dls_lcp_certificate c = {.residual = 77};
  dls_error e;
  const dls_lcp good = {.n = 2, .M = {2, 2, 3, M}, .q = q};
  ck_assert_int_eq(dls_lcp_check(&good, &e), DLS_OK);
  ck_assert_int_eq(dls_lcp_check(NULL, &e), DLS_E_ARGUMENT);
  check_error(&e, DLS_E_ARGUMENT, "lcp", -1);
  dls_lcp bad = good;
  bad.n = 0;
  ck_assert_int_lt(dls_lcp_check(&bad, &e), 0);
  check_error(&e, DLS_E_SIZE, "n", -1);
  bad.n = 3;
  ck_assert_int_lt(dls_lcp_check(&bad, &e), 0);
  check_error(&e, DLS_E_SIZE, "M", -1);
  bad = good;
  bad.M.ld = 1;
  ck_assert_int_lt(dls_lcp_check(&bad, &e), 0);
  check_error(&e, DLS_E_SIZE, "M", -1);
  bad = good;
  bad.M.a = NULL;
  ck_assert_int_lt(dls_lcp_check(&bad, &e), 0);
  check_error(&e, DLS_E_ARGUMENT, "M", -1);
  bad = good;
  bad.q = NULL;
  ck_assert_int_lt(dls_lcp_check(&bad, &e), 0);
  check_error(&e, DLS_E_ARGUMENT, "q", -1);
  M[4] = nan; /* row 1, column 1 */
  ck_assert_int_lt(dls_lcp_check(&good, &e), 0);
  check_error(&e, DLS_E_NOT_FINITE, "M", 4);
  M[4] = 4;
  q[1] = inf;
  ck_assert_int_lt(dls_lcp_certify(&good, z, y, &c, &e), 0);
  check_error(&e, DLS_E_NOT_FINITE, "q", 1);
  q[1] = -2;
  ck_assert_int_lt(dls_lcp_certify(&good, NULL, y, &c, &e), 0);
  check_error(&e, DLS_E_ARGUMENT, "z", -1);
  z[1] = nan;
  ck_assert_int_lt(dls_lcp_certify(&good, z, y, &c, &e), 0);
  check_error(&e, DLS_E_NOT_FINITE, "z", 1);
  z[1] = 0;
  ck_assert_int_lt(dls_lcp_certify(&good, z, y, NULL, &e), 0);
  check_error(&e, DLS_E_ARGUMENT, "certificate", -1);
  malloc_fails_at(1);
  ck_assert_int_eq(dls_lcp_certify(&good, z, y, &c, &e), DLS_E_MEMORY);
  malloc_fails_at(0);
  ck_assert_double_eq(c.residual, 77);
  assert_near(y, (double[]){5, 6}, 2, 0);
}

/* ---- proofs ---------------------------------------------------------------------------------- */

TEST(ray_by_hand) {
  /* M = (0 1; -1 0), q = (-1, -2), d = (1, 1). z0 = 2: y = (1, 0); z_1 enters: y = (1 + t, 0), z0
   * stays at 2: dy = (1, 0), dz = (0, 1). */
  const double M[4] = {0, -1, 1, 0}, q[2] = {-1, -2}, d[2] = {1, 1}, z[2] = {0, 0}, dz[2] = {0, 1};
  const dls_lcp lcp = lcp_of(2, M, q);
  double v = 9;
  ck_assert_int_eq(dls_lcp_check_ray(&lcp, d, z, 2, dz, 0, &v, NULL), DLS_OK);
  ck_assert_double_eq(v, 0);
  /* its dz is a Farkas proof: M^T dz = (-1, 0), q^T dz = -2 */
  ck_assert_int_eq(dls_lcp_check_farkas(&lcp, dz, &v, NULL), DLS_OK);
  ck_assert_double_eq(v, 0);
  /* every condition broken in turn; the measure of entry i: y_0 = 1 against |z_1| + z0 + |q_0| */
  ck_assert_int_eq(dls_lcp_check_ray(&lcp, d, z, 1.5, dz, 0, &v, NULL), DLS_OK); /* y_1 = -1/2 */
  ck_assert_double_eq_tol(v, 0.5 / 3.5, 1e-15);
  const double back[2] = {0, -1}, none[2] = {0, 0}, both[2] = {1, 1}, minus[2] = {0, -0.1};
  ck_assert_int_eq(dls_lcp_check_ray(&lcp, d, z, 2, back, 0, &v, NULL), DLS_OK); /* dy_0 < 0 */
  ck_assert_double_eq(v, 1);
  ck_assert_int_eq(dls_lcp_check_ray(&lcp, d, minus, 2, dz, 0, &v, NULL), DLS_OK); /* z_1 < 0 */
  ck_assert_double_gt(v, 0.01);
  ck_assert_int_eq(dls_lcp_check_ray(&lcp, d, z, 2, both, 0, &v, NULL), DLS_OK); /* dz_0 dy_0 */
  ck_assert_double_eq(v, 1);
  ck_assert_int_eq(dls_lcp_check_ray(&lcp, d, z, 2, dz, 1, &v, NULL), DLS_OK); /* dz_1 dy_1 */
  ck_assert_double_eq(v, 1);
  ck_assert_int_eq(dls_lcp_check_ray(&lcp, d, z, 3, dz, 0, &v, NULL), DLS_OK); /* dz_1 y_1 */
  ck_assert_double_eq_tol(v, 0.2, 1e-15);
  ck_assert_int_eq(dls_lcp_check_ray(&lcp, d, z, 2, none, 1, &v, NULL), DLS_OK); /* primary */
  ck_assert_double_eq(v, INFINITY);
  ck_assert_int_eq(dls_lcp_check_ray(&lcp, d, z, 2, dz, -1, &v, NULL), DLS_OK);
  ck_assert_double_eq(v, INFINITY);
  ck_assert_int_eq(dls_lcp_check_ray(&lcp, d, z, 0, dz, 0, &v, NULL), DLS_OK); /* z0 = 0 */
  ck_assert_double_eq(v, INFINITY);
}

TEST(farkas_by_hand) {
  const double M[4] = {1, -2, 1, -1}, q[2] = {-1, 1}; /* v = (2, 1): M^T v = (0, 1), q^T v = -1 */
  const double v[2] = {2, 1}, w[2] = {1, 1}, negative[2] = {-1, 1}, plus[2] = {0, 1};
  dls_lcp lcp = lcp_of(2, M, q);
  double violation;
  ck_assert_int_eq(dls_lcp_check_farkas(&lcp, v, &violation, NULL), DLS_OK);
  ck_assert_double_eq_tol(violation, (1.0 / 3) / (1.0 / 3),
                          1e-15); /* M^T v: 1 of 3; q^T v: 1 of 3 */
  ck_assert_int_eq(dls_lcp_check_farkas(&lcp, w, &violation, NULL), DLS_OK); /* q^T v = 0 */
  ck_assert_double_eq(violation, INFINITY);
  ck_assert_int_eq(dls_lcp_check_farkas(&lcp, negative, &violation, NULL), DLS_OK);
  ck_assert_double_eq(violation, INFINITY);
  ck_assert_int_eq(dls_lcp_check_farkas(&lcp, plus, &violation, NULL), DLS_OK);
  ck_assert_double_eq(violation, INFINITY);
}

TEST(bad_proofs) {
  const double M[4] = {0, -1, 1, 0}, q[2] = {-1, -2};
  double d[2] = {1, 1}, z[2] = {0, 0}, dz[2] = {0, 1}, v = 9;
  const dls_lcp lcp = lcp_of(2, M, q);
  dls_error e;
  ck_assert_int_lt(dls_lcp_check_ray(NULL, d, z, 2, dz, 0, &v, &e), 0);
  check_error(&e, DLS_E_ARGUMENT, "lcp", -1);
  ck_assert_int_lt(dls_lcp_check_ray(&lcp, NULL, z, 2, dz, 0, &v, &e), 0);
  check_error(&e, DLS_E_ARGUMENT, "cover", -1);
  d[1] = 0;
  ck_assert_int_lt(dls_lcp_check_ray(&lcp, d, z, 2, dz, 0, &v, &e), 0);
  check_error(&e, DLS_E_ARGUMENT, "cover", 1);
  d[1] = NAN;
  ck_assert_int_lt(dls_lcp_check_ray(&lcp, d, z, 2, dz, 0, &v, &e), 0);
  check_error(&e, DLS_E_NOT_FINITE, "cover", 1);
  d[1] = 1;
  ck_assert_int_lt(dls_lcp_check_ray(&lcp, d, NULL, 2, dz, 0, &v, &e), 0);
  check_error(&e, DLS_E_ARGUMENT, "z", -1);
  z[0] = INFINITY;
  ck_assert_int_lt(dls_lcp_check_ray(&lcp, d, z, 2, dz, 0, &v, &e), 0);
  check_error(&e, DLS_E_NOT_FINITE, "z", 0);
  z[0] = 0;
  ck_assert_int_lt(dls_lcp_check_ray(&lcp, d, z, NAN, dz, 0, &v, &e), 0);
  check_error(&e, DLS_E_NOT_FINITE, "z0", 0);
  ck_assert_int_lt(dls_lcp_check_ray(&lcp, d, z, 2, NULL, 0, &v, &e), 0);
  check_error(&e, DLS_E_ARGUMENT, "dz", -1);
  dz[1] = NAN;
  ck_assert_int_lt(dls_lcp_check_ray(&lcp, d, z, 2, dz, 0, &v, &e), 0);
  check_error(&e, DLS_E_NOT_FINITE, "dz", 1);
  ck_assert_int_lt(dls_lcp_check_farkas(&lcp, dz, &v, &e), 0);
  check_error(&e, DLS_E_NOT_FINITE, "v", 1);
  dz[1] = 1;
  ck_assert_int_lt(dls_lcp_check_ray(&lcp, d, z, 2, dz, INFINITY, &v, &e), 0);
  check_error(&e, DLS_E_NOT_FINITE, "dz0", 0);
  ck_assert_int_lt(dls_lcp_check_ray(&lcp, d, z, 2, dz, 0, NULL, &e), 0);
  check_error(&e, DLS_E_ARGUMENT, "violation", -1);
  malloc_fails_at(1);
  ck_assert_int_eq(dls_lcp_check_ray(&lcp, d, z, 2, dz, 0, &v, &e), DLS_E_MEMORY);
  malloc_fails_at(0);
  ck_assert_int_lt(dls_lcp_check_farkas(NULL, dz, &v, &e), 0);
  check_error(&e, DLS_E_ARGUMENT, "lcp", -1);
  ck_assert_int_lt(dls_lcp_check_farkas(&lcp, NULL, &v, &e), 0);
  check_error(&e, DLS_E_ARGUMENT, "v", -1);
  ck_assert_int_lt(dls_lcp_check_farkas(&lcp, dz, NULL, &e), 0);
  check_error(&e, DLS_E_ARGUMENT, "violation", -1);
  ck_assert_double_eq(v, 9);
}

/* ---- contact --------------------------------------------------------------------------------- */

/* Separate, stick, slip in -t, slip in +t: (r_n, r_t / mu, u_n, u_t), friction against the slip */
static const double states[4][4] = {
    {0, 0, 0.5, -0.25}, {2, 0.5, 0, 0}, {2, 2, 0, -0.75}, {2, -2, 0, 0.75}};

/* An unsymmetric W of three candidates, entries that double precision holds exactly */
static void make_W(double *W) {
  for (int j = 0; j < 6; j++)
    for (int i = 0; i < 6; i++)
      W[i + 6 * j] = i == j ? 4 : (double)((3 * i + 5 * j) % 7 - 3) / 8;
}

TEST(states_by_hand) {
  /* the middle candidate has mu = 0: its row is normal only */
  const double mu[3] = {0.5, 0, 2};
  double W[36], r[6], u[6], q[6], z[7], y[7], M[7 * 8], qz[7], back[6];
  make_W(W);
  for (int a = 0; a < 4; a++)
    for (int b = 0; b < 2; b++)
      for (int c = 0; c < 4; c++) {
        const int k[3] = {a, b, c};
        const int at[3] = {0, 3, 4};
        for (int p = 0; p < 3; p++) {
          const double *state = states[k[p]], m = mu[p];
          r[2 * p] = state[0];
          r[2 * p + 1] = m * state[1];
          u[2 * p] = state[2];
          u[2 * p + 1] = state[3];
          z[at[p]] = r[2 * p];
          y[at[p]] = u[2 * p];
          if (m == 0) continue;
          z[at[p] + 1] = m * r[2 * p] + r[2 * p + 1];          /* phi_2 */
          z[at[p] + 2] = u[2 * p + 1] < 0 ? -u[2 * p + 1] : 0; /* lambda_2 */
          y[at[p] + 1] = u[2 * p + 1] > 0 ? u[2 * p + 1] : 0;  /* lambda_1 */
          y[at[p] + 2] = m * r[2 * p] - r[2 * p + 1];          /* phi_1 */
        }
        for (int i = 0; i < 6; i++) {
          q[i] = u[i];
          for (int j = 0; j < 6; j++)
            q[i] -= W[i + 6 * j] * r[j];
        }
        const dls_contact problem = {.d = 2, .nc = 3, .W = {6, 6, 6, W}, .q = q, .mu = mu};
        dls_error error;
        ck_assert_int_eq(dls_contact_lcp_size(&problem), 7);
        ck_assert_int_eq(dls_contact_to_lcp(&problem, NULL, M, 8, qz, &error), DLS_OK);
        for (int i = 0; i < 7; i++) {
          double v = qz[i];
          for (int j = 0; j < 7; j++)
            v += M[i + 8 * j] * z[j];
          ck_assert_double_eq_tol(v, y[i], 1e-14);
          ck_assert_double_ge(z[i], 0);
          ck_assert_double_ge(y[i], 0);
          ck_assert_double_eq(z[i] * y[i], 0);
        }
        ck_assert_int_eq(dls_contact_from_lcp(&problem, NULL, z, back, &error), DLS_OK);
        assert_near(back, r, 6, 0);
        dls_certificate certificate; /* and the contact laws agree */
        ck_assert_int_eq(dls_contact_certify(&problem, back, NULL, &certificate, &error), DLS_OK);
        ck_assert_double_le(certificate.residual, 4e-16);
      }
}

TEST(scaled_and_by_blocks) {
  const double mu[3] = {0.5, 0, 2}, s[3] = {2, 0.25, 8}, q[6] = {1, 2, 3, 4, 5, 6};
  const int first[3] = {0, 3, 4}, rows[3] = {3, 1, 3};
  double W[36], x[9 * 4 + 4], M[49], M1[49], M2[49], q1[7], q2[7], r1[6], r2[6];
  /* block columns in disorder, one block in two parts */
  const int p[4] = {0, 4, 7, 10}, row[10] = {2, 0, 1, 1, 1, 0, 2, 0, 2, 1};
  make_W(W);
  for (int b = 0; b < 3; b++)
    for (int k = p[b]; k < p[b + 1]; k++)
      for (int e = 0; e < 4; e++)
        x[4 * k + e] = W[2 * row[k] + e % 2 + 6 * (2 * b + e / 2)] * (k == 2 ? 3 : k == 3 ? -2 : 1);
  const dls_contact dense = {.d = 2, .nc = 3, .W = {6, 6, 6, W}, .q = q, .mu = mu};
  const dls_contact blocks = {.d = 2, .nc = 3, .Wb = {2, 3, p, row, x}, .q = q, .mu = mu};
  ck_assert_int_eq(dls_contact_to_lcp(&dense, NULL, M, 7, q1, NULL), DLS_OK);
  ck_assert_int_eq(dls_contact_to_lcp(&dense, s, M1, 7, q1, NULL), DLS_OK);
  ck_assert_int_eq(dls_contact_to_lcp(&blocks, s, M2, 7, q2, NULL), DLS_OK);
  assert_near(M1, M2, 49, 0);
  assert_near(q1, q2, 7, 0);
  /* the W part is s_a s_b times the unscaled one, the rest is the same */
  for (int a = 0; a < 3; a++)
    for (int b = 0; b < 3; b++)
      for (int i = 0; i < rows[a]; i++)
        for (int j = 0; j < rows[b]; j++) {
          const int at = first[a] + i + 7 * (first[b] + j);
          ck_assert_double_eq(M1[at], M[at] * (i < 2 && j < 2 ? s[a] * s[b] : 1));
        }
  assert_near(q1, (double[]){2 * q[0], 2 * q[1], 0, 0.25 * q[2]}, 4, 0);
  const double z[7] = {1, 2, 3, 4, 5, 6, 7};
  ck_assert_int_eq(dls_contact_from_lcp(&dense, NULL, z, r1, NULL), DLS_OK);
  ck_assert_int_eq(dls_contact_from_lcp(&blocks, s, z, r2, NULL), DLS_OK);
  for (int i = 0; i < 6; i++)
    ck_assert_double_eq(r2[i], s[i / 2] * r1[i]);
}

TEST(bad_contact) {
  double W[36], q[6] = {0}, mu[3] = {0.5, 0, 2}, s[3] = {1, 1, 1}, z[7] = {0}, M[49], qz[7], r[6];
  dls_error e;
  make_W(W);
  for (int k = 0; k < 7; k++)
    qz[k] = M[7 * k] = 3;
  for (int k = 0; k < 6; k++)
    r[k] = 3;
  dls_contact problem = {.d = 2, .nc = 3, .W = {6, 6, 6, W}, .q = q, .mu = mu};
  ck_assert_int_eq(dls_contact_lcp_size(NULL), 0);
  ck_assert_int_lt(dls_contact_to_lcp(NULL, NULL, M, 7, qz, &e), 0);
  check_error(&e, DLS_E_ARGUMENT, "problem", -1);
  ck_assert_int_lt(dls_contact_to_lcp(&problem, NULL, NULL, 7, qz, &e), 0);
  check_error(&e, DLS_E_ARGUMENT, "M", -1);
  ck_assert_int_lt(dls_contact_to_lcp(&problem, NULL, M, 6, qz, &e), 0);
  check_error(&e, DLS_E_SIZE, "ldm", -1);
  const dls_contact none = {.d = 2};
  ck_assert_int_lt(dls_contact_to_lcp(&none, NULL, M, 7, qz, &e), 0);
  check_error(&e, DLS_E_SIZE, "nc", -1);
  ck_assert_int_lt(dls_contact_to_lcp(&problem, NULL, M, 7, NULL, &e), 0);
  check_error(&e, DLS_E_ARGUMENT, "q", -1);
  ck_assert_int_lt(dls_contact_from_lcp(NULL, NULL, z, r, &e), 0);
  check_error(&e, DLS_E_ARGUMENT, "problem", -1);
  ck_assert_int_lt(dls_contact_from_lcp(&problem, NULL, NULL, r, &e), 0);
  check_error(&e, DLS_E_ARGUMENT, "z", -1);
  ck_assert_int_lt(dls_contact_from_lcp(&problem, NULL, z, NULL, &e), 0);
  check_error(&e, DLS_E_ARGUMENT, "r", -1);
  z[6] = NAN;
  ck_assert_int_lt(dls_contact_from_lcp(&problem, NULL, z, r, &e), 0);
  check_error(&e, DLS_E_NOT_FINITE, "z", 6);
  z[6] = 0;
  const double wrong[] = {0, -1, NAN};
  for (int k = 0; k < 3; k++) {
    s[1] = wrong[k];
    const dls_status status = k < 2 ? DLS_E_ARGUMENT : DLS_E_NOT_FINITE;
    ck_assert_int_lt(dls_contact_to_lcp(&problem, s, M, 7, qz, &e), 0);
    check_error(&e, status, "s", 1);
    ck_assert_int_lt(dls_contact_from_lcp(&problem, s, z, r, &e), 0);
    check_error(&e, status, "s", 1);
  }
  mu[2] = -1;
  ck_assert_int_lt(dls_contact_to_lcp(&problem, NULL, M, 7, qz, &e), 0);
  check_error(&e, DLS_E_ARGUMENT, "mu", 2);
  mu[2] = 2;
  W[7] = NAN;
  ck_assert_int_lt(dls_contact_to_lcp(&problem, NULL, M, 7, qz, &e), 0);
  check_error(&e, DLS_E_NOT_FINITE, "W", 7);
  W[7] = 4;
  problem.d = 3;
  problem.nc = 2;
  ck_assert_int_eq(dls_contact_lcp_size(&problem), 0);
  ck_assert_int_eq(dls_contact_to_lcp(&problem, NULL, M, 7, qz, &e), DLS_E_UNSUPPORTED);
  check_error(&e, DLS_E_UNSUPPORTED, "d", -1);
  ck_assert_int_eq(dls_contact_from_lcp(&problem, NULL, z, r, &e), DLS_E_UNSUPPORTED);
  for (int k = 0; k < 7; k++) {
    ck_assert_double_eq(qz[k], 3);
    ck_assert_double_eq(M[7 * k], 3);
  }
  assert_all(r, 6, 3);
}

TEST(a_high_floor_excuses_nothing) {
  dls_lcp_certificate c = {.residual = 1e-6, .floor = 1e-3};
  ck_assert_int_eq(dls_lcp_certificate_holds(&c, 1e-8), 0);
  ck_assert_int_eq(dls_lcp_certificate_holds(&c, 1e-5), 0);
  ck_assert_int_eq(dls_lcp_certificate_holds(&c, 1e-2), 1);
  c.residual = 0; /* a y = 0 of which no digit is right */
  ck_assert_int_eq(dls_lcp_certificate_holds(&c, 0), 0);
  for (int k = 0; k < 400; k++) { /* the rule of the contact problem */
    const double residual = exp2(-40 + k % 20), floor = exp2(-60 + k / 10), tol = exp2(-33 + k % 7);
    const dls_certificate contact = {
        .residual = residual, .residual_u = residual, .floor_u = floor};
    c = (dls_lcp_certificate){.residual = residual, .floor = floor};
    ck_assert_int_eq(dls_lcp_certificate_holds(&c, tol), dls_certificate_holds(&contact, tol));
  }
  c = (dls_lcp_certificate){.residual = 4e-16, .floor = 1e-16};
  ck_assert_int_eq(dls_lcp_certificate_holds(&c, 0), 1);
  c.floor = NAN;
  ck_assert_int_eq(dls_lcp_certificate_holds(&c, 0), 0);
}
