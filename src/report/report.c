/*
 * report.c: delassus report NAME...: one page each that answers how accurate, how fast and how
 * stable, and what is enough.
 *
 *   1  the first screen: what to take, accuracy, speed, stability, uniqueness, the command
 *   2  the error budget, and the cheapest setting that is accurate enough (report_budget.c)
 *   3  speed against accuracy: chart          4  stability: map
 *   5  bodies that move: energy               6  contacts
 *   7  the commands that draw each part again
 */
#define _GNU_SOURCE
#include <stdlib.h>
#include <string.h>

#include "problem/matrices.h"
#include "report.h"

enum { SLUG = 80 };

/* Parts of the CPU: the budget, and each of chart and map. */
static const double budget_share = 0.55, quick_share = 0.95, part_share = 0.2;
static const double own_accuracy = 1e-2, own_cpu = 60, quick_cpu = 20;

typedef struct report_options {
  double accuracy, cpu; /* cpu: seconds for a page; 0: own_cpu, quick_cpu */
  const char *of;       /* NULL: force,curve */
  int asked;            /* the same as bits */
  int text, quick, data;
  const char *out;
  source from;
} report_options;

static void report_usage(FILE *out) {
  fputs(
      "Usage: delassus report [OPTION]... FILE|SCENE...\n"
      "  or:  delassus report [OPTION]... --W=W --q=Q --mu=MU (or --stiffness=K ...)\n"
      "Writes a page (HTML) for each name: what to take for a wanted accuracy, how far mesh,\n"
      "steps and tolerance move the answer, speed against accuracy, where methods fail, energy,\n"
      "contacts, and the commands that draw each part again. The page needs no network.\n"
      "\n"
      "      --accuracy=E      wanted relative accuracy of the scene's answer (0.01)\n"
      "      --of=LIST         what is to be accurate: force (at the end; or the impulse, the "
      "work),\n"
      "                        curve (over the steps), pressure, edge (of contact), slip (zone),\n"
      "                        drift (of energy); force,curve\n"
      "      --cpu=S           approximate CPU seconds for a page (60; --quick 20)\n"
      "      --quick           the verdict, the error budget and the contacts only\n"
      "      --data            keep all files of a scene (else 20 MB: the largest ones go)\n"
      "      --text            print the page as text, too\n"
      "  -o, --out=DIR         folder for the pages (a new one under TMPDIR, which is "
      "printed)\n" LAST_USAGE "\n"
      "Exit status: 0, 1 if there is no answer, 2 bad input.\n\n",
      out);
  source_usage(out);
}

/* Returns the bits of a list of quantities, 0 if it is none. */
static int take_asked(const char *list) {
  int bits = 0;
  for (;;) {
    const size_t length = strcspn(list, ",");
    int of = 0;
    while (of < OF_COUNT &&
           (strlen(quantity_names[of]) != length || strncmp(list, quantity_names[of], length) != 0))
      of++;
    if (of == OF_COUNT) return 0;
    bits |= 1 << of;
    if (!list[length]) return bits;
    list += length + 1;
  }
}

/* A page while it is made. */
typedef struct report {
  const report_options *options;
  const char *shown; /* the name that was given */
  page page;
  parts parts;
  const budget *budget;     /* of a scene, or NULL */
  const file_budget *rungs; /* of a file, or NULL */
  char slug[SLUG], file[SLUG + 8], folder[PATH_ROOM], verdict[PAGE_SENTENCE];
} report;

static int printed; /* pages in the object of --json */

/* Prints the numbers of the first screen. */
static void print_budget(const budget *b) {
  char options[SETTING_ROOM];
  const probe *take = &b->probe[b->take];
  printf(", \"options\": ");
  print_json_string(stdout, setting_text(b->scene, &take->at, 1, options));
  printf(", \"cpu_seconds\": %.6g", take->got.seconds);
  print_json_field(stdout, "answer", take->got.value);
  print_json_field(stdout, "reference", b->reference);
  for (quantity_of of = OF_FORCE; of < OF_COUNT; of++) {
    if (!(b->scene->has >> of & 1)) continue;
    printf(", \"%s\": {\"asked\": %s, \"error\": ", quantity_names[of],
           b->of >> of & 1 ? "true" : "false");
    print_json_number(stdout, budget_within(b, b->take, of));
    fputs(", \"reference_error\": ", stdout);
    print_json_number(stdout, of == OF_DRIFT ? (double)NAN : b->doubt[of]);
    putchar('}');
  }
}

