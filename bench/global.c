/*
 * global.c: compares contact over whole surfaces on K (dls_global_solve), on W and by the same
 * splitting with CHOLMOD (global_peer.c).
 *
 *   global [--table NAME]... [--out DIR]         the tables: peer, growth, tolerance, robust,
 *                                                foreseen, choice, where; all without --table
 *   global --scene KIND SUPPORT LOAD NX NY NZ [--mu MU] [--tol TOL] [--seed SEED]
 *                                                one scene by all methods, on the screen only
 *
 * Every solve runs in a child process, which makes the scene itself: CPU seconds from create to the
 * answer, on one thread, and the peak of its memory without the model. Methods to be compared run
 * three times each, in turn; the fastest run counts. Seeds are even: odd ones served for tuning. W
 * is refused if its estimate is more than 4 GB.
 *
 * Writes DIR/global.md, and DIR/global.csv for the picture.
 */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "common.h"
#include "global_ways.h"

enum { turns = 3, WHERE = 6, TABLES };

static const double most_bytes = 4e9;

/* One scene with its friction and tolerance. */
typedef struct task {
  scene S;
  double mu, tol;
} task;

static task task_of(scene_kind kind, scene_support support, scene_load load, int nx, int ny,
                    int nz) {
  return (task){.S = {.kind = kind, .support = support, .load = load, .size = {nx, ny, nz}},
                .mu = 0.3,
                .tol = 1e-8};
}

static int is_3d(const scene *S) {
  return S->kind == PLATE || S->kind == TUBE;
}

/* Prints "strip 4000 x 4, soft, lift". */
static void print_scene(FILE *page, const scene *S) {
  bench_print(page, "%s %d x %d", scene_kind_name[S->kind], S->size[0], S->size[1]);
  if (is_3d(S)) bench_print(page, " x %d", S->size[2]);
  bench_print(page, ", %s, %s", scene_support_name[S->support], scene_load_name[S->load]);
}

/* Runs the ways of a mask in turn, and keeps the fastest of each. */
static void run_ways(const task *t, int ways, int count, result *best) {
  for (int turn = 0; turn < count; turn++)
    for (way w = ON_K; w < WAYS; w++) {
      if (turn == 0) best[w] = (result){.failed = 1};
      if (!(ways >> w & 1) || (turn && best[w].failed)) continue;
      const result now = run_way(w, &t->S, t->mu, t->tol, 1, most_bytes);
      if (turn == 0 || now.cpu < best[w].cpu) best[w] = now;
    }
}

static int is_solved(const result *r) {
  return !r->failed && dls_solved(r->status);
}

/* Prints a number, or nothing where a way has none. */
static void print_number(FILE *page, const char *format, int there, double x) {
  if (there)
    bench_print(page, format, x);
  else
    bench_print(page, " |");
}

/* ---- tables ---------------------------------------------------------------------------------- */

