/*
 * test_contract.c: the obligations of every method, by each public interface ("door"): its own
 * functions, or dls_solver with each method of the library's table. A method that joins the table
 * is tested here without an edit.
 *
 * A loop test counts doors first: _i = door * cases + case.
 */
#include "cases.h"
#include "doors.h"
#include "made.h"
#include "run.h"

static int doors(void) {
  return direct_doors + method_count();
}

/* settings of any door */
typedef union any_settings {
  char bytes[256];
  double alignment;
  void *pointer;
} any_settings;

static any_settings settings_for(const tested_solver *s, double tol, int warm_start) {
  any_settings settings;
  ck_assert(s->settings_size <= sizeof settings);
  s->init(s, &settings, tol > s->tol ? tol : s->tol, warm_start);
  return settings;
}

/* Solves a problem from r as a start, or from nothing. */
static dls_status solve_from(const tested_solver *s, const dls_contact *p, double tol,
                             int warm_start, double *r, dls_info *info) {
  const any_settings settings = settings_for(s, tol, warm_start);
  return run_with(s, p, &settings, tol > s->tol ? tol : s->tol, r, NULL, info);
}

/* ---- answers --------------------------------------------------------------------------------- */

/* The few problems of cases.c that a method is known not to solve; its own tests say more. */
static int is_beyond(dls_method method, const char *name) {
  static const struct {
    dls_method method;
    const char *name;
  } known[] = {{DLS_NLGS, "C11"}, {DLS_NLGS, "C13"}, {DLS_NEWTON, "C13"}};
  for (size_t k = 0; k < sizeof known / sizeof known[0]; k++)
    if (known[k].method == method && strcmp(known[k].name, name) == 0) return 1;
  return 0;
}

TEST_EACH(by_hand, 0, doors() * hand_count) {
  const tested_solver s = door(_i / hand_count);
  const hand_case *k = &hand[_i % hand_count];
  static model a;
  set_hand(&a, k);
  const int m = k->d * k->nc;
  double r[4];
  dls_info info;
  const dls_status status = solve_from(&s, &a.p, 1e-14, 0, r, &info);
  if (s.tol > 0) return; /* run_in has compared what it says with the certificate */
  if (is_beyond(s.method, k->name)) {
    ck_assert_int_ne(status, DLS_OK);
    return;
  }
  ck_assert_msg(status == DLS_OK, "%s, %s: %d, %g", s.name, k->name, (int)status,
                info.certificate.residual);
  if (strcmp(k->name, "C16") == 0) return; /* three solutions */
  for (int i = 0; i < m; i++)
    ck_assert_msg(fabs(r[i] - k->r[i]) <= 1e-12 * fmax(1, norm_of(k->r, m)), "%s: r[%d] = %.17g",
                  k->name, i, r[i]);
}

/* Of all reactions that hold a hyperstatic problem, only the sum is known. */
TEST_EACH(hyperstatic, 0, doors()) {
  const tested_solver s = door(_i);
  static model a;
  set_hand(&a, &hyperstatic_case);
  double r[4];
  dls_info info;
  ck_assert_int_eq(solve_from(&s, &a.p, 1e-13, 0, r, &info), DLS_OK);
  const double close = s.tol > 0 ? 1e-5 : 1e-12;
  ck_assert(fabs(r[0] + r[2] - 1) <= close && fabs(r[1] + r[3] + .25) <= close);
}

/* C1 has three solutions: from each of them nothing is done. */
TEST_EACH(a_solution_stays, 0, doors()) {
  const tested_solver s = door(_i);
  static const double start[3][2] = {{0, 0}, {2, -3}, {1, -2}};
  static model a;
  if (s.restarts) return;
  set_hand(&a, &ambiguous_case);
  for (int k = 0; k < 3; k++) {
    double r[2] = {start[k][0], start[k][1]};
    dls_info info;
    ck_assert_int_eq(solve_from(&s, &a.p, 1e-12, 1, r, &info), DLS_OK);
    ck_assert(r[0] == start[k][0] && r[1] == start[k][1]);
    ck_assert(info.iterations == 0 && info.sweeps == 0 && info.factorisations == 0);
  }
}

