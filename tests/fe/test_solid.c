/* test_solid.c: tests material, four-node elements, obstacles and banded matrices of the finite
 * element module. */
#include "fe/solid.h"
#include "run.h"

static const dlsi_hardening steel = {.factor = 593, .offset = 0.00384, .exponent = 0.202};
static const dlsi_hardening rigid = {.factor = 1e300, .offset = 1, .exponent = 1};

/* repeatable numbers in (-1, 1) */
static double next_number(unsigned *seed) {
  *seed = *seed * 1664525u + 1013904223u;
  return (double)*seed / 2147483648.0 - 1;
}

/* ---- hardening ------------------------------------------------------------------------------- */

TEST(hardening_functions) {
  const double ep[] = {0, 0.1, 0.4}, sigma[] = {100, 160, 190};
  const dlsi_hardening table = {.points = 3, .ep = ep, .sigma = sigma};
  const dlsi_hardening linear = {.factor = 261.2, .offset = 0.11868, .exponent = 1};
  double slope;
  ck_assert_double_eq_tol(dlsi_hardening_value(&linear, 0, &slope), 261.2 * 0.11868, 1e-13);
  ck_assert_double_eq_tol(slope, 261.2, 1e-12);
  const double at[] = {0, 0.05, 0.1, 0.25, 0.4, 9}, value[] = {100, 130, 160, 175, 190, 190};
  const double slopes[] = {600, 600, 100, 100, 0, 0};
  for (int k = 0; k < 6; k++) {
    ck_assert_double_eq_tol(dlsi_hardening_value(&table, at[k], &slope), value[k], 1e-11);
    ck_assert_double_eq_tol(slope, slopes[k], 1e-11);
  }
  for (int k = 1; k < 5; k++) {
    const double e = 0.1 * k, h = 1e-5;
    double s1, s2;
    const double difference =
        dlsi_hardening_value(&steel, e + h, &s1) - dlsi_hardening_value(&steel, e - h, &s2);
    (void)dlsi_hardening_value(&steel, e, &slope);
    ck_assert_double_eq_tol(difference / (2 * h), slope, 1e-6 * slope);
  }
}

/* ---- material -------------------------------------------------------------------------------- */

static double determinant(const double F[5]) {
  return (F[0] * F[3] - F[1] * F[2]) * F[4];
}

/* be = J^-2/3 F Cp F^T */
static void elastic_strain(const double F[5], const double C[4], double be[4]) {
  const double s = pow(determinant(F), -2.0 / 3);
  be[0] = s * (F[0] * F[0] * C[0] + 2 * F[0] * F[1] * C[3] + F[1] * F[1] * C[1]);
  be[1] = s * (F[2] * F[2] * C[0] + 2 * F[2] * F[3] * C[3] + F[3] * F[3] * C[1]);
  be[2] = s * F[4] * F[4] * C[2];
  be[3] = s * (F[0] * F[2] * C[0] + (F[0] * F[3] + F[1] * F[2]) * C[3] + F[1] * F[3] * C[1]);
}

TEST(small_strains_obey_hooke) {
  const double E = 2e5, nu = 0.3, G = E / 2 / (1 + nu), h = 1e-7;
  const dlsi_solid solid = dlsi_solid_make(E, nu, steel);
  const double F[5] = {1 + 3 * h, 2 * h, -h, 1 - 5 * h, 1 + h}; /* trace -h, e12 = h/2 */
  const dlsi_point virgin = dlsi_point_virgin();
  dlsi_point now;
  double s[4], p, slope;
  ck_assert(dlsi_solid_update(&solid, F, determinant(F), &virgin, &now, s, NULL));
  const double expected[4] = {3 * h + h / 3, -5 * h + h / 3, h + h / 3, h / 2};
  for (int i = 0; i < 4; i++)
    ck_assert_double_eq_tol(s[i], 2 * G * expected[i], 2 * G * h * 1e-5);
  (void)dlsi_solid_volume(&solid, 1 - h, &p, &slope);
  ck_assert_double_eq_tol(p, -E / 3 / (1 - 2 * nu) * h, E * h * 1e-5);
  ck_assert(now.ep == 0);
}

