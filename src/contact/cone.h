/*
 * cone.h: the algebra of the Lorentz cone { x : x_0 >= |x_1| } of one contact, d = 2 or 3.
 *
 *   x o y = (x.y, x_0 y_1 + y_0 x_1)
 *   P = eta [w_0, w_1'; w_1, I + w_1 w_1' / (1 + w_0)]: the symmetric scaling of Nesterov and Todd
 *   with P x = P^-1 z for x and z inside of the cone
 *
 * Source: Alizadeh and Goldfarb, Math. Program. 95, 2003, 3-51.
 */
#ifndef DLSI_BASE_CONE_H
#define DLSI_BASE_CONE_H

#include "contact.h"

/* Returns x_0^2 - |x_1|^2. */
static inline double dlsi_cone_det(int d, const double *x) {
  const double t = dlsi_tangent_norm(d, x);
  return (x[0] - t) * (x[0] + t);
}

/* Returns x.y. */
static inline double dlsi_cone_dot(int d, const double *x, const double *y) {
  double sum = 0;
  for (int i = 0; i < d; i++)
    sum += x[i] * y[i];
  return sum;
}

/* z := x o y */
static inline void dlsi_cone_product(int d, const double *x, const double *y, double *z) {
  z[0] = dlsi_cone_dot(d, x, y);
  for (int i = 1; i < d; i++)
    z[i] = x[0] * y[i] + y[0] * x[i];
}

/* y := the solution of x o y = v */
static inline void dlsi_cone_divide(int d, const double *x, const double *v, double *y) {
  double sum = x[0] * v[0];
  for (int i = 1; i < d; i++)
    sum -= x[i] * v[i];
  y[0] = sum / dlsi_cone_det(d, x);
  for (int i = 1; i < d; i++)
    y[i] = (v[i] - y[0] * x[i]) / x[0];
}

/* y := P x, inverse = 1: P^-1 x; y is not x. w: (w_0, w_1) of dlsi_cone_between. */
static inline void dlsi_cone_scale(int d, double eta, const double *w, int inverse, const double *x,
                                   double *y) {
  const double turn = inverse ? -1 : 1, size = inverse ? 1 / eta : eta;
  double t = 0;
  for (int i = 1; i < d; i++)
    t += turn * w[i] * x[i];
  const double f = x[0] + t / (1 + w[0]);
  y[0] = size * (w[0] * x[0] + t);
  for (int i = 1; i < d; i++)
    y[i] = size * (x[i] + f * turn * w[i]);
}

/* Returns the largest a for which x + a dx stays in the cone. */
static inline double dlsi_cone_step(int d, const double *x, const double *dx) {
  double A = dx[0] * dx[0], B = x[0] * dx[0];
  for (int i = 1; i < d; i++) {
    A -= dx[i] * dx[i];
    B -= x[i] * dx[i];
  }
  const double C = fmax(dlsi_cone_det(d, x), 0), root = B * B - A * C;
  double a = dx[0] < 0 ? -x[0] / dx[0] : INFINITY;
  if (root < 0) return a;
  const double s = -(B + copysign(sqrt(root), B)), roots[2] = {s / A, C / s};
  for (int k = 0; k < 2; k++)
    if (roots[k] > 0 && roots[k] < a) a = roots[k];
  return a;
}

/* Sets eta and w of P for x and z. Returns 0 if they are not inside of the cone. */
static inline int dlsi_cone_between(int d, const double *x, const double *z, double *eta,
                                    double *w) {
  const double dx = dlsi_cone_det(d, x), dz = dlsi_cone_det(d, z);
  if (!(dx > 0 && dz > 0 && x[0] > 0 && z[0] > 0)) return 0;
  const double sx = sqrt(dx), sz = sqrt(dz);
  const double gamma = sqrt((1 + dlsi_cone_dot(d, x, z) / (sx * sz)) / 2);
  double sum = 0;
  for (int i = 1; i < d; i++) {
    w[i] = (z[i] / sz - x[i] / sx) / (2 * gamma);
    sum += w[i] * w[i];
  }
  w[0] = sqrt(1 + sum);
  *eta = sqrt(sz / sx);
  return 1;
}

/* rc := target (1, 0) - lambda o lambda; with directions ax of x and az of z, not NULL, minus (P
 * ax) o (P^-1 az): the right side of a step to x o z = target, of nc contacts; eta: nc. */
static inline void dlsi_cone_target(int d, int nc, const double *eta, const double *w,
                                    const double *lambda, double target, const double *ax,
                                    const double *az, double *rc) {
  for (int c = 0; c < nc; c++) {
    const int o = d * c;
    double l[3], a[3], b[3], ab[3] = {0};
    dlsi_cone_product(d, lambda + o, lambda + o, l);
    if (ax) {
      dlsi_cone_scale(d, eta[c], w + o, 0, ax + o, a);
      dlsi_cone_scale(d, eta[c], w + o, 1, az + o, b);
      dlsi_cone_product(d, a, b, ab);
    }
    for (int i = 0; i < d; i++)
      rc[o + i] = (i ? 0 : target) - l[i] - ab[i];
  }
}

#endif