TEST_EACH(no_solution, 0, doors() * jammed_count) {
  const tested_solver s = door(_i / jammed_count);
  const hand_case *k = &jammed[_i % jammed_count];
  static model a;
  set_hand(&a, k);
  double r[4];
  dls_info info;
  const dls_status status = solve_from(&s, &a.p, 1e-8, 0, r, &info);
  ck_assert_msg(status > 0, "%s, %s: %d", s.name, k->name, (int)status);
  ck_assert(info.certificate.residual > 0.1 && isfinite(info.certificate.residual));
}

/* From any start, off the cone too, and after any number of iterations the answer is not worse. */
TEST_EACH(never_worse, 0, doors() * 30) {
  const tested_solver s = door(_i / 30);
  const int i = _i % 30;
  static model a;
  if (s.restarts) return;
  double r[9];
  set_seed(362436069 + (uint64_t)i);
  if (i % 2) {
    const hand_case *k = hand_named("C14");
    set_hand(&a, k);
    for (int e = 0; e < 4; e++)
      r[e] = k->r[e] * (1 + 0.5 * uniform());
  } else {
    random_model(&a, 2 + i / 2 % 2, 3, 2);
    for (int e = 0; e < 9; e++)
      r[e] = uniform();
  }
  any_settings settings = settings_for(&s, 1e-14, 1);
  s.limits(&settings)->max_iterations = 1 + i % 4;
  const dls_certificate before = certificate_of(&a.p, r);
  dls_info info;
  (void)run_with(&s, &a.p, &settings, 1e-14, r, NULL, &info);
  ck_assert(info.certificate.residual <= before.residual);
}

TEST_EACH(start_that_overflows, 0, doors()) {
  const tested_solver s = door(_i);
  static model a;
  set_hand(&a, hand_named("stick"));
  double r[2] = {1.7e308, 1.7e308};
  dls_info info;
  const dls_status status = solve_from(&s, &a.p, 1e-12, 1, r, &info);
  ck_assert_int_eq(status, DLS_OK);
  const double close = s.tol > 0 ? 1e-5 : 1e-11;
  ck_assert(fabs(r[0] - 1) <= close && fabs(r[1] + .5) <= close);
}

/* A start so large that W r hides q in its rounding is dropped: the answer is that from r = 0, to
 * the same bits where the method sweeps from its start; a start that is merely bad is not. */
TEST_EACH(start_that_hides_q, 0, doors() * 10) {
  const tested_solver s = door(_i / 10);
  static model a;
  numbered_model(&a, _i % 10);
  double cold[most], r[most], u[most];
  dls_info info;
  const double tol = 1e-10;
  ck_assert_int_eq(solve_from(&s, &a.p, tol, 0, cold, &info), DLS_OK);
  const int m = a.p.d * a.p.nc;
  const double size = norm_of(cold, m) + norm_of(a.q, m);
  dls_certificate start;
  for (int k = 0; k < m; k++)
    r[k] = 1e25 * size * (k % 2 ? -0.5 : 1);
  ck_assert_int_eq(dls_contact_certify(&a.p, r, u, &start, NULL), DLS_OK);
  if (!(start.floor_u >= 1)) return; /* no reaction of the answer, or W weak */
  ck_assert_int_eq(solve_from(&s, &a.p, tol, 1, r, &info), DLS_OK);
  if (s.method == DLS_NLGS || s.method == DLS_NEWTON)
    ck_assert_mem_eq(r, cold, sizeof *r * (size_t)m);
  for (int k = 0; k < m; k++)
    ck_assert(fabs(r[k] - cold[k]) <= 1e-4 * size || s.tol > 0);
}

/* ---- random ---------------------------------------------------------------------------------- */

TEST_EACH(random_problem, 0, doors() * 40) {
  const tested_solver s = door(_i / 40);
  expect_solved(&s, _i % 40);
  expect_answer_of(&s, _i % 40, s.method == DLS_NLGS ? DLS_NEWTON : DLS_NLGS);
}

TEST_EACH(units, 0, doors() * 12) {
  const tested_solver s = door(_i / 12);
  static model a;
  numbered_model(&a, _i % 12);
  /* powers of ten round: below 1e-8 that decides now and then which columns Anderson drops */
  for (int two = 0; two < 2; two++) {
    const double tol = two ? 1e-10 : 1e-8;
    const any_settings settings = settings_for(&s, tol, 0);
    expect_any_units(&s, &a, &settings, s.tol > 0 ? s.tol : tol, two);
  }
}

