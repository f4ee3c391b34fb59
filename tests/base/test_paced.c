/* test_paced.c: a callback that is called now and then. */
#define _POSIX_C_SOURCE 200809L
#include <time.h>

#include "delassus.h"
#include "made.h"
#include "run.h"

static int calls, answer;
static const dls_progress *got;

static int count_call(void *data, const dls_progress *progress) {
  got = progress;
  calls += data == &calls;
  return answer;
}

static double now(void) {
  struct timespec t;
  ck_assert_int_eq(clock_gettime(CLOCK_MONOTONIC, &t), 0);
  return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

TEST(one_call_in_each_stretch) {
  dls_paced paced = {.progress = count_call, .progress_data = &calls, .seconds = 0.01};
  dls_progress progress = {.iteration = 1};
  const double begun = now();
  int asked = 0;
  calls = answer = 0;
  ck_assert_int_eq(dls_progress_paced(&paced, &progress), 0);
  ck_assert_int_eq(calls, 0);
  while (calls < 3) {
    ck_assert_int_eq(dls_progress_paced(&paced, &progress), 0);
    asked++;
  }
  ck_assert(got == &progress && asked > 3 && now() - begun >= 0.03);
}

TEST(its_answer_cancels) {
  dls_paced paced = {.progress = count_call, .progress_data = &calls, .seconds = 1e-9};
  dls_progress progress = {.iteration = 1}, last = {.last = 1};
  calls = 0;
  answer = 7;
  ck_assert_int_eq(dls_progress_paced(&paced, &progress), 0); /* the first use begins to count */
  const struct timespec wait = {0, 1000};
  ck_assert_int_eq(nanosleep(&wait, NULL), 0);
  ck_assert_int_eq(dls_progress_paced(&paced, &progress), 7);
  ck_assert_int_eq(dls_progress_paced(&paced, &last), 0);
  ck_assert_int_eq(calls, 1);
}

/* A solve that cycles ends by the callback, whose cpu_seconds are those of a limit alone. */
TEST(a_solve_is_cancelled) {
  const double W[] = {1, 0, -1, 0, 0, 1, 0, 1, -1, 0, 1, 0, 0, 1, 0, 1}, q[] = {-1, 0, -1, 0};
  const double mu[] = {0.5, 0.5};
  const dls_contact problem = {.d = 2, .nc = 2, .W = {4, 4, 4, W}, .q = q, .mu = mu};
  dls_paced paced = {.progress = count_call, .progress_data = &calls, .seconds = 0.01};
  dls_info info;
  double r[4];
  dls_solver_settings settings = settings_with(DLS_NLGS, default_tol);
  settings.limits.max_iterations = 2000000000;
  settings.limits.progress = dls_progress_paced;
  settings.limits.progress_data = &paced;
  calls = 0;
  answer = 1;
  ck_assert_int_eq(dls_solve(&problem, &settings, r, NULL, &info, NULL), DLS_CANCELLED);
  ck_assert(calls == 1 && info.iterations > 1);
}
