/*
 * test_limit.c: dls_limit_load beside limits by hand, and beside planted ones: random bodies, a
 * motion b and reactions r on the cones of the contacts that b slides on. r is an answer at the
 * planted lambda, and beyond it b proves that there is none. test_limit COUNT plants COUNT of them.
 */
#include "delassus.h"
#include "front_cases.h"
#include "run.h"

enum { most = 24, contacts = 12, columns = 2 * contacts };

/* A body, or several: H by columns, K sparse. */
typedef struct body {
  int d, n, nc;
  double N[contacts][most], T[columns][most];
  double f0[most], f1[most], mu[contacts];
  double K[most][most];
  int pN[contacts + 1], iN[contacts * most], pT[columns + 1], iT[columns * most];
  int pK[most + 1], iK[most * most];
  double xN[contacts * most], xT[columns * most], xK[most * most];
  double r[3 * contacts], x[most], motion[most];
} body;

static void columns_of(int cols, int n, const double *a, int lower, int *p, int *i, double *x) {
  int e = p[0] = 0;
  for (int j = 0; j < cols; j++) {
    for (int k = lower ? j : 0; k < n; k++)
      if (a[j * most + k] != 0) i[e] = k, x[e++] = a[j * most + k];
    p[j + 1] = e;
  }
}

static dls_reduction *reduction_of(body *b) {
  columns_of(b->nc, b->n, b->N[0], 0, b->pN, b->iN, b->xN);
  columns_of((b->d - 1) * b->nc, b->n, b->T[0], 0, b->pT, b->iT, b->xT);
  columns_of(b->n, b->n, b->K[0], 1, b->pK, b->iK, b->xK);
  const dls_model model = {.d = b->d,
                           .n = b->n,
                           .nodes = b->nc,
                           .operator_kind = DLS_STIFFNESS_SPARSE,
                           .factorization = DLS_CHOLESKY,
                           .Ks = {b->n, b->n, b->pK, b->iK, b->xK},
                           .HN = {b->n, b->nc, b->pN, b->iN, b->xN},
                           .HT = {b->n, (b->d - 1) * b->nc, b->pT, b->iT, b->xT}};
  dls_reduction *reduction;
  dls_error error;
  ck_assert_msg(!dls_reduction_create(&reduction, &model, NULL, &error), "%s", error.message);
  return reduction;
}

/* b.(f0 + lambda f1), and what a proof asks of the motion at each contact. */
static void assert_proof(const body *b, double lambda, const double *mu) {
  double work = 0;
  for (int i = 0; i < b->n; i++)
    work += b->motion[i] * (b->f0[i] + lambda * b->f1[i]);
  ck_assert_double_gt(work, 0);
  for (int c = 0; c < b->nc; c++) {
    double normal = 0, tangent[2] = {0};
    for (int i = 0; i < b->n; i++) {
      normal += b->N[c][i] * b->motion[i];
      for (int k = 0; k < b->d - 1; k++)
        tangent[k] += b->T[(b->d - 1) * c + k][i] * b->motion[i];
    }
    ck_assert_double_ge(normal, mu[c] * hypot(tangent[0], tangent[1]) - 1e-11);
  }
  for (int i = 0; i < b->n; i++) {
    double Kb = 0;
    for (int j = 0; j < b->n; j++)
      Kb += b->K[i][j] * b->motion[j];
    ck_assert_double_le(fabs(Kb), 1e-9);
  }
}

/* Finds the limit from 0; both sides meet, with a proof. Returns `carried`. */
static dls_limit limit_of(body *b, const dls_limit_settings *settings) {
  dls_reduction *reduction = reduction_of(b);
  dls_limit limit;
  dls_error error;
  const dls_status status = dls_limit_load(reduction, b->f0, b->f1, NULL, b->mu, NULL, settings,
                                           b->r, b->x, b->motion, &limit, &error);
  ck_assert_msg(status >= 0, "%s", error.message);
  dls_reduction_destroy(reduction);
  if (limit.proved) assert_proof(b, limit.refused, b->mu);
  return limit;
}

