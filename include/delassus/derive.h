/*
 * delassus/derive.h: derivatives of an answer with respect to the data, of any loss or in any
 * direction.
 *
 *   u = W r + q and the laws of contact.h           data W, q, mu;       answer r, u
 *   K x = f + H r, u = H^T x + g and these laws     data K, f, g, mu;    answer r, u, x
 *
 * Where no contact is on the border of two states and the reactions are determined, a solution r
 * is a smooth function of the data. One factorisation, in create, gives all derivatives. They are
 * exact up to rounding for an exact r, and as accurate as r otherwise: dls_contact_prove improves
 * an r to rounding. The formulas: src/facts/derive.c.
 *
 * Create refuses an r without a derivative: DLS_E_NO_DERIVATIVE,
 *
 *   argument "contact", index c   contact c is on the border of two states, which the message
 *                                 names: its distance from the other one is at most 1e-6 of the
 *                                 largest entry of (w r, u), or 10 times what r lacks
 *   argument "r"                  the reactions are not determined (self-stresses)
 *
 * On a border the answer has one derivative for each of the two states. With side = 0 or 1 create
 * takes one of them: 0 the higher state of dls_contact_state (stick rather than slip, closed rather
 * than free), 1 the lower one, for all contacts on a border. side = -1: refuse.
 *
 * The friction of a contact that sticks, is free, has mu = INFINITY, or has mu = 0 and does not
 * move along its tangents does not matter: its derivative is 0. For mu_c = 0 and u_t not 0 the
 * derivative is the one to the right.
 */
#ifndef DELASSUS_DERIVE_H
#define DELASSUS_DERIVE_H

#include "delassus/reduction.h"

#ifdef __cplusplus
extern "C" {
#endif

/* The data, m = d nc: a gradient dL/ddata, or a change of the data. Fields of the other kind of
 * object have to be NULL. */
typedef struct dls_derive_data {
  double *mu; /* contacts */
  double *q;  /* on W: m; as a gradient a, dL/dW = a r^T                     length (velocity) */
  double *W;  /* on W: each stored value: as W.a (W.ld m; beyond m rows nothing is written), Wb.x,
                 or bodies.H (0 of a fixed body) */
  double *f;  /* on K: n; as a gradient b, dL/dK = -b x^T                    force (impulse) */
  double *g;  /* on K: d * nodes, as dls_reduction_load takes g              length (velocity) */
  double *K;  /* on K: each stored value: n x n without gaps, or as Ks.x. Of a symmetric K
                 (DLS_CHOLESKY, DLS_LDLT) a value below the diagonal stands for two places, and one
                 above it, which is not read, has the gradient 0 */
} dls_derive_data;

/* The answer: a gradient dL/danswer of a loss L, or the change of the answer. */
typedef struct dls_derive_answer {
  double *r; /* m                                                            force (impulse) */
  double *u; /* m                                                            length (velocity) */
  double *x; /* on K: n                                                      length (velocity) */
} dls_derive_answer;

/* The derivatives at one answer. One call at a time on an object (DLS_E_BUSY). */
typedef struct dls_derive dls_derive;

/* Factors the matrix of the states of r. *out = NULL on error. problem: borrowed, as it is, until
 * destroy. r: m. O(rows^3) operations, m^2 doubles. DLS_E_NO_DERIVATIVE; DLS_E_ARGUMENT, also for
 * an r with a residual above 1e-4; DLS_E_SIZE, DLS_E_NOT_FINITE, DLS_E_MEMORY. */
DLS_API DLS_MUST_USE dls_status dls_derive_create(dls_derive **out, const dls_contact *problem,
                                                  const double *r, int side, dls_error *error);

/* Works as dls_derive_create for the body of a reduction, made on W or on K, and its answer (r, x)
 * for the last load. No update of the reduction until destroy. mu (contacts); NULL: model.mu. r: m;
 * x: n. K may be singular, where contacts alone hold
 * a body; then (r, x) is in equilibrium without springs. A sparse LU of K beside the contacts.
 *
 * For a dls_global make a reduction of its model with settings.on = DLS_ON_K, which factors
 * nothing, and load g. A flexibility or a host's solver is DLS_E_UNSUPPORTED: dls_derive_create
 * gives dL/dq, and the host's own solver dL/df = K^-T (H dL/dq + dL/dx). Redundant joints are not
 * determined. */
DLS_API DLS_MUST_USE dls_status dls_derive_create_body(dls_derive **out, dls_reduction *reduction,
                                                       const double *mu, const double *r,
                                                       const double *x, int side, dls_error *error);

/* Computes the gradient of a loss, the vector-Jacobian product: fills the arrays of *gradient that
 * are not NULL from those of *loss; NULL there: 0. Allocates nothing (MUMPS does). Outputs overlap
 * nothing. DLS_E_ARGUMENT, DLS_E_NOT_FINITE, DLS_E_BUSY, DLS_E_MEMORY (MUMPS). */
DLS_API DLS_MUST_USE dls_status dls_derive_vjp(dls_derive *derive, const dls_derive_answer *loss,
                                               const dls_derive_data *gradient, dls_error *error);

/* Computes the change of the answer, the Jacobian-vector product: fills the arrays of *moved that
 * are not NULL from those of *change; NULL there: 0. As dls_derive_vjp. */
DLS_API DLS_MUST_USE dls_status dls_derive_jvp(dls_derive *derive, const dls_derive_data *change,
                                               const dls_derive_answer *moved, dls_error *error);

/* NULL is fine. */
DLS_API void dls_derive_destroy(dls_derive *derive);

#ifdef __cplusplus
}
#endif

#endif
