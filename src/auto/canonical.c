/*
 * canonical.c: solves a renumbered and scaled copy of the problem. If the first plan fails, up to
 * 300 rows, auto solves from r = 0 on a copy whose order and units follow from the data
 * (renumber.c), so that success does not depend on the numbers of the contacts. Only
 * dlsi_auto_on_copy changes to a copy and back.
 *
 * On the copy, frictions above 1e4, also infinite ones, are first replaced by 1e4, which pivots and
 * paths can handle. An answer in which these contacts do not slip is an answer of the problem.
 */
#include <float.h>
#include <math.h>
#include <string.h>

#include "auto/auto.h"

/* Turns to a copy of the problem, with r = 0 as the best. Returns the certificate of the best r of
 * the problem, which is work->kept then. */
static dls_certificate enter_copy(dlsi_auto *work) {
  const dls_contact *problem = work->problem;
  const size_t m = (size_t)problem->d * (size_t)problem->nc;
  const dls_certificate kept = work->info.certificate;
  memcpy(work->kept, work->best, m * sizeof *work->kept);
  memset(work->best, 0, m * sizeof *work->best);
  dlsi_renumber_set(&work->copy, problem, work->firm ? dlsi_auto_firm : INFINITY);
  work->problem = &work->copy.problem;
  work->info.certificate = dlsi_no_certificate;
  return kept;
}

/* Takes the vectors of the verdict back from the copy. */
static void take_back_vectors(dlsi_auto *work, dls_status status) {
  const dlsi_renumber *copy = &work->copy;
  const int excluded = work->excluded, proved = status == DLS_NO_SOLUTION;
  const double *delta = work->part[AUGMENTED] && !excluded && !proved
                            ? dlsi_augmented_method.direction(work->part[AUGMENTED])
                            : NULL;
  const double *v = proved || excluded ? dlsi_lemke_method.farkas(work->part[PIVOTING]) : NULL;
  work->has_direction = delta != NULL;
  work->has_farkas = v != NULL;
  if (delta) dlsi_renumber_back(copy, copy->problem.d, 0, delta, work->direction);
  if (v) dlsi_renumber_back(copy, 1, 0, v, work->farkas);
}

/* Takes the best r back from the copy if it is better than the one kept. Returns the status for the
 * problem. */
static dls_status leave_copy(dlsi_auto *work, const dls_contact *problem,
                             const dls_certificate *kept, dls_status status) {
  const dlsi_renumber *copy = &work->copy;
  const size_t m = (size_t)problem->d * (size_t)problem->nc;
  dls_certificate *best = &work->info.certificate;
  work->problem = problem;
  dlsi_renumber_back(copy, problem->d, copy->power_q - copy->power_W, work->best, work->r);
  dlsi_contact_multiply(problem, NULL, work->r, work->v[0], work->v[1]);
  dlsi_auto_set_weights(work);
  dlsi_contact_measure(problem, work->r, work->v[0], work->v[1], work->weights, work->v[2], best);
  /* forces beyond the range of numbers: an answer to the copy is none to the problem */
  const int in_range = best->residual <= DBL_MAX && dlsi_first_not_finite(work->r, m) < 0;
  if (in_range && (status == DLS_OK || dlsi_is_better(best, kept))) {
    memcpy(work->best, work->r, m * sizeof *work->best);
  } else {
    memcpy(work->best, work->kept, m * sizeof *work->best);
    *best = *kept;
  }
  if (status == DLS_NO_SOLUTION_LIKELY && best->residual <= work->options.limits.tol)
    return DLS_STALLED; /* only rounding speaks against this answer */
  return status;
}

dls_status dlsi_auto_on_copy(dlsi_auto *work, dlsi_auto_run_fn run, const step *plan,
                             dls_error *error) {
  const dls_contact *problem = work->problem;
  const dls_certificate kept = enter_copy(work);
  const dls_status status = run(work, plan, error);
  if (status < 0) return status;
  if (work->has_copy) take_back_vectors(work, status);
  return leave_copy(work, problem, &kept, status);
}
