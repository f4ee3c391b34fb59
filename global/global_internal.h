/*
 * global_internal.h: declares what the files of global/ share.
 *
 * Round variables: r' = D^1/2 r, u' = D^-1/2 u, g' = D^-1/2 g, H' = H D^-1/2, mu' = mu
 * (w_t/w_n)^1/2 with the weights D of the certificate (base/body.h). The law between u' and r' with
 * mu' is the same law, and H' r' = H r. All files but global.c work in them and write no primes.
 */
#ifndef DLSI_GLOBAL_H
#define DLSI_GLOBAL_H

#include "base/body.h"
#include "base/columns.h"
#include "delassus/global.h"
#include "linear/anderson.h"
#include "linear/cholesky.h"
#include "linear/dense.h"
#include "linear/general.h"
#include "linear/operator.h"
#include "linear/redundant.h"
#include "linear/sparse_lu.h"

/* ---- system.c: A = K + rho H H^T + E --------------------------------------------------------- */

typedef struct dlsi_system {
  int n, d;
  int symmetric, definite;    /* definite: 0 after a pivot has shown that A is not */
  size_t entries, of_K, of_H; /* entries = of_K + of_H + n, in this order, of one triangle where K
                                 is symmetric */
  int *row, *col;             /* counted from 1: entries */
  double *x;                  /* values of A: entries */
  double *h;                  /* values of H H^T: of_H */
  const double *K;            /* values of K, borrowed: of_K */
  dls_sparse H;               /* borrowed */
  double *e;                  /* n: E is hold * e; |K_jj|, or the largest entry of column j; 0 of
                                 multipliers: redundant joints are not in K */
  double hold;                /* 0 where nothing is singular */
  double *size;               /* n: scratch */
  dlsi_cholesky *cholesky;    /* NULL where K is not symmetric */
  dlsi_general general;
} dlsi_system;

/* Analyses. K: sparse, repeated entries added up; of a symmetric K only the lower triangle. H: n
 * x m, d columns a contact. joint: 1 of a multiplier, n; NULL: there is none. The values are read,
 * and K.Ks.x and H are borrowed. *out = NULL on error: DLS_E_MEMORY, DLS_E_SIZE. */
dls_status dlsi_system_create(dlsi_system **out, const dls_model *K, const dls_sparse *H, int d,
                              const int *joint, dls_error *error);

/* Orders and analyses A, or A + A^T where K is not symmetric. *out = NULL on error:
 * DLS_E_MEMORY. */
dls_status dlsi_system_analyse(const dlsi_system *work, dlsi_cholesky **out, dls_error *error);

/* Takes new values on the same pattern. */
void dlsi_system_update(dlsi_system *work, const dls_model *K, const dls_sparse *H,
                        const int *joint);

/* Factors A. If A is singular, or a pivot is rounding, hold := 1e-8: then E holds what nothing else
 * holds. The caller adds E x_old to the right side, so that a fixed point does not depend on E. LU
 * if A is not definite. DLS_E_SINGULAR, DLS_E_UNSUPPORTED, DLS_E_MEMORY. */
dls_status dlsi_system_factor(dlsi_system *work, double rho, dls_error *error);

/* Factors K + H M H^T + E in place of A. M: symmetric, a block for each contact: 4 numbers, nn, tt,
 * ss, ts; other couplings are 0. DLS_E_SINGULAR if that is not definite, DLS_E_MEMORY. */
dls_status dlsi_system_factor_weighted(dlsi_system *work, const double *M, dls_error *error);

/* x := A^-1 x. DLS_E_MEMORY. */
dls_status dlsi_system_solve(dlsi_system *work, double *x, dls_error *error);

/* NULL is fine. */
void dlsi_system_destroy(dlsi_system *work);

/* ---- the workspace --------------------------------------------------------------------------- */

struct dls_global {
  atomic_int busy;
  int d, nc, nodes;
  int n, m;
  dls_model whole; /* a view of K: n, operator_kind DLS_STIFFNESS_SPARSE, factorization, Ks */
  dls_model model; /* whole without redundant joints: for all except the certificate */
  dlsi_columns K;
  dlsi_apart apart;
  dlsi_operator operator; /* H^T as it is, P, mu of the model */
  dlsi_columns H;         /* n x m, round */
  dlsi_body body;
  double *w, *root;         /* 2 nc; m: D^1/2 */
  int *part;                /* 3 n: of the body */
  dlsi_system *system;      /* NULL: solver */
  dls_global_solver solver; /* in place of system, if it has functions */
  double *R;                /* m: rho D^-1, for the solver */
  double accuracy;          /* asked of the solver's next solve */
  int moves;                /* 1 if `motion` proves that there is no solution */
  int mover;                /* its body, -1: joints */
  double *motion;           /* n */

