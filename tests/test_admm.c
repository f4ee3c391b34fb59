/* test_admm.c: splitting with a factorisation, on problems solved by hand, on random ones, on bad
 * input. */
#include <check.h>
#include <float.h>
#include <limits.h>
#include <math.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

#include "delassus/admm.h"
#include "delassus/solve.h"
#include "failures.h"
#include "malloc_fails.h"

enum { most = 60 }; /* unknowns of the largest problem below */

static uint64_t seed;

/* uniform in (-1, 1) */
static double uniform(void) {
  seed ^= seed << 13;
  seed ^= seed >> 7;
  seed ^= seed << 17;
  return ((double)(seed >> 11) + 0.5) * 0x1p-52 - 1;
}

/* a problem with its own storage; W dense, column-major */
typedef struct model {
  double W[most * most], q[most], mu[most / 2];
  dls_contact p;
} model;

static void set_model(model *a, int d, int nc) {
  const int m = d * nc;
  memset(a, 0, sizeof *a);
  a->p.d = d;
  a->p.nc = nc;
  a->p.W.rows = a->p.W.cols = a->p.W.ld = m;
  a->p.W.a = a->W;
  a->p.q = a->q;
  a->p.mu = a->mu;
}

/* W = A A^T / m + I / 10, symmetric positive definite; q_n mostly < 0 */
static void random_model(model *a, int d, int nc, double mu) {
  const int m = d * nc;
  static double A[most * most];
  set_model(a, d, nc);
  for (int k = 0; k < m * m; k++)
    A[k] = uniform();
  for (int i = 0; i < m; i++)
    for (int j = 0; j <= i; j++) {
      double s = i == j ? 0.1 : 0;
      for (int k = 0; k < m; k++)
        s += A[i + m * k] * A[j + m * k] / m;
      a->W[i + m * j] = a->W[j + m * i] = s;
    }
  for (int i = 0; i < m; i++)
    a->q[i] = uniform() - (i % d == 0 ? 0.5 : 0);
  for (int c = 0; c < nc; c++)
    a->mu[c] = mu;
}

static dls_status run(const dls_contact *p, const dls_admm_settings *settings, double *r, double *u,
                      dls_info *info) {
  dls_admm *work;
  dls_error error;
  ck_assert_int_eq(dls_admm_create(&work, p->d, p->nc, settings, &error), DLS_OK);
  const dls_status status = dls_admm_solve(work, p, r, u, info, &error);
  ck_assert(status >= 0);
  ck_assert_int_eq(info->status, status);
  ck_assert_int_eq(info->method, DLS_ADMM);
  dls_admm_destroy(work);

  /* what it says of r is what the public certificate says, and OK means that it holds */
  dls_certificate c;
  double v[most];
  ck_assert_int_eq(dls_contact_certify(p, r, v, &c, &error), DLS_OK);
  ck_assert(c.residual == info->certificate.residual && c.floor == info->certificate.floor);
  ck_assert_int_eq(status == DLS_OK, dls_certificate_holds(&c, settings->tol));
  if (u) ck_assert_mem_eq(u, v, (size_t)(p->d * p->nc) * sizeof *u);
  return status;
}

static dls_admm_settings with_tol(double tol) {
  dls_admm_settings s;
  dls_admm_settings_init(&s);
  s.tol = tol;
  return s;
}

/* ---- by hand --------------------------------------------------------------------------------- */

typedef struct hand_case {
  const char *name;
  int d, nc;
  double W[36]; /* by rows */
  double q[6], mu, r[6];
} hand_case;

static const hand_case hand[] = {
    {"separate", 2, 1, {2, 1, 1, 2}, {1, -3}, 1, {0, 0}},
    {"q = 0", 2, 1, {2, 1, 1, 2}, {0, 0}, 1, {0, 0}},
    {"stick", 2, 1, {2, 0, 0, 1}, {-2, .5}, 1, {1, -.5}},
    {"slip right", 2, 1, {2, 0, 0, 1}, {-2, 5}, 1, {1, -1}},
    {"slip left", 2, 1, {2, 0, 0, 1}, {-2, -5}, 1, {1, 1}},
    {"coupled stick", 2, 1, {2, 1, 1, 2}, {-3.5, -1}, .5, {2, -.5}},
    {"coupled slip left", 2, 1, {2, 1, 1, 2}, {-5, -6}, .5, {2, 1}},
    {"coupled slip right", 2, 1, {2, 1, 1, 2}, {-3, 1}, .5, {2, -1}},
    {"no friction", 2, 1, {2, 1, 1, 2}, {-4, 3}, 0, {2, 0}},
    /* normals coupled: 2 r_1 + r_2 = 3, r_1 + 2 r_2 = 3; one sticks, one slips left */
    {"two",
     2,
     2,
     {2, 0, 1, 0, 0, 1, 0, 0, 1, 0, 2, 0, 0, 0, 0, 1},
     {-3, .25, -3, -3},
     .5,
     {1, -.25, 1, .5}},
    /* the second is lifted off by the first: u_n2 = 1 - 0.5 */
    {"one lifts off",
     2,
     2,
     {2, 0, 1, 0, 0, 1, 0, 0, 1, 0, 2, 0, 0, 0, 0, 1},
     {-2, 0, -.5, 9},
     1,
     {1, 0, 0, 0}},
    /* without friction: 2 r_1 + r_2 = 3, r_1 + 2 r_2 = 3 whatever the tangents do; W not symmetric
     * */
    {"two without friction",
     2,
     2,
     {2, 5, 1, 0, -5, 9, 0, 7, 1, 0, 2, 3, 0, -7, -3, 9},
     {-3, 4, -3, 1},
     0,
     {1, 0, 1, 0}},
    /* u = (2 - 1/2 - 3/2, -1 - 1/2 + 3/2) */
    {"not symmetric", 2, 1, {2, 1, -1, 1}, {-1.5, 1.5}, 1, {1, -.5}},
    {"slip in 3D", 3, 1, {2, 0, 0, 0, 1, 0, 0, 0, 1}, {-2, 3, 4}, 1, {1, -.6, -.8}},
    /* W + rho D is singular at first: w = 1, W_tt = -1; the tangent is held by mu = 0 */
    {"singular", 2, 1, {3, 0, 0, -1}, {-3, 1}, 0, {1, 0}},
};

