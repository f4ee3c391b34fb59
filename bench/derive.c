/*
 * derive.c: the cost of derivatives compared with that of the answer. Writes derive.md.
 *
 * Sets: random problems, W = A A^T / m + shift I with shift 0.1 or 0.001, d = 1, 2, 3, 50 to 500
 * contacts; elastic blocks and cubes (solvers_scenes.c) with 50 to 500 contacts; W dense. CPU
 * seconds over those of dls_solve at 1e-8 by auto, each the least of 3 calls: of dls_derive_create,
 * of dls_derive_vjp for dL/dq and dL/dmu, and with dL/dW, which writes m^2 numbers, and of
 * dls_derive_jvp.
 */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "common.h"
#include "delassus/derive.h"
#include "delassus/fe.h"
#include "solvers_scenes.h"

enum { calls = 3, randoms = 36, most_costs = 500, sets = 3, kinds = 5 };

typedef struct derive_set {
  const char *name;
  int problems, solved, without; /* an answer without a derivative */
  int count;
  double cost[kinds][most_costs]; /* create, vjp, vjp with W, jvp, create + vjp */
} derive_set;

static void derive_scene(void *data, const scene *s) {
  derive_set *set = data;
  const dls_contact *p = &s->contact;
  const size_t m = (size_t)p->d * (size_t)p->nc;
  if (!p->W.a || p->nc < 50 || p->nc > 500 || set->count == most_costs) return;
  if (s->model && strcmp(s->set, "global") == 0) return; /* twice the same */
  double *r = calloc(5 * m + (size_t)p->nc + (size_t)p->W.ld * m, sizeof *r);
  if (!r) return;
  double *g = r + m, *q = g + m, *dr = q + m, *mu = dr + 2 * m, *W = mu + p->nc;
  bench_clock clock[kinds] = {{0}}, solve = {0};
  dls_status status = DLS_OK;
  for (size_t k = 0; k < m; k++)
    g[k] = cos((double)k);
  while (!status && bench_runs(&solve, calls, 0, 0))
    status = dls_solve(p, NULL, r, NULL, NULL, NULL);
  set->problems++;
  set->solved += !status;
  for (int k = 0; k < calls && !status; k++) {
    dls_derive *derive;
    for (int i = 0; i < 4 && !status; i++) {
      bench_start(&clock[i]);
      status =
          i == 0 ? dls_derive_create(&derive, p, r, -1, NULL)
          : i < 3
              ? dls_derive_vjp(derive, &(dls_derive_answer){.r = g},
                               &(dls_derive_data){.q = q, .mu = mu, .W = i == 1 ? NULL : W}, NULL)
              : dls_derive_jvp(derive, &(dls_derive_data){.q = g},
                               &(dls_derive_answer){.r = dr, .u = dr + m}, NULL);
      (void)bench_stop(&clock[i]);
    }
    dls_derive_destroy(derive);
  }
  clock[4].least = clock[0].least + clock[1].least;
  set->without += status == DLS_E_NO_DERIVATIVE;
  for (int k = 0; k < kinds && !status; k++)
    set->cost[k][set->count] = clock[k].least / solve.least;
  set->count += !status;
  free(r);
}

