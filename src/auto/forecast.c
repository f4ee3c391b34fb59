/*
 * forecast.c: decides when a step ends, from the residuals that its iterations report.
 *
 * With e the residual and e* the target, every 5 sweeps,
 *
 *   (FC1)  expected remaining sweeps: log(e / e*) / rate. rate: mean decrease of log e per sweep
 *          since the step began, sweep k with the weight k, so that the last half counts most
 *   (FC2)  sweeps end if (FC1) exceeds the cost of the next step, and at least N sweeps are done:
 *            cost  Newton's method: price.c, PR1; the convex problem or momentum: 100 sweeps
 *            N     60  W by blocks, regime few
 *                  20  W by blocks, else; or e > .05 before any failure
 *                  10  otherwise
 *            N is halved from a warm start whose first sweep ends with e <= 1/4, and doubled by
 *            each failure
 *   (FC3)  Newton's method ends if S steps have not reduced e. S = 4, or as many as cost
 *          half of (FC1) and of splitting, up to 12; doubled by each failure
 *
 *   (FC4)  momentum gives way to the augmented Lagrangian once the sweeps of the solve cost a turn,
 *          if (FC1) or these sweeps exceed four turns. A turn is PR5 of price.c at first. The
 *          augmented Lagrangian ends after a turn of its own, which doubles the next. Both go on
 *          from where they were (NL14, AU6), so that neither takes much more than three times its
 *          cost alone
 *   (FC5)  sweeps give way to the convex problem if (FC1) exceeds 100: at once where bodies look at
 *          rest; elsewhere after 200 sweeps, or four factorisations as numbered if these cost less,
 *          if (FC1) exceeds twice the sweeps so far, and after 800 in any case. There its factors
 *          may cost as many sweeps as were made, at rest 1000, else it waits for so many; once it
 *          has failed, for 4 times the sweeps, and then it is more patient. vi/split/fill.c
 */
#include <math.h>

#include "auto/auto.h"

/* Tells the caller's callback and keeps to the caller's limits. Returns 1 to stop. */
static int must_stop(dlsi_auto *work, const dls_progress *p) {
  const dls_limits *limits = &work->options.limits;
  dls_progress mine = *p;
  mine.method = "auto";
  if (work->problem == &work->copy.problem && limits->progress && p->r) { /* the caller's r */
    const dlsi_renumber *copy = &work->copy;
    dlsi_renumber_back(copy, work->d, copy->power_q - copy->power_W, p->r, work->v[3]);
    mine.r = work->v[3];
  }
  if (work->touches && limits->progress && mine.r) {
    dlsi_auto_put_among_all(work, mine.r, work->shown);
    mine.r = work->shown;
  }
  work->stopped = dlsi_tell(limits, work->begun, &mine);
  if (!work->stopped && limits->max_iterations &&
      work->info.iterations + p->iteration >= limits->max_iterations)
    work->stopped = DLS_MAX_ITERATIONS;
  return work->stopped != DLS_OK;
}

/* Ends a step: `ahead` sweeps more cost more than the next step, both in sweeps. Returns 1. */
static int end_as_costlier(dlsi_auto *work, double ahead, double next) {
  work->why = DLS_REASON_COSTLIER;
  work->foreseen[0] = ahead;
  work->foreseen[1] = next;
  return 1;
}

/* Returns 1 after so many sweeps, with `ahead` more, if the convex problem is next: (FC5). */
static int is_convex_due(dlsi_auto *work, double sweeps, double ahead) {
  if (sweeps < work->convex_from || ahead <= dlsi_auto_ahead) return 0;
  if (!work->info.at_rest && ahead <= 2 * sweeps && sweeps < 4 * dlsi_auto_sweeps_before) return 0;
  if (!work->history.taken[REST]) {
    const dls_contact *problem = work->problem;
    const int told = work->options.limits.blocks, d = problem->d;
    const double blocks = told > 1 ? told : 10. * problem->nc;
    const double fill = dlsi_foresee_fill(problem) / (2 * d * d * blocks);
    if (fill > fmax(sweeps, work->info.at_rest ? 1000 : 0)) work->convex_from = fill;
  }
  return sweeps >= work->convex_from;
}

static int watch_sweeps(void *data, const dls_progress *p) {
  DLSI_DOOR;
  dlsi_auto *work = data;
  if (must_stop(work, p)) return 1;
  const double now = log(p->residual);
  if (p->iteration == 1) {
    work->least = now;
    work->near = work->options.limits.warm_start && p->residual <= dlsi_auto_far_start;
  }
  const double gain = now < work->least ? work->least - now : 0;
  work->least -= gain;
  work->rate += 2. / (p->iteration + 1) * (gain - work->rate);
  if (p->iteration % dlsi_auto_look_every) return 0;
  const double newton = dlsi_auto_cost_of_newton(work),
               ahead = (work->least - work->target) / work->rate;
  const double other =
      dlsi_auto_is_packing(work) && !dlsi_auto_has_pushed(work) ? dlsi_auto_ahead : newton;
  const int convex = is_convex_due(work, dlsi_auto_sweeps(work) + p->iteration, ahead);
  const double next = convex ? fmin(other, dlsi_auto_ahead) : other;
  if (work->d == 3 && p->residual > dlsi_auto_unsorted &&
      dlsi_auto_cost_of_split(work) < 2 * newton)
    work->costly = 1;
  work->ahead = ahead;
  const int failures = dlsi_auto_failures(work);
  const int sorted = failures || p->residual <= dlsi_auto_unsorted;
  const int twice = !work->problem->W.a || !sorted;
  const int cold =
      dlsi_auto_is_few(work) ? dlsi_auto_first_of_few : (twice + 1) * dlsi_auto_first_sweeps;
  const int first = cold / (work->near + 1);
  if (!(p->iteration >= first << failures && ahead > next)) return 0;
  return end_as_costlier(work, ahead, next);
}

