/*
 * test_bar.c: elastic bars that hit a wall: D. Doyen, A. Ern, S. Piperno, Time-integration schemes
 * for the finite element dynamic Signorini problem, SIAM J. Sci. Comput. 33 (2011). Each step meets
 * the energy identity and the momentum balance (moving_step).
 */
#include "delassus/reduction.h"
#include "moving.h"
#include "reduced.h"
#include "run.h"

static moving_parts parts;

/* A bar of N equal elements of length l; node 0 may touch a wall below it. fixed: 1: node N is held
 * and no unknown. gap: at x = 0. */
static dls_motion_model bar_model(int N, double l, double E, double rho, int lumped, int fixed,
                                  double gap) {
  const int n = N + 1 - fixed;
  moving_begin(&parts, n);
  for (int j = 0; j < n; j++) {
    const int elements = (j > 0) + (j < N);
    moving_add(&parts.M, j, j, rho * l * elements / (lumped ? 2 : 3));
    moving_add(&parts.K, j, j, E / l * elements);
    if (j + 1 == n) continue;
    if (!lumped) moving_add(&parts.M, j + 1, j, rho * l / 6);
    moving_add(&parts.K, j + 1, j, -E / l);
  }
  moving_touch(&parts, 0, -1, gap);
  return moving_model(&parts);
}

/* What a run shows of the contact at node 0, beside the exact gap. */
typedef struct bar_run {
  double energy;    /* at the end, over that at the start */
  double impulse;   /* of the whole run */
  double error;     /* |gap - exact| over |exact|, L2 in time */
  double variation; /* of the pressure p/h */
} bar_run;

typedef double exact_gap(double t);

/* E 900, rho 1, L 10, falls with v0 = 10 from h0 = 5. The shock reaches the free end and comes back
 * after 2 L/c = 2/3: touches in [1/2, 7/6] with p = v0 sqrt(E rho) = 300, and leaves with v0. */
static double gap_impact(double t) {
  return t < 0.5 ? 5 - 10 * t : t < 7.0 / 6 ? 0 : 10 * (t - 7.0 / 6);
}

/* E = rho = L = 1, held at x = 1, let go from the gap (1 - x)/2: period 3; p = 1/2 in [1, 2]. */
static double gap_fixed(double t) {
  const double s = fmod(t, 3);
  return s < 1 ? (1 - s) / 2 : s < 2 ? 0 : (s - 2) / 2;
}

static bar_run bar_go(dls_motion *motion, double h, double end, exact_gap *exact) {
  const dls_motion_energies start = moving_energies(motion);
  bar_run run = {0};
  double before = 0, size = 0;
  for (dls_motion_state s = moving_state(motion); s.t < end - 1e-9 * h;) {
    s = moving_step(motion, NULL, NULL, NULL);
    const double wanted = exact(s.t);
    run.impulse += s.p[0];
    run.error += (s.gap[0] - wanted) * (s.gap[0] - wanted);
    size += wanted * wanted;
    run.variation += fabs(s.p[0] / h - before);
    before = s.p[0] / h;
  }
  const dls_motion_energies now = moving_energies(motion);
  run.error = sqrt(run.error / size);
  run.energy = (now.kinetic + now.elastic) / (start.kinetic + start.elastic);
  dls_motion_destroy(motion);
  return run;
}

static const double courant = 0.9;

static bar_run bar_impact(dls_motion_law law, int N, int lumped, double theta) {
  const double h = courant * 10 / N / 30;
  const dls_motion_model model = bar_model(N, 10.0 / N, 900, 1, lumped, 0, 5);
  dls_motion_settings settings = moving_settings(law, h);
  settings.theta = theta;
  double v[moving_columns];
  for (int j = 0; j <= N; j++)
    v[j] = -10;
  return bar_go(moving_create(&model, &settings, NULL, v), h, 1.5, gap_impact);
}

/* Lumped mass, theta = 1/2: node 0 stops in one step. It loses its kinetic energy, l/(2 L) of E0,
 * and as much as the scheme has spread of it over its neighbours: E0 (l/L) sqrt(1 + nu^2) / 2 in
 * all, nu the Courant number; the rest comes back. */
TEST(test_loss) {
  ck_assert_double_eq_tol(sqrt(1 + courant * courant) / 100, 0.01345362, 1e-8);
  for (int N = 50; N <= 100; N *= 2)
    ck_assert_double_eq_tol(1 - bar_impact(DLS_MOTION_VELOCITY, N, 1, 0.5).energy,
                            sqrt(1 + courant * courant) / (2 * N), 1e-9);
}

