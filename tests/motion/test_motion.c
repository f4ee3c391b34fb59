/* test_motion.c: laws in closed form, what a motion keeps, wrong input, failing mallocs. */
#include "moving.h"
#include "run.h"

static moving_parts parts;

/* A mass 1 in the plane, unknowns (x, y), above an obstacle along x; a spring k along x and y where
 * k > 0. */
static dls_motion_model point_model(double mass, double k, double gap) {
  moving_begin(&parts, 2);
  for (int i = 0; i < 2; i++) {
    if (mass > 0) moving_add(&parts.M, i, i, mass);
    if (k > 0) moving_add(&parts.K, i, i, k);
  }
  moving_touch(&parts, 1, 0, gap);
  return moving_model(&parts);
}

/* ---- laws ------------------------------------------------------------------------------------ */

/* A ball, v = -3, meets a racket that rises with V = 2, e = 1/2: v+ = V + e (V - v) = 4.5; p = m
 * (v+ - v) = 7.5; the racket gives p V = 15, the impact takes p (u+ + u)/2 = 7.5 (2.5 - 5)/2. */
TEST(test_racket) {
  const dls_motion_model model = point_model(1, 0, 0);
  dls_motion_settings settings = moving_settings(DLS_MOTION_VELOCITY, 1e-3);
  settings.restitution = 0.5;
  const double v[2] = {0, -3}, y[2] = {2, 0};
  dls_motion *motion = moving_create(&model, &settings, NULL, v);
  dls_motion_state s = moving_step(motion, NULL, y, NULL);
  const dls_motion_energies e = moving_energies(motion);
  ck_assert_double_eq_tol(s.v[1], 4.5, 1e-12);
  ck_assert_double_eq_tol(s.p[0], 7.5, 1e-12);
  ck_assert_double_eq_tol(e.obstacle, 15, 1e-12);
  ck_assert_double_eq_tol(e.impact, 7.5 * (2.5 - 5) / 2, 1e-12);
  s = moving_step(motion, NULL, y, NULL); /* flies off */
  ck_assert_int_eq(s.state[0], DLS_FREE);
  ck_assert_double_eq(s.p[0], 0);
  ck_assert_double_eq_tol(s.gap[0], 1e-3 * (0.5 * (4.5 - 3) + 4.5 - 2 * 2), 1e-15);
  dls_motion_destroy(motion);
}

/* The gap form ends the step of the impact at gap = 0, not below, with what is left of the speed;
 * the next one stops the ball. */
TEST(test_gap_form) {
  const dls_motion_model model = point_model(2, 0, 0.25);
  const dls_motion_settings settings = moving_settings(DLS_MOTION_GAP, 0.1);
  const double v[2] = {0, -1};
  dls_motion *motion = moving_create(&model, &settings, NULL, v);
  const double gaps[] = {0.15, 0.05, 0, 0}, impulses[] = {0, 0, 2 * (1 - 0.5), 2 * 0.5};
  for (int k = 0; k < 4; k++) {
    const dls_motion_state s = moving_step(motion, NULL, NULL, NULL);
    ck_assert_double_eq_tol(s.gap[0], gaps[k], 1e-15);
    ck_assert_double_eq_tol(s.p[0], impulses[k], 1e-14);
  }
  dls_motion_destroy(motion);
}

/* Without contact nodes a spring swings: with theta = 1/2, cos(w t), tan(w h/2) = h/2, without
 * loss; with theta = 1 the scheme takes energy, which it says. */
TEST(test_swing) {
  moving_begin(&parts, 1);
  moving_add(&parts.M, 0, 0, 1);
  moving_add(&parts.K, 0, 0, 1);
  const dls_motion_model model = moving_model(&parts);
  dls_motion_settings settings = moving_settings(DLS_MOTION_VELOCITY, 0.25);
  const double one = 1, w = 2 * atan(0.125) / 0.25;
  for (settings.theta = 0.5; settings.theta <= 1; settings.theta += 0.25) {
    dls_motion *motion = moving_create(&model, &settings, &one, NULL);
    for (int k = 1; k <= 40; k++) {
      const dls_motion_state s = moving_step(motion, NULL, NULL, NULL);
      if (settings.theta == 0.5) ck_assert_double_eq_tol(s.x[0], cos(w * s.t), 1e-13);
    }
    const dls_motion_energies e = moving_energies(motion);
    ck_assert_double_eq_tol(e.kinetic + e.elastic, 0.5 + e.numerical, 1e-14);
    ck_assert_double_ge(settings.theta == 0.5, e.numerical > -0.1);
    dls_motion_destroy(motion);
  }
}