static void expect_limit(body *b, double expected) {
  const dls_limit limit = limit_of(b, NULL);
  ck_assert(limit.proved);
  ck_assert_double_le(limit.carried, expected * (1 + 1e-8));
  ck_assert_double_ge(limit.refused, expected * (1 - 1e-8));
  ck_assert_double_le(limit.refused - limit.carried, 1e-6 * limit.refused);
  ck_assert_int_le(limit.solves, 8);
  dls_limit_settings fine;
  dls_limit_settings_init(&fine);
  fine.tol = 1e-9;
  const dls_limit close = limit_of(b, &fine);
  ck_assert_double_eq_tol(close.carried, expected, 1e-8 * expected);
  ck_assert_double_eq_tol(close.refused, expected, 1e-8 * expected);
}

/* Contact c of the rigid body at unknowns 3 a: at (x, y) from its centre, normal (nx, ny). */
static void touch(body *b, int c, int a, double x, double y, double nx, double ny, double sign) {
  double *N = b->N[c] + 3 * a, *T = b->T[c] + 3 * a;
  N[0] += sign * nx, N[1] += sign * ny, N[2] += sign * (x * ny - y * nx);
  T[0] += sign * ny, T[1] -= sign * nx, T[2] -= sign * (x * nx + y * ny);
}

/* A box of width 1 and height h, weight 1, on the floor, pushed at its top: it slides at mu, or
 * tips over its edge at 1 / (2 h). */
TEST(box_slides_or_tips) {
  for (int tips = 0; tips < 2; tips++) {
    const double h = tips ? 2 : 0.5;
    body b = {.d = 2, .n = 3, .nc = 2, .mu = {0.4, 0.4}, .f0 = {0, -1}, .f1 = {1, 0, -h / 2}};
    touch(&b, 0, 0, -0.5, -h / 2, 0, 1, 1);
    touch(&b, 1, 0, 0.5, -h / 2, 0, 1, 1);
    expect_limit(&b, tips ? 1 / (2 * h) : 0.4);
    /* pulled the other way, downwards in lambda */
    dls_limit_settings settings;
    dls_limit_settings_init(&settings);
    settings.to = -INFINITY;
    const dls_limit limit = limit_of(&b, &settings);
    ck_assert(limit.proved && limit.carried < 0);
    ck_assert_double_eq_tol(limit.carried, tips ? -1 / (2 * h) : -0.4, 1e-6);
  }
}

/* A plate between two jaws that are pressed together with 3, mu = .4: a lap joint, a grasp. It is
 * pulled out at 2 .4 3. The jaws, bodies 1 and 2, are held by a guide, contact 2, 3. */
TEST(lap_joint) {
  body b = {.d = 2, .n = 9, .nc = 8, .f0 = {0, 0, 0, 0, -3, 0, 0, 3, 0}, .f1 = {1}};
  for (int side = 0; side < 2; side++)
    for (int k = 0; k < 2; k++) {
      const int c = 2 * side + k, g = 4 + c;
      const double x = k ? 1 : -1, up = side ? -1 : 1;
      b.mu[c] = 0.4;
      touch(&b, c, 1 + side, x, -0.5 * up, 0, up, 1); /* jaw on plate */
      touch(&b, c, 0, x, 0.1 * up, 0, up, -1);
      touch(&b, g, 1 + side, k ? 1 : -1, 0, k ? -1 : 1, 0, 1); /* between two smooth walls */
    }
  expect_limit(&b, 2.4);
}

/* Two masses joined by a spring, of weight 2 and 3, mu = .3, .2; the first one is pushed towards
 * the second. Both slide at .3 * 2 + .2 * 3; the friction of the second shortens the spring. */
TEST(elastic_pair) {
  body b = {.d = 2, .n = 4, .nc = 2, .mu = {0.3, 0.2}, .f0 = {0, -2, 0, -3}, .f1 = {1}};
  const double k = 100;
  b.K[0][0] = b.K[2][2] = k;
  b.K[0][2] = b.K[2][0] = -k;
  for (int c = 0; c < 2; c++)
    b.N[c][2 * c + 1] = b.T[c][2 * c] = 1;
  expect_limit(&b, 1.2);
  ck_assert_double_eq_tol(b.x[0] - b.x[2], 0.6 / k, 1e-5 / k);
}

