/* test_global.c: the contact problem on K itself: answers by hand, laws checked by plain loops,
 * proofs that there is none, agreement with W, units, storage, errors. */
#include "delassus.h"
#include "reduced.h"
#include "run.h"
#include "solids.h"
#include "stiffness.h"

/* ---- helpers --------------------------------------------------------------------------------- */

typedef struct answer {
  dls_status status;
  int n, m;
  double *r, *x, *mu;
  dls_info info;
  dls_global *global;
} answer;

static void answer_free(answer *A) {
  dls_global_destroy(A->global);
  free(A->r);
  free(A->x);
  free(A->mu);
}

/* Solves with the same friction everywhere. */
static answer answer_of(const dls_model *model, const double *f, const double *g, double mu,
                        double tol) {
  answer A = {.n = model->n};
  dls_error e = {0};
  const dls_limits limits = {.tol = tol};
  ck_assert_msg(!dls_global_create(&A.global, model, &e), "%s", e.message);
  const int nc = dls_global_contacts(A.global);
  A.m = model->d * nc;
  A.r = calloc((size_t)A.m + 1, sizeof *A.r);
  A.x = calloc((size_t)A.n, sizeof *A.x);
  A.mu = calloc((size_t)nc + 1, sizeof *A.mu);
  for (int c = 0; c < nc; c++)
    A.mu[c] = mu;
  A.status = dls_global_solve(A.global, f, g, A.mu, &limits, A.r, A.x, &A.info, &e);
  ck_assert_msg(A.status >= 0, "%s", e.message);
  ck_assert_int_eq(A.status, A.info.status);
  return A;
}

/* y := A x, or A^T x; A is symmetric and only its lower triangle counts where `half`. */
static void stress_multiply(const dls_sparse *A, int transposed, int half, const double *x,
                            double *y) {
  memset(y, 0, (size_t)(transposed ? A->cols : A->rows) * sizeof *y);
  for (int j = 0; j < A->cols; j++)
    for (int k = A->p[j]; k < A->p[j + 1]; k++) {
      if (half && A->i[k] < j) continue;
      if (!transposed || half) y[A->i[k]] += A->x[k] * x[j];
      if (transposed || (half && A->i[k] > j)) y[j] += A->x[k] * x[A->i[k]];
    }
}

/* Checks K x = f + H r and the law of each contact, by plain loops; sparse K without P. */
static void expect_solved(const answer *A, const dls_model *model, const double *f, const double *g,
                          double tol) {
  const int n = model->n, d = model->d, nc = model->nodes, half = model->factorization != DLS_LU;
  double *Kx = calloc((size_t)n, sizeof *Kx), *Hr = calloc((size_t)n, sizeof *Hr);
  double *u = calloc((size_t)(d * nc) + 1, sizeof *u);
  ck_assert_msg(A->status == DLS_OK, "%s: u %.1e r %.1e e %.1e after %d",
                dls_status_name(A->status), A->info.certificate.residual_u,
                A->info.certificate.residual_r, A->info.certificate.equilibrium,
                A->info.iterations);
  stress_multiply(&model->Ks, 0, half, A->x, Kx);
  for (int c = 0; c < nc; c++)
    for (int i = 0; i < d; i++) {
      const dls_sparse *L = i ? &model->HT : &model->HN;
      const int column = i ? (d - 1) * c + i - 1 : c;
      u[d * c + i] = g ? g[d * c + i] : 0;
      for (int k = L->p[column]; k < L->p[column + 1]; k++) {
        Hr[L->i[k]] += L->x[k] * A->r[d * c + i];
        u[d * c + i] += L->x[k] * A->x[L->i[k]];
      }
    }
  double force = 0, motion = 0;
  for (int j = 0; j < n; j++) {
    force = fmax(force, fmax(fabs(Hr[j]), f ? fabs(f[j]) : 0));
    motion = fmax(motion, fabs(A->x[j]));
  }
  for (int j = 0; j < n; j++)
    ck_assert_msg(fabs(Kx[j] - Hr[j] - (f ? f[j] : 0)) <= tol * force * sqrt(n),
                  "force at %d: %.1e", j, Kx[j] - Hr[j] - (f ? f[j] : 0));
  for (int c = 0; c < nc; c++) {
    const double *r = A->r + d * c, *w = u + d * c, mu = A->mu[c];
    const double rt = d == 3 ? hypot(r[1], r[2]) : fabs(r[1]);
    const double ut = d == 3 ? hypot(w[1], w[2]) : fabs(w[1]);
    const double R = r[0] > 0 ? mu * r[0] : 0;
    ck_assert_msg(r[0] >= 0 && w[0] >= -tol * motion * 10, "contact %d: r_n %g u_n %g", c, r[0],
                  w[0]);
    ck_assert(fmin(r[0] / force, w[0] / motion) <= tol * 10);
    ck_assert(rt <= R * (1 + 1e-12));
    if (rt < R * (1 - 1e-6)) ck_assert_msg(ut <= 10 * tol * motion, "contact %d sticks: %g", c, ut);
    for (int i = 1; i < d && ut > 1e-4 * motion && mu > 0; i++) /* slip is opposed */
      ck_assert(fabs(r[i] / force + R / force * w[i] / ut) <= 1e4 * 10 * tol);
  }
  free(Kx);
  free(Hr);
  free(u);
}