static void set_hand(model *a, const hand_case *k) {
  const int m = k->d * k->nc;
  set_model(a, k->d, k->nc);
  for (int i = 0; i < m; i++) {
    a->q[i] = k->q[i];
    for (int j = 0; j < m; j++)
      a->W[i + m * j] = k->W[m * i + j];
  }
  for (int c = 0; c < k->nc; c++)
    a->mu[c] = k->mu;
}

START_TEST(by_hand) {
  const hand_case *k = &hand[_i];
  static model a;
  set_hand(&a, k);
  const dls_admm_settings s = with_tol(1e-14);
  double r[6], u[6];
  dls_info info;
  ck_assert_msg(run(&a.p, &s, r, u, &info) == DLS_OK, "%s: %g", k->name, info.certificate.residual);
  for (int i = 0; i < k->d * k->nc; i++) /* |W^-1| < 3 */
    ck_assert_msg(fabs(r[i] - k->r[i]) <= 1e-12, "%s: r[%d] = %.17g", k->name, i, r[i]);
  if (strcmp(k->name, "singular") == 0) ck_assert_int_eq(info.factorisations, 2);
}
END_TEST

/* W = D = 1, q = (-1, 0), so r = (1, 0): from v = z = 0 (D2) gives (1 + rho) x = 1, (D4) v = 1.6 x,
 * and then z = v, (1 + rho) x' = rho v + 1. */
START_TEST(first_iterations) {
  static model a;
  const hand_case k = {"", 2, 1, {1, 0, 0, 1}, {-1, 0}, 1, {1, 0}};
  set_hand(&a, &k);
  dls_admm_settings s = with_tol(0);
  double r[2];
  dls_info info;
  for (int e = -2; e <= 2; e++) {
    s.rho = pow(10, e);
    const double x = 1 / (1 + s.rho);
    s.max_iterations = 1;
    ck_assert_int_eq(run(&a.p, &s, r, NULL, &info), DLS_MAX_ITERATIONS);
    ck_assert(fabs(r[0] - x) <= 1e-15 && r[1] == 0);
    const double x2 = (s.rho * 1.6 * x + 1) / (1 + s.rho);
    if (fabs(x2 - 1) >= fabs(x - 1)) continue; /* the better one is returned */
    s.max_iterations = 2;
    ck_assert_int_eq(run(&a.p, &s, r, NULL, &info), DLS_MAX_ITERATIONS);
    ck_assert(fabs(r[0] - x2) <= 1e-15 && r[1] == 0);
  }
}
END_TEST

START_TEST(ambiguous) { /* C1: from any of its solutions no step is taken */
  static model a;
  const hand_case k = {"C1", 2, 1, {1, 1, 1, 2}, {1, 4}, 2, {0}};
  static const double start[3][2] = {{0, 0}, {2, -3}, {1, -2}};
  set_hand(&a, &k);
  dls_admm_settings s = with_tol(1e-12);
  s.warm_start = 1;
  for (int i = 0; i < 3; i++) {
    double r[2] = {start[i][0], start[i][1]}, u[2];
    dls_info info;
    ck_assert_int_eq(run(&a.p, &s, r, u, &info), DLS_OK);
    ck_assert(r[0] == start[i][0] && r[1] == start[i][1]);
    ck_assert(info.iterations == 0 && info.factorisations == 0);
  }
}
END_TEST

START_TEST(jammed) { /* C3 at mu >= 1, and C4, have no solution */
  static const hand_case k[] = {
      {"C3", 2, 1, {1, 1, 1, 1}, {-2, 0}, 1, {0}},
      {"C3", 2, 1, {1, 1, 1, 1}, {-2, 0}, 2, {0}},
      {"C4", 2, 2, {1, 0, -1, 0, 0, 1, 0, 1, -1, 0, 1, 0, 0, 1, 0, 1}, {-1, 0, -1, 0}, .3, {0}},
      {"C3, 3D", 3, 1, {1, 1, 0, 1, 1, 0, 0, 0, 1}, {-2, 0, 0}, 2, {0}},
      {"W = 0", 2, 1, {0}, {-1, 0}, 1, {0}},
  };
  static model a;
  set_hand(&a, &k[_i]);
  for (int way = 0; way < 4; way++) {
    dls_admm_settings s = with_tol(1e-8);
    s.rho = pow(10, way - 2);
    double r[6], u[6];
    dls_info info;
    const dls_status status = run(&a.p, &s, r, u, &info);
    ck_assert_msg(status == DLS_STALLED || status == DLS_MAX_ITERATIONS, "%s, way %d: %d, %g",
                  k[_i].name, way, status, info.certificate.residual);
    ck_assert(info.certificate.residual > 0.1 && info.certificate.residual <= 1 + 1e-15);
  }
}
END_TEST

