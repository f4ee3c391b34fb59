/* test_facets.c: the friction cone with facets as an LCP, and from there to the round cone. */
#include "contact/contact.h"
#include "delassus.h"
#include "fclib_file.h"
#include "front_cases.h"
#include "lcp/lcp_internal.h"
#include "made.h"
#include "run.h"

enum { NC = 6, MOST = 3 * NC, ROWS = NC * (16 + 2) };

static const double pi = 3.14159265358979323846;
static double W[MOST * MOST], q[MOST], mu[NC];
static double M[ROWS * ROWS], b[ROWS], z[ROWS], y[ROWS];

static dls_contact random_problem(int d, int nc, double friction, unsigned seed) {
  return coupled(W, q, mu, d, nc, 0.2, friction, seed);
}

static dls_contact one_candidate(int d, const double *w, const double *p, const double *friction) {
  return (dls_contact){.d = d, .nc = 1, .W = {d, d, d, w}, .q = p, .mu = friction};
}

/* The answer of the LCP alone, by the covering vector (1 .. 1); facets = 0: the 3-row form. */
static dls_status solve_lcp(const dls_contact *p, int facets, double *r) {
  const int n = facets ? dls_contact_facets_size(p, facets) : dls_contact_lcp_size(p);
  ck_assert_int_ge(n, 1);
  ck_assert_int_le(n, ROWS);
  ck_assert_int_eq(facets ? dls_contact_to_facets_lcp(p, facets, NULL, M, n, b, NULL)
                          : dls_contact_to_lcp(p, NULL, M, n, b, NULL),
                   DLS_OK);
  const dls_lcp lcp = {.n = n, .M = {n, n, n, M}, .q = b};
  double ones[ROWS];
  dls_lemke *lemke;
  dls_lemke_settings settings;
  dls_lemke_settings_init(&settings);
  for (int i = 0; i < n; i++)
    ones[i] = 1;
  settings.cover = ones;
  ck_assert_int_eq(dls_lemke_create(&lemke, n, &settings, NULL), DLS_OK);
  const dls_status status = dls_lemke_solve(lemke, &lcp, z, y, NULL, NULL);
  dls_lemke_destroy(lemke);
  ck_assert_int_eq(facets ? dls_contact_from_facets_lcp(p, facets, NULL, z, r, NULL)
                          : dls_contact_from_lcp(p, NULL, z, r, NULL),
                   DLS_OK);
  return status;
}

static dls_solver_settings lemke_to(double tol) {
  dls_solver_settings s = settings_with(DLS_LEMKE, tol);
  return s;
}

static double residual_of(const dls_contact *p, const double *r) {
  const dls_certificate c = certificate_of(p, r);
  return c.residual;
}

/* ---- by hand --------------------------------------------------------------------------------- */

TEST(slip_along_a_corner_is_exact) {
  /* r_n = 4/2; the disc of radius 1 stops -q_t = 3 e: r_t = e, u_t = -2 e, lambda = 2 */
  const double w[9] = {2, 0, 0, 0, 1, 0, 0, 0, 1}, friction = 0.5;
  for (int facets = 4; facets <= 16; facets *= 2)
    for (int k = 0; k < facets; k++) {
      const double e[2] = {cos(2 * pi * k / facets), sin(2 * pi * k / facets)};
      const double p[3] = {-4, -3 * e[0], -3 * e[1]};
      const dls_contact problem = one_candidate(3, w, p, &friction);
      double r[3];
      ck_assert_int_eq(dls_contact_facets_size(&problem, facets), facets + 2);
      ck_assert_int_eq(solve_lcp(&problem, facets, r), DLS_OK);
      ck_assert_double_eq_tol(r[0], 2, 4 * DBL_EPSILON);
      assert_near(r + 1, (double[]){e[0], e[1]}, 2, 8 * DBL_EPSILON);
      ck_assert_double_eq_tol(z[facets + 1], 2, 16 * DBL_EPSILON);
    }
}

