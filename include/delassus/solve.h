/*
 * delassus/solve.h: the front door: one call for any method.
 */
#ifndef DELASSUS_SOLVE_H
#define DELASSUS_SOLVE_H

#include "delassus/nlgs.h"

#ifdef __cplusplus
extern "C" {
#endif

typedef struct dls_solver_settings {
  dls_limits
      limits;  /* max_iterations: sweeps, pivots of each LCP and rounds of its crash start, steps,
                        augmentations; auto: of all stages together. dls_solve sets blocks itself */
  size_t size; /* set by init; settings without it are refused */
  dls_method method; /* DLS_AUTO */
  int facets;        /* Lemke, d = 3: of the friction cone, even, 4 to DLS_FACETS_MAX; 0: 8; 0 */
  dls_acceleration acceleration; /* nlgs; DLS_ACCELERATION_NONE */
  int positive_definite; /* 1: W is known to be symmetric positive definite: newton, alone and in
                            auto, leaves its regularisation out; 0 */
} dls_solver_settings;

DLS_API void dls_solver_settings_init(dls_solver_settings *settings);

/* "auto", "nlgs", "lemke", "newton", "admm", "augmented-lagrangian", "penalty"; NULL for a number
 * that is no method. dls_method_find returns 0 for no method. */
DLS_API const char *dls_method_name(dls_method method);
DLS_API int dls_method_find(const char *name, dls_method *method);

/* "none", "aitken", "anderson"; 0 for another name. */
DLS_API int dls_acceleration_find(const char *name, dls_acceleration *acceleration);

/* Workspace for problems of dimension d with at most nc candidates, reused over time steps. */
typedef struct dls_solver dls_solver;

/* Up to how many candidates auto has Lemke's method in its workspace. */
enum { DLS_AUTO_LEMKE_2D = 150, DLS_AUTO_LEMKE_3D = 60 };

/* *out = new workspace, NULL on error; the settings are copied. DLS_E_ARGUMENT, DLS_E_SIZE,
 * DLS_E_SETTINGS, DLS_E_MEMORY.
 *
 * Auto takes accelerated sweeps of Gauss-Seidel and Newton's method in turn, as their progress and
 * cost tell; between them ADMM, from 150 rows on, for a dense W and for stacks at rest (W by blocks, -q
 * nearly in the friction cones); then the augmented Lagrangian, then Lemke's method (src/auto.c). Each
 * but ADMM for a stack starts from the best r so far, which is what is returned. info.stage has what was
 * done. It holds the workspaces of dls_nlgs_create with Anderson acceleration, dls_newton_create without
 * sweeps, dls_admm_create (m >= 150) and dls_augmented_create, the last three with room for one matrix
 * between them; Lemke's as follows (within the limits above); besides 2 m doubles, m = d nc, 2 nc ints,
 * nc bytes, and up to 2 kB. For W dense, Lemke's apart, that is
 *
 *   m >= 150   m^2 + 103 m + 47 nc doubles (d = 3: 75 nc)
 *   else       m^2 +  71 m + 45 nc doubles (d = 3: 73 nc)
 *
 * nc bytes, and up to 12 kB.
 *
 * Lemke solves, for d = 2, the LCP of dls_contact_to_lcp and, where that ends in a ray, the one of
 * dls_contact_to_facets_lcp; for d = 3 the latter with the facets of the settings. Where the
 * certificate does not hold yet, Newton's method takes the answer to the round cone (newton.h).
 * It holds the LCP and its table, about 2 n^2 doubles: n = (facets + 2) nc for d = 3; n = 4 nc for
 * d = 2 up to 4 nc = 4000, beyond that n = 3 nc, and a ray ends it.
 *
 * The augmented Lagrangian and the penalty method take the defaults of augmented.h. The penalty
 * method is one augmentation with eps_c = 1e6 / w_c from lambda = 0, warm_start or not. Its r has an
 * error of about 1e-6: DLS_OK if the certificate holds all the same, as a rule DLS_MAX_ITERATIONS;
 * DLS_STALLED if the regularised problem could not be solved. */
DLS_API DLS_MUST_USE dls_status dls_solver_create(dls_solver **out, int d, int nc,
                                                  const dls_solver_settings *settings,
                                                  dls_error *error);

/* r (m): in, the start if warm_start; out, the reactions. u (m) or NULL: W r + q. info or NULL.
 * Allocates nothing for a W of the storage that `blocks` announced, MUMPS apart (newton.h).
 *
 * Statuses of the methods. Of Lemke with d = 3, DLS_RAY and never DLS_NO_SOLUTION: what is proved of
 * the faceted cone does not bind the round one. DLS_NO_SOLUTION_LIKELY: the augmented Lagrangian,
 * alone or in auto, saw the reactions run away; the direction follows. DLS_NO_SOLUTION of auto:
 * proved by Lemke's method, d = 2. DLS_STALLED of auto: all its methods failed. Auto, not warm, where every
 * q_n >= 0, or up to 20 candidates and the certificate of r = 0 holds: r = 0 without a stage. Up to
 * 20 candidates of which one has q_n < 0, or those that have couple with none (W by blocks), it tries
 * one sweep without workspace, and dls_solve allocates nothing if that is it (src/alone.c). */
DLS_API DLS_MUST_USE dls_status dls_solver_solve(dls_solver *solver, const dls_contact *problem,
                                                 double *r, double *u, dls_info *info,
                                                 dls_error *error);

/* After DLS_NO_SOLUTION_LIKELY, the direction delta (m) of dls_augmented_direction(), augmented.h:
 * W delta is as good as 0 and q.delta < 0. A proof only where W delta = 0, W is symmetric,
 * delta_n >= 0 and delta_t = 0. Else NULL. Lives until the next solve or destroy. */
DLS_API const double *dls_solver_direction(const dls_solver *solver);

/* NULL is fine. */
DLS_API void dls_solver_destroy(dls_solver *solver);

/* create, solve and destroy in one call; settings NULL for the defaults. Auto allocates what its stages after the
 * first need when it comes to them. */
DLS_API DLS_MUST_USE dls_status dls_solve(const dls_contact *problem,
                                          const dls_solver_settings *settings, double *r, double *u,
                                          dls_info *info, dls_error *error);

#ifdef __cplusplus
}
#endif

#endif
