/*
 * test_block.c: elastic blocks: on a fast belt, and on a path. Each step meets the energy identity
 * and the momentum balance (moving_step).
 */
#include "delassus/fe.h"
#include "moving.h"
#include "run.h"

static const double pi = 3.14159265358979323846;
static moving_parts parts;

/* ---- block on a belt ------------------------------------------------------------------------- */

enum { nx = 16, ny = 8, belt_nodes = nx + 1, belt_n = 2 * (nx + 1) * (ny + 1), belt_steps = 200 };

/* .2 x .1, E 1e7, nu .3, rho 1000, lumped mass, on the belt all along its lower edge. */
static void belt_build(double *load) {
  static double K[belt_n * belt_n];
  dls_fe_mesh mesh;
  const double rho = 1000, area = 0.2 / nx * 0.1 / ny / 2;
  double mass[belt_n] = {0};
  ck_assert_int_eq(dls_fe_mesh_block(&mesh, 0.2, 0.1, nx, ny, NULL), DLS_OK);
  ck_assert_int_eq(dls_fe_stiffness(&mesh, 1e7, 0.3, K, belt_n, NULL), DLS_OK);
  for (int k = 0; k < 3 * mesh.triangles; k++)
    for (int i = 0; i < 2; i++)
      mass[2 * mesh.node[k] + i] += rho * area / 3;
  moving_begin(&parts, belt_n);
  moving_add_dense(&parts.K, belt_n, K);
  for (int j = 0; j < belt_n; j++) {
    moving_add(&parts.M, j, j, mass[j]);
    load[j] = j % 2 ? -9.81 * mass[j] : 0;
  }
  for (int c = 0; c < belt_nodes; c++)
    moving_touch(&parts, 2 * c + 1, 2 * c, 0);
  dls_fe_mesh_free(&mesh);
}

/* Drives the belt with velocity V; p: impulses of all steps. */
static void belt_run(double V, double h, double tol, double *p) {
  static double load[belt_n];
  belt_build(load);
  const dls_motion_model model = moving_model(&parts);
  dls_motion_settings settings = moving_settings(DLS_MOTION_VELOCITY, h);
  settings.activation = 1e-9;
  if (tol > 0) settings.limits.tol = tol;
  dls_motion *motion = moving_create(&model, &settings, NULL, NULL);
  double y[2 * belt_nodes], mu[belt_nodes];
  for (int c = 0; c < belt_nodes; c++) {
    y[2 * c] = 0;
    y[2 * c + 1] = V;
    mu[c] = 0.5;
  }
  for (int k = 0; k < belt_steps; k++, p += (ptrdiff_t)2 * belt_nodes)
    memcpy(p, moving_step(motion, load, y, mu).p, 2 * belt_nodes * sizeof *p);
  dls_motion_destroy(motion);
}

/* The belt outruns the block, so that all that press slip one way and r does not depend on V: the
 * run at V = 1 has the reactions of the others. Asked to 1e-6 in each of 200 steps, at V 10 with h
 * 1e-7 and V 1000 with h 1e-5, where |q| is V and the weight moves q_n by g h; with the tolerance
 * of a motion, and with 1e-8, that of a solver. */
TEST_EACH(test_belt, 0, 4) {
  static double slow[2 * belt_nodes * belt_steps], fast[2 * belt_nodes * belt_steps];
  const double h = _i % 2 ? 1e-5 : 1e-7, V = _i % 2 ? 1000 : 10, tol = _i < 2 ? 0 : 1e-8;
  belt_run(1, h, 1e-14, slow);
  belt_run(V, h, tol, fast);
  for (int k = 0; k < belt_steps; k++) {
    const int at = 2 * belt_nodes * k;
    double error = 0, size = 0;
    for (int i = at; i < at + 2 * belt_nodes; i++) {
      error = fmax(error, fabs(fast[i] - slow[i]));
      size = fmax(size, fabs(slow[i]));
      if (i % 2) ck_assert_double_eq_tol(fast[i], 0.5 * fast[i - 1], 1e-6 * size + 1e-300);
    }
    ck_assert_double_gt(size, 0);
    ck_assert_msg(error <= 1e-6 * size, "step %d: %g of %g", k, error, size);
  }
}

