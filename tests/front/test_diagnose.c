/* test_diagnose.c: facts about a contact problem, against closed forms, enumeration and scaling. */
#include "cases.h"
#include "delassus.h"
#include "failures.h"
#include "made.h"
#include "run.h"
#include "vi/vi_internal.h"

static uint64_t state;

/* in (-1, 1) */
static double noise(void) {
  state = state * 6364136223846793005u + 1442695040888963407u;
  return (double)(state >> 11) * 0x1p-52 - 1;
}

static dls_diagnosis diagnose(int d, int nc, const double *W, const double *q, const double *mu) {
  const int m = d * nc;
  const dls_contact p = {.d = d, .nc = nc, .W = {m, m, m, W}, .q = q, .mu = mu};
  dls_diagnosis g;
  ck_assert_int_eq(dls_contact_diagnose(&p, 100, &g, NULL), DLS_OK);
  return g;
}

/* bytes of padding aside, the same numbers to the last bit */
static void same_bits(const dls_diagnosis *a, const dls_diagnosis *b) {
  ck_assert_mem_eq(&a->weight_min, &b->weight_min, 5 * sizeof(double));
  ck_assert_int_eq(a->closing, b->closing);
  ck_assert_mem_eq(&a->asymmetry, &b->asymmetry, sizeof(double));
  ck_assert(a->row == b->row && a->col == b->col);
  ck_assert_mem_eq(&a->zero_block, &b->zero_block, 5 * sizeof(dls_flaw));
  ck_assert(a->spectrum == b->spectrum && a->rank == b->rank && a->negative == b->negative);
  ck_assert_mem_eq(&a->noise, &b->noise, 5 * sizeof(double));
  ck_assert_int_eq(a->critical, b->critical);
  ck_assert_mem_eq(&a->wedged, &b->wedged, sizeof(dls_flaw));
  ck_assert_mem_eq(&a->friction_unique, &b->friction_unique, sizeof(double));
}

static void close_to(double x, double y, double relative) {
  ck_assert_msg(fabs(x - y) <= relative * fabs(y), "%.17g instead of %.17g", x, y);
}

/* no candidate but `first`, if not -1, is so */
static void flaw_is(const dls_flaw *flaw, int count, int first) {
  ck_assert_int_eq(flaw->count, count);
  ck_assert_int_eq(flaw->first, first);
}

/* ---- closed forms ---------------------------------------------------------------------------- */

TEST(diagonal) {
  /* w = 4, 9; scaled diagonal 1/2, 3/2, 2/3, 4/3; nothing couples n and t */
  const double W[16] = {2, 0, 0, 0, 0, 6, 0, 0, 0, 0, 6, 0, 0, 0, 0, 12};
  const double q[4] = {3, 0, -4, 0}, mu[2] = {0.5, 0.25};
  const dls_diagnosis g = diagnose(2, 2, W, q, mu);
  ck_assert(g.weight_min == 4 && g.weight_max == 9 && g.q_norm == 5);
  ck_assert(g.friction_min == 0.25 && g.friction_max == 0.5);
  ck_assert_int_eq(g.closing, 1);
  ck_assert(g.asymmetry == 0 && g.row == -1 && g.col == -1);
  ck_assert(g.spectrum == 1 && g.rank == 4 && g.negative == 0);
  close_to(g.smallest, 0.5, 8 * DBL_EPSILON);
  close_to(g.smallest_positive, 0.5, 8 * DBL_EPSILON);
  close_to(g.largest, 1.5, 8 * DBL_EPSILON);
  ck_assert(g.noise == 16 * DBL_EPSILON);
  ck_assert(isinf(g.friction_critical) && g.critical == -1 && isinf(g.friction_unique));
  flaw_is(&g.zero_block, 0, -1);
  flaw_is(&g.no_weight, 0, -1);
  flaw_is(&g.no_normal, 0, -1);
  flaw_is(&g.singular_block, 0, -1);
  flaw_is(&g.no_effect, 0, -1);
  flaw_is(&g.wedged, 0, -1);
}

/* One candidate in 2D, W = (a b; b c): mu* = a/|b| if a c >= 2 b^2, else 2 sqrt(a c - b^2)/c. */
TEST(one_candidate_has_its_closed_form) {
  const double mu = 0.5, q[2] = {-1, 0};
  state = 1;
  for (int k = 0; k < 200; k++) {
    const double a = exp(2 * noise()), c = exp(2 * noise()), b = 0.999 * sqrt(a * c) * noise();
    const dls_diagnosis g = diagnose(2, 1, (const double[4]){a, b, b, c}, q, &mu);
    const double det = a * c - b * b;
    close_to(g.friction_critical, a / fabs(b), 8 * DBL_EPSILON);
    /* sqrt of s = det/c: rounding of s relative to a */
    close_to(g.friction_unique, a * c >= 2 * b * b ? a / fabs(b) : 2 * sqrt(det) / c,
             32 * DBL_EPSILON * a * c / det);
    ck_assert(g.friction_unique <= g.friction_critical * (1 + 32 * DBL_EPSILON * a * c / det));
    flaw_is(&g.wedged, mu > a / fabs(b), mu > a / fabs(b) ? 0 : -1);
  }
}

