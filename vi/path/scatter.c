/*
 * scatter.c: Newton's method from many scattered starts, d = 2 and 3, for small problems on which
 * all else fails.
 *
 * Newton's method on the friction law (newton.c) ends in a few steps if the states of the start are
 * those of a solution, or near them. If no path leads to a solution, states drawn at random find it
 * sooner or later.
 *
 *   (SC1)  draw a state for each contact, free, stick, or slip in some direction t; the shares
 *          are drawn, too. Every other start takes the states of the best r so far and draws one
 *          or a few of them again
 *   (SC2)  r solves the smallest linear problem of these states: u_n = 0, r_t = mu r_n t for slip,
 *          u = 0 for stick; W_cc is raised by 1e-6 w_c, so that a W of low rank has an answer. In
 *          slip an r_n < 0 changes its sign
 *   (SC3)  up to 20 Newton steps from there, with line search in the third and fourth of every four
 *          starts; stop if the certificate holds
 *
 * A fixed seed gives the same problem the same starts: as many as cost some 3e9 flops, at most
 * 2000. auto takes an eighth of them first, and the rest last.
 *
 * Cost of a start: 21 LU of up to m x m. What can fail: no start is near a solution, which proves
 * nothing.
 */
#include <float.h>
#include <math.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include "linear/dense.h"
#include "vi/vi_internal.h"

enum { most_starts = 2000, steps_of_start = 20 };
static const double most_flops = 3e9;
static const double on_edge = 1e-6; /* a reaction this close to the edge of its cone slips */
static const double shift = 1e-6;   /* (SC2), of w_c */

typedef struct scatter {
  dls_limits limits;
  dls_newton *newton[2]; /* without and with its line search */
  double *r;             /* m: start and answer of Newton's method */
  double *b;             /* m */
  int *first, *pivot;    /* nc + 1, m */
  dlsi_room *room;
  uint64_t state; /* of the random numbers */
  dlsi_iterate it;
} scatter;

/* Draws from (low, high). */
static double scatter_draw(scatter *work, double low, double high) {
  work->state += DLSI_GOLDEN_BITS;
  return low + (high - low) * dlsi_draw(work->state);
}

/* Sets r to the code of a state: (1, mu t) for slip along t, (1, 0) for stick, 0 for free. */
static void scatter_draw_state(scatter *work, int d, double mu, double free, double slides,
                               double *r) {
  const double is_free = scatter_draw(work, 0, 1), slip = scatter_draw(work, 0, 1);
  const double turn = scatter_draw(work, 0, 2);
  memset(r, 0, (size_t)d * sizeof *r);
  if (is_free < free) return;
  r[0] = 1;
  if (!(slip < slides) || d == 1) return;
  r[1] = d == 2 ? (turn < 1 ? mu : -mu) : mu * cos(3.141592653589793 * turn);
  if (d == 3) r[2] = mu * sin(3.141592653589793 * turn);
}

/* (SC1) r := newly drawn states. */
static void scatter_anew(scatter *work, const dls_contact *problem) {
  const double free = scatter_draw(work, 0, 1), slides = scatter_draw(work, 0, 1);
  for (int c = 0; c < problem->nc; c++)
    scatter_draw_state(work, problem->d, problem->mu[c], free, slides, work->r + problem->d * c);
}

/* (SC1) r := the states of the best r, some drawn again. */
static void scatter_near(scatter *work, const dls_contact *problem) {
  const int d = problem->d, nc = problem->nc;
  for (int c = 0; c < nc; c++) {
    const double *best = work->it.best + d * c, mu = problem->mu[c];
    const double t = dlsi_tangent_norm(d, best);
    double *r = work->r + d * c;
    memset(r, 0, (size_t)d * sizeof *r);
    if (!(best[0] > 0)) continue;
    r[0] = 1;
    for (int i = 1; i < d && t >= (1 - on_edge) * mu * best[0] && t > 0; i++)
      r[i] = mu * best[i] / t;
  }
  do {
    const int c = (int)scatter_draw(work, 0, nc);
    scatter_draw_state(work, d, problem->mu[c], 1. / 3, 0.5, work->r + d * c);
  } while (scatter_draw(work, 0, 1) < 0.5);
}

/* first[c] := the first unknown of contact c: none if it is free, the size of r_c if it slips, d if
 * it sticks. */
static void scatter_number(scatter *work, const dls_contact *problem) {
  const int d = problem->d;
  int k = 0;
  for (int c = 0; c < problem->nc; c++) {
    const double *r = work->r + d * c;
    const int slips = !(problem->mu[c] > 0) || dlsi_tangent_norm(d, r) > 0;
    work->first[c] = k;
    k += !(r[0] > 0) ? 0 : slips ? 1 : d;
  }
  work->first[problem->nc] = k;
}

