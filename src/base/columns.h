/* columns.h: sparse matrices that own their arrays. */
#ifndef DLSI_COLUMNS_H
#define DLSI_COLUMNS_H

#include "base/base.h"

/* compressed columns; free after a failed alloc, too */
typedef struct dlsi_columns {
  int rows, cols;
  int *p, *i;
  double *x;
} dlsi_columns;

typedef struct dlsi_triplets {
  int rows, cols, count;
  int *row, *col;
  double *x;
} dlsi_triplets;

/* Which columns of a matrix of local columns (n, t[, s], n, ...), and how they are numbered. */
typedef enum dlsi_part { DLSI_ALL, DLSI_NORMALS, DLSI_TANGENTS } dlsi_part;

/* Room for `most` triplets, of which there are none yet. Free t after a failure, too. DLS_E_MEMORY;
 * DLS_E_SIZE if they are more than INT_MAX. */
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

/* The number of local column col within the part, -1 if it is not of the part. */
int dlsi_column_of(int d, dlsi_part which, int col);

/* A := a part of the columns; a counting sort, so that each keeps the order of the triplets. */
dls_status dlsi_columns_compress(const dlsi_triplets *t, int d, dlsi_part which, dlsi_columns *A,
                                 dls_error *error);

#endif
