/*
 * test_side_by_side.c: eight host threads at once, each with its own objects: every method of the
 * table by every door, LCP solvers, a motion. Each answer has the bits that one thread alone gets.
 * Reductions and files: tests/reduction/test_threads.c.
 */
#define _POSIX_C_SOURCE 200809L /* pthread_barrier */

#include <check.h>
#include <pthread.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

#include "cases.h"
#include "delassus/motion.h"
#include "delassus/pivoting.h"
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

START_TEST(every_method_beside_itself) {
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
END_TEST

/* ---- threads of the BLAS --------------------------------------------------------------------- */

static double process_seconds(void) {
  struct timespec t;
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &t);
  return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

/* Prints CPU time, of all threads of the process and least of five, and the last bits of r, of
 * each method on a dense problem in 3D with the given number of candidates. Waits after a solve,
 * so that threads of the BLAS that still wait for work are counted. */
static int print_blas(int nc) {
  enum { turns = 5 };
  const struct timespec rest = {0, 60000000};
  const int m = 3 * nc;
  const size_t n = (size_t)m;
  double *A = malloc(n * n * sizeof *A), *W = malloc(n * n * sizeof *W);
  double *q = malloc(n * sizeof *q), *mu = malloc(n * sizeof *mu), *r = malloc(n * sizeof *r);
  if (!A || !W || !q || !mu || !r) return 1;
  set_seed(2);
  for (size_t k = 0; k < n * n; k++)
    A[k] = uniform();
  gram(m, A, 0.01, W);
  for (int k = 0; k < m; k++) {
    q[k] = uniform() - (k % 3 == 0 ? 0.4 : 0);
    mu[k] = 0.5;
  }
  const dls_contact problem = {.d = 3, .nc = nc, .W = {m, m, m, W}, .q = q, .mu = mu};
  for (int method = 0; method < method_count(); method++) {
    if (method == DLS_LEMKE || (method == DLS_HOMOTOPY && m > 150)) continue; /* slow */
    dls_solver_settings settings;
    dls_solver_settings_init(&settings);
    settings.method = (dls_method)method;
    double least = 1e9;
    dls_status status = DLS_OK;
    for (int k = 0; k < turns; k++) {
      nanosleep(&rest, NULL);
      const double begun = process_seconds();
      status = dls_solve(&problem, &settings, r, NULL, NULL, NULL);
      nanosleep(&rest, NULL);
      const double used = process_seconds() - begun;
      if (used < least) least = used;
    }
    unsigned long long bits = 0, word;
    for (size_t k = 0; k < n; k++) {
      memcpy(&word, r + k, sizeof word);
      bits = bits * 31 + word;
    }
    printf("%5d rows %-20s %7.2f ms of CPU, bits %04llx, %s\n", m,
           dls_method_name((dls_method)method), 1e3 * least, bits & 0xffff,
           dls_status_text(status));
  }
  free(A);
  free(W);
  free(q);
  free(mu);
  free(r);
  return 0;
}

/* test_side_by_side [blas CANDIDATES] */
int main(int argc, char **argv) {
  if (argc == 3 && strcmp(argv[1], "blas") == 0) return print_blas(atoi(argv[2]));
  return RUN("side by side", NULL, NULL, ONCE(every_method_beside_itself));
}