static int watch_newton(void *data, const dls_progress *p) {
  DLSI_DOOR;
  dlsi_auto *work = data;
  if (must_stop(work, p)) return 1;
  const double now = log(p->residual);
  if (now < work->least) {
    work->least = now;
    work->since = p->iteration;
  }
  return p->iteration - work->since >= work->patience << dlsi_auto_failures(work);
}

/* Stops when the convex problem is to be tried. Sweeps that get nowhere stop by themselves. */
static int watch_push(void *data, const dls_progress *p) {
  DLSI_DOOR;
  dlsi_auto *work = data;
  if (must_stop(work, p)) return 1;
  const double now = log(p->residual);
  if (!work->since) work->least = now;
  const double gain = now < work->least ? work->least - now : 0;
  const int sweeps = p->iteration - work->since; /* of bodies some in one go */
  work->least -= gain;
  work->rate += 2. * sweeps / (p->iteration + sweeps) * (gain / sweeps - work->rate);
  work->since = p->iteration;
  if (p->iteration % dlsi_auto_look_every || p->iteration < 2 * dlsi_auto_first_sweeps) return 0;
  const double ahead = (now - work->target) / work->rate;
  const double so_far = dlsi_auto_sweeps(work) + p->iteration;
  if (is_convex_due(work, so_far, ahead)) return end_as_costlier(work, ahead, dlsi_auto_ahead);
  if (!dlsi_auto_has_augmented(work)) { /* (FC4) */
    const double turn = fmax(work->turn, dlsi_auto_cost_of_augmented(work));
    if (so_far >= turn && (ahead > 4 * turn || so_far >= 4 * turn)) {
      work->turn = turn;
      return end_as_costlier(work, ahead, turn);
    }
  }
  if (!dlsi_auto_is_near(work, p->residual)) return 0;
  const double newton = dlsi_auto_cost_of_newton(work);
  return ahead > newton && end_as_costlier(work, ahead, newton);
}

static int watch_augmented(void *data, const dls_progress *p) {
  DLSI_DOOR;
  dlsi_auto *work = data;
  if (must_stop(work, p)) return 1;
  dls_stage so_far = {.method = DLS_AUGMENTED_LAGRANGIAN, .iterations = p->iteration};
  so_far.factorisations = dlsi_augmented_factorisations(work->part[AUGMENTED]);
  const double cost = dlsi_auto_price_of(work->problem, work->unknowns, &so_far);
  return work->in_turn && cost >= work->turn && end_as_costlier(work, cost, work->turn);
}

/* Keeps to the limits of the caller and, in a plan that the caller has named, to its iterations. */
static int watch_count(void *data, const dls_progress *p) {
  DLSI_DOOR;
  dlsi_auto *work = data;
  if (must_stop(work, p)) return 1;
  if (!work->counted || !work->most || p->iteration < work->most) return 0;
  work->why = DLS_REASON_SPENT;
  return 1;
}

dls_progress_fn dlsi_auto_watch_of(const dlsi_auto *work, part k) {
  static const dls_progress_fn of[parts] = {[SWEEPS] = watch_sweeps,
                                            [NEWTON] = watch_newton,
                                            [PUSH] = watch_push,
                                            [AUGMENTED] = watch_augmented};
  return work->counted || !of[k] ? watch_count : of[k];
}

/* Returns how many steps without progress Newton's method may take: half of what comes after it. */
static int patience_of_newton(const dlsi_auto *work) {
  const double other = dlsi_auto_has_splitting(work)
                           ? fmin(work->ahead, dlsi_auto_cost_of_split(work))
                           : work->ahead;
  return (int)fmin(fmax(other / (2 * work->step), dlsi_auto_first_patience),
                   dlsi_auto_last_patience);
}

void dlsi_auto_begin_watch(dlsi_auto *work) {
  const dls_certificate *best = &work->info.certificate;
  const double tol = work->options.limits.tol;
  const int measured = best->floor_u <= DBL_MAX; /* not at the first step of all, or of a copy */
  work->target = log(measured ? dlsi_certificate_target(best, tol) : tol);
  work->least = log(best->residual);
  work->rate = 0;
  work->unknowns = dlsi_auto_count_unknowns(work->problem, work->r);
  work->since = 0;
  work->patience = patience_of_newton(work);
  work->why = DLS_REASON_NO_PROGRESS;
  work->foreseen[0] = work->foreseen[1] = 0;
}
