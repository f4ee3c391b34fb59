/* test_groups.c: sweeps over groups of eight candidates (groups.c, groups_sweep.c). */
#include "cases.h"
#include "delassus.h"
#include "made.h"
#include "rigid.h"
#include "run.h"
#include "vi/sweep/groups.h"

/* The kernel with one lane in a register: plain doubles. */
enum { newton_steps = 1 };
#define WIDTH 1
#define TARGET
#define NAME(x) x##_1
#define ROOT(x) ((V){sqrt((x)[0])})
#define ANY(m)  ((m)[0] != 0)
#include "vi/sweep/groups_kernel.h"
#include "vi/vi_internal.h"

static const char *const kinds[] = {"packing-flow", "packing-rest", "discs-flow", "wall-pushed"};
static rigid made;

/* The problem of a test: kind _i / 2, of bodies or by blocks. */
static const dls_contact *groups_make(int i, int candidates) {
  ck_assert_int_eq(rigid_create(&made, kinds[i / 2], candidates, .5, 3), 0);
  return i % 2 ? &made.factored : &made.contact;
}

static int are_coupled(const dls_contact *p, int a, int b) {
  if (p->bodies.H) {
    for (int k = 0; k < 4; k++) {
      const int body = p->bodies.body[2 * a + k / 2];
      if (body >= 0 && body == p->bodies.body[2 * b + k % 2]) return 1;
    }
    return 0;
  }
  for (int k = p->Wb.p[a]; k < p->Wb.p[a + 1]; k++)
    if (p->Wb.i[k] == b) return 1;
  return 0;
}

/* Each candidate stands in one lane, and the eight of a group share nothing. Returns the number of
 * groups. */
static int check_groups(const dls_contact *p) {
  dlsi_groups g = {.count = 0};
  int *seen = calloc((size_t)p->nc, sizeof *seen);
  ck_assert_ptr_nonnull(seen);
  ck_assert_int_eq(dlsi_groups_set(&g, p, (dlsi_set){.count = p->nc}, NULL, NULL), DLS_OK);
  for (int k = 0; k < 8 * g.count; k++) {
    if (g.member[k] < 0) continue;
    ck_assert_int_eq(seen[g.member[k]]++, 0);
    for (int l = k / 8 * 8; l < k; l++)
      ck_assert(!are_coupled(p, g.member[l], g.member[k]));
  }
  for (int c = 0; c < p->nc; c++)
    ck_assert_int_eq(seen[c], 1);
  free(seen);
  const int count = g.count;
  dlsi_groups_free(&g);
  return count;
}

TEST_EACH(groups_share_nothing, 0, 8) {
  const dls_contact *p = groups_make(_i, 1200);
  ck_assert_int_lt(check_groups(p), p->nc / 6);
  rigid_free(&made);
}

/* Long rows: sets of 40 candidates, each coupled with all of its set. */
TEST(long_rows) {
  enum { sets = 16, side = 40, nc = sets * side };
  static double x[nc * side], q[nc], mu[nc];
  static int p[nc + 1], i[nc * side];
  for (int e = 0; e < nc * side; e++) {
    const int c = e / side;
    p[c + 1] = e + 1;
    i[e] = c / side * side + e % side;
    x[e] = i[e] == c ? 2 : .01;
  }
  const dls_contact problem = {.d = 1, .nc = nc, .q = q, .mu = mu, .Wb = {1, nc, p, i, x}};
  ck_assert_int_ge(check_groups(&problem), side);
  /* groups serve as long as the structure stays */
  dlsi_groups g = {.count = 0};
  ck_assert_int_eq(dlsi_groups_set(&g, &problem, (dlsi_set){.count = nc}, NULL, NULL), DLS_OK);
  ck_assert_int_eq(dlsi_groups_are_of(&g, &problem), 1);
  i[0] = 1;
  i[1] = 0;
  ck_assert_int_eq(dlsi_groups_are_of(&g, &problem), 0);
  dlsi_groups_free(&g);
}

/* Registers of 1, 2, 4 and 8 lanes give the same bits of r, v and u. */
TEST_EACH(bits_do_not_depend_on_lanes, 0, 8) {
  const dls_contact *p = groups_make(_i, 1200);
  const size_t m = (size_t)p->d * (size_t)p->nc, n = 6 * (size_t)made.bodies;
  double *r[4], *v[4], *u[4];
  for (int k = 0; k < 4; k++) {
    dlsi_groups g = {.count = 0, .width = 1 << k};
    r[k] = calloc(2 * m + n, sizeof *r[k]);
    ck_assert_ptr_nonnull(r[k]);
    u[k] = r[k] + m;
    v[k] = u[k] + m;
    ck_assert_int_eq(dlsi_groups_set(&g, p, (dlsi_set){.count = p->nc}, NULL, NULL), DLS_OK);
    for (int sweep = 0; sweep < 30; sweep++)
      ck_assert_int_eq(
          k ? dlsi_groups_sweep(&g, NULL, r[k], v[k]) : run_1(&g, 0, g.count, r[k], v[k], NULL), 1);
    if (k)
      dlsi_groups_look(&g, NULL, r[k], v[k], u[k]);
    else
      (void)run_1(&g, 0, g.count, r[k], v[k], u[k]);
    ck_assert_mem_eq(r[k], r[0], (2 * m + n) * sizeof *r[0]);
    dlsi_groups_free(&g);
  }
  double *exact = calloc(m, sizeof *exact);
  ck_assert_ptr_nonnull(exact);
  ck_assert_int_eq(dls_contact_certify(p, r[3], exact, &(dls_certificate){0}, NULL), DLS_OK);
  double size = 0;
  for (size_t k = 0; k < m; k++)
    size = fmax(size, fabs(p->q[k]));
  for (size_t k = 0; k < m; k++)
    ck_assert_double_le(fabs(exact[k] - u[3][k]), 1e-10 * size);
  free(exact);
  for (int k = 0; k < 4; k++)
    free(r[k]);
  rigid_free(&made);
}