/* ---- warm start ------------------------------------------------------------------------------ */

typedef struct warm_run {
  int sweeps;
  double change;            /* mean of |p - p before| / |p| */
  double p[2 * belt_nodes]; /* of the last step */
} warm_run;

static double warm_norm(const double *a, const double *b) {
  double sum = 0;
  for (int i = 0; i < 2 * belt_nodes; i++)
    sum += (a[i] - b[i]) * (a[i] - b[i]);
  return sqrt(sum);
}

/* Moves the block, from rest, for 200 steps on the belt: by dynamics, h = 1e-4, or on a path, held
 * by springs at all nodes and pressed harder and harder. */
static warm_run warm_go(dls_motion_law law, double tol, int warm) {
  static double load[belt_n], f[belt_n];
  const double none[2 * belt_nodes] = {0};
  belt_build(load);
  dls_motion_model model = moving_model(&parts);
  if (law == DLS_MOTION_PATH) {
    model.M.p = NULL;
    for (int j = 0; j < belt_n; j++)
      parts.K.x[parts.K.p[j]] += 1e4; /* the diagonal comes first */
  }
  dls_motion_settings settings = moving_settings(law, 1e-4);
  if (law == DLS_MOTION_VELOCITY) settings.activation = 1e-9;
  settings.method = DLS_NLGS;
  settings.limits.tol = tol;
  settings.limits.warm_start = warm;
  dls_motion *motion = moving_create(&model, &settings, NULL, NULL);
  double y[2 * belt_nodes] = {0}, mu[belt_nodes];
  for (int c = 0; c < belt_nodes; c++) {
    y[2 * c + 1] = 0.05;
    mu[c] = 0.5;
  }
  warm_run run = {0};
  const double *p = moving_state(motion).p;
  for (int k = 0; k < belt_steps; k++) {
    for (int j = 0; j < belt_n; j++)
      f[j] = law == DLS_MOTION_PATH ? load[j] * (100 + k) : load[j];
    dls_info info;
    ck_assert_int_eq(dls_motion_step(motion, f, y, mu, &info, NULL), DLS_OK);
    run.sweeps += info.iterations;
    const double size = warm_norm(p, none);
    if (k > 0 && size > 0) run.change += warm_norm(p, run.p) / size / (belt_steps - 1);
    memcpy(run.p, p, sizeof run.p);
  }
  dls_motion_destroy(motion);
  return run;
}

/* A sweep gains a fixed factor, so a warm start saves those that a cold one needs to come as near
 * as p of the step before: log(1/change) of log(1/tol). Where p changes by .55 % in a step, on
 * this path, that is a fifth of the sweeps at 1e-12, and more than half of them at 1e-4. */
TEST_EACH(test_warm, 0, 4) {
  const dls_motion_law law = _i < 2 ? DLS_MOTION_VELOCITY : DLS_MOTION_PATH;
  const double tol = _i % 2 ? 1e-4 : 1e-12;
  const warm_run cold = warm_go(law, tol, 0), warm = warm_go(law, tol, 1);
  ck_assert_int_lt(warm.sweeps, cold.sweeps);
  if (tol < 1e-8) {
    const double none[2 * belt_nodes] = {0};
    ck_assert_double_le(warm_norm(warm.p, cold.p), 1e-8 * warm_norm(cold.p, none));
  }
  if (law == DLS_MOTION_VELOCITY) return;
  ck_assert_double_eq_tol(warm.change, 0.0055, 0.0001);
  const double saved = 1 - (double)warm.sweeps / cold.sweeps, whole = log(1 / tol);
  if (tol < 1e-8)
    ck_assert_double_eq_tol(saved, log(1 / warm.change) / whole, 0.05);
  else
    ck_assert_double_ge(saved, 0.5);
}

