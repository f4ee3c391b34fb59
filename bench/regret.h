/* regret.h: shared by the files of bench/regret: one problem solved by all, and the page. */
#ifndef REGRET_H
#define REGRET_H

#include <stdio.h>

#include "solvers.h"

/* ---- solving (regret_solve.c) ---------------------------------------------------------------- */

/* The CPU of a solve, s; INFINITY: not certified within the limit. */
typedef struct result {
  const char *kind; /* or a file */
  int size, nc;     /* contacts asked for, and made; size = 0 for a file */
  double mu, tol, limit;
  unsigned long seed;
  double automatic, best, peer;
  const char *method, *peer_method; /* of best and peer; "" */
  dls_status status;                /* auto's own */
  char stages[640]; /* of auto, as regret_stages writes them; "" where it is quick */
} result;

/* CPU of auto over that of the best method; where auto failed its limit takes the place of its
 * CPU. NAN if nothing solves the problem; .5 if no
 * method does in twice the CPU of auto. */
double regret_of(const result *r);

typedef struct regret_how {
  double seconds; /* limit of auto, s per 500 contacts, and of methods while none has solved s */
  int no_peer;    /* 1: without Siconos */
  int all;        /* 1: each method has that limit and is printed; 0: a method that takes longer
                     than the best so far and twice the CPU of auto is stopped */
  int info;       /* 1: each solve fills a dls_info, whose predicted error costs a factorisation of
                     a dense W of up to 300 rows */
} regret_how;

/* Solves s to tol by auto, by each method and by the peer. Fills automatic to stages of *r. */
void regret_solve(const scene *s, double tol, const regret_how *how, result *r);

/* ---- the page (regret_report.c) -------------------------------------------------------------- */

/* Prints tables: by band and tolerance, the worst, what auto does not solve, by kind. */
void regret_report(FILE *page, int count, const result *results);

#endif
