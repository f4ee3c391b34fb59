/* test_step.c: every figure of a step against its formula, from dense matrices; when contacts are
 * closed; what a start forgets; the reports. */
#include "made.h"
#include "motion/motion_internal.h"
#include "moving.h"
#include "run.h"

/* Two points (x, y) in the plane, coupled by M, C and K; normals y and tangents x, of the second
 * node in twice and minus the unit; candidates of three quarters of node 0 and one of node 1, and
 * of node 1 alone. */
enum { n = 4, m = 4 };

static const double dense_M[n * n] = {4, 1, 0, 0, 1, 2, 0.5, 0, 0, 0.5, 3, 0, 0, 0, 0, 2},
                                dense_C[n * n] = {1,   0, 0.5, 0, 0, 0.25, 0, 0,
                                                  0.5, 0, 1,   0, 0, 0,    0, 0.5},
                                dense_K[n * n] = {9, 2, 0, 1, 2, 8, 1, 0, 0, 1, 7, 2, 1, 0, 2, 6};
static const double L[n * m] = {0, 1, 0, 0, 1, 0, 0, 0, 0, 0, 0, 2, 0, 0, -1, 0}; /* n x 2 nodes */
static const double P[4] = {0.75, 0.25, 0, 1};                                    /* 2 x 2 */

static moving_parts parts;

static dls_motion_model step_model(int path) {
  static const int hp[] = {0, 1, 2}, hn[] = {1, 3}, ht[] = {0, 2}, pp[] = {0, 2, 3},
                   pi[] = {0, 1, 1};
  static const double xn[] = {1, 2}, xt[] = {1, -1}, xp[] = {0.75, 0.25, 1}, gap[] = {0.125, -0.5};
  moving_begin(&parts, n);
  if (!path) moving_add_dense(&parts.M, n, dense_M);
  if (!path) moving_add_dense(&parts.C, n, dense_C);
  moving_add_dense(&parts.K, n, dense_K);
  dls_motion_model model = moving_model(&parts);
  model.nodes = 2;
  model.HN = (dls_sparse){n, 2, hp, hn, xn};
  model.HT = (dls_sparse){n, 2, hp, ht, xt};
  model.P = (dls_sparse){2, 2, pp, pi, xp};
  model.gap = gap;
  return model;
}

/* y := A x and a := |A||x| */
static void step_multiply(const double *A, const double *x, double *y, double *a) {
  for (int i = 0; i < n; i++) {
    y[i] = a[i] = 0;
    for (int j = 0; j < n; j++) {
      y[i] += A[i + n * j] * x[j];
      a[i] += fabs(A[i + n * j] * x[j]);
    }
  }
}

static double step_dot(const double *x, const double *y) {
  double sum = 0;
  for (int i = 0; i < n; i++)
    sum += x[i] * y[i];
  return sum;
}

/* c := P^T (L^T x - s y), of all candidates */
static void step_local(const double *x, double s, const double *y, double *c) {
  double local[4];
  for (int k = 0; k < 4; k++) {
    local[k] = -s * y[k];
    for (int i = 0; i < n; i++)
      local[k] += L[i + n * k] * x[i];
  }
  for (int a = 0; a < 2; a++)
    for (int i = 0; i < 2; i++)
      c[2 * a + i] = P[2 * a] * local[i] + P[2 * a + 1] * local[2 + i];
}

typedef struct record {
  double x[n], v[n], slip[2], way[4], gap0[2];
  dls_motion_energies e;
} record;

/* (|v|.|M||v| + |x|.|K||x|) / 2 and both energies */
static double step_energies(const double *x, const double *v, int path, double *kinetic,
                            double *elastic) {
  double y[n], a[n], size = 0;
  step_multiply(dense_K, x, y, a);
  *elastic = step_dot(x, y) / 2;
  for (int i = 0; i < n; i++)
    size += fabs(x[i]) * a[i] / 2;
  *kinetic = 0;
  if (path) return size;
  step_multiply(dense_M, v, y, a);
  *kinetic = step_dot(v, y) / 2;
  for (int i = 0; i < n; i++)
    size += fabs(v[i]) * a[i] / 2;
  return size;
}

static void expect_near(double found, double expected, const char *what) {
  ck_assert_msg(fabs(found - expected) <= 1e-12 * (1 + fabs(expected)), "%s: %.17g, not %.17g",
                what, found, expected);
}

