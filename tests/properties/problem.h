/*
 * problem.h: a contact problem and the facts that its generator knows, the random numbers, and the
 * judges that use nothing of the library: the residual, the true error, the exact sum, and Farkas'
 * proof.
 */
#ifndef PROPERTIES_PROBLEM_H
#define PROPERTIES_PROBLEM_H

#include <stddef.h>
#include <stdint.h>

enum { NC_MAX = 1001, M_MAX = 3 * NC_MAX };

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
  int symmetric;             /* W is symmetric and positive semidefinite up to rounding */
  double *W;                 /* m x m, column-major, leading dimension m; owned */
  double q[M_MAX];           /* m */
  double mu[NC_MAX];         /* nc; INFINITY: bonded */
  double r[M_MAX], u[M_MAX]; /* SOLVABLE: m */
  double y[NC_MAX];          /* UNSOLVABLE: nc */
} problem;

/* Returns `size` bytes of 0, or ends the program. */
void *problem_alloc(size_t size);

/* Makes p a problem of this size, its W 0; the other fields stay. p->W: NULL or owned. */
void problem_resize(problem *p, int d, int nc);

/* to := from, with a W of its own. */
void problem_copy(problem *to, const problem *from);

/* Returns 1 if some friction is infinite. */
int problem_is_bonded(const problem *p);

/* ---- random numbers: splitmix64 -------------------------------------------------------------- */

typedef struct dice {
  uint64_t state;
} dice;

uint64_t dice_bits(dice *g);
int dice_below(dice *g, int n);                   /* 0 .. n-1 */
int dice_sign(dice *g);                           /* -1 or 1 */
double dice_between(dice *g, double a, double b); /* uniform in [a, b) */
double dice_normal(dice *g);                      /* mean 0, variance about 1 */
double dice_power(dice *g, double a, double b); /* 10 to the power of a uniform number in [a, b) */

/* ---- classes --------------------------------------------------------------------------------- */

enum { CLASSES = 28 };
extern const char *const class_name[CLASSES];

/* The class of a seed: of a thousand seeds each class has its share, the more the cheaper its
 * problems are. */
int class_of_seed(uint64_t seed);

/* Returns 1 if a problem of this class takes about a second. */
int class_is_dear(int class);

/* *p := the problem of this class and seed; the same bits at every call. */
void generate(int class, uint64_t seed, problem *p);

/* SOLVABLE: q := u - W r without rounding, then rounded once; p->exact := 1 if that and the law
 * hold without rounding, else 0. */
void plant_q(problem *p);

/* ---- judges ---------------------------------------------------------------------------------- */

/* Both parts of the certificate as docs/certificate.md defines them, in long double. */
typedef struct measure {
  double u, floor_u;     /* positions, over |q| */
  double r, floor_r;     /* forces, over |r| */
  double seen_u, seen_r; /* the floors where double precision may see another state */
} measure;

/* weights := w_n and w_t of each candidate, 2 nc. */
void measure_weights(const problem *p, long double *weights);

/* Returns the branch of the projection in F of candidate c: 0 free, 1 stick, 2 slip; u: of it, d.
 * F (d), if not NULL: F. */
int measure_branch(const problem *p, int c, const long double *weights, const long double *r,
                   const long double *u, long double *F);

/* e (d) := what rounds in F of candidate c in this branch; u, r of it, a = |W||r| + |q|. */
void measure_rounding(const problem *p, int c, int branch, const long double *weights,
                      const long double *r, const long double *u, const long double *a,
                      long double *e);

void measure_answer(const problem *p, const double *r, measure *out);

/* Returns 1 if both parts (forces = 0: that of positions) are at most slack max(tol, 4 floor) and
 * 4 floor of both, whatever state is seen, at most slack max(tol, most). NaN gives 0. most: 1e-8
 * solved, 1e-4 to rounding. */
int measure_holds(const measure *a, double tol, double slack, double most, int forces);

/* A sum of products of three doubles without rounding: fixed point, 32 bits in each limb. */
enum { EXACT_LIMBS = 208 };
typedef struct exact {
  int64_t limb[EXACT_LIMBS];
} exact;

void exact_clear(exact *sum);
double exact_round(exact *sum); /* the nearest double, or one of its neighbours */
void exact_add(exact *sum, double a, double b, double c); /* sum += a b c */
int exact_sign(exact *sum);                               /* -1, 0, 1 */

/* 1 if y (nc) proves, without rounding, that no r in the cones has (W r + q)_n >= 0: y >= 0,
 * q_n.y < 0 and, with g = W' y (y on the normal rows), g_n + mu |g_t| <= 0 for every candidate. */
int farkas_holds(const problem *p, const double *y);

/* 1 if y or one of its roundings to few digits is such a proof. y: nc, overwritten by the proof. */
int farkas_rounded(const problem *p, double *y);

/* Rule 8. The true answer of the stored numbers is found in long double from the planted one, by
 * Newton's method on its states, and so is the condition of this answer. */
typedef enum truth_verdict {
  TRUTH_HOLDS = 0,
  TRUTH_OTHER,   /* next to another answer, which is true, too */
  TRUTH_UNKNOWN, /* the answer is not determined, not even in long double */
  TRUTH_WRONG_R, /* reactions */
  TRUTH_WRONG_U  /* positions */
} truth_verdict;

typedef struct truth {
  truth_verdict verdict;
  double error;     /* of r, or of u: |r - r_true| / |r_true|, |u - u_true| / (|q| + |u_true|) */
  double largest;   /* of r by entries, over the largest entry of r_true */
  double size;      /* |r| / |r_true| */
  double tol;       /* of the judge */
  double condition; /* of r: relative error per relative residual; 0: not computed */
} truth;

/* Judges r, an answer at this tolerance: wrong if the error is above 1000 tol times the condition
 * or, with capped = 1, above a hundredth. */
void judge_truth(const problem *p, const double *r, double tol, int capped, truth *out);

#endif
