/*
 * race.h: the methods side by side on one contact problem, for chart, map and profile: who takes
 * part, what each needed for a tolerance, and where each gave up.
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

#include "console/palette.h"
#include "problem/matrices.h"

/* ---- race.c ---------------------------------------------------------------------------------- */

/* The options of chart and profile. */
typedef struct race_options {
  source from;
  int repeat;
  double limit, budget;
  const char *out;
} race_options;
extern const option_row race_option_rows[];

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

/* Returns the least CPU of those who answered the rung, INFINITY if none did. */
double race_fastest(const race *a, int rung);

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
