/* test_batch.c: dls_solve_batch beside dls_solve. */
#include <check.h>
#include <math.h>
#include <string.h>

#include "cases.h"
#include "delassus/solve.h"
#include "errors.h"
#include "malloc_fails.h"
#include "run.h"

enum { count = 60 };

static struct {
  model a[count];
  block_storage B[count];
  dls_contact p[count];
  double r[count][most], u[count][most];
  double *at_r[count], *at_u[count];
  dls_info info[count];
} T;

/* Problems of all dimensions, in rows of as many candidates, dense and by blocks. */
static void batch_make(int by_block) {
  memset(&T, 0, sizeof T);
  set_seed(88172645463325252u + 2);
  for (int k = 0; k < count; k++) {
    const int d = 1 + k / 5 % 3, nc = 1 + k / 10 % 6 * 3;
    random_model(&T.a[k], d, nc, d == 1 ? 0 : .2 * (k % 4));
    T.p[k] = by_block && k % 2 ? by_blocks(&T.a[k], &T.B[k]) : T.a[k].p;
    T.at_r[k] = T.r[k];
    T.at_u[k] = T.u[k];
  }
}

START_TEST(answers) {
  batch_make(_i);
  dls_solver_settings s;
  dls_solver_settings_init(&s);
  s.limits.tol = 1e-12;
  int lanes = 0;
  ck_assert_int_eq(dls_solve_batch(count, T.p, &s, T.at_r, T.at_u, T.info, NULL), DLS_OK);
  for (int k = 0; k < count; k++) {
    const int m = T.p[k].d * T.p[k].nc;
    double r[most], u[most];
    dls_certificate c;
    ck_assert_int_eq(dls_solve(&T.p[k], &s, r, NULL, NULL, NULL), DLS_OK);
    ck_assert_int_eq(dls_contact_certify(&T.p[k], T.r[k], u, &c, NULL), DLS_OK);
    ck_assert(dls_certificate_holds(&c, 1e-12) && T.info[k].status == DLS_OK);
    ck_assert(c.residual == T.info[k].certificate.residual && T.info[k].method == DLS_AUTO);
    for (int i = 0; i < m; i++) {
      ck_assert(fabs(r[i] - T.r[k][i]) <= close_of(&T.a[k]));
      ck_assert(u[i] == T.u[k][i]);
    }
    lanes += T.info[k].stages == 1 && T.info[k].unique == DLS_UNIQUE_UNKNOWN;
  }
  ck_assert_int_gt(lanes, count / 4);
  double again[count][most];
  memcpy(again, T.r, sizeof again);
  ck_assert_int_eq(dls_solve_batch(count, T.p, &s, T.at_r, NULL, NULL, NULL), DLS_OK);
  ck_assert_mem_eq(again, T.r, sizeof again);
}
END_TEST

/* A count that ends within a row of equal shapes leaves the problems after it alone. */
START_TEST(what_comes_after_is_left_alone) {
  static const double untouched[most];
  dls_solver_settings s;
  dls_solver_settings_init(&s);
  for (int first = 1; first <= 9; first++) {
    batch_make(0);
    ck_assert_int_eq(dls_solve_batch(first, T.p, &s, T.at_r, T.at_u, T.info, NULL), DLS_OK);
    for (int k = first; k < count; k++)
      ck_assert(memcmp(T.r[k], untouched, sizeof untouched) == 0 && T.info[k].stages == 0);
  }
}
END_TEST

/* Warm from the answers nothing is done; other methods and limits go one by one. */
START_TEST(settings_hold) {
  batch_make(0);
  dls_solver_settings s;
  dls_solver_settings_init(&s);
  s.limits.tol = 1e-10;
  ck_assert_int_eq(dls_solve_batch(count, T.p, &s, T.at_r, NULL, NULL, NULL), DLS_OK);
  s.limits.warm_start = 1;
  ck_assert_int_eq(dls_solve_batch(count, T.p, &s, T.at_r, NULL, T.info, NULL), DLS_OK);
  for (int k = 0; k < count; k++)
    ck_assert_int_eq(T.info[k].iterations, 0);
  s.limits.warm_start = 0;
  s.method = DLS_NEWTON;
  ck_assert_int_eq(dls_solve_batch(count, T.p, &s, T.at_r, NULL, T.info, NULL), DLS_OK);
  for (int k = 0; k < count; k++)
    ck_assert_int_eq(T.info[k].method, DLS_NEWTON);
  s.method = DLS_AUTO;
  s.limits.max_iterations = 1;
  const dls_status status = dls_solve_batch(count, T.p, &s, T.at_r, NULL, T.info, NULL);
  ck_assert_int_eq(status, DLS_MAX_ITERATIONS);
  for (int k = 0; k < count; k++)
    ck_assert_int_le(T.info[k].iterations, 1);
}
END_TEST

