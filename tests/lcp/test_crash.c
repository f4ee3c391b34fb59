/* test_crash.c: the rounds of the crash start against elimination, and where they give up. */
#include "cases.h"
#include "lcp/lcp_internal.h"
#include "lcp_of.h"
#include "run.h"

enum { most_n = 48 };

/* A crash with memory of its own, and the same method done directly. */
typedef struct crash_pair {
  dlsi_crash work;
  dlsi_arena arena;
  double s[most_n], A[most_n * most_n];
  int in[most_n], fewest, chances;
} crash_pair;

static void crash_open(crash_pair *t, const dls_lcp *lcp, const double *z) {
  const size_t n = (size_t)lcp->n;
  t->work = (dlsi_crash){.rounds = 0};
  t->arena = (dlsi_arena){.size = 0};
  dlsi_crash_carve(&t->work, &t->arena, n, n);
  ck_assert_int_eq(dlsi_arena_allocate(&t->arena, "n", lcp->n, NULL), DLS_OK);
  memset(t->arena.base, 0x5a, t->arena.size);
  dlsi_crash_carve(&t->work, &t->arena, n, n);
  dlsi_lcp_weights(lcp, t->s);
  t->work.s = t->s;
  t->work.factors.A = t->A;
  dlsi_crash_begin(lcp, z, &t->work);
  for (int i = 0; i < lcp->n; i++) {
    t->in[i] = z && z[i] > 0;
    ck_assert(t->work.z[i] == 0);
  }
  t->fewest = 2 * lcp->n;
  t->chances = 4;
}

/* z_A := -M_AA^-1 q_A by elimination with full search of the column. Returns 0 where it is
 * singular. */
static int solve_directly(const dls_lcp *lcp, const int *in, double *z) {
  static double A[most_n][most_n + 1];
  int at[most_n], k = 0;
  for (int i = 0; i < lcp->n; i++) {
    z[i] = 0;
    if (in[i]) at[k++] = i;
  }
  for (int i = 0; i < k; i++) {
    for (int j = 0; j < k; j++)
      A[i][j] = dlsi_lcp_column(lcp, at[j])[at[i]];
    A[i][k] = -lcp->q[at[i]];
  }
  for (int p = 0; p < k; p++) {
    int r = p;
    for (int i = p + 1; i < k; i++)
      if (fabs(A[i][p]) > fabs(A[r][p])) r = i;
    if (fabs(A[r][p]) < 1e-9) return 0;
    for (int j = 0; j <= k; j++) {
      const double a = A[p][j];
      A[p][j] = A[r][j];
      A[r][j] = a;
    }
    for (int i = 0; i < k; i++)
      for (int j = k; i != p && j >= p; j--)
        A[i][j] -= A[i][p] / A[p][p] * A[p][j];
  }
  for (int i = 0; i < k; i++)
    z[at[i]] = A[i][k] / A[i][i];
  return 1;
}

/* Takes a round on both sides; returns what both say. */
static int expect_round(crash_pair *t, const dls_lcp *lcp) {
  const int n = lcp->n;
  double z[most_n] = {0}, y[most_n], a[most_n];
  int wrong[most_n], count = 0, grown = 0, loaded = 0, expected = 0;
  const int singular = !solve_directly(lcp, t->in, z);
  if (singular)
    expected = -1;
  else {
    dlsi_lcp_multiply(lcp, lcp->q, z, y, a);
    for (int i = 0; i < n; i++) {
      const double v = t->in[i] ? t->s[i] * z[i] : y[i];
      wrong[i] = v < -1e-13 * (fabs(lcp->q[i]) + a[i]);
      count += wrong[i];
      if (!t->in[i] || lcp->q[i] == 0) continue;
      loaded++;
      grown += a[i] > 1000 * fabs(lcp->q[i]);
    }
    if (2 * grown > loaded)
      expected = -1;
    else if (count == 0)
      expected = 1;
    else {
      if (4 * count <= 3 * t->fewest)
        t->chances = 4;
      else if (--t->chances == 0)
        expected = -1;
      if (count < t->fewest) t->fewest = count;
    }
  }
  const int before = t->work.rounds, outcome = dlsi_crash_round(lcp, &t->work);
  /* with the factors of an earlier basis rounding may hide that this one is singular */
  if (singular && t->work.change.n > 0) return -1;
  ck_assert_int_eq(outcome, expected);
  ck_assert_int_eq(t->work.rounds, before + 1);
  if (outcome >= 0)
    for (int i = 0; i < n; i++)
      ck_assert_double_eq_tol(t->work.z[i], z[i], 1e-9 * (1 + fabs(z[i])));
  if (outcome != 0) return outcome;
  for (int i = 0; i < n; i++)
    t->in[i] ^= wrong[i];
  for (int j = 0; j < n; j++) { /* one by one, as (CR4) leaves out alone what needs others */
    int empty = 1;
    for (int i = 0; i < n; i++)
      if (t->in[i] && dlsi_lcp_column(lcp, j)[i] != 0) empty = 0;
    if (empty) t->in[j] = 0;
  }
  ck_assert_mem_eq(t->in, t->work.in, (size_t)n * sizeof *t->in);
  return 0;
}

/* Runs to the end, which is returned; *changes counts the rounds with the factors of an earlier
 * one, where some enter and some leave. */
static int expect_crash(const dls_lcp *lcp, const double *z, int *changes) {
  static crash_pair t;
  int outcome = 0;
  crash_open(&t, lcp, z);
  while (outcome == 0) {
    outcome = expect_round(&t, lcp);
    *changes += t.work.change.n > t.work.e && t.work.e > 0;
  }
  free(t.arena.base);
  return outcome;
}

