/* test_augmented.c: the augmented Lagrangian and the penalty method, on problems solved by hand, on
 * random ones, on ones without a solution, on bad input. */
#include <check.h>
#include <float.h>
#include <limits.h>
#include <math.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include "delassus/augmented.h"
#include "delassus/nlgs.h"
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
  a->p = (dls_contact){.d = d, .nc = nc, .W = {m, m, m, a->W}, .q = a->q, .mu = a->mu};
}

static void copy_model(model *a, const model *b) {
  *a = *b;
  a->p.W.a = a->W;
  a->p.q = a->q;
  a->p.mu = a->mu;
}

/* W = A A^T / m + I / 10 with A m x m, symmetric positive definite; q_n mostly < 0 */
static void random_model(model *a, int i) {
  static double A[most * most];
  const double mu[] = {0, 0.1, 0.3, 0.6};
  const int d = 2 + i % 2, nc = 1 + i % 20, m = d * nc;
  seed = 88172645463325252u + (uint64_t)i;
  set_model(a, d, nc);
  for (int k = 0; k < m * m; k++)
    A[k] = uniform();
  for (int k = 0; k < m; k++)
    for (int l = 0; l <= k; l++) {
      double s = k == l ? 0.1 : 0;
      for (int j = 0; j < m; j++)
        s += A[k + m * j] * A[l + m * j] / m;
      a->W[k + m * l] = a->W[l + m * k] = s;
    }
  for (int k = 0; k < m; k++)
    a->q[k] = uniform() - (k % d == 0 ? 0.5 : 0);
  for (int c = 0; c < nc; c++)
    a->mu[c] = mu[i % 4];
}

/* W = B B^T of half rank, and q = u - W r for r, u that obey the laws */
static void deficient_model(model *a, int model_number) {
  static double B[most * most];
  const int d = 2 + model_number % 2, nc = 4 + model_number % 12, m = d * nc, rank = m / 2;
  seed = 88172645463325252u + 77 * (uint64_t)model_number;
  set_model(a, d, nc);
  for (int k = 0; k < m * rank; k++)
    B[k] = uniform();
  double r[most] = {0}, u[most] = {0};
  for (int c = 0; c < nc; c++) {
    double *rc = r + d * c, *uc = u + d * c;
    const double angle = 3 * uniform(), mu = 0.3;
    const double t[2] = {d == 2 ? copysign(1, angle) : cos(angle), sin(angle)};
    a->mu[c] = mu;
    for (int i = 1; i < d; i++) {
      uc[i] = c % 3 == 0 ? uniform() : c % 3 == 1 ? -t[i - 1] : 0; /* free, slip, stick */
      rc[i] = c % 3 == 0 ? 0 : mu * t[i - 1] * (c % 3 == 1 ? 1 : 0.5);
    }
    rc[0] = c % 3 > 0;
    uc[0] = c % 3 == 0;
  }
  for (int i = 0; i < m; i++) {
    for (int j = 0; j < m; j++)
      for (int k = 0; k < rank; k++)
        a->W[i + m * j] += B[i + m * k] * B[j + m * k] / rank;
    a->q[i] = u[i];
    for (int j = 0; j < m; j++)
      a->q[i] -= a->W[i + m * j] * r[j];
  }
}

static dls_augmented_settings with_tol(double tol) {
  dls_augmented_settings s;
  dls_augmented_settings_init(&s);
  s.tol = tol;
  return s;
}

static dls_augmented *create(const dls_contact *p, const dls_augmented_settings *settings) {
  dls_augmented *work;
  ck_assert_int_eq(dls_augmented_create(&work, p->d, p->nc, settings, NULL), DLS_OK);
  return work;
}

static dls_status run_in(dls_augmented *work, const dls_contact *p,
                         const dls_augmented_settings *settings, double *r, double *u,
                         dls_info *info) {
  dls_error error;
  const dls_status status = dls_augmented_solve(work, p, r, u, info, &error);
  ck_assert_int_ge(status, 0);
  ck_assert_int_eq(info->status, status);
  ck_assert_int_eq(info->method, DLS_AUGMENTED_LAGRANGIAN);
  ck_assert_int_le(info->iterations, settings->max_iterations);

  /* what it says of r is what the public certificate says, and OK means that it holds */
  dls_certificate c;
  double v[most];
  ck_assert_int_eq(dls_contact_certify(p, r, v, &c, &error), DLS_OK);
  ck_assert(c.residual == info->certificate.residual && c.floor == info->certificate.floor);
  ck_assert_int_eq(status == DLS_OK, dls_certificate_holds(&c, settings->tol));
  if (u) ck_assert_mem_eq(u, v, (size_t)(p->d * p->nc) * sizeof *u);
  if (status == DLS_OK) ck_assert_ptr_null(dls_augmented_direction(work));
  return status;
}

static dls_status run(const dls_contact *p, const dls_augmented_settings *settings, double *r,
                      double *u, dls_info *info) {
  dls_augmented *work = create(p, settings);
  const dls_status status = run_in(work, p, settings, r, u, info);
  dls_augmented_destroy(work);
  return status;
}

typedef struct hand_case {
  const char *name;
  int d, nc;
  double W[16]; /* by rows */
  double q[4], mu, r[4];
} hand_case;

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

