/*
 * t3.c: computes stiffness, edge loads and stress of three-node triangles, linear elasticity in
 * plane strain, unit thickness.
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
 * K is symmetric to the last bit: (TR3) multiplies by l and G after the symmetric products, and the
 * blocks (i, j) and (j, i) add up over the triangles in the same order.
 * What can fail: flat or clockwise triangles, refused; nu -> 1/2, where l grows without bound and
 * the triangle locks.
 */
#include <float.h>
#include <math.h>
#include <string.h>

#include "fe_internal.h"

typedef struct lame {
  double l, G;
} lame;

static lame t3_moduli(double E, double nu) { /* (TR2) */
  return (lame){.l = E * nu / ((1 + nu) * (1 - 2 * nu)), .G = E / (2 * (1 + nu))};
}

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

/* Checks the mesh, that the area of every triangle is above the rounding of its coordinates, and
 * the material. */
dls_status dlsi_fe_check_elastic(const dls_fe_mesh *mesh, double E, double nu, dls_error *error) {
  const dls_status status = dlsi_fe_check_mesh(mesh, error);
  if (status) return status;
  for (int e = 0; e < mesh->triangles; e++) {
    double b[3], c[3], edges = 0;
    const double area2 = t3_gradients(mesh, e, b, c);
    for (int i = 0; i < 3; i++)
      edges += b[i] * b[i] + c[i] * c[i];
    if (!(area2 > DBL_EPSILON * edges))
      return dlsi_fail(error, DLS_E_ARGUMENT, "node", 3LL * e, area2 / 2,
                       "triangle %d is flat or clockwise", e);
  }
  const dlsi_setting material[] = {{"E", E, 0, DBL_MAX, 1}, {"nu", nu, -1, 0.5, 1}};
  return dlsi_check_each(2, material, error);
}

/* Checks the arguments of dls_fe_stiffness. */
static dls_status stiffness_check(const dls_fe_mesh *mesh, double E, double nu, const double *K,
                                  int ldk, dls_error *error) {
  const dls_status status = dlsi_fe_check_elastic(mesh, E, nu, error);
  if (status) return status;
  if (!K) return dlsi_is_null(error, "K");
  const int n = 2 * mesh->nodes;
  return ldk >= n
             ? DLS_OK
             : dlsi_fail(error, DLS_E_SIZE, "ldk", -1, ldk, "is %d, must be at least %d", ldk, n);
}

void dlsi_fe_triangle(const dls_fe_mesh *mesh, int triangle, double E, double nu, double k[36]) {
  const lame D = t3_moduli(E, nu);
  double b[3], c[3];
  const double s = 1 / (2 * t3_gradients(mesh, triangle, b, c)); /* 1/4A */
  for (int j = 0; j < 3; j++)
    for (int i = 0; i < 3; i++) { /* (TR3) */
      double *kij = k + 2 * i + 6 * (2 * j);
      const double bb = b[i] * b[j], bc = b[i] * c[j], cb = c[i] * b[j], cc = c[i] * c[j];
      kij[0] = s * ((D.l + 2 * D.G) * bb + D.G * cc);
      kij[1] = s * (D.l * cb + D.G * bc);
      kij[6] = s * (D.l * bc + D.G * cb);
      kij[7] = s * ((D.l + 2 * D.G) * cc + D.G * bb);
    }
}

dls_status dls_fe_stiffness(const dls_fe_mesh *mesh, double E, double nu, double *K, int ldk,
                            dls_error *error) {
  const dls_status status = stiffness_check(mesh, E, nu, K, ldk, error);
  if (status) return dlsi_at(__func__, status, error);
  const int n = 2 * mesh->nodes;
  const size_t ld = (size_t)ldk;
  for (int j = 0; j < n; j++)
    memset(K + (size_t)j * ld, 0, (size_t)n * sizeof *K);
  for (int e = 0; e < mesh->triangles; e++) {
    const int *node = mesh->node + 3 * (size_t)e;
    double k[36];
    dlsi_fe_triangle(mesh, e, E, nu, k);
    for (int j = 0; j < 6; j++)
      for (int i = 0; i < 6; i++)
        K[2 * (size_t)node[i / 2] + (size_t)(i % 2) +
          (2 * (size_t)node[j / 2] + (size_t)(j % 2)) * ld] += k[i + 6 * j];
  }
  return DLS_OK;
}

