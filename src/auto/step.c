/*
 * step.c: runs a plan. Each step is a solve by a method from the best r so far, or from r = 0. Its
 * r is kept if it is better, and info.stage gets a line.
 *
 *   (ST1)  the first r that the certificate accepts is the answer
 *   (ST2)  if the convex problem meets the tolerance up to the rounding of W r, the plan ends: no
 *          later step has less rounding
 *   (ST3)  if the best r is solved to rounding, a large component of r in the null space of W may
 *          cause the rounding. ADMM from r = 0 finds reactions with a small one; the better r is
 *          the answer
 *   (ST4)  if Lemke's method has proved that there is no solution, or shown that none could be
 *          certified (facts/farkas.c), the plan ends. An early Lemke step does not end it, because
 *          the copy of renumber.c finds the proof again for each order of the contacts
 */
#include <float.h>
#include <math.h>
#include <string.h>

#include "auto/auto.h"

/* ---- workspaces ------------------------------------------------------------------------------ */

dls_status dlsi_auto_form_blocks(dlsi_auto *work, dls_error *error) {
  if (!dlsi_is_factored(work->problem)) return DLS_OK;
  const dls_status status = dlsi_form_blocks(&work->formed, &work->problem, error);
  if (status) return status;
  const int blocks = work->problem->Wb.p[work->problem->nc];
  if (blocks > work->options.limits.blocks) work->options.limits.blocks = blocks;
  return DLS_OK;
}

static dls_limits limits_of(dlsi_auto *work, part k) {
  return (dls_limits){.tol = work->options.limits.tol,
                      .max_iterations = work->most ? work->most : dlsi_auto_kind[k].most,
                      .warm_start = k != PIVOTING && k != COLD_SPLITTING,
                      .blocks = work->options.limits.blocks,
                      .progress = dlsi_auto_watch_of(work, k),
                      .progress_data = work,
                      .cpu_seconds = dlsi_clock_left(&work->options.limits, work->begun),
                      .threads = work->options.limits.threads};
}

part dlsi_auto_home_of(part k) {
  return k == COLD_SPLITTING || k == SETTLE ? SPLITTING : k;
}

dls_status dlsi_auto_create_part(dlsi_auto *work, part k, dls_error *error) {
  dlsi_options options = work->options;
  if (work->part[k]) return DLS_OK;
  options.limits = limits_of(work, k);
  options.limits.cpu_seconds = 0;    /* each step sets it */
  options.stage = k == PUSH ? 2 : 1; /* momentum, the usual way (vi/sweep/nlgs.c) */
  options.room = &work->room;
  return dlsi_auto_kind[k].method->create(&work->part[k], work->d, work->nc, &options, error);
}

/* ---- one step -------------------------------------------------------------------------------- */

/* Runs the method of part k from work->r. */
static dls_status run_part(dlsi_auto *work, part k, dls_info *info, dls_error *error) {
  const step_kind *kind = &dlsi_auto_kind[k];
  void *const home = work->part[dlsi_auto_home_of(k)];
  const dls_limits limits = limits_of(work, k);
  dls_contact of_bodies = *work->problem; /* momentum takes the factors even where W is formed */
  if (k == PUSH && of_bodies.bodies.H) of_bodies.Wb = (dls_blocks){0};
  if (k == AUGMENTED)
    dlsi_augmented_allow(home, work->in_turn ? dlsi_auto_factors_of_turn(work) : 0);
  if (k == REST) dlsi_rest_allow(home, work->convex_from > 0 ? dlsi_auto_sweeps(work) : 0);
  dlsi_set_limits(kind->method, home, &limits);
  return kind->method->solve(home, &of_bodies, work->r, NULL, info, error);
}

/* Returns why a step has ended, with this status and this certificate of its r. */
static dls_reason reason_of(const dlsi_auto *work, part k, dls_status status,
                            const dls_certificate *of_r) {
  if (dls_certificate_verdict(of_r, work->options.limits.tol) != DLS_STALLED)
    return DLS_REASON_SOLVED;
  if (work->stopped == DLS_MAX_ITERATIONS) return DLS_REASON_ITERATIONS;
  if (work->stopped)
    return work->stopped == DLS_TIME_LIMIT ? DLS_REASON_TIME : DLS_REASON_CANCELLED;
  if (status == DLS_NO_SOLUTION) return DLS_REASON_NO_SOLUTION;
  if (k == PIVOTING && dlsi_contact_lemke_excludes(work->part[k])) return DLS_REASON_EXCLUDED;
  switch (status) {
  case DLS_CANCELLED: /* by the watch */
    return work->why;
  case DLS_TIME_LIMIT:
    return DLS_REASON_TIME;
  case DLS_MAX_ITERATIONS:
    return DLS_REASON_SPENT;
  case DLS_RAY:
  case DLS_NO_SOLUTION_LIKELY:
    return DLS_REASON_RUNS_AWAY;
  default:
    return DLS_REASON_NO_PROGRESS;
  }
}

