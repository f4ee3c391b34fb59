/* test_reduction.c: the model's checks, W, q, recovery, the weighting of a line. */
#include "delassus.h"
#include "reduced.h"
#include "run.h"

/* ---- a model of any size, with room for its arrays ------------------------------------------- */

enum { max_n = 120, max_nodes = 60, max_m = 120 };

typedef struct host {
  int n, calls, most, fail_at, spoil;
  const double *inverse; /* n x n */
} host;

typedef struct fixture {
  double K[max_n * max_n], inverse[max_n * max_n];
  int Kp[max_n + 1], Ki[2 * max_n * max_n];
  double Kx[2 * max_n * max_n];
  int Np[max_nodes + 1], Ni[2 * max_nodes], Tp[2 * max_nodes + 1], Ti[4 * max_nodes];
  double Nx[2 * max_nodes], Tx[4 * max_nodes];
  int Pp[max_nodes + 1], Pi[3 * max_nodes];
  double Px[3 * max_nodes];
  double f[max_n], g[max_m], r[max_m];
  host user;
  dls_model model;
} fixture;

static fixture F; /* too large for a stack */
static unsigned long long seed;

/* uniform in (-1, 1) */
static double random_number(void) {
  seed = seed * 6364136223846793005ULL + 1442695040888963407ULL;
  return (double)(seed >> 11) / 4503599627370496.0 - 1;
}

/* X := inverse X, by hand */
static int host_solve(void *data, double *X, int n, int nrhs) {
  host *user = data;
  if (nrhs > user->most) user->most = nrhs;
  if (++user->calls == user->fail_at) return 7;
  double y[max_n];
  for (int j = 0; j < nrhs; j++) {
    double *x = X + (size_t)j * (size_t)n;
    for (int i = 0; i < n; i++) {
      y[i] = 0;
      for (int k = 0; k < n; k++)
        y[i] += user->inverse[i + n * k] * x[k];
    }
    memcpy(x, y, (size_t)n * sizeof *x);
  }
  if (user->spoil) X[(size_t)n * (size_t)nrhs - 1] = NAN;
  return 0;
}

/* inverse := K^-1 by Gauss-Jordan with pivots on the diagonal (K is diagonally dominant) */
static void invert(const double *K, double *inverse, int n) {
  static double A[max_n * max_n];
  memcpy(A, K, (size_t)(n * n) * sizeof *A);
  for (int k = 0; k < n; k++) {
    const double pivot = A[k + n * k];
    for (int j = 0; j < n; j++)
      if (j != k) A[k + n * j] /= pivot;
    for (int i = 0; i < n; i++)
      for (int j = 0; i != k && j < n; j++)
        if (j != k) A[i + n * j] -= A[i + n * k] * A[k + n * j];
    for (int i = 0; i < n; i++)
      if (i != k) A[i + n * k] /= -pivot;
    A[k + n * k] = 1 / pivot;
  }
  memcpy(inverse, A, (size_t)(n * n) * sizeof *A);
}

static dls_sparse sparse(int rows, int cols, const int *p, const int *i, const double *x) {
  return (dls_sparse){rows, cols, p, i, x};
}

/* The sparse form of F.K: every entry in two halves, in two places of its column. */
static void fill_sparse(int n) {
  int e = 0;
  for (int j = 0; j < n; j++) {
    F.Kp[j] = e;
    for (int half = 0; half < 2; half++)
      for (int i = n - 1; i >= 0; i--)
        if (F.K[i + n * j] != 0) {
          F.Ki[e] = i;
          F.Kx[e++] = F.K[i + n * j] / 2;
        }
  }
  F.Kp[n] = e;
  F.model.Ks = sparse(n, n, F.Kp, F.Ki, F.Kx);
}

/* Diagonally dominant K, coupled only among unknowns equal modulo `parts`; random operators with
 * two entries a column; weighted: each candidate on two nodes. */
static void make(int d, int n, int nodes, int parts, int symmetric, int weighted) {
  memset(&F, 0, sizeof F);
  seed = 1;
  for (int j = 0; j < n; j++)
    for (int i = 0; i < n; i++) {
      if ((i - j) % parts != 0) continue;
      const double a = random_number();
      F.K[i + n * j] = i == j ? n + a : symmetric && i < j ? F.K[j + n * i] : a;
    }
  for (int j = 0; symmetric && j < n; j++)
    for (int i = 0; i < j; i++)
      F.K[i + n * j] = F.K[j + n * i];
  invert(F.K, F.inverse, n);
  for (int k = 0; k < 2 * nodes; k++) {
    F.Ni[k] = (3 * k + k % 2) % n;
    F.Nx[k] = random_number();
    F.Np[(k + 1) / 2] = 2 * ((k + 1) / 2);
  }
  for (int k = 0; k < 2 * (d - 1) * nodes; k++) {
    F.Ti[k] = (5 * k + 2) % n;
    F.Tx[k] = random_number();
    F.Tp[(k + 1) / 2] = 2 * ((k + 1) / 2);
  }
  for (int k = 0; k < n; k++)
    F.f[k] = random_number();
  for (int k = 0; k < d * nodes; k++) {
    F.g[k] = random_number();
    F.r[k] = random_number();
  }
  F.user = (host){.n = n, .inverse = F.inverse};
  F.model = (dls_model){.d = d,
                        .n = n,
                        .nodes = nodes,
                        .operator_kind = DLS_STIFFNESS_DENSE,
                        .factorization = symmetric ? DLS_CHOLESKY : DLS_LU,
                        .K = {n, n, n, F.K},
                        .solve = host_solve,
                        .user = &F.user,
                        .HN = sparse(n, nodes, F.Np, F.Ni, F.Nx),
                        .HT = sparse(n, (d - 1) * nodes, F.Tp, F.Ti, F.Tx)};
  fill_sparse(n);
  if (!weighted) return;
  for (int j = 0; j < nodes - 1; j++) {
    F.Pp[j + 1] = 2 * (j + 1);
    F.Pi[2 * j] = j + 1;
    F.Pi[2 * j + 1] = j;
    F.Px[2 * j] = 0.25;
    F.Px[2 * j + 1] = 0.75;
  }
  F.model.P = sparse(nodes, nodes - 1, F.Pp, F.Pi, F.Px);
}

static int candidates(void) {
  return F.model.P.p ? F.model.P.cols : F.model.nodes;
}

/* y (d * nodes) := L^T x */
static void traces(const double *x, double *y) {
  const int d = F.model.d;
  for (int node = 0; node < F.model.nodes; node++)
    for (int c = 0; c < d; c++) {
      const dls_sparse *L = c ? &F.model.HT : &F.model.HN;
      const int j = c ? (d - 1) * node + c - 1 : node;
      double sum = 0;
      for (int k = L->p[j]; k < L->p[j + 1]; k++)
        sum += L->x[k] * x[L->i[k]];
      y[d * node + c] = sum;
    }
}

/* x (n) += L R */
static void add_loads(const double *R, double *x) {
  const int d = F.model.d;
  for (int node = 0; node < F.model.nodes; node++)
    for (int c = 0; c < d; c++) {
      const dls_sparse *L = c ? &F.model.HT : &F.model.HN;
      const int j = c ? (d - 1) * node + c - 1 : node;
      for (int k = L->p[j]; k < L->p[j + 1]; k++)
        x[L->i[k]] += L->x[k] * R[d * node + c];
    }
}

/* The systems are diagonally dominant, of condition about 3. */
static double rounding(void) {
  return 8 * F.model.n * DBL_EPSILON;
}

static dls_reduction *new_reduction(void) {
  dls_reduction *R = NULL;
  dls_error error = {0};
  const dls_status status = reduce_on_W(&R, &F.model, NULL, &error);
  ck_assert_msg(status == DLS_OK, "%s", error.message);
  return R;
}

/* A flexibility is the inverse of K. */
static void take_operator(int kind) {
  F.model.operator_kind = (dls_operator)kind;
  if (kind == DLS_FLEXIBILITY) F.model.K.a = F.inverse;
}

/* ---- closed forms ---------------------------------------------------------------------------- */

/* One node, unknowns (x, y), n = +y, t = +x: K = (2 -1; -1 3), K^-1 = (3 1; 1 2) / 5. */
static void make_two_springs(void) {
  make(2, 2, 1, 1, 1, 0);
  memcpy(F.K, (double[]){2, -1, -1, 3}, 4 * sizeof(double));
  memcpy(F.inverse, (double[]){0.6, 0.2, 0.2, 0.4}, 4 * sizeof(double));
  F.Ni[0] = 1;
  F.Ti[0] = 0;
  F.Nx[0] = F.Tx[0] = 1;
  F.Np[1] = F.Tp[1] = 1;
  fill_sparse(2);
}

TEST_EACH(springs_by_hand, 0, 5) {
  make_two_springs();
  if (_i == 4)
    F.model.factorization = DLS_LU;
  else
    take_operator(1 + _i);
  dls_reduction *R = new_reduction();
  dls_contact p = contact_of(R);
  assert_close(p.W.a, (double[]){0.4, 0.2, 0.2, 0.6}, 4, 4 * DBL_EPSILON);
  assert_close(p.q, (double[]){0, 0}, 2, 0);
  ck_assert_int_eq(dls_reduction_load(R, (double[]){5, -10}, (double[]){0.5, 0}, NULL), DLS_OK);
  assert_close(p.q, (double[]){-2.5, 1}, 2, 8 * DBL_EPSILON);
  /* r = (10, -5) holds the load: x = 0 */
  double x[2] = {9, 9}, left[2], R2[2];
  ck_assert_int_eq(dls_reduction_recover(R, (double[]){10, -5}, x, NULL), DLS_OK);
  ck_assert_double_le(largest(x, 2), 16 * DBL_EPSILON);
  ck_assert_int_eq(dls_reduction_recover(R, (double[]){0, 0}, left, NULL), DLS_OK);
  assert_close(left, (double[]){1, -3}, 2, 8 * DBL_EPSILON);
  ck_assert_int_eq(dls_reduction_nodal(R, (double[]){10, -5}, R2, NULL), DLS_OK);
  assert_close(R2, (double[]){10, -5}, 2, 0);
  /* gap alone, then nothing at all */
  ck_assert_int_eq(dls_reduction_load(R, NULL, (double[]){0.5, 2}, NULL), DLS_OK);
  assert_close(p.q, (double[]){0.5, 2}, 2, 0);
  ck_assert_int_eq(dls_reduction_load(R, NULL, NULL, NULL), DLS_OK);
  assert_close(p.q, (double[]){0, 0}, 2, 0);
  ck_assert_int_eq(dls_reduction_recover(R, (double[]){10, -5}, x, NULL), DLS_OK);
  assert_close(x, (double[]){-1, 3}, 2, 8 * DBL_EPSILON); /* K^-1 (-5, 10) */
  dls_reduction_destroy(R);
}

