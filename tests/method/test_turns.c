/* test_turns.c: which variant is the fastest (vi/sweep/turns.c), on variants with known rates. */
#include "run.h"
#include "vi/vi_internal.h"

/* Each way brings the residual down by its rate a sweep, five sweeps at a time; the third one
 * alone as long as the residual is below `turn`. Returns the sweeps to 1e-8; way: those of each. */
static int sweeps_of(int ways, const double *rate, double turn, int *way) {
  dlsi_turns turns;
  double residual = 1;
  int sweeps = 0;
  dlsi_turns_start(&turns, ways);
  for (int k = 0; k < dlsi_most_ways; k++)
    way[k] = 0;
  while (residual > 1e-8 && sweeps < 1000000) {
    const int now = turns.now;
    if (residual > turn || now == 2)
      for (int k = 0; k < 5; k++)
        residual *= rate[now];
    way[now] += 5;
    sweeps += 5;
    (void)dlsi_turns_advance(&turns, residual, 5);
  }
  return sweeps;
}

/* A way that halves the residual in less than the first price goes on to the end, whatever the
 * others might do. */
TEST(quick_way_stays) {
  const double rate[] = {0.99, 0.5, 0.5};
  int way[dlsi_most_ways];
  ck_assert_int_eq(sweeps_of(3, rate, 0, way), 1835); /* .99^1835 = 9.8e-9 */
  ck_assert_int_eq(way[0], 1835);
}

/* Of a slow one and others that get nowhere each of the others has its turns; they take less than
 * the slow one does in all. */
TEST(vain_ways_are_left) {
  const double rate[] = {1, 0.999, 1};
  int way[dlsi_most_ways];
  const int sweeps = sweeps_of(3, rate, 0, way);
  ck_assert_int_eq(way[1], 18415); /* .999^18415 = 1e-8 */
  ck_assert_int_lt(sweeps, 2 * way[1]);
  ck_assert(way[0] > 0 && way[2] > 0);
}

/* The one way that helps near the end is found there. */
TEST(ways_are_tried_again) {
  const double rate[] = {0.98, 0.999, 0.99};
  int way[dlsi_most_ways];
  const int sweeps = sweeps_of(3, rate, 1e-4, way);
  ck_assert_int_eq(way[0], 460 + 150); /* .98^460 = 9.2e-5, and its patience */
  ck_assert_int_eq(way[1], 150);
  ck_assert_int_eq(sweeps - way[0] - way[1], 910); /* .99^910 = 1.1e-4 */
}

/* Where all are slow, the one that gets farthest in its turns has nearly all
 * of the sweeps. */
TEST(slow_ways_are_compared) {
  const double rate[] = {0.9998, 0.9995, 0.9999};
  int way[dlsi_most_ways];
  const int sweeps = sweeps_of(3, rate, 0, way);
  ck_assert_int_gt(15 * way[1], 14 * sweeps);
  ck_assert(way[0] > 0 && way[2] > 0);
}

/* A way alone goes on without end. */
TEST(one_way_has_no_other) {
  const double rate[] = {1, 0, 0};
  int way[dlsi_most_ways];
  ck_assert_int_eq(sweeps_of(1, rate, 0, way), 1000000);
  ck_assert_int_eq(way[0], 1000000);
}
