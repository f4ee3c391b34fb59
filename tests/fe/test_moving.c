/*
 * test_moving.c: runs the scenes of moving bodies and compares them with closed forms, with figures
 * of another program with the same scheme (impulses to 1e-4, norms to 3 %, dissipations to 1e-5),
 * and with a monolithic block.
 */
#include "delassus/moving.h"
#include "fe/moving_internal.h"
#include "run.h"

static dls_error error;

static dls_moving_settings defaults(void) {
  dls_moving_settings s;
  dls_moving_settings_init(&s);
  return s;
}

static dls_moving *create(const char *name, const dls_moving_settings *settings,
                          dls_moving_data *data) {
  dls_moving *moving;
  const dls_status status = dls_moving_create(&moving, name, settings, &error);
  ck_assert_msg(status == DLS_OK, "%s: %s", name, error.message);
  dls_moving_get(moving, data);
  return moving;
}

/* Takes `count` steps; the identity of energies and the balance of momentum must hold in each. */
static void advance(dls_moving *moving, int count, dls_moving_data *data) {
  for (int k = 0; k < count; k++) {
    const dls_status status = dls_moving_step(moving, &error);
    ck_assert_msg(status == DLS_OK, "step %d: %s, %s", k, dls_status_name(status), error.message);
    dls_moving_get(moving, data);
    ck_assert_double_le(data->energy.residual, 1e-13 * data->energy.scale);
    ck_assert_double_le(data->energy.momentum, 1e-11);
  }
}

/* Runs a whole scene; data without its views. */
static dls_moving_data whole(const char *name, const dls_moving_settings *settings) {
  dls_moving_data data;
  dls_moving *moving = create(name, settings, &data);
  advance(moving, data.steps, &data);
  dls_moving_destroy(moving);
  return data;
}

static double energy_left(const dls_moving_data *d) {
  return (d->energy.kinetic + d->energy.elastic) / d->energy_start;
}

static void expect(double value, double wanted, double relative) {
  ck_assert_msg(fabs(value - wanted) <= relative * fabs(wanted), "%.10g, wanted %.10g to %g", value,
                wanted, relative);
}

/* ---- bars ------------------------------------------------------------------------------------ */

/* Lumped mass, theta 1/2, e 0: one impact of the lowest node takes (l / L) sqrt(1 + nu^2) / 2 of
 * the energy, nu the Courant number. */
TEST_EACH(impact_of_a_lumped_bar, 0, 3) {
  const int nx[] = {50, 20, 50};
  const double courant[] = {0.9, 0.5, 0.5};
  dls_moving_settings s = defaults();
  s.mass = DLS_FE_LUMPED;
  s.nx = nx[_i];
  s.courant = courant[_i];
  const dls_moving_data d = whole("bar-impact", &s);
  const double nu = s.courant;
  expect(1 - energy_left(&d), sqrt(1 + nu * nu) / 2 / s.nx, 1e-9);
  if (_i == 0) expect(1 - energy_left(&d), 0.01345362, 1e-6);
}

TEST(impact) {
  dls_moving_settings s = defaults();
  dls_moving_data d = whole("bar-impact", &s);
  expect(d.impulse[0], 198.845083, 1e-8);
  expect(d.gap_error, 2.394e-2, 0.03);
  ck_assert_double_lt(d.variation, 800);
  s.nx = 400;
  d = whole("bar-impact", &s);
  expect(d.gap_error, 7.21e-3, 0.03);
  s.nx = 100;
  s.theta = 1;
  d = whole("bar-impact", &s);
  expect(energy_left(&d), 0.8312, 1e-4);
}

TEST(bounce) {
  dls_moving_settings s = defaults();
  s.nx = 400;
  const dls_moving_data d = whole("bar-bounce", &s);
  expect(d.impulse[0], 532.666, 1e-4);
  expect(d.gap_error, 9.65e-3, 0.03);
}

TEST(fixed) {
  const int nx[] = {100, 400};
  const double norm[] = {2.951e-2, 1.079e-2}, left[] = {0.991392, 0.997618};
  for (int k = 0; k < 2; k++) {
    dls_moving_settings s = defaults();
    s.nx = nx[k];
    const dls_moving_data d = whole("bar-fixed", &s);
    expect(d.gap_error, norm[k], 0.03);
    expect(energy_left(&d), left[k], 1e-6);
  }
}

