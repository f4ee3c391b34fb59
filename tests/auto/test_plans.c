/* test_plans.c: the report of auto on its steps; plans and omitted steps that a caller names. */
#include "delassus/solve.h"
#include "failures.h"
#include "front_cases.h"
#include "made.h"
#include "rigid.h"
#include "run.h"

enum { nc = 30, m = 3 * PLANTED };

static planted_problem storage;
static double r[m];

/* A problem that no sweeps solve, and Newton's method only now and then. */
static dls_contact hard(void) {
  return planted(&storage, 2, nc, nc, 3, 2);
}

static dls_solver_settings given(const char *plan, const char *without) {
  dls_solver_settings s = settings_with(DLS_AUTO, default_tol);
  s.plan = plan;
  s.without = without;
  return s;
}

static dls_info solve_with(const dls_contact *p, const dls_solver_settings *s) {
  dls_info info;
  ck_assert_int_ge(dls_solve(p, s, r, NULL, &info, NULL), 0);
  return info;
}

static int has_step(const dls_info *info, dls_step step) {
  for (int k = 0; k < info->stages; k++)
    if (info->stage[k].step == step) return 1;
  return 0;
}

/* The last step is solved iff the solve is, no other one; a forecast has its two numbers. */
static void check_reasons(const dls_info *info) {
  for (int k = 0; k < info->stages; k++) {
    const dls_stage *s = &info->stage[k];
    ck_assert_ptr_nonnull(dls_step_name(s->step));
    ck_assert_ptr_nonnull(dls_reason_text(s->reason));
    if (s->reason == DLS_REASON_COSTLIER)
      ck_assert(s->ahead > s->next && s->next > 0);
    else
      ck_assert(s->ahead == 0 && s->next == 0);
  }
  const dls_reason last = info->stage[info->stages - 1].reason;
  ck_assert_int_eq(last == DLS_REASON_SOLVED, info->status == DLS_OK);
}

TEST(steps_have_names_and_reasons) {
  for (int k = 0; k < 12; k++) {
    const dls_contact p = planted_case(&storage, k);
    const dls_info info = solve_auto(&p, 1e-10, r);
    check_reasons(&info);
    ck_assert_int_eq(info.regime, DLS_REGIME_ELASTIC);
    ck_assert_int_eq(info.stage[0].step, DLS_STEP_ANDERSON);
    ck_assert(info.stage[0].reason != DLS_REASON_SOLVED || info.stages == 1);
    for (int i = 0; i < info.stages; i++)
      ck_assert(info.stage[i].cpu_seconds == 0); /* nobody asks: no clock is read */
  }
}

/* Words that the steps go by are distinct and without gaps; a plan takes all but two. */
TEST(words) {
  int count = 0;
  const dls_contact p = hard();
  for (; dls_step_name((dls_step)count); count++) {
    const char *name = dls_step_name((dls_step)count);
    const dls_solver_settings s = given(name, NULL), less = given(NULL, name);
    const int no_word = count == DLS_STEP_INTERIOR || count == DLS_STEP_ON_K;
    dls_info info;
    const dls_status status = dls_solve(&p, &s, r, NULL, &info, NULL);
    ck_assert_int_eq(status == DLS_E_ARGUMENT, no_word);
    if (!no_word) ck_assert_int_eq(info.stages, 1);
    if (!no_word) ck_assert_int_eq(info.regime, DLS_REGIME_GIVEN);
    if (!no_word && count != DLS_STEP_SWEEPS) ck_assert_int_eq((int)info.stage[0].step, count);
    ck_assert_int_eq(dls_solve(&p, &less, r, NULL, &info, NULL) == DLS_E_ARGUMENT, no_word);
    if (!no_word) ck_assert(!has_step(&info, (dls_step)count));
    for (int k = 0; k < count; k++)
      ck_assert_str_ne(dls_step_name((dls_step)k), name);
  }
  ck_assert_int_eq(count, DLS_STEP_ON_K + 1);
  ck_assert_ptr_null(dls_step_name((dls_step)-1));
  for (count = 0; dls_reason_text((dls_reason)count); count++)
    for (int k = 0; k < count; k++)
      ck_assert_str_ne(dls_reason_text((dls_reason)k), dls_reason_text((dls_reason)count));
  ck_assert_int_eq(count, DLS_REASON_RUNS_AWAY + 1);
  for (count = 0; dls_regime_name((dls_regime)count); count++) {
  }
  ck_assert_int_eq(count, DLS_REGIME_GIVEN + 1);
}