/* Checks the motion of a proof by plain loops. */
static void expect_no_solution(const answer *A, const dls_model *model, const double *f) {
  const int n = model->n, d = model->d, nc = model->nodes;
  int body = -1;
  const double *b = dls_global_motion(A->global, &body);
  ck_assert_msg(A->status == DLS_NO_SOLUTION, "%s", dls_status_name(A->status));
  ck_assert_ptr_nonnull(b);
  ck_assert(body >= 0 && body < n && fabs(largest(b, n) - 1) <= .1);
  double *Kb = calloc((size_t)n, sizeof *Kb), *hn = calloc((size_t)nc + 1, sizeof *hn);
  double *ht = calloc((size_t)(2 * nc) + 1, sizeof *ht), load = 0, turmoil = 0;
  stress_multiply(&model->Ks, 0, 1, b, Kb);
  stress_multiply(&model->HN, 1, 0, b, hn);
  stress_multiply(&model->HT, 1, 0, b, ht);
  ck_assert(largest(Kb, n) <= 1e-12 * largest(model->Ks.x, model->Ks.p[n]));
  for (int j = 0; j < n; j++) {
    load += b[j] * f[j];
    turmoil += fabs(b[j] * f[j]);
  }
  ck_assert_msg(load > 1e-8 * turmoil, "b^T f = %g", load);
  for (int c = 0; c < nc; c++) {
    const double t = d == 3 ? hypot(ht[2 * c], ht[2 * c + 1]) : fabs(ht[c]);
    ck_assert_msg(hn[c] - A->mu[c] * t >= -1e-12, "contact %d: %g %g", c, hn[c], t);
  }
  free(Kb);
  free(hn);
  free(ht);
}

/* ---- small bodies by hand -------------------------------------------------------------------- */

/* Two free bars in series: unknowns 0, 1 and 2, 3; node 0 on the ground, node 2 on node 1, pressed
 * at node 3. */
static stiffness S;
static const int bars_Np[] = {0, 1, 3}, bars_Ni[] = {0, 1, 2}, none[] = {0, 0, 0};
static const double bars_Nx[] = {1, -1, 1};

static const dls_model *two_bars(dls_factorization factorization, int is_sparse) {
  const double rows[16] = {1, -1, 0, 0, -1, 1, 0, 0, 0, 0, 1, -1, 0, 0, -1, 1};
  stiffness_fill(&S, 4, rows, factorization, is_sparse);
  S.model.nodes = 2;
  S.model.HN = (dls_sparse){4, 2, bars_Np, bars_Ni, bars_Nx};
  S.model.HT = (dls_sparse){4, 2, none, bars_Ni, bars_Nx};
  return &S.model;
}

/* Statics: 10 at both contacts; x = -0, -10, -10, -20. By every factorisation, dense and sparse. */
TEST_EACH(free_bars, 0, 6) {
  const double f[4] = {0, 0, 0, -10}, expected[] = {0, -10, -10, -20};
  const dls_model *model = two_bars((dls_factorization)(1 + _i % 3), _i / 3);
  answer A = answer_of(model, f, NULL, 0, 1e-10);
  ck_assert_int_eq(A.status, DLS_OK);
  for (int c = 0; c < 2; c++)
    ck_assert_msg(fabs(A.r[2 * c] - 10) <= 1e-8 && A.r[2 * c + 1] == 0, "%g", A.r[2 * c]);
  assert_near(A.x, expected, 4, 1e-7);
  ck_assert_ptr_null(dls_global_motion(A.global, NULL));
  ck_assert_ptr_null(dls_global_motion(NULL, NULL));
  answer_free(&A);
}

/* The upper bar pulled away from the lower one: bar 2, 3 moves most. */
TEST(bar_pulled_up) {
  const double f[4] = {0, -1, 0, 10};
  const dls_model *model = two_bars(DLS_CHOLESKY, 1);
  answer A = answer_of(model, f, NULL, 0, 1e-8);
  expect_no_solution(&A, model, f);
  int body;
  const double *b = dls_global_motion(A.global, &body);
  ck_assert_int_eq(body, 2);
  ck_assert_msg(fabs(b[2] - 1) <= 1e-12 && fabs(b[3] - 1) <= 1e-12 && fabs(b[0] - b[1]) <= 1e-12,
                "%g %g %g %g", b[0], b[1], b[2] - 1, b[3] - 1);
  answer_free(&A);
}

/* Two nodes tied by a multiplier, x_0 - x_1 = 0, unknown 2; a spring of 1000 under node 1 and a
 * load of 10 on each. Node 0 meets the ground after .01. */
TEST_EACH(tie_by_multiplier, 0, 2) {
  const double rows[9] = {0, 0, 1, 0, 1000, -1, 1, -1, 0}, f[3] = {-10, -10, 0};
  const double g[4] = {.01, 0, .015, 0};
  const int p[] = {0, 1, 2}, i[] = {0, 1};
  const double x[] = {1, 1};
  stiffness_fill(&S, 3, rows, _i ? DLS_LU : DLS_LDLT, 1);
  S.model.nodes = 2;
  S.model.HN = (dls_sparse){3, 2, p, i, x};
  S.model.HT = (dls_sparse){3, 2, none, i, x};
  answer A = answer_of(&S.model, f, g, .3, 1e-10);
  ck_assert_int_eq(A.status,
                   DLS_OK); /* x = -.01 at both: 1000 x .01 = 10 by the spring, 10 by node 0 */
  ck_assert_double_eq_tol(A.r[0], 10, 1e-7);
  ck_assert_double_eq_tol(A.r[2], 0, 1e-7);
  ck_assert_double_eq_tol(A.x[1], -.01, 1e-10);
  answer_free(&A);
}