/* Damping, theta = 1/2, m = c = 1: v+ = v (1 - h/2)/(1 + h/2); the work of the damper is what is
 * lost. */
TEST(test_damping) {
  moving_begin(&parts, 1);
  moving_add(&parts.M, 0, 0, 1);
  moving_add(&parts.C, 0, 0, 1);
  moving_touch(&parts, 0, -1, 1);
  const dls_motion_model model = moving_model(&parts);
  const dls_motion_settings settings = moving_settings(DLS_MOTION_VELOCITY, 0.5);
  const double one = 1;
  dls_motion *motion = moving_create(&model, &settings, NULL, &one);
  const dls_motion_state s = moving_step(motion, NULL, NULL, NULL);
  ck_assert_double_eq_tol(s.v[0], 0.6, 1e-15);
  ck_assert_double_eq_tol(moving_energies(motion).damping, 0.18 - 0.5, 1e-15);
  dls_motion_destroy(motion);
}

/* A path: pressed by 10, sheared, mu = 1/2, k = 1. F = 8 moves the point by F - mu N = 3; without
 * F it springs back to mu N = 5 at most, so it stays at 3 and friction takes what it had given
 * back to hold it: r_t = 3. A belt that then goes by -4 takes it along to -1; one more -9 leaves it
 * where friction gives up, x = -5. The answer to F = 0 depends on the path. */
TEST(test_path) {
  const dls_motion_model model = point_model(0, 1, 0.5);
  const dls_motion_settings settings = moving_settings(DLS_MOTION_PATH, 1);
  const struct {
    double F, y, x, r, slip;
    dls_contact_state state;
  } at[] = {{0, 0, 0, 0, 0, DLS_STICK},
            {4, 0, 0, -4, 0, DLS_STICK},
            {8, 0, 3.25, -4.75, 3.25, DLS_SLIP},
            {0, 0, 3.25, 3.25, 3.25, DLS_STICK},
            {0, -4, -0.75, -0.75, 3.25, DLS_STICK},
            {0, -9, -4.75, -4.75, 3.25 + 5, DLS_SLIP}};
  dls_motion *motion = moving_create(&model, &settings, NULL, NULL);
  double work = 0;
  for (size_t k = 0; k < sizeof at / sizeof at[0]; k++) {
    const double f[2] = {at[k].F, -10}, y[2] = {0, at[k].y}, mu = 0.5;
    const dls_motion_state s = moving_step(motion, f, y, &mu);
    ck_assert_double_eq_tol(s.x[0], at[k].x, 1e-12); /* r_n = 10 - .5 k, y = -.5: mu r_n = 4.75 */
    ck_assert_double_eq_tol(s.x[1], -0.5, 1e-12);
    assert_near(s.p, (double[]){9.5, at[k].r}, 2, 1e-11);
    ck_assert_double_eq_tol(s.slip[0], at[k].slip, 1e-11);
    ck_assert_int_eq(s.state[0], at[k].state);
    work += s.p[1] * s.u[1];
  }
  ck_assert_double_eq_tol(work, -4.75 * (3.25 + 5), 1e-10);
  ck_assert_double_eq_tol(moving_energies(motion).friction, work, 1e-12);
  dls_motion_destroy(motion);
}

/* Weighted reactions: two nodes, one candidate, P = (1/4, 3/4), frictionless contact of a bar that
 * turns: gap = (gap_1 + 3 gap_2)/4 and the nodes push back by p/4 and 3 p/4. The slip is the
 * candidate's. */
