/* columns.h: sparse matrices that own their arrays. */
#ifndef DLSI_COLUMNS_H
#define DLSI_COLUMNS_H

#include "contact.h"

/* Compressed columns. Free them after a failed allocation, too. */
typedef struct dlsi_columns {
  int rows, cols;
  int *p, *i;
  double *x;
} dlsi_columns;

/* Entries by row and column, in any order; entries of the same place add up. */
typedef struct dlsi_triplets {
  int rows, cols, count;
  int *row, *col;
  double *x;
} dlsi_triplets;

/* A part of the columns of a matrix, where columns are local directions (n, t[, s], n, ...). */
typedef enum dlsi_part { DLSI_ALL, DLSI_NORMALS, DLSI_TANGENTS } dlsi_part;

/* Allocates `most` triplets, none filled. Free t after a failure, too. DLS_E_MEMORY; DLS_E_SIZE if
 * there are more than INT_MAX. */
dls_status dlsi_triplets_alloc(int rows, int cols, size_t most, dlsi_triplets *t, dls_error *error);

static inline void dlsi_triplets_add(dlsi_triplets *t, int row, int col, double x) {
  t->row[t->count] = row;
  t->col[t->count] = col;
  t->x[t->count++] = x;
}

dls_status dlsi_columns_alloc(int rows, int cols, int entries, dlsi_columns *A, dls_error *error);
void dlsi_columns_free(dlsi_columns *A);
dls_sparse dlsi_columns_view(const dlsi_columns *A);
void dlsi_triplets_free(dlsi_triplets *t);

/* Returns the number of local column col within the part, -1 if the part does not have it. */
int dlsi_column_of(int d, dlsi_part which, int col);

/* Sorts a part of the triplets into compressed columns A; entries of a column keep their order. */
dls_status dlsi_columns_compress(const dlsi_triplets *t, int d, dlsi_part which, dlsi_columns *A,
                                 dls_error *error);

#endif
