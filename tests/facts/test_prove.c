/*
 * test_prove.c: proofs against exact answers.
 *
 * Problems of small integers, d = 1 and 2: all states in turn, each solved in fractions, give all
 * solutions. d = 3: the solution is planted, r_t on Pythagorean triples, q = u - W r in integers.
 *
 *   build/tests/facts/test_prove 100000
 *
 * judges so many problems of either kind and prints how many proofs there are, and how many are
 * wrong.
 */
#include "cases.h"
#include "delassus.h"
#include "failures.h"
#include "run.h"

enum { most_nc = 3, size = 2 * most_nc };

/* ---- all solutions of a problem of integers -------------------------------------------------- */

/* W, q and mu: integers, mu in quarters. Up to 4 unknowns with friction: 64 bits hold their
 * products. */
typedef struct exact {
  int d, nc, W[size][size], q[size], mu[most_nc];
  int singular; /* choices of states whose matrix is singular */
  int solutions,
      regular; /* isolated ones; regular: one of them, all its inequalities strict, ... */
  long double r[64][size];
  long double strict[size]; /* ... is this one */
} exact;

static int integer(int from, int to) {
  const int x = from + (int)((uniform() + 1) / 2 * (to - from + 1));
  return x > to ? to : x;
}

/* Bareiss: M (n x n + 1) becomes diagonal but for a common factor. Returns 0 if M is singular;
 * x_i = M[i][n] / M[i][i]. */
static int solve_exactly(int n, long long M[size][size + 1]) {
  long long before = 1;
  for (int k = 0; k < n; k++) {
    int p = k;
    while (p < n && M[p][k] == 0)
      p++;
    if (p == n) return 0;
    for (int j = 0; j <= n && p != k; j++) {
      const long long x = M[k][j];
      M[k][j] = M[p][j];
      M[p][j] = x;
    }
    for (int i = 0; i < n; i++) {
      if (i == k) continue;
      const long long by = M[i][k];
      for (int j = 0; j <= n; j++)
        M[i][j] = (M[i][j] * M[k][k] - by * M[k][j]) / before;
    }
    before = M[k][k];
  }
  return 1;
}

/* States: 0 free, 1 stick, 2 and 3 slip with r_t = mu r_n and -mu r_n. Judges those of `code`. */
static void exact_try(exact *e, int code) {
  long long M[size][size + 1] = {{0}}, r[size] = {0}, u, det;
  int state[most_nc], n = 0, of[size], part[size], strict = 1;
  for (int c = 0; c < e->nc; c++, code /= 4) {
    state[c] = code % 4;
    if (e->d == 1 || e->mu[c] == 0) { /* stick and one slip are one state */
      if (state[c] > 1) return;
      if (state[c] == 1) state[c] = 2;
    }
    for (int i = 0; i < (state[c] == 0 ? 0 : state[c] == 1 ? 2 : 1); i++) {
      of[n] = c;
      part[n++] = i;
    }
  }
  for (int i = 0; i < n; i++) { /* 4 r_n of slips are unknown: all entries are integers */
    const int row = e->d * of[i] + part[i];
    M[i][n] = -e->q[row];
    for (int j = 0; j < n; j++) {
      const int col = e->d * of[j], slip = state[of[j]] >= 2;
      M[i][j] = e->W[row][col + part[j]] * (slip ? 4 : 1);
      if (slip && e->d == 2)
        M[i][j] += e->W[row][col + 1] * e->mu[of[j]] * (state[of[j]] == 2 ? 1 : -1);
    }
  }
  if (!solve_exactly(n, M)) {
    e->singular++;
    return;
  }
  det = n ? M[0][0] : 1; /* all of the diagonal */
  const long long sign = det < 0 ? -1 : 1;
  for (int i = 0; i < n; i++) { /* r in units of 1 / (4 |det|), which the sign leaves positive */
    const int c = of[i], slip = state[c] >= 2;
    const long long x = M[i][n] * sign * 4;
    r[e->d * c + part[i]] = x * (slip ? 4 : 1);
    if (slip && e->d == 2) r[e->d * c + 1] = x * e->mu[c] * (state[c] == 2 ? 1 : -1);
  }
  for (int c = 0; c < e->nc; c++) {
    const int o = e->d * c, slip = state[c] >= 2;
    long long law[2] = {0, 1}; /* >= 0 */
    for (int i = 0; i < e->d; i++) {
      u = 4 * det * sign * e->q[o + i];
      for (int j = 0; j < e->d * e->nc; j++)
        u += e->W[o + i][j] * r[j];
      if (state[c] == 0 && i == 0) law[0] = u;
      if (slip && i == 1 && e->mu[c] > 0) law[1] = state[c] == 2 ? -u : u;
    }
    if (state[c]) law[0] = r[o];
    if (state[c] == 1) law[1] = e->mu[c] * r[o] - 4 * (r[o + 1] < 0 ? -r[o + 1] : r[o + 1]);
    if (law[0] < 0 || law[1] < 0) return;
    if (law[0] == 0 || law[1] == 0) strict = 0;
  }
  for (int i = 0; i < e->d * e->nc; i++) {
    e->r[e->solutions][i] = (long double)r[i] / (long double)(4 * det * sign);
    if (strict) e->strict[i] = e->r[e->solutions][i];
  }
  e->solutions++;
  e->regular |= strict;
}

