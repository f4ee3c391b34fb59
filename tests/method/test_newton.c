/* test_newton.c: nonsmooth Newton, on problems solved by hand, on random ones, on bad input. */
#include "cases.h"
#include "delassus/newton.h"
#include "doors.h"
#include "failures.h"
#include "made.h"
#include "run.h"
#include "vi/vi_internal.h"

/* ---- by hand --------------------------------------------------------------------------------- */

/* The step alone goes round on these; line and sweeps: what it answers with either. */
static const struct {
  const char *name;
  dls_status alone, line, sweeps;
} cycles[] = {{"C6", DLS_STALLED, DLS_OK, DLS_OK},
              {"C7", DLS_STALLED, DLS_STALLED, DLS_OK},
              {"C7 in 3D", DLS_STALLED, DLS_STALLED, DLS_OK},
              {"C13", DLS_STALLED, DLS_OK, DLS_STALLED},
              {"C14", DLS_STALLED, DLS_STALLED, DLS_OK}};

TEST_EACH(cycle, 0, sizeof cycles / sizeof cycles[0]) {
  static model a;
  const hand_case *k = hand_named(cycles[_i].name);
  set_hand(&a, k);
  for (int way = 0; way < 3; way++) {
    dls_newton_settings s = newton_tol(1e-12);
    s.regularization = 0;
    s.sweeps = way == 2 ? 20 : 0;
    s.line_search = way == 1;
    double r[4], u[4];
    dls_info info;
    const dls_status status = run_newton(&a.p, &s, r, u, &info);
    const dls_status expected[] = {cycles[_i].alone, cycles[_i].line, cycles[_i].sweeps};
    ck_assert_msg(status == expected[way], "%s, way %d: %d", k->name, way, status);
    ck_assert(info.certificate.residual <= 1 + 1e-15); /* of r = 0 */
    if (status == DLS_STALLED) ck_assert_int_ge(info.iterations, 12);
    for (int i = 0; status == DLS_OK && i < k->d * k->nc; i++)
      ck_assert(fabs(r[i] - k->r[i]) <= 1e-10);
  }
}

TEST_EACH(no_solution_in_any_way, 0, jammed_count) {
  static model a;
  set_hand(&a, &jammed[_i]);
  for (int way = 0; way < 4; way++) {
    dls_newton_settings s = newton_tol(1e-8);
    s.line_search = way & 1;
    if (way & 2) s.sweeps = 0, s.regularization = 0;
    expect_no_answer(&the_newton, &a.p, &s);
  }
}

TEST(hyperstatic_without_sweeps) {
  static model a;
  set_hand(&a, &hyperstatic_case);
  for (int way = 0; way < 2; way++) {
    dls_newton_settings s = newton_tol(1e-13);
    s.sweeps = 0;
    if (way) s.regularization = 0; /* the matrix is singular: eps comes by itself */
    double r[4], u[4];
    dls_info info;
    ck_assert_int_eq(run_newton(&a.p, &s, r, u, &info), DLS_OK);
    ck_assert(info.iterations >= 1);
    ck_assert(fabs(r[0] + r[2] - 1) <= 1e-12 && fabs(r[1] + r[3] + .25) <= 1e-12);
  }
}

/* Without friction and with everything in contact: W_nn r_n = -q_n. With mu = 0 a candidate has one
 * unknown, and the tangential rows are not looked at. */
TEST(without_friction) {
  static model a;
  const hand_case k = {
      "", 2, 2, {2, 5, 1, 0, 5, 0, 0, 7, 1, 0, 2, 3, 0, 7, 3, 0}, {-3, 4, -3, 1}, 0, {1, 0, 1, 0}};
  set_hand(&a, &k);
  dls_newton_settings s = newton_tol(1e-14);
  s.sweeps = 0;
  s.regularization = 0;
  s.limits.warm_start = 1;
  double r[4] = {.5, 3, .5, -2}, u[4];
  dls_info info;
  ck_assert_int_eq(run_newton(&a.p, &s, r, u, &info), DLS_OK);
  assert_near(r, k.r, 4, 1e-14);
}

