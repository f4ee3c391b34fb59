/* test_solver.c: the contact problem on K with the host's solver for K + H R H^T. */
#include "delassus/global.h"
#include "global/global_internal.h"
#include "run.h"
#include "solids.h"

/* A host that applies A and solves by conjugate gradients. */
typedef struct host {
  const dls_model *model;
  double *R, *left, *p, *v;
  int prepared, solved, steps;
  int wrong;    /* arguments that should not be; ck_assert would allocate */
  double worst; /* the largest residual of a first guess, over |b| */
  dls_status answer_prepare, answer_solve;
  double *B; /* 3 m: of Newton's preconditioner, some steps of conjugate gradients on K + H B H^T */
  int blocks, cycles, most;
  double garbage; /* answered in place of them if not 0 */
  dls_status answer_apply;
} host;

static host host_of(const dls_model *model) {
  host h = {.model = model};
  const size_t n = (size_t)model->n, m = (size_t)(model->d * model->nodes);
  h.R = calloc(4 * m + 3 * n, sizeof *h.R);
  ck_assert_ptr_nonnull(h.R);
  h.B = h.R + m;
  h.left = h.R + 4 * m;
  h.p = h.left + n;
  h.v = h.p + n;
  return h;
}

static dls_status prepare(void *data, const double *R, dls_error *error) {
  host *h = data;
  h->wrong += !error;
  for (int k = 0; k < h->model->d * h->model->nodes; k++) {
    h->wrong += !(R[k] > 0 && R[k] <= DBL_MAX);
    h->R[k] = R[k];
  }
  h->prepared++;
  return h->answer_prepare;
}

static double product(const double *a, const double *b, int n) {
  double sum = 0;
  for (int k = 0; k < n; k++)
    sum += a[k] * b[k];
  return sum;
}

static dls_status gradients(void *data, const double *b, double *x, double accuracy,
                            dls_error *error) {
  host *h = data;
  const int n = h->model->n;
  h->wrong += !error;
  h->solved++;
  if (h->answer_solve) return h->answer_solve;
  solids_apply(h->model, h->R, x, h->v);
  for (int k = 0; k < n; k++)
    h->p[k] = h->left[k] = b[k] - h->v[k];
  const double load = sqrt(product(b, b, n));
  double size = product(h->left, h->left, n);
  if (h->solved > 20) h->worst = fmax(h->worst, sqrt(size) / load);
  for (int step = 0; step < 50 * n && sqrt(size) > accuracy * load; step++) {
    solids_apply(h->model, h->R, h->p, h->v);
    const double a = size / product(h->p, h->v, n), before = size;
    for (int k = 0; k < n; k++) {
      x[k] += a * h->p[k];
      h->left[k] -= a * h->v[k];
    }
    size = product(h->left, h->left, n);
    for (int k = 0; k < n; k++)
      h->p[k] = h->left[k] + size / before * h->p[k];
    h->steps++;
  }
  return DLS_OK;
}

static dls_status block(void *data, const double *B, dls_error *error) {
  host *h = data;
  const int d = h->model->d;
  h->wrong += !error;
  memcpy(h->B, B, (size_t)(d * d * h->model->nodes) * sizeof *B);
  for (int c = 0; c < h->model->nodes; c++, B += d * d)
    for (int k = 0; k < d * d; k++)
      h->wrong +=
          !(fabs(B[k] - B[k / d + d * (k % d)]) <= 1e-15 * fabs(B[k]) && B[k / d * (d + 1)] >= 0);
  h->blocks++;
  return DLS_OK;
}

/* y := (K + H B H^T) x */
static void host_apply(host *h, const double *x, double *y) {
  const dls_model *model = h->model;
  const int d = model->d;
  static const double none[1200];
  h->wrong += d * model->nodes > 1200;
  solids_apply(model, none, x, y);
  for (int c = 0; c < model->nodes; c++) {
    double u[3] = {0};
    for (int turn = 0; turn < 2; turn++)
      for (int i = 0; i < d; i++) {
        const dls_sparse *L = i ? &model->HT : &model->HN;
        const int column = i ? (d - 1) * c + i - 1 : c;
        double push = 0;
        for (int k = 0; k < d; k++)
          push += h->B[d * d * c + i + d * k] * u[k];
        for (int e = L->p[column]; turn && e < L->p[column + 1]; e++)
          y[L->i[e]] += L->x[e] * push;
        for (int e = L->p[column]; !turn && e < L->p[column + 1]; e++)
          u[i] += L->x[e] * x[L->i[e]];
      }
  }
}

