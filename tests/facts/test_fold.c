/* test_fold.c: the fold by hand: its friction, states, witness, and the number of matrices. */
#include "facts/facts.h"
#include "front_cases.h"
#include "run.h"

enum { most_nc = 3, most_m = 2 * most_nc };

typedef struct fold_problem {
  double W[most_m * most_m], q[most_m], mu[most_nc];
  dls_contact p;
} fold_problem;

static fold_problem t;
static dls_fold fold;
static dls_contact_state state[most_nc];
static double q[most_m], r[most_m], other[most_m];

static void set_fold(int nc) {
  const int m = 2 * nc;
  t = (fold_problem){.p = {.d = 2, .nc = nc, .W = {m, m, m, t.W}, .q = t.q, .mu = t.mu}};
}

/* W_cc = w (1 coupling; coupling 1) */
static void set_block(int c, double w, double coupling, double mu) {
  double *W = t.W + 2 * c * (t.p.W.ld + 1);
  W[0] = W[1 + t.p.W.ld] = w;
  W[1] = W[t.p.W.ld] = w * coupling;
  t.mu[c] = mu;
}

static void find_fold(int search) {
  memset(&fold, 0x55, sizeof fold);
  memset(state, 0x55, sizeof state);
  ck_assert_int_eq(dlsi_contact_fold(&t.p, search, &fold, state, q, r, other, NULL), DLS_OK);
}

static void fold_vector_is(const double *x, double first, double second) {
  ck_assert_msg(fabs(x[0] - first) <= 1e-14 * 8 && fabs(x[1] - second) <= 1e-14 * 8, "%.17g %.17g",
                x[0], x[1]);
}

/* W = 4 (1 b; b 1), b = -1/2 or 1/2: lambda = 2 with r_t = side 2 r_n, side = -sign b. Scaled by
 * 1 / 2: y = (1, 2 side) or its negative, W y = (0, 3 side / 2), so that a step of 1 / 3 leaves
 * half of u_t; q = (0, -side) - W (1, 2 side) = (0, -5 side / 2). The other candidate, of W = w, is
 * free: q_n = sqrt(w), in either place; the one that folds has the share 1, or 1/2 where its mu is
 * the smaller. */
TEST(one_slips) {
  for (int at = 0; at < 2; at++)
    for (int half = 0; half < 2; half++)
      for (int side = -1; side <= 1; side += 2) {
        const int none = 1 - at;
        set_fold(2);
        set_block(at, 4, -0.5 * side, half ? 0.25 : 0.5);
        set_block(none, 16, 0, half ? 0.5 : 0.25);
        find_fold(0);
        ck_assert_double_eq_tol(fold.friction, half ? 4 : 2, 1e-14);
        ck_assert(fold.exact == 1 && fold.matrices == 6 + 1);
        ck_assert(state[at] == DLS_SLIP && state[none] == DLS_FREE);
        fold_vector_is(q + 2 * at, 0, -5 * side);
        fold_vector_is(q + 2 * none, 4, 0);
        fold_vector_is(r + 2 * at, 0.5, side);
        fold_vector_is(r + 2 * none, 0, 0);
        const double step = other[2 * at] > 0.5 ? 1. / 6 : -1. / 6;
        fold_vector_is(other + 2 * at, 0.5 + step, side * (1 + 2 * step));
        fold_vector_is(other + 2 * none, 0, 0);
      }
}

/* (4^nc - 2^nc) / 2 matrices, as one of them slips and the first keeps its side; without friction a
 * candidate is free or slips: 5 for one of two. All without are as all with it. One more gives the
 * vector of the fold. */
