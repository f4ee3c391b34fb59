/* global_ways.c: the methods that solve a scene, as global_ways.h describes them. */
#include "global_ways.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>

#include "common.h"
#include "global/global_internal.h"

typedef struct trial {
  way w;
  scene plan;
  double mu, tol, most_bytes;
  result *out;
} trial;

/* ---- ways ------------------------------------------------------------------------------------ */

static void take_K(const scene *S, const double *mu, double tol, double *r, double *x,
                   result *out) {
  dls_global *G;
  dls_info info;
  dls_error e = {0};
  const dls_limits limits = {.tol = tol};
  const double held = bench_watch_memory(), start = bench_seconds();
  if (dls_global_create(&G, &S->model, &e)) {
    fprintf(stderr, "%s\n", e.message);
    return;
  }
  out->create = bench_seconds() - start;
  out->status = dls_global_solve(G, S->f, S->g, mu, &limits, r, x, &info, &e);
  out->cpu = bench_seconds() - start;
  out->bytes = bench_memory("VmHWM") - held;
  if (out->status < 0) fprintf(stderr, "%s\n", e.message);
  out->failed = out->status < 0 || dls_global_get_info(G, &out->foreseen, NULL);
  out->iterations = info.iterations;
  out->factorisations = info.factorisations;
  out->residual = info.certificate.residual;
  bench_clock c = {0};
  while (bench_runs(&c, 3, 0, 0))
    out->failed |= dlsi_system_factor(G->system, 1, NULL) != 0;
  out->factor = c.least;
  dls_global_destroy(G);
}

/* w: ON_W, or EITHER, which chooses. */
static void take_reduction(way w, const scene *S, const double *mu, double tol, double most_bytes,
                           double *r, double *x, result *out) {
  dls_reduction *R = NULL;
  dls_reduction_info facts = {.on = DLS_ON_W};
  dls_reduction_settings how;
  dls_solver_settings settings;
  dls_info info = {.iterations = 0};
  dls_error e = {0};
  dls_reduction_settings_init(&how);
  dls_solver_settings_init(&settings);
  settings.limits.tol = tol;
  if (w == ON_W) {
    how.on = DLS_ON_W;
    if (dls_reduction_estimate(&S->model, NULL, &facts, NULL)) return;
    out->foreseen_W = facts.bytes;
    if (facts.bytes > most_bytes) return;
  }
  const double held = bench_watch_memory(), start = bench_seconds();
  dls_status status = dls_reduction_create(&R, &S->model, &how, &e);
  out->create = bench_seconds() - start;
  if (!status) status = dls_reduction_load(R, S->f, S->g, &e);
  if (!status) status = dls_reduction_solve(R, mu, &settings, r, NULL, x, &info, &e);
  out->cpu = bench_seconds() - start;
  out->bytes = bench_memory("VmHWM") - held;
  out->status = status;
  if (status >= 0 && dls_reduction_get_info(R, &facts, &e)) status = DLS_E_ARGUMENT;
  if (status < 0) fprintf(stderr, "%s\n", e.message);
  out->failed = status < 0;
  out->on_K = facts.on == DLS_ON_K;
  out->iterations = info.iterations;
  out->factorisations = info.factorisations;
  out->residual = info.certificate.residual;
  dls_reduction_destroy(R);
}

static void take_peer(const scene *S, double mu, double tol, double *r, double *x, result *out) {
  const double held = bench_watch_memory(), start = bench_seconds();
  const int answer = peer_solve(S, mu, tol, r, x, &out->iterations);
  out->cpu = bench_seconds() - start;
  out->bytes = bench_memory("VmHWM") - held;
  out->failed = answer < 0;
  out->factorisations = 2;
  out->status = answer ? DLS_MAX_ITERATIONS : DLS_OK;
}

static void run_trial(void *data) {
  trial *t = data;
  scene *S = &t->plan;
  scene_create(S);
  t->out->n = S->n;
  t->out->nc = S->nc;
  t->out->entries = S->model.Ks.p[S->n];
  double *mu = malloc((size_t)S->nc * sizeof *mu), *x = calloc((size_t)S->n, sizeof *x);
  double *r = calloc((size_t)(S->d * S->nc), sizeof *r);
  if (!mu || !x || !r) return;
  for (int c = 0; c < S->nc; c++)
    mu[c] = t->mu;
  if (t->w == ON_K)
    take_K(S, mu, t->tol, r, x, t->out);
  else if (t->w == PEER)
    take_peer(S, t->mu, t->tol, r, x, t->out);
  else
    take_reduction(t->w, S, mu, t->tol, t->most_bytes, r, x, t->out);
  free(mu);
  free(x);
  free(r);
  scene_free(S);
}

result run_way(way w, const scene *plan, double mu, double tol, int turns, double most_bytes) {
  result best = {.failed = 1};
  result *out = bench_shared(sizeof *out);
  trial t = {w, *plan, mu, tol, most_bytes, out};
  for (int turn = 0; out && turn < turns; turn++) {
    *out = (result){.failed = 1, .status = DLS_STALLED, .residual = NAN};
    if (bench_child(run_trial, &t)) out->failed = 1;
    if (turn == 0 || out->cpu < best.cpu) best = *out;
    if (out->failed) break;
  }
  if (out) munmap(out, sizeof *out);
  return best;
}
