/* test_reduction_sparse.c: sparse K through MUMPS, what a scene does not need, singular K, limits.
 * With MUMPS=0 the same models go part by part as dense matrices. */
#define _POSIX_C_SOURCE 200809L /* mkstemp, dup2 */

#include <fcntl.h>
#include <unistd.h>

#include "delassus.h"
#include "delassus/fe.h"
#include "reduced.h"
#include "run.h"

/* ---- trusses: side x side nodes, bars along edges and diagonals of squares ------------------- */

enum {
  side = TEST_SMALL ? 13 : 16,
  body = 2 * side * side,
  max_n = 2 * body,
  max_nodes = 2 * side
};

typedef struct truss {
  int n;
  double *K; /* n x n */
  int p[max_n + 1], *i;
  double *x;
  int Np[max_nodes + 1], Ni[4 * max_nodes], Tp[max_nodes + 1], Ti[4 * max_nodes];
  double Nx[4 * max_nodes], Tx[4 * max_nodes];
  int Pp[max_nodes + 1], Pi[2 * max_nodes];
  double Px[2 * max_nodes];
  double f[max_n], g[2 * max_nodes], r[2 * max_nodes];
  dls_model model;
} truss;

static truss T;
static unsigned long long seed;

static double random_number(void) {
  seed = seed * 6364136223846793005ULL + 1442695040888963407ULL;
  return (double)(seed >> 11) / 4503599627370496.0 - 1;
}

static double *entry(int i, int j) {
  return T.K + i + (size_t)j * (size_t)T.n;
}

/* The bars of a body whose unknowns begin at `first`. */
static void add_bars(int first) {
  for (int node = 0; node < side * side; node++)
    for (int bar = 0; bar < 4; bar++) {
      const int dx[] = {1, 0, 1, -1}, dy[] = {0, 1, 1, 1};
      const int column = node % side + dx[bar], row = node / side + dy[bar];
      if (column < 0 || column >= side || row >= side) continue;
      const int a = first + 2 * node, b = first + 2 * (column + side * row);
      const double l = hypot(dx[bar], dy[bar]), c[] = {-dx[bar] / l, -dy[bar] / l};
      for (int j = 0; j < 2; j++)
        for (int i = 0; i < 2; i++) {
          *entry(a + i, a + j) += c[i] * c[j];
          *entry(b + i, b + j) += c[i] * c[j];
          *entry(a + i, b + j) -= c[i] * c[j];
          *entry(b + i, a + j) -= c[i] * c[j];
        }
    }
}

typedef enum form { LOWER, DOUBLED } form; /* lower triangle; all, in halves, rows descending */

static void store(form how, dls_factorization factorization) {
  int e = 0;
  free(T.i);
  free(T.x);
  T.i = malloc(80 * (size_t)T.n * sizeof *T.i);
  T.x = malloc(80 * (size_t)T.n * sizeof *T.x);
  for (int j = 0; j < T.n; j++) {
    T.p[j] = e;
    for (int turn = 0; turn < (how == DOUBLED ? 2 : 1); turn++)
      for (int k = 0; k < T.n; k++) {
        const int i = how == DOUBLED ? T.n - 1 - k : k;
        if (*entry(i, j) == 0 || (how == LOWER && i < j)) continue;
        T.i[e] = i;
        T.x[e++] = *entry(i, j) / (how == DOUBLED ? 2 : 1);
      }
  }
  T.p[T.n] = e;
  T.model.Ks = (dls_sparse){T.n, T.n, T.p, T.i, T.x};
  T.model.operator_kind = DLS_STIFFNESS_SPARSE;
  T.model.factorization = factorization;
}

/* Contact nodes: the lowest row of each body; t = +x, n = +y. */
static void pick_nodes(int bodies) {
  const int nodes = bodies * side;
  for (int k = 0; k < nodes; k++) {
    const int first = k / side * body + 2 * (k % side);
    T.Ni[k] = first + 1;
    T.Ti[k] = first;
    T.Nx[k] = T.Tx[k] = 1;
    T.Np[k + 1] = T.Tp[k + 1] = k + 1;
  }
  T.model.nodes = nodes;
  T.model.HN = (dls_sparse){T.n, nodes, T.Np, T.Ni, T.Nx};
  T.model.HT = (dls_sparse){T.n, nodes, T.Tp, T.Ti, T.Tx};
}

/* held: the left side of the first body stands on springs. skew: an unsymmetric part. */
static void make(int bodies, int held, double skew) {
  free(T.K);
  free(T.i);
  free(T.x);
  memset(&T, 0, sizeof T);
  seed = 1;
  T.n = bodies * body;
  T.K = calloc((size_t)T.n * (size_t)T.n, sizeof *T.K);
  for (int b = 0; b < bodies; b++)
    add_bars(b * body);
  for (int k = 0; held && k < bodies * side; k++)
    for (int i = 0; i < 2; i++) {
      const int at = k / side * body + 2 * side * (k % side) + i;
      *entry(at, at) += 1;
    }
  for (int j = 0; skew != 0 && j < T.n; j++)
    for (int i = j + 1; i < T.n; i++) {
      const double a = *entry(i, j);
      *entry(i, j) += skew * fabs(a);
      *entry(j, i) -= skew * fabs(a);
    }
  T.model = (dls_model){.d = 2, .n = T.n, .K = {T.n, T.n, T.n, T.K}};
  pick_nodes(bodies);
  store(LOWER, DLS_CHOLESKY);
  if (skew != 0) store(DOUBLED, DLS_LU);
  for (int k = 0; k < T.n; k++)
    T.f[k] = random_number();
  for (int k = 0; k < 2 * T.model.nodes; k++) {
    T.g[k] = random_number();
    T.r[k] = random_number();
  }
}