TEST(fixed_order) { /* >= .6 between 50 and 800 elements */
  double norm[2];
  for (int k = 0; k < 2; k++) {
    dls_moving_settings s = defaults();
    s.nx = k ? 800 : 50;
    norm[k] = whole("bar-fixed", &s).gap_error;
  }
  ck_assert_double_ge(log(norm[0] / norm[1]) / log(16), 0.6);
}

/* The order of the error of the gap over 25, 50, .., 400 elements: the slope of log(error) over
 * log(h), least squares. h halves from mesh to mesh, so that the weights are 2, 1, 0, -1, -2. */
TEST_EACH(orders, 0, 3) {
  static const char *const name[] = {"bar-impact", "bar-bounce", "bar-fixed"};
  static const double published[] = {0.87, 0.68, 0.76};
  double sum = 0, first = 0;
  for (int k = 0; k < 5; k++) {
    dls_moving_settings s = defaults();
    s.nx = 25 << k;
    const dls_moving_data d = whole(name[_i], &s);
    if (k == 0) first = d.element;
    expect(d.element, first / (1 << k), 1e-14);
    sum += (2 - k) * log(d.gap_error);
  }
  expect(sum / (10 * log(2)), published[_i], 0.01);
}

/* The closed forms: gaps are continuous and >= 0, forces push only where the gap is 0, impulses are
 * those of the weight or of the turned momentum, and the end is the start again. */
TEST_EACH(closed_forms, 0, 3) {
  dlsi_moving_exact *const exact[] = {dlsi_exact_impact, dlsi_exact_bounce, dlsi_exact_fixed};
  const double time[] = {1.5, 16.0 / 3, 3}, impulse[] = {200, 1600.0 / 3, 0.5};
  const double speed[] = {10, 20, 0.5}; /* of the end, at most */
  enum { count = 300000 };
  const double h = time[_i] / count;
  double sum = 0, gap, force, before, start;
  exact[_i](0, &before, &force);
  start = before;
  for (int k = 1; k <= count; k++) {
    exact[_i]((k - 0.5) * h, &gap, &force);
    sum += h * force;
    ck_assert(force >= 0 && (force == 0 || gap == 0));
    exact[_i](k * h, &gap, &force);
    ck_assert_double_ge(gap, -1e-12);
    ck_assert_double_le(fabs(gap - before), 1.001 * speed[_i] * h);
    before = gap;
  }
  expect(sum, impulse[_i], 1e-4);
  if (_i > 0) ck_assert_double_le(fabs(before - start), 1e-9);
}

/* ---- blocks ---------------------------------------------------------------------------------- */

TEST_EACH(jean, 0, 6) { /* friction's work in the second cycle */
  static const struct {
    const char *name;
    int law, steps;
    double amplitude, work, loop;
  } run[] = {{"jean-moving", 0, 800, 1e-5, 9.35233, 9.35478},
             {"jean-moving", 0, 3200, 1e-5, 9.35443, 0},
             {"jean-moving", 0, 800, 4e-5, 200.97623, 0},
             {"jean-moving4", 0, 800, 1e-5, 6.53362, 0},
             {"jean-moving", DLS_MOTION_GAP, 800, 1e-5, 9.352326, 0},
             {"jean-moving", 0, 800, 1e-6, 0, 0}};
  dls_moving_settings s = defaults();
  s.law = (dls_motion_law)run[_i].law;
  s.steps = run[_i].steps;
  s.amplitude = run[_i].amplitude;
  dls_moving_data d;
  dls_moving *moving = create(run[_i].name, &s, &d);
  advance(moving, d.cycle, &d);
  const double first = d.energy.friction;
  double loop = 0, force = 0, place = d.obstacle;
  for (int c = 0; c < d.candidates; c++)
    force += d.r[2 * c + 1];
  for (int k = 0; k < d.cycle; k++) {
    advance(moving, 1, &d);
    double next = 0;
    for (int c = 0; c < d.candidates; c++)
      next += d.r[2 * c + 1];
    loop += (force + next) / 2 * (d.obstacle - place);
    force = next;
    place = d.obstacle;
  }
  const double work = first - d.energy.friction;
  if (run[_i].work > 0)
    expect(work, run[_i].work, 1e-5);
  else
    ck_assert_double_le(fabs(work), 1e-9); /* it has shaken down */
  if (run[_i].loop > 0) expect(loop, run[_i].loop, 1e-5);
  dls_moving_destroy(moving);
}

