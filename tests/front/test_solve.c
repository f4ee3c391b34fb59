/* test_solve.c: dls_solver: every method by the same calls. */
#include "delassus.h"
#include "doors.h"
#include "front_cases.h"
#include "made.h"
#include "run.h"
#include "vi/vi_internal.h"

enum { NC = 12, M = 2 * NC };

static double W[M * M], q[M], mu[NC];

static dls_contact random_problem(unsigned seed) {
  return coupled(W, q, mu, 2, NC, 0.5, 0.3, seed);
}

TEST(methods_have_names) {
  dls_method m = DLS_AUTO;
  ck_assert_str_eq(dls_method_name(DLS_AUTO), "auto");
  ck_assert_str_eq(dls_method_name(DLS_NLGS), "nlgs");
  ck_assert_str_eq(dls_method_name(DLS_LEMKE), "lemke");
  ck_assert_str_eq(dls_method_name(DLS_AUGMENTED_LAGRANGIAN), "augmented-lagrangian");
  ck_assert_str_eq(dls_method_name(DLS_PENALTY), "penalty");
  ck_assert_str_eq(dls_method_name(DLS_NEWTON), "newton");
  ck_assert_ptr_null(dls_method_name((dls_method)99));
  for (int k = 0; dls_method_name((dls_method)k); k++) {
    ck_assert_int_eq(dls_method_find(dls_method_name((dls_method)k), &m), 1);
    ck_assert_int_eq(m, k);
    ck_assert_ptr_nonnull(dls_method_summary((dls_method)k));
  }
  ck_assert_ptr_null(dls_method_summary((dls_method)99));
  ck_assert_int_eq(dls_method_find("lemke", &m), 1);
  ck_assert_int_eq(m, DLS_LEMKE);
  ck_assert_int_eq(dls_method_find("newton-raphson", &m), 0);
  ck_assert_int_eq(dls_method_find(NULL, &m), 0);
  ck_assert_int_eq(m, DLS_LEMKE);
}

enum { BELT = 17 };

/* Sets r (n) to the solution of A r = b by elimination; A, column-major, and b are overwritten. */
static void eliminate(int n, double *A, double *b, double *r) {
  for (int k = 0; k < n; k++)
    for (int i = k + 1; i < n; i++) {
      const double f = A[i + n * k] / A[k + n * k];
      for (int j = k; j < n; j++)
        A[i + n * j] -= f * A[k + n * j];
      b[i] -= f * b[k];
    }
  for (int k = n - 1; k >= 0; k--) {
    r[k] = b[k];
    for (int j = k + 1; j < n; j++)
      r[k] -= A[k + n * j] * r[j];
    r[k] /= A[k + n * k];
  }
}

/* A block on a belt that moves at V, a time step h: q_t = -V, q_n = -g h or so. |q| holds the
 * speed, while the reactions, and their errors, live at g h. All candidates slide: with
 * r_t = mu r_n, the normal reactions solve (W_nn + mu W_nt) r_n = -q_n. */
TEST_EACH(block_on_a_belt, 0, 4) {
  static const double speed[] = {10, 10, 1000, 0.1}, step[] = {1e-5, 1e-7, 1e-5, 1e-3};
  const int n = BELT, m = 2 * BELT;
  double w[4 * BELT * BELT], A[BELT * BELT], b[BELT], exact[BELT], p[2 * BELT], friction[BELT];
  for (int j = 0; j < n; j++)
    for (int i = 0; i < n; i++) {
      const double near = pow(0.6, abs(i - j)), turn = 0.3 * near * (i < j ? 1 : -1) * (i != j);
      w[2 * i + m * 2 * j] = w[2 * i + 1 + m * (2 * j + 1)] = near;
      w[2 * i + m * (2 * j + 1)] = turn;
      w[2 * j + 1 + m * 2 * i] = turn;
      A[i + n * j] = near + 0.3 * turn;
    }
  for (int i = 0; i < n; i++) {
    friction[i] = 0.3;
    b[i] = 9.81 * step[_i] * (1 + 0.2 * sin(i));
    p[2 * i] = -b[i];
    p[2 * i + 1] = -speed[_i];
  }
  eliminate(n, A, b, exact);
  const dls_contact problem = {.d = 2, .nc = n, .W = {m, m, m, w}, .q = p, .mu = friction};
  for (int k = 0; k < method_count(); k++) {
    double r[2 * BELT], worst = 0, largest = 0;
    if (k == DLS_PENALTY) continue;
    dls_solver_settings s = settings_with((dls_method)k, default_tol);
    ck_assert_int_eq(dls_solve(&problem, &s, r, NULL, NULL, NULL), DLS_OK);
    for (int i = 0; i < n; i++) {
      ck_assert(exact[i] > 0);
      worst = fmax(worst, fmax(fabs(r[2 * i] - exact[i]), fabs(r[2 * i + 1] - 0.3 * exact[i])));
      largest = fmax(largest, exact[i]);
    }
    ck_assert_msg(worst <= 1e-6 * largest, "%s: %g", dls_method_name(s.method), worst / largest);
  }
}

/* Every method that reaches 1e-13, so all but the penalty method. */
TEST(methods_agree) {
  const int methods = method_count();
  for (unsigned seed = 1; seed <= 80; seed++) {
    dls_contact p = random_problem(seed);
    p.d = 2 + (int)(seed % 2); /* m = 24 = 2 * 12 = 3 * 8 */
    p.nc = M / p.d;
    double sweeps[M], r[M], u[M];
    dls_solver_settings s = settings_of(DLS_NLGS);
    ck_assert_int_eq(dls_solve(&p, &s, sweeps, NULL, NULL, NULL), DLS_OK);
    double scale = 0;
    for (int i = 0; i < M; i++)
      scale = fmax(scale, fabs(sweeps[i]));
    for (int k = 0; k < methods; k++) {
      dls_info info;
      dls_error e = {0};
      if (k == DLS_PENALTY) continue;
      s = settings_of((dls_method)k);
      const dls_status status = dls_solve(&p, &s, r, u, &info, &e);
      ck_assert_msg(status == DLS_OK, "seed %u: %s %s", seed, dls_status_name(status), e.message);
      ck_assert(info.status == DLS_OK && info.method == s.method &&
                info.iterations + info.sweeps > 0);
      ck_assert(info.certificate.residual <= 1e-13);
      dls_certificate c; /* the one the solver reports is the public one */
      ck_assert_int_eq(dls_contact_certify(&p, r, NULL, &c, NULL), DLS_OK);
      ck_assert_int_eq(same_certificate(&c, &info.certificate), 1);
      assert_near(r, sweeps, M, 1e-11 * scale); /* cond(W) < 10 */
    }
  }
}

TEST(accelerations_have_names) {
  static const char *const names[] = {"none", "aitken", "anderson"};
  const dls_contact p = random_problem(3);
  int sweeps[3] = {0};
  for (int k = 0; k < 3; k++) {
    dls_solver_settings s = settings_of(DLS_NLGS);
    ck_assert_int_eq(dls_acceleration_find(names[k], &s.acceleration), 1);
    double r[M];
    dls_info info;
    ck_assert_int_eq(dls_solve(&p, &s, r, NULL, &info, NULL), DLS_OK);
    sweeps[k] = info.iterations;
  }
  ck_assert_int_lt(sweeps[2], sweeps[0]);
  ck_assert_int_ne(sweeps[1], sweeps[2]);
  dls_acceleration none = DLS_ACCELERATION_NONE;
  ck_assert_int_eq(dls_acceleration_find("Anderson", &none), 0);
  ck_assert_int_eq(dls_acceleration_find(NULL, &none), 0);
  ck_assert_int_eq(dls_acceleration_find("none", NULL), 0);
}

