/*
 * pieces.h: BLAS and LAPACK for small matrices, in pieces so small that no BLAS wakes a thread for
 * one: waking a thread costs more CPU than the work, and changes the order of sums. `alone`, from
 * dlsi_is_small, selects pieces (1) or one call of BLAS for the whole (0). The sizes determine the
 * pieces: any number of threads gives the same bits.
 */
#ifndef DLSI_PIECES_H
#define DLSI_PIECES_H

#include "contact/contact.h"

/* Returns 1 if a matrix, or its factor, with so many entries is worth one thread only: a dense
 * problem with 1000 rows takes some 10 ms. */
int dlsi_is_small(size_t entries);

/* C := alpha op(A) op(B) + beta C; arguments as those of dgemm. C: m x n; op(A): m x k. */
void dlsi_gemm(int alone, char transa, char transb, int m, int n, int k, double alpha,
               const double *A, int lda, const double *B, int ldb, double beta, double *C, int ldc);

/* C := alpha A A^T + beta C, lower triangles; the upper one of C is kept. C: n x n; A: n x k. */
void dlsi_syrk(int alone, int n, int k, double alpha, const double *A, int lda, double beta,
               double *C, int ldc);

/* y := alpha A x + beta y. A: m x n, n > 0, column-major without gaps. */
void dlsi_gemv(int alone, int m, int n, double alpha, const double *A, const double *x, double beta,
               double *y);

/* B := op(T)^-1 B, or with side 'R', uplo 'L' and trans 'T' B := B T^-T; T is triangular, and the
 * arguments are those of dtrsm. B: m x n. */
void dlsi_trsm(int alone, char side, char uplo, char trans, char diag, int m, int n,
               const double *T, int ldt, double *B, int ldb);

/* A := L with A = L L^T, lower triangles. Returns 0, or k > 0 if pivot k, counted from 1, is not
 * positive. A: n x n, leading dimension ld. */
int dlsi_potrf(int alone, int n, double *A, int ld);

/* Returned if the host has cancelled the work. */
enum { dlsi_stopped = -2 };

/* Returns how many columns make a piece of some 4e9 operations, a tenth of a second, if each column
 * takes `each`; at least 64. */
int dlsi_piece_columns(double each);

/* Factors a panel: A := L with A = L L^T as dlsi_potrf, rows below it := (these rows) L^-T. A: n x
 * n on top of `rows` rows, leading dimension ld. Looks at the watch between pieces of some 4e9
 * operations, after `done` of its stage, and returns dlsi_stopped if the host cancels. */
int dlsi_panel(int alone, int n, int rows, double *A, int ld, dlsi_watch *watch, int done);

/* A := L and U with P A = L U. Returns 0, or k > 0 if pivot k, counted from 1, is 0. A: n x n,
 * leading dimension ld; pivot: n, row exchanges counted from 1. */
int dlsi_getrf(int alone, int n, double *A, int ld, int *pivot);

/* B := A^-1 B with the factors of dlsi_getrf. B: n x nrhs, leading dimension ldb. */
void dlsi_getrs(int alone, int n, int nrhs, const double *A, int ld, const int *pivot, double *B,
                int ldb);

#endif
