/*
 * solid.h: finite elastoplasticity on four-node elements, what its files share.
 *
 *   material.c   stress, tangent and new state of a point
 *   q4.c         forces and tangent of an element
 *   obstacle.c   distance from a rigid profile
 *   band.c       banded matrices: assembly, supports, LU
 *   forming.c    the loops; forming_contact.c: the contact problem; forming_scene.c: the scenes
 *
 * Symmetric tensors of plane strain and of axisymmetry have four components, in the order
 * (11, 22, 33, 12); 33 is out of the plane (the hoop direction). Rates of deformation that go with
 * them in products are (d11, d22, d33, 2 d12).
 */
#ifndef DLSI_SOLID_H
#define DLSI_SOLID_H

#include "base/base.h"

/* ---- material -------------------------------------------------------------------------------- */

/* sigma0(ep) = factor (offset + ep)^exponent; or, with points > 0, the polygon through
 * (ep[k], sigma[k]), ep[0] = 0, ascending, constant beyond the last one. */
typedef struct dlsi_hardening {
  double factor, offset, exponent; /* force / length^2, 1, 1; linear: exponent = 1 */
  int points;
  const double *ep, *sigma;
} dlsi_hardening;

/* sigma0 at ep >= 0; *slope := its derivative, to the right at a corner. */
double dlsi_hardening_value(const dlsi_hardening *hardening, double ep, double *slope);

typedef struct dlsi_solid {
  double bulk, shear; /* K, mu of [C] (8) */
  dlsi_hardening hardening;
  int keep_trace; /* 1: [C] (13) as printed; 0: det be = 1 */
} dlsi_solid;

/* From E > 0, -1 < nu < 1/2. */
dlsi_solid dlsi_solid_make(double E, double nu, dlsi_hardening hardening);

/* What a point remembers: Cp^-1 = Fp^-1 Fp^-T, the equivalent plastic strain, and for the books
 * the elastic energy of distortion and the plastic work, per unit of initial volume. */
typedef struct dlsi_point {
  double Cp[4];
  double ep;
  double elastic, plastic;
} dlsi_point;

dlsi_point dlsi_point_virgin(void);

/* F = (F11 F12 F21 F22 F33), J = det F > 0. *now: the state at F if it was *old; s (4): deviatoric
 * Kirchhoff stress; c (4 x 4, column-major) or NULL: its tangent, Lie derivative of s = c : d.
 * 0 if the local iteration fails or something is not finite. */
int dlsi_solid_update(const dlsi_solid *solid, const double F[5], double J, const dlsi_point *old,
                      dlsi_point *now, double s[4], double *c);

/* U of [C] (8) and U', U''. */
double dlsi_solid_volume(const dlsi_solid *solid, double J, double *p, double *slope);

/* ---- element --------------------------------------------------------------------------------- */

typedef struct dlsi_q4 {
  int axisymmetric;    /* x_1 is the radius, volumes are per radian; else unit thickness */
  int full;            /* 1: standard Q4; 0: Q4/P0, mean dilatation */
  const double *X, *x; /* 2 x 4 each: corners at rest and now, counterclockwise */
} dlsi_q4;

/* now (4) from old (4); f (8): internal forces; K (8 x 8, column-major) or NULL: tangent;
 * energy: elastic; plastic work. stress (4 x 4, Cauchy, one column per point) or NULL. 0 if the
 * element is turned inside out or the material fails. */
int dlsi_q4_forces(const dlsi_q4 *element, const dlsi_solid *solid, const dlsi_point *old,
                   dlsi_point *now, double *f, double *K, double energy[2], double *stress);

/* ---- obstacle -------------------------------------------------------------------------------- */

/* A line from a to b, the body on its left; or, with side != 0, the arc of the circle about c
 * between a and b, the body outside of the circle (side = 1) or inside (side = -1). */
typedef struct dlsi_piece {
  double a[2], b[2];
  double c[2], radius;
  int side;
} dlsi_piece;

/* A profile, piece after piece. Its first and its last piece go on beyond its ends. */
typedef struct dlsi_obstacle {
  int pieces;
  const dlsi_piece *piece;
} dlsi_obstacle;

/* Distance of point x, negative inside; n (2): unit normal towards the body; the tangent is
 * t = (n_2, -n_1); n turns by curvature t t^T dx with x. */
double dlsi_obstacle_gap(const dlsi_obstacle *obstacle, const double x[2], double n[2],
                         double *curvature);

/* ---- banded matrices ------------------------------------------------------------------------- */

/* n x n, entries with |i - j| <= k. */
typedef struct dlsi_band {
  int n, k;
  double *a, *lu; /* (3 k + 1) * n */
  int *pivot;
} dlsi_band;

int dlsi_band_create(dlsi_band *band, int n, int k); /* 0: no memory; free it all the same */
void dlsi_band_free(dlsi_band *band);
void dlsi_band_clear(dlsi_band *band);

/* Place of (i, j) in a and lu; in column j that of (0, j) is inside of the array, too. */
static inline size_t dlsi_band_at(const dlsi_band *band, int i, int j) {
  return (size_t)(2 * band->k + i - j) + (size_t)(3 * band->k + 1) * (size_t)j;
}

/* Makes A x = f say x_j = value, by a decoupled row and column. */
void dlsi_band_support(dlsi_band *band, int j, double value, double *f);

void dlsi_band_load(dlsi_band *band);  /* lu := a */
int dlsi_band_factor(dlsi_band *band); /* lu := its LU factors; 0: singular */

/* X := A^-1 X by the factor, as a dls_solve_fn. */
int dlsi_band_solve(void *band, double *X, int n, int count);

#endif
