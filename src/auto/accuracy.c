/*
 * accuracy.c: improves answers with a large error. If W is nearly singular, as for a body on soft
 * springs, the error may be large although the residual is small. The problem is then solved to
 * smaller tolerances as long as the predicted error falls (facts/sensitivity.c).
 *
 *   (AC1)  the error is predicted if W may hide one (SN6); up to 60 rows only if the caller asks
 *          for dls_info: there the prediction would be half of the work
 *   (AC2)  in a sequence of warm solves, error / residual of the last predicted answer is used
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
  if (m > (size_t)rows) return status;
  if (!asked && m <= dlsi_predicted_of_blocks) return status;
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
