/*
 * dynamics.c: columns of spheres that collapse, in steps of time: each step solved cold, and warm
 * with dls_solver_map.
 *
 *   dynamics [--out DIR] [--kind KIND] [--sizes N,N,..] [--tol TOL] [--steps COUNT]
 *            [--limit SECONDS] [--large]
 *
 * Both solvers get the same problem; the cold answer moves the spheres. Times are CPU of
 * dls_solver_map and dls_solver_solve.
 */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "common.h"
#include "delassus/solve.h"
#include "dynamics_column.h"

enum { most_sizes = 8, most_steps = 1000, shown = 10 };

/* loose: spheres that fall together at first. stacked: equal spheres that touch; of 1000 some steps
 * are not solved in 3 s, cold or warm. */
static const column_kind kinds[] = {{"loose", 0.02, 2.1, 0.005, 5e-4, 80, 1000000},
                                    {"stacked", 0, 2.02, 0.001, 1e-3, 20, 500}};

typedef struct plan {
  FILE *page;
  const char *kind;
  int sizes[most_sizes], size_count, steps;
  double tol, limit; /* limit: CPU seconds of a solve */
} plan;

/* What a way to solve has taken so far. */
typedef struct spent {
  dls_solver *solver;
  bench_clock clock;
  double *r, residual; /* residual: the largest one */
  long sweeps;
  int solved;
} spent;

static void spent_create(spent *a, const plan *p, int warm, int most) {
  dls_solver_settings s;
  dls_solver_settings_init(&s);
  s.limits.tol = p->tol;
  s.limits.warm_start = warm;
  s.limits.blocks = 1;
  s.limits.cpu_seconds = p->limit;
  *a = (spent){.r = calloc(3 * (size_t)most, sizeof *a->r)};
  if (!a->r || dls_solver_create(&a->solver, 3, most, &s, NULL)) exit(1);
}

static void spent_free(spent *a) {
  dls_solver_destroy(a->solver);
  free(a->r);
}

/* Counts from here on. */
static void spent_restart(spent *a) {
  a->clock = (bench_clock){0};
  a->residual = 0;
  a->sweeps = a->solved = 0;
}

/* Takes one step. from: NULL for a cold one. */
static void spent_step(spent *a, const plan *p, const dls_contact *problem, const int *from,
                       dls_info *info) {
  dls_certificate now;
  bench_start(&a->clock);
  if (from && dls_solver_map(a->solver, problem->nc, from, a->r, NULL)) exit(1);
  if (dls_solver_solve(a->solver, problem, a->r, NULL, info, NULL) < 0) exit(1);
  (void)bench_stop(&a->clock);
  if (dls_contact_certify(problem, a->r, NULL, &now, NULL)) exit(1);
  a->sweeps += info->iterations;
  a->solved += dls_certificate_holds(&now, p->tol);
  if (!(now.residual <= a->residual)) a->residual = now.residual;
}

static void print_step(int step, const column *a, const dls_info *info, const spent *way) {
  int kept = 0, acting = 0;
  for (int c = 0; c < a->now.count; c++) {
    kept += a->from[c] >= 0;
    acting += a->q[3 * c] < 0;
  }
  bench_print(NULL, "| %d | %d | %.1f | %.0f | %.2f | %d | %.2f | %d | %.2f | %.1e |\n", step,
              a->now.count, 100. * kept / a->now.count, 100. * acting / a->now.count,
              1e3 * way[0].clock.last, info[0].iterations, 1e3 * way[1].clock.last,
              info[1].iterations, way[1].clock.last / way[0].clock.last,
              info[1].certificate.residual);
}

