/* race.c: times the methods on one contact problem, down a ladder of tolerances (race.h). */
#include <limits.h>
#include <math.h>
#include <stdlib.h>

#include "race.h"

const option_row race_option_rows[] = {ROW(A_COUNT, "repeat", 'r', race_options, repeat),
                                       ROW(A_NUMBER, "limit", 'l', race_options, limit),
                                       ROW(A_NUMBER, "budget", 'b', race_options, budget),
                                       ROW(A_TEXT, "out", 'o', race_options, out),
                                       SOURCE_OPTIONS(race_options, from),
                                       LAST_OPTIONS};

/* CPU that a method may take over the fastest before it counts as over time. */
static const double patience = 30;

/* Sizes beyond which a method is left out: its workspace or its path would take minutes. */
enum { lemke_rows = 4000, homotopy_rows = 300 };

/* Timing: a quick solve is run so many times in a turn, or until it has taken so many seconds. */
enum { calls_in_a_turn = 20 };
static const double turn_seconds = 1e-3;

trial *race_trial(const race *a, int k, int rung) {
  return &a->trials[k * a->rungs + rung];
}

double *race_answer(const race *a, int k, int rung) {
  const size_t m = (size_t)a->d * (size_t)a->nc;
  return a->answers + (size_t)(k * a->rungs + rung) * m;
}

double race_fastest(const race *a, int rung) {
  double least = INFINITY;
  for (int k = 0; k < a->count; k++) {
    const trial *t = race_trial(a, k, rung);
    if (is_answer(t->end)) least = fmin(least, t->seconds);
  }
  return least;
}

/* ---- one solve ------------------------------------------------------------------------------- */

static const double longer = 10; /* times a limit that ended a solve without a verdict */

/* Sweeps on K itself, for more and more digits until r holds on W, whose certificate judges all
 * contenders. */
static dls_status race_sweep(race *a, const dls_limits *limits, double *r, dls_info *info,
                             dls_error *error) {
  const problem *body = a->body;
  const double start = cpu_seconds();
  dls_primal_settings s;
  dls_primal_settings_init(&s);
  s.limits = *limits;
  *info = (dls_info){.method = DLS_NLGS};
  for (;; s.limits.tol /= 10, s.limits.warm_start = 1) {
    dls_primal *primal;
    dls_primal_info own = {0};
    dls_status status = dls_primal_create(&primal, &body->model, &s, error);
    if (!status)
      status =
          dls_primal_solve(primal, body->f, body->g, a->problem->mu, a->x, r, NULL, &own, error);
    dls_primal_destroy(primal);
    info->iterations += own.iterations;
    if (status < 0) return status;
    const dls_status known = dls_contact_certify(a->problem, r, NULL, &info->certificate, error);
    if (known) return known;
    if (dls_certificate_holds(&info->certificate, limits->tol)) return DLS_OK;
    if (status) return status;
    if (s.limits.tol < 1e-17) return DLS_STALLED;
    if (limits->cpu_seconds > 0) {
      s.limits.cpu_seconds = start + limits->cpu_seconds - cpu_seconds();
      if (s.limits.cpu_seconds <= 0) return DLS_TIME_LIMIT;
    }
  }
}

dls_status race_call(race *a, int k, const dls_limits *limits, double *r, dls_info *info,
                     dls_error *error) {
  if (a->who[k].on_body) return race_sweep(a, limits, r, info, error);
  const dls_status status = dls_solver_set_limits(a->solver[k], limits, error);
  return status ? status : dls_solver_solve(a->solver[k], a->problem, r, NULL, info, error);
}

/* Goes on with a solve that its own limit of iterations has ended: once, with ten times as many. */
static dls_status race_longer(race *a, int k, int rung, dls_limits *limits, dls_error *error) {
  trial *t = race_trial(a, k, rung);
  dls_info info;
  if (t->iterations <= 0 || t->iterations > INT_MAX / longer) return DLS_OK;
  const double start = cpu_seconds();
  limits->max_iterations = (int)(longer * t->iterations);
  const dls_status status = race_call(a, k, limits, race_answer(a, k, rung), &info, error);
  if (status < 0) return status;
  if (status == DLS_CANCELLED) a->interrupted = 1;
  t->end = ending_of(status);
  if (status == DLS_MAX_ITERATIONS && !(info.certificate.residual < t->residual / 2))
    t->end = ENDED_STALLED;
  if (t->end != ENDED_SOLVED) return DLS_OK;
  *t = (trial){t->end, 1, info.iterations, 1, info.certificate.residual, cpu_seconds() - start};
  return DLS_OK;
}

/* Solves once, within `limit` seconds of CPU if that is > 0; *t takes the outcome and keeps the
 * least time. Returns an error of the library. */
static dls_status race_solve(race *a, int k, int rung, double limit, dls_error *error) {
  trial *t = race_trial(a, k, rung);
  dls_info info = {0};
  dls_limits limits = {.tol = a->tol[rung], .cpu_seconds = longer * limit};
  if (limit > 0) limits.progress = show_progress;
  const double start = cpu_seconds();
  const dls_status status = race_call(a, k, &limits, race_answer(a, k, rung), &info, error);
  const double seconds = cpu_seconds() - start;
  if (limit > 0) {
    *t = (trial){.end = ending_of(status), .asked = 1, .seconds = seconds};
    t->iterations = info.iterations;
    t->residual = status < 0 ? NAN : info.certificate.residual;
    if (status == DLS_CANCELLED) a->interrupted = 1;
    if (status == DLS_MAX_ITERATIONS) return race_longer(a, k, rung, &limits, error);
  } else if (seconds < t->seconds)
    t->seconds = seconds;
  return DLS_OK;
}

