/*
 * test_trails.c: how the methods go on problems of many kinds, beside how they went: trails.txt has
 * a line for each problem. A change of a constant, a sign or an order in a method shows there,
 * where a test of its answer alone would pass. Another trail is no defect; a worse one is:
 *
 *   worse    a run ends with a worse status, or with the same one for more than 5/4 of the cost of
 *            the file and 20 sweeps
 *   better   none is worse, and one is better by as much
 *   other    neither, but statuses, steps, iterations or stages are not those of the file
 *
 * It counts them, with all costs before and after, and fails on worse. The cost of a run: that of
 * its iterations in sweeps by the one model of auto (src/auto/price.c), as if all candidates stuck;
 * other prices need the file anew.
 *
 *   build/tests/tuning/test_trails print
 *
 * writes the file. It solves each problem again with W and q disturbed by rounding: what does not
 * survive that would differ between processors, too. The line of a problem:
 *
 *   NAME HASH SWEEPS/FACTORISATIONS/STEPS FACTS RUN ..
 *   HASH   of all counts of the runs without ~
 *   FACTS  HASH[/MASK]: of what is known without solving; mask: hexadecimal, a bit for each figure
 *   RUN    STATUSES:COST[<LARGEST][~], or . for none; statuses: a letter for each solve, - where
 *          rounding decides; largest cost with rounding; ~: rounding changes counts
 */
#include <check.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "auto/auto.h"
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

enum { most_counts = 400, most_sums = 120, most_solves = 24 };
typedef struct trail {
  int counts, sums, solves, calls;
  int count[most_counts];
  double sum[most_sums];        /* of facts */
  char status[most_solves + 1]; /* a letter for each solve */
  double sweeps, factorisations, steps, cost;
} trail;

static const char trails_file[] = TEST_DATA "/../tests/tuning/trails.txt";

static void trails_count(trail *t, int x) {
  ck_assert_int_lt(t->counts, most_counts);
  t->count[t->counts++] = x;
}

static void trails_sum(trail *t, double x) {
  ck_assert_int_lt(t->sums, most_sums);
  t->sum[t->sums++] = isfinite(x) ? x : 1e9;
}

/* Puts a weighted sum of the x_i over their size. */
static void trails_vector(trail *t, const double *x, int n) {
  double sum = 0;
  for (int i = 0; i < n; i++)
    sum += (1 + fmod(.6180339887498949 * (i + 1), 1)) * x[i];
  const double size = norm_of(x, n);
  trails_sum(t, size > 0 ? sum / size : 0);
}

/* Letters of statuses from the best on: two of one rank are as good as each other only if they are
 * the same. */
static const struct {
  dls_status status;
  char letter;
  int rank;
} ranks[] = {{DLS_OK, 'o', 0},
             {DLS_NO_SOLUTION, 'n', 0},
             {DLS_TO_ROUNDING, 'r', 1},
             {DLS_NO_SOLUTION_LIKELY, 'l', 2},
             {DLS_MAX_ITERATIONS, 'm', 3},
             {DLS_STALLED, 's', 3},
             {DLS_RAY, 'y', 3}};
enum { statuses = sizeof ranks / sizeof ranks[0] };

static void trails_status(trail *t, dls_status status) {
  ck_assert_int_lt(t->solves, most_solves);
  char letter = 'e';
  for (int k = 0; k < statuses; k++)
    if (ranks[k].status == status) letter = ranks[k].letter;
  t->status[t->solves++] = letter;
}

static int rank_of(char letter) {
  for (int k = 0; k < statuses; k++)
    if (ranks[k].letter == letter) return ranks[k].rank;
  return 4;
}

static int trails_look(void *data, const dls_progress *progress) {
  trail *t = data;
  t->calls += !progress->last;
  return 0;
}

/* Adds what a method, or a stage of auto, has taken. */
static void trails_stage(trail *t, const dls_contact *p, const dls_stage *stage) {
  const int sweeps = stage->method == DLS_NLGS;
  *(sweeps ? &t->sweeps : &t->steps) += stage->iterations;
  t->factorisations += stage->factorisations;
  t->cost += dlsi_auto_price_of(p, p->d * p->nc, stage);
}

