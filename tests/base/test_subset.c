/* test_subset.c: where a subset puts its numbers, entry by entry; errors in its list. */
#include "contact/contact.h"
#include "run.h"

/* Three candidates, d = 1, by blocks: the column of candidate 0 has the rows 2 0 1 0, that of 1
 * none, that of 2 the rows 1 2. */
static const int p[4] = {0, 4, 4, 6}, i[6] = {2, 0, 1, 0, 1, 2};
static const double x[6] = {1, 2, 3, 4, 5, 6}, q[3] = {7, 8, 9}, mu[3] = {0, 0, 0};
static const dls_contact blocks = {.d = 1, .nc = 3, .Wb = {1, 3, p, i, x}, .q = q, .mu = mu};

/* Columns and rows 0 and 2: blocks 0, 1, 3, 5 are left, of rows that are renumbered. */
TEST(blocks_by_hand) {
  const int list[2] = {0, 2}, expected[] = {0, 3, 4, 1, 0, 0, 1, 77};
  const double numbers[] = {1, 2, 4, 6, 7, 9, 0, 0, 77};
  int index[8];
  double values[9];
  dls_contact s;
  for (int k = 0; k < 8; k++)
    index[k] = 77;
  for (int k = 0; k < 9; k++)
    values[k] = 77;
  ck_assert_int_eq(dls_contact_subset(&blocks, 2, list, values, index, &s, NULL), DLS_OK);
  ck_assert_mem_eq(index, expected, sizeof index);
  ck_assert_mem_eq(values, numbers, sizeof values);
  ck_assert(s.Wb.p == index && s.Wb.i == index + 3 && s.Wb.x == values);
  ck_assert(s.d == 1 && s.nc == 2 && s.Wb.d == 1 && s.Wb.n == 2 && !s.W.a && !s.bodies.H);
  ck_assert(s.q == values + 4 && s.mu == values + 6);
}

/* Of one candidate in the middle, and of the last: rows before and after the list are left out. */
TEST(one_of_three) {
  static const int last[] = {0, 1, 0, 77};
  int index[4] = {77, 77, 77, 77};
  double values[4];
  dls_contact s;
  ck_assert_int_eq(dls_contact_subset(&blocks, 1, (const int[]){1}, values, index, &s, NULL),
                   DLS_OK);
  ck_assert(index[0] == 0 && index[1] == 0 && index[2] == 77 && values[0] == 8);
  ck_assert_int_eq(dls_contact_subset(&blocks, 1, (const int[]){2}, values, index, &s, NULL),
                   DLS_OK);
  ck_assert_mem_eq(index, last, sizeof last);
  ck_assert(values[0] == 6 && values[1] == 9 && values[2] == 0);
}

/* W with room between its columns, d = 2: W' without. */
TEST(dense_by_hand) {
  enum { nc = 3, m = 2 * nc, ld = m + 1 };
  static const int list[2] = {0, 2}, row[4] = {0, 1, 4, 5};
  double W[ld * m], load[m], friction[nc] = {.25, .5, .75}, values[23];
  for (int k = 0; k < ld * m; k++)
    W[k] = k;
  for (int k = 0; k < m; k++)
    load[k] = 100 + k;
  values[22] = 77;
  const dls_contact dense = {.d = 2, .nc = nc, .W = {m, m, ld, W}, .q = load, .mu = friction};
  dls_contact s;
  ck_assert_int_eq(dls_contact_subset(&dense, 2, list, values, NULL, &s, NULL), DLS_OK);
  for (int k = 0; k < 16; k++)
    ck_assert(values[k] == row[k % 4] + ld * row[k / 4]);
  for (int k = 0; k < 4; k++)
    ck_assert(values[16 + k] == 100 + row[k]);
  ck_assert(values[20] == .25 && values[21] == .75 && values[22] == 77);
  ck_assert(s.W.rows == 4 && s.W.cols == 4 && s.W.ld == 4 && s.W.a == values && !s.Wb.x);
}

