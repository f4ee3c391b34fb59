/*
 * front_cases.h: problems for dls_solver and for auto, and checks of auto's report.
 */
#ifndef FRONT_CASES_H
#define FRONT_CASES_H

#include "delassus/solve.h"

/* The next random number of a sequence, in [-1, 1). */
double draw(unsigned *seed);

/* Default settings of a method, tol = 1e-13. */
dls_solver_settings settings_of(dls_method method);

/* Compares all fields; memcmp would compare the padding, too. */
int same_certificate(const dls_certificate *a, const dls_certificate *b);

/* Makes W = A^T A / m + diagonal I with coupled normals and tangents; every fourth candidate has no
 * friction. W (m x m), q (m), mu (nc): storage, m = d nc. */
dls_contact coupled(double *W, double *q, double *mu, int d, int nc, double diagonal,
                    double friction, unsigned seed);

enum { PLANTED = 40 }; /* candidates at most */

typedef struct planted_problem {
  double W[9 * PLANTED * PLANTED], q[3 * PLANTED], mu[PLANTED];
} planted_problem;

/* Makes W = B B^T of the rank given, scaled, and q = u - W r for some (r, u) that is a solution, a
 * third of the candidates each free, slipping and sticking: hard for sweeps and for Newton's
 * method. */
dls_contact planted(planted_problem *a, int d, int nc, int rank, double friction, unsigned seed);
/* The same with columns of B that fall from 1 to condition^-1/2: W is as ill-conditioned. */
dls_contact planted_graded(planted_problem *a, int d, int nc, int rank, double condition,
                           double friction, unsigned seed);
/* The k-th of them: full rank and mu = 1, or half of it and mu = 3 */
dls_contact planted_case(planted_problem *a, int k);

/* Solves by auto; any status but an error. */
dls_info solve_auto(const dls_contact *p, double tol, double *r);
/* Asserts that the stages add up, and that the best of them is what is returned. */
void check_report(const dls_info *info);
void same_stages(const dls_info *a, const dls_info *b);

/* Calls dls_solve, or create and solve, with each malloc failing in turn; returns how many
 * failed. */
long fail_in_turn(const dls_contact *p, const dls_solver_settings *s, int at_once);

#endif