/* Remembers a step that has ended with `status`, and when the step may come again. */
static void remember(dlsi_auto *work, part k, dls_status status, const dls_info *info) {
  dlsi_auto_history *h = &work->history;
  h->taken[k]++;
  h->iterations[k] += info->iterations;
  h->ended[k] = reason_of(work, k, status, &info->certificate);
  h->last = k;
  if (k == REST) {
    const double refused = status == DLS_STALLED ? dlsi_rest_refused(work->part[REST]) : 0;
    const int again = status == DLS_STALLED && work->convex_from > 0;
    work->convex_from = refused > 0 ? refused : again ? 4. * dlsi_auto_sweeps(work) : INFINITY;
  }
  if (k == AUGMENTED && h->ended[k] == DLS_REASON_COSTLIER) work->turn *= 2;
}

/* Adds a line to the report. */
static dls_stage *add_line(dlsi_auto *work, part k, dls_reason reason) {
  dls_info *all = &work->info;
  if (all->stages == DLS_STAGES_MAX) all->stages--; /* the last line is that of the last step */
  dls_stage *line = &all->stage[all->stages++];
  *line = (dls_stage){.method = dlsi_auto_kind[k].method->method,
                      .residual = all->certificate.residual,
                      .step = dlsi_auto_kind[k].step,
                      .reason = reason,
                      .on_copy = work->problem == &work->copy.problem};
  return line;
}

/* Adds the line of a step that has ended to the report, and keeps its r if that is the best.
 * begun: CPU seconds of the solve before it. */
static void report(dlsi_auto *work, part k, const dls_info *info, double begun) {
  dls_info *all = &work->info;
  dls_stage *line = add_line(work, k, work->history.ended[k]);
  line->iterations = info->iterations;
  line->factorisations = info->factorisations;
  line->residual = info->certificate.residual;
  if (info->stages) line->step = info->stage[0].step;
  if (line->reason == DLS_REASON_COSTLIER) {
    line->ahead = work->foreseen[0];
    line->next = work->foreseen[1];
  }
  line->cpu_seconds = dlsi_clock_since(work->begun) - begun;
  all->iterations += info->iterations;
  all->factorisations += info->factorisations;
  if (!dlsi_is_better(&info->certificate, &all->certificate)) return;
  all->certificate = info->certificate;
  memcpy(work->best, work->r,
         (size_t)work->problem->d * (size_t)work->problem->nc * sizeof *work->best);
}

/* Adds the line of a step that cannot be taken. */
static dls_status pass_over(dlsi_auto *work, part k) {
  (void)add_line(work, k, DLS_REASON_NOT_APPLICABLE);
  return DLS_STALLED;
}

dls_status dlsi_auto_take_step(dlsi_auto *work, step s, dls_error *error) {
  const part k = s.part;
  if (dlsi_auto_is_left_out(work, k)) return DLS_STALLED;
  dls_error why = {0};
  const double begun = dlsi_clock_since(work->begun);
  work->most = s.most;
  dls_status status = k == PUSH ? DLS_OK : dlsi_auto_form_blocks(work, &why);
  if (status == DLS_E_SIZE) return pass_over(work, k); /* too many blocks: sweeps on bodies alone */
  const size_t m = (size_t)work->problem->d * (size_t)work->problem->nc;
  dls_info info = {.status = DLS_OK};
  if (!status) status = dlsi_auto_create_part(work, dlsi_auto_home_of(k), &why);
  work->in_turn = s.flags & IN_TURN && !dlsi_auto_has_pushed(work);
  if (s.flags & COLD && k == PUSH && !status) dlsi_nlgs_forget(work->part[PUSH]);
  if (!work->in_turn && k == AUGMENTED && !status) dlsi_augmented_forget(work->part[AUGMENTED]);
  if (s.flags & COLD)
    memset(work->r, 0, m * sizeof *work->r);
  else
    memcpy(work->r, work->best, m * sizeof *work->r);
  dlsi_auto_begin_watch(work);
  if (!status) status = run_part(work, k, &info, &why);
  remember(work, k, status, &info);
  if ((k == SPLITTING || k == COLD_SPLITTING || k == REST) && status == DLS_E_UNSUPPORTED)
    return pass_over(work, k); /* a build without MUMPS */
  if (status < 0) {
    if (error) *error = why;
    return status;
  }
  if (work->stepped && !work->info.stages && status == DLS_STALLED && !info.iterations)
    return status; /* (SQ2) without a step */
  report(work, k, &info, begun);
  return status;
}

