/*
 * cases.h: small contact problems that the tests of the solvers share, and the checks that every
 * solver must pass on them.
 */
#ifndef CASES_H
#define CASES_H

#include <stddef.h>
#include <stdint.h>

#include "delassus/info.h"

enum { most = 60 }; /* unknowns of the largest problem here */

void set_seed(uint64_t seed);
double uniform(void); /* in (-1, 1) */
double norm_of(const double *x, int n);

/* ---- problems -------------------------------------------------------------------------------- */

/* a problem with its own storage; W dense, column-major */
typedef struct model {
  double W[most * most], q[most], mu[most / 2];
  dls_contact p;
} model;

void set_model(model *a, int d, int nc); /* all zero */
void copy_model(model *a, const model *b);

/* W := A A^T / m + shift I, symmetric positive definite; all m x m, column-major */
void gram(int m, const double *A, double shift, double *W);
/* W := A A^T / m + shift I + skew (an antisymmetric matrix), then q; A, that matrix and q are of
 * draw(), which is in (-1, 1) */
void gram_and_skew(int m, double (*draw)(void), double shift, double skew, double *W, double *q);
/* W = A A^T / m + I / 10; q_n mostly < 0 */
void random_model(model *a, int d, int nc, double mu);
/* the i-th of them: 2D and 3D, up to 20 candidates, mu = 0 .. 0.6; from `normal_models` on d = 1;
 * starts the random numbers again */
enum { normal_models = 1000 };
void numbered_model(model *a, int i);
/* W = B B^T of half rank, with a solution of free, slipping and sticking candidates; mu = 0.3 */
void deficient_model(model *a, int i);
/* W = A A^T / m + I / 1000, pressed all over: many sweeps */
void slow_model(model *a, int i);

/* q -> length q, W -> length / force W: then r -> force r, u -> length u */
void scale_model(model *a, const model *b, double length, double force);
/* candidates in reverse order; k of b is reversed(b, k) of a */
void reverse_model(model *a, const model *b);
int reversed(const model *a, int k);
/* 3D: the tangents of candidate c turned by angle[c]; and a vector with them */
void turn_model(model *a, const model *b, const double *angle);
void turn_vector(const model *a, const double *angle, double *v);

/* W by blocks, in storage of its own */
typedef struct block_storage {
  int p[most + 1], i[most * most / 4];
  double x[most * most];
} block_storage;
dls_contact by_blocks(const model *a, block_storage *B);

/* W = H^T H of random bodies, some candidates on a fixed one: *factored, in storage of its own; a:
 * the same with W dense. The i-th of them: d = 1 + i % 3, up to 10 candidates, W positive
 * definite. */
typedef struct bodies_storage {
  int body[2 * most];
  double H[12 * most];
} bodies_storage;
void bodies_model(model *a, bodies_storage *B, dls_contact *factored, int i);

/* A row of row_nc 2D candidates, each coupled to its neighbours, in both storages, which the next
 * call overwrites: sticking, with mu large; or W singular, by pairs. */
enum { row_nc = 150, row_m = 2 * row_nc };
void row_problem(int singular, dls_contact *dense, dls_contact *blocks);

/* by hand, or from the catalogue of data/failures (C1, ...) */
typedef struct hand_case {
  const char *name;
  int d, nc;
  double W[16]; /* by rows */
  double q[4], mu;
  double r[4]; /* the only solution (C16: one of three); jammed: along which reactions run away */
} hand_case;

extern const hand_case hand[], jammed[]; /* with a solution, without */
enum { hand_count = 25, jammed_count = 5 };

/* C1: free, stick and slip are solutions; C5: two contacts that share everything */
extern const hand_case ambiguous_case, hyperstatic_case;

const hand_case *hand_named(const char *name);
void set_hand(model *a, const hand_case *k);

/* ---- solvers --------------------------------------------------------------------------------- */

