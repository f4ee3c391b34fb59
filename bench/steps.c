/*
 * steps.c: many problems one after the other: a batch of small ones, and the steps of a load path.
 *
 *   steps [--out DIR]
 *       steps.md: CPU of dls_solve_batch compared with a loop of dls_solve on boxes with four
 *       contacts; of a load path of 50 steps, smooth or with jumps, each from the answer of the
 *       last, compared with the same steps from zero; and of a punch with and without the contacts
 *       that cannot touch
 *
 * Each time is the least of several runs that take turns; seeds are even.
 */
#include <math.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "common.h"
#include "delassus/solve.h"
#include "half_space.h"
#include "regret_kinds.h"

/* ---- random numbers -------------------------------------------------------------------------- */

static uint64_t steps_state;

static double steps_draw(void) {
  return bench_draw(&steps_state);
}

/* ---- boxes ----------------------------------------------------------------------------------- */

enum { corners = 4, box_rows = 3 * corners, boxes = 2000, runs = 7 };

typedef struct box {
  double W[box_rows * box_rows], q[box_rows], mu[corners];
} box;

/* Makes a box of random sides on the plane, at rest, sliding or tumbling, after a step of
 * gravity. */
static void box_make(box *b, int kind) {
  const double a[3] = {1 + .5 * steps_draw(), 1 + .5 * steps_draw(), 1 + .5 * steps_draw()};
  solid one = {.mass = 1, .v = {0, 0, -.1}};
  rigid made;
  heap h = {.d = 3};
  for (int i = 0; i < 3; i++) {
    const double s = a[(i + 1) % 3], t = a[(i + 2) % 3];
    one.inertia[i] = (s * s + t * t) / 3;
    one.v[i] += kind == 1 && i < 2 ? .3 * steps_draw() : kind == 2 ? .1 * steps_draw() : 0;
    one.spin[i] = kind == 2 ? .1 * steps_draw() : 0;
  }
  (void)heap_add_body(&h, one);
  for (int c = 0; c < corners; c++) {
    const double x = c % 2 ? a[0] : -a[0], y = c / 2 ? a[1] : -a[1];
    heap_touch(&h, (place){.b = -1, .x = {x, y, -a[2]}, .normal = {0, 0, 1}});
    b->mu[c] = .5;
  }
  if (rigid_close(&made, &h, .5) || dls_blocks_to_dense(&made.contact.Wb, b->W, box_rows, NULL))
    exit(1);
  memcpy(b->q, made.contact.q, sizeof b->q);
  rigid_free(&made);
}

static dls_contact box_contact(const box *b) {
  return (dls_contact){
      .d = 3, .nc = corners, .W = {box_rows, box_rows, box_rows, b->W}, .q = b->q, .mu = b->mu};
}

/* Times all boxes by a loop of dls_solve (batch = 0) or one dls_solve_batch; returns how many were
 * solved. */
static int box_time(const dls_contact *p, double (*r)[box_rows], int batch, bench_clock *c) {
  double *at[boxes];
  dls_info *info = malloc(boxes * sizeof *info);
  if (!info) exit(1);
  for (int k = 0; k < boxes; k++)
    at[k] = r[k];
  int solved = 0;
  bench_start(c);
  dls_status status = DLS_OK;
  for (int k = 0; !batch && k < boxes && status >= 0; k++)
    status = dls_solve(&p[k], NULL, r[k], NULL, &info[k], NULL);
  if (batch) status = dls_solve_batch(boxes, p, NULL, at, NULL, info, NULL);
  (void)bench_stop(c);
  for (int k = 0; k < boxes && status >= 0; k++)
    solved += info[k].status == DLS_OK;
  free(info);
  return solved;
}

static void print_boxes(FILE *page) {
  static const char *const name[] = {"at rest", "sliding", "tumbling"};
  static box b[boxes];
  static double r[boxes][box_rows];
  static dls_contact p[boxes];
  bench_print(
      page,
      "## %d boxes with four contacts, d = 3, W dense, 1e-8\n\n| boxes | loop of dls_solve, us "
      "each | dls_solve_batch | loop over batch | solved |\n|---|---|---|---|---|\n",
      boxes);
  for (int kind = 0; kind < 3; kind++) {
    bench_clock clock[2] = {{0}};
    int solved[2] = {0};
    steps_state = 2 + 2 * (uint64_t)kind;
    for (int k = 0; k < boxes; k++) {
      box_make(&b[k], kind);
      p[k] = box_contact(&b[k]);
    }
    for (int run = 0; run < runs; run++)
      for (int batch = 0; batch < 2; batch++)
        solved[batch] = box_time(p, r, batch, &clock[batch]);
    bench_print(page, "| %s | %.2f | %.2f | %.2f | %d, %d |\n", name[kind],
                1e6 * clock[0].least / boxes, 1e6 * clock[1].least / boxes,
                clock[0].least / clock[1].least, solved[0], solved[1]);
  }
}