TEST(drop) {
  dls_moving_data d;
  dls_moving *moving = create("block-drop", NULL, &d);
  int slipping = 1;
  for (int k = 0; k < d.steps; k++) {
    advance(moving, 1, &d);
    for (int c = 0; c < d.candidates; c++)
      slipping &= d.state.state[c] != DLS_STICK;
    if (slipping && d.impulse[0] > 0) expect(d.impulse[1], -0.3 * d.impulse[0], 1e-12);
  }
  ck_assert_int_eq(slipping, 1);
  expect(d.impulse[0], 39.767150, 1e-7);
  expect(d.energy.friction, -17.06728, 1e-5);
  expect(d.energy.impact, -0.81594, 1e-5);
  double mass = 0, momentum[2] = {0};
  for (int j = 0; j < d.model->n; j++)
    for (int k = d.model->M.p[j]; k < d.model->M.p[j + 1]; k++) {
      mass += d.model->M.x[k] / 2;
      momentum[j % 2] += d.model->M.x[k] * d.state.v[j];
    }
  expect(mass, 20, 1e-12);
  expect(momentum[0] / mass, 1.403493, 1e-6);
  expect(momentum[1] / mass, 0.694057, 1e-6);
  dls_moving_destroy(moving);
}

/* ---- two blocks ------------------------------------------------------------------------------ */

/* x := K^-1 x by the rows of the Cholesky factor L. */
static void substitute(const double *L, int n, double *x) {
  for (int i = 0; i < n; i++) {
    for (int k = 0; k < i; k++)
      x[i] -= L[i * n + k] * x[k];
    x[i] /= L[i * n + i];
  }
  for (int i = n - 1; i >= 0; i--) {
    for (int k = i + 1; k < n; k++)
      x[i] -= L[k * n + i] * x[k];
    x[i] /= L[i * n + i];
  }
}

/* x := K^-1 f, K sparse, symmetric, positive definite, by a dense Cholesky factor; refined by
 * residuals in long double, so that x is right to the last digits. */
static void solve_dense(const dls_sparse *K, const double *f, double *x) {
  const int n = K->rows;
  double *L = calloc((size_t)n * (size_t)n, sizeof *L), *left = calloc((size_t)n, sizeof *left);
  long double *sum = calloc((size_t)n, sizeof *sum);
  ck_assert(L && left && sum);
  for (int j = 0; j < n; j++)
    for (int k = K->p[j]; k < K->p[j + 1]; k++)
      L[K->i[k] * n + j] = K->x[k]; /* rows one after the other */
  for (int i = 0; i < n; i++)
    for (int j = 0; j <= i; j++) {
      double s = L[i * n + j];
      for (int k = 0; k < j; k++)
        s -= L[i * n + k] * L[j * n + k];
      L[i * n + j] = i == j ? sqrt(s) : s / L[j * n + j];
    }
  for (int turn = 0; turn < 4; turn++) {
    for (int i = 0; i < n; i++)
      sum[i] = f[i];
    for (int j = 0; j < n; j++)
      for (int k = K->p[j]; k < K->p[j + 1]; k++)
        sum[K->i[k]] -= (long double)K->x[k] * x[j];
    for (int i = 0; i < n; i++)
      left[i] = (double)sum[i];
    substitute(L, n, left);
    for (int i = 0; i < n; i++)
      x[i] += left[i];
  }
  free(L);
  free(left);
  free(sum);
}

enum { bx = 16, by = 8 }; /* of each block */

/* Computes the block of both heights in one piece under pressure and shear; D: 2 nodes. */
static void monolithic(double E, double nu, double *D) {
  const double pressure = 1e6, shear = 0.2e6;
  dls_fe_mesh mesh;
  dls_fe_matrix K;
  ck_assert_int_eq(dls_fe_mesh_quads(&mesh, 0.1, 0.1, bx, 2 * by, NULL), DLS_OK);
  const int N = 2 * mesh.nodes;
  int *unknown = malloc((size_t)N * sizeof *unknown), n = 0;
  double *F = calloc((size_t)N, sizeof *F), *f = calloc((size_t)N, sizeof *f);
  double *x = calloc((size_t)N, sizeof *x);
  ck_assert(unknown && F && f && x);
  for (int k = 0; k < N; k++)
    unknown[k] = k == 0 || (k % 2 && k / 2 <= bx) ? -1 : n++;
  const int top = mesh.nodes - bx - 1;
  for (int e = 0; e < bx; e++) {
    ck_assert_int_eq(dls_fe_edge_load(&mesh, e, e + 1, -shear, 0, F, NULL), DLS_OK);
    ck_assert_int_eq(dls_fe_edge_load(&mesh, top + e, top + e + 1, shear, -pressure, F, NULL),
                     DLS_OK);
  }
  ck_assert_int_eq(dls_fe_sparse_stiffness(&mesh, E, nu, unknown, n, &K, NULL), DLS_OK);
  for (int k = 0; k < N; k++)
    if (unknown[k] >= 0) f[unknown[k]] = F[k];
  solve_dense(&K.A, f, x);
  for (int k = 0; k < N; k++)
    D[k] = unknown[k] < 0 ? 0 : x[unknown[k]];
  free(unknown);
  free(F);
  free(f);
  free(x);
  dls_fe_matrix_free(&K);
  dls_fe_mesh_free(&mesh);
}

