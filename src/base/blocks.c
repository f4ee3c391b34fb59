/* blocks.c: dense matrices and matrices by blocks, from one to the other. */
#include <limits.h>
#include <string.h>

#include "base/base.h"

/* dense, square, finite, of d x d blocks */
static dls_status check_square(const dls_dense *A, int d, dls_error *error) {
  if (!A) return dlsi_is_null(error, "A");
  if (d != 2 && d != 3)
    return dlsi_fail(error, DLS_E_ARGUMENT, "d", -1, d, "is %d, must be 2 or 3", d);
  if (A->rows < 0 || A->rows % d)
    return dlsi_fail(error, DLS_E_SIZE, "A", -1, A->rows, "has %d rows, not n times %d", A->rows,
                     d);
  return dlsi_check_dense("A", A, A->rows, A->rows, error);
}

static int is_zero(int d, const double *a, size_t ld) {
  for (int j = 0; j < d; j++)
    for (int i = 0; i < d; i++)
      if (a[(size_t)i + (size_t)j * ld] != 0) return 0;
  return 1;
}

dls_status dls_blocks_count(const dls_dense *A, int d, int *count, dls_error *error) {
  const dls_status status = check_square(A, d, error);
  if (status) return dlsi_at(__func__, status, error);
  if (!count) return dlsi_at(__func__, dlsi_is_null(error, "count"), error);
  const size_t D = (size_t)d, n = (size_t)A->rows / D, ld = (size_t)A->ld;
  size_t found = 0;
  for (size_t b = 0; b < n; b++)
    for (size_t a = 0; a < n; a++)
      found += !is_zero(d, A->a + D * a + D * b * ld, ld);
  if (found > INT_MAX)
    return dlsi_at(__func__,
                   dlsi_fail(error, DLS_E_SIZE, "A", -1, (double)found, "has too many blocks"),
                   error);
  *count = (int)found;
  return DLS_OK;
}

dls_status dls_blocks_from_dense(const dls_dense *A, int d, int *p, int *i, double *x,
                                 dls_blocks *B, dls_error *error) {
  const dls_status status = check_square(A, d, error);
  if (status) return dlsi_at(__func__, status, error);
  if (!p) return dlsi_at(__func__, dlsi_is_null(error, "p"), error);
  if (!i) return dlsi_at(__func__, dlsi_is_null(error, "i"), error);
  if (!x) return dlsi_at(__func__, dlsi_is_null(error, "x"), error);
  if (!B) return dlsi_at(__func__, dlsi_is_null(error, "B"), error);
  const size_t D = (size_t)d, ld = (size_t)A->ld;
  const int n = A->rows / d;
  int k = 0;
  p[0] = 0;
  for (int b = 0; b < n; b++) {
    for (int a = 0; a < n; a++) {
      const double *block = A->a + D * (size_t)a + D * (size_t)b * ld;
      if (is_zero(d, block, ld)) continue;
      for (size_t j = 0; j < D; j++)
        memcpy(x + D * D * (size_t)k + D * j, block + j * ld, D * sizeof *x);
      i[k++] = a;
    }
    p[b + 1] = k;
  }
  *B = (dls_blocks){d, n, p, i, x};
  return DLS_OK;
}

dls_status dls_blocks_to_dense(const dls_blocks *B, double *a, int ld, dls_error *error) {
  const dls_status status = dlsi_check_blocks(B, error);
  if (status) return dlsi_at(__func__, status, error);
  const size_t D = (size_t)B->d, rows = D * (size_t)B->n, L = (size_t)ld;
  if (!a) return dlsi_at(__func__, dlsi_is_null(error, "a"), error);
  if (ld < 1 || L < rows)
    return dlsi_at(
        __func__,
        dlsi_fail(error, DLS_E_SIZE, "ld", -1, ld, "must be at least %d x %d", B->d, B->n), error);
  for (size_t j = 0; j < rows; j++)
    memset(a + j * L, 0, rows * sizeof *a);
  for (int b = 0; b < B->n; b++)
    for (int k = B->p[b]; k < B->p[b + 1]; k++)
      for (size_t j = 0; j < D; j++)
        for (size_t i = 0; i < D; i++)
          a[D * (size_t)B->i[k] + i + (D * (size_t)b + j) * L] +=
              B->x[D * D * (size_t)k + D * j + i];
  return DLS_OK;
}
