/* system.h: A = K + rho H H^T + E, factored for several rho after one analysis. */
#ifndef DLSI_SYSTEM_H
#define DLSI_SYSTEM_H

#include "contact/columns.h"
#include "contact/contact.h"
#include "linear/cholesky.h"
#include "linear/general.h"

/* *out := K of a checked model, dense or sparse, as dlsi_system_create takes it: by columns,
 * repeated entries added up, of a symmetric K only the lower triangle. The caller calls
 * dlsi_columns_free, also after an error: DLS_E_MEMORY, DLS_E_SIZE, DLS_E_NOT_FINITE if a sum is
 * infinite. */
dls_status dlsi_stiffness_columns(const dls_model *model, dlsi_columns *out, dls_error *error);

typedef struct dlsi_system {
  int n, d;
  int symmetric, definite;    /* definite: 0 after a pivot has shown that A is not */
  size_t entries, of_K, of_H; /* entries = of_K + of_H + n, in this order, of one triangle where K
                                 is symmetric */
  int *row, *col;             /* counted from 1: entries */
  double *x;                  /* values of A: entries */
  double *h;                  /* values of H H^T: of_H */
  const double *K;            /* values of K, borrowed: of_K */
  dls_sparse H;               /* borrowed */
  double *e;                  /* n: E is hold * e; |K_jj|, or the largest entry of column j; 0 of
                                 multipliers: redundant joints are not in K */
  double hold;                /* 0 where nothing is singular */
  double *size;               /* n: scratch */
  dlsi_cholesky *cholesky;    /* NULL where K is not symmetric */
  dlsi_general general;
} dlsi_system;

/* Analyses. K: sparse, repeated entries added up; of a symmetric K only the lower triangle. H: n
 * x m, d columns a contact. joint: 1 of a multiplier, n; NULL: there is none. The values are read,
 * and K.Ks.x and H are borrowed. *out = NULL on error: DLS_E_MEMORY, DLS_E_SIZE. */
dls_status dlsi_system_create(dlsi_system **out, const dls_model *K, const dls_sparse *H, int d,
                              const int *joint, dls_error *error);

/* Orders and analyses A, or A + A^T where K is not symmetric. *out = NULL on error:
 * DLS_E_MEMORY. */
dls_status dlsi_system_analyse(const dlsi_system *work, dlsi_cholesky **out, dls_error *error);

/* Takes new values on the same pattern. */
void dlsi_system_update(dlsi_system *work, const dls_model *K, const dls_sparse *H,
                        const int *joint);

/* Factors A. If A is singular, or a pivot is rounding, hold := 1e-8: then E holds what nothing else
 * holds. The caller adds E x_old to the right side, so that a fixed point does not depend on E. LU
 * if A is not definite. DLS_E_SINGULAR, DLS_E_UNSUPPORTED, DLS_E_MEMORY. */
dls_status dlsi_system_factor(dlsi_system *work, double rho, dls_error *error);

/* Factors K + rho H_p H_p^T + E, summed over bodies p, in place of A: each side of a contact is
 * held by itself. part: the connected body of each unknown, n. Errors of dlsi_system_factor. */
dls_status dlsi_system_factor_apart(dlsi_system *work, double rho, const int *part,
                                    dls_error *error);

/* Factors K + H M H^T + E in place of A. M: symmetric, a block for each contact: 4 numbers, nn, tt,
 * ss, ts; other couplings are 0. DLS_E_SINGULAR if that is not definite, DLS_E_MEMORY. */
dls_status dlsi_system_factor_weighted(dlsi_system *work, const double *M, dls_error *error);

/* x := A^-1 x. DLS_E_MEMORY. */
dls_status dlsi_system_solve(dlsi_system *work, double *x, dls_error *error);

/* NULL is fine. */
void dlsi_system_destroy(dlsi_system *work);

#endif
