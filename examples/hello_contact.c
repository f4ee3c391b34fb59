/*
 * hello_contact.c: the smallest contact problem, checked by hand.
 *
 * A block hangs on springs of 1000 N/m, one upright and one level. Without the floor it would come
 * to rest 2 mm below it and 3 mm to the right. The floor holds it up with r_n = 2 mm * 1000 N/m =
 * 2 N. To hold it in place as well would take 3 N; friction gives at most mu r_n = 1 N, so the
 * block slips, until the spring is left with 3 N - 1 N: u_t = 2 N / 1000 N/m = 2 mm.
 *
 * Output:
 *   solved: r_n = 2 N, r_t = -1 N
 *   u_n = 0 mm, u_t = 2 mm
 *   residual below 1e-8: yes
 */
#include <stdio.h>

#include "delassus/solve.h"

int main(void) {
  const double W[] = {1e-3, 0, 0, 1e-3}; /* m/N, column-major, order (n, t) */
  const double q[] = {-2e-3, 3e-3};      /* m, where the block would be without the floor */
  const double mu[] = {0.5};
  const dls_contact problem = {.d = 2, .nc = 1, .W = {2, 2, 2, W}, .q = q, .mu = mu};

  double r[2], u[2];
  dls_info info;
  dls_error error;
  const dls_status status = dls_solve(&problem, NULL, r, u, &info, &error);
  if (status < 0) {
    fprintf(stderr, "%s\n", error.message);
    return 1;
  }
  printf("%s: r_n = %.6g N, r_t = %.6g N\n", dls_status_text(status), r[0], r[1]);
  printf("u_n = %.6g mm, u_t = %.6g mm\n", 1e3 * u[0], 1e3 * u[1]);
  printf("residual below 1e-8: %s\n", info.certificate.residual <= 1e-8 ? "yes" : "no");
  return 0;
}
