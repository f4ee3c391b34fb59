/* test_modes.c: the null space of small matrices, the springs on it and how their feet follow. */
#include <check.h>
#include <float.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "errors.h"
#include "reduction/reduction_internal.h"
#include "run.h"
#include "stiffness.h"

/* ---- feet ------------------------------------------------------------------------------------ */

static void expect_moves(dlsi_follow *follow, int count, const double *spring,
                         const double *stretch, const double *expected) {
  double move[3] = {7, 7, 7};
  dlsi_follow_step(follow, count, spring, stretch, move);
  for (int k = 0; k < 3; k++)
    ck_assert_msg(move[k] == (k < count ? expected[k] : 7), "%d: %g", k, move[k]);
}

/* S = diag(1, 4). M = 1, then with d = (4, 2), e = (-4, 0): (d + M e) dM / slope = (0, 2)(4, 8) /
 * -16, so that M = (1 0; .5 2); with d = (0, 4), e = (2, -1): (2, 3)(8, 32) / -16, so that M = (2
 * 4; 2 8). A stretch of the size of the one before, 2^2 + 4 = 8, makes M = 1 again. */
START_TEST(feet_of_two_springs) {
  const double spring[] = {1, 4};
  dlsi_follow follow = {0};
  expect_moves(&follow, 2, spring, (double[]){4, 2}, (double[]){4, 2});
  ck_assert(follow.turned && !follow.learnt);
  expect_moves(&follow, 2, spring, (double[]){0, 2}, (double[]){0, 4});
  ck_assert_int_eq(follow.learnt, 1);
  ck_assert(follow.M[0] == 1 && follow.M[1] == 0.5 && follow.M[2] == 0 && follow.M[3] == 2);
  expect_moves(&follow, 2, spring, (double[]){2, 1}, (double[]){8, 12});
  expect_moves(&follow, 2, spring, (double[]){-2, 1}, (double[]){-2, 1});
  ck_assert_int_eq(follow.learnt, 0);
  ck_assert(follow.M[0] == 1 && follow.M[1] == 0 && follow.M[2] == 0 && follow.M[3] == 1);
}
END_TEST

/* What has been learnt outlasts a new load: `turned` alone is 0 then. */
START_TEST(feet_of_another_load) {
  const double spring[] = {2};
  dlsi_follow follow = {0};
  expect_moves(&follow, 1, spring, (double[]){4}, (double[]){4});
  expect_moves(&follow, 1, spring, (double[]){2}, (double[]){4}); /* M = 2 */
  follow.turned = 0;
  expect_moves(&follow, 1, spring, (double[]){8}, (double[]){16});
  ck_assert(follow.stretch[0] == 8 && follow.move[0] == 16 && follow.turned == 1);
}
END_TEST

/* d^T S M e = -t d^T S d teaches for t > 1e-6 alone: with t = 2^-20 M becomes 1 / t, with t = 2^-19
 * its half, of both units of d and e. */
START_TEST(feet_that_feel_nothing) {
  const double spring[] = {3}, t = _i < 2 ? 0x1p-19 : 0x1p-20, unit = _i % 2 ? 1024 : 1;
  dlsi_follow follow = {0};
  double move;
  dlsi_follow_step(&follow, 1, spring, &unit, &move);
  const double less = unit * (1 - t);
  dlsi_follow_step(&follow, 1, spring, &less, &move);
  ck_assert_int_eq(follow.learnt, _i < 2);
  ck_assert(follow.M[0] == (_i < 2 ? 1 / t : 1));
}
END_TEST

/* With as many modes as there may be, the last of them, too. */
START_TEST(feet_of_all_modes) {
  double spring[dlsi_most_modes], stretch[dlsi_most_modes], move[dlsi_most_modes];
  dlsi_follow follow = {0};
  for (int k = 0; k < dlsi_most_modes; k++) {
    spring[k] = 1;
    stretch[k] = k + 1;
  }
  for (int turn = 0; turn < 2; turn++) {
    dlsi_follow_step(&follow, dlsi_most_modes, spring, stretch, move);
    ck_assert_mem_eq(move, stretch, sizeof move);
    ck_assert_mem_eq(follow.stretch, stretch, sizeof stretch);
  }
}
END_TEST