/* ---- springs: the augmentations themselves --------------------------------------------------- */

static const hand_case stick = {"stick", 2, 1, {2, 1, 1, 2}, {-3.5, -1}, .5, {2, -.5}};
static const hand_case slip = {"slip right", 2, 1, {2, 0, 0, 1}, {-2, 5}, 1, {1, -1}};

/* One candidate and k augmentations from lambda = 0. Sticking: (W + 1/eps) r_k = r_(k-1)/eps - q,
 * by Cramer; slipping: the same of r_n alone, r_t = -mu r_n. */
START_TEST(one_candidate) {
  static model a;
  const double eps[] = {0.5, 3, 50};
  for (int e = 0; e < 3; e++)
    for (int sliding = 0; sliding < 2; sliding++) {
      set_hand(&a, sliding ? &slip : &stick);
      const double *W = a.W, E = 1 / eps[e];
      double n = 0, t = 0;
      for (int k = 1; k <= 6; k++) {
        const double bn = E * n - a.q[0], bt = E * t - a.q[1];
        const double det = (W[0] + E) * (W[3] + E) - W[1] * W[2];
        n = sliding ? bn / (W[0] + E) : ((W[3] + E) * bn - W[2] * bt) / det;
        t = sliding ? -n : ((W[0] + E) * bt - W[1] * bn) / det;
        ck_assert(sliding || fabs(t) < .5 * n);
        dls_augmented_settings s = with_tol(1e-14);
        s.penalty = &eps[e];
        s.adaptive = 0;
        s.max_iterations = k;
        double r[2], u[2];
        dls_info info;
        const dls_status status = run(&a.p, &s, r, u, &info);
        ck_assert(status == DLS_MAX_ITERATIONS && info.iterations == k);
        /* k solutions to 1e-15 |q| or the rounding of |W^-1| |q| */
        ck_assert_double_eq_tol(r[0], n, 1e-13);
        ck_assert_double_eq_tol(r[1], t, 1e-13);
      }
    }
}
END_TEST

/* without friction the error of the normal reaction falls by 1 / (1 + eps w) each time */
START_TEST(factor_of_convergence) {
  static model a;
  set_hand(&a, &slip);
  a.mu[0] = 0;
  for (int e = 0; e < 3; e++) {
    dls_augmented_settings s = with_tol(1e-14);
    s.factor = (double[]){0.3, 1, 20}[e];
    s.adaptive = 0;
    const double w = 1.5, eps = s.factor / w; /* w = trace(W) / 2 */
    double wrong = 1;                         /* r_n = 1 is the solution */
    for (int k = 1; k <= 8; k++) {
      wrong /= 1 + eps * 2;
      s.max_iterations = k;
      double r[2];
      dls_info info;
      ck_assert_int_ge(run(&a.p, &s, r, NULL, &info), 0);
      ck_assert_double_eq_tol(1 - r[0], wrong, 1e-14);
      ck_assert(r[1] == 0);
    }
  }
}
END_TEST

/* (32)-(34) as the paper prints them, each candidate with its penalty: after one augmentation from
 * lambda, r is the return mapping of lambda - eps u. */
START_TEST(return_mapping) {
  static model a;
  random_model(&a, _i);
  const int d = a.p.d, nc = a.p.nc, m = d * nc;
  double eps[most], lambda[most] = {0}, r[most], u[most];
  for (int c = 0; c < nc; c++)
    eps[c] = 2 + uniform();
  dls_augmented_settings s = with_tol(1e-13);
  s.penalty = eps;
  s.adaptive = 0;
  s.max_iterations = 1;
  s.warm_start = 1;
  double size_q = 0;
  for (int k = 0; k < m; k++)
    size_q += a.q[k] * a.q[k];
  for (int augmentation = 0; augmentation < 3; augmentation++) {
    dls_info info;
    memcpy(r, lambda, sizeof r);
    const dls_status status = run(&a.p, &s, r, u, &info);
    ck_assert(status == DLS_MAX_ITERATIONS || (status == DLS_OK && a.q[0] > 0));
    for (int c = 0; c < nc; c++) {
      const double *l = lambda + d * c, *uc = u + d * c;
      double R[3] = {fmax(0, l[0] - eps[c] * uc[0])}; /* (32) */
      double trial = 0;
      for (int i = 1; i < d; i++) { /* (33) */
        R[i] = l[i] - eps[c] * uc[i];
        trial = hypot(trial, R[i]);
      }
      const double excess = trial - a.mu[c] * R[0]; /* (34), f_s */
      for (int i = 1; i < d && excess > 0; i++)
        R[i] -= excess * R[i] / trial;
      for (int i = 0; i < d; i++) /* eps w < 3 times the residual, 1e-14 |q| or its floor */
        ck_assert_double_eq_tol(r[d * c + i], R[i], 1e-12 * (1 + sqrt(size_q)));
    }
    memcpy(lambda, r, sizeof r);
  }
}
END_TEST

/* ---- by hand --------------------------------------------------------------------------------- */

