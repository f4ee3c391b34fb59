/*
 * test_least.c: the least reactions of an answer's positions, and how many there are.
 *
 * Rigid bodies held by more contacts than determine their reactions: tables, an arch, a wall.
 * Solved by hand, or by every method and in two orders of the contacts.
 */
#include "delassus.h"
#include "front_cases.h"
#include "made.h"
#include "run.h"

static const double pi = 3.141592653589793;

enum { most_bodies = 60, most_nc = 160, most_m = 320, n2 = 3, n3 = 6 };

/* Bodies of d = 2 (x, y, turn) or 3 (x, y, z, three turns) and their contacts. */
typedef struct scene {
  int d, nc, count, body[2 * most_nc];
  double at[most_bodies][3], mass[most_bodies], inertia[most_bodies], H[2 * n2 * 2 * most_nc];
  double force[most_bodies][6], point[most_nc][3], normal[most_nc][2], q[most_m], mu[most_nc];
  double W[most_m * most_m], x[most_m * most_m];
  int p[most_nc + 1], i[most_nc * most_nc];
  dls_contact p_;
} scene;

static int motions(const scene *s) {
  return 3 * (s->d - 1);
}

/* Adds a body under its weight, 1 a mass, in -y (d = 2) or -z. */
static int add_body(scene *s, double x, double y, double z, double mass, double inertia) {
  const int k = s->count++;
  const double at[3] = {x, y, z};
  memcpy(s->at[k], at, sizeof at);
  s->mass[k] = mass;
  s->inertia[k] = inertia;
  s->force[k][s->d - 1] = -mass;
  return k;
}

/* Adds a contact at (x, y, z) between body a (-1: the ground) and b; (nx, ny), d = 2: the normal
 * into b; d = 3: it is z. */
static void add_contact(scene *s, int a, int b, double x, double y, double z, double nx, double ny,
                        double mu) {
  const int c = s->nc++;
  const double p[3] = {x, y, z};
  s->body[2 * c] = b;
  s->body[2 * c + 1] = a;
  s->mu[c] = mu;
  memcpy(s->point[c], p, sizeof p);
  s->normal[c][0] = nx;
  s->normal[c][1] = ny;
}

/* h (6) := the motion of `body` by a unit force e at p, times M^-1/2. */
static void push_body(const scene *s, int body, const double *p, const double *e, double sign,
                      double *h) {
  double r[3];
  for (int i = 0; i < 3; i++)
    r[i] = p[i] - s->at[body][i];
  const double m = sign / sqrt(s->mass[body]), I = sign / sqrt(s->inertia[body]);
  const double turn[3] = {r[1] * e[2] - r[2] * e[1], r[2] * e[0] - r[0] * e[2],
                          r[0] * e[1] - r[1] * e[0]};
  for (int i = 0; i < s->d; i++)
    h[i] = m * e[i];
  for (int i = 0; i < 2 * s->d - 3; i++)
    h[s->d + i] = I * (s->d == 2 ? turn[2] : turn[i]);
}

