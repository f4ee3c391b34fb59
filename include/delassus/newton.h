/*
 * delassus/newton.h: nonsmooth Newton on the friction law (Alart and Curnier 1991), after some
 * sweeps of Gauss-Seidel. For d = 2 and 3, W symmetric or not, of full rank or not. It takes a few
 * steps where Gauss-Seidel takes hundreds of sweeps. Each step is an LU of the unknowns that the
 * states leave: none for a free contact, d for one that sticks, d - 1 for one that slips.
 *
 * Dense LU for a dense W, for a W by blocks with at least 25 % of all blocks, and up to 250 such
 * unknowns; else sparse LU by MUMPS, which one thread at a time may use. A library built
 * without MUMPS factorises dense there, too.
 */
#ifndef DELASSUS_NEWTON_H
#define DELASSUS_NEWTON_H

#include "delassus/info.h"

#ifdef __cplusplus
extern "C" {
#endif

/* Settings: call dls_newton_settings_init, then change fields. NULL settings are the defaults,
 * which stand last in each comment. */
typedef struct dls_newton_settings {
  dls_limits limits;     /* max_iterations: steps; the method's own limit: 30.
                        progress hears of sweeps ("nlgs") and of steps ("newton") */
  size_t size;           /* set by init; settings without it are refused */
  int sweeps;            /* of Gauss-Seidel before the first step, >= 0; 20 */
  int line_search;       /* 1: shorten steps, for starts without sweeps; 0: full steps; 0 */
  double regularization; /* eps: the matrix of a step is made of W + eps diag(w); [0, 1); 1e-6 */
} dls_newton_settings;

/* Sets each field to its default. */
DLS_API void dls_newton_settings_init(dls_newton_settings *settings);

/* A workspace for problems of dimension d with at most nc candidates; reused over time steps. */
typedef struct dls_newton dls_newton;

/* Creates a workspace: *out, NULL on error. The settings are copied. Memory, with m = d nc: O(m)
 * and, for the matrix, m^2 doubles; or O(blocks + m) where it is sparse: 0 < blocks < nc^2 / 4, m >
 * 250, and MUMPS is there. DLS_E_ARGUMENT, DLS_E_SIZE, DLS_E_SETTINGS, DLS_E_MEMORY. */
DLS_API DLS_MUST_USE dls_status dls_newton_create(dls_newton **out, int d, int nc,
                                                  const dls_newton_settings *settings,
                                                  dls_error *error);

/* Solves a problem. r (m): in, the start if warm_start, else ignored; out, the reactions with the
 * smallest residual found, the start included. u (m) or NULL: W r + q. info or NULL. r, u
 * must not overlap each other or the problem.
 *
 * Allocates nothing for a W of the storage that `blocks` announced to create; MUMPS allocates in
 * each factorisation. For another W, or more blocks, it allocates once and keeps the memory.
 *
 * DLS_OK; DLS_MAX_ITERATIONS; DLS_STALLED: 12 steps that did not halve the residual;
 * DLS_CANCELLED; DLS_E_MEMORY, an error of dls_contact_check, or DLS_E_SIZE for another d or more
 * candidates than in create. */
DLS_API DLS_MUST_USE dls_status dls_newton_solve(dls_newton *workspace, const dls_contact *problem,
                                                 double *r, double *u, dls_info *info,
                                                 dls_error *error);

/* Frees the object; NULL is fine. */
DLS_API void dls_newton_destroy(dls_newton *workspace);

#ifdef __cplusplus
}
#endif

#endif
