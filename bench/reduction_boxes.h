/*
 * reduction_boxes.h: elastic boxes of square (Q4, plane strain) or cubic (H8) elements.
 */
#ifndef REDUCTION_BOXES_H
#define REDUCTION_BOXES_H

#include "delassus.h"

/* A box with E = 1, nu = 0.3 and `cells` elements of size 1 a side, clamped on the face x = 0. The
 * nodes of the face below touch, normal up, tangents along the axes. Owns its arrays. */
typedef struct box {
  dls_model model; /* sparse K, DLS_CHOLESKY: its lower triangle; or all of it, DLS_LU */
  int *p, *i, *hp, *hn, *ht;
  double *x, *one;
} box;

/* Makes K and H. skew: size of the skew-symmetric part of K over its off-diagonal entries; 0 makes
 * a symmetric K. Returns 0, or -1 without memory. */
int box_create(box *b, int d, int cells, double skew);

/* Makes a flat box of this height, glued to a rigid body above in place of the face x = 0. All
 * nodes of the face below touch: along x first, then, d = 3, along y. */
int box_create_glued(box *b, int d, int cells, int height);

/* Makes such a cube of side 1, n elements a side, of this ratio of Poisson. */
int box_create_cube(box *b, int n, double nu);
void box_free(box *b);

/* Returns |K x - b| / (|K||x|) in maximum norms, |K| by rows; NAN without memory. */
double box_residual(const dls_model *model, const double *x, const double *b);

#endif