/* Forms H, q and W, dense; the contacts in the order from[0], from[1], ... (NULL: as they are). */
static void form(scene *s, const int *from) {
  const int d = s->d, n = motions(s), m = d * s->nc;
  scene old = *s;
  for (int c = 0; c < s->nc; c++) {
    const int f = from ? from[c] : c;
    memcpy(s->point[c], old.point[f], sizeof s->point[c]);
    memcpy(s->normal[c], old.normal[f], sizeof s->normal[c]);
    memcpy(&s->body[2 * c], &old.body[2 * f], 2 * sizeof s->body[0]);
    s->mu[c] = old.mu[f];
  }
  memset(s->q, 0, sizeof s->q);
  memset(s->H, 0, sizeof s->H);
  for (int c = 0; c < s->nc; c++)
    for (int side = 0; side < 2; side++)
      for (int i = 0; i < d; i++) {
        const int body = s->body[2 * c + side];
        const double nx = s->normal[c][0], ny = s->normal[c][1];
        const double of2[2][3] = {{nx, ny, 0}, {ny, -nx, 0}};
        const double of3[3][3] = {{0, 0, 1}, {1, 0, 0}, {0, 1, 0}};
        double *h = s->H + n * d * (2 * c + side) + n * i;
        if (body < 0) continue;
        push_body(s, body, s->point[c], d == 2 ? of2[i] : of3[i], side ? -1 : 1, h);
        for (int k = 0; k < n; k++) {
          const double by = k < d ? s->mass[body] : s->inertia[body];
          s->q[d * c + i] += h[k] * s->force[body][k] / sqrt(by);
        }
      }
  s->p_ = (dls_contact){.d = d, .nc = s->nc, .q = s->q, .mu = s->mu};
  s->p_.bodies = (dls_bodies){n, s->count, s->body, s->H, NULL};
  int blocks;
  dls_blocks B;
  ck_assert_int_eq(dls_bodies_count(&s->p_, &blocks, NULL), DLS_OK);
  ck_assert_int_le(blocks * d * d, most_m * most_m);
  ck_assert_int_eq(dls_blocks_from_bodies(&s->p_, s->p, s->i, s->x, &B, NULL), DLS_OK);
  ck_assert_int_eq(dls_blocks_to_dense(&B, s->W, m, NULL), DLS_OK);
  s->p_.bodies = (dls_bodies){0};
  s->p_.W = (dls_dense){m, m, m, s->W};
}

/* A table on `legs` legs, a circle, under a force (fx, 0, -1) at (ex, ey). */
static void table(scene *s, int legs, double fx, double ex, double ey) {
  *s = (scene){.d = 3};
  add_body(s, 0, 0, 1, 1, 0.1);
  s->force[0][0] = fx;
  s->force[0][3] = -ey;
  s->force[0][4] = ex;
  for (int k = 0; k < legs; k++) {
    const double a = 2 * pi * (k + 0.5) / legs;
    add_contact(s, -1, 0, sqrt(2) * cos(a), sqrt(2) * sin(a), 0, 0, 0, 0.5);
  }
}

/* A half circle of `count` voussoirs between two springers, two contacts a joint. */
static void arch(scene *s, int count) {
  *s = (scene){.d = 2};
  for (int k = 0; k < count; k++) {
    const double a = pi * (1 - (k + 0.5) / count), m = 0.3 * pi / count;
    add_body(s, cos(a), sin(a), 0, m, m * (0.09 + (pi / count) * (pi / count)) / 12);
  }
  for (int k = 0; k <= count; k++)
    for (int side = 0; side < 2; side++) {
      const double a = pi * (1 - (double)k / count), r = side ? 1.15 : 0.85;
      const double sign = k == count ? -1 : 1;
      add_contact(s, k == count ? -1 : k - 1, k == count ? count - 1 : k, r * cos(a), r * sin(a), 0,
                  sign * sin(a), -sign * cos(a), 0.7);
    }
}

/* A wall of `rows` courses of bricks of 2 x 1, 4 and 3 in turn. */
static void wall(scene *s, int rows) {
  *s = (scene){.d = 2};
  for (int j = 0; j < rows; j++)
    for (int i = 0; i < 4 - j % 2; i++) {
      const int b = add_body(s, 2 * i + 1 + j % 2, j + 0.5, 0, 2, 2 * 5 / 12.0);
      for (int k = 0; k < 4; k++) { /* two contacts on each brick below, or on the ground */
        const double x = 2 * i + j % 2 + (j ? (k + 1) / 2 : 2 * (k / 2));
        const int below = j ? b - (4 - (j - 1) % 2) + (k / 2) - (j % 2 == 0) : -1;
        const int there = j == 0 ? k % 2 == 0 : j % 2 || (k / 2 ? i < 3 : i > 0);
        if (there) add_contact(s, below, b, x, j, 0, 0, 1, 0.6);
      }
    }
}

