/*
 * test_rigid.c: rigid bodies with answers derived by hand. Each step of each of them meets the
 * energy identity and the momentum balance (moving_step).
 */
#include "contact/contact.h"
#include "moving.h"
#include "run.h"

static const double gravity = 9.81, pi = 3.14159265358979323846;
static moving_parts parts;

/* Returns the next of a sequence of random numbers in (-1, 1). */
static double dice(void) {
  static uint64_t count;
  return 2 * dlsi_draw(++count * DLSI_GOLDEN_BITS) - 1;
}

/* A ball of mass 1 at height 1, e = 1/2. Falls for sqrt(2/g) = .451524 s; every flight lasts half
 * of the one before: at rest from sqrt(2/g)(1 + 2 (1/2 + 1/4 + ..)) = 3 sqrt(2/g) = 1.35457 s. The
 * last velocities of the scheme change their sign and halve from step to step: below 1e-5 g h from
 * 1.35469 s on, to two steps. At rest the impulse is m g h. */
TEST(test_ball) {
  moving_begin(&parts, 1);
  moving_add(&parts.M, 0, 0, 1);
  moving_touch(&parts, 0, -1, 0);
  const dls_motion_model model = moving_model(&parts);
  const double h = 1.0 / 25600, one = 1, f = -gravity;
  dls_motion_settings settings = moving_settings(DLS_MOTION_VELOCITY, h);
  settings.restitution = 0.5;
  dls_motion *motion = moving_create(&model, &settings, &one, NULL);
  double rest = 0;
  dls_motion_state s = moving_state(motion);
  while (s.t < 1.4) {
    s = moving_step(motion, &f, NULL, NULL);
    if (fabs(s.v[0]) > 1e-5 * gravity * h) rest = s.t + h;
  }
  ck_assert_double_eq_tol(rest, 1.35469, 2 * h);
  ck_assert_double_ge(rest, 3 * sqrt(2 / gravity));
  ck_assert_double_eq_tol(s.p[0], gravity * h, 1e-12 * gravity * h);
  dls_motion_destroy(motion);
}

/* A block, m = 1, on a belt, V = .1, held by a spring, k = 1, pressed by N = 10; mu .5 where it
 * sticks, .3 where it slips. It sticks from x = 1 to x = 5, for 4 / V = 40; slips about x = 3 with
 * the amplitude sqrt(4 + V^2) and, like the belt, with v = V at both ends: for pi + 2 atan(V/2).
 * Period 43.241509; asked to 2 h. */
TEST(test_stick_slip) {
  moving_begin(&parts, 2);
  moving_add(&parts.M, 0, 0, 1);
  moving_add(&parts.M, 1, 1, 1);
  moving_add(&parts.K, 0, 0, 1);
  moving_touch(&parts, 1, 0, 0);
  const dls_motion_model model = moving_model(&parts);
  const double h = 1e-3, f[2] = {0, -10}, y[2] = {0, 0.1};
  const dls_motion_settings settings = moving_settings(DLS_MOTION_VELOCITY, h);
  dls_motion *motion = moving_create(&model, &settings, NULL, NULL);
  double begins[3] = {0};
  int count = 0;
  for (dls_motion_state s = moving_state(motion); count < 3 && s.t < 150;) {
    const dls_contact_state before = s.state[0];
    const int holds = before == DLS_STICK && s.x[0] + h * y[1] <= 5; /* to the end of this step */
    const double mu = holds ? 0.5 : 0.3;
    s = moving_step(motion, f, y, &mu);
    if (before == DLS_STICK && s.state[0] == DLS_SLIP) begins[count++] = s.t;
  }
  ck_assert_int_eq(count, 3);
  const double period = 40 + pi + 2 * atan(0.05);
  ck_assert_double_eq_tol(period, 43.241509, 1e-6);
  ck_assert_double_eq_tol(begins[1] - begins[0], period, 2 * h);
  ck_assert_double_eq_tol(begins[2] - begins[1], period, 2 * h);
  dls_motion_destroy(motion);
}

