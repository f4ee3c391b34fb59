/* test_exact.c: sums of products without rounding, cones to the last bit, vectors near a proof. */
#include "contact/exact.h"
#include "run.h"

/* ---- sums ------------------------------------------------------------------------------------ */

/* A factor 2^high + side 2^low of up to 53 bits. */
typedef struct factor {
  int high, low, side;
} factor;

static double value_of(factor f) {
  return ldexp(1, f.high) + f.side * ldexp(1, f.low);
}

/* sum := sum + turn a b c. */
static void add_product(dlsi_exact *sum, int turn, const factor f[3]) {
  dlsi_exact_add(sum, turn * value_of(f[0]), value_of(f[1]), value_of(f[2]));
}

/* sum := sum + turn a b c, multiplied out: eight powers of two. */
static void add_powers(dlsi_exact *sum, int turn, const factor f[3]) {
  for (int k = 0; k < 8; k++) {
    double power[3];
    for (int i = 0; i < 3; i++)
      power[i] = k >> i & 1 ? f[i].side * ldexp(1, f[i].low) : ldexp(1, f[i].high);
    dlsi_exact_add(sum, turn * power[0], power[1], power[2]);
  }
}

/* a b c less its eight powers of two is 0, and the least number of the sum's range decides then;
 * at every place within a digit, from the least doubles to the largest. */
TEST(products_are_exact) {
  static const factor some[6] = {{53, 0, -1}, {52, 0, 1}, {52, 1, -1},
                                 {32, 0, -1}, {33, 0, 1}, {52, 32, 1}};
  const double least = DBL_TRUE_MIN;
  for (int of = 0; of < 6 * 6 * 6; of++)
    for (int e = -1074; e <= 970; e += of % 7 == 0 ? 7 : 511) { /* to 2^1023 */
      factor f[3] = {some[of % 6], some[of / 6 % 6], some[of / 36]};
      for (int i = 0; i < 3; i++) {
        f[i].high += e;
        f[i].low += e;
      }
      for (int turn = -1; turn <= 1; turn += 2) {
        dlsi_exact sum;
        dlsi_exact_clear(&sum);
        add_product(&sum, turn, f);
        ck_assert_int_eq(dlsi_exact_sign(&sum), turn);
        dlsi_exact_add(&sum, -turn * least, least, least);
        add_powers(&sum, -turn, f);
        ck_assert_int_eq(dlsi_exact_sign(&sum), -turn);
        dlsi_exact_add(&sum, least, turn * least, least);
        ck_assert_int_eq(dlsi_exact_sign(&sum), 0);
      }
    }
}

/* Of denormal numbers, which have fewer bits: x x (2^80 x) = (2^40 x) (2^40 x) x; and the largest
 * products that there are. */
TEST(products_at_the_ends_of_the_range) {
  const double least = DBL_TRUE_MIN;
  dlsi_exact sum;
  for (int bits = 1; bits <= 53; bits++) {
    const double x = (ldexp(1, bits) - 1) * least;
    dlsi_exact_clear(&sum);
    dlsi_exact_add(&sum, x, -x, ldexp(x, 80));
    ck_assert_int_eq(dlsi_exact_sign(&sum), -1);
    dlsi_exact_add(&sum, ldexp(x, 40), ldexp(x, 40), x);
    ck_assert_int_eq(dlsi_exact_sign(&sum), 0);
    dlsi_exact_add(&sum, least, least, least);
    ck_assert_int_eq(dlsi_exact_sign(&sum), 1);
  }
  dlsi_exact_clear(&sum);
  ck_assert_int_eq(dlsi_exact_sign(&sum), 0);
  for (int k = 0; k < 2; k++)
    dlsi_exact_add(&sum, DBL_MAX, -DBL_MAX, DBL_MAX / 2);
  ck_assert_int_eq(dlsi_exact_sign(&sum), -1);
  dlsi_exact_add(&sum, DBL_MAX, DBL_MAX, DBL_MAX);
  ck_assert_int_eq(dlsi_exact_sign(&sum), 0);
  dlsi_exact_add(&sum, 0, DBL_MAX, DBL_MAX); /* a factor 0 */
  dlsi_exact_add(&sum, DBL_MAX, 0, DBL_MAX);
  dlsi_exact_add(&sum, DBL_MAX, DBL_MAX, -0.0);
  ck_assert_int_eq(dlsi_exact_sign(&sum), 0);
}

