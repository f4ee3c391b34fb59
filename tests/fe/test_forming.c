/* test_forming.c: tests indentation and extrusion of [Chabrand 1998] against reference values,
 * energies, and method against method. */
#define _XOPEN_SOURCE 700 /* mkdtemp */

#include <signal.h>
#include <sys/resource.h>
#include <unistd.h>

#include "fe/forming_internal.h"
#include "run.h"

static dls_error error;

static dls_forming_settings init(void) {
  dls_forming_settings s;
  dls_forming_settings_init(&s);
  return s;
}

static dls_forming *create_forming(const char *name, const dls_forming_settings *s) {
  dls_forming *f;
  ck_assert_int_eq(dls_forming_create(&f, name, s, &error), DLS_OK);
  return f;
}

static dls_forming_data get(const dls_forming *f) {
  dls_forming_data d;
  dls_forming_get(f, &d);
  return d;
}

static void step_until(dls_forming *f, double travel) {
  while (get(f).travel < travel - 1e-9)
    ck_assert_int_eq(dls_forming_step(f, &error), DLS_OK);
  ck_assert_double_eq_tol(get(f).travel, travel, 1e-9);
}

/* ---- published and reference values ---------------------------------------------------------- */

typedef struct spot {
  double travel, low, high; /* band of the force */
} spot;

typedef struct run {
  const char *name;
  double mu;
  int clamped;
  spot spots[4];
} run;

/* Bands of two independent finite element codes, CalculiX and GetFEM; where both values are known,
 * the band is 0.1 % beyond each. The end of the extrusion has no band: it must only be reached. */
static const run runs[] = {
    {"indentation", 0.2, 0, {{1, 4809, 4891}, {5, 9123, 9188}, {10, 12709, 12842}}},
    {"indentation", 0, 0, {{1, 4834, 4851}, {5, 9108, 9141}, {10, 11973, 12013}}},
    {"indentation", 0.2, 1, {{1, 5263, 5293}, {5, 12009, 12044}, {10, 16285, 16488}}},
    {"extrusion",
     0.1,
     0,
     {{39.116, 40734, 42192}, {81.788, 176615, 183925}, {124.46, 612562, 637928}, {177.8, 0, 1e9}}},
    {"extrusion",
     0,
     0,
     {{39.116, 11403, 11773}, {81.788, 38732, 39636}, {124.46, 105099, 109389}, {177.8, 0, 1e9}}},
};

enum { run_count = sizeof runs / sizeof runs[0] };

TEST_EACH(reference_forces, 0, 2 * run_count) {
  const run *r = &runs[_i % run_count];
  dls_forming_settings s = init();
  s.method = _i < run_count ? DLS_LEMKE : DLS_AUTO;
  s.mu = r->mu;
  s.clamped = r->clamped;
  dls_forming *f = create_forming(r->name, &s);
  for (int k = 0; k < 4 && r->spots[k].travel > 0; k++) {
    step_until(f, r->spots[k].travel);
    const dls_forming_data d = get(f);
    ck_assert_double_ge(d.force, r->spots[k].low);
    ck_assert_double_le(d.force, r->spots[k].high);
  }
  const dls_forming_data d = get(f);
  ck_assert_double_eq(d.travel, d.whole);
  ck_assert_int_eq(d.count.halvings, 0);
  ck_assert_double_le(d.worst_equilibrium, s.tol);
  ck_assert_double_le(d.worst_residual, s.tol);
  if (r == runs) { /* the contact set and the largest plastic strain at 10 mm */
    int contacts = 0;
    double last = 0, strain = 0;
    for (int c = 0; c < d.candidates; c++)
      if (d.r[2 * c] > 0) {
        const int node = d.candidate_node[c];
        contacts++;
        last = d.mesh->xy[2 * node] + d.displacement[2 * node];
      }
    for (int q = 0; q < 4 * d.mesh->quads; q++)
      strain = fmax(strain, d.plastic_strain[q]);
    ck_assert_int_eq(contacts, 10);
    ck_assert_double_eq_tol(last, 20.2, 0.1);
    ck_assert_double_eq_tol(strain, 0.5, 0.01);
  }
  ck_assert_int_eq(dls_forming_step(f, &error), DLS_E_ARGUMENT); /* no step is left */
  ck_assert_str_eq(error.argument, "forming");
  dls_forming_destroy(f);
}

