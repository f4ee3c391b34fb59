/*
 * body.c: the answer of the body, not of W alone: dls_reduction_solve.
 *
 *   (BY1)  r := the solution on W, x := K^-1 (f + H r)                 not where modes are held
 *   (BY2)  the certificate of the pair (x, r) on K decides             dls_reduction_certify
 *   (BY3)  where it does not hold, method auto: the problem on K itself (global/), from (x, r).
 *          Springs hold nothing there, and no precision is lost in a W that is large beside the
 *          body: soft supports, bodies that contact alone holds
 *
 * Cost: that of dls_solve, a product with K; where (BY3) is needed, factors of K + H R H^T, which
 * the reduction keeps. What can fail: (BY3) for a flexibility or a host's solver, which have no K.
 */
#include <float.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/columns.h"
#include "delassus/global.h"
#include "front/front.h"
#include "reduction/reduced.h"

/* The problem on K, kept by the reduction. Where H has no tangents, d = 2 there with r_t = 0. */
typedef struct companion {
  dls_global *global;
  int d, of_H; /* rows of a contact there and in H */
} companion;

static void companion_destroy(void *of) {
  companion *it = of;
  if (it) dls_global_destroy(it->global);
  free(it);
}

/* *out := the problem on K, which the reduction owns. */
static dls_status companion_of(dls_reduction *reduction, companion **out, dls_error *error) {
  const dlsi_reduced of = dlsi_reduction_body(reduction);
  *out = of.companion;
  if (*out) return DLS_OK;
  dlsi_columns HN = {0}, HT = {0};
  const int d = of.H->d > 1 ? of.H->d : 2;
  companion *made = calloc(1, sizeof *made);
  dls_status status = made ? DLS_OK : dlsi_no_memory(error);
  if (!status) status = dlsi_operator_columns(of.H, d, DLSI_NORMALS, &HN, error);
  if (!status) status = dlsi_operator_columns(of.H, d, DLSI_TANGENTS, &HT, error);
  dls_model model = of.K;
  model.d = d;
  model.nodes = of.H->candidates;
  if (!status) {
    model.HN = dlsi_columns_view(&HN);
    model.HT = dlsi_columns_view(&HT);
    made->d = d;
    made->of_H = of.H->d;
    status = dls_global_create(&made->global, &model, error);
  }
  dlsi_columns_free(&HN);
  dlsi_columns_free(&HT);
  if (status) {
    free(made);
    return status;
  }
  dlsi_reduction_keep(reduction, made, companion_destroy);
  *out = made;
  return DLS_OK;
}

/* (BY3) from (x, r), in what is left of the time since `begun`. Returns a status of
 * dls_global_solve. */
static dls_status solve_on_K(dls_reduction *reduction, const double *mu, const dls_limits *limits,
                             double begun, double *r, double *x, dls_info *info, dls_error *error) {
  companion *it;
  dls_status status = companion_of(reduction, &it, error);
  if (status) return status;
  const dlsi_reduced of = dlsi_reduction_body(reduction);
  const size_t nc = (size_t)of.H->candidates, d = (size_t)it->d, rows = (size_t)it->of_H;
  double *all = dlsi_alloc(2 * d * nc, sizeof *all), *gap = all ? all + d * nc : NULL;
  if (!all) return dlsi_no_memory(error);
  memset(all, 0, 2 * d * nc * sizeof *all);
  for (size_t k = 0; k < rows * nc; k++) {
    const size_t at = d * (k / rows) + k % rows;
    all[at] = r[k];
    gap[at] = of.gap[k];
  }
  dls_limits there = *limits;
  there.warm_start = 1;
  if (limits->cpu_seconds > 0) there.cpu_seconds = dlsi_clock_left(limits, begun);
  status = dls_global_solve(it->global, of.f, gap, mu, &there, all, x, info, error);
  for (size_t k = 0; status >= 0 && k < rows * nc; k++)
    r[k] = all[d * (k / rows) + k % rows];
  free(all);
  return status;
}

/* Returns the status of a solve that ended with `status`, by the certificate of the body. x carries
 * eps times the condition of K, which the rounding levels do not hold: up to 1e-8 that is
 * allowed. */
static dls_status judge_body(const dls_certificate *c, double asked, double condition,
                             dls_status status) {
  const double tol = fmax(asked, fmin(DBL_EPSILON * condition, 1e-8));
  const dls_status verdict = dls_certificate_verdict(c, tol);
  if (verdict != DLS_STALLED && status != DLS_NO_SOLUTION) return verdict;
  if (status != DLS_OK && status != DLS_TO_ROUNDING) return status;
  return c->equilibrium <= dlsi_target(tol, c->floor_e) ? DLS_STALLED : DLS_NOT_IN_EQUILIBRIUM;
}

/* Adds what was done on K to the outcome on W. */
static void add_outcome(dls_info *all, const dls_info *on_K) {
  if (all->stages == DLS_STAGES_MAX) all->stages--;
  all->stage[all->stages++] =
      (dls_stage){DLS_ADMM, on_K->iterations, on_K->factorisations, on_K->certificate.residual};
  all->iterations += on_K->iterations;
  all->factorisations += on_K->factorisations;
  all->certificate = on_K->certificate;
  all->error = 0;
  all->unique = DLS_UNIQUE_UNKNOWN;
}