static void step_check(const record *before, const dls_motion_state *s,
                       const dls_motion_energies *e, const dls_motion_settings *set,
                       const double *f, const double *y) {
  const int path = set->law == DLS_MOTION_PATH;
  const double h = set->h, theta = path ? 1 : set->theta;
  double dx[n], dv[n], vth[n], xth[n], Hp[n] = {0}, aHp[n] = {0}, t[n], a[n], b[n], sums[n];
  double old[4], now[4], given[4], to[4], zero[n] = {0}, way[4];
  for (int i = 0; i < n; i++) {
    dx[i] = s->x[i] - before->x[i];
    dv[i] = s->v[i] - before->v[i];
    vth[i] = before->v[i] + theta * dv[i];
    xth[i] = theta * s->x[i] + (1 - theta) * before->x[i];
    if (!path) expect_near(dx[i], h * vth[i], "x");
    if (path) expect_near(s->v[i], dx[i] / h, "v");
  }
  for (int c = 0; c < 2; c++) /* H p */
    for (int k = 0; k < 4; k++) {
      const double share = P[2 * c + k / 2] * s->p[2 * c + k % 2];
      for (int i = 0; i < n; i++) {
        Hp[i] += L[i + n * k] * share;
        aHp[i] += fabs(L[i + n * k] * share);
      }
    }
  for (int k = 0; k < 4; k++)
    way[k] = before->way[k] + h * y[k];
  step_local(before->v, 1, y, old);
  step_local(path ? dx : s->v, path ? h : 1, y, now);
  step_local(zero, -1, y, given);
  step_local(s->x, 1, way, to);
  double obstacle = 0, work[2] = {0};
  for (int k = 0; k < 4; k++) {
    expect_near(s->u[k], now[k], "u");
    obstacle += s->p[k] * given[k] * (path ? h : 1);
    work[k % 2] += s->p[k] * (path ? now[k] : theta * now[k] + (1 - theta) * old[k]);
    if (k % 2 == 0)
      expect_near(s->gap[k / 2], to[k] + P[k] * before->gap0[0] + P[k + 1] * before->gap0[1],
                  "gap");
    else
      expect_near(s->slip[k / 2],
                  before->slip[k / 2] +
                      (path ? now[k] : h * (theta * now[k] + (1 - theta) * old[k])),
                  "slip");
  }
  double kinetic, elastic;
  double scale = step_energies(s->x, s->v, path, &kinetic, &elastic);
  expect_near(e->kinetic, kinetic, "kinetic");
  expect_near(e->elastic, elastic, "elastic");
  expect_near(e->load, before->e.load + (path ? step_dot(f, dx) : h * step_dot(f, vth)), "load");
  expect_near(e->obstacle, before->e.obstacle + obstacle, "obstacle");
  expect_near(e->impact, before->e.impact + work[0], "impact");
  expect_near(e->friction, before->e.friction + work[1], "friction");
  for (int i = 0; i < n; i++) { /* terms of the momentum */
    b[i] = (path ? 1 : h) * f[i] + Hp[i];
    sums[i] = fabs((path ? 1 : h) * f[i]) + aHp[i];
  }
  double damping = 0, numerical = 0;
  step_multiply(dense_K, dx, t, a);
  numerical += (path ? -0.5 : 0.5 - theta) * step_dot(dx, t);
  if (!path) {
    step_multiply(dense_C, vth, t, a);
    damping = -h * step_dot(vth, t);
    for (int i = 0; i < n; i++) {
      b[i] -= h * t[i];
      sums[i] += h * a[i];
    }
    step_multiply(dense_M, dv, t, a);
    numerical += (0.5 - theta) * step_dot(dv, t);
    for (int i = 0; i < n; i++) {
      b[i] -= t[i];
      sums[i] += a[i];
    }
  }
  step_multiply(dense_K, xth, t, a);
  double step = 0;
  for (int i = 0; i < n; i++) {
    b[i] -= (path ? 1 : h) * t[i];
    sums[i] += (path ? 1 : h) * a[i];
    ck_assert_double_le(fabs(b[i]), 1e-11);
    step += fabs(path ? dx[i] : vth[i]) * sums[i];
  }
  expect_near(e->damping, before->e.damping + damping, "damping");
  expect_near(e->numerical, before->e.numerical + numerical, "numerical");
  scale = fmax(fmax(scale, before->e.scale), step + fabs(obstacle) + fabs(work[1]));
  expect_near(e->scale, scale, "scale");
}

