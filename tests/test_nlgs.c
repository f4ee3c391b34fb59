/* test_nlgs.c: projected Gauss-Seidel, on problems solved by hand, on random ones, on bad input. */
#include <check.h>
#include <float.h>
#include <limits.h>
#include <math.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "delassus/files.h"
#include "delassus/nlgs.h"
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

/* W by blocks, in storage of its own */
typedef struct blocks {
  int p[most + 1], i[most * most];
  double x[most * most];
} blocks;

static dls_contact by_blocks(const model *a, blocks *B) {
  const int d = a->p.d, nc = a->p.nc, m = d * nc;
  for (int b = 0, k = 0; b < nc; b++) {
    B->p[b] = k;
    for (int c = 0; c < nc; c++, k++) {
      B->i[k] = c;
      for (int e = 0; e < d * d; e++)
        B->x[k * d * d + e] = a->W[d * c + e % d + m * (d * b + e / d)];
    }
    B->p[b + 1] = k;
  }
  dls_contact p = a->p;
  memset(&p.W, 0, sizeof p.W);
  p.Wb = (dls_blocks){d, nc, B->p, B->i, B->x};
  return p;
}

static dls_status run(const dls_contact *p, const dls_nlgs_settings *settings, double *r, double *u,
                      dls_info *info) {
  dls_nlgs *work;
  dls_error error;
  ck_assert_int_eq(dls_nlgs_create(&work, p->d, p->nc, settings, &error), DLS_OK);
  const dls_status status = dls_nlgs_solve(work, p, r, u, info, &error);
  ck_assert(status >= 0);
  ck_assert_int_eq(info->status, status);
  ck_assert_int_eq(info->method, DLS_NLGS);
  dls_nlgs_destroy(work);

  /* what it says of r is what the public certificate says, and OK means that it holds */
  dls_certificate c;
  double v[most];
  ck_assert_int_eq(dls_contact_certify(p, r, v, &c, &error), DLS_OK);
  ck_assert(c.residual == info->certificate.residual && c.floor == info->certificate.floor);
  ck_assert_int_eq(status == DLS_OK, dls_certificate_holds(&c, settings->tol));
  if (u) ck_assert_mem_eq(u, v, (size_t)(p->d * p->nc) * sizeof *u);
  return status;
}

static double norm_of(const double *x, int n) {
  double s = 0;
  for (int i = 0; i < n; i++)
    s += x[i] * x[i];
  return sqrt(s);
}

static dls_nlgs_settings with_tol(double tol) {
  dls_nlgs_settings s;
  dls_nlgs_settings_init(&s);
  s.tol = tol;
  return s;
}

/* ---- by hand --------------------------------------------------------------------------------- */

typedef struct hand_case {
  const char *name;
  int d, nc;
  double W[36]; /* by rows */
  double q[6], mu, r[6];
  int sweeps; /* -1: not said */
} hand_case;

