/*
 * reduction_internal.h: declares what the files of reduction/ share, and the contract of the
 * back-ends.
 *
 * A back-end presents K as a direct sum: in the order of the parts K is block diagonal, with
 * `parts` blocks that nothing couples. Dense matrices, the host's solver, and a sparse K that goes
 * to MUMPS have one part. A position is the number of an unknown in this order.
 */
#ifndef DLSI_REDUCTION_H
#define DLSI_REDUCTION_H

#include "contact/body.h"
#include "contact/columns.h"
#include "contact/contact.h"
#include "delassus/reduction.h"
#include "linear/operator.h"
#include "linear/own.h"
#include "linear/schur.h"
#include "linear/system.h"

enum {
  dlsi_batch = 64,         /* most right-hand sides in one solve; more are not faster */
  dlsi_small_part = 250,   /* up to so many unknowns a dense factor of a sparse K is faster ... */
  dlsi_tiny_part = 25,     /* ... than the Schur complement; if K is definite and has at most ... */
  dlsi_few_parts = 4,      /* ... few_parts parts, up to tiny_part */
  dlsi_largest_part = 8000 /* most unknowns of such a part in a build without MUMPS: 0.5 GB */
};

/* ---- K --------------------------------------------------------------------------------------- */

typedef struct dlsi_factor {
  int n, parts;
  int largest;    /* unknowns of the largest part */
  int *first;     /* parts + 1: part k owns the positions first[k] .. first[k+1]-1 */
  int *unknown;   /* n: the unknown at each position; ascending within a part */
  int *place;     /* n: the position of each unknown */
  int symmetric;  /* 1: K^-1 is symmetric up to the rounding of a solve */
  size_t scratch; /* doubles of `work` for a solve, per unknown and right-hand side: 0 or 1 */

  dls_operator kind;
  dls_factorization factorization;
  double rcond;      /* of the scaled K, the least of its parts */
  dlsi_schur *schur; /* NULL: the parts are dense, or the host's */
  int kept;          /* unknowns of the Schur complement */
  int keeps_Z;       /* 1: keep Z for other H (dls_reduction_move) */
  double *Z;         /* (kept + 1) x kept: S^-1 and scratch; NULL: not at hand */
  size_t entries;    /* of A */
  double *A;         /* matrices or factors of the parts, one after the other */
  size_t *start;     /* parts: where each of them starts in A */
  double *row, *col; /* n, by position: powers of two; diag(row) K diag(col) is factored */
  int *pivot;        /* n, by position: row exchanges of LU */
  dls_solve_fn solve;
  void *user;
  void *memory;      /* of all arrays but A */
  dlsi_watch *watch; /* the caller's, for numeric and dlsi_influence; or NULL */
} dlsi_factor;

/* Lays out and analyses the operator of a model that has passed dlsi_check_model; *out = NULL on
 * error. keep: unknowns of the Schur complement where there is one, ascending, count.
 * DLS_E_SINGULAR (structurally), DLS_E_UNSUPPORTED (a part too large), DLS_E_SIZE, DLS_E_MEMORY. */
dls_status dlsi_factor_create(dlsi_factor **out, const dls_model *model, int count, const int *keep,
                              dls_error *error);

/* Estimates factor_bytes, bytes (most in use while factoring) and flops of the layout. */
void dlsi_factor_estimate(const dlsi_factor *factor, dls_reduction_info *info);

/* Compares the pattern of a sparse K of the same size. DLS_E_ARGUMENT naming Ks if it differs. */
dls_status dlsi_factor_same(const dlsi_factor *factor, const dls_model *model, dls_error *error);

/* Factors the values of a model of the same pattern. DLS_E_NOT_POSITIVE_DEFINITE, DLS_E_SINGULAR,
 * DLS_E_NOT_FINITE (entries that add up to Inf), DLS_E_MEMORY; index: the unknown of the whole
 * K. DLS_CANCELLED by factor->watch: the factor holds nothing. */
dls_status dlsi_factor_numeric(dlsi_factor *factor, const dls_model *model, dls_error *error);

/* Solves X := K_part^-1 X. X: size of the part x nrhs, column-major without gaps, nrhs <=
 * dlsi_batch. work: scratch, factor->scratch * size * nrhs. Only schur.h allocates.
 * DLS_E_CALLBACK, DLS_E_MEMORY; X is then undefined. */
dls_status dlsi_factor_solve(const dlsi_factor *factor, int part, double *X, int nrhs, double *work,
                             dls_error *error);

/* NULL is fine. */
void dlsi_factor_destroy(dlsi_factor *factor);

/* ---- kept.c: the host's model, for the certificate of the body ------------------------------- */

typedef struct dlsi_kept {
  int has_K;         /* 0: a flexibility, a host's solver */
  dls_model model;   /* a view of K alone */
  dlsi_body body;    /* kept_body fills its model */
  double *f, *gap;   /* the last load: n, m */
  double *u, *w;     /* m: scratch; weights of the contacts: 2 nc */
  double *x;         /* values of K */
  double *scratch;   /* of the measure */
  int *index, *part; /* part: 3 n, with joints and pieces */
  double *memory;
  dlsi_columns K, H; /* of system, which is made when a certificate first needs it */
  dlsi_system *system;
} dlsi_kept;

/* Copies K, finds the bodies and the weights. H is borrowed. The caller calls dlsi_kept_free, also
 * after an error: DLS_E_MEMORY. */
dls_status dlsi_kept_create(dlsi_kept *kept, const dls_model *model, const dlsi_operator *H,
                            dls_error *error);
void dlsi_kept_free(dlsi_kept *kept);

/* Certifies (x, r) for the last load, and for u = H^T x + g in kept->u. Looks behind loads that
 * balance in themselves and behind rounding (linear/own.h) if the pair does not hold at `tol`
 * without. regular: K is known to be held: without reactions there is nothing to look behind.
 * DLS_E_MEMORY, DLS_E_SINGULAR, DLS_E_UNSUPPORTED. */
dls_status dlsi_kept_certify(dlsi_kept *kept, const dlsi_operator *H, const double *mu,
                             const double *r, const double *x, double tol, int regular,
                             dls_certificate *certificate, dls_error *error);
/* Makes *next of another H on the same K, with the same f: what depends on H is new, what does not
 * stays that of kept until dlsi_kept_take, which frees the old. Call dlsi_kept_free(next) after an
 * error: DLS_E_MEMORY. */
dls_status dlsi_kept_again(const dlsi_kept *kept, const dlsi_operator *H, dlsi_kept *next,
                           dls_error *error);
void dlsi_kept_take(dlsi_kept *kept, const dlsi_kept *next);

/* ---- W --------------------------------------------------------------------------------------- */

/* Forms W := H^T K^-1 H, m x m. DLS_E_NOT_FINITE naming W, DLS_E_MEMORY, the errors of the
 * solves; DLS_CANCELLED by factor->watch. */
dls_status dlsi_influence(dlsi_factor *factor, const dlsi_operator *H, double *W, dls_error *error);

#endif
