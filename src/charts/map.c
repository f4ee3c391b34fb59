/*
 * map.c: delassus map NAME...: where each method works. One name: rows are friction. Several names:
 * rows are the problems, at their own friction. Beside it the largest reaction, which grows without
 * bound where the body jams.
 */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "map.h"

enum { most_rows_of_bounds = 1500, most_rows_of_friction = 60, most_candidates_of_fold = 40 };

static const double solve_limit = 0.3; /* CPU seconds of a solve, unless --limit says */

static void map_usage(FILE *out) {
  fputs(
      "Usage: delassus map [OPTION]... FILE|SCENE\n"
      "  or:  delassus map [OPTION]... FILE|SCENE FILE|SCENE...\n"
      "  or:  delassus map [OPTION]... --W=W --q=Q --mu=MU (or --stiffness=K ...)\n"
      "Shows where each method works. Columns are methods; rows are friction, or the problems if\n"
      "there are several names. The colour is the verdict; shade and number are the CPU over the\n"
      "fastest of the row. A cell that meets its limit ten times over is hatched: not decided. "
      "For\n"
      "scenes in steps (indentation, bar-impact, ...) the axes are friction and the number of\n"
      "steps, or with --step as above. Writes map.csv, map.png and map.svg; Ctrl-C draws what is\n"
      "done.\n"
      "\n"
      "      --mu=FROM:TO      range of friction (0:10; forming 0:1)\n"
      "      --rows=N          number of values of friction (18; 8)\n"
      "      --against=WHAT    x axis: condition, rank or skew of W, with a panel for each method\n"
      "                        that shows the share of solved samples; mesh, for scenes in steps\n"
      "      --samples=N       random loads for each cell (5)\n"
      "  -m, --method=METHOD   method for scenes in steps (auto)\n"
      "  -t, --tol=T           tolerance (1e-8)\n"
      "  -l, --limit=S         CPU seconds for a solve (0.3; --against 0.05), or for a cell of\n"
      "                        scenes in steps (10); in need ten times as many\n"
      "  -o, --out=DIR         folder for the files (a new one under TMPDIR, which is "
      "printed)\n" LAST_USAGE "\n"
      "Exit status: 0, 1 if auto failed where another method did not, 2 bad input.\n\n",
      out);
  source_usage(out);
}

/* ---- one row --------------------------------------------------------------------------------- */

/* The map while it is measured. */
typedef struct map_run {
  map_picture picture;
  contender who[MOST_CONTENDERS];
  double side[MAP_ROWS], mu[MAP_ROWS];
  int solved_by_auto[MAP_ROWS];
  FILE *csv;
  int failed; /* 1: auto failed where another method did not */
} map_run;

/* Races the methods on one problem and fills row `row`; *stop = 1 after Ctrl-C. */
static dls_status map_race(map_run *m, int row, const dls_contact *contact, const problem *body,
                           const map_options *o, int *stop, dls_error *error) {
  const race_plan plan = {.rungs = 1, .tol = &o->tol, .repeat = 6, .limit = o->limit, .budget = 5};
  race a = {0};
  dls_status status = race_run(&a, contact, body, &plan, error);
  *stop = a.interrupted;
  if (status || a.interrupted) {
    race_free(&a);
    return status;
  }
  const double fastest = race_fastest(&a, 0);
  m->side[row] = NAN;
  m->solved_by_auto[row] = is_answer(race_trial(&a, 0, 0)->end);
  m->failed |= isfinite(fastest) && !m->solved_by_auto[row];
  for (int k = 0; k < a.count; k++) {
    const trial *t = race_trial(&a, k, 0);
    int j = 0;
    while (j < m->picture.columns && strcmp(m->who[j].name, a.who[k].name) != 0)
      j++;
    map_verdict(map_at(&m->picture, 0, row, j), t->end, t->seconds / fastest);
    fprintf(m->csv, "%s,%.9g,%s,%s,%.4e,%d,%.3e\n", quote(AS_CSV, m->picture.row[row]).text,
            m->mu[row], a.who[k].name, ending_word(t->end), t->seconds, t->iterations, t->residual);
    if (t->end != ENDED_SOLVED || isfinite(m->side[row])) continue;
    m->side[row] = largest_entry(race_answer(&a, k, 0), a.d * a.nc);
  }
  fflush(m->csv);
  race_free(&a);
  return DLS_OK;
}

