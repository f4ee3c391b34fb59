/*
 * solvers_report.h: output of bench/solvers: a row for each scene, solver and target, the page of
 * results, the data of the pictures.
 */
#ifndef SOLVERS_REPORT_H
#define SOLVERS_REPORT_H

#include "solvers.h"

enum { TARGETS = 3 };

typedef enum verdict {
  NOT_RUN = 0,
  SOLVED = 1,     /* the certificate holds */
  UNSOLVED = 2,   /* ended, and says that it has not solved it */
  WRONG = 3,      /* says that it has, with a tolerance of its own not above the target */
  OVER_LIMIT = 4, /* of CPU */
  CRASHED = 5,
  REFUSED_IT = 6
} verdict;

typedef struct record {
  const char *method, *setting, *storage;
  int peer;
  double target, own_tol; /* the tolerance that the solver was given */
  verdict status;
  double residual, cpu, setup;
  int iterations;
  solve_fn solve; /* and what it takes, to run it again */
  const void *how;
} record;

typedef struct report report;

/* Opens DIRECTORY/solvers.csv and solvers.md; argv: of the program, for the head of the page. NULL
 * after a message. */
report *report_open(const char *directory, int argc, char *const *argv);

void report_scene(report *p, const scene *s); /* the next records are of s; its name is copied */
void report_add(report *p, const record *a);
void report_progress(const report *p); /* a line on stdout about the last scene */

/* Writes the summary on the page and on stdout, and the data of the pictures; releases p. Returns
 * 0, or -1 if there was no scene or something could not be written. */
int report_close(report *p);

#endif
