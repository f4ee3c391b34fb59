/*
 * test_lanes.c: sweeps over eight small problems at once: on problems whose sweeps contract each
 * lane reaches the requested certificate, whatever the others do.
 */
#include "cases.h"
#include "made.h"
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

TEST_EACH(each_lane_arrives, 0, 96) {
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
    dlsi_lane_get(work, k, d, r);
    const dls_certificate c = certificate_of(&problem[k], r);
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

/* Candidates apart from each other, free, sticking and without friction, are solved by one sweep;
 * the next one, after which the sweeps look, finds that nothing moves. q = 0 in some lanes. */
TEST(ends_at_the_first_look) {
  static model a[dlsi_lanes];
  dls_contact problem[dlsi_lanes];
  dlsi_lane_work *work = dlsi_lane_create();
  ck_assert_ptr_nonnull(work);
  for (int d = 1; d <= 3; d++)
    for (int nc = 1; nc <= dlsi_lane_candidates; nc++) {
      for (int k = 0; k < dlsi_lanes; k++) {
        set_model(&a[k], d, nc);
        for (int i = 0; i < d * nc; i++) {
          a[k].W[i + d * nc * i] = 1 << (i + k) % 4;
          a[k].q[i] = k % 3 == 2 ? 0 : i % d == 0 ? (i % 2 ? 3 : -4 - k) : .25;
        }
        for (int c = 0; c < nc; c++)
          a[k].mu[c] = d > 1 && c % 3 ? 1 : 0;
        for (int c = 0; c < nc; c += 3) /* without friction, at rest or sliding */
          for (int i = 1; i < d; i++)
            a[k].q[d * c + i] = k % 2;
        problem[k] = a[k].p;
      }
      ck_assert_int_eq(dlsi_lane_solve(work, dlsi_lanes, problem, 1e-12), 2);
      for (int k = 0; k < dlsi_lanes; k++) {
        double r[3 * dlsi_lane_candidates];
        dlsi_lane_get(work, k, d, r);
        for (int i = 0; i < d * nc; i++) {
          const int c = i / d, loaded = a[k].q[d * c] < 0;
          const double own = -a[k].q[i] / (1 << (i + k) % 4);
          ck_assert(r[i] == (loaded && (i % d == 0 || a[k].mu[c] > 0) ? own : 0));
        }
      }
    }
  free(work);
}

/* C11 in one lane, whose sweeps cycle: the limit, wherever it
 * stands beside others with q = 0. */
TEST(goes_on_while_a_lane_moves) {
  static model a[2];
  dls_contact problem[dlsi_lanes];
  dlsi_lane_work *work = dlsi_lane_create();
  ck_assert_ptr_nonnull(work);
  set_hand(&a[0], hand_named("C11"));
  set_model(&a[1], a[0].p.d, a[0].p.nc);
  for (int i = 0; i < a[0].p.d * a[0].p.nc; i++)
    a[1].W[i * (a[0].p.d * a[0].p.nc + 1)] = 1;
  for (int at = 0; at < dlsi_lanes; at++) {
    for (int k = 0; k < dlsi_lanes; k++)
      problem[k] = a[k != at].p;
    ck_assert_int_eq(dlsi_lane_solve(work, dlsi_lanes, problem, 1e-8), 32);
  }
  free(work);
}

/* Two candidates of each lane pressed, without friction: the sweeps that follow, r_c := (-q_c -
 * W_cb r_b) / W_cc, and every second one |w dr| <= tol |q| / 4 and |dr| <= tol |r| / 4 in all
 * lanes; W_cc = unit diag(1, 3, 5), so that w = d unit. Lane `at` moves, the others do not, or all
 * move, each at its own pace and in its own units. */
TEST_EACH(looks_by_hand, 0, 24) {
  static const double coupling[] = {0x1p-12, 0x1p-11, 0.5, -0.5, -0.9, 0.75, -0.75, -0.25};
  const double tol = 1e-3, least = tol * tol / 16;
  const int d = 1 + _i / 8, m = 2 * d;
  static model a[dlsi_lanes];
  dls_contact problem[dlsi_lanes];
  dlsi_lane_work *work = dlsi_lane_create();
  ck_assert_ptr_nonnull(work);
  for (int at = 0; at <= dlsi_lanes; at++) {
    double r[dlsi_lanes][2] = {{0}}, s[6];
    for (int l = 0; l < dlsi_lanes; l++) {
      const double unit = l == at ? 4 : ldexp(1, -20 + 5 * l);
      const double c = l == at ? coupling[_i % 8] : at == dlsi_lanes ? coupling[l] : 0;
      set_model(&a[l], d, 2);
      for (int i = 0; i < m; i++)
        a[l].W[i + m * i] = unit * (1 + 2 * (i % d));
      a[l].W[d] = a[l].W[m * d] = unit * c;
      a[l].q[0] = a[l].q[d] = l == at ? -4 : -0x1p-20;
      problem[l] = a[l].p;
    }
    int sweeps = 0, done = 0;
    while (!done && sweeps < 32) {
      done = ++sweeps % 2 == 0;
      for (int l = 0; l < dlsi_lanes; l++) {
        const double *W = a[l].W, *q = a[l].q, w = d * W[0];
        double moved = 0, forces = 0;
        for (int c = 0; c < 2; c++) {
          const double n = (-q[d * c] - W[d] * r[l][1 - c]) / W[0], dr = n - r[l][c];
          moved += w * dr * w * dr;
          forces += dr * dr;
          r[l][c] = n;
        }
        done = done && moved <= least * 2 * q[0] * q[0] &&
               forces <= least * (r[l][0] * r[l][0] + r[l][1] * r[l][1]);
      }
    }
    ck_assert_int_eq(dlsi_lane_solve(work, dlsi_lanes, problem, tol), sweeps);
    for (int l = 0; l < dlsi_lanes; l++) {
      dlsi_lane_get(work, l, d, s);
      for (int i = 0; i < m; i++)
        ck_assert_double_eq_tol(s[i], i % d ? 0 : r[l][i / d], 1e-14 * r[l][i / d]);
    }
  }
  free(work);
}

/* One lane slips, W = 1, q = (-1, 5, 0) and mu = 1, the others are free. */
TEST(one_lane_slips) {
  static model a[2];
  dls_contact problem[dlsi_lanes];
  dlsi_lane_work *work = dlsi_lane_create();
  ck_assert_ptr_nonnull(work);
  for (int d = 2; d <= 3; d++) {
    for (int l = 0; l < 2; l++) {
      set_model(&a[l], d, 1);
      for (int i = 0; i < d; i++)
        a[l].W[i + d * i] = 1;
      a[l].q[0] = l ? 1 : -1;
      a[l].q[1] = l ? 0 : 5;
      a[l].mu[0] = 1;
    }
    for (int at = 0; at < dlsi_lanes; at++) {
      for (int l = 0; l < dlsi_lanes; l++)
        problem[l] = a[l != at].p;
      (void)dlsi_lane_solve(work, dlsi_lanes, problem, 1e-12);
      for (int l = 0; l < dlsi_lanes; l++) {
        double r[3] = {7, 7, 0};
        dlsi_lane_get(work, l, d, r);
        assert_near(r, (double[]){l == at, -(l == at), 0}, 3, 1e-15);
      }
    }
  }
  free(work);
}
