/*
 * t3.c: computes stiffness, mass and stress of a three-node triangle, linear elasticity in plane
 * strain, unit thickness.
 *
 * On a triangle (1, 2, 3) of area A the hat function of node i has the constant gradient
 *
 *   (dN_i/dx, dN_i/dy) = (b_i, c_i) / 2A,   b_i = y_j - y_k,  c_i = x_k - x_j                 (TR1)
 *   2A = b_1 c_2 - b_2 c_1,                 (i, j, k) in cyclic order
 *
 * Strain and stress are constant: with e = (e_xx, e_yy, 2 e_xy) = B u,
 *
 *   s = D e,   D = ( l+2G  l     0 )        G = E / 2(1+nu),  l = E nu / (1+nu)(1-2nu)        (TR2)
 *                  ( l     l+2G  0 )
 *                  ( 0     0     G )
 *   K = sum of A B^T D B, whose 2 x 2 block of nodes (i, j) is 1/4A times                     (TR3)
 *
 *     ( (l+2G) b_i b_j + G c_i c_j     l b_i c_j + G c_i b_j      )
 *     ( l c_i b_j + G b_i c_j          (l+2G) c_i c_j + G b_i b_j )
 *
 *   M_ij = rho A/12 (1 + delta_ij)                                                            (TR4)
 *
 * What can fail: flat or clockwise triangles, refused; nu -> 1/2, where l grows without bound and
 * the triangle locks.
 */
#include <float.h>
#include <string.h>

#include "fe_internal.h"

/* Fills b and c of (TR1), 3 each; returns 2A. */
static double t3_gradients(const dls_fe_mesh *mesh, int triangle, double b[3], double c[3]) {
  const int *node = mesh->node + 3 * (size_t)triangle;
  for (int i = 0; i < 3; i++) {
    const double *J = mesh->xy + 2 * (size_t)node[(i + 1) % 3];
    const double *K = mesh->xy + 2 * (size_t)node[(i + 2) % 3];
    b[i] = J[1] - K[1];
    c[i] = K[0] - J[0];
  }
  return b[0] * c[1] - b[1] * c[0];
}

int dlsi_t3_is_flat(const dls_fe_mesh *mesh, int e) {
  double b[3], c[3], edges = 0;
  const double area2 = t3_gradients(mesh, e, b, c);
  for (int i = 0; i < 3; i++)
    edges += b[i] * b[i] + c[i] * c[i];
  return !(area2 > DBL_EPSILON * edges);
}

void dlsi_t3_stiffness(const dls_fe_mesh *mesh, int e, const dlsi_lame *D, double *k) {
  double b[3], c[3];
  const double factor = 1 / (2 * t3_gradients(mesh, e, b, c)); /* 1/4A */
  memset(k, 0, 36 * sizeof *k);
  for (int j = 0; j < 3; j++)
    for (int i = 0; i < 3; i++) /* (TR3) */
      dlsi_add_elastic(D, factor, b[i], c[i], b[j], c[j], k + 2 * i + 12 * j, 6);
}

void dlsi_t3_mass(const dls_fe_mesh *mesh, int e, double rho, double *m) {
  double b[3], c[3];
  const double part = rho * t3_gradients(mesh, e, b, c) / 24;
  for (int k = 0; k < 9; k++) /* (TR4) */
    m[k] = k % 4 == 0 ? 2 * part : part;
}

void dlsi_t3_stress(const dls_fe_mesh *mesh, int e, const dlsi_lame *D, const double *u,
                    double *s) {
  double b[3], c[3], xx = 0, yy = 0, xy2 = 0; /* e_xx, e_yy, 2 e_xy, each times 2A */
  const double area2 = t3_gradients(mesh, e, b, c);
  for (int i = 0; i < 3; i++) {
    const double *v = u + 2 * (size_t)mesh->node[3 * (size_t)e + (size_t)i];
    xx += b[i] * v[0];
    yy += c[i] * v[1];
    xy2 += c[i] * v[0] + b[i] * v[1];
  }
  s[0] = ((D->l + 2 * D->G) * xx + D->l * yy) / area2; /* (TR2) */
  s[1] = (D->l * xx + (D->l + 2 * D->G) * yy) / area2;
  s[2] = D->G * xy2 / area2;
}