/* K = (2 1; 0 1), K^-1 = (1/2 -1/2; 0 1): in the order (n, t) = (y, x), W = (1 0; -1/2 1/2). */
TEST_EACH(unsymmetric_by_hand, 0, 2) {
  make_two_springs();
  memcpy(F.K, (double[]){2, 0, 1, 1}, 4 * sizeof(double));
  fill_sparse(2);
  F.model.factorization = DLS_LU;
  F.model.operator_kind = _i ? DLS_STIFFNESS_SPARSE : DLS_STIFFNESS_DENSE;
  dls_reduction *R = new_reduction();
  assert_close(contact_of(R).W.a, (double[]){1, -0.5, 0, 0.5}, 4, 4 * DBL_EPSILON);
  dls_reduction_destroy(R);
}

/* ---- the mechanics, without regard to how W is made ------------------------------------------ */

/* K x = f + L P r and P^T (L^T x + g) = W r + q, R = P r */
static void assert_mechanics(dls_reduction *R) {
  const int d = F.model.d, n = F.model.n, nc = candidates(), m = d * nc;
  const dls_contact p = contact_of(R);
  ck_assert_int_eq(p.nc, nc);
  ck_assert_int_eq(dls_reduction_load(R, F.f, F.g, NULL), DLS_OK);
  double x[max_n], load[max_n], Kx[max_n] = {0}, nodal[max_m], weighted[max_m] = {0}, y[max_m];
  double u[max_m], expected[max_m] = {0};
  ck_assert_int_eq(dls_reduction_recover(R, F.r, x, NULL), DLS_OK);
  ck_assert_int_eq(dls_reduction_nodal(R, F.r, nodal, NULL), DLS_OK);
  for (int j = 0; j < nc; j++)
    for (int k = F.model.P.p ? F.Pp[j] : j; k < (F.model.P.p ? F.Pp[j + 1] : j + 1); k++)
      for (int c = 0; c < d; c++)
        weighted[d * (F.model.P.p ? F.Pi[k] : k) + c] +=
            (F.model.P.p ? F.Px[k] : 1) * F.r[d * j + c];
  assert_close(nodal, weighted, d * F.model.nodes, 4 * DBL_EPSILON);
  memcpy(load, F.f, (size_t)n * sizeof *load);
  add_loads(nodal, load);
  for (int j = 0; j < n; j++)
    for (int i = 0; i < n; i++)
      Kx[i] += F.K[i + n * j] * x[j];
  assert_close(Kx, load, n, rounding());
  traces(x, y);
  for (int j = 0; j < nc; j++)
    for (int k = F.model.P.p ? F.Pp[j] : j; k < (F.model.P.p ? F.Pp[j + 1] : j + 1); k++)
      for (int c = 0; c < d; c++) {
        const int node = F.model.P.p ? F.Pi[k] : k;
        expected[d * j + c] += (F.model.P.p ? F.Px[k] : 1) * (y[d * node + c] + F.g[d * node + c]);
      }
  memcpy(u, p.q, (size_t)m * sizeof *u);
  for (int j = 0; j < m; j++)
    for (int i = 0; i < m; i++)
      u[i] += p.W.a[i + m * j] * F.r[j];
  assert_close(u, expected, m, rounding());
}

/* Copies the W of F.model (size bytes). */
static void copy_W(double *W, size_t size) {
  dls_reduction *R = new_reduction();
  memcpy(W, contact_of(R).W.a, size);
  dls_reduction_destroy(R);
}

TEST_EACH(all_operators_agree, 0, 4) {
  const int weighted = _i % 2, d = 2 + _i / 2 % 2;
  double W[max_m * max_m];
  for (int kind = 0; kind < 6; kind++) {
    make(d, 30, 6, 1, 1, weighted);
    if (kind >= 4) F.model.factorization = DLS_LU;
    take_operator(kind < 4 ? kind + 1 : kind - 3);
    dls_reduction *R = new_reduction();
    const dls_contact p = contact_of(R);
    const int m = d * p.nc;
    if (kind == 0) memcpy(W, p.W.a, (size_t)(m * m) * sizeof *W);
    assert_close(p.W.a, W, m * m, rounding());
    for (int j = 0; kind < 2 && j < m; j++) /* Cholesky: exactly symmetric */
      for (int i = 0; i < j; i++)
        ck_assert(p.W.a[i + m * j] == p.W.a[j + m * i]);
    assert_mechanics(R);
    dls_reduction_destroy(R);
  }
}

TEST_EACH(unsymmetric_stiffness, 0, 4) {
  make(2 + _i / 2, 30, 6, 1, 0, 1);
  if (_i % 2) F.model.operator_kind = DLS_STIFFNESS_SPARSE;
  dls_reduction *R = new_reduction();
  assert_mechanics(R);
  dls_reduction_destroy(R);
}

/* Parts that interlace (unknowns equal modulo 7, say; one unknown each for 42), some not loaded. */
TEST_EACH(connected_parts, 0, 4) {
  const int parts[] = {2, 7, 20, 42};
  for (int symmetric = 0; symmetric < 2; symmetric++) {
    make(3, 42, 4, parts[_i], symmetric, 0);
    F.model.operator_kind = DLS_STIFFNESS_SPARSE;
    dls_reduction *R = new_reduction();
    assert_mechanics(R);
    dls_reduction_destroy(R);
  }
}

/* Only the lower triangle is read for Cholesky; the leading dimension is obeyed. */
TEST(lower_triangle) {
  make(2, 10, 3, 1, 1, 0);
  double W[36], wide[10 * 13];
  copy_W(W, sizeof W);
  for (int j = 0; j < 10; j++)
    for (int i = 0; i < 13; i++)
      wide[i + 13 * j] = i < 10 && i >= j ? F.K[i + 10 * j] : NAN;
  F.model.K = (dls_dense){10, 10, 13, wide};
  dls_reduction *R = new_reduction();
  ck_assert_mem_eq(contact_of(R).W.a, W, sizeof W);
  dls_reduction_destroy(R);
}

/* More columns than a batch holds; the host sees at most 64, then single ones. */
TEST(batches) {
  make(2, 100, 50, 1, 1, 0);
  static double W[100 * 100];
  copy_W(W, sizeof W);
  F.model.operator_kind = DLS_HOST_SOLVER;
  dls_reduction *R = new_reduction();
  assert_close(contact_of(R).W.a, W, 100 * 100, rounding());
  ck_assert_int_eq(F.user.calls, 2);
  ck_assert_int_eq(F.user.most, 64);
  F.user.most = 0;
  assert_mechanics(R);
  ck_assert_int_eq(F.user.most, 1);
  dls_reduction_destroy(R);
}

/* Tangents that a frictionless model leaves empty: their rows and columns of W are zero. */
TEST_EACH(empty_tangents, 0, 4) {
  make(2, 12, 4, 1, 1, 0);
  memset(F.Tp, 0, sizeof F.Tp);
  take_operator(1 + _i);
  dls_reduction *R = new_reduction();
  const dls_contact p = contact_of(R);
  for (int j = 0; j < 8; j++)
    for (int i = 0; i < 8; i++)
      ck_assert((p.W.a[i + 8 * j] == 0) == (i % 2 || j % 2));
  assert_mechanics(R);
  dls_reduction_destroy(R);
}

TEST_EACH(same_bits_twice, 0, 8) {
  make(2, 40, 10, 2, _i % 2, 1);
  take_operator(1 + _i / 2);
  double W[18 * 18], q[18];
  for (int turn = 0; turn < 2; turn++) {
    dls_reduction *R = new_reduction();
    const dls_contact p = contact_of(R);
    ck_assert_int_eq(dls_reduction_load(R, F.f, F.g, NULL), DLS_OK);
    if (turn == 0) {
      memcpy(W, p.W.a, sizeof W);
      memcpy(q, p.q, sizeof q);
    }
    ck_assert_mem_eq(p.W.a, W, sizeof W);
    ck_assert_mem_eq(p.q, q, sizeof q);
    dls_reduction_destroy(R);
  }
}

/* ---- units ----------------------------------------------------------------------------------- */

TEST_EACH(units, 0, 12) {
  const double force[] = {1e-9, 1e9, 1, 1, 1e-9, 1e9}, unit[] = {1, 1, 1e-9, 1e9, 1e9, 1e-9};
  const double b = force[_i % 6], a = unit[_i % 6];
  for (int kind = 0; kind < 4; kind++) {
    make(2, 24, 5, 3, _i / 6, 1);
    take_operator(1 + kind);
    dls_reduction *R = new_reduction();
    double W[64], q[8];
    ck_assert_int_eq(dls_reduction_load(R, F.f, F.g, NULL), DLS_OK);
    for (int i = 0; i < 64; i++)
      W[i] = a / b * contact_of(R).W.a[i];
    for (int i = 0; i < 8; i++)
      q[i] = a * contact_of(R).q[i];
    dls_reduction_destroy(R);
    for (int k = 0; k < 24 * 24; k++) {
      F.K[k] *= b / a;
      F.inverse[k] *= a / b;
    }
    for (int k = 0; k < F.Kp[24]; k++)
      F.Kx[k] *= b / a;
    for (int k = 0; k < 24; k++)
      F.f[k] *= b;
    for (int k = 0; k < 10; k++)
      F.g[k] *= a;
    R = new_reduction();
    ck_assert_int_eq(dls_reduction_load(R, F.f, F.g, NULL), DLS_OK);
    assert_close(contact_of(R).W.a, W, 64, rounding());
    assert_close(contact_of(R).q, q, 8, rounding());
    dls_reduction_destroy(R);
  }
}

