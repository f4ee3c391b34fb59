/* facts.h: facts about a problem, for auto, which decides by them, and for the public calls. */
#ifndef DLSI_FACTS_H
#define DLSI_FACTS_H

#include "contact/method.h"
#include "delassus/trust.h"

/* ---- contact_lemke.c ------------------------------------------------------------------------- */

extern const dlsi_method dlsi_lemke_method;

/* Returns 1 if the last solve in this workspace of dlsi_lemke_method has shown that no r can be
 * certified. */
int dlsi_contact_lemke_excludes(const void *lemke);

/* ---- farkas.c -------------------------------------------------------------------------------- */

/* The linear problem that every solution solves, as an LCP in z = (v, x), (FA2), with the
 * scales s (nc) and the unit of (CL4). M: n x n, q: n, column: scratch, m. */
int dlsi_farkas_size(const dls_contact *problem);
void dlsi_farkas_lcp(const dls_contact *problem, const double *s, double unit, double *M, double *q,
                     double *column);

/* Returns 1 if v >= 0 (nc) shows that the certificate of no r can hold, (FA3). w: weights of the
 * certificate. */
int dlsi_farkas_excludes(const dls_contact *problem, const double *w, const double *v, double tol);

/* ---- sensitivity.c --------------------------------------------------------------------------- */

enum { dlsi_predicted_rows = 300, dlsi_predicted_of_blocks = 60 };

/* Returns |r - r*| / |r| to first order, in the states that r has, at least that of rounding; 0 if
 * nothing touches, -1 if the reactions are not determined. For up to dlsi_predicted_rows rows. w:
 * weights of the certificate. J: scratch, m x m. x: scratch, m. */
double dlsi_predict_error(const dls_contact *problem, const double *r, double *w, double *J,
                          double *x);

/* Returns 1 if `cost` multiplications are at most a twentieth of what the iterations and
 * factorisations of a solve with m rows took. */
int dlsi_is_small_part(double cost, const dls_info *info, double m);

/* (SN6) Returns 1 if the error of r may be large although the residual is small; always 1 where the
 * prediction costs little: few rows, or a long solve, whose iterations and factorisations `info`
 * has. For up to dlsi_predicted_rows rows. W: dense or by blocks. w: weights of the certificate.
 * Costs about one product with W. */
int dlsi_may_hide_error(const dls_contact *problem, const double *w, const dls_info *info);

/* state (nc) := the states of the positions u, with u_n and |u_t| up to `close` taken as 0:
 * contacts that touch and do not slip stick, with or without a reaction. */
void dlsi_contact_touch(const dls_contact *problem, const double *u, double close,
                        dls_contact_state *state);

/* Returns the distance within which a contact is on the border of two states: a fraction of the
 * largest entry of w r and u, at least 10 times the residual. w: weights of the certificate. */
double dlsi_border_width(const dls_contact *problem, const double *w, const double *r,
                         const double *u, double residual);

/* Returns the other state that a contact in `state` is within `close` of; without one, `state`. w,
 * r, u: of this contact. */
dls_contact_state dlsi_border_state(int d, double mu, dls_contact_state state, const double *w,
                                    const double *r, const double *u, double close);

/* ---- prove.c --------------------------------------------------------------------------------- */

/* Does the work of dls_contact_prove; W dense or by blocks, all checked. */
dls_status dlsi_contact_prove(const dls_contact *problem, const double *r, dls_proof *proof,
                              double *improved, dls_error *error);

/* ---- bound.c --------------------------------------------------------------------------------- */

/* Sets *friction, below which each q has exactly one solution, 0 if the symmetric part of W is not
 * positive definite, and value (m), the eigenvalues of that part, scaled, in ascending order;
 * value[0] = NAN if LAPACK does not find them. scale: 1 / sqrt of the weights, nc. DLS_OK or
 * DLS_E_MEMORY. */
dls_status dlsi_unique_below(const dls_contact *problem, const double *scale, double *value,
                             double *friction);

/* ---- states.c, fold.c ------------------------------------------------------------------------ */

/* Candidates of the largest problem for dlsi_contact_find_states. */
enum { dlsi_most_states = 8 };

/* Does the work of dls_contact_fold on a problem. search: 1 for the local search, whatever the
 * size. */
dls_status dlsi_contact_fold(const dls_contact *problem, int search, dls_fold *fold,
                             dls_contact_state *state, double *q, double *r, double *other,
                             dls_error *error);

/* Tries all states of a problem with d = 2 and at most so many contacts (states.c). Returns 1 if
 * that gives a certified answer, 0 if no states have one, -1 if rounding leaves it open or the time
 * of a solve that began at `begun` is over. r: scratch, m. best: the best answer so far, m; a
 * better answer replaces it and its certificate. */
int dlsi_contact_find_states(const dls_contact *problem, const dls_limits *limits, double begun,
                             double *r, double *best, dls_certificate *certificate);

#endif
