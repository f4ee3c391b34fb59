/*
 * bench.h: what the benchmark programs share: problems of any size, the peer.
 */
#ifndef BENCH_H
#define BENCH_H

#include <stddef.h>

#include "delassus.h"

/* ---- problems (problems.c) ------------------------------------------------------------------- */

/* An LCP that owns its arrays; release with problem_free. */
typedef struct problem {
  char name[64];
  int n;
  double *M; /* n x n, column-major */
  double *q; /* n */
} problem;

void problem_free(problem *p);
dls_lcp problem_view(const problem *p);

/* Random LCP of size n, the same on every machine up to the rounding of BLAS. 0, or -1 if there is no
 * memory. */
int problem_random(problem *p, int n);

/* A contact problem that owns its arrays. */
typedef struct lining {
  dls_contact contact;
  double *W, *q, *mu;
} lining;

/* The elastic lining of problems.c with nc >= 2 candidates; then its LCP, of size 3 nc. 0 or -1. */
int lining_create(lining *l, int nc);
void lining_free(lining *l);
int problem_from_lining(problem *p, const lining *l);

/* DIR/NAME_M.mtx and DIR/NAME_q.mtx. 0, or -1 with a message on stderr. */
int problem_read(problem *p, const char *directory, const char *name);

/* ---- the peer (peer.c) ----------------------------------------------------------------------- */

/* Siconos Numerics, lexicographic Lemke, on the n x n matrix M, `calls` times from z = w = 0 (n). *cpu
 * receives the CPU time of one call, *pivots their number. Returns what the last call returns, 0 for
 * success; -1 if the calls could not be set up. */
int peer_lemke(int n, double *M, double *q, int calls, double *z, double *w, double *cpu,
               int *pivots);

#endif