/* The status is that of the first problem without a solution; the others are solved. */
START_TEST(one_without_a_solution) {
  batch_make(0);
  for (int k = 0; k < 8; k++)
    set_hand(&T.a[k], k == 3 ? &jammed[0] : hand_named("stick")), T.p[k] = T.a[k].p;
  const dls_status status = dls_solve_batch(8, T.p, NULL, T.at_r, NULL, T.info, NULL);
  ck_assert(status > 0 && status == T.info[3].status);
  for (int k = 0; k < 8; k++)
    ck_assert((T.info[k].status == DLS_OK) == (k != 3));
}
END_TEST

START_TEST(bad_input) {
  batch_make(0);
  dls_error e;
  dls_solver_settings s;
  dls_solver_settings_init(&s);
  ck_assert_int_eq(dls_solve_batch(0, NULL, NULL, NULL, NULL, NULL, &e), DLS_OK);
#define REFUSES(n, p, settings, r, status, argument, index)                                        \
  expect_error(dls_solve_batch(n, p, settings, r, NULL, T.info, &e), &e, status,                   \
               "dls_solve_batch", argument, index)
  REFUSES(-1, T.p, NULL, T.at_r, DLS_E_SIZE, "count", -1);
  REFUSES(count, NULL, NULL, T.at_r, DLS_E_ARGUMENT, "problem", -1);
  REFUSES(count, T.p, NULL, NULL, DLS_E_ARGUMENT, "r", -1);
  s.size = 0;
  REFUSES(count, T.p, &s, T.at_r, DLS_E_SETTINGS, "settings", -1);
  dls_solver_settings_init(&s);
  s.limits.warm_start = 1;
  T.r[7][0] = NAN;
  REFUSES(count, T.p, &s, T.at_r, DLS_E_NOT_FINITE, "problem", 7);
  T.r[7][0] = 0;
  T.at_r[9] = NULL;
  REFUSES(count, T.p, NULL, T.at_r, DLS_E_ARGUMENT, "problem", 9);
  T.at_r[9] = T.r[9];
  T.a[40].q[0] = INFINITY;
  REFUSES(count, T.p, NULL, T.at_r, DLS_E_NOT_FINITE, "problem", 40);
  ck_assert_ptr_nonnull(strstr(e.message, "q[0]"));
  for (int k = 0; k < count; k++)
    ck_assert(T.r[k][0] == 0);
#undef REFUSES
}
END_TEST

/* Memory is asked for as often for sixty problems as for twenty of the same kinds; and each malloc
 * may fail. */
START_TEST(memory) {
  batch_make(0);
  for (int k = 0; k < count; k++)
    T.p[k] = T.p[k % 20];
  long calls[2];
  for (int i = 0; i < 2; i++) {
    malloc_fails_at(0);
    const dls_status status = dls_solve_batch(i ? count : 20, T.p, NULL, T.at_r, NULL, NULL, NULL);
    calls[i] = malloc_calls();
    ck_assert_int_eq(status, DLS_OK);
  }
  ck_assert_int_eq(calls[0], calls[1]);
  dls_error e;
  for (long k = 1; k <= calls[1]; k++) {
    malloc_fails_at(k);
    const dls_status status = dls_solve_batch(count, T.p, NULL, T.at_r, NULL, NULL, &e);
    malloc_fails_at(0);
    ck_assert_msg(status == DLS_E_MEMORY && e.status == status, "malloc %ld: %d", k, (int)status);
    ck_assert_str_eq(e.function, "dls_solve_batch");
  }
}
END_TEST

/* Reactions beside an entry of 1e202 are rounding noise: the answer is certified with a residual of
 * 1, and it is the r that is handed out. */
START_TEST(noise_is_handed_out) {
  const double W[] = {0.03125, 2.25, 1.4423069849040525e+202, 2}, q[] = {-2.40625, 0.84375};
  const double mu = 0.03;
  const dls_contact problem = {.d = 2, .nc = 1, .W = {2, 2, 2, W}, .q = q, .mu = &mu};
  double r[2] = {0, 0}, *at_r[] = {r};
  dls_certificate c;
  ck_assert_int_eq(dls_solve_batch(1, &problem, NULL, at_r, NULL, NULL, NULL), DLS_OK);
  ck_assert_int_eq(dls_contact_certify(&problem, r, NULL, &c, NULL), DLS_OK);
  ck_assert(dls_certificate_holds(&c, 1e-8));
}
END_TEST

int main(void) {
  return RUN("batch", NULL, NULL, EACH(answers, 0, 2), ONCE(what_comes_after_is_left_alone),
             ONCE(settings_hold), ONCE(one_without_a_solution), ONCE(bad_input), ONCE(memory),
             ONCE(noise_is_handed_out));
}
