/* test_solve.c: the front door: every method by the same calls. */
#include <check.h>
#include <float.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "delassus.h"
#include "malloc_fails.h"

static const dls_method methods[] = {DLS_NLGS, DLS_LEMKE, DLS_NEWTON};

enum { METHODS = 3, NC = 12, M = 2 * NC };

static double W[M * M], q[M], mu[NC];

static double uniform(unsigned *seed) {
  *seed = *seed * 1664525u + 1013904223u;
  return (double)(*seed >> 8) / (1 << 23) - 1;
}

/* W = A^T A / m + I / 2 with coupled normals and tangents, some candidates without friction. */
static dls_contact random_problem(unsigned seed) {
  double A[M * M];
  for (int k = 0; k < M * M; k++)
    A[k] = uniform(&seed);
  for (int i = 0; i < M; i++)
    for (int j = 0; j < M; j++) {
      double sum = i == j ? 0.5 : 0;
      for (int k = 0; k < M; k++)
        sum += A[k + M * i] * A[k + M * j] / M;
      W[i + M * j] = sum;
    }
  for (int i = 0; i < M; i++)
    q[i] = uniform(&seed) - (i % 2 ? 0 : 0.5);
  for (int c = 0; c < NC; c++)
    mu[c] = c % 4 == 3 ? 0 : 0.3;
  return (dls_contact){.d = 2, .nc = NC, .W = {M, M, M, W}, .q = q, .mu = mu};
}

/* All fields; memcmp would compare the padding, too. */
static int same_certificate(const dls_certificate *a, const dls_certificate *b) {
  return a->residual == b->residual && a->floor == b->floor && a->penetration == b->penetration &&
         a->adhesion == b->adhesion && a->cone_violation == b->cone_violation &&
         a->slip_direction == b->slip_direction && a->complementarity == b->complementarity &&
         a->worst == b->worst;
}

static dls_solver_settings settings_of(dls_method method) {
  dls_solver_settings s;
  dls_solver_settings_init(&s);
  s.method = method;
  s.tol = 1e-13;
  return s;
}

START_TEST(methods_have_names) {
  dls_method m = (dls_method)0;
  ck_assert_str_eq(dls_method_name(DLS_NLGS), "nlgs");
  ck_assert_str_eq(dls_method_name(DLS_LEMKE), "lemke");
  ck_assert_str_eq(dls_method_name(DLS_AUGMENTED_LAGRANGIAN), "augmented-lagrangian");
  ck_assert_str_eq(dls_method_name(DLS_PENALTY), "penalty");
  ck_assert_str_eq(dls_method_name(DLS_NEWTON), "newton");
  ck_assert_ptr_null(dls_method_name((dls_method)99));
  ck_assert_int_eq(dls_method_find("lemke", &m), 1);
  ck_assert_int_eq(m, DLS_LEMKE);
  ck_assert_int_eq(dls_method_find("newton-raphson", &m), 0);
  ck_assert_int_eq(dls_method_find(NULL, &m), 0);
  ck_assert_int_eq(m, DLS_LEMKE);
}
END_TEST

START_TEST(methods_agree) {
  for (unsigned seed = 1; seed <= 80; seed++) {
    dls_contact p = random_problem(seed);
    p.d = 2 + (int)(seed % 2); /* m = 24 = 2 * 12 = 3 * 8 */
    p.nc = M / p.d;
    double r[METHODS][M], u[METHODS][M];
    for (int k = 0; k < METHODS; k++) {
      const dls_solver_settings s = settings_of(methods[k]);
      dls_info info;
      dls_error e = {0};
      const dls_status status = dls_solve(&p, &s, r[k], u[k], &info, &e);
      ck_assert_msg(status == DLS_OK, "seed %u: %s %s", seed, dls_status_name(status), e.message);
      ck_assert(info.status == DLS_OK && info.method == s.method &&
                info.iterations + info.sweeps > 0);
      ck_assert(info.certificate.residual <= 1e-13);
      dls_certificate c; /* the one the solver reports is the public one */
      ck_assert_int_eq(dls_contact_certify(&p, r[k], NULL, &c, NULL), DLS_OK);
      ck_assert_int_eq(same_certificate(&c, &info.certificate), 1);
    }
    double scale = 0;
    for (int i = 0; i < M; i++)
      scale = fmax(scale, fabs(r[1][i]));
    for (int i = 0; i < M; i++) /* cond(W) < 10 */
      for (int k = 1; k < METHODS; k++)
        ck_assert_double_eq_tol(r[0][i], r[k][i], 1e-11 * scale);
  }
}
END_TEST

