/* blocks.c: dense matrices to matrices by blocks, and back. */
#include <limits.h>
#include <string.h>

#include "contact.h"

/* Checks that A is dense, square, finite, of d x d blocks. */
static dls_status check_square(const dls_dense *A, int d, dls_error *error) {
  if (!A) return dlsi_is_null(error, "A");
  const dls_status status = dlsi_check_dimension("d", d, error);
  if (status) return status;
  if (A->rows < 0 || A->rows % d)
    return dlsi_fail(error, DLS_E_SIZE, "A", -1, A->rows, "has %d row%s, not n times %d", A->rows,
                     A->rows == 1 ? "" : "s", d);
  return dlsi_check_dense("A", A, A->rows, A->rows, error);
}

/* Returns block (row, col) of A, or NULL if all its entries are 0. */
static const double *find_block(const dls_dense *A, size_t d, int row, int col) {
  const double *block = A->a + d * (size_t)row + d * (size_t)col * (size_t)A->ld;
  for (size_t j = 0; j < d; j++)
    for (size_t i = 0; i < d; i++)
      if (block[i + j * (size_t)A->ld] != 0) return block;
  return NULL;
}

dls_status dls_blocks_count(const dls_dense *A, int d, int *count, dls_error *error) {
  DLSI_DOOR;
  dls_status status = check_square(A, d, error);
  if (!status && !count) status = dlsi_is_null(error, "count");
  if (status) return dlsi_at(__func__, status, error);
  size_t found = 0;
  for (int b = 0; b < A->rows / d; b++)
    for (int a = 0; a < A->rows / d; a++)
      found += find_block(A, (size_t)d, a, b) != NULL;
  if (found > INT_MAX)
    status = /* unreachable: by a test, as 2^31 blocks take 16 GB */
        dlsi_fail(error, DLS_E_SIZE, "A", -1, (double)found, "has too many blocks");
  else
    *count = (int)found;
  return dlsi_at(__func__, status, error);
}

dls_status dls_blocks_from_dense(const dls_dense *A, int d, int *p, int *i, double *x,
                                 dls_blocks *B, dls_error *error) {
  DLSI_DOOR;
  dls_status status = check_square(A, d, error);
  if (!status && !p) status = dlsi_is_null(error, "p");
  if (!status && !i) status = dlsi_is_null(error, "i");
  if (!status && !x) status = dlsi_is_null(error, "x");
  if (!status && !B) status = dlsi_is_null(error, "B");
  if (status) return dlsi_at(__func__, status, error);
  const size_t D = (size_t)d;
  const int n = A->rows / d;
  int k = 0;
  p[0] = 0;
  for (int b = 0; b < n; b++) {
    for (int a = 0; a < n; a++) {
      const double *block = find_block(A, D, a, b);
      if (!block) continue;
      for (size_t j = 0; j < D; j++)
        memcpy(x + D * D * (size_t)k + D * j, block + j * (size_t)A->ld, D * sizeof *x);
      i[k++] = a;
    }
    p[b + 1] = k;
  }
  *B = (dls_blocks){d, n, p, i, x};
  return DLS_OK;
}

dls_status dls_blocks_to_dense(const dls_blocks *B, double *a, int ld, dls_error *error) {
  DLSI_DOOR;
  dls_status status = dlsi_check_blocks(B, error);
  if (!status && !a) status = dlsi_is_null(error, "a");
  if (!status && (ld < 1 || ld < B->d * B->n))
    status = dlsi_fail(error, DLS_E_SIZE, "ld", -1, ld, "must be at least %d x %d", B->d, B->n);
  if (status) return dlsi_at(__func__, status, error);
  const size_t D = (size_t)B->d, rows = D * (size_t)B->n, L = (size_t)ld;
  for (size_t j = 0; j < rows; j++)
    memset(a + j * L, 0, rows * sizeof *a);
  for (int b = 0; b < B->n; b++)
    for (int k = B->p[b]; k < B->p[b + 1]; k++)
      for (size_t e = 0; e < D * D; e++)
        a[D * (size_t)B->i[k] + e % D + (D * (size_t)b + e / D) * L] += B->x[D * D * (size_t)k + e];
  return DLS_OK;
}