/* Each column on three unknowns of the two lowest rows; candidates on two nodes each. */
static void make_mortar(void) {
  const int nodes = T.model.nodes;
  for (int k = 0; k < nodes; k++) {
    T.Np[k + 1] = T.Tp[k + 1] = 3 * (k + 1);
    for (int e = 0; e < 3; e++) {
      const int node = (k + e * 5) % (2 * side);
      T.Ni[3 * k + e] = 2 * node + 1;
      T.Ti[3 * k + e] = 2 * node + (e == 2);
      T.Nx[3 * k + e] = random_number();
      T.Tx[3 * k + e] = random_number();
    }
  }
  for (int j = 0; j < nodes - 1; j++) {
    T.Pp[j + 1] = 2 * (j + 1);
    T.Pi[2 * j] = j;
    T.Pi[2 * j + 1] = j + 1;
    T.Px[2 * j] = 0.75;
    T.Px[2 * j + 1] = 0.25;
  }
  T.model.P = (dls_sparse){nodes, nodes - 1, T.Pp, T.Pi, T.Px};
}

static dls_reduction_settings defaults(void) {
  dls_reduction_settings s;
  dls_reduction_settings_init(&s);
  return s;
}

static dls_reduction *new_reduction(const dls_reduction_settings *settings) {
  dls_reduction *R = NULL;
  dls_error error = {0};
  const dls_status status = reduce_on_W(&R, &T.model, settings, &error);
  ck_assert_msg(status == DLS_OK, "%s", error.message);
  return R;
}

static dls_reduction_info info_of(const dls_reduction *R) {
  dls_reduction_info info;
  ck_assert_int_eq(dls_reduction_get_info(R, &info, NULL), DLS_OK);
  return info;
}

/* W, q, x of one reduction equal those of another. */
static void assert_same(dls_reduction *A, dls_reduction *B, double tol) {
  const dls_contact a = contact_of(A), b = contact_of(B);
  const size_t m = (size_t)a.W.rows;
  ck_assert_int_eq(a.W.rows, b.W.rows);
  assert_close(a.W.a, b.W.a, (int)(m * m), tol);
  ck_assert_int_eq(dls_reduction_load(A, T.f, T.g, NULL), DLS_OK);
  ck_assert_int_eq(dls_reduction_load(B, T.f, T.g, NULL), DLS_OK);
  assert_close(a.q, b.q, (int)m, tol);
  double *x = malloc(2 * (size_t)T.n * sizeof *x), *y = x + T.n;
  ck_assert_int_eq(dls_reduction_recover(A, T.r, x, NULL), DLS_OK);
  ck_assert_int_eq(dls_reduction_recover(B, T.r, y, NULL), DLS_OK);
  assert_close(x, y, T.n, tol);
  free(x);
}

/* The same model with K dense. */
static void assert_dense_agrees(dls_reduction *S) {
  const dls_operator kind = T.model.operator_kind;
  T.model.operator_kind = DLS_STIFFNESS_DENSE;
  dls_reduction *D = new_reduction(NULL);
  T.model.operator_kind = kind;
  assert_same(S, D, 1e-12);
  dls_reduction_destroy(D);
}

/* ---- the sparse path is the dense path ------------------------------------------------------- */

/* kind 0: definite, 1: the same as DLS_LDLT, 2: the same as DLS_LU, 3: unsymmetric, 4: indefinite
 * by a multiplier that ties two unknowns */
static void make_kind(int kind, form how) {
  make(1, 1, kind == 3 ? 0.2 : 0);
  if (kind == 4) { /* unknown n - 1 becomes the multiplier of x_40 = x_90 */
    for (int k = 0; k < T.n; k++)
      *entry(T.n - 1, k) = *entry(k, T.n - 1) = 0;
    *entry(T.n - 1, 40) = *entry(40, T.n - 1) = 1;
    *entry(T.n - 1, 90) = *entry(90, T.n - 1) = -1;
  }
  const dls_factorization f[] = {DLS_CHOLESKY, DLS_LDLT, DLS_LU, DLS_LU, DLS_LDLT};
  store(f[kind] == DLS_LU ? DOUBLED : how, f[kind]);
}

/* Unknowns that H touches. */
static int touched(void) {
  int marked[max_n] = {0}, count = 0;
  for (int e = 0; e < T.Np[T.model.nodes]; e++)
    marked[T.Ni[e]] = marked[T.Ti[e]] = 1;
  for (int i = 0; i < T.n; i++)
    count += marked[i];
  return count;
}

TEST_EACH(sparse_equals_dense, 0, 20) {
  make_kind(_i / 4, _i % 2 ? DOUBLED : LOWER);
  if (_i / 2 % 2) make_mortar();
  dls_reduction *S = new_reduction(NULL);
  assert_dense_agrees(S);
  if (WITH_MUMPS) ck_assert_int_eq(info_of(S).condensed, touched());
  ck_assert_double_gt(info_of(S).condition, 10);
  ck_assert_double_lt(info_of(S).condition, 1e6);
  const dls_contact p = contact_of(S);
  const size_t m = (size_t)p.W.rows;
  for (size_t j = 0; _i / 4 != 2 && _i / 4 != 3 && j < m; j++)
    for (size_t i = 0; i < j; i++)
      ck_assert(p.W.a[i + j * m] == p.W.a[j + i * m]);
  dls_reduction_destroy(S);
}

/* Unsymmetric W is not its transpose: tangents that ride along (follower loads). */
TEST(unsymmetric_is_unsymmetric) {
  make_kind(3, DOUBLED);
  dls_reduction *S = new_reduction(NULL);
  const dls_contact p = contact_of(S);
  const size_t m = (size_t)p.W.rows;
  ck_assert_double_gt(fabs(p.W.a[1] - p.W.a[m]), 1e-3 * largest(p.W.a, (int)(m * m)));
  dls_reduction_destroy(S);
}

