/*
 * face.c: the point of a face nearest to a given point, for edges (2D), T3 and Q4.
 *
 *   Q4: x(a, b) = (1-a)(1-b) X_0 + a (1-b) X_1 + a b X_2 + (1-a) b X_3; Newton's method on
 *       |P - x|^2 / 2, at most 30 steps. Its Hessian x_i . x_j - (P - x) . x_ij; without the second
 *       term where it is not definite
 *   inside of the face: that point; else the nearest point of its edges
 *
 * What can fail: a warped Q4 whose radius of curvature is less than the distance of P has more than
 * one such point.
 */
#include <math.h>
#include <string.h>

#include "geometry.h"

void dlsi_face_corners(const dlsi_faces *faces, int face, double C[4][3]) {
  const int d = faces->d;
  for (int k = 0; k < faces->corners; k++) {
    const size_t at = (size_t)faces->face[(size_t)faces->corners * (size_t)face + (size_t)k];
    for (int i = 0; i < 3; i++)
      C[k][i] = i < d ? faces->X[(size_t)d * (at - (size_t)faces->base) + (size_t)i] : 0;
  }
}

static double face_distance(const double a[3], const double b[3]) {
  const double v[3] = {a[0] - b[0], a[1] - b[1], a[2] - b[2]};
  return sqrt(dlsi_dot3(v, v));
}

double dlsi_face_size(int corners, double C[4][3]) {
  double size = 0;
  for (int k = 1; k < corners; k++)
    for (int l = 0; l < k; l++)
      size = fmax(size, face_distance(C[k], C[l]));
  return size;
}

/* n := the unit vector of a x b, or in 2D of a turned by -90 degrees; returns its length before. */
static double face_unit(int d, const double a[3], const double b[3], double n[3]) {
  if (d == 2) {
    n[0] = a[1];
    n[1] = -a[0];
    n[2] = 0;
  } else
    dlsi_cross3(a, b, n);
  const double length = sqrt(dlsi_dot3(n, n));
  for (int k = 0; k < 3; k++)
    n[k] /= length;
  return length;
}

int dlsi_face_normal(int d, int corners, double C[4][3], double n[3]) {
  const int last = corners - 1;
  double a[3], b[3];
  for (int k = 0; k < 3; k++) {
    a[k] = C[corners == 4 ? 2 : 1][k] - C[0][k];
    b[k] = C[last][k] - C[corners == 4 ? 1 : 0][k];
  }
  const double size = dlsi_face_size(corners, C);
  return face_unit(d, a, b, n) > 1e-12 * (d == 2 ? size : size * size);
}

/* Shape functions at (a, b), and the tangents there. */
static void face_shape(int corners, double C[4][3], double a, double b, double w[4],
                       double tangent[2][3]) {
  const double w3[4] = {1 - a - b, a, b},
               w4[4] = {(1 - a) * (1 - b), a * (1 - b), a * b, (1 - a) * b};
  const double a4[4] = {b - 1, 1 - b, b, -b}, b4[4] = {a - 1, -a, a, 1 - a};
  const double a3[4] = {-1, 1, 0}, b3[4] = {-1, 0, 1};
  memcpy(w, corners == 4 ? w4 : w3, sizeof w4);
  memset(tangent, 0, 6 * sizeof(double));
  for (int k = 0; k < corners; k++)
    for (int i = 0; i < 3; i++) {
      tangent[0][i] += (corners == 4 ? a4 : a3)[k] * C[k][i];
      tangent[1][i] += (corners == 4 ? b4 : b3)[k] * C[k][i];
    }
}

static void face_point(int corners, double C[4][3], const double w[4], double c[3]) {
  memset(c, 0, 3 * sizeof *c);
  for (int k = 0; k < corners; k++)
    for (int i = 0; i < 3; i++)
      c[i] += w[k] * C[k][i];
}

/* Newton's method on T3 and Q4; returns 1 with (a, b) if that converges within the face. */
static int face_inside(int corners, double C[4][3], const double P[3], double *a, double *b) {
  double twist[3] = {0};
  for (int i = 0; corners == 4 && i < 3; i++)
    twist[i] = C[0][i] - C[1][i] + C[2][i] - C[3][i];
  *a = *b = corners == 4 ? 1. / 2 : 1. / 3;
  for (int step = 0; step < 30; step++) {
    double w[4], x[3], t[2][3], v[3];
    face_shape(corners, C, *a, *b, w, t);
    face_point(corners, C, w, x);
    for (int i = 0; i < 3; i++)
      v[i] = P[i] - x[i];
    const double aa = dlsi_dot3(t[0], t[0]), bb = dlsi_dot3(t[1], t[1]);
    const double plain = dlsi_dot3(t[0], t[1]);
    double ab = plain - dlsi_dot3(v, twist);
    if (!(aa * bb - ab * ab > 0.01 * (aa * bb - plain * plain))) ab = plain;
    const double det = aa * bb - ab * ab;
    if (!(det > 0)) return 0;
    const double va = dlsi_dot3(v, t[0]), vb = dlsi_dot3(v, t[1]);
    const double da = (bb * va - ab * vb) / det, db = (aa * vb - ab * va) / det;
    *a += da;
    *b += db;
    if (!(fabs(*a) < 10 && fabs(*b) < 10)) return 0;
    if (corners == 3 || fabs(da) + fabs(db) < 1e-9) /* its square is left */
      return *a >= 0 && *b >= 0 && (corners == 4 ? *a <= 1 && *b <= 1 : *a + *b <= 1);
  }
  return 0;
}

void dlsi_face_nearest(int d, int corners, double C[4][3], const double P[3], double w[4],
                       double c[3], double n[3]) {
  static const double place[4][2] = {{0, 0}, {1, 0}, {1, 1}, {0, 1}},
                      place3[3][2] = {{0, 0}, {1, 0}, {0, 1}};
  double a = 0, b = 0, t[2][3];
  if (d == 2 || !face_inside(corners, C, P, &a, &b)) {
    double best = INFINITY;
    for (int k = 0; k < (d == 2 ? 1 : corners); k++) { /* the nearest point of the edges */
      const int l = (k + 1) % corners;
      double e[3], q[3], x[3];
      for (int i = 0; i < 3; i++) {
        e[i] = C[l][i] - C[k][i];
        q[i] = P[i] - C[k][i];
      }
      const double length = dlsi_dot3(e, e), along = length > 0 ? dlsi_dot3(e, q) / length : 0;
      const double s = along < 0 ? 0 : along > 1 ? 1 : along;
      for (int i = 0; i < 3; i++)
        x[i] = C[k][i] + s * e[i];
      const double distance = face_distance(x, P);
      if (!(distance < best)) continue;
      best = distance;
      const double *from = corners == 4 ? place[k] : place3[k],
                   *to = corners == 4 ? place[l] : place3[l];
      a = d == 2 ? s : from[0] + s * (to[0] - from[0]);
      b = d == 2 ? 0 : from[1] + s * (to[1] - from[1]);
    }
  }
  if (d == 2) {
    w[0] = 1 - a;
    w[1] = a;
    for (int i = 0; i < 3; i++)
      t[0][i] = t[1][i] = C[1][i] - C[0][i];
  } else
    face_shape(corners, C, a, b, w, t);
  face_point(corners, C, w, c);
  if (n && !(face_unit(d, t[0], t[1], n) > 0)) (void)dlsi_face_normal(d, corners, C, n);
}