/* ---- lines ----------------------------------------------------------------------------------- */

/* Adds a line at friction mu if the rows reach it. */
static void add_line(map_run *m, double mu, const char *colour, const char *text) {
  const int rows = m->picture.rows;
  if (!isfinite(mu) || rows < 2 || mu < m->mu[0] || mu > m->mu[rows - 1] ||
      m->picture.lines == MAP_LINES)
    return;
  int i = 0;
  while (i < rows - 2 && m->mu[i + 1] <= mu)
    i++;
  map_line *line = &m->picture.line[m->picture.lines++];
  line->row = i + 0.5; /* rows below it have less */
  line->colour = colour;
  (void)snprintf(line->text, sizeof line->text, "%s %.3g", text, mu);
}

/* Writes friction `mu` into values: of the largest, the others in proportion. */
static void scale_friction(const dls_contact *contact, double mu, double *values) {
  const double most = largest_entry(contact->mu, contact->nc);
  for (int c = 0; c < contact->nc; c++)
    values[c] = most > 0 ? mu * (contact->mu[c] / most) : mu;
}

/* Goes up the rows by auto, each from the answer of the row below; returns the last friction that
 * was solved before one was not, NaN for none. */
static double continue_rows(const map_run *m, const dls_contact *given, const map_options *o,
                            double *mu, int rows) {
  dls_contact contact = *given;
  dls_solver_settings s;
  dls_solver *solver = NULL;
  double last = NAN, *r = calloc((size_t)given->d * (size_t)given->nc, sizeof *r);
  dls_solver_settings_init(&s);
  s.limits.tol = o->tol;
  s.limits.cpu_seconds = 10 * o->limit;
  s.limits.progress = show_progress;
  s.limits.blocks = contact.Wb.x ? contact.Wb.p[contact.nc] : 0;
  contact.mu = mu;
  if (!r || dls_solver_create(&solver, contact.d, contact.nc, &s, NULL)) rows = 0;
  for (int i = 0; i < rows; i++) {
    scale_friction(given, m->mu[i], mu);
    dls_limits limits = s.limits;
    limits.warm_start = i > 0;
    if (dls_solver_set_limits(solver, &limits, NULL) ||
        dls_solver_solve(solver, &contact, r, NULL, NULL, NULL))
      break;
    last = m->mu[i];
  }
  progress_end();
  dls_solver_destroy(solver);
  free(r);
  return last;
}

/* ---- rows of friction ------------------------------------------------------------------------ */

/* Chooses the rows: the range, and the problem's own friction. */
static int choose_rows(map_run *m, const dls_contact *contact, const map_options *o) {
  const double own = largest_entry(contact->mu, contact->nc), to = o->to < 0 ? 10 : o->to;
  int rows = o->rows ? o->rows : 18, is_there = own == 0;
  if (rows > most_rows_of_friction) rows = most_rows_of_friction;
  spread_friction(o->from, to, rows, m->mu);
  for (int i = 0; i < rows; i++)
    is_there |= m->mu[i] == own;
  if (!is_there) m->mu[rows++] = own;
  qsort(m->mu, (size_t)rows, sizeof m->mu[0], ascending);
  for (int i = 0; i < rows; i++)
    (void)snprintf(m->picture.row[i], MAP_NAME, "%.3g%s", m->mu[i],
                   m->mu[i] == own ? " (own)" : "");
  return rows;
}

/* Marks what is known of the friction; without memory returns DLS_E_MEMORY. */
static dls_status add_lines(map_run *m, const dls_contact *contact, const map_options *o,
                            double *mu, int done, dls_error *error) {
  dls_diagnosis facts;
  dls_status status = dls_contact_diagnose(contact, most_rows_of_bounds, &facts, error);
  if (status == DLS_E_MEMORY) return status;
  if (!status) {
    if (facts.friction_unique > 0)
      add_line(m, facts.friction_unique, "#009e73", "one answer for all loads below");
    add_line(m, facts.friction_critical, "#d55e00", "some candidate jams above");
  }
  dls_fold fold;
  status = contact->nc <= (contact->d == 2 ? most_candidates_of_fold : DLS_STATES_MAX)
               ? dls_contact_fold(contact, &fold, NULL, NULL, NULL, NULL, error)
               : DLS_E_UNSUPPORTED;
  if (status == DLS_E_MEMORY) return status;
  if (!status)
    add_line(m, fold.friction, "#000000",
             fold.exact ? "fold: several answers for some loads above"
                        : "fold (searched): several answers above");
  const double last = continue_rows(m, contact, o, mu, done);
  if (done && last < m->mu[done - 1]) add_line(m, last, "#cc79a7", "last reached by continuation");
  return DLS_OK;
}