/* 3D, W = (a b 0; b c 0; 0 0 e), e <= c: S = a - b^2/c, T = diag(1/c, 1/e), P = (b/c, 0). */
TEST(three_dimensions) {
  const double mu = 0.5, q[3] = {1, 0, 0}, W[9] = {2, 1, 0, 1, 4, 0, 0, 0, 3};
  const dls_diagnosis g = diagnose(3, 1, W, q, &mu);
  close_to(g.weight_min, 3, 4 * DBL_EPSILON);
  close_to(g.friction_critical, 2, 8 * DBL_EPSILON); /* a / |b| */
  const double k = sqrt((2 - 0.25) / 4), h = 0.25;
  close_to(g.friction_unique, h + k * k / h, 32 * DBL_EPSILON);
  ck_assert_int_eq(g.closing, 0);
}

TEST(rank_and_definiteness) {
  state = 2;
  const double mu[4] = {0.1, 0.1, 0.1, 0.1}, q[8] = {0};
  for (int rank = 1; rank <= 8; rank++) { /* W = B B^T, B 8 x rank */
    double B[64], W[64];
    for (int i = 0; i < 8 * rank; i++)
      B[i] = noise();
    for (int i = 0; i < 8; i++)
      for (int j = 0; j < 8; j++) {
        W[i + 8 * j] = 0;
        for (int k = 0; k < rank; k++)
          W[i + 8 * j] += B[i * rank + k] * B[j * rank + k];
      }
    const dls_diagnosis g = diagnose(2, 4, W, q, mu);
    ck_assert_int_eq(g.rank, rank);
    ck_assert_int_eq(g.negative, 0);
    ck_assert((g.friction_unique > 0) == (rank == 8));
    ck_assert(g.smallest_positive > g.noise * g.largest && g.smallest <= g.smallest_positive);
  }
  /* scaled (1 3; 3 1): eigenvalues -2, 4 */
  const dls_diagnosis g = diagnose(2, 1, (const double[4]){5, 15, 15, 5}, q, mu);
  ck_assert(g.rank == 2 && g.negative == 1 && g.friction_unique == 0);
  close_to(g.smallest, -2, 8 * DBL_EPSILON);
  close_to(g.largest, 4, 8 * DBL_EPSILON);
  close_to(g.smallest_positive, 4, 8 * DBL_EPSILON);
  /* (1 1+e; 1+e 1): -e and 2 + e; a file's rounding, and more than that */
  for (int k = 0; k < 2; k++) {
    const double e = k ? 1e-4 : 1e-7;
    const dls_diagnosis h = diagnose(2, 1, (const double[4]){1, 1 + e, 1 + e, 1}, q, mu);
    ck_assert_int_eq(h.rank, k ? 2 : 1);
    ck_assert_int_eq(h.negative, k ? 1 : 0);
    if (!k) close_to(h.noise, 10 * e / (2 + e), 1e-7);
  }
}

TEST(unsymmetric) {
  /* (4 1; 2 4): scaled (1 1/4; 1/2 1), symmetric part 1 +- 3/8 */
  const double mu[2] = {0.3, 0.3}, q[4] = {0};
  const dls_diagnosis g = diagnose(2, 1, (const double[4]){4, 2, 1, 4}, q, mu);
  close_to(g.asymmetry, 0.25, 8 * DBL_EPSILON);
  ck_assert(g.row == 0 && g.col == 1);
  close_to(g.largest, 1.375, 8 * DBL_EPSILON);
  close_to(g.smallest, 0.625, 8 * DBL_EPSILON);
  close_to(g.friction_critical, 4, 8 * DBL_EPSILON); /* the row of u_n: W_nt = 1 */
  /* S = 1 - 1/8, T = 1, P = 1/4, Q = 1/2: g = 1/4, h = 1/4 < k: h + k^2/h - g = 7/2 */
  close_to(g.friction_unique, 3.5, 32 * DBL_EPSILON);
  /* (1 0; 0 1) and (1 9; -8 1): s = t = k = 1, h = 9, g = 17: 2 k - g < 0, no bound */
  const double twist[16] = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, -8, 0, 0, 9, 1};
  const dls_diagnosis f = diagnose(2, 2, twist, q, mu);
  ck_assert(f.smallest > 0 && f.friction_unique == 0);
  /* the worst pair: rows 1 and 2 of two candidates with the weights 1 and 100 */
  double W[16] = {1, 0.1, 0, 0, 0, 1, 0, 0, 0, 3, 100, 0, 0, 0, 0, 100};
  const dls_diagnosis h = diagnose(2, 2, W, q, mu);
  close_to(h.asymmetry, 0.3, 8 * DBL_EPSILON);
  ck_assert(h.row == 1 && h.col == 2);
}

/* ---- degenerate candidates ------------------------------------------------------------------- */