/* The reference gives 13,761 for fully integrated elements. */
TEST(standard_elements_lock) {
  dls_forming_settings s = init();
  s.standard = 1;
  dls_forming *f = create_forming("indentation", &s);
  step_until(f, 10);
  ck_assert_double_eq_tol(get(f).force, 13761, 0.005 * 13761);
  dls_forming_destroy(f);
}

/* ---- energy ---------------------------------------------------------------------------------- */

static double imbalance(const dls_forming_energy *e) {
  return fabs(e->elastic + e->plastic + e->friction - e->external) / e->external;
}

TEST_EACH(energy, 0, 2) {
  const double bound = _i == 0 ? 0.005 : 0.01;
  dls_forming_settings s = init();
  s.steps = _i == 0 ? 200 : 600;
  dls_forming *f = create_forming(_i == 0 ? "indentation" : "extrusion", &s);
  step_until(f, get(f).whole);
  const dls_forming_energy e = get(f).energy;
  ck_assert_double_gt(e.friction, bound * e.external);
  ck_assert_double_gt(e.plastic, bound * e.external);
  ck_assert_double_le(imbalance(&e), bound);
  dls_forming_destroy(f);
}

/* Friction's part of the balance is too small for the bound above. An independent sum over the
 * steps from the public data: the slip is the motion of a node less that of the obstacle (the die
 * stands) along t, its work the trapezoid of r_t. */
TEST_EACH(friction_energy, 0, 2) {
  dls_forming_settings s = init();
  s.nx = _i == 0 ? 10 : 2;
  s.ny = 10;
  s.steps = _i == 0 ? 50 : 150;
  dls_forming *f = create_forming(_i == 0 ? "indentation" : "extrusion", &s);
  enum { most = 12 }; /* extrusion: lateral surface, front */
  double before[2 * most], rt[most] = {0}, travel = 0, work = 0;
  dls_forming_data d = get(f);
  ck_assert_int_eq(d.candidates, _i == 0 ? 11 : most);
  for (int c = 0; c < d.candidates; c++)
    memcpy(before + 2 * c, d.displacement + 2 * d.candidate_node[c], 2 * sizeof *before);
  for (int k = 0; k < s.steps; k++) {
    ck_assert_int_eq(dls_forming_step(f, &error), DLS_OK);
    d = get(f);
    const double obstacle[2] = {0, _i == 0 ? travel - d.travel : 0};
    for (int c = 0; c < d.candidates; c++) {
      const double *now = d.displacement + 2 * d.candidate_node[c], *n = d.normal + 2 * c;
      const double slip = n[1] * (now[0] - before[2 * c] - obstacle[0]) -
                          n[0] * (now[1] - before[2 * c + 1] - obstacle[1]);
      work -= (rt[c] + d.r[2 * c + 1]) / 2 * slip;
      rt[c] = d.r[2 * c + 1];
      memcpy(before + 2 * c, now, 2 * sizeof *now);
    }
    travel = d.travel;
    ck_assert_double_eq_tol(d.energy.friction, work, 1e-9 * d.energy.external);
  }
  ck_assert_int_eq(d.count.halvings, 0);
  ck_assert_double_gt(work, 0.005 * d.energy.external);
  dls_forming_destroy(f);
}

/* [C] (13) as printed gives the default's force, but not its stored energy. */
TEST(update_as_printed) {
  double force[2];
  for (int keep = 0; keep < 2; keep++) {
    dls_forming_settings s = init();
    s.keep_trace = keep;
    dls_forming *f = create_forming("extrusion", &s);
    step_until(f, 81.788);
    const dls_forming_energy e = get(f).energy;
    force[keep] = get(f).force;
    ck_assert((imbalance(&e) < 0.01) == !keep);
    dls_forming_destroy(f);
  }
  ck_assert_double_eq_tol(force[0], force[1], 1e-5 * force[0]);
}

/* ---- convergence ----------------------------------------------------------------------------- */

/* The last three residuals of the equilibrium loop: each at most 1e3 times the square of the one
 * before, and that is far below it; up to where rounding (1e-11 here) takes over. */
TEST(quadratic_convergence) {
  dls_forming_settings s = init();
  s.nx = s.ny = 10;
  s.steps = 40;
  s.clamped = 1;
  dls_forming *f = create_forming("indentation", &s);
  int seen = 0;
  for (int k = 0; k < 20; k++) {
    ck_assert_int_eq(dls_forming_step(f, &error), DLS_OK);
    const dls_forming_data d = get(f);
    if (d.residuals < 4) continue;
    const double *e = d.residual + d.residuals - 3;
    ck_assert_double_lt(e[1], 0.1 * e[0]);
    ck_assert_double_le(e[2], 1e3 * e[1] * e[1] + 1e-10);
    seen++;
  }
  ck_assert_int_ge(seen, 1);
  dls_forming_destroy(f);
}

