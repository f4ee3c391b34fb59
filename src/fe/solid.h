/*
 * solid.h: finite elastoplasticity on four-node elements; declares the parts of a forming scene.
 *
 *   material.c   stress, tangent and new state of a point
 *   q4.c         forces and tangent of an element
 *   obstacle.c   distance from a rigid profile
 *   band.c       banded matrices: assembly, supports, LU
 *
 * Symmetric tensors of plane strain and of axisymmetry have four components, in the order
 * (11, 22, 33, 12); 33 is out of the plane (the hoop direction). Rates of deformation that multiply
 * them are (d11, d22, d33, 2 d12).
 */
#ifndef DLSI_SOLID_H
#define DLSI_SOLID_H

#include "contact/contact.h"

/* ---- material -------------------------------------------------------------------------------- */

/* Yield stress: sigma0(ep) = factor (offset + ep)^exponent; or, with points > 0, the polygon
 * through (ep[k], sigma[k]), ep[0] = 0, ep ascending, constant beyond the last point. */
typedef struct dlsi_hardening {
  double factor, offset, exponent; /* force / length^2, 1, 1; linear: exponent = 1 */
  int points;
  const double *ep, *sigma;
} dlsi_hardening;

/* Returns sigma0 at ep >= 0; *slope := the derivative of sigma0, to the right at a corner. */
double dlsi_hardening_value(const dlsi_hardening *hardening, double ep, double *slope);

typedef struct dlsi_solid {
  double bulk, shear; /* K, mu of [C] (8) */
  dlsi_hardening hardening;
  int keep_trace; /* 1: [C] (13) as printed; 0: det be = 1 */
} dlsi_solid;

/* Returns the solid of Young's modulus E > 0 and Poisson's ratio nu, -1 < nu < 1/2. */
dlsi_solid dlsi_solid_make(double E, double nu, dlsi_hardening hardening);

/* State of a point of the material. */
typedef struct dlsi_point {
  double Cp[4];            /* Cp^-1 = Fp^-1 Fp^-T */
  double ep;               /* equivalent plastic strain */
  double elastic, plastic; /* energy of distortion, plastic work, per unit of initial volume; only
                              the energy balance reads them */
} dlsi_point;

/* Returns the state before any deformation. */
dlsi_point dlsi_point_virgin(void);

/* Moves a point from the state *old to the deformation gradient F. Returns 0 if the local iteration
 * fails or a result is not finite.
 *   F: in, (F11 F12 F21 F22 F33); J: in, det F > 0
 *   now: out, the state at F
 *   s: out, deviatoric Kirchhoff stress, 4
 *   c: out or NULL, tangent, 4 x 4 column-major: Lie derivative of s = c : d */
int dlsi_solid_update(const dlsi_solid *solid, const double F[5], double J, const dlsi_point *old,
                      dlsi_point *now, double s[4], double *c);

/* Returns U(J) of [C] (8); *p := U', *slope := U''. */
double dlsi_solid_volume(const dlsi_solid *solid, double J, double *p, double *slope);

/* ---- element --------------------------------------------------------------------------------- */

typedef struct dlsi_q4 {
  int axisymmetric;    /* x_1 is the radius, volumes are per radian; else unit thickness */
  int full;            /* 1: standard Q4; 0: Q4/P0, mean dilatation */
  const double *X, *x; /* 2 x 4 each: corners at rest and now, counterclockwise */
} dlsi_q4;

/* Moves the points of an element to its corners x. Returns 0 if the element is turned inside out or
 * the material fails.
 *   old: in, states, 4; now: out, states at x, 4
 *   f: out, internal forces, 8
 *   K: out or NULL, tangent, 8 x 8 column-major
 *   energy: out, elastic energy and plastic work
 *   stress: out or NULL, Cauchy stress, 4 x 4, one column per point */
int dlsi_q4_forces(const dlsi_q4 *element, const dlsi_solid *solid, const dlsi_point *old,
                   dlsi_point *now, double *f, double *K, double energy[2], double *stress);

/* ---- obstacle -------------------------------------------------------------------------------- */

/* A piece of a profile. side = 0: the line from a to b, the body on its left. side = 1 or -1: the
 * arc between a and b of the circle about c, the body outside (1) or inside (-1) of the circle. */
typedef struct dlsi_piece {
  double a[2], b[2];
  double c[2], radius;
  int side;
} dlsi_piece;

/* A profile: piece k ends at b where piece k + 1 begins at a. The first piece goes on beyond its a,
 * the last one beyond its b. */
typedef struct dlsi_obstacle {
  int pieces;
  const dlsi_piece *piece;
} dlsi_obstacle;

/* Returns the distance of the point x from the profile, negative inside the obstacle.
 *   n: out, unit normal towards the body, 2; the tangent is t = (n_2, -n_1)
 *   curvature: out; a motion dx of the point turns n by curvature t t^T dx */
double dlsi_obstacle_gap(const dlsi_obstacle *obstacle, const double x[2], double n[2],
                         double *curvature);

/* ---- banded matrices ------------------------------------------------------------------------- */

/* A matrix, n x n, of entries with |i - j| <= k, beside its LU factors. */
typedef struct dlsi_band {
  int n, k;
  double *a, *lu; /* (3 k + 1) * n */
  int *pivot;
} dlsi_band;

/* Returns 0 if there is no memory; the band is to be freed all the same. */
int dlsi_band_create(dlsi_band *band, int n, int k);
void dlsi_band_free(dlsi_band *band);
void dlsi_band_clear(dlsi_band *band); /* a := 0 */

/* Returns the place of entry (i, j) in a and lu, which have one for j - 2 k <= i <= j + k. */
static inline size_t dlsi_band_at(const dlsi_band *band, int i, int j) {
  return (size_t)(2 * band->k + i - j) + (size_t)(3 * band->k + 1) * (size_t)j;
}

/* Prescribes x_j = value in a x = f by a decoupled row and column of a; f: in and out, n. */
void dlsi_band_support(dlsi_band *band, int j, double value, double *f);

void dlsi_band_load(dlsi_band *band);  /* lu := a */
int dlsi_band_factor(dlsi_band *band); /* lu := the LU factors of lu; returns 0 if singular */

/* X (n x count) := A^-1 X by the factors lu; a dls_solve_fn. Returns 0 on success. */
int dlsi_band_solve(void *band, double *X, int n, int count);

#endif
