/*
 * test_failures.c: the answer of each method to each problem of data/failures: never a false
 * "solved", never without end, and one of the solutions that the file states if it says "ok".
 */
#include "delassus.h"
#include "failures.h"
#include "made.h"
#include "run.h"

enum { max_problems = 128, permutations = 1000 };

static failure all[max_problems];
static int problems;

static void setup(void) {
  static char names[max_problems][64];
  char why[200];
  problems = failures_list(TEST_DATA "/failures", names, max_problems);
  ck_assert_int_gt(problems, 0);
  for (int p = 0; p < problems; p++)
    if (!failure_read(TEST_DATA "/failures", names[p], &all[p], why)) ck_abort_msg("%s", why);
}

/* ---- the problem as a method takes it -------------------------------------------------------- */

typedef struct instance {
  const failure *f;
  dls_lcp lcp;
  double M[FAILURE_N * FAILURE_N], q[FAILURE_N]; /* of lcp */
} instance;

/* 0 for a contact problem in 3D, which has no LCP */
static int make_instance(const failure *f, instance *i) {
  i->f = f;
  int n = f->n;
  if (f->d == 3) return 0;
  if (f->d == 2) {
    const dls_contact c = failure_contact(f);
    n = dls_contact_lcp_size(&c);
    ck_assert_int_le(n, FAILURE_N);
    ck_assert_int_eq(dls_contact_to_lcp(&c, NULL, i->M, n, i->q, NULL), DLS_OK);
  } else {
    memcpy(i->M, f->M, sizeof i->M);
    memcpy(i->q, f->q, sizeof i->q);
  }
  i->lcp = (dls_lcp){.n = n, .M = {n, n, n, i->M}, .q = i->q};
  return 1;
}

/* x := what the file speaks of (r or z) from the z of the LCP */
static void as_stated(const instance *i, const double *z, double *x) {
  if (i->f->d == 2) {
    const dls_contact c = failure_contact(i->f);
    ck_assert_int_eq(dls_contact_from_lcp(&c, NULL, z, x, NULL), DLS_OK);
  } else
    memcpy(x, z, (size_t)i->f->n * sizeof *x);
}

static double failure_residual(const failure *f, const double *x) {
  if (f->d) {
    const dls_contact problem = failure_contact(f);
    dls_certificate c = certificate_of(&problem, x);
    return dls_certificate_holds(&c, 1e-12) ? 0 : c.residual;
  }
  dls_lcp_certificate c;
  const dls_lcp problem = {.n = f->n, .M = {f->n, f->n, f->n, f->M}, .q = f->q};
  ck_assert_int_eq(dls_lcp_certify(&problem, x, NULL, &c, NULL), DLS_OK);
  return dls_lcp_certificate_holds(&c, 1e-12) ? 0 : c.residual;
}

/* 1 if x is point p of the file within close |x| */
static int is_near(const failure *f, int p, const double *x, double close) {
  double size = 0;
  for (int i = 0; i < f->n; i++)
    size = fmax(size, fabs(f->point[p].x[i]));
  for (int i = 0; i < f->n; i++)
    if (!(fabs(x[i] - f->point[p].x[i]) <= close * size)) return 0;
  return 1;
}

/* for x to rounding; the worst condition number there is 4e6 */
static int is_point(const failure *f, int p, const double *x) {
  return is_near(f, p, x, 1e-8);
}

static int is_stated(const failure *f, const double *x) {
  for (int p = 0; p < f->points; p++)
    if (is_point(f, p, x)) return 1;
  return 0;
}

/* ---- (a) the solutions are solutions --------------------------------------------------------- */

TEST(stated_solutions_are_solutions) {
  for (int p = 0; p < problems; p++) {
    const failure *f = &all[p];
    for (int s = 0; s < f->points; s++) {
      ck_assert_msg(failure_residual(f, f->point[s].x) == 0, "%s, point %d: residual %.2e", f->name,
                    s, failure_residual(f, f->point[s].x));
      for (int t = 0; t < s; t++) /* a continuum is convex */
        if (f->point[s].continuum >= 0 && f->point[s].continuum == f->point[t].continuum) {
          double x[FAILURE_N];
          for (int i = 0; i < f->n; i++)
            x[i] = 0.25 * f->point[s].x[i] + 0.75 * f->point[t].x[i];
          ck_assert_msg(failure_residual(f, x) == 0, "%s, between %d and %d", f->name, s, t);
        }
      for (int t = 0; t < f->rays; t++)
        if (f->point[s].continuum == f->ray[t].continuum) {
          double x[FAILURE_N];
          for (int i = 0; i < f->n; i++)
            x[i] = f->point[s].x[i] + 10 * f->ray[t].x[i];
          ck_assert_msg(failure_residual(f, x) == 0, "%s, point %d, ray %d", f->name, s, t);
        }
    }
  }
}