/* A visit gives each candidate of a group the exact local solution, once its l has settled: a
 * fixed point of these sweeps is one of sweeps one by one. */
TEST_EACH(fixed_points_are_those_of_one_by_one, 4, 6) {
  const dls_contact *p = groups_make(_i, 600);
  double *r = calloc((size_t)(p->d * p->nc), sizeof *r);
  dls_info info;
  ck_assert_ptr_nonnull(r);
  dls_solver_settings s = settings_with(DLS_NLGS, default_tol);
  s.acceleration = DLS_ACCELERATION_MOMENTUM;
  s.limits.max_iterations = 200000;
  s.limits.tol = 1e-6;
  ck_assert_int_eq(dls_solve(p, &s, r, NULL, &info, NULL), DLS_OK);
  ck_assert_double_le(info.certificate.residual, 1e-6);
  free(r);
  rigid_free(&made);
}

/* Candidates with mu = infinity, mu = 0 and a block that is not positive definite take local.c. */
TEST_EACH(odd_candidates, 0, 3) {
  enum { nc = 800 };
  static double x[9 * nc], q[3 * nc], mu[nc], r[3 * nc], s[3];
  static int p[nc + 1], i[nc];
  const int d = _i + 1;
  set_seed(7);
  for (int c = 0; c < nc; c++) {
    double *W = x + d * d * c;
    for (int e = 0; e < d * d; e++)
      W[e] = e % (d + 1) == 0 ? 2 : .3 * uniform();
    if (d > 1 && c % 5 == 4) W[d + 1] = -1;
    mu[c] = c % 5 == 0 ? INFINITY : c % 5 == 1 ? 0 : .4;
    if (d == 1) mu[c] = 0;
    for (int k = 0; k < d; k++)
      q[d * c + k] = uniform() - (k ? .5 : .8);
    p[c + 1] = c + 1;
    i[c] = c;
  }
  const dls_contact problem = {.d = d, .nc = nc, .q = q, .mu = mu, .Wb = {d, nc, p, i, x}};
  dlsi_groups g = {.count = 0};
  const double *v = NULL;
  memset(r, 0, sizeof r);
  ck_assert_int_eq(dlsi_groups_set(&g, &problem, (dlsi_set){.count = nc}, NULL, NULL), DLS_OK);
  for (int sweep = 0; sweep < 500; sweep++) /* l of mu = 0 must not grow from each to the next */
    (void)dlsi_groups_sweep(&g, NULL, r, (double *)v);
  for (int c = 0; c < nc; c++) {
    (void)dlsi_nlgs_local(d, x + d * d * c, q + d * c, mu[c], s, NULL);
    for (int k = 0; k < d; k++)
      ck_assert_double_le(fabs(s[k] - r[d * c + k]), 1e-12);
  }
  dlsi_groups_free(&g);
}

/* A workspace for many candidates gives each problem the bits that a new one gives, while
 * candidates come and go, W changes or is given in the other storage. */
TEST_EACH(structure_that_changes, 0, 2) {
  static const int sizes[] = {1500, 900, 900, 1400, 300, 1500};
  dls_nlgs *work;
  dls_nlgs_settings settings;
  dls_nlgs_settings_init(&settings);
  settings.limits.max_iterations = 20;
  settings.acceleration = _i ? DLS_ACCELERATION_MOMENTUM : DLS_ACCELERATION_NONE;
  ck_assert_int_eq(dls_nlgs_create(&work, 3, 2000, &settings, NULL), DLS_OK);
  for (int k = 0; k < 6; k++) {
    const dls_contact *p = groups_make(k == 2 ? 1 : k % 2, sizes[k]);
    const size_t m = 3 * (size_t)p->nc;
    double *q = malloc(m * sizeof *q), *r = calloc(2 * m, sizeof *r);
    ck_assert(q && r);
    for (size_t e = 0; e < m; e++)
      q[e] = p->q[e] * (k == 2 ? 1.25 : 1);
    dls_contact now = *p;
    now.q = q;
    dls_nlgs *fresh;
    ck_assert_int_eq(dls_nlgs_create(&fresh, 3, p->nc, &settings, NULL), DLS_OK);
    ck_assert_int_eq(dls_nlgs_solve(work, &now, r, NULL, NULL, NULL), DLS_MAX_ITERATIONS);
    ck_assert_int_eq(dls_nlgs_solve(fresh, &now, r + m, NULL, NULL, NULL), DLS_MAX_ITERATIONS);
    ck_assert_mem_eq(r, r + m, m * sizeof *r);
    dls_nlgs_destroy(fresh);
    free(q);
    free(r);
    rigid_free(&made);
  }
  dls_nlgs_destroy(work);
}

/* Each allocation fails in turn; then all goes well in the same workspace. */
TEST_EACH(memory_of_groups, 0, 2) {
  const dls_contact *p = groups_make(_i, 700);
  double *r = calloc((size_t)(p->d * p->nc), sizeof *r);
  dls_nlgs_settings settings;
  dls_nlgs *work;
  ck_assert_ptr_nonnull(r);
  dls_nlgs_settings_init(&settings);
  settings.limits.max_iterations = 3;
  ck_assert_int_eq(dls_nlgs_create(&work, p->d, p->nc, &settings, NULL), DLS_OK);
  MALLOCS_FAIL(dls_nlgs_solve(work, p, r, NULL, NULL, NULL), 1, DLS_MAX_ITERATIONS, 3);
  dls_nlgs_destroy(work);
  free(r);
  rigid_free(&made);
}
