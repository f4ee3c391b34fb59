/*
 * solve_lemke.c: Lemke's method on a contact problem: d = 2, the 3-row form of the LCP, after a ray the
 * 4-row form; d = 3, the faceted cone. Then Newton's method takes the answer to the round cone. The
 * certificate decides.
 */
#include <math.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include "delassus/facets.h"
#include "delassus/lcp.h"
#include "delassus/newton.h"
#include "front/front.h"

enum {
  default_facets = 8,
  most_fallback_rows = 4000, /* d = 2: of a 4-row form that create still has room for */
  polish_sweeps = 30,
  polish_rounds = 3
};

struct dlsi_pivoting {
  dls_solver_settings settings;
  int d, nc;
  dls_lemke *lemke;
  dls_nlgs *nlgs;            /* sweeps between ... */
  dls_newton *newton;        /* ... Newton steps at the end */
  int facets;                /* of the cone; d = 2: 2 */
  int n;                     /* rows there is room for */
  double *M, *q;             /* n x n, n */
  double *z;                 /* n */
  double *s;                 /* scales r_c = s_c r'_c, nc */
  double *r, *u, *a, *F, *w; /* m, m, m, m, nc */
  double *best;              /* m */
};

/* the workspace and its arrays, in one piece; n rows of the LCP */
static dlsi_pivoting *carve(dlsi_arena *arena, int d, int candidates, int rows) {
  const size_t D = sizeof(double), n = (size_t)rows, nc = (size_t)candidates, m = (size_t)d * nc;
  dlsi_pivoting *s = dlsi_take(arena, 1, sizeof *s);
  dlsi_pivoting filled = {.d = d, .nc = candidates, .n = rows};
  filled.M = dlsi_take(arena, n, n * D);
  filled.q = dlsi_take(arena, n, D);
  filled.z = dlsi_take(arena, n, D);
  filled.s = dlsi_take(arena, nc, D);
  filled.r = dlsi_take(arena, m, D);
  filled.u = dlsi_take(arena, m, D);
  filled.a = dlsi_take(arena, m, D);
  filled.F = dlsi_take(arena, m, D);
  filled.w = dlsi_take(arena, nc, D);
  filled.best = dlsi_take(arena, m, D);
  if (arena->failed || !arena->base) return NULL;
  *s = filled;
  return s;
}

static dls_status create_parts(dlsi_pivoting *work, dls_error *error) {
  const dls_solver_settings *settings = &work->settings;
  dls_lemke_settings s;
  dls_lemke_settings_init(&s);
  s.limits.tol = settings->limits.tol;
  s.limits.max_iterations = settings->limits.max_iterations;
  s.limits.warm_start = settings->limits.warm_start;
  s.limits.progress = settings->limits.progress;
  s.limits.progress_data = settings->limits.progress_data;
  dls_nlgs_settings sweeps;
  dls_nlgs_settings_init(&sweeps);
  sweeps.limits.tol = settings->limits.tol;
  sweeps.limits.max_iterations = polish_sweeps;
  sweeps.limits.warm_start = 1;
  dls_newton_settings steps;
  dls_newton_settings_init(&steps);
  steps.limits.tol = settings->limits.tol;
  steps.sweeps = 0;
  steps.limits.blocks = settings->limits.blocks;
  steps.limits.warm_start = 1;
  dls_status status = dls_lemke_create(&work->lemke, work->n, &s, error);
  if (!status) status = dls_nlgs_create(&work->nlgs, work->d, work->nc, &sweeps, error);
  if (!status) status = dls_newton_create(&work->newton, work->d, work->nc, &steps, error);
  return status;
}

dls_status dlsi_pivoting_create(dlsi_pivoting **out, int d, int nc,
                                const dls_solver_settings *settings, dls_error *error) {
  *out = NULL;
  const int facets = d == 2 ? 2 : settings->facets ? settings->facets : default_facets;
  long long n = (facets + 2) * (long long)nc;
  if (d == 2 && n > most_fallback_rows) n = 3LL * nc; /* no room for the 4-row form */
  if (n > INT32_MAX / 4) return dlsi_fail(error, DLS_E_SIZE, "nc", -1, nc, "is too large");
  dlsi_arena arena = {0};
  (void)carve(&arena, d, nc, (int)n);
  arena.size = arena.used;
  arena.used = 0;
  arena.base = arena.failed ? NULL : dlsi_alloc(arena.size, 1);
  if (!arena.base) return dlsi_no_memory(error);
  dlsi_pivoting *work = carve(&arena, d, nc, (int)n);
  work->settings = *settings;
  work->facets = facets;
  const dls_status status = create_parts(work, error);
  if (status) {
    dlsi_pivoting_destroy(work);
    return status;
  }
  *out = work;
  return DLS_OK;
}

void dlsi_pivoting_destroy(dlsi_pivoting *work) {
  if (!work) return;
  dls_lemke_destroy(work->lemke);
  dls_nlgs_destroy(work->nlgs);
  dls_newton_destroy(work->newton);
  free(work); /* first in its one piece */
}

