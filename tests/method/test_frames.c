/* test_frames.c: the stiffness in the frames of the contact nodes, by hand. */
#include "run.h"
#include "vi/vi_internal.h"

enum { n = 4, ld = 6 };

static dls_error error;

/* Two unknowns of a node, 2 and 1, and two others; K dense with a leading dimension of its own, NaN
 * above the diagonal and below the matrix, and sparse with two entries in one place and zeros. */
typedef struct one_node {
  double K[ld * n], kx[16], nx[4], tx[4];
  int kp[n + 1], ki[16], np[2], ni[4], tp[2], ti[4];
  dls_model model;
} one_node;

static void node_make(one_node *s, int sparse) {
  *s = (one_node){
      .kp = {0, 4, 9, 13, 16},
      .ki = {0, 0, 2, 1, /**/ 0, 1, 2, 3, 1, /**/ 2, 3, 1, 0, /**/ 3, 1, 0},
      .kx = {5, 3, 2, 0, /**/ 77, 4, 1, 2, 12, /**/ 32, 0, 99, 99, /**/ 7, 99, 99},
      .np = {0, 3},
      .ni = {0, 2, 1},
      .nx = {0, 1, 1},
      .tp = {0, 3},
      .ti = {1, 2, 1},
      .tx = {-1, 2, 1},
  };
  /* K = [8 0 2 0; 0 16 1 2; 2 1 32 0; 0 2 0 7]; n = x_2 + x_1, t = 2 x_2 + 0 x_1 */
  static const double lower[n][n] = {{8, 0, 2, 0}, {0, 16, 1, 2}, {0, 0, 32, 0}, {0, 0, 0, 7}};
  for (int j = 0; j < n; j++)
    for (int i = 0; i < ld; i++)
      s->K[i + ld * j] = i >= j && i < n ? lower[j][i] : NAN;
  s->model = (dls_model){
      .d = 2,
      .n = n,
      .nodes = 1,
      .operator_kind = sparse ? DLS_STIFFNESS_SPARSE : DLS_STIFFNESS_DENSE,
      .K = {n, n, ld, s->K},
      .Ks = {n, n, s->kp, s->ki, s->kx},
      .HN = {n, 1, s->np, s->ni, s->nx},
      .HT = {n, 1, s->tp, s->ti, s->tx},
  };
}

/* B = (n, t) = [1 2; 1 0] in the order (2, 1), T = B^-T = [0 1; 1/2 -1/2] by columns: x_2 = x'_t /
 * 2, x_1 = x'_n - x'_t / 2. K' = T^T K T with K_22 = 32, K_11 = 16, K_21 = 1:
 *   K'_nn = 16, K'_nt = 1/2 - 8 = -7.5, K'_tt = 8 - 1/2 + 4 = 11.5;
 *   K_20 = 2: K'_t0 = 1; K_13 = 2: K'_n3 = 2, K'_t3 = -1. */
static const double turned[n][n] = {
    {8, 1, 0, 0}, {1, 11.5, -7.5, -1}, {0, -7.5, 16, 2}, {0, -1, 2, 7}};

TEST(a_frame_by_hand) {
  for (int sparse = 0; sparse < 2; sparse++) {
    one_node s;
    node_make(&s, sparse);
    dlsi_frames a;
    ck_assert_int_eq(dlsi_frames_create(&a, &s.model, &error), DLS_OK);
    ck_assert(a.n == n && a.nodes == 1 && a.normal[0] == 2 && a.tangent[0] == 1);
    ck_assert(a.node[0] == -1 && a.node[1] == 0 && a.node[2] == 0 && a.node[3] == -1);
    static const double T[4] = {0, 1, .5, -.5};
    for (int k = 0; k < 4; k++)
      ck_assert(a.T[k] == T[k]);
    double K[n][n] = {{0}};
    ck_assert(a.start[0] == 0);
    for (int j = 0; j < n; j++) {
      for (size_t k = a.start[j]; k < a.start[j + 1]; k++) {
        ck_assert(K[j][a.row[k]] == 0); /* each row once */
        K[j][a.row[k]] = a.value[k];
      }
      ck_assert(a.diagonal[j] == turned[j][j]);
    }
    for (int j = 0; j < n; j++)
      for (int i = 0; i < n; i++)
        ck_assert(K[j][i] == turned[j][i]);
    /* those of `turned` that are not 0 and no other */
    ck_assert_int_eq((long long)a.start[n], 12);
    ck_assert(dlsi_frames_coupling(&a, 0) == -7.5);
    dlsi_frames_free(&a);
  }
}

