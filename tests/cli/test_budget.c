/*
 * test_budget.c: the error budget of `delassus report` on a scene that is a formula. With h the
 * element size, k the step and t the tolerance over the scene's own, and the clock a sum of costs:
 *
 *   value = 3 (1 + .04 h^2 + .01 k + 1e-6 t)     seconds = 1 / (h^2 k)
 *
 * so that every error, order, limit and cost is known.
 */
#include "report/report.h"
#include "run.h"

enum { own_nx = 1 << 16, own_steps = 1 << 12 };
static const double own_tol = 1e-6;
static double now;         /* the clock */
static double sign = 1;    /* of the errors */
static double offset;      /* relative, of the limit of graded meshes */
static double wiggle;      /* relative, to and fro from level to level: there is no order */
static int most_nx;        /* finer meshes fail */
static int fails_late;     /* 1: when all that they may take is gone */
static double exact = NAN; /* the scene's closed form */

double cpu_seconds(void) {
  return now;
}

int was_interrupted(void) {
  return 0;
}

void progress_part(const char *part) {
  ck_assert_ptr_nonnull(part);
}

int ascending(const void *a, const void *b) {
  const double x = *(const double *)a, y = *(const double *)b;
  return (x > y) - (x < y);
}

int setting_is(const setting *a, const setting *b) {
  return a->nx == b->nx && a->steps == b->steps && a->tol == b->tol && a->grade == b->grade;
}

setting setting_scaled(const scene *s, int mesh, int steps, int tol) {
  setting at = s->own;
  at.nx = (int)round(at.nx * pow(2, 0.5 * mesh));
  at.steps = (int)round(at.steps * pow(2, steps + (s->dynamic ? 0.5 * mesh : 0)));
  at.tol *= pow(10, -tol);
  return at;
}

const char *setting_variant(const scene *s, int k, setting *at) {
  *at = s->own;
  at->mu = 0;
  return k == 0 ? "no friction" : NULL;
}

/* Relative error of a setting; its CPU. */
static double true_error(const setting *at) {
  const double h = (double)own_nx / at->nx, k = at->steps ? (double)own_steps / at->steps : 0;
  return .04 * h * h * (at->grade > 0 ? .25 : 1) + .01 * k + 1e-6 * at->tol / own_tol;
}

static double true_seconds(const setting *at) {
  const double n = (double)at->nx / own_nx;
  return n * n * (at->steps ? (double)at->steps / own_steps : 1) * (at->grade > 0 ? 1.5 : 1);
}

dls_status scene_run(const scene *s, const setting *at, double limit, scene_answer *out,
                     dls_error *error) {
  (void)s, (void)error;
  ck_assert(limit > 0);
  const double fine = log2((double)at->nx / own_nx) * 2 + log2(at->steps / (double)own_steps + 1);
  const int fails = at->nx > most_nx;
  *out = (scene_answer){.status = fails ? DLS_STALLED : DLS_OK, .seconds = true_seconds(at)};
  out->value = 3 * (1 + sign * true_error(at)) * (at->grade > 0 ? 1 + offset : 1);
  out->value += 3 * wiggle * cos(acos(-1) * fine);
  if (fails) out->value = NAN;
  if (fails && fails_late) out->seconds = limit;
  now += out->seconds;
  return DLS_OK;
}

double answer_distance(const scene_answer *a, const scene_answer *b, quantity_of of) {
  (void)of;
  return fabs(a->value - b->value) / fabs(b->value);
}

static void plain_scene(void) {
  sign = 1, offset = wiggle = 0, most_nx = INT_MAX, fails_late = 0, exact = NAN;
}

/* A budget that has run: of a scene with two meshes and no steps, or one mesh and steps, which may
 * go with it. */
static const budget *run_budget(scene_kind kind, int dynamic, double accuracy, double seconds) {
  static scene s;
  static budget b;
  s = (scene){.kind = kind, .own = {.nx = own_nx, .tol = own_tol}, .exact = exact};
  s.own.steps = kind == SCENE_AT_ONCE ? 0 : own_steps;
  s.dynamic = dynamic;
  s.grade = kind == SCENE_AT_ONCE ? 3 : 0;
  s.has = 1 << OF_FORCE | 1 << OF_CURVE;
  b = (budget){.scene = &s, .accuracy = accuracy, .limit = seconds, .start = now};
  now = 1000;
  ck_assert_int_eq(budget_run(&b, NULL), DLS_OK);
  return &b;
}

static double spent(const budget *b, const char *part) {
  double all = 0;
  for (int k = 0; k < b->probes; k++)
    if (strcmp(b->probe[k].part, part) == 0) all += b->probe[k].got.seconds;
  return all;
}

/* Limit, order and doubt of a ladder are those of the formula. */
static void check_ladder(const budget *b, const ladder *l, double order) {
  const setting *finest = &b->probe[ladder_probe(b, l, l->high)].at;
  const double value = 3 * (1 + sign * true_error(finest));
  ck_assert_msg(fabs(l->order - order) < .05, "%s: order %g", l->part, l->order);
  ck_assert(l->monotone);
  ck_assert(fabs(l->doubt - 1.25 * fabs(l->limit - value) / l->limit) < 1e-9);
  ck_assert(l->doubt < b->accuracy / 4);
}

