/* vi_internal.h: shared by the files of vi/, with their functions for the front door. */
#ifndef VI_INTERNAL_H
#define VI_INTERNAL_H

#include <math.h>

#include "contact/contact.h"
#include "contact/method.h"
#include "delassus/admm.h"
#include "delassus/augmented.h"
#include "delassus/newton.h"
#include "delassus/nlgs.h"
#include "linear/anderson.h"
#include "linear/room.h"

/* A contact's own block W_cc (d x d, column-major) and the terms of its solution that do not depend
 * on q (local.c). */
typedef struct dlsi_block_2d {
  double W[4], mu;
  double f, inv_pivot, inv_s; /* stick: elimination by row p */
  double inv_slip[2];         /* slip: 1 / (W_nn -+ mu W_nt) */
  int p;                      /* pivot row */
} dlsi_block_2d;

typedef struct dlsi_block_3d {
  double W[9], mu;
  double inv_a, c[2];        /* (LO2): 1 / W_nn, the column below / W_nn */
  double S[4], det, trace;   /* Schur's complement */
  double f, u01, inv0, inv1; /* LU factors of S, rows pivoted by p */
  double scale;              /* size of l */
  int p;
} dlsi_block_3d;

void dlsi_block_2d_set(dlsi_block_2d *block, const double *W, double mu);
void dlsi_block_3d_set(dlsi_block_3d *block, const double *W, double mu);

/* The kind of solution that dlsi_nlgs_local returned. */
typedef enum dlsi_local_state {
  DLS_LOCAL_NONE = -1, /* the local problem has no solution; r has the smallest error found */
  DLS_LOCAL_FREE = 0,
  DLS_LOCAL_SLIP = 1,
  DLS_LOCAL_STICK = 2
} dlsi_local_state;

/* Solves the problem of one contact exactly: r with u = W r + q, d = 1, 2 or 3; W is d x d with
 * leading dimension d. If several solutions exist, it returns the first of free, stick, slip.
 * *count, or NULL, receives their number (0 for none; 2 ends for a continuum). In 3D with W_nn <= 0
 * it tries free only. If several slips exist without stick, it always returns the same one. r is
 * finite for each W and q. */
dlsi_local_state dlsi_nlgs_local(int d, const double *W, const double *q, double mu, double *r,
                                 int *count);

/* Returns the number of solutions, up to rounding, of a local problem that has at least one. */
int dlsi_local_count(int d, const double *W, const double *q, double mu);

/* dlsi_nlgs_local without the count, for the sweep. guess (3D): first value of l >= 0 in
 * u_t = -l r_t, such as the last |u_t| / |r_t|; 0 for none. */
dlsi_local_state dlsi_local_1d(double W, const double *q, double *r);
dlsi_local_state dlsi_local_2d(const dlsi_block_2d *block, const double *q, double *r);
dlsi_local_state dlsi_local_3d(const dlsi_block_3d *block, const double *q, double guess,
                               double *r);

/* K with the unknowns of each contact node turned into its local frame (frames.c). */
typedef struct dlsi_frames {
  int n, nodes;
  size_t *start; /* n + 1: column j of K' has the entries start[j] .. start[j+1]-1: */
  int *row;      /* ... in these rows, each once */
  double *value;
  double *diagonal; /* n */
  int *node;        /* n: contact node of the unknown, -1 for none */
  int *normal;      /* nodes: the unknown that has become u_n - g_n, ... */
  int *tangent;     /* nodes: ... and u_t - g_t */
  double *T;    /* 4 nodes: x_c = T_c x'_c, by columns; unknowns in the order (normal, tangent) */
  void *memory; /* of all arrays but row and value */
} dlsi_frames;

/* Fills *frames from a model that has passed dlsi_check_model. Free it also after an error. */
dls_status dlsi_frames_create(dlsi_frames *frames, const dls_model *model, dls_error *error);
void dlsi_frames_free(dlsi_frames *frames);

/* Returns K'_nt of contact node c. */
double dlsi_frames_coupling(const dlsi_frames *frames, int c);

/* f' := T^T f, and x := T x', also in place. */
void dlsi_frames_forces(const dlsi_frames *frames, const double *f, double *local);
void dlsi_frames_unknowns(const dlsi_frames *frames, const double *local, double *x);
/* x' := T^-1 x: u - g at the contact nodes, also in place. */
void dlsi_frames_positions(const dlsi_frames *frames, const double *x, double *local);

/* ---- vi/sweep/momentum.c: momentum on sweeps ------------------------------------------------- */

