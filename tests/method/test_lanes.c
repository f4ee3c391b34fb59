/*
 * test_lanes.c: sweeps over eight small problems at once: on problems whose sweeps contract each
 * lane arrives, whatever the others do, at the certificate that was asked for.
 */
#include <check.h>
#include <math.h>
#include <stdlib.h>

#include "cases.h"
#include "run.h"
#include "vi/vi_internal.h"

/* W = 4 I and couplings below 1, unsymmetric inside of the blocks, too; all states occur. */
static void contracting_model(model *a, int d, int nc) {
  const int m = d * nc;
  set_model(a, d, nc);
  for (int j = 0; j < m; j++) {
    for (int i = 0; i < m; i++)
      a->W[i + m * j] = (i == j ? 4 : 0) + 0.8 * uniform() / nc;
    a->q[j] = 2 * uniform() - (j % d == 0 ? 0.5 : 0);
  }
  for (int c = 0; d > 1 && c < nc; c++)
    a->mu[c] = c % 4 == 3 ? 0 : 0.4 + 0.3 * uniform();
}

START_TEST(each_lane_arrives) {
  static model a[dlsi_lanes];
  dls_contact problem[dlsi_lanes];
  const int d = 1 + _i % 3, nc = 1 + _i / 3 % dlsi_lane_candidates, count = 1 + _i % dlsi_lanes;
  const double tol = 1e-8;
  int states[3] = {0};
  set_seed(8862 + (uint64_t)_i);
  for (int k = 0; k < count; k++) {
    contracting_model(&a[k], d, nc);
    problem[k] = a[k].p;
  }
  dlsi_lane_work *work = dlsi_lane_create();
  ck_assert_ptr_nonnull(work);
  const int sweeps = dlsi_lane_solve(work, count, problem, tol);
  ck_assert_int_ge(sweeps, 1);
  for (int k = 0; k < count; k++) {
    double r[3 * dlsi_lane_candidates];
    dls_certificate c;
    dlsi_lane_get(work, k, d, r);
    ck_assert_int_eq(dls_contact_certify(&problem[k], r, NULL, &c, NULL), DLS_OK);
    ck_assert_msg(dls_certificate_holds(&c, tol), "d = %d, nc = %d, lane %d of %d: %g", d, nc, k,
                  count, c.residual);
    for (int i = 0; i < nc; i++) {
      const double n = r[d * i], t = d < 2 ? 0 : hypot(r[d * i + 1], d == 3 ? r[d * i + 2] : 0);
      states[n == 0 ? 0 : t < a[k].mu[i] * n * (1 - 1e-9) ? 1 : 2]++;
    }
  }
  if (d > 1 && nc * count > 20) ck_assert(states[0] && states[2]);
  free(work);
}
END_TEST

int main(void) {
  return RUN("lanes", NULL, NULL, EACH(each_lane_arrives, 0, 96));
}
