/*
 * test_threads.c: many host threads at once, each with its own objects. Every answer has the bits
 * that one thread alone computes.
 *
 * The bodies are chains of cells with one contact node each, more than 250 connected unknowns, so
 * that MUMPS and METIS are at work: LU and LDLT of K, sparse LU in Newton's method for W by blocks;
 * every second problem is dense.
 */
#define _POSIX_C_SOURCE 200809L /* pthread_barrier, mkstemp */

#include <pthread.h>
#include <time.h>
#include <unistd.h>

#include "contact/contact.h"
#include "delassus.h"
#include "made.h"
#include "reduced.h"
#include "run.h"

enum { threads = 8, problems = 100 };
enum { cells = 80, per_cell = 4, n = cells * per_cell, most = 5 * n };
enum { blocks_nc = 140, blocks_m = 2 * blocks_nc };

typedef struct body {
  int p[n + 1], i[most], Np[cells + 1], Ni[cells], Tp[cells + 1], Ti[cells];
  double x[most], Nx[cells], Tx[cells], f[n], mu[cells];
  double dense[n * n];
  dls_model model;
} body;

/* What is compared: an answer, or the status that stands for none. */
typedef struct answer {
  dls_status status;
  double r[blocks_m], x[n];
} answer;

static double uniform(uint64_t *seed) {
  *seed = *seed * 6364136223846793005u + 1442695040888963407u;
  return (double)(*seed >> 11) / 9007199254740992.0;
}

/* A chain: unknown j is joined to j+1 and j+4 by springs of random stiffness, all stand on soft
 * ones; the first two unknowns of a cell are its contact node. skew: an unsymmetric part. */
static void body_make(body *b, uint64_t seed, double skew) {
  const int reach[] = {1, 4};
  int e = 0;
  memset(b, 0, sizeof *b);
  double *K = b->dense;
  for (int j = 0; j < n; j++) {
    K[j + j * n] += 0.1 + uniform(&seed);
    for (int k = 0; k < 2; k++) {
      const int i = j + reach[k];
      if (i >= n) continue;
      const double s = 1 + uniform(&seed), a = skew * s;
      K[j + j * n] += s;
      K[i + i * n] += s;
      K[i + j * n] -= s - a;
      K[j + i * n] -= s + a;
    }
    b->f[j] = uniform(&seed) - (j % per_cell == 1 ? 1 : 0.5);
  }
  for (int j = 0; j < n; j++) {
    for (int i = 0; i < n; i++) {
      if (K[i + j * n] == 0) continue;
      b->i[e] = i;
      b->x[e++] = K[i + j * n];
    }
    b->p[j + 1] = e;
  }
  for (int c = 0; c < cells; c++) {
    b->Ti[c] = per_cell * c;
    b->Ni[c] = per_cell * c + 1;
    b->Np[c + 1] = b->Tp[c + 1] = c + 1;
    b->Nx[c] = b->Tx[c] = 1;
    b->mu[c] = 0.5 * uniform(&seed);
  }
  b->model = (dls_model){.d = 2, .n = n, .nodes = cells, .K = {n, n, n, b->dense}};
  b->model.Ks = (dls_sparse){n, n, b->p, b->i, b->x};
  b->model.HN = (dls_sparse){n, cells, b->Np, b->Ni, b->Nx};
  b->model.HT = (dls_sparse){n, cells, b->Tp, b->Ti, b->Tx};
}

/* K -> W -> r -> x. */
static void solve_body(body *b, uint64_t seed, dls_operator kind, dls_factorization factorization,
                       answer *out) {
  dls_reduction *reduction;
  dls_contact problem;
  body_make(b, seed, factorization == DLS_LU ? 0.3 : 0);
  b->model.operator_kind = kind;
  b->model.factorization = factorization;
  out->status = reduce_on_W(&reduction, &b->model, NULL, NULL);
  if (!out->status) out->status = dls_reduction_load(reduction, b->f, NULL, NULL);
  if (!out->status) out->status = dls_reduction_contact(reduction, b->mu, &problem, NULL);
  if (!out->status) out->status = dls_solve(&problem, NULL, out->r, NULL, NULL, NULL);
  if (!out->status) out->status = dls_reduction_recover(reduction, out->r, out->x, NULL);
  dls_reduction_destroy(reduction);
}

/* A row of candidates that all press and couple to their neighbours, W by blocks: Newton's method
 * takes sparse LU. */
static void solve_blocks(uint64_t seed, answer *out) {
  int p[blocks_nc + 1] = {0}, i[3 * blocks_nc], e = 0;
  double x[12 * blocks_nc], q[blocks_m], mu[blocks_nc];
  for (int c = 0; c < blocks_nc; c++) {
    for (int a = c - 1; a <= c + 1; a++) {
      if (a < 0 || a >= blocks_nc) continue;
      const double coupling = -0.45, tangent = a == c ? 0.1 : 0.05;
      const double block[] = {a == c ? 1 : coupling, tangent, tangent, a == c ? 1 : coupling};
      memcpy(x + 4 * e, block, sizeof block);
      i[e++] = a;
    }
    p[c + 1] = e;
    q[2 * c] = -1 - uniform(&seed);
    q[2 * c + 1] = uniform(&seed) - 0.5;
    mu[c] = 0.3;
  }
  const dls_contact problem = {
      .d = 2, .nc = blocks_nc, .Wb = {2, blocks_nc, p, i, x}, .q = q, .mu = mu};
  dls_solver_settings settings = settings_with(DLS_NEWTON, default_tol);
  out->status = dls_solve(&problem, &settings, out->r, NULL, NULL, NULL);
}