/* Any start: what comes back is never worse than it. */
TEST_EACH(never_worse_in_any_way, 0, 30) {
  static model a;
  const hand_case *k = hand_named("C14");
  set_hand(&a, k);
  set_seed(362436069 + (uint64_t)_i);
  dls_newton_settings s = newton_tol(1e-14);
  s.limits.warm_start = 1;
  s.sweeps = _i % 3;
  s.line_search = _i % 2;
  double r[4], u[4];
  for (int i = 0; i < 4; i++)
    r[i] = k->r[i] * (1 + 0.5 * uniform());
  const dls_certificate before = certificate_of(&a.p, r);
  dls_info info;
  (void)run_newton(&a.p, &s, r, u, &info);
  ck_assert(info.certificate.residual <= before.residual);
}

/* data/failures: "solved" only where there is a solution, and then with the certificate (run).
 * Which ones it solves: those whose line says so. */
TEST(catalogue) {
  int contacts, solved = 0;
  const failure *f = contact_failures(&contacts);
  for (const failure *end = f + contacts; f < end; f++) {
    const dls_contact p = failure_contact(f);
    const dls_newton_settings s = newton_tol(1e-12);
    double r[FAILURE_N];
    dls_info info;
    const dls_status status = run_newton(&p, &s, r, NULL, &info);
    ck_assert_msg(!(f->none && status == DLS_OK), "%s", f->name);
    ck_assert_msg((status == DLS_OK) == failure_says(f, "newton", DLS_OK), "%s", f->name);
    solved += status == DLS_OK;
  }
  ck_assert_msg(contacts >= 33 && solved >= 22, "%d, %d", contacts, solved);
}

/* in the sweeps, then in the steps */
typedef struct both {
  double least;
  int sweeps, steps, cancel_at;
} both;

static int look_at_both(void *data, const dls_progress *progress) {
  both *w = data;
  if (progress->last) return 0;
  const int step = strcmp(progress->stage, "newton") == 0;
  ck_assert_str_eq(progress->method, "newton");
  if (step)
    ck_assert_int_eq(progress->iteration, ++w->steps);
  else {
    ck_assert_str_eq(progress->stage, "nlgs");
    ck_assert_int_eq(progress->iteration, ++w->sweeps);
  }
  if (progress->residual < w->least) w->least = progress->residual;
  return w->sweeps + w->steps == w->cancel_at;
}

TEST_EACH(cancelled, 0, 4) { /* in the sweeps, in the steps, never */
  static model a;
  set_hand(&a, hand_named("C13"));
  static const int at[] = {7, 20, 25, 0}, sweeps[] = {7, 20, 20, 20}, steps[] = {0, 0, 5, 3};
  static const dls_status status[] = {DLS_CANCELLED, DLS_CANCELLED, DLS_CANCELLED,
                                      DLS_MAX_ITERATIONS};
  dls_newton_settings s = newton_tol(1e-8);
  both w = {INFINITY, 0, 0, at[_i]};
  s.limits.progress = look_at_both;
  s.limits.progress_data = &w;
  if (!at[_i]) s.limits.max_iterations = 3;
  double r[4], u[4];
  dls_info info;
  ck_assert_int_eq(run_newton(&a.p, &s, r, u, &info), status[_i]);
  ck_assert_int_eq(info.sweeps, sweeps[_i]);
  ck_assert_int_eq(info.iterations, steps[_i]);
  ck_assert(w.sweeps == sweeps[_i] && w.steps == steps[_i]);
  ck_assert(info.certificate.residual <= w.least * (1 + 1e-12)); /* the best of them all */
}

/* Told that W is positive definite, a stage of auto takes no eps: one step from r = 0, where both
 * press, is the answer of W r = -q. */