/* Recovers for one r after the other from one load, and without a load: K x = f + H r each time. */
TEST_EACH(recovers_often, 0, 5) {
  make_kind(_i, DOUBLED);
  dls_reduction *S = new_reduction(NULL);
  double *x = malloc(3 * (size_t)T.n * sizeof *x), *left = x + T.n, *first = left + T.n;
  for (int turn = 0; turn < 6; turn++) {
    const double factor = turn % 2 ? -2 : 1;
    double r[2 * side];
    if (turn % 3 == 0)
      ck_assert_int_eq(dls_reduction_load(S, turn ? NULL : T.f, T.g, NULL), DLS_OK);
    scale_vector(r, T.r, factor, 2 * side);
    ck_assert_int_eq(dls_reduction_recover(S, r, x, NULL), DLS_OK);
    for (int i = 0; i < T.n; i++)
      left[i] = (turn < 3 ? T.f[i] : 0) + (i < 2 * side ? r[i % 2 ? i - 1 : i + 1] : 0);
    const double size = largest(left, T.n);
    for (int j = 0; j < T.n; j++)
      for (int i = 0; i < T.n; i++)
        left[i] -= *entry(i, j) * x[j];
    ck_assert_double_le(largest(left, T.n), 1e-12 * size);
    if (turn == 0) memcpy(first, x, (size_t)T.n * sizeof *x);
    if (turn == 2) assert_close(x, first, T.n, 1e-12);
  }
  free(x);
  dls_reduction_destroy(S);
}

/* No candidate is active: a plain solve. */
TEST_EACH(no_candidates, 0, 5) {
  make_kind(_i, DOUBLED);
  const int active[side] = {0};
  T.model.active = active;
  dls_reduction *S = new_reduction(NULL);
  ck_assert_int_eq(info_of(S).condensed, 0);
  double *x = malloc((size_t)T.n * sizeof *x), *Kx = calloc((size_t)T.n, sizeof *Kx);
  ck_assert_int_eq(dls_reduction_load(S, T.f, T.g, NULL), DLS_OK);
  ck_assert_int_eq(dls_reduction_recover(S, NULL, x, NULL), DLS_OK);
  for (int j = 0; j < T.n; j++)
    for (int i = 0; i < T.n; i++)
      Kx[i] += *entry(i, j) * x[j];
  assert_close(Kx, T.f, T.n, 1e-12);
  free(x);
  free(Kx);
  dls_reduction_destroy(S);
}

/* Few columns on many unknowns: no Schur complement, the same W. */
TEST(few_columns) {
  make(1, 1, 0);
  T.model.nodes = 1;
  for (int k = 0; k < 4 * side; k++) {
    T.Ni[k] = 2 * k + 1;
    T.Ti[k] = 2 * k;
    T.Nx[k] = T.Tx[k] = random_number();
  }
  T.Np[1] = T.Tp[1] = 4 * side;
  T.model.HN = (dls_sparse){T.n, 1, T.Np, T.Ni, T.Nx};
  T.model.HT = (dls_sparse){T.n, 1, T.Tp, T.Ti, T.Tx};
  dls_reduction *S = new_reduction(NULL);
  ck_assert_int_eq(info_of(S).condensed, 0);
  assert_dense_agrees(S);
  dls_reduction_destroy(S);
}

/* The block of Jean (1988), 296 unknowns, concentrated and weighted. */
TEST_EACH(jean_block, 0, 2) {
  dls_fe_scene *scene;
  dls_fe_scene_data data;
  ck_assert_int_eq(dls_fe_scene_create(&scene, "jean-fig3", _i, NULL), DLS_OK);
  dls_fe_scene_get(scene, &data);
  make(1, 1, 0);
  T.n = data.model.n;
  memcpy(T.K, data.model.K.a, (size_t)T.n * (size_t)T.n * sizeof *T.K);
  T.model = data.model;
  memcpy(T.f, data.f, (size_t)T.n * sizeof *T.f);
  memcpy(T.g, data.g, 2 * (size_t)data.model.nodes * sizeof *T.g);
  dls_reduction *D = new_reduction(NULL);
  store(LOWER, DLS_CHOLESKY);
  dls_reduction *S = new_reduction(NULL);
  if (WITH_MUMPS) ck_assert_int_gt(info_of(S).condensed, 0);
  assert_same(S, D, 1e-12);
  dls_reduction_destroy(S);
  dls_reduction_destroy(D);
  dls_fe_scene_destroy(scene);
}

/* A multiplier that ties two unknowns of contact nodes: K is regular, K without these is not. */
TEST_EACH(tied_contact_nodes, 0, 2) {
  make(1, 1, 0);
  const int last = T.n - 1;
  for (int k = 0; k < T.n; k++)
    *entry(last, k) = *entry(k, last) = 0;
  *entry(last, 0) = *entry(0, last) = 1;
  *entry(last, 6) = *entry(6, last) = -1;
  store(_i ? DOUBLED : LOWER, _i ? DLS_LU : DLS_LDLT);
  dls_reduction *S = new_reduction(NULL);
  ck_assert_int_eq(info_of(S).condensed, 0);
  assert_dense_agrees(S);
  ck_assert_int_eq(dls_reduction_update(S, &T.model, NULL), DLS_OK);
  assert_dense_agrees(S);
  dls_reduction_destroy(S);
}

