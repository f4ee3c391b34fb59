/*
 * test_body.c: dls_reduction_solve and dls_reduction_certify: "solved" means the body, not only W.
 */
#include <time.h>

#include "delassus.h"
#include "front/front.h"
#include "made.h"
#include "run.h"
#include "solids.h"

/* A bar of two nodes along the normal, one unit of stiffness, its foot a contact without tangents;
 * held by springs of stiffness `soft` at both nodes. */
typedef struct bar {
  double K[4], one[1];
  int p[2], none[2], row[1];
  dls_model model;
} bar;

static void make_bar(bar *b, double soft) {
  *b = (bar){.K = {1 + soft, -1, -1, 1 + soft}, .one = {1}, .p = {0, 1}};
  b->model = (dls_model){.d = 2,
                         .n = 2,
                         .nodes = 1,
                         .operator_kind = DLS_STIFFNESS_DENSE,
                         .factorization = DLS_CHOLESKY,
                         .K = {2, 2, 2, b->K},
                         .HN = {2, 1, b->p, b->row, b->one},
                         .HT = {2, 1, b->none, b->row, b->one}};
}

static dls_reduction *reduced(const dls_model *model, const double *f, const double *g) {
  dls_reduction *reduction;
  dls_error e;
  dls_status status = dls_reduction_create(&reduction, model, NULL, &e);
  if (!status) status = dls_reduction_load(reduction, f, g, &e);
  ck_assert_msg(status == DLS_OK, "%s", e.message);
  return reduction;
}

static const double none[1] = {0};

/* Statics: a free bar pressed by 10 stands with r_n = 10, on soft springs nearly so. */
TEST(bar_that_contact_holds) {
  static const double soft[] = {0, 1e-12, 1e-8, 1e-4, 1};
  for (int k = 0; k < 5; k++) {
    bar b;
    double r[2], u[2], x[2];
    dls_info info;
    const double f[2] = {0, -10}, s = soft[k];
    make_bar(&b, s);
    dls_reduction *reduction = reduced(&b.model, f, NULL);
    ck_assert_int_eq(dls_reduction_solve(reduction, none, NULL, r, u, x, &info, NULL), DLS_OK);
    /* x_0 = 0, x_1 = -10 / (1 + s), r_n = -x_1 */
    ck_assert_double_eq_tol(r[0], 10 / (1 + s), 1e-7);
    assert_near(x, (double[]){0, -10 / (1 + s)}, 2, 1e-7);
    ck_assert(u[0] == x[0] && r[1] == 0);
    dls_certificate c;
    ck_assert_int_eq(dls_reduction_certify(reduction, none, r, x, NULL, &c, NULL), DLS_OK);
    ck_assert(c.residual == info.certificate.residual && c.equilibrium <= 1e-8);
    ck_assert_int_eq(dls_certificate_verdict(&c, 1e-8), DLS_OK);
    dls_reduction_destroy(reduction);
  }
}

/* Pulled up, nothing holds the free bar: the motion (1, 1) proves it. A gap closes first. */
TEST(bar_that_nothing_holds) {
  bar b;
  double r[2] = {7, 7}, x[2] = {7, 7};
  int unknown = -1;
  const double up[2] = {0, 10}, down[2] = {0, -10}, g[2] = {5, 0};
  make_bar(&b, 0);
  dls_reduction *reduction = reduced(&b.model, up, NULL);
  ck_assert_ptr_null(dls_reduction_motion(reduction, &unknown));
  ck_assert_int_eq(dls_reduction_solve(reduction, none, NULL, r, NULL, x, NULL, NULL),
                   DLS_NO_SOLUTION);
  const double *b_of = dls_reduction_motion(reduction, &unknown);
  ck_assert_ptr_nonnull(b_of);
  ck_assert(b_of[0] == b_of[1] && b_of[1] > 0 && unknown == 0);
  ck_assert_int_eq(dls_reduction_load(reduction, down, g, NULL), DLS_OK);
  ck_assert_int_eq(dls_reduction_solve(reduction, none, NULL, r, NULL, x, NULL, NULL), DLS_OK);
  ck_assert_double_eq_tol(r[0], 10, 1e-7);
  ck_assert_double_eq_tol(x[0], -5, 1e-7);
  ck_assert_ptr_null(dls_reduction_motion(reduction, &unknown));
  dls_reduction_destroy(reduction);
}

