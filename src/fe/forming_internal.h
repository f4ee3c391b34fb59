/*
 * forming_internal.h: declares what a forming scene holds. forming_scene.c builds it,
 * forming_step.c takes its steps, forming.c runs the loops of a step, forming_contact.c solves the
 * linearised contact problems, forming_body.c certifies the body, forming_tools.c its tools.
 */
#ifndef DLSI_FORMING_INTERNAL_H
#define DLSI_FORMING_INTERNAL_H

#include <time.h>

#include "delassus/forming.h"
#include "delassus/primal.h"
#include "delassus/reduction.h"
#include "solid.h"

enum { dlsi_most_pieces = 3, dlsi_most_obstacles = 2 };

/* A rigid obstacle that candidates may touch. */
typedef struct dlsi_rigid {
  dlsi_piece piece[dlsi_most_pieces];
  dlsi_obstacle profile; /* where it stands at load 0 */
  double way[2];         /* its displacement at load 1 */
} dlsi_rigid;

/* The candidates that a linearised problem is solved on, one after the other. */
typedef struct dlsi_chosen {
  int count;
  int *mark;                /* nc   for each candidate: 1 if chosen */
  int *p, *i;               /* nc + 1, 2 nc   pattern of H_N and of H_T, compressed columns */
  double *normal, *tangent; /* 2 nc each      values of H_N and H_T */
  double *u, *r, *mu;       /* 2 nc, 2 nc, nc */
} dlsi_chosen;

enum { dlsi_most_tools = 4, dlsi_most_outline = 64 };

/* The end of a step before it is accepted. */
typedef struct dlsi_book {
  double force, external, friction; /* force; work of the step */
} dlsi_book;

/* A forming scene. A load is the fraction of the whole displacement reached, 0 to 1. n = 2 * nodes
 * unknowns, supported ones included; nc candidates. */
struct dls_forming {
  dls_forming_settings settings;
  /* the scene */
  dls_forming_mesh mesh;
  int axisymmetric, n, nc;
  dlsi_solid solid;
  dlsi_rigid rigid[dlsi_most_obstacles]; /* the last one moves */
  int rigids;
  double whole;   /* length of the displacement of the last obstacle */
  int holds;      /* 1: the last obstacle is a plane y = const that holds the nodes that it meets */
  double low[2];  /* planes of symmetry and of support: a body has x >= low[0], y >= low[1] */
  int *fixed;     /* n     1: supported or driven */
  double *rest;   /* n     position of a fixed unknown at load 0 */
  double *drive;  /* n     displacement of a fixed unknown at load 1 */
  int *candidate; /* nc    node */
  int *meets;     /* nc    obstacle of the candidate */
  int *candidate_tool; /* nc    tool of the candidate, as shown */
  double *mu;          /* nc    0 at a node that is supported along its tangent */
  int edges;
  int *edge;         /* edges  nodes of the boundary, counterclockwise */
  int *held;         /* nodes 1: the last obstacle holds the node */
  int *held0;        /* nodes at the end of the last step */
  int *turns;        /* nodes how often the step has changed it */
  int *candidate_of; /* nodes: the candidate, -1: none */
  /* the state; names with 0: at the end of the last step */
  int step;
  double seconds, begun; /* CPU of the previous steps, and at the start of this step */
  double load0, load;
  dls_forming_way way;             /* solves the linearised problems */
  int inside_out;                  /* element that failed last */
  double part;                     /* load of the last step or part; 0 after a failure */
  dlsi_point *old, *now;           /* 4 * quads */
  double *before, *x0, *x;         /* n     positions; before: one step earlier than x0 */
  double *r0, *r;                  /* 2 nc  reactions (n, t) */
  double *F;                       /* n     internal forces at x */
  double elastic, plastic;         /* energy and work at x */
  double *stress;                  /* 16 * quads */
  double *plastic_strain;          /* 4 * quads */
  double *displacement, *reaction; /* n */
  /* frames: taken with the nodes at `anchor`, then frozen */
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
  dls_solver *last_resort;  /* auto: Lemke's method, else NULL */
  dls_reduction *reduction; /* of the last condensed problem, NULL before the first */
  dls_contact problem;
  int *Kp, *Ki; /* Gauss-Seidel: the symmetric part of K by columns */
  double *Kx;
  int augmentations;    /* of the step so far */
  double *lambda, *eps; /* springs: 2 nc, nc */
  double *trial_u;      /* 2 nc */
  int *branch;          /* nc */
  dlsi_book book;
  double largest;        /* force so far */
  double slope;          /* of the force over the load, in the last step or part */
  dls_forming_data good; /* at the end of the last step */
  /* a copy of the state at the start of a step that is compared with two halves */
  dls_forming_data kept_data;
  double kept_load, kept_part, kept_largest, kept_slope;
  double *kept_before, *kept_x, *kept_r; /* n, n, 2 nc */
  int *kept_held;                        /* nodes */
  dlsi_point *kept_points;               /* 4 * quads */
  /* tools, as shown */
  double outline[dlsi_most_tools][2 * dlsi_most_outline];
  dls_forming_tool tool[dlsi_most_tools];
  /* the certificate's problem, W_cc = 1 / stiff_c */
  double *stiff;                              /* nc */
  int *node_p, *node_i;                       /* nc + 1, nc */
  double *node_W, *node_q, *node_r, *node_mu; /* 4 nc, 2 nc, 2 nc, nc */
  dls_forming_data data;
};

