/*
 * race.h: the methods side by side on one contact problem, for chart, map and profile: who takes
 * part, in which colour, what each needed for a tolerance, and where each gave up.
 *
 * A limit is no verdict. A solve that ends at a limit goes on, until it has a verdict or is
 * "not decided":
 *
 *   its own limit of iterations   once more, with ten times as many; "no progress" if these do not
 *                                 halve the residual, else "not decided"
 *   CPU seconds of the plan       up to ten times as many, then "not decided"
 */
#ifndef RACE_H
#define RACE_H

#include "matrices.h"

/* ---- palette.c ------------------------------------------------------------------------------- */

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

/* ---- race.c ---------------------------------------------------------------------------------- */

/* One method, one tolerance. */
typedef struct trial {
  ending end;
  int asked; /* 0: the method gave up at a coarser tolerance, whose verdict stands here too */
  int iterations;
  int longer;               /* 1: solved beyond the method's own limit of iterations */
  double residual, seconds; /* of the certificate; CPU, the least of all repeats */
} trial;

typedef struct race_plan {
  int rungs;
  const double *tol; /* rungs: falling */
  int repeat;        /* how often a solve is timed, at most */
  double limit;      /* CPU seconds of a solve that may always be used; ten times in need */
  double budget;     /* CPU seconds of all, about */
} race_plan;

/* What the race found; start from {0}, race_free after a failed race, too. */
typedef struct race {
  int d, nc, rungs, count;
  const double *tol;
  contender who[MOST_CONTENDERS];
  trial *trials;              /* count x rungs: race_trial */
  double *answers;            /* count x rungs x m: race_answer, where solved */
  const dls_contact *problem; /* borrowed */
  const problem *body;        /* the model of the problem; NULL: none */
  double *x;                  /* its unknowns */
  const race_plan *plan;      /* while it runs */
  dls_solver *solver[MOST_CONTENDERS];
  int interrupted; /* 1: Ctrl-C ended it; trials that are missing are marked as over time */
} race;

/* Runs every contender down the ladder, from the coarsest tolerance on, interleaved, the solvers
 * made once: first once each, then again in turns. A method that gave up is not asked for more
 * digits. A solve may take limit, and 30 times what the fastest needed, and in need ten times that.
 * body: the problem whose model stands behind contact, for gauss-seidel, or NULL. Returns DLS_OK,
 * or an error of the problem. */
dls_status race_run(race *a, const dls_contact *contact, const problem *body, const race_plan *plan,
                    dls_error *error);
void race_free(race *a);

/* Solves once by contender k, within limits, from r as they say; the certificate in info is that of
 * the contact problem. */
dls_status race_call(race *a, int k, const dls_limits *limits, double *r, dls_info *info,
                     dls_error *error);

/* Returns 1 if the contender takes part in the race on a problem. */
int race_takes(const contender *who, const dls_contact *contact, const problem *body);

trial *race_trial(const race *a, int k, int rung);
double *race_answer(const race *a, int k, int rung);

/* Returns the least CPU of those who answered the rung, INFINITY if none did; singles = 1: auto
 * apart. */
double race_fastest(const race *a, int rung, int singles);

/* ---- history.c ------------------------------------------------------------------------------- */

enum { HISTORY_POINTS = 600, HISTORY_STAGES = 24 };

/* The residual of a solve as it went on. */
typedef struct history {
  int points, every, calls; /* of calls, every so manieth is kept */
  int iteration[HISTORY_POINTS];
  double residual[HISTORY_POINTS], seconds[HISTORY_POINTS];
  int stages, begin[HISTORY_STAGES]; /* iteration at which the stage began */
  const char *stage[HISTORY_STAGES];
  int before, last; /* iterations of the stages before; of this one so far */
} history;

/* Solves once more by contender k and records. */
dls_status record_history(history *h, race *a, int k, double tol, double limit, double *r,
                          dls_error *error);

#endif