/* Without the spring: a load on node 1 lifts both nodes, or presses node 0 on the ground. */
TEST_EACH(tied_nodes_fall, 0, 2) {
  const double rows[9] = {0, 0, 1, 0, 0, -1, 1, -1, 0}, f[3] = {1, _i ? -10 : 10, 0};
  const int p[] = {0, 1}, i[] = {0};
  const double x[] = {1};
  stiffness_fill(&S, 3, rows, DLS_LDLT, 1);
  S.model.nodes = 1;
  S.model.HN = (dls_sparse){3, 1, p, i, x};
  S.model.HT = (dls_sparse){3, 1, none, i, x};
  answer A = answer_of(&S.model, f, NULL, 0, 1e-10);
  ck_assert_msg(A.status == (_i ? DLS_OK : DLS_NO_SOLUTION), "%s", dls_status_name(A.status));
  if (_i) ck_assert_double_eq_tol(A.r[0], 9, 1e-7);
  if (!_i) {
    const double *b = dls_global_motion(A.global, NULL);
    ck_assert(fabs(b[0] - 1) <= 1e-12 && fabs(b[1] - 1) <= 1e-12 && fabs(b[2]) <= 1e-12);
  }
  answer_free(&A);
}

/* One node given twice as a contact slides: the sums are what K and the load say. */
TEST(node_twice) {
  const double rows[4] = {100, 0, 0, 100}, f[2] = {1, -10};
  const int p[] = {0, 1, 2}, in[] = {1, 1}, it[] = {0, 0};
  const double x[] = {1, 1};
  stiffness_fill(&S, 2, rows, DLS_CHOLESKY, 1);
  S.model.nodes = 2;
  S.model.HN = (dls_sparse){2, 2, p, in, x};
  S.model.HT = (dls_sparse){2, 2, p, it, x};
  answer A = answer_of(&S.model, f, NULL, .05, 1e-12);
  expect_solved(&A, &S.model, f, NULL, 1e-11);
  ck_assert_double_eq_tol(A.r[0] + A.r[2], 10, 1e-9);
  ck_assert_double_eq_tol(A.r[1] + A.r[3], -.5, 1e-9);
  ck_assert_double_eq_tol(A.x[0], .005, 1e-12);
  answer_free(&A);
}

/* Without contacts x = K^-1 f; a free body without load stays, with one it goes. */
TEST(no_contact) {
  const double rows[4] = {2, -1, -1, 2}, free_rows[4] = {1, -1, -1, 1}, f[2] = {1, 0};
  stiffness_fill(&S, 2, rows, DLS_CHOLESKY, 1);
  answer A = answer_of(&S.model, f, NULL, 0, 1e-14);
  ck_assert_int_eq(A.status, DLS_OK);
  ck_assert(fabs(A.x[0] - 2. / 3) <= 1e-15 && fabs(A.x[1] - 1. / 3) <= 1e-15);
  answer_free(&A);
  stiffness_fill(&S, 2, free_rows, DLS_CHOLESKY, 1);
  A = answer_of(&S.model, NULL, NULL, 0, 1e-8);
  ck_assert(A.status == DLS_OK && A.x[0] == 0 && A.x[1] == 0);
  answer_free(&A);
  A = answer_of(&S.model, (double[]){1, -1}, NULL, 0, 1e-8);
  ck_assert_int_eq(A.status, DLS_OK);
  ck_assert_double_eq_tol(A.x[0] - A.x[1], 1, 1e-7);
  answer_free(&A);
  A = answer_of(&S.model, f, NULL, 0, 1e-8);
  ck_assert_int_eq(A.status, DLS_NO_SOLUTION);
  answer_free(&A);
}

/* A bonded contact holds its tangent while it is pressed, whatever the load along it. */
TEST(bonded) {
  const double rows[4] = {100, 0, 0, 100}, f[2] = {50, -10};
  const int p[] = {0, 1}, in[] = {1}, it[] = {0};
  const double x[] = {1};
  stiffness_fill(&S, 2, rows, DLS_CHOLESKY, 1);
  S.model.nodes = 1;
  S.model.HN = (dls_sparse){2, 1, p, in, x};
  S.model.HT = (dls_sparse){2, 1, p, it, x};
  answer A = answer_of(&S.model, f, NULL, INFINITY, 1e-10);
  ck_assert_int_eq(A.status, DLS_OK);
  assert_near(A.r, (double[]){10, -50}, 2, 1e-7);
  answer_free(&A);
}

/* ---- elastic bodies -------------------------------------------------------------------------- */

/* A block of height 1 in an overlap of .02 between rigid plates without friction, which nothing
 * holds sideways: 2 * .02 / 2 E / (1 - nu^2) of force on the length of 4. */
