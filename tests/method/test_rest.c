/* test_rest.c: structures at rest, a stage of auto. */
#include "auto/auto.h"
#include "cases.h"
#include "delassus/solve.h"
#include "made.h"
#include "rigid.h"
#include "run.h"

/* A problem with room for its reactions. */
typedef struct structure {
  rigid a;
  size_t m;
  double *r;
} structure;

static structure build(const char *kind, int candidates, double mu) {
  structure s;
  ck_assert_int_eq(rigid_create(&s.a, kind, candidates, mu, 2), 0);
  s.m = (size_t)(s.a.d * s.a.contact.nc);
  s.r = calloc(s.m, sizeof *s.r);
  ck_assert_ptr_nonnull(s.r);
  return s;
}

static void tear_down(structure *s) {
  free(s->r);
  rigid_free(&s->a);
}

static dls_status rest(structure *s, const dls_limits *limits, dls_info *info) {
  const dls_contact *p = &s->a.contact;
  const dlsi_options options = {.limits = *limits};
  void *work;
  dls_status status = dlsi_rest_method.create(&work, p->d, p->nc, &options, NULL);
  if (status) return status;
  status = dlsi_rest_method.solve(work, p, s->r, NULL, info, NULL);
  dlsi_rest_method.destroy(work);
  return status;
}

/* Splitting is enough; its count grows little with the size. */
TEST_EACH(structures, 0, 10) {
  static const char *const kinds[] = {"wall-rest",  "wall-pushed", "rubble-rest", "rubble-pushed",
                                      "wall3-rest", "chain",       "chain3",      "arch",
                                      "arch3",      "tower"};
  const dls_limits limits = {.tol = 1e-8};
  for (int size = 200; size <= 3200; size *= 4) {
    structure s = build(kinds[_i], size, 0.5);
    dls_info info;
    ck_assert_msg(rest(&s, &limits, &info) == DLS_OK, "%s, %d", kinds[_i], size);
    const dls_certificate c = certificate_of(&s.a.contact, s.r);
    ck_assert(dls_certificate_holds(&c, 1e-8));
    ck_assert_int_le(info.iterations, 100);
    ck_assert_int_le(info.factorisations, 3);
    tear_down(&s);
  }
}

/* The interior point: a wall near the load at which it slides, 2D, and one pushed across, 3D. */
TEST_EACH(near_the_limit, 0, 2) {
  const dls_limits limits = {.tol = 1e-8};
  structure s = _i ? build("wall3-pushed", 1500, 0.32) : build("wall-pushed", 2500, 0.305);
  dls_info info;
  ck_assert_int_eq(rest(&s, &limits, &info), DLS_OK);
  const dls_certificate c = certificate_of(&s.a.contact, s.r);
  ck_assert(dls_certificate_holds(&c, 1e-8));
  ck_assert_int_gt(info.factorisations, 8);
  ck_assert_int_le(info.factorisations, 30);
  tear_down(&s);
}

/* A wall that slides, where the convex problem has another answer: not solved, and no worse than
 * r = 0. */
TEST(slides) {
  const dls_limits limits = {.tol = 1e-8};
  structure s = build("wall-pushed", 600, 0.2);
  dls_info info;
  const dls_certificate zero = certificate_of(&s.a.contact, s.r);
  ck_assert_int_eq(rest(&s, &limits, &info), DLS_STALLED);
  const dls_certificate c = certificate_of(&s.a.contact, s.r);
  ck_assert(!dls_certificate_holds(&c, 1e-8));
  ck_assert(c.residual == info.certificate.residual && c.residual < zero.residual);
  tear_down(&s);
}

/* Units of W and q that are powers of two change no bit; candidates without friction have no
 * tangential reaction. */
TEST(units_and_smooth_candidates) {
  const dls_limits limits = {.tol = 1e-8};
  structure s = build("wall3-rest", 300, 0.5), t = build("wall3-rest", 300, 0.5);
  dls_info one, other;
  for (int c = 0; c < s.a.contact.nc; c += 3)
    s.a.mu[c] = t.a.mu[c] = 0;
  for (size_t k = 0; k < t.m; k++)
    t.a.q[k] = ldexp(t.a.q[k], 30);
  for (size_t k = 0; k < 9 * (size_t)t.a.p[t.a.contact.nc]; k++)
    t.a.x[k] = ldexp(t.a.x[k], -30);
  ck_assert_int_eq(rest(&s, &limits, &one), DLS_OK);
  ck_assert_int_eq(rest(&t, &limits, &other), DLS_OK);
  ck_assert_int_eq(one.iterations, other.iterations);
  for (size_t k = 0; k < s.m; k++) {
    ck_assert(ldexp(s.r[k], 60) == t.r[k]);
    if (s.a.mu[k / 3] == 0 && k % 3) ck_assert(s.r[k] == 0);
  }
  tear_down(&s);
  tear_down(&t);
}

