/*
 * generate.h: declares what generate.c and extremes.c share.
 */
#ifndef PROPERTIES_GENERATE_H
#define PROPERTIES_GENERATE_H

#include "problem.h"

typedef enum form {
  FACTOR,    /* W = B B' */
  DIAGONAL,  /* W = Q D Q', Q orthogonal */
  CHAIN,     /* W = B B', candidate c in columns c and c + 1 only */
  STRESS,    /* W = B B' with B' r small against |B||r|: reactions that hold themselves */
  SLIGHT,    /* W = B B' and a small part without symmetry */
  SKEW,      /* W = A - A' and a small B B' */
  NO_BLOCKS, /* W = B B' or B C', some W_cc = 0 */
  PRODUCT,   /* W = B C', any eigenvalues */
  ANY_FORM,
  /* extremes.c */
  OPEN,    /* some candidates open, at any distance and stiffness */
  SPRINGS, /* a standing body on soft springs: W is large along its rigid motions */
  ASPECT,  /* W_tt and W_nn apart */
  MASSES,  /* stacks of bodies whose masses are far apart */
  BONDED,  /* any friction, infinite too */
  HEAVY,   /* one reaction far above the others */
  SIZES    /* sizes on both sides of the limits at which the library takes other ways */
} form;

typedef struct recipe {
  const char *name;
  kind kind;
  form form;
  int bits;      /* 0: any doubles; 1: whole numbers; 4: multiples of 1/16 */
  int full;      /* 1: rank m; 0: from 15 to 100 % */
  double mu;     /* greatest friction */
  double ratio;  /* u is 10^(-ratio .. ratio) times the size of W r */
  double scales; /* candidates differ by 10^(-scales .. scales) in W_cc */
  int share;     /* of 1000 problems: even in time, but a few milliseconds or less are cheap */
} recipe;

/* A number of the recipe's kind, of size 1 to 4. */
double draw_number(dice *g, const recipe *of);

/* r and u of candidate c in state 0 free, 1 stick, 2 slip, 3 grazing (u = r = 0), 4 stick on the
 * cone's edge; u times ratio. */
void plant_candidate(dice *g, const recipe *of, problem *p, int c, int state, double ratio);

/* B, C: m x columns */
typedef struct factor {
  int columns;
  double *B, *C;
} factor;

/* W := W + weight B C' in short numbers or to rounding; symmetric to the last bit where C = B. */
void add_product(problem *p, double weight, const factor *f, const double *C);

void draw_factor(dice *g, const recipe *of, const problem *p, double *B, int columns);

/* *p := a problem of one of the forms after ANY_FORM; all but q. */
void draw_extreme(dice *g, const recipe *of, problem *p);

#endif
