/*
 * report.c: is the setting that `delassus report` advises accurate enough, and is it cheap?
 *
 *   report [--out DIR] [--cpu S] [--scene NAME]...
 *       report.md: for each scene and accuracy the advised setting, its error beside a reference
 *       four times finer in mesh and steps, and its CPU beside the cheapest setting of a grid that
 *       is within the accuracy
 *
 * Reference: the closed form; for one equilibrium 512 x 256 elements graded to the power 3; else
 * elements a quarter as large and four times the steps of the setting advised for the tightest
 * accuracy, tol / 100; where that would take more than 60 s by the costs of half the element size,
 * elements half as large and four times the steps. What such a reference, k times finer than a
 * setting, keeps of its error is added by the order p of the ladder for the tightest accuracy: the
 * difference over 1 - k^-p, p = 0.5 without an order. Scenes of dynamics: their steps follow the
 * mesh.
 *
 * Grid: mesh by sqrt(2), steps by 2, the tolerance as advised, every setting up to twice the CPU of
 * the advised one. A setting of the grid counts if it and all settings of the grid that are as fine
 * or finer in both are within the accuracy of the reference: not by luck. Runs that do not finish
 * do not count.
 */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "common.h"
#include "report/report.h"

enum { ACCURACIES = 3, GRID_LOW = -12, GRID_HIGH = 9, GRID = GRID_HIGH - GRID_LOW + 1 };
static const double accuracies[ACCURACIES] = {1e-1, 1e-2, 1e-3};
static const double long_reference = 60; /* CPU seconds */

typedef struct grid_cell {
  int run;
  double error, seconds;
} grid_cell;

static void stop_on(dls_status status, const char *name, const dls_error *error) {
  if (status >= 0) return;
  (void)fprintf(stderr, "report: %s: %s\n", name, error->message);
  exit(1);
}

static scene_answer run_at(const scene *s, setting at, double limit) {
  scene_answer got;
  dls_error error = {0};
  stop_on(scene_run(s, &at, limit, &got, &error), s->name, &error);
  return got;
}

/* Returns `at` with `mesh` times the elements along each side and four times the steps. */
static setting finer(setting at, int mesh) {
  at.nx = mesh * at.nx;
  at.ny = mesh * at.ny;
  at.upper = mesh * at.upper;
  at.steps = 4 * at.steps;
  at.tol = fmax(at.tol / 100, 1e-8); /* Newton on a fine mesh leaves 1e-9 of the forces */
  return at;
}

/* Makes the reference. *at: in, the setting advised for the tightest accuracy; out, that of the
 * reference, all 0 for a closed form or a graded mesh. */
static double run_reference(const scene *s, setting *at) {
  const setting advised = *at;
  *at = (setting){0};
  if (isfinite(s->exact)) return s->exact;
  if (s->kind == SCENE_AT_ONCE) {
    const setting fine = {.tol = 1e-8, .nx = 512, .ny = 256, .grade = 3, .mu = -1};
    return run_at(s, fine, 1e9).value;
  }
  *at = finer(advised, 2);
  const scene_answer half = run_at(s, *at, 1e9), own = run_at(s, advised, 1e9);
  if (!advised.nx || half.seconds * half.seconds / own.seconds >= long_reference) return half.value;
  *at = finer(advised, 4);
  return run_at(s, *at, 1e9).value;
}

/* Returns the CPU of the cheapest setting of the grid that is within the accuracy, with all finer
 * ones. */
static double find_cheapest(const scene *s, const setting *advised, double seconds,
                            double reference, double accuracy) {
  static grid_cell grid[GRID][GRID];
  double best = INFINITY;
  memset(grid, 0, sizeof grid);
  for (int i = 0; i < GRID; i++)
    for (int j = 0; j < GRID; j++) {
      grid_cell *g = &grid[i][j];
      setting here = setting_scaled(s, i + GRID_LOW, j + GRID_LOW, 0);
      const setting before = setting_scaled(s, i + GRID_LOW - 1, j + GRID_LOW, 0);
      const setting fewer = setting_scaled(s, i + GRID_LOW, j + GRID_LOW - 1, 0);
      here.tol = advised->tol;
      here.grade = advised->grade;
      if ((s->own.nx ? before.nx == here.nx : i > 0) ||
          (s->own.steps ? fewer.steps == here.steps : j > 0))
        continue;
      g->seconds = fmax(i ? grid[i - 1][j].seconds : 0, j ? grid[i][j - 1].seconds : 0);
      if (g->seconds > 2 * seconds) continue; /* a finer mesh and more steps cost more */
      const scene_answer got = run_at(s, here, 4 * seconds);
      *g = (grid_cell){isfinite(got.value), fabs(got.value / reference - 1), got.seconds};
    }
  for (int i = 0; i < GRID; i++)
    for (int j = 0; j < GRID; j++) {
      int good = grid[i][j].run;
      for (int k = i; k < GRID && good; k++)
        for (int l = j; l < GRID && good; l++)
          if (grid[k][l].run && !(grid[k][l].error <= accuracy)) good = 0;
      if (good) best = fmin(best, grid[i][j].seconds);
    }
  return best;
}

