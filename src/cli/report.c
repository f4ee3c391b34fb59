/*
 * report.c: delassus report NAME...: one page each that answers how accurate, how fast and how
 * stable, and what is enough.
 *
 *   1  the verdict: what to take
 *   2  the error budget, and the cheapest setting that is accurate enough (report_budget.c)
 *   3  speed against accuracy: chart          4  stability: map
 *   5  bodies that move: energy               6  contacts
 *   7  the commands that draw each part again
 */
#define _GNU_SOURCE
#include <getopt.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "matrices.h"
#include "report.h"

enum { KEY_TEXT = KEY_ON + 1, KEY_QUICK, KEY_CPU, SLUG = 80 };

/* Parts of the CPU: the budget, and each of chart and map. */
static const double budget_share = 0.55, part_share = 0.2;
static const double own_accuracy = 1e-2, own_cpu = 60, quick_cpu = 6;

typedef struct report_options {
  double accuracy, cpu; /* cpu: seconds for a page; 0: own_cpu, quick_cpu */
  int text, quick;
  const char *out;
  matrix_options matrices;
} report_options;

static void report_usage(FILE *out) {
  fputs("Usage: delassus report [OPTION]... FILE|SCENE...\n"
        "  or:  delassus report --stiffness=K --HN=N --HT=T --f=F --mu=MU [OPTION]...\n"
        "Writes a page (HTML) for each name: what to take for a wanted accuracy, how far mesh,\n"
        "steps and tolerance move the answer, speed against accuracy, where methods fail, energy,\n"
        "contacts, and the commands that draw each part again. The page needs no network.\n"
        "\n"
        "      --accuracy=E      wanted relative accuracy of the scene's answer (0.01)\n"
        "      --cpu=S           approximate CPU seconds for a page (60; --quick 6)\n"
        "      --quick           the verdict, the error budget and the contacts only\n"
        "      --text            print the page as text, too\n"
        "  -o, --out=DIR         folder for the pages (a new one under TMPDIR, which is printed)\n"
        "\n",
        out);
  matrices_usage(out);
  fputs("\n" LAST_USAGE "\n"
        "Exit status: 0, 1 if no setting is proved or measured to be accurate enough, 2 bad "
        "input.\n",
        out);
}

/* A page while it is made. */
typedef struct report {
  const report_options *options;
  page page;
  parts parts;
  char slug[SLUG], file[SLUG + 8], folder[PATH_ROOM], verdict[PAGE_SENTENCE];
} report;

static int printed; /* pages in the object of --json */

/* Prints a page as a field of the object. */
static void print_page(const report *a, int met) {
  if (!is_json()) return;
  if (!printed++) fputs("{\n  \"command\": \"report\"", stdout);
  fputs(",\n  ", stdout);
  print_json_string(stdout, a->file);
  fputs(": {\"name\": ", stdout);
  print_json_string(stdout, a->parts.name);
  printf(", \"met\": %s, \"verdict\": ", met ? "true" : "false");
  print_json_string(stdout, a->verdict);
  fputs("}", stdout);
}

/* Makes a file's name of any name: letters, digits, points and dashes stay. */
static void make_slug(const char *name, int number, char slug[SLUG]) {
  char base[SLUG - 16];
  shorten(name, base, sizeof base);
  for (char *c = base; *c; c++)
    if (!strchr("abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789.-_", *c)) *c = '_';
  if (base[0] == '.' || base[0] == '-') base[0] = '_';
  if (number > 1)
    (void)snprintf(slug, SLUG, "%s-%d", base, number);
  else
    (void)snprintf(slug, SLUG, "%s", base);
}

/* Begins the page with its verdict; returns 0 after a complaint. */
static int begin_page(report *a, const char *directory) {
  const report_options *o = a->options;
  char title[200], options[80];
  (void)snprintf(options, sizeof options, "--accuracy=%g --cpu=%g%s", o->accuracy, o->cpu,
                 o->quick ? " --quick" : "");
  part_note(&a->parts, options);
  (void)snprintf(title, sizeof title, "%.150s", a->parts.name);
  if (!page_open(&a->page, directory, a->file, title, o->text && !is_json())) return 0;
  page_say(&a->page, PAGE_LEAD, "%s.", a->verdict);
  return 1;
}

/* Adds the sections of other commands; contact: NULL for a scene in steps. */
static void add_parts(report *a, const dls_contact *contact) {
  if (a->options->quick) return;
  if (contact) part_speed(&a->parts);
  page_say(&a->page, PAGE_SECTION, "Stability");
  part_stability(&a->parts, contact);
}