/* A path of 12 steps into the plastic range and back; at its end s is on or inside the yield
 * surface, det be is 1 by default and the trace that of the trial by (13). */
TEST(return_mapping) {
  for (int keep = 0; keep < 2; keep++) {
    dlsi_solid solid = dlsi_solid_make(2e5, 0.3, steel);
    solid.keep_trace = keep;
    dlsi_point old = dlsi_point_virgin(), now;
    unsigned seed = 7;
    double F[5] = {1, 0, 0, 1, 1}, plastic = 0, drift = 0;
    for (int k = 0; k < 12; k++) {
      double s[4], be[4], trial[4], slope;
      for (int i = 0; i < 5; i++)
        F[i] += 0.03 * next_number(&seed);
      elastic_strain(F, old.Cp, trial);
      ck_assert(dlsi_solid_update(&solid, F, determinant(F), &old, &now, s, NULL));
      elastic_strain(F, now.Cp, be);
      const double det = (be[0] * be[1] - be[3] * be[3]) * be[2];
      const double mean = (be[0] + be[1] + be[2]) / 3;
      const double q = sqrt(1.5 * (s[0] * s[0] + s[1] * s[1] + s[2] * s[2] + 2 * s[3] * s[3]));
      const double yield = dlsi_hardening_value(&steel, now.ep, &slope);
      ck_assert_double_le(q, yield * (1 + 1e-13));
      if (now.ep > old.ep) ck_assert_double_ge(q, yield * (1 - 1e-13));
      for (int i = 0; i < 4; i++) /* s = mu dev be */
        ck_assert_double_eq_tol(s[i], solid.shear * (be[i] - (i < 3 ? mean : 0)), 1e-11 * 2e5);
      if (keep)
        ck_assert_double_eq_tol(mean, (trial[0] + trial[1] + trial[2]) / 3, 1e-13);
      else
        ck_assert_double_eq_tol(det, 1, 1e-13);
      ck_assert_double_eq_tol(now.elastic, solid.shear / 2 * 3 * (mean - 1), 1e-10 * 2e5);
      plastic = fmax(plastic, now.ep);
      drift = fmax(drift, fabs(det - 1));
      old = now;
    }
    ck_assert_double_gt(plastic, 0.1);
    if (keep) ck_assert_double_gt(drift, 1e-6);
  }
}

TEST(bad_points) {
  const dlsi_solid solid = dlsi_solid_make(2e5, 0.3, steel);
  const double bad[][5] = {{NAN, 0, 0, 1, 1}, {1e200, 0, 0, 1, 1}, {1, INFINITY, 0, 1, 1}};
  const dlsi_point virgin = dlsi_point_virgin();
  dlsi_point now;
  double s[4], c[16];
  for (int k = 0; k < 3; k++)
    ck_assert(!dlsi_solid_update(&solid, bad[k], determinant(bad[k]), &virgin, &now, s, c));
}

/* ---- element --------------------------------------------------------------------------------- */

/* a crooked element off the axis, and its points after `plastic` of a plastic first step */
typedef struct sample {
  double X[8], x[8];
  dlsi_solid solid;
  dlsi_point old[4];
} sample;

static sample make_sample(int axisymmetric, int standard, double size, unsigned seed) {
  sample a = {.X = {1, 0, 2.1, 0.2, 2.3, 1.4, 0.9, 1.1}, .solid = dlsi_solid_make(2e5, 0.3, steel)};
  double f[8], energy[2];
  dlsi_point now[4];
  for (int q = 0; q < 4; q++)
    a.old[q] = dlsi_point_virgin();
  for (int step = 0; step < 2; step++) { /* the second one starts from plastic points */
    for (int k = 0; k < 8; k++)
      a.x[k] = (step == 0 ? a.X[k] : a.x[k]) + size * next_number(&seed);
    if (step == 1) break;
    const dlsi_q4 element = {axisymmetric, standard, a.X, a.x};
    ck_assert(dlsi_q4_forces(&element, &a.solid, a.old, now, f, NULL, energy, NULL));
    memcpy(a.old, now, sizeof now);
  }
  return a;
}