/* The limits of a solver change between two solves; what is wrong is named and changes nothing. */
TEST(limits_change) {
  const dls_contact p = random_problem(1);
  for (dls_method method = DLS_AUTO; dls_method_name(method); method++) {
    dls_solver_settings s = settings_of(method);
    s.limits.tol = 1e-2;
    dls_info coarse, fine;
    dls_error e;
    double r[M];
    dls_solver *solver = solver_of(2, NC, &s);
    ck_assert_int_eq(dls_solver_solve(solver, &p, r, NULL, &coarse, NULL), DLS_OK);
    dls_limits limits = s.limits;
    limits.tol = method == DLS_PENALTY ? 1e-5 : 1e-12;
    ck_assert_int_eq(dls_solver_set_limits(solver, &limits, &e), DLS_OK);
    dls_limits bad = limits;
    bad.tol = -1;
    REFUSES(ARGUMENT, "tol", -1, dls_solver_set_limits, solver, &bad);
    REFUSES(ARGUMENT, "limits", -1, dls_solver_set_limits, solver, NULL);
    ck_assert_int_eq(dls_solver_solve(solver, &p, r, NULL, &fine, NULL), DLS_OK);
    ck_assert(fine.certificate.residual <= limits.tol);
    dls_solver_destroy(solver);
  }
  const dls_limits limits = {.tol = 1e-8};
  REFUSES(ARGUMENT, "solver", -1, dls_solver_set_limits, NULL, &limits);
}

/* W = [8 1 1; 1 8 1; 1 1 8] of normals on each other is dominant and stays so with some friction;
 * [2 1.5 1.5; ..] is definite and not dominant; [1 2; 2 1] is neither, and pressed by (1, 1) has
 * the answers (1, 0), (0, 1) and (1/3, 1/3). */
TEST(one_answer_is_proved) {
  const struct {
    int nc;
    double own, off, mu;
    dls_uniqueness unique;
  } of[] = {{3, 8, 1, 0, DLS_UNIQUE_YES},        {3, 8, 1, .3, DLS_UNIQUE_YES},
            {3, 8, 1, 4, DLS_UNIQUE_UNKNOWN},    {3, 2, 1.5, 0, DLS_UNIQUE_YES},
            {3, 2, 1.5, .3, DLS_UNIQUE_UNKNOWN}, {2, 1, 2, 0, DLS_UNIQUE_UNKNOWN}};
  for (size_t k = 0; k < sizeof of / sizeof of[0]; k++)
    for (int d = 2; d < 4; d++) {
      const int m = d * of[k].nc;
      double A[81] = {0}, load[9] = {0}, friction[3], x[9];
      for (int i = 0; i < m; i++)
        for (int j = 0; j < m; j++) {
          if (i == j) A[i + m * j] = of[k].own;
          if (i % d == 0 && j % d == 0 && i != j) A[i + m * j] = of[k].off;
          if (i % d == 1 && j % d == 0 && i != j + 1) A[i + m * j] = A[j + m * i] = .25;
        }
      for (int c = 0; c < of[k].nc; c++)
        load[d * c] = -1, friction[c] = of[k].mu;
      const dls_contact p = {.d = d, .nc = of[k].nc, .W = {m, m, m, A}, .q = load, .mu = friction};
      dls_solver_settings s = settings_of(DLS_AUTO);
      dls_info info;
      ck_assert_int_eq(dls_solve(&p, &s, x, NULL, &info, NULL), DLS_OK);
      ck_assert_msg(info.unique == of[k].unique, "%zu, d = %d: %d", k, d, (int)info.unique);
    }
}

/* Without friction and W_nn dominant: proved. Beside a pressed candidate, c01 of data/failures as
 * it sticks: the candidate could be free as well. */
TEST(auto_tells_of_other_answers) {
  const double dominant[16] = {2, 0, .5, 0, 0, 2, 0, 0, .5, 0, 2, 0, 0, 0, 0, 2};
  const double pressed[4] = {-1, 0, -1, 0}, none[2] = {0, 0};
  const double several[16] = {2, 0, .1, 0, 0, 2, 0, 0, .1, 0, 1, 1, 0, 0, 1, 2};
  const double load[4] = {-2, 0, .91, 4}, friction[2] = {.5, 2};
  dls_contact p = {.d = 2, .nc = 2, .W = {4, 4, 4, dominant}, .q = pressed, .mu = none};
  dls_solver_settings s = settings_of(DLS_AUTO);
  double r[4];
  dls_info info;
  ck_assert_int_eq(dls_solve(&p, &s, r, NULL, &info, NULL), DLS_OK);
  ck_assert_int_eq(info.unique, DLS_UNIQUE_YES);
  ck_assert_int_eq(info.ambiguous, 0);
  p.W.a = several, p.q = load, p.mu = friction;
  s.limits.warm_start = 1;
  r[0] = .9, r[1] = 0, r[2] = 2, r[3] = -3;
  ck_assert_int_eq(dls_solve(&p, &s, r, NULL, &info, NULL), DLS_OK);
  ck_assert_int_eq(info.ambiguous, 1);
  ck_assert_int_eq(info.unique, DLS_UNIQUE_NO);
  ck_assert_double_eq_tol(r[2], 2, 1e-12);
}

TEST(bad_settings_are_refused) {
  const dls_contact p = random_problem(1);
  double r[M];
  dls_error e;
  dls_solver *solver = (dls_solver *)&e;
  const dls_solver_settings good = settings_of(DLS_NLGS);
  dls_solver_settings s;
  memset(&s, 0, sizeof s);
  ck_assert_int_eq(dls_solver_create(&solver, 2, NC, &s, &e), DLS_E_SETTINGS);
  ck_assert_ptr_null(solver);
  ck_assert_str_eq(e.argument, "settings");
  ck_assert_int_eq(dls_solver_create(&solver, 2, NC, NULL, &e), DLS_OK); /* the defaults */
  dls_solver_destroy(solver);
  solver = NULL;
  REFUSES(ARGUMENT, "out", -1, dls_solver_create, NULL, 2, NC, &good);
  s = good, s.method = (dls_method)42;
  REFUSES(ARGUMENT, "method", -1, dls_solver_create, &solver, 2, NC, &s);
  const double bad[] = {-1e-3, NAN, INFINITY};
  for (int k = 0; k < 3; k++) {
    s = good, s.limits.tol = bad[k];
    REFUSES(ARGUMENT, "tol", -1, dls_solver_create, &solver, 2, NC, &s);
  }
  s = good, s.acceleration = (dls_acceleration)4;
  REFUSES(ARGUMENT, "acceleration", -1, dls_solver_create, &solver, 2, NC, &s);
  s = good, s.method = DLS_LEMKE, s.acceleration = DLS_ACCELERATION_AITKEN;
  REFUSES(ARGUMENT, "acceleration", -1, dls_solver_create, &solver, 2, NC, &s);
  s = good, s.limits.blocks = -1;
  REFUSES(ARGUMENT, "blocks", -1, dls_solver_create, &solver, 2, NC, &s);
  const int hints[] = {-1, 2};
  for (int k = 0; k < 2; k++) {
    s = good, s.positive_definite = hints[k];
    REFUSES(ARGUMENT, "positive_definite", -1, dls_solver_create, &solver, 2, NC, &s);
  }
  s = good, s.limits.max_iterations = -1;
  ck_assert_int_eq(dls_solver_create(&solver, 2, NC, &s, &e), DLS_E_ARGUMENT);
  ck_assert_int_eq(dls_solver_create(&solver, 0, NC, &good, &e), DLS_E_ARGUMENT);
  ck_assert_int_eq(dls_solver_create(&solver, 2, -1, &good, &e), DLS_E_SIZE);
  const int facets[] = {-8, 2, 7, 66};
  for (int k = 0; k < 4; k++) {
    s = settings_of(DLS_LEMKE), s.facets = facets[k];
    REFUSES(ARGUMENT, "facets", -1, dls_solver_create, &solver, 3, NC, &s);
  }
  s = settings_of(DLS_LEMKE);
  REFUSES(SIZE, "nc", -1, dls_solver_create, &solver, 3, 1 << 28, &s);
  ck_assert_ptr_null(solver);
  r[0] = 9;
  ck_assert_int_eq(dls_solve(NULL, &good, r, NULL, NULL, &e), DLS_E_ARGUMENT);
  REFUSES(ARGUMENT, "r", -1, dls_solve, &p, &good, NULL, NULL, NULL);
  ck_assert(r[0] == 9);
}

