/*
 * sequence.c: what a warm solve takes from earlier solves.
 *
 *   (SQ1)  line: if the start is the answer of the last solve, also try 2 r(last) - r(before) and
 *          start from the better one. While W does not change, u of both follows without a product;
 *          (SQ2) begins with that u.
 *   (SQ2)  step: with W dense, a warm solve may begin with Newton's method on the factors of the
 *          last solve (newton.c, NE5). If no state changes, such a step takes only products and
 *          triangular solves. In sweeps,
 *
 *            begin with Newton if the last solve by sweeps cost more than E
 *            E := one step for each two digits of tol             at first
 *            E := (5 E + cost of the solve) / 6                   after a solve that began so
 *            E := 0.98 E                                          after a solve by sweeps
 *            cost of a step 3/2; of factors and their border 3 + k^2 / (10 m), but not of the first
 *            ones after a solve by sweeps
 *
 *          After a failure the next warm solve does not try. From a start (SQ1) with e > 1/4
 *          Newton's method continues as long as the factors are useful, because more states change
 *          there than one new factor would correct.
 *   (SQ3)  map: where contacts get other numbers, come or go (dls_solver_map), the answers of (SQ1)
 *          are renamed, with r = 0 for new contacts. If any come or go, W r of both is made afresh
 *          if W is dense: two products. W of a packing changes with each step; its answers are
 *          not extrapolated then
 */
#include <math.h>
#include <string.h>

#include "auto/auto.h"

/* Returns the sweeps that a solve with (SQ2) is expected to take. */
static double expect_of_step(const dlsi_auto *work) {
  if (work->of_step > 0) return work->of_step;
  return fmax(-log10(work->options.limits.tol) / 2, 1) * dlsi_auto_step_sweeps;
}

/* Returns 1 if a warm solve begins with Newton's method (SQ2). */
static int may_begin_with_newton(dlsi_auto *work) {
  const dls_contact *problem = work->problem;
  const int failed = work->failed_to_step;
  work->failed_to_step = 0;
  if (!work->options.limits.warm_start || failed || !problem->W.a) return 0;
  return work->swept > expect_of_step(work);
}

/* Measures r, and keeps it as the best one if it is better. Scratch: v. */
static void offer(dlsi_auto *work, const double *r) {
  const dls_contact *problem = work->problem;
  dls_certificate now;
  dlsi_contact_multiply(problem, NULL, r, work->v[0], work->v[1]);
  dlsi_contact_measure(problem, r, work->v[0], work->v[1], work->weights, work->v[2], &now);
  if (!dlsi_is_better(&now, &work->info.certificate)) return;
  work->info.certificate = now;
  memcpy(work->best, r, (size_t)problem->d * (size_t)problem->nc * sizeof *r);
}

/* Returns the residual of r with v[0] as its u. */
static double expect(dlsi_auto *work, const double *r) {
  const dls_contact *problem = work->problem;
  dls_certificate now;
  memset(work->v[1], 0, (size_t)problem->d * (size_t)problem->nc * sizeof *r);
  dlsi_contact_measure(problem, r, work->v[0], work->v[1], work->weights, work->v[2], &now);
  return now.residual;
}

/* Makes W r of both answers afresh. Scratch: v[0]. */
static void multiply_answers(dlsi_auto *work) {
  const dls_contact *problem = work->problem;
  const size_t m = (size_t)problem->d * (size_t)problem->nc;
  const auto_answer *const answers[] = {&work->last, &work->former};
  for (int i = 0; i < 2; i++) {
    dlsi_contact_multiply(problem, NULL, answers[i]->r, work->v[0], NULL);
    for (size_t k = 0; k < m; k++)
      answers[i]->Wr[k] = work->v[0][k] - problem->q[k];
  }
}

/* (SQ1) Returns 1 if the certificate of the start holds already. With the same W both starts are
 * measured without a product, since W r is linear in r; with another one this is a guess. */
int dlsi_auto_predict(dlsi_auto *work) {
  const dls_contact *problem = work->problem;
  const auto_answer *a = &work->last, *b = &work->former;
  const size_t m = (size_t)problem->d * (size_t)problem->nc;
  work->start = 0;
  if (work->answers < 2 || work->last_nc != problem->nc ||
      memcmp(a->r, work->best, m * sizeof *a->r) != 0)
    return 0;
  if (work->mapped && !problem->W.a) return 0; /* (SQ3) */
  dlsi_auto_set_weights(work);
  if (work->mapped) multiply_answers(work);
  for (size_t k = 0; k < m; k++)
    work->v[0][k] = a->Wr[k] + problem->q[k];
  double residual = expect(work, a->r);
  for (size_t k = 0; k < m; k++) {
    work->r[k] = 2 * a->r[k] - b->r[k];
    work->v[0][k] = 2 * a->Wr[k] - b->Wr[k] + problem->q[k];
  }
  const double of_line = expect(work, work->r);
  if (of_line < residual) {
    residual = of_line;
    memcpy(work->best, work->r, m * sizeof *work->best);
  } else
    for (size_t k = 0; k < m; k++)
      work->v[0][k] = a->Wr[k] + problem->q[k];
  if (residual > work->options.limits.tol) return work->start = residual, 0;
  memcpy(work->r, work->best, m * sizeof *work->r);
  offer(work, work->r);
  return dls_certificate_holds(&work->info.certificate, work->options.limits.tol);
}

