/* test_factor.c: the back-ends of a reduction by hand: parts, scaling, conditions, estimates and
 * errors. */
#include "reduction/reduction_internal.h"
#include "run.h"
#include "stiffness.h"

static stiffness S;

static dlsi_factor *factor_new(void) {
  dlsi_factor *factor = NULL;
  ck_assert_int_eq(dlsi_factor_create(&factor, &S.model, 0, NULL, NULL), DLS_OK);
  return factor;
}

/* The factor of S, which must be regular. */
static dlsi_factor *factored(void) {
  dlsi_factor *factor = factor_new();
  ck_assert_int_eq(dlsi_factor_numeric(factor, &S.model, NULL), DLS_OK);
  return factor;
}

static void expect_ints(const int *found, const int *expected, int n) {
  for (int k = 0; k < n; k++)
    ck_assert_msg(found[k] == expected[k], "%d: %d, not %d", k, found[k], expected[k]);
}

/* ---- parts ----------------------------------------------------------------------------------- */

/* 8 unknowns, tied (5, 3), (4, 1), (6, 4), (3, 0), of which some in the upper triangle alone: parts
 * {0, 3, 5}, {1, 4, 6}, {2}, {7}. */
static void make_parts(dls_factorization factorization, int is_sparse) {
  double rows[64] = {0};
  for (int k = 0; k < 8; k++)
    rows[9 * k] = k + 1;
  rows[5 * 8 + 3] = rows[4 + 8] = rows[6 * 8 + 4] = rows[3] = 0.5;
  stiffness_fill(&S, 8, rows, factorization, is_sparse);
}

TEST(parts_of_a_graph) {
  make_parts(DLS_LU, 1);
  dlsi_factor *factor = factor_new();
  ck_assert(factor->n == 8 && factor->parts == 4 && factor->largest == 3 && !factor->schur);
  expect_ints(factor->first, (int[]){0, 3, 6, 7, 8}, 5);
  expect_ints(factor->unknown, (int[]){0, 3, 5, 1, 4, 6, 2, 7}, 8);
  expect_ints(factor->place, (int[]){0, 3, 6, 1, 4, 2, 5, 7}, 8);
  const size_t start[] = {0, 9, 18, 19};
  ck_assert_mem_eq(factor->start, start, sizeof start);
  ck_assert(factor->entries == 20 && factor->symmetric == 0 && factor->scratch == 0);
  dlsi_factor_destroy(factor);
  dlsi_factor_destroy(NULL);
}

/* 8 s^2 bytes and 2 s^3 / 3 operations, half of it for Cholesky, of each part; nothing of a host's
 * solver, bytes alone of a flexibility. */
TEST_EACH(parts_are_foreseen, 0, 6) {
  const int dense = _i % 2;
  const dls_factorization tag = (dls_factorization)(1 + _i / 2 % 3);
  make_parts(tag, !dense);
  dlsi_factor *factor = factor_new();
  dls_reduction_info info = {.flops = 7, .bytes = 7};
  dlsi_factor_estimate(factor, &info);
  const double cubes = dense ? 8 * 8 * 8 : 27 + 27 + 1 + 1;
  ck_assert(info.factor_bytes == 8 * (dense ? 64 : 20) && info.bytes == info.factor_bytes);
  ck_assert_double_eq_tol(info.flops, (tag == DLS_CHOLESKY ? 1 : 2) * cubes / 3, 1e-12);
  ck_assert(factor->symmetric == (tag != DLS_LU) && factor->kept == 0 && factor->scratch == 0);
  dlsi_factor_destroy(factor);
  for (int host = 0; host < 2; host++) {
    S.model.operator_kind = host ? DLS_HOST_SOLVER : DLS_FLEXIBILITY;
    factor = factor_new();
    info.flops = 7;
    dlsi_factor_estimate(factor, &info);
    ck_assert(info.flops == 0 && info.bytes == (host ? 0 : 512));
    ck_assert(factor->symmetric == 0 && factor->scratch == (host ? 0 : 1));
    expect_ints(factor->unknown, (int[]){0, 1, 2, 3, 4, 5, 6, 7}, 8);
    expect_ints(factor->place, factor->unknown, 8);
    expect_ints(factor->first, (int[]){0, 8}, 2);
    dlsi_factor_destroy(factor);
  }
}