static dls_status cycle(void *data, const double *b, double *x, double accuracy, dls_error *error) {
  host *h = data;
  const int n = h->model->n;
  h->wrong += !error || accuracy != 0.1;
  h->cycles++;
  for (int k = 0; k < n; k++) {
    h->wrong += x[k] != 0;
    h->p[k] = h->left[k] = b[k];
    x[k] = h->garbage;
  }
  if (h->answer_apply || h->garbage != 0) return h->answer_apply;
  double size = product(b, b, n);
  const double load = size;
  for (int step = 0; step < h->most && size > 1e-20 * load; step++) {
    host_apply(h, h->p, h->v);
    const double a = size / product(h->p, h->v, n), before = size;
    for (int k = 0; k < n; k++) {
      x[k] += a * h->p[k];
      h->left[k] -= a * h->v[k];
    }
    size = product(h->left, h->left, n);
    for (int k = 0; k < n; k++)
      h->p[k] = h->left[k] + size / before * h->p[k];
  }
  return DLS_OK;
}

static double apart(const double *a, const double *b, int n) {
  double most = 0, scale = 0;
  for (int k = 0; k < n; k++) {
    most = fmax(most, fabs(a[k] - b[k]));
    scale = fmax(scale, fabs(b[k]));
  }
  return most / scale;
}

/* Both answers of a scene: by the factor, by the host. */
static void expect_equal(solids *S, double friction) {
  const dls_model *model = &S->model;
  const int n = model->n, nc = model->nodes, m = model->d * nc;
  double *r = calloc((size_t)(2 * m + nc), sizeof *r), *s = r + m, *mu = s + m;
  double *x = calloc((size_t)(2 * n), sizeof *x), *y = x + n;
  host h = host_of(model);
  const dls_global_solver solver = {.data = &h, .prepare = prepare, .solve = gradients};
  const dls_limits limits = {.tol = 1e-9};
  dls_global *G = NULL;
  dls_error e = {0};
  dls_info info;
  for (int c = 0; c < nc; c++)
    mu[c] = friction;
  ck_assert_msg(!dls_global_create(&G, model, &e), "%s", e.message);
  ck_assert_int_eq(dls_global_solve(G, S->f, S->g, mu, &limits, r, x, &info, &e), DLS_OK);
  dls_global_destroy(G);
  ck_assert_msg(!dls_global_create_with(&G, model, &solver, &e), "%s", e.message);
  for (int turn = 0; turn < 2; turn++) { /* the second one after an update */
    h.prepared = h.solved = 0;
    ck_assert_int_eq(dls_global_solve(G, S->f, S->g, mu, &limits, s, y, &info, &e), DLS_OK);
    ck_assert(dls_certificate_holds(&info.certificate, 1e-9));
    ck_assert_int_eq(h.solved, info.iterations);
    ck_assert_int_eq(h.prepared, info.factorisations);
    ck_assert_msg(apart(s, r, m) < 1e-6 && apart(y, x, n) < 1e-6, "%g %g", apart(s, r, m),
                  apart(y, x, n));
    ck_assert_int_eq(dls_global_update(G, model, &e), DLS_OK);
  }
  ck_assert(h.worst < 0.1); /* first guesses come closer */
  ck_assert_int_eq(h.wrong, 0);
  dls_global_destroy(G);
  free(h.R);
  free(r);
  free(x);
}

TEST_EACH(agrees_with_the_factor, 0, 3) {
  solids S;
  if (_i == 0)
    solids_pad(&S, 24, 4);
  else if (_i == 1)
    solids_plate(&S, 6, 2);
  else
    solids_stack(&S, 2, 2, 3, 0.5); /* bodies that contact alone holds */
  (void)solids_model(&S);
  expect_equal(&S, 0.3);
  solids_free(&S);
}

/* ---- K elsewhere, as src/mpi has it ---------------------------------------------------------- */

static void multiply_elsewhere(void *data, const double *x, double *y, double *a) {
  dlsi_body_multiply(data, x, y, a);
}

static void join_nobody(void *data, dlsi_how how, double *x, size_t count) {
  (void)data, (void)how, (void)x, (void)count;
}
static void fetch_nothing(void *data, double *r) {
  (void)data, (void)r;
}
static void give_nothing(void *data, dlsi_how how, double *u) {
  (void)data, (void)how, (void)u;
}