TEST(matrices_are_counted) {
  static const int matrices[] = {1, 6, 28};
  for (int nc = 1; nc <= 3; nc++) {
    set_fold(nc);
    for (int c = 0; c < nc; c++)
      set_block(c, 1, 0.25, 1);
    find_fold(0);
    ck_assert_int_eq(fold.matrices, matrices[nc - 1] + 1);
    ck_assert_double_eq_tol(fold.friction, 4, 1e-14);
    for (int c = 0; c < nc; c++)
      t.mu[c] = 0;
    find_fold(0);
    ck_assert_int_eq(fold.matrices, matrices[nc - 1] + 1);
    ck_assert_double_eq_tol(fold.friction, 4, 1e-14);
  }
  for (int c = 0; c < 2; c++) {
    set_fold(2);
    set_block(c, 1, 0.25, 0);
    set_block(1 - c, 1, 0.125, 2);
    find_fold(0);
    ck_assert_int_eq(fold.matrices, 5 + 1);
    ck_assert_double_eq_tol(fold.friction, 8, 1e-14); /* the one with friction */
    ck_assert(state[1 - c] == DLS_SLIP && state[c] == DLS_FREE);
  }
}

/* Two that slip against each other: W_nn = I, W_nt = (0 a; b 0), of which (FO2) has the eigenvalues
 * g = +- sqrt(a b) if both slip to sides of the same product, else imaginary ones: lambda =
 * 1 / sqrt(a b), and sides that are opposed if a b < 0. */
TEST(two_slip) {
  for (int opposed = 0; opposed < 2; opposed++) {
    const double a = 0.5, b = opposed ? -0.125 : 0.125;
    set_fold(2);
    set_block(0, 1, 0, 1);
    set_block(1, 1, 0, 1);
    t.W[0 + 4 * 3] = t.W[3 + 4 * 0] = a; /* W_nt of 0 and 1 */
    t.W[2 + 4 * 1] = t.W[1 + 4 * 2] = b;
    for (int search = 0; search < 2; search++) {
      find_fold(search);
      ck_assert_double_eq_tol(fold.friction, 4, 1e-13);
      ck_assert(fold.exact == !search);
      ck_assert(state[0] == DLS_SLIP && state[1] == DLS_SLIP);
      ck_assert((r[1] * r[3] > 0) == !opposed);
      fold_vector_is(r, 1, r[1] > 0 ? 4 : -4);
      fold_vector_is(r + 2, 1, r[3] > 0 ? 4 : -4);
      for (int k = 0; k < 2; k++) { /* both are answers of q: u_n = 0, u_t against r_t */
        const double *of = k ? other : r;
        for (int c = 0; c < 2; c++) {
          const double couple_n = c ? b : a, couple_t = c ? a : b;
          const double u_n = q[2 * c] + of[2 * c] + couple_n * of[2 * (1 - c) + 1];
          const double u_t = q[2 * c + 1] + of[2 * c + 1] + couple_t * of[2 * (1 - c)];
          ck_assert_msg(fabs(u_n) <= 1e-13 && u_t * of[2 * c + 1] < 0, "%g, %g", u_n, u_t);
          ck_assert(of[2 * c] >= 0.4 && fabs(of[2 * c]) < 1.6);
          ck_assert(fabs(fabs(of[2 * c + 1]) - 4 * of[2 * c]) < 1e-13);
        }
      }
      ck_assert(fabs(r[0] - other[0]) > 0.01);
    }
  }
}

/* One slips, b = 1/4 between its n and t, and the other one sticks, h = 1/2 between its t and the n
 * of the first: g = -b / (1 - h^2), lambda = 3 in place of 4, y = (1, -3; 0, -1/2) for b > 0, and
 * the step leaves 6 tenths of the friction of the one that sticks, 3/32. Each of q, r, other may be
 * NULL. */