TEST(slip_through_the_middle_of_a_facet) {
  /* W = I, r_n = 2, radius R = mu r_n. The nearest point of the polygon to -q_t, |q_t| = 5, above
   * the middle of a facet is that middle: |r_t| = R cos(pi / facets), along -q_t. Then
   * |F| = R (1 - cos(pi / facets)). */
  const double w[9] = {1, 0, 0, 0, 1, 0, 0, 0, 1}, friction = 0.75, R = 1.5;
  double before = 1;
  for (int facets = 4; facets <= 32; facets *= 2) {
    const double short_of = 1 - cos(pi / facets), angle = pi / facets * 3;
    const double p[3] = {-2, 5 * cos(angle), 5 * sin(angle)};
    const dls_contact problem = one_candidate(3, w, p, &friction);
    double r[3], u[3];
    ck_assert_int_eq(solve_lcp(&problem, facets, r), DLS_OK);
    ck_assert_double_eq_tol(r[0], 2, 1e-14);
    ck_assert_double_eq_tol(r[1], -R * (1 - short_of) * cos(angle), 1e-14);
    ck_assert_double_eq_tol(r[2], -R * (1 - short_of) * sin(angle), 1e-14);
    const dls_certificate c = certificate_of(&problem, r);
    const double residual = c.residual_u;
    ck_assert_double_eq_tol(residual, R * short_of / sqrt(29), 1e-15);
    ck_assert(residual < before / (facets == 4 ? 1 : 3.8)); /* as 1 / facets^2 */
    before = residual;

    dls_solver_settings s = lemke_to(1e-14);
    dls_info info;
    s.facets = facets;
    ck_assert_int_eq(dls_solve(&problem, &s, r, u, &info, NULL), DLS_OK);
    ck_assert(info.certificate.residual <= 1e-14 && info.iterations > 0);
    assert_near(r + 1, (double[]){-R * cos(angle), -R * sin(angle)}, 2, 1e-13);
    ck_assert_double_eq_tol(u[1], (5 - R) * cos(angle), 1e-13);
    s.limits.tol = 1; /* good enough as it is: the polygon's answer, not the round one */
    ck_assert_int_eq(dls_solve(&problem, &s, r, NULL, NULL, NULL), DLS_OK);
    ck_assert(residual_of(&problem, r) <= 1);
  }
}

TEST(free_stick_and_no_friction) {
  const double w[9] = {1, 0, 0, 0, 1, 0, 0, 0, 1};
  const double apart[3] = {0.5, 1, -2}, held[3] = {-1, 0.1, -0.2};
  const double friction = 1, none = 0;
  for (int facets = 4; facets <= 10; facets += 2) {
    double r[3] = {9, 9, 9};
    dls_contact p = one_candidate(3, w, apart, &friction);
    ck_assert_int_eq(solve_lcp(&p, facets, r), DLS_OK);
    for (int i = 0; i < 3; i++)
      ck_assert_double_eq_tol(r[i], 0, 1e-15);
    p.q = held;
    ck_assert_int_eq(solve_lcp(&p, facets, r), DLS_OK);
    assert_near(r, (double[]){1, -0.1, 0.2}, 3, 1e-15);
    p.mu = &none;
    ck_assert_int_eq(dls_contact_facets_size(&p, facets), 1);
    ck_assert_int_eq(solve_lcp(&p, facets, r), DLS_OK);
    ck_assert(r[0] == 1 && r[1] == 0 && r[2] == 0);
  }
  for (int k = 0; k < 2; k++) { /* the front door, with and without friction */
    const dls_solver_settings s = lemke_to(1e-14);
    const dls_contact p = one_candidate(3, w, held, k ? &friction : &none);
    double r[3];
    ck_assert_int_eq(dls_solve(&p, &s, r, NULL, NULL, NULL), DLS_OK);
    ck_assert_double_eq_tol(r[0], 1, 1e-15);
    ck_assert_double_eq_tol(r[2], k ? 0.2 : 0, 1e-15);
  }
}

/* W positive definite, friction large: mu > W_nn / W_nt = 5/2 in the first (C12a of the catalogue
 * of failures), where r = (1, -2), u = 0 is the only solution. The others end in a ray from the
 * default covering vector; at the end, two where Newton's method cannot help. */