/* ---- (b) enumeration finds exactly them ------------------------------------------------------ */

/* 1 if the form c.x varies in some continuum of the file */
static int varies(const failure *f, int i, double ci, int j, double cj) {
  for (int s = 0; s < f->points; s++)
    for (int t = 0; t < s; t++)
      if (f->point[s].continuum >= 0 && f->point[s].continuum == f->point[t].continuum)
        if (ci * (f->point[s].x[i] - f->point[t].x[i]) +
                cj * (f->point[s].x[j] - f->point[t].x[j]) !=
            0)
          return 1;
  for (int t = 0; t < f->rays; t++)
    if (ci * f->ray[t].x[i] + cj * f->ray[t].x[j] != 0) return 1;
  return 0;
}

TEST(enumeration_finds_exactly_the_stated_solutions) {
  static double list[64 * FAILURE_N];
  for (int p = 0; p < problems; p++) {
    const failure *f = &all[p];
    instance it;
    if (!make_instance(f, &it)) continue;
    const int n = it.lcp.n;
    dls_enumeration found;
    ck_assert_int_eq(dls_lcp_enumerate(&it.lcp, 1e-12, 64, list, &found, NULL), DLS_OK);
    int met[FAILURE_POINTS] = {0};
    for (int k = 0; k < found.solutions; k++) {
      double x[FAILURE_N];
      as_stated(&it, list + k * n, x);
      ck_assert_msg(is_stated(f, x), "%s: solution %d of the enumeration is not stated", f->name,
                    k);
      for (int s = 0; s < f->points; s++)
        met[s] |= is_point(f, s, x);
    }
    int continua_met[FAILURE_POINTS] = {0};
    for (int s = 0; s < f->points; s++) {
      if (f->point[s].continuum < 0)
        ck_assert_msg(met[s], "%s: solution %d not found", f->name, s);
      else
        continua_met[f->point[s].continuum] |= met[s];
    }
    for (int c = 0; c < f->continua; c++)
      ck_assert_msg(continua_met[c], "%s: no point of continuum %d found", f->name, c);
    /* what is not determined: z, or r_n and phi_2 = mu r_n + r_t of each candidate */
    if (!f->d)
      for (int i = 0; i < n; i++)
        ck_assert_msg(found.undetermined[i] == varies(f, i, 1, i, 0), "%s: z[%d]", f->name, i);
    for (int c = 0, k = 0; c<f->nc; k += f->mu[c++]> 0 ? 3 : 1) {
      ck_assert_msg(found.undetermined[k] == varies(f, 2 * c, 1, 2 * c, 0), "%s: r_n of %d",
                    f->name, c);
      if (f->mu[c] > 0)
        ck_assert_msg(found.undetermined[k + 1] == varies(f, 2 * c, f->mu[c], 2 * c + 1, 1),
                      "%s: phi_2 of %d", f->name, c);
    }
  }
}

/* ---- (c), (e), (f) the pivoting methods, in any order of the unknowns ------------------------ */

static uint64_t state;

static int below(int n) {
  state = state * 6364136223846793005u + 1442695040888963407u;
  return (int)((state >> 33) % (uint64_t)n);
}

/* order := a random permutation; out := the LCP with unknowns in that order */
static void permute(const instance *it, int *order, double *M, double *q, dls_lcp *out) {
  const int n = it->lcp.n;
  for (int i = 0; i < n; i++)
    order[i] = i;
  for (int i = n - 1; i > 0; i--) {
    const int j = below(i + 1), k = order[i];
    order[i] = order[j];
    order[j] = k;
  }
  for (int j = 0; j < n; j++) {
    for (int i = 0; i < n; i++)
      M[i + j * n] = it->M[order[i] + order[j] * n];
    q[j] = it->q[order[j]];
  }
  *out = (dls_lcp){.n = n, .M = {n, n, n, M}, .q = q};
}

typedef struct method {
  const char *name;
  void *workspace;
  dls_status (*solve)(void *workspace, const dls_lcp *lcp, double *z);
} method;

