/*
 * delassus/solve.h: one function for all methods.
 */
#ifndef DELASSUS_SOLVE_H
#define DELASSUS_SOLVE_H

#include "delassus/nlgs.h"
#include "delassus/reduction.h"

#ifdef __cplusplus
extern "C" {
#endif

/* Settings: call dls_solver_settings_init, then change fields. NULL settings are the defaults,
 * which stand last in each comment. */
typedef struct dls_solver_settings {
  dls_limits limits; /* max_iterations of auto: for all its stages together */
  size_t size;       /* set by init; settings without it are refused */
  dls_method method; /* DLS_AUTO */
  int facets;        /* lemke, d = 3: of the friction cone, even, 4 to DLS_FACETS_MAX; 0: 8; 0 */
  dls_acceleration acceleration; /* nlgs; DLS_ACCELERATION_NONE */
  int positive_definite; /* 1: you know that W is symmetric positive definite; Newton's method then
                            does not regularise it; 0 */
  dls_forces forces;     /* DLS_FORCES_LEAST: replaces a solved r by the least reactions of the same
                        positions, if W is symmetric and mu finite. Takes the memory of newton and
                        some of its steps. info.forces reports whether r was replaced. auto then
                        does not extrapolate from earlier answers, and dls_solve_batch uses no
                        lanes. DLS_FORCES_ANY */
  /* Steps of auto; NULL: auto chooses them; NULL. dls_solver_create reads both.
   *
   * plan: the steps to run, for example "sweeps:30,newton,homotopy", up to DLS_STAGES_MAX. ":30"
   * ends a step after 30 iterations. Without it a step ends as in auto; the last one runs to its
   * own end. A plan works on the problem as given: auto makes no copy, leaves no contact out, does
   * not extrapolate from earlier answers and does not improve an answer whose info.error is large.
   * dls_reduction_solve does not continue on K.
   *
   * without: the steps to leave out, of auto's plans or of `plan`, for example "homotopy,scatter".
   *
   * Words: the names of dls_step, except interior-point and on-K. */
  const char *plan, *without;
} dls_solver_settings;

/* Sets each field to its default. */
DLS_API void dls_solver_settings_init(dls_solver_settings *settings);

/* Return the name of a method ("auto", "nlgs", ...) and one line on when to use it; NULL for a
 * number that is no method. Methods are numbered from 0 without gaps. */
DLS_API const char *dls_method_name(dls_method method);
DLS_API const char *dls_method_summary(dls_method method);

/* Finds the method of that name: sets *method and returns 1, or returns 0. */
DLS_API int dls_method_find(const char *name, dls_method *method);

/* Finds the acceleration "none", "aitken", "anderson" or "momentum": sets *acceleration and returns
 * 1, or returns 0. */
DLS_API int dls_acceleration_find(const char *name, dls_acceleration *acceleration);

/* Workspace for problems of dimension d with at most nc candidates, reused over time steps. */
typedef struct dls_solver dls_solver;

/* Creates a workspace: *out, NULL on error. The settings are copied. Memory, with m = d nc:
 *
 *   O(m)             nlgs; up to 300 rows m^2 doubles more, as for all methods but auto, for
 *                    info.error
 *   m^2 doubles      newton, admm, augmented-lagrangian, penalty, auto, if limits.blocks = 0
 *   O(blocks)        the same methods, if limits.blocks > 0 (W by blocks), and MUMPS's factors
 *   3 m^2 doubles    homotopy
 *   4 m^2 doubles    auto up to 300 rows
 *   2 n^2 doubles    lemke, and auto up to n = DLS_AUTO_LEMKE_ROWS: the LCP and its table.
 *                    n = 2 nc for d = 1; n = (facets + 2) nc for d = 3; d = 2: n = 4 nc up to
 *                    4 nc = 4000, beyond that n = 3 nc, and a ray ends it. For a dense W of more
 *                    than 300 rows auto allocates it in the solve that needs it, n <= 3000
 *
 * For W of bodies nlgs and, beyond 1000 contacts, auto work on the motions of the bodies. The first
 * solve that needs W by blocks forms it and keeps the memory.
 *
 * auto runs these stages. Each starts from the best r so far, which is returned; info.stage lists
 * them.
 *
 *   1  up to 20 contacts that W does not couple: one by one, in closed form
 *   2  accelerated sweeps and Newton's method in turn, by their progress and cost; ADMM in between.
 *      W by blocks: sweeps with momentum after them beyond 100 contacts, in their place beyond 1000
 *      and in turns of equal cost with the augmented Lagrangian; after 200 sweeps the convex
 *      problem.
 *      3D, dense W of up to 180 rows: the augmented Lagrangian after Newton's method
 *   3  up to 300 rows, on a renumbered and scaled copy, so that the order of the contacts does not
 *      matter: Lemke's method, homotopy, Newton's method from random starts, ADMM
 *   4  beyond 300 rows: Lemke's method while its table is small, augmented Lagrangian, ADMM
 *
 * If a dense W proves that at least 40 % of the contacts stay open, a cold solve works on a smaller
 * copy without them. With warm_start, auto extrapolates from its last two answers, and begins with
 * Newton's method on the factors of the last solve if that ended with it (dense W).
 *
 * lemke solves for d = 2 the LCP of dls_contact_to_lcp, and the one of dls_contact_to_facets_lcp if
 * that ends in a ray; for d = 3 the latter. If the certificate does not hold yet, Newton's method
 * continues on the round cone (newton.h).
 *
 * penalty is one augmentation of the augmented Lagrangian (augmented.h) with eps_c = 1e6 / w_c from
 * lambda = 0; it ignores warm_start. Its r has an error of about 1e-6. It returns DLS_OK if the
 * certificate holds, usually DLS_MAX_ITERATIONS, and DLS_STALLED if the regularised problem could
 * not be solved.
 *
 * DLS_E_ARGUMENT (of plan and without with the wrong word), DLS_E_SIZE, DLS_E_SETTINGS,
 * DLS_E_MEMORY. */
DLS_API DLS_MUST_USE dls_status dls_solver_create(dls_solver **out, int d, int nc,
                                                  const dls_solver_settings *settings,
                                                  dls_error *error);

/* Changes the limits of a solver from the next solve on: tol, max_iterations, warm_start, progress;
 * blocks stays that of create. DLS_E_ARGUMENT leaves the limits unchanged. */
DLS_API DLS_MUST_USE dls_status dls_solver_set_limits(dls_solver *solver, const dls_limits *limits,
                                                      dls_error *error);

/* Solves a problem.
 *
 *   r (m)   in: the start if warm_start; out: the reactions
 *   u (m)   or NULL: W r + q
 *   info    or NULL: auto then does not predict info.error, and does not improve an answer whose
 *           error is large
 *
 * r and u must not overlap each other or W, q, mu (DLS_E_ARGUMENT). Allocates nothing if W has the
 * storage that limits.blocks announced, apart from MUMPS (newton.h) and from the proof of r with
 * which auto ends when all else fails (dls_contact_prove).
 *
 *   DLS_NO_SOLUTION         lemke, auto: no solution exists, proved exactly for the numbers of W, q
 *                           and mu; dls_solver_farkas returns the proof
 *   DLS_NO_SOLUTION_LIKELY  auto: each solution would be too large to be certified. Or all methods
 *                           failed, from r = 0, and in more ways than one; W shows no reason for a
 *                           solution; and no states of the contacts have one (d = 2, up to 8
 *                           contacts), or r runs away along dls_solver_direction (d = 3, up to 2)
 *   DLS_RAY                 r runs away along dls_solver_direction. A solution may or may not
 *                           exist; if dls_solver_farkas is not NULL, none is near
 *   DLS_STALLED             auto: all methods failed */
DLS_API DLS_MUST_USE dls_status dls_solver_solve(dls_solver *solver, const dls_contact *problem,
                                                 double *r, double *u, dls_info *info,
                                                 dls_error *error);

/* Tells a solver which contacts of its next solve were there in its last one, where contacts
 * appear, vanish or change their numbers from step to step. That solve then starts from what the
 * last one left: set limits.warm_start, and pass r on to it.
 *
 *   nc        contacts of the next solve, 0 to those of create
 *   from (nc) for each contact its number in the last solve, each number at most once; -1: the
 *             contact is new
 *   r (d nc)  out: the reactions of the last solve under the new numbers, 0 for new contacts
 *
 * The frames (n, t, s) of contacts that stay should turn with the bodies, since r is carried over
 * in them. auto and nlgs keep the order in which a sweep visits the contacts, with a new contact
 * after the one before it in the numbering; auto also keeps the answers from which it extrapolates
 * and, for a dense W, Newton's factors if contacts stay in their order and only open ones come or
 * go. What the solver knows of costs stays, too. Sweeps with momentum over at least 500 contacts
 * that W does not couple densely leave out contacts without a reaction as long as they stay open.
 *
 * A solve of another number of contacts forgets the map; another call before that solve replaces
 * it. The last solve is the last one that returned no error; before the first solve all contacts
 * are new. Allocates nothing.
 *
 * DLS_E_SIZE (nc), DLS_E_ARGUMENT (from, with the index: out of range, or twice the same), with r
 * unchanged; DLS_E_BUSY. */
DLS_API DLS_MUST_USE dls_status dls_solver_map(dls_solver *solver, int nc, const int *from,
                                               double *r, dls_error *error);

/* Returns the direction (m) along which the reactions of the last solve grew without bound, or
 * NULL. It lives until the next solve or destroy.
 *
 *   DLS_NO_SOLUTION_LIKELY or DLS_STALLED of auto or the augmented Lagrangian: delta with W delta
 *   = 0 to rounding and q.delta < 0: it causes no displacement and gains work without bound. It
 *   proves that there is no solution only if W delta = 0, W is symmetric, delta_n >= 0 and
 *   delta_t = 0
 *   DLS_RAY of lemke: the reactions of the ray, dz of lcp.h */
DLS_API const double *dls_solver_direction(const dls_solver *solver);

/* Returns the proof after DLS_NO_SOLUTION: v (nc) with
 *
 *   v >= 0,   sum_c v_c q_cn < 0,   g_cn + mu_c |g_ct| <= 0,   g_c = sum_a v_a (row n of W_ac)
 *
 * exactly for the numbers of the problem, so that no r in the friction cones has u_n = (W r + q)_n
 * >= 0: 0 <= v.u_n = g.r + v.q_n < 0 otherwise. After DLS_RAY of lemke, and after DLS_STALLED or
 * DLS_NO_SOLUTION_LIKELY of auto, v satisfies this up to rounding, if such a v is known. That
 * proves nothing, but a solution would be too large to be certified. Else NULL. v lives until the
 * next solve or destroy. */
DLS_API const double *dls_solver_farkas(const dls_solver *solver);

/* Describes in words what a solve did, and returns the length of the whole text without its final
 * 0; 0 if info is NULL. For auto: the regime, and a line for each stage with its iterations,
 * residual, why it ended and, if measured, its CPU time. For another method one line.
 *   text, room: receives at most `room` bytes, the final 0 included; NULL and 0 for none */
DLS_API size_t dls_explain(const dls_info *info, char *text, size_t room);

/* Frees the workspace; NULL is fine. */
DLS_API void dls_solver_destroy(dls_solver *solver);

/* Creates a workspace, solves and destroys it; limits.blocks is set from the problem. auto
 * allocates the memory of each stage when it comes to it. Arguments, statuses and errors of
 * dls_solver_create and dls_solver_solve. */
DLS_API DLS_MUST_USE dls_status dls_solve(const dls_contact *problem,
                                          const dls_solver_settings *settings, double *r, double *u,
                                          dls_info *info, dls_error *error);

/* Solves the contact problem of a reduction, with f and g as last loaded, and recovers x. The pair
 * (x, r) is solved if dls_reduction_certify certifies it for the body. If r solves the problem on W
 * but not that of the body (soft supports), the method auto continues on K itself (global.h). A
 * reduction on K (settings.on) solves there at once, by method auto alone; a warm start then uses r
 * and the x of the last solve.
 *
 *   mu        as in dls_reduction_contact
 *   settings  NULL for the defaults
 *   r (m)     in: the start if warm_start; out: reactions
 *   u (m)     or NULL: H^T x + g
 *   x (n)     unknowns
 *   info      or NULL: certificate is that of the body
 *
 * Statuses of dls_solver_solve and, with the best pair found: DLS_NOT_IN_EQUILIBRIUM, the forces of
 * a body do not balance (certificate.unbalanced of body certificate.body); DLS_NO_SOLUTION: also
 * where a rigid motion proves that nothing can hold a body (dls_reduction_motion). Allocates.
 * Errors of dls_reduction_contact, dls_solve, dls_global_solve. */
DLS_API DLS_MUST_USE dls_status dls_reduction_solve(dls_reduction *reduction, const double *mu,
                                                    const dls_solver_settings *settings, double *r,
                                                    double *u, double *x, dls_info *info,
                                                    dls_error *error);

/* Solves the contact problem of a model in one call: chooses W or K by the estimated cost, loads f
 * and g, solves by method auto, recovers x. For several loads on one K, or for settings, create a
 * reduction (dls_reduction_create, _load, _solve).
 *
 *   f (n)            loads, or NULL for 0
 *   g (d * nodes)    gaps, or NULL for 0
 *   mu (candidates)  friction, one for each active contact; NULL: model->mu
 *   r (m)            out: reactions, m = d * (active contacts)
 *   u (m)            or NULL: H^T x + g
 *   x (n)            out: unknowns
 *   info             or NULL: certificate is that of the body
 *
 * Any status >= 0 sets all outputs; the answer is certified if dls_solved(status). Statuses of
 * dls_reduction_solve. Errors of dls_reduction_create, dls_reduction_load, dls_reduction_solve. */
DLS_API DLS_MUST_USE dls_status dls_solve_model(const dls_model *model, const double *f,
                                                const double *g, const double *mu, double *r,
                                                double *u, double *x, dls_info *info,
                                                dls_error *error);

/* Judges an answer (x, r) that a host has computed itself: sets info->certificate to that of the
 * body, and info->status, which is returned. A solved status stays if the certificate holds to
 * max(tol, eps cond(K)), at most 1e-8. Errors of dls_reduction_certify. */
DLS_API DLS_MUST_USE dls_status dls_reduction_judge(dls_reduction *reduction, const double *mu,
                                                    const double *r, const double *x, double tol,
                                                    dls_info *info, dls_error *error);

/* Returns the rigid motion (n) that proves DLS_NO_SOLUTION of dls_reduction_solve, as
 * dls_global_motion, or NULL. Lives until the next solve, update or destroy. */
DLS_API const double *dls_reduction_motion(dls_reduction *reduction, int *unknown);

/* Solves problem[0 .. count-1] independently, with one set of settings (NULL: the defaults). r[k]
 * as in dls_solve; u NULL, or u[k] (or NULL); info NULL, or info[count]. The memory is allocated
 * once, for the largest problem.
 *
 * Consecutive problems with the same number of contacts, at most 8, are swept eight at a time, one
 * in each lane of a register, if the method is auto, they start from r = 0, and neither a callback
 * nor a limit of iterations or time is set. dls_solve solves those that the certificate then
 * refuses, and all others. An answer from lanes has one stage, nlgs, and info.unique is not
 * computed. If a problem has several solutions, dls_solve may find another.
 *
 * Returns DLS_OK if all are solved, else the status of the first that is not; info[k].status has
 * each. Errors: those of dls_solve. An error in problem k names "problem", k and, in the message,
 * what is wrong there; nothing has been solved then. After DLS_E_MEMORY some may have been. */
DLS_API DLS_MUST_USE dls_status dls_solve_batch(int count, const dls_contact *problem,
                                                const dls_solver_settings *settings,
                                                double *const *r, double *const *u, dls_info *info,
                                                dls_error *error);

#ifdef __cplusplus
}
#endif

#endif
