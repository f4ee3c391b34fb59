/*
 * delassus/motion.h: bodies that move: the theta scheme with contact and friction, and paths of
 * equilibria. [Jean 1988] 2 and 3. The guide, "Bodies that move", says when to use which law.
 *
 *   M v' + C v + K x = f + H p/h,   gap = gap0 + H_n^T x - y_n,   u = H^T v - y'
 *   A = M + h theta C + h^2 theta^2 K                                 reduced once for a given h
 *   A (v+ - v) = h (f - C v - K x - h theta K v) + H p
 *   x+ = x + h (theta v+ + (1 - theta) v)
 *
 *   x, v   unknowns of the host and their velocities, n             length, length / time
 *   f      loads, the mean over the step, n                         force
 *   p      impulses of the obstacle on the body during the step     force time
 *   u      local relative velocities, at the end of the step        length / time
 *   y, y'  motion of the obstacle; y' is its mean over the step     length, length / time
 *   gap0   normal gap at x = 0, nodes                               length
 *
 * The laws, at each candidate to contact, with Coulomb's law on u_t+ and p in all of them:
 *
 *   velocity form   0 <= u_n+ + e u_n  _|_  p_n >= 0   where gap + forecast h u_n <= activation, or
 *                   <= 1e-6 h max |q| of a contact that was closed in the last step, q being u
 *                   without contact; p = 0 elsewhere                (2.1)3-4, Moreau
 *   gap form        0 <= u_n+ + gap / h  _|_  p_n >= 0              (3.2)1; theta = 1 only
 *   path            no M: K x = f + H r; 0 <= gap+ _|_ r_n >= 0; the slip u_t is counted from the
 *                   step before: u = H^T (x+ - x) - h y', a length  (2.1)1; p stands for r, a force
 *
 * In 1/2 <= theta <= 1, with v_th = theta v+ + (1 - theta) v and E = (v.M v + x.K x) / 2, exactly
 *
 *   E+ - E = (1/2 - theta)(|dv|_M^2 + |dx|_K^2) - h v_th.C v_th + h f.v_th + p.(H^T v_th)
 *
 * for symmetric M and K; on a path E+ - E = f.dx + r.(H^T dx) - |dx|_K^2 / 2.
 */
#ifndef DELASSUS_MOTION_H
#define DELASSUS_MOTION_H

#include "delassus/model.h"
#include "delassus/solve.h"

