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

/* Three copies of a problem side by side have its path: norms are means over contacts (HO6). */
TEST(copies_have_one_path) {
  enum { nc = 6, rows = 3 * nc, all = 3 * rows };
  static planted_problem a;
  static double W[all * all];
  const dls_solver_settings settings = settings_of(DLS_HOMOTOPY);
  double q[all], mu[3 * nc], r[all];
  dls_info info[2];
  for (unsigned seed = 1; seed <= 20; seed++) {
    const dls_contact p = planted(&a, 3, nc, 12, 3, seed);
    const dls_contact copies = {.d = 3, .nc = 3 * nc, .W = {all, all, all, W}, .q = q, .mu = mu};
    for (int i = 0; i < all; i++) {
      q[i] = a.q[i % rows];
      mu[i / 3] = a.mu[i / 3 % nc];
      for (int j = 0; j < all; j++)
        W[i + all * j] = i / rows == j / rows ? a.W[i % rows + rows * (j % rows)] : 0;
    }
    ck_assert_int_eq(dls_solve(&p, &settings, r, NULL, &info[0], NULL), DLS_OK);
    ck_assert_int_eq(dls_solve(&copies, &settings, r, NULL, &info[1], NULL), DLS_OK);
    ck_assert_int_eq(info[1].factorisations, info[0].factorisations);
  }
}
