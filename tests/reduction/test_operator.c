/* test_operator.c: H = L P and W = H^T K^-1 H by hand, without what a scene does not need. */
#include "reduction/reduction_internal.h"
#include "run.h"

/* ---- H --------------------------------------------------------------------------------------- */

/* Three nodes on 7 unknowns, of which 2 and 6 are not touched; node 2 has no tangent. Candidates:
 * a quarter of node 0 and half of node 1; node 1; twice node 2. */
static const int Np[] = {0, 1, 2, 4}, Ni[] = {1, 3, 4, 1}, Tp[] = {0, 1, 2, 2}, Ti[] = {0, 5};
static const double Nx[] = {2, 4, 1, -1}, Tx[] = {1, 8};
static const int Pp[] = {0, 2, 3, 4}, Pi[] = {0, 1, 1, 2}, some[] = {1, 0, 5};
static const double Px[] = {0.25, 0.5, 1, 2};
static double diagonal[] = {1, 2, 4, 8, 16, 32, 64};
static const int Kp[] = {0, 1, 2, 3, 4, 5, 6, 7}, Ki[] = {0, 1, 2, 3, 4, 5, 6};

static dls_model operator_model(void) {
  return (dls_model){.d = 2,
                     .n = 7,
                     .nodes = 3,
                     .operator_kind = DLS_STIFFNESS_SPARSE,
                     .factorization = DLS_LU,
                     .Ks = {7, 7, Kp, Ki, diagonal},
                     .HN = {7, 3, Np, Ni, Nx},
                     .HT = {7, 3, Tp, Ti, Tx}};
}

static void expect_columns(const dlsi_columns *A, int rows, int cols, const int *p, const int *i,
                           const double *x) {
  ck_assert(A->rows == rows && A->cols == cols);
  for (int j = 0; j <= cols; j++)
    ck_assert_msg(A->p[j] == p[j], "p[%d] = %d, not %d", j, A->p[j], p[j]);
  for (int k = 0; k < p[cols]; k++)
    ck_assert_msg(A->i[k] == i[k] && A->x[k] == x[k], "%d: (%d, %g)", k, A->i[k], A->x[k]);
}

/* Candidates 0 and 2 are active, and the second one has no friction. */
TEST(active_candidates) {
  const double mu[] = {0.5, 9, 0};
  dls_model model = operator_model();
  model.P = (dls_sparse){3, 3, Pp, Pi, Px};
  model.active = some;
  model.mu = mu;
  dlsi_operator H;
  ck_assert_int_eq(dlsi_operator_create(&H, &model, 0, NULL), DLS_OK);
  ck_assert(H.d == 2 && H.candidates == 2 && H.kept == 5 && H.columns == 3);
  ck_assert(H.mu[0] == 0.5 && H.mu[1] == 0);
  ck_assert(dlsi_has_tangents(&H, 0) && !dlsi_has_tangents(&H, 1));
  expect_columns(&H.P, 3, 2, (int[]){0, 2, 3}, (int[]){0, 1, 2}, (double[]){0.25, 0.5, 2});
  expect_columns(&H.Ht, 4, 7, (int[]){0, 1, 3, 3, 4, 5, 6, 6}, (int[]){1, 0, 2, 0, 2, 1},
                 (double[]){0.25, 0.5, -2, 2, 2, 4});
  const int keep[] = {0, 1, 3, 4, 5};
  ck_assert_mem_eq(H.keep, keep, sizeof keep);
  dlsi_columns part;
  ck_assert_int_eq(dlsi_operator_columns(&H, 2, DLSI_ALL, &part, NULL), DLS_OK);
  expect_columns(&part, 7, 4, (int[]){0, 2, 4, 6, 6}, (int[]){1, 3, 0, 5, 1, 4},
                 (double[]){0.5, 2, 0.25, 4, -2, 2});
  dlsi_columns_free(&part);
  ck_assert_int_eq(dlsi_operator_columns(&H, 2, DLSI_NORMALS, &part, NULL), DLS_OK);
  expect_columns(&part, 7, 2, (int[]){0, 2, 4}, (int[]){1, 3, 1, 4}, (double[]){0.5, 2, -2, 2});
  dlsi_columns_free(&part);
  ck_assert_int_eq(dlsi_operator_columns(&H, 3, DLSI_TANGENTS, &part, NULL), DLS_OK);
  expect_columns(&part, 7, 4, (int[]){0, 2, 2, 2, 2}, (int[]){0, 5}, (double[]){0.25, 4});
  dlsi_columns_free(&part);
  dlsi_operator_free(&H);
  ck_assert(!H.keep && !H.mu && H.candidates == 0);
  dlsi_operator_free(&H);
  /* without mu all have tangents, one of them empty */
  model.mu = NULL;
  ck_assert_int_eq(dlsi_operator_create(&H, &model, 0, NULL), DLS_OK);
  ck_assert(!H.mu && H.columns == 3 && H.kept == 5 && H.Ht.rows == 4);
  ck_assert(dlsi_has_tangents(&H, 0) && dlsi_has_tangents(&H, 1));
  dlsi_operator_free(&H);
}