/* Spends 0.15 s in each of the two solves. data: int[2], which of them have been told of. */
static int spend(void *data, const dls_progress *progress) {
  int *told = data, on_K = strcmp(progress->method, "global") == 0;
  const clock_t begun = clock();
  while (!told[on_K] && (double)(clock() - begun) < 0.15 * CLOCKS_PER_SEC)
    continue;
  told[on_K] = 1;
  return 0;
}

/* The limit of time is one for the solve on W and the one on K that follows: three blocks pushed
 * beyond friction, which springs hold too softly for W. */
TEST(time_is_kept_over_both_solves) {
  static const double seconds[2] = {100, 0.25};
  solids S;
  solids_stack(&S, 2, 3, 2, 1.05);
  for (int i = 0; i < 2 * S.nodes; i++)
    solids_spring(&S, i / 2, i % 2, 1e-11);
  const dls_model *model = solids_model(&S);
  double *r = calloc(2 * (size_t)S.contacts, sizeof *r), *x = calloc((size_t)model->n, sizeof *x);
  double *mu = calloc((size_t)S.contacts, sizeof *mu);
  ck_assert(r && x && mu);
  for (int c = 0; c < S.contacts; c++)
    mu[c] = 0.3;
  dls_reduction *reduction = reduced(model, S.f, S.g);
  for (int k = 0; k < 2; k++) {
    int told[2] = {0, 0};
    dls_solver_settings settings = settings_with(DLS_AUTO, default_tol);
    settings.limits.progress = spend;
    settings.limits.progress_data = told;
    settings.limits.cpu_seconds = seconds[k];
    const dls_status status = dls_reduction_solve(reduction, mu, &settings, r, NULL, x, NULL, NULL);
    ck_assert_int_eq(status == DLS_TIME_LIMIT, k);
    ck_assert(told[0] && told[1]);
  }
  dls_reduction_destroy(reduction);
  free(r);
  free(x);
  free(mu);
  solids_free(&S);
}

/* The certificate by hand: the point of examples/point.c, right, off in r, off in x. */
TEST(certificate_of_the_body) {
  const double K[] = {3, 1, 1, 2}, f[] = {5, -10}, mu[] = {0.2}, one[] = {1};
  const int p[] = {0, 1}, along[] = {0}, upward[] = {1};
  dls_model model = {.d = 2, .n = 2, .nodes = 1, .K = {2, 2, 2, K}};
  model.operator_kind = DLS_STIFFNESS_DENSE;
  model.factorization = DLS_CHOLESKY;
  model.HN = (dls_sparse){2, 1, p, upward, one};
  model.HT = (dls_sparse){2, 1, p, along, one};
  dls_reduction *reduction = reduced(&model, f, NULL);
  double r[2], x[2], u[2];
  dls_certificate c;
  ck_assert_int_eq(dls_reduction_solve(reduction, mu, NULL, r, u, x, NULL, NULL), DLS_OK);
  assert_near(r, (double[]){10.9375, -2.1875}, 2, 1e-13);
  ck_assert_double_eq_tol(x[0], 0.9375, 1e-13);
  x[0] += 0.01; /* K x changes by (.03, .01) beside |f| + |H r| */
  ck_assert_int_eq(dls_reduction_certify(reduction, mu, r, x, u, &c, NULL), DLS_OK);
  ck_assert_double_eq_tol(c.unbalanced, hypot(0.03, 0.01), 1e-12);
  ck_assert_double_eq_tol(c.equilibrium,
                          hypot(0.03, 0.01) / (hypot(5, 10) + hypot(10.9375, 2.1875)), 1e-12);
  ck_assert(c.body == 0 && u[1] == x[0]);
  ck_assert_int_eq(dls_certificate_verdict(&c, 1e-8), DLS_STALLED);
  x[0] -= 0.01;
  r[0] += 0.01; /* beside the cone, and out of balance */
  ck_assert_int_eq(dls_reduction_certify(reduction, mu, r, x, u, &c, NULL), DLS_OK);
  ck_assert_double_eq_tol(c.unbalanced, 0.01, 1e-12);
  ck_assert(c.residual_r > 1e-5 && c.residual_r < 1e-3);
  dls_reduction_destroy(reduction);
}

/* K^-1 given, or a solver of the host: equilibrium is not known, and x = K^-1 (f + H r) is
 * believed. */
