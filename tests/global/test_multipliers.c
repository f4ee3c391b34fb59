/* test_multipliers.c: joints together with contacts, redundant ones too, on W and on K: truth from
 * statics by hand. */

#include "delassus/global.h"
#include "delassus/reduction.h"
#include "delassus/solve.h"
#include "linkage.h"
#include "reduced.h"
#include "run.h"
#include "solids.h"

static linkage L;
static dls_info info;
static dls_reduction_info facts;
static double r[300], x[linkage_most];

static void free_linkage(void) {
  linkage_free(&L);
}

static const double joint_tol = 1e-14; /* of the scale, linkage_apart */

/* Solves by the reduction (door 0) or on K (door 1). Returns the status. */
static dls_status answer(const dls_model *model, int door, double friction, double tol) {
  dls_error e = {0};
  double mu[100];
  dls_status status;
  for (int c = 0; c < 100; c++)
    mu[c] = friction;
  memset(r, 0, sizeof r);
  memset(x, 0, sizeof x);
  memset(&info, 0, sizeof info);
  if (door) {
    dls_global *global;
    dls_limits limits;
    dls_solver_settings defaults;
    dls_solver_settings_init(&defaults);
    limits = defaults.limits;
    limits.tol = tol;
    ck_assert_msg(!dls_global_create(&global, model, &e), "%s", e.message);
    status = dls_global_solve(global, L.f, NULL, mu, &limits, r, x, &info, &e);
    dls_global_destroy(global);
  } else {
    dls_reduction *reduction;
    dls_solver_settings settings;
    dls_solver_settings_init(&settings);
    settings.limits.tol = tol;
    ck_assert_msg(!reduce_on_W(&reduction, model, NULL, &e), "%s", e.message);
    ck_assert(!dls_reduction_get_info(reduction, &facts, &e));
    ck_assert_msg(!dls_reduction_load(reduction, L.f, NULL, &e), "%s", e.message);
    status = dls_reduction_solve(reduction, mu, &settings, r, NULL, x, &info, &e);
    dls_reduction_destroy(reduction);
  }
  ck_assert_msg(status >= 0, "%s", e.message);
  return status;
}

/* A run is a door, a storage and a factorisation: 0 <= run < 8. */
enum { runs = 8 };
static dls_status solve_run(int run, double friction, double tol) {
  const dls_model *model = linkage_model(&L, run & 4 ? DLS_LU : DLS_LDLT, run & 2);
  return answer(model, run & 1, friction, tol);
}

static const double origin[3] = {0, 0, 0};

/* ---- scenes ---------------------------------------------------------------------------------- */

static const double angle = .6, weight = 10;

/* Two bars of length 1 lean on each other, hinged at the top `times` times. */
static void lean(int times) {
  const double c = cos(angle) / 2, s = sin(angle) / 2;
  linkage_new(&L, 2);
  const int a = linkage_body(&L, 1, 1. / 12, weight), b = linkage_body(&L, 1, 1. / 12, weight);
  for (int k = 0; k < times; k++)
    linkage_pin(&L, a, (double[]){c, s}, b, (double[]){-c, s});
  linkage_contact(&L, a, (double[]){-c, -s});
  linkage_contact(&L, b, (double[]){c, -s});
}

/* Each foot carries one weight; thrust T = W cot(angle) / 2 is below friction .8. */
TEST_EACH(doubled_hinge, 0, 3 * runs) {
  const int times = 1 + _i % 3;
  const double thrust = weight / tan(angle) / 2;
  lean(times);
  const dls_status status = solve_run(_i / 3, .8, 1e-10);
  ck_assert_msg(status == DLS_OK, "%s %g", dls_status_name(status), info.certificate.residual);
  ck_assert_double_eq_tol(r[0], weight, 1e-9);
  ck_assert_double_eq_tol(r[2], weight, 1e-9);
  ck_assert_double_eq_tol(r[1], thrust, 1e-9);
  ck_assert_double_eq_tol(r[3], -thrust, 1e-9);
  ck_assert_msg(linkage_apart(&L, x) <= joint_tol, "%g", linkage_apart(&L, x));
  double sum = 0; /* of the hinges: the thrust, whichever of them carries it */
  for (int k = 0; k < times; k++)
    sum += x[6 + 2 * k];
  ck_assert_double_eq_tol(sum, thrust, 1e-9);
  if (_i / 3 & 1) return;
  ck_assert(facts.joints == 2 * times && facts.redundant == 2 * (times - 1));
  for (int k = 8; k < L.n; k++)
    ck_assert(x[k] == 0);
}