/* ---- a plan ---------------------------------------------------------------------------------- */

/* A step EARLY, on the copy: paths of pivots depend on the order of the contacts. */
static dls_status take_first(dlsi_auto *work, const step *plan, dls_error *error) {
  return dlsi_auto_take_step(work, plan[0], error);
}

static int is_open(const dlsi_auto *work, const step *s) {
  const step_kind *kind = &dlsi_auto_kind[s->part];
  if (dlsi_auto_is_left_out(work, s->part)) return 0;
  if (s->flags & IN_TURN && !dlsi_auto_may_take_turn(work)) return 0;
  if (s->flags & SMALL && !dlsi_auto_may_augment_early(work)) return 0;
  if (s->flags & SORTED && work->info.certificate.residual > dlsi_auto_unsorted) return 0;
  if (kind->may && !kind->may(work)) return 0;
  if (s->flags & EARLY && !dlsi_auto_may_go_early(work, s->part)) return 0;
  return !(s->flags & COLD) || dlsi_auto_may_go_another_way(work);
}

/* (ST3) Returns the verdict of the better one, or an error. */
static dls_status take_less_stress(dlsi_auto *work, part now, dls_error *error) {
  if (now == COLD_SPLITTING || !dlsi_auto_may_go_another_way(work) || dlsi_auto_has_plan(work))
    return dlsi_auto_verdict_of(work);
  const dls_status status = dlsi_auto_take_step(work, (step){COLD_SPLITTING, COLD, 0}, error);
  return status < 0 ? status : work->stopped ? work->stopped : dlsi_auto_verdict_of(work);
}

int dlsi_auto_is_rounded(const dlsi_auto *work) {
  return work->history.taken[REST] && work->history.last == REST &&
         dlsi_certificate_meets(&work->info.certificate, work->options.limits.tol);
}

/* Returns 1 if nothing is left to try after the step s, which ended with *status: that of the plan
 * then. */
static int is_decided(dlsi_auto *work, const step *s, dls_status *status) {
  const int early = s->flags & EARLY;
  const int excluded = s->part == PIVOTING && work->part[PIVOTING] &&
                       dlsi_contact_lemke_excludes(work->part[PIVOTING]);
  const int proved = *status == DLS_NO_SOLUTION;
  if (work->stopped) return *status = work->stopped, 1;
  if (dlsi_auto_is_rounded(work)) return *status = DLS_STALLED, 1;
  if (*status == DLS_TIME_LIMIT) return 1;
  if (!proved && !excluded) return 0;
  if (work->firm) return 0; /* of the copy alone */
  work->excluded = !early && excluded && !proved;
  if (early || !proved) *status = DLS_STALLED; /* (ST4) */
  return 1;
}

/* Returns the part that a step of the caller's plan runs; END, with a line in the report, if it
 * cannot be taken. */
static part part_of_given(dlsi_auto *work, const step *s) {
  const part k = s->flags & ANY_SWEEPS && !dlsi_auto_may_sweep(work) ? PUSH : s->part;
  if (dlsi_auto_is_left_out(work, k)) return END;
  if (!dlsi_auto_can_take(work, k)) (void)pass_over(work, k);
  return dlsi_auto_can_take(work, k) ? k : END;
}

static dls_status take_given(dlsi_auto *work, const step *s, part k, dls_error *error) {
  work->counted = s->most || s[1].part == END;
  const dls_status status = dlsi_auto_take_step(work, (step){k, s->flags, s->most}, error);
  work->counted = 0;
  return status;
}

dls_status dlsi_auto_follow(dlsi_auto *work, const step *plan, dls_error *error) {
  const int given = dlsi_auto_has_plan(work);
  int gave_way = 0; /* a step since the last AGAIN, to the next one */
  for (const step *s = plan; s->part != END; s++) {
    if (s->part == AGAIN) {
      s -= gave_way ? s->most + 1 : 0;
      gave_way = 0;
      continue;
    }
    const part k = given ? part_of_given(work, s) : is_open(work, s) ? s->part : END;
    if (k == END) continue;
    dls_status status = given              ? take_given(work, s, k, error)
                        : s->flags & EARLY ? dlsi_auto_on_copy(work, take_first, s, error)
                                           : dlsi_auto_take_step(work, *s, error);
    if (status < 0) return status;
    const dlsi_auto_history *h = &work->history;
    gave_way |= h->ended[h->last] == DLS_REASON_COSTLIER;
    const dls_status verdict = dlsi_auto_verdict_of(work);
    if (verdict == DLS_OK) return DLS_OK; /* (ST1) */
    if (verdict == DLS_TO_ROUNDING && !work->stopped) return take_less_stress(work, s->part, error);
    if (is_decided(work, s, &status)) return status;
  }
  return DLS_STALLED;
}