/* A solver as its users see it: a method's own functions, or dls_solver with that method. */
typedef struct tested_solver tested_solver;
struct tested_solver {
  const char *name;      /* of its functions: "dls_nlgs" */
  const char *workspace; /* how its errors call the workspace */
  dls_method method;
  int restarts; /* 1: from the answer it does its work again, to the same answer up to rounding */
  double tol;   /* the smallest it reaches: 0, but 1e-4 of the penalty method */
  size_t settings_size;
  void (*init)(const tested_solver *self, void *settings, double tol, int warm_start);
  dls_limits *(*limits)(void *settings);
  dls_status (*create)(void **work, int d, int nc, const void *settings, dls_error *error);
  dls_status (*solve)(void *work, const dls_contact *p, double *r, double *u, dls_info *info,
                      dls_error *error);
  void (*destroy)(void *work);
};

/* Solves once in a workspace, or in one of its own, with the settings of create. Asserts that the
 * solver says of r what the public certificate says, and that DLS_OK means that it holds. */
dls_status run_in(const tested_solver *s, void *work, const dls_contact *p, double tol, double *r,
                  double *u, dls_info *info);
dls_status run_with(const tested_solver *s, const dls_contact *p, const void *settings, double tol,
                    double *r, double *u, dls_info *info);

/* Of numbered_model i, |r - r'| of answers with residuals of 1e-12 */
double close_of(const model *a);

/* ---- what every solver owes (tests/contract) ------------------------------------------------- */

/* Below, settings are as from s->init(s, .., tol, 0). */

/* Solves numbered_model i: again, warm, by blocks, reversed; and to the answer of `other`. */
void expect_solved(const tested_solver *s, int i);
void expect_answer_of(const tested_solver *s, int i, dls_method other);
/* and to the answer of other settings, tol = 1e-12 too */
void expect_same_answer(const tested_solver *s, int i, const void *settings);
/* two: units of powers of two, odd and even, which scale without rounding, to the same bits; else
 * powers of ten */
void expect_any_units(const tested_solver *s, const model *a, const void *settings, double tol,
                      int two);
void expect_any_tangents(const tested_solver *s, int i);
void expect_floor(const tested_solver *s, int i); /* tol = 0 */
/* b fits into the workspace of a, too; nothing is allocated, and nothing is left of a */
void expect_reuse(const tested_solver *s, const model *a, const model *b);
/* create takes from `bytes` to `bytes` + slack bytes, every malloc of it may fail */
void expect_memory(const tested_solver *s, int d, int nc, const void *settings, double bytes,
                   double slack);

/* solve of a problem that create was not told of: each malloc may fail, r and the workspace stay as
 * good as they were */
void expect_solve_unwinds(const tested_solver *s, void *work, const dls_contact *p, double *r);
/* row_problem, dense and then twice by blocks: the same bits again, and the dense answer to tol
 * unless it is singular, which leaves several.
 * r: out, the dense answer, row_m; info: out, of both storages */
void expect_sparse_is_dense(const tested_solver *s, void *work, int singular, double tol, double *r,
                            dls_info info[2]);
/* solve of a problem that create was told of, or that was solved before: allocates nothing */
void expect_no_allocation(const tested_solver *s, void *work, const dls_contact *p, double *r);
/* no solution: honest, and not worse than r = 0, whose residual is 1 */
void expect_no_answer(const tested_solver *s, const dls_contact *p, const void *settings);

/* A refused create leaves NULL; what all settings hold; and a refused solve leaves its outputs. */
void refuses_to_create(const tested_solver *s, dls_status status, const char *argument,
                       long long index, int d, int nc, const void *settings);
void expect_bad_create(const tested_solver *s);
void expect_bad_solve(const tested_solver *s);

/* progress_data of look, which checks the calls and cancels at one of them; 0: never */
typedef struct watch {
  const char *method; /* NULL: of any stage, whose iterations count from 1 */
  int max_iterations;
  double least; /* residual so far */
  int calls, cancel_at;
} watch;
int look(void *data, const dls_progress *progress);

#endif