static void table_peer(FILE *page) {
  const task tasks[] = {
      task_of(STRIP, SOFT, LIFT, 1000, 4, 1),  task_of(STRIP, SOFT, LIFT, 4000, 4, 1),
      task_of(STRIP, SOFT, LIFT, 20000, 4, 1), task_of(STRIP, SOFT, PRESS, 4000, 4, 1),
      task_of(SHEETS, SOFT, LIFT, 2000, 4, 1), task_of(RIM, SOFT, LIFT, 1600, 8, 1),
      task_of(PLATE, SOFT, LIFT, 20, 20, 3),   task_of(PLATE, SOFT, LIFT, 50, 50, 3),
      task_of(PLATE, SOFT, PRESS, 50, 50, 3),  task_of(PLATE, SOFT, LIFT, 20, 20, 20),
      task_of(TUBE, SOFT, LIFT, 128, 24, 2),   task_of(PLATE, SOFT, LIFT, 100, 100, 3)};
  bench_print(
      page, "## Against W and against CHOLMOD\n\n`make bench-global BENCH='--table peer'`\n\nTo "
            "1e-8, friction .3. Peer: two factors by CHOLMOD and the plain splitting, R = 1/w. W: "
            "reduction and auto; where it is refused, its memory is an estimate.\n\n| scene | "
            "unknowns | contacts | K: s | MB | iterations | K over peer: CPU | memory | W over K: "
            "CPU | memory |\n|---|---|---|---|---|---|---|---|---|---|\n");
  for (size_t k = 0; k < sizeof tasks / sizeof tasks[0]; k++) {
    result r[WAYS];
    run_ways(&tasks[k], 1 << ON_K | 1 << PEER, turns, r);
    r[ON_W] = run_way(ON_W, &tasks[k].S, tasks[k].mu, tasks[k].tol, 1, most_bytes);
    const result *K = &r[ON_K], *W = &r[ON_W], *peer = &r[PEER];
    bench_print(page, "| ");
    print_scene(page, &tasks[k].S);
    bench_print(page, " | %d | %d | %.3g | %.3g | %d%s |", K->n, K->nc, K->cpu, 1e-6 * K->bytes,
                K->iterations, is_solved(K) ? "" : " unsolved");
    bench_print(page, " %.2g%s | %.2g |", K->cpu / peer->cpu, is_solved(peer) ? "" : " unsolved",
                K->bytes / peer->bytes);
    print_number(page, " %.2g |", !W->failed, W->cpu / K->cpu);
    bench_print(page, " %.2g |\n", (W->failed ? W->foreseen_W : W->bytes) / K->bytes);
  }
}

static void table_growth(FILE *page) {
  const task tasks[][4] = {
      {task_of(STRIP, SOFT, LIFT, 1000, 4, 1), task_of(STRIP, SOFT, LIFT, 4000, 4, 1),
       task_of(STRIP, SOFT, LIFT, 20000, 4, 1), task_of(STRIP, SOFT, LIFT, 100000, 4, 1)},
      {task_of(PLATE, SOFT, LIFT, 13, 13, 3), task_of(PLATE, SOFT, LIFT, 25, 25, 3),
       task_of(PLATE, SOFT, LIFT, 50, 50, 3), task_of(PLATE, SOFT, LIFT, 100, 100, 3)},
      {task_of(PLATE, SOFT, LIFT, 8, 8, 8), task_of(PLATE, SOFT, LIFT, 14, 14, 14),
       task_of(PLATE, SOFT, LIFT, 24, 24, 24), task_of(PLATE, SOFT, LIFT, 36, 36, 36)},
      {task_of(STRIP, HELD, LIFT, 300, 4, 1), task_of(STRIP, HELD, LIFT, 1000, 4, 1),
       task_of(STRIP, HELD, LIFT, 2000, 4, 1), task_of(STRIP, HELD, LIFT, 3000, 4, 1)}};
  bench_print(page,
              "\n## Growth\n\n`make bench-global BENCH='--table growth'`\n\nTo 1e-8, friction .3. "
              "The largest of four scenes of a kind. The exponent is that of CPU, and of memory, "
              "against unknowns, from the second scene to this one.\n\n"
              "| scene | unknowns | contacts | s | MB | iterations | factors | CPU grows like | "
              "memory |\n|---|---|---|---|---|---|---|---|---|\n");
  for (int row = 0; row < 4; row++) {
    result second = {.failed = 1};
    for (int k = 0; k < 4; k++) {
      const result r = run_way(ON_K, &tasks[row][k].S, 0.3, 1e-8, turns, 0);
      if (k == 1) second = r;
      FILE *const kept = k == 3 ? page : NULL; /* the screen shows all */
      bench_print(kept, "| ");
      print_scene(kept, &tasks[row][k].S);
      bench_print(kept, " | %d | %d | %.3g | %.3g | %d%s | %d |", r.n, r.nc, r.cpu, 1e-6 * r.bytes,
                  r.iterations, is_solved(&r) ? "" : " unsolved", r.factorisations);
      const double by = log((double)r.n / second.n);
      bench_print(kept, " n^%.2f | n^%.2f |\n", log(r.cpu / second.cpu) / by,
                  log(r.bytes / second.bytes) / by);
    }
  }
}

