/* test_steps.c: auto in steps: what one solve leaves to the next warm one (SQ1), (SQ2). */
#include "delassus/solve.h"
#include "front_cases.h"
#include "half_space.h"
#include "made.h"
#include "run.h"

enum { nc = 60, m = 2 * nc, steps = 20 };

static double W[m * m], q[m], q0[m], mu[nc], rough;
static dls_contact p;

/* The load of step k, a polynomial of degree 3 in k. */
static void load(int k) {
  const double t = (double)k / steps;
  for (int c = 0; c < nc; c++) {
    q[2 * c] = q0[2 * c] - .2 * t * (1 + rough * cos(c));
    q[2 * c + 1] = .1 * t * t * t + .01 * t * t * sin(c);
  }
}

/* Pressed and pushed, with friction; a crown leaves candidates free. */
static void steps_make(double crown, double friction, double roughness) {
  p = half_plane(W, q0, mu, nc, 3, 0, crown, friction);
  p.q = q;
  rough = roughness;
  load(0);
}

static dls_solver *steps_solver(int warm, int definite) {
  dls_solver_settings s = settings_of(DLS_AUTO);
  s.limits.tol = 1e-10;
  s.limits.warm_start = warm;
  s.positive_definite = definite;
  dls_solver *solver = solver_of(2, nc, &s);
  return solver;
}

/* While all stick, a step needs no factorisation and no sweep, but one step of Newton's method,
 * whether it has its regularisation or not. */
TEST_EACH(nothing_changes, 0, 2) {
  steps_make(0, 1000, .01);
  dls_solver *solver = steps_solver(1, _i);
  double r[m] = {0};
  for (int k = 0; k < steps; k++) {
    dls_info info;
    load(k);
    ck_assert_int_eq(dls_solver_solve(solver, &p, r, NULL, &info, NULL), DLS_OK);
    if (k < 3) continue;
    ck_assert_int_eq(info.factorisations, 0);
    ck_assert_int_le(info.stages, 1);
    ck_assert(!info.stages || info.stage[0].method == DLS_NEWTON);
    ck_assert_int_le(info.iterations, 1);
  }
  dls_solver_destroy(solver);
}

/* Where the answers lie on a line, it is followed without a stage, and what is said of the answer
 * is its certificate. */
TEST(a_line_is_followed) {
  steps_make(0, 1000, 0);
  dls_solver *solver = steps_solver(1, 0);
  double r[m] = {0}, u[m];
  int followed = 0;
  for (int k = 0; k < steps; k++) {
    dls_info info;
    dls_certificate c;
    for (int i = 0; i < nc; i++)
      q[2 * i] = q0[2 * i] - 0.01 * k;
    memset(&info, 0, sizeof info);
    ck_assert_int_eq(dls_solver_solve(solver, &p, r, NULL, &info, NULL), DLS_OK);
    followed += info.stages == 0;
    ck_assert_int_eq(dls_contact_certify(&p, r, u, &c, NULL), DLS_OK);
    ck_assert_double_eq_tol(info.certificate.floor_u, c.floor_u, 1e-12 * c.floor_u);
    ck_assert_double_eq_tol(info.certificate.floor_r, c.floor_r, 1e-12 * c.floor_r);
  }
  ck_assert_int_ge(followed, steps / 2);
  dls_solver_destroy(solver);
}

/* The path of free, slipping and sticking candidates: the answers are those of cold solves, for
 * fewer factorisations; all of it gives the same bits again. */
