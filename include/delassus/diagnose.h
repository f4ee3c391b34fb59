/*
 * delassus/diagnose.h: facts about a contact problem: symmetry, rank and definiteness of W, degenerate
 * candidates, scales, and how large friction may be.
 *
 * All is measured on the scaled matrix D^-1/2 W D^-1/2, D = diag(w_c I_d) with the w_c of the
 * certificate, so that neither units nor the sizes of candidates matter. Facts, not verdicts: the
 * solvers take any W.
 */
#ifndef DELASSUS_DIAGNOSE_H
#define DELASSUS_DIAGNOSE_H

#include "delassus/contact.h"

#ifdef __cplusplus
extern "C" {
#endif

/* How many candidates (rows) are so, and the first of them, -1 if there is none. */
typedef struct dls_flaw {
  int count, first;
} dls_flaw;

/* Fields are only ever added at the end. */
typedef struct dls_diagnosis {
  /* scales */
  double weight_min, weight_max;     /* w_c, where trace(W_cc) > 0; 0 if nowhere  length/force */
  double q_norm;                     /* |q|_2                                     length */
  double friction_min, friction_max; /* mu_c                                      1 */
  int closing; /* candidates with q_n < 0; where none is, r = 0 is a solution */

  /* symmetry: largest |W_ij - W_ji| over the largest |W_ij|, both scaled, and where it is */
  double asymmetry; /* 1 */
  int row, col;     /* row < col; -1 if W is symmetric to the last bit */

  /* degenerate candidates; a zero block is not counted among the next three as well */
  dls_flaw zero_block;     /* W_cc = 0 */
  dls_flaw no_weight;      /* trace(W_cc) <= 0: the certificate takes the mean weight */
  dls_flaw no_normal;      /* W_nn <= 0: pushing does not open the contact */
  dls_flaw singular_block; /* W_cc singular to rounding */
  dls_flaw no_effect;      /* columns of W that are zero to rounding: r that no u depends on (index
                              into r) */

  /* eigenvalues of the symmetric part of the scaled matrix; m > limit: spectrum = 0, rank = negative
   * = -1, the others 0 */
  int spectrum;             /* 1: computed */
  int rank;                 /* those with |value| > noise * largest |value| */
  int negative;             /* those with value < -noise * largest |value| */
  double noise;             /* 4 m eps; where 0 > smallest >= -1e-5 largest, ten times that ratio if
                               larger: no flexibility matrix has negative eigenvalues, so that one of
                               this size tells how far the data were rounded */
  double largest, smallest; /* 1 */
  double smallest_positive; /* above the noise; 0 if none. largest / smallest_positive is the
                               condition number of W on its range */

  /* friction */
  double friction_critical; /* smallest W_nn / |W_nt| of a candidate, 0 where W_nn <= 0. Some
                               mu_c above its candidate's: there are q with several solutions. INFINITY:
                               no candidate couples n and t */
  int critical;             /* that candidate; -1: none */
  dls_flaw wedged;          /* candidates with mu_c > their W_nn / |W_nt| */
  double
      friction_unique; /* all mu_c below it: exactly one solution whatever q is; Lemke's method (2D)
                               finds it, fixed points on the sliding threshold converge with the factor
                               friction_max / friction_unique. Sufficient only, up to rounding; 0: no
                               bound is known (W is not positive definite, or m > limit). INFINITY: any
                               friction. Proof, and what it is worth: src/diagnose.c */
} dls_diagnosis;

/* *diagnosis := the facts. limit >= 0: up to m = limit the eigenvalues and friction_unique are
 * computed, with 3 m^2 + O(m) doubles and O(m^3) operations (m = 1710: 6 s on one thread); the rest is O(size
 * of W). DLS_OK, DLS_E_ARGUMENT, DLS_E_MEMORY, or an error of dls_contact_check. */
DLS_API DLS_MUST_USE dls_status dls_contact_diagnose(const dls_contact *problem, int limit,
                                                     dls_diagnosis *diagnosis, dls_error *error);

#ifdef __cplusplus
}
#endif

#endif