TEST(degenerate_candidates_are_named) {
  static const double good[4] = {2, 0.5, 0.5, 2}, zero[4] = {0}, none[4] = {1, 0, 0, -1},
                      pull[4] = {-1, 0, 0, 4}, flat[4] = {1, 1, 1, 1}, slide[4] = {2, 0, 0, 0};
  static const struct {
    const double *block;
    int zero, weight, normal, singular, effect;
  } kind[] = {{good, 0, 0, 0, 0, 0}, {zero, 1, 0, 0, 0, 2}, {none, 0, 1, 0, 0, 0},
              {pull, 0, 0, 1, 0, 0}, {flat, 0, 0, 0, 1, 0}, {slide, 0, 0, 0, 1, 1}};
  const double mu[3] = {0, 0, 0}, q[6] = {0};
  for (int k = 0; k < 6; k++)
    for (int c = 0; c < 3; c++) {
      double W[36] = {0};
      for (int b = 0; b < 3; b++)
        for (int e = 0; e < 4; e++)
          W[2 * b + e % 2 + 6 * (2 * b + e / 2)] = b == c ? kind[k].block[e] : good[e];
      const dls_diagnosis g = diagnose(2, 3, W, q, mu);
      flaw_is(&g.zero_block, kind[k].zero, kind[k].zero ? c : -1);
      flaw_is(&g.no_weight, kind[k].weight, kind[k].weight ? c : -1);
      flaw_is(&g.no_normal, kind[k].normal, kind[k].normal ? c : -1);
      flaw_is(&g.singular_block, kind[k].singular, kind[k].singular ? c : -1);
      const int row = kind[k].effect == 2 ? 2 * c : 2 * c + 1; /* slide: W_tt = 0 */
      flaw_is(&g.no_effect, kind[k].effect, kind[k].effect ? row : -1);
      if (k == 1 || k == 3) ck_assert(g.friction_critical == 0 && g.critical == c);
      ck_assert(k == 1 || k == 3 || k == 4 || fabs(g.friction_critical - 4) < 1e-14);
    }
  const double hinge[4] = {0, 1, 1, 2}; /* W_nn = 0 in a block that is not */
  const dls_diagnosis h = diagnose(2, 1, hinge, q, mu);
  flaw_is(&h.zero_block, 0, -1);
  flaw_is(&h.no_normal, 1, 0);
  flaw_is(&h.singular_block, 0, -1);
  flaw_is(&h.no_effect, 0, -1);
  const double negative[4] = {1, -4, -4, 0}; /* the largest entries are */
  const dls_diagnosis f = diagnose(2, 1, negative, q, mu);
  flaw_is(&f.singular_block, 0, -1);
  flaw_is(&f.no_normal, 0, -1);
  ck_assert_double_eq_tol(f.friction_critical, 0.25, 1e-15);
  /* all zero: no scale anywhere, nothing breaks */
  const double W[36] = {0};
  const dls_diagnosis g = diagnose(2, 3, W, q, mu);
  ck_assert(g.weight_min == 0 && g.weight_max == 0 && g.rank == 0 && g.largest == 0);
  flaw_is(&g.zero_block, 3, 0);
  flaw_is(&g.no_effect, 6, 0);
}

TEST(singular_blocks_in_three_dimensions) {
  const double q[3] = {0}, mu = 0.1;
  state = 3;
  for (int rank = 1; rank <= 3; rank++)
    for (int k = 0; k < 50; k++) {
      double B[9], W[9] = {0};
      for (int e = 0; e < 9; e++)
        B[e] = noise();
      for (int e = 0; e < 9; e++)
        for (int l = 0; l < rank; l++)
          W[e] += B[e % 3 + 3 * l] * B[e / 3 + 3 * l];
      const dls_diagnosis g = diagnose(3, 1, W, q, &mu);
      flaw_is(&g.singular_block, rank < 3, rank < 3 ? 0 : -1);
      ck_assert_int_eq(g.rank, rank);
    }
}

/* ---- invariance ------------------------------------------------------------------------------ */

enum { NC = 4, M = 2 * NC };

/* Random W = (B B^T + 0.1 I + skew) / m, and q. */
static void random_matrix(int m, double skew, double *W, double *q) {
  gram_and_skew(m, noise, 0.1 / m, skew / m, W, q);
}

static void same_facts(const dls_diagnosis *a, const dls_diagnosis *b) {
  const double condition = b->largest / b->smallest_positive, tol = 100 * DBL_EPSILON * condition;
  ck_assert(a->rank == b->rank && a->negative == b->negative && a->closing == b->closing);
  close_to(a->asymmetry, b->asymmetry, tol);
  close_to(a->smallest, b->smallest, tol);
  close_to(a->largest, b->largest, tol);
  close_to(a->friction_unique, b->friction_unique, tol);
  close_to(a->friction_critical, b->friction_critical, tol);
  ck_assert_int_eq(a->wedged.count, b->wedged.count);
}

