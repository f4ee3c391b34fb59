/*
 * test_trails.c: pins how the methods go, step by step, on problems of many kinds: trails.txt has
 * a line for each problem and run. A change of a constant, a sign or an order in a method shows
 * there, where a test of its answer alone would pass. A change of tuning that is meant makes new
 * figures, which
 *
 *   build/tests/tuning/test_trails print
 *
 * writes. It solves each problem again with W and q disturbed by rounding, and writes - for a
 * figure that does not survive it: that one would differ between processors, too.
 */
#include <check.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "cases.h"
#include "delassus.h"
#include "failures.h"
#include "front_cases.h"
#include "rigid.h"
#include "run.h"

/* ---- problems -------------------------------------------------------------------------------- */

typedef struct trails_problem {
  char name[64];
  dls_contact p;
  rigid bodies; /* owns the arrays of p where bodies.p is set */
} trails_problem;

enum { half_cells = 60, side = 7, surface_rows = 3 * side * side };

/* A surface of 7 x 7 points that move along by exp(-distance / 10), normals and tangents coupled,
 * under a load by chance: sweeps and Newton's method alone do not get far. */
static dls_contact trails_surface(double friction, unsigned seed) {
  static double W[surface_rows * surface_rows], q[surface_rows], mu[side * side];
  enum { nc = side * side, m = surface_rows };
  for (int c = 0; c < nc; c++) {
    mu[c] = friction;
    for (int i = 0; i < 3; i++)
      q[3 * c + i] = draw(&seed) - (i ? 0 : .5);
    for (int b = 0; b < nc; b++) {
      const double x = c % side - b % side, y = c / side - b / side, r = hypot(x, y);
      const double g = exp(-.1 * r), couple[3] = {0, .3 * x * g / (1 + r), .3 * y * g / (1 + r)};
      for (int i = 0; i < 3; i++)
        for (int j = 0; j < 3; j++)
          W[3 * c + i + (3 * b + j) * m] =
              (i == j ? g : 0) + (j == 0 ? couple[i] : 0) - (i == 0 ? couple[j] : 0);
    }
  }
  return (dls_contact){.d = 3, .nc = nc, .W = {m, m, m, W}, .q = q, .mu = mu};
}

/* W of 40 candidates and rank 84 but for 1e-3, much friction, most candidates lifted: Newton's
 * method fails where ADMM is forecast to cost more than the sweeps ahead. */
static dls_contact trails_low_rank(unsigned seed) {
  enum { nc = 40, m = 3 * nc, rank = 84 };
  static double W[m * m], q[m], mu[nc], G[m * rank];
  for (int k = 0; k < m * rank; k++)
    G[k] = draw(&seed);
  for (int j = 0; j < m; j++)
    for (int i = 0; i < m; i++) {
      double sum = 0;
      for (int k = 0; k < rank; k++)
        sum += G[i + k * m] * G[j + k * m];
      W[i + j * m] = sum / rank + (i == j ? 1e-3 : 0);
    }
  for (int i = 0; i < m; i++) {
    mu[i / 3] = 4;
    q[i] = draw(&seed) + (i % 3 ? 0 : .5);
  }
  return (dls_contact){.d = 3, .nc = nc, .W = {m, m, m, W}, .q = q, .mu = mu};
}