TEST(every_failing_malloc_unwinds) {
  const int methods = method_count();
  for (int k = 0; k < methods; k++) {
    const dls_contact p = random_problem(2);
    dls_solver_settings s = settings_of((dls_method)k);
    if (k == DLS_PENALTY) s.limits.tol = 1e-4;
    ck_assert_int_ge(fail_in_turn(&p, &s, 1), 1);
    ck_assert_int_ge(fail_in_turn(&p, &s, 0), 2);
  }
}

/* No candidate approaches: r = 0, and its certificate is the one that anybody computes. */
TEST(free_problem_is_answered_at_once) {
  dls_contact p = random_problem(3);
  for (int c = 0; c < NC; c++)
    q[2 * c] = c % 3 ? fabs(q[2 * c]) : 0;
  const dls_solver_settings s = settings_of(DLS_AUTO);
  double r[M], u[M];
  dls_info info;
  dls_certificate c;
  dls_solver *solver = solver_of(2, NC, &s);
  for (int way = 0; way < 2; way++) {
    memset(r, 9, sizeof r);
    memset(&info, 9, sizeof info);
    ck_assert_int_eq(way ? dls_solver_solve(solver, &p, r, u, &info, NULL)
                         : dls_solve(&p, &s, r, u, &info, NULL),
                     DLS_OK);
    ck_assert_int_eq(dls_contact_certify(&p, r, NULL, &c, NULL), DLS_OK);
    ck_assert_int_eq(same_certificate(&c, &info.certificate), 1);
    ck_assert(c.residual == 0 && info.iterations == 0 && info.method == DLS_AUTO);
    for (int i = 0; i < M; i++)
      ck_assert(r[i] == 0 && u[i] == q[i]);
  }
  dls_solver_destroy(solver);
  q[4] = NAN;
  ck_assert_int_eq(dls_solve(&p, &s, r, u, &info, NULL), DLS_E_NOT_FINITE);
}

/* ---- short calls: what is checked in one go -------------------------------------------------- */

enum { FEW = 5 };

/* nc uncoupled candidates, W dense or by blocks */
typedef struct small {
  dls_contact p;
  int start[FEW + 1], row[FEW];
  double W[9 * FEW * FEW], x[9 * FEW], q[3 * FEW], mu[FEW];
} small;

static void set_small(small *a, int d, int nc, int blocks, int pressed) {
  const int m = d * nc;
  memset(a, 0, sizeof *a);
  for (int c = 0; c < nc; c++) {
    for (int i = 0; i < d; i++) {
      a->W[(d * c + i) * (m + 1)] = a->x[d * d * c + i * (d + 1)] = 2 + i;
      a->q[d * c + i] = 0.25 * i + (i ? 0 : pressed && c == nc - 1 ? -1 : 1);
    }
    a->mu[c] = 0.5;
    a->start[c] = a->row[c] = c;
  }
  a->start[nc] = nc;
  a->p = (dls_contact){.d = d, .nc = nc, .q = a->q, .mu = a->mu};
  if (blocks)
    a->p.Wb = (dls_blocks){d, nc, a->start, a->row, a->x};
  else
    a->p.W = (dls_dense){m, m, m, a->W};
}

/* By both doors: the error of dls_contact_check, and nothing written. Returns its status. */
static dls_status fails_alike(const small *a, int d, int nc) {
  const dls_solver_settings s = settings_of(DLS_AUTO);
  dls_error expected;
  const dls_status status = dls_contact_check(&a->p, &expected);
  dls_solver *solver = solver_of(d, nc, &s);
  for (int way = 0; way < 2; way++) {
    double r[3 * FEW], u[3 * FEW], before[3 * FEW];
    dls_info info, info_before;
    dls_error e = {0};
    memset(r, 9, sizeof r);
    memset(u, 9, sizeof u);
    memset(before, 9, sizeof before);
    memset(&info, 9, sizeof info);
    memset(&info_before, 9, sizeof info_before);
    const dls_status got = way ? dls_solver_solve(solver, &a->p, r, u, &info, &e)
                               : dls_solve(&a->p, &s, r, u, &info, &e);
    ck_assert_int_eq(got, status);
    if (!status) continue;
    ck_assert_str_eq(e.argument, expected.argument);
    ck_assert_int_eq(e.index, expected.index);
    ck_assert_mem_eq(r, before, sizeof r);
    ck_assert_mem_eq(u, before, sizeof u);
    ck_assert_mem_eq(&info, &info_before, sizeof info);
  }
  dls_solver_destroy(solver);
  return status;
}

static int count_last(void *data, const dls_progress *progress) {
  ck_assert_str_eq(progress->method, "auto");
  ck_assert(progress->residual >= 0 && progress->residual <= 1e-8);
  ++*(int *)data;
  return 1;
}

/* Where auto needs no iteration, or one sweep, the callback hears of the answer once, and cannot
 * cancel it; with an info or without one. */
TEST(an_answer_at_once_is_told_once) {
  double W1[4] = {2, 0, 0, 1}, mu1 = 0.5, r[2];
  int calls = 0;
  dls_solver_settings s = settings_of(DLS_AUTO);
  s.limits.progress = count_last;
  s.limits.progress_data = &calls;
  for (int way = 0; way < 4; way++) {
    double q1[2] = {way & 1 ? -1 : 1, 0.25};
    const dls_contact p = {.d = 2, .nc = 1, .W = {2, 2, 2, W1}, .q = q1, .mu = &mu1};
    dls_info info;
    ck_assert_int_eq(dls_solve(&p, &s, r, NULL, way & 2 ? &info : NULL, NULL), DLS_OK);
    ck_assert_int_eq(calls, way + 1);
    ck_assert_double_eq_tol(r[0], way & 1 ? 0.5 : 0, 1e-15);
  }
}

TEST(short_calls_see_every_bad_number) {
  const double bad[] = {NAN, INFINITY, -INFINITY};
  for (int way = 0; way < 8; way++)
    for (int nc = 1; nc <= FEW; nc++) {
      const int d = way & 1 ? 3 : 2, blocks = way & 2, pressed = way & 4, m = d * nc;
      small a;
      set_small(&a, d, nc, blocks, pressed);
      ck_assert_int_eq(fails_alike(&a, d, nc), DLS_OK);
      const int count[] = {blocks ? d * m : m * m, m, nc};
      double *const numbers[] = {blocks ? a.x : a.W, a.q, a.mu};
      for (int k = 0; k < 3; k++)
        for (int i = 0; i < count[k]; i++) {
          const double sound = numbers[k][i];
          for (int j = 0; j < 3; j++) {
            if (k == 2 && j == 1) continue; /* an infinite friction is one */
            numbers[k][i] = bad[j];
            ck_assert_int_eq(fails_alike(&a, d, nc), DLS_E_NOT_FINITE);
          }
          numbers[k][i] = sound;
        }
      a.W[0] = a.x[0] = INFINITY, a.q[m - 1] = -INFINITY; /* whose sum is NaN */
      ck_assert_int_eq(fails_alike(&a, d, nc), DLS_E_NOT_FINITE);
      set_small(&a, d, nc, blocks, pressed);
      a.mu[nc - 1] = -1e-300;
      ck_assert_int_eq(fails_alike(&a, d, nc), DLS_E_ARGUMENT);
    }
}