START_TEST(hyperstatic) { /* C5: two contacts that share everything */
  static model a;
  const hand_case k = {
      "C5", 2, 2, {1, 0, 1, 0, 0, 1, 0, 1, 1, 0, 1, 0, 0, 1, 0, 1}, {-1, .25, -1, .25}, .5, {0}};
  set_hand(&a, &k);
  const dls_admm_settings s = with_tol(1e-13);
  double r[4];
  dls_info info;
  ck_assert_int_eq(run(&a.p, &s, r, NULL, &info), DLS_OK);
  ck_assert(fabs(r[0] + r[2] - 1) <= 1e-12 && fabs(r[1] + r[3] + .25) <= 1e-12);
}
END_TEST

/* data/failures: "solved" only where there is a solution, and then with the certificate (run): all
 * that have one, from any rho, C10 (a window of rho without acceleration), C11, C13, C14, C15, C19
 * among them. Solved is right: where the solution is known to be unique, this is it. */
START_TEST(catalogue) {
  static char names[128][64];
  static failure f;
  char why[200];
  const double rho[] = {0.01, 0.03, 0.1, 0.3, 1, 3, 10, 100};
  const int n = failures_list(TEST_DATA "/failures", names, 128);
  int contacts = 0;
  for (int i = 0; i < n; i++) {
    ck_assert_msg(failure_read(TEST_DATA "/failures", names[i], &f, why), "%s", why);
    if (!f.d) continue;
    const dls_contact p = {.d = f.d, .nc = f.nc, .W = {f.n, f.n, f.n, f.M}, .q = f.q, .mu = f.mu};
    dls_admm_settings s = with_tol(1e-12);
    s.rho = rho[_i];
    double r[FAILURE_N];
    dls_info info;
    const dls_status status = run(&p, &s, r, NULL, &info);
    ck_assert_msg(status == (f.none ? DLS_MAX_ITERATIONS : DLS_OK), "%s, rho = %g: %d", f.name,
                  s.rho, status);
    ck_assert_int_le(info.factorisations, 9);
    contacts++;
    if (f.none || f.continua || f.points != 1) continue;
    double largest = 0;
    for (int k = 0; k < f.n; k++)
      largest = fmax(largest, fabs(f.point[0].x[k]));
    for (int k = 0; k < f.n; k++) /* |W^-1| is 2e6 in C19 */
      ck_assert_msg(fabs(r[k] - f.point[0].x[k]) <= 1e-5 * largest, "%s: r[%d] = %.17g", f.name, k,
                    r[k]);
  }
  ck_assert_int_ge(contacts, 20);
}
END_TEST

/* Any start: what comes back is never worse than it. */
START_TEST(never_worse) {
  static model a;
  random_model(&a, 2 + _i % 2, 3, 2);
  seed = 362436069 + (uint64_t)_i;
  dls_admm_settings s = with_tol(1e-14);
  s.warm_start = 1;
  s.max_iterations = 1 + _i % 3;
  s.rho = pow(10, _i % 5 - 2);
  double r[9];
  for (int i = 0; i < 9; i++)
    r[i] = uniform();
  dls_certificate before;
  ck_assert_int_eq(dls_contact_certify(&a.p, r, NULL, &before, NULL), DLS_OK);
  dls_info info;
  (void)run(&a.p, &s, r, NULL, &info);
  ck_assert(info.certificate.residual <= before.residual);
}
END_TEST

START_TEST(start_that_overflows) { /* is dropped */
  static model a;
  set_hand(&a, &hand[2]);
  dls_admm_settings s = with_tol(1e-14);
  s.warm_start = 1;
  double r[2] = {1e308, -1e308};
  dls_info info;
  ck_assert_int_eq(run(&a.p, &s, r, NULL, &info), DLS_OK);
  ck_assert(fabs(r[0] - 1) <= 1e-12 && fabs(r[1] + .5) <= 1e-12);
}
END_TEST

typedef struct watch {
  double least;
  int iterations, cancel_at;
} watch;

static int look(void *data, const dls_progress *progress) {
  watch *w = data;
  ck_assert_str_eq(progress->method, "admm");
  ck_assert_int_eq(progress->iteration, ++w->iterations);
  if (progress->residual < w->least) w->least = progress->residual;
  return w->iterations == w->cancel_at;
}

START_TEST(cancelled) { /* cancelled, or at the limit: the best of what was met */
  static model a;
  seed = 521288629;
  random_model(&a, 3, 20, 0.6);
  dls_admm_settings s = with_tol(1e-15);
  watch w = {INFINITY, 0, _i ? 7 : 0};
  s.progress = look;
  s.progress_data = &w;
  s.max_iterations = _i ? 1000 : 5;
  double r[most];
  dls_info info;
  ck_assert_int_eq(run(&a.p, &s, r, NULL, &info), _i ? DLS_CANCELLED : DLS_MAX_ITERATIONS);
  ck_assert_int_eq(info.iterations, _i ? 7 : 5);
  ck_assert_int_eq(w.iterations, info.iterations);
  ck_assert(fabs(info.certificate.residual - w.least) <= 1e-12); /* u(x) is W x + q */
}
END_TEST

/* ---- random ---------------------------------------------------------------------------------- */