/* The steps are those of the plan, in its order, with its iterations, until one solves. */
TEST(a_plan_is_followed) {
  const dls_contact p = hard();
  const dls_solver_settings s = given("sweeps:30, newton:2 ,momentum:7,anderson:3", NULL);
  static const dls_step steps[] = {DLS_STEP_ANDERSON, DLS_STEP_NEWTON, DLS_STEP_MOMENTUM,
                                   DLS_STEP_ANDERSON};
  static const int most[] = {30, 2, 7, 3};
  const dls_info info = solve_with(&p, &s);
  ck_assert_int_eq(info.stages, 4);
  for (int k = 0; k < 4; k++) {
    ck_assert_int_eq(info.stage[k].step, steps[k]);
    ck_assert_int_eq(info.stage[k].iterations, most[k]);
    ck_assert_int_eq(info.stage[k].reason, DLS_REASON_SPENT);
  }
  ck_assert_int_eq(info.status, DLS_STALLED);
}

/* The last step of a plan has no forecast; one before it has. */
/* An answer whose reactions may have a large error is made better by auto, and told by a plan. */
TEST(a_plan_is_followed_once) {
  failure f; /* an answer of residual 1e-8 has reactions to 1e-3 */
  char why[200];
  ck_assert_msg(failure_read(TEST_DATA "/failures", "c25-unsymmetric", &f, why), "%s", why);
  const dls_contact p = failure_contact(&f);
  const dls_solver_settings s = given("scatter", NULL);
  const dls_info info = solve_with(&p, &s);
  ck_assert(info.status == DLS_OK && info.error > 1e-4);
  ck_assert_int_eq(info.stages, 1);
}

/* Momentum that is interrupted goes on from where it was: the same sweeps as in one go. Begun
 * again, mixed3-rest takes 7279 of them in place of 4681. */
TEST_EACH(momentum_goes_on, 0, 3) {
  static const char *const kinds[] = {"packing-rest", "mixed3-rest", "rubble-pushed"};
  rigid a;
  int sweeps[2] = {0};
  ck_assert_int_eq(rigid_create(&a, kinds[_i], 400, 0.5, 6), 0);
  double *x = calloc((size_t)(a.d * a.contact.nc), sizeof *x);
  ck_assert_ptr_nonnull(x);
  for (int k = 0; k < 2; k++) {
    dls_solver_settings s = given(k ? "momentum:150,momentum" : "momentum", NULL);
    dls_info info;
    s.limits.tol = 1e-6;
    ck_assert_int_eq(dls_solve(&a.contact, &s, x, NULL, &info, NULL), DLS_OK);
    ck_assert_int_eq(info.stages, k + 1);
    sweeps[k] = info.iterations;
  }
  ck_assert_int_le(abs(sweeps[1] - sweeps[0]), sweeps[0] / 50);
  free(x);
  rigid_free(&a);
}

TEST(forecasts_in_a_plan) {
  const dls_contact p = hard();
  const dls_solver_settings one = given("anderson", NULL), two = given("anderson,newton:1", NULL);
  const dls_info alone = solve_with(&p, &one), both = solve_with(&p, &two);
  ck_assert_int_eq(both.stage[0].reason, DLS_REASON_COSTLIER);
  ck_assert(both.stage[0].ahead > both.stage[0].next);
  ck_assert_int_gt(alone.stage[0].iterations, both.stage[0].iterations);
  ck_assert_int_ne(alone.stage[0].reason, DLS_REASON_COSTLIER);
}

