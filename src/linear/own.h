/*
 * own.h: splits the body's own deformation off its loads: what they do to the body alone.
 *
 *   f' = f - K x_own,   g' = g + H^T x_own,   y = x - x_own:   K y = f' + H r,   u = H^T y + g'
 *
 * for any x_own. Here f' is what K does not resist: the resultants of f on free and softly held
 * bodies, as forces at the contacts, and 0 where K holds the body. Heat, pressure, bolts and
 * penalties balance in themselves: f is 1e6 or 1e30 times what contact carries, f' is not.
 */
#ifndef DLSI_OWN_H
#define DLSI_OWN_H

#include "contact/body.h"

typedef struct dlsi_own {
  const dlsi_body *body;
  /* x := B x, B near K^-1 wherever K resists more than contacts of 1e-5 of the local stiffness */
  dls_status (*solve)(void *data, double *x, dls_error *error);
  void *data;
} dlsi_own;

/* stiffness of a contact in B, in round variables; 1e-3 to 1e-7 are equal */
static const double dlsi_own_share = 1e-5;

/* Splits `load`: x := x_own, rest := load - K x. Rest is exactly 0 on a body where it is no more
 * than the rounding of the loads leaves. load, rest: n, force; may be the same array. x: n, length.
 * Up to 16 solves, some products with K. Allocates; DLS_E_MEMORY or an error of solve. */
dls_status dlsi_own_split(const dlsi_own *of, const double *load, long double *x, double *rest,
                          dls_error *error);

/* g := g + H^T x. x: n; g: m. */
void dlsi_own_look(const dlsi_body *body, const long double *x, double *g);

/* balanced := | f k / K_jj | by bodies, k the least K_jj of the body, where rest is 0, else 0: a
 * load on a penalty counts as the displacement that it makes. f, rest: n; balanced: 2 parts, the
 * second half scratch. */
void dlsi_own_balanced(const dlsi_body *body, const double *f, const double *rest,
                       double *balanced);

/* blur := for each row of H^T, the largest position that x_own has at a contact of its bodies.
 * x: n, x_own; parts: scratch, parts; blur: m. */
void dlsi_own_blur(const dlsi_body *body, const long double *x, double *parts, double *blur);

/* Takes the rigid motion out of x that K holds only by its own rounding, by bodies: x := the
 * elastic part of x, g := g + H^T of what is taken out. Then K x has no forces of rounding, and
 * rounding levels no motion. x: n, length; g: m. Errors of dlsi_own_split. */
dls_status dlsi_own_land(const dlsi_own *of, double *x, double *g, dls_error *error);

/* Measures the pair (x, r) on the split problem, as dlsi_body_measure, after dlsi_own_land. What
 * the rounding of x makes of forces, up to 4 eps |K||x| in each row, counts as the displacement
 * that it is. u: H^T x + g, m. Errors of dlsi_own_split. */
dls_status dlsi_own_measure(const dlsi_own *of, const double *f, const double *g, const double *mu,
                            const double *r, const double *x, double *u, double *work,
                            dls_certificate *certificate, dls_error *error);

#endif
