/* border.h: a Newton step with the factors of other states: few candidates have changed theirs. */
#ifndef DLSI_BORDER_H
#define DLSI_BORDER_H

#include "base/base.h"
#include "linear/dense.h"
#include "states_matrix.h"

/* Returns 1 if factors for a serve for b. loose: of two slips, d = 3, the directions may differ by
 * some degrees, and l may: the solution is then inexact. */
int dlsi_branch_serves(const dlsi_branch *a, const dlsi_branch *b, int loose);

typedef struct dlsi_border {
  int loose; /* of dlsi_branch_serves; the caller's, before it adds */
  int d, nc;
  int n;       /* side of the factored matrix */
  int k, most; /* unknowns more, of the candidates that have changed; most: room */
  int held;    /* S is factored for so many of them */
  /* in what the matrix leaves of its room; without room for any change most is 0 */
  dlsi_branch *base;  /* nc: states of the factored matrix */
  dlsi_branch *frame; /* most: by slot, the slip of FRAMED */
  dlsi_branch *now;   /* most: by slot, states for which S is factored */
  int *slot;          /* nc: first unknown more, -1: the candidate has not changed */
  int *of;            /* most: candidate of each unknown more, -1: given up */
  int *form;          /* most: by slot, border_form */
  double *X, *V;      /* (BO3), (BO4): n x most */
  double *Q, *T, *S;  /* (BO3), (BO4), (BO5): most x most */
  double *z;          /* d nc */
  double *v, *y;      /* most */
  int *pivot;         /* most */
} dlsi_border;

/* Notes that a matrix of side n has been factored for these states. spare: room for what comes with
 * the changes of states, size doubles, kept until the next call; b->most = 0: it has none, and the
 * caller sees to it that no state changes. */
void dlsi_border_begin(dlsi_border *b, int d, int nc, const dlsi_branch *branch, int n,
                       double *spare, size_t size);

/* Adds the candidates that have changed to those that are there. W dense. Returns 0 if they are
 * too many, or have got friction: nothing is added then. */
int dlsi_border_add(dlsi_border *b, const dls_contact *problem, const dlsi_dense *factors,
                    const dlsi_branch *branch);

/* x := the solution of (NE2) for these states with right side x. w, E: nc; E may be NULL.
 * Returns 0 if the matrix is singular; x stays then. */
int dlsi_border_solve(dlsi_border *b, const dlsi_dense *factors, const dlsi_branch *branch,
                      const double *w, const double *E, double eps, double *x);

#endif