/* f' = T^T f, x = T x', x' = T^-1 x = B^T x, in place and not. */
TEST(vectors_by_hand) {
  static const double from[n] = {3, 4, 6, 5};
  static const double expected[3][n] = {{3, 1, 4, 5}, {3, 4, 2, 5}, {3, 12, 10, 5}};
  void (*const turn[3])(const dlsi_frames *, const double *, double *) = {
      dlsi_frames_forces, dlsi_frames_unknowns, dlsi_frames_positions};
  one_node s;
  node_make(&s, 0);
  dlsi_frames a;
  ck_assert_int_eq(dlsi_frames_create(&a, &s.model, &error), DLS_OK);
  for (int k = 0; k < 3; k++) {
    double to[n], same[n];
    memcpy(same, from, sizeof same);
    turn[k](&a, from, to);
    turn[k](&a, same, same);
    for (int i = 0; i < n; i++)
      ck_assert(to[i] == expected[k][i] && same[i] == expected[k][i]);
  }
  dlsi_frames_free(&a);
}

static void expect_refused(const one_node *s, dls_status status, const char *argument, int index,
                           const char *says) {
  dlsi_frames a;
  ck_assert_int_eq(dlsi_frames_create(&a, &s->model, &error), status);
  ck_assert_str_eq(error.argument, argument);
  ck_assert_int_eq(error.index, index);
  ck_assert_msg(strstr(error.message, says) != NULL, "%s", error.message);
  dlsi_frames_free(&a);
}

/* n and t of an angle: 1e-8 of their lengths is too little, twice as much is not. */
TEST(nearly_parallel) {
  one_node s;
  dlsi_frames a;
  for (int k = 0; k < 2; k++) {
    node_make(&s, 0);
    s.nx[1] = 1024; /* n = (1024, 0), t = (1/8, e) */
    s.nx[2] = 0;
    s.tx[0] = 0;
    s.tx[1] = .125;
    s.tx[2] = .125 * (k == 0 ? .9e-8 : 1.9e-8);
    if (k == 0)
      expect_refused(&s, DLS_E_UNSUPPORTED, "HT", 0, "parallel");
    else
      ck_assert_int_eq(dlsi_frames_create(&a, &s.model, &error), DLS_OK);
  }
  ck_assert(a.normal[0] == 2 && a.tangent[0] == 1);
  dlsi_frames_free(&a);
}

/* The pivot K'_tt - K'_nt^2 / K'_nn of the node, 0 and 1/16; the number is that of the tangent. */
TEST(pivot_within_a_node) {
  one_node s;
  dlsi_frames a;
  for (int k = 0; k < 2; k++) {
    node_make(&s, 0);
    s.nx[2] = 0; /* n = x_2, t = x_1 */
    s.tx[0] = 0;
    s.tx[1] = 0;
    s.K[2 + ld * 2] = 16;
    s.K[2 + ld * 1] = 4;
    s.K[1 + ld * 1] = k == 0 ? 1 : 1.0625;
    if (k == 0) {
      expect_refused(&s, DLS_E_NOT_POSITIVE_DEFINITE, "K", 1, "unknown 1 within contact node 0");
      ck_assert(error.value == 0);
    } else
      ck_assert_int_eq(dlsi_frames_create(&a, &s.model, &error), DLS_OK);
  }
  ck_assert(dlsi_frames_coupling(&a, 0) == 4);
  dlsi_frames_free(&a);
  s.K[1 + ld * 1] = 0;
  expect_refused(&s, DLS_E_NOT_POSITIVE_DEFINITE, "K", 1, "diagonal entry of unknown 1 is 0");
}

/* A third unknown of HN, of HT; none at all; one alone, of both. */
TEST(unknowns_of_a_node) {
  one_node s;
  node_make(&s, 0);
  s.nx[0] = 1;
  expect_refused(&s, DLS_E_UNSUPPORTED, "HN", 0, "acts on more than two");
  node_make(&s, 0);
  s.ti[1] = 3;
  expect_refused(&s, DLS_E_UNSUPPORTED, "HT", 0, "with HN, on more than two");
  node_make(&s, 0);
  s.nx[1] = s.nx[2] = 0;
  expect_refused(&s, DLS_E_UNSUPPORTED, "HN", 0, "acts on no unknown");
  node_make(&s, 0);
  s.nx[2] = s.tx[0] = s.tx[2] = 0;
  expect_refused(&s, DLS_E_UNSUPPORTED, "HT", 0, "parallel");
}
