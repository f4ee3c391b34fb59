/* test_schur.c: the Schur complement of small sparse matrices by hand: solves, halves, inverses,
 * measures and errors. */
#include "linear/schur.h"
#include "run.h"

#if WITH_MUMPS

/* K = (4 2 0 0; 2 5 2 0; 0 2 5 2; 0 0 2 5) = L L^T with L = (2; 1 2; 0 1 2; 0 0 1 2), all of it or
 * its lower triangle with 99 above, which is not to be read. K (1, 2, -1, 3) = (8, 10, 5, 13). */
enum { n = 4 };
static const int whole_p[] = {0, 2, 5, 8, 10}, whole_i[] = {0, 1, 0, 1, 2, 1, 2, 3, 2, 3};
static const double whole_x[] = {4, 2, 2, 5, 2, 2, 5, 2, 2, 5},
                    lower_x[] = {4, 2, 99, 5, 2, 99, 5, 2, 99, 5};
static const double answer[] = {1, 2, -1, 3}, load[] = {8, 10, 5, 13};

static dls_sparse schur_matrix(dls_factorization tag) {
  return (dls_sparse){n, n, whole_p, whole_i, tag == DLS_LU ? whole_x : lower_x};
}

static dlsi_schur *schur_new(const dls_sparse *Ks, dls_factorization tag, int count,
                             const int *keep) {
  dlsi_schur *work = NULL;
  ck_assert_int_eq(dlsi_schur_create(&work, Ks, tag, count, keep, NULL), DLS_OK);
  return work;
}

static void schur_expect(const double *x, const double *expected, int count) {
  for (int k = 0; k < count; k++)
    ck_assert_msg(fabs(x[k] - expected[k]) <= 1e-13, "%d: %g, not %g", k, x[k], expected[k]);
}

/* One right-hand side, then three, of a new factor again: nothing, two or all unknowns kept; MUMPS
 * wants one that is not. */
TEST_EACH(solves, 0, 9) {
  static const int keep[] = {1, 3}, all[] = {0, 1, 2, 3};
  const dls_factorization tag = (dls_factorization)(1 + _i % 3);
  const int count = _i / 3 == 2 ? tag == DLS_CHOLESKY ? n : n - 1 : 2 * (_i / 3);
  const dls_sparse Ks = schur_matrix(tag);
  dlsi_schur *work = schur_new(&Ks, tag, count, count > 2 ? all : keep);
  for (int turn = 0; turn < 2; turn++) {
    ck_assert_int_eq(dlsi_schur_factor(work, &Ks, NULL), DLS_OK);
    for (int nrhs = 1; nrhs <= 3; nrhs += 2) {
      double X[3 * n], expected[3 * n];
      for (int k = 0; k < nrhs * n; k++) {
        X[k] = (1 + k / n) * load[k % n];
        expected[k] = (1 + k / n) * answer[k % n];
      }
      ck_assert_int_eq(dlsi_schur_solve(work, X, nrhs, NULL), DLS_OK);
      schur_expect(X, expected, nrhs * n);
      ck_assert_int_eq(dlsi_schur_holds(work), 0);
    }
  }
  ck_assert(dlsi_schur_measured(work)->error < 4 * DBL_EPSILON);
  dlsi_schur_destroy(work);
  dlsi_schur_destroy(NULL);
}

/* condense: z = (K^-1 b)_c; expand: K^-1 (b + h), of another h as well where K is definite. A solve
 * and a factor end it. (K^-1)_cc comes from S. */