/* No diagonal: MUMPS must pivot, and needs more room than it foresees. */
TEST(pivoting_takes_room) {
  make(1, 1, 0);
  for (int j = 0; j < T.n; j++)
    for (int i = 0; i < T.n; i++)
      *entry(i, j) = 0;
  for (int j = 0; j < T.n; j++) {
    *entry((j + 1) % T.n, j) = 2;
    for (int e = 0; e < 2; e++)
      *entry((int)(fabs(random_number()) * T.n), j) += random_number();
    *entry(j, j) = 0;
  }
  store(DOUBLED, DLS_LU);
  dls_reduction *S = new_reduction(NULL);
  assert_dense_agrees(S);
  dls_reduction_destroy(S);
}

TEST_EACH(same_bits, 0, 5) {
  make_kind(_i, LOWER);
  dls_reduction *A = new_reduction(NULL), *B = new_reduction(NULL);
  assert_same(A, B, 0);
  dls_reduction_destroy(B);
  dls_reduction_destroy(A);
}

/* Units of forces and lengths, and unknowns in different units (rotations beside displacements). */
TEST_EACH(units, 0, 12) {
  const double force[] = {1e-9, 1e9, 1}, turn[] = {1, 1, 1e7};
  make_kind(_i / 3, LOWER);
  dls_reduction *A = new_reduction(NULL);
  const dls_contact p = contact_of(A);
  const size_t m = (size_t)p.W.rows;
  double *W = malloc(m * m * sizeof *W);
  for (size_t k = 0; k < m * m; k++)
    W[k] = p.W.a[k] / force[_i % 3];
  for (int j = 0; j < T.n; j++) /* unknowns above the two lowest rows change their unit */
    for (int i = 0; i < T.n; i++)
      *entry(i, j) *=
          force[_i % 3] * (i < 4 * side ? 1 : turn[_i % 3]) * (j < 4 * side ? 1 : turn[_i % 3]);
  store(T.model.factorization == DLS_LU ? DOUBLED : LOWER, T.model.factorization);
  dls_reduction *B = new_reduction(NULL);
  assert_close(contact_of(B).W.a, W, (int)(m * m), 1e-12);
  if (WITH_MUMPS) ck_assert_double_lt(info_of(B).condition, 2 * info_of(A).condition);
  free(W);
  dls_reduction_destroy(B);
  dls_reduction_destroy(A);
}

/* ---- only what the scene needs --------------------------------------------------------------- */

TEST_EACH(without_tangents, 0, 2) {
  make(1, 1, 0);
  dls_reduction *A = new_reduction(NULL);
  const dls_contact full = contact_of(A);
  ck_assert_int_eq(dls_reduction_load(A, T.f, T.g, NULL), DLS_OK);
  const size_t m = 2 * side;
  double mu[side], wrong[side];
  int active[side];
  for (int c = 0; c < side; c++) {
    mu[c] = _i && c % 3 == 0 ? 0.5 : 0;
    wrong[c] = 0.5;
    active[c] = c % 4 != 1;
  }
  T.model.mu = mu;
  T.model.active = active;
  dls_reduction *B = new_reduction(NULL);
  dls_contact p;
  ck_assert_int_eq(dls_reduction_contact(B, NULL, &p, NULL), DLS_OK);
  ck_assert_int_eq(dls_contact_check(&p, NULL), DLS_OK);
  ck_assert_int_eq(p.nc, side - side / 4);
  REFUSES(ARGUMENT, "mu", _i, dls_reduction_contact, B, wrong, &p);
  ck_assert_int_eq(dls_reduction_load(B, T.f, T.g, NULL), DLS_OK);
  const size_t k = (size_t)p.W.rows;
  size_t touched = 0;
  for (int a = 0, c = 0; a < side; a++) {
    if (!active[a]) continue;
    ck_assert(p.mu[c] == mu[a]);
    touched += mu[a] > 0 ? 2 : 1;
    for (int b = 0, e = 0; b < side; b++) {
      if (!active[b]) continue;
      for (size_t i = 0; i < 2; i++)
        for (size_t j = 0; j < 2; j++) {
          const int there = (i == 0 || mu[a] > 0) && (j == 0 || mu[b] > 0);
          const double expected = there ? full.W.a[2 * (size_t)a + i + m * (2 * (size_t)b + j)] : 0;
          ck_assert_double_eq_tol(p.W.a[2 * (size_t)c + i + k * (2 * (size_t)e + j)], expected,
                                  1e-12 * largest(full.W.a, (int)(m * m)));
        }
      e++;
    }
    ck_assert_double_eq_tol(p.q[2 * c], full.q[2 * a], 1e-12 * largest(full.q, (int)m));
    if (mu[a] == 0) ck_assert(p.q[2 * c + 1] == 0);
    c++;
  }
  if (WITH_MUMPS) ck_assert_int_eq(info_of(B).condensed, (int)touched);
  double nodal[2 * side];
  ck_assert_int_eq(dls_reduction_nodal(B, T.r, nodal, NULL), DLS_OK);
  for (int a = 0, c = 0; a < side; a++) {
    ck_assert(nodal[2 * a] == (active[a] ? T.r[2 * c] : 0));
    c += active[a];
  }
  dls_reduction_destroy(B);
  dls_reduction_destroy(A);
}

