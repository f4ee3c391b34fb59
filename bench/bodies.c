/*
 * bodies.c: compares rigid bodies as W = H^T H with W by blocks; sweeps on two threads.
 *
 *   bodies [--kind KIND] [--sizes N,N,..] [--seed S] [--dense ROWS] [--sweeps COUNT] [--rounds R]
 *          [--out DIR]
 *
 * Storages are compared by CPU time on one thread, threads by wall time if two threads have two
 * cores to themselves; the page says whether they had.
 */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

#include "common.h"
#include "delassus.h"
#include "rigid.h"
#include "solvers_scenes.h"
#include "vi/vi_internal.h"

enum { most_sizes = 8 };
static const double quiet = 0.9; /* share of a core that one thread has to itself */

typedef struct plan {
  const char *kind;
  int sizes[most_sizes], size_count, dense, sweeps, rounds;
  unsigned long seed;
  double core; /* share of two cores that two threads have */
  FILE *page;
} plan;

typedef struct timing {
  double wall, cpu; /* the least of each */
  int iterations;
} timing;

static double wall_seconds(void) {
  struct timespec t;
  clock_gettime(CLOCK_MONOTONIC, &t);
  return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

/* ---- one solve ------------------------------------------------------------------------------- */

typedef struct way {
  dls_method method;
  dls_acceleration acceleration;
  int threads, sweeps; /* sweeps > 0: so many, whatever the residual */
  double tol;
} way;

static void time_solve(const plan *p, const dls_contact *problem, const way *w, timing *best) {
  dls_solver_settings s;
  dls_solver *solver = NULL;
  dls_info info = {.iterations = 0};
  double *r = calloc((size_t)(problem->d * problem->nc), sizeof *r);
  *best = (timing){INFINITY, INFINITY, 0};
  dls_solver_settings_init(&s);
  s.method = w->method;
  s.acceleration = w->acceleration;
  s.limits.tol = w->sweeps ? 0 : w->tol;
  s.limits.max_iterations = w->sweeps ? w->sweeps : w->method == DLS_NLGS ? 100000 : 0;
  s.limits.threads = w->threads;
  s.limits.blocks = problem->Wb.x ? problem->Wb.p[problem->nc] : 0;
  s.limits.cpu_seconds = 120;
  if (problem->bodies.H && dls_bodies_count(problem, &s.limits.blocks, NULL)) s.limits.blocks = 1;
  dls_status status = r ? dls_solver_create(&solver, problem->d, problem->nc, &s, NULL) : -1;
  for (int k = 0; k < p->rounds && status >= 0; k++) {
    const double wall = wall_seconds(), cpu = bench_seconds();
    status = dls_solver_solve(solver, problem, r, NULL, &info, NULL);
    best->wall = fmin(best->wall, wall_seconds() - wall);
    best->cpu = fmin(best->cpu, bench_seconds() - cpu);
  }
  best->iterations = info.iterations;
  if (status < 0 || (!w->sweeps && status)) *best = (timing){NAN, NAN, info.iterations};
  dls_solver_destroy(solver);
  free(r);
}

/* ---- storages -------------------------------------------------------------------------------- */

static double megabytes(const dls_contact *p) {
  const double d = p->d, nc = p->nc;
  if (p->bodies.H) return 1e-6 * (nc * (16 * p->bodies.n * d + 8) + 8 * p->bodies.count);
  return 1e-6 * ((8 * d * d + 4) * p->Wb.p[p->nc] + 4 * nc);
}

static void compare_storages(const plan *p, const rigid *a) {
  const way all[] = {{DLS_NLGS, DLS_ACCELERATION_NONE, 1, p->sweeps, 0},
                     {DLS_NLGS, DLS_ACCELERATION_NONE, 1, 0, 1e-4},
                     {DLS_NLGS, DLS_ACCELERATION_MOMENTUM, 1, 0, 1e-4},
                     {DLS_AUTO, DLS_ACCELERATION_NONE, 1, 0, 1e-4}};
  timing t[2][4];
  for (int k = 0; k < 4; k++)
    for (int b = 0; b < 2; b++)
      time_solve(p, b ? &a->factored : &a->contact, &all[k], &t[b][k]);
  bench_print(p->page, "| %d | %.1f | %.1f |", a->contact.nc, megabytes(&a->contact),
              megabytes(&a->factored));
  bench_print(p->page, " %.3f | %.3f |", 1e6 * t[0][0].cpu / p->sweeps / a->contact.nc,
              1e6 * t[1][0].cpu / p->sweeps / a->contact.nc);
  for (int k = 1; k < 4; k++)
    bench_print(p->page, " %.3g (%d) | %.3g (%d) |", t[0][k].cpu, t[0][k].iterations, t[1][k].cpu,
                t[1][k].iterations);
  bench_print(p->page, " %.2f | %.2f | %.2f |\n", t[1][0].cpu / t[0][0].cpu,
              t[0][2].cpu / t[0][1].cpu, t[1][2].cpu / t[0][1].cpu);
}

/* ---- threads --------------------------------------------------------------------------------- */

/* Times sweeps and a solve on one and two threads. */
static void compare_threads(const plan *p, const char *name, const dls_contact *problem) {
  timing sweep[2], whole[2];
  for (int k = 0; k < 2; k++) {
    const way sweeps = {DLS_NLGS, DLS_ACCELERATION_NONE, 1 + k, p->sweeps, 0};
    const way fast = {DLS_NLGS, problem->W.a ? DLS_ACCELERATION_NONE : DLS_ACCELERATION_MOMENTUM,
                      1 + k, 0, 1e-4};
    time_solve(p, problem, &sweeps, &sweep[k]);
    time_solve(p, problem, &fast, &whole[k]);
  }
  bench_print(p->page, "| %s | %d | %.2f |", name, problem->nc, sweep[1].cpu / sweep[0].cpu);
  if (p->core < quiet) { /* others have the cores */
    bench_print(p->page, " busy | | | | | |\n");
    return;
  }
  bench_print(p->page, " %.3g | %.3g | %.2f | %.3g (%d) | %.3g (%d) | %.2f |\n",
              1e3 * sweep[0].wall / p->sweeps, 1e3 * sweep[1].wall / p->sweeps,
              sweep[0].wall / sweep[1].wall, whole[0].wall, whole[0].iterations, whole[1].wall,
              whole[1].iterations, whole[0].wall / whole[1].wall);
}

static void compare_dense(void *data, const scene *s) {
  compare_threads(data, "dense", &s->contact);
}

/* Sums of an array, one for each thread: what they read in a second. */
typedef struct stream {
  const double *x;
  size_t count; /* of each thread */
  double sum[2];
} stream;

static void stream_read(void *data, int k) {
  stream *s = data;
  const double *x = s->x + (size_t)k * s->count;
  double sum[8] = {0};
  for (size_t i = 0; i + 8 <= s->count; i += 8)
    for (size_t l = 0; l < 8; l++)
      sum[l] += x[i + l];
  s->sum[k] = sum[0] + sum[1] + sum[2] + sum[3] + sum[4] + sum[5] + sum[6] + sum[7];
}

/* Returns the share of two cores that two threads get while they read for half a second. */
static void measure_share(dlsi_team *team, void *data) {
  const size_t count = (size_t)1 << 16;
  double *x = calloc(2 * count, sizeof *x), kept = 1;
  const double start = wall_seconds(), cpu = bench_seconds();
  stream s = {.x = x, .count = count};
  while (x && wall_seconds() - start < 0.5) {
    dlsi_parallel(team, 2, stream_read, &s);
    kept += s.sum[0];
  }
  free(x);
  *(double *)data = kept * (bench_seconds() - cpu) / (wall_seconds() - start) / 2;
}

/* ---- the page -------------------------------------------------------------------------------- */

/* The cell that is the same in all tables of a size. */
static void run_sizes(plan *p, rigid *a) {
  bench_print(p->page,
              "\n## Storages, one thread\n\nMegabytes of W; CPU microseconds of a plain sweep for "
              "a contact; CPU seconds (sweeps) to 1e-4.\n\n| contacts | MB: blocks | bodies | "
              "sweep: blocks | bodies | plain: blocks | bodies | momentum: blocks | bodies | auto: "
              "blocks | bodies | sweep, bodies / blocks | momentum / plain, blocks | momentum on "
              "bodies / plain on blocks |\n|---|---|---|---|---|---|---|---|---|---|---|---|---|---"
              "|\n");
  for (int k = 0; k < p->size_count; k++)
    compare_storages(p, &a[k]);
  dlsi_team_run(2, measure_share, &p->core);
  bench_print(p->page,
              "\n## Two threads over one\n\nTwo threads had %.2f of two cores (below %.1f wall "
              "times are left out: busy). CPU 2 / 1: CPU of a sweep on both threads over that on "
              "one. Sweep: wall milliseconds of a plain sweep. Solve: wall seconds (sweeps) to "
              "1e-4, with momentum, for W dense without.\n\n| W | contacts | CPU 2 / 1 | sweep: 1 "
              "| 2 | speed-up | solve: 1 | 2 | speed-up |\n|---|---|---|---|---|---|---|---|---|\n",
              p->core, quiet);
  for (int k = 0; k < p->size_count; k++) {
    compare_threads(p, "blocks", &a[k].contact);
    compare_threads(p, "bodies", &a[k].factored);
  }
  (void)scenes_random(2, p->dense / 3, 0, compare_dense, p); /* d = 3 */
}

int main(int argc, char **argv) {
  plan p = {.kind = bench_word(argc, argv, "--kind", "packing-flow"),
            .sizes = {5000, 20000, 90000},
            .seed = (unsigned long)bench_number(argc, argv, "--seed", 2),
            .dense = (int)bench_number(argc, argv, "--dense", 6000),
            .sweeps = (int)bench_number(argc, argv, "--sweeps", 50),
            .rounds = (int)bench_number(argc, argv, "--rounds", 3)};
  rigid a[most_sizes];
  p.size_count = bench_list(argc, argv, "--sizes", p.sizes, 3, most_sizes);
  if (p.sweeps < 1 || p.rounds < 1) return 2;
  p.page = bench_program(argc, argv,
                         "[--kind KIND] [--sizes N,N..] [--seed SEED] [--dense N] [--sweeps N] "
                         "[--rounds N] [--out DIR]",
                         "bodies", "Rigid bodies in factored form, and two threads");
  bench_print(p.page, "%s, mu .5, seed %lu.\n", p.kind, p.seed);
  int made = 0;
  while (made < p.size_count && rigid_create(&a[made], p.kind, p.sizes[made], .5, p.seed) == 0)
    made++;
  if (made == p.size_count)
    run_sizes(&p, a);
  else
    fprintf(stderr, "bodies: %s: unknown, or out of memory\n", p.kind);
  while (made > 0)
    rigid_free(&a[--made]);
  fclose(p.page);
  return 0;
}