/* Measures work->r; *best and work->best keep the one with the smallest residual. */
static void offer(dlsi_pivoting *work, const dls_contact *problem, dls_certificate *best) {
  const size_t m = (size_t)problem->d * (size_t)problem->nc;
  dls_certificate certificate;
  dlsi_contact_multiply(problem, NULL, work->r, work->u, work->a);
  dlsi_contact_measure(problem, work->r, work->u, work->a, work->w, work->F, &certificate);
  if (!(certificate.residual < best->residual)) return;
  *best = certificate;
  memcpy(work->best, work->r, m * sizeof *work->r);
}

/* Solves the LCP of facets (0: the 3-row form) in scaled unknowns, starting (warm) from the states
 * of work->z, and offers its reactions. Returns the status of the LCP, or an error. */
static dls_status pivot(dlsi_pivoting *work, const dls_contact *problem, int facets, int *pivots,
                        dls_certificate *best, dls_error *error) {
  const double *s = work->s;
  const int n = facets ? dls_contact_facets_size(problem, facets) : dls_contact_lcp_size(problem);
  dls_status status =
      facets ? dls_contact_to_facets_lcp(problem, facets, s, work->M, n, work->q, error)
             : dls_contact_to_lcp(problem, s, work->M, n, work->q, error);
  if (status) return status;
  if (facets) memset(work->z, 0, (size_t)n * sizeof *work->z);
  const dls_lcp lcp = {n, {n, n, n, work->M}, work->q};
  dls_lemke_info info;
  status = dls_lemke_solve(work->lemke, &lcp, work->z, NULL, &info, error);
  if (status < 0) return status;
  *pivots += info.pivots + info.crash_rounds;
  const dls_status mapped =
      facets ? dls_contact_from_facets_lcp(problem, facets, s, work->z, work->r, error)
             : dls_contact_from_lcp(problem, s, work->z, work->r, error);
  if (mapped) return mapped;
  offer(work, problem, best);
  return status;
}

/* From the LCP's reactions to the round cone by Newton's method; where the states of the candidates
 * cycle, Gauss-Seidel sweeps sort them out, and again. (Not from the best r so far: r = 0 may have
 * the smaller residual, but not the states.) */
static dls_status polish(dlsi_pivoting *work, const dls_contact *problem, dls_certificate *best,
                         dls_error *error) {
  const double tol = work->settings.limits.tol;
  for (int round = 1; !dls_certificate_holds(best, tol) && round <= polish_rounds; round++) {
    if (round > 1) {
      const dls_status status = dls_nlgs_solve(work->nlgs, problem, work->r, NULL, NULL, error);
      if (status < 0) return status;
      offer(work, problem, best);
    }
    const dls_status status = dls_newton_solve(work->newton, problem, work->r, NULL, NULL, error);
    if (status < 0) return status;
    offer(work, problem, best);
  }
  return DLS_OK;
}

dls_status dlsi_pivoting_solve(dlsi_pivoting *work, const dls_contact *problem, double *r,
                               double *u, dls_info *info, dls_error *error) {
  const size_t m = (size_t)problem->d * (size_t)problem->nc;
  const int flat = problem->d == 2;
  int pivots = 0;
  dls_certificate best = {.residual = INFINITY};
  dlsi_contact_weights(problem, work->w);
  if (work->settings.limits.warm_start) {
    memcpy(work->r, r, m * sizeof *r);
    offer(work, problem, &best);
    if (flat) dlsi_friction_start(problem, work->w, work->r, work->u, work->z);
  }
  memset(work->r, 0, m * sizeof *r);
  offer(work, problem, &best);
  for (int c = 0; c < problem->nc; c++)
    work->s[c] = 1 / sqrt(work->w[c]);
  dls_status status = pivot(work, problem, flat ? 0 : work->facets, &pivots, &best, error);
  if (flat && status == DLS_RAY && dls_contact_facets_size(problem, 2) <= work->n)
    status = pivot(work, problem, 2, &pivots, &best, error);
  if (status < 0) return status;
  if (!flat && status == DLS_NO_SOLUTION) status = DLS_RAY; /* the round cone holds more */
  if (status == DLS_OK || status == DLS_RAY || status == DLS_STALLED) {
    const dls_status polished = polish(work, problem, &best, error);
    if (polished) return polished;
  }
  if (dls_certificate_holds(&best, work->settings.limits.tol))
    status = DLS_OK;
  else if (status == DLS_OK)
    status = DLS_STALLED;
  memcpy(r, work->best, m * sizeof *r);
  if (u) dlsi_contact_multiply(problem, NULL, r, u, NULL);
  if (info) {
    memset(info, 0, sizeof *info);
    info->status = status;
    info->method = DLS_LEMKE;
    info->iterations = pivots;
    info->certificate = best;
  }
  return status;
}