/* A frictionless reduction is H_N alone: W_nn, q_n, the same x, and a quarter of the bytes of W. */
TEST_EACH(normals_alone, 0, 2) {
  make(1, 1, 0);
  double mu[side] = {0}, x[max_n], y[max_n];
  int active[side];
  for (int c = 0; c < side; c++)
    active[c] = c % 5 != 2;
  T.model.active = active;
  dls_reduction *A = new_reduction(NULL);
  dls_reduction_settings s = defaults();
  s.frictionless = 1;
  T.model.mu = _i ? mu : NULL;
  long failed;
  dls_reduction *B = create_by_failures(&T.model, &s, &failed);
  ck_assert_int_gt(failed, 1);
  ck_assert(info_of(A).W_bytes == 4 * info_of(B).W_bytes);
  for (int turn = 0; turn < 2; turn++) {
    ck_assert_int_eq(dls_reduction_load(A, T.f, T.g, NULL), DLS_OK);
    ck_assert_int_eq(dls_reduction_load(B, T.f, T.g, NULL), DLS_OK);
    const dls_contact full = contact_of(A);
    dls_contact p;
    ck_assert_int_eq(dls_reduction_contact(B, NULL, &p, NULL), DLS_OK);
    ck_assert_int_eq(dls_contact_check(&p, NULL), DLS_OK);
    ck_assert(p.d == 1 && p.nc == full.nc && p.W.rows == p.nc);
    ck_assert(info_of(B).W_bytes == 8. * p.nc * p.nc);
    const int m = 2 * p.nc;
    double r[2 * side], n[side], nodal[2 * side], nodal_n[2 * side];
    for (int a = 0; a < p.nc; a++) {
      ck_assert_double_eq_tol(p.q[a], full.q[2 * a], 1e-12 * largest(full.q, m));
      for (int b = 0; b < p.nc; b++)
        ck_assert_double_eq_tol(p.W.a[a + p.nc * b], full.W.a[2 * a + m * 2 * b],
                                1e-12 * largest(full.W.a, m * m));
    }
    ck_assert_int_eq(dls_solve(&full, NULL, r, NULL, NULL, NULL), DLS_OK);
    ck_assert_int_eq(dls_solve(&p, NULL, n, NULL, NULL, NULL), DLS_OK);
    for (int c = 0; c < p.nc; c++)
      ck_assert_double_eq_tol(n[c], r[2 * c], 1e-6 * largest(r, m));
    ck_assert_int_eq(dls_reduction_recover(A, r, x, NULL), DLS_OK);
    ck_assert_int_eq(dls_reduction_recover(B, n, y, NULL), DLS_OK);
    assert_close(y, x, T.n, 1e-6);
    ck_assert_int_eq(dls_reduction_nodal(A, r, nodal, NULL), DLS_OK);
    ck_assert_int_eq(dls_reduction_nodal(B, n, nodal_n, NULL), DLS_OK);
    assert_close(nodal_n, nodal, 2 * side, 1e-6);
    ck_assert_int_eq(dls_reduction_update(B, &T.model, NULL), DLS_OK);
  }
  dls_error error;
  dls_reduction *C;
  mu[8] = .5;
  T.model.mu = mu;
  ck_assert_int_eq(reduce_on_W(&C, &T.model, &s, &error), DLS_E_ARGUMENT);
  ck_assert_str_eq(error.argument, "mu");
  ck_assert_int_eq(error.index, 8);
  ck_assert_ptr_null(C);
  dls_reduction_destroy(B);
  dls_reduction_destroy(A);
}

/* A dense K in space, node after node: W takes a ninth of its bytes. */
TEST(normals_alone_in_space) {
  enum { nodes = 20, n = 3 * nodes };
  static double K[n * n], x[n], g[n];
  int Np[nodes + 1], Ni[nodes], Tp[2 * nodes + 1], Ti[2 * nodes];
  double one[2 * nodes], r[nodes], back[n], f[n], nodal[n];
  for (int i = 0; i < n; i++)
    for (int j = 0; j < n; j++)
      K[i + n * j] = (i == j ? 3 : 0) + 1. / (1 + abs(i - j));
  for (int k = 0; k < nodes; k++) {
    Np[k] = k, Ni[k] = 3 * k, Tp[2 * k] = 2 * k, Tp[2 * k + 1] = 2 * k + 1;
    Ti[2 * k] = 3 * k + 1, Ti[2 * k + 1] = 3 * k + 2, one[2 * k] = one[2 * k + 1] = 1;
  }
  Np[nodes] = nodes, Tp[2 * nodes] = 2 * nodes;
  for (int i = 0; i < n; i++)
    f[i] = i % 3 ? 0 : -1, g[i] = i % 3 ? 5 : .1 * (i % 7);
  const dls_model model = {.n = n,
                           .d = 3,
                           .nodes = nodes,
                           .operator_kind = DLS_STIFFNESS_DENSE,
                           .factorization = DLS_CHOLESKY,
                           .K = {n, n, n, K},
                           .HN = {n, nodes, Np, Ni, one},
                           .HT = {n, 2 * nodes, Tp, Ti, one}};
  dls_reduction_settings s = defaults();
  dls_reduction_info full, alone;
  ck_assert_int_eq(dls_reduction_estimate(&model, &s, &full, NULL), DLS_OK);
  s.frictionless = 1;
  ck_assert_int_eq(dls_reduction_estimate(&model, &s, &alone, NULL), DLS_OK);
  ck_assert(full.W_bytes == 9 * alone.W_bytes && alone.W_bytes == 8. * nodes * nodes);
  dls_reduction *R;
  dls_contact p;
  ck_assert_int_eq(reduce_on_W(&R, &model, &s, NULL), DLS_OK);
  ck_assert_int_eq(dls_reduction_load(R, f, g, NULL), DLS_OK);
  ck_assert_int_eq(dls_reduction_contact(R, NULL, &p, NULL), DLS_OK);
  ck_assert_int_eq(dls_solve(&p, NULL, r, NULL, NULL, NULL), DLS_OK);
  ck_assert_int_eq(dls_reduction_recover(R, r, x, NULL), DLS_OK);
  ck_assert_int_eq(dls_reduction_nodal(R, r, nodal, NULL), DLS_OK);
  for (int i = 0; i < n; i++) { /* K x - f = the nodal reactions, which are normal */
    back[i] = -f[i];
    for (int j = 0; j < n; j++)
      back[i] += K[i + n * j] * x[j];
    ck_assert_double_eq_tol(back[i], nodal[i], 1e-10);
    if (i % 3) continue;
    ck_assert(x[i] + g[i] >= -1e-7 && nodal[i] >= 0 && fabs(nodal[i] * (x[i] + g[i])) <= 1e-7);
  }
  ck_assert(largest(r, nodes) > 0);
  dls_reduction_destroy(R);
}

