/* matrices.h: a contact problem from the matrices of a host code. */
#ifndef MATRICES_H
#define MATRICES_H

#include "arrays.h"
#include "problem.h"

/* The options of `delassus solve` that name matrices; NULL, 0: not given. */
typedef struct matrix_options {
  const char *stiffness, *flexibility, *W;
  const char *H, *HN, *HT, *nodes;
  const char *f, *q, *g, *mu; /* g, mu: a number or a file */
  const char *weights;
  int dim, triplets;
  const char *where; /* --on */
  dls_on on;         /* with any method but auto: DLS_ON_W */
} matrix_options;

/* Returns the file that names the problem: K, K^-1 or W; NULL if no matrix is given. */
const char *matrices_name(const matrix_options *options);

/* Returns 1 if any of the options is given. */
int matrices_given(const matrix_options *options);

/* Reads all files: sets p->model, f, g and mu, or p->contact from --W. Returns 1, or 0 after a
 * complaint; free p in both cases. */
int matrices_load(const matrix_options *options, problem *p);

/* Reads mu anew, and with loads = 1 f and g, or q. */
int matrices_load_data(const matrix_options *options, int loads, problem *p);

/* Returns loads (n) as --f gives them, to be freed; NULL after a complaint. */
double *matrices_read_loads(const char *path, const matrix_options *options, const problem *p);

/* Reads --mu, if it is given, in place of the friction of a file or a scene. */
int friction_load(const matrix_options *options, problem *p);

/* The problem that a command is asked for, beside its name. Start from {0}. */
typedef struct source {
  matrix_options matrices;
  int step;             /* of a scene in steps; 0: the last with the most contacts that touch */
  int solves;           /* 1: for solve, which takes a problem on K */
  const engine *engine; /* that may solve it, or NULL */
} source;

/* The rows of the options; member: the source in the data of a command. */
#define SOURCE_OPTIONS(type, member)                                                               \
  ROW(A_TEXT, "stiffness", 0, type, member.matrices.stiffness),                                    \
      ROW(A_TEXT, "flexibility", 0, type, member.matrices.flexibility),                            \
      ROW(A_TEXT, "W", 0, type, member.matrices.W), ROW(A_TEXT, "H", 0, type, member.matrices.H),  \
      ROW(A_TEXT, "HN", 0, type, member.matrices.HN),                                              \
      ROW(A_TEXT, "HT", 0, type, member.matrices.HT),                                              \
      ROW(A_TEXT, "nodes", 0, type, member.matrices.nodes),                                        \
      ROW(A_TEXT, "f", 0, type, member.matrices.f), ROW(A_TEXT, "q", 0, type, member.matrices.q),  \
      ROW(A_TEXT, "g", 0, type, member.matrices.g),                                                \
      ROW(A_TEXT, "mu", 0, type, member.matrices.mu),                                              \
      ROW(A_TEXT, "weights", 0, type, member.matrices.weights),                                    \
      ROW(A_COUNT, "dim", 0, type, member.matrices.dim),                                           \
      ROW(A_FLAG, "triplets", 0, type, member.matrices.triplets),                                  \
      ROW(A_TEXT, "on", 0, type, member.matrices.where),                                           \
      ROW(A_COUNT, "step", 0, type, member.step)

/* problem.c: returns the names that a command of contact problems is given, the *count after the
 * options: one of a matrix, or those of files and scenes; it leaves LCPs out, which methods for
 * contact do not take, with a line on stderr for each. NULL after a complaint. */
char **source_names(int *count, char **argv, const source *from);

/* Prints the part of --help. */
void source_usage(FILE *out);

#endif