/* An elastic punch, three nodes of weight 1 joined by bars, stands on two of them, mu = .3, and is
 * pushed at the third: it slides at .3 * 3, before it tips at 3. */
TEST(elastic_punch) {
  const double at[3][2] = {{-0.5, 0}, {0.5, 0}, {0, 0.5}};
  body b = {
      .d = 2, .n = 6, .nc = 2, .mu = {0.3, 0.3}, .f0 = {0, -1, 0, -1, 0, -1}, .f1 = {[4] = 1}};
  for (int i = 0; i < 3; i++) {
    const int j = (i + 1) % 3;
    const double dx = at[j][0] - at[i][0], dy = at[j][1] - at[i][1], length = hypot(dx, dy);
    const double e[2] = {dx / length, dy / length};
    for (int p = 0; p < 2; p++)
      for (int q = 0; q < 2; q++) {
        const double k = 100 / length * e[p] * e[q];
        b.K[2 * i + p][2 * i + q] += k;
        b.K[2 * j + p][2 * j + q] += k;
        b.K[2 * i + p][2 * j + q] -= k;
        b.K[2 * j + p][2 * i + q] -= k;
      }
  }
  for (int c = 0; c < 2; c++)
    b.N[c][2 * c + 1] = b.T[c][2 * c] = 1;
  expect_limit(&b, 0.9);
  ck_assert_double_eq_tol(b.r[0] + b.r[2], 3, 1e-7);
  ck_assert_double_eq_tol(b.r[1] + b.r[3], -0.9, 1e-7);
  /* moments about the right foot: r_n of the left one */
  ck_assert_double_eq_tol(b.r[0], 3 * 0.5 - 0.9 * 0.5, 1e-7);
}

/* On a slope of 3 : 4 a box needs the friction 3/4; a held body carries all, and one that falls
 * carries nothing. */
TEST(friction_and_ends) {
  body b = {.d = 2, .n = 3, .nc = 2, .mu = {0, 0}, .f0 = {3, -4}};
  touch(&b, 0, 0, -1, -0.1, 0, 1, 1);
  touch(&b, 1, 0, 1, -0.1, 0, 1, 1);
  dls_reduction *reduction = reduction_of(&b);
  const double grows[] = {1, 1};
  dls_limit limit;
  dls_limit_settings s;
  dls_limit_settings_init(&s);
  s.from = 2;
  s.to = 0;
  s.tol = 1e-9;
  s.limits.tol = 1e-10;
  ck_assert(!dls_limit_load(reduction, b.f0, NULL, NULL, b.mu, grows, &s, b.r, b.x, b.motion,
                            &limit, NULL));
  ck_assert(limit.proved && limit.refused <= 0.75 && limit.carried >= 0.75 - 1e-8);
  ck_assert_double_le(limit.carried - limit.refused, 1e-8);
  const double needed[] = {limit.refused, limit.refused};
  assert_proof(&b, 0, needed);
  /* at the start nothing is certified: it slides */
  s.from = 0.5;
  memset(b.motion, 0, sizeof b.motion);
  ck_assert_int_eq(dls_limit_load(reduction, b.f0, NULL, NULL, b.mu, grows, &s, b.r, b.x, b.motion,
                                  &limit, NULL),
                   DLS_NO_SOLUTION);
  ck_assert(isnan(limit.carried) && limit.refused == 0.5 && limit.proved && limit.solves == 1);
  dls_reduction_destroy(reduction);
  b.f1[0] = 1;
  b.f0[0] = 0;
  for (int i = 0; i < 3; i++)
    b.K[i][i] = 10;
  limit = limit_of(&b, NULL);
  ck_assert(!limit.proved && isinf(limit.refused) && isnan(limit.open) && limit.solves < 20);
  dls_limit_settings_init(&s);
  s.to = 5;
  limit = limit_of(&b, &s);
  ck_assert(!limit.proved && limit.carried == 5 && limit.refused == 5);
}

/* W alone: a rod of compliance 1 between two walls, at gaps of 1 that both close by lambda. It
 * slides, and does not shrink. With W definite all loads are carried. */
