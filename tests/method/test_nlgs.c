/* test_nlgs.c: projected Gauss-Seidel, on problems solved by hand, on random ones, on bad input. */
#include <check.h>
#include <float.h>
#include <limits.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "cases.h"
#include "delassus/files.h"
#include "delassus/nlgs.h"
#include "delassus/reduction.h"
#include "malloc_fails.h"
#include "vi/vi_internal.h"

SOLVER(nlgs, DLS_NLGS);

static dls_status run(const dls_contact *p, const dls_nlgs_settings *settings, double *r, double *u,
                      dls_info *info) {
  return run_with(&the_nlgs, p, settings, settings->limits.tol, r, u, info);
}

/* ---- by hand --------------------------------------------------------------------------------- */

/* from r = 0, where something is said; -1: it goes round for ever */
static const struct {
  const char *name;
  int sweeps;
} known[] = {{"separate", 0},
             {"q = 0", 0},
             {"stick", 1},
             {"slip right", 1},
             {"slip left", 1},
             {"coupled stick", 1},
             {"coupled slip left", 1},
             {"coupled slip right", 1},
             {"no friction", 1},
             {"C7", 1},
             {"C11", -1},
             {"C13", -1},
             {"C7 in 3D", 1},
             {"C16", 1},
             {"slip in 3D", 1}};

START_TEST(by_hand) {
  const hand_case *k = &hand[_i];
  static model a;
  set_hand(&a, k);
  const dls_nlgs_settings s = with_tol(1e-14);
  double r[4], u[4];
  dls_info info;
  const dls_status status = run(&a.p, &s, r, u, &info);
  int cycles = 0;
  for (size_t e = 0; e < sizeof known / sizeof known[0]; e++)
    if (strcmp(known[e].name, k->name) == 0) {
      cycles = known[e].sweeps < 0;
      if (!cycles) ck_assert_int_eq(info.iterations, known[e].sweeps);
    }
  ck_assert_msg(status == (cycles ? DLS_MAX_ITERATIONS : DLS_OK), "%s: %g", k->name,
                info.certificate.residual);
  if (cycles) return;
  /* residual <= 1e-14; the worst is C15, where |W^-1| is 100 or so */
  for (int i = 0; i < k->d * k->nc; i++)
    ck_assert_msg(fabs(r[i] - k->r[i]) <= 1e-11, "%s: r[%d] = %.17g", k->name, i, r[i]);
  ck_assert_int_eq(info.ambiguous, strcmp(k->name, "C16") == 0);
}
END_TEST

START_TEST(ambiguous) {
  static model a;
  set_hand(&a, &ambiguous_case);
  dls_nlgs_settings s = with_tol(1e-12);
  double r[2] = {2, -3}, u[2];
  dls_info info;
  ck_assert_int_eq(run(&a.p, &s, r, u, &info), DLS_OK);
  ck_assert(r[0] == 0 && r[1] == 0);
  ck_assert_int_eq(info.ambiguous, 1);
  s.limits.warm_start = 1; /* from the sticking solution: it is one, and stays */
  r[0] = 2;
  r[1] = -3;
  ck_assert_int_eq(run(&a.p, &s, r, u, &info), DLS_OK);
  ck_assert(r[0] == 2 && r[1] == -3 && info.iterations == 0 && info.ambiguous == 1);
}
END_TEST

START_TEST(no_solution) {
  static model a;
  set_hand(&a, &jammed[_i]);
  const dls_nlgs_settings s = with_tol(1e-8);
  double r[4], u[4];
  dls_info info;
  const dls_status status = run(&a.p, &s, r, u, &info);
  ck_assert_msg(status == DLS_STALLED || status == DLS_MAX_ITERATIONS, "%s", jammed[_i].name);
  ck_assert(info.certificate.residual > 0.1 && isfinite(info.certificate.residual));
  if (jammed[_i].nc == 1) ck_assert_int_eq(status, DLS_STALLED);
}
END_TEST

START_TEST(hyperstatic) {
  static model a;
  set_hand(&a, &hyperstatic_case);
  const dls_nlgs_settings s = with_tol(1e-13);
  double r[4], u[4];
  dls_info info;
  ck_assert_int_eq(run(&a.p, &s, r, u, &info), DLS_OK);
  ck_assert(fabs(r[0] + r[2] - 1) <= 1e-12 && fabs(r[1] + r[3] + .25) <= 1e-12);
}
END_TEST

