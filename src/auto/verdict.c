/*
 * verdict.c: the status if there is no answer.
 *
 *   DLS_NO_SOLUTION         Lemke's method has a proof (facts/farkas.c)
 *   DLS_NO_SOLUTION_LIKELY  W shows no reason for a solution (vi/exists.c), and one of
 *                             - the linear problem of farkas.c shows that none could be certified
 *                             - all steps failed, d = 2, up to 8 contacts, and no states have a
 *                               solution (facts/states.c)
 *                             - all steps failed, d = 3, up to 2 contacts, no r is near the
 *                               tolerance, and the augmented Lagrangian sees r run away
 *   DLS_TO_ROUNDING         nothing is proved against a solution, up to dlsi_predicted_rows rows,
 *                           and Krawczyk's test (facts/prove.c) proves the best r, improved by its
 *                           Newton steps, to 1e-4: only its rounding fails the certificate
 *   DLS_STALLED             else. Larger problems whose reactions run away may have a solution that
 *                           no step finds
 */
#include <string.h>

#include "auto/auto.h"

/* Returns 1 if the augmented Lagrangian has ended with a direction delta along which W delta is 0
 * up to rounding: w: weights, set already. */
static int runs_away(const dlsi_auto *work) {
  const dls_contact *problem = work->problem;
  const size_t d = (size_t)problem->d, m = d * (size_t)problem->nc;
  const double *delta = dlsi_augmented_method.direction(work->part[AUGMENTED]);
  double *v = work->v[0];
  if (!delta) return 0;
  dlsi_contact_apply(problem, delta, v);
  for (size_t k = 0; k < m; k++)
    v[k] /= work->w[k / d];
  return dlsi_max_abs(v, m) <= 1e-10 * dlsi_max_abs(delta, m);
}

dls_status dlsi_auto_judge(dlsi_auto *work, dls_error *error) {
  const dls_contact *problem = work->problem;
  const double tol = work->options.limits.tol;
  const size_t m = (size_t)problem->d * (size_t)problem->nc;
  const int sure = work->excluded, few = problem->d == 2 && problem->nc <= dlsi_most_states;
  double *J = work->room.J;
  if (work->bonded || work->firm) return DLS_STALLED;
  work->room.owner = work;
  if (few && !sure) {
    const int found = dlsi_contact_find_states(problem, &work->options.limits, work->begun, work->r,
                                               work->best, &work->info.certificate);
    if (dlsi_clock_is_over(&work->options.limits, work->begun)) return DLS_TIME_LIMIT;
    const dls_status status =
        found ? dlsi_auto_take_step(work, (step){NEWTON, 0, 0}, error) : DLS_STALLED;
    if (status < 0) return status;
    if (dls_certificate_holds(&work->info.certificate, tol)) return DLS_OK;
    if (found) return DLS_STALLED;
  }
  if (!few && !sure && (problem->nc > 2 || dlsi_auto_may_settle(work))) return DLS_STALLED;
  if (!dlsi_auto_may_follow_path(work) || work->room.side < m) return DLS_STALLED;
  dlsi_contact_weights(problem, work->w);
  if (!few && !sure && !runs_away(work)) return DLS_STALLED;
  if (!few && !sure && !dlsi_is_semidefinite(problem, work->w, J)) return DLS_STALLED;
  if (dlsi_solution_exists(problem, work->w, J, work->v)) return DLS_STALLED;
  return DLS_NO_SOLUTION_LIKELY;
}

dls_status dlsi_auto_prove(dlsi_auto *work, const dls_contact *problem, dls_status status) {
  const size_t m = (size_t)problem->d * (size_t)problem->nc;
  dls_certificate now;
  dls_proof proof;
  if (status != DLS_STALLED && status != DLS_NO_SOLUTION_LIKELY) return status;
  if (dlsi_auto_has_plan(work)) return status; /* it says what is done */
  if (m > dlsi_predicted_rows || dlsi_first_not_finite(work->best, m) >= 0) return status;
  if (dlsi_contact_prove(problem, work->best, &proof, work->r, NULL)) return status; /* no memory */
  if (proof.kind != DLS_PROVED || !(proof.radius <= dlsi_auto_accurate)) return status;
  if (dls_contact_certify(problem, work->r, NULL, &now, NULL)) return status;
  memcpy(work->best, work->r, m * sizeof *work->r);
  work->info.certificate = now;
  return dls_certificate_holds(&now, work->options.limits.tol) ? DLS_OK : DLS_TO_ROUNDING;
}
