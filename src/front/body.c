/*
 * body.c: the answer of the body, not only of W: dls_reduction_solve.
 *
 *   (BY1)  r := the solution on W, x := K^-1 (f + H r)
 *   (BY2)  the certificate of the pair (x, r) on K decides             dls_reduction_certify
 *   (BY3)  if it does not hold, method auto: the problem on K itself (global/), from (x, r). It
 *          loses no precision in a W that is large compared with the body: soft supports
 *   (BY4)  dls_reduction_create: (BY3) at once, and no W, if an estimate finds that cheaper, K is
 *          singular (bodies that only contact holds), or W is beyond the limit of memory
 *
 * Cost: that of dls_solve, a product with K; for (BY3) factors of K + H R H^T, which the reduction
 * keeps. What can fail: (BY3) for a flexibility or a host's solver, which have no K.
 */
#include <float.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "contact/columns.h"
#include "delassus/global.h"
#include "front/front.h"
#include "global/solved.h"
#include "reduction/reduced.h"

/* The problem on K, kept by the reduction. If H has no tangents, it has d = 2 with r_t = 0. */
typedef struct companion {
  dls_global *global;
  int d, of_H; /* rows of a contact on K and in H */
  double *x;   /* n: of the last solve, the start of the next one */
} companion;

static void companion_destroy(void *of) {
  companion *it = of;
  if (!it) return;
  dls_global_destroy(it->global);
  free(it->x);
  free(it);
}

/* Creates it, or gives it the values of an update; another pattern needs a new one. */
static dls_status companion_fill(companion *it, const dls_model *model, dls_error *error) {
  if (it->global && !dls_global_update(it->global, model, error)) return DLS_OK;
  dls_global_destroy(it->global);
  it->global = NULL;
  return dls_global_create(&it->global, model, error);
}

/* *out := the problem on K, which the reduction owns. */
static dls_status companion_of(dls_reduction *reduction, companion **out, dls_error *error) {
  const dlsi_reduced of = dlsi_reduction_body(reduction);
  *out = of.companion;
  if (*out && !of.is_stale) return DLS_OK;
  dlsi_columns HN = {0}, HT = {0};
  const int d = of.H->d > 1 ? of.H->d : 2;
  companion *made = *out ? *out : calloc(1, sizeof *made);
  if (made && !made->x) made->x = calloc((size_t)of.K.n, sizeof *made->x);
  dls_status status = made && made->x ? DLS_OK : dlsi_no_memory(error);
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
    status = companion_fill(made, &model, error);
  }
  dlsi_columns_free(&HN);
  dlsi_columns_free(&HT);
  if (status) {
    if (!*out) companion_destroy(made);
    return status;
  }
  dlsi_reduction_keep(reduction, made, companion_destroy);
  *out = made;
  return DLS_OK;
}

/* ---- W or K ---------------------------------------------------------------------------------- */

/* Seconds of a 3 GHz core, only for the choice: rates of dense products and of memory; of ordering
 * and analysis per entry of K. */
static const double dense_rate = 2e10, memory_rate = 1e10, per_analysed = 1.5e-7;
enum { sweeps_on_W = 60, steps_on_K = 35, small_on_W = 100 };

/* Returns the cost that W has and K has not: forming W and `loads` solves on it. */
static double cost_of_W(const dlsi_reduced *of, int loads) {
  const double m = (double)of->H->d * of->H->candidates, b = of->H->kept;
  const double form = 2 * b * b * b / dense_rate;
  const double solve = sweeps_on_W * sizeof(double) * m * m / memory_rate + m * m * m / dense_rate;
  return form + loads * solve;
}

static double entries_of_K(const dls_model *K) {
  return K->operator_kind == DLS_STIFFNESS_SPARSE ? (double)K->Ks.p[K->n] : (double)K->n * K->n;
}

/* *better := 1 if K is estimated to be cheaper than W. Both take a factor and an analysis. The
 * reduction is on K. Its companion, the analysis, is created only if W costs more than that. */
static dls_status foresee(dls_reduction *reduction, int loads, int *better, dls_error *error) {
  const dlsi_reduced of = dlsi_reduction_body(reduction);
  const double analysis = per_analysed * entries_of_K(&of.K), of_W = cost_of_W(&of, loads);
  companion *it;
  dls_global_info info;
  *better = 0;
  if (of_W <= 2 * analysis) return DLS_OK;
  dls_status status = companion_of(reduction, &it, error);
  if (status == DLS_E_UNSUPPORTED) return DLS_OK; /* an unsymmetric K without MUMPS */
  if (!status) status = dls_global_get_info(it->global, &info, error);
  if (status) return status;
  const double of_K = loads * (steps_on_K * info.step_bytes / memory_rate);
  *better = of_K < of_W;
  return status;
}

