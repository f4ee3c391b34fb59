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
 *
 * m = d nc as in contact.h. A loss L(r, u, x) is given by its gradients gr = dL/dr (m), gu = dL/du
 * (m), gx = dL/dx (n), each NULL for 0. Outputs may be NULL where they are not wanted.
 */
#ifndef DELASSUS_DERIVE_H
#define DELASSUS_DERIVE_H

#include "delassus/reduction.h"

#ifdef __cplusplus
extern "C" {
#endif

/* The derivatives at one answer. One call at a time on an object (DLS_E_BUSY). */
typedef struct dls_derive dls_derive;

/* Factors the matrix of the states of r. *out = NULL on error. problem: borrowed, as it is, until
 * destroy. r: m; copied. O(rows^3) operations, m^2 doubles. DLS_E_NO_DERIVATIVE; DLS_E_ARGUMENT,
 * also for an r that misses the laws by more than 1e-4 of the largest entry of (w r, u);
 * DLS_E_SIZE, DLS_E_NOT_FINITE, DLS_E_MEMORY. */
DLS_API DLS_MUST_USE dls_status dls_derive_create(dls_derive **out, const dls_contact *problem,
                                                  const double *r, int side, dls_error *error);

/* Gives the gradient of L, the vector-Jacobian products:
 *
 *   q    dL/dq, m; then dL/dW = q r^T                                      of a position
 *   mu   dL/dmu, nc
 *   W    dL/d(each stored value of the problem's W): as W.a (W.ld m; what lies beyond m rows is
 *        left alone), Wb.x, or bodies.H (0 of a fixed body)
 *
 * Allocates nothing (MUMPS does). Outputs must not overlap inputs. DLS_E_ARGUMENT,
 * DLS_E_NOT_FINITE, DLS_E_BUSY, DLS_E_MEMORY (MUMPS). */
DLS_API DLS_MUST_USE dls_status dls_derive_vjp(dls_derive *derive, const double *gr,
                                               const double *gu, double *q, double *mu, double *W,
                                               dls_error *error);

/* Gives the change of the answer, dr (m) and du (m), for a change of the data, the Jacobian-vector
 * product: dq (m), dmu (nc), dW (stored as W above), each NULL for 0. As dls_derive_vjp. */
DLS_API DLS_MUST_USE dls_status dls_derive_jvp(dls_derive *derive, const double *dq,
                                               const double *dmu, const double *dW, double *dr,
                                               double *du, dls_error *error);

/* Works as dls_derive_create on the body of a reduction, on W or on K, and an answer (r, x) of it:
 * K as in its last create or update, g as last loaded, neither of which may change until destroy.
 * mu (contacts): borrowed; NULL: model.mu, or 0 without it. r: m; x: n. No spring that holds a mode
 * takes part: (r, x) has to be in equilibrium, and bodies that contact alone holds have
 * derivatives, too. A sparse LU of K beside the contacts. For a dls_global make a reduction of its
 * model with settings.on = DLS_ON_K, which is not factored, and load g. DLS_E_UNSUPPORTED for a
 * flexibility or a host's solver, which has no K: dls_derive_create on the contact problem gives
 * dL/dq, and the host's own solver dL/df = K^-T (H dL/dq + gx). Redundant joints are not
 * determined. */
DLS_API DLS_MUST_USE dls_status dls_derive_create_body(dls_derive **out, dls_reduction *reduction,
                                                       const double *mu, const double *r,
                                                       const double *x, int side, dls_error *error);

/* Gives the gradient of L for a body:
 *
 *   f    dL/df, n; then dL/dK = -f x^T                                      of a displacement
 *   g    dL/dg, d * nodes as dls_reduction_load takes g
 *   mu   dL/dmu, contacts
 *   K    dL/d(each stored value of K): n x n without gaps, or as Ks.x. Of a symmetric K
 *        (DLS_CHOLESKY, DLS_LDLT) an entry below the diagonal moves two places, and one above it,
 *        which is not read, has 0 */
DLS_API DLS_MUST_USE dls_status dls_derive_body_vjp(dls_derive *derive, const double *gr,
                                                    const double *gu, const double *gx, double *f,
                                                    double *g, double *mu, double *K,
                                                    dls_error *error);

/* Gives dr (m), du (m), dx (n) for df (n), dg (d * nodes), dmu (contacts), dK (as K above). */
DLS_API DLS_MUST_USE dls_status dls_derive_body_jvp(dls_derive *derive, const double *df,
                                                    const double *dg, const double *dmu,
                                                    const double *dK, double *dr, double *du,
                                                    double *dx, dls_error *error);

/* NULL is fine. */
DLS_API void dls_derive_destroy(dls_derive *derive);

#ifdef __cplusplus
}
#endif

#endif