TEST(units_do_not_matter) {
  double W[M * M], q[M];
  const double mu[NC] = {0.1, 0.2, 0.9, 1.7};
  state = 4;
  random_matrix(M, 0.01, W, q);
  const dls_diagnosis g = diagnose(2, NC, W, q, mu);
  ck_assert(g.friction_unique > 0 && g.asymmetry > 0);
  static const double factor[4] = {1e-9, 1e9, 1e-3, 1e3};
  for (int f = 0; f < 4; f++)
    for (int l = 0; l < 4; l++) { /* force, length */
      double V[M * M], p[M];
      for (int i = 0; i < M * M; i++)
        V[i] = factor[l] / factor[f] * W[i];
      for (int i = 0; i < M; i++)
        p[i] = factor[l] * q[i];
      const dls_diagnosis h = diagnose(2, NC, V, p, mu);
      same_facts(&h, &g);
      ck_assert(h.row == g.row && h.col == g.col && h.critical == g.critical);
      close_to(h.weight_min, factor[l] / factor[f] * g.weight_min, 8 * DBL_EPSILON);
      close_to(h.weight_max, factor[l] / factor[f] * g.weight_max, 8 * DBL_EPSILON);
      close_to(h.q_norm, factor[l] * g.q_norm, 8 * DBL_EPSILON);
    }
  /* units of each candidate's own */
  double V[M * M], p[M];
  static const double s[NC] = {1e-4, 1, 1e3, 1e6};
  for (int i = 0; i < M * M; i++)
    V[i] = s[i % M / 2] * s[i / M / 2] * W[i];
  for (int i = 0; i < M; i++)
    p[i] = s[i / 2] * q[i];
  const dls_diagnosis h = diagnose(2, NC, V, p, mu);
  same_facts(&h, &g);
}

TEST(order_does_not_matter) {
  double W[M * M], V[M * M], q[M], p[M];
  const double mu[NC] = {0.1, 0.2, 0.9, 1.7}, nu[NC] = {0.9, 0.1, 1.7, 0.2};
  static const int from[NC] = {2, 0, 3, 1};
  state = 5;
  random_matrix(M, 0.01, W, q);
  for (int i = 0; i < M; i++) {
    const int k = 2 * from[i / 2] + i % 2;
    p[i] = q[k];
    for (int j = 0; j < M; j++)
      V[i + M * j] = W[k + M * (2 * from[j / 2] + j % 2)];
  }
  const dls_diagnosis g = diagnose(2, NC, W, q, mu), h = diagnose(2, NC, V, p, nu);
  same_facts(&h, &g);
  ck_assert_int_eq(from[h.critical], g.critical);
  const int i = 2 * from[h.row / 2] + h.row % 2, j = 2 * from[h.col / 2] + h.col % 2;
  ck_assert((i == g.row && j == g.col) || (i == g.col && j == g.row));
}

TEST(tangent_frames_do_not_matter) {
  double W[81], V[81] = {0}, q[9];
  const double mu[3] = {0.1, 0.2, 0.9};
  state = 6;
  double B[81];
  for (int i = 0; i < 81; i++)
    B[i] = noise();
  for (int i = 0; i < 81; i++) {
    W[i] = (i % 9 == i / 9) + 0.01 * noise();
    for (int k = 0; k < 9; k++)
      W[i] += B[i % 9 + 9 * k] * B[i / 9 + 9 * k];
  }
  double R[81] = {0}; /* rotations about n */
  for (int c = 0; c < 3; c++) {
    const double a = 3 * noise();
    R[3 * c + 9 * (3 * c)] = 1;
    R[3 * c + 1 + 9 * (3 * c + 1)] = R[3 * c + 2 + 9 * (3 * c + 2)] = cos(a);
    R[3 * c + 1 + 9 * (3 * c + 2)] = -sin(a);
    R[3 * c + 2 + 9 * (3 * c + 1)] = sin(a);
    for (int i = 0; i < 3; i++)
      q[3 * c + i] = i ? 1 : noise();
  }
  for (int i = 0; i < 9; i++)
    for (int j = 0; j < 9; j++)
      for (int k = 0; k < 9; k++)
        for (int l = 0; l < 9; l++)
          V[i + 9 * j] += R[i + 9 * k] * W[k + 9 * l] * R[j + 9 * l];
  const dls_diagnosis g = diagnose(3, 3, W, q, mu);
  dls_diagnosis h = diagnose(3, 3, V, q, mu);
  ck_assert(g.friction_unique > 0);
  h.asymmetry = g.asymmetry; /* entry by entry, it depends on the frame */
  same_facts(&h, &g);
}