TEST_EACH(halves, 0, 3) {
  static const int keep[] = {1, 3};
  const dls_factorization tag = (dls_factorization)(1 + _i);
  const dls_sparse Ks = schur_matrix(tag);
  dlsi_schur *work = schur_new(&Ks, tag, 2, keep);
  ck_assert_int_eq(dlsi_schur_factor(work, &Ks, NULL), DLS_OK);
  double Z[4], K[n * n] = {0}, columns[n * n];
  for (int j = 0; j < n; j++)
    K[j * (n + 1)] = 1;
  memcpy(columns, K, sizeof K);
  ck_assert_int_eq(dlsi_schur_solve(work, columns, n, NULL), DLS_OK);
  ck_assert_int_eq(dlsi_schur_inverse(work, Z), DLS_OK);
  const double corner[] = {columns[1 + n], columns[3 + n], columns[1 + 3 * n], columns[3 + 3 * n]};
  schur_expect(Z, corner, 4);
  ck_assert_double_eq_tol(Z[3], 0.25, 1e-13); /* minor 64 of det K = 256 */
  if (tag != DLS_LU) ck_assert(Z[1] == Z[2]);
  for (int turn = 0; turn < 2; turn++) {
    double b[n], x[n], z[2];
    memcpy(b, load, sizeof b);
    ck_assert_int_eq(dlsi_schur_holds(work), 0);
    ck_assert_int_eq(dlsi_schur_condense(work, b, z, NULL), DLS_OK);
    ck_assert_int_eq(dlsi_schur_holds(work), 1);
    schur_expect(z, (double[]){answer[1], answer[3]}, 2);
    memcpy(x, b, sizeof x);
    const double h[] = {256, -256};
    ck_assert_int_eq(dlsi_schur_expand(work, h, x, NULL), DLS_OK);
    double expected[n];
    for (int i = 0; i < n; i++)
      expected[i] = answer[i] + 256 * (columns[i + n] - columns[i + 3 * n]);
    assert_near(x, expected, n, 1e-11);
    ck_assert_int_eq(dlsi_schur_holds(work), tag == DLS_CHOLESKY);
    if (tag == DLS_CHOLESKY) {
      ck_assert_int_eq(dlsi_schur_expand(work, (double[]){0, 0}, x, NULL), DLS_OK);
      schur_expect(x, answer, n);
      if (turn == 0) ck_assert_int_eq(dlsi_schur_factor(work, &Ks, NULL), DLS_OK);
    }
  }
  dlsi_schur_destroy(work);
}

/* Powers of two scale a diagonal K to 1: |A|_1 = 1 and |A^-1|_F = 2 of four unknowns. */
TEST_EACH(measures_of_a_diagonal, 0, 6) {
  static const int p[] = {0, 1, 2, 3, 4}, i[] = {0, 1, 2, 3}, keep[] = {2};
  static const double x[] = {4, 0x1p-40, 0x1p60, 1};
  const dls_factorization tag = (dls_factorization)(1 + _i / 2);
  const dls_sparse Ks = {n, n, p, i, x};
  dlsi_schur *work = schur_new(&Ks, tag, _i % 2, keep);
  ck_assert(dlsi_schur_measured(work)->rcond == 0 && dlsi_schur_measured(work)->error == 0);
  ck_assert_int_eq(dlsi_schur_factor(work, &Ks, NULL), DLS_OK);
  ck_assert(dlsi_schur_measured(work)->rcond == 0.5 && dlsi_schur_measured(work)->error == 0);
  double b[] = {8, 0x1p-40, 0x1p62, 7};
  ck_assert_int_eq(dlsi_schur_solve(work, b, 1, NULL), DLS_OK);
  const double expected[] = {2, 1, 4, 7};
  ck_assert_mem_eq(b, expected, sizeof b);
  if (_i % 2) {
    double Z;
    ck_assert_int_eq(dlsi_schur_inverse(work, &Z), DLS_OK);
    ck_assert(Z == 0x1p-60);
  }
  dlsi_schur_destroy(work);
}

/* K = (1 0 -.5; 0 1 -.5; -.5 -.5 1): |K|_1 = 2, of the last column, half of which stands above the
 * diagonal. 1 / (2 |K^-1|_F) with the mean of two |K^-1 v|^2, v of +-1 by chance, x_2 = 2 v_2 + v_0
 * + v_1, x_i = v_i + x_2 / 2. */
TEST_EACH(condition_by_hand, 0, 3) {
  static const int p[] = {0, 2, 4, 7}, i[] = {0, 2, 1, 2, 0, 1, 2};
  static const double x[] = {1, -0.5, 1, -0.5, -0.5, -0.5, 1};
  const dls_factorization tag = (dls_factorization)(1 + _i);
  const dls_sparse Ks = {3, 3, p, i, x};
  dlsi_schur *work = schur_new(&Ks, tag, 0, NULL);
  ck_assert_int_eq(dlsi_schur_factor(work, &Ks, NULL), DLS_OK);
  const double rcond = dlsi_schur_measured(work)->rcond;
  double squares[4], nearest = INFINITY;
  for (int v = 0; v < 4; v++) {
    const double v0 = v % 2 ? 1 : -1, v1 = v / 2 ? 1 : -1, x2 = 2 + v0 + v1;
    squares[v] = (v0 + x2 / 2) * (v0 + x2 / 2) + (v1 + x2 / 2) * (v1 + x2 / 2) + x2 * x2;
  }
  for (int k = 0; k < 16; k++)
    nearest = fmin(nearest, fabs(rcond - 0.5 / sqrt((squares[k / 4] + squares[k % 4]) / 2)));
  ck_assert_msg(nearest <= 1e-14, "%g: %g", rcond, nearest);
  ck_assert(dlsi_schur_measured(work)->error <= 2 * DBL_EPSILON);
  dlsi_schur_destroy(work);
}

