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
  double penalty, relaxation;
  int augmentations, plain; /* plain: 1: without Aitken */
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
  int steps;     /* that the first method has done */
  double *values;
} history;

typedef struct result {
  int present;           /* 0: the method is not in this build */
  int done;              /* 1: all steps are */
  dls_status status;     /* of the last step; DLS_TIME_LIMIT: out of time */
  double travel;         /* at the end */
  dls_forming_data data; /* its counts and times: what the views show is gone */
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
    h->steps = step;
    memcpy(at, d->reaction, n * sizeof *at);
    memcpy(at + n, d->displacement, n * sizeof *at);
  }
  if (step > h->steps) return 1;
  r->force = fmax(r->force, relative_distance(d->reaction, at, n));
  r->displacement = fmax(r->displacement, relative_distance(d->displacement, at + n, n));
  return 1;
}

/* Runs a scene by a method up to its end, to a step that fails, or to `limit` seconds of CPU (0:
 * none). Returns 0 where the table has to end: after a complaint, or an interrupt. */
static int run_method(const char *scene, const row *by, double limit, history *h, result *r) {
  const char *method = by->method;
  dls_forming_settings settings;
  dls_forming *forming;
  dls_error error = {0};
  dls_forming_settings_init(&settings);
  *r = (result){0};
  if (!forming_method(method, &settings)) return 1;
  settings.tol = by->tol;
  settings.penalty = by->penalty;
  settings.augmentations = by->augmentations;
  if (by->relaxation > 0) settings.relaxation = by->relaxation;
  settings.aitken = !by->plain;
  settings.cpu_seconds = limit;
  const int first = !h->values;
  const double start = cpu_seconds();
  if (dls_forming_create(&forming, scene, &settings, &error)) return complain_of(scene, &error), 0;
  dls_forming_get(forming, &r->data);
  int good = 1;
  const int steps = r->data.steps;
  for (int step = 1; good && !r->status && step <= steps; step++) {
    r->status = dls_forming_step(forming, &error);
    dls_forming_get(forming, &r->data);
    if (r->status < 0) {
      (void)complain_of(scene, &error);
      good = 0;
    } else if (!r->status && !compare_step(&r->data, step, first, h, r)) {
      (void)complain("out of memory");
      good = 0;
    } else if (show_step(&r->data, step)) {
      good = 0;
    }
  }
  progress_end();
  r->cpu = cpu_seconds() - start;
  r->travel = r->data.travel;
  r->present = 1;
  r->done = good && !r->status;
  dls_forming_destroy(forming);
  return good;
}

/* Prints why and where a run has stopped, or ends the line. */
static void print_end(const result *r) {
  if (r->done)
    putchar('\n');
  else
    printf("  %s at %.4g of %.4g mm\n", status_word(r->status), r->travel, r->data.whole);
}

static void print_json_result(const char *comma, const row *by, const result *r) {
  const dls_forming_data *d = &r->data;
  printf("%s\n      {\"method\": \"%s\", \"status\": \"%s\"", comma, by->method,
         status_word(r->status));
  const struct {
    const char *name;
    double value;
  } numbers[] = {{"tol", by->tol},
                 {"penalty", by->penalty},
                 {"augmentations", by->augmentations},
                 {"relaxation", by->relaxation},
                 {"aitken", !by->plain},
                 {"travel", r->travel},
                 {"cpu", r->cpu},
                 {"assembly_cpu", d->cpu.assembly},
                 {"reduction_cpu", d->cpu.reduction},
                 {"contact_cpu", d->cpu.contact},
                 {"newton_steps", d->count.newton},
                 {"frames", d->count.frames},
                 {"iterations", d->count.iterations},
                 {"halved", d->count.halvings},
                 {"force_difference", r->force},
                 {"displacement_difference", r->displacement},
                 {"worst_residual", d->worst_residual}};
  for (size_t k = 0; k < sizeof numbers / sizeof numbers[0]; k++) {
    printf(", \"%s\": ", numbers[k].name);
    print_json_number(stdout, numbers[k].value);
  }
}

/* ---- Tables 2 and 3 -------------------------------------------------------------------------- */

/* Returns 1 if the paper has a before b, and here it is the other way round. */
static int is_turned(int scene, const result *r, int a, int b) {
  return rows[a].paper[scene] < rows[b].paper[scene] && r[a].done && r[b].done &&
         r[a].cpu > r[b].cpu;
}

/* Returns 1 if the order of a method and of one before it in the table is not the paper's. */
static int is_marked(int scene, const result *r, int k) {
  for (int a = 0; a < k; a++)
    if (is_turned(scene, r, a, k) || is_turned(scene, r, k, a)) return 1;
  return 0;
}

