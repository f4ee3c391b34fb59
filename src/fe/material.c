/*
 * material.c: moves a point of finite elastoplasticity, [Chabrand 1998] (1)-(14).
 *
 *   F = Fe Fp,  J = det F,  be = J^-2/3 F Cp^-1 F^T   (isochoric part, (9); after (8) the paper
 *                                                      prints J^-1/3, a slip)
 *   tau = J U'(J) 1 + s,   s = mu dev be                                                 (4), (10)
 *   U   = K/2 ( (J^2 - 1)/2 - ln J )                                                         (8)
 *   f   = sqrt(3/2) |s| - sigma0(ep) <= 0                                                    (5)
 *
 * Radial return with trial s', be' from the old Cp, n = s'/|s'|, m = tr be' / 3, G = mu m:
 *
 *   (MA1)  f' = sqrt(3/2) |s'| - sigma0(ep_n) <= 0: elastic, s = s'                         (11)
 *   (MA2)  sqrt(3/2) |s'| - 3 G l = sigma0(ep_n + l)        Newton for l                 (5), (12)
 *   (MA3)  s = a n,  a = |s'| - sqrt(6) G l,  ep = ep_n + l                              (12), (14)
 *   (MA4)  be = s / mu + m 1,  Cp^-1 = J^2/3 F^-1 be F^-T                                    (13)
 *
 * (13) keeps the trace, m as above. It lets det be drift from 1, and the elastic energy with it.
 * By default m is the root near 1 of det( s/mu + m 1 ) = m^3 - |s/mu|^2 m / 2 + det(s/mu) = 1.
 *
 * Tangent. For a rate d of deformation (without spin),
 *
 *   ds' - d s' - s' d = c' : d,   c' = 2 G (I - 1x1/3) - 2/3 (s' x 1 + 1 x s')
 *   d|s'| = (2 |s'| N + 2 G n) : d,  N = dev(n n),     dG = 2/3 s' : d                     (MA5)
 *   (MA2):  da = (1 - 1/b) (d|s'| - sqrt(6) l dG),   b = 1 + sigma0' / 3G
 *   c = g c' + n x ( da - g d|s'| ),   g = a / |s'|                                        (MA6)
 *
 * c is not quite symmetric: n x N has no partner, because the return (12) does not minimise an
 * energy. The weight of the skew part is |s'| over G, some percent.
 * Cost: some hundred operations and a pow. What can fail: J <= 0, or overflow: not finite.
 */
#include <float.h>
#include <math.h>
#include <string.h>

#include "solid.h"

double dlsi_hardening_value(const dlsi_hardening *h, double ep, double *slope) {
  if (!h->points) {
    const double base = h->offset + ep;
    const double value = h->factor * (h->exponent == 1 ? base : pow(base, h->exponent));
    *slope = h->exponent * (value / base);
    return value;
  }
  int k = 0;
  while (k + 1 < h->points && ep >= h->ep[k + 1])
    k++;
  *slope = k + 1 < h->points ? (h->sigma[k + 1] - h->sigma[k]) / (h->ep[k + 1] - h->ep[k]) : 0;
  return h->sigma[k] + *slope * (ep - h->ep[k]);
}

dlsi_solid dlsi_solid_make(double E, double nu, dlsi_hardening hardening) {
  return (dlsi_solid){
      .bulk = E / (3 * (1 - 2 * nu)), .shear = E / (2 * (1 + nu)), .hardening = hardening};
}

dlsi_point dlsi_point_virgin(void) {
  return (dlsi_point){.Cp = {1, 1, 1, 0}};
}

double dlsi_solid_volume(const dlsi_solid *solid, double J, double *p, double *slope) {
  *p = solid->bulk / 2 * (J - 1 / J);
  *slope = solid->bulk / 2 * (1 + 1 / (J * J));
  return solid->bulk / 2 * ((J * J - 1) / 2 - log(J));
}

/* B := scale F A F^T */
static void material_push(const double F[5], const double A[4], double scale, double B[4]) {
  const double a = F[0] * A[0] + F[1] * A[3], b = F[0] * A[3] + F[1] * A[1];
  const double c = F[2] * A[0] + F[3] * A[3], d = F[2] * A[3] + F[3] * A[1];
  B[0] = scale * (a * F[0] + b * F[1]);
  B[1] = scale * (c * F[2] + d * F[3]);
  B[2] = scale * (F[4] * A[2] * F[4]);
  B[3] = scale * (a * F[2] + b * F[3]);
}

/* Returns |s| of a symmetric tensor. */
static double tensor_norm(const double s[4]) {
  return sqrt(s[0] * s[0] + s[1] * s[1] + s[2] * s[2] + 2 * s[3] * s[3]);
}

/* Solves (MA2); returns the multiplier l, -1 on failure. Left side minus right side decreases in l
 * from f' > 0 at l = 0. A Newton step that leaves the bracket is replaced by the bracket's middle.
 *   trial: sqrt(3/2) |s'|; ep: ep_n */
