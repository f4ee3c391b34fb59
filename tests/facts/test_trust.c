/*
 * test_trust.c: all solutions of small problems, the fold, and the meaning of a residual.
 */
#include "delassus.h"
#include "delassus/fe.h"
#include "facts/facts.h"
#include "failures.h"
#include "front_cases.h"
#include "made.h"
#include "reduced.h"
#include "run.h"

enum { room = 64, most_m = 2 * DLS_STATES_MAX };

typedef struct solutions {
  double r[room * most_m], low[room * most_m], high[room * most_m];
  dls_solution_set set;
} solutions;

static dls_status enumerate(const dls_contact *p, solutions *s) {
  return dls_contact_enumerate(p, 1e-8, room, s->r, s->low, s->high, &s->set, NULL);
}

static int is_close(const double *a, const double *b, int m) {
  double difference = 0, size = 0;
  for (int i = 0; i < m; i++) {
    difference = fmax(difference, fabs(a[i] - b[i]));
    size = fmax(size, fmax(fabs(a[i]), fabs(b[i])));
  }
  return difference <= 1e-6 * size;
}

/* ---- the catalogue --------------------------------------------------------------------------- */

/* The connected sets of a file: set[k] of continuum k is the least one that it shares a point
 * with. Returns how many. */
static int connect(const failure *f, int *set) {
  int count = 0;
  for (int k = 0; k < f->continua; k++)
    set[k] = k;
  for (int pass = 0; pass < f->continua; pass++)
    for (int a = 0; a < f->points; a++)
      for (int b = 0; b < f->points; b++) {
        const int i = f->point[a].continuum, j = f->point[b].continuum;
        if (i < 0 || j < 0 || !is_close(f->point[a].x, f->point[b].x, f->n)) continue;
        set[i] = set[j] = set[i] < set[j] ? set[i] : set[j];
      }
  for (int k = 0; k < f->continua; k++)
    count += set[k] == k;
  return count;
}

/* The box around a set of the file. */
static void box(const failure *f, const int *set, int wanted, double *low, double *high) {
  for (int i = 0; i < f->n; i++) {
    low[i] = INFINITY;
    high[i] = -INFINITY;
    for (int a = 0; a < f->points; a++) {
      if (f->point[a].continuum < 0 || set[f->point[a].continuum] != wanted) continue;
      low[i] = fmin(low[i], f->point[a].x[i]);
      high[i] = fmax(high[i], f->point[a].x[i]);
    }
    for (int a = 0; a < f->rays; a++) {
      if (set[f->ray[a].continuum] != wanted) continue;
      if (f->ray[a].x[i] > 0) high[i] = INFINITY;
      if (f->ray[a].x[i] < 0) low[i] = -INFINITY;
    }
  }
}

static int same_box(const double *low, const double *high, const double *l, const double *h,
                    int m) {
  double size = 0;
  int same = 1;
  for (int i = 0; i < m; i++) {
    if (isfinite(l[i])) size = fmax(size, fabs(l[i]));
    if (isfinite(h[i])) size = fmax(size, fabs(h[i]));
  }
  for (int i = 0; i < m; i++) {
    same &= isfinite(l[i]) ? fabs(low[i] - l[i]) <= 1e-6 * size : low[i] == l[i];
    same &= isfinite(h[i]) ? fabs(high[i] - h[i]) <= 1e-6 * size : high[i] == h[i];
  }
  return same;
}

