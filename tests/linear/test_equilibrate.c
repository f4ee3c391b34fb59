/* test_equilibrate.c: factors for rows and columns by hand. */
#include "linear/equilibrate.h"
#include "run.h"

enum { n = 4 };

static double R[n], C[n], scratch[2 * n];

/* Finds R and C; the scratch and both hold other numbers before. */
static void find(const dls_sparse *K, int symmetric) {
  for (int i = 0; i < n; i++)
    R[i] = C[i] = scratch[i] = scratch[n + i] = 1e300;
  dlsi_find_scales(K, symmetric, R, C, scratch);
}

/* Entries of a diagonal become 1 at once, by the power of two below 1/sqrt(a); two in one place
 * count by themselves; a row without entries but 0 stays. */
TEST(diagonal) {
  const int p[] = {0, 1, 2, 4, 5}, i[] = {0, 1, 2, 2, 3};
  const double x[] = {-4, 1. / 64, 9, 9, 0};
  const dls_sparse K = {n, n, p, i, x};
  for (int symmetric = 0; symmetric < 2; symmetric++) {
    find(&K, symmetric);
    ck_assert(R[0] == 0.5 && R[1] == 8 && R[2] == 0.25 && R[3] == 1);
    ck_assert(C[0] == 0.5 && C[1] == 8 && C[2] == 0.25 && C[3] == 1);
  }
}

/* A row whose only entry is 2^-64, in a column of 1: each sweep but the first, which takes all of
 * it, halves what is left: 2^(64 - 64 / 2^5) after five; a column of 2^-32 alike. Above the
 * diagonal a symmetric K is not read. */
TEST(five_sweeps) {
  const int p[] = {0, 2, 3, 4, 5}, i[] = {0, 1, 0, 2, 3};
  double x[] = {1, 0x1p-64, 0x1p-32, 1, 1};
  const dls_sparse K = {n, n, p, i, x};
  find(&K, 0);
  ck_assert(R[0] == 1 && R[1] == 0x1p62 && R[2] == 1 && R[3] == 1);
  ck_assert(C[0] == 1 && C[1] == 0x1p31 && C[2] == 1 && C[3] == 1);
  x[2] = 0x1p900;
  find(&K, 1);
  ck_assert(R[0] == 1 && R[1] == 0x1p62 && R[2] == 1 && R[3] == 1);
  ck_assert(C[0] == 1 && C[1] == 0x1p62 && C[2] == 1 && C[3] == 1);
}