/* C11: W SPD, one solution, and yet the sweeps repeat for ever */
START_TEST(cycle) {
  static model a;
  set_hand(&a, hand_named("C11"));
  for (int cancel = 0; cancel < 2; cancel++) {
    dls_nlgs_settings s = with_tol(1e-8);
    watch w = {"nlgs", 500, INFINITY, 0, cancel ? 7 : 0};
    s.limits.max_iterations = 500;
    s.limits.progress = look;
    s.limits.progress_data = &w;
    double r[4], u[4];
    dls_info info;
    ck_assert_int_eq(run(&a.p, &s, r, u, &info), cancel ? DLS_CANCELLED : DLS_MAX_ITERATIONS);
    ck_assert_int_eq(info.iterations, cancel ? 7 : 500);
    ck_assert_int_eq(w.calls, info.iterations);
    ck_assert(info.certificate.residual > 0.01);
    ck_assert(info.certificate.residual <= w.least * (1 + 1e-12)); /* the best of them all */
  }
}
END_TEST

/* Any start, off the cone too: what comes back is never worse than it. */
START_TEST(never_worse) {
  static model a;
  const hand_case *k = hand_named("C14");
  set_hand(&a, k);
  set_seed(362436069 + (uint64_t)_i);
  dls_nlgs_settings s = with_tol(1e-14);
  s.limits.warm_start = 1;
  s.limits.max_iterations = 1 + _i % 4;
  double r[4], u[4];
  for (int i = 0; i < 4; i++)
    r[i] = k->r[i] * (1 + 0.5 * uniform());
  dls_certificate before;
  ck_assert_int_eq(dls_contact_certify(&a.p, r, NULL, &before, NULL), DLS_OK);
  dls_info info;
  (void)run(&a.p, &s, r, u, &info);
  ck_assert(info.certificate.residual <= before.residual);
}
END_TEST

/* ---- random ---------------------------------------------------------------------------------- */

START_TEST(random_problem) {
  expect_solved(&the_nlgs, _i);

  /* other relaxations: the same answer */
  static model a;
  numbered_model(&a, _i);
  dls_nlgs_settings s = with_tol(1e-12);
  double r[most], r2[most];
  dls_info info;
  ck_assert_int_eq(run(&a.p, &s, r, NULL, &info), DLS_OK);
  for (int o = 0; o < 2; o++) {
    s.relaxation = o ? 1.2 : 0.7;
    ck_assert_int_eq(run(&a.p, &s, r2, NULL, &info), DLS_OK);
    for (int k = 0; k < a.p.d * a.p.nc; k++)
      ck_assert(fabs(r[k] - r2[k]) <= close_of(&a));
  }
}
END_TEST

START_TEST(units) {
  static model a;
  numbered_model(&a, _i);
  const dls_nlgs_settings s = with_tol(1e-10);
  expect_any_units(&the_nlgs, &a, &s, 1e-10);
}
END_TEST

START_TEST(turned_tangents) {
  expect_any_tangents(&the_nlgs, _i);
}
END_TEST

START_TEST(tolerance_zero) {
  expect_floor(&the_nlgs, _i);
}
END_TEST

START_TEST(smaller_problem) {
  static model a, b;
  numbered_model(&a, 39);
  numbered_model(&b, 11);
  expect_reuse(&the_nlgs, &a, &b);
}
END_TEST

/* ---- acceleration ---------------------------------------------------------------------------- */

static const dls_acceleration accelerations[] = {DLS_ACCELERATION_AITKEN,
                                                 DLS_ACCELERATION_ANDERSON};

static dls_nlgs_settings accelerated(double tol, dls_acceleration acceleration) {
  dls_nlgs_settings s = with_tol(tol);
  s.acceleration = acceleration;
  return s;
}