/* ---- the ladder ------------------------------------------------------------------------------ */

/* Returns 1 for a problem on which the method would take minutes, or too much memory. */
static int race_is_too_large(dls_method method, int d, int nc) {
  if (method == DLS_HOMOTOPY) return d * nc > homotopy_rows;
  return method == DLS_LEMKE && (d == 2 ? 4 : 10) * nc > lemke_rows;
}

int race_takes(const contender *who, const dls_contact *contact, const problem *body) {
  if (!who->on_body) return !race_is_too_large(who->method, contact->d, contact->nc);
  const dls_model *model = body ? &body->model : NULL;
  dls_primal *primal = NULL;
  const int takes = model && model->n && model->d == 2 && !model->P.p && !model->active &&
                    model->nodes == contact->nc && !dls_primal_create(&primal, model, NULL, NULL);
  dls_primal_destroy(primal);
  return takes;
}

/* Makes the solvers of all who take part. */
static dls_status race_line_up(race *a, dls_error *error) {
  contender all[MOST_CONTENDERS];
  const int count = list_contenders(all);
  for (int k = 0; k < count; k++) {
    if (!race_takes(&all[k], a->problem, a->body)) continue;
    if (all[k].on_body) {
      a->x = calloc((size_t)a->body->model.n, sizeof *a->x);
      if (!a->x) return DLS_E_MEMORY;
      a->who[a->count++] = all[k];
      continue;
    }
    dls_solver_settings s;
    dls_solver_settings_init(&s);
    s.method = all[k].method;
    s.acceleration = all[k].acceleration;
    s.limits.blocks = a->problem->Wb.x ? a->problem->Wb.p[a->nc] : 0;
    const dls_status status = dls_solver_create(&a->solver[a->count], a->d, a->nc, &s, error);
    if (status) return status;
    a->who[a->count++] = all[k];
  }
  return DLS_OK;
}

/* Runs each contender once on a rung; one that gave up before keeps its verdict. */
static dls_status race_first(race *a, int rung, double end, dls_error *error) {
  for (int k = 0; k < a->count; k++) {
    trial *t = race_trial(a, k, rung);
    if (rung && race_trial(a, k, rung - 1)->end != ENDED_SOLVED) {
      *t = *race_trial(a, k, rung - 1);
      t->asked = 0;
      continue;
    }
    const double fastest = race_fastest(a, rung), left = fmax(end - cpu_seconds(), 0);
    double limit = fmax(a->plan->limit, isfinite(fastest) ? patience * fastest : 0);
    if (a->who[k].method == DLS_AUTO) limit = fmax(limit, left / 2);
    limit = fmin(limit, fmax(left / 4, a->plan->limit));
    *t = (trial){.end = ENDED_UNDECIDED, .residual = NAN};
    const dls_status status = a->interrupted ? DLS_OK : race_solve(a, k, rung, limit, error);
    if (status) return status;
  }
  return DLS_OK;
}

/* Times each solved trial again. */
static dls_status race_turn(race *a, int turn, double end, dls_error *error) {
  for (int rung = 0; rung < a->rungs; rung++)
    for (int k = 0; k < a->count; k++) {
      const trial *t = race_trial(a, k, rung);
      if (t->end != ENDED_SOLVED || t->longer || (turn > 1 && t->seconds > 0.2)) continue;
      const double start = cpu_seconds();
      for (int call = 0; call < calls_in_a_turn && cpu_seconds() < start + turn_seconds; call++) {
        const dls_status status = race_solve(a, k, rung, 0, error);
        if (status) return status;
      }
      if (cpu_seconds() > end || was_interrupted()) return DLS_OK;
    }
  return DLS_OK;
}

dls_status race_run(race *a, const dls_contact *contact, const problem *body, const race_plan *plan,
                    dls_error *error) {
  dls_status status = dls_contact_check(contact, error);
  if (status) return status;
  *a = (race){.d = contact->d, .nc = contact->nc, .rungs = plan->rungs, .tol = plan->tol};
  a->problem = contact;
  a->body = body;
  a->plan = plan;
  const size_t cells = (size_t)plan->rungs * MOST_CONTENDERS;
  a->trials = calloc(cells, sizeof *a->trials);
  a->answers = malloc(cells * (size_t)a->d * (size_t)a->nc * sizeof *a->answers);
  if (!a->trials || !a->answers) return no_memory(error);
  const double end = cpu_seconds() + plan->budget;
  status = race_line_up(a, error);
  for (int rung = 0; rung < a->rungs && !status; rung++)
    status = race_first(a, rung, end, error);
  for (int turn = 1; turn < plan->repeat && !status && !a->interrupted; turn++)
    if (cpu_seconds() < end) status = race_turn(a, turn, end, error);
  a->interrupted |= was_interrupted();
  progress_end();
  return status;
}

void race_free(race *a) {
  for (int k = 0; k < MOST_CONTENDERS; k++)
    dls_solver_destroy(a->solver[k]);
  free(a->x);
  free(a->trials);
  free(a->answers);
}