/* Unknowns in three units (displacements, rotations, ...): K is then of condition 1e36 as it
 * stands; W of the unknowns that keep their unit stays the same. */
TEST_EACH(mixed_units, 0, 8) {
  const double scale[] = {1, _i % 2 ? 1e9 : 1e-9, _i % 2 ? 1e-9 : 1e9};
  make(2, 21, 2, 1, _i / 2 % 2, 0);
  for (int k = 0; k < 4; k++) {
    F.Ni[k] -= F.Ni[k] % 3;
    F.Ti[k] -= F.Ti[k] % 3;
  }
  double W[16];
  copy_W(W, sizeof W);
  for (int j = 0; j < 21; j++)
    for (int i = 0; i < 21; i++)
      F.K[i + 21 * j] *= scale[i % 3] * scale[j % 3];
  fill_sparse(21);
  if (_i / 4) F.model.operator_kind = DLS_STIFFNESS_SPARSE;
  dls_reduction *R = new_reduction();
  assert_close(contact_of(R).W.a, W, 16, rounding());
  dls_reduction_destroy(R);
}

/* ---- matrices that have no inverse ----------------------------------------------------------- */

static void assert_create_fails(dls_status status, const char *argument, long long index,
                                dls_error *error) {
  int mark;
  dls_reduction *R = (dls_reduction *)(void *)&mark;
  dls_error own, *e = error ? error : &own;
  memset(e, 0, sizeof *e);
  const dls_status answer = reduce_on_W(&R, &F.model, NULL, e);
  ck_assert_msg(answer == status, "%s instead of %s (%s): %s", dls_status_name(answer),
                dls_status_name(status), argument, e->message);
  ck_assert_ptr_null(R);
  ck_assert_int_eq(e->status, status);
  ck_assert_str_eq(e->function, "dls_reduction_create");
  ck_assert_msg(strcmp(e->argument, argument) == 0, "%s instead of %s", e->argument, argument);
  ck_assert_msg(e->index == index, "%s[%lld] instead of %lld", argument, e->index, index);
  ck_assert_int_eq(reduce_on_W(&R, &F.model, NULL, NULL), status);
}

/* A 2 x 2 matrix as K, dense or as the part {1, 3} of a sparse one with unknowns 0, 2, 4 beside
 * it. */
static void make_small(int sparse_form, dls_factorization factorization, double k00, double k10,
                       double k01, double k11) {
  make(2, sparse_form ? 5 : 2, 1, 1, 1, 0);
  const int n = F.model.n, i = sparse_form ? 1 : 0, j = sparse_form ? 3 : 1;
  memset(F.K, 0, sizeof F.K);
  for (int k = 0; k < n; k++)
    F.K[k + n * k] = 1;
  F.K[i + n * i] = k00;
  F.K[j + n * i] = k10;
  F.K[i + n * j] = k01;
  F.K[j + n * j] = k11;
  fill_sparse(n);
  F.model.factorization = factorization;
  F.model.operator_kind = sparse_form ? DLS_STIFFNESS_SPARSE : DLS_STIFFNESS_DENSE;
}

/* One null vector, largest at one of two unknowns. */
static void assert_one_mode(const char *K, int first, int last) {
  dls_reduction *R = NULL;
  dls_error error = {0};
  ck_assert_int_eq(reduce_on_W(&R, &F.model, NULL, &error), DLS_E_SINGULAR);
  ck_assert_ptr_null(R);
  ck_assert_str_eq(error.argument, K);
  ck_assert(error.index == first || error.index == last);
  ck_assert_ptr_nonnull(strstr(error.message, "; W needs bodies that are held, K does not"));
}

TEST_EACH(singular_matrices, 0, 2) {
  const char *K = _i ? "Ks" : "K";
  const int first = _i ? 1 : 0, last = _i ? 3 : 1;
  dls_error error;
  /* a spring between two unknowns, held nowhere */
  make_small(_i, DLS_LU, 1, -1, -1, 1);
  assert_one_mode(K, first, last);
  make_small(_i, DLS_CHOLESKY, 1, -1, -1, 1);
  assert_one_mode(K, first, last);
  make_small(_i, DLS_LDLT, 1, -1, -1, 1);
  assert_one_mode(K, first, last);
  /* held by rounding alone: the pivot is positive */
  make_small(_i, DLS_CHOLESKY, 1, 1, 1, 1 + 4 * DBL_EPSILON);
  assert_one_mode(K, first, last);
  make_small(_i, DLS_LU, 1, 1, 1, 1 + 4 * DBL_EPSILON);
  assert_one_mode(K, first, last);
  /* held well enough */
  make_small(_i, DLS_CHOLESKY, 1, 1, 1, 1 + 1000 * DBL_EPSILON);
  dls_reduction_destroy(new_reduction());
  make_small(_i, DLS_LU, 1, 1, 1, 1 + 1000 * DBL_EPSILON);
  dls_reduction_destroy(new_reduction());
  /* indefinite: pivot 1 - 2^2 */
  make_small(_i, DLS_CHOLESKY, 1, 2, 2, 1);
  assert_create_fails(DLS_E_NOT_POSITIVE_DEFINITE, K, last, &error);
  ck_assert(error.value == -3);
  make_small(_i, DLS_CHOLESKY, -2, 0.5, 0.5, 1);
  assert_create_fails(DLS_E_NOT_POSITIVE_DEFINITE, K, first, &error);
  ck_assert(error.value == -1);
  /* an empty column, an empty row, for LU; a negative diagonal is no obstacle */
  make_small(_i, DLS_LU, 0, 0, 1, 1);
  assert_one_mode(K, first, first);
  make_small(_i, DLS_LU, 1, 0, 1, 0);
  assert_one_mode(K, first, last);
  make_small(_i, DLS_LU, 0, 1, -1, -1);
  dls_reduction_destroy(new_reduction());
}

/* A free truss: a grid of squares with both diagonals, three rigid-body modes; bars of stiffness 1.
 * Never W, whatever the order of the unknowns. Held at three unknowns it passes. */
TEST_EACH(free_body, 0, 10) {
  const int side = 5, n = 2 * side * side;
  make(2, n, 2, 1, 1, 0);
  memset(F.K, 0, sizeof F.K);
  for (int node = 0; node < side * side; node++)
    for (int bar = 0; bar < 4; bar++) {
      const int dx[] = {1, 0, 1, -1}, dy[] = {0, 1, 1, 1};
      const int column = node % side + dx[bar], row = node / side + dy[bar];
      if (column < 0 || column >= side || row >= side) continue;
      const int other = column + side * row;
      const double l = hypot(dx[bar], dy[bar]), cx = dx[bar] / l, cy = dy[bar] / l;
      const double c[] = {-cx, -cy, cx, cy};
      int at[] = {2 * node, 2 * node + 1, 2 * other, 2 * other + 1};
      for (int k = 0; k < 4; k++)
        at[k] = (at[k] * 7 + _i) % n; /* 7 and n have no common factor */
      for (int j = 0; j < 4; j++)
        for (int i = 0; i < 4; i++)
          F.K[at[i] + n * at[j]] += c[i] * c[j];
    }
  fill_sparse(n);
  for (int kind = 0; kind < 4; kind++) {
    F.model.operator_kind = kind % 2 ? DLS_STIFFNESS_SPARSE : DLS_STIFFNESS_DENSE;
    F.model.factorization = kind / 2 ? DLS_LU : DLS_CHOLESKY;
    dls_reduction *R = NULL;
    dls_error error;
    const dls_status status = reduce_on_W(&R, &F.model, NULL, &error);
    ck_assert_int_eq(status, DLS_E_SINGULAR);
    ck_assert_ptr_null(R);
    ck_assert(error.index >= 0 && error.index < n);
  }
  const int held[] = {0, 1, 3};
  for (int k = 0; k < 3; k++) {
    const int i = (held[k] * 7 + _i) % n;
    F.K[i + n * i] += 1;
  }
  F.model.operator_kind = DLS_STIFFNESS_DENSE;
  for (int kind = 0; kind < 2; kind++) {
    F.model.factorization = kind ? DLS_LU : DLS_CHOLESKY;
    dls_reduction_destroy(new_reduction());
  }
}

TEST(part_too_large) {
  enum { n = 8001 };
  static int p[n + 1], i[2 * n];
  static double x[2 * n];
  make(2, 4, 1, 1, 1, 0);
  for (int j = 0; j < n; j++) { /* a chain from unknown 0 to the last */
    p[j + 1] = 2 * (j + 1);
    i[2 * j] = j;
    i[2 * j + 1] = j ? j - 1 : 0;
    x[2 * j] = 2;
    x[2 * j + 1] = -0.5;
  }
  F.model.n = n;
  F.model.operator_kind = DLS_STIFFNESS_SPARSE;
  F.model.factorization = DLS_LU;
  F.model.Ks = sparse(n, n, p, i, x);
  F.model.HN.rows = F.model.HT.rows = n;
  if (WITH_MUMPS) {
    dls_reduction_destroy(new_reduction());
    return;
  }
  dls_error error;
  assert_create_fails(DLS_E_UNSUPPORTED, "Ks", 0, &error);
  ck_assert(error.value == n);
  ck_assert_ptr_nonnull(strstr(error.message, "8001"));
  ck_assert_ptr_nonnull(strstr(error.message, "8000"));
}

