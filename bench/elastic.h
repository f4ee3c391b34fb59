/* elastic.h: elastic boxes of square (Q4, plane strain) or cubic (H8) elements for bench/reduction. */
#ifndef ELASTIC_H
#define ELASTIC_H

#include "delassus.h"

/* E = 1, nu = 0.3, elements of size 1, `cells` a side; the face x = 0 is clamped, the nodes of the
 * face below are contact nodes (normal up, tangents along the axes). Owns its arrays. */
typedef struct box {
  dls_model model; /* sparse K, DLS_CHOLESKY: its lower triangle; or all of it, DLS_LU */
  int *p, *i, *hp, *hn, *ht;
  double *x, *one;
} box;

/* skew: size of the skew-symmetric part of K against its off-diagonal entries, 0 for a symmetric K.
 * 0, or -1 if there is no memory. */
int box_create(box *b, int d, int cells, double skew);
void box_free(box *b);

#endif