TEST(one_sticks) {
  for (int at = 0; at < 2; at++)
    for (int side = -1; side <= 1; side += 2) {
      const int n = 2 * at, other_t = 2 * (1 - at) + 1;
      double alone[4];
      set_fold(2);
      set_block(at, 1, -0.25 * side, 1);
      set_block(1 - at, 1, 0, 1. / 32);
      t.W[n + 4 * other_t] = t.W[other_t + 4 * n] = 0.5;
      find_fold(0);
      ck_assert_double_eq_tol(fold.friction, 3, 1e-14);
      ck_assert(state[at] == DLS_SLIP && state[1 - at] == DLS_STICK);
      fold_vector_is(r + n, 1, 3 * side);
      fold_vector_is(r + other_t - 1, 1, 0);
      const double step = other[n] > 1 ? 0.075 : -0.075;
      fold_vector_is(other + n, 1 + step, 3 * side * (1 + step));
      fold_vector_is(other + other_t - 1, 1, -step / 2);
      fold_vector_is(q + n, -1 + 0.75, -side - (3 - 0.25) * side);
      fold_vector_is(q + other_t - 1, -1, -0.5);
      for (int k = 0; k < 3; k++) {
        const double *all[3] = {q, r, other};
        double *const one[3] = {k == 0 ? alone : NULL, k == 1 ? alone : NULL,
                                k == 2 ? alone : NULL};
        ck_assert_int_eq(dlsi_contact_fold(&t.p, 0, &fold, NULL, one[0], one[1], one[2], NULL),
                         DLS_OK);
        ck_assert_mem_eq(alone, all[k], sizeof alone);
      }
    }
}

/* One candidate, 200 starts: two matrices from a start that slips, three from the other 50. */
TEST(the_search_ends) {
  set_fold(1);
  set_block(0, 1, 0.25, 1);
  find_fold(1);
  ck_assert_double_eq_tol(fold.friction, 4, 1e-14);
  ck_assert(fold.exact == 0 && fold.matrices == 400 + 50 + 1 && state[0] == DLS_SLIP);
  t.mu[0] = 0.5;
  ck_assert_int_eq(dls_contact_fold(&t.p, &fold, NULL, NULL, NULL, NULL, NULL), DLS_OK);
  ck_assert(fold.exact == 1 && fold.matrices == 1 + 1);
}

/* What of W is not positive definite: its symmetric part is singular, (1 1; 1 1), or is not. */
TEST(unsymmetric) {
  set_fold(1);
  set_block(0, 1, 0, 1);
  for (int k = 0; k < 2; k++) {
    t.W[k ? 1 : 2] = 3;
    t.W[k ? 2 : 1] = -1;
    dls_error e;
    ck_assert_int_eq(dlsi_contact_fold(&t.p, 0, &fold, NULL, NULL, NULL, NULL, &e),
                     DLS_E_NOT_POSITIVE_DEFINITE);
    ck_assert_str_eq(e.argument, "W");
    ck_assert(e.index == -1);
    t.W[k ? 1 : 2] = 2; /* (1 1/2; 1/2 1) */
    find_fold(0);
    ck_assert_double_eq_tol(fold.friction, k ? 1 : 0.5, 1e-14); /* W_nn / |W_nt| */
  }
}

TEST(what_is_refused) {
  dls_error e;
  fold.matrices = 77;
  set_fold(2);
  set_block(0, 1, 0, 1);
  set_block(1, 1, 0, INFINITY);
  ck_assert_int_eq(dlsi_contact_fold(&t.p, 0, &fold, NULL, NULL, NULL, NULL, &e),
                   DLS_E_UNSUPPORTED);
  ck_assert_str_eq(e.argument, "mu");
  ck_assert_int_eq(e.index, 1);
  t.mu[0] = 0;
  t.p = (dls_contact){.d = 1, .nc = 1, .W = {1, 1, 4, t.W}, .q = t.q, .mu = t.mu};
  ck_assert_int_eq(dlsi_contact_fold(&t.p, 0, &fold, NULL, NULL, NULL, NULL, &e),
                   DLS_E_UNSUPPORTED);
  ck_assert_str_eq(e.argument, "d");
  ck_assert(e.index == -1 && e.value == 1 && fold.matrices == 77);
}