TEST(four_rows_solve_what_three_cannot) {
  static const double w1[4] = {5, 2, 2, 1}, q1[2] = {-1, 0}, mu1[1] = {3}, r1[2] = {1, -2};
  static const double w2[16] = {9, 8, -2, -1, 8, 8, 0, 0, -2, 0, 7, 0, -1, 0, 0, 3};
  static const double q2[4] = {-1, 1, 2, -1}, mu2[2] = {3, 1}, r2[4] = {8, -8.125, 2, 2};
  static const double w3[16] = {2, 3, 2, 0, 3, 10, 0, 0, 2, 0, 8, -4, 0, 0, -4, 4};
  static const double q3[4] = {-1, 0, 1, 2}, mu3[2] = {3, 3};
  static const double r3[4] = {10. / 11, -3. / 11, 0, 0};
  const dls_contact problem[3] = {{.d = 2, .nc = 1, .W = {2, 2, 2, w1}, .q = q1, .mu = mu1},
                                  {.d = 2, .nc = 2, .W = {4, 4, 4, w2}, .q = q2, .mu = mu2},
                                  {.d = 2, .nc = 2, .W = {4, 4, 4, w3}, .q = q3, .mu = mu3}};
  const double *const answer[3] = {r1, r2, r3};
  for (int k = 0; k < 3; k++) {
    const dls_contact *p = problem + k;
    double r[4] = {9, 9, 9, 9};
    if (k == 0) ck_assert_int_eq(solve_lcp(p, 0, r), DLS_RAY);
    ck_assert_int_eq(dls_contact_facets_size(p, 2), 4 * p->nc);
    ck_assert_int_eq(solve_lcp(p, 2, r), DLS_OK);
    for (int i = 0; i < 2 * p->nc; i++)
      ck_assert_double_eq_tol(r[i], answer[k][i], 1e-13);
    const dls_solver_settings s = lemke_to(1e-14);
    ck_assert_int_eq(dls_solve(p, &s, r, NULL, NULL, NULL), DLS_OK);
    for (int i = 0; i < 2 * p->nc; i++)
      ck_assert_double_eq_tol(r[i], answer[k][i], 1e-13);
  }
  for (unsigned seed = 1842; seed <= 2667; seed += 825) {
    const dls_contact p = random_problem(2, 2, 8, seed);
    const dls_solver_settings s = lemke_to(1e-12);
    double r[4];
    ck_assert_int_eq(dls_solve(&p, &s, r, NULL, NULL, NULL), DLS_OK);
  }
}

/* Newton's method alone cycles from r = 0: only r = (5, 4, 0), u = 0. */
TEST(newton_cycle_in_3d) {
  const double w[9] = {1, -1, 0, -1, 2, 0, 0, 0, 2}, p[3] = {-1, -3, 0}, friction = 2;
  const dls_contact problem = one_candidate(3, w, p, &friction);
  const dls_solver_settings s = lemke_to(1e-13);
  double r[3];
  ck_assert_int_eq(dls_solve(&problem, &s, r, NULL, NULL, NULL), DLS_OK);
  assert_near(r, (double[]){5, 4, 0}, 3, 1e-12);
}

/* No r has u_n >= 0. A ray of the LCP with facets proves nothing of the round cone; the linear
 * problem does. */
TEST(no_solution_is_claimed) {
  const double w[9] = {0}, p[3] = {-1, 0, 0}, friction = 0.5;
  for (int d = 2; d <= 3; d++) {
    const dls_contact problem = one_candidate(d, w, p, &friction);
    const dls_solver_settings s = lemke_to(1e-10);
    dls_info info;
    double r[3] = {9, 9, 9};
    ck_assert_int_eq(dls_solve(&problem, &s, r, NULL, &info, NULL), DLS_NO_SOLUTION);
    ck_assert(info.certificate.residual > 0.1 && isfinite(info.certificate.residual));
    ck_assert(info.certificate.residual == residual_of(&problem, r));
  }
}

/* ---- M and q, entry by entry ----------------------------------------------------------------- */

