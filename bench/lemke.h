/*
 * lemke.h: shared by the files of bench/lemke: problems of any size, the peer.
 */
#ifndef BENCH_LEMKE_H
#define BENCH_LEMKE_H

#include <stddef.h>

#include "delassus.h"

/* ---- problems (lemke_problems.c) ------------------------------------------------------------- */

/* An LCP that owns its arrays; release with problem_free. */
typedef struct problem {
  char name[64];
  int n;
  double *M; /* n x n, column-major */
  double *q; /* n */
} problem;

void problem_free(problem *p);
dls_lcp problem_view(const problem *p);

/* Makes a random LCP of size n, equal on every machine up to the rounding of BLAS. Returns 0, or -1
 * without memory. */
int problem_random(problem *p, int n);

/* A contact problem that owns its arrays. */
typedef struct lining {
  dls_contact contact;
  dls_reduction *reduction;
  double *W, *q, *mu;
} lining;

/* Makes the elastic lining of lemke_problems.c with nc >= 2 candidates, and its LCP of size 3 nc.
 * Each returns 0, or -1 without memory. */
int lining_create(lining *l, int nc);
void lining_free(lining *l);
int problem_from_lining(problem *p, const lining *l);

/* Reads DIRECTORY/NAME_M.mtx and NAME_q.mtx. Returns 0, or -1 after a message on stderr. */
int problem_read(problem *p, const char *directory, const char *name);

/* ---- the peer (lemke_peer.c) ----------------------------------------------------------------- */

/* Runs the lexicographic Lemke of Siconos Numerics `calls` times on M (n x n) from z = w = 0 (n).
 * cpu: CPU seconds of one call; pivots: their number. Returns the status of the last call, 0 for
 * success, or -1 if the calls could not be set up. */
int peer_lemke(int n, double *M, double *q, int calls, double *z, double *w, double *cpu,
               int *pivots);

#endif