/* ---- methods --------------------------------------------------------------------------------- */

typedef struct method {
  dls_forming_contact contact;
  const char *name; /* of the condensed ones */
  double tol, agreement;
} method;

/* Gauss-Seidel works on the symmetric part of K and arrives at Lemke's answer, too. */
static const method methods[] = {
    {DLS_FORMING_CONDENSED, "nlgs", 1e-9, 1e-8},
    {DLS_FORMING_CONDENSED, "newton", 1e-9, 1e-8},
    {DLS_FORMING_CONDENSED, "augmented-lagrangian", 1e-9, 1e-8},
    {DLS_FORMING_GAUSS_SEIDEL, NULL, 1e-10, 1e-8},
    {DLS_FORMING_AUGMENTED_LAGRANGIAN, NULL, 1e-10, 1e-7},
    {DLS_FORMING_PENALTY, NULL, 1e-9, 2e-2},
};
enum { method_count = sizeof methods / sizeof methods[0] };

/* largest difference of a from b over the largest of b */
static double relative_distance(const double *a, const double *b, int n) {
  double d = 0, m = 0;
  for (int i = 0; i < n; i++) {
    d = fmax(d, fabs(a[i] - b[i]));
    m = fmax(m, fabs(b[i]));
  }
  return d / m;
}

TEST_EACH(methods_agree, 0, 2 * method_count) {
  const char *name = _i % 2 ? "extrusion" : "indentation";
  const method *m = &methods[_i / 2];
  dls_forming_settings s = init();
  s.nx = _i % 2 ? 2 : 10;
  s.ny = 10;
  s.steps = _i % 2 ? 150 : 50;
  dls_forming *reference = create_forming(name, &s);
  s.contact = m->contact;
  s.tol = m->tol;
  if (m->name) ck_assert(dls_method_find(m->name, &s.method));
  dls_forming *f = create_forming(name, &s);
  double worst = 0;
  for (int k = 0; k < 60 && k < s.steps; k++) {
    ck_assert_int_eq(dls_forming_step(reference, &error), DLS_OK);
    ck_assert_int_eq(dls_forming_step(f, &error), DLS_OK);
    const dls_forming_data a = get(f), b = get(reference);
    worst = fmax(worst, relative_distance(a.reaction, b.reaction, 2 * a.mesh->nodes));
    worst = fmax(worst, relative_distance(a.displacement, b.displacement, 2 * a.mesh->nodes));
  }
  ck_assert_double_le(worst, m->agreement);
  if (m->contact == DLS_FORMING_PENALTY) {
    ck_assert_double_ge(worst, 1e-6);
    ck_assert_double_ge(get(f).worst_residual, 1e-6); /* the certificate says so */
  } else {
    ck_assert_double_le(get(f).worst_residual, m->tol);
  }
  dls_forming_destroy(reference);
  dls_forming_destroy(f);
}

/* auto tries Newton's method on K first and finds Lemke's answer. Under the large steps and the
 * friction of the third scene that fails now and then, and W is condensed. No step is halved:
 * halves would be another load path, with another plastic answer. */
TEST_EACH(newton_on_stiffness, 0, 3) {
  const char *name = _i == 1 ? "extrusion" : "indentation";
  dls_forming_settings s = init();
  if (_i == 2) {
    s.nx = s.ny = 6;
    s.steps = 12;
    s.mu = 3;
  }
  dls_forming *reference = create_forming(name, &s);
  s.method = DLS_AUTO;
  dls_forming *f = create_forming(name, &s);
  double worst = 0;
  for (int k = 0; k < get(f).steps; k++) {
    ck_assert_int_eq(dls_forming_step(reference, &error), DLS_OK);
    ck_assert_int_eq(dls_forming_step(f, &error), DLS_OK);
    const dls_forming_data a = get(f), b = get(reference);
    worst = fmax(worst, relative_distance(a.reaction, b.reaction, 2 * a.mesh->nodes));
  }
  const dls_forming_data a = get(f), b = get(reference);
  ck_assert_double_le(worst, 1e-10);
  ck_assert_double_le(a.worst_residual, s.tol);
  ck_assert(a.count.halvings == 0 && b.count.halvings == 0);
  ck_assert_int_ge(b.count.reductions, b.count.newton);
  if (_i == 2) {
    ck_assert_int_gt(a.count.reductions, 0);
    ck_assert_int_lt(a.count.reductions, a.count.newton / 2);
  } else {
    ck_assert_int_eq(a.count.reductions, 0);
    ck_assert_int_eq(a.count.newton, b.count.newton);
    ck_assert_int_lt(a.count.iterations, a.count.newton * 11 / 10);
  }
  dls_forming_destroy(reference);
  dls_forming_destroy(f);
}