/* The i-th problem, with all its solutions, and as doubles. */
static void exact_make(exact *e, model *a, int i) {
  set_seed((uint64_t)i + 1);
  *e = (exact){.d = 1 + i % 2, .nc = 1 + i / 2 % (i % 2 ? 2 : most_nc)};
  const int m = e->d * e->nc, kind = i / 6 % 3;
  set_model(a, e->d, e->nc);
  for (int c = 0; c < e->nc; c++) {
    e->mu[c] = e->d == 1 ? 0 : integer(0, 8);
    a->mu[c] = e->mu[c] / 4.0;
  }
  for (int k = 0; k < m; k++) { /* any W, symmetric, or definite */
    for (int j = 0; j <= k; j++) {
      e->W[k][j] = integer(-3, 3) + (j == k ? 3 : 0);
      e->W[j][k] = kind ? e->W[k][j] : integer(-3, 3) + (j == k ? 3 : 0);
      if (kind == 2 && j == k) e->W[k][k] += 8;
    }
    e->q[k] = integer(-7, 7);
  }
  for (int k = 0; k < m; k++) {
    for (int j = 0; j < m; j++)
      a->W[k + j * m] = e->W[k][j];
    a->q[k] = e->q[k];
  }
  for (int code = 0; code < 1 << 2 * e->nc; code++)
    exact_try(e, code);
}

/* ---- judges ---------------------------------------------------------------------------------- */

typedef struct tally {
  int problems, proofs, wrong, regular, missed, without;
} tally;

/* Returns |x - r| of all entries. */
static double distance(int m, const double *r, const long double *x) {
  double sum = 0;
  for (int i = 0; i < m; i++)
    sum = hypot(sum, (double)(x[i] - r[i]));
  return sum;
}

/* w (nc): the mean of each diagonal block, of the positive ones where it is not positive. */
static void weigh(const exact *e, double *w) {
  double sum = 0, positive = 0;
  for (int c = 0; c < e->nc; c++) {
    w[c] = 0;
    for (int j = e->d * c; j < e->d * (c + 1); j++)
      w[c] += (double)e->W[j][j] / e->d;
    if (w[c] > 0) sum += w[c];
    positive += w[c] > 0;
  }
  for (int c = 0; c < e->nc; c++)
    if (!(w[c] > 0)) w[c] = positive > 0 ? sum / positive : INFINITY; /* not judged by the box */
}