TEST(all_of_the_catalogue) {
  int count, problems = 0, continua = 0, none = 0;
  const failure *list = contact_failures(&count);
  for (int k = 0; k < count; k++) {
    const failure *f = &list[k];
    const dls_contact p = failure_contact(f);
    static solutions s;
    int set[FAILURE_POINTS], isolated = 0;
    if (f->d != 2 || f->nc > DLS_STATES_MAX) continue;
    problems++;
    const dls_status status = enumerate(&p, &s);
    if (f->none) {
      none++;
      ck_assert_msg(status == DLS_NO_SOLUTION, "%s: %s", f->name, dls_status_name(status));
      ck_assert(s.set.isolated == 0 && s.set.continua == 0 && s.set.states == 0);
      continue;
    }
    ck_assert_msg(status == DLS_OK, "%s: %s", f->name, dls_status_name(status));
    for (int a = 0; a < f->points; a++) {
      if (f->point[a].continuum >= 0) continue;
      isolated++;
      int seen = 0;
      for (int l = 0; l < s.set.isolated; l++)
        seen += is_close(s.r + l * f->n, f->point[a].x, f->n);
      ck_assert_msg(seen == 1, "%s: solution %d is listed %d times", f->name, a, seen);
    }
    ck_assert_msg(isolated == s.set.isolated, "%s: %d isolated", f->name, s.set.isolated);
    const int sets = connect(f, set);
    ck_assert_msg(sets == s.set.continua, "%s: %d continua", f->name, s.set.continua);
    continua += sets;
    for (int a = 0; a < f->continua; a++) {
      double low[FAILURE_N], high[FAILURE_N];
      int seen = 0;
      if (set[a] != a) continue;
      box(f, set, a, low, high);
      for (int l = isolated; l < isolated + sets; l++)
        seen += same_box(s.low + l * f->n, s.high + l * f->n, low, high, f->n);
      ck_assert_msg(seen == 1, "%s: continuum %d is listed %d times", f->name, a, seen);
    }
  }
  ck_assert_int_ge(problems, 30);
  ck_assert_msg(continua >= 4 && none >= 4, "%d, %d", continua, none);
}

/* ---- random problems ------------------------------------------------------------------------- */

/* Draws a problem of 2 or 3 candidates: W of any kind, whole numbers now and then. */
static dls_contact any_problem(int k, double *W, double *q, double *mu) {
  unsigned seed = (unsigned)k * 7919u + 17u;
  const int nc = 2 + k % 2, m = 2 * nc, kind = k / 2 % 5,
            rank = kind == 3   ? m - 1 - k % 2
                   : kind == 4 ? 1 + k / 10 % 2
                               : m;
  double B[6 * 6];
  for (int e = 0; e < m * m; e++)
    B[e] = kind == 4 ? nearbyint(3 * draw(&seed)) : draw(&seed);
  for (int i = 0; i < m; i++)
    for (int j = 0; j < m; j++) {
      W[i + m * j] = kind == 2 ? B[i + m * j] + (i == j) : 0;
      for (int l = 0; kind != 2 && l < rank; l++)
        W[i + m * j] += B[i + m * l] * B[j + m * l];
      if (kind == 1) W[i + m * j] += i < j ? 0.5 : i > j ? -0.5 : 0;
    }
  for (int i = 0; i < m; i++)
    q[i] = kind == 4 ? nearbyint(4 * draw(&seed)) - (i % 2 == 0) : draw(&seed) - 0.4 * (i % 2 == 0);
  for (int c = 0; c < nc; c++)
    mu[c] = (k / 10 + c) % 7 == 6 ? 0 : 0.5 * (1 + k / 10 % 6);
  return (dls_contact){.d = 2, .nc = nc, .W = {m, m, m, W}, .q = q, .mu = mu};
}

/* Returns 1 if r is one of the solutions, or in the box around a continuum. */
static int is_listed(const solutions *s, const double *r, int m) {
  for (int l = 0; l < s->set.isolated + s->set.continua; l++) {
    int inside = 1;
    for (int i = 0; i < m; i++) {
      const double slack = 1e-5 * (1 + fabs(r[i]));
      inside &= r[i] >= s->low[l * m + i] - slack && r[i] <= s->high[l * m + i] + slack;
    }
    if (inside || is_close(s->r + l * m, r, m)) return 1;
  }
  return 0;
}

/* What any method finds is in the list; a proof that there is none leaves it empty; and where it is
 * empty no method finds anything. */
