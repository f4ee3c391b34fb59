/* test_sparse_lu.c: small matrices by hand, one after the other in one workspace. */
#include "linear/sparse_lu.h"
#include "run.h"

#if WITH_MUMPS

static dlsi_sparse_lu *lu;

static void lu_begin(void) {
  ck_assert_int_eq(dlsi_sparse_lu_create(&lu, NULL), DLS_OK);
  ck_assert_int_eq(dlsi_sparse_lu_reserve(lu, 4, NULL), DLS_OK);
}

static void lu_end(void) {
  dlsi_sparse_lu_destroy(lu);
  dlsi_sparse_lu_destroy(NULL);
}

/* A x = b is solved to the answer; x holds b before. */
static void lu_expect(const dls_sparse *A, double *x, const double *answer) {
  ck_assert_int_eq(dlsi_sparse_lu_factor(lu, A, NULL), DLS_OK);
  ck_assert_int_eq(dlsi_sparse_lu_solve(lu, x, NULL), DLS_OK);
  double largest = 0; /* an entry that is 0 may be rounding of the others */
  for (int i = 0; i < A->cols; i++)
    largest = fmax(largest, fabs(answer[i]));
  for (int i = 0; i < A->cols; i++)
    ck_assert_double_le(fabs(x[i] - answer[i]), 4 * DBL_EPSILON * largest);
}

/* (4 0; 0 2), (0 4; 2 0), (0 2; 2 0), (4 1; 0 2): patterns of as many entries in other places. */
TEST(other_patterns) {
  static const int p[] = {0, 1, 2}, q[] = {0, 1, 3}, straight[] = {0, 1}, turned[] = {1, 0};
  static const int upper[] = {0, 0, 1};
  static const double large[] = {4, 2}, small[] = {2, 2}, x3[] = {4, 1, 2}, turned4[] = {2, 4};
  for (int turn = 0; turn < 2; turn++) {
    double b[4][2] = {{8, 6}, {8, 6}, {8, 6}, {8, 6}};
    lu_expect(&(dls_sparse){2, 2, p, straight, large}, b[0], (double[]){2, 3});
    lu_expect(&(dls_sparse){2, 2, p, turned, turned4}, b[1], (double[]){3, 2});
    lu_expect(&(dls_sparse){2, 2, p, turned, small}, b[2], (double[]){3, 4});
    lu_expect(&(dls_sparse){2, 2, q, upper, x3}, b[3], (double[]){1.25, 3});
  }
}

/* Columns that begin elsewhere, with rows the same: (1 1; 0 1) has rows 0, 0, 1, and so has the
 * matrix whose first column has two entries in row 0 and one in row 1, the second none. */
TEST(other_columns) {
  static const int p[] = {0, 1, 3}, q[] = {0, 3, 3}, i[] = {0, 0, 1};
  static const double x[] = {1, 1, 1};
  double b[] = {5, 2}, again[] = {5, 2};
  dls_error error;
  lu_expect(&(dls_sparse){2, 2, p, i, x}, b, (double[]){3, 2});
  ck_assert_int_eq(dlsi_sparse_lu_factor(lu, &(dls_sparse){2, 2, q, i, x}, &error), DLS_E_SINGULAR);
  ck_assert_str_eq(error.argument, "");
  ck_assert(error.index == -1 && error.value == 0);
  static const int nothing[] = {0, 0, 0};
  ck_assert_int_eq(dlsi_sparse_lu_factor(lu, &(dls_sparse){2, 2, nothing, i, x}, &error),
                   DLS_E_SINGULAR);
  lu_expect(&(dls_sparse){2, 2, p, i, x}, again, (double[]){3, 2});
}

/* Entries in one place add up; a smaller matrix, one of more entries, and a smaller one again. */
TEST(other_sizes) {
  static const int p[] = {0, 2}, i[] = {0, 0}, one[] = {0, 1}, four[] = {0, 1, 2, 3, 4};
  static const int five[] = {0, 2, 3, 4, 5}, rows[] = {3, 2, 1, 0}, more[] = {0, 3, 2, 1, 0};
  static const double x[] = {1, 3}, y[] = {1, 2, 4, 8}, z[] = {1, 1, 2, 4, 8};
  double a[] = {12}, b[] = {8, 8, 8, 8}, c[] = {10}, d[] = {8, 8, 8, 8}, e[] = {12};
  lu_expect(&(dls_sparse){1, 1, p, i, x}, a, (double[]){3});
  lu_expect(&(dls_sparse){4, 4, four, rows, y}, b, (double[]){8, 4, 2, 1});
  lu_expect(&(dls_sparse){1, 1, one, i, x}, c, (double[]){10});
  ck_assert_int_eq(dlsi_sparse_lu_reserve(lu, 5, NULL), DLS_OK);
  /* the first column (1, 0, 0, 1): 8 = x_0 + 8 x_3, 8 = x_0 */
  lu_expect(&(dls_sparse){4, 4, five, more, z}, d, (double[]){8, 4, 2, 0});
  lu_expect(&(dls_sparse){1, 1, p, i, x}, e, (double[]){3});
}

/* From the least normal number to the largest, and at both ends of the powers that are divided out:
 * A = a (1 2; 0 1), x = (1, 1) exactly. */
TEST(units) {
  static const double of[] = {0x1p-1022, 0x1p-1023, 0x1p-1040, 0x1p-900, 3,
                              0x1p999,   0x1p1000,  0x1p1001,  0x1p1021};
  static const int p[] = {0, 1, 3}, i[] = {0, 0, 1};
  for (int k = 0; k < 9; k++) {
    const double x[] = {of[k], 2 * of[k], of[k]};
    double b[] = {3 * of[k], of[k]};
    lu_expect(&(dls_sparse){2, 2, p, i, x}, b, (double[]){1, 1});
  }
}

/* Of 0 no power of two is divided out; the workspace serves afterwards. */
TEST(zero_is_singular) {
  static const int p[] = {0, 1, 2}, i[] = {0, 1};
  const double x[] = {0, 0}, y[] = {1, 4};
  double b[] = {3, 8};
  ck_assert_int_eq(dlsi_sparse_lu_factor(lu, &(dls_sparse){2, 2, p, i, x}, NULL), DLS_E_SINGULAR);
  lu_expect(&(dls_sparse){2, 2, p, i, y}, b, (double[]){3, 2});
}

/* Room that is there is kept; what failed is gone, and comes back. */
TEST(reserve) {
  malloc_fails_at(0);
  dls_status status = dlsi_sparse_lu_reserve(lu, 4, NULL);
  if (!status) status = dlsi_sparse_lu_reserve(lu, 1, NULL);
  long calls = malloc_calls();
  ck_assert(!status && calls == 0);
  for (int k = 1; k <= 3; k++) {
    malloc_fails_at(k);
    const dls_status failed = dlsi_sparse_lu_reserve(lu, 4 + (size_t)k, NULL);
    malloc_fails_at(0);
    status = dlsi_sparse_lu_reserve(lu, 2, NULL);
    calls = malloc_calls();
    const size_t bytes = malloc_bytes();
    ck_assert(failed == DLS_E_MEMORY && !status && calls == 3);
    ck_assert(bytes == 2 * (2 * sizeof(int) + sizeof(double)));
    static const int p[] = {0, 1, 2}, i[] = {1, 0};
    double b[] = {6, 6};
    lu_expect(&(dls_sparse){2, 2, p, i, (double[]){2, 3}}, b, (double[]){3, 2});
  }
}

int main(void) {
  return run_tests("sparse_lu", lu_begin, lu_end);
}

#endif
