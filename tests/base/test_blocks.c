/* test_blocks.c: dense matrices to matrices by blocks and back, entry by entry. */
#include "contact/contact.h"
#include "run.h"

enum { room = 7 * 6 };

/* One entry of a 6 x 6 matrix with room between its columns makes one block, wherever it stands;
 * what stands in the room, and -0, make none. */
TEST_EACH(any_entry_makes_a_block, 0, 3) {
  const int d = 1 + _i, n = 6 / d, ld = 7;
  double a[room];
  for (int at = 0; at < 36; at++) {
    const int row = at % 6, col = at / 6;
    int count = -1, p[7], i[2] = {77, 77};
    double x[10];
    dls_blocks B;
    for (int k = 0; k < room; k++)
      a[k] = k % ld == 6 ? 5 : -0.0;
    for (int k = 0; k < 10; k++)
      x[k] = 77;
    a[row + ld * col] = 3;
    const dls_dense A = {6, 6, ld, a};
    ck_assert_int_eq(dls_blocks_count(&A, d, &count, NULL), DLS_OK);
    ck_assert_int_eq(count, 1);
    ck_assert_int_eq(dls_blocks_from_dense(&A, d, p, i, x, &B, NULL), DLS_OK);
    for (int b = 0; b <= n; b++)
      ck_assert_int_eq(p[b], b > col / d);
    ck_assert(i[0] == row / d && i[1] == 77 && x[d * d] == 77);
    for (int e = 0; e < d * d; e++)
      ck_assert(x[e] == (e == row % d + d * (col % d) ? 3 : 0));
    ck_assert(B.d == d && B.n == n && B.p == p && B.i == i && B.x == x);
  }
}

/* Blocks of a column in any order, of the same place added; the room between columns is left. */
TEST(blocks_add_up) {
  const int p[3] = {0, 3, 4}, i[4] = {1, 0, 1, 0};
  const double x[16] = {1, 2, 3, 4, 5, 6, 7, 8, 10, 20, 30, 40, 9, 10, 11, 12};
  const double expected[20] = {5, 6,  11, 22, 77, 7,  8,  33, 44, 77,
                               9, 10, 0,  0,  77, 11, 12, 0,  0,  77};
  const dls_blocks B = {2, 2, p, i, x};
  double a[20];
  for (int k = 0; k < 20; k++)
    a[k] = 77;
  ck_assert_int_eq(dls_blocks_to_dense(&B, a, 5, NULL), DLS_OK);
  ck_assert_mem_eq(a, expected, sizeof a);
  double dense[16], y[16];
  int r[3], j[4], count;
  dls_blocks C;
  ck_assert_int_eq(dls_blocks_to_dense(&B, dense, 4, NULL), DLS_OK);
  const dls_dense A = {4, 4, 4, dense};
  ck_assert_int_eq(dls_blocks_count(&A, 2, &count, NULL), DLS_OK);
  ck_assert_int_eq(count, 3);
  ck_assert_int_eq(dls_blocks_from_dense(&A, 2, r, j, y, &C, NULL), DLS_OK);
  ck_assert(r[0] == 0 && r[1] == 2 && r[2] == 3 && j[0] == 0 && j[1] == 1 && j[2] == 0);
  const double blocks[12] = {5, 6, 7, 8, 11, 22, 33, 44, 9, 10, 11, 12};
  ck_assert_mem_eq(y, blocks, sizeof blocks);
}

TEST(nothing) {
  double none[1] = {77}, x[1];
  const int start[1] = {0};
  int p[1] = {77}, i[1], count = 77;
  dls_blocks B;
  const dls_dense A = {0, 0, 1, none};
  ck_assert_int_eq(dls_blocks_count(&A, 3, &count, NULL), DLS_OK);
  ck_assert_int_eq(count, 0);
  ck_assert_int_eq(dls_blocks_from_dense(&A, 3, p, i, x, &B, NULL), DLS_OK);
  ck_assert(p[0] == 0 && B.n == 0 && B.d == 3);
  const dls_blocks empty = {3, 0, start, NULL, NULL};
  ck_assert_int_eq(dls_blocks_to_dense(&empty, none, 1, NULL), DLS_OK);
  ck_assert(none[0] == 77);
}

/* The number that is wrong, no index, and words with both sizes. */
TEST(wrong_sizes) {
  static const struct {
    int rows, d;
    const char *words;
  } bad[] = {{1, 2, "has 1 row, not n times 2"},
             {4, 3, "has 4 rows, not n times 3"},
             {-2, 2, "has -2 rows, not n times 2"}};
  double a[16] = {0};
  int count = 77;
  for (int k = 0; k < 3; k++) {
    const dls_dense A = {bad[k].rows, bad[k].rows, 4, a};
    REFUSES(SIZE, "A", -1, dls_blocks_count, &A, bad[k].d, &count);
    ck_assert(last_refusal.index == -1 && last_refusal.value == bad[k].rows && count == 77);
    ck_assert_msg(strstr(last_refusal.message, bad[k].words) != NULL, "%s", last_refusal.message);
  }
  const int p[3] = {0, 0, 0};
  for (int n = 0; n <= 2; n += 2) { /* ld is one less than it must be */
    const dls_blocks B = {2, n, p, NULL, NULL};
    const int ld = n ? 3 : 0;
    REFUSES(SIZE, "ld", -1, dls_blocks_to_dense, &B, a, ld);
    ck_assert(last_refusal.index == -1 && last_refusal.value == ld);
    ck_assert_ptr_nonnull(
        strstr(last_refusal.message, n ? "must be at least 2 x 2" : "must be at least 2 x 0"));
  }
  const dls_blocks B = {2, 2, p, NULL, NULL};
  a[0] = a[15] = 77;
  ck_assert_int_eq(dls_blocks_to_dense(&B, a, 4, NULL), DLS_OK);
  ck_assert(a[0] == 0 && a[15] == 0);
}