TEST(agrees_with_the_verdicts) {
  int solved = 0, none = 0, proved = 0, several = 0, continua = 0, hidden = 0, farkas = 0;
  for (int k = 0; k < 1000; k++) {
    double W[36], q[6], mu[3], r[6];
    const dls_contact p = any_problem(k, W, q, mu);
    static solutions s;
    const dls_status status = enumerate(&p, &s);
    const int m = 2 * p.nc, listed = s.set.isolated + s.set.continua;
    ck_assert_msg(status == DLS_OK || status == DLS_NO_SOLUTION ||
                      status == DLS_NO_SOLUTION_LIKELY || status == DLS_STALLED,
                  "%d: %s", k, dls_status_name(status));
    ck_assert((status == DLS_OK) == (listed > 0) || status == DLS_STALLED);
    hidden += status == DLS_STALLED;
    none += listed == 0;
    proved += status == DLS_NO_SOLUTION;
    several += s.set.isolated > 1;
    continua += s.set.continua;
    for (dls_method method = DLS_AUTO; method <= DLS_LEMKE; method += 2) {
      dls_solver_settings settings = settings_of(method);
      settings.limits.tol = 1e-9;
      dls_info info;
      dls_solver *solver = solver_of(2, p.nc, &settings);
      const dls_status found = dls_solver_solve(solver, &p, r, NULL, &info, NULL);
      ck_assert_int_ge(found, 0);
      if (found == DLS_OK) {
        solved++;
        ck_assert_msg(is_listed(&s, r, m) || status == DLS_STALLED, "%d: %s finds another one", k,
                      dls_method_name(method));
      }
      if (found == DLS_NO_SOLUTION) {
        farkas++;
        ck_assert_msg(status == DLS_NO_SOLUTION, "%d: %s", k, dls_status_name(status));
      }
      if (found == DLS_NO_SOLUTION_LIKELY) ck_assert_int_eq(listed, 0);
      if (method == DLS_AUTO && listed) ck_assert_int_eq(found, DLS_OK);
      dls_solver_destroy(solver);
    }
  }
  ck_assert_msg(solved > 1500 && none > 100 && 5 * proved >= 4 * none && several > 50 &&
                    farkas > 100 && continua > 10 && hidden == 0,
                "solved %d, none %d, proved %d, several %d, continua %d, hidden %d, Farkas %d",
                solved, none, proved, several, continua, hidden, farkas);
}

TEST(enumerates_nothing_wrong) {
  double W[4] = {1, 0, 0, 1}, q[2] = {-1, 0}, mu[1] = {0.5}, r[2] = {7, 7}, low[2], high[2];
  dls_contact p = {.d = 2, .nc = 1, .W = {2, 2, 2, W}, .q = q, .mu = mu};
  dls_solution_set set = {9, 9, 9};
  dls_error e;
#define REFUSED(status, name, call)                                                                \
  do {                                                                                             \
    ck_assert_int_eq(call, status);                                                                \
    ck_assert_str_eq(e.argument, name);                                                            \
    ck_assert_str_eq(e.function, "dls_contact_enumerate");                                         \
    ck_assert(r[0] == 7 && set.states == 9);                                                       \
  } while (0)
  REFUSED(DLS_E_ARGUMENT, "r", dls_contact_enumerate(&p, 0, 1, NULL, low, high, &set, &e));
  REFUSED(DLS_E_ARGUMENT, "low", dls_contact_enumerate(&p, 0, 1, r, NULL, high, &set, &e));
  REFUSED(DLS_E_ARGUMENT, "high", dls_contact_enumerate(&p, 0, 1, r, low, NULL, &set, &e));
  REFUSED(DLS_E_ARGUMENT, "found", dls_contact_enumerate(&p, 0, 1, r, NULL, NULL, NULL, &e));
  REFUSED(DLS_E_ARGUMENT, "tol", dls_contact_enumerate(&p, -1, 1, r, NULL, NULL, &set, &e));
  REFUSED(DLS_E_ARGUMENT, "capacity", dls_contact_enumerate(&p, 0, 0, r, NULL, NULL, &set, &e));
  p.nc = -1;
  REFUSED(DLS_E_SIZE, "nc", dls_contact_enumerate(&p, 0, 1, r, NULL, NULL, &set, &e));
  double many[18 * 18] = {0}, long_q[18] = {0}, long_mu[9] = {0};
  p = (dls_contact){.d = 2, .nc = 9, .W = {18, 18, 18, many}, .q = long_q, .mu = long_mu};
  REFUSED(DLS_E_SIZE, "nc", dls_contact_enumerate(&p, 0, 1, r, NULL, NULL, &set, &e));
  p.d = 3;
  p.nc = 6;
  REFUSED(DLS_E_UNSUPPORTED, "d", dls_contact_enumerate(&p, 0, 1, r, NULL, NULL, &set, &e));
#undef REFUSED
}

