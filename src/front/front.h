/* front.h: what the files behind the front door share. */
#ifndef DLSI_FRONT_H
#define DLSI_FRONT_H

#include "base/method.h"
#include "delassus/solve.h"

/* The row of a method, NULL for a number that is no method. */
const dlsi_method *dlsi_method_of(dls_method method);

/* Checks the settings of a solver. */
dls_status dlsi_solver_check(const dls_solver_settings *settings, dls_error *error);

/* Does the work of dls_solver_create, *out = NULL before. lazy: see dlsi_options. */
dls_status dlsi_solver_create(dls_solver **out, int d, int nc, int lazy,
                              const dls_solver_settings *settings, dls_error *error);

/* ---- src/front/body.c ------------------------------------------------------------------------ */

/* Takes the certificate of the body into info and sets info->status, so far that of the solve, by
 * it: DLS_OK or DLS_TO_ROUNDING where it holds, and never else. condition: of K, 0 where x does not
 * come from a solve with K. */
void dlsi_body_judge(dls_info *info, const dls_certificate *certificate, double tol,
                     double condition);

#endif
