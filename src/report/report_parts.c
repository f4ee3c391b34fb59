/*
 * report_parts.c: the parts of a page that other commands make: chart, map and scene run within
 * this one, into folders beside the page, which takes their tables and pictures in. Each command
 * line is printed at the end of the page, so that every part can be drawn again.
 */
#define _GNU_SOURCE
#include <dirent.h>
#include <math.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include "charts/chart.h"
#include "charts/map.h"
#include "report.h"

enum { MAP_OF_METHODS = 6, MAP_OF_STEPS = 4, STEP_CELLS = 24, METHODS = 13, MOST_TABLE = 40 };
static const double most_megabytes = 19; /* of a scene's files; with the other parts 20 */
enum { most_rows_of_facts = 1500, most_contacts_of_fold = 40 };

/* ---- commands -------------------------------------------------------------------------------- */

static void add_words(command_line *l, const char *words) {
  while (*words && l->count < MOST_WORDS) {
    const int length = (int)strcspn(words, " ");
    if (length) (void)snprintf(l->word[l->count++], PATH_ROOM, "%.*s", length, words);
    words += length + (words[length] == ' ');
  }
}

static void add_word(command_line *l, const char *before, const char *word) {
  if (l->count < MOST_WORDS)
    (void)snprintf(l->word[l->count++], PATH_ROOM, "%s%.*s", before, PATH_ROOM - 20, word);
}

/* Begins the command `what` with its options on the scene or file, its files in FOLDER/what. */
static void begin_line(command_line *l, const parts *a, const char *what, const char *options) {
  l->count = 0;
  add_words(l, what);
  add_words(l, options);
  if (strcmp(what, "solve") != 0) add_word(l, "--out=", what);
  if (a->name[0] == '-') add_word(l, "", "--");
  add_word(l, "", a->name);
}

/* Writes the command as a shell reads it: words with other characters in quotes. */
static void write_line(const command_line *l, char *text, size_t size) {
  size_t used = (size_t)snprintf(text, size, "delassus");
  for (int k = 0; k < l->count && used + 8 < size; k++) {
    const char *w = l->word[k];
    const int plain = w[strspn(w, "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789"
                                  "-_=./,:+")] == '\0';
    used += (size_t)snprintf(text + used, size - used, plain ? " " : " '");
    for (; *w && used + 8 < size; w++) /* ' ends the quotes, stands escaped, begins them again */
      used += (size_t)snprintf(text + used, size - used, *w == '\'' ? "'\\''" : "%c", *w);
    if (!plain) used += (size_t)snprintf(text + used, size - used, "'");
  }
}

/* Runs the command line, its files in FOLDER/what; returns its exit status. `why` (PATH_ROOM): what
 * it complained of. */
static int run_line(command_line *l, const parts *a, const char *what, int (*run)(int, char **),
                    char path[PATH_ROOM], char *why) {
  static char quiet[] = "--quiet";
  char out[PATH_ROOM + 8], *argv[MOST_WORDS + 2];
  int count = 0;
  why[0] = '\0';
  if (!join_path(path, a->folder, what)) return EXIT_BAD_INPUT;
  (void)snprintf(out, sizeof out, "--out=%s", path);
  for (int k = 0; k < l->count; k++) {
    argv[count++] = strncmp(l->word[k], "--out=", 6) ? l->word[k] : out;
    if (k == 0) argv[count++] = quiet;
  }
  argv[count] = NULL;
  progress_part(what);
  struct open_file *files = set_files_aside();
  const int result = run_command(run, argv, why);
  put_files_back(files);
  return result;
}

void part_note(parts *a, const char *what, const char *options) {
  begin_line(&a->line, a, what, options);
  if (a->commands < MOST_COMMANDS) write_line(&a->line, a->command[a->commands++], COMMAND_ROOM);
}

