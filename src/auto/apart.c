/*
 * apart.c: finds contacts that stay open for all reactions.
 *
 *   u_n,c = q_n,c + sum_e (W_nn,ce r_n,e + W_nt,ce r_t,e)
 *        >= q_n,c + sum_e (W_nn,ce - mu_e |W_nt,ce|) r_n,e
 *
 * for r in the cones. Therefore r_c = 0 in each solution if q_n,c > 0 and no bracket is negative,
 * and the problem of the other contacts has the same solutions. This holds on an elastic body far
 * from its edges, not for rigid bodies, which act as levers. It pays if at least 40 % of them
 * are left out. Cost: at most d numbers of W for each pair. Without memory nothing is left out.
 */
#include <stdlib.h>
#include <string.h>

#include "auto/auto.h"

/* Returns 1 if the bracket of candidates c and e is not negative. */
static int apart_pushes(const dls_contact *problem, int c, int e) {
  const size_t d = (size_t)problem->d, ld = (size_t)problem->W.ld;
  const double *W = problem->W.a + d * (size_t)c + d * (size_t)e * ld, mu = problem->mu[e];
  double t2 = 0;
  for (size_t j = 1; j < d; j++)
    t2 += W[j * ld] * W[j * ld];
  return W[0] >= 0 && W[0] * W[0] >= mu * mu * t2; /* NaN for infinite friction: not proved */
}

/* Returns 1 if enough candidates are left out for the copy to pay. */
static int apart_pays(const dls_contact *problem, int far) {
  return problem->nc - far <= .6 * problem->nc;
}

int dlsi_list_touching(const dls_contact *problem, int **list) {
  const int nc = problem->nc;
  const size_t d = (size_t)problem->d;
  int far = 0, count = 0;
  *list = NULL;
  if (!problem->W.a || nc < 30) return 0;
  for (int c = 0; c < nc; c++)
    far += problem->q[d * (size_t)c] > 0;
  if (!apart_pays(problem, far)) return 0;
  int *const made = dlsi_alloc(2 * (size_t)nc, sizeof *made);
  if (!made) return 0;
  int *const apart = made + nc;
  for (int c = 0; c < nc; c++)
    apart[c] = problem->q[d * (size_t)c] > 0;
  for (int e = 0; e < nc && apart_pays(problem, far); e++)
    for (int c = 0; c < nc; c++)
      if (apart[c] && !apart_pushes(problem, c, e)) {
        apart[c] = 0;
        far--;
      }
  for (int c = 0; c < nc && apart_pays(problem, far); c++)
    if (!apart[c]) made[count++] = c;
  if (count > 0)
    *list = made;
  else
    free(made);
  return count;
}

void dlsi_auto_put_among_all(const dlsi_auto *work, const double *r, double *all) {
  const size_t d = (size_t)work->d;
  memset(all, 0, d * (size_t)work->whole * sizeof *all);
  for (size_t k = 0; k < (size_t)work->touches; k++)
    memcpy(all + d * (size_t)work->touching[k], r + d * k, d * sizeof *all);
}

/* Solves the problem of `count` candidates that may touch. values: memory of the copy.
 * Returns as take_touching does. */
static dls_status take_others(dlsi_auto *work, const dls_contact *problem, int count,
                              double *values, dlsi_auto_solve_fn solve, dls_error *error) {
  dls_contact others;
  dlsi_subset(problem, count, work->touching, values, NULL, &others);
  work->touches = count;
  const dls_status status = solve(work, &others, error);
  memcpy(work->r, work->best, (size_t)problem->d * (size_t)count * sizeof *work->r);
  dlsi_auto_put_among_all(work, work->r, work->best);
  work->touches = 0;
  work->problem = problem;
  if (status < 0) return status;
  dlsi_auto_set_weights(work);
  dlsi_contact_multiply(problem, NULL, work->best, work->v[0], work->v[1]);
  dlsi_contact_measure(problem, work->best, work->v[0], work->v[1], work->weights, work->v[2],
                       &work->info.certificate);
  if (dlsi_auto_verdict_of(work) != DLS_STALLED) return dlsi_auto_verdict_of(work);
  return work->stopped || status == DLS_TIME_LIMIT ? status : DLS_STALLED;
}

/* Returns DLS_OK, an error, the reason for an end by the caller, or DLS_STALLED to go on. */
dls_status dlsi_auto_take_touching(dlsi_auto *work, const dls_contact *problem,
                                   dlsi_auto_solve_fn solve, dls_error *error) {
  const int count = dlsi_list_touching(problem, &work->touching);
  const size_t d = (size_t)problem->d, n = (size_t)count, m = d * n;
  dls_status status = DLS_STALLED;
  if (count == 0) return status;
  double *values = dlsi_alloc(m * m + m + 3 * n + d * (size_t)problem->nc, sizeof *values);
  if (values) {                               /* else the whole, which needs no copy */
    work->shown = values + m * m + m + 3 * n; /* behind W, q, mu, weights */
    status = take_others(work, problem, count, values, solve, error);
  }
  free(values);
  free(work->touching);
  work->touching = NULL;
  return status;
}