/* Each law, theta = 1/2, 3/4, 1, over steps that touch, stick, slip and part; f and y change. */
TEST_EACH(steps_by_their_formulas, 0, 5) {
  static const dls_motion_law laws[] = {DLS_MOTION_VELOCITY, DLS_MOTION_VELOCITY,
                                        DLS_MOTION_VELOCITY, DLS_MOTION_GAP, DLS_MOTION_PATH};
  const int path = _i == 4;
  const dls_motion_model model = step_model(path);
  dls_motion_settings settings = moving_settings(laws[_i], 0.25);
  if (_i < 3) settings.theta = 0.5 + 0.25 * _i;
  if (_i == 1) settings.restitution = 0.5;
  const double x[n] = {0.5, -0.25, 0.125, 1}, v[n] = {1, -2, 0.5, -1}, mu[2] = {0.5, 0.25};
  dls_motion *motion = moving_create(&model, &settings, x, path ? NULL : v);
  record before = {.gap0 = {0.125, -0.5}};
  memcpy(before.x, x, sizeof x);
  if (!path) memcpy(before.v, v, sizeof v);
  before.e = moving_energies(motion);
  double kinetic, elastic;
  expect_near(before.e.scale, step_energies(x, before.v, path, &kinetic, &elastic), "scale");
  expect_near(before.e.kinetic, kinetic, "kinetic");
  expect_near(before.e.elastic, elastic, "elastic");
  int pressed = 0, parted = 0;
  for (int k = 0; k < 12; k++) {
    const double f[n] = {k % 3, k % 4 == 3 ? 9 : -7, 2 - k % 5, k % 2 ? -8 : 4};
    const double y[4] = {0.25 * (k % 3), 0.5 - k % 2, -0.125 * (k % 4), 0.25 * k};
    if (k == 6) ck_assert_int_eq(dls_motion_set_h(motion, settings.h = 0.125, NULL), DLS_OK);
    const dls_motion_state s = moving_step(motion, f, y, mu);
    const dls_motion_energies e = moving_energies(motion);
    step_check(&before, &s, &e, &settings, f, y);
    ck_assert(s.steps == k + 1 && s.candidates == 2 && s.n == n && s.d == 2);
    expect_near(s.t, k < 6 ? 0.25 * (k + 1) : 1.5 + 0.125 * (k - 5), "t");
    for (int c = 0; c < 2; c++) {
      pressed += s.p[2 * c] > 0;
      parted += s.p[2 * c] == 0;
      ck_assert_int_eq(s.state[c] == DLS_FREE, s.p[2 * c] == 0);
    }
    memcpy(before.x, s.x, sizeof before.x);
    memcpy(before.v, s.v, sizeof before.v);
    memcpy(before.slip, s.slip, sizeof before.slip);
    for (int i = 0; i < 4; i++)
      before.way[i] += settings.h * y[i];
    before.e = e;
  }
  ck_assert_msg(pressed > 3 && parted > 3, "%d, %d", pressed, parted);

  /* a start forgets all of it, and knows the velocities and the gaps of its state */
  ck_assert_int_eq(dls_motion_start(motion, x, path ? NULL : v, -3, NULL), DLS_OK);
  const dls_motion_state s = moving_state(motion);
  const dls_motion_energies e = moving_energies(motion);
  double u[4];
  const double zero[4] = {0};
  step_local(path ? zero : v, 0, zero, u);
  for (int k = 0; k < 4; k++) {
    expect_near(s.u[k], u[k], "u");
    ck_assert(s.p[k] == 0 && s.x[k] == x[k] && s.v[k] == (path ? 0 : v[k]));
  }
  step_local(x, 0, zero, u);
  expect_near(s.gap[0], u[0] + 0.75 * 0.125 - 0.25 * 0.5, "gap");
  expect_near(s.gap[1], u[2] - 0.5, "gap");
  for (int c = 0; c < 2; c++)
    ck_assert(s.slip[c] == 0 && s.state[c] == DLS_FREE);
  for (int k = 0; k < 4; k++)
    ck_assert(motion->now.way[k] == 0 && motion->zero[k] == 0);
  ck_assert(s.steps == 0 && s.t == -3 && s.active == 0);
  ck_assert(e.load == 0 && e.damping == 0 && e.obstacle == 0 && e.friction == 0);
  ck_assert(e.impact == 0 && e.numerical == 0 && e.residual == 0 && e.momentum == 0);
  dls_contact problem;
  ck_assert_int_eq(dls_motion_get_problem(motion, &problem, NULL), DLS_OK);
  ck_assert(problem.nc == 0 && problem.d == 2);
  ck_assert_int_eq(dls_motion_start(motion, NULL, NULL, 0, NULL), DLS_OK);
  for (int k = 0; k < n; k++)
    ck_assert(s.x[k] == 0 && s.v[k] == 0 && s.u[k] == 0);
  dls_motion_destroy(motion);
}