static dls_status lemke(void *workspace, const dls_lcp *lcp, double *z) {
  return dls_lemke_solve(workspace, lcp, z, NULL, NULL, NULL);
}

static dls_status principal(void *workspace, const dls_lcp *lcp, double *z) {
  return dls_principal_solve(workspace, lcp, z, NULL, NULL, NULL);
}

/* z answers an instance: status is one of `allowed`, and if it is DLS_OK, z is a stated solution */
static void judge(const char *name, const instance *it, unsigned allowed, dls_status status,
                  const double *z) {
  const failure *f = it->f;
  ck_assert_msg(status >= 0 && (allowed >> status & 1), "%s, %s: %s", f->name, name,
                dls_status_name(status));
  if (status != DLS_OK) return;
  double x[FAILURE_N];
  dls_lcp_certificate c;
  ck_assert_int_eq(dls_lcp_certify(&it->lcp, z, NULL, &c, NULL), DLS_OK);
  ck_assert_msg(dls_lcp_certificate_holds(&c, 1e-12), "%s, %s: residual %.2e, floor %.2e", f->name,
                name, c.residual, c.floor);
  as_stated(it, z, x);
  ck_assert_msg(is_stated(f, x), "%s, %s: a solution that is not stated", f->name, name);
}

static void try_orders(const method *m, const instance *it, unsigned allowed) {
  double z[FAILURE_N], M[FAILURE_N * FAILURE_N], q[FAILURE_N], w[FAILURE_N];
  int order[FAILURE_N];
  judge(m->name, it, allowed, m->solve(m->workspace, &it->lcp, z), z);
  for (int k = 0; k < permutations; k++) {
    dls_lcp permuted;
    permute(it, order, M, q, &permuted);
    const dls_status status = m->solve(m->workspace, &permuted, w);
    for (int i = 0; i < it->lcp.n; i++)
      z[order[i]] = w[i];
    judge(m->name, it, allowed, status, z);
  }
}

TEST(lemke_in_any_order) {
  dls_lemke_settings settings;
  dls_lemke_settings_init(&settings);
  for (settings.crash = 0; settings.crash <= 1; settings.crash++) {
    dls_lemke *workspace;
    ck_assert_int_eq(dls_lemke_create(&workspace, FAILURE_N, &settings, NULL), DLS_OK);
    const method m = {settings.crash ? "lemke, crash start" : "lemke", workspace, lemke};
    for (int p = 0; p < problems; p++) {
      instance it;
      if (!make_instance(&all[p], &it)) continue;
      ck_assert_msg(all[p].lemke, "%s says nothing of Lemke's method", all[p].name);
      /* where there is a solution and the path ends in a ray, a crash start may find it */
      const unsigned lucky = settings.crash && !all[p].none ? 1u << DLS_OK : 0;
      try_orders(&m, &it, all[p].lemke | lucky);
    }
    dls_lemke_destroy(workspace);
  }
}

TEST(principal_pivoting_in_any_order) {
  dls_principal_settings settings;
  dls_principal_settings_init(&settings);
  int tried = 0;
  for (settings.block_steps = 0; settings.block_steps <= 10; settings.block_steps += 10) {
    dls_principal *workspace;
    ck_assert_int_eq(dls_principal_create(&workspace, FAILURE_N, &settings, NULL), DLS_OK);
    const method m = {settings.block_steps ? "block pivots" : "single pivots", workspace,
                      principal};
    for (int p = 0; p < problems; p++) {
      instance it;
      if (!all[p].principal) continue;
      ck_assert(make_instance(&all[p], &it));
      /* 2^n exchanges one by one take too long */
      if (settings.block_steps || it.lcp.n <= 6) try_orders(&m, &it, all[p].principal);
      tried++;
    }
    dls_principal_destroy(workspace);
  }
  ck_assert_int_ge(tried, 20);
}

/* Where M is no P-matrix the method may fail, but it must not lie. */
TEST(principal_pivoting_is_honest_elsewhere) {
  const unsigned any = 1u << DLS_OK | 1u << DLS_MAX_ITERATIONS | 1u << DLS_STALLED;
  dls_principal_settings settings;
  dls_principal_settings_init(&settings);
  dls_principal *workspace;
  ck_assert_int_eq(dls_principal_create(&workspace, FAILURE_N, &settings, NULL), DLS_OK);
  for (int p = 0; p < problems; p++) {
    instance it;
    double z[FAILURE_N];
    if (all[p].principal || !make_instance(&all[p], &it)) continue;
    const unsigned allowed = all[p].none ? any & ~(1u << DLS_OK) : any;
    judge("block pivots", &it, allowed, principal(workspace, &it.lcp, z), z);
  }
  dls_principal_destroy(workspace);
}