/* ---- failures -------------------------------------------------------------------------------- */

/* A step that cannot converge, for a tolerance below rounding: a status, and the last good state,
 * from which the way goes on once the tolerance is back. */
TEST(failed_step) {
  dls_forming_settings s = init();
  s.nx = s.ny = 8;
  s.steps = 50;
  dls_forming *f = create_forming("indentation", &s), *twin = create_forming("indentation", &s);
  step_until(f, 1);
  step_until(twin, 1);
  f->settings.tol = 1e-16;
  ck_assert_int_eq(dls_forming_step(f, &error), DLS_STALLED);
  f->settings.tol = s.tol;
  const dls_forming_data a = get(f), b = get(twin);
  const size_t size = 2 * (size_t)a.mesh->nodes * sizeof(double);
  ck_assert_int_eq(a.count.halvings, 6);
  ck_assert(a.travel == b.travel && a.force == b.force);
  ck_assert(memcmp(a.displacement, b.displacement, size) == 0);
  ck_assert_double_le(relative_distance(a.stress, b.stress, 16 * a.mesh->quads), 1e-12);
  ck_assert_double_le(a.equilibrium, s.tol);
  ck_assert_int_eq(dls_forming_step(f, &error), DLS_OK);
  ck_assert_int_eq(dls_forming_step(twin, &error), DLS_OK);
  ck_assert_double_le(relative_distance(get(f).reaction, get(twin).reaction, 2 * a.mesh->nodes),
                      1e-8);
  dls_forming_destroy(f);
  dls_forming_destroy(twin);
}

/* Cancels at its third call in a step. */
static int cancel_third(void *calls, const dls_progress *progress) {
  ck_assert_int_ge(progress->iteration, 1);
  ck_assert_int_eq(progress->max_iterations, 100);
  return ++*(int *)calls == 3;
}

/* A step that is cancelled in its middle: the state of the step before, no fault; the same step
 * goes on to the bits of a twin that nobody has cancelled. */
TEST(cancelled_in_a_step) {
  for (int contact = DLS_FORMING_CONDENSED; contact <= DLS_FORMING_PENALTY; contact++) {
    int calls = -100000;
    dls_forming_settings s = init();
    s.contact = (dls_forming_contact)contact;
    s.method = DLS_AUTO;
    dls_forming *twin = create_forming("indentation", &s);
    s.progress = cancel_third;
    s.progress_data = &calls;
    dls_forming *f = create_forming("indentation", &s);
    ck_assert_int_eq(dls_forming_step(f, &error), DLS_OK);
    ck_assert_int_gt(calls, -100000);
    const double travel = get(f).travel, force = get(f).force;
    calls = 0;
    ck_assert_int_eq(dls_forming_step(f, &error), DLS_CANCELLED);
    ck_assert_int_eq(calls, 3);
    ck_assert_double_eq(get(f).travel, travel);
    ck_assert_double_eq(get(f).force, force);
    ck_assert_int_eq(get(f).fault.kind, DLS_FORMING_NO_FAULT);
    ck_assert_int_eq(dls_forming_step(f, &error), DLS_OK);
    for (int k = 0; k < 2; k++)
      ck_assert_int_eq(dls_forming_step(twin, &error), DLS_OK);
    ck_assert_double_eq(get(f).travel, get(twin).travel);
    ck_assert_double_eq(get(f).force, get(twin).force);
    dls_forming_destroy(f);
    dls_forming_destroy(twin);
  }
}

/* A limit that is over within the first step: its status, the state at rest, no fault; without the
 * limit the same scene goes on to the bits of its twin. */
