/*
 * bound.c: a friction below which each q has exactly one solution (friction_unique of diagnose.h).
 *
 * W is the scaled matrix of diagnose.c. Let (r, u) and (r', u') be two solutions for the same q,
 *
 *   y = r_n - r'_n,  x = r_t - r'_t,  p = u_n - u'_n,  v = u_t - u'_t.
 *
 * (DG1) y_c p_c = -r_n u'_n - r'_n u_n <= 0
 * (DG2) x_c . v_c <= mu_c |y_c| |v_c|, for r_t . u_t = -mu r_n |u_t|, r_t . u'_t >= -mu r_n |u'_t|
 *        give x . v <= -mu (r_n - r'_n) (|u_t| - |u'_t|)
 *
 * With T = W_tt^-1, P = W_nt T, Q = T W_tn, S = W_nn - W_nt T W_tn:
 *
 * (DG3) x = T v - Q y,  p = S y + P v
 *
 * Take tau >= 1 times the sum of (DG1) and once that of (DG2), mu = max mu_c, and Cauchy-Schwarz:
 *
 *   mu |y| |v| >= tau y.p + x.v = tau y^T S y + v^T T v + y^T (P - Q^T + (tau - 1) P) v
 *              >= tau s |y|^2 + t |v|^2 - (g + (tau - 1) h) |y| |v|
 *
 *   s = smallest eigenvalue of the symmetric part of S,  g = |P - Q^T|_2 (0 for symmetric W)
 *   t = smallest eigenvalue of the symmetric part of T,  h = |P|_2
 *
 * and tau s |y|^2 + t |v|^2 >= 2 sqrt(tau s t) |y| |v|. So y = v = 0, hence x = 0, if mu is less
 * than
 *
 * (DG4) mu* = max over tau >= 1 of 2 sqrt(tau s t) - (tau - 1) h - g
 *          = 2 k - g            if h >= k = sqrt(s t)     (tau = 1)
 *          = h + k^2 / h - g    if h <  k                 (tau = (k/h)^2)
 *
 * provided s, t > 0. The same lines with the thresholds mu_c b_c, mu_c b'_c in place of mu_c
 * r_n, mu_c r'_n give |y| <= (mu / mu*) |b - b'|: the fixed point on the sliding threshold
 * contracts. Its step is a variational inequality of the operator diag(tau, 1) (W r + q), strongly
 * monotone by the case mu = 0 of the above, and so has one solution: the fixed point exists,
 * whatever q is.
 *
 * Lemke (2D, the form of delassus/lcp.h). A secondary ray gives dz != 0 that solves LCP(M, dz0 d),
 * d > 0, dz0 >= 0: a friction problem with q = dz0 (d_1, d_2) and -mu r_n <= r_t <= mu r_n + dz0
 * d_3, for which (DG1), (DG2) hold all the same. It has the solution r = 0, and so no other:
 * phi_2 = 0, and if dz0 > 0, phi_1 > 0, lambda_2 = 0, that is dz = 0. If dz0 = 0, some dz has
 * lambda_2 > 0 and dy the same lambda_1; by complementarity phi_1 = phi_2 = 0 at the start of the
 * ray, but there phi_1 + phi_2 = 2 mu r_n + d_3 z0 > 0. So there is no ray, and Lemke's method
 * ends at the solution.
 *
 * How sharp mu* is: for one contact in 2D with W_nn W_tt >= 2 W_nt^2 it is W_nn / |W_nt|, the exact
 * value, and never more. For many contacts it decreases as 1 / sqrt(condition number). Projected
 * Gauss-Seidel and Newton may fail below it: data/failures/c13 has mu = 2 < mu* = 2.83, and both
 * cycle. (Gauss-Seidel solved 3600 of 3600 random problems, mu = 0.99 mu*, nc <= 12.)
 *
 * Cost: eigenvalues of an m x m and of some smaller symmetric matrices, one inverse. What can
 * fail: s and t carry rounding errors of eps times the condition number, and so does mu*.
 */
#include <float.h>
#include <math.h>
#include <stdlib.h>

#include "facts/facts.h"
#include "linear/blas.h"
#include "linear/dense.h"
#include "linear/pieces.h"

enum { eigen_work = 34 }; /* dsyev: (block size 32 + 2) n doubles */

/* Fills A (m x m) with the scaled W, the normal rows and columns of all contacts first. */
static void bound_matrix(const dls_contact *problem, const double *scale, double *A) {
  const size_t d = (size_t)problem->d, nc = (size_t)problem->nc, m = d * nc;
  for (size_t e = 0; e < m * m; e++)
    A[e] = 0;
  for (size_t b = 0; b < nc; b++) {
    const dlsi_block_column blocks = dlsi_contact_column(problem, b);
    for (size_t j = 0; j < d; j++) {
      double *column = A + (j ? nc + (d - 1) * b + j - 1 : b) * m;
      for (size_t k = blocks.begin; k < blocks.end; k++) {
        const size_t a = dlsi_row(&blocks, k);
        const double *w = blocks.x + k * blocks.step + j * blocks.ld;
        for (size_t i = 0; i < d; i++)
          column[i ? nc + (d - 1) * a + i - 1 : a] += scale[a] * scale[b] * w[i];
      }
    }
  }
}

