/*
 * accuracy.c: improves answers with a large error. If W is nearly singular, as for a body on soft
 * springs, the error may be large although the residual is small. The problem is then solved to
 * smaller tolerances as long as the predicted error falls (facts/sensitivity.c).
 *
 *   (AC1)  the error is predicted if W has few large eigenvalues:
 *          (tr S)^2 / |S|^2 < max(12, m / 16), S = D^-1/2 W D^-1/2, |S| Frobenius' norm, D the
 *          weights of the certificate. For k equal eigenvalues and no others the left side is k;
 *          two bodies on soft springs have 12
 *   (AC2)  in a sequence of warm solves, error / residual of the last predicted answer is used
 *
 * What can fail: more soft directions than that. The error of ordinary elastic bodies is 1 to 100
 * times their residual.
 */
#include <float.h>
#include <math.h>

#include "auto/auto.h"

/* Adds the entries of a d x d block of rows b and columns c of W, by their weights. */
static void add_block(const dlsi_auto *work, int b, int c, const double *block, size_t ld,
                      double *trace, double *square) {
  const size_t d = (size_t)work->d;
  for (size_t j = 0; j < d; j++)
    for (size_t i = 0; i < d; i++) {
      const double x = block[i + ld * j];
      const double w = work->weights[2 * b + (i > 0)], v = work->weights[2 * c + (j > 0)];
      *square += x * x / (w * v);
      if (b == c && i == j) *trace += x / w;
    }
}

/* (AC1) Returns 1 if W may hide an error. */
static int may_hide(const dlsi_auto *work) {
  const dls_contact *problem = work->problem;
  const int d = problem->d, nc = problem->nc;
  const dls_blocks *W = &problem->Wb;
  double trace = 0, square = 0;
  for (int b = 0; b < nc && problem->W.a; b++)
    for (int c = 0; c < nc; c++) {
      const size_t ld = (size_t)problem->W.ld, at = (size_t)(d * b) + ld * (size_t)(d * c);
      add_block(work, b, c, problem->W.a + at, ld, &trace, &square);
    }
  for (int b = 0; b < nc && !problem->W.a; b++)
    for (int k = W->p[b]; k < W->p[b + 1]; k++)
      add_block(work, b, W->i[k], W->x + (size_t)(d * d) * (size_t)k, (size_t)d, &trace, &square);
  const double m = (double)d * nc;
  return !(trace * trace >= fmax(dlsi_auto_directions, m / dlsi_auto_direction_of) * square);
}

/* Sets info.error, and how much a residual means. Returns the error, -1 where r is not determined,
 * or INFINITY without memory. */
static double predict(dlsi_auto *work) {
  const dls_contact *problem = work->problem;
  const size_t m = (size_t)problem->d * (size_t)problem->nc;
  if (work->options.lazy && dlsi_room_dense(&work->room, m, NULL)) return INFINITY;
  dlsi_auto_set_weights(work);
  work->room.owner = work;
  dlsi_contact_multiply(problem, NULL, work->best, work->v[0], NULL);
  const double predicted =
      dlsi_predict_error(problem, work->best, work->v[0], work->weights, work->room.J, work->v[1]);
  work->info.error = predicted < 0 ? INFINITY : predicted; /* not determined */
  work->amplified = work->info.error / work->info.certificate.residual;
  return predicted;
}

dls_status dlsi_auto_take_to_accuracy(dlsi_auto *work, int is_asked, dls_error *error) {
  const dls_contact *problem = work->problem;
  const size_t m = (size_t)problem->d * (size_t)problem->nc;
  const double tol = work->options.limits.tol, enough = fmax(dlsi_auto_accurate, 100 * tol);
  const dls_certificate *best = &work->info.certificate;
  const int rows = problem->W.a ? dlsi_predicted_rows : dlsi_predicted_of_blocks;
  if (m > (size_t)rows || best->residual == 0) return DLS_OK;
  const int known = work->amplified > 0 && work->last_nc == problem->nc;
  if (work->options.limits.warm_start && known && work->amplified * best->residual <= enough) {
    work->info.error = work->amplified * best->residual; /* (AC2) */
    return DLS_OK;
  }
  dlsi_auto_set_weights(work);
  if (!may_hide(work)) {
    if (is_asked) predict(work);
    return DLS_OK;
  }
  dls_status status = DLS_OK;
  double before = INFINITY;
  for (int turn = 0; status == DLS_OK; turn++) {
    const double predicted = predict(work);
    if (!(predicted > enough && predicted < before / 2) || turn == dlsi_auto_accurate_turns) break;
    if (dlsi_auto_has_plan(work)) break; /* followed once */
    before = predicted;
    work->options.limits.tol = fmax(best->residual * enough / before / 2, DBL_EPSILON);
    status = dlsi_auto_follow(work, dlsi_auto_first_plan(work), error);
    work->options.limits.tol = tol;
    if (status >= 0) status = work->stopped ? work->stopped : dlsi_auto_verdict_of(work);
  }
  return status;
}
