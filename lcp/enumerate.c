/*
 * enumerate.c: finds all solutions of a small LCP(M, q).
 *
 *   y = M z + q,   y >= 0,  z >= 0,  y^T z = 0
 *
 * The solution set is the union over the 2^n sets A of the polyhedra
 *
 *   P_A = { z : z_A >= 0,  z = 0 elsewhere,  (M z + q)_A = 0,  (M z + q) >= 0 elsewhere }
 *       = { x >= 0 : C x = q },   x_j = z_j, C_j = -M_j for j in A;  x_j = y_j, C_j = e_j elsewhere
 *
 * For each A:
 *   (EN1)  M_AA regular:  z_A = -M_AA^-1 q_A is a solution if the certificate says so
 *   (EN2)  M_AA singular: x := a vertex of P_A by the simplex method (phase 1, Bland's rule), or
 *          P_A is empty
 *   (EN3)  J := { j : x_j > 0 somewhere in P_A }, by the simplex method on each x_j from there
 *   (EN4)  the affine hull of P_A has the directions { v : C_J v_J = 0, v = 0 elsewhere }; z_i
 *          takes more than one value if some v_i != 0
 *
 * Reason for (EN4): take for each j in J a point of P_A with x_j > 0. The mean of these points is
 * positive on all of J, so P_A contains mean + t v for small |t|. An isolated solution is the only
 * point of each P_A that contains it, so (EN1) or (EN2) finds it.
 *
 * The computation uses (R M C, R q / beta), with powers of two R, C that equilibrate M and beta =
 * max |R q|: tolerances are pure numbers. Listed solutions are certified on the user's M and q.
 *
 * Cost: 2^n eliminations of k x k, k = n/2 on average. Can fail: a matrix within 1e-12 of a
 * singular one counts as singular, and the simplex method treats 1e-10 as 0.
 */
#include <float.h>
#include <limits.h>
#include <math.h>
#include <string.h>

#include "delassus/pivoting.h"
#include "lcp_internal.h"

enum { most = DLS_ENUMERATE_MAX, pivot_limit = 10000 };

static const double rank_tol = 1e-12, zero_tol = 1e-10, same_tol = 1e-8;

/* How a set A ends: no certified solution; a point of P_A is listed; list full; rounding. */
typedef enum outcome { none = 0, listed = 1, full = -1, stalled = -2 } outcome;

typedef double table[most][most + 1]; /* rows of (A | b), b right after the last column of A */

typedef struct problem {
  const dls_lcp *lcp;
  int n;
  double tol;
  double M[most][most], q[most]; /* R M C, R q / beta */
  double unit[most];             /* z_j = unit_j x_j for the scaled z */
  double weights[most];          /* of the certificate */
  int capacity;
  double *list; /* n x capacity */
  dls_enumeration found;
} problem;

/* ---- elimination ----------------------------------------------------------------------------- */

static void simplex_divide_row(table T, int r, int width, double pivot) {
  for (int j = 0; j < width; j++)
    T[r][j] /= pivot;
}

/* Makes column j unit: T_rj = 1, T_ij = 0 for the other rows. */
static void enumerate_pivot(table T, int rows, int width, int r, int j) {
  simplex_divide_row(T, r, width, T[r][j]);
  T[r][j] = 1;
  for (int i = 0; i < rows; i++) {
    const double f = T[i][j];
    if (i == r || f == 0) continue;
    for (int l = 0; l < width; l++)
      T[i][l] -= f * T[r][l];
    T[i][j] = 0;
  }
}

/* Eliminates (A | b) by Gauss-Jordan with complete pivoting; row_of[j] := the row of column j, -1
 * if it has none. Returns the rank of A. */
static int enumerate_eliminate(table T, int rows, int cols, int *row_of) {
  int rank = 0, used[most] = {0};
  double first = 0;
  for (int j = 0; j < cols; j++)
    row_of[j] = -1;
  for (;;) {
    int r = -1, c = -1;
    double largest = 0;
    for (int i = 0; i < rows; i++)
      for (int j = 0; !used[i] && j < cols; j++)
        if (row_of[j] < 0 && fabs(T[i][j]) > largest) {
          largest = fabs(T[i][j]);
          r = i;
          c = j;
        }
    if (rank == 0) first = largest;
    if (!(largest > rank_tol * first)) return rank;
    enumerate_pivot(T, rows, cols + 1, r, c);
    row_of[c] = r;
    used[r] = 1;
    rank++;
  }
}