TEST(overflows) {
  make_small(1, DLS_LU, 1, 0.5, 0.5, 1);
  for (int k = 0; k < F.Kp[5]; k++)
    if (F.Ki[k] == 3 && k >= F.Kp[3]) F.Kx[k] = 1e308;
  assert_create_fails(DLS_E_NOT_FINITE, "Ks", 3, NULL);
  make_two_springs();
  for (int k = 0; k < 4; k++)
    F.K[k] *= 1e-300;
  F.Nx[0] = 1e200;
  assert_create_fails(DLS_E_NOT_FINITE, "W", 0, NULL);

  make_two_springs();
  for (int k = 0; k < 4; k++)
    F.K[k] *= 1e-300;
  dls_reduction *R = new_reduction();
  ck_assert_int_eq(dls_reduction_load(R, (double[]){0, 1e-300}, NULL, NULL), DLS_OK);
  const double q = contact_of(R).q[0];
  REFUSES(NOT_FINITE, "q", 0, dls_reduction_load, R, (double[]){0, 1e200}, NULL);
  ck_assert(contact_of(R).q[0] == q);
  double x[2] = {5, 5};
  REFUSES(NOT_FINITE, "x", 0, dls_reduction_recover, R, (double[]){1e200, 0}, x);
  ck_assert(x[0] == 5 && x[1] == 5);
  dls_reduction_destroy(R);
}

/* ---- which unknown a bad K names ------------------------------------------------------------- */

/* Three chains whose unknowns interlace: link k of chain c is unknown 3 k + c, so that the position
 * of an unknown in its part is not its number. Chains 0 and 2 are sound. Chain 1 is L L^T with
 * small integers: every pivot is exact, in whatever order LAPACK works. */
enum { links = 10, bad_link = 6, chained = 3 * links };

/* Returns L_ij: 1 on the diagonal, `pivot` at bad_link, and links to the one before; link bad_link
 * + 1 passes bad_link by, so that nothing after the bad pivot depends on it. */
static double chain_factor(int i, int j, double pivot) {
  if (i == j) return i == bad_link ? pivot : 1;
  if (i == bad_link + 1) return j == bad_link - 1 ? -1 : 0;
  return i == j + 1 ? -1 : 0;
}

static double *chain_entry(int chain, int i, int j) {
  return &F.K[3 * i + chain + chained * (3 * j + chain)];
}

static void make_chains(double pivot) {
  make(2, chained, 3, 1, 1, 0);
  memset(F.K, 0, sizeof F.K);
  for (int j = 0; j < links; j++)
    for (int i = 0; i < links; i++) {
      *chain_entry(0, i, j) = *chain_entry(2, i, j) = i == j ? 3 : abs(i - j) == 1 ? -1 : 0;
      for (int k = 0; k < links; k++)
        *chain_entry(1, i, j) += chain_factor(i, k, pivot) * chain_factor(j, k, pivot);
    }
}

enum { zero_pivot, tiny_pivot, negative_pivot, negative_diagonal, zero_row, zero_column, kinds };

static int is_factored(dls_factorization tag, int kind) {
  if (kind == zero_row || kind == zero_column) return tag == DLS_LU;
  return tag == DLS_CHOLESKY || kind == zero_pivot || kind == tiny_pivot;
}

/* Sparse parts and a dense K, by each factorisation, as it is and with units that differ from
 * unknown to unknown by powers of two. */
TEST_EACH(bad_stiffness_names_its_unknown, 0, 72) {
  const int kind = _i / 4 % kinds, scaled = _i / 2 % 2, dense = _i % 2, bad = 3 * bad_link + 1;
  const dls_factorization tag = (dls_factorization)(1 + _i / (4 * kinds));
  if (!is_factored(tag, kind)) return;
  make_chains(kind == tiny_pivot ? 0x1p-26 : 0);
  if (kind == negative_pivot) F.K[bad + chained * bad] -= 0.25;
  if (kind == negative_diagonal) F.K[bad + chained * bad] = -1;
  for (int k = 0; k < chained; k++) {
    if (kind == zero_row) F.K[bad + chained * k] = 0;
    if (kind == zero_column) F.K[k + chained * bad] = 0;
  }
  for (int i = 0; i < chained; i++) {
    const double unit = scaled ? ldexp(1, 7 * i % 41 - 20) : 1;
    for (int j = 0; j < chained; j++) {
      F.K[i + chained * j] *= unit;
      F.K[j + chained * i] *= unit;
    }
  }
  fill_sparse(chained);
  F.model.operator_kind = dense ? DLS_STIFFNESS_DENSE : DLS_STIFFNESS_SPARSE;
  F.model.factorization = tag;
  dls_reduction *R = NULL;
  dls_error error = {0};
  const dls_status status = reduce_on_W(&R, &F.model, NULL, &error);
  const int indefinite =
      tag == DLS_CHOLESKY && (kind == negative_pivot || kind == negative_diagonal);
  ck_assert_msg(status == (indefinite ? DLS_E_NOT_POSITIVE_DEFINITE : DLS_E_SINGULAR), "%d: %s", _i,
                error.message);
  ck_assert_str_eq(error.argument, dense ? "K" : "Ks");
  ck_assert_msg(error.index == bad, "%d: %s", _i, error.message);
}

/* An x that overflows, and entries of one place that add up to Inf. */
TEST_EACH(overflow_names_its_unknown, 0, 2) {
  const int bad = 3 * bad_link + 1;
  make_chains(1);
  for (int k = 0; k < chained; k++) {
    F.K[bad + chained * k] = F.K[k + chained * bad] = k == bad ? 0x1p-100 : 0;
    F.f[k] = k == bad ? 0x1p+960 : 0;
  }
  fill_sparse(chained);
  F.model.operator_kind = _i ? DLS_STIFFNESS_DENSE : DLS_STIFFNESS_SPARSE;
  memset(F.Np, 0, sizeof F.Np); /* with H = 0 no q overflows */
  memset(F.Tp, 0, sizeof F.Tp);
  dls_reduction *R = new_reduction();
  dls_error error = {0};
  double x[chained], r[6] = {0};
  ck_assert_int_eq(dls_reduction_load(R, F.f, NULL, NULL), DLS_OK);
  REFUSES(NOT_FINITE, "x", bad, dls_reduction_recover, R, r, x);
  dls_reduction_destroy(R);
  if (_i) return;
  make_chains(1);
  F.model.operator_kind = DLS_STIFFNESS_SPARSE;
  F.model.factorization = DLS_LU;
  fill_sparse(chained);
  for (int k = F.Kp[bad]; k < F.Kp[bad + 1]; k++) /* off the diagonal: the column is named */
    if (F.Ki[k] == bad - 3) F.Kx[k] = DBL_MAX;
  ck_assert_int_eq(reduce_on_W(&R, &F.model, NULL, &error), DLS_E_NOT_FINITE);
  ck_assert_str_eq(error.argument, "Ks");
  ck_assert_int_eq(error.index, bad);
}

/* ---- the callback ---------------------------------------------------------------------------- */

TEST(callback_fails) {
  make(2, 100, 50, 1, 1, 0);
  F.model.operator_kind = DLS_HOST_SOLVER;
  dls_error error;
  F.user.fail_at = 2;
  int mark;
  dls_reduction *R = (dls_reduction *)(void *)&mark;
  ck_assert_int_eq(reduce_on_W(&R, &F.model, NULL, &error), DLS_E_CALLBACK);
  ck_assert_ptr_null(R);
  ck_assert_str_eq(error.argument, "solve");
  ck_assert(error.value == 7);
  F.user.fail_at = 0;
  F.user.spoil = 1;
  assert_create_fails(DLS_E_CALLBACK, "solve", 99, NULL);
  F.user.spoil = 0;

  R = new_reduction();
  ck_assert_int_eq(dls_reduction_load(R, F.f, F.g, NULL), DLS_OK);
  double q[100], x[100], before[100], twice[100];
  memcpy(q, contact_of(R).q, sizeof q);
  ck_assert_int_eq(dls_reduction_recover(R, F.r, before, NULL), DLS_OK);
  for (int k = 0; k < 100; k++) {
    twice[k] = 2 * F.f[k];
    x[k] = 5;
  }
  for (int spoil = 0; spoil < 2; spoil++) {
    F.user.spoil = spoil;
    F.user.fail_at = spoil ? 0 : F.user.calls + 1;
    ck_assert_int_eq(dls_reduction_load(R, twice, NULL, &error), DLS_E_CALLBACK);
    ck_assert_str_eq(error.function, "dls_reduction_load");
    ck_assert_int_eq(error.index, spoil ? 99 : -1);
    ck_assert_mem_eq(contact_of(R).q, q, sizeof q);
    F.user.fail_at = spoil ? 0 : F.user.calls + 1;
    ck_assert_int_eq(dls_reduction_recover(R, F.r, x, &error), DLS_E_CALLBACK);
    ck_assert_str_eq(error.function, "dls_reduction_recover");
    assert_all(x, 100, 5);
  }
  F.user.spoil = 0; /* f is still the first one */
  ck_assert_int_eq(dls_reduction_recover(R, F.r, x, NULL), DLS_OK);
  ck_assert_mem_eq(x, before, sizeof x);
  dls_reduction_destroy(R);
}

/* 64 columns are one batch, and none is asked for after them. */
TEST(whole_batches) {
  make(2, 100, 32, 1, 1, 0);
  F.model.operator_kind = DLS_HOST_SOLVER;
  dls_reduction *R = new_reduction();
  ck_assert(F.user.calls == 1 && F.user.most == 64);
  dls_reduction_destroy(R);
}

/* ---- bad input ------------------------------------------------------------------------------- */

/* make(), one change, and what both check and create must say of it */
#define BAD(change, status, name, place)                                                           \
  do {                                                                                             \
    make(2, 6, 3, 1, symmetric, 1);                                                                \
    F.model.operator_kind = kind;                                                                  \
    change;                                                                                        \
    dls_error e_;                                                                                  \
    ck_assert_int_eq(dls_model_check(&F.model, &e_), status);                                      \
    ck_assert_str_eq(e_.argument, name);                                                           \
    ck_assert_int_eq(e_.index, place);                                                             \
    ck_assert_str_eq(e_.function, "dls_model_check");                                              \
    assert_create_fails(status, name, place, NULL);                                                \
  } while (0)