/* Finds the eigenvalues, ascending, of the symmetric part of X (n x n, leading dimension ld).
 * Returns 0 if an entry of it overflows or LAPACK did not converge. H: scratch, n x n. value: n.
 * work: scratch, 34 n. */
static int bound_eigenvalues(int n, const double *X, int ld, double *H, double *value,
                             double *work) {
  const size_t N = (size_t)n, L = (size_t)ld;
  for (size_t j = 0; j < N; j++)
    for (size_t i = j; i < N; i++)
      H[i + j * N] = 0.5 * X[i + j * L] + 0.5 * X[j + i * L];
  const int room = eigen_work * n;
  int info;
  for (size_t j = 0; j < N; j++) /* LAPACK would print */
    if (dlsi_first_not_finite(H + j + j * N, N - j) >= 0) return 0;
  dsyev_("N", "L", &n, H, &n, value, work, &room, &info, 1, 1);
  return info == 0;
}

/* Finds |X|_2, X being rows x cols, from X X^T. Returns 0 if LAPACK did not converge. */
static int bound_norm(int rows, int cols, const double *X, double *XXt, double *H, double *value,
                      double *work, double *norm) {
  const size_t entries = (size_t)rows * (size_t)(rows + cols);
  dlsi_gemm(dlsi_is_small(entries), 'N', 'T', rows, rows, cols, 1, X, rows, X, rows, 0, XXt, rows);
  const int ok = bound_eigenvalues(rows, XXt, rows, H, value, work);
  *norm = ok && value[rows - 1] > 0 ? sqrt(value[rows - 1]) : 0;
  return ok;
}

/* Returns mu* of (DG4), 0 if there is none. A: (W_nn W_nt; W_tn W_tt), m x m, overwritten. H, V:
 * scratch, m x m; V has room for T, P and Q: nt^2 + 2 nn nt < m^2. value: m. work: 34 m. */
static double bound_of(int nn, int nt, double *A, double *H, double *V, int *pivot, double *value,
                       double *work) {
  if (nt == 0) /* without tangents a positive definite W_nn is enough */
    return bound_eigenvalues(nn, A, nn, H, value, work) && value[0] > 0 ? INFINITY : 0;
  const int m = nn + nt;
  const size_t N = (size_t)nn, L = (size_t)nt, M = (size_t)m;
  double *Wnn = A, *Wtn = A + N, *Wnt = A + N * M, *Wtt = Wnt + N;
  double *T = V, *P = T + L * L, *Q = P + N * L;

  for (size_t j = 0; j < L; j++)
    for (size_t i = 0; i < L; i++) {
      H[i + j * L] = Wtt[i + j * M];
      T[i + j * L] = i == j;
    }
  dlsi_dense factors = {.n = nt, .A = H, .pivot = pivot};
  if (dlsi_dense_lu(&factors)) return 0;
  dlsi_dense_solve(&factors, T, nt, nt); /* (DG3) */
  const int alone = dlsi_is_small(M * M);
  dlsi_gemm(alone, 'N', 'N', nn, nt, nt, 1, Wnt, m, T, nt, 0, P, nn);
  dlsi_gemm(alone, 'N', 'N', nt, nn, nt, 1, T, nt, Wtn, m, 0, Q, nt);
  dlsi_gemm(alone, 'N', 'N', nn, nn, nt, -1, P, nn, Wtn, m, 1, Wnn, m); /* S */

  double g, h;
  if (!bound_eigenvalues(nn, Wnn, m, H, value, work)) return 0;
  const double s = value[0];
  if (!bound_eigenvalues(nt, T, nt, H, value, work)) return 0;
  const double t = value[0];
  if (!(s > 0) || !(t > 0)) return 0;
  double *XXt = A; /* nn x nn; A is not needed any more */
  if (!bound_norm(nn, nt, P, XXt, H, value, work, &h)) return 0;
  for (size_t j = 0; j < L; j++)
    for (size_t i = 0; i < N; i++)
      P[i + j * N] -= Q[j + i * L];
  if (!bound_norm(nn, nt, P, XXt, H, value, work, &g)) return 0;

  const double k = sqrt(s * t); /* (DG4) */
  const double bound = (h >= k ? 2 * k : h + k * (k / h)) - g;
  return bound > 0 ? bound : 0;
}

dls_status dlsi_unique_below(const dls_contact *problem, const double *scale, double *value,
                             double *friction) {
  const int nc = problem->nc, m = problem->d * nc;
  const size_t M = (size_t)m;
  double *A = dlsi_alloc(3 * M + eigen_work + 1, M * sizeof *A);
  int *pivot = dlsi_alloc(M, sizeof *pivot);
  dls_status status = DLS_E_MEMORY;
  if (A && pivot) {
    double *H = A + M * M, *V = H + M * M, *work = V + M * M;
    *friction = 0;
    bound_matrix(problem, scale, A);
    if (!bound_eigenvalues(m, A, m, H, value, work))
      value[0] = NAN;
    else if (value[0] > 4 * m * DBL_EPSILON * value[m - 1])
      *friction = bound_of(nc, m - nc, A, H, V, pivot, work + eigen_work * M, work);
    status = DLS_OK;
  }
  free(A);
  free(pivot);
  return status;
}
