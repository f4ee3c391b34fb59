/*
 * scatter.c: Newton's method from many scattered starts, d = 2 and 3, for small problems on which
 * all else fails.
 *
 * Newton's method on the friction law (newton.c) ends in a few steps where the states of the start
 * are those of a solution, or near them. Where a problem has a solution that no path leads to,
 * states drawn at random find it sooner or later.
 *
 *   (SC1)  draw shares of free and of sliding candidates, and an exponent s from (-2, 2)
 *   (SC2)  draw each candidate free, sticking (r in the cone) or sliding (r on its edge), with
 *          r_n = 10^(s + x) |q| / w_c, x from (-1, 1), |q| the largest entry
 *   (SC3)  up to 20 steps of Newton's method from there, with its line search at every other start;
 *          stop if the certificate holds
 *
 * The numbers follow from a fixed seed: the same problem takes the same starts. As many starts are
 * taken as cost some 3e8 flops, at most 1000.
 *
 * Cost: 20 LU of m x m a start. What can fail: that no start is near a solution; that proves
 * nothing.
 */
#include <float.h>
#include <math.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include "vi_internal.h"

enum { most_starts = 1000, steps_of_start = 20 };
static const double most_flops = 3e8;
static const double spread = 2; /* (SC1), decades */

typedef struct scatter {
  dls_limits limits;
  dls_newton *newton[2]; /* without and with its line search */
  double *r;             /* m: start and answer of Newton's method */
  uint64_t state;        /* of the random numbers */
  dlsi_iterate it;
} scatter;

/* Draws from (low, high) (splitmix64: Steele, Lea and Flood, OOPSLA 2014). */
static double scatter_draw(scatter *work, double low, double high) {
  uint64_t z = work->state += 0x9e3779b97f4a7c15u;
  z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9u;
  z = (z ^ (z >> 27)) * 0x94d049bb133111ebu;
  return low + (high - low) * ldexp((double)((z ^ (z >> 31)) >> 11), -53);
}

/* (SC1), (SC2) size: of q. */
static void scatter_start(scatter *work, const dls_contact *problem, double size) {
  const int d = problem->d;
  const double free = scatter_draw(work, 0, 1), slides = scatter_draw(work, 0, 1);
  const double exponent = scatter_draw(work, -spread, spread);
  for (int c = 0; c < problem->nc; c++) {
    double *r = work->r + d * c;
    const double is_free = scatter_draw(work, 0, 1), slip = scatter_draw(work, 0, 1);
    const double push = pow(10, exponent + scatter_draw(work, -1, 1)) * size / work->it.w[c];
    const double part = scatter_draw(work, 0, 1), turn = scatter_draw(work, 0, 2);
    const double t = problem->mu[c] * push * (slip < slides ? 1 : part);
    memset(r, 0, (size_t)d * sizeof *r);
    if (is_free < free) continue;
    r[0] = push;
    r[1] = d == 2 ? (turn < 1 ? t : -t) : t * cos(3.141592653589793 * turn);
    if (d == 3) r[2] = t * sin(3.141592653589793 * turn);
  }
}

static dls_status scatter_solve(void *scatter_work, const dls_contact *problem, double *r,
                                double *u, dls_info *info, dls_error *error) {
  scatter *work = scatter_work;
  dlsi_iterate *it = &work->it;
  dls_info outcome = {.method = DLS_NEWTON}, steps;
  const size_t m = (size_t)problem->d * (size_t)problem->nc;
  const double size = dlsi_max_abs(problem->q, m), cube = (double)m * (double)m * (double)m;
  const double starts = fmin(most_starts, most_flops / (steps_of_start * cube));
  const dls_limits limits = {.tol = work->limits.tol,
                             .max_iterations = steps_of_start,
                             .warm_start = 1,
                             .cpu_seconds = dlsi_no_clock};
  for (int k = 0; k < 2; k++)
    dlsi_newton_method.set_limits(work->newton[k], &limits);
  dlsi_iterate_begin(it, problem, NULL, work->limits.tol, work->limits.warm_start, r, work->r);
  dls_status status = dlsi_iterate_start(it, problem, work->r) ? DLS_OK : DLS_STALLED;
  work->state = 0;
  for (int k = 0; k < starts && status == DLS_STALLED; k++) {
    scatter_start(work, problem, size);
    status = dlsi_newton_run(work->newton[k % 2], problem, NULL, work->r, NULL, &steps, error);
    if (status < 0) return status;
    outcome.iterations += steps.iterations;
    outcome.factorisations += steps.factorisations;
    status = dlsi_iterate_keep(it, problem, work->r, &steps.certificate) ? DLS_OK : DLS_STALLED;
    if (status == DLS_OK) break;
    status =
        dlsi_iterate_tell(it, "scatter", outcome.iterations, 0, it->certificate.residual, it->best);
    if (status == DLS_OK) status = DLS_STALLED;
    if (status == DLS_STALLED && work->limits.max_iterations &&
        outcome.iterations >= work->limits.max_iterations)
      status = DLS_MAX_ITERATIONS;
  }
  return dlsi_iterate_end(it, problem, status, &outcome, r, u, info);
}

/* ---- create ---------------------------------------------------------------------------------- */

static void scatter_carve(void *scatter_work, dlsi_arena *arena) {
  scatter *work = scatter_work;
  work->r = dlsi_take(arena, (size_t)work->it.d * (size_t)work->it.nc, sizeof *work->r);
  dlsi_iterate_carve(&work->it, arena, work->it.d, work->it.nc, &work->limits);
}

static void scatter_destroy(void *scatter_work) {
  scatter *work = scatter_work;
  if (!work) return;
  for (int k = 0; k < 2; k++)
    dls_newton_destroy(work->newton[k]);
  free(work);
}

static void scatter_set_limits(void *scatter_work, const dls_limits *limits) {
  dlsi_set_limits(&((scatter *)scatter_work)->limits, limits);
}

static dls_status scatter_create(void **out, int d, int nc, const dlsi_options *options,
                                 dls_error *error) {
  scatter filled = {.limits = options->limits, .it = {.d = d, .nc = nc}};
  void *memory;
  dls_status status = dlsi_workspace(&memory, &filled, sizeof filled, scatter_carve, nc, error);
  if (status) return status;
  scatter *work = memory;
  for (int k = 0; !status && k < 2; k++) {
    dls_newton_settings steps;
    dls_newton_settings_init(&steps);
    steps.sweeps = 0;
    steps.line_search = k;
    steps.limits.warm_start = 1;
    steps.limits.blocks = options->limits.blocks;
    status = dlsi_newton_create(&work->newton[k], d, nc, &steps, options->room, error);
  }
  if (status)
    scatter_destroy(work);
  else
    *out = work;
  return status;
}

/* A stage of auto alone, which has no number among the methods: its steps are Newton's. */
const dlsi_method dlsi_scatter_method = {
    .method = DLS_NEWTON,
    .name = "scatter",
    .summary = "2D, 3D, small: Newton's method from many scattered starts",
    .create = scatter_create,
    .solve = scatter_solve,
    .destroy = scatter_destroy,
    .set_limits = scatter_set_limits,
};