/* W not symmetric, and a candidate whose W_cc is 0: given back at once. */
TEST_EACH(not_its_problem, 0, 2) {
  const dls_limits limits = {.tol = 1e-8};
  structure s = build("wall-rest", 200, 0.5);
  const int *p = s.a.p;
  dls_info info;
  for (int k = p[7]; k < p[8]; k++)
    if (_i ? s.a.i[k] == 7 : s.a.i[k] != 7)
      for (int e = 0; e < 4; e++)
        s.a.x[4 * k + e] *= _i ? 0 : 1.1;
  ck_assert_int_eq(rest(&s, &limits, &info), DLS_STALLED);
  ck_assert_int_eq(info.factorisations, 0);
  tear_down(&s);
}

static int third(void *data, const dls_progress *progress) {
  *(int *)data = progress->iteration;
  return progress->iteration == 3;
}

TEST(cancelled) {
  int iteration = 0;
  const dls_limits limits = {.tol = 1e-8, .progress = third, .progress_data = &iteration};
  structure s = build("arch", 200, 0.5);
  dls_info info;
  ck_assert_int_eq(rest(&s, &limits, &info), DLS_CANCELLED);
  ck_assert_int_eq(iteration, 3);
  ck_assert_int_eq(info.iterations, 3);
  tear_down(&s);
}

/* It ends in this way before its first iteration, after so many factorisations. */
static void ends_at_once(const char *kind, int size, double cpu_seconds, dls_status status,
                         int factorisations) {
  const dls_limits limits = {.tol = 1e-8, .cpu_seconds = cpu_seconds};
  structure s = build(kind, size, 0.5);
  dls_info info;
  ck_assert_int_eq(rest(&s, &limits, &info), status);
  ck_assert_int_eq(info.factorisations, factorisations);
  ck_assert_int_eq(info.iterations, 0);
  tear_down(&s);
}

/* A factorisation that would take more than the sweeps it saves is not begun, (AR11). */
TEST(too_much_fill) {
  ends_at_once("packing-rest", 30000, 0, DLS_STALLED, 0);
}

/* The time is over before the first factorisation is done. */
TEST(time_is_over_in_a_factorisation) {
  ends_at_once("wall3-rest", 3200, 1e-4, DLS_TIME_LIMIT, 1);
}

TEST_EACH(failing_mallocs, 0, 2) {
  const dls_limits limits = {.tol = 1e-8};
  structure s = build(_i ? "chain" : "wall-pushed", 200, 0.5);
  dls_info info;
  s.r[0] = 9;
  MALLOCS_FAIL(rest(&s, &limits, &info), s.r[0] == 9, DLS_OK, 11);
  tear_down(&s);
}

/* auto takes the stage, and ends with it on a long chain, too. */
TEST_EACH(stage_of_auto, 0, 2) {
  structure s = build("chain", _i ? 40000 : 2000, 0.5);
  dls_info info;
  dls_solver_settings settings = settings_with(DLS_AUTO, default_tol);
  const dls_status status = dls_solve(&s.a.contact, &settings, s.r, NULL, &info, NULL);
  ck_assert_int_eq(status, DLS_OK);
  ck_assert_int_eq(info.stages, 2);
  ck_assert_int_eq(info.stage[1].method, DLS_ADMM);
  ck_assert(info.certificate.residual <= 1e-8);
  tear_down(&s);
}

TEST_ALONE(without_dissection) { /* and auto goes on */
  const dls_limits limits = {.tol = 1e-8};
  structure s = build("wall-rest", 200, 0.5);
  dls_info info;
  ck_assert_int_eq(rest(&s, &limits, &info), DLS_E_UNSUPPORTED);
  tear_down(&s);
}

int main(void) {
  if (!WITH_MUMPS) return run_alone(without_dissection, 0, 1);
  return run_tests("rest", NULL, NULL);
}
