/*
 * delassus/reduction.h: from the host's model to the contact problem, and back.
 *
 *   K x = f + H r,   u = H^T x + g
 *   W = H^T K^-1 H,  q = H^T K^-1 f + g,   u = W r + q        [Jean 1988] (3.3)1-6
 *
 *   x  unknowns of the host (displacements or velocities), n    length (velocity)
 *   f  loads on them, n                                         force (impulse)
 *   K  stiffness (mass, or tangent), n x n, regular             force / length
 *   H  = (H_N, H_T): column c of H_N, and columns (d-1) c .. of H_T, give the normal and the
 *      tangents of contact node c
 *   g  initial gap, or the motion of the obstacle with the sign of a gap, d per contact node in
 *      local order ([J] Y_0; gap / h + velocity in dynamics)    length (velocity)
 *
 * Weighted reactions, [J] 4.4: H = L P with L the nodal operator (L_N, L_T) that the host gives and
 * P (contact nodes x candidates) the weighting; without P, candidates are the contact nodes.
 * Unknowns are then the weighted reactions of dimension force (the paper's M r); P r are the
 * equivalent nodal reactions, and u = P^T (L^T x + g).
 */
#ifndef DELASSUS_REDUCTION_H
#define DELASSUS_REDUCTION_H

#include "delassus/contact.h"