/* Writes the body's model as an FCLIB file and reads it back. */
static void solve_file(body *b, uint64_t seed, answer *out) {
  char path[] = "/tmp/delassus-threads-XXXXXX";
  static const double none[2 * cells];
  dls_fclib *file = NULL;
  dls_model model;
  const double *f, *g, *mu;
  const int held = mkstemp(path);
  ck_assert_int_ge(held, 0);
  close(held);
  body_make(b, seed, 0);
  b->model.operator_kind = DLS_STIFFNESS_SPARSE;
  b->model.factorization = DLS_LU;
  out->status =
      dls_fclib_write_global(path, &b->model, b->f, none, b->mu, "threads", NULL, NULL, NULL, NULL);
  if (!out->status) out->status = dls_fclib_read(&file, path, NULL);
  if (!out->status) out->status = dls_fclib_model(file, &model, &f, &g, &mu, NULL);
  if (!out->status) memcpy(out->x, f, sizeof out->x);
  dls_fclib_destroy(file);
  unlink(path);
}

static void solve_one(body *b, int k, answer *out) {
  const uint64_t seed = (uint64_t)(2 * k + 2);
  memset(out, 0, sizeof *out);
  switch (k % 8) {
  case 0:
    solve_body(b, seed, DLS_STIFFNESS_SPARSE, DLS_LDLT, out);
    break;
  case 2:
    solve_body(b, seed, DLS_STIFFNESS_SPARSE, DLS_LU, out);
    break;
  case 4:
    solve_body(b, seed, DLS_STIFFNESS_SPARSE, DLS_CHOLESKY, out);
    break;
  case 6:
    solve_blocks(seed, out);
    break;
  case 7:
    solve_file(b, seed, out);
    break;
  default:
    solve_body(b, seed, DLS_STIFFNESS_DENSE, k % 8 == 1 ? DLS_CHOLESKY : DLS_LU, out);
  }
}

static pthread_barrier_t together;

typedef struct worker {
  int first; /* problems first, first + 1, .. of the round */
  answer *expected;
  int wrong; /* answers whose bits are others */
} worker;

/* Every thread solves all problems, beginning at another one. */
static void *worker_run(void *data) {
  worker *w = data;
  body *b = malloc(sizeof *b);
  answer *a = malloc(sizeof *a);
  pthread_barrier_wait(&together);
  for (int k = 0; k < problems; k++) {
    const int which = (w->first + k) % problems;
    solve_one(b, which, a);
    w->wrong += memcmp(a, &w->expected[which], sizeof *a) != 0;
  }
  free(a);
  free(b);
  return NULL;
}

TEST(eight_threads_get_the_answers_of_one) {
  answer *expected = malloc(problems * sizeof *expected);
  body *b = malloc(sizeof *b);
  for (int k = 0; k < problems; k++) {
    solve_one(b, k, &expected[k]);
    if (expected[k].status != DLS_E_UNSUPPORTED) ck_assert_int_eq(expected[k].status, DLS_OK);
  }
  free(b);
  pthread_t thread[threads];
  worker w[threads];
  ck_assert_int_eq(pthread_barrier_init(&together, NULL, threads), 0);
  for (int t = 0; t < threads; t++) {
    w[t] = (worker){problems / threads * t, expected, 0};
    ck_assert_int_eq(pthread_create(&thread[t], NULL, worker_run, &w[t]), 0);
  }
  for (int t = 0; t < threads; t++)
    ck_assert_int_eq(pthread_join(thread[t], NULL), 0);
  pthread_barrier_destroy(&together);
  for (int t = 0; t < threads; t++)
    ck_assert_int_eq(w[t].wrong, 0);
  free(expected);
}

/* ---- cost of the lock ------------------------------------------------------------------------ */

static double now(void) {
  struct timespec t;
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &t);
  return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

/* Prints what an uncontended lock costs beside the cheapest call of MUMPS here, one solve with
 * n = 320; least of several. Runs in a second thread, as a lock in a process of one thread may be
 * cheaper. */
static void *print_cost(void *data) {
  enum { rounds = 9, pairs = 100000, solves = 200 };
  double lock = 1, solve = 1;
  body *b = data;
  static answer a;
  dls_reduction *reduction;
  body_make(b, 2, 0.3);
  b->model.operator_kind = DLS_STIFFNESS_SPARSE;
  b->model.factorization = DLS_LU;
  dls_status status = reduce_on_W(&reduction, &b->model, NULL, NULL);
  for (int round = 0; !status && round < rounds; round++) {
    double begin = now();
    for (int k = 0; k < pairs; k++) {
      dlsi_lock();
      dlsi_unlock();
    }
    const double one_lock = (now() - begin) / pairs;
    begin = now();
    for (int k = 0; !status && k < solves; k++)
      status = dls_reduction_recover(reduction, a.r, a.x, NULL);
    const double one_solve = (now() - begin) / solves;
    if (one_lock < lock) lock = one_lock;
    if (one_solve < solve) solve = one_solve;
  }
  dls_reduction_destroy(reduction);
  if (status)
    printf("%s\n", dls_status_text(status));
  else
    printf("lock and unlock %.0f ns, one solve by MUMPS with n = %d %.0f us\n", 1e9 * lock, n,
           1e6 * solve);
  return NULL;
}

static int cost(void) {
  pthread_t thread;
  body *b = malloc(sizeof *b);
  if (!b || pthread_create(&thread, NULL, print_cost, b)) return 1;
  pthread_join(thread, NULL);
  free(b);
  return 0;
}

/* test_threads [cost] */
int main(int argc, char **argv) {
  if (argc == 2 && strcmp(argv[1], "cost") == 0) return cost();
  return run_tests("threads", NULL, NULL);
}
