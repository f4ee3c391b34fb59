/*
 * test_primal.c: projected Gauss-Seidel on the displacements: springs by hand, random systems and
 * the block of [Jean 1988] against Gauss-Seidel on the condensed problem, bad input.
 */
#include "delassus.h"
#include "delassus/fe.h"
#include "made.h"
#include "reduced.h"
#include "run.h"

enum { most = 40, most_nodes = 8 }; /* unknowns, contact nodes of the systems made here */

static dls_error error;
static void ok(dls_status status) {
  ck_assert_msg(status == DLS_OK, "%s: %s", dls_status_name(status), error.message);
}

static dls_primal_settings primal_tol(double tol) {
  dls_primal_settings s;
  dls_primal_settings_init(&s);
  s.limits.tol = tol;
  return s;
}

/* a model with its own storage, K dense and sparse */
typedef struct springs {
  double K[most * most], f[most], g[2 * most_nodes], mu[most_nodes];
  int kp[most + 1], ki[most * most];
  double kx[most * most];
  int np[most_nodes + 1], ni[2 * most_nodes], tp[most_nodes + 1], ti[2 * most_nodes];
  double nx[2 * most_nodes], tx[2 * most_nodes];
  dls_model model;
} springs;

/* node c on unknowns i, j, its normal turned by `angle` from i towards j */
static void set_node(springs *s, int c, int i, int j, double angle) {
  const double co = angle == 0 ? 1 : cos(angle), si = angle == 0 ? 0 : sin(angle);
  const int a = 2 * c, b = a + 1;
  s->np[c] = s->tp[c] = a;
  s->np[c + 1] = s->tp[c + 1] = a + 2;
  s->ni[a] = s->ti[a] = i;
  s->ni[b] = s->ti[b] = j;
  s->nx[a] = co;
  s->nx[b] = si;
  s->tx[a] = -si;
  s->tx[b] = co;
}

/* the sparse K from the dense one, and the views */
static void finish(springs *s, int n, int nodes, dls_operator kind) {
  int k = 0;
  for (int j = 0; j < n; j++) {
    s->kp[j] = k;
    for (int i = 0; i < n; i++)
      if (s->K[i + n * j] != 0) {
        s->ki[k] = i;
        s->kx[k++] = s->K[i + n * j];
      }
  }
  s->kp[n] = k;
  s->model = (dls_model){.d = 2,
                         .n = n,
                         .nodes = nodes,
                         .operator_kind = kind,
                         .factorization = DLS_CHOLESKY,
                         .K = {n, n, n, s->K},
                         .Ks = {n, n, s->kp, s->ki, s->kx},
                         .HN = {n, nodes, s->np, s->ni, s->nx},
                         .HT = {n, nodes, s->tp, s->ti, s->tx}};
}

typedef struct answer {
  double x[most], r[2 * most_nodes], u[2 * most_nodes];
  dls_primal_info info;
} answer;

/* |v| in the norm of the certificate: the 2 x 2 frames are orthogonal here, n, t unit vectors */
static double force_norm(const springs *s, const double *v) {
  const int n = s->model.n;
  double sum = 0, own[most] = {0};
  for (int c = 0; c < s->model.nodes; c++) {
    const int i = s->ni[2 * c], j = s->ni[2 * c + 1];
    const double co = s->nx[2 * c], si = s->nx[2 * c + 1];
    const double a = s->K[i + n * i], b = s->K[j + n * i], d = s->K[j + n * j];
    const double vn = co * v[i] + si * v[j], vt = co * v[j] - si * v[i];
    sum += vn * vn / (co * co * a + 2 * co * si * b + si * si * d);
    sum += vt * vt / (si * si * a - 2 * co * si * b + co * co * d);
    own[i] = own[j] = 1;
  }
  for (int i = 0; i < n; i++)
    if (own[i] == 0) sum += v[i] * v[i] / s->K[i + n * i];
  return sqrt(sum);
}

/* The equilibrium of an answer, by the formula of the header from the model's own arrays. */
static double equilibrium(const springs *s, const answer *a) {
  const int n = s->model.n;
  double e[most], h[most] = {0};
  for (int c = 0; c < s->model.nodes; c++)
    for (int k = 2 * c; k < 2 * c + 2; k++) {
      h[s->ni[k]] += s->nx[k] * a->r[2 * c];
      h[s->ti[k]] += s->tx[k] * a->r[2 * c + 1];
    }
  for (int i = 0; i < n; i++) {
    e[i] = -s->f[i] - h[i];
    for (int j = 0; j < n; j++)
      e[i] += s->K[i + n * j] * a->x[j];
  }
  return force_norm(s, e) / (force_norm(s, s->f) + force_norm(s, h));
}

static dls_status run_springs(const springs *s, const dls_primal_settings *settings, answer *a) {
  dls_primal *work;
  ok(dls_primal_create(&work, &s->model, settings, &error));
  const dls_status status =
      dls_primal_solve(work, s->f, s->g, s->mu, a->x, a->r, a->u, &a->info, &error);
  dls_primal_destroy(work);
  ck_assert_msg(status >= 0, "%s", error.message);
  const dls_primal_info *info = &a->info;
  ck_assert_int_eq(info->status, status);
  const double floor = 4 * info->equilibrium_floor;
  const int holds =
      info->equilibrium <= (floor <= settings->limits.tol ? settings->limits.tol : floor) &&
      dls_certificate_holds(&info->laws, settings->limits.tol);
  ck_assert_int_eq(status == DLS_OK, holds);
  return status;
}

/* ---- by hand --------------------------------------------------------------------------------- */

/* unknowns (normal, tangent[, free]); K by rows */
typedef struct hand_case {
  const char *name;
  int n;
  double K[9], f[3], g[2], mu, x[3], r[2], u[2];
} hand_case;

