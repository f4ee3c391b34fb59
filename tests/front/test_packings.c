/* test_packings.c: packings of rigid bodies, the stages that auto takes on them (AT13). */
#include <check.h>
#include <stdlib.h>

#include "delassus/solve.h"
#include "rigid.h"
#include "run.h"

/* Solves a packing by auto to tol. */
static dls_info pack(const char *kind, int candidates, uint64_t seed, double tol) {
  rigid a;
  dls_info info = {.status = DLS_STALLED};
  dls_certificate c;
  dls_solver_settings settings;
  dls_solver *solver;
  ck_assert_int_eq(rigid_create(&a, kind, candidates, 0.5, seed), 0);
  double *r = calloc((size_t)(a.d * a.contact.nc), sizeof *r);
  ck_assert_ptr_nonnull(r);
  dls_solver_settings_init(&settings);
  settings.limits.tol = tol;
  settings.limits.blocks = a.contact.Wb.p[a.contact.nc];
  ck_assert_int_eq(dls_solver_create(&solver, a.d, a.contact.nc, &settings, NULL), DLS_OK);
  ck_assert_int_eq(dls_solver_solve(solver, &a.contact, r, NULL, &info, NULL), DLS_OK);
  ck_assert_int_eq(dls_contact_certify(&a.contact, r, NULL, &c, NULL), DLS_OK);
  ck_assert(dls_certificate_holds(&c, tol));
  dls_solver_destroy(solver);
  free(r);
  rigid_free(&a);
  return info;
}

/* Sweeps are enough for 1e-4, with momentum where there are many candidates. */
START_TEST(sweeps_are_enough) {
  static const int sizes[] = {300, 700, 2500};
  static const char *const kinds[] = {"packing-rest", "packing-flow"};
  for (int k = 0; k < 2; k++) {
    const dls_info info = pack(kinds[k], sizes[_i], 2, 1e-4);
    ck_assert_int_le(info.stages, 2);
    for (int s = 0; s < info.stages; s++)
      ck_assert_int_eq(info.stage[s].method, DLS_NLGS);
  }
}
END_TEST

/* Newton's method takes over where the residual is small already, not before. */
START_TEST(newton_ends_it) {
  const dls_info info = pack("packing-flow", 300, 2, 1e-10);
  ck_assert_int_eq(info.stage[info.stages - 1].method, DLS_NEWTON);
  for (int s = 1; s < info.stages; s++)
    if (info.stage[s].method == DLS_NEWTON) ck_assert(info.stage[s - 1].residual <= 1e-5);
}
END_TEST

int main(void) {
  return RUN("packings", NULL, NULL, EACH(sweeps_are_enough, 0, 3), ONCE(newton_ends_it));
}
