/*
 * prove.c: counts the certified answers that dls_contact_prove proves; its cost. Writes proof.md.
 *
 * Sets: random problems, W = A A^T / m + shift I with shift 0.1 or 0.001, d = 1, 2, 3, 1 to 300
 * rows, even seeds; FCLIB files of one directory; those of another one with Jean's block, saved by
 * make bench-prove; elastic blocks and cubes (solvers_scenes.c). An answer is regular
 * where dls_contact_sensitivity, for up to 600 unknowns, sees full rank and no contact on a border.
 * Cost: CPU seconds of dls_contact_prove over those of dls_solve at 1e-8 by auto, each the least of
 * 3 calls.
 */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "common.h"
#include "delassus/trust.h"
#include "solvers_scenes.h"

enum { calls = 3, randoms = 300, most_costs = 2000, sets = 6, most_rows = 600 };

typedef struct prove_set {
  const char *name;
  int problems, solved, regular, proved, positions, border; /* of the solved ones */
  int missed;                                               /* regular, not proved */
  double radius;                                            /* the largest */
  int count, large; /* of the costs; with 50 to 500 contacts */
  double cost[most_costs], cost_large[most_costs];
} prove_set;

/* Returns the least CPU seconds of solves, or of proofs where r is solved, in *status. */
static double measure_call(const dls_contact *p, double *r, dls_proof *proof, dls_status *status) {
  bench_clock c = {0};
  dls_solver_settings s;
  dls_solver_settings_init(&s);
  s.limits.cpu_seconds = 20;
  if (p->Wb.x) s.limits.blocks = p->Wb.p[p->nc];
  while (bench_runs(&c, 1, calls, 0.1))
    *status =
        proof ? dls_contact_prove(p, r, proof, NULL, NULL) : dls_solve(p, &s, r, NULL, NULL, NULL);
  return c.least;
}

static void prove_scene(void *data, const scene *s) {
  prove_set *set = data;
  const dls_contact *p = &s->contact;
  if (!p->nc || (s->model && strcmp(s->set, "global") == 0)) return; /* twice the same */
  dls_sensitivity of;
  dls_proof proof;
  dls_status status = DLS_OK;
  double *r = calloc((size_t)p->d * (size_t)p->nc, sizeof *r);
  if (!r) return;
  set->problems++;
  const double solve = measure_call(p, r, NULL, &status);
  if (status == DLS_OK) {
    set->solved++;
    const double cost = measure_call(p, r, &proof, &status) / solve;
    const int regular = proof.rows <= most_rows && !dls_contact_sensitivity(p, r, &of, NULL) &&
                        of.border == 0 && of.rank == of.rows;
    set->regular += regular;
    set->proved += proof.kind == DLS_PROVED;
    set->positions += proof.kind == DLS_PROVED_POSITIONS;
    set->border += !proof.kind && proof.border;
    set->missed += regular && proof.kind != DLS_PROVED;
    if (regular && proof.kind != DLS_PROVED)
      fprintf(stderr, "%s %s: not proved, border %d, rows %d\n", s->set, s->name, proof.border,
              proof.rows);
    if (proof.kind == DLS_PROVED) set->radius = fmax(set->radius, proof.radius);
    if (set->count < most_costs) set->cost[set->count++] = cost;
    if (p->W.a && p->nc >= 50 && p->nc <= 500 && set->large < most_costs)
      set->cost_large[set->large++] = cost;
  }
  free(r);
}

int main(int argc, char **argv) {
  static prove_set set[sets] = {{.name = "random"},         {.name = "random, 50 to 500 contacts"},
                                {.name = "FCLIB"},          {.name = "Jean's block"},
                                {.name = "elastic blocks"}, {.name = "elastic cubes"}};
  static const char usage[] = "[--out DIR] [FCLIB [FILES...]]";
  const char *fclib = bench_other(argc, argv, usage, 0), *more = bench_other(argc, argv, usage, 1);
  FILE *page = bench_program(argc, argv, usage, "proof", "Proofs of answers");
  for (int k = 0; k < randoms; k++)
    if (scenes_random(k, 0, 300, prove_scene, &set[0])) return 1;
  for (int k = 0; k < 36; k++)
    if (scenes_random(k, 50 + 450 * (k / 3) / 11, 0, prove_scene, &set[1])) return 1;
  if (scenes_files(fclib ? fclib : "data/fclib", prove_scene, &set[2]) ||
      (more && scenes_files(more, prove_scene, &set[3])) ||
      scenes_blocks(0, prove_scene, &set[4]) || scenes_cubes(0, prove_scene, &set[5]))
    return 1;
  bench_print(page,
              "\nAnswers of auto at 1e-8, and the result of `dls_contact_prove`. Regular: full "
              "rank and no contact on a border\nof two states, by `dls_contact_sensitivity`. Cost: "
              "CPU of the proof over that of the solve, median;\nthe last column that of 50 to 500 "
              "contacts, W dense.\n\n| set | solved | regular | regular, not proved | proved | "
              "positions proved | on a border | largest radius | cost | cost, 50 to 500 |\n"
              "|---|---|---|---|---|---|---|---|---|---|\n");
  static double all[most_costs];
  size_t count = 0;
  for (int k = 0; k < sets; k++)
    for (int i = 0; i < set[k].large && count < most_costs; i++)
      all[count++] = set[k].cost_large[i];
  for (int k = 0; k < sets; k++) {
    prove_set *s = &set[k];
    bench_print(page, "| %s | %d of %d | %d | %d | %d | %d | %d | %.0e | %.2f | ", s->name,
                s->solved, s->problems, s->regular, s->missed, s->proved, s->positions, s->border,
                s->radius, bench_median((size_t)s->count, s->cost));
    if (s->large)
      bench_print(page, "%.2f (%d) |\n", bench_median((size_t)s->large, s->cost_large), s->large);
    else
      bench_print(page, " |\n");
  }
  bench_print(page, "\nMedian cost of all %zu problems of 50 to 500 contacts, W dense: %.2f.\n",
              count, bench_median(count, all));
  bench_print(page,
              "\nProofs against exact answers, of problems of integers and of planted solutions: "
              "`CK_DEFAULT_TIMEOUT=0\nbuild/tests/facts/test_prove 100000`.\n");
  return fclose(page) != 0;
}