static const hand_case hand[] = {
    {"free", 2, {2, 0, 0, 1}, {2, 3}, {0, 0}, 1, {1, 3}, {0, 0}, {1, 3}},
    {"nothing", 2, {2, 0, 0, 1}, {0, 0}, {0, 0}, 1, {0, 0}, {0, 0}, {0, 0}},
    {"gap alone", 2, {2, 0, 0, 1}, {0, 0}, {3, 1}, 1, {0, 0}, {0, 0}, {3, 1}},
    {"stick", 2, {2, 0, 0, 1}, {-2, .5}, {0, 0}, 1, {0, 0}, {2, -.5}, {0, 0}},
    {"slip right", 2, {2, 0, 0, 1}, {-2, 5}, {0, 0}, 1, {0, 3}, {2, -2}, {0, 3}},
    {"slip left", 2, {2, 0, 0, 1}, {-2, -5}, {0, 0}, 1, {0, -3}, {2, 2}, {0, -3}},
    {"no friction", 2, {2, 0, 0, 1}, {-2, 5}, {0, 0}, 0, {0, 5}, {2, 0}, {0, 5}},
    /* r_n = u_t + 3, r_t = 2 u_t - f_t = -+ r_n / 2 */
    {"coupled, right", 2, {2, 1, 1, 2}, {-3, 5}, {0, 0}, .5, {0, 1.4}, {4.4, -2.2}, {0, 1.4}},
    {"coupled, left",
     2,
     {2, 1, 1, 2},
     {-3, -5},
     {0, 0},
     .5,
     {0, -7. / 3},
     {2. / 3, 1. / 3},
     {0, -7. / 3}},
    {"coupled, stick", 2, {2, 1, 1, 2}, {-3, 1}, {0, 0}, .5, {0, 0}, {3, -1}, {0, 0}},
    /* free although f_n < 0: the tangent's load lifts it; x = K^-1 f */
    {"coupled, lifted", 2, {2, 1, 1, 2}, {-1, -5}, {0, 0}, .5, {1, -3}, {0, 0}, {1, -3}},
    {"gap closes", 2, {2, 0, 0, 1}, {-2, 0}, {.5, 0}, 1, {-.5, 0}, {1, 0}, {0, 0}},
    {"gap stays open", 2, {2, 0, 0, 1}, {-2, 0}, {2, 1}, 1, {-1, 0}, {0, 0}, {1, 1}},
    {"obstacle moves", 2, {2, 0, 0, 1}, {-2, 0}, {0, -3}, 1, {0, 2}, {2, 2}, {0, -1}},
    {"obstacle pushes", 2, {2, 0, 0, 1}, {0, 0}, {-1, 0}, 1, {1, 0}, {2, 0}, {0, 0}},
/* a chain wall - x_2 - x_n of unit springs, pulled down at x_2, stuck or slipping at its end */
#define CHAIN                                                                                      \
  { 1, 0, -1, 0, 1, 0, -1, 0, 2 }
    {"chain, stick", 3, CHAIN, {-3, 1, -2}, {0, 0}, .5, {0, 0, -1}, {4, -1}, {0, 0}},
    {"chain, slip", 3, CHAIN, {-3, 7, -2}, {0, 0}, .5, {0, 5, -1}, {4, -2}, {0, 5}},
#undef CHAIN
};
enum { hand_count = sizeof hand / sizeof hand[0] };

/* _i: case, and frame: along the axes, or turned by 1 rad with K and f turned along */
TEST_EACH(by_hand, 0, 2 * hand_count) {
  const hand_case *k = &hand[_i / 2];
  const int turned = _i % 2, n = k->n;
  const double co = turned ? cos(1) : 1, si = turned ? sin(1) : 0;
  const double Q[9] = {co, si, 0, -si, co, 0, 0, 0, 1}; /* by columns of 3: x = Q x' */
  springs s = {0};
  double x[3] = {0};
  for (int i = 0; i < n; i++)
    for (int j = 0; j < n; j++) {
      s.f[i] += Q[i + 3 * j] * k->f[j];
      x[i] += Q[i + 3 * j] * k->x[j];
      for (int p = 0; p < n; p++)
        for (int q = 0; q < n; q++)
          s.K[i + n * j] += Q[i + 3 * p] * k->K[n * p + q] * Q[j + 3 * q];
    }
  set_node(&s, 0, 0, 1, turned);
  memcpy(s.g, k->g, sizeof k->g);
  s.mu[0] = k->mu;
  finish(&s, n, 1, DLS_STIFFNESS_DENSE);
  const dls_primal_settings settings = primal_tol(1e-14);
  answer a;
  ck_assert_msg(run_springs(&s, &settings, &a) == DLS_OK, "%s", k->name);
  /* numbers up to 5, condition of K up to 7 */
  for (int i = 0; i < n; i++)
    ck_assert_msg(fabs(a.x[i] - x[i]) <= 1e-12, "%s: x[%d] = %.17g", k->name, i, a.x[i]);
  for (int i = 0; i < 2; i++) {
    ck_assert_msg(fabs(a.r[i] - k->r[i]) <= 1e-12, "%s: r[%d] = %.17g", k->name, i, a.r[i]);
    ck_assert_msg(fabs(a.u[i] - k->u[i]) <= 1e-12, "%s: u[%d] = %.17g", k->name, i, a.u[i]);
  }
}

/* ---- random ---------------------------------------------------------------------------------- */

static uint64_t seed;

/* uniform in (-1, 1) */
static double noise(void) {
  seed ^= seed << 13;
  seed ^= seed >> 7;
  seed ^= seed << 17;
  return ((double)(seed >> 11) + 0.5) * 0x1p-52 - 1;
}

/* K = A A^T / n + I, of eigenvalues 1 .. 5 or so; loads that press; contact nodes anywhere, in
 * inclined frames; K dense for even i. */