/* A sum of finite numbers overflows: they are no error. */
TEST(short_calls_take_large_numbers) {
  for (int way = 0; way < 4; way++) {
    const int d = way & 1 ? 3 : 2;
    small a;
    set_small(&a, d, 4, way & 2, 0);
    for (int c = 0; c < 4; c++)
      a.q[d * c] = DBL_MAX;
    ck_assert_int_eq(fails_alike(&a, d, 4), DLS_OK);
  }
}

/* 1 if that is a fault of this storage */
static int spoil(small *a, int fault, int blocks) {
  dls_contact *p = &a->p;
  const int d = p->d, nc = p->nc, m = d * nc;
  if (fault == 0) p->d = 1;
  if (fault == 1) p->d = 4;
  if (fault == 2) p->nc = INT32_MAX;
  if (fault == 3) p->nc = -1;
  if (fault == 4) p->q = NULL;
  if (fault == 5) p->mu = NULL;
  if (fault == 6 && blocks) p->W = (dls_dense){m, m, m, a->W};
  if (fault == 6 && !blocks) p->Wb = (dls_blocks){d, nc, a->start, a->row, a->x};
  if (fault == 7) p->W.a = NULL, p->Wb.x = NULL;
  if (fault == 8) p->W.rows--;
  if (fault == 9) p->W.cols++;
  if (fault == 10) p->W.ld--;
  if (fault == 11) p->Wb.d = 5 - d;
  if (fault == 12) p->Wb.n--;
  if (fault == 13) p->Wb.p = NULL;
  if (fault == 14) p->Wb.i = NULL;
  if (fault == 15) a->start[0] = 1;
  if (fault == 16) a->start[2] = nc;
  if (fault == 17) a->row[nc - 1] = nc;
  if (fault == 18) a->row[0] = -1;
  return fault < 8 || (fault > 10) == blocks;
}

TEST(short_calls_see_every_bad_view) {
  enum { faults = 19, nc = 4 };
  for (int way = 0; way < 4; way++)
    for (int fault = 0; fault < faults; fault++) {
      const int d = way & 1 ? 3 : 2, blocks = way >> 1;
      small a;
      set_small(&a, d, nc, blocks, 0);
      const int at_fault = spoil(&a, fault, blocks);
      ck_assert_int_eq(fails_alike(&a, d, nc) != DLS_OK, at_fault);
    }
}

/* Whatever stands behind the rows of a dense W is not looked at, and changes nothing. */
TEST(short_calls_take_a_wider_leading_dimension) {
  for (int pressed = 0; pressed < 2; pressed++) {
    const dls_solver_settings s = settings_of(DLS_AUTO);
    small a;
    double wide[(3 * FEW + 2) * 3 * FEW], r[3 * FEW], t[3 * FEW];
    set_small(&a, 3, FEW, 0, pressed);
    const int m = 3 * FEW, ld = m + 2;
    for (int j = 0; j < m; j++)
      for (int i = 0; i < ld; i++)
        wide[i + ld * j] = i < m ? a.W[i + m * j] : NAN;
    ck_assert_int_eq(dls_solve(&a.p, &s, r, NULL, NULL, NULL), DLS_OK);
    a.p.W = (dls_dense){m, m, ld, wide};
    ck_assert_int_eq(dls_solve(&a.p, &s, t, NULL, NULL, NULL), DLS_OK);
    ck_assert_mem_eq(r, t, sizeof r);
  }
}

/* ---- candidates apart (src/auto/alone.c) ---------------------------------------------------- */

enum { APART = 24 };

/* n candidates by blocks: W_cc = A^T A + I / 2 and no other blocks. */
typedef struct apart {
  dls_contact p;
  int start[APART + 1], row[APART + 1];
  double x[9 * (APART + 1)], b[3 * APART], friction[APART];
} apart;

static void set_apart(apart *a, int d, int n, unsigned seed) {
  for (int c = 0; c < n; c++) {
    double A[9];
    for (int e = 0; e < d * d; e++)
      A[e] = draw(&seed);
    for (int i = 0; i < d; i++)
      for (int j = 0; j < d; j++) {
        double sum = i == j ? 0.5 : 0;
        for (int k = 0; k < d; k++)
          sum += A[k + d * i] * A[k + d * j];
        a->x[d * d * c + i + d * j] = sum;
      }
    for (int i = 0; i < d; i++)
      a->b[d * c + i] = draw(&seed) - (i ? 0 : 0.5);
    a->friction[c] = c % 4 == 3 ? 0 : 0.5;
    a->start[c] = a->row[c] = c;
  }
  a->start[n] = n;
  a->p = (dls_contact){
      .d = d, .nc = n, .Wb = {d, n, a->start, a->row, a->x}, .q = a->b, .mu = a->friction};
}

/* auto's answer is what anybody certifies, the same by both doors. */
static dls_info solve_apart(const dls_contact *p, double tol, double *r) {
  const int m = p->d * p->nc;
  dls_solver_settings s = settings_of(DLS_AUTO);
  double u[3 * APART], t[3 * APART], v[3 * APART];
  dls_info info, other;
  dls_certificate c;
  s.limits.tol = tol;
  memset(&info, 9, sizeof info);
  ck_assert_int_eq(dls_solve(p, &s, r, u, &info, NULL), DLS_OK);
  ck_assert_int_eq(dls_contact_certify(p, r, v, &c, NULL), DLS_OK);
  ck_assert_int_eq(same_certificate(&c, &info.certificate), 1);
  ck_assert_int_eq(dls_certificate_holds(&c, tol), 1);
  for (int i = 0; i < m; i++)
    ck_assert(u[i] == v[i]);
  ck_assert(info.status == DLS_OK && info.method == DLS_AUTO && info.sweeps == 0);
  dls_solver_settings sweeps = settings_of(DLS_NLGS);
  sweeps.limits.tol = tol;
  sweeps.limits.warm_start = 1;
  memcpy(t, r, (size_t)m * sizeof *t);
  ck_assert_int_eq(dls_solve(p, &sweeps, t, NULL, &other, NULL), DLS_OK);
  ck_assert_int_eq(info.ambiguous, other.ambiguous);
  s.limits.blocks = p->Wb.x ? p->Wb.p[p->nc] : 0;
  dls_solver *solver = solver_of(p->d, p->nc, &s);
  ck_assert_int_eq(dls_solver_solve(solver, p, t, NULL, &other, NULL), DLS_OK);
  dls_solver_destroy(solver);
  ck_assert_mem_eq(r, t, (size_t)m * sizeof *r);
  ck_assert(other.iterations == info.iterations && other.stages == info.stages);
  return info;
}

static void is_one_sweep(const dls_info *info) {
  ck_assert(info->iterations == 1 && info->stages == 1 && info->factorisations == 0);
  ck_assert(info->stage[0].method == DLS_NLGS && info->stage[0].iterations == 1 &&
            info->stage[0].factorisations == 0 &&
            info->stage[0].residual == info->certificate.residual);
}

/* To the bits of plain sweeps, which need a second one to see that nothing changes; up to 20
 * candidates without memory. */
