/* test_body.c: the certificate of a pair (x, r), its weights and the connected bodies, by hand. */
#include "contact/body.h"
#include "run.h"
#include "stiffness.h"

static stiffness S;

/* Unknowns (t, n) of two nodes, K in 2 x 2 blocks; contact c on node c. H^T and H have the same
 * arrays. */
static const int Hp[] = {0, 1, 2, 3, 4}, Hi[] = {1, 0, 3, 2};
static const double Hx[] = {1, 1, 1, 1};
static const double rows[16] = {4, 1, 0, 0, 1, 4, 0, 0, 0, 0, 100, 0, 0, 0, 0, 25};
static int part[4];
static double w[4], work[200];

/* The body of S with `nc` contacts, H^T of columns p, rows i and entries 1, weights v. */
static dlsi_body body_with(int nc, const int *p, const int *i, const double *v) {
  return (dlsi_body){.n = S.model.n,
                     .model = &S.model,
                     .Ht = {2 * nc, S.model.n, p, i, Hx},
                     .d = 2,
                     .nc = nc,
                     .w = v,
                     .part = part,
                     .parts = dlsi_body_parts(&S.model, part)};
}

static dlsi_body body_of(dls_factorization factorization, int is_sparse) {
  const dls_sparse H = {4, 4, Hp, Hi, Hx};
  stiffness_fill(&S, 4, rows, factorization, is_sparse);
  ck_assert(!dlsi_body_weights(&S.model, &H, 2, w, NULL));
  const dlsi_body body = body_with(2, Hp, Hi, w);
  ck_assert_uint_le(dlsi_body_scratch(&body), 200);
  return body;
}

TEST_EACH(weights_and_parts, 0, 6) {
  const dlsi_body body = body_of((dls_factorization)(1 + _i % 3), _i / 3);
  ck_assert_int_eq(body.parts, 3);
  ck_assert(part[0] == 0 && part[1] == 0 && part[2] == 1 && part[3] == 2);
  assert_near(w, (double[]){4. / 15, 4. / 15, 1. / 25}, 3, 1e-16);
  ck_assert_double_eq_tol(w[3], 1. / 100, 1e-17);
  double y[4], a[4];
  dlsi_body_multiply(&S.model, (const double[]){1, -1, 2, 0}, y, a);
  ck_assert(y[0] == 3 && y[1] == -3 && y[2] == 200 && y[3] == 0);
  ck_assert(a[0] == 5 && a[1] == 5 && a[2] == 200 && a[3] == 0);
}

/* Where K says nothing the others' mean serves, and 1 where none says anything; without tangents
 * w_t = w_n; on more than 24 unknowns the diagonal. */
TEST(weights_guarded) {
  enum { many = 30 };
  double K[many * many] = {0}, v[4], x[many];
  int p[] = {0, 1, 1, 2, 2}, i[many];
  stiffness_fill(&S, 2, (const double[]){5, 0, 0, 0}, DLS_LDLT, 1);
  dls_sparse H = {2, 4, p, (const int[]){0, 1}, Hx};
  ck_assert(!dlsi_body_weights(&S.model, &H, 2, v, NULL));
  ck_assert(v[0] == .2 && v[1] == .2 && v[2] == .2 && v[3] == .2);
  stiffness_fill(&S, 2, (const double[]){0, 0, 0, -1}, DLS_LDLT, 1);
  ck_assert(!dlsi_body_weights(&S.model, &H, 2, v, NULL));
  ck_assert(v[0] == 1 && v[1] == 1 && v[2] == 1 && v[3] == 1);
  for (int k = 0; k < many; k++) {
    K[k + many * k] = 2;
    if (k + 1 < many) K[k + many * (k + 1)] = K[k + 1 + many * k] = -.5;
    i[k] = k;
    x[k] = 1;
  }
  stiffness_fill(&S, many, K, DLS_CHOLESKY, 1);
  const int all[] = {0, many, many};
  H = (dls_sparse){many, 2, all, i, x};
  ck_assert(!dlsi_body_weights(&S.model, &H, 2, v, NULL));
  ck_assert(v[0] == many / 2.);
  for (long k = 1; k <= 3; k++) {
    malloc_fails_at(k);
    const dls_status status = dlsi_body_weights(&S.model, &H, 2, v, NULL);
    malloc_fails_at(0);
    ck_assert_int_eq(status, DLS_E_MEMORY);
  }
}

