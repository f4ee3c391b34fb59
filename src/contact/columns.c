/* columns.c: sparse matrices that own their arrays. */
#include "columns.h"

#include <limits.h>
#include <stdlib.h>
#include <string.h>

void dlsi_columns_free(dlsi_columns *A) {
  free(A->p);
  free(A->i);
  free(A->x);
}

dls_status dlsi_columns_alloc(int rows, int cols, int entries, dlsi_columns *A, dls_error *error) {
  A->rows = rows;
  A->cols = cols;
  A->p = dlsi_alloc((size_t)cols + 1, sizeof *A->p);
  A->i = dlsi_alloc((size_t)entries, sizeof *A->i);
  A->x = dlsi_alloc((size_t)entries, sizeof *A->x);
  return A->p && A->i && A->x ? DLS_OK : dlsi_no_memory(error);
}

dls_sparse dlsi_columns_view(const dlsi_columns *A) {
  return (dls_sparse){A->rows, A->cols, A->p, A->i, A->x};
}

dls_status dlsi_triplets_alloc(int rows, int cols, size_t most, dlsi_triplets *t,
                               dls_error *error) {
  *t = (dlsi_triplets){.rows = rows, .cols = cols};
  if (most > INT_MAX)
    return dlsi_fail(error, DLS_E_SIZE, "", -1, (double)most, "%zu entries are too many", most);
  t->row = dlsi_alloc(most, sizeof *t->row);
  t->col = dlsi_alloc(most, sizeof *t->col);
  t->x = dlsi_alloc(most, sizeof *t->x);
  return t->row && t->col && t->x ? DLS_OK : dlsi_no_memory(error);
}

void dlsi_triplets_free(dlsi_triplets *t) {
  free(t->row);
  free(t->col);
  free(t->x);
}

int dlsi_column_of(int d, dlsi_part which, int col) {
  const int c = col / d, k = col % d;
  if (which == DLSI_ALL) return col;
  if (which == DLSI_NORMALS) return k == 0 ? c : -1;
  return k == 0 ? -1 : (d - 1) * c + k - 1;
}

dls_status dlsi_columns_compress(const dlsi_triplets *t, int d, dlsi_part which, dlsi_columns *A,
                                 dls_error *error) {
  const int cols = which == DLSI_ALL ? t->cols : t->cols / d * (which == DLSI_NORMALS ? 1 : d - 1);
  int entries = 0;
  for (int k = 0; k < t->count; k++)
    entries += dlsi_column_of(d, which, t->col[k]) >= 0;
  const dls_status status = dlsi_columns_alloc(t->rows, cols, entries, A, error);
  if (status) return status;
  memset(A->p, 0, ((size_t)cols + 1) * sizeof *A->p);
  for (int k = 0; k < t->count; k++) {
    const int j = dlsi_column_of(d, which, t->col[k]);
    if (j >= 0) A->p[j + 1]++;
  }
  for (int j = 0; j < cols; j++)
    A->p[j + 1] += A->p[j];
  for (int k = 0; k < t->count; k++) {
    const int j = dlsi_column_of(d, which, t->col[k]);
    if (j < 0) continue;
    A->i[A->p[j]] = t->row[k];
    A->x[A->p[j]++] = t->x[k];
  }
  for (int j = cols; j > 0; j--) /* each p[j] is at the end of its column now */
    A->p[j] = A->p[j - 1];
  A->p[0] = 0;
  return DLS_OK;
}
