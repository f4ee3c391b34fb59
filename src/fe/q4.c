/*
 * q4.c: computes forces and tangent of the four-node element at finite strain, standard and Q4/P0,
 * plane strain and axisymmetric.
 *
 * At the 2 x 2 Gauss points, with dV the element of initial volume (axisymmetric: 2 pi taken out),
 *
 *   F = sum of x_a (dN_a/dX)^T,   F_33 = 1, or r / R                                         (QF1)
 *   B:  (d11, d22, d33, 2 d12) of the current gradients g_a = F^-T dN_a/dX, hoop N_a / r     (QF2)
 *   f = sum of B^T tau dV,   tau = J p 1 + s                                                 (QF3)
 *
 * Standard element: p = U'(J) at the point. Q4/P0 ([Chabrand 1998] end of section 2) has the fields
 * displacement, pressure and dilatation; eliminating pressure and dilatation, which are constant in
 * the element, leaves
 *
 *   p = U'(T),   T = (sum of J dV) / V                                                       (QF4)
 *
 * while s belongs to the point's own isochoric F. Tangent, with the material's tangent c of s and
 * the row of the divergence D = (1, 1, 1, 0) B,
 *
 *   K = sum of ( B^T (c + J p (1x1 - 2 I)) B + g_a.tau g_b 1 + hoop ) dV                     (QF5)
 *     + U'' h h^T / V,   h = sum of J D dV;   standard: U'' J^2 D D^T dV of each point       (QF6)
 *
 * Cost: 4 points, 2 x 8 x 4 x 8 operations each. What can fail: J <= 0 at a point.
 */
#include <math.h>
#include <string.h>

#include "solid.h"

typedef struct gauss {
  double F[5], J, dV;
  double g[4][2]; /* current gradients */
  double hoop[4]; /* N_a / r, plane strain: 0 */
} gauss;

/* Fills *p by (QF1), (QF2); returns 0 if the element is inside out, at rest or now. */
static int q4_kinematics(const dlsi_q4 *e, int point, gauss *p) {
  static const double sign[4][2] = {{-1, -1}, {1, -1}, {1, 1}, {-1, 1}};
  const double at = 1 / sqrt(3), xi = at * sign[point][0], eta = at * sign[point][1];
  double N[4], local[4][2], rest[4] = {0}, R = 0, r = 0;
  for (int a = 0; a < 4; a++) {
    N[a] = (1 + sign[a][0] * xi) * (1 + sign[a][1] * eta) / 4;
    local[a][0] = sign[a][0] * (1 + sign[a][1] * eta) / 4;
    local[a][1] = sign[a][1] * (1 + sign[a][0] * xi) / 4;
    for (int i = 0; i < 2; i++)
      for (int j = 0; j < 2; j++)
        rest[i + 2 * j] += e->X[2 * a + i] * local[a][j];
    R += N[a] * e->X[2 * a];
    r += N[a] * e->x[2 * a];
  }
  const double area = rest[0] * rest[3] - rest[1] * rest[2];
  double G[4][2], *F = p->F; /* G: gradients at rest */
  memset(F, 0, sizeof p->F);
  for (int a = 0; a < 4; a++) {
    G[a][0] = (rest[3] * local[a][0] - rest[1] * local[a][1]) / area;
    G[a][1] = (rest[0] * local[a][1] - rest[2] * local[a][0]) / area;
    for (int i = 0; i < 2; i++)
      for (int j = 0; j < 2; j++)
        F[2 * i + j] += e->x[2 * a + i] * G[a][j];
  }
  F[4] = e->axisymmetric ? r / R : 1;
  const double det = F[0] * F[3] - F[1] * F[2];
  p->J = det * F[4];
  p->dV = e->axisymmetric ? area * R : area;
  for (int a = 0; a < 4; a++) {
    p->g[a][0] = (F[3] * G[a][0] - F[2] * G[a][1]) / det;
    p->g[a][1] = (F[0] * G[a][1] - F[1] * G[a][0]) / det;
    p->hoop[a] = e->axisymmetric ? N[a] / r : 0;
  }
  return area > 0 && det > 0 && F[4] > 0 && isfinite(p->J);
}

