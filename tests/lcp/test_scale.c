/* test_scale.c: the scaling of an LCP against its formulas, entry by entry. */
#include "cases.h"
#include "lcp/lcp_internal.h"
#include "lcp_of.h"
#include "run.h"

enum { most_n = 600 }; /* more than a chunk of scale.c */

static double M[most_n * most_n], v[most_n * most_n];

static double mean_of_others(int n, const double *x, const char *set) {
  double sum = 0;
  int count = 0;
  for (int i = 0; i < n; i++)
    if (set[i]) sum += x[i], count++;
  return count ? sum / count : 0;
}

/* (SC1), (SC2) for the values v where M is not 0. */
static void alternate_directly(int n, double *rho, double *gamma) {
  for (int columns = 0; columns < 2; columns++) {
    double *x = columns ? gamma : rho;
    const double *other = columns ? rho : gamma;
    char set[most_n] = {0};
    for (int i = 0; i < n; i++) {
      double sum = 0;
      int count = 0;
      for (int j = 0; j < n; j++) {
        const int at = columns ? j + n * i : i + n * j;
        if (M[at] == 0) continue;
        sum += log2(v[at]) + other[j];
        count++;
      }
      set[i] = count > 0;
      if (count) x[i] = -sum / count;
    }
    const double mean = mean_of_others(n, x, set);
    for (int i = 0; i < n; i++)
      if (!set[i]) x[i] = mean;
  }
}

/* Returns the rounds of (SC4). */
static int equilibrate_directly(int n, double *rho, double *gamma) {
  int zeros = 0, round = 0;
  for (int k = 0; k < n * n; k++) {
    v[k] = fabs(M[k]);
    zeros |= M[k] == 0;
  }
  memset(gamma, 0, (size_t)n * sizeof *gamma);
  for (int k = 0; k <= zeros; k++)
    alternate_directly(n, rho, gamma);
  for (;; round++) {
    double row[most_n] = {0}, column[most_n] = {0}, least = INFINITY, most_of_rows = 0;
    for (int j = 0; j < n; j++)
      for (int i = 0; i < n; i++) {
        const double size = exp2(rho[i] + gamma[j]) * fabs(M[i + n * j]);
        row[i] = fmax(row[i], size);
        column[j] = fmax(column[j], size);
      }
    for (int i = 0; i < n; i++) {
      most_of_rows = fmax(most_of_rows, row[i]);
      if (row[i] > 0) least = fmin(least, row[i]);
    }
    if (round == 8 || !(most_of_rows > 0x1p20 * least)) break;
    for (int j = 0; j < n; j++)
      for (int i = 0; i < n; i++)
        v[i + n * j] =
            fmax(fabs(M[i + n * j]), 0x1p-10 * sqrt(row[i] * column[j]) / exp2(rho[i] + gamma[j]));
    alternate_directly(n, rho, gamma);
  }
  double shift = 0;
  for (int i = 0; i < n; i++)
    shift += (gamma[i] - rho[i]) / 2 / n;
  for (int i = 0; i < n; i++) {
    rho[i] += shift;
    gamma[i] -= shift;
  }
  return round;
}

/* Compares, and returns the rounds of (SC4). */
static int expect_formulas(int n) {
  static double rho[most_n], gamma[most_n], expected[2][most_n], work[9 * most_n + 1];
  for (int k = 0; k < 9 * n; k++)
    work[k] = NAN;
  for (int i = 0; i < n; i++)
    rho[i] = gamma[i] = NAN;
  work[9 * n] = 7;
  const dls_lcp lcp = lcp_of(n, M, NULL);
  dlsi_lcp_equilibrate(&lcp, rho, gamma, work);
  ck_assert(work[9 * n] == 7);
  const int rounds = equilibrate_directly(n, expected[0], expected[1]);
  for (int i = 0; i < n; i++) {
    ck_assert_double_eq_tol(rho[i], expected[0][i], 1e-9);
    ck_assert_double_eq_tol(gamma[i], expected[1][i], 1e-9);
  }
  return rounds;
}