/* ---- the Jean block on a moving plane -------------------------------------------------------- */

/* Returns what friction takes in the second cycle of y_t = a sin 2 pi t, `steps` to a cycle. */
static double jean_loss(const char *name, int weighted, double a, int steps) {
  dls_fe_scene *scene;
  dls_fe_scene_data data;
  ck_assert_int_eq(dls_fe_scene_create(&scene, name, weighted, NULL), DLS_OK);
  dls_fe_scene_get(scene, &data);
  const dls_model *m = &data.model;
  double gap[2 * belt_nodes], y[2 * belt_nodes] = {0};
  moving_begin(&parts, m->n);
  moving_add_dense(&parts.K, m->n, m->K.a);
  for (int c = 0; c < m->nodes; c++)
    gap[c] = data.g[2 * c];
  dls_motion_model model = moving_model(&parts);
  model.nodes = m->nodes;
  model.HN = m->HN;
  model.HT = m->HT;
  model.P = m->P;
  model.gap = gap;
  const dls_motion_settings settings = moving_settings(DLS_MOTION_PATH, 1.0 / steps);
  dls_motion *motion = moving_create(&model, &settings, NULL, NULL);
  double first = 0;
  for (int k = 0; k < 2 * steps; k++) {
    const double from = sin(2 * pi * k / steps), to = sin(2 * pi * (k + 1) / steps);
    for (int c = 0; c < m->nodes; c++)
      y[2 * c + 1] = a * (to - from) * steps;
    (void)moving_step(motion, data.f, y, data.mu);
    if (k + 1 == steps) first = moving_energies(motion).friction;
  }
  const double loss = first - moving_energies(motion).friction;
  dls_motion_destroy(motion);
  dls_fe_scene_destroy(scene);
  return loss;
}

/* J/m, as an independent program has them; a small amplitude shakes down: all sticks in the second
 * cycle. The weighted candidates carry their slip as well: they shake down at a smaller amplitude,
 * and their losses are of the same size. */
TEST(test_jean) {
  ck_assert_double_eq_tol(jean_loss("jean-fig3", 0, 1e-5, 400), 9.35233, 1e-5);
  ck_assert_double_eq_tol(jean_loss("jean-fig3", 0, 1e-5, 1600), 9.35443, 1e-5);
  ck_assert_double_eq_tol(jean_loss("jean-fig3", 0, 4e-5, 400), 200.97623, 1e-5);
  ck_assert_double_eq_tol(jean_loss("jean-fig4", 0, 1e-5, 400), 6.53362, 1e-5);
  ck_assert_double_le(fabs(jean_loss("jean-fig3", 0, 1e-6, 400)), 1e-9);
  ck_assert_double_le(fabs(jean_loss("jean-fig3", 1, 1e-7, 400)), 1e-9);
  ck_assert_double_eq_tol(jean_loss("jean-fig4", 1, 1e-5, 400), 6.53362, 0.1);
}

/* ---- two blocks ------------------------------------------------------------------------------ */

enum { wide = 8, tall = 6, pair_line = wide + 1, pair_nodes = pair_line * (tall + 1) };
enum { pair_n = 2 * pair_nodes - 2 * pair_line, whole_n = 2 * pair_line * 2 * tall };

/* Adds K of a block of wide x tall elements per unit, without the unknowns of its first `fixed`
 * nodes, at unknown `first`. */
static void pair_add(int rows, int fixed, int first, moving_matrix *A) {
  static double K[4 * pair_line * pair_line * (2 * tall + 1) * (2 * tall + 1)];
  dls_fe_mesh mesh;
  ck_assert_int_eq(dls_fe_mesh_block(&mesh, 1, 0.5 * rows / tall, wide, rows, NULL), DLS_OK);
  const int n = 2 * mesh.nodes;
  ck_assert_int_eq(dls_fe_stiffness(&mesh, 1, 0.3, K, n, NULL), DLS_OK);
  for (int j = 2 * fixed; j < n; j++)
    for (int i = j; i < n; i++)
      if (K[i + j * n] != 0)
        moving_add(A, first + i - 2 * fixed, first + j - 2 * fixed, K[i + j * n]);
  dls_fe_mesh_free(&mesh);
}

