/* front.h: the methods behind the front door that are made of others. */
#ifndef DLSI_FRONT_H
#define DLSI_FRONT_H

#include "delassus/solve.h"
#include "lcp/lcp_internal.h"
#include "vi/vi_internal.h"

/* Lemke's method on a contact problem, solve_lemke.c. Settings, sizes and problem have been checked;
 * otherwise as dls_solver_create, _solve, _destroy say. */
typedef struct dlsi_pivoting dlsi_pivoting;

dls_status dlsi_pivoting_create(dlsi_pivoting **out, int d, int nc,
                                const dls_solver_settings *settings, dls_error *error);
dls_status dlsi_pivoting_solve(dlsi_pivoting *work, const dls_contact *problem, double *r,
                               double *u, dls_info *info, dls_error *error);
void dlsi_pivoting_destroy(dlsi_pivoting *work);

/* All methods in turn, auto.c; the same. complete = 0: only what the first stage needs; the solve then
 * allocates the rest if it gets so far. */
typedef struct dlsi_auto dlsi_auto;

dls_status dlsi_auto_create(dlsi_auto **out, int d, int nc, const dls_solver_settings *settings,
                            int complete, dls_error *error);
dls_status dlsi_auto_solve(dlsi_auto *work, const dls_contact *problem, double *r, double *u,
                           dls_info *info, dls_error *error);
const double *dlsi_auto_direction(const dlsi_auto *work);
void dlsi_auto_destroy(dlsi_auto *work);

/* So few candidates that preparations, checks and calls can take longer than the solution itself. */
enum { DLSI_FEW = 20 };

/* alone.c: 1 if r, u (or NULL), info (or NULL) hold a certified answer found from r = 0, else 0 and they are
 * untouched. At most DLSI_FEW candidates, q_n < 0 for one of them. */
int dlsi_alone_solve(const dls_contact *problem, double tol, double *r, double *u, dls_info *info);

/* What info says of such an answer, but for the stages past info->stages: clearing those takes as long as the
 * smallest solve. */
static inline void dlsi_alone_report(dls_info *info, int sweeps,
                                     const dls_certificate *certificate) {
  info->status = DLS_OK;
  info->method = DLS_AUTO;
  info->iterations = sweeps;
  info->certificate = *certificate;
  info->ambiguous = info->factorisations = info->sweeps = 0;
  info->stages = sweeps;
  if (sweeps) info->stage[0] = (dls_stage){DLS_NLGS, sweeps, 0, certificate->residual};
}

#endif
