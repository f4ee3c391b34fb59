/*
 * scatter.c: Newton steps from scattered states, where the splitting and all else have failed.
 *
 *   (GS1)  Each turn draws a share of open contacts. In even turns x = 0 and every contact is
 *          drawn: open, sticking, or slipping in a direction that is drawn. In odd turns x and r
 *          are the best pair, and up to half of the contacts are drawn.
 *   (GS2)  Scattered Newton steps from there: (GN4) of newton.c.
 *   (GS3)  Ends with a pair that is solved, after 300 turns, or after 1e6 / (n + m) steps.
 *
 * With large friction a problem has several solutions or few, and which contacts touch, stick and
 * slip is a question of combinations: no descent leads to the answer. Draws depend on the turn
 * alone: the same problem takes the same steps. Cost: an LU for each step. Fails: finds nothing.
 */
#include <math.h>

#include "global_internal.h"
#include "solved.h"

enum { most_turns = 300, most_contacts = 500 };

static const double hold = 1e-10;    /* as fixed.c */
static const double most_work = 1e6; /* steps times unknowns */

/* (GS1) Sets x, u, r of turn k. What is drawn is larger than all of r and u: it is the state. */
static void scatter_draw(dls_global *work, int k, uint64_t *draw, double *r) {
  const int d = work->d, again = k % 2;
  const double share = dlsi_draw(*draw += DLSI_GOLDEN_BITS);
  double most = 0;
  for (int j = 0; j < work->n; j++)
    work->x[j] = again ? work->best_x[j] : 0;
  dlsi_global_look(work, work->x, work->u);
  for (int i = 0; i < work->m; i++) {
    r[i] = again ? work->best_r[i] * work->root[i] : 0;
    most = fmax(most, fabs(r[i]) + fabs(work->u[i]));
  }
  for (int c = 0; c < work->nc; c++) {
    double v[4];
    for (int i = 0; i < 4; i++)
      v[i] = dlsi_draw(*draw += DLSI_GOLDEN_BITS);
    if (again && v[0] > share / 2) continue;
    const int open = v[1] < (again ? 1. / 3 : share);
    const double bound = dlsi_friction_bound(work->bend[c], 1);
    double *rc = r + d * c;
    rc[0] = (open ? -4 : 4) * most;
    for (int i = 1; i < d; i++)
      rc[i] = 0;
    if (open || dlsi_is_bonded(work->bend[c]) || dlsi_draw(*draw += DLSI_GOLDEN_BITS) < 0.5)
      continue;
    const double angle = 6.283185307179586 * v[2];
    rc[1] = 8 * bound * most * (d == 3 ? cos(angle) : v[2] < 0.5 ? 1 : -1);
    if (d == 3) rc[2] = 8 * bound * most * sin(angle);
  }
}

dls_status dlsi_global_scatter(dls_global *work, dls_status failed, dls_error *error) {
  const int before = work->factorisations;
  work->unscattered = work->best.residual;
  const double unknowns = (double)work->n + work->m;
  dls_status status = DLS_STALLED;
  uint64_t draw = 0;
  if (!work->system || work->m == 0 || work->nc > most_contacts) return failed;
  for (int k = 0; k < most_turns && status == DLS_STALLED; k++) {
    work->scattered = work->factorisations - before;
    if (!(unknowns * work->scattered < most_work)) break;
    scatter_draw(work, k, &draw, work->before);
    status = dlsi_global_newton(work, work->before, hold, draw, error); /* (GS2) */
  }
  work->scattered = work->factorisations - before;
  return status == DLS_STALLED ? failed : status;
}

int dlsi_global_scattered(const dls_global *global, double *before) {
  *before = global->unscattered;
  return global->scattered;
}
