/*
 * test_cancel.c: the host watches a reduction and cancels it at each of its calls: nothing is
 * returned, a cancelled update holds nothing, and the next one has all bits.
 */
#include "delassus/reduction.h"
#include "reduced.h"
#include "run.h"

/* ---- a cube of side^3 nodes on a floor ------------------------------------------------------- */

enum { side = 10, nodes = side * side * side, floor_nodes = side * side, n = 3 * nodes };
enum { small = TEST_SMALL ? 3 : 5 }; /* layers of the cubes that are dense, LU, or the host's */

typedef struct cube {
  int p[n + 1], i[12 * n], Np[floor_nodes + 1], Ni[floor_nodes], Tp[2 * floor_nodes + 1];
  int Ti[2 * floor_nodes];
  double x[12 * n], one[2 * floor_nodes];
  double *K; /* dense */
  dls_model model;
} cube;

static cube C;

static void put_entry(int *e, int i, double x) {
  C.i[*e] = i;
  C.x[(*e)++] = x;
}

/* Three unknowns of a node feel one another and their like at the six neighbours; of `cells` layers
 * of nodes. full: both triangles. */
static void make_cube(int cells, int full) {
  const int stride[3] = {1, side, side * side}, size = 3 * floor_nodes * cells;
  int e = 0;
  for (int j = 0; j < size; j++) {
    const int node = j / 3, at[3] = {node % side, node / side % side, node / (side * side)};
    C.p[j] = e;
    for (int k = 2; k >= 0; k--)
      if (full && at[k] > 0) put_entry(&e, j - 3 * stride[k], -1);
    for (int k = full ? 0 : j % 3; k < 3; k++)
      put_entry(&e, 3 * node + k, k == j % 3 ? 6.2 : 0.1);
    for (int k = 0; k < 3; k++)
      if (at[k] + 1 < (k < 2 ? side : cells)) put_entry(&e, j + 3 * stride[k], -1);
  }
  C.p[size] = e;
  for (int c = 0; c < floor_nodes; c++) {
    C.Np[c + 1] = c + 1;
    C.Ni[c] = 3 * c + 2;
    for (int k = 0; k < 2; k++) {
      C.Tp[2 * c + k + 1] = 2 * c + k + 1;
      C.Ti[2 * c + k] = 3 * c + k;
      C.one[2 * c + k] = 1;
    }
  }
  C.model = (dls_model){.d = 3,
                        .n = size,
                        .nodes = floor_nodes,
                        .operator_kind = DLS_STIFFNESS_SPARSE,
                        .factorization = full ? DLS_LU : DLS_CHOLESKY,
                        .Ks = {size, size, C.p, C.i, C.x},
                        .HN = {size, floor_nodes, C.Np, C.Ni, C.one},
                        .HT = {size, 2 * floor_nodes, C.Tp, C.Ti, C.one}};
}

static void make_dense(void) {
  make_cube(small, 1);
  const size_t size = (size_t)C.model.n;
  C.K = calloc(size, size * sizeof *C.K);
  ck_assert_ptr_nonnull(C.K);
  for (int j = 0; j < C.model.n; j++)
    for (int e = C.p[j]; e < C.p[j + 1]; e++)
      C.K[(size_t)C.i[e] + (size_t)j * size] = C.x[e];
  C.model.operator_kind = DLS_STIFFNESS_DENSE;
  C.model.factorization = DLS_CHOLESKY;
  C.model.K = (dls_dense){C.model.n, C.model.n, C.model.n, C.K};
}

/* K = 2 I */
static int halve(void *user, double *X, int rows, int nrhs) {
  (void)user;
  for (int k = 0; k < rows * nrhs; k++)
    X[k] /= 2;
  return 0;
}

static void make_host(void) {
  make_cube(small, 0);
  C.model.operator_kind = DLS_HOST_SOLVER;
  C.model.solve = halve;
}

/* ---- the host -------------------------------------------------------------------------------- */

typedef struct host {
  int calls, lasts, cancel_at; /* 0: never */
  int stages, most;            /* that have begun; pieces of the last one */
  char stage[20];
} host;

static int look_on(void *data, const dls_progress *p) {
  static const char *const order[] = {"analysis", "factor", "W"};
  host *h = data;
  ck_assert_str_eq(p->method, "reduction");
  ck_assert_ptr_null(p->r);
  ck_assert(p->residual == -1);
  ck_assert_int_ge(p->iteration, 0);
  ck_assert(p->max_iterations == 0 || p->iteration <= p->max_iterations);
  ck_assert_int_eq(h->lasts, 0);
  if (p->last) {
    h->lasts++;
    return 0;
  }
  if (strcmp(h->stage, p->stage) != 0) {
    ck_assert_int_lt(h->stages, 3);
    ck_assert_str_eq(p->stage, order[h->stages++]);
    (void)strcpy(h->stage, p->stage);
  }
  h->most = p->max_iterations;
  ck_assert(h->cancel_at == 0 || h->calls < h->cancel_at); /* none after it */
  return ++h->calls == h->cancel_at;
}