/* ---- springs --------------------------------------------------------------------------------- */

static stiffness S;

/* Entry (i, j) of a model. */
static double modes_at(const dls_model *model, int i, int j) {
  if (model->operator_kind == DLS_STIFFNESS_DENSE) return model->K.a[i + j * model->K.ld];
  double sum = 0;
  for (int e = model->Ks.p[j]; e < model->Ks.p[j + 1]; e++)
    if (model->Ks.i[e] == i) sum += model->Ks.x[e];
  return sum;
}

/* 0.1 K_jj; where that is not > 0, 0.1 times the largest entry of column j (of Ks three quarters of
 * it, as it stands there); 0.1 in an empty column. */
START_TEST(springs_of_each_kind) {
  const double rows[] = {0, 8, 0, 16, 0, 0, 0, 8, -2, 2, 0, 0, -4, 0, 0, 1};
  const double part = _i ? 0.75 : 1;
  stiffness_fill(&S, 4, rows, DLS_LU, _i);
  int unknown[] = {3, 1, 0, 2};
  double spring[5] = {7, 7, 7, 7, 7};
  dlsi_stable stable;
  const dlsi_modes modes = {.count = 4, .unknown = unknown};
  ck_assert_int_eq(dlsi_stable_create(&stable, &S.model, &modes, spring, NULL), DLS_OK);
  const double expected[] = {0.1, 0.1 * 8 * part, 0.1 * 4 * part, 0.1, 7};
  for (int k = 0; k < 5; k++)
    ck_assert_msg(fabs(spring[k] - expected[k]) <= 2 * DBL_EPSILON * expected[k], "%d: %g", k,
                  spring[k]);
  for (int j = 0; j < 4; j++)
    for (int i = 0; i < 4; i++) {
      double sum = rows[j + 4 * i];
      for (int k = 0; k < 4; k++)
        if (i == j && unknown[k] == i) sum += spring[k];
      ck_assert_double_eq_tol(modes_at(&stable.model, i, j), sum, 1e-15);
    }
  dlsi_stable_free(&stable);
}
END_TEST

/* No mode, no spring: the model itself. A negative K_jj, and entries below the diagonal, count by
 * their size. */
START_TEST(springs_of_other_models) {
  stiffness_fill(&S, 2, (double[]){-4, 0, 2, 1}, DLS_LU, _i);
  int unknown[] = {0};
  double spring = 7;
  dlsi_stable stable;
  ck_assert_int_eq(dlsi_stable_create(&stable, &S.model, &(dlsi_modes){0}, &spring, NULL), DLS_OK);
  ck_assert(spring == 7 && stable.model.K.a == S.a && stable.model.Ks.x == S.x);
  dlsi_stable_free(&stable);
  const dlsi_modes modes = {.count = 1, .unknown = unknown};
  ck_assert_int_eq(dlsi_stable_create(&stable, &S.model, &modes, &spring, NULL), DLS_OK);
  ck_assert_double_eq_tol(spring, _i ? 0.3 : 0.4, 1e-15);
  dlsi_stable_free(&stable);
}
END_TEST

/* ---- the null space -------------------------------------------------------------------------- */

/* Two pairs of unknowns tied by a spring, (0, 3) and (1, 4), each with one mode, and unknown 2,
 * held: of the modes the first `most` are handed out, each to its place, or their count alone. */
