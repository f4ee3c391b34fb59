/*
 * test_busy.c: objects outside of the table of methods, used again from inside of their own
 * callback: LCP solvers, the primal solver, reductions with a host's solver, motions. Every call
 * that would change the object returns DLS_E_BUSY, the first call ends as if nothing had happened,
 * and the object is free again. The methods of the table: test_contract.c.
 */
#include "delassus.h"
#include "reduced.h"
#include "run.h"

enum { most = 8 };

/* The calls that a callback makes, each with sound arguments. */
typedef dls_status own_call(void *object, dls_error *error);
typedef struct own_calls {
  void *object; /* NULL until create has returned */
  const char *argument;
  own_call *const *call; /* NULL: ends the list */
  int visits;
} own_calls;

static void call_all(own_calls *own) {
  own->visits++;
  for (int k = 0; own->object && own->call[k]; k++) {
    dls_error error;
    ck_assert_int_eq(own->call[k](own->object, &error), DLS_E_BUSY);
    ck_assert_str_eq(error.argument, own->argument);
    ck_assert_str_eq(dls_status_name(error.status), "DLS_E_BUSY");
  }
}

static int call_all_from_progress(void *data, const dls_progress *progress) {
  (void)progress;
  call_all(data);
  return 0;
}

/* ---- linear complementarity ------------------------------------------------------------------ */

/* Murty's matrix: the most pivots. Solution z = (1, 0, .., 0). */
static dls_lcp murty_lcp(void) {
  static double M[most * most], q[most];
  for (int j = 0; j < most; j++) {
    q[j] = -1;
    for (int i = 0; i < most; i++)
      M[i + most * j] = i == j ? 1 : i > j ? 2 : 0;
  }
  return (dls_lcp){.n = most, .M = {most, most, most, M}, .q = q};
}