TEST(without_stiffness) {
  for (int definite = 0; definite < 2; definite++) {
    const double q1[] = {-1, 0, -1, 0}, g[] = {1, 0, 1, 0}, mu[] = {0.3, 0.3}, one[] = {1, 1};
    const double f1[] = {0, 0, 0, 0, 1};
    double K[25] = {0}, r[4], x[5], motion[5];
    const int p[] = {0, 1, 2}, normal[] = {0, 2}, tangent[] = {1, 3};
    for (int i = 0; i < 4; i++) {
      K[6 * i] = 1;
      K[20 + i] = q1[i];
    }
    if (!definite) K[2] = K[10] = -1;
    const dls_model model = {.d = 2,
                             .n = 5,
                             .nodes = 2,
                             .operator_kind = DLS_FLEXIBILITY,
                             .factorization = DLS_LU,
                             .K = {5, 5, 5, K},
                             .HN = {5, 2, p, normal, one},
                             .HT = {5, 2, p, tangent, one}};
    dls_reduction *reduction;
    dls_limit limit;
    dls_error error;
    ck_assert_msg(!dls_reduction_create(&reduction, &model, NULL, &error), "%s", error.message);
    ck_assert(!dls_limit_load(reduction, NULL, f1, g, mu, NULL, NULL, r, x, motion, &limit, NULL));
    ck_assert(limit.proved == !definite);
    if (definite) ck_assert(isinf(limit.refused) && limit.carried > 1e6);
    if (!definite) ck_assert(limit.carried <= 1 + 1e-9 && limit.refused >= 1 - 1e-9);
    if (!definite) ck_assert(limit.refused - limit.carried <= 1e-6);
    for (int i = 0; i < 5 && !definite; i++)
      ck_assert(motion[i] == 0);
    dls_reduction_destroy(reduction);
  }
}

/* ---- planted limits -------------------------------------------------------------------------- */

static int limits = 300;
static int planted_solves[101], unsettled;

static void plant_limit(unsigned seed, body *b) {
  *b = (body){
      .d = 2 + (int)(seed % 2), .n = 3 + (int)(seed / 2 % 10), .nc = 3 + (int)(seed / 20 % 9)};
  double v[most], square = 0, load[most] = {0};
  for (int i = 0; i < b->n; i++)
    v[i] = draw(&seed), square += v[i] * v[i];
  for (int c = 0; c < b->nc; c++) {
    const int slides = draw(&seed) < 0.4;
    const double scale = exp(2 * draw(&seed));
    double t[2] = {0}, size = 0;
    b->mu[c] = fabs(draw(&seed));
    for (int k = 0; k < b->d - 1; k++) {
      double *T = b->T[(b->d - 1) * c + k];
      for (int i = 0; i < b->n; i++)
        T[i] = scale * draw(&seed), t[k] += T[i] * v[i];
    }
    size = hypot(t[0], t[1]);
    double normal = 0;
    const double wanted = b->mu[c] * size + (slides ? 0 : scale * fabs(draw(&seed)));
    for (int i = 0; i < b->n; i++)
      b->N[c][i] = scale * draw(&seed), normal += b->N[c][i] * v[i];
    for (int i = 0; i < b->n; i++)
      b->N[c][i] += (wanted - normal) / square * v[i];
    /* r at the limit, against the slip where b slides; r0 within all cones */
    const double rn = slides ? fabs(draw(&seed)) : 0, r0 = fabs(draw(&seed)),
                 part = draw(&seed) / 2;
    for (int i = 0; i < b->n; i++) {
      load[i] -= rn * b->N[c][i];
      b->f0[i] -= r0 * b->N[c][i];
      for (int k = 0; k < b->d - 1; k++) {
        const double *T = b->T[(b->d - 1) * c + k];
        if (size > 0) load[i] += b->mu[c] * rn * t[k] / size * T[i];
        if (size > 0) b->f0[i] += part * b->mu[c] * r0 * t[k] / size * T[i];
      }
    }
  }
  for (int i = 0; i < b->n; i++)
    b->f1[i] = load[i] - b->f0[i];
}