/* a->p := problem k in storage that lasts until the next call. Returns 0 past the last one. */
static int trails_make(int k, trails_problem *a) {
  static model m, copy;
  static bodies_storage storage;
  static planted_problem plant;
  static double W[4 * half_cells * half_cells], q[2 * half_cells], mu[half_cells];
  memset(a, 0, sizeof *a);
  int at = k;
#define TRAILS(count, ...)                                                                         \
  do {                                                                                             \
    if (at >= 0 && at < (count)) {                                                                 \
      __VA_ARGS__;                                                                                 \
      return 1;                                                                                    \
    }                                                                                              \
    at -= (count);                                                                                 \
  } while (0)
  TRAILS(8, numbered_model(&m, at < 6 ? 3 * at + 2 : normal_models + at);
         (void)snprintf(a->name, sizeof a->name, "random-%d", at); a->p = m.p);
  TRAILS(4, deficient_model(&m, at); (void)snprintf(a->name, sizeof a->name, "deficient-%d", at);
         a->p = m.p);
  TRAILS(2, slow_model(&m, at); (void)snprintf(a->name, sizeof a->name, "slow-%d", at); a->p = m.p);
  TRAILS(1, slow_model(&copy, 1); scale_model(&m, &copy, 1e-3, 1e6);
         (void)snprintf(a->name, sizeof a->name, "other-units"); a->p = m.p);
  TRAILS(7, a->p = planted_case(&plant, at);
         (void)snprintf(a->name, sizeof a->name, "planted-%d", at));
  TRAILS(2, a->p = half_plane(W, q, mu, at ? half_cells : 24, 2, at ? .3 : .8, at ? 3 : .5, .4);
         (void)snprintf(a->name, sizeof a->name, "half-plane-%d", at));
  TRAILS(3, bodies_model(&m, &storage, &a->p, at + 3);
         (void)snprintf(a->name, sizeof a->name, "bodies-%d", at));
  int count;
  const failure *f = contact_failures(&count);
  TRAILS(count, a->p = failure_contact(&f[at]);
         (void)snprintf(a->name, sizeof a->name, "%.50s", f[at].name));
  int kinds = 0;
  while (rigid_kind(kinds))
    kinds++;
  /* every kind by blocks, of bodies, larger */
  static const struct {
    const char *name;
    int of_bodies, candidates;
  } size[] = {{"", 0, 36},
              {"-of-bodies", 1, 36},
              {"-150", 0, 150},
              {"-150-of-bodies", 1, 150},
              {"-500", 0, 500}};
  enum { sizes = sizeof size / sizeof size[0] };
  TRAILS(sizes * kinds, const char *kind = rigid_kind(at / sizes); const int s = at % sizes;
         ck_assert_int_eq(rigid_create(&a->bodies, kind, size[s].candidates, .5, 7), 0);
         a->p = size[s].of_bodies ? a->bodies.factored : a->bodies.contact;
         (void)snprintf(a->name, sizeof a->name, "%s%s", kind, size[s].name));
  /* with slabs for several threads */
  static const char *const large[] = {"chain", "packing-flow", "wall-pushed"};
  TRAILS(6, const int of_bodies = at % 2;
         ck_assert_int_eq(rigid_create(&a->bodies, large[at / 2], 2000, .5, 7), 0);
         a->p = of_bodies ? a->bodies.factored : a->bodies.contact; (void)snprintf(
             a->name, sizeof a->name, "%s-2000%s", large[at / 2], of_bodies ? "-of-bodies" : ""));
  /* where the first path of the homotopy leads nowhere */
  TRAILS(2, a->p = at ? planted(&plant, 3, 3, 5, 3, 45) : planted(&plant, 2, 4, 4, 10, 14);
         (void)snprintf(a->name, sizeof a->name, "later-start-%d", at));
  TRAILS(8, a->p = trails_surface(1 << at / 2, (unsigned)at + 5);
         (void)snprintf(a->name, sizeof a->name, "surface-%d", at));
  TRAILS(1, a->p = trails_low_rank(619); (void)snprintf(a->name, sizeof a->name, "low-rank"));
#undef TRAILS
  return 0;
}

static void trails_free(trails_problem *a) {
  if (a->bodies.p) rigid_free(&a->bodies);
}

/* ---- what a run leaves ----------------------------------------------------------------------- */

enum { most_counts = 400, most_sums = 120 };
typedef struct trail {
  int counts, sums, calls;
  int count[most_counts];     /* compared exactly */
  double sum[most_sums];      /* compared to sum_tol */
  double residuals[2], steps; /* of early calls, of all; what else the callback is told */
} trail;