TEST(candidates_apart_take_one_sweep) {
  for (unsigned seed = 1; seed <= 60; seed++) {
    apart a;
    const int n = seed % 3 ? 20 : APART;
    set_apart(&a, 2 + (int)(seed % 2), n, seed);
    double r[3 * APART], t[3 * APART];
    const dls_info info = solve_apart(&a.p, 1e-13, r);
    is_one_sweep(&info);
    const dls_solver_settings plain = settings_of(DLS_NLGS), s = settings_of(DLS_AUTO);
    ck_assert_int_eq(dls_solve(&a.p, &plain, t, NULL, NULL, NULL), DLS_OK);
    ck_assert_mem_eq(r, t, (size_t)(a.p.d * n) * sizeof *r);
    malloc_fails_at(0);
    const dls_status status = dls_solve(&a.p, &s, t, NULL, NULL, NULL);
    const long calls = malloc_calls();
    ck_assert(status == DLS_OK && (calls == 0) == (n <= 20));
  }
}

TEST(one_candidate_takes_one_sweep) {
  for (unsigned seed = 1; seed <= 60; seed++) {
    apart a;
    const int d = 2 + (int)(seed % 2);
    set_apart(&a, d, 1, seed);
    a.b[0] = -1;
    const dls_contact dense = {.d = d, .nc = 1, .W = {d, d, d, a.x}, .q = a.b, .mu = a.friction};
    double r[3], t[3];
    const dls_info info = solve_apart(&a.p, 1e-13, r), other = solve_apart(&dense, 1e-13, t);
    is_one_sweep(&info);
    is_one_sweep(&other);
    ck_assert_mem_eq(r, t, (size_t)d * sizeof *r);
    ck_assert_int_ne(dlsi_nlgs_local(d, a.x, a.b, a.friction[0], t, NULL), DLS_LOCAL_NONE);
    ck_assert_mem_eq(r, t, (size_t)d * sizeof *r);
  }
}

TEST(candidates_apart_in_any_units) {
  const double factor[] = {1e-9, 1, 1e9, 1e-160, 1e150};
  for (unsigned seed = 1; seed <= 10; seed++)
    for (int i = 0; i < 5; i++)
      for (int j = 0; j < 3; j++) {
        apart a, b;
        double r[3 * APART], t[3 * APART];
        const double length = factor[i], force = factor[j];
        set_apart(&a, 2 + (int)(seed % 2), 12, seed);
        set_apart(&b, a.p.d, 12, seed);
        for (int e = 0; e < a.p.d * a.p.d * 12; e++)
          b.x[e] *= length / force;
        for (int e = 0; e < a.p.d * 12; e++)
          b.b[e] *= length;
        (void)solve_apart(&a.p, 1e-13, r);
        const dls_info info = solve_apart(&b.p, 1e-13, t);
        is_one_sweep(&info);
        for (int e = 0; e < a.p.d * 12; e++)
          ck_assert_double_eq_tol(t[e] / force, r[e], 1e-11 * (1 + fabs(r[e])));
      }
}

/* Candidate 0 is pressed alone, and by the block W_10 so is 1: that takes more sweeps. Where W_10
 * opens 1 instead, it does not. Where both are pressed from the start they meet. */
TEST(a_neighbour_pressed_takes_more_sweeps) {
  for (int d = 2; d <= 3; d++)
    for (int way = 0; way < 3; way++) {
      apart a;
      double r[6], t[6];
      set_apart(&a, d, 2, 5);
      const int start[3] = {0, 2, 4}, row[4] = {0, 1, 0, 1};
      double x[36] = {0};
      memcpy(x, a.x, (size_t)(d * d) * sizeof *x);
      memcpy(x + 3 * d * d, a.x + d * d, (size_t)(d * d) * sizeof *x);
      x[d * d] = x[2 * d * d] = way == 1 ? 0.3 : -0.3; /* W_nn between them */
      a.p.Wb = (dls_blocks){d, 2, start, row, x};
      a.b[0] = -1;
      a.b[d] = way == 2 ? -1 : 1e-3;
      const dls_info info = solve_apart(&a.p, 1e-13, r);
      const dls_solver_settings plain = settings_of(DLS_NLGS);
      ck_assert_int_eq(dls_solve(&a.p, &plain, t, NULL, NULL, NULL), DLS_OK);
      assert_near(r, t, 2 * d, 1e-11);
      if (way == 1)
        is_one_sweep(&info);
      else
        ck_assert_int_gt(info.iterations, 1);
    }
}

/* r = 0 is the answer exactly where its certificate holds, which is where nothing presses, however
 * little; no stage then. */
TEST(nearly_free_is_answered_by_nothing) {
  int answered = 0, solved = 0;
  for (unsigned seed = 1; seed <= 200; seed++)
    for (double tol = 1e-13; tol < 1; tol *= 10) {
      apart a;
      double r[3 * APART];
      const double none[3 * APART] = {0};
      set_apart(&a, 2 + (int)(seed % 2), 4, seed);
      for (int c = 0; c < 4; c++) {
        double *qn = &a.b[a.p.d * c];
        *qn = (seed % 4 ? *qn : fabs(*qn)) * pow(10, -(double)(seed % 20));
      }
      const dls_info info = solve_apart(&a.p, tol, r);
      const dls_certificate c = certificate_of(&a.p, none);
      ck_assert_int_eq(info.iterations == 0, dls_certificate_holds(&c, tol));
      ck_assert_int_eq(info.stages, info.iterations);
      answered += info.iterations == 0;
      solved += info.iterations == 1;
    }
  ck_assert(answered > 100 && solved > 100);
}

/* Blocks that hold no solution, or whose trace is not positive, are left to the stages. */
TEST(bad_blocks_go_through_the_stages) {
  for (int d = 2; d <= 3; d++) {
    apart a;
    double r[6];
    dls_info info;
    const dls_solver_settings s = settings_of(DLS_AUTO);
    set_apart(&a, d, 2, 7);
    a.b[0] = a.b[d] = -1;
    for (int e = 0; e < d * d; e++)
      a.x[e] = e % (d + 1) ? 0 : e ? 1 : -0.1; /* W_nn r_n = 1, r_n >= 0: no */
    memset(&info, 0, sizeof info);
    ck_assert_int_gt(dls_solve(&a.p, &s, r, NULL, &info, NULL), 0);
    ck_assert_int_gt(info.stages, 1);
    ck_assert_int_eq(dls_certificate_holds(&info.certificate, 1e-13), 0);
    a.x[0] = 0.1;
    for (int i = 1; i < d; i++) {
      a.x[(d + 1) * i] = -0.1 / (d - 1); /* trace 0, yet r = (10, 0, 0) has u = 0 */
      a.b[i] = 0;
    }
    const dls_info odd = solve_apart(&a.p, 1e-13, r);
    ck_assert_int_ge(odd.stages, 1);
    ck_assert_double_eq_tol(r[0], 10, 1e-11);
  }
}

/* ---- auto ------------------------------------------------------------------------------------ */