/* A plan less a step is the plan without the word; one that names every step takes none. */
TEST(a_plan_less_a_step) {
  const dls_contact p = hard();
  const dls_solver_settings whole = given("anderson:9,newton:3", NULL);
  const dls_solver_settings less = given("anderson:9,splitting:4,newton:3", "splitting");
  const dls_solver_settings none = given("sweeps:9", "sweeps");
  const dls_info a = solve_with(&p, &whole), b = solve_with(&p, &less), c = solve_with(&p, &none);
  same_stages(&a, &b);
  ck_assert(a.certificate.residual == b.certificate.residual);
  ck_assert_int_eq(c.stages, 0);
  ck_assert_int_eq(c.status, DLS_STALLED);
}

/* Three steps of a load, each from the answer before; r: 3 x 4, of all of them. Returns the last
 * status. */
static dls_status follow_load(const dls_solver_settings *s, double *u, dls_info *info,
                              double *all) {
  double W[16] = {2, .5, .3, 0, .5, 1, 0, .2, .3, 0, 1.5, .4, 0, .2, .4, 1};
  double q[4] = {-1, .3, -.5, -.2}, mu[2] = {.4, .6};
  const dls_contact p = {.d = 2, .nc = 2, .W = {4, 4, 4, W}, .q = q, .mu = mu};
  dls_solver *solver;
  dls_status status = dls_solver_create(&solver, 2, 2, s, NULL);
  memset(all, 0, 12 * sizeof *all);
  for (int step = 0; step < 3 && status >= 0; step++) {
    double *now = all + 4 * step;
    if (step) memcpy(now, now - 4, 4 * sizeof *now);
    q[0] -= .1;
    status = dls_solver_solve(solver, &p, now, u, info, NULL);
    (void)dls_solver_direction(solver);
    (void)dls_solver_farkas(solver);
  }
  dls_solver_destroy(solver);
  return status;
}

/* Every word of a plan with every step left out, warm and cold: a NULL for u changes no bit of r,
 * and one for info not how the solve ends (solve.h: it is not improved by its predicted error). */
TEST(outputs_that_nobody_wants) {
  enum { names = DLS_STEP_ON_K + 1, more = 4 };
  const char *plans[names + more] = {"homotopy,scatter", "sweeps:1,scatter",
                                     "newton:1,splitting,newton"};
  const char *left[names + more] = {
      "newton,sweeps", "newton,anderson,momentum,sweeps,convex",
      "newton,lemke,homotopy,splitting,augmented-lagrangian,anderson,momentum,sweeps,convex,"
      "cold-splitting,near-splitting"};
  for (int k = 0; k < names; k++)
    if (k != DLS_STEP_INTERIOR && k != DLS_STEP_ON_K)
      plans[more + k] = left[more + k] = dls_step_name((dls_step)k);
  for (int a = 0; a < names + more; a++)
    for (int b = 0; b < names + more; b++)
      for (int warm = 0; warm < 2; warm++) {
        double u[4], all[2][12];
        dls_info info;
        dls_solver_settings s = given(plans[a], left[b]);
        s.limits.warm_start = warm;
        const dls_status status = follow_load(&s, u, &info, all[0]);
        ck_assert_int_ge(status, 0);
        for (int k = 0; k < 2; k++) {
          ck_assert_int_eq(follow_load(&s, u, k ? &info : NULL, all[0]), status);
          ck_assert_int_eq(follow_load(&s, NULL, k ? &info : NULL, all[1]), status);
          ck_assert_mem_eq(all[0], all[1], sizeof all[0]);
        }
      }
}

/* Auto's own plans without one of the steps that it takes: the others as before, up to there. */
TEST(without_a_step) {
  const dls_contact p = hard();
  const dls_solver_settings own = given(NULL, NULL);
  const dls_info all = solve_with(&p, &own);
  ck_assert_int_ge(all.stages, 3);
  for (int k = 0; k < all.stages; k++) {
    const dls_solver_settings less = given(NULL, dls_step_name(all.stage[k].step));
    const dls_info info = solve_with(&p, &less);
    ck_assert(!has_step(&info, all.stage[k].step));
    for (int i = 0; i < k && i < info.stages && all.stage[i].step != all.stage[k].step; i++)
      ck_assert_int_eq(info.stage[i].step, all.stage[i].step);
  }
}