/* Makes the problem of G with K elsewhere. ranks: NULL, or one that is alone. */
static dls_global *elsewhere(const dls_global *G, host *h, const dlsi_ranks *ranks) {
  static const dls_sparse nowhere = {0};
  const dls_global_solver solver = {.data = h, .prepare = prepare, .solve = gradients};
  dls_model model = *h->model;
  dlsi_body body = {.multiply = multiply_elsewhere,
                    .data = (void *)(uintptr_t)h->model,
                    .ranks = ranks,
                    .n = model.n,
                    .d = model.d,
                    .nc = model.nodes,
                    .w = G->w,
                    .part = G->part,
                    .parts = G->body.parts};
  dls_global *out;
  dls_error e = {0};
  model.Ks = nowhere;
  ck_assert_msg(!dlsi_global_create_on(&out, &model, &body, &solver, &e), "%s", e.message);
  return out;
}

/* The same answer as where K is here; so one rank alone. */
TEST_EACH(a_K_that_is_elsewhere, 0, 2) {
  solids S;
  solids_pad(&S, 24, 4);
  const dls_model *model = solids_model(&S);
  const int n = model->n, nc = model->nodes, m = model->d * nc;
  double *r = calloc((size_t)(3 * m + nc), sizeof *r), *s = r + m, *scratch = s + m;
  double *mu = scratch + m, *x = calloc((size_t)(2 * n), sizeof *x), *y = x + n;
  const dlsi_ranks alone = {NULL, join_nobody, fetch_nothing, give_nothing,
                            0,    (size_t)m,   (size_t)m,     scratch};
  const dls_limits limits = {.tol = 1e-9};
  dls_global *G;
  dls_info info;
  host h = host_of(model);
  for (int c = 0; c < nc; c++)
    mu[c] = 0.3;
  ck_assert_int_eq(dls_global_create(&G, model, NULL), DLS_OK);
  ck_assert_int_eq(dls_global_solve(G, S.f, S.g, mu, &limits, r, x, &info, NULL), DLS_OK);
  dls_global *there = elsewhere(G, &h, _i ? &alone : NULL);
  ck_assert_int_eq(dls_global_solve(there, S.f, S.g, mu, &limits, s, y, &info, NULL), DLS_OK);
  ck_assert(dls_certificate_holds(&info.certificate, 1e-9));
  ck_assert_msg(apart(s, r, m) < 1e-6 && apart(y, x, n) < 1e-6, "%g %g", apart(s, r, m),
                apart(y, x, n));
  ck_assert_int_eq(h.wrong, 0);
  dls_global_destroy(there);
  dls_global_destroy(G);
  free(h.R);
  free(r);
  free(x);
  solids_free(&S);
}

/* Every allocation of a problem whose K is elsewhere fails in turn. */
TEST(a_K_elsewhere_without_memory) {
  solids S;
  solids_pad(&S, 6, 2);
  const dls_model *model = solids_model(&S);
  host h = host_of(model);
  dls_global *G, *there = NULL;
  dls_error error;
  ck_assert_int_eq(dls_global_create(&G, model, NULL), DLS_OK);
  dlsi_body body = G->body;
  const dls_global_solver solver = {.data = &h, .prepare = prepare, .solve = gradients};
  body.multiply = multiply_elsewhere;
  body.data = (void *)(uintptr_t)model;
  body.model = NULL;
  MALLOCS_FAIL(dlsi_global_create_on(&there, model, &body, &solver, &error), there == NULL, DLS_OK,
               3);
  dls_global_destroy(there);
  dls_global_destroy(G);
  free(h.R);
  solids_free(&S);
}

/* A block that its weight presses on the ground has no motion that proves anything; one that is
 * pulled up has, without a solve. */
TEST_EACH(a_proof_alone, 0, 2) {
  solids S;
  solids_stack(&S, 2, 1, 3, 0);
  const dls_model *model = solids_model(&S);
  double *mu = calloc((size_t)model->nodes, sizeof *mu);
  int proved = -1;
  dls_global *G;
  ck_assert_int_eq(dls_global_create(&G, model, NULL), DLS_OK);
  for (int k = 0; k < model->n && _i; k++)
    S.f[k] = -S.f[k];
  ck_assert_int_eq(dlsi_global_prove_for(G, S.f, mu, &proved, NULL), DLS_OK);
  ck_assert_int_eq(proved, _i);
  ck_assert_int_eq(dls_global_motion(G, NULL) != NULL, _i);
  dls_global_destroy(G);
  free(mu);
  solids_free(&S);
}