/* Fills the matrix and the right side b of (SC2). */
static void scatter_fill(scatter *work, const dls_contact *problem) {
  const int d = problem->d, nc = problem->nc, *first = work->first;
  const size_t n = (size_t)first[nc], m = (size_t)d * (size_t)nc;
  double *column = work->room->J, *u = work->it.u;
  work->room->owner = work;
  for (int c = 0; c < nc; c++)
    for (int j = first[c]; j < first[c + 1]; j++, column += n) {
      const int part = j - first[c];
      double e[3] = {0};
      e[part] = 1;
      if (first[c + 1] - first[c] == 1) memcpy(e, work->r + d * c, (size_t)d * sizeof *e);
      memset(u, 0, m * sizeof *u);
      dlsi_contact_add_columns(problem, c, e, u);
      for (int a = 0; a < nc; a++)
        for (int i = first[a]; i < first[a + 1]; i++)
          column[i] = u[d * a + i - first[a]];
      column[j] += shift * work->it.w[c];
      work->b[j] = -problem->q[d * c + part];
    }
}

/* (SC2) r := the start for the states coded in r. Returns 0 if there is none. */
static int scatter_start(scatter *work, const dls_contact *problem) {
  const int d = problem->d, nc = problem->nc;
  scatter_number(work, problem);
  const int *first = work->first, k = first[nc];
  if (k == 0) return 0;
  scatter_fill(work, problem);
  dlsi_dense factors = {.n = k, .A = work->room->J, .pivot = work->pivot};
  if (dlsi_dense_lu(&factors)) return 0;
  dlsi_dense_solve(&factors, work->b, k, 1);
  for (int c = 0; c < nc; c++) {
    const double *b = work->b + first[c];
    const int sticks = first[c + 1] - first[c] > 1;
    for (int i = 0; i < d && first[c + 1] > first[c]; i++)
      work->r[d * c + i] = sticks ? b[i] : work->r[d * c + i] * fabs(b[0]);
  }
  return dlsi_max_abs(work->r, (size_t)(d * nc)) <= DBL_MAX;
}

static dls_status scatter_solve(void *scatter_work, const dls_contact *problem, double *r,
                                double *u, dls_info *info, dls_error *error) {
  scatter *work = scatter_work;
  dlsi_iterate *it = &work->it;
  dls_info outcome = {.method = DLS_NEWTON}, steps;
  const size_t m = (size_t)problem->d * (size_t)problem->nc;
  const double cube = (double)m * (double)m * (double)m;
  const double starts = fmin(most_starts, most_flops / (steps_of_start * cube));
  const dls_limits limits = {.tol = work->limits.tol,
                             .max_iterations = steps_of_start,
                             .warm_start = 1,
                             .cpu_seconds = dlsi_no_clock};
  for (int k = 0; k < 2; k++)
    dlsi_set_limits(&dlsi_newton_method, work->newton[k], &limits);
  dlsi_iterate_begin(it, problem, NULL, work->limits.tol, work->limits.warm_start, r, work->r);
  dls_status status = dlsi_iterate_start(it, problem, work->r) ? DLS_OK : DLS_STALLED;
  if (status == DLS_STALLED) {
    const dls_status room = dlsi_room_dense(work->room, m, error);
    if (room) return room;
  }
  work->state = 0;
  for (int k = 0; k < starts && status == DLS_STALLED; k++) {
    if (k % 2 == 0)
      scatter_anew(work, problem);
    else
      scatter_near(work, problem);
    if (!scatter_start(work, problem)) continue;
    status = dlsi_newton_run(work->newton[k / 2 % 2], problem, NULL, work->r, NULL, &steps, error);
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
  const size_t m = (size_t)work->it.d * (size_t)work->it.nc;
  work->r = dlsi_take(arena, m, sizeof *work->r);
  work->b = dlsi_take(arena, m, sizeof *work->b);
  work->first = dlsi_take(arena, (size_t)work->it.nc + 1, sizeof *work->first);
  work->pivot = dlsi_take(arena, m, sizeof *work->pivot);
  dlsi_iterate_carve(&work->it, arena, work->it.d, work->it.nc, &work->limits);
}

static void scatter_destroy(void *scatter_work) {
  scatter *work = scatter_work;
  if (!work) return;
  for (int k = 0; k < 2; k++)
    dls_newton_destroy(work->newton[k]);
  free(work);
}

static dls_status scatter_create(void **out, int d, int nc, const dlsi_options *options,
                                 dls_error *error) {
  scatter filled = {.limits = options->limits, .room = options->room, .it = {.d = d, .nc = nc}};
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

/* A stage of auto only, without a number among the methods: its steps are Newton's. */
const dlsi_method dlsi_scatter_method = {
    .method = DLS_NEWTON,
    .name = "scatter",
    .summary = "2D, 3D, small: Newton's method from many scattered starts",
    .create = scatter_create,
    .solve = scatter_solve,
    .destroy = scatter_destroy,
    .limits = offsetof(scatter, limits),
};
