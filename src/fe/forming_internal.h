/*
 * forming_internal.h: declares what a forming scene holds. forming_scene.c builds it, forming.c
 * runs the loops on it, forming_contact.c solves the linearised contact problems for forming.c.
 */
#ifndef DLSI_FORMING_INTERNAL_H
#define DLSI_FORMING_INTERNAL_H

#include <time.h>

#include "delassus/forming.h"
#include "delassus/primal.h"
#include "delassus/reduction.h"
#include "solid.h"

enum { dlsi_most_pieces = 3 };

/* The candidates that a linearised problem is solved on, one after the other. */
typedef struct dlsi_chosen {
  int count;
  int *mark;                /* nc   for each candidate: 1 if chosen */
  int *p, *i;               /* nc + 1, 2 nc   pattern of H_N and of H_T, compressed columns */
  double *normal, *tangent; /* 2 nc each      values of H_N and H_T */
  double *u, *r, *mu;       /* 2 nc, 2 nc, nc */
} dlsi_chosen;

/* A forming scene. A load is the part of the whole way that is behind, 0 to 1. n = 2 * nodes
 * unknowns, supported ones included; nc candidates. */
struct dls_forming {
  dls_forming_settings settings;
  /* the scene */
  dls_forming_mesh mesh;
  int axisymmetric, n, nc;
  dlsi_solid solid;
  dlsi_piece piece[dlsi_most_pieces];
  dlsi_obstacle obstacle; /* where it stands at load 0 */
  double way[2];          /* of the obstacle up to load 1 */
  double whole;           /* length of the way of obstacle or ram */
  int *fixed;             /* n     1: supported or driven */
  double *drive;          /* n     displacement of a fixed unknown at load 1 */
  int *candidate;         /* nc    node */
  double *mu;             /* nc    0 at a node that is supported along its tangent */
  int *driven;            /* nc    1 at one that its support drives along */
  /* the state; names with 0: at the end of the last step */
  int step;
  double load0, load;
  double part;                     /* load gone in the last step or part; 0 after a failure */
  dlsi_point *old, *now;           /* 4 * quads */
  double *before, *x0, *x;         /* n     positions; before: one step before x0 */
  double *r0, *r;                  /* 2 nc  reactions (n, t) */
  double *F;                       /* n     internal forces at x */
  double elastic, plastic;         /* energy and work at x */
  double *stress;                  /* 16 * quads */
  double *plastic_strain;          /* 4 * quads */
  double *displacement, *reaction; /* n */
  /* frames, taken with the nodes at `anchor` and frozen */
  double *normal, *tangent, *anchor; /* 2 nc each */
  double *gap;                       /* nc */
  double *bend;                      /* nc    curvature r_n at the anchor */
  double *u;                         /* 2 nc  (u_n, u_t) at x, (FO7) */
  /* the linearised problem */
  dlsi_band band;
  double *rhs, *dx, *start_x; /* n */
  double *next_r, *start_r;   /* 2 nc */
  dlsi_chosen chosen;
  dls_solver *solver;       /* of the condensed problem */
  dls_reduction *reduction; /* of the last condensed problem, NULL before the first */
  dls_contact problem;
  int *Kp, *Ki; /* Gauss-Seidel: the symmetric part of K by columns */
  double *Kx;
  double *lambda, *eps; /* springs: 2 nc, nc */
  double *trial_u;      /* 2 nc */
  int *branch;          /* nc */
  /* the certificate's problem, W_cc = 1 / stiff_c */
  double *stiff;                              /* nc */
  int *node_p, *node_i;                       /* nc + 1, nc */
  double *node_W, *node_q, *node_r, *node_mu; /* 4 nc, 2 nc, 2 nc, nc */
  dls_forming_data data;
};

/* Adds (FO8) of forming.c to y: y += b t t.(x - anchor). y: n. */
void dlsi_forming_turn(const dls_forming *f, double *y);

/* Solves the linearised contact problem at x by the method of the settings: reads K, F, u and r of
 * the scene, writes dx and next_r, and overwrites K. Returns DLS_STALLED if K is singular, or not
 * positive definite where it must be; DLS_OK also where the method has stopped early. */
dls_status dlsi_forming_direction(dls_forming *f, dls_error *error);

/* Springs, the penalty method and the augmented Lagrangian. springs: returns 1 if contact is by
 * springs. set_springs: sets the stiffness of the springs and their first multipliers for a step.
 * augment: renews the multipliers. */
int dlsi_forming_springs(const dls_forming *f);
void dlsi_forming_set_springs(dls_forming *f);
void dlsi_forming_augment(dls_forming *f);

/* Returns the largest difference of r from the springs' reactions at u, less what rounding of the
 * positions makes of it, over the largest reaction. */
double dlsi_forming_stretch(const dls_forming *f);

/* Returns the CPU seconds of the process. */
static inline double dlsi_forming_seconds(void) {
  return (double)clock() / CLOCKS_PER_SEC;
}

#endif