static void random_springs(int i, springs *s) {
  static double A[most * most];
  const int nodes = 1 + i % most_nodes, n = 2 * nodes + 3 * i % 20;
  memset(s, 0, sizeof *s);
  seed = 88172645463325252u + (uint64_t)i;
  for (int k = 0; k < n * n; k++)
    A[k] = noise();
  for (int j = 0; j < n; j++)
    for (int k = 0; k <= j; k++) {
      double sum = j == k;
      for (int l = 0; l < n; l++)
        sum += A[j + n * l] * A[k + n * l] / n;
      s->K[j + n * k] = s->K[k + n * j] = sum;
    }
  int place[most];
  for (int k = 0; k < n; k++) {
    const int l = (int)((noise() + 1) / 2 * (k + 1));
    place[k] = place[l];
    place[l] = k;
    s->f[k] = noise();
  }
  for (int c = 0; c < nodes; c++) {
    const int p = place[2 * c], q = place[2 * c + 1];
    set_node(s, c, p, q, 3 * noise());
    s->f[p] -= 2 * s->nx[2 * c];
    s->f[q] -= 2 * s->nx[2 * c + 1];
    s->g[2 * c] = noise() / 3;
    s->g[2 * c + 1] = c % 3 ? 0 : noise();
    s->mu[c] = 0.4 + 0.4 * noise();
  }
  finish(s, n, nodes, i % 2 ? DLS_STIFFNESS_SPARSE : DLS_STIFFNESS_DENSE);
}

/* Solves by Gauss-Seidel on the reactions; *certificate: of r, in the condensed problem. */
static void condensed(const springs *s, const double *r, answer *dual,
                      dls_certificate *certificate) {
  dls_reduction *reduction;
  dls_contact problem;
  ok(reduce_on_W(&reduction, &s->model, NULL, &error));
  ok(dls_reduction_load(reduction, s->f, s->g, &error));
  ok(dls_reduction_contact(reduction, s->mu, &problem, &error));
  ok(dls_contact_certify(&problem, r, NULL, certificate, &error));
  dls_solver_settings settings = settings_with(DLS_AUTO, 1e-14);
  ok(dls_solve(&problem, &settings, dual->r, dual->u, NULL, &error));
  ok(dls_reduction_recover(reduction, dual->r, dual->x, &error));
  dls_reduction_destroy(reduction);
}

static void expect_close(const double *a, const double *b, int n, double close) {
  for (int i = 0; i < n; i++)
    ck_assert_msg(fabs(a[i] - b[i]) <= close, "[%d]: %.17g, not %.17g", i, a[i], b[i]);
}

TEST_EACH(random_system, 0, 40) {
  static springs s, t;
  random_springs(_i, &s);
  const int n = s.model.n, m = 2 * s.model.nodes;
  const double tol = 1e-12;
  const dls_primal_settings settings = primal_tol(tol);
  answer a, b, dual;
  dls_certificate certificate;
  ok(run_springs(&s, &settings, &a));
  ck_assert_int_gt(a.info.iterations, 0);
  ck_assert(fabs(equilibrium(&s, &a) - a.info.equilibrium) <= 4 * a.info.equilibrium_floor);

  /* the answer of the condensed problem, |K^-1| <= 1; measured over these systems: residuals there
   * up to 1.0 tol, errors up to 2.1 tol */
  condensed(&s, a.r, &dual, &certificate);
  ck_assert_double_le(certificate.residual, 4 * tol);
  const double close = 10 * tol * fmax(largest(dual.r, m), largest(dual.x, n));
  expect_close(a.r, dual.r, m, close);
  expect_close(a.u, dual.u, m, close);
  expect_close(a.x, dual.x, n, close);

  /* again: the same bits; from the answer: no sweep; from elsewhere: the same answer */
  ok(run_springs(&s, &settings, &b));
  ck_assert_mem_eq(a.x, b.x, (size_t)n * sizeof *a.x);
  ck_assert_mem_eq(a.r, b.r, (size_t)m * sizeof *a.r);
  ck_assert_mem_eq(&a.info, &b.info, sizeof a.info);
  dls_primal_settings other = settings;
  other.limits.warm_start = 1;
  ok(run_springs(&s, &other, &b));
  ck_assert_int_eq(b.info.iterations, 0);
  expect_close(b.x, a.x, n, 4 * DBL_EPSILON * largest(a.x, n) + 4 * DBL_EPSILON);
  for (int i = 0; i < n; i++)
    b.x[i] = 5 * noise();
  ok(run_springs(&s, &other, &b));
  expect_close(b.r, dual.r, m, close);

  /* plain, and over-relaxed */
  other = settings;
  other.aitken = 0;
  for (int k = 0; k < 2; k++) {
    other.relaxation = k ? 1.3 : 1;
    ok(run_springs(&s, &other, &b));
    expect_close(b.x, dual.x, n, close);
    expect_close(b.r, dual.r, m, close);
  }

  /* K in the other storage, the upper triangle not there: the same bits */
  t = s;
  finish(&t, n, s.model.nodes, _i % 2 ? DLS_STIFFNESS_DENSE : DLS_STIFFNESS_SPARSE);
  if (_i % 2)
    for (int j = 0; j < n; j++)
      for (int i = 0; i < j; i++)
        t.K[i + n * j] = NAN;
  ok(run_springs(&t, &settings, &b));
  ck_assert_mem_eq(a.x, b.x, (size_t)n * sizeof *a.x);

  /* unknowns and contact nodes in reverse order */
  memset(&t, 0, sizeof t);
  for (int j = 0; j < n; j++) {
    t.f[n - 1 - j] = s.f[j];
    for (int i = 0; i < n; i++)
      t.K[n - 1 - i + n * (n - 1 - j)] = s.K[i + n * j];
  }
  for (int c = 0; c < s.model.nodes; c++) {
    const int e = s.model.nodes - 1 - c;
    set_node(&t, e, n - 1 - s.ni[2 * c], n - 1 - s.ni[2 * c + 1],
             atan2(s.nx[2 * c + 1], s.nx[2 * c]));
    memcpy(t.g + 2 * e, s.g + 2 * c, 2 * sizeof *t.g);
    t.mu[e] = s.mu[c];
  }
  for (int c = 0; c <= s.model.nodes; c++)
    t.np[c] = t.tp[c] = 2 * c;
  finish(&t, n, s.model.nodes, DLS_STIFFNESS_SPARSE);
  ok(run_springs(&t, &settings, &b));
  for (int i = 0; i < n; i++)
    ck_assert(fabs(b.x[n - 1 - i] - dual.x[i]) <= close);
  for (int i = 0; i < m; i++)
    ck_assert(fabs(b.r[m - 2 - i + 2 * (i % 2)] - dual.r[i]) <= close);
}

/* The certificate by the formulas of the header, from x, r and u of an early end: K' = T^T K T with
 * the columns of T along n and t, W_cc = K'_cc^-1, q = u - W r, w = trace(W_cc) / 2; floors of
 * |f'| + |K'| |x'| without gaps. */