/* What was said of other answers to W holds beside a certified answer alone. */
static void forget_unproved(dls_info *info) {
  if (info->status == DLS_OK || info->status == DLS_TO_ROUNDING) return;
  info->unique = DLS_UNIQUE_UNKNOWN;
  info->error = 0;
}

void dlsi_body_judge(dls_info *info, const dls_certificate *certificate, double tol,
                     double condition) {
  info->certificate = *certificate;
  info->status = judge_body(certificate, tol, condition, info->status);
  forget_unproved(info);
}

static dls_status body_solve(dls_reduction *reduction, const double *mu,
                             const dls_solver_settings *settings, double *r, double *u, double *x,
                             dls_info *info, dls_error *error) {
  const dlsi_reduced of = dlsi_reduction_body(reduction);
  dls_solver_settings s;
  dls_solver_settings_init(&s);
  if (settings) s = *settings;
  const double tol = s.limits.tol, begun = dlsi_clock_start(&s.limits);
  dls_contact problem;
  dls_reduction_info facts;
  dls_info outcome = {.method = s.method}, on_K = {.status = DLS_OK};
  dls_status status = dls_reduction_get_info(reduction, &facts, error);
  if (!status) status = dls_reduction_contact(reduction, mu, &problem, error);
  if (status) return status;
  if (!r && problem.nc > 0) return dlsi_is_null(error, "r");
  if (!x) return dlsi_is_null(error, "x");
  const size_t m = (size_t)problem.d * (size_t)problem.nc;
  const int on_K_alone = facts.modes > 0 && of.has_K && s.method == DLS_AUTO;
  double *answer = dlsi_alloc(2 * m + (size_t)of.K.n, sizeof *answer);
  if (!answer) return dlsi_no_memory(error);
  double *position = answer + m, *unknowns = position + m;
  if (s.limits.warm_start && m)
    memcpy(answer, r, m * sizeof *answer);
  else
    memset(answer, 0, m * sizeof *answer);
  if (!on_K_alone) status = dls_solve(&problem, &s, answer, NULL, &outcome, error); /* (BY1) */
  if (status >= 0) {
    const dls_status on_W = status;
    status = dls_reduction_recover(reduction, answer, unknowns, error);
    if (!status) /* (BY2) */
      status = dls_reduction_certify(reduction, problem.mu, answer, unknowns, position,
                                     &outcome.certificate, error);
    if (!status)
      status =
          on_K_alone ? DLS_STALLED : judge_body(&outcome.certificate, tol, facts.condition, on_W);
  }
  const int goes_on = (status == DLS_STALLED || status == DLS_NOT_IN_EQUILIBRIUM ||
                       status == DLS_MAX_ITERATIONS || status == DLS_NO_SOLUTION_LIKELY) &&
                      s.method == DLS_AUTO && of.has_K && m > 0 && !s.limits.max_iterations;
  if (goes_on) {
    status = solve_on_K(reduction, problem.mu, &s.limits, begun, answer, unknowns, &on_K, error);
    if (status >= 0) {
      add_outcome(&outcome, &on_K);
      const dls_status measured = dls_reduction_certify(reduction, problem.mu, answer, unknowns,
                                                        position, &outcome.certificate, error);
      status = measured ? measured : judge_body(&outcome.certificate, tol, 0, status);
    }
  }
  outcome.status = status;
  forget_unproved(&outcome);
  if (status >= 0 && m) memcpy(r, answer, m * sizeof *r);
  if (status >= 0) memcpy(x, unknowns, (size_t)of.K.n * sizeof *x);
  if (status >= 0 && u && m) memcpy(u, position, m * sizeof *u);
  if (status >= 0 && info) *info = outcome;
  free(answer);
  return status;
}

dls_status dls_reduction_judge(dls_reduction *reduction, const double *mu, const double *r,
                               const double *x, double tol, dls_info *info, dls_error *error) {
  DLSI_DOOR;
  dls_reduction_info facts;
  if (!info) return dlsi_at(__func__, dlsi_is_null(error, "info"), error);
  dls_status status = dls_reduction_get_info(reduction, &facts, error);
  dls_certificate certificate;
  if (!status) status = dls_reduction_certify(reduction, mu, r, x, NULL, &certificate, error);
  if (status) return dlsi_at(__func__, status, error);
  dlsi_body_judge(info, &certificate, tol, facts.condition);
  return info->status;
}

dls_status dls_reduction_solve(dls_reduction *reduction, const double *mu,
                               const dls_solver_settings *settings, double *r, double *u, double *x,
                               dls_info *info, dls_error *error) {
  DLSI_DOOR;
  if (!reduction) return dlsi_at(__func__, dlsi_is_null(error, "reduction"), error);
  return dlsi_at(__func__, body_solve(reduction, mu, settings, r, u, x, info, error), error);
}

const double *dls_reduction_motion(dls_reduction *reduction, int *unknown) {
  companion *it = reduction ? dlsi_reduction_body(reduction).companion : NULL;
  return it ? dls_global_motion(it->global, unknown) : NULL;
}
