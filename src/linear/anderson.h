/* anderson.h: accelerates a fixed-point iteration by Anderson's method. */
#ifndef DLSI_ANDERSON_H
#define DLSI_ANDERSON_H

#include "contact/contact.h"

/* The history of a fixed-point iteration under Anderson acceleration (anderson.c). */
typedef struct dlsi_anderson {
  int window;
  int shortens;            /* 1: gamma that is too large is shortened, (AN4); set by the owner */
  int started;             /* 1: f, g, u are there */
  int columns, newest;     /* columns of DF, DG, DU, in a ring */
  size_t of_u;             /* numbers in u; 0 without */
  double *DF, *DG, *DU;    /* m window, of_u window for DU */
  double *f, *g, *u;       /* of the last step taken: m, of_u for u */
  double *gram, *L;        /* window^2 */
  double *work;            /* 3 window; from 2 window on: DF^T f */
  const dlsi_ranks *ranks; /* that have rows of f; NULL; set by the owner */
} dlsi_anderson;

void dlsi_anderson_carve(dlsi_anderson *a, dlsi_arena *arena, size_t m, int window, size_t of_u);
void dlsi_anderson_clear(dlsi_anderson *a);

/* Takes g = g(x), the weighted residual f = D (g - x) and u = u(g) into the history; g and u become
 * the next x and u(x). Returns 0, g and u untouched, if there is nothing to combine. f, g: m, the
 * same m as since clear; u: of_u, NULL if that is 0. */
int dlsi_anderson_step(dlsi_anderson *a, int m, const double *f, double *g, double *u);

#endif
