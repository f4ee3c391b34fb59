/*
 * setting.h: a built-in scene at one setting, and the one number that stands for its answer.
 */
#ifndef SETTING_H
#define SETTING_H

#include "problem.h"

/* A setting. Fields that a scene does not have are 0. */
typedef struct setting {
  double tol;
  const char *method; /* of scenes in steps; NULL: auto */
  int nx, ny, upper;  /* elements; upper: of two-blocks */
  double grade;       /* equilibrium: of the mesh; 0: even */
  int steps;
  double mu;             /* < 0: the scene's own */
  int weighted;          /* equilibrium: weighted reactions */
  double penalty;        /* forming: > 0: the penalty method with this factor */
  int clamped;           /* indentation */
  dls_fe_mass_kind mass; /* bodies that move; 0 on a path */
} setting;

/* A scene of any kind, and what is asked of it. */
typedef struct scene {
  const char *name;
  scene_kind kind;
  const char *answer, *unit; /* "force on the cylinder", "N/mm" */
  setting own;
  double exact;     /* the answer in closed form; NaN: there is none */
  const char *says; /* what it is */
  double whole;     /* of a scene in steps: the whole way, or the whole time */
  int dynamic;      /* 1: steps have to follow the mesh */
  int friction;     /* 1: own friction is not 0 */
  int has;          /* bits 1 << OF_..: the quantities that it has */
  double grade;     /* of a second kind of mesh; 0: none */
  int tall;         /* 1: a second kind has elements half as wide and twice as high: a contact edge
                       that moves along x asks for many nodes there */
} scene;

/* What the answer is. The fields have PIECES values: the curve at the fractions 1/PIECES, 2/PIECES,
 * .. of the steps, the others in as many equal parts of the surface at rest: mean pressure, the
 * fraction that touches, the fraction that slips; at the end, of bodies that move the means over
 * time. */
typedef enum quantity_of {
  OF_FORCE, /* the one number */
  OF_CURVE,
  OF_PRESSURE,
  OF_EDGE,
  OF_SLIP,
  OF_DRIFT, /* of energy, bodies that move: worst error of a step's balance over its scale */
  OF_COUNT
} quantity_of;

enum { PIECES = 50 };

/* The answer at a setting. */
typedef struct scene_answer {
  dls_status status;
  double field[OF_COUNT][PIECES];
  double reduction; /* CPU seconds of these: the reduction of an equilibrium */
  double value;     /* NaN if the scene did not finish */
  double seconds;   /* of CPU, from the model on: the least of up to three runs of a short scene */
  double part;      /* of the steps that are done, 0 to 1 */
  double drift;     /* OF_DRIFT */
  double gap;       /* bars: error of the gap beside the closed form; else NaN */
} scene_answer;

/* Finds a scene of any kind by its name and its own setting. Returns 0 if there is none of that
 * name; *status < 0: *error tells. */
int scene_find(const char *name, scene *s, dls_status *status, dls_error *error);

/* Runs the scene. limit: CPU seconds, after which it stops with DLS_TIME_LIMIT. Returns a status
 * < 0 with *error, or DLS_OK. */
dls_status scene_run(const scene *s, const setting *at, double limit, scene_answer *out,
                     dls_error *error);

/* Returns how far `a` is from `b` in a quantity: |a - b| / |b| of the number; of curve and pressure
 * the L2 norm of the difference over that of b; of edge and slip zone the length where a and b
 * differ over the length that touches in b; the drift of a. */
double answer_distance(const scene_answer *a, const scene_answer *b, quantity_of of);

/* Returns 1 if both are the same. */
int setting_is(const setting *a, const setting *b);

/* Returns the scene's own setting with 2^(mesh/2) times the elements along each side, 2^steps times
 * the steps (of a dynamic scene times 2^(mesh/2) besides), and tol / 10^tol. */
setting setting_scaled(const scene *s, int mesh, int steps, int tol);

/* Sets *at to variant k of the model at the scene's own setting and returns its name, two words or
 * more; "" for one that the scene does not have, NULL beyond the last. */
const char *setting_variant(const scene *s, int k, setting *at);

/* Writes the options of `delassus scene` that set `at` ("--mesh=20x20 --steps=100 --tol=1e-04"),
 * or, options = 0, the same in words ("20 x 20, 100 steps, tol 1e-04"); returns text. */
enum { SETTING_ROOM = 160 };
const char *setting_text(const scene *s, const setting *at, int options, char text[SETTING_ROOM]);

#endif
