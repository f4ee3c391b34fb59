/*
 * mortar.c: computes the contact operators between two lines of nodes that do not match.
 *
 * The products of hat functions of both lines are quadratic between neighbours among all nodes:
 * two Gauss points are exact there. A constant pressure thus gives both lines the nodal forces of
 * that pressure, and equal linear displacements of the lines give no jump: the patch test holds to
 * rounding. It does not hold if nodes of one line are tied to the edges of the other.
 * O(na nb) for zeroing, O(na + nb) for the integrals.
 */
#include <math.h>
#include <string.h>

#include "moving_internal.h"

/* Fills the values of the two hat functions of piece k of a line at x. */
static void mortar_hats(const double *line, int k, double x, double hat[2]) {
  hat[1] = (x - line[k]) / (line[k + 1] - line[k]);
  hat[0] = 1 - hat[1];
}

void dlsi_mortar_line(int na, const double *a, int nb, const double *b, double *A, double *B) {
  memset(A, 0, (size_t)na * (size_t)na * sizeof *A);
  memset(B, 0, (size_t)na * (size_t)nb * sizeof *B);
  double left = a[0];
  for (int i = 0, j = 0; i < na - 1 && j < nb - 1;) {
    const int ends_a = a[i + 1] <= b[j + 1];
    const double right = ends_a ? a[i + 1] : b[j + 1], half = (right - left) / 2;
    for (int point = 0; point < 2; point++) {
      const double x = left + half + (point ? half : -half) / sqrt(3);
      double s[2], m[2];
      mortar_hats(a, i, x, s);
      mortar_hats(b, j, x, m);
      for (int k = 0; k < 2; k++)
        for (int l = 0; l < 2; l++) {
          A[(i + k) * na + i + l] += half * s[k] * s[l];
          B[(i + k) * nb + j + l] += half * s[k] * m[l];
        }
    }
    left = right;
    j += b[j + 1] <= right;
    i += ends_a;
  }
  for (int i = 0; i < na; i++) {
    double w = 0;
    for (int j = 0; j < na; j++)
      w += A[i * na + j];
    for (int j = 0; j < na; j++)
      A[i * na + j] /= w;
    for (int j = 0; j < nb; j++)
      B[i * nb + j] /= w;
  }
}
