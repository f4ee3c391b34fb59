/*
 * cone.h: the scales that make friction cones Lorentz cones, whose algebra is contact/cone.h.
 */
#ifndef DLSI_CONE_H
#define DLSI_CONE_H

#include "contact/cone.h"

/* Sets the scales S (m) of r_c = S_c x_c that make friction cones Lorentz cones and give all scaled
 * W_cc the same mean diagonal. Returns that mean, 0 if W has no diagonal. Tangents without friction
 * have the scale 0. A change of the unit of W by a power of two changes no bit of S. diagonal:
 * scratch, nc. cone.c. */
double dlsi_cone_scales(const dls_contact *problem, double *diagonal, double *S);

#endif
