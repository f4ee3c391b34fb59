/*
 * others.c: searches for other answers than a certified one, at low cost. front/diagnose.c finds
 * out more.
 */
#include <math.h>

#include "auto/auto.h"

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
  dlsi_nlgs_method.set_limits(work->part[SWEEPS], &limits);
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
