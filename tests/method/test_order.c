/* test_order.c: the order of the contacts that follows from the data. */
#include "cases.h"
#include "run.h"
#include "vi/vi_internal.h"

enum { d = 2, nc = 120, m = d * nc }; /* more than few_candidates of order.c */

static double W[m * m], q[m], mu[nc], x[m * m];
static int p[nc + 1], rows[nc * nc];

/* W of couplings of all sizes, dense, and by blocks, every one of them. */
static void make_elastic(dls_contact *dense, dls_contact *blocks) {
  set_seed(11);
  for (int i = 0; i < m; i++) {
    q[i] = uniform();
    mu[i / d] = 0.3;
    for (int j = 0; j <= i; j++)
      W[i + m * j] = W[j + m * i] = i == j ? 2 * m : uniform();
  }
  for (int c = 0, k = 0; c < nc; c++) {
    for (int a = 0; a < nc; a++, k++) {
      rows[k] = a;
      for (int j = 0; j < d; j++)
        for (int i = 0; i < d; i++)
          x[d * d * k + i + d * j] = W[d * a + i + m * (d * c + j)];
    }
    p[c + 1] = k;
  }
  *dense = (dls_contact){.d = d, .nc = nc, .W = {m, m, m, W}, .q = q, .mu = mu};
  *blocks = (dls_contact){.d = d, .nc = nc, .Wb = {d, nc, p, rows, x}, .q = q, .mu = mu};
}

static void order_of(const dls_contact *problem, int *order) {
  static double keys[3][nc];
  double *const key[3] = {keys[0], keys[1], keys[2]};
  int scratch[nc];
  dlsi_order_candidates(problem, key, scratch, order);
}

/* (OR1) tells the first, then each is the one that those before it are coupled to most. */
TEST(walks_along_the_largest_coupling) {
  dls_contact dense, blocks;
  int order[nc], by_blocks[nc], seen[nc] = {0};
  make_elastic(&dense, &blocks);
  order_of(&dense, order);
  order_of(&blocks, by_blocks);
  ck_assert_mem_eq(order, by_blocks, sizeof order);
  for (int c = 0; c < nc; c++) /* all weights are one */
    ck_assert_double_le(q[d * order[0]], q[d * c]);
  for (int k = 0; k < nc; k++) {
    double largest = 0, own = 0;
    ck_assert_int_eq(seen[order[k]]++, 0);
    for (int l = k; l < nc; l++) {
      double sum = 0;
      for (int c = 0; c < k; c++)
        sum += fabs(W[d * order[l] + m * (d * order[c])]);
      if (l == k) own = sum;
      largest = fmax(largest, sum);
    }
    ck_assert_double_ge(own, largest * (1 - 0x1p-24));
  }
}