TEST_EACH(turned_tangents, 0, doors() * 10) {
  const tested_solver s = door(_i / 10);
  expect_any_tangents(&s, _i % 10);
}

TEST_EACH(tolerance_zero, 0, doors() * 20) {
  const tested_solver s = door(_i / 20);
  if (s.tol > 0 || s.method == DLS_ADMM)
    return; /* near the floor ADMM is left by luck: test_admm */
  expect_floor(&s, _i % 20);
}

TEST_EACH(smaller_problem, 0, doors()) {
  const tested_solver s = door(_i);
  static model a, b;
  numbered_model(&a, 39);
  numbered_model(&b, 11);
  expect_reuse(&s, &a, &b);
}

/* ---- rigid bodies, W = H^T H ----------------------------------------------------------------- */

/* Largest |r| over the tolerance that two answers to 1e-12 may differ by, W as random as here. */
static const double close_of_bodies = 1e-7;

/* The answer is that of W dense; again in the same workspace, without memory, and warm. */
TEST_EACH(bodies, 0, doors() * 30) {
  const tested_solver s = door(_i / 30);
  static model a;
  static bodies_storage B;
  dls_contact p;
  bodies_model(&a, &B, &p, _i % 30);
  const int m = a.p.d * a.p.nc;
  const double tol = s.tol > 0 ? s.tol : 1e-12;
  const double close = close_of_bodies * (tol / 1e-12);
  any_settings cold = settings_for(&s, tol, 0);
  s.limits(&cold)->blocks = a.p.nc * a.p.nc;
  double dense[most], r[most], r2[most], u[most];
  dls_info info;
  ck_assert_int_eq(solve_from(&s, &a.p, tol, 0, dense, &info), DLS_OK);
  void *work;
  ck_assert_int_eq(s.create(&work, a.p.d, a.p.nc, &cold, NULL), DLS_OK);
  ck_assert_int_eq(run_in(&s, work, &p, tol, r, u, &info), DLS_OK);
  expect_no_allocation(&s, work, &p, r2);
  ck_assert_mem_eq(r, r2, (size_t)m * sizeof *r);
  const double size = 1 + norm_of(dense, m);
  for (int k = 0; k < m; k++) {
    double expected = a.q[k];
    for (int l = 0; l < m; l++)
      expected += a.W[k + m * l] * r[l];
    ck_assert(fabs(r[k] - dense[k]) <= close * size);
    ck_assert(fabs(u[k] - expected) <= 1e-13 * size);
  }
  s.destroy(work);
  if (s.restarts) return;
  ck_assert_int_eq(solve_from(&s, &p, tol, 1, r2, &info), DLS_OK);
  ck_assert_mem_eq(r, r2, (size_t)m * sizeof *r);
  ck_assert(info.iterations == 0 && info.sweeps == 0 && info.factorisations == 0);
}

/* Each malloc of a solve may fail; then one limit of iterations, one call that cancels. */
TEST_EACH(bodies_unwind_and_stop, 0, doors()) {
  const tested_solver s = door(_i);
  static model a;
  static bodies_storage B;
  dls_contact p;
  bodies_model(&a, &B, &p, 29);
  any_settings settings = settings_for(&s, s.tol > 0 ? s.tol : 1e-10, 0);
  void *work;
  double r[most];
  dls_info info;
  ck_assert_int_eq(s.create(&work, p.d, p.nc, &settings, NULL), DLS_OK);
  expect_solve_unwinds(&s, work, &p, r);
  s.destroy(work);
  watch w = {NULL, 0, INFINITY, 0, 1};
  settings = settings_for(&s, 1e-14, 0);
  s.limits(&settings)->progress = look;
  s.limits(&settings)->progress_data = &w;
  const dls_status status = run_with(&s, &p, &settings, fmax(s.tol, 1e-14), r, NULL, &info);
  ck_assert(status == DLS_CANCELLED || status == DLS_OK);
  ck_assert(w.calls == 1 && isfinite(info.certificate.residual));
}