TEST(test_impact) {
  const bar_run coarse = bar_impact(DLS_MOTION_VELOCITY, 100, 0, 0.5),
                fine = bar_impact(DLS_MOTION_VELOCITY, 400, 0, 0.5);
  ck_assert_double_eq_tol(coarse.impulse, 198.845083, 1e-4);
  ck_assert_double_eq_tol(coarse.error, 2.394e-2, 0.03 * 2.394e-2);
  ck_assert_double_eq_tol(fine.error, 7.21e-3, 0.03 * 7.21e-3);
  ck_assert_double_lt(coarse.variation, 800); /* exact: 600 */
  ck_assert_double_lt(fine.variation, 800);
  ck_assert_double_eq_tol(bar_impact(DLS_MOTION_VELOCITY, 100, 0, 1).energy, 0.8312, 1e-4);
}

static bar_run bar_fixed(int N) {
  const double h = courant / N;
  const dls_motion_model model = bar_model(N, 1.0 / N, 1, 1, 0, 1, 0);
  const dls_motion_settings settings = moving_settings(DLS_MOTION_VELOCITY, h);
  double x[moving_columns];
  for (int j = 0; j < N; j++)
    x[j] = (1 - (double)j / N) / 2;
  return bar_go(moving_create(&model, &settings, x, NULL), h, 12, gap_fixed);
}

TEST(test_fixed) {
  const bar_run coarse = bar_fixed(100), fine = bar_fixed(400);
  ck_assert_double_eq_tol(coarse.error, 2.951e-2, 0.03 * 2.951e-2);
  ck_assert_double_eq_tol(fine.error, 1.079e-2, 0.03 * 1.079e-2);
  ck_assert_double_eq_tol(coarse.energy, 0.991392, 1e-5);
  ck_assert_double_eq_tol(fine.energy, 0.997618, 1e-5);
}

/* The gap form with theta < 1, which a motion refuses, by a loop of the host's own:
 *
 *   0 <= gap+ = gap + h (theta u+ + (1 - theta) u)  _|_  p >= 0
 *
 * Returns the variation of the pressure. */
static double own_gap_form(int N, double theta) {
  static double A[moving_entries], x[moving_columns], v[moving_columns], b[moving_columns];
  const double h = courant * 10 / N / 30, a = h * h * theta * theta;
  const dls_motion_model bodies = bar_model(N, 10.0 / N, 900, 1, 0, 0, 5);
  for (int k = 0; k < bodies.M.p[N + 1]; k++) /* M and K have one pattern */
    A[k] = parts.M.x[k] + a * parts.K.x[k];
  const dls_model model = {.d = 2,
                           .n = N + 1,
                           .nodes = 1,
                           .operator_kind = DLS_STIFFNESS_SPARSE,
                           .factorization = DLS_CHOLESKY,
                           .Ks = {N + 1, N + 1, bodies.M.p, bodies.M.i, A},
                           .HN = bodies.HN,
                           .HT = bodies.HT};
  dls_reduction *reduction;
  ck_assert_int_eq(reduce_on_W(&reduction, &model, NULL, NULL), DLS_OK);
  for (int j = 0; j <= N; j++) {
    x[j] = 0;
    v[j] = -10;
  }
  double before = 0, variation = 0;
  for (int step = 0; step * h < 1.5; step++) {
    for (int j = 0; j <= N; j++) { /* b = -h K (x + h theta v) */
      const double k = 900.0 * N / 10, y = x[j] + h * theta * v[j];
      b[j] = 0;
      if (j > 0) b[j] -= h * k * (y - x[j - 1] - h * theta * v[j - 1]);
      if (j < N) b[j] -= h * k * (y - x[j + 1] - h * theta * v[j + 1]);
    }
    const double g[2] = {v[0] + ((5 + x[0]) / h + (1 - theta) * v[0]) / theta, 0}, mu = 0;
    double r[2], dv[moving_columns];
    dls_contact problem;
    ck_assert_int_eq(dls_reduction_load(reduction, b, g, NULL), DLS_OK);
    ck_assert_int_eq(dls_reduction_contact(reduction, &mu, &problem, NULL), DLS_OK);
    ck_assert_int_eq(dls_solve(&problem, NULL, r, NULL, NULL, NULL), DLS_OK);
    ck_assert_int_eq(dls_reduction_recover(reduction, r, dv, NULL), DLS_OK);
    for (int j = 0; j <= N; j++) {
      x[j] += h * (v[j] + theta * dv[j]);
      v[j] += dv[j];
    }
    variation += fabs(r[0] / h - before);
    before = r[0] / h;
  }
  dls_reduction_destroy(reduction);
  return variation;
}

/* Exact: 600. With theta = 1 the variation stays; with theta = 1/2 it grows as 1/h. */
TEST(test_gap_form_with_half) {
  double one[2], half[2];
  for (int k = 0; k < 2; k++) {
    one[k] = own_gap_form(k ? 1600 : 100, 1);
    half[k] = own_gap_form(k ? 1600 : 100, 0.5);
  }
  ck_assert_double_eq_tol(one[0], bar_impact(DLS_MOTION_GAP, 100, 0, 1).variation, 1e-6);
  ck_assert_double_lt(fmax(one[0], one[1]), 800);
  ck_assert_double_gt(half[0], 6000);
  ck_assert_double_gt(half[1], 4 * half[0]);
}