static const char trails_file[] = TEST_DATA "/../tests/tuning/trails.txt";
static const double sum_tol = 1e-5;

static void trails_count(trail *t, int x) {
  ck_assert_int_lt(t->counts, most_counts);
  t->count[t->counts++] = x;
}

static void trails_sum(trail *t, double x) {
  ck_assert_int_lt(t->sums, most_sums);
  t->sum[t->sums++] = isfinite(x) ? x : 1e9;
}

static double trails_weight(int k) {
  return 1 + fmod(.6180339887498949 * (k + 1), 1);
}

/* Puts a weighted sum of the x_i over their size. */
static void trails_vector(trail *t, const double *x, int n) {
  double sum = 0;
  for (int i = 0; i < n; i++)
    sum += trails_weight(i) * x[i];
  const double size = norm_of(x, n);
  trails_sum(t, size > 0 ? sum / size : 0);
}

/* Returns the logarithm of a residual: 0 where rounding leaves noise, 1 where it is unknown. */
static double size_of_residual(double residual) {
  return residual > 1e-7 ? log10(residual) : residual < 0;
}

static int trails_look(void *data, const dls_progress *progress) {
  trail *t = data;
  const int k = t->calls++;
  const double size = trails_weight(k) * size_of_residual(progress->residual);
  if (k < 10) t->residuals[0] += size;
  t->residuals[1] += size;
  t->steps += trails_weight(k) * (progress->iteration + progress->max_iterations + progress->last) +
              progress->stage[0] + progress->stage[1];
  return 0;
}

static void trails_calls(trail *t) {
  trails_count(t, t->calls);
  trails_sum(t, t->residuals[0]);
  trails_sum(t, t->residuals[1]);
  trails_sum(t, t->steps);
}

static void trails_info(trail *t, const dls_info *info) {
  trails_count(t, (int)info->status);
  trails_count(t, info->iterations);
  trails_count(t, info->factorisations);
  trails_count(t, info->sweeps);
  trails_count(t, info->ambiguous);
  trails_count(t, (int)info->unique);
  const dls_certificate *c = &info->certificate;
  trails_sum(t, size_of_residual(c->residual_u + 2 * c->residual_r));
  double sum = 0;
  for (int k = 0; k < info->stages; k++) {
    trails_count(t, (int)info->stage[k].method);
    trails_count(t, info->stage[k].factorisations);
    trails_count(t, info->stage[k].iterations);
    sum += trails_weight(k) * size_of_residual(info->stage[k].residual);
  }
  trails_sum(t, sum);
}

/* ---- runs ------------------------------------------------------------------------------------ */

static const struct {
  const char *name;
  dls_method method;
  dls_acceleration acceleration;
  int max_iterations, most_rows;
  int threads; /* more than 1: of many candidates alone */
} runs[] = {
    {"nlgs", DLS_NLGS, DLS_ACCELERATION_NONE, 200, 1000, 1},
    {"aitken", DLS_NLGS, DLS_ACCELERATION_AITKEN, 200, 1000, 1},
    {"anderson", DLS_NLGS, DLS_ACCELERATION_ANDERSON, 200, 1000, 1},
    {"momentum", DLS_NLGS, DLS_ACCELERATION_MOMENTUM, 900, 1000, 1},
    {"newton", DLS_NEWTON, DLS_ACCELERATION_NONE, 12, 300, 1},
    {"admm", DLS_ADMM, DLS_ACCELERATION_NONE, 120, 300, 1},
    {"augmented", DLS_AUGMENTED_LAGRANGIAN, DLS_ACCELERATION_NONE, 12, 150, 1},
    {"penalty", DLS_PENALTY, DLS_ACCELERATION_NONE, 0, 150, 1},
    {"homotopy", DLS_HOMOTOPY, DLS_ACCELERATION_NONE, 60, 60, 1},
    {"lemke", DLS_LEMKE, DLS_ACCELERATION_NONE, 0, 60, 1},
    {"auto", DLS_AUTO, DLS_ACCELERATION_NONE, 300, 1000, 1},
    {"nlgs-2", DLS_NLGS, DLS_ACCELERATION_NONE, 20, 10000, 2},
    {"momentum-2", DLS_NLGS, DLS_ACCELERATION_MOMENTUM, 120, 10000, 2},
};
enum { method_runs = sizeof runs / sizeof runs[0] };