/* For any z: y = M z + q is (u_n, e_k.u_t + lambda, mu r_n - sum beta) of u = W r + q. */
static void check_form(const dls_contact *p, int facets, const double *s) {
  const int d = p->d, nc = p->nc, m = d * nc, n = dls_contact_facets_size(p, facets), ld = n + 3;
  double *A = malloc((size_t)(ld * n) * sizeof *A);
  double r[MOST], u[MOST];
  unsigned seed = 7;
  ck_assert_ptr_nonnull(A);
  for (int k = 0; k < ld * n; k++)
    A[k] = 77;
  for (int i = 0; i < n; i++)
    z[i] = draw(&seed);
  ck_assert_int_eq(dls_contact_to_facets_lcp(p, facets, s, A, ld, b, NULL), DLS_OK);
  ck_assert_int_eq(dls_contact_from_facets_lcp(p, facets, s, z, r, NULL), DLS_OK);
  for (int i = 0; i < m; i++) {
    u[i] = q[i];
    for (int j = 0; j < m; j++)
      u[i] += W[i + m * j] * r[j];
  }
  for (int i = 0; i < n; i++) {
    y[i] = b[i];
    for (int j = 0; j < n; j++)
      y[i] += A[i + ld * j] * z[j];
    ck_assert(A[n + ld * i] == 77 && A[n + 2 + ld * i] == 77);
  }
  for (int c = 0, i = 0; c < nc; c++) {
    const double sc = s ? s[c] : 1, *uc = u + d * c;
    double t[2] = {0}, sum = 0, rn = z[i];
    ck_assert_double_eq_tol(r[d * c], sc * rn, 1e-15 * sc);
    ck_assert_double_eq_tol(y[i], sc * uc[0], 1e-13);
    i++;
    for (int k = 0; k < facets && mu[c] > 0; k++, i++) {
      const double e[2] = {cos(2 * pi * k / facets), sin(2 * pi * k / facets)};
      const double slip = uc[1] * e[0] + (d == 3 ? uc[2] * e[1] : 0);
      t[0] += z[i] * e[0];
      t[1] += z[i] * e[1];
      sum += z[i];
      ck_assert_double_eq_tol(y[i], sc * slip + z[i - k + facets], 1e-13);
    }
    for (int k = 1; k < d; k++)
      ck_assert_double_eq_tol(r[d * c + k], sc * t[k - 1], 1e-14 * sc);
    if (mu[c] > 0) {
      ck_assert_double_eq_tol(y[i], mu[c] * rn - sum, 1e-14);
      i++;
    }
    if (c == nc - 1) ck_assert_int_eq(i, n);
  }
  free(A);
}

TEST(rows_say_what_they_should) {
  const double s[NC] = {1, 2, 0.3, 5, 0.7, 1.5};
  for (int d = 2; d <= 3; d++)
    for (int facets = d == 2 ? 2 : 4; facets <= (d == 2 ? 2 : 12); facets += 2) {
      dls_contact p = random_problem(d, NC, 0.6, 3);
      const int m = d * NC;
      for (int i = 0; i < m * m; i++)
        W[i] += 0.1 * sin(i); /* not symmetric */
      check_form(&p, facets, NULL);
      check_form(&p, facets, s);

      /* the same by blocks, each in two halves */
      int start[NC + 1], row[2 * NC * NC];
      double x[2 * MOST * MOST];
      for (int c = 0, k = 0; c <= NC; c++) {
        start[c] = k;
        for (int a = 0; c < NC && a < 2 * NC; a++, k++) {
          row[k] = a % NC;
          for (int e = 0; e < d * d; e++)
            x[d * d * k + e] = W[d * (a % NC) + e % d + m * (d * c + e / d)] / 2;
        }
      }
      p.W = (dls_dense){0};
      p.Wb = (dls_blocks){d, NC, start, row, x};
      check_form(&p, facets, s);
    }
}

TEST(facets_two_and_three_rows_agree_in_2d) {
  for (unsigned seed = 1; seed <= 100; seed++) {
    const dls_contact p = random_problem(2, NC, 0.4, seed);
    double three[MOST], four[MOST];
    ck_assert_int_eq(solve_lcp(&p, 0, three), DLS_OK);
    ck_assert_int_eq(solve_lcp(&p, 2, four), DLS_OK);
    assert_near(three, four, 2 * NC, 1e-12); /* cond(W) < 30 */
  }
}

/* ---- the round cone -------------------------------------------------------------------------- */

/* The sum over problems: each single one may be lucky with its angles. 1 / facets^2 is the law as
 * long as the polygon does not change which candidates slip. */
