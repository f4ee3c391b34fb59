/* front.h: what the files behind the front door share. */
#ifndef DLSI_FRONT_H
#define DLSI_FRONT_H

#include "base/method.h"
#include "delassus/solve.h"
#include "delassus/trust.h"

/* The row of a method, NULL for a number that is no method. */
const dlsi_method *dlsi_method_of(dls_method method);

/* The methods that auto is made of; vi/ and contact_lemke.c. */
extern const dlsi_method dlsi_nlgs_method, dlsi_newton_method, dlsi_admm_method,
    dlsi_augmented_method, dlsi_lemke_method, dlsi_homotopy_method;

/* Returns 1 if r, u (or NULL), info (or NULL) hold the certified answer of a problem whose
 * candidates are free or stand alone (alone.c), else 0, and they are untouched. From r = 0,
 * without a workspace. */
int dlsi_alone_solve(const dls_contact *problem, double tol, double *r, double *u, dls_info *info);

/* Candidates of the largest problem for dlsi_contact_find_states. */
enum { dlsi_most_states = 8 };

/* Does the work of dls_contact_fold on a problem; search: 1 for the local search, whatever its
 * size. */
dls_status dlsi_contact_fold(const dls_contact *problem, int search, dls_fold *fold,
                             dls_contact_state *state, double *q, double *r, double *other,
                             dls_error *error);

/* Tries all states of a problem with d = 2 and at most so many candidates (states.c). Returns 1 if
 * that gives a certified answer, 0 if no states have one, -1 if rounding does not tell or the time
 * of a solve that began at `begun` is over. r: scratch, m. best: the best answer so far, m,
 * replaced with its certificate by a better one. */
int dlsi_contact_find_states(const dls_contact *problem, const dls_limits *limits, double begun,
                             double *r, double *best, dls_certificate *certificate);

#endif
