/*
 * moving_internal.h: shares a scene of bodies that move among its files.
 *
 *   moving_scene.c   meshes, supports, loads, contact operators, first state of each scene
 *   moving_exact.c   closed forms of the bars
 *   mortar.c         contact operators between two lines of nodes that do not match
 *   moving.c         the steps
 */
#ifndef DLSI_MOVING_INTERNAL_H
#define DLSI_MOVING_INTERNAL_H

#include "contact/columns.h"
#include "delassus/moving.h"

/* Fills gap and force of the closed form of a bar at time t, from its start. */
typedef void dlsi_moving_exact(double t, double *gap, double *force);
dlsi_moving_exact dlsi_exact_impact, dlsi_exact_bounce, dlsi_exact_fixed;

/* What a motion needs. Arrays are NULL until they are made. */
typedef struct dlsi_moving_scene {
  dls_moving_settings settings; /* with the scene's own values */
  const char *block;            /* jean-moving: scene of scene.c; else NULL */
  double h, time;               /* of a step, and whole */
  int steps, cycle;
  dls_fe_mesh mesh;
  double E, nu, rho;
  int *unknown; /* 2 * nodes of the mesh */
  int n;
  dls_fe_matrix K, M; /* M: empty on a path */
  int candidates;
  int *candidate_node; /* candidates */
  dlsi_columns HN, HT;
  double *gap;     /* candidates */
  double *load[2]; /* n each; load[1] may be NULL */
  double *x, *v;   /* n; NULL for 0 */
  int ramped;      /* 1: load[0] grows during the first half of the time, load[1] in the second */
  int shaken;      /* 1: the obstacle moves */
  dlsi_moving_exact *exact; /* NULL: none */
} dlsi_moving_scene;

/* Builds scene `name`; free it after a failure, too. */
dls_status dlsi_moving_build(dlsi_moving_scene *scene, const char *name,
                             const dls_moving_settings *settings, dls_error *error);
void dlsi_moving_free(dlsi_moving_scene *scene);

/* Computes the operators of a line of nodes (abscissae a, ascending, na) that presses on another
 * one (b, nb) of the same extent: with the hat functions psi of the first line and N of both,
 *
 *   A_ij = integral of psi_i N_j^a / w_i,  B_ij = that of psi_i N_j^b / w_i,  w_i = that of psi_i
 *
 * so that u_i = sum of A_ij u_j^a - sum of B_ij u_j^b is the mean of the jump under psi_i, and r_i
 * = p w_i the reaction of a pressure p. A: na x na, B: na x nb, both row-major, zeroed before. */
void dlsi_mortar_line(int na, const double *a, int nb, const double *b, double *A, double *B);

#endif
