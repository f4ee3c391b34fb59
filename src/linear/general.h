/* general.h: LU of a square matrix given by triplets. */
#ifndef DLSI_GENERAL_H
#define DLSI_GENERAL_H

#include "contact/columns.h"
#include "linear/dense.h"
#include "linear/sparse_lu.h"

/* Dense up to 250 unknowns, and in a build without MUMPS up to 8000; else by MUMPS. Zero at
 * first. */
typedef struct dlsi_general {
  int n, dense;      /* dense: 1 if the last factor is dense */
  dlsi_dense of;     /* its factor */
  double *A, *scale; /* n^2; row and column scales, 4 n */
  int *pivot;
  size_t room;        /* largest n of the arrays */
  dlsi_sparse_lu *lu; /* NULL where never needed */
} dlsi_general;

/* Factors the matrix of t, square. DLS_E_SINGULAR, DLS_E_UNSUPPORTED (without MUMPS),
 * DLS_E_MEMORY. */
dls_status dlsi_general_factor(dlsi_general *work, const dlsi_triplets *t, dls_error *error);

/* x (n) := A^-1 x or, transposed, A^-T x. DLS_E_MEMORY. */
dls_status dlsi_general_solve(const dlsi_general *work, int transposed, double *x,
                              dls_error *error);

/* Frees the memory, not *work itself. */
void dlsi_general_free(dlsi_general *work);

#endif
