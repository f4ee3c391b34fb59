/*
 * host_solver.c: the host lends its own factorisation (here L D L^T of a tridiagonal K) through a
 * callback; two loads on it. The two nodes of host_dense.c, unknowns (y0, x0, x1, y1): node 0
 * sticks under both loads, node 1 slides to the right under the first, left under the second.
 *
 * Output:
 *   r = 10.000 -1.000 4.000 -2.000, y0 = -0.500, x1 = 1.000
 *   r = 10.000 1.000 4.000 2.000, y0 = -0.500, x1 = -1.000
 */
#include <stdio.h>

#include "delassus/solve.h"

typedef struct tridiagonal {
  double d[4], l[4]; /* D; l[i] = L(i, i-1) */
} tridiagonal;

static int solve(void *user, double *X, int n, int nrhs) {
  const tridiagonal *T = user;
  for (double *x = X; nrhs-- > 0; x += n) {
    for (int i = 1; i < n; i++)
      x[i] -= T->l[i] * x[i - 1];
    for (int i = n - 1; i >= 0; i--)
      x[i] = x[i] / T->d[i] - (i < n - 1 ? T->l[i + 1] * x[i + 1] : 0);
  }
  return 0;
}

int main(void) {
  const double diagonal[] = {4, 3, 4, 5}, below[] = {0, 0, -1, 1}; /* below[i] = K(i, i-1) */
  const double f[2][4] = {{-12, 0, 6, -3}, {-12, 0, -6, -5}}, g[] = {0.5, 0, 0, 0};
  const double mu[] = {0.5, 0.5}, one[] = {1, 1};
  const int p[] = {0, 1, 2}, normal[] = {0, 3}, tangent[] = {1, 2};
  tridiagonal T = {{diagonal[0]}, {0}};
  for (int i = 1; i < 4; i++) {
    T.l[i] = below[i] / T.d[i - 1];
    T.d[i] = diagonal[i] - T.l[i] * below[i];
  }
  dls_model model = {.d = 2, .n = 4, .nodes = 2, .operator_kind = DLS_HOST_SOLVER, .user = &T};
  model.solve = solve;
  model.HN = (dls_sparse){4, 2, p, normal, one};
  model.HT = (dls_sparse){4, 2, p, tangent, one};
  dls_error error;
  dls_reduction *reduction;
  double r[4], x[4];
  dls_status status = dls_reduction_create(&reduction, &model, NULL, &error);
  for (int k = 0; dls_solved(status) && k < 2; k++) {
    status = dls_reduction_load(reduction, f[k], g, &error);
    if (!status) status = dls_reduction_solve(reduction, mu, NULL, r, NULL, x, NULL, &error);
    if (dls_solved(status))
      printf("r = %.3f %.3f %.3f %.3f, y0 = %.3f, x1 = %.3f\n", r[0], r[1], r[2], r[3], x[0], x[2]);
  }
  dls_reduction_destroy(reduction);
  if (dls_solved(status)) return 0;
  fprintf(stderr, "%s\n", status < 0 ? error.message : dls_status_text(status));
  return 1;
}