TEST_EACH(certificate_of_an_early_end, 0, 24) {
  static springs s;
  static double T[most * most], K[most * most], a[most];
  random_springs(_i, &s);
  memset(s.g, 0, sizeof s.g);
  const int n = s.model.n, nodes = s.model.nodes;
  dls_primal_settings settings = primal_tol(1e-14);
  settings.limits.max_iterations = 2;
  answer b;
  ck_assert_int_eq(run_springs(&s, &settings, &b), DLS_MAX_ITERATIONS);
  ck_assert_int_eq(b.info.iterations, 2);
  memset(T, 0, sizeof T);
  for (int k = 0; k < n; k++)
    T[k + n * k] = 1;
  for (int k = 0; k < 2 * nodes; k++) { /* unknown i of a node becomes n, j becomes t */
    T[s.ni[k] + n * s.ni[k - k % 2]] = s.nx[k];
    T[s.ti[k] + n * s.ni[k - k % 2 + 1]] = s.tx[k];
  }
  double load = 0, forces = 0, out = 0, rounding = 0;
  for (int i = 0; i < n; i++) {
    double f = 0;
    for (int k = 0; k < n; k++)
      f += T[k + n * i] * s.f[k];
    a[i] = fabs(f);
    double e = -f;
    for (int j = 0; j < n; j++) {
      double x = 0;
      K[i + n * j] = 0;
      for (int k = 0; k < n; k++) {
        x += T[k + n * j] * b.x[k];
        for (int l = 0; l < n; l++)
          K[i + n * j] += T[k + n * i] * s.K[k + n * l] * T[l + n * j];
      }
      a[i] += fabs(K[i + n * j] * x);
      e += K[i + n * j] * x; /* at the nodes: r */
    }
    int of_node = 0;
    for (int k = 0; k < 2 * nodes; k++)
      of_node |= s.ni[k] == i;
    load += f * f / K[i + n * i];
    *(of_node ? &forces : &out) += e * e / K[i + n * i];
    rounding += a[i] * a[i] / K[i + n * i];
  }
  const double scale = sqrt(load) + sqrt(forces);
  ck_assert_double_eq_tol(b.info.equilibrium, sqrt(out) / scale, 1e-12);
  ck_assert_double_eq_tol(b.info.equilibrium_floor / DBL_EPSILON, sqrt(rounding) / scale, 1e-9);
  double F = 0, force = 0, q2 = 0, r2 = 0, floor = 0, floor_force = 0;
  for (int c = 0; c < nodes; c++) {
    const int i = s.ni[2 * c], j = s.ni[2 * c + 1];
    const double nn = K[i + n * i], nt = K[i + n * j], tt = K[j + n * j], det = nn * tt - nt * nt;
    const double W[4] = {tt / det, -nt / det, -nt / det, nn / det}, w[2] = {W[0], W[3]};
    const double *r = b.r + 2 * c, *u = b.u + 2 * c, at[2] = {a[i], a[j]};
    const double n_of = w[0] * r[0] - u[0], t = w[1] * r[1] - u[1];
    const double wide = s.mu[c] * w[1] / w[0], R = wide * n_of;
    const int inside = fabs(t) <= R, polar = n_of <= 0;
    const double P[2] = {polar ? 0 : n_of, polar ? 0 : inside ? t : R * (t > 0 ? 1 : -1)};
    double all[2], q[2];
    for (int k = 0; k < 2; k++) {
      q[k] = u[k] - W[k] * r[0] - W[k + 2] * r[1];
      all[k] = fabs(u[k]) + fabs(W[k]) * at[0] + fabs(W[k + 2]) * at[1] + fabs(q[k]);
    }
    const double Dr[2] = {w[0] * fabs(r[0]), w[1] * fabs(r[1])};
    const double rounds[2] = {all[0], inside ? all[1] : Dr[1] + wide * (all[0] + Dr[0])};
    for (int k = 0; k < 2; k++) {
      const double v = w[k] * r[k] - P[k];
      F += v * v;
      force += v * v / (w[k] * w[k]);
      if (polar) continue;
      q2 += q[k] * q[k];
      r2 += r[k] * r[k];
      floor += rounds[k] * rounds[k];
      floor_force += rounds[k] * rounds[k] / (w[k] * w[k]);
    }
  }
  const dls_certificate *laws = &b.info.laws;
  ck_assert_double_eq_tol(laws->residual_u, sqrt(F / q2), 1e-9 * sqrt(F / q2) + 1e-14);
  ck_assert_double_eq_tol(laws->residual_r, fmin(1, sqrt(force / r2)), 1e-9);
  ck_assert_double_eq_tol(laws->floor_u / DBL_EPSILON, sqrt(floor / q2), 1e-9 * sqrt(floor / q2));
  if (force < r2)
    ck_assert_double_eq_tol(laws->floor_r / DBL_EPSILON, sqrt(floor_force / r2),
                            1e-9 * sqrt(floor_force / r2));
}

/* What lies behind f, g, mu and the start x is not looked at. */
TEST_EACH(ends_of_arrays, 0, 4) {
  static springs s;
  static answer a;
  memset(&a, 0, sizeof a);
  random_springs(_i, &s);
  dls_primal_settings settings = primal_tol(1e-8);
  settings.limits.warm_start = 1;
  s.f[s.model.n] = s.g[2 * s.model.nodes] = s.mu[s.model.nodes] = a.x[s.model.n] = NAN;
  a.r[2 * s.model.nodes] = a.u[2 * s.model.nodes] = 7;
  ok(run_springs(&s, &settings, &a));
  ck_assert(isnan(a.x[s.model.n]));
  ck_assert(a.r[2 * s.model.nodes] == 7 && a.u[2 * s.model.nodes] == 7);
}

