/*
 * toy.c: the smallest method of the table, sweeps with a proximal point outside; d = 2 and 3.
 *
 * u = W r + q with the laws of contact is solved for W + D, D = diag(w_c), about the r before:
 *
 *   (TY1)  for each candidate c in turn: r_c := the answer of its own problem, (W_cc + w_c I) and
 *          u_c - (W_cc + w_c I) r_c with u = W r + q + D (r - p), by dls_nlgs_local
 *   (TY2)  after every 10 sweeps, p := r
 *
 * Stop: the certificate of r holds, or the limit of sweeps.
 * Source: Gauss-Seidel as in nlgs.c; Rockafellar, SIAM J. Control Optim. 14, 1976 for (TY2).
 * Cost: a sweep is a product with W. What fails: small eigenvalues of W take 1 / them of sweeps.
 */
#include <stdlib.h>
#include <string.h>

#include "base/method.h"
#include "delassus/nlgs.h"
#include "vi_internal.h"

enum { toy_most_sweeps = 100000, toy_inner = 10 };

typedef struct toy {
  int d, nc;
  dls_limits limits;
  dlsi_iterate it;
  double *r, *p; /* m */
} toy;

static void toy_carve(void *workspace, dlsi_arena *arena) {
  toy *work = workspace;
  const size_t m = (size_t)work->d * (size_t)work->nc;
  dlsi_iterate_carve(&work->it, arena, work->d, work->nc, &work->limits);
  dlsi_take_vectors(arena, m, 2, (double **const[]){&work->r, &work->p});
}

static dls_status toy_create(void **out, int d, int nc, const dlsi_options *options,
                             dls_error *error) {
  toy filled = {.d = d, .nc = nc, .limits = options->limits};
  return dlsi_workspace(out, &filled, sizeof filled, toy_carve, nc, error);
}

/* (TY1) */
static void toy_sweep(toy *work, const dls_contact *problem) {
  const int d = problem->d;
  for (int c = 0; c < problem->nc; c++) {
    double W[9], q[3], change[3], w = work->it.w[c];
    double *r = work->r + (size_t)d * (size_t)c, *u = work->it.u + (size_t)d * (size_t)c;
    const double *p = work->p + (size_t)d * (size_t)c;
    dlsi_contact_diagonal(problem, c, W);
    for (int i = 0; i < d; i++) {
      q[i] = u[i] - w * p[i];
      for (int j = 0; j < d; j++)
        q[i] -= W[i + d * j] * r[j];
      W[i + d * i] += w;
    }
    memcpy(change, r, (size_t)d * sizeof *r);
    (void)dls_nlgs_local(d, W, q, problem->mu[c], r, NULL);
    for (int i = 0; i < d; i++)
      change[i] = r[i] - change[i];
    dlsi_contact_add_columns(problem, c, change, work->it.u);
  }
}

static dls_status toy_iterate(toy *work, const dls_contact *problem, dls_info *outcome) {
  const int most = dlsi_most_iterations(&work->limits, toy_most_sweeps);
  const size_t m = (size_t)problem->d * (size_t)problem->nc;
  for (int k = 1; k <= most; k++) {
    if (k % toy_inner == 1) memcpy(work->p, work->r, m * sizeof *work->p); /* (TY2) */
    toy_sweep(work, problem);
    outcome->iterations = k;
    const dls_certificate now = dlsi_iterate_offer(&work->it, problem, work->r);
    if (dls_certificate_holds(&now, work->limits.tol)) return DLS_OK;
    if (dlsi_is_cancelled(&work->limits, "toy", k, most, now.residual)) return DLS_CANCELLED;
  }
  return DLS_MAX_ITERATIONS;
}

static dls_status toy_solve(void *workspace, const dls_contact *problem, double *r, double *u,
                            dls_info *info, dls_error *error) {
  toy *work = workspace;
  dls_info outcome = {.method = (dls_method)7};
  dls_status status = DLS_OK;
  (void)error;
  dlsi_iterate_begin(&work->it, problem, NULL, work->limits.tol, work->limits.warm_start, r,
                     work->r);
  if (!dlsi_iterate_start(&work->it, problem, work->r))
    status = toy_iterate(work, problem, &outcome);
  return dlsi_iterate_end(&work->it, problem, status, &outcome, r, u, info);
}

static void toy_set_limits(void *workspace, const dls_limits *limits) {
  dlsi_set_limits(&((toy *)workspace)->limits, limits);
}

const dlsi_method dlsi_toy_method = {.method = (dls_method)7, /* DLS_TOY of delassus/info.h */
                                     .name = "toy",
                                     .summary = "2D, 3D: shows how a method joins the table",
                                     .create = toy_create,
                                     .solve = toy_solve,
                                     .destroy = free,
                                     .set_limits = toy_set_limits};