/* Errors name the setting, the word and the right ones; r and info stay. */
TEST(wrong_words) {
  static const struct {
    const char *plan, *without, *says;
  } wrong[] = {{"sweeps,newtn", NULL, "'newtn' is no step: sweeps anderson"},
               {"", NULL, "'' is no step"},
               {"newton,", NULL, "'' is no step"},
               {"interior-point", NULL, "'interior-point' is no step"},
               {"sweeps:0", NULL, "whole number >= 1"},
               {"sweeps:", NULL, "whole number >= 1"},
               {"sweeps:-3", NULL, "whole number >= 1"},
               {"sweeps:99999999999999999999", NULL, "whole number >= 1"},
               {"sweeps:3x", NULL, "a comma ends a step"},
               {"sweeps newton", NULL, "a comma ends a step"},
               {NULL, "homotopy:3", "takes no iterations"},
               {NULL, "Homotopy", "'Homotopy' is no step"},
               {NULL, "", "'' is no step"},
               {"newton", "scater", "'scater' is no step"}};
  const dls_contact p = hard();
  for (size_t k = 0; k < sizeof wrong / sizeof wrong[0]; k++) {
    const dls_solver_settings s = given(wrong[k].plan, wrong[k].without);
    dls_error error = {0};
    dls_info info = {.stages = -7};
    dls_solver *solver;
    r[0] = -7;
    ck_assert_int_eq(dls_solve(&p, &s, r, NULL, &info, &error), DLS_E_ARGUMENT);
    ck_assert_msg(strstr(error.message, wrong[k].says), "%s", error.message);
    if (strstr(wrong[k].says, "no step"))
      ck_assert_msg(strstr(error.message, "scatter"), "%s", error.message);
    ck_assert_str_eq(error.argument, wrong[k].without ? "without" : "plan");
    ck_assert(r[0] == -7 && info.stages == -7);
    ck_assert_int_eq(dls_solver_create(&solver, 2, nc, &s, NULL), DLS_E_ARGUMENT);
    ck_assert_ptr_null(solver);
  }
  dls_solver_settings s = given("newton", NULL);
  dls_error error = {0};
  s.method = DLS_NLGS;
  ck_assert_int_eq(dls_solve(&p, &s, r, NULL, NULL, &error), DLS_E_ARGUMENT);
  ck_assert(strstr(error.message, "is for auto") && strcmp(error.argument, "plan") == 0);
  char many[500] = "lemke";
  for (int k = 0; k < DLS_STAGES_MAX; k++)
    strcat(many, ",lemke");
  s = given(many, NULL);
  ck_assert_int_eq(dls_solve(&p, &s, r, NULL, NULL, &error), DLS_E_ARGUMENT);
  ck_assert_ptr_nonnull(strstr(error.message, "more than 40 steps"));
}

/* A solver keeps no pointer to the words, solves the same again, and unwinds without memory. */
TEST(words_are_read_once) {
  const dls_contact p = hard();
  char plan[] = "anderson:4,newton:2", without[] = "scatter";
  const dls_solver_settings s = given(plan, without);
  dls_solver *solver;
  MALLOCS_FAIL(dls_solver_create(&solver, 2, nc, &s, NULL), !solver, DLS_OK, 1);
  memset(plan, 'x', sizeof plan);
  memset(without, 'x', sizeof without);
  dls_info info[2];
  malloc_fails_at(0);
  const dls_status status = dls_solver_solve(solver, &p, r, NULL, &info[0], NULL);
  const dls_status again = dls_solver_solve(solver, &p, r, NULL, &info[1], NULL);
  const long calls = malloc_calls(); /* Check allocates, too */
  ck_assert(status == DLS_STALLED && again == DLS_STALLED && calls == 0);
  same_stages(&info[0], &info[1]);
  ck_assert_int_eq(info[0].stages, 2);
  dls_solver_destroy(solver);
}