static const hand_case hand[] = {
    {"separate", 2, 1, {2, 1, 1, 2}, {1, -3}, 1, {0, 0}},
    {"q = 0", 2, 1, {2, 1, 1, 2}, {0, 0}, 1, {0, 0}},
    {"C1", 2, 1, {1, 1, 1, 2}, {1, 4}, 2, {0, 0}},
    {"coupled stick", 2, 1, {2, 1, 1, 2}, {-3.5, -1}, .5, {2, -.5}},
    {"coupled slip left", 2, 1, {2, 1, 1, 2}, {-5, -6}, .5, {2, 1}},
    {"coupled slip right", 2, 1, {2, 1, 1, 2}, {-3, 1}, .5, {2, -1}},
    {"no friction", 2, 1, {2, 1, 1, 2}, {-4, 3}, 0, {2, 0}},
    {"C3 below", 2, 1, {1, 1, 1, 1}, {-2, 0}, .5, {4, -2}},
    {"C6", 2, 1, {2, -1, -1, 1}, {-1, 1}, 1, {1. / 3, -1. / 3}},
    {"C7", 2, 1, {1, -1, -1, 2}, {-1, -3}, 2, {5, 4}},
    {"C7 in 3D", 3, 1, {1, -1, 0, -1, 2, 0, 0, 0, 2}, {-1, -3, 0}, 2, {5, 4, 0}},
    {"C9", 2, 1, {1, -1, -1, 2}, {-1, 0}, 3, {2, 1}},
    {"C10", 2, 1, {2, -1, -1, 1}, {-1, 1}, 4, {1. / 6, -2. / 3}},
    {"C11",
     2,
     2,
     {1, 1, 0, -1, 1, 2, 1, -2, 0, 1, 3, 0, -1, -2, 0, 3},
     {-1, 1, -1, 0},
     1,
     {3, -3, 4. / 3, -1}},
    {"C12a", 2, 1, {5, 2, 2, 1}, {-1, 0}, 3, {1, -2}},
    {"C12b",
     2,
     2,
     {3, 1, 0, 1, 1, 2, 2, 0, 0, 2, 3, 0, 1, 0, 0, 1},
     {-2, 0, -1, 0},
     2,
     {6, -10, 7, -6}},
    {"C13",
     2,
     2,
     {4, 1, 0, -1, 1, 1, -1, 0, 0, -1, 4, -1, -1, 0, -1, 1},
     {0, 1, -1, -1},
     2,
     {.25, -.5, .25, .5}},
    {"C14",
     2,
     2,
     {3, 0, -2, 0, 0, 2, 0, -1, -2, 0, 3, -2, 0, -1, -2, 3},
     {0, 0, -1, -2},
     1,
     {26, 16, 39, 32}},
    {"C15",
     2,
     2,
     {3, 0, -1, 1, 0, 3, -2, 1, -1, -2, 2, 0, 1, 1, 0, 4},
     {-2, 0, -2, -1},
     2,
     {34, 59, 77, -23}},
    {"C16", 3, 1, {2, -1, 2, -1, 2, 0, 2, 0, 3}, {-1, 4, 3}, 1, {6, 1, -5}},
    {"slip in 3D", 3, 1, {2, 0, 0, 0, 1, 0, 0, 0, 1}, {-2, 3, 4}, 1, {1, -.6, -.8}},
};

START_TEST(by_hand) {
  const hand_case *k = &hand[_i];
  static model a;
  set_hand(&a, k);
  const dls_augmented_settings s = with_tol(1e-13);
  double r[4], u[4];
  dls_info info;
  ck_assert_msg(run(&a.p, &s, r, u, &info) == DLS_OK, "%s: %g", k->name, info.certificate.residual);
  /* residual <= 1e-13; the worst is C15, where |W^-1| |q| is about 300 and w 3 */
  for (int i = 0; i < k->d * k->nc; i++)
    ck_assert_msg(fabs(r[i] - k->r[i]) <= 1e-10, "%s: r[%d] = %.17g", k->name, i, r[i]);
}
END_TEST

START_TEST(other_solution) { /* C1 from its sticking solution: lambda is one, and stays */
  static model a;
  set_hand(&a, &hand[2]);
  dls_augmented_settings s = with_tol(1e-12);
  s.warm_start = 1;
  double r[2] = {2, -3};
  dls_info info;
  ck_assert_int_eq(run(&a.p, &s, r, NULL, &info), DLS_OK);
  ck_assert(r[0] == 2 && r[1] == -3 && info.iterations == 0);
}
END_TEST

START_TEST(start_too_far) { /* W r overflows */
  static model a;
  set_hand(&a, &stick);
  dls_augmented_settings s = with_tol(1e-12);
  s.warm_start = 1;
  double r[2] = {1.7e308, 1.7e308}, r2[2];
  dls_info info, info2;
  ck_assert_int_eq(run(&a.p, &s, r, NULL, &info), DLS_OK);
  s.warm_start = 0;
  ck_assert_int_eq(run(&a.p, &s, r2, NULL, &info2), DLS_OK);
  ck_assert_mem_eq(r, r2, sizeof r);
}
END_TEST