static dls_status create_on(dls_reduction **out, const dls_model *model,
                            const dls_reduction_settings *settings, dls_on on, dls_error *error) {
  dls_reduction_settings s = *settings;
  s.on = on;
  return dlsi_reduction_create(out, model, &s, error);
}

/* Refuses a problem on K that needs more than the limit. */
static dls_status check_memory_on_K(dls_reduction *reduction, double limit, dls_error *error) {
  companion *it;
  dls_global_info info;
  dls_status status = limit > 0 ? companion_of(reduction, &it, error) : DLS_OK;
  if (status || limit == 0) return status;
  status = dls_global_get_info(it->global, &info, error);
  if (status || info.bytes <= limit) return status;
  return dlsi_fail(error, DLS_E_MEMORY, "memory_limit", -1, info.bytes,
                   "%.3g GB needed on K, which takes less than W; limit %.3g", 1e-9 * info.bytes,
                   1e-9 * limit);
}

/* Replaces the reduction to K, if there is one, by that to W. If K is singular or W beyond the
 * limit, it stays on K. */
static dls_status take_W(dls_reduction **out, const dls_model *model,
                         const dls_reduction_settings *settings, dls_error *error) {
  dls_reduction *on_W = NULL;
  dls_error why = {0};
  dls_status status = create_on(&on_W, model, settings, DLS_ON_W, &why);
  const int limited = status == DLS_E_MEMORY && strcmp(why.argument, "memory_limit") == 0;
  if (status == DLS_E_SINGULAR || limited) {
    dls_error none = {0};
    const dls_status on_K = *out ? DLS_OK : create_on(out, model, settings, DLS_ON_K, &none);
    if (!on_K) return limited ? check_memory_on_K(*out, settings->memory_limit, error) : DLS_OK;
    if (on_K != DLS_E_UNSUPPORTED) { /* that of a flexibility, which has no K */
      status = on_K;
      why = none;
    }
  }
  if (status < 0 && error) *error = why;
  dls_reduction_destroy(*out);
  *out = on_W;
  return status;
}

dls_status dlsi_body_foresee(dls_reduction *reduction, int *better, dls_error *error) {
  const dlsi_operator *H = dlsi_reduction_body(reduction).H;
  *better = 0;
  if ((double)H->d * H->candidates <= small_on_W) return DLS_OK;
  const dls_status status = foresee(reduction, 1, better, error);
  dlsi_reduction_keep(reduction, NULL, NULL);
  return status;
}

/* Returns 1 if W is taken without a look at the costs: for few contacts, a given
 * surface, or if W is not formed. */
static int prefers_W(const dls_model *model, const dls_reduction_settings *settings) {
  const int candidates = model->P.p ? model->P.cols : model->nodes;
  return !settings->form_W || settings->surface_count > 0 ||
         (double)model->d * candidates <= small_on_W;
}

static dls_status body_create(dls_reduction **out, const dls_model *model,
                              const dls_reduction_settings *settings, dls_error *error) {
  dls_reduction_settings defaults;
  dls_reduction_settings_init(&defaults);
  if (!settings) settings = &defaults;
  if (!out || !model || settings->on != DLS_ON_EITHER)
    return dlsi_reduction_create(out, model, settings, error);
  int better = 0;
  dls_status status = DLS_OK;
  *out = NULL;
  if (!prefers_W(model, settings)) {
    status = create_on(out, model, settings, DLS_ON_K, error);
    if (status == DLS_E_UNSUPPORTED) return create_on(out, model, settings, DLS_ON_W, error);
    if (!status) status = foresee(*out, settings->loads, &better, error);
  }
  if (!status)
    status = better ? check_memory_on_K(*out, settings->memory_limit, error)
                    : take_W(out, model, settings, error);
  if (!status) return DLS_OK;
  dls_reduction_destroy(*out);
  *out = NULL;
  return status;
}

dls_status dls_reduction_create(dls_reduction **out, const dls_model *model,
                                const dls_reduction_settings *settings, dls_error *error) {
  DLSI_DOOR;
  return dlsi_at(__func__, body_create(out, model, settings, error), error);
}

/* ---- the solve ------------------------------------------------------------------------------- */

/* (BY3) from (x, r), or without W from the last x and r, or from 0; in the rest of the time since
 * `begun`. unread: info->error stays 0. Returns a status of dls_global_solve. */
