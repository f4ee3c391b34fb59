/*
 * profile.h: the picture of performance profiles, of delassus profile and of bench/solvers. It
 * needs nothing of cli.h.
 */
#ifndef PROFILE_H
#define PROFILE_H

/* Times of solvers on problems, one column of the picture for each target. */
typedef struct profile_picture {
  const char *directory, *name; /* NAME.dat, .gp, .png, .svg */
  const char *title;
  int solvers, problems, targets;
  const char *const *solver;  /* names; method_colour() knows them. 0 is auto */
  const int *peer;            /* solvers: 1 for another library, dashed; NULL: none is */
  const char *const *problem; /* names */
  const char *const *target;  /* "residual 1e-8" */
  const double *seconds;      /* (target * solvers + solver) * problems + problem; INFINITY: not
                                 solved */
} profile_picture;

/* Draws for each target the profiles [Dolan and More 2002]: the part of the problems that a solver
 * solves in at most tau times the CPU of the fastest, and below them every problem, from quick to
 * slow. Returns 1, or 0 after a complaint if a file cannot be written; a missing gnuplot is told
 * and forgiven. */
int draw_profiles(const profile_picture *p);

#endif
