/* front.h: what the files behind the front door share. */
#ifndef DLSI_FRONT_H
#define DLSI_FRONT_H

#include "base/method.h"
#include "delassus/solve.h"

/* The row of a method, NULL for a number that is no method. */
const dlsi_method *dlsi_method_of(dls_method method);

/* The methods that auto is made of; vi/ and contact_lemke.c. */
extern const dlsi_method dlsi_nlgs_method, dlsi_newton_method, dlsi_admm_method,
    dlsi_augmented_method, dlsi_lemke_method;

/* Returns 1 if r, u (or NULL), info (or NULL) hold the certified answer of a problem whose
 * candidates are free or stand alone (alone.c), else 0, and they are untouched. From r = 0,
 * without a workspace. */
int dlsi_alone_solve(const dls_contact *problem, double tol, double *r, double *u, dls_info *info);

#endif