TEST(test_weighting) {
  moving_begin(&parts, 4);
  for (int i = 0; i < 4; i++)
    moving_add(&parts.M, i, i, 1);
  moving_touch(&parts, 1, 0, 0.2);
  moving_touch(&parts, 3, 2, 0.4);
  dls_motion_model model = moving_model(&parts);
  const int p[] = {0, 2}, i[] = {0, 1};
  const double x[] = {0.25, 0.75}, v[4] = {1, -4, 1, -4}, mu = 0.5;
  model.P = (dls_sparse){2, 1, p, i, x};
  const dls_motion_settings settings = moving_settings(DLS_MOTION_GAP, 0.125);
  dls_motion *motion = moving_create(&model, &settings, NULL, v);
  ck_assert_double_eq_tol(moving_state(motion).gap[0], 0.35, 1e-15);
  const dls_motion_state s = moving_step(motion, NULL, NULL, &mu);
  /* H.H = 10/16: u_n+ = -gap/h = -2.8 = -4 + 10/16 p; slip: u_t = 1 - 10/16 p/2 */
  assert_near(s.p, (double[]){1.92, -0.96}, 2, 1e-13);
  ck_assert_double_eq_tol(s.gap[0], 0, 1e-15);
  ck_assert_double_eq_tol(s.v[1], -4 + 1.92 / 4, 1e-13);
  ck_assert_double_eq_tol(s.v[3], -4 + 1.92 * 3 / 4, 1e-13);
  ck_assert_double_eq_tol(s.slip[0], 0.125 * 0.4, 1e-14);
  dls_motion_destroy(motion);
}

/* In 3D: a puck slides with v = (3, 4) and mu = 1/4 under g = 8: it brakes by 2 along its way and
 * stops after 2.5 s and 6.25, in the direction (.6, .8): the tangents see (3.75, 5). */
TEST(test_puck) {
  const int p[] = {0, 1, 2, 3}, i[] = {0, 1, 2}, z[] = {2};
  const double mass[] = {1, 1, 1}, v[] = {3, 4, 0}, f[] = {0, 0, -8}, mu = 0.25;
  dls_motion_model model = {.d = 3, .n = 3, .nodes = 1, .factorization = DLS_CHOLESKY};
  model.M = (dls_sparse){3, 3, p, i, mass};
  model.HN = (dls_sparse){3, 1, p, z, mass};
  model.HT = (dls_sparse){3, 2, p, i, mass};
  const dls_motion_settings settings = moving_settings(DLS_MOTION_VELOCITY, 0.125);
  dls_motion *motion = moving_create(&model, &settings, NULL, v);
  dls_motion_state s = moving_state(motion);
  while (s.t < 3) {
    s = moving_step(motion, f, NULL, &mu);
    const int slides = s.t < 2.4;
    ck_assert_int_eq(s.state[0], slides ? DLS_SLIP : DLS_STICK);
    ck_assert_double_eq_tol(s.p[1], slides ? -0.15 : s.t < 2.6 ? -0.15 : 0, 1e-11);
    ck_assert_double_eq_tol(hypot(s.v[0], s.v[1]), fmax(0, 5 - 2 * s.t), 1e-10);
  }
  assert_near(s.slip, (double[]){3.75, 5}, 2, 1e-10);
  ck_assert_double_eq_tol(moving_energies(motion).friction, -12.5, 1e-10);
  dls_motion_destroy(motion);
}

/* Two points slide along an obstacle, each its own way. */
TEST(test_two_ways) {
  moving_begin(&parts, 4);
  for (int i = 0; i < 4; i++)
    moving_add(&parts.M, i, i, 1);
  moving_touch(&parts, 1, 0, 0);
  moving_touch(&parts, 3, 2, 0);
  const dls_motion_model model = moving_model(&parts);
  const dls_motion_settings settings = moving_settings(DLS_MOTION_VELOCITY, 0.25);
  const double v[4] = {1, 0, -2, 0}, f[4] = {0, -1, 0, -1};
  dls_motion *motion = moving_create(&model, &settings, NULL, v);
  for (int k = 1; k <= 4; k++) {
    const dls_motion_state s = moving_step(motion, f, NULL, NULL);
    assert_near(s.slip, (double[]){0.25 * k, -0.5 * k}, 2, 1e-14);
    ck_assert_double_eq_tol(s.p[0], 0.25, 1e-13);
    ck_assert_double_eq_tol(s.p[2], 0.25, 1e-13);
  }
  /* with friction the one at rest stays, the other one slides */
  const double still[4] = {0, 0, -2, 0}, mu[2] = {0.5, 0.5};
  ck_assert_int_eq(dls_motion_start(motion, NULL, still, 0, NULL), DLS_OK);
  const dls_motion_state s = moving_step(motion, f, NULL, mu);
  ck_assert_int_eq(s.state[0], DLS_STICK);
  ck_assert_int_eq(s.state[1], DLS_SLIP);
  ck_assert_double_eq_tol(s.p[3], 0.125, 1e-13);
  dls_motion_destroy(motion);
}