static const hand_case hand[] = {
    {"separate", 2, 1, {2, 1, 1, 2}, {1, -3}, 1, {0, 0}, 0},
    {"q = 0", 2, 1, {2, 1, 1, 2}, {0, 0}, 1, {0, 0}, 0},
    {"stick", 2, 1, {2, 0, 0, 1}, {-2, .5}, 1, {1, -.5}, 1},
    {"slip right", 2, 1, {2, 0, 0, 1}, {-2, 5}, 1, {1, -1}, 1},
    {"slip left", 2, 1, {2, 0, 0, 1}, {-2, -5}, 1, {1, 1}, 1},
    {"coupled stick", 2, 1, {2, 1, 1, 2}, {-3.5, -1}, .5, {2, -.5}, 1},
    {"coupled slip left", 2, 1, {2, 1, 1, 2}, {-5, -6}, .5, {2, 1}, 1},
    {"coupled slip right", 2, 1, {2, 1, 1, 2}, {-3, 1}, .5, {2, -1}, 1},
    {"no friction", 2, 1, {2, 1, 1, 2}, {-4, 3}, 0, {2, 0}, 1},
    {"C7", 2, 1, {1, -1, -1, 2}, {-1, -3}, 2, {5, 4}, 1},
    /* normals coupled: 2 r_1 + r_2 = 3, r_1 + 2 r_2 = 3; one sticks, one slips left */
    {"two",
     2,
     2,
     {2, 0, 1, 0, 0, 1, 0, 0, 1, 0, 2, 0, 0, 0, 0, 1},
     {-3, .25, -3, -3},
     .5,
     {1, -.25, 1, .5},
     -1},
    /* the second is lifted off by the first: u_n2 = 1 - 0.5 */
    {"one lifts off",
     2,
     2,
     {2, 0, 1, 0, 0, 1, 0, 0, 1, 0, 2, 0, 0, 0, 0, 1},
     {-2, 0, -.5, 9},
     1,
     {1, 0, 0, 0},
     -1},
    {"C12b",
     2,
     2,
     {3, 1, 0, 1, 1, 2, 2, 0, 0, 2, 3, 0, 1, 0, 0, 1},
     {-2, 0, -1, 0},
     2,
     {6, -10, 7, -6},
     -1},
    {"C14",
     2,
     2,
     {3, 0, -2, 0, 0, 2, 0, -1, -2, 0, 3, -2, 0, -1, -2, 3},
     {0, 0, -1, -2},
     1,
     {26, 16, 39, 32},
     -1},
    {"C7 in 3D", 3, 1, {1, -1, 0, -1, 2, 0, 0, 0, 2}, {-1, -3, 0}, 2, {5, 4, 0}, 1},
    {"C16", 3, 1, {2, -1, 2, -1, 2, 0, 2, 0, 3}, {-1, 4, 3}, 1, {6, 1, -5}, 1},
    {"slip in 3D", 3, 1, {2, 0, 0, 0, 1, 0, 0, 0, 1}, {-2, 3, 4}, 1, {1, -.6, -.8}, 1},
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
  const dls_nlgs_settings s = with_tol(1e-14);
  double r[6], u[6];
  dls_info info;
  ck_assert_msg(run(&a.p, &s, r, u, &info) == DLS_OK, "%s: %g", k->name, info.certificate.residual);
  /* residual <= 1e-14; the worst is C14, where |W^-1 q| is 26 |q| */
  for (int i = 0; i < k->d * k->nc; i++)
    ck_assert_msg(fabs(r[i] - k->r[i]) <= 1e-11, "%s: r[%d] = %.17g", k->name, i, r[i]);
  if (k->sweeps >= 0) ck_assert_int_eq(info.iterations, k->sweeps);
  ck_assert_int_eq(info.ambiguous, strcmp(k->name, "C16") == 0);
}
END_TEST

START_TEST(ambiguous) { /* C1 */
  static model a;
  const hand_case k = {"C1", 2, 1, {1, 1, 1, 2}, {1, 4}, 2, {0}, 0};
  set_hand(&a, &k);
  dls_nlgs_settings s = with_tol(1e-12);
  double r[2] = {2, -3}, u[2];
  dls_info info;
  ck_assert_int_eq(run(&a.p, &s, r, u, &info), DLS_OK);
  ck_assert(r[0] == 0 && r[1] == 0);
  ck_assert_int_eq(info.ambiguous, 1);
  s.warm_start = 1; /* from the sticking solution: it is one, and stays */
  r[0] = 2;
  r[1] = -3;
  ck_assert_int_eq(run(&a.p, &s, r, u, &info), DLS_OK);
  ck_assert(r[0] == 2 && r[1] == -3 && info.iterations == 0 && info.ambiguous == 1);
}
END_TEST

