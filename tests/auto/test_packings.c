/* test_packings.c: packings of rigid bodies, the stages that auto takes on them; an elastic
 * body by blocks. */
#include "cases.h"
#include "delassus/solve.h"
#include "front_cases.h"
#include "half_space.h"
#include "made.h"
#include "rigid.h"
#include "run.h"

/* Solves a packing by a method to tol; spare: candidates that there is room for besides. */
static dls_info pack_by(dls_method method, dls_acceleration acceleration, const char *kind,
                        int candidates, uint64_t seed, double tol, int spare) {
  rigid a;
  dls_info info = {.status = DLS_STALLED};
  ck_assert_int_eq(rigid_create(&a, kind, candidates, 0.5, seed), 0);
  double *r = calloc((size_t)(a.d * a.contact.nc), sizeof *r);
  ck_assert_ptr_nonnull(r);
  dls_solver_settings settings = settings_with(method, default_tol);
  settings.acceleration = acceleration;
  settings.limits.tol = tol;
  settings.limits.blocks = a.contact.Wb.p[a.contact.nc];
  dls_solver *solver = solver_of(a.d, a.contact.nc + spare, &settings);
  ck_assert_int_eq(dls_solver_solve(solver, &a.contact, r, NULL, &info, NULL), DLS_OK);
  const dls_certificate c = certificate_of(&a.contact, r);
  ck_assert(dls_certificate_holds(&c, tol));
  dls_solver_destroy(solver);
  free(r);
  rigid_free(&a);
  return info;
}

/* Solves a packing by auto to tol. */
static dls_info pack(const char *kind, int candidates, uint64_t seed, double tol) {
  return pack_by(DLS_AUTO, DLS_ACCELERATION_NONE, kind, candidates, seed, tol, 0);
}

/* Sweeps are enough for 1e-4, with momentum where there are many candidates; the convex problem may
 * be tried twice beside them. */
TEST_EACH(sweeps_are_enough, 0, 3) {
  static const int sizes[] = {300, 700, 2500};
  static const char *const kinds[] = {"packing-rest", "packing-flow"};
  for (int k = 0; k < 2; k++) {
    const dls_info info = pack(kinds[k], sizes[_i], 2, 1e-4);
    ck_assert_int_le(info.stages, 5);
    ck_assert_int_eq(info.stage[info.stages - 1].method, DLS_NLGS);
    for (int s = 0; s < info.stages; s++)
      if (info.stage[s].step != DLS_STEP_CONVEX) ck_assert_int_eq(info.stage[s].method, DLS_NLGS);
  }
}

/* A tight packing begins with momentum, which goes on between looks for candidates to sweep alone:
 * it takes less than half of the plain sweeps then. */
TEST(tight_ones_take_momentum) {
  for (uint64_t seed = 2; seed <= 8; seed += 6) {
    const dls_info a = pack("packing-flow", 300, seed, 1e-4);
    const dls_info momentum =
        pack_by(DLS_NLGS, DLS_ACCELERATION_MOMENTUM, "packing-flow", 300, seed, 1e-4, 0);
    const dls_info plain =
        pack_by(DLS_NLGS, DLS_ACCELERATION_NONE, "packing-flow", 300, seed, 1e-4, 0);
    ck_assert_int_eq(a.stages, 1);
    ck_assert_int_eq(a.iterations, momentum.iterations);
    ck_assert_int_lt(2 * momentum.iterations, plain.iterations);
  }
}

/* Sweeps are as patient in a workspace with room for 1000 candidates more. */
TEST(room_changes_nothing) {
  static const char *const kinds[] = {"packing-rest", "discs-rest"};
  for (int k = 0; k < 2; k++) {
    const dls_info a = pack(kinds[k], 300, 4, 1e-4);
    const dls_info b = pack_by(DLS_AUTO, DLS_ACCELERATION_NONE, kinds[k], 300, 4, 1e-4, 1000);
    ck_assert_int_eq(a.stages, b.stages);
    for (int s = 0; s < a.stages; s++)
      ck_assert_int_eq(a.stage[s].iterations, b.stage[s].iterations);
  }
}

