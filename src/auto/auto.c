/*
 * auto.c: the method "auto": runs other methods in turn, by a plan (plan.c).
 *
 *   (AT1)  cold solve: if at least 40 % of the contacts provably stay open, solve a copy without
 *          them (apart.c); if that fails, solve the whole problem
 *   (AT2)  warm solve: extrapolate from the last two answers, and maybe begin with a step of
 *          Newton's method (sequence.c)
 *   (AT3)  run the first plan of the problem's regime (plan.c)
 *   (AT4)  if it fails: up to 300 rows run the plan on a renumbered and scaled copy (renumber.c),
 *          with a verdict (verdict.c); beyond, run another plan
 *   (AT5)  improve an answer whose reactions may have a large error (accuracy.c); search for other
 *          answers (accuracy.c)
 *
 * What can fail: every step; then DLS_STALLED with the best r.
 */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "auto/auto.h"

/* Prepares a solve of this problem from r = 0. Errors of dlsi_form_blocks. */
static dls_status begin_solve(dlsi_auto *work, const dls_contact *problem, dls_error *error) {
  work->problem = problem;
  const int large = dlsi_auto_is_packing(work) && problem->nc > dlsi_auto_many; /* W when asked */
  const dls_status status = large ? DLS_OK : dlsi_auto_form_blocks(work, error);
  if (status) return status;
  problem = work->problem;
  work->bonded = dlsi_first_bonded(problem) >= 0;
  work->firm = !dlsi_auto_has_plan(work) && dlsi_auto_may_copy(work) &&
               dlsi_max_abs(problem->mu, (size_t)problem->nc) > dlsi_auto_firm;
  work->info = (dls_info){.method = DLS_AUTO, .certificate = dlsi_no_certificate};
  work->stopped = DLS_OK;
  work->history = (dlsi_auto_history){.last = SWEEPS};
  work->costly = work->has_copy = work->has_direction = work->has_farkas = work->excluded = 0;
  work->stepped = 0;
  work->turn = 0;
  work->info.at_rest = !dlsi_auto_has_plan(work) && dlsi_auto_looks_at_rest(work);
  work->convex_from = dlsi_auto_first_try(work);
  work->info.regime = dlsi_auto_regime(work);
  if (work->part[PUSH]) dlsi_nlgs_forget(work->part[PUSH]);
  if (work->part[AUGMENTED]) dlsi_augmented_forget(work->part[AUGMENTED]);
  work->info.candidates = work->whole;
  work->info.blocks = problem->W.a ? 0 : problem->Wb.x ? problem->Wb.p[problem->nc] : -1;
  work->info.left_out = work->touches ? work->whole - work->touches : 0;
  work->ahead = 0;
  work->step = 1;
  memset(work->best, 0, (size_t)problem->d * (size_t)problem->nc * sizeof *work->best);
  return DLS_OK;
}

static dls_status follow_and_judge(dlsi_auto *work, const step *plan, dls_error *error) {
  work->has_copy = 1;
  const dls_status status = dlsi_auto_follow(work, plan, error);
  return status == DLS_STALLED ? dlsi_auto_judge(work, error) : status;
}

/* (AT4) up to 300 rows. Returns as dlsi_auto_follow. */
static dls_status take_copy(dlsi_auto *work, dls_error *error) {
  dls_status status = dlsi_auto_on_copy(work, follow_and_judge, dlsi_auto_plan_on_copy, error);
  if (!dls_solved(status) || dlsi_auto_verdict_of(work) != DLS_STALLED)
    return status == DLS_OK ? dlsi_auto_verdict_of(work) : status;
  /* sums in another order round otherwise */
  status = dlsi_auto_take_step(work, (step){NEWTON, 0, 0}, error);
  return status < 0 ? status : dlsi_auto_verdict_of(work);
}