/* Checks the arguments of dls_fe_edge_load, which is called edge by edge: it looks at the two
 * nodes, not at the whole mesh. *half := half of the edge's length. */
static dls_status edge_check(const dls_fe_mesh *mesh, int a, int b, double tx, double ty,
                             const double *f, double *half, dls_error *error) {
  if (!mesh) return dlsi_is_null(error, "mesh");
  if (!mesh->xy) return dlsi_is_null(error, "xy");
  if (a < 0 || a >= mesh->nodes)
    return dlsi_fail(error, DLS_E_ARGUMENT, "a", -1, a, "is %d, no node of the mesh", a);
  if (b < 0 || b >= mesh->nodes || b == a)
    return dlsi_fail(error, DLS_E_ARGUMENT, "b", -1, b, "is %d, no other node", b);
  if (!isfinite(tx)) return dlsi_fail(error, DLS_E_NOT_FINITE, "tx", -1, tx, "is not finite");
  if (!isfinite(ty)) return dlsi_fail(error, DLS_E_NOT_FINITE, "ty", -1, ty, "is not finite");
  if (!f) return dlsi_is_null(error, "f");
  const double *A = mesh->xy + 2 * (size_t)a, *B = mesh->xy + 2 * (size_t)b;
  *half = hypot(B[0] - A[0], B[1] - A[1]) / 2;
  if (isfinite(*half)) return DLS_OK;
  return dlsi_fail(error, DLS_E_NOT_FINITE, "xy", 2LL * (isfinite(A[0] + A[1]) ? b : a), *half,
                   "edge of no finite length");
}

dls_status dls_fe_edge_load(const dls_fe_mesh *mesh, int a, int b, double tx, double ty, double *f,
                            dls_error *error) {
  double half = 0;
  const dls_status status = edge_check(mesh, a, b, tx, ty, f, &half, error);
  if (status) return dlsi_at(__func__, status, error);
  f[2 * (size_t)a] += half * tx;
  f[2 * (size_t)a + 1] += half * ty;
  f[2 * (size_t)b] += half * tx;
  f[2 * (size_t)b + 1] += half * ty;
  return DLS_OK;
}

dls_status dls_fe_stress(const dls_fe_mesh *mesh, double E, double nu, const double *displacement,
                         double *stress, dls_error *error) {
  dls_status status = dlsi_fe_check_elastic(mesh, E, nu, error);
  if (!status)
    status = dlsi_check_vector("displacement", displacement, 2 * (size_t)mesh->nodes, error);
  if (!status && !stress) status = dlsi_is_null(error, "stress");
  if (status) return dlsi_at(__func__, status, error);
  const lame D = t3_moduli(E, nu);
  for (int e = 0; e < mesh->triangles; e++) {
    double b[3], c[3], xx = 0, yy = 0, xy2 = 0; /* e_xx, e_yy, 2 e_xy, each times 2A */
    const double area2 = t3_gradients(mesh, e, b, c);
    for (int i = 0; i < 3; i++) {
      const double *u = displacement + 2 * (size_t)mesh->node[3 * (size_t)e + (size_t)i];
      xx += b[i] * u[0];
      yy += c[i] * u[1];
      xy2 += c[i] * u[0] + b[i] * u[1];
    }
    double *s = stress + 3 * (size_t)e; /* (TR2) */
    s[0] = ((D.l + 2 * D.G) * xx + D.l * yy) / area2;
    s[1] = (D.l * xx + (D.l + 2 * D.G) * yy) / area2;
    s[2] = D.G * xy2 / area2;
  }
  return DLS_OK;
}