/* Of a definite K: 8 bytes an entry of L; with it the largest update, and 8 + 16 bytes an entry of
 * K; s^3 / 3 operations for s columns without rows below, and b^3 for S^-1. (4 1; 1 4) with one
 * unknown kept has two supernodes: 1/3 + 1 + 1 for the first, 1/3 for the second. MUMPS tells
 * millions of bytes; what is added to these is 16 an entry and 8 b^2; S^-1 takes 2 b^3 by LU. */
TEST(foreseen_by_hand) {
  static const int p[] = {0, 2, 4}, i[] = {0, 1, 0, 1}, keep[] = {0, 1, 2, 3};
  static const double x[] = {4, 1, 1, 4};
  const dls_sparse two = {2, 2, p, i, x}, four = schur_matrix(DLS_CHOLESKY);
  dlsi_schur *work = schur_new(&two, DLS_CHOLESKY, 1, keep);
  const dlsi_schur_measures *of = dlsi_schur_measured(work);
  ck_assert(of->factor_bytes == 8 * 3 && of->bytes == 8 * 3 + 8 + 24 * 3);
  ck_assert_double_eq_tol(of->flops, 8. / 3 + 1, 1e-14);
  dlsi_schur_destroy(work);
  work = schur_new(&four, DLS_CHOLESKY, n, keep);
  of = dlsi_schur_measured(work);
  ck_assert(of->factor_bytes == 8 * 16 && of->bytes == 8 * 16 + 24 * 7);
  ck_assert_double_eq_tol(of->flops, 64. / 3 + 64, 1e-13);
  dlsi_schur_destroy(work);
  double flops[2][2];
  for (int lu = 0; lu < 2; lu++)
    for (int b = 0; b < 2; b++) {
      const dls_factorization tag = lu ? DLS_LU : DLS_LDLT;
      work = schur_new(&four, tag, 2 * b, keep);
      of = dlsi_schur_measured(work);
      ck_assert(fmod(of->bytes, 1e6) == 16 * (lu ? 10 : 7) + 8 * 4 * b);
      ck_assert(of->factor_bytes >= 8 * n && fmod(of->factor_bytes, 8) == 0);
      flops[lu][b] = of->flops;
      dlsi_schur_destroy(work);
    }
  ck_assert_double_lt(fabs(flops[0][1] - flops[0][0] - 8), 8);
  ck_assert_double_gt(flops[1][1] - flops[1][0], 4);
}

/* Another pattern: the first entry that differs is named, of a symmetric K below the diagonal
 * alone; -1 where entries are missing, with their number. */
TEST_EACH(patterns_are_compared, 0, 2) {
  const dls_factorization tag = _i ? DLS_LU : DLS_LDLT;
  const dls_sparse Ks = schur_matrix(tag);
  dlsi_schur *work = schur_new(&Ks, tag, 0, NULL);
  int p[n + 1], i[12];
  double x[12] = {0};
  dls_sparse other = {n, n, p, i, x};
  dls_error e;
  memcpy(p, whole_p, sizeof p);
  memcpy(i, whole_i, sizeof whole_i);
  ck_assert_int_eq(dlsi_schur_same(work, &other, NULL), DLS_OK);
  i[4] = 3;
  expect_error(dlsi_schur_same(work, &other, &e), &e, DLS_E_ARGUMENT, "", "Ks", 4);
  ck_assert(e.value == 3);
  i[4] = 2;
  i[5] = 0; /* above the diagonal */
  const dls_status above = dlsi_schur_same(work, &other, &e);
  ck_assert_int_eq(above, _i ? DLS_E_ARGUMENT : DLS_OK);
  if (_i) ck_assert(e.index == 5 && e.value == 0);
  i[5] = 1;
  p[2] = 4; /* the third column begins with row 2, which stood in the second */
  expect_error(dlsi_schur_same(work, &other, &e), &e, DLS_E_ARGUMENT, "", "Ks", 4);
  ck_assert(e.value == 2);
  p[2] = 5;
  p[4] = 9; /* the last entry is missing */
  expect_error(dlsi_schur_same(work, &other, &e), &e, DLS_E_ARGUMENT, "", "Ks", -1);
  ck_assert(e.value == (_i ? 9 : 6));
  ck_assert_ptr_nonnull(strstr(e.message, _i ? "has 9 entries that are read, of 10 in create"
                                             : "has 6 entries that are read, of 7 in create"));
  p[4] = 11; /* there is one more */
  i[10] = 3;
  expect_error(dlsi_schur_same(work, &other, &e), &e, DLS_E_ARGUMENT, "", "Ks", 10);
  ck_assert(e.value == 3);
  dlsi_schur_destroy(work);
}