TEST(without_K) {
  bar b;
  double r[2], x[2];
  const double C[4] = {2, 1, 1, 1}, f[2] = {0, -10};
  dls_info info;
  make_bar(&b, 0);
  b.model.operator_kind = DLS_FLEXIBILITY;
  b.model.K = (dls_dense){2, 2, 2, C};
  dls_reduction_settings settings;
  dls_reduction_settings_init(&settings);
  dls_reduction *reduction = reduction_of(&b.model, &settings);
  ck_assert_int_eq(dls_reduction_load(reduction, f, NULL, NULL), DLS_OK);
  ck_assert_int_eq(dls_reduction_solve(reduction, none, NULL, r, NULL, x, &info, NULL), DLS_OK);
  ck_assert_double_eq_tol(r[0], 5, 1e-12); /* 2 r_n = 10 */
  ck_assert(info.certificate.equilibrium == 0 && info.certificate.body == -1);
  dls_reduction_destroy(reduction);
}

/* Statics of many free blocks: on each plane the reactions carry what stands above, whatever the
 * number of rigid-body modes; pushed beyond friction, nothing holds them. */
TEST(stacks_of_free_blocks) {
  static const int count[2] = {12, 4};
  for (int k = 0; k < 4; k++) {
    const int d = 2 + k % 2, blocks = count[k % 2], side = 2, slides = k / 2;
    solids S;
    solids_stack(&S, d, blocks, side, slides ? 1.05 : 0.5);
    const dls_model *model = solids_model(&S);
    const int m = d * S.contacts, plane = S.contacts / blocks;
    double *r = calloc((size_t)m, sizeof *r), *x = calloc((size_t)model->n, sizeof *x);
    double *mu = calloc((size_t)S.contacts, sizeof *mu), weight = 0, sum = 0;
    for (int c = 0; c < S.contacts; c++)
      mu[c] = 0.3;
    for (int i = 0; i < model->n; i++)
      weight -= i % d == d - 1 ? S.f[i] : 0;
    dls_reduction *reduction = reduced(model, S.f, S.g);
    dls_info info;
    const dls_status status = dls_reduction_solve(reduction, mu, NULL, r, NULL, x, &info, NULL);
    ck_assert_int_eq(status, slides ? DLS_NO_SOLUTION : DLS_OK);
    for (int c = 0; c < plane; c++)
      sum += r[d * c];
    if (!slides) ck_assert_double_eq_tol(sum, weight, 1e-6 * weight);
    if (!slides) ck_assert(info.certificate.equilibrium <= 1e-8);
    dls_reduction_destroy(reduction);
    free(r);
    free(x);
    free(mu);
    solids_free(&S);
  }
}

static dls_on place_of(const dls_reduction *reduction) {
  dls_reduction_info info;
  ck_assert_int_eq(dls_reduction_get_info(reduction, &info, NULL), DLS_OK);
  return info.on;
}

/* Makes a reduction that chooses where it solves. */
static dls_reduction *either(const dls_model *model, dls_on on, double limit) {
  dls_reduction_settings settings;
  dls_reduction *reduction;
  dls_error e = {.message = "", .index = 7};
  dls_reduction_settings_init(&settings);
  settings.on = on;
  settings.memory_limit = limit;
  const dls_status status = dls_reduction_create(&reduction, model, &settings, &e);
  ck_assert_msg(status == DLS_OK, "%s", e.message);
  ck_assert_int_eq(e.index, 7); /* left alone */
  return reduction;
}

