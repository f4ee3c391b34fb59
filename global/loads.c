/*
 * loads.c: loads that a body balances in itself, split off (linear/own.h).
 *
 *   (LO1)  A pair that holds only with all of |f| in the scale of equilibrium (base/equilibrium.c)
 *          ends the solve: split, and solve again. So does a solve that found nothing, or one that
 *          takes more than 40 iterations while loads are 100 times the contact forces.
 *   (LO2)  B = (K + eps H_p H_p^T + E)^-1, summed over bodies p, round variables: each side of a
 *          contact is held by itself, or f' of a light body would carry the weight of its
 *          neighbours. It has the pattern of A. A host's solver holds both sides together.
 *   (LO3)  If 4 times the rounding level of equilibrium is above tol and 1e-8, the best pair is
 *          measured once more without rigid motions (OW5).
 */
#include <stdlib.h>
#include <string.h>

#include "global_internal.h"
#include "solved.h"

static const double host_accuracy = 1e-6; /* of a solve of (OW1), which gains that much a step */

static dls_status loads_solve(void *data, double *x, dls_error *error) {
  dls_global *work = data;
  if (work->system) return dlsi_system_solve(work->system, x, error);
  memcpy(work->y, x, (size_t)work->n * sizeof *x);
  memset(x, 0, (size_t)work->n * sizeof *x);
  return dlsi_host_solve(work->solver.solve, work->solver.data, work->y, x, host_accuracy, error);
}

int dlsi_global_is_split(const dls_global *global) {
  return global->is_split;
}

/* (LO2) */
static dls_status loads_factor(dls_global *work, dls_error *error) {
  if (work->system) {
    work->factorisations++;
    return dlsi_system_factor_apart(work->system, dlsi_own_share, work->part, error);
  }
  work->rho = dlsi_own_share;
  return dlsi_global_factor(work, error);
}

dls_status dlsi_global_split_off(dls_global *work, dls_error *error) {
  const dlsi_own of = {&work->body, loads_solve, work};
  const size_t n = (size_t)work->n;
  long double *x = malloc((n + 1) * sizeof *x);
  double *rest = dlsi_alloc(n, sizeof *rest);
  dls_status status = x && rest ? DLS_OK : dlsi_no_memory(error);
  status = dlsi_joined_status(work->body.ranks, status, error);
  if (!status) status = loads_factor(work, error);
  if (!status) status = dlsi_own_split(&of, work->f, x, rest, error);
  if (!status) {
    dlsi_own_balanced(&work->body, work->f, rest, work->balanced);
    memcpy(work->f, rest, n * sizeof *work->f);
    work->body.balanced = work->balanced;
    dlsi_own_blur(&work->body, x, rest, work->blur); /* rest is spent */
    work->body.blur = work->blur;
    dlsi_own_look(&work->body, x, work->gap);
    for (size_t j = 0; j < n; j++)
      work->own[j] = (double)x[j];
    for (int k = 0; k < work->m; k++)
      work->g[k] = work->gap[k] / work->root[k];
    work->load = work->f;
    work->is_split = 1;
  }
  free(rest);
  free(x);
  return status;
}

dls_status dlsi_global_land(dls_global *work, dls_status verdict, dls_error *error) {
  const dlsi_own of = {&work->body, loads_solve, work};
  const double tol = work->limits->tol;
  if ((verdict != DLS_OK && verdict != DLS_TO_ROUNDING) || work->body.joint ||
      !dlsi_global_touches(work) || !(4 * work->best.floor_e > fmax(tol, 1e-8)))
    return verdict;
  memcpy(work->x, work->best_x, (size_t)work->n * sizeof *work->x);
  dls_status status = loads_factor(work, error);
  if (!status) status = dlsi_own_land(&of, work->x, work->gap, error);
  if (status) return status;
  for (int j = 0; j < work->n; j++) {
    work->flight[j] += work->best_x[j] - work->x[j];
    work->f[j] = work->load ? work->load[j] : 0;
  }
  for (int k = 0; k < work->m; k++) {
    work->g[k] = work->gap[k] / work->root[k];
    work->r[k] = work->best_r[k] * work->root[k];
  }
  work->is_split = 1;
  work->best = (dls_certificate){.residual = INFINITY, .body = -1};
  status = dlsi_global_measure(work, work->r, &work->best);
  if (status != DLS_STALLED) return status;
  memcpy(work->best_x, work->x, (size_t)work->n * sizeof *work->x);
  return DLS_NOT_IN_EQUILIBRIUM;
}
