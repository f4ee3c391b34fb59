/*
 * global_scenes.h: elastic bodies of bilinear quadrilaterals (plane strain) or trilinear hexahedra,
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
#ifndef GLOBAL_SCENES_H
#define GLOBAL_SCENES_H

#include "contact/columns.h"
#include "delassus/model.h"

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

  /* made by scene_create */
  int d, n, nc;
  dlsi_columns K, N, T;
  double *f, *g; /* n; d nc */
  dls_model model;
} scene;

extern const char *const scene_kind_name[], *const scene_support_name[], *const scene_load_name[];

/* Makes the scene that its first fields name. Returns 0, or -1 without memory. */
int scene_create(scene *S);
void scene_free(scene *S);

#endif