/* Newton's method takes over where the residual is small already, not before. */
TEST(newton_ends_it) {
  const dls_info info = pack("packing-flow", 300, 2, 1e-10);
  ck_assert_int_eq(info.stage[info.stages - 1].method, DLS_NEWTON);
  for (int s = 1; s < info.stages; s++)
    if (info.stage[s].method == DLS_NEWTON) ck_assert(info.stage[s - 1].residual <= 1e-5);
}

/* Where sweeps get nowhere, the augmented Lagrangian takes turns of equal cost with them, and goes
 * on from where it was: it needs as many augmentations as alone, and not 12228 sweeps before. */
TEST(sweeps_that_stall) {
  const dls_info info = pack("packing-rest", 300, 4, 1e-8);
  const dls_info alone =
      pack_by(DLS_AUGMENTED_LAGRANGIAN, DLS_ACCELERATION_NONE, "packing-rest", 300, 4, 1e-8, 0);
  int sweeps = 0, augmentations = 0;
  for (int s = 0; s < info.stages; s++)
    *(info.stage[s].method == DLS_NLGS                   ? &sweeps
      : info.stage[s].method == DLS_AUGMENTED_LAGRANGIAN ? &augmentations
                                                         : &(int){0}) += info.stage[s].iterations;
  ck_assert_int_eq(info.stage[info.stages - 1].method, DLS_AUGMENTED_LAGRANGIAN);
  ck_assert_int_lt(sweeps, 6000);
  ck_assert_int_le(augmentations, alone.iterations + 10);
}

/* An elastic body by blocks is no packing: the stages and steps are those of its dense W. */
TEST(elastic_by_blocks) {
  enum { nc = 1100, m = 2 * nc };
  double *W = calloc((size_t)m * m, sizeof *W), *x = calloc((size_t)m * m, sizeof *x);
  double *q = calloc(4 * m, sizeof *q), *r = q + m, *s = r + m, *mu = s + m;
  int *p = calloc(nc + 1 + (size_t)nc * nc, sizeof *p);
  ck_assert(W && x && q && p);
  const dls_contact dense = half_plane(W, q, mu, nc, 3, 0.3, 1.2, 0.4);
  dls_contact blocks = dense;
  blocks.W = (dls_dense){0};
  ck_assert_int_eq(dls_blocks_from_dense(&dense.W, 2, p, p + nc + 1, x, &blocks.Wb, NULL), DLS_OK);
  const dls_info a = solve_auto(&dense, 1e-4, r), b = solve_auto(&blocks, 1e-4, s);
  ck_assert_int_eq(a.status, DLS_OK);
  ck_assert_int_eq(b.status, DLS_OK);
  ck_assert_int_eq(a.stages, b.stages);
  for (int k = 0; k < a.stages; k++) {
    ck_assert_int_eq(a.stage[k].method, b.stage[k].method);
    ck_assert_int_eq(a.stage[k].iterations, b.stage[k].iterations);
  }
  free(W);
  free(x);
  free(q);
  free(p);
}

/* What settles in a box from random places is not what a lattice becomes: in 2D Anderson's sweeps
 * are the quickest, and auto takes them, of bodies, too (momentum alone needs three times the
 * sweeps, plain ones more than nine times). */
TEST(settled_ones_take_the_quickest_way) {
  rigid a;
  ck_assert_int_eq(rigid_create(&a, "discs-rest", 3000, 0.5, 4), 0);
  for (int bodies = 0; bodies < 2; bodies++) {
    dls_info info[3];
    const dls_contact *problem = bodies ? &a.factored : &a.contact;
    double *r = calloc((size_t)(a.d * a.contact.nc), sizeof *r);
    ck_assert_ptr_nonnull(r);
    for (int k = 0; k < 3; k++) {
      dls_solver_settings settings = settings_with(k ? DLS_NLGS : DLS_AUTO, default_tol);
      settings.acceleration = k == 1 ? DLS_ACCELERATION_MOMENTUM : DLS_ACCELERATION_NONE;
      settings.limits.tol = 1e-4;
      ck_assert_int_eq(dls_solve(problem, &settings, r, NULL, &info[k], NULL), DLS_OK);
    }
    ck_assert_int_lt(2 * info[0].iterations, info[1].iterations);
    ck_assert_int_lt(3 * info[1].iterations, info[2].iterations);
    free(r);
  }
  rigid_free(&a);
}