TEST(without_W) {
  make(1, 1, 0);
  dls_reduction *A = new_reduction(NULL);
  dls_reduction_settings s = defaults();
  s.form_W = 0;
  dls_reduction *B = new_reduction(&s);
  dls_contact p;
  double mu[side] = {0}, *x = malloc(2 * (size_t)T.n * sizeof *x);
  ck_assert_int_eq(dls_reduction_contact(B, mu, &p, NULL), DLS_E_UNSUPPORTED);
  ck_assert(info_of(B).condensed == 0 && info_of(B).W_bytes == 0);
  ck_assert_int_eq(dls_reduction_load(A, T.f, T.g, NULL), DLS_OK);
  ck_assert_int_eq(dls_reduction_load(B, T.f, T.g, NULL), DLS_OK);
  ck_assert_int_eq(dls_reduction_recover(A, T.r, x, NULL), DLS_OK);
  ck_assert_int_eq(dls_reduction_recover(B, T.r, x + T.n, NULL), DLS_OK);
  assert_close(x, x + T.n, T.n, 1e-12);
  free(x);
  dls_reduction_destroy(B);
  dls_reduction_destroy(A);
}

/* ---- the same pattern, new values ------------------------------------------------------------ */

TEST_EACH(update, 0, 5) {
  const int dense = _i == 4;
  make_kind(dense ? 0 : _i, LOWER);
  if (dense) T.model.operator_kind = DLS_STIFFNESS_DENSE;
  dls_reduction *R = new_reduction(NULL);
  const dls_contact before = contact_of(R);
  const size_t entries = (size_t)T.p[T.n];
  for (size_t k = 0; k < entries; k++)
    T.x[k] *= 3;
  for (size_t k = 0; k < (size_t)T.n * (size_t)T.n; k++)
    T.K[k] *= 3;
  T.Nx[2] = 0.5;
  ck_assert_int_eq(dls_reduction_load(R, T.f, T.g, NULL), DLS_OK);
  ck_assert_int_eq(dls_reduction_update(R, &T.model, NULL), DLS_OK);
  ck_assert_ptr_eq(contact_of(R).W.a, before.W.a);
  ck_assert(largest(before.q, before.W.rows) == 0);
  dls_reduction *S = new_reduction(NULL);
  assert_same(R, S, 0);

  /* what does not fit leaves it alone */
  dls_error error;
  dls_model other = T.model;
  other.HN = other.HT;
  REFUSES(ARGUMENT, "HN", -1, dls_reduction_update, R, &other);
  other = T.model;
  other.nodes = 3;
  other.HN.cols = other.HT.cols = 3;
  REFUSES(SIZE, "nodes", -1, dls_reduction_update, R, &other);
  if (!dense) {
    const int old = T.i[1];
    T.i[1] = T.n - 1;
    ck_assert_int_eq(dls_reduction_update(R, &T.model, &error), WITH_MUMPS ? DLS_E_ARGUMENT : 0);
    if (WITH_MUMPS) ck_assert_str_eq(error.argument, "Ks");
    T.i[1] = old;
    ck_assert_int_eq(dls_reduction_update(R, &T.model, &error), DLS_OK);
  }
  assert_same(R, S, 0);

  /* values that fail leave nothing, until there are good ones */
  other = T.model;
  double *zeros = calloc((size_t)T.n, (size_t)T.n * sizeof *zeros);
  other.Ks.x = other.K.a = zeros;
  ck_assert_int_eq(dls_reduction_update(R, &other, &error), DLS_E_SINGULAR);
  REFUSES(ARGUMENT, "reduction", -1, dls_reduction_load, R, T.f, T.g);
  ck_assert_int_eq(dls_reduction_update(R, &T.model, &error), DLS_OK);
  assert_same(R, S, 0);
  free(zeros);
  dls_reduction_destroy(S);
  dls_reduction_destroy(R);
}

/* ---- memory foreseen ------------------------------------------------------------------------- */

TEST_EACH(estimate, 0, 2) {
  make(1, 1, 0);
  if (_i) T.model.operator_kind = DLS_STIFFNESS_DENSE;
  dls_reduction_info info, took;
  ck_assert_int_eq(dls_reduction_estimate(&T.model, NULL, &info, NULL), DLS_OK);
  dls_reduction *R = new_reduction(NULL);
  took = info_of(R);
  ck_assert(info.W_bytes == 8.0 * 4 * side * side);
  ck_assert(info.condition == 0 && took.condition > 1);
  ck_assert(info.condensed == took.condensed && info.flops == took.flops);
  ck_assert(info.factor_bytes == took.factor_bytes && info.bytes == took.bytes);
  const double n = T.n;
  if (_i) ck_assert(info.factor_bytes == 8 * n * n && info.flops == n * n * n / 3);
  ck_assert_double_gt(info.bytes, info.factor_bytes + info.W_bytes);
  ck_assert_double_gt(info.flops, 1e5);
  dls_reduction_destroy(R);

  dls_reduction_settings s = defaults();
  s.memory_limit = info.bytes;
  dls_reduction_destroy(new_reduction(&s));
  s.memory_limit = info.bytes - 1;
  dls_error error;
  ck_assert_int_eq(reduce_on_W(&R, &T.model, &s, &error), DLS_E_MEMORY);
  ck_assert_ptr_null(R);
  ck_assert_str_eq(error.argument, "memory_limit");
  ck_assert(error.value == info.bytes);
  ck_assert_ptr_nonnull(strstr(error.message, "GB needed"));
  ck_assert_ptr_nonnull(strstr(error.message, "dls_primal"));
  ck_assert_int_eq(dls_reduction_estimate(&T.model, &s, &info, NULL), DLS_OK);
}