TEST(more_facets_smaller_error) {
  double before = 0;
  for (int facets = 4; facets <= 16; facets *= 2) {
    double sum = 0;
    for (unsigned seed = 1; seed <= 60; seed++) {
      const dls_contact p = random_problem(3, NC, 0.6, seed);
      double r[MOST];
      ck_assert_int_eq(solve_lcp(&p, facets, r), DLS_OK);
      for (int c = 0; c < NC; c++) /* inscribed: in the round cone */
        ck_assert(hypot(r[3 * c + 1], r[3 * c + 2]) <= mu[c] * r[3 * c] * (1 + 1e-14) + 1e-14);
      sum += residual_of(&p, r);
    }
    if (facets > 4) ck_assert(sum < before / 2);
    before = sum;
  }
}

TEST(random_problems_to_rounding) {
  for (unsigned seed = 1; seed <= 100; seed++) {
    const dls_contact p = random_problem(3, NC, seed % 2 ? 0.3 : 1, seed);
    const dls_solver_settings s = lemke_to(1e-12);
    double r[MOST], u[MOST], twice[MOST];
    dls_info info;
    ck_assert_int_eq(dls_solve(&p, &s, r, u, &info, NULL), DLS_OK);
    ck_assert(residual_of(&p, r) <= 1e-12);
    for (int c = 0; c < NC; c++) { /* the laws as they stand in contact.h */
      const double *rc = r + 3 * c, *uc = u + 3 * c, rt = hypot(rc[1], rc[2]);
      const double ut = hypot(uc[1], uc[2]);
      ck_assert(rc[0] >= -1e-10 && uc[0] >= -1e-10 && fabs(rc[0] * uc[0]) <= 1e-10);
      ck_assert(rt <= mu[c] * rc[0] + 1e-10);
      ck_assert(ut * (mu[c] * rc[0] - rt) <= 1e-10);
      ck_assert_double_eq_tol(rc[1] * uc[1] + rc[2] * uc[2], -rt * ut, 1e-10);
    }
    ck_assert_int_eq(dls_solve(&p, &s, twice, NULL, NULL, NULL), DLS_OK);
    ck_assert_mem_eq(r, twice, (size_t)(3 * NC) * sizeof *r);
  }
}

/* Steps from r to 1e-12, without sweeps. */
static int newton_steps(const dls_contact *p, double *r) {
  dls_newton_settings s;
  dls_newton_settings_init(&s);
  s.limits.tol = 1e-12;
  s.sweeps = 0;
  s.limits.warm_start = 1;
  dls_newton *newton;
  dls_info info;
  ck_assert_int_eq(dls_newton_create(&newton, p->d, p->nc, &s, NULL), DLS_OK);
  ck_assert_int_eq(dls_newton_solve(newton, p, r, NULL, &info, NULL), DLS_OK);
  dls_newton_destroy(newton);
  return info.iterations;
}

/* Newton's method squares the error: from the polygon's 1e-2 to 1e-12 within some steps. A wrong
 * slope would take tens, or never get there. */
TEST(few_newton_steps) {
  int most = 0, sum = 0;
  for (unsigned seed = 1; seed <= 200; seed++) {
    const dls_contact p = random_problem(3, NC, 0.6, seed);
    double r[MOST];
    ck_assert_int_eq(solve_lcp(&p, 8, r), DLS_OK);
    const int steps = newton_steps(&p, r);
    ck_assert(residual_of(&p, r) <= 1e-12);
    if (steps > most) most = steps;
    sum += steps;
  }
  ck_assert_int_le(most, 8);
  ck_assert_int_le(sum, 200 * 4);
}

/* W of rank 1 and free candidates: J is singular but for eps. Any r_n1 + r_n2 = 1 will do. */
TEST(newton_on_a_singular_matrix) {
  const double p_q[6] = {-1, 0, 0, -1, 0, 0}, friction[2] = {0.5, 0.5};
  double V[36] = {0}, r[6] = {0.45, 0.01, 0, 0.5, 0, -0.02};
  V[0] = V[3] = V[18] = V[21] = 1;
  const dls_contact p = {.d = 3, .nc = 2, .W = {6, 6, 6, V}, .q = p_q, .mu = friction};
  ck_assert_int_le(newton_steps(&p, r), 4);
  ck_assert(residual_of(&p, r) <= 1e-12);
  ck_assert_double_eq_tol(r[0] + r[3], 1, 1e-11);
}

