/*
 * map_steps.c: maps of scenes that go in steps, forming or bodies that move: friction against the
 * number of steps, or against the mesh; a cell tells if the scene finished, in how many seconds and
 * how far its answer is from that of the finest run of its row, or why it stopped, and how far it
 * came.
 */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "map.h"
#include "problem/setting.h"

enum { STEP_ROWS = 8, STEP_COLUMNS = 6 };

static const double scene_limit = 10; /* CPU seconds of a cell, unless --limit says */
static const double dark_off = 1e-3;  /* distance from the finest up to which a cell is dark */

/* ---- cells ----------------------------------------------------------------------------------- */

/* A run of the scene. */
typedef struct walk {
  int is_done, is_finest; /* is_done = 0: Ctrl-C came first */
  scene_answer got;
  double off; /* of the answer from that of the finest run of the row, in parts of the latter;
                 0 for the finest itself, NaN for a run that did not finish */
} walk;

/* Compares the answers of a row. */
static void compare_walks(walk *row, int columns) {
  int finest = columns - 1;
  while (finest > 0 && !(row[finest].is_done && isfinite(row[finest].got.value)))
    finest--;
  const double value = row[finest].got.value;
  for (int j = 0; j < columns; j++) {
    const double apart = fabs(row[j].got.value - value);
    row[j].is_finest = j == finest;
    row[j].off = row[j].is_done ? (apart > 0 ? apart / fabs(value) : apart) : NAN;
  }
}

/* Sets the cell of a run: the seconds and the distance from the finest if it finished, else the
 * verdict and the part of the way. */
static void show_walk(map_cell *cell, const walk *w) {
  const ending e = ending_of(w->got.status);
  map_verdict(cell, e, w->off / dark_off);
  if (e != ENDED_SOLVED) {
    (void)snprintf(cell->text, sizeof cell->text, "%s %.0f %%", ending_word(e),
                   floor(100 * w->got.part));
    return;
  }
  char off[12] = "finest";
  if (!w->is_finest)
    (void)snprintf(off, sizeof off, w->off < 0.0995 ? "%.1g %%" : "%.0f %%", 100 * w->off);
  (void)snprintf(cell->text, sizeof cell->text, "%s, %s", in_words(w->got.seconds).text, off);
}

/* Returns the setting of column j, a number of steps or a mesh, and names the column. */
static setting set_column(map_picture *p, int j, int mesh, const scene *s) {
  const int steps = mesh ? 0 : j - 5, size = mesh ? 2 * (j - 3) : 0;
  const setting at = setting_scaled(s, size, steps, 0);
  if (!mesh)
    (void)snprintf(p->column[j], MAP_NAME, "%d", at.steps);
  else if (at.ny)
    (void)snprintf(p->column[j], MAP_NAME, "%dx%d", at.nx, at.ny);
  else
    (void)snprintf(p->column[j], MAP_NAME, "%d", at.nx);
  return at;
}

/* Runs the scene for every cell; walks: rows x columns. */
static dls_status run_walks(map_picture *p, const scene *s, const map_options *o, int mesh,
                            const double *mu, walk *walks, dls_error *error) {
  dls_status status = DLS_OK;
  for (int j = 0; j < p->columns && !status; j++) {
    setting at = set_column(p, j, mesh, s);
    at.method = o->method;
    for (int i = 0; i < p->rows && !status && !was_interrupted(); i++) {
      walk *w = &walks[i * p->columns + j];
      at.mu = mu[i];
      status =
          scene_run(s, &at, map_longer * (o->limit < 0 ? scene_limit : o->limit), &w->got, error);
      w->is_done = !status && !was_interrupted();
    }
  }
  return status;
}

/* Fills the cells of the runs that are done, and writes them as a table; returns 0 after a
 * complaint. */
