/*
 * test_side_by_side.c: eight host threads at once, each with its own objects: every method of the
 * table by every door, LCP solvers, a motion. Each answer has the same bits as one thread alone.
 * Reductions and files: tests/reduction/test_threads.c.
 */
#define _POSIX_C_SOURCE 200809L /* pthread_barrier */

#include <pthread.h>

#include "cases.h"
#include "delassus.h"
#include "doors.h"
#include "run.h"

enum { threads = 8, numbered = 10, problems = numbered + 4, steps = 40, most_tasks = 1000 };

typedef struct answer {
  dls_status status;
  double x[most];
} answer;

static model of[problems]; /* read by all threads */

static void make_problems(void) {
  for (int k = 0; k < numbered; k++)
    numbered_model(&of[k], 3 * k + 1);
  set_hand(&of[numbered], &jammed[0]);
  set_hand(&of[numbered + 1], hand_named("C13"));
  slow_model(&of[numbered + 2], 0);
  slow_model(&of[numbered + 3], 1);
}

static void solve_by_door(int k, const model *a, answer *out) {
  const tested_solver s = door(k);
  union {
    char bytes[256];
    double alignment;
    void *pointer;
  } settings;
  void *work = NULL;
  s.init(&s, &settings, 1e-10, 0);
  out->status = s.create(&work, a->p.d, a->p.nc, &settings, NULL);
  if (!out->status) out->status = s.solve(work, &a->p, out->x, NULL, NULL, NULL);
  s.destroy(work);
}

/* Solves LCP(W, q) by both pivoting methods. */
static void pivot_one(const model *a, answer *out) {
  const int n = a->p.d * a->p.nc;
  const dls_lcp lcp = {.n = n, .M = a->p.W, .q = a->q};
  dls_lemke *lemke = NULL;
  dls_principal *principal = NULL;
  double z[most] = {0};
  out->status = dls_lemke_create(&lemke, n, NULL, NULL);
  if (!out->status) out->status = dls_lemke_solve(lemke, &lcp, out->x, NULL, NULL, NULL);
  if (!out->status) out->status = dls_principal_create(&principal, n, NULL, NULL);
  if (!out->status) out->status = dls_principal_solve(principal, &lcp, z, NULL, NULL, NULL);
  for (int i = 0; i < n; i++)
    out->x[i] += z[i];
  dls_lemke_destroy(lemke);
  dls_principal_destroy(principal);
}

/* A point on a spring thrown along an obstacle, M = 1, K = 2. */
static void move(answer *out) {
  static const int p[3] = {0, 1, 2}, i[2] = {0, 1}, turned[1] = {1};
  static const double one[2] = {1, 1}, two[2] = {2, 2}, f[2] = {0.5, -3}, mu = 0.25;
  const dls_motion_model body = {.d = 2,
                                 .n = 2,
                                 .nodes = 1,
                                 .factorization = DLS_CHOLESKY,
                                 .M = {2, 2, p, i, one},
                                 .K = {2, 2, p, i, two},
                                 .HN = {2, 1, p, turned, one},
                                 .HT = {2, 1, p, i, one}};
  const double v[2] = {2, -1};
  dls_motion_settings settings;
  dls_motion *motion = NULL;
  dls_motion_state state;
  dls_motion_settings_init(&settings);
  settings.h = 0.05;
  settings.restitution = 0.5;
  out->status = dls_motion_create(&motion, &body, &settings, NULL);
  if (!out->status) out->status = dls_motion_start(motion, NULL, v, 0, NULL);
  for (int k = 0; !out->status && k < steps; k++)
    out->status = dls_motion_step(motion, f, NULL, &mu, NULL, NULL);
  if (!out->status) out->status = dls_motion_get_state(motion, &state, NULL);
  if (!out->status) memcpy(out->x, state.x, 2 * sizeof *out->x);
  if (!out->status) memcpy(out->x + 2, state.p, 2 * sizeof *out->x);
  dls_motion_destroy(motion);
}

static int task_count(void) {
  return (direct_doors + method_count()) * problems + problems + 1;
}

static void do_task(int task, answer *out) {
  const int doors = direct_doors + method_count();
  memset(out, 0, sizeof *out);
  if (task < doors * problems)
    solve_by_door(task / problems, &of[task % problems], out);
  else if (task < (doors + 1) * problems)
    pivot_one(&of[task % problems], out);
  else
    move(out);
}

static pthread_barrier_t together;

typedef struct side {
  int first;
  const answer *expected;
  int wrong; /* the first task + 1 whose bits are others */
} side;

/* Does all tasks, beginning at another one than the other threads. */
static void *do_all(void *data) {
  side *own = data;
  const int count = task_count();
  pthread_barrier_wait(&together);
  for (int k = 0; k < count; k++) {
    const int task = (own->first + k) % count;
    answer a;
    do_task(task, &a);
    if (memcmp(&a, &own->expected[task], sizeof a) && !own->wrong) own->wrong = task + 1;
  }
  return NULL;
}

TEST(every_method_beside_itself) {
  const int count = task_count();
  static answer expected[most_tasks];
  ck_assert_int_le(count, most_tasks);
  make_problems();
  int solved = 0;
  for (int task = 0; task < count; task++) {
    do_task(task, &expected[task]);
    ck_assert_int_ge(expected[task].status, DLS_E_ARGUMENT); /* some LCP(W, q) are beyond them */
    solved += expected[task].status == DLS_OK;
  }
  ck_assert_int_ge(solved, count * 3 / 4);
  ck_assert_int_eq(expected[count - 1].status, DLS_OK);
  pthread_t thread[threads];
  side sides[threads];
  ck_assert_int_eq(pthread_barrier_init(&together, NULL, threads), 0);
  for (int t = 0; t < threads; t++) {
    sides[t] = (side){count / threads * t, expected, 0};
    ck_assert_int_eq(pthread_create(&thread[t], NULL, do_all, &sides[t]), 0);
  }
  for (int t = 0; t < threads; t++)
    ck_assert_int_eq(pthread_join(thread[t], NULL), 0);
  pthread_barrier_destroy(&together);
  for (int t = 0; t < threads; t++)
    ck_assert_int_eq(sides[t].wrong, 0);
}
