/* vi_internal.h: what the files of vi/ share, and what the front door asks of them. */
#ifndef VI_INTERNAL_H
#define VI_INTERNAL_H

#include <math.h>

#include "base/base.h"
#include "delassus/admm.h"
#include "delassus/augmented.h"
#include "delassus/newton.h"
#include "delassus/nlgs.h"
#include "linear/room.h"

/* A candidate's own block W_cc (d x d, column-major) and what does not hang on q in its solution:
 * local.c has the formulas. */
typedef struct dlsi_block_2d {
  double W[4], mu;
  double f, inv_pivot, inv_s; /* stick: elimination, */
  double inv_slip[2];         /* slip: 1 / (W_nn -+ mu W_nt) */
  int p;                      /* ... by row p */
} dlsi_block_2d;

typedef struct dlsi_block_3d {
  double W[9], mu;
  double inv_a, c[2];        /* (L2): 1 / W_nn, the column below times it, */
  double S[4], det, trace;   /* Schur's complement, */
  double f, u01, inv0, inv1; /* its LU factors, rows pivoted, */
  double scale;              /* and a size for l */
  int p;
} dlsi_block_3d;

void dlsi_block_2d_set(dlsi_block_2d *block, const double *W, double mu);
void dlsi_block_3d_set(dlsi_block_3d *block, const double *W, double mu);

/* dls_nlgs_local without the count, for the sweep. guess (3D): where to look first for l >= 0 in
 * u_t = -l r_t, such as |u_t| / |r_t| before; 0 for none. */
dls_local_state dlsi_local_2d(const dlsi_block_2d *block, const double *q, double *r);
dls_local_state dlsi_local_3d(const dlsi_block_3d *block, const double *q, double guess, double *r);

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

/* Fills *frames (to be freed also after an error) from a model that has passed dlsi_check_model. */
dls_status dlsi_frames_create(dlsi_frames *frames, const dls_model *model, dls_error *error);
void dlsi_frames_free(dlsi_frames *frames);

/* f' := T^T f, and x := T x', also in place. */
void dlsi_frames_forces(const dlsi_frames *frames, const double *f, double *local);
void dlsi_frames_unknowns(const dlsi_frames *frames, const double *local, double *x);
/* x' := T^-1 x: u - g at the contact nodes, also in place. */
void dlsi_frames_positions(const dlsi_frames *frames, const double *x, double *local);

/* The history of a fixed-point iteration under Anderson acceleration (anderson.c). */
typedef struct dlsi_anderson {
  int window;
  int started;          /* f, g, u are there */
  int columns, newest;  /* of DF, DG, DU, in a ring */
  double *DF, *DG, *DU; /* m window; DU and u may be NULL: no u */
  double *f, *g, *u;    /* m  of the last step taken */
  double *gram, *L;     /* window^2 */
  double *work;         /* 3 window; from 2 window on: DF^T f */
} dlsi_anderson;

void dlsi_anderson_carve(dlsi_anderson *a, dlsi_arena *arena, size_t m, int window, int with_u);
void dlsi_anderson_clear(dlsi_anderson *a);

/* Takes g = g(x), the weighted residual f = D (g - x) and u = u(g), m each, in; g and u become the
 * next x and u(x); u is NULL for a history carved without. 0 if the history does not say anything
 * yet: they stay. m: the same since clear. */
int dlsi_anderson_step(dlsi_anderson *a, int m, const double *f, double *g, double *u);

/* ---- with springs: u = (W + diag(E)) r + q, E_c >= 0 for all d rows of candidate c ----------- */

/* u := (W + diag(E)) r + q and, if a is not NULL, a := (|W| + diag(E)) |r|, as dlsi_contact_multiply. E: nc, or
 * NULL for 0. */
static inline void dlsi_multiply(const dls_contact *problem, const int *order, const double *E,
                                 const double *r, double *u, double *a) {
  const size_t d = (size_t)problem->d, m = d * (size_t)problem->nc;
  dlsi_contact_multiply(problem, order, r, u, a);
  for (size_t k = 0; E && k < m; k++) {
    u[k] += E[k / d] * r[k];
    if (a) a[k] += E[k / d] * fabs(r[k]);
  }
}

/* what a run has done */
typedef struct dlsi_newton_count {
  int sweeps, steps, factorisations;
} dlsi_newton_count;

/* dls_newton_solve as dlsi_nlgs_run (dlsi.h), on behalf of `function`. */
dls_status dlsi_newton_run(dls_newton *work, const dls_contact *problem, const double *E,
                           double tol, double *r, double *u, dls_certificate *certificate,
                           dlsi_newton_count *count, dls_error *error);

/* ---- vi/nlgs.c --------------------------------------------------------------------------------- */

/* What sweeps can do for other methods; all zero: those of dls_nlgs_solve. */
typedef struct dlsi_sweeps {
  const int *order; /* nc: in which they visit the candidates; NULL: 0, 1, .. */
  const double *E;  /* nc: springs on the diagonal of W; not in the certificate's weights */
  int plain;        /* so many before an acceleration begins */
} dlsi_sweeps;

/* dls_nlgs_solve of what has been checked already. r as there, and the iterate while the progress callback is
 * called; u (m or NULL), its certificate, the sweeps done. */
dls_status dlsi_nlgs_run(dls_nlgs *work, const dls_contact *problem, dlsi_sweeps sweeps, double tol,
                         double *r, double *u, dls_certificate *certificate, int *iterations);

/* The creates on behalf of `function`, with a room that outlives the workspace; NULL: one of its own. */
dls_status dlsi_newton_create(dls_newton **out, int d, int nc, const dls_newton_settings *settings,
                              dlsi_room *room, dls_error *error);
dls_status dlsi_admm_create(dls_admm **out, int d, int nc, const dls_admm_settings *settings,
                            dlsi_room *room, dls_error *error);
dls_status dlsi_augmented_create(dls_augmented **out, int d, int nc,
                                 const dls_augmented_settings *settings, dlsi_room *room,
                                 dls_error *error);

/* The solves of what has been checked already. */
dls_status dlsi_newton_solve(dls_newton *work, const dls_contact *problem, double *r, double *u,
                             dls_info *info, dls_error *error);
dls_status dlsi_admm_solve(dls_admm *work, const dls_contact *problem, double *r, double *u,
                           dls_info *info, dls_error *error);
dls_status dlsi_augmented_solve(dls_augmented *work, const dls_contact *problem, double *r,
                                double *u, dls_info *info, dls_error *error);

#endif
