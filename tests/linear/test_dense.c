/* test_dense.c: dense factors: Cholesky, LU if that is not possible, by their residuals. */
#include "cases.h"
#include "linear/dense.h"
#include "run.h"

enum { n_most = 12, columns = 3 };

/* Symmetric positive definite, symmetric and indefinite with the first pivot that fails at row
 * n / 2, unsymmetric; times 2^e. */
static void dense_matrix(int kind, int n, int e, double *A) {
  for (int j = 0; j < n; j++)
    for (int i = 0; i <= j; i++) {
      const double x = i == j ? (kind == 1 && i >= n / 2 ? -4 : 4) : 0.5 * uniform();
      A[i + n * j] = ldexp(x, e);
      A[j + n * i] = kind == 2 && i != j ? ldexp(0.5 * uniform(), e) : A[i + n * j];
    }
}

/* Solves A X = B and measures it, column by column for 2^7 A, too. */
TEST_EACH(factor_and_solve, 0, 3 * n_most) {
  const int kind = _i % 3, n = 1 + _i / 3 % n_most;
  double X[2][n_most * columns];
  for (int turn = 0; turn < 2; turn++) {
    const int e = turn ? 7 : 0;
    double A[n_most * n_most], LU[n_most * n_most], diagonal[n_most], B[n_most * columns];
    double sums[n_most], scratch[4 * n_most];
    int pivot[n_most], iwork[n_most];
    set_seed(77 + (uint64_t)_i);
    dense_matrix(kind, n, e, A);
    memcpy(LU, A, sizeof A);
    for (int k = 0; k < n * columns; k++)
      B[k] = X[turn][k] = uniform();
    ck_assert_int_eq(dlsi_is_symmetric(A, (size_t)n), kind < 2 || n == 1);
    dlsi_dense f = {.n = n, .A = LU, .pivot = pivot};
    ck_assert_int_eq(dlsi_dense_factor(&f, diagonal), 0);
    ck_assert_int_eq(f.cholesky, kind == 0 || (kind == 2 && n == 1));
    dlsi_dense_solve(&f, X[turn], n, turn ? 1 : columns);
    if (turn) /* column by column */
      for (int c = 1; c < columns; c++)
        dlsi_dense_solve(&f, X[turn] + c * n, n, 1);
    for (int c = 0; c < columns; c++)
      for (int i = 0; i < n; i++) {
        double left = -B[i + n * c];
        for (int j = 0; j < n; j++)
          left += A[i + n * j] * X[turn][j + n * c];
        ck_assert_msg(fabs(left) <= 1e-13, "kind %d, n = %d, (%d, %d): %g", kind, n, i, c, left);
      }
    double Z[n_most * n_most]; /* A Z = 1 */
    ck_assert_int_eq(dlsi_dense_inverse(&f, Z, NULL), 0);
    if (f.cholesky) dlsi_make_symmetric(Z, (size_t)n, 0);
    for (int c = 0; c < n; c++)
      for (int i = 0; i < n; i++) {
        double left = i == c ? -1 : 0;
        for (int j = 0; j < n; j++)
          left += A[i + n * j] * Z[j + n * c];
        ck_assert_double_le(fabs(left), 1e-13);
      }
    const double norm = dlsi_dense_norm(A, (size_t)n, 0, sums);
    const double rcond = dlsi_dense_rcond(&f, norm, scratch, iwork);
    ck_assert(rcond > 0.1 && rcond <= 1 + 1e-14);
  }
  for (int k = 0; k < n * columns; k++)
    ck_assert(fabs(X[0][k] - ldexp(X[1][k], 7)) <= 1e-13);
}

TEST(singular) {
  double A[4] = {1, 2, 2, 4}, diagonal[2];
  int pivot[2];
  dlsi_dense f = {.n = 2, .A = A, .pivot = pivot};
  ck_assert_int_eq(dlsi_dense_factor(&f, diagonal), 2);
}

/* Z L L^T = 1, in several blocks of columns */
TEST(inverse_of_many_rows) {
  enum { many = 150 };
  static double A[many * many], L[many * many], Z[many * many];
  set_seed(9);
  dense_matrix(0, many, 0, A);
  for (int j = 0; j < many; j++)
    A[j + many * j] = many;
  memcpy(L, A, sizeof A);
  dlsi_dense f = {.n = many, .A = L};
  ck_assert_int_eq(dlsi_dense_cholesky(&f), 0);
  ck_assert_int_eq(dlsi_dense_inverse(&f, Z, NULL), 0);
  dlsi_make_symmetric(Z, many, 0);
  for (int c = 0; c < many; c++)
    for (int i = 0; i < many; i++) {
      double left = i == c ? -1 : 0;
      for (int j = 0; j < many; j++)
        left += A[i + many * j] * Z[j + many * c];
      ck_assert_double_le(fabs(left), 1e-13);
    }
}

/* The largest column sum: 3, 14, 24 of the matrix whose lower triangle alone is read; 3, 212, 324
 * of the whole one. */
TEST(norm) {
  const double A[9] = {1, -2, 0, 200, 4, 8, 300, 8, -16};
  double sums[3];
  ck_assert(dlsi_dense_norm(A, 3, 1, sums) == 24);
  ck_assert(sums[0] == 3 && sums[1] == 14 && sums[2] == 24);
  ck_assert(dlsi_dense_norm(A, 3, 0, sums) == 324);
  ck_assert(sums[0] == 3 && sums[1] == 212 && sums[2] == 324);
}