START_TEST(accelerated_random_problem) {
  static model a;
  static block_storage B;
  numbered_model(&a, _i);
  const int m = a.p.d * a.p.nc;
  const double close = close_of(&a);
  double plain[most], r[most], r2[most];
  dls_info info, info2;
  const dls_nlgs_settings none = with_tol(1e-12);
  ck_assert_int_eq(run(&a.p, &none, plain, NULL, &info), DLS_OK);
  for (int k = 0; k < 2; k++) {
    dls_nlgs_settings s = accelerated(1e-12, accelerations[k]);
    ck_assert_int_eq(run(&a.p, &s, r, NULL, &info), DLS_OK);
    for (int j = 0; j < m; j++)
      ck_assert(fabs(r[j] - plain[j]) <= close);

    /* again, and W by blocks: the same bits */
    ck_assert_int_eq(run(&a.p, &s, r2, NULL, &info2), DLS_OK);
    ck_assert_mem_eq(r, r2, (size_t)m * sizeof *r);
    const dls_contact p = by_blocks(&a, &B);
    ck_assert_int_eq(run(&p, &s, r2, NULL, &info2), DLS_OK);
    ck_assert_mem_eq(r, r2, (size_t)m * sizeof *r);
    ck_assert_int_eq(info.iterations, info2.iterations);

    /* from the answer: no sweep; from elsewhere, with other windows and relaxed: the same answer */
    s.limits.warm_start = 1;
    ck_assert_int_eq(run(&a.p, &s, r2, NULL, &info2), DLS_OK);
    ck_assert_int_eq(info2.iterations, 0);
    for (int o = 0; o < 3; o++) {
      s.window = o ? 3 : 100;
      s.relaxation = o == 2 ? 0.8 : 1;
      for (int j = 0; j < m; j++)
        r2[j] = 5 * uniform();
      ck_assert_int_eq(run(&a.p, &s, r2, NULL, &info2), DLS_OK);
      for (int j = 0; j < m; j++)
        ck_assert(fabs(r2[j] - plain[j]) <= close);
    }
  }
}
END_TEST

/* pressed all over, and W = A A^T / m + I / 1000 */
static void slow_model(int i, model *a) {
  set_seed(88172645463325252u + (uint64_t)i);
  const int d = 2 + i % 2, m = most;
  random_model(a, d, m / d, 0.5);
  for (int k = 0; k < m; k++) {
    a->W[k + m * k] += 1e-3 - 0.1;
    if (k % d == 0) a->q[k] -= 4;
  }
}

START_TEST(fewer_sweeps) {
  static model a;
  slow_model(_i, &a);
  double r[most];
  dls_info none, aitken, anderson;
  dls_nlgs_settings s = with_tol(1e-12);
  s.limits.max_iterations = 100000;
  ck_assert_int_eq(run(&a.p, &s, r, NULL, &none), DLS_OK);
  s.acceleration = DLS_ACCELERATION_AITKEN;
  ck_assert_int_eq(run(&a.p, &s, r, NULL, &aitken), DLS_OK);
  s.acceleration = DLS_ACCELERATION_ANDERSON;
  ck_assert_int_eq(run(&a.p, &s, r, NULL, &anderson), DLS_OK);
  /* measured: 98-159, 52-80, 33-44 */
  ck_assert_int_le(5 * aitken.iterations, 4 * none.iterations);
  ck_assert_int_le(2 * anderson.iterations, none.iterations);
}
END_TEST

static const char *const files[] = {"Confeti-ex13-4contact-Fc3D-SBM",
                                    "FC2D_SliderCrankLagrangian00000",
                                    "FC3D_Example1",
                                    "GFC3D_Example0",
                                    "GFC3D_OneContact",
                                    "gfc2d_granularflowonwall_00069_00350"};

START_TEST(fclib_file) {
  char path[200];
  (void)snprintf(path, sizeof path, TEST_DATA "/fclib/%s.hdf5", files[_i]);
  dls_fclib *file;
  dls_error error;
  const dls_status status = dls_fclib_read(&file, path, &error);
  if (status == DLS_E_UNSUPPORTED) return; /* built without HDF5 */
  ck_assert_msg(status == DLS_OK, "%s", error.message);
  dls_contact p;
  dls_reduction *reduction = NULL;
  if (dls_fclib_is_global(file)) {
    dls_model global;
    const double *f, *g, *mu;
    ck_assert_int_eq(dls_fclib_model(file, &global, &f, &g, &mu, &error), DLS_OK);
    ck_assert_int_eq(dls_reduction_create(&reduction, &global, &error), DLS_OK);
    ck_assert_int_eq(dls_reduction_load(reduction, f, g, &error), DLS_OK);
    ck_assert_int_eq(dls_reduction_contact(reduction, mu, &p, &error), DLS_OK);
  } else
    ck_assert_int_eq(dls_fclib_contact(file, &p, &error), DLS_OK);
  for (int k = 0; k < 2; k++) {
    const dls_nlgs_settings s = accelerated(1e-12, accelerations[k]);
    double *r = calloc((size_t)p.d * (size_t)p.nc, sizeof *r);
    dls_nlgs *work;
    dls_info info;
    dls_certificate c;
    ck_assert_int_eq(dls_nlgs_create(&work, p.d, p.nc, &s, &error), DLS_OK);
    ck_assert_msg(dls_nlgs_solve(work, &p, r, NULL, &info, &error) == DLS_OK, "%s: %g", files[_i],
                  info.certificate.residual);
    ck_assert_int_eq(dls_contact_certify(&p, r, NULL, &c, &error), DLS_OK);
    ck_assert(dls_certificate_holds(&c, 1e-12));
    dls_nlgs_destroy(work);
    free(r);
  }
  dls_reduction_destroy(reduction);
  dls_fclib_destroy(file);
}
END_TEST