START_TEST(modes_by_their_number) {
  const double rows[] = {1, 0, 0,  -1, 0, 0, 2, 0, 0,  -2, 0, 0, 3,
                         0, 0, -1, 0,  0, 1, 0, 0, -2, 0,  0, 2};
  stiffness_fill(&S, 5, rows, _i / 2 ? DLS_LU : DLS_CHOLESKY, _i % 2);
  for (int most = 0; most <= 3; most++) {
    double basis[15];
    int unknown[3] = {-7, -7, -7}, alone[3] = {-7, -7, -7}, count = -1;
    for (int k = 0; k < 15; k++)
      basis[k] = 7;
    ck_assert_int_eq(dls_model_modes(&S.model, most, basis, unknown, &count, NULL), DLS_OK);
    ck_assert_int_eq(count, 2);
    ck_assert_int_eq(dls_model_modes(&S.model, most, NULL, alone, &count, NULL), DLS_OK);
    ck_assert_mem_eq(alone, unknown, sizeof alone);
    for (int c = 0; c < 3; c++) {
      if (c >= most || c >= 2) {
        ck_assert(unknown[c] == -7 && basis[5 * c] == 7 && basis[5 * c + 4] == 7);
        continue;
      }
      const int pair = unknown[c] % 3;
      ck_assert(pair < 2 && (c == 0 || pair != unknown[0] % 3));
      ck_assert(basis[5 * c + unknown[c]] == 1);
      for (int i = 0; i < 5; i++)
        ck_assert_double_le(fabs(basis[5 * c + i] - (i % 3 == pair)), 1e-12);
    }
    double again[15];
    for (int k = 0; k < 15; k++)
      again[k] = 7;
    ck_assert_int_eq(dls_model_modes(&S.model, most, again, NULL, &count, NULL), DLS_OK);
    ck_assert_mem_eq(again, basis, sizeof basis);
  }
  dls_error e;
  int count;
  const char *name = "dls_model_modes";
  expect_error(dls_model_modes(&S.model, -3, NULL, NULL, &count, &e), &e, DLS_E_SIZE, name, "most",
               -1);
  ck_assert(e.value == -3);
  expect_error(dls_model_modes(&S.model, 0, NULL, NULL, NULL, &e), &e, DLS_E_ARGUMENT, name,
               "count", -1);
  S.model.operator_kind = DLS_FLEXIBILITY;
  expect_error(dls_model_modes(&S.model, 0, NULL, NULL, &count, &e), &e, DLS_E_UNSUPPORTED, name,
               "operator_kind", -1);
  ck_assert(e.value == DLS_FLEXIBILITY);
}
END_TEST

/* K = (1 -1; -1 1 + t) has the singular values 2 and t / 2 up to t^2, and |K|_1 = 2: a null vector
 * if t <= 200 eps, up to the scales of (MO1), which are powers of 2 near 1. */
START_TEST(nearly_a_mode) {
  const double t = _i / 4 ? 400 * DBL_EPSILON : 100 * DBL_EPSILON;
  stiffness_fill(&S, 2, (double[]){1, -1, -1, 1 + t}, _i / 2 % 2 ? DLS_LU : DLS_LDLT, _i % 2);
  int count = -1;
  ck_assert_int_eq(dls_model_modes(&S.model, 0, NULL, NULL, &count, NULL), DLS_OK);
  ck_assert_int_eq(count, _i / 4 ? 0 : 1);
}
END_TEST

/* Of K = 0 every unknown is a mode of its own, up to 24 of them. */
START_TEST(modes_of_nothing) {
  static double rows[stiffness_dense_most * stiffness_dense_most];
  const int n = _i, all = n < 24 ? n : 24;
  stiffness_fill(&S, n, rows, n % 2 ? DLS_LU : DLS_CHOLESKY, n % 4 / 2);
  static double basis[24 * stiffness_dense_most];
  int unknown[24], count = -1;
  ck_assert_int_eq(dls_model_modes(&S.model, 24, basis, unknown, &count, NULL), DLS_OK);
  ck_assert_int_eq(count, all);
  for (int c = 0; c < all; c++)
    for (int k = 0; k < all; k++)
      ck_assert(basis[unknown[k] + c * n] == (c == k));
}
END_TEST