/* Where Newton's method cycles, sweeps and more steps get there (seed 315 in 3D). */
TEST(large_friction) {
  const dls_solver_settings s = lemke_to(1e-12);
  double r[MOST];
  for (unsigned seed = 1; seed <= 600; seed++) {
    dls_contact p = random_problem(3, NC, 3, seed);
    ck_assert_int_eq(dls_solve(&p, &s, r, NULL, NULL, NULL), DLS_OK);
    p = random_problem(2, 3, 6, seed);
    ck_assert_int_eq(dls_solve(&p, &s, r, NULL, NULL, NULL), DLS_OK);
  }
  /* r = 0 has a smaller residual here than the LCP's r, and is no place to start */
  const unsigned misleading[] = {94, 155, 269, 561};
  for (int k = 0; k < 4; k++) {
    const dls_contact p = random_problem(3, 3, 8, misleading[k]);
    ck_assert_int_eq(dls_solve(&p, &s, r, NULL, NULL, NULL), DLS_OK);
  }
}

/* The polygon turns with the tangents, the answer must not. */
TEST(rotated_tangents_same_answer) {
  for (unsigned seed = 1; seed <= 20; seed++) {
    dls_contact p = random_problem(3, NC, 0.3, seed);
    const dls_solver_settings s = lemke_to(1e-13);
    const int m = 3 * NC;
    double r[MOST], turned[MOST], Q[MOST * MOST] = {0}, A[MOST * MOST], V[MOST * MOST], p_q[MOST];
    for (int c = 0; c < NC; c++) {
      const double angle = 0.3 + c;
      Q[3 * c + m * (3 * c)] = 1;
      Q[3 * c + 1 + m * (3 * c + 1)] = Q[3 * c + 2 + m * (3 * c + 2)] = cos(angle);
      Q[3 * c + 2 + m * (3 * c + 1)] = sin(angle);
      Q[3 * c + 1 + m * (3 * c + 2)] = -sin(angle);
    }
    ck_assert_int_eq(dls_solve(&p, &s, r, NULL, NULL, NULL), DLS_OK);
    for (int i = 0; i < m; i++) { /* V = Q W Q^T, Q q */
      p_q[i] = 0;
      for (int k = 0; k < m; k++)
        p_q[i] += Q[i + m * k] * q[k];
      for (int j = 0; j < m; j++) {
        A[i + m * j] = 0;
        for (int k = 0; k < m; k++)
          A[i + m * j] += Q[i + m * k] * W[k + m * j];
      }
    }
    for (int i = 0; i < m; i++)
      for (int j = 0; j < m; j++) {
        V[i + m * j] = 0;
        for (int k = 0; k < m; k++)
          V[i + m * j] += A[i + m * k] * Q[j + m * k];
      }
    p.W.a = V, p.q = p_q;
    ck_assert_int_eq(dls_solve(&p, &s, turned, NULL, NULL, NULL), DLS_OK);
    for (int i = 0; i < m; i++) {
      double sum = 0;
      for (int k = 0; k < m; k++)
        sum += Q[i + m * k] * r[k];
      ck_assert_double_eq_tol(turned[i], sum, 1e-11);
    }
  }
}

TEST(units_do_not_change_the_path) {
  const double factor[] = {1e-9, 1e-3, 1e6, 1e9};
  for (unsigned seed = 1; seed <= 5; seed++) {
    dls_contact p = random_problem(3, NC, 0.6, seed);
    const dls_solver_settings s = lemke_to(1e-12);
    double r[MOST], t[MOST], V[MOST * MOST], v[MOST];
    dls_info info, other;
    ck_assert_int_eq(dls_solve(&p, &s, r, NULL, &info, NULL), DLS_OK);
    for (int i = 0; i < 16; i++) {
      const double length = factor[i / 4], force = factor[i % 4];
      scale_vector(V, W, length / force, MOST * MOST);
      scale_vector(v, q, length, MOST);
      p.W.a = V, p.q = v;
      ck_assert_int_eq(dls_solve(&p, &s, t, NULL, &other, NULL), DLS_OK);
      ck_assert_int_eq(other.iterations, info.iterations);
      for (int e = 0; e < MOST; e++)
        ck_assert_double_eq_tol(t[e] / force, r[e], 1e-11);
    }
  }
}

