/*
 * hard.h: shared by the files of bench/hard: hard 3D problems, one method on one of them, the page.
 */
#ifndef BENCH_HARD_H
#define BENCH_HARD_H

#include <stdint.h>
#include <stdio.h>

#include "delassus.h"
#include "regret_kinds.h"

/* ---- problems (regret_elastic.c) ------------------------------------------------------------- */

/* Returns "none", "rank", "border", "bonded". */
const char *hard_flaw_name(planted_flaw flaw);

/* Makes the planted problem of these numbers, d = 3. Returns 0, or -1 without memory. */
int hard_create(regret_problem *p, int nc, double condition, double mu, planted_flaw flaw,
                uint64_t seed);

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
hard_end hard_run(const regret_problem *p, int k, double seconds, double *cpu);

/* ---- the page (hard_report.c) ---------------------------------------------------------------- */

typedef struct hard_row {
  planted_flaw flaw;
  int nc, seed, method;
  double condition, mu, cpu, limit;
  hard_end end;
} hard_row;

/* Writes the tables of the rows, the lines on top first. */
void hard_report(FILE *page, int count, const hard_row *row);

#endif
