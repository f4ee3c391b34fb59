/*
 * equilibrate.c: A = R K C with diagonal matrices of powers of two that bring the largest entry of
 * each row and column near 1 (Ruiz, Rutherford Appleton Laboratory RAL-TR-2001-034).
 *
 *   (EQ1)  divide each row and column by the square root of its largest entry, five times
 *   (EQ2)  round R and C to powers of two, so that scaling is exact
 *
 * Cost: five passes over K. Cannot fail.
 */
#include <math.h>
#include <string.h>

#include "linear/equilibrate.h"

enum { sweeps = 5 };

/* Divides diagonal by sqrt(largest), where that is not 0. */
static void scale_shrink(double *diagonal, const double *largest, size_t n) {
  for (size_t i = 0; i < n; i++)
    if (largest[i] > 0) diagonal[i] /= sqrt(largest[i]);
}

void dlsi_find_scales(const dls_sparse *K, int symmetric, double *R, double *C, double *scratch) {
  const size_t n = (size_t)K->cols;
  double *rows = scratch, *cols = symmetric ? scratch : scratch + n;
  for (size_t i = 0; i < n; i++)
    R[i] = C[i] = 1;
  for (int sweep = 0; sweep < sweeps; sweep++) { /* (EQ1) */
    memset(scratch, 0, 2 * n * sizeof *scratch);
    for (int j = 0; j < K->cols; j++)
      for (int k = K->p[j]; k < K->p[j + 1]; k++) {
        const int i = K->i[k];
        if (symmetric && i < j) continue;
        const double a = fabs(R[i] * K->x[k] * C[j]);
        if (a > rows[i]) rows[i] = a;
        if (a > cols[j]) cols[j] = a;
      }
    scale_shrink(R, rows, n);
    if (symmetric)
      memcpy(C, R, n * sizeof *C);
    else
      scale_shrink(C, cols, n);
  }
  for (size_t i = 0; i < n; i++) { /* (EQ2) */
    R[i] = ldexp(1, ilogb(R[i]));
    C[i] = ldexp(1, ilogb(C[i]));
  }
}