/* Steps that cannot be taken leave a line, and the plan goes on. */
TEST(not_applicable) {
  dls_contact p = hard();
  dls_solver_settings s = given("convex,anderson:3", NULL);
  dls_info info = solve_with(&p, &s);
  ck_assert_int_eq(info.stages, 2);
  ck_assert_int_eq(info.stage[0].step, DLS_STEP_CONVEX);
  ck_assert_int_eq(info.stage[0].reason, DLS_REASON_NOT_APPLICABLE);
  ck_assert_int_eq(info.stage[0].iterations, 0);
  ck_assert_int_eq(info.stage[1].iterations, 3);
  storage.mu[4] = INFINITY;
  s = given("lemke,homotopy,scatter,anderson:2", NULL);
  info = solve_with(&p, &s);
  ck_assert_int_eq(info.stages, 4);
  for (int k = 0; k < 3; k++)
    ck_assert_int_eq(info.stage[k].reason, DLS_REASON_NOT_APPLICABLE);
}

static int cancel(void *data, const dls_progress *progress) {
  (void)data;
  return progress->iteration >= 3;
}

TEST(limits_of_the_caller) {
  const dls_contact p = hard();
  dls_solver_settings s = given(NULL, NULL);
  s.limits.max_iterations = 12;
  dls_info info = solve_with(&p, &s);
  ck_assert_int_eq(info.status, DLS_MAX_ITERATIONS);
  ck_assert_int_eq(info.stage[info.stages - 1].reason, DLS_REASON_ITERATIONS);
  s = given(NULL, NULL);
  s.limits.cpu_seconds = 1e-9;
  info = solve_with(&p, &s);
  ck_assert_int_eq(info.status, DLS_TIME_LIMIT);
  ck_assert_int_eq(info.stage[info.stages - 1].reason, DLS_REASON_TIME);
  s = given(NULL, NULL);
  s.limits.progress = cancel;
  info = solve_with(&p, &s);
  ck_assert_int_eq(info.status, DLS_CANCELLED);
  ck_assert_int_eq(info.stage[info.stages - 1].reason, DLS_REASON_CANCELLED);
  ck_assert_int_eq(info.stage[info.stages - 1].iterations, 3);
}

/* Candidate 7 cannot be pushed up. A plan proves it, too, and returns the proof. */
TEST(proofs) {
  dls_contact p = hard();
  const int row = 2 * 7;
  for (int j = 0; j < 2 * nc; j++)
    storage.W[row + 2 * nc * j] = storage.W[j + 2 * nc * row] = 0;
  storage.q[row] = -1;
  for (int k = 0; k < 2; k++) {
    const dls_solver_settings s = given(k ? "anderson:3,lemke" : NULL, NULL);
    dls_info info;
    dls_solver *solver = solver_of(2, nc, &s);
    ck_assert_int_eq(dls_solver_solve(solver, &p, r, NULL, &info, NULL), DLS_NO_SOLUTION);
    ck_assert_int_eq(info.stage[info.stages - 1].step, DLS_STEP_LEMKE);
    ck_assert_int_eq(info.stage[info.stages - 1].reason, DLS_REASON_NO_SOLUTION);
    const double *v = dls_solver_farkas(solver);
    ck_assert(v && v[7] > 0);
    dls_solver_destroy(solver);
  }
}

/* A limit of time asks for the clock. */
TEST(seconds_of_each_step) {
  const dls_contact p = hard();
  dls_solver_settings s = given(NULL, NULL);
  double all = 0;
  s.limits.cpu_seconds = 1e3;
  const dls_info info = solve_with(&p, &s);
  for (int k = 0; k < info.stages; k++) {
    ck_assert(info.stage[k].cpu_seconds >= 0);
    all += info.stage[k].cpu_seconds;
  }
  ck_assert(all > 0 && all < 1e3);
}