TEST(press_fit) {
  solids T;
  solids_new(&T, 2, 10, 10);
  solids_block(&T, (int[]){4, 1, 1}, 1000);
  for (int i = 0; i < 5; i++) {
    solids_contact(&T, i, -1, (double[]){0, 1}, -.01);
    solids_contact(&T, 5 + i, -1, (double[]){0, -1}, -.01);
  }
  answer A = answer_of(solids_model(&T), NULL, T.g, 0, 1e-10);
  expect_solved(&A, &T.model, NULL, T.g, 1e-9);
  for (int i = 0; i < 5; i++) {
    const double expected = 20 / (1 - .09) * (i == 0 || i == 4 ? .5 : 1);
    ck_assert_double_eq_tol(A.r[4 * i], expected, 1e-6);
    ck_assert_double_eq_tol(A.r[4 * i + 2], expected, 1e-6);
  }
  answer_free(&A);
  solids_free(&T);
}

/* A free block under a load, and the same on springs of 1e-8 at every unknown: the same forces,
 * although K^-1 f is 1e8 times the body. */
TEST(weak_springs) {
  answer A[2];
  solids T[2];
  for (int soft = 0; soft < 2; soft++) {
    solids_stack(&T[soft], 2, 1, 2, .5);
    for (int k = 0; soft && k < 18; k++)
      solids_spring(&T[soft], k / 2, k % 2, 1e-8);
    A[soft] = answer_of(solids_model(&T[soft]), T[soft].f, T[soft].g, .3, 1e-10);
    expect_solved(&A[soft], &T[soft].model, T[soft].f, T[soft].g, 1e-9);
  }
  for (int k = 0; k < A[0].m; k++)
    ck_assert_double_eq_tol(A[0].r[k], A[1].r[k], 1e-7 * 1e-3);
  for (int soft = 0; soft < 2; soft++) {
    answer_free(&A[soft]);
    solids_free(&T[soft]);
  }
}

static const struct { int d, count, side; } stack_of[] = {{2, 40, 3}, {3, 12, 2}};

/* The top of a stack of free blocks, pushed by less than friction: all weight reaches the ground.
 * Beyond it, by 1 % or twice over, nothing holds it. */
TEST_EACH(stacks, 0, 12) {
  const double push[] = {.5, .9, .999, 1.01, 1.1, 2};
  const int k = _i / 6, d = stack_of[k].d, count = stack_of[k].count, side = stack_of[k].side;
  solids T;
  solids_stack(&T, d, count, side, push[_i % 6]);
  answer A = answer_of(&T.model, T.f, T.g, .3, 1e-8);
  if (push[_i % 6] > 1)
    expect_no_solution(&A, &T.model, T.f);
  else {
    double weight = 0, along = 0;
    expect_solved(&A, &T.model, T.f, T.g, 1e-7);
    for (int c = 0; c < (d == 2 ? side + 1 : (side + 1) * (side + 1)); c++) {
      weight += A.r[d * c];
      along += d == 2 ? A.r[2 * c + 1] : A.r[3 * c + 1];
    }
    ck_assert_double_eq_tol(weight, 1e-3 * count, 1e-6 * 1e-3 * count);
    ck_assert_double_eq_tol(fabs(along), push[_i % 6] * .3e-3, 1e-6 * 1e-3 * count);
  }
  answer_free(&A);
  solids_free(&T);
}

/* The top of a stack is pushed by 1.1 times the friction; springs of 1e-8 to 1e-14 of E at every
 * unknown hold the rest: 3e-5 = 27 k x. Solved down to 1e-12, to what K x rounds. Below, the
 * rounding of K x is more than 1e-4 of the load: not solved, and nothing else is said. */
TEST_EACH(springs_hold, 0, 7) {
  const double k = pow(10, -8 - _i);
  solids T;
  solids_stack(&T, 3, 3, 2, 1.1);
  for (int j = 0; j < T.model.n; j++)
    solids_spring(&T, j / 3, j % 3, k);
  answer A = answer_of(solids_model(&T), T.f, T.g, .3, 1e-8);
  const int solved = A.status == DLS_OK || A.status == DLS_TO_ROUNDING;
  double x = 0;
  for (int j = 54; j < 81; j++)
    x += A.x[3 * j] / 27;
  ck_assert_msg(solved == (_i <= 4) && (solved || A.status == DLS_STALLED), "%s",
                dls_status_name(A.status));
  ck_assert_msg(!solved || fabs(27 * k * x / 3e-5 - 1) <= 1e-3, "%g", 27 * k * x);
  answer_free(&A);
  solids_free(&T);
}

/* An arch that is too thin, or on joints too smooth, is proved to fall. */
TEST_EACH(arches_fall, 0, 9) {
  const int stones[] = {15, 15, 15, 31, 31, 31, 31, 9, 45};
  const double thick[] = {.08, .1, .2, .1, .105, .2, .3, .12, .12};
  const double mu[] = {.6, .6, .1, .7, .7, .1, .3, .32, .32};
  solids T;
  solids_arch(&T, stones[_i], thick[_i]);
  answer A = answer_of(&T.model, T.f, T.g, mu[_i], 1e-8);
  expect_no_solution(&A, &T.model, T.f);
  answer_free(&A);
  solids_free(&T);
}

/* Thicker ones stand, with hinges and sliding joints all along: all weight at the springers. */
TEST_EACH(arches_stand, 0, 9) {
  const int stones[] = {13, 17, 19, 9, 21, 31, 31, 31, 31};
  const double thick[] = {.2, .15, .2, .2, .2, .2, .12, .11, .3};
  const double mu[] = {.5, .6, .4, .7, .7, .7, .7, .7, .35};
  solids T;
  double up = 0;
  solids_arch(&T, stones[_i], thick[_i]);
  answer A = answer_of(&T.model, T.f, T.g, mu[_i], 1e-10);
  expect_solved(&A, &T.model, T.f, T.g, 1e-9);
  for (int j = 0; j < 4; j++) { /* normals at both springers point up */
    up += A.r[2 * j];
    up += A.r[2 * (T.contacts - 1 - j)];
  }
  ck_assert_double_eq_tol(up, 1, 1e-9);
  answer_free(&A);
  solids_free(&T);
}