/* Node 0 slides under (1, -3): u_n = 0, r_n = N, r_t = -mu N. Node 1 hangs 7 above the ground. */
static void slide(double mu, double *x, double *r, double *f) {
  const double t = .5, N = (3 * 4 + 1) / (4 + mu); /* K x = f + H r with x = (t, 0) */
  memset(r, 0, 4 * sizeof *r);
  r[0] = N;
  r[1] = -mu * N;
  x[0] = t;
  x[1] = x[2] = x[3] = 0;
  f[0] = 4 * t + mu * N;
  f[1] = t - N;
  f[2] = f[3] = 0;
}

TEST(exact_pair) {
  const dlsi_body body = body_of(DLS_CHOLESKY, 1);
  const double mu[] = {.25, .25}, far[] = {0, 0, 7e9, 0};
  double x[4], r[4], f[4], u[4];
  dls_certificate c;
  slide(.25, x, r, f);
  dlsi_body_measure(&body, f, far, mu, r, x, u, work, &c);
  ck_assert(u[0] == 0 && u[1] == .5 && u[2] == 7e9);
  ck_assert_msg(c.residual <= 4 * DBL_EPSILON, "%g", c.residual);
  ck_assert(c.floor_u <= 4 * DBL_EPSILON && c.floor_r <= 4 * DBL_EPSILON); /* open: no floor */
  ck_assert(c.floor_e <= 4 * DBL_EPSILON);
  ck_assert(dls_certificate_holds(&c, 1e-12) && dlsi_body_badness(&c) <= 16 * DBL_EPSILON);
  ck_assert(c.penetration == 0 && c.adhesion == 0 && c.complementarity == 0);
}

/* What is wrong shows in its part: a force of 1 that is missing on body 0; a reaction beyond the
 * cone; a contact left out. */
TEST(wrong_pairs) {
  const dlsi_body body = body_of(DLS_CHOLESKY, 1);
  const double mu[] = {.25, .25};
  double x[4], r[4], f[4], u[4];
  dls_certificate c;
  slide(.25, x, r, f);
  f[1] += 1;
  dlsi_body_measure(&body, f, NULL, mu, r, x, u, work, &c);
  ck_assert(c.body == 0 && c.residual == c.equilibrium && c.residual_u <= 1e-15);
  ck_assert_double_eq_tol(c.unbalanced, 1, 1e-14);
  ck_assert_double_eq_tol(c.equilibrium, 1 / (hypot(f[0], f[1]) + hypot(r[0], r[1])), 1e-15);
  ck_assert(!dls_certificate_holds(&c, 1e-2) && dls_certificate_holds(&c, .5));
  f[1] -= 1;
  r[1] *= 1.5;
  dlsi_body_measure(&body, f, NULL, mu, r, x, u, work, &c);
  ck_assert_double_eq_tol(c.cone_violation, .125 * r[0], 1e-14);
  ck_assert(c.residual_r > .05 && c.worst == 0);
  memset(r, 0, sizeof r);
  x[1] = -.125; /* below the ground, without a reaction */
  dlsi_body_measure(&body, f, NULL, mu, r, x, u, work, &c);
  ck_assert(c.penetration == .125 && c.residual_r == 1 && c.residual_u > .1);
  /* no load, no motion: nothing to measure; motion without load is all wrong */
  memset(x, 0, sizeof x);
  dlsi_body_measure(&body, NULL, NULL, mu, r, x, u, work, &c);
  ck_assert(c.residual == 0 && c.body == -1 && dls_certificate_holds(&c, 0));
  x[3] = 1;
  dlsi_body_measure(&body, NULL, NULL, mu, r, x, u, work, &c);
  ck_assert(c.equilibrium == 1 && c.body == 2);
  x[3] = NAN;
  dlsi_body_measure(&body, NULL, NULL, mu, r, x, u, work, &c);
  ck_assert(!dls_certificate_holds(&c, 1) && c.residual != c.residual);
}

