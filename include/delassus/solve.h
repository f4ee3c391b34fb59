/*
 * delassus/solve.h: the front door: one call for any method.
 */
#ifndef DELASSUS_SOLVE_H
#define DELASSUS_SOLVE_H

#include "delassus/nlgs.h"
#include "delassus/reduction.h"

#ifdef __cplusplus
extern "C" {
#endif

/* Fill by dls_solver_settings_init, then change what you like; NULL in their place: the
 * defaults. */
typedef struct dls_solver_settings {
  dls_limits limits; /* max_iterations: of auto, of all its stages together */
  size_t size;       /* set by init; settings without it are refused */
  dls_method method; /* DLS_AUTO */
  int facets;        /* lemke, d = 3: of the friction cone, even, 4 to DLS_FACETS_MAX; 0: 8; 0 */
  dls_acceleration acceleration; /* nlgs; DLS_ACCELERATION_NONE */
  int positive_definite; /* 1: W is known to be symmetric positive definite: newton, alone and in
                            auto, leaves its regularisation out; 0 */
  dls_forces forces;     /* DLS_FORCES_LEAST: a solved r is replaced by the least reactions of its
                        positions, where W is symmetric and mu finite (src/facts/least.c); it takes
                        as much memory as newton, and some of its steps (bench/results/least.md).
                        info.forces says whether it was. auto follows no line through the last
                        answers then, and lanes of dls_solve_batch are not used. DLS_FORCES_ANY */
  /* auto, to see what its steps are worth; NULL: all as auto thinks best; NULL. Read by create.
   *
   * plan, "sweeps:30,newton,homotopy": these steps in turn, in the place of auto's own. ":30" lets
   * a step take 30 iterations; without it a step ends as in auto, the last one by itself. Up to
   * DLS_STAGES_MAX steps. They work on the problem as it is: no candidate is left out, no copy is
   * made, no line through the last answers followed, no answer made better whose info.error is
   * large. dls_reduction_solve does not go on with the problem on K.
   *
   * without, "homotopy,scatter": auto's plans less these steps; with a plan, that one less these.
   *
   * Words: those of dls_step but interior-point and on-K. */
  const char *plan, *without;
} dls_solver_settings;

DLS_API void dls_solver_settings_init(dls_solver_settings *settings);

/* Name of a method ("auto", "nlgs", ...) and one line on what it is for and when to take it; NULL
 * for a number that is no method. Methods are numbered from 0 without gaps. */
DLS_API const char *dls_method_name(dls_method method);
DLS_API const char *dls_method_summary(dls_method method);

/* *method := the one of that name. Returns 0 if there is none. */
DLS_API int dls_method_find(const char *name, dls_method *method);

/* "none", "aitken", "anderson", "momentum"; 0 for another name. */
DLS_API int dls_acceleration_find(const char *name, dls_acceleration *acceleration);

/* Workspace for problems of dimension d with at most nc candidates, reused over time steps. */
typedef struct dls_solver dls_solver;

/* *out = new workspace, NULL on error; the settings are copied. With m = d nc it takes
 *
 *   O(m) memory      nlgs, and up to 300 rows m^2 doubles as every method but auto, for info.error
 *   m^2 doubles      newton, admm, augmented-lagrangian, penalty, auto, for a W announced as dense
 *   O(blocks)        the same, for a W announced by blocks (limits.blocks), and what MUMPS needs to
 *                    factorise it
 *   3 m^2 doubles    homotopy
 *   4 m^2 doubles    auto up to 300 rows
 *   2 n^2 doubles    lemke, and auto up to n = DLS_AUTO_LEMKE_ROWS: the LCP and its table.
 *                    n = 2 nc for d = 1; n = (facets + 2) nc for d = 3; d = 2: n = 4 nc up to
 *                    4 nc = 4000, beyond that n = 3 nc, and a ray ends it. For a dense W of more
 *                    than 300 rows auto takes that memory in the solve that needs it, n <= 3000
 *
 * and O(m) besides. For W of bodies nlgs and, beyond 1000 candidates, auto take the motions of the
 * bodies; W by blocks, which all else needs, is formed at the first solve that comes to it, and
 * that memory kept.
 *
 * auto takes accelerated sweeps of Gauss-Seidel and Newton's method in turn, as their progress
 * and cost tell; between them ADMM, from 100 rows on, for a dense W, and for what may be at rest
 * (W by blocks, -q nearly in the friction cones). Each goes on from the best r so far, which is
 * what is returned. Up to 300 rows, what these leave is solved on a copy in an order and in units
 * that follow from the data, so that the order of the candidates does not decide: Lemke's method,
 * which may prove that there is no solution, the homotopy, Newton's method from scattered starts,
 * ADMM with a tiny rho from r = 0. Beyond, Lemke's method while its table is small, the augmented
 * Lagrangian and that ADMM (src/auto/plan.c). info.stage has what was done.
 *
 * Beyond 100 candidates by blocks sweeps with momentum follow the first accelerated sweeps, beyond
 * 1000 they take their place; Newton steps come last.
 *
 * Where W is dense and shows that two in five candidates or more cannot touch, a cold solve of auto
 * takes the others alone, a copy that it allocates; without memory it takes all.
 *
 * auto in steps, limits.warm_start on one solver: where r is the answer of the solve before, auto
 * follows the line through its last two answers if that is better; where Newton's method ended the
 * solve before, W dense, auto begins with it, on the factors kept since. A step in which no
 * candidate changes its state then factorises nothing. W may have changed all the same.
 *
 * lemke solves, for d = 2, the LCP of dls_contact_to_lcp and, where that ends in a ray, the one of
 * dls_contact_to_facets_lcp; for d = 3 the latter. Where the certificate does not hold yet,
 * Newton's method takes the answer to the round cone (newton.h).
 *
 * penalty is one augmentation of the augmented Lagrangian (augmented.h) with eps_c = 1e6 / w_c from
 * lambda = 0, warm_start or not. Its r has an error of about 1e-6: DLS_OK if the certificate
 * holds all the same, as a rule DLS_MAX_ITERATIONS; DLS_STALLED if the regularised problem could
 * not be solved.
 *
 * DLS_E_ARGUMENT (of plan and without with the wrong word), DLS_E_SIZE, DLS_E_SETTINGS,
 * DLS_E_MEMORY. */
DLS_API DLS_MUST_USE dls_status dls_solver_create(dls_solver **out, int d, int nc,
                                                  const dls_solver_settings *settings,
                                                  dls_error *error);

/* Changes the limits of an existing solver, from the next solve on: tol, max_iterations,
 * warm_start, progress. blocks stays that of create. DLS_E_ARGUMENT, and the limits are as they
 * were. */
DLS_API DLS_MUST_USE dls_status dls_solver_set_limits(dls_solver *solver, const dls_limits *limits,
                                                      dls_error *error);

/* r (m): in, the start if warm_start; out, the reactions. u (m) or NULL: W r + q. info or NULL.
 * r and u overlap neither each other nor W, q, mu (DLS_E_ARGUMENT).
 * Allocates nothing for a W of the storage that `blocks` announced, MUMPS apart (newton.h), and
 * apart from auto's last resort, a proof of its best r (dls_contact_prove).
 *
 * Statuses of the methods. DLS_NO_SOLUTION of lemke and auto: proved, exactly for the numbers of
 * W, q and mu; dls_solver_farkas() has the proof. DLS_NO_SOLUTION_LIKELY, of auto alone: no r can
 * be certified, any solution being too far away (src/facts/farkas.c); or all methods have failed,
 * from r = 0 and more ways than one, and no states of the candidates have a solution, d = 2 and up
 * to 8 candidates, or the reactions run away along dls_solver_direction(), d = 3 and up to 2; and
 * W shows no reason why there should be one (src/auto/verdict.c). DLS_RAY: the reactions run
 * away along dls_solver_direction(), which says nothing of solutions; with a dls_solver_farkas(),
 * that there is none near. DLS_STALLED of auto: all its methods failed. Where every q_n >= 0, and
 * where few candidates press and W couples none of them, auto answers without a workspace unless
 * it starts warm: r = 0 without a stage, or one sweep (src/auto/alone.c). */
DLS_API DLS_MUST_USE dls_status dls_solver_solve(dls_solver *solver, const dls_contact *problem,
                                                 double *r, double *u, dls_info *info,
                                                 dls_error *error);

/* After DLS_NO_SOLUTION_LIKELY or DLS_STALLED of auto or the augmented Lagrangian, the direction
 * delta (m) of dls_augmented_direction(), augmented.h, if it saw one: W delta is as good as 0 and
 * q.delta < 0. A proof only where W delta = 0, W is symmetric, delta_n >= 0 and delta_t = 0. After
 * DLS_RAY of lemke, the reactions of the ray (m), in lcp.h dz. Else NULL. Lives until the next
 * solve or destroy. */
DLS_API const double *dls_solver_direction(const dls_solver *solver);

/* After DLS_NO_SOLUTION, the proof: v (nc) with
 *
 *   v >= 0,   sum_c v_c q_cn < 0,   g_cn + mu_c |g_ct| <= 0,   g_c = sum_a v_a (row n of W_ac)
 *
 * exactly for the numbers of the problem, so that no r in the friction cones has u_n = (W r + q)_n
 * >= 0: 0 <= v.u_n = g.r + v.q_n < 0 otherwise. After DLS_RAY of lemke, DLS_STALLED or
 * DLS_NO_SOLUTION_LIKELY of auto, a v for which this holds but for rounding, if there is one:
 * nothing proved, a solution would be too large to be certified. Else NULL.
 * Lives until the next solve or destroy. */
DLS_API const double *dls_solver_farkas(const dls_solver *solver);

/* text := what auto did with a problem and why, in words, by lines: the regime, each stage with
 * its iterations, its residual, why it ended and, where it was measured, its CPU. Of another method
 * one line. At most `room` bytes with the final 0, NULL and 0: none. Returns the length of the
 * whole text without the 0; 0 without info. */
DLS_API size_t dls_explain(const dls_info *info, char *text, size_t room);

/* NULL is fine. */
DLS_API void dls_solver_destroy(dls_solver *solver);

/* create, solve and destroy in one call; limits.blocks is set from the problem. Auto allocates
 * what its stages after the first need when it comes to them. */
DLS_API DLS_MUST_USE dls_status dls_solve(const dls_contact *problem,
                                          const dls_solver_settings *settings, double *r, double *u,
                                          dls_info *info, dls_error *error);

/* Solves the contact problem of a reduction, with f and g as last loaded, and recovers x. The
 * answer is the pair (x, r), and "solved" is said by dls_reduction_certify alone, of the body.
 * Where the solution on W does not hold on the body (soft supports, rigid-body modes that springs
 * hold) the method auto goes on with the problem on K itself (global.h), which needs no springs.
 * A reduction on K (settings.on) solves there at once, by method auto alone; a warm start is then
 * from r and the x of the last solve.
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

/* Judges an answer r of the contact problem that a host has solved itself, with x recovered: sets
 * info->certificate to that of the body and info->status, which is returned, by it: a solved status
 * stays one only if the certificate holds to the larger one of tol and eps times the condition of
 * K, at most 1e-8. Errors of dls_reduction_certify. */
DLS_API DLS_MUST_USE dls_status dls_reduction_judge(dls_reduction *reduction, const double *mu,
                                                    const double *r, const double *x, double tol,
                                                    dls_info *info, dls_error *error);

/* Returns the rigid motion (n) that proves DLS_NO_SOLUTION of dls_reduction_solve, as
 * dls_global_motion, or NULL. Lives until the next solve, update or destroy. */
DLS_API const double *dls_reduction_motion(dls_reduction *reduction, int *unknown);

/* Solves problem[0 .. count-1], each by itself, with one set of settings (NULL: the defaults): r[k]
 * as in dls_solve, u NULL or u[k] (or NULL) as there, info NULL or info[count]. The memory is
 * allocated once, for the largest problem, however many there are.
 *
 * Problems of the same number of candidates, at most 8, that follow each other are swept eight at a
 * time, one in each lane of the processor's registers, if the method is auto, no callback and no
 * limit of iterations or of time is set, and they start from r = 0 (vi/lanes.c). What the
 * certificate does not accept then, and all else, is solved as by dls_solve. info says which:
 * an answer by lanes has one stage, nlgs, and unique is not looked for. Where a problem has several
 * solutions, dls_solve may find another.
 *
 * Returns DLS_OK if all are solved, else the status of the first one that is not; info[k].status
 * has each. Errors: those of dls_solve; an error in problem k names "problem", k and, in the
 * message, what is wrong there, and nothing has been solved; after DLS_E_MEMORY some may have
 * been. */
DLS_API DLS_MUST_USE dls_status dls_solve_batch(int count, const dls_contact *problem,
                                                const dls_solver_settings *settings,
                                                double *const *r, double *const *u, dls_info *info,
                                                dls_error *error);

#ifdef __cplusplus
}
#endif

#endif
