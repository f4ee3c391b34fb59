/*
 * global_internal.h: declares what the files of global/ share.
 *
 * Round variables: r' = D^1/2 r, u' = D^-1/2 u, g' = D^-1/2 g, H' = H D^-1/2, mu' = mu
 * (w_t/w_n)^1/2 with the weights D of the certificate (base/body.h). The law between u' and r' with
 * mu' is the same law, and H' r' = H r. All files but global.c work in them and write no primes.
 */
#ifndef DLSI_GLOBAL_H
#define DLSI_GLOBAL_H

#include "contact/body.h"
#include "contact/columns.h"
#include "delassus/global.h"
#include "linear/anderson.h"
#include "linear/dense.h"
#include "linear/general.h"
#include "linear/operator.h"
#include "linear/own.h"
#include "linear/redundant.h"
#include "linear/sparse_lu.h"
#include "linear/system.h"

/* ---- the workspace --------------------------------------------------------------------------- */

/* *proved := 1 if no answer exists. */
typedef dls_status (*dlsi_global_proof)(void *data, int *proved, dls_error *error);

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
  double *w, *root;         /* 2 nc, then shares, n, of a K that is here; m: D^1/2; with
                               ranks of their reach */
  int *part;                /* 3 n: of the body */
  dlsi_system *system;      /* NULL: solver */
  dls_global_solver solver; /* in place of system, if it has functions */
  dlsi_global_proof prove;  /* in place of motion.c, or NULL */
  void *prover;
  double *R;       /* m: rho D^-1, for the solver */
  double accuracy; /* asked of the solver's next solve */
  int moves;       /* 1 if `motion` proves that there is no solution */
  int mover;       /* its body, -1: joints */
  double *motion;  /* n */

  /* of the current solve */
  const dls_limits *limits;
  double begun;
  int iterations, factorisations;
  int scattered;           /* Newton steps from scattered states, ... */
  double unscattered;      /* ... and the residual before */
  const double *given;     /* n: the caller's f; NULL: 0 */
  const double *load;      /* n: the same, or f' once the own deformation is split off */
  double *f;               /* n: 0 in redundant joints */
  double *gap, *mu, *bend; /* g of the contacts, m; mu and mu' of the contacts, nc */
  double *g;               /* D^-1/2 gap: m */
  double rho;
  double *q, *r, *z;       /* m: state; reactions; rho times the law's last positions */
  double *p, *before;      /* m: r - rho u; scratch */
  int *state;              /* nc: dls_contact_state, -1: not known */
  double *x, *y;           /* n: unknowns; right side and solution */
  double *u;               /* m: H^T x + g */
  double *own;             /* n: the body's own deformation, split off; 0 before */
  double *flight;          /* n: motions that K holds by its rounding alone, moved into gap */
  double *balanced, *blur; /* 2 parts, m: of body, once split */
  int from_r;              /* 1: a warm start without x: the states of r, and an x from them */
  int unread;              /* info.error is left 0 */
  int is_split;            /* 1: f, load, gap, g are of the split problem, x and best_x its y */
  double *best_r, *best_x; /* as the caller has them: m, n */
  double *trial, *look;    /* m: r, u as the caller has them */
  double *scratch;         /* dlsi_body_scratch */
  dls_certificate best;
  dlsi_anderson history; /* of q */
  void *memory;          /* of the arrays */
  size_t bytes;          /* at `memory` */
};

/* ---- global.c -------------------------------------------------------------------------------- */

/* *out := a problem whose K is elsewhere. Reads d, n, nodes, factorization, HN, HT of `model`; with
 * ranks n is of this rank, and nodes are those that its rows of H touch, its own first.
 * body: its multiply, data, ranks, nc, w, part, parts are borrowed. solver: copied. */
dls_status dlsi_global_create_on(dls_global **out, const dls_model *model, const dlsi_body *body,
                                 const dls_global_solver *solver, dls_error *error);

/* Looks for the motion of a proof, without a solve; f, mu: n, contacts. *proved := 1:
 * dls_global_motion returns it. */
dls_status dlsi_global_prove_for(dls_global *work, const double *f, const double *mu, int *proved,
                                 dls_error *error);

/* ---- pair.c ---------------------------------------------------------------------------------- */

/* u := H^T x + g and v += H r with the round H; g: m, NULL for 0. */
void dlsi_global_look_from(const dls_global *work, const double *g, const double *x, double *u);
void dlsi_global_look(const dls_global *work, const double *x, double *u);
void dlsi_global_push(const dls_global *work, const double *r, double *v);

/* Returns 1 if the own deformation can be split off, and has not been. */
int dlsi_global_can_split(const dls_global *work);

/* Returns 1 if there are contacts, on any rank. */
int dlsi_global_touches(const dls_global *work);

/* Returns the mean of w_n. */
double dlsi_global_compliance(const dls_global *work);

/* Returns 1 if K = 0. */
int dlsi_global_is_rigid(const dls_global *work);

/* Measures the pair (work->x, r), r round, and keeps it if it is the best so far. Returns DLS_OK if
 * it is solved, DLS_TO_ROUNDING, DLS_STALLED to go on, or dlsi_split_first. *found receives the
 * certificate. */
