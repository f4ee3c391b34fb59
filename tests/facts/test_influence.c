/* test_influence.c: how reactions change with q and with friction, beside differences of proved
 * answers, and by hand. */
#include <check.h>
#include <float.h>
#include <math.h>
#include <string.h>

#include "cases.h"
#include "delassus/solve.h"
#include "delassus/trust.h"
#include "facts/influence.h"
#include "malloc_fails.h"
#include "run.h"

/* r := the answer to rounding. Returns 0 where it is not proved. */
static int prove_answer(const dls_contact *p, double *r) {
  dls_proof proof;
  if (dls_solve(p, NULL, r, NULL, NULL, NULL)) return 0;
  ck_assert_int_eq(dls_contact_prove(p, r, &proof, r, NULL), DLS_OK);
  return proof.kind == DLS_PROVED;
}

/* Central differences, h = 1e-4 to 1e-7: the best of them agrees to 1e-7 of the largest entry. */
START_TEST(beside_differences) {
  static model a, b;
  static double r[most], w[most], dq[most * most], dmu[most], low[most], high[most];
  numbered_model(&a, _i);
  const int d = a.p.d, m = d * a.p.nc;
  copy_model(&b, &a);
  ck_assert(prove_answer(&a.p, r));
  ck_assert_int_eq(dlsi_contact_influence(&a.p, r, w, dq, dmu, NULL), DLS_OK);
  for (int c = 0; c < a.p.nc; c++) {
    double mean = 0;
    for (int i = 0; i < d; i++)
      mean += a.W[(d * c + i) * (m + 1)] / d;
    ck_assert_double_eq_tol(w[c], mean, 4 * DBL_EPSILON * mean);
  }
  for (int j = 0; j <= m; j++) { /* j = m: friction */
    const double *slope = j < m ? dq + j * m : dmu;
    double best = INFINITY, size = 0;
    for (double h = 1e-4; h > 1e-8; h /= 10) {
      double worst = 0;
      int proved = 1;
      for (int side = -1; side <= 1 && proved; side += 2) {
        memcpy(b.q, a.q, sizeof a.q);
        memcpy(b.mu, a.mu, sizeof a.mu);
        if (j < m) b.q[j] += side * h;
        for (int c = 0; j == m && c < a.p.nc; c++)
          if (a.mu[c] > 0) b.mu[c] += side * h;
        proved = prove_answer(&b.p, side < 0 ? low : high);
      }
      for (int i = 0; i < m && proved; i++) {
        worst = fmax(worst, fabs((high[i] - low[i]) / (2 * h) - slope[i]));
        size = fmax(size, fabs(slope[i]));
      }
      if (proved) best = fmin(best, worst);
    }
    ck_assert_double_le(best, 1e-7 * fmax(size, 1));
  }
}
END_TEST

/* W = 2, q = (-2, -3), mu = 1/2: slips with r = (1, 1/2). d r / d q_n = -(1, 1/2) / 2, of q_t
 * nothing, of mu (0, 1). */
START_TEST(by_hand) {
  static model a;
  double w[1], dq[4], dmu[2];
  const double r[2] = {1, 0.5};
  set_model(&a, 2, 1);
  a.W[0] = a.W[3] = 2;
  a.q[0] = -2;
  a.q[1] = -3;
  a.mu[0] = 0.5;
  ck_assert_int_eq(dlsi_contact_influence(&a.p, r, w, dq, dmu, NULL), DLS_OK);
  ck_assert(w[0] == 2 && dq[0] == -0.5 && dq[1] == -0.25 && dq[2] == 0 && dq[3] == 0);
  ck_assert(dmu[0] == 0 && dmu[1] == 1);
  long failed = 0;
  for (dls_status status = DLS_E_MEMORY; status == DLS_E_MEMORY; failed++) {
    malloc_fails_at(failed + 1);
    status = dlsi_contact_influence(&a.p, r, w, dq, dmu, NULL);
    malloc_fails_at(0);
    ck_assert(status == DLS_OK || status == DLS_E_MEMORY);
  }
  ck_assert_int_ge(failed, 4);
}
END_TEST

/* Two legs under one load: the reactions are not determined. */
START_TEST(not_determined) {
  static model a;
  double w[2], dq[4], dmu[2];
  const double r[2] = {1, 1};
  set_model(&a, 1, 2);
  a.W[0] = a.W[1] = a.W[2] = a.W[3] = 1;
  a.q[0] = a.q[1] = -2;
  ck_assert_int_eq(dlsi_contact_influence(&a.p, r, w, dq, dmu, NULL), DLS_E_SINGULAR);
}
END_TEST

int main(void) {
  return RUN("influence", NULL, NULL, EACH(beside_differences, 0, 16), ONCE(by_hand),
             ONCE(not_determined));
}
