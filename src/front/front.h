/* front.h: declares what the files of src/front share. */
#ifndef DLSI_FRONT_H
#define DLSI_FRONT_H

#include "contact/method.h"
#include "delassus/reduction.h"
#include "delassus/solve.h"

/* Returns the row of a method, NULL for a number that is no method. */
const dlsi_method *dlsi_method_of(dls_method method);

/* Checks the settings of a solver. */
dls_status dlsi_solver_check(const dls_solver_settings *settings, dls_error *error);

/* Does the work of dls_solver_create, *out = NULL before. lazy: see dlsi_options. */
dls_status dlsi_solver_create(dls_solver **out, int d, int nc, int lazy,
                              const dls_solver_settings *settings, dls_error *error);

/* ---- scaled.c -------------------------------------------------------------------------------- */

/* A solve in units of its own; units NULL: in those of the caller. */
typedef struct dlsi_scaled {
  dlsi_units *units;
  size_t m;
  const dls_contact *given; /* the caller's problem, ... */
  double *r, *u;            /* ... arrays, ... */
  dls_info *info, own;      /* ... info, and that of the copy, ... */
  dls_limits host;          /* ... limits */
} dlsi_scaled;

/* Begin and end a solve of a problem that has been checked. The first one may replace the problem,
 * r, u, info and the callback of the limits by those of a copy. The second one fills the caller's
 * arrays and returns the status for the caller's problem. */
dls_status dlsi_scaled_begin(dlsi_scaled *s, dlsi_units *units, const dls_contact **problem,
                             double **r, double **u, dls_info **info, dls_limits *limits,
                             dls_error *error);
dls_status dlsi_scaled_end(dlsi_scaled *s, dls_status status, dls_error *error);

/* ---- src/front/body.c ------------------------------------------------------------------------ */

/* Copies the certificate of the body to info and sets info->status, so far that of the solve: to
 * DLS_OK or DLS_TO_ROUNDING if and only if the certificate holds. condition: of K, 0 if x does not
 * come from a solve with K. */
void dlsi_body_judge(dls_info *info, const dls_certificate *certificate, double tol,
                     double condition);

/* *better := 1 if K is estimated to be cheaper than W. The reduction is on K, and keeps nothing of
 * the look. */
dls_status dlsi_body_foresee(dls_reduction *reduction, int *better, dls_error *error);

/* Returns why a solve on K ended with `status`. */
dls_reason dlsi_body_reason(dls_status status);

#endif
