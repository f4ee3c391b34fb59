/*
 * reduction_internal.h: what the files of reduction/ share; the contract of the back-ends.
 *
 * A back-end presents K as a direct sum: after a renumbering of the unknowns K is block diagonal,
 * with `parts` blocks that nothing couples. Dense matrices, the host's solver, and a sparse K that goes
 * to MUMPS have one part.
 */
#ifndef DLSI_REDUCTION_H
#define DLSI_REDUCTION_H

#include "base/base.h"
#include "delassus/reduction.h"
#include "linear/schur.h"

enum {
  dlsi_batch = 64,         /* most right-hand sides in one solve; more are not faster */
  dlsi_small_part = 250,   /* unknowns of a sparse K for which a dense factor is faster */
  dlsi_largest_part = 8000 /* the same in a build without MUMPS, at most: 0.5 GB */
};

typedef struct dlsi_factor {
  int n, parts;
  int largest;    /* unknowns of the largest part */
  int *first;     /* parts + 1: part k owns the positions first[k] .. first[k+1]-1, */
  int *unknown;   /* n: where unknown[position] stands; ascending within a part */
  int *place;     /* n: its inverse */
  int symmetric;  /* K^-1 is symmetric whatever the rounding of a solve */
  size_t scratch; /* doubles of `work` for a solve, per unknown and right-hand side: 0 or 1 */

  dls_operator kind;
  dls_factorization factorization;
  double rcond;      /* of K scaled, the least of its parts */
  dlsi_schur *schur; /* NULL: the parts are dense, or the host's */
  int kept;          /* unknowns of its Schur complement */
  size_t entries;    /* of A */
  double *A;         /* the parts' matrices or factors, one after the other, ... */
  size_t *start;     /* parts: ... beginning here */
  double *row, *col; /* n: powers of two; what is factored is diag(row) K diag(col) */
  int *pivot;        /* n: row exchanges of LU */
  dls_solve_fn solve;
  void *user;
  void *memory; /* of all arrays but A */
} dlsi_factor;

/* *out = the operator of a model that has passed dlsi_check_model, laid out and analysed; NULL on
 * error. keep (count): unknowns of the Schur complement where there is one, ascending. DLS_E_SINGULAR
 * (structurally), DLS_E_UNSUPPORTED (a part too large), DLS_E_SIZE, DLS_E_MEMORY. */
dls_status dlsi_factor_create(dlsi_factor **out, const dls_model *model, int count, const int *keep,
                              dls_error *error);

/* What was laid out: bytes of the factor, in use while factoring, operations. */
void dlsi_factor_estimate(const dlsi_factor *factor, double *factor_bytes, double *bytes,
                          double *flops);

/* DLS_E_ARGUMENT naming Ks if a sparse K of the same size has another pattern. */
dls_status dlsi_factor_same(const dlsi_factor *factor, const dls_model *model, dls_error *error);

/* Factors the values of a model of the same pattern. DLS_E_NOT_POSITIVE_DEFINITE, DLS_E_SINGULAR,
 * DLS_E_NOT_FINITE (entries that add up to Inf), DLS_E_MEMORY; index: the unknown of the whole K. */
dls_status dlsi_factor_numeric(dlsi_factor *factor, const dls_model *model, dls_error *error);

/* X (size of the part x nrhs, column-major without gaps) := K_part^-1 X, nrhs <= dlsi_batch. work:
 * scratch * size * nrhs doubles. Allocates nothing but what schur.h does. DLS_E_CALLBACK,
 * DLS_E_MEMORY, X then being undefined. */
dls_status dlsi_factor_solve(const dlsi_factor *factor, int part, double *X, int nrhs, double *work,
                             dls_error *error);

/* NULL is fine. */
void dlsi_factor_destroy(dlsi_factor *factor);

/* Rigid-body modes: basis (n x count, column-major), 1 in unknown[k] where the other columns are 0. */
typedef struct dlsi_modes {
  int count;
  double *basis;
  int *unknown;
} dlsi_modes;

/* The null space of a checked stiffness, dense or sparse; count 0 if there is none. Owned by the
 * caller, to be freed by dlsi_modes_free also after an error. */
dls_status dlsi_modes_find(const dls_model *model, dlsi_modes *modes, dls_error *error);

/* The same from model->modes, which must be null vectors of K. DLS_E_ARGUMENT naming the column. */
dls_status dlsi_modes_given(const dls_model *model, dlsi_modes *modes, dls_error *error);
void dlsi_modes_free(dlsi_modes *modes);

/* model with its K replaced by K + spring_j e_j e_j^T for j = unknown[k] of the modes, spring_j = 1e-4 K_jj
 * (of the largest entry of column j where that is not positive). */
typedef struct dlsi_stable {
  dls_model model;
  int *p, *i; /* what model points to instead of K */
  double *x;
} dlsi_stable;

/* spring (modes->count): receives the stiffnesses. To be freed by dlsi_stable_free also after an
 * error. DLS_E_MEMORY. */
dls_status dlsi_stable_create(dlsi_stable *stable, const dls_model *model, const dlsi_modes *modes,
                              double *spring, dls_error *error);
void dlsi_stable_free(dlsi_stable *stable);

/* H by rows: entry e, p[k] <= e < p[k+1], of the unknown at position k stands in column j[e]. */
typedef struct dlsi_rows {
  size_t n, m;
  size_t *p; /* n + 2, the last one unused */
  int *j;
  double *h;
} dlsi_rows;

/* y (m) += H^T x over the s positions from `first` on; x begins with the first of these */
void dlsi_rows_add(const dlsi_rows *H, size_t first, size_t s, const double *x, double *y);

/* W (m x m) := H^T K^-1 H. keep (factor->kept): the unknowns of the Schur complement. DLS_E_NOT_FINITE
 * naming W, DLS_E_MEMORY, and the errors of the solves. */
dls_status dlsi_influence(const dlsi_factor *factor, const dlsi_rows *H, const int *keep, double *W,
                          dls_error *error);

#endif