/* An unsymmetric A: C = (0 -1; 1 0) turns the velocity and does no work; theta = 1/2 turns it by
 * 2 atan(h/2) a step. */
TEST(test_turning) {
  moving_begin(&parts, 2);
  for (int j = 0; j < 2; j++) {
    moving_add(&parts.M, j, j, 1);
    moving_add(&parts.C, 1 - j, j, j ? -1 : 1);
  }
  moving_touch(&parts, 1, 0, 1e3);
  dls_motion_model model = moving_model(&parts);
  model.factorization = DLS_LU;
  const dls_motion_settings settings = moving_settings(DLS_MOTION_VELOCITY, 0.5);
  const double v[2] = {1, 0};
  dls_motion *motion = moving_create(&model, &settings, NULL, v);
  for (int k = 1; k <= 10; k++) {
    const dls_motion_state s = moving_step(motion, NULL, NULL, NULL);
    assert_near(s.v, (double[]){cos(2 * k * atan(0.25)), -sin(2 * k * atan(0.25))}, 2, 1e-13);
  }
  ck_assert_double_eq_tol(moving_energies(motion).damping, 0, 1e-14);
  dls_motion_destroy(motion);
}

/* ---- what a motion keeps --------------------------------------------------------------------- */

enum { chain = 6 };

/* A chain of masses pressed against a wall by springs, all of which touch: coupled candidates. */
static dls_motion_model chain_model(double mass, double k, double gap) {
  moving_begin(&parts, 2 * chain);
  for (int j = 0; j < 2 * chain; j++) {
    if (mass > 0) moving_add(&parts.M, j, j, mass);
    moving_add(&parts.K, j, j, 3 * k);
    if (j + 1 < 2 * chain) moving_add(&parts.K, j + 1, j, -0.5 * k);
    if (j + 2 < 2 * chain) moving_add(&parts.K, j + 2, j, -k / 2);
  }
  for (int c = 0; c < chain; c++)
    moving_touch(&parts, 2 * c + 1, 2 * c, gap * (c % 3));
  return moving_model(&parts);
}

static double chain_load[2 * chain], chain_mu[chain];

static void chain_loads(double force) {
  for (int j = 0; j < 2 * chain; j++)
    chain_load[j] = force * (j % 2 ? -1 : 0.3);
  for (int c = 0; c < chain; c++)
    chain_mu[c] = 0.4;
}

/* A step that is not certified leaves all as it was; the run goes on to the same bits. */
TEST_EACH(test_refused_step, 0, 3) {
  const dls_motion_law laws[] = {DLS_MOTION_VELOCITY, DLS_MOTION_GAP, DLS_MOTION_PATH};
  const dls_motion_model model = chain_model(_i == 2 ? 0 : 1, 1, 1e-3);
  dls_motion_settings settings = moving_settings(laws[_i], 0.05);
  settings.method = DLS_NLGS;
  chain_loads(1);
  dls_motion *one = moving_create(&model, &settings, NULL, NULL);
  dls_motion *two = moving_create(&model, &settings, NULL, NULL);
  dls_limits few = settings.limits;
  few.max_iterations = 1;
  int refused = 0;
  for (int k = 0; k < 20; k++) {
    const dls_motion_state before = moving_state(two);
    double x[2 * chain], p[2 * chain];
    memcpy(x, before.x, sizeof x);
    memcpy(p, before.p, sizeof p);
    const dls_motion_energies e = moving_energies(two);
    chain_load[0] = 0.1 * k;
    ck_assert_int_eq(dls_motion_set_limits(two, &few, NULL), DLS_OK);
    dls_info info;
    const dls_status status = dls_motion_step(two, chain_load, NULL, chain_mu, &info, NULL);
    if (status) {
      refused++;
      ck_assert_int_eq(status, DLS_MAX_ITERATIONS);
      ck_assert_int_eq(info.status, status);
      const dls_motion_state after = moving_state(two);
      const dls_motion_energies left = moving_energies(two);
      ck_assert_int_eq(after.steps, before.steps);
      ck_assert_mem_eq(after.x, x, sizeof x);
      ck_assert_mem_eq(after.p, p, sizeof p);
      ck_assert_mem_eq(&left, &e, sizeof e);
      dls_contact problem;
      ck_assert_int_eq(dls_motion_get_problem(two, &problem, NULL), DLS_OK);
      ck_assert_int_gt(problem.nc, 0);
      ck_assert_int_eq(dls_contact_check(&problem, NULL), DLS_OK);
      ck_assert_int_eq(dls_motion_set_limits(two, &settings.limits, NULL), DLS_OK);
      moving_step(two, chain_load, NULL, chain_mu);
    }
    moving_step(one, chain_load, NULL, chain_mu);
    ck_assert_mem_eq(moving_state(two).x, moving_state(one).x, sizeof x);
  }
  ck_assert_int_gt(refused, 0);
  dls_motion_destroy(one);
  dls_motion_destroy(two);
}