TEST_EACH(bad_bodies, 0, doors()) {
  const tested_solver s = door(_i);
  static model a;
  static bodies_storage B;
  dls_contact good, bad;
  bodies_model(&a, &B, &good, 29);
  const any_settings settings = settings_for(&s, 1e-8, 0);
  const struct {
    dls_status status;
    const char *argument;
    long long index;
  } wrong[] = {{DLS_E_SIZE, "bodies.n", -1},           {DLS_E_SIZE, "bodies.count", -1},
               {DLS_E_ARGUMENT, "bodies.body", -1},    {DLS_E_ARGUMENT, "bodies.body", 4},
               {DLS_E_ARGUMENT, "bodies.body", 3},     {DLS_E_ARGUMENT, "bodies.body", 5},
               {DLS_E_NOT_FINITE, "bodies.H", 18 * 7}, {DLS_E_ARGUMENT, "bodies", -1},
               {DLS_E_ARGUMENT, "bodies.work", -1}};
  void *work;
  ck_assert_int_eq(s.create(&work, good.d, good.nc, &settings, NULL), DLS_OK);
  for (int k = 0; k < 9; k++) {
    static bodies_storage C;
    double r[most] = {7};
    dls_error error;
    C = B;
    bad = good;
    bad.bodies.body = C.body;
    bad.bodies.H = C.H;
    if (k == 0) bad.bodies.n = 3;
    if (k == 1) bad.bodies.count = -1;
    if (k == 2) bad.bodies.body = NULL;
    if (k == 3) C.body[4] = good.bodies.count;
    if (k == 4) C.body[3] = -2;
    if (k == 5) C.body[4] = C.body[5] = 1;
    if (k == 6) C.body[7] = 0, C.H[18 * 7] = INFINITY;
    if (k == 7) bad.W = a.p.W;
    if (k == 8) bad.bodies.work = r;
    ck_assert_int_eq(s.solve(work, &bad, r, NULL, NULL, &error), wrong[k].status);
    ck_assert_str_eq(error.argument, wrong[k].argument);
    ck_assert_msg(error.index == wrong[k].index, "%d: %lld", k, error.index);
    ck_assert(r[0] == 7);
  }
  s.destroy(work);
}

/* ---- normals alone, d = 1 -------------------------------------------------------------------- */

/* LCP(W_nn, q_n) by hand; r = -1: there is no solution. */
static const struct {
  int nc;
  double W[4], q[2], r[2]; /* W by rows */
} normal_case[] = {{1, {2}, {-1}, {.5}},
                   {1, {2}, {1}, {0}},
                   {1, {2}, {0}, {0}},
                   {2, {2, 1, 1, 2}, {-1, -1}, {1. / 3, 1. / 3}},
                   {2, {1, .5, .5, 1}, {-1, 1}, {1, 0}},
                   {2, {1, -.5, -.5, 1}, {-1, .25}, {7. / 6, 1. / 3}},
                   {2, {1, .5, .25, 2}, {-1, -2}, {8. / 15, 14. / 15}},
                   {1, {-1}, {-1}, {-1}},
                   {1, {0}, {-1}, {-1}},
                   {2, {1, -1, -1, 1}, {-1, -1}, {-1, -1}}};
enum { normal_count = sizeof normal_case / sizeof normal_case[0] };

TEST_EACH(normals_by_hand, 0, doors() * normal_count) {
  const tested_solver s = door(_i / normal_count);
  const int k = _i % normal_count, nc = normal_case[k].nc;
  static model a;
  set_model(&a, 1, nc);
  for (int e = 0; e < nc * nc; e++)
    a.W[e % nc * nc + e / nc] = normal_case[k].W[e];
  memcpy(a.q, normal_case[k].q, sizeof normal_case[k].q);
  double r[2];
  dls_info info;
  const dls_status status = solve_from(&s, &a.p, 1e-12, 0, r, &info);
  if (s.tol > 0) return; /* run_in has compared what it says with the certificate */
  const int solvable = normal_case[k].r[0] >= 0;
  ck_assert_msg((status == DLS_OK) == solvable && status >= 0, "%s, %d: %d, %g", s.name, k,
                (int)status, info.certificate.residual);
  for (int c = 0; solvable && c < nc; c++)
    ck_assert_double_eq_tol(r[c], normal_case[k].r[c], 1e-10);
  if (!solvable && (s.method == DLS_AUTO || s.method == DLS_LEMKE))
    ck_assert_msg(status == DLS_NO_SOLUTION, "%s, %d: %d", s.name, k, (int)status);
}