TEST(definite_needs_no_eps) {
  static model a;
  double r[2] = {0};
  void *work;
  dls_info info;
  set_model(&a, 1, 2);
  a.W[0] = a.W[3] = 2;
  a.W[1] = a.W[2] = 1;
  a.q[0] = a.q[1] = -3;
  const dlsi_options options = {
      .limits = {.tol = 0, .max_iterations = 1}, .positive_definite = 1, .stage = 1};
  ck_assert_int_eq(dlsi_newton_method.create(&work, 1, 2, &options, NULL), DLS_OK);
  ck_assert_int_eq(dlsi_newton_method.solve(work, &a.p, r, NULL, &info, NULL), DLS_OK);
  ck_assert(info.iterations == 1 && info.factorisations == 1 && info.sweeps == 0);
  assert_near(r, (double[]){1, 1}, 2, 1e-15);
  dlsi_newton_method.destroy(work);
}

/* ---- random ---------------------------------------------------------------------------------- */

TEST_EACH(line_search_without_sweeps, 0, 40) {
  dls_newton_settings s = newton_tol(1e-12);
  s.sweeps = 0;
  s.line_search = 1;
  expect_same_answer(&the_newton, _i, &s);
}

/* ---- the line search ------------------------------------------------------------------------- */

/* |AC| of newton.c for one candidate in 2D, from r and u */
static double law_error(double w, double mu, const double *r, const double *u) {
  const double x = w * r[0] - u[0], R = x > 0 ? mu * x : 0, tau = w * r[1] - u[1];
  const double held = fmax(-R, fmin(R, tau));
  return hypot(w * r[0] - fmax(0, x), w * r[1] - held);
}

static void velocity(const model *a, const double *r, double *u) {
  for (int i = 0; i < 2; i++)
    u[i] = a->W[i] * r[0] + a->W[i + 2] * r[1] + a->q[i];
}

/* to := the full step (N1)-(N3) from r; 0 where its matrix is singular */
static int full_step(const model *a, double w, const double *r, double *to) {
  const double *W = a->W, mu = a->mu[0];
  double u[2];
  velocity(a, r, u);
  const double x = w * r[0] - u[0], R = mu * fmax(0, x), tau = w * r[1] - u[1];
  if (x <= 0) {
    to[0] = to[1] = 0;
    return 1;
  }
  if (fabs(tau) <= R) {
    const double det = W[0] * W[3] - W[1] * W[2];
    to[0] = r[0] - (W[3] * u[0] - W[2] * u[1]) / det;
    to[1] = r[1] - (W[0] * u[1] - W[1] * u[0]) / det;
    return fabs(det) > 1e-9;
  }
  const double t = tau > 0 ? 1 : -1, k = (mu * u[0] + R) / w - t * r[1];
  const double slope = W[0] + mu * t * W[2], b = -(u[0] + W[2] * k * t) / slope;
  to[0] = r[0] + b;
  to[1] = r[1] + k * t + mu * t * b;
  return fabs(slope) > 1e-9;
}

typedef struct residual_list {
  int steps;
  double of[30];
} residual_list;

static int list_residual(void *data, const dls_progress *progress) {
  residual_list *to = data;
  if (!progress->last) to->of[to->steps++] = progress->residual;
  return 0;
}

/* (N4) done by hand: step by step the residuals that the method reports. u of a trial is the mean
 * of the two u it lies between. */