#ifdef __cplusplus
extern "C" {
#endif

typedef enum dls_operator {
  DLS_STIFFNESS_DENSE = 1,  /* K dense; Cholesky or LU (LAPACK) */
  DLS_STIFFNESS_SPARSE = 2, /* K sparse, full pattern; each connected part of its graph is factored
                               as a dense matrix (mass matrices of rigid bodies, small models);
                               a part of more than 8000 unknowns is DLS_E_UNSUPPORTED */
  DLS_FLEXIBILITY = 3,      /* K^-1 given, dense; W is as symmetric as it is */
  DLS_HOST_SOLVER = 4       /* the host solves with its own factorisation */
} dls_operator;

typedef enum dls_factorization {
  DLS_CHOLESKY = 1, /* K symmetric positive definite; only its lower triangle is read */
  DLS_LU = 2        /* K regular, symmetric or not */
} dls_factorization;

/* X (n x nrhs, column-major, leading dimension n): in, right-hand sides; out, K^-1 times them.
 * nrhs is between 1 and 64: at most 64 n doubles at a time while W is formed, 1 afterwards. Return
 * 0, or any other value for failure (DLS_E_CALLBACK, value = what was returned). A result that is
 * not finite is a failure too (index = its unknown). */
typedef int (*dls_solve_fn)(void *user, double *X, int n, int nrhs);

/* A view; everything is borrowed. What is not named by `operator_kind` is ignored. K, the operators
 * and P are read by dls_reduction_create only; the callback must stay callable. */
typedef struct dls_model {
  int d;     /* 2 or 3 */
  int n;     /* unknowns */
  int nodes; /* contact nodes */
  dls_operator operator_kind;
  dls_factorization factorization; /* of K, dense or sparse */
  dls_dense K;                     /* DLS_STIFFNESS_DENSE; or K^-1 for DLS_FLEXIBILITY */
  dls_sparse Ks;                   /* DLS_STIFFNESS_SPARSE */
  dls_solve_fn solve;              /* DLS_HOST_SOLVER */
  void *user;
  dls_sparse HN; /* n x nodes */
  dls_sparse HT; /* n x (d-1) nodes */
  dls_sparse P;  /* nodes x candidates, every entry >= 0, no empty column; P.p = NULL for none */
} dls_model;

/* Sizes, pointers, indices, finite values, signs; names the field ("K", "Ks", "HN", "P", ...) and
 * the index: position i + j*ld in K, position in x, i or p of a sparse matrix, column for an empty
 * column of P. Of a dense K for DLS_CHOLESKY only the lower triangle is read. Callers need not
 * call it: create does. */
DLS_API DLS_MUST_USE dls_status dls_model_check(const dls_model *model, dls_error *error);

typedef struct dls_reduction dls_reduction;

/* Factors K, forms W; *out = NULL on error. With m = d * candidates it holds m^2 doubles for W, H,
 * a few vectors, and the factor or K^-1 (n^2; the sum of the squares of the parts for a sparse K);
 * at most 128 n doubles more while it forms W. W is exactly symmetric with DLS_CHOLESKY.
 *
 * DLS_E_NOT_POSITIVE_DEFINITE and DLS_E_SINGULAR (condition above 4e14 after scaling rows and
 * columns, so whatever the units of forces, moments, displacements and rotations) name K or Ks,
 * the unknown (index) where a pivot vanished, and the pivot of the scaled matrix (value; entries
 * near 1). DLS_E_NOT_FINITE naming "W", or entries of Ks that add up to Inf: an overflow.
 * DLS_E_UNSUPPORTED, DLS_E_CALLBACK, DLS_E_SIZE, DLS_E_MEMORY, and the errors of
 * dls_model_check. */
DLS_API DLS_MUST_USE dls_status dls_reduction_create(dls_reduction **out, const dls_model *model,
                                                     dls_error *error);

/* New loads and gaps on the same factor: q := H^T K^-1 f + P^T g. f (n) or NULL for 0; g (d *
 * nodes) or NULL for 0. Before the first call f and q are 0; an error leaves both as they were.
 * One solve. Allocates nothing. */
DLS_API DLS_MUST_USE dls_status dls_reduction_load(dls_reduction *reduction, const double *f,
                                                   const double *g, dls_error *error);

/* *problem := the contact problem with the friction coefficients mu (candidates; borrowed). W and
 * q belong to the reduction and live as long as it does; q changes with dls_reduction_load. */
DLS_API DLS_MUST_USE dls_status dls_reduction_contact(const dls_reduction *reduction,
                                                      const double *mu, dls_contact *problem,
                                                      dls_error *error);

/* x (n) := K^-1 (f + H r), f as last given to dls_reduction_load (copied there). r (m). One solve.
 * Allocates nothing. */
DLS_API DLS_MUST_USE dls_status dls_reduction_recover(dls_reduction *reduction, const double *r,
                                                      double *x, dls_error *error);

/* R (d * nodes) := P r in local order, the nodal reactions that r (m) stands for; R = r without P.
 * R and r must not overlap. */
DLS_API DLS_MUST_USE dls_status dls_reduction_nodal(const dls_reduction *reduction, const double *r,
                                                    double *R, dls_error *error);

/* NULL is fine. */
DLS_API void dls_reduction_destroy(dls_reduction *reduction);

/* The weighting of a contact line, [J] 4.4 example 2: column j spreads the reaction of candidate j,
 * constant on its dual cell (half way to its neighbours), by the integrals of the nodes' hat
 * functions over that cell divided by its length.
 *
 *   nodes      number of nodes of the line, in order, >= 2
 *   s          their abscissae along the line, strictly increasing, nodes      length
 *   candidate  candidate[i] != 0: node i is a candidate; 0: it is not (fixed, say), nodes. NULL:
 *              all. A surface ends at the first and last node, candidates or not.
 *   p, i, x    the columns of P (nodes x candidates), compressed; room for
 *              nodes + 1, 3 nodes, 3 nodes
 *   length     measure of each dual cell (the paper's M), candidates; or NULL   length
 *   columns    receives the number of candidates
 *
 * Columns add up to 1: the resultant is kept. Inside, (1/4) a/(a+b), 3/4, (1/4) b/(a+b) for the
 * segments a, b beside the node ((1/8, 3/4, 1/8) if equal); at an end (3/4, 1/4). Rows ascend in
 * each column. A neighbour that is no candidate keeps its row of P: its node takes part in the
 * reduction. DLS_E_ARGUMENT (no candidate at all, s not increasing: index), DLS_E_SIZE,
 * DLS_E_NOT_FINITE. */
DLS_API DLS_MUST_USE dls_status dls_weighting_line(int nodes, const double *s, const int *candidate,
                                                   int *p, int *i, double *x, double *length,
                                                   int *columns, dls_error *error);

#ifdef __cplusplus
}
#endif

#endif