TEST(answers_of_a_path) {
  static double path[2][steps][m];
  steps_make(.5, .3, .3);
  int factorisations[2] = {0}, iterations[2] = {0};
  for (int turn = 0; turn < 2; turn++) {
    dls_solver *cold = steps_solver(0, 0), *warm = steps_solver(1, 0);
    double r[m] = {0}, s[m];
    for (int k = 0; k < steps; k++) {
      dls_info info[2];
      load(k);
      ck_assert_int_eq(dls_solver_solve(cold, &p, s, NULL, &info[0], NULL), DLS_OK);
      ck_assert_int_eq(dls_solver_solve(warm, &p, r, NULL, &info[1], NULL), DLS_OK);
      assert_close(r, s, m, 1e-7);
      memcpy(path[turn][k], r, sizeof r);
      for (int i = 0; i < 2; i++) {
        factorisations[i] += info[i].factorisations;
        iterations[i] += info[i].iterations;
        check_report(&info[i]);
      }
    }
    dls_solver_destroy(warm);
    dls_solver_destroy(cold);
  }
  ck_assert_mem_eq(path[0], path[1], sizeof path[0]);
  ck_assert_int_lt(2 * iterations[1], iterations[0]);
  ck_assert_int_lt(factorisations[1], factorisations[0]);
}

/* Where the load jumps, a warm start costs no more than a cold one: sweeps have to sort the states
 * again. */
TEST(loads_that_jump) {
  steps_make(.5, .3, .3);
  dls_solver *cold = steps_solver(0, 0), *warm = steps_solver(1, 0);
  double r[m] = {0}, s[m];
  int factorisations[2] = {0}, iterations[2] = {0};
  for (int k = 0; k < steps; k++) {
    dls_info info[2];
    load(7 * k % steps);
    ck_assert_int_eq(dls_solver_solve(cold, &p, s, NULL, &info[0], NULL), DLS_OK);
    ck_assert_int_eq(dls_solver_solve(warm, &p, r, NULL, &info[1], NULL), DLS_OK);
    assert_close(r, s, m, 1e-7);
    for (int i = 0; i < 2; i++) {
      factorisations[i] += info[i].factorisations;
      iterations[i] += info[i].iterations;
    }
  }
  ck_assert_int_le(2 * factorisations[1], 3 * factorisations[0]); /* 28, 20 */
  ck_assert_int_le(iterations[1], iterations[0]);
  dls_solver_destroy(warm);
  dls_solver_destroy(cold);
}

/* W may change under the factors, and candidates may come and go; what a warm solve keeps is not
 * seen by a cold one. */
TEST_EACH(changes_are_seen, 0, 2) {
  static double values[m * m + 3 * nc];
  steps_make(.2, _i ? .4 : 1000, .3);
  dls_solver *solver = steps_solver(1, 0), *fresh = steps_solver(0, 0);
  double r[m] = {0}, s[m], x[m];
  dls_info info;
  for (int k = 0; k < steps; k++) {
    int candidate[nc], count = 0;
    dls_contact some;
    load(k);
    if (k % 3 == 2)
      for (int e = 0; e < m * m; e++)
        W[e] *= 1.3;
    for (int c = 0; c < nc; c++)
      if (k % 4 || (c + k) % 7) candidate[count++] = c;
    ck_assert_int_eq(dls_contact_subset(&p, count, candidate, values, NULL, &some, NULL), DLS_OK);
    for (int c = 0; c < count; c++)
      memcpy(x + 2 * c, r + 2 * candidate[c], 2 * sizeof *x);
    ck_assert_int_eq(dls_solver_solve(solver, &some, x, NULL, &info, NULL), DLS_OK);
    ck_assert_int_eq(dls_solver_solve(fresh, &some, s, NULL, NULL, NULL), DLS_OK);
    assert_close(x, s, 2 * count, 1e-7);
    const dls_certificate certificate = certificate_of(&some, x);
    ck_assert(dls_certificate_holds(&certificate, 1e-10));
    memset(r, 0, sizeof r);
    for (int c = 0; c < count; c++)
      memcpy(r + 2 * candidate[c], x + 2 * c, 2 * sizeof *x);
  }
  dls_limits limits = settings_of(DLS_AUTO).limits;
  limits.tol = 1e-10;
  ck_assert_int_eq(dls_solver_set_limits(solver, &limits, NULL), DLS_OK);
  ck_assert_int_eq(dls_solver_solve(solver, &p, r, NULL, NULL, NULL), DLS_OK);
  ck_assert_int_eq(dls_solver_solve(fresh, &p, s, NULL, NULL, NULL), DLS_OK);
  ck_assert_mem_eq(r, s, sizeof r);
  dls_solver_destroy(fresh);
  dls_solver_destroy(solver);
}