/* Rigid bodies: momentum has its name, structures at rest are convex, and say so. */
TEST_EACH(names_of_what_ran, 0, 4) {
  static const struct {
    const char *kind;
    int candidates;
    dls_regime regime;
    dls_step step;
    int at_rest;
  } of[] = {{"packing-flow", 300, DLS_REGIME_TIGHT, DLS_STEP_MOMENTUM, 0},
            {"packing-flow", 80, DLS_REGIME_FEW, DLS_STEP_ANDERSON, 0},
            {"chain", 2000, DLS_REGIME_TIGHT, DLS_STEP_CONVEX, 1},
            {"wall-pushed", 300, DLS_REGIME_PACKING, DLS_STEP_ANDERSON, 1}};
  rigid a;
  dls_info info;
  ck_assert_int_eq(rigid_create(&a, of[_i].kind, of[_i].candidates, 0.5, 2), 0);
  double *x = calloc((size_t)(a.d * a.contact.nc), sizeof *x);
  ck_assert_ptr_nonnull(x);
  ck_assert_int_ge(dls_solve(&a.contact, NULL, x, NULL, &info, NULL), 0);
  ck_assert_int_eq(info.regime, of[_i].regime);
  ck_assert_int_eq(info.at_rest, of[_i].at_rest);
  if (WITH_MUMPS) ck_assert(has_step(&info, of[_i].step));
  const dls_solver_settings s = given("sweeps:10", NULL);
  ck_assert_int_ge(dls_solve(&a.contact, &s, x, NULL, &info, NULL), 0);
  ck_assert_int_eq(info.stage[0].step,
                   of[_i].regime == DLS_REGIME_TIGHT ? DLS_STEP_MOMENTUM : DLS_STEP_ANDERSON);
  ck_assert_int_eq(info.stage[0].iterations, 10);
  free(x);
  rigid_free(&a);
}

/* Ill-conditioned: the homotopy comes near an answer at once. The augmented Lagrangian and ADMM add
 * the last digits, so that no further path is needed. */
TEST_EACH(last_digits_after_a_short_path, 0, 4) {
  static const unsigned seeds[] = {8, 9, 22, 31};
  const dls_contact p = planted_graded(&storage, 3, 12, 18, 1e8, 0.3, seeds[_i]);
  dls_solver_settings s = given(NULL, NULL);
  s.limits.tol = 1e-11;
  const dls_info info = solve_with(&p, &s);
  ck_assert_int_eq(info.status, DLS_OK);
  ck_assert(has_step(&info, DLS_STEP_AUGMENTED));
  for (int k = 0; k < info.stages; k++)
    if (info.stage[k].step == DLS_STEP_HOMOTOPY) ck_assert_int_le(info.stage[k].iterations, 100);
}

/* Far from an answer the many paths follow the short one immediately. */
TEST(no_last_digits_far_from_an_answer) {
  failure f;
  char why[200];
  ck_assert_msg(failure_read("data/failures", "c03-jam-above", &f, why), "%s", why);
  const dls_contact p = failure_contact(&f);
  const dls_info info = solve_with(&p, NULL);
  int k = 0;
  while (k < info.stages && info.stage[k].step != DLS_STEP_HOMOTOPY)
    k++;
  ck_assert_int_lt(k + 1, info.stages);
  ck_assert_int_eq(info.stage[k].iterations, 100);
  ck_assert_double_gt(info.stage[k].residual, 0.05);
  ck_assert_int_eq(info.stage[k + 1].step, DLS_STEP_HOMOTOPY);
}

/* Each problem of a batch follows the plan, none goes into lanes. */
TEST(batches) {
  static const double W[] = {2, 0.5, 0.5, 1}, q[] = {-1, 0.3}, mu[] = {0.4};
  const dls_contact one = {.d = 2, .nc = 1, .W = {2, 2, 2, W}, .q = q, .mu = mu};
  const dls_contact all[] = {one, one};
  const dls_solver_settings s = given("newton", NULL);
  double x[4];
  double *const to[] = {x, x + 2};
  dls_info info[2];
  ck_assert_int_eq(dls_solve_batch(2, all, &s, to, NULL, info, NULL), DLS_OK);
  for (int k = 0; k < 2; k++)
    ck_assert(info[k].stages == 1 && info[k].stage[0].step == DLS_STEP_NEWTON);
}