/* Prints line k of a table, with a star where a remark follows. */
static void print_result(int scene, const result *all, int k) {
  const row *by = &rows[k];
  const result *r = &all[k];
  const dls_forming_data *d = &r->data;
  const double paper = by->paper[scene];
  printf("%-20s", by->method);
  if (isnan(paper))
    printf("  %6s  %6s", "-", "-");
  else
    printf("  %6.2f  %6.2f", paper, paper / rows[0].paper[scene]);
  printf("  %7.2f  %6.2f  %6.2f  %6.2f  %6.2f  %7d  %7d  %9d  %8.1e  %8.1e  %8.1e", r->cpu,
         r->cpu / all[0].cpu, d->cpu.assembly, d->cpu.reduction, d->cpu.contact, d->count.newton,
         d->count.frames, d->count.iterations, r->force, r->displacement, d->worst_residual);
  if (is_marked(scene, all, k)) fputs("  *", stdout);
  print_end(r);
}

/* Prints a remark on each pair of the paper's methods whose order by CPU is another one here: in
 * which part most of the difference lies, and of which parts it consists. */
static void print_order(int scene, const result *r) {
  int same = 1;
  for (int a = 0; a < ROWS; a++)
    for (int b = 0; b < ROWS; b++) {
      if (!is_turned(scene, r, a, b)) continue;
      const dls_forming_data *x = &r[a].data, *y = &r[b].data;
      const double assembly = x->cpu.assembly - y->cpu.assembly;
      const double reduction = x->cpu.reduction - y->cpu.reduction;
      const double contact = x->cpu.contact - y->cpu.contact;
      const char *most = reduction >= fmax(assembly, contact) ? "factorisation and condensation"
                         : assembly >= contact                ? "assembly"
                                                              : "the method";
      same = 0;
      printf("* The paper has %s before %s. Here %s takes %.2f s more, most of it in\n"
             "  %s: assembly %+.2f, factorisation and condensation %+.2f, method %+.2f;\n"
             "  Newton steps %+d, condensations of K to W %+d.\n",
             rows[a].method, rows[b].method, rows[a].method, r[a].cpu - r[b].cpu, most, assembly,
             reduction, contact, x->count.newton - y->count.newton,
             x->count.reductions - y->count.reductions);
    }
  if (same) puts("The order of the paper's four methods by CPU is the paper's.");
}

static void print_json_order(int scene, const result *r) {
  const char *comma = "";
  fputs("],\n     \"order_differs\": [", stdout);
  for (int a = 0; a < ROWS; a++)
    for (int b = 0; b < ROWS; b++) {
      if (!is_turned(scene, r, a, b)) continue;
      printf("%s{\"paper_first\": \"%s\", \"here_first\": \"%s\"}", comma, rows[a].method,
             rows[b].method);
      comma = ", ";
    }
  fputs("]}", stdout);
}

static int run_table(int scene, int json, int *stopped) {
  const char *name = dls_forming_name(scene);
  history h = {0};
  result r[ROWS] = {{0}};
  int good = 1;
  if (json)
    printf("%s\n    {\"table\": %d, \"scene\": \"%s\", \"rows\": [", scene ? "," : "", scene + 2,
           name);
  else
    tell(
        "Table %d of the paper: %s. The paper: minutes, and ratio to Lemke. Here: seconds of CPU,\n"
        "ratio to Lemke, of which assembly, factorisation and condensation, method; counts; "
        "largest\n"
        "difference of nodal contact forces and of displacements from Lemke's in any step, over "
        "the\n"
        "largest of the step; worst certificate. Tolerance 1e-9, Gauss-Seidel 1e-10.\n\n"
        "%-20s  %6s  %6s  %7s  %6s  %6s  %6s  %6s  %7s  %7s  %9s  %8s  %8s  %8s\n",
        scene + 2, name, "method", "paper", "ratio", "CPU", "ratio", "assem", "factor", "method",
        "Newton", "frames", "iterations", "force", "displ", "residual");
  const char *comma = "";
  for (int k = 0; good && k < ROWS; k++) {
    good = run_method(name, &rows[k], 0, &h, &r[k]);
    if (!r[k].present) continue;
    *stopped |= !r[k].done;
    if (json)
      print_json_result(comma, &rows[k], &r[k]), putchar('}');
    else if (!is_quiet())
      print_result(scene, r, k);
    comma = ",";
  }
  free(h.values);
  if (json) {
    print_json_order(scene, r);
  } else if (good && !is_quiet()) {
    putchar('\n');
    print_order(scene, r);
    putchar('\n');
  }
  return good;
}

/* ---- section 6 ------------------------------------------------------------------------------- */

