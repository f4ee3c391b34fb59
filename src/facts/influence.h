/* influence.h: which data each reaction of an answer depends on. */
#ifndef DLSI_INFLUENCE_H
#define DLSI_INFLUENCE_H

#include "delassus/contact.h"

/* dq (m x m, column-major) := d r_i / d q_j in the states of r, an answer; dmu (m) := d r_i / d mu,
 * all mu_c > 0 raised together; w (nc) := trace(W_cc) / d. DLS_E_SINGULAR: r is not determined.
 * DLS_E_MEMORY. */
dls_status dlsi_contact_influence(const dls_contact *problem, const double *r, double *w,
                                  double *dq, double *dmu, dls_error *error);

#endif
