/*
 * delassus/nlgs.h: projected Gauss-Seidel on the reactions (nonlinear Gauss-Seidel), [Jean 1988]
 * 3.3. For each contact in turn, a sweep solves the d x d problem of that contact exactly, with all
 * others frozen. For d = 2 and 3, W symmetric or not.
 */
#ifndef DELASSUS_NLGS_H
#define DELASSUS_NLGS_H

#include "delassus/info.h"

#ifdef __cplusplus
extern "C" {
#endif

/* Acceleration of the sweeps, each being a fixed-point map r := g(r).
 *
 *   Aitken    starts a sweep from a combination of the last two, [Chabrand 1998] 4.2
 *   Anderson  the same with up to `window` differences
 *   momentum  extrapolates along the last step; for large W of many bodies. With W by blocks it
 *             also chooses at run time between extra sweeps where the residual is large and
 *             restarted momentum, by the cost of halving the residual */
typedef enum dls_acceleration {
  DLS_ACCELERATION_NONE = 0,
  DLS_ACCELERATION_AITKEN = 1,
  DLS_ACCELERATION_ANDERSON = 2,
  DLS_ACCELERATION_MOMENTUM = 3
} dls_acceleration;

/* Settings: call dls_nlgs_settings_init, then change fields. NULL settings are the defaults, which
 * stand last in each comment. */
typedef struct dls_nlgs_settings {
  dls_limits limits; /* max_iterations: sweeps; the method's own limit: 10000 */
  size_t size;       /* set by init; settings without it are refused */
  double relaxation; /* r_c += relaxation * (local solution - r_c), then projected; (0, 2); 1 */
  dls_acceleration acceleration; /* DLS_ACCELERATION_NONE */
  int window; /* Anderson: number of differences of sweeps to combine, 1 .. 100; 10 */
} dls_nlgs_settings;

/* Sets each field to its default. */
DLS_API void dls_nlgs_settings_init(dls_nlgs_settings *settings);

/* A workspace for problems of dimension d with at most nc candidates; reused over time steps. */
typedef struct dls_nlgs dls_nlgs;

/* Creates a workspace: *out, NULL on error. The settings are copied. Memory: O(m), m = d nc;
 * accelerated O(window m). DLS_E_ARGUMENT, DLS_E_SIZE, DLS_E_SETTINGS, DLS_E_MEMORY. */
DLS_API DLS_MUST_USE dls_status dls_nlgs_create(dls_nlgs **out, int d, int nc,
                                                const dls_nlgs_settings *settings,
                                                dls_error *error);

/* Solves a problem. Allocates nothing. r (m): in, the start if warm_start (projected on the cone
 * unless it is a solution), else ignored; out, the reactions; if the status is > 0, those with the
 * smallest residual found. u (m) or NULL: W r + q. info or NULL. r, u must not overlap each other
 * or the problem. DLS_OK, DLS_MAX_ITERATIONS, DLS_CANCELLED, DLS_STALLED (a sweep changes nothing),
 * an error of dls_contact_check, or DLS_E_SIZE for another d or more candidates than in create. */
DLS_API DLS_MUST_USE dls_status dls_nlgs_solve(dls_nlgs *workspace, const dls_contact *problem,
                                               double *r, double *u, dls_info *info,
                                               dls_error *error);

/* Frees the object; NULL is fine. */
DLS_API void dls_nlgs_destroy(dls_nlgs *workspace);

#ifdef __cplusplus
}
#endif

#endif