static void table_tolerance(FILE *page) {
  const double tol[] = {1e-4, 1e-6, 1e-8, 1e-10, 1e-12};
  const task tasks[] = {
      task_of(STRIP, SOFT, LIFT, 4000, 4, 1), task_of(SHEETS, SOFT, LIFT, 2000, 4, 1),
      task_of(RIM, SOFT, LIFT, 1600, 8, 1),   task_of(PLATE, SOFT, LIFT, 50, 50, 3),
      task_of(TUBE, SOFT, LIFT, 128, 24, 2),  task_of(STRIP, HELD, LIFT, 1000, 4, 1)};
  bench_print(page, "\n## Tolerance\n\n`make bench-global BENCH='--table tolerance'`\n\nCPU s "
                    "(iterations), friction .3.\n\n| scene | 1e-4 | 1e-6 | 1e-8 | 1e-10 | 1e-12 | "
                    "1e-12 over 1e-6 |\n|---|---|---|---|---|---|---|\n");
  for (size_t k = 0; k < sizeof tasks / sizeof tasks[0]; k++) {
    double cpu[5];
    bench_print(page, "| ");
    print_scene(page, &tasks[k].S);
    for (int i = 0; i < 5; i++) {
      const result r = run_way(ON_K, &tasks[k].S, 0.3, tol[i], turns, 0);
      cpu[i] = r.cpu;
      bench_print(page, " | %.3g (%d%s)", r.cpu, r.iterations, is_solved(&r) ? "" : ", unsolved");
    }
    bench_print(page, " | %.2g |\n", cpu[4] / cpu[1]);
  }
}

/* Returns 1 if contact with this friction can hold the body against the load for sure. */
static int is_held(const task *t) {
  if (t->S.support != FREE) return 1;
  return t->S.load == SHEAR ? t->mu >= 0.7 : t->mu >= 0.3;
}

static void table_robust(FILE *page) {
  const int sizes[SCENE_KINDS][3] = {
      {1000, 4, 1}, {300, 4, 1}, {320, 6, 1}, {24, 24, 2}, {64, 16, 2}};
  const double mu[] = {0.05, 0.1, 0.3, 0.7, 1, 2};
  double all[1000], most = 0, slowest = 0;
  size_t count = 0, unsolved = 0;
  bench_print(page, "\n## Loads, supports, friction\n\n`make bench-global BENCH='--table "
                    "robust'`\n\nTo 1e-8, friction .05, .1, .3, .7, 1, 2, seeds "
                    "2 and 4. Free bodies without the frictions that may not hold them. Solved of "
                    "all, and most iterations.\n\n"
                    "| five bodies, support | press | shear | lift |\n|---|---|---|---|\n");
  for (int support = 0; support < SCENE_SUPPORTS; support++) {
    bench_print(page, "| %s |", scene_support_name[support]);
    for (int load = 0; load < SCENE_LOADS; load++) {
      double here = 0;
      size_t tried = 0, solved = 0;
      for (int k = 0; k < 12 * SCENE_KINDS; k++) {
        const int kind = k / 12, *s = sizes[kind];
        task t =
            task_of((scene_kind)kind, (scene_support)support, (scene_load)load, s[0], s[1], s[2]);
        t.mu = mu[k % 12 / 2];
        t.S.seed = 2 + 2 * (k % 2);
        if (!is_held(&t)) continue;
        const result r = run_way(ON_K, &t.S, t.mu, t.tol, 1, 0);
        all[count++] = r.iterations;
        here = fmax(here, r.iterations);
        tried++;
        solved += (size_t)is_solved(&r);
        unsolved += !is_solved(&r);
        slowest = fmax(slowest, r.cpu);
        if (!is_solved(&r))
          fprintf(stderr, "unsolved: %s, mu %g seed %d: %s, %.1e\n", scene_kind_name[kind], t.mu,
                  t.S.seed, dls_status_name(r.status), r.residual);
      }
      most = fmax(most, here);
      bench_print(page, " %zu of %zu: %.0f |", solved, tried, here);
    }
    bench_print(page, "\n");
  }
  const double median = bench_median(count, all);
  size_t beyond = 0;
  for (size_t k = 0; k < count; k++)
    beyond += all[k] > 3 * median;
  bench_print(page,
              "\n%zu scenes, %zu unsolved. Iterations: median %.0f, most %.0f, %.2g times the "
              "median; %zu scenes take more than 3 times the median. The slowest: %.2g s.\n",
              count, unsolved, median, most, most / median, beyond, slowest);
}