/* Feet that slip: T = mu W, and both bars move as statics by virtual work says. */
TEST_EACH(slipping_feet, 0, runs) {
  lean(2);
  const double mu = .3, c = cos(angle), s = sin(angle);
  const dls_status status = solve_run(_i, mu, 1e-10);
  ck_assert_msg(status == DLS_OK, "%s %g", dls_status_name(status), info.certificate.residual);
  /* one motion w: foot at -s w, hinge down by c w, centre (-s, -c) w / 2, turn w; N by the sum of
   * both bars' vertical impulse: 2 N - 2 W = -2 m c w / 2 */
  const double m = 1, I = 1. / 12, inertia = m / 4 + I;
  /* W c/2 - mu N s = inertia w,  N = W - m c w / 2 */
  const double w = (weight * c / 2 - mu * weight * s) / (inertia - mu * s * m * c / 2);
  const double N = weight - m * c * w / 2;
  ck_assert_double_eq_tol(x[2], -w, 1e-8);
  ck_assert_double_eq_tol(r[0], N, 1e-8);
  ck_assert_double_eq_tol(r[1], mu * N, 1e-8);
  ck_assert_double_eq_tol(r[3], -mu * N, 1e-8);
  ck_assert_msg(linkage_apart(&L, x) <= joint_tol, "%g", linkage_apart(&L, x));
}

/* A crank about the ground, a rod, and a slider on the ground; a couple on the crank pushes the
 * slider against friction. The rod carries S = couple / (R sin(a + b)). */
static void slider_crank(int times, double couple) {
  const double R = .5, l = 1.5, a = 1, b = asin(R * sin(a) / l);
  linkage_new(&L, 2);
  const int crank = linkage_body(&L, 2, .1, 0), rod = linkage_body(&L, 1, .2, 0),
            slider = linkage_body(&L, 3, 1, 20);
  const double C[2] = {R * cos(a) / 2, R * sin(a) / 2}, D[2] = {l * cos(b) / 2, -l * sin(b) / 2};
  const double minus_C[2] = {-C[0], -C[1]}, minus_D[2] = {-D[0], -D[1]};
  for (int k = 0; k < times; k++) {
    linkage_pin(&L, crank, minus_C, -1, origin);
    linkage_pin(&L, crank, C, rod, minus_D);
    linkage_pin(&L, rod, D, slider, origin);
    (void)linkage_turn(&L, slider, -1, NULL);
  }
  linkage_contact(&L, slider, origin);
  L.f[2] = couple;
}

TEST_EACH(slider_crank_holds, 0, 2 * runs) {
  const double R = .5, l = 1.5, a = 1, b = asin(R * sin(a) / l), couple = -2;
  const double S = -couple / (R * sin(a + b));
  slider_crank(1 + _i % 2, couple);
  const dls_status status = solve_run(_i / 2, .5, 1e-10);
  ck_assert_msg(status == DLS_OK, "%s %g", dls_status_name(status), info.certificate.residual);
  ck_assert_double_eq_tol(r[0], 20 + S * sin(b), 1e-9);
  ck_assert_double_eq_tol(r[1], -S * cos(b), 1e-9);
  ck_assert_msg(linkage_apart(&L, x) <= joint_tol, "%g", linkage_apart(&L, x));
  if (!(_i / 2 & 1)) ck_assert_int_eq(facts.redundant, _i % 2 ? 7 : 0);
}

/* A four-bar linkage in space, its axes along y: two cranks at angle `lean` on ground pivots, and a
 * coupler with a foot on the ground. A hinge in space has 5 rows, four of them 20 on 18 unknowns of
 * which one motion is left: 3 are redundant, whatever the bars. */