static void from_problem(int i, model *a) {
  seed = 88172645463325252u + (uint64_t)i;
  const double mu[] = {0, 0.1, 0.3, 0.6};
  random_model(a, 2 + i % 2, 1 + i % 20, mu[i % 4]);
}

START_TEST(random_problem) {
  static model a;
  from_problem(_i, &a);
  const int d = a.p.d, nc = a.p.nc, m = d * nc;
  const dls_admm_settings s = with_tol(1e-12);
  double r[most], u[most], r2[most];
  dls_info info, info2;
  ck_assert_int_eq(run(&a.p, &s, r, u, &info), DLS_OK);
  ck_assert(info.certificate.residual <= 1e-12);

  /* again: the same bits */
  ck_assert_int_eq(run(&a.p, &s, r2, NULL, &info2), DLS_OK);
  ck_assert_mem_eq(r, r2, (size_t)m * sizeof *r);
  ck_assert_int_eq(info.iterations, info2.iterations);

  /* from the answer: no iteration */
  dls_admm_settings warm = s;
  warm.warm_start = 1;
  ck_assert_int_eq(run(&a.p, &warm, r2, NULL, &info2), DLS_OK);
  ck_assert_mem_eq(r, r2, (size_t)m * sizeof *r);
  ck_assert(info2.iterations == 0 && info2.factorisations == 0);

  /* from anywhere, off the cone too; |r - r2| <= |W^-1| (|F| + |F2|) or so, W >= I / 10 */
  double q2 = 0;
  for (int k = 0; k < m; k++) {
    q2 += a.q[k] * a.q[k];
    r2[k] = 5 * uniform();
  }
  const double close = 1000 * 1e-12 * sqrt(q2);
  ck_assert_int_eq(run(&a.p, &warm, r2, NULL, &info2), DLS_OK);
  for (int k = 0; k < m; k++)
    ck_assert(fabs(r[k] - r2[k]) <= close);

  /* W by blocks: the same bits */
  static double x[most * most];
  int p[most + 1], i[most * most];
  for (int b = 0, k = 0; b < nc; b++) {
    p[b] = k;
    for (int c = 0; c < nc; c++, k++) {
      i[k] = c;
      for (int e = 0; e < d * d; e++)
        x[k * d * d + e] = a.W[d * c + e % d + m * (d * b + e / d)];
    }
    p[b + 1] = k;
  }
  dls_contact blocks = a.p;
  memset(&blocks.W, 0, sizeof blocks.W);
  blocks.Wb = (dls_blocks){d, nc, p, i, x};
  ck_assert_int_eq(run(&blocks, &s, r2, NULL, &info2), DLS_OK);
  ck_assert_mem_eq(r, r2, (size_t)m * sizeof *r);

  /* Newton's method: the same answer */
  dls_solver_settings newton;
  dls_solver_settings_init(&newton);
  newton.method = DLS_NEWTON;
  newton.tol = 1e-12;
  ck_assert_int_eq(dls_solve(&a.p, &newton, r2, NULL, NULL, NULL), DLS_OK);
  for (int k = 0; k < m; k++)
    ck_assert(fabs(r[k] - r2[k]) <= close);

  /* candidates in reverse order: the same answer */
  static model b;
  set_model(&b, d, nc);
  for (int k = 0; k < m; k++) {
    const int k2 = d * (nc - 1 - k / d) + k % d;
    b.q[k2] = a.q[k];
    b.mu[k2 / d] = a.mu[k / d];
    for (int l = 0; l < m; l++)
      b.W[k2 + m * (d * (nc - 1 - l / d) + l % d)] = a.W[k + m * l];
  }
  ck_assert_int_eq(run(&b.p, &s, r2, NULL, &info2), DLS_OK);
  for (int k = 0; k < m; k++)
    ck_assert(fabs(r[k] - r2[d * (nc - 1 - k / d) + k % d]) <= close);
}
END_TEST

START_TEST(units) {
  static model a, b;
  from_problem(_i, &a);
  const int m = a.p.d * a.p.nc;
  const dls_admm_settings s = with_tol(1e-10);
  double r[most], r2[most];
  dls_info info, info2;
  ck_assert_int_eq(run(&a.p, &s, r, NULL, &info), DLS_OK);
  for (int length = -1; length <= 1; length++)
    for (int force = -1; force <= 1; force++)
      for (int two = 0; two < 2; two++) {
        const double al = two ? ldexp(1, 30 * length) : pow(10, 9 * length);
        const double be = two ? ldexp(1, 30 * force) : pow(10, 9 * force);
        b = a;
        b.p.W.a = b.W;
        b.p.q = b.q;
        b.p.mu = b.mu;
        for (int k = 0; k < m; k++)
          b.q[k] *= al;
        for (int k = 0; k < m * m; k++)
          b.W[k] *= al / be;
        ck_assert_int_eq(run(&b.p, &s, r2, NULL, &info2), DLS_OK);
        ck_assert_int_eq(info2.iterations, info.iterations);
        ck_assert_int_eq(info2.factorisations, info.factorisations);
        for (int k = 0; two && k < m; k++)
          ck_assert(r2[k] == be * r[k]);
      }
}
END_TEST

