/* derive.h: what the files of derivatives share: derive.c has the formulas. */
#ifndef DLSI_DERIVE_H
#define DLSI_DERIVE_H

#include "delassus/derive.h"
#include "linear/general.h"
#include "reduction/reduced.h"
#include "vi/states_matrix.h"

struct dls_derive {
  atomic_int busy;
  int n, rows;           /* unknowns of K, 0 on W; of the states */
  dls_contact problem;   /* of a body: d, nc and mu alone */
  dlsi_formed formed;    /* of W of rigid bodies */
  dlsi_states_matrix *A; /* on W, ... */
  dlsi_general M;        /* ... or on K, (DB1), ... */
  dlsi_reduced body;     /* ... of this body; body.H = NULL on W */
  dls_contact_state *state;
  dlsi_branch *branch; /* nc */
  double *w, *t;       /* 2 nc: weights; t of (DR1), 0 where there is none */
  double *r, *u;       /* m: the answer */
  double *x;           /* n */
  double *a, *b, *c;   /* m: scratch */
  double *z;           /* n + m: right sides and solutions, of K first */
  double *row, *col;   /* n + m: R and C of (DR7) */
  double *motion;      /* on W of rigid bodies: motions of all bodies, twice */
  double *memory;
};

/* Makes an empty object for a problem, with n unknowns of K: only problem is set. *out = NULL on
 * error: DLS_E_MEMORY. */
dls_status dlsi_derive_new(dls_derive **out, const dls_contact *problem, int n, dls_error *error);

/* Sets states, branches and t from r, u and w. DLS_E_NO_DERIVATIVE, DLS_E_ARGUMENT (r, side). */
dls_status dlsi_derive_choose(dls_derive *work, int side, double residual, dls_error *error);

/* Solves in z with A or M. DLS_E_MEMORY. */
dls_status dlsi_derive_solve(dls_derive *work, int transposed, dls_error *error);

/* (DR7) after a factorisation that ended with `status`. DLS_E_NO_DERIVATIVE. */
dls_status dlsi_derive_judge(dls_derive *work, dls_status status, dls_error *error);

/* s (m) := s of (DR1); dmu NULL: 0. */
void dlsi_derive_slip(const dls_derive *work, const double *dmu, double *s);

/* mu (nc) := r_n t . v. */
void dlsi_derive_friction(const dls_derive *work, const double *v, double *mu);

/* An array of a caller, NULL or `size` finite numbers. */
typedef struct dlsi_given {
  const char *name;
  const double *x;
  size_t size;
} dlsi_given;

/* Begins a call on an object of W or of a body; dlsi_leave ends it. DLS_E_ARGUMENT,
 * DLS_E_NOT_FINITE, DLS_E_BUSY. */
dls_status dlsi_derive_enter(dls_derive *work, int of_body, int count, const dlsi_given *given,
                             dls_error *error);

#endif
