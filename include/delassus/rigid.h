/*
 * delassus/rigid.h: contacts between rigid bodies in space, as a physics engine has them: H in the
 * factors of dls_bodies, q, and impulses back to velocities.
 *
 *   H_c = B^T J_c,  B B^T = M^-1,  J_c = (e_j; (p - x) x e_j) for e = (n, t, s), -J_c for body b
 *   q_c = J_c^T (v; w) + gap e_n,      (v; w) += B H_c r_c
 *
 *   add the impulses of loads to v and w             v += h g, ...
 *   dls_rigid_contact for each contact k
 *   dls_solve of {.d = 3, .nc = nc, .q = q, .mu = mu, .bodies = {6, count, body, H, NULL}}
 *   dls_rigid_apply
 *   move the bodies with v and w
 *
 * Any system of units; H has the unit 1 / sqrt(mass), q of a velocity, r of an impulse. In the
 * plane, write H by hand as examples/host_rigid.c does.
 */
#ifndef DELASSUS_RIGID_H
#define DELASSUS_RIGID_H

#include "delassus/contact.h"

#ifdef __cplusplus
extern "C" {
#endif

/* A body. Matrices are row-major. */
typedef struct dls_rigid {
  double mass;       /* > 0; INFINITY: it moves with v and w, whatever pushes it */
  double inertia[9]; /* about the centre of mass, in the body's frame; positive definite; not read
                        if the mass is infinite                            mass length^2 */
  double R[9];       /* rotation: a vector of the body's frame becomes R times it in the world */
  double x[3];       /* centre of mass, in the world                                   length */
  double v[3], w[3]; /* its velocity, and the spin, in the world     length / time, 1 / time */
} dls_rigid;

/* Fills contact k of a problem: two blocks of H, three entries of q, two of body.
 *
 *   bodies  count
 *   a, b    their numbers; -1: fixed. Not the same
 *   point   of the contact, 3, in the world                                         length
 *   normal  from b into a, 3, of any length > 0; t and s follow as in pairs.h
 *   gap     distance / h, or another velocity that is added to the normal one: 0 for bodies that
 *           touch; < 0 pushes them apart                                  length / time
 *   k       contact, >= 0
 *   body    2 (k + 1) at least: receives a and b; -1 also for infinite masses
 *   H       36 (k + 1), q 3 (k + 1) at least
 *   frame   receives rows n, t, s, 9, or NULL: r_n n + r_t t + r_s s is the impulse on a
 *
 * O(1). DLS_E_ARGUMENT (NULL; a, b, k; normal zero; "bodies" with the number of the body: mass,
 * inertia or R that is none), DLS_E_NOT_FINITE; nothing is written then. */
DLS_API DLS_MUST_USE dls_status dls_rigid_contact(int count, const dls_rigid *bodies, int a, int b,
                                                  const double *point, const double *normal,
                                                  double gap, int k, int *body, double *H,
                                                  double *q, double *frame, dls_error *error);

/* Adds the motions of reactions r (3 nc) to v and w of the bodies (count); body and H are those of
 * nc contacts. O(nc + count), allocates nothing. DLS_E_ARGUMENT (NULL, body), DLS_E_SIZE,
 * DLS_E_NOT_FINITE (r, H; index), as for bodies above; nothing is changed then. */
DLS_API DLS_MUST_USE dls_status dls_rigid_apply(int count, dls_rigid *bodies, int nc,
                                                const int *body, const double *H, const double *r,
                                                dls_error *error);

#ifdef __cplusplus
}
#endif

#endif