/* Runs a command for this page; says on the page why it did not work. Returns 1 if it did. */
static int make_part(parts *a, const char *what, const char *options, int (*run)(int, char **),
                     char path[PATH_ROOM]) {
  char why[PATH_ROOM];
  if (strcmp(what, "scene") != 0) /* is noted on the first screen */
    part_note(a, what, options);
  else
    begin_line(&a->line, a, what, options);
  if (run_line(&a->line, a, what, run, path, why) != EXIT_BAD_INPUT) return 1;
  page_say(a->page, PAGE_NOTE, "No %s: %.600s", what, *why ? why : "it failed");
  a->commands -= strcmp(what, "scene") != 0; /* it does not work alone, either */
  return 0;
}

/* ---- speed against accuracy ------------------------------------------------------------------ */

void part_speed(parts *a, int step, const char *of) {
  char path[PATH_ROOM], options[40], of_step[24] = "";
  if (step) (void)snprintf(of_step, sizeof of_step, " --step=%d", step);
  (void)snprintf(options, sizeof options, "--budget=%.2g --repeat=8%s", a->cpu, of_step);
  if (!make_part(a, "chart", options, command_chart, path)) return;
  (void)page_picture(a->page, path, "chart.svg",
                     "Every method: residual, cost, error and convergence");
  page_say(a->page, PAGE_PLAIN, "Every method to 1e-08 on %s:", of);
  (void)page_csv(a->page, path, "chart.csv",
                 "method,verdict,cpu_s,times_fastest,iterations,residual,error", "1e-08",
                 MOST_TABLE);
}

/* ---- stability ------------------------------------------------------------------------------- */

/* What the words of a map mean. */
static const struct {
  const char *word, *meaning;
} meanings[] = {{"solved", "an answer with a certificate; a scene: it finishes"},
                {"not decided", "a limit was met, and with ten times the limit, too: no verdict"},
                {"no progress", "it cycles, or the residual stands still"},
                {"ray", "Lemke's method stopped on a ray: a solution may or may not exist"},
                {"likely none", "jam: the reactions grow without bound, no solution is likely"},
                {"proved none", "no solution exists: proved"},
                {"mesh folded", "the mesh folds"},
                {"refused", "too large for the method, or not of its kind"}};
enum { MEANINGS = sizeof meanings / sizeof meanings[0] };

/* Counts the cells of map.csv by their verdict. */
static void count_cells(const parts *a, const char *path) {
  csv_table t;
  int count[MEANINGS] = {0};
  if (!csv_open(&t, path, "map.csv")) return;
  const int at = csv_column(&t, "verdict", strlen("verdict"));
  while (csv_next(&t))
    for (int k = 0; k < MEANINGS && at >= 0 && at < t.fields; k++)
      count[k] += !strcmp(t.field[at], meanings[k].word);
  page_table(a->page, "cells,verdict,meaning");
  for (int k = 0; k < MEANINGS; k++) {
    if (!count[k]) continue;
    page_cell(a->page, "%d", count[k]);
    page_cell(a->page, "%s", meanings[k].word);
    page_cell(a->page, "%s", meanings[k].meaning);
  }
  page_table_end(a->page);
}

enum { ANSWERS = 32, ANSWER_ROWS = 2 * DLS_STATES_MAX };

/* Returns words for the contact problem that stands for a scene in steps. */
static const char *where(const parts *a) {
  return a->scene && a->scene->kind != SCENE_AT_ONCE ? " of the contact problem of one step" : "";
}

