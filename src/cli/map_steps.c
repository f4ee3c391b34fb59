/*
 * map_steps.c: maps of scenes that go in steps, forming or bodies that move: friction against the
 * number of steps, or against the mesh; a cell tells if the scene finished, and in how many
 * seconds, or why it stopped, and how far it came.
 */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "map.h"
#include "setting.h"

enum { STEP_ROWS = 8, STEP_COLUMNS = 6 };

static const double scene_limit = 10; /* CPU seconds of a cell, unless --limit says */

/* ---- cells ----------------------------------------------------------------------------------- */

/* Sets the cell of a run: the seconds if it finished, else the verdict and the part of the way. */
static void show_walk(map_cell *cell, const scene_answer *w) {
  const ending e = ending_of(w->status);
  map_verdict(cell, e, 1);
  if (e == ENDED_SOLVED)
    (void)snprintf(cell->text, sizeof cell->text, w->seconds < 99.5 ? "%.2g s" : "%.0f s",
                   w->seconds);
  else
    (void)snprintf(cell->text, sizeof cell->text, "%s %.0f %%", ending_word(e),
                   floor(100 * w->part));
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

/* Runs the scene for every cell. DLS_E_FILE: after a complaint. */
static dls_status fill_walks(map_picture *p, const scene *s, const map_options *o, int mesh,
                             int *all_done, dls_error *error) {
  double mu[MAP_ROWS];
  FILE *csv = open_in(o->out, "map.csv");
  dls_status status = csv ? DLS_OK : DLS_E_FILE;
  if (csv) fprintf(csv, "mu,%s,verdict,part,cpu_s\n", mesh ? "mesh" : "steps");
  spread_friction(o->from, o->to < 0 ? (s->kind == SCENE_MOVING ? 10 : 1) : o->to, p->rows, mu);
  *all_done = 1;
  for (int i = 0; i < p->rows; i++)
    (void)snprintf(p->row[i], MAP_NAME, "%.2g", mu[i]);
  for (int j = 0; j < p->columns && !status; j++) {
    setting at = set_column(p, j, mesh, s);
    at.method = o->method;
    for (int i = 0; i < p->rows && !status && !was_interrupted(); i++) {
      scene_answer done;
      at.mu = mu[i];
      status =
          scene_run(s, &at, map_longer * (o->limit < 0 ? scene_limit : o->limit), &done, error);
      if (status || was_interrupted()) continue;
      show_walk(map_at(p, 0, i, j), &done);
      *all_done &= done.status == DLS_OK;
      fprintf(csv, "%.9g,%s,%s,%.4f,%.4f\n", mu[i], p->column[j],
              ending_word(ending_of(done.status)), done.part, done.seconds);
    }
  }
  return !status && !close_file(csv, "map.csv") ? DLS_E_FILE : status;
}

/* ---- the map --------------------------------------------------------------------------------- */

int map_steps(const char *name, map_options *o, int moves) {
  const int mesh = o->against != NULL;
  char title[200], x[80], notes[200];
  map_picture p = {.title = title, .panels = 1, .columns = STEP_COLUMNS, .notes = notes};
  dls_error error = {.status = DLS_E_MEMORY, .message = "out of memory"};
  scene s;
  dls_status found = DLS_OK;
  int all_done = 0, result = EXIT_BAD_INPUT;
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
  p.subtitle =
      moves ? "blue: finished, CPU seconds; else why it stopped, and after how much of the time"
            : "blue: finished, CPU seconds; else why it stopped, and after how much of the way";
  (void)snprintf(title, sizeof title, "%s by %s: does it finish?", name, o->method);
  (void)snprintf(notes, sizeof notes,
                 "measured; tolerance %.0e. Hatched: not decided in %g s of CPU", s.own.tol,
                 map_longer * (o->limit < 0 ? scene_limit : o->limit));
  p.cells = calloc((size_t)(p.rows * p.columns), sizeof *p.cells);
  if (!p.cells)
    (void)complain_of(name, &error);
  else if ((o->out = take_folder(o->out, "map", name))) {
    p.directory = o->out;
    const dls_status status = fill_walks(&p, &s, o, mesh, &all_done, &error);
    if (!status)
      result = draw_map(&p);
    else if (status != DLS_E_FILE)
      (void)complain_of(name, &error);
  }
  free(p.cells);
  if (result == EXIT_SOLVED && !all_done) result = EXIT_NOT_SOLVED;
  return end_table(result, "not every run finishes", "map", o->out, "map.csv");
}