/* Few contacts on a thick body: W. All of a thin one's bottom: K. Both have the same answer. */
TEST(W_or_K) {
  for (int thin = 0; thin < 2; thin++) {
    solids S;
    solids_pad(&S, thin ? 600 : 20, thin ? 4 : 30);
    const dls_model *model = solids_model(&S);
    const size_t m = 2 * (size_t)S.contacts, n = (size_t)model->n;
    double *r[2], *x[2], *mu = calloc((size_t)S.contacts, sizeof *mu), top = 0;
    for (int c = 0; c < S.contacts; c++)
      mu[c] = 0.3;
    dls_reduction *chosen = either(model, DLS_ON_EITHER, 0);
    ck_assert_int_eq(place_of(chosen), thin ? DLS_ON_K : DLS_ON_W);
    dls_reduction_destroy(chosen);
    for (int k = 0; k < 2; k++) {
      dls_info info;
      dls_contact problem;
      dls_reduction *reduction = either(model, k ? DLS_ON_K : DLS_ON_W, 0);
      ck_assert_int_eq(place_of(reduction), k ? DLS_ON_K : DLS_ON_W);
      int better = -1; /* the same choice, of a reduction that is on K */
      if (k) ck_assert_int_eq(dlsi_body_foresee(reduction, &better, NULL), DLS_OK);
      if (k) ck_assert_int_eq(better, thin);
      r[k] = calloc(m, sizeof *r[k]);
      x[k] = calloc(n, sizeof *x[k]);
      dls_solver_settings tight = settings_with(DLS_AUTO, 1e-11);
      ck_assert_int_eq(dls_reduction_load(reduction, S.f, S.g, NULL), DLS_OK);
      ck_assert_int_eq(dls_reduction_solve(reduction, mu, &tight, r[k], NULL, x[k], &info, NULL),
                       DLS_OK);
      ck_assert_double_le(info.certificate.equilibrium, 1e-10);
      if (k) { /* what W alone has */
        double *other = calloc(n, sizeof *other);
        dls_error e;
        ck_assert_int_eq(dls_reduction_contact(reduction, mu, &problem, &e), DLS_E_UNSUPPORTED);
        REFUSES(UNSUPPORTED, "reduction", -1, dls_reduction_recover, reduction, r[k], other);
        tight.method = DLS_NLGS;
        REFUSES(UNSUPPORTED, "method", -1, dls_reduction_solve, reduction, mu, &tight, r[k], NULL,
                x[k], NULL);
        free(other);
      }
      dls_reduction_destroy(reduction);
    }
    for (size_t i = 0; i < m; i++)
      top = fmax(top, fabs(r[0][i]));
    for (size_t i = 0; i < m; i++)
      ck_assert_double_eq_tol(r[0][i], r[1][i], 1e-6 * top);
    for (int k = 0; k < 2; k++) {
      free(r[k]);
      free(x[k]);
    }
    free(mu);
    solids_free(&S);
  }
}

/* A singular K and a W that does not fit are taken on K, what has no K on W; a limit that neither
 * meets is an error. */
TEST(the_only_place) {
  bar b;
  solids S;
  dls_reduction_settings settings;
  dls_reduction *reduction;
  make_bar(&b, 0);
  reduction = either(&b.model, DLS_ON_EITHER, 0);
  ck_assert_int_eq(place_of(reduction), DLS_ON_K);
  dls_reduction_destroy(reduction);
  make_bar(&b, 1);
  reduction = either(&b.model, DLS_ON_EITHER, 0);
  ck_assert_int_eq(place_of(reduction), DLS_ON_W);
  dls_reduction_destroy(reduction);
  const double C[4] = {2, 1, 1, 1};
  b.model.operator_kind = DLS_FLEXIBILITY;
  b.model.K = (dls_dense){2, 2, 2, C};
  reduction = either(&b.model, DLS_ON_EITHER, 0);
  ck_assert_int_eq(place_of(reduction), DLS_ON_W);
  dls_reduction_destroy(reduction);
  dls_reduction_settings_init(&settings);
  settings.on = DLS_ON_K;
  REFUSES(UNSUPPORTED, "on", -1, dls_reduction_create, &reduction, &b.model, &settings);
  ck_assert_ptr_null(reduction);
  solids_pad(&S, 60, 30);
  const dls_model *model = solids_model(&S);
  dls_reduction_info info;
  ck_assert_int_eq(dls_reduction_estimate(model, NULL, &info, NULL), DLS_OK);
  reduction = either(model, DLS_ON_EITHER, info.bytes);
  ck_assert_int_eq(place_of(reduction), DLS_ON_W);
  dls_reduction_destroy(reduction);
  solids T;
  solids_pad(&T, 120, 2);
  model = solids_model(&T);
  dls_global_info on_K;
  ck_assert_int_eq(dls_reduction_estimate(model, NULL, &info, NULL), DLS_OK);
  ck_assert_int_eq(dls_global_estimate(model, &on_K, NULL), DLS_OK);
  ck_assert_double_lt(on_K.bytes, info.bytes);
  reduction = either(model, DLS_ON_EITHER, (on_K.bytes + info.bytes) / 2);
  ck_assert_int_eq(place_of(reduction), DLS_ON_K);
  dls_reduction_destroy(reduction);
  settings.on = DLS_ON_EITHER;
  settings.memory_limit = on_K.bytes / 2;
  REFUSES(MEMORY, "memory_limit", -1, dls_reduction_create, &reduction, model, &settings);
  ck_assert_ptr_null(reduction);
  settings.memory_limit = 0;
  settings.loads = 0;
  REFUSES(ARGUMENT, "loads", -1, dls_reduction_create, &reduction, model, &settings);
  solids_free(&S);
  solids_free(&T);
}

