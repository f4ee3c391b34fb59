/*
 * active.h: the linear equations of chosen states, and Newton's method on them, in long double.
 *
 * For chosen states of the contacts the laws are linear, except for the direction of slip in 3D
 * (e = r_t / |r_t|, e' normal to it). Unknowns z and equations of
 *
 *   stick  r (d)                                       u = 0
 *   slip   r_n, with r_t = mu r_n e                    u_n = 0
 *          3D: force along e', which turns r_t         u_t.e' = 0, turned: + |u_t| / (mu r_n)
 *
 * dr = G dz, A dz = - H' u, A = H' W G + the turns: G the columns, H the rows.
 */
#ifndef PROPERTIES_ACTIVE_H
#define PROPERTIES_ACTIVE_H

#include "problem.h"

typedef long double real;

typedef struct unknown {
  int c, tangent;  /* candidate; 1: its scale is that of w_t */
  real g[3], h[3]; /* column of G and of H, d entries */
  real turn;
} unknown;

typedef struct active {
  const problem *p;
  int n;
  real *w, *r, *u, *a; /* weights 2 nc; m each; a = |W||r| + |q| */
  int *branch, *pivot; /* nc; n */
  int singular;        /* after (T4) */
  unknown *z;          /* m */
  real *A;             /* n x n: its LU */
  real *x, *y, *b;     /* scratch: m, m, n */
} active;

active *active_create(const problem *p);
void active_destroy(active *s);

/* Lists the unknowns of the states in s->branch; r and u: on them. */
void active_list(active *s);

/* A := its factor. Returns 0 where a pivot is rounding. */
int active_factor(active *s);

/* b (n) := A^-1 b, or A^-T b. */
void active_solve(active *s, int transposed, real *b);

/* Newton's method from s->r, overwritten; the states are those of measure.c at every step. Returns
 * 1: s->r is an answer to long double precision, A its factor; 0: none found; -1: A is singular. */
int active_find(active *s);

/* |x|_2, n entries */
real active_length(const real *x, int n);

#endif
