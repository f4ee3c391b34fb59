/*
 * test_traps.c: a host that traps floating point errors, rounds upwards and keeps flags. Every
 * method solves every problem of data/ without a trap, to the bits of a plain host; traps, rounding
 * and flags stay as the host has set them; its callbacks find them so.
 */
#define _GNU_SOURCE /* feenableexcept */
#include <fenv.h>
#include <pthread.h>

#include "contact/contact.h"
#include "delassus.h"
#include "doors.h"
#include "failures.h"
#include "fclib_file.h"
#include "made.h"
#include "reduced.h"
#include "run.h"
#include "solids.h"

enum { capacity = 4000 };

/* ---- a host with traps ----------------------------------------------------------------------- */

#ifdef FE_UPWARD
static const int rounding = FE_UPWARD;
#else
static const int rounding = FE_TONEAREST;
#endif

static int traps; /* where the processor has them */

static int traps_now(void) {
#ifdef __GLIBC__
  return fegetexcept();
#else
  return 0;
#endif
}

static void set_host(void) {
  ck_assert_int_eq(feclearexcept(FE_ALL_EXCEPT), 0);
  ck_assert_int_eq(feraiseexcept(FE_UNDERFLOW), 0);
  ck_assert_int_eq(feclearexcept(FE_ALL_EXCEPT & ~FE_UNDERFLOW), 0);
  ck_assert_int_eq(fesetround(rounding), 0);
#ifdef __GLIBC__
  (void)feenableexcept(FE_INVALID | FE_DIVBYZERO | FE_OVERFLOW);
#endif
  traps = traps_now();
}

static void set_plain(void) {
  ck_assert_int_eq(fesetenv(FE_DFL_ENV), 0);
}

static int is_host(void) {
  return traps_now() == traps && fegetround() == rounding;
}

/* The host's environment with its flags. */
static void expect_host(const char *where) {
  const int now = traps_now(), round = fegetround(), flags = fetestexcept(FE_ALL_EXCEPT);
  set_plain(); /* the library check computes */
  ck_assert_msg(now == traps, "%s: traps %d, were %d", where, now, traps);
  ck_assert_msg(round == rounding, "%s: rounding", where);
  ck_assert_msg(flags == FE_UNDERFLOW, "%s: flags %d, were %d", where, flags, FE_UNDERFLOW);
}

/* ---- every method ---------------------------------------------------------------------------- */

/* Solves twice, without traps and with them. */
static void solve_both(const dls_contact *p, const dls_solver_settings *s, const char *name) {
  static double r[2][capacity], u[2][capacity];
  const size_t m = (size_t)p->d * (size_t)p->nc;
  dls_info info[2];
  dls_status status[2];
  ck_assert_int_le((int)m, capacity);
  memset(r, 0, sizeof r);
  memset(u, 0, sizeof u);
  status[0] = dls_solve(p, s, r[0], u[0], &info[0], NULL);
  set_host();
  status[1] = dls_solve(p, s, r[1], u[1], &info[1], NULL);
  expect_host(name);
  ck_assert_msg(status[0] == status[1], "%s, %s: %d, with traps %d", name,
                dls_method_name(s->method), status[0], status[1]);
  ck_assert_msg(!memcmp(r[0], r[1], m * sizeof **r) && !memcmp(u[0], u[1], m * sizeof **u),
                "%s, %s: other bits with traps", name, dls_method_name(s->method));
}

static int iterations(void *data, const dls_progress *progress) {
  (void)progress;
  *(int *)data += 1;
  return 0;
}

/* Every method, silent and with a callback. */
static void every_method(const dls_contact *p, int most_iterations, const char *name) {
  for (int method = 0; method < method_count(); method++) {
    int calls = 0;
    dls_solver_settings s = settings_with((dls_method)method, default_tol);
    s.limits.max_iterations = most_iterations;
    solve_both(p, &s, name);
    s.limits.progress = iterations;
    s.limits.progress_data = &calls;
    solve_both(p, &s, name);
  }
}

/* What tells of a problem and of an answer. */
static void every_look(const dls_contact *p, const double *r, const char *name) {
  double u[FAILURE_N];
  dls_certificate c;
  dls_diagnosis about;
  dls_contact_state state[FAILURE_N];
  set_host();
  dls_status status = dls_contact_certify(p, r, u, &c, NULL);
  if (!status) status = dls_contact_states(p, r, u, state, NULL);
  const int holds = dls_certificate_holds(&c, 1e-8);
  const dls_status of_problem = dls_contact_diagnose(p, 100, &about, NULL);
  expect_host(name);
  ck_assert_int_eq(status, DLS_OK);
  ck_assert_int_ge(holds, 0);
  ck_assert_int_ge(of_problem, DLS_OK);
}