/* A chain of `links` unknowns, (2 -1; -1 2 ..), and single ones. */
static void factor_chain(int links, int singles, dls_factorization factorization) {
  const int n = links + singles;
  int e = 0;
  memset(&S, 0, sizeof S);
  for (int j = 0; j < n; j++) {
    S.p[j] = e;
    S.i[e] = j;
    S.x[e++] = 2;
    if (j + 1 < links) {
      S.i[e] = j + 1;
      S.x[e++] = -1;
    }
    if (j > 0 && j < links && factorization == DLS_LU) {
      S.i[e] = j - 1;
      S.x[e++] = -1;
    }
  }
  S.p[n] = e;
  S.model = (dls_model){.d = 2,
                        .n = n,
                        .operator_kind = DLS_STIFFNESS_SPARSE,
                        .factorization = factorization,
                        .Ks = {n, n, S.p, S.i, S.x}};
}

/* Parts of up to 250 unknowns are dense, of up to 25 where K is definite and has at most 4. */
TEST_EACH(small_parts_are_dense, 0, 11) {
  static const struct {
    dls_factorization tag;
    int links, singles, dense;
  } at[] = {{DLS_CHOLESKY, 25, 0, 1},  {DLS_CHOLESKY, 26, 0, 0}, {DLS_CHOLESKY, 26, 3, 0},
            {DLS_CHOLESKY, 25, 3, 1},  {DLS_CHOLESKY, 26, 4, 1}, {DLS_CHOLESKY, 250, 4, 1},
            {DLS_CHOLESKY, 251, 4, 0}, {DLS_LDLT, 250, 0, 1},    {DLS_LDLT, 251, 0, 0},
            {DLS_LU, 250, 0, 1},       {DLS_LU, 251, 0, 0}};
  factor_chain(at[_i].links, at[_i].singles, at[_i].tag);
  const int keep[] = {1, 3};
  dlsi_factor *factor = NULL;
  ck_assert_int_eq(dlsi_factor_create(&factor, &S.model, 2, keep, NULL), DLS_OK);
  const int dense = at[_i].dense || !dlsi_schur_available();
  ck_assert_int_eq(factor->schur == NULL, dense);
  ck_assert_int_eq(factor->kept, dense ? 0 : 2);
  ck_assert_int_eq(factor->parts, dense ? 1 + at[_i].singles : 1);
  ck_assert_int_eq(factor->largest, dense ? at[_i].links : S.model.n);
  ck_assert_int_eq(factor->first[factor->parts], S.model.n);
  if (!dense) {
    const dlsi_schur_measures *of = dlsi_schur_measured(factor->schur);
    dls_reduction_info info;
    dlsi_factor_estimate(factor, &info);
    ck_assert(info.factor_bytes == of->factor_bytes + 8 * 2 * 2);
    ck_assert(info.bytes == of->bytes && info.flops == of->flops);
    for (int k = 0; k < S.model.n; k++)
      ck_assert(factor->unknown[k] == k && factor->place[k] == k);
  }
  dlsi_factor_destroy(factor);
}

/* Another pattern may not tie two parts: the entry that does is named, of either triangle. */
TEST_EACH(parts_stay_apart, 0, 2) {
  make_parts(DLS_LU, 1);
  dlsi_factor *factor = factor_new();
  dls_error e;
  ck_assert_int_eq(dlsi_factor_same(factor, &S.model, NULL), DLS_OK);
  const int column = _i ? 6 : 0, row = _i ? 2 : 1, at = S.p[column] + 1, old = S.i[at];
  S.i[at] = row;
  expect_error(dlsi_factor_same(factor, &S.model, &e), &e, DLS_E_ARGUMENT, "", "Ks", at);
  ck_assert(e.value == row);
  S.i[at] = old;
  S.model.operator_kind = DLS_STIFFNESS_DENSE;
  ck_assert_int_eq(dlsi_factor_same(factor, &S.model, NULL), DLS_OK);
  dlsi_factor_destroy(factor);
  factor_chain(1, 2, DLS_LU); /* as many parts as unknowns */
  factor = factor_new();
  ck_assert_int_eq(dlsi_factor_same(factor, &S.model, NULL), DLS_OK);
  dlsi_factor_destroy(factor);
}

