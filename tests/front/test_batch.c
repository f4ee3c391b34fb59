/* test_batch.c: dls_solve_batch against dls_solve. */
#include "cases.h"
#include "delassus/solve.h"
#include "made.h"
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

TEST_EACH(answers, 0, 2) {
  batch_make(_i);
  dls_solver_settings s = settings_with(DLS_AUTO, 1e-12);
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

/* A count that ends within a row of equal shapes leaves the problems after it alone. */
TEST(what_comes_after_is_left_alone) {
  static const double untouched[most];
  dls_solver_settings s = settings_with(DLS_AUTO, default_tol);
  for (int first = 1; first <= 9; first++) {
    batch_make(0);
    ck_assert_int_eq(dls_solve_batch(first, T.p, &s, T.at_r, T.at_u, T.info, NULL), DLS_OK);
    for (int k = first; k < count; k++)
      ck_assert(memcmp(T.r[k], untouched, sizeof untouched) == 0 && T.info[k].stages == 0);
  }
}

/* Warm from the answers nothing is done; other methods and limits go one by one. */
TEST(settings_hold) {
  batch_make(0);
  dls_solver_settings s = settings_with(DLS_AUTO, 1e-10);
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

/* The status is that of the first problem without a solution; the others are solved. */
TEST(one_without_a_solution) {
  batch_make(0);
  for (int k = 0; k < 8; k++)
    set_hand(&T.a[k], k == 3 ? &jammed[0] : hand_named("stick")), T.p[k] = T.a[k].p;
  const dls_status status = dls_solve_batch(8, T.p, NULL, T.at_r, NULL, T.info, NULL);
  ck_assert(status > 0 && status == T.info[3].status);
  for (int k = 0; k < 8; k++)
    ck_assert((T.info[k].status == DLS_OK) == (k != 3));
}

TEST(bad_input) {
  batch_make(0);
  dls_error e;
  dls_solver_settings s = settings_with(DLS_AUTO, default_tol);
  ck_assert_int_eq(dls_solve_batch(0, NULL, NULL, NULL, NULL, NULL, &e), DLS_OK);
  REFUSES(SIZE, "count", -1, dls_solve_batch, -1, T.p, NULL, T.at_r, NULL, T.info);
  REFUSES(ARGUMENT, "problem", -1, dls_solve_batch, count, NULL, NULL, T.at_r, NULL, T.info);
  REFUSES(ARGUMENT, "r", -1, dls_solve_batch, count, T.p, NULL, NULL, NULL, T.info);
  s.size = 0;
  REFUSES(SETTINGS, "settings", -1, dls_solve_batch, count, T.p, &s, T.at_r, NULL, T.info);
  dls_solver_settings_init(&s);
  s.limits.warm_start = 1;
  T.r[7][0] = NAN;
  REFUSES(NOT_FINITE, "problem", 7, dls_solve_batch, count, T.p, &s, T.at_r, NULL, T.info);
  T.r[7][0] = 0;
  T.at_r[9] = NULL;
  REFUSES(ARGUMENT, "problem", 9, dls_solve_batch, count, T.p, NULL, T.at_r, NULL, T.info);
  T.at_r[9] = T.r[9];
  T.a[40].q[0] = INFINITY;
  REFUSES(NOT_FINITE, "problem", 40, dls_solve_batch, count, T.p, NULL, T.at_r, NULL, T.info);
  ck_assert_ptr_nonnull(strstr(last_refusal.message, "q[0]"));
  for (int k = 0; k < count; k++)
    ck_assert(T.r[k][0] == 0);
}

/* Memory is asked for as often for sixty problems as for twenty of the same kinds; and each malloc
 * may fail. */
TEST(memory) {
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

/* Beside an entry of 1e202 r_t has to be 0, which no state of the contact allows: nothing is
 * solved. The states' matrices are singular to rounding, so that no verdict is due, either. */
TEST(noise_is_no_answer) {
  const double W[] = {0.03125, 2.25, 1.4423069849040525e+202, 2}, q[] = {-2.40625, 0.84375};
  const double mu = 0.03;
  const dls_contact problem = {.d = 2, .nc = 1, .W = {2, 2, 2, W}, .q = q, .mu = &mu};
  double r[2] = {0, 0}, *at_r[] = {r};
  ck_assert_int_eq(dls_solve_batch(1, &problem, NULL, at_r, NULL, NULL, NULL), DLS_STALLED);
  const dls_certificate c = certificate_of(&problem, r);
  ck_assert(!dls_certificate_holds(&c, 1e-8));
}

/* ---- what goes into the lanes ---------------------------------------------------------------- */

enum { easy_count = 24 };

/* Problems of nc candidates that nothing presses: swept side by side they count a stage and the
 * sweeps of all, alone neither. */
static void make_easy(int d, int nc) {
  memset(&T, 0, sizeof T);
  for (int k = 0; k < easy_count; k++) {
    set_model(&T.a[k], d, nc);
    for (int i = 0; i < d * nc; i++) {
      T.a[k].W[i + T.a[k].p.W.ld * i] = 1;
      T.a[k].q[i] = i % d == 0;
    }
    T.p[k] = T.a[k].p;
    T.at_r[k] = T.r[k];
    T.at_u[k] = T.u[k];
  }
}

/* Makes problem k one of many sweeps: two candidates pressed against each other. */
static void make_slow(int k) {
  const int d = T.p[k].d;
  T.a[k].W[d] = T.a[k].W[T.p[k].W.ld * d] = 0.75;
  T.a[k].q[0] = T.a[k].q[d] = -1;
}

static int runs(int n, const dls_solver_settings *s) {
  return dls_solve_batch(n, T.p, s, T.at_r, T.at_u, T.info, NULL) == DLS_OK;
}

/* One to eight candidates are swept, in any dimension; nine, none, bonded ones, bodies are not. */
TEST(which_are_swept) {
  const double H[18] = {1, 0, 0, 0, 1, 0};
  const int body[2] = {0, -1};
  for (int d = 1; d <= 3; d++)
    for (int nc = 0; nc <= 9; nc++) {
      make_easy(d, nc);
      ck_assert(runs(1, NULL));
      ck_assert_int_eq(T.info[0].stages, nc > 0 && nc < 9);
      ck_assert(T.info[0].method == DLS_AUTO && T.info[0].status == DLS_OK);
    }
  make_easy(2, 1);
  T.a[1].mu[0] = INFINITY;
  T.p[4].W.a = NULL;
  T.p[4].bodies = (dls_bodies){3, 1, body, H, NULL};
  ck_assert(runs(8, NULL));
  for (int k = 0; k < 8; k++)
    ck_assert_int_eq(T.info[k].stages, k != 1 && k != 4);
}

/* Limits, a start and other methods keep all out of the lanes, where all share sweeps. */
TEST(settings_that_sweep_none) {
  for (int k = 0; k < 5; k++) {
    dls_solver_settings s = settings_with(DLS_AUTO, default_tol);
    if (k == 1) s.limits.cpu_seconds = 0.5;
    if (k == 2) s.limits.max_iterations = 1;
    if (k == 3) s.limits.warm_start = 1;
    if (k == 4) s.method = DLS_NLGS;
    make_easy(2, 2);
    make_slow(0);
    ck_assert(runs(3, &s) == (k != 2));
    ck_assert_int_ge(T.info[0].iterations, k == 2 ? 1 : 2);
    for (int i = 1; i < 3; i++)
      ck_assert_int_eq(T.info[i].iterations == T.info[0].iterations, k == 0);
    ck_assert_int_eq(T.info[0].method, k == 4 ? DLS_NLGS : DLS_AUTO);
  }
}

/* Eight in a row of as many candidates share the sweeps of the slowest; a bonded one, a body,
 * another number of candidates and the end of the list end the row. */
TEST(rows_share_their_sweeps) {
  const double H[36] = {1, 0, 0, 0, 1, 0};
  const int body[4] = {0, -1, 0, -1};
  for (int slow = 0; slow < 8; slow += 7)
    for (int end = 1; end <= 8; end++)
      for (int kind = 0; kind < 4; kind++) {
        if (slow >= end) continue;
        make_easy(2, 2);
        make_slow(slow);
        if (kind == 1) T.a[end].mu[0] = INFINITY;
        if (kind == 2) T.p[end].W.a = NULL;
        if (kind == 2) T.p[end].bodies = (dls_bodies){3, 1, body, H, NULL};
        if (kind == 3) T.p[end].nc = T.p[end].W.rows = T.p[end].W.cols = 1;
        if (kind == 3) T.p[end].d = T.p[end].nc = 1;
        ck_assert(runs(kind ? 16 : end, NULL));
        const int sweeps = T.info[slow].iterations;
        ck_assert_int_gt(sweeps, 8);
        for (int k = 0; k < (kind ? 16 : end); k++) {
          ck_assert_msg((T.info[k].iterations == sweeps) == (k < end), "%d of %d: %d", k, end,
                        kind);
          if (k >= end) continue;
          ck_assert(T.info[k].stages == 1 && T.info[k].stage[0].method == DLS_NLGS);
          ck_assert(T.info[k].stage[0].iterations == sweeps && T.info[k].stage[1].iterations == 0);
          ck_assert(T.info[k].stage[0].residual == T.info[k].certificate.residual);
        }
      }
}

/* A candidate with three solutions, beside one that is pressed, is told of as dls_solve does. */
TEST(several_solutions_are_told) {
  dls_info info;
  double r[4];
  make_easy(2, 2);
  model *a = &T.a[2];
  a->W[1] = a->W[a->p.W.ld] = 1; /* W_cc = (1 1; 1 2), q_c = (1, 4) */
  a->W[1 + a->p.W.ld] = a->mu[0] = 2;
  a->q[1] = 4;
  a->q[2] = -1;
  ck_assert(runs(4, NULL));
  ck_assert_int_eq(dls_solve(&T.p[2], NULL, r, NULL, &info, NULL), DLS_OK);
  ck_assert_int_eq(info.ambiguous, 1);
  for (int k = 0; k < 4; k++)
    ck_assert_int_eq(T.info[k].ambiguous, k == 2);
  ck_assert(T.info[2].method == DLS_AUTO);
}

/* The first and the last problem are looked at, each with its own r and u. */
TEST(each_is_checked) {
  dls_error e;
  make_easy(2, 1);
  REFUSES(ARGUMENT, "problem", -1, dls_solve_batch, 1, NULL, NULL, T.at_r, NULL, NULL);
  REFUSES(ARGUMENT, "r", -1, dls_solve_batch, 1, T.p, NULL, NULL, NULL, NULL);
  for (int k = 0; k < 4; k++) {
    make_easy(2, 1);
    T.a[k].q[1] = NAN;
    REFUSES(NOT_FINITE, "problem", k, dls_solve_batch, 4, T.p, NULL, T.at_r, NULL, NULL);
    ck_assert(last_refusal.value != last_refusal.value);
    T.a[k].q[1] = 0;
    T.at_u[k] = T.r[k]; /* overlaps */
    REFUSES(ARGUMENT, "problem", k, dls_solve_batch, 4, T.p, NULL, T.at_r, T.at_u, NULL);
    T.at_u[k] = NULL;
    ck_assert_int_eq(dls_solve_batch(4, T.p, NULL, T.at_r, T.at_u, NULL, &e), DLS_OK);
    for (int i = 0; i < 4; i++)
      ck_assert(T.u[i][0] == (i != k));
  }
}
