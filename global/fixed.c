/*
 * fixed.c: the fixed point of s = mu |u_t| by convex problems, d = 2 and 3.
 *
 *   (GF1)  x, r := the convex problem with gaps g + s (interior.c), and springs of 1e-12 of K that
 *          have no force at the previous x
 *   (GF2)  Newton steps from there (newton.c), with springs of 1e-10 if the states leave a motion
 *          free: a block whose contacts all slip, to both sides
 *   (GF3)  s := mu |H_t^T x + g_t|
 *
 * Rigid bodies that rest, K = 0, have s = 0: with `rests` (GF1) alone, and x = 0 if g = 0.
 *
 * A fixed point of (GF1), (GF3) meets the law. It depends on no start. That helps if the splitting
 * converges slowly or has run away. Source: Acary, Cadoux, Lemarechal and Malick, ZAMM 91, 2011,
 * 155-175, who prove existence by it. Cost: 10 to 40 factorisations of (GF1), 3 to 12 of (GF2), at
 * most 10 times. What can fail: (GF3) may cycle. (GF1) computes contacts without force and gap to
 * about 1e-6. Newton steps from there may cycle, too.
 */
#include <stdlib.h>
#include <string.h>

#include "global_internal.h"

enum { most_turns = 10 };

static const double hold_convex = 1e-12, hold_newton = 1e-10;

static dls_status fixed_run(dls_global *work, int rests, double *g, double *x, double *r,
                            dls_error *error) {
  const int d = work->d;
  memcpy(g, work->g, (size_t)work->m * sizeof *g);
  for (int turn = 0; turn < most_turns; turn++) {
    dls_certificate now;
    dls_status status = dlsi_global_interior(work, hold_convex, 1, turn ? work->x : NULL, g, x, r,
                                             error); /* (GF1) */
    if (status && status != DLS_STALLED) return status;
    if (rests && dlsi_max_abs(g, (size_t)work->m) == 0) memset(x, 0, (size_t)work->n * sizeof *x);
    memcpy(work->x, x, (size_t)work->n * sizeof *x);
    dlsi_global_look(work, x, work->u);
    status = dlsi_global_measure(work, r, &now);
    if (rests) return status;
    if (status == DLS_STALLED)
      status = dlsi_global_newton(work, r, hold_newton, 0, error); /* (GF2) */
    if (status != DLS_STALLED) return status;
    dlsi_global_look(work, x, work->u); /* (GF3) */
    for (int c = 0; c < work->nc; c++)
      if (!dlsi_is_bonded(work->bend[c]))
        g[d * c] = work->g[d * c] + work->bend[c] * dlsi_tangent_norm(d, work->u + d * c);
  }
  return DLS_STALLED;
}

dls_status dlsi_global_fixed(dls_global *work, int rests, dls_error *error) {
  const size_t n = (size_t)work->n, m = (size_t)work->m;
  if (work->model.factorization == DLS_LU || m == 0) return DLS_STALLED;
  double *g = dlsi_alloc(2 * m + 2 * n, sizeof *g);
  if (!g) return dlsi_no_memory(error);
  double *x = g + 2 * m, *kept = x + n;
  memcpy(kept, work->x, n * sizeof *kept);
  const dls_status status = fixed_run(work, rests, g, x, g + m, error);
  memcpy(work->x, kept, n * sizeof *kept);
  free(g);
  return status;
}
