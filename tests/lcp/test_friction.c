/* test_friction.c: contact problems as LCPs of any form, in small integers, free of rounding. */
#include "cases.h"
#include "lcp/lcp_internal.h"
#include "run.h"

enum { most_rows = 24, canary = 3 };

/* Small integers and halves */
static double some_number(void) {
  return rint(8 * uniform()) / 2;
}

/* r = G z and y = E (W r + q) + L z written out, (FI1) and (FI2): M = E W G + L. */
static int form_directly(const dls_contact *p, const double *W, const dlsi_form *form,
                         const double *s, double M[most_rows][most_rows], double *q,
                         double G[][most_rows]) {
  const int d = p->d, m = d * p->nc;
  double E[most_rows][most_rows] = {{0}};
  int n = 0;
  memset(M, 0, most_rows * sizeof *M);
  memset(G, 0, most_rows * sizeof *G);
  for (int c = 0; c < p->nc; c++) {
    const double mu = p->mu[c], sc = s ? s[c] : 1;
    const int first = n, last = n + form->directions + 1;
    for (int i = 0; i < d; i++) {
      E[first][d * c + i] = sc * form->c[0][i];
      G[d * c + i][first] = sc * (form->c[0][i] - (mu > 0 ? form->shift * mu * form->c[1][i] : 0));
    }
    n = first + 1;
    if (!(mu > 0)) continue;
    for (int k = 1; k <= form->directions; k++, n++) {
      for (int i = 0; i < d; i++) {
        E[n][d * c + i] = G[d * c + i][n] = sc * form->c[k][i];
      }
      M[n][last] = 1;
      M[last][n] = -1;
    }
    M[last][first] = (1 + form->shift) * mu;
    n = last + 1;
  }
  for (int i = 0; i < n; i++) {
    q[i] = 0;
    for (int a = 0; a < m; a++) {
      q[i] += E[i][a] * p->q[a];
      for (int j = 0; j < n; j++)
        for (int b = 0; b < m; b++)
          M[i][j] += E[i][a] * W[a + m * b] * G[b][j];
    }
  }
  return n;
}

/* d = 1, 2, 3; candidates with and without friction, the last one too; W dense and by blocks, two
 * of them in one place; with scales and without; a column longer than it has to be;
 * directions beyond those of the form, which nobody may read. */
TEST_EACH(any_form, 0, 16) {
  static const dlsi_form forms[4] = {
      {.directions = 1, .shift = 1, .c = {{1, 0, 0}, {9, 9, 9}, {9, 9, 9}}},
      {.directions = 1, .shift = 1, .c = {{1, 0, 0}, {0, 1, 0}, {9, 9, 9}}},
      {.directions = 2, .shift = 0, .c = {{1, 0, 0}, {0, 1, 0}, {0, -1, 0}, {9, 9, 9}}},
      {.directions = 3,
       .shift = .5,
       .c = {{1, 0, 0}, {0, 2, 1}, {0, -1, 3}, {0, 4, -2}, {9, 9, 9}}}};
  const dlsi_form *form = &forms[_i % 4];
  const int d = _i % 4 == 0 ? 1 : _i % 4 < 3 ? 2 : 3, nc = 4, m = d * nc, sparse = _i / 4 % 2;
  const double mu[2][4] = {{.5, 0, 2, 1}, {0, 1, .25, 0}}, scales[4] = {2, .5, 4, 1};
  const double none[4] = {0}, *s = _i / 8 % 2 ? scales : NULL;
  double W[144], x[9 * 16], q[12];
  /* blocks (0,0), (2,0), (2,0) again; (1,1); (0,2), (2,2); (3,3), (1,3) */
  const int p[5] = {0, 3, 4, 6, 8}, rows[8] = {0, 2, 2, 1, 0, 2, 3, 1};
  set_seed(5 + (uint64_t)_i);
  for (int k = 0; k < m * m; k++)
    W[k] = sparse ? 0 : some_number();
  for (int c = 0; sparse && c < nc; c++)
    for (int k = p[c]; k < p[c + 1]; k++)
      for (int e = 0; e < d * d; e++)
        W[d * rows[k] + e % d + m * (d * c + e / d)] += x[d * d * k + e] = some_number();
  for (int i = 0; i < m; i++)
    q[i] = some_number();
  dls_contact problem = {.d = d, .nc = nc, .q = q, .mu = d == 1 ? none : mu[_i / 8 % 2]};
  if (sparse)
    problem.Wb = (dls_blocks){d, nc, p, rows, x};
  else
    problem.W = (dls_dense){m, m, m, W};
  double M[most_rows][most_rows], G[most_rows][most_rows], expected_q[most_rows];
  double made[most_rows * (most_rows + canary)], made_q[most_rows];
  const int n = form_directly(&problem, W, form, s, M, expected_q, G), ld = n + canary;
  ck_assert_int_eq(dlsi_form_size(&problem, form->directions), n);
  for (int k = 0; k < most_rows * (most_rows + canary); k++)
    made[k] = 77;
  for (int k = 0; k < most_rows; k++)
    made_q[k] = 77;
  ck_assert_int_eq(dlsi_form_matrix(&problem, form, s, made, ld, made_q, NULL), DLS_OK);
  for (int j = 0; j < n; j++)
    for (int i = 0; i < ld; i++)
      ck_assert(made[i + ld * j] == (i < n ? M[i][j] : 77));
  for (int i = 0; i < most_rows; i++)
    ck_assert(made_q[i] == (i < n ? expected_q[i] : 77));
  ck_assert(made[ld * n] == 77);
  double z[most_rows], r[13];
  for (int i = 0; i < n; i++)
    z[i] = some_number();
  r[m] = 77;
  ck_assert_int_eq(dlsi_form_reactions(&problem, form, s, z, r, NULL), DLS_OK);
  for (int a = 0; a < m; a++) {
    double sum = 0;
    for (int i = 0; i < n; i++)
      sum += G[a][i] * z[i];
    ck_assert(r[a] == sum);
  }
  ck_assert(r[m] == 77);
}