/* each candidate's tangents turned by an angle of its own */
/* each candidate's tangents turned by an angle of its own */
START_TEST(turned_tangents) {
  static model a, b;
  from_problem(2 * _i + 1, &a);
  const int nc = a.p.nc, m = 3 * nc;
  ck_assert_int_eq(a.p.d, 3);
  double co[most], si[most], r[most], r2[most];
  for (int c = 0; c < nc; c++) {
    const double angle = 3 * uniform();
    co[c] = cos(angle);
    si[c] = sin(angle);
  }
  b = a;
  b.p.W.a = b.W;
  b.p.q = b.q;
  b.p.mu = b.mu;
  for (int c = 0; c < nc; c++) { /* q, the rows and the columns of W */
    const int t = 3 * c + 1;
    b.q[t] = co[c] * a.q[t] + si[c] * a.q[t + 1];
    b.q[t + 1] = co[c] * a.q[t + 1] - si[c] * a.q[t];
    for (int k = 0; k < m; k++) {
      const double x = b.W[t + m * k], y = b.W[t + 1 + m * k];
      b.W[t + m * k] = co[c] * x + si[c] * y;
      b.W[t + 1 + m * k] = co[c] * y - si[c] * x;
    }
    for (int k = 0; k < m; k++) {
      const double x = b.W[k + m * t], y = b.W[k + m * (t + 1)];
      b.W[k + m * t] = co[c] * x + si[c] * y;
      b.W[k + m * (t + 1)] = co[c] * y - si[c] * x;
    }
  }
  const dls_admm_settings s = with_tol(1e-10);
  dls_info info, info2;
  ck_assert_int_eq(run(&a.p, &s, r, NULL, &info), DLS_OK);
  ck_assert_int_eq(run(&b.p, &s, r2, NULL, &info2), DLS_OK);
  ck_assert_int_eq(info.iterations, info2.iterations);
  for (int c = 0; c < nc; c++) { /* the same iterations, but for rounding */
    const int n = 3 * c, t = n + 1;
    ck_assert(fabs(r2[n] - r[n]) <= 1e-11);
    ck_assert(fabs(r2[t] - (co[c] * r[t] + si[c] * r[t + 1])) <= 1e-11);
    ck_assert(fabs(r2[t + 1] - (co[c] * r[t + 1] - si[c] * r[t])) <= 1e-11);
  }
}
END_TEST

START_TEST(tolerance_zero) { /* the floor ends it */
  static model a;
  from_problem(_i, &a);
  const dls_admm_settings s = with_tol(0);
  double r[most];
  dls_info info;
  ck_assert_int_eq(run(&a.p, &s, r, NULL, &info), DLS_OK);
  ck_assert(info.certificate.residual <= 4 * info.certificate.floor);
}
END_TEST

START_TEST(
    smaller_problem_and_new_q) { /* a workspace serves what fits, time step after time step */
  static model a, b;
  from_problem(39, &a);
  from_problem(11, &b);
  ck_assert(a.p.d == b.p.d && a.p.nc > b.p.nc);
  const dls_admm_settings s = with_tol(1e-10);
  dls_admm *work;
  double r[most], r2[most];
  dls_info info;
  ck_assert_int_eq(dls_admm_create(&work, a.p.d, a.p.nc, &s, NULL), DLS_OK);
  malloc_fails_at(0);
  const dls_status first = dls_admm_solve(work, &a.p, r, NULL, &info, NULL);
  const dls_status second = dls_admm_solve(work, &b.p, r, NULL, NULL, NULL);
  const long calls = malloc_calls();
  ck_assert(first == DLS_OK && second == DLS_OK && calls == 0);
  ck_assert_int_eq(run(&b.p, &s, r2, NULL, &info), DLS_OK);
  ck_assert_mem_eq(r, r2, (size_t)(b.p.d * b.p.nc) * sizeof *r);
  dls_admm_destroy(work);
}
END_TEST

/* ---- large: both storages -------------------------------------------- */

/* A row of 2D candidates, each coupled to its neighbours; singular by pairs, or not. */
enum { LARGE = 150, LARGE_M = 2 * LARGE };
static double large_W[LARGE_M * LARGE_M], large_x[3 * LARGE * 4], large_q[LARGE_M], large_mu[LARGE];
static int large_p[LARGE + 1], large_i[3 * LARGE];

static void large_problem(int singular, dls_contact *dense, dls_contact *blocks) {
  seed = 2463534242;
  int k = 0;
  memset(large_W, 0, sizeof large_W);
  for (int b = 0; b < LARGE; b++) {
    large_p[b] = k;
    for (int a = b - 1; a <= b + 1; a++) {
      if (a < 0 || a >= LARGE) continue;
      const double near = singular ? (a / 2 == b / 2) : 0.4; /* singular: by pairs, of rank 1 */
      const double x[4] = {a == b ? 1 : near, a == b || singular ? 0 : .1 * (a - b),
                           a == b || singular ? 0 : .1 * (b - a), a == b ? 1 : near};
      memcpy(large_x + 4 * k, x, sizeof x);
      large_i[k++] = a;
      for (int e = 0; e < 4; e++)
        large_W[2 * a + e % 2 + LARGE_M * (2 * b + e / 2)] = x[e];
    }
    large_q[2 * b] = singular ? -1 : -1 + 0.2 * uniform();
    large_q[2 * b + 1] = singular ? 0.1 : 0.2 * uniform();
    large_mu[b] = 1;
  }
  large_p[LARGE] = k;
  const dls_dense W = {LARGE_M, LARGE_M, LARGE_M, large_W};
  *dense = (dls_contact){.d = 2, .nc = LARGE, .W = W, .q = large_q, .mu = large_mu};
  *blocks = *dense;
  memset(&blocks->W, 0, sizeof blocks->W);
  blocks->Wb = (dls_blocks){2, LARGE, large_p, large_i, large_x};
}

