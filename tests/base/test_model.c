/* test_model.c: K read whole or by its lower triangle; sizes at their limits. */
#include "contact/body.h"
#include "contact/contact.h"
#include "delassus/model.h"
#include "run.h"

enum { n = 3, ld = 5 };

/* A model without contact nodes: of K alone. */
static dls_model dense(const double *K, dls_factorization factorization) {
  return (dls_model){.d = 2,
                     .n = n,
                     .operator_kind = DLS_STIFFNESS_DENSE,
                     .factorization = factorization,
                     .K = {n, n, ld, K}};
}

static dls_model sparse(const int *p, const int *i, const double *x, dls_factorization by) {
  return (dls_model){.d = 2,
                     .n = n,
                     .operator_kind = DLS_STIFFNESS_SPARSE,
                     .factorization = by,
                     .Ks = {n, n, p, i, x}};
}

static void model_accepts(const dls_model *model) {
  dls_error e = {.message = ""};
  ck_assert_msg(dls_model_check(model, &e) == DLS_OK, "%s", e.message);
}

static void model_refuses(const dls_model *model, dls_status status, const char *argument,
                          long long index, double value, const char *words) {
  dls_error e;
  ck_assert_int_eq(dls_model_check(model, &e), status);
  ck_assert_str_eq(e.argument, argument);
  ck_assert_int_eq(e.index, index);
  ck_assert(e.value == value || (e.value != e.value && value != value));
  ck_assert_msg(strstr(e.message, words) != NULL, "%s", e.message);
}

/* Of a symmetric K the entries on and below the diagonal are read, of another one all. */
TEST(entries_that_are_read) {
  double K[ld * n];
  for (int at = 0; at < ld * n; at++) {
    const int i = at % ld, j = at / ld;
    for (int e = 0; e < ld * n; e++)
      K[e] = 1;
    K[at] = NAN;
    for (int by = 0; by < 3; by++) {
      const dls_factorization of[3] = {DLS_CHOLESKY, DLS_LDLT, DLS_LU};
      const dls_model model = dense(K, of[by]);
      char words[40];
      (void)snprintf(words, sizeof words, "(row %d, column %d)", i, j);
      if (i < n && (i >= j || by == 2))
        model_refuses(&model, DLS_E_NOT_FINITE, "K", at, NAN, words);
      else
        model_accepts(&model);
    }
  }
  dls_model tight = dense(K, DLS_CHOLESKY);
  for (int e = 0; e < ld * n; e++)
    K[e] = 1;
  tight.K.ld = n;
  model_accepts(&tight);
  tight.K.ld = n - 1;
  model_refuses(&tight, DLS_E_SIZE, "K", -1, 2, "leading dimension 2 is less than 3");
  tight.K = (dls_dense){n, n + 1, ld, K};
  model_refuses(&tight, DLS_E_SIZE, "K", -1, 3, "is 3 x 4, must be 3 x 3");
}

/* DLS_LU refuses a lower triangle, unless it is said to be all of K; zeros do not count, and the
 * last entry below is named. */
TEST(triangles_for_lu) {
  double K[ld * n] = {[0] = 1, [ld + 1] = 1, [2 * ld + 2] = 1};
  dls_model model = dense(K, DLS_LU);
  model_accepts(&model); /* a diagonal */
  K[1] = -4, K[ld + 2] = 5;
  model_refuses(&model, DLS_E_ARGUMENT, "K", ld + 2, 0, "is a lower triangle");
  model.triangular = 1;
  model_accepts(&model);
  model.triangular = 0;
  K[2 * ld] = 1e-300; /* one entry above */
  model_accepts(&model);
  K[1] = K[ld + 2] = 0; /* an upper triangle is all of it */
  model_accepts(&model);
  K[2 * ld] = 0, K[2] = 7;
  model_refuses(&model, DLS_E_ARGUMENT, "K", 2, 0, "is a lower triangle");

  const int p[n + 1] = {0, 3, 5, 7}, i[7] = {0, 2, 1, 1, 2, 2, 0};
  double x[7] = {1, -2, 3, 1, -5, 1, 0};
  model = sparse(p, i, x, DLS_LU);
  model_refuses(&model, DLS_E_ARGUMENT, "Ks", 4, 0, "is a lower triangle");
  x[4] = 0;
  model_refuses(&model, DLS_E_ARGUMENT, "Ks", 2, 0, "is a lower triangle");
  model.triangular = 1;
  model_accepts(&model);
  model.triangular = 0;
  x[6] = -1;
  model_accepts(&model);
  x[6] = x[1] = x[2] = 0; /* a diagonal */
  model_accepts(&model);
}

/* Entries at position 0 count, too: in a column 0 that is empty, or alone in it. */
TEST(triangles_from_the_first_entry) {
  const int late[n + 1] = {0, 0, 2, 2}, early[n + 1] = {0, 1, 1, 1}, row[2] = {0, 2};
  const double x[2] = {1, 1};
  dls_model model = sparse(late, row, x, DLS_LU);
  model_accepts(&model);
  model = sparse(early, row + 1, x, DLS_LU);
  model_refuses(&model, DLS_E_ARGUMENT, "Ks", 0, 0, "is a lower triangle");
  const int above[n + 1] = {0, 0, 1, 1};
  model = sparse(above, row, x, DLS_CHOLESKY);
  model_refuses(&model, DLS_E_ARGUMENT, "Ks", 0, 1, "is an upper triangle");
}