/* A membrane, pressed, over a flat obstacle: contact at each node, without tangents. The path is
 * solved on K, and create takes far less than the m^2 doubles of a W. Its limits can change there,
 * too. At each malloc that fails create unwinds. */
TEST(test_path_on_K) {
  enum { side = 40, n = side * side, m = 2 * n };
  static int p[n + 1], i[5 * n], id[n + 1], none[n + 1];
  static double x[5 * n], one[n], gap[n], load[n];
  int count = 0;
  for (int j = 0; j < n; j++) {
    const int at[5] = {j - side, j % side > 0 ? j - 1 : -1, j, j % side < side - 1 ? j + 1 : n,
                       j + side};
    for (int k = 0; k < 5; k++)
      if (at[k] >= 0 && at[k] < n) {
        i[count] = at[k];
        x[count++] = at[k] == j ? 4 : -1;
      }
    p[j + 1] = count;
    id[j] = j;
    one[j] = 1;
    gap[j] = 0.05;
    load[j] = -1e-3;
  }
  id[n] = n;
  const dls_motion_model model = {.d = 2,
                                  .n = n,
                                  .nodes = n,
                                  .factorization = DLS_CHOLESKY,
                                  .K = {n, n, p, i, x},
                                  .HN = {n, n, id, id, one},
                                  .HT = {n, n, none, i, x},
                                  .gap = gap};
  dls_motion_settings settings = moving_settings(DLS_MOTION_PATH, 1);
  dls_motion *motion = NULL;
  malloc_fails_at(0);
  ck_assert_int_eq(dls_motion_create(&motion, &model, &settings, NULL), DLS_OK);
  const size_t bytes = malloc_bytes();
  const long calls = malloc_calls();
  ck_assert(bytes < sizeof(double) * m * m / 4);
  dls_limits limits = settings.limits;
  limits.tol = -1;
  REFUSES(ARGUMENT, "tol", -1, dls_motion_set_limits, motion, &limits);
  limits.tol = 1e-10;
  ck_assert_int_eq(dls_motion_set_limits(motion, &limits, NULL), DLS_OK);
  for (int step = 0; step < 3; step++) {
    const dls_motion_state s = moving_step(motion, load, NULL, NULL);
    dls_contact problem;
    ck_assert_int_eq(dls_motion_get_problem(motion, &problem, NULL), DLS_OK);
    ck_assert_int_eq(problem.nc, 0); /* it was on K */
    int touches = 0;
    for (int c = 0; c < n; c++) { /* 0 <= gap _|_ p_n >= 0, and no tangent */
      ck_assert(s.gap[c] >= -1e-9 && s.p[2 * c] >= 0 && s.p[2 * c + 1] == 0);
      ck_assert(fabs(s.gap[c]) < 1e-9 || s.p[2 * c] == 0);
      touches += s.p[2 * c] > 0;
    }
    ck_assert(touches > 0 && touches < n);
    for (int j = 0; j < n; j++)
      load[j] *= 1.2;
  }
  dls_motion_destroy(motion);
  for (long k = 1; k <= calls; k++) {
    malloc_fails_at(k);
    const dls_status status = dls_motion_create(&motion, &model, &settings, NULL);
    malloc_fails_at(0);
    ck_assert(status == DLS_OK || (status == DLS_E_MEMORY && !motion));
    dls_motion_destroy(motion);
  }
}