/* Adds the end; returns the exit status. */
static int end_page(report *a, const char *directory, int met) {
  if (a->page.pictures == 0 && !a->options->quick) {
    page_say(&a->page, PAGE_NOTE, "No pictures: install gnuplot (Debian: gnuplot-nox).");
    if (!a->parts.scene) (void)complain("no pictures; install gnuplot (Debian: gnuplot-nox)");
  }
  page_say(&a->page, PAGE_SECTION, "Commands");
  part_commands(&a->parts);
  if (!page_close(&a->page, a->file)) return EXIT_BAD_INPUT;
  print_page(a, met);
  if (!a->page.text) tell("%s: %s.\n", quote(AS_SHOWN, a->parts.name).text, a->verdict);
  tell("page: %s/%s\n", quote(AS_SHOWN, directory).text, a->file);
  return met ? EXIT_SOLVED : EXIT_NOT_SOLVED;
}

/* ---- a scene --------------------------------------------------------------------------------- */

static int report_scene(report *a, const scene *s, const char *directory) {
  const report_options *o = a->options;
  budget *b = calloc(1, sizeof *b);
  named subject = {0};
  dls_error error = {.status = DLS_E_MEMORY, .message = "out of memory"};
  int result = EXIT_BAD_INPUT;
  if (!b) return complain_of(s->name, &error);
  *b = (budget){.scene = s, .accuracy = o->accuracy, .limit = budget_share * o->cpu};
  if (budget_run(b, &error) || b->take < 0) {
    if (!was_interrupted()) (void)complain_of(s->name, &error);
    free(b);
    return was_interrupted() ? EXIT_NOT_SOLVED : EXIT_BAD_INPUT;
  }
  budget_verdict(b, a->verdict, sizeof a->verdict);
  a->parts.scene = s;
  a->parts.take = &b->probe[b->take].at;
  const int equilibrium = s->kind == KIND_EQUILIBRIUM;
  dls_status status = equilibrium ? named_load(s->name, &subject, &error) : DLS_OK;
  if (status)
    (void)complain_of(s->name, &error);
  else if (make_directory(a->folder) && begin_page(a, directory)) {
    page_say(&a->page, PAGE_SECTION, "Error budget");
    budget_tables(b, &a->page);
    page_say(&a->page, PAGE_SECTION, "Speed against accuracy");
    if (budget_picture(b, a->folder))
      (void)page_picture(&a->page, a->folder, "budget.svg",
                         "What each part costs and brings: the error that it leaves against CPU");
    add_parts(a, equilibrium ? &subject.contact : NULL);
    part_run(&a->parts, &b->probe[b->take].got);
    result = end_page(a, directory, b->met);
  }
  named_free(&subject);
  free(b);
  return result;
}

/* ---- a file, or matrices --------------------------------------------------------------------- */

static int report_contact(report *a, const dls_contact *contact, const char *directory) {
  const report_options *o = a->options;
  file_budget b = {.contact = contact, .accuracy = o->accuracy, .limit = budget_share * o->cpu};
  dls_error error = {.status = DLS_E_MEMORY, .message = "out of memory"};
  int result = EXIT_BAD_INPUT;
  if (file_budget_run(&b, &error))
    (void)complain_of(a->parts.name, &error);
  else if (file_verdict(&b, a->verdict, sizeof a->verdict), make_directory(a->folder)) {
    if (begin_page(a, directory)) {
      page_say(&a->page, PAGE_SECTION, "Error budget");
      file_tables(&b, &a->page);
      page_say(&a->page, PAGE_SECTION, "Speed against accuracy");
      add_parts(a, contact);
      page_say(&a->page, PAGE_SECTION, "Contacts");
      file_contacts(&b, &a->page);
      result = end_page(a, directory, b.take >= 0);
    }
  }
  file_budget_free(&b);
  return result;
}

/* Writes the condensed problem of matrices as a file that chart and map read. */
static int save_problem(report *a, const problem *p, char path[PATH_ROOM]) {
  dls_error error = {0};
  if (!make_directory(a->folder) || !join_path(path, a->folder, "problem.hdf5")) return 0;
  if (!dls_fclib_write_local(path, &p->contact, a->slug, NULL, NULL, &error)) return 1;
  (void)complain_of(path, &error);
  return 0;
}

static int report_matrices(report *a, const char *directory) {
  matrix_options m = a->options->matrices;
  problem p = {0};
  char path[PATH_ROOM];
  int result = EXIT_BAD_INPUT;
  m.on = DLS_ON_W; /* the proofs, chart and map take W */
  if (matrices_load(&m, &p) && save_problem(a, &p, path)) {
    problem_fit_threads(&p);
    a->parts.name = path;
    result = report_contact(a, &p.contact, directory);
  }
  problem_free(&p);
  return result;
}

