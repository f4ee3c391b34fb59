/* global_ways.h: one scene solved by one method, in a child process. */
#ifndef GLOBAL_WAYS_H
#define GLOBAL_WAYS_H

#include "delassus.h"
#include "surfaces.h"

/* ON_K: dls_global_create and dls_global_solve. ON_W: bench_reduce, dls_solve (auto),
 * dls_reduction_recover. PEER: global_peer.h. EITHER: dls_reduction_create and
 * dls_reduction_solve. */
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
  double residual, equilibrium;   /* by the certificate; PEER: its own */
} result;

/* Solves the scene with friction mu everywhere to tol, `turns` times, each in its child process,
 * and returns the fastest. ON_W is refused where more than most_bytes are foreseen. */
result run_way(way w, const scene *plan, double mu, double tol, int turns, double most_bytes);

#endif
