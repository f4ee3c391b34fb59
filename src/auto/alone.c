/*
 * alone.c: solves the contacts one by one, from r = 0 and without a workspace.
 *
 *   (AL1)  r = 0                                  if every q_n >= 0
 *   (AL2)  r_c = the solution of contact c alone, u_c = W_cc r_c + q_c (local.c), for each c
 *          with q_n < 0, and 0 for the others         if there is one such c, or W couples none
 *
 * (AL2) is the first sweep of Gauss-Seidel (nlgs.c), to the same bits, and the last one if it
 * presses no other contact; for few only. What can fail: a contact without a local solution,
 * or with trace(W_cc) <= 0; another contact that the reactions press. Then it returns 0 and has
 * written nothing, and the sweeps begin.
 */
#include <float.h>
#include <math.h>
#include <string.h>

#include "auto/auto.h"
#include "delassus/nlgs.h"
#include "vi/vi_internal.h"

enum { few = 20, most_rows = 3 * few }; /* more take so long that a workspace costs nothing */

/* Sets r of the candidates with q_n < 0 by (AL2). Returns 0 if W couples two of them, or one has no
 * solution or no weight of its own. */
static int solve_each(const dls_contact *problem, double *r) {
  const dls_blocks *B = &problem->Wb;
  const int d = problem->d;
  int pressed = 0, coupled = 0;
  for (int c = 0; c < problem->nc; c++) {
    const double *q = problem->q + d * c;
    if (!(q[0] < 0)) continue;
    coupled |= !(B->x && B->p[c + 1] - B->p[c] == 1 && B->i[B->p[c]] == c);
    if (++pressed > 1 && coupled) return 0;
    double W[9];
    dlsi_contact_diagonal(problem, c, W);
    if (!(dlsi_block_weight(d, W) > 0)) return 0;
    if (dlsi_nlgs_local(d, W, q, problem->mu[c], r + d * c, NULL) == DLS_LOCAL_NONE) return 0;
  }
  return 1;
}

/* Returns 1 if the certificate of r holds and no contact without a reaction is pressed by more than
 * rounding, which a tolerance may hide where W is nearly singular; u := W r + q. */
static int is_certified(const dls_contact *problem, double tol, const double *r, const double *w,
                        double *u, dls_certificate *certificate) {
  double a[most_rows], F[most_rows];
  dlsi_contact_multiply(problem, NULL, r, u, a);
  dlsi_contact_measure(problem, r, u, a, w, F, certificate);
  for (int c = 0; c < problem->nc; c++) {
    const int n = problem->d * c;
    if (r[n] == 0 && u[n] < -4 * DBL_EPSILON * (a[n] + fabs(problem->q[n]))) return 0;
  }
  return dlsi_certificate_holds(certificate, tol);
}

static int is_pressed(const dls_contact *problem) {
  for (int c = 0; c < problem->nc; c++)
    if (problem->q[(size_t)problem->d * (size_t)c] < 0) return 1;
  return 0;
}

int dlsi_alone_solve(const dls_contact *problem, double tol, double *r, double *u, dls_info *info) {
  const size_t m = (size_t)problem->d * (size_t)problem->nc;
  double x[most_rows] = {0}, v[most_rows], w[2 * few];
  dls_certificate certificate = {.body = -1};
  const int pressed = is_pressed(problem);
  if (pressed && (problem->nc > few || dlsi_is_factored(problem))) return 0;
  if (pressed) dlsi_certificate_weights(problem, w);
  if (pressed && !solve_each(problem, x)) return 0;
  if (pressed && !is_certified(problem, tol, x, w, v, &certificate)) return 0;
  if (pressed)
    memcpy(r, x, m * sizeof *r);
  else
    memset(r, 0, m * sizeof *r);
  if (u) memcpy(u, pressed ? v : problem->q, m * sizeof *u);
  if (!info) return 1;
  double J[most_rows * most_rows], own[most_rows];
  const double predicted = pressed ? dlsi_predict_error(problem, x, w, J, own) : 0;
  *info = (dls_info){.method = DLS_AUTO, .iterations = pressed, .stages = pressed};
  info->certificate = certificate;
  info->error = predicted < 0 ? INFINITY : predicted; /* not determined */
  if (pressed) info->ambiguous = dlsi_count_ambiguous(problem, x, v, NULL);
  if (pressed)
    info->stage[0] =
        (dls_stage){.method = DLS_NLGS, .iterations = 1, .residual = certificate.residual};
  return 1;
}