/* ---- the simplex method on { x >= 0 : C x = q } ---------------------------------------------- */

typedef struct cone {
  int n;
  table T;         /* B^-1 (C | q), B the basic columns */
  int basic[most]; /* column of each row; -1: an artificial variable */
  int pivots;      /* a few n; at pivot_limit rounding has defeated Bland's rule */
} cone;

/* Returns the row that leaves for column e by Bland's rule: the least variable among the ties,
 * artificial ones first; -1 if x_e is unbounded. *step := the new value of x_e. */
static int simplex_leaving_row(const cone *k, int e, double *step) {
  int row = -1;
  *step = INFINITY;
  for (int i = 0; i < k->n; i++) {
    if (!(k->T[i][e] > zero_tol)) continue;
    const double ratio = k->T[i][k->n] / k->T[i][e];
    if (row < 0 || ratio < *step - zero_tol) {
      row = i;
      *step = ratio;
    } else if (ratio <= *step + zero_tol && k->basic[i] < k->basic[row]) {
      row = i;
      if (ratio < *step) *step = ratio;
    }
  }
  return row;
}

static void simplex_enter(cone *k, int row, int e) {
  enumerate_pivot(k->T, k->n, k->n + 1, row, e);
  k->basic[row] = e;
  k->pivots++;
  for (int i = 0; i < k->n; i++) /* a value within rounding of 0 is 0 */
    if (fabs(k->T[i][k->n]) <= zero_tol) k->T[i][k->n] = 0;
}

/* (EN2) Returns 1 if there is a vertex; then x = T_.n in the basic columns. */
static int simplex_find_vertex(cone *k) {
  const int n = k->n;
  for (int i = 0; i < n; i++) {
    k->basic[i] = -1;
    if (k->T[i][n] < 0) simplex_divide_row(k->T, i, n + 1, -1);
  }
  double step;
  for (int e = 0; e < n && k->pivots < pivot_limit; e++) { /* least column that ... */
    double gain = 0;                                       /* ... lowers the artificial sum */
    for (int i = 0; i < n; i++)
      if (k->basic[i] < 0) gain += k->T[i][e];
    if (!(gain > n * zero_tol)) continue;
    const int row = simplex_leaving_row(k, e, &step);
    if (row < 0) continue;
    simplex_enter(k, row, e);
    e = -1;
  }
  for (int i = 0; i < n; i++)
    if (k->basic[i] < 0 && k->T[i][n] > 0) return 0;
  for (int i = 0; i < n; i++) {
    int e = -1; /* pivot out an artificial variable at 0, or clear its row */
    for (int j = 0; k->basic[i] < 0 && j < n; j++)
      if (fabs(k->T[i][j]) > zero_tol && (e < 0 || fabs(k->T[i][j]) > fabs(k->T[i][e]))) e = j;
    if (e >= 0)
      simplex_enter(k, i, e);
    else if (k->basic[i] < 0)
      memset(k->T[i], 0, sizeof k->T[i]);
  }
  return 1;
}

static void simplex_mark_positive(const cone *k, char *positive) {
  for (int i = 0; i < k->n; i++)
    if (k->basic[i] >= 0 && k->T[i][k->n] > 0) positive[k->basic[i]] = 1;
}