/* Solves, then with q of the next steps of a load path, from the answer of the step before. */
static void run_method(const dls_contact *p, int run, trail *t) {
  const int m = p->d * p->nc, steps = runs[run].threads > 1 || m > 150 ? 1 : 3;
  double *r = calloc((size_t)m + 1, sizeof *r), *u = calloc((size_t)m + 1, sizeof *u);
  double *q = calloc((size_t)m + 1, sizeof *q);
  ck_assert(r && u && q);
  dls_solver_settings s = settings_of(runs[run].method);
  s.acceleration = runs[run].acceleration;
  s.limits.tol = 1e-10;
  s.limits.max_iterations = runs[run].max_iterations;
  if (s.method == DLS_HOMOTOPY && m <= 12)
    s.limits.max_iterations = 1000; /* past its first start */
  s.limits.threads = runs[run].threads;
  s.limits.blocks = p->Wb.x ? p->Wb.p[p->nc] : 0;
  s.limits.warm_start = 1;
  s.limits.progress = trails_look;
  s.limits.progress_data = t;
  dls_contact a = *p;
  a.q = q;
  dls_solver *solver = NULL;
  dls_status status = dls_solver_create(&solver, p->d, p->nc, &s, NULL);
  for (int step = 0; step < steps && status >= 0; step++) {
    for (int i = 0; i < m; i++)
      q[i] = p->q[i] * (1 + .02 * step * (i % 3 - 1));
    dls_info info = {0};
    status = dls_solver_solve(solver, &a, r, u, &info, NULL);
    if (status < 0) break;
    trails_info(t, &info);
    trails_vector(t, r, m);
    trails_vector(t, u, m);
    trails_calls(t);
  }
  trails_count(t, (int)status);
  if (status >= 0 && dls_solver_direction(solver))
    trails_vector(t, dls_solver_direction(solver), m);
  if (status >= 0 && dls_solver_farkas(solver)) trails_vector(t, dls_solver_farkas(solver), p->nc);
  dls_solver_destroy(solver);
  free(r);
  free(u);
  free(q);
}

/* What is known of a problem without solving it, and of an answer. */
static void run_facts(const dls_contact *p, trail *t) {
  const int m = p->d * p->nc;
  dls_diagnosis g;
  ck_assert_int_eq(dls_contact_diagnose(p, 100, &g, NULL), DLS_OK);
  const dls_flaw *flaw[] = {&g.zero_block,     &g.no_weight, &g.no_normal,
                            &g.singular_block, &g.no_effect, &g.wedged};
  for (int k = 0; k < 6; k++) {
    trails_count(t, flaw[k]->count);
    trails_count(t, flaw[k]->first);
  }
  const int count[] = {g.closing, g.spectrum, g.rank, g.negative, g.critical, g.hints};
  for (int k = 0; k < 6; k++)
    trails_count(t, count[k]);
  trails_sum(t, g.weight_min / g.weight_max);
  trails_sum(t, g.asymmetry > 1e-12 ? g.asymmetry : 0);
  trails_sum(t, g.smallest_positive / g.largest);
  trails_sum(t, g.largest);
  trails_sum(t, g.friction_critical);
  trails_sum(t, g.friction_unique);
  double *r = calloc(8 * (size_t)m + 1, sizeof *r);
  ck_assert_ptr_nonnull(r);
  dls_solver_settings s = settings_of(DLS_AUTO);
  s.limits.tol = 1e-10;
  dls_info info;
  dls_sensitivity at = {0};
  if (dls_solve(p, &s, r, NULL, &info, NULL) == DLS_OK &&
      dls_contact_sensitivity(p, r, &at, NULL) == 0) {
    const int of[] = {at.rows, at.rank, at.border, at.isolated};
    for (int k = 0; k < 4; k++)
      trails_count(t, of[k]);
    trails_sum(t, at.amplification);
    trails_sum(t, at.amplification_r);
  }
  if (p->d == 2) {
    dls_fold fold = {0};
    const dls_status status =
        p->nc <= 12 ? dls_contact_fold(p, &fold, NULL, r, r + m, r + 2 * m, NULL) : 0;
    trails_count(t, (int)status);
    trails_count(t, fold.exact);
    trails_count(t, fold.matrices);
    trails_sum(t, fold.friction);
    for (int k = 0; k < 3; k++)
      trails_vector(t, r + k * m, m);
    if (p->nc <= 4) {
      double low[64], high[64];
      dls_solution_set found = {0};
      memset(r, 0, 8 * (size_t)m * sizeof *r);
      memset(low, 0, sizeof low);
      memset(high, 0, sizeof high);
      trails_count(t, (int)dls_contact_enumerate(p, 1e-8, 8, r, low, high, &found, NULL));
      trails_count(t, found.isolated);
      trails_count(t, found.continua);
      trails_count(t, found.states);
      for (int k = 0; k < 8; k++)
        trails_vector(t, r + k * m, m);
    }
  }
  free(r);
}

