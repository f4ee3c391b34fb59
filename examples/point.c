/*
 * point.c: K, H, f, mu -> r, x, the program of README.md and docs/tour.md. A point (x, y) on
 * springs is pushed onto the floor y = 0 and slides to the right.
 *
 * Output:
 *   solved: r_n = 10.9375, r_t = -2.1875, x = 0.9375
 */
#include <delassus.h>
#include <stdio.h>

int main(void) {
  const double K[] = {3, 1, 1, 2}, f[] = {5, -10}, mu[] = {0.2}, one[] = {1};
  const int p[] = {0, 1}, along[] = {0}, up[] = {1}; /* H_N picks y, H_T picks x */
  dls_model model = {.d = 2, .n = 2, .nodes = 1, .K = {2, 2, 2, K}, .factorization = DLS_CHOLESKY};
  model.operator_kind = DLS_STIFFNESS_DENSE;
  model.HN = (dls_sparse){2, 1, p, up, one};
  model.HT = (dls_sparse){2, 1, p, along, one};
  double r[2], x[2];
  dls_error error;
  const dls_status status = dls_solve_model(&model, f, NULL, mu, r, NULL, x, NULL, &error);
  if (status < 0) return fprintf(stderr, "%s\n", error.message);
  printf("%s: r_n = %g, r_t = %g, x = %g\n", dls_status_text(status), r[0], r[1], x[0]);
  return 0;
}