/* Prints a page as a field of the object. */
static void print_page(const report *a, int met) {
  if (!is_json()) return;
  if (!printed++) fputs("{\n  \"command\": \"report\"", stdout);
  fputs(",\n  ", stdout);
  print_json_string(stdout, a->file);
  fputs(": {\"name\": ", stdout);
  print_json_string(stdout, a->shown);
  printf(", \"met\": %s, \"verdict\": ", met ? "true" : "false");
  print_json_string(stdout, a->verdict);
  if (a->budget) print_budget(a->budget);
  if (a->rungs && a->rungs->take >= 0)
    printf(", \"proved\": %s, \"tol\": %g, \"error\": %.6g, \"cpu_seconds\": %.6g",
           a->rungs->proof.kind ? "true" : "false", a->rungs->tol[a->rungs->take],
           a->rungs->error[a->rungs->take], a->rungs->seconds[a->rungs->take]);
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
  char title[200], options[120];
  (void)snprintf(options, sizeof options, "--accuracy=%g --cpu=%g%s%s%s", o->accuracy, o->cpu,
                 o->quick ? " --quick" : "", o->of ? " --of=" : "", o->of ? o->of : "");
  part_note(&a->parts, "report", options);
  (void)snprintf(title, sizeof title, "%.150s", a->shown);
  if (!page_open(&a->page, directory, a->file, title, o->text && !is_json())) return 0;
  if (a->parts.scene) page_say(&a->page, PAGE_PLAIN, "%s.", a->parts.scene->says);
  page_say(&a->page, PAGE_LEAD, "%s.", a->verdict);
  return 1;
}

/* Adds the sections of other commands. of: the problem that all methods solve. */
static void add_parts(report *a, const char *of) {
  progress_task(a->shown, a->options->cpu, a->options->quick ? quick_share : budget_share);
  if (a->options->quick) return;
  part_speed(&a->parts, a->options->from.step, of);
  progress_task(a->shown, a->options->cpu, budget_share + part_share);
  page_say(&a->page, PAGE_SECTION, "Stability");
  part_stability(&a->parts);
}

/* Adds the end; returns the exit status. met: within the accuracy; solved: there is an answer. */
static int end_page(report *a, const char *directory, int met, int solved) {
  if (a->page.pictures == 0 && !a->options->quick) {
    page_say(&a->page, PAGE_NOTE, "No pictures: install gnuplot (Debian: gnuplot-nox).");
    if (!a->parts.scene) (void)complain("no pictures; install gnuplot (Debian: gnuplot-nox)");
  }
  page_say(&a->page, PAGE_SECTION, "Commands");
  part_commands(&a->parts);
  if (!page_close(&a->page, a->file)) return EXIT_BAD_INPUT;
  print_page(a, met);
  if (!a->page.text) tell("%s: %s.\n", quote(AS_SHOWN, a->shown).text, a->verdict);
  tell("page: %s/%s\n", quote(AS_SHOWN, directory).text, a->file);
  return solved ? EXIT_SOLVED : EXIT_NOT_SOLVED;
}

/* ---- a scene --------------------------------------------------------------------------------- */

/* The rest of the first screen. p: the contact problem, of one step where there are several. */
static void first_screen(report *a, const budget *b, const problem *p) {
  const probe *take = &b->probe[b->take];
  const int reduces = !take->got.status && take->got.reduction > 0;
  char options[SETTING_ROOM];
  budget_accuracy(b, &a->page);
  page_say(&a->page, PAGE_PLAIN, "Speed: %s of CPU, %s%s.", in_words(take->got.seconds).text,
           reduces ? in_words(take->got.reduction).text : "",
           take->got.status ? "up to there"
           : reduces        ? " of these to reduce K to W"
                            : "all steps");
  if (take->got.status)
    page_say(&a->page, PAGE_PLAIN, "Stability: it stops after %.0f %% of the steps.",
             100 * take->got.part);
  else if (b->scene->kind == SCENE_MOVING)
    page_say(&a->page, PAGE_PLAIN,
             "Stability: it finishes; the energy balance of the worst step is off by %.1e %%.",
             100 * take->got.drift);
  else
    page_say(&a->page, PAGE_PLAIN, "Stability: it finishes, each contact problem solved to %.0e.",
             take->at.tol);
  if (p->contact.nc)
    part_uniqueness(&a->parts, &p->contact);
  else
    page_say(&a->page, PAGE_PLAIN, "Uniqueness: unknown%s.",
             b->scene->own.upper ? "; a free body has no W" : "; without --quick it is computed");
  page_say(&a->page, PAGE_PLAIN, "Method: auto.");
  part_note(&a->parts, "scene", setting_text(b->scene, &take->at, 1, options));
  part_command(&a->parts);
}