START_TEST(jammed) { /* C3 at mu >= 1, and C4, have no solution */
  static const hand_case k[] = {
      {"C3", 2, 1, {1, 1, 1, 1}, {-2, 0}, 1, {0}, 0},
      {"C3", 2, 1, {1, 1, 1, 1}, {-2, 0}, 2, {0}, 0},
      {"C4", 2, 2, {1, 0, -1, 0, 0, 1, 0, 1, -1, 0, 1, 0, 0, 1, 0, 1}, {-1, 0, -1, 0}, .3, {0}, 0},
      {"C3, 3D", 3, 1, {1, 1, 0, 1, 1, 0, 0, 0, 1}, {-2, 0, 0}, 2, {0}, 0},
      {"W = 0", 2, 1, {0}, {-1, 0}, 1, {0}, 0},
  };
  static model a;
  set_hand(&a, &k[_i]);
  const dls_nlgs_settings s = with_tol(1e-8);
  double r[6], u[6];
  dls_info info;
  const dls_status status = run(&a.p, &s, r, u, &info);
  ck_assert_msg(status == DLS_STALLED || status == DLS_MAX_ITERATIONS, "%s", k[_i].name);
  ck_assert(info.certificate.residual > 0.1 && isfinite(info.certificate.residual));
  if (k[_i].nc == 1) ck_assert_int_eq(status, DLS_STALLED);
}
END_TEST

START_TEST(hyperstatic) { /* C5: two contacts that share everything */
  static model a;
  const hand_case k = {
      "C5", 2, 2, {1, 0, 1, 0, 0, 1, 0, 1, 1, 0, 1, 0, 0, 1, 0, 1}, {-1, .25, -1, .25}, .5, {0}, 0};
  set_hand(&a, &k);
  const dls_nlgs_settings s = with_tol(1e-13);
  double r[4], u[4];
  dls_info info;
  ck_assert_int_eq(run(&a.p, &s, r, u, &info), DLS_OK);
  ck_assert(fabs(r[0] + r[2] - 1) <= 1e-12 && fabs(r[1] + r[3] + .25) <= 1e-12);
}
END_TEST

/* C11: W SPD, one solution, and yet the sweeps repeat for ever */
typedef struct watch {
  double least;
  int calls, cancel_at;
} watch;

static int look(void *data, const dls_progress *progress) {
  watch *w = data;
  ck_assert_int_eq(progress->iteration, ++w->calls);
  ck_assert_str_eq(progress->method, "nlgs");
  if (progress->residual < w->least) w->least = progress->residual;
  return w->calls == w->cancel_at;
}

static void set_cycle(model *a) {
  static const hand_case k = {"C11",
                              2,
                              2,
                              {1, 1, 0, -1, 1, 2, 1, -2, 0, 1, 3, 0, -1, -2, 0, 3},
                              {-1, 1, -1, 0},
                              1,
                              {3, -3, 4. / 3, -1},
                              -1};
  set_hand(a, &k);
}

START_TEST(cycle) {
  static model a;
  set_cycle(&a);
  dls_nlgs_settings s = with_tol(1e-8);
  watch w = {INFINITY, 0, 0};
  s.max_iterations = 500;
  s.progress = look;
  s.progress_data = &w;
  double r[4], u[4];
  dls_info info;
  ck_assert_int_eq(run(&a.p, &s, r, u, &info), DLS_MAX_ITERATIONS);
  ck_assert_int_eq(info.iterations, 500);
  ck_assert_int_eq(w.calls, 500);
  ck_assert(info.certificate.residual > 0.01);
  ck_assert(info.certificate.residual <= w.least * (1 + 1e-12)); /* the best of them all */
}
END_TEST

