/* front.h: what the files behind the front door share. */
#ifndef DLSI_FRONT_H
#define DLSI_FRONT_H

#include <stdint.h>

#include "base/method.h"
#include "delassus/solve.h"
#include "delassus/trust.h"

/* The row of a method, NULL for a number that is no method. */
const dlsi_method *dlsi_method_of(dls_method method);

/* The methods that auto is made of; vi/ and contact_lemke.c. */
extern const dlsi_method dlsi_nlgs_method, dlsi_newton_method, dlsi_admm_method,
    dlsi_augmented_method, dlsi_lemke_method, dlsi_homotopy_method, dlsi_scatter_method,
    dlsi_rest_method;

/* Checks the settings of a solver. */
dls_status dlsi_solver_check(const dls_solver_settings *settings, dls_error *error);

/* Does the work of dls_solver_create, *out = NULL before. lazy: see dlsi_options. */
dls_status dlsi_solver_create(dls_solver **out, int d, int nc, int lazy,
                              const dls_solver_settings *settings, dls_error *error);

/* Returns 1 if r, u (or NULL), info (or NULL) hold the certified answer of a problem whose
 * candidates are free or stand alone (alone.c), else 0, and they are untouched. From r = 0,
 * without a workspace. */
int dlsi_alone_solve(const dls_contact *problem, double tol, double *r, double *u, dls_info *info);

/* farkas.c: the linear problem that every solution solves, as an LCP in z = (v, x), (FA2), with the
 * scales s (nc) and the unit of (CL4). M: n x n, q: n, column: scratch, m. */
int dlsi_farkas_size(const dls_contact *problem);
void dlsi_farkas_lcp(const dls_contact *problem, const double *s, double unit, double *M, double *q,
                     double *column);

/* Returns 1 if v >= 0 (nc) shows that the certificate of no r can hold, (FA3). w: weights of the
 * certificate. */
int dlsi_farkas_excludes(const dls_contact *problem, const double *w, const double *v, double tol);

/* Returns 1 if the last solve in this workspace of dlsi_lemke_method has shown that no r can be
 * certified. */
int dlsi_contact_lemke_excludes(const void *lemke);

/* searches: 1 lets the next solves of this workspace of dlsi_lemke_method search as (CL6) of
 * contact_lemke.c says; 0: no more. */
void dlsi_contact_lemke_search(void *lemke, int searches);

/* ---- src/front/body.c ------------------------------------------------------------------------ */

/* Takes the certificate of the body into info and sets info->status, so far that of the solve, by
 * it: DLS_OK or DLS_TO_ROUNDING where it holds, and never else. condition: of K, 0 where x does not
 * come from a solve with K. */
void dlsi_body_judge(dls_info *info, const dls_certificate *certificate, double tol,
                     double condition);

/* ---- src/front/sensitivity.c ----------------------------------------------------------------- */

enum { dlsi_predicted_rows = 300, dlsi_predicted_of_blocks = 60 };

/* Returns |r - r*| / |r| to first order, in the states that r has; 0 where nothing touches, -1
 * where the reactions are not determined. For up to dlsi_predicted_rows rows. u: W r + q. w:
 * weights of the certificate. J: scratch, m x m. x: scratch, m. */
double dlsi_predict_error(const dls_contact *problem, const double *r, double *u, double *w,
                          double *J, double *x);

/* A copy of a problem in an order and in units of its own (renumber.c). */
typedef struct dlsi_renumber {
  dls_contact problem;  /* the copy, W dense */
  double *W, *q, *mu;   /* its arrays: m x m, m, nc */
  double *weights;      /* 2 nc, where the problem has weights */
  int *from;            /* its candidate c is from[c] of the problem; 3 nc, the rest scratch */
  int power_W, power_q; /* W and q of the problem are 2 to these powers times those of the copy */
  double *key[3];       /* scratch, nc each */
  uint64_t *code;       /* scratch, 2 nc */
} dlsi_renumber;

void dlsi_renumber_carve(dlsi_renumber *copy, dlsi_arena *arena, int d, int nc);

/* most_mu: larger frictions become this one. */
void dlsi_renumber_set(dlsi_renumber *copy, const dls_contact *problem, double most_mu);

/* back := x, `entries` numbers per candidate, in the order of the problem, times 2^power. */
void dlsi_renumber_back(const dlsi_renumber *copy, int entries, int power, const double *x,
                        double *back);

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

/* ---- apart.c --------------------------------------------------------------------------------- */

/* *list := the candidates of a problem that may touch, ascending, where W is dense and at least two
 * in five of the candidates provably cannot; the caller frees it. Returns how many; 0, *list NULL,
 * where that is not so. */
int dlsi_list_touching(const dls_contact *problem, int **list);

#endif
