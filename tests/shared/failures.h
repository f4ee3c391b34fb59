/*
 * failures.h: reads the catalogue of data/failures (the format: data/failures/README.md).
 */
#ifndef FAILURES_H
#define FAILURES_H

#include <stddef.h>

#include "delassus/contact.h"

enum { FAILURE_N = 20, FAILURE_POINTS = 32 };

/* A solution (continuum = -1), or a point or a direction of continuum 0, 1, ... */
typedef struct failure_point {
  int continuum;
  double x[FAILURE_N];
} failure_point;

/* Methods that dls_solve is asked for: a method by name, nlgs also with "+anderson". */
enum { FAILURE_METHODS = 9 };
extern const char *const failure_methods[FAILURE_METHODS];

typedef struct failure {
  char name[64];                   /* of the file, without .txt */
  int d, nc;                       /* a contact problem; 0: an LCP */
  int n;                           /* d nc, or the size of the LCP */
  double M[FAILURE_N * FAILURE_N]; /* W or M, n x n, column-major */
  double q[FAILURE_N], mu[FAILURE_N];
  int none; /* the file says that there is no solution */
  int points, rays, continua;
  failure_point point[FAILURE_POINTS], ray[FAILURE_POINTS];
  unsigned lemke, nlgs, principal; /* bit s: status s may be the answer; 0: nothing is said */
  unsigned solve[FAILURE_METHODS]; /* the same of failure_methods through dls_solve */
} failure;

/* names := the problems of the directory, sorted; returns how many, -1 if it cannot be read. */
int failures_list(const char *directory, char names[][64], int capacity);

/* "ok", "stalled", ...: the word of the format for a status >= 0. */
const char *failure_word(int status);

/* 1 on success; else why (200) says what is wrong. */
int failure_read(const char *directory, const char *name, failure *f, char *why);

/* Returns 1 if the line solve of f allows that method this status alone. */
int failure_says(const failure *f, const char *method, int status);

/* The contact problem of f; f->d > 0. */
dls_contact failure_contact(const failure *f);

/* All contact problems of the catalogue, in storage that stays; fails the test if one is not
 * read. */
const failure *contact_failures(int *count);

#endif
