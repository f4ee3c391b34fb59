/*
 * doors.h: the solvers that the tests drive: the four methods with functions of their own, and
 * dls_solver with any method of the library's table.
 *
 * NAME_tol: default settings with a tolerance. run_NAME: run_with (cases.h) with typed settings.
 */
#ifndef DOORS_H
#define DOORS_H

#include "cases.h"
#include "delassus/admm.h"
#include "delassus/augmented.h"
#include "delassus/newton.h"
#include "delassus/nlgs.h"
#include "delassus/solve.h"

#define DECLARE_DOOR(NAME)                                                                         \
  extern const tested_solver the_##NAME;                                                           \
  dls_##NAME##_settings NAME##_tol(double tol);                                                    \
  dls_status run_##NAME(const dls_contact *p, const dls_##NAME##_settings *settings, double *r,    \
                        double *u, dls_info *info)
DECLARE_DOOR(nlgs);
DECLARE_DOOR(newton);
DECLARE_DOOR(admm);
DECLARE_DOOR(augmented);
#undef DECLARE_DOOR

enum { direct_doors = 4 };

/* How many methods the table has. */
int method_count(void);

/* Door k: for k < direct_doors a method's own, then dls_solver with method k - direct_doors. */
tested_solver door(int k);

#endif
