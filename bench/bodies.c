/*
 * bodies.c: compares rigid bodies as W = H^T H with W by blocks; sweeps on two threads, with a
 * model of the memory traffic extended to 64.
 *
 *   bodies [--kind KIND] [--sizes N,N,..] [--seed S] [--dense ROWS] [--sweeps COUNT] [--rounds R]
 *          [--socket GB/s] [--out DIR]
 *
 * Storages are compared by CPU time on one thread, threads by wall time if two threads have two
 * cores to themselves; the page says whether they had.
 *
 * The model of a sweep on p threads: c seconds per contact in the cache, measured on the smallest
 * problem, B bytes per contact that are read or written once,
 *
 *   t(p) = max( c span(p), B nc / memory(p) ) + barriers(p)
 *
 * span(p): contacts of the busiest thread, if the slabs (slabs.c) are handed out one by one;
 * memory(p) = p memory(1), up to the limit of a socket; barriers: as measured on two threads.
 */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

#include "common.h"
#include "delassus.h"
#include "rigid.h"
#include "vi/vi_internal.h"

enum { most_sizes = 8, most_threads = 64 };
static const double quiet = 0.9;          /* share of a core that one thread has to itself */
static const double short_barrier = 2e-6; /* supposed where the cores are busy */

typedef struct plan {
  const char *kind;
  int sizes[most_sizes], size_count, dense, sweeps, rounds;
  unsigned long seed;
  double socket, core; /* core: share of two cores that two threads have */
  FILE *page, *csv;
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

/* Times sweeps and a solve on one and two threads. seconds: of a sweep on each by the wall, CPU
 * seconds of one thread. */
static void compare_threads(const plan *p, const char *name, const dls_contact *problem,
                            double seconds[3]) {
  timing sweep[2], whole[2];
  for (int k = 0; k < 2; k++) {
    const way sweeps = {DLS_NLGS, DLS_ACCELERATION_NONE, 1 + k, p->sweeps, 0};
    const way fast = {DLS_NLGS, problem->W.a ? DLS_ACCELERATION_NONE : DLS_ACCELERATION_MOMENTUM,
                      1 + k, 0, 1e-4};
    time_solve(p, problem, &sweeps, &sweep[k]);
    time_solve(p, problem, &fast, &whole[k]);
    seconds[k] = sweep[k].wall / p->sweeps;
  }
  seconds[2] = sweep[0].cpu / p->sweeps;
  bench_print(p->page, "| %s | %d | %.2f |", name, problem->nc, sweep[1].cpu / sweep[0].cpu);
  if (p->core < quiet) { /* others have the cores */
    bench_print(p->page, " busy | | | | | |\n");
    seconds[0] = seconds[1] = NAN;
    return;
  }
  bench_print(p->page, " %.3g | %.3g | %.2f | %.3g (%d) | %.3g (%d) | %.2f |\n", 1e3 * seconds[0],
              1e3 * seconds[1], sweep[0].wall / sweep[1].wall, whole[0].wall, whole[0].iterations,
              whole[1].wall, whole[1].iterations, whole[0].wall / whole[1].wall);
}

static void compare_dense(const plan *p) {
  const int nc = p->dense / 3, m = 3 * nc;
  const size_t rows = (size_t)m;
  double *W = malloc(rows * rows * sizeof *W), *q = malloc(rows * sizeof *q), unused[3];
  double *mu = malloc(rows * sizeof *mu);
  for (size_t j = 0; W && q && mu && j < rows; j++) {
    q[j] = j % 3 ? .1 * (double)(j % 7) - .3 : -1;
    mu[j] = .3;
    for (size_t i = 0; i < rows; i++)
      W[i + rows * j] = (i == j           ? 1
                         : i % 3 == j % 3 ? .3
                                          : .05) /
                        (1 + fabs((double)i - (double)j));
  }
  if (W && q && mu && nc) {
    const dls_contact problem = {.d = 3, .nc = nc, .W = {m, m, m, W}, .q = q, .mu = mu};
    compare_threads(p, "dense", &problem, unused);
  }
  free(W);
  free(q);
  free(mu);
}

/* ---- the model ------------------------------------------------------------------------------- */

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

/* What a team measures: bytes that so many threads read in a second of CPU of each, and the wall
 * seconds of two tasks of nothing. */
typedef struct rates {
  int threads;
  double bytes, barrier;
} rates;

static void nothing(void *data, int k) {
  (void)data;
  (void)k;
}

static void measure_rates(dlsi_team *team, void *data) {
  enum { barriers = 10000 };
  rates *of = data;
  const size_t count = (size_t)1 << 25;
  double *x = malloc(2 * count * sizeof *x), best = INFINITY, kept = 0;
  for (size_t i = 0; x && i < 2 * count; i++)
    x[i] = 1;
  for (int k = 0; x && k < 5; k++) {
    stream s = {.x = x, .count = 2 * count / (size_t)of->threads};
    const double start = bench_seconds();
    dlsi_parallel(team, of->threads, stream_read, &s);
    best = fmin(best, (bench_seconds() - start) / of->threads);
    kept += s.sum[0];
  }
  free(x);
  of->bytes = kept > 0 ? (double)(2 * count * sizeof *x) / best : NAN;
  const double start = wall_seconds();
  for (int k = 0; k < barriers; k++)
    dlsi_parallel(team, 2, nothing, NULL);
  of->barrier = (wall_seconds() - start) / barriers;
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

/* Returns the candidates that the busiest of p threads visits in a sweep. */
static int span(const dlsi_set *set, int p) {
  int all = 0;
  for (int parity = 0; parity < 2; parity++) {
    int load[most_threads] = {0}, most = 0;
    for (int k = parity; k < set->slabs; k += 2) {
      int least = 0;
      for (int t = 1; t < p; t++)
        if (load[t] < load[least]) least = t;
      load[least] += set->start[k + 1] - set->start[k];
      if (load[least] > most) most = load[least];
    }
    all += most;
  }
  return all;
}

/* Returns the bytes that a sweep moves for a candidate: H or the column of W, its own block, r, q
 * and, by blocks, u of the column; r and u are read and written. */
static double bytes_of(const dls_contact *p) {
  const double d = p->d, own = sizeof(dlsi_block_3d) + 8 * (2 * d + d) + 8;
  if (p->bodies.H) return own + 16 * p->bodies.n * d + 8;
  const double blocks = (double)p->Wb.p[p->nc] / p->nc;
  return own + blocks * (8 * d * d + 4) + 16 * d;
}

static void draw(const plan *p, const char *name, const dls_contact *problem, double c,
                 const double rate[2], double barrier, const double seconds[3]) {
  dlsi_slabs slabs = {.memory = NULL};
  if (dlsi_slabs_set(&slabs, problem, NULL)) return;
  const double traffic = bytes_of(problem) * problem->nc;
  bench_print(NULL, "| %s | %d | %d | %.0f |", name, problem->nc, slabs.set.slabs,
              bytes_of(problem));
  double t1 = 0;
  for (int threads = 1; threads <= most_threads; threads *= 2) {
    const double memory = threads == 1 ? rate[0] : fmin(rate[1] / 2 * threads, p->socket * 1e9);
    const double work = c * span(&slabs.set, threads), moves = traffic / memory;
    const double t = fmax(work, moves) + (threads > 1 ? 4 * barrier : 0);
    if (threads == 1) t1 = t;
    bench_print(NULL, " %.3g (%.1f) |", 1e3 * t, t1 / t);
    fprintf(p->csv, "%s,%d,%d,%g,%g,%g\n", name, problem->nc, threads, t, t1 / t,
            threads == 2   ? seconds[0] / seconds[1]
            : threads == 1 ? 1
                           : NAN);
  }
  bench_print(NULL, "\n");
  dlsi_slabs_free(&slabs);
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
  double seconds[most_sizes][2][3];
  dlsi_team_run(2, measure_share, &p->core);
  bench_print(p->page,
              "\n"
              "## Two threads over one\n"
              "\n"
              "Two threads had %.2f of two cores (below %.1f wall times are left out: busy). "
              "CPU 2 / 1: CPU of a sweep on both threads over that on one. Sweep: wall "
              "milliseconds of a plain sweep. Solve: wall seconds (sweeps) to 1e-4, with "
              "momentum, for W dense without.\n"
              "\n"
              "| W | contacts | CPU 2 / 1 | sweep: 1 | 2 | speed-up | solve: 1 | 2 | "
              "speed-up |\n"
              "|---|---|---|---|---|---|---|---|---|\n",
              p->core, quiet);
  for (int k = 0; k < p->size_count; k++) {
    compare_threads(p, "blocks", &a[k].contact, seconds[k][0]);
    compare_threads(p, "bodies", &a[k].factored, seconds[k][1]);
  }
  compare_dense(p);
  rates one = {1, 0, 0}, two = {2, 0, 0};
  dlsi_team_run(1, measure_rates, &one);
  dlsi_team_run(2, measure_rates, &two);
  const double rate[2] = {one.bytes, two.bytes};
  const double barrier = p->core < quiet ? short_barrier : two.barrier;
  bench_print(
      p->page,
      "\n## Model\n\nThe memory gives %.1f GB/s to one thread and %.1f to two; %.0f GB/s "
      "are supposed of a whole socket. A barrier of two threads: %.1f us%s. Milliseconds of "
      "a sweep (speed-up) on 1 to 64 threads: the picture, bodies.csv and the screen.\n\n"
      "![Speed-up of a sweep against threads](bodies.png)\n",
      1e-9 * rate[0], 1e-9 * rate[1], p->socket, 1e6 * barrier,
      p->core < quiet ? ", supposed" : "");
  bench_print(NULL, "| W | contacts | slabs | bytes a contact | 1 | 2 | 4 | 8 | 16 | 32 | 64 |\n");
  for (int b = 0; b < 2; b++) {
    const double c = seconds[0][b][2] / a[0].contact.nc;
    for (int k = 0; k < p->size_count; k++)
      draw(p, b ? "bodies" : "blocks", b ? &a[k].factored : &a[k].contact, c, rate, barrier,
           seconds[k][b]);
  }
}

int main(int argc, char **argv) {
  if (!bench_options(argc, argv,
                     "[--kind KIND] [--sizes N,N..] [--seed SEED] [--dense N] [--sweeps N] "
                     "[--rounds N] [--socket GFLOPS] [--out DIR]"))
    return 2;
  plan p = {.kind = bench_word(argc, argv, "--kind", "packing-flow"),
            .sizes = {5000, 20000, 90000},
            .seed = (unsigned long)bench_number(argc, argv, "--seed", 2),
            .dense = (int)bench_number(argc, argv, "--dense", 6000),
            .sweeps = (int)bench_number(argc, argv, "--sweeps", 50),
            .rounds = (int)bench_number(argc, argv, "--rounds", 3),
            .socket = bench_number(argc, argv, "--socket", 200)};
  const char *out = bench_word(argc, argv, "--out", "build");
  rigid a[most_sizes];
  p.size_count = bench_list(argc, argv, "--sizes", p.sizes, 3, most_sizes);
  if (p.sweeps < 1 || p.rounds < 1) return 2;
  p.page = bench_page(out, "bodies", "Rigid bodies in factored form, and two threads", argc, argv);
  p.csv = p.page ? bench_open(out, "bodies.csv") : NULL;
  if (!p.csv) return 1;
  fprintf(p.csv, "storage,candidates,threads,seconds,speedup,measured\n");
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
  fclose(p.csv);
  return 0;
}
