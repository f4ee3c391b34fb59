/* cone.c: scales friction cones to Lorentz cones. */
#include "cone.h"

double dlsi_cone_scales(const dls_contact *problem, double *diagonal, double *S) {
  const int d = problem->d, nc = problem->nc;
  double unit = 0;
  for (int c = 0; c < nc; c++) {
    const double mu = problem->mu[c];
    double block[9], *D = S + d * c;
    dlsi_contact_diagonal(problem, c, block);
    diagonal[c] = 0;
    for (int i = 0; i < d; i++) {
      D[i] = i ? mu > 0 : mu > 0 ? 1 / mu : 1;
      diagonal[c] += D[i] * D[i] * block[i + d * i] / d;
    }
    unit = fmax(unit, diagonal[c]);
  }
  for (int i = 0; i < d * nc; i++)
    S[i] *= diagonal[i / d] > 0 ? sqrt(unit / diagonal[i / d]) : 1;
  return unit;
}
