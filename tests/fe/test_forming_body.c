/* test_forming_body.c: tests that a forming scene ends with a body, or with a place and a reason.
 * Corners are counted here, from the files for ParaView, without the code of the scene. */
#define _XOPEN_SOURCE 700 /* mkdtemp */

#include <unistd.h>

#include "delassus/forming.h"
#include "run.h"

static dls_error error;

/* ---- files ----------------------------------------------------------------------------------- */

enum { most_numbers = 40000 };

typedef struct grid {
  double points[most_numbers], displacement[most_numbers], node[most_numbers], end[most_numbers];
  int coordinates, cells;
} grid;

/* Reads an array of a file by its name; returns how many numbers it has. */
static int read_array(const char *text, const char *name, double *x) {
  char head[64];
  (void)snprintf(head, sizeof head, "Name=\"%s\"", name);
  const char *at = strstr(text, head);
  ck_assert_msg(at != NULL, "no array %s", name);
  at = strchr(at, '>') + 1;
  int count = 0;
  for (char *end;; at = end) {
    const double value = strtod(at, &end);
    if (end == at) return count;
    ck_assert_int_lt(count, most_numbers);
    x[count++] = value;
  }
}

static void read_grid(const char *path, grid *g) {
  FILE *file = fopen(path, "r");
  ck_assert_ptr_nonnull(file);
  ck_assert_int_eq(fseek(file, 0, SEEK_END), 0);
  const long size = ftell(file);
  rewind(file);
  char *text = malloc((size_t)size + 1);
  ck_assert_ptr_nonnull(text);
  ck_assert_uint_eq(fread(text, 1, (size_t)size, file), (size_t)size);
  text[size] = '\0';
  (void)fclose(file);
  g->coordinates = read_array(text, "points", g->points);
  ck_assert_int_eq(read_array(text, "displacement", g->displacement), g->coordinates);
  (void)read_array(text, "connectivity", g->node);
  g->cells = read_array(text, "offsets", g->end);
  free(text);
}

/* Returns the number of corners of cells that are inside out, and of points beyond the axis. */
static int count_faults(const grid *g) {
  int faults = 0;
  for (int e = 0, first = 0; e < g->cells; first = (int)g->end[e++]) {
    const int corners = (int)g->end[e] - first;
    for (int k = 0; k < corners; k++) {
      double x[3], y[3];
      for (int j = 0; j < 3; j++) {
        const int i = 3 * (int)g->node[first + (k + (j == 2 ? corners - 1 : j)) % corners];
        x[j] = g->points[i] + g->displacement[i];
        y[j] = g->points[i + 1] + g->displacement[i + 1];
      }
      const double area = (x[1] - x[0]) * (y[2] - y[0]) - (y[1] - y[0]) * (x[2] - x[0]);
      faults += !(area > 0);
    }
  }
  for (int i = 0; i < g->coordinates; i += 3)
    faults += !(g->points[i] + g->displacement[i] >= -1e-7);
  return faults;
}

static int faults_of(const dls_forming *f, const char *folder) {
  static grid g;
  char path[64];
  (void)snprintf(path, sizeof path, "%s/a.vtu", folder);
  ck_assert_int_eq(dls_forming_write_vtu(f, path, &error), DLS_OK);
  read_grid(path, &g);
  ck_assert_int_eq(unlink(path), 0);
  dls_forming_data d;
  dls_forming_get(f, &d);
  for (int i = 0; i < g.coordinates; i++)
    ck_assert_double_eq(g.displacement[i], i % 3 < 2 ? d.displacement[i / 3 * 2 + i % 3] : 0);
  return count_faults(&g);
}

/* ---- the extrusion --------------------------------------------------------------------------- */

static const char *const methods[] = {"auto", "lemke", "nlgs", "newton", "", "", ""};
static const dls_forming_contact contacts[] = {DLS_FORMING_AUGMENTED_LAGRANGIAN,
                                               DLS_FORMING_PENALTY, DLS_FORMING_GAUSS_SEIDEL};
