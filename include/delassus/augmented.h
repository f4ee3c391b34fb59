/*
 * delassus/augmented.h: the augmented Lagrangian, [Chabrand 1998] 4.1, on the reactions; with one
 * augmentation and a large penalty, the penalty method. For d = 2 and 3, W symmetric or not,
 * singular or not.
 *
 * An augmentation replaces each contact by springs of stiffness eps_c,
 *
 *   r_n = < lambda_n - eps_c u_n >,   r_t = lambda_t - eps_c u_t put on the disc |r_t| <= mu r_n,
 *
 * solves u = W r + q with that r, and takes r as the next lambda. The error of the springs vanishes
 * with the augmentations, for each eps_c; a large eps_c makes it vanish faster, but each problem is
 * harder to solve. This is the proximal point method.
 */
#ifndef DELASSUS_AUGMENTED_H
#define DELASSUS_AUGMENTED_H

#include "delassus/info.h"

#ifdef __cplusplus
extern "C" {
#endif

/* Settings: call dls_augmented_settings_init, then change fields. NULL settings are the defaults,
 * which stand last in each comment. */
typedef struct dls_augmented_settings {
  dls_limits limits;     /* max_iterations: augmentations; the method's own limit: 400.
                        warm_start: lambda = r as passed in */
  size_t size;           /* set by init; settings without it are refused */
  double factor;         /* eps_c = factor / w_c, w_c as in the certificate; > 0; 100 */
  const double *penalty; /* eps_c > 0 (nc of create), force / length, in place of that; copied by
                            create; NULL for none */
  /* 1: all eps_c grow after an augmentation that was solved (by 5 before the first failure, then by
   * 1.25), and halve after one that was not; 0: they stay, and a failure ends the solve; 1 */
  int adaptive;
} dls_augmented_settings;

/* Sets each field to its default. */
DLS_API void dls_augmented_settings_init(dls_augmented_settings *settings);

/* A workspace for problems of dimension d with at most nc candidates; reused over time steps. */
typedef struct dls_augmented dls_augmented;

/* Creates a workspace: *out, NULL on error. The settings are copied. Memory: O(d nc), and that of
 * dls_newton_create (newton.h). DLS_E_ARGUMENT, DLS_E_SIZE, DLS_E_SETTINGS, DLS_E_MEMORY;
 * DLS_E_NOT_FINITE for a penalty that is not finite. */
DLS_API DLS_MUST_USE dls_status dls_augmented_create(dls_augmented **out, int d, int nc,
                                                     const dls_augmented_settings *settings,
                                                     dls_error *error);

/* Solves a problem. Allocates as much as dls_newton_solve. r (m): in, the first lambda if
 * warm_start, else ignored; out, the reactions; if the status is > 0, those with the smallest
 * residual found. u (m) or NULL: W r + q. info or NULL. r, u must not overlap each other or the
 * problem.
 *
 * DLS_OK: the certificate holds. DLS_MAX_ITERATIONS: after the last augmentation allowed it does
 * not; with max_iterations = 1 its residual is the error of the penalty method. DLS_STALLED: an
 * augmentation could not be solved, and no smaller penalty is left to try; the residual no longer
 * falls; or the reactions run away (below). DLS_CANCELLED. An error of dls_contact_check;
 * DLS_E_SIZE for another d or more candidates than in create; DLS_E_MEMORY. */
DLS_API DLS_MUST_USE dls_status dls_augmented_solve(dls_augmented *workspace,
                                                    const dls_contact *problem, double *r,
                                                    double *u, dls_info *info, dls_error *error);

/* Frees the object; NULL is fine. */
DLS_API void dls_augmented_destroy(dls_augmented *workspace);

#ifdef __cplusplus
}
#endif

#endif