TEST_EACH(units, 0, 16) {
  static springs s, t;
  random_springs(_i, &s);
  const int n = s.model.n, m = 2 * s.model.nodes;
  const dls_primal_settings settings = primal_tol(1e-10);
  answer a, b;
  ok(run_springs(&s, &settings, &a));
  for (int length = -1; length <= 1; length++)
    for (int force = -1; force <= 1; force++)
      for (int two = 0; two < 2; two++) {
        const double al = two ? ldexp(1, 30 * length) : pow(10, 9 * length);
        const double be = two ? ldexp(1, 30 * force) : pow(10, 9 * force);
        t = s;
        for (int k = 0; k < n * n; k++)
          t.K[k] *= be / al;
        for (int k = 0; k < n; k++)
          t.f[k] *= be;
        for (int k = 0; k < m; k++)
          t.g[k] *= al;
        finish(&t, n, s.model.nodes, s.model.operator_kind);
        ok(run_springs(&t, &settings, &b));
        ck_assert_int_eq(b.info.iterations, a.info.iterations);
        ck_assert_int_eq(b.info.thresholds, a.info.thresholds);
        for (int k = 0; two && k < m; k++)
          ck_assert(b.r[k] == be * a.r[k]);
        for (int k = 0; two && k < n; k++)
          ck_assert(b.x[k] == al * a.x[k]);
      }
}

/* Unknowns of several units: K_ij -> s_i K_ij s_j, f_i -> s_i f_i, x_i -> x_i / s_i. */
TEST_EACH(mixed_units, 0, 16) {
  static springs s, t;
  random_springs(_i, &s);
  const int n = s.model.n, nodes = s.model.nodes;
  const dls_primal_settings settings = primal_tol(1e-10);
  answer a, b;
  ok(run_springs(&s, &settings, &a));
  double scale[most];
  for (int i = 0; i < n; i++)
    scale[i] = i % 2 ? 1 : ldexp(1, 30);
  for (int c = 0; c < nodes; c++) /* of a contact node the same for both */
    scale[s.ni[2 * c]] = scale[s.ni[2 * c + 1]] = ldexp(1, c % 2 ? -30 : 10);
  t = s;
  for (int j = 0; j < n; j++) {
    t.f[j] *= scale[j];
    for (int i = 0; i < n; i++)
      t.K[i + n * j] *= scale[i] * scale[j];
  }
  for (int k = 0; k < 2 * nodes; k++) {
    t.nx[k] *= scale[s.ni[k]];
    t.tx[k] *= scale[s.ti[k]];
  }
  finish(&t, n, nodes, s.model.operator_kind);
  ok(run_springs(&t, &settings, &b));
  ck_assert_int_eq(b.info.iterations, a.info.iterations);
  ck_assert_mem_eq(b.r, a.r, (size_t)(2 * nodes) * sizeof *a.r);
  for (int i = 0; i < n; i++)
    ck_assert(b.x[i] * scale[i] == a.x[i]);
}

TEST_EACH(tolerance_zero, 0, 20) { /* the floors end it */
  static springs s;
  random_springs(_i, &s);
  const dls_primal_settings settings = primal_tol(0);
  answer a;
  ok(run_springs(&s, &settings, &a));
  ck_assert(a.info.equilibrium <= 4 * a.info.equilibrium_floor);
  ck_assert(a.info.laws.residual <= 4 * a.info.laws.floor_u);
  ck_assert_int_lt(a.info.iterations, 5000);
}

/* ---- the block of Jean ----------------------------------------------------------------------- */

enum { jean_n = 296, jean_m = 32 };

typedef struct jean {
  dls_fe_scene *scene;
  dls_fe_scene_data data;
  double x[jean_n], r[jean_m], u[jean_m];
  dls_primal_info info;
} jean;

static void open_scene(jean *j, const char *name, int weighted) {
  ok(dls_fe_scene_create(&j->scene, name, weighted, &error));
  dls_fe_scene_get(j->scene, &j->data);
}

static dls_status solve_scene(jean *j, const dls_primal_settings *settings) {
  dls_primal *work;
  ok(dls_primal_create(&work, &j->data.model, settings, &error));
  const dls_status status =
      dls_primal_solve(work, j->data.f, j->data.g, j->data.mu, j->x, j->r, j->u, &j->info, &error);
  dls_primal_destroy(work);
  return status;
}

static const char *const names[] = {"jean-fig3", "jean-fig4"};

TEST_EACH(jean_block, 0, 2) {
  static jean j;
  open_scene(&j, names[_i], 0);
  const double tol = 1e-12;
  const dls_primal_settings settings = primal_tol(tol);
  ok(solve_scene(&j, &settings));

  dls_reduction *reduction;
  dls_contact problem;
  dls_certificate certificate;
  ok(reduce_on_W(&reduction, &j.data.model, NULL, &error));
  ok(dls_reduction_load(reduction, j.data.f, j.data.g, &error));
  ok(dls_reduction_contact(reduction, j.data.mu, &problem, &error));
  /* what is out of balance, at 1e-12 of the forces, moves the contact nodes by K^-1 times it:
   * factors of 5.5 and 420 are measured: normals and tangents have weights of their own */
  ok(dls_contact_certify(&problem, j.r, NULL, &certificate, &error));
  ck_assert_double_le(certificate.residual_u, 10 * tol);
  ck_assert_double_le(certificate.residual_r, 500 * tol);
  dls_solver_settings nlgs = settings_with(DLS_AUTO, 1e-14);
  double x[jean_n], r[jean_m], u[jean_m];
  ok(dls_solve(&problem, &nlgs, r, u, NULL, &error));
  ok(dls_reduction_recover(reduction, r, x, &error));
  expect_close(j.r, r, jean_m, 100 * tol * largest(r, jean_m));
  expect_close(j.u, u, jean_m, 100 * tol * largest(u, jean_m));
  expect_close(j.x, x, jean_n, 100 * tol * largest(x, jean_n));
  dls_contact_state p[jean_m / 2], q[jean_m / 2];
  ok(dls_contact_states(&problem, r, u, q, &error));
  ok(dls_contact_states(&problem, j.r, j.u, p, &error));
  ck_assert_mem_eq(p, q, sizeof p);
  dls_reduction_destroy(reduction);
  dls_fe_scene_destroy(j.scene);
}

