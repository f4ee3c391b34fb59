/*
 * tables.c: delassus tables: runs both scenes by every method and prints Tables 2 and 3 of
 * [Chabrand 1998] beside the results.
 */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "cli.h"

/* A row of the tables: a method and the paper's minutes, NaN where the paper has none. Lemke
 * comes first: the other methods are compared with it. */
typedef struct row {
  const char *method;
  double paper[2]; /* indentation, extrusion */
  double tol;      /* iterative ones need a smaller one for forces that agree to 1e-8 */
  /* of the study; 0: the default */
  double penalty;
  int augmentations;
  double relaxation;
  int plain; /* 1: without Aitken */
} row;

static const row rows[] = {{"lemke", {9, 2}, 1e-9, 0, 0, 0, 0},
                           {"gauss-seidel", {77, 8.5}, 1e-10, 0, 0, 0, 0},
                           {"augmented-lagrangian", {28, 6.5}, 1e-9, 0, 0, 0, 0},
                           {"penalty", {11, 1.75}, 1e-9, 0, 0, 0, 0},
                           {"nlgs", {NAN, NAN}, 1e-9, 0, 0, 0, 0},
                           {"newton", {NAN, NAN}, 1e-9, 0, 0, 0, 0},
                           {"auto", {NAN, NAN}, 1e-9, 0, 0, 0, 0}};
enum { ROWS = sizeof rows / sizeof rows[0] };

/* Reactions and displacements at the end of every step, by which runs are compared. */
typedef struct history {
  size_t length; /* doubles of a step: 2 * nodes reactions, then as many displacements */
  double *values;
} history;

typedef struct result {
  int done;
  dls_forming_data data;
  double cpu;
  double force, displacement; /* largest differences from Lemke's, over the largest of the step */
} result;

/* Returns the largest |a - b| over the largest |b|. */
static double relative_distance(const double *a, const double *b, size_t n) {
  double d = 0, m = 0;
  for (size_t i = 0; i < n; i++) {
    d = fmax(d, fabs(a[i] - b[i]));
    m = fmax(m, fabs(b[i]));
  }
  return d > 0 ? d / m : 0;
}

/* Keeps a step of the first method, and compares a step of another method with it. */
static int compare_step(const dls_forming_data *d, int step, int first, history *h, result *r) {
  const size_t n = 2 * (size_t)d->mesh->nodes;
  if (first && step == 1) {
    h->length = 2 * n;
    h->values = malloc(h->length * (size_t)d->steps * sizeof *h->values);
  }
  if (!h->values) return 0;
  double *at = h->values + h->length * (size_t)(step - 1);
  if (first) {
    memcpy(at, d->reaction, n * sizeof *at);
    memcpy(at + n, d->displacement, n * sizeof *at);
  }
  r->force = fmax(r->force, relative_distance(d->reaction, at, n));
  r->displacement = fmax(r->displacement, relative_distance(d->displacement, at + n, n));
  return 1;
}

static int run_method(const char *scene, const row *by, int first, history *h, result *r) {
  const char *method = by->method;
  dls_forming_settings settings;
  dls_forming *forming;
  dls_error error = {0};
  dls_forming_settings_init(&settings);
  *r = (result){0};
  if (!forming_method(method, &settings)) return 1; /* not in this build */
  settings.tol = by->tol;
  settings.penalty = by->penalty;
  settings.augmentations = by->augmentations;
  if (by->relaxation > 0) settings.relaxation = by->relaxation;
  settings.aitken = !by->plain;
  const double start = cpu_seconds();
  if (dls_forming_create(&forming, scene, &settings, &error)) return complain_of(scene, &error), 0;
  dls_forming_get(forming, &r->data);
  int good = 1;
  const int steps = r->data.steps;
  dls_status status = DLS_OK;
  for (int step = 1; good && !status && step <= steps; step++) {
    status = dls_forming_step(forming, &error);
    dls_forming_get(forming, &r->data);
    if (status) {
      complain("%s by %s: %s at %g mm", scene, method, dls_status_text(status), r->data.travel);
      good = 0;
    } else if (!compare_step(&r->data, step, first, h, r)) {
      complain("out of memory");
      good = 0;
    } else if (show_step(&r->data, step)) {
      good = 0;
    }
  }
  progress_end();
  r->cpu = cpu_seconds() - start;
  r->done = good;
  dls_forming_destroy(forming);
  return good;
}