/* ---- d = 3 -------------------------------------------------------------------------------------
 */

enum { side = 7, nc3 = side * side, m3 = 3 * nc3 };

static double W3[m3 * m3], q3[m3], mu3[nc3];

/* Makes a surface whose points move by 1 / distance, normals and tangents coupled a little. */
static dls_contact space_make(void) {
  for (int c = 0; c < nc3; c++) {
    mu3[c] = c % 9 ? .3 : 0;
    for (int b = 0; b < nc3; b++) {
      const double x = c % side - b % side, y = c / side - b / side;
      const double r = c == b ? .3 : hypot(x, y), s[3] = {0, .1 * x / (r * r), .1 * y / (r * r)};
      for (int i = 0; i < 3; i++)
        for (int j = 0; j < 3; j++)
          W3[3 * c + i + (3 * b + j) * m3] =
              (i == j ? 1 / r : 0) + (j == 0 ? s[i] : 0) - (i == 0 ? s[j] : 0);
    }
  }
  return (dls_contact){.d = 3, .nc = nc3, .W = {m3, m3, m3, W3}, .q = q3, .mu = mu3};
}

/* A crown that presses, shears and turns; jump: loads by chance instead, of which no step is near
 * the one before. */
static void space_load(double t, int jump) {
  static unsigned seed = 5;
  for (int c = 0; c < nc3; c++) {
    const double x = 2. * (c % side) / (side - 1) - 1, y = 2. * (c / side) / (side - 1) - 1;
    const double load[3] = {-.2 - .8 * t + .4 * (x * x + y * y), .3 * t - .1 * y * t, .1 * t * x};
    for (int i = 0; i < 3; i++)
      q3[3 * c + i] = jump ? draw(&seed) - (i ? 0 : .5) : load[i];
  }
}

/* Directions of slip turn with every step: the answers are those of cold solves, and on a smooth
 * path by few factorisations. Where the load jumps, sweeps solve it as they do from nothing. */
TEST_EACH(slips_that_turn, 0, 2) {
  const dls_contact p3 = space_make();
  dls_solver_settings settings = settings_of(DLS_AUTO);
  settings.limits.tol = 1e-10;
  dls_solver *cold = solver_of(3, nc3, &settings);
  settings.limits.warm_start = 1;
  dls_solver *warm = solver_of(3, nc3, &settings);
  double r[m3] = {0}, s[m3];
  int factorisations = 0, iterations[2] = {0}, by_steps = 0;
  for (int k = 1; k <= 2 * steps; k++) {
    dls_info info[2];
    space_load(.5 * k / steps, _i);
    ck_assert_int_eq(dls_solver_solve(cold, &p3, s, NULL, &info[0], NULL), DLS_OK);
    ck_assert_int_eq(dls_solver_solve(warm, &p3, r, NULL, &info[1], NULL), DLS_OK);
    assert_close(r, s, m3, 1e-6);
    check_report(&info[1]);
    factorisations += info[1].factorisations;
    by_steps += info[1].stages == 1 && info[1].stage[0].method == DLS_NEWTON;
    for (int i = 0; i < 2; i++)
      iterations[i] += info[i].iterations;
  }
  if (_i) {
    ck_assert_int_le(by_steps, 3); /* 1, of 40 */
    ck_assert_int_le(factorisations, 3);
    ck_assert_int_le(iterations[1], iterations[0]);
  } else {
    ck_assert_int_ge(by_steps, 2 * steps - 4);
    ck_assert_int_lt(factorisations, steps);
    ck_assert_int_lt(3 * iterations[1], iterations[0]);
    ck_assert_int_lt(iterations[1], 191); /* 186, and 195 without (NE6) */
  }
  dls_solver_destroy(warm);
  dls_solver_destroy(cold);
}
