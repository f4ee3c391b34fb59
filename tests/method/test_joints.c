/* test_joints.c: W + R on the motions of the joints, against W + R itself. */
#include "cases.h"
#include "rigid.h"
#include "run.h"
#include "vi/split/joints.h"

typedef struct pair {
  rigid a;
  int m;
  double *S, *q, *rho, *p, *x, *y, *g;
} pair;

/* Scales S that differ by up to 2, rho from 1e-8 to 1e-5; one candidate in five is without
 * friction. */
static pair pair_build(const char *kind, int candidates) {
  pair s;
  ck_assert_int_eq(rigid_create(&s.a, kind, candidates, 0.5, 2), 0);
  const int d = s.a.d, nc = s.a.contact.nc, m = s.m = d * nc;
  double **const arrays[] = {&s.S, &s.q, &s.rho, &s.p, &s.x, &s.y, &s.g};
  for (int k = 0; k < 7; k++) {
    *arrays[k] = calloc((size_t)m, sizeof(double));
    ck_assert_ptr_nonnull(*arrays[k]);
  }
  set_seed(7);
  for (int i = 0; i < m; i++) {
    s.S[i] = i / d % 5 == 4 && i % d ? 0 : 1.5 + 0.5 * uniform();
    s.q[i] = s.S[i] * s.a.q[i];
    s.p[i] = uniform();
  }
  for (int c = 0; c < nc; c++)
    s.rho[c] = pow(10, -6.5 + 1.5 * uniform());
  return s;
}

static void pair_free(pair *s) {
  double *const arrays[] = {s->S, s->q, s->rho, s->p, s->x, s->y, s->g};
  for (int k = 0; k < 7; k++)
    free(arrays[k]);
  rigid_free(&s->a);
}

/* y := S W S x */
static void pair_apply(const pair *s, const double *x, double *y) {
  double *Sx = calloc((size_t)s->m, sizeof *Sx);
  ck_assert_ptr_nonnull(Sx);
  for (int i = 0; i < s->m; i++)
    Sx[i] = s->S[i] * x[i];
  dlsi_contact_apply(&s->a.contact, Sx, y);
  for (int i = 0; i < s->m; i++)
    y[i] *= s->S[i];
  free(Sx);
}

/* (W + R) x = R p - q for a q in the range of W: of walls and towers on half of the unknowns. */
TEST_EACH(solves, 0, 6) {
  static const struct {
    const char *kind;
    int size;
    double share; /* of the unknowns, at most */
  } cases[] = {{"wall-pushed", 300, 0.76}, {"wall3-pushed", 600, 0.51}, {"tower", 300, 0.51},
               {"chain", 100, 1},          {"arch3", 100, 0.51},        {"packing-rest", 300, 1}};
  for (int even = 0; even < 2; even++) {
    pair s = pair_build(cases[_i].kind, cases[_i].size);
    dlsi_joints *work;
    for (int c = 0; even && c < s.a.contact.nc; c++)
      s.rho[c] = 1e-8;
    ck_assert_int_eq(dlsi_joints_create(&work, &s.a.contact, s.S, 1, NULL), DLS_OK);
    ck_assert(work->n <= cases[_i].share * s.m);
    memcpy(s.x, s.q, (size_t)s.m * sizeof *s.x);
    dlsi_joints_split(work, s.x, s.g);
    ck_assert(largest(s.x, s.m) == 0); /* all of q is in the range */
    ck_assert_int_eq(dlsi_joints_factor(work, s.rho), 0);
    ck_assert_int_eq(dlsi_joints_solve(work, s.rho, s.p, s.g, s.x, NULL), DLS_OK);
    pair_apply(&s, s.x, s.y);
    double worst = 0;
    for (int i = 0; i < s.m; i++) {
      const double rho = s.rho[i / s.a.d];
      worst = fmax(worst, fabs(s.y[i] + rho * (s.x[i] - s.p[i]) + s.q[i]));
      if (s.S[i] == 0) ck_assert(s.x[i] == s.p[i]);
    }
    const double size = largest(s.q, s.m) + largest(s.S, s.m) * largest(s.x, s.m);
    ck_assert_msg(worst <= 1e-11 * size, "%s: %g of %g", cases[_i].kind, worst, size);
    dlsi_joints_destroy(work);
    pair_free(&s);
  }
}

