/*
 * profile.h: the picture of a performance profile, of delassus profile and of bench/solvers. It
 * needs no other header.
 */
#ifndef PROFILE_H
#define PROFILE_H

#include <math.h>

int command_profile(int argc, char **argv);

/* What stands for a time: not answered is INFINITY, met a limit is less than 0, took no part is
 * NaN. */
#define PROFILE_NOT_ANSWERED INFINITY
#define PROFILE_NOT_DECIDED  (-1.0)
#define PROFILE_TOOK_NO_PART NAN

/* Times of solvers on problems, to one tolerance. */
typedef struct profile_picture {
  const char *directory, *name; /* NAME.dat, .gp, .png, .svg */
  const char *title;
  int solvers, problems;
  const char *const *solver; /* names; method_colour() knows them. 0 is auto */
  const int *peer;           /* solvers: 1 for another library, dashed; NULL: none is */
  const double *seconds;     /* solver * problems + problem */
} profile_picture;

/* Draws the profiles [Dolan and More 2002] of all that take part in any problem: the fraction of
 * the problems that a solver answers in at most tau times the CPU of the fastest. Returns 1, or 0
 * after a complaint if a file cannot be written; a missing gnuplot is told and forgiven. */
int draw_profile(const profile_picture *p);

#endif
