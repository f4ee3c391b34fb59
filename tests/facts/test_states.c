/* test_states.c: all states of small contact problems by hand: the list, its order, and the result
 * of auto's search through them. */
#include "delassus.h"
#include "facts/facts.h"
#include "run.h"

enum { most_nc = 8, most_m = 2 * most_nc, room = 32 };

typedef struct small_problem {
  double W[most_m * most_m], q[most_m], mu[most_nc];
  dls_contact p;
} small_problem;

static small_problem t;
static double r[room * most_m], low[room * most_m], high[room * most_m];
static dls_solution_set set;

static void set_small(int nc) {
  const int m = 2 * nc;
  t = (small_problem){.p = {.d = 2, .nc = nc, .W = {m, m, m, t.W}, .q = t.q, .mu = t.mu}};
  memset(&set, 0x55, sizeof set);
  for (int k = 0; k < room * most_m; k++)
    r[k] = low[k] = high[k] = 77;
}

/* Sets W_cc (by columns), q_c and mu_c. */
static void set_candidate(int c, const double *W, const double *q, double mu) {
  for (int e = 0; e < 4; e++)
    t.W[2 * c + e % 2 + t.p.W.ld * (2 * c + e / 2)] = W[e];
  t.q[2 * c] = q[0];
  t.q[2 * c + 1] = q[1];
  t.mu[c] = mu;
}

/* |x_i - y_i| <= tol size */
static void close_values(const double *x, const double *y, int n, double size, double tol) {
  for (int i = 0; i < n; i++)
    ck_assert_msg(fabs(x[i] - y[i]) <= tol * size, "%d: %.17g, not %.17g", i, x[i], y[i]);
}

static dls_status list_states(int capacity) {
  return dls_contact_enumerate(&t.p, 1e-8, capacity, r, low, high, &set, NULL);
}

static void expect_set(int isolated, int continua, int states) {
  ck_assert_int_eq(set.isolated, isolated);
  ck_assert_int_eq(set.continua, continua);
  ck_assert_int_eq(set.states, states);
}

/* W = (1 1; 1 2), q = (1, 4), mu = 2: free r = 0; sticks r = -W^-1 q = (2, -3); slips r = (1, -2),
 * u = (0, 1). */
static const double three_W[4] = {1, 1, 1, 2}, three_q[2] = {1, 4};
static const double three_r[3][2] = {{0, 0}, {2, -3}, {1, -2}};

/* W_nn + mu W_nt = 0: r = 0 alone, u = (0, 1), and r = s (1, 1), s >= 1, u = (0, 1 - s). At r = 0
 * the candidate is free or slips to the left, at r = (1, 1) it sticks or slips to the right. */
TEST(one_beside_a_ray) {
  const double W[4] = {1, -2, -1, 1}, q[2] = {0, 1};
  for (int unit = -8; unit <= 8; unit += 8) { /* 2^unit: reactions in another unit */
    set_small(1);
    set_candidate(0, W, q, 1);
    for (int k = 0; k < 4; k++)
      t.W[k] = ldexp(t.W[k], -unit);
    ck_assert_int_eq(list_states(2), DLS_OK);
    expect_set(1, 1, 4);
    ck_assert(r[0] == 0 && r[1] == 0 && low[0] == 0 && high[1] == 0);
    const double s = ldexp(1, unit);
    close_values(low + 2, (const double[]){s, s}, 2, s, 1e-12);
    ck_assert(high[2] == INFINITY && high[3] == INFINITY);
    ck_assert(r[2] >= 0.999 * s && r[3] == r[2]);
    ck_assert(r[4] == 77 && low[4] == 77 && high[4] == 77);
  }
  set_small(1);
  set_candidate(0, W, q, 1);
  ck_assert_int_eq(list_states(1), DLS_MAX_ITERATIONS);
  expect_set(1, 1, 4);
  ck_assert(r[0] == 0 && r[2] == 77 && low[2] == 77 && high[2] == 77);
}

/* The same with q = (0, -1): the ray r = s (1, 1), s >= 0, u = (0, -1 - s), begins where the free
 * candidate slides as well. */
TEST(a_ray_from_free) {
  for (int nc = 1; nc <= 2; nc++) {
    set_small(nc);
    for (int c = 0; c < nc; c++)
      set_candidate(c, (const double[]){1, -2, -1, 1}, (const double[]){0, -1}, 1);
    ck_assert_int_eq(list_states(1), DLS_OK);
    expect_set(0, 1, nc == 1 ? 2 : 4);
    for (int k = 0; k < 2 * nc; k++)
      ck_assert(r[k] == 0 && low[k] == 0 && high[k] == INFINITY);
  }
}

