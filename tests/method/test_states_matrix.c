/*
 * test_states_matrix.c: A = R W E + L of chosen states against differences of the laws, its two
 * storages, its solves, and the products with R and E.
 */
#include "cases.h"
#include "contact/contact.h"
#include "run.h"
#include "vi/newton/states_matrix.h"

/* States at random, r in these states and u = W r + q. */
typedef struct chosen {
  model a;
  dls_contact_state state[most];
  double r[most], u[most];
  dlsi_branch branch[most];
  int n;
} chosen;

static void choose(chosen *x, int i) {
  numbered_model(&x->a, i);
  const int d = x->a.p.d;
  for (int c = 0; c < x->a.p.nc; c++) {
    const double mu = x->a.mu[c], draw = uniform();
    double *r = x->r + d * c, t = 0;
    x->state[c] = draw < -0.5 ? DLS_FREE : draw < 0.2 || d == 1 ? DLS_STICK : DLS_SLIP;
    if (x->state[c] == DLS_STICK && d > 1 && mu == 0) x->state[c] = DLS_SLIP;
    for (int k = 0; k < d; k++)
      r[k] = x->state[c] == DLS_FREE ? 0 : k ? uniform() : 1.5 + uniform();
    for (int k = 1; k < d; k++)
      t = hypot(t, r[k]);
    for (int k = 1; k < d && x->state[c] == DLS_SLIP; k++)
      r[k] *= mu * r[0] / t;
  }
  dlsi_contact_multiply(&x->a.p, NULL, x->r, x->u, NULL);
  x->n = dlsi_branches_set(&x->a.p, x->state, x->r, x->u, x->branch);
}

/* The laws of a contact in its state, rows as those of R; p . u |r_t| with r_t turned. */
static void laws_of(int d, const dlsi_branch *b, const double *r, const double *u, double *F) {
  for (int i = 0; i < b->count; i++)
    F[i] = u[i];
  if (d == 3 && b->state == DLS_SLIP && b->count == 2)
    F[1] = (r[1] * u[2] - r[2] * u[1]) / hypot(r[1], r[2]);
}

/* A y is the difference of the laws where r goes along E y: mu |r_t| to second order. The law
 * across has the sign of u_t along r_t, which is against it: choose u so. */
TEST_EACH(derivative_of_the_laws, 0, 44) {
  const int number = _i < 40 ? _i : normal_models + _i - 40;
  chosen x;
  static double A[most * most], column[most];
  int row[most];
  const double h = 1e-6;
  choose(&x, number);
  const dls_contact *p = &x.a.p;
  double q[most];
  for (int c = 0; c < p->nc; c++) { /* slip against r_t: u_t := -2 r_t, u_n := 0 */
    for (int k = 0; k < p->d; k++) {
      const int at = p->d * c + k;
      const double u = x.state[c] == DLS_SLIP && k ? -2 * x.r[at] : 0;
      q[at] = x.a.q[at] + u - x.u[at];
    }
  }
  memcpy(x.a.q, q, sizeof q);
  dlsi_contact_multiply(p, NULL, x.r, x.u, NULL);
  x.n = dlsi_branches_set(p, x.state, x.r, x.u, x.branch);
  dlsi_states_fill(p, x.branch, NULL, x.n, row, column, A);
  for (int j = 0; j < x.n; j++) {
    double y[most] = {0}, r[2][most], u[most], F[2][most];
    for (int side = 0; side < 2; side++) {
      y[j] = side ? -h : h;
      memcpy(r[side], x.r, sizeof x.r);
      dlsi_branches_add_directions(p->d, p->nc, x.branch, y, r[side]);
      dlsi_contact_multiply(p, NULL, r[side], u, NULL);
      for (int c = 0; c < p->nc; c++)
        laws_of(p->d, &x.branch[c], r[side] + p->d * c, u + p->d * c, F[side] + x.branch[c].first);
    }
    for (int i = 0; i < x.n; i++)
      ck_assert_double_le(fabs((F[0][i] - F[1][i]) / (2 * h) - A[i + j * x.n]), 1e-8);
  }
}

/* By blocks: the same A but for the order of sums; with a shift on its diagonal. */
TEST_EACH(two_storages, 0, 40) {
  chosen x;
  block_storage B;
  static double A[2][most * most], column[most];
  double shift[most];
  int row[most];
  choose(&x, _i);
  const dls_contact blocks = by_blocks(&x.a, &B);
  for (int c = 0; c < x.a.p.nc; c++)
    shift[c] = c + 1;
  dlsi_states_fill(&x.a.p, x.branch, shift, x.n, row, column, A[0]);
  dlsi_states_fill(&blocks, x.branch, shift, x.n, row, column, A[1]);
  for (int k = 0; k < x.n * x.n; k++)
    ck_assert_double_le(fabs(A[0][k] - A[1][k]), 16 * DBL_EPSILON * (1 + fabs(A[0][k])));
  dlsi_states_fill(&blocks, x.branch, NULL, x.n, row, column, A[1]);
  for (int c = 0; c < x.a.p.nc; c++)
    for (int j = x.branch[c].first; j < x.branch[c].first + x.branch[c].count; j++)
      ck_assert_double_le(fabs(A[0][j * (x.n + 1)] - A[1][j * (x.n + 1)] - shift[c]), 1e-13 * most);
}