dls_status dlsi_global_measure(dls_global *work, const double *r, dls_certificate *found);

/* Call a host's function in the environment of the host (base.h), as dls_global_solver says. Return
 * its answer as a status of the solve. Fill *error if the host has not. */
dls_status dlsi_host_prepare(dls_global_prepare_fn prepare, void *data, const double *R,
                             dls_error *error);
dls_status dlsi_host_solve(dls_global_solve_fn solve, void *data, const double *b, double *x,
                           double accuracy, dls_error *error);

/* Asks a host's solver for an accuracy that suits this relative change of q, NaN for 0 / 0. */
void dlsi_global_ask(dls_global *work, double change);

/* Factors A for work->rho, and counts. */
dls_status dlsi_global_factor(dls_global *work, dls_error *error);

/* x := the solution of A x = f + H (2 r - q - rho g) + E x for r, q; u := H^T x + g. g NULL for
 * 0. */
dls_status dlsi_global_step(dls_global *work, const double *r, const double *q, const double *g,
                            dls_error *error);

/* ---- loads.c --------------------------------------------------------------------------------- */

/* Of a measure: solved but for loads that may balance in themselves. The solve ends, and begins
 * again after dlsi_global_split_off. No status of the library. */
static const dls_status dlsi_split_first = (dls_status)100;

/* Splits it off: f, load, gap, g, own. Spoils y and the factor of A. An error of a solve. */
dls_status dlsi_global_split_off(dls_global *work, dls_error *error);

/* Moves the rigid motions that K holds by its rounding alone out of the best pair, if rounding
 * levels need a second look, and measures it again: flight and gap, g receive them, r and x the
 * pair. Returns `verdict`, that of the new measure, or DLS_NOT_IN_EQUILIBRIUM: go on from there.
 * Spoils y and the factor of A. */
dls_status dlsi_global_land(dls_global *work, dls_status verdict, dls_error *error);

/* ---- splitting.c ----------------------------------------------------------------------------- */

/* Solves from work->r, work->x in at most `most` iterations. work->best_r, best_x receive the best
 * pair. Returns a status of a solve. */
dls_status dlsi_global_split(dls_global *work, int most, dls_error *error);

/* Returns the status of a solve that ended with `status` and the best pair unsolved. */
dls_status dlsi_global_verdict(const dls_global *work, dls_status status);

/* ---- newton.c -------------------------------------------------------------------------------- */

/* Takes Newton steps from work->x and r (round, m) and measures each. hold: factor of E if the
 * states leave a motion free; 0: the steps end there. draw: not 0: scattered steps (GN4). Returns
 * as dlsi_global_measure, or an error. Keeps x, spoils r and u. */
dls_status dlsi_global_newton(dls_global *work, double *r, double hold, uint64_t draw,
                              dls_error *error);

/* Improves the best pair by a step, if it can, and predicts |r - r*| / |r|: INFINITY if the
 * reactions are not determined, 0 for a host's solver or more than 1,000 unknowns and reactions.
 * Spoils x, r, u, before. DLS_OK or an error. */
dls_status dlsi_global_accuracy(dls_global *work, double *predicted, dls_error *error);

/* ---- krylov.c -------------------------------------------------------------------------------- */

/* A z = b with a preconditioner. Vectors have `size` entries, of this rank. */
typedef struct dlsi_krylov {
  size_t size;
  const dlsi_ranks *ranks;
  void *data;
  void (*apply)(void *data, const double *z, double *w);
  dls_status (*precondition)(void *data, double *b, double *z, dls_error *error);
} dlsi_krylov;

/* z := about A^-1 b, |b - A z| <= eta |b| if 30 steps are enough. Spoils b.
 * DLS_E_MEMORY, or what the preconditioner returns. */
dls_status dlsi_krylov_solve(const dlsi_krylov *of, double eta, double *b, double *z,
                             dls_error *error);

/* ---- scatter.c ------------------------------------------------------------------------------- */

/* Takes Newton steps from scattered states after a solve that failed. Returns `failed`, or the
 * status of a pair found, or an error. Spoils x, r, u, before. */
dls_status dlsi_global_scatter(dls_global *work, dls_status failed, dls_error *error);

/* ---- interior.c ------------------------------------------------------------------------------ */

/* x, r := the solution of the convex problem (GI1) with gaps g (m; NULL: 0) and springs hold E
 * without force at `old` (n; NULL: 0). Starts from points of `start` times the size of f and g. All
 * round; x: n; r: m, NULL if not wanted. DLS_OK, DLS_STALLED with the last point, DLS_E_MEMORY,
 * DLS_CANCELLED, DLS_TIME_LIMIT. */
dls_status dlsi_global_interior(dls_global *work, double hold, double start, const double *old,
                                const double *g, double *x, double *r, dls_error *error);

/* ---- fixed.c --------------------------------------------------------------------------------- */

/* Solves by convex problems, from zero; rests: 1 for one of them. Returns as dlsi_global_measure,
 * or an error. Keeps x, spoils r and u. */
dls_status dlsi_global_fixed(dls_global *work, int rests, dls_error *error);

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