/* ---- d = 3 ----------------------------------------------------------------------------------- */

enum { most_3d = 4, rows_3d = 3 * most_3d };

/* W, q, mu of nc contacts with d = 3. */
typedef struct space_problem {
  double W[rows_3d * rows_3d], q[rows_3d], mu[most_3d];
  dls_contact p;
} space_problem;

static void set_space(space_problem *s, int nc) {
  const int m = 3 * nc;
  *s = (space_problem){.p = {.d = 3, .nc = nc}};
  s->p.W = (dls_dense){m, m, m, s->W};
  s->p.q = s->q;
  s->p.mu = s->mu;
  for (int i = 0; i < m; i++)
    s->W[i + m * i] = 1;
  for (int c = 0; c < nc; c++)
    s->mu[c] = 1;
}

/* Turns the tangents of contact c by an angle: rows and columns of W. */
static void turn_tangents(space_problem *s, int c, double angle) {
  const int m = 3 * s->p.nc, a = 3 * c + 1, b = a + 1;
  for (int columns = 0; columns < 2; columns++)
    for (int k = 0; k < m; k++) {
      double *A = columns ? &s->W[k + m * a] : &s->W[a + m * k];
      double *B = columns ? &s->W[k + m * b] : &s->W[b + m * k];
      const double x = *A, y = *B;
      *A = cos(angle) * x + sin(angle) * y;
      *B = cos(angle) * y - sin(angle) * x;
    }
}

/* The bracket by hand, and the witness: q has both answers at `friction`, apart by more than
 * residuals hide. */
static void expect_bracket(space_problem *s, double unique, double friction) {
  double load[rows_3d], one[rows_3d], two[rows_3d], mu[most_3d], apart = 0, size = 0, most_mu = 0;
  dls_contact_state kind[most_3d];
  dls_error error;
  ck_assert_msg(!dls_contact_fold(&s->p, &fold, kind, load, one, two, &error), "%s", error.message);
  ck_assert(!fold.exact && fold.unique <= fold.friction);
  if (unique > 0) ck_assert_double_eq_tol(fold.unique, unique, 1e-13 * unique);
  if (friction > 0) {
    ck_assert_double_ge(fold.friction, friction);
    ck_assert_double_le(fold.friction, friction * (1 + 1.1e-6));
  }
  for (int c = 0; c < s->p.nc; c++)
    most_mu = fmax(most_mu, s->mu[c]);
  for (int c = 0; c < s->p.nc; c++)
    mu[c] = fold.friction * s->mu[c] / most_mu;
  dls_contact p = s->p;
  p.q = load;
  p.mu = mu;
  for (int k = 0; k < 2; k++) {
    dls_certificate certificate;
    ck_assert(!dls_contact_certify(&p, k ? two : one, NULL, &certificate, NULL));
    ck_assert(dls_certificate_holds(&certificate, 1e-12));
  }
  for (int i = 0; i < 3 * p.nc; i++) {
    apart = fmax(apart, fabs(one[i] - two[i]));
    size = fmax(size, fabs(one[i]));
  }
  ck_assert_msg(apart > 1e-7 * size, "%g of %g", apart, size);
}

/* One contact, W = (1 b 0; b 1 0; 0 0 e): slip along x folds at 1 / b. Where k = 1 - e - b^2 < 0, a
 * direction at the angle a to x that can turn folds at
 *
 *   (1 - b^2 sin^2 a / c) / (b e cos a / c),  c = e cos^2 a + sin^2 a,
 *
 * least at cos^2 a = -(e + k) / k, if that is below 1: 2 sqrt(-k (e + k)) / (b e). For e = 1 it is
 * the bound below which the answer is proved to be one: the bracket closes. In any frame, unit. */