static int show_walks(map_picture *p, const char *directory, int mesh, const double *mu,
                      walk *walks, int *all_done) {
  FILE *csv = open_growing(directory, "map.csv", "");
  if (!csv) return 0;
  fprintf(csv, "mu,%s,verdict,part,cpu_s,answer,off\n", mesh ? "mesh" : "steps");
  for (int i = 0; i < p->rows; i++)
    compare_walks(&walks[i * p->columns], p->columns);
  for (int j = 0; j < p->columns; j++)
    for (int i = 0; i < p->rows; i++) {
      const walk *w = &walks[i * p->columns + j];
      *all_done &= w->is_done && w->got.status == DLS_OK;
      if (!w->is_done) continue;
      show_walk(map_at(p, 0, i, j), w);
      fprintf(csv, "%.9g,%s,%s,%.4f,%.4f", mu[i], p->column[j],
              ending_word(ending_of(w->got.status)), w->got.part, w->got.seconds);
      fprintf(csv, isfinite(w->off) ? ",%.9g,%.3e\n" : ",,\n", w->got.value, w->off);
    }
  return close_file(csv, "map.csv");
}

/* ---- the map --------------------------------------------------------------------------------- */

int map_steps(const char *name, map_options *o, int moves) {
  const int mesh = o->against != NULL;
  char title[200], subtitle[300], x[80], notes[300];
  double mu[MAP_ROWS];
  map_picture p = {.title = title, .panels = 1, .columns = STEP_COLUMNS, .notes = notes};
  dls_error error = {.status = DLS_E_MEMORY, .message = "out of memory"};
  scene s;
  dls_status found = DLS_OK;
  int all_done = 1, result = EXIT_BAD_INPUT;
  dls_method method;
  dls_forming_settings forming;
  if (!(moves ? dls_method_find(o->method, &method) : forming_method(o->method, &forming)))
    return no_method(o->method, NULL), EXIT_BAD_INPUT;
  if (!scene_find(name, &s, &found, &error) || found) return complain_of(name, &error);
  if (mesh && !s.own.nx) return complain("--against=mesh: %s has one mesh", name);
  p.rows = o->rows ? o->rows : STEP_ROWS;
  if (p.rows > MAP_ROWS) p.rows = MAP_ROWS;
  (void)snprintf(x, sizeof x, "steps of the whole %s, %g%s", moves ? "time" : "way", s.whole,
                 moves ? "" : " mm");
  p.x = mesh ? "elements" : x;
  p.y = "friction";
  p.subtitle = subtitle;
  (void)snprintf(subtitle, sizeof subtitle,
                 "blue: finished; CPU seconds, and how far the %s is from the finest of the row",
                 s.answer);
  (void)snprintf(title, sizeof title, "%s by %s: does it finish, and how far off?", name,
                 o->method);
  (void)snprintf(notes, sizeof notes,
                 "measured; tolerance %.0e. Else: why it stopped, after how much of the %s. "
                 "Hatched: not decided in %g s",
                 s.own.tol, moves ? "time" : "way",
                 map_longer * (o->limit < 0 ? scene_limit : o->limit));
  spread_friction(o->from, o->to < 0 ? (moves ? 10 : 1) : o->to, p.rows, mu);
  for (int i = 0; i < p.rows; i++)
    (void)snprintf(p.row[i], MAP_NAME, "%.2g", mu[i]);
  walk *walks = calloc((size_t)(p.rows * p.columns), sizeof *walks);
  p.cells = calloc((size_t)(p.rows * p.columns), sizeof *p.cells);
  if (!p.cells || !walks)
    (void)complain_of(name, &error);
  else if ((o->out = take_folder(o->out, "map", name))) {
    p.directory = o->out;
    if (run_walks(&p, &s, o, mesh, mu, walks, &error))
      (void)complain_of(name, &error);
    else if (show_walks(&p, o->out, mesh, mu, walks, &all_done))
      result = draw_map(&p);
  }
  free(p.cells);
  free(walks);
  if (result == EXIT_SOLVED && !all_done) result = EXIT_NOT_SOLVED;
  return end_table(result, "not every run finishes", "map", o->out, "map.csv");
}
