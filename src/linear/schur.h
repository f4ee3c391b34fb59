/*
 * schur.h: a sparse K without the unknowns c that are kept, by MUMPS (sequential) with an ordering by
 * METIS:
 *
 *   S = K_cc - K_ci K_ii^-1 K_ic,      K x = b:   S x_c = b_c - K_ci K_ii^-1 b_i,
 *                                                 K_ii x_i = b_i - K_ic x_c
 *
 * S is dense and kept as its Cholesky or LU factor. With no unknown kept this is a sparse direct
 * solver. In a build without MUMPS (MUMPS=0) create answers DLS_E_UNSUPPORTED.
 *
 * MUMPS allocates in every call, and its Fortran modules hold process-wide variables: no two threads
 * may be in these functions at once. Nothing is printed.
 */
#ifndef DLSI_SCHUR_H
#define DLSI_SCHUR_H

#include "base/base.h"

typedef struct dlsi_schur dlsi_schur;

/* 1 if this build has MUMPS. */
int dlsi_schur_available(void);

/* Takes over the pattern of Ks (DLS_CHOLESKY, DLS_LDLT: of its lower triangle), orders and analyses
 * it. keep (count): the unknowns c, ascending; borrowed. All errors on behalf of `function`;
 * *out = NULL on error. DLS_E_UNSUPPORTED, DLS_E_MEMORY, DLS_E_SINGULAR (structurally). */
dls_status dlsi_schur_create(dlsi_schur **out, const dls_sparse *Ks,
                             dls_factorization factorization, int count, const int *keep,
                             dls_error *error);

/* What the analysis foresees: bytes of the factor, bytes in use at the same time while factoring (S
 * included), operations (the dense ones on S included). */
void dlsi_schur_estimate(const dlsi_schur *schur, double *factor_bytes, double *bytes,
                         double *flops);

/* DLS_E_ARGUMENT naming Ks if its pattern is not the one that was analysed; its size is. */
dls_status dlsi_schur_same(const dlsi_schur *schur, const dls_sparse *Ks, dls_error *error);

/* Takes over the values of Ks, of the same pattern, and factors. DLS_E_NOT_POSITIVE_DEFINITE (value: a pivot, or the number of negative ones), DLS_E_SINGULAR,
 * DLS_E_NOT_FINITE (overflow of entries that add up), DLS_E_MEMORY. */
dls_status dlsi_schur_factor(dlsi_schur *schur, const dls_sparse *Ks, dls_error *error);

/* X (n x nrhs, column-major) := K^-1 X. DLS_E_MEMORY. */
dls_status dlsi_schur_solve(dlsi_schur *schur, double *X, int nrhs, dls_error *error);

/* z (count) := (K^-1 x)_c, for half of the work; count > 0. x (n) is spoilt. DLS_E_MEMORY. */
dls_status dlsi_schur_kept(dlsi_schur *schur, double *x, double *z, dls_error *error);

/* Z (count x count, column-major) := S^-1 = (K^-1)_cc, exactly symmetric where K is. DLS_E_MEMORY. */
dls_status dlsi_schur_inverse(const dlsi_schur *schur, double *Z, dls_error *error);

/* The smallest singular value of the scaled K over its largest, by estimate: 1 / (|K|_1 |K^-1|_F). */
double dlsi_schur_rcond(const dlsi_schur *schur);

/* |A x - v| / (|A||x|) of two solves with the scaled K of the last factor. Where K is indefinite K_ii
 * may be singular, or nearly so, although K is not: factor then answers DLS_E_SINGULAR, or this is far
 * above rounding, and keeping no unknown is the way out. */
double dlsi_schur_error(const dlsi_schur *schur);

/* NULL is fine. */
void dlsi_schur_destroy(dlsi_schur *schur);

#endif