/* What is not in the range of W stays, and W that is not symmetric is no structure. */
TEST(splits_and_refuses) {
  pair s = pair_build("wall3-rest", 300);
  dlsi_joints *work;
  ck_assert_int_eq(dlsi_joints_create(&work, &s.a.contact, s.S, 1, NULL), DLS_OK);
  memcpy(s.x, s.p, (size_t)s.m * sizeof *s.x);
  dlsi_joints_split(work, s.x, s.g);
  pair_apply(&s, s.x, s.y); /* Q^T x = 0, so that W x = 0 */
  ck_assert(largest(s.x, s.m) > 0.1 && largest(s.y, s.m) <= 1e-12 * largest(s.a.x, 9));
  dlsi_joints_destroy(work);
  for (int e = 0; e < 9; e++)
    s.a.x[9 * (s.a.p[3] + (s.a.i[s.a.p[3]] == 3)) + e] += 1;
  ck_assert_int_eq(dlsi_joints_create(&work, &s.a.contact, s.S, 1, NULL), DLS_STALLED);
  ck_assert_ptr_null(work);
  pair_free(&s);
}

/* The first candidate has more neighbours than any other: (W + R) x = R p - q of
 * W = (2 1 1 1; 1 2 0 0; 1 0 2 0; 1 0 0 2), R = 1, q = 0, p = W (1, 2, 3, 4) + (1, 2, 3, 4). */
TEST(a_star) {
  static const int p[5] = {0, 4, 6, 8, 10}, i[10] = {0, 1, 2, 3, 0, 1, 0, 2, 0, 3};
  static const double x[10] = {2, 1, 1, 1, 1, 2, 1, 2, 1, 2}, ones[4] = {1, 1, 1, 1}, q[4] = {0};
  static const double to[4] = {12, 7, 10, 13};
  const dls_contact star = {.d = 1, .nc = 4, .Wb = {1, 4, p, i, x}, .q = q, .mu = q};
  double split[4] = {0}, g[4], found[4];
  dlsi_joints *work;
  ck_assert_int_eq(dlsi_joints_create(&work, &star, ones, 1, NULL), DLS_OK);
  dlsi_joints_split(work, split, g);
  ck_assert_int_eq(dlsi_joints_factor(work, ones), 0);
  ck_assert_int_eq(dlsi_joints_solve(work, ones, to, g, found, NULL), DLS_OK);
  for (int k = 0; k < 4; k++)
    ck_assert_msg(fabs(found[k] - (k + 1)) <= 1e-12, "%d: %g", k, found[k]);
  dlsi_joints_destroy(work);
}

/* A rho < 0 is a pivot that is not positive, of the first unknown of its joint. */
TEST(joints_of_negative_rho) {
  pair s = pair_build("wall3-rest", 300);
  dlsi_joints *work;
  int tried = 0;
  ck_assert_int_eq(dlsi_joints_create(&work, &s.a.contact, s.S, 1, NULL), DLS_OK);
  for (int J = 0; J < work->count; J++) {
    const int *list = work->list + work->first[J], n = work->first[J + 1] - work->first[J];
    if (n < 2 || work->rank[J] == s.a.d * n) continue; /* nothing is factorised */
    for (int k = 0; k < n; k++)
      s.rho[list[k]] *= -1;
    ck_assert_int_eq(dlsi_joints_factor(work, s.rho), work->at[J] + 1);
    for (int k = 0; k < n; k++)
      s.rho[list[k]] *= -1;
    tried++;
  }
  ck_assert_int_gt(tried, 2);
  ck_assert_int_eq(dlsi_joints_factor(work, s.rho), 0);
  dlsi_joints_destroy(work);
  pair_free(&s);
}

TEST(joints_without_memory) {
  pair s = pair_build("wall3-rest", 200);
  dlsi_joints *work = NULL;
  MALLOCS_FAIL(dlsi_joints_create(&work, &s.a.contact, s.S, 1, NULL), !work, DLS_OK, 11);
  malloc_fails_at(1);
  ck_assert_int_eq(dlsi_joints_factor(work, s.rho), -1);
  malloc_fails_at(0);
  dlsi_joints_destroy(work);
  pair_free(&s);
}

int main(void) {
  if (!WITH_MUMPS) return 0;
  return run_tests("joints", NULL, NULL);
}