static dls_admm *large_workspace(double tol, int blocks) {
  dls_admm_settings s = with_tol(tol);
  dls_admm *work;
  s.blocks = blocks;
  ck_assert_int_eq(dls_admm_create(&work, 2, LARGE, &s, NULL), DLS_OK);
  return work;
}

START_TEST(sparse_is_dense) {
  dls_contact dense, blocks;
  large_problem(_i, &dense, &blocks);
  double r[LARGE_M], r2[LARGE_M], r3[LARGE_M];
  dls_info info, info2;
  dls_error error;
  dls_admm *work = large_workspace(1e-12, 0);
  ck_assert_int_eq(dls_admm_solve(work, &dense, r, NULL, &info, &error), DLS_OK);
  const dls_status status = dls_admm_solve(work, &blocks, r2, NULL, &info2, &error);
  if (WITH_MUMPS) {
    ck_assert_int_eq(status, DLS_OK);
    for (int k = 0; !_i && k < LARGE_M; k++) /* |W^-1| < 10; |q| < 13 */
      ck_assert(fabs(r[k] - r2[k]) <= 1e-9);
    ck_assert_int_eq(dls_admm_solve(work, &blocks, r3, NULL, NULL, &error), DLS_OK);
    ck_assert_mem_eq(r2, r3, sizeof r2);
  } else {
    ck_assert_int_eq(status, DLS_E_UNSUPPORTED);
    ck_assert_str_eq(error.function, "dls_admm_solve");
  }
  dls_admm_destroy(work);
}
END_TEST

START_TEST(announced_storage_allocates_nothing) {
  if (_i && !WITH_MUMPS) return;
  dls_contact dense, blocks;
  large_problem(0, &dense, &blocks);
  const dls_contact *p = _i ? &blocks : &dense;
  double r[LARGE_M];
  dls_admm *work = large_workspace(1e-8, _i ? large_p[LARGE] : 0);
  malloc_fails_at(0);
  const dls_status status = dls_admm_solve(work, p, r, NULL, NULL, NULL);
  const long calls = malloc_calls();
  ck_assert(status == DLS_OK && calls == 0);
  dls_admm_destroy(work);
}
END_TEST

START_TEST(no_memory_for_another) { /* outputs untouched, and the workspace as good as new */
  if (!_i && !WITH_MUMPS) return;
  dls_contact dense, blocks;
  large_problem(0, &dense, &blocks);
  const dls_contact *p = _i ? &dense : &blocks;
  dls_admm *work = large_workspace(1e-8, _i ? 1 : 0);
  double r[LARGE_M];
  dls_error error;
  r[0] = 9;
  long k = 1;
  for (;; k++) {
    malloc_fails_at(k);
    const dls_status status = dls_admm_solve(work, p, r, NULL, NULL, &error);
    malloc_fails_at(0);
    if (status == DLS_OK) break;
    ck_assert_int_eq(status, DLS_E_MEMORY);
    ck_assert_str_eq(error.function, "dls_admm_solve");
    ck_assert(r[0] == 9);
  }
  ck_assert(k > 1);
  malloc_fails_at(0); /* the room is kept */
  const dls_status again = dls_admm_solve(work, p, r, NULL, NULL, NULL);
  const long calls = malloc_calls();
  ck_assert(again == DLS_OK && calls == 0);
  dls_admm_destroy(work);
}
END_TEST

/* ---- an elastic half-plane: dense W of any size
 * ----------------------------------------------------- */

#ifndef CELLS
#define CELLS 100
#endif

/* CELLS cells of width h on the surface of a half-plane, by Flamant's solution, in units of 2 (1 -
 * nu^2) /
 * (pi E): along a line force the mean of -log |x| over the cell, plus `depth` for where the body is
 * held; across it pi / 2 (1 - 2 nu) / (2 - 2 nu), nu = 1 / 8. u_t is pushed by `push`; q_n = -1 +
 * crown x^2. */
static double plane_W[4 * CELLS * CELLS], plane_q[2 * CELLS], plane_mu[CELLS];

static double log_integral(double x) {
  return x * log(fabs(x)) - x;
}

static dls_contact half_plane_problem(double depth, double push, double crown, double mu) {
  const double h = 2. / CELLS, across = 0.3 / 0.7 * acos(0);
  const int m = 2 * CELLS;
  for (int b = 0; b < CELLS; b++) {
    for (int a = 0; a < CELLS; a++) {
      const double x = (a - b) * h;
      const double along = depth - (log_integral(x + h / 2) - log_integral(x - h / 2)) / h;
      const double side = a > b ? across : a < b ? -across : 0;
      double *block = plane_W + 2 * a + (size_t)m * (size_t)(2 * b);
      block[0] = block[m + 1] = along;
      block[1] = -side;
      block[m] = side;
    }
    const double x = (b - 0.5 * (CELLS - 1)) * h;
    plane_q[2 * b] = -1 + crown * x * x;
    plane_q[2 * b + 1] = push;
    plane_mu[b] = mu;
  }
  return (dls_contact){.d = 2, .nc = CELLS, .W = {m, m, m, plane_W}, .q = plane_q, .mu = plane_mu};
}

/* Pressed and pushed, all slide; a punch that touches in the middle; deep, so that W is
 * ill-conditioned; the same with most of them sticking. The answer of Newton's method, in fewer
 * iterations than sweeps. */