/* Updates keep what they can: new values, then another pattern; a free position for a load. */
TEST(updates_on_K) {
  bar b;
  double r[2], x[2], u[2];
  dls_contact_state state[1];
  const double f[2] = {0, -10};
  make_bar(&b, 1);
  dls_reduction *reduction = either(&b.model, DLS_ON_K, 0);
  for (int k = 0; k < 3; k++) {
    static const double soft[] = {1, 3, 0};
    const double s = soft[k];
    make_bar(&b, s);
    ck_assert_int_eq(dls_reduction_update(reduction, &b.model, NULL), DLS_OK);
    ck_assert_int_eq(dls_reduction_solve(reduction, none, NULL, r, NULL, x, NULL, NULL), DLS_OK);
    ck_assert(r[0] == 0 && x[1] == 0); /* no load yet */
    ck_assert_int_eq(dls_reduction_load(reduction, f, NULL, NULL), DLS_OK);
    ck_assert_int_eq(dls_reduction_solve(reduction, none, NULL, r, u, x, NULL, NULL), DLS_OK);
    ck_assert_double_eq_tol(r[0], 10 / (1 + s), 1e-7);
    ck_assert_double_eq_tol(x[1], -10 / (1 + s), 1e-7);
    ck_assert_int_eq(dls_reduction_states(reduction, none, r, u, state, NULL), DLS_OK);
    ck_assert_int_eq(state[0], DLS_STICK);
  }
  const double free_x[2] = {-10, -20}; /* K x = (10, -10): r_n = 0 at x_1 = -10 */
  ck_assert_int_eq(dls_reduction_load_free(reduction, free_x, NULL, NULL), DLS_OK);
  ck_assert_int_eq(dls_reduction_solve(reduction, none, NULL, r, NULL, x, NULL, NULL), DLS_OK);
  ck_assert_double_eq_tol(x[0] - x[1], 10, 1e-7);
  dls_reduction_destroy(reduction);
}

TEST(bad_input) {
  bar b;
  double r[2] = {7, 7}, x[2] = {7, 7};
  const double f[2] = {0, -10}, bad[2] = {0, NAN};
  dls_certificate c;
  make_bar(&b, 0);
  dls_reduction *reduction = reduced(&b.model, f, NULL);
  REFUSES(ARGUMENT, "reduction", -1, dls_reduction_solve, NULL, none, NULL, r, NULL, x, NULL);
  REFUSES(ARGUMENT, "r", -1, dls_reduction_solve, reduction, none, NULL, NULL, NULL, x, NULL);
  REFUSES(ARGUMENT, "x", -1, dls_reduction_solve, reduction, none, NULL, r, NULL, NULL, NULL);
  REFUSES(NOT_FINITE, "r", 1, dls_reduction_certify, reduction, none, bad, x, NULL, &c);
  REFUSES(NOT_FINITE, "x", 1, dls_reduction_certify, reduction, none, r, bad, NULL, &c);
  REFUSES(ARGUMENT, "certificate", -1, dls_reduction_certify, reduction, none, r, x, NULL, NULL);
  ck_assert(r[0] == 7 && x[1] == 7);
  dls_reduction_destroy(reduction);
}

/* ---- one call -------------------------------------------------------------------------------- */

/* The point of README.md: K = (3 1; 1 2) on a floor, friction .2. `of` owns the arrays. */
static dls_model point_of(bar *of) {
  static const int p[] = {0, 1}, along[] = {0}, up[] = {1};
  make_bar(of, 0);
  memcpy(of->K, (double[]){3, 1, 1, 2}, sizeof of->K);
  dls_model model = of->model;
  model.HN = (dls_sparse){2, 1, p, up, of->one};
  model.HT = (dls_sparse){2, 1, p, along, of->one};
  return model;
}