static void add_scene(report *a, const budget *b, const problem *p) {
  first_screen(a, b, p);
  page_say(&a->page, PAGE_SECTION, "Error budget");
  budget_tables(b, &a->page);
  page_say(&a->page, PAGE_SECTION, "Speed against accuracy");
  if (budget_picture(b, a->folder))
    (void)page_picture(&a->page, a->folder, "budget.svg",
                       "Error left by each part of the setting, against CPU");
  add_parts(a, *p->note ? p->note : "the contact problem of the scene as it is");
  part_run(&a->parts, &b->probe[b->take].got);
  if (!a->options->data) part_trim(&a->parts);
}

static int report_scene(report *a, const scene *s, const char *directory) {
  const report_options *o = a->options;
  budget *b = calloc(1, sizeof *b);
  problem p = {0};
  dls_error error = {.status = DLS_E_MEMORY, .message = "out of memory"};
  int result = EXIT_BAD_INPUT;
  if (!b) return complain_of(s->name, &error);
  *b = (budget){.scene = s,
                .accuracy = o->accuracy,
                .of = o->asked,
                .limit = (o->quick ? quick_share : budget_share) * o->cpu};
  if (o->asked && !(o->asked & s->has)) {
    (void)complain("%s: --of: it has none of '%s'", s->name, o->of);
    free(b);
    return result;
  }
  if (budget_run(b, &error) || b->take < 0) {
    result = was_interrupted() ? EXIT_NOT_SOLVED : complain_of(s->name, &error);
    free(b);
    return result;
  }
  budget_verdict(b, a->verdict, sizeof a->verdict);
  a->budget = b;
  a->parts.scene = s;
  a->parts.take = &b->probe[b->take].at;
  const int no_problem = (o->quick && s->kind != SCENE_AT_ONCE) || s->own.upper; /* no run; no W */
  if ((no_problem || problem_open(s->name, &o->from, &p)) && make_directory(a->folder) &&
      begin_page(a, directory)) {
    add_scene(a, b, &p);
    result = end_page(a, directory, b->met, !b->probe[b->take].got.status);
  }
  problem_free(&p);
  free(b);
  return result;
}

/* ---- a file, or matrices --------------------------------------------------------------------- */

/* Adds the sums of the reactions and, with coordinates, a picture of the surface. */
static void add_surface(report *a, const file_budget *b, const problem *p) {
  char *text = NULL, *next;
  size_t size;
  FILE *file = b->best >= 0 ? open_memstream(&text, &size) : NULL;
  if (!file) return;
  const int good = put_reactions(file, p, b->r);
  if (fclose(file) == 0 && good)
    for (char *line = strtok_r(text, "\n", &next); line; line = strtok_r(NULL, "\n", &next))
      page_say(&a->page, PAGE_NOTE, "%s.", line + strspn(line, " "));
  free(text);
  if (picture_surface(a->folder, p, b->state, b->r))
    (void)page_picture(&a->page, a->folder, "surface.svg", "Reactions and states over the surface");
}

/* Adds the budget and the rest of the page. */
static int add_contact(report *a, const problem *p, const char *directory) {
  const dls_contact *contact = &p->contact;
  char options[40];
  const report_options *o = a->options;
  file_budget *b = calloc(1, sizeof *b); /* 35 kB, and the solves take 50 kB of the stack */
  dls_error error = {.status = DLS_E_MEMORY, .message = "out of memory"};
  int result = EXIT_BAD_INPUT;
  if (!b) return complain("%s: out of memory", a->shown);
  b->contact = contact;
  b->accuracy = o->accuracy;
  b->limit = (o->quick ? quick_share : budget_share) * o->cpu;
  if (file_budget_run(b, &error)) {
    (void)complain_of(a->parts.name, &error);
  } else {
    file_verdict(b, a->verdict, sizeof a->verdict);
    a->rungs = b;
    if (begin_page(a, directory)) {
      if (p->reduction_cpu_seconds > 0)
        page_say(&a->page, PAGE_PLAIN, "Speed: %s of CPU besides, to reduce K to W.",
                 in_words(p->reduction_cpu_seconds).text);
      if (b->best >= 0)
        page_say(&a->page, PAGE_PLAIN, "Stability: auto solves it to %.0e.", b->tol[b->best]);
      part_uniqueness(&a->parts, contact);
      if (b->take >= 0) {
        (void)snprintf(options, sizeof options, "--tol=%.0e", b->tol[b->take]);
        part_note(&a->parts, "solve", options);
        part_command(&a->parts);
      }
      page_say(&a->page, PAGE_SECTION, "Error budget");
      file_tables(b, &a->page);
      if (!o->quick) page_say(&a->page, PAGE_SECTION, "Speed against accuracy");
      add_parts(a, "the file's problem");
      page_say(&a->page, PAGE_SECTION, "Contacts");
      file_contacts(b, &a->page);
      add_surface(a, b, p);
      result = end_page(a, directory, b->take >= 0, b->best >= 0);
    }
  }
  file_budget_free(b);
  free(b);
  return result;
}

