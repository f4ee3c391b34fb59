/*
 * blocks.c: products with W, dense and by blocks, compared with simple products of the same memory.
 *
 *   blocks [--out DIR]    blocks.md
 *
 *   dense    u = W r + q; u and |W| |r|; one column block; a Gauss-Seidel sweep in which all
 *            contacts change: over one dgemv
 *   blocks   u = W r + q, and a sweep: over reading the bytes of W once
 *
 * CPU time. Short rounds in which each has its turn; ratios are medians of ratios within a round:
 * the clock of a shared machine varies by a factor of 2, with different effects on products and
 * solutions. Dense: W_ab = exp(-|a - b| / 30) on normals, 0.8 of it on tangents, 1e-3 more on the
 * diagonal, everything pressed and pushed, mu = 0.5. Blocks: symmetric pairs in a band at random
 * places, as many as give the density named.
 */
#include <math.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/base.h"
#include "common.h"
#include "delassus/nlgs.h"
#include "linear/blas.h"

enum { least_rounds = 9, most_rounds = 401, most_things = 6, few = 8, many = 24 };
/* Seconds:
 *   shortest  of a measurement of one function
 *   settling  of the calls before it that are not measured, because a processor may take half a
 *             millisecond to change its clock for the wide registers of dgemv
 *   enough    of all measurements together */
static const double shortest = 3e-3, settling = 1e-3, enough = 2;

static uint64_t seed = 88172645463325252u;

/* Draws from (-1, 1). */
static double blocks_uniform(void) {
  seed ^= seed << 13;
  seed ^= seed >> 7;
  seed ^= seed << 17;
  return ((double)(seed >> 11) + 0.5) * 0x1p-52 - 1;
}

static void *need(size_t count, size_t size) {
  void *p = calloc(count ? count : 1, size);
  if (p) return p;
  fputs("blocks: out of memory\n", stderr);
  exit(1);
}

static void must(dls_status status, const dls_error *error) {
  if (status >= 0) return;
  fprintf(stderr, "blocks: %s\n", error->message);
  exit(1);
}

/* Arguments of everything timed. */
typedef struct work {
  dls_contact problem;
  double *r, *u, *a;
  double sum; /* of what was read */
} work;

static void blocks_multiply(work *w) {
  dlsi_contact_multiply(&w->problem, NULL, w->r, w->u, NULL);
}

static void blocks_magnitudes(work *w) {
  dlsi_contact_multiply(&w->problem, NULL, w->r, w->u, w->a);
}

/* Adds the columns of all candidates, one after the other. */
static void add_columns(work *w) {
  const size_t d = (size_t)w->problem.d;
  for (int c = 0; c < w->problem.nc; c++)
    dlsi_contact_add_columns(&w->problem, c, w->r + d * (size_t)c, w->u);
}

static void yard(work *w) {
  const dls_dense *A = &w->problem.W;
  const double one = 1;
  const int step = 1;
  memcpy(w->u, w->problem.q, (size_t)A->rows * sizeof *w->u);
  dgemv_("N", &A->rows, &A->cols, &one, A->a, &A->ld, w->r, &step, &one, w->u, &step, 1);
}

/* Reads W once, into eight sums, so that the additions do not wait for each other. */
static void stream(work *w) {
  const dls_blocks *B = &w->problem.Wb;
  const size_t blocks = (size_t)B->p[B->n], entries = (size_t)(B->d * B->d) * blocks;
  double s[8] = {0};
  int t = 0;
  for (size_t k = 0; k + 8 <= entries; k += 8)
    for (int e = 0; e < 8; e++)
      s[e] += B->x[k + (size_t)e];
  for (size_t k = 0; k < blocks; k++)
    t ^= B->i[k];
  for (int e = 0; e < 8; e++)
    w->sum += s[e];
  w->sum += t;
}

static void solve_sweeps(work *w, int sweeps) {
  dls_nlgs_settings s;
  dls_nlgs_settings_init(&s);
  s.limits.tol = 0;
  s.limits.max_iterations = sweeps;
  dls_nlgs *nlgs;
  dls_error error;
  must(dls_nlgs_create(&nlgs, w->problem.d, w->problem.nc, &s, &error), &error);
  must(dls_nlgs_solve(nlgs, &w->problem, w->a, NULL, NULL, &error), &error);
  dls_nlgs_destroy(nlgs);
}

static void solve_few(work *w) {
  solve_sweeps(w, few);
}
static void solve_many(work *w) {
  solve_sweeps(w, many);
}

/* Returns the CPU seconds of a call. */
static double time_turn(void (*f)(work *), work *w) {
  int calls = 0, settled = 0;
  double start = bench_seconds();
  for (;;) {
    f(w);
    calls++;
    const double cpu = bench_seconds() - start;
    if (cpu >= shortest) return cpu / calls;
    if (settled || cpu < settling) continue;
    settled = 1;
    calls = 0;
    start = bench_seconds();
  }
}

/* Times n functions in turn. The last two solve with few and many sweeps, from which the time of
 * one sweep follows: entry n-1. t: median CPU seconds of a call, n; ratio: over that of f[0], n. */