TEST(every_failure) {
  int count = 0;
  const failure *all = contact_failures(&count);
  ck_assert_int_gt(count, 0);
  for (int k = 0; k < count; k++) {
    const dls_contact p = failure_contact(&all[k]);
    every_method(&p, 200, all[k].name);
    for (int point = 0; point < all[k].points; point++)
      every_look(&p, all[k].point[point].x, all[k].name);
  }
}

/* Pivots on an LCP by both methods. */
static void pivot_both(const dls_lcp *lcp, const char *name) {
  static double z[4][capacity];
  const size_t n = (size_t)lcp->n;
  dls_status status[4];
  memset(z, 0, sizeof z);
  for (int k = 0; k < 4; k++) {
    dls_lemke *lemke = NULL;
    dls_principal *principal = NULL;
    if (k > 1) set_host();
    dls_status s = k % 2 ? dls_principal_create(&principal, lcp->n, NULL, NULL)
                         : dls_lemke_create(&lemke, lcp->n, NULL, NULL);
    if (!s)
      s = k % 2 ? dls_principal_solve(principal, lcp, z[k], NULL, NULL, NULL)
                : dls_lemke_solve(lemke, lcp, z[k], NULL, NULL, NULL);
    if (k > 1) expect_host(name);
    status[k] = s;
    dls_lemke_destroy(lemke);
    dls_principal_destroy(principal);
  }
  for (int k = 0; k < 2; k++) {
    ck_assert_int_eq(status[k], status[k + 2]);
    ck_assert_msg(!memcmp(z[k], z[k + 2], n * sizeof **z), "%s: other bits with traps", name);
  }
}

TEST(every_lcp) {
  static char names[128][64];
  static failure f;
  char why[200];
  int lcps = 0;
  const int count = failures_list(TEST_DATA "/failures", names, 128);
  for (int k = 0; k < count; k++) {
    ck_assert_msg(failure_read(TEST_DATA "/failures", names[k], &f, why), "%s", why);
    if (f.d) continue;
    const dls_lcp lcp = {.n = f.n, .M = {f.n, f.n, f.n, f.M}, .q = f.q};
    pivot_both(&lcp, f.name);
    lcps++;
  }
  ck_assert_int_gt(lcps, 0);
}

/* Reads, reduces where there is a K, solves and recovers. */
TEST_EACH(every_file, 0, fclib_count) {
  const char *name = fclib_files[_i];
  dls_fclib *file = read_fclib_file(name);
  if (!file) return; /* a build without HDF5 */
  dls_contact p;
  if (!dls_fclib_is_global(file)) {
    ck_assert_int_eq(dls_fclib_contact(file, &p, NULL), DLS_OK);
    every_method(&p, 200, name);
    dls_fclib_destroy(file);
    return;
  }
  dls_model K;
  dls_reduction *reduction = NULL;
  const double *f = NULL, *g = NULL, *mu = NULL;
  ck_assert_int_eq(dls_fclib_model(file, &K, &f, &g, &mu, NULL), DLS_OK);
  double *x = calloc((size_t)K.n, sizeof *x), *r = calloc((size_t)K.n + capacity, sizeof *r);
  set_host();
  dls_status status = reduce_on_W(&reduction, &K, NULL, NULL);
  if (!status) status = dls_reduction_load(reduction, f, g, NULL);
  if (!status) status = dls_reduction_contact(reduction, mu, &p, NULL);
  if (!status) status = dls_reduction_recover(reduction, r, x, NULL);
  expect_host(name);
  if (!WITH_MUMPS && status == DLS_E_UNSUPPORTED) {
    dls_fclib_destroy(file);
    free(x);
    free(r);
    return;
  }
  ck_assert_int_eq(status, DLS_OK);
  every_method(&p, 60, name);
  dls_reduction_destroy(reduction);
  dls_fclib_destroy(file);
  free(x);
  free(r);
}

/* ---- callbacks and threads ------------------------------------------------------------------- */

static int host_calls,
    host_finds; /* calls of a callback; those that found the host's environment */

static int look_at_host(void *data, const dls_progress *progress) {
  (void)data;
  (void)progress;
  host_calls++;
  host_finds += is_host();
  return 0;
}