/* Writes the row of Jean's block with nx x nx/2 rectangles. */
static dls_status derive_block(FILE *page, int nx) {
  dls_fe_scene *jean;
  dls_fe_scene_settings is;
  dls_fe_scene_data of;
  dls_fe_scene_settings_init(&is);
  is.nx = nx;
  is.ny = nx / 2;
  dls_status status = dls_fe_scene_create_with(&jean, "jean-fig3", 0, &is, NULL);
  if (status) return status;
  dls_fe_scene_get(jean, &of);
  const size_t n = (size_t)of.model.n, m = 2 * (size_t)of.candidates;
  double *r = calloc(3 * m + 3 * n, sizeof *r), *x = r ? r + m : NULL;
  bench_clock clock[4] = {{0}};
  for (int k = 0; r && k < calls && !status; k++) {
    dls_reduction *reduction = NULL;
    dls_derive *derive = NULL;
    double *g = x + n, *f = g + n, *mu = f + n;
    for (size_t i = 0; i < n; i++)
      g[i] = cos((double)i);
    for (int i = 0; i < 4 && !status; i++) {
      bench_start(&clock[i]);
      if (i == 0) status = bench_reduce(&reduction, &of.model, NULL);
      if (i == 1) status = dls_reduction_load(reduction, of.f, of.g, NULL);
      if (i == 1 && !status)
        status = dls_reduction_solve(reduction, of.mu, NULL, r, NULL, x, NULL, NULL);
      if (i == 2) status = dls_derive_create_body(&derive, reduction, of.mu, r, x, -1, NULL);
      if (i == 3)
        status = dls_derive_vjp(derive, &(dls_derive_answer){.x = g},
                                &(dls_derive_data){.f = f, .mu = mu}, NULL);
      (void)bench_stop(&clock[i]);
    }
    dls_derive_destroy(derive);
    dls_reduction_destroy(reduction);
  }
  if (r && !status)
    bench_print(page, "| %d x %d | %d | %.2f | %.2f | %.3f |\n", nx, nx / 2, of.model.n,
                clock[1].least / clock[0].least, clock[2].least / clock[0].least,
                clock[3].least / clock[0].least);
  free(r);
  dls_fe_scene_destroy(jean);
  return status;
}

static void derive_row(FILE *page, derive_set *s) {
  bench_print(page, "| %s | %d of %d | %d |", s->name, s->solved, s->problems, s->without);
  for (int k = 0; k < kinds; k++)
    bench_print(page, " %.2f |", bench_median((size_t)s->count, s->cost[k]));
  bench_print(page, "\n");
}

int main(int argc, char **argv) {
  static derive_set set[sets + 1] = {
      {.name = "random"}, {.name = "elastic blocks"}, {.name = "elastic cubes"}, {.name = "all"}};
  FILE *page = bench_program(argc, argv, "[--out DIR]", "derive", "Cost of derivatives");
  for (int k = 0; k < randoms; k++)
    if (scenes_random(k, 50 + 450 * (k / 3) / 11, 0, derive_scene, &set[0])) return 1;
  if (scenes_blocks(0, derive_scene, &set[1]) || scenes_cubes(0, derive_scene, &set[2])) return 1;
  bench_print(
      page,
      "\n50 to 500 contacts, W dense: CPU over that of `dls_solve` at 1e-8 by auto, medians. One "
      "create serves any number of\ngradients (vjp: dL/dq, dL/dmu) and directions (jvp: dr, du) at "
      "an answer.\n\n| set | solved | no derivative | create | vjp | vjp with dL/dW | jvp | create "
      "+ vjp |\n|---|---|---|---|---|---|---|---|\n");
  for (int k = 0; k < sets; k++) {
    derive_set *all = &set[sets];
    all->problems += set[k].problems;
    all->solved += set[k].solved;
    all->without += set[k].without;
    for (int i = 0; i < set[k].count && all->count < most_costs; i++, all->count++)
      for (int kind = 0; kind < kinds; kind++)
        all->cost[kind][all->count] = set[k].cost[kind][i];
    derive_row(page, &set[k]); /* sorts */
  }
  derive_row(page, &set[sets]);
  bench_print(
      page, "\nOn K: the block of Jean (1988), Fig. 3, CPU over that of `dls_reduction_create`.\n\n"
            "| mesh | unknowns | load and solve | create | vjp (dL/df, dL/dmu) |\n"
            "|---|---|---|---|---|\n");
  for (int nx = 16; nx <= 128; nx *= 2)
    if (derive_block(page, nx)) return 1;
  return fclose(page) != 0;
}