/* Beside a candidate with three solutions: three, then three rays, each with one of these. */
TEST(three_beside_three_rays) {
  set_small(2);
  set_candidate(0, (const double[]){1, -2, -1, 1}, (const double[]){0, 1}, 1);
  set_candidate(1, three_W, three_q, 2);
  ck_assert_int_eq(list_states(6), DLS_OK);
  expect_set(3, 3, 12);
  for (int k = 0; k < 6; k++) {
    const double *at = three_r[k % 3];
    close_values(r + 4 * k + 2, at, 2, 1, 1e-13);
    close_values(low + 4 * k, (const double[]){k / 3, k / 3, at[0], at[1]}, 4, 1, 1e-13);
    close_values(high + 4 * k + 2, at, 2, 1, 1e-13);
    ck_assert(k < 3 ? high[4 * k] == 0 && high[4 * k + 1] == 0
                    : high[4 * k] == INFINITY && high[4 * k + 1] == INFINITY);
  }
  for (int capacity = 1; capacity < 6; capacity++) {
    r[4 * capacity] = low[4 * capacity] = high[4 * capacity] = 77;
    ck_assert_int_eq(list_states(capacity), DLS_MAX_ITERATIONS);
    ck_assert(r[4 * capacity] == 77 && low[4 * capacity] == 77 && high[4 * capacity] == 77);
  }
}

/* W_tt = (1 1; 1 1), r_n = (1, 1), r_t = (s, -s) for -1 <= s <= 1 = mu: both stick, which is first
 * in the list of states; at either end one slips, or the other, or both. */
TEST(two_supports_push_each_other) {
  set_small(2);
  for (int c = 0; c < 2; c++)
    set_candidate(c, (const double[]){1, 0, 0, 1}, (const double[]){-1, 0}, 1);
  t.W[1 + 4 * 3] = t.W[3 + 4 * 1] = 1;
  ck_assert_int_eq(list_states(1), DLS_OK);
  expect_set(0, 1, 7);
  close_values(low, (const double[]){1, -1, 1, -1}, 4, 1, 1e-12);
  close_values(high, (const double[]){1, 1, 1, 1}, 4, 1, 1e-12);
}

/* Two supports of a bar without friction, W_nn = (1 1; 1 1), q_n = -2: r_1 + r_2 = 2, either at
 * least 0; by states both press, or one alone with the other at its border. The forces of the
 * second one in another unit: r_1 + r_2 / 4 = 2. */
TEST(two_supports_share_a_load) {
  const double W[4] = {1, 0, 0, 1}, q[2] = {-2, 0}, V[4] = {0.0625, 0, 0, 0.0625};
  const double other[2] = {-0.5, 0};
  for (int k = 0; k < 2; k++) {
    set_small(2);
    set_candidate(0, W, q, 0);
    set_candidate(1, k ? V : W, k ? other : q, 0);
    t.W[2] = t.W[8] = k ? 0.25 : 1;
    ck_assert_int_eq(list_states(1), DLS_OK);
    expect_set(0, 1, 3);
    close_values(low, (const double[]){0, 0, 0, 0}, 4, 2, 1e-12);
    close_values(high, (const double[]){2, 0, k ? 8 : 2, 0}, 4, 2, 1e-12);
    ck_assert(r[4] == 77);
  }
}

/* Three candidates apart with three solutions each, which are of 27 states; the first candidate's
 * state changes first, in the order free, sticks, slips. */
TEST(solutions_of_three_apart) {
  set_small(3);
  for (int c = 0; c < 3; c++)
    set_candidate(c, three_W, three_q, 2);
  ck_assert_int_eq(list_states(27), DLS_OK);
  expect_set(27, 0, 27);
  for (int k = 0; k < 27; k++)
    for (int c = 0, l = k; c < 3; c++, l /= 3) {
      close_values(r + 6 * k + 2 * c, three_r[l % 3], 2, 1, 1e-13);
      ck_assert_mem_eq(low + 6 * k + 2 * c, r + 6 * k + 2 * c, 2 * sizeof *r);
      ck_assert_mem_eq(high + 6 * k + 2 * c, r + 6 * k + 2 * c, 2 * sizeof *r);
    }
  ck_assert(r[6 * 27] == 77);
  ck_assert_int_eq(list_states(26), DLS_MAX_ITERATIONS);
}

/* Beside one without friction, which is pressed, whose u_n = 0 at r = 0 as free and as slipping, or
 * which opens; in either order. Its u_t is no unknown, and its W_tt = -4 no matter. */
