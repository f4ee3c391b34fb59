/*
 * delassus/moving.h: scenes of bodies that move in the finite element module (libdelassus-fe): bars
 * that hit a wall, with closed forms; the block of [Jean 1988] on an obstacle that moves to and
 * fro; a block that is thrown on the ground; two deformable blocks pressed together. The motion is
 * that of motion.h.
 *
 * The bars are columns of four-node elements whose two nodes of a height move together and up or
 * down only, with nu = 0: bars of linear elements.
 */
#ifndef DELASSUS_MOVING_H
#define DELASSUS_MOVING_H

#include "delassus/fe.h"
#include "delassus/motion.h"

#ifdef __cplusplus
extern "C" {
#endif

/* Settings: call dls_moving_settings_init, then change fields. NULL settings are the defaults,
 * which stand last in each comment. A scene ignores the fields that it does not need. */
typedef struct dls_moving_settings {
  dls_limits limits;     /* of the contact problems; those of motion.h */
  size_t size;           /* set by init; settings without it are refused */
  dls_motion_law law;    /* 0: the scene's own; 0 */
  dls_method method;     /* of the contact problems; DLS_AUTO */
  dls_fe_mass_kind mass; /* 0: the scene's own; 0 */
  double theta;          /* 0: 1/2 in the velocity form, 1 in the gap form; 0 */
  double restitution;    /* < 0: the scene's own; -1 */
  double mu;             /* < 0: the scene's own; -1 */
  double courant;        /* bars: h c / l of a step h; 0: the scene's own; 0 */
  int steps;             /* equal steps of the whole time, before courant; 0: the scene's own; 0 */
  int nx, ny; /* elements along x and y, of the lower of two blocks; bars: nx along the bar; 0: the
                 scene's own; 0 */
  int upper;  /* two-blocks: elements of the upper block along x; 0: the scene's own; 0 */
  double
      amplitude; /* jean-moving: amplitude of the obstacle; < 0: the scene's own; -1      length */
  double frequency; /* jean-moving: of the obstacle; 0: 1 on a path, else 1000; 0        1 / time */
  int measure; /* 1: solves each contact problem a second time, from r = 0, to measure its cost and
                  what the warm start saves; 0 */
} dls_moving_settings;

/* Sets each field to its default. */
DLS_API void dls_moving_settings_init(dls_moving_settings *settings);

/* Return names ("bar-impact", ...) and one-line descriptions, index 0 ..; NULL past the last. */
DLS_API const char *dls_moving_name(int index);
DLS_API const char *dls_moving_description(int index);

typedef struct dls_moving dls_moving;

/* Creates the scene `name` before its first step: *out, NULL on error. DLS_E_ARGUMENT: no scene of
 * that name, or a setting outside its range, which *error names; DLS_E_SETTINGS; the errors of
 * dls_fe_sparse_stiffness and dls_motion_create. */
DLS_API DLS_MUST_USE dls_status dls_moving_create(dls_moving **out, const char *name,
                                                  const dls_moving_settings *settings,
                                                  dls_error *error);

/* Takes a step. Statuses of dls_motion_step; another one than DLS_OK leaves the scene at the last
 * step. DLS_E_ARGUMENT "moving" after the last step. */
DLS_API DLS_MUST_USE dls_status dls_moving_step(dls_moving *moving, dls_error *error);

/* A scene after a step. All arrays belong to the scene and change with the next step. */
typedef struct dls_moving_data {
  const char *name;
  dls_moving_settings settings; /* as the scene runs, its own values filled in */
  int dynamic;                  /* 1: with mass; 0: a path of equilibria */
  int has_exact;                /* 1: exact_gap and exact_force are known */
  int obstacle_moves;           /* 1: the obstacle moves to and fro */
  double h;                     /* of a step                                        time */
  double element;               /* bars: length of an element                       length */
  int steps;                    /* of the whole time */
  int cycle; /* jean-moving: steps of a cycle; two-blocks: of each part; else steps */
  const dls_fe_mesh *mesh;
  double E, nu, rho;             /* of the material */
  const dls_motion_model *model; /* M, K, H_N, H_T, gap */
  const int *unknown;            /* 2 mesh nodes: number in the model, -1 if supported */
  int candidates;
  const int *candidate_node; /* candidates: node of the mesh */

  int step;                   /* done */
  dls_motion_state state;     /* of motion.h */
  dls_motion_energies energy; /* of motion.h */
  double energy_start;        /* kinetic and elastic, at the start                  work */
  const double *displacement; /* 2 mesh nodes                                       length */
  const double *reaction;     /* 2 mesh nodes: mean forces of the step; zero at the start   force */
  const double *r;            /* 2 candidates: the same, local (n, t)                     force */
  double obstacle;            /* jean-moving: where the obstacle is                       length */
  double impulse[2];          /* sum of the p of all candidates so far, n and t; on a path 0 */
  double variation;           /* total variation of the sum of r_n so far                 force */
  double exact_gap;           /* bars: closed form of the gap, and of the force at the middle */
  double exact_force;         /*   of the step */
  double gap_error;     /* bars: L2 norm over time of gap - exact_gap, over that of exact_gap */
  dls_info info;        /* of the contact problem of the step */
  long long iterations; /* of the methods so far */
  long long cold_iterations;            /* the same from r = 0, with settings.measure */
  double step_seconds, contact_seconds; /* CPU so far: steps, and contact problems from r = 0 */
} dls_moving_data;

/* Sets *data to views of the scene, which live as long as it does; all zero if moving is NULL. */
DLS_API void dls_moving_get(const dls_moving *moving, dls_moving_data *data);

/* Returns the contact problem of the last step, of the contacts that took part in it: a view that
 * lives until the next step. nc = 0 without any, and on a path that is solved on K.
 * DLS_E_ARGUMENT. */
DLS_API DLS_MUST_USE dls_status dls_moving_problem(const dls_moving *moving, dls_contact *problem,
                                                   dls_error *error);

/* Frees the scene; NULL is fine. */
DLS_API void dls_moving_destroy(dls_moving *moving);

#ifdef __cplusplus
}
#endif

#endif