TEST(line_search_by_hand) {
  int halvings = 0, compared = 0;
  for (int number = 0; number < 400; number++) {
    static model a;
    set_seed(362436069 + (uint64_t)number);
    random_model(&a, 2, 1, 2);
    a.W[1] = a.W[2] = 0.95 * copysign(sqrt(a.W[0] * a.W[3]), a.q[1]);
    const double w = (a.W[0] + a.W[3]) / 2;
    dls_newton_settings s = newton_tol(1e-12);
    residual_list seen = {0};
    s.sweeps = 0;
    s.regularization = 0;
    s.line_search = 1;
    s.limits.warm_start = 1;
    s.limits.max_iterations = 6;
    s.limits.progress = list_residual;
    s.limits.progress_data = &seen;
    double r[2] = {1 + uniform(), 3 * uniform()}, answer[2] = {r[0], r[1]}, u[2];
    dls_info info;
    (void)run_newton(&a.p, &s, answer, NULL, &info);
    velocity(&a, r, u);
    double last[5] = {law_error(w, a.mu[0], r, u)};
    for (int k = 0; k < seen.steps; k++) {
      double next[2], v[2], bound = 0;
      if (!full_step(&a, w, r, next)) break;
      for (int e = 0; e < 5; e++)
        bound = fmax(bound, last[e]);
      for (int trial = 0; trial <= 6; trial++) {
        velocity(&a, next, v);
        last[(k + 1) % 5] = law_error(w, a.mu[0], next, v);
        if (last[(k + 1) % 5] < bound || trial == 6) break;
        halvings++;
        for (int i = 0; i < 2; i++)
          next[i] = 0.5 * (r[i] + next[i]);
      }
      memcpy(r, next, sizeof r);
      const dls_certificate c = certificate_of(&a.p, r);
      if (c.residual < 1e-9) break;
      ck_assert_msg(fabs(c.residual - seen.of[k]) <= 1e-6 * c.residual, "%d, step %d: %g, not %g",
                    number, k + 1, seen.of[k], c.residual);
      compared++;
    }
  }
  ck_assert_msg(halvings >= 50 && compared >= 200, "%d, %d", halvings, compared);
}

/* ---- the head of the matrix ------------------------------------------------------------------ */

enum { bed_nc = 60, bed_m = 3 * bed_nc };

/* Candidates in a row on an elastic bed, W the coupling exp(-|a - b| / 4) of blocks that are
 * positive definite, pressed by a hump and pushed; unsymmetric: by one bit. */
static dls_contact bed(int d, double mu_of_all, double push, int unsymmetric) {
  static const double block[] = {1, 0.2, 0.1, 0.2, 0.8, -0.1, 0.1, -0.1, 0.9};
  static double W[bed_m * bed_m], q[bed_m], mu[bed_nc];
  const int m = d * bed_nc;
  for (int b = 0; b < bed_nc; b++) {
    const double x = (b - 0.4 * bed_nc) / bed_nc;
    mu[b] = b % 7 == 3 ? 0 : mu_of_all;
    for (int j = 0; j < d; j++) {
      q[d * b + j] = j == 0 ? 8 * x * x - 1 : push * (j == 1 ? 1 + x : sin(9 * x));
      for (int a = 0; a < bed_nc; a++)
        for (int i = 0; i < d; i++)
          W[d * a + i + m * (d * b + j)] = exp(-abs(a - b) / 4.) * block[3 * j + i];
    }
    double *w = &W[d * b + 1 + m * d * b];
    if (unsymmetric) *w = nextafter(*w, 1);
  }
  return (dls_contact){.d = d, .nc = bed_nc, .W = {m, m, m, W}, .q = q, .mu = mu};
}

/* One bit in each block makes W unsymmetric and the method take LU of all: step by step the same
 * residuals. */
TEST_EACH(head_is_lu, 0, 2) {
  const int d = 2 + _i;
  const double mu[] = {0.2, 0.5, 1, 2};
  int most_steps = 0;
  for (int k = 0; k < 4; k++)
    for (int l = 0; l < 4; l++) {
      residual_list seen[2] = {{0}, {0}};
      double r[2][bed_m];
      for (int way = 0; way < 2; way++) {
        const dls_contact p = bed(d, mu[k], 0.1 + 0.1 * l, way);
        dls_newton_settings s = newton_tol(1e-12);
        s.sweeps = 0;
        s.limits.progress = list_residual;
        s.limits.progress_data = &seen[way];
        dls_newton *work;
        dls_info info;
        ck_assert_int_eq(dls_newton_create(&work, p.d, p.nc, &s, NULL), DLS_OK);
        ck_assert_int_eq(dls_newton_solve(work, &p, r[way], NULL, &info, NULL), DLS_OK);
        dls_newton_destroy(work);
      }
      ck_assert_int_eq(seen[0].steps, seen[1].steps);
      for (int i = 0; i < seen[0].steps; i++)
        ck_assert(fabs(seen[0].of[i] - seen[1].of[i]) <= 1e-9 * seen[1].of[i] + 1e-14);
      for (int i = 0; i < d * bed_nc; i++)
        ck_assert(fabs(r[0][i] - r[1][i]) <= 1e-10);
      if (seen[0].steps > most_steps) most_steps = seen[0].steps;
    }
  ck_assert_int_ge(most_steps, 5);
}