START_TEST(units_do_not_change_the_path) {
  const double factor[] = {1e-9, 1e-3, 1e6, 1e9};
  for (int k = 0; k < METHODS; k++) {
    const dls_method method = methods[k];
    for (unsigned seed = 1; seed <= 5; seed++) {
      dls_contact p = random_problem(seed);
      const dls_solver_settings s = settings_of(method);
      double r[M], u[M], V[M * M], b[M], t[M];
      dls_info info, other;
      ck_assert_int_eq(dls_solve(&p, &s, r, u, &info, NULL), DLS_OK);
      for (int i = 0; i < 4; i++)
        for (int j = 0; j < 4; j++) {
          const double length = factor[i], force = factor[j];
          for (int e = 0; e < M * M; e++)
            V[e] = W[e] * (length / force);
          for (int e = 0; e < M; e++)
            b[e] = q[e] * length;
          p.W.a = V, p.q = b;
          ck_assert_int_eq(dls_solve(&p, &s, t, u, &other, NULL), DLS_OK);
          ck_assert_int_eq(other.iterations, info.iterations);
          for (int e = 0; e < M; e++)
            ck_assert_double_eq_tol(t[e] / force, r[e], 1e-11 * (1 + fabs(r[e])));
        }
    }
  }
}
END_TEST

START_TEST(permuted_candidates_same_answer) {
  for (int k = 0; k < METHODS; k++)
    for (unsigned seed = 1; seed <= 10; seed++) {
      const dls_contact p = random_problem(seed);
      const dls_solver_settings s = settings_of(methods[k]);
      double V[M * M], b[M], nu[NC], r[M], t[M];
      int at[M];
      for (int i = 0; i < M; i++)
        at[i] = 2 * ((i / 2 * 5 + 3) % NC) + i % 2; /* 5 is prime to 12 */
      for (int i = 0; i < M; i++) {
        b[i] = q[at[i]];
        nu[i / 2] = mu[at[i] / 2];
        for (int j = 0; j < M; j++)
          V[i + M * j] = W[at[i] + M * at[j]];
      }
      const dls_contact t_problem = {.d = 2, .nc = NC, .W = {M, M, M, V}, .q = b, .mu = nu};
      dls_info info;
      ck_assert_int_eq(dls_solve(&p, &s, r, NULL, &info, NULL), DLS_OK);
      ck_assert_int_eq(dls_solve(&t_problem, &s, t, NULL, &info, NULL), DLS_OK);
      for (int i = 0; i < M; i++)
        ck_assert_double_eq_tol(t[i], r[at[i]], 1e-11 * (1 + fabs(r[at[i]])));
    }
}
END_TEST