/* Richardson's extrapolation of central differences of the forces, against K */
TEST_EACH(tangent_is_the_derivative_of_the_forces, 0, 8) {
  const int axisymmetric = _i & 1, standard = (_i >> 1) & 1;
  const double size = _i & 4 ? 1e-4 : 0.08; /* elastic, plastic */
  sample a = make_sample(axisymmetric, standard, size, (unsigned)_i);
  const dlsi_q4 element = {axisymmetric, standard, a.X, a.x};
  double f[8], K[64], energy[2], D[64];
  dlsi_point now[4];
  ck_assert(dlsi_q4_forces(&element, &a.solid, a.old, now, f, K, energy, NULL));
  double plastic = 0;
  for (int q = 0; q < 4; q++)
    plastic += now[q].ep - a.old[q].ep;
  ck_assert((plastic > 0.01) == !(_i & 4));
  const double h = 1e-3 * size;
  for (int l = 0; l < 8; l++) {
    double g[4][8];
    const double x = a.x[l], at[4] = {-2, -1, 1, 2};
    for (int k = 0; k < 4; k++) {
      a.x[l] = x + h * at[k];
      ck_assert(dlsi_q4_forces(&element, &a.solid, a.old, now, g[k], NULL, energy, NULL));
    }
    a.x[l] = x;
    for (int k = 0; k < 8; k++)
      D[k + 8 * l] = K[k + 8 * l] - (8 * (g[2][k] - g[1][k]) - (g[3][k] - g[0][k])) / (12 * h);
  }
  ck_assert_double_le(largest(D, 64), 1e-7 * largest(K, 64));
}

/* The elastic energy is a potential of the forces. */
TEST_EACH(elastic_forces_are_a_gradient, 0, 4) {
  const int axisymmetric = _i & 1, standard = (_i >> 1) & 1;
  sample a = make_sample(axisymmetric, standard, 0.08, 3);
  a.solid.hardening = rigid;
  for (int q = 0; q < 4; q++)
    a.old[q] = dlsi_point_virgin();
  const dlsi_q4 element = {axisymmetric, standard, a.X, a.x};
  double f[8], g[8], energy[2];
  dlsi_point now[4];
  ck_assert(dlsi_q4_forces(&element, &a.solid, a.old, now, f, NULL, energy, NULL));
  for (int k = 0; k < 8; k++) {
    const double x = a.x[k], h = 1e-4, at[4] = {-2, -1, 1, 2};
    double E[4];
    for (int j = 0; j < 4; j++) {
      a.x[k] = x + h * at[j];
      ck_assert(dlsi_q4_forces(&element, &a.solid, a.old, now, g, NULL, energy, NULL));
      E[j] = energy[0];
    }
    a.x[k] = x;
    const double slope = (8 * (E[2] - E[1]) - (E[3] - E[0])) / (12 * h);
    ck_assert_double_eq_tol(slope, f[k], 1e-7 * largest(f, 8));
  }
}