static dls_status solve_for(const dls_contact *p, dls_method method, dls_forces forces, double *r,
                            dls_info *info) {
  dls_solver_settings settings = settings_with(method, default_tol);
  settings.forces = forces;
  return dls_solve(p, &settings, r, NULL, info, NULL);
}

/* Returns max |r_k - x_k| over max |x|. */
static double apart(int m, const double *r, const double *x) {
  double most = 0, size = 0;
  for (int k = 0; k < m; k++) {
    most = fmax(most, fabs(r[k] - x[k]));
    size = fmax(size, fabs(x[k]));
  }
  return most / size;
}

/* ---- by hand --------------------------------------------------------------------------------- */

/* Four and eight legs carry a fourth and an eighth each, without friction. With the load at (e, e)
 * a leg at (x, y) carries 1 / legs (1 + e x + e y), sum x^2 = legs being that of a circle. */
TEST_EACH(legs_by_hand, 0, 4) {
  static scene s;
  static const int legs[] = {4, 8, 4, 8};
  const double e = _i < 2 ? 0 : 0.2;
  double r[24];
  dls_info info;
  int freedom;
  table(&s, legs[_i], 0, e, e);
  form(&s, NULL);
  ck_assert_int_eq(solve_for(&s.p_, DLS_AUTO, DLS_FORCES_LEAST, r, &info), DLS_OK);
  ck_assert_int_eq(info.forces, DLS_FORCES_LEAST);
  ck_assert_double_le(info.certificate.residual, 1e-12);
  for (int c = 0; c < legs[_i]; c++) {
    const double *p = s.point[c];
    ck_assert_double_eq_tol(r[3 * c], (1 + e * p[0] + e * p[1]) / legs[_i], 1e-8);
    ck_assert_double_le(hypot(r[3 * c + 1], r[3 * c + 2]), 1e-8);
  }
  ck_assert_int_eq(dls_contact_freedom(&s.p_, r, &freedom, NULL), DLS_OK);
  ck_assert_int_eq(freedom, 3 * legs[_i] - 6);
}

/* A load at (0.7, 0.7): r = (1 + .7 x + .7 y) / 4 would pull at (-1, -1), which carries nothing:
 * the other three are determined, .7, .15, .15. */
TEST(a_leg_without_load) {
  static scene s;
  double r[12];
  dls_info info;
  table(&s, 4, 0, 0.7, 0.7);
  form(&s, NULL);
  ck_assert_int_eq(solve_for(&s.p_, DLS_AUTO, DLS_FORCES_LEAST, r, &info), DLS_OK);
  ck_assert_int_eq(info.forces, DLS_FORCES_LEAST);
  for (int c = 0; c < 4; c++) {
    const double x = s.point[c][0], y = s.point[c][1];
    const double expected = x > 0 && y > 0 ? 0.7 : x < 0 && y < 0 ? 0 : 0.15;
    ck_assert_double_eq_tol(r[3 * c], expected, 1e-8);
  }
}

/* A block of weight 1 between two walls, mu = 1/4: any r_n >= 2 holds it. The least has r_n = 2 and
 * r_t = 1/2, on the cones. Started from r_n = 10: without that it may fall. */
TEST(a_grip) {
  static scene s;
  double r[4] = {10, 0, 10, 0};
  dls_info info;
  s = (scene){.d = 2};
  add_body(&s, 0, 0, 0, 1, 1);
  add_contact(&s, -1, 0, -1, 0, 0, 1, 0, 0.25);
  add_contact(&s, -1, 0, 1, 0, 0, -1, 0, 0.25);
  form(&s, NULL);
  r[1] = -0.5; /* t is (ny, -nx) */
  r[3] = 0.5;
  dls_solver_settings settings = settings_with(DLS_AUTO, default_tol);
  settings.limits.warm_start = 1;
  settings.forces = DLS_FORCES_LEAST;
  ck_assert_int_eq(dls_solve(&s.p_, &settings, r, NULL, &info, NULL), DLS_OK);
  ck_assert_int_eq(info.forces, DLS_FORCES_LEAST);
  const double expected[4] = {2, -0.5, 2, 0.5};
  ck_assert_double_le(apart(4, r, expected), 1e-8);
}