static const row study[] = {
    {"lemke", {NAN, NAN}, 1e-9, 0, 0, 0, 0},
    {"penalty", {NAN, NAN}, 1e-9, 10, 0, 0, 0},
    {"penalty", {NAN, NAN}, 1e-9, 100, 0, 0, 0},
    {"penalty", {NAN, NAN}, 1e-9, 1000, 0, 0, 0},
    {"penalty", {NAN, NAN}, 1e-9, 10000, 0, 0, 0},
    {"augmented-lagrangian", {NAN, NAN}, 1e-9, 10, 0, 1, 0},
    {"augmented-lagrangian", {NAN, NAN}, 1e-9, 10, 0, 5, 0},
    {"augmented-lagrangian", {NAN, NAN}, 1e-9, 10, 0, 0, 0},
    {"augmented-lagrangian", {NAN, NAN}, 1e-9, 100, 0, 1, 0},
    {"augmented-lagrangian", {NAN, NAN}, 1e-9, 100, 0, 5, 0},
    {"augmented-lagrangian", {NAN, NAN}, 1e-9, 100, 0, 0, 0},
    {"gauss-seidel", {NAN, NAN}, 1e-10, 0, 1, 0, 1},
    {"gauss-seidel", {NAN, NAN}, 1e-10, 0, 1.5, 0, 1},
    {"gauss-seidel", {NAN, NAN}, 1e-10, 0, 1.8, 0, 1},
    {"gauss-seidel", {NAN, NAN}, 1e-10, 0, 1, 0, 0},
    {"gauss-seidel", {NAN, NAN}, 1e-10, 0, 1.5, 0, 0},
};

/* A run is given up past so many times Lemke's CPU: the compromise is settled by then. */
static const double study_patience = 10;

/* Prints section 6 of the paper: what penalty factor, augmentations, relaxation and Aitken's
 * acceleration give and take, force error against CPU. */
static int run_study(int scene, int json, int *stopped) {
  const char *name = dls_forming_name(scene);
  history h = {0};
  double lemke = 0;
  int good = 1;
  (void)stopped; /* runs are given up on purpose */
  if (json)
    printf("%s\n    {\"scene\": \"%s\", \"rows\": [", scene ? "," : "", name);
  else
    tell(
        "%s: augmentations a step at most (0: as many as it takes), largest difference of nodal\n"
        "contact forces from Lemke's in any step over the largest of the step, CPU over Lemke's. A "
        "run\nis given up past %g times Lemke's CPU.\n\n"
        "%-20s  %7s  %5s  %5s  %6s  %8s  %8s  %7s  %10s\n",
        name, study_patience, "method", "penalty", "augm", "relax", "Aitken", "force", "CPU",
        "ratio", "iterations");
  const char *comma = "";
  for (size_t k = 0; good && k < sizeof study / sizeof study[0]; k++) {
    const row *s = &study[k];
    result r;
    good = run_method(name, s, study_patience * lemke, &h, &r);
    if (!r.present) continue;
    if (k == 0) lemke = r.cpu;
    if (json) {
      print_json_result(comma, s, &r), putchar('}');
    } else if (!is_quiet()) {
      printf("%-20s  %7g  %5d  %5g  %6s  %8.1e  %8.2f  %7.2f  %10d", s->method, s->penalty,
             s->augmentations, s->relaxation, s->relaxation > 0 ? (s->plain ? "no" : "yes") : "-",
             r.force, r.cpu, r.cpu / lemke, r.data.count.iterations);
      print_end(&r);
      (void)fflush(stdout);
    }
    comma = ",";
  }
  if (json)
    fputs("]}", stdout);
  else
    tell("\n");
  free(h.values);
  return good;
}

/* ---- the command ----------------------------------------------------------------------------- */

typedef struct tables_options {
  int study, json;
} tables_options;

static void tables_usage(FILE *out) {
  fputs("Usage: delassus tables [--study] [--json]\n"
        "Runs both forming scenes of Chabrand, Dubois and Raous (1998) by each method and\n"
        "prints our figures beside their Tables 2 and 3.\n"
        "\n"
        "      --study           section 6: error of the forces against CPU, for penalty factors,\n"
        "                        augmentations, relaxation, Aitken\n" LAST_USAGE "\n"
        "Exit status: 0, 1 if a run of the tables stops before its end, 2 bad input.\n",
        out);
}

int command_tables(int argc, char **argv) {
  static const option_row options[] = {ROW(A_FLAG, "study", 0, tables_options, study),
                                       LAST_OPTIONS};
  static const command tables = {options, tables_usage, NULL, 0};
  tables_options o = {0};
  const int stop = take_options(argc, argv, &tables, &o);
  if (stop != GO_ON) return stop;
  if (optind < argc) return wrong_names(argv[0]);
  o.json = is_json();
  watch_interrupt();
  int good = 1, stopped = 0;
  if (o.json) printf("{\n  \"%s\": [", o.study ? "studies" : "tables");
  for (int scene = 0; good && scene < 2; scene++)
    good = (o.study ? run_study : run_table)(scene, o.json, &stopped);
  if (o.json) puts("\n  ]\n}");
  const int ended = good && !stopped ? EXIT_SOLVED : EXIT_NOT_SOLVED;
  if (o.json) return ended;
  if (good && !o.study)
    tell(
        "Why: with ten or twenty candidates the method's own share is small, and the assembly for "
        "each\n"
        "Newton step is the same for all. On W, a factorisation and a solve for each of its "
        "columns\n"
        "come on top. Springs save these columns, and so does auto, which is Newton's method on K\n"
        "here: both factorise once for each guess of what sticks and slips. Augmentations cost\n"
        "assemblies and factorisations of their own; the penalty method has but one, and the "
        "error\n"
        "that the table shows.\n");
  return end_command(ended, "a run stops before its end");
}
