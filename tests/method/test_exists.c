/* test_exists.c: what W alone proves about solutions (vi/exists.c), on matrices worked by hand. */
#include "cases.h"
#include "run.h"
#include "vi/vi_internal.h"

typedef struct solvable {
  double W[4]; /* one candidate, d = 2, by columns */
  double mu;
  int exists, semidefinite;
} solvable;

static const solvable hands[] = {
    {{1, -.9, -.9, 1}, 0, 1, 1},  /* pivots 1 and 1 - .81 */
    {{1, -.9, -.9, .8}, 3, 0, 0}, /* .8 - .81 < 0, and no x keeps apart with that friction */
    {{1, -1, 3, 1}, 0, 1, 1},     /* symmetric part of ones: singular; x = (1, 0) keeps apart */
    {{4, 1, 1, 9}, 5, 1, 1},      /* definite, whatever the friction */
    {{1, 0, 0, -1}, 2, 1, 0},     /* indefinite; x = (1, 0) moves along the normal alone */
    {{-1, 0, 0, -1}, 0, 0, 0},    {{0, 0, 0, 0}, 0, 0, 1}, /* a shift makes it definite */
};

TEST_EACH(what_one_candidate_tells, 0, sizeof hands / sizeof hands[0]) {
  const solvable *h = &hands[_i];
  const double q[2] = {-1, 0}, w[1] = {1};
  double J[4], room[4][2], *const v[4] = {room[0], room[1], room[2], room[3]};
  const dls_contact p = {.d = 2, .nc = 1, .W = {2, 2, 2, h->W}, .q = q, .mu = &h->mu};
  ck_assert_int_eq(dlsi_solution_exists(&p, w, J, v), h->exists);
  ck_assert_int_eq(dlsi_is_semidefinite(&p, w, J), h->semidefinite);
}
