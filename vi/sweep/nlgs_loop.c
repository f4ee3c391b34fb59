/*
 * nlgs_loop.c: sweeps of Gauss-Seidel (nlgs.c) until the certificate holds.
 *
 *   start     r on its cones; its certificate
 *   repeat    (NL6)-(NL8) another start of the sweep     (nlgs_ways.c, nlgs_sets.c)
 *             (NL0)-(NL4) the sweep                      (nlgs_sweep.c)
 *             the residual, from the current u           (nlgs_estimate.c)
 *             (NL5) u and the certificate afresh, if they are due
 *             (NL12) another variant                     (nlgs_ways.c)
 *             (NL13) the contacts that act               (nlgs_active.c)
 *
 * Both parts of the residual are estimated after each sweep. If W is not dense, without (NL6), and
 * from 1000 contacts on or in groups, they are estimated after every fifth one.
 *
 *   (NL5)  u and the certificate are recomputed from the user's W and q if each part meets its
 *          target, max(tol, 4 floor), if a sweep changes nothing, and every 50 sweeps. If a sweep
 *          from a fresh u changes nothing and is not solved, none will: DLS_STALLED.
 *          A call that ends early returns the best r
 */
#include <float.h>
#include <limits.h>
#include <math.h>
#include <string.h>

#include "nlgs_work.h"

enum { most_sweeps = 10000, refresh_every = 50 };
enum { seldom = 5 };                        /* sweeps from one estimate to the next */
enum { often_first = 20, look_every = 20 }; /* (NL13): sweeps between looks at all contacts */

/* Recomputes u in the order of the visits, so that its bits do not depend on the numbers: sweeps go
 * on from it. */
static void nlgs_refresh(const dls_nlgs *work, const dls_contact *problem, const double *r) {
  if (work->order) dlsi_multiply(problem, work->order, work->it.E, r, work->it.u, NULL);
}

/* Projects r on its cones, so that r_n = 0 means r_c = 0 (NL0). Returns 1 if that moved r by more
 * than rounding. */
static int nlgs_project_start(const dls_contact *problem, double *r) {
  const size_t d = (size_t)problem->d;
  int outside = 0;
  for (int c = 0; c < problem->nc; c++) {
    double *rc = r + d * (size_t)c, v[3], size = 0, moved = 0;
    memcpy(v, rc, d * sizeof *v);
    (void)dlsi_project_cone(problem->d, problem->mu[c], v, rc);
    for (size_t i = 0; i < d; i++) {
      size += fabs(v[i]);
      moved += fabs(rc[i] - v[i]);
    }
    outside |= !(moved <= 8 * DBL_EPSILON * size);
  }
  return outside;
}

/* Sets W_cc (+ E_c) of all contacts, for sweeps one by one. */
static void nlgs_set_blocks(dls_nlgs *work, const dls_contact *problem, const double *E) {
  const size_t d = (size_t)problem->d;
  for (int c = 0; c < problem->nc; c++) {
    double W[9];
    dlsi_contact_diagonal(problem, c, W);
    for (size_t i = 0; E && i < d; i++)
      W[(d + 1) * i] += E[c];
    if (d == 1)
      work->block_1d[c] = W[0];
    else if (d == 2)
      dlsi_block_2d_set(&work->block_2d[c], W, problem->mu[c]);
    else
      dlsi_block_3d_set(&work->block_3d[c], W, problem->mu[c]);
  }
}

/* Makes the groups of all contacts if the next sweep needs them: (NL13) begins without. Sweeps go
 * one by one if they do not pay. DLS_E_MEMORY. */
static dls_status nlgs_widen(dls_nlgs *work, const dls_contact *problem) {
  if (work->narrow || work->whole || !work->grouped) return DLS_OK;
  const dls_status status = dlsi_groups_set(&work->groups, problem, work->slabs.set, NULL, NULL);
  work->grouped = work->whole = !status && work->groups.count > 0;
  if (!work->grouped) nlgs_set_blocks(work, problem, NULL);
  return status;
}

/* Sweeps from r until the certificate holds. Returns DLS_OK, or the reason to stop before; it.u
 * then belongs to it.best. *iterations: sweeps done. */