/* ---- (d) Gauss-Seidel ------------------------------------------------------------------------ */

/* r, solved by NLGS for the candidates in the order given, back in the order of the file */
static dls_status nlgs(const failure *f, const int *order, const dls_nlgs_settings *settings,
                       double *r) {
  const int d = f->d, n = f->n;
  double W[FAILURE_N * FAILURE_N], q[FAILURE_N], mu[FAILURE_N], x[FAILURE_N] = {0};
  int row[FAILURE_N];
  for (int i = 0; i < n; i++)
    row[i] = d * order[i / d] + i % d;
  for (int j = 0; j < n; j++) {
    for (int i = 0; i < n; i++)
      W[i + n * j] = f->M[row[i] + n * row[j]];
    q[j] = f->q[row[j]];
    mu[j / d] = f->mu[order[j / d]];
  }
  const dls_contact problem = {.d = d, .nc = f->nc, .W = {n, n, n, W}, .q = q, .mu = mu};
  dls_nlgs *workspace;
  ck_assert_int_eq(dls_nlgs_create(&workspace, d, f->nc, settings, NULL), DLS_OK);
  const dls_status status = dls_nlgs_solve(workspace, &problem, x, NULL, NULL, NULL);
  dls_nlgs_destroy(workspace);
  for (int i = 0; i < n; i++)
    r[row[i]] = x[i];
  return status;
}

/* NLGS need not converge, and whether it does depends on the order; it must not lie. */
TEST(gauss_seidel) {
  const unsigned any = 1u << DLS_OK | 1u << DLS_MAX_ITERATIONS | 1u << DLS_STALLED;
  dls_nlgs_settings settings;
  dls_nlgs_settings_init(&settings);
  settings.limits.tol = 1e-12;
  for (int p = 0; p < problems; p++) {
    const failure *f = &all[p];
    if (!f->d) continue;
    ck_assert_msg(f->nlgs, "%s says nothing of NLGS", f->name);
    for (int trial = 0; trial < 10; trial++) {
      int order[FAILURE_N] = {0};
      double r[FAILURE_N] = {0};
      for (int c = 0; c < f->nc; c++)
        order[c] = c;
      for (int c = f->nc - 1; trial > 0 && c > 0; c--) {
        const int k = below(c + 1), o = order[c];
        order[c] = order[k];
        order[k] = o;
      }
      const unsigned allowed = trial == 0 ? f->nlgs : f->none ? any & ~(1u << DLS_OK) : any;
      const dls_status status = nlgs(f, order, &settings, r);
      ck_assert_msg(status >= 0 && (allowed >> status & 1), "%s, nlgs: %s", f->name,
                    dls_status_name(status));
      if (status != DLS_OK) continue;
      ck_assert_msg(failure_residual(f, r) == 0, "%s, nlgs: residual %.2e", f->name,
                    failure_residual(f, r));
      /* inside of a continuum the certificate alone decides */
      if (f->continua == 0) ck_assert_msg(is_stated(f, r), "%s, nlgs: not stated", f->name);
    }
  }
}

/* A soft and a stiff support (c20), in both orders: 1e-8 is of either's reactions. */
TEST(scales) {
  const failure *f = NULL;
  for (int p = 0; p < problems; p++)
    if (!strcmp(all[p].name, "c20-scales")) f = &all[p];
  ck_assert_ptr_nonnull(f);
  dls_nlgs_settings settings;
  dls_nlgs_settings_init(&settings);
  for (int accelerated = 0; accelerated < 2; accelerated++)
    for (int first = 0; first < 2; first++) {
      const int order[] = {first, 1 - first};
      double r[FAILURE_N];
      settings.acceleration = accelerated ? DLS_ACCELERATION_ANDERSON : DLS_ACCELERATION_NONE;
      ck_assert_int_eq(nlgs(f, order, &settings, r), DLS_OK);
      const double exact[] = {0.5, -0.19, 5e5, 9e4};
      for (int i = 0; i < 4; i++)
        ck_assert_double_eq_tol(r[i] / exact[i], 1, 1e-6);
    }
}

/* ---- (g) every method through the front door ------------------------------------------------- */