TEST(progress_finds_the_host) {
  model a;
  double r[most];
  slow_model(&a, 1);
  for (int method = 0; method < method_count(); method++) {
    dls_solver_settings s = settings_with((dls_method)method, default_tol);
    s.limits.progress = look_at_host;
    s.limits.max_iterations = 50;
    host_calls = host_finds = 0;
    set_host();
    const dls_status status = dls_solve(&a.p, &s, r, NULL, NULL, NULL);
    expect_host(dls_method_name(s.method));
    ck_assert_int_ge(status, 0);
    ck_assert_int_gt(host_calls, 0);
    ck_assert_msg(host_calls == host_finds, "%s: %d of %d calls find traps and rounding",
                  dls_method_name(s.method), host_finds, host_calls);
  }
}

static int plain_finds;

static int look_at_plain(void *data, const dls_progress *progress) {
  (void)data;
  (void)progress;
  host_calls++;
  plain_finds += traps_now() == 0 && fegetround() == FE_TONEAREST;
  return 0;
}

/* A host without traps finds its flags as they were, whatever a solve with traps did before. */
TEST(plain_host_keeps_its_flags) {
  int count = 0;
  host_calls = plain_finds = 0;
  const failure *all = contact_failures(&count);
  double r[FAILURE_N];
  for (int k = 0; k < count; k++)
    for (int method = 0; method < method_count(); method++) {
      const dls_contact p = failure_contact(&all[k]);
      dls_diagnosis about;
      dls_solver_settings s = settings_with((dls_method)method, default_tol);
      s.limits.max_iterations = 50;
      set_host();
      dls_status status = dls_solve(&p, &s, r, NULL, NULL, NULL);
      set_plain();
      s.limits.progress = look_at_plain;
      if (status >= 0) status = dls_solve(&p, &s, r, NULL, NULL, NULL);
      if (status >= 0) status = dls_contact_diagnose(&p, 100, &about, NULL);
      ck_assert_msg(fetestexcept(FE_ALL_EXCEPT) == 0, "%s, %s: flags", all[k].name,
                    dls_method_name(s.method));
    }
  ck_assert_int_gt(host_calls, 0);
  ck_assert_int_eq(plain_finds, host_calls);
}

/* K = 2 I; solves by the library, too, which goes through a door inside of a door. */
static int halve(void *user, double *X, int n, int nrhs) {
  (void)user;
  host_calls++;
  host_finds += is_host();
  double W = 1, q = -1, mu = 0, r = 0;
  const dls_contact p = {.d = 1, .nc = 1, .W = {1, 1, 1, &W}, .q = &q, .mu = &mu};
  const dls_status status = dls_solve(&p, NULL, &r, NULL, NULL, NULL);
  host_finds += status == DLS_OK && r == 1 && is_host();
  for (int i = 0; i < n * nrhs; i++)
    X[i] /= 2;
  return 0;
}

TEST(solver_finds_the_host) {
  static const int column[] = {0, 1}, normal[] = {0}, tangent[] = {1};
  static const double one[] = {1}, f[2] = {-1, 0};
  double x[2], r[2] = {1, 0};
  const dls_model m = {.d = 2,
                       .n = 2,
                       .nodes = 1,
                       .operator_kind = DLS_HOST_SOLVER,
                       .solve = halve,
                       .HN = {2, 1, column, normal, one},
                       .HT = {2, 1, column, tangent, one}};
  dls_reduction *R = NULL;
  host_calls = host_finds = 0;
  set_host();
  dls_status status = reduce_on_W(&R, &m, NULL, NULL);
  if (!status) status = dls_reduction_load(R, f, NULL, NULL);
  if (!status) status = dls_reduction_recover(R, r, x, NULL);
  expect_host("host solver");
  ck_assert_int_eq(status, DLS_OK);
  ck_assert_int_gt(host_calls, 0);
  ck_assert_int_eq(host_finds, 2 * host_calls);
  dls_reduction_destroy(R);
}

/* ---- the problem on K ------------------------------------------------------------------------ */

/* A strip that lifts off in parts, a stack that stands, one that slides off: proofs, too. */
static void solids_on_K(int kind, solids *S) {
  if (kind == 0) solids_pad(S, 30, 3);
  if (kind > 0) solids_stack(S, 2, 3, 2, kind == 1 ? 0.5 : 1.1);
}