/* Sizes that are and are not multiples of eight; M without zeros, with zeros, with an empty row and
 * an empty column. */
TEST(small_matrices) {
  set_seed(12);
  for (int n = 1; n <= 18; n++)
    for (int kind = 0; kind < 3; kind++) {
      for (int k = 0; k < n * n; k++)
        M[k] = (kind && uniform() < 0 ? 0 : 1) * (2 * (uniform() < 0) - 1) * exp2(7 * uniform());
      for (int j = 0; kind == 2 && j < n; j++)
        M[n / 2 + n * j] = M[j + n * (n - 1)] = 0;
      ck_assert_int_eq(expect_formulas(n), 0);
    }
}

/* n = 2 on paper: log2|M| = [1 3; 5 9] has rho = -2, -7, gamma = 1.5, -1.5, moved to the same mean,
 * -2.25; a row of 0 takes the other's rho. */
TEST(two_by_hand) {
  const double A[4] = {2, 32, -8, 512}, row[4] = {4, 0, 16, 0}, none[4] = {0};
  static const double expected[3][4] = {
      {.25, -4.75, -.75, -3.75}, {-1.5, -1.5, -.5, -2.5}, {0, 0, 0, 0}};
  const double *const matrix[3] = {A, row, none};
  for (int k = 0; k < 3; k++) {
    double x[4], work[18];
    const dls_lcp lcp = lcp_of(2, matrix[k], NULL);
    dlsi_lcp_equilibrate(&lcp, x, x + 2, work);
    for (int i = 0; i < 4; i++)
      ck_assert_double_eq_tol(x[i], expected[k][i], 1e-14);
  }
}

/* Entries that decay along a line call for (SC4), a triangle of growing ones for two rounds of it;
 * units of rows and columns, zeros in between. */
TEST(negligible_entries) {
  int one = 0, two = 0;
  for (int kind = 0; kind < 6; kind++) {
    const int n = 30 + 3 * kind;
    for (int j = 0; j < n; j++)
      for (int i = 0; i < n; i++) {
        const int zero = kind % 2 && (i + 2 * j) % 3 == 1;
        M[i + n * j] = zero ? 0 : exp2(-(2. + 4 * (kind / 2)) * abs(i - j) + i % 5 - 3 * (j % 4));
      }
    const int rounds = expect_formulas(n);
    one += rounds == 1;
    two += rounds == 2;
  }
  for (int n = 12; n <= 13; n++) {
    for (int k = 0; k < n * n; k++)
      M[k] = 0;
    for (int j = 0; j < n; j++)
      for (int i = j; i < n; i++)
        M[i + n * j] = exp2(i == j ? 0 : 30 * (i - j));
    const int rounds = expect_formulas(n);
    one += rounds == 1;
    two += rounds == 2;
  }
  ck_assert_int_gt(one, 0);
  ck_assert_int_gt(two, 0);
}

/* More rows than one product of mantissas takes, whose exponents would not do in one either. */
TEST(beyond_a_chunk) {
  for (int n = 511; n <= 514; n += n == 511 ? 2 : 1) {
    set_seed((uint64_t)n);
    for (int k = 0; k < n * n; k++)
      M[k] = exp2(100 * uniform()) * (1.9 + .09 * uniform());
    (void)expect_formulas(n);
  }
}

TEST(powers_of_two) {
  ck_assert(dlsi_power_of_two(0) == 1 && dlsi_power_of_two(.4) == 1 && dlsi_power_of_two(.6) == 2);
  ck_assert(dlsi_power_of_two(-1.6) == .25 && dlsi_power_of_two(499) == 0x1p499);
  ck_assert(dlsi_power_of_two(500.4) == 0x1p500 && dlsi_power_of_two(501) == 0x1p500);
  ck_assert(dlsi_power_of_two(-499) == 0x1p-499 && dlsi_power_of_two(-501) == 0x1p-500);
}
