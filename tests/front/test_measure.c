/* test_measure.c: the rule by which bench/ counts solves (bench/solvers_call.c), and the check of
 * its options (bench/common.c). */
#include "../../bench/common.h"
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
TEST_EACH(answers_that_hold, 0, 6) {
  static const double W[] = {1, 0, 0, 1}, q[] = {-1, -1}, mu[] = {0, 0};
  static const double r[] = {1, 0, NAN, INFINITY, -INFINITY, 1e308};
  const scene s = {.contact = {.d = 1, .nc = 2, .W = {2, 2, 2, W}, .q = q, .mu = mu}};
  const outcome o = measure(&s, answer, &r[_i], 1e-4, 10);
  ck_assert_int_eq(o.ended, ENDED);
  ck_assert_int_eq(o.claim, 1);
  ck_assert_int_eq(dls_certificate_holds(&o.certificate, 1e-4), _i == 0);
  ck_assert_int_eq(o.certificate.residual <= 1e-4, _i == 0);
}

/* Options and values that a usage has pass; all others are refused, wherever they stand. */
TEST(options_of_a_bench) {
  static const char may[] = "[--out DIR] [--large] [--sizes N,N..]";
  static const char must[] = "--out DIR [--only WORD]", names[] = "--out DIR [FILE...]";
  static const struct {
    const char *usage;
    int good;
    char *argument[5];
  } rows[] = {
      {may, 1, {0}},
      {may, 1, {"--out", "a"}},
      {may, 1, {"--large", "--sizes", "1,2", "--out", "a"}},
      {may, 1, {"--out", "a", "--large"}},
      {may, 0, {"--help"}},
      {may, 0, {"-h"}},
      {may, 0, {"-"}},
      {may, 0, {"a"}},
      {may, 0, {""}},
      {may, 0, {"--out"}},
      {may, 0, {"--ou", "a"}},
      {may, 0, {"--outer", "a"}},
      {may, 0, {"--nonsense", "--out", "a"}},
      {may, 0, {"--out", "a", "--nonsense"}},
      {may, 0, {"--large", "yes"}},
      {may, 0, {"[--out", "a"}},
      {must, 1, {"--out", "a"}},
      {must, 1, {"--only", "b", "--out", "a"}},
      {must, 0, {0}},
      {must, 0, {"--only", "b"}},
      {must, 0, {"--out", "a", "b"}},
      {names, 1, {"--out", "a", "b", "c"}},
      {names, 0, {"b", "c"}},
      {names, 0, {"--out", "a", "b", "--nonsense"}},
  };
  for (size_t k = 0; k < sizeof rows / sizeof rows[0]; k++) {
    char *argv[7] = {"bench"};
    int argc = 1;
    for (; argc <= 5 && rows[k].argument[argc - 1]; argc++)
      argv[argc] = rows[k].argument[argc - 1];
    ck_assert_msg(bench_options(argc, argv, rows[k].usage) == rows[k].good, "row %zu: %s", k,
                  rows[k].usage);
  }
}
