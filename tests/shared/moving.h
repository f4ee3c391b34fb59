/* moving.h: bodies that move, put together entry by entry, and steps that check themselves. */
#ifndef MOVING_H
#define MOVING_H

#include "delassus/motion.h"

enum { moving_columns = 2100, moving_entries = 24000, moving_bodies = 60 };

/* A sparse matrix that is written column after column. */
typedef struct moving_matrix {
  int columns; /* begun so far */
  int p[moving_columns + 1], i[moving_entries];
  double x[moving_entries];
} moving_matrix;

/* The parts of a dls_motion_model. Begin with moving_begin. */
typedef struct moving_parts {
  int n, nodes;
  moving_matrix M, C, K, HN, HT;
  double gap[moving_columns];
  double centre[2 * moving_bodies]; /* of rigid bodies: unknowns x, y, angle of body b at 3 b */
} moving_parts;

void moving_begin(moving_parts *parts, int n);

/* Adds an entry; columns must not decrease. */
void moving_add(moving_matrix *A, int i, int j, double x);

/* Adds a contact node with the normal e_i (i < 0: none) and the tangent e_j (j < 0: none). */
void moving_touch(moving_parts *parts, int i, int j, double gap);

/* Adds a rigid body of the plane, the next one. */
void moving_body(moving_parts *parts, int b, double x, double y, double mass, double inertia);

/* Adds a contact node between the bodies a and b (b < 0: the obstacle) at the point X; the normal
 * of angle `angle` points to a, the tangent is the normal turned by -90 degrees. */
void moving_joint(moving_parts *parts, int a, int b, const double *X, double angle, double gap);

/* Adds the lower triangle of a dense matrix (n x n, leading dimension n), without its zeros. */
void moving_add_dense(moving_matrix *A, int n, const double *dense);

/* The model, d = 2, DLS_CHOLESKY. Matrices without a column are left out. */
dls_motion_model moving_model(moving_parts *parts);

/* Default settings with a law and a step. */
dls_motion_settings moving_settings(dls_motion_law law, double h);

dls_motion *moving_create(const dls_motion_model *model, const dls_motion_settings *settings,
                          const double *x, const double *v);

/* A step that is certified and sound: energy identity <= 1e-13 of its scale, momentum <= 1e-11.
 * Returns the state after it. */
dls_motion_state moving_step(dls_motion *motion, const double *f, const double *y,
                             const double *mu);

dls_motion_state moving_state(const dls_motion *motion);
dls_motion_energies moving_energies(const dls_motion *motion);

#endif