START_TEST(solver_is_reused_allocates_nothing_and_repeats_bits) {
  for (int k = 0; k < METHODS; k++) {
    const dls_solver_settings s = settings_of(methods[k]);
    dls_solver *solver;
    double first[M], r[M], u[M];
    ck_assert_int_eq(dls_solver_create(&solver, 2, NC, &s, NULL), DLS_OK);
    for (int round = 0; round < 2; round++)
      for (unsigned seed = 1; seed <= 4; seed++) {
        dls_contact p = random_problem(seed);
        if (seed == 4) /* a smaller problem in the same workspace */
          p.nc = 5, p.W.rows = p.W.cols = 10;
        malloc_fails_at(0);
        const dls_status status = dls_solver_solve(solver, &p, r, u, NULL, NULL);
        const long calls = malloc_calls(); /* Check itself allocates, too */
        ck_assert_int_eq(status, DLS_OK);
        ck_assert_int_eq(calls, 0);
        if (seed == 1 && round == 0) memcpy(first, r, sizeof r);
        if (seed == 1) ck_assert_mem_eq(first, r, sizeof r);
      }
    dls_solver_destroy(solver);
  }
  dls_solver_destroy(NULL);
}
END_TEST

static int stop(void *data, const dls_progress *progress) {
  (void)progress;
  ++*(int *)data;
  return 1;
}

START_TEST(progress_cancels) {
  const dls_contact p = random_problem(3);
  dls_solver_settings s = settings_of(DLS_NLGS);
  int calls = 0;
  double r[M];
  dls_info info;
  s.progress = stop;
  s.progress_data = &calls;
  ck_assert_int_eq(dls_solve(&p, &s, r, NULL, &info, NULL), DLS_CANCELLED);
  ck_assert_int_eq(calls, 1);
  ck_assert_int_eq(info.status, DLS_CANCELLED);
  dls_certificate c;
  ck_assert_int_eq(dls_contact_certify(&p, r, NULL, &c, NULL), DLS_OK);
  ck_assert_int_eq(same_certificate(&c, &info.certificate), 1);
}
END_TEST

START_TEST(iteration_limit_is_honest) {
  const dls_contact p = random_problem(3);
  for (int k = 0; k < 2; k++) { /* Newton is there after 2 */
    dls_solver_settings s = settings_of(methods[k]);
    s.max_iterations = 2;
    double r[M];
    dls_info info;
    ck_assert_int_eq(dls_solve(&p, &s, r, NULL, &info, NULL), DLS_MAX_ITERATIONS);
    ck_assert_int_eq(info.iterations, 2);
    ck_assert(info.certificate.residual > 1e-8 && isfinite(info.certificate.residual));
  }
}
END_TEST

START_TEST(accelerations_have_names) {
  static const char *const names[] = {"none", "aitken", "anderson"};
  const dls_contact p = random_problem(3);
  int sweeps[3] = {0};
  for (int k = 0; k < 3; k++) {
    dls_solver_settings s = settings_of(DLS_NLGS);
    ck_assert_int_eq(dls_acceleration_find(names[k], &s.acceleration), 1);
    double r[M];
    dls_info info;
    ck_assert_int_eq(dls_solve(&p, &s, r, NULL, &info, NULL), DLS_OK);
    sweeps[k] = info.iterations;
  }
  ck_assert_int_lt(sweeps[2], sweeps[0]);
  ck_assert_int_ne(sweeps[1], sweeps[2]);
  dls_acceleration none = DLS_ACCELERATION_NONE;
  ck_assert_int_eq(dls_acceleration_find("Anderson", &none), 0);
  ck_assert_int_eq(dls_acceleration_find(NULL, &none), 0);
  ck_assert_int_eq(dls_acceleration_find("none", NULL), 0);
}
END_TEST