TEST_EACH(bad_model, 0, 8) {
  const dls_operator kind = (dls_operator)(1 + _i / 2);
  const int symmetric = _i % 2;
  make(2, 6, 3, 1, symmetric, 1);
  F.model.operator_kind = kind;
  ck_assert_int_eq(dls_model_check(&F.model, NULL), DLS_OK);

  BAD(F.model.d = 1, DLS_E_ARGUMENT, "d", -1);
  BAD(F.model.d = 4, DLS_E_ARGUMENT, "d", -1);
  BAD(F.model.n = 0, DLS_E_SIZE, "n", -1);
  BAD(F.model.nodes = -1, DLS_E_SIZE, "nodes", -1);
  BAD(F.model.nodes = 1 << 30, DLS_E_SIZE, "nodes", -1);
  BAD(F.model.operator_kind = (dls_operator)0, DLS_E_ARGUMENT, "operator_kind", -1);
  BAD(F.model.operator_kind = (dls_operator)5, DLS_E_ARGUMENT, "operator_kind", -1);

  if (kind == DLS_STIFFNESS_DENSE || kind == DLS_STIFFNESS_SPARSE) {
    BAD(F.model.factorization = (dls_factorization)0, DLS_E_ARGUMENT, "factorization", -1);
    BAD(F.model.factorization = (dls_factorization)4, DLS_E_ARGUMENT, "factorization", -1);
  }
  if (kind == DLS_STIFFNESS_DENSE || kind == DLS_FLEXIBILITY) {
    BAD(F.model.K.a = NULL, DLS_E_ARGUMENT, "K", -1);
    BAD(F.model.K.rows = 5, DLS_E_SIZE, "K", -1);
    BAD(F.model.K.cols = 7, DLS_E_SIZE, "K", -1);
    BAD(F.model.K.ld = 5, DLS_E_SIZE, "K", -1);
    BAD(F.K[35] = NAN, DLS_E_NOT_FINITE, "K", 35);
    BAD(F.K[8] = INFINITY, DLS_E_NOT_FINITE, "K", 8);
    BAD(F.K[0] = -INFINITY, DLS_E_NOT_FINITE, "K", 0);
  }
  if (kind == DLS_STIFFNESS_SPARSE) {
    BAD(F.model.Ks.p = NULL, DLS_E_ARGUMENT, "Ks", -1);
    BAD(F.model.Ks.i = NULL, DLS_E_ARGUMENT, "Ks", -1);
    BAD(F.model.Ks.x = NULL, DLS_E_ARGUMENT, "Ks", -1);
    BAD(F.model.Ks.rows = 5, DLS_E_SIZE, "Ks", -1);
    BAD(F.model.Ks.cols = 5, DLS_E_SIZE, "Ks", -1);
    BAD(F.Kp[0] = 1, DLS_E_ARGUMENT, "Ks", 0);
    BAD(F.Kp[2] = 5, DLS_E_ARGUMENT, "Ks", 2);
    BAD(F.Ki[9] = 6, DLS_E_ARGUMENT, "Ks", 9);
    dls_error outside;
    ck_assert_int_eq(dls_model_check(&F.model, &outside), DLS_E_ARGUMENT);
    ck_assert_ptr_nonnull(strstr(outside.message, "outside of 0 .. 5"));
    BAD(F.Ki[0] = -1, DLS_E_ARGUMENT, "Ks", 0);
    BAD(F.Kx[71] = NAN, DLS_E_NOT_FINITE, "Ks", 71);
  }
  if (kind == DLS_HOST_SOLVER) BAD(F.model.solve = NULL, DLS_E_ARGUMENT, "solve", -1);

  BAD(F.model.HN.p = NULL, DLS_E_ARGUMENT, "HN", -1);
  BAD(F.model.HN.i = NULL, DLS_E_ARGUMENT, "HN", -1);
  BAD(F.model.HN.x = NULL, DLS_E_ARGUMENT, "HN", -1);
  BAD(F.model.HN.rows = 7, DLS_E_SIZE, "HN", -1);
  BAD(F.model.HN.cols = 2, DLS_E_SIZE, "HN", -1);
  BAD(F.Np[0] = -1, DLS_E_ARGUMENT, "HN", 0);
  BAD(F.Np[2] = 1, DLS_E_ARGUMENT, "HN", 2);
  BAD(F.Ni[5] = 6, DLS_E_ARGUMENT, "HN", 5);
  BAD(F.Nx[5] = NAN, DLS_E_NOT_FINITE, "HN", 5);
  BAD(F.model.HT.p = NULL, DLS_E_ARGUMENT, "HT", -1);
  BAD(F.model.HT.i = NULL, DLS_E_ARGUMENT, "HT", -1);
  BAD(F.model.HT.x = NULL, DLS_E_ARGUMENT, "HT", -1);
  BAD(F.model.HT.rows = 7, DLS_E_SIZE, "HT", -1);
  BAD(F.model.HT.cols = 6, DLS_E_SIZE, "HT", -1);
  BAD(F.Tp[0] = 1, DLS_E_ARGUMENT, "HT", 0);
  BAD(F.Tp[3] = 1, DLS_E_ARGUMENT, "HT", 3);
  BAD(F.Ti[2] = -1, DLS_E_ARGUMENT, "HT", 2);
  BAD(F.Tx[0] = -INFINITY, DLS_E_NOT_FINITE, "HT", 0);
  BAD(F.model.P.i = NULL, DLS_E_ARGUMENT, "P", -1);
  BAD(F.model.P.x = NULL, DLS_E_ARGUMENT, "P", -1);
  BAD(F.model.P.rows = 2, DLS_E_SIZE, "P", -1);
  BAD(F.model.P.cols = -1, DLS_E_SIZE, "P", -1);
  BAD(F.model.P.cols = 1 << 30, DLS_E_SIZE, "P", -1);
  BAD(F.Pp[0] = 1, DLS_E_ARGUMENT, "P", 0);
  BAD(F.Pp[2] = 1, DLS_E_ARGUMENT, "P", 2);
  BAD(F.Pi[3] = 3, DLS_E_ARGUMENT, "P", 3);
  BAD(F.Px[3] = NAN, DLS_E_NOT_FINITE, "P", 3);
  BAD(F.Px[2] = -0.75, DLS_E_ARGUMENT, "P", 1);       /* column 1 adds up to 0 */
  BAD(F.Px[2] = -1, DLS_E_ARGUMENT, "P", 1);          /* and to less */
  BAD(F.Pp[1] = 0, DLS_E_ARGUMENT, "P", 0);           /* column 0 is empty */
  BAD(F.Px[2] = F.Px[3] = 0, DLS_E_ARGUMENT, "P", 1); /* column 1 holds zeros */

  dls_error error;
  dls_reduction *R = NULL;
  REFUSES(ARGUMENT, "model", -1, dls_model_check, NULL);
  ck_assert_int_eq(reduce_on_W(&R, NULL, NULL, &error), DLS_E_ARGUMENT);
  ck_assert_str_eq(error.argument, "model");
  make(2, 6, 3, 1, 1, 0);
  ck_assert_int_eq(reduce_on_W(NULL, &F.model, NULL, &error), DLS_E_ARGUMENT);
  ck_assert_str_eq(error.argument, "out");
}

/* No contact node, nodes without an active one, or a P without columns: x = K^-1 f, and a contact
 * problem without candidates, which is solved. */
TEST_EACH(no_candidates, 0, 12) {
  const int kind = 1 + _i / 3;
  make(2, 30, 4, 3, 1, 0);
  take_operator(kind);
  int active[4] = {0};
  if (_i % 3 == 0) {
    F.model.nodes = 0;
    F.model.HN = F.model.HT = (dls_sparse){0};
  } else if (_i % 3 == 1)
    F.model.active = active;
  else
    F.model.P = sparse(4, 0, F.Pp, F.Pi, F.Px);
  dls_reduction *R = new_reduction();
  ck_assert_int_eq(dls_reduction_load(R, F.f, F.model.nodes ? F.g : NULL, NULL), DLS_OK);
  dls_contact p;
  ck_assert_int_eq(dls_reduction_contact(R, NULL, &p, NULL), DLS_OK);
  ck_assert_int_eq(p.nc, 0);
  ck_assert_int_eq(p.d, 2);
  dls_info info;
  ck_assert_int_eq(dls_solve(&p, NULL, NULL, NULL, &info, NULL), DLS_OK);
  ck_assert(info.certificate.residual == 0);
  double x[30], expected[30] = {0}, nodal[8];
  ck_assert_int_eq(dls_reduction_recover(R, NULL, x, NULL), DLS_OK);
  for (int j = 0; j < 30; j++)
    for (int i = 0; i < 30; i++)
      expected[i] += F.inverse[i + 30 * j] * F.f[j];
  assert_close(x, expected, 30, rounding());
  ck_assert_int_eq(dls_reduction_nodal(R, NULL, nodal, NULL), DLS_OK);
  ck_assert_int_eq(dls_reduction_update(R, &F.model, NULL), DLS_OK);
  dls_reduction_destroy(R);
}