/* A proof is right if exactly one solution lies within its radius, and no other one in its box. */
static int is_right(const exact *e, const dls_proof *proof, const double *r) {
  const int m = e->d * e->nc;
  double w[most_nc];
  weigh(e, w);
  int near = 0, in_box = 0;
  if (proof->kind == DLS_PROVED_POSITIONS) return e->solutions + e->singular > 0;
  for (int k = 0; k < e->solutions; k++) {
    int inside = 1, again = 0;
    for (int i = 0; i < m; i++) {
      const double off = fabs((double)(e->r[k][i] - r[i]));
      if (off > 0 && off * w[i / e->d] > proof->box) inside = 0;
    }
    for (int l = 0; l < k && !again; l++)
      again = !memcmp(e->r[k], e->r[l], sizeof e->r[k]);
    if (again) continue;
    in_box += inside;
    near += distance(m, r, e->r[k]) <= proof->radius * norm_of(r, m) * (1 + 1e-9) + 1e-19;
  }
  return near == 1 && in_box <= 1;
}

static void judge_start(const exact *e, const model *a, const double *start, tally *t) {
  double r[size];
  dls_proof proof;
  ck_assert_int_eq(dls_contact_prove(&a->p, start, &proof, r, NULL), DLS_OK);
  if (!proof.kind) return;
  t->proofs++;
  t->wrong += !is_right(e, &proof, r);
}

/* Judges proofs of the i-th problem from the answer of auto, and from r that are forced on it. */
static void judge_integers(int i, tally *t) {
  static exact e;
  static model a;
  double r[size];
  dls_info info;
  dls_proof proof;
  exact_make(&e, &a, i);
  const int m = e.d * e.nc;
  t->problems++;
  t->without += !e.solutions && !e.singular;
  const dls_status status = dls_solve(&a.p, NULL, r, NULL, &info, NULL);
  ck_assert_int_ge(status, 0);
  judge_start(&e, &a, r, t);
  if (e.regular && e.solutions == 1 && !e.singular && status == DLS_OK) {
    t->regular++;
    ck_assert_int_eq(dls_contact_prove(&a.p, r, &proof, NULL, NULL), DLS_OK);
    t->missed += proof.kind != DLS_PROVED;
  }
  for (int turn = 0; turn < 3; turn++) {
    for (int k = 0; k < m; k++)
      r[k] = turn == 2 ? 0 : k % e.d ? uniform() : 1 + uniform();
    if (turn && e.solutions) r[0] = (double)e.r[0][0];
    judge_start(&e, &a, r, t);
  }
}

/* The i-th problem with a planted solution, d = 3. */
static void plant(int i, model *a, long double *x) {
  static const int triples[][3] = {{3, 4, 5}, {-4, 3, 5}, {0, 5, 5}, {5, 12, 13}, {-8, 15, 17}};
  set_seed((uint64_t)i + 1);
  const int nc = 1 + i % most_nc, m = 3 * nc;
  int r[9], u[9];
  set_model(a, 3, nc);
  for (int c = 0; c < nc; c++) {
    const int *t = triples[integer(0, 4)], state = integer(0, 2);
    const int k = 1 << integer(0, 3), alpha = integer(1, 4);
    a->mu[c] = t[2] / 32.0; /* r_n = 32 k: r_t = k t on the edge */
    r[3 * c] = state ? 32 * k : 0;
    u[3 * c] = state ? 0 : integer(1, 9);
    for (int j = 0; j < 2; j++) {
      r[3 * c + 1 + j] = state == 0 ? 0 : state == 1 ? k * t[j] : k * integer(-2, 2);
      u[3 * c + 1 + j] = state == 2 ? 0 : state == 1 ? -alpha * t[j] : integer(-9, 9);
    }
  }
  for (int k = 0; k < m; k++)
    for (int j = 0; j <= k; j++)
      a->W[k + j * m] = a->W[j + k * m] = integer(-3, 3) + (j == k ? 24 : 0);
  for (int k = 0; k < m; k++) {
    double sum = u[k];
    for (int j = 0; j < m; j++)
      sum -= a->W[k + j * m] * r[j];
    a->q[k] = sum;
    x[k] = r[k];
  }
}