static dls_status follow_plans(dlsi_auto *work, dls_error *error) {
  if (dlsi_auto_has_plan(work)) return dlsi_auto_follow(work, dlsi_auto_first_plan(work), error);
  if (work->options.limits.warm_start && dlsi_auto_predict(work)) return DLS_OK;
  dls_status status = dlsi_auto_begin_with_newton(work, error); /* (AT2) */
  if (status != DLS_STALLED) return status;
  status = dlsi_auto_follow(work, dlsi_auto_first_plan(work), error); /* (AT3) */
  if (status != DLS_STALLED || dlsi_auto_is_rounded(work)) return status;
  if (!dlsi_auto_may_copy(work)) { /* (AT4) */
    status = dlsi_auto_follow(work, dlsi_auto_plan_beyond, error);
    return status == DLS_STALLED ? dlsi_auto_judge(work, error) : status;
  }
  status = take_copy(work, error);
  if (status != DLS_STALLED || !work->firm) return status;
  work->firm = 0;
  return take_copy(work, error);
}

static dls_status solve_cold(dlsi_auto *work, const dls_contact *problem, dls_error *error) {
  const dls_status status = begin_solve(work, problem, error);
  return status ? status : follow_plans(work, error);
}

/* Returns u of the best r as sweeps of bodies have left it, the bits of a product; NULL: there is
 * none. */
static const double *gap_of_sweeps(const dlsi_auto *work, dls_status status) {
  const int last = work->info.stages - 1;
  if (status != DLS_OK || last < 0 || work->has_copy || !dlsi_is_factored(work->problem) ||
      work->info.stage[last].step != DLS_STEP_MOMENTUM ||
      work->info.stage[last].residual != work->info.certificate.residual)
    return NULL;
  return dlsi_nlgs_gap(work->part[PUSH]);
}

static dls_status auto_solve(void *automatic, const dls_contact *problem, double *r, double *u,
                             dls_info *info, dls_error *error) {
  dlsi_auto *work = automatic;
  const size_t m = (size_t)problem->d * (size_t)problem->nc;
  const int warm = work->options.limits.warm_start;
  work->begun = dlsi_clock_start(&work->options.limits);
  work->whole = problem->nc;
  dls_status status = dlsi_lend(&work->formed, &problem, error);
  if (status) return status;
  status = warm || dlsi_auto_has_plan(work)
               ? DLS_STALLED
               : dlsi_auto_take_touching(work, problem, solve_cold, error);
  if (status == DLS_STALLED) {
    status = begin_solve(work, problem, error);
    if (status) return status;
    if (warm) memcpy(work->best, r, m * sizeof *r);
    status = follow_plans(work, error);
  }
  if (status < 0) return status;
  status = dlsi_settled(&work->info.certificate, work->options.limits.tol, status);
  status = dlsi_auto_prove(work, work->problem, status);
  if (status == DLS_OK || status == DLS_TO_ROUNDING)
    status = dlsi_auto_take_to_accuracy(work, info != NULL, status, error);
  if (status < 0) return status;
  problem = work->problem;
  memcpy(r, work->best, m * sizeof *r);
  const double *gap = gap_of_sweeps(work, status);
  if (u && !gap) dlsi_contact_multiply(problem, NULL, r, work->v[0], NULL);
  if (u) memcpy(u, gap ? gap : work->v[0], m * sizeof *u);
  work->info.status = status;
  dlsi_auto_remember_cost(work, r);
  if (warm) dlsi_auto_remember_answer(work, r, u ? u : gap);
  if (info && status == DLS_OK) dlsi_auto_look_for_others(work, r, gap);
  if (info) *info = work->info;
  return status;
}

static const double *auto_direction(const void *automatic) {
  const dlsi_auto *work = automatic;
  if (work->has_copy) return work->has_direction ? work->direction : NULL;
  return dlsi_augmented_method.direction(work->part[AUGMENTED]);
}

static const double *auto_farkas(const void *automatic) {
  const dlsi_auto *work = automatic;
  if (work->has_farkas || work->has_copy) return work->has_farkas ? work->farkas : NULL;
  return work->info.status == DLS_NO_SOLUTION ? dlsi_lemke_method.farkas(work->part[PIVOTING])
                                              : NULL;
}

static void auto_destroy(void *automatic) {
  dlsi_auto *work = automatic;
  if (!work) return;
  for (part k = 0; k < parts; k++)
    dlsi_auto_kind[k].method->destroy(work->part[k]);
  dlsi_room_free(&work->room);
  dlsi_formed_free(&work->formed);
  free(work);
}