START_TEST(hyperstatic) { /* C5: two contacts that share everything */
  static model a;
  const hand_case k = {
      "C5", 2, 2, {1, 0, 1, 0, 0, 1, 0, 1, 1, 0, 1, 0, 0, 1, 0, 1}, {-1, .25, -1, .25}, .5, {0}};
  set_hand(&a, &k);
  const dls_augmented_settings s = with_tol(1e-13);
  double r[4], u[4];
  dls_info info;
  ck_assert_int_eq(run(&a.p, &s, r, u, &info), DLS_OK);
  ck_assert(fabs(r[0] + r[2] - 1) <= 1e-12 && fabs(r[1] + r[3] + .25) <= 1e-12);
}
END_TEST

/* ---- no solution ----------------------------------------------------------------------------- */

static const hand_case none[] = {
    {"C3", 2, 1, {1, 1, 1, 1}, {-2, 0}, 1, {1, -1}}, /* r: the direction */
    {"C3 above", 2, 1, {1, 1, 1, 1}, {-2, 0}, 2, {1, -1}},
    {"C4",
     2,
     2,
     {1, 0, -1, 0, 0, 1, 0, 1, -1, 0, 1, 0, 0, 1, 0, 1},
     {-1, 0, -1, 0},
     .3,
     {1, 0, 1, 0}},
    {"C3 in 3D", 3, 1, {1, 1, 0, 1, 1, 0, 0, 0, 1}, {-2, 0, 0}, 2, {1, -1, 0}},
    {"W = 0", 2, 1, {0}, {-1, 0}, 1, {1, 0}},
};

START_TEST(no_solution) {
  const hand_case *k = &none[_i];
  static model a;
  set_hand(&a, k);
  const dls_augmented_settings s = with_tol(1e-8);
  const int m = k->d * k->nc;
  dls_augmented *work = create(&a.p, &s);
  ck_assert_ptr_null(dls_augmented_direction(work));
  double r[4], u[4];
  dls_info info;
  ck_assert_int_eq(run_in(work, &a.p, &s, r, u, &info), DLS_STALLED);
  ck_assert(info.certificate.residual > 0.1 && isfinite(info.certificate.residual));
  const double *delta = dls_augmented_direction(work);
  ck_assert_ptr_nonnull(delta);
  double gain = 0;
  for (int i = 0; i < m; i++) {
    double v = 0;
    for (int j = 0; j < m; j++)
      v += k->W[m * i + j] * delta[j];
    gain += k->q[i] * delta[i];
    ck_assert(fabs(v) < 1e-3);
    ck_assert_double_eq_tol(delta[i], k->r[i], 1e-3); /* (A5): 1e-4 |delta|, |delta| < 2 */
  }
  ck_assert(gain < -0.5);
  if (m == 2) { /* a problem with a solution in the same workspace: no direction */
    set_hand(&a, &stick);
    ck_assert_int_eq(run_in(work, &a.p, &s, r, u, &info), DLS_OK);
  }
  dls_augmented_destroy(work);
}
END_TEST

/* all of data/failures: solved where there is a solution, a direction where there is none */
START_TEST(catalogue) {
  static char names[128][64];
  static failure f;
  char why[200];
  int problems = 0;
  const int n = failures_list(TEST_DATA "/failures", names, 128);
  for (int k = 0; k < n; k++) {
    if (!failure_read(TEST_DATA "/failures", names[k], &f, why)) ck_abort_msg("%s", why);
    if (!f.d) continue; /* an LCP */
    const dls_contact p = {.d = f.d, .nc = f.nc, .W = {f.n, f.n, f.n, f.M}, .q = f.q, .mu = f.mu};
    const dls_augmented_settings s = with_tol(1e-10);
    dls_augmented *work = create(&p, &s);
    double r[FAILURE_N];
    dls_info info;
    const dls_status status = run_in(work, &p, &s, r, NULL, &info);
    ck_assert_msg(status == (f.none ? DLS_STALLED : DLS_OK), "%s: %s", f.name,
                  dls_status_name(status));
    ck_assert_int_eq(dls_augmented_direction(work) != NULL, f.none);
    dls_augmented_destroy(work);
    problems++;
  }
  ck_assert_int_ge(problems, 27);
}
END_TEST

/* C4 with springs too stiff for (A2), and none softer to try; and where they may soften */
START_TEST(too_stiff) {
  static model a;
  set_hand(&a, &none[2]);
  dls_augmented_settings s = with_tol(1e-8);
  s.adaptive = 0;
  s.factor = 1e9;
  dls_augmented *work = create(&a.p, &s);
  double r[4];
  dls_info info;
  ck_assert_int_eq(run_in(work, &a.p, &s, r, NULL, &info), DLS_STALLED);
  ck_assert_int_eq(info.iterations, 1);
  ck_assert_ptr_null(dls_augmented_direction(work));
  dls_augmented_destroy(work);
  s.adaptive = 1;
  work = create(&a.p, &s);
  ck_assert_int_eq(run_in(work, &a.p, &s, r, NULL, &info), DLS_STALLED);
  ck_assert_int_gt(info.iterations, 1);
  ck_assert_ptr_nonnull(dls_augmented_direction(work));
  dls_augmented_destroy(work);
}
END_TEST

/* ---- random ---------------------------------------------------------------------------------- */