/* Cantilevers of up to 3000 elements, friction from 0 to 2: the augmented Lagrangian ends them in
 * 60 to 230 iterations, the splitting alone in thousands, or never. */
TEST_EACH(slender, 0, 5) {
  const int length[] = {1000, 1000, 1000, 1000, 3000};
  const double mu[] = {0, .05, .3, 2, .3};
  solids T;
  solids_strip(&T, length[_i], 4);
  answer A = answer_of(&T.model, T.f, T.g, mu[_i], 1e-9);
  expect_solved(&A, &T.model, T.f, T.g, 1e-8);
  ck_assert_msg(A.info.iterations <= (_i < 4 ? 150 : 300), "%d", A.info.iterations);
  answer_free(&A);
  solids_free(&T);
}

/* A thin plate that hangs on one side: contacts slip in all directions, open and close far away. */
TEST(thin_plate) {
  enum { nx = 30 };
  solids T;
  solids_new(&T, 3, 2 * (nx + 1) * (nx + 1), (nx + 1) * (nx + 1));
  const int first = solids_block(&T, (int[]){nx, nx, 1}, 1), layer = (nx + 1) * (nx + 1);
  for (int j = 0; j <= nx; j++)
    for (int k = 0; k < 3; k++)
      solids_spring(&T, first + (nx + 1) * j, k, 1e3);
  for (int i = 0; i < layer; i++) {
    const double x = (double)(i % (nx + 1)) / nx, y = (double)i / layer;
    T.f[3 * (layer + i)] = 2.5e-3 * sin(8 * x + 3 * y);
    T.f[3 * (layer + i) + 1] = 2e-3 * cos(6 * x - 7 * y);
    T.f[3 * (layer + i) + 2] = -1e-2 + (sin(9 * x - 5 * y) < -.5 ? 1.8e-2 : 0);
    solids_contact(&T, i, -1, (double[]){0, 0, 1}, 0);
  }
  answer A = answer_of(solids_model(&T), T.f, T.g, .3, 1e-9);
  expect_solved(&A, &T.model, T.f, T.g, 1e-8);
  ck_assert_msg(A.info.iterations <= 150, "%d", A.info.iterations);
  answer_free(&A);
  solids_free(&T);
}

/* A cantilever of 1000 elements. One of 1000 x 1 is held by a stiffness of 1e-10 of K's entries,
 * one of 3000 x 1 by 7e-12: they may stall, but are never said to be free. */
TEST_EACH(strips, 0, 3) {
  static const int length[] = {250, 1000, 3000};
  solids T;
  solids_strip(&T, length[_i], _i ? 1 : 4);
  answer A = answer_of(&T.model, T.f, T.g, .3, 1e-10);
  if (_i) {
    ck_assert_int_ne(A.status, DLS_NO_SOLUTION);
    ck_assert_ptr_null(dls_global_motion(A.global, NULL));
  } else {
    expect_solved(&A, &T.model, T.f, T.g, 1e-9);
    ck_assert_int_le(A.info.iterations, 200); /* 60 */
  }
  answer_free(&A);
  solids_free(&T);
}

/* Contact over a whole surface, mu from .05 to 2. */
TEST_EACH(surfaces, 0, 24) {
  const double mu[] = {0, .05, .3, .6, 1, 2};
  const int spatial = _i / 12;
  const double tol = _i / 6 % 2 ? 1e-12 : 1e-8;
  solids T;
  if (spatial)
    solids_plate(&T, 8, 2);
  else
    solids_pad(&T, 120, 3);
  answer A = answer_of(&T.model, T.f, T.g, mu[_i % 6], tol);
  expect_solved(&A, &T.model, T.f, T.g, tol < 1e-10 ? 1e-11 : 1e-7);
  ck_assert_int_le(A.info.iterations, 200); /* 20 to 60 here */
  answer_free(&A);
  solids_free(&T);
}

/* The same forces as those of W. */
TEST_EACH(agrees_with_W, 0, 2) {
  solids T;
  dls_reduction *R;
  dls_contact problem;
  dls_admm *admm;
  if (_i)
    solids_plate(&T, 5, 2);
  else
    solids_pad(&T, 40, 2);
  answer A = answer_of(&T.model, T.f, T.g, .3, 1e-10);
  ck_assert_int_eq(A.status, DLS_OK);
  ck_assert(!reduce_on_W(&R, &T.model, NULL, NULL));
  ck_assert(!dls_reduction_load(R, T.f, T.g, NULL));
  ck_assert(!dls_reduction_contact(R, A.mu, &problem, NULL));
  dls_admm_settings s;
  dls_admm_settings_init(&s);
  s.limits.tol = 1e-10;
  double *r = calloc((size_t)A.m, sizeof *r);
  ck_assert(!dls_admm_create(&admm, problem.d, problem.nc, &s, NULL));
  ck_assert_int_eq(dls_admm_solve(admm, &problem, r, NULL, NULL, NULL), DLS_OK);
  assert_near(A.r, r, A.m, 1e-6 * largest(r, A.m));
  free(r);
  dls_admm_destroy(admm);
  dls_reduction_destroy(R);
  answer_free(&A);
  solids_free(&T);
}