static dls_status solve_on_K(dls_reduction *reduction, const double *mu, const dls_limits *limits,
                             double begun, int unread, double *r, double *x, dls_info *info,
                             dls_error *error) {
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
  there.warm_start = limits->warm_start || !of.on_K;
  if (limits->cpu_seconds > 0) there.cpu_seconds = dlsi_clock_left(limits, begun);
  if (of.on_K) memcpy(x, it->x, (size_t)of.K.n * sizeof *x);
  dlsi_global_leave_error(it->global, unread);
  status = dls_global_solve(it->global, of.f, gap, mu, &there, all, x, info, error);
  if (status >= 0) memcpy(it->x, x, (size_t)of.K.n * sizeof *x);
  for (size_t k = 0; status >= 0 && k < rows * nc; k++)
    r[k] = all[d * (k / rows) + k % rows];
  free(all);
  return status;
}

/* Returns the status of a solve that ended with `status`, by the certificate of the body. x has an
 * error of eps times the condition of K, which the rounding levels do not include: up to 1e-8 is
 * allowed. */
static dls_status judge_body(const dls_certificate *c, double asked, double condition,
                             dls_status status) {
  const double tol = fmax(asked, fmin(DBL_EPSILON * condition, 1e-8));
  const dls_status verdict = dlsi_certificate_verdict(c, tol);
  if (verdict != DLS_STALLED && status != DLS_NO_SOLUTION) return verdict;
  if (status != DLS_OK && status != DLS_TO_ROUNDING) return status;
  return c->equilibrium <= dlsi_target(tol, c->floor_e) ? DLS_STALLED : DLS_NOT_IN_EQUILIBRIUM;
}

dls_reason dlsi_body_reason(dls_status status) {
  return status == DLS_OK || status == DLS_TO_ROUNDING ? DLS_REASON_SOLVED
         : status == DLS_CANCELLED                     ? DLS_REASON_CANCELLED
         : status == DLS_TIME_LIMIT                    ? DLS_REASON_TIME
         : status == DLS_MAX_ITERATIONS                ? DLS_REASON_ITERATIONS
         : status == DLS_NO_SOLUTION                   ? DLS_REASON_NO_SOLUTION
                                                       : DLS_REASON_NO_PROGRESS;
}

/* Adds the outcome on K, which ended with `status`, to the outcome on W. */
static void add_outcome(dls_info *all, const dls_info *on_K, dls_reduction *reduction,
                        dls_status status) {
  const companion *it = dlsi_reduction_body(reduction).companion;
  double residual;
  const int scattered = dlsi_global_scattered(it->global, &residual);
  const dls_stage stages[] = {
      {.method = DLS_ADMM,
       .iterations = on_K->iterations,
       .factorisations = on_K->factorisations - scattered,
       .residual = scattered ? residual : on_K->certificate.residual,
       .step = DLS_STEP_ON_K,
       .reason = scattered ? DLS_REASON_NO_PROGRESS : dlsi_body_reason(status)},
      {.method = DLS_NEWTON,
       .iterations = scattered,
       .factorisations = scattered,
       .residual = on_K->certificate.residual,
       .step = DLS_STEP_SCATTER,
       .reason = status == DLS_STALLED || status == DLS_NOT_IN_EQUILIBRIUM
                     ? DLS_REASON_SPENT
                     : dlsi_body_reason(status)}};
  for (int k = 0; k < (scattered ? 2 : 1); k++) {
    if (all->stages == DLS_STAGES_MAX) all->stages--;
    all->stage[all->stages++] = stages[k];
    all->iterations += stages[k].iterations;
  }
  all->factorisations += on_K->factorisations;
  all->certificate = on_K->certificate;
  all->error = 0;
  all->unique = DLS_UNIQUE_UNKNOWN;
  all->forces = DLS_FORCES_ANY;
}

/* Removes what info reports about other answers on W: it is true only with a certified answer. */
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

/* (BY1), (BY2): answer := r, unknowns := x. *outcome gets the certificate of the body. Returns the
 * status by it. */
static dls_status solve_on_W(dls_reduction *reduction, const double *mu,
                             const dls_solver_settings *settings, double condition, double *answer,
                             double *unknowns, double *position, dls_info *outcome,
                             dls_error *error) {
  dls_contact problem;
  dls_status status = dls_reduction_contact(reduction, mu, &problem, error);
  if (status) return status;
  const dls_status on_W = dls_solve(&problem, settings, answer, NULL, outcome, error);
  if (on_W < 0) return on_W;
  status = dls_reduction_recover(reduction, answer, unknowns, error);
  if (!status)
    status = dlsi_reduction_certify(reduction, mu, answer, unknowns, settings->limits.tol, position,
                                    &outcome->certificate, error);
  return status ? status : judge_body(&outcome->certificate, settings->limits.tol, condition, on_W);
}

