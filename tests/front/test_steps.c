/* test_steps.c: auto in steps: what one solve leaves to the next warm one (AT14), (AT15). */
#include <check.h>
#include <math.h>
#include <string.h>

#include "close.h"
#include "delassus/solve.h"
#include "front_cases.h"
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
  dls_solver *solver;
  ck_assert_int_eq(dls_solver_create(&solver, 2, nc, &s, NULL), DLS_OK);
  return solver;
}

/* While all stick, a step needs no factorisation and no sweep, but one step of Newton's method,
 * whether it has its regularisation or not. */
START_TEST(nothing_changes) {
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
END_TEST

/* The path of free, slipping and sticking candidates: the answers are those of cold solves, for
 * fewer factorisations; all of it gives the same bits again. */
START_TEST(answers_of_a_path) {
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
END_TEST

/* W may change under the factors, and candidates may come and go; what a warm solve keeps is not
 * seen by a cold one. */
START_TEST(changes_are_seen) {
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
    dls_certificate certificate;
    ck_assert_int_eq(dls_contact_certify(&some, x, NULL, &certificate, NULL), DLS_OK);
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
END_TEST

int main(void) {
  return RUN("steps", NULL, NULL, EACH(nothing_changes, 0, 2), ONCE(answers_of_a_path),
             EACH(changes_are_seen, 0, 2));
}