static void trails_info(trail *t, const dls_contact *p, const dls_info *info) {
  trails_status(t, info->status);
  trails_count(t, (int)info->status);
  trails_count(t, info->iterations);
  trails_count(t, info->factorisations);
  trails_count(t, info->sweeps);
  trails_count(t, info->ambiguous);
  trails_count(t, (int)info->unique);
  t->sweeps += info->sweeps;
  t->cost += info->sweeps; /* of Newton's method, before its steps */
  for (int k = 0; k < info->stages; k++) {
    trails_count(t, (int)info->stage[k].method);
    trails_count(t, info->stage[k].factorisations);
    trails_count(t, info->stage[k].iterations);
    trails_stage(t, p, &info->stage[k]);
  }
  if (info->method != DLS_AUTO)
    trails_stage(t, p,
                 &(dls_stage){.method = info->method,
                              .iterations = info->iterations,
                              .factorisations = info->factorisations});
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
  const int m = p->d * p->nc, solves = runs[run].threads > 1 || m > 150 ? 1 : 3;
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
  for (int k = 0; k < solves && status >= 0; k++) {
    for (int i = 0; i < m; i++)
      q[i] = p->q[i] * (1 + .02 * k * (i % 3 - 1));
    dls_info info = {0};
    status = dls_solver_solve(solver, &a, r, u, &info, NULL);
    if (status < 0) break;
    trails_info(t, &a, &info);
    trails_count(t, t->calls);
  }
  trails_status(t, status); /* with an error, of create or solve */
  dls_solver_destroy(solver);
  free(r);
  free(u);
  free(q);
}

/* What is known of a problem without solving it. */
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
  const dls_status status = dls_solve_batch(lanes, a, NULL, r, NULL, info, NULL);
  trails_status(t, status < 0 ? status : DLS_OK);
  for (int k = 0; k < lanes; k++) {
    if (status >= 0) trails_info(t, p, &info[k]);
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
    trails_status(t, dls_lemke_solve(work, lcp, z, y, &info, NULL));
    t->steps += info.pivots;
    t->cost += info.pivots;
    trails_count(t, info.pivots);
    trails_count(t, info.starts);
    trails_count(t, info.refreshes);
    trails_count(t, info.crash_rounds);
    trails_count(t, t->calls);
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
    trails_status(t, dls_principal_solve(work, lcp, z, y, &info, NULL));
    t->steps += info.iterations;
    t->factorisations += info.factorizations;
    t->cost += info.factorizations;
    trails_count(t, info.iterations);
    trails_count(t, info.single_exchanges);
    trails_count(t, info.factorizations);
    dls_principal_destroy(work);
  }
  free(z);
}

