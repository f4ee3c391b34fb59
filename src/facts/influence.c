/*
 * influence.c: which data each reaction of an answer depends on.
 *
 *   (IN1)  d r / d q_j = -E A^-1 R e_j                               vi/states_matrix.c
 *   (IN2)  all mu_c > 0 raised together: p = r_n t where a contact slips with u_t not 0, else 0;
 *          d r / d mu = p - E A^-1 R W p
 *
 * Cost: one factorisation and m + 1 solves. What can fail: A is singular.
 */
#include "facts/influence.h"

#include <stdlib.h>
#include <string.h>

#include "vi/states_matrix.h"

/* x (m) := -E A^-1 R v. y: scratch, m. */
static dls_status influence_of(const dlsi_states_matrix *A, const double *v, double *y, double *x,
                               dls_error *error) {
  const size_t m = (size_t)A->d * (size_t)A->nc;
  dlsi_branches_rows(A->d, A->nc, A->branch, v, y);
  const dls_status status = A->n ? dlsi_states_solve(A, 0, y, error) : DLS_OK;
  for (int k = 0; k < A->n; k++)
    y[k] = -y[k];
  memset(x, 0, m * sizeof *x);
  dlsi_branches_add_directions(A->d, A->nc, A->branch, y, x);
  return status;
}

/* v (m) := p of (IN2). */
static void influence_of_friction(const dls_contact *problem, const dlsi_branch *branch,
                                  const double *r, double *v) {
  const int d = problem->d;
  memset(v, 0, (size_t)d * (size_t)problem->nc * sizeof *v);
  for (int c = 0; c < problem->nc; c++)
    for (int i = 1; branch[c].state == DLS_SLIP && problem->mu[c] > 0 && i < d; i++)
      v[d * c + i] = r[d * c] * branch[c].t[i - 1];
}

dls_status dlsi_contact_influence(const dls_contact *problem, const double *r, double *w,
                                  double *dq, double *dmu, dls_error *error) {
  const size_t nc = (size_t)problem->nc, m = (size_t)problem->d * nc;
  dlsi_formed formed = {.work = NULL};
  dlsi_states_matrix *A = NULL;
  double *u = dlsi_alloc(3 * m, sizeof *u), *v = u ? u + m : NULL, *y = u ? v + m : NULL;
  dls_contact_state *state = dlsi_alloc(nc, sizeof *state);
  dls_status status = u && state ? DLS_OK : dlsi_no_memory(error);
  if (!status) status = dlsi_form_blocks(&formed, &problem, error);
  if (!status) dlsi_contact_weights(problem, w);
  if (!status) dlsi_contact_multiply(problem, NULL, r, u, NULL);
  if (!status) status = dls_contact_states(problem, r, u, state, error);
  if (!status) status = dlsi_states_create(&A, problem, error);
  if (!status) {
    A->n = dlsi_branches_set(problem, state, r, u, A->branch);
    if (A->n) status = dlsi_states_factor(A, problem, NULL, v, error);
  }
  for (size_t j = 0; !status && j < m; j++) {
    memset(v, 0, m * sizeof *v);
    v[j] = 1;
    status = influence_of(A, v, y, dq + j * m, error);
  }
  if (!status) {
    influence_of_friction(problem, A->branch, r, v);
    dlsi_contact_apply(problem, v, u);
    status = influence_of(A, u, y, dmu, error);
    for (size_t i = 0; i < m; i++)
      dmu[i] += v[i];
  }
  dlsi_states_destroy(A);
  dlsi_formed_free(&formed);
  free(state);
  free(u);
  return status;
}