/* ---- a load path ----------------------------------------------------------------------------- */

enum { load_steps = 50 };

typedef struct path {
  int d, side, nc; /* side: candidates along x */
  double press, crown, tilt, shear, turn;
  double jump; /* of the load, as a share of the way */
  double *at;  /* x, y of each */
  regret_problem of;
} path;

/* Seed 0 is the path of the first table; others draw load and friction within two fifths of it. */
static double path_factor(int seed) {
  return seed ? 1 + .4 * steps_draw() : 1;
}

static void path_make(path *a, int d, int side, int seed, double jump) {
  const int nc = d == 2 ? side : side * side, m = d * nc;
  *a = (path){.d = d, .side = side, .nc = nc, .jump = jump};
  steps_state = (uint64_t)seed;
  (void)steps_draw();
  a->press = .8 * path_factor(seed);
  a->crown = .3 * path_factor(seed);
  a->tilt = .05 * path_factor(seed);
  a->shear = .25 * path_factor(seed);
  a->turn = .1 * path_factor(seed);
  const double friction = .3 * path_factor(seed);
  a->at = malloc(sizeof *a->at * 2 * (size_t)nc);
  if (!a->at || regret_room(&a->of, d, nc)) exit(1);
  double *W = a->of.W, *mu = a->of.own.mu;
  for (int c = 0; c < nc; c++) {
    a->at[2 * c] = 2 * (c % side + .5) / side - 1;
    a->at[2 * c + 1] = d == 2 ? 0 : 2 * (c / side + .5) / side - 1;
  }
  if (d == 2)
    (void)half_plane(W, a->of.own.q, mu, nc, 2, 0, 0, friction);
  else
    half_space(nc, a->at, 2. / side, W);
  for (int c = 0; c < nc; c++)
    mu[c] = friction;
  for (size_t k = 0; k < (size_t)m * (size_t)m; k++)
    W[k] *= d == 2 ? 2. / side : 4 * acos(0); /* of a cell; 2 pi */
}

/* Sets q for the share `load` of the way: a crowned punch that presses, tilts and shears. */
static void path_load(const path *a, double load) {
  for (int c = 0; c < a->nc; c++) {
    const double x = a->at[2 * c], y = a->at[2 * c + 1];
    double *q = a->of.own.q + a->d * c;
    q[0] = -.2 - a->press * load + a->crown * (x * x + y * y) + a->tilt * x * load;
    q[1] = a->shear * load;
    if (a->d == 3) q[2] = a->turn * load * x;
  }
}

/* Walks the path, cold or warm; returns CPU ms per step. */
static double path_time(const path *a, int warm, int *solved) {
  dls_solver_settings s;
  dls_solver_settings_init(&s);
  s.limits.warm_start = warm;
  dls_solver *solver;
  double *r = calloc((size_t)(a->d * a->nc), sizeof *r);
  bench_clock c = {0};
  if (!r || dls_solver_create(&solver, a->d, a->nc, &s, NULL)) exit(1);
  *solved = 0;
  steps_state = 0;
  for (int k = 1; k <= load_steps; k++) {
    const double load = (double)k / load_steps + a->jump * steps_draw();
    path_load(a, fmin(fmax(load, 1. / load_steps), 1));
    dls_info info;
    bench_start(&c);
    *solved += dls_solver_solve(solver, &a->of.contact, r, NULL, &info, NULL) == DLS_OK;
    (void)bench_stop(&c);
  }
  dls_solver_destroy(solver);
  free(r);
  return 1e3 * c.all / load_steps;
}

static void path_free(path *a) {
  regret_free(&a->of);
  free(a->at);
}