/* Unknown 0 tied to another one by (1 1; 1 1): nothing is left of the latter in S, whose pivot is
 * 0, be it the first or the second one kept. */
TEST_EACH(zero_in_the_complement, 0, 4) {
  static const int keep[] = {1, 2};
  const dls_factorization tag = _i / 2 ? DLS_LU : DLS_LDLT;
  const int tied = 1 + _i % 2;
  const int p[] = {0, 2, tied == 1 ? 4 : 3, 5}, straight[] = {0, 1, 0, 1, 2},
            crossed[] = {0, 2, 1, 0, 2};
  static const double x[] = {1, 1, 1, 1, 1};
  const dls_sparse Ks = {3, 3, p, tied == 1 ? straight : crossed, x};
  dlsi_schur *work = schur_new(&Ks, tag, 2, keep);
  dls_error e;
  expect_error(dlsi_schur_factor(work, &Ks, &e), &e, DLS_E_SINGULAR, "", "Ks", tied);
  ck_assert(e.value == 0);
  dlsi_schur_destroy(work);
}

/* 2 I beside (1 1; 1 1 + 2 eps), which is as good as singular: named is where |A^-1 v| is largest,
 * with the condition. */
TEST_EACH(nearly_singular, 0, 3) {
  static const int p[] = {0, 1, 2, 4, 6}, i[] = {0, 1, 2, 3, 2, 3};
  static const double x[] = {2, 2, 1, 1, 1, 1 + 2 * DBL_EPSILON};
  const dls_factorization tag = (dls_factorization)(1 + _i);
  const dls_sparse Ks = {n, n, p, i, x};
  dlsi_schur *work = schur_new(&Ks, tag, 0, NULL);
  dls_error e = {0};
  ck_assert_int_eq(dlsi_schur_factor(work, &Ks, &e), DLS_E_SINGULAR);
  ck_assert_str_eq(e.argument, "Ks");
  ck_assert_msg(e.index == 2 || e.index == 3, "%lld", e.index);
  ck_assert(e.value == dlsi_schur_measured(work)->rcond);
  ck_assert_double_lt(e.value, 2 * DBL_EPSILON);
  dlsi_schur_destroy(work);
}

/* K = (4 6; 6 5), of which MUMPS is not asked: the pivot 5 - 36 / 4 of unknown 1, which stands last
 * where it is kept, in units of the scaled K: between a quarter and four times -1. */
TEST_EACH(what_is_not_definite, 0, 2) {
  static const int p[] = {0, 2, 4}, i[] = {0, 1, 1, 1};
  static const double x[] = {4, 6, 3, 2}, huge[] = {1, 0, 1.5e308, 1.5e308};
  dls_sparse Ks = {2, 2, p, i, x};
  dlsi_schur *work = schur_new(&Ks, DLS_CHOLESKY, _i, (int[]){1});
  dls_error e;
  ck_assert_int_eq(dlsi_schur_factor(work, &Ks, &e), DLS_E_NOT_POSITIVE_DEFINITE);
  if (_i) ck_assert_int_eq(e.index, 1);
  ck_assert_msg(e.value <= -0.25 && e.value >= -4, "%g", e.value);
  Ks.x = huge; /* entries that add up to Inf as they stand, but not in the units of K */
  ck_assert_int_eq(dlsi_schur_factor(work, &Ks, NULL), DLS_OK);
  dlsi_schur_destroy(work);
}

#endif