/* b := the column of B of corner a, component i. */
static void q4_strain(const gauss *p, int a, int i, double b[4]) {
  b[0] = i == 0 ? p->g[a][0] : 0;
  b[1] = i == 1 ? p->g[a][1] : 0;
  b[2] = i == 0 ? p->hoop[a] : 0;
  b[3] = p->g[a][1 - i];
}

/* K += (QF5) of a point; c: in, the material's tangent; out, scratch. */
static void q4_stiffen(const gauss *p, const double tau[4], double pressure, double *c, double *K) {
  static const double one[4] = {1, 1, 1, 0}, identity[4] = {1, 1, 1, 0.5};
  for (int j = 0; j < 4; j++)
    for (int i = 0; i < 4; i++)
      c[i + 4 * j] += p->J * pressure * (one[i] * one[j] - (i == j ? 2 * identity[i] : 0));
  double B[8][4];
  for (int k = 0; k < 8; k++)
    q4_strain(p, k / 2, k % 2, B[k]);
  for (int l = 0; l < 8; l++) {
    double v[4];
    for (int i = 0; i < 4; i++)
      v[i] =
          p->dV * (c[i] * B[l][0] + c[i + 4] * B[l][1] + c[i + 8] * B[l][2] + c[i + 12] * B[l][3]);
    for (int k = 0; k < 8; k++)
      K[k + 8 * l] += B[k][0] * v[0] + B[k][1] * v[1] + B[k][2] * v[2] + B[k][3] * v[3];
  }
  for (int b = 0; b < 4; b++)
    for (int a = 0; a < 4; a++) {
      const double *g = p->g[a], *h = p->g[b];
      const double geometric =
          p->dV * (g[0] * (tau[0] * h[0] + tau[3] * h[1]) + g[1] * (tau[3] * h[0] + tau[1] * h[1]));
      K[2 * a + 16 * b] += geometric + p->dV * tau[2] * p->hoop[a] * p->hoop[b];
      K[2 * a + 1 + 8 * (2 * b + 1)] += geometric;
    }
}

/* K += factor h h^T, (QF6) */
static void q4_add_square(const double h[8], double factor, double *K) {
  for (int l = 0; l < 8; l++)
    for (int k = 0; k < 8; k++)
      K[k + 8 * l] += factor * h[k] * h[l];
}

int dlsi_q4_forces(const dlsi_q4 *e, const dlsi_solid *solid, const dlsi_point *old,
                   dlsi_point *now, double *f, double *K, double energy[2], double *stress) {
  gauss point[4];
  double V = 0, v = 0, p, slope, h[8] = {0};
  for (int q = 0; q < 4; q++) {
    if (!q4_kinematics(e, q, &point[q])) return 0;
    V += point[q].dV;
    v += point[q].J * point[q].dV;
  }
  const double U = dlsi_solid_volume(solid, v / V, &p, &slope); /* (QF4) */
  energy[0] = e->full ? 0 : U * V;
  energy[1] = 0;
  memset(f, 0, 8 * sizeof *f);
  if (K) memset(K, 0, 64 * sizeof *K);
  for (int q = 0; q < 4; q++) {
    const gauss *g = &point[q];
    double tau[4], c[16] = {0}, D[8];
    if (!dlsi_solid_update(solid, g->F, g->J, &old[q], &now[q], tau, K ? c : NULL)) return 0;
    if (e->full) energy[0] += g->dV * dlsi_solid_volume(solid, g->J, &p, &slope);
    energy[0] += g->dV * now[q].elastic;
    energy[1] += g->dV * now[q].plastic;
    for (int i = 0; i < 3; i++)
      tau[i] += g->J * p;
    for (int i = 0; stress && i < 4; i++)
      stress[4 * q + i] = tau[i] / g->J;
    for (int k = 0; k < 8; k++) {
      double b[4];
      q4_strain(g, k / 2, k % 2, b);
      f[k] += g->dV * (b[0] * tau[0] + b[1] * tau[1] + b[2] * tau[2] + b[3] * tau[3]); /* (QF3) */
      D[k] = g->J * (b[0] + b[1] + b[2]);
      h[k] += g->dV * D[k];
    }
    if (!K) continue;
    q4_stiffen(g, tau, p, c, K);
    if (e->full) q4_add_square(D, slope * g->dV, K);
  }
  if (K && !e->full) q4_add_square(h, slope / V, K);
  return 1;
}