/* The problem by blocks, in scrambled order, every block of a candidate's own split in two. */
TEST(blocks_give_the_facts_of_the_dense_matrix) {
  for (int d = 2; d <= 3; d++) {
    const int nc = 3, m = 3 * d;
    double W[81], x[9 * 12], q[9] = {-1}, mu[3] = {0.3, 0.2, 0.1};
    int p[4] = {0}, i[12], used = 0;
    state = 7;
    for (int k = 0; k < m * m; k++)
      W[k] = (k % m == k / m ? 4 : 0) + noise();
    for (int a = 0; a < d; a++)
      for (int b = 0; b < d; b++) /* blocks (0, 2) only: its mirror image is missing */
        W[2 * d + a + m * b] = 0;
    for (int c = 0; c < nc; c++) {
      for (int a = nc - 1; a >= 0; a--)
        for (int part = 0; part < (a == c ? 2 : 1); part++) {
          if (c == 0 && a == 2) continue;
          for (int e = 0; e < d * d; e++) {
            const double w = W[d * a + e % d + m * (d * c + e / d)];
            x[d * d * used + e] = a != c ? w : part ? 0.25 * w : 0.75 * w;
          }
          i[used++] = a;
        }
      p[c + 1] = used;
    }
    const dls_contact blocks = {.d = d, .nc = nc, .Wb = {d, nc, p, i, x}, .q = q, .mu = mu};
    dls_diagnosis g = diagnose(d, nc, W, q, mu), h;
    ck_assert_int_eq(dls_contact_diagnose(&blocks, 100, &h, NULL), DLS_OK);
    ck_assert(g.asymmetry > 0);
    same_facts(&h, &g);
    ck_assert(h.row == g.row && h.col == g.col && h.critical == g.critical);
    flaw_is(&h.no_effect, 0, -1);
  }
}

TEST(blocks_that_are_missing) {
  /* candidate 1 has no block at all */
  const int p[4] = {0, 1, 1, 2}, i[2] = {0, 2};
  const double x[8] = {2, 0, 0, 2, 3, 0, 0, 3}, q[6] = {0}, mu[3] = {0};
  const dls_contact blocks = {.d = 2, .nc = 3, .Wb = {2, 3, p, i, x}, .q = q, .mu = mu};
  dls_diagnosis g;
  ck_assert_int_eq(dls_contact_diagnose(&blocks, 6, &g, NULL), DLS_OK);
  flaw_is(&g.zero_block, 1, 1);
  flaw_is(&g.no_effect, 2, 2);
  ck_assert(g.asymmetry == 0 && g.rank == 4 && g.negative == 0);
  ck_assert(g.weight_min == 2 && g.weight_max == 3);
}

/* ---- friction bounds ------------------------------------------------------------------------- */

/* Every entry of the catalogue with several solutions, or none, stands at a friction that is not
 * below the bound; and what has critical friction 1 by hand (c01 .. c03) has it here. */
TEST(catalogue_of_failures) {
  char names[100][64], why[200];
  const int count = failures_list(TEST_DATA "/failures", names, 100);
  ck_assert_int_gt(count, 50);
  int several = 0;
  for (int k = 0; k < count; k++) {
    static failure f;
    ck_assert_msg(failure_read(TEST_DATA "/failures", names[k], &f, why), "%s: %s", names[k], why);
    if (!f.d) continue;
    const dls_diagnosis g = diagnose(f.d, f.nc, f.M, f.q, f.mu);
    ck_assert_msg(!(g.friction_unique > g.friction_critical * (1 + 1e-12)), "%s", names[k]);
    if (f.none || f.points != 1) {
      several++;
      ck_assert_msg(!(g.friction_max < g.friction_unique * (1 - 1e-12)), "%s: %g < %g", names[k],
                    g.friction_max, g.friction_unique);
    }
    if (!strncmp(names[k], "c01", 3) || !strncmp(names[k], "c02", 3)) {
      /* W = (1 1; 1 2): a c = 2 b^2, where the bound is exact */
      close_to(g.friction_unique, 1, 32 * DBL_EPSILON);
      close_to(g.friction_critical, 1, 4 * DBL_EPSILON);
      flaw_is(&g.wedged, f.mu[0] > 1, f.mu[0] > 1 ? 0 : -1);
    }
    if (!strncmp(names[k], "c13", 3)) {
      /* W_nn = 4 I, W_tt = I, W_nt = sqrt(2) times a reflection: s = 2, t = 1, h = sqrt(2). Not
       * safe for Gauss-Seidel, though the solution is unique. */
      close_to(g.friction_unique, 2 * sqrt(2), 64 * DBL_EPSILON);
      ck_assert(g.friction_max == 2 && f.points == 1 && !(f.nlgs & 1u << DLS_OK));
    }
    if (!strncmp(names[k], "c03", 3))
      ck_assert(g.rank == 1 && g.friction_unique == 0 && fabs(g.friction_critical - 1) < 1e-15);
  }
  ck_assert_int_ge(several, 8);
}

/* Solutions r of a 2D problem by enumeration that differ by more than 1e-6 of the largest; the
 * lambdas of a candidate with r = 0 are not unique, and are not counted. */
static int count_reactions(const dls_contact *p) {
  enum { N = 12, ROOM = 64 };
  double A[N * N], b[N], z[N * ROOM], r[ROOM][M];
  const int n = dls_contact_lcp_size(p), m = 2 * p->nc;
  int different = 0;
  ck_assert_int_le(n, N);
  ck_assert_int_eq(dls_contact_to_lcp(p, NULL, A, n, b, NULL), DLS_OK);
  const dls_lcp lcp = {.n = n, .M = {n, n, n, A}, .q = b};
  dls_enumeration found;
  ck_assert_int_eq(dls_lcp_enumerate(&lcp, 1e-9, ROOM, z, &found, NULL), DLS_OK);
  for (int c = 0; c < p->nc; c++)
    ck_assert(!found.undetermined[3 * c] && !found.undetermined[3 * c + 1]);
  for (int k = 0; k < found.solutions; k++) {
    ck_assert_int_eq(dls_contact_from_lcp(p, NULL, z + n * k, r[different], NULL), DLS_OK);
    int is_new = 1;
    for (int l = 0; l < different && is_new; l++) {
      double gap = 0, size = 0;
      for (int i = 0; i < m; i++) {
        gap = fmax(gap, fabs(r[l][i] - r[different][i]));
        size = fmax(size, fabs(r[l][i]));
      }
      is_new = gap > 1e-6 * size;
    }
    different += is_new;
  }
  return different;
}