static dls_status map_friction(map_run *m, const problem *body, const map_options *o,
                               dls_error *error) {
  const dls_contact *given = &body->contact;
  double *mu = malloc((size_t)given->nc * sizeof *mu);
  dls_contact contact = *given;
  dls_status status = mu ? DLS_OK : DLS_E_MEMORY;
  int stop = 0, done = 0;
  m->picture.rows = choose_rows(m, given, o);
  contact.mu = mu;
  for (; done < m->picture.rows && !status && !stop; done += !stop) {
    scale_friction(given, m->mu[done], mu);
    status = map_race(m, done, &contact, body, o, &stop, error);
  }
  m->picture.rows = done;
  if (!status && !stop) status = add_lines(m, given, o, mu, done, error);
  free(mu);
  return status;
}

/* ---- rows of problems ------------------------------------------------------------------------ */

/* Fills a row for each name, the first on top. DLS_E_FILE: after a complaint. */
static dls_status map_problems(map_run *m, int count, char **names, const map_options *o,
                               const char **at, dls_error *error) {
  int stop = 0, done = 0;
  dls_status status = DLS_OK;
  m->picture.rows = count;
  for (int i = 0; i < count && !status && !stop; i++) {
    const int row = count - 1 - i;
    problem subject = {0};
    *at = names[i];
    if (!problem_open(names[i], &o->of, &subject))
      status = was_interrupted() ? DLS_CANCELLED : DLS_E_FILE;
    else {
      (void)snprintf(m->picture.row[row], MAP_NAME, "%s", subject.name);
      m->mu[row] = largest_entry(subject.contact.mu, subject.contact.nc);
      status = map_race(m, row, &subject.contact, &subject, o, &stop, error);
    }
    problem_free(&subject);
    done += !stop;
  }
  /* rows that Ctrl-C left out are the lowest */
  const int left = count - done;
  memmove(m->picture.row, m->picture.row + left, (size_t)done * sizeof m->picture.row[0]);
  memmove(m->picture.cells, map_at(&m->picture, 0, left, 0),
          (size_t)(done * m->picture.columns) * sizeof *m->picture.cells);
  memmove(m->side, m->side + left, (size_t)done * sizeof m->side[0]);
  m->picture.rows = done;
  return status == DLS_CANCELLED ? DLS_OK : status;
}

/* Lists the methods as columns: those that take part on one problem, all for several. */
static void list_columns(map_run *m, const problem *alone) {
  contender all[MOST_CONTENDERS];
  const int count = list_contenders(all);
  map_picture *p = &m->picture;
  p->columns = 0;
  for (int k = 0; k < count; k++) {
    if (alone && !race_takes(&all[k], &alone->contact, alone)) continue;
    m->who[p->columns] = all[k];
    const char *name = all[k].name + (strncmp(all[k].name, "nlgs+", 5) ? 0 : 4); /* +aitken */
    if (!strcmp(name, "augmented-lagrangian")) name = "augm. L.";
    (void)snprintf(p->column[p->columns++], MAP_NAME, "%.40s", name);
  }
}

/* ---- the command ----------------------------------------------------------------------------- */

