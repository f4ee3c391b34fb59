/* test_border.c: a Newton step with the factors of other states, against its own matrix. */
#include "cases.h"
#include "run.h"
#include "vi/newton/border.h"

enum { nc = 24, most_rows = 3 * nc };

static double W[most_rows * most_rows], q[most_rows], w[nc], E[nc], mu[nc];
static dls_contact p;
static int d, m;

/* W diagonally dominant, not symmetric, so that every matrix of a step is regular. */
static void border_problem(int dimension) {
  d = dimension;
  m = d * nc;
  for (int k = 0; k < m * m; k++)
    W[k] = uniform() / m;
  for (int k = 0; k < m; k++)
    W[k + k * m] += 3;
  for (int c = 0; c < nc; c++) {
    w[c] = 2 + uniform();
    E[c] = 1 + uniform();
    mu[c] = d > 1 && c % 5 ? .3 : 0;
  }
  p = (dls_contact){.d = d, .nc = nc, .W = {m, m, m, W}, .q = q, .mu = mu};
}

/* A state by chance; its place among the unknowns is set by border_number. */
static dlsi_branch border_state(int c) {
  dlsi_branch b = {.state = DLS_FREE, .mu = mu[c]};
  const double chance = (uniform() + 1) / 2, angle = 3 * uniform();
  if (chance < (d == 1 ? .45 : .3)) return b;
  if (mu[c] > 0 && chance < .6) {
    b.state = DLS_STICK;
    b.count = (short)d;
    return b;
  }
  b.state = DLS_SLIP;
  b.count = (short)(mu[c] > 0 && d > 1 ? d - 1 : 1);
  if (!(mu[c] > 0)) return b;
  b.t[0] = d == 3 ? cos(angle) : angle > 0 ? 1 : -1;
  b.t[1] = d == 3 ? sin(angle) : 0;
  b.l = d == 3 ? 1 + uniform() : 0;
  return b;
}

static int border_number(dlsi_branch *b) {
  int n = 0;
  for (int c = 0; c < nc; c++) {
    b[c].first = n;
    n += b[c].count;
  }
  return n;
}

/* M (n x n) := (NE2). */
static void border_matrix(const dlsi_branch *b, const double *springs, double eps, int n,
                          double *M) {
  for (int c = 0; c < nc; c++)
    for (int j = 0; j < b[c].count; j++)
      for (int a = 0; a < nc; a++)
        for (int i = 0; i < b[a].count; i++) {
          double e[3], v[3] = {0}, *at = M + b[a].first + i + (size_t)(b[c].first + j) * (size_t)n;
          dlsi_branch_direction(&b[c], j, e);
          for (int k = 0; k < d; k++)
            for (int l = 0; l < d; l++)
              v[k] += W[d * a + k + (d * c + l) * m] * e[l];
          *at = dlsi_branch_row(&b[a], i, v);
          if (a == c && i == j)
            *at += eps * w[c] + (springs ? springs[c] : 0) +
                   (b[c].state == DLS_SLIP && j == 1 ? b[c].l : 0);
        }
}

/* The largest component of M x - right. */
static double border_error(const double *M, int n, const double *x, const double *right) {
  double largest = 0;
  for (int i = 0; i < n; i++) {
    double sum = -right[i];
    for (int j = 0; j < n; j++)
      sum += M[i + j * n] * x[j];
    largest = fmax(largest, fabs(sum));
  }
  return largest;
}

/* Factorises (NE2) of these states, and begins a border on the room that is left. Returns the side
 * of the matrix. */
static int border_start(dlsi_border *border, dlsi_dense *factors, dlsi_branch *base,
                        const double *springs, double eps) {
  static double room[2 * most_rows * most_rows];
  static int pivot[most_rows];
  double scratch[most_rows];
  const int n = border_number(base);
  const size_t used = (size_t)(n * n), all = sizeof room / sizeof *room;
  border_matrix(base, springs, eps, n, room);
  *factors = (dlsi_dense){.n = n, .A = room, .pivot = pivot};
  ck_assert_int_eq(dlsi_dense_factor(factors, scratch), 0);
  dlsi_border_begin(border, d, nc, base, n, room + used, all - used);
  return n;
}

/* Changes two candidates at a time, some of them more than once, until there is no room. */
TEST_EACH(solves_for_other_states, 0, 48) {
  static double M[most_rows * most_rows];
  dlsi_branch base[nc], now[nc];
  double x[most_rows], right[most_rows];
  const double eps = 1e-3, *springs = _i / 3 % 2 ? E : NULL;
  set_seed(521288629 + (uint64_t)_i);
  border_problem(_i % 3 + 1);
  for (int c = 0; c < nc; c++)
    base[c] = now[c] = border_state(c);
  dlsi_dense factors;
  dlsi_border border = {.loose = 0};
  const int n = border_start(&border, &factors, base, springs, eps);
  ck_assert_int_ge(border.most, 1);
  ck_assert_int_le(border.most, n / 6);
  int turns = 0, k;
  for (;; turns++) {
    k = border_number(now);
    const int before = border.k;
    if (!dlsi_border_add(&border, &p, &factors, now)) {
      ck_assert_int_eq(border.k, before);
      break;
    }
    border_matrix(now, springs, eps, k, M);
    for (int i = 0; i < k; i++)
      right[i] = x[i] = uniform();
    ck_assert(dlsi_border_solve(&border, &factors, now, w, springs, eps, x));
    ck_assert_msg(border_error(M, k, x, right) <= 1e-12, "turn %d: %g", turns,
                  border_error(M, k, x, right));
    ck_assert(turns < 200);
    now[(7 * turns + 3) % nc] = border_state((7 * turns + 3) % nc);
    const int again = border.k ? border.of[turns % border.k] : -1; /* -1: given up */
    if (again >= 0) now[again] = border_state(again);
  }
  ck_assert_int_ge(turns, 2);
}