/* A momentum that does not hold is told: M dv - h f over its largest sum of terms, for M = diag(4,
 * 2), h = 1/2: of dv = (1, 0) alone 1; with f = (6, 0) 4 - 3 of 7; with f = (8, 6) and dv = (1, 1)
 * (0, -1) of 8. */
TEST(momentum_that_is_wrong) {
  moving_begin(&parts, 2);
  moving_add(&parts.M, 0, 0, 4);
  moving_add(&parts.M, 1, 1, 2);
  const dls_motion_model model = moving_model(&parts);
  const dls_motion_settings settings = moving_settings(DLS_MOTION_VELOCITY, 0.5);
  dls_motion *motion = moving_create(&model, &settings, NULL, NULL);
  dlsi_motion_keep(motion, &motion->now, &motion->next);
  ck_assert(dlsi_motion_momentum(motion, NULL, (double[]){0, 0}) == 0);
  ck_assert(dlsi_motion_momentum(motion, NULL, (double[]){1, 0}) == 1);
  ck_assert(dlsi_motion_momentum(motion, (double[]){6, 0}, (double[]){1, 0}) == 1. / 7);
  ck_assert(dlsi_motion_momentum(motion, (double[]){8, 6}, (double[]){1, 1}) == 1. / 8);
  dls_motion_destroy(motion);
}

/* A = M + h theta C + h^2 theta^2 K, entries as they stand, column by column; a path has K. */
TEST(matrix_of_a_step) {
  moving_begin(&parts, 2);
  moving_add(&parts.M, 0, 0, 4);
  moving_add(&parts.M, 1, 1, 5);
  moving_add(&parts.C, 1, 0, 2);
  moving_add(&parts.K, 0, 0, 64);
  moving_add(&parts.K, 1, 0, 32);
  moving_add(&parts.K, 1, 1, 128);
  moving_touch(&parts, 1, 0, 0);
  dls_motion_model model = moving_model(&parts);
  dls_motion_settings settings = moving_settings(DLS_MOTION_VELOCITY, 0.5);
  dls_motion *motion = moving_create(&model, &settings, NULL, NULL);
  const int p[] = {0, 4, 6}, i[] = {0, 1, 0, 1, 1, 1}, q[] = {0, 2, 3}, j[] = {0, 1, 1};
  const double ht = 0.25, x[] = {4, 2 * ht, 64 * ht * ht, 32 * ht * ht, 5, 128 * ht * ht};
  ck_assert(motion->A.rows == 2 && motion->A.cols == 2);
  ck_assert_mem_eq(motion->A.p, p, sizeof p);
  ck_assert_mem_eq(motion->A.i, i, sizeof i);
  ck_assert_mem_eq(motion->A.x, x, sizeof x);
  ck_assert_int_eq(dls_motion_set_h(motion, 0.25, NULL), DLS_OK);
  ck_assert(motion->A.x[1] == 0.25 && motion->A.x[2] == 1 && motion->A.x[0] == 4);
  dls_motion_destroy(motion);
  model.M.p = model.C.p = NULL;
  settings.law = DLS_MOTION_PATH;
  motion = moving_create(&model, &settings, NULL, NULL);
  ck_assert_mem_eq(motion->A.p, q, sizeof q);
  ck_assert_mem_eq(motion->A.i, j, sizeof j);
  ck_assert(motion->A.x[0] == 64 && motion->A.x[1] == 32 && motion->A.x[2] == 128);
  dls_motion_destroy(motion);
}

/* Closed: gap + forecast h u_n <= activation. Two masses, u_n = -2, h = 1/2, forecast 1/4: gaps up
 * to 1/4 + activation. */
