/*
 * cholesky.h: A = L L^T of a sparse symmetric positive definite matrix by supernodes: columns of L
 * with the same rows below them form one dense panel. The last `kept` unknowns c of the order are
 * one supernode: its panel is the factor of S = A_cc - A_ci A_ii^-1 A_ic.
 *
 * A position is the number of an unknown in the order of elimination.
 */
#ifndef DLSI_CHOLESKY_H
#define DLSI_CHOLESKY_H

#include "contact/contact.h"

typedef struct dlsi_cholesky {
  int n, kept, count; /* unknowns; those of c; supernodes, c last if there is one */
  int *unknown, *place;
  int *first;    /* count + 1: supernode s owns the positions first[s] .. first[s+1]-1 */
  int *owner;    /* n: the supernode of a position */
  size_t *start; /* count + 1: the rows below its columns are row[start[s]] .. , ascending */
  int *row;
  size_t *panel; /* count + 1: its panel begins at L + panel[s]: columns, then rows, below each
                    other; as many columns; lower triangle on top */
  size_t *where; /* entries of A: the place of each in L */
  size_t entries;
  double *L;
  int longest;       /* rows of the longest panel */
  size_t update;     /* entries of the largest update */
  double flops;      /* of the factorisation */
  double *pivot;     /* n: reciprocals of the diagonal of L */
  double *y, *held;  /* n: of the current solve; L^-1 b of dlsi_cholesky_condense */
  double *x;         /* longest */
  int *head, *next;  /* count: list of supernodes whose next update is for this one */
  size_t *todo;      /* count: the first row of a supernode that has not updated */
  int *local;        /* n: place of a position in the current panel */
  dlsi_watch *watch; /* the caller's, for dlsi_cholesky_factor; or NULL */
} dlsi_cholesky;

/* Analyses the graph of the entries (row[k], col[k]), k < entries, counted from 1, of one triangle.
 * order: the place of each unknown, counted from 1, n; the last `kept` are c. *out = NULL on error.
 * DLS_E_MEMORY. */
dls_status dlsi_cholesky_create(dlsi_cholesky **out, int n, size_t entries, const int *row,
                                const int *col, const int *order, int kept, dls_error *error);

/* Factors. x: the values, entries. Returns 0, or k > 0 if the pivot at position k, counted from 1,
 * is *pivot <= 0. DLS_E_MEMORY is -1, DLS_CANCELLED dlsi_stopped (pieces.h). */
int dlsi_cholesky_factor(dlsi_cholesky *work, const double *x, double *pivot);

/* Returns the factor of S, kept x kept without gaps, lower triangle; NULL for kept = 0. */
double *dlsi_cholesky_of_kept(const dlsi_cholesky *work);

/* Solves X := A^-1 X. X: n x nrhs. Allocates for more than one right-hand side: DLS_E_MEMORY. */
dls_status dlsi_cholesky_solve(dlsi_cholesky *work, double *X, int nrhs, dls_error *error);

/* The two halves of a solve of A x = b + (0, h_c). condense takes b (n; NULL for 0), keeps the
 * forward pass and computes z := b_c - A_ci A_ii^-1 b_i (kept). expand takes x_c = S^-1 (z + h_c)
 * and computes all of x (n). It may run once for each h. */
void dlsi_cholesky_condense(dlsi_cholesky *work, const double *b, double *z);
void dlsi_cholesky_expand(dlsi_cholesky *work, const double *xc, double *x);

/* NULL is fine. */
void dlsi_cholesky_destroy(dlsi_cholesky *work);

#endif