/* A pair tied by a spring, in units that differ by 2^20: its mode is x_0 = 2^20 x_1. */
START_TEST(modes_in_other_units) {
  const double u = 0x1p20, rows[] = {1, -u, -u, u * u};
  stiffness_fill(&S, 2, rows, _i / 2 ? DLS_LU : DLS_LDLT, _i % 2);
  double basis[2];
  int unknown, count;
  ck_assert_int_eq(dls_model_modes(&S.model, 1, basis, &unknown, &count, NULL), DLS_OK);
  ck_assert_int_eq(count, 1);
  const double other = unknown == 0 ? 1 / u : u;
  ck_assert(basis[unknown] == 1);
  ck_assert_double_le(fabs(basis[1 - unknown] - other), 1e-12 * other);
}
END_TEST

/* Takes modes that are given (n x count), from an array of no entry more; returns the status. */
static dls_status take(dlsi_modes *modes, const double *given, int count, int ld,
                       dls_error *error) {
  const size_t size = ((size_t)ld * (size_t)(count - 1) + (size_t)S.n) * sizeof *given;
  double *a = malloc(size);
  ck_assert_ptr_nonnull(a);
  memcpy(a, given, size);
  const dls_dense B = {S.n, count, ld, a};
  const dls_status status = dlsi_modes_create(modes, &S.model, B, error);
  free(a);
  return status;
}

/* |K x| <= 1e-8 |K||x| is a null vector: of K = (1 -1; -1 1), (1, 1 + t) leaves t of 2 (1 + t). */
START_TEST(given_modes_are_null_vectors) {
  stiffness_fill(&S, 2, (double[]){1, -1, -1, 1}, DLS_CHOLESKY, _i);
  dlsi_modes modes;
  dls_error e;
  double given[] = {1, 1, 9, 1, 1 + 0x1p-26, 9};
  ck_assert_int_eq(take(&modes, given, 1, 3, &e), DLS_OK);
  dlsi_modes_free(&modes);
  ck_assert_int_eq(take(&modes, given + 3, 1, 3, &e), DLS_OK); /* .75e-8 */
  ck_assert_int_eq(modes.count, 1);
  ck_assert_int_eq(modes.unknown[0], 0); /* as large but for 1e-6: the first */
  ck_assert(modes.basis[0] == 1 && fabs(modes.basis[1] - 1) < 1e-7);
  dlsi_modes_free(&modes);
  given[4] = 1 + 0x1p-25; /* 1.5e-8 */
  ck_assert_int_eq(take(&modes, given, 2, 3, &e), DLS_E_ARGUMENT);
  ck_assert_str_eq(e.argument, "modes");
  ck_assert_int_eq(e.index, 1);
  ck_assert_double_eq_tol(e.value, 0x1p-26, 1e-14);
  ck_assert_ptr_nonnull(strstr(e.message, "column 1 is no null vector of K: |K x| = 1.49e-08"));
  dlsi_modes_free(&modes);
}
END_TEST

/* Of K = 0 every vector is a null vector. (1, 0, 0) and (1, t, 0) are independent if t > 2e-8: the
 * second row has the length t / sqrt(2) once the first, sqrt(2), is taken out. What comes out are
 * unit vectors. A column of zeros is never independent. */
START_TEST(given_modes_are_independent) {
  static const double zero[9];
  stiffness_fill(&S, 3, zero, DLS_CHOLESKY, 0);
  dlsi_modes modes;
  dls_error e;
  double given[] = {1, 0, 0, 1, 2.1e-8, 0, 0, 0, 2};
  ck_assert_int_eq(take(&modes, given, 3, 3, &e), DLS_OK);
  ck_assert_int_eq(modes.count, 3);
  for (int c = 0; c < 3; c++)
    for (int i = 0; i < 3; i++)
      ck_assert(modes.basis[i + 3 * c] == (i == modes.unknown[c]));
  ck_assert(modes.unknown[0] == 0 && modes.unknown[1] == 1 && modes.unknown[2] == 2);
  dlsi_modes_free(&modes);
  given[4] = 1.9e-8;
  for (int turn = 0; turn < 2; turn++) {
    ck_assert_int_eq(take(&modes, given, turn ? 1 : 2, 3, &e), DLS_E_ARGUMENT);
    ck_assert_str_eq(e.argument, "modes");
    ck_assert(e.index == -1 && e.value == 0);
    ck_assert_int_eq(modes.count, 0);
    dlsi_modes_free(&modes);
    given[0] = 0;
  }
}
END_TEST