static int report_file(report *a, const char *directory) {
  named subject = {0};
  dls_error error = {0};
  int result;
  if (named_load(a->parts.name, &subject, &error))
    result = complain_of(a->parts.name, &error);
  else
    result = report_contact(a, &subject.contact, directory);
  named_free(&subject);
  return result;
}

/* ---- the command ----------------------------------------------------------------------------- */

/* Makes the page of a name; number: of names so far that make the same file name. */
static int report_name(const char *name, int number, const report_options *o,
                       const char *directory) {
  report *a = calloc(1, sizeof *a);
  scene s;
  dls_error error = {0};
  dls_status status = DLS_OK;
  int result;
  if (!a) return complain("%s: out of memory", name);
  a->options = o;
  make_slug(name, number, a->slug);
  (void)snprintf(a->file, sizeof a->file, "%s.html", a->slug);
  a->parts.page = &a->page;
  a->parts.name = name;
  a->parts.folder = a->folder;
  a->parts.cpu = part_share * o->cpu;
  if (!join_path(a->folder, directory, a->slug))
    result = EXIT_BAD_INPUT;
  else if (matrices_given(&o->matrices))
    result = report_matrices(a, directory);
  else if (scene_find(name, &s, &status, &error))
    result = status ? complain_of(name, &error) : report_scene(a, &s, directory);
  else
    result = report_file(a, directory);
  free(a);
  return result;
}

static taken take_report_option(int key, const char *text, void *data) {
  report_options *o = data;
  const taken matrix = take_matrix_option(key, text, &o->matrices);
  if (matrix != OPTION_UNKNOWN) return matrix;
  switch (key) {
  case 'a':
    if (!parse_number("accuracy", text, &o->accuracy)) return OPTION_WRONG;
    if (o->accuracy > 0 && o->accuracy < 1) return OPTION_TAKEN;
    return complain("--accuracy: '%s' is not between 0 and 1", text), OPTION_WRONG;
  case KEY_CPU:
    return parse_number("cpu", text, &o->cpu);
  case KEY_TEXT:
    o->text = 1;
    return OPTION_TAKEN;
  case KEY_QUICK:
    o->quick = 1;
    return OPTION_TAKEN;
  case 'o':
    o->out = text;
    return OPTION_TAKEN;
  default:
    return OPTION_UNKNOWN;
  }
}

/* Counts the names before k that make the same file name as that of k, and k. */
static int count_alike(char **names, int k) {
  char own[SLUG], other[SLUG];
  int count = 1;
  make_slug(names[k], 1, own);
  for (int i = 0; i < k; i++) {
    make_slug(names[i], 1, other);
    count += !strcmp(own, other);
  }
  return count;
}

int command_report(int argc, char **argv) {
  static const struct option options[] = {VALUE("accuracy", 'a'),
                                          VALUE("cpu", KEY_CPU),
                                          FLAG("quick", KEY_QUICK),
                                          FLAG("text", KEY_TEXT),
                                          VALUE("out", 'o'),
                                          MATRIX_OPTIONS,
                                          LAST_OPTIONS};
  static const command report_command = {"o:", options, report_usage, take_report_option, 0};
  report_options o = {.accuracy = own_accuracy};
  const int stop = take_options(argc, argv, &report_command, &o);
  if (stop != GO_ON) return stop;
  const char *matrix = matrices_name(&o.matrices);
  int count = argc - optind;
  char **names = argv + optind;
  char *single[] = {(char *)(size_t)matrix};
  if (matrices_given(&o.matrices) ? count != 0 || !matrix : count == 0) return wrong_names(argv[0]);
  if (matrix) {
    names = single;
    count = 1;
  } else {
    count = leave_lcps(count, names);
  }
  if (count == 0) return EXIT_SOLVED;
  if (o.cpu <= 0) o.cpu = o.quick ? quick_cpu : own_cpu;
  watch_interrupt();
  const char *directory = take_folder(o.out, "report", NULL);
  if (!directory) return EXIT_BAD_INPUT;
  int result = EXIT_SOLVED;
  for (int k = 0; k < count && result != EXIT_BAD_INPUT && !was_interrupted(); k++) {
    const int one = report_name(names[k], count_alike(names, k), &o, directory);
    if (one > result) result = one;
  }
  if (printed) {
    printf(",\n  \"status\": \"%s\",\n  \"directory\": ", result == EXIT_SOLVED ? "solved"
                                                          : result == EXIT_BAD_INPUT
                                                              ? "error"
                                                              : "not_solved");
    print_json_string(stdout, directory);
    puts("\n}");
  }
  return end_command(result, "no setting is measured to be accurate enough");
}