START_TEST(
    accelerated_cycle) { /* C11 again: solved or not, what is said is true, and it is the best */
  static model a;
  set_hand(&a, hand_named("C11"));
  for (int k = 0; k < 2; k++) {
    dls_nlgs_settings s = accelerated(1e-8, accelerations[k]);
    watch w = {"nlgs", 500, INFINITY, 0, 0};
    s.limits.max_iterations = 500;
    s.limits.progress = look;
    s.limits.progress_data = &w;
    double r[4], u[4];
    dls_info info;
    const dls_status status = run(&a.p, &s, r, u, &info);
    ck_assert(status == DLS_OK || status == DLS_MAX_ITERATIONS);
    ck_assert_int_eq(w.calls, info.iterations - (status == DLS_OK));
    ck_assert(info.certificate.residual <= w.least * (1 + 1e-12));
  }
}
END_TEST

START_TEST(accelerated_units) {
  static model a;
  numbered_model(&a, _i);
  const dls_nlgs_settings s = accelerated(1e-10, accelerations[_i / 2 % 2]);
  expect_any_units(&the_nlgs, &a, &s, 1e-10);
}
END_TEST

static int stop(void *data, const dls_progress *progress) {
  const int *at = data;
  return progress->iteration == *at;
}

/* What an earlier problem left in the workspace, cancelled half-way, plays no part. */
START_TEST(accelerated_workspace) {
  static model a, b;
  slow_model(0, &a);
  numbered_model(&b, 10);
  ck_assert(a.p.d == b.p.d && a.p.nc > b.p.nc);
  for (int k = 0; k < 2; k++) {
    int at = 0;
    dls_nlgs_settings s = accelerated(1e-12, accelerations[k]);
    s.limits.progress = stop;
    s.limits.progress_data = &at;
    double r[most], r2[most];
    dls_info info;
    ck_assert_int_eq(run(&b.p, &s, r, NULL, &info), DLS_OK);
    dls_nlgs *work;
    ck_assert_int_eq(dls_nlgs_create(&work, 2, a.p.nc, &s, NULL), DLS_OK);
    malloc_fails_at(0);
    at = 7;
    const dls_status first = dls_nlgs_solve(work, &a.p, r2, NULL, &info, NULL);
    at = 0;
    const dls_status second = dls_nlgs_solve(work, &b.p, r2, NULL, NULL, NULL);
    const long calls = malloc_calls();
    ck_assert(first == DLS_CANCELLED && second == DLS_OK && calls == 0);
    ck_assert_int_eq(info.iterations, 7);
    ck_assert_mem_eq(r, r2, (size_t)(b.p.d * b.p.nc) * sizeof *r);
    dls_nlgs_destroy(work);
  }
}
END_TEST

/* The candidates numbered backwards and visited in the same order, W singular, u afresh on the way: as long
 * as no residual is one of rounding, by which the best r is chosen, not a bit is another one. */
START_TEST(same_visits_same_bits) {
  static model a, b;
  int compared = 0;
  for (int number = 0; number < 40; number++) {
    deficient_model(&a, number);
    reverse_model(&b, &a);
    const int d = a.p.d, nc = a.p.nc;
    int order[2][most];
    for (int c = 0; c < nc; c++) {
      order[0][c] = c;
      order[1][c] = nc - 1 - c;
    }
    for (int k = 0; k < 3; k++) {
      dls_nlgs_settings s = k < 2 ? accelerated(0, accelerations[k]) : with_tol(0);
      s.limits.max_iterations = k < 2 ? 8 : 60;
      s.limits.warm_start = 1;
      double r[2][most];
      dls_certificate c;
      for (int side = 0; side < 2; side++) {
        for (int i = 0; i < d * nc; i++)
          r[side][i] = ((side ? reversed(&a, i) : i) % 7 - 3) * norm_of(a.q, d * nc);
        dls_nlgs *work;
        dls_info info;
        ck_assert_int_eq(dls_nlgs_create(&work, d, nc, &s, NULL), DLS_OK);
        (void)dlsi_nlgs_run(work, side ? &b.p : &a.p, order[side], NULL, r[side], NULL, &info);
        c = info.certificate;
        dls_nlgs_destroy(work);
      }
      if (c.residual < 1e-10) continue;
      compared++;
      for (int i = 0; i < d * nc; i++)
        ck_assert(r[1][i] == r[0][reversed(&a, i)]);
    }
  }
  ck_assert_int_ge(compared, 60);
}
END_TEST

