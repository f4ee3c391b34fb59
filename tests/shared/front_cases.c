/* front_cases.c: implements front_cases.h. */
#include "front_cases.h"

#include <check.h>
#include <math.h>

#include "malloc_fails.h"

enum { most_here = 24 }; /* rows of coupled() and of fail_in_turn() */

double draw(unsigned *seed) {
  *seed = *seed * 1664525u + 1013904223u;
  return (double)(*seed >> 8) / (1 << 23) - 1;
}

int same_certificate(const dls_certificate *a, const dls_certificate *b) {
  return a->residual == b->residual && a->residual_u == b->residual_u &&
         a->residual_r == b->residual_r && a->floor_u == b->floor_u && a->floor_r == b->floor_r &&
         a->penetration == b->penetration && a->adhesion == b->adhesion &&
         a->cone_violation == b->cone_violation && a->slip_direction == b->slip_direction &&
         a->complementarity == b->complementarity && a->worst == b->worst;
}

dls_solver_settings settings_of(dls_method method) {
  dls_solver_settings s;
  dls_solver_settings_init(&s);
  s.method = method;
  s.limits.tol = 1e-13;
  return s;
}

/* ---- problems -------------------------------------------------------------------------------- */

dls_contact coupled(double *W, double *q, double *mu, int d, int nc, double diagonal,
                    double friction, unsigned seed) {
  double A[most_here * most_here];
  const int m = d * nc;
  ck_assert_int_le(m, most_here);
  for (int k = 0; k < m * m; k++)
    A[k] = draw(&seed);
  for (int i = 0; i < m; i++)
    for (int j = 0; j < m; j++) {
      double sum = i == j ? diagonal : 0;
      for (int k = 0; k < m; k++)
        sum += A[k + m * i] * A[k + m * j] / m;
      W[i + m * j] = sum;
    }
  for (int i = 0; i < m; i++)
    q[i] = draw(&seed) - (i % d ? 0 : 0.5);
  for (int c = 0; c < nc; c++)
    mu[c] = c % 4 == 3 ? 0 : friction;
  return (dls_contact){.d = d, .nc = nc, .W = {m, m, m, W}, .q = q, .mu = mu};
}

dls_contact planted_graded(planted_problem *a, int d, int nc, int rank, double condition,
                           double friction, unsigned seed) {
  static double B[9 * PLANTED * PLANTED];
  const int m = d * nc;
  double r[3 * PLANTED] = {0}, u[3 * PLANTED] = {0};
  for (int k = 0; k < m * rank; k++)
    B[k] = draw(&seed) * pow(condition, -0.5 * (k / m) / (rank - 1));
  for (int c = 0; c < nc; c++) {
    const double state = draw(&seed), size = 1.5 + draw(&seed);
    const double t[2] = {draw(&seed), d == 3 ? draw(&seed) : 0}, l = hypot(t[0], t[1]);
    a->mu[c] = friction;
    if (state < -1. / 3)
      u[d * c] = size;
    else
      r[d * c] = size;
    for (int i = 1; i < d; i++) {
      if (state < -1. / 3)
        u[d * c + i] = t[i - 1];
      else if (state < 1. / 3) {
        r[d * c + i] = friction * size * t[i - 1] / l;
        u[d * c + i] = -t[i - 1];
      } else
        r[d * c + i] = 0.5 * friction * size * t[i - 1];
    }
  }
  for (int i = 0; i < m; i++) {
    a->q[i] = u[i];
    for (int j = 0; j < m; j++) {
      double sum = 0;
      for (int k = 0; k < rank; k++)
        sum += B[i + m * k] * B[j + m * k] / rank;
      a->W[i + m * j] = sum;
      a->q[i] -= sum * r[j];
    }
  }
  return (dls_contact){.d = d, .nc = nc, .W = {m, m, m, a->W}, .q = a->q, .mu = a->mu};
}

dls_contact planted(planted_problem *a, int d, int nc, int rank, double friction, unsigned seed) {
  return planted_graded(a, d, nc, rank, 1, friction, seed);
}

dls_contact planted_case(planted_problem *a, int k) {
  const int d = 2 + k % 2, nc = 10 + 5 * (k % 7);
  return planted(a, d, nc, k % 3 ? d * nc : (d * nc + 1) / 2, k % 3 ? 1 : 3, (unsigned)k + 1);
}

/* ---- auto ------------------------------------------------------------------------------------ */

dls_info solve_auto(const dls_contact *p, double tol, double *r) {
  dls_solver_settings s = settings_of(DLS_AUTO);
  s.limits.tol = tol;
  dls_info info;
  ck_assert_int_ge(dls_solve(p, &s, r, NULL, &info, NULL), 0);
  return info;
}

void check_report(const dls_info *info) {
  int iterations = 0, factorisations = 0;
  double least = INFINITY;
  ck_assert(info->method == DLS_AUTO && info->stages >= 1 && info->stages <= DLS_STAGES_MAX);
  for (int k = 0; k < info->stages; k++) {
    const dls_stage *s = &info->stage[k];
    ck_assert_ptr_nonnull(dls_method_name(s->method));
    iterations += s->iterations;
    factorisations += s->factorisations;
    least = fmin(least, s->residual);
  }
  ck_assert_int_eq(iterations, info->iterations);
  ck_assert_int_eq(factorisations, info->factorisations);
  const dls_certificate *c = &info->certificate; /* auto's copy rounds otherwise */
  ck_assert(fabs(least - c->residual) <= 4 * fmax(c->floor_u, c->floor_r));
}

void same_stages(const dls_info *a, const dls_info *b) {
  ck_assert_int_eq(a->stages, b->stages);
  for (int k = 0; k < a->stages; k++)
    ck_assert(a->stage[k].method == b->stage[k].method &&
              a->stage[k].iterations == b->stage[k].iterations);
}

long fail_in_turn(const dls_contact *p, const dls_solver_settings *s, int at_once) {
  double r[most_here] = {9};
  ck_assert_int_le(p->d * p->nc, most_here);
  dls_status status = DLS_E_MEMORY;
  long failed = 0;
  for (long at = 1; status == DLS_E_MEMORY; at++) {
    dls_error e = {0};
    dls_solver *solver = NULL;
    malloc_fails_at(at);
    if (at_once)
      status = dls_solve(p, s, r, NULL, NULL, &e);
    else
      status = dls_solver_create(&solver, p->d, p->nc, s, &e);
    malloc_fails_at(0);
    if (!at_once && !status) status = dls_solver_solve(solver, p, r, NULL, NULL, &e);
    dls_solver_destroy(solver);
    if (status == DLS_E_MEMORY) {
      failed++;
      ck_assert(r[0] == 9 && e.status == DLS_E_MEMORY);
    }
  }
  ck_assert_int_eq(status, DLS_OK);
  return failed;
}