/* Slides down an incline of 20 degrees from v = 5, mu = .5; returns the distance at 4.5 s. */
static double incline_distance(double h) {
  const double angle = pi / 9;
  const double f[2] = {gravity * sin(angle), -gravity * cos(angle)}, v[2] = {5, 0}, mu = 0.5;
  moving_begin(&parts, 2);
  moving_add(&parts.M, 0, 0, 1);
  moving_add(&parts.M, 1, 1, 1);
  moving_touch(&parts, 1, 0, 0);
  const dls_motion_model model = moving_model(&parts);
  const dls_motion_settings settings = moving_settings(DLS_MOTION_VELOCITY, h);
  dls_motion *motion = moving_create(&model, &settings, NULL, v);
  dls_motion_state s = moving_state(motion);
  double stop = 0;
  while (s.t < 4.5) {
    const double before = s.x[0];
    s = moving_step(motion, f, NULL, &mu);
    if (s.state[0] == DLS_SLIP) stop = s.t + h;
    if (s.t > 4.1) ck_assert_double_le(fabs(s.x[0] - before), 4 * DBL_EPSILON * s.x[0]);
  }
  ck_assert_double_eq_tol(stop, 3.987321, h);
  ck_assert_double_eq_tol(s.slip[0], s.x[0], 1e-12);
  const double x = s.x[0];
  dls_motion_destroy(motion);
  return x;
}

/* Decelerates by a = g (mu cos - sin) = 1.253975: stops after v/a = 3.987321 s and v^2/2a =
 * 9.96830320, and does not creep. theta = 1/2 integrates the slide exactly; in the last step, from
 * the velocity w < a h to 0, it goes w h/2 instead of w^2/2a: an error of at most a h^2/8. */
TEST(test_incline) {
  const double a = gravity * (0.5 * cos(pi / 9) - sin(pi / 9));
  ck_assert_double_eq_tol(5 / a, 3.987321, 1e-6);
  ck_assert_double_eq_tol(25 / (2 * a), 9.96830320, 1e-8);
  for (double h = 0.02; h > 1e-3; h /= 2) {
    const double w = a * (5 / a - h * floor(5 / a / h));
    const double error = w * h / 2 - w * w / (2 * a);
    ck_assert_double_eq_tol(incline_distance(h), 25 / (2 * a) + error, 1e-9);
    ck_assert_double_le(error, a * h * h / 8 + 1e-12);
  }
}

/* Painleve's rod: m = 1, half length 1, inertia 1/3, its tip slides with u_t = -1, mu = 2, centre
 * at (c, s) from the tip, c^2 = 1/5. W = (1 + 3 c^2, -3 c s; -3 c s, 1 + 3 s^2) = (1.6 -1.2; -1.2
 * 3.4). Slip on with r_t = 2 r_n would give u_n = (1.6 - 2.4) r_n - g h < 0 for every r_n: there is
 * an impact without collision. It stops the tip: r = W^-1 (g h, 1), r_n = (3.4 g h + 1.2)/4 =
 * .300008 for h = 1e-6, r_t = (1.2 g h + 1.6)/4 <= 2 r_n. */
TEST(test_painleve) {
  const double c = sqrt(0.2), s = sqrt(0.8), tip[2] = {0, 0}, h = 1e-6, mu = 2;
  const double f[3] = {0, -gravity, 0}, v[3] = {-1, 0, 0};
  moving_begin(&parts, 3);
  moving_body(&parts, 0, c, s, 1, 1.0 / 3);
  moving_joint(&parts, 0, -1, tip, pi / 2, 0);
  const dls_motion_model model = moving_model(&parts);
  const dls_motion_settings settings = moving_settings(DLS_MOTION_VELOCITY, h);
  dls_motion *motion = moving_create(&model, &settings, NULL, v);
  const dls_motion_state state = moving_step(motion, f, NULL, &mu);
  ck_assert_double_eq_tol(state.p[0], 0.300008, 1e-6);
  ck_assert_double_eq_tol(state.p[0], (3.4 * gravity * h + 1.2) / 4, 1e-12);
  ck_assert_double_eq_tol(state.p[1], (1.2 * gravity * h + 1.6) / 4, 1e-12);
  ck_assert_int_eq(state.state[0], DLS_STICK);
  dls_motion_destroy(motion);
}

/* Kane's rod: m = 1, half length 1, inertia 1/3, hits with v = (1, -1, 0) at 60 degrees, e = 1, mu
 * = .2. W = (7/4, -3 q; -3 q, 13/4), q = sqrt(3)/4, u = (-1, 1). It sticks: p_n = (13 - 6 q)/8, p_t
 * = (6 q - 7/4)/4 < mu p_n. The work of friction, p_t/2, is > 0: (6 sqrt(3) - 14/2)/32 of an energy
 * of 1. With p(e) the works cancel for e^2 = (5 - 6 q)/(13/4). */