static void judge_planted(int i, tally *t) {
  static model a;
  long double x[9];
  double r[9];
  dls_info info;
  dls_proof proof;
  plant(i, &a, x);
  t->problems++;
  if (dls_solve(&a.p, NULL, r, NULL, &info, NULL)) return;
  t->regular++;
  ck_assert_int_eq(dls_contact_prove(&a.p, r, &proof, r, NULL), DLS_OK);
  t->missed += proof.kind != DLS_PROVED;
  if (!proof.kind) return;
  t->proofs++;
  t->wrong += !(distance(3 * a.p.nc, r, x) <= proof.radius * norm_of(r, 3 * a.p.nc) * (1 + 1e-9));
}

enum { integers = 3000, planted = 1500 };

TEST(proofs_of_integers) {
  tally t = {0};
  for (int i = 0; i < integers; i++)
    judge_integers(i, &t);
  ck_assert_int_eq(t.wrong, 0);
  ck_assert_int_eq(t.missed, 0);
  ck_assert_int_gt(t.regular, integers / 3);
  ck_assert_int_gt(t.without, integers / 100);
}

TEST(proofs_of_planted) {
  tally t = {0};
  for (int i = 0; i < planted; i++)
    judge_planted(i, &t);
  ck_assert_int_eq(t.wrong, 0);
  ck_assert_int_eq(t.missed, 0);
  ck_assert_int_eq(t.regular, planted);
}

/* ---- by hand --------------------------------------------------------------------------------- */

static dls_proof prove(const dls_contact *p, const double *r, double *improved) {
  dls_proof proof;
  ck_assert_int_eq(dls_contact_prove(p, r, &proof, improved, NULL), DLS_OK);
  return proof;
}

/* W = 1, q = (-1, t), mu = 1/2: sticks with r = (1, -t) for |t| < 1/2, slips beyond. */
TEST_EACH(border_of_one, 0, 3) {
  static model a;
  static const double t[] = {0.25, 0.5, 0.75};
  set_model(&a, 2, 1);
  a.W[0] = a.W[3] = 1;
  a.q[0] = -1;
  a.q[1] = t[_i];
  a.mu[0] = 0.5;
  const double r[2] = {1, -fmin(t[_i], 0.5)};
  const dls_proof proof = prove(&a.p, r, NULL);
  ck_assert_int_eq(proof.kind, _i == 1 ? DLS_NOT_PROVED : DLS_PROVED);
  ck_assert_int_eq(proof.border, _i == 1);
  ck_assert_int_eq(proof.contact, _i == 1 ? 0 : -1);
  ck_assert(_i != 1 || proof.state + proof.other == DLS_STICK + DLS_SLIP);
  ck_assert_int_eq(proof.rows, _i == 2 ? 1 : 2);
}

/* A contact that touches without force, one that leaves: the borders of free. */
TEST(border_of_free) {
  static model a;
  set_model(&a, 1, 2);
  a.W[0] = a.W[3] = 1;
  a.q[0] = -1;
  a.q[1] = 0;
  const dls_proof proof = prove(&a.p, (double[]){1, 0}, NULL);
  ck_assert_int_eq(proof.kind, DLS_NOT_PROVED);
  ck_assert_int_eq(proof.border, 1);
  ck_assert_int_eq(proof.contact, 1);
  ck_assert(proof.state == DLS_FREE || proof.other == DLS_FREE);
}

/* Four legs of a table under its weight: W = H^T H with the three motions that its legs feel, a
 * sum of forces that is determined to rounding, one self-stress. */