TEST(blocks_in_one_piece) {
  static double D[2 * (bx + 1) * (2 * by + 1)];
  dls_moving_settings s = defaults();
  s.mu = 10;
  s.steps = 40;
  s.nx = s.upper = bx;
  s.ny = by;
  dls_moving_data d;
  dls_moving *moving = create("two-blocks", &s, &d);
  advance(moving, d.steps, &d);
  for (int c = 0; c < d.candidates; c++)
    ck_assert_int_eq(d.state.state[c], DLS_STICK);
  monolithic(d.E, d.nu, D);
  const int lower = 2 * (bx + 1) * (by + 1), size = 2 * (bx + 1) * (2 * by + 1);
  double most = 0, worst = 0;
  for (int k = 0; k < size; k++)
    most = fmax(most, fabs(D[k]));
  for (int k = 0; k < 2 * d.mesh->nodes; k++) {
    const double off = d.displacement[k] - D[k < lower ? k : k - 2 * (bx + 1)];
    worst = fmax(worst, fabs(off));
  }
  ck_assert_double_le(worst, 1e-11 * most);
  dls_moving_destroy(moving);
}

/* Returns the part under the hat function of candidate c of the upper edge. */
static double share_of(const dls_moving_data *d, int c) {
  const double *xy = d->mesh->xy;
  const int *node = d->candidate_node, last = d->candidates - 1;
  return (xy[2 * node[c < last ? c + 1 : c]] - xy[2 * node[c > 0 ? c - 1 : c]]) / 2;
}

/* Uniform pressure over lines of nodes that do not match, to rounding: the springs that hold the
 * upper block make W 10 times larger than the blocks do, which is lost in the reactions. */
TEST_EACH(blocks_patch, 7, 20) {
  const double pressure = 1e6;
  dls_moving_settings s = defaults();
  s.upper = _i;
  dls_moving_data d;
  dls_moving *moving = create("two-blocks", &s, &d);
  advance(moving, d.cycle, &d);
  for (int c = 0; c < d.candidates; c++) {
    expect(d.r[2 * c], pressure * share_of(&d, c), 1e-11);
    ck_assert_double_le(fabs(d.r[2 * c + 1]), 1e-11 * pressure * share_of(&d, c));
  }
  double *stress = malloc(3 * (size_t)d.mesh->quads * sizeof *stress);
  ck_assert_ptr_nonnull(stress);
  ck_assert_int_eq(dls_fe_stress(d.mesh, d.E, d.nu, d.displacement, stress, NULL), DLS_OK);
  for (int k = 0; k < 3 * d.mesh->quads; k++)
    ck_assert_double_le(fabs(stress[k] + (k % 3 == 1 ? pressure : 0)), 1e-11 * pressure);
  free(stress);
  dls_moving_destroy(moving);
}

/* The reactions hold the upper block: resultants and moment about the middle of its lower edge, at
 * the end of the shear, where some candidates slip. */
TEST(blocks_equilibrium) {
  const double load = 1e6 * 0.1, shear = 0.2e6 * 0.1, height = 0.05, middle = 0.05;
  dls_moving_data d;
  dls_moving *moving = create("two-blocks", NULL, &d);
  int slipped = 0;
  for (int k = 0; k < d.steps; k++) {
    advance(moving, 1, &d);
    const double part[2] = {fmin(k + 1, d.cycle) / d.cycle, fmax(k + 1 - d.cycle, 0) / d.cycle};
    double sum[3] = {0};
    for (int i = d.candidate_node[0]; i < d.mesh->nodes; i++) {
      sum[0] += d.reaction[2 * i];
      sum[1] += d.reaction[2 * i + 1];
      sum[2] += (d.mesh->xy[2 * i] - middle) * d.reaction[2 * i + 1];
    }
    ck_assert_double_le(fabs(sum[0] + part[1] * shear), 1e-12 * load);
    ck_assert_double_le(fabs(sum[1] - part[0] * load), 1e-12 * load);
    ck_assert_double_le(fabs(sum[2] - part[1] * shear * height), 1e-12 * load * height);
    for (int c = 0; c < d.candidates; c++)
      slipped += d.state.state[c] == DLS_SLIP;
  }
  ck_assert_int_gt(slipped, 0);
  ck_assert_double_lt(d.energy.friction, 0);
  dls_moving_destroy(moving);
}

