/*
 * method.h: a row of the table of methods (src/front/methods.c) for contact problems. Each method's
 * file ends with its row, const dlsi_method dlsi_<name>_method.
 */
#ifndef DLSI_METHOD_H
#define DLSI_METHOD_H

#include <stddef.h>

#include "contact.h"

struct dlsi_room; /* linear/room.h */

/* What a method is created from. A method reads only what it needs. */
typedef struct dlsi_options {
  dls_limits limits;
  int acceleration;      /* dls_acceleration, of sweeps */
  int facets;            /* of the friction cone of an LCP, d = 3; 0: the method's own */
  int positive_definite; /* 1: W is known to be symmetric positive definite */
  /* 1: a step of auto, which goes on from the r of earlier steps: no sweeps of other methods, no
   * answer but r and its certificate; a cold solve of splitting has a tiny rho. 2: sweeps with
   * momentum */
  int stage;
  int lazy;                   /* 1: auto may allocate while it solves what only later stages need */
  const char *plan, *without; /* of auto, from dls_solver_settings, checked; not kept */
  /* for the matrix, shared with methods that run before or after; NULL: a room of its own */
  struct dlsi_room *room;
} dlsi_options;

typedef struct dlsi_method {
  dls_method method;
  const char *name;    /* as --method and dls_method_find take it */
  const char *summary; /* one line for --help: for what, and when */
  /* As dls_solver_create, _solve and _destroy say; d, nc, the options and the problem have been
   * checked. */
  dls_status (*create)(void **out, int d, int nc, const dlsi_options *options, dls_error *error);
  dls_status (*solve)(void *work, const dls_contact *problem, double *r, double *u, dls_info *info,
                      dls_error *error);
  void (*destroy)(void *work);
  size_t limits; /* where the workspace has its dls_limits */
  /* After DLS_NO_SOLUTION_LIKELY, or a ray of Lemke's method, the direction along which the
   * reactions run away, m. NULL: the method does not return it. */
  const double *(*direction)(const void *work);
  /* As dls_solver_farkas says. NULL: the method proves nothing. */
  const double *(*farkas)(const void *work);
  /* Renames what the next solve takes from the last one: its contact c, of nc, is from[c] of that
   * one, -1: it is new. from NULL: there is no map. Called before each solve; NULL: the method
   * takes nothing but r. */
  void (*map)(void *work, int nc, const int *from);
  int takes_bodies; /* 1: solves a problem of bodies directly, 0: also needs W by blocks */
} dlsi_method;

/* Sets the limits of a workspace but for `blocks`, for which create has made room. */
static inline void dlsi_set_limits(const dlsi_method *of, void *work, const dls_limits *limits) {
  dls_limits *to = (void *)((char *)work + of->limits);
  const int blocks = to->blocks;
  *to = *limits;
  to->blocks = blocks;
}

#endif
