/*
 * delassus/facets.h: states the contact problem on a friction cone with facets as an LCP, for d =
 * 3, and for d = 2, where facets leave the cone as it is.
 *
 * The disc |r_t| <= mu r_n gives way to the polygon whose corners are the ends of mu r_n e_k, the
 * directions e_k (k = 0 .. facets-1) standing at the angles 2 pi k / facets from t towards s. Per
 * candidate with mu > 0, facets + 2 rows (Klarbring and Bjorkman, Computers and Structures 30,
 * 1988, 1185-1198; in this form Stewart and Trinkle, Int. J. Num. Meth. Eng. 39, 1996, 2673-2691):
 *
 *   z = (r_n, beta_0 .. beta_(facets-1), lambda),                r_t = sum_k beta_k e_k
 *   y = (u_n, e_k.u_t + lambda,          mu r_n - sum_k beta_k)
 *
 * and one, z = r_n, y = u_n, for one with mu = 0. lambda is the size of the slip. The polygon lies
 * inside the disc: reactions never leave the round cone, and friction falls short of mu r_n by at
 * most the fraction 1 - cos(pi / facets), 7.6 % for 8 facets, 1.9 % for 16; dls_solve removes that
 * error.
 *
 * d = 1 and 2 have facets = 2, the directions t and -t, and no error: 4 rows per contact where
 * dls_contact_to_lcp has 3. Use this form if the other one ends in a ray: with W positive definite
 * it has none, for each mu.
 */
#ifndef DELASSUS_FACETS_H
#define DELASSUS_FACETS_H

#include "delassus/contact.h"

#ifdef __cplusplus
extern "C" {
#endif

#define DLS_FACETS_MAX 64

/* Counts the rows of the LCP. 0 for NULL, for a number of facets that is not allowed (2 where d =
 * 2; even, 4 to DLS_FACETS_MAX, where d = 3), and where the size does not fit an int. */
DLS_API int dls_contact_facets_size(const dls_contact *problem, int facets);

/* Forms M (n x n, leading dimension ldm >= n) and q (n) of the LCP above, n =
 * dls_contact_facets_size, in scaled unknowns r_c = s_c r'_c, u_c = u'_c / s_c; s (nc, each > 0) or
 * NULL for none. s_c = 1 / sqrt(w_c) makes the diagonal blocks of W of size 1. M and q must not
 * overlap each other, s or the problem; rows n .. ldm-1 of M are left alone. Allocates nothing.
 * DLS_E_ARGUMENT, DLS_E_SIZE, DLS_E_NOT_FINITE. */
DLS_API DLS_MUST_USE dls_status dls_contact_to_facets_lcp(const dls_contact *problem, int facets,
                                                          const double *s, double *M, int ldm,
                                                          double *q, dls_error *error);

/* Computes the reactions r (d nc) of z (n); facets and s as above. */
DLS_API DLS_MUST_USE dls_status dls_contact_from_facets_lcp(const dls_contact *problem, int facets,
                                                            const double *s, const double *z,
                                                            double *r, dls_error *error);

#ifdef __cplusplus
}
#endif

#endif
