/*
 * auto_price.c: the cost of a step of each method in accelerated sweeps, measured, and as auto
 * assumes it in dlsi_auto_price_of (src/auto/price.c).
 *
 * A run is a whole solve from r = 0 with a limit of iterations, on existing workspaces: CPU of the
 * thread, the least of several. Its cost is that over the CPU of a sweep. The first sweeps of
 * Newton's method are subtracted, so that two steps or fewer show nothing. The unknowns are those
 * of the answer, or of the best r.
 *
 * A cost is wrong if both differ by more than a factor of 2; those of a method if more than 10 % of
 * them are wrong, rounded up: a shared machine is off by a third at times. Plain sweeps are
 * measured alone.
 */
#include "auto_price.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "auto/auto.h"
#include "common.h"
#include "delassus.h"
#include "regret_kinds.h"

/* Up to `rows` rows. */
static const struct {
  const char *name;
  dls_method method;
  dls_acceleration acceleration;
  int most, rows;
} runs[] = {{"sweep, accelerated", DLS_NLGS, DLS_ACCELERATION_ANDERSON, 50, 4000},
            {"sweep", DLS_NLGS, DLS_ACCELERATION_NONE, 50, 4000},
            {"sweep, momentum", DLS_NLGS, DLS_ACCELERATION_MOMENTUM, 50, 4000},
            {"newton", DLS_NEWTON, DLS_ACCELERATION_NONE, 8, 4000},
            {"admm", DLS_ADMM, DLS_ACCELERATION_NONE, 50, 1000},
            {"augmented Lagrangian", DLS_AUGMENTED_LAGRANGIAN, DLS_ACCELERATION_NONE, 3, 1000},
            {"homotopy", DLS_HOMOTOPY, DLS_ACCELERATION_NONE, 10, 300},
            {"lemke", DLS_LEMKE, DLS_ACCELERATION_NONE, 0, 100}};
enum { methods = sizeof runs / sizeof runs[0] };

static const char *const kinds[] = {"gears",      "poly2-rest", "wall-pushed", "dome",
                                    "balls-flow", "ell3-rest",  "ill2",        "block2",
                                    "ill3",       "rough3",     "cube.49"};
enum { kind_count = sizeof kinds / sizeof kinds[0] };
static const int sizes[] = {30, 100, 300, 1000};
enum { size_count = sizeof sizes / sizeof sizes[0], most_rows = kind_count * size_count };
enum { least_steps = 3 };

/* Of a method. */
typedef struct tally {
  int count, wrong;
  double ratio[most_rows]; /* measured over assumed */
} tally;

/* Returns the least CPU of a run, s; INFINITY where it does not run. */
static double time_run(const dls_contact *p, int run, double *r, dls_info *info) {
  dls_solver_settings s;
  dls_solver *solver;
  dls_solver_settings_init(&s);
  s.method = runs[run].method;
  s.acceleration = runs[run].acceleration;
  s.limits.tol = 1e-12;
  s.limits.max_iterations = runs[run].most;
  s.limits.blocks = p->Wb.x ? p->Wb.p[p->nc] : 0;
  s.limits.cpu_seconds = 10;
  if (dls_solver_create(&solver, p->d, p->nc, &s, NULL)) return INFINITY;
  bench_clock c = {0};
  dls_status status = DLS_OK;
  while (status >= 0 && status != DLS_TIME_LIMIT && bench_runs(&c, 3, 40, .1))
    status = dls_solver_solve(solver, p, r, NULL, info, NULL);
  dls_solver_destroy(solver);
  return status < 0 || status == DLS_TIME_LIMIT ? INFINITY : c.least;
}

/* Returns the unknowns of an answer. */
static double unknowns_of(const dls_contact *p, double *r) {
  dls_solver_settings s;
  dls_solver_settings_init(&s);
  s.limits.cpu_seconds = 5;
  if (dls_solve(p, &s, r, NULL, NULL, NULL) < 0) exit(1);
  return dlsi_auto_count_unknowns(p, r);
}

static void price_problem(const char *kind, const dls_contact *p, tally *all) {
  const int m = p->d * p->nc;
  double *r = calloc((size_t)m, sizeof *r), sweep = 0, plain = 1;
  if (!r) exit(1);
  const double k = unknowns_of(p, r);
  bench_print(NULL, "| %s | %s | %d | %d | %.0f |", kind, p->W.a ? "dense" : "blocks", p->d, p->nc,
              k);
  for (int run = 0; run < methods; run++) {
    dls_info info = {0};
    const double seconds = m <= runs[run].rows ? time_run(p, run, r, &info) : INFINITY;
    if (run == 0) sweep = seconds / info.iterations;
    if (run == 0) bench_print(NULL, " %.3g |", 1e6 * sweep);
    if (run == 0) continue;
    if (!(seconds < INFINITY) || info.iterations < least_steps) {
      bench_print(NULL, " |");
      continue;
    }
    const dls_stage stage = {.method = info.method,
                             .iterations = info.iterations,
                             .factorisations = info.factorisations};
    const double steps = info.iterations, assumed = dlsi_auto_price_of(p, k, &stage) / steps;
    const double measured = (seconds / sweep - plain * info.sweeps) / steps;
    const int off = !(measured <= 2 * assumed && assumed <= 2 * measured);
    if (run == 1) plain = measured;
    if (run == 1) bench_print(NULL, " %.2g |", measured);
    if (run == 1) continue;
    bench_print(NULL, off ? " **%.3g** %.3g |" : " %.3g %.3g |", measured, assumed);
    all[run].wrong += off;
    all[run].ratio[all[run].count++] = measured / assumed;
  }
  bench_print(NULL, "\n");
  free(r);
}