/* Without friction there is one row a candidate. The friction of an inactive one does not count. */
TEST(normals_alone) {
  double mu[] = {0, 9, 0};
  dls_model model = operator_model();
  model.active = some;
  dlsi_operator H;
  for (int with = 0; with < 2; with++) {
    model.mu = with ? mu : NULL;
    ck_assert_int_eq(dlsi_operator_create(&H, &model, 1, NULL), DLS_OK);
    ck_assert(H.d == 1 && H.candidates == 2 && H.kept == 2 && H.columns == 2);
    ck_assert(H.mu[0] == 0 && H.mu[1] == 0 && !dlsi_has_tangents(&H, 0));
    expect_columns(&H.P, 3, 2, (int[]){0, 1, 2}, (int[]){0, 2}, (double[]){1, 1});
    expect_columns(&H.Ht, 2, 7, (int[]){0, 0, 2, 2, 2, 3, 3, 3}, (int[]){0, 1, 1},
                   (double[]){2, -1, 1});
    dlsi_operator_free(&H);
  }
  mu[2] = 0.25;
  dls_error e;
  expect_error(dlsi_operator_create(&H, &model, 1, &e), &e, DLS_E_ARGUMENT, "", "mu", 2);
  ck_assert(e.value == 0.25);
  dlsi_operator_free(&H);
}

/* In space node k has the tangents 2 k and 2 k + 1, between the normals. */
TEST(two_tangents) {
  static const int np[] = {0, 1, 2}, ni[] = {0, 1}, tp[] = {0, 1, 2, 3, 4}, ti[] = {2, 3, 4, 5};
  static const double nx[] = {1, 2}, tx[] = {3, 4, 5, 6};
  dls_model model = operator_model();
  model.d = 3;
  model.nodes = 2;
  model.HN = (dls_sparse){7, 2, np, ni, nx};
  model.HT = (dls_sparse){7, 4, tp, ti, tx};
  dlsi_operator H;
  ck_assert_int_eq(dlsi_operator_create(&H, &model, 0, NULL), DLS_OK);
  ck_assert(H.d == 3 && H.columns == 6 && H.kept == 6);
  expect_columns(&H.Ht, 6, 7, (int[]){0, 1, 2, 3, 4, 5, 6, 6}, (int[]){0, 3, 1, 2, 4, 5},
                 (double[]){1, 2, 3, 4, 5, 6});
  double y[6] = {100, 100, 100, 100, 100, 100};
  dlsi_operator_add(&H, (int[]){4, 0, 6}, 3, (double[]){2, 7, 9}, y);
  const double expected[] = {107, 100, 100, 100, 110, 100};
  ck_assert_mem_eq(y, expected, sizeof y);
  dlsi_operator_free(&H);
}

/* ---- W --------------------------------------------------------------------------------------- */

/* Of the candidates above with K = diag(2^k): n_0 = (.5 at 1, 2 at 3), t_0 = (.25 at 0, 4 at 5),
 * n_2 = (-2 at 1, 2 at 4), t_2 = 0. */
TEST_EACH(influence_by_hand, 0, 3) {
  dls_model model = operator_model();
  model.P = (dls_sparse){3, 3, Pp, Pi, Px};
  model.active = some;
  model.factorization = (dls_factorization)(1 + _i);
  dlsi_operator H;
  dlsi_factor *factor;
  ck_assert_int_eq(dlsi_operator_create(&H, &model, 0, NULL), DLS_OK);
  ck_assert_int_eq(dlsi_factor_create(&factor, &model, 0, NULL, NULL), DLS_OK);
  ck_assert_int_eq(dlsi_factor_numeric(factor, &model, NULL), DLS_OK);
  double W[16];
  for (int k = 0; k < 16; k++)
    W[k] = 7;
  ck_assert_int_eq(dlsi_influence(factor, &H, W, NULL), DLS_OK);
  const double nn = 0.25 / 2 + 4. / 8, tt = 0.0625 + 16. / 32, mm = 4. / 2 + 4. / 16, nm = -1. / 2;
  const double expected[] = {nn, 0, nm, 0, 0, tt, 0, 0, nm, 0, mm, 0, 0, 0, 0, 0};
  for (int k = 0; k < 16; k++)
    ck_assert_msg(fabs(W[k] - expected[k]) <= 4 * DBL_EPSILON, "%d: %g", k, W[k]);
  dls_error e;
  for (int k = 1; k < 3; k++) { /* each malloc; the figure is that of 16 doubles */
    malloc_fails_at(k);
    const dls_status status = dlsi_influence(factor, &H, W, &e);
    malloc_fails_at(0);
    expect_error(status, &e, DLS_E_MEMORY, "", "", -1);
    ck_assert_ptr_nonnull(strstr(e.message, "W alone takes 1.28e-07 GB; dls_primal"));
  }
  H.Ht.x[3] = 1e300; /* 2 at 3, n_0: its square overflows in W alone */
  expect_error(dlsi_influence(factor, &H, W, &e), &e, DLS_E_NOT_FINITE, "", "W", 0);
  H.Ht.x[3] = 2;
  H.Ht.x[4] = 1e300; /* 2 at 4, n_2 */
  expect_error(dlsi_influence(factor, &H, W, &e), &e, DLS_E_NOT_FINITE, "", "W", 10);
  ck_assert(e.value > DBL_MAX);
  dlsi_factor_destroy(factor);
  dlsi_operator_free(&H);
}