/* The step that predicts the error improves an answer whose info is read. */
TEST(info_improves) {
  solids T;
  solids_plate(&T, 6, 2);
  answer best = answer_of(&T.model, T.f, T.g, .3, 1e-12);
  answer A = answer_of(&T.model, T.f, T.g, .3, 1e-3);
  double *unread = calloc((size_t)A.m, sizeof *unread), error[2] = {0};
  const dls_limits limits = {.tol = 1e-3};
  ck_assert_int_eq(dls_global_solve(A.global, T.f, T.g, A.mu, &limits, unread, A.x, NULL, NULL),
                   DLS_OK);
  for (int k = 0; k < A.m; k++) {
    error[0] = fmax(error[0], fabs(A.r[k] - best.r[k]));
    error[1] = fmax(error[1], fabs(unread[k] - best.r[k]));
  }
  ck_assert_double_le(10 * error[0], error[1]);
  free(unread);
  answer_free(&best);
  answer_free(&A);
  solids_free(&T);
}

/* f by 1e9 and 1e-9, lengths by 1e3 and 1e-3: the same iterations. */
TEST_EACH(units, 0, 4) {
  const double force = _i / 2 ? 1e9 : 1e-9, length = _i % 2 ? 1e3 : 1e-3;
  solids T;
  solids_plate(&T, 6, 2);
  answer A = answer_of(&T.model, T.f, T.g, .3, 1e-8);
  for (int k = 0; k < T.Kc.p[T.Kc.cols]; k++)
    T.Kc.x[k] *= force / length;
  for (int j = 0; j < A.n; j++)
    T.f[j] *= force;
  answer B = answer_of(&T.model, T.f, T.g, .3, 1e-8);
  ck_assert(A.status == DLS_OK && B.status == DLS_OK);
  ck_assert_int_eq(A.info.iterations, B.info.iterations);
  ck_assert_int_eq(A.info.factorisations, B.info.factorisations);
  for (int k = 0; k < A.m; k++)
    ck_assert_double_eq_tol(B.r[k] / force, A.r[k], 1e-7 * largest(A.r, A.m));
  answer_free(&A);
  answer_free(&B);
  solids_free(&T);
}

/* A K that is not symmetric: springs that turn. And its transpose would not do. */
TEST(unsymmetric) {
  const double rows[16] = {4, 1, 0, 0, -1, 4, .5, 0, 0, -.5, 4, 1, 0, 0, -1, 4};
  const double f[4] = {1, -3, .5, -2};
  const int p[] = {0, 1, 2}, in[] = {1, 3}, it[] = {0, 2};
  const double x[] = {1, 1};
  stiffness_fill(&S, 4, rows, DLS_LU, 1);
  S.model.nodes = 2;
  S.model.HN = (dls_sparse){4, 2, p, in, x};
  S.model.HT = (dls_sparse){4, 2, p, it, x};
  answer A = answer_of(&S.model, f, NULL, .2, 1e-12);
  expect_solved(&A, &S.model, f, NULL, 1e-11);
  answer_free(&A);
}

/* Weighted contacts: u = P^T (L^T x + g). The certificate of W accepts r. */
TEST(weighted) {
  enum { nodes = 20, contacts = 10 };
  solids T;
  int p[contacts + 1], i[2 * contacts], active[contacts];
  double w[2 * contacts], mu[contacts], g[2 * nodes];
  solids_pad(&T, nodes, 2);
  for (int c = 0; c < contacts; c++) {
    p[c] = 2 * c;
    i[2 * c] = 2 * c;
    i[2 * c + 1] = 2 * c + 1;
    w[2 * c] = .25 + .01 * c;
    w[2 * c + 1] = .75;
    active[c] = c != 3;
    mu[c] = c == 5 ? 0 : .3;
  }
  for (int k = 0; k < 2 * nodes; k++)
    g[k] = k % 2 ? 0 : .01 * (k % 3);
  p[contacts] = 2 * contacts;
  T.model.P = (dls_sparse){nodes, contacts, p, i, w};
  T.model.active = active;
  T.model.mu = mu;
  dls_global *G;
  dls_info info;
  double r[2 * contacts], *x = calloc((size_t)T.model.n, sizeof *x),
                          *y = calloc((size_t)T.model.n, sizeof *y);
  ck_assert(!dls_global_create(&G, &T.model, NULL));
  ck_assert_int_eq(dls_global_contacts(G), contacts - 1);
  const dls_limits limits = {.tol = 1e-11};
  ck_assert_int_eq(dls_global_solve(G, T.f, g, NULL, &limits, r, x, &info, NULL), DLS_OK);
  dls_reduction *R;
  dls_contact problem;
  dls_certificate found;
  ck_assert(!reduce_on_W(&R, &T.model, NULL, NULL));
  ck_assert(!dls_reduction_load(R, T.f, g, NULL));
  ck_assert(!dls_reduction_contact(R, NULL, &problem, NULL));
  ck_assert(!dls_contact_certify(&problem, r, NULL, &found, NULL));
  ck_assert_msg(found.residual <= 1e-9, "%g", found.residual);
  ck_assert(!dls_reduction_recover(R, r, y, NULL));
  assert_near(x, y, T.model.n, 1e-8 * largest(y, T.model.n));
  ck_assert(r[2 * 4 + 1] == 0); /* the fifth active contact has no tangent */
  const double some[contacts - 1] = {.1, .1, .1, .1, .1, .1, .1, .1, .1};
  REFUSES(ARGUMENT, "mu", 4, dls_global_solve, G, T.f, g, some, &limits, r, x, &info);
  dls_reduction_destroy(R);
  dls_global_destroy(G);
  free(x);
  free(y);
  solids_free(&T);
}

