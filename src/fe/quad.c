/*
 * quad.c: computes stiffness, mass and stress of a four-node element, linear elasticity in plane
 * strain, small strain, unit thickness; q4.c has the element of finite strain.
 *
 * With the corners (xi_a, eta_a) = (-1,-1), (1,-1), (1,1), (-1,1) of the square,
 *
 *   N_a = (1 + xi_a xi)(1 + eta_a eta) / 4,   x = sum of N_a x_a,   J = dx / d(xi, eta)       (QS1)
 *   K_ab = sum over 2 x 2 Gauss points of det J B_a^T D B_b, as (TR2) of t3.c                 (QS2)
 *   M_ab = sum over the same points of det J rho N_a N_b                                      (QS3)
 *
 * (QS3) is exact: N_a N_b det J has degree three in xi and in eta. All four points weigh 1.
 * What can fail: corners that are not convex, refused; nu -> 1/2, where the element locks.
 */
#include <float.h>
#include <math.h>
#include <string.h>

#include "fe_internal.h"

static const double quad_sign[4][2] = {{-1, -1}, {1, -1}, {1, 1}, {-1, 1}};

int dlsi_quad_is_flat(const dls_fe_mesh *mesh, int e) {
  const int *node = mesh->quad + 4 * (size_t)e;
  for (int k = 0; k < 4; k++) { /* det J is bilinear: its least value is at a corner */
    const double *a = mesh->xy + 2 * (size_t)node[k];
    const double *b = mesh->xy + 2 * (size_t)node[(k + 1) % 4];
    const double *d = mesh->xy + 2 * (size_t)node[(k + 3) % 4];
    const double p = b[0] - a[0], q = b[1] - a[1], r = d[0] - a[0], s = d[1] - a[1];
    if (!(p * s - q * r > DBL_EPSILON * (p * p + q * q + r * r + s * s))) return 1;
  }
  return 0;
}

/* Computes N_a, dN_a/dx and dN_a/dy (4 each) at (xi, eta), (QS1); returns det J. */
static double quad_shape(const dls_fe_mesh *mesh, int e, double xi, double eta, double N[4],
                         double b[4], double c[4]) {
  const int *node = mesh->quad + 4 * (size_t)e;
  double local[4][2], J[4] = {0};
  for (int a = 0; a < 4; a++) {
    const double *s = quad_sign[a], *x = mesh->xy + 2 * (size_t)node[a];
    N[a] = (1 + s[0] * xi) * (1 + s[1] * eta) / 4;
    local[a][0] = s[0] * (1 + s[1] * eta) / 4;
    local[a][1] = s[1] * (1 + s[0] * xi) / 4;
    for (int i = 0; i < 2; i++)
      for (int j = 0; j < 2; j++)
        J[i + 2 * j] += x[i] * local[a][j];
  }
  const double det = J[0] * J[3] - J[1] * J[2];
  for (int a = 0; a < 4; a++) {
    b[a] = (J[3] * local[a][0] - J[1] * local[a][1]) / det;
    c[a] = (J[0] * local[a][1] - J[2] * local[a][0]) / det;
  }
  return det;
}

static double quad_point(const dls_fe_mesh *mesh, int e, int point, double N[4], double b[4],
                         double c[4]) {
  const double at = 1 / sqrt(3);
  return quad_shape(mesh, e, at * quad_sign[point][0], at * quad_sign[point][1], N, b, c);
}

void dlsi_quad_stiffness(const dls_fe_mesh *mesh, int e, const dlsi_lame *D, double *k) {
  memset(k, 0, 64 * sizeof *k);
  for (int point = 0; point < 4; point++) {
    double N[4], b[4], c[4];
    const double det = quad_point(mesh, e, point, N, b, c);
    for (int j = 0; j < 4; j++)
      for (int i = 0; i < 4; i++) /* (QS2) */
        dlsi_add_elastic(D, det, b[i], c[i], b[j], c[j], k + 2 * i + 16 * j, 8);
  }
}

void dlsi_quad_mass(const dls_fe_mesh *mesh, int e, double rho, double *m) {
  memset(m, 0, 16 * sizeof *m);
  for (int point = 0; point < 4; point++) {
    double N[4], b[4], c[4];
    const double weight = rho * quad_point(mesh, e, point, N, b, c);
    for (int j = 0; j < 4; j++)
      for (int i = 0; i < 4; i++) /* (QS3) */
        m[i + 4 * j] += weight * (N[i] * N[j]);
  }
}

void dlsi_quad_stress(const dls_fe_mesh *mesh, int e, const dlsi_lame *D, const double *u,
                      double *s) {
  double N[4], b[4], c[4], xx = 0, yy = 0, xy2 = 0; /* e_xx, e_yy, 2 e_xy */
  (void)quad_shape(mesh, e, 0, 0, N, b, c);
  for (int a = 0; a < 4; a++) {
    const double *v = u + 2 * (size_t)mesh->quad[4 * (size_t)e + (size_t)a];
    xx += b[a] * v[0];
    yy += c[a] * v[1];
    xy2 += c[a] * v[0] + b[a] * v[1];
  }
  s[0] = (D->l + 2 * D->G) * xx + D->l * yy;
  s[1] = D->l * xx + (D->l + 2 * D->G) * yy;
  s[2] = D->G * xy2;
}
