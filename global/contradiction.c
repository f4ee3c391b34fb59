/*
 * contradiction.c: proves that joints ask for something that no motion can do.
 *
 * A redundant joint j is a combination of others: K b = 0 for a b of multipliers alone, b_j = 1.
 *
 *   (GC1)  x of a step holds all other joints. If j does not hold, A y = column j of K,
 *          b := e_j - y, with 0 in place of y at positions
 *   (GC2)  Check by the user's numbers: |K b|_i <= 100 eps sum_k |K_ik|; b^T f more than 1e-10
 *          |b|^T |f|. H^T b = 0.
 *
 * Then b^T (f + H r) > 0 for all r, but b^T K x = 0. As in motion.c, K must be symmetric.
 * Cost: a product with K; if a joint does not hold, also a solve and three products.
 */
#include <stdlib.h>
#include <string.h>

#include "global_internal.h"

static const double rounding = 1e-12; /* of b: that of the solve */
static const double slack = 100 * DBL_EPSILON;
static const double certain = 1e-10; /* of the sum of absolute terms: more than rounding */

/* Returns the redundant joint that holds least, -1 if all hold. */
static int contradiction_find(const dls_global *work, double *Kx, double *a) {
  int worst = -1;
  double most = certain;
  dlsi_body_multiply(&work->whole, work->x, Kx, a);
  for (int k = 0; k < work->apart.count; k++) {
    const int j = work->apart.redundant[k];
    const double f = work->load ? work->load[j] : 0, size = a[j] + fabs(f);
    const double part = size > 0 ? fabs(Kx[j] - f) / size : 0;
    if (!(part > most)) continue;
    most = part;
    worst = j;
  }
  return worst;
}

/* (GC1) b of joint j. scratch: n. */
static dls_status contradiction_vector(dls_global *work, int j, double *b, double *scratch,
                                       dls_error *error) {
  const size_t n = (size_t)work->n;
  double most = 0;
  memset(scratch, 0, n * sizeof *scratch);
  scratch[j] = 1;
  dlsi_body_multiply(&work->whole, scratch, b, NULL);
  const dls_status status = dlsi_system_solve(work->system, b, error);
  for (size_t k = 0; k < n; k++) {
    b[k] = !work->body.joint[k] ? 0 : (k == (size_t)j) - b[k];
    if (fabs(b[k]) > most) most = fabs(b[k]);
  }
  for (size_t k = 0; k < n; k++)
    b[k] = fabs(b[k]) > rounding * most ? b[k] / most : 0;
  return status;
}

/* (GC2) Turns b so that b^T f > 0. Returns 0 if b proves nothing. */
static int contradiction_holds(const dls_global *work, double *b, double *Kb, double *a) {
  const size_t n = (size_t)work->n;
  double load = 0, turmoil = 0;
  for (size_t k = 0; k < n; k++) {
    const double f = work->load ? work->load[k] : 0;
    load += b[k] * f;
    turmoil += fabs(b[k] * f);
    Kb[k] = 1;
  }
  dlsi_body_multiply(&work->whole, Kb, work->y, a);
  dlsi_body_multiply(&work->whole, b, Kb, NULL);
  for (size_t k = 0; k < n; k++) {
    if (!(fabs(Kb[k]) <= slack * a[k])) return 0;
    if (load < 0) b[k] = -b[k];
  }
  return fabs(load) > certain * turmoil;
}

dls_status dlsi_global_contradict(dls_global *work, int *proved, dls_error *error) {
  const size_t n = (size_t)work->n;
  *proved = 0;
  if (work->apart.count == 0 || work->model.factorization == DLS_LU) return DLS_OK;
  double *scratch = dlsi_alloc(2 * n, sizeof *scratch);
  if (!scratch) return dlsi_no_memory(error);
  const int j = contradiction_find(work, scratch, scratch + n);
  dls_status status = DLS_OK;
  if (j >= 0) status = contradiction_vector(work, j, work->motion, scratch, error);
  if (!status && j >= 0 && contradiction_holds(work, work->motion, scratch, scratch + n)) {
    *proved = work->moves = 1;
    work->mover = -1;
  }
  free(scratch);
  return status;
}
