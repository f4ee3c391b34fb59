/* states_matrix.h: the matrix that the states of the contacts leave, and its factors. */
#ifndef DLSI_STATES_MATRIX_H
#define DLSI_STATES_MATRIX_H

#include "contact/contact.h"
#include "linear/dense.h"
#include "linear/room.h"

/* The unknowns y and equations of one contact in its state: states_matrix.c, (SM1). */
typedef struct dlsi_branch {
  short state;     /* dls_contact_state */
  short symmetric; /* 1: R = E^T (SM3), 0: (SM1) */
  short count;     /* number of unknowns, ... */
  int first;       /* ... the first one */
  double mu;
  double t[2]; /* slip: direction along; across, d = 3: (-t[1], t[0]) */
  double l;
} dlsi_branch;

/* e (3) := the direction of unknown j of a contact in its r: column j of E. */
void dlsi_branch_direction(const dlsi_branch *b, int j, double *e);

/* Returns row i of R of a contact times v (3). */
double dlsi_branch_row(const dlsi_branch *b, int i, const double *v);

/* v (3) := a block of W, d x d at x, times e. */
void dlsi_branch_block(int d, const double *x, size_t ld, const double *e, double *v);

/* Returns 1 if a and b lead to the same rows and columns of A. */
int dlsi_branch_is_same(const dlsi_branch *a, const dlsi_branch *b);

/* branch (nc) := those of r in these states, u = W r + q. Returns the number of unknowns n. */
int dlsi_branches_set(const dls_contact *problem, const dls_contact_state *state, const double *r,
                      const double *u, dlsi_branch *branch);

/* Products with R and E. y: n; v: m. */
void dlsi_branches_rows(int d, int nc, const dlsi_branch *branch, const double *v, double *y);
void dlsi_branches_directions(int d, int nc, const dlsi_branch *branch, const double *v,
                              double *y); /* y := E^T v; the line above: y := R v */
void dlsi_branches_add_rows(int d, int nc, const dlsi_branch *branch, const double *y,
                            double *v); /* v += R^T y */
void dlsi_branches_add_directions(int d, int nc, const dlsi_branch *branch, const double *y,
                                  double *v); /* v += E y */

/* A (n x n) := R W E + L + shift_c R E on the diagonal; W dense or by blocks. shift: nc, or NULL.
 * row: n, the row of W of each row of A (not of those across a slip). column: scratch, m. */
void dlsi_states_fill(const dls_contact *problem, const dlsi_branch *branch, const double *shift,
                      int n, int *row, double *column, double *A);

typedef enum dlsi_states_factors {
  DLSI_NO_FACTORS,
  DLSI_DENSE_FACTORS,
  DLSI_SPARSE_FACTORS
} dlsi_states_factors;

/* A with its factors: Cholesky if A is symmetric and positive definite, else LU, in dense storage;
 * by MUMPS if W by blocks is sparse. */
typedef struct dlsi_states_matrix {
  int d, nc, n;                /* n: unknowns, of the caller with `branch` */
  dlsi_branch *branch;         /* nc */
  dlsi_states_factors factors; /* of these branches, until the caller changes them */
  int sparse;                  /* 1: more than dense_limit unknowns are factorised by MUMPS */
  dlsi_dense dense;
  dlsi_room *room;
  int *pivot; /* m */
  int *p;     /* m + 1: starts of columns, or rows of W */
} dlsi_states_matrix;

/* Takes branch, pivot and p. d, nc: set. */
void dlsi_states_carve(dlsi_states_matrix *A, dlsi_arena *arena);

/* Makes room for the matrices of nc contacts, W dense (blocks = 0) or in `blocks` blocks. told:
 * blocks announced for A->nc contacts, 0: none; they decide how A is factorised. DLS_E_MEMORY. */
dls_status dlsi_states_reserve(dlsi_states_matrix *A, int nc, int blocks, int told,
                               dls_error *error);

/* Fills A (dlsi_states_fill) and factors it. scratch: m. DLS_E_SINGULAR, DLS_E_MEMORY. */
dls_status dlsi_states_factor(dlsi_states_matrix *A, const dls_contact *problem,
                              const double *shift, double *scratch, dls_error *error);

/* x (n) := A^-1 x or, transposed, A^-T x. DLS_E_MEMORY (MUMPS). */
dls_status dlsi_states_solve(const dlsi_states_matrix *A, int transposed, double *x,
                             dls_error *error);

/* Allocates A with a room of its own for the problem, W dense or by blocks. Later only MUMPS
 * allocates. *out = NULL on error: DLS_E_MEMORY. destroy: NULL is fine. */
dls_status dlsi_states_create(dlsi_states_matrix **out, const dls_contact *problem,
                              dls_error *error);
void dlsi_states_destroy(dlsi_states_matrix *A);

#endif