START_TEST(random_problem) {
  static model a, b;
  random_model(&a, _i);
  const int d = a.p.d, nc = a.p.nc, m = d * nc;
  const dls_augmented_settings s = with_tol(1e-12);
  double r[most], u[most], r2[most];
  dls_info info, info2;
  ck_assert_int_eq(run(&a.p, &s, r, u, &info), DLS_OK);
  ck_assert(info.certificate.residual <= 1e-12);

  /* again: the same bits */
  ck_assert_int_eq(run(&a.p, &s, r2, NULL, &info2), DLS_OK);
  ck_assert_mem_eq(r, r2, (size_t)m * sizeof *r);
  ck_assert(info.iterations == info2.iterations && info.factorisations == info2.factorisations);

  /* from the answer: nothing to do */
  dls_augmented_settings warm = s;
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

  /* another method: the same answer */
  dls_nlgs_settings sweeps;
  dls_nlgs_settings_init(&sweeps);
  sweeps.tol = 1e-12;
  dls_nlgs *nlgs;
  ck_assert_int_eq(dls_nlgs_create(&nlgs, d, nc, &sweeps, NULL), DLS_OK);
  ck_assert_int_eq(dls_nlgs_solve(nlgs, &a.p, r2, NULL, NULL, NULL), DLS_OK);
  dls_nlgs_destroy(nlgs);
  for (int k = 0; k < m; k++)
    ck_assert(fabs(r[k] - r2[k]) <= close);

  /* W by blocks: the same bits */
  static double x[most * most];
  int p[most + 1], i[most * most];
  for (int c = 0, k = 0; c < nc; c++) {
    p[c] = k;
    for (int e = 0; e < nc; e++, k++) {
      i[k] = e;
      for (int f = 0; f < d * d; f++)
        x[k * d * d + f] = a.W[d * e + f % d + m * (d * c + f / d)];
    }
    p[c + 1] = k;
  }
  dls_contact blocks = a.p;
  memset(&blocks.W, 0, sizeof blocks.W);
  blocks.Wb = (dls_blocks){d, nc, p, i, x};
  ck_assert_int_eq(run(&blocks, &s, r2, NULL, &info2), DLS_OK);
  ck_assert_mem_eq(r, r2, (size_t)m * sizeof *r);

  /* candidates in reverse order: the same answer */
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

START_TEST(rank_deficient) {
  static model a;
  deficient_model(&a, _i);
  const dls_augmented_settings s = with_tol(1e-12);
  double r[most];
  dls_info info;
  ck_assert_int_eq(run(&a.p, &s, r, NULL, &info), DLS_OK);
}
END_TEST

START_TEST(units) {
  static model a, b;
  if (_i % 2)
    deficient_model(&a, _i);
  else
    random_model(&a, _i);
  const int m = a.p.d * a.p.nc;
  double r[most], r2[most], eps[most], eps2[most];
  for (int c = 0; c < a.p.nc; c++)
    eps[c] = 100 + 50 * uniform();
  for (int given = 0; given < 2; given++)
    for (int length = -1; length <= 1; length++)
      for (int force = -1; force <= 1; force++)
        for (int two = 0; two < 2; two++) {
          dls_augmented_settings s = with_tol(1e-10);
          dls_info info, info2;
          s.penalty = given ? eps : NULL;
          ck_assert_int_eq(run(&a.p, &s, r, NULL, &info), DLS_OK);
          const double al = two ? ldexp(1, 30 * length) : pow(10, 9 * length);
          const double be = two ? ldexp(1, 30 * force) : pow(10, 9 * force);
          copy_model(&b, &a);
          for (int k = 0; k < m; k++) {
            b.q[k] *= al;
            eps2[k] = eps[k / a.p.d] * (be / al);
          }
          for (int c = 0; c < a.p.nc; c++)
            eps2[c] = eps[c] * (be / al);
          for (int k = 0; k < m * m; k++)
            b.W[k] *= al / be;
          s.penalty = given ? eps2 : NULL;
          ck_assert_int_eq(run(&b.p, &s, r2, NULL, &info2), DLS_OK);
          ck_assert_int_eq(info2.iterations, info.iterations);
          ck_assert_int_eq(info2.factorisations, info.factorisations);
          for (int k = 0; two && !given && k < m; k++)
            ck_assert(r2[k] == be * r[k]);
        }
}
END_TEST

/* each candidate's tangents turned by an angle of its own */
START_TEST(turned_tangents) {
  static model a, b;
  random_model(&a, 2 * _i + 1);
  const int nc = a.p.nc, m = 3 * nc;
  ck_assert_int_eq(a.p.d, 3);
  double co[most], si[most], r[most], r2[most];
  for (int c = 0; c < nc; c++) {
    const double angle = 3 * uniform();
    co[c] = cos(angle);
    si[c] = sin(angle);
  }
  copy_model(&b, &a);
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
  const dls_augmented_settings s = with_tol(1e-10);
  dls_info info, info2;
  ck_assert_int_eq(run(&a.p, &s, r, NULL, &info), DLS_OK);
  ck_assert_int_eq(run(&b.p, &s, r2, NULL, &info2), DLS_OK);
  ck_assert(info.iterations == info2.iterations && info.factorisations == info2.factorisations);
  for (int c = 0; c < nc; c++) { /* the same steps, but for rounding */
    const int n = 3 * c, t = n + 1;
    ck_assert(fabs(r2[n] - r[n]) <= 1e-11);
    ck_assert(fabs(r2[t] - (co[c] * r[t] + si[c] * r[t + 1])) <= 1e-11);
    ck_assert(fabs(r2[t + 1] - (co[c] * r[t + 1] - si[c] * r[t])) <= 1e-11);
  }
}
END_TEST

START_TEST(tolerance_zero) { /* the floor ends it */
  static model a;
  random_model(&a, _i);
  const dls_augmented_settings s = with_tol(0);
  double r[most];
  dls_info info;
  ck_assert_int_eq(run(&a.p, &s, r, NULL, &info), DLS_OK);
  ck_assert(info.certificate.residual <= 4 * info.certificate.floor);
}
END_TEST

START_TEST(
    smaller_problem_and_new_q) { /* a workspace serves what fits, time step after time step */
  static model a, b;
  deficient_model(&a, 11);
  deficient_model(&b, 5);
  ck_assert(a.p.d == b.p.d && a.p.nc > b.p.nc);
  const dls_augmented_settings s = with_tol(1e-10);
  dls_augmented *work = create(&a.p, &s);
  double r[most], r2[most];
  dls_info info;
  malloc_fails_at(0);
  const dls_status first = dls_augmented_solve(work, &a.p, r, NULL, &info, NULL);
  const int factorisations = info.factorisations;
  const dls_status second = dls_augmented_solve(work, &b.p, r, NULL, NULL, NULL);
  const long calls = malloc_calls();
  ck_assert(first == DLS_OK && second == DLS_OK && calls == 0 && factorisations > 0);
  ck_assert_int_eq(run(&b.p, &s, r2, NULL, &info), DLS_OK);
  ck_assert_mem_eq(r, r2, (size_t)(b.p.d * b.p.nc) * sizeof *r);
  dls_augmented_destroy(work);
}
END_TEST

/* ---- progress -------------------------------------------------------------------------------- */

typedef struct watch {
  double least;
  int calls, cancel_at;
} watch;

static int look(void *data, const dls_progress *progress) {
  watch *w = data;
  ck_assert_int_eq(progress->iteration, ++w->calls);
  ck_assert_str_eq(progress->method, "augmented-lagrangian");
  ck_assert_int_eq(progress->max_iterations, 400);
  if (progress->residual < w->least) w->least = progress->residual;
  return w->calls == w->cancel_at;
}

START_TEST(cancelled) {
  static model a;
  random_model(&a, 18);
  for (int cancel_at = 0; cancel_at < 3; cancel_at++) {
    watch w = {INFINITY, 0, cancel_at};
    dls_augmented_settings s = with_tol(1e-12);
    s.progress = look;
    s.progress_data = &w;
    double r[most];
    dls_info info;
    ck_assert_int_eq(run(&a.p, &s, r, NULL, &info), cancel_at ? DLS_CANCELLED : DLS_OK);
    ck_assert_int_eq(info.iterations, w.calls);
    ck_assert(cancel_at == 0 || w.calls == cancel_at);
    ck_assert(info.certificate.residual == w.least); /* the best of them */
  }
}
END_TEST

/* ---- the front door -------------------------------------------------------------------------- */

START_TEST(by_name) {
  static model a;
  random_model(&a, _i);
  if (a.p.nc < 2) return;
  dls_solver_settings s;
  dls_solver_settings_init(&s);
  double r[most], r2[most], u[most];
  dls_info info;
  ck_assert_int_eq(dls_method_find("augmented-lagrangian", &s.method), 1);
  ck_assert_int_eq(s.method, DLS_AUGMENTED_LAGRANGIAN);
  s.tol = 1e-12;
  ck_assert_int_eq(dls_solve(&a.p, &s, r, NULL, &info, NULL), DLS_OK);
  ck_assert_int_eq(info.method, DLS_AUGMENTED_LAGRANGIAN);

  /* the penalty method has an error, says so, and is as good as its certificate */
  ck_assert_int_eq(dls_method_find("penalty", &s.method), 1);
  ck_assert_int_eq(s.method, DLS_PENALTY);
  ck_assert_int_eq(dls_solve(&a.p, &s, r2, u, &info, NULL), DLS_MAX_ITERATIONS);
  ck_assert(info.method == DLS_PENALTY && info.status == DLS_MAX_ITERATIONS);
  ck_assert(info.iterations == 1);
  ck_assert(info.certificate.residual > 1e-12 && info.certificate.residual < 1e-4);
  for (int k = 0; k < a.p.d * a.p.nc; k++)
    if (k % a.p.d == 0) ck_assert(u[k] <= 0 || r2[k] == 0); /* springs are pressed in */
  s.tol = 1e-4;
  ck_assert_int_eq(dls_solve(&a.p, &s, r2, NULL, &info, NULL), DLS_OK);
}
END_TEST

/* ---- bad input ------------------------------------------------------------------------------- */

static void expect_create(dls_status status, const char *argument, long long index, int d, int nc,
                          const dls_augmented_settings *s) {
  dls_error error = {0};
  dls_augmented *work = (dls_augmented *)&error; /* must become NULL */
  ck_assert_int_eq(dls_augmented_create(&work, d, nc, s, &error), status);
  ck_assert_ptr_null(work);
  ck_assert_int_eq(error.status, status);
  ck_assert_str_eq(error.function, "dls_augmented_create");
  ck_assert_str_eq(error.argument, argument);
  ck_assert(error.index == index);
  ck_assert_int_eq(dls_augmented_create(&work, d, nc, s, NULL), status);
}

START_TEST(bad_create) {
  dls_error error;
  const dls_augmented_settings good = with_tol(1e-8);
  ck_assert_int_eq(dls_augmented_create(NULL, 2, 1, &good, &error), DLS_E_ARGUMENT);
  ck_assert_str_eq(error.argument, "out");
  expect_create(DLS_E_ARGUMENT, "d", -1, 1, 1, &good);
  expect_create(DLS_E_ARGUMENT, "d", -1, 4, 1, &good);
  expect_create(DLS_E_SIZE, "nc", -1, 2, 0, &good);
  expect_create(DLS_E_SIZE, "nc", -1, 3, INT_MAX, &good);
  expect_create(DLS_E_SIZE, "nc", -1, 3, INT_MAX / 3, &good); /* m^2 doubles */
  expect_create(DLS_E_ARGUMENT, "settings", -1, 2, 1, NULL);
  dls_augmented_settings s = {0};
  expect_create(DLS_E_SETTINGS, "settings", -1, 2, 1, &s);
  const double bad_tol[] = {-1, NAN, INFINITY}, bad[] = {0, -1, NAN, INFINITY, 1e-320};
  for (int k = 0; k < 3; k++) {
    s = good;
    s.tol = bad_tol[k];
    expect_create(DLS_E_ARGUMENT, "tol", -1, 2, 1, &s);
  }
  for (int k = 0; k < 5; k++) {
    s = good;
    s.factor = bad[k];
    expect_create(DLS_E_ARGUMENT, "factor", -1, 2, 1, &s);
    const double penalty[] = {1, 1e300, bad[k]};
    s = good;
    s.penalty = penalty;
    expect_create(isfinite(bad[k]) ? DLS_E_ARGUMENT : DLS_E_NOT_FINITE, "penalty", 2, 2, 3, &s);
  }
  s = good;
  s.max_iterations = 0;
  expect_create(DLS_E_ARGUMENT, "max_iterations", -1, 2, 1, &s);
  s = good;
  s.blocks = -1;
  expect_create(DLS_E_ARGUMENT, "blocks", -1, 2, 1, &s);
  s = good;
  s.adaptive = -1;
  expect_create(DLS_E_ARGUMENT, "adaptive", -1, 2, 1, &s);
  s = good;
  s.warm_start = 2;
  expect_create(DLS_E_ARGUMENT, "warm_start", -1, 2, 1, &s);
  dls_augmented_settings_init(NULL);
  dls_augmented_destroy(NULL);
  ck_assert_ptr_null(dls_augmented_direction(NULL));
}
END_TEST

static void expect_solve(dls_augmented *work, dls_status status, const char *argument,
                         long long index, const dls_contact *p, double *r) {
  dls_error error = {0};
  dls_info info, same_info;
  double u[most], same_u[most], same_r[most];
  memset(&info, 7, sizeof info);
  memset(u, 7, sizeof u);
  same_info = info;
  memcpy(same_u, u, sizeof u);
  if (r) memcpy(same_r, r, sizeof same_r);
  ck_assert_int_eq(dls_augmented_solve(work, p, r, u, &info, &error), status);
  ck_assert_str_eq(error.function, "dls_augmented_solve");
  ck_assert_str_eq(error.argument, argument);
  ck_assert(error.index == index);
  ck_assert_mem_eq(&info, &same_info, sizeof info);
  ck_assert_mem_eq(u, same_u, sizeof u);
  if (r) ck_assert_mem_eq(r, same_r, sizeof same_r);
}

START_TEST(bad_solve) {
  static model a, b;
  random_model(&a, 6); /* 2D, 7 candidates */
  dls_augmented_settings s = with_tol(1e-8);
  s.warm_start = 1;
  dls_augmented *work, *small, *other;
  ck_assert_int_eq(dls_augmented_create(&work, 2, 7, &s, NULL), DLS_OK);
  ck_assert_int_eq(dls_augmented_create(&small, 2, 6, &s, NULL), DLS_OK);
  ck_assert_int_eq(dls_augmented_create(&other, 3, 7, &s, NULL), DLS_OK);
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
    copy_model(&b, &a);                                                                            \
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
  dls_augmented_destroy(work);
  dls_augmented_destroy(small);
  dls_augmented_destroy(other);
}
END_TEST

/* A chain of candidates by blocks with more unknowns than are factorised dense, pressed and pushed:
 * as announced to create nothing is allocated, not announced the same bits. Sparse and dense agree. */
START_TEST(by_blocks) {
  enum { nc = 200, m = 2 * nc };
  static double x[12 * nc], W[m * m], q[m], mu[nc], r[3][m];
  static int p[nc + 1], i[3 * nc];
  int k = 0;
  for (int b = 0; b < nc; b++) {
    for (int a = b - 1; a <= b + 1; a++) {
      if (a < 0 || a >= nc) continue;
      const double block[4] = {a == b ? 1 : .49, .1 * (a - b), .1 * (b - a), a == b ? 1 : .49};
      memcpy(x + 4 * k, block, sizeof block);
      i[k++] = a;
      for (int e = 0; e < 4; e++)
        W[2 * a + e % 2 + m * (2 * b + e / 2)] = block[e];
    }
    p[b + 1] = k;
    q[2 * b] = -1 + .2 * sin(b);
    q[2 * b + 1] = .3 * cos(3 * b);
    mu[b] = 1;
  }
  const dls_contact dense = {.d = 2, .nc = nc, .W = {m, m, m, W}, .q = q, .mu = mu};
  const dls_contact blocks = {.d = 2, .nc = nc, .Wb = {2, nc, p, i, x}, .q = q, .mu = mu};
  const double entries = 4. * k + m, own = 8. * ((9 + 14 + 2) * m + (4 + 9) * nc);
  for (int way = 0; way < 3; way++) { /* dense; by blocks, announced; not announced */
    dls_augmented_settings s = with_tol(1e-12);
    s.blocks = way == 1 ? k : 0;
    malloc_fails_at(0);
    dls_augmented *work = create(&dense, &s);
    const double got = (double)malloc_bytes();
    const double bytes =
        own +
        (way == 1 && WITH_MUMPS ? 8. * 250 * 250 + (16. + 3 * sizeof(int)) * entries : 8. * m * m);
    ck_assert_msg(got >= bytes && got <= bytes + 14000, "%.0f, %.0f", got, bytes);
    dls_info info;
    malloc_fails_at(0);
    const dls_status status =
        dls_augmented_solve(work, way ? &blocks : &dense, r[way], NULL, &info, NULL);
    const long calls = malloc_calls();
    ck_assert(status == DLS_OK && info.factorisations > 0);
    ck_assert_int_eq(calls > 0, way == 2 && WITH_MUMPS);
    dls_augmented_destroy(work);
  }
  ck_assert_mem_eq(r[1], r[2], sizeof r[1]);
  for (int e = 0; e < m; e++) /* |W^-1| < 60, |q| < 20 */
    ck_assert(fabs(r[0][e] - r[1][e]) <= 1e-9);
}
END_TEST

START_TEST(no_memory) {
  const dls_augmented_settings s = with_tol(1e-8);
  dls_solver_settings front;
  dls_solver_settings_init(&front);
  for (int door = 0; door < 3; door++) {
    dls_error error;
    dls_augmented *work;
    dls_solver *solver;
    front.method = door == 1 ? DLS_AUGMENTED_LAGRANGIAN : DLS_PENALTY;
    long k = 1;
    for (;; k++) {
      malloc_fails_at(k);
      const dls_status status = door ? dls_solver_create(&solver, 3, 10, &front, &error)
                                     : dls_augmented_create(&work, 3, 10, &s, &error);
      malloc_fails_at(0);
      if (status == DLS_OK) break;
      ck_assert_int_eq(status, DLS_E_MEMORY);
      ck_assert(door ? solver == NULL : work == NULL);
    }
    ck_assert_int_gt(k, door ? 2 : 1);
    if (door)
      dls_solver_destroy(solver);
    else
      dls_augmented_destroy(work);
  }
}
END_TEST

int main(void) {
  Suite *suite = suite_create("augmented");
  TCase *t = tcase_create("springs");
  tcase_add_test(t, one_candidate);
  tcase_add_test(t, factor_of_convergence);
  tcase_add_loop_test(t, return_mapping, 0, 40);
  suite_add_tcase(suite, t);
  t = tcase_create("by hand");
  tcase_add_loop_test(t, by_hand, 0, sizeof hand / sizeof hand[0]);
  tcase_add_test(t, other_solution);
  tcase_add_test(t, start_too_far);
  tcase_add_test(t, hyperstatic);
  tcase_add_loop_test(t, no_solution, 0, sizeof none / sizeof none[0]);
  tcase_add_test(t, catalogue);
  tcase_add_test(t, too_stiff);
  suite_add_tcase(suite, t);
  t = tcase_create("random");
  tcase_set_timeout(t, 60);
  tcase_add_loop_test(t, random_problem, 0, 40);
  tcase_add_loop_test(t, rank_deficient, 0, 24);
  tcase_add_loop_test(t, units, 0, 12);
  tcase_add_loop_test(t, turned_tangents, 0, 10);
  tcase_add_loop_test(t, tolerance_zero, 0, 20);
  tcase_add_test(t, smaller_problem_and_new_q);
  tcase_add_test(t, by_blocks);
  tcase_add_test(t, cancelled);
  tcase_add_loop_test(t, by_name, 0, 20);
  suite_add_tcase(suite, t);
  t = tcase_create("bad input");
  tcase_add_test(t, bad_create);
  tcase_add_test(t, bad_solve);
  tcase_add_test(t, no_memory);
  suite_add_tcase(suite, t);
  SRunner *runner = srunner_create(suite);
  srunner_run_all(runner, CK_NORMAL);
  const int failed = srunner_ntests_failed(runner);
  srunner_free(runner);
  return failed ? EXIT_FAILURE : EXIT_SUCCESS;
}