static void expect_planted(unsigned seed) {
  static body b;
  plant_limit(seed, &b);
  const dls_limit limit = limit_of(&b, NULL); /* checks the proof */
  planted_solves[limit.solves]++;
  ck_assert_msg(limit.refused >= 1 - 1e-8, "%u: refused at %.12g", seed, limit.refused);
  ck_assert_msg(limit.carried <= 1 + 1e-7, "%u: carried %.12g", seed, limit.carried);
  unsettled += !(limit.proved && limit.refused - limit.carried <= 1e-6 * limit.refused);
}

TEST(planted_limits) {
  int solves = 0, k = 0;
  for (int seed = 1; seed <= limits; seed++)
    expect_planted((unsigned)seed * 7919);
  while ((solves += planted_solves[k]) < limits / 2)
    k++;
  if (limits > 300) printf("median %d solves, %d of %d unsettled\n", k, unsettled, limits);
  ck_assert_int_le(k, 8);
  ck_assert_int_eq(unsettled, 0);
}

/* ---- an arch --------------------------------------------------------------------------------- */

enum { stones = 100, joints = 2 * (stones + 1), unknowns = 3 * stones };

/* A semicircle of rigid stones, mean radius 1, thickness .15, friction .7, pushed sideways with
 * lambda times its weight. Close to the limit the reactions of the hinges are small beside the
 * others: an answer there takes as few factors as one far below it. */
TEST(arch_close_to_its_limit) {
  static int p[2][joints + 1], row[2][6 * joints], none[unknowns + 1];
  static double value[2][6 * joints], f[2][unknowns], mu[joints], r[2 * joints], x[unknowns];
  const double step = 3.14159265358979 / stones, thick = 0.15;
  for (int a = 0; a < stones; a++) {
    f[0][3 * a + 1] = -step * thick;
    f[1][3 * a] = step * thick;
  }
  const double out = 1 + thick * thick / 12, half = sin(step / 2) / (step / 2) * out;
  for (int j = 0; j < joints; j++) {
    const double t = step * (j / 2), radius = 1 + thick * (j % 2 - 0.5);
    const double n[2] = {-sin(t), cos(t)}, at[2] = {radius * cos(t), radius * sin(t)};
    mu[j] = 0.7;
    for (int h = 0; h < 2; h++) {
      const double e[2] = {h ? n[1] : n[0], h ? -n[0] : n[1]};
      p[h][j + 1] = p[h][j];
      for (int side = 1; side >= 0; side--) { /* the stone before the joint, the one behind */
        const int a = j / 2 - side;
        if (a < 0 || a >= stones) continue;
        const double middle = step * (a + 0.5), sign = side ? -1 : 1;
        const double arm[2] = {at[0] - half * cos(middle), at[1] - half * sin(middle)};
        const double entry[3] = {e[0], e[1], arm[0] * e[1] - arm[1] * e[0]};
        for (int i = 0; i < 3; i++) {
          row[h][p[h][j + 1]] = 3 * a + i;
          value[h][p[h][j + 1]++] = sign * entry[i];
        }
      }
    }
  }
  const dls_model model = {.d = 2,
                           .n = unknowns,
                           .nodes = joints,
                           .operator_kind = DLS_STIFFNESS_SPARSE,
                           .factorization = DLS_CHOLESKY,
                           .Ks = {unknowns, unknowns, none, row[0], value[0]},
                           .HN = {unknowns, joints, p[0], row[0], value[0]},
                           .HT = {unknowns, joints, p[1], row[1], value[1]}};
  dls_reduction *reduction;
  dls_limit limit;
  dls_error error;
  ck_assert_msg(!dls_reduction_create(&reduction, &model, NULL, &error), "%s", error.message);
  ck_assert(!dls_limit_load(reduction, f[0], f[1], NULL, mu, NULL, NULL, r, x, NULL, &limit, NULL));
  ck_assert(limit.proved && limit.refused - limit.carried <= 1e-6 * limit.refused);
  ck_assert_int_le(limit.solves, 8);
  for (int i = 0; i < unknowns; i++)
    f[0][i] += limit.carried * f[1][i];
  dls_info info;
  ck_assert(!dls_reduction_load(reduction, f[0], NULL, NULL));
  ck_assert_int_eq(dls_reduction_solve(reduction, mu, NULL, r, NULL, x, &info, NULL), DLS_OK);
  ck_assert_int_le(info.stage[0].factorisations, 40);
  dls_reduction_destroy(reduction);
}