/* ---- starts, updates, limits ----------------------------------------------------------------- */

/* A warm start from the answer takes no iteration, from a near one fewer; an update gives the bits
 * of a new object; a repeated solve the same bits. */
TEST(warm_and_update) {
  solids T;
  solids_plate(&T, 6, 2);
  answer A = answer_of(&T.model, T.f, T.g, .3, 1e-8);
  ck_assert_int_eq(A.status, DLS_OK);
  dls_limits limits = {.tol = 1e-8, .warm_start = 1};
  dls_info info;
  double *r = calloc((size_t)A.m, sizeof *r), *x = calloc((size_t)A.n, sizeof *x);
  memcpy(r, A.r, (size_t)A.m * sizeof *r);
  memcpy(x, A.x, (size_t)A.n * sizeof *x);
  ck_assert_int_eq(dls_global_solve(A.global, T.f, T.g, A.mu, &limits, r, x, &info, NULL), DLS_OK);
  ck_assert_int_eq(info.iterations, 0);
  memcpy(r, A.r, (size_t)A.m * sizeof *r);
  memcpy(x, A.x, (size_t)A.n * sizeof *x); /* without info no step improves them */
  ck_assert_int_eq(dls_global_solve(A.global, T.f, T.g, A.mu, &limits, r, x, NULL, NULL), DLS_OK);
  ck_assert_mem_eq(x, A.x, (size_t)A.n * sizeof *x);
  for (int j = 0; j < A.n; j++)
    T.f[j] *= 1 + 1e-6 * (j % 3);
  ck_assert_int_eq(dls_global_solve(A.global, T.f, T.g, A.mu, &limits, r, x, &info, NULL), DLS_OK);
  ck_assert_int_lt(info.iterations, A.info.iterations);
  for (int k = 0; k < T.Kc.p[T.Kc.cols]; k++)
    T.Kc.x[k] *= 2;
  ck_assert(!dls_global_update(A.global, &T.model, NULL));
  answer B = answer_of(&T.model, T.f, T.g, .3, 1e-8);
  limits.warm_start = 0;
  for (int turn = 0; turn < 2; turn++) {
    ck_assert_int_eq(dls_global_solve(A.global, T.f, T.g, A.mu, &limits, r, x, &info, NULL),
                     DLS_OK);
    ck_assert_mem_eq(r, B.r, (size_t)A.m * sizeof *r);
    ck_assert_mem_eq(x, B.x, (size_t)A.n * sizeof *x);
  }
  free(r);
  free(x);
  answer_free(&A);
  answer_free(&B);
  solids_free(&T);
}

static int calls, last_iteration, cancel_at;
static dls_global *inside;

static int watch_global(void *data, const dls_progress *progress) {
  ck_assert_ptr_eq(data, &calls);
  ck_assert_str_eq(progress->method, "global");
  if (!progress->last) {
    double r[1], x[1];
    REFUSES(BUSY, "global", -1, dls_global_solve, inside, NULL, NULL, NULL, NULL, r, x, NULL);
    last_iteration = progress->iteration;
    calls++;
  }
  return calls == cancel_at;
}

TEST(limits_hold) {
  solids T;
  solids_pad(&T, 100, 2);
  answer A = answer_of(&T.model, T.f, T.g, .3, 1e-8);
  dls_info info;
  dls_limits limits = {.tol = 1e-8, .progress = watch_global, .progress_data = &calls};
  inside = A.global;
  calls = 0;
  cancel_at = 2;
  ck_assert_int_eq(dls_global_solve(A.global, T.f, T.g, A.mu, &limits, A.r, A.x, &info, NULL),
                   DLS_CANCELLED);
  ck_assert(info.status == DLS_CANCELLED && info.iterations == 20 && last_iteration == 20);
  ck_assert(info.certificate.residual > 1e-8 && info.certificate.residual < 1);
  cancel_at = -1;
  limits.max_iterations = 15;
  ck_assert_int_eq(dls_global_solve(A.global, T.f, T.g, A.mu, &limits, A.r, A.x, &info, NULL),
                   DLS_MAX_ITERATIONS);
  ck_assert_int_eq(info.iterations, 15);
  limits = (dls_limits){.tol = 0, .cpu_seconds = 1e-9};
  ck_assert_int_eq(dls_global_solve(A.global, T.f, T.g, A.mu, &limits, A.r, A.x, &info, NULL),
                   DLS_TIME_LIMIT);
  answer_free(&A);
  solids_free(&T);
}

/* ---- errors ---------------------------------------------------------------------------------- */

