/* border.h: a Newton step with the factors of other states, if few contacts have changed. */
#ifndef DLSI_BORDER_H
#define DLSI_BORDER_H

#include "contact/contact.h"
#include "linear/dense.h"
#include "states_matrix.h"

typedef struct dlsi_border {
  int loose; /* for branch_serves; set before dlsi_border_add */
  int d, nc;
  int n;       /* side of the factored matrix */
  int k, most; /* added unknowns, of the changed contacts; most: room */
  int held;    /* unknowns for which S is factored */
  /* in the room that the matrix leaves; most = 0: no room for any change */
  dlsi_branch *base;  /* nc: states of the factored matrix */
  dlsi_branch *frame; /* most: by slot, the slip of FRAMED */
  dlsi_branch *now;   /* most: by slot, states for which S is factored */
  int *slot;          /* nc: first added unknown, -1: contact has not changed */
  int *of;            /* most: contact of each added unknown, -1: dropped */
  int *form;          /* most: by slot, border_form */
  double *X, *V;      /* (BO3), (BO4): n x most */
  double *Q, *T, *S;  /* (BO3), (BO4), (BO5): most x most */
  double *z;          /* d nc */
  double *v, *y;      /* most */
  int *pivot;         /* most */
} dlsi_border;

/* Notes that a matrix of side n has been factored for these states. spare: room for later changes
 * of states, size doubles, kept until the next call. b->most = 0: there is none, and the caller
 * must not change a state. */
void dlsi_border_begin(dlsi_border *b, int d, int nc, const dlsi_branch *branch, int n,
                       double *spare, size_t size);

/* Adds the contacts that have changed since. W dense. Returns 0 and adds nothing if they are too
 * many, or one has gained friction. */
int dlsi_border_add(dlsi_border *b, const dls_contact *problem, const dlsi_dense *factors,
                    const dlsi_branch *branch);

/* x := the solution of (NE2) for these states with right side x. w, E: nc; E may be NULL. Returns 0
 * and keeps x if the matrix is singular. */
int dlsi_border_solve(dlsi_border *b, const dlsi_dense *factors, const dlsi_branch *branch,
                      const double *w, const double *E, double eps, double *x);

#endif