static const double frictions[] = {0.12, 0.3, 0.4}; /* 0.2 below */
enum {
  method_count = sizeof methods / sizeof methods[0],
  friction_count = sizeof frictions / sizeof frictions[0]
};

static dls_forming *create(const char *name, int method, double mu, int nx, int ny) {
  dls_forming_settings s;
  dls_forming_settings_init(&s);
  s.mu = mu;
  s.nx = nx;
  s.ny = ny;
  if (methods[method][0])
    ck_assert(dls_method_find(methods[method], &s.method));
  else
    s.contact = contacts[method - 4];
  dls_forming *f;
  ck_assert_int_eq(dls_forming_create(&f, name, &s, &error), DLS_OK);
  return f;
}

/* Runs a scene; every tenth state and the last one are bodies whose forces balance, and a run that
 * stops says where and why. Returns the status, and the data at the end. */
static dls_status run_to_the_end(dls_forming *f, const char *folder, dls_forming_data *d) {
  dls_status status = DLS_OK;
  dls_forming_get(f, d);
  for (int step = 1; !status && step <= d->steps; step++) {
    status = dls_forming_step(f, &error);
    dls_forming_get(f, d);
    ck_assert_double_le(d->balance, 1e-9);
    if (step % 10 == 0 || status || step == d->steps) ck_assert_int_eq(faults_of(f, folder), 0);
  }
  ck_assert_double_le(d->worst_balance, 1e-9);
  if (status == DLS_OK) {
    ck_assert_double_eq(d->travel, d->whole);
    return status;
  }
  const dls_forming_fault *fault = &d->fault;
  ck_assert(status == DLS_FOLDED || status == DLS_STALLED);
  ck_assert((fault->kind < DLS_FORMING_ELEMENT) == (status == DLS_FOLDED));
  ck_assert_int_ne(fault->kind, DLS_FORMING_NO_FAULT);
  ck_assert(fault->element >= 0 || fault->node >= 0);
  ck_assert_int_gt((int)strlen(fault->text), 10);
  ck_assert_double_gt(fault->travel, d->travel);
  ck_assert_double_lt(fault->travel, d->travel + d->whole / d->steps);
  return status;
}

/* Runs a scene. nx, ny: 0 for its own mesh. d: the numbers at the end, without arrays. */
static dls_status run_mesh(const char *name, int method, double mu, int nx, int ny,
                           dls_forming_data *d) {
  char folder[] = "/tmp/test_body.XXXXXX";
  ck_assert_ptr_nonnull(mkdtemp(folder));
  dls_forming *f = create(name, method, mu, nx, ny);
  const dls_status status = run_to_the_end(f, folder, d);
  if (d->travel > 100) ck_assert_int_gt(d->count.held, 5); /* lateral nodes lie on the ram */
  dls_forming_destroy(f);
  ck_assert_int_eq(rmdir(folder), 0);
  return status;
}

/* Sweeps on displacements are left out where they take minutes, and what auto_goes_as_far runs. */
TEST_EACH(extrusion_is_a_body, 0, (int)method_count *(int)friction_count) {
  const int method = _i % method_count;
  const double mu = frictions[_i / method_count];
  if ((method == method_count - 1 && mu > 0.2) || (mu == 0.3 && method < 2)) return;
  dls_forming_data d;
  const dls_status status = run_mesh("extrusion", method, mu, 0, 0, &d);
  if (mu <= 0.2) ck_assert_int_eq(status, DLS_OK);
}

/* The paper's friction, fine; nodes numbered along y; a fold that leaves an edge 1e-7 long. */
TEST_EACH(other_mesh_is_a_body, 0, 2) {
  dls_forming_data d;
  ck_assert_int_eq(run_mesh(_i ? "indentation" : "extrusion", 0, 0.1, 8, _i ? 3 : 40, &d), DLS_OK);
  if (_i) ck_assert_int_eq(run_mesh("extrusion", 2, 0.4, 3, 15, &d), DLS_FOLDED);
}