TEST(blocks_with_mass) { /* slowly enough, they come to the same forces */
  dls_moving_settings s = defaults();
  s.law = DLS_MOTION_GAP;
  s.steps = 100;
  const dls_moving_data d = whole("two-blocks", &s);
  ck_assert_double_lt(d.energy.kinetic, 1e-2 * d.energy.elastic);
}

TEST(mortar) {
  const double a[] = {0, 0.3, 0.5, 1, 1.2}, b[] = {0, 0.1, 0.5, 0.7, 0.9, 1.2};
  enum { na = 5, nb = 6 };
  double A[na * na], B[na * nb], w[na], column[na + nb] = {0};
  dlsi_mortar_line(na, a, nb, b, A, B);
  for (int i = 0; i < na; i++) {
    w[i] = (a[i < na - 1 ? i + 1 : i] - a[i > 0 ? i - 1 : i]) / 2;
    double sum[4] = {0}; /* of 1 and of x, on both lines */
    for (int j = 0; j < na; j++) {
      sum[0] += A[i * na + j];
      sum[1] += A[i * na + j] * a[j];
      column[j] += w[i] * A[i * na + j];
    }
    for (int j = 0; j < nb; j++) {
      sum[2] += B[i * nb + j];
      sum[3] += B[i * nb + j] * b[j];
      column[na + j] += w[i] * B[i * nb + j];
    }
    ck_assert_double_eq_tol(sum[0], 1, 1e-15 * 4);
    ck_assert_double_eq_tol(sum[2], 1, 1e-15 * 4);
    ck_assert_double_eq_tol(sum[1], sum[3], 1e-15 * 4); /* equal linear fields: no jump */
  }
  assert_near(column, w, na, 1e-15); /* a constant pressure gives its nodal forces on both lines */
  for (int j = 0; j < nb; j++)
    ck_assert_double_eq_tol(column[na + j], (b[j < nb - 1 ? j + 1 : j] - b[j > 0 ? j - 1 : j]) / 2,
                            1e-15);
}

/* ---- input ----------------------------------------------------------------------------------- */

TEST(names) {
  int count = 0;
  for (; dls_moving_name(count); count++) {
    ck_assert_ptr_nonnull(dls_moving_description(count));
    dls_moving_data d;
    dls_moving *moving = create(dls_moving_name(count), NULL, &d);
    ck_assert_str_eq(d.name, dls_moving_name(count));
    ck_assert(d.step == 0 && d.steps > 0 && d.h > 0 && d.candidates > 0);
    ck_assert_double_eq(d.gap_error, 0);
    dls_moving_destroy(moving);
  }
  ck_assert_int_eq(count, 7);
  ck_assert(!dls_moving_name(-1) && !dls_moving_description(count));
}

