/*
 * trails.h: problems of many kinds, runs of the methods on them, and the record of a run, for
 * tuning/test_trails.
 */
#ifndef TRAILS_H
#define TRAILS_H

#include "delassus.h"
#include "rigid.h"

/* ---- problems (trails_problems.c) ------------------------------------------------------------ */

typedef struct trails_problem {
  char name[64];
  dls_contact p;
  rigid bodies; /* owns the arrays of p where bodies.p is set */
} trails_problem;

/* a->p := problem k in storage that lasts until the next call. Returns 0 past the last one. */
int trails_make(int k, trails_problem *a);
void trails_free(trails_problem *a);

/* Returns p with W and q disturbed by rounding, as symmetric, in other units. storage: takes
 * its arrays, which the caller frees. */
dls_contact trails_disturbed(const dls_contact *p, double *storage[2], unsigned *seed);

/* ---- runs (trails_runs.c) -------------------------------------------------------------------- */

enum { trails_runs = 15 }; /* of the methods, of a batch, of LCPs */
enum { trails_counts = 600, trails_sums = 120, trails_solves = 24 };

typedef struct trail {
  int counts, sums, solves, calls;
  int count[trails_counts];
  double sum[trails_sums];        /* of facts */
  char status[trails_solves + 1]; /* a letter for each solve */
  double sweeps, factorisations, steps, cost;
} trail;

/* Returns the rank of a letter of trail.status, 0 the best. Two letters of rank 0 say opposite
 * things. */
int trails_rank(char letter);

const char *trails_name(int run);
int trails_has(const dls_contact *p, int run); /* 1 if the run of a problem is worth its time */
void trails_run(const dls_contact *p, int run, trail *t);

/* What is known of a problem without solving it, of small ones. */
int trails_has_facts(const dls_contact *p);
void trails_facts(const dls_contact *p, trail *t);

/* The exact solutions, or the least bad points, of candidates alone; W and q disturbed, unless
 * disturbance is NULL. */
void trails_local(int number, unsigned *disturbance, trail *t);

#endif