/* Carries are done before 2^30 pending products of digits below 2^32 overflow 64 bits. */
TEST(carries_are_done_in_time) {
  dlsi_exact sum;
  dlsi_exact_clear(&sum);
  sum.pending = (1 << 30) - 2;
  dlsi_exact_add(&sum, 1, 1, 1);
  ck_assert_int_eq(sum.pending, (1 << 30) - 1);
  dlsi_exact_add(&sum, -1, 1, 1);
  ck_assert_int_eq(sum.pending, 0);
  ck_assert_int_eq(dlsi_exact_sign(&sum), 0);
}

/* ---- proofs of no solution ------------------------------------------------------------------- */

/* Two candidates; g = sum_a v_a (row n of W_a0) = v_0 (N[0], T[0], S[0]) + v_1 (N[1], T[1], S[1]);
 * the columns of candidate 1 are 0. */
static int is_proof(int d, double mu, const double N[2], const double T[2], const double S[2],
                    const double q[2], const double v[2]) {
  const int ld = 2 * d + 1;
  double W[42] = {0}, load[6] = {0}, friction[2] = {mu, mu};
  const double *const row[3] = {N, T, S};
  for (int j = 0; j < d; j++)
    for (int a = 0; a < 2; a++) {
      W[d * a + ld * j] = row[j][a];
      load[d * a] = q[a];
    }
  const dls_contact p = {.d = d, .nc = 2, .W = {2 * d, 2 * d, ld, W}, .q = load, .mu = friction};
  return dlsi_contact_is_infeasible(&p, v);
}

static const double zero[2] = {0, 0}, pressed[2] = {-1, 0};

/* The border g_n + mu |g_t| = 0 belongs to it; one unit of the last place beyond does not. */
TEST(cones_to_the_last_bit_2d) {
  const double v[2] = {1, 0x1p-60};
  for (int side = -1; side <= 1; side += 2) {
    const double T[2] = {side * 2, side * 2};
    for (int k = -1; k <= 1; k++) {
      const double N[2] = {-1, -1 - k * DBL_EPSILON};
      ck_assert_int_eq(is_proof(2, 0.5, N, T, NULL, pressed, v), k >= 0);
    }
    ck_assert_int_eq(is_proof(2, 0.5 + DBL_EPSILON, (double[]){-1, -1}, T, NULL, pressed, v), 0);
    ck_assert_int_eq(is_proof(2, 0, zero, T, NULL, pressed, v), 1);
  }
  for (int k = -1; k <= 1; k++) /* d = 1: g_n <= 0 */
    ck_assert_int_eq(is_proof(1, 0, (double[]){-1, 0x1p60 + k * 0x1p8}, NULL, NULL, pressed, v),
                     k <= 0);
}

/* g = s (-25, 7, 24) and s = 1 + 2^-70: 25^2 = 7^2 + 24^2, with mu = 1/2 for tangents of twice the
 * size; whole numbers of 53 bits, too: (m^2 + n^2)^2 = (m^2 - n^2)^2 + (2 m n)^2. */
TEST(cones_to_the_last_bit_3d) {
  const double m = 0x1p26 - 1, n = 0x1p25 - 3, a = m * m - n * n, b = 2 * m * n, c = m * m + n * n;
  const double triple[2][3] = {{7, 24, 25}, {a, b, c}};
  for (int of = 0; of < 2; of++)
    for (int turn = 0; turn < 8; turn++)
      for (int small = 30; small <= 300; small += 45) {
        const double *const x = triple[of], v[2] = {1, ldexp(1, -small)};
        const double t = turn & 1 ? -2 : 2, s = turn & 2 ? -2 : 2;
        const int first = turn >> 2, second = 1 - first;
        const double T[2] = {t * x[first], t * x[first]}, S[2] = {s * x[second], s * x[second]};
        for (int k = -1; k <= 1; k++) {
          const double N[2] = {-x[2], -x[2] * (1 + k * 2 * DBL_EPSILON)};
          ck_assert_int_eq(is_proof(3, 0.5, N, T, S, pressed, v), k >= 0);
        }
        ck_assert_int_eq(is_proof(3, 0.5, (double[]){x[2], x[2]}, T, S, pressed, v), 0);
      }
  ck_assert_int_eq(is_proof(3, 1, zero, zero, zero, pressed, (double[]){1, 0}), 1);
  ck_assert_int_eq(is_proof(3, 1, (double[]){0x1p-500, 0}, zero, zero, pressed, (double[]){1, 0}),
                   0);
}