TEST(kane) {
  const double tip[2] = {0, 0}, mu = 0.2, v[3] = {1, -1, 0}, root = sqrt(3);
  moving_begin(&parts, 3);
  moving_body(&parts, 0, 0.5, root / 2, 1, 1.0 / 3);
  moving_joint(&parts, 0, -1, tip, pi / 2, 0);
  const dls_motion_model model = moving_model(&parts);
  dls_motion_settings settings = moving_settings(DLS_MOTION_VELOCITY, 1e-6);
  settings.restitution = 1;
  dls_motion *motion = moving_create(&model, &settings, NULL, v);
  dls_motion_state state = moving_step(motion, NULL, NULL, &mu);
  dls_motion_energies energies = moving_energies(motion);
  ck_assert(state.restitution == 1);
  ck_assert_double_eq_tol(energies.created, (6 * root - 7) / 32, 1e-12);
  ck_assert_double_eq_tol(energies.kinetic, 1 + energies.created, 1e-12);
  dls_motion_destroy(motion);
  settings.energy_consistent = 1;
  motion = moving_create(&model, &settings, NULL, v);
  state = moving_step(motion, NULL, NULL, &mu);
  energies = moving_energies(motion);
  ck_assert_double_eq_tol(state.restitution, sqrt((5 - 1.5 * root) / 3.25), 1e-8);
  ck_assert_double_eq_tol(state.u[0], state.restitution, 1e-12);
  ck_assert_double_le(energies.kinetic, 1);
  ck_assert_double_eq_tol(energies.kinetic, 1, 1e-8);
  ck_assert(energies.created == 0);
  dls_motion_destroy(motion);
}

/* Random impacts of two bodies with 1 to 3 contacts, e and mu up to 1.2. With e as given some gain
 * energy, and `created` is what they gain; with energy_consistent none does. The few that have no
 * solution (jammed) are left out. */
TEST(impacts_create_no_energy) {
  int solved = 0, gained = 0;
  for (int trial = 0; trial < 3000; trial++) {
    double mu[3], v[6], before[2], after[2], made[2];
    moving_begin(&parts, 6);
    for (int b = 0; b < 2; b++)
      moving_body(&parts, b, dice(), dice(), exp(dice()), exp(2 * dice() - 1));
    for (int c = 0; c <= trial % 3; c++) {
      const double X[2] = {dice(), dice()};
      moving_joint(&parts, c != 0, c == 2 ? 0 : -1, X, pi * dice(), 0);
      mu[c] = 0.6 + 0.6 * dice();
    }
    for (int i = 0; i < 6; i++)
      v[i] = dice();
    const dls_motion_model model = moving_model(&parts);
    dls_motion_settings settings = moving_settings(DLS_MOTION_VELOCITY, 1e-9);
    settings.restitution = fabs(dice());
    int good = 1;
    for (int way = 0; way < 2; way++) {
      settings.energy_consistent = way;
      dls_motion *motion = moving_create(&model, &settings, NULL, v);
      before[way] = moving_energies(motion).kinetic;
      good = good && dls_motion_step(motion, NULL, NULL, mu, NULL, NULL) == DLS_OK;
      after[way] = moving_energies(motion).kinetic;
      made[way] = moving_energies(motion).created;
      dls_motion_destroy(motion);
    }
    if (!good) continue;
    solved++;
    const double gain = after[0] - before[0], rounding = 1e-10 * (before[0] + fabs(gain));
    if (gain > rounding) gained++;
    ck_assert_double_eq_tol(made[0], fmax(gain, 0), rounding);
    ck_assert_msg(after[1] <= before[1] * (1 + 1e-10), "trial %d: gains %g of %g", trial,
                  after[1] - before[1], before[1]);
    ck_assert(made[1] <= 1e-10 * before[1]);
  }
  ck_assert_int_ge(solved, 2970);
  ck_assert_int_ge(gained, 30);
}

/* ---- structures ------------------------------------------------------------------------------ */

static double closed = 0; /* activation */
static double load[3 * moving_bodies], friction[4 * moving_bodies];

/* Takes steps of h under the weight of the bodies, gravity (gx, gy); returns max |v| / (g t). */
static double unrest(double h, int steps, double gx, double gy, double mu, double *crown) {
  const dls_motion_model model = moving_model(&parts);
  dls_motion_settings settings = moving_settings(DLS_MOTION_VELOCITY, h);
  settings.activation = closed;
  dls_motion *motion = moving_create(&model, &settings, NULL, NULL);
  for (int i = 0; i < parts.n; i++)
    load[i] = parts.M.x[i] * (i % 3 == 0 ? gx : i % 3 == 1 ? gy : 0);
  for (int c = 0; c < parts.nodes; c++)
    friction[c] = mu;
  double worst = 0;
  dls_motion_state s = moving_state(motion);
  for (int k = 0; k < steps; k++) {
    s = moving_step(motion, load, NULL, friction);
    for (int i = 0; i < parts.n; i++)
      worst = fmax(worst, fabs(s.v[i]));
  }
  if (crown) *crown = hypot(s.x[parts.n / 6 * 3], s.x[parts.n / 6 * 3 + 1]);
  worst /= gravity * s.t;
  dls_motion_destroy(motion);
  return worst;
}

