/* test_anderson.c: Anderson acceleration, by hand and against a direct least squares problem. */
#include "cases.h"
#include "run.h"
#include "vi/vi_internal.h"

enum { most_m = 16, most_window = 8 };

/* What lies behind the arrays of a history must stay as it is. */
typedef struct history {
  dlsi_anderson a;
  dlsi_arena arena;
  double *behind;
} history;

static void history_carve(history *h, size_t m, int window, int with_u) {
  dlsi_anderson_carve(&h->a, &h->arena, m, window, with_u ? m : 0);
  h->behind = dlsi_take(&h->arena, 8, sizeof *h->behind);
}

static void history_make(history *h, int m, int window, int with_u) {
  *h = (history){.arena = {NULL, 0, 0, 0}};
  history_carve(h, (size_t)m, window, with_u);
  ck_assert_int_eq(dlsi_arena_allocate(&h->arena, "m", m, NULL), DLS_OK);
  memset(h->arena.base, 0xff, h->arena.size); /* NaN, should anything be read before it is set */
  history_carve(h, (size_t)m, window, with_u);
  memset(h->behind, 7, 8 * sizeof *h->behind);
  dlsi_anderson_clear(&h->a);
}

static void history_free(history *h) {
  const unsigned char *byte = (const unsigned char *)h->behind;
  for (size_t k = 0; k < 8 * sizeof *h->behind; k++)
    ck_assert_int_eq(byte[k], 7);
  free(h->arena.base);
}

/* Aitken: x := x / 2 + 1 from 0 gives g = 1, 3/2, whose limit is 2; u = 4 x - 3. */
TEST(a_line_ends_at_once) {
  history h;
  history_make(&h, 1, 1, 1);
  double f = 1, g = 1, u = 1;
  ck_assert_int_eq(dlsi_anderson_step(&h.a, 1, &f, &g, &u), 0);
  ck_assert(g == 1 && u == 1);
  f = .5, g = 1.5, u = 3;
  ck_assert_int_eq(dlsi_anderson_step(&h.a, 1, &f, &g, &u), 1);
  ck_assert(g == 2 && u == 5);
  history_free(&h);
}

/* gamma = f / df is -10^4 for f = -10^4 - 1, -10^4, which is the largest; beyond that, and where df
 * is 0 or not finite, all is forgotten: the next step has nothing to combine. */
TEST(forgets_what_is_too_large) {
  static const double f[4][2] = {{-10001, -10000}, {-10002, -10001}, {3, 3}, {1, NAN}};
  for (int k = 0; k < 4; k++) {
    history h;
    history_make(&h, 1, 2, 0);
    double g = 1;
    ck_assert_int_eq(dlsi_anderson_step(&h.a, 1, &f[k][0], &g, NULL), 0);
    ck_assert(g == 1);
    g = 2;
    ck_assert_int_eq(dlsi_anderson_step(&h.a, 1, &f[k][1], &g, NULL), k == 0);
    ck_assert(g == (k == 0 ? 10002 : 2));
    g = 5;
    const double next = 8;
    ck_assert_int_eq(dlsi_anderson_step(&h.a, 1, &next, &g, NULL), k == 0);
    if (k > 0) ck_assert(g == 5 && h.a.columns == 0 && h.a.started == 1);
    ck_assert_ptr_null(h.a.DU);
    ck_assert_ptr_null(h.a.u);
    history_free(&h);
  }
}

/* gamma = -10001 is shortened to -10^4, and the history goes on; what is not finite is
 * forgotten. */
TEST(shortens_what_is_too_large) {
  history h;
  history_make(&h, 1, 2, 1);
  h.a.shortens = 1;
  double f = -10002, g = 1, u = 3;
  ck_assert_int_eq(dlsi_anderson_step(&h.a, 1, &f, &g, &u), 0);
  f = -10001, g = 2, u = 5;
  ck_assert_int_eq(dlsi_anderson_step(&h.a, 1, &f, &g, &u), 1);
  ck_assert(g == 10002 && u == 20005 && h.a.columns == 1);
  g = 2, u = 5; /* df = 0 */
  ck_assert_int_eq(dlsi_anderson_step(&h.a, 1, &f, &g, &u), 0);
  ck_assert(g == 2 && u == 5 && h.a.columns == 0);
  history_free(&h);
}

/* Solves min |f - DF gamma|_2 for the n newest of the differences, DF (most_m apart), in long
 * double by normal equations and Gauss' elimination; x -= DX gamma. */