/* LCP(W, q), and the LCP of the friction; costs in pivots and factorisations. */
static void run_lcp(const dls_contact *p, trail *t) {
  if (p->W.a) put_lcp(t, &(dls_lcp){.n = p->d * p->nc, .M = p->W, .q = p->q});
  const int facets = 6;
  const int n = p->d == 3 ? dls_contact_facets_size(p, facets) : dls_contact_lcp_size(p);
  if (n < 1) return;
  double *M = calloc((size_t)n * (size_t)(n + 1), sizeof *M), *q = M + n * n;
  ck_assert_ptr_nonnull(M);
  const dls_status status = p->d == 3 ? dls_contact_to_facets_lcp(p, facets, NULL, M, n, q, NULL)
                                      : dls_contact_to_lcp(p, NULL, M, n, q, NULL);
  trails_status(t, status);
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
enum { batch = method_runs, lcps, problem_runs };

static const char *trails_name(int run) {
  return run < method_runs ? runs[run].name : run == batch ? "batch" : "lcp";
}

static int has_facts(const dls_contact *p) {
  return p->d * p->nc <= 100;
}

/* Returns 1 if the run of a problem is worth its time. */
static int trails_has(const dls_contact *p, int run) {
  const int m = p->d * p->nc;
  if (run == batch) return p->nc <= 8;
  if (run == lcps) return m <= 45 && dls_contact_check(p, NULL) == DLS_OK;
  return m <= runs[run].most_rows && (runs[run].threads == 1 || p->nc > 1000);
}

static void trails_run(const dls_contact *p, int run, trail *t) {
  memset(t, 0, sizeof *t);
  if (run < method_runs)
    run_method(p, run, t);
  else if (run == batch)
    run_batch(p, t);
  else
    run_lcp(p, t);
}

/* ---- disturbed by rounding ------------------------------------------------------------------- */

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

/* ---- hashes ---------------------------------------------------------------------------------- */

/* FNV-1a. */
static unsigned trails_hash(unsigned hash, long long x) {
  for (int k = 0; k < 8; k++)
    hash = (hash ^ (unsigned)((unsigned long long)x >> 8 * k & 255)) * 16777619u;
  return hash;
}

static const unsigned hash_start = 2166136261u;

static unsigned hash_counts(unsigned hash, const trail *t) {
  for (int i = 0; i < t->counts; i++)
    hash = trails_hash(hash, t->count[i]);
  for (int i = 0; i < t->solves; i++)
    hash = trails_hash(hash, t->status[i]);
  return hash;
}

/* Returns the digits of a sum that a hash sees: 1e-4 of max(1, |x|). */
static double digits_of(double x) {
  return 1e4 * asinh(x);
}

/* Returns figure i of the facts t as a whole number. */
static long long fact_of(const trail *t, int i) {
  return i < t->counts ? t->count[i] : llround(digits_of(t->sum[i - t->counts]));
}

/* Returns 1 if figure i of the facts is the same with rounding. */
static int fact_stands(const trail *t, int i, const trail *others, int n) {
  const double x = i < t->counts ? 0 : digits_of(t->sum[i - t->counts]);
  if (fabs(x - floor(x) - .5) < .05) return 0; /* between two whole numbers */
  for (int k = 0; k < n; k++)
    if (fact_of(&others[k], i) != fact_of(t, i)) return 0;
  return 1;
}

enum { most_facts = most_counts + most_sums };

/* stands[i] := 1 for the figures of a mask, hexadecimal, of n figures; all without one. */
static void read_mask(const char *mask, int n, int stands[most_facts]) {
  for (int i = 0; i < n; i++) {
    char digit[2] = {mask ? mask[i / 4] : 'f', 0};
    stands[i] = (int)(strtol(digit, NULL, 16) >> i % 4 & 1);
  }
}

static unsigned hash_facts(const trail *t, const int *stands) {
  unsigned hash = trails_hash(trails_hash(hash_start, t->counts), t->sums);
  for (int i = 0; i < t->counts + t->sums; i++)
    if (stands[i]) hash = trails_hash(hash, fact_of(t, i));
  return hash;
}

/* Writes HASH[/MASK], or . where rounding changes how many figures there are. */
static void print_facts(FILE *out, const trail *t, const trail *others, int n) {
  const int all = t->counts + t->sums;
  int stands[most_facts] = {0}, whole = 1;
  for (int k = 0; k < n; k++)
    if (others[k].counts != t->counts || others[k].sums != t->sums) {
      fprintf(out, " .");
      return;
    }
  for (int i = 0; i < all; i++)
    whole &= stands[i] = fact_stands(t, i, others, n);
  fprintf(out, " %08x", hash_facts(t, stands));
  for (int i = 0; i < all && !whole; i += 4) {
    int digit = 0;
    for (int j = i; j < i + 4 && j < all; j++)
      digit |= stands[j] << (j - i);
    fprintf(out, "%s%x", i ? "" : "/", (unsigned)digit);
  }
}

/* Fails where a fact is not that of the file. */
static void compare_facts(const trail *t, const char *token, const char *name) {
  if (strcmp(token, ".") == 0) return;
  const char *slash = strchr(token, '/');
  int stands[most_facts] = {0};
  if (slash) ck_assert_int_eq((int)strlen(slash + 1), (t->counts + t->sums + 3) / 4);
  read_mask(slash ? slash + 1 : NULL, t->counts + t->sums, stands);
  ck_assert_msg(hash_facts(t, stands) == strtoul(token, NULL, 16),
                "%s: other facts than in the file", name);
}

/* ---- the file -------------------------------------------------------------------------------- */

/* What the file says of a run. */
typedef struct record {
  char status[most_solves + 1];
  double cost, largest;
  int floats; /* rounding changes counts */
} record;

static void record_make(record *a, const trail *t, const trail *others, int n) {
  memset(a, 0, sizeof *a);
  memcpy(a->status, t->status, sizeof a->status);
  a->cost = a->largest = ceil(t->cost);
  for (int k = 0; k < n; k++) {
    a->largest = fmax(a->largest, ceil(others[k].cost));
    a->floats |= hash_counts(hash_start, &others[k]) != hash_counts(hash_start, t);
    for (int i = 0; i < t->solves; i++)
      if (others[k].status[i] != t->status[i]) a->status[i] = '-';
  }
}

static void record_print(FILE *out, const record *a) {
  fprintf(out, " %s:%.0f", a->status, a->cost);
  if (a->largest > a->cost) fprintf(out, "<%.0f", a->largest);
  if (a->floats) fprintf(out, "~");
}

static void record_read(record *a, const char *token) {
  memset(a, 0, sizeof *a);
  const char *colon = strchr(token, ':');
  ck_assert(colon && colon - token <= most_solves);
  memcpy(a->status, token, (size_t)(colon - token));
  char *end;
  a->cost = a->largest = strtod(colon + 1, &end);
  if (*end == '<') a->largest = strtod(end + 1, &end);
  if (*end == '~') a->floats = *end++ == '~';
  ck_assert_int_eq(*end, 0);
}

/* Returns 1 where the run is better than the record, -1 where it is worse. */
static int record_judge(const record *a, const trail *t) {
  int better = 0;
  if (strlen(a->status) != strlen(t->status)) return -1;
  for (int i = 0; a->status[i]; i++) {
    if (a->status[i] == '-' || a->status[i] == t->status[i]) continue;
    const int was = rank_of(a->status[i]), is = rank_of(t->status[i]);
    if (is > was || (is == was && is == 0)) return -1;
    better |= is < was;
  }
  if (better) return 1;
  if (t->cost > 1.25 * a->largest + 20) return -1;
  return t->cost < a->cost / 1.25 - 20;
}

typedef struct totals {
  double sweeps, factorisations, steps, cost;
} totals;

static void totals_add(totals *a, const trail *t) {
  a->sweeps += t->sweeps;
  a->factorisations += t->factorisations;
  a->steps += t->steps;
  a->cost += ceil(t->cost);
}

enum { local_lines = 30, others = 16 };

/* Runs p, and n problems that differ from it by rounding. run < 0: the facts. */
static void run_disturbed(const dls_contact *p, int run, trail *t, trail *other, int n) {
  static unsigned seed = 5;
  for (int j = -1; j < n; j++) {
    double *storage[2] = {NULL, NULL};
    const dls_contact a = j < 0 ? *p : trails_disturbed(p, storage, &seed);
    trail *const to = j < 0 ? t : &other[j];
    memset(to, 0, sizeof *to);
    if (run < 0)
      run_facts(&a, to);
    else
      trails_run(&a, run, to);
    free(storage[0]);
    free(storage[1]);
  }
}

static void print_problem(FILE *out, const trails_problem *a) {
  static trail t, other[others];
  static record of[problem_runs];
  unsigned hash = hash_start;
  totals all = {0, 0, 0, 0};
  for (int run = 0; run < problem_runs; run++) {
    if (!trails_has(&a->p, run)) continue;
    run_disturbed(&a->p, run, &t, other, others);
    record_make(&of[run], &t, other, others);
    if (!of[run].floats) hash = hash_counts(hash, &t);
    totals_add(&all, &t);
  }
  fprintf(out, "%s %08x %.0f/%.0f/%.0f", a->name, hash, all.sweeps, all.factorisations, all.steps);
  if (has_facts(&a->p)) {
    run_disturbed(&a->p, -1, &t, other, others);
    print_facts(out, &t, other, others);
  } else {
    fprintf(out, " .");
  }
  for (int run = 0; run < problem_runs; run++)
    if (trails_has(&a->p, run))
      record_print(out, &of[run]);
    else
      fprintf(out, " .");
  fprintf(out, "\n");
}

START_TEST(print_trails) {
  FILE *out = fopen(trails_file, "w");
  ck_assert_ptr_nonnull(out);
  static trails_problem a;
  static trail t, other[others];
  unsigned seed = 5;
  fprintf(out,
          "# test_trails.c says what stands here: name hash sweeps/factorisations/steps facts");
  for (int run = 0; run < problem_runs; run++)
    fprintf(out, " %s", trails_name(run));
  fprintf(out, "\n");
  for (int k = 0; trails_make(k, &a); k++) {
    print_problem(out, &a);
    trails_free(&a);
  }
  for (int k = 0; k < local_lines; k++) {
    memset(&t, 0, sizeof t);
    memset(other, 0, sizeof other);
    run_local(k, NULL, &t);
    for (int j = 0; j < others; j++)
      run_local(k, &seed, &other[j]);
    fprintf(out, "local-%d", k);
    print_facts(out, &t, other, others);
    fprintf(out, "\n");
  }
  ck_assert_int_eq(fclose(out), 0);
}
END_TEST

/* ---- the comparison -------------------------------------------------------------------------- */

typedef struct tally {
  int same, other, better, worse;
  totals before, after;
} tally;

/* Reads the next line; save: where its words begin. */
static void next_line(FILE *file, const char *name, char **save) {
  static char line[4000];
  do
    ck_assert_ptr_nonnull(fgets(line, sizeof line, file));
  while (line[0] == '#');
  ck_assert_str_eq(strtok_r(line, " \n", save), name);
}

static const char *next_word(char **save) {
  const char *word = strtok_r(NULL, " \n", save);
  ck_assert_ptr_nonnull(word);
  return word;
}

/* Returns how run `run` went beside the file: 1, 0, -1, as record_judge; says so if not 0. */
static int compare_run(const trails_problem *a, int run, const char *token, tally *all,
                       unsigned *hash) {
  static trail t;
  record was;
  record_read(&was, token);
  run_disturbed(&a->p, run, &t, NULL, 0);
  if (!was.floats) *hash = hash_counts(*hash, &t);
  totals_add(&all->after, &t);
  all->before.cost += was.cost;
  const int judged = record_judge(&was, &t);
  if (judged)
    printf("%s: %s, %s: %s:%.0f, in the file %s\n", judged < 0 ? "worse" : "better", a->name,
           trails_name(run), t.status, ceil(t.cost), token);
  return judged;
}

static void compare_problem(const trails_problem *a, FILE *file, tally *all) {
  static trail t;
  char *save;
  next_line(file, a->name, &save);
  const unsigned was = (unsigned)strtoul(next_word(&save), NULL, 16);
  unsigned hash = hash_start;
  totals before;
  ck_assert_int_eq(sscanf(next_word(&save), "%lf/%lf/%lf", &before.sweeps, &before.factorisations,
                          &before.steps),
                   3);
  all->before.sweeps += before.sweeps;
  all->before.factorisations += before.factorisations;
  all->before.steps += before.steps;
  const char *word = next_word(&save);
  if (has_facts(&a->p)) {
    run_disturbed(&a->p, -1, &t, NULL, 0);
    compare_facts(&t, word, a->name);
  }
  int better = 0, worse = 0;
  for (int run = 0; run < problem_runs; run++) {
    word = next_word(&save);
    ck_assert_int_eq(trails_has(&a->p, run), strcmp(word, ".") != 0);
    if (strcmp(word, ".") == 0) continue;
    const int judged = compare_run(a, run, word, all, &hash);
    better |= judged > 0;
    worse |= judged < 0;
  }
  ck_assert_ptr_null(strtok_r(NULL, " \n", &save));
  ++*(worse ? &all->worse : better ? &all->better : hash != was ? &all->other : &all->same);
}

START_TEST(trails_are_no_worse_than_those_of_the_file) {
  static trails_problem a;
  static trail t;
  static tally all;
  FILE *file = fopen(trails_file, "r");
  ck_assert_ptr_nonnull(file);
  for (int k = 0; trails_make(k, &a); k++) {
    compare_problem(&a, file, &all);
    trails_free(&a);
  }
  for (int k = 0; k < local_lines; k++) {
    char name[20], *save;
    (void)snprintf(name, sizeof name, "local-%d", k);
    memset(&t, 0, sizeof t);
    run_local(k, NULL, &t);
    next_line(file, name, &save);
    compare_facts(&t, next_word(&save), name);
  }
  ck_assert_int_eq(fgetc(file), EOF);
  (void)fclose(file);
  const totals *b = &all.before, *c = &all.after;
  printf("trails: %d same, %d other, %d better, %d worse\n"
         "before: cost %.0f, %.0f sweeps, %.0f factorisations, %.0f steps\n"
         "after:  cost %.0f, %.0f sweeps, %.0f factorisations, %.0f steps\n",
         all.same, all.other, all.better, all.worse, b->cost, b->sweeps, b->factorisations,
         b->steps, c->cost, c->sweeps, c->factorisations, c->steps);
  (void)fflush(stdout); /* a failure ends this process */
  ck_assert_msg(all.worse == 0, "%d problems are worse than in the file", all.worse);
}
END_TEST

int main(int argc, char **argv) {
  if (argc > 1 && strcmp(argv[1], "print") == 0)
    return RUN("trails", NULL, NULL, ONCE(print_trails));
  return RUN("trails", NULL, NULL, ONCE(trails_are_no_worse_than_those_of_the_file));
}