/* Ten blocks, 1 x 1/2, on a slope: the weight of all leaves the foot where tan = (1/2) / (5/2),
 * 11.3099 degrees. */
static double stack_unrest(double degrees, int steps) {
  moving_begin(&parts, 30);
  for (int b = 0; b < 10; b++) {
    moving_body(&parts, b, 0, 0.25 + 0.5 * b, 1, (1 + 0.25) / 12);
    for (int side = -1; side <= 1; side += 2)
      moving_joint(&parts, b, b - 1, (double[]){0.5 * side, 0.5 * b}, pi / 2, 0);
  }
  const double angle = degrees * pi / 180;
  return unrest(1e-3, steps, gravity * sin(angle), -gravity * cos(angle), 0.5, NULL);
}

TEST(test_stack) {
  ck_assert_double_le(stack_unrest(11.30, 100), 1e-12);
  const double falls = stack_unrest(11.32, 100);
  ck_assert_double_ge(falls, 1e-6);
  ck_assert_double_le(falls, 1e-2);
}

/* A half circle of n voussoirs, mean radius 1, thickness t, mu = 1: trapezoids whose corners lie on
 * the circles 1 -+ t/2. The inertia of a thin rod across will do. */
static void arch_build(int n, double t) {
  const double ri = 1 - t / 2, ro = 1 + t / 2, half = pi / n / 2;
  const double area = (ro * ro - ri * ri) * sin(half) * cos(half);
  const double centre = 2.0 / 3 * (pow(ro, 3) - pow(ri, 3)) / (ro * ro - ri * ri) * cos(half);
  const double inertia = area * t * t / 12;
  moving_begin(&parts, 3 * n);
  for (int b = 0; b < n; b++) {
    const double at = (2 * b + 1) * half;
    moving_body(&parts, b, centre * cos(at), centre * sin(at), area, inertia);
  }
  for (int j = 0; j <= n; j++)
    for (int side = -1; side <= 1; side += 2) {
      const double at = 2 * j * half, r = 1 + side * t / 2, X[2] = {r * cos(at), r * sin(at)};
      if (j < n)
        moving_joint(&parts, j, j - 1, X, at + pi / 2, 0);
      else
        moving_joint(&parts, n - 1, -1, X, at - pi / 2, 0);
    }
}

/* Least thickness of an arch that stands, by statics alone: .107348 for 20 voussoirs, .107432 for
 * 40, with an independent linear program; one step from rest tells. */
TEST_EACH(test_arch_thickness, 0, 2) {
  const int n = _i == 0 ? 20 : 40;
  const double least = _i == 0 ? 0.107348 : 0.107432;
  arch_build(n, least + 1e-6);
  ck_assert_double_le(unrest(1e-3, 1, 0, -gravity, 1, NULL), 1e-10);
  arch_build(n, least - 1e-6);
  ck_assert_double_ge(unrest(1e-3, 1, 0, -gravity, 1, NULL), 1e-8);
}

/* An arch that is thick enough stands for .5 s. */
TEST(test_arch_stands) {
  double crown;
  arch_build(20, 0.12);
  ck_assert_double_le(unrest(1e-3, 500, 0, -gravity, 1, &crown), 1e-12);
  ck_assert_double_lt(crown, 1e-12);
  closed = 1e-9;
  ck_assert_double_le(unrest(1e-3, 500, 0, -gravity, 1, &crown), 1e-12);
  ck_assert_double_lt(crown, 1e-12);
  closed = 0;
}

/* Boxes of side 1 that rest on each other do not sink: rounding opens their gaps, and no contact
 * lets go for a step. They fall when the floor is gone, and when they are lifted they leave. */
TEST(boxes_at_rest) {
  double way;
  moving_begin(&parts, 15);
  for (int b = 0; b < 5; b++) {
    moving_body(&parts, b, 0.01 * b, 0.5 + b, 1, 1.0 / 6);
    for (int side = -1; side <= 1; side += 2)
      moving_joint(&parts, b, b - 1, (double[]){0.5 * side + 0.005 * b, b}, pi / 2, 0);
  }
  ck_assert_double_le(unrest(1.0 / 60, 2000, 0.1, -gravity, 0.5, &way), 1e-12);
  ck_assert_double_lt(way, 1e-12);
  const double t = 20.0 / 60; /* lifted by 1/2 beyond the weight */
  ck_assert_double_le(unrest(1.0 / 60, 20, 0, 0.5, 0.5, &way), 0.5 / gravity * (1 + 1e-9));
  ck_assert_double_eq_tol(way, t * t / 4, 1e-9);
}