static void four_bar(void) {
  const double R = 1, tilt = 1.1, C[3] = {R * cos(tilt) / 2, 0, R * sin(tilt) / 2};
  const double minus_C[3] = {-C[0], 0, -C[2]}, left[3] = {-1, 0, 0}, right[3] = {1, 0, 0};
  const double e1[3] = {1, 0, 0}, e3[3] = {0, 0, 1}, foot[3] = {.3, .2, -.9};
  linkage_new(&L, 3);
  const int a = linkage_body(&L, 1, .1, 3), b = linkage_body(&L, 1, .1, 3),
            c = linkage_body(&L, 2, .5, 7);
  const int pairs[4][2] = {{a, -1}, {b, -1}, {a, c}, {b, c}};
  for (int k = 0; k < 4; k++) {
    const double *A = k < 2 ? minus_C : C, *B = k < 2 ? origin : k == 2 ? left : right;
    linkage_pin(&L, pairs[k][0], A, pairs[k][1], B);
    (void)linkage_turn(&L, pairs[k][0], pairs[k][1], e1);
    (void)linkage_turn(&L, pairs[k][0], pairs[k][1], e3);
  }
  linkage_contact(&L, c, foot);
}

/* Every point of the coupler moves along (-sin, 0, cos) of the tilt: virtual work. */
TEST_EACH(four_bar_stands, 0, 3 * runs) {
  const double mu = _i % 3 * .4, tilt = 1.1, load = (7 + 3) * cos(tilt);
  four_bar();
  const dls_status status = solve_run(_i / 3, mu, 1e-10);
  ck_assert_msg(status == DLS_OK, "%s %g", dls_status_name(status), info.certificate.residual);
  ck_assert_double_eq_tol(r[0] * cos(tilt) - r[1] * sin(tilt), load, 1e-9);
  ck_assert(hypot(r[1], r[2]) <= mu * r[0] * (1 + 1e-12));
  ck_assert_msg(linkage_apart(&L, x) <= joint_tol, "%g", linkage_apart(&L, x));
  if (!(_i / 3 & 1)) ck_assert(facts.joints == 20 && facts.redundant == 3);
}

/* A straight chain of bars, pinned to the ground at both ends, contacts .1 below the middles: 44
 * bars with each pin given twice have n = 312, more than what is factored dense. */
static void chain(int bars, int times) {
  const double A[2] = {.5, 0}, B[2] = {-.5, 0}, below[2] = {0, -.1};
  linkage_new(&L, 2);
  for (int k = 0; k < bars; k++)
    (void)linkage_body(&L, 1, 1. / 12, 1);
  for (int turn = 0; turn < times; turn++)
    for (int k = 0; k <= bars; k++)
      linkage_pin(&L, k ? k - 1 : -1, k ? A : origin, k < bars ? k : -1, k < bars ? B : origin);
  for (int k = 0; k < bars; k++)
    linkage_contact(&L, k, below);
}

/* Nothing moves, whether pins are doubled or not, and vertical forces balance. Contacts and pins
 * are more than the bars have motions: r is not unique. */
TEST_EACH(chains, 0, 4 * runs) {
  const int bars = _i / 2 / runs ? 44 : 12, times = 1 + _i % 2, positions = 3 * bars;
  chain(bars, times);
  const dls_status status = solve_run(_i / 2 % runs, 0, 1e-12);
  ck_assert_msg(status == DLS_OK, "%s %g", dls_status_name(status), info.certificate.residual);
  ck_assert_msg(linkage_apart(&L, x) <= joint_tol, "%g", linkage_apart(&L, x));
  double sum = 0;
  for (int k = 0; k < positions; k++)
    ck_assert_double_le(fabs(x[k]), 1e-11);
  for (int turn = 0; turn < times; turn++) { /* pins to the ground */
    const double *l = x + positions + turn * (2 * bars + 2);
    sum += l[1] - l[2 * bars + 1];
  }
  for (int c = 0; c < bars; c++)
    sum += r[2 * c];
  ck_assert_double_eq_tol(sum, bars, 1e-9);
}

/* ---- elastic bodies -------------------------------------------------------------------------- */

enum { across = 12, up = 6, column = up + 1, plates = 2 * (across + 1) * column };

