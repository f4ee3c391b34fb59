/*
 * delassus/diagnose.h: facts about a contact problem: symmetry, rank and definiteness of W,
 * degenerate candidates, scales, and how large friction may be.
 *
 * All is measured on the scaled matrix D^-1/2 W D^-1/2, D = diag(w_c I_d) with the w_c of the
 * certificate, so that the facts depend neither on units nor on the sizes of the contacts. They are
 * facts, not verdicts: the solvers accept each W.
 */
#ifndef DELASSUS_DIAGNOSE_H
#define DELASSUS_DIAGNOSE_H

#include "delassus/contact.h"

#ifdef __cplusplus
extern "C" {
#endif

/* Number of contacts (or columns) with a flaw, and the index of the first, -1 for none. */
typedef struct dls_flaw {
  int count, first;
} dls_flaw;

/* Possible mistakes in a problem. A correct problem may show them, too. */
enum {
  DLS_HINT_OUTWARD = 1,   /* each q_n > 0: nothing presses. If bodies should be pressed together,
                             H_N has the wrong sign */
  DLS_HINT_TRANSPOSED = 2 /* W is unsymmetric, and sweeps solve the problem with W^T but not with
                             W: rows may have been given as columns */
};

typedef struct dls_diagnosis {
  /* Scales, in the user's units: w_c = trace(W_cc) / d where positive (0 if nowhere), |q|, mu_c. */
  double weight_min, weight_max; /* length (velocity) / force */
  double q_norm;                 /* length (velocity) */
  double friction_min, friction_max;
  int closing; /* candidates with q_n < 0; if there is none, r = 0 is a solution */

  /* Largest |W_ij - W_ji| over the largest |W_ij|, scaled, and where it is: row < col, -1 if W is
   * symmetric to the last bit. */
  double asymmetry;
  int row, col;

  /* Degenerate candidates. One with W_cc = 0 is not counted in the three that follow. */
  dls_flaw zero_block;     /* W_cc = 0 */
  dls_flaw no_weight;      /* trace(W_cc) <= 0: the certificate takes the mean weight */
  dls_flaw no_normal;      /* W_nn <= 0: pushing does not open the contact */
  dls_flaw singular_block; /* W_cc singular to rounding */
  dls_flaw no_effect; /* columns of W (index into r) that are 0 to rounding: no u depends on r_i */

  /* Eigenvalues of the symmetric part of the scaled matrix. m > limit: spectrum = 0, rank = -1,
   * negative = -1, the others 0. noise is 4 m eps. A flexibility matrix has no negative
   * eigenvalues: 0 > smallest >= -1e-5 largest shows that the data were rounded (text files), and
   * noise is then max(4 m eps, 10 |smallest| / largest). */
  int spectrum;             /* 1: computed */
  int rank;                 /* number of |value| > noise * the largest |value| */
  int negative;             /* number of values < -noise * the largest |value| */
  double noise;             /* 1 */
  double largest, smallest; /* 1 */
  double smallest_positive; /* above the noise, 0 if none; largest / smallest_positive is the
                               condition number of W on its range */

  /* Friction. Some mu_c > W_nn / |W_nt| of its own candidate (0 where W_nn <= 0): there are q with
   * several solutions. friction_critical is the smallest of these numbers, INFINITY if no candidate
   * couples n and t, critical its candidate (-1); wedged: candidates with mu_c above their own.
   *
   * All mu_c < friction_unique: exactly one solution for each q. Lemke's method (2D) finds it, and
   * the fixed point on the sliding threshold converges with the factor friction_max /
   * friction_unique. The condition is sufficient only, and up to rounding; Gauss-Seidel and Newton
   * can still cycle. INFINITY: any friction; 0: no bound is known, because W is not positive
   * definite or m > limit. */
  double friction_critical;
  int critical;
  dls_flaw wedged;
  double friction_unique;

  int hints; /* sum of DLS_HINT_OUTWARD, DLS_HINT_TRANSPOSED (m <= limit) */
} dls_diagnosis;

/* Computes the facts of a problem. The eigenvalues and friction_unique are computed up to m = limit
 * >= 0, with 3 m^2 + O(m) doubles and O(m^3) operations (m = 2000: 1.8 s on one thread); the rest
 * is O(size of W). DLS_OK, DLS_E_ARGUMENT, DLS_E_MEMORY, or an error of dls_contact_check. */
DLS_API DLS_MUST_USE dls_status dls_contact_diagnose(const dls_contact *problem, int limit,
                                                     dls_diagnosis *diagnosis, dls_error *error);

#ifdef __cplusplus
}
#endif

#endif