/* Cholesky refuses an upper triangle, by its pattern, and names its last entry. */
TEST(triangles_for_cholesky) {
  const int p[n + 1] = {0, 1, 3, 5}, upper[5] = {0, 0, 1, 1, 2}, diagonal[5] = {0, 1, 1, 2, 2};
  const int both[5] = {2, 0, 1, 1, 2};
  const double x[5] = {1, 2, 3, 4, 5};
  dls_model model = sparse(p, upper, x, DLS_CHOLESKY);
  model_refuses(&model, DLS_E_ARGUMENT, "Ks", 3, 4, "is an upper triangle");
  model.Ks.i = diagonal;
  model_accepts(&model);
  model.Ks.i = both;
  model_accepts(&model);
}

/* Sizes at their limits. */
TEST(limits_of_sizes) {
  const double K[ld * n] = {[0] = 1, [ld + 1] = 1, [2 * ld + 2] = 1};
  const double ones[1] = {1};
  dls_model model = dense(K, DLS_CHOLESKY), one;
  const int none[3] = {0, 0, 0};
  model.nodes = 1;
  model_refuses(&model, DLS_E_SIZE, "HN", -1, 0, "is 0 x 0, must be 3 x 1");
  model.HN = (dls_sparse){n, 1, none, NULL, NULL};
  model_refuses(&model, DLS_E_SIZE, "HT", -1, 0, "is 0 x 0, must be 3 x 1");
  model.d = 3;
  model.HT = (dls_sparse){n, 2, none, NULL, NULL};
  model_accepts(&model);
  ck_assert_int_eq(dlsi_model_candidates(&model), 1);
  model.nodes = INT_MAX / 3 + 1;
  model_refuses(&model, DLS_E_SIZE, "nodes", -1, INT_MAX / 3 + 1, "is 715827883");
  model.nodes = INT_MAX / 3; /* as many as there can be: H is at fault */
  model_refuses(&model, DLS_E_SIZE, "HN", -1, 3, "must be 3 x 715827882");
  one = (dls_model){.d = 2, .n = 1, .operator_kind = DLS_FLEXIBILITY, .K = {1, 1, 1, ones}};
  model_accepts(&one);
}

/* A weighting makes the candidates; its largest number, an entry 0 beside one that is not. */
TEST(weightings) {
  const double K[ld * n] = {[0] = 1, [ld + 1] = 1, [2 * ld + 2] = 1};
  const int p[3] = {0, 2, 3}, i[3] = {0, 0, 0}, none[2] = {0, 0};
  double x[3] = {0, 1, 2}, mu[2] = {0, 1};
  dls_model model = dense(K, DLS_CHOLESKY);
  model.nodes = 1;
  model.HN = model.HT = (dls_sparse){n, 1, none, NULL, NULL};
  model.P = (dls_sparse){1, 2, p, i, x};
  model.mu = mu;
  model_accepts(&model);
  ck_assert_int_eq(dlsi_model_candidates(&model), 2);
  mu[1] = -2;
  model_refuses(&model, DLS_E_ARGUMENT, "mu", 1, -2, "is negative");
  model.mu = NULL;
  x[0] = -0.5; /* beside 1: a column of quadratic edges may have such entries */
  model_accepts(&model);
  x[0] = -3;
  model_refuses(&model, DLS_E_ARGUMENT, "P", 0, -2, "column 0 adds up to -2");
  x[0] = 0, x[2] = 0;
  model_refuses(&model, DLS_E_ARGUMENT, "P", 1, 0, "column 1 adds up to 0");
  model.P.cols = INT_MAX / 2 + 1;
  model_refuses(&model, DLS_E_SIZE, "P", -1, INT_MAX / 2 + 1, "has 1073741824 columns");
}

/* Two frames without stiffness or contacts, each of two bodies, a joint between them and one to the
 * ground: no diagonal entry tells bodies and joints apart, the order does. */
TEST_EACH(joints_without_stiffness, 0, 2) {
  const int is_joint[2][8] = {{0, 0, 0, 0, 1, 1, 1, 1}, {0, 1, 0, 1, 0, 0, 1, 1}};
  const int frame[2][8] = {{0, 1, 0, 1, 0, 0, 1, 1}, {0, 0, 0, 0, 1, 1, 1, 1}};
  double K[64] = {0};
  int body[2][2], joint[2][2], count[2][2] = {{0}}, found[8];
  for (int k = 0; k < 8; k++) {
    const int of = frame[_i][k], is = is_joint[_i][k];
    (is ? joint : body)[of][count[is][of]++] = k;
  }
  for (int of = 0; of < 2; of++)
    for (int k = 0; k < 2; k++)
      for (int l = k; l < 2; l++) {
        const int i = body[of][l], j = joint[of][k + l == 2 ? 1 : 0];
        K[i + 8 * j] = K[j + 8 * i] = k == l ? 1 : -1;
      }
  const dls_model model = {.d = 2,
                           .n = 8,
                           .operator_kind = DLS_STIFFNESS_DENSE,
                           .factorization = DLS_LDLT,
                           .K = {8, 8, 8, K}};
  ck_assert_int_eq(dlsi_body_joints(&model, NULL, found), 4);
  ck_assert_mem_eq(found, is_joint[_i], sizeof found);
}