/* Eight problems that differ in q and in their units, at once. */
static void run_batch(const dls_contact *p, trail *t) {
  enum { lanes = 8 };
  const int m = p->d * p->nc;
  dls_contact a[lanes];
  double *r[lanes], *q[lanes];
  dls_info info[lanes];
  for (int k = 0; k < lanes; k++) {
    r[k] = calloc(2 * (size_t)m + 1, sizeof *r[k]);
    ck_assert_ptr_nonnull(r[k]);
    q[k] = r[k] + m;
    for (int i = 0; i < m; i++)
      q[k][i] = ldexp(p->q[i] * (1 + .1 * ((3 * i + k) % 7)), 5 * k % lanes * 6);
    a[k] = *p;
    a[k].q = q[k];
  }
  trails_count(t, (int)dls_solve_batch(lanes, a, NULL, r, NULL, info, NULL));
  for (int k = 0; k < lanes; k++) {
    trails_count(t, info[k].iterations);
    trails_count(t, info[k].stages);
    trails_vector(t, r[k], m);
    trails_sum(t, size_of_residual(info[k].certificate.residual));
    free(r[k]);
  }
}

static void put_lcp(trail *t, const dls_lcp *lcp) {
  const int n = lcp->n;
  double *z = calloc((size_t)n * 9, sizeof *z), *y = z + n;
  ck_assert_ptr_nonnull(z);
  for (int kind = 0; kind < 3; kind++) { /* cold; the path alone, cold, then warm */
    dls_lemke_settings s;
    dls_lemke_settings_init(&s);
    s.limits.tol = 1e-10;
    s.limits.warm_start = kind == 2;
    s.crash = kind != 1;
    s.limits.progress = trails_look;
    s.limits.progress_data = t;
    if (kind == 2)
      for (int i = 0; i < n; i += 3)
        z[i] = z[i] > 0 ? 0 : 1;
    dls_lemke *work;
    dls_lemke_info info = {0};
    ck_assert_int_eq(dls_lemke_create(&work, n, &s, NULL), DLS_OK);
    trails_count(t, (int)dls_lemke_solve(work, lcp, z, y, &info, NULL));
    trails_count(t, info.pivots);
    trails_count(t, info.starts);
    trails_count(t, info.refreshes);
    trails_count(t, info.crash_rounds);
    trails_vector(t, z, n);
    trails_vector(t, y, n);
    trails_sum(t, size_of_residual(info.certificate.residual));
    trails_calls(t);
    dls_lemke_destroy(work);
  }
  for (int kind = 0; kind < 2; kind++) {
    dls_principal_settings s;
    dls_principal_settings_init(&s);
    s.limits.tol = 1e-10;
    if (kind) s.block_steps = 1;
    dls_principal *work;
    dls_principal_info info = {0};
    ck_assert_int_eq(dls_principal_create(&work, n, &s, NULL), DLS_OK);
    trails_count(t, (int)dls_principal_solve(work, lcp, z, y, &info, NULL));
    trails_count(t, info.iterations);
    trails_count(t, info.single_exchanges);
    trails_count(t, info.factorizations);
    trails_vector(t, z, n);
    trails_sum(t, size_of_residual(info.certificate.residual));
    dls_principal_destroy(work);
  }
  if (n <= 9) {
    dls_enumeration found = {0};
    memset(z, 0, 9 * (size_t)n * sizeof *z);
    trails_count(t, (int)dls_lcp_enumerate(lcp, 1e-8, 9, z, &found, NULL));
    trails_count(t, found.solutions);
    trails_count(t, found.singular_bases);
    trails_count(t, found.continua);
    for (int k = 0; k < 9; k++)
      trails_vector(t, z + k * n, n);
  }
  free(z);
}

