/*
 * A linear complementarity problem by Lemke's method, and one without a solution with its proof.
 *
 * Output:
 *   solved: z = (1, 2), 2 exchanges
 *   no solution exists: v = (0, 1), violation 0
 */
#include <stdio.h>

#include "delassus.h"

int main(void) {
  /* y = M z + q, y >= 0, z >= 0, y^T z = 0; column-major */
  const double M[4] = {2, 1, 1, 2}, q[2] = {-4, -5};
  const dls_lcp lcp = {.n = 2, .M = {2, 2, 2, M}, .q = q};
  dls_lemke *lemke;
  dls_lemke_info info;
  dls_error error;
  double z[2];
  if (dls_lemke_create(&lemke, 2, NULL, &error)) {
    fprintf(stderr, "%s\n", error.message);
    return 1;
  }
  dls_status status = dls_lemke_solve(lemke, &lcp, z, NULL, &info, &error);
  if (status == DLS_OK) /* certified: residual from M, q and z alone is at most tol */
    printf("%s: z = (%g, %g), %d exchanges\n", dls_status_text(status), z[0], z[1],
           info.pivots + info.crash_rounds);

  /* y_2 = -z_1 - 2 can never be >= 0. The proof is a v >= 0 with M^T v <= 0 and q^T v < 0. */
  const double N[4] = {0, -1, 1, 0}, p[2] = {-1, -2};
  const dls_lcp impossible = {.n = 2, .M = {2, 2, 2, N}, .q = p};
  double v[2], violation;
  status = dls_lemke_solve(lemke, &impossible, z, NULL, &info, &error);
  if (status == DLS_NO_SOLUTION && dls_lemke_farkas(lemke, v, &error) == DLS_OK &&
      dls_lcp_check_farkas(&impossible, v, &violation, &error) == DLS_OK)
    printf("%s: v = (%g, %g), violation %g\n", dls_status_text(status), v[0], v[1], violation);
  dls_lemke_destroy(lemke);
  return 0;
}