/* ---- scaling --------------------------------------------------------------------------------- */

/* 1 / sqrt(k_ii) down to a power of two: 8 becomes 2, 2^-3 becomes 2, 4 becomes 1; 2^-1073 and
 * 2^1001 as well, with |e| / 2. */
TEST_EACH(scaled_diagonals, 0, 2) {
  const double k[] = {8, 0x1p-3, 4, 1, 0x1p-1073, 0x1p1001, 3};
  const double scale[] = {0x1p-1, 0x1p2, 0x1p-1, 1, 0x1p537, 0x1p-500, 1};
  double rows[49] = {0};
  for (int i = 0; i < 7; i++)
    rows[8 * i] = k[i];
  stiffness_fill(&S, 7, rows, DLS_CHOLESKY, _i);
  dlsi_factor *factor = factored();
  for (int i = 0; i < 7; i++) {
    ck_assert_msg(factor->row[i] == scale[i] && factor->col[i] == scale[i], "%d: %g", i,
                  factor->row[i]);
    const double *L = factor->A + (_i ? (size_t)i : (size_t)(8 * i));
    ck_assert_double_eq_tol(*L * *L, k[i] * scale[i] * scale[i], 1e-15);
  }
  dlsi_factor_destroy(factor);
}

/* The largest entry of each row, then of each column comes into [1, 2): of (0 8; 3 1) rows by 1/8,
 * 1/2. Powers beyond 2^1000 are cut off: 2^-1060 takes 2^1000, 2^60, and 2^1010 2^-1000, 2^-10. */
TEST(scaled_rows_and_columns) {
  stiffness_fill(&S, 2, (double[]){0, 8, 3, 1}, DLS_LU, 0);
  dlsi_factor *factor = factored();
  ck_assert(factor->row[0] == 0.125 && factor->row[1] == 0.5);
  ck_assert(factor->col[0] == 1 && factor->col[1] == 1);
  dlsi_factor_destroy(factor);
  stiffness_fill(&S, 2, (double[]){4, 1, 4, 0.25}, DLS_LU, 1);
  factor = factored();
  ck_assert(factor->row[0] == 0.25 && factor->row[1] == 0.25);
  ck_assert(factor->col[0] == 1 && factor->col[1] == 4);
  dlsi_factor_destroy(factor);
  const double k[] = {0x1p-1060, 0x1p1010, 0x1p-1001, 0x1p1001, 0x1p-1000, 0x1p1000};
  const double row[] = {0x1p1000, 0x1p-1000, 0x1p1000, 0x1p-1000, 0x1p1000, 0x1p-1000};
  const double col[] = {0x1p60, 0x1p-10, 2, 0.5, 1, 1};
  double rows[36] = {0};
  for (int i = 0; i < 6; i++)
    rows[7 * i] = k[i];
  stiffness_fill(&S, 6, rows, DLS_LU, 0);
  factor = factored();
  for (int i = 0; i < 6; i++)
    ck_assert_msg(factor->row[i] == row[i] && factor->col[i] == col[i], "%d: %g", i,
                  factor->row[i]);
  double x[] = {0x1p-1060, 0x1p1011, 3 * 0x1p-1001, 0, 0x1p-998, 0x1p1000};
  ck_assert_int_eq(dlsi_factor_solve(factor, 0, x, 1, NULL, NULL), DLS_OK);
  const double expected[] = {1, 2, 3, 0, 4, 1};
  ck_assert_mem_eq(x, expected, sizeof x);
  dlsi_factor_destroy(factor);
}

/* K = (4 2 0; 2 5 2; 0 2 5) = L L^T with L = (2; 1 2; 0 1 2): K (1, 2, -1)^T = (8, 10, -1)^T. Of a
 * symmetric K the triangle above the diagonal is not read. Unsymmetric: (4 2 0; 0 5 2; 0 2 5) times
 * the same is (8, 8, -1). */