TEST(bad_input) {
  dls_global *G = NULL;
  double f[4] = {0, 0, 0, -10}, g[4] = {0}, mu[2] = {0}, r[4] = {7, 7, 7, 7}, x[4] = {7, 7, 7, 7};
  const double kept[4] = {7, 7, 7, 7};
  dls_limits limits = {.tol = 1e-8};
  const dls_model *model = two_bars(DLS_CHOLESKY, 1);
  REFUSES(ARGUMENT, "out", -1, dls_global_create, NULL, model);
  REFUSES(ARGUMENT, "model", -1, dls_global_create, &G, NULL);
  dls_model other = *model;
  other.n = 0;
  REFUSES(SIZE, "n", -1, dls_global_create, &G, &other);
  other = *model;
  other.operator_kind = DLS_FLEXIBILITY;
  other.K = (dls_dense){4, 4, 4, (const double[16]){0}};
  REFUSES(UNSUPPORTED, "operator_kind", -1, dls_global_create, &G, &other);
  ck_assert_ptr_null(G);
  ck_assert(!dls_global_create(&G, model, NULL));
  REFUSES(ARGUMENT, "global", -1, dls_global_solve, NULL, f, g, mu, &limits, r, x, NULL);
  REFUSES(ARGUMENT, "r", -1, dls_global_solve, G, f, g, mu, &limits, NULL, x, NULL);
  REFUSES(ARGUMENT, "x", -1, dls_global_solve, G, f, g, mu, &limits, r, NULL, NULL);
  REFUSES(ARGUMENT, "x", -1, dls_global_solve, G, f, g, mu, &limits, r, r + 3, NULL);
  f[2] = NAN;
  REFUSES(NOT_FINITE, "f", 2, dls_global_solve, G, f, g, mu, &limits, r, x, NULL);
  f[2] = 0;
  g[3] = INFINITY;
  REFUSES(NOT_FINITE, "g", 3, dls_global_solve, G, f, g, mu, &limits, r, x, NULL);
  g[3] = 0;
  mu[1] = -1;
  REFUSES(ARGUMENT, "mu", 1, dls_global_solve, G, f, g, mu, &limits, r, x, NULL);
  mu[1] = 0;
  limits.tol = NAN;
  REFUSES(ARGUMENT, "tol", -1, dls_global_solve, G, f, g, mu, &limits, r, x, NULL);
  limits = (dls_limits){.tol = 1e-8, .warm_start = 1};
  r[1] = NAN;
  REFUSES(NOT_FINITE, "r", 1, dls_global_solve, G, f, g, mu, &limits, r, x, NULL);
  r[1] = 7;
  x[0] = NAN;
  REFUSES(NOT_FINITE, "x", 0, dls_global_solve, G, f, g, mu, &limits, r, x, NULL);
  x[0] = 7;
  ck_assert_mem_eq(r, kept, sizeof r);
  ck_assert_mem_eq(x, kept, sizeof x);
  /* an update of another kind leaves the object as it was */
  REFUSES(ARGUMENT, "global", -1, dls_global_update, NULL, model);
  other = *model;
  other.nodes = 1;
  other.HN.cols = other.HT.cols = 1;
  REFUSES(SIZE, "nodes", -1, dls_global_update, G, &other);
  other = *model;
  other.factorization = DLS_LDLT;
  REFUSES(ARGUMENT, "factorization", -1, dls_global_update, G, &other);
  other = *model;
  other.active = (const int[]){1, 0};
  REFUSES(SIZE, "active", -1, dls_global_update, G, &other);
  other = *model;
  other.HN.i = (const int[]){0, 1, 3};
  REFUSES(ARGUMENT, "HN", -1, dls_global_update, G, &other);
  other = *model;
  other.Ks = (dls_sparse){4, 4, (const int[]){0, 1, 2, 3, 4}, (const int[]){0, 1, 2, 3},
                          (const double[]){1, 1, 1, 1}};
  REFUSES(ARGUMENT, "Ks", -1, dls_global_update, G, &other);
  ck_assert_int_eq(dls_global_solve(G, f, NULL, NULL, NULL, r, x, NULL, NULL), DLS_OK);
  ck_assert_double_eq_tol(r[0], 10, 1e-6);
  dls_global_destroy(G);
  dls_global_destroy(NULL);
}

/* Every failing allocation of create, update and solve unwinds; outputs stay. */
TEST_EACH(failing_mallocs, 0, 4) {
  solids T;
  dls_global *G = NULL;
  if (_i == 2)
    solids_plate(&T, 6, 2);
  else
    solids_stack(&T, 2, 3, 2, _i ? 2 : .9);
  if (_i == 3) T.model.factorization = DLS_LDLT;
  const int nc = T.contacts, n = T.model.n, m = T.model.d * nc;
  double *mu = calloc((size_t)nc, sizeof *mu), *r = calloc((size_t)m, sizeof *r);
  double *x = calloc((size_t)n, sizeof *x);
  const dls_limits limits = {.tol = _i == 2 ? 1e-12 : 1e-8};
  for (int c = 0; c < nc; c++)
    mu[c] = .3;
  MALLOCS_FAIL(dls_global_create(&G, &T.model, NULL), !G, DLS_OK, 20);
  MALLOCS_FAIL(dls_global_update(G, &T.model, NULL), 1, DLS_OK, 10);
  MALLOCS_FAIL(dls_global_solve(G, T.f, T.g, mu, &limits, r, x, NULL, NULL),
               largest(r, m) == 0 && largest(x, n) == 0,
               _i == 1 || _i == 3 ? DLS_NO_SOLUTION : DLS_OK, 1);
  dls_global_destroy(G);
  free(mu);
  free(r);
  free(x);
  solids_free(&T);
}
