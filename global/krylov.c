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
 * A vector has n entries, of which a rank keeps its own rows, and k that all ranks have. No
 * restart: `most` is small, and a Newton step needs one digit. Memory: 2 `most` vectors of the own
 * rows.
 */
#include <float.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "global_internal.h"

enum { most_columns = 30 };

/* What a rank keeps of a vector. */
typedef struct basis {
  const dlsi_krylov *of;
  size_t own, size; /* rows; rows and k */
  double *V, *Z;
} basis;

static void basis_put(const basis *b, double *column, const double *whole) {
  memcpy(column, whole + b->of->spread.first, b->own * sizeof *column);
  memcpy(column + b->own, whole + b->of->n, (size_t)b->of->k * sizeof *column);
}

static void basis_take(const basis *b, const double *column, double *whole) {
  memcpy(whole + b->of->spread.first, column, b->own * sizeof *column);
  memcpy(whole + b->of->n, column + b->own, (size_t)b->of->k * sizeof *column);
}

static double basis_dot(const double *a, const double *b, size_t n) {
  double sum = 0;
  for (size_t i = 0; i < n; i++)
    sum += a[i] * b[i];
  return sum;
}

/* h := V^T w of the first `count` columns, and |w|^2 behind them. */
static void basis_products(const basis *b, int count, const double *w, double *h) {
  for (int j = 0; j <= count; j++)
    h[j] = basis_dot(j < count ? b->V + (size_t)j * b->size : w, w, b->own);
  if (b->of->spread.sum) b->of->spread.sum(b->of->spread.data, h, count + 1);
  for (int j = 0; j <= count; j++) {
    const double *v = j < count ? b->V + (size_t)j * b->size : w;
    h[j] += basis_dot(v + b->own, w + b->own, (size_t)b->of->k);
  }
}

/* (KR2) Returns |w|. */
static double basis_orthogonalise(const basis *b, int count, double *w, double *h) {
  double g[most_columns + 1];
  memset(h, 0, ((size_t)count + 1) * sizeof *h);
  for (int turn = 0; turn < 3; turn++) { /* the third one for the norm */
    basis_products(b, count, w, g);
    for (int j = 0; turn < 2 && j < count; j++) {
      const double *v = b->V + (size_t)j * b->size;
      h[j] += g[j];
      for (size_t i = 0; i < b->size; i++)
        w[i] -= g[j] * v[i];
    }
  }
  return sqrt(g[count]);
}

/* (KR4) from the triangle R and the turned right side. */
static void basis_solution(const basis *b, int count, double (*R)[most_columns + 1],
                           const double *right, double *whole) {
  double y[most_columns];
  double *sum = b->V; /* spent */
  for (int j = count - 1; j >= 0; j--) {
    y[j] = right[j];
    for (int i = j + 1; i < count; i++)
      y[j] -= R[i][j] * y[i];
    y[j] /= R[j][j];
  }
  memset(sum, 0, b->size * sizeof *sum);
  for (int j = 0; j < count; j++)
    for (size_t i = 0; i < b->size; i++)
      sum[i] += y[j] * b->Z[(size_t)j * b->size + i];
  basis_take(b, sum, whole);
  if (b->of->spread.gather) b->of->spread.gather(b->of->spread.data, whole);
}

dls_status dlsi_krylov_solve(const dlsi_krylov *of, double eta, double *b, double *z,
                             dls_error *error) {
  basis s = {
      .of = of, .own = (size_t)of->spread.rows, .size = (size_t)of->spread.rows + (size_t)of->k};
  double R[most_columns][most_columns + 1], turn[most_columns][2], right[most_columns + 1], none;
  dls_status status = DLS_OK;
  s.V = dlsi_alloc((2 * most_columns + 1) * (s.size + 1), sizeof *s.V);
  if (!s.V) return dlsi_no_memory(error);
  s.Z = s.V + (most_columns + 1) * s.size;
  basis_put(&s, s.V, b);
  right[0] = basis_orthogonalise(&s, 0, s.V, &none);
  const double start = right[0];
  int j = 0;
  for (size_t i = 0; i < s.size && start > 0; i++)
    s.V[i] /= start;
  while (!status && j < most_columns && fabs(right[j]) > eta * start) {
    double *w = s.V + (size_t)(j + 1) * s.size, *h = R[j];
    basis_take(&s, s.V + (size_t)j * s.size, b);
    status = of->precondition(of->data, b, z, error); /* (KR1) */
    if (status) break;
    basis_put(&s, s.Z + (size_t)j * s.size, z);
    of->apply(of->data, z, b);
    basis_put(&s, w, b);
    double next = basis_orthogonalise(&s, j + 1, w, h);
    for (int i = 0; i < j; i++) { /* (KR3) */
      const double a = h[i];
      h[i] = turn[i][0] * a + turn[i][1] * h[i + 1];
      h[i + 1] = turn[i][0] * h[i + 1] - turn[i][1] * a;
    }
    const double size = hypot(h[j], next);
    if (!(size > 0 && size <= DBL_MAX)) break;
    for (size_t i = 0; i < s.size && next > 0; i++)
      w[i] /= next;
    turn[j][0] = h[j] / size;
    turn[j][1] = next / size;
    h[j] = size;
    right[j + 1] = -turn[j][1] * right[j];
    right[j] *= turn[j][0];
    j++;
  }
  if (!status) basis_solution(&s, j, R, right, z);
  free(s.V);
  return status;
}