TEST_EACH(normals, 0, doors() * 20) {
  const tested_solver s = door(_i / 20);
  const int i = normal_models + _i % 20;
  static model a;
  expect_solved(&s, i);
  expect_answer_of(&s, i, s.method == DLS_NLGS ? DLS_NEWTON : DLS_NLGS);
  if (s.tol == 0 && s.method != DLS_ADMM) expect_floor(&s, i);
  numbered_model(&a, i);
  for (int two = 0; two < 2; two++) {
    const double tol = two ? 1e-10 : 1e-8;
    const any_settings settings = settings_for(&s, tol, 0);
    expect_any_units(&s, &a, &settings, s.tol > 0 ? s.tol : tol, two);
  }
}

/* The normal reactions of a problem without friction are those of d = 1. */
TEST_EACH(normals_of_a_space, 0, doors() * 20) {
  const tested_solver s = door(_i / 20);
  static model a, b;
  set_seed(88172645463325252u + (uint64_t)_i);
  random_model(&a, 2 + _i % 2, 1 + _i % 20, 0);
  const int d = a.p.d, nc = a.p.nc, m = d * nc;
  set_model(&b, 1, nc);
  for (int c = 0; c < nc; c++) {
    b.q[c] = a.q[d * c];
    for (int k = 0; k < nc; k++)
      b.W[k + nc * c] = a.W[d * k + m * d * c];
  }
  const double tol = s.tol > 0 ? s.tol : 1e-12;
  double r[most], n[most];
  dls_info info;
  ck_assert_int_eq(solve_from(&s, &a.p, tol, 0, r, &info), DLS_OK);
  ck_assert_int_eq(solve_from(&s, &b.p, tol, 0, n, &info), DLS_OK);
  for (int c = 0; c < nc; c++)
    ck_assert(fabs(n[c] - r[d * c]) <= close_of(&a) * (tol / 1e-12));
}

TEST_EACH(normals_have_no_friction, 0, doors()) {
  const tested_solver s = door(_i);
  static model a;
  numbered_model(&a, normal_models + 4);
  a.mu[3] = .5;
  const any_settings settings = settings_for(&s, 1e-8, 0);
  void *work;
  ck_assert_int_eq(s.create(&work, 1, a.p.nc, &settings, NULL), DLS_OK);
  double r[most] = {7};
  dls_error error;
  ck_assert_int_eq(s.solve(work, &a.p, r, NULL, NULL, &error), DLS_E_ARGUMENT);
  ck_assert_str_eq(error.argument, "mu");
  ck_assert_int_eq(error.index, 3);
  ck_assert(r[0] == 7);
  a.mu[3] = 0;
  ck_assert_int_ge(s.solve(work, &a.p, r, NULL, NULL, &error), 0);
  s.destroy(work);
}

/* ---- stopping -------------------------------------------------------------------------------- */

/* Cancelled at the first or second call, or after two iterations: the status says so unless all is
 * solved by then, and the answer is the best of what was reported. */
TEST_EACH(stopped_early, 0, doors() * 3) {
  const tested_solver s = door(_i / 3);
  const int cancel_at = _i % 3;
  static model a;
  set_seed(521288629);
  random_model(&a, 3, 20, 0.6);
  any_settings settings = settings_for(&s, 1e-14, 0);
  watch w = {NULL, 0, INFINITY, 0, cancel_at};
  dls_limits *limits = s.limits(&settings);
  limits->progress = look;
  limits->progress_data = &w;
  if (!cancel_at) limits->max_iterations = 2;
  double r[most];
  dls_info info;
  const dls_status status = run_with(&s, &a.p, &settings, fmax(s.tol, 1e-14), r, NULL, &info);
  if (cancel_at && w.calls == cancel_at)
    ck_assert(status == DLS_CANCELLED || (s.tol > 0 && status == DLS_OK));
  else
    ck_assert(status == DLS_OK || (!cancel_at && status == DLS_MAX_ITERATIONS));
  ck_assert(!cancel_at || w.calls <= cancel_at);
  ck_assert_int_ge(w.calls, 1);
  ck_assert(isfinite(info.certificate.residual));
  ck_assert(info.certificate.residual <= w.least * (1 + 1e-12) + 1e-12);
}

/* The calls of one solve; least: the best residual of all but the last; r: of the last. */
typedef struct history {
  const dls_contact *problem;
  const char *method;
  int calls, lasts, iteration; /* iteration: of the last */
  double least, cpu_seconds, residual;
  double r[most];
} history;