/* Entries of one place that are finite, and whose sum is not. */
TEST(entries_that_add_up_to_infinity) {
  solids S;
  solids_pad(&S, 4, 2);
  dls_model model = *solids_model(&S);
  double *x = calloc((size_t)model.Ks.p[model.n], sizeof *x);
  dls_global *G;
  for (int k = 0; k < model.Ks.p[model.n]; k++)
    x[k] = 1e308;
  model.Ks.x = x;
  REFUSES(NOT_FINITE, "Ks", 2, dls_global_create, &G,
          &model); /* of the first node of two squares */
  free(x);
  solids_free(&S);
}

/* Newton steps by the host's preconditioner, exact or rough, end where the factor ends, in the same
 * steps in other units; where it is no preconditioner, or a motion is free, the splitting does. */
TEST_EACH(newton_by_the_host, 0, 15) {
  static const struct {
    int most;
    double garbage;
    dls_status answer;
  } hosts[] = {{10000, 0, 0}, {25, 0, 0}, {0, 1e-3, 0}, {0, NAN, 0}, {0, 0, DLS_E_SINGULAR}};
  const int kind = _i % 5, spatial = _i / 5;
  int steps[2] = {0};
  for (int units = 0; units < 2; units++) {
    solids S;
    if (spatial == 0)
      solids_pad(&S, 24, 4);
    else if (spatial == 1)
      solids_plate(&S, 6, 2);
    else
      solids_stack(&S, 2, 2, 3, 0.5);
    const dls_model *model = solids_model(&S);
    const int n = model->n, nc = model->nodes, m = model->d * nc;
    const double stiffness = units ? 0x1p20 : 1;
    double *K = calloc((size_t)model->Ks.p[n], sizeof *K), *mu = calloc((size_t)nc, sizeof *mu);
    double *r = calloc((size_t)(2 * m), sizeof *r), *s = r + m;
    double *x = calloc((size_t)(2 * n), sizeof *x), *y = x + n;
    for (int k = 0; k < model->Ks.p[n]; k++)
      K[k] = stiffness * model->Ks.x[k];
    for (int k = 0; k < n; k++)
      S.f[k] *= stiffness;
    for (int c = 0; c < nc; c++)
      mu[c] = 0.3;
    dls_model scaled = *model;
    scaled.Ks.x = K;
    host h = host_of(&scaled);
    h.most = hosts[kind].most;
    h.garbage = hosts[kind].garbage;
    h.answer_apply = hosts[kind].answer;
    const dls_global_solver solver = {&h, prepare, gradients, block, cycle};
    const dls_limits limits = {.tol = 1e-9};
    dls_global *G = NULL;
    dls_error e = {0};
    dls_info info;
    ck_assert_msg(!dls_global_create(&G, &scaled, &e), "%s", e.message);
    ck_assert_int_eq(dls_global_solve(G, S.f, S.g, mu, &limits, r, x, &info, &e), DLS_OK);
    dls_global_destroy(G);
    ck_assert_msg(!dls_global_create_with(&G, &scaled, &solver, &e), "%s", e.message);
    ck_assert_int_eq(dls_global_solve(G, S.f, S.g, mu, &limits, s, y, &info, &e), DLS_OK);
    ck_assert(dls_certificate_holds(&info.certificate, 1e-9));
    ck_assert_msg(apart(s, r, m) < 1e-6 && apart(y, x, n) < 1e-6, "%g %g", apart(s, r, m),
                  apart(y, x, n));
    ck_assert(h.cycles > 0 && h.wrong == 0);
    if (kind < 2 && spatial < 2) { /* Newton's steps alone */
      ck_assert_msg(h.solved == 0 && info.iterations <= 12 && h.cycles <= 8 * info.iterations,
                    "%d %d %d", h.solved, info.iterations, h.cycles);
      ck_assert_int_eq(h.blocks, info.factorisations);
    } else if (kind >= 2)
      ck_assert_int_gt(h.solved, 0);
    steps[units] = info.iterations;
    dls_global_destroy(G);
    free(h.R);
    free(K);
    free(mu);
    free(r);
    free(x);
    solids_free(&S);
  }
  ck_assert(kind == 2 || steps[0] == steps[1]); /* garbage has no units */
}