/* W of an unsymmetric K stays so: (2 1; 0 1)^-1 = (.5 -.5; 0 1) on the unknowns 1 and 0. */
TEST(influence_without_symmetry) {
  static const int p[] = {0, 1, 3}, i[] = {0, 0, 1}, np[] = {0, 1}, ni[] = {1}, ti[] = {0};
  static const double x[] = {2, 1, 1}, one[] = {1};
  const dls_model model = {.d = 2,
                           .n = 2,
                           .nodes = 1,
                           .operator_kind = DLS_STIFFNESS_SPARSE,
                           .factorization = DLS_LU,
                           .Ks = {2, 2, p, i, x},
                           .HN = {2, 1, np, ni, one},
                           .HT = {2, 1, np, ti, one}};
  dlsi_operator H;
  dlsi_factor *factor;
  double W[4];
  ck_assert_int_eq(dlsi_operator_create(&H, &model, 0, NULL), DLS_OK);
  ck_assert_int_eq(dlsi_factor_create(&factor, &model, 0, NULL, NULL), DLS_OK);
  ck_assert_int_eq(dlsi_factor_numeric(factor, &model, NULL), DLS_OK);
  ck_assert_int_eq(dlsi_influence(factor, &H, W, NULL), DLS_OK);
  const double expected[] = {1, -0.5, 0, 0.5};
  ck_assert_mem_eq(W, expected, sizeof W);
  dlsi_factor_destroy(factor);
  dlsi_operator_free(&H);
}

enum { links = 300, touched = 80 };

/* 80 candidates on a chain of 300 unknowns, two on each of 80 unknowns, in batches of 64 columns or
 * from the Schur complement on these unknowns: K^-1 of (2 -1; -1 2 ..) is min(i, j) (n + 1 -
 * max(i, j)) / (n + 1), i and j counted from 1. */
TEST_EACH(influence_of_a_chain, 0, 6) {
  static int p[links + 1], i[3 * links], np[touched + 1], ni[touched], ti[touched];
  static double x[3 * links], one[touched], W[4 * touched * touched];
  const dls_factorization tag = (dls_factorization)(1 + _i / 2);
  int end = 0;
  for (int j = 0; j < links; j++) {
    for (int k = -1; k < 2; k++)
      if (j + k >= 0 && j + k < links) {
        i[end] = j + k;
        x[end++] = k ? -1 : 2;
      }
    p[j + 1] = end;
  }
  for (int c = 0; c < touched; c++) {
    np[c + 1] = c + 1;
    ni[c] = 3 * c + 7;
    ti[c] = 3 * (touched - 1 - c) + 7;
    one[c] = 1;
  }
  const dls_model model = {.d = 2,
                           .n = links,
                           .nodes = touched,
                           .operator_kind = DLS_STIFFNESS_SPARSE,
                           .factorization = tag,
                           .Ks = {links, links, p, i, x},
                           .HN = {links, touched, np, ni, one},
                           .HT = {links, touched, np, ti, one}};
  dlsi_operator H;
  dlsi_factor *factor;
  ck_assert_int_eq(dlsi_operator_create(&H, &model, 0, NULL), DLS_OK);
  ck_assert(H.kept == touched && H.columns == 2 * touched);
  const int kept = _i % 2 ? H.kept : 0;
  ck_assert_int_eq(dlsi_factor_create(&factor, &model, kept, H.keep, NULL), DLS_OK);
  ck_assert_int_eq(factor->kept, dlsi_schur_available() ? kept : 0);
  ck_assert_int_eq(dlsi_factor_numeric(factor, &model, NULL), DLS_OK);
  ck_assert_int_eq(dlsi_influence(factor, &H, W, NULL), DLS_OK);
  for (int b = 0; b < 2 * touched; b++)
    for (int a = 0; a < 2 * touched; a++) {
      const int k = 1 + (a % 2 ? ti : ni)[a / 2], l = 1 + (b % 2 ? ti : ni)[b / 2];
      const int low = k < l ? k : l, high = k < l ? l : k;
      const double expected = (double)low * (links + 1 - high) / (links + 1);
      const double w = W[a + 2 * touched * b];
      ck_assert_msg(fabs(w - expected) <= 1e-12 * links, "(%d, %d): %g", a, b, w - expected);
      if (tag != DLS_LU) ck_assert(w == W[b + 2 * touched * a]);
    }
  if (kept > 0) {
    dls_error e;
    malloc_fails_at(1);
    const dls_status status = dlsi_influence(factor, &H, W, &e);
    malloc_fails_at(0);
    ck_assert_int_eq(status, DLS_E_MEMORY);
    ck_assert_ptr_nonnull(strstr(e.message, "W alone takes 0.000205 GB"));
  }
  dlsi_factor_destroy(factor);
  dlsi_operator_free(&H);
}