TEST_EACH(solves_by_hand, 0, 6) {
  const dls_factorization tag = (dls_factorization)(1 + _i / 2);
  double rows[] = {4, 2, 0, 2, 5, 2, 0, 2, 5};
  if (tag == DLS_LU)
    rows[3] = 0;
  else
    rows[1] = rows[2] = rows[5] = 99;
  stiffness_fill(&S, 3, rows, tag, _i % 2);
  dlsi_factor *factor = factored();
  double X[] = {8, tag == DLS_LU ? 8 : 10, -1, 16, tag == DLS_LU ? 16 : 20, -2};
  ck_assert_int_eq(dlsi_factor_solve(factor, 0, X, 2, NULL, NULL), DLS_OK);
  const double expected[] = {1, 2, -1, 2, 4, -2};
  assert_near(X, expected, 6, 1e-14);
  dlsi_factor_destroy(factor);
}

/* ---- conditions ------------------------------------------------------------------------------ */

/* Unknown 1 + (1 1; 1 1 + d) + unknown 2^4: of the pair 1 / (|A|_1 |A^-1|_1) = d / (2 + d)^2. */
static void make_pair(double d, dls_factorization tag, int is_sparse) {
  double rows[] = {1, 0, 0, 0, 0, 1, 1, 0, 0, 1, 1, 0, 0, 0, 0, 16};
  rows[10] = 1 + d;
  stiffness_fill(&S, 4, rows, tag, is_sparse);
}

/* d / 4 >= 10 eps is regular; LAPACK, which sees K as a whole, estimates d / 2. The condition is
 * that of the worst part. Below, the smallest pivot is
 * reported: d, of the third unknown; Cholesky's is its square. */
TEST_EACH(conditions_at_the_limit, 0, 4) {
  const dls_factorization tag = _i / 2 ? DLS_LU : DLS_CHOLESKY;
  const double part = _i % 2 ? 1 : 0.5;
  make_pair(part * 42 * DBL_EPSILON, tag, _i % 2);
  dlsi_factor *factor = factored();
  ck_assert_double_eq_tol(factor->rcond / DBL_EPSILON, 10.5, 1e-12);
  make_pair(0x1p-20, tag, _i % 2);
  ck_assert_int_eq(dlsi_factor_numeric(factor, &S.model, NULL), DLS_OK);
  ck_assert_double_eq_tol(factor->rcond * part, 0x1p-22, 0x1p-40);
  make_pair(part * 38 * DBL_EPSILON, tag, _i % 2);
  dls_error e;
  expect_error(dlsi_factor_numeric(factor, &S.model, &e), &e, DLS_E_SINGULAR, "",
               _i % 2 ? "Ks" : "K", 2);
  ck_assert_double_eq_tol(e.value / DBL_EPSILON, part * 38, 1e-12);
  ck_assert_ptr_nonnull(strstr(e.message, "(scaled), condition 4.74e+14; "));
  make_pair(2, tag, _i % 2); /* in the same workspace */
  ck_assert_int_eq(dlsi_factor_numeric(factor, &S.model, NULL), DLS_OK);
  ck_assert_double_gt(factor->rcond, 0.05);
  dlsi_factor_destroy(factor);
  make_pair(-1, DLS_LU, 0);
  S.model.operator_kind = DLS_FLEXIBILITY; /* is not factored: no condition */
  factor = factored();
  ck_assert(factor->rcond == 0);
  dlsi_factor_destroy(factor);
}

/* What has no factor: rows, columns and pivots of 0 have the value 0; a pivot < 0 its own, a
 * diagonal entry < 0 the value -1. */
