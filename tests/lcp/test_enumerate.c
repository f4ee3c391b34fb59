/* test_enumerate.c: vertices, proofs of emptiness and extents of { x >= 0 : C x = q }, by hand. */
#include "lcp/lcp_internal.h"
#include "run.h"

enum { rows_most = 3 };

/* Rows of (C | q), n of n + 1. */
typedef struct vertex_case {
  int n, found;
  double C[rows_most * (rows_most + 1)], x[rows_most];
} vertex_case;

/* Bland's rule takes the least column that lowers the sum, and of equal ratios the first row. */
static const vertex_case vertices[] = {
    {1, 1, {2, 6}, {3}},
    {1, 1, {-2, -6}, {3}},
    {1, 0, {2, -6}, {0}},
    {1, 1, {0, 0}, {0}},
    {1, 0, {0, 1}, {0}},
    {2, 1, {1, 1, 2, 1, -1, 0}, {1, 1}},  /* one point */
    {2, 1, {-1, 0, -3, 0, 1, 5}, {3, 5}}, /* q of both signs */
    {2, 1, {1, 1, 2, 0, 0, 0}, {2, 0}},   /* a segment */
    {2, 1, {1, -1, 1, 0, 0, 0}, {1, 0}},  /* a half line */
    {2, 1, {1, -2, 1, 0, 0, 0}, {1, 0}},
    {2, 1, {1, 2, 2, 0, 0, 0}, {2, 0}},
    {2, 1, {1e-4, 1, 3e-4 + 1e-11, 1, 0, 3}, {3, 0}},          /* 1e-11 is 0 */
    {2, 1, {1, -1, -1, 0, 0, 0}, {0, 1}},                      /* another one */
    {2, 0, {1, 1, -1, 0, 1, 1}, {0}},                          /* x_0 + x_1 = -1 */
    {2, 0, {1, -1, 1, 1, -1, 2}, {0}},                         /* two lines apart */
    {3, 1, {1, 1, 0, 2, 0, 0, 0, 0, 2, 2, 0, 4}, {2, 0, 0}},   /* one row thrice, or 0 */
    {3, 1, {1, 1, 1, 4, 1, 2, 4, 13, 1, 3, 9, 28}, {1, 0, 3}}, /* by three pivots */
    {3, 1, {0, 0, 1, 1, 0, 1, 1, 3, 1, 1, 1, 6}, {3, 2, 1}},   /* rows out of order */
    {3, 1, {1, 1, 1, 1, 1, -1, 0, 0, 1, 0, -1, 0}, {1. / 3, 1. / 3, 1. / 3}},
};
enum { vertex_count = sizeof vertices / sizeof *vertices };

TEST_EACH(finds_vertices, 0, vertex_count) {
  const vertex_case *k = &vertices[_i];
  double x[rows_most + 1] = {7, 7, 7, 7};
  ck_assert_int_eq(dlsi_find_vertex(k->n, k->C, x), k->found);
  for (int i = 0; k->found && i < k->n; i++)
    ck_assert_double_eq_tol(x[i], k->x[i], 1e-15);
  ck_assert(x[k->n] == 7);
}

/* y.C <= 0 and y.q > 0. By hand: two values of x_0; -x_0 = 1; and the slack in the equations of
 * columns that are basic. */
TEST(refutes_vertices) {
  double y[rows_most + 1];
  for (int c = 0; c < vertex_count; c++) {
    const vertex_case *k = &vertices[c];
    const int n = k->n;
    double gain = 0;
    y[n] = 7;
    ck_assert_int_eq(dlsi_refute_vertex(n, k->C, 0, y), !k->found);
    for (int j = 0; !k->found && j <= n; j++) {
      double sum = 0;
      for (int i = 0; i < n; i++)
        sum += y[i] * k->C[i * (n + 1) + j];
      if (j < n)
        ck_assert(sum <= 0);
      else
        gain = sum;
    }
    ck_assert(k->found || gain > 0);
    ck_assert(y[n] == 7);
  }
  static const double twice[] = {1, 0, 1, 1, 0, 2}, below[] = {1, 0, -1, 0, 1, 1};
  ck_assert_int_eq(dlsi_refute_vertex(2, twice, 0.25, y), 1);
  ck_assert(y[0] == -1.25 && y[1] == 1);
  ck_assert_int_eq(dlsi_refute_vertex(2, below, 0.25, y), 1);
  ck_assert(y[0] == -1 && y[1] == -0.25);
}

typedef struct spread_case {
  int n, dimension;
  double C[rows_most * (rows_most + 1)];
  double a[2][rows_most], low[2], high[2];
} spread_case;

static const spread_case spreads[] = {
    {2, -1, {1, 1, -1, 0, 1, 1}, {{1}}, {0}, {0}},
    {2, 0, {1, 0, 1, 0, 1, 2}, {{1}}, {0}, {0}},
    {2, 0, {1, 1, 0, 0, 0, 0}, {{1}}, {0}, {0}}, /* x_0 + x_1 = 0: the origin */
    {2, 1, {1, 1, 2, 0, 0, 0}, {{1, 0}, {1, -1}}, {0, -2}, {2, 2}},
    {2, 1, {1, 1, 2, 0, 0, 0}, {{1, 1}, {0, 3}}, {2, 0}, {2, 6}},
    {2, 1, {1, -1, 1, 0, 0, 0}, {{1, 0}, {-1, 0}}, {1, -INFINITY}, {INFINITY, -1}},
    {2, 1, {1, -1, 1, 0, 0, 0}, {{0, 1}, {1, -1}}, {0, 1}, {INFINITY, 1}},
    {2, 1, {1, -1, 0, 0, 0, 0}, {{1, 0}, {0, 1}}, {0, 0}, {INFINITY, INFINITY}}, /* at step 0 */
    {2, 2, {0, 0, 0, 0, 0, 0}, {{1, 0}, {0, -1}}, {0, -INFINITY}, {INFINITY, 0}},
    {3, 2, {1, 1, 1, 1, 0, 0, 0, 0, 0, 0, 0, 0}, {{1, 2, 3}, {1, 0, 0}}, {1, 0}, {3, 1}},
    {3, 1, {1, -1, 0, 0, 1, 1, 1, 2, 0, 0, 0, 0}, {{1, 0, 0}, {0, 0, 1}}, {0, 0}, {1, 2}},
    {3, 1, {0, 0, 1, 4, 1, 1, 0, 1, 0, 0, 0, 0}, {{0, 0, 1}, {0, 1, 1}}, {4, 4}, {4, 5}},
};
enum { spread_count = sizeof spreads / sizeof *spreads };

TEST_EACH(spreads_of_polyhedra, 0, spread_count) {
  const spread_case *k = &spreads[_i];
  double a[2 * rows_most], low[3] = {7, 7, 7}, high[3] = {7, 7, 7};
  for (int l = 0; l < 2; l++)
    memcpy(a + l * k->n, k->a[l], (size_t)k->n * sizeof *a);
  for (int count = 0; count <= 2; count++) {
    ck_assert_int_eq(dlsi_spread(k->n, k->C, count, a, low, high), k->dimension);
    for (int l = 0; l < 3; l++) {
      ck_assert(low[l] == (l < count && k->dimension > 0 ? k->low[l] : 7));
      ck_assert(high[l] == (l < count && k->dimension > 0 ? k->high[l] : 7));
    }
  }
}