/* ---- arguments ------------------------------------------------------------------------------- */

static int cancel_at_once(void *data, const dls_progress *now) {
  (void)data, (void)now;
  return 1;
}

TEST(arguments) {
  body b = {.d = 2, .n = 3, .nc = 2, .mu = {0.4, 0.4}, .f0 = {0, -1}, .f1 = {1}};
  touch(&b, 0, 0, -0.5, -0.1, 0, 1, 1);
  touch(&b, 1, 0, 0.5, -0.1, 0, 1, 1);
  dls_reduction *reduction = reduction_of(&b);
  dls_limit limit = {.solves = -7};
  dls_error e;
  dls_limit_settings s;
  const char *const name = "dls_limit_load";
  const double nan[] = {0, NAN, 0}, falls[] = {-1, 0}, bad[] = {0.4, -1};
#define LIMIT(f0, f1, mu, mu1, s, r)                                                               \
  dls_limit_load(reduction, f0, f1, NULL, mu, mu1, s, r, b.x, NULL, &limit, &e)
  REFUSES(ARGUMENT, "reduction", -1, dls_limit_load, NULL, b.f0, b.f1, NULL, b.mu, NULL, NULL, b.r,
          b.x, NULL, &limit);
  expect_error(LIMIT(nan, b.f1, b.mu, NULL, NULL, b.r), &e, DLS_E_NOT_FINITE, name, "f0", 1);
  expect_error(LIMIT(b.f0, nan, b.mu, NULL, NULL, b.r), &e, DLS_E_NOT_FINITE, name, "f1", 1);
  expect_error(LIMIT(b.f0, NULL, b.mu, NULL, NULL, b.r), &e, DLS_E_ARGUMENT, name, "f1", -1);
  expect_error(LIMIT(b.f0, b.f1, NULL, NULL, NULL, b.r), &e, DLS_E_ARGUMENT, name, "mu", -1);
  expect_error(LIMIT(b.f0, b.f1, bad, NULL, NULL, b.r), &e, DLS_E_ARGUMENT, name, "mu", 1);
  expect_error(LIMIT(b.f0, b.f1, b.mu, nan, NULL, b.r), &e, DLS_E_NOT_FINITE, name, "mu1", 1);
  expect_error(LIMIT(b.f0, b.f1, b.mu, falls, NULL, b.r), &e, DLS_E_ARGUMENT, name, "mu1", 0);
  expect_error(LIMIT(b.f0, b.f1, b.mu, NULL, NULL, NULL), &e, DLS_E_ARGUMENT, name, "r", -1);
  dls_limit_settings_init(&s);
  s.tol = 0;
  expect_error(LIMIT(b.f0, b.f1, b.mu, NULL, &s, b.r), &e, DLS_E_ARGUMENT, name, "tol", -1);
  dls_limit_settings_init(&s);
  s.to = s.from;
  expect_error(LIMIT(b.f0, b.f1, b.mu, NULL, &s, b.r), &e, DLS_E_ARGUMENT, name, "to", -1);
  s.size = 0;
  expect_error(LIMIT(b.f0, b.f1, b.mu, NULL, &s, b.r), &e, DLS_E_SETTINGS, name, "settings", -1);
  ck_assert_int_eq(limit.solves, -7);
  dls_limit_settings_init(&s);
  s.most = 2;
  ck_assert_int_eq(LIMIT(b.f0, b.f1, b.mu, NULL, &s, b.r), DLS_MAX_ITERATIONS);
  ck_assert_int_eq(limit.solves, 2);
  dls_limit_settings_init(&s);
  s.limits.progress = cancel_at_once;
  ck_assert_int_eq(LIMIT(b.f0, b.f1, b.mu, NULL, &s, b.r), DLS_CANCELLED);
  ck_assert_int_le(limit.solves, 2);
  dls_reduction_destroy(reduction);
}

int main(int argc, char **argv) {
  if (argc > 1) limits = atoi(argv[1]);
  return run_tests("limit", NULL, NULL);
}