/* A size of INT_MAX just fits: 1 + 2 (D + 2), and one candidate more does not. */
TEST(largest_size) {
  const double mu[4] = {0, 1, 1, 0};
  const int directions = INT_MAX / 2 - 2;
  dls_contact problem = {.d = 3, .nc = 3, .mu = mu};
  ck_assert_int_eq(dlsi_form_size(&problem, directions), INT_MAX);
  problem.nc = 4;
  ck_assert_int_eq(dlsi_form_size(&problem, directions), 0);
}

/* Sticks, slips to either side, free to either side and at rest; without friction loaded and free.
 * z = (r_n, phi_2, lambda_2) > 0. */
TEST(start_by_states) {
  const double r[16] = {1, .5, 1, -1, 1, 1, 0, 0, 0, 0, 0, 0, 1, 0, 0, 0};
  const double u[16] = {0, 0, 0, 3, 0, -3, 1, -2, 1, 2, 1, 0, 0, -5, 1, -5};
  const double mu[8] = {1, 1, 1, 1, 1, 1, 0, 0}, w[8] = {1, 2, 1, 1, 1, 1, 1, 1};
  static const double expected[20] = {1, 1, 0, 1, 0, 0, 1, 1, 1, 0, 0, 1, 0, 0, 0, 0, 0, 0, 1, 0};
  const dls_contact problem = {.d = 2, .nc = 8, .mu = mu};
  double z[21];
  for (int k = 0; k < 21; k++)
    z[k] = 77;
  dlsi_friction_start(&problem, w, r, u, z);
  for (int k = 0; k < 20; k++)
    ck_assert_msg(z[k] == expected[k], "z[%d] = %g", k, z[k]);
  ck_assert(z[20] == 77);
}

/* What is wrong is told by its name, index and number, and nothing is written. */
TEST(refusals_of_forms) {
  static const dlsi_form form = {.directions = 1, .shift = 1, .c = {{1, 0, 0}, {0, 1, 0}}};
  const double W[16] = {0}, q[4] = {0}, mu[2] = {1, 0}, s[2] = {1, 0}, z[4] = {0, 1, NAN, 2};
  dls_contact problem = {.d = 2, .nc = 2, .W = {4, 4, 4, W}, .q = q, .mu = mu};
  double M[16] = {7}, to[4] = {7};
  dls_error e;
  ck_assert_int_eq(dlsi_form_matrix(&problem, &form, NULL, M, 3, to, &e), DLS_E_SIZE);
  ck_assert(strcmp(e.argument, "ldm") == 0 && e.index == -1 && e.value == 3);
  ck_assert_int_eq(dlsi_form_matrix(&problem, &form, NULL, NULL, 4, to, &e), DLS_E_ARGUMENT);
  ck_assert_str_eq(e.argument, "M");
  ck_assert_int_eq(dlsi_form_matrix(&problem, &form, NULL, M, 4, NULL, &e), DLS_E_ARGUMENT);
  ck_assert_str_eq(e.argument, "q");
  ck_assert_int_eq(dlsi_form_matrix(&problem, &form, s, M, 4, to, &e), DLS_E_ARGUMENT);
  ck_assert(strcmp(e.argument, "s") == 0 && e.index == 1 && e.value == 0);
  ck_assert_int_eq(dlsi_form_reactions(&problem, &form, NULL, z, to, &e), DLS_E_NOT_FINITE);
  ck_assert(strcmp(e.argument, "z") == 0 && e.index == 2);
  ck_assert_int_eq(dlsi_form_reactions(&problem, &form, NULL, q, NULL, &e), DLS_E_ARGUMENT);
  ck_assert_str_eq(e.argument, "r");
  problem.nc = 0;
  ck_assert_int_eq(dlsi_form_matrix(&problem, &form, NULL, M, 4, to, &e), DLS_E_SIZE);
  ck_assert(strcmp(e.argument, "nc") == 0 && e.index == -1 && e.value == 0);
  ck_assert(M[0] == 7 && to[0] == 7);
}
