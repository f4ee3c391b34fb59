/* half_space.c: implements half_space.h. */
#include "half_space.h"

#include <math.h>
#include <string.h>

static const double pi = 3.14159265358979;

static double log_integral(double x) {
  return x * log(fabs(x)) - x;
}

dls_contact half_plane(double *W, double *q, double *mu, int nc, double depth, double push,
                       double crown, double friction) {
  const double h = 2. / nc, across = 0.3 / 0.7 * acos(0);
  const int m = 2 * nc;
  for (int b = 0; b < nc; b++) {
    for (int a = 0; a < nc; a++) {
      const double x = (a - b) * h;
      const double along = depth - (log_integral(x + h / 2) - log_integral(x - h / 2)) / h;
      const double side = a > b ? across : a < b ? -across : 0;
      double *block = W + 2 * a + (size_t)m * (size_t)(2 * b);
      block[0] = block[m + 1] = along;
      block[1] = -side;
      block[m] = side;
    }
    const double x = (b - 0.5 * (nc - 1)) * h;
    q[2 * b] = -1 + crown * x * x;
    q[2 * b + 1] = push;
    mu[b] = friction;
  }
  return (dls_contact){.d = 2, .nc = nc, .W = {m, m, m, W}, .q = q, .mu = mu};
}

/* B (3 x 3) := the block of two points at (x, y) from each other, columns by a normal and two
 * tangential forces. */
static void half_space_block(double x, double y, double a, double *B) {
  const double nu = 0.3, k = 1 / (2 * pi), r2 = x * x + y * y, r = sqrt(r2);
  memset(B, 0, 9 * sizeof *B);
  if (r == 0) {
    B[0] = k * (1 - nu) * 3.5255 / a;
    B[4] = B[8] = k * (1 - nu / 2) * 3.5255 / a;
    return;
  }
  B[0] = k * (1 - nu) / r;
  B[4] = k * ((1 - nu) / r + nu * x * x / (r * r2));
  B[8] = k * ((1 - nu) / r + nu * y * y / (r * r2));
  B[5] = B[7] = k * nu * x * y / (r * r2);
  B[1] = -k * (1 - 2 * nu) / 2 * x / r2;
  B[2] = -k * (1 - 2 * nu) / 2 * y / r2;
  B[3] = -B[1];
  B[6] = -B[2];
}

void half_space(int nc, const double *at, double a, double *W) {
  for (int j = 0; j < nc; j++)
    for (int i = 0; i < nc; i++) {
      double B[9];
      half_space_block(at[2 * i] - at[2 * j], at[2 * i + 1] - at[2 * j + 1], a, B);
      for (int k = 0; k < 9; k++)
        W[(size_t)(3 * i + k % 3) + (size_t)(3 * nc) * (size_t)(3 * j + k / 3)] = B[k];
    }
}