TEST(a_candidate_without_friction) {
  static const double W[4] = {8, 3, 5, -4};
  for (int kind = 0; kind < 3; kind++)
    for (int c = 0; c < 2; c++) {
      const double q[2] = {kind == 0 ? -16 : kind == 1 ? 0 : 1, -1};
      set_small(2);
      set_candidate(c, W, q, 0);
      set_candidate(1 - c, three_W, three_q, 2);
      ck_assert_int_eq(list_states(4), DLS_OK);
      expect_set(3, 0, kind == 1 ? 6 : 3);
      for (int k = 0; k < 3; k++) {
        close_values(r + 4 * k + 2 * c, (const double[]){kind ? 0 : 2, 0}, 2, 1, 1e-13);
        close_values(r + 4 * k + 2 * (1 - c), three_r[k], 2, 1, 1e-13);
      }
    }
}

/* The mirror image t -> -t has the mirrored solutions, in any unit of W three. */
TEST(either_side) {
  for (int power = -40; power <= 40; power += 40) {
    const double w = ldexp(1, power), W[4] = {w, -w, -w, 2 * w}, q[2] = {1, -4};
    set_small(1);
    set_candidate(0, W, q, 2);
    ck_assert_int_eq(list_states(3), DLS_OK);
    expect_set(3, 0, 3);
    for (int k = 0; k < 3; k++)
      close_values(r + 2 * k, (const double[]){three_r[k][0] / w, -three_r[k][1] / w}, 2, 1 / w,
                   1e-13);
  }
}

/* A wedge on the border of the cone: r = (2, 2 mu) sticks and slips, one solution of two states. */
TEST(border_between_two_states) {
  const double W[4] = {4, 0, 0, 4}, q[2] = {-8, -4};
  for (int side = -1; side <= 1; side += 2) {
    set_small(1);
    set_candidate(0, W, q, 0.5);
    t.q[1] *= side;
    ck_assert_int_eq(list_states(1), DLS_OK);
    expect_set(1, 0, 2);
    close_values(r, (const double[]){2, side}, 2, 1, 1e-14);
  }
}

/* No u_n >= 0 with W_nn = -1; u_n = -1 + r_n + 4 r_t < 0 where r_t has to be negative; and two
 * candidates of which one has three solutions: each is refuted. */
TEST(no_solution_is_proved) {
  static const double W[2][4] = {{-1, 0, 0, 1}, {1, 2, 2, 1}};
  static const double q[2][2] = {{-1, 0}, {-1, 1}};
  for (int k = 0; k < 2; k++)
    for (int nc = 1; nc <= 2; nc++) {
      set_small(nc);
      set_candidate(0, W[k], q[k], 1);
      if (nc == 2) set_candidate(1, three_W, three_q, 2);
      ck_assert_int_eq(list_states(1), DLS_NO_SOLUTION);
      expect_set(0, 0, 0);
      ck_assert(r[0] == 77);
    }
}

/* u_n0 + u_n1 = -2 whatever r is: the sum of two rows refutes each choice of states. */
TEST(no_solution_of_two_together) {
  for (int k = 0; k < 3; k++) {
    set_small(2);
    for (int c = 0; c < 2; c++)
      set_candidate(c, (const double[]){1, 0, 0, 1}, (const double[]){-1, 0}, 2 * k);
    t.W[2] = t.W[8] = -1;
    ck_assert_int_eq(list_states(1), DLS_NO_SOLUTION);
    expect_set(0, 0, 0);
  }
}

/* W_nn = (1 -h; -h h^2) for h = 1 / 5, rounded up in h^2: u_n0 h + u_n1 = -h, up to rounding, so
 * that what is no solution to rounding is one beyond 1e15, and is not refuted. */
TEST(no_solution_but_for_rounding) {
  const double h = 0.2;
  for (int k = 0; k < 2; k++) {
    set_small(2);
    set_candidate(0, (const double[]){1, 0, 0, 1}, (const double[]){-1, 0}, 2 * k);
    set_candidate(1, (const double[]){h * h, 0, 0, h * h}, (const double[]){0, 0}, 2 * k);
    t.W[2] = t.W[8] = -h;
    ck_assert_int_eq(list_states(1), DLS_NO_SOLUTION_LIKELY);
    expect_set(0, 0, 0);
  }
}