START_TEST(cancelled) {
  static model a;
  set_cycle(&a);
  dls_nlgs_settings s = with_tol(1e-8);
  watch w = {INFINITY, 0, 7};
  s.progress = look;
  s.progress_data = &w;
  double r[4], u[4];
  dls_info info;
  ck_assert_int_eq(run(&a.p, &s, r, u, &info), DLS_CANCELLED);
  ck_assert_int_eq(info.iterations, 7);
  ck_assert(info.certificate.residual <= w.least * (1 + 1e-12));
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
  const dls_nlgs_settings s = with_tol(1e-12);
  double r[most], u[most], r2[most];
  dls_info info, info2;
  ck_assert_int_eq(run(&a.p, &s, r, u, &info), DLS_OK);
  ck_assert(info.certificate.residual <= 1e-12);

  /* again: the same bits */
  ck_assert_int_eq(run(&a.p, &s, r2, NULL, &info2), DLS_OK);
  ck_assert_mem_eq(r, r2, (size_t)m * sizeof *r);
  ck_assert_int_eq(info.iterations, info2.iterations);

  /* from the answer: no sweep */
  dls_nlgs_settings warm = s;
  warm.warm_start = 1;
  ck_assert_int_eq(run(&a.p, &warm, r2, NULL, &info2), DLS_OK);
  ck_assert_mem_eq(r, r2, (size_t)m * sizeof *r);
  ck_assert_int_eq(info2.iterations, 0);

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
  static blocks B;
  const dls_contact blockwise = by_blocks(&a, &B);
  ck_assert_int_eq(run(&blockwise, &s, r2, NULL, &info2), DLS_OK);
  ck_assert_mem_eq(r, r2, (size_t)m * sizeof *r);

  /* other relaxations: the same answer */
  for (int o = 0; o < 2; o++) {
    dls_nlgs_settings relaxed = s;
    relaxed.relaxation = o ? 1.2 : 0.7;
    ck_assert_int_eq(run(&a.p, &relaxed, r2, NULL, &info2), DLS_OK);
    for (int k = 0; k < m; k++)
      ck_assert(fabs(r[k] - r2[k]) <= close);
  }

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
  const dls_nlgs_settings s = with_tol(1e-10);
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
        for (int k = 0; two && k < m; k++)
          ck_assert(r2[k] == be * r[k]);
      }
}
END_TEST

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
  const dls_nlgs_settings s = with_tol(1e-10);
  dls_info info, info2;
  ck_assert_int_eq(run(&a.p, &s, r, NULL, &info), DLS_OK);
  ck_assert_int_eq(run(&b.p, &s, r2, NULL, &info2), DLS_OK);
  ck_assert_int_eq(info.iterations, info2.iterations);
  for (int c = 0; c < nc; c++) { /* the same sweeps, but for rounding */
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
  const dls_nlgs_settings s = with_tol(0);
  double r[most];
  dls_info info;
  ck_assert_int_eq(run(&a.p, &s, r, NULL, &info), DLS_OK);
  ck_assert(info.certificate.residual <= 4 * info.certificate.floor);
  ck_assert(info.iterations < 10000);
}
END_TEST

START_TEST(
    smaller_problem_and_new_q) { /* a workspace serves what fits, time step after time step */
  static model a, b;
  from_problem(39, &a);
  from_problem(11, &b);
  ck_assert(a.p.d == b.p.d && a.p.nc > b.p.nc);
  const dls_nlgs_settings s = with_tol(1e-10);
  dls_nlgs *work;
  double r[most], r2[most];
  dls_info info;
  ck_assert_int_eq(dls_nlgs_create(&work, a.p.d, a.p.nc, &s, NULL), DLS_OK);
  malloc_fails_at(0);
  const dls_status first = dls_nlgs_solve(work, &a.p, r, NULL, &info, NULL);
  const dls_status second = dls_nlgs_solve(work, &b.p, r, NULL, NULL, NULL);
  const long calls = malloc_calls();
  ck_assert(first == DLS_OK && second == DLS_OK && calls == 0);
  ck_assert_int_eq(run(&b.p, &s, r2, NULL, &info), DLS_OK);
  ck_assert_mem_eq(r, r2, (size_t)(b.p.d * b.p.nc) * sizeof *r);
  dls_nlgs_destroy(work);
}
END_TEST

/* ---- acceleration ---------------------------------------------------------------------------- */

