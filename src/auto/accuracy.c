/*
 * accuracy.c: an answer of little residual may have a large error where W is nearly singular, as
 * under a body on soft springs. Such a problem is solved to a smaller tolerance as long as that
 * makes the predicted error less (facts/sensitivity.c). In a sequence of warm solves the last
 * answer that was looked at tells how much a residual means.
 */
#include <float.h>
#include <math.h>

#include "auto/auto.h"

static const double accurate = 1e-4;    /* relative error of r that nobody is told of */
static const double determined = 1e-13; /* residual of a factorisation that needs no second one */
enum { most_turns = 3 };

dls_status dlsi_auto_take_to_accuracy(dlsi_auto *work, dls_error *error) {
  const dls_contact *problem = work->problem;
  const size_t m = (size_t)problem->d * (size_t)problem->nc;
  const double tol = work->options.limits.tol, enough = fmax(accurate, 100 * tol);
  const dls_certificate *best = &work->info.certificate;
  dls_status status = DLS_OK;
  const int rows = problem->W.a ? dlsi_predicted_rows : dlsi_predicted_of_blocks;
  const dls_info *info = &work->info;
  const int direct = m > dlsi_predicted_of_blocks && info->stages &&
                     info->stage[info->stages - 1].method != DLS_NLGS;
  if (m > (size_t)rows || best->residual == 0 || (direct && best->residual <= determined))
    return status;
  const int known = work->amplified > 0 && work->last_nc == problem->nc;
  if (work->options.limits.warm_start && known && work->amplified * best->residual <= enough) {
    work->info.error = work->amplified * best->residual;
    return status;
  }
  double before = INFINITY;
  for (int turn = 0; status == DLS_OK; turn++) {
    if (work->options.lazy && dlsi_room_dense(&work->room, m, NULL)) break;
    dlsi_auto_set_weights(work);
    work->room.owner = work;
    dlsi_contact_multiply(problem, NULL, work->best, work->v[0], NULL);
    const double predicted = dlsi_predict_error(problem, work->best, work->v[0], work->weights,
                                                work->room.J, work->v[1]);
    work->info.error = predicted < 0 ? INFINITY : predicted; /* not determined */
    work->amplified = work->info.error / best->residual;
    if (!(predicted > enough && predicted < before / 2) || turn == most_turns) break;
    if (dlsi_auto_has_plan(work)) break; /* followed once */
    before = predicted;
    work->options.limits.tol = fmax(best->residual * enough / before / 2, DBL_EPSILON);
    status = dlsi_auto_follow(work, dlsi_auto_first_plan(work), error);
    work->options.limits.tol = tol;
    if (status >= 0) status = work->stopped ? work->stopped : dlsi_auto_verdict_of(work);
  }
  return status;
}
