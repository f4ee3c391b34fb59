/* test_table.c: Lemke's table, which postpones its pivots, against one that does each at once. */
#include "cases.h"
#include "lcp/lcp_internal.h"
#include "run.h"

enum { size = 40, columns = size + 1, exchanges = 250, spare = 3 };

/* The table of (TA1) and (TA2), and the derivatives g. */
typedef struct plain {
  double A[size * columns], b[size], g[size];
  int basic[size], column[columns];
} plain;

static void plain_exchange(plain *p, int r, int s) {
  double c[size];
  memcpy(c, p->A + size * s, sizeof c);
  for (int j = 0; j < columns; j++) {
    const double share = p->A[r + size * j] / c[r];
    if (j == s) continue;
    for (int i = 0; i < size; i++)
      p->A[i + size * j] -= c[i] * share;
    p->A[r + size * j] = -share;
  }
  for (int i = 0; i < size; i++)
    p->A[i + size * s] = (i == r ? 1 : c[i]) / c[r];
  const double b = p->b[r] / c[r], g = p->g[r] / c[r];
  for (int i = 0; i < size; i++) {
    p->b[i] -= c[i] * b;
    p->g[i] -= c[i] * g;
  }
  p->b[r] = -b;
  p->g[r] = -g;
  const int in = p->column[s];
  p->column[s] = p->basic[r];
  p->basic[r] = in;
}

static void table_open(dlsi_table *table, dlsi_arena *arena, plain *p) {
  *table = (dlsi_table){.n = size};
  *arena = (dlsi_arena){0};
  dlsi_table_carve(table, arena, size, size + spare);
  ck_assert_int_eq(dlsi_arena_allocate(arena, "n", size, NULL), DLS_OK);
  dlsi_table_carve(table, arena, size, size + spare);
  set_seed(7);
  for (int j = 0; j < columns; j++) {
    for (int i = 0; i < size; i++)
      p->A[i + size * j] = table->T[i + table->ld * j] = uniform();
    p->column[j] = table->column[j] = size + j;
    table->where[size + j] = -1 - j;
    table->born[j] = -1;
  }
  for (int i = 0; i < size; i++) {
    p->b[i] = table->b[i] = uniform();
    p->g[i] = table->g[i] = uniform();
    p->basic[i] = table->basic[i] = table->where[i] = i;
  }
}

/* Columns, values, the move by y and the lists of variables. */
static void expect_same(const dlsi_table *table, const plain *p) {
  double c[size], dy[size], sum[size] = {0};
  for (int s = 0; s < columns; s++) {
    dlsi_table_column(table, s, c);
    assert_close(c, p->A + size * s, size, 1e-9);
    ck_assert_int_eq(table->column[s], p->column[s]);
    ck_assert_int_eq(table->where[p->column[s]], -1 - s);
  }
  assert_close(table->b, p->b, size, 1e-9);
  assert_close(table->g, p->g, size, 1e-9);
  for (int i = 0; i < size; i++) {
    ck_assert_int_eq(table->basic[i], p->basic[i]);
    ck_assert_int_eq(table->where[p->basic[i]], i);
    dy[i] = i % 5 == 3 ? 0 : uniform();
  }
  for (int s = 0; s < columns; s++)
    for (int i = 0; i < size && p->column[s] < size; i++)
      sum[i] += dy[p->column[s]] * p->A[i + size * s];
  dlsi_table_move_y(table, dy, c);
  assert_close(c, sum, size, 1e-9);
}

/* Rows of the largest entry, so that nothing grows. The table is looked at when nothing is pending,
 * some, more than a part of (TA4), and after the block is full. */
TEST(exchanges_that_are_put_off) {
  static plain p;
  dlsi_table table;
  dlsi_arena arena;
  table_open(&table, &arena, &p);
  expect_same(&table, &p);
  for (int k = 1; k <= exchanges; k++) {
    const int s = (int)((uniform() + 1) / 2 * columns);
    double c[size];
    int r = 0;
    dlsi_table_column(&table, s, c);
    for (int i = 1; i < size; i++)
      if (fabs(c[i]) > fabs(c[r])) r = i;
    dlsi_table_exchange(&table, r, s, c);
    plain_exchange(&p, r, s);
    ck_assert_int_eq(table.pending, k % dlsi_table_block);
    if (k < 4 || k % 16 < 2) expect_same(&table, &p);
  }
  free(arena.base);
}
