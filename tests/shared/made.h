/* made.h: what many tests make in one line; the test fails where the library refuses. */
#ifndef MADE_H
#define MADE_H

#include "delassus/reduction.h"
#include "delassus/solve.h"

static const double default_tol = 1e-8; /* that of dls_solver_settings_init */

dls_solver_settings settings_with(dls_method method, double tol);
dls_solver *solver_of(int d, int nc, const dls_solver_settings *settings);
dls_reduction *reduction_of(const dls_model *model, const dls_reduction_settings *settings);
dls_certificate certificate_of(const dls_contact *p, const double *r);

#endif
