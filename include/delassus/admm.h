/*
 * delassus/admm.h: the alternating direction method of multipliers (ADMM), that is, the splitting
 * of Douglas and Rachford, with the exact resolvent of the friction law. For d = 2 and 3, W
 * symmetric or not, of full rank or not.
 *
 *   z = v projected by the law:   z_n = max(v_n, 0), z_t = v_t on the disc of radius mu z_n
 *   x from u = W r + q:           (W + rho D) x = rho D (2 z - v) - q
 *   v := v + 1.6 (x - z), accelerated (Anderson)
 *
 * D = diag(w_c), the weights of the certificate. One factorisation of W + rho D serves many
 * iterations. An iteration costs about as much as a sweep of Gauss-Seidel, but couples all
 * contacts. Use it for an ill-conditioned W and for small tolerances.
 *
 * Dense Cholesky (LU if W is not symmetric to the last bit) for a dense W, and for W by blocks up
 * to 250 unknowns; beyond that sparse LU by MUMPS, which one thread at a time may
 * use. A library without MUMPS then returns DLS_E_UNSUPPORTED.
 */
#ifndef DELASSUS_ADMM_H
#define DELASSUS_ADMM_H

#include "delassus/info.h"

#ifdef __cplusplus
extern "C" {
#endif

/* Settings: call dls_admm_settings_init, then change fields. NULL settings are the defaults, which
 * stand last in each comment. */
typedef struct dls_admm_settings {
  dls_limits limits; /* max_iterations: iterations; the method's own limit: 5000 */
  size_t size;       /* set by init; settings without it are refused */
  double rho;        /* first value; later ones adapt, 1e-8 .. 100; > 0, finite; no unit; 1 */
} dls_admm_settings;

/* Sets each field to its default. */
DLS_API void dls_admm_settings_init(dls_admm_settings *settings);

/* A workspace for problems of dimension d with at most nc candidates; reused over time steps. */
typedef struct dls_admm dls_admm;

/* Creates a workspace: *out, NULL on error. The settings are copied. Memory, with m = d nc: O(m)
 * and, for the matrix, m^2 doubles where blocks = 0 or m <= 250, else O(blocks + m).
 * DLS_E_ARGUMENT, DLS_E_SIZE, DLS_E_SETTINGS, DLS_E_MEMORY. */
DLS_API DLS_MUST_USE dls_status dls_admm_create(dls_admm **out, int d, int nc,
                                                const dls_admm_settings *settings,
                                                dls_error *error);

/* Solves a problem. r (m): in, the start if warm_start, else ignored; out, the reactions with the
 * smallest residual found, the start included. They lie outside the friction cone by no more than
 * the residual. u (m) or NULL: W r + q. info or NULL; info->factorisations counts. r, u must not
 * overlap each other or the problem.
 *
 * Allocates nothing for a W as announced to create; MUMPS allocates in each factorisation. For the
 * other storage, or more blocks, it allocates once and keeps the memory.
 *
 * DLS_OK; DLS_MAX_ITERATIONS; DLS_STALLED: an iteration changes nothing, overflows, or W + rho D is
 * singular for every rho tried; DLS_CANCELLED; DLS_E_MEMORY, DLS_E_UNSUPPORTED, an error of
 * dls_contact_check, or DLS_E_SIZE for another d or more candidates than in create. */
DLS_API DLS_MUST_USE dls_status dls_admm_solve(dls_admm *workspace, const dls_contact *problem,
                                               double *r, double *u, dls_info *info,
                                               dls_error *error);

/* Frees the object; NULL is fine. */
DLS_API void dls_admm_destroy(dls_admm *workspace);

#ifdef __cplusplus
}
#endif

#endif