/* Adds springs below, the load of a press above, and a contact below every other bottom node. node:
 * of (i, j) of the whole. */
static void press(solids *S, int (*node)(int, int)) {
  for (int i = 0; i <= 2 * across; i++) {
    solids_spring(S, node(i, 0), 0, .3);
    solids_spring(S, node(i, 0), 1, .05);
    if (i % 2) solids_contact(S, node(i, 0), -1, (double[]){0, 1}, .01 * (i % 3));
    S->f[2 * node(i, up) + 1] = -.02;
    S->f[2 * node(i, up)] = .004;
  }
}

static int node_of_whole(int i, int j) {
  return i + (2 * across + 1) * j;
}

static int node_of_halves(int i, int j) {
  const int second = i > across;
  return second * (across + 1) * column + i - second * across + (across + 1) * j;
}

/* The right edge of the first half, and the left edge of the second one. */
static int node_left(int j) {
  return node_of_halves(across, j);
}
static int node_right(int j) {
  return (across + 1) * column + (across + 1) * j;
}

static void make_whole(solids *S) {
  solids_new(S, 2, plates, across);
  (void)solids_block(S, (int[]){2 * across, up, 1}, 1);
  press(S, node_of_whole);
  (void)solids_model(S);
}

/* Makes two halves, tied node by node, each tie `times` times. */
static void make_halves(solids *S, int times) {
  solids_new(S, 2, plates, across);
  (void)solids_block(S, (int[]){across, up, 1}, 1);
  (void)solids_block(S, (int[]){across, up, 1}, 1);
  press(S, node_of_halves);
  int row = 2 * plates;
  for (int j = 0; j < column * times; j++)
    for (int k = 0; k < 2; k++, row++) {
      dlsi_triplets_add(&S->K, row, 2 * node_left(j % column) + k, 1);
      dlsi_triplets_add(&S->K, row, 2 * node_right(j % column) + k, -1);
    }
  S->model = (dls_model){.d = 2,
                         .n = row,
                         .nodes = across,
                         .operator_kind = DLS_STIFFNESS_SPARSE,
                         .factorization = DLS_LDLT};
  S->K.rows = S->K.cols = S->N.rows = S->T.rows = row;
  ck_assert(!dlsi_columns_compress(&S->K, 1, DLSI_ALL, &S->Kc, NULL));
  ck_assert(!dlsi_columns_compress(&S->N, 1, DLSI_ALL, &S->Nc, NULL));
  ck_assert(!dlsi_columns_compress(&S->T, 1, DLSI_ALL, &S->Tc, NULL));
  S->model.Ks = dlsi_columns_view(&S->Kc);
  S->model.HN = dlsi_columns_view(&S->Nc);
  S->model.HT = dlsi_columns_view(&S->Tc);
}

/* Checks r (s) and x (z) of the halves beside those of the whole (r, y). */
static void expect_whole(const double *s, const double *z, const double *y) {
  double scale = 0, force = 0;
  for (int k = 0; k < 2 * plates; k++)
    scale = fmax(scale, fabs(y[k]));
  for (int k = 0; k < 2 * across; k++)
    force = fmax(force, fabs(r[k]));
  for (int k = 0; k < 2 * across; k++)
    ck_assert_double_eq_tol(r[k], s[k], 1e-6 * force);
  for (int j = 0; j < column; j++)
    for (int k = 0; k < 2; k++) {
      const double left = z[2 * node_left(j) + k], right = z[2 * node_right(j) + k];
      ck_assert_double_eq_tol(left, right, joint_tol * scale);
      ck_assert_double_eq_tol(left, y[2 * node_of_whole(across, j) + k], 1e-6 * scale);
    }
}