/* A rotation on top of a plane deformation turns the forces and keeps states and energies. */
TEST(rotations_do_no_work) {
  sample a = make_sample(0, 0, 0.08, 11), b = a;
  const double angle = 0.7, c = cos(angle), s = sin(angle);
  for (int k = 0; k < 4; k++) {
    b.x[2 * k] = c * a.x[2 * k] - s * a.x[2 * k + 1] + 5;
    b.x[2 * k + 1] = s * a.x[2 * k] + c * a.x[2 * k + 1] - 3;
  }
  double f[8], g[8], E[2], e[2];
  dlsi_point p[4], q[4];
  const dlsi_q4 one = {0, 0, a.X, a.x}, two = {0, 0, b.X, b.x};
  ck_assert(dlsi_q4_forces(&one, &a.solid, a.old, p, f, NULL, E, NULL));
  ck_assert(dlsi_q4_forces(&two, &b.solid, b.old, q, g, NULL, e, NULL));
  for (int k = 0; k < 4; k++) {
    ck_assert_double_eq_tol(g[2 * k], c * f[2 * k] - s * f[2 * k + 1], 1e-10 * largest(f, 8));
    ck_assert_double_eq_tol(g[2 * k + 1], s * f[2 * k] + c * f[2 * k + 1], 1e-10 * largest(f, 8));
    ck_assert_double_eq_tol(p[k].ep, q[k].ep, 1e-13);
    for (int i = 0; i < 4; i++)
      ck_assert_double_eq_tol(p[k].Cp[i], q[k].Cp[i], 1e-12);
  }
  ck_assert_double_eq_tol(E[0], e[0], 1e-10 * E[0]);
  ck_assert_double_eq_tol(E[1], e[1], 1e-12 * E[1]);
}

TEST(inside_out) {
  sample a = make_sample(0, 0, 0.01, 1);
  const dlsi_q4 element = {0, 0, a.X, a.x};
  double f[8], energy[2];
  dlsi_point now[4];
  a.x[4] = -1; /* corner 3 through the opposite one */
  a.x[5] = -1;
  ck_assert(!dlsi_q4_forces(&element, &a.solid, a.old, now, f, NULL, energy, NULL));
  a.x[4] = NAN;
  ck_assert(!dlsi_q4_forces(&element, &a.solid, a.old, now, f, NULL, energy, NULL));
}

/* ---- small structures ------------------------------------------------------------------------ */

/* n x n elements on a quadrilateral; a few Newton steps with given displacements */
typedef struct plate {
  int n, axisymmetric, standard;
  double *X, *x, *F;
  int *fixed;
  dlsi_solid solid;
  dlsi_point *old, *now;
  dlsi_band K;
} plate;

static void plate_make(plate *p, int n, const double corner[8]) {
  const int nodes = (n + 1) * (n + 1);
  p->n = n;
  p->X = malloc(2 * (size_t)nodes * sizeof *p->X);
  p->x = malloc(2 * (size_t)nodes * sizeof *p->x);
  p->F = malloc(2 * (size_t)nodes * sizeof *p->F);
  p->fixed = calloc(2 * (size_t)nodes, sizeof *p->fixed);
  p->old = malloc(4 * (size_t)(n * n) * sizeof *p->old);
  p->now = malloc(4 * (size_t)(n * n) * sizeof *p->now);
  ck_assert(p->X && p->x && p->F && p->fixed && p->old && p->now);
  ck_assert(dlsi_band_create(&p->K, 2 * nodes, 2 * (n + 2) + 1));
  for (int j = 0; j <= n; j++)
    for (int i = 0; i <= n; i++)
      for (int k = 0; k < 2; k++) {
        const double s = (double)i / n, t = (double)j / n;
        p->X[2 * (i + j * (n + 1)) + k] = (1 - s) * (1 - t) * corner[k] +
                                          s * (1 - t) * corner[2 + k] + s * t * corner[4 + k] +
                                          (1 - s) * t * corner[6 + k];
      }
  memcpy(p->x, p->X, 2 * (size_t)nodes * sizeof *p->x);
  for (int k = 0; k < 4 * n * n; k++)
    p->old[k] = dlsi_point_virgin();
}

static void plate_free(plate *p) {
  dlsi_band_free(&p->K);
  void *const owned[] = {p->X, p->x, p->F, p->fixed, p->old, p->now};
  for (int k = 0; k < 6; k++)
    free(owned[k]);
}

