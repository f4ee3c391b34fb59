/* test_reference.c: two runs of another code, row by row (data/dynamics/README.md). */
#include "moving.h"
#include "run.h"

static moving_parts parts;

/* Opens a run; *rows: their number. */
static FILE *run_open(const char *path, int columns, int *rows) {
  FILE *file = fopen(path, "r");
  ck_assert_msg(file != NULL, "%s", path);
  int found;
  ck_assert_int_eq(fscanf(file, "%d %d", rows, &found), 2);
  ck_assert_int_eq(found, columns);
  return file;
}

static void run_read(FILE *file, int columns, double *row) {
  for (int k = 0; k < columns; k++)
    ck_assert_int_eq(fscanf(file, "%lf", &row[k]), 1);
}

/* Largest difference and largest value of a column. */
typedef struct column_error {
  double error, size;
} column_error;

static void compare(column_error *column, double ours, double theirs) {
  column->error = fmax(column->error, fabs(ours - theirs));
  column->size = fmax(column->size, fabs(theirs));
}

static void assert_agrees(const char *name, const column_error *column, double tol) {
  ck_assert_msg(column->error <= tol * column->size, "%s: %g of %g", name, column->error,
                column->size);
}

TEST(test_bouncing_ball) {
  int rows;
  FILE *file = run_open(TEST_DATA "/dynamics/BouncingBallTS.ref", 5, &rows);
  moving_begin(&parts, 1);
  moving_add(&parts.M, 0, 0, 1);
  moving_touch(&parts, 0, -1, 0);
  const dls_motion_model model = moving_model(&parts);
  dls_motion_settings settings = moving_settings(DLS_MOTION_VELOCITY, 5e-3);
  settings.restitution = 0.9;
  const double one = 1, f = -9.81;
  dls_motion *motion = moving_create(&model, &settings, &one, NULL);
  column_error q = {0}, v = {0}, p = {0};
  double row[5];
  for (int k = 0; k < rows; k++) {
    run_read(file, 5, row);
    const dls_motion_state s = k > 0 ? moving_step(motion, &f, NULL, NULL) : moving_state(motion);
    compare(&q, s.x[0], row[1]);
    compare(&v, s.v[0], row[2]);
    compare(&p, s.p[0], row[3]);
  }
  assert_agrees("q", &q, 1e-13);
  assert_agrees("v", &v, 1e-13);
  assert_agrees("p", &p, 1e-13);
  ck_assert_double_gt(p.size, 1);
  dls_motion_destroy(motion);
  (void)fclose(file);
}

TEST(test_impacting_bar) {
  enum { n = 100, columns = 12 };
  const double l = 1.0 / n, mass = 7800 * 3.14e-4 * l / 6, stiffness = 210e9 * 3.14e-4 / l;
  int rows;
  FILE *file = run_open(TEST_DATA "/dynamics/ImpactingBar.ref", columns, &rows);
  moving_begin(&parts, n);
  for (int j = 0; j < n; j++) { /* the lower triangles */
    const int elements = (j > 0) + (j < n - 1);
    moving_add(&parts.M, j, j, 2 * mass * elements);
    moving_add(&parts.K, j, j, stiffness * elements);
    if (j == n - 1) continue;
    moving_add(&parts.M, j + 1, j, mass);
    moving_add(&parts.K, j + 1, j, -stiffness);
  }
  moving_touch(&parts, 0, -1, 1e-15);
  const dls_motion_model model = moving_model(&parts);
  dls_motion_settings settings = moving_settings(DLS_MOTION_VELOCITY, 2e-6);
  settings.forecast = 0;
  double x[n], v[n];
  for (int j = 0; j < n; j++) {
    x[j] = 5e-5;
    v[j] = -0.1;
  }
  dls_motion *motion = moving_create(&model, &settings, x, v);
  column_error of[columns] = {{0, 0}};
  double row[columns];
  for (int k = 0; k < rows; k++) {
    run_read(file, columns, row);
    const dls_motion_state s = k > 0 ? moving_step(motion, NULL, NULL, NULL) : moving_state(motion);
    const dls_motion_energies e = moving_energies(motion);
    const double ours[columns - 1] = {s.t + 1e-8, s.x[0],        s.v[0],        s.p[0] / 2e-6,
                                      s.p[0],     2 * e.elastic, 2 * e.kinetic, s.x[n - 1],
                                      s.v[n - 1], s.x[n / 2],    s.v[n / 2]};
    for (int c = 0; c < columns - 1; c++)
      compare(&of[c], ours[c], row[c]);
  }
  static const char *const name[columns - 1] = {"t",       "q_0", "v_0", "p/h",   "p",    "elastic",
                                                "kinetic", "q_N", "v_N", "q_mid", "v_mid"};
  for (int c = 0; c < columns - 1; c++)
    assert_agrees(name[c], &of[c], 1e-11);
  ck_assert_double_gt(of[4].size, 0);
  dls_motion_destroy(motion);
  (void)fclose(file);
}
