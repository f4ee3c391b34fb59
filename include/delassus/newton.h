/*
 * delassus/newton.h: nonsmooth Newton on the friction law (Alart and Curnier 1991), after some
 * sweeps of Gauss-Seidel. For d = 2 and 3, W symmetric or not, of full rank or not. A handful of
 * steps where Gauss-Seidel needs hundreds of sweeps; each one is an LU of the unknowns that the
 * states of the candidates leave: none for a free one, d for one that sticks, d - 1 for one that
 * slips.
 *
 * Dense LU for a dense W, for a W by blocks with a quarter of all blocks or more, and up to 250
 * such unknowns; else sparse LU by MUMPS, into which one thread at a time is let. A library built
 * without MUMPS factorises dense there, too.
 */
#ifndef DELASSUS_NEWTON_H
#define DELASSUS_NEWTON_H

#include "delassus/info.h"

#ifdef __cplusplus
extern "C" {
#endif

/* Fill by dls_newton_settings_init, then change what you like; NULL means the defaults. */
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

/* *out = new workspace, NULL on error; the settings are copied. Memory, with m = d nc: O(m) and,
 * for the matrix, m^2 doubles; or O(blocks + m) where it is sparse: 0 < blocks < nc^2 / 4, m > 250,
 * and MUMPS is there. DLS_E_ARGUMENT, DLS_E_SIZE, DLS_E_SETTINGS, DLS_E_MEMORY. */
DLS_API DLS_MUST_USE dls_status dls_newton_create(dls_newton **out, int d, int nc,
                                                  const dls_newton_settings *settings,
                                                  dls_error *error);

/* Solves. r (m): in, the start if warm_start, else ignored; out, the reactions with the smallest
 * residual met, the start included: never worse than it. u (m) or NULL: W r + q. info or NULL. r, u
 * must not overlap each other or the problem.
 *
 * Allocates nothing for a W of the storage that `blocks` announced to create, MUMPS apart, which
 * allocates in every factorisation; for another W, or more blocks, it makes room once and keeps it.
 *
 * DLS_OK; DLS_MAX_ITERATIONS; DLS_STALLED: 12 steps that did not halve the residual;
 * DLS_CANCELLED; DLS_E_MEMORY, an error of dls_contact_check, or DLS_E_SIZE for another d or more
 * candidates than in create. */
DLS_API DLS_MUST_USE dls_status dls_newton_solve(dls_newton *workspace, const dls_contact *problem,
                                                 double *r, double *u, dls_info *info,
                                                 dls_error *error);

/* NULL is fine. */
DLS_API void dls_newton_destroy(dls_newton *workspace);

#ifdef __cplusplus
}
#endif

#endif
