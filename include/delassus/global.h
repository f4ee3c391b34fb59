/*
 * delassus/global.h: the contact problem on K itself. W is never formed.
 *
 *   K x = f + H r,   u = H^T x + g,   the law of contact and friction between u and r
 *                                                            [Jean 1988] (3.3)1-3, (2.1)1, 4.2
 *
 * delassus/reduction.h says what x, f, K, H, g are; delassus/contact.h has the law. Use it for
 *
 *   - contact over whole surfaces, where W is large: cost and memory are those of two factors of K
 *   - bodies that contact alone holds: K may be singular, without springs and without modes
 *   - K nearly singular: soft supports
 *   - with all of these joints (model.h), redundant ones too
 *
 * The answer is the pair (x, r). Its certificate has three parts: positions, forces, and the
 * equilibrium of each connected body. Loads that balance in themselves are split off where they
 * would hide an error (docs/certificate.md); the certificate is then that of the split problem.
 */
#ifndef DELASSUS_GLOBAL_H
#define DELASSUS_GLOBAL_H

#include "delassus/info.h"
#include "delassus/model.h"

#ifdef __cplusplus
extern "C" {
#endif

typedef struct dls_global dls_global;

/* Copies the model, analyses K + H R H^T. *out = NULL on error. model: DLS_STIFFNESS_DENSE (its
 * zeros are left out) or DLS_STIFFNESS_SPARSE; K may be singular, symmetric or not, and with
 * DLS_CHOLESKY need not be definite. Contacts are the active candidates; where model.mu is 0
 * the tangents are left out. m = d * contacts.
 *
 * Memory: the factor of K + H R H^T, twice K, H, some vectors. DLS_E_UNSUPPORTED for a flexibility
 * or a host's solver, and for K unsymmetric or indefinite with more than 8000 unknowns in a build
 * without MUMPS; DLS_E_SIZE, DLS_E_MEMORY, the errors of dls_model_check. */
DLS_API DLS_MUST_USE dls_status dls_global_create(dls_global **out, const dls_model *model,
                                                  dls_error *error);

/* Takes R (m; force / length), which is read during the call only. Called before the first solve
 * and whenever R has changed, a few times in dls_global_solve. */
typedef dls_status (*dls_global_prepare_fn)(void *data, const double *R, dls_error *error);

/* Solves A x = b. b: n, force. x: n, in a guess, the x of the iteration before; out with
 * |b - A x| <= accuracy |b|: 1 % of the relative change in the iteration before, at least 1 % of
 * tol. */
typedef dls_status (*dls_global_solve_fn)(void *data, const double *b, double *x, double accuracy,
                                          dls_error *error);

/* A solver for A = K + H R H^T that the host brings: R diagonal and positive, of the contacts, so
 * that A is positive definite where K is semidefinite and no motion that K leaves free leaves every
 * contact where it is. Both functions are called by dls_global_solve alone, from its thread, never
 * two at a time. An error (< 0) that they return ends the solve as its status, a number > 0 as
 * DLS_CANCELLED; *error, not NULL, is theirs to fill or to leave.
 *
 * block and apply are optional. With them a solve begins with Newton steps, whose equations FGMRES
 * solves; prepare and solve are called where these fail. The R of block are d x d blocks, one for
 * each contact, in P = K + H R H^T: symmetric, positive semidefinite, 20 times the local stiffness
 * in directions that a contact holds. apply returns x = about P^-1 b by any preconditioner of P,
 * which may differ from call to call: one cycle of multigrid, a factor. x is 0 in; accuracy is 0.1
 * and may be ignored. Where a motion is free, P is singular: apply may return anything, or
 * DLS_E_SINGULAR, which ends the steps and not the solve. */
typedef struct dls_global_solver {
  void *data; /* the host's; the library passes it on and never frees it */
  dls_global_prepare_fn prepare;
  dls_global_solve_fn solve;
  dls_global_prepare_fn block; /* of Newton steps, as apply; both or none */
  dls_global_solve_fn apply;
} dls_global_solver;

/* Works as dls_global_create, with the host's solver in place of a factor: for models that are too
 * large for a factor. *solver is copied; its data must live until dls_global_destroy. The host
 * knows K and H (n x m: the active contacts, local order) and adds up A, or applies it. Proofs,
 * which factorise, are left out: it never returns DLS_NO_SOLUTION. Without block and apply there
 * are no Newton steps; with them a solve allocates up to 61 vectors of n + m for these. After
 * dls_global_update the host has the new values of K and H before the next solve. */
DLS_API DLS_MUST_USE dls_status dls_global_create_with(dls_global **out, const dls_model *model,
                                                       const dls_global_solver *solver,
                                                       dls_error *error);

/* Takes new values of K, H, P on the pattern of create and keeps the analysis. DLS_E_SIZE or
 * DLS_E_ARGUMENT for another size or pattern; after an error the object is as it was. */
DLS_API DLS_MUST_USE dls_status dls_global_update(dls_global *global, const dls_model *model,
                                                  dls_error *error);

/* Solves for new loads and gaps.
 *
 *   f       loads, n; NULL for 0                                        force (impulse)
 *   g       gaps, d * nodes, as dls_reduction_load; NULL for 0          length (velocity)
 *   mu      friction of the contacts; INFINITY: bonded; NULL: model.mu, or 0 without it
 *   limits  NULL for the defaults; max_iterations: of the splitting, 0: 5000; blocks and threads
 *           are not read. warm_start: starts from r and x as passed in; if
 *           x is 0, from the x that the states of r have
 *   r       reactions, m: in for a warm start, out                      force (impulse)
 *   x       unknowns, n: in for a warm start, out                       length (velocity)
 *   info    or NULL: iterations (of the splitting, and Newton steps with a host's apply),
 *           factorisations (calls of prepare and block), certificate of (x, r); method is DLS_ADMM
 *
 * Where the splitting and Newton's method find nothing, Newton steps from states that are drawn
 * follow, up to 500 contacts: large friction leaves few answers that no descent leads to. r, x must
 * not overlap each other or the rest. Allocates the matrix of a Newton step, and the vectors of an
 * augmented Lagrangian, while it is tried, and what MUMPS and the factors do.
 *
 * DLS_OK; DLS_TO_ROUNDING: solved as well as double precision holds (x, r), the floors say how
 * well; DLS_NO_SOLUTION: proved, dls_global_motion shows why; DLS_NOT_IN_EQUILIBRIUM: a body's
 * forces do not balance and no proof was found; DLS_STALLED, DLS_MAX_ITERATIONS, DLS_CANCELLED,
 * DLS_TIME_LIMIT: with the best pair met. DLS_E_ARGUMENT (mu > 0 where model.mu is 0, a negative
 * mu), DLS_E_NOT_FINITE, DLS_E_SETTINGS, DLS_E_MEMORY, DLS_E_SINGULAR, DLS_E_BUSY. */
DLS_API DLS_MUST_USE dls_status dls_global_solve(dls_global *global, const double *f,
                                                 const double *g, const double *mu,
                                                 const dls_limits *limits, double *r, double *x,
                                                 dls_info *info, dls_error *error);

/* Cost of a problem on K, A = K + H R H^T. Where K is unsymmetric, by the pattern of A + A^T. */
typedef struct dls_global_info {
  double flops;        /* of one factorisation of A, from the analysis */
  double factor_bytes; /* of the factor of A */
  double step_bytes;   /* an iteration reads and writes: the factor twice, vectors */
  double bytes;        /* in use during a solve that allocates nothing of its own */
} dls_global_info;

/* Estimates the cost of dls_global_create and dls_global_solve from ordering and analysis, without
 * a factor. Arguments and errors of dls_global_create. If you will solve anyway, create and
 * dls_global_get_info return the same figures and keep the analysis. */
DLS_API DLS_MUST_USE dls_status dls_global_estimate(const dls_model *model, dls_global_info *info,
                                                    dls_error *error);

/* Returns the cost of an existing problem. O(1); for an unsymmetric K it runs the analysis.
 * DLS_E_BUSY, DLS_E_MEMORY; DLS_E_UNSUPPORTED with a solver of the host. */
DLS_API DLS_MUST_USE dls_status dls_global_get_info(dls_global *global, dls_global_info *info,
                                                    dls_error *error);

/* Returns the number of contacts; 0 for NULL. */
DLS_API int dls_global_contacts(const dls_global *global);

/* Returns the rigid motion b (n, largest entry near 1) that proves DLS_NO_SOLUTION after the last
 * solve, NULL after any other status. K b = 0 to the rounding of K, b^T f > 0, and (H^T b)_n >= mu
 * |(H^T b)_t| to rounding at each contact: b^T (f + H r) > 0 for each r that the law allows, so
 * that nothing balances f. *body (or NULL): the first unknown of the connected body that moves
 * most. A b of multipliers alone, *body = -1, shows joints that contradict each other. */
DLS_API const double *dls_global_motion(const dls_global *global, int *body);

/* Frees the object; NULL is fine. */
DLS_API void dls_global_destroy(dls_global *global);

#ifdef __cplusplus
}
#endif

#endif