TEST(bad_input) {
  const char *make = "dls_moving_create";
  dls_moving *m = (dls_moving *)(void *)&error;
  REFUSES(ARGUMENT, "out", -1, dls_moving_create, NULL, "bar-impact", NULL);
  REFUSES(ARGUMENT, "name", -1, dls_moving_create, &m, NULL, NULL);
  ck_assert_ptr_null(m);
  REFUSES(ARGUMENT, "name", -1, dls_moving_create, &m, "bar", NULL);
  dls_moving_settings s = {0};
  REFUSES(SETTINGS, "settings", -1, dls_moving_create, &m, "bar-impact", &s);
#define REFUSED(field, value, name)                                                                \
  do {                                                                                             \
    s = defaults();                                                                                \
    s.field = value;                                                                               \
    expect_error(dls_moving_create(&m, "bar-impact", &s, &error), &error, DLS_E_ARGUMENT, make,    \
                 name, -1);                                                                        \
  } while (0)
  REFUSED(theta, 0.49, "theta");
  REFUSED(theta, 1.01, "theta");
  REFUSED(theta, NAN, "theta");
  REFUSED(restitution, 1.5, "restitution");
  REFUSED(restitution, NAN, "restitution");
  REFUSED(mass, (dls_fe_mass_kind)3, "mass");
  REFUSED(law, (dls_motion_law)4, "law");
  REFUSED(law, DLS_MOTION_PATH, "law");
  REFUSED(method, (dls_method)99, "method");
  REFUSED(steps, -1, "steps");
  REFUSED(nx, -1, "nx");
  REFUSED(ny, -1, "ny");
  REFUSED(upper, -1, "upper");
  REFUSED(courant, -1, "courant");
  REFUSED(courant, INFINITY, "courant");
  REFUSED(mu, NAN, "mu");
  REFUSED(amplitude, NAN, "amplitude");
  REFUSED(frequency, NAN, "frequency");
  REFUSED(limits.tol, -1, "tol");
  s = defaults();
  s.ny = 9;
  REFUSES(ARGUMENT, "nx", -1, dls_moving_create, &m, "jean-moving", &s);
  s = defaults();
  s.law = DLS_MOTION_GAP;
  s.theta = 0.5; /* its pressure does not converge */
  REFUSES(ARGUMENT, "theta", -1, dls_moving_create, &m, "bar-impact", &s);
  ck_assert_ptr_null(m);
  REFUSES(ARGUMENT, "moving", -1, dls_moving_step, NULL);
  s = defaults();
  s.steps = 2;
  dls_moving_data d, after;
  m = create("two-blocks", &s, &d);
  advance(m, 2, &d);
  REFUSES(ARGUMENT, "moving", -1, dls_moving_step, m);
  dls_moving_get(m, &after);
  ck_assert_int_eq(after.step, 2);
  dls_moving_get(m, NULL);
  dls_moving_destroy(m);
  dls_moving_destroy(NULL);
  dls_moving_get(NULL, &d);
  ck_assert(!d.name && !d.mesh);
}

/* The contact problem of a step has the step's reactions, h r in time; on K there is none. */
TEST_EACH(problem_of_a_step, 0, 3) {
  static const char *const scenes[] = {"block-drop", "jean-moving", "two-blocks"};
  dls_moving_data d;
  dls_contact problem;
  dls_certificate c;
  dls_moving_settings s = defaults();
  if (_i == 1) s.method = DLS_LEMKE; /* on W */
  dls_moving *m = create(scenes[_i], &s, &d);
  do
    advance(m, 1, &d);
  while (d.r[0] == 0 && d.step < d.steps);
  ck_assert_int_eq(dls_moving_problem(m, &problem, &error), DLS_OK);
  if (_i == 2) {
    ck_assert_int_eq(problem.nc, 0);
  } else {
    ck_assert_int_eq(problem.nc, d.state.active);
    double p[100];
    for (int k = 0; k < 2 * problem.nc; k++)
      p[k] = d.state.p[2 * d.state.active_list[k / 2] + k % 2];
    ck_assert_int_eq(dls_contact_certify(&problem, p, NULL, &c, &error), DLS_OK);
    ck_assert(dls_certificate_holds(&c, 1e-11));
    p[0] *= 1.001; /* and not others */
    ck_assert_int_eq(dls_contact_certify(&problem, p, NULL, &c, &error), DLS_OK);
    ck_assert(!dls_certificate_holds(&c, 1e-6));
  }
  REFUSES(ARGUMENT, "moving", -1, dls_moving_problem, NULL, &problem);
  REFUSES(ARGUMENT, "problem", -1, dls_moving_problem, m, NULL);
  dls_moving_destroy(m);
}

TEST_EACH(without_memory, 0, 4) {
  static const char *const scenes[] = {"bar-bounce", "two-blocks", "jean-moving", "block-drop"};
  dls_moving_settings s = defaults();
  if (_i != 2) { /* which has one mesh only */
    s.nx = 3;
    s.ny = 2;
  }
  s.upper = 2;
  s.measure = 1;
  dls_moving *m;
  MALLOCS_FAIL((m = (dls_moving *)(void *)&error, dls_moving_create(&m, scenes[_i], &s, &error)),
               !m, DLS_OK, 1);
  dls_moving_destroy(m);
}

TEST(repeated) { /* to the same bits, with and without measuring */
  dls_moving_settings s = defaults();
  s.steps = 60;
  const dls_moving_data a = whole("jean-moving", &s);
  s.measure = 1;
  const dls_moving_data b = whole("jean-moving", &s);
  ck_assert(a.energy.friction == b.energy.friction && a.energy.elastic == b.energy.elastic);
  ck_assert(a.cold_iterations == 0 && b.cold_iterations > 0 && a.iterations == b.iterations);
}