/* Each malloc fails in turn, with a solution and without; a short list says so; q = 0. */
TEST(enumerates_at_the_edges) {
  double W[4] = {1, 1, 1, 2}, q[2] = {1, 4}, mu[1] = {2}, r[8] = {7}, zero[2] = {0, 0};
  const dls_contact p = {.d = 2, .nc = 1, .W = {2, 2, 2, W}, .q = q, .mu = mu};
  dls_solution_set set;
  ck_assert_int_eq(dls_contact_enumerate(&p, 1e-8, 4, r, NULL, NULL, &set, NULL), DLS_OK);
  ck_assert(set.isolated == 3 && set.continua == 0);
  double all[8], low[8], high[8];
  memcpy(all, r, sizeof all);
  ck_assert_int_eq(dls_contact_enumerate(&p, 1e-8, 3, r, low, high, &set, NULL), DLS_OK);
  for (int i = 0; i < 6; i++)
    ck_assert(low[i] == all[i] && high[i] == all[i]);
  for (int power = -40; power <= 40; power += 80) { /* forces in another unit are as different */
    double other[2] = {ldexp(1, power), ldexp(4, power)};
    dls_contact scaled = p;
    scaled.q = other;
    ck_assert_int_eq(dls_contact_enumerate(&scaled, 1e-8, 4, r, NULL, NULL, &set, NULL), DLS_OK);
    ck_assert(set.isolated == 3 && set.continua == 0);
    for (int i = 0; i < 6; i++)
      ck_assert(r[i] == ldexp(all[i], power));
  }
  r[2] = 7;
  ck_assert_int_eq(dls_contact_enumerate(&p, 1e-8, 1, r, NULL, NULL, &set, NULL),
                   DLS_MAX_ITERATIONS);
  ck_assert(set.isolated == 3 && r[2] == 7);
  dls_contact rest = p;
  rest.q = zero;
  ck_assert_int_eq(dls_contact_enumerate(&rest, 1e-8, 4, r, NULL, NULL, &set, NULL), DLS_OK);
  ck_assert(set.isolated == 1 && r[0] == 0 && r[1] == 0);
  double jam[4] = {-1, 0, 0, 1}, against[2] = {-1, 0};
  const dls_contact jammed = {.d = 2, .nc = 1, .W = {2, 2, 2, jam}, .q = against, .mu = mu};
  const dls_contact *const both[] = {&p, &jammed};
  for (int k = 0; k < 2; k++) {
    long failed = 0;
    for (dls_status status = DLS_E_MEMORY; status == DLS_E_MEMORY; failed++) {
      r[0] = 7;
      malloc_fails_at(failed + 1);
      status = dls_contact_enumerate(both[k], 1e-8, 4, r, NULL, NULL, &set, NULL);
      malloc_fails_at(0);
      ck_assert(status != DLS_E_MEMORY || r[0] == 7 || k == 1);
    }
    ck_assert_int_ge(failed, k ? 1 : 2);
  }
}

/* ---- the fold -------------------------------------------------------------------------------- */

/* W symmetric positive definite or, odd k, with an antisymmetric part. */
static dls_contact regular_problem(int k, double *W, double *q, double *mu) {
  unsigned seed = (unsigned)k * 104729u + 5u;
  const int nc = 2 + k % 4;
  dls_contact p = coupled(W, q, mu, 2, nc, 0.02 + 0.1 * (k % 3), 1, seed);
  const int m = 2 * nc;
  for (int i = 0; i < m && k % 2; i++)
    for (int j = 0; j < i; j++) {
      const double x = 0.1 * draw(&seed);
      W[i + m * j] += x;
      W[j + m * i] -= x;
    }
  for (int c = 0; c < nc; c++)
    mu[c] = k % 5 == 4 && c == 1 ? 0 : 1 + (k % 3) * 0.25 * c;
  return p;
}