static void print_path(FILE *page, int d, int side, int seed, double jump) {
  path a;
  double least[2] = {INFINITY, INFINITY};
  int solved[2];
  path_make(&a, d, side, seed, jump);
  for (int run = 0; run < 3; run++)
    for (int warm = 0; warm < 2; warm++)
      least[warm] = fmin(least[warm], path_time(&a, warm, &solved[warm]));
  bench_print(seed == 2 ? NULL : page, "| %d | %d | %d | %.3f | %.3f | %.2f | %d, %d |\n", a.d,
              a.nc, seed, least[0], least[1], least[1] / least[0], solved[0], solved[1]);
  path_free(&a);
}

static void print_paths(FILE *page) {
  static const struct {
    int d, side, seed;
  } scene[] = {{2, 64, 0}, {2, 150, 0}, {2, 200, 0}, {2, 300, 0}, {2, 500, 0}, {2, 64, 2},
               {2, 64, 4}, {2, 240, 2}, {2, 240, 4}, {2, 500, 2}, {2, 500, 4}, {3, 8, 0},
               {3, 14, 0}, {3, 20, 0},  {3, 8, 2},   {3, 8, 4},   {3, 12, 2},  {3, 12, 4},
               {3, 14, 2}, {3, 14, 4},  {3, 20, 2},  {3, 20, 4}};
  static const double jump[] = {0, .05, .3};
  for (int j = 0; j < 3; j++) {
    bench_print(page, "\n## Load paths of %d steps, elastic, W dense, 1e-8", load_steps);
    if (j) bench_print(page, ", the load up to %g of the path ahead or behind", jump[j]);
    bench_print(page,
                "\n\n| d | contacts | seed | cold, ms a step | warm | warm over cold | solved |\n"
                "|---|---|---|---|---|---|---|\n");
    for (size_t k = 0; k < sizeof scene / sizeof scene[0]; k++)
      if (!j || scene[k].seed == 4)
        print_path(page, scene[k].d, scene[k].side, scene[k].seed, jump[j]);
  }
}

/* ---- a punch that cannot touch everywhere ---------------------------------------------------- */

/* Returns the least CPU ms of 20 solves from r = 0. As a warm start, auto leaves out none. */
static double part_time(const path *a, int warm, int *touching) {
  dls_solver_settings s;
  dls_solver_settings_init(&s);
  s.limits.warm_start = warm;
  dls_solver *solver;
  double *r = malloc(sizeof *r * (size_t)(a->d * a->nc));
  bench_clock clock = {0};
  if (!r || dls_solver_create(&solver, a->d, a->nc, &s, NULL)) exit(1);
  while (bench_runs(&clock, 20, 0, 0)) {
    memset(r, 0, sizeof *r * (size_t)(a->d * a->nc));
    if (dls_solver_solve(solver, &a->of.contact, r, NULL, NULL, NULL)) exit(1);
  }
  *touching = 0;
  for (int c = 0; c < a->nc; c++)
    *touching += r[a->d * c] > 0;
  dls_solver_destroy(solver);
  free(r);
  return 1e3 * clock.least;
}

static void print_parts(FILE *page) {
  static const struct { int d, side; } scene[] = {{2, 150}, {2, 400}, {3, 10}, {3, 20}};
  bench_print(page, "\n## A crowned punch, W dense, 1e-8: what cannot touch is left out\n\n"
                    "| d | contacts | q_n <= 0 | touch | all, ms | without the others | ratio |\n"
                    "|---|---|---|---|---|---|---|\n");
  for (size_t k = 0; k < sizeof scene / sizeof scene[0]; k++)
    for (int crown = 4; crown <= 8; crown += 4) {
      path a;
      int near = 0, touching[2];
      path_make(&a, scene[k].d, scene[k].side, 0, 0);
      for (int c = 0; c < a.nc; c++) {
        const double x = a.at[2 * c], y = a.at[2 * c + 1];
        double *q = a.of.own.q + a.d * c;
        q[0] = crown * (x * x + y * y) - 1;
        q[1] = .25;
        if (a.d == 3) q[2] = .1 * x;
        near += q[0] <= 0;
      }
      const double all = part_time(&a, 1, &touching[1]), some = part_time(&a, 0, &touching[0]);
      if (touching[0] != touching[1]) exit(1);
      bench_print(page, "| %d | %d | %d | %d | %.3f | %.3f | %.2f |\n", a.d, a.nc, near,
                  touching[0], all, some, some / all);
      path_free(&a);
    }
}

int main(int argc, char **argv) {
  FILE *page =
      bench_program(argc, argv, "[--out DIR]", "steps", "Many problems one after the other");
  print_boxes(page);
  print_paths(page);
  print_parts(page);
  return fclose(page) ? 1 : 0;
}