/* A rigid motion of 1e8 without force: x rounds, and the floors say so. */
TEST(rounding) {
  stiffness_fill(&S, 2, (const double[]){1, -1, -1, 1}, DLS_CHOLESKY, 1);
  const dlsi_body body = body_with(1, (const int[]){0, 1, 1}, Hp, (const double[]){1, 1});
  const double f[] = {-1, 0}, x[] = {1e8, 1e8}, g[] = {-1e8, 0}, r[] = {1, 0}, mu[] = {0};
  double u[2];
  dls_certificate c;
  dlsi_body_measure(&body, f, g, mu, r, x, u, work, &c);
  ck_assert(c.residual == 0 && u[0] == 0);
  ck_assert(c.floor_u >= DBL_EPSILON && c.floor_u <= 4 * DBL_EPSILON);
  ck_assert(c.floor_r >= 1e8 * DBL_EPSILON && c.floor_r <= 3e8 * DBL_EPSILON);
  ck_assert(c.floor_e >= 1e8 * DBL_EPSILON && c.floor_e <= 3e8 * DBL_EPSILON);
  ck_assert(!dls_certificate_holds(&c, 1e-8) &&
            dls_certificate_verdict(&c, 1e-8) == DLS_TO_ROUNDING);
  ck_assert(dlsi_body_badness(&c) >= 4e8 * DBL_EPSILON);
}

/* Unknowns (t, n) of a node, and one that a penalty of 1e18 holds at 1: K. */
static const double held[9] = {4, 1, -1, 1, 4, 0, -1, 0, 1e18};

/* What a penalty rounds does not hide a contact elsewhere, and no rounding hides a reaction that is
 * far outside its cone: contact of unknowns (n, t) = (1, 0), then (1, 2). */
TEST_EACH(penalties_hide_little, 0, 2) {
  const int on_penalty = _i, p[2][4] = {{0, 1, 2, 2}, {0, 0, 1, 2}}, at[2][2] = {{1, 0}, {0, 1}};
  const double mu[] = {.25}, v[] = {.25, on_penalty ? 1e-18 : .25};
  double share[3], r[2] = {1, 0}, x[3] = {0, 0, 1}, f[3], u[2];
  dls_certificate c;
  stiffness_fill(&S, 3, held, DLS_CHOLESKY, 1);
  dlsi_body_shares(&S.model, share);
  ck_assert(share[0] == .5 && share[1] == .25 && share[2] == 1e-18);
  dlsi_body body = body_with(1, p[on_penalty], at[on_penalty], v);
  body.share = share;
  for (int wrong = 0; wrong < 3; wrong++) {
    r[1] = wrong == 1 ? .9 : 0;  /* outside the cone */
    x[1] = wrong == 2 ? -.5 : 0; /* below the ground */
    const double push[3] = {on_penalty ? 0 : r[1], r[0], on_penalty ? r[1] : 0};
    dlsi_body_multiply(&S.model, x, f, NULL);
    for (int k = 0; k < 3; k++)
      f[k] -= push[k];
    const double g[] = {0, on_penalty ? -1 : 0};
    dlsi_body_measure(&body, f, g, mu, r, x, u, work, &c);
    ck_assert_msg(wrong ? c.residual_r > .1 : c.residual_r == 0, "%d: %g", wrong, c.residual_r);
  }
}

/* A joint pulls with 1e16, which the loads balance: a reaction of 4 is rounding, and says so. A
 * reaction that balances it measures no load of 8. */
TEST(joints_show_rounding) {
  const double K[9] = {1, 0, 0, 0, 1, 1e8, 0, 1e8, 0}, mu[] = {.25}, v[] = {1, 1};
  const double x[] = {0, 0, 1e8}, r[] = {4, 0}, f[] = {0, 1e16 - 4, 0};
  const int p[] = {0, 1, 2, 2}, of_unknown[] = {1, 0};
  int piece[3];
  const int joint[] = {0, 0, 1};
  double u[2];
  dls_certificate c;
  stiffness_fill(&S, 3, K, DLS_LDLT, 1);
  dlsi_body body = body_with(1, p, of_unknown, v);
  body.joint = joint;
  body.piece = piece;
  body.pieces = dlsi_body_pieces(&S.model, joint, piece);
  ck_assert_uint_le(dlsi_body_scratch(&body), 200);
  dlsi_body_measure(&body, f, NULL, mu, r, x, u, work, &c);
  ck_assert(c.residual == 0 && c.floor_r > .1 && c.floor_e < 1e-15);
  ck_assert_int_eq(dls_certificate_verdict(&c, 1e-8), DLS_STALLED);
  const double large[] = {1e16 - 8, 0}, small[] = {0, 8, 0};
  dlsi_body_measure(&body, small, NULL, mu, large, x, u, work, &c);
  ck_assert(c.residual == 0 && c.floor_e > .1);
}