/* Lists all answers of a small problem in 2D; returns 0 where that is not known. */
static int list_answers(const parts *a, const dls_contact *contact) {
  static const char *const count[] = {"no answer", "one answer", "two answers", "three answers"};
  static double r[3 * ANSWERS * ANSWER_ROWS];
  const int m = 2 * contact->nc, room = ANSWERS * ANSWER_ROWS;
  dls_solution_set set;
  char text[400] = "";
  size_t used = 0;
  if (contact->d != 2 || contact->nc > DLS_STATES_MAX) return 0;
  const dls_status status =
      dls_contact_enumerate(contact, 1e-8, ANSWERS, r, r + room, r + 2 * (size_t)room, &set, NULL);
  if (status != DLS_OK && status != DLS_NO_SOLUTION) return 0;
  for (int k = 0; k < set.isolated && k < ANSWERS && !set.continua && m <= 4; k++)
    for (int i = 0; i < m && used + 16 < sizeof text; i++)
      used += (size_t)snprintf(text + used, sizeof text - used, "%s%.4g",
                               i   ? " "
                               : k ? "; r = "
                                   : ": r = ",
                               r[k * m + i]);
  if (set.continua)
    page_say(a->page, PAGE_PLAIN, "Uniqueness%s: more than one answer, in %d connected set%s.",
             where(a), set.continua, plural(set.continua));
  else if (set.isolated < 4)
    page_say(a->page, PAGE_PLAIN, "Uniqueness%s: %s, proved%s.", where(a), count[set.isolated],
             text);
  else
    page_say(a->page, PAGE_PLAIN, "Uniqueness%s: %d answers, proved%s.", where(a), set.isolated,
             text);
  return 1;
}

void part_uniqueness(const parts *a, const dls_contact *contact) {
  const double own = largest_entry(contact->mu, contact->nc);
  dls_diagnosis facts = {0};
  dls_fold fold = {0};
  char below[80] = "", other[80] = "";
  if (list_answers(a, contact)) return;
  const int known = !dls_contact_diagnose(contact, most_rows_of_facts, &facts, NULL);
  const int folds = contact->nc <= (contact->d == 2 ? most_contacts_of_fold : DLS_STATES_MAX) &&
                    !dls_contact_fold(contact, &fold, NULL, NULL, NULL, NULL, NULL);
  if (known && facts.friction_unique > 0 && isfinite(facts.friction_unique))
    (void)snprintf(below, sizeof below, " Below friction %.3g each load has one answer (proved).",
                   facts.friction_unique);
  if (folds && isfinite(fold.friction))
    (void)snprintf(other, sizeof other,
                   " A search found loads with several answers only above friction %.3g.",
                   fold.friction);
  else if (folds)
    (void)snprintf(other, sizeof other, " A search found no other answer for any load.");
  if ((known && own < facts.friction_unique) || (folds && fold.exact && own < fold.friction))
    page_say(a->page, PAGE_PLAIN, "Uniqueness%s: one answer, proved, at friction %.3g.%s", where(a),
             own, below);
  else if (folds && own >= fold.friction)
    page_say(
        a->page, PAGE_PLAIN,
        "Uniqueness%s: unknown at friction %.3g. Above friction %.3g%s some loads have several "
        "answers.%s",
        where(a), own, fold.friction, fold.exact ? "" : ", perhaps less,", below);
  else
    page_say(a->page, PAGE_PLAIN, "Uniqueness%s: unknown at friction %.3g.%s%s", where(a), own,
             other, below);
  if (known && own > facts.friction_critical)
    page_say(a->page, PAGE_PLAIN, "Contact %d alone can jam: its friction is above %.3g.",
             facts.critical + 1, facts.friction_critical);
}

void part_command(const parts *a) {
  page_say(a->page, PAGE_COMMAND, "%s", a->command[a->commands - 1]);
}

void part_stability(parts *a) {
  const int steps = a->scene && a->scene->kind != SCENE_AT_ONCE;
  const int rows = steps ? MAP_OF_STEPS : MAP_OF_METHODS;
  char path[PATH_ROOM], options[60];
  (void)snprintf(options, sizeof options, "--rows=%d --limit=%.2g", rows,
                 a->cpu / (steps ? STEP_CELLS : 2 * rows * METHODS));
  if (!make_part(a, "map", options, command_map, path)) return;
  const int drawn = page_picture(a->page, path, "map.svg",
                                 steps ? "Does the scene finish? Friction against steps"
                                       : "Which method works up to which friction");
  count_cells(a, path);
  if (!drawn)
    (void)page_csv(a->page, path, "map.csv", steps ? "" : "mu,method,verdict,cpu_s,residual", NULL,
                   PAGE_CELLS / PAGE_COLUMNS);
}