/* With time enough: what is taken is within the accuracy, and nothing cheaper on the ladders is. */
TEST_EACH(the_cheapest_is_taken, 0, 20) {
  const double accuracy[] = {.1, .05, .02, .01};
  const int two = _i >= 16 || _i / 4 % 2;
  sign = _i < 8 ? 1 : -1;
  exact = _i < 16 ? NAN : 3;
  const budget *b = run_budget(two ? SCENE_AT_ONCE : SCENE_FORMING, 0, accuracy[_i % 4], 1e6);
  const setting *take = &b->probe[b->take].at;
  const ladder *both[] = {&b->mesh, &b->second}, *steps = &b->steps;
  const double doubt = fmax(b->doubt[OF_FORCE], b->doubt[OF_CURVE]);
  ck_assert(b->met && !b->disagree && b->check >= 0);
  if (_i < 16) check_ladder(b, &b->mesh, 2);
  ck_assert_msg(fabs(b->reference / 3 - 1) < 1e-4, "%.9g", b->reference);
  ck_assert(true_error(take) <= b->accuracy && b->error <= b->accuracy);
  ck_assert(b->error >= .99 * true_error(take));
  if (!two) check_ladder(b, steps, 1);
  for (int k = 0; k < 2; k++)
    for (int i = both[k]->low; i <= both[k]->high; i++)
      for (int j = two ? 0 : steps->low; j <= (two ? 0 : steps->high); j++) {
        setting at = setting_scaled(b->scene, i, j, 0);
        at.grade = k ? b->scene->grade : 0;
        ck_assert_msg(true_error(&at) + doubt > .98 * b->accuracy ||
                          true_seconds(&at) >= .99 * true_seconds(take),
                      "mesh %d, steps %d: %g for %g s, taken %g s", i, j, true_error(&at),
                      true_seconds(&at), true_seconds(take));
      }
  ck_assert_int_eq(b->second.low > b->second.high, !two);
}

/* Without: the mesh has what steps and tolerances leave, the finest setting is taken, and what
 * would be enough is so, while half a level less is not. */
TEST_EACH(what_would_be_enough, 0, 2) {
  const double seconds = 400;
  const budget *b = run_budget(_i ? SCENE_MOVING : SCENE_FORMING, _i, 1e-4, seconds);
  ck_assert(!b->met && b->take >= 0);
  ck_assert(spent(b, "steps") <= .12 * seconds && spent(b, "tolerance") <= .06 * seconds);
  ck_assert(now - 1000 <= seconds && spent(b, "mesh") > .55 * seconds); /* the others leave it */
  ck_assert_int_eq(b->take, ladder_probe(b, &b->mesh, b->mesh.high));
  const setting enough = b->enough;
  ck_assert_int_gt(enough.nx, b->probe[b->take].at.nx);
  ck_assert(b->enough_seconds > .5 * true_seconds(&enough));
  ck_assert(b->enough_seconds < 2 * true_seconds(&enough));
}

/* Two meshes with unlike limits: the reference is as doubtful as they are apart. */
TEST_EACH(meshes_that_disagree, 0, 2) {
  offset = _i ? -.02 : .02;
  const budget *b = run_budget(SCENE_AT_ONCE, 0, .01, 1e6);
  ck_assert(b->disagree && !b->met);
  ck_assert(fabs(b->doubt[OF_FORCE] - .02) < 1e-3);
}

/* Steps that go with the mesh, at any sign of the errors. */
TEST_EACH(steps_with_the_mesh, 0, 4) {
  sign = _i % 2 ? -1 : 1;
  exact = _i < 2 ? NAN : 3;
  const budget *b = run_budget(SCENE_MOVING, 1, .02, 1e6);
  const setting *take = &b->probe[b->take].at;
  ck_assert(b->met && true_error(take) <= .02);
  ck_assert(fabs(b->reference / 3 - 1) < 5e-3);
  const setting half = setting_scaled(b->scene, -1, 0, 0);
  ck_assert_int_eq(b->probe[ladder_probe(b, &b->mesh, -1)].at.steps, half.steps);
}

/* Values to and fro: no order, the finest value with three times the largest change as doubt. */
TEST(values_without_an_order) {
  wiggle = .004;
  const budget *b = run_budget(SCENE_FORMING, 0, .2, 1e6);
  const ladder *l = &b->mesh;
  const setting *finest = &b->probe[ladder_probe(b, l, l->high)].at;
  ck_assert(isnan(l->order));
  ck_assert(fabs(l->limit / b->probe[ladder_probe(b, l, l->high)].got.value - 1) < 1e-12);
  ck_assert(l->doubt >= 3 * .004 && l->doubt < .25 * b->accuracy);
  ck_assert_int_gt(finest->nx, own_nx);
}

/* Where finer meshes fail, the ladder ends below, and the rest goes on. */
TEST(fine_meshes_fail) {
  most_nx = 2 * own_nx;
  const budget *b = run_budget(SCENE_FORMING, 0, .001, 1e6);
  ck_assert(!b->met);
  ck_assert_int_eq(b->mesh.high, 2);
  ck_assert_int_eq(b->probe[b->take].at.nx, most_nx);
  ck_assert_int_eq(b->check, -1);
}

/* A mesh that never ends costs its ladder twice what was foreseen, not all that is left. */
TEST(a_mesh_that_never_ends) {
  most_nx = 2 * own_nx;
  fails_late = 1;
  const budget *b = run_budget(SCENE_AT_ONCE, 0, .001, 200);
  ck_assert_int_eq(b->mesh.high, 2);
  ck_assert_int_eq(b->second.high, 2);
  ck_assert(spent(b, "mesh") < .275 * 200 && spent(b, "graded mesh") < .275 * 200);
  ck_assert(isfinite(b->error) && fabs(b->reference / 3 - 1) <= b->doubt[OF_FORCE]);
}

int main(void) {
  return run_tests("budget", plain_scene, NULL);
}