int price_report(FILE *page, uint64_t seed) {
  static tally all[methods];
  int wrong = 0;
  bench_print(page, "The cost of a step in accelerated sweeps: measured over assumed. The screen "
                    "has each problem.\n\n");
  bench_print(NULL, "measured and assumed; **more than a factor of 2 apart**\n\n| problem | W | d "
                    "| contacts | unknowns | sweep us |");
  for (int run = 1; run < methods; run++)
    bench_print(NULL, " %s |", runs[run].name);
  bench_print(NULL, "\n|---|---|---|---|---|---|");
  for (int run = 1; run < methods; run++)
    bench_print(NULL, "---|");
  bench_print(NULL, "\n");
  for (int j = 0; j < kind_count; j++)
    for (int i = 0; i < size_count; i++) {
      regret_problem a;
      if (sizes[i] > regret_most(kinds[j])) continue;
      if (regret_create(&a, kinds[j], sizes[i], .5, seed)) exit(1);
      price_problem(kinds[j], &a.contact, all);
      regret_free(&a);
    }
  bench_print(NULL, "\n");
  bench_print(page, "| method | problems | measured / assumed, median | beyond 2 | |\n"
                    "|---|---|---|---|---|\n");
  for (int run = 2; run < methods; run++) {
    const int failed = all[run].wrong > (all[run].count + 9) / 10;
    bench_print(page, "| %s | %d | %.2f | %d | %s |\n", runs[run].name, all[run].count,
                bench_median((size_t)all[run].count, all[run].ratio), all[run].wrong,
                failed ? "wrong" : "");
    wrong += failed;
  }
  return wrong;
}

/* ---- the total ------------------------------------------------------------------------------- */

/*
 * The total cost of auto on generated problems. A constant is measured by the difference that
 * another value makes (src/auto/constants.h). Problems: every kind of regret_kinds.h with about 24,
 * 70, 220 and 500 contacts, friction .1, .5, 1.5, to 1e-6 and 1e-8 in turn; at most 3000
 * iterations. Costs by dlsi_auto_price_of (all unknowns as if they stuck) are the same in every
 * run; CPU is of the thread, the less of two solves.
 */
typedef struct total {
  int count, solved;
  double cost, log_cost, log_seconds;
} total;

static void add_problem(total *all, const dls_contact *p, double tol) {
  const int m = p->d * p->nc;
  double *r = calloc((size_t)m, sizeof *r), cost = 1;
  bench_clock c = {0};
  dls_solver_settings s;
  dls_solver *solver;
  dls_info info = {.status = DLS_OK};
  dls_solver_settings_init(&s);
  s.limits.tol = tol;
  s.limits.max_iterations = 3000;
  s.limits.blocks = p->Wb.x ? p->Wb.p[p->nc] : 0;
  if (!r || dls_solver_create(&solver, p->d, p->nc, &s, NULL)) exit(1);
  while (bench_runs(&c, 2, 0, 0))
    if (dls_solver_solve(solver, p, r, NULL, &info, NULL) < 0) exit(1);
  for (int k = 0; k < info.stages; k++)
    cost += dlsi_auto_price_of(p, m, &info.stage[k]);
  all->count++;
  all->solved += info.status == DLS_OK;
  all->cost += cost;
  all->log_cost += log(cost);
  all->log_seconds += log(c.least);
  dls_solver_destroy(solver);
  free(r);
}

void total_report(uint64_t seed) {
  static const int about[] = {24, 70, 220, 500};
  static const double friction[] = {.1, .5, 1.5};
  total all = {.count = 0};
  for (int k = 0; regret_kind(k); k++)
    for (int i = 0; i < 4; i++) {
      const char *kind = regret_kind(k);
      const int named = !strncmp(kind, "cube", 4) || !strcmp(kind, "block2"); /* few sizes */
      regret_problem a;
      if (about[i] > regret_most(kind) || (named && i > 1)) continue;
      if (regret_create(&a, kind, about[i], friction[(k + i) % 3], seed + 7 * (uint64_t)i)) exit(1);
      add_problem(&all, &a.contact, i % 2 ? 1e-8 : 1e-6);
      regret_free(&a);
    }
  printf("%d of %d solved; cost in sweeps %.0f, mean %.2f; mean CPU %.4f ms\n", all.solved,
         all.count, all.cost, exp(all.log_cost / all.count),
         1e3 * exp(all.log_seconds / all.count));
}
