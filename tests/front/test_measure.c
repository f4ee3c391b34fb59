/* test_measure.c: the rule by which bench/ counts solves (bench/solvers_call.c). */
#include <check.h>
#include <math.h>

#include "../../bench/solvers.h"
#include "run.h"

/* A solver that answers r = `how`, twice, and claims success. */
static void answer(const void *how, const scene *s, double tol, int calls, double *r, outcome *o) {
  (void)tol, (void)calls;
  for (int k = 0; k < s->contact.nc; k++)
    r[k] = *(const double *)how;
  o->ended = ENDED;
  o->claim = 1;
  o->cpu = 1;
}

/* W = 1, q = -1: r = 1 holds; 0, NaN and infinity do not, whatever the solver says. */
START_TEST(answers_that_hold) {
  static const double W[] = {1, 0, 0, 1}, q[] = {-1, -1}, mu[] = {0, 0};
  static const double r[] = {1, 0, NAN, INFINITY, -INFINITY, 1e308};
  const scene s = {.contact = {.d = 1, .nc = 2, .W = {2, 2, 2, W}, .q = q, .mu = mu}};
  const outcome o = measure(&s, answer, &r[_i], 1e-4, 10);
  ck_assert_int_eq(o.ended, ENDED);
  ck_assert_int_eq(o.claim, 1);
  ck_assert_int_eq(dls_certificate_holds(&o.certificate, 1e-4), _i == 0);
  ck_assert_int_eq(o.certificate.residual <= 1e-4, _i == 0);
}
END_TEST

int main(void) {
  return RUN("measure", NULL, NULL, EACH(answers_that_hold, 0, 6));
}