static dls_status solve_by_method(const char *name, const dls_contact *problem, double *r) {
  dls_solver_settings s = settings_with(DLS_AUTO, 1e-12);
  if (!strcmp(name, "nlgs+anderson")) {
    s.method = DLS_NLGS;
    s.acceleration = DLS_ACCELERATION_ANDERSON;
  } else
    ck_assert_msg(dls_method_find(name, &s.method), "%s", name);
  return dls_solve(problem, &s, r, NULL, NULL, NULL);
}

static dls_status by_method(const char *name, const failure *f, double *r) {
  const dls_contact problem = failure_contact(f);
  return solve_by_method(name, &problem, r);
}

TEST(front_door) {
  for (int p = 0; p < problems; p++) {
    const failure *f = &all[p];
    for (int k = 0; f->d && k < FAILURE_METHODS; k++) {
      const char *name = failure_methods[k];
      double r[FAILURE_N];
      ck_assert_msg(f->solve[k], "%s says nothing of %s", f->name, name);
      const dls_status status = by_method(name, f, r);
      ck_assert_msg(status >= 0 && (f->solve[k] >> status & 1), "%s, %s: %s", f->name, name,
                    failure_word(status));
      ck_assert_msg(!(f->none && status == DLS_OK), "%s, %s: has no solution", f->name, name);
      if (status != DLS_OK) continue;
      ck_assert_msg(failure_residual(f, r) == 0, "%s, %s: residual %.2e", f->name, name,
                    failure_residual(f, r));
      int met = f->continua > 0; /* inside of one the certificate alone decides */
      for (int s = 0; s < f->points; s++)
        met |= is_near(f, s, r, 1e-4); /* 1e-12 times that condition number */
      ck_assert_msg(met, "%s, %s: not stated", f->name, name);
    }
  }
}

/* W in units of one, three and thirteen powers of two less: r is the same number of them more. */
TEST(units_keep_every_bit) {
  static const int power[] = {1, 3, 13};
  for (int p = 0; p < problems; p++) {
    const failure *f = &all[p];
    for (int k = 0; f->d && k < FAILURE_METHODS; k++)
      for (size_t e = 0; e < sizeof power / sizeof *power; e++) {
        double W[FAILURE_N * FAILURE_N], r[FAILURE_N], scaled[FAILURE_N];
        dls_contact problem = failure_contact(f);
        for (int i = 0; i < f->n * f->n; i++)
          W[i] = ldexp(f->M[i], -power[e]);
        problem.W.a = W;
        const char *name = failure_methods[k];
        ck_assert_msg(by_method(name, f, r) == solve_by_method(name, &problem, scaled),
                      "%s, %s, 2^-%d: another status", f->name, name, power[e]);
        for (int i = 0; i < f->n; i++)
          ck_assert_msg(scaled[i] == ldexp(r[i], power[e]), "%s, %s, 2^-%d: r[%d] is %a, not %a",
                        f->name, name, power[e], i, scaled[i], ldexp(r[i], power[e]));
      }
  }
}

TEST(auto_solves_what_can_be_solved) {
  for (int p = 0; p < problems; p++)
    if (all[p].d)
      ck_assert_msg((all[p].solve[0] == 1u << DLS_OK) == !all[p].none, "%s", all[p].name);
}

/* README.md has a line for each contact problem that a method other than penalty does not solve:
 * its name, and the words of its lines `solve`. */
TEST(table_is_that_of_the_files) {
  static char text[40000];
  FILE *in = fopen(TEST_DATA "/failures/README.md", "r");
  ck_assert_ptr_nonnull(in);
  text[fread(text, 1, sizeof text - 1, in)] = 0;
  fclose(in);
  for (int p = 0; p < problems; p++) {
    const failure *f = &all[p];
    if (!f->d) continue;
    char line[400];
    int hard = 0,
        n = snprintf(line, sizeof line, "| %s%s |", f->name, f->none ? " (no solution)" : "");
    for (int k = 0; k < FAILURE_METHODS; k++) {
      if (strcmp(failure_methods[k], "penalty") != 0) hard |= f->solve[k] != 1u << DLS_OK;
      for (int s = 0; s <= DLS_NO_SOLUTION_LIKELY; s++)
        if (f->solve[k] >> s & 1)
          n += snprintf(line + n, sizeof line - (size_t)n, " %s", failure_word(s));
      n += snprintf(line + n, sizeof line - (size_t)n, " |");
    }
    ck_assert_msg((strstr(text, line) != NULL) == hard, "README.md, not as it should be: %s", line);
  }
}

int main(void) {
  return run_tests("failures", setup, NULL);
}
