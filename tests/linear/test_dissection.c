/* test_dissection.c: orders by METIS: each unknown once, those of a node in a row, whatever else is
 * listed; little fill. */
#include <check.h>
#include <stdint.h>
#include <string.h>

#include "base/base.h"
#include "linear/cholesky.h"
#include "linear/dissection.h"
#include "malloc_fails.h"
#include "run.h"

#if WITH_MUMPS

enum { side = 12, nodes = side * side, most_unknowns = 3 * nodes, most_listed = 200 * nodes };

static struct {
  int n;
  size_t entries;
  int row[most_listed], col[most_listed], order[most_unknowns];
} G;

static void list(int i, int j) {
  G.row[G.entries] = 1 + i;
  G.col[G.entries++] = 1 + j;
}

/* A grid of side x side nodes with d unknowns each, coupled along edges and diagonals: the lower
 * triangle; `turn` 1: with each entry twice and the diagonal. */
static void list_grid(int d, int turn) {
  G.n = d * nodes;
  G.entries = 0;
  for (int node = 0; node < nodes; node++)
    for (int k = 0; k < 5; k++) {
      const int column = node % side + (int[]){0, -1, 0, 1, -1}[k];
      const int row = node / side - (k > 1 ? 1 : 0);
      if (column < 0 || column >= side || row < 0) continue;
      const int other = column + side * row;
      for (int i = 0; i < d; i++)
        for (int j = 0; j < d; j++) {
          if (k == 0 && i <= j) {
            if (turn && i == j) list(d * node + i, d * node + i);
            continue;
          }
          for (int again = 0; again <= turn; again++)
            list(d * node + i, d * other + j);
        }
    }
}

static void dissect(void) {
  memset(G.order, -1, sizeof G.order);
  ck_assert_int_eq(dlsi_dissection(G.n, G.entries, G.row, G.col, G.order, NULL), DLS_OK);
  int seen[most_unknowns] = {0};
  for (int k = 0; k < G.n; k++) {
    ck_assert(G.order[k] >= 0 && G.order[k] < G.n);
    seen[G.order[k]]++;
  }
  for (int k = 0; k < G.n; k++)
    ck_assert_int_eq(seen[k], 1);
  for (int k = G.n; k < most_unknowns; k++)
    ck_assert_int_eq(G.order[k], -1);
}

/* The unknowns of a node stand in a row, ascending, in the order of the nodes alone; entries listed
 * twice and those of the diagonal change nothing. */
START_TEST(unknowns_of_a_node) {
  const int d = 1 + _i;
  int alone[nodes], first[most_unknowns];
  list_grid(1, 0);
  dissect();
  memcpy(alone, G.order, sizeof alone);
  list_grid(d, 0);
  dissect();
  memcpy(first, G.order, sizeof first);
  for (int k = 0; k < G.n; k++)
    ck_assert(first[k] % d == k % d && first[k] / d == first[k - k % d] / d);
  if (d == 1) ck_assert_mem_eq(alone, first, sizeof alone);
  list_grid(d, 1);
  dissect();
  ck_assert_mem_eq(G.order, first, (size_t)G.n * sizeof first[0]);
}
END_TEST

/* Operations of a Cholesky factor in this order. */
static double operations(const int *order) {
  int turn[most_unknowns];
  for (int k = 0; k < G.n; k++)
    turn[order[k]] = k + 1;
  dlsi_cholesky *L;
  ck_assert_int_eq(dlsi_cholesky_create(&L, G.n, G.entries, G.row, G.col, turn, 0, NULL), DLS_OK);
  const double flops = L->flops;
  dlsi_cholesky_destroy(L);
  return flops;
}

/* On a grid the factor takes much less work than in the order of rows, of which the band is full:
 * less than two thirds on 12 x 12 nodes. */
START_TEST(little_fill) {
  int rows[most_unknowns];
  list_grid(1 + _i, 0);
  dissect();
  for (int k = 0; k < G.n; k++)
    rows[k] = k;
  ck_assert_double_lt(operations(G.order), 0.67 * operations(rows));
}
END_TEST

/* A star with as many leaves, a pair of whose unknowns is alike but for each other; a pair with
 * equal neighbourhoods that are not neighbours is no node; unknowns alone. */
START_TEST(odd_graphs) {
  G.n = 5;
  G.entries = 0;
  dissect(); /* no entry at all */
  for (int i = 1; i < 5; i++)
    list(i, 0);
  dissect();
  list(2, 1);
  dissect();
  int at[5];
  for (int k = 0; k < 5; k++)
    at[G.order[k]] = k;
  ck_assert_int_eq(at[2], at[1] + 1);
  G.n = 1;
  G.entries = 0;
  list(0, 0);
  dissect();
}
END_TEST

START_TEST(every_malloc_fails) {
  list_grid(2, 0);
  dls_status status = DLS_E_MEMORY;
  long k = 0;
  while (status) {
    dls_error e = {0};
    malloc_fails_at(++k);
    status = dlsi_dissection(G.n, G.entries, G.row, G.col, G.order, &e);
    malloc_fails_at(0);
    if (status) ck_assert(status == DLS_E_MEMORY && e.index == -1);
  }
  ck_assert_int_eq(k, 6);
}
END_TEST

int main(void) {
  return RUN("dissection", NULL, NULL, EACH(unknowns_of_a_node, 0, 3), EACH(little_fill, 0, 3),
             ONCE(odd_graphs), ONCE(every_malloc_fails));
}

#else

int main(void) {
  return 0;
}

#endif
