/*
 * surfaces.h: elastic bodies of bilinear quadrilaterals (plane strain) or trilinear hexahedra,
 * E = 1, nu = .3, whose contacts lie on a whole surface.
 *
 *   STRIP   nx x ny squares of side 1 on the ground               2D
 *   SHEETS  one strip on another with fewer elements along it, so that nodes do not match;
 *           each node of the upper one touches a segment of the lower one                     2D
 *   RIM     a ring of nx elements along it and ny across, with nx / 16 teeth, in a round cavity;
 *           the nodes of the tops of the teeth touch              2D
 *   PLATE   nx x ny x nz cubes of side 1 on the ground            3D
 *   TUBE    nx elements around, ny along, nz across the wall, in an oval bore; the outer nodes
 *           touch                                                 3D
 */
#ifndef SURFACES_H
#define SURFACES_H

#include "solids.h"

typedef enum scene_kind { STRIP, SHEETS, RIM, PLATE, TUBE, SCENE_KINDS } scene_kind;

/* SOFT: springs of .05 at the nodes opposite to the contacts; a strip is clamped at its end, too.
 * HELD: clamped at one end alone: strips and plates are cantilevers; rims and tubes at the nodes
 * opposite to the contacts. FREE: contact alone holds the body, K is singular. The lower one of two
 * sheets is always clamped below. */
typedef enum scene_support { SOFT, HELD, FREE, SCENE_SUPPORTS } scene_support;

/* PRESS: pressed. SHEAR: pressed, and pushed by half of it along the surface. LIFT: pressed, a
 * fifth of it lifted, pushed here and there. */
typedef enum scene_load { PRESS, SHEAR, LIFT, SCENE_LOADS } scene_load;

typedef struct scene {
  scene_kind kind;
  scene_support support;
  scene_load load;
  int seed;    /* 0: the waves of the study; else drawn */
  int size[3]; /* elements; size[2] is 1 in 2D */

  /* made by scene_create; f: n, g: d nc */
  solids body;
  int d, n, nc;
  const double *f, *g;
  dls_model model;
  double wave[6]; /* factors of wave numbers, and phases, of the loads */
} scene;

extern const char *const scene_kind_name[], *const scene_support_name[], *const scene_load_name[];

/* Makes the scene that its first fields name. */
void scene_create(scene *S);
void scene_free(scene *S);

#endif