TEST(four_legs) {
  static model a;
  static const double H[3][4] = {{1, 1, 1, 1}, {1, -1, 1, -1}, {1, 1, -1, -1}};
  double r[4] = {0.75, 0.25, 0.25, 0.75}, improved[4];
  set_model(&a, 1, 4);
  for (int i = 0; i < 4; i++) {
    a.q[i] = -2;
    for (int j = 0; j < 4; j++)
      for (int k = 0; k < 3; k++)
        a.W[i + 4 * j] += H[k][i] * H[k][j];
  }
  const dls_proof proof = prove(&a.p, r, improved);
  ck_assert_int_eq(proof.kind, DLS_PROVED_POSITIONS);
  ck_assert_int_eq(proof.freedom, 1);
  ck_assert_int_eq(proof.rows, 4);
  /* (m + 8) eps (|W| |r| + |q|) / |q| where long double has 53 bits, as under valgrind */
  ck_assert_double_le(proof.perturbed, 12 * DBL_EPSILON * (12 + 2) / 2 * 4);
  ck_assert_double_le(proof.radius, 1e-14);
  ck_assert_double_le(fabs(improved[0] + improved[1] + improved[2] + improved[3] - 2), 1e-14);
  r[0] = 0.8; /* the legs do not balance: no solution, but one near */
  ck_assert_int_eq(prove(&a.p, r, improved).kind, DLS_PROVED_POSITIONS);
  ck_assert_double_le(fabs(improved[0] + improved[1] + improved[2] + improved[3] - 2), 1e-14);
}

/* One contact, W = diag(1, 1, 1/100), mu = 1, q = (-1, -1.05, 0): slips with r = (1, 1, 0). Where
 * r_t is turned by psi, the law across it is sin(psi) (1.05 - 0.99 cos(psi)) over a cosine. Its
 * slope is 0.06 at the answer, three times that at psi = 0.3: steps by the slope of their start
 * stop far from it, and a proof has to know by how much slopes change in its box ((PR4), B). */
TEST(turned_slip) {
  static model a;
  static const double answer[3] = {1, 1, 0};
  int proofs = 0;
  set_model(&a, 3, 1);
  a.W[0] = a.W[4] = 1;
  a.W[8] = 0.01;
  a.q[0] = -1;
  a.q[1] = -1.05;
  a.mu[0] = 1;
  for (int k = -60; k <= 60; k++) {
    const double psi = k / 100.0, r[3] = {1, cos(psi), sin(psi)};
    double improved[3], off = 0;
    const dls_proof proof = prove(&a.p, r, improved);
    if (!proof.kind) continue;
    proofs++;
    for (int i = 0; i < 3; i++)
      off = hypot(off, improved[i] - answer[i]);
    ck_assert_double_le(off, proof.radius * norm_of(improved, 3) * (1 + 1e-9));
  }
  ck_assert_int_ge(proofs, 40);
}

/* By blocks, of bodies, in other units and with contacts in another order: the same verdict, and
 * radii within a factor of 4. */
TEST_EACH(storages_and_units, 0, 18) {
  const int number = _i < 12 ? _i : _i + 88;
  static model a, b;
  static block_storage B;
  static bodies_storage S;
  dls_contact other;
  double r[most], mirrored[most], improved[2][most];
  if (number < 100) numbered_model(&a, number);
  if (number >= 100) bodies_model(&a, &S, &other, number);
  const int m = a.p.d * a.p.nc;
  dls_info info;
  ck_assert_int_eq(dls_solve(&a.p, NULL, r, NULL, &info, NULL), DLS_OK);
  const dls_proof one = prove(&a.p, r, improved[0]);
  if (number < 100) other = by_blocks(&a, &B);
  for (int turn = 0; turn < 3; turn++) {
    memcpy(mirrored, r, sizeof r);
    if (turn == 1) {
      scale_model(&b, &a, 1e-6, 1e9);
      for (int k = 0; k < m; k++)
        mirrored[k] = r[k] * 1e9;
    }
    if (turn == 2) {
      reverse_model(&b, &a);
      for (int k = 0; k < m; k++)
        mirrored[k] = r[reversed(&a, k)];
    }
    const dls_proof two = prove(turn ? &b.p : &other, mirrored, improved[1]);
    ck_assert_int_eq(two.kind, one.kind);
    ck_assert_double_le(two.radius, 4 * one.radius);
    ck_assert_double_le(one.radius, 4 * two.radius);
    ck_assert_double_le(two.error, 1.1 * one.error + 1e-13);
  }
  ck_assert_int_eq(one.kind, DLS_PROVED);
  ck_assert_double_le(one.radius, 1e-12);
}