static const dls_acceleration accelerations[] = {DLS_ACCELERATION_AITKEN,
                                                 DLS_ACCELERATION_ANDERSON};

static dls_nlgs_settings accelerated(double tol, dls_acceleration acceleration) {
  dls_nlgs_settings s = with_tol(tol);
  s.acceleration = acceleration;
  return s;
}

START_TEST(accelerated_random_problem) {
  static model a;
  static blocks B;
  from_problem(_i, &a);
  const int m = a.p.d * a.p.nc;
  const double close = 1000 * 1e-12 * norm_of(a.q, m);
  double plain[most], r[most], r2[most];
  dls_info info, info2;
  const dls_nlgs_settings none = with_tol(1e-12);
  ck_assert_int_eq(run(&a.p, &none, plain, NULL, &info), DLS_OK);
  for (int k = 0; k < 2; k++) {
    dls_nlgs_settings s = accelerated(1e-12, accelerations[k]);
    ck_assert_int_eq(run(&a.p, &s, r, NULL, &info), DLS_OK);
    for (int j = 0; j < m; j++)
      ck_assert(fabs(r[j] - plain[j]) <= close);

    /* again, and W by blocks: the same bits */
    ck_assert_int_eq(run(&a.p, &s, r2, NULL, &info2), DLS_OK);
    ck_assert_mem_eq(r, r2, (size_t)m * sizeof *r);
    const dls_contact p = by_blocks(&a, &B);
    ck_assert_int_eq(run(&p, &s, r2, NULL, &info2), DLS_OK);
    ck_assert_mem_eq(r, r2, (size_t)m * sizeof *r);
    ck_assert_int_eq(info.iterations, info2.iterations);

    /* from the answer: no sweep; from elsewhere, with other windows and relaxed: the same answer */
    s.warm_start = 1;
    ck_assert_int_eq(run(&a.p, &s, r2, NULL, &info2), DLS_OK);
    ck_assert_int_eq(info2.iterations, 0);
    for (int o = 0; o < 3; o++) {
      s.window = o ? 3 : 100;
      s.relaxation = o == 2 ? 0.8 : 1;
      for (int j = 0; j < m; j++)
        r2[j] = 5 * uniform();
      ck_assert_int_eq(run(&a.p, &s, r2, NULL, &info2), DLS_OK);
      for (int j = 0; j < m; j++)
        ck_assert(fabs(r2[j] - plain[j]) <= close);
    }
  }
}
END_TEST

/* pressed all over, and W = A A^T / m + I / 1000 */
static void slow_model(int i, model *a) {
  seed = 88172645463325252u + (uint64_t)i;
  const int d = 2 + i % 2, m = most;
  random_model(a, d, m / d, 0.5);
  for (int k = 0; k < m; k++) {
    a->W[k + m * k] += 1e-3 - 0.1;
    if (k % d == 0) a->q[k] -= 4;
  }
}

START_TEST(fewer_sweeps) {
  static model a;
  slow_model(_i, &a);
  double r[most];
  dls_info none, aitken, anderson;
  dls_nlgs_settings s = with_tol(1e-12);
  s.max_iterations = 100000;
  ck_assert_int_eq(run(&a.p, &s, r, NULL, &none), DLS_OK);
  s.acceleration = DLS_ACCELERATION_AITKEN;
  ck_assert_int_eq(run(&a.p, &s, r, NULL, &aitken), DLS_OK);
  s.acceleration = DLS_ACCELERATION_ANDERSON;
  ck_assert_int_eq(run(&a.p, &s, r, NULL, &anderson), DLS_OK);
  /* measured: 98-159, 52-80, 33-44 */
  ck_assert_int_le(5 * aitken.iterations, 4 * none.iterations);
  ck_assert_int_le(2 * anderson.iterations, none.iterations);
}
END_TEST

