/* trails_runs.c: the runs of trails.h. */
#include "auto/auto.h"
#include "cases.h"
#include "front_cases.h"
#include "run.h"
#include "trails.h"
#include "vi/vi_internal.h"

/* ---- what a run leaves ----------------------------------------------------------------------- */

static void trails_count(trail *t, int x) {
  ck_assert_int_lt(t->counts, trails_counts);
  t->count[t->counts++] = x;
}

static void trails_sum(trail *t, double x) {
  ck_assert_int_lt(t->sums, trails_sums);
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
  ck_assert_int_lt(t->solves, trails_solves);
  char letter = 'e';
  for (int k = 0; k < statuses; k++)
    if (ranks[k].status == status) letter = ranks[k].letter;
  t->status[t->solves++] = letter;
}

int trails_rank(char letter) {
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
    {"auto", DLS_AUTO, DLS_ACCELERATION_NONE, 3000, 1000, 1},
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

void trails_facts(const dls_contact *p, trail *t) {
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

void trails_local(int number, unsigned *disturbance, trail *t) {
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
    trails_count(t, (int)dlsi_nlgs_local(d, W, q, mu, r, &count));
    trails_count(t, count);
    trails_vector(t, r, d);
    trails_sum(t, norm_of(r, d));
  }
}

/* After the runs of the methods: */
enum { batch = method_runs, lcps, all_runs };
_Static_assert((int)all_runs == (int)trails_runs, "trails.h counts them");

const char *trails_name(int run) {
  return run < method_runs ? runs[run].name : run == batch ? "batch" : "lcp";
}

int trails_has_facts(const dls_contact *p) {
  return p->d * p->nc <= 100;
}

int trails_has(const dls_contact *p, int run) {
  const int m = p->d * p->nc;
  if (run == batch) return p->nc <= 8;
  if (run == lcps) return m <= 45 && dls_contact_check(p, NULL) == DLS_OK;
  return m <= runs[run].most_rows && (runs[run].threads == 1 || p->nc > 1000);
}

void trails_run(const dls_contact *p, int run, trail *t) {
  memset(t, 0, sizeof *t);
  if (run < method_runs)
    run_method(p, run, t);
  else if (run == batch)
    run_batch(p, t);
  else
    run_lcp(p, t);
}