/* Just below the bound there is one solution, and Lemke's method finds it; Gauss-Seidel as well, of
 * which there is no proof. */
TEST(below_the_bound_there_is_one_solution) {
  static const double skew[3] = {0, 1e-3, 0.05};
  state = 8;
  int tried = 0;
  for (int k = 0; k < 300; k++) {
    const int nc = 1 + k % 3, m = 2 * nc;
    double W[36], q[6], mu[3] = {0}, r[6];
    random_matrix(m, skew[k / 3 % 3], W, q);
    const dls_diagnosis g = diagnose(2, nc, W, q, mu);
    ck_assert(g.friction_unique <= g.friction_critical * (1 + 1e-10));
    if (!(g.friction_unique > 0)) continue;
    tried++;
    for (int c = 0; c < nc; c++) {
      mu[c] = 0.999 * g.friction_unique;
      q[2 * c] = -fabs(q[2 * c]);
    }
    const dls_contact p = {.d = 2, .nc = nc, .W = {m, m, m, W}, .q = q, .mu = mu};
    ck_assert_int_eq(count_reactions(&p), 1);
    dls_solver_settings settings = settings_with(DLS_LEMKE, default_tol);
    ck_assert_int_eq(dls_solve(&p, &settings, r, NULL, NULL, NULL), DLS_OK);
    settings.method = DLS_NLGS;
    settings.limits.max_iterations = 100000;
    ck_assert_int_eq(dls_solve(&p, &settings, r, NULL, NULL, NULL), DLS_OK);
  }
  ck_assert_int_ge(tried, 250);
}

/* r with r_n >= 0, |r_t| <= mu_c b_c instead of the cone, W symmetric: by relaxation, one unknown
 * at a time. */
static void solve_threshold(const dls_contact *p, const double *b, double *r) {
  const int m = 2 * p->nc;
  memset(r, 0, (size_t)m * sizeof *r);
  for (int sweep = 0; sweep < 3000; sweep++)
    for (int i = 0; i < m; i++) {
      double u = p->q[i];
      for (int j = 0; j < m; j++)
        u += p->W.a[i + m * j] * r[j];
      const double bound = p->mu[i / 2] * b[i / 2], x = r[i] - u / p->W.a[i + m * i];
      r[i] = i % 2 ? fmin(fmax(x, -bound), bound) : fmax(x, 0);
    }
}

/* The map b -> r_n of the sliding thresholds has the Lipschitz constant mu / mu*, in the norm of
 * the scaled problem, sum w_c b_c^2. */
TEST(fixed_points_on_the_threshold_contract) {
  state = 11;
  double largest = 0;
  for (int k = 0; k < 60; k++) {
    const int nc = 1 + k % 3, m = 2 * nc;
    double W[36], q[6], b[2][3], r[2][6], mu[3] = {0}, before = 0, after = 0;
    random_matrix(m, 0, W, q);
    const double bound = diagnose(2, nc, W, q, mu).friction_unique;
    for (int c = 0; c < nc; c++) {
      mu[c] = 0.9 * bound;
      q[2 * c] = -fabs(q[2 * c]);
      b[0][c] = 1 + noise();
      b[1][c] = b[0][c] * (1 + 0.01 * noise());
    }
    const dls_contact p = {.d = 2, .nc = nc, .W = {m, m, m, W}, .q = q, .mu = mu};
    for (int l = 0; l < 2; l++)
      solve_threshold(&p, b[l], r[l]);
    for (int c = 0; c < nc; c++) {
      const int n = 2 * c;
      const double w = 0.5 * (W[n + m * n] + W[n + 1 + m * (n + 1)]);
      before += w * pow(b[0][c] - b[1][c], 2);
      after += w * pow(r[0][n] - r[1][n], 2);
    }
    const double factor = sqrt(after / before);
    ck_assert_msg(factor <= 0.9 + 1e-6, "%g", factor);
    largest = fmax(largest, factor);
  }
  ck_assert_msg(largest > 0.8, "%g", largest);
}

/* Above W_nn / |W_nt| of one candidate: the q of src/front/diagnose.c has two solutions at
 * least. */