/* Steps that advance go on, though none halves the residual of the one before: no splitting. */
TEST(newton_on_a_long_surface) {
  solids S;
  solids_strip(&S, 80, 4);
  const dls_model *model = solids_model(&S);
  const int n = model->n, nc = model->nodes, m = 2 * nc;
  double *mu = calloc((size_t)(nc + m + n), sizeof *mu), *r = mu + nc, *x = r + m;
  host h = host_of(model);
  h.most = 10000;
  const dls_global_solver solver = {&h, prepare, gradients, block, cycle};
  const dls_limits limits = {.tol = 1e-9};
  dls_global *G = NULL;
  dls_error e = {0};
  dls_info info;
  for (int c = 0; c < nc; c++) {
    const double X = 2. * c / nc - 1;
    mu[c] = 1;
    S.g[2 * c] = 6e-3 * X * X;
  }
  ck_assert_msg(!dls_global_create_with(&G, model, &solver, &e), "%s", e.message);
  ck_assert_int_eq(dls_global_solve(G, S.f, S.g, mu, &limits, r, x, &info, &e), DLS_OK);
  ck_assert(dls_certificate_holds(&info.certificate, 1e-9));
  ck_assert_int_eq(h.solved, 0);
  dls_global_destroy(G);
  free(h.R);
  free(mu);
  solids_free(&S);
}

/* Where all contacts are open, or there is none, x is as accurate as tol asks for. */
TEST_EACH(open_or_none, 0, 2) {
  solids S;
  solids_pad(&S, 12, 3);
  const dls_model *model = solids_model(&S);
  dls_model bare = *model;
  if (_i) bare.nodes = 0;
  const int n = model->n, m = bare.d * bare.nodes;
  double *r = calloc((size_t)(m + n) + 1, sizeof *r), *x = r + m;
  host h = host_of(&bare);
  const dls_global_solver solver = {.data = &h, .prepare = prepare, .solve = gradients};
  dls_global *G = NULL;
  dls_error e = {0};
  dls_info info;
  for (int c = 0; c < model->nodes; c++)
    S.g[model->d * c] = 1e3;
  for (int k = 0; k < n; k++)
    S.f[k] += 1e-3 * sin(k);
  ck_assert_msg(!dls_global_create_with(&G, &bare, &solver, &e), "%s", e.message);
  ck_assert_int_eq(dls_global_solve(G, S.f, m ? S.g : NULL, NULL, NULL, r, x, &info, &e), DLS_OK);
  ck_assert_msg(info.certificate.equilibrium > 0 && info.certificate.equilibrium <= 1e-8, "%g",
                info.certificate.equilibrium);
  assert_all(r, m, 0);
  dls_global_destroy(G);
  free(h.R);
  free(r);
  solids_free(&S);
}