/* Loads the last line of nodes: the pressure p, the shear t. f: n. */
static void pair_load(double *f, int n, double p, double t) {
  memset(f, 0, (size_t)n * sizeof *f);
  for (int c = 0; c <= wide; c++) {
    const double share = (c == 0 || c == wide ? 0.5 : 1) / wide;
    f[n - 2 * pair_line + 2 * c] = t * share;
    f[n - 2 * pair_line + 2 * c + 1] = -p * share;
  }
}

/* An upper block that nothing but contact holds stands on a lower one, pressed and then sheared;
 * all sticks: the answer is that of one block, to 1e-11, and the free body is in equilibrium to
 * 1e-12. */
TEST(test_two_blocks) {
  enum { n = pair_n + 2 * pair_nodes };
  moving_begin(&parts, n);
  pair_add(tall, pair_line, 0, &parts.K);
  pair_add(tall, 0, pair_n, &parts.K);
  for (int c = 0; c < pair_line; c++) {
    for (int k = 1; k >= 0; k--) {
      moving_matrix *L = k ? &parts.HN : &parts.HT;
      moving_add(L, pair_n - 2 * pair_line + 2 * c + k, c, -1);
      moving_add(L, pair_n + 2 * c + k, c, 1);
    }
    parts.nodes++;
  }
  const dls_motion_model model = moving_model(&parts);
  dls_motion_settings settings = moving_settings(DLS_MOTION_PATH, 1);
  dls_motion *motion = moving_create(&model, &settings, NULL, NULL);

  static moving_parts one;
  moving_begin(&one, whole_n);
  pair_add(2 * tall, pair_line, 0, &one.K);
  moving_touch(&one, whole_n - 1, whole_n - 2, 1e3);
  const dls_motion_model whole_model = moving_model(&one);
  dls_motion *whole = moving_create(&whole_model, &settings, NULL, NULL);

  static double f[n], F[whole_n];
  double mu[pair_line];
  for (int c = 0; c < pair_line; c++)
    mu[c] = 2;
  for (int k = 0; k < 4; k++) {
    const double t = 5e-5 * k;
    pair_load(f, n, 1e-3, t);
    pair_load(F, whole_n, 1e-3, t);
    const dls_motion_state s = moving_step(motion, f, NULL, mu);
    const dls_motion_state w = moving_step(whole, F, NULL, NULL);
    double error = 0, size = 0, up = -1e-3, back = t, turn = 0;
    for (int i = 0; i < whole_n; i++) {
      const int twice = i >= pair_n ? i + 2 * pair_line : i; /* the interface stands twice */
      error = fmax(error, fabs(s.x[twice] - w.x[i]));
      if (i >= pair_n - 2 * pair_line && i < pair_n)
        error = fmax(error, fabs(s.x[i + 2 * pair_line] - w.x[i]));
      size = fmax(size, fabs(w.x[i]));
    }
    for (int c = 0; c < pair_line; c++) {
      up += s.p[2 * c];
      back += s.p[2 * c + 1];
      turn += s.p[2 * c] * (c - wide / 2) / wide;
      if (k) ck_assert_int_eq(s.state[c], DLS_STICK);
    }
    turn -= 0.5 * t;
    ck_assert_msg(error <= 1e-11 * size, "%d: %g of %g", k, error, size);
    ck_assert_double_le(fmax(fabs(up), fmax(fabs(back), fabs(turn))), 1e-12 * 1e-3);
  }
  dls_motion_destroy(motion);
  dls_motion_destroy(whole);
}