/* LCP(W, q), and the LCP of the friction. */
static void run_lcp(const dls_contact *p, trail *t) {
  if (p->W.a) put_lcp(t, &(dls_lcp){.n = p->d * p->nc, .M = p->W, .q = p->q});
  const int facets = 6;
  const int n = p->d == 3 ? dls_contact_facets_size(p, facets) : dls_contact_lcp_size(p);
  if (n < 1) return;
  double *M = calloc((size_t)n * (size_t)(n + 1), sizeof *M), *q = M + n * n;
  ck_assert_ptr_nonnull(M);
  const dls_status status = p->d == 3 ? dls_contact_to_facets_lcp(p, facets, NULL, M, n, q, NULL)
                                      : dls_contact_to_lcp(p, NULL, M, n, q, NULL);
  trails_count(t, (int)status);
  if (!status) put_lcp(t, &(dls_lcp){.n = n, .M = {n, n, n, M}, .q = q});
  free(M);
}

/* The exact solutions, or the least bad points, of a candidate alone; W and q disturbed. */
static void run_local(int number, unsigned *disturbance, trail *t) {
  unsigned seed = 77 + (unsigned)number;
  for (int k = 0; k < 30; k++) {
    const int d = 1 + (number + k) % 3;
    double W[9], q[3], r[3] = {0};
    for (int i = 0; i < d * d; i++) /* from definite to anything */
      W[i] = draw(&seed) * (i % (d + 1) ? 1 : 1.5) + (i % (d + 1) ? 0 : k % 5 * .5);
    for (int i = 0; i < d; i++) {
      for (int j = 0; j < i && number % 2; j++)
        W[i + d * j] = W[j + d * i];
      q[i] = draw(&seed);
    }
    if (k % 3) q[0] = -fabs(q[0]);
    const double mu = 1.5 + 1.5 * draw(&seed);
    for (int i = 0; i < d && disturbance; i++) {
      q[i] *= 1 + 1e-13 * draw(disturbance);
      W[i * (d + 1)] *= 1 + 1e-14 * draw(disturbance);
    }
    int count;
    trails_count(t, (int)dls_nlgs_local(d, W, q, mu, r, &count));
    trails_count(t, count);
    trails_vector(t, r, d);
    trails_sum(t, norm_of(r, d));
  }
}

/* After the runs of the methods: */
enum { facts = method_runs, batch, lcps, problem_runs };

static const char *trails_name(int run) {
  return run < method_runs ? runs[run].name
         : run == facts    ? "facts"
         : run == batch    ? "batch"
                           : "lcp";
}

/* Returns 1 if the run of a problem is worth its time. */
static int trails_has(const dls_contact *p, int run) {
  const int m = p->d * p->nc;
  if (run == facts) return m <= 100;
  if (run == batch) return p->nc <= 8;
  if (run == lcps) return m <= 45 && dls_contact_check(p, NULL) == DLS_OK;
  return m <= runs[run].most_rows && (runs[run].threads == 1 || p->nc > 1000);
}

