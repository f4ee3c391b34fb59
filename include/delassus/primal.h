/*
 * delassus/primal.h: projected Gauss-Seidel on the displacements, [Chabrand 1998] 4.2, (37)-(38).
 * Contact and friction directly on K, without condensation, d = 2:
 *
 *   K x = f + H r,   u = H^T x + g,   the laws of contact.h between u and r at each contact node
 *
 * The method is a fixed point on the sliding thresholds b_c = mu_c r_n. For fixed b the problem is
 * Tresca's, the minimum of a convex function under u_n >= 0, which a sweep lowers by relaxing one
 * unknown (contact node) after the other. It factorises nothing: the memory is K and some vectors.
 * The number of sweeps grows as the mesh is refined. Use it as a slow reference.
 */
#ifndef DELASSUS_PRIMAL_H
#define DELASSUS_PRIMAL_H

#include "delassus/info.h"
#include "delassus/model.h"

#ifdef __cplusplus
extern "C" {
#endif

/* Settings: call dls_primal_settings_init, then change fields. NULL settings are the defaults,
 * which stand last in each comment. */
typedef struct dls_primal_settings {
  dls_limits limits; /* tol: on both parts of the certificate. max_iterations: sweeps; the
                        method's own limit: 100000. warm_start: from x as passed in */
  size_t size;       /* set by init; settings without it are refused */
  double relaxation; /* of the unknowns that carry no contact; (0, 2); 1 */
  int aitken;        /* 1: Aitken acceleration of the sweeps; 0: none; 1 */
} dls_primal_settings;

/* Sets each field to its default. */
DLS_API void dls_primal_settings_init(dls_primal_settings *settings);

/* The certificate, in two parts; both without unit. r is what the contact nodes take out of
 * K x = f + H r, so that their own equilibrium is exact, and u = H^T x + g; K' and f' are K and f
 * with the unknowns of each contact node turned into its local frame.
 *
 *   equilibrium = |K' x' - f' - r| / (|f'| + |r|),    |v|^2 = sum of v_i^2 / K'_ii
 *   laws        = the certificate of contact.h for the problem of each node with all other nodes
 *                 frozen: W_cc = K'_cc^-1 (2 x 2), no coupling, q_c = u_c - W_cc r_c
 *
 * with the weights w_n, w_t of the diagonal of K'_cc^-1. A reaction that is no more than the
 * rounding of K' x' - f' counts as 0. The floors are what the arithmetic can attain: eps times the
 * same measures of |f'| + |K'| (|x'| + |g|) (a sum of magnitudes).
 * DLS_OK: equilibrium <= max(tol, 4 equilibrium_floor), and likewise both parts of the laws.
 *
 * The condensed problem, W = H^T K^-1 H, may have a larger residual: its u differs from this one by
 * H^T K^-1 times the forces out of balance, which the conditioning of K may magnify. The block of
 * [Jean 1988] Fig. 3 stopped at 1e-10 has 1.4e-10 of positions and 2.1e-9 of forces by
 * dls_contact_certify. */
typedef struct dls_primal_info {
  dls_status status; /* as returned */
  int iterations;    /* sweeps */
  int thresholds;    /* steps of the fixed point: times that b was changed */
  double equilibrium, equilibrium_floor;
  dls_certificate laws;
} dls_primal_info;

/* K and H prepared, and room for solving; reused over load steps. */
typedef struct dls_primal dls_primal;

/* *out = new workspace, NULL on error. The model is read here, not kept; the settings are copied.
 * Memory: O(n + entries of K); nothing is allocated later.
 *
 * K: DLS_STIFFNESS_DENSE or DLS_STIFFNESS_SPARSE with DLS_CHOLESKY: symmetric positive definite,
 * its lower triangle is read. H: columns c of H_N and H_T together have entries in exactly two
 * rows, unknowns of contact node c and of no other node, where they form a regular 2 x 2 block: n
 * and t of the node, in any directions. All else is DLS_E_UNSUPPORTED, naming "d", "operator_kind",
 * "factorization", "P", or "HN", "HT" and the column. DLS_E_NOT_POSITIVE_DEFINITE names K or Ks,
 * the unknown (index) whose pivot, alone or within its contact node, is not positive, and the
 * pivot. DLS_E_NOT_FINITE: entries that add up to Inf. DLS_E_ARGUMENT, DLS_E_SETTINGS,
 * DLS_E_MEMORY, and the errors of dls_model_check. */
DLS_API DLS_MUST_USE dls_status dls_primal_create(dls_primal **out, const dls_model *model,
                                                  const dls_primal_settings *settings,
                                                  dls_error *error);

/* Solves a problem. Allocates nothing.
 *
 *   f     loads, n, or NULL for 0                                            force
 *   g     initial gaps, 2 per contact node (n, t), or NULL for 0             length
 *   mu    friction coefficients >= 0, one per contact node
 *   x     n: in, the start if warm_start, else ignored; out, displacements   length
 *   r     reactions, 2 per contact node                                      force
 *   u     relative positions H^T x + g, 2 per contact node, or NULL          length
 *   info  or NULL
 *
 * Arrays must not overlap. If the status is > 0, the outputs belong to the x with the smallest
 * certificate found. DLS_OK; DLS_MAX_ITERATIONS; DLS_CANCELLED; DLS_STALLED: a sweep changes
 * nothing, or the numbers overflow; DLS_E_NOT_POSITIVE_DEFINITE: a step d with d^T K d < 0, naming
 * "K" (value: d^T K d / d^T diag(K) d); DLS_E_ARGUMENT, DLS_E_NOT_FINITE. */
DLS_API DLS_MUST_USE dls_status dls_primal_solve(dls_primal *workspace, const double *f,
                                                 const double *g, const double *mu, double *x,
                                                 double *r, double *u, dls_primal_info *info,
                                                 dls_error *error);

/* Frees the object; NULL is fine. */
DLS_API void dls_primal_destroy(dls_primal *workspace);

#ifdef __cplusplus
}
#endif

#endif
