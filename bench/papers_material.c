/*
 * papers_material.c: the return of the flow rule (6) of [Chabrand 1998] as it stands, in the place
 * of the radial return (12). This object defines every symbol of src/fe/material.c, so that the
 * linker does not take that of the library.
 *
 *   (6)   d_p = -1/2 be^-1 L_v be = l' sqrt(3/2) n,   n = s / |s|
 *   (12)  be in the plastic term is replaced by its mean: L_v be = -2 l' sqrt(3/2) (tr be / 3) n
 *
 * Integrated over a step with the direction n at its end, as the return (12) does:
 *
 *   (EX1)  be = exp(-2 l sqrt(3/2) n) be',   s = mu dev be,   n = s / |s|
 *   (EX2)  sqrt(3/2) |s| = sigma0(ep_n + l)
 *
 * be, be', s and n have the same principal axes, and det be = 1 without a correction. Newton's
 * method finds the logarithms of the principal values and l. The tangent is a central difference:
 * its error stops nothing, as Newton's method converges to the balance of forces.
 */
#include "fe/solid.h"
#include "papers.h"

#define dlsi_solid_update papers_radial
int papers_radial(const dlsi_solid *solid, const double F[5], double J, const dlsi_point *old,
                  dlsi_point *now, double s[4], double *c);
#include "fe/material.c"
#undef dlsi_solid_update

int papers_exponential;

/* b: eigenvalues of A; (x, y): the unit eigenvector of b[0] in the plane; b[2] is out of it. */
static void principal(const double A[4], double b[3], double *x, double *y) {
  const double mean = (A[0] + A[1]) / 2, half = (A[0] - A[1]) / 2, size = hypot(half, A[3]);
  const double angle = size > 0 ? atan2(A[3], half) / 2 : 0;
  b[0] = mean + size;
  b[1] = mean - size;
  b[2] = A[2];
  *x = cos(angle);
  *y = sin(angle);
}

/* A := the tensor with these principal values. */
static void compose(const double b[3], double x, double y, double A[4]) {
  A[0] = b[0] * x * x + b[1] * y * y;
  A[1] = b[0] * y * y + b[1] * x * x;
  A[2] = b[2];
  A[3] = (b[0] - b[1]) * x * y;
}

/* n := s / |s| of the principal values exp(2 e_i); returns |s| / mu. */
static double direction(const double e[3], double b[3], double n[3]) {
  for (int i = 0; i < 3; i++)
    b[i] = exp(2 * e[i]);
  const double mean = (b[0] + b[1] + b[2]) / 3;
  for (int i = 0; i < 3; i++)
    n[i] = b[i] - mean;
  const double size = sqrt(n[0] * n[0] + n[1] * n[1] + n[2] * n[2]);
  for (int i = 0; i < 3; i++)
    n[i] /= size;
  return size;
}

/* Solves A x = x, 4 x 4 by rows, with row exchanges; returns 0 if A is singular. */
static int solve4(double A[4][4], double x[4]) {
  for (int k = 0; k < 4; k++) {
    int p = k;
    for (int i = k + 1; i < 4; i++)
      if (fabs(A[i][k]) > fabs(A[p][k])) p = i;
    if (!(fabs(A[p][k]) > 0)) return 0;
    for (int j = 0; j < 4; j++) {
      const double swap = A[k][j];
      A[k][j] = A[p][j];
      A[p][j] = swap;
    }
    const double swap = x[k];
    x[k] = x[p];
    x[p] = swap;
    for (int i = k + 1; i < 4; i++) {
      const double factor = A[i][k] / A[k][k];
      for (int j = k; j < 4; j++)
        A[i][j] -= factor * A[k][j];
      x[i] -= factor * x[k];
    }
  }
  for (int k = 3; k >= 0; k--) {
    for (int j = k + 1; j < 4; j++)
      x[k] -= A[k][j] * x[j];
    x[k] /= A[k][k];
  }
  return 1;
}

/* Solves (EX1) and (EX2) for the logarithms e of the principal values and l by Newton's method. e:
 * in, those of the trial; out. b: exp(2 e). Returns l, -1 on failure. */
