/*
 * profile.h: the picture of performance profiles, of delassus profile and of bench/solvers. It
 * needs nothing of cli.h.
 */
#ifndef PROFILE_H
#define PROFILE_H

#include <math.h>

/* What stands for a time: not answered is INFINITY, met a limit is less than 0, took no part is
 * NaN. */
#define PROFILE_NOT_ANSWERED INFINITY
#define PROFILE_NOT_DECIDED  (-1.0)
#define PROFILE_TOOK_NO_PART NAN

/* Times of solvers on problems, one column of the picture for each target. */
typedef struct profile_picture {
  const char *directory, *name; /* NAME.dat, .gp, .png, .svg */
  const char *title, *notes;    /* notes: below it */
  const char *absent;           /* of a solver that takes part in no problem: "3D only" */
  int solvers, problems, targets;
  const char *const *solver; /* names; method_colour() knows them. 0 is auto */
  const int *peer;           /* solvers: 1 for another library, dashed; NULL: none is */
  const char *const *target; /* "residual 1e-8" */
  const double *seconds;     /* (target * solvers + solver) * problems + problem */
} profile_picture;

/* Draws for each target the profiles [Dolan and More 2002]: the part of the problems that a solver
 * answers in at most tau times the CPU of the fastest, and below them every problem, from quick to
 * slow. Returns 1, or 0 after a complaint if a file cannot be written; a missing gnuplot is told
 * and forgiven. */
int draw_profiles(const profile_picture *p);

#endif
