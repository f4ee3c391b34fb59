/*
 * prove.c: how many certified answers dls_contact_prove proves, and at what cost. Writes proof.md.
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

void dsyrk_(const char *uplo, const char *trans, const int *n, const int *k, const double *alpha,
            const double *a, const int *lda, const double *beta, double *c, const int *ldc, size_t,
            size_t);

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
  double least = INFINITY;
  for (int k = 0; k < calls; k++) {
    dls_solver_settings s;
    dls_solver_settings_init(&s);
    s.limits.cpu_seconds = 20;
    if (p->Wb.x) s.limits.blocks = p->Wb.p[p->nc];
    const double begun = bench_seconds();
    *status =
        proof ? dls_contact_prove(p, r, proof, NULL, NULL) : dls_solve(p, &s, r, NULL, NULL, NULL);
    least = fmin(least, bench_seconds() - begun);
    if (least > 0.1) break;
  }
  return least;
}

static void prove_scene(void *data, const scene *s) {
  prove_set *set = data;
  const dls_contact *p = &s->contact;
  if (!p->nc || (s->model && strcmp(s->set, "global") == 0)) return; /* twice the same */
  dls_sensitivity of;
  dls_proof proof;
  dls_status status;
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

/* Judges random problem k; nc = 0: drawn, 1 to 300 rows. */
static void judge_random(int k, int nc, prove_set *set) {
  uint64_t seed = 2 * (uint64_t)k + 2;
  scene s = {.set = "random"};
  const int d = 1 + k % 3;
  if (!nc) nc = 1 + (int)((bench_draw(&seed) + 1) / 2 * (300 / d));
  const size_t m = (size_t)d * (size_t)nc;
  double *A = malloc(m * m * sizeof *A), *W = calloc(m * m, sizeof *W);
  double *q = malloc(m * sizeof *q), *mu = malloc((size_t)nc * sizeof *mu);
  (void)snprintf(s.name, sizeof s.name, "%d", k);
  for (size_t i = 0; A && i < m * m; i++)
    A[i] = bench_draw(&seed);
  const int n = (int)m;
  const double over = 1 / (double)m, zero = 0;
  if (A && W) dsyrk_("L", "N", &n, &n, &over, A, &n, &zero, W, &n, 1, 1);
  for (size_t j = 0; A && W && j < m; j++) {
    W[j * (m + 1)] += k / 3 % 2 ? 1e-3 : 0.1;
    for (size_t i = j + 1; i < m; i++)
      W[j + i * m] = W[i + j * m];
  }
  for (size_t i = 0; q && i < m; i++)
    q[i] = bench_draw(&seed) - (i % (size_t)d == 0 ? 0.3 : 0);
  for (int c = 0; mu && c < nc; c++)
    mu[c] = d == 1 ? 0 : 0.45 + 0.35 * bench_draw(&seed);
  s.contact = (dls_contact){.d = d, .nc = nc, .W = {n, n, n, W}, .q = q, .mu = mu};
  if (A && W && q && mu) prove_scene(set, &s);
  free(A);
  free(W);
  free(q);
  free(mu);
}

int main(int argc, char **argv) {
  static prove_set set[sets] = {{.name = "random"},         {.name = "random, 50 to 500 contacts"},
                                {.name = "FCLIB"},          {.name = "Jean's block"},
                                {.name = "elastic blocks"}, {.name = "elastic cubes"}};
  const char *out = argc >= 3 && strcmp(argv[1], "--out") == 0 ? argv[2] : NULL;
  if (!out) return 1;
  for (int k = 0; k < randoms; k++)
    judge_random(k, 0, &set[0]);
  for (int k = 0; k < 36; k++)
    judge_random(k, 50 + 450 * (k / 3) / 11, &set[1]);
  if (scenes_files(argc > 3 ? argv[3] : "data/fclib", prove_scene, &set[2]) ||
      (argc > 4 && scenes_files(argv[4], prove_scene, &set[3])) ||
      scenes_blocks(0, prove_scene, &set[4]) || scenes_cubes(0, prove_scene, &set[5]))
    return 1;
  FILE *page = bench_page(out, "proof", "Proofs of answers", argc, argv);
  if (!page) return 1;
  bench_print(page,
              "\nAnswers of auto at 1e-8, and what `dls_contact_prove` says of them. Regular: full "
              "rank and no contact on a border\nof two states, as `dls_contact_sensitivity` sees "
              "them. Cost: CPU of the proof over that of the solve, median;\nthe last column that "
              "of 50 to 500 contacts, W dense.\n\n"
              "| set | solved | regular | regular, not proved | proved | positions proved | on a "
              "border | largest radius | cost | cost, 50 to 500 |\n"
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
              "\nProofs beside exact answers, of problems of integers and of planted solutions: "
              "`CK_DEFAULT_TIMEOUT=0\nbuild/tests/facts/test_prove 100000`.\n");
  return fclose(page) != 0;
}