/* Powers of two change no bit of the mantissas; powers of ten round, which full rank forgives. */
TEST(auto_takes_the_same_stages_in_any_units) {
  static planted_problem a, b;
  const double factor[] = {ldexp(1, -30), 1e-9, 1e9, ldexp(1, 30)};
  for (int k = 0; k < 30; k++) {
    dls_contact p = planted_case(&a, k);
    const int m = p.d * p.nc, full = k % 3 != 0;
    double r[3 * PLANTED], t[3 * PLANTED];
    const dls_info info = solve_auto(&p, 1e-10, r);
    for (int i = 0; i < 4; i++)
      for (int j = 0; j < 4; j++) {
        const int exact = i % 3 == 0 && j % 3 == 0;
        if (!exact && !full) continue;
        for (int e = 0; e < m * m; e++)
          b.W[e] = a.W[e] * (factor[i] / factor[j]);
        for (int e = 0; e < m; e++)
          b.q[e] = a.q[e] * factor[i];
        dls_contact scaled = p;
        scaled.W.a = b.W;
        scaled.q = b.q;
        const dls_info other = solve_auto(&scaled, 1e-10, t);
        same_stages(&info, &other);
        if (!exact) continue;
        ck_assert(other.certificate.residual == info.certificate.residual);
        for (int e = 0; e < m; e++)
          ck_assert(t[e] == r[e] * factor[j]);
      }
  }
}

/* The tangents of every candidate turned by an angle of its own: the same stages. Full rank. */
TEST(auto_does_not_see_frames) {
  static planted_problem a, b;
  for (int k = 0; k < 20; k++) {
    const int nc = 10 + k, m = 3 * nc;
    const dls_contact p = planted(&a, 3, nc, m, 0.5, (unsigned)k + 100);
    double T[3 * PLANTED][2], r[3 * PLANTED], t[3 * PLANTED];
    const dls_info info = solve_auto(&p, 1e-10, r);
    ck_assert_int_eq(info.status, DLS_OK);
    for (int c = 0; c < nc; c++) {
      T[c][0] = cos(c + 0.3);
      T[c][1] = sin(c + 0.3);
    }
    dls_contact turned = p;
    turned.W.a = b.W;
    turned.q = b.q;
    for (int j = 0; j < m; j++) /* columns, then rows: W' = R W R^T */
      for (int i = 0; i < m; i++) {
        const int c = j / 3, o = 3 * c;
        const double x = a.W[i + m * (o + 1)], y = a.W[i + m * (o + 2)];
        b.W[i + m * j] = j % 3 == 0   ? a.W[i + m * j]
                         : j % 3 == 1 ? T[c][0] * x + T[c][1] * y
                                      : -T[c][1] * x + T[c][0] * y;
      }
    memcpy(b.q, a.q, sizeof b.q);
    for (int j = 0; j <= m; j++) {
      double *v = j < m ? b.W + m * j : b.q;
      for (int c = 0; c < nc; c++) {
        const double x = v[3 * c + 1], y = v[3 * c + 2];
        v[3 * c + 1] = T[c][0] * x + T[c][1] * y;
        v[3 * c + 2] = -T[c][1] * x + T[c][0] * y;
      }
    }
    const dls_info other = solve_auto(&turned, 1e-10, t);
    same_stages(&info, &other);
  }
}

/* b := a with candidate c in the place of at[c] */
static dls_contact permuted(const dls_contact *p, const int *at, planted_problem *b) {
  const int d = p->d, m = d * p->nc;
  for (int i = 0; i < m; i++) {
    const int o = d * at[i / d] + i % d;
    b->q[i] = p->q[o];
    b->mu[i / d] = p->mu[at[i / d]];
    for (int j = 0; j < m; j++)
      b->W[i + m * j] = p->W.a[o + m * (d * at[j / d] + j % d)];
  }
  return (dls_contact){.d = d, .nc = p->nc, .W = {m, m, m, b->W}, .q = b->q, .mu = b->mu};
}

/* Candidates in another order, W dense and by blocks: the same stages. Of sweeps alone the same
 * bits; of full rank, the same certificate up to rounding. */
TEST(auto_does_not_see_the_order) {
  static planted_problem a, b;
  static double x[9 * PLANTED * PLANTED];
  int starts[PLANTED + 1], rows[PLANTED * PLANTED], at[PLANTED];
  int several = 0, alike = 0;
  for (int k = 0; k < 60; k++) {
    const int d = 2 + k % 2, nc = 10 + k % 20;
    unsigned seed = (unsigned)k + 1;
    const int rank = k % 5 ? d * nc : d * nc / 2;
    const dls_contact p = planted(&a, d, nc, rank, k % 3 ? 0.5 : 1, seed + 100);
    for (int c = 0; c < nc; c++)
      at[c] = c;
    for (int c = nc - 1; c > 0; c--) {
      const int swap = (int)(0.5 * (draw(&seed) + 1) * c), kept = at[c];
      at[c] = at[swap];
      at[swap] = kept;
    }
    const dls_contact other = permuted(&p, at, &b);
    for (int blocks = 0; blocks < 2; blocks++) {
      dls_info info[2];
      double r[2][3 * PLANTED], size = 0;
      for (int side = 0; side < 2; side++) {
        dls_contact one = side ? other : p;
        dls_blocks B;
        ck_assert_int_eq(dls_blocks_from_dense(&one.W, d, starts, rows, x, &B, NULL), DLS_OK);
        if (blocks) one.Wb = B;
        if (blocks) one.W.a = NULL;
        info[side] = solve_auto(&one, 1e-10, r[side]);
        ck_assert_int_eq(info[side].status, DLS_OK);
      }
      same_stages(&info[0], &info[1]);
      several += info[0].stages > 1;
      alike += info[0].stages == 1;
      if (info[0].stages > 1 && rank < d * nc) continue;
      const dls_certificate *c = &info[0].certificate;
      ck_assert_double_le(fabs(c->residual - info[1].certificate.residual), 4 * c->floor_u);
      for (int i = 0; i < d * nc; i++)
        size = fmax(size, fabs(r[0][i]));
      for (int i = 0; i < d * nc; i++) { /* the smallest eigenvalue of W is above 1e-5 */
        const double rounding = info[0].stages > 1 ? 1e-9 * size : 0;
        ck_assert_double_le(fabs(r[1][i] - r[0][d * at[i / d] + i % d]), rounding);
      }
    }
  }
  ck_assert(several >= 10 && alike >= 10);
}

/* More rows than Newton's method has room for before it knows the storage, and more than auto's
 * Lemke. */
TEST(no_allocation_by_blocks_and_in_larger_problems) {
  enum { nc = 151 };
  static double x[4 * 3 * nc], load[2 * nc], friction[nc], r[2 * nc];
  static int p[nc + 1], i[3 * nc];
  for (int c = 0, k = 0; c < nc; c++) { /* a chain: 2 on the diagonal, -0.9 beside it */
    for (int b = c - 1; b <= c + 1; b++) {
      if (b < 0 || b >= nc) continue;
      const double v = b == c ? 2 : -0.9;
      x[4 * k] = x[4 * k + 3] = v;
      x[4 * k + 1] = x[4 * k + 2] = 0.1 * v;
      i[k++] = b;
    }
    p[c + 1] = k;
    load[2 * c] = c % 5 ? -1 : 1;
    load[2 * c + 1] = sin(c);
    friction[c] = 0.3;
  }
  const dls_contact problem = {.d = 2, .nc = nc, .Wb = {2, nc, p, i, x}, .q = load, .mu = friction};
  static double dense[4 * nc * nc];
  for (int c = 0; c < nc; c++)
    for (int k = p[c]; k < p[c + 1]; k++)
      for (int e = 0; e < 4; e++)
        dense[2 * i[k] + e % 2 + 2 * nc * (2 * c + e / 2)] = x[4 * k + e];
  for (int k = 0; k < method_count(); k++)
    for (int by_blocks = 0; by_blocks < 2; by_blocks++) {
      if (k == DLS_ADMM && by_blocks && !WITH_MUMPS) continue;
      dls_contact one = problem;
      if (!by_blocks) one = (dls_contact){.d = 2, .nc = nc, .q = load, .mu = friction};
      if (!by_blocks) one.W = (dls_dense){2 * nc, 2 * nc, 2 * nc, dense};
      dls_solver_settings s = settings_of((dls_method)k);
      if (k == DLS_PENALTY) s.limits.tol = 1e-4;
      s.limits.blocks = by_blocks ? p[nc] : 0;
      dls_info info;
      dls_solver *solver = solver_of(2, nc, &s);
      malloc_fails_at(0);
      const dls_status status = dls_solver_solve(solver, &one, r, NULL, &info, NULL);
      const long calls = malloc_calls();
      ck_assert_msg(status == DLS_OK && calls == 0, "%s: %d, %ld", dls_method_name((dls_method)k),
                    (int)status, calls);
      if (k == DLS_AUTO) check_report(&info);
      dls_solver_destroy(solver);
    }
}