TEST(above_the_critical_friction_there_are_several) {
  state = 9;
  for (int k = 0; k < 60; k++) {
    const int nc = 1 + k % 3, m = 2 * nc;
    double W[36], q[6], mu[3];
    random_matrix(m, 0.05, W, q);
    for (int c = 0; c < nc; c++)
      mu[c] = 0;
    const dls_diagnosis g = diagnose(2, nc, W, q, mu);
    const int n = 2 * g.critical, t = n + 1;
    ck_assert_int_ge(g.critical, 0);
    for (int c = 0; c < nc; c++)
      mu[c] = 1.001 * g.friction_critical;
    const double e = W[n + m * t] > 0 ? -1 : 1, r_t = e * mu[0];
    for (int i = 0; i < m; i++)
      q[i] = i == t            ? -e - (W[i + m * n] + W[i + m * t] * r_t)
             : i == n || i % 2 ? -(W[i + m * n] + W[i + m * t] * r_t)
                               : 100 * (1 + mu[0]);
    const dls_contact p = {.d = 2, .nc = nc, .W = {m, m, m, W}, .q = q, .mu = mu};
    ck_assert_int_ge(count_reactions(&p), 2);
  }
}

/* 3D, one candidate: the local solver counts its solutions. Above the bound some have three. */
TEST(one_candidate_in_3d_has_one_solution_below_the_bound) {
  state = 10;
  int several = 0;
  for (int k = 0; k < 20000; k++) {
    double B[9], W[9], r[3], q[3];
    for (int i = 0; i < 9; i++)
      B[i] = noise();
    for (int i = 0; i < 9; i++) {
      W[i] = i % 4 == 0 ? 0.01 : 0;
      for (int l = 0; l < 3; l++)
        W[i] += B[i % 3 + 3 * l] * B[i / 3 + 3 * l];
    }
    for (int i = 0; i < 3; i++)
      q[i] = noise();
    q[0] = -fabs(q[0]);
    const double zero = 0;
    const dls_diagnosis g = diagnose(3, 1, W, q, &zero);
    int count;
    ck_assert(dlsi_nlgs_local(3, W, q, 0.999 * g.friction_unique, r, &count) != DLS_LOCAL_NONE);
    ck_assert_int_eq(count, 1);
    (void)dlsi_nlgs_local(3, W, q, 20 * g.friction_unique, r, &count);
    several += count > 1;
  }
  ck_assert_int_gt(several, 0);
}

/* ---- limit, bad input, memory ---------------------------------------------------------------- */

static double W2[16] = {4, 1, 1, 0, 1, 3, 0, 1, 1, 0, 4, -1, 0, 1, -1, 3};
static double q2[4] = {-1, 2, 3, -4}, mu2[2] = {0.5, 0.25};

static dls_contact dense2(void) {
  return (dls_contact){.d = 2, .nc = 2, .W = {4, 4, 4, W2}, .q = q2, .mu = mu2};
}

TEST(too_large_is_said) {
  const dls_contact p = dense2();
  dls_diagnosis g, h;
  ck_assert_int_eq(dls_contact_diagnose(&p, 4, &g, NULL), DLS_OK);
  ck_assert(g.spectrum == 1 && g.rank == 4);
  ck_assert_int_eq(dls_contact_diagnose(&p, 3, &h, NULL), DLS_OK);
  ck_assert(h.spectrum == 0 && h.rank == -1 && h.negative == -1);
  ck_assert(h.noise == 0 && h.largest == 0 && h.smallest == 0 && h.smallest_positive == 0);
  ck_assert(h.friction_unique == 0 && h.friction_critical == g.friction_critical);
  ck_assert(h.asymmetry == g.asymmetry && h.weight_max == g.weight_max);
}

TEST(the_same_bits_twice) {
  const dls_contact p = dense2();
  dls_diagnosis g, h;
  ck_assert_int_eq(dls_contact_diagnose(&p, 4, &g, NULL), DLS_OK);
  ck_assert_int_eq(dls_contact_diagnose(&p, 4, &h, NULL), DLS_OK);
  same_bits(&g, &h);
}

/* An error names the slot and leaves the diagnosis alone. */
static void refuses(const dls_contact *p, int limit, dls_status status, const char *argument,
                    long long index) {
  dls_diagnosis g, before;
  memset(&g, 0x5a, sizeof g);
  memcpy(&before, &g, sizeof g);
  dls_error e = {0};
  ck_assert_int_eq(dls_contact_diagnose(p, limit, &g, &e), status);
  ck_assert_str_eq(e.argument, argument);
  ck_assert_int_eq(e.index, index);
  ck_assert_str_eq(e.function, "dls_contact_diagnose");
  ck_assert_mem_eq(&g, &before, sizeof g);
}

TEST(no_candidates) {
  const dls_contact p = {.d = 3};
  dls_diagnosis g;
  ck_assert_int_eq(dls_contact_diagnose(&p, 10, &g, NULL), DLS_OK);
  ck_assert(g.spectrum && g.rank == 0 && g.negative == 0 && g.friction_unique > 1e300);
  ck_assert(g.friction_max == 0 && g.closing == 0 && g.no_effect.count == 0);
}

