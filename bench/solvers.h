/*
 * solvers.h: shared by the files of bench/solvers: the peer, one measured call.
 */
#ifndef SOLVERS_H
#define SOLVERS_H

#include "delassus.h"
#include "solvers_scenes.h"

/* ---- one call in a process of its own (solvers_call.c) --------------------------------------- */

/* How a call ended. */
typedef enum ending {
  ENDED = 0,
  REFUSED = 1, /* it returned an error, or cannot take this problem */
  LIMIT = 2,   /* CPU limit */
  CRASH = 3    /* a signal, or exit() */
} ending;

typedef struct outcome {
  ending ended;
  int claim;         /* the solver says "solved" */
  dls_status status; /* of a method of delassus */
  int iterations;    /* as the solver counts them; -1 for unknown */
  int calls;         /* between two readings of the clock */
  double cpu;        /* of a solve, s; the smallest of several readings if that is short */
  double setup;      /* of what goes with each call but is not the solve: creating, destroying */
  dls_certificate certificate; /* of the answer; INFINITY without one, or for NaN */
} outcome;

/* Solves s `calls` times to its own `tol` by the method that `how` describes, each time from r (m)
 * = 0. Fills all of *o but the certificate, for one call. */
typedef void (*solve_fn)(const void *how, const scene *s, double tol, int calls, double *r,
                         outcome *o);

/* Runs solve() in a child process that is stopped after `limit` seconds of CPU, and certifies the
 * answer. */
outcome measure(const scene *s, solve_fn solve, const void *how, double tol, double limit);

/* Returns the CPU of a solve whose certificate holds, INFINITY for another one. */
double outcome_seconds(const outcome *o, double tol);

/* ---- delassus (solvers_own.c) ---------------------------------------------------------------- */

/* A method, or a step of auto. */
typedef struct own_method {
  const char *name, *method, *acceleration;
  int most[2];      /* contacts in 2D and 3D beyond which it is not tried */
  const char *step; /* the plan of auto; NULL: its own */
  double limit;     /* CPU seconds; 0: none */
  int no_info;      /* 1: without a dls_info */
  int setup;        /* 1: outcome.setup of short calls is what dls_solve takes beyond the solve on a
                       solver that is there already; else: creating and destroying */
} own_method;

/* Solves by the own_method `how`: a solve_fn. A global problem is reduced within each call. */
void own_solve(const void *how, const scene *s, double tol, int calls, double *r, outcome *o);

/* Fills the settings of a method for a problem; sweeps have no limit of iterations. */
void own_settings(dls_solver_settings *settings, const own_method *w, const dls_contact *problem,
                  double tol);

/* ---- the peer (solvers_peer.c) --------------------------------------------------------------- */

/* A solver of Siconos Numerics with one setting and one storage of W. */
typedef struct peer_method peer_method;

/* Returns setting `index` of the list, from 0; NULL past the last. */
const peer_method *peer_at(int index);
const char *peer_name(const peer_method *p);    /* of the solver, "siconos-nsgs" */
const char *peer_setting(const peer_method *p); /* "default", ... */
int peer_pivots(const peer_method *p);          /* takes no tolerance */

/* Returns the storage of W that p gets: "dense", "blocks", "sparse"; a dense W stays dense. */
const char *peer_storage(const peer_method *p, const scene *s);

/* Returns 1 if p can be tried on s. patient = 0: only a p that was fastest somewhere. */
int peer_takes(const peer_method *p, const scene *s, int patient);

/* Solve s by the peer_method `how`; each is a solve_fn. The storage is converted and the options
 * are made outside of the time measured: by peer_solve for each call, by peer_solve_again once. */
void peer_solve(const void *how, const scene *s, double tol, int calls, double *r, outcome *o);
void peer_solve_again(const void *how, const scene *s, double tol, int calls, double *r,
                      outcome *o);

/* Runs p down its own tolerances, from 10 tol on, until its answer is certified to tol. limit: CPU
 * seconds of one run, besides .1 for converting W. */
outcome peer_reach(const peer_method *p, const scene *s, double tol, double limit);

#endif