/* A rigid box at rest on two corners: u = 0, and the bound on u is relative to q. */
TEST(positions_of_a_body_at_rest) {
  static const double h[4][3] = {{0, 1, -0.5}, {1, 0, 0.5}, {0, 1, 0.5}, {1, 0, 0.5}};
  static const double f[3] = {0, -10, 0}, compliance[3] = {1, 1, 6}, mu[2] = {0.5, 0.5};
  double W[16] = {0}, q[4] = {0}, r[4];
  for (int i = 0; i < 4; i++)
    for (int k = 0; k < 3; k++) {
      q[i] += h[i][k] * compliance[k] * f[k];
      for (int j = 0; j < 4; j++)
        W[i + 4 * j] += h[i][k] * compliance[k] * h[j][k];
    }
  const dls_contact p = {.d = 2, .nc = 2, .W = {4, 4, 4, W}, .q = q, .mu = mu};
  ck_assert_int_eq(dls_solve(&p, NULL, r, NULL, NULL, NULL), DLS_OK);
  dls_proof proof;
  ck_assert_int_eq(dls_contact_prove(&p, r, &proof, r, NULL), DLS_OK);
  ck_assert_int_eq(proof.kind, DLS_PROVED_POSITIONS);
  ck_assert_int_eq(proof.freedom, 1);
  ck_assert_double_le(proof.radius_u, 1e-12);
  ck_assert_double_le(fabs(r[0] + r[2] - 10), 1e-7);
}

/* The catalogue: a proof is of a solution that the file lists, and there is none of a problem
 * without one, from any r. */
TEST(proofs_of_the_catalogue) {
  int count, proofs = 0;
  const failure *f = contact_failures(&count);
  for (int k = 0; k < count; k++) {
    const dls_contact p = failure_contact(&f[k]);
    double r[FAILURE_N] = {0}, improved[FAILURE_N];
    dls_info info;
    for (int turn = 0; turn < 8; turn++) {
      if (turn == 0) ck_assert_int_ge(dls_solve(&p, NULL, r, NULL, &info, NULL), 0);
      for (int i = 0; turn && i < f[k].n; i++)
        r[i] = uniform() * turn;
      const dls_proof proof = prove(&p, r, improved);
      if (!proof.kind) continue;
      proofs++;
      ck_assert_msg(!f[k].none, "%s has no solution", f[k].name);
      int listed = f[k].continua > 0 || f[k].points == 0;
      for (int s = 0; s < f[k].points && !listed; s++) {
        double off = 0;
        for (int i = 0; i < f[k].n; i++) /* files have some 16 digits */
          off = hypot(off, f[k].point[s].x[i] - improved[i]);
        listed = off <= (proof.radius + 1e-12) * norm_of(improved, f[k].n);
      }
      ck_assert_msg(listed, "%s: not one of its solutions", f[k].name);
    }
  }
  ck_assert_int_ge(proofs, count);
}

/* W = (1 -1; -1 1 + 1e-13) is definite: the certificate cannot tell, the proof can, and auto asks
 * for it. */