static dls_status nlgs_iterate(dls_nlgs *work, const dls_contact *problem, double *r,
                               int *iterations) {
  const dls_limits *limits = &work->settings.limits;
  dlsi_iterate *it = &work->it;
  const int most = dlsi_most_iterations(limits, most_sweeps);
  const int pushed = work->settings.acceleration == DLS_ACCELERATION_MOMENTUM;
  const size_t m = (size_t)problem->d * (size_t)problem->nc;
  const double scale = 1 / dlsi_norm2(problem->q, m);
  if (dlsi_iterate_start(it, problem, r)) return DLS_OK;
  dls_certificate now = it->certificate;
  if (nlgs_project_start(problem, r)) now = dlsi_iterate_offer(it, problem, r);
  if (dls_certificate_holds(&now, it->tol)) return DLS_OK;
  const int before = pushed ? dlsi_nlgs_resume(work, problem, r) : 0; /* (NL14) */
  if (!before) {
    nlgs_refresh(work, problem, r);
    dlsi_nlgs_begin_ways(work, problem, r);
  }
  if (before) dlsi_nlgs_estimate(work, problem, r, scale, 1, &now);
  if (pushed) dlsi_nlgs_narrow(work, problem, r); /* (NL13) */
  const int often = problem->W.a || (problem->nc < dlsi_few_candidates && !work->grouped);
  double accepted = before ? work->left.accepted : now.residual;
  int fresh = 1, changed = before ? work->left.changed : 0; /* fresh: u has no rounding of sweeps */
  const int last = before > INT_MAX - most ? INT_MAX - 1 : before + most;
  int turn;
  dls_status reason = DLS_MAX_ITERATIONS;
  for (int k = before + 1; k <= last && reason == DLS_MAX_ITERATIONS; k++) {
    const int looks = often || work->now == DLSI_WAY_ANDERSON ? 1 : seldom;
    if (work->now == DLSI_WAY_ANDERSON && changed) {
      dlsi_nlgs_accelerate(work, problem, now.residual, scale, &accepted, r);
      fresh = 0;
    }
    if (pushed && work->now != DLSI_WAY_ANDERSON && changed) { /* (NL8), (NL9) */
      if (!dlsi_nlgs_push(work, problem, k, now.residual, r)) {
        reason = DLS_STALLED;
        break;
      }
      fresh = 0;
    }
    if (nlgs_widen(work, problem)) return DLS_E_MEMORY;
    changed = dlsi_nlgs_sweep(work, problem, dlsi_nlgs_all(work, problem), r);
    work->sweeps++;
    *iterations = k - before;
    if (changed && k % looks && k < last) {
      fresh = 0;
      continue;
    }
    const int everywhere = !work->narrow || k <= often_first || k % look_every == 0;
    dlsi_nlgs_estimate(work, problem, r, scale, everywhere, &now);
    const int was_fresh = fresh;
    fresh = !changed || dlsi_certificate_meets(&now, it->tol) || k % refresh_every == 0;
    if (fresh) now = dlsi_iterate_measure(it, problem, r); /* (NL5) */
    if (dlsi_iterate_keep(it, problem, r, &now)) return DLS_OK;
    if (fresh) nlgs_refresh(work, problem, r);
    if (pushed && (everywhere || fresh)) dlsi_nlgs_narrow(work, problem, r); /* (NL13) */
    const dls_status stop = dlsi_iterate_tell(it, "nlgs", k - before, most, now.residual, r);
    if (stop)
      reason = stop;
    else if ((!changed && was_fresh) || dlsi_iterate_is_lost(now.residual))
      reason = DLS_STALLED;
    else if (pushed && (turn = dlsi_nlgs_change_way(work, problem, now.residual, looks, r)) > 0) {
      accepted = INFINITY;
      changed = turn > 1;
      fresh = 0;
    }
  }
  if (reason != DLS_STALLED)
    dlsi_nlgs_leave(work, problem, before + *iterations, changed, accepted, r);
  return dlsi_iterate_settle(it, problem, reason);
}

dls_status dlsi_nlgs_run(dls_nlgs *work, const dls_contact *problem, const int *order,
                         const double *E, double *r, double *u, dls_info *info) {
  const dls_limits *limits = &work->settings.limits;
  if (!work->grouped) nlgs_set_blocks(work, problem, E);
  work->order = order;
  dlsi_iterate_begin(&work->it, problem, E, limits->tol, work->stage || limits->warm_start, r, r);
  dls_info outcome = {.method = DLS_NLGS};
  const dls_status status = nlgs_iterate(work, problem, r, &outcome.iterations);
  return dlsi_iterate_end(&work->it, problem, status, &outcome, r, u, info);
}