/* Returns the cost of a report in sweeps, a Newton step being five of them at least
 * (src/auto/auto.c). */
static int cost_of(const dls_info *info) {
  int cost = 0;
  for (int k = 0; k < info->stages; k++)
    cost += (info->stage[k].method == DLS_NLGS ? 1 : 5) * info->stage[k].iterations;
  return cost;
}

/* A warm start helps where it is close, and does no harm where it is nonsense. */
/* The forces of the answer overflow: there is a best r all the same, and it is made of numbers. */
TEST(forces_beyond_numbers) {
  enum { m = 12 };
  static double large_W[m * m], load[m], r[m];
  const double rough[] = {.1, .5, .9, 1.6};
  for (int c = 0; c < m; c++) {
    for (int b = 0; b < m; b++)
      large_W[b + m * c] = (b == c ? 2 : .1 * ((b + c) % 3)) * 1e-160;
    load[c] = c % 3 ? 1e160 : -1.6e308;
  }
  const dls_contact problem = {.d = 3, .nc = 4, .W = {m, m, m, large_W}, .q = load, .mu = rough};
  for (int method = 0; dls_method_name((dls_method)method); method++) {
    dls_solver_settings s = settings_with((dls_method)method, default_tol);
    const dls_status status = dls_solve(&problem, &s, r, NULL, NULL, NULL);
    ck_assert_msg(status != DLS_OK, "%s", dls_method_name(s.method));
    for (int k = 0; k < m && status > 0; k++)
      ck_assert_msg(isfinite(r[k]), "%s: %g", dls_method_name(s.method), r[k]);
  }
}

/* W next to the ends of the range is no error of an argument that nobody has given. */
TEST(entries_at_the_ends_of_the_range) {
  static const double ends[] = {5e-324, 1e-310, 1e-160, 1e160, 1e300, 1.7e308};
  const double rough[] = {.3, .5};
  for (int d = 2; d <= 3; d++)
    for (size_t e = 0; e < sizeof ends / sizeof *ends; e++)
      for (int method = 0; dls_method_name((dls_method)method); method++) {
        const int m = 2 * d;
        double large_W[36] = {0}, load[6], r[6];
        for (int k = 0; k < m; k++) {
          large_W[k + m * k] = ends[e];
          load[k] = k % d ? .3 : -1;
        }
        const dls_contact problem = {
            .d = d, .nc = 2, .W = {m, m, m, large_W}, .q = load, .mu = rough};
        dls_error error = {0};
        dls_solver_settings s = settings_with((dls_method)method, default_tol);
        s.limits.max_iterations = 100;
        const dls_status status = dls_solve(&problem, &s, r, NULL, NULL, &error);
        ck_assert_msg(status >= 0, "%s, %g: %s", dls_method_name(s.method), ends[e], error.message);
        for (int k = 0; k < m; k++)
          ck_assert_msg(isfinite(r[k]), "%s, %g: %g", dls_method_name(s.method), ends[e], r[k]);
      }
}

/* q of 1e300 over blocks of 1e-3 beside the diagonal: what a scaled copy finds is no number in the
 * units of the problem, and is not returned as the best. */
TEST(forces_beyond_the_range_are_not_returned) {
  static const int p[6] = {0, 0, 0, 1, 1, 2}, i[2] = {0, 1};
  static const double x[18] = {26,  1.5,   10,  34.5,  -38.5, 25.5,  -5,  -27.5, -51,
                               -21, -10.5, 1.5, -57.5, 3,     -14.5, -26, -1,    -11};
  static const double load[15] = {47,   24,    44.5, -9, -50.5, 35,    -41, 33,
                                  40.5, -51.5, -28,  20, -3,    -18.5, 26};
  static const double rough[5] = {.98, .31, INFINITY, .99, 1.96};
  double blocks[18], beyond[15], r[15];
  for (int k = 0; k < 18; k++)
    blocks[k] = x[k] / 16000;
  for (int k = 0; k < 15; k++)
    beyond[k] = load[k] * 6.25e298;
  const dls_contact problem = {
      .d = 3, .nc = 5, .Wb = {3, 5, p, i, blocks}, .q = beyond, .mu = rough};
  dls_solver_settings s = settings_with(DLS_AUTO, 1e-3);
  s.limits.max_iterations = 52;
  ck_assert_int_gt(dls_solve(&problem, &s, r, NULL, NULL, NULL), 0);
  for (int k = 0; k < 15; k++)
    ck_assert_msg(isfinite(r[k]), "%d: %g", k, r[k]);
}

TEST(auto_starts_warm) {
  static planted_problem a;
  int cold_cost = 0, warm_cost = 0;
  for (int k = 1; k < 30; k += 3) { /* full rank */
    const dls_contact p = planted_case(&a, k);
    const int m = p.d * p.nc;
    dls_solver_settings s = settings_of(DLS_AUTO);
    double r[3 * PLANTED], t[3 * PLANTED];
    const dls_info cold = solve_auto(&p, s.limits.tol, r);
    dls_info info;
    s.limits.warm_start = 1;
    memcpy(t, r, sizeof t);
    ck_assert_int_eq(dls_solve(&p, &s, t, NULL, &info, NULL), DLS_OK);
    ck_assert_int_eq(info.iterations, 0);
    ck_assert_mem_eq(t, r, (size_t)m * sizeof *t);
    for (int e = 0; e < m; e++)
      t[e] = r[e] * (1 + 1e-6 * (e % 3));
    ck_assert_int_eq(dls_solve(&p, &s, t, NULL, &info, NULL), DLS_OK);
    cold_cost += cost_of(&cold);
    warm_cost += cost_of(&info);
    for (int e = 0; e < m; e++)
      t[e] = e % 2 ? DBL_MAX : -DBL_MAX;
    ck_assert_int_eq(dls_solve(&p, &s, t, NULL, &info, NULL), DLS_OK);
    check_report(&info);
  }
  ck_assert_int_lt(4 * warm_cost, 3 * cold_cost);
}

/* ---- no solution ----------------------------------------------------------------------------- */

/* c03 of data/failures, the wedge that jams: reactions along (1, -1) cost nothing. In 3D, too. */
static const double wedge_W[9] = {1, 1, 0, 1, 1, 0, 0, 0, 1}, wedge_q[3] = {-2, 0, 0}, two[1] = {2};
/* c04, the particle between two walls that come closer: Lemke's method proves it */
static const double squeezed_W[16] = {1, 0, -1, 0, 0, 1, 0, 1, -1, 0, 1, 0, 0, 1, 0, 1};
static const double squeezed_q[4] = {-1, 0, -1, 0}, both[2] = {0.5, 0.5};