/* Refuses arguments that the problem on K does not take. */
static dls_status check_on_K(const dlsi_reduced *of, const double *mu,
                             const dls_solver_settings *settings, dls_error *error) {
  if (settings->method != DLS_AUTO)
    return dlsi_fail(error, DLS_E_UNSUPPORTED, "method", -1, settings->method,
                     "needs W; this reduction solves on K, by method auto");
  const char *of_W = settings->plan      ? "plan"
                     : settings->without ? "without"
                     : settings->forces  ? "forces"
                                         : NULL;
  if (of_W)
    return dlsi_fail(error, DLS_E_UNSUPPORTED, of_W, -1, 0, "needs W; this reduction solves on K");
  return dlsi_check_friction(mu, (size_t)of->H->candidates, error);
}

/* Returns 1 if the last solve on K has measured its answer more precisely than x in doubles is. */
static int is_split(dls_reduction *reduction) {
  const companion *it = dlsi_reduction_body(reduction).companion;
  return it && dlsi_global_is_split(it->global);
}

/* u := H^T x + g */
static void look_at(const dlsi_reduced *of, const double *x, double *u) {
  const dlsi_columns *Ht = &of->H->Ht;
  memcpy(u, of->gap, (size_t)of->H->d * (size_t)of->H->candidates * sizeof *u);
  for (int j = 0; j < of->K.n; j++)
    for (int k = Ht->p[j]; k < Ht->p[j + 1]; k++)
      u[Ht->i[k]] += Ht->x[k] * x[j];
}

static dls_status body_solve(dls_reduction *reduction, const double *mu,
                             const dls_solver_settings *settings, double *r, double *u, double *x,
                             dls_info *info, dls_error *error) {
  const dlsi_reduced of = dlsi_reduction_body(reduction);
  dls_solver_settings s;
  dls_solver_settings_init(&s);
  if (settings) s = *settings;
  const double tol = s.limits.tol, begun = dlsi_clock_start(&s.limits);
  dls_reduction_info facts;
  dls_info outcome = {.method = s.method}, on_K = {.status = DLS_OK};
  dls_status status = dls_reduction_get_info(reduction, &facts, error);
  if (!mu) mu = of.mu;
  if (!status && of.on_K) status = check_on_K(&of, mu, &s, error);
  if (status) return status;
  const size_t m = (size_t)of.H->d * (size_t)of.H->candidates, n = (size_t)of.K.n;
  if (!r && m > 0) return dlsi_is_null(error, "r");
  if (!x) return dlsi_is_null(error, "x");
  double *answer = dlsi_alloc(2 * m + n, sizeof *answer);
  if (!answer) return dlsi_no_memory(error);
  double *position = answer + m, *unknowns = position + m;
  memset(answer, 0, (2 * m + n) * sizeof *answer);
  if (s.limits.warm_start && m) memcpy(answer, r, m * sizeof *answer);
  status = of.on_K ? DLS_STALLED
                   : solve_on_W(reduction, mu, &s, facts.condition, answer, unknowns, position,
                                &outcome, error);
  const int goes_on = (status == DLS_STALLED || status == DLS_NOT_IN_EQUILIBRIUM ||
                       status == DLS_MAX_ITERATIONS || status == DLS_NO_SOLUTION_LIKELY) &&
                      s.method == DLS_AUTO && !s.plan && of.has_K && m > 0 &&
                      !s.limits.max_iterations;
  if (goes_on || of.on_K) {
    status = solve_on_K(reduction, mu, &s.limits, begun, !info, answer, unknowns, &on_K, error);
    if (status >= 0) {
      add_outcome(&outcome, &on_K, reduction, status);
      outcome.error = on_K.error;
      if (!is_split(reduction)) {
        const dls_status measured = dlsi_reduction_certify(reduction, mu, answer, unknowns, tol,
                                                           position, &outcome.certificate, error);
        if (measured) status = measured;
      } else
        look_at(&of, unknowns, position);
      if (status >= 0) status = judge_body(&outcome.certificate, tol, 0, status);
    }
  }
  outcome.status = status;
  forget_unproved(&outcome);
  if (status >= 0 && m) memcpy(r, answer, m * sizeof *r);
  if (status >= 0) memcpy(x, unknowns, n * sizeof *x);
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
  if (!status) status = dlsi_reduction_certify(reduction, mu, r, x, tol, NULL, &certificate, error);
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
