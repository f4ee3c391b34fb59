/*
 * reduction_internal.h: what the files of reduction/ share; the contract of the back-ends.
 *
 * A back-end presents K as a direct sum: after a renumbering of the unknowns K is block diagonal,
 * with `parts` blocks that nothing couples. Dense matrices and the host's solver have one part.
 */
#ifndef DLSI_REDUCTION_H
#define DLSI_REDUCTION_H

#include "delassus/reduction.h"
#include "dlsi.h"

enum {
  dlsi_batch = 64, /* most right-hand sides in one solve; more are not faster */
  dlsi_largest_part =
      8000 /* unknowns of a sparse K that are factored as one dense matrix: 0.5 GB */
};

typedef struct dlsi_factor {
  int n, parts;
  int largest;    /* unknowns of the largest part */
  int *first;     /* parts + 1: part k owns the positions first[k] .. first[k+1]-1, */
  int *unknown;   /* n: where unknown[position] stands; ascending within a part */
  int symmetric;  /* Cholesky: K^-1 is symmetric whatever the rounding of a solve */
  size_t scratch; /* doubles of `work` for a solve, per unknown and right-hand side: 0 or 1 */

  dls_operator kind;
  double *A;         /* the parts' matrices or factors, one after the other, ... */
  size_t *start;     /* parts: ... beginning here */
  double *row, *col; /* n: powers of two; what is factored is diag(row) K diag(col) */
  int *pivot;        /* n: row exchanges of LU */
  dls_solve_fn solve;
  void *user;
  void *memory; /* of all arrays but A */
} dlsi_factor;

/* *out = the operator of a model that has passed dlsi_check_model, factored; NULL on error.
 * DLS_E_NOT_POSITIVE_DEFINITE, DLS_E_SINGULAR, DLS_E_NOT_FINITE (entries that add up to Inf),
 * DLS_E_UNSUPPORTED (a part too large), DLS_E_SIZE, DLS_E_MEMORY; index: the unknown of the whole
 * K. */
dls_status dlsi_factor_create(dlsi_factor **out, const char *function, const dls_model *model,
                              dls_error *error);

/* X (size of the part x nrhs, column-major without gaps) := K_part^-1 X, nrhs <= dlsi_batch. work:
 * scratch * size * nrhs doubles. Allocates nothing. DLS_E_CALLBACK, X then being undefined. */
dls_status dlsi_factor_solve(const dlsi_factor *factor, const char *function, int part, double *X,
                             int nrhs, double *work, dls_error *error);

/* NULL is fine. */
void dlsi_factor_destroy(dlsi_factor *factor);

/* Candidates of a checked model. */
int dlsi_model_candidates(const dls_model *model);

#endif