#ifdef __cplusplus
extern "C" {
#endif

typedef enum dls_motion_law {
  DLS_MOTION_VELOCITY = 1, /* impacts, with restitution; 1/2 <= theta <= 1 */
  DLS_MOTION_GAP = 2,      /* [J] (3.2)1: no penetration at the end of a step; theta = 1 */
  DLS_MOTION_PATH = 3      /* equilibria, one after the other: no M, theta is not read */
} dls_motion_law;

/* The bodies: views, borrowed as long as the motion lives. Of M, C, K tagged as symmetric only the
 * lower triangle is read. Columns of HN, HT and P are those of dls_model (model.h); candidates are
 * the columns of P, or the contact nodes. */
typedef struct dls_motion_model {
  int d;                           /* 2 or 3 */
  int n;                           /* unknowns */
  int nodes;                       /* contact nodes, >= 0 */
  dls_factorization factorization; /* of M, C, K and A: DLS_CHOLESKY, DLS_LDLT or DLS_LU; of
                                      DLS_CHOLESKY, with multipliers among the unknowns (model.h) A
                                      is factorised as DLS_LDLT */
  dls_sparse M;                    /* n x n; M.p = NULL for a path */
  dls_sparse C;                    /* n x n; C.p = NULL for none; a path has none */
  dls_sparse K;                    /* n x n; K.p = NULL for none: rigid bodies */
  dls_sparse HN;                   /* n x nodes */
  dls_sparse HT;                   /* n x (d-1) nodes */
  dls_sparse P;                    /* nodes x candidates; P.p = NULL for none */
  const double *gap;               /* nodes: gap at x = 0; NULL for 0; read by create only */
} dls_motion_model;

/* Settings: call dls_motion_settings_init, set h, then change fields. The default stands last in
 * each comment. */
typedef struct dls_motion_settings {
  dls_limits limits;  /* of the contact problem of a step; tol: 1e-12; warm_start: 1, from the
                         impulses of the step before */
  size_t size;        /* set by init; settings without it are refused */
  dls_motion_law law; /* DLS_MOTION_VELOCITY */
  dls_method method;  /* of the contact problem; DLS_AUTO */
  double h;           /* step, > 0; init leaves 0, which is refused; 1 for a path may do   time */
  double theta;       /* 1/2 <= theta <= 1; 1/2 */
  double restitution; /* e, 0 <= e <= 1, of the velocity form; 0 */
  double activation;  /* >= 0: gap below which a candidate is closed in the velocity form; 0. Bodies
                         that rest on each other need none                              length */
  double forecast;    /* 0 <= forecast <= 1: fraction of the step after which the gap is predicted;
                         1/2 */
  int energy_consistent; /* 1: where friction and restitution together would create energy (Kane
                            1984), the step takes the largest e up to `restitution` that creates
                            none; 0 */
} dls_motion_settings;

/* Sets each field to its default. */
DLS_API void dls_motion_settings_init(dls_motion_settings *settings);

typedef struct dls_motion dls_motion;

/* Creates a motion: *out, the bodies at rest at x = 0; NULL on error. Reduces A. Memory: that of
 * dls_reduction_create, and O(n + nnz); on W also that of dls_solver_create, and (d candidates)^2
 * doubles. Checks all arguments before any work:
 * DLS_E_ARGUMENT, DLS_E_SIZE, DLS_E_NOT_FINITE, DLS_E_SETTINGS naming "h", "theta", "M", ... and
 * the index. The errors of dls_reduction_create: of a singular A they name M, on a path K. */
DLS_API DLS_MUST_USE dls_status dls_motion_create(dls_motion **out, const dls_motion_model *model,
                                                  const dls_motion_settings *settings,
                                                  dls_error *error);

/* Restarts from x and v (n; NULL for 0; a path has no v) at time t: impulses, slip, works, the
 * travel of the obstacle and the count of steps become 0. DLS_E_ARGUMENT, DLS_E_NOT_FINITE. */
DLS_API DLS_MUST_USE dls_status dls_motion_start(dls_motion *motion, const double *x,
                                                 const double *v, double t, dls_error *error);

/* Takes a step. f (n; NULL for 0; on a path the loads at its end); y (d nodes in local order: mean
 * velocity y' of the obstacle during the step, at each contact node; NULL for 0); mu (candidates;
 * NULL for 0); info or NULL: of the contact problem.
 *
 * DLS_OK: the contact problem is certified to limits.tol. Any other status, > 0 or an error: the
 * state is that of the last step; change the limits or reduce h, and try again. Takes one and a
 * half solves with A. Allocates nothing (MUMPS does). */
DLS_API DLS_MUST_USE dls_status dls_motion_step(dls_motion *motion, const double *f,
                                                const double *y, const double *mu, dls_info *info,
                                                dls_error *error);

/* Changes the step h from the next step on: forms and factorises A again, on the old pattern. The
 * state stays. On a path h is only the unit of y'. DLS_E_ARGUMENT for a wrong h, and the errors of
 * dls_reduction_update, after which only start, set_h and destroy may be called. */
DLS_API DLS_MUST_USE dls_status dls_motion_set_h(dls_motion *motion, double h, dls_error *error);

/* Changes the limits of the contact problem from the next step on. Errors of
 * dls_solver_set_limits. */
DLS_API DLS_MUST_USE dls_status dls_motion_set_limits(dls_motion *motion, const dls_limits *limits,
                                                      dls_error *error);

/* The state after the last step that was certified. The arrays belong to the motion, stay in their
 * place as long as it lives, and change with each step. */
typedef struct dls_motion_state {
  int d, n, candidates;
  long long steps;
  double t;            /* start + the h of each step */
  const double *x, *v; /* n; on a path v = (x+ - x) / h */
  const double *p;     /* d candidates: impulse of the step; on a path the reactions, forces */
  const double *u;     /* d candidates: H^T v+ - y'; on a path H^T (x+ - x) - h y', a length */
  const double *gap;   /* candidates: after the step */
  const double *slip; /* (d-1) candidates: the sum of all h (theta u_t+ + (1-theta) u_t), the travel
                          of the body's point on the obstacle                  length */
  const dls_contact_state *state; /* candidates; DLS_FREE where it took no part */
  int active;                     /* candidates in the contact problem of the step */
  const int *active_list;         /* active: their numbers, ascending */
  double restitution;             /* e of the step; with energy_consistent it may be less */
} dls_motion_state;

/* Sets *state to views of the motion, which live as long as it does and change with each step.
 * DLS_E_ARGUMENT. */
DLS_API DLS_MUST_USE dls_status dls_motion_get_state(const dls_motion *motion,
                                                     dls_motion_state *state, dls_error *error);

/* Energies now, works of all steps since the start, and the checks of the last step. elastic +
 * kinetic - (those at the start) = load + damping + obstacle + friction + impact + numerical. */
typedef struct dls_motion_energies {
  double kinetic, elastic; /* v.M v / 2, x.K x / 2                             work */
  double load;             /* h f.v_th */
  double damping;          /* -h v_th.C v_th */
  double obstacle;         /* p.y', of the obstacle's motion */
  double friction;         /* p_t.u_t,th; > 0 only for theta < 1, where slip reverses */
  double impact;           /* p_n.u_n,th; on a path r_n (gap+ - gap) */
  double numerical;        /* (1/2 - theta)(|dv|_M^2 + |dx|_K^2); on a path -|dx|_K^2 / 2 */
  /* |left - right| of the identity in the last step, and what is rounded in it: the largest so far
   * of (|v|.|M||v| + |x|.|K||x|) / 2 and of |v_th|.s, where s = |M||dv| + h |f| + h |C||v_th| +
   * h |K||x_th| + |H||p|, x_th as v_th (on a path of |dx|.(|f| + |K||x+| + |H||r|)), with what the
   * obstacle and friction do */
  double residual, scale; /*                                                   work */
  /* max_i |M dv - h (f - C v_th - K x_th) - H p|_i / max_i s_i of the last step   1 */
  double momentum;
  double created; /* the sum of friction + impact of the steps in which it is > 0: contact put
                     energy into the bodies, by restitution with friction, or by slip that reverses
                     within a step; 0 on a path                                            work */
} dls_motion_energies;

/* Copies the energies, works and checks of the motion into *energies. DLS_E_ARGUMENT. */
DLS_API DLS_MUST_USE dls_status dls_motion_get_energies(const dls_motion *motion,
                                                        dls_motion_energies *energies,
                                                        dls_error *error);

/* Returns the contact problem of the last step, certified or not: of the active candidates; nc = 0
 * without any, and on a path that is solved on K. Use it with dls_contact_diagnose, or to solve the
 * problem by another method. It lives until the next step. DLS_E_ARGUMENT. */
DLS_API DLS_MUST_USE dls_status dls_motion_get_problem(const dls_motion *motion,
                                                       dls_contact *problem, dls_error *error);

/* Frees the object; NULL is fine. */
DLS_API void dls_motion_destroy(dls_motion *motion);

#ifdef __cplusplus
}
#endif

#endif
