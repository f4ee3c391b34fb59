/*
 * hard.h: shared by the files of bench/hard: hard 3D problems, one method on one of them, the page.
 */
#ifndef BENCH_HARD_H
#define BENCH_HARD_H

#include <stdint.h>
#include <stdio.h>

#include "delassus.h"

/* ---- problems (hard_problems.c) -------------------------------------------------------------- */

typedef enum hard_flaw { HARD_NONE, HARD_RANK, HARD_BORDER, HARD_BONDED, HARD_FLAWS } hard_flaw;

/* Returns "none", "rank", "border", "bonded". */
const char *hard_flaw_name(hard_flaw flaw);

typedef struct hard_problem {
  dls_contact contact;
  double *W, *q, *mu, *r; /* r: the answer that q was made for */
} hard_problem;

/* Makes the problem of these numbers: d = 3, nc contacts, W dense with eigenvalues from 1 to 1 /
 * condition. Returns 0, or -1 without memory. */
int hard_create(hard_problem *p, int nc, double condition, double mu, hard_flaw flaw,
                uint64_t seed);
void hard_free(hard_problem *p);

/* ---- one method (hard_solve.c) --------------------------------------------------------------- */

/* Why a run ended, as hard_solve.c decides. */
typedef enum hard_end {
  HARD_SOLVED,
  HARD_CYCLE,     /* the reactions return to what they were */
  HARD_RAY,       /* they grow along a ray */
  HARD_STUCK,     /* no progress: the method gave up, or the residual no longer falls */
  HARD_WRONG,     /* reports that there is no solution */
  HARD_UNDECIDED, /* limit of time or iterations reached: no verdict */
  HARD_REFUSED,   /* not for this problem */
  HARD_ENDS
} hard_end;

/* Return the word of an ending, and the name of method k; NULL past the last. */
const char *hard_end_name(hard_end end);
const char *hard_method_name(int k);

/* Runs method k to 1e-8 within `seconds` of CPU, and if it meets the limit, again within ten times
 * that. cpu: of the last run. */
hard_end hard_run(const hard_problem *p, int k, double seconds, double *cpu);

/* ---- the page (hard_report.c) ---------------------------------------------------------------- */

typedef struct hard_row {
  hard_flaw flaw;
  int nc, seed, method;
  double condition, mu, cpu, limit;
  hard_end end;
} hard_row;

/* Writes the tables of the rows, the lines on top first. */
void hard_report(FILE *page, int count, const hard_row *row);

/* ---- the fold (hard_fold.c) ------------------------------------------------------------------ */

/* Writes the table of bounds on the friction from which some loads have two answers. Returns 0, or
 * 1 after a message. */
int hard_fold_table(FILE *page);

#endif