TEST_EACH(acceleration_pays, 0, 2) { /* measured: 308, 715, 2341 sweeps; Fig. 4 223, 675, 2044 */
  static jean j;
  open_scene(&j, names[_i], 0);
  dls_primal_settings settings = primal_tol(1e-8);
  ok(solve_scene(&j, &settings));
  const int aitken = j.info.iterations;
  settings.aitken = 0;
  settings.relaxation = 1.7;
  ok(solve_scene(&j, &settings));
  const int relaxed = j.info.iterations;
  settings.relaxation = 1;
  ok(solve_scene(&j, &settings));
  const int plain = j.info.iterations;
  ck_assert_msg(2 * aitken < relaxed && 2 * relaxed < plain, "%d, %d, %d sweeps", aitken, relaxed,
                plain);
  dls_fe_scene_destroy(j.scene);
}

typedef struct watch {
  double least;
  int calls, cancel_at;
} watch;

static int look_at_sweeps(void *data, const dls_progress *progress) {
  watch *w = data;
  if (progress->last) return 0;
  ck_assert_int_eq(progress->iteration, ++w->calls);
  ck_assert_str_eq(progress->method, "gauss-seidel");
  if (progress->residual < w->least) w->least = progress->residual;
  return w->calls == w->cancel_at;
}

TEST(stopped_early) { /* cancelled, at the limit: honest, and the best of all sweeps */
  static jean j;
  open_scene(&j, names[0], 0);
  for (int cancel = 0; cancel < 2; cancel++) {
    watch w = {INFINITY, 0, cancel ? 37 : 0};
    dls_primal_settings settings = primal_tol(1e-8);
    settings.limits.max_iterations = cancel ? 1000 : 60;
    settings.limits.progress = look_at_sweeps;
    settings.limits.progress_data = &w;
    ck_assert_int_eq(solve_scene(&j, &settings), cancel ? DLS_CANCELLED : DLS_MAX_ITERATIONS);
    ck_assert_int_eq(j.info.status, cancel ? DLS_CANCELLED : DLS_MAX_ITERATIONS);
    ck_assert_int_eq(j.info.iterations, cancel ? 37 : 60);
    ck_assert_int_eq(w.calls, j.info.iterations);
    const double residual = fmax(j.info.equilibrium, j.info.laws.residual);
    ck_assert(residual > 1e-8 && residual <= w.least * (1 + 1e-9));
  }
  dls_fe_scene_destroy(j.scene);
}

TEST_EACH(weighted_is_refused, 0, 2) {
  static jean j;
  open_scene(&j, names[_i], 1);
  const dls_primal_settings settings = primal_tol(1e-8);
  dls_primal *work = (dls_primal *)&j;
  ck_assert_int_eq(dls_primal_create(&work, &j.data.model, &settings, &error), DLS_E_UNSUPPORTED);
  ck_assert_ptr_null(work);
  ck_assert_str_eq(error.argument, "P");
  dls_fe_scene_destroy(j.scene);
}

/* One workspace over load steps; nothing is allocated. */
TEST(load_steps) {
  static springs s;
  random_springs(6, &s);
  const int n = s.model.n;
  const dls_primal_settings settings = primal_tol(1e-10);
  answer a, b;
  dls_primal *work;
  ok(dls_primal_create(&work, &s.model, &settings, &error));
  int bad = 0;
  malloc_fails_at(0);
  for (int step = 1; step <= 3; step++) {
    for (int i = 0; i < n; i++)
      s.f[i] *= 1.5;
    bad |= dls_primal_solve(work, s.f, s.g, s.mu, a.x, a.r, NULL, NULL, &error);
  }
  const long calls = malloc_calls(); /* Check allocates, too */
  ck_assert(!bad && calls == 0);
  ok(run_springs(&s, &settings, &b));
  ck_assert_mem_eq(a.x, b.x, (size_t)n * sizeof *a.x);
  /* NULL is 0 */
  ok(dls_primal_solve(work, NULL, NULL, s.mu, a.x, a.r, NULL, NULL, &error));
  assert_all(a.x, n, 0);
  dls_primal_destroy(work);
}

/* The fixed point need not converge: u_t = (5 - b) / K_tt and b = mu (1 + K_nt u_t) multiply an
 * error of b by -3.6. The answer is u_t = 1 / 4.6. */
TEST(fixed_point_cycles) {
  springs s = {.K = {1, .9, .9, 1}, .f = {-1, 5}, .mu = {4}};
  set_node(&s, 0, 0, 1, 0);
  finish(&s, 2, 1, DLS_STIFFNESS_DENSE);
  dls_primal_settings settings = primal_tol(1e-8);
  settings.limits.max_iterations = 500;
  answer a;
  ck_assert_int_eq(run_springs(&s, &settings, &a), DLS_MAX_ITERATIONS);
  ck_assert_int_eq(a.info.iterations, 500);
  ck_assert(a.info.laws.residual > 1e-3);
}

/* A chain of n - 2 unit springs from a wall to the contact, whose normal stands at the end. */
static void make_chain(springs *s, int n) {
  memset(s, 0, sizeof *s);
  for (int i = 2; i < n; i++) {
    s->f[i] = -1;
    s->K[i + n * i] = 2;
    if (i + 1 < n) s->K[i + n * (i + 1)] = s->K[i + 1 + n * i] = -1;
  }
  s->K[0] = 2;
  s->K[1 + n] = 1;
  s->K[n - 1] = s->K[n * (n - 1)] = -1;
  s->f[0] = -1;
  s->f[1] = .3;
  s->mu[0] = .5;
  set_node(s, 0, 0, 1, 0);
  finish(s, n, 1, DLS_STIFFNESS_DENSE);
}

/* tol = 0: the floors that end it are those of a fresh R, taken every 50 sweeps at least. The long
 * chain is slow: 50 sweeps earlier the certificate does not hold yet. The short ones take more than
 * 50 and more than 100 sweeps, before which x, and the floors with it, had settled: one sweep
 * earlier the certificate does not hold. */