static void print_result(const char *method, double paper, double paper_lemke, const result *r,
                         double lemke) {
  const dls_forming_data *d = &r->data;
  printf("%-20s", method);
  if (isnan(paper))
    printf("  %6s  %6s", "-", "-");
  else
    printf("  %6.2f  %6.2f", paper, paper / paper_lemke);
  printf("  %7.2f  %6.2f  %6.2f  %6.2f  %6.2f  %7d  %7d  %9d  %8.1e  %8.1e  %8.1e\n", r->cpu,
         r->cpu / lemke, d->cpu.assembly, d->cpu.reduction, d->cpu.contact, d->count.newton,
         d->count.frames, d->count.iterations, r->force, r->displacement, d->worst_residual);
}

/* Prints the pairs of the paper's methods whose order by CPU is another one here. */
static void print_order(int scene, const result *r) {
  int same = 1;
  for (int a = 0; a < ROWS; a++)
    for (int b = 0; b < ROWS; b++) {
      if (!(rows[a].paper[scene] < rows[b].paper[scene]) || !r[a].done || !r[b].done) continue;
      if (r[a].cpu <= r[b].cpu) continue;
      same = 0;
      printf("The paper has %s before %s, here it is the other way round (%.2f s and %.2f s).\n",
             rows[a].method, rows[b].method, r[a].cpu, r[b].cpu);
    }
  if (same) puts("The order of the paper's four methods by CPU is the paper's.");
}

static int run_table(int scene) {
  const char *name = dls_forming_name(scene);
  history h = {0};
  result r[ROWS];
  int good = 1;
  printf(
      "Table %d of the paper: %s. The paper: minutes, and ratio to Lemke. Here: seconds of CPU,\n"
      "ratio to Lemke, of which assembly, factorisation and condensation, method; counts; largest\n"
      "difference of nodal contact forces and of displacements from Lemke's in any step, over the\n"
      "largest of the step; worst certificate. Tolerance 1e-9, Gauss-Seidel 1e-10.\n\n",
      scene + 2, name);
  printf("%-20s  %6s  %6s  %7s  %6s  %6s  %6s  %6s  %7s  %7s  %9s  %8s  %8s  %8s\n", "method",
         "paper", "ratio", "CPU", "ratio", "assem", "factor", "method", "Newton", "frames",
         "iterations", "force", "displ", "residual");
  for (int k = 0; good && k < ROWS; k++) {
    good = run_method(name, &rows[k], k == 0, &h, &r[k]);
    if (r[k].done)
      print_result(rows[k].method, rows[k].paper[scene], rows[0].paper[scene], &r[k], r[0].cpu);
  }
  free(h.values);
  if (!good) return 0;
  putchar('\n');
  print_order(scene, r);
  return 1;
}

/* Prints section 6 of the paper: what penalty factor, augmentations, relaxation and Aitken's
 * acceleration give and take, force error against CPU. */