struct dlsi_groups;

/* Some contacts (or bodies); list NULL: the first `count`. If slabs > 0, slab k holds
 * list[start[k]] .. list[start[k+1]-1]. No two even slabs share a row of u, nor do two odd ones. */
typedef struct dlsi_set {
  const int *list;
  int count, slabs;
  const int *start;                 /* slabs + 1 */
  const struct dlsi_groups *groups; /* the same contacts in groups (groups.h); NULL: none */
} dlsi_set;

typedef struct dlsi_momentum {
  double *r, *u;    /* start of the current sweep: m; u of bodies: v, n count */
  double *p, *pu;   /* the last step: m; pu as u */
  double reference; /* G* of (MO3) */
  dlsi_team *team;
  int k;
} dlsi_momentum;

void dlsi_momentum_carve(dlsi_momentum *mo, dlsi_arena *arena, size_t m);

/* Restarts at r and u = W r + q. changes: the contacts whose r the sweeps change, d numbers each.
 * rows: the contacts whose u they change, e numbers each; for bodies e motions. */
void dlsi_momentum_start(dlsi_momentum *mo, int d, int e, dlsi_set changes, dlsi_set rows,
                         const double *r, const double *u);

/* Computes the start of the next sweep by (MO1)-(MO4) with b <= largest. r, u: in, after a sweep;
 * out, that start. w: weights. Returns G. */
double dlsi_momentum_step(dlsi_momentum *mo, int d, int e, const double *w, double largest,
                          dlsi_set changes, dlsi_set rows, double *r, double *u);

/* ---- vi/sweep/turns.c: which variant is the quickest ----------------------------------------- */

enum { dlsi_most_ways = 3 };

typedef struct dlsi_turns {
  int ways, now;                /* number of variants; the current one */
  double price[dlsi_most_ways]; /* (TU1) */
  double spent;                 /* cost since the variant began or halved the residual */
  double least, halved, begun;  /* residuals: least; at the last halving; when the variant began or
                                   last halved it */
} dlsi_turns;

/* Begins with variant 0. ways: number of variants, 1 to dlsi_most_ways. */
void dlsi_turns_start(dlsi_turns *turns, int ways);

/* The current variant has reached `residual` at this cost. Returns 1 if another one follows. */
int dlsi_turns_advance(dlsi_turns *turns, double residual, double cost);

/* ---- vi/sweep/slabs.c: contacts that may be swept at the same time --------------------------- */

/* Returns the number of pieces of a loop over `count` contacts, for any number of threads: so sums
 * by pieces have the same bits. */
enum { dlsi_most_pieces = 64 };
int dlsi_pieces(int count);

/* Returns where piece k of 0 .. count-1 begins. */
static inline int dlsi_piece(int count, int pieces, int k) {
  return (int)((long long)count * k / pieces);
}

typedef struct dlsi_slabs {
  int *memory; /* of the arrays below, kept from one problem to the next */
  size_t room;
  dlsi_set set; /* all contacts, ascending in each slab */
  int *some;    /* start of a part of the set: slabs + 1 */
  int *rows;    /* the same of another part: slabs + 1 */
} dlsi_slabs;

/* Sorts the contacts of a problem by blocks or of bodies into slabs. DLS_E_MEMORY. */
dls_status dlsi_slabs_set(dlsi_slabs *slabs, const dls_contact *problem, dls_error *error);
void dlsi_slabs_free(dlsi_slabs *slabs);

/* Makes the next run in this workspace of dlsi_newton_method begin with the factors of the last
 * run, if they still exist (NE5). u: u of its start, which is then not measured; NULL: unknown.
 * no_more: 1 to end that run before it factorises. */
void dlsi_newton_keep(void *work, const double *u, int no_more);

/* Renames the contacts of the factors that the last run has left, dlsi_method.map. They are
 * forgotten unless contacts stay in their order and only those without an unknown come or go.
 * dlsi_nlgs_map renames the visits. */
void dlsi_newton_map(void *work, int nc, const int *from);

/* Lets the convex problem of rest.c take factorisations of so many sweeps, (AR12); 0: (AR11). */
void dlsi_rest_allow(void *work, double sweeps);

/* Returns the sweeps of the factorisation that the last run of rest.c has refused; 0: none. */
double dlsi_rest_refused(const void *work);

/* Returns about how many operations a factorisation by joints.c of a problem of bodies takes
 * (fill.c), hardly too many; 0 if there are no bodies. */
double dlsi_foresee_fill(const dls_contact *problem);