static const char *const files[] = {"Confeti-ex13-4contact-Fc3D-SBM",
                                    "FC2D_SliderCrankLagrangian00000",
                                    "FC3D_Example1",
                                    "GFC3D_Example0",
                                    "GFC3D_OneContact",
                                    "gfc2d_granularflowonwall_00069_00350"};

START_TEST(fclib_file) {
  char path[200];
  (void)snprintf(path, sizeof path, TEST_DATA "/fclib/%s.hdf5", files[_i]);
  dls_fclib *file;
  dls_error error;
  const dls_status status = dls_fclib_read(&file, path, &error);
  if (status == DLS_E_UNSUPPORTED) return; /* built without HDF5 */
  ck_assert_msg(status == DLS_OK, "%s", error.message);
  dls_contact p;
  dls_reduction *reduction = NULL;
  if (dls_fclib_is_global(file)) {
    dls_model global;
    const double *f, *g, *mu;
    ck_assert_int_eq(dls_fclib_model(file, &global, &f, &g, &mu, &error), DLS_OK);
    ck_assert_int_eq(dls_reduction_create(&reduction, &global, &error), DLS_OK);
    ck_assert_int_eq(dls_reduction_load(reduction, f, g, &error), DLS_OK);
    ck_assert_int_eq(dls_reduction_contact(reduction, mu, &p, &error), DLS_OK);
  } else
    ck_assert_int_eq(dls_fclib_contact(file, &p, &error), DLS_OK);
  for (int k = 0; k < 2; k++) {
    const dls_nlgs_settings s = accelerated(1e-12, accelerations[k]);
    double *r = calloc((size_t)p.d * (size_t)p.nc, sizeof *r);
    dls_nlgs *work;
    dls_info info;
    dls_certificate c;
    ck_assert_int_eq(dls_nlgs_create(&work, p.d, p.nc, &s, &error), DLS_OK);
    ck_assert_msg(dls_nlgs_solve(work, &p, r, NULL, &info, &error) == DLS_OK, "%s: %g", files[_i],
                  info.certificate.residual);
    ck_assert_int_eq(dls_contact_certify(&p, r, NULL, &c, &error), DLS_OK);
    ck_assert(dls_certificate_holds(&c, 1e-12));
    dls_nlgs_destroy(work);
    free(r);
  }
  dls_reduction_destroy(reduction);
  dls_fclib_destroy(file);
}
END_TEST

START_TEST(
    accelerated_cycle) { /* C11 again: solved or not, what is said is true, and it is the best */
  static model a;
  set_cycle(&a);
  for (int k = 0; k < 2; k++) {
    dls_nlgs_settings s = accelerated(1e-8, accelerations[k]);
    watch w = {INFINITY, 0, 0};
    s.max_iterations = 500;
    s.progress = look;
    s.progress_data = &w;
    double r[4], u[4];
    dls_info info;
    const dls_status status = run(&a.p, &s, r, u, &info);
    ck_assert(status == DLS_OK || status == DLS_MAX_ITERATIONS);
    ck_assert_int_eq(w.calls, info.iterations - (status == DLS_OK));
    ck_assert(info.certificate.residual <= w.least * (1 + 1e-12));
  }
}
END_TEST

START_TEST(accelerated_units) {
  static model a, b;
  from_problem(_i, &a);
  const int m = a.p.d * a.p.nc;
  const dls_nlgs_settings s = accelerated(1e-10, accelerations[_i / 2 % 2]);
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
        for (int k = 0; two && k < m; k++)
          ck_assert(r2[k] == be * r[k]);
      }
}
END_TEST

static int stop(void *data, const dls_progress *progress) {
  const int *at = data;
  return progress->iteration == *at;
}