/* ---- bad input ------------------------------------------------------------------------------- */

START_TEST(bad_create) {
  expect_bad_create(&the_nlgs);
  const dls_nlgs_settings good = with_tol(1e-8);
  const double bad_relaxation[] = {0, 2, -1, NAN, INFINITY};
  for (int k = 0; k < 5; k++) {
    dls_nlgs_settings s = good;
    s.relaxation = bad_relaxation[k];
    refuses_to_create(&the_nlgs, DLS_E_ARGUMENT, "relaxation", -1, 2, 1, &s);
  }
  const int bad_window[] = {0, -1, 101, INT_MIN}, bad_acceleration[] = {-1, 3};
  for (int k = 0; k < 4; k++) {
    dls_nlgs_settings s = good;
    s.window = bad_window[k];
    refuses_to_create(&the_nlgs, DLS_E_ARGUMENT, "window", -1, 2, 1, &s);
  }
  for (int k = 0; k < 2; k++) {
    dls_nlgs_settings s = good;
    s.acceleration = (dls_acceleration)bad_acceleration[k];
    refuses_to_create(&the_nlgs, DLS_E_ARGUMENT, "acceleration", -1, 2, 1, &s);
  }
  dls_nlgs_settings_init(NULL);
}
END_TEST

START_TEST(bad_solve) {
  expect_bad_solve(&the_nlgs);
}
END_TEST

START_TEST(memory) { /* the formula of nlgs.h */
  for (int d = 2; d <= 3; d++)
    for (int nc = 10; nc <= 1000; nc *= 10)
      for (int window = 0; window <= 20; window += 10) {
        dls_nlgs_settings s = with_tol(1e-8);
        const double m = d * nc, k = window;
        double doubles = 4 * m + (d == 2 ? 12 : 26) * nc;
        if (window) {
          s.acceleration = DLS_ACCELERATION_ANDERSON;
          s.window = window;
          doubles += (4 + 3 * k) * m + (2 * k + 3) * k;
        }
        expect_memory(&the_nlgs, d, nc, &s, 8 * doubles, 2000);
      }
}
END_TEST

int main(void) {
  Suite *suite = suite_create("nlgs");
  TCase *t = tcase_create("by hand");
  tcase_add_loop_test(t, by_hand, 0, hand_count);
  tcase_add_test(t, ambiguous);
  tcase_add_loop_test(t, no_solution, 0, jammed_count);
  tcase_add_test(t, hyperstatic);
  tcase_add_test(t, cycle);
  tcase_add_loop_test(t, never_worse, 0, 30);
  suite_add_tcase(suite, t);
  t = tcase_create("random");
  tcase_set_timeout(t, 60);
  tcase_add_loop_test(t, random_problem, 0, 40);
  tcase_add_loop_test(t, units, 0, 12);
  tcase_add_loop_test(t, turned_tangents, 0, 10);
  tcase_add_loop_test(t, tolerance_zero, 0, 20);
  tcase_add_test(t, smaller_problem);
  suite_add_tcase(suite, t);
  t = tcase_create("accelerated");
  tcase_set_timeout(t, 60);
  tcase_add_loop_test(t, accelerated_random_problem, 0, 40);
  tcase_add_loop_test(t, fewer_sweeps, 0, 10);
  tcase_add_loop_test(t, fclib_file, 0, sizeof files / sizeof files[0]);
  tcase_add_test(t, accelerated_cycle);
  tcase_add_loop_test(t, accelerated_units, 0, 40);
  tcase_add_test(t, accelerated_workspace);
  tcase_add_test(t, same_visits_same_bits);
  suite_add_tcase(suite, t);
  t = tcase_create("bad input");
  tcase_add_test(t, bad_create);
  tcase_add_test(t, bad_solve);
  tcase_add_test(t, memory);
  suite_add_tcase(suite, t);
  SRunner *runner = srunner_create(suite);
  srunner_run_all(runner, CK_NORMAL);
  const int failed = srunner_ntests_failed(runner);
  srunner_free(runner);
  return failed ? EXIT_FAILURE : EXIT_SUCCESS;
}