static double plastic_multiplier(const dlsi_hardening *h, double trial, double G, double ep) {
  double low = 0, high = trial / (3 * G), l = 0, slope;
  for (int k = 0; k < 60; k++) {
    const double y = trial - 3 * G * l - dlsi_hardening_value(h, ep + l, &slope);
    if (!isfinite(y)) return -1;
    if (fabs(y) <= 4 * DBL_EPSILON * trial) return l;
    if (y > 0)
      low = l;
    else
      high = l;
    const double next = l + y / (3 * G + slope);
    const double safe = next >= low && next <= high ? next : (low + high) / 2;
    if (safe == l) return l;
    l = safe;
  }
  return -1;
}

/* Returns the root near 1 of det(D + m 1) = 1 by Newton's method from m. D: in, deviatoric. */
static double unit_mean(const double D[4], double m) {
  const double second = tensor_norm(D) * tensor_norm(D) / 2;
  const double third = D[2] * (D[0] * D[1] - D[3] * D[3]);
  for (int k = 0; k < 20; k++) {
    const double step = (m * (m * m - second) + third - 1) / (3 * m * m - second);
    m -= step;
    if (fabs(step) <= 2 * DBL_EPSILON * m) break;
  }
  return m;
}

/* c := g c' + n x v, (MA6); an elastic point has g = 1, v = 0. */
static void material_tangent(double G, double g, const double trial[4], const double n[4],
                             const double v[4], double *c) {
  static const double one[4] = {1, 1, 1, 0}, identity[4] = {1, 1, 1, 0.5};
  for (int j = 0; j < 4; j++)
    for (int i = 0; i < 4; i++)
      c[i + 4 * j] = g * (2 * G * ((i == j ? identity[i] : 0) - one[i] * one[j] / 3) -
                          2.0 / 3 * (trial[i] * one[j] + one[i] * trial[j])) +
                     n[i] * v[j];
}

int dlsi_solid_update(const dlsi_solid *solid, const double F[5], double J, const dlsi_point *old,
                      dlsi_point *now, double s[4], double *c) {
  const double mu = solid->shear;
  double be[4], trial[4], n[4] = {0}, v[4] = {0}, slope;
  material_push(F, old->Cp, 1 / cbrt(J * J), be); /* (9) */
  const double m = (be[0] + be[1] + be[2]) / 3, G = mu * m;
  for (int i = 0; i < 4; i++)
    trial[i] = mu * (be[i] - (i < 3 ? m : 0));
  const double size = tensor_norm(trial);
  const double before = dlsi_hardening_value(&solid->hardening, old->ep, &slope);
  if (!isfinite(size + before)) return 0;
  *now = *old;
  if (sqrt(1.5) * size <= before) { /* (MA1) */
    memcpy(s, trial, sizeof trial);
    now->elastic = mu / 2 * 3 * (m - 1);
    if (c) material_tangent(G, 1, trial, n, v, c);
    return 1;
  }
  const double l = plastic_multiplier(&solid->hardening, sqrt(1.5) * size, G, old->ep); /* (MA2) */
  if (!(l >= 0)) return 0;
  now->ep = old->ep + l; /* (MA3) */
  const double after = dlsi_hardening_value(&solid->hardening, now->ep, &slope);
  const double a = size - sqrt(6) * G * l, g = a / size;
  double D[4];
  for (int i = 0; i < 4; i++) {
    n[i] = trial[i] / size;
    s[i] = a * n[i];
    D[i] = s[i] / mu;
  }
  const double mean = solid->keep_trace ? m : unit_mean(D, m); /* (MA4) */
  for (int i = 0; i < 3; i++)
    D[i] += mean;
  const double area = F[0] * F[3] - F[1] * F[2];
  const double inverse[5] = {F[3] / area, -F[1] / area, -F[2] / area, F[0] / area, 1 / F[4]};
  material_push(inverse, D, cbrt(J * J), now->Cp);
  now->elastic = mu / 2 * 3 * (mean - 1);
  now->plastic = old->plastic + (before + after) / 2 * l;
  if (c) {
    const double b = 1 + slope / (3 * G);
    const double square[4] = {n[0] * n[0] + n[3] * n[3], n[1] * n[1] + n[3] * n[3], n[2] * n[2],
                              n[3] * (n[0] + n[1])};
    for (int i = 0; i < 4; i++) { /* (MA5), (MA6) */
      const double N = square[i] - (i < 3 ? 1.0 / 3 : 0);
      const double ds = 2 * size * N + 2 * G * n[i];
      v[i] = (1 - 1 / b) * (ds - sqrt(6) * l * (2.0 / 3 * size) * n[i]) - g * ds;
    }
    material_tangent(G, g, trial, n, v, c);
  }
  return isfinite(now->Cp[0] + now->Cp[1] + now->Cp[2] + now->Cp[3]);
}