/* A block slides on three feet at x = -1, 0, 1, its centre 1/2 above: r_t = -mu r_n, the moment of
 * friction mu / 2 = sum x r_n. w = (2 + x^2 + 1/4) / 2, and the least r has w r_n = a + b x, which
 * is r_n = a / w + x mu / 4, a = 1 / sum 1 / w. */
TEST(sliding_feet) {
  static scene s;
  double r[6], u[6];
  dls_info info;
  const double mu = 0.3;
  s = (scene){.d = 2};
  add_body(&s, 0, 0.5, 0, 1, 1);
  s.force[0][0] = 1;
  for (int k = -1; k <= 1; k++)
    add_contact(&s, -1, 0, k, 0, 0, 0, 1, mu);
  form(&s, NULL);
  dls_solver_settings settings = settings_with(DLS_AUTO, default_tol);
  settings.forces = DLS_FORCES_LEAST;
  ck_assert_int_eq(dls_solve(&s.p_, &settings, r, u, &info, NULL), DLS_OK);
  ck_assert_int_eq(info.forces, DLS_FORCES_LEAST);
  for (int c = 0; c < 3; c++) {
    const double w[3] = {1.625, 1.125, 1.625}, a = 1 / (2 / w[0] + 1 / w[1]);
    assert_near(r + 2 * c, (double[]){a / w[c] + (c - 1) * mu / 4, -mu * r[2 * c]}, 2, 1e-8);
    ck_assert_double_eq_tol(u[2 * c + 1], 1 - mu, 1e-8);
  }
  int freedom;
  ck_assert_int_eq(dls_contact_freedom(&s.p_, r, &freedom, NULL), DLS_OK);
  ck_assert_int_eq(freedom, 1);
}

/* A table of eight legs slides: r_t = -mu r_n along x. Friction tips it by mu, as its centre is 1
 * above the feet: r_n = (1 + mu x) / 8. */
TEST(sliding_table) {
  static scene s;
  double r[24], u[24];
  dls_info info;
  int freedom;
  dls_solver_settings settings = settings_with(DLS_AUTO, default_tol);
  settings.forces = DLS_FORCES_LEAST;
  table(&s, 8, 0.9, 0, 0);
  form(&s, NULL);
  ck_assert_int_eq(dls_solve(&s.p_, &settings, r, u, &info, NULL), DLS_OK);
  ck_assert_int_eq(info.forces, DLS_FORCES_LEAST);
  for (int c = 0; c < 8; c++) {
    assert_near(r + 3 * c, (double[]){(1 + 0.5 * s.point[c][0]) / 8, -0.5 * r[3 * c], 0}, 3, 1e-8);
    ck_assert_double_eq_tol(u[3 * c + 1], 0.4, 1e-8);
  }
  ck_assert_int_eq(dls_contact_freedom(&s.p_, r, &freedom, NULL), DLS_OK);
  ck_assert_int_ge(freedom, 5);
}

/* ---- every method, in two orders ------------------------------------------------------------- */

static void scatter(int nc, int *from) {
  for (int c = 0; c < nc; c++)
    from[c] = c;
  for (int c = nc - 1, x = 1; c > 0; c--) {
    x = (x * 7 + 3) % 1009;
    const int k = x % (c + 1), y = from[c];
    from[c] = from[k];
    from[k] = y;
  }
}