TEST_EACH(candidates_that_are_closed, 0, 4) {
  const double least = 0x1p-40, activation = _i % 2 ? 0.125 : 0;
  const double gaps[2] = {0.25 + activation + (_i < 2 ? 0 : least), 0.25 + activation - least};
  moving_begin(&parts, 4);
  for (int i = 0; i < 4; i++)
    moving_add(&parts.M, i, i, 1);
  moving_touch(&parts, 1, 0, gaps[0]);
  moving_touch(&parts, 3, 2, gaps[1]);
  const dls_motion_model model = moving_model(&parts);
  dls_motion_settings settings = moving_settings(DLS_MOTION_VELOCITY, 0.5);
  settings.forecast = 0.25;
  settings.activation = activation;
  const double v[4] = {0, -2, 0, -2};
  dls_motion *motion = moving_create(&model, &settings, NULL, v);
  const dls_motion_state s = moving_step(motion, NULL, NULL, NULL);
  const int first = _i < 2 ? 0 : 1;
  ck_assert_int_eq(s.active, 2 - first);
  for (int k = first; k < 2; k++)
    ck_assert_int_eq(s.active_list[k - first], k);
  ck_assert(s.p[0] == (first ? 0 : 2) && s.p[2] == 2);
  ck_assert_int_eq(s.state[0] == DLS_FREE, first);
  ck_assert_int_ne(s.state[1], DLS_FREE);
  dls_contact problem;
  ck_assert_int_eq(dls_motion_get_problem(motion, &problem, NULL), DLS_OK);
  ck_assert_int_eq(problem.nc, 2 - first);
  dls_motion_destroy(motion);
}

/* Two coupled masses rest under a load: with a smaller step the impulses are smaller in proportion,
 * so that Gauss-Seidel, which begins with these, ends as soon as with the step before. */
TEST(impulses_begin_in_proportion) {
  moving_begin(&parts, 4);
  for (int i = 0; i < 4; i++) {
    moving_add(&parts.M, i, i, 2);
    if (i < 2) moving_add(&parts.M, i + 2, i, 1);
  }
  moving_touch(&parts, 1, 0, 0);
  moving_touch(&parts, 3, 2, 0);
  const dls_motion_model model = moving_model(&parts);
  dls_motion_settings settings = moving_settings(DLS_MOTION_VELOCITY, 0.5);
  settings.method = DLS_NLGS;
  const double f[4] = {0, -8, 0, -4}, mu[2] = {0.5, 0.5};
  dls_motion *motion = moving_create(&model, &settings, NULL, NULL);
  dls_info info[4];
  static const double h[] = {0.5, 0.5, 0.125, 0.25};
  for (int k = 0; k < 4; k++) {
    ck_assert_int_eq(dls_motion_set_h(motion, h[k], NULL), DLS_OK);
    ck_assert_int_eq(dls_motion_step(motion, f, NULL, mu, &info[k], NULL), DLS_OK);
    ck_assert_double_eq_tol(moving_state(motion).p[0], 8 * h[k], 1e-11);
    if (k > 0) ck_assert_int_le(info[k].iterations, info[1].iterations);
  }
  ck_assert_int_lt(info[1].iterations, info[0].iterations);
  dls_motion_destroy(motion);
}

/* The iterations of a step are those of its contact problem, from the same start. */
TEST_EACH(iterations_of_a_step, 0, 2) {
  const dls_motion_model model = step_model(_i);
  dls_motion_settings settings = moving_settings(_i ? DLS_MOTION_PATH : DLS_MOTION_VELOCITY, 1);
  settings.method = DLS_NLGS;
  settings.activation = 100;
  const double f[n] = {3, -9, -5, -8}, mu[2] = {0.25, 0.25};
  dls_motion *motion = moving_create(&model, &settings, NULL, NULL);
  dls_info info, again;
  dls_contact problem;
  ck_assert_int_eq(dls_motion_step(motion, f, NULL, mu, &info, NULL), DLS_OK);
  ck_assert_int_eq(dls_motion_get_problem(motion, &problem, NULL), DLS_OK);
  ck_assert_int_eq(problem.nc, 2);
  dls_solver_settings solver = settings_with(DLS_NLGS, default_tol);
  solver.limits = settings.limits;
  double r[m] = {0};
  ck_assert_int_eq(dls_solve(&problem, &solver, r, NULL, &again, NULL), DLS_OK);
  ck_assert_int_gt(info.iterations, 0);
  ck_assert_int_eq(info.iterations, again.iterations);
  ck_assert_mem_eq(moving_state(motion).p, r, sizeof r);
  dls_motion_destroy(motion);
}