/* Forces of every method at a friction where lateral nodes lie on the ram. */
TEST(methods_agree_beyond_the_paper) {
  double force[method_count];
  for (int k = 0; k < method_count; k++) {
    dls_forming_data d;
    ck_assert_int_eq(run_mesh("extrusion", k, 0.2, 3, 15, &d), DLS_OK);
    ck_assert_int_eq(d.count.halvings, 0);
    force[k] = d.force;
    ck_assert_double_eq_tol(force[k], force[0], (k == 5 ? 1e-3 : k == 6 ? 1e-8 : 1e-9) * force[0]);
  }
}

/* Where a run is halved sooner or later: auto, Lemke's method and the augmented Lagrangian have one
 * force on all steps before the first halving of any. */
TEST_EACH(methods_agree_before_halving, 0, 2) {
  static const double mu[] = {0.3, 0.4};
  static const int chosen[] = {0, 1, 4}, least[] = {40, 20};
  dls_forming *f[3];
  dls_forming_data d;
  int halvings = 0, steps = 0;
  for (int k = 0; k < 3; k++)
    f[k] = create("extrusion", chosen[k], mu[_i], 0, 0);
  for (; !halvings; steps++) {
    double force = 0;
    for (int k = 0; k < 3; k++) {
      const dls_status status = dls_forming_step(f[k], &error);
      dls_forming_get(f[k], &d);
      halvings = d.count.halvings;
      if (halvings) break;
      ck_assert_int_eq(status, DLS_OK);
      if (k == 0) force = d.force;
      ck_assert_double_eq_tol(d.force, force, 1e-8 * force);
    }
  }
  ck_assert_int_ge(steps, least[_i]);
  for (int k = 0; k < 3; k++)
    dls_forming_destroy(f[k]);
}

/* Beyond the friction that the mesh bears auto stops at one corner, and no earlier than Lemke's
 * method. Halved steps are paths of their own: the last digits of the arithmetic move each stop by
 * a few steps, and decide whether Lemke's method comes to that corner or to a step that it finds
 * no answer of; from mu = .34 on those of auto, too. Up to .33 it folds there with OpenBLAS's
 * kernels for Zen, Sandy Bridge, Nehalem and Prescott, within 1 mm of travel. */
TEST_EACH(auto_goes_as_far, 0, 3) {
  static const double mu[] = {0.3, 0.31, 0.32};
  double travel[2];
  for (int k = 0; k < 2; k++) {
    dls_forming_data d;
    const dls_status status = run_mesh("extrusion", k, mu[_i], 0, 0, &d);
    travel[k] = d.travel;
    if (k && status == DLS_STALLED) continue;
    ck_assert_int_eq(status, DLS_FOLDED);
    ck_assert_int_eq(d.fault.kind, DLS_FORMING_CORNER);
    ck_assert_int_eq(d.fault.element, 63);
    ck_assert_int_eq(d.fault.corner, 1);
  }
  ck_assert_double_gt(travel[0], 0.95 * travel[1]);
}

/* Where steps are halved, methods differ by what the error of the steps says; at 160 mm. */
TEST(halved_methods_agree) {
  double force[2], off[2];
  for (int k = 0; k < 2; k++) {
    dls_forming_settings s;
    dls_forming_settings_init(&s);
    s.method = k ? DLS_LEMKE : DLS_AUTO;
    s.mu = 0.2;
    s.step_tol = 1e-3;
    dls_forming *f;
    ck_assert_int_eq(dls_forming_create(&f, "extrusion", &s, &error), DLS_OK);
    dls_forming_data d;
    for (int step = 0; step < 270; step++)
      ck_assert_int_eq(dls_forming_step(f, &error), DLS_OK);
    dls_forming_get(f, &d);
    ck_assert_int_gt(d.count.halvings, 0);
    force[k] = d.force;
    off[k] = d.step_error;
    dls_forming_destroy(f);
  }
  ck_assert_double_le(fmax(off[0], off[1]), 0.04 * force[0]);
  ck_assert_double_eq_tol(force[0], force[1], off[0] + off[1]);
}

/* The forces of the tools add up to zero, the container stands apart from the die, and the force is
 * that on the ram. With friction at the ram, which counts as a tool like the others. */
