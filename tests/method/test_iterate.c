/* test_iterate.c: which of two iterates is the better answer. */
#include "run.h"
#include "vi/vi_internal.h"

static dls_certificate of(double residual_u, double residual_r, double floor_u) {
  dls_certificate c = {.floor_u = floor_u};
  dlsi_set_residuals(&c, residual_u, residual_r, 1); /* |r| = 1 */
  return c;
}

static void first_is_better(dls_certificate a, dls_certificate b) {
  ck_assert(dlsi_is_better(&a, &b) && !dlsi_is_better(&b, &a));
}

TEST(the_larger_part_decides) {
  first_is_better(of(1e-9, 1e-8, 1e-16), of(1e-9, 1e-7, 1e-16));
  first_is_better(of(1e-8, 1e-9, 1e-16), of(1e-7, 1e-9, 1e-16));
  first_is_better(of(1e-8, 1e-8, 1e-16), of(1e-12, 1e-7, 1e-16));
  const dls_certificate c = of(1e-8, 1e-9, 1e-16);
  ck_assert(!dlsi_is_better(&c, &c));
}

/* r = 1e16 in the null space of W, say: all rounding, its residual 0. */
TEST(a_runaway_never_wins) {
  first_is_better(of(1e-9, 1e-9, 1e-15), of(0, 0, 1));
  first_is_better(of(1e-3, 1e-3, 1e-15), of(0, 0, 1e-3));
  first_is_better(of(0, 0, 1e-12), of(1e-3, 1e-3, 1e-15));
}

/* Far from the answer the residual of forces is 1 for all. */
TEST(positions_decide_between_equals) {
  first_is_better(of(0.1, 3, 1e-16), of(0.5, 7, 1e-16));
  const dls_certificate zero = of(0.5, INFINITY, 1e-16);
  ck_assert(zero.residual_r == 1 && zero.residual == 1);
}

TEST(nan_never_wins) {
  first_is_better(of(9, 9, 1e-16), of(NAN, 0, 1e-16));
  first_is_better(of(9, 9, 1e-16), of(0, NAN, 1e-16));
  first_is_better(of(9, 9, 1e-16), of(0, 0, NAN));
  first_is_better(of(9, 9, 1e-16), dlsi_no_certificate);
  const dls_certificate bad = of(NAN, NAN, NAN), infinite = of(INFINITY, 0, 0);
  ck_assert(!dlsi_is_better(&bad, &dlsi_no_certificate));
  ck_assert(!dlsi_is_better(&infinite, &dlsi_no_certificate));
}