/* y += H r; y: n. */
void dlsi_forming_push(const dls_forming *f, const double *r, double *y);

/* Holds a node on the moving plane (on = 1), or lets it go. */
void dlsi_forming_hold(dls_forming *f, int node, int on);

/* Returns the friction on a contact whose node is held (nothing moves by it), else 0. */
double dlsi_forming_held_friction(const dls_forming *f, int c);

/* Returns the node of the largest force out of balance. */
int dlsi_forming_worst_node(const dls_forming *f);

/* Runs the contact loop at f->load, from x0 and r0, by the method f->way. */
dls_status dlsi_forming_contact_loop(dls_forming *f, dls_error *error);

/* Assembles and sets frames and positions at x, where assembly has succeeded before. */
void dlsi_forming_show(dls_forming *f);

/* Checks that the positions x are a body (forming_body.c); returns 0 and fills *fault if not. */
int dlsi_forming_is_body(const dls_forming *f, dls_forming_fault *fault);

/* Returns the corner of an element that a tool presses flat, -1 if there is none. */
int dlsi_forming_flat_corner(const dls_forming *f, int element);

/* Fills *fault with a kind, places (-1: none), a value and a text. */
void dlsi_forming_blame(dls_forming_fault *fault, dls_forming_fault_kind kind, int element,
                        int corner, int node, double value);

/* Tools (forming_tools.c). press: sums up the forces of the tools and their balance, from F and the
 * reactions of the candidates. move: brings the outlines to f->load. */
void dlsi_forming_press(dls_forming *f);
void dlsi_forming_move_tools(dls_forming *f);

/* Adds (FO8) of forming.c to y: y += b t t.(x - anchor). y: n. */
void dlsi_forming_turn(const dls_forming *f, double *y);

/* Solves the linearised contact problem at x by the method of the settings: reads K, F, u and r of
 * the scene, writes dx and next_r, and overwrites K. Returns DLS_STALLED if K is singular, or not
 * positive definite where it must be; DLS_OK also if the method has stopped early. */
dls_status dlsi_forming_direction(dls_forming *f, dls_error *error);

/* Springs, the penalty method and the augmented Lagrangian. springs: returns 1 if springs model the
 * contact. set_springs: sets the stiffness of the springs and their first multipliers for a step.
 * augment: renews the multipliers; stays: returns 1 if they stay for the rest of the step, so that
 * only the laws of the springs are left to solve. */
int dlsi_forming_springs(const dls_forming *f);
void dlsi_forming_set_springs(dls_forming *f);
void dlsi_forming_augment(dls_forming *f);
int dlsi_forming_stays(const dls_forming *f);

/* Returns the largest difference of r from the springs' reactions at u, less the effect of rounding
 * of the positions, over the largest reaction. */
double dlsi_forming_stretch(const dls_forming *f);

/* Returns the CPU seconds of the process. */
static inline double dlsi_forming_seconds(void) {
  return (double)clock() / CLOCKS_PER_SEC;
}

/* Returns the rest of settings.cpu_seconds. */
static inline double dlsi_forming_left(const dls_forming *f) {
  return f->settings.cpu_seconds - f->seconds - (dlsi_forming_seconds() - f->begun);
}

/* Returns 1 for a status after which nothing else is tried. */
static inline int dlsi_forming_is_over(dls_status status) {
  return status == DLS_TIME_LIMIT || status == DLS_CANCELLED;
}

#endif
