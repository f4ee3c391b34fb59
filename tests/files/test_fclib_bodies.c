/* test_fclib_bodies.c: which global problems are read as rigid bodies, and the result. */
#include "files/fclib_bodies.h"
#include "run.h"

enum { entries = 16 };

/* Two bodies in 2D, M_1 = diag(4, 4, 1), M_2 = [4 2 0; 2 5 0; 0 0 9], and entries between them that
 * are 0; one candidate. */
typedef struct two_bodies {
  int Mp[7], Mi[entries], Hp[2][2], Hi[2][4];
  double Mx[entries], Hx[2][4];
  double f[6], w[2];
  dlsi_fclib_global of;
} two_bodies;

static void make_two(two_bodies *t) {
  *t = (two_bodies){
      .Mp = {0, 2, 3, 4, 6, 9, 10},
      .Mi = {0, 3, 1, 2, 3, 4, 0, 3, 4, 5},
      .Mx = {4, 0, 4, 1, 4, 2, 0, 2, 5, 9},
      .Hp = {{0, 2}, {0, 4}},
      .Hi = {{0, 4}, {1, 2, 3, 5}},
      .Hx = {{1, -2}, {1, 3, 4, 6}},
      .f = {2, 4, 5, 2, 7, 3},
      .w = {10, 20},
  };
  t->of = (dlsi_fclib_global){.d = 2,
                              .nc = 1,
                              .M = {6, 6, t->Mp, t->Mi, t->Mx},
                              .HN = {6, 1, t->Hp[0], t->Hi[0], t->Hx[0]},
                              .HT = {6, 1, t->Hp[1], t->Hi[1], t->Hx[1]},
                              .f = t->f,
                              .w = t->w};
}

static void expect_none(const two_bodies *t) {
  dlsi_fclib_bodies B;
  ck_assert_int_eq(dlsi_fclib_bodies_create(&B, &t->of, NULL), DLS_OK);
  ck_assert_ptr_null(B.body);
  dlsi_fclib_bodies_free(&B);
}

/* H_1 := L_1^-1 H_1, L_1 = diag(2, 2, 1); H_2 := L_2^-1 H_2, L_2 = [2 0 0; 1 2 0; 0 0 3];
 * q = w + H^T (1, 2, 5, 1, 3, 1). */
TEST(two_bodies_by_hand) {
  static const double H[12] = {.5, 0, 0, 0, .5, 3, 0, -1, 0, 2, -1, 2};
  two_bodies t;
  dlsi_fclib_bodies B;
  make_two(&t);
  ck_assert_int_eq(dlsi_fclib_bodies_create(&B, &t.of, NULL), DLS_OK);
  ck_assert(B.n == 3 && B.count == 2 && B.body && B.body[0] == 0 && B.body[1] == 1);
  ck_assert_mem_eq(B.H, H, sizeof H);
  ck_assert(B.q[0] == 7.5 && B.q[1] == 37);
  dlsi_fclib_bodies_free(&B);
  ck_assert_ptr_null(B.body);
}

/* Another place of M than its blocks; M_2 not symmetric; M_1, M_2 not positive definite. */
TEST_EACH(other_matrices_are_no_bodies, 0, 7) {
  static const struct {
    int k;
    double x;
  } change[] = {{1, 1e-300}, {6, -3}, {5, 3}, {0, 0}, {3, -1}, {8, 1}, {9, 0}};
  two_bodies t;
  make_two(&t);
  t.Mx[change[_i].k] = change[_i].x;
  expect_none(&t);
}

TEST(other_shapes_are_no_bodies) {
  two_bodies t;
  make_two(&t);
  t.of.M.rows = t.of.M.cols = 4; /* no whole number of bodies */
  expect_none(&t);
  make_two(&t);
  t.of.d = 3; /* of six motions each: the two blocks are one body, and HT has one column of two */
  t.of.nc = 0;
  expect_none(&t);
}

/* A third body in a row of H, and one that its number 0 leaves out. */
TEST(a_candidate_moves_two_bodies) {
  for (int third = 0; third < 2; third++) {
    int Mp[10], Mi[9], Hp[2][2] = {{0, 2}, {0, 2}}, Hi[2][2] = {{0, 3}, {3, 6}};
    double Mx[9], f[9] = {0}, Hx[2][2] = {{1, -1}, {1, third ? -1 : 0}}, w[2] = {0};
    for (int j = 0; j < 9; j++) {
      Mp[j] = Mi[j] = j;
      Mx[j] = 1;
    }
    Mp[9] = 9;
    const dlsi_fclib_global of = {.d = 2,
                                  .nc = 1,
                                  .M = {9, 9, Mp, Mi, Mx},
                                  .HN = {9, 1, Hp[0], Hi[0], Hx[0]},
                                  .HT = {9, 1, Hp[1], Hi[1], Hx[1]},
                                  .f = f,
                                  .w = w};
    dlsi_fclib_bodies B;
    ck_assert_int_eq(dlsi_fclib_bodies_create(&B, &of, NULL), DLS_OK);
    ck_assert_int_eq(B.body == NULL, third);
    dlsi_fclib_bodies_free(&B);
  }
}

/* A candidate with the ground beside one body: its second body is none. */
TEST(one_body_on_the_ground) {
  two_bodies t;
  dlsi_fclib_bodies B;
  make_two(&t);
  t.Hp[0][1] = 1;
  t.Hp[1][1] = 2;
  ck_assert_int_eq(dlsi_fclib_bodies_create(&B, &t.of, NULL), DLS_OK);
  ck_assert(B.body && B.body[0] == 0 && B.body[1] == -1);
  ck_assert(B.q[0] == 10.5 && B.q[1] == 36);
  for (int k = 6; k < 12; k++)
    ck_assert(B.H[k] == 0);
  dlsi_fclib_bodies_free(&B);
}
