/*
 * price.c: what a step costs, in sweeps of Gauss-Seidel with Anderson's acceleration. The one cost
 * model of auto; build/bench/auto --price measures it, and fails beyond a factor of 2. k: unknowns
 * that the states leave, m: rows.
 *
 *   (PR1)  a step of Newton's method: min(s, 50) sweeps, s = max(5 + k / 12, k / 6), in 3D, where a
 *          sweep takes longer, two thirds of that; W dense k^2 / (6 m) if that is more: a step
 *          multiplies by W twice and factorises k^3 where a sweep reads k m; W by blocks, d = 3,
 *          (k / 6000)^2 times as many from 6000 on, for the fill
 *   (PR2)  all of Newton's method: s steps. s = d - 1 for a dense W whose k has not changed since
 *          the last look: with the right states a step is exact in 2D, and two do in 3D; else
 *          s = 4. Each failure of Newton's method doubles s.
 *   (PR3)  all of splitting: 50 max(mu, 1)^2 m / k sweeps, its factorisation included; mu: the mean
 *          of the candidates with a reaction. Its iterations read m^2 where a sweep reads k m.
 *   (PR4)  what a line of the report has cost: a table of its iterations and factorisations
 *   (PR5)  all of the augmented Lagrangian: 40 steps of Newton's method; in 2D (k / 2000)^2 times
 *          as many from 2000 on, because packings of discs of all sizes have much fill
 */
#include <math.h>

#include "auto/auto.h"

static const double on_cone = 1e-9; /* a reaction that lacks no more than this share slips */

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

double dlsi_auto_cost_of_split(const dlsi_auto *work) {
  const dls_contact *problem = work->problem;
  double sum = 0, count = 0;
  for (int c = 0; c < problem->nc; c++) {
    const int presses = work->r[problem->d * c] > 0;
    sum += presses ? problem->mu[c] : 0;
    count += presses;
  }
  const double mu = fmax(count > 0 ? sum / count : 0, 1), m = (double)problem->d * problem->nc;
  return 50 * mu * mu * m / fmax(work->unknowns, 1);
}

/* Returns the sweeps that a step of Newton's method takes with k unknowns, (PR1). */
static double price_of_step(const dls_contact *problem, double k) {
  const int dense = problem->W.a != NULL;
  const double m = (double)problem->d * problem->nc;
  const double fill = !dense && problem->d == 3 && k > 6000 ? k / 6000 : 1;
  const double sweeps = fmax(5 + k / 12, k / 6) / (problem->d == 3 ? 1.5 : 1);
  const double usual = fmin(sweeps, dlsi_auto_most_of_step) * fill * fill;
  return dense ? fmax(usual, k * k / (6 * m)) : usual;
}

double dlsi_auto_cost_of_newton(dlsi_auto *work) {
  const dls_contact *problem = work->problem;
  const int dense = problem->W.a != NULL;
  const double k = dlsi_auto_count_unknowns(problem, work->r);
  const int settled = dense && k == work->unknowns;
  work->unknowns = k;
  work->step = price_of_step(problem, k);
  work->costly = dense && !settled && work->step > dlsi_auto_most_of_step;
  return (settled ? problem->d - 1 : 4) * (1 << dlsi_auto_failures(work)) * work->step;
}

double dlsi_auto_cost_of_augmented(const dlsi_auto *work) {
  const double k = dlsi_auto_count_unknowns(work->problem, work->r);
  const double fill = work->d == 2 ? fmax(k / 2000, 1) : 1;
  return 40 * fill * fill * price_of_step(work->problem, k);
}

/* Returns the factorisations that cost a turn of the augmented Lagrangian. */
int dlsi_auto_factors_of_turn(const dlsi_auto *work) {
  const double k = dlsi_auto_count_unknowns(work->problem, work->best);
  return (int)fmax(1, work->turn / price_of_step(work->problem, k));
}

/* (PR4). Steps of Newton's method on factors that serve on take 5 sweeps; an augmentation about 10
 * beside its steps; iterations of splitting a product, by blocks with few rows that of a dense
 * factor, with more what a sparse solve takes at least; pivots write the table of an LCP. */
double dlsi_auto_price_of(const dls_contact *problem, double k, const dls_stage *stage) {
  const int d = problem->d, dense = problem->W.a != NULL;
  const double factorise = price_of_step(problem, k), m = (double)d * problem->nc;
  const double n = stage->iterations, factors = stage->factorisations;
  switch (stage->method) {
  case DLS_NEWTON:
    return factors * factorise + (n - factors) * 5;
  case DLS_ADMM:
    return n * (dense ? 1 + m / 180 : m <= 250 ? 1 + m / 80 : 8.5);
  case DLS_AUGMENTED_LAGRANGIAN:
  case DLS_PENALTY:
    return n * 10 + factors * factorise;
  case DLS_HOMOTOPY:
    return factors * m / (dense && d == 3 ? 9 : 5);
  case DLS_LEMKE:
    return 15 + n * (d < 3 ? .7 : dense ? 1.4 : 2.1) * pow(m / fmax(k, 1), 2. / 3);
  default:
    return n;
  }
}