TEST(defaults) {
  dls_motion_settings s;
  memset(&s, 77, sizeof s);
  dls_motion_settings_init(&s);
  ck_assert(s.size == sizeof s && s.law == DLS_MOTION_VELOCITY && s.method == DLS_AUTO);
  ck_assert(s.theta == 0.5 && s.forecast == 0.5 && s.limits.tol == 1e-12);
  ck_assert(s.limits.warm_start == 1 && s.h == 0 && s.restitution == 0);
  ck_assert(s.activation == 0);
}

/* Settings at their limits pass; beyond, the value is told. */
TEST(limits_of_settings) {
  moving_begin(&parts, 2);
  moving_add(&parts.M, 0, 0, 1);
  moving_add(&parts.M, 1, 1, 1);
  moving_touch(&parts, 1, 0, 0);
  const dls_motion_model model = moving_model(&parts);
  dls_motion_settings s = moving_settings(DLS_MOTION_VELOCITY, DBL_MIN);
  dls_motion *motion;
  s.activation = DBL_MAX;
  s.restitution = s.forecast = s.theta = 1;
  ck_assert_int_eq(dls_motion_create(&motion, &model, &s, NULL), DLS_OK);
  ck_assert(moving_state(motion).t == 0 && moving_state(motion).steps == 0);
  dls_motion_destroy(motion);
  s.activation = s.restitution = s.forecast = 0;
  s.theta = 0.5;
  ck_assert_int_eq(dls_motion_create(&motion, &model, &s, NULL), DLS_OK);
  dls_motion_destroy(motion);
  s.law = DLS_MOTION_GAP;
  s.theta = 0.75;
  REFUSES(ARGUMENT, "theta", -1, dls_motion_create, &motion, &model, &s);
  ck_assert(last_refusal.value == 0.75);
  s.theta = 1;
  s.restitution = 0.25;
  REFUSES(ARGUMENT, "restitution", -1, dls_motion_create, &motion, &model, &s);
  ck_assert(last_refusal.value == 0.25);
  s.restitution = 0;
  ck_assert_int_eq(dls_motion_create(&motion, &model, &s, NULL), DLS_OK);
  dls_motion_destroy(motion);
}

/* The matrix of a reduction, its Ks, has the name that the host knows. */
TEST_EACH(singular_by_its_name, 0, 2) {
  const int path = _i;
  moving_begin(&parts, 2);
  moving_add(path ? &parts.K : &parts.M, 0, 0, 1);
  moving_add(path ? &parts.K : &parts.M, 1, 1, 0);
  moving_touch(&parts, 1, 0, 0);
  const dls_motion_model model = moving_model(&parts);
  dls_motion_settings s = moving_settings(path ? DLS_MOTION_PATH : DLS_MOTION_VELOCITY, 0.5);
  dls_motion *motion;
  if (path) s.method = DLS_NLGS; /* auto takes K */
  REFUSES(SINGULAR, path ? "K" : "M", 1, dls_motion_create, &motion, &model, &s);
  ck_assert(!strstr(last_refusal.message, "Ks") && !strstr(last_refusal.message, "reduction"));
  ck_assert_ptr_nonnull(strstr(last_refusal.message, path ? "K[1]" : "M[1]"));
  ck_assert_ptr_nonnull(strstr(last_refusal.message, "singular: "));
}

/* A step that overflows names x or v and leaves the state. */
TEST_EACH(steps_that_overflow, 0, 2) {
  moving_begin(&parts, 2);
  moving_add(&parts.M, 0, 0, 1);
  moving_add(&parts.M, 1, 1, 1);
  moving_touch(&parts, 1, -1, 0);
  const dls_motion_model model = moving_model(&parts);
  dls_motion_settings s = moving_settings(DLS_MOTION_VELOCITY, _i ? 0.5 : 4);
  const double v[2] = {_i ? 1.5e308 : 1e308, 1}, f[2] = {_i ? 1e308 : 0, 0};
  dls_motion *motion = moving_create(&model, &s, NULL, (double[]){0, 1});
  ck_assert_int_eq(dls_motion_start(motion, NULL, v, 0, NULL), DLS_OK);
  REFUSES(NOT_FINITE, _i ? "v" : "x", 0, dls_motion_step, motion, f, NULL, NULL, NULL);
  ck_assert(last_refusal.value > DBL_MAX && moving_state(motion).steps == 0 &&
            moving_state(motion).x[0] == 0);
  dls_motion_destroy(motion);
}
