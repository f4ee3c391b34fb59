/*
 * scenes.h: small free bodies with random contacts; statics decides whether they stand.
 */
#ifndef SCENES_H
#define SCENES_H

#include <stdint.h>

#include "solids.h"

typedef enum scene_kind {
  SCENE_STANDS, /* f = -H r for an r inside of the cones: an answer exists */
  SCENE_FALLS   /* a rigid motion b with (H^T b)_n >= mu |(H^T b)_t| at every contact and b^T f > 0:
                   no answer exists */
} scene_kind;

/* Makes the scene of this seed: 1 to 5 blocks of squares (d = 2) or cubes (d = 3), each of its own
 * stiffness, 2 to 8 contacts a block with the ground or with other blocks, normals at random,
 * forces over 1e4. *mu: friction of all contacts. */
void scene_generate(uint64_t seed, int d, scene_kind kind, solids *S, double *mu);

#endif