/* ---- large: the matrices beyond 250 unknowns ------------------------------------------------- */

enum { grid = 52, grid_nc = grid * grid, grid_m = 2 * grid_nc };

static dls_newton *large_workspace(double tol, int sweeps, int blocks) {
  dls_newton_settings s = newton_tol(tol);
  dls_newton *work;
  s.sweeps = sweeps;
  s.limits.blocks = blocks;
  ck_assert_int_eq(dls_newton_create(&work, 2, row_nc, &s, NULL), DLS_OK);
  return work;
}

/* unknowns of the step at r, d = 2: one of each slipping, two of each sticking candidate */
static int unknowns_at(const dls_contact *problem, const double *r) {
  static double u[grid_m];
  static dls_contact_state state[grid_nc];
  dls_certificate c;
  ck_assert_int_le(problem->nc, grid_nc);
  ck_assert_int_eq(dls_contact_certify(problem, r, u, &c, NULL), DLS_OK);
  ck_assert_int_eq(dls_contact_states(problem, r, u, state, NULL), DLS_OK);
  int unknowns = 0;
  for (int b = 0; b < problem->nc; b++)
    unknowns += (int)state[b];
  return unknowns;
}

TEST_EACH(sparse_is_dense, 0, 2) {
  dls_contact dense, blocks;
  double r[row_m];
  dls_info info[2];
  dls_newton *work = large_workspace(1e-12, !_i, 0);
  expect_sparse_is_dense(&the_newton, work, _i, 1e-10, r, info); /* |W^-1| < 10; |q| < 13 */
  ck_assert_int_ge(info[0].iterations, 1);
  ck_assert_int_eq(info[1].iterations, info[0].iterations);
  row_problem(_i, &dense, &blocks);
  ck_assert_int_gt(unknowns_at(&dense, r), 250); /* more than create has room for */
  dls_newton_destroy(work);
}

/* The sparse LU is the same each time, in any workspace. Left to choose (ICNTL(7) = 7) MUMPS takes
 * an ordering that draws random numbers for these unknowns, though not for 1800. A grid of
 * candidates, each coupled to four neighbours, nearly all of them sticking. */
TEST(sparse_same_bits) {
  if (!WITH_MUMPS) return;
  static double x[5 * grid_nc * 4], q[grid_m], mu[grid_nc], r[3][grid_m];
  static int p[grid_nc + 1], i[5 * grid_nc];
  static const int away[] = {-grid, -1, 0, 1, grid};
  set_seed(88172645463325252u);
  int count = 0;
  for (int b = 0; b < grid_nc; b++) {
    p[b] = count;
    for (int k = 0; k < 5; k++) {
      const int a = b + away[k];
      if (a < 0 || a >= grid_nc || (k % 2 && a / grid != b / grid)) continue;
      for (int e = 0; e < 4; e++)
        x[4 * count + e] = a == b ? e % 3 == 0 : 0.1 * uniform();
      i[count++] = a;
    }
    q[2 * b] = -1 + 0.2 * uniform();
    q[2 * b + 1] = 0.2 * uniform();
    mu[b] = 0.5;
  }
  p[grid_nc] = count;
  const dls_contact problem = {
      .d = 2, .nc = grid_nc, .Wb = {2, grid_nc, p, i, x}, .q = q, .mu = mu};
  dls_newton_settings s = newton_tol(1e-12);
  s.sweeps = 1;
  s.limits.blocks = count;
  dls_newton *work[2];
  dls_info info[3];
  for (int k = 0; k < 2; k++)
    ck_assert_int_eq(dls_newton_create(&work[k], 2, grid_nc, &s, NULL), DLS_OK);
  for (int turn = 0; turn < 3; turn++) {
    ck_assert_int_eq(dls_newton_solve(work[turn / 2], &problem, r[turn], NULL, &info[turn], NULL),
                     DLS_OK);
    ck_assert_int_eq(info[turn].iterations, info[0].iterations);
    ck_assert_mem_eq(r[turn], r[0], sizeof r[0]);
  }
  ck_assert_int_gt(unknowns_at(&problem, r[0]), 5000);
  for (int k = 0; k < 2; k++)
    dls_newton_destroy(work[k]);
}