/* Densities a thousand times each other's: the residual falls slowly, by whichever way. Anderson's
 * sweeps need the fewest, and get their time. */
TEST(slow_ones_take_it_too) {
  const dls_info a = pack("mixed2-rest", 1500, 2, 1e-4);
  const dls_info anderson =
      pack_by(DLS_NLGS, DLS_ACCELERATION_ANDERSON, "mixed2-rest", 1500, 2, 1e-4, 0);
  ck_assert_int_eq(a.stage[a.stages - 1].step, DLS_STEP_MOMENTUM);
  ck_assert_int_lt(a.iterations, 2 * anderson.iterations);
}

/* A train of gears on heavy axles, driven at both ends, four flanks a pair: a factorisation costs a
 * few sweeps, and sweeps that seem to be near go on for thousands. The convex problem comes early,
 * to any tolerance. */
TEST_EACH(rows_of_bodies_need_few_sweeps, 0, 3) {
  enum { gears = 80, nc = 4 * (gears - 1) };
  static int body[2 * nc], p[nc + 1], i[16 * nc];
  static double H[12 * nc], q[2 * nc], mu[nc], x[64 * nc], r[2 * nc];
  double root[gears][3], v[gears][3];
  set_seed(808 + (uint64_t)_i);
  for (int b = 0; b < gears; b++) {
    const double m = 1.5 + uniform() / 2, turn = b == 0           ? 1
                                                 : b == gears - 1 ? .6
                                                                  : .15 * (1 + uniform());
    root[b][0] = root[b][1] = 1 / sqrt(80 * m);
    root[b][2] = 1 / sqrt(.5 * m);
    v[b][0] = v[b][1] = 0;
    v[b][2] = b % 2 ? -turn : turn;
  }
  memset(q, 0, sizeof q);
  for (int c = 0; c < nc; c++) {
    const double side = c % 4 < 2 ? 1 : -1, off = c % 2 ? .04 : -.05;
    const double n[2] = {-sin(.349), side * cos(.349)}, F[2][2] = {{n[0], n[1]}, {-n[1], n[0]}};
    mu[c] = .8;
    for (int s = 0; s < 2; s++) {
      const int b = body[2 * c + s] = c / 4 + s;
      const double arm[2] = {s ? off - 1 : off + 1, off * side}, sign = s ? -1 : 1;
      for (int j = 0; j < 2; j++) {
        const double row[3] = {F[j][0], F[j][1], arm[0] * F[j][1] - arm[1] * F[j][0]};
        for (int l = 0; l < 3; l++) {
          H[12 * c + 6 * s + 3 * j + l] = sign * row[l] * root[b][l];
          q[2 * c + j] += sign * row[l] * v[b][l];
        }
      }
    }
  }
  dls_contact train = {.d = 2, .nc = nc, .q = q, .mu = mu, .bodies = {3, gears, body, H, NULL}};
  dls_blocks W;
  ck_assert_int_eq(dls_blocks_from_bodies(&train, p, i, x, &W, NULL), DLS_OK);
  train.bodies = (dls_bodies){0};
  train.Wb = W;
  for (int k = 0; k < 2; k++) {
    dls_info info;
    dls_solver_settings settings = settings_with(DLS_AUTO, k ? 1e-8 : 1e-4);
    ck_assert_int_eq(dls_solve(&train, &settings, r, NULL, &info, NULL), DLS_OK);
    ck_assert_int_eq(info.stage[1].step, DLS_STEP_CONVEX);
    ck_assert_int_lt(info.iterations, 150);
  }
}