static void table_foreseen(FILE *page) {
  const task tasks[] = {
      task_of(STRIP, SOFT, LIFT, 1000, 4, 1),  task_of(STRIP, SOFT, LIFT, 20000, 4, 1),
      task_of(STRIP, SOFT, LIFT, 400, 40, 1),  task_of(STRIP, SOFT, LIFT, 200, 200, 1),
      task_of(SHEETS, SOFT, LIFT, 2000, 4, 1), task_of(RIM, SOFT, LIFT, 1600, 8, 1),
      task_of(PLATE, SOFT, LIFT, 20, 20, 3),   task_of(PLATE, SOFT, LIFT, 50, 50, 3),
      task_of(PLATE, SOFT, LIFT, 20, 20, 20),  task_of(TUBE, SOFT, LIFT, 128, 24, 2)};
  bench_print(
      page, "\n## Estimates\n\n`make bench-global BENCH='--table foreseen'`\n\nFigures of "
            "dls_global_estimate over measured ones, ten scenes. Factor: flops / 30e9 + 7e-9 s for "
            "each entry; step: step_bytes / (10 GB/s); create: .15e-6 s for each entry of a "
            "triangle of K.\n\n| factor | step | create | memory |\n|---|---|---|---|\n|");
  double least[4] = {INFINITY, INFINITY, INFINITY, INFINITY}, most[4] = {0};
  for (size_t k = 0; k < sizeof tasks / sizeof tasks[0]; k++) {
    const result r = run_way(ON_K, &tasks[k].S, 0.3, 1e-8, turns, 0);
    const double entries = r.foreseen.factor_bytes / sizeof(double);
    const double factor = r.foreseen.flops / 30e9 + 7e-9 * entries;
    const double step = (r.cpu - r.create - r.factorisations * r.factor) / r.iterations;
    const double ratio[] = {factor / r.factor, r.foreseen.step_bytes / 10e9 / step,
                            0.15e-6 * r.entries / r.create, r.foreseen.bytes / r.bytes};
    print_scene(NULL, &tasks[k].S);
    for (int i = 0; i < 4; i++) {
      bench_print(NULL, " %.2g%s", ratio[i], i == 3 ? "\n" : "");
      least[i] = fmin(least[i], ratio[i]);
      most[i] = fmax(most[i], ratio[i]);
    }
  }
  for (int i = 0; i < 4; i++)
    bench_print(page, " %.2g to %.2g |", least[i], most[i]);
  bench_print(page, "\n");
}

/* The scenes that the rule of the choice (src/front/body.c) was not made by. */
static const task *scenes_of_choice(int *count) {
  static task all[28];
  const struct {
    scene_kind kind;
    int size[3];
  } bodies[] = {{STRIP, {150, 2, 1}}, {STRIP, {400, 12, 1}}, {STRIP, {1500, 3, 1}},
                {STRIP, {80, 40, 1}}, {SHEETS, {120, 3, 1}}, {SHEETS, {700, 5, 1}},
                {RIM, {320, 6, 1}},   {RIM, {960, 12, 1}},   {PLATE, {9, 9, 3}},
                {PLATE, {18, 18, 6}}, {PLATE, {26, 26, 1}},  {PLATE, {12, 12, 12}},
                {TUBE, {48, 12, 2}},  {TUBE, {96, 16, 1}}};
  *count = 0;
  for (size_t k = 0; k < sizeof bodies / sizeof *bodies; k++)
    for (int seed = 6; seed <= 8; seed += 2) {
      task t =
          task_of(bodies[k].kind, seed == 6 ? SOFT : HELD, (scene_load)((k + (size_t)seed) % 3),
                  bodies[k].size[0], bodies[k].size[1], bodies[k].size[2]);
      t.S.seed = seed;
      all[(*count)++] = t;
    }
  return all;
}