/* Solves a storage that create was not told of: dense, then by blocks. Outputs untouched without
 * memory, and the
 * workspace as good as new. */
TEST_EACH(no_memory_for_large, 0, 2) {
  dls_contact dense, blocks;
  row_problem(0, &dense, &blocks);
  if (!WITH_MUMPS) return; /* dense, both */
  dls_newton *work = large_workspace(1e-8, 1, _i ? blocks.Wb.p[row_nc] : 0);
  const dls_contact *p = _i ? &dense : &blocks;
  double r[row_m];
  expect_solve_unwinds(&the_newton, work, p, r);
  expect_no_allocation(&the_newton, work, p, r); /* the room is kept, for either */
  expect_no_allocation(&the_newton, work, _i ? &blocks : &dense, r);
  dls_newton_destroy(work);
}

/* One matrix, m^2 or the sparse one of the blocks, and O(m); a solve of what was announced
 * allocates nothing. */
TEST(memory) {
  dls_contact p[2];
  row_problem(0, &p[0], &p[1]);
  const double m = row_m;
  const int full = row_nc * row_nc / 4; /* from there on dense */
  const int told[] = {0, p[1].Wb.p[row_nc], 0, full - 1, full, full};
  for (int way = 0; way < 6; way++) {
    dls_newton_settings s = newton_tol(1e-10);
    s.limits.blocks = told[way];
    s.sweeps = way & 2 ? 20 : 0;
    const int sparse = s.limits.blocks && s.limits.blocks < full && WITH_MUMPS;
    const double entries = 4. * s.limits.blocks + m;
    const double matrix =
        sparse ? 8 * (250. * 250 + 2 * entries) + 3 * entries * sizeof(int) : 8 * m * m;
    expect_memory(&the_newton, 2, row_nc, &s, matrix, 8 * 60 * m + 16384);
    dls_newton *work;
    ck_assert_int_eq(dls_newton_create(&work, 2, row_nc, &s, NULL), DLS_OK);
    double r[row_m];
    expect_no_allocation(&the_newton, work, &p[way & 1], r);
    dls_newton_destroy(work);
  }
}

/* ---- bad input ------------------------------------------------------------------------------- */

TEST(bad_create) {
  expect_bad_create(&the_newton);
  const double bad_eps[] = {-1e-9, 1, NAN, INFINITY};
  for (int k = 0; k < 4; k++) {
    dls_newton_settings s = newton_tol(1e-8);
    s.regularization = bad_eps[k];
    refuses_to_create(&the_newton, DLS_E_ARGUMENT, "regularization", -1, 2, 1, &s);
  }
  dls_newton_settings s = newton_tol(1e-8);
  s.sweeps = -1;
  refuses_to_create(&the_newton, DLS_E_ARGUMENT, "sweeps", -1, 2, 1, &s);
  s = newton_tol(1e-8);
  s.line_search = 2;
  refuses_to_create(&the_newton, DLS_E_ARGUMENT, "line_search", -1, 2, 1, &s);
  s = newton_tol(1e-8);
  refuses_to_create(&the_newton, DLS_E_SIZE, "nc", -1, 3, INT_MAX / 3, &s); /* m^2 doubles */
}