TEST(files_in_3d) {
  const char *name[] = {"FC3D_Example1", "Confeti-ex13-4contact-Fc3D-SBM"};
  for (int k = 0; k < 2; k++) {
    dls_fclib *file = read_fclib_file(name[k]);
    if (!file) return; /* built without HDF5 */
    dls_contact p;
    ck_assert_int_eq(dls_fclib_contact(file, &p, NULL), DLS_OK);
    ck_assert_int_eq(p.d, 3);
    for (int facets = 4; facets <= 16; facets += 4) {
      dls_solver_settings s = lemke_to(1e-12);
      double r[12];
      s.facets = facets;
      ck_assert_int_le(p.nc, 4);
      ck_assert_int_eq(dls_solve(&p, &s, r, NULL, NULL, NULL), DLS_OK);
      ck_assert(residual_of(&p, r) <= 1e-12);
    }
    dls_fclib_destroy(file);
  }
}

TEST(limit_and_cancellation_are_not_polished_away) {
  const dls_contact p = random_problem(3, NC, 0.6, 5);
  dls_solver_settings s = lemke_to(1e-12);
  double r[MOST];
  dls_info info;
  s.limits.max_iterations = 3;
  ck_assert_int_eq(dls_solve(&p, &s, r, NULL, &info, NULL), DLS_MAX_ITERATIONS);
  ck_assert_int_eq(info.iterations, 2 + 3); /* two rounds of the crash start, three pivots */
  ck_assert(info.certificate.residual == residual_of(&p, r));
}

/* ---- memory and bad input -------------------------------------------------------------------- */

TEST(solver_is_reused_and_allocates_nothing) {
  const dls_solver_settings s = lemke_to(1e-12);
  double first[MOST], r[MOST], u[MOST];
  dls_solver *solver = solver_of(3, NC, &s);
  for (int round = 0; round < 2; round++)
    for (unsigned seed = 1; seed <= 6; seed++) {
      const dls_contact p = random_problem(3, seed == 6 ? 2 : NC, seed == 5 ? 3 : 0.5, seed);
      malloc_fails_at(0);
      const dls_status status = dls_solver_solve(solver, &p, r, u, NULL, NULL);
      const long calls = malloc_calls(); /* Check itself allocates, too */
      ck_assert_int_eq(status, DLS_OK);
      ck_assert_int_eq(calls, 0);
      if (seed == 1 && round == 0) memcpy(first, r, sizeof r);
      if (seed == 1) ck_assert_mem_eq(first, r, sizeof r);
    }
  dls_solver_destroy(solver);
}

TEST(every_failing_malloc_unwinds) {
  for (int d = 2; d <= 3; d++) {
    const dls_contact p = random_problem(d, NC, 0.5, 2);
    const dls_solver_settings s = lemke_to(1e-12);
    double r[MOST] = {9};
    dls_error e = {0};
    MALLOCS_FAIL(dls_solve(&p, &s, r, NULL, NULL, &e), r[0] == 9 && e.status == DLS_E_MEMORY,
                 DLS_OK, 6);
    ck_assert_int_eq(mallocs_failed, 6); /* arrays, Lemke's, sweeps, 2 of steps, prediction */
  }
}

TEST(sizes) {
  dls_contact p = random_problem(3, NC, 0.5, 1); /* one of six without friction */
  ck_assert_int_eq(dls_contact_facets_size(&p, 4), 5 * 6 + 1);
  ck_assert_int_eq(dls_contact_facets_size(&p, 64), 5 * 66 + 1);
  const int refused[] = {-4, 0, 2, 3, 5, 66};
  for (int k = 0; k < 6; k++)
    ck_assert_int_eq(dls_contact_facets_size(&p, refused[k]), 0);
  ck_assert_int_eq(dls_contact_facets_size(NULL, 8), 0);
  p.mu = NULL;
  ck_assert_int_eq(dls_contact_facets_size(&p, 8), 0);
  p = random_problem(2, NC, 0.5, 1);
  ck_assert_int_eq(dls_contact_facets_size(&p, 2), 5 * 4 + 1);
  ck_assert_int_eq(dls_contact_facets_size(&p, 8), 0);
}