/* (EN3) Raises x_j from 0 until it is positive or cannot grow. */
static void simplex_try_positive(cone *k, int j, char *positive) {
  const int n = k->n;
  while (!positive[j] && k->pivots < pivot_limit) {
    int row = -1, e = -1;
    for (int i = 0; i < n; i++)
      if (k->basic[i] == j) row = i;
    if (row < 0) e = j;
    for (int l = 0; row >= 0 && e < 0 && l < n; l++) /* x_j = T_rn - sum_l T_rl x_l */
      if (k->T[row][l] < -zero_tol) e = l;
    if (e < 0) return;
    double step;
    const int leaving = simplex_leaving_row(k, e, &step);
    if (leaving < 0) { /* a ray of P_A */
      positive[e] = 1;
      for (int i = 0; i < n; i++)
        if (k->basic[i] >= 0 && k->T[i][e] < -zero_tol) positive[k->basic[i]] = 1;
      return;
    }
    simplex_enter(k, leaving, e);
    simplex_mark_positive(k, positive);
  }
}

/* ---- one set A ------------------------------------------------------------------------------- */

/* Adds z (n, scaled) to the list if it is certified and new. */
static outcome enumerate_add(problem *p, const double *z) {
  const int n = p->n;
  double x[most], y[most], a[most], largest = 0;
  for (int i = 0; i < n; i++) {
    x[i] = z[i] > 0 ? p->unit[i] * z[i] : 0;
    if (z[i] > largest) largest = z[i];
  }
  dls_lcp_certificate certificate;
  dlsi_lcp_multiply(p->lcp, p->lcp->q, x, y, a);
  dlsi_lcp_measure(p->lcp, x, y, a, p->weights, &certificate);
  if (!dls_lcp_certificate_holds(&certificate, p->tol)) return none;
  for (int l = 0; l < p->found.solutions; l++) {
    const double *w = p->list + (size_t)l * (size_t)n;
    int same = 1;
    for (int i = 0; i < n; i++)
      if (!(fabs(x[i] - w[i]) / p->unit[i] <= same_tol * largest)) same = 0;
    if (same) return listed;
  }
  if (p->found.solutions == p->capacity) return full;
  memcpy(p->list + (size_t)p->found.solutions++ * (size_t)n, x, (size_t)n * sizeof *x);
  return listed;
}

/* x_A := M_AA^-1 b_A if M_AA is regular; returns the rank of M_AA. */
static int enumerate_solve(const problem *p, int k, const int *A, const double *b, double *x) {
  table T;
  int row_of[most];
  for (int i = 0; i < k; i++) {
    for (int j = 0; j < k; j++)
      T[i][j] = p->M[A[i]][A[j]];
    T[i][k] = b[A[i]];
  }
  const int rank = enumerate_eliminate(T, k, k, row_of);
  for (int j = 0; j < k && rank == k; j++)
    x[A[j]] = T[row_of[j]][k];
  return rank;
}

/* (EN1) Returns 0 if M_AA is singular. A sign wrong by more than rounding rejects z at once. */
static int enumerate_regular(problem *p, int k, const int *A, outcome *out) {
  const int n = p->n;
  double b[most], z[most] = {0}, largest = 0;
  for (int i = 0; i < n; i++)
    b[i] = -p->q[i];
  if (enumerate_solve(p, k, A, b, z) < k) return 0;
  *out = none;
  for (int i = 0; i < k; i++)
    if (fabs(z[A[i]]) > largest) largest = fabs(z[A[i]]);
  for (int i = 0; i < k; i++)
    if (!(z[A[i]] >= -same_tol * largest)) return 1;
  for (int i = 0; i < n; i++) { /* b := -q - M z = -y */
    double a = fabs(b[i]);
    for (int j = 0; j < k; j++) {
      b[i] -= p->M[i][A[j]] * z[A[j]];
      a += fabs(p->M[i][A[j]] * z[A[j]]);
    }
    if (!(b[i] <= same_tol * a)) return 1;
  }
  *out = enumerate_add(p, z);
  return 1;
}

