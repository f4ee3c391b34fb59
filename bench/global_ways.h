/* global_ways.h: one scene solved by one method, in a child process. */
#ifndef GLOBAL_WAYS_H
#define GLOBAL_WAYS_H

#include "delassus.h"
#include "surfaces.h"

/* ON_K: dls_global_create and dls_global_solve. ON_W, EITHER: dls_reduction_create, on W or as it
 * chooses, and dls_reduction_solve. PEER: global_peer.c. */
typedef enum way { ON_K, ON_W, PEER, EITHER, WAYS } way;

typedef struct result {
  int failed; /* 1: error, or refused */
  dls_status status;
  int n, nc, entries;             /* entries: of one triangle of K */
  int iterations, factorisations; /* of the solve; ON_W: iterations of auto's stages */
  double create, cpu;             /* s: create; create and solve */
  double bytes;                   /* most in use at the same time, without the model */
  double factor;                  /* ON_K: s of one factorisation, the fastest of three */
  dls_global_info foreseen;       /* ON_K */
  double foreseen_W;              /* ON_W: bytes, dls_reduction_estimate */
  int on_K;                       /* EITHER: 1 if K was chosen */
  double residual;                /* by the certificate; PEER: its own */
} result;

/* Solves the scene with friction mu everywhere to tol, `turns` times, each in its child process,
 * and returns the fastest. ON_W is refused where more than most_bytes are foreseen. */
result run_way(way w, const scene *plan, double mu, double tol, int turns, double most_bytes);

/* Solves a scene whose K is regular by the splitting as a careful user writes it with CHOLMOD,
 * until the residuals of positions and forces are at most tol (global_peer.c). r: d nc; x: n;
 * *iterations: at most 20000. Returns 0, 1 if it did not come there, -1 on an error. */
int peer_solve(const scene *S, double mu, double tol, double *r, double *x, int *iterations);

#endif