static void race(int n, void (*const f[])(work *), work *w, double *t, double *ratio) {
  static double all[most_things][most_rounds], over[most_things][most_rounds];
  const double start = bench_seconds();
  int round = 0;
  for (; round < most_rounds; round++) {
    if (round >= least_rounds && bench_seconds() - start > enough) break;
    for (int k = 0; k < n; k++)
      all[k][round] = time_turn(f[k], w);
    all[n - 1][round] = (all[n - 1][round] - all[n - 2][round]) / (many - few);
    for (int k = 0; k < n; k++)
      over[k][round] = all[k][round] / all[0][round];
  }
  for (int k = 0; k < n; k++) {
    t[k] = bench_median((size_t)round, all[k]);
    ratio[k] = bench_median((size_t)round, over[k]);
  }
}

static void prepare_work(work *w, int d, int nc) {
  const size_t m = (size_t)(d * nc);
  double *q = need(m, sizeof *q), *mu = need((size_t)nc, sizeof *mu);
  *w = (work){.problem = {.d = d, .nc = nc, .q = q, .mu = mu},
              .r = need(m, sizeof *w->r),
              .u = need(m, sizeof *w->u),
              .a = need(m, sizeof *w->a)};
  for (size_t k = 0; k < m; k++) {
    const double x = (double)(k / (size_t)d) / 40;
    q[k] = k % (size_t)d == 0 ? -1 + 0.1 * sin(x) : 0.4 + 0.2 * cos(x + (double)(k % (size_t)d));
    w->r[k] = blocks_uniform();
    mu[k / (size_t)d] = 0.5;
  }
}

static void release_work(work *w) {
  free((void *)w->problem.q);
  free((void *)w->problem.mu);
  free(w->r);
  free(w->u);
  free(w->a);
}

static void time_dense(FILE *page, int d, int m) {
  work w;
  prepare_work(&w, d, m / d);
  double *W = need((size_t)m * (size_t)m, sizeof *W);
  for (int j = 0; j < m; j++)
    for (int i = j % d; i < m; i += d)
      W[(size_t)i + (size_t)j * (size_t)m] =
          (j % d ? 0.8 : 1) * exp(-abs(i / d - j / d) / 30.) + 1e-3 * (i == j);
  w.problem.W = (dls_dense){m, m, m, W};
  void (*const all[])(work *) = {yard,        blocks_multiply, blocks_magnitudes,
                                 add_columns, solve_few,       solve_many};
  double t[6], ratio[6];
  race(6, all, &w, t, ratio);
  const double entries = (double)m * m;
  bench_print(page, "| %dD | %d | %.2f | %.1f | %.2f | %.2f | %.2f | %.2f |\n", d, m,
              2e-9 * entries / t[0], 8e-9 * entries / t[0], ratio[1], ratio[2], ratio[3], ratio[5]);
  free(W);
  release_work(&w);
}

static void time_blocks(FILE *page, int d, int nc, int per_column) {
  work w;
  prepare_work(&w, d, nc);
  const int band = 10 * per_column;
  int *p = need((size_t)nc + 1, sizeof *p);
  int *i = need((size_t)(nc * (per_column + 1)), sizeof *i);
  double *x = need((size_t)(d * d * nc) * (size_t)(per_column + 1), sizeof *x);
  int k = 0;
  for (int b = 0; b < nc; b++) {
    for (int e = 0; e < per_column; e++) {
      const int a = e == 0 ? b : (int)(b + blocks_uniform() * band + 2 * nc) % nc;
      for (int f = 0; f < d * d; f++)
        x[d * d * k + f] = e == 0 ? (f % (d + 1) == 0 ? 2 : 0) : blocks_uniform() / per_column;
      i[k++] = a;
    }
    p[b + 1] = k;
  }
  w.problem.Wb = (dls_blocks){d, nc, p, i, x};
  void (*const all[])(work *) = {stream, blocks_multiply, solve_few, solve_many};
  double t[4], ratio[4];
  race(4, all, &w, t, ratio);
  const double bytes = k * (8. * d * d + 4);
  bench_print(page, "| %dD | %d | %d | %.1f | %.1f | %.2f | %.2f | %.2f | %.0f |\n", d, nc, k,
              1e-6 * bytes, 1e-9 * bytes / t[0], 2e-9 * d * d * k / t[1], ratio[1], ratio[3],
              1e9 * t[3] / nc);
  free(p);
  free(i);
  free(x);
  release_work(&w);
}

int main(int argc, char **argv) {
  const int rows[] = {126, 504, 1002, 2004, 4002};
  if (!bench_options(argc, argv, "[--out DIR]")) return 2;
  const char *directory = argc > 2 ? argv[argc - 1] : "bench/results";
  FILE *page = bench_page(directory, "blocks", "W dense and by blocks", argc, argv);
  if (!page) return 1;
  bench_print(page, "Dense: times over dgemv's on the same W.\n\n"
                    "| dense | m | dgemv GFlop/s | GB/s | u = W r + q | with abs(W) abs(r) | by "
                    "columns | sweep |\n|---|---|---|---|---|---|---|---|\n");
  for (int d = 2; d <= 3; d++)
    for (int k = 0; k < 5; k++)
      time_dense(page, d, rows[k]);
  bench_print(page, "\nBy blocks: times over reading the same bytes once (stream).\n\n"
                    "| blocks | candidates | blocks | MB | stream GB/s | GFlop/s | u = W r + q | "
                    "sweep | ns per candidate |\n|---|---|---|---|---|---|---|---|---|\n");
  for (int d = 2; d <= 3; d++)
    for (int nc = 500; nc <= 128000; nc *= 16) {
      time_blocks(page, d, nc, 5);
      time_blocks(page, d, nc, 25);
    }
  return fclose(page) != 0;
}
