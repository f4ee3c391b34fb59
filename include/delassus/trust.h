/*
 * delassus/trust.h: how far you can trust the answer to a contact problem: all solutions of a small
 * problem, the friction above which some loads have several solutions, the error that a residual
 * leaves in the reactions, and a proof of an answer.
 */
#ifndef DELASSUS_TRUST_H
#define DELASSUS_TRUST_H

#include "delassus/contact.h"

#ifdef __cplusplus
extern "C" {
#endif

/* ---- all solutions --------------------------------------------------------------------------- */

/* Candidates of the largest problem that dls_contact_enumerate takes. */
enum { DLS_STATES_MAX = 8 };

typedef struct dls_solution_set {
  int isolated; /* solutions with no other one near */
  int continua; /* connected sets of more than one solution */
  int states;   /* choices of a state (free, stick, slip to the left, to the right) for every
                   candidate that hold a solution: several hold one on the border between them */
} dls_solution_set;

/* Finds all solutions of a problem with d = 2 and up to DLS_STATES_MAX candidates: with the states
 * chosen, the laws are linear, and their solutions a polyhedron.
 *
 *   r (m x capacity, column-major): the isolated solutions, then a vertex of each continuum
 *   low, high (as r, or both NULL): the smallest and largest value of each entry in the connected
 *   set that holds it, -INFINITY and INFINITY if there is none; isolated solutions: r twice
 *
 * A continuum is one of reactions: the position that a free candidate leaves to a multiplier of
 * some LCP does not make one. Each solution listed has a certificate that holds for tol. Two that
 * differ by less than 1e-8 of the largest entry, in scaled units, are one.
 *
 * DLS_OK: all are listed, up to 1e-10 of the scaled data. DLS_NO_SOLUTION: none, and each choice of
 * states is refuted by a vector that holds exactly for the numbers of W, q and mu, or Lemke's
 * method has a proof. DLS_NO_SOLUTION_LIKELY: none, up to rounding. DLS_MAX_ITERATIONS: there are
 * more than `capacity`, and the first of them are in the list. DLS_STALLED: rounding keeps a choice
 * of states from being decided; the list holds the others. Else an error:
 * DLS_E_UNSUPPORTED for d = 3 or an infinite mu, DLS_E_SIZE for more candidates, DLS_E_ARGUMENT,
 * DLS_E_MEMORY. Solves 4^nc small linear programs. */
DLS_API DLS_MUST_USE dls_status dls_contact_enumerate(const dls_contact *problem, double tol,
                                                      int capacity, double *r, double *low,
                                                      double *high, dls_solution_set *found,
                                                      dls_error *error);

/* ---- what a residual means ------------------------------------------------------------------- */

typedef struct dls_sensitivity {
  int rows; /* equations of the candidates that carry a reaction: d where one sticks, d - 1 where it
               slips, 1 without friction */
  int rank; /* of their matrix A, scaled, to rounding */
  int border;   /* candidates on the border of two states, where A holds on one side */
  int isolated; /* 1: no other answer near; 0: others near, the reactions are not determined; -1:
                   not known, border > 0 */
  double amplification;   /* |A^-1| |q| / |r|: relative error of r per residual_u; INFINITY where
                             rank < rows */
  double amplification_r; /* |A^-1 diag(w)|: the same per residual_r */
  double error; /* the relative error of r, |r - r*| / |r|, that its certificate leaves: the smaller
                   of both products, with each residual at least its floor */
} dls_sensitivity;

/* Estimates the error of r (m), the answer of a solver, from its residual. In the states of r the
 * laws are linear, and |A^-1| follows from singular values. The estimate is right to first order if
 * r has the states of the solution. O(rows^3) operations, rows^2 doubles + O(m). DLS_OK,
 * DLS_E_ARGUMENT, DLS_E_SIZE, DLS_E_NOT_FINITE, DLS_E_MEMORY. */
DLS_API DLS_MUST_USE dls_status dls_contact_sensitivity(const dls_contact *problem, const double *r,
                                                        dls_sensitivity *sensitivity,
                                                        dls_error *error);

/* Counts the self-stresses of an answer r (m): *freedom := the dimension of the reactions with the
 * positions of r. 0: r is determined. Greater: the positions determine the sum of the reactions on
 * each body, not single reactions, and a solver returns one of many (dls_solver_settings.forces).
 * Other positions may be answers, too, with other sums (info.unique), as of a block that jams or
 * falls. The count is rows - rank of the matrix A above, in the states of r; contacts that touch to
 * 1e-6 of the largest position count as sticking, with or without a reaction. O(rows^3) operations,
 * rows^2 doubles + O(m). Errors of dls_contact_sensitivity. */
DLS_API DLS_MUST_USE dls_status dls_contact_freedom(const dls_contact *problem, const double *r,
                                                    int *freedom, dls_error *error);

/* ---- a proof --------------------------------------------------------------------------------- */

typedef enum dls_proof_kind {
  DLS_NOT_PROVED = 0,
  DLS_PROVED = 1,          /* one solution, and no other one in the box */
  DLS_PROVED_POSITIONS = 2 /* r is not determined (freedom > 0): u is proved, for a q that
                              differs from the problem's by `perturbed` at most */
} dls_proof_kind;

typedef struct dls_proof {
  dls_proof_kind kind;
  double radius;    /* |r* - improved| / |improved|: relative bound on the error of forces */
  double radius_u;  /* max |u* - u| / max(|u|, |q|): the same for positions */
  double error;     /* |r* - r| / |r|: of the r that was given */
  double box;       /* the box: w |r - improved| <= box in each entry of r, w the mean of the
                       contact's diagonal of W, where it is not positive that of the others
                       length (velocity) */
  double perturbed; /* DLS_PROVED_POSITIONS: bound on the change of q over the largest |q| */
  int rows;         /* unknowns of the states of r, ... */
  int freedom;      /* ... and how many of them no equation determines: self-stresses */
  int border;       /* contacts that are, up to rounding, on the border of two states; the first
                       of them (-1: none) and its states: */
  int contact;
  dls_contact_state state, other;
} dls_proof;

/* Proves that the problem, exactly as its numbers stand, has one solution r* near r and no other
 * one in a box around it, and bounds the distance of r* from r: Krawczyk's test in the states of r,
 * in floating point with bounds on its own rounding. It improves r by Newton steps first; box and
 * radii belong to the improved r.
 *
 *   r         m, an answer with a certificate (any finite r is safe)
 *   improved  m, or NULL; may be r: receives the improved r if there is a proof, else r
 *
 * DLS_NOT_PROVED with border > 0 names a contact. With border = 0, A is too ill-conditioned or r is
 * no solution. The bounds hold for a BLAS that multiplies matrices in the usual way, for rounding
 * to nearest, and without underflow. 2 rows^3 operations, 2 rows^2 doubles + O(m). DLS_OK,
 * DLS_E_ARGUMENT, DLS_E_SIZE, DLS_E_NOT_FINITE, DLS_E_MEMORY. */
DLS_API DLS_MUST_USE dls_status dls_contact_prove(const dls_contact *problem, const double *r,
                                                  dls_proof *proof, double *improved,
                                                  dls_error *error);

/* ---- the fold -------------------------------------------------------------------------------- */

typedef struct dls_fold {
  double friction; /* the largest coefficient at the fold; INFINITY if there is none */
  double unique;   /* each q has exactly one solution below: proved up to rounding. friction where
                      that is exact, else friction_unique of diagnose.h, <= friction */
  int exact;       /* 1: of all states; 0: of those that the search tried: the fold lies in
                      [unique, friction] */
  int matrices;    /* number of matrices tried */
} dls_fold;

/* Finds the least friction at which the matrix of some slip, stick and free contacts,
 *
 *   u_n = 0, u_t = 0 where they stick,  u_n = 0, r_t = mu e r_n where they slip,  r = 0 elsewhere,
 *
 * becomes singular (Hassani, Hild and Ionescu's eigenvalue problem), for W positive definite. e:
 * the direction of slip, +-1 for d = 2, a unit vector for d = 3. Below it each q has exactly one
 * solution; above it some q have several. All mu_c are scaled together; if all are 0, they are
 * taken as equal. Exact for d = 2 up to DLS_STATES_MAX contacts; else a local search from many
 * starts over states and directions.
 *
 *   state (nc): the states, slip to the side that r_t tells
 *   q, r, other (m each): a witness: with the coefficients mu_c fold->friction / max mu, the load q
 *   has the solutions r and other; d = 2: both in these states; d = 3: r_c or other_c is 0 where a
 *   contact slips in a fixed direction, and friction is 1e-6 above that of the singular matrix
 *
 * Each may be NULL; they are set where there is a fold. DLS_OK; DLS_E_UNSUPPORTED for d = 1 or an
 * infinite mu; DLS_E_NOT_POSITIVE_DEFINITE; DLS_E_ARGUMENT, DLS_E_MEMORY, or an error of
 * dls_contact_check. */
DLS_API DLS_MUST_USE dls_status dls_contact_fold(const dls_contact *problem, dls_fold *fold,
                                                 dls_contact_state *state, double *q, double *r,
                                                 double *other, dls_error *error);

#ifdef __cplusplus
}
#endif

#endif