static double flow(const dlsi_solid *solid, double ep, double e[3], double b[3]) {
  const double mu = solid->shear, trial[3] = {e[0], e[1], e[2]}, root = sqrt(1.5);
  double n[3], slope, l = 0;
  const double length = sqrt(e[0] * e[0] + e[1] * e[1] + e[2] * e[2]);
  /* the start: the return for small strain */
  for (int k = 0; k < 30; k++) {
    const double y =
        root * 2 * mu * length - dlsi_hardening_value(&solid->hardening, ep + l, &slope);
    l = fmax(0, l + (y - 3 * mu * l) / (3 * mu + slope));
  }
  const double left = fmax(0.01, 1 - root * l / length);
  for (int i = 0; i < 3; i++)
    e[i] *= left;
  for (int k = 0; k < 40; k++) {
    const double size = direction(e, b, n);
    double A[4][4], x[4], change = 0;
    const double yield = dlsi_hardening_value(&solid->hardening, ep + l, &slope);
    for (int j = 0; j < 3; j++) {
      const double along = 2 * b[j] * n[j]; /* of |s| / mu */
      for (int i = 0; i < 3; i++)
        A[i][j] = (i == j) + root * l * (2 * b[j] * ((i == j) - 1.0 / 3) - n[i] * along) / size;
      A[3][j] = root * mu * along / yield;
      A[j][3] = root * n[j];
      x[j] = trial[j] - e[j] - root * l * n[j];
    }
    A[3][3] = -slope / yield;
    x[3] = 1 - root * mu * size / yield;
    if (!solve4(A, x)) return -1;
    for (int i = 0; i < 3; i++) {
      e[i] += x[i];
      change = fmax(change, fabs(x[i]));
    }
    l = fmax(0, l + x[3]);
    if (!isfinite(change)) return -1;
    if (change <= 1e-14) {
      direction(e, b, n);
      return l;
    }
  }
  return -1;
}

/* Moves a point by (EX1), (EX2) without a tangent. */
static int exponential_point(const dlsi_solid *solid, const double F[5], double J,
                             const dlsi_point *old, dlsi_point *now, double s[4]) {
  const double mu = solid->shear;
  double be[4], trial[3], b[3] = {0}, e[3], x, y, slope;
  material_push(F, old->Cp, 1 / cbrt(J * J), be);
  principal(be, trial, &x, &y);
  const double m = (trial[0] + trial[1] + trial[2]) / 3;
  double size = 0;
  for (int i = 0; i < 3; i++)
    size += (trial[i] - m) * (trial[i] - m);
  size = sqrt(size);
  *now = *old;
  now->elastic = mu / 2 * 3 * (m - 1);
  const double before = dlsi_hardening_value(&solid->hardening, old->ep, &slope);
  const double excess = sqrt(1.5) * mu * size - before;
  if (!(excess > 0)) {
    for (int i = 0; i < 4; i++)
      s[i] = mu * (be[i] - (i < 3 ? m : 0));
    return isfinite(excess);
  }
  for (int i = 0; i < 3; i++)
    e[i] = log(trial[i]) / 2;
  const double l = flow(solid, old->ep, e, b);
  if (!(l >= 0)) return 0;
  const double after = dlsi_hardening_value(&solid->hardening, old->ep + l, &slope);
  now->ep = old->ep + l;
  const double mean = (b[0] + b[1] + b[2]) / 3;
  compose(b, x, y, be);
  for (int i = 0; i < 4; i++)
    s[i] = mu * (be[i] - (i < 3 ? mean : 0));
  const double area = F[0] * F[3] - F[1] * F[2];
  const double inverse[5] = {F[3] / area, -F[1] / area, -F[2] / area, F[0] / area, 1 / F[4]};
  material_push(inverse, be, cbrt(J * J), now->Cp);
  now->elastic = mu / 2 * 3 * (mean - 1);
  now->plastic = old->plastic + (before + after) / 2 * l;
  return isfinite(now->Cp[0] + now->Cp[1] + now->Cp[2] + now->Cp[3]);
}

/* c of d -> ds - d s - s d, d in the components (11, 22, 33, 2 12). */
static int exponential_tangent(const dlsi_solid *solid, const double F[5], const dlsi_point *old,
                               const double s[4], double *c) {
  const double h = 1e-6;
  for (int j = 0; j < 4; j++) {
    const double a = j == 0, b = j == 1, o = j == 2, t = j == 3 ? 0.5 : 0;
    double side[2][4];
    for (int k = 0; k < 2; k++) {
      const double e = k ? -h : h;
      const double G[5] = {F[0] + e * (a * F[0] + t * F[2]), F[1] + e * (a * F[1] + t * F[3]),
                           F[2] + e * (t * F[0] + b * F[2]), F[3] + e * (t * F[1] + b * F[3]),
                           F[4] * (1 + e * o)};
      dlsi_point now;
      const double J = (G[0] * G[3] - G[1] * G[2]) * G[4];
      if (!exponential_point(solid, G, J, old, &now, side[k])) return 0;
    }
    /* d s + s d, with d12 = t */
    const double Lie[4] = {2 * (a * s[0] + t * s[3]), 2 * (b * s[1] + t * s[3]), 2 * o * s[2],
                           (a + b) * s[3] + t * (s[0] + s[1])};
    for (int i = 0; i < 4; i++)
      c[i + 4 * j] = (side[0][i] - side[1][i]) / (2 * h) - Lie[i];
  }
  return 1;
}

int dlsi_solid_update(const dlsi_solid *solid, const double F[5], double J, const dlsi_point *old,
                      dlsi_point *now, double s[4], double *c) {
  if (!papers_exponential) return papers_radial(solid, F, J, old, now, s, c);
  return exponential_point(solid, F, J, old, now, s) &&
         (!c || exponential_tangent(solid, F, old, s, c));
}
