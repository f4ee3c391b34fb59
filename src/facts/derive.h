/* derive.h: what the files of derivatives share: derive.c has the formulas. */
#ifndef DLSI_DERIVE_H
#define DLSI_DERIVE_H

#include "delassus/derive.h"
#include "linear/general.h"
#include "reduction/reduced.h"
#include "vi/newton/states_matrix.h"

struct dls_derive {
  atomic_int busy;
  int n, rows;           /* unknowns of K, 0 on W; of the states */
  dls_contact problem;   /* of a body: only d, nc and mu */
  dlsi_formed formed;    /* of W of rigid bodies */
  dlsi_states_matrix *A; /* on W, ... */
  dlsi_general M;        /* ... or on K, (DB1), ... */
  dlsi_reduced body;     /* ... of this body; body.H = NULL on W */
  int fixed, *redundant; /* multipliers of redundant joints, 0 as in the reduction */
  dls_contact_state *state;
  dlsi_branch *branch; /* nc */
  double *w, *t;       /* 2 nc: weights; t of (DR1), 0 where there is none */
  double *r, *u;       /* m: the answer */
  double *x;           /* n */
  double *a, *b, *c;   /* m: scratch */
  double *z;           /* n + m: right sides and solutions, K first */
  double *row, *col;   /* n + m: R and C of (DR7) */
  double *motion;      /* on W of rigid bodies: motions of all bodies, twice */
};

/* ---- derive_states.c ------------------------------------------------------------------------- */

/* Makes an empty object for a problem, with n unknowns of K: only problem is set. *out = NULL on
 * error: DLS_E_MEMORY. */
dls_status dlsi_derive_new(dls_derive **out, const dls_contact *problem, int n, dls_error *error);

/* Sets states, branches and t from r, u and w. DLS_E_NO_DERIVATIVE, DLS_E_ARGUMENT (r, side). */
dls_status dlsi_derive_choose(dls_derive *work, int side, double residual, dls_error *error);

/* z := A^-1 z or M^-1 z, or transposed. DLS_E_MEMORY. */
dls_status dlsi_derive_solve(dls_derive *work, int transposed, dls_error *error);

/* (DR7) after a factorisation that ended with `status`. DLS_E_NO_DERIVATIVE. */
dls_status dlsi_derive_judge(dls_derive *work, dls_status status, dls_error *error);

/* ---- derive_body.c --------------------------------------------------------------------------- */

/* x (n) += H r;  y (m) += H^T x */
void dlsi_derive_push(const dls_derive *work, const double *r, double *x);
void dlsi_derive_look(const dls_derive *work, const double *x, double *y);

/* contacts (m) := P^T nodes or, back = 1, nodes := P contacts, without the omitted tangents. */
void dlsi_derive_gaps(const dls_derive *work, int back, double *nodes, double *contacts);

/* Returns the number of stored values of K. */
size_t dlsi_derive_values(const dls_model *K);

/* (DB4) value := the gradient of the stored values of K;  y (n) := dK x */
void dlsi_derive_stored(const dls_derive *work, const double *b, double *value);
void dlsi_derive_apply(const dls_derive *work, const double *dK, double *y);

#endif