/* (SM3) R = E^T: E^T W E + L and shift_c E^T E, in both storages. */
TEST_EACH(symmetric_rows, 0, 40) {
  chosen x;
  block_storage B;
  static double A[2][most * most], column[most];
  double shift[most];
  int row[most];
  choose(&x, _i);
  const int d = x.a.p.d, nc = x.a.p.nc, m = d * nc;
  const dls_contact blocks = by_blocks(&x.a, &B);
  for (int c = 0; c < nc; c++) {
    x.branch[c].symmetric = 1;
    shift[c] = c + 1;
  }
  dlsi_states_fill(&x.a.p, x.branch, shift, x.n, row, column, A[0]);
  dlsi_states_fill(&blocks, x.branch, shift, x.n, row, column, A[1]);
  for (int j = 0; j < x.n; j++) {
    double y[most] = {0}, e[most] = {0}, v[most] = {0}, z[most];
    y[j] = 1;
    dlsi_branches_add_directions(d, nc, x.branch, y, e);
    dlsi_contact_apply(&x.a.p, e, v);
    for (int k = 0; k < m; k++) /* shift_c E^T E, and L below */
      v[k] += shift[k / d] * e[k];
    dlsi_branches_directions(d, nc, x.branch, v, y);
    dlsi_branches_rows(d, nc, x.branch, v, z);
    for (int c = 0; c < nc; c++)
      if (x.branch[c].state == DLS_SLIP && x.branch[c].count == 2 && x.branch[c].first + 1 == j)
        y[j] += x.branch[c].l;
    for (int i = 0; i < x.n; i++) {
      ck_assert_double_le(fabs(A[0][i + j * x.n] - y[i]), 1e-13 * (1 + fabs(y[i])));
      ck_assert_double_le(fabs(A[1][i + j * x.n] - y[i]), 1e-13 * (1 + fabs(y[i])));
      if (i != j) ck_assert_double_le(fabs(z[i] - y[i]), 1e-13 * (1 + fabs(y[i])));
    }
    double w[most] = {0}, of[most] = {0};
    of[j] = 1;
    dlsi_branches_add_rows(d, nc, x.branch, of, w);
    for (int k = 0; k < m; k++)
      ck_assert(w[k] == e[k]); /* R^T = E */
  }
}

/* v.(E y) = (E^T v).y, v.(R^T y) = (R v).y */
TEST_EACH(adjoint_products, 0, 40) {
  chosen x;
  choose(&x, _i);
  const int d = x.a.p.d, nc = x.a.p.nc;
  for (int rows = 0; rows < 2; rows++) {
    double v[most], y[most], to[most] = {0}, from[most], sum[2] = {0};
    for (int k = 0; k < most; k++)
      v[k] = uniform(), y[k] = uniform();
    (rows ? dlsi_branches_add_rows : dlsi_branches_add_directions)(d, nc, x.branch, y, to);
    (rows ? dlsi_branches_rows : dlsi_branches_directions)(d, nc, x.branch, v, from);
    for (int k = 0; k < d * nc; k++)
      sum[0] += v[k] * to[k];
    for (int k = 0; k < x.n; k++)
      sum[1] += y[k] * from[k];
    ck_assert_double_le(fabs(sum[0] - sum[1]), 1e-13 * most);
  }
}

/* A row of contacts, dense and (more than dense_limit unknowns) by MUMPS: |A x - b| and
 * |A^T x - b|. */
TEST_EACH(solves, 0, 2) {
  dls_contact problem[2];
  static double A[row_m * row_m], column[row_m], r[row_m], u[row_m], b[row_m], x[row_m];
  static dls_contact_state state[row_nc];
  static int row[row_m];
  row_problem(0, &problem[0], &problem[1]);
  dlsi_states_matrix *work;
  const dls_contact *p = &problem[_i];
  ck_assert_int_eq(dlsi_states_create(&work, p, NULL), DLS_OK);
  for (int c = 0; c < row_nc; c++) {
    state[c] = c % 7 == 3 ? DLS_SLIP : DLS_STICK;
    r[2 * c] = 1;
    r[2 * c + 1] = c % 7 == 3 ? (c % 2 ? 0.5 : -0.5) : 0;
  }
  work->n = dlsi_branches_set(p, state, r, u, work->branch);
  dlsi_states_fill(p, work->branch, NULL, work->n, row, column, A);
  ck_assert_int_eq(dlsi_states_factor(work, p, NULL, column, NULL), DLS_OK);
  ck_assert_int_eq(work->factors, WITH_MUMPS && _i ? DLSI_SPARSE_FACTORS : DLSI_DENSE_FACTORS);
  for (int transposed = 0; transposed < 2; transposed++) {
    for (int k = 0; k < work->n; k++)
      b[k] = x[k] = uniform();
    ck_assert_int_eq(dlsi_states_solve(work, transposed, x, NULL), DLS_OK);
    for (int i = 0; i < work->n; i++) {
      double sum = -b[i];
      for (int j = 0; j < work->n; j++)
        sum += A[transposed ? j + i * work->n : i + j * work->n] * x[j];
      ck_assert_double_le(fabs(sum), 1e-11);
    }
  }
  dlsi_states_destroy(work);
}

/* Each allocation fails in turn. */
TEST_EACH(memory, 0, 2) {
  dls_contact problem[2];
  dlsi_states_matrix *work;
  row_problem(0, &problem[0], &problem[1]);
  MALLOCS_FAIL(dlsi_states_create(&work, &problem[_i], NULL), !work, DLS_OK, 2);
  dlsi_states_destroy(work);
  dlsi_states_destroy(NULL);
}