START_TEST(half_plane) {
  static const double depth[] = {2, 8, 100, 100}, crown[] = {0, 1.5, 0, 0}, mu[] = {.3, .3, .3, 1};
  static double r[3][2 * CELLS];
  const dls_method method[] = {DLS_ADMM, DLS_NEWTON, DLS_NLGS};
  const dls_contact p = half_plane_problem(depth[_i], 0.5, crown[_i], mu[_i]);
  dls_info info[3];
  for (int way = 0; way < 3; way++) {
    dls_solver_settings s;
    dls_solver_settings_init(&s);
    s.method = method[way];
    s.tol = 1e-10;
    s.max_iterations = way == 2 ? 3000 : 0;
    if (way == 2) s.acceleration = DLS_ACCELERATION_ANDERSON;
    const clock_t start = clock();
    const dls_status status = dls_solve(&p, &s, r[way], NULL, &info[way], NULL);
    const double seconds = (double)(clock() - start) / CLOCKS_PER_SEC;
    if (CELLS > 100)
      printf("half-plane %d, m = %d: %s %s, %d iterations, %d factorisations, %.4f s\n", _i,
             2 * CELLS, dls_method_name(method[way]), dls_status_name(status), info[way].iterations,
             info[way].factorisations, seconds);
    if (way < 2) ck_assert_int_eq(status, DLS_OK);
  }
  double difference = 0, largest = 0;
  for (int e = 0; e < 2 * CELLS; e++) {
    difference = fmax(difference, fabs(r[0][e] - r[1][e]));
    largest = fmax(largest, fabs(r[0][e]));
  }
  /* |W^-1| grows with CELLS */
  ck_assert_msg(difference <= 1e-8 * CELLS * largest, "%g of %g", difference, largest);
  ck_assert_int_lt(info[0].iterations, info[2].iterations);
}
END_TEST

/* ---- bad input ------------------------------------------------------------------------------- */

static void expect_create(dls_status status, const char *argument, int d, int nc,
                          const dls_admm_settings *s) {
  dls_error error = {0};
  dls_admm *work = (dls_admm *)&error; /* must become NULL */
  ck_assert_int_eq(dls_admm_create(&work, d, nc, s, &error), status);
  ck_assert_ptr_null(work);
  ck_assert_int_eq(error.status, status);
  ck_assert_str_eq(error.function, "dls_admm_create");
  ck_assert_str_eq(error.argument, argument);
  ck_assert_int_eq(dls_admm_create(&work, d, nc, s, NULL), status);
}

START_TEST(bad_create) {
  dls_error error;
  const dls_admm_settings good = with_tol(1e-8);
  ck_assert_int_eq(dls_admm_create(NULL, 2, 1, &good, &error), DLS_E_ARGUMENT);
  ck_assert_str_eq(error.argument, "out");
  expect_create(DLS_E_ARGUMENT, "d", 1, 1, &good);
  expect_create(DLS_E_ARGUMENT, "d", 4, 1, &good);
  expect_create(DLS_E_SIZE, "nc", 2, 0, &good);
  expect_create(DLS_E_SIZE, "nc", 3, INT_MAX, &good);
  expect_create(DLS_E_ARGUMENT, "settings", 2, 1, NULL);
  dls_admm_settings s = {0};
  expect_create(DLS_E_SETTINGS, "settings", 2, 1, &s);
  const double bad_tol[] = {-1, NAN, INFINITY}, bad_rho[] = {0, -1, NAN, INFINITY};
  for (int k = 0; k < 3; k++) {
    s = good;
    s.tol = bad_tol[k];
    expect_create(DLS_E_ARGUMENT, "tol", 2, 1, &s);
  }
  for (int k = 0; k < 4; k++) {
    s = good;
    s.rho = bad_rho[k];
    expect_create(DLS_E_ARGUMENT, "rho", 2, 1, &s);
  }
  s = good;
  s.blocks = -1;
  expect_create(DLS_E_ARGUMENT, "blocks", 2, 1, &s);
  if (WITH_MUMPS) {
    s.blocks = INT_MAX;
    expect_create(DLS_E_SIZE, "blocks", 2, 200, &s);
  }
  s = good;
  s.max_iterations = 0;
  expect_create(DLS_E_ARGUMENT, "max_iterations", 2, 1, &s);
  s = good;
  s.warm_start = 2;
  expect_create(DLS_E_ARGUMENT, "warm_start", 2, 1, &s);
  dls_admm_settings_init(NULL);
  dls_admm_destroy(NULL);
}
END_TEST

static void expect_solve(dls_admm *work, dls_status status, const char *argument, long long index,
                         const dls_contact *p, double *r) {
  dls_error error = {0};
  dls_info info, same_info;
  double u[most], same_u[most], same_r[most];
  memset(&info, 7, sizeof info);
  memset(u, 7, sizeof u);
  same_info = info;
  memcpy(same_u, u, sizeof u);
  if (r) memcpy(same_r, r, sizeof same_r);
  ck_assert_int_eq(dls_admm_solve(work, p, r, u, &info, &error), status);
  ck_assert_str_eq(error.function, "dls_admm_solve");
  ck_assert_str_eq(error.argument, argument);
  ck_assert(error.index == index);
  ck_assert_mem_eq(&info, &same_info, sizeof info);
  ck_assert_mem_eq(u, same_u, sizeof u);
  if (r) ck_assert_mem_eq(r, same_r, sizeof same_r);
}

