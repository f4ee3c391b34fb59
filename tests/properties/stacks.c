/*
 * stacks.c: calls the function of the library that solves the stacks of bodies.c.
 */
#include "bodies.h"
#include "delassus/global.h"

dls_status stack_solve_global(void *user, const stack *s, double tol, double *x, double *r) {
  (void)user;
  dls_global *global = NULL;
  const dls_limits limits = {.tol = tol, .threads = 1};
  const dls_model model = {.d = 2,
                           .n = s->n,
                           .nodes = s->nc,
                           .operator_kind = DLS_STIFFNESS_SPARSE,
                           .factorization = DLS_CHOLESKY,
                           .Ks = s->K,
                           .HN = s->HN,
                           .HT = s->HT,
                           .mu = s->mu};
  dls_status status = dls_global_create(&global, &model, NULL);
  if (!status) status = dls_global_solve(global, s->f, NULL, s->mu, &limits, r, x, NULL, NULL);
  dls_global_destroy(global);
  return status;
}