/* Solves the steps of one column. summary: its line. */
static void run_column(const plan *p, const column_kind *kind, int count, char *summary,
                       size_t room) {
  static double ratio[most_steps];
  column a;
  spent way[2];
  if (column_create(&a, kind, count, 2)) exit(1);
  for (int k = 0; k < 2; k++)
    spent_create(&way[k], p, k, a.most);
  bench_print(NULL, /* the steps are for the screen */
              "\n## %s, %d spheres\n\n| step | contacts | known, %% | closing, %% | cold, ms | "
              "sweeps | warm, ms | sweeps | ratio | residual, warm |\n|---|---|---|---|---|---|---"
              "|---|---|---|\n",
              kind->name, count);
  for (int k = 0; k < kind->before + p->steps; k++) {
    dls_info info[2] = {{.iterations = 0}};
    if (column_look(&a)) exit(1);
    for (int i = 0; i < 2; i++) {
      if (k == kind->before) spent_restart(&way[i]);
      spent_step(&way[i], p, &a.contact, i ? a.from : NULL, &info[i]);
    }
    if (k >= kind->before && (k - kind->before) % (p->steps > shown ? p->steps / shown : 1) == 0)
      print_step(k, &a, info, way);
    if (k >= kind->before) ratio[k - kind->before] = way[1].clock.last / way[0].clock.last;
    column_move(&a, way[0].r);
  }
  (void)snprintf(
      summary, room, "| %s | %d | %.3f | %ld | %.3f | %ld | %.2f | %.2f | %.2f | %.1e | %d, %d |\n",
      kind->name, count, way[0].clock.all, way[0].sweeps, way[1].clock.all, way[1].sweeps,
      way[1].clock.all / way[0].clock.all, bench_median((size_t)p->steps, ratio),
      (double)way[1].sweeps / (double)way[0].sweeps, way[1].residual, way[0].solved, way[1].solved);
  for (int k = 0; k < 2; k++)
    spent_free(&way[k]);
  column_free(&a);
}

int main(int argc, char **argv) {
  enum { rows = 2 * most_sizes, room = 200 };
  static char summary[rows][room];
  plan p = {.kind = bench_word(argc, argv, "--kind", ""),
            .sizes = {500, 1000, 5000},
            .steps = (int)bench_number(argc, argv, "--steps", 50),
            .tol = bench_number(argc, argv, "--tol", 1e-4),
            .limit = bench_number(argc, argv, "--limit", 10)};
  int count = 0;
  p.size_count = bench_list(argc, argv, "--sizes", p.sizes, 3, most_sizes - 1);
  if (bench_has(argc, argv, "--large")) p.sizes[p.size_count++] = 20000;
  if (p.steps < 1 || p.steps > most_steps) return 2;
  p.page = bench_program(argc, argv,
                         "[--kind KIND] [--sizes N,N..] [--large] [--tol TOL] [--limit SECONDS] "
                         "[--steps N] [--out DIR]",
                         "dynamics", "Columns of spheres that collapse");
  bench_print(p.page,
              "Steps in time by the scheme of Moreau and Jean, friction 0.4, to residual %g. Each "
              "step is solved cold and, with dls_solver_map, warm; the cold answer moves the "
              "spheres. The screen shows ten steps of each: known contacts were there in the step "
              "before, closing ones have q_n < 0.\n",
              p.tol);
  for (size_t k = 0; k < sizeof kinds / sizeof kinds[0]; k++)
    for (int s = 0; s < p.size_count; s++)
      if (p.sizes[s] <= kinds[k].most && strncmp(kinds[k].name, p.kind, strlen(p.kind)) == 0)
        run_column(&p, &kinds[k], p.sizes[s], summary[count++], room);
  bench_print(
      p.page,
      "\n## %d steps\n\n| column | spheres | cold, s | sweeps | warm, s | sweeps | warm over cold "
      "| median of the steps | sweeps, warm over cold | largest residual, warm | solved, cold and "
      "warm |\n|---|---|---|---|---|---|---|---|---|---|---|\n",
      p.steps);
  for (int k = 0; k < count; k++)
    bench_print(p.page, "%s", summary[k]);
  return fclose(p.page) ? 1 : 0;
}