static int run_study(int scene) {
  static const row study[] = {
      {"lemke", {NAN, NAN}, 1e-9, 0, 0, 0, 0},
      {"penalty", {NAN, NAN}, 1e-9, 10, 0, 0, 0},
      {"penalty", {NAN, NAN}, 1e-9, 100, 0, 0, 0},
      {"penalty", {NAN, NAN}, 1e-9, 1000, 0, 0, 0},
      {"penalty", {NAN, NAN}, 1e-9, 10000, 0, 0, 0},
      {"augmented-lagrangian", {NAN, NAN}, 1e-9, 10, 1, 0, 0},
      {"augmented-lagrangian", {NAN, NAN}, 1e-9, 10, 5, 0, 0},
      {"augmented-lagrangian", {NAN, NAN}, 1e-9, 10, 0, 0, 0},
      {"augmented-lagrangian", {NAN, NAN}, 1e-9, 100, 1, 0, 0},
      {"augmented-lagrangian", {NAN, NAN}, 1e-9, 100, 5, 0, 0},
      {"augmented-lagrangian", {NAN, NAN}, 1e-9, 100, 0, 0, 0},
      {"gauss-seidel", {NAN, NAN}, 1e-10, 0, 0, 1, 1},
      {"gauss-seidel", {NAN, NAN}, 1e-10, 0, 0, 1.5, 1},
      {"gauss-seidel", {NAN, NAN}, 1e-10, 0, 0, 1.8, 1},
      {"gauss-seidel", {NAN, NAN}, 1e-10, 0, 0, 1, 0},
      {"gauss-seidel", {NAN, NAN}, 1e-10, 0, 0, 1.5, 0},
  };
  history h = {0};
  double lemke = 1;
  int good = 1;
  printf(
      "%s: augmentations a step at most (0: as many as it takes), largest difference of nodal\n"
      "contact forces from Lemke's in any step over the largest of the step, CPU over Lemke's\n\n"
      "%-20s  %7s  %5s  %5s  %6s  %8s  %8s  %7s  %10s\n",
      dls_forming_name(scene), "method", "penalty", "augm", "relax", "Aitken", "force", "CPU",
      "ratio", "iterations");
  for (size_t k = 0; good && k < sizeof study / sizeof study[0]; k++) {
    const row *s = &study[k];
    result r;
    good = run_method(dls_forming_name(scene), s, k == 0, &h, &r);
    if (k == 0) lemke = r.cpu;
    if (!r.done) continue;
    printf("%-20s  %7g  %5d  %5g  %6s  %8.1e  %8.2f  %7.2f  %10d\n", s->method, s->penalty,
           s->augmentations, s->relaxation, s->relaxation > 0 ? (s->plain ? "no" : "yes") : "-",
           r.force, r.cpu, r.cpu / lemke, r.data.count.iterations);
  }
  putchar('\n');
  free(h.values);
  return good;
}

int command_tables(int argc, char **argv) {
  const int study = argc == 2 && !strcmp(argv[1], "--study");
  if (argc > 1 && !study) {
    const int help = !strcmp(argv[1], "--help") || !strcmp(argv[1], "-h");
    fputs(
        "Usage: delassus tables [--study]\n"
        "Runs both forming scenes of Chabrand, Dubois and Raous (1998) by every method and prints\n"
        "their Tables 2 and 3 beside ours. With --study: the compromise of section 6 between the\n"
        "error of the forces and the CPU, over penalty factors, augmentations, relaxation, "
        "Aitken.\n",
        help ? stdout : stderr);
    return help ? EXIT_SOLVED : EXIT_BAD_INPUT;
  }
  watch_interrupt();
  for (int scene = 0; scene < 2; scene++)
    if (!(study ? run_study : run_table)(scene)) return EXIT_NOT_SOLVED;
  if (study) return EXIT_SOLVED;
  puts(
      "\nWhy: with ten or twenty candidates the method's own share is small, and the assembly for "
      "each\n"
      "Newton step is the same for all. On W, a factorisation and a solve for each of its columns\n"
      "come on top. Springs save these columns, and so does auto, which is Newton's method on K\n"
      "here: both factorise once for each guess of what sticks and slips. Augmentations cost\n"
      "assemblies and factorisations of their own; the penalty method has but one, and the error\n"
      "that the table shows.");
  return EXIT_SOLVED;
}