/* The halves have W, r and x of the whole, by W and on K. */
TEST_EACH(tied_halves, 0, 2) {
  static double y[2 * plates], z[2 * plates + 4 * column], f[2 * plates + 4 * column];
  const int times = 1 + _i % 2;
  double mu[across], s[2 * across] = {0};
  solids whole, halves;
  dls_reduction *A, *B;
  dls_global *global;
  dls_contact P, Q;
  dls_error e = {0};
  for (int c = 0; c < across; c++)
    mu[c] = .3;
  make_whole(&whole);
  make_halves(&halves, times);
  memcpy(f, halves.f, 2 * plates * sizeof *f);
  ck_assert_msg(!reduce_on_W(&A, &whole.model, NULL, &e), "%s", e.message);
  ck_assert(!dls_reduction_load(A, whole.f, whole.g, NULL));
  ck_assert(!dls_reduction_solve(A, mu, NULL, r, NULL, y, &info, NULL));
  const dls_status status = reduce_on_W(&B, &halves.model, NULL, &e);
  ck_assert_msg(!status || (!WITH_MUMPS && status == DLS_E_UNSUPPORTED), "%s", e.message);
  if (!status) {
    ck_assert(!dls_reduction_contact(A, mu, &P, NULL) && !dls_reduction_contact(B, mu, &Q, NULL));
    for (int k = 0; k < P.W.rows * P.W.cols; k++)
      ck_assert_double_eq_tol(P.W.a[k], Q.W.a[k], 1e-11 * P.W.a[0]);
    ck_assert(!dls_reduction_load(B, f, halves.g, NULL));
    ck_assert(!dls_reduction_solve(B, mu, NULL, s, NULL, z, &info, NULL));
    ck_assert(!dls_reduction_get_info(B, &facts, NULL));
    ck_assert(facts.joints == 2 * column * times && facts.redundant == 2 * column * (times - 1));
    expect_whole(s, z, y);
  }
  ck_assert_msg(!dls_global_create(&global, &halves.model, &e), "%s", e.message);
  ck_assert_int_eq(dls_global_solve(global, f, halves.g, mu, NULL, s, z, &info, &e), DLS_OK);
  expect_whole(s, z, y);
  dls_global_destroy(global);
  dls_reduction_destroy(A);
  dls_reduction_destroy(B);
  solids_free(&whole);
  solids_free(&halves);
}

/* ---- statics without mass, proofs ------------------------------------------------------------ */

static void without_mass(void) {
  for (int k = 0; k < L.K.count; k++)
    if (L.K.row[k] == L.K.col[k]) L.K.x[k] = 0;
}

TEST_EACH(massless, 0, 12) {
  const double thrust = weight / tan(angle) / 2;
  lean(1 + _i % 3);
  without_mass();
  const dls_status status = solve_run(1 + 2 * (_i / 3), .8, 1e-10);
  ck_assert_msg(status == DLS_OK, "%s %g", dls_status_name(status), info.certificate.residual);
  ck_assert_double_eq_tol(r[0], weight, 1e-9);
  ck_assert_double_eq_tol(r[1], thrust, 1e-9);
  ck_assert_double_eq_tol(r[2], weight, 1e-9);
  ck_assert_double_eq_tol(r[3], -thrust, 1e-9);
}

/* Friction .7 holds no thrust of .731: the motion that proves it moves bodies, not forces. Joints
 * that contradict each other are proved by forces alone. */
TEST_EACH(proofs, 0, 4) {
  const int contradict = _i / 2, is_sparse = _i % 2;
  dls_global *global;
  dls_error e = {0};
  const double mu[2] = {.7, .7};
  lean(2);
  if (contradict)
    L.f[9] = .25;
  else
    without_mass();
  const dls_model *model = linkage_model(&L, DLS_LDLT, is_sparse);
  ck_assert(!dls_global_create(&global, model, &e));
  ck_assert_int_eq(dls_global_solve(global, L.f, NULL, mu, NULL, r, x, &info, &e), DLS_NO_SOLUTION);
  int body;
  const double *b = dls_global_motion(global, &body);
  ck_assert_ptr_nonnull(b);
  ck_assert_int_eq(body, contradict ? -1 : 0);
  double load = 0;
  for (int j = 0; j < L.n; j++) {
    double sum = 0;
    for (int k = 0; k < L.n; k++)
      sum += L.dense[k < j ? j + L.n * k : k + L.n * j] * b[k];
    ck_assert_double_le(fabs(sum), 1e-14);
    load += b[j] * L.f[j];
    ck_assert((j < 6) == !contradict || b[j] == 0);
  }
  ck_assert_double_gt(load, .01);
  ck_assert(contradict || load > .1);
  dls_global_destroy(global);
  if (!contradict) return;
  for (int run = 0; run < 4; run++) { /* no certificate for any x */
    linkage again = L;
    const dls_status status = answer(&again.model, run & 1, .8, 1e-8);
    ck_assert_int_eq(status, DLS_NO_SOLUTION);
  }
}