/* ---- the run: motion, contacts --------------------------------------------------------------- */

void part_run(parts *a, const scene_answer *got) {
  char path[PATH_ROOM], options[SETTING_ROOM];
  static const char *const pictures[3][2] = {
      {"deformed.svg", "reactions.svg"}, {"force.svg", "pressure.svg"}, {"map.svg", "bar.svg"}};
  static int (*const run[3])(int, char **) = {command_scene, command_forming, command_moving};
  const int kind = (int)a->scene->kind - (int)SCENE_AT_ONCE;
  const int moves = a->scene->kind == SCENE_MOVING;
  (void)setting_text(a->scene, a->take, 1, options);
  page_say(a->page, PAGE_SECTION, moves ? "Motion: drift of energy" : "Contacts");
  if (!make_part(a, "scene", options, run[kind], path)) return;
  if (moves) {
    page_say(a->page, PAGE_PLAIN,
             "The energy balance of the worst step is off by %.1e %% of the energies in it.",
             100 * got->drift);
    if (isfinite(got->gap))
      page_say(a->page, PAGE_PLAIN, "The gap is off by %.2g %% of the closed form (L2 over time).",
               100 * got->gap);
    (void)page_picture(a->page, path, "energy.svg", "Energies, works, and what does not balance");
    (void)page_csv(a->page, path, "energy.csv", "", NULL, 1);
    page_say(a->page, PAGE_SECTION, "Contacts");
  }
  static const char *const captions[3][2] = {
      {"The deformed mesh and its reactions", "Reactions along the contact line"},
      {"Force against travel",
       "Pressure and shear at the end; pressure over the travel, where none has the colour of the "
       "page"},
      {"State and pressure over surface and time; none has the colour of the page",
       "Gap and force beside the closed form"}};
  for (int k = 0; k < 2; k++)
    (void)page_picture(a->page, path, pictures[kind][k], captions[kind][k]);
  static const char *const columns[3] = {"candidate_from_0,x,rn,rt,un,ut,status",
                                         "candidate_from_0,x,y,gap,slip,rn,rt",
                                         "t,candidate_from_0,r_n,r_t,u_n,u_t,state"};
  page_say(a->page, PAGE_PLAIN, "The last rows of contact.csv:");
  (void)page_csv(a->page, path, "contact.csv", columns[kind], NULL, MOST_TABLE / 2);
}

/* Returns the size of the files in the folder, in MB, and finds the largest one of those that
 * scenes write for every step. */
static double folder_size(const char *folder, char largest[PATH_ROOM], double *most) {
  DIR *list = opendir(folder);
  char path[PATH_ROOM];
  struct stat is;
  double sum = 0;
  *most = 0;
  for (struct dirent *d; list && (d = readdir(list)) != NULL;) {
    if (!join_path(path, folder, d->d_name) || lstat(path, &is) || !S_ISREG(is.st_mode)) continue;
    const double size = 1e-6 * (double)is.st_size;
    sum += size;
    if (size <= *most || (strncmp(d->d_name, "step_", 5) && strncmp(d->d_name, "tools_", 6) &&
                          strcmp(d->d_name, "contact.csv") != 0))
      continue;
    *most = size;
    memcpy(largest, path, sizeof path);
  }
  if (list) (void)closedir(list);
  return sum;
}

void part_trim(const parts *a) {
  char path[PATH_ROOM], largest[PATH_ROOM];
  double most, left_out = 0;
  if (!join_path(path, a->folder, "scene")) return;
  while (folder_size(path, largest, &most) > most_megabytes && most > 0 && !unlink(largest))
    left_out += most;
  if (left_out > 0)
    page_say(a->page, PAGE_NOTE,
             "Left out: %.0f MB of the largest files of the scene; --data keeps them.", left_out);
}

void part_commands(const parts *a) {
  page_say(a->page, PAGE_PLAIN, "No part draws random numbers; CPU times differ between runs.");
  for (int k = 0; k < a->commands; k++)
    page_say(a->page, PAGE_COMMAND, "%s", a->command[k]);
}