static dls_reduction_settings watched(host *h, int cancel_at) {
  dls_reduction_settings s;
  dls_reduction_settings_init(&s);
  *h = (host){.cancel_at = cancel_at};
  s.progress = look_on;
  s.progress_data = h;
  return s;
}

static void (*const make[])(void) = {make_dense, make_host};

static void make_model(int k) {
  if (k >= 2)
    make_cube(k == 2 ? side : small, k == 3);
  else
    make[k]();
}

static void free_model(void) {
  free(C.K);
  C.K = NULL;
}

/* least: calls at least. */
static const int least[] = {5, 8, 14, 6};

TEST_EACH(cancels_create, 0, WITH_MUMPS ? 4 : 2) {
  make_model(_i);
  host h;
  dls_reduction *R = NULL;
  dls_error error = {0};
  dls_reduction_settings s = watched(&h, 0);
  ck_assert_int_eq(reduce_on_W(&R, &C.model, &s, &error), DLS_OK);
  dls_reduction_destroy(R);
  ck_assert_int_eq(h.lasts, 1);
  ck_assert_int_eq(h.stages, 3);
  const int calls = h.calls;
  ck_assert_int_ge(calls, least[_i]);
  for (int k = 1; k <= calls; k++) {
    R = (dls_reduction *)&h;
    s = watched(&h, k);
    ck_assert_int_eq(reduce_on_W(&R, &C.model, &s, &error), DLS_CANCELLED);
    ck_assert_ptr_null(R);
    ck_assert_int_eq(h.calls, k);
    ck_assert_int_eq(h.lasts, 1);
    ck_assert_int_eq(error.status, DLS_OK); /* no error */
  }
  free_model();
}

TEST_EACH(cancels_update, 0, WITH_MUMPS ? 4 : 2) {
  make_model(_i);
  host h;
  dls_reduction *R = NULL;
  dls_error error = {0};
  dls_contact p;
  const dls_reduction_settings s = watched(&h, 0);
  ck_assert_int_eq(reduce_on_W(&R, &C.model, &s, &error), DLS_OK);
  ck_assert_int_eq(dls_reduction_contact(R, (double[floor_nodes]){0}, &p, NULL), DLS_OK);
  const size_t bytes = 9 * (size_t)floor_nodes * floor_nodes * sizeof *p.W.a;
  double *W = malloc(bytes);
  ck_assert_ptr_nonnull(W);
  memcpy(W, p.W.a, bytes);
  const int calls = h.calls;
  for (int k = 1; k<calls; k += k> 3 ? calls / 5 + 1 : 1) {
    h = (host){.cancel_at = k, .stages = 1, .stage = "analysis"};
    if (dls_reduction_update(R, &C.model, &error) == DLS_OK) break; /* there is no analysis */
    ck_assert_int_eq(h.calls, k);
    ck_assert_int_eq(h.lasts, 1);
    ck_assert_int_eq(dls_reduction_load(R, NULL, NULL, NULL), DLS_E_ARGUMENT);
    h = (host){.stages = 1, .stage = "analysis"};
    ck_assert_int_eq(dls_reduction_update(R, &C.model, &error), DLS_OK);
    ck_assert_int_eq(dls_reduction_contact(R, (double[floor_nodes]){0}, &p, NULL), DLS_OK);
    ck_assert_int_eq(memcmp(W, p.W.a, bytes), 0);
  }
  dls_reduction_destroy(R);
  free(W);
  free_model();
}

/* Two candidates at one unknown of a body whose other unknowns are condensed: W has one piece. */
TEST_EACH(one_unknown, 0, WITH_MUMPS) {
  static const int p[] = {0, 1, 2}, row[] = {2, 2}, none[5] = {0};
  host h;
  dls_reduction *R;
  const dls_reduction_settings s = watched(&h, 0);
  make_cube(side, 0);
  C.model.nodes = 2;
  C.model.HN = (dls_sparse){C.model.n, 2, p, row, C.one};
  C.model.HT = (dls_sparse){C.model.n, 4, none, row, C.one};
  ck_assert_int_eq(reduce_on_W(&R, &C.model, &s, NULL), DLS_OK);
  ck_assert_int_eq(h.most, 1);
  dls_reduction_destroy(R);
}