/* The determinant of the matrix (FO1) of states[c] = 0 free, 1 stick, 2, 3 slip. */
static double state_determinant(const dls_contact *p, const int *states, double factor) {
  double A[100];
  int row[10], k = 0;
  const int m = 2 * p->nc;
  for (int c = 0; c < p->nc; c++) {
    if (states[c]) row[k++] = 2 * c;
    if (states[c] == 1) row[k++] = 2 * c + 1;
  }
  for (int j = 0; j < k; j++) {
    const int c = row[j] / 2;
    const double t = states[c] == 2 ? p->mu[c] : states[c] == 3 ? -p->mu[c] : 0;
    for (int i = 0; i < k; i++)
      A[i + 10 * j] = p->W.a[row[i] + m * row[j]] +
                      (states[c] > 1 ? factor * t * p->W.a[row[i] + m * (row[j] + 1)] : 0);
  }
  double det = 1;
  for (int s = 0; s < k; s++) {
    int best = s;
    for (int i = s; i < k; i++)
      if (fabs(A[i + 10 * s]) > fabs(A[best + 10 * s])) best = i;
    for (int j = 0; j < k; j++) {
      const double x = A[s + 10 * j];
      A[s + 10 * j] = A[best + 10 * j];
      A[best + 10 * j] = x;
    }
    det *= (best == s ? 1 : -1) * A[s + 10 * s];
    for (int i = s + 1; i < k; i++)
      for (int j = k - 1; j >= s; j--)
        A[i + 10 * j] -= A[i + 10 * s] / A[s + 10 * s] * A[s + 10 * j];
  }
  return det;
}

/* Returns the least determinant of all states. */
static double least_determinant(const dls_contact *p, double factor) {
  double least = INFINITY;
  for (int n = 0; n < 1 << 2 * p->nc; n++) {
    int states[5];
    for (int c = 0; c < p->nc; c++) { /* without friction none sticks */
      const int state = n >> 2 * c & 3;
      states[c] = state == 1 && !(p->mu[c] > 0) ? 2 : state;
    }
    least = fmin(least, state_determinant(p, states, factor));
  }
  return least;
}

/* The witness at the fold: two certified answers of one load, which the library gives both. */
static void expect_witness(const dls_contact *p, const dls_fold *fold, const double *q, double *r,
                           double *other, double *mu) {
  const int m = 2 * p->nc;
  double most_mu = 0, difference = 0, size = 0;
  for (int c = 0; c < p->nc; c++)
    most_mu = fmax(most_mu, p->mu[c]);
  for (int c = 0; c < p->nc; c++)
    mu[c] = p->mu[c] * fold->friction / most_mu;
  dls_contact w = *p;
  w.q = q;
  w.mu = mu;
  for (int k = 0; k < 2; k++) {
    double *start = k ? other : r;
    dls_solver_settings s = settings_of(DLS_AUTO);
    dls_info info;
    s.limits.tol = 1e-9;
    s.limits.warm_start = 1;
    ck_assert_int_eq(dls_solve(&w, &s, start, NULL, &info, NULL), DLS_OK);
  }
  for (int i = 0; i < m; i++) {
    difference = fmax(difference, fabs(r[i] - other[i]));
    size = fmax(size, fabs(r[i]));
  }
  ck_assert_msg(difference > 1e-3 * size, "%g of %g", difference, size);
}