static int map_methods(int count, char **names, map_options *o) {
  map_run *m = calloc(1, sizeof *m);
  problem subject = {0};
  dls_error error = {.status = DLS_E_MEMORY, .message = "out of memory"};
  dls_status status = DLS_E_MEMORY;
  const char *at = names[0];
  char title[200], subtitle[200], notes[240];
  if (!m) return complain("%s: out of memory", at);
  m->picture = (map_picture){.title = title, .subtitle = subtitle, .notes = notes};
  m->picture.panels = 1;
  m->picture.x = "";
  if (count == 1) m->picture.side = m->side;
  m->picture.side_title = "largest reaction [force]";
  m->picture.y = count > 1 ? "" : "friction";
  m->picture.cells = calloc((size_t)MAP_ROWS * MAP_COLUMNS, sizeof *m->picture.cells);
  if (m->picture.cells)
    status = count > 1 || problem_open(at, &o->of, &subject) ? DLS_OK : DLS_E_FILE;
  if (!status) list_columns(m, count > 1 ? NULL : &subject);
  /* the files complain by themselves */
  if (!status && (o->out = take_folder(o->out, "map", count > 1 ? NULL : at)) &&
      (m->csv =
           open_growing(o->out, "map.csv", "row,mu,method,verdict,cpu_s,iterations,residual\n"))) {
    m->picture.directory = o->out;
    if (count > 1) {
      status = map_problems(m, count, names, o, &at, &error);
      (void)snprintf(title, sizeof title, "Who solves what: %d problem%s", m->picture.rows,
                     plural(m->picture.rows));
    } else {
      status = map_friction(m, &subject, o, &error);
      (void)snprintf(title, sizeof title, "%s: who solves it, friction by friction", subject.name);
    }
    (void)snprintf(subtitle, sizeof subtitle,
                   "blue: solved to %.0e; the bluer the faster; numbers: CPU over the fastest of "
                   "the row",
                   o->tol);
  }
  (void)snprintf(notes, sizeof notes,
                 "measured: CPU of each solve. Hatched, not decided: no verdict in %g s of CPU (or "
                 "300 times the fastest), or in ten times the method's iterations",
                 map_longer * o->limit);
  int result = EXIT_BAD_INPUT;
  if (status && status != DLS_E_FILE)
    (void)complain_of(at, &error);
  else if (!status && m->csv && close_file(m->csv, "map.csv"))
    result = draw_map(&m->picture);
  if (result == EXIT_SOLVED && m->failed) result = EXIT_NOT_SOLVED;
  problem_free(&subject);
  free(m->picture.cells);
  free(m);
  return end_table(result, "auto fails where another method does not", "map", o->out, "map.csv");
}

static taken take_range(const char *text, map_options *o) {
  const char *at = text;
  if (read_real(&at, &o->from) && *at++ == ':' && read_real(&at, &o->to) && !*at && o->from >= 0 &&
      o->to > o->from)
    return OPTION_TAKEN;
  return (taken)refuse("--mu: '%s' is not FROM:TO, two numbers, 0 <= FROM < TO", text);
}

static taken take_map_option(int key, const char *text, void *data) {
  map_options *o = data;
  (void)key; /* --mu alone */
  if (strchr(text, ':')) return take_range(text, o);
  o->of.matrices.mu = text;
  return OPTION_TAKEN;
}

int command_map(int argc, char **argv) {
  static const option_row options[] = {VALUE("mu", 256),
                                       ROW(A_COUNT, "rows", 0, map_options, rows),
                                       ROW(A_TEXT, "against", 0, map_options, against),
                                       ROW(A_COUNT, "samples", 0, map_options, samples),
                                       ROW(A_NUMBER, "tol", 't', map_options, tol),
                                       ROW(A_NUMBER, "limit", 'l', map_options, limit),
                                       ROW(A_TEXT, "method", 'm', map_options, method),
                                       ROW(A_TEXT, "out", 'o', map_options, out),
                                       SOURCE_OPTIONS(map_options, of),
                                       LAST_OPTIONS};
  static const command map = {options, map_usage, take_map_option, 0};
  map_options o = {.to = -1, .tol = 1e-8, .limit = -1, .samples = 5, .method = "auto"};
  const int stop = take_options(argc, argv, &map, &o);
  if (stop != GO_ON) return stop;
  int count = argc - optind;
  char **names = source_names(&count, argv, &o.of);
  if (!names) return EXIT_BAD_INPUT;
  if (count == 0) return EXIT_SOLVED;
  if (count > MAP_ROWS) return complain("map: at most %d names", MAP_ROWS);
  if (o.of.matrices.mu && !matrices_name(&o.of.matrices))
    return take_range(o.of.matrices.mu, &o), EXIT_BAD_INPUT;
  watch_interrupt();
  const scene_kind kind = kind_among(argc, argv);
  if (kind >= SCENE_FORMING && !o.of.step && count == 1 &&
      (!o.against || !strcmp(o.against, "mesh")))
    return map_steps(names[0], &o, kind == SCENE_MOVING);
  if (o.against) {
    if (count > 1) return complain("--against: takes one name");
    return map_against(names[0], &o);
  }
  if (o.limit < 0) o.limit = solve_limit;
  return map_methods(count, names, &o);
}