static void combine_directly(int m, int n, double *const DF[], const double *f, double *const DX[],
                             const double *x, double *out) {
  long double A[most_window][most_window + 1];
  for (int i = 0; i < n; i++)
    for (int j = 0; j <= n; j++) {
      A[i][j] = 0;
      for (int k = 0; k < m; k++)
        A[i][j] += (long double)DF[i][k] * (j < n ? DF[j][k] : f[k]);
    }
  for (int p = 0; p < n; p++) /* positive definite: no search for a pivot */
    for (int i = 0; i < n; i++)
      for (int j = n; i != p && j >= p; j--)
        A[i][j] -= A[i][p] / A[p][p] * A[p][j];
  for (int k = 0; k < m; k++) {
    long double sum = x[k];
    for (int i = 0; i < n; i++)
      sum -= DX[i][k] * (A[i][n] / A[i][i]);
    out[k] = (double)sum;
  }
}

/* (AN1)-(AN3) of random f, g, u, more of them than the window holds, and again after a clear in the
 * same memory. */
static void expect_least_squares(int m, int window, int with_u) {
  enum { most_steps = 24 };
  static double f[most_steps][most_m], g[most_steps][most_m], u[most_steps][most_m];
  static double df[most_steps][most_m], dg[most_steps][most_m], du[most_steps][most_m];
  history h;
  history_make(&h, m, window, with_u);
  for (int round = 0; round < 2; round++, dlsi_anderson_clear(&h.a))
    for (int k = 0; k < 2 * window + 2 + round; k++) {
      double *DF[most_window], *DG[most_window], *DU[most_window], next[most_m], next_u[most_m];
      double expected[most_m];
      for (int i = 0; i < m; i++) {
        f[k][i] = uniform();
        g[k][i] = next[i] = uniform();
        u[k][i] = next_u[i] = uniform();
        df[k][i] = k ? f[k][i] - f[k - 1][i] : NAN;
        dg[k][i] = k ? g[k][i] - g[k - 1][i] : NAN;
        du[k][i] = k ? u[k][i] - u[k - 1][i] : NAN;
      }
      const int n = k < window ? k : window;
      for (int i = 0; i < n; i++) {
        DF[i] = df[k - i];
        DG[i] = dg[k - i];
        DU[i] = du[k - i];
      }
      ck_assert_int_eq(dlsi_anderson_step(&h.a, m, f[k], next, with_u ? next_u : NULL), k > 0);
      combine_directly(m, n, DF, f[k], DG, g[k], expected);
      assert_near(next, expected, m, 1e-9);
      combine_directly(m, with_u ? n : 0, DF, f[k], DU, u[k], expected);
      assert_near(next_u, expected, m, 1e-9);
    }
  history_free(&h);
}

TEST(is_least_squares) {
  set_seed(3);
  expect_least_squares(1, 1, 1);
  expect_least_squares(5, 3, 1);
  expect_least_squares(7, 2, 0);
  expect_least_squares(16, 5, 1);
  expect_least_squares(16, 8, 1); /* every array fills its lines of memory */
  expect_least_squares(16, 8, 0);
}

/* df = e_1, then e_1 + s e_2: the older column is left out where its sine is below 1e-5, although
 * gamma, of 1 and -1, is not large. f = (1, 0) after both: with the newer one alone gamma = 1 /
 * (1 + s^2), with both 1, and x = g - dg_older. */
TEST(a_dependent_column_is_left_out) {
  static const double sine[2] = {0x1p-16, 0x1p-17};
  for (int k = 0; k < 2; k++) {
    const double s = sine[k];
    const double f[3][2] = {{-1, -s}, {0, -s}, {1, 0}};
    const double g[3][2] = {{0, 0}, {8, 0}, {8, 16}}; /* dg = (8, 0), (0, 16) */
    double x[2] = {0, 0};
    history h;
    history_make(&h, 2, 2, 0);
    for (int step = 0; step < 3; step++) {
      memcpy(x, g[step], sizeof x);
      ck_assert_int_eq(dlsi_anderson_step(&h.a, 2, f[step], x, NULL), step > 0);
    }
    /* in all digits but half of them */
    assert_near(x, (double[]){k == 0 ? 0 : 8, k == 0 ? 16 : 0}, 2, 1e-4);
    history_free(&h);
  }
}