TEST(nearly_singular) {
  static model a;
  double r[2];
  dls_info info;
  set_model(&a, 1, 2);
  a.W[0] = 1;
  a.W[1] = a.W[2] = -1;
  a.W[3] = 1 + 1e-13;
  a.q[0] = a.q[1] = -1;
  ck_assert_int_eq(dls_solve(&a.p, NULL, r, NULL, &info, NULL), DLS_TO_ROUNDING);
  const dls_proof proof = prove(&a.p, r, NULL);
  ck_assert_int_eq(proof.kind, DLS_PROVED);
  const double answer = 2 / (a.W[3] - 1);
  ck_assert_double_le(fabs(r[1] - answer), proof.radius * answer * 2);
}

/* W from 1e-300 to 1e300 and forces as far apart: the box of a proof may overflow. Each call ends,
 * and what it proves is the answer. */
TEST(beyond_the_range_of_numbers) {
  static model a;
  int proved = 0;
  for (int i = -300; i <= 300; i += 50)
    for (int j = -300; j <= 300; j += 50)
      for (int l = -300; l <= 300; l += 100) {
        set_model(&a, 2, 1);
        a.W[0] = pow(10, i);
        a.W[3] = 1e-10 * a.W[0];
        a.q[0] = -pow(10, j);
        a.mu[0] = 1;
        const double r[2] = {pow(10, l), 0}, answer = pow(10, j - i);
        double better[2];
        const dls_proof proof = prove(&a.p, r, better);
        if (proof.kind == DLS_NOT_PROVED) continue;
        ck_assert_double_eq_tol(better[0], answer, 1e-12 * answer);
        ck_assert_double_eq(better[1], 0);
        proved++;
      }
  ck_assert_int_gt(proved, 200);
}

TEST(nothing_wrong) {
  double W[4] = {4, 0, 0, 1}, q[2] = {-4, -0.25}, mu[1] = {0.5}, r[2] = {1, 0.25};
  double improved[2] = {7, 7};
  const dls_contact p = {.d = 2, .nc = 1, .W = {2, 2, 2, W}, .q = q, .mu = mu};
  dls_proof proof = {.rows = -7};
  REFUSES(ARGUMENT, "problem", -1, dls_contact_prove, NULL, r, &proof, NULL);
  REFUSES(ARGUMENT, "r", -1, dls_contact_prove, &p, NULL, &proof, NULL);
  REFUSES(ARGUMENT, "proof", -1, dls_contact_prove, &p, r, NULL, NULL);
  r[1] = NAN;
  REFUSES(NOT_FINITE, "r", 1, dls_contact_prove, &p, r, &proof, improved);
  r[1] = 0.25;
  MALLOCS_FAIL(dls_contact_prove(&p, r, &proof, improved, NULL),
               proof.rows == -7 && improved[0] == 7, DLS_OK, 3);
  ck_assert_int_eq(proof.kind, DLS_PROVED);
  const dls_contact nothing = {.d = 2};
  ck_assert_int_eq(dls_contact_prove(&nothing, r, &proof, improved, NULL), DLS_OK);
  ck_assert_int_eq(proof.kind, DLS_PROVED);
}

static int count; /* of the command line */

TEST_ALONE(counted) {
  tally t[2] = {{0}};
  for (int i = 0; i < count; i++) {
    judge_integers(i, &t[0]);
    judge_planted(i, &t[1]);
  }
  for (int k = 0; k < 2; k++)
    printf("%s: %d problems (%d without a solution), %d proofs, %d wrong; %d of %d regular "
           "answers proved\n",
           k ? "planted, d = 3" : "integers, d = 1, 2", t[k].problems, t[k].without, t[k].proofs,
           t[k].wrong, t[k].regular - t[k].missed, t[k].regular);
  (void)fflush(stdout);
  ck_assert_int_eq(t[0].wrong + t[1].wrong, 0);
}

int main(int argc, char **argv) {
  if (argc > 1) {
    count = atoi(argv[1]);
    return run_alone(counted, 0, 1);
  }
  return run_tests("prove", NULL, NULL);
}