static void plate_assemble(plate *p) {
  const int n = p->n;
  dlsi_band_clear(&p->K);
  memset(p->F, 0, (size_t)p->K.n * sizeof *p->F);
  for (int e = 0; e < n * n; e++) {
    const int a = e % n + e / n * (n + 1), node[4] = {a, a + 1, a + n + 2, a + n + 1};
    double X[8], x[8], f[8], K[64], energy[2];
    for (int k = 0; k < 8; k++) {
      X[k] = p->X[2 * node[k / 2] + k % 2];
      x[k] = p->x[2 * node[k / 2] + k % 2];
    }
    const dlsi_q4 element = {p->axisymmetric, p->standard, X, x};
    ck_assert(
        dlsi_q4_forces(&element, &p->solid, p->old + 4 * e, p->now + 4 * e, f, K, energy, NULL));
    for (int l = 0; l < 8; l++) {
      const int j = 2 * node[l / 2] + l % 2;
      p->F[j] += f[l];
      for (int k = 0; k < 8; k++)
        p->K.a[dlsi_band_at(&p->K, 2 * node[k / 2] + k % 2, j)] += K[k + 8 * l];
    }
  }
}

/* Newton's method from p->x for forces `load`; fixed unknowns stay. Returns the steps, -1 if more
 * than 20. */
static int plate_solve(plate *p, const double *load) {
  const int N = p->K.n;
  double *d = malloc((size_t)N * sizeof *d);
  ck_assert_ptr_nonnull(d);
  int steps = -1;
  for (int k = 0; k <= 20 && steps < 0; k++) {
    plate_assemble(p);
    double out = 0;
    for (int i = 0; i < N; i++) {
      d[i] = load[i] - p->F[i];
      if (!p->fixed[i]) out = fmax(out, fabs(d[i]));
    }
    if (out <= 1e-8 * largest(p->F, N)) steps = k;
    for (int i = 0; i < N; i++)
      if (p->fixed[i]) dlsi_band_support(&p->K, i, 0, d);
    dlsi_band_load(&p->K);
    ck_assert(dlsi_band_factor(&p->K));
    ck_assert_int_eq(dlsi_band_solve(&p->K, d, N, 1), 0);
    for (int i = 0; i < N; i++)
      p->x[i] += d[i];
  }
  free(d);
  return steps;
}

/* Patch test: on a crooked mesh with the boundary displaced as by one deformation gradient, the
 * inside follows. Plane: any gradient. Axisymmetric: r scaled, z scaled, where hoop and radial
 * stress are equal. Elastic and far into the plastic range. */
TEST_EACH(patch, 0, 8) {
  const int axisymmetric = _i & 1, standard = (_i >> 1) & 1, plastic = (_i >> 2) & 1;
  const double corner[8] = {1, 0, 3, 0.3, 2.8, 2.2, 1.2, 1.9};
  const double square[8] = {1, 0, 3, 0, 3, 2, 1, 2};
  const double G[4] = {axisymmetric ? 0.06 : 0.1, axisymmetric ? 0 : 0.07, axisymmetric ? 0 : -0.03,
                       -0.08};
  plate p = {.axisymmetric = axisymmetric,
             .standard = standard,
             .solid = dlsi_solid_make(2e5, 0.3, plastic ? steel : rigid)};
  enum { n = 4 };
  plate_make(&p, n, axisymmetric ? square : corner);
  unsigned seed = 5;
  double load[2 * (n + 1) * (n + 1)] = {0};
  for (int i = 0; i <= n; i++)
    for (int j = 0; j <= n; j++) {
      const int a = i + j * (n + 1), inside = i > 0 && i < n && j > 0 && j < n;
      for (int k = 0; k < 2; k++) {
        if (inside) p.X[2 * a + k] += 0.08 * next_number(&seed);
        p.fixed[2 * a + k] = !inside;
      }
      for (int k = 0; k < 2; k++)
        p.x[2 * a + k] = p.X[2 * a + k] + G[2 * k] * p.X[2 * a] + G[2 * k + 1] * p.X[2 * a + 1] +
                         (inside ? 0.01 * next_number(&seed) : 0);
    }
  ck_assert_int_gt(plate_solve(&p, load), 1);
  for (int a = 0; a < (n + 1) * (n + 1); a++)
    for (int k = 0; k < 2; k++)
      ck_assert_double_eq_tol(p.x[2 * a + k] - p.X[2 * a + k],
                              G[2 * k] * p.X[2 * a] + G[2 * k + 1] * p.X[2 * a + 1], 1e-9);
  ck_assert((p.now[0].ep > 0.01) == plastic);
  plate_free(&p);
}