TEST(one_contact_in_space) {
  static const double b[] = {0.5, 0.8, 0.8, 0.8}, e[] = {1, 1, 0.9, 0.5};
  for (int k = 0; k < 4; k++)
    for (int turned = 0; turned < 3; turned++) {
      space_problem s;
      set_space(&s, 1);
      s.W[1] = s.W[3] = b[k];
      s.W[8] = e[k];
      turn_tangents(&s, 0, turned);
      for (int i = 0; i < 9 && turned == 2; i++)
        s.W[i] *= 1e-9;
      const double kappa = 1 - e[k] - b[k] * b[k];
      const int turns = -kappa > e[k] + kappa;
      expect_bracket(&s, k < 2 ? (turns ? 1.2 : 2) : 0,
                     turns ? 2 * sqrt(-kappa * (e[k] + kappa)) / (b[k] * e[k]) : 1 / b[k]);
    }
}

/* Two slip against each other as in two_slip, in directions of their own: a, b between the n of
 * one and a tangent of the other: 1 / sqrt(a b); a second contact that sticks as in one_sticks: 3.
 * A share of 1/2 at both doubles the largest coefficient. */
TEST(two_contacts_in_space) {
  for (int k = 0; k < 4; k++) {
    space_problem s;
    set_space(&s, 2);
    s.W[0 + 6 * 4] = 0.5;
    s.W[3 + 6 * 1] = 0.125;
    turn_tangents(&s, 0, k);
    turn_tangents(&s, 1, -2 * k);
    if (k == 3) s.mu[0] = 0.25; /* with s_0 = 1/4 the product falls to a quarter */
    expect_bracket(&s, 0, k == 3 ? 8 : 4);
    set_space(&s, 2);
    s.W[0 + 6 * 1] = s.W[1 + 6 * 0] = 0.25;
    s.W[0 + 6 * 4] = s.W[4 + 6 * 0] = 0.5;
    s.W[3 + 6 * 3] = 1. / 32;
    turn_tangents(&s, 0, k);
    turn_tangents(&s, 1, -2 * k);
    expect_bracket(&s, 0, 3);
  }
}

/* Random W: the friction is that of any frame, and the bracket is one. Each malloc fails in turn.
 */
TEST(brackets_in_space) {
  for (unsigned k = 0; k < 12; k++) {
    unsigned seed = 977 * k + 1;
    space_problem s;
    double B[rows_3d * rows_3d];
    set_space(&s, 1 + (int)(k % 3));
    const int m = 3 * s.p.nc;
    for (int i = 0; i < m * m; i++)
      B[i] = draw(&seed);
    for (int i = 0; i < m; i++)
      for (int j = 0; j < m; j++) {
        s.W[i + m * j] = i == j ? 0.1 : 0;
        for (int l = 0; l < m; l++)
          s.W[i + m * j] += B[i + m * l] * B[j + m * l];
      }
    if (k % 4 == 3) s.mu[0] = 0;
    if (k % 4 == 3 && s.p.nc == 1) continue; /* all equal then */
    expect_bracket(&s, 0, 0);
    const double before = fold.friction;
    for (int c = 0; c < s.p.nc; c++)
      turn_tangents(&s, c, 1 + c);
    expect_bracket(&s, 0, 0);
    ck_assert_double_eq_tol(fold.friction, before, 1e-6 * before);
  }
  space_problem s;
  set_space(&s, 1);
  s.W[1] = s.W[3] = 0.5;
  fold.matrices = -7;
  MALLOCS_FAIL(dls_contact_fold(&s.p, &fold, NULL, NULL, NULL, NULL, NULL), fold.matrices == -7,
               DLS_OK, 2);
  s.W[1] = s.W[3] = 0; /* nothing couples n and t */
  ck_assert(!dls_contact_fold(&s.p, &fold, NULL, NULL, NULL, NULL, NULL));
  ck_assert(isinf(fold.friction) && isinf(fold.unique));
}