TEST(floors_are_kept_up_to_date) {
  static const struct {
    int n, least, earlier;
  } chain[] = {{most, 1000, 50}, {7, 100, 1}, {6, 50, 1}};
  for (int k = 0; k < 3; k++) {
    static springs s;
    make_chain(&s, chain[k].n);
    dls_primal_settings settings = primal_tol(0);
    settings.aitken = 0;
    answer a;
    ok(run_springs(&s, &settings, &a));
    ck_assert_int_gt(a.info.iterations, chain[k].least);
    settings.limits.max_iterations = a.info.iterations - chain[k].earlier;
    ck_assert_int_eq(run_springs(&s, &settings, &a), DLS_MAX_ITERATIONS);
  }
}

TEST(overflow_is_not_solved) { /* f^2 / K_ii is not a number of this arithmetic */
  springs s = {.K = {2, 0, 0, 1}, .f = {-1e200, 1e200}, .mu = {1}};
  set_node(&s, 0, 0, 1, 0);
  finish(&s, 2, 1, DLS_STIFFNESS_DENSE);
  const dls_primal_settings settings = primal_tol(1e-8);
  answer a;
  ck_assert_int_eq(run_springs(&s, &settings, &a), DLS_STALLED);
}

/* ---- bad input ------------------------------------------------------------------------------- */

static void expect_create(const dls_model *model, const dls_primal_settings *settings,
                          dls_status status, const char *argument, long long index) {
  dls_primal *work = (dls_primal *)&error; /* must become NULL */
  memset(&error, 0, sizeof error);
  ck_assert_int_eq(dls_primal_create(&work, model, settings, &error), status);
  ck_assert_ptr_null(work);
  ck_assert_int_eq(error.status, status);
  ck_assert_str_eq(error.function, "dls_primal_create");
  ck_assert_str_eq(error.argument, argument);
  ck_assert_msg(error.index == index, "%s", error.message);
  ck_assert_int_eq(dls_primal_create(&work, model, settings, NULL), status);
}

TEST(bad_settings) {
  static springs s;
  random_springs(6, &s);
  const dls_primal_settings good = primal_tol(1e-8);
  REFUSES(ARGUMENT, "out", -1, dls_primal_create, NULL, &s.model, &good);
  dls_primal *work;
  ck_assert_int_eq(dls_primal_create(&work, &s.model, NULL, &error), DLS_OK); /* the defaults */
  dls_primal_destroy(work);
  dls_primal_settings bad = {0};
  expect_create(&s.model, &bad, DLS_E_SETTINGS, "settings", -1);
  const double tol[] = {-1, NAN, INFINITY}, relaxation[] = {0, 2, -1, NAN, INFINITY};
  for (int k = 0; k < 3; k++) {
    bad = good;
    bad.limits.tol = tol[k];
    expect_create(&s.model, &bad, DLS_E_ARGUMENT, "tol", -1);
  }
  for (int k = 0; k < 5; k++) {
    bad = good;
    bad.relaxation = relaxation[k];
    expect_create(&s.model, &bad, DLS_E_ARGUMENT, "relaxation", -1);
  }
  bad = good;
  bad.limits.max_iterations = -1;
  expect_create(&s.model, &bad, DLS_E_ARGUMENT, "max_iterations", -1);
  bad = good;
  bad.aitken = 2;
  expect_create(&s.model, &bad, DLS_E_ARGUMENT, "aitken", -1);
  bad = good;
  bad.limits.warm_start = -1;
  expect_create(&s.model, &bad, DLS_E_ARGUMENT, "warm_start", -1);
  dls_primal_settings_init(NULL);
  dls_primal_destroy(NULL);
}

TEST(bad_model) {
  static springs a, b;
  random_springs(6, &a); /* 7 contact nodes, 32 unknowns, dense */
  const int n = a.model.n, nodes = a.model.nodes;
  ck_assert(n == 32 && nodes == 7);
  const dls_primal_settings settings = primal_tol(1e-8);
  expect_create(NULL, &settings, DLS_E_ARGUMENT, "model", -1);
#define WITH(change, status, argument, index)                                                      \
  do {                                                                                             \
    b = a;                                                                                         \
    finish(&b, n, nodes, DLS_STIFFNESS_DENSE);                                                     \
    change;                                                                                        \
    expect_create(&b.model, &settings, status, argument, index);                                   \
  } while (0)
  WITH(b.model.d = 4, DLS_E_ARGUMENT, "d", -1);
  WITH(b.model.n = 0, DLS_E_SIZE, "n", -1);
  WITH(b.model.nodes = -1, DLS_E_SIZE, "nodes", -1);
  WITH(b.model.K.a = NULL, DLS_E_ARGUMENT, "K", -1);
  WITH(b.K[5 + n * 3] = NAN, DLS_E_NOT_FINITE, "K", 5 + n * 3);
  WITH(b.nx[3] = INFINITY, DLS_E_NOT_FINITE, "HN", 3);
  WITH(b.ti[3] = n, DLS_E_ARGUMENT, "HT", 3);
  WITH((b.model.operator_kind = DLS_STIFFNESS_SPARSE, b.kx[9] = NAN), DLS_E_NOT_FINITE, "Ks", 9);
  WITH((b.model.operator_kind = DLS_STIFFNESS_SPARSE, b.ki[9] = -1), DLS_E_ARGUMENT, "Ks", 9);

  /* what the method cannot do */
  WITH(b.model.operator_kind = DLS_FLEXIBILITY, DLS_E_UNSUPPORTED, "operator_kind", -1);
  WITH(b.model.factorization = DLS_LU, DLS_E_UNSUPPORTED, "factorization", -1);
  int p[15];
  for (int k = 0; k < 15; k++)
    p[k] = k < 14 ? k : 14;
  WITH((b.model.d = 3, b.model.HT = (dls_sparse){n, 14, p, b.ti, b.tx}), DLS_E_UNSUPPORTED, "d",
       -1);
  const int one[8] = {0, 1, 2, 3, 4, 5, 6, 7}, *row = one;
  const double weight[7] = {1, 1, 1, 1, 1, 1, 1};
  WITH((b.model.P = (dls_sparse){7, 7, one, row, weight}), DLS_E_UNSUPPORTED, "P", -1);
  const int other = a.ni[0];
  WITH(b.ni[5] = other, DLS_E_UNSUPPORTED, "HT", 2);                    /* three unknowns with HN */
  WITH((b.ni[5] = other, b.ti[5] = other), DLS_E_UNSUPPORTED, "HN", 2); /* node 0's */
  WITH((b.nx[4] = b.nx[5] = 0), DLS_E_UNSUPPORTED, "HN", 2);
  WITH((b.tx[4] = b.tx[5] = 0), DLS_E_UNSUPPORTED, "HT", 2);
  WITH((b.tx[4] = b.nx[4], b.tx[5] = b.nx[5]), DLS_E_UNSUPPORTED, "HT", 2);
  WITH((b.np[2] = 5, b.ni[4] = other), DLS_E_UNSUPPORTED, "HN", 1); /* three of its own */

  /* not positive definite: on the diagonal of a free unknown, within a contact node, an overflow */
  int i = 0;
  for (int c = 0; c < nodes; c++) /* a free unknown: the last that no node has */
    for (int k = 0; k < 2 * nodes; k++)
      if (a.ni[k] == i) i++, k = -1;
  WITH(b.K[i + n * i] = 0, DLS_E_NOT_POSITIVE_DEFINITE, "K", i);
  ck_assert(error.value == 0);
  WITH(b.K[i + n * i] = -3, DLS_E_NOT_POSITIVE_DEFINITE, "K", i);
  ck_assert(error.value == -3);
  WITH((b.K[i + n * i] = 0, finish(&b, n, nodes, DLS_STIFFNESS_SPARSE)),
       DLS_E_NOT_POSITIVE_DEFINITE, "Ks", i);
  const int q = a.ni[2], t = a.ni[3];
  WITH((set_node(&b, 1, q, t, 0), b.K[q + n * t] = b.K[t + n * q] = 9), DLS_E_NOT_POSITIVE_DEFINITE,
       "K", t);
  ck_assert(error.value < 0);
  WITH((b.model.operator_kind = DLS_STIFFNESS_SPARSE, b.ki[0] = b.ki[1] = 0,
        b.kx[0] = b.kx[1] = DBL_MAX),
       DLS_E_NOT_FINITE, "Ks", -1);
}

