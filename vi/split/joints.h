/*
 * joints.h: W + R of a structure, R = diag(rho_c), factorised on the motions of its joints.
 */
#ifndef DLSI_JOINTS_H
#define DLSI_JOINTS_H

#include "linear/cholesky.h"

typedef struct dlsi_joints {
  int d, nc, count, n; /* n: motions of all joints */
  int *first;          /* count + 1: joint j is list[first[j]] .. list[first[j + 1] - 1] */
  int *list;           /* nc */
  int *joint, *place;  /* nc: joint of each contact, its place among those of the joint */
  int *rank, *at;      /* count: motions, the first of these */
  size_t *basis;       /* count: Q_j begins at Q + basis[j]: unknowns x rank, column-major */
  size_t *inverse;     /* count: B_j^-1 begins at inverses + inverse[j]: rank x rank */
  double *Q, *inverses;
  double *c, *s, *t; /* n: scratch */
  int *row, *col;    /* of the lower triangle of B^-1, then of W', counted from 1 */
  double *value;
  size_t entries;
  dlsi_cholesky *factor; /* of W' + B^-1 */
} dlsi_joints;

/* Finds the joints of S W S / unit by blocks, and orders and analyses its matrix. *out = NULL on
 * error. DLS_STALLED if Q W' Q^T is not that W: it is not symmetric or not semidefinite.
 * DLS_E_MEMORY. S: m. */
dls_status dlsi_joints_create(dlsi_joints **out, const dls_contact *problem, const double *S,
                              double unit, dls_error *error);

/* Factorises for rho (nc). Returns 0, k > 0 if pivot k is not positive, -1 without memory. */
int dlsi_joints_factor(dlsi_joints *work, const double *rho);

/* motions := Q^T v (n), v := v - Q motions (m), its rounding errors set to 0. */
void dlsi_joints_split(const dlsi_joints *work, double *v, double *motions);

/* x := the solution of (W + R) x = R p - Q g with the rho of the factorisation; p, x: m, g: n. */
dls_status dlsi_joints_solve(dlsi_joints *work, const double *rho, const double *p, const double *g,
                             double *x, dls_error *error);

/* NULL is fine. */
void dlsi_joints_destroy(dlsi_joints *work);

#endif