TEST_EACH(tools_balance, 0, 2) {
  dls_forming_settings s;
  dls_forming_settings_init(&s);
  s.ram_mu = _i ? 0.1 : 0;
  s.method = DLS_AUTO;
  dls_forming *f;
  ck_assert_int_eq(dls_forming_create(&f, "extrusion", &s, &error), DLS_OK);
  dls_forming_data d;
  dls_forming_get(f, &d);
  for (int step = 0; step < d.steps; step++) {
    ck_assert_int_eq(dls_forming_step(f, &error), DLS_OK);
    dls_forming_get(f, &d);
    double sum = 0;
    for (int k = 0; k < d.tools; k++)
      sum += d.tool[k].force[1];
    ck_assert_double_le(fabs(sum), 1e-9 * d.force);
    ck_assert_str_eq(d.tool[2].name, "ram");
    ck_assert_double_eq_tol(-d.tool[2].force[1], d.force, 1e-12 * d.force);
  }
  ck_assert_double_gt(d.tool[0].force[1], 0.2 * d.force); /* friction at the container */
  ck_assert_double_gt(d.tool[3].force[1], 0.5 * d.force);
  dls_forming_destroy(f);
}

/* The force at the end depends on the number of steps by no more than is said. */
TEST(step_error) {
  static const int steps[] = {75, 300, 600};
  double force[3], off[3];
  for (int k = 0; k < 3; k++) {
    dls_forming_settings s;
    dls_forming_settings_init(&s);
    s.method = DLS_AUTO;
    s.steps = steps[k];
    s.step_tol = 1e-3;
    dls_forming *f;
    ck_assert_int_eq(dls_forming_create(&f, "extrusion", &s, &error), DLS_OK);
    dls_forming_data d;
    for (int step = 0; step < s.steps; step++)
      ck_assert_int_eq(dls_forming_step(f, &error), DLS_OK);
    dls_forming_get(f, &d);
    ck_assert_double_gt(d.step_error, 0);
    ck_assert_double_le(d.step_error, 0.01 * d.force);
    off[k] = d.step_error;
    ck_assert_int_ge(d.count.compared, s.steps);
    force[k] = d.force;
    dls_forming_destroy(f);
  }
  ck_assert_double_lt(off[2], off[0] / 2);
  for (int k = 0; k < 3; k++)
    ck_assert_double_eq_tol(force[k], force[2], off[k] + off[2]);
}

/* Indentation without friction, at the paper's, and beyond: a body by every method, one force, more
 * of it with more friction, and tools in balance: what the cylinder presses the floor holds. */
TEST(indentation_at_any_friction) {
  static const double mu[] = {0, 0.1, 0.4};
  char folder[] = "/tmp/test_body.XXXXXX";
  ck_assert_ptr_nonnull(mkdtemp(folder));
  double force[3];
  for (int k = 0; k < 3; k++)
    for (int method = 0; method < 5; method++) {
      dls_forming *f = create("indentation", method, mu[k], 10, 10);
      dls_forming_data d;
      ck_assert_int_eq(run_to_the_end(f, folder, &d), DLS_OK);
      ck_assert_int_eq(d.count.halvings, 0);
      if (method == 0) force[k] = d.force;
      ck_assert_double_eq_tol(d.force, force[k], 1e-7 * force[k]);
      ck_assert_double_eq_tol(d.tool[2].force[1], d.force, 1e-8 * d.force);
      double slip = 0;
      for (int c = 0; c < d.candidates; c++) {
        slip = fmax(slip, fabs(d.r[2 * c + 1]));
        ck_assert_double_le(fabs(d.r[2 * c + 1]), mu[k] * d.r[2 * c] + 1e-7 * force[k]);
      }
      ck_assert((slip == 0) == (mu[k] == 0));
      dls_forming_destroy(f);
    }
  ck_assert_double_gt(force[1], force[0]);
  ck_assert_double_gt(force[2], force[1]);
  ck_assert_int_eq(rmdir(folder), 0);
}
