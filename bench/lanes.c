/*
 * lanes.c: compares a sweep of Gauss-Seidel over groups of eight contacts, in registers of 2, 4 and
 * 8 lanes, with the sweep over one after the other, from r = 0.
 *
 *   lanes [--sizes N,N,..] [--seed S] [--sweeps COUNT] [--rounds R] [--out DIR]
 *
 * CPU nanoseconds per contact and sweep, the least of the rounds, which go over all columns in
 * turn: on a busy machine compare columns of a row, not rows.
 */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "common.h"
#include "delassus.h"
#include "rigid.h"
#include "vi/sweep/groups.h"

enum { most_sizes = 8, columns = 5 }; /* one by one, 2, 4, 8 lanes, filling the groups */

typedef struct plan {
  int sizes[most_sizes], size_count, sweeps, rounds;
  unsigned long seed;
  FILE *page;
} plan;

/* Times the sweeps one by one: a relaxation next to 1 keeps groups away. Returns 1 if they fail. */
static int one_by_one(const plan *p, const dls_contact *problem, double *r, bench_clock *c) {
  dls_nlgs_settings s;
  dls_nlgs *work = NULL;
  dls_nlgs_settings_init(&s);
  s.limits.max_iterations = p->sweeps;
  s.limits.tol = 0;
  s.relaxation = nextafter(1, 0);
  if (dls_nlgs_create(&work, problem->d, problem->nc, &s, NULL)) return 1;
  bench_start(c);
  const dls_status status = dls_nlgs_solve(work, problem, r, NULL, NULL, NULL);
  (void)bench_stop(c);
  dls_nlgs_destroy(work);
  return status < 0;
}

static void lanes_compare(const plan *p, FILE *page, const char *kind, const char *storage,
                          const dls_contact *problem, int bodies) {
  bench_clock clock[columns] = {{0}}, *set = &clock[columns - 1];
  double full = 0;
  const size_t m = (size_t)problem->d * (size_t)problem->nc, n = 6 * (size_t)bodies;
  double *r = calloc(m + n, sizeof *r);
  for (int round = 0; r && round < p->rounds; round++) {
    if (one_by_one(p, problem, r, clock)) break;
    for (int k = 1; k <= 3; k++) {
      dlsi_groups groups = {.count = 0, .width = 1 << k};
      memset(r, 0, (m + n) * sizeof *r);
      bench_start(set);
      if (dlsi_groups_set(&groups, problem, (dlsi_set){.count = problem->nc}, NULL, NULL)) break;
      (void)bench_stop(set);
      bench_start(&clock[k]);
      for (int sweep = 0; sweep < p->sweeps; sweep++)
        (void)dlsi_groups_sweep(&groups, NULL, r, r + m);
      (void)bench_stop(&clock[k]);
      full = problem->nc / 8. / groups.count;
      dlsi_groups_free(&groups);
    }
  }
  free(r);
  const double unit = 1e9 / problem->nc / p->sweeps;
  const double one = clock[0].least, eight = clock[3].least;
  bench_print(page, "| %s | %s | %d | %.1f | %.2f | %.2f | %.2f | %.2f | %.1f |\n", kind, storage,
              problem->nc, unit * one, one / clock[1].least, one / clock[2].least, one / eight,
              full, set->least / eight * p->sweeps);
}

int main(int argc, char **argv) {
  static const char *const kinds[] = {"packing-flow", "packing-rest", "balls-rest", "discs-rest"};
  plan p = {.sizes = {700, 4000, 20000},
            .seed = (unsigned long)bench_number(argc, argv, "--seed", 2),
            .sweeps = (int)bench_number(argc, argv, "--sweeps", 100),
            .rounds = (int)bench_number(argc, argv, "--rounds", 5)};
  p.size_count = bench_list(argc, argv, "--sizes", p.sizes, 3, most_sizes);
  if (p.sweeps < 1 || p.rounds < 1) return 2;
  p.page = bench_program(argc, argv,
                         "[--sizes N,N..] [--seed SEED] [--sweeps N] [--rounds N] [--out DIR]",
                         "lanes", "Sweeps in lanes");
  bench_print(p.page,
              "One by one: CPU nanoseconds of a contact in a plain sweep, from r = 0. Over 2, 4, 8 "
              "lanes: that time over the time in groups. Full: the part of the lanes that are "
              "full. Set-up: in sweeps of 8 lanes.\n\n| kind | W | contacts | one by one | over 2 "
              "lanes | over 4 | over 8 | full | set-up |\n|---|---|---|---|---|---|---|---|---|\n");
  for (size_t kind = 0; kind < sizeof kinds / sizeof kinds[0]; kind++)
    for (int k = 0; k < p.size_count; k++) {
      rigid a;
      if (rigid_create(&a, kinds[kind], p.sizes[k], .5, p.seed)) return 1;
      FILE *const page = k == p.size_count - 1 ? p.page : NULL; /* the screen shows all */
      lanes_compare(&p, page, kinds[kind], "blocks", &a.contact, a.bodies);
      lanes_compare(&p, page, kinds[kind], "bodies", &a.factored, a.bodies);
      rigid_free(&a);
    }
  return fclose(p.page) ? 1 : 0;
}
