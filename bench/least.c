/*
 * least.c: cost and use of the least reactions (dls_solver_settings.forces). Writes least.md.
 *
 * Sets: tables of 4 to 32 legs and arches of 6 to 60 voussoirs at rest, walls (solvers_scenes.c),
 * FCLIB files of a directory; of these, problems of up to 600 rows whose reactions are free.
 * Cost: CPU seconds of dls_solve by auto with DLS_FORCES_LEAST over those without, less 1, each the
 * least of 5 calls. Orders: |r - r'| / |r| of the contacts as they are and reversed.
 */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "common.h"
#include "delassus/trust.h"
#include "rigid.h"
#include "solvers_scenes.h"

enum { calls = 5, most_costs = 500, sets = 4, most_rows = 600 };
static const double pi = 3.141592653589793;

typedef struct least_set {
  const char *name;
  int problems, least, count; /* not determined; of these solved with the least r; costs */
  double any, by_least;       /* largest distance of two orders */
  double cost[most_costs];
} least_set;

/* Returns the least CPU seconds of solves; r, *info: of the last. */
static double measure_solve(const dls_contact *p, dls_forces forces, double *r, dls_info *info) {
  bench_clock c = {0};
  dls_solver_settings s;
  dls_solver_settings_init(&s);
  s.forces = forces;
  s.limits.cpu_seconds = 20;
  while (bench_runs(&c, calls, 0, 0))
    if (dls_solve(p, &s, r, NULL, info, NULL)) return NAN;
  return c.least;
}

/* Reverses the contacts of x, m. */
static void reverse(int d, int nc, const double *x, double *y) {
  for (int c = 0; c < nc; c++)
    memcpy(y + d * c, x + d * (nc - 1 - c), (size_t)d * sizeof *x);
}

static void least_scene(void *data, const scene *s) {
  least_set *set = data;
  const dls_contact *p = &s->contact;
  const int d = p->d, nc = p->nc, m = d * nc;
  if (!nc || m > most_rows || strcmp(s->set, "global") == 0) return; /* twice the same */
  const size_t M = (size_t)m;
  double *r = malloc((4 * M + 2 * M * M + M + (size_t)nc) * sizeof *r);
  if (!r) return;
  double *x = r + M, *y = x + M, *z = y + M, *W = z + M, *V = W + M * M, *q = V + M * M;
  double *mu = q + M;
  dls_info info;
  int freedom = 0;
  dls_contact turned = {.d = d, .nc = nc, .W = {m, m, m, V}, .q = q, .mu = mu};
  const double any = measure_solve(p, DLS_FORCES_ANY, r, &info);
  if (any > 0 && !dls_contact_freedom(p, r, &freedom, NULL) && freedom > 0) {
    set->problems++;
    const double least = measure_solve(p, DLS_FORCES_LEAST, x, &info);
    set->least += info.forces == DLS_FORCES_LEAST;
    if (set->count < most_costs) set->cost[set->count++] = least / any - 1;
    memset(W, 0, M * M * sizeof *W);
    for (size_t j = 0; p->W.a && j < M; j++)
      memcpy(W + j * M, p->W.a + j * (size_t)p->W.ld, M * sizeof *W);
    if (p->Wb.x && dls_blocks_to_dense(&p->Wb, W, m, NULL)) exit(1);
    for (int j = 0; j < m; j++)
      reverse(d, nc, W + (size_t)j * M, V + (size_t)(d * (nc - 1 - j / d) + j % d) * M);
    reverse(d, nc, p->q, q);
    reverse(1, nc, p->mu, mu);
    if (measure_solve(&turned, DLS_FORCES_ANY, y, &info) > 0) {
      reverse(d, nc, y, z);
      set->any = fmax(set->any, bench_distance(M, z, r));
    }
    if (measure_solve(&turned, DLS_FORCES_LEAST, y, &info) > 0) {
      reverse(d, nc, y, z);
      set->by_least = fmax(set->by_least, bench_distance(M, z, x));
    }
  }
  free(r);
}

/* ---- tables and arches ----------------------------------------------------------------------- */

/* Judges the bodies, W dense. */
static void judge_rigid(rigid *a, least_set *set) {
  const int m = a->contact.d * a->contact.nc;
  double *W = calloc((size_t)m * (size_t)m, sizeof *W);
  if (!W || dls_blocks_to_dense(&a->contact.Wb, W, m, NULL)) exit(1);
  scene s = {.set = "rigid", .contact = a->contact};
  s.contact.W = (dls_dense){m, m, m, W};
  s.contact.Wb = (dls_blocks){0};
  least_scene(set, &s);
  free(W);
  rigid_free(a);
}

static void judge_table(int legs, least_set *set) {
  rigid a;
  heap h = {.d = 3};
  (void)heap_add_body(&h, (solid){.v = {0, 0, -1}, .mass = 1, .inertia = {1. / 9, 1. / 9, 1. / 9}});
  for (int c = 0; c < legs; c++) {
    const double at = 2 * pi * c / legs;
    heap_touch(&h, (place){.b = -1, .x = {cos(at), sin(at), -1}, .normal = {0, 0, 1}});
  }
  if (rigid_close(&a, &h, 0.5)) exit(1);
  judge_rigid(&a, set);
}

static void judge_arch(int bodies, least_set *set) {
  rigid a;
  if (rigid_create(&a, "arch", 2 * (bodies + 1), 0.7, 1)) exit(1);
  judge_rigid(&a, set);
}

int main(int argc, char **argv) {
  static least_set set[sets] = {
      {.name = "tables"}, {.name = "arches"}, {.name = "walls"}, {.name = "FCLIB"}};
  static const char usage[] = "[--out DIR] [FCLIB...]";
  const char *fclib = bench_other(argc, argv, usage, 0);
  FILE *page = bench_program(argc, argv, usage, "least", "The least reactions");
  for (int legs = 4; legs <= 32; legs++)
    judge_table(legs, &set[0]);
  for (int bodies = 6; bodies <= 60; bodies += 6)
    judge_arch(bodies, &set[1]);
  if (scenes_walls(0, least_scene, &set[2]) ||
      scenes_files(fclib ? fclib : "data/fclib", least_scene, &set[3]))
    return 1;
  bench_print(page,
              "\nProblems of up to 600 rows whose reactions are not determined, solved by auto at "
              "1e-8 with `forces` any and least.\nCost: CPU of the least over that of the solve "
              "alone. Orders: the largest relative distance of the reactions of the\ncontacts as "
              "they are and reversed.\n\n| set | not determined | the least found | cost, median | "
              "largest | orders, any | orders, least |\n|---|---|---|---|---|---|---|\n");
  for (int k = 0; k < sets; k++) {
    least_set *s = &set[k];
    if (!s->problems) {
      bench_print(page, "| %s | 0 | | | | | |\n", s->name);
      continue;
    }
    const double median = bench_median((size_t)s->count, s->cost);
    bench_print(page, "| %s | %d | %d | %.2f | %.2f | %.0e | %.0e |\n", s->name, s->problems,
                s->least, median, s->cost[s->count - 1], s->any, s->by_least);
  }
  return fclose(page) != 0;
}