TEST(fold_of_small_problems) {
  int found = 0, missed = 0;
  double late = 0;
  for (int k = 0; k < 100; k++) {
    double W[100], q[10], mu[5], load[10], r[10], other[10], at[5], most_mu = 0;
    double base[10];
    const dls_contact p = regular_problem(k, W, q, mu);
    dls_fold fold, search;
    dls_contact_state state[5];
    ck_assert_int_eq(dls_contact_fold(&p, &fold, state, load, r, other, NULL), DLS_OK);
    ck_assert_int_eq(dlsi_contact_fold(&p, 1, &search, NULL, NULL, NULL, NULL, NULL), DLS_OK);
    ck_assert(fold.exact && !search.exact);
    ck_assert(search.friction >= fold.friction * (1 - 1e-9));
    if (!isfinite(fold.friction)) continue;
    found++;
    if (search.friction / fold.friction - 1 > 1e-9) missed++;
    late = fmax(late, search.friction / fold.friction - 1);
    for (int c = 0; c < p.nc; c++)
      most_mu = fmax(most_mu, p.mu[c]);
    for (int l = 1; l <= 20; l++) /* regular all the way, and no longer beyond */
      ck_assert_msg(least_determinant(&p, 0.9999 * l / 20 * fold.friction / most_mu) > 0,
                    "%d: %d of 20, fold %.10g", k, l, fold.friction);
    ck_assert(least_determinant(&p, 1.0001 * fold.friction / most_mu) < 0);
    memcpy(base, r, sizeof base);
    expect_witness(&p, &fold, load, r, other, at);
    for (int beyond = 0; beyond < 2; beyond++) { /* one solution below the fold, several above */
      static solutions s;
      const double share = beyond ? 1.001 : 0.999;
      double close[5], moved[10];
      const int m = 2 * p.nc;
      dls_contact w = p;
      for (int c = 0; c < p.nc; c++)
        close[c] = share * at[c];
      for (int i = 0; i < m; i++) { /* r in its states and u stay, but for the slip's r_t */
        moved[i] = load[i];
        for (int c = 0; c < p.nc; c++)
          moved[i] += (1 - share) * W[i + m * (2 * c + 1)] * base[2 * c + 1];
      }
      w.q = moved;
      w.mu = close;
      const dls_status status = enumerate(&w, &s);
      ck_assert_msg(status == DLS_OK, "%d: %s", k, dls_status_name(status));
      ck_assert_msg(s.set.continua == 0, "%d", k);
      if (!beyond) ck_assert_msg(s.set.isolated == 1, "%d: %d", k, s.set.isolated);
      if (beyond) ck_assert_msg(s.set.isolated > 1, "%d: %d", k, s.set.isolated);
    }
  }
  ck_assert_msg(found > 90 && missed == 0, "%d, %d missed, by %g", found, missed, late);
}

TEST(fold_of_the_jean_block) {
  dls_fe_scene *scene;
  dls_fe_scene_data data;
  dls_reduction *reduction;
  dls_contact p;
  dls_fold fold;
  static double q[200], r[200], other[200], mu[100];
  ck_assert_int_eq(dls_fe_scene_create(&scene, "jean-fig3", 0, NULL), DLS_OK);
  dls_fe_scene_get(scene, &data);
  ck_assert_int_eq(reduce_on_W(&reduction, &data.model, NULL, NULL), DLS_OK);
  ck_assert_int_eq(dls_reduction_load(reduction, data.f, data.g, NULL), DLS_OK);
  ck_assert_int_eq(dls_reduction_contact(reduction, data.mu, &p, NULL), DLS_OK);
  ck_assert_int_eq(dls_contact_fold(&p, &fold, NULL, q, r, other, NULL), DLS_OK);
  ck_assert_msg(!fold.exact && fabs(fold.friction - 1.318) <= 0.01 * 1.318, "%.6g of %d matrices",
                fold.friction, fold.matrices);
  expect_witness(&p, &fold, q, r, other, mu);
  dls_reduction_destroy(reduction);
  dls_fe_scene_destroy(scene);
}

TEST(no_fold) {
  double W[9] = {1, 0, 0, 0, 1, 0, 0, 0, 1}, q[3] = {-1, 0, 0}, mu[1] = {0.5}, r[2] = {7, 7};
  dls_contact p = {.d = 2, .nc = 1, .W = {2, 2, 2, W}, .q = q, .mu = mu};
  dls_fold fold = {.matrices = -7};
  dls_contact_state state = DLS_STICK;
  dls_error e;
  W[1] = W[2] = 0; /* nothing couples n and t */
  W[3] = 1;
  ck_assert_int_eq(dls_contact_fold(&p, &fold, &state, NULL, r, NULL, &e), DLS_OK);
  ck_assert(fold.friction == INFINITY && fold.exact && state == DLS_STICK && r[0] == 7);
  fold.matrices = -7;
  W[3] = -1;
  REFUSES(NOT_POSITIVE_DEFINITE, "W", -1, dls_contact_fold, &p, &fold, NULL, NULL, NULL, NULL);
  W[3] = 1;
  REFUSES(ARGUMENT, "fold", -1, dls_contact_fold, &p, NULL, NULL, NULL, NULL, NULL);
  mu[0] = -1;
  ck_assert_int_eq(dls_contact_fold(&p, &fold, NULL, NULL, NULL, NULL, &e), DLS_E_ARGUMENT);
  mu[0] = 0.5;
  p.d = 1;
  mu[0] = 0;
  p.W = (dls_dense){1, 1, 1, W};
  ck_assert_int_eq(dls_contact_fold(&p, &fold, NULL, NULL, NULL, NULL, &e), DLS_E_UNSUPPORTED);
  ck_assert_int_eq(dls_contact_fold(NULL, &fold, NULL, NULL, NULL, NULL, &e), DLS_E_ARGUMENT);
  ck_assert_int_eq(fold.matrices, -7);
}