/* v >= 0, finite, and v.q_n < 0 without rounding. */
TEST(proofs_have_signs) {
  const double N[2] = {-1, -1}, one[2] = {1, 1};
  const double bad[] = {-1, NAN, INFINITY};
  for (int k = 0; k < 3; k++)
    for (int at = 0; at < 2; at++) {
      double v[2] = {1, 1};
      v[at] = bad[k];
      ck_assert_int_eq(is_proof(2, 0, N, zero, NULL, (double[]){-1, -1}, v), 0);
    }
  ck_assert_int_eq(is_proof(2, 0, N, zero, NULL, (double[]){-0x1p60, 0x1p60}, one), 0);
  ck_assert_int_eq(is_proof(2, 0, N, zero, NULL, (double[]){-0x1p60 - 256, 0x1p60}, one), 1);
  ck_assert_int_eq(is_proof(2, 0, N, zero, NULL, (double[]){0x1p60, -0x1p60 + 128}, one), 0);
}

/* ---- vectors near a proof -------------------------------------------------------------------- */

/* Holds at one vector alone. */
typedef struct wanted {
  size_t n;
  double v[4];
} wanted;

static int is_wanted(const void *of, const double *v) {
  const wanted *w = of;
  for (size_t i = 0; i < w->n; i++)
    if (v[i] != w->v[i]) return 0;
  return 1;
}

/* Asks for `to` near `from`; what is found takes the place of v, else v stays. */
static int finds(size_t n, const double *from, const double *to) {
  wanted w = {.n = n};
  double v[4], work[4];
  for (size_t i = 0; i < n; i++) {
    v[i] = from[i];
    w.v[i] = to[i];
  }
  const int found = dlsi_find_exact(n, v, work, is_wanted, &w);
  ck_assert_mem_eq(v, found ? to : from, n * sizeof *v);
  return found;
}

/* The vector itself; without entries below 1e-12 of the largest, or below 0. */
TEST(itself_and_without_rounding) {
  const double odd = 8 * (1 + 0x1p-45); /* of more bits than 40 */
  ck_assert(finds(2, (double[]){odd, 1e-13}, (double[]){odd, 1e-13}));
  ck_assert(finds(2, (double[]){odd, 7e-12}, (double[]){odd, 0}));
  ck_assert(finds(2, (double[]){odd, -1e-3}, (double[]){odd, 0}));
  ck_assert(!finds(2, (double[]){odd, 9e-12}, (double[]){odd, 0}));
  ck_assert(!finds(2, (double[]){0, 0}, (double[]){0, 0}));
  ck_assert(!finds(2, (double[]){0, INFINITY}, (double[]){0, INFINITY}));
}

/* Fractions over the largest entry, to whole numbers up to 2^31, in lowest terms. */
TEST(whole_numbers) {
  const double pi = 3.14159265358979;
  ck_assert(finds(3, (double[]){pi, pi * 3 / 14, pi * 5 / 6}, (double[]){42, 9, 35}));
  ck_assert(finds(3, (double[]){pi * 5 / 6, 0, pi}, (double[]){5, 0, 6}));
  ck_assert(finds(4, (double[]){pi, pi / 3, pi / 9, pi * 8 / 9}, (double[]){9, 3, 1, 8}));
  ck_assert(finds(2, (double[]){pi, pi * 0x1p-31}, (double[]){0x1p31, 1}));
  ck_assert(!finds(2, (double[]){pi, pi * 0x1p-32}, (double[]){0x1p32, 1}));
  ck_assert(finds(3, (double[]){pi, pi * 0x1p-16, pi * 0x1p-31}, (double[]){0x1p31, 0x1p15, 1}));
  ck_assert(!finds(3, (double[]){pi, pi * 0x1p-16, pi * 0x1p-32}, (double[]){0x1p32, 0x1p16, 1}));
}

/* 0.785.. = pi / 4 and 0.3 in binary digits of the largest entry, and eight times as much. */
TEST(few_digits) {
  static const int bits[8] = {53, 40, 30, 20, 12, 8, 5, 3};
  static const double digits[8][2] = {{7074237752028440, 2702159776422298},
                                      {863554413089, 329853488333},
                                      {843314857, 322122547},
                                      {823550, 314573},
                                      {3217, 1229},
                                      {201, 77},
                                      {25, 10},
                                      {6, 2}};
  for (int k = 0; k < 8; k++)
    for (int e = 0; e <= 3; e += 3) {
      const double v[2] = {ldexp(0.7853981633974483, e), ldexp(0.3, e)};
      const double to[2] = {ldexp(digits[k][0], e - bits[k]), ldexp(digits[k][1], e - bits[k])};
      ck_assert(finds(2, v, to));
      ck_assert(finds(2, (double[]){v[1], v[0]}, (double[]){to[1], to[0]}));
      ck_assert(!finds(2, v, (double[]){to[0], to[1] + ldexp(1, e - bits[k])}));
    }
}