/* What an earlier problem left in the workspace, cancelled half-way, plays no part. */
START_TEST(accelerated_workspace) {
  static model a, b;
  slow_model(0, &a);
  from_problem(10, &b);
  ck_assert(a.p.d == b.p.d && a.p.nc > b.p.nc);
  for (int k = 0; k < 2; k++) {
    int at = 0;
    dls_nlgs_settings s = accelerated(1e-12, accelerations[k]);
    s.progress = stop;
    s.progress_data = &at;
    double r[most], r2[most];
    dls_info info;
    ck_assert_int_eq(run(&b.p, &s, r, NULL, &info), DLS_OK);
    dls_nlgs *work;
    ck_assert_int_eq(dls_nlgs_create(&work, 2, a.p.nc, &s, NULL), DLS_OK);
    malloc_fails_at(0);
    at = 7;
    const dls_status first = dls_nlgs_solve(work, &a.p, r2, NULL, &info, NULL);
    at = 0;
    const dls_status second = dls_nlgs_solve(work, &b.p, r2, NULL, NULL, NULL);
    const long calls = malloc_calls();
    ck_assert(first == DLS_CANCELLED && second == DLS_OK && calls == 0);
    ck_assert_int_eq(info.iterations, 7);
    ck_assert_mem_eq(r, r2, (size_t)(b.p.d * b.p.nc) * sizeof *r);
    dls_nlgs_destroy(work);
  }
}
END_TEST

/* ---- bad input ------------------------------------------------------------------------------- */

static void expect_create(dls_status status, const char *argument, int d, int nc,
                          const dls_nlgs_settings *s) {
  dls_error error = {0};
  dls_nlgs *work = (dls_nlgs *)&error; /* must become NULL */
  ck_assert_int_eq(dls_nlgs_create(&work, d, nc, s, &error), status);
  ck_assert_ptr_null(work);
  ck_assert_int_eq(error.status, status);
  ck_assert_str_eq(error.function, "dls_nlgs_create");
  ck_assert_str_eq(error.argument, argument);
  ck_assert_int_eq(dls_nlgs_create(&work, d, nc, s, NULL), status);
}

START_TEST(bad_create) {
  dls_error error;
  const dls_nlgs_settings good = with_tol(1e-8);
  ck_assert_int_eq(dls_nlgs_create(NULL, 2, 1, &good, &error), DLS_E_ARGUMENT);
  ck_assert_str_eq(error.argument, "out");
  expect_create(DLS_E_ARGUMENT, "d", 1, 1, &good);
  expect_create(DLS_E_ARGUMENT, "d", 4, 1, &good);
  expect_create(DLS_E_SIZE, "nc", 2, 0, &good);
  expect_create(DLS_E_SIZE, "nc", 3, INT_MAX, &good);
  expect_create(DLS_E_ARGUMENT, "settings", 2, 1, NULL);
  dls_nlgs_settings s = {0};
  expect_create(DLS_E_SETTINGS, "settings", 2, 1, &s);
  const double bad_tol[] = {-1, NAN, INFINITY}, bad_relaxation[] = {0, 2, -1, NAN, INFINITY};
  for (int k = 0; k < 3; k++) {
    s = good;
    s.tol = bad_tol[k];
    expect_create(DLS_E_ARGUMENT, "tol", 2, 1, &s);
  }
  for (int k = 0; k < 5; k++) {
    s = good;
    s.relaxation = bad_relaxation[k];
    expect_create(DLS_E_ARGUMENT, "relaxation", 2, 1, &s);
  }
  s = good;
  s.max_iterations = 0;
  expect_create(DLS_E_ARGUMENT, "max_iterations", 2, 1, &s);
  s = good;
  s.warm_start = 2;
  expect_create(DLS_E_ARGUMENT, "warm_start", 2, 1, &s);
  const int bad_window[] = {0, -1, 101, INT_MIN}, bad_acceleration[] = {-1, 3};
  for (int k = 0; k < 4; k++) {
    s = good;
    s.window = bad_window[k];
    expect_create(DLS_E_ARGUMENT, "window", 2, 1, &s);
  }
  for (int k = 0; k < 2; k++) {
    s = good;
    s.acceleration = (dls_acceleration)bad_acceleration[k];
    expect_create(DLS_E_ARGUMENT, "acceleration", 2, 1, &s);
  }
  dls_nlgs_settings_init(NULL);
  dls_nlgs_destroy(NULL);
}
END_TEST