/* A held body, a free one pressed down, one that flies away: the statuses, and what they set. */
TEST(one_call) {
  bar b;
  dls_info info;
  double r[2] = {NAN, NAN}, u[2] = {NAN, NAN}, x[2] = {NAN, NAN};
  const double f[] = {5, -10}, mu[] = {0.2}, down[] = {0, -10}, up[] = {0, 10}, g[] = {1, 0};
  const dls_model held = point_of(&b);
  ck_assert_int_eq(dls_solve_model(&held, f, NULL, mu, r, u, x, &info, NULL), DLS_OK);
  const double expected[] = {10.9375, -2.1875, 0, 0.9375, 0.9375, 0};
  for (int k = 0; k < 2; k++) {
    ck_assert_double_eq_tol(r[k], expected[k], 1e-7);
    ck_assert_double_eq_tol(u[k], expected[2 + k], 1e-7);
    ck_assert_double_eq_tol(x[k], expected[4 + k], 1e-7);
  }
  ck_assert(info.certificate.residual <= 1e-8 && info.certificate.equilibrium <= 1e-8);
  make_bar(&b, 0);
  b.model.mu = none; /* NULL stands for it */
  ck_assert_int_eq(dls_solve_model(&b.model, down, g, NULL, r, NULL, x, &info, NULL), DLS_OK);
  ck_assert_double_eq_tol(r[0], 10, 1e-7);
  assert_near(x, (double[]){-1, -11}, 2, 1e-7);
  r[0] = r[1] = x[0] = x[1] = NAN;
  const dls_status flies = dls_solve_model(&b.model, up, NULL, none, r, u, x, &info, NULL);
  ck_assert(flies == DLS_NO_SOLUTION && info.status == flies && !dls_solved(flies));
  ck_assert(isfinite(r[0]) && isfinite(r[1]) && isfinite(x[0]) && isfinite(x[1]));
}

/* Every solver leaves x behind an answer that is not within the tolerance: here the tolerance is
 * beyond rounding, and the time is over at once. */
TEST(x_is_set) {
  bar b;
  dls_solver_settings s;
  double r[2] = {NAN, NAN}, x[2] = {NAN, NAN};
  const double f[] = {5, -10}, mu[] = {0.2};
  const dls_model held = point_of(&b);
  for (int k = 0; k < 2; k++)
    for (int on = DLS_ON_W; on <= DLS_ON_K; on++) {
      dls_reduction *reduction = either(&held, (dls_on)on, 0);
      dls_solver_settings_init(&s);
      s.limits.tol = k ? 1e-8 : 1e-300;
      if (k) s.limits.cpu_seconds = 1e-300;
      ck_assert_int_eq(dls_reduction_load(reduction, f, NULL, NULL), DLS_OK);
      const dls_status status = dls_reduction_solve(reduction, mu, &s, r, NULL, x, NULL, NULL);
      ck_assert_int_ge(status, 0);
      ck_assert(isfinite(r[0]) && isfinite(r[1]) && isfinite(x[0]) && isfinite(x[1]));
      if (dls_solved(status)) ck_assert_double_eq_tol(x[0], 0.9375, 1e-7);
      dls_reduction_destroy(reduction);
    }
}

/* Answers that are certified. */
TEST(solved) {
  for (int status = -20; status < 20; status++)
    ck_assert(dls_solved((dls_status)status) == (status == DLS_OK || status == DLS_TO_ROUNDING));
}

/* The errors name this function and its argument, and leave the outputs. */
TEST(one_call_refuses) {
  bar b;
  double r[2] = {7, 7}, x[2] = {7, 7};
  const double f[] = {5, -10}, mu[] = {0.2}, bad[] = {0, NAN}, below[] = {-1};
  const dls_model held = point_of(&b);
  dls_model wrong = held;
  wrong.d = 4;
  REFUSES(ARGUMENT, "model", -1, dls_solve_model, NULL, f, NULL, mu, r, NULL, x, NULL);
  REFUSES(ARGUMENT, "d", -1, dls_solve_model, &wrong, f, NULL, mu, r, NULL, x, NULL);
  REFUSES(NOT_FINITE, "f", 1, dls_solve_model, &held, bad, NULL, mu, r, NULL, x, NULL);
  REFUSES(NOT_FINITE, "g", 1, dls_solve_model, &held, f, bad, mu, r, NULL, x, NULL);
  REFUSES(ARGUMENT, "mu", -1, dls_solve_model, &held, f, NULL, NULL, r, NULL, x, NULL);
  REFUSES(ARGUMENT, "mu", 0, dls_solve_model, &held, f, NULL, below, r, NULL, x, NULL);
  REFUSES(ARGUMENT, "r", -1, dls_solve_model, &held, f, NULL, mu, NULL, NULL, x, NULL);
  REFUSES(ARGUMENT, "x", -1, dls_solve_model, &held, f, NULL, mu, r, NULL, NULL, NULL);
  ck_assert(r[0] == 7 && r[1] == 7 && x[0] == 7 && x[1] == 7);
}