/* Positive diagonal, and still not positive definite: found on the way, wherever x starts. */
TEST(negative_curvature) {
  springs s = {
      .K = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 2, 0, 0, 2, 1}, .f = {-1, 0, 1, 1.5}, .mu = {.5}};
  set_node(&s, 0, 0, 1, 0);
  finish(&s, 4, 1, DLS_STIFFNESS_DENSE);
  for (int k = 0; k < 4; k++) {
    dls_primal_settings settings = primal_tol(1e-8);
    settings.aitken = k % 2;
    settings.relaxation = k < 2 ? 1 : 1.5;
    dls_primal *work;
    answer a, same;
    memset(&a, 7, sizeof a);
    same = a;
    ok(dls_primal_create(&work, &s.model, &settings, &error));
    REFUSES(NOT_POSITIVE_DEFINITE, "K", -1, dls_primal_solve, work, s.f, s.g, s.mu, a.x, a.r, a.u,
            &a.info);
    ck_assert(last_refusal.value < 0 && last_refusal.value >= -1); /* -1: the lowest eigenvalue */
    ck_assert_mem_eq(&a, &same, sizeof a);
    dls_primal_destroy(work);
  }
}

static void expect_solve(dls_primal *work, const double *f, const double *g, const double *mu,
                         double *x, double *r, dls_status status, const char *argument,
                         long long index) {
  answer a, same;
  memset(&a, 7, sizeof a);
  same = a;
  double x_before[most], r_before[2 * most_nodes];
  if (x) memcpy(x_before, x, sizeof x_before);
  if (r) memcpy(r_before, r, sizeof r_before);
  ck_assert_int_eq(dls_primal_solve(work, f, g, mu, x, r, a.u, &a.info, &error), status);
  ck_assert_str_eq(error.function, "dls_primal_solve");
  ck_assert_str_eq(error.argument, argument);
  ck_assert(error.index == index);
  ck_assert_mem_eq(&a, &same, sizeof a);
  if (x) ck_assert_mem_eq(x, x_before, sizeof x_before);
  if (r) ck_assert_mem_eq(r, r_before, sizeof r_before);
}

TEST(bad_solve) {
  static springs s;
  random_springs(6, &s);
  dls_primal_settings settings = primal_tol(1e-8);
  settings.limits.warm_start = 1;
  dls_primal *work;
  ok(dls_primal_create(&work, &s.model, &settings, &error));
  double x[most] = {0}, r[2 * most_nodes] = {0}, f[most], g[2 * most_nodes], mu[most_nodes];
#define SOLVE(change, status, argument, index)                                                     \
  do {                                                                                             \
    memcpy(f, s.f, sizeof f);                                                                      \
    memcpy(g, s.g, sizeof g);                                                                      \
    memcpy(mu, s.mu, sizeof mu);                                                                   \
    change;                                                                                        \
    expect_solve(work, f, g, mu, x, r, status, argument, index);                                   \
  } while (0)
  SOLVE(f[31] = NAN, DLS_E_NOT_FINITE, "f", 31);
  SOLVE(g[3] = -INFINITY, DLS_E_NOT_FINITE, "g", 3);
  SOLVE(mu[4] = NAN, DLS_E_NOT_FINITE, "mu", 4);
  SOLVE(mu[4] = -.1, DLS_E_ARGUMENT, "mu", 4);
  x[7] = INFINITY;
  SOLVE((void)0, DLS_E_NOT_FINITE, "x", 7);
  x[7] = 0;
  expect_solve(NULL, f, g, mu, x, r, DLS_E_ARGUMENT, "workspace", -1);
  expect_solve(work, f, g, NULL, x, r, DLS_E_ARGUMENT, "mu", -1);
  expect_solve(work, f, g, mu, NULL, r, DLS_E_ARGUMENT, "x", -1);
  expect_solve(work, f, g, mu, x, NULL, DLS_E_ARGUMENT, "r", -1);
  dls_primal_destroy(work);
}

TEST(no_memory) {
  static springs s;
  random_springs(7, &s);
  const dls_primal_settings settings = primal_tol(1e-8);
  dls_primal *work;
  MALLOCS_FAIL(dls_primal_create(&work, &s.model, &settings, &error), !work, DLS_OK, 1);
  dls_primal_destroy(work);
}
