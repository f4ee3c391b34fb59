/*
 * fclib_bodies.c: a global problem M v = H r + f, u = H^T v + w of rigid bodies, from its matrices.
 *
 *   M = diag(M_b), n x n blocks, n = 3 (d - 1);  M_b = L_b L_b^T
 *   H_cb := L_b^-1 H_cb,  W = H^T H,  q = w + H^T L^-1 f
 *
 * This form exists if M is block diagonal so, symmetric and positive definite, and no contact moves
 * more than two bodies. Cost: O(n^2) per body, O(n^2 d) per contact. Fails: no memory.
 */
#include <math.h>
#include <stdlib.h>

#include "files/fclib_bodies.h"

/* Gathers the blocks of M into L, n x n each, column-major. Returns 0 if M has other entries. */
static int bodies_of_mass(const dls_sparse *M, int n, double *L) {
  for (int j = 0; j < M->cols; j++)
    for (int k = M->p[j]; k < M->p[j + 1]; k++) {
      const int i = M->i[k];
      if (i / n == j / n)
        L[(size_t)(j / n * n + j % n) * (size_t)n + (size_t)(i % n)] += M->x[k];
      else if (M->x[k] != 0)
        return 0;
    }
  return 1;
}

/* L := chol(L), lower triangle. Returns 0 if L is not symmetric, or not positive definite. */
static int bodies_factor(int n, double *L) {
  for (int j = 0; j < n; j++)
    for (int i = 0; i < j; i++)
      if (L[i + n * j] != L[j + n * i]) return 0;
  for (int j = 0; j < n; j++) {
    for (int k = 0; k < j; k++)
      for (int i = j; i < n; i++)
        L[i + n * j] -= L[i + n * k] * L[j + n * k];
    if (!(L[j + n * j] > 0)) return 0;
    const double root = sqrt(L[j + n * j]);
    for (int i = j; i < n; i++)
      L[i + n * j] /= root;
  }
  return 1;
}

/* x := L^-1 x */
static void bodies_solve(int n, const double *L, double *x) {
  for (int j = 0; j < n; j++) {
    x[j] /= L[j + n * j];
    for (int i = j + 1; i < n; i++)
      x[i] -= L[i + n * j] * x[j];
  }
}

/* Adds column `from` of A to column `to` of the blocks of contact c. Returns 0 if that is a third
 * body. */
static int bodies_take(dlsi_fclib_bodies *B, int d, int c, const dls_sparse *A, int from, int to) {
  const int n = B->n;
  for (int k = A->p[from]; k < A->p[from + 1]; k++) {
    const int b = A->i[k] / n;
    if (A->x[k] == 0) continue;
    int side = 0;
    while (side < 2 && B->body[2 * c + side] >= 0 && B->body[2 * c + side] != b)
      side++;
    if (side == 2) return 0;
    B->body[2 * c + side] = b;
    B->H[(size_t)(n * d) * (size_t)(2 * c + side) + (size_t)(n * to + A->i[k] % n)] += A->x[k];
  }
  return 1;
}

/* Fills all of B except its memory. L: n n count zeros, scratch; f: n count, overwritten. Returns 0
 * if the problem is not one of rigid bodies. */
static int bodies_fill(dlsi_fclib_bodies *B, const dlsi_fclib_global *of, double *L, double *f) {
  const int d = of->d, n = B->n, nc = of->nc;
  if (!bodies_of_mass(&of->M, n, L)) return 0;
  for (int b = 0; b < B->count; b++) {
    double *Lb = L + (size_t)(n * n) * (size_t)b;
    if (!bodies_factor(n, Lb)) return 0;
    for (int i = 0; i < n; i++)
      f[n * b + i] = of->f[n * b + i];
    bodies_solve(n, Lb, f + n * b);
  }
  for (int c = 0; c < nc; c++) {
    B->body[2 * c] = B->body[2 * c + 1] = -1;
    if (!bodies_take(B, d, c, &of->HN, c, 0)) return 0;
    for (int i = 1; i < d; i++)
      if (!bodies_take(B, d, c, &of->HT, (d - 1) * c + i - 1, i)) return 0;
  }
  for (int k = 0; k < 2 * nc; k++) {
    const int b = B->body[k];
    for (int i = 0; i < d; i++) {
      double *h = B->H + (size_t)(n * d) * (size_t)k + (size_t)(n * i);
      double *q = &B->q[d * (k / 2) + i];
      if (k % 2 == 0) *q = of->w[d * (k / 2) + i];
      if (b < 0) continue;
      bodies_solve(n, L + (size_t)(n * n) * (size_t)b, h);
      for (int l = 0; l < n; l++)
        *q += h[l] * f[n * b + l];
    }
  }
  return 1;
}

dls_status dlsi_fclib_bodies_create(dlsi_fclib_bodies *out, const dlsi_fclib_global *of,
                                    dls_error *error) {
  const int n = 3 * (of->d - 1), count = of->M.cols / n;
  const size_t nc = (size_t)of->nc, d = (size_t)of->d, N = (size_t)n, bodies = (size_t)count;
  *out = (dlsi_fclib_bodies){.n = n, .count = count};
  if (of->M.cols % n || nc == 0) return DLS_OK;
  dlsi_fclib_bodies B = *out;
  double *L = calloc(N * bodies + bodies, N * sizeof *L);
  B.body = dlsi_alloc(2 * nc, sizeof *B.body);
  B.H = calloc(2 * nc, N * d * sizeof *B.H);
  B.q = dlsi_alloc(d * nc, sizeof *B.q);
  const int whole = L && B.body && B.H && B.q;
  if (whole && bodies_fill(&B, of, L, L + N * N * bodies))
    *out = B;
  else
    dlsi_fclib_bodies_free(&B);
  free(L);
  return whole ? DLS_OK : dlsi_no_memory(error);
}

void dlsi_fclib_bodies_free(dlsi_fclib_bodies *B) {
  free(B->body);
  free(B->H);
  free(B->q);
  *B = (dlsi_fclib_bodies){.body = NULL};
}