static int take_history(void *data, const dls_progress *p) {
  history *h = data;
  ck_assert_int_eq(h->lasts, 0); /* nothing follows the last call */
  h->calls++;
  ck_assert_str_eq(p->method, h->method);
  ck_assert(p->stage && p->stage[0]);
  ck_assert_double_ge(p->cpu_seconds, h->cpu_seconds);
  h->cpu_seconds = p->cpu_seconds;
  h->lasts += p->last != 0;
  if (!p->last) {
    ck_assert_int_ge(p->iteration, 0);
    if (p->residual >= 0 && p->residual < h->least) h->least = p->residual;
  } else {
    h->residual = p->residual;
    h->iteration = p->iteration;
    memcpy(h->r, p->r, (size_t)(h->problem->d * h->problem->nc) * sizeof *h->r);
  }
  if (!p->r || p->residual < 0) return 0;
  const dls_certificate c = certificate_of(h->problem, p->r);
  /* the certificate of this r: the last time exactly, else as the iteration estimates it */
  if (p->last)
    ck_assert(p->residual == c.residual);
  else if (c.residual < 1 && p->residual < 1)
    ck_assert_msg(
        fabs(p->residual - c.residual) <= 1e-6 * c.residual + 100 * (c.floor_u + c.floor_r),
        "%s, %s %d: %.17g, %.17g", p->method, p->stage, p->iteration, p->residual, c.residual);
  return 0;
}

/* Tells of every method the same measure, and once of the end, solved or not. */
TEST_EACH(one_last_call, 0, doors() * 12) {
  const tested_solver s = door(_i / 12);
  const int i = _i % 12;
  static model a;
  if (i < 10)
    numbered_model(&a, 3 * i + 1);
  else
    set_hand(&a, i == 10 ? &jammed[0] : hand_named("C11"));
  any_settings settings = settings_for(&s, 1e-10, 0);
  history h = {
      .problem = &a.p, .method = dls_method_name(s.method), .least = INFINITY, .cpu_seconds = 0};
  dls_limits *limits = s.limits(&settings);
  limits->progress = take_history;
  limits->progress_data = &h;
  double r[most];
  dls_info info;
  const dls_status status = run_with(&s, &a.p, &settings, fmax(s.tol, 1e-10), r, NULL, &info);
  ck_assert_int_ge(status, 0);
  ck_assert_int_eq(h.lasts, 1);
  ck_assert_int_eq(h.iteration, info.sweeps + info.iterations);
  ck_assert(h.residual == info.certificate.residual);
  ck_assert_mem_eq(h.r, r, (size_t)(a.p.d * a.p.nc) * sizeof *r);
  if (status && i != 10) /* where reactions run away, less rounding is better than less residual */
    ck_assert(h.residual <= h.least * (1 + 1e-9) + 1e-13);
}

/* A limit that is over at once, on problems that some methods solve before they look at the clock:
 * the status says so, and the best answer is kept; with time enough nothing changes, to the
 * bit. */
TEST_EACH(time_limit, 0, doors() * 6) {
  const tested_solver s = door(_i / 6);
  const int i = _i % 6;
  static model a;
  if (i < 4)
    slow_model(&a, i);
  else
    set_hand(&a, i == 4 ? &jammed[0] : hand_named("C13"));
  double r[3][most];
  dls_info info[3];
  dls_status status[3];
  for (int k = 0; k < 3; k++) {
    any_settings settings = settings_for(&s, 1e-12, 0);
    s.limits(&settings)->cpu_seconds = k == 0 ? 1e-12 : k == 1 ? 1e6 : 0;
    status[k] = run_with(&s, &a.p, &settings, fmax(s.tol, 1e-12), r[k], NULL, &info[k]);
  }
  ck_assert(status[0] == DLS_TIME_LIMIT || status[0] == DLS_OK);
  ck_assert(info[0].certificate.residual <= 1 || info[0].status == DLS_OK);
  ck_assert_int_eq(status[1], status[2]);
  ck_assert_mem_eq(r[1], r[2], (size_t)(a.p.d * a.p.nc) * sizeof **r);
  if (status[2] != DLS_OK && status[0] == DLS_TIME_LIMIT && s.method != DLS_PENALTY)
    ck_assert_int_le(info[0].iterations, info[2].iterations);
}

