/*
 * krylov.c: A z = b by flexible GMRES, for a preconditioner that may vary: Saad, SIAM J. Sci.
 * Comput. 14, 1993, 461-469.
 *
 *   (KR1)  z_j := M v_j,  w := A z_j
 *   (KR2)  w := w - V h,  h = V^T w, twice; v_j+1 := w / |w|
 *   (KR3)  Givens rotations keep the Hessenberg matrix of all h triangular; the last entry of the
 *          turned right side is the residual
 *   (KR4)  z := sum y_j z_j
 *
 * No restart: `most` is small, and a Newton step needs one digit. Memory: 2 `most` vectors.
 */
#include <float.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "global_internal.h"

enum { most_columns = 30 };

typedef struct basis {
  const dlsi_krylov *of;
  double *V, *Z; /* by columns of of->size */
} basis;

static double basis_dot(const double *a, const double *b, size_t n) {
  double sum = 0;
  for (size_t i = 0; i < n; i++)
    sum += a[i] * b[i];
  return sum;
}

/* h := V^T w of the first `count` columns, and |w|^2 behind them. */
static void basis_products(const basis *b, int count, const double *w, double *h) {
  const size_t size = b->of->size;
  for (int j = 0; j <= count; j++)
    h[j] = basis_dot(j < count ? b->V + (size_t)j * size : w, w, size);
  dlsi_join(b->of->ranks, DLSI_SUM, h, (size_t)count + 1);
}

/* (KR2) Returns |w|. */
static double basis_orthogonalise(const basis *b, int count, double *w, double *h) {
  double g[most_columns + 1];
  memset(h, 0, ((size_t)count + 1) * sizeof *h);
  for (int turn = 0; turn < 3; turn++) { /* the third one for the norm */
    basis_products(b, count, w, g);
    for (int j = 0; turn < 2 && j < count; j++) {
      const double *v = b->V + (size_t)j * b->of->size;
      h[j] += g[j];
      for (size_t i = 0; i < b->of->size; i++)
        w[i] -= g[j] * v[i];
    }
  }
  return sqrt(g[count]);
}

/* (KR4) from the triangle R and the turned right side. */
static void basis_solution(const basis *b, int count, double (*R)[most_columns + 1],
                           const double *right, double *z) {
  const size_t size = b->of->size;
  double y[most_columns];
  for (int j = count - 1; j >= 0; j--) {
    y[j] = right[j];
    for (int i = j + 1; i < count; i++)
      y[j] -= R[i][j] * y[i];
    y[j] /= R[j][j];
  }
  memset(z, 0, size * sizeof *z);
  for (int j = 0; j < count; j++)
    for (size_t i = 0; i < size; i++)
      z[i] += y[j] * b->Z[(size_t)j * size + i];
}

dls_status dlsi_krylov_solve(const dlsi_krylov *of, double eta, double *b, double *z,
                             dls_error *error) {
  const size_t size = of->size;
  basis s = {.of = of};
  double R[most_columns][most_columns + 1], turn[most_columns][2], right[most_columns + 1], none;
  s.V = dlsi_alloc((2 * most_columns + 1) * (size + 1), sizeof *s.V);
  dls_status status = s.V ? DLS_OK : dlsi_no_memory(error);
  status = dlsi_joined_status(of->ranks, status, error);
  if (status) {
    free(s.V);
    return status;
  }
  s.Z = s.V + (most_columns + 1) * size;
  memcpy(s.V, b, size * sizeof *b);
  right[0] = basis_orthogonalise(&s, 0, s.V, &none);
  const double start = right[0];
  int j = 0;
  for (size_t i = 0; i < size && start > 0; i++)
    s.V[i] /= start;
  while (!status && j < most_columns && fabs(right[j]) > eta * start) {
    double *w = s.V + (size_t)(j + 1) * size, *h = R[j], *to = s.Z + (size_t)j * size;
    memcpy(b, w - size, size * sizeof *b);
    status = of->precondition(of->data, b, to, error); /* (KR1) */
    if (status) break;
    of->apply(of->data, to, w);
    double next = basis_orthogonalise(&s, j + 1, w, h);
    for (int i = 0; i < j; i++) { /* (KR3) */
      const double a = h[i];
      h[i] = turn[i][0] * a + turn[i][1] * h[i + 1];
      h[i + 1] = turn[i][0] * h[i + 1] - turn[i][1] * a;
    }
    const double length = hypot(h[j], next);
    if (!(length > 0 && length <= DBL_MAX)) break;
    for (size_t i = 0; i < size && next > 0; i++)
      w[i] /= next;
    turn[j][0] = h[j] / length;
    turn[j][1] = next / length;
    h[j] = length;
    right[j + 1] = -turn[j][1] * right[j];
    right[j] *= turn[j][0];
    j++;
  }
  if (!status) basis_solution(&s, j, R, right, z);
  free(s.V);
  return status;
}
