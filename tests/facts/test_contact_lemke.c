/* test_contact_lemke.c: the search by Lemke's method, a stage of auto (CL6). */
#include <check.h>

#include "cases.h"
#include "facts/facts.h"
#include "front_cases.h"
#include "run.h"

/* Two wedges that jam, of which each presses the other: no solution, and no proof of it. */
static void jam(model *a) {
  set_model(a, 3, 2);
  for (int c = 0; c < 2; c++) {
    const int n = 3 * c, t = n + 1, s = n + 2, ld = a->p.W.ld;
    a->W[n + ld * n] = a->W[n + ld * t] = a->W[t + ld * n] = a->W[t + ld * t] = 1;
    a->W[s + ld * s] = 1;
    a->q[n] = -2;
    a->mu[c] = 2 + c;
  }
  a->W[3] = a->W[3 * a->p.W.ld] = -0.25;
}

/* Pivots of the search with up to `facets` facets. */
static int pivots_of(const dls_contact *p, int facets) {
  const dlsi_options options = {.limits = {.tol = 1e-8}, .facets = facets};
  void *work;
  double r[6];
  dls_info info;
  ck_assert_int_eq(dlsi_lemke_method.create(&work, p->d, p->nc, &options, NULL), DLS_OK);
  dlsi_contact_lemke_search(work, 1);
  ck_assert_int_ge(dlsi_lemke_method.solve(work, p, r, NULL, &info, NULL), 1);
  dlsi_lemke_method.destroy(work);
  return info.iterations;
}

/* Up to 4 facets it takes the cone with 4 alone, up to 6 each of two, up to 8 each of three. */
START_TEST(the_search_takes_every_number_of_facets) {
  static model a;
  jam(&a);
  const int four = pivots_of(&a.p, 4), six = pivots_of(&a.p, 6), eight = pivots_of(&a.p, 8);
  ck_assert_int_gt(four, 100);
  ck_assert_int_gt(six, four);
  ck_assert_int_gt(eight, six);
}
END_TEST

/* Returns the status of Lemke's method on p, from r = 0; searches: (CL6). */
static dls_status run_on(const dls_contact *p, int searches) {
  const dlsi_options options = {.limits = {.tol = 1e-8}};
  void *work;
  double r[3 * PLANTED];
  ck_assert_int_eq(dlsi_lemke_method.create(&work, p->d, p->nc, &options, NULL), DLS_OK);
  dlsi_contact_lemke_search(work, searches);
  const dls_status status = dlsi_lemke_method.solve(work, p, r, NULL, NULL, NULL);
  ck_assert_int_ge(status, 0);
  dlsi_lemke_method.destroy(work);
  return status;
}

/* Of planted problems of low rank and large friction, 20 candidates in 2D and 12 in 3D, one run
 * leaves some, and the search solves them all. */
START_TEST(the_search_goes_where_one_path_does_not) {
  static planted_problem a;
  const int d = _i, nc = d == 2 ? 20 : 12, rank = d == 2 ? 10 : 18;
  int lost = 0;
  for (unsigned seed = 1; seed <= 100; seed++) {
    const dls_contact p = planted(&a, d, nc, rank, 8, seed);
    if (run_on(&p, 0) == DLS_OK) continue;
    lost++;
    ck_assert_int_eq(run_on(&p, 1), DLS_OK);
  }
  ck_assert_int_ge(lost, 5);
}
END_TEST

int main(void) {
  return RUN("contact_lemke", NULL, NULL, ONCE(the_search_takes_every_number_of_facets),
             EACH(the_search_goes_where_one_path_does_not, 2, 4));
}
