/*
 * bodies.h: stacks of blocks that only contact holds, K x = f + H r, u = H' x, d = 2, and their
 * statics, in short dyadic numbers: every resultant below is exact.
 *
 * Block b is a lattice of braced unit squares on plane b: the ground for b = 0, else the top of
 * block b - 1. K is singular: three rigid motions a block. The resultant of plane b follows from
 * the loads of the blocks b and above:
 *
 *   N = - sum f_y,  T = - sum f_x,  M = sum x_c r_n = - sum (x f_y - y f_x) + height T
 *
 * Equilibrium exists if and only if every plane can carry it: N >= 0, |T| <= mu N and M / N between
 * the outermost contacts of the plane.
 */
#ifndef PROPERTIES_BODIES_H
#define PROPERTIES_BODIES_H

#include "delassus/matrix.h"
#include "delassus/status.h"
#include "problem.h"

enum { BLOCKS_MAX = 40 };

typedef enum stack_kind { STANDS, SLIDES, TIPS, LIFTED, ON_EDGE } stack_kind;

typedef struct plane {
  double N, T, M;      /* of its reactions on the block above: force, force, force x length */
  double height;       /* y of the plane */
  int first, contacts; /* of the candidates first .. first + contacts - 1, x increasing */
} plane;

typedef struct stack {
  int n, nodes, nc, blocks; /* n = 2 nodes; node i has the unknowns 2 i (x) and 2 i + 1 (y) */
  dls_sparse K, HN, HT;     /* n x n, all entries; n x nc; views of the arrays below */
  double *f, *mu;           /* n; nc */
  int *block;               /* nodes: the block of a node */
  double *place;            /* 2 nodes: x and y */
  plane planes[BLOCKS_MAX]; /* blocks */
  stack_kind kind; /* ON_EDGE: a plane is within a sixteenth of its limits; STANDS: all are inside
                      them by more; else: a plane is beyond by more */
  int *index;      /* owned memory of the views */
  double *numbers;
} stack;

/* s := the stack of this seed, the same bits at every call. s: 0, or a stack to be replaced. */
void stack_generate(uint64_t seed, stack *s);
void stack_free(stack *s);

/* A door of the library: x (n), r (2 nc, (n, t) of each candidate). */
typedef dls_status (*stack_solver)(void *user, const stack *s, double tol, double *x, double *r);

typedef enum stack_verdict {
  STACK_GOOD = 0,
  STACK_CLAIMED, /* DLS_OK, and there is no equilibrium */
  STACK_DENIED,  /* it stands, and the status is neither DLS_OK nor DLS_TO_ROUNDING */
  STACK_BLOCK,   /* forces or moments of a block do not balance */
  STACK_PLANE,   /* the resultant of a plane is not that of statics */
  STACK_CONE,    /* a reaction pulls, or leaves its cone */
  STACK_NODES,   /* K x = f + H r does not hold */
  STACK_LAW,     /* H' x and r do not meet the laws of contact and friction */
  STACK_VERDICTS
} stack_verdict;

extern const char *const stack_text[STACK_VERDICTS];

/* Judges an answer at this tolerance, in long double. Balances are over |f| + |H r| of the block,
 * positions over the largest |x|. */
stack_verdict stack_judge(const stack *s, dls_status status, const double *x, const double *r,
                          double tol);

/* Solves `count` stacks, of the seeds seed + i step, and prints the verdicts by kind. Returns 1 if
 * all are good. */
int stack_run(uint64_t seed, uint64_t step, long count, double tol, stack_solver solve, void *user);

/* dls_global_solve; user: NULL. */
dls_status stack_solve_global(void *user, const stack *s, double tol, double *x, double *r);

#endif