TEST(time_limit) {
  for (int contact = DLS_FORMING_CONDENSED; contact <= DLS_FORMING_PENALTY; contact++) {
    dls_forming_settings s = init();
    s.contact = (dls_forming_contact)contact;
    s.method = DLS_AUTO;
    dls_forming *twin = create_forming("extrusion", &s);
    ck_assert_int_eq(dls_forming_step(twin, &error), DLS_OK);
    s.cpu_seconds = 1e-12;
    dls_forming *f = create_forming("extrusion", &s);
    for (int again = 0; again < 2; again++) {
      ck_assert_int_eq(dls_forming_step(f, &error), DLS_TIME_LIMIT);
      const dls_forming_data d = get(f);
      ck_assert_int_eq(d.fault.kind, DLS_FORMING_NO_FAULT);
      ck_assert(d.travel == 0 && d.force == 0 && d.count.newton == 0 && d.count.halvings == 0);
    }
    f->settings.cpu_seconds = 1e9;
    ck_assert_int_eq(dls_forming_step(f, &error), DLS_OK);
    ck_assert(get(f).force == get(twin).force);
    dls_forming_destroy(f);
    dls_forming_destroy(twin);
  }
}

#define REJECTED(field, value, status, argument_)                                                  \
  do {                                                                                             \
    dls_forming_settings bad = init();                                                             \
    bad.field = value;                                                                             \
    f = (dls_forming *)&bad;                                                                       \
    ck_assert_int_eq(dls_forming_create(&f, "extrusion", &bad, &error), status);                   \
    ck_assert_str_eq(error.argument, argument_);                                                   \
    ck_assert_ptr_null(f);                                                                         \
  } while (0)

TEST(bad_input) {
  dls_forming *f;
  const dls_forming_settings s = init();
  ck_assert_int_eq(dls_forming_create(NULL, "extrusion", &s, &error), DLS_E_ARGUMENT);
  ck_assert_int_eq(dls_forming_create(&f, NULL, &s, &error), DLS_E_ARGUMENT);
  REFUSES(ARGUMENT, "name", -1, dls_forming_create, &f, "forging", &s);
  ck_assert_int_eq(dls_forming_create(&f, "extrusion", NULL, &error), DLS_OK); /* the defaults */
  dls_forming_destroy(f);
  REJECTED(size, 3, DLS_E_SETTINGS, "settings");
  REJECTED(nx, -1, DLS_E_ARGUMENT, "nx");
  REJECTED(ny, -1, DLS_E_ARGUMENT, "ny");
  REJECTED(nx, INT_MAX, DLS_E_SIZE, "nx");
  REJECTED(ny, INT_MAX, DLS_E_SIZE, "ny");
  REJECTED(steps, -1, DLS_E_ARGUMENT, "steps");
  REJECTED(mu, NAN, DLS_E_NOT_FINITE, "mu");
  REJECTED(mu, INFINITY, DLS_E_NOT_FINITE, "mu");
  REJECTED(clamped, 2, DLS_E_ARGUMENT, "clamped");
  REJECTED(standard, 2, DLS_E_ARGUMENT, "standard");
  REJECTED(keep_trace, 2, DLS_E_ARGUMENT, "keep_trace");
  REJECTED(ram_mu, -1, DLS_E_ARGUMENT, "ram_mu");
  REJECTED(ram_mu, NAN, DLS_E_ARGUMENT, "ram_mu");
  REJECTED(penalty, -1, DLS_E_ARGUMENT, "penalty");
  REJECTED(augmentations, -1, DLS_E_ARGUMENT, "augmentations");
  REJECTED(relaxation, 0, DLS_E_ARGUMENT, "relaxation");
  REJECTED(aitken, 2, DLS_E_ARGUMENT, "aitken");
  REJECTED(step_tol, 2, DLS_E_ARGUMENT, "step_tol");
  REJECTED(cpu_seconds, -1, DLS_E_ARGUMENT, "cpu_seconds");
  REJECTED(cpu_seconds, NAN, DLS_E_ARGUMENT, "cpu_seconds");
  REJECTED(tol, 0, DLS_E_ARGUMENT, "tol");
  REJECTED(tol, NAN, DLS_E_ARGUMENT, "tol");
  REJECTED(contact, (dls_forming_contact)9, DLS_E_ARGUMENT, "contact");
  REJECTED(method, (dls_method)99, DLS_E_ARGUMENT, "method");
  ck_assert_int_eq(dls_forming_step(NULL, &error), DLS_E_ARGUMENT);
  dls_forming_data d;
  dls_forming_get(NULL, &d);
  ck_assert_ptr_null(d.mesh);
  dls_forming_destroy(NULL);
  ck_assert_str_eq(dls_forming_name(0), "indentation");
  ck_assert_str_eq(dls_forming_name(1), "extrusion");
  ck_assert(!dls_forming_name(2) && !dls_forming_name(-1) && !dls_forming_description(2));
  ck_assert(dls_forming_description(0) && dls_forming_description(1));
}