/* The test of an LCP solver, with at least so many calls of the progress callback. */
#define LCP_SOLVER(name, least)                                                                    \
  static dls_status name##_again(void *object, dls_error *error) {                                 \
    const dls_lcp lcp = murty_lcp();                                                               \
    double z[most] = {7};                                                                          \
    const dls_status status = dls_##name##_solve(object, &lcp, z, NULL, NULL, error);              \
    ck_assert(z[0] == 7);                                                                          \
    return status;                                                                                 \
  }                                                                                                \
  TEST(name) {                                                                                     \
    static own_call *const calls[] = {name##_again, NULL};                                         \
    own_calls own = {NULL, "workspace", calls, 0};                                                 \
    const dls_lcp lcp = murty_lcp();                                                               \
    dls_##name##_settings settings;                                                                \
    dls_##name##_settings_init(&settings);                                                         \
    settings.limits.progress = call_all_from_progress;                                             \
    settings.limits.progress_data = &own;                                                          \
    dls_##name *work;                                                                              \
    double z[2][most];                                                                             \
    ck_assert_int_eq(dls_##name##_create(&work, most, &settings, NULL), DLS_OK);                   \
    for (int k = 0; k < 2; k++) {                                                                  \
      own.object = k ? work : NULL;                                                                \
      ck_assert_int_eq(dls_##name##_solve(work, &lcp, z[k], NULL, NULL, NULL), DLS_OK);            \
    }                                                                                              \
    ck_assert_int_ge(own.visits, least);                                                           \
    ck_assert_mem_eq(z[0], z[1], sizeof z[0]);                                                     \
    ck_assert(z[0][0] == 1 && z[0][most - 1] == 0);                                                \
    dls_##name##_destroy(work);                                                                    \
  }
LCP_SOLVER(lemke, 2)
LCP_SOLVER(principal, 3)

/* ---- a point on springs above an obstacle -------------------------------------------------- */

static const double point_K[4] = {2, 0, 0, 2}, point_f[2] = {1, -4}, point_mu[1] = {0.25};
static const int point_p[3] = {0, 1, 2}, point_i[2] = {0, 1};
static const int normal_p[2] = {0, 1}, normal_i[1] = {1}, tangent_i[1] = {0};
static const double point_one[2] = {1, 1}, point_two[2] = {2, 2};

static dls_model point_model(void) {
  return (dls_model){.d = 2,
                     .n = 2,
                     .nodes = 1,
                     .operator_kind = DLS_STIFFNESS_DENSE,
                     .factorization = DLS_CHOLESKY,
                     .K = {2, 2, 2, point_K},
                     .Ks = {2, 2, point_p, point_i, point_two},
                     .HN = {2, 1, normal_p, normal_i, point_one},
                     .HT = {2, 1, normal_p, tangent_i, point_one}};
}

static dls_status primal_again(void *object, dls_error *error) {
  double x[2] = {7}, r[2] = {7};
  const dls_status status =
      dls_primal_solve(object, point_f, NULL, point_mu, x, r, NULL, NULL, error);
  ck_assert(x[0] == 7 && r[0] == 7);
  return status;
}

TEST(primal) {
  static own_call *const calls[] = {primal_again, NULL};
  own_calls own = {NULL, "workspace", calls, 0};
  dls_model model = point_model();
  dls_primal_settings settings;
  dls_primal_settings_init(&settings);
  settings.limits.progress = call_all_from_progress;
  settings.limits.progress_data = &own;
  dls_primal *work;
  double x[2] = {0}, r[2][2];
  ck_assert_int_eq(dls_primal_create(&work, &model, &settings, NULL), DLS_OK);
  for (int k = 0; k < 2; k++) {
    own.object = k ? work : NULL;
    ck_assert_int_eq(dls_primal_solve(work, point_f, NULL, point_mu, x, r[k], NULL, NULL, NULL),
                     DLS_OK);
  }
  ck_assert_int_ge(own.visits, 2);
  ck_assert_mem_eq(r[0], r[1], sizeof r[0]);
  ck_assert_double_eq_tol(r[0][0], 4, 1e-8);
  dls_primal_destroy(work);
}

/* ---- a reduction whose host solves ---------------------------------------------------------- */

static int point_solve(void *user, double *X, int n, int nrhs) {
  for (int k = 0; k < n * nrhs; k++)
    X[k] /= 2;
  call_all(user);
  return 0;
}

static dls_status load_again(void *object, dls_error *error) {
  return dls_reduction_load(object, point_f, NULL, error);
}
static dls_status load_free_again(void *object, dls_error *error) {
  return dls_reduction_load_free(object, point_f, NULL, error);
}
static dls_status recover_again(void *object, dls_error *error) {
  double x[2] = {7}, r[2] = {0};
  const dls_status status = dls_reduction_recover(object, r, x, error);
  ck_assert(x[0] == 7);
  return status;
}
static dls_status update_again(void *object, dls_error *error) {
  const dls_model model = point_model();
  return dls_reduction_update(object, &model, error);
}

TEST(reduction) {
  static own_call *const calls[] = {load_again, load_free_again, recover_again, update_again, NULL};
  own_calls own = {NULL, "reduction", calls, 0};
  dls_model model = point_model();
  model.operator_kind = DLS_HOST_SOLVER;
  model.solve = point_solve;
  model.user = &own;
  dls_reduction *work;
  ck_assert_int_eq(reduce_on_W(&work, &model, NULL, NULL), DLS_OK);
  own.object = work;
  const int before = own.visits;
  dls_contact problem;
  double x[2], r[2] = {4, 0};
  ck_assert_int_eq(dls_reduction_update(work, &model, NULL), DLS_OK);
  ck_assert_int_eq(dls_reduction_load(work, point_f, NULL, NULL), DLS_OK);
  ck_assert_int_eq(dls_reduction_recover(work, r, x, NULL), DLS_OK);
  ck_assert_int_ge(own.visits, before + 2);
  ck_assert(x[0] == 0.5 && x[1] == 0);
  ck_assert_int_eq(dls_reduction_contact(work, point_mu, &problem, NULL), DLS_OK);
  ck_assert(problem.q[0] == -2 && problem.q[1] == 0.5 && problem.W.a[0] == 0.5);
  const double infinite[2] = {1, INFINITY}; /* an error leaves the object free, too */
  ck_assert_int_eq(dls_reduction_load(work, infinite, NULL, NULL), DLS_E_NOT_FINITE);
  ck_assert_int_eq(dls_reduction_load(work, point_f, NULL, NULL), DLS_OK);
  dls_reduction_destroy(work);
}

/* ---- a motion -------------------------------------------------------------------------------- */

static dls_status step_again(void *object, dls_error *error) {
  return dls_motion_step(object, point_f, NULL, point_mu, NULL, error);
}
static dls_status start_again(void *object, dls_error *error) {
  return dls_motion_start(object, NULL, NULL, 0, error);
}
static dls_status set_h_again(void *object, dls_error *error) {
  return dls_motion_set_h(object, 1, error);
}
static dls_status set_limits_again(void *object, dls_error *error) {
  const dls_limits limits = {.tol = 1e-3};
  return dls_motion_set_limits(object, &limits, error);
}

/* The state may be read at any time: it is that of the step before. */
static dls_status state_again(void *object, dls_error *error) {
  dls_motion_state state;
  ck_assert_int_eq(dls_motion_get_state(object, &state, error), DLS_OK);
  ck_assert_int_eq(state.steps, 0);
  return step_again(object, error);
}

TEST(motion) {
  static own_call *const calls[] = {step_again,       start_again, set_h_again,
                                    set_limits_again, state_again, NULL};
  own_calls own = {NULL, "motion", calls, 0};
  const dls_model point = point_model();
  dls_motion_model model = {.d = 2,
                            .n = 2,
                            .nodes = 1,
                            .factorization = DLS_CHOLESKY,
                            .M = point.Ks,
                            .K = point.Ks,
                            .HN = point.HN,
                            .HT = point.HT};
  dls_motion_settings settings;
  dls_motion_settings_init(&settings);
  settings.h = 0.5;
  settings.limits.progress = call_all_from_progress;
  settings.limits.progress_data = &own;
  double p[2][2];
  for (int k = 0; k < 2; k++) {
    dls_motion *work;
    dls_motion_state state;
    ck_assert_int_eq(dls_motion_create(&work, &model, &settings, NULL), DLS_OK);
    own.object = k ? work : NULL;
    ck_assert_int_eq(dls_motion_step(work, point_f, NULL, point_mu, NULL, NULL), DLS_OK);
    ck_assert_int_eq(dls_motion_get_state(work, &state, NULL), DLS_OK);
    memcpy(p[k], state.p, sizeof p[k]);
    own.object = NULL;
    const double infinite[2] = {1, INFINITY};
    ck_assert_int_eq(dls_motion_step(work, infinite, NULL, NULL, NULL, NULL), DLS_E_NOT_FINITE);
    ck_assert_int_eq(dls_motion_step(work, point_f, NULL, point_mu, NULL, NULL), DLS_OK);
    dls_motion_destroy(work);
  }
  ck_assert_int_ge(own.visits, 4);
  ck_assert(p[0][0] > 0);
  ck_assert_mem_eq(p[0], p[1], sizeof p[0]);
}