TEST_EACH(pivots_are_told, 0, 8) {
  static const struct {
    double rows[9];
    dls_factorization tag;
    dls_status status;
    int index;
    double value;
  } at[] = {
      {{1, 0, 0, 0, 0, 0, 2, 3, 1}, DLS_LU, DLS_E_SINGULAR, 1, 0},
      {{1, 0, 2, 1, 0, 3, 0, 0, 1}, DLS_LU, DLS_E_SINGULAR, 1, 0},
      {{1, 1, 0, 0, 1, 1, 1, 2, 1}, DLS_LU, DLS_E_SINGULAR, 2, 0},
      {{1, 1, 0, 1, 1, 0, 0, 0, 1}, DLS_CHOLESKY, DLS_E_NOT_POSITIVE_DEFINITE, 1, 0},
      {{1, 2, 0, 2, 1, 0, 0, 0, 1}, DLS_CHOLESKY, DLS_E_NOT_POSITIVE_DEFINITE, 1, -3},
      {{1, 0, 1, 0, 0, 0, 1, 0, 2}, DLS_CHOLESKY, DLS_E_NOT_POSITIVE_DEFINITE, 1, 0},
      {{1, 1, 0, 1, 0, 0, 0, 0, 1}, DLS_CHOLESKY, DLS_E_NOT_POSITIVE_DEFINITE, 1, 0},
      {{1, 0, 1, 0, 2, 0, 1, 0, -4}, DLS_CHOLESKY, DLS_E_NOT_POSITIVE_DEFINITE, 2, -1},
  };
  stiffness_fill(&S, 3, at[_i].rows, at[_i].tag, 0);
  dlsi_factor *factor = factor_new();
  dls_error e;
  expect_error(dlsi_factor_numeric(factor, &S.model, &e), &e, at[_i].status, "", "K", at[_i].index);
  ck_assert_msg(e.value == at[_i].value, "%g", e.value);
  if (at[_i].tag == DLS_LU) ck_assert_ptr_nonnull(strstr(e.message, "condition inf; "));
  dlsi_factor_destroy(factor);
}

/* Entries that add up to Inf are named by their column, here the last one of the second part, or
 * the first of all. */
TEST_EACH(sums_that_overflow, 0, 2) {
  const int column = _i ? 0 : 6;
  make_parts(DLS_LU, 1);
  dlsi_factor *factor = factor_new();
  for (int e = S.p[column]; e < S.p[column + 1]; e++)
    S.x[e] = 1.5e308;
  dls_error e;
  expect_error(dlsi_factor_numeric(factor, &S.model, &e), &e, DLS_E_NOT_FINITE, "", "Ks", column);
  ck_assert(e.value > DBL_MAX);
  dlsi_factor_destroy(factor);
}

/* ---- the host's solver, memory --------------------------------------------------------------- */

/* X := 2 X, but for the entry that `user` tells; answers *user where that is negative. */
static int host_doubles(void *user, double *X, int n, int nrhs) {
  const int bad = *(int *)user;
  for (int k = 0; k < n * nrhs; k++)
    X[k] = k == bad ? (double)NAN : 2 * X[k];
  return bad < 0 ? bad : 0;
}

TEST(host_answers) {
  make_parts(DLS_LU, 0);
  S.model.operator_kind = DLS_HOST_SOLVER;
  S.model.solve = host_doubles;
  int bad = 99;
  S.model.user = &bad;
  dlsi_factor *factor = factored();
  ck_assert(factor->rcond == 0);
  double X[16] = {1, 2};
  X[15] = 3;
  ck_assert_int_eq(dlsi_factor_solve(factor, 0, X, 2, NULL, NULL), DLS_OK);
  ck_assert(X[0] == 2 && X[1] == 4 && X[15] == 6);
  dls_error e;
  bad = 13; /* the sixth unknown of the second right-hand side */
  expect_error(dlsi_factor_solve(factor, 0, X, 2, NULL, &e), &e, DLS_E_CALLBACK, "", "solve", 5);
  ck_assert(e.value != e.value);
  bad = 0;
  expect_error(dlsi_factor_solve(factor, 0, X, 2, NULL, &e), &e, DLS_E_CALLBACK, "", "solve", 0);
  bad = -4;
  expect_error(dlsi_factor_solve(factor, 0, X, 2, NULL, &e), &e, DLS_E_CALLBACK, "", "solve", -1);
  ck_assert(e.value == -4);
  dlsi_factor_destroy(factor);
}

/* The three allocations of a factorisation fail in turn; the matrix is kept from the first on. */
TEST(every_malloc_of_numeric_fails) {
  make_parts(DLS_LU, 1);
  dlsi_factor *factor = factor_new();
  for (int turn = 0; turn < 2; turn++) {
    dls_status status = DLS_E_MEMORY;
    long k = 0;
    while (status) {
      malloc_fails_at(++k);
      status = dlsi_factor_numeric(factor, &S.model, NULL);
      malloc_fails_at(0);
      if (status) ck_assert_int_eq(status, DLS_E_MEMORY);
    }
    ck_assert_int_eq(k, 3); /* of the second turn: its work, its iwork, none */
  }
  dlsi_factor_destroy(factor);
}
