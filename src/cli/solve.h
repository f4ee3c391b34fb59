/* solve.h: what solve and study share: the options of a solve, and the solve itself. */
#ifndef SOLVE_H
#define SOLVE_H

#include "problem/matrices.h"

typedef struct solve_options {
  solver_options solver;
  source from;
  int lcp, proof, prove, print, explain;
  const char *out, *csv, *history, *plot; /* NULL: none */
  const char *limit;                      /* a file of loads: how much of it is carried; NULL */
} solve_options;

extern const command solve_command;
void solve_options_init(solve_options *options);

/* Checks the options of the solver against each other; returns 0 after a complaint. */
int settle_solve_options(solve_options *options);

/* Returns the source of the problem; with options that need W, on W. */
source solve_source(const solve_options *options);

/* An answer, and the solver that holds the vectors of its verdict. Start from {0}. */
typedef struct solution {
  dls_solver *solver; /* NULL: solved on K */
  double *r, *u, *x;  /* x: NULL for a problem without K */
} solution;
void solution_free(solution *a);

/* Solves a problem: fills a, and of o all but proofs and what is unsettled. */
dls_status problem_solve(problem *p, const solve_options *options, solution *a, outcome *o,
                         dls_error *error);

#endif
