/*
 * equilibrate.c: A = R K C with diagonal matrices of powers of two that bring the largest entry of each row
 * and column near 1 (Ruiz, Rutherford Appleton Laboratory RAL-TR-2001-034): each is divided by the
 * square root of that entry, five times.
 */
#include <math.h>
#include <string.h>

#include "linear/equilibrate.h"

enum { sweeps = 5 };

/* diagonal /= sqrt(largest), where that is not 0 */
static void shrink(double *diagonal, const double *largest, size_t n) {
  for (size_t i = 0; i < n; i++)
    if (largest[i] > 0) diagonal[i] /= sqrt(largest[i]);
}

void dlsi_find_scales(const dls_sparse *K, int symmetric, double *R, double *C, double *room) {
  const size_t n = (size_t)K->cols;
  double *rows = room, *cols = symmetric ? room : room + n;
  for (size_t i = 0; i < n; i++)
    R[i] = C[i] = 1;
  for (int sweep = 0; sweep < sweeps; sweep++) {
    memset(room, 0, 2 * n * sizeof *room);
    for (int j = 0; j < K->cols; j++)
      for (int k = K->p[j]; k < K->p[j + 1]; k++) {
        const int i = K->i[k];
        if (symmetric && i < j) continue;
        const double a = fabs(R[i] * K->x[k] * C[j]);
        if (a > rows[i]) rows[i] = a;
        if (a > cols[j]) cols[j] = a;
      }
    shrink(R, rows, n);
    if (symmetric)
      memcpy(C, R, n * sizeof *C);
    else
      shrink(C, cols, n);
  }
  for (size_t i = 0; i < n; i++) {
    R[i] = ldexp(1, ilogb(R[i]));
    C[i] = ldexp(1, ilogb(C[i]));
  }
}
