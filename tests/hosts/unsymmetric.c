#include "unsymmetric.h"

#include <delassus.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>

/* n unknowns in rows of `width`, coupled more to one side; node c: unknowns 20 c, 20 c + 1 */
enum { n = 2000, nc = 10, width = 40 };

int unsymmetric_wrong(void) {
  static int p[n + 1], i[5 * n], each[nc + 1], normal[nc], tangent[nc];
  static double K[5 * n], one[nc], f[n], mu[nc], r[2 * nc], x[n], left[n];
  for (int j = 0, k = 0; j < n; j++) {
    const int neighbours[] = {-width, -1, 0, 1, width};
    for (int s = 0; s < 5; s++) {
      const int row = j + neighbours[s];
      if (row < 0 || row >= n) continue;
      i[k] = row;
      K[k++] = s == 2 ? 4 : s < 2 ? -0.9 : -0.8;
    }
    p[j + 1] = k;
    f[j] = left[j] = -1;
  }
  for (int c = 0; c < nc; c++) {
    each[c + 1] = c + 1;
    normal[c] = 20 * c;
    tangent[c] = 20 * c + 1;
    one[c] = 1;
    mu[c] = 0.3;
  }
  const dls_model model = {.d = 2,
                           .n = n,
                           .nodes = nc,
                           .operator_kind = DLS_STIFFNESS_SPARSE,
                           .factorization = DLS_LU,
                           .Ks = {n, n, p, i, K},
                           .HN = {n, nc, each, normal, one},
                           .HT = {n, nc, each, tangent, one}};
  dls_reduction *reduction;
  dls_error error = {0};
  dls_status status = dls_reduction_create(&reduction, &model, NULL, &error);
  if (!status) status = dls_reduction_load(reduction, f, NULL, &error);
  if (!status) status = dls_reduction_solve(reduction, mu, NULL, r, NULL, x, NULL, &error);
  dls_reduction_destroy(reduction);
  for (int c = 0; c < nc; c++) {
    left[normal[c]] += r[2 * c];
    left[tangent[c]] += r[2 * c + 1];
  }
  double most = 0;
  for (int j = 0; j < n; j++)
    for (int k = p[j]; k < p[j + 1]; k++)
      left[i[k]] -= K[k] * x[j];
  for (int j = 0; j < n; j++)
    if (!(fabs(left[j]) <= most)) most = fabs(left[j]);
  const int wrong = status != DLS_OK || !(r[0] > 0) || !(most <= 1e-10);
  if (wrong)
    printf("delassus: %s %s, |K x - f - H r| = %g\n", dls_status_text(status), error.message, most);
  return wrong;
}