/* Writes the condensed problem of matrices as a file and takes it from there, as commands do. */
static int save_problem(report *a, problem *p, problem *saved, char path[PATH_ROOM]) {
  const source file = {0};
  dls_error error = {0};
  if (!join_path(path, a->folder, "problem.hdf5")) return 0;
  a->parts.name = path;
  if (dls_fclib_write_local(path, &p->contact, a->shown, NULL, NULL, &error))
    return complain_of(path, &error), 0;
  if (!problem_open(path, &file, saved)) return 0;
  p->contact = saved->contact;
  return 1;
}

static int report_contact(report *a, const char *directory) {
  problem p = {0}, saved = {0};
  char path[PATH_ROOM];
  int result = EXIT_BAD_INPUT;
  if (problem_open(a->shown, &a->options->from, &p) && make_directory(a->folder) &&
      (!p.matrices || save_problem(a, &p, &saved, path))) {
    problem_fit_threads(&p);
    result = add_contact(a, &p, directory);
  } else if (was_interrupted()) {
    result = EXIT_NOT_SOLVED;
  }
  problem_free(&p);
  problem_free(&saved);
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
  int result = EXIT_BAD_INPUT;
  if (!a) return complain("%s: out of memory", name);
  a->options = o;
  a->shown = name;
  make_slug(name, number, a->slug);
  (void)snprintf(a->file, sizeof a->file, "%s.html", a->slug);
  a->parts.page = &a->page;
  a->parts.name = name;
  a->parts.folder = a->folder;
  a->parts.cpu = part_share * o->cpu;
  progress_task(a->shown, o->cpu, 0);
  if (join_path(a->folder, directory, a->slug)) {
    if (matrices_given(&o->from.matrices) || !scene_find(name, &s, &status, &error))
      result = report_contact(a, directory);
    else
      result = status ? complain_of(name, &error) : report_scene(a, &s, directory);
  }
  progress_task(NULL, 0, 0);
  progress_end();
  free(a);
  return result;
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
  static const option_row options[] = {ROW(A_NUMBER, "accuracy", 0, report_options, accuracy),
                                       ROW(A_NUMBER, "cpu", 0, report_options, cpu),
                                       ROW(A_TEXT, "of", 0, report_options, of),
                                       ROW(A_FLAG, "quick", 0, report_options, quick),
                                       ROW(A_FLAG, "data", 0, report_options, data),
                                       ROW(A_FLAG, "text", 0, report_options, text),
                                       ROW(A_TEXT, "out", 'o', report_options, out),
                                       SOURCE_OPTIONS(report_options, from),
                                       LAST_OPTIONS};
  static const command report_command = {options, report_usage, NULL, 0};
  report_options o = {.accuracy = own_accuracy};
  const int stop = take_options(argc, argv, &report_command, &o);
  if (stop != GO_ON) return stop;
  if (!(o.accuracy > 0 && o.accuracy < 1))
    return complain("--accuracy: '%g' is not between 0 and 1", o.accuracy);
  if (o.of && !(o.asked = take_asked(o.of)))
    return complain("--of: '%s' is not a list of force, curve, pressure, edge, slip, drift", o.of);
  int count = argc - optind;
  char **names = source_names(&count, argv, &o.from);
  if (!names) return EXIT_BAD_INPUT;
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
    static const char *const words[] = {"solved", "not_solved", "error"}; /* by exit status */
    printf(",\n  \"status\": \"%s\",\n  \"directory\": ", words[result]);
    print_json_string(stdout, directory);
    puts("\n}");
  }
  return end_command(result, "there is no answer");
}