/* Remembers the answer of a warm solve. u: that of r, NULL: not known. */
void dlsi_auto_remember_answer(dlsi_auto *work, const double *r, const double *u) {
  const dls_contact *problem = work->problem;
  const size_t m = (size_t)problem->d * (size_t)problem->nc;
  const auto_answer oldest = work->former;
  const dls_info *info = &work->info;
  const dls_stage *line = info->stages ? &info->stage[info->stages - 1] : NULL;
  if (!u && info->status == DLS_OK && !work->has_copy && line && line->step == DLS_STEP_NEWTON &&
      line->residual == info->certificate.residual)
    u = dlsi_newton_gap(work->part[NEWTON]);
  work->answers = work->answers && work->last_nc == problem->nc ? 2 : 1;
  work->last_nc = problem->nc;
  work->former = work->last;
  work->last = oldest;
  memcpy(oldest.r, r, m * sizeof *r);
  if (!u) dlsi_contact_multiply(problem, NULL, r, work->v[0], NULL);
  if (!u) u = work->v[0];
  for (size_t k = 0; k < m; k++)
    oldest.Wr[k] = u[k] - problem->q[k];
}

/* Renames an answer. Scratch: v[0], v[1]. */
static void rename_answer(const dlsi_auto *work, auto_answer *a, int nc, const int *from) {
  const size_t d = (size_t)work->d, m = d * (size_t)nc, bytes = d * sizeof *a->r;
  double *r = work->v[0], *Wr = work->v[1];
  for (int c = 0; c < nc; c++) {
    const size_t to = d * (size_t)c, at = from[c] < 0 ? 0 : d * (size_t)from[c];
    memset(r + to, 0, bytes);
    memset(Wr + to, 0, bytes);
    if (from[c] >= 0) memcpy(r + to, a->r + at, bytes);
    if (from[c] >= 0) memcpy(Wr + to, a->Wr + at, bytes);
  }
  memcpy(a->r, r, m * sizeof *r);
  memcpy(a->Wr, Wr, m * sizeof *Wr);
}

void dlsi_auto_map(void *automatic, int nc, const int *from) {
  dlsi_auto *work = automatic;
  if (work->part[PUSH]) dlsi_nlgs_map(work->part[PUSH], nc, from);
  if (work->part[NEWTON]) dlsi_newton_map(work->part[NEWTON], nc, from);
  work->mapped = 0;
  if (!from || !work->answers) return;
  int kept = 0;
  for (int c = 0; c < nc; c++) {
    if (from[c] >= work->last_nc) work->answers = 0; /* of an earlier solve */
    kept += from[c] >= 0;
  }
  if (!work->answers) return;
  rename_answer(work, &work->last, nc, from);
  if (work->answers == 2) rename_answer(work, &work->former, nc, from);
  work->mapped = kept < nc || kept < work->last_nc; /* some have come or gone */
  work->last_nc = nc;
}

dls_status dlsi_auto_begin_with_newton(dlsi_auto *work, dls_error *error) {
  if (!may_begin_with_newton(work)) return DLS_STALLED;
  dls_status status = dlsi_auto_create_part(work, NEWTON, error);
  if (status) return status;
  work->stepped = 1;
  work->of_step = expect_of_step(work);
  dlsi_newton_keep(work->part[NEWTON], work->start > 0 ? work->v[0] : NULL,
                   work->start > dlsi_auto_far_start);
  status = dlsi_auto_take_step(work, (step){NEWTON, 0, 0}, error);
  work->history = (dlsi_auto_history){.last = NEWTON}; /* no failure */
  if (!work->info.stages && status >= 0) {             /* without a step */
    work->stepped = 0;
    return DLS_STALLED;
  }
  if (status < 0) return status;
  if (dlsi_auto_verdict_of(work) != DLS_STALLED) return dlsi_auto_verdict_of(work);
  work->failed_to_step = 1;
  if (work->start > 0)
    offer(work, work->last.r); /* what the step has begun with has no certificate */
  if (work->stopped) return work->stopped;
  return status == DLS_TIME_LIMIT ? status : DLS_STALLED;
}

/* Remembers for (SQ2) what the solve took. */
void dlsi_auto_remember_cost(dlsi_auto *work, const double *r) {
  const dls_info *info = &work->info;
  if (!info->stages) return; /* it had nothing to do */
  const double k = info->factorisations ? dlsi_auto_count_unknowns(work->problem, r) : 0;
  const double factors = 3 + k * k / (10. * work->problem->d * work->problem->nc);
  double cost = 0;
  for (int s = 0; s < info->stages; s++) {
    const int newton = info->stage[s].method == DLS_NEWTON;
    cost += (newton ? dlsi_auto_step_sweeps : 1) * info->stage[s].iterations;
    cost += newton ? factors * info->stage[s].factorisations : 0;
  }
  if (!work->stepped) {
    work->of_step *= .98;
    work->swept = cost;
  } else {
    if (!work->in_steps && info->factorisations) cost -= factors;
    work->of_step += (cost - work->of_step) / 6;
  }
  work->in_steps = work->stepped;
}
