/*
 * iterate.c: the common part of all iterations on the reactions: a workspace in one piece, weights,
 * the certificate of the iterate, the best r so far, the limits, and the answer.
 */
#include <float.h>
#include <math.h>
#include <string.h>

#include "linear/blas.h"
#include "vi_internal.h"

/* Returns the error of r that its certificate allows, infinite for NaN. */
static double error_of(const dls_certificate *c) {
  const double rounding = 4 * c->floor_u;
  const double error = rounding > c->residual ? rounding : c->residual;
  return error <= DBL_MAX && rounding == rounding ? error : INFINITY;
}

int dlsi_is_better(const dls_certificate *a, const dls_certificate *b) {
  const double of_a = error_of(a), of_b = error_of(b);
  return of_a < of_b || (of_a == of_b && a->residual_u < b->residual_u);
}

/* ---- workspace ------------------------------------------------------------------------------- */

dls_status dlsi_workspace(void **out, void *filled, size_t size, dlsi_carve *carve, int nc,
                          dls_error *error) {
  const dls_status status = dlsi_check_blas(error);
  return status ? status : dlsi_carve_workspace(out, filled, size, carve, "nc", nc, error);
}

void dlsi_take_vectors(dlsi_arena *arena, size_t n, int count, double **const vector[]) {
  for (int k = 0; k < count; k++)
    *vector[k] = dlsi_take(arena, n, sizeof **vector[k]);
}

void dlsi_iterate_carve(dlsi_iterate *it, dlsi_arena *arena, int d, int nc,
                        const dls_limits *limits) {
  const size_t n = (size_t)nc;
  it->d = d;
  it->nc = nc;
  it->limits = limits;
  double **const vectors[] = {&it->u, &it->a, &it->F, &it->best};
  it->w = dlsi_take(arena, n, sizeof *it->w);
  it->weights = dlsi_take(arena, 2 * n, sizeof *it->weights);
  dlsi_take_vectors(arena, (size_t)d * n, 4, vectors);
}

/* ---- one solve ------------------------------------------------------------------------------- */

static size_t size_of(const dls_contact *problem) {
  return (size_t)problem->d * (size_t)problem->nc;
}

void dlsi_multiply(const dls_contact *problem, const int *order, const double *E, const double *r,
                   double *u, double *a) {
  const size_t d = (size_t)problem->d, m = size_of(problem);
  dlsi_contact_multiply(problem, order, r, u, a);
  for (size_t k = 0; E && k < m; k++) {
    u[k] += E[k / d] * r[k];
    if (a) a[k] += E[k / d] * fabs(r[k]);
  }
}

/* u := W r + q with the springs and, if a is not NULL, a := |W| |r| with them. */
static void iterate_multiply(const dlsi_iterate *it, const dls_contact *problem, const double *r,
                             double *u, double *a) {
  if (it->shared)
    it->shared->multiply(it->shared->data, r, u, a);
  else
    dlsi_multiply(problem, NULL, it->E, r, u, a);
}

void dlsi_iterate_begin(dlsi_iterate *it, const dls_contact *problem, const double *E, double tol,
                        int warm, const double *start, double *r) {
  const size_t m = size_of(problem);
  it->E = E;
  it->tol = tol;
  it->begun = dlsi_clock_start(it->limits);
  it->certificate = dlsi_no_certificate;
  it->rounded = 0;
  dlsi_both_weights(problem, it->w, it->weights);
  if (!warm || dlsi_max_abs(problem->q, m) == 0)
    memset(r, 0, m * sizeof *r);
  else if (r != start)
    memcpy(r, start, m * sizeof *r);
  memcpy(it->best, r, m * sizeof *r);
}

dls_certificate dlsi_iterate_measure(dlsi_iterate *it, const dls_contact *problem,
                                     const double *r) {
  dls_certificate now;
  iterate_multiply(it, problem, r, it->u, it->a);
  dlsi_contact_measure(problem, r, it->u, it->a, it->weights, it->F, &now);
  return now;
}

int dlsi_iterate_keep(dlsi_iterate *it, const dls_contact *problem, const double *r,
                      const dls_certificate *now) {
  const dls_status verdict = dlsi_certificate_verdict(now, it->tol);
  if (verdict == DLS_TO_ROUNDING) it->rounded++;
  if (verdict != DLS_OK && !dlsi_is_better(now, &it->certificate)) return 0;
  it->certificate = *now;
  memcpy(it->best, r, size_of(problem) * sizeof *r);
  return verdict == DLS_OK;
}

dls_certificate dlsi_iterate_offer(dlsi_iterate *it, const dls_contact *problem, const double *r) {
  const dls_certificate now = dlsi_iterate_measure(it, problem, r);
  (void)dlsi_iterate_keep(it, problem, r, &now);
  return now;
}

int dlsi_iterate_start(dlsi_iterate *it, const dls_contact *problem, double *r) {
  const dls_certificate now = dlsi_iterate_offer(it, problem, r);
  if (!(now.residual <= DBL_MAX && now.floor_u < 1)) { /* q is lost in the rounding of W r */
    memset(r, 0, size_of(problem) * sizeof *r);
    (void)dlsi_iterate_offer(it, problem, r);
  }
  return dlsi_certificate_holds(&it->certificate, it->tol);
}

dls_status dlsi_iterate_settle(dlsi_iterate *it, const dls_contact *problem, dls_status reason) {
  it->certificate = dlsi_iterate_measure(it, problem, it->best);
  return dlsi_settled(&it->certificate, it->tol, reason);
}

dls_status dlsi_iterate_end(dlsi_iterate *it, const dls_contact *problem, dls_status status,
                            dls_info *outcome, double *r, double *u, dls_info *info) {
  if (status < 0) return status;
  status = dlsi_settled(&it->certificate, it->tol, status);
  outcome->status = status;
  it->iterations = outcome->sweeps + outcome->iterations;
  outcome->certificate = it->certificate;
  memcpy(r, it->best, size_of(problem) * sizeof *r);
  if (u) iterate_multiply(it, problem, r, u, NULL);
  if (info) *info = *outcome;
  return status;
}