static void make_scene(scene *s, int k) {

  if (k == 0) table(s, 4, 0, 0, 0);
  if (k == 1) table(s, 8, 0.2, 0.1, 0.3);
  if (k == 2) wall(s, 8);
  if (k == 3) arch(s, 30);
}

/* Judges r beside r' of the same positions, a convex set: the sum of w r.(r' - r) is >= 0 for the
 * least r. */
static void assert_least(const dls_contact *p, const double *r, const double *other) {
  const int d = p->d, m = d * p->nc;
  double slope = 0, least = 0;
  for (int k = 0; k < m; k++) {
    double w = 0;
    for (int i = 0; i < d; i++)
      w += p->W.a[(k / d * d + i) * (m + 1)] / d;
    slope += w * r[k] * (other[k] - r[k]);
    least += w * r[k] * r[k];
  }
  ck_assert_double_ge(slope, -1e-6 * least);
}

/* The least forces do not depend on method and order. */
TEST_EACH(methods_and_orders, 0, 4) {
  static const dls_method method[] = {DLS_AUTO, DLS_NLGS, DLS_NEWTON, DLS_ADMM,
                                      DLS_AUGMENTED_LAGRANGIAN};
  static scene s[2];
  static double r[most_m], x[most_m], first[most_m], any[most_m];
  int from[most_nc], solved = 0;
  dls_info info;
  make_scene(&s[0], _i);
  make_scene(&s[1], _i);
  scatter(s[0].nc, from);
  form(&s[0], NULL);
  form(&s[1], from);
  const int d = s[0].d, m = d * s[0].nc;
  for (int k = 0; k < 10; k++) {
    const dls_contact *p = &s[k % 2].p_;
    if (solve_for(p, method[k / 2], DLS_FORCES_ANY, any, &info)) continue; /* the arch is hard */
    ck_assert_int_eq(info.forces, DLS_FORCES_ANY);
    ck_assert_int_eq(solve_for(p, method[k / 2], DLS_FORCES_LEAST, x, &info), DLS_OK);
    ck_assert_int_eq(info.forces, DLS_FORCES_LEAST);
    ck_assert(dls_certificate_holds(&info.certificate, 1e-8));
    assert_least(p, x, any);
    for (int c = 0; c < s[0].nc; c++)
      memcpy(r + d * (k % 2 ? from[c] : c), x + d * c, (size_t)d * sizeof *r);
    if (!solved++) memcpy(first, r, sizeof r);
    ck_assert_double_le(apart(m, r, first), 1e-6);
  }
  ck_assert_int_ge(solved, 7);
  if (_i != 3) return;
  for (int c = 0; c < s[0].nc; c++) { /* the arch: joint k and joint 30 - k, the same side */
    const int mirror = s[0].nc - 2 - c + 2 * (c % 2);
    ck_assert_double_eq_tol(first[2 * c], first[2 * mirror], 1e-6 * fabs(first[2 * c]) + 1e-9);
  }
}

/* W of low rank, its eigenvalues over four decades: Newton's method needs its line search (LS4). */
TEST_EACH(line_search, 0, 4) {
  static const struct {
    int nc, rank, seed;
    double mu;
  } of[] = {{19, 14, 45, .1}, {34, 51, 475, .3}, {14, 10, 555, .3}, {24, 18, 585, 8}};
  static planted_problem a;
  double r[3 * PLANTED], any[3 * PLANTED];
  dls_info info;
  const dls_contact p = planted_graded(&a, 2 + of[_i].seed % 2, of[_i].nc, of[_i].rank, 1e4,
                                       of[_i].mu, (unsigned)of[_i].seed);
  ck_assert_int_eq(solve_for(&p, DLS_AUTO, DLS_FORCES_ANY, any, NULL), DLS_OK);
  ck_assert_int_eq(solve_for(&p, DLS_AUTO, DLS_FORCES_LEAST, r, &info), DLS_OK);
  ck_assert_int_eq(info.forces, DLS_FORCES_LEAST);
  assert_least(&p, r, any);
}