/* Directions of slip that turn a little and an l that changes need no unknown more where factors
 * may serve loosely: what the solution leaves of its right side is of the size of the turn, and
 * nothing comes of a change of l on a W that does not couple. A direction that turns far needs
 * some. */
TEST_EACH(serves_loosely, 0, 2) {
  static double M[most_rows * most_rows];
  const double turn = _i ? 0 : 0.02, stretch = _i ? 3 : 1;
  dlsi_branch base[nc], now[nc];
  double x[most_rows], right[most_rows];
  set_seed(88172645 + (uint64_t)_i);
  border_problem(3);
  for (int k = 0; _i && k < m * m; k++)
    W[k] = k / m == k % m ? 3 : 0;
  for (int c = 0; c < nc; c++) {
    w[c] = 3;
    base[c] = now[c] = border_state(c);
    if (now[c].count != 2) continue;
    const double cosine = cos(turn), sine = sin(turn), t[2] = {now[c].t[0], now[c].t[1]};
    now[c].t[0] = cosine * t[0] - sine * t[1];
    now[c].t[1] = cosine * t[1] + sine * t[0];
    now[c].l *= stretch;
  }
  dlsi_dense factors;
  dlsi_border border = {.loose = 1};
  const int n = border_start(&border, &factors, base, NULL, 0);
  ck_assert_int_eq(border_number(now), n);
  ck_assert_int_eq(dlsi_border_add(&border, &p, &factors, now), 1);
  ck_assert_int_eq(border.k, 0);
  border_matrix(now, NULL, 0, n, M);
  for (int i = 0; i < n; i++)
    right[i] = x[i] = uniform();
  ck_assert(dlsi_border_solve(&border, &factors, now, w, NULL, 0, x));
  const double left = border_error(M, n, x, right);
  if (_i)
    ck_assert(left <= 1e-12);
  else
    ck_assert(left > 1e-6 && left <= 2 * turn);
  int far = 0;
  while (now[far].count != 2)
    far++;
  now[far].t[0] = -now[far].t[0];
  now[far].t[1] = -now[far].t[1];
  ck_assert_int_eq(dlsi_border_add(&border, &p, &factors, now), 1);
  ck_assert_int_eq(border.k, 2);
}

/* W = 1 but for two contacts with the same rows and columns: where both press, S = 1 - 1 = 0 is not
 * rounded, the matrix is singular, and x stays. */
TEST(singular_states) {
  dlsi_branch b[nc];
  double x[most_rows], before[most_rows];
  set_seed(521288629);
  border_problem(1);
  for (int k = 0; k < m * m; k++)
    W[k] = k / m == k % m || (k / m < 2 && k % m < 2);
  for (int c = 0; c < nc; c++)
    b[c] = (dlsi_branch){.state = c % 2 ? DLS_SLIP : DLS_FREE, .count = (short)(c % 2)};
  dlsi_dense factors;
  dlsi_border border = {.loose = 0};
  (void)border_start(&border, &factors, b, NULL, 0);
  b[0] = (dlsi_branch){.state = DLS_SLIP, .count = 1};
  (void)border_number(b);
  for (int k = 0; k < m; k++)
    x[k] = before[k] = uniform();
  ck_assert_int_eq(dlsi_border_add(&border, &p, &factors, b), 1);
  ck_assert_int_eq(border.k, 1);
  ck_assert_int_eq(dlsi_border_solve(&border, &factors, b, w, NULL, 0, x), 0);
  ck_assert_mem_eq(x, before, (size_t)m * sizeof *x);
}

/* No room: nothing fits, and the factors serve as they are. */
TEST(without_room) {
  double A[4] = {4, 0, 0, 4}, x[2] = {2, 2};
  int pivot[2];
  const dlsi_branch b[2] = {{.state = DLS_SLIP, .count = 1},
                            {.state = DLS_SLIP, .count = 1, .first = 1}};
  const double four[4] = {4, 0, 0, 4}, zero[2] = {0}, one[2] = {1, 1};
  const dls_contact problem = {.d = 1, .nc = 2, .W = {2, 2, 2, four}, .q = zero, .mu = zero};
  dlsi_dense factors = {.n = 2, .A = A, .pivot = pivot};
  double scratch[2];
  ck_assert_int_eq(dlsi_dense_factor(&factors, scratch), 0);
  dlsi_border border = {.loose = 0};
  dlsi_border_begin(&border, 1, 2, b, 2, NULL, 0);
  ck_assert_int_eq(border.most, 0);
  ck_assert_int_eq(dlsi_border_add(&border, &problem, &factors, b), 1);
  ck_assert_int_eq(dlsi_border_solve(&border, &factors, b, one, NULL, 0, x), 1);
  ck_assert(x[0] == .5 && x[1] == .5);
}