/* One candidate: the fold is W_nn / |W_nt|, in any unit. */
/* Nothing to look at is no reason to ask LAPACK, which would print. */
TEST(fold_of_nothing) {
  const dls_contact none = {.d = 2};
  dls_fold fold;
  ck_assert_int_eq(dls_contact_fold(&none, &fold, NULL, NULL, NULL, NULL, NULL), DLS_OK);
  ck_assert(fold.friction == INFINITY && fold.exact && fold.matrices == 0);
}

TEST(fold_of_one) {
  for (int k = 0; k < 3; k++) {
    const double unit = k == 0 ? 1 : k == 1 ? 1e9 : 1e-9;
    double W[4] = {unit, -0.8 * unit, -0.8 * unit, unit}, q[2] = {-1, 0}, mu[1] = {0.3};
    const dls_contact p = {.d = 2, .nc = 1, .W = {2, 2, 2, W}, .q = q, .mu = mu};
    dls_fold fold;
    ck_assert_int_eq(dls_contact_fold(&p, &fold, NULL, NULL, NULL, NULL, NULL), DLS_OK);
    ck_assert(fabs(fold.friction - 1.25) < 1e-12);
    mu[0] = 0;
    ck_assert_int_eq(dls_contact_fold(&p, &fold, NULL, NULL, NULL, NULL, NULL), DLS_OK);
    ck_assert(fabs(fold.friction - 1.25) < 1e-12);
    fold.matrices = -7;
    MALLOCS_FAIL(dls_contact_fold(&p, &fold, NULL, NULL, NULL, NULL, NULL), fold.matrices == -7,
                 DLS_OK, 2);
  }
}

/* ---- what a residual means ------------------------------------------------------------------- */

/* By hand: one candidate that sticks, slips, or is free, W = diag(4, 1). */
TEST(sensitivity_by_hand) {
  double W[4] = {4, 0, 0, 1}, q[2] = {-4, -0.25}, mu[1] = {0.5}, r[2] = {1, 0.25};
  const dls_contact p = {.d = 2, .nc = 1, .W = {2, 2, 2, W}, .q = q, .mu = mu};
  dls_sensitivity s;
  ck_assert_int_eq(dls_contact_sensitivity(&p, r, &s, NULL), DLS_OK);
  ck_assert(s.rows == 2 && s.rank == 2 && s.border == 0 && s.isolated == 1);
  ck_assert(fabs(s.amplification - hypot(4, 0.25) / hypot(1, 0.25)) < 1e-12);
  ck_assert(fabs(s.amplification_r - 1) < 1e-12);
  q[1] = -2; /* slips: r_t = 0.5, u_t = -1.5 */
  r[1] = 0.5;
  ck_assert_int_eq(dls_contact_sensitivity(&p, r, &s, NULL), DLS_OK);
  ck_assert(s.rows == 1 && s.rank == 1 && s.isolated == 1);
  ck_assert(fabs(s.amplification - sqrt(1.25) / 4 * hypot(4, 2) / hypot(1, 0.5)) < 1e-12);
  q[0] = 1; /* free */
  r[0] = r[1] = 0;
  ck_assert_int_eq(dls_contact_sensitivity(&p, r, &s, NULL), DLS_OK);
  ck_assert(s.rows == 0 && s.rank == 0 && s.isolated == 1 && s.error == 0);
  q[0] = 0; /* on the border */
  ck_assert_int_eq(dls_contact_sensitivity(&p, r, &s, NULL), DLS_OK);
  ck_assert(s.border == 1 && s.isolated == -1);
}