/* Makes, updates and solves the problem on K. r: m + n, x behind r. Returns the status. */
static dls_status run_on_K(const solids *S, double mu_of_all, double *r) {
  const dls_model *on = &S->model;
  double *x = r + on->d * on->nodes, *mu = calloc((size_t)on->nodes, sizeof *mu);
  dls_limits limits = {.tol = 1e-8, .threads = 1, .progress = look_at_host};
  dls_global *G = NULL;
  dls_global_info info;
  for (int c = 0; c < on->nodes; c++)
    mu[c] = mu_of_all;
  dls_status status = dls_global_create(&G, on, NULL);
  if (!status) status = dls_global_get_info(G, &info, NULL);
  if (!status) status = dls_global_update(G, on, NULL);
  if (!status) status = dls_global_solve(G, S->f, S->g, mu, &limits, r, x, NULL, NULL);
  dls_global_destroy(G);
  free(mu);
  return status;
}

TEST_EACH(on_K, 0, 3) {
  solids S;
  solids_on_K(_i, &S);
  const size_t m = (size_t)(S.model.d * S.model.nodes), size = m + (size_t)S.model.n;
  double *plain = calloc(size, sizeof *plain), *trapped = calloc(size, sizeof *trapped);
  const dls_status one = run_on_K(&S, 0.3, plain);
  host_calls = host_finds = 0;
  set_host();
  const dls_status two = run_on_K(&S, 0.3, trapped);
  expect_host("on K");
  ck_assert_int_eq(one, _i == 2 ? DLS_NO_SOLUTION : DLS_OK);
  ck_assert_int_eq(one, two);
  ck_assert(!memcmp(plain, trapped, size * sizeof *plain));
  ck_assert_int_gt(host_calls, 0);
  ck_assert_int_eq(host_calls, host_finds);
  free(plain);
  free(trapped);
  solids_free(&S);
}

static dls_status prepare_unit(void *data, const double *R, dls_error *e) {
  (void)data;
  (void)e;
  host_calls++;
  host_finds += is_host() && R[0] > 0;
  return DLS_OK;
}

/* A = 1 + R in both directions of one node that rests on the ground. */
static dls_status solve_unit(void *data, const double *b, double *x, double accuracy,
                             dls_error *e) {
  const double *R = data;
  (void)accuracy;
  (void)e;
  host_calls++;
  host_finds += is_host();
  for (int i = 0; i < 2; i++)
    x[i] = b[i] / (1 + *R);
  return 1; /* cancels */
}

TEST(solver_on_K_finds_the_host) {
  static const int column[] = {0, 1}, normal[] = {0}, tangent[] = {1};
  static const double one[] = {1}, K[4] = {1, 0, 0, 1}, f[2] = {-1, 0};
  double x[2], r[2] = {0}, R = 1;
  const dls_model m = {.d = 2,
                       .n = 2,
                       .nodes = 1,
                       .operator_kind = DLS_STIFFNESS_DENSE,
                       .factorization = DLS_CHOLESKY,
                       .K = {2, 2, 2, K},
                       .HN = {2, 1, column, normal, one},
                       .HT = {2, 1, column, tangent, one}};
  const dls_global_solver solver = {.data = &R, .prepare = prepare_unit, .solve = solve_unit};
  dls_global *G = NULL;
  host_calls = host_finds = 0;
  set_host();
  dls_status status = dls_global_create_with(&G, &m, &solver, NULL);
  if (!status) status = dls_global_solve(G, f, NULL, NULL, NULL, r, x, NULL, NULL);
  expect_host("host's solver on K");
  ck_assert_int_eq(status, DLS_CANCELLED);
  ck_assert_int_eq(host_calls, 2);
  ck_assert_int_eq(host_calls, host_finds);
  dls_global_destroy(G);
}

/* Leaves traps and another rounding to whoever called. */
static void spoil(void) {
  (void)fesetround(rounding);
#ifdef __GLIBC__
  (void)feenableexcept(FE_INVALID | FE_DIVBYZERO | FE_OVERFLOW | FE_UNDERFLOW | FE_INEXACT);
#endif
}

static int spoil_progress(void *data, const dls_progress *progress) {
  (void)progress;
  host_calls++;
  if (*(int *)data) spoil();
  return 0;
}

/* K = 3 I by the host. */
static int spoil_solve(void *user, double *X, int n, int nrhs) {
  host_calls++;
  for (int i = 0; i < n * nrhs; i++)
    X[i] /= 3;
  if (*(int *)user) spoil();
  return 0;
}

static dls_status spoil_prepare(void *user, const double *R, dls_error *error) {
  (void)R, (void)error;
  host_calls++;
  if (*(int *)user) spoil();
  return DLS_OK;
}

/* A = 3 I + R, which the dense K and one node have; R is left out: the answer is not exact. */
static dls_status spoil_solve_on_K(void *user, const double *b, double *x, double accuracy,
                                   dls_error *error) {
  (void)accuracy, (void)error;
  host_calls++;
  for (int i = 0; i < 2; i++)
    x[i] = b[i] / 4;
  if (*(int *)user) spoil();
  return DLS_OK;
}