/* start forgets the run: the next one has the same bits. */
TEST(test_start_again) {
  const dls_motion_model model = chain_model(1, 1, 1e-3);
  const dls_motion_settings settings = moving_settings(DLS_MOTION_VELOCITY, 0.05);
  chain_loads(1);
  dls_motion *motion = moving_create(&model, &settings, NULL, NULL);
  double first[2 * chain];
  for (int run = 0; run < 2; run++) {
    for (int k = 0; k < 30; k++)
      moving_step(motion, chain_load, NULL, chain_mu);
    if (run == 0) memcpy(first, moving_state(motion).x, sizeof first);
    ck_assert_mem_eq(moving_state(motion).x, first, sizeof first);
    ck_assert_int_eq(dls_motion_start(motion, NULL, NULL, 7, NULL), DLS_OK);
    ck_assert_double_eq(moving_state(motion).t, 7);
  }
  dls_motion_destroy(motion);
}

/* Lengths in units of a, forces of b, times of c: the run is the same. */
TEST(test_units) {
  const double a = 1e3, b = 1e-6, c = 60;
  double x[2 * chain];
  for (int turn = 0; turn < 2; turn++) {
    const double la = turn ? a : 1, lb = turn ? b : 1, lc = turn ? c : 1;
    const dls_motion_model model = chain_model(lb * lc * lc / la, lb / la, 1e-3 * la);
    dls_motion_settings settings = moving_settings(DLS_MOTION_VELOCITY, 0.05 * lc);
    settings.activation = 1e-9 * la;
    settings.restitution = 0.25;
    chain_loads(lb);
    dls_motion *motion = moving_create(&model, &settings, NULL, NULL);
    for (int k = 0; k < 40; k++)
      moving_step(motion, chain_load, NULL, chain_mu);
    for (int i = 0; i < 2 * chain; i++) {
      if (turn) ck_assert_double_eq_tol(moving_state(motion).x[i], a * x[i], 1e-9 * a);
      if (!turn) x[i] = moving_state(motion).x[i];
    }
    dls_motion_destroy(motion);
  }
}

/* Falls freely with h, h/2, h/8: theta = 1/2 is exact for any of them; a wrong h is refused. */
TEST(test_set_h) {
  const dls_motion_model model = point_model(2, 0, 100);
  const dls_motion_settings settings = moving_settings(DLS_MOTION_VELOCITY, 0.5);
  const double f[2] = {0, -6};
  dls_motion *motion = moving_create(&model, &settings, NULL, NULL);
  double h = 0.5;
  for (int k = 0; k < 6; k++) {
    const dls_motion_state s = moving_step(motion, f, NULL, NULL);
    ck_assert_double_eq_tol(s.x[1], -1.5 * s.t * s.t, 1e-13);
    REFUSES(ARGUMENT, "h", -1, dls_motion_set_h, motion, -1);
    h /= k % 2 ? 2 : 8;
    ck_assert_int_eq(dls_motion_set_h(motion, h, NULL), DLS_OK);
  }
  dls_motion_destroy(motion);
}

/* ---- wrong input ----------------------------------------------------------------------------- */

static void expect_create(const dls_motion_model *model, const dls_motion_settings *settings,
                          dls_status status, const char *argument, long long index) {
  dls_motion *motion = (dls_motion *)&parts;
  dls_error error;
  malloc_fails_at(0);
  const dls_status answer = dls_motion_create(&motion, model, settings, &error);
  const long work = malloc_calls();
  ck_assert_ptr_null(motion);
  expect_error(answer, &error, status, "dls_motion_create", argument, index);
  if (status != DLS_E_SINGULAR) ck_assert_int_le(work, 1); /* the motion itself, no work */
}