/* Bodies of the last candidates: two numbers each, and nothing after them. */
TEST(bodies_by_hand) {
  const int body[6] = {0, -1, 1, 0, -1, 2}, expected[] = {1, 0, -1, 2, 77};
  double H[2 * 3 * 2 * 3], load[6], friction[3] = {.25, .5, .75}, values[31];
  int index[5] = {77, 77, 77, 77, 77};
  for (int k = 0; k < 36; k++)
    H[k] = k;
  for (int k = 0; k < 6; k++)
    load[k] = 100 + k;
  values[30] = 77;
  const dls_contact of = {
      .d = 2, .nc = 3, .bodies = {3, 3, body, H, NULL}, .q = load, .mu = friction};
  dls_contact s;
  ck_assert_int_eq(dls_contact_subset(&of, 2, (const int[]){1, 2}, values, index, &s, NULL),
                   DLS_OK);
  ck_assert_mem_eq(index, expected, sizeof index);
  for (int k = 0; k < 24; k++)
    ck_assert(values[k] == 12 + k);
  for (int k = 0; k < 4; k++)
    ck_assert(values[24 + k] == 102 + k);
  ck_assert(values[28] == .5 && values[29] == .75 && values[30] == 77);
  ck_assert(s.bodies.n == 3 && s.bodies.count == 3);
  ck_assert_int_eq(dls_contact_subset(&of, 0, NULL, NULL, NULL, &s, NULL), DLS_OK);
  ck_assert(s.d == 2 && s.nc == 0 && !s.bodies.H);
}

/* An empty list needs no memory; a full one is the problem. */
TEST(none_and_all) {
  dls_contact s;
  int index[10];
  double values[12];
  ck_assert_int_eq(dls_contact_subset(&blocks, 0, NULL, NULL, NULL, &s, NULL), DLS_OK);
  ck_assert(s.d == 1 && s.nc == 0 && !s.q && !s.Wb.x);
  ck_assert_int_eq(dls_contact_subset(&blocks, 3, (const int[]){0, 1, 2}, values, index, &s, NULL),
                   DLS_OK);
  ck_assert_mem_eq(index, p, sizeof p);
  ck_assert_mem_eq(index + 4, i, sizeof i);
  ck_assert_mem_eq(values, x, sizeof x);
}

/* The error has the index in the list, its number, and the range or the number before. */
TEST(lists_that_are_refused) {
  static const struct {
    int count, list[3], index, value;
    dls_status status;
    const char *argument, *words;
  } bad[] = {{2, {1, 0}, 1, 0, DLS_E_ARGUMENT, "candidate", "does not ascend: comes after 1"},
             {2, {1, 1}, 1, 1, DLS_E_ARGUMENT, "candidate", "does not ascend: comes after 1"},
             {3, {0, 2, 1}, 2, 1, DLS_E_ARGUMENT, "candidate", "does not ascend: comes after 2"},
             {1, {3}, 0, 3, DLS_E_ARGUMENT, "candidate", "is outside of 0 .. 2"},
             {3, {0, 1, 3}, 2, 3, DLS_E_ARGUMENT, "candidate", "is outside of 0 .. 2"},
             {1, {-1}, 0, -1, DLS_E_ARGUMENT, "candidate", "is outside of 0 .. 2"},
             {4, {0}, -1, 4, DLS_E_SIZE, "count", "is 4, must be from 0 to 3"},
             {-1, {0}, -1, -1, DLS_E_SIZE, "count", "is -1, must be from 0 to 3"}};
  for (size_t k = 0; k < sizeof bad / sizeof bad[0]; k++) {
    int index[10];
    double values[12] = {77};
    dls_contact s = {.d = 77};
    dls_error e;
    ck_assert_int_eq(dls_contact_subset(&blocks, bad[k].count, bad[k].list, values, index, &s, &e),
                     bad[k].status);
    ck_assert_str_eq(e.argument, bad[k].argument);
    ck_assert_int_eq(e.index, bad[k].index);
    ck_assert(e.value == bad[k].value);
    ck_assert_msg(strstr(e.message, bad[k].words) != NULL, "%s", e.message);
    ck_assert(s.d == 77 && values[0] == 77);
  }
}