START_TEST(bad_settings_are_refused) {
  const dls_contact p = random_problem(1);
  double r[M];
  dls_error e;
  dls_solver *solver = (dls_solver *)&e;
  const dls_solver_settings good = settings_of(DLS_NLGS);
  dls_solver_settings s;
  memset(&s, 0, sizeof s);
  ck_assert_int_eq(dls_solver_create(&solver, 2, NC, &s, &e), DLS_E_SETTINGS);
  ck_assert_ptr_null(solver);
  ck_assert_str_eq(e.argument, "settings");
  ck_assert_int_eq(dls_solver_create(&solver, 2, NC, NULL, &e), DLS_E_ARGUMENT);
  ck_assert_int_eq(dls_solver_create(NULL, 2, NC, &good, &e), DLS_E_ARGUMENT);
  ck_assert_str_eq(e.argument, "out");
  s = good, s.method = (dls_method)42;
  ck_assert_int_eq(dls_solver_create(&solver, 2, NC, &s, &e), DLS_E_ARGUMENT);
  ck_assert_str_eq(e.argument, "settings.method");
  const double bad[] = {-1e-3, NAN, INFINITY};
  for (int k = 0; k < 3; k++) {
    s = good, s.tol = bad[k];
    ck_assert_int_eq(dls_solver_create(&solver, 2, NC, &s, &e), DLS_E_ARGUMENT);
    ck_assert_str_eq(e.argument, "settings.tol");
  }
  s = good, s.acceleration = (dls_acceleration)3;
  ck_assert_int_eq(dls_solver_create(&solver, 2, NC, &s, &e), DLS_E_ARGUMENT);
  ck_assert_str_eq(e.argument, "acceleration");
  s = good, s.method = DLS_LEMKE, s.acceleration = DLS_ACCELERATION_AITKEN;
  ck_assert_int_eq(dls_solver_create(&solver, 2, NC, &s, &e), DLS_E_ARGUMENT);
  ck_assert_str_eq(e.argument, "settings.acceleration");
  s = good, s.max_iterations = -1;
  ck_assert_int_eq(dls_solver_create(&solver, 2, NC, &s, &e), DLS_E_ARGUMENT);
  ck_assert_int_eq(dls_solver_create(&solver, 1, NC, &good, &e), DLS_E_ARGUMENT);
  ck_assert_int_eq(dls_solver_create(&solver, 2, 0, &good, &e), DLS_E_SIZE);
  const int facets[] = {-8, 2, 7, 66};
  for (int k = 0; k < 4; k++) {
    s = settings_of(DLS_LEMKE), s.facets = facets[k];
    ck_assert_int_eq(dls_solver_create(&solver, 3, NC, &s, &e), DLS_E_ARGUMENT);
    ck_assert_str_eq(e.argument, "settings.facets");
  }
  s = settings_of(DLS_LEMKE);
  ck_assert_int_eq(dls_solver_create(&solver, 3, 1 << 28, &s, &e), DLS_E_SIZE);
  ck_assert_str_eq(e.argument, "nc");
  ck_assert_ptr_null(solver);
  r[0] = 9;
  ck_assert_int_eq(dls_solve(NULL, &good, r, NULL, NULL, &e), DLS_E_ARGUMENT);
  ck_assert_int_eq(dls_solve(&p, &good, NULL, NULL, NULL, &e), DLS_E_ARGUMENT);
  ck_assert_str_eq(e.argument, "r");
  ck_assert(r[0] == 9);
}
END_TEST

START_TEST(solver_refuses_other_sizes_and_bad_numbers) {
  for (int k = 0; k < METHODS; k++) {
    const dls_solver_settings s = settings_of(methods[k]);
    dls_contact p = random_problem(1);
    dls_solver *solver;
    dls_error e;
    double r[M], before[M];
    for (int i = 0; i < M; i++)
      r[i] = before[i] = 9;
    ck_assert_int_eq(dls_solver_create(&solver, 2, NC - 1, &s, NULL), DLS_OK);
    ck_assert_int_eq(dls_solver_solve(solver, &p, r, NULL, NULL, &e), DLS_E_SIZE);
    ck_assert_str_eq(e.argument, "problem");
    dls_solver_destroy(solver);
    W[5] = NAN;
    ck_assert_int_eq(dls_solve(&p, &s, r, NULL, NULL, &e), DLS_E_NOT_FINITE);
    ck_assert_str_eq(e.argument, "W");
    ck_assert_int_eq(e.index, 5);
    ck_assert_mem_eq(r, before, sizeof r);
    ck_assert_int_eq(dls_solver_solve(NULL, &p, r, NULL, NULL, &e), DLS_E_ARGUMENT);
  }
}
END_TEST