TEST(in_words) {
  const dls_contact p = hard();
  dls_solver_settings s = given(NULL, NULL);
  s.limits.cpu_seconds = 1e3;
  dls_info info = solve_with(&p, &s);
  char text[4000], cut[40];
  const size_t length = dls_explain(&info, text, sizeof text);
  ck_assert_uint_eq(length, strlen(text));
  ck_assert(strncmp(text, "regime elastic (W is dense, 30 candidates)", 42) == 0);
  int lines = 0;
  for (const char *at = text; (at = strchr(at, '\n')); at++)
    lines++;
  ck_assert_int_eq(lines, info.stages + 2);
  for (int k = 0; k < info.stages; k++) {
    ck_assert_ptr_nonnull(strstr(text, dls_step_name(info.stage[k].step)));
    ck_assert_ptr_nonnull(strstr(text, dls_reason_text(info.stage[k].reason)));
  }
  ck_assert_ptr_nonnull(strstr(text, "s of CPU"));
  ck_assert_int_eq(info.stage[0].reason, DLS_REASON_COSTLIER);
  ck_assert_ptr_nonnull(strstr(text, "the next step (")); /* and the forecast */
  ck_assert(strstr(text, " more sweeps expected, ") || strstr(text, "no end expected, "));
  ck_assert_uint_eq(dls_explain(&info, cut, sizeof cut), length);
  ck_assert_int_eq(strncmp(cut, text, sizeof cut - 1), 0);
  ck_assert_uint_eq(strlen(cut), sizeof cut - 1);
  ck_assert_uint_eq(dls_explain(&info, NULL, 0), length);
  ck_assert_uint_eq(dls_explain(NULL, cut, sizeof cut), 0);
  ck_assert_str_eq(cut, "");
  s = given("newton:1", NULL);
  info = solve_with(&p, &s);
  dls_explain(&info, text, sizeof text);
  ck_assert(strstr(text, "the plan is the caller's") && !strstr(text, "s of CPU"));
  info.method = DLS_NLGS;
  dls_explain(&info, text, sizeof text);
  ck_assert(strncmp(text, "nlgs alone", 10) == 0);
}

/* What an info holds, and its word. */
TEST(explains_each_field) {
  char text[4000];
  dls_info info = {.method = DLS_AUTO};
  dls_explain(&info, text, sizeof text);
  ck_assert(strncmp(text, "no plan was needed", 18) == 0);
  info.stages = 1;
  info.stage[0] = (dls_stage){.step = DLS_STEP_ON_K,
                              .reason = DLS_REASON_COSTLIER,
                              .ahead = INFINITY,
                              .next = 7,
                              .on_copy = 1};
  dls_explain(&info, text, sizeof text);
  ck_assert(strncmp(text, "the problem on K itself", 23) == 0 && strstr(text, ", on a copy"));
  ck_assert_ptr_nonnull(strstr(text, "(no end expected, the next step costs 7 sweeps)"));
  info.regime = DLS_REGIME_PACKING;
  info.blocks = -1;
  info.candidates = 30;
  info.left_out = 2;
  info.at_rest = 1;
  dls_explain(&info, text, sizeof text);
  ck_assert_ptr_nonnull(strstr(text, "(W of bodies, 30 candidates): many bodies"));
  ck_assert_ptr_nonnull(strstr(text, "\nat rest ("));
  ck_assert_ptr_nonnull(strstr(text, "\n2 of 30 candidates provably cannot touch"));
  info.blocks = 56;
  dls_explain(&info, text, sizeof text);
  ck_assert_ptr_nonnull(strstr(text, "W by blocks, 2.0 for each candidate"));
}
