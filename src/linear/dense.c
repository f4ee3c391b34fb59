/* cholesky.c: what Newton's method and ADMM share where W is symmetric and dense: A = L L^T. */
#include "linear/dense.h"
#include "linear/blas.h"

/* Tiles keep both triangles in the cache. */
int dlsi_is_symmetric(const double *A, size_t n) {
  enum { tile = 32 };
  for (size_t j0 = 0; j0 < n; j0 += tile)
    for (size_t i0 = j0; i0 < n; i0 += tile)
      for (size_t j = j0; j < j0 + tile && j < n; j++)
        for (size_t i = i0; i < i0 + tile && i < n; i++)
          if (A[i + n * j] != A[j + n * i]) return 0;
  return 1;
}

/* dpotrs, made for many x, takes three times as long in OpenBLAS */
static void solve(const char *trans, int n, const double *L, double *x) {
  const int one = 1;
  if (n) dtrsv_("L", trans, "N", &n, L, &n, x, &one, 1, 1, 1);
}

void dlsi_solve_lower(int n, const double *L, double *x) {
  solve("N", n, L, x);
}

void dlsi_solve_upper(int n, const double *L, double *x) {
  solve("T", n, L, x);
}
