/*
 * hard_fold.c: the fold in 3D, the least friction at which some loads have two answers, between the
 * proof that there is one below and a pair of certified answers: dls_contact_fold.
 */
#include "common.h"
#include "delassus/trust.h"
#include "hard.h"

int hard_fold_table(FILE *page) {
  bench_print(page,
              "| contacts | condition | seed | one answer below | two answers at | quotient | "
              "matrices |\n|---|---|---|---|---|---|---|\n");
  for (int nc = 2; nc <= 6; nc += 2)
    for (double condition = 10; condition < 2e4; condition *= condition)
      for (uint64_t seed = 2; seed <= 4; seed += 2) {
        regret_problem h;
        dls_fold f = {0};
        if (hard_create(&h, nc, condition, 0, FLAW_NONE, seed)) return 1;
        if (dls_contact_fold(&h.contact, &f, NULL, NULL, NULL, NULL, NULL)) return 1;
        bench_print(page, "| %d | %.0e | %d | %.3g | %.3g | %.2f | %d |\n", nc, condition,
                    (int)seed, f.unique, f.friction, f.friction / f.unique, f.matrices);
        regret_free(&h);
      }
  return 0;
}