/* Cook's membrane: clamped on the left, sheared by a traction on the right; E such that mu =
 * 80.194, nu = 0.4999, small load. Returns the deflection of the upper right corner. */
static double cook(int n, double nu, int standard, double force) {
  const double corner[8] = {0, 0, 48, 44, 48, 60, 0, 44};
  plate p = {.standard = standard, .solid = dlsi_solid_make(2 * 80.194 * (1 + nu), nu, rigid)};
  plate_make(&p, n, corner);
  double *load = calloc((size_t)p.K.n, sizeof *load);
  ck_assert_ptr_nonnull(load);
  for (int j = 0; j <= n; j++) {
    p.fixed[2 * j * (n + 1)] = p.fixed[2 * j * (n + 1) + 1] = 1;
    load[2 * (n + j * (n + 1)) + 1] = force / n * (j == 0 || j == n ? 0.5 : 1);
  }
  ck_assert_int_gt(plate_solve(&p, load), 0);
  const int tip = 2 * (n + n * (n + 1)) + 1;
  const double deflection = p.x[tip] - p.X[tip];
  free(load);
  plate_free(&p);
  return deflection;
}

TEST(no_locking) {
  /* nearly incompressible: 8 x 8 of Q4/P0 within 5 % of 32 x 32; the standard element is far off */
  const double fine = cook(32, 0.4999, 0, 10), coarse = cook(8, 0.4999, 0, 10);
  ck_assert_double_eq_tol(coarse, fine, 0.05 * fine);
  ck_assert_double_lt(cook(8, 0.4999, 1, 10), 0.6 * fine);
  /* compressible: both elements do */
  const double soft = cook(32, 0.3, 0, 10);
  ck_assert_double_eq_tol(cook(32, 0.3, 1, 10), soft, 0.02 * soft);
}

/* One element, plane strain, pressed to half of its height, free to spread: -655.95 MPa. */
TEST(one_element_compressed) {
  enum { steps = 5000 };
  const double corner[8] = {0, 0, 1, 0, 1, 1, 0, 1}, load[8] = {0};
  plate p = {.solid = dlsi_solid_make(2e5, 0.3, steel)};
  plate_make(&p, 1, corner);
  for (int k = 0; k < 8; k++)
    p.fixed[k] = k % 2 == 1 || k == 0 || k == 4;
  for (int k = 1; k <= steps; k++) {
    for (int i = 0; i < 8; i++)
      if (i == 5 || i == 7) p.x[i] = 1 - 0.5 * k / steps;
    ck_assert_int_ge(plate_solve(&p, load), 0);
    memcpy(p.old, p.now, 4 * sizeof *p.old);
  }
  const double stress = (p.F[5] + p.F[7]) / (p.x[2] - p.x[0]);
  ck_assert_double_eq_tol(stress, -655.95, 1e-3 * 655.95);
  plate_free(&p);
}

/* ---- obstacle -------------------------------------------------------------------------------- */

TEST(plane_and_cylinder) {
  const dlsi_piece floor_piece = {.a = {0, 0}, .b = {2, 2}}; /* body above the diagonal */
  const dlsi_obstacle ramp = {1, &floor_piece};
  const double x[2] = {-7, -5};
  double n[2], curvature;
  ck_assert_double_eq_tol(dlsi_obstacle_gap(&ramp, x, n, &curvature), sqrt(2), 1e-14);
  assert_near(n, (double[]){-sqrt(0.5), sqrt(0.5)}, 2, 1e-15);
  ck_assert(curvature == 0);
  const dlsi_piece round = {.c = {1, 2}, .radius = 3, .side = 1};
  const dlsi_obstacle cylinder = {1, &round};
  const double y[2] = {4, 6}, inside[2] = {1, 0};
  ck_assert_double_eq_tol(dlsi_obstacle_gap(&cylinder, y, n, &curvature), 2, 1e-14);
  ck_assert_double_eq_tol(n[0], 0.6, 1e-15);
  ck_assert_double_eq_tol(curvature, 0.2, 1e-15);
  ck_assert_double_eq_tol(dlsi_obstacle_gap(&cylinder, inside, n, &curvature), -1, 1e-14);
  ck_assert_double_eq_tol(n[1], -1, 1e-15);
}