TEST(without_memory) {
  for (int contact = DLS_FORMING_CONDENSED; contact <= DLS_FORMING_PENALTY; contact++) {
    dls_forming_settings s = init();
    s.nx = 2;
    s.ny = 4;
    s.contact = (dls_forming_contact)contact;
    dls_forming *first;
    MALLOCS_FAIL((first = (dls_forming *)&s, dls_forming_create(&first, "extrusion", &s, &error)),
                 !first, DLS_OK, 4);
    dls_forming_destroy(first);
    dls_forming *f = create_forming("extrusion", &s), *twin = create_forming("extrusion", &s);
    ck_assert_int_eq(dls_forming_step(twin, &error), DLS_OK);
    dls_status status = DLS_E_MEMORY;
    for (long k = 1; status == DLS_E_MEMORY; k++) { /* out of memory: the last good state stays */
      malloc_fails_at(k < 20 ? k : 0);
      status = dls_forming_step(f, &error);
      malloc_fails_at(0); /* the test library allocates, too */
      if (status == DLS_E_MEMORY) ck_assert(get(f).travel == 0);
      ck_assert(k > 1 || status == DLS_E_MEMORY);
    }
    ck_assert_int_eq(status, DLS_OK);
    ck_assert(get(f).force == get(twin).force);
    dls_forming_destroy(f);
    dls_forming_destroy(twin);
  }
}

TEST(vtu) {
  char folder[] = "/tmp/test_forming.XXXXXX", path[64], line[256];
  ck_assert_ptr_nonnull(mkdtemp(folder));
  (void)snprintf(path, sizeof path, "%s/a.vtu", folder);
  dls_forming_settings s = init();
  s.nx = 2;
  s.ny = 3;
  dls_forming *f = create_forming("indentation", &s);
  ck_assert_int_eq(dls_forming_step(f, &error), DLS_OK);
  ck_assert_int_eq(dls_forming_write_vtu(f, path, &error), DLS_OK);
  FILE *file = fopen(path, "r");
  ck_assert_ptr_nonnull(file);
  int arrays = 0, sizes = 0, closed = 0;
  while (fgets(line, sizeof line, file)) {
    arrays += strstr(line, "<DataArray") != NULL;
    sizes += strstr(line, "NumberOfPoints=\"12\" NumberOfCells=\"6\"") != NULL;
    closed = strcmp(line, "</VTKFile>\n") == 0;
  }
  (void)fclose(file);
  ck_assert(arrays == 11 && sizes == 1 && closed);
  struct rlimit limit, before; /* a file of more than 1000 bytes fails as on a full disk */
  ck_assert_int_eq(getrlimit(RLIMIT_FSIZE, &before), 0);
  limit = before;
  limit.rlim_cur = 1000;
  void (*handler)(int) = signal(SIGXFSZ, SIG_IGN);
  ck_assert_int_eq(setrlimit(RLIMIT_FSIZE, &limit), 0);
  const dls_status status = dls_forming_write_vtu(f, path, &error);
  ck_assert_int_eq(setrlimit(RLIMIT_FSIZE, &before), 0);
  (void)signal(SIGXFSZ, handler);
  ck_assert_int_eq(status, DLS_E_FILE);
  ck_assert_int_eq(unlink(path), 0);    /* the file of before is still there */
  if (access("/dev/full", W_OK) == 0) { /* only files are removed: here a link to a device */
    ck_assert_int_eq(symlink("/dev/full", path), 0);
    ck_assert_int_eq(dls_forming_write_vtu(f, path, &error), DLS_E_FILE);
    ck_assert_int_eq(unlink(path), 0); /* it is still there */
  }
  (void)rmdir(folder);
  ck_assert_int_eq(dls_forming_write_vtu(f, path, &error), DLS_E_FILE);
  ck_assert_int_eq(dls_forming_write_vtu(f, NULL, &error), DLS_E_ARGUMENT);
  ck_assert_int_eq(dls_forming_write_vtu(NULL, path, &error), DLS_E_ARGUMENT);
  ck_assert_int_eq(dls_forming_write_tools(f, path, &error), DLS_E_FILE);
  ck_assert_int_eq(dls_forming_write_tools(f, NULL, &error), DLS_E_ARGUMENT);
  ck_assert_int_eq(dls_forming_write_tools(NULL, path, &error), DLS_E_ARGUMENT);
  dls_forming_destroy(f);
}