TEST(test_settings) {
  const dls_motion_model model = point_model(1, 0, 0);
  const dls_motion_settings good = moving_settings(DLS_MOTION_VELOCITY, 0.1);
  dls_motion_settings s;
#define EXPECT(change, argument)                                                                   \
  s = good;                                                                                        \
  change;                                                                                          \
  expect_create(&model, &s, DLS_E_ARGUMENT, argument, -1)
  EXPECT(s.h = 0, "h");
  EXPECT(s.h = -1, "h");
  EXPECT(s.h = (double)NAN, "h");
  EXPECT(s.h = (double)INFINITY, "h");
  EXPECT(s.theta = 0.49, "theta");
  EXPECT(s.theta = 1.01, "theta");
  EXPECT(s.theta = (double)NAN, "theta");
  EXPECT(s.restitution = -0.1, "restitution");
  EXPECT(s.restitution = 1.1, "restitution");
  EXPECT(s.activation = -1, "activation");
  EXPECT(s.forecast = 2, "forecast");
  EXPECT(s.law = (dls_motion_law)0, "law");
  EXPECT(s.law = (dls_motion_law)4, "law");
  EXPECT(s.law = DLS_MOTION_GAP, "theta");
  EXPECT((s.law = DLS_MOTION_GAP, s.theta = 1, s.restitution = 0.5), "restitution");
  EXPECT(s.limits.tol = -1, "tol");
  EXPECT(s.method = (dls_method)99, "method");
#undef EXPECT
  s = good;
  s.size = 0;
  expect_create(&model, &s, DLS_E_SETTINGS, "settings", -1);
  expect_create(&model, NULL, DLS_E_ARGUMENT, "settings", -1);
  expect_create(NULL, &good, DLS_E_ARGUMENT, "model", -1);
  REFUSES(ARGUMENT, "out", -1, dls_motion_create, NULL, &model, &good);
}

TEST(test_model) {
  const dls_motion_model good = point_model(1, 1, 0);
  const dls_motion_settings velocity = moving_settings(DLS_MOTION_VELOCITY, 0.1);
  const dls_motion_settings path = moving_settings(DLS_MOTION_PATH, 0.1);
  const double bad[2] = {1, (double)NAN};
  dls_motion_model m;
#define EXPECT(settings, status, change, argument, index)                                          \
  m = good;                                                                                        \
  change;                                                                                          \
  expect_create(&m, &(settings), status, argument, index)
  EXPECT(velocity, DLS_E_ARGUMENT, m.d = 4, "d", -1);
  EXPECT(velocity, DLS_E_SIZE, m.n = 0, "n", -1);
  EXPECT(velocity, DLS_E_SIZE, m.nodes = -1, "nodes", -1);
  EXPECT(velocity, DLS_E_ARGUMENT, m.M.p = NULL, "M", -1);
  EXPECT(velocity, DLS_E_SIZE, m.M.cols = 3, "M", -1);
  EXPECT(velocity, DLS_E_NOT_FINITE, m.M.x = bad, "M", 1);
  EXPECT(velocity, DLS_E_SIZE, m.K.rows = 1, "K", -1);
  EXPECT(velocity, DLS_E_NOT_FINITE, m.K.x = bad, "K", 1);
  EXPECT(velocity, DLS_E_NOT_FINITE, (m.C = m.K, m.C.x = bad), "C", 1);
  EXPECT(velocity, DLS_E_SIZE, m.HN.rows = 7, "HN", -1);
  EXPECT(velocity, DLS_E_SIZE, m.HT.cols = 7, "HT", -1);
  EXPECT(velocity, DLS_E_NOT_FINITE, m.gap = bad + 1, "gap", 0);
  EXPECT(velocity, DLS_E_SIZE, m.P = m.K, "P", -1);
  EXPECT(path, DLS_E_ARGUMENT, (void)m, "M", -1);
  EXPECT(path, DLS_E_ARGUMENT, (m.M.p = NULL, m.C = m.K), "C", -1);
  EXPECT(path, DLS_E_ARGUMENT, m.M.p = m.K.p = NULL, "K", -1);
  const double zero[2] = {0, 0};
  EXPECT(velocity, DLS_E_SINGULAR, m.M.x = m.K.x = zero, "M", 0);
  dls_motion_settings on_W = path; /* auto would take K */
  on_W.method = DLS_NLGS;
  EXPECT(on_W, DLS_E_SINGULAR, (m.M.p = NULL, m.K.x = zero), "K", 0);
#undef EXPECT
}