/* Line, quarter of a circle, line, the body in the hollow: along a path near the wall, on either
 * side, gap and normal are continuous, the gap's gradient is n, and n turns by the curvature. */
TEST(profile_with_joints) {
  const dlsi_piece pieces[3] = {{.a = {-5, 0}, .b = {0, 0}},
                                {.a = {0, 0}, .b = {2, 2}, .c = {0, 2}, .radius = 2, .side = -1},
                                {.a = {2, 2}, .b = {2, 7}}};
  const dlsi_obstacle hollow = {3, pieces};
  for (int side = -1; side <= 1; side++) {
    double before[2] = {0, 1};
    for (int k = 0; k <= 4000; k++) {
      const double s = -3 + k * 1e-3 * (6 + acos(-1)) / 4 - 0, out = 0.3 * side;
      const double arc = acos(-1); /* its length */
      const double a = s < 0 ? 0 : s < arc ? s / 2 : arc / 2;
      const double foot[2] = {s < 0 ? s : 2 * sin(a), s > arc ? 2 + s - arc : 2 - 2 * cos(a)};
      const double normal[2] = {-sin(a), cos(a)};
      const double x[2] = {foot[0] + out * normal[0], foot[1] + out * normal[1]};
      double n[2], curvature;
      ck_assert_double_eq_tol(dlsi_obstacle_gap(&hollow, x, n, &curvature), out, 1e-13);
      assert_near(n, (double[]){normal[0], normal[1]}, 2, 1e-13);
      ck_assert_double_le(hypot(n[0] - before[0], n[1] - before[1]), 2e-3);
      memcpy(before, n, sizeof n);
      const double round = s > 1e-9 && s < arc - 1e-9 ? -1 / (2 - out) : 0;
      if (fabs(s) > 1e-9 && fabs(s - arc) > 1e-9) ck_assert_double_eq_tol(curvature, round, 1e-12);
    }
  }
}

/* By hand, lines that meet at a convex corner (0, 0): from (-4, 0) to b = (0, 0), the body above,
 * then down to (4, -3). Beyond end b of the first line the corner is its nearest point. */
TEST(beyond_the_end_of_a_line) {
  const dlsi_piece pieces[2] = {{.a = {-4, 0}, .b = {0, 0}}, {.a = {0, 0}, .b = {4, -3}}};
  const dlsi_obstacle wedge = {2, pieces};
  const struct {
    double x[2], gap, n[2];
  } at[] = {
      {{-1, 2}, 2, {0, 1}},         /* above the first line */
      {{10, 0.5}, 6.4, {0.6, 0.8}}, /* nearer to the first line drawn on than to the second */
      {{1, -0.5}, 0.2, {0.6, 0.8}}, /* likewise, close to the wall */
      {{1, 2}, 2, {0, 1}},   /* the corner is nearest to both: the first line counts, (OB2) */
      {{0.5, 3}, 3, {0, 1}}, /* likewise, farther up */
  };
  for (size_t k = 0; k < sizeof at / sizeof at[0]; k++) {
    double n[2], curvature;
    ck_assert_double_eq_tol(dlsi_obstacle_gap(&wedge, at[k].x, n, &curvature), at[k].gap, 1e-14);
    assert_near(n, (double[]){at[k].n[0], at[k].n[1]}, 2, 1e-15);
    ck_assert(curvature == 0);
  }
}

/* A hook: a long line, and a short one that turns back above it, whose free end is a or b. The line
 * of the short one is drawn on beyond that end, and nearer than the long one. */
