/*
 * delassus/model.h: the host's model: an operator for K or its inverse, and the contact operators.
 *
 *   K x = f + H r,   u = H^T x + g                            [Jean 1988] (3.3)1-3
 *
 * delassus/reduction.h says what x, f, K, H, g are.
 */
#ifndef DELASSUS_MODEL_H
#define DELASSUS_MODEL_H

#include "delassus/matrix.h"

#ifdef __cplusplus
extern "C" {
#endif

typedef enum dls_operator {
  DLS_STIFFNESS_DENSE = 1,  /* K dense; LAPACK */
  DLS_STIFFNESS_SPARSE = 2, /* K sparse. Where no connected part of its graph has more than 250
                               unknowns (mass matrices of rigid bodies; DLS_CHOLESKY and up to four
                               parts: 25) it is factorised part by part as dense matrices, else
                               DLS_CHOLESKY by supernodes and the others by MUMPS. Without MUMPS
                               parts may have 8000 unknowns; more are DLS_E_UNSUPPORTED */
  DLS_FLEXIBILITY = 3,      /* K^-1 given, dense; W is symmetric if K^-1 is */
  DLS_HOST_SOLVER = 4       /* the host solves with its own factorisation */
} dls_operator;

/* The kind of K. If it is symmetric, only the lower triangle is read: give the full matrix or its
 * lower triangle.
 *
 * Joints are multipliers among the unknowns:
 *
 *   K = (A  G; G^T  0),   unknowns (x; l),   loads (f; b):   A x + G l = f + H r,   G^T x = b
 *
 *   G  a column for each joint                                  the unit of its b over that of x
 *   l  forces of the joints on the bodies, with the sign of -G  force (impulse)
 *   b  prescribed value of G^T x                                length (velocity)
 *
 * in any order of the unknowns, by DLS_LDLT or DLS_LU. A multiplier is an unknown that H does not
 * touch, with K_jj = 0 and an entry beside an unknown with K_jj > 0; or with K_jj < 0: a joint that
 * yields. Redundant joints are allowed: of joints that depend on each other to 1e-12 those of the
 * first unknowns carry the forces, and the multipliers of the others are 0. (Any l with G l = 0 may
 * be added without a change of x and r.) The guide, "How to model it", has examples. */
typedef enum dls_factorization {
  DLS_CHOLESKY = 1, /* K symmetric positive definite */
  DLS_LU = 2,       /* K regular, symmetric or not; all its entries */
  DLS_LDLT = 3      /* K symmetric and regular but for redundant joints: multipliers among the
                       unknowns, softening */
} dls_factorization;

/* X (n x nrhs, column-major, leading dimension n): in, right-hand sides; out, K^-1 times them.
 * nrhs is between 1 and 64: at most 64 n doubles at a time while W is formed, 1 afterwards. Return
 * 0, or any other value for failure (DLS_E_CALLBACK, value = what was returned). A result that is
 * not finite is a failure too (index = its unknown). */
typedef int (*dls_solve_fn)(void *user, double *X, int n, int nrhs);

/* A view; everything is borrowed. What is not named by `operator_kind` is ignored, and what comes
 * after P may stay zero. Matrices and arrays are read by dls_reduction_create and
 * dls_reduction_update only; the callback must stay callable. */
typedef struct dls_model {
  int d;     /* 2 or 3 */
  int n;     /* unknowns */
  int nodes; /* contact nodes, >= 0 */
  dls_operator operator_kind;
  dls_factorization factorization; /* of K, dense or sparse */
  dls_dense K;                     /* DLS_STIFFNESS_DENSE; or K^-1 for DLS_FLEXIBILITY */
  dls_sparse Ks;      /* DLS_STIFFNESS_SPARSE; unsorted and repeated entries are fine */
  dls_solve_fn solve; /* DLS_HOST_SOLVER */
  void *user;
  dls_sparse HN; /* n x nodes; any number of entries a column */
  dls_sparse HT; /* n x (d-1) nodes */
  dls_sparse P;  /* nodes x candidates, each column adds up to > 0; P.p = NULL for none. Where an
                    entry is < 0, as on quadratic edges, nodal reactions P r may pull */

  /* Leave out of the contact problem: */
  const int
      *active;      /* candidates: 0 leaves a candidate out of the contact problem; NULL for none */
  const double *mu; /* candidates: where it is 0 the tangents are left out; NULL: all are wanted */

  /* DLS_LU: 1 says that a K without entries above its diagonal is all of K, not half of it. */
  int triangular;
} dls_model;

/* Checks sizes, pointers, indices, finite values, signs; names the field ("K", "Ks", "HN", "P",
 * "active", "mu", ...) and the index: position i + j*ld in a dense matrix, position in x,
 * i or p of a sparse matrix, column for a column of P whose sum is not > 0. Of a K for DLS_CHOLESKY
 * or DLS_LDLT only the lower triangle is read; a sparse one with entries above the diagonal and
 * none below is refused. Of a K for DLS_LU a lower triangle alone is refused unless `triangular`.
 * Callers need not call it: create does. */
DLS_API DLS_MUST_USE dls_status dls_model_check(const dls_model *model, dls_error *error);

#ifdef __cplusplus
}
#endif

#endif