static void auto_carve(void *automatic, dlsi_arena *arena) {
  dlsi_auto *work = automatic;
  const size_t m = (size_t)work->d * (size_t)work->nc;
  work->r = dlsi_take(arena, m, sizeof *work->r);
  work->best = dlsi_take(arena, m, sizeof *work->best);
  work->w = dlsi_take(arena, (size_t)work->nc, sizeof *work->w);
  work->weights = dlsi_take(arena, 2 * (size_t)work->nc, sizeof *work->weights);
  double **const answers[] = {&work->last.r, &work->last.Wr, &work->former.r, &work->former.Wr};
  dlsi_take_vectors(arena, m, 4, answers);
  for (int k = 0; k < 3; k++)
    work->v[k] = dlsi_take(arena, m, sizeof *work->v[k]);
  if (work->options.plan || work->options.without)
    work->given = dlsi_take(arena, 1, sizeof *work->given);
  if (m > dlsi_auto_small) return;
  work->v[3] = dlsi_take(arena, m, sizeof *work->v[3]);
  dlsi_renumber_carve(&work->copy, arena, work->d, work->nc);
  work->kept = dlsi_take(arena, m, sizeof *work->kept);
  work->direction = dlsi_take(arena, m, sizeof *work->direction);
  work->farkas = dlsi_take(arena, (size_t)work->nc, sizeof *work->farkas);
}

static int is_in_plan(const dlsi_auto *work, part k) {
  for (const step *s = work->given->step; s->part != END; s++)
    if (dlsi_auto_home_of(s->part) == k || (s->flags & ANY_SWEEPS && k == PUSH)) return 1;
  return 0;
}

/* Returns 1 if a solve may come to part k, whatever the problem. */
static int may_need(const dlsi_auto *work, part k) {
  if (dlsi_auto_is_left_out(work, k)) return 0;
  if (dlsi_auto_has_plan(work)) return is_in_plan(work, k);
  const int nc = work->nc, m = work->d * nc, blocks = work->options.limits.blocks;
  switch (k) {
  case SWEEPS:
    return nc <= dlsi_auto_many || !blocks || blocks / nc >= nc / 4;
  case REST:
    return m >= dlsi_auto_rest_least;
  case PUSH:
    return blocks;
  case PIVOTING:
    return m <= dlsi_auto_small && dlsi_auto_may_pivot(work);
  case HOMOTOPY:
  case SCATTER:
    return m <= dlsi_auto_small;
  default:
    return dlsi_auto_home_of(k) == k;
  }
}

static dls_status auto_create(void **out, int d, int nc, const dlsi_options *options,
                              dls_error *error) {
  dlsi_auto filled = {.options = *options, .d = d, .nc = nc};
  void *memory;
  dls_status status = dlsi_workspace(&memory, &filled, sizeof filled, auto_carve, nc, error);
  if (status) return status;
  dlsi_auto *work = memory;
  if (work->given)
    status = dlsi_auto_read_words(options->plan, options->without, work->given, error);
  work->options.plan = work->options.without = NULL;
  for (part k = 0; !status && !options->lazy && k < parts; k++)
    if (may_need(work, k)) status = dlsi_auto_create_part(work, k, error);
  if (!status && !options->lazy && d * nc <= dlsi_auto_small) /* a copy is dense */
    status = dlsi_room_dense(&work->room, (size_t)(d * nc), error);
  if (status)
    auto_destroy(work);
  else
    *out = work;
  return status;
}

const dlsi_method dlsi_auto_method = {
    .method = DLS_AUTO,
    .name = "auto",
    .summary = "2D, 3D, any W: the default; the others in turn, as their progress and cost tell",
    .create = auto_create,
    .solve = auto_solve,
    .destroy = auto_destroy,
    .limits = offsetof(dlsi_auto, options.limits),
    .direction = auto_direction,
    .farkas = auto_farkas,
    .map = dlsi_auto_map,
    .takes_bodies = 1,
};
