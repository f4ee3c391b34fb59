/*
 * check.h: one problem, solved by many methods, and what the answers must not claim.
 */
#ifndef PROPERTIES_CHECK_H
#define PROPERTIES_CHECK_H

#include "delassus/solve.h"
#include "problem.h"

typedef enum rule {
  KEPT = 0,
  REFUSED,    /* an error for a sound problem */
  LIKELY,     /* 1: solvable, and the status is DLS_NO_SOLUTION_LIKELY */
  PROVED,     /* 1: solvable, and the status is DLS_NO_SOLUTION */
  NOT_HELD,   /* 2: DLS_OK or DLS_TO_ROUNDING, and the residual of positions does not hold */
  NOT_HELD_R, /* 2: DLS_OK, and the residual of forces does not hold */
  UNSEEN,     /* 3: not DLS_OK, and the answer holds, or its residual is 0; to rounding likewise */
  CONTRADICTION, /* 4: one run denies a solution, another one has an answer that holds */
  BITS,          /* 5: powers of four of W, of two of q change a bit of r, or the status */
  ODD_BITS,      /* 5: so does an odd power of two of W, whose square root is rounded */
  UNITS,         /* 5: such an odd power changes the verdict, solved or not */
  ORDER,         /* 6: another order of the candidates is solved, this one not, or the reverse */
  NO_PROOF,      /* 7: DLS_NO_SOLUTION without a proof that is exact */
  TRUE_R,        /* 8: DLS_OK, and r is far from the true answer; the library does not say so */
  TRUE_U,        /* 8: likewise u */
  RULES
} rule;

extern const char *const rule_text[RULES];

/* One way to solve a problem. */
typedef struct run {
  dls_method method;
  int rows; /* 0: the contact problem by `method`; 3, 4: Lemke on its LCP of so many rows (d = 2) */
  int crash;   /* LCP: dls_lemke_settings.crash */
  int blocks;  /* 1: W by blocks */
  int front;   /* 1: dls_solve, not dls_solver_solve */
  int warm;    /* 1: from reactions drawn by `seed`; 2: from the answer of the run before */
  int shuffle; /* 1: candidates in an order drawn by `seed` */
  int power_W, power_q; /* W and q times two to this power */
  uint64_t seed;
  double tol;
} run;

typedef struct outcome {
  dls_status status;
  double residual; /* as the library reports it */
  double error;    /* of r, as the library predicts it; 0: it does not */
  int factorisations;
  double r[M_MAX];       /* in the problem's own order and unit */
  measure is;            /* of r, by measure_answer */
  truth is_true;         /* DLS_OK of a planted problem: of r, by judge_truth */
  int holds;             /* 1: r is a certified answer at the tolerance of the run, with a margin */
  int holds_to_rounding; /* likewise, with floors up to 1e-4 */
  int is_proved;         /* DLS_TO_ROUNDING: dls_contact_prove proves r */
  int lcp_holds;         /* an LCP's own certificate holds */
  int lcp_proof;         /* DLS_NO_SOLUTION of an LCP: 1 exact for the LCP's own numbers, 0 not */
  int proof;             /* DLS_NO_SOLUTION: 1 exact, 0 not */
} outcome;

enum { RUNS_MAX = 40 };

/* Solves p as `how` says; before: the outcome that how->warm = 2 starts from. */
void solve_run(const problem *p, const run *how, const outcome *before, outcome *out);

/* A broken rule, and the runs that show it. */
typedef struct finding {
  rule rule;
  int pair;         /* 1: both runs, else the first alone */
  truth is_true;    /* rule 8 */
  double predicted; /* rule 8: the error that the library predicts */
  run first, second;
} finding;

/* What one problem brought. */
typedef struct verdict {
  int visible;       /* SOLVABLE, and rounding does not hide the planted answer */
  int solved;        /* auto, cold, at the tolerance of the command line */
  int solved_fine;   /* the same at a hundredth */
  dls_status status; /* of the first of these */
  double forces;     /* residual_r of its answer if solved */
  double amplified;  /* largest true error of a solved run, over tol and the condition */
  int unknown;       /* runs solved whose true error is not determined */
  int other;         /* runs solved by another answer than the planted one */
  int both_true;     /* an exact proof beside an answer that holds to rounding */
  int doubtful;      /* "likely" of a problem that is not planted, beside an answer that holds */
  int runs;
  int findings;
  finding finding[RULES];
} verdict;

typedef struct options {
  double tol;
} options;

void check_problem(const problem *p, uint64_t seed, const options *ask, verdict *v);

/* 1 if p breaks the rule of `found` with its runs. */
int finding_stands(const problem *p, const finding *found);

/* p made small: candidates dropped, entries set to 0 and rounded, as long as the finding stands;
 * `seconds` of CPU at most. */
void reduce_problem(problem *p, const finding *found, double seconds);

/* Writes p in the format of data/failures. Returns 0 if the file cannot be written. */
int write_problem(const char *path, const problem *p, const finding *found, const char *title,
                  const char *source);

/* "auto, tol 1e-08, blocks": in words for a report. text: 200. */
void describe_run(const run *how, char *text);

#endif