/* Each malloc of one call fails in turn, of a held body and of a free one. */
TEST_EACH(one_call_without_memory, 0, 2) {
  bar b;
  const double f[] = {0, -10}, mu[] = {0};
  dls_model model = point_of(&b);
  if (_i) {
    make_bar(&b, 0);
    model = b.model;
  }
  double r[2] = {7, 7}, x[2] = {7, 7};
  MALLOCS_FAIL(dls_solve_model(&model, f, NULL, mu, r, NULL, x, NULL, NULL), r[0] == 7 && x[0] == 7,
               DLS_OK, 19);
}

/* A free body leaves a pivot of rounding size: an elastic block, in two units, lies on the ground
 * and is pressed. W is refused, on K it stands. An indefinite K is not taken for a free one. */
TEST_EACH(free_strip, 0, 2) {
  for (int unit = 0; unit < 2; unit++) {
    solids S;
    solids_stack(&S, 2, 1, _i ? 24 : 6, 0);
    if (unit)
      for (int k = 0; k < S.K.count; k++)
        S.K.x[k] *= 1e9;
    const dls_model *model = solids_model(&S);
    const size_t m = 2 * (size_t)S.contacts, n = (size_t)model->n;
    double *r = calloc(m, sizeof *r), *x = calloc(n, sizeof *x), weight = 0, up = 0;
    double *mu = calloc((size_t)S.contacts, sizeof *mu);
    dls_reduction_settings s;
    dls_reduction *reduction;
    dls_reduction_settings_init(&s);
    s.on = DLS_ON_W;
    for (s.allow_indefinite = 0; s.allow_indefinite < 2; s.allow_indefinite++)
      ck_assert_int_eq(dls_reduction_create(&reduction, model, &s, NULL), DLS_E_SINGULAR);
    ck_assert(dls_solved(dls_solve_model(model, S.f, S.g, mu, r, NULL, x, NULL, NULL)));
    for (size_t i = 1; i < n; i += 2)
      weight -= S.f[i];
    for (size_t i = 0; i < m; i += 2)
      up += r[i];
    ck_assert_double_eq_tol(up, weight, 1e-7 * weight);
    for (int k = 0; k < S.K.count; k++) /* softening at a corner */
      if (S.K.row[k] == 0 && S.K.col[k] == 0) S.K.x[k] *= 0.5;
    model = solids_model(&S);
    s.allow_indefinite = 0;
    ck_assert_int_eq(dls_reduction_create(&reduction, model, &s, NULL),
                     DLS_E_NOT_POSITIVE_DEFINITE);
    s.on = DLS_ON_EITHER;
    s.loads = 1000;
    if (2 * S.contacts <= 100)
      ck_assert_int_eq(dls_reduction_create(&reduction, model, &s, NULL),
                       DLS_E_NOT_POSITIVE_DEFINITE);
    free(r);
    free(x);
    free(mu);
    solids_free(&S);
  }
}

TEST(failing_mallocs) {
  bar b;
  const double f[2] = {0, -10};
  long k = 1;
  for (dls_status status = DLS_E_MEMORY; status == DLS_E_MEMORY; k++) {
    double r[2] = {7, 7}, x[2] = {7, 7};
    make_bar(&b, 0);
    dls_reduction *reduction = reduced(&b.model, f, NULL);
    malloc_fails_at(k);
    status = dls_reduction_solve(reduction, none, NULL, r, NULL, x, NULL, NULL);
    malloc_fails_at(0);
    if (status == DLS_E_MEMORY)
      ck_assert(r[0] == 7 && x[0] == 7);
    else
      ck_assert_double_eq_tol(r[0], 10, 1e-7);
    dls_reduction_destroy(reduction);
  }
  ck_assert_int_gt(k, 5);
}
