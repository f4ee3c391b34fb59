/*
 * facets.c: states the contact problem on a friction cone with facets as an LCP.
 *
 *   r_t = sum_k beta_k e_k,   0 <= u_n                   _|_  r_n     >= 0
 *                             0 <= e_k.u_t + lambda      _|_  beta_k  >= 0     k = 0 .. facets-1
 *                             0 <= mu r_n - sum_k beta_k _|_  lambda  >= 0
 *
 * This is (FI1)-(FI3) of friction.c with shift = 0.
 *
 * If sum beta < mu r_n, then lambda = 0 and e_k.u_t >= 0 for every k, hence u_t = 0: both e_k and
 * -e_k are directions. If lambda > 0, beta_k > 0 only for the least e_k.u_t = -lambda: friction
 * opposes slip as well as the polygon allows (Stewart and Trinkle, reference in facets.h).
 *
 * C has the columns c_0 = n, c_(k+1) = e_k. The rows of contact a in the columns of contact b are
 * C^T W_ab C. The column of lambda holds 1, the row of lambda (mu, -1 .. -1). So for z >= 0
 *
 *   z^T M z = r^T W r + sum_c mu_c r_nc lambda_c
 *
 * and M is copositive if W is positive semidefinite. If W is positive definite, Lemke's method
 * meets no ray: LCP(M, 0) has only the solutions z = (0, 0, lambda), and q^T z = 0 for them
 * (Cottle, Pang, Stone, The Linear Complementarity Problem, 1992, theorem 4.4.12).
 *
 * The polygon is inscribed in the circle, so r stays in the round cone. If W = w I and slip goes
 * through the middle of a facet, the certificate has
 *
 *   |F_c| = w mu r_n (1 - cos(pi / facets)) / sqrt(1 + mu^2),   1 - cos(pi / facets) ~ 5 / facets^2
 */
#include <math.h>

#include "lcp_internal.h"

static int facets_allowed(int d, int facets) {
  if (d <= 2) return facets == 2;
  return d == 3 && facets >= 4 && facets <= DLS_FACETS_MAX && facets % 2 == 0;
}

int dls_contact_facets_size(const dls_contact *problem, int facets) {
  if (!problem || !facets_allowed(problem->d, facets) || !problem->mu) return 0;
  return dlsi_form_size(problem, facets);
}

/* Checks the problem and fills the form; the second half of the e_k is minus the first half. */
static dls_status facets_form(const dls_contact *problem, int facets, dlsi_form *form,
                              dls_error *error) {
  dls_status status = dlsi_check_contact(problem, error);
  if (!status) status = dlsi_refuse_bonded(problem, error);
  if (status) return status;
  if (!facets_allowed(problem->d, facets))
    return dlsi_fail(error, DLS_E_ARGUMENT, "facets", -1, facets, "is %d, must be %s", facets,
                     problem->d <= 2 ? "2 where d is 1 or 2" : "even, 4 to 64, where d = 3");
  *form = (dlsi_form){.directions = facets, .c = {{1, 0, 0}}};
  for (int k = 0; k < facets / 2; k++) {
    const double angle = 2 * acos(-1) * k / facets;
    double *e = form->c[1 + k], *opposite = form->c[1 + k + facets / 2];
    e[1] = cos(angle);
    e[2] = problem->d == 3 ? sin(angle) : 0;
    opposite[1] = -e[1];
    opposite[2] = -e[2];
  }
  return DLS_OK;
}

dls_status dls_contact_to_facets_lcp(const dls_contact *problem, int facets, const double *s,
                                     double *M, int ldm, double *q, dls_error *error) {
  DLSI_DOOR;
  dlsi_form form;
  dlsi_formed formed = {.work = NULL};
  dls_status status = facets_form(problem, facets, &form, error);
  if (!status) status = dlsi_form_blocks(&formed, &problem, error);
  if (!status) status = dlsi_form_matrix(problem, &form, s, M, ldm, q, error);
  dlsi_formed_free(&formed);
  return dlsi_at(__func__, status, error);
}

dls_status dls_contact_from_facets_lcp(const dls_contact *problem, int facets, const double *s,
                                       const double *z, double *r, dls_error *error) {
  DLSI_DOOR;
  dlsi_form form;
  dls_status status = facets_form(problem, facets, &form, error);
  if (!status) status = dlsi_form_reactions(problem, &form, s, z, r, error);
  return dlsi_at(__func__, status, error);
}
