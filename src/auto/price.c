/*
 * price.c: what a step costs, in sweeps of Gauss-Seidel. The one cost model of auto.
 *
 *   (PR1)  Newton's method: s steps of min(max(5 + k / 12, k / 6), 50) sweeps, k unknowns, or, W
 *          dense, k^2 / (6 m) if that is more: a step multiplies by W twice and factorises k^3
 *          where a sweep reads k m; W by blocks, d = 3, (k / 6000)^2 times as many from 6000 on,
 *          for the fill. s = d - 1 for a dense W whose k has not changed since the last look: with
 *          the right states a step is exact in 2D, and two do in 3D; else s = 4. Each failure of
 *          Newton's method doubles s.
 *   (PR2)  splitting: 50 max(mu, 1)^2 m / k sweeps, its factorisation included; mu: the mean of the
 *          candidates with a reaction. Its iterations read m^2 where a sweep reads k m.
 */
#include <math.h>

#include "auto/auto.h"

enum { usual_splits = 50 };            /* sweeps in all, where m = k and mu <= 1 */
static const double few_filled = 6000; /* unknowns by blocks, d = 3 */
static const double on_cone = 1e-9;    /* a reaction that lacks no more than this share slips */

double dlsi_auto_count_unknowns(const dls_contact *problem, const double *r) {
  const int d = problem->d;
  double k = 0;
  for (int c = 0; c < problem->nc; c++, r += d) {
    const double mu = problem->mu[c];
    if (!(r[0] > 0)) continue;
    k += dlsi_tangent_norm(d, r) < (1 - on_cone) * mu * r[0] ? d : mu > 0 ? d - 1 : 1;
  }
  return k;
}

/* Returns the mean friction of the candidates with a reaction in r. */
static double mean_friction(const dls_contact *problem, const double *r) {
  double sum = 0, count = 0;
  for (int c = 0; c < problem->nc; c++, r += problem->d) {
    if (!(r[0] > 0)) continue;
    sum += problem->mu[c];
    count++;
  }
  return count > 0 ? sum / count : 0;
}

double dlsi_auto_cost_of_split(const dlsi_auto *work) {
  const double mu = fmax(mean_friction(work->problem, work->r), 1);
  const double m = (double)work->problem->d * work->problem->nc;
  return usual_splits * mu * mu * m / fmax(work->unknowns, 1);
}

double dlsi_auto_cost_of_newton(dlsi_auto *work) {
  const dls_contact *problem = work->problem;
  const int dense = problem->W.a != NULL;
  const double k = dlsi_auto_count_unknowns(problem, work->r), m = (double)problem->d * problem->nc;
  const int settled = dense && k == work->unknowns;
  const double fill = !dense && problem->d == 3 && k > few_filled ? k / few_filled : 1;
  const double usual = fmin(fmax(5 + k / 12, k / 6), 50) * fill * fill;
  const double dense_step = fmax(usual, k * k / (6 * m));
  work->unknowns = k;
  work->step = dense ? dense_step : usual;
  work->costly = dense && !settled && dense_step > 50;
  return (settled ? problem->d - 1 : 4) * (1 << work->failures) * work->step;
}
