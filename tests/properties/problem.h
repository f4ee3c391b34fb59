/*
 * problem.h: a contact problem with what its generator knows of it, the random numbers, and the
 * three judges that use nothing of the library: the residual, the exact sum, and Farkas' proof.
 */
#ifndef PROPERTIES_PROBLEM_H
#define PROPERTIES_PROBLEM_H

#include <stdint.h>

enum { NC_MAX = 60, M_MAX = 3 * NC_MAX };

typedef enum kind {
  SOLVABLE,   /* r, u is an answer: planted */
  BORDERLINE, /* nothing is known */
  SURE,       /* W is positive definite without rounding: there is an answer, however far */
  UNSOLVABLE  /* y proves it, to rounding at least */
} kind;

typedef struct problem {
  int d, nc, m; /* m = d nc */
  kind kind;
  int exact;                 /* SOLVABLE: q = u - W r and the law hold without rounding */
  int symmetric;             /* W is symmetric and positive semidefinite but for rounding */
  double W[M_MAX * M_MAX];   /* m x m, column-major, leading dimension m */
  double q[M_MAX];           /* m */
  double mu[NC_MAX];         /* nc */
  double r[M_MAX], u[M_MAX]; /* SOLVABLE: m */
  double y[NC_MAX];          /* UNSOLVABLE: nc */
} problem;

/* ---- random numbers: splitmix64 -------------------------------------------------------------- */

typedef struct dice {
  uint64_t state;
} dice;

uint64_t dice_bits(dice *g);
int dice_below(dice *g, int n);                   /* 0 .. n-1 */
double dice_between(dice *g, double a, double b); /* uniform in [a, b) */
double dice_normal(dice *g);                      /* mean 0, variance about 1 */
double dice_power(dice *g, double a, double b); /* 10 to the power of a uniform number in [a, b) */

/* ---- classes --------------------------------------------------------------------------------- */

enum { CLASSES = 21 };
extern const char *const class_name[CLASSES];

/* The class of a seed: of a thousand seeds each class has its share, the more the cheaper its
 * problems are. */
int class_of_seed(uint64_t seed);

/* *p := the problem of this class and seed; the same bits at every call. */
void generate(int class, uint64_t seed, problem *p);

/* SOLVABLE: q := u - W r in long double, rounded once; p->exact := 1 if that and the law hold
 * without rounding, else 0. */
void plant_q(problem *p);

/* ---- judges ---------------------------------------------------------------------------------- */

/* Both parts of the certificate as DESIGN.md defines them, in long double. */
typedef struct measure {
  double u, floor_u; /* positions, over |q| */
  double r, floor_r; /* forces, over |r| */
} measure;

void measure_answer(const problem *p, const double *r, measure *out);

/* 1 if the part of positions (and, with forces = 1, the part of forces) is at most
 * slack max(tol, 4 floor) and 4 floor_u at most slack max(tol, 1e-8). NaN gives 0. */
int measure_holds(const measure *a, double tol, double slack, int forces);

/* A sum of products of three doubles without rounding: fixed point, 32 bits in each limb. */
enum { EXACT_LIMBS = 208 };
typedef struct exact {
  int64_t limb[EXACT_LIMBS];
} exact;

void exact_clear(exact *sum);
void exact_add(exact *sum, double a, double b, double c); /* sum += a b c */
int exact_sign(exact *sum);                               /* -1, 0, 1 */

/* 1 if y (nc) proves, without rounding, that no r in the cones has (W r + q)_n >= 0: y >= 0,
 * q_n.y < 0 and, with g = W' y (y on the normal rows), g_n + mu |g_t| <= 0 for every candidate. */
int farkas_holds(const problem *p, const double *y);

/* 1 if y or one of its roundings to few digits is such a proof. y: nc, overwritten by the proof. */
int farkas_rounded(const problem *p, double *y);

#endif
