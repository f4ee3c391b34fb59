/* test_number.c: norms to the last entry and beyond the range of squares, drawn
 * numbers, whole numbers. */
#include "contact/contact.h"
#include "run.h"

/* The largest entry, NaN or infinity is found wherever it stands, beside the last four, too. */
TEST(the_largest_anywhere) {
  double x[14];
  for (size_t n = 1; n <= 13; n++)
    for (size_t at = 0; at < n; at++) {
      for (size_t i = 0; i < 14; i++)
        x[i] = i < n ? (i % 2 ? -1. : 1.) - (double)i / 64 : NAN; /* none reads beyond n */
      x[at] = -8;
      ck_assert(dlsi_max_abs(x, n) == 8);
      x[at] = NAN;
      ck_assert_double_nan(dlsi_max_abs(x, n));
      x[at] = -INFINITY;
      ck_assert(dlsi_max_abs(x, n) == INFINITY);
      for (size_t i = 0; i < n; i++)
        x[i] = INFINITY; /* many of them are no NaN */
      ck_assert(dlsi_max_abs(x, n) == INFINITY);
      x[at] = NAN;
      ck_assert_double_nan(dlsi_max_abs(x, n));
    }
  ck_assert(dlsi_max_abs(x, 0) == 0);
}

/* |(3, 4)| = 5 at both ends of the range, exactly. */
TEST(norms_at_the_ends_of_the_range) {
  for (int e = -1074; e <= 1021; e++) {
    const double x[3] = {ldexp(3, e), 0, ldexp(-4, e)};
    ck_assert(dlsi_norm2(x, 3) == ldexp(5, e));
    ck_assert(dlsi_norm2(x, 1) == ldexp(3, e));
  }
  const double huge[3] = {DBL_MAX, DBL_MAX, 1}, endless[3] = {1, -INFINITY, 1};
  const double lost[4] = {INFINITY, NAN, 0x1p1000, 1}, none[2] = {0, -0.0};
  ck_assert(dlsi_norm2(huge, 1) == DBL_MAX);
  ck_assert(dlsi_norm2(huge, 2) == DBL_MAX); /* the norm itself is beyond the range */
  ck_assert(dlsi_norm2(endless, 3) == INFINITY);
  ck_assert_double_nan(dlsi_norm2(lost, 4));
  ck_assert(dlsi_norm2(none, 2) == 0);
}

/* The published beginning of splitmix64 from 0. */
TEST(drawn_numbers_are_those_of_splitmix64) {
  static const uint64_t first[3] = {0xe220a8397b1dcdaf, 0x6e789e6aa1b965f4, 0x06c45d188009454f};
  for (int i = 0; i < 3; i++) {
    const uint64_t x = ((uint64_t)i + 1) * DLSI_GOLDEN_BITS;
    ck_assert(dlsi_mix(x) == first[i]);
    ck_assert(dlsi_draw(x) == ldexp((double)(first[i] >> 11), -53));
    ck_assert(dlsi_draw_entry(0, i + 1) == dlsi_draw(x));
  }
  ck_assert(dlsi_draw_entry(5, 7) == dlsi_draw((((uint64_t)5 << 32) + 7) * DLSI_GOLDEN_BITS));
}

/* Digits alone, within the range; the place behind them. */
TEST(whole_numbers) {
  static const struct {
    const char *text;
    int least, most, value, taken; /* taken: characters, 0: refused */
  } cases[] = {{"12x", 1, 99, 12, 2},
               {"007", 1, 7, 7, 3},
               {"2147483647", 0, INT_MAX, INT_MAX, 10},
               {"2147483648", 0, INT_MAX, 0, 0},
               {"4294967298", 0, INT_MAX, 0, 0},
               {"18446744073709551618", 0, INT_MAX, 0, 0},
               {"340282366920938463463374607431768211458", 0, INT_MAX, 0, 0},
               {"0", 1, 9, 0, 0},
               {"0", 0, 0, 0, 1},
               {"10", 0, 9, 0, 0},
               {"", 0, 9, 0, 0},
               {" 1", 0, 9, 0, 0},
               {"+1", 0, 9, 0, 0},
               {"-1", 0, 9, 0, 0},
               {"x1", 0, 9, 0, 0}};
  for (size_t k = 0; k < sizeof cases / sizeof *cases; k++) {
    const char *at = cases[k].text;
    int value = -7;
    const int taken = dlsi_read_whole(&at, cases[k].least, cases[k].most, &value);
    ck_assert_int_eq(taken, cases[k].taken > 0);
    ck_assert_int_eq((int)(at - cases[k].text), cases[k].taken);
    ck_assert_int_eq(value, taken ? cases[k].value : -7);
  }
}