TEST(a_jam_has_likely_no_solution) {
  const dls_method which[] = {DLS_AUTO, DLS_AUGMENTED_LAGRANGIAN};
  for (int k = 0; k < 4; k++) {
    const int d = 2 + k / 2;
    const dls_contact p = {.d = d, .nc = 1, .W = {d, d, 3, wedge_W}, .q = wedge_q, .mu = two};
    const double easy[3] = {1, 0, 0};
    dls_contact solvable = p;
    solvable.q = easy;
    const dls_solver_settings s = settings_of(which[k % 2]);
    dls_info info;
    double r[3];
    dls_solver *solver = solver_of(d, 1, &s);
    ck_assert_ptr_null(dls_solver_direction(solver));
    /* the augmented Lagrangian alone has seen too little to say so */
    const dls_status status = k % 2 ? DLS_STALLED : DLS_NO_SOLUTION_LIKELY;
    ck_assert_int_eq(dls_solver_solve(solver, &p, r, NULL, &info, NULL), status);
    ck_assert_int_eq(info.status, status);
    ck_assert(info.certificate.residual > 0.1);
    const double *delta = dls_solver_direction(solver);
    ck_assert_ptr_nonnull(delta);
    double work = 0, largest = 0;
    for (int i = 0; i < d; i++) {
      double sum = 0;
      work += wedge_q[i] * delta[i];
      largest = fmax(largest, fabs(delta[i]));
      for (int j = 0; j < d; j++)
        sum += wedge_W[i + 3 * j] * delta[j];
      ck_assert_double_le(fabs(sum), 2e-4); /* 1e-4 |delta|, weights 1 */
    }
    ck_assert(work < 0);
    ck_assert(largest == 1);
    ck_assert_int_eq(dls_solver_solve(solver, &solvable, r, NULL, NULL, NULL), DLS_OK);
    ck_assert_ptr_null(dls_solver_direction(solver));
    dls_solver_destroy(solver);
  }
  ck_assert_ptr_null(dls_solver_direction(NULL));
}

/* The sweeps of the jam stall at once and forecast nothing: what the solve before forecast does not
 * count. */
TEST(auto_forgets_the_solve_before) {
  static planted_problem a;
  const dls_contact jam = {.d = 2, .nc = 1, .W = {2, 2, 3, wedge_W}, .q = wedge_q, .mu = two};
  const dls_contact before = planted(&a, 2, 40, 41, 1, 7);
  const dls_solver_settings s = settings_of(DLS_AUTO);
  double r[2 * PLANTED];
  const dls_info fresh = solve_auto(&jam, s.limits.tol, r);
  dls_info info;
  dls_solver *solver = solver_of(2, PLANTED, &s);
  ck_assert_int_eq(dls_solver_solve(solver, &before, r, NULL, &info, NULL), DLS_OK);
  ck_assert(info.stages > 1);
  ck_assert_int_ge(dls_solver_solve(solver, &jam, r, NULL, &info, NULL), 0);
  same_stages(&fresh, &info);
  dls_solver_destroy(solver);
}

TEST(auto_proves_that_there_is_no_solution) {
  const dls_contact p = {.d = 2, .nc = 2, .W = {4, 4, 4, squeezed_W}, .q = squeezed_q, .mu = both};
  double r[4];
  const dls_info info = solve_auto(&p, 1e-8, r);
  ck_assert_int_eq(info.status, DLS_NO_SOLUTION);
  ck_assert_int_eq(info.stage[info.stages - 1].method, DLS_LEMKE);
}

/* A time limit ends auto in whichever stage it falls, a little later than it says, with the best
 * answer so far; the last call tells of it. */
static int note_last(void *data, const dls_progress *progress) {
  if (progress->last) *(dls_progress *)data = *progress;
  return 0;
}

TEST(time_limit_in_any_stage) {
  enum { nc = 8, m = 2 * nc };
  double A[m * m], b[m], friction[nc], r[m];
  dls_contact p = coupled(A, b, friction, 2, nc, 0, 9, 77);
  for (int c = 0; c < nc; c++) { /* one candidate jams, by itself */
    friction[c] = 9;
    for (int k = 0; k < m; k++)
      if (c == 7) A[14 + m * k] = A[k + m * 14] = A[15 + m * k] = A[k + m * 15] = 0;
  }
  A[14 + m * 14] = A[14 + m * 15] = A[15 + m * 14] = A[15 + m * 15] = 1; /* above its critical mu */
  friction[7] = 2;
  b[14] = -2;
  b[15] = 0;
  dls_solver_settings s = settings_of(DLS_AUTO);
  dls_progress last = {0};
  dls_info info;
  s.limits.progress = note_last;
  s.limits.progress_data = &last;
  const dls_status whole = dls_solve(&p, &s, r, NULL, &info, NULL);
  ck_assert_msg(whole == DLS_NO_SOLUTION_LIKELY || whole == DLS_NO_SOLUTION || whole == DLS_STALLED,
                "%s", dls_status_name(whole));
  const double all = last.cpu_seconds;
  for (int k = 1; k < 20; k++) {
    s.limits.cpu_seconds = all * k / 20;
    last.cpu_seconds = -1;
    const dls_status status = dls_solve(&p, &s, r, NULL, &info, NULL);
    ck_assert_msg(status == DLS_TIME_LIMIT || status == whole, "%d: %s", k,
                  dls_status_name(status));
    ck_assert(last.cpu_seconds >= 0 && last.residual == info.certificate.residual);
    if (status == DLS_TIME_LIMIT)
      ck_assert_msg(last.cpu_seconds >= s.limits.cpu_seconds &&
                        last.cpu_seconds <= s.limits.cpu_seconds + 0.3 * all + 0.02,
                    "%d: %g of %g, %g", k, last.cpu_seconds, s.limits.cpu_seconds, all);
  }
}

/* Two candidates in 3D, the first one sliding fast: most stages end near the planted answer and
 * not at it, so that "no solution likely" would be false for any tolerance. */
TEST(a_near_answer_is_not_denied) {
  static const double A[36] = {
      66.50493729458866,   22.1576632898001,    -8.618633243360543,  -734.8527793596492,
      151.49156420836556,  -127.14039510512083, 22.1576632898001,    81.87171988377476,
      -18.74760229068303,  -226.9717017296989,  409.3260061688352,   -114.05904387611272,
      -8.618633243360543,  -18.74760229068303,  11.118910854842728,  -31.653935613585467,
      -317.418252060653,   263.31618817050776,  -734.8527793596492,  -226.9717017296989,
      -31.653935613585467, 10457.330606703646,  2822.0684300385637,  -3130.368767867036,
      151.49156420836556,  409.3260061688352,   -317.418252060653,   2822.0684300385637,
      11429.235504849683,  -9784.445722882712,  -127.14039510512083, -114.05904387611272,
      263.31618817050776,  -3130.368767867036,  -9784.445722882712,  9425.498537102076};
  const double b[6] = {2367.666989248906,   -1368497.6105288682, -3402851.8343295422,
                       -54897.549669179985, -31354.344341863558, 47796.612774205554};
  const double friction[2] = {7.514502922937276, 7.514502922937276};
  const double answer[6] = {2.860233982524332, 8.03953124879171,    19.93301677587765,
                            3.840469684764513, -14.256544488960373, -19.015966628367135};
  const dls_contact p = {.d = 3, .nc = 2, .W = {6, 6, 6, A}, .q = b, .mu = friction};
  double u[6], r[6];
  dls_certificate c;
  ck_assert_int_eq(dls_contact_certify(&p, answer, u, &c, NULL), DLS_OK);
  ck_assert(dls_certificate_holds(&c, 1e-8));
  const dls_info info = solve_auto(&p, 1e-8, r);
  ck_assert_int_eq(info.status, DLS_OK);
  ck_assert_int_eq(solve_auto(&p, 1e-12, r).status, DLS_OK);
}