/* Returns the factorisations that the run of the augmented Lagrangian has taken so far. */
int dlsi_augmented_factorisations(const void *work);

/* Lets a run of the augmented Lagrangian take so many factorisations, within an augmentation; 0:
 * any number. */
void dlsi_augmented_allow(void *work, int factorisations);

/* Makes the next run of this stage of auto begin at its start, whatever the last one has left
 * (NL14), (AU6): it is of another problem, or from r = 0. */
void dlsi_nlgs_forget(void *work);
void dlsi_augmented_forget(void *work);

/* Returns u of the answer of the last run of nlgs, after DLS_OK. */
const double *dlsi_nlgs_gap(const void *work);
void dlsi_nlgs_map(void *work, int nc, const int *from);

/* Makes all runs in this workspace factorise again after a change of states: a W then gives the
 * same bits dense and by blocks. */
void dlsi_newton_anew(dls_newton *work);

/* Returns u of the answer of the last run, after DLS_OK. */
const double *dlsi_newton_gap(const void *work);

/* ---- vi/sweep/lanes.c: several small problems at once ---------------------------------------- */

enum { dlsi_lanes = 8, dlsi_lane_candidates = 8 };

typedef struct dlsi_lane_work dlsi_lane_work;

/* Allocates the workspace, which free() takes back; NULL without memory. */
dlsi_lane_work *dlsi_lane_create(void);

/* Sweeps over up to dlsi_lanes checked problems with the same number of contacts, at most
 * dlsi_lane_candidates, from r = 0. Returns the number of sweeps. dlsi_lane_get copies the r of
 * problem k, d numbers per contact. That r has no certificate: measure it. */
int dlsi_lane_solve(dlsi_lane_work *work, int count, const dls_contact *problem, double tol);
void dlsi_lane_get(const dlsi_lane_work *work, int k, int d, double *r);

/* ---- vi/iterate.c: an iterate, its certificate, the best r so far ---------------------------- */

/* Returns 1 if the r with certificate a is a better answer than the r with certificate b. Only this
 * function decides that. The better r has the smaller max(residual_u, 4 floor_u, residual_r), so
 * that an r that has run away, whose residual is only rounding, does not win. If both are equal
 * (the force residual is 1 far from the answer), the smaller residual_u wins. No infinity or NaN is
 * better. */
int dlsi_is_better(const dls_certificate *a, const dls_certificate *b);

/* A certificate to begin with: worse than that of any r. */
static const dls_certificate dlsi_no_certificate = {
    .residual = INFINITY, .residual_u = INFINITY, .floor_u = INFINITY, .floor_r = INFINITY};

/* A W that several processes share; none holds all of it. Each runs the same iteration on the same
 * numbers. The problem's Wb has the d x d diagonal blocks of W. These functions do what takes all
 * of W; all processes call them together and get equal results. */
typedef struct dlsi_shared {
  void *data; /* first argument of each */
  /* u := W r + q, and, if a is not NULL, a := |W| |r|. m each. */
  void (*multiply)(void *data, const double *r, double *u, double *a);
  /* Prepares solves with A = W + rho diag(w), w for each contact. DLS_E_SINGULAR,
   * DLS_E_MEMORY. */
  dls_status (*factor)(void *data, double rho, const double *w, dls_error *error);
  /* x := A^-1 x, m. */
  void (*solve)(void *data, double *x);
} dlsi_shared;

/* The part of a workspace that all iterations on r need. Springs E_c >= 0 on all d rows of
 * contact c make the problem u = (W + diag(E)) r + q; the weights remain those of W. */
typedef struct dlsi_iterate {
  int d, nc;
  atomic_int busy;          /* 1: a public solve is at work in the workspace */
  const dls_limits *limits; /* of the workspace's settings */
  double tol;
  const dlsi_shared *shared;   /* where W is; NULL: in the problem */
  const double *E;             /* springs: nc, of the caller; NULL for 0 */
  double *w;                   /* unit of steps, a compliance per contact: nc */
  double *weights;             /* of the certificate: 2 nc */
  int rounded;                 /* certificates that held to rounding alone */
  double *u;                   /* W r + q of the r measured last: m */
  double *a;                   /* |W| |r| of that r: m */
  double *F;                   /* F of that r, also scratch: m */
  double *best;                /* best r so far: m */
  dls_certificate certificate; /* of best */
  double begun;                /* CPU seconds when the solve began; -1: not needed */
  int iterations;              /* of the last solve, with its sweeps */
} dlsi_iterate;