static void expect_solve(dls_nlgs *work, dls_status status, const char *argument, long long index,
                         const dls_contact *p, double *r) {
  dls_error error = {0};
  dls_info info, same_info;
  double u[most], same_u[most], same_r[most];
  memset(&info, 7, sizeof info);
  memset(u, 7, sizeof u);
  same_info = info;
  memcpy(same_u, u, sizeof u);
  if (r) memcpy(same_r, r, sizeof same_r);
  ck_assert_int_eq(dls_nlgs_solve(work, p, r, u, &info, &error), status);
  ck_assert_str_eq(error.function, "dls_nlgs_solve");
  ck_assert_str_eq(error.argument, argument);
  ck_assert(error.index == index);
  ck_assert_mem_eq(&info, &same_info, sizeof info);
  ck_assert_mem_eq(u, same_u, sizeof u);
  if (r) ck_assert_mem_eq(r, same_r, sizeof same_r);
}

START_TEST(bad_solve) {
  static model a, b;
  from_problem(6, &a); /* 2D, 7 candidates */
  dls_nlgs_settings s = with_tol(1e-8);
  s.warm_start = 1;
  dls_nlgs *work, *small, *other;
  ck_assert_int_eq(dls_nlgs_create(&work, 2, 7, &s, NULL), DLS_OK);
  ck_assert_int_eq(dls_nlgs_create(&small, 2, 6, &s, NULL), DLS_OK);
  ck_assert_int_eq(dls_nlgs_create(&other, 3, 7, &s, NULL), DLS_OK);
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
  dls_nlgs_destroy(work);
  dls_nlgs_destroy(small);
  dls_nlgs_destroy(other);
}
END_TEST

START_TEST(no_memory) {
  dls_nlgs_settings s = with_tol(1e-8);
  if (_i) s.acceleration = DLS_ACCELERATION_ANDERSON;
  dls_error error;
  dls_nlgs *work;
  long k = 1;
  for (;; k++) {
    malloc_fails_at(k);
    const dls_status status = dls_nlgs_create(&work, 3, 10, &s, &error);
    malloc_fails_at(0);
    if (status == DLS_OK) break;
    ck_assert_int_eq(status, DLS_E_MEMORY);
    ck_assert_ptr_null(work);
  }
  ck_assert(k > 1);
  dls_nlgs_destroy(work);
}
END_TEST

int main(void) {
  Suite *suite = suite_create("nlgs");
  TCase *t = tcase_create("by hand");
  tcase_add_loop_test(t, by_hand, 0, sizeof hand / sizeof hand[0]);
  tcase_add_test(t, ambiguous);
  tcase_add_loop_test(t, jammed, 0, 5);
  tcase_add_test(t, hyperstatic);
  tcase_add_test(t, cycle);
  tcase_add_test(t, cancelled);
  suite_add_tcase(suite, t);
  t = tcase_create("random");
  tcase_set_timeout(t, 60);
  tcase_add_loop_test(t, random_problem, 0, 40);
  tcase_add_loop_test(t, units, 0, 12);
  tcase_add_loop_test(t, turned_tangents, 0, 10);
  tcase_add_loop_test(t, tolerance_zero, 0, 20);
  tcase_add_test(t, smaller_problem_and_new_q);
  suite_add_tcase(suite, t);
  t = tcase_create("accelerated");
  tcase_set_timeout(t, 60);
  tcase_add_loop_test(t, accelerated_random_problem, 0, 40);
  tcase_add_loop_test(t, fewer_sweeps, 0, 10);
  tcase_add_loop_test(t, fclib_file, 0, sizeof files / sizeof files[0]);
  tcase_add_test(t, accelerated_cycle);
  tcase_add_loop_test(t, accelerated_units, 0, 40);
  tcase_add_test(t, accelerated_workspace);
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