/* Returns the true error of the limit over its estimate, the closed form kept aside. */
static double kept_aside(scene s, const budget *asked, double truth) {
  static budget b;
  dls_error error = {0};
  s.exact = NAN;
  b = (budget){&s, .of = asked->of, .accuracy = asked->accuracy, .limit = asked->limit};
  stop_on(budget_run(&b, &error), s.name, &error);
  return fabs(b.reference / truth - 1) / b.doubt[OF_FORCE];
}

typedef struct tally {
  int pairs, met, missed, unknown, undecided, cheap;
} tally;

static void bench_scene(FILE *to, const char *name, double cpu, tally *sum) {
  scene s;
  dls_error error = {0};
  dls_status status = DLS_OK;
  static budget b[ACCURACIES];
  if (!scene_find(name, &s, &status, &error)) exit(1);
  stop_on(status, name, &error);
  for (int k = 0; k < ACCURACIES; k++) {
    b[k] = (budget){&s, .of = 1 << OF_FORCE, .accuracy = accuracies[k], .limit = cpu};
    stop_on(budget_run(&b[k], &error), name, &error);
  }
  const budget *last = &b[ACCURACIES - 1];
  setting fine = last->probe[last->take].at;
  const double reference = run_reference(&s, &fine);
  const double own = s.own.nx ? last->mesh.order : last->steps.order;
  const double order = isfinite(own) ? own : 0.5; /* of what is refined */
  for (int k = 0; k < ACCURACIES; k++) {
    const probe *take = &b[k].probe[b[k].take];
    char words[SETTING_ROOM];
    const double times = fine.nx      ? (double)fine.nx / take->at.nx
                         : fine.steps ? (double)fine.steps / take->at.steps
                                      : INFINITY;
    const double wrong = fabs(take->got.value / reference - 1) / (1 - pow(times, -order));
    const double least =
        b[k].met ? find_cheapest(&s, &take->at, take->got.seconds, reference, accuracies[k])
                 : INFINITY;
    sum->pairs++;
    sum->undecided += !b[k].met;
    sum->met += b[k].met && wrong <= accuracies[k];
    sum->missed += b[k].met && wrong > accuracies[k];
    sum->unknown += b[k].met && !isfinite(wrong);
    sum->cheap += b[k].met && take->got.seconds <= 2 * least;
    bench_print(to, "| %s | %g | %s%s | %.2g | %.2g |", name, accuracies[k],
                b[k].met ? "" : "not decided: ", setting_text(&s, &take->at, 0, words), wrong,
                take->got.seconds);
    bench_print(to, isfinite(least) ? " %.2g | %.2g |" : " | %.2g |",
                isfinite(least) ? take->got.seconds / least : b[k].error, b[k].error);
    if (times < INFINITY)
      bench_print(to, " |\n");
    else
      bench_print(to, " %.2g |\n", kept_aside(s, &b[k], reference));
    (void)fflush(to);
  }
}

int main(int argc, char **argv) {
  const double cpu = bench_number(argc, argv, "--cpu", 33);
  const int all = !bench_has(argc, argv, "--scene");
  FILE *to = bench_program(argc, argv, "[--out DIR] [--cpu SECONDS] [--scene NAME]", "report",
                           "The setting that delassus report advises");
  tally sum = {0};
  bench_print(
      to, "Each scene at three accuracies: the advised setting, its error beside the closed form, "
          "a graded mesh of 512 x 256,\nor a reference with four times the steps and finer "
          "elements, its CPU, that CPU over the cheapest setting of a grid that is\nwithin the "
          "accuracy with all finer ones (empty: none up to twice this CPU), and the error that the "
          "report estimates. Last:\nthe true error of the limit of the meshes over its estimate, "
          "closed forms kept aside.\n\n| scene | accuracy | advised | error | CPU s | over the "
          "cheapest | estimated | limit |\n|---|---|---|---|---|---|---|---|\n");
  for (int k = 0; scene_name(k) && all; k++)
    bench_scene(to, scene_name(k), cpu, &sum);
  for (int k = 1; k + 1 < argc; k += 2)
    if (strcmp(argv[k], "--scene") == 0) bench_scene(to, argv[k + 1], cpu, &sum);
  bench_print(
      to,
      "\n%d pairs: %d met, %d missed, %d whose reference stops, %d not decided within %g s of "
      "CPU, which the report says; %d of those decided cost at most twice the cheapest.\n",
      sum.pairs, sum.met, sum.missed, sum.unknown, sum.undecided, cpu, sum.cheap);
  return fclose(to) != 0;
}