/* dlsi_carve_workspace for nc contacts. */
dls_status dlsi_workspace(void **out, void *filled, size_t size, dlsi_carve *carve, int nc,
                          dls_error *error);

/* Takes `count` arrays of n doubles. */
void dlsi_take_vectors(dlsi_arena *arena, size_t n, int count, double **const vector[]);

/* Takes the arrays of `it` for nc contacts and stores the limits of the workspace. */
void dlsi_iterate_carve(dlsi_iterate *it, dlsi_arena *arena, int d, int nc,
                        const dls_limits *limits);

/* Checks the arguments of a solve in the workspace of `it` (NULL: no workspace) and enters the
 * workspace, until dlsi_iterate_leave. Inline, so that readers and analysers see that `it` is not
 * NULL after DLS_OK. */
static inline dls_status dlsi_iterate_enter(dlsi_iterate *it, const dls_contact *problem,
                                            const double *r, const double *u, dls_error *error) {
  if (!it) return dlsi_is_null(error, "workspace");
  const dls_status status =
      dlsi_check_solve(it->d, it->nc, problem, r, u, it->limits->warm_start, error);
  return status ? status : dlsi_enter(&it->busy, "workspace", error);
}

/* Prepares a solve: weights, no best r yet, r := start if warm is 1 and q is not 0, else r := 0.
 * start: m, may be r. */
void dlsi_iterate_begin(dlsi_iterate *it, const dls_contact *problem, const double *E, double tol,
                        int warm, const double *start, double *r);

/* Returns the certificate of r; it->u := W r + q, it->a := |W| |r|, each with the springs. */
dls_certificate dlsi_iterate_measure(dlsi_iterate *it, const dls_contact *problem, const double *r);

/* Keeps r as the best one if its certificate `now` is better or holds. Returns 1 if it holds.
 * Counts certificates that hold to rounding only. */
int dlsi_iterate_keep(dlsi_iterate *it, const dls_contact *problem, const double *r,
                      const dls_certificate *now);

/* Measures r and keeps it: the two calls above. Returns the certificate of r. */
dls_certificate dlsi_iterate_offer(dlsi_iterate *it, const dls_contact *problem, const double *r);

/* Offers the start r of a solve. If W r overflows, or its rounding is larger than q (floor_u >= 1),
 * r becomes 0. Returns 1 if the certificate holds. */
int dlsi_iterate_start(dlsi_iterate *it, const dls_contact *problem, double *r);

/* Measures the best r again, because an estimate may have chosen it. Returns the verdict of its
 * certificate (dls_certificate_verdict) if it is one, else `reason`. */
dls_status dlsi_iterate_settle(dlsi_iterate *it, const dls_contact *problem, dls_status reason);

/* Stores the answer: r := the best one, u := W r + q with the springs (m, or NULL), *info :=
 * *outcome (or NULL) with status and certificate. Returns status, or DLS_TO_ROUNDING if the method
 * has ended by itself and the certificate holds to rounding. An error changes nothing. */
dls_status dlsi_iterate_end(dlsi_iterate *it, const dls_contact *problem, dls_status status,
                            dls_info *outcome, double *r, double *u, dls_info *info);

/* Returns 1 if an iteration has run away: it does not come back, and squares of r overflow, in some
 * units sooner than in others. */
static inline int dlsi_iterate_is_lost(double residual) {
  return !(residual <= 1e100);
}

/* Certificates that hold to rounding alone, after which no iteration improves the answer. */
enum { dlsi_rounded_patience = 5 };

/* Reports the residual of r (NULL: not known) to the progress callback and checks the time limit.
 * Returns DLS_OK to go on, DLS_CANCELLED, DLS_TIME_LIMIT, or DLS_TO_ROUNDING if
 * dlsi_rounded_patience certificates have held to rounding alone. */
static inline dls_status dlsi_iterate_tell(const dlsi_iterate *it, const char *method,
                                           int iteration, int max_iterations, double residual,
                                           const double *r) {
  const dls_status end = it->rounded >= dlsi_rounded_patience ? DLS_TO_ROUNDING : DLS_OK;
  if (!it->limits->progress && !(it->limits->cpu_seconds > 0)) return end;
  dls_progress progress = {method, method, iteration, max_iterations, residual, r, 0, 0};
  const dls_status stop = dlsi_tell(it->limits, it->begun, &progress);
  return stop ? stop : end;
}

/* Makes the last progress call of a solve with the answer r, unless `status` is an error. Leaves
 * the workspace. Returns status. */
