/* front.h: declares what the files of src/front share. */
#ifndef DLSI_FRONT_H
#define DLSI_FRONT_H

#include "base/method.h"
#include "delassus/solve.h"

/* Returns the row of a method, NULL for a number that is no method. */
const dlsi_method *dlsi_method_of(dls_method method);

/* Checks the settings of a solver. */
dls_status dlsi_solver_check(const dls_solver_settings *settings, dls_error *error);

/* Does the work of dls_solver_create, *out = NULL before. lazy: see dlsi_options. */
dls_status dlsi_solver_create(dls_solver **out, int d, int nc, int lazy,
                              const dls_solver_settings *settings, dls_error *error);

/* ---- src/front/body.c ------------------------------------------------------------------------ */

/* Copies the certificate of the body to info and sets info->status, so far that of the solve: to
 * DLS_OK or DLS_TO_ROUNDING if and only if the certificate holds. condition: of K, 0 if x does not
 * come from a solve with K. */
void dlsi_body_judge(dls_info *info, const dls_certificate *certificate, double tol,
                     double condition);

#endif
