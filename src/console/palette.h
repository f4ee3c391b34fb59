/*
 * palette.h: the methods and the verdicts of a solve in tables and pictures.
 */
#ifndef PALETTE_H
#define PALETTE_H

#include "console.h"

/* A method that takes part, the same colour and point in every picture of the project. */
typedef struct contender {
  char name[32]; /* "nlgs", "nlgs+anderson" */
  dls_method method;
  dls_acceleration acceleration;
  int on_body;        /* 1: Gauss-Seidel on the displacements, of a problem with its model */
  const char *colour; /* "#rrggbb" */
  int point;          /* of gnuplot: a type of point */
} contender;

enum { MOST_CONTENDERS = 16 };

/* Fills list with auto, then every other method of the library, nlgs also with each acceleration,
 * and gauss-seidel on the displacements; returns how many. */
int list_contenders(contender list[MOST_CONTENDERS]);

/* Returns the colour, and the type of point, of a method by its name; grey for an unknown one. */
const char *method_colour(const char *name);
int method_point(const char *name);

/* The verdict on a solve: a word for tables and a colour for maps. */
typedef enum ending {
  ENDED_SOLVED = 0,
  ENDED_STALLED, /* no progress */
  ENDED_RAY,
  ENDED_LIKELY_NONE,
  ENDED_NONE, /* no solution: proved */
  ENDED_REFUSED,
  ENDED_UNDECIDED, /* no verdict: it met a limit */
  ENDED_FOLDED,    /* of scenes in steps: the mesh */
  ENDINGS
} ending;

/* Returns 1 for what answers the problem: a solution, or the proof that there is none. */
static inline int is_answer(ending e) {
  return e == ENDED_SOLVED || e == ENDED_NONE;
}

ending ending_of(dls_status status);
const char *ending_word(ending e);
const char *ending_colour(ending e);

#endif
