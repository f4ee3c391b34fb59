/* test_fill.c: the fill that is foreseen from the graph of the bodies (vi/split/fill.c). */
#include "rigid.h"
#include "run.h"
#include "vi/vi_internal.h"

static double foreseen(const char *kind, int candidates) {
  rigid a;
  ck_assert_int_eq(rigid_create(&a, kind, candidates, 0.5, 2), 0);
  const double flops = dlsi_foresee_fill(&a.factored);
  ck_assert(dlsi_foresee_fill(&a.contact) == 0); /* no bodies */
  rigid_free(&a);
  return flops;
}

/* The cut of a chain is one joint of any length: 2 contacts of 2 unknowns, 3 motions. A pile of
 * balls n times as wide has n^2 contacts across: n^6 operations. */
TEST(graphs) {
  ck_assert_double_le(foreseen("chain", 2000), 4 * 4 * 4 * 4);
  ck_assert(foreseen("chain", 2000) == foreseen("chain", 200));
  const double ratio = foreseen("balls-rest", 1600) / foreseen("balls-rest", 200);
  ck_assert_double_ge(ratio, 20);
  ck_assert_double_le(ratio, 200);
}

/* The order of the contacts and of the bodies of a pair does not matter. */
TEST(order) {
  rigid a;
  ck_assert_int_eq(rigid_create(&a, "wall-pushed", 500, 0.5, 2), 0);
  const size_t nc = (size_t)a.contact.nc;
  dls_contact turned = a.factored;
  int *body = malloc(2 * nc * sizeof *body);
  ck_assert_ptr_nonnull(body);
  for (size_t k = 0; k < 2 * nc; k++)
    body[k] = a.factored.bodies.body[2 * nc - 1 - k];
  turned.bodies.body = body;
  ck_assert(dlsi_foresee_fill(&turned) == dlsi_foresee_fill(&a.factored));
  free(body);
  rigid_free(&a);
}

TEST(no_memory) {
  rigid a;
  ck_assert_int_eq(rigid_create(&a, "balls-rest", 500, 0.5, 2), 0);
  malloc_fails_at(1);
  const double flops = dlsi_foresee_fill(&a.factored);
  malloc_fails_at(0);
  ck_assert(flops == 0);
  rigid_free(&a);
}