/* (EN2)-(EN4) for the set `in`, M_AA singular. */
static outcome enumerate_singular(problem *p, const char *in) {
  const int n = p->n;
  cone k = {.n = n};
  for (int i = 0; i < n; i++) {
    for (int j = 0; j < n; j++)
      k.T[i][j] = in[j] ? -p->M[i][j] : i == j;
    k.T[i][n] = p->q[i];
  }
  p->found.singular_bases++;
  const int vertex = simplex_find_vertex(&k); /* (EN2) */
  if (k.pivots >= pivot_limit) return stalled;
  if (!vertex) return none;
  double z[most] = {0};
  for (int i = 0; i < n; i++)
    if (k.basic[i] >= 0 && in[k.basic[i]]) z[k.basic[i]] = k.T[i][n];
  const outcome out = enumerate_add(p, z);
  if (out != listed) return out;

  char positive[most] = {0};
  simplex_mark_positive(&k, positive);
  for (int j = 0; j < n; j++)
    simplex_try_positive(&k, j, positive); /* (EN3) */
  if (k.pivots >= pivot_limit) return stalled;

  int J[most], count = 0, row_of[most]; /* (EN4) */
  for (int j = 0; j < n; j++)
    if (positive[j]) J[count++] = j;
  table T = {{0}};
  for (int i = 0; i < n; i++)
    for (int j = 0; j < count; j++)
      T[i][j] = in[J[j]] ? -p->M[i][J[j]] : i == J[j];
  if (enumerate_eliminate(T, n, count, row_of) == count) return listed;
  p->found.continua++;
  for (int j = 0; j < count; j++) {
    int moves = row_of[j] < 0;
    for (int l = 0; l < count && !moves; l++)
      moves = row_of[l] < 0 && fabs(T[row_of[j]][l]) > zero_tol;
    if (moves && in[J[j]]) p->found.undetermined[J[j]] = 1;
  }
  return listed;
}

/* ---- all of them ----------------------------------------------------------------------------- */

static void enumerate_prepare(problem *p) {
  const dls_lcp *lcp = p->lcp;
  const int n = p->n;
  double rho[most], gamma[most], work[9 * most], beta = 0;
  dlsi_lcp_weights(lcp, p->weights);
  dlsi_lcp_equilibrate(lcp, rho, gamma, work);
  for (int i = 0; i < n; i++) {
    rho[i] = dlsi_power_of_two(rho[i]);
    gamma[i] = dlsi_power_of_two(gamma[i]);
    p->q[i] = rho[i] * lcp->q[i];
    if (fabs(p->q[i]) > beta) beta = fabs(p->q[i]);
  }
  if (beta == 0) beta = 1;
  for (int j = 0; j < n; j++) {
    for (int i = 0; i < n; i++)
      p->M[i][j] = rho[i] * lcp->M.a[(size_t)i + (size_t)j * (size_t)lcp->M.ld] * gamma[j];
    p->q[j] /= beta;
    p->unit[j] = gamma[j] * beta;
  }
}

static dls_status enumerate_check(const dls_lcp *lcp, double tol, int capacity, const double *z,
                                  const dls_enumeration *found, dls_error *error) {
  const dls_status status = dlsi_check_dense_lcp(lcp, error);
  if (status) return status;
  if (lcp->n > most)
    return dlsi_fail(error, DLS_E_SIZE, "n", -1, lcp->n, "is %d, must be at most %d", lcp->n, most);
  if (!z) return dlsi_is_null(error, "z");
  if (!found) return dlsi_is_null(error, "found");
  const dlsi_setting own[] = {{"tol", tol, 0, DBL_MAX, 0}, {"capacity", capacity, 1, INT_MAX, 0}};
  return dlsi_check_each(2, own, error);
}

dls_status dls_lcp_enumerate(const dls_lcp *lcp, double tol, int capacity, double *z,
                             dls_enumeration *found, dls_error *error) {
  DLSI_DOOR;
  const dls_status status = enumerate_check(lcp, tol, capacity, z, found, error);
  if (status) return dlsi_at(__func__, status, error);
  const int n = lcp->n;
  problem p = {.lcp = lcp, .n = n, .tol = tol, .capacity = capacity, .list = z};
  enumerate_prepare(&p);
  outcome out = none;
  for (unsigned long set = 0; set < 1UL << n && out >= none; set++) {
    char in[most];
    int A[most], k = 0;
    for (int i = 0; i < n; i++) {
      in[i] = set >> i & 1;
      if (in[i]) A[k++] = i;
    }
    if (!enumerate_regular(&p, k, A, &out)) out = enumerate_singular(&p, in);
  }
  *found = p.found;
  return out == full ? DLS_MAX_ITERATIONS : out == stalled ? DLS_STALLED : DLS_OK;
}