/* One K by its three factorisations: Cholesky's factor and that of LDLT are one triangle, LU has
 * two. MUMPS counts what it needs for the last two in whole millions, of which one is enough. */
TEST(factorisations_are_foreseen_alike) {
  dls_reduction_info by[3];
  for (int kind = 0; kind < 3; kind++) {
    make_kind(kind, LOWER);
    ck_assert_int_eq(dls_reduction_estimate(&T.model, NULL, &by[kind], NULL), DLS_OK);
    ck_assert_double_gt(by[kind].bytes, by[kind].factor_bytes);
  }
  if (!WITH_MUMPS) return;
  for (int kind = 1; kind < 3; kind++) {
    const dls_reduction_info *now = &by[kind], *one = &by[0];
    ck_assert_double_gt(now->factor_bytes, 0.75 * kind * one->factor_bytes);
    ck_assert_double_lt(now->factor_bytes, 1.25 * kind * one->factor_bytes);
    ck_assert_double_gt(now->flops, 0.75 * kind * one->flops);
    ck_assert_double_lt(now->flops, 1.25 * kind * one->flops);
    ck_assert_double_gt(now->bytes, 1e6);
    ck_assert_double_lt(now->bytes, 2e6);
  }
}

/* ---- no Cholesky factor, no inverse ---------------------------------------------------------- */

TEST_EACH(indefinite, 0, 2) {
  make(1, 1, 0);
  for (int k = 0; k < T.n; k++) /* below the smallest elastic eigenvalue and above others */
    *entry(k, k) -= 0.7;
  store(LOWER, DLS_CHOLESKY);
  if (_i) T.model.operator_kind = DLS_STIFFNESS_DENSE;
  dls_reduction *R;
  dls_error error;
  ck_assert_int_eq(reduce_on_W(&R, &T.model, NULL, &error), DLS_E_NOT_POSITIVE_DEFINITE);
  ck_assert_ptr_null(R);
  ck_assert(error.value < 0 || error.index == -1);
  dls_reduction_settings s = defaults();
  s.allow_indefinite = 1;
  R = new_reduction(&s);
  ck_assert_int_eq(info_of(R).indefinite, 1);
  T.model.factorization = DLS_LU;
  store(DOUBLED, DLS_LU);
  dls_reduction *S = new_reduction(NULL);
  ck_assert_int_eq(info_of(S).indefinite, 0);
  assert_same(R, S, 1e-11);
  dls_reduction_destroy(S);
  dls_reduction_destroy(R);
}

/* Free bodies, whatever K is tagged as: refused on W, and allow_indefinite does not make them
 * indefinite. Held on K, where the choice is left. */
TEST_EACH(free_bodies, 0, 12) {
  const int bodies = 1 + _i % 2;
  const dls_factorization tag = (dls_factorization)(1 + _i / 2 % 3);
  make(bodies, 0, 0);
  store(tag == DLS_LU ? DOUBLED : LOWER, tag);
  if (_i / 6) T.model.operator_kind = DLS_STIFFNESS_DENSE;
  dls_reduction *R;
  dls_error error;
  ck_assert_int_eq(reduce_on_W(&R, &T.model, NULL, &error), DLS_E_SINGULAR);
  ck_assert_ptr_null(R);
  ck_assert_ptr_nonnull(strstr(error.message, "singular"));
  dls_reduction_settings s = defaults();
  s.allow_indefinite = 1;
  ck_assert_int_eq(reduce_on_W(&R, &T.model, &s, &error), DLS_E_SINGULAR);
  for (int k = 0; k < 2; k++) {
    ck_assert_int_eq(dls_reduction_create(&R, &T.model, k ? &s : NULL, &error), DLS_OK);
    ck_assert_int_eq(info_of(R).on, DLS_ON_K);
    dls_reduction_destroy(R);
  }
}

/* An unknown that nothing holds, not even structurally; in K or beside it. */
TEST_EACH(structurally_singular, 0, 6) {
  make(1, 1, 0);
  const dls_factorization tag = (dls_factorization)(1 + _i % 3);
  const int lost = _i < 3 ? 201 : 7; /* inside; of a contact node */
  for (int k = 0; k < T.n; k++)
    *entry(lost, k) = *entry(k, lost) = 0;
  store(tag == DLS_LU ? DOUBLED : LOWER, tag);
  dls_reduction *R;
  dls_error error;
  ck_assert_int_eq(reduce_on_W(&R, &T.model, NULL, &error), DLS_E_SINGULAR);
  ck_assert_str_eq(error.argument, "Ks");
  ck_assert(error.index == lost || (tag != DLS_CHOLESKY && error.index == -1));
}

/* ---- bad input ------------------------------------------------------------------------------- */