/* The continua of the catalogue have a rank below their rows; the prediction of a random problem
 * holds for what sweeps leave, within a factor. */
TEST(sensitivity_of_answers) {
  int count, singular = 0;
  const failure *list = contact_failures(&count);
  for (int k = 0; k < count; k++) {
    if (strcmp(list[k].name, "c05-hyperstatic") &&
        strcmp(list[k].name, "c21-frictionless-supports"))
      continue;
    const dls_contact p = failure_contact(&list[k]);
    double r[FAILURE_N];
    dls_sensitivity s;
    (void)solve_auto(&p, 1e-10, r);
    ck_assert_int_eq(dls_contact_sensitivity(&p, r, &s, NULL), DLS_OK);
    singular += s.rank < s.rows && s.error == INFINITY && s.isolated < 1;
  }
  ck_assert_int_eq(singular, 2);
  double most = 0, least = INFINITY;
  for (int k = 0; k < 100; k++) {
    static planted_problem a;
    const dls_contact p = planted(&a, 2 + k % 2, 8, (2 + k % 2) * 8, 0.4, (unsigned)k + 1);
    const int m = p.d * p.nc;
    double exact[24], r[24], difference = 0, size = 0;
    dls_solver_settings sweeps = settings_of(DLS_NLGS);
    dls_sensitivity s;
    dls_info info;
    if (solve_auto(&p, 1e-13, exact).status) continue;
    sweeps.limits.tol = 1e-6;
    if (dls_solve(&p, &sweeps, r, NULL, &info, NULL)) continue;
    ck_assert_int_eq(dls_contact_sensitivity(&p, r, &s, NULL), DLS_OK);
    for (int i = 0; i < m; i++) {
      difference += (r[i] - exact[i]) * (r[i] - exact[i]);
      size += exact[i] * exact[i];
    }
    const double share = s.error / sqrt(difference / size);
    if (s.border || !(info.certificate.residual > 1e-9) || !isfinite(share)) continue;
    most = fmax(most, share);
    least = fmin(least, share);
  }
  ck_assert_msg(least > 0.8 && least < 2 && most < 1000, "%g to %g", least, most);
}

/* A large u_t at an r without a tangent: slip in no direction, of which u_n = 0 alone is asked. */
TEST_EACH(sensitivity_of_slip_without_friction_forces, 0, 2) {
  const double W[9] = {1, 0, 0, 0, 1, 0, 0, 0, 1}, q[3] = {-1, 2, 1}, mu[1] = {0.5};
  const double r[3] = {1, 0, 0};
  const int d = 2 + _i;
  const dls_contact p = {.d = d, .nc = 1, .W = {d, d, 3, W}, .q = q, .mu = mu};
  dls_sensitivity s;
  ck_assert_int_eq(dls_contact_sensitivity(&p, r, &s, NULL), DLS_OK);
  ck_assert(s.rows == 1 && s.rank == 1);
  ck_assert(isfinite(s.amplification) && isfinite(s.amplification_r) && isfinite(s.error));
}

TEST(sensitivity_of_nothing_wrong) {
  double W[4] = {4, 0, 0, 1}, q[2] = {-4, -0.25}, mu[1] = {0.5}, r[2] = {1, 0.25};
  const dls_contact p = {.d = 2, .nc = 1, .W = {2, 2, 2, W}, .q = q, .mu = mu};
  dls_sensitivity s = {.rows = -7};
  dls_error e;
  ck_assert_int_eq(dls_contact_sensitivity(NULL, r, &s, &e), DLS_E_ARGUMENT);
  REFUSES(ARGUMENT, "r", -1, dls_contact_sensitivity, &p, NULL, &s);
  ck_assert_int_eq(dls_contact_sensitivity(&p, r, NULL, &e), DLS_E_ARGUMENT);
  r[1] = NAN;
  ck_assert_int_eq(dls_contact_sensitivity(&p, r, &s, &e), DLS_E_NOT_FINITE);
  r[1] = 0.25;
  MALLOCS_FAIL(dls_contact_sensitivity(&p, r, &s, NULL), s.rows == -7, DLS_OK, 5);
}