/* What a host answers is what the solve answers. */
TEST(answers_of_a_host) {
  solids S;
  solids_pad(&S, 6, 2);
  const dls_model *model = solids_model(&S);
  const int n = model->n, nc = model->nodes, m = model->d * nc;
  double *r = calloc((size_t)(m + n), sizeof *r), *x = r + m;
  host h = host_of(model);
  dls_global_solver solver = {.data = &h, .prepare = prepare, .solve = gradients};
  dls_global *G = (void *)&h;
  dls_error e = {0};
  dls_info info = {0};
  REFUSES(ARGUMENT, "solver", -1, dls_global_create_with, &G, model, NULL);
  ck_assert_ptr_null(G);
  solver.prepare = NULL;
  REFUSES(ARGUMENT, "solver.prepare", -1, dls_global_create_with, &G, model, &solver);
  solver.prepare = prepare;
  solver.solve = NULL;
  REFUSES(ARGUMENT, "solver.solve", -1, dls_global_create_with, &G, model, &solver);
  solver.solve = gradients;
  solver.apply = cycle;
  REFUSES(ARGUMENT, "solver.block", -1, dls_global_create_with, &G, model, &solver);
  solver.apply = NULL;
  solver.block = block;
  REFUSES(ARGUMENT, "solver.apply", -1, dls_global_create_with, &G, model, &solver);
  solver.apply = cycle;
  h.answer_apply = DLS_E_MEMORY;
  ck_assert_msg(!dls_global_create_with(&G, model, &solver, &e), "%s", e.message);
  REFUSES(MEMORY, "solver", -1, dls_global_solve, G, S.f, S.g, NULL, NULL, r, x, &info);
  h.answer_apply = DLS_CANCELLED;
  ck_assert_int_eq(dls_global_solve(G, S.f, S.g, NULL, NULL, r, x, &info, &e), DLS_CANCELLED);
  h.answer_apply = DLS_OK;
  h.most = 10000;
  MALLOCS_FAIL(dls_global_solve(G, S.f, S.g, NULL, NULL, r, x, &info, NULL), r[0] == 0, DLS_OK, 5);
  memset(r, 0, (size_t)(m + n) * sizeof *r);
  dls_global_destroy(G);
  solver.block = NULL;
  solver.apply = NULL;
  ck_assert_msg(!dls_global_create_with(&G, model, &solver, &e), "%s", e.message);
  dls_global_info cost;
  REFUSES(UNSUPPORTED, "global", -1, dls_global_get_info, G, &cost);
  h.answer_prepare = DLS_E_SINGULAR;
  REFUSES(SINGULAR, "solver", -1, dls_global_solve, G, S.f, S.g, NULL, NULL, r, x, &info);
  ck_assert_int_eq(dls_global_solve(G, S.f, S.g, NULL, NULL, r, x, &info, NULL), DLS_E_SINGULAR);
  h.answer_prepare = DLS_OK;
  h.answer_solve = DLS_E_MEMORY;
  REFUSES(MEMORY, "solver", -1, dls_global_solve, G, S.f, S.g, NULL, NULL, r, x, &info);
  ck_assert_int_eq(dls_global_solve(G, S.f, S.g, NULL, NULL, r, x, &info, NULL), DLS_E_MEMORY);
  assert_all(r, m + n, 0); /* untouched */
  h.answer_solve = DLS_CANCELLED;
  ck_assert_int_eq(dls_global_solve(G, S.f, S.g, NULL, NULL, r, x, &info, &e), DLS_CANCELLED);
  ck_assert_int_eq(info.status, DLS_CANCELLED);
  h.answer_solve = DLS_OK;
  ck_assert_int_eq(dls_global_solve(G, S.f, S.g, NULL, NULL, r, x, &info, &e), DLS_OK);
  ck_assert_int_eq(h.wrong, 0);
  dls_global_destroy(G);
  free(h.R);
  free(r);
  solids_free(&S);
}

/* Nothing holds a body that is lifted; without a factor that is not proved. */
TEST(without_proof) {
  solids S;
  solids_stack(&S, 2, 1, 2, 0);
  const dls_model *model = solids_model(&S);
  const int n = model->n, m = model->d * model->nodes;
  double *r = calloc((size_t)(m + n), sizeof *r), *x = r + m;
  host h = host_of(model);
  const dls_global_solver solver = {.data = &h, .prepare = prepare, .solve = gradients};
  const dls_limits limits = {.tol = 1e-8, .max_iterations = 400};
  dls_global *G = NULL;
  dls_error e = {0};
  dls_info info;
  for (int k = 0; k < n; k++)
    S.f[k] = -S.f[k];
  ck_assert_msg(!dls_global_create_with(&G, model, &solver, &e), "%s", e.message);
  const dls_status status = dls_global_solve(G, S.f, S.g, NULL, &limits, r, x, &info, &e);
  ck_assert_int_eq(status, DLS_NOT_IN_EQUILIBRIUM);
  ck_assert_ptr_null(dls_global_motion(G, NULL));
  ck_assert_int_eq(h.wrong, 0);
  dls_global_destroy(G);
  free(h.R);
  free(r);
  solids_free(&S);
}

/* Each malloc of create fails in turn; a solve allocates nothing. */
TEST(failing_mallocs) {
  solids S;
  solids_plate(&S, 3, 1);
  const dls_model *model = solids_model(&S);
  const int n = model->n, m = model->d * model->nodes;
  double *r = calloc((size_t)(m + n), sizeof *r), *x = r + m;
  host h = host_of(model);
  const dls_global_solver solver = {.data = &h, .prepare = prepare, .solve = gradients};
  dls_global *G = NULL;
  MALLOCS_FAIL(dls_global_create_with(&G, model, &solver, NULL), !G, DLS_OK, 10);
  malloc_fails_at(1);
  const dls_status status = dls_global_solve(G, S.f, S.g, NULL, NULL, r, x, NULL, NULL);
  malloc_fails_at(0);
  ck_assert_int_eq(status, DLS_OK);
  ck_assert_int_eq(h.wrong, 0);
  dls_global_destroy(G);
  free(h.R);
  free(r);
  solids_free(&S);
}
