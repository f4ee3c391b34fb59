/*
 * dynamics_column.h: spheres that fall, roll and slip, in steps of time by the scheme of Moreau
 * and Jean:
 *
 *   v+ = v + h g + M^-1 H r,   x+ = x + h v+,   u = gap / h e_n + H^T v+
 *
 * Contacts are the pairs of spheres that are nearer than a margin, and the spheres that are so
 * near the floor z = 0: they appear and vanish from step to step.
 */
#ifndef BENCH_DYNAMICS_COLUMN_H
#define BENCH_DYNAMICS_COLUMN_H

#include <stdint.h>

#include "delassus/rigid.h"

/* The contacts of one step, those of a sphere side by side. */
typedef struct column_contacts {
  int count;
  int *first; /* spheres + 1: the first contact of each sphere */
  int *body;  /* 2 count: the sphere, and the other one; -1: the floor */
} column_contacts;

/* How the spheres stand at first: in the hollows of the layer below, radii 1 cm, with chances of
 * `spread` of the radius, and so far apart. */
typedef struct column_kind {
  const char *name;
  double spread, cell, shake; /* none; of the mean radius: across, and of random places */
  double h;                   /* s */
  int before;                 /* steps until it is measured */
  int most;                   /* spheres */
} column_kind;

typedef struct column {
  int count, most;    /* spheres; contacts that there is room for */
  double h, friction; /* s; none */
  dls_rigid *sphere;  /* count */
  double *radius;     /* count: m */
  column_contacts now, last;
  int *from;               /* of each contact its number in the step before; -1: it is new */
  double *H, *q, *mu;      /* of the contact problem */
  int *head, *next, *cell; /* of the search: buckets, count, 3 count */
  int buckets;
  dls_contact contact; /* of the arrays above */
} column;

/* Makes a column of so many spheres, three times as high as wide, at rest. 0, or -1 without
 * memory. */
int column_create(column *a, const column_kind *kind, int count, uint64_t seed);

/* Adds gravity to the velocities, finds the contacts and makes the contact problem of the next
 * step. 0, or -1 without room. */
int column_look(column *a);

/* Takes the step with these impulses (3 nc). */
void column_move(column *a, const double *r);

void column_free(column *a);

#endif
