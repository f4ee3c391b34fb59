/*
 * alone.c: what the method auto answers without a workspace, from r = 0, where some q_n < 0.
 *
 *   (A1)  r = 0                                  if the certificate holds: q_n < 0 by less than tol
 *   (A2)  r_c = the solution of candidate c alone, u_c = W_cc r_c + q_c (vi/local.c), for the c with
 *         q_n < 0 and 0 for the others           if that is one, or nothing couples them
 *
 * (A2) is the first sweep of Gauss-Seidel (vi/nlgs.c), to the same bits, and the last one if none of the
 * others is pressed by it: where W is block diagonal, where a single candidate is pressed or there
 * is but one. What is answered is what the certificate holds for, (A1) and (A2) up to 20 candidates: a
 * larger problem takes long enough for the sweeps with all their preparations not to be seen.
 *
 * Cost: O(nc) for q, the columns of W of those c, the certificate.
 * What can fail: a candidate without a local solution, or with trace(W_cc) <= 0; another one that is
 * pressed by the reactions. Then 0 is returned, nothing has been written, and the sweeps begin.
 */
#include <string.h>

#include "front/front.h"

enum { most_rows = 3 * DLSI_FEW };

/* (A2) r and the weights w of the candidates with q_n < 0 (those of the others do not count: w r = 0);
 * 0 if W couples two of them, or one has no solution or no weight of its own. */
static int solve_each(const dls_contact *problem, double *r, double *w) {
  const dls_blocks *B = &problem->Wb;
  const int d = problem->d;
  int pressed = 0, coupled = 0;
  for (int c = 0; c < problem->nc; c++) {
    const double *q = problem->q + d * c;
    if (!(q[0] < 0)) continue;
    const int only = B->x && B->p[c + 1] - B->p[c] == 1 && B->i[B->p[c]] == c;
    coupled |= !only;
    if (++pressed > 1 && coupled) return 0;
    double copy[9];
    const double *W = only ? B->x + (size_t)(d * d) * (size_t)B->p[c] : copy;
    if (!only) dlsi_contact_diagonal(problem, c, copy);
    w[c] = dlsi_block_weight(d, W);
    if (!(w[c] > 0)) return 0;
    if (dls_nlgs_local(d, W, q, problem->mu[c], r + d * c, NULL) == DLS_LOCAL_NONE) return 0;
  }
  return 1;
}

/* Does r = 0 fail (A1) for certain? F_c = -P_Cmu(v), v = -(q_c + mu |q_t| n), and with e = (1, -mu q_t / |q_t|)
 * in the cone |P(v)| >= v.e / |e| = -q_n / sqrt(1 + mu^2). */
static int is_needed(const dls_contact *problem, double tol) {
  const int d = problem->d;
  double sum = 0, all = 0;
  for (int c = 0; c < problem->nc; c++) {
    const double *q = problem->q + d * c, mu = problem->mu[c];
    all += q[0] * q[0] + q[1] * q[1] + (d == 3 ? q[2] * q[2] : 0);
    if (q[0] < 0) sum += q[0] * q[0] / (1 + mu * mu);
  }
  return sum > tol * tol * all;
}

static int certify(const dls_contact *problem, double tol, const double *r, const double *w,
                   double *u, dls_certificate *certificate) {
  double a[most_rows], F[most_rows];
  dlsi_contact_multiply(problem, NULL, r, u, a);
  dlsi_contact_measure(problem, r, u, a, w, F, certificate);
  return dls_certificate_holds(certificate, tol);
}

int dlsi_alone_solve(const dls_contact *problem, double tol, double *r, double *u, dls_info *info) {
  const size_t m = (size_t)problem->d * (size_t)problem->nc;
  double x[most_rows], v[most_rows], w[DLSI_FEW];
  dls_certificate certificate = {0};
  int sweeps = 0;
  memset(x, 0, m * sizeof *x);
  memset(w, 0, sizeof w);
  if (is_needed(problem, tol) || !certify(problem, tol, x, w, v, &certificate)) {
    if (!solve_each(problem, x, w)) return 0;
    if (!certify(problem, tol, x, w, v, &certificate)) return 0;
    sweeps = 1;
  }
  memcpy(r, x, m * sizeof *r);
  if (u) memcpy(u, v, m * sizeof *u);
  if (info) dlsi_alone_report(info, sweeps, &certificate);
  return 1;
}