  /* of the current solve */
  const dls_limits *limits;
  double begun;
  int iterations, factorisations;
  const double *load;      /* n: the caller's f; NULL: 0 */
  double *f;               /* n: 0 in redundant joints */
  double *gap, *mu, *bend; /* g of the contacts, m; mu and mu' of the contacts, nc */
  double *g;               /* D^-1/2 gap: m */
  double rho;
  double *q, *r, *z;       /* m: state; reactions; rho times the law's last positions */
  double *p, *before;      /* m: r - rho u; scratch */
  int *state;              /* nc: dls_contact_state, -1: not known */
  double *x, *y;           /* n: unknowns; right side and solution */
  double *u;               /* m: H^T x + g */
  double *best_r, *best_x; /* as the caller has them: m, n */
  double *trial, *look;    /* m: r, u as the caller has them */
  double *scratch;         /* dlsi_body_scratch */
  dls_certificate best;
  dlsi_anderson history; /* of q */
  void *memory;          /* of the arrays */
  size_t bytes;          /* at `memory` */
};

/* ---- global.c -------------------------------------------------------------------------------- */

/* *out := a problem whose K is elsewhere. Reads d, n, nodes, factorization, HN, HT of `model`.
 * body: its multiply, data, w, part, parts are borrowed. solver: copied. */
dls_status dlsi_global_create_on(dls_global **out, const dls_model *model, const dlsi_body *body,
                                 const dls_global_solver *solver, dls_error *error);

/* ---- pair.c ---------------------------------------------------------------------------------- */

/* u := H^T x + g and v += H r with the round H. */
void dlsi_global_look(const dls_global *work, const double *x, double *u);
void dlsi_global_push(const dls_global *work, const double *r, double *v);

/* Measures the pair (work->x, r), r round, and keeps it if it is the best so far. Returns DLS_OK if
 * it is solved, DLS_TO_ROUNDING, or DLS_STALLED to go on. *found receives the certificate. */
dls_status dlsi_global_measure(dls_global *work, const double *r, dls_certificate *found);

/* Call a host's function in the environment of the host (base.h), as dls_global_solver says. Return
 * its answer as a status of the solve. Fill *error if the host has not. */
dls_status dlsi_host_prepare(const dls_global_solver *solver, const double *R, dls_error *error);
dls_status dlsi_host_solve(const dls_global_solver *solver, const double *b, double *x,
                           double accuracy, dls_error *error);

/* Asks a host's solver for an accuracy that suits this relative change of q, NaN for 0 / 0. */
void dlsi_global_ask(dls_global *work, double change);

/* Factors A for work->rho, and counts. */
dls_status dlsi_global_factor(dls_global *work, dls_error *error);

/* x := the solution of A x = f + H (2 r - q - rho g) + E x for r, q; u := H^T x + g. g NULL for
 * 0. */
dls_status dlsi_global_step(dls_global *work, const double *r, const double *q, const double *g,
                            dls_error *error);

/* ---- splitting.c ----------------------------------------------------------------------------- */

/* Solves from work->r, work->x in at most `most` iterations. work->best_r, best_x receive the best
 * pair. Returns a status of a solve. */
dls_status dlsi_global_split(dls_global *work, int most, dls_error *error);

/* ---- newton.c -------------------------------------------------------------------------------- */

/* Takes Newton steps from work->x and r (round, m) and measures each. hold: factor of E if the
 * states leave a motion free; 0: the steps end there. Returns as dlsi_global_measure, or an error.
 * Keeps x, spoils r and u. */
dls_status dlsi_global_newton(dls_global *work, double *r, double hold, dls_error *error);

/* ---- interior.c ------------------------------------------------------------------------------ */

/* x, r := the solution of the convex problem (GI1) with gaps g (m; NULL: 0) and springs hold E
 * without force at `old` (n; NULL: 0). Starts from points of `start` times the size of f and g. All
 * round; x: n; r: m, NULL if not wanted. DLS_OK, DLS_STALLED with the last point, DLS_E_MEMORY,
 * DLS_CANCELLED, DLS_TIME_LIMIT. */
dls_status dlsi_global_interior(dls_global *work, double hold, double start, const double *old,
                                const double *g, double *x, double *r, dls_error *error);

/* ---- fixed.c --------------------------------------------------------------------------------- */

/* Solves by convex problems, from zero. Returns as dlsi_global_measure, or an error. Keeps x,
 * spoils r and u. */
dls_status dlsi_global_fixed(dls_global *work, dls_error *error);

/* ---- lagrangian.c ---------------------------------------------------------------------------- */

/* Takes up to `most` steps of the augmented Lagrangian from work->x and the reactions r (round, m),
 * and measures. Returns as dlsi_global_measure, or an error. Spoils x, u, before. Afterwards A is
 * not the one of work->rho. */
dls_status dlsi_global_lagrangian(dls_global *work, const double *r, int most, dls_error *error);

/* ---- motion.c -------------------------------------------------------------------------------- */

/* Looks for a rigid motion that nothing can hold. *proved := 1: work->motion holds it. Keeps q, r,
 * p, x, u; spoils y. DLS_E_MEMORY. */
dls_status dlsi_global_prove(dls_global *work, int *proved, dls_error *error);

/* ---- contradiction.c ------------------------------------------------------------------------- */

/* Checks after a step whether redundant joints hold, too. *proved := 1: they contradict others, and
 * work->motion is the proof. DLS_E_MEMORY. */
dls_status dlsi_global_contradict(dls_global *work, int *proved, dls_error *error);

#endif