TEST_EACH(bad_time_limit, 0, doors()) {
  const tested_solver s = door(_i);
  for (int k = 0; k < 3; k++) {
    any_settings settings = settings_for(&s, 1e-8, 0);
    s.limits(&settings)->cpu_seconds = k == 0 ? -1 : k == 1 ? (double)NAN : (double)INFINITY;
    refuses_to_create(&s, DLS_E_ARGUMENT, "cpu_seconds", -1, 2, 1, &settings);
  }
}

/* ---- one call at a time ---------------------------------------------------------------------- */

/* The solve that a callback is called from. */
typedef struct own_solve {
  const tested_solver *s;
  const dls_contact *problem;
  void *work;
  int calls, reenters;
} own_solve;

/* Solves again in the workspace that is at work, and changes its limits. */
static int solve_again(void *data, const dls_progress *p) {
  (void)p;
  own_solve *own = data;
  own->calls++;
  if (!own->reenters) return 0;
  double r[most] = {7}, u[most] = {7};
  dls_info info = {.iterations = 7};
  dls_error error;
  ck_assert_int_eq(own->s->solve(own->work, own->problem, r, u, &info, &error), DLS_E_BUSY);
  ck_assert_str_eq(error.argument, own->s->workspace);
  ck_assert_int_eq(error.status, DLS_E_BUSY);
  ck_assert(r[0] == 7 && u[0] == 7 && info.iterations == 7);
  if (strcmp(own->s->workspace, "solver")) return 0;
  const dls_limits limits = {.tol = 1e-3};
  REFUSES(BUSY, "solver", -1, dls_solver_set_limits, own->work, &limits);
  REFUSES(BUSY, "solver", -1, dls_solver_map, own->work, 0, NULL, NULL);
  return 0;
}

/* A workspace used again from inside of its own callback refuses, and the solve that is at work
 * gives the bits that it gives undisturbed; then the workspace is free again, also after bad input
 * and after a problem without candidates. */
TEST_EACH(busy, 0, doors() * 8) {
  const tested_solver s = door(_i / 8);
  const int i = _i % 8;
  static model a;
  if (i < 4)
    numbered_model(&a, 9 * i + 2);
  else if (i < 6)
    set_hand(&a, i == 4 ? &jammed[0] : hand_named("C13"));
  else
    slow_model(&a, i - 6);
  own_solve own = {.s = &s, .problem = &a.p};
  any_settings settings = settings_for(&s, 1e-10, 0);
  s.limits(&settings)->progress = solve_again;
  s.limits(&settings)->progress_data = &own;
  double r[4][most];
  dls_status status[4];
  int calls[4];
  ck_assert_int_eq(s.create(&own.work, a.p.d, a.p.nc, &settings, NULL), DLS_OK);
  for (int k = 0; k < 4; k++) {
    own.calls = 0;
    own.reenters = k == 1;
    if (k == 2) {
      const dls_contact none = {.d = a.p.d};
      own.reenters = 1;
      own.problem = &none;
      ck_assert_int_eq(s.solve(own.work, &none, NULL, NULL, NULL, NULL), DLS_OK);
      own.problem = &a.p;
      ck_assert_int_eq(s.solve(own.work, &a.p, NULL, NULL, NULL, NULL), DLS_E_ARGUMENT);
      own.calls = own.reenters = 0;
      s.destroy(own.work);
      ck_assert_int_eq(s.create(&own.work, a.p.d, a.p.nc, &settings, NULL), DLS_OK);
    }
    status[k] = s.solve(own.work, &a.p, r[k], NULL, NULL, NULL);
    ck_assert_int_ge(status[k], 0);
    calls[k] = own.calls;
    ck_assert_int_ge(calls[k], 1);
  }
  for (int k = 0; k < 2; k++) { /* the first and the second solve in a new workspace */
    ck_assert_int_eq(status[k], status[k + 2]);
    ck_assert_int_eq(calls[k], calls[k + 2]);
    ck_assert_mem_eq(r[k], r[k + 2], (size_t)(a.p.d * a.p.nc) * sizeof **r);
  }
  s.destroy(own.work);
}

/* Counts the calls, each the last one of a solve whose residual is 0, and tries to cancel. */
static int count_lasts(void *data, const dls_progress *p) {
  ck_assert(p->last && p->residual == 0 && p->iteration == 0);
  ++*(int *)data;
  return 1;
}