static void print_seconds_or_not(FILE *page, double seconds) {
  bench_print(page, isinf(seconds) ? "not solved | " : "%.3g | ", seconds);
}

static void table_choice(FILE *page) {
  int count, right = 0;
  double most = 0;
  const task *all = scenes_of_choice(&count);
  double over[28];
  bench_print(page, "\n## The choice\n\n`make bench-global BENCH='--table choice'`\n\n"
                    "dls_reduction_create against K and W: bodies, seeds (6, 8) and supports that "
                    "did not serve to make its rule; friction .3, to 1e-8; fastest of three. The "
                    "page has those above 1.2, the screen all.\n\n"
                    "| scene | unknowns | contacts | K: s | W: s | chosen | s | over the better |\n"
                    "|---|---|---|---|---|---|---|---|\n");
  for (int k = 0; k < count; k++) {
    result r[WAYS];
    run_ways(&all[k], 1 << ON_K | 1 << ON_W | 1 << EITHER, turns, r);
    const double K = is_solved(&r[ON_K]) ? r[ON_K].cpu : INFINITY;
    const double W = is_solved(&r[ON_W]) ? r[ON_W].cpu : INFINITY;
    over[k] = r[EITHER].cpu / fmin(K, W);
    most = fmax(most, over[k]);
    right += is_solved(&r[EITHER]);
    FILE *const kept = over[k] > 1.2 ? page : NULL;
    bench_print(kept, "| ");
    print_scene(kept, &all[k].S);
    bench_print(kept, " | %d | %d | ", r[EITHER].n, r[EITHER].nc);
    print_seconds_or_not(kept, K);
    print_seconds_or_not(kept, W);
    bench_print(kept, "%s | %.3g | %.2f |\n", r[EITHER].on_K ? "K" : "W", r[EITHER].cpu, over[k]);
  }
  bench_print(page, "\n%d of %d solved. Over the better of both: median %.2f, most %.2f.\n", right,
              count, bench_median((size_t)count, over), most);
}

static void table_where(FILE *page, FILE *csv) {
  const int strips[] = {60, 120, 250, 500, 1000}, high[] = {1, 2, 4, 8, 16, 32, 64};
  const int plates[] = {6, 10, 16, 24, 32}, thick[] = {1, 2, 4, 8, 16};
  bench_print(
      page,
      "\n## Where K begins to win\n\n`make bench-global BENCH='--table where'`\n\nStrips and "
      "plates of many lengths and heights, soft, lift, friction .3, to 1e-8; every method once, "
      "the faster of both scenes of seeds 2 and 4. global.csv has the seconds.\n\n| d | elements "
      "on a side | CPU of W over CPU of K, 1, 2, 4, .. layers |\n|---|---|---|\n");
  fputs("d,size,layers,n,nc,K_s,W_s,K_MB,W_MB\n", csv);
  for (int d = 2; d <= 3; d++)
    for (int a = 0; a < 5; a++) {
      bench_print(page, "| %d | %d |", d, d == 2 ? strips[a] : plates[a]);
      for (int b = 0; b < (d == 2 ? 7 : 5); b++) {
        const int size = d == 2 ? strips[a] : plates[a], layers = d == 2 ? high[b] : thick[b];
        if (d == 3 && layers > size) continue;
        if (d == 2 && layers * 2 > size) continue;
        result best[WAYS] = {{0}};
        for (int seed = 2; seed <= 4; seed += 2) {
          task t = d == 2 ? task_of(STRIP, SOFT, LIFT, size, layers, 1)
                          : task_of(PLATE, SOFT, LIFT, size, size, layers);
          result now[WAYS];
          t.S.seed = seed;
          run_ways(&t, 1 << ON_K | 1 << ON_W, 1, now);
          for (way w = ON_K; w <= ON_W; w++)
            if (seed == 2 || now[w].cpu < best[w].cpu) best[w] = now[w];
        }
        const result *K = &best[ON_K], *W = &best[ON_W];
        if (!is_solved(K) || W->failed) {
          bench_print(page, b ? ", -" : " -");
          continue;
        }
        fprintf(csv, "%d,%d,%d,%d,%d,%.4g,%.4g,%.4g,%.4g\n", d, size, layers, K->n, K->nc, K->cpu,
                W->cpu, 1e-6 * K->bytes, 1e-6 * W->bytes);
        bench_print(page, "%s %.2g", b ? "," : "", W->cpu / K->cpu);
      }
      bench_print(page, " |\n");
    }
  bench_print(page, "\n![CPU of W over CPU of K against contacts over unknowns](global.png)\n");
}