TEST(test_arguments) {
  const dls_motion_model model = point_model(1, 1, 0);
  const dls_motion_settings settings = moving_settings(DLS_MOTION_VELOCITY, 0.1);
  const double bad[2] = {0, (double)NAN}, minus = -1;
  dls_motion *motion = moving_create(&model, &settings, NULL, NULL);
  dls_error error;
#define EXPECT(call, name, status, argument, index)                                                \
  expect_error(call, &error, status, name, argument, index)
  const char *const step = "dls_motion_step";
  EXPECT(dls_motion_step(NULL, NULL, NULL, NULL, NULL, &error), step, DLS_E_ARGUMENT, "motion", -1);
  EXPECT(dls_motion_step(motion, bad, NULL, NULL, NULL, &error), step, DLS_E_NOT_FINITE, "f", 1);
  EXPECT(dls_motion_step(motion, NULL, bad, NULL, NULL, &error), step, DLS_E_NOT_FINITE, "y", 1);
  EXPECT(dls_motion_step(motion, NULL, NULL, &minus, NULL, &error), step, DLS_E_ARGUMENT, "mu", 0);
  const double huge[2] = {1e308, 1e308};
  ck_assert_int_lt(dls_motion_step(motion, huge, NULL, NULL, NULL, NULL) |
                       dls_motion_step(motion, huge, NULL, NULL, NULL, NULL),
                   1);
  const char *const start = "dls_motion_start";
  EXPECT(dls_motion_start(NULL, NULL, NULL, 0, &error), start, DLS_E_ARGUMENT, "motion", -1);
  EXPECT(dls_motion_start(motion, bad, NULL, 0, &error), start, DLS_E_NOT_FINITE, "x", 1);
  EXPECT(dls_motion_start(motion, NULL, bad, 0, &error), start, DLS_E_NOT_FINITE, "v", 1);
  EXPECT(dls_motion_start(motion, NULL, NULL, bad[1], &error), start, DLS_E_NOT_FINITE, "t", 0);
  const dls_motion_model pressed = point_model(0, 1, 0);
  const dls_motion_settings along = moving_settings(DLS_MOTION_PATH, 1);
  dls_motion *path = moving_create(&pressed, &along, NULL, NULL);
  EXPECT(dls_motion_start(path, NULL, huge, 0, &error), start, DLS_E_ARGUMENT, "v", -1);
  dls_motion_destroy(path);
  EXPECT(dls_motion_set_h(NULL, 1, &error), "dls_motion_set_h", DLS_E_ARGUMENT, "motion", -1);
  const dls_limits negative = {.tol = -1};
  EXPECT(dls_motion_set_limits(NULL, &settings.limits, &error), "dls_motion_set_limits",
         DLS_E_ARGUMENT, "motion", -1);
  EXPECT(dls_motion_set_limits(motion, NULL, &error), "dls_motion_set_limits", DLS_E_ARGUMENT,
         "limits", -1);
  EXPECT(dls_motion_set_limits(motion, &negative, &error), "dls_motion_set_limits", DLS_E_ARGUMENT,
         "tol", -1);
  EXPECT(dls_motion_get_state(motion, NULL, &error), "dls_motion_get_state", DLS_E_ARGUMENT,
         "state", -1);
  EXPECT(dls_motion_get_energies(motion, NULL, &error), "dls_motion_get_energies", DLS_E_ARGUMENT,
         "energies", -1);
  EXPECT(dls_motion_get_problem(motion, NULL, &error), "dls_motion_get_problem", DLS_E_ARGUMENT,
         "problem", -1);
#undef EXPECT
  dls_motion_destroy(motion);
  dls_motion_destroy(NULL);
  dls_motion_settings_init(NULL);
}

/* Every malloc of create fails in turn; so do those of set_h. */
TEST(test_malloc) {
  const dls_motion_model model = chain_model(1, 1, 1e-3);
  const dls_motion_settings settings = moving_settings(DLS_MOTION_VELOCITY, 0.05);
  dls_motion *motion = NULL;
  dls_status status = DLS_E_MEMORY;
  long k = 1;
  for (; status == DLS_E_MEMORY; k++) {
    malloc_fails_at(k);
    status = dls_motion_create(&motion, &model, &settings, NULL);
    malloc_fails_at(0);
    ck_assert_int_eq(status != DLS_OK, motion == NULL);
  }
  ck_assert_int_eq(status, DLS_OK);
  ck_assert_int_gt(k, 8);
  chain_loads(1);
  malloc_fails_at(0);
  status = dls_motion_step(motion, chain_load, NULL, chain_mu, NULL, NULL);
  ck_assert_int_eq(malloc_calls(), 0);
  ck_assert_int_eq(status, DLS_OK);
  dls_motion_destroy(motion);
}
