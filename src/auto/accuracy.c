/*
 * accuracy.c: improves answers with a large error. If W is nearly singular, as for a body on soft
 * springs, the error may be large although the residual is small. The problem is then solved to
 * smaller tolerances as long as the predicted error falls (facts/sensitivity.c).
 *
 *   (AC1)  the error is predicted if W may hide one (SN6), and the caller asks for dls_info
 *   (AC2)  in a sequence of warm solves, error / residual of the last predicted answer is used
 * Also searches for other answers, at low cost. front/diagnose.c finds out more.
 */
#include <float.h>
#include <math.h>

#include "auto/auto.h"

/* Sets info.error, and how much a residual means. Returns the error, -1 where r is not determined,
 * or INFINITY without memory. */
static double predict(dlsi_auto *work) {
  const dls_contact *problem = work->problem;
  const size_t m = (size_t)problem->d * (size_t)problem->nc;
  if (work->options.lazy && dlsi_room_dense(&work->room, m, NULL)) return INFINITY;
  dlsi_auto_set_weights(work);
  work->room.owner = work;
  const double predicted =
      dlsi_predict_error(problem, work->best, work->weights, work->room.J, work->v[1]);
  work->info.error = predicted < 0 ? INFINITY : predicted; /* not determined */
  work->amplified = work->info.error / fmax(work->info.certificate.residual, DBL_EPSILON);
  return predicted;
}

dls_status dlsi_auto_take_to_accuracy(dlsi_auto *work, int asked, dls_status status,
                                      dls_error *error) {
  const dls_contact *problem = work->problem;
  const size_t m = (size_t)problem->d * (size_t)problem->nc;
  const double tol = work->options.limits.tol, enough = fmax(dlsi_auto_accurate, 100 * tol);
  const dls_certificate *best = &work->info.certificate;
  const int rows = problem->W.a ? dlsi_predicted_rows : dlsi_predicted_of_blocks;
  if (!asked || m > (size_t)rows) return status;
  const int known = work->amplified > 0 && work->last_nc == problem->nc;
  const double likely = work->amplified * fmax(best->residual, DBL_EPSILON);
  if (work->options.limits.warm_start && known && likely <= enough) {
    work->info.error = likely; /* (AC2) */
    return status;
  }
  dlsi_auto_set_weights(work);
  if (!dlsi_may_hide_error(problem, work->weights, &work->info)) return status; /* (AC1) */
  double before = INFINITY;
  for (int turn = 0; turn == 0 || status == DLS_OK; turn++) {
    const double predicted = predict(work);
    if (status != DLS_OK) break; /* no better one to rounding */
    if (!(predicted > enough && predicted < before / 2) || turn == 3) break;
    if (dlsi_auto_has_plan(work) || best->residual <= DBL_EPSILON) break; /* followed once */
    before = predicted;
    work->options.limits.tol = fmax(best->residual * enough / before / 2, DBL_EPSILON);
    status = dlsi_auto_follow(work, dlsi_auto_first_plan(work), error);
    work->options.limits.tol = tol;
    if (status >= 0) status = dlsi_settled(best, tol, work->stopped ? work->stopped : DLS_STALLED);
  }
  return status;
}

enum { few_normals = 6 }; /* whose factorisation is below the cost of a call */

/* Returns room for W_nn, or NULL where there is friction, its factorisation would be more than a
 * small part of what the solve took, or the room keeps factors for the next solve. */
static double *room_of_normals(dlsi_auto *work) {
  const size_t n = (size_t)work->problem->nc;
  const double m = (double)n * work->problem->d, cost = (double)n * (double)n * (double)n / 3;
  for (size_t c = 0; c < n; c++)
    if (work->problem->mu[c] > 0) return NULL;
  if (work->options.limits.warm_start) return NULL;
  if (n > few_normals && !dlsi_is_small_part(cost, &work->info, m)) return NULL;
  if (work->options.lazy && dlsi_room_dense(&work->room, n, NULL)) return NULL;
  if (work->room.side < n) return NULL;
  work->room.owner = work;
  return work->room.J;
}

/* Counts the ambiguous candidates. Sets unique to no if as many sweeps as the answer r took, from
 * where these have another solution by themselves, end at another answer. */
static void sweep_to_another(dlsi_auto *work, const double *r, const double *u) {
  const dls_contact *problem = work->problem;
  const size_t d = (size_t)problem->d, m = d * (size_t)problem->nc;
  double *other = work->v[1];
  dls_limits limits = {.tol = work->options.limits.tol, .warm_start = 1};
  dls_info info;
  if (!u) dlsi_contact_multiply(problem, NULL, r, work->v[0], NULL);
  work->info.ambiguous = dlsi_count_ambiguous(problem, r, u ? u : work->v[0], other);
  if (!work->info.ambiguous || !work->part[SWEEPS]) return;
  limits.cpu_seconds = dlsi_clock_left(&work->options.limits, work->begun);
  limits.max_iterations = work->info.iterations > 10 ? work->info.iterations : 10;
  dlsi_set_limits(&dlsi_nlgs_method, work->part[SWEEPS], &limits);
  if (dlsi_nlgs_method.solve(work->part[SWEEPS], problem, other, NULL, &info, NULL)) return;
  double difference = 0, size = 0;
  for (size_t k = 0; k < m; k++) {
    const double w = work->w[k / d];
    difference = fmax(difference, fabs(w * (other[k] - r[k])));
    size = fmax(size, fabs(w * r[k]));
  }
  if (difference > 1e-3 * size) work->info.unique = DLS_UNIQUE_NO;
}

void dlsi_auto_look_for_others(dlsi_auto *work, const double *r, const double *u) {
  const dls_contact *problem = work->problem;
  const int ambiguous = dlsi_may_be_ambiguous(problem);
  if (!ambiguous && dlsi_is_factored(problem)) return; /* nothing is shown of W there */
  dlsi_auto_set_weights(work);
  if (ambiguous)
    sweep_to_another(work, r, u);
  else if (dlsi_is_unique(problem, work->w, work->v[2], room_of_normals(work)))
    work->info.unique = DLS_UNIQUE_YES;
}
