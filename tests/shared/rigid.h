/*
 * rigid.h: contact problems of rigid bodies, of any size: packings, walls, chains, arches, towers.
 *
 *   W = H^T M^-1 H by blocks,  q = H^T v,  v the motion of the bodies without reactions
 */
#ifndef RIGID_H
#define RIGID_H

#include <stdint.h>

#include "delassus/contact.h"

typedef struct rigid {
  int d, bodies;
  dls_contact contact;  /* of the arrays below, W by blocks */
  dls_contact factored; /* the same, of bodies */
  int *body;  /* 2 nc: of candidate c the upper one 2 c, the lower one 2 c + 1; -1: fixed */
  double *H;  /* nc times 2 blocks of n x d, column-major: M^-1/2 H, n = 3 (d - 1) motions */
  double *v;  /* n bodies: M^1/2 v */
  int *p, *i; /* of W by blocks */
  double *x, *q, *mu;
} rigid;

/* Makes the problem `kind` of about `candidates` candidates with friction mu. Returns 0, or -1 for
 * an unknown kind or without memory. Kinds:
 *
 *   packing-rest, packing-flow   3D spheres of radius .3535 +-3 % on a face-centred lattice, moved
 *                                by +-5 % of a cell, in a box; under one step of gravity, or with
 *                                random velocities besides
 *   wall-rest, wall-pushed       2D bricks 2 x 1 in running bond; pushed along
 *   rubble-rest, rubble-pushed   the same with bricks of random widths from 1 to 3
 *   wall3-rest, wall3-pushed     3D bricks 2 x 1 x 1, four candidates an overlap; pushed along and
 *                                across
 *   chain, chain3                2D discs, 3D balls upon each other, with small random velocities
 *   arch, arch3                  a half ring of voussoirs of thickness .3 under gravity
 *   tower2                       2D blocks 1 x 1 upon each other, slightly pushed
 *   tower                        3D planks 3 x 1 x .4, three a layer, crosswise
 *   discs-rest, discs-flow       2D discs of radius 1 +-30 % that have settled from random places
 *                                in a box; under one step of gravity, or with random velocities
 *                                besides
 *   balls-rest, balls-flow       the same in 3D
 *   mixed2-rest, mixed3-rest     discs-rest, balls-rest with densities from 1/32 to 32
 *   sizes2-flow, sizes3-flow     discs-flow, balls-flow with radii from 1 to 10 */
int rigid_create(rigid *a, const char *kind, int candidates, double mu, uint64_t seed);
void rigid_free(rigid *a);

/* Makes wall-pushed of so many rows, `width` bricks long, pushed by this velocity. */
int rigid_wall(rigid *a, int rows, int width, double push, double mu);

/* ---- other bodies ---------------------------------------------------------------------------- */

/* A body: axes along x, y, z. d = 2: in the plane x, y; the last inertia alone counts. */
typedef struct solid {
  double x[3], v[3], spin[3]; /* middle, velocity, angular velocity */
  double mass, inertia[3];
} solid;

/* A place where body a may touch body b (-1: fixed); normal from b to a, unit. */
typedef struct place {
  int a, b;
  double x[3], normal[3];
} place;

/* Bodies and places while they are put up: set d and state first. bad: 1 without memory. */
typedef struct heap {
  int d, bodies, places, most_bodies, most_places, bad;
  solid *body;
  place *at;
  double push; /* velocity along of what is pushed */
  uint64_t state;
} heap;

/* Returns a number in (-1, 1). */
double heap_random(heap *h);

/* c := a x b. */
void rigid_cross(const double *a, const double *b, double *c);

/* Add a body, whose number is returned, or a place; heap_body with inertia (3, or 1 for d = 2) and
 * v: velocity, then turning. rigid_close makes the problem and frees the heap: 0, or -1. */
int heap_add_body(heap *h, solid body);
int heap_body(heap *h, const double *middle, double mass, const double *inertia, const double *v);
void heap_touch(heap *h, place at);
void heap_contact(heap *h, int a, int b, const double *x, const double *normal);
int rigid_close(rigid *a, heap *h, double mu);

/* Allocates body, H, v, q, mu, all 0; forms q += H^T v and W by blocks of them. 0, or -1. */
int rigid_room(rigid *a, int d, int bodies, int nc);
int rigid_assemble(rigid *a);

/* The kinds above but for the sizes, in that order; NULL past the last. */
const char *rigid_kind(int index);

#endif
