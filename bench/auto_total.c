/*
 * auto_total.c: the total cost of auto on generated problems. A constant is measured by the
 * difference that another value makes (src/auto/constants.h).
 *
 * Problems: every kind of regret_kinds.h with about 24, 70, 220 and 500 contacts, friction .1, .5,
 * 1.5, to 1e-6 and 1e-8 in turn; at most 3000 iterations. Costs by dlsi_auto_price_of (all unknowns
 * as if they stuck) are the same in every run; CPU is of the thread, the less of two solves.
 */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "auto/auto.h"
#include "auto_price.h"
#include "common.h"
#include "delassus.h"
#include "regret_kinds.h"

typedef struct total {
  int count, solved;
  double cost, log_cost, log_seconds;
} total;

static void add_problem(total *all, const dls_contact *p, double tol) {
  const int m = p->d * p->nc;
  double *r = calloc((size_t)m, sizeof *r), seconds = INFINITY, cost = 1;
  dls_solver_settings s;
  dls_solver *solver;
  dls_info info = {.status = DLS_OK};
  dls_solver_settings_init(&s);
  s.limits.tol = tol;
  s.limits.max_iterations = 3000;
  s.limits.blocks = p->Wb.x ? p->Wb.p[p->nc] : 0;
  if (!r || dls_solver_create(&solver, p->d, p->nc, &s, NULL)) exit(1);
  for (int k = 0; k < 2; k++) {
    const double begun = bench_seconds();
    if (dls_solver_solve(solver, p, r, NULL, &info, NULL) < 0) exit(1);
    seconds = fmin(seconds, bench_seconds() - begun);
  }
  for (int k = 0; k < info.stages; k++)
    cost += dlsi_auto_price_of(p, m, &info.stage[k]);
  all->count++;
  all->solved += info.status == DLS_OK;
  all->cost += cost;
  all->log_cost += log(cost);
  all->log_seconds += log(seconds);
  dls_solver_destroy(solver);
  free(r);
}

void total_report(uint64_t seed) {
  static const int sizes[] = {24, 70, 220, 500};
  static const double friction[] = {.1, .5, 1.5};
  total all = {.count = 0};
  for (int k = 0; regret_kind(k); k++)
    for (int i = 0; i < 4; i++) {
      const char *kind = regret_kind(k);
      const int named = !strncmp(kind, "cube", 4) || !strcmp(kind, "block2"); /* few sizes */
      regret_problem a;
      if (sizes[i] > regret_most(kind) || (named && i > 1)) continue;
      if (regret_create(&a, kind, sizes[i], friction[(k + i) % 3], seed + 7 * (uint64_t)i)) exit(1);
      add_problem(&all, &a.contact, i % 2 ? 1e-8 : 1e-6);
      regret_free(&a);
    }
  printf("%d of %d solved; cost in sweeps %.0f, mean %.2f; mean CPU %.4f ms\n", all.solved,
         all.count, all.cost, exp(all.log_cost / all.count),
         1e3 * exp(all.log_seconds / all.count));
}