/* ---- the command ----------------------------------------------------------------------------- */

static int named(const char *const *names, int count, const char *name) {
  for (int k = 0; k < count; k++)
    if (strcmp(names[k], name) == 0) return k;
  fprintf(stderr, "global: %s is not known\n", name);
  exit(2);
}

static int one_scene(int argc, char **argv) {
  task t = task_of((scene_kind)named(scene_kind_name, SCENE_KINDS, argv[0]),
                   (scene_support)named(scene_support_name, SCENE_SUPPORTS, argv[1]),
                   (scene_load)named(scene_load_name, SCENE_LOADS, argv[2]), atoi(argv[3]),
                   atoi(argv[4]), atoi(argv[5]));
  static const char *const way_name[] = {"K", "W", "peer", "either"};
  int failed = 0;
  t.mu = bench_number(argc, argv, "--mu", t.mu);
  t.tol = bench_number(argc, argv, "--tol", t.tol);
  t.S.seed = (int)bench_number(argc, argv, "--seed", t.S.seed);
  for (way w = ON_K; w < WAYS; w++) {
    if (w != ON_K && w != EITHER && t.S.support == FREE) continue;
    const result r = run_way(w, &t.S, t.mu, t.tol, 1, most_bytes);
    failed |= r.failed;
    printf(
        "%-6s %s: n %d, contacts %d, %.3g s, %.3g MB, %d iterations, %d factors, residual %.1e\n",
        way_name[w], r.failed ? "failed or refused" : dls_status_name(r.status), r.n, r.nc, r.cpu,
        1e-6 * r.bytes, r.iterations, r.factorisations, r.residual);
  }
  return failed;
}

int main(int argc, char **argv) {
  static const char *const table[] = {"peer",     "growth", "tolerance", "robust",
                                      "foreseen", "choice", "where"};
  int wanted = 0;
  if (argc > 7 && !strcmp(argv[1], "--scene")) return one_scene(argc - 2, argv + 2);
  if (!bench_options(argc, argv, "[--table NAME] [--out DIR]"))
    return fputs("or: global --scene KIND SUPPORT LOAD NX NY NZ [--mu MU] [--tol TOL] "
                 "[--seed SEED]\n",
                 stderr),
           2;
  for (int k = 1; k + 1 < argc; k += 2)
    if (!strcmp(argv[k], "--table")) wanted |= 1 << named(table, TABLES, argv[k + 1]);
  const char *directory = bench_word(argc, argv, "--out", "bench/results");
  if (!wanted) wanted = (1 << TABLES) - 1;
  FILE *page = bench_page(directory, "global", "The contact problem on K against W", argc, argv);
  FILE *csv = wanted >> WHERE & 1 ? bench_open(directory, "global.csv") : NULL;
  if (!page || (wanted >> WHERE & 1 && !csv)) return EXIT_FAILURE;
  bench_print(page,
              "CPU seconds and peak memory of a child process, without the model; "
              "tests/shared/surfaces.h has the scenes. Each table has its command. One scene: "
              "`build/bench/global --scene strip soft lift 4000 4 1`.\n\n");
  if (wanted & 1) table_peer(page);
  if (wanted >> 1 & 1) table_growth(page);
  if (wanted >> 2 & 1) table_tolerance(page);
  if (wanted >> 3 & 1) table_robust(page);
  if (wanted >> 4 & 1) table_foreseen(page);
  if (wanted >> 5 & 1) table_choice(page);
  if (csv) table_where(page, csv);
  fclose(page);
  if (csv) fclose(csv);
  return 0;
}
