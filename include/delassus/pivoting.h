/*
 * delassus/pivoting.h: two relatives of Lemke's method for LCP(M, q) of delassus/lcp.h.
 *
 *   dls_principal_solve  block principal pivoting, for P-matrices (every principal minor > 0): one
 *                        factorisation per guess of the active set instead of one pivot per
 *                        unknown; sparse factors for a sparse M, with a smoothing path as safeguard
 *   dls_lcp_enumerate    all solutions of a small LCP, n <= 20, whatever M
 */
#ifndef DELASSUS_PIVOTING_H
#define DELASSUS_PIVOTING_H

#include "delassus/lcp.h"

#ifdef __cplusplus
extern "C" {
#endif

/* ---- block principal pivoting ---------------------------------------------------------------- */

/* Fill by dls_principal_settings_init, then change fields; NULL settings mean the defaults. */
typedef struct dls_principal_settings {
  dls_limits limits; /* max_iterations: exchanges and steps of the path; the method's own limit:
                        10 n + 1000. warm_start: from the support { i : z_i > 0 } of z. blocks:
                        storage of M for which create allocates: 0: dense; > 0: Ms of up to so many
                        entries (1 for none); 0 */
  size_t size;       /* set by init; settings without it are refused */
  int block_steps;   /* exchanges of all infeasible unknowns at once that may pass without a new
                         least number of them; then one at a time, least index first (Murty), until
                         that number falls; of Ms the smoothing path in their place. >= 0; 0: always
                        one at a time; 10 */
} dls_principal_settings;

/* Sets each field to its default. */
DLS_API void dls_principal_settings_init(dls_principal_settings *settings);

typedef struct dls_principal_info {
  dls_status status;
  int iterations;                  /* exchanges */
  int single_exchanges;            /* those of them made one unknown at a time */
  int factorizations;              /* of principal submatrices, Cholesky or LU, and of path_steps */
  int path_steps;                  /* Ms: steps of the smoothing path, each with a factorisation */
  dls_lcp_certificate certificate; /* of the z that is returned */
} dls_principal_info;

typedef struct dls_principal dls_principal; /* workspace for n <= the n of create */

/* Creates a workspace: *out, NULL on error; n^2 + O(n) doubles, or O(n + limits.blocks) for Ms. The
 * settings are copied. DLS_E_ARGUMENT, DLS_E_SIZE, DLS_E_SETTINGS, DLS_E_MEMORY. */
DLS_API DLS_MUST_USE dls_status dls_principal_create(dls_principal **out, int n,
                                                     const dls_principal_settings *settings,
                                                     dls_error *error);

/* Solves the LCP. z (n): in, the start if warm_start, else ignored; out, the solution, z >= 0.
 * y (n, or NULL) := M z + q. info or NULL. z and y must not overlap each other or the problem.
 * Allocates nothing for M; for Ms the factors.
 *
 *   DLS_OK              certified; the only solution if M is a P-matrix
 *   DLS_MAX_ITERATIONS, DLS_CANCELLED
 *                       z is the basis of least residual found, its negative parts set to 0
 *   DLS_STALLED         a principal submatrix is singular to working precision (condition number
 *                       above 1 / (n eps) when equilibrated), so that M is no P-matrix, or nearly
 *                       none; or the last basis is feasible and the certificate does not hold; z as
 *                       above
 *
 * or an error of dls_lcp_check; DLS_E_SIZE for an M or Ms that limits.blocks did not announce;
 * DLS_E_MEMORY, and in a build without MUMPS DLS_E_UNSUPPORTED for a basis of more than 8000
 * unknowns (Ms). For a P-matrix the method ends; for others it may cycle, up to max_iterations.
 * Singular M (a structure on more supports than it needs): use Lemke.
 *
 * Of Ms it ends, in exact arithmetic, for every P-matrix, at a basis, so that z has the rounding
 * level as residual. P-matrices are for example
 *
 *   symmetric positive definite ones, also with a skew part
 *   M-matrices (obstacle problems, optimal stopping)
 *   strictly diagonally dominant ones with M_ii > 0
 *
 * Of a positive semidefinite M + M^T (a quadratic program with its multipliers) it usually ends,
 * where some z > 0 has M z + q > 0: at a basis, or on the path once tol is met. For others it may
 * stop with DLS_STALLED. No status of it proves that there is no solution. */
DLS_API DLS_MUST_USE dls_status dls_principal_solve(dls_principal *workspace, const dls_lcp *lcp,
                                                    double *z, double *y, dls_principal_info *info,
                                                    dls_error *error);

/* Frees the object; NULL is fine. */
DLS_API void dls_principal_destroy(dls_principal *workspace);

/* ---- all solutions --------------------------------------------------------------------------- */

enum { DLS_ENUMERATE_MAX = 20 };

typedef struct dls_enumeration {
  int solutions;      /* points in the list */
  int singular_bases; /* complementary bases whose matrix is singular to working precision */
  int continua;       /* those of them that hold more than one solution */
  char undetermined[DLS_ENUMERATE_MAX]; /* [i] = 1: z_i takes several values in one continuum */
} dls_enumeration;

/* Finds all solutions of LCP(M, q), n <= 20: for each of the 2^n sets A, the solutions with y_A = 0
 * and z_i = 0 outside of A form a polyhedron; where M_AA is regular it is one point or empty.
 *
 *   z (n x capacity, column-major): the solutions, each with a certificate <= max(tol, 4 floor).
 *   Two that differ by less than 1e-8 of the largest entry, all being scaled as the equilibrated
 *   columns of M, are listed once.
 *
 *   continua = 0: the list is the whole solution set; solutions = 0 means that there is none.
 *   continua > 0: all solutions that are isolated are in the list, and at least one vertex of each
 *   continuum; `undetermined` marks the unknowns that are not fixed, for example hyperstatic
 *   reactions.
 *
 * M_AA counts as singular if it is within 1e-12 of a singular matrix, and 1e-10 counts as 0 in the
 * polyhedra of singular ones (all after equilibration). Use exact arithmetic for borderline cases.
 *
 * tol >= 0, capacity >= 1. DLS_OK; DLS_MAX_ITERATIONS when the list is full, DLS_STALLED if
 * rounding keeps the simplex method from ending: z and *found hold the solutions found so far.
 * DLS_E_ARGUMENT, DLS_E_SIZE for n > 20, or an error of dls_lcp_check. Allocates nothing. 2^n
 * eliminations: 6 ms for n = 12, 4 s for n = 20, three times that where many of the bases are
 * singular. */
DLS_API DLS_MUST_USE dls_status dls_lcp_enumerate(const dls_lcp *lcp, double tol, int capacity,
                                                  double *z, dls_enumeration *found,
                                                  dls_error *error);

#ifdef __cplusplus
}
#endif

#endif