START_TEST(bad_solve) {
  static model a, b;
  from_problem(6, &a); /* 2D, 7 candidates */
  dls_admm_settings s = with_tol(1e-8);
  s.warm_start = 1;
  dls_admm *work, *small, *other;
  ck_assert_int_eq(dls_admm_create(&work, 2, 7, &s, NULL), DLS_OK);
  ck_assert_int_eq(dls_admm_create(&small, 2, 6, &s, NULL), DLS_OK);
  ck_assert_int_eq(dls_admm_create(&other, 3, 7, &s, NULL), DLS_OK);
  double r[most] = {0};
  expect_solve(NULL, DLS_E_ARGUMENT, "workspace", -1, &a.p, r);
  expect_solve(work, DLS_E_ARGUMENT, "problem", -1, NULL, r);
  expect_solve(small, DLS_E_SIZE, "problem", -1, &a.p, r);
  expect_solve(other, DLS_E_SIZE, "problem", -1, &a.p, r);
  expect_solve(work, DLS_E_ARGUMENT, "r", -1, &a.p, NULL);
  r[3] = INFINITY;
  expect_solve(work, DLS_E_NOT_FINITE, "r", 3, &a.p, r);
  r[3] = 0;
#define WITH(change, status, argument, index)                                                      \
  do {                                                                                             \
    b = a;                                                                                         \
    b.p.W.a = b.W;                                                                                 \
    b.p.q = b.q;                                                                                   \
    b.p.mu = b.mu;                                                                                 \
    change;                                                                                        \
    expect_solve(work, status, argument, index, &b.p, r);                                          \
  } while (0)
  WITH(b.W[15] = NAN, DLS_E_NOT_FINITE, "W", 15);
  WITH(b.q[2] = -INFINITY, DLS_E_NOT_FINITE, "q", 2);
  WITH(b.mu[4] = NAN, DLS_E_NOT_FINITE, "mu", 4);
  WITH(b.mu[4] = -1, DLS_E_ARGUMENT, "mu", 4);
  WITH(b.p.q = NULL, DLS_E_ARGUMENT, "q", -1);
  WITH(b.p.mu = NULL, DLS_E_ARGUMENT, "mu", -1);
  WITH(b.p.W.a = NULL, DLS_E_ARGUMENT, "W", -1);
  WITH(b.p.W.ld = 3, DLS_E_SIZE, "W", -1);
  WITH(b.p.nc = 0, DLS_E_SIZE, "nc", -1);
  WITH(b.p.d = 5, DLS_E_ARGUMENT, "d", -1);
  dls_admm_destroy(work);
  dls_admm_destroy(small);
  dls_admm_destroy(other);
}
END_TEST

START_TEST(no_memory) { /* dense; by blocks */
  dls_admm_settings s = with_tol(1e-8);
  s.blocks = 500 * _i;
  dls_error error;
  dls_admm *work;
  long k = 1;
  for (;; k++) {
    malloc_fails_at(k);
    const dls_status status = dls_admm_create(&work, 3, _i ? 100 : 10, &s, &error);
    malloc_fails_at(0);
    if (status == DLS_OK) break;
    ck_assert_int_eq(status, DLS_E_MEMORY);
    ck_assert_ptr_null(work);
  }
  ck_assert(k > 1);
  dls_admm_destroy(work);
}
END_TEST

int main(void) {
  Suite *suite = suite_create("admm");
  TCase *t = tcase_create("by hand");
  tcase_add_loop_test(t, by_hand, 0, sizeof hand / sizeof hand[0]);
  tcase_add_test(t, first_iterations);
  tcase_add_test(t, ambiguous);
  tcase_add_loop_test(t, jammed, 0, 5);
  tcase_add_test(t, hyperstatic);
  tcase_add_loop_test(t, catalogue, 0, 8);
  tcase_add_loop_test(t, never_worse, 0, 30);
  tcase_add_test(t, start_that_overflows);
  tcase_add_loop_test(t, cancelled, 0, 2);
  suite_add_tcase(suite, t);
  t = tcase_create("random");
  tcase_set_timeout(t, 60);
  tcase_add_loop_test(t, random_problem, 0, 40);
  tcase_add_loop_test(t, units, 0, 12);
  tcase_add_loop_test(t, turned_tangents, 0, 10);
  tcase_add_loop_test(t, tolerance_zero, 0, 20);
  tcase_add_test(t, smaller_problem_and_new_q);
  suite_add_tcase(suite, t);
  t = tcase_create("large");
  tcase_set_timeout(t, 60);
  tcase_add_loop_test(t, sparse_is_dense, 0, 2);
  tcase_add_loop_test(t, announced_storage_allocates_nothing, 0, 2);
  tcase_add_loop_test(t, no_memory_for_another, 0, 2);
  tcase_add_loop_test(t, half_plane, 0, 4);
  suite_add_tcase(suite, t);
  t = tcase_create("bad input");
  tcase_add_test(t, bad_create);
  tcase_add_test(t, bad_solve);
  tcase_add_loop_test(t, no_memory, 0, 2);
  suite_add_tcase(suite, t);
  SRunner *runner = srunner_create(suite);
  srunner_run_all(runner, CK_NORMAL);
  const int failed = srunner_ntests_failed(runner);
  srunner_free(runner);
  return failed ? EXIT_FAILURE : EXIT_SUCCESS;
}