/* Each mode is reduced by the others, whatever their order: (1, 2, 0), (2, 1, 3) are orthogonal to
 * (2, -1, -1), so that row i of an orthonormal basis has the square 1 - (4, 1, 1) / 6. Rows 1 and 2
 * are the largest: (1, 2, 0) / 2 = (.5, 1, 0), (2, 1, 3) / 3 - (1, 2, 0) / 6 = (.5, 0, 1). */
START_TEST(given_modes_are_reduced) {
  static const double zero[9];
  stiffness_fill(&S, 3, zero, DLS_LU, 1);
  dlsi_modes modes;
  double given[] = {1, 2, 0, 2, 1, 3};
  ck_assert_int_eq(take(&modes, given, 2, 3, NULL), DLS_OK);
  ck_assert_int_eq(modes.unknown[0], 1);
  ck_assert_int_eq(modes.unknown[1], 2);
  const double expected[] = {0.5, 1, 0, 0.5, 0, 1};
  for (int k = 0; k < 6; k++)
    ck_assert_double_eq_tol(modes.basis[k], expected[k], 1e-15);
  dlsi_modes_free(&modes);
}
END_TEST

/* Rounding gives any basis of the null space; the unknowns are those of the space. The modes of
 * five nodes on a line of slope 0.3, in units of 1 and of 1000 lengths, and mixed. */
START_TEST(any_basis_has_the_same_unknowns) {
  enum { n = 10, count = 3 };
  static const double zero[n * n];
  static const double mix[4][count * count] = {{1, 0, 0, 0, 1, 0, 0, 0, 1},
                                               {1, 0, 0, 0, 1, 0, 0, 0, 1000},
                                               {0, 0, 1, -2, 0, 0, 0, 5, 0},
                                               {.6, .8, .1, -.8, .6, .3, .2, -.7, .5}};
  stiffness_fill(&S, n, zero, DLS_CHOLESKY, 0);
  double plain[n * count] = {0}, given[n * count] = {0}, first[n * count];
  for (int k = 0; k < n / 2; k++) {
    plain[2 * k] = plain[n + 2 * k + 1] = 1;
    plain[2 * n + 2 * k] = -.3 * k;
    plain[2 * n + 2 * k + 1] = k;
  }
  int unknown[count];
  for (int way = 0; way < 4; way++) {
    memset(given, 0, sizeof given);
    for (int c = 0; c < count; c++)
      for (int b = 0; b < count; b++)
        for (int i = 0; i < n; i++)
          given[i + c * n] += mix[way][b + c * count] * plain[i + b * n];
    dlsi_modes modes;
    ck_assert_int_eq(take(&modes, given, count, n, NULL), DLS_OK);
    if (way == 0) {
      memcpy(unknown, modes.unknown, sizeof unknown);
      memcpy(first, modes.basis, sizeof first);
    }
    ck_assert_mem_eq(modes.unknown, unknown, sizeof unknown);
    for (int e = 0; e < n * count; e++)
      ck_assert_double_eq_tol(modes.basis[e], first[e], 1e-13);
    dlsi_modes_free(&modes);
  }
}
END_TEST

int main(void) {
  return RUN("modes", NULL, NULL, ONCE(feet_of_two_springs), ONCE(feet_of_another_load),
             EACH(feet_that_feel_nothing, 0, 4), ONCE(feet_of_all_modes),
             EACH(springs_of_each_kind, 0, 2), EACH(springs_of_other_models, 0, 2),
             EACH(modes_by_their_number, 0, 4), EACH(nearly_a_mode, 0, 8),
             EACH(modes_of_nothing, 1, stiffness_dense_most + 1), EACH(modes_in_other_units, 0, 4),
             EACH(given_modes_are_null_vectors, 0, 2), ONCE(given_modes_are_independent),
             ONCE(given_modes_are_reduced), ONCE(any_basis_has_the_same_unknowns));
}