TEST(free_ends_are_drawn_on) {
  const double tip[2] = {-0.4, 0.3}, x[2] = {-1.66, 1.12};
  const dlsi_piece free_b[2] = {{.a = {-4, 0}, .b = {0, 0}}, {.a = {0, 0}, .b = {tip[0], tip[1]}}};
  const dlsi_piece free_a[2] = {{.a = {tip[0], tip[1]}, .b = {0, 0}}, {.a = {0, 0}, .b = {-4, 0}}};
  for (int k = 0; k < 2; k++) {
    const dlsi_obstacle hook = {2, k ? free_a : free_b};
    const double side = k ? -1 : 1;
    double n[2], curvature;
    ck_assert_double_eq_tol(dlsi_obstacle_gap(&hook, x, n, &curvature), side * 0.1, 1e-14);
    assert_near(n, (double[]){side * -0.6, side * -0.8}, 2, 1e-15);
  }
}

/* ---- band ------------------------------------------------------------------------------------ */

TEST(band_solves_with_supports) {
  enum { n = 12, k = 3, known = 5 };
  dlsi_band band;
  double A[n * n] = {0}, x[n], f[n] = {0};
  unsigned seed = 2;
  ck_assert(dlsi_band_create(&band, n, k));
  dlsi_band_clear(&band);
  for (int j = 0; j < n; j++) {
    x[j] = next_number(&seed);
    for (int i = 0; i < n; i++)
      if (abs(i - j) <= k)
        A[i + n * j] = band.a[dlsi_band_at(&band, i, j)] = next_number(&seed) + (i == j ? 4 : 0);
  }
  for (int j = 0; j < n; j++)
    for (int i = 0; i < n; i++)
      f[i] += A[i + n * j] * x[j];
  f[known] = 99; /* replaced by x[known] as given */
  dlsi_band_support(&band, known, x[known], f);
  dlsi_band_load(&band);
  ck_assert(dlsi_band_factor(&band));
  ck_assert_int_eq(dlsi_band_solve(&band, f, n, 1), 0);
  assert_near(f, x, n, 1e-13);
  dlsi_band_clear(&band);
  dlsi_band_load(&band);
  ck_assert(!dlsi_band_factor(&band));
  dlsi_band_free(&band);
  for (long fail = 1; fail <= 3; fail++) {
    malloc_fails_at(fail);
    ck_assert(!dlsi_band_create(&band, n, k));
    dlsi_band_free(&band);
  }
  malloc_fails_at(0);
}

/* A hollow of two lines and an arc between: points at the centre of the arc and beyond are in front
 * of it, not inside, and see the nearer line. */
TEST(obstacle_beyond_the_centre) {
  const double half = acos(-1) / 8, s = sin(half), c = cos(half), radius = 2;
  /* about the origin, the arc at the right; lines along its tangents */
  const double a[2] = {radius * c, -radius * s}, b[2] = {radius * c, radius * s};
  dlsi_piece pieces[3] = {{.a = {a[0] - 9 * s, a[1] - 9 * c}, .b = {a[0], a[1]}},
                          {.a = {a[0], a[1]}, .b = {b[0], b[1]}, .radius = radius, .side = -1},
                          {.a = {b[0], b[1]}, .b = {b[0] - 9 * s, b[1] + 9 * c}}};
  const dlsi_obstacle hollow = {3, pieces};
  for (int k = -4; k <= 4; k++)
    for (int l = 0; l < 20; l++) {
      const double x[2] = {-0.5 * l, 0.25 * k};
      double n[2], curvature;
      const double gap = dlsi_obstacle_gap(&hollow, x, n, &curvature);
      /* both lines are at radius - x.c - |y| s or more */
      ck_assert_double_eq_tol(gap, radius - x[0] * c - fabs(x[1]) * s, 1e-13 * (1 + l));
      ck_assert_double_eq_tol(n[0], -c, 1e-14);
      ck_assert(curvature == 0 && fabs(fabs(n[1]) - s) < 1e-14);
    }
}
