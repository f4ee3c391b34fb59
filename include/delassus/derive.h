/*
 * delassus/derive.h: derivatives of an answer with respect to its data.
 *
 *   on W   u = W r + q and the laws of contact.h           data W, q, mu      answer r, u
 *   on K   K x = f + H r, u = H^T x + g and these laws     data K, f, g, mu   answer r, u, x
 *
 * The answer is a smooth function of the data if no contact is on the border of two states and the
 * reactions are determined. Create factorises one matrix; each gradient or direction then takes one
 * solve with it. The derivatives are exact to rounding for an exact r, and as accurate as r
 * otherwise (dls_contact_prove improves r to rounding).
 *
 * Create refuses an answer without derivatives by DLS_E_NO_DERIVATIVE:
 *
 *   argument "contact", index c   contact c is on the border of two states, which the message
 *                                 names: within max(1e-6, 10 residual) of the largest entry of
 *                                 (w r, u)
 *   argument "r"                  the reactions are not determined (self-stresses)
 *
 * On a border the answer has a kink, with one derivative for each of the two states. side = 0 takes
 * the higher state of dls_contact_state (stick rather than slip, closed rather than free), side = 1
 * the lower one, at all contacts on a border; side = -1 refuses.
 *
 * The derivative with respect to mu_c is 0 where contact c is free or sticks, where mu_c is
 * INFINITY, and where mu_c = 0 and u_t = 0. Where mu_c = 0 and u_t is not 0 it is the derivative to
 * the right.
 */
#ifndef DELASSUS_DERIVE_H
#define DELASSUS_DERIVE_H

#include "delassus/reduction.h"

#ifdef __cplusplus
extern "C" {
#endif

/* The data, m = d nc: a gradient dL/ddata, or a change of the data. Fields of the other kind of
 * object must be NULL. */
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

/* Factorises the matrix of the states of r. *out = NULL on error. problem: borrowed, as it is,
 * until destroy. r: m. O(rows^3) operations, m^2 doubles. DLS_E_NO_DERIVATIVE; DLS_E_ARGUMENT, also
 * for an r with a residual above 1e-4; DLS_E_SIZE, DLS_E_NOT_FINITE, DLS_E_MEMORY. */
DLS_API DLS_MUST_USE dls_status dls_derive_create(dls_derive **out, const dls_contact *problem,
                                                  const double *r, int side, dls_error *error);

/* Works as dls_derive_create for the body of a reduction, made on W or on K, and its answer (r, x)
 * for the last load. The reduction must not be updated until destroy. mu: one for each contact;
 * NULL: model.mu. r: m; x: n. K may be singular if contacts alone hold a body; (r, x) is in
 * equilibrium. Factorises a sparse matrix of K and the contacts.
 *
 * For a dls_global make a reduction of its model with settings.on = DLS_ON_K, which factorises
 * nothing, and load f and g. DLS_E_UNSUPPORTED for a flexibility or a host's solver: use
 * dls_derive_create for dL/dq, and your own solver for dL/df = K^-T (H dL/dq + dL/dx).
 * Redundant joints (model.h) carry no force: derivatives with respect to their loads are 0, and a
 * change of K is one of all copies of a joint alike. */
DLS_API DLS_MUST_USE dls_status dls_derive_create_body(dls_derive **out, dls_reduction *reduction,
                                                       const double *mu, const double *r,
                                                       const double *x, int side, dls_error *error);

/* Computes the gradient of a loss, the vector-Jacobian product: fills the arrays of *gradient that
 * are not NULL from those of *loss; NULL there: 0. Allocates nothing (MUMPS does). Outputs overlap
 * nothing. DLS_E_ARGUMENT, DLS_E_NOT_FINITE, DLS_E_BUSY, DLS_E_MEMORY (MUMPS). */
DLS_API DLS_MUST_USE dls_status dls_derive_vjp(dls_derive *derive, const dls_derive_answer *loss,
                                               const dls_derive_data *gradient, dls_error *error);

/* Computes the change of the answer, the Jacobian-vector product: fills the arrays of *moved that
 * are not NULL from those of *change; NULL there: 0. Allocation, overlap and errors of
 * dls_derive_vjp. */
DLS_API DLS_MUST_USE dls_status dls_derive_jvp(dls_derive *derive, const dls_derive_data *change,
                                               const dls_derive_answer *moved, dls_error *error);

/* Frees the object; NULL is fine. */
DLS_API void dls_derive_destroy(dls_derive *derive);

#ifdef __cplusplus
}
#endif

#endif
