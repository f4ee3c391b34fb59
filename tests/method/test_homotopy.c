/* test_homotopy.c: the interior homotopy by itself. */
#include "front_cases.h"
#include "run.h"

/* Planted problems of low rank and large friction, of which the first ten starts leave some: drawn
 * ones lead to all (HO8). */
TEST(drawn_starts_reach_planted_solutions) {
  static planted_problem a;
  const dls_solver_settings settings = settings_of(DLS_HOMOTOPY);
  double r[3 * PLANTED];
  dls_info info;
  int later = 0;
  for (unsigned seed = 1; seed <= 40; seed++) {
    const dls_contact p = planted(&a, 3, 12, 9, 16, seed);
    ck_assert_int_eq(dls_solve(&p, &settings, r, NULL, &info, NULL), DLS_OK);
    later += info.factorisations > 10 * 500;
  }
  ck_assert_int_ge(later, 2);
}
