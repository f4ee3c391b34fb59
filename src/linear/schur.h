/*
 * schur.h: factors a sparse K without the unknowns c that are kept, in an order by METIS: by
 * cholesky.c if K is positive definite, else by MUMPS (sequential):
 *
 *   S = K_cc - K_ci K_ii^-1 K_ic,      K x = b:   S x_c = b_c - K_ci K_ii^-1 b_i,
 *                                                 K_ii x_i = b_i - K_ic x_c
 *
 * S is dense and kept as its Cholesky or LU factor. With no unknown kept this is a sparse direct
 * solver. In a build without MUMPS (MUMPS=0) create returns DLS_E_UNSUPPORTED.
 *
 * MUMPS allocates in every call; only one thread at a time may call it (mumps.h). Nothing is
 * printed.
 */
#ifndef DLSI_SCHUR_H
#define DLSI_SCHUR_H

#include "contact/contact.h"

typedef struct dlsi_schur dlsi_schur;

/* Returns 1 if this build has MUMPS. */
int dlsi_schur_available(void);

/* Copies the pattern of Ks (DLS_CHOLESKY, DLS_LDLT: of its lower triangle), orders and analyses it.
 * keep: the unknowns c, ascending, count; copied. *out = NULL on error: DLS_E_UNSUPPORTED,
 * DLS_E_MEMORY, DLS_E_SINGULAR (structurally). */
dls_status dlsi_schur_create(dlsi_schur **out, const dls_sparse *Ks,
                             dls_factorization factorization, int count, const int *keep,
                             dls_error *error);

typedef struct dlsi_schur_measures {
  /* estimated by create */
  double factor_bytes; /* of the factor */
  double bytes;        /* most in use while factoring, S included */
  double flops;        /* operations, the dense ones on S included */
  int fronts;          /* supernodes of a definite K; 0: MUMPS has its own */
  /* of the last factor; 0 before */
  double rcond; /* 1 / (|A|_1 |A^-1|_F) of the scaled K, by estimate */
  double error; /* |A x - v| / (|A||x|), the larger of two solves with the scaled K */
} dlsi_schur_measures;

/* Returns the measures, which live as long as `work`. If K is indefinite, K_ii may be singular or
 * nearly so although K is not: factor then returns DLS_E_SINGULAR, or `error` is far above
 * rounding. The remedy is to keep no unknown. */
const dlsi_schur_measures *dlsi_schur_measured(const dlsi_schur *work);

/* Compares the pattern of Ks, of the right size, with the analysed one. DLS_E_ARGUMENT naming
 * Ks. */
dls_status dlsi_schur_same(const dlsi_schur *work, const dls_sparse *Ks, dls_error *error);

/* Takes over the values of Ks, of the same pattern, and factors. DLS_E_NOT_POSITIVE_DEFINITE
 * (value: a pivot, or the number of negative ones), DLS_E_SINGULAR, DLS_E_NOT_FINITE (overflow of
 * entries that add up), DLS_E_MEMORY. */
dls_status dlsi_schur_factor(dlsi_schur *work, const dls_sparse *Ks, dls_error *error);

/* Solves X := K^-1 X. X: n x nrhs, column-major without gaps. DLS_E_MEMORY. */
dls_status dlsi_schur_solve(dlsi_schur *work, double *X, int nrhs, dls_error *error);

/* The two halves of a solve, count > 0. condense computes z := (K^-1 b)_c (count) and holds what
 * expand needs to compute x := K^-1 (b + h) (n) for an h (count) on c. x of condense: in, b; out,
 * spoilt; n. holds returns 1 if expand may be called: with MUMPS once, otherwise once for each h.
 * Other solves and a new factor end it. DLS_E_MEMORY. */
dls_status dlsi_schur_condense(dlsi_schur *work, double *x, double *z, dls_error *error);
int dlsi_schur_holds(const dlsi_schur *work);
dls_status dlsi_schur_expand(dlsi_schur *work, const double *h, double *x, dls_error *error);

/* Lets the host watch factor and inverse, and cancel them (DLS_CANCELLED): between the fronts of a
 * definite K, with MUMPS before and after. watch may be NULL. */
void dlsi_schur_watch(dlsi_schur *work, dlsi_watch *watch);

/* Computes Z := S^-1 = (K^-1)_cc, exactly symmetric if K is. Z: count x count, column-major.
 * DLS_CANCELLED. */
dls_status dlsi_schur_inverse(const dlsi_schur *work, double *Z);

/* NULL is fine. */
void dlsi_schur_destroy(dlsi_schur *work);

#endif