/* A second way, where no least reaction is on its cone: W + eps diag(w), eps = 1e-8, has one
 * answer, the least one to first order of eps. */
TEST_EACH(beside_regularised, 0, 2) {
  static scene s;
  static double r[most_m], x[most_m];
  dls_info info;
  make_scene(&s, _i);
  form(&s, NULL);
  const int m = s.d * s.nc;
  ck_assert_int_eq(solve_for(&s.p_, DLS_AUTO, DLS_FORCES_LEAST, r, &info), DLS_OK);
  for (int c = 0; c < s.nc; c++) {
    double w = 0;
    for (int i = s.d * c; i < s.d * (c + 1); i++)
      w += s.W[i * (m + 1)] / s.d;
    for (int i = s.d * c; i < s.d * (c + 1); i++)
      s.W[i * (m + 1)] += 1e-8 * w;
  }
  dls_solver_settings settings = settings_with(DLS_AUTO, 1e-11);
  ck_assert_int_eq(dls_solve(&s.p_, &settings, x, NULL, &info, NULL), DLS_OK);
  ck_assert_double_le(apart(m, r, x), 1e-5);
}

/* Other units, a factor of 1e6 on lengths and 1e-3 on forces: the same. */
TEST_EACH(units, 0, 4) {
  static scene s;
  static double r[most_m], x[most_m];
  dls_info info;
  make_scene(&s, _i);
  form(&s, NULL);
  const int m = s.d * s.nc;
  ck_assert_int_eq(solve_for(&s.p_, DLS_AUTO, DLS_FORCES_LEAST, r, &info), DLS_OK);
  for (int k = 0; k < m * m; k++)
    s.W[k] *= 1e9;
  for (int k = 0; k < m; k++) {
    s.q[k] *= 1e6;
    r[k] *= 1e-3;
  }
  ck_assert_int_eq(solve_for(&s.p_, DLS_AUTO, DLS_FORCES_LEAST, x, &info), DLS_OK);
  ck_assert_int_eq(info.forces, DLS_FORCES_LEAST);
  ck_assert_double_le(apart(m, x, r), 1e-6);
}

/* By blocks and of bodies: the same. */
TEST_EACH(storages, 0, 4) {
  static scene s;
  static double r[3][most_m];
  dls_info info;
  make_scene(&s, _i);
  form(&s, NULL);
  const int m = s.d * s.nc;
  dls_contact p[3] = {s.p_, s.p_, s.p_};
  p[1].W = p[2].W = (dls_dense){0};
  p[1].Wb = (dls_blocks){s.d, s.nc, s.p, s.i, s.x};
  p[2].bodies = (dls_bodies){motions(&s), s.count, s.body, s.H, NULL};
  for (int k = 0; k < 3; k++) {
    int freedom[2];
    ck_assert_int_eq(solve_for(&p[k], DLS_AUTO, DLS_FORCES_LEAST, r[k], &info), DLS_OK);
    ck_assert_int_eq(info.forces, DLS_FORCES_LEAST);
    ck_assert_double_le(apart(m, r[k], r[0]), 1e-6);
    ck_assert_int_eq(dls_contact_freedom(&p[k], r[0], &freedom[0], NULL), DLS_OK);
    ck_assert_int_eq(dls_contact_freedom(&p[0], r[0], &freedom[1], NULL), DLS_OK);
    ck_assert_int_eq(freedom[0], freedom[1]);
  }
}

