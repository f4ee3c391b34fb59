/* test_columns.c: triplets to compressed columns, all or those of one component. */
#include "contact/columns.h"
#include "run.h"

/* Two candidates in 3D, local columns n t s n t s; entries unsorted, two of them in one place. */
static void add_all(dlsi_triplets *t) {
  static const int row[7] = {3, 0, 1, 2, 3, 0, 1}, col[7] = {5, 0, 4, 0, 5, 3, 2};
  for (int k = 0; k < 7; k++)
    dlsi_triplets_add(t, row[k], col[k], k + 1);
}

TEST(columns_by_hand) {
  static const struct {
    int cols, p[7], i[7];
    double x[7];
  } is[3] = {{6, {0, 2, 2, 3, 4, 5, 7}, {0, 2, 1, 0, 1, 3, 3}, {2, 4, 7, 6, 3, 1, 5}},
             {2, {0, 2, 3}, {0, 2, 0}, {2, 4, 6}},
             {4, {0, 0, 1, 2, 4}, {1, 1, 3, 3}, {7, 3, 1, 5}}};
  const dlsi_part part[3] = {DLSI_ALL, DLSI_NORMALS, DLSI_TANGENTS};
  dlsi_triplets t;
  ck_assert_int_eq(dlsi_triplets_alloc(4, 6, 7, &t, NULL), DLS_OK);
  ck_assert(t.rows == 4 && t.cols == 6 && t.count == 0);
  add_all(&t);
  for (int k = 0; k < 3; k++) {
    dlsi_columns A;
    ck_assert_int_eq(dlsi_columns_compress(&t, 3, part[k], &A, NULL), DLS_OK);
    const int cols = is[k].cols;
    const size_t count = (size_t)is[k].p[cols];
    const dls_sparse view = dlsi_columns_view(&A);
    ck_assert(view.rows == 4 && view.cols == cols);
    ck_assert_mem_eq(view.p, is[k].p, ((size_t)cols + 1) * sizeof *view.p);
    ck_assert_mem_eq(view.i, is[k].i, count * sizeof *view.i);
    ck_assert_mem_eq(view.x, is[k].x, count * sizeof *view.x);
    dlsi_columns_free(&A);
  }
  for (int k = 0; k < 6; k++) { /* n t s n t s; d = 2: n t n t n t; d = 1: n n n n n n */
    const int normal[6] = {0, -1, -1, 1, -1, -1}, tangent[6] = {-1, 0, 1, -1, 2, 3};
    ck_assert_int_eq(dlsi_column_of(3, DLSI_NORMALS, k), normal[k]);
    ck_assert_int_eq(dlsi_column_of(3, DLSI_TANGENTS, k), tangent[k]);
    ck_assert_int_eq(dlsi_column_of(2, DLSI_NORMALS, k), k % 2 ? -1 : k / 2);
    ck_assert_int_eq(dlsi_column_of(2, DLSI_TANGENTS, k), k % 2 ? k / 2 : -1);
    ck_assert_int_eq(dlsi_column_of(1, DLSI_ALL, k), k);
    ck_assert_int_eq(dlsi_column_of(1, DLSI_NORMALS, k), k);
  }
  dlsi_triplets_free(&t);
}

/* No columns, no entries; more entries than an int counts; each malloc failing. */
TEST(nothing_and_too_much) {
  dlsi_triplets t;
  dlsi_columns A;
  dls_error e;
  ck_assert_int_eq(dlsi_triplets_alloc(3, 0, 0, &t, NULL), DLS_OK);
  ck_assert_int_eq(dlsi_columns_compress(&t, 1, DLSI_ALL, &A, NULL), DLS_OK);
  ck_assert(A.rows == 3 && A.cols == 0 && A.p[0] == 0);
  dlsi_columns_free(&A);
  dlsi_triplets_free(&t);
  ck_assert_int_eq(dlsi_triplets_alloc(3, 3, (size_t)INT_MAX + 1, &t, &e), DLS_E_SIZE);
  ck_assert(e.value == (double)INT_MAX + 1);
  dlsi_triplets_free(&t);
  for (long k = 1; k <= 3; k++) {
    malloc_fails_at(k);
    ck_assert_int_eq(dlsi_triplets_alloc(4, 6, 7, &t, &e), DLS_E_MEMORY);
    malloc_fails_at(0);
    dlsi_triplets_free(&t);
  }
  ck_assert_int_eq(dlsi_triplets_alloc(4, 6, 7, &t, &e), DLS_OK);
  add_all(&t);
  for (long k = 1; k <= 3; k++) {
    malloc_fails_at(k);
    ck_assert_int_eq(dlsi_columns_compress(&t, 2, DLSI_ALL, &A, &e), DLS_E_MEMORY);
    malloc_fails_at(0);
    dlsi_columns_free(&A);
  }
  dlsi_triplets_free(&t);
}