static double M[most_n * most_n], q[most_n], start[most_n];

/* Positive definite, nearly all of A_0 right: a few indices change, and change back. */
TEST(rounds_are_elimination) {
  int changes = 0, ends[3] = {0};
  for (int trial = 0; trial < 60; trial++) {
    const int n = 20 + trial % 29;
    set_seed((uint64_t)trial);
    gram_and_skew(n, uniform, .05, .02, M, q);
    for (int i = 0; i < n; i++) {
      q[i] = uniform() < -.6 ? .3 : -fabs(q[i]) - .02;
      start[i] = i % 11 != trial % 11;
    }
    const dls_lcp lcp = lcp_of(n, M, q);
    ends[1 + expect_crash(&lcp, trial % 3 ? start : NULL, &changes)]++;
  }
  ck_assert_int_gt(changes, 20);
  ck_assert_int_gt(ends[2], 20);
}

/* Small integers, zeros on the diagonal: bases that are singular, columns without a partner; unit
 * blocks below let there be factors that are kept. */
TEST(rounds_of_integers) {
  int changes = 0, ends[3] = {0};
  set_seed(21);
  for (int trial = 0; trial < 400; trial++) {
    const int n = trial % 2 ? 5 : 30, small = trial % 2 ? 5 : 6;
    memset(M, 0, sizeof M);
    for (int j = 0; j < n; j++) {
      for (int i = 0; i < small && j < small; i++)
        M[i + n * j] = (i != j || trial % 4 < 2) * rint(2 * uniform());
      if (j >= small) M[j + n * j] = 1;
      q[j] = j >= small ? -1 : uniform() - .25;
      start[j] = j >= small || uniform() > 0;
    }
    const dls_lcp lcp = lcp_of(n, M, q);
    ends[1 + expect_crash(&lcp, start, &changes)]++;
  }
  ck_assert_int_gt(changes, 10);
  ck_assert_int_gt(ends[0], 50);
  ck_assert_int_gt(ends[2], 20);
}

/* Exchanging all at once cycles here [Kostreva 1979], from six of the eight bases: `patience`
 * rounds, or one more. */
TEST(patience_ends) {
  const double C[9] = {1, 0, 2, 2, 1, 0, 0, 2, 1}, minus[3] = {-1, -1, -1};
  const dls_lcp lcp = lcp_of(3, C, minus);
  int ends[3] = {0}, changes = 0;
  for (int set = 0; set < 8; set++) {
    const double z[3] = {set & 1, set >> 1 & 1, set >> 2 & 1};
    ends[1 + expect_crash(&lcp, z, &changes)]++;
  }
  ck_assert(ends[0] == 6 && ends[2] == 2);
}

/* (CR3) |M||z| is 2^k - 1 in two rows with q = -1: too much from 1000 on, unless as many rows are
 * as they should; rows without a load do not
 * count, whatever their terms. */
TEST(growth_gives_up) {
  for (int k = 9; k <= 10; k++)
    for (int others = 0; others <= 2; others++)
      for (int loaded = 0; loaded < 2; loaded++) {
        const double e = ldexp(1, -k + 1);
        double z[4] = {1, 1, 1, 1};
        const double f[4] = {-1, -1, loaded ? -1 : 0, loaded ? -1 : 0};
        const int n = 2 + others;
        memset(M, 0, sizeof M);
        M[0] = M[1 + n] = 1;
        M[1] = M[n] = e - 1;
        for (int i = 2; i < n; i++) {
          M[i + n * i] = 1;
          if (loaded) continue; /* z_i = z_1 - z_0 = 0, of large terms */
          M[i] = 1;
          M[i + n] = -1;
        }
        const dls_lcp lcp = lcp_of(n, M, f);
        static crash_pair t;
        crash_open(&t, &lcp, z);
        ck_assert_int_eq(expect_round(&t, &lcp), k == 9 || (others == 2 && loaded) ? 1 : -1);
        free(t.arena.base);
      }
}

/* A pivot of 2^-39 beside terms of 1 is regular, one of 2^-40 is rounding, wherever the two rows
 * stand and in any unit. The answer is 1 in both. */
TEST(what_is_singular) {
  static const int pairs[][2] = {{0, 1}, {5, 37}, {31, 32}, {0, 31}, {32, 33}, {0, 47}, {46, 47}};
  for (size_t p = 0; p < sizeof pairs / sizeof pairs[0]; p++)
    for (int k = 39; k <= 40; k++) {
      const int n = most_n, a = pairs[p][0], b = pairs[p][1];
      const double unit = p % 2 ? 0x1p60 : 1;
      memset(M, 0, sizeof M);
      for (int i = 0; i < n; i++) {
        M[i + n * i] = unit;
        start[i] = 1;
        q[i] = -unit;
      }
      M[a + n * b] = M[b + n * a] = unit;
      M[b + n * b] = unit * (1 + ldexp(1, -k));
      q[a] = -2 * unit;
      q[b] = -unit * (2 + ldexp(1, -k));
      const dls_lcp lcp = lcp_of(n, M, q);
      static crash_pair t;
      crash_open(&t, &lcp, start);
      ck_assert_int_eq(dlsi_crash_round(&lcp, &t.work), k == 39 ? 1 : -1);
      for (int i = 0; i < n; i++)
        ck_assert_double_eq_tol(t.work.z[i], k == 39 ? 1 : 0, 1e-15);
      free(t.arena.base);
    }
}