/* A host's own K^-1 f gives the q and the x that f gives, until the next load or update. */
TEST_EACH(free_velocity, 0, 16) {
  make(2 + _i / 8, 30, 6, 3, 1, _i / 4 % 2);
  take_operator(1 + _i % 4);
  const int n = 30, m = F.model.d * candidates();
  dls_reduction *R = new_reduction();
  double q[max_m], x[max_n], free[max_n], y[max_n], zero[max_m] = {0};
  ck_assert_int_eq(dls_reduction_load(R, F.f, F.g, NULL), DLS_OK);
  memcpy(q, contact_of(R).q, (size_t)m * sizeof *q);
  ck_assert_int_eq(dls_reduction_recover(R, F.r, x, NULL), DLS_OK);
  ck_assert_int_eq(dls_reduction_recover(R, zero, free, NULL), DLS_OK);
  ck_assert_int_eq(dls_reduction_load(R, NULL, NULL, NULL), DLS_OK);
  ck_assert_int_eq(dls_reduction_load_free(R, free, F.g, NULL), DLS_OK);
  assert_close(contact_of(R).q, q, m, rounding());
  ck_assert_int_eq(dls_reduction_recover(R, zero, y, NULL), DLS_OK);
  assert_close(y, free, n, 0);
  ck_assert_int_eq(dls_reduction_recover(R, F.r, y, NULL), DLS_OK);
  assert_close(y, x, n, rounding());

  REFUSES(ARGUMENT, "reduction", -1, dls_reduction_load_free, NULL, free, F.g);
  REFUSES(ARGUMENT, "x_free", -1, dls_reduction_load_free, R, NULL, F.g);
  y[3] = NAN;
  REFUSES(NOT_FINITE, "x_free", 3, dls_reduction_load_free, R, y, F.g);
  F.g[5] = INFINITY;
  REFUSES(NOT_FINITE, "g", 5, dls_reduction_load_free, R, free, F.g);
  assert_close(contact_of(R).q, q, m, rounding());

  ck_assert_int_eq(dls_reduction_load(R, F.f, NULL, NULL), DLS_OK);
  ck_assert_int_eq(dls_reduction_recover(R, F.r, y, NULL), DLS_OK);
  assert_close(y, x, n, 0);
  ck_assert_int_eq(dls_reduction_load_free(R, free, NULL, NULL), DLS_OK);
  ck_assert_int_eq(dls_reduction_update(R, &F.model, NULL), DLS_OK);
  ck_assert_int_eq(dls_reduction_recover(R, zero, y, NULL), DLS_OK);
  ck_assert(largest(y, n) == 0);
  dls_reduction_destroy(R);
}

TEST(bad_calls) {
  make(2, 6, 3, 1, 1, 1);
  dls_reduction *R = new_reduction();
  dls_error e;
  double q[4], f[6] = {1, 2, 3, 4, 5, 6}, g[6] = {1, 2, 3, 4, 5, 6};
  const char *name = "dls_reduction_load";
  ck_assert_int_eq(dls_reduction_load(R, f, g, NULL), DLS_OK);
  memcpy(q, contact_of(R).q, sizeof q);
  REFUSES(ARGUMENT, "reduction", -1, dls_reduction_load, NULL, f, g);
  f[4] = NAN;
  REFUSES(NOT_FINITE, "f", 4, dls_reduction_load, R, f, g);
  f[4] = 1;
  g[5] = INFINITY;
  REFUSES(NOT_FINITE, "g", 5, dls_reduction_load, R, f, g);
  ck_assert_mem_eq(contact_of(R).q, q, sizeof q);

  name = "dls_reduction_contact";
  dls_contact p, zero;
  memset(&p, 0, sizeof p);
  memset(&zero, 0, sizeof zero);
  double mu[2] = {0.5, 0.5};
  REFUSES(ARGUMENT, "reduction", -1, dls_reduction_contact, NULL, mu, &p);
  REFUSES(ARGUMENT, "mu", -1, dls_reduction_contact, R, NULL, &p);
  REFUSES(ARGUMENT, "problem", -1, dls_reduction_contact, R, mu, NULL);
  mu[1] = -1e-30;
  REFUSES(ARGUMENT, "mu", 1, dls_reduction_contact, R, mu, &p);
  mu[0] = NAN;
  REFUSES(NOT_FINITE, "mu", 0, dls_reduction_contact, R, mu, &p);
  ck_assert_mem_eq(&p, &zero, sizeof p);

  double r[4] = {1, 2, 3, 4}, x[6] = {7, 7, 7, 7, 7, 7}, out[6] = {7, 7, 7, 7, 7, 7};
  for (int nodal = 0; nodal < 2; nodal++) {
    name = nodal ? "dls_reduction_nodal" : "dls_reduction_recover";
#define CALL(R_, r_, x_)                                                                           \
  (nodal ? dls_reduction_nodal(R_, r_, x_, &e) : dls_reduction_recover(R_, r_, x_, &e))
    expect_error(CALL(NULL, r, x), &e, DLS_E_ARGUMENT, name, "reduction", -1);
    expect_error(CALL(R, NULL, x), &e, DLS_E_ARGUMENT, name, "r", -1);
    expect_error(CALL(R, r, NULL), &e, DLS_E_ARGUMENT, name, nodal ? "R" : "x", -1);
    r[3] = NAN;
    expect_error(CALL(R, r, x), &e, DLS_E_NOT_FINITE, name, "r", 3);
    r[3] = 4;
    ck_assert_mem_eq(x, out, sizeof x);
  }
  dls_reduction_destroy(R);
  dls_reduction_destroy(NULL);
}

/* ---- memory ---------------------------------------------------------------------------------- */

TEST_EACH(every_malloc_fails, 0, 8) {
  make(2, 12, 4, 3, _i % 2, 1);
  take_operator(1 + _i / 2);
  long count;
  dls_reduction *R = create_by_failures(&F.model, NULL, &count);
  ck_assert(count > 5 && count <= 100);
  const double mu[3] = {0};
  dls_contact p;
  double x[12], nodal[8];
  malloc_fails_at(1); /* Check allocates as well: ask first, assert afterwards */
  const dls_status answers[] = {
      dls_reduction_load(R, F.f, F.g, NULL), dls_reduction_contact(R, mu, &p, NULL),
      dls_reduction_recover(R, F.r, x, NULL), dls_reduction_nodal(R, F.r, nodal, NULL)};
  const long calls = malloc_calls();
  malloc_fails_at(0);
  ck_assert_int_eq(calls, 0);
  for (int i = 0; i < 4; i++)
    ck_assert_int_eq(answers[i], DLS_OK);
  dls_reduction_destroy(R);
}

/* ---- what is foreseen, compared and reported ------------------------------------------------- */

static dls_reduction_info estimated(const dls_reduction_settings *settings) {
  dls_reduction_info info;
  ck_assert_int_eq(dls_reduction_estimate(&F.model, settings, &info, NULL), DLS_OK);
  return info;
}

/* n = 100, d = 2: the factor 8 n^2, W 8 m^2, six vectors of n, a batch of m or 64 columns of n; of
 * the last two nothing without W. */
TEST_EACH(bytes_by_hand, 0, 2) {
  const int nodes = _i ? 50 : 4, batch = _i ? 64 : 8;
  make(2, 100, nodes, 1, 1, 0);
  dls_reduction_settings s;
  dls_reduction_settings_init(&s);
  dls_reduction_info info = estimated(&s);
  const double m = 2 * nodes, W = 8 * m * m;
  ck_assert(info.W_bytes == W && info.factor_bytes == 80000 && info.condensed == 0);
  ck_assert(info.bytes == 80000 + W + 8 * (600 + 100 * batch));
  s.form_W = 0;
  info = estimated(&s);
  ck_assert(info.W_bytes == 0 && info.bytes == 80000 + 4800);
  s.form_W = 1;
  s.memory_limit = 1000;
  dls_reduction *R;
  dls_error e;
  expect_error(reduce_on_W(&R, &F.model, &s, &e), &e, DLS_E_MEMORY, "dls_reduction_create",
               "memory_limit", -1);
  ck_assert_ptr_nonnull(
      strstr(e.message, _i ? "0.000216 GB needed (W 8e-05, factor 8e-05), limit 1e-06; "
                           : "9.17e-05 GB needed (W 5.12e-07, factor 8e-05), limit 1e-06; "));
}

/* A chain of 300 unknowns, of which one column of H touches `count`. */
static void make_touched(int count) {
  static int p[301], i[600];
  static double x[600];
  make(2, 40, 1, 1, 1, 0);
  for (int j = 0, e = 0; j < 300; j++) {
    i[e] = j;
    x[e++] = 2;
    if (j < 299) i[e] = j + 1;
    if (j < 299) x[e++] = -1;
    p[j + 1] = e;
  }
  for (int k = 0; k < count; k++) {
    F.Ni[k] = 30 * k;
    F.Nx[k] = 1;
  }
  F.Np[1] = count;
  F.model.n = F.model.HN.rows = F.model.HT.rows = 300;
  F.model.operator_kind = DLS_STIFFNESS_SPARSE;
  F.model.Ks = sparse(300, 300, p, i, x);
}

/* One column on 7 unknowns is condensed, on 8 solved for: b / 4 <= 1. A Schur complement takes b^2
 * doubles besides, solves 300 columns. */
TEST(condensed_by_hand) {
  dls_reduction_settings s;
  dls_reduction_settings_init(&s);
  s.frictionless = 1;
  for (int count = 7; count <= 8; count++) {
    make_touched(count);
    const dls_reduction_info info = estimated(&s);
    if (!WITH_MUMPS) continue;
    ck_assert_int_eq(info.condensed, count == 7 ? 7 : 0);
    s.form_W = 0;
    const dls_reduction_info none = estimated(&s);
    s.form_W = 1;
    ck_assert(none.condensed == 0 && none.W_bytes == 0);
    if (count == 8) ck_assert(info.bytes - none.bytes == 8 + 8 * 300);
    dls_reduction *R;
    ck_assert_int_eq(reduce_on_W(&R, &F.model, &s, NULL), DLS_OK);
    double expected = 0;
    for (int a = 0; a < count; a++)
      for (int b = 0; b < count; b++)
        expected += (1 + 30. * (a < b ? a : b)) * (300 - 30. * (a < b ? b : a)) / 301;
    dls_contact problem;
    ck_assert_int_eq(dls_reduction_contact(R, NULL, &problem, NULL), DLS_OK);
    ck_assert_double_eq_tol(problem.W.a[0], expected, 1e-11 * expected);
    dls_reduction_destroy(R);
  }
}