/* Runs every kind of callback. r: answers. */
static void run_spoiled(int spoils, double r[2][most]) {
  static const int column[] = {0, 1}, normal[] = {0}, tangent[] = {1};
  static const double one[] = {1}, K[4] = {3, 0, 0, 3}, f[2] = {-1, .3};
  dls_model m = {.d = 2,
                 .n = 2,
                 .nodes = 1,
                 .operator_kind = DLS_HOST_SOLVER,
                 .solve = spoil_solve,
                 .user = &spoils,
                 .HN = {2, 1, column, normal, one},
                 .HT = {2, 1, column, tangent, one}};
  const double mu = .2;
  dls_reduction *R = NULL;
  dls_global *G = NULL;
  dls_info info;
  dls_solver_settings s = settings_with(DLS_AUTO, default_tol);
  s.limits.progress = spoil_progress;
  s.limits.progress_data = &spoils;
  memset(r[0], 0, sizeof r[0]);
  memset(r[1], 0, sizeof r[1]);
  dls_status status = dls_reduction_create(&R, &m, NULL, NULL);
  if (!status) status = dls_reduction_load(R, f, NULL, NULL);
  if (!status) status = dls_reduction_solve(R, &mu, &s, r[0], r[0] + 2, r[0] + 4, &info, NULL);
  dls_reduction_destroy(R);
  m.operator_kind = DLS_STIFFNESS_DENSE;
  m.factorization = DLS_CHOLESKY;
  m.K = (dls_dense){2, 2, 2, K};
  const dls_global_solver solver = {
      .data = &spoils, .prepare = spoil_prepare, .solve = spoil_solve_on_K};
  s.limits.max_iterations = 20;
  if (!status) status = dls_global_create_with(&G, &m, &solver, NULL);
  if (!status) status = dls_global_solve(G, f, NULL, &mu, &s.limits, r[1], r[1] + 2, &info, NULL);
  dls_global_destroy(G);
  r[0][most - 1] = (double)status;
}

/* A callback that unmasks traps and rounds otherwise changes no bit, and ends nothing. */
TEST(callbacks_leave_what_they_like) {
  static double r[4][most];
  model a;
  numbered_model(&a, 7);
  host_calls = 0;
  for (int spoils = 0; spoils < 2; spoils++) {
    set_plain();
    run_spoiled(spoils, r + 2 * spoils);
    ck_assert_int_eq(traps_now(), 0);
    ck_assert_int_eq(fegetround(), FE_TONEAREST);
  }
  ck_assert_int_gt(host_calls, 10);
  ck_assert_mem_eq(r[0], r[2], 2 * sizeof r[0]);
  for (int method = 0; method < method_count(); method++) {
    for (int spoils = 0; spoils < 2; spoils++) {
      dls_solver_settings s = settings_with((dls_method)method, default_tol);
      s.limits.progress = spoil_progress;
      s.limits.progress_data = &spoils;
      set_plain();
      const dls_status status = dls_solve(&a.p, &s, r[spoils], r[2 + spoils], NULL, NULL);
      ck_assert_int_eq(traps_now(), 0);
      ck_assert_int_eq(fegetround(), FE_TONEAREST);
      ck_assert_int_ge(status, 0);
    }
    const size_t bytes = (size_t)a.p.d * (size_t)a.p.nc * sizeof(double);
    ck_assert_mem_eq(r[0], r[1], bytes);
    ck_assert_mem_eq(r[2], r[3], bytes);
  }
}

/* Tasks of helpers, whose threads begin while the host has its traps on. */
typedef struct helpers {
  pthread_t host;
  _Atomic int others, held; /* tasks in other threads than the host's; those without traps */
} helpers;

static void help(void *data, int k) {
  helpers *h = data;
  (void)k;
  if (pthread_equal(pthread_self(), h->host)) return;
  h->others++;
  h->held += traps_now() == 0 && fegetround() == FE_TONEAREST;
}

static void run_helpers(dlsi_team *team, void *data) {
  helpers *h = data;
  for (int turn = 0; turn < 100000 && h->others < 100; turn++)
    dlsi_parallel(team, 64, help, data);
}

TEST(helpers_hold_the_host) {
  helpers h = {.host = pthread_self()};
  set_host();
  dlsi_team_run(3, run_helpers, &h);
  expect_host("helpers");
  ck_assert_int_eq(h.held, h.others);
}

int main(void) {
  return run_tests("traps", NULL, set_plain);
}