/* A pin that is pulled open by .125: b; on one side of two parallel cranks. */
TEST_EACH(prescribed, 0, runs) {
  const double end[2] = {.5, 0}, pin[2] = {-.5, 0};
  linkage_new(&L, 2);
  (void)linkage_body(&L, 2, 2. / 12, 0);
  for (int k = 0; k < 2; k++) {
    (void)linkage_tie(&L, 0, pin, -1, pin, (double[]){0, 1}, .125);
    (void)linkage_tie(&L, 0, end, -1, end, (double[]){1, 0}, 0);
  }
  linkage_contact(&L, 0, end);
  const dls_status status = solve_run(_i, .3, 1e-12);
  ck_assert_msg(status == DLS_OK, "%s %g", dls_status_name(status), info.certificate.residual);
  /* the free end does not move down: v_y = .0625, turn = -.125 about it; no load, so r_n is what
   * keeps the end: m / 4 - I = 1/2 - 1/6 over 1, times .125 */
  ck_assert_double_eq_tol(x[1], .0625, 1e-14);
  ck_assert_double_eq_tol(x[2], -.125, 1e-14);
  ck_assert_double_eq_tol(r[0], .125 * (2. / 4 - 2. / 12), 1e-13);
  ck_assert_msg(linkage_apart(&L, x) <= joint_tol, "%g", linkage_apart(&L, x));
}

/* ---- the certificate ------------------------------------------------------------------------- */

/* Measures (x, r) as changed by the caller. */
static dls_certificate certify(dls_reduction *reduction) {
  const double mu[100] = {.8, .8};
  dls_certificate c;
  ck_assert(!dls_reduction_certify(reduction, mu, r, x, NULL, &c, NULL));
  return c;
}

/* An open joint is a length over lengths, and a light body is not hidden by a heavy one. From 6 on
 * bar 0 has no inertia: a row without stiffness makes no length. */
TEST_EACH(wrong_pairs, 0, 12) {
  lean(2);
  L.K.x[0] = L.K.x[1] = 1e8; /* bar 0: mass, weight, inertia */
  L.K.x[2] = _i < 6 ? 1e8 / 12 : 0;
  L.f[1] *= 1e8;
  const double units[2] = {_i % 3 == 1 ? 1e9 : 1, _i % 3 == 2 ? 1e-9 : 1}; /* force, length */
  for (int k = 0; k < L.K.count; k++)
    L.K.x[k] *= L.K.row[k] < 6 ? units[0] / units[1] : 1;
  for (int k = 0; k < L.n; k++)
    L.f[k] *= k < 6 ? units[0] : units[1];
  const dls_model *model = linkage_model(&L, DLS_LDLT, _i / 3 % 2);
  const double mu[100] = {.8, .8};
  dls_reduction *reduction;
  ck_assert(!reduce_on_W(&reduction, model, NULL, NULL));
  ck_assert(!dls_reduction_load(reduction, L.f, NULL, NULL));
  ck_assert(dls_reduction_solve(reduction, mu, NULL, r, NULL, x, &info, NULL) >= 0);
  dls_certificate c = certify(reduction);
  ck_assert_msg(c.equilibrium <= 1e-11, "%g", c.equilibrium);
  const double scale = weight * units[1]; /* f over mass: the displacement that there is */
  x[4] += 1e-3 * scale;
  c = certify(reduction);
  ck_assert_msg(c.equilibrium > 1e-5 && c.equilibrium < 1e-2, "%g", c.equilibrium);
  x[4] -= 1e-3 * scale;
  ck_assert(certify(reduction).equilibrium <= 1e-11);
  r[2] *= .5; /* half of what holds the light bar */
  c = certify(reduction);
  ck_assert_msg(c.equilibrium > 1e-6, "%g", c.equilibrium);
  ck_assert_double_eq_tol(c.unbalanced / (weight * units[0]), .5, .5);
  dls_reduction_destroy(reduction);
}

