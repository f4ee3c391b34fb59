/* matrices.h: a contact problem from the matrices of a host code. */
#ifndef MATRICES_H
#define MATRICES_H

#include "arrays.h"
#include "cli.h"

/* The options of `delassus solve` that name matrices; NULL, 0: not given. */
typedef struct matrix_options {
  const char *stiffness, *flexibility, *W;
  const char *H, *HN, *HT, *nodes;
  const char *f, *q, *g, *mu; /* g, mu: a number or a file */
  const char *weights, *modes;
  int dim, stabilize;
  dls_on on; /* with any method but auto: DLS_ON_W */
} matrix_options;

/* Keys of the options, beyond all characters. */
enum {
  KEY_STIFFNESS = 256,
  KEY_FLEXIBILITY,
  KEY_W,
  KEY_H,
  KEY_HN,
  KEY_HT,
  KEY_NODES,
  KEY_F,
  KEY_Q,
  KEY_G,
  KEY_MU,
  KEY_WEIGHTS,
  KEY_MODES,
  KEY_DIM,
  KEY_STABILIZE,
  KEY_ON,
  KEY_STEP,
  KEY_AFTER /* of the other options of a command */
};

#define MATRIX_OPTIONS                                                                             \
  VALUE("stiffness", KEY_STIFFNESS), VALUE("flexibility", KEY_FLEXIBILITY), VALUE("W", KEY_W),     \
      VALUE("H", KEY_H), VALUE("HN", KEY_HN), VALUE("HT", KEY_HT), VALUE("nodes", KEY_NODES),      \
      VALUE("f", KEY_F), VALUE("q", KEY_Q), VALUE("g", KEY_G), VALUE("mu", KEY_MU),                \
      VALUE("weights", KEY_WEIGHTS), VALUE("modes", KEY_MODES), VALUE("dim", KEY_DIM),             \
      FLAG("stabilize", KEY_STABILIZE), VALUE("on", KEY_ON)

/* Takes one of MATRIX_OPTIONS; OPTION_UNKNOWN for another key. */
taken take_matrix_option(int key, const char *text, matrix_options *options);

/* Returns the file that names the problem: K, K^-1 or W; NULL if no matrix is given. */
const char *matrices_name(const matrix_options *options);

/* Returns 1 if any of the options is given. */
int matrices_given(const matrix_options *options);

/* Prints the part of --help. */
void matrices_usage(FILE *out);

/* Reads all files: sets p->model, f, g and mu, or p->contact from --W. Returns 1, or 0 after a
 * complaint; free p in both cases. */
int matrices_load(const matrix_options *options, problem *p);

/* The problem that a command is asked for, beside its name. Start from {0}. */
typedef struct source {
  matrix_options matrices;
  int step;   /* of a scene in steps; 0: the last with the most contacts that touch */
  int solves; /* 1: for solve, which takes a problem on K and rigid bodies as they are */
} source;

#define SOURCE_OPTIONS MATRIX_OPTIONS, VALUE("step", KEY_STEP)
taken take_source_option(int key, const char *text, source *from);

/* Returns the names that a command of contact problems is given, the *count after the options: one
 * of a matrix, or those of files and scenes, without LCPs (leave_lcps). NULL after a complaint. */
char **source_names(int *count, char **argv, const source *from);

void source_usage(FILE *out);

#endif