START_TEST(every_failing_malloc_unwinds) {
  for (int k = 0; k < METHODS; k++) {
    const dls_contact p = random_problem(2);
    const dls_solver_settings s = settings_of(methods[k]);
    double r[M] = {9};
    dls_status status = DLS_E_MEMORY;
    long failed = 0;
    for (long at = 1; status == DLS_E_MEMORY; at++) {
      dls_error e = {0};
      malloc_fails_at(at);
      status = dls_solve(&p, &s, r, NULL, NULL, &e);
      malloc_fails_at(0);
      if (status == DLS_E_MEMORY) {
        failed++;
        ck_assert(r[0] == 9 && e.status == DLS_E_MEMORY);
      }
    }
    ck_assert_int_eq(status, DLS_OK);
    ck_assert_int_ge(failed, 2);
  }
}
END_TEST

/* Ten steps of a load that turns: from the states of the step before, few pivots are left. */
START_TEST(lemke_starts_from_the_last_step) {
  dls_contact p = random_problem(6);
  double load[M], r[M], cold[M];
  int warm_pivots = 0, cold_pivots = 0;
  for (int k = 0; k < 10; k++) {
    for (int i = 0; i < M; i++)
      load[i] = q[i] + 0.02 * k * (i % 2 ? 1 : -1);
    p.q = load;
    dls_solver_settings s = settings_of(DLS_LEMKE);
    dls_info info;
    ck_assert_int_eq(dls_solve(&p, &s, cold, NULL, &info, NULL), DLS_OK);
    if (k > 0) cold_pivots += info.iterations;
    s.warm_start = k > 0;
    ck_assert_int_eq(dls_solve(&p, &s, r, NULL, &info, NULL), DLS_OK);
    if (k > 0) warm_pivots += info.iterations;
    for (int i = 0; i < M; i++)
      ck_assert_double_eq_tol(r[i], cold[i], 1e-11 * (1 + fabs(cold[i])));
  }
  ck_assert_int_lt(5 * warm_pivots, cold_pivots);
  dls_solver_settings s = settings_of(DLS_LEMKE);
  dls_error e;
  s.warm_start = 1;
  r[4] = INFINITY;
  ck_assert_int_eq(dls_solve(&p, &s, r, NULL, NULL, &e), DLS_E_NOT_FINITE);
  ck_assert_str_eq(e.argument, "r");
  ck_assert_int_eq(e.index, 4);
}
END_TEST

int main(void) {
  Suite *suite = suite_create("solve");
  TCase *tcase = tcase_create("solve");
  tcase_add_test(tcase, methods_have_names);
  tcase_add_test(tcase, methods_agree);
  tcase_add_test(tcase, units_do_not_change_the_path);
  tcase_add_test(tcase, permuted_candidates_same_answer);
  tcase_add_test(tcase, solver_is_reused_allocates_nothing_and_repeats_bits);
  tcase_add_test(tcase, progress_cancels);
  tcase_add_test(tcase, iteration_limit_is_honest);
  tcase_add_test(tcase, accelerations_have_names);
  tcase_add_test(tcase, bad_settings_are_refused);
  tcase_add_test(tcase, solver_refuses_other_sizes_and_bad_numbers);
  tcase_add_test(tcase, every_failing_malloc_unwinds);
  tcase_add_test(tcase, lemke_starts_from_the_last_step);
  suite_add_tcase(suite, tcase);
  SRunner *runner = srunner_create(suite);
  srunner_run_all(runner, CK_NORMAL);
  const int failed = srunner_ntests_failed(runner);
  srunner_free(runner);
  return failed == 0 ? EXIT_SUCCESS : EXIT_FAILURE;
}