TEST(bad_input) {
  make(1, 1, 0);
  dls_reduction *R;
  dls_error error;
  /* an upper triangle */
  for (int j = 0; j < T.n; j++)
    for (int i = j + 1; i < T.n; i++)
      *entry(i, j) = 0;
  store(DOUBLED, DLS_CHOLESKY);
  ck_assert_int_eq(reduce_on_W(&R, &T.model, NULL, &error), DLS_E_ARGUMENT);
  ck_assert_str_eq(error.argument, "Ks");
  make(1, 1, 0);
  int active[side] = {0};
  double mu[side] = {0};
  T.model.active = active;
  ck_assert_int_eq(dls_model_check(&T.model, &error), DLS_OK);
  T.model.active = NULL;
  T.model.mu = mu;
  mu[5] = -1;
  ck_assert_int_eq(dls_model_check(&T.model, &error), DLS_E_ARGUMENT);
  ck_assert(strcmp(error.argument, "mu") == 0 && error.index == 5);
  mu[5] = NAN;
  ck_assert_int_eq(dls_model_check(&T.model, &error), DLS_E_NOT_FINITE);
  T.model.mu = NULL;

  dls_reduction_settings s = defaults();
  s.size = 0;
  ck_assert_int_eq(reduce_on_W(&R, &T.model, &s, &error), DLS_E_SETTINGS);
#define SETTING(change, name)                                                                      \
  do {                                                                                             \
    s = defaults();                                                                                \
    change;                                                                                        \
    ck_assert_int_eq(reduce_on_W(&R, &T.model, &s, &error), DLS_E_ARGUMENT);                       \
    ck_assert_str_eq(error.argument, name);                                                        \
    ck_assert_str_eq(error.function, "dls_reduction_create");                                      \
    ck_assert_ptr_null(R);                                                                         \
  } while (0)
  SETTING(s.memory_limit = -1, "memory_limit");
  SETTING(s.memory_limit = NAN, "memory_limit");
  SETTING(s.allow_indefinite = 2, "allow_indefinite");
  SETTING(s.form_W = 7, "form_W");
  SETTING(s.frictionless = 2, "frictionless");
  dls_reduction_info info;
  ck_assert_int_eq(reduce_on_W(NULL, &T.model, NULL, &error), DLS_E_ARGUMENT);
  ck_assert_int_eq(dls_reduction_estimate(&T.model, NULL, NULL, &error), DLS_E_ARGUMENT);
  ck_assert_int_eq(dls_reduction_estimate(NULL, NULL, &info, &error), DLS_E_ARGUMENT);
  ck_assert_int_eq(dls_reduction_get_info(NULL, &info, &error), DLS_E_ARGUMENT);
  ck_assert_int_eq(dls_reduction_update(NULL, &T.model, &error), DLS_E_ARGUMENT);
  R = new_reduction(NULL);
  ck_assert_int_eq(dls_reduction_get_info(R, NULL, &error), DLS_E_ARGUMENT);
  ck_assert_int_eq(dls_reduction_update(R, NULL, &error), DLS_E_ARGUMENT);
  dls_reduction_destroy(R);
  make(1, 1, 0);
  dls_reduction_settings_init(NULL);
  /* the method on K itself knows nothing of these */
  T.model.mu = mu;
  mu[5] = 0;
  dls_primal_settings primal;
  dls_primal_settings_init(&primal);
  dls_primal *P;
  ck_assert_int_eq(dls_primal_create(&P, &T.model, &primal, &error), DLS_OK);
  dls_primal_destroy(P);
  active[0] = 1;
  T.model.active = active;
  REFUSES(UNSUPPORTED, "active", -1, dls_primal_create, &P, &T.model, &primal);
  ck_assert_int_eq(
      dls_fclib_write_global("/dev/null", &T.model, T.f, T.g, mu, NULL, NULL, NULL, NULL, &error),
      DLS_E_UNSUPPORTED);
}

/* ---- what the host shares with us ------------------------------------------------------------ */

/* Nothing is printed, whatever happens, and rand() goes on as if nothing had been. */
TEST(leaves_the_host_alone) {
  srand(7);
  const int one = rand(), two = rand();
  srand(7);
  ck_assert_int_eq(rand(), one);
  char name[] = "/tmp/delassus-test-XXXXXX";
  const int file = mkstemp(name), out = dup(1), err = dup(2);
  dup2(file, 1);
  dup2(file, 2);
  make(1, 1, 0);
  dls_reduction *R = NULL;
  const int good = reduce_on_W(&R, &T.model, NULL, NULL);
  dls_reduction_destroy(R);
  make(1, 0, 0);
  const int bad = reduce_on_W(&R, &T.model, NULL, NULL);
  fflush(stdout);
  const off_t length = lseek(file, 0, SEEK_END);
  dup2(out, 1);
  dup2(err, 2);
  close(file);
  unlink(name);
  ck_assert_int_eq(good, DLS_OK);
  ck_assert_int_eq(bad, DLS_E_SINGULAR);
  ck_assert_int_eq((int)length, 0);
  ck_assert_int_eq(rand(), two);
}

TEST_EACH(every_malloc_fails, 0, 4) {
  make(1, 1, 0);
  const dls_factorization tag[] = {DLS_CHOLESKY, DLS_LDLT, DLS_LU, DLS_CHOLESKY};
  store(tag[_i] == DLS_LU ? DOUBLED : LOWER, tag[_i]);
  if (_i == 3) make_mortar();
  dls_reduction_settings s = defaults();
  dls_status status = DLS_OK;
  long k;
  dls_reduction *R = create_by_failures(&T.model, &s, &k);
  ck_assert(k > 8 && k <= 200);
  for (k = 1; k < 100; k++) {
    dls_error error = {0};
    malloc_fails_at(k);
    status = dls_reduction_update(R, &T.model, &error);
    malloc_fails_at(0);
    if (!status) break;
    ck_assert_int_eq(status, DLS_E_MEMORY);
  }
  ck_assert_int_eq(status, DLS_OK);
  dls_reduction *S = new_reduction(&s);
  assert_same(R, S, 0);
  dls_reduction_destroy(S);
  dls_reduction_destroy(R);
}
