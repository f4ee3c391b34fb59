/*
 * delassus/limit.h: how much a structure carries, with a proof on both sides.
 *
 *   K x = f0 + lambda f1 + H r,   u = H^T x + g,   friction mu + lambda mu1
 *
 * From lambda = settings.from, where there has to be an answer, towards settings.to: the last
 * lambda at which an answer was certified, and beyond it the first one at which a rigid motion b
 * proves that there is none,
 *
 *   K b = 0,   b.(f0 + lambda f1) > 0,   (H^T b)_n >= mu |(H^T b)_t| at each contact.
 *
 * b is the mechanism of collapse. For bodies that only contact holds (K = 0, or K of free bodies)
 * both meet: a load that no answer carries has such a motion (Farkas; limit analysis). They are the
 * limit of the associated law, which bounds that of Coulomb's law from above: with friction an
 * answer at a smaller load may still be left on another path. limit.unique says whether the answer
 * at `carried` is the only one. A body that K holds carries every load. W alone, q0 + lambda q1:
 * the model of a flexibility K^-1 = (W q1; 0 0), H = (1; 0), f1 = (0; 1), g = q0; then weights
 * (dls_solver_farkas) prove in place of b, and trials bisect.
 *
 * Each b gives the lambda from which on it proves, b.(f0 + lambda f1) = 0, which is the next trial
 * (Newton's method on the largest lambda, by cuts); bisection where there is none.
 */
#ifndef DELASSUS_LIMIT_H
#define DELASSUS_LIMIT_H

#include "delassus/solve.h"

#ifdef __cplusplus
extern "C" {
#endif

/* Settings: call dls_limit_settings_init, then change fields. The default stands last in each
 * comment. */
typedef struct dls_limit_settings {
  dls_limits limits; /* of each solve */
  size_t size;       /* set by init; settings without it are refused */
  double from, to;   /* finite; != from, may be -INFINITY or INFINITY; 0, INFINITY */
  double tol;        /* ends where |refused - carried| <= tol max(|carried|, |refused|); 1e-6 */
  int most;          /* solves, >= 2; 100 */
} dls_limit_settings;

/* Sets each field to its default. */
DLS_API void dls_limit_settings_init(dls_limit_settings *settings);

typedef struct dls_limit {
  double carried; /* an answer was certified here */
  double refused; /* a motion proves that there is none here; an infinite `to`, or `to` itself, if
                     nothing was found up to it */
  int proved;     /* 1: refused has a motion, or weights without K */
  double open;    /* the trial nearest to `carried` that was neither certified nor proved; NAN if
                     there is none */
  int solves;
  dls_uniqueness unique; /* of the answer at `carried` */
} dls_limit;

/* Finds the limit of the loads of a reduction.
 *
 *   f0, f1     n each; NULL for 0                                       force (impulse)
 *   g          d * nodes, as dls_reduction_load; NULL for 0             length (velocity)
 *   mu, mu1   candidates each; mu1 NULL for 0. mu + lambda mu1 >= 0 for all lambda that are tried;
 *              with mu1 a motion proves at its own lambda alone
 *   settings   NULL for the defaults
 *   r, x       m, n: the answer at `carried`; x NULL for none
 *   motion     n: the motion at `refused`, largest entry near 1; 0 without one; NULL for none
 *   limit      what was found
 *
 * DLS_OK: both sides meet to tol, or `to` is reached. DLS_MAX_ITERATIONS: `most` solves.
 * DLS_STALLED: trials next to `carried` were neither certified nor proved; both sides stand. Where
 * nothing is certified at `from`, the status of dls_reduction_solve there: then r, x are those of
 * that solve, carried = NAN, and refused = from if that is proved. The reduction keeps the load of
 * some trial. Allocates.
 *
 * Errors: DLS_E_ARGUMENT, DLS_E_NOT_FINITE, DLS_E_SETTINGS, DLS_E_MEMORY, and those of
 * dls_reduction_load and dls_reduction_solve. */
DLS_API DLS_MUST_USE dls_status dls_limit_load(dls_reduction *reduction, const double *f0,
                                               const double *f1, const double *g, const double *mu,
                                               const double *mu1,
                                               const dls_limit_settings *settings, double *r,
                                               double *x, double *motion, dls_limit *limit,
                                               dls_error *error);

#ifdef __cplusplus
}
#endif

#endif
