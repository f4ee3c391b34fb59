/*
 * delassus/nlgs.h: projected Gauss-Seidel on the reactions (nonlinear Gauss-Seidel), [Jean 1988]
 * 3.3. Each candidate in turn gets the exact solution of its own d x d problem with all others
 * frozen. For d = 2 and 3, W symmetric or not.
 */
#ifndef DELASSUS_NLGS_H
#define DELASSUS_NLGS_H

#include "delassus/info.h"

#ifdef __cplusplus
extern "C" {
#endif

/* The sweep as a fixed-point map r := g(r), and the next sweep started from a combination of the
 * last ones (linear/anderson.c). Aitken: of the last two, [Chabrand 1998] 4.2; Anderson: of more.
 * Momentum (vi/momentum.c): further along the last step, and, W by blocks, sweeps of their own
 * where the residual is, or momentum begun anew now and then, whichever is quicker (vi/turns.c);
 * for large W of many bodies. */
typedef enum dls_acceleration {
  DLS_ACCELERATION_NONE = 0,
  DLS_ACCELERATION_AITKEN = 1,
  DLS_ACCELERATION_ANDERSON = 2,
  DLS_ACCELERATION_MOMENTUM = 3
} dls_acceleration;

/* Fill by dls_nlgs_settings_init, then change what you like; NULL means the defaults. */
typedef struct dls_nlgs_settings {
  dls_limits limits; /* max_iterations: sweeps; the method's own limit: 10000 */
  size_t size;       /* set by init; settings without it are refused */
  double relaxation; /* r_c += relaxation * (local solution - r_c), then projected; (0, 2); 1 */
  dls_acceleration acceleration; /* DLS_ACCELERATION_NONE */
  int window; /* Anderson: how many differences of sweeps are combined, 1 .. 100; 10 */
} dls_nlgs_settings;

/* Sets each field to its default. */
DLS_API void dls_nlgs_settings_init(dls_nlgs_settings *settings);

/* A workspace for problems of dimension d with at most nc candidates; reused over time steps. */
typedef struct dls_nlgs dls_nlgs;

/* *out = new workspace, NULL on error; the settings are copied. Memory: O(m), m = d nc; accelerated
 * O(window m). DLS_E_ARGUMENT, DLS_E_SIZE, DLS_E_SETTINGS, DLS_E_MEMORY. */
DLS_API DLS_MUST_USE dls_status dls_nlgs_create(dls_nlgs **out, int d, int nc,
                                                const dls_nlgs_settings *settings,
                                                dls_error *error);

/* Solves; allocates nothing. r (m): in, the start if warm_start (put on the cone first unless it is
 * a solution), else ignored; out, the reactions: where the status is > 0, those with the smallest
 * residual met. u (m) or NULL: W r + q. info or NULL. r, u must not overlap each other or the
 * problem. DLS_OK, DLS_MAX_ITERATIONS, DLS_CANCELLED, DLS_STALLED (a sweep changes nothing), an
 * error of dls_contact_check, or DLS_E_SIZE for another d or more candidates than in create. */
DLS_API DLS_MUST_USE dls_status dls_nlgs_solve(dls_nlgs *workspace, const dls_contact *problem,
                                               double *r, double *u, dls_info *info,
                                               dls_error *error);

/* NULL is fine. */
DLS_API void dls_nlgs_destroy(dls_nlgs *workspace);

/* Which of the solutions of a local problem dls_nlgs_local returned. */
typedef enum dls_local_state {
  DLS_LOCAL_NONE = -1, /* the local problem has no solution; r is the least bad candidate */
  DLS_LOCAL_FREE = 0,
  DLS_LOCAL_SLIP = 1,
  DLS_LOCAL_STICK = 2
} dls_local_state;

/* The exact solution of one candidate alone: r with u = W r + q, d = 1, 2 or 3; W is d x d with
 * leading dimension d. Where several solutions exist, the first of free, stick, slip is taken;
 * *count, if not NULL, receives how many there are (0 for none; of a continuum, its ends). In 3D
 * with W_nn <= 0 nothing but free is looked for, and of several slips without stick it is not said
 * which is taken, but always the same. r is finite whatever W and q are. */
DLS_API dls_local_state dls_nlgs_local(int d, const double *W, const double *q, double mu,
                                       double *r, int *count);

#ifdef __cplusplus
}
#endif

#endif