static inline dls_status dlsi_iterate_leave(dlsi_iterate *it, const char *method, dls_status status,
                                            const double *r) {
  if (status >= 0)
    dlsi_tell_last(it->limits, it->begun, method, method, it->iterations, it->certificate.residual,
                   r);
  return dlsi_leave(&it->busy, status);
}

/* u := (W + diag(E)) r + q and, if a is not NULL, a := (|W| + diag(E)) |r|, as
 * dlsi_contact_multiply. E: nc, or NULL for 0. */
void dlsi_multiply(const dls_contact *problem, const int *order, const double *E, const double *r,
                   double *u, double *a);

/* ---- vi/sweep/order.c ------------------------------------------------------------------------ */

/* Returns 1 if W is dense, or full with more than 100 contacts: most contacts are coupled, as on
 * elastic bodies. */
int dlsi_is_elastic(const dls_contact *problem);

/* order (nc) := the contacts in an order that follows from the data, not from their numbers.
 * key: 3 arrays of nc doubles, scratch; scratch: nc. */
void dlsi_order_candidates(const dls_contact *problem, double *const key[3], int *scratch,
                           int *order);

/* ---- one method inside of another ------------------------------------------------------------ */

/* Solve as dls_nlgs_solve and dls_newton_solve do, for checked arguments, with springs E (nc, NULL
 * for 0). order: nc, the order of visits in a sweep; NULL: 0, 1, .. r is also the iterate that the
 * progress callback of sweeps gets. */
dls_status dlsi_nlgs_run(dls_nlgs *work, const dls_contact *problem, const int *order,
                         const double *E, double *r, double *u, dls_info *info);
dls_status dlsi_newton_run(dls_newton *work, const dls_contact *problem, const double *E, double *r,
                           double *u, dls_info *info, dls_error *error);

/* Creates with a room that outlives the workspace; NULL: a room of its own. */
dls_status dlsi_newton_create(dls_newton **out, int d, int nc, const dls_newton_settings *settings,
                              dlsi_room *room, dls_error *error);

/* ---- vi/split/admm.c ------------------------------------------------------------------------- */

/* Makes later solves in the workspace take W from `shared` (borrowed); NULL: from the problem. */
void dlsi_admm_share(dls_admm *work, const dlsi_shared *shared);

/* ---- vi/sweep/ambiguous.c -------------------------------------------------------------------- */

/* Returns 0 if no contact can have several solutions. */
int dlsi_may_be_ambiguous(const dls_contact *problem);

/* Returns the number of contacts that have several solutions if the others stay at r; u = W r + q.
 * other (m, or NULL) := r with the first solution of each of these contacts. */
int dlsi_count_ambiguous(const dls_contact *problem, const double *r, const double *u,
                         double *other);

/* ---- vi/exists.c ----------------------------------------------------------------------------- */

/* Returns 1 if W proves that there is a solution, for a positive semidefinite symmetric part; 0
 * proves nothing. w: weights of the certificate. J: scratch, m x m. v: scratch, m each. */
int dlsi_solution_exists(const dls_contact *problem, const double *w, double *J,
                         double *const v[4]);

/* Returns 1 if the symmetric part of W is positive semidefinite up to rounding. */
int dlsi_is_semidefinite(const dls_contact *problem, const double *w, double *J);

/* ---- vi/unique.c ----------------------------------------------------------------------------- */

/* Returns 1 if the problem has at most one answer, proved up to rounding; 0 proves nothing. w:
 * weights of the certificate. row: scratch, nc. J: without friction scratch, nc x nc, or NULL for
 * the inexpensive search; with friction NULL. */
int dlsi_is_unique(const dls_contact *problem, const double *w, double *row, double *J);

/* ---- rows of the table of methods ------------------------------------------------------------ */

extern const dlsi_method dlsi_nlgs_method, dlsi_newton_method, dlsi_admm_method;
extern const dlsi_method dlsi_augmented_method, dlsi_penalty_method;

/* Returns a direction delta (m, its largest entry +-1) along which the reactions of the last solve
 * grew without bound, or NULL:
 *
 *   |W delta| < 1e-4 |delta|   and   q.delta < -1e-4 |q| |delta|,
 *
 * in norms weighted by w_c: reactions along delta cause no displacement and gain work without
 * bound. Such a delta makes it likely that there is no solution. It is a proof only if W is
 * symmetric, W delta = 0, delta_n >= 0 and delta_t = 0: a self-stress of the normal reactions. NULL
 * after DLS_OK. It lives until the next solve or destroy. */
const double *dlsi_augmented_direction(const void *workspace);

#endif