/* Without candidates every problem is solved, in a workspace for none or for more, from a start or
 * from nothing; the callback is called once, and there is nothing left for it to cancel. */
TEST_EACH(no_candidates, 0, doors() * 12) {
  const tested_solver s = door(_i / 12);
  const int d = 1 + _i % 3, room = _i / 3 % 2 ? 3 : 0, warm = _i / 6 % 2;
  any_settings settings = settings_for(&s, 1e-8, warm);
  int calls = 0;
  s.limits(&settings)->progress = count_lasts;
  s.limits(&settings)->progress_data = &calls;
  void *work;
  ck_assert_int_eq(s.create(&work, d, room, &settings, NULL), DLS_OK);
  const dls_contact p = {.d = d};
  dls_info info;
  for (int turn = 1; turn <= 2; turn++) {
    memset(&info, 0x55, sizeof info);
    ck_assert_int_eq(s.solve(work, &p, NULL, NULL, turn == 2 ? &info : NULL, NULL), DLS_OK);
    ck_assert_int_eq(calls, turn);
  }
  ck_assert(info.status == DLS_OK && info.method == s.method);
  ck_assert(info.iterations == 0 && info.stages == 0 && info.certificate.residual == 0);
  ck_assert(dls_certificate_holds(&info.certificate, 0));
  s.destroy(work);
}

/* ---- memory ---------------------------------------------------------------------------------- */

/* Doubles of a workspace for a dense W, the terms of m^2. Lemke's method has the LCP and its table,
 * each of n^2, n the size of the LCP: 2 nc for d = 1, 4 nc in 2D and 10 nc in 3D with 8 facets;
 * auto has them up to a limit. */
static double lcp_rows(int d, int nc) {
  return (d == 1 ? 2 : d == 2 ? 4 : 10) * nc;
}

static double matrices(dls_method method, int d, int nc, int *pivots) {
  const double m = d * nc, n = lcp_rows(d, nc);
  const int few = n <= DLS_AUTO_LEMKE_ROWS;
  *pivots = method == DLS_LEMKE || (method == DLS_AUTO && few);
  const int path = method == DLS_HOMOTOPY || (method == DLS_AUTO && m <= 300);
  return (method == DLS_NLGS || method == DLS_LEMKE ? 0 : m * m) + (*pivots ? 2 * n * n : 0) +
         (path ? 2 * m * m : 0);
}

/* The order of memory: besides matrices O(m), 200 m doubles (for d = 1 500 a candidate) or 700 n
 * for a table's pending pivots. A second matrix would be seen. A method that is not known here may
 * have one matrix or none. Each malloc may fail. */
TEST_EACH(memory, 0, doors()) {
  const tested_solver s = door(_i);
  for (int d = 1; d <= 3; d++)
    for (int k = 60; k <= 180; k += 60) {
      int pivots;
      const int nc = d == 1 ? 3 * k : k; /* so that a matrix outweighs what auto has by candidate */
      const any_settings settings = settings_for(&s, 1e-8, 0);
      const double m = (double)d * nc; /* the front door predicts errors up to 300 rows */
      const int predicts = _i >= direct_doors && s.method != DLS_AUTO && m <= 300;
      const double doubles =
          matrices(s.method, d, nc, &pivots) + (predicts ? m * m + m + 2 * nc : 0);
      const double vectors = (d == 1 ? 500 : 200 * d) * nc + (pivots ? 700 * lcp_rows(d, nc) : 0);
      const double least = s.method <= DLS_HOMOTOPY ? doubles : 0;
      expect_memory(&s, d, nc, &settings, sizeof(double) * least,
                    sizeof(double) * (doubles - least + vectors) + 20480);
    }
}

/* ---- bad input ------------------------------------------------------------------------------- */

TEST_EACH(bad_create, 0, doors()) {
  const tested_solver s = door(_i);
  expect_bad_create(&s);
}

TEST_EACH(bad_solve, 0, doors()) {
  const tested_solver s = door(_i);
  expect_bad_solve(&s);
}

TEST(defaults_without_a_place) {
  dls_nlgs_settings_init(NULL);
  dls_newton_settings_init(NULL);
  dls_admm_settings_init(NULL);
  dls_augmented_settings_init(NULL);
  dls_solver_settings_init(NULL);
}