/* As many candidates as there may be: each is pressed alone; q = 0. */
TEST(eight_candidates) {
  set_small(8);
  for (int c = 0; c < 8; c++)
    set_candidate(c, (const double[]){2, 0, 0, 4}, (const double[]){-2 - 2 * c, 1}, 0);
  ck_assert_int_eq(list_states(1), DLS_OK);
  expect_set(1, 0, 1);
  for (int c = 0; c < 8; c++)
    close_values(r + 2 * c, (const double[]){1 + c, 0}, 2, 8, 1e-14);
  ck_assert(r[16] == 77);
  set_small(1);
  set_candidate(0, three_W, (const double[]){0, 0}, 2);
  ck_assert_int_eq(list_states(1), DLS_OK);
  ck_assert(set.isolated == 1 && set.continua == 0 && r[0] == 0 && r[1] == 0);
}

/* ---- the search of auto ---------------------------------------------------------------------- */

static int find(double tol, double cpu_seconds, dls_certificate *c) {
  const dls_limits limits = {.tol = tol, .cpu_seconds = cpu_seconds};
  return dlsi_contact_find_states(&t.p, &limits, dlsi_clock_start(&limits), low, r, c);
}

TEST(auto_finds_the_first_state) {
  dls_certificate c = {.residual = 1};
  set_small(2);
  set_candidate(0, three_W, (const double[]){-3, -4}, 2); /* sticks: r = (2, 1) */
  set_candidate(1, three_W, three_q, 2);
  ck_assert_int_eq(find(1e-8, 0, &c), 1);
  close_values(r, (const double[]){2, 1, 0, 0}, 4, 1, 1e-14);
  ck_assert(c.residual < 1e-14);
  set_small(1); /* none */
  c.residual = 1;
  set_candidate(0, (const double[]){-1, 0, 0, 1}, (const double[]){-1, 0}, 1);
  ck_assert_int_eq(find(1e-8, 0, &c), 0);
  ck_assert(c.residual == 1 && r[0] == 77);
  set_candidate(0, three_W, three_q, 2); /* no time */
  ck_assert_int_eq(find(1e-8, 1e-300, &c), -1);
  ck_assert(c.residual == 1 && r[0] == 77);
}

/* A solution of some states that is not as good as the r at hand, which is no answer either: r
 * stays, and "none" is not said. */
TEST(rounding_is_not_none) {
  dls_certificate c = {.residual_r = 1};
  set_small(1);
  set_candidate(0, (const double[]){49, 0, 0, 49}, (const double[]){-1, 0}, 1); /* 49 / 49 < 1 */
  ck_assert_int_eq(find(1e-8, 0, &c), -1);
  ck_assert(r[0] == 77 && low[0] == 1. / 49);
}

/* Both contacts have negative diagonals, contact 1 in other units: two solutions in exact
 * arithmetic. A negative diagonal scales a contact, too; in the units of the other contact, 2^30
 * apart, no state was found, and auto said "no solution likely". */
TEST(negative_diagonals_in_other_units) {
  static const double W[16] = {-3, 2, 2, 2, 2, -2, -3, 3, 2, -3, -2, 1, 2, 3, 1, 2};
  static const double q[4] = {-4, 3, -3, 1};
  static const int units[] = {0, 10, -17, -30, 60, -80};
  for (size_t k = 0; k < sizeof units / sizeof units[0]; k++) {
    double one[4];
    set_small(2);
    t.mu[0] = 100;
    t.mu[1] = 1;
    for (int i = 0; i < 4; i++) {
      const int of_row = i > 1 ? units[k] : 0;
      t.q[i] = ldexp(q[i], of_row);
      for (int j = 0; j < 4; j++)
        t.W[i + 4 * j] = ldexp(W[i + 4 * j], of_row + (j > 1 ? units[k] : 0));
    }
    const dls_status status = dls_contact_enumerate(&t.p, 1e-8, room, r, NULL, NULL, &set, NULL);
    ck_assert(status == DLS_OK ? set.isolated == 2 : status == DLS_STALLED && set.isolated == 1);
    ck_assert_int_eq(dls_solve(&t.p, NULL, one, NULL, NULL, NULL), DLS_OK);
  }
}

/* W = diag(2^-k, 1), q = (-1/16, -1/8), mu = 1/2: sticks with r = (2^(k-4), 1/8) alone, however
 * stiff the normal is beside the tangent; below r_t = 1e-12 r_n rounding may leave it open. */
TEST(a_stiff_normal) {
  for (int k = 4; k <= 44; k += 10) {
    set_small(1);
    set_candidate(0, (const double[]){ldexp(1, -k), 0, 0, 1}, (const double[]){-0.0625, -0.125},
                  0.5);
    const dls_status status = list_states(1);
    if (k == 44 && status == DLS_STALLED) return;
    ck_assert_int_eq(status, DLS_OK);
    expect_set(1, 0, 1);
    const double expected[2] = {ldexp(1, k - 4), 0.125};
    close_values(r, expected, 2, expected[0], 1e-12);
  }
}