/* A load that overflows leaves the one before, of which nothing but f may be left in the factor. */
TEST(overflow_leaves_the_load) {
  make_touched(7);
  double f[300], x[300], again[300];
  for (int k = 0; k < 300; k++)
    f[k] = k % 7;
  dls_reduction_settings s;
  dls_reduction_settings_init(&s);
  s.frictionless = 1;
  dls_reduction *R;
  ck_assert_int_eq(reduce_on_W(&R, &F.model, &s, NULL), DLS_OK);
  ck_assert_int_eq(dls_reduction_load(R, f, NULL, NULL), DLS_OK);
  ck_assert_int_eq(dls_reduction_recover(R, F.r, x, NULL), DLS_OK);
  scale_vector(f, f, 1e307, 300);
  ck_assert_int_eq(dls_reduction_load(R, f, NULL, NULL), DLS_E_NOT_FINITE);
  ck_assert_int_eq(dls_reduction_recover(R, F.r, again, NULL), DLS_OK);
  assert_close(again, x, 300, 1e-13);
  dls_reduction_destroy(R);
}

/* The condition: of a factor its estimate, of what is not factored 0. */
TEST_EACH(conditions_are_told, 0, 4) {
  make_two_springs();
  take_operator(1 + _i);
  dls_reduction *R = new_reduction();
  dls_reduction_info info;
  ck_assert_int_eq(dls_reduction_get_info(R, &info, NULL), DLS_OK);
  ck_assert(info.indefinite == 0 && info.condensed == 0);
  if (_i < 2) /* scaled to (2 -1/2; -1/2 3/4)..: 1 to 10 */
    ck_assert(info.condition > 1 && info.condition < 10);
  else
    ck_assert(info.condition == 0);
  dls_reduction_destroy(R);
}

/* Another model's first difference is named, with its figure; the reduction stays as it was. H
 * touches the unknowns 0 to 2 by normals, 3 by two tangents; the third tangent is empty. */
TEST(differences_are_named) {
  static const int np[] = {0, 1, 2, 3}, ni[] = {0, 1, 2}, tp[] = {0, 1, 2, 2}, ti[] = {3, 3};
  static const int more[] = {0, 2, 3, 4}, more_i[] = {0, 1, 1, 2}, late[] = {0, 0, 2, 2};
  static const int apart[] = {3, 4}, last[] = {5, 5}, six[] = {0, 1, 2, 2, 2, 2, 2};
  static const int active[] = {4, 0, 0};
  static const double x[] = {1, 2, 3, 4}, mu[] = {0, 0, 0};
  make(2, 6, 3, 1, 1, 0);
  F.model.HN = sparse(6, 3, np, ni, x);
  F.model.HT = sparse(6, 3, tp, ti, x);
  dls_reduction *R = new_reduction();
  dls_model other;
  dls_error e;
#define DIFFERS(change, status, name, figure)                                                      \
  other = F.model;                                                                                 \
  change;                                                                                          \
  expect_error(dls_reduction_update(R, &other, &e), &e, status, "dls_reduction_update", name, -1); \
  ck_assert_msg(e.value == (figure), "%s: %g", name, e.value)
  DIFFERS((other.d = 3, other.HT = sparse(6, 6, six, ti, x)), DLS_E_SIZE, "d", 3);
  DIFFERS((other.n = other.HN.rows = other.HT.rows = 7, other.K = (dls_dense){7, 7, 7, F.K}),
          DLS_E_SIZE, "n", 7);
  DIFFERS(other.nodes = other.HN.cols = other.HT.cols = 2, DLS_E_SIZE, "nodes", 2);
  DIFFERS(other.active = active, DLS_E_SIZE, "active", 1);
  DIFFERS(other.P = sparse(3, 3, more, more_i, x), DLS_E_SIZE, "P", 4);
  DIFFERS(other.mu = mu, DLS_E_SIZE, "mu", 1);
  DIFFERS(other.operator_kind = DLS_STIFFNESS_SPARSE, DLS_E_SIZE, "operator_kind",
          DLS_STIFFNESS_SPARSE);
  DIFFERS(other.factorization = DLS_LDLT, DLS_E_SIZE, "factorization", DLS_LDLT);
  /* more entries on the same unknowns; an empty column more; an unknown more; another one */
  DIFFERS(other.HN = sparse(6, 3, more, more_i, x), DLS_E_ARGUMENT, "HN", 6);
  DIFFERS(other.HT.p = late, DLS_E_ARGUMENT, "HN", 5);
  DIFFERS(other.HT.i = apart, DLS_E_ARGUMENT, "HN", 5);
  DIFFERS(other.HT.i = last, DLS_E_ARGUMENT, "HN", 5);
  double y[6];
  ck_assert_int_eq(dls_reduction_recover(R, F.r, y, NULL), DLS_OK);
  ck_assert_int_eq(dls_reduction_update(R, &F.model, NULL), DLS_OK);
  dls_reduction_destroy(R);
}