TEST(bad_input_is_named) {
  dls_contact p = dense2();
  refuses(NULL, 10, DLS_E_ARGUMENT, "problem", -1);
  refuses(&p, -1, DLS_E_ARGUMENT, "limit", -1);
  p.d = 4;
  refuses(&p, 10, DLS_E_ARGUMENT, "d", -1);
  p = dense2(), p.nc = -1;
  refuses(&p, 10, DLS_E_SIZE, "nc", -1);
  p = dense2(), p.W.a = NULL;
  refuses(&p, 10, DLS_E_ARGUMENT, "W", -1);
  p = dense2(), p.q = NULL;
  refuses(&p, 10, DLS_E_ARGUMENT, "q", -1);
  p = dense2(), p.mu = NULL;
  refuses(&p, 10, DLS_E_ARGUMENT, "mu", -1);
  double W[16], q[4], mu[2];
  for (int k = 0; k < 16; k++) {
    memcpy(W, W2, sizeof W);
    W[k] = k % 2 ? NAN : INFINITY;
    p = dense2(), p.W.a = W;
    refuses(&p, 10, DLS_E_NOT_FINITE, "W", k);
  }
  for (int k = 0; k < 4; k++) {
    memcpy(q, q2, sizeof q);
    q[k] = NAN;
    p = dense2(), p.q = q;
    refuses(&p, 10, DLS_E_NOT_FINITE, "q", k);
  }
  for (int k = 0; k < 2; k++) {
    memcpy(mu, mu2, sizeof mu);
    mu[k] = -1;
    p = dense2(), p.mu = mu;
    refuses(&p, 10, DLS_E_ARGUMENT, "mu", k);
  }
  p = dense2();
  REFUSES(ARGUMENT, "diagnosis", -1, dls_contact_diagnose, &p, 10, NULL);
}

TEST(each_failing_malloc_unwinds) {
  const int i[2] = {0, 1}, s[3] = {0, 1, 2};
  const double x[8] = {2, 1, 1, 2, 3, 0, 0, 3};
  for (int blocks = 0; blocks < 2; blocks++) {
    dls_contact p = dense2();
    if (blocks) p.W = (dls_dense){0}, p.Wb = (dls_blocks){2, 2, s, i, x};
    dls_diagnosis g, before;
    dls_error e = {0};
    memset(&g, 0x5a, sizeof g);
    memcpy(&before, &g, sizeof g);
    MALLOCS_FAIL(dls_contact_diagnose(&p, 10, &g, &e),
                 e.status == DLS_E_MEMORY && memcmp(&g, &before, sizeof g) == 0, DLS_OK, 6);
    ck_assert_int_eq(mallocs_failed, 6); /* scale, work, lists, value, A, pivot */
  }
}

/* An unsymmetric W needs the first nine mallocs, among them r and the transpose. */
TEST(each_failing_malloc_of_unsymmetric_ones) {
  double W[16];
  memcpy(W, W2, sizeof W);
  W[1] = 0;
  dls_contact p = dense2();
  p.W.a = W;
  for (long k = 1; k <= 9; k++) {
    dls_diagnosis g;
    malloc_fails_at(k);
    const dls_status status = dls_contact_diagnose(&p, 10, &g, NULL);
    malloc_fails_at(0);
    ck_assert_msg(status == DLS_E_MEMORY, "%ld: %d", k, status);
  }
}

/* A candidate with an unsymmetric W that has an answer, and none with its transpose; and bodies
 * that move apart. */
TEST(hints) {
  const double rows[] = {1, -2, -0.6, 1}, apart[] = {1, 0}, pressed[] = {-1, 0}, mu[] = {1};
  const double columns[] = {1, -0.6, -2, 1};
  dls_diagnosis g;
  dls_contact p = {.d = 2, .nc = 1, .W = {2, 2, 2, rows}, .q = apart, .mu = mu};
  ck_assert_int_eq(dls_contact_diagnose(&p, 10, &g, NULL), DLS_OK);
  ck_assert_int_eq(g.hints, DLS_HINT_OUTWARD);
  p.q = pressed;
  for (int turned = 0; turned < 2; turned++) {
    double r[2];
    p.W.a = turned ? columns : rows;
    const int solved = dls_solve(&p, NULL, r, NULL, NULL, NULL) == DLS_OK;
    ck_assert_int_eq(dls_contact_diagnose(&p, 10, &g, NULL), DLS_OK);
    ck_assert_int_eq(solved, !turned);
    ck_assert_int_eq(g.hints, solved ? 0 : DLS_HINT_TRANSPOSED);
    ck_assert_int_eq(dls_contact_diagnose(&p, 1, &g, NULL), DLS_OK); /* beyond the limit */
    ck_assert_int_eq(g.hints, 0);
  }
  dls_blocks B;
  int start[2], row[1];
  double x[4];
  ck_assert_int_eq(dls_blocks_from_dense(&p.W, 2, start, row, x, &B, NULL), DLS_OK);
  const dls_contact by_blocks = {.d = 2, .nc = 1, .Wb = B, .q = pressed, .mu = mu};
  ck_assert_int_eq(dls_contact_diagnose(&by_blocks, 10, &g, NULL), DLS_OK);
  ck_assert_int_eq(g.hints, DLS_HINT_TRANSPOSED);
}
