/*
 * delassus/forming.h: the forming scenes of [Chabrand 1998] section 5 in the finite element module
 * (libdelassus-fe): a body of four-node elements Q4/P0, plane strain or axisymmetric, finite
 * elastoplasticity, pressed against a rigid profile with Coulomb friction, in load steps.
 *
 * A step is the paper's Table 1: a contact loop that updates the local frames of the contacts, and
 * within it the equilibrium loop, Newton's method with frozen frames. Each linearised contact
 * problem
 *
 *   K dx = -F(x) + H r,   u = H^T dx + g(x),   the laws of contact.h between u and r     (24), (25)
 *
 * is solved by the method of settings.contact. A step is done when equilibrium and contact.h's
 * certificate hold.
 */
#ifndef DELASSUS_FORMING_H
#define DELASSUS_FORMING_H

#include "delassus/solve.h"

#ifdef __cplusplus
extern "C" {
#endif

/* Methods for a linearised contact problem. */
typedef enum dls_forming_contact {
  DLS_FORMING_CONDENSED = 1,            /* W, q by the reduction, then settings.method */
  DLS_FORMING_GAUSS_SEIDEL = 2,         /* on the symmetric part of K, primal.h */
  DLS_FORMING_AUGMENTED_LAGRANGIAN = 3, /* springs in K, multipliers updated in the contact loop */
  DLS_FORMING_PENALTY = 4               /* stiffer springs, no multipliers */
} dls_forming_contact;

/* The method that solved the linearised problems of a step. Method auto tries the first three in
 * turn before it halves a step; each other method is the fourth. */
typedef enum dls_forming_way {
  DLS_FORMING_ON_K = 0,     /* auto: Newton's method on K, on W if that fails */
  DLS_FORMING_ON_W = 1,     /* auto: auto on W */
  DLS_FORMING_BY_LEMKE = 2, /* auto: Lemke's method on W */
  DLS_FORMING_BY_METHOD = 3 /* the method of the settings */
} dls_forming_way;

/* Settings: call dls_forming_settings_init, then change fields. NULL settings are the defaults,
 * which stand last in each comment. */
typedef struct dls_forming_settings {
  size_t size;        /* set by init; settings without it are refused */
  int nx, ny;         /* elements along x and y; 0: the scene's own; 0 */
  int steps;          /* equal steps of the whole travel; 0: the scene's own; 0 */
  double mu;          /* friction; < 0: the scene's own; -1 */
  int clamped;        /* indentation: the bottom sticks to its support; 0 */
  int standard;       /* 1: standard elements instead of Q4/P0, to see locking; 0 */
  int keep_trace;     /* update (13) as printed instead of det be = 1; 0 */
  double ram_mu;      /* extrusion: friction at the ram; >= 0; 0 */
  double penalty;     /* springs: eps over the stiffness of the node; 0: 30, 1000 for the
                         penalty method, whose error then shows; 1e6 to 1e10 hide it; 0 */
  int augmentations;  /* largest number of updates of the multipliers in a step; 0: the limit
                                  of the contact loop; 0 */
  double relaxation;  /* Gauss-Seidel: see primal.h; 1 */
  int aitken;         /* Gauss-Seidel: see primal.h; 1 */
  double tol;         /* on equilibrium and certificate; > 0; 1e-9 */
  double step_tol;    /* on the error of a step, below; < 1; 0: not estimated; 0 */
  double cpu_seconds; /* > 0: of the process in all steps together, then DLS_TIME_LIMIT;
                                  0: no limit; 0 */
  dls_forming_contact contact; /* DLS_FORMING_CONDENSED */
  dls_method method; /* of the condensed problem; DLS_LEMKE. DLS_AUTO: on K itself first */

  /* Called before each Newton step with the step of the scene and the error of equilibrium; another
   * value than 0 ends the step: DLS_CANCELLED; NULL, NULL */
  dls_progress_fn progress;
  void *progress_data;
} dls_forming_settings;

/* Sets each field to its default. */
DLS_API void dls_forming_settings_init(dls_forming_settings *settings);

enum { DLS_FORMING_MOST_STEPS = 25 }; /* of Newton's method in an equilibrium loop */

/* Return names ("indentation", "extrusion") and one-line descriptions, index 0 ..; NULL past the
 * last. */
DLS_API const char *dls_forming_name(int index);
DLS_API const char *dls_forming_description(int index);

typedef struct dls_forming dls_forming;

/* Creates the scene `name` at rest: *out, NULL on error. DLS_E_ARGUMENT: no scene of that name, or
 * a setting outside its range, which *error names; DLS_E_NOT_FINITE: mu; DLS_E_SIZE: nx times ny
 * elements are too many; DLS_E_SETTINGS, DLS_E_MEMORY. */
DLS_API DLS_MUST_USE dls_status dls_forming_create(dls_forming **out, const char *name,
                                                   const dls_forming_settings *settings,
                                                   dls_error *error);

/* Takes the next step. If a step fails, the other methods (dls_forming_way) are tried; then it is
 * halved, up to six times. Halves are another load path, with another plastic answer. Rounding, and
 * so the machine, can decide which of very large steps are halved.
 *
 * With step_tol > 0 each part of a step is repeated in two halves. The halves are kept if both
 * forces differ by at most step_tol times the largest force so far; otherwise each half is treated
 * in the same way, up to six times. data.step_error sums the differences. Without step_tol this is
 * done only if the force departs from its trend by more than 25 % of the largest force so far, to
 * confirm the jump.
 *
 *   DLS_OK          equilibrium and certificate hold to the tolerance, and there is no fault
 *                   (dls_forming_fault_kind). Penalty: equilibrium and the law of the springs hold;
 *                   the certificate shows the penalty's error
 *   DLS_FOLDED      the smallest part of the step has a fault
 *   DLS_STALLED     the smallest parts of the step failed
 *   DLS_TIME_LIMIT  settings.cpu_seconds is over; no fault
 *   DLS_CANCELLED   by settings.progress; no fault
 *   DLS_E_ARGUMENT  all steps are done
 *   DLS_E_MEMORY    a step allocates, for the reduction
 *
 * After DLS_FOLDED and DLS_STALLED data.fault says where and why. After these, DLS_TIME_LIMIT and
 * DLS_CANCELLED the state is the last good one, somewhere within the step; the next call tries
 * again. */
DLS_API DLS_MUST_USE dls_status dls_forming_step(dls_forming *forming, dls_error *error);

/* Frees the scene; NULL is fine. */
DLS_API void dls_forming_destroy(dls_forming *forming);

/* Why a step is refused. Elements, corners and nodes count from 0, as in the files
 * for ParaView. */
typedef enum dls_forming_fault_kind {
  DLS_FORMING_NO_FAULT = 0,
  DLS_FORMING_CORNER,   /* an element is turned inside out at a corner (DLS_FOLDED, as the next) */
  DLS_FORMING_SIDE,     /* a node is beyond the axis, a plane of symmetry or the floor */
  DLS_FORMING_INSIDE,   /* a node of the boundary is inside a tool */
  DLS_FORMING_CROSSING, /* the boundary crosses itself */
  DLS_FORMING_BALANCE,  /* the forces on the body do not add up to zero */
  DLS_FORMING_ENERGY,   /* the energy of the step does not add up */
  DLS_FORMING_JUMP,     /* the force jumps, and halving the step does not confirm it */
  DLS_FORMING_ELEMENT,  /* Newton's method turns an element inside out (DLS_STALLED, as the next) */
  DLS_FORMING_NEWTON    /* Newton's method does not contract */
} dls_forming_fault_kind;

typedef struct dls_forming_fault {
  dls_forming_fault_kind kind;
  int element, corner, node; /* -1: none */
  double travel;             /* target of the refused step; length */
  double value;              /* twice the area at the corner, depth, imbalance, .. */
  char text[96];             /* "element 37, corner 2 is inside out" */
} dls_forming_fault;

/* A tool or a support, which presses on the body. */
typedef struct dls_forming_tool {
  const char *name;
  double force[2];       /* on the body, (x, y)                     force */
  int points;            /* of its outline, counterclockwise; 0: none is drawn */
  const double *outline; /* 2 * points, current position      length */
} dls_forming_tool;

typedef struct dls_forming_mesh {
  int nodes, quads;
  double *xy; /* 2 * nodes, at rest                  length */
  int *node;  /* 4 * quads, counterclockwise */
} dls_forming_mesh;

/* Sums from the start. */
typedef struct dls_forming_count {
  int parts;      /* steps, those of halved steps counted each */
  int halvings;   /* steps that were halved */
  int handed;     /* steps that another method than the first one solved */
  int compared;   /* steps that were compared with two halves */
  int held;       /* nodes that the ram takes along, of the last step */
  int frames;     /* passes of the contact loop; augmentations */
  int newton;     /* steps of Newton's method: linearised contact problems */
  int reductions; /* condensations of K to W */
  int iterations; /* of the method: pivots, sweeps, .. */
} dls_forming_count;

/* CPU seconds from the start. */
typedef struct dls_forming_cpu {
  double assembly;  /* forces, tangent, return mapping */
  double reduction; /* factorisations of K, with springs or without; W and q, dx */
  double contact;   /* the method; Gauss-Seidel: its sweeps on K */
} dls_forming_cpu;

/* Work from the start; axisymmetric: per radian. */
typedef struct dls_forming_energy {
  double external, elastic, plastic, friction; /* force * length */
} dls_forming_energy;

/* Views that live until the next step. Reactions, frames and stresses are those at the end of the
 * last step, or at the point within the step where it had to stop. */
typedef struct dls_forming_data {
  const dls_forming_mesh *mesh;
  int axisymmetric; /* x is the radius, forces are per radian; else per unit thickness */
  int steps;
  double travel, whole;       /* of the tool or ram: so far, in all         length */
  double force;               /* resistance to it                           force */
  const double *displacement; /* 2 * nodes                                  length */
  const double *reaction;     /* 2 * nodes, on the body, (x, y)             force */
  int candidates;
  const int *candidate_node;    /* candidates */
  const int *candidate_tool;    /* candidates */
  const double *normal;         /* 2 * candidates; the tangent is (n_2, -n_1) */
  const double *u;              /* 2 * candidates: gap, slip of the step      length */
  const double *r;              /* 2 * candidates: r_n, r_t                   force */
  const double *stress;         /* 16 * quads: Cauchy (11, 22, 33, 12) of 4 points */
  const double *plastic_strain; /* 4 * quads, equivalent */
  double equilibrium;           /* |F - H r| / |F| of the last step */
  dls_certificate certificate;  /* each candidate with the others frozen, as in primal.h */
  double worst_equilibrium, worst_residual; /* of all steps */
  double balance, worst_balance; /* |sum of all forces on the body| over the sum of their sizes;
                                    axisymmetric: along the axis */
  double step_error;             /* with step_tol: estimate of the error of the force, summed over
                                    the steps                 force */
  dls_forming_way way;           /* method that solved the last step */
  dls_forming_fault fault;       /* of the last step that was refused */
  int tools;
  const dls_forming_tool *tool; /* tools */
  int residuals;                /* of the last equilibrium loop: |F - H r| / |F| before .. */
  double residual[DLS_FORMING_MOST_STEPS + 1]; /* .. each step and at its end */
  dls_forming_count count;
  dls_forming_cpu cpu;
  dls_forming_energy energy;
} dls_forming_data;

/* Sets *data to views of the scene; all zero if forming is NULL. */
DLS_API void dls_forming_get(const dls_forming *forming, dls_forming_data *data);

/* Returns the last linearised contact problem that DLS_FORMING_CONDENSED condensed, of the
 * contacts that may touch: a view that lives until the next step. DLS_E_ARGUMENT: there is none
 * yet (DLS_AUTO condenses only if it cannot solve on K). */
DLS_API DLS_MUST_USE dls_status dls_forming_problem(const dls_forming *forming,
                                                    dls_contact *problem, dls_error *error);

/* Writes an unstructured VTK XML file (.vtu, ascii) with displacement, contact force, contact
 * state (DLS_FREE 0, DLS_SLIP 1, DLS_STICK 2; -1 where there is no candidate), gap and slip of the
 * step per node, the tensor of Cauchy stress and the equivalent plastic strain per element (means
 * of its points). An element with a
 * corner that a tool presses flat is written as the two triangles that meet there. DLS_E_FILE:
 * cannot be opened, or written (no file is left behind). */
DLS_API DLS_MUST_USE dls_status dls_forming_write_vtu(const dls_forming *forming, const char *path,
                                                      dls_error *error);

/* Writes the outlines of the tools at their current positions, as polygons (.vtu), with the index
 * of the tool and its force on the body. DLS_E_FILE. */
DLS_API DLS_MUST_USE dls_status dls_forming_write_tools(const dls_forming *forming,
                                                        const char *path, dls_error *error);

#ifdef __cplusplus
}
#endif

#endif
