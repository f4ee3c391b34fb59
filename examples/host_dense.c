/*
 * host_dense.c: a finite element code passes its stiffness matrix and its contact operators,
 * and gets reactions and displacements back.
 *
 * Two nodes above an obstacle y <= 0, held by springs; unknowns (x0, y0, x1, y1); n = +y, t = +x.
 * Node 0 has an initial gap of 0.5, is pressed on hard and sticks; node 1 slides to the right.
 *
 * Output:
 *   candidate     u_n     u_t     r_n     r_t
 *   0           0.000   0.000  10.000  -1.000
 *   1           0.000   1.000   4.000  -2.000
 *   x = 0.000 -0.500 1.000 0.000
 */
#include <math.h>
#include <stdio.h>

#include "delassus/solve.h"

/* no "-0.000" */
static double tidy(double x) {
  return fabs(x) < 5e-4 ? 0 : x;
}

int main(void) {
  const double K[] = {3, 0, -1, 0, 0, 4, 0, 0, -1, 0, 4, 1, 0, 0, 1, 5};
  const double f[] = {0, -12, 6, -3}, g[] = {0.5, 0, 0, 0}, mu[] = {0.5, 0.5};
  /* column c of H_N picks y of node c, of H_T its x */
  const int p[] = {0, 1, 2}, normal[] = {1, 3}, tangent[] = {0, 2};
  const double one[] = {1, 1};
  const dls_model model = {.d = 2,
                           .n = 4,
                           .nodes = 2,
                           .operator_kind = DLS_STIFFNESS_DENSE,
                           .factorization = DLS_CHOLESKY,
                           .K = {4, 4, 4, K},
                           .HN = {4, 2, p, normal, one},
                           .HT = {4, 2, p, tangent, one}};
  dls_error error;
  double r[4], u[4], x[4];
  const dls_status status = dls_solve_model(&model, f, g, mu, r, u, x, NULL, &error);
  if (!dls_solved(status))
    return fprintf(stderr, "%s\n", status < 0 ? error.message : dls_status_text(status));
  printf("candidate     u_n     u_t     r_n     r_t\n");
  for (int c = 0; c < 2; c++)
    printf("%d         %7.3f %7.3f %7.3f %7.3f\n", c, tidy(u[2 * c]), tidy(u[2 * c + 1]),
           tidy(r[2 * c]), tidy(r[2 * c + 1]));
  printf("x = %.3f %.3f %.3f %.3f\n", tidy(x[0]), tidy(x[1]), tidy(x[2]), tidy(x[3]));
  return 0;
}
