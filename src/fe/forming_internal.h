/* forming_internal.h: what a forming scene holds. */
#ifndef DLSI_FORMING_INTERNAL_H
#define DLSI_FORMING_INTERNAL_H

#include "delassus/forming.h"
#include "delassus/primal.h"
#include "delassus/reduction.h"
#include "solid.h"

enum { dlsi_most_pieces = 3 };

/* Candidates of a linearised problem, one after the other; H_N and H_T in compressed columns. */
typedef struct dlsi_chosen {
  int count;
  int *mark;                /* nc   of all candidates: whether it is chosen */
  int *p, *i;               /* nc + 1, 2 nc */
  double *normal, *tangent; /* 2 nc each: the values of H_N and H_T */
  double *u, *r, *mu;       /* 2 nc, 2 nc, nc */
} dlsi_chosen;

/* Load is the part of the whole way that has been gone, 0 to 1; n = 2 * nodes unknowns, supported
 * ones included; nc candidates. */
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
  /* the state; 0: at the end of the last step */
  int step;
  double load0, load;
  double part;                     /* load of the last step, or part; 0 after a failure */
  dlsi_point *old, *now;           /* 4 * quads */
  double *before, *x0, *x;         /* n     positions; before: a step before x0 */
  double *r0, *r;                  /* 2 nc  reactions (n, t) */
  double *F;                       /* n     internal forces at x */
  double elastic, plastic;         /* energy and work at x */
  double *stress;                  /* 16 * quads */
  double *plastic_strain;          /* 4 * quads */
  double *displacement, *reaction; /* n */
  /* frames, frozen where the nodes were at `anchor` */
  double *normal, *tangent, *anchor; /* 2 nc each */
  double *gap;                       /* nc */
  double *bend;                      /* nc    curvature r_n there */
  double *u;                         /* 2 nc  gap and slip at x */
  /* the linearised problem */
  dlsi_band band;
  double *rhs, *dx, *start_x; /* n */
  double *next_r, *start_r;   /* 2 nc */
  dlsi_chosen chosen;
  dls_solver *solver; /* condensed */
  int *Kp, *Ki;       /* Gauss-Seidel: the symmetric part of K by columns */
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

/* y (n) += b t t.(x - anchor), forming.c (S8) */
void dlsi_forming_turn(const dls_forming *f, double *y);

/* dx and next_r from the K, F and u at hand, by the method of the settings; K is used up.
 * DLS_STALLED if K is singular, or not positive definite where it must be; other statuses > 0 of
 * the method are good enough. */
dls_status dlsi_forming_direction(dls_forming *f, dls_error *error);

/* Whether contact is by springs; their stiffness and first multipliers for a step; the next
 * ones. */
int dlsi_forming_springs(const dls_forming *f);
void dlsi_forming_set_springs(dls_forming *f);
void dlsi_forming_augment(dls_forming *f);

/* The largest difference of r from the springs' reactions at u, beyond what rounding of the
 * positions makes of it, over the largest reaction. */
double dlsi_forming_stretch(const dls_forming *f);

/* CPU seconds of the process. */
double dlsi_forming_seconds(void);

#endif