/* A solver that is used again, and a batch, give the same bits as one call. */
TEST(solver_and_batch) {
  static scene s, t;
  double r[3][24], *const of[1] = {r[2]};
  dls_info info;
  dls_solver_settings settings = settings_with(DLS_AUTO, default_tol);
  settings.forces = DLS_FORCES_LEAST;
  settings.method = DLS_NLGS; /* auto may allocate */
  table(&s, 8, 0.2, 0.1, 0.3);
  table(&t, 4, 0, 0, 0);
  form(&s, NULL);
  form(&t, NULL);
  ck_assert_int_eq(dls_solve(&s.p_, &settings, r[0], NULL, &info, NULL), DLS_OK);
  dls_solver *solver = solver_of(3, 8, &settings);
  malloc_fails_at(0);
  const dls_status one = dls_solver_solve(solver, &t.p_, r[1], NULL, &info, NULL);
  const dls_status two = dls_solver_solve(solver, &s.p_, r[1], NULL, &info, NULL);
  ck_assert_int_eq(malloc_calls(), 0);
  ck_assert(one == DLS_OK && two == DLS_OK);
  ck_assert_int_eq(memcmp(r[0], r[1], sizeof r[0]), 0);
  dls_solver_destroy(solver);
  ck_assert_int_eq(dls_solve_batch(1, &s.p_, &settings, of, NULL, &info, NULL), DLS_OK);
  ck_assert_int_eq(info.forces, DLS_FORCES_LEAST);
  ck_assert_int_eq(memcmp(r[0], r[2], sizeof r[0]), 0);
}

/* ---- what is left as it is ------------------------------------------------------------------- */

TEST(left_as_it_is) {
  static scene s;
  double r[12], any[12];
  dls_info info;
  table(&s, 4, 0, 0, 0);
  form(&s, NULL);
  s.W[1] += 1e-6; /* W is not symmetric */
  ck_assert_int_eq(solve_for(&s.p_, DLS_AUTO, DLS_FORCES_ANY, any, &info), DLS_OK);
  ck_assert_int_eq(solve_for(&s.p_, DLS_AUTO, DLS_FORCES_LEAST, r, &info), DLS_OK);
  ck_assert_int_eq(info.forces, DLS_FORCES_ANY);
  form(&s, NULL);
  s.mu[1] = INFINITY;
  ck_assert_int_eq(solve_for(&s.p_, DLS_AUTO, DLS_FORCES_LEAST, r, &info), DLS_OK);
  ck_assert_int_eq(info.forces, DLS_FORCES_ANY);
}

TEST(nothing_wrong) {
  static scene s;
  double r[12] = {0};
  int freedom = -7;
  dls_solver_settings settings = settings_with(DLS_AUTO, default_tol);
  settings.forces = (dls_forces)2;
  table(&s, 4, 0, 0, 0);
  form(&s, NULL);
  REFUSES(ARGUMENT, "forces", -1, dls_solve, &s.p_, &settings, r, NULL, NULL);
  settings.forces = DLS_FORCES_LEAST;
  MALLOCS_FAIL((memset(r, 0, sizeof r), dls_solve(&s.p_, &settings, r, NULL, NULL, NULL)), 1,
               DLS_OK, 3);
  REFUSES(ARGUMENT, "problem", -1, dls_contact_freedom, NULL, r, &freedom);
  REFUSES(ARGUMENT, "r", -1, dls_contact_freedom, &s.p_, NULL, &freedom);
  REFUSES(ARGUMENT, "freedom", -1, dls_contact_freedom, &s.p_, r, NULL);
  r[1] = NAN;
  REFUSES(NOT_FINITE, "r", 1, dls_contact_freedom, &s.p_, r, &freedom);
  ck_assert_int_eq(freedom, -7);
  r[1] = 0;
  MALLOCS_FAIL(dls_contact_freedom(&s.p_, r, &freedom, NULL), freedom == -7, DLS_OK, 1);
  ck_assert_int_eq(freedom, 6);
  const dls_contact nothing = {.d = 2};
  ck_assert_int_eq(dls_contact_freedom(&nothing, r, &freedom, NULL), DLS_OK);
  ck_assert_int_eq(freedom, 0);
}