static void trails_run(const dls_contact *p, int run, trail *t) {
  memset(t, 0, sizeof *t);
  if (run < method_runs)
    run_method(p, run, t);
  else if (run == facts)
    run_facts(p, t);
  else if (run == batch)
    run_batch(p, t);
  else
    run_lcp(p, t);
}

/* ---- figures --------------------------------------------------------------------------------- */

/* Writes the figures of t, - for those that differ from another one of `others`. */
static void trails_print(FILE *out, const trail *t, const trail *others, int n) {
  int same = 1;
  for (int k = 0; k < n; k++)
    same &= others[k].counts == t->counts && others[k].sums == t->sums;
  if (!same) {
    fprintf(out, " -\n");
    return;
  }
  for (int i = 0; i < t->counts; i++) {
    same = 1;
    for (int k = 0; k < n; k++)
      same &= others[k].count[i] == t->count[i];
    if (same)
      fprintf(out, " %d", t->count[i]);
    else
      fprintf(out, " -");
  }
  fprintf(out, " :");
  for (int i = 0; i < t->sums; i++) {
    same = 1;
    for (int k = 0; k < n; k++)
      same &= fabs(others[k].sum[i] - t->sum[i]) <= .01 * sum_tol * fmax(1, fabs(t->sum[i]));
    if (same)
      fprintf(out, " %.8g", t->sum[i]);
    else
      fprintf(out, " -");
  }
  fprintf(out, "\n");
}

/* Compares t with the figures of the file's next line. */
static void trails_compare(const trail *t, FILE *file, const char *name, const char *run) {
  static char line[16000];
  do
    ck_assert_ptr_nonnull(fgets(line, sizeof line, file));
  while (line[0] == '#');
  if (!t) return;
  char *save, *word = strtok_r(line, " \n", &save);
  ck_assert_str_eq(word, name);
  word = strtok_r(NULL, " \n", &save);
  ck_assert_str_eq(word, run);
  for (int i = 0; i < t->counts + 1 + t->sums; i++) {
    word = strtok_r(NULL, " \n", &save);
    ck_assert_msg(word != NULL, "%s, %s: more than %d figures", name, run, i);
    if (strcmp(word, "-") == 0) {
      if (i > 0 || *save) continue;
      return;
    }
    if (i < t->counts) {
      ck_assert_msg(atoi(word) == t->count[i], "%s, %s: count %d is %d, not %s", name, run, i,
                    t->count[i], word);
    } else if (i == t->counts) {
      ck_assert_msg(strcmp(word, ":") == 0, "%s, %s: %s is no :", name, run, word);
    } else {
      const double is = t->sum[i - t->counts - 1], wanted = strtod(word, NULL);
      ck_assert_msg(fabs(is - wanted) <= sum_tol * fmax(1, fabs(wanted)),
                    "%s, %s: sum %d is %.9g, not %.9g", name, run, i - t->counts - 1, is, wanted);
    }
  }
  ck_assert_msg(strtok_r(NULL, " \n", &save) == NULL, "%s, %s: fewer figures", name, run);
}

/* Returns 1 + rounding, the same for row, col and col, row. */
static double rounding_of(int row, int col, unsigned seed) {
  const unsigned low = (unsigned)(row < col ? row : col), high = (unsigned)(row < col ? col : row);
  unsigned own = seed ^ (low * 7919u + high * 104729u);
  (void)draw(&own);
  return 1 + 2e-14 * draw(&own);
}

/* Returns p with W and q disturbed by rounding, as symmetric, in other units. storage: takes
 * its arrays, which the caller frees. */