/* ---- polyhedra of others --------------------------------------------------------------------- */

/* Finds a vertex of { x >= 0 : C x = q }. Returns as dlsi_find_vertex. */
static int cone_begin(cone *k, int n, const double *C) {
  *k = (cone){.n = n};
  for (int i = 0; i < n; i++)
    memcpy(k->T[i], C + (size_t)i * (size_t)(n + 1), (size_t)(n + 1) * sizeof *C);
  const int found = simplex_find_vertex(k);
  return k->pivots >= pivot_limit ? -1 : found;
}

int dlsi_find_vertex(int n, const double *C, double *x) {
  cone k;
  const int found = cone_begin(&k, n, C);
  if (found < 0) return -1;
  memset(x, 0, (size_t)n * sizeof *x);
  for (int i = 0; i < n && found; i++)
    if (k.basic[i] >= 0) x[k.basic[i]] = k.T[i][n];
  return found;
}

/* y: dual values of min sum of artificial variables; each row that is not met has one. */
int dlsi_refute_vertex(int n, const double *C, double slack, double *y) {
  cone k;
  table B; /* transposed: row j for the variable that is basic in row j */
  int row_of[most];
  if (cone_begin(&k, n, C) != 0) return 0;
  for (int j = 0; j < n; j++) {
    const int artificial = k.basic[j] < 0;
    for (int i = 0; i < n; i++)
      B[j][i] = !artificial ? C[i * (n + 1) + k.basic[j]] : 0;
    if (artificial) B[j][j] = C[j * (n + 1) + n] < 0 ? -1 : 1;
    B[j][n] = artificial ? 1 : -slack;
  }
  if (enumerate_eliminate(B, n, n, row_of) < n) return 0;
  for (int i = 0; i < n; i++)
    y[i] = B[row_of[i]][n];
  return 1;
}

/* Maximises c.x from a vertex. Returns the maximum, INFINITY if there is no bound. */
static double simplex_raise(cone *k, const double *c) {
  const int n = k->n;
  for (int e = 0; e < n && k->pivots < pivot_limit; e++) {
    double gain = c[e], step;
    for (int i = 0; i < n; i++)
      if (k->basic[i] >= 0) gain -= c[k->basic[i]] * k->T[i][e];
    if (!(gain > n * zero_tol)) continue;
    const int row = simplex_leaving_row(k, e, &step);
    if (row < 0) return INFINITY;
    simplex_enter(k, row, e);
    e = -1;
  }
  double value = 0;
  for (int i = 0; i < n; i++)
    if (k->basic[i] >= 0) value += c[k->basic[i]] * k->T[i][n];
  return value;
}

/* Returns the dimension of P (EN4), from a vertex. */
static int cone_dimension(cone *k, const double *C) {
  const int n = k->n;
  char positive[most] = {0};
  int count = 0, row_of[most];
  simplex_mark_positive(k, positive);
  for (int j = 0; j < n; j++)
    simplex_try_positive(k, j, positive);
  table T = {{0}};
  for (int j = 0; j < n; j++) {
    if (!positive[j]) continue;
    for (int i = 0; i < n; i++)
      T[i][count] = C[i * (n + 1) + j];
    count++;
  }
  return count - enumerate_eliminate(T, n, count, row_of);
}

int dlsi_spread(int n, const double *C, int count, const double *a, double *low, double *high) {
  cone k;
  if (cone_begin(&k, n, C) != 1) return -1;
  const int dimension = cone_dimension(&k, C);
  for (int l = 0; dimension > 0 && l < count && k.pivots < pivot_limit; l++) {
    double c[most];
    for (int j = 0; j < n; j++)
      c[j] = a[l * n + j];
    high[l] = simplex_raise(&k, c);
    for (int j = 0; j < n; j++)
      c[j] = -c[j];
    low[l] = -simplex_raise(&k, c);
  }
  return k.pivots >= pivot_limit ? -1 : dimension;
}
