/* prove.h: what the files of a proof share. prove.c has the formulas. */
#ifndef DLSI_PROVE_H
#define DLSI_PROVE_H

#include "facts/facts.h"
#include "linear/room.h"
#include "vi/newton/states_matrix.h"

typedef struct dlsi_prove {
  const dls_contact *problem;
  int n, all;              /* unknowns in use; with those of (PR7) that keep their values */
  double up;               /* 1 + the relative rounding of a sum of positive numbers */
  double *w, *weights, *s; /* nc: the unit of y; 2 nc: of the certificate; nc: 1 / w */
  double *r, *given;
  double *b;                      /* nc */
  double *u, *a, *du, *turned;    /* m; u in double; |W| |r| + |q|; error of u; rounding of r */
  double *h, *extra, *Wh, *We;    /* m: |E| s, |E' - E| s, and |W| times them */
  double *F, *B, *g, *z, *v, *v2; /* m each: of n unknowns */
  long double *sum;               /* m */
  dls_contact_state *state;       /* nc */
  dlsi_branch *branch;            /* nc */
  int *row, *pivot, *keep;        /* m */
  dlsi_room J, Z;
} dlsi_prove;

/* (PR1) r := the point with r_n and b; turned := the rounding of its r_t. */
void dlsi_prove_put(dlsi_prove *work);

/* (PR6) u, du */
void dlsi_prove_positions(dlsi_prove *work);

/* (PR2) F := the laws, v := |F| with the error of u; both of the n unknowns in use. */
void dlsi_prove_laws(dlsi_prove *work);

/* (PR3) B, and h, extra, Wh, We of this box. Returns 0 if B is not known. z: scratch. */
int dlsi_prove_slopes(dlsi_prove *work, double delta);

/* Counts the contacts whose inequalities fail somewhere in the box of the last slopes; records the
 * first. h, Wh: lost. */
void dlsi_prove_states(dlsi_prove *work, double delta, dls_proof *proof);

/* Fills the radii from v, bounds on |y* - y|; radius_u from all of the box. After the states. */
void dlsi_prove_radii(dlsi_prove *work, double delta, dls_proof *proof);

/* Returns the residual of the equations that do not count, over the largest |q| (PR7). After the
 * slopes. */
double dlsi_prove_lack(dlsi_prove *work, double delta);

#endif