/* ---- new values, memory ---------------------------------------------------------------------- */

/* Three cranks of one coupler: one joint is redundant while they are parallel. Turning one of them
 * locks the linkage; turning it back sets it free. */
static void cranks(double tilt) {
  linkage_new(&L, 2);
  for (int k = 0; k < 4; k++)
    (void)linkage_body(&L, 1, .1, 1);
  for (int k = 0; k < 3; k++) {
    const double a = k == 1 ? tilt : 1.1, C[2] = {cos(a) / 2, sin(a) / 2};
    linkage_pin(&L, k, (double[]){-C[0], -C[1]}, -1, origin);
    linkage_pin(&L, k, C, 3, (double[]){k - 1, 0});
  }
  linkage_contact(&L, 3, (double[]){.25, -.5});
}

TEST_EACH(updated, 0, 2) {
  const double tilts[] = {1.1, .9, 1.1}, mu[1] = {0};
  dls_reduction *reduction = NULL;
  dls_global *global = NULL;
  for (int k = 0; k < 3; k++) {
    linkage_free(&L);
    cranks(tilts[k]);
    const dls_model *model = linkage_model(&L, DLS_LDLT, _i);
    dls_error e = {0};
    if (k == 0) {
      ck_assert_msg(!reduce_on_W(&reduction, model, NULL, &e), "%s", e.message);
      ck_assert_msg(!dls_global_create(&global, model, &e), "%s", e.message);
    } else {
      ck_assert_msg(!dls_reduction_update(reduction, model, &e), "%s", e.message);
      ck_assert_msg(!dls_global_update(global, model, &e), "%s", e.message);
    }
    ck_assert(!dls_reduction_get_info(reduction, &facts, NULL));
    ck_assert_int_eq(facts.redundant, k != 1);
    ck_assert(!dls_reduction_load(reduction, L.f, NULL, NULL));
    ck_assert(!dls_reduction_solve(reduction, mu, NULL, r, NULL, x, &info, NULL));
    /* weights: the coupler, half of each crank; locked: the joints carry them */
    ck_assert_double_eq_tol(r[0], k == 1 ? 0 : 2.5, 1e-10);
    ck_assert(linkage_apart(&L, x) <= joint_tol);
    memset(r, 0, sizeof r);
    ck_assert(!dls_global_solve(global, L.f, NULL, mu, NULL, r, x, &info, &e));
    ck_assert_double_eq_tol(r[0], k == 1 ? 0 : 2.5, 1e-7);
    ck_assert(linkage_apart(&L, x) <= joint_tol);
  }
  dls_reduction_destroy(reduction);
  dls_global_destroy(global);
}

TEST_EACH(failing_mallocs, 0, 4) {
  const double mu[2] = {.8, .8};
  lean(2);
  if (_i & 1) L.f[9] = .25; /* the proof, too */
  const dls_model *model = linkage_model(&L, DLS_LDLT, _i & 2);
  dls_status status = DLS_E_MEMORY;
  for (long k = 1; status == DLS_E_MEMORY; k++) {
    dls_reduction *reduction;
    malloc_fails_at(k);
    status = reduce_on_W(&reduction, model, NULL, NULL);
    malloc_fails_at(0);
    ck_assert(status == DLS_OK || (status == DLS_E_MEMORY && !reduction));
    dls_reduction_destroy(reduction);
  }
  status = DLS_E_MEMORY;
  for (long k = 1; status == DLS_E_MEMORY; k++) {
    dls_global *global;
    malloc_fails_at(k);
    status = dls_global_create(&global, model, NULL);
    if (!status) status = dls_global_solve(global, L.f, NULL, mu, NULL, r, x, NULL, NULL);
    malloc_fails_at(0);
    dls_global_destroy(global);
  }
  ck_assert_int_eq(status, _i & 1 ? DLS_NO_SOLUTION : DLS_OK);
}

int main(void) {
  return run_tests("multipliers", NULL, free_linkage);
}