/* After an update that failed, and without W, a call says so, without a figure. */
TEST(nothing_is_held) {
  make_two_springs();
  dls_reduction_settings s;
  dls_reduction_settings_init(&s);
  s.form_W = 0;
  dls_reduction *R;
  dls_contact p;
  dls_reduction_info info;
  dls_error e;
  double x[2];
  ck_assert_int_eq(reduce_on_W(&R, &F.model, &s, NULL), DLS_OK);
  REFUSES(UNSUPPORTED, "reduction", -1, dls_reduction_contact, R, x, &p);
  ck_assert(last_refusal.value == 0);
  F.K[0] = -1;
  ck_assert_int_eq(dls_reduction_update(R, &F.model, NULL), DLS_E_NOT_POSITIVE_DEFINITE);
#define HOLDS_NOTHING(name, ...)                                                                   \
  expect_error(name(__VA_ARGS__, &e), &e, DLS_E_ARGUMENT, #name, "reduction", -1);                 \
  ck_assert(e.value == 0)
  HOLDS_NOTHING(dls_reduction_load, R, F.f, NULL);
  HOLDS_NOTHING(dls_reduction_load_free, R, F.f, NULL);
  HOLDS_NOTHING(dls_reduction_contact, R, x, &p);
  HOLDS_NOTHING(dls_reduction_recover, R, F.r, x);
  HOLDS_NOTHING(dls_reduction_nodal, R, F.r, x);
  HOLDS_NOTHING(dls_reduction_get_info, R, &info);
  dls_reduction_destroy(R);
}

/* mu > 0 where the tangents were left out is refused, with its place and figure. */
TEST(tangents_left_out) {
  double mu[] = {0.5, 0, 0};
  make(2, 6, 3, 1, 1, 0);
  F.model.mu = mu;
  dls_reduction *R = new_reduction();
  dls_contact p;
  ck_assert_int_eq(dls_reduction_contact(R, NULL, &p, NULL), DLS_OK);
  ck_assert(p.mu[0] == 0.5 && p.mu[1] == 0 && p.nc == 3);
  const double other[] = {0.25, 0, 0.125};
  REFUSES(ARGUMENT, "mu", 2, dls_reduction_contact, R, other, &p);
  ck_assert(last_refusal.value == 0.125);
  ck_assert_int_eq(dls_reduction_load(R, NULL, (double[]){1, 2, 3, 4, 5, 6}, NULL), DLS_OK);
  assert_close(p.q, (double[]){1, 2, 3, 0, 5, 0}, 6, 0);
  dls_reduction_destroy(R);
}

/* ---- the weighting of a line ----------------------------------------------------------------- */

static void assert_column(const int *p, const int *i, const double *x, int j, int count,
                          const int *rows, const double *values) {
  ck_assert_int_eq(p[j + 1] - p[j], count);
  double sum = 0;
  for (int k = 0; k < count; k++) {
    ck_assert_int_eq(i[p[j] + k], rows[k]);
    ck_assert_double_eq_tol(x[p[j] + k], values[k], DBL_EPSILON);
    sum += x[p[j] + k];
  }
  ck_assert_double_eq_tol(sum, 1, 2 * DBL_EPSILON);
}

/* Segments 1, 3, 2; the last node is fixed: no candidate, but it keeps its share. Any unit. */
TEST_EACH(line_by_hand, 0, 4) {
  const double unit[] = {1, 1e-9, 1e9, 1e-300};
  double s[] = {0, 1, 4, 6}, x[12], length[4];
  for (int k = 0; k < 4; k++)
    s[k] = (s[k] - 2) * unit[_i];
  const int candidate[] = {1, 1, 1, 0};
  int p[5], i[12], columns;
  ck_assert_int_eq(dls_weighting_line(4, s, candidate, p, i, x, length, &columns, NULL), DLS_OK);
  ck_assert_int_eq(columns, 3);
  assert_column(p, i, x, 0, 2, (int[]){0, 1}, (double[]){0.75, 0.25});
  assert_column(p, i, x, 1, 3, (int[]){0, 1, 2}, (double[]){0.0625, 0.75, 0.1875});
  assert_column(p, i, x, 2, 3, (int[]){1, 2, 3}, (double[]){0.15, 0.75, 0.1});
  assert_close(length, (double[]){0.5 * unit[_i], 2 * unit[_i], 2.5 * unit[_i]}, 3,
               4 * DBL_EPSILON);
  ck_assert_int_eq(dls_weighting_line(4, s, NULL, p, i, x, NULL, &columns, NULL), DLS_OK);
  ck_assert_int_eq(columns, 4);
  assert_column(p, i, x, 3, 2, (int[]){2, 3}, (double[]){0.25, 0.75});
}

/* [J] 4.4 as printed: equal spacing, all nodes candidates: rows of P^T 3/4 1/4; 1/8 3/4 1/8; 1/4
 * 3/4. */
TEST(line_as_printed) {
  const double s[] = {0, 1, 2, 3, 4};
  int p[6], i[15], columns;
  double x[15];
  ck_assert_int_eq(dls_weighting_line(5, s, NULL, p, i, x, NULL, &columns, NULL), DLS_OK);
  assert_column(p, i, x, 0, 2, (int[]){0, 1}, (double[]){0.75, 0.25});
  for (int j = 1; j < 4; j++)
    assert_column(p, i, x, j, 3, (int[]){j - 1, j, j + 1}, (double[]){0.125, 0.75, 0.125});
  assert_column(p, i, x, 4, 2, (int[]){3, 4}, (double[]){0.25, 0.75});
  /* a candidate beside two nodes that are none; and one at the end alone */
  const int inside[] = {0, 0, 1, 0, 1};
  ck_assert_int_eq(dls_weighting_line(5, s, inside, p, i, x, NULL, &columns, NULL), DLS_OK);
  ck_assert_int_eq(columns, 2);
  assert_column(p, i, x, 0, 3, (int[]){1, 2, 3}, (double[]){0.125, 0.75, 0.125});
  assert_column(p, i, x, 1, 2, (int[]){3, 4}, (double[]){0.25, 0.75});
}

/* The line's P goes into a model as it is. */
TEST(line_in_a_model) {
  make(2, 20, 6, 1, 1, 1);
  const double s[] = {0, 0.5, 2, 2.25, 3, 7};
  const int candidate[] = {1, 1, 1, 0, 1, 0};
  int columns;
  ck_assert_int_eq(dls_weighting_line(6, s, candidate, F.Pp, F.Pi, F.Px, NULL, &columns, NULL),
                   DLS_OK);
  F.model.P = sparse(6, columns, F.Pp, F.Pi, F.Px);
  dls_reduction *R = new_reduction();
  assert_mechanics(R);
  double nodal[12], sum[4] = {0};
  ck_assert_int_eq(dls_reduction_nodal(R, F.r, nodal, NULL), DLS_OK);
  for (int k = 0; k < 6; k++)
    for (int c = 0; c < 2; c++) {
      sum[c] += nodal[2 * k + c];
      sum[2 + c] += k < columns ? F.r[2 * k + c] : 0;
    }
  assert_close(sum, sum + 2, 2, 16 * DBL_EPSILON); /* the resultant */
  dls_reduction_destroy(R);
}

/* Returns the integral of the hat function of `node` of a quadratic edge (0: first corner, 1:
 * middle, 2: last corner) from t to t + width, edge of length 1: Simpson's rule is exact to degree
 * 3. */
static double quadratic_hat(int node, double t) {
  return node == 0 ? (1 - t) * (1 - 2 * t) : node == 1 ? 4 * t * (1 - t) : t * (2 * t - 1);
}
static double quadratic_integral(int node, double t, double width) {
  return width / 6 *
         (quadratic_hat(node, t) + 4 * quadratic_hat(node, t + width / 2) +
          quadratic_hat(node, t + width));
}

/* Edges of 1, 3 and 2: each entry is the integral over the cell, over its length. Corners have
 * entries < 0, columns add up to 1. Any unit. */
TEST_EACH(quadratic_by_integrals, 0, 3) {
  const double unit[] = {1, 1e-9, 1e9}, edge[] = {1, 3, 2};
  double s[] = {0, 0.5, 1, 2.5, 4, 5, 6}, x[28], length[7];
  for (int k = 0; k < 7; k++)
    s[k] = (s[k] - 2) * unit[_i];
  int p[8], i[28], columns;
  ck_assert_int_eq(dls_weighting_quadratic(7, s, NULL, p, i, x, length, &columns, NULL), DLS_OK);
  ck_assert_int_eq(columns, 7);
  ck_assert_int_eq(p[7], 25);
  for (int j = 0; j < 7; j++) {
    double P[7] = {0}, cell = 0, sum = 0;
    for (int e = 0; e < 3; e++)
      for (int quarter = 0; quarter < 4; quarter++) {
        const int owner = 2 * e + (quarter == 0 ? 0 : quarter == 3 ? 2 : 1);
        if (owner != j) continue;
        cell += edge[e] / 4;
        for (int node = 0; node < 3; node++)
          P[2 * e + node] += edge[e] * quadratic_integral(node, quarter / 4., 0.25);
      }
    ck_assert_double_eq_tol(length[j], cell * unit[_i], 8 * DBL_EPSILON * cell * unit[_i]);
    int negative = 0;
    for (int k = p[j]; k < p[j + 1]; k++) {
      ck_assert(k == p[j] || i[k] > i[k - 1]);
      ck_assert_double_eq_tol(x[k], P[i[k]] / cell, 8 * DBL_EPSILON);
      negative += x[k] < 0;
      sum += x[k];
      P[i[k]] = 0;
    }
    for (int k = 0; k < 7; k++)
      ck_assert_double_eq_tol(P[k], 0, 8 * DBL_EPSILON); /* nothing left out */
    ck_assert_double_eq_tol(sum, 1, 8 * DBL_EPSILON);
    ck_assert_int_eq(negative, j % 2 ? 0 : j == 0 || j == 6 ? 1 : 2);
  }
  const int candidate[] = {0, 1, 1, 0, 0, 0, 0};
  ck_assert_int_eq(dls_weighting_quadratic(7, s, candidate, p, i, x, NULL, &columns, NULL), DLS_OK);
  ck_assert_int_eq(columns, 2);
  assert_column(p, i, x, 0, 3, (int[]){0, 1, 2}, (double[]){1. / 24, 11. / 12, 1. / 24});
}

/* A P with entries < 0 goes into a model: the mechanics hold, and W = P^T (L^T K^-1 L) P is still
 * positive definite, so that every load has an answer. */
TEST(quadratic_in_a_model) {
  make(2, 97, 5, 1, 1, 1);
  const double s[] = {0, 0.5, 1, 1.25, 1.5}, mu[] = {0.5, 0.5, 0.5, 0.5, 0.5};
  int columns;
  ck_assert_int_eq(dls_weighting_quadratic(5, s, NULL, F.Pp, F.Pi, F.Px, NULL, &columns, NULL),
                   DLS_OK);
  F.model.P = sparse(5, columns, F.Pp, F.Pi, F.Px);
  dls_reduction *R = new_reduction();
  assert_mechanics(R);
  dls_contact problem;
  ck_assert_int_eq(dls_reduction_contact(R, mu, &problem, NULL), DLS_OK);
  dls_diagnosis d;
  ck_assert_int_eq(dls_contact_diagnose(&problem, 10, &d, NULL), DLS_OK);
  ck_assert(d.spectrum == 1 && d.smallest > 1e-8 * d.largest);
  double r[10];
  ck_assert_int_eq(dls_solve(&problem, NULL, r, NULL, NULL, NULL), DLS_OK);
  dls_reduction_destroy(R);
}

TEST(bad_quadratic) {
  double s[] = {0, 1, 2}, x[12], length[3];
  int p[4], i[12], columns = 77;
  dls_error e;
  const char *name = "dls_weighting_quadratic";
#define QUADRATIC(n, s_, p_, i_, x_, k, status, argument, index)                                   \
  expect_error(dls_weighting_quadratic(n, s_, NULL, p_, i_, x_, length, k, &e), &e, status, name,  \
               argument, index)
  QUADRATIC(2, s, p, i, x, &columns, DLS_E_SIZE, "nodes", -1);
  QUADRATIC(1, s, p, i, x, &columns, DLS_E_SIZE, "nodes", -1);
  QUADRATIC(3, NULL, p, i, x, &columns, DLS_E_ARGUMENT, "s", -1);
  QUADRATIC(3, s, NULL, i, x, &columns, DLS_E_ARGUMENT, "p", -1);
  QUADRATIC(3, s, p, NULL, x, &columns, DLS_E_ARGUMENT, "i", -1);
  QUADRATIC(3, s, p, i, NULL, &columns, DLS_E_ARGUMENT, "x", -1);
  QUADRATIC(3, s, p, i, x, NULL, DLS_E_ARGUMENT, "columns", -1);
  s[1] = 1.001;
  QUADRATIC(3, s, p, i, x, &columns, DLS_E_ARGUMENT, "s", 1);
  s[1] = NAN;
  QUADRATIC(3, s, p, i, x, &columns, DLS_E_NOT_FINITE, "s", 1);
  ck_assert_int_eq(columns, 77);
}

TEST(bad_line) {
  double s[] = {0, 1, 2}, x[9];
  const int none[3] = {0};
  int p[4], i[9], columns = 77;
  dls_error e;
  const char *name = "dls_weighting_line";
  memset(p, 7, sizeof p);
  memset(i, 7, sizeof i);
  memset(x, 7, sizeof x);
  double length[3];
  memset(length, 7, sizeof length);
#define LINE(n, s_, c, p_, i_, x_, k, status, argument, index)                                     \
  expect_error(dls_weighting_line(n, s_, c, p_, i_, x_, length, k, &e), &e, status, name,          \
               argument, index)
  LINE(1, s, NULL, p, i, x, &columns, DLS_E_SIZE, "nodes", -1);
  LINE(1 << 30, s, NULL, p, i, x, &columns, DLS_E_SIZE, "nodes", -1);
  LINE(3, NULL, NULL, p, i, x, &columns, DLS_E_ARGUMENT, "s", -1);
  LINE(3, s, none, p, i, x, &columns, DLS_E_ARGUMENT, "candidate", -1);
  LINE(3, s, NULL, NULL, i, x, &columns, DLS_E_ARGUMENT, "p", -1);
  LINE(3, s, NULL, p, NULL, x, &columns, DLS_E_ARGUMENT, "i", -1);
  LINE(3, s, NULL, p, i, NULL, &columns, DLS_E_ARGUMENT, "x", -1);
  LINE(3, s, NULL, p, i, x, NULL, DLS_E_ARGUMENT, "columns", -1);
  s[2] = NAN;
  LINE(3, s, NULL, p, i, x, &columns, DLS_E_NOT_FINITE, "s", 2);
  s[2] = 1;
  LINE(3, s, NULL, p, i, x, &columns, DLS_E_ARGUMENT, "s", 2);
  s[0] = -1.7e308;
  s[1] = 1.7e308;
  LINE(3, s, NULL, p, i, x, &columns, DLS_E_ARGUMENT, "s", 1);
  ck_assert_int_eq(columns, 77);
  for (int k = 0; k < 4; k++)
    ck_assert_int_eq(p[k], 0x07070707);
  for (int k = 0; k < 9; k++)
    ck_assert(i[k] == 0x07070707 && x[k] == x[0] && x[k] < 1e-200 && length[k % 3] == x[0]);
}
