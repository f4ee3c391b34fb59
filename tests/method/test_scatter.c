/* test_scatter.c: Newton's method from scattered starts, a stage of auto. */
#include "auto/auto.h"
#include "cases.h"
#include "front_cases.h"
#include "linear/room.h"
#include "made.h"
#include "run.h"
#include "vi/vi_internal.h"

/* Two candidates with much friction, W of rank 3: the answer r = (0, 0, 0, 4, -8, -16), u small
 * beside q, which sweeps, Newton's method and all else do not find from r = 0. */
static void slippery(model *a) {
  static const double B[6][3] = {{1, .5, .25}, {.75, .5, .75}, {.5, .25, 0},
                                 {1, 1, .5},   {-.5, 1, .5},   {0, 1, .75}};
  static const double r[6] = {0, 0, 0, 4, -8, -16}, u[6] = {.03125, .125, .125, 0, .03125, .0625};
  set_model(a, 3, 2);
  for (int i = 0; i < 6; i++) {
    a->q[i] = u[i];
    for (int j = 0; j < 6; j++) {
      for (int k = 0; k < 3; k++)
        a->W[i + a->p.W.ld * j] += B[i][k] * B[j][k];
      a->q[i] -= a->W[i + a->p.W.ld * j] * r[j];
    }
  }
  a->mu[0] = a->mu[1] = sqrt(20);
}

typedef struct scattered {
  dlsi_room room;
  void *work;
} scattered;

static dls_status open_run(scattered *s, const dls_contact *p, const dls_limits *limits) {
  *s = (scattered){.work = NULL};
  const dlsi_options options = {.limits = *limits, .room = &s->room};
  return dlsi_scatter_method.create(&s->work, p->d, p->nc, &options, NULL);
}

static void end(scattered *s) {
  if (s->work) dlsi_scatter_method.destroy(s->work);
  dlsi_room_free(&s->room);
}

static dls_status scatter(const dls_contact *p, const dls_limits *limits, double *r,
                          dls_info *info) {
  scattered s;
  dls_status status = open_run(&s, p, limits);
  if (!status) status = dlsi_scatter_method.solve(s.work, p, r, NULL, info, NULL);
  end(&s);
  return status;
}

TEST_EACH(finds_what_is_there, 0, 12) {
  static model a;
  const dls_limits limits = {.tol = 1e-10};
  double r[most], again[most];
  dls_info info;
  if (_i)
    deficient_model(&a, _i);
  else
    slippery(&a);
  ck_assert_int_eq(scatter(&a.p, &limits, r, &info), DLS_OK);
  const dls_certificate c = certificate_of(&a.p, r);
  ck_assert(dls_certificate_holds(&c, 1e-10));
  ck_assert_int_eq(scatter(&a.p, &limits, again, NULL), DLS_OK);
  ck_assert_mem_eq(r, again, (size_t)(a.p.d * a.p.nc) * sizeof *r);
}

/* Planted problems of low rank and large friction. Starts whose slipping contacts do not slip the
 * way they were drawn (SC2) reach 24. */
TEST(planted_solutions_are_found) {
  static planted_problem a;
  const dls_limits limits = {.tol = 1e-10};
  double r[3 * PLANTED];
  int solved = 0;
  for (unsigned seed = 1; seed <= 30; seed++) {
    const dls_contact p = planted(&a, 3, 12, 9, 16, seed);
    solved += scatter(&p, &limits, r, NULL) == DLS_OK;
  }
  ck_assert_int_ge(solved, 26);
}

static int third_call(void *data, const dls_progress *progress) {
  int *calls = data;
  ck_assert_str_eq(progress->method, "scatter");
  return ++*calls == 3;
}

/* W = 0 and q_n < 0: no solution. */
TEST(keeps_to_limits) {
  static model a;
  double r[most] = {0};
  int calls = 0;
  dls_info info;
  set_model(&a, 2, 3);
  for (int c = 0; c < 3; c++) {
    a.q[2 * c] = -1;
    a.mu[c] = 0.5;
  }
  dls_limits limits = {.tol = 1e-8, .progress = third_call, .progress_data = &calls};
  ck_assert_int_eq(scatter(&a.p, &limits, r, &info), DLS_CANCELLED);
  ck_assert_int_eq(calls, 3);
  limits = (dls_limits){.tol = 1e-8, .max_iterations = 7};
  ck_assert_int_eq(scatter(&a.p, &limits, r, &info), DLS_MAX_ITERATIONS);
  ck_assert_int_lt(info.iterations, 7 + 20);
  limits = (dls_limits){.tol = 1e-8};
  ck_assert_int_eq(scatter(&a.p, &limits, r, &info), DLS_STALLED);
}

TEST(failing_mallocs_unwind) {
  static model a;
  const dls_limits limits = {.tol = 1e-10};
  double r[most] = {9};
  slippery(&a);
  MALLOCS_FAIL(scatter(&a.p, &limits, r, NULL), r[0] == 9, DLS_OK, 4);
}