static dls_contact trails_disturbed(const dls_contact *p, double *storage[2], unsigned *seed) {
  dls_contact a = *p;
  const int d = p->d, m = d * p->nc;
  const dls_blocks *B = &p->Wb;
  const double unit = 1.5 + draw(seed) / 2;
  double *q = storage[0] = malloc((size_t)m * sizeof *q);
  ck_assert_ptr_nonnull(q);
  for (int i = 0; i < m; i++)
    q[i] = p->q[i] * (1 + 2e-12 * draw(seed));
  a.q = q;
  const int rows = p->bodies.H ? 2 * p->bodies.n : p->W.ld;
  const int entries = B->x ? d * d * B->p[p->nc] : rows * m;
  double *x = storage[1] = malloc((size_t)entries * sizeof *x);
  ck_assert_ptr_nonnull(x);
  for (int k = 0; k < entries && p->bodies.H; k++)
    x[k] = unit * p->bodies.H[k] * rounding_of(0, k, *seed);
  for (int k = 0; k < entries && p->W.a; k++)
    x[k] = unit * p->W.a[k] * rounding_of(k % rows, k / rows, *seed);
  for (int c = 0; c < p->nc && B->x; c++)
    for (int k = B->p[c]; k < B->p[c + 1]; k++)
      for (int e = 0; e < d * d; e++)
        x[d * d * k + e] =
            unit * B->x[d * d * k + e] * rounding_of(d * B->i[k] + e % d, d * c + e / d, *seed);
  if (p->bodies.H) a.bodies.H = x;
  if (p->W.a) a.W.a = x;
  if (B->x) a.Wb.x = x;
  return a;
}

enum { local_lines = 30, others = 16 };

START_TEST(print_trails) {
  FILE *out = fopen(trails_file, "w");
  ck_assert_ptr_nonnull(out);
  static trails_problem a;
  static trail t, other[others];
  unsigned seed = 5;
  for (int k = 0; trails_make(k, &a); k++) {
    for (int run = 0; run < problem_runs; run++) {
      if (!trails_has(&a.p, run)) continue;
      trails_run(&a.p, run, &t);
      for (int j = 0; j < others; j++) {
        double *storage[2];
        const dls_contact p = trails_disturbed(&a.p, storage, &seed);
        trails_run(&p, run, &other[j]);
        free(storage[0]);
        free(storage[1]);
      }
      fprintf(out, "%s %s", a.name, trails_name(run));
      trails_print(out, &t, other, others);
    }
    trails_free(&a);
  }
  for (int k = 0; k < local_lines; k++) {
    memset(&t, 0, sizeof t);
    memset(other, 0, sizeof other);
    run_local(k, NULL, &t);
    for (int j = 0; j < others; j++)
      run_local(k, &seed, &other[j]);
    fprintf(out, "local %d", k);
    trails_print(out, &t, other, others);
  }
  ck_assert_int_eq(fclose(out), 0);
}
END_TEST

/* All runs of a fourth of the problems. */
enum { shares = 4 };
START_TEST(trails_are_those_of_the_file) {
  static trails_problem a;
  static trail t;
  FILE *file = fopen(trails_file, "r");
  ck_assert_ptr_nonnull(file);
  for (int k = 0; trails_make(k, &a); k++) {
    for (int run = 0; run < problem_runs; run++) {
      if (!trails_has(&a.p, run)) continue;
      const int mine = k % shares == _i;
      if (mine) trails_run(&a.p, run, &t);
      trails_compare(mine ? &t : NULL, file, a.name, trails_name(run));
    }
    trails_free(&a);
  }
  for (int k = 0; k < local_lines; k++) {
    char number[12];
    (void)snprintf(number, sizeof number, "%d", k);
    memset(&t, 0, sizeof t);
    run_local(k, NULL, &t);
    trails_compare(_i == 0 ? &t : NULL, file, "local", number);
  }
  ck_assert_int_eq(fgetc(file), EOF);
  (void)fclose(file);
}
END_TEST

int main(int argc, char **argv) {
  if (argc > 1 && strcmp(argv[1], "print") == 0)
    return RUN("trails", NULL, NULL, ONCE(print_trails));
  return RUN("trails", NULL, NULL, EACH(trails_are_those_of_the_file, 0, shares));
}
