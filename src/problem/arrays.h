/* arrays.h: matrices and vectors of a host code, read from files; every function complains of what
 * is wrong itself. */
#ifndef ARRAYS_H
#define ARRAYS_H

#include "delassus.h"
#include "files/formats.h"

/* Rows of numbers: a[i * cols + j], which the caller frees, after a failure, too. */
typedef dlsi_table table;

/* Reads a table: Matrix Market, .npy, PETSc's vectors or plain text. Returns 1; 0 after a
 * complaint. */
int table_read(const char *path, table *t);

/* Sets if text holds triplets: --triplets. */
void arrays_of_triplets(int on);

/* Returns 1 if all rows of a table look like row, column, value. */
int table_is_triplets(const table *t);

/* Complains that a file looks like triplets; returns 0. */
int refuse_triplets(const char *path);

/* Returns a new copy of the table, column after column; NULL after a complaint. */
double *table_by_columns(const char *path, const table *t);

/* A sparse matrix that owns its arrays: those of the reader of the library, where p is NULL, or p,
 * i, x. */
typedef struct sparse {
  dls_sparse view;
  int *p, *i;
  double *x;
  int *labels; /* (node, direction) of each row, as the file has them; or NULL */
} sparse;

/* Allocates room for `count` entries; returns 1, or 0 after a complaint. */
int sparse_alloc(int rows, int cols, size_t count, sparse *A);

/* Reads a matrix of any kind; returns 1, or 0 after a complaint. */
int sparse_read(const char *path, sparse *A);
void sparse_free(sparse *A);

/* Return 1 if the file holds entries by row and column (-1 after a complaint); if its name is that
 * of CalculiX. */
int array_is_sparse(const char *path);
int array_is_calculix(const char *path);

/* Return 1 if the matrix (n x n) is symmetric but for the rounding of an assembly, 0 if not; -1
 * after a complaint of no memory. */
int dense_is_symmetric(int n, const double *a);
int sparse_is_symmetric(const dls_sparse *A);

/* Return "a lower" or "an upper" if all entries beside the diagonal stand on one side of it, else
 * NULL. */
const char *dense_triangle(int n, const double *a);
const char *sparse_triangle(const dls_sparse *A);

#endif