TEST(bad_input_is_named) {
  dls_contact good = random_problem(3, 2, 0.5, 1), p = good;
  const int n = dls_contact_facets_size(&p, 4), ld = n;
  double s[2] = {1, 1}, r[6], *const A = M;
  dls_error e;
  ck_assert_int_eq(n, 12);
#define TO(problem, facets, scale, matrix, lda, vector)                                            \
  dls_contact_to_facets_lcp(problem, facets, scale, matrix, lda, vector, &e)
#define FROM(problem, facets, scale, point, answer)                                                \
  dls_contact_from_facets_lcp(problem, facets, scale, point, answer, &e)
  for (int i = 0; i < n; i++)
    b[i] = 9, z[i] = 1;
  for (int i = 0; i < 6; i++)
    r[i] = 9;
  A[0] = 9;
  for (int from = 0; from < 2; from++) {
    ck_assert_int_eq(from ? FROM(NULL, 4, s, z, r) : TO(NULL, 4, s, A, ld, b), DLS_E_ARGUMENT);
    ck_assert_str_eq(e.argument, "problem");
    ck_assert_int_eq(e.index, -1);
    p = good, p.q = NULL;
    ck_assert_int_eq(from ? FROM(&p, 4, s, z, r) : TO(&p, 4, s, A, ld, b), DLS_E_ARGUMENT);
    ck_assert_str_eq(e.argument, "q");
    ck_assert_int_eq(e.index, -1);
    p = good;
    ck_assert_int_eq(from ? FROM(&p, 5, s, z, r) : TO(&p, 5, s, A, ld, b), DLS_E_ARGUMENT);
    ck_assert_str_eq(e.argument, "facets");
    ck_assert_int_eq(e.index, -1);
    ck_assert(e.value == 5);
    const double bad[] = {0, -1, NAN, INFINITY};
    for (int k = 0; k < 4; k++) {
      s[1] = bad[k];
      ck_assert_int_eq(from ? FROM(&p, 4, s, z, r) : TO(&p, 4, s, A, ld, b),
                       k < 2 ? DLS_E_ARGUMENT : DLS_E_NOT_FINITE);
      ck_assert_str_eq(e.argument, "s");
      ck_assert_int_eq(e.index, 1);
      s[1] = 1;
    }
    W[7] = NAN;
    ck_assert_int_eq(from ? FROM(&p, 4, s, z, r) : TO(&p, 4, s, A, ld, b), DLS_E_NOT_FINITE);
    ck_assert_str_eq(e.argument, "W");
    ck_assert_int_eq(e.index, 7);
    good = random_problem(3, 2, 0.5, 1);
  }
  ck_assert_int_eq(TO(&p, 4, s, NULL, ld, b), DLS_E_ARGUMENT);
  ck_assert_str_eq(e.argument, "M");
  ck_assert_int_eq(e.index, -1);
  ck_assert_int_eq(TO(&p, 4, s, A, ld - 1, b), DLS_E_SIZE);
  ck_assert_str_eq(e.argument, "ldm");
  ck_assert_int_eq(e.index, -1);
  ck_assert_int_eq(TO(&p, 4, s, A, ld, NULL), DLS_E_ARGUMENT);
  ck_assert_str_eq(e.argument, "q");
  ck_assert_int_eq(e.index, -1);
  ck_assert_int_eq(FROM(&p, 4, s, NULL, r), DLS_E_ARGUMENT);
  ck_assert_str_eq(e.argument, "z");
  ck_assert_int_eq(e.index, -1);
  ck_assert_int_eq(FROM(&p, 4, s, z, NULL), DLS_E_ARGUMENT);
  ck_assert_str_eq(e.argument, "r");
  ck_assert_int_eq(e.index, -1);
  z[11] = INFINITY;
  ck_assert_int_eq(FROM(&p, 4, s, z, r), DLS_E_NOT_FINITE);
  ck_assert_str_eq(e.argument, "z");
  ck_assert_int_eq(e.index, 11);
  ck_assert(A[0] == 9);
  assert_all(b, n, 9);
  assert_all(r, 6, 9);
#undef TO
#undef FROM
}
