/*
 * map_steps.c: maps of scenes that go in steps, forming or bodies that move: friction against the
 * number of steps, or against the mesh; a cell tells if the scene finished, and in how many
 * seconds, or why it stopped, and how far it came.
 */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "map.h"

enum { STEP_ROWS = 8, STEP_COLUMNS = 6 };

static const double scene_limit = 10; /* CPU seconds of a cell, unless --limit says */

/* A scene of either kind: `moving` is read where moves = 1, else `forming`. */
typedef struct walker {
  const char *name;
  int moves;
  dls_forming_settings forming;
  dls_moving_settings moving;
  int steps, nx, ny, upper; /* of the scene's own; ny, upper: 0 where it has none */
  double most_mu, whole;    /* friction on the top row; the whole way, or the whole time */
} walker;

/* How a scene went. */
typedef struct walk {
  dls_status status;
  double part, seconds; /* of the way, 0 to 1; CPU */
} walk;

/* ---- both kinds ------------------------------------------------------------------------------ */

static dls_status forming_own(walker *w, dls_error *error) {
  dls_forming *forming;
  dls_forming_data d;
  const dls_status status = dls_forming_create(&forming, w->name, &w->forming, error);
  if (status) return status;
  dls_forming_get(forming, &d);
  /* nx <= ny from (nx + 1) (ny + 1) nodes and nx ny elements */
  const int sum = d.mesh->nodes - d.mesh->quads - 1;
  const double apart = sqrt(fmax(0, (double)sum * sum - 4.0 * d.mesh->quads));
  w->nx = (int)round((sum - apart) / 2);
  w->ny = (int)round((sum + apart) / 2);
  w->steps = d.steps;
  w->whole = d.whole;
  w->most_mu = 1;
  dls_forming_destroy(forming);
  return DLS_OK;
}

static dls_status moving_own(walker *w, dls_error *error) {
  dls_moving *moving;
  dls_moving_data d;
  const dls_status status = dls_moving_create(&moving, w->name, &w->moving, error);
  if (status) return status;
  dls_moving_get(moving, &d);
  w->nx = d.settings.nx;
  w->ny = d.settings.ny;
  w->upper = d.settings.upper;
  w->steps = d.steps;
  w->whole = d.steps * d.h;
  w->most_mu = 10;
  dls_moving_destroy(moving);
  return DLS_OK;
}

/* Takes the steps from the first to the end, to the first that fails, or to the limit. */
static dls_status walk_forming(const walker *w, double limit, walk *out, dls_error *error) {
  dls_forming *forming;
  dls_forming_data d;
  dls_forming_settings s = w->forming;
  s.cpu_seconds = map_longer * limit;
  dls_status status = dls_forming_create(&forming, w->name, &s, error);
  if (status) return status;
  const double start = cpu_seconds();
  dls_forming_get(forming, &d);
  for (int step = 1; step <= d.steps && !status; step++) {
    status = dls_forming_step(forming, error);
    dls_forming_get(forming, &d);
    if (!status && show_step(&d, step)) status = DLS_CANCELLED;
  }
  *out = (walk){status, d.travel / d.whole, cpu_seconds() - start};
  dls_forming_destroy(forming);
  return status < 0 ? status : DLS_OK;
}

static dls_status walk_moving(const walker *w, double limit, walk *out, dls_error *error) {
  dls_moving *moving;
  dls_moving_data d;
  dls_moving_settings s = w->moving;
  s.limits.cpu_seconds =
      map_longer * limit; /* of a contact problem, which may be without a solution */
  dls_status status = dls_moving_create(&moving, w->name, &s, error);
  if (status) return status;
  const double start = cpu_seconds();
  dls_moving_get(moving, &d);
  while (d.step < d.steps && !status) {
    status = dls_moving_step(moving, error);
    dls_moving_get(moving, &d);
    if (!status && show_moving_step(&d)) status = DLS_CANCELLED;
    if (!status && d.step < d.steps && cpu_seconds() - start > map_longer * limit)
      status = DLS_TIME_LIMIT;
  }
  *out = (walk){status, (double)d.step / d.steps, cpu_seconds() - start};
  dls_moving_destroy(moving);
  return status < 0 ? status : DLS_OK;
}

/* Returns 0 for no method. */
static int walker_method(walker *w, const char *method) {
  return w->moves ? dls_method_find(method, &w->moving.method)
                  : forming_method(method, &w->forming);
}

static dls_status walk_scene(walker *w, double mu, double limit, walk *out, dls_error *error) {
  w->forming.mu = w->moving.mu = mu;
  const dls_status status = (w->moves ? walk_moving : walk_forming)(w, limit, out, error);
  progress_end();
  return status;
}

/* ---- cells ----------------------------------------------------------------------------------- */

/* Sets the cell of a walk: the seconds if it finished, else the verdict and the part of the way. */
static void show_walk(map_cell *cell, const walk *w) {
  const ending e = ending_of(w->status);
  map_verdict(cell, e, 1);
  if (e == ENDED_SOLVED)
    (void)snprintf(cell->text, sizeof cell->text, w->seconds < 99.5 ? "%.2g s" : "%.0f s",
                   w->seconds);
  else
    (void)snprintf(cell->text, sizeof cell->text, "%s %.0f %%", ending_word(e),
                   floor(100 * w->part));
}

/* Returns count times the factor, at least `least`; 0 of what a scene does not have. */
static int scaled(int count, double factor, int least) {
  return count ? (int)fmax(least, round(count * factor)) : 0;
}

/* Sets column j: a number of steps, or a mesh. */
static void set_column(map_picture *p, int j, int mesh, walker *w) {
  const double factor = pow(2, mesh ? j - 3 : j - 5); /* of the scene's own */
  if (!mesh) {
    w->forming.steps = w->moving.steps = scaled(w->steps, factor, 1);
    (void)snprintf(p->column[j], MAP_NAME, "%d", w->moving.steps);
    return;
  }
  w->forming.nx = w->moving.nx = scaled(w->nx, factor, 2);
  w->forming.ny = w->moving.ny = scaled(w->ny, factor, 2);
  w->moving.upper = scaled(w->upper, factor, 2);
  if (w->ny)
    (void)snprintf(p->column[j], MAP_NAME, "%dx%d", w->moving.nx, w->moving.ny);
  else
    (void)snprintf(p->column[j], MAP_NAME, "%d", w->moving.nx);
}

/* Runs the scene for every cell. DLS_E_FILE: after a complaint. */
static dls_status fill_walks(map_picture *p, walker *w, const map_options *o, int mesh,
                             int *all_done, dls_error *error) {
  double mu[MAP_ROWS];
  FILE *csv = open_in(o->out, "map.csv");
  dls_status status = csv ? DLS_OK : DLS_E_FILE;
  if (csv) fprintf(csv, "mu,%s,verdict,part,cpu_s\n", mesh ? "mesh" : "steps");
  spread_friction(o->from, o->to < 0 ? w->most_mu : o->to, p->rows, mu);
  *all_done = 1;
  for (int i = 0; i < p->rows; i++)
    (void)snprintf(p->row[i], MAP_NAME, "%.2g", mu[i]);
  for (int j = 0; j < p->columns && !status; j++) {
    set_column(p, j, mesh, w);
    for (int i = 0; i < p->rows && !status && !was_interrupted(); i++) {
      walk done;
      status = walk_scene(w, mu[i], o->limit < 0 ? scene_limit : o->limit, &done, error);
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
  walker w = {.name = name, .moves = moves};
  int all_done = 0, result = EXIT_BAD_INPUT;
  dls_forming_settings_init(&w.forming);
  dls_moving_settings_init(&w.moving);
  if (!walker_method(&w, o->method)) return no_method(o->method, NULL), EXIT_BAD_INPUT;
  if ((moves ? moving_own : forming_own)(&w, &error)) return complain_of(name, &error);
  p.rows = o->rows ? o->rows : STEP_ROWS;
  if (p.rows > MAP_ROWS) p.rows = MAP_ROWS;
  (void)snprintf(x, sizeof x, "steps of the whole %s, %g%s", moves ? "time" : "way", w.whole,
                 moves ? "" : " mm");
  p.x = mesh ? "elements" : x;
  p.y = "friction";
  p.subtitle =
      moves ? "blue: finished, CPU seconds; else why it stopped, and after how much of the time"
            : "blue: finished, CPU seconds; else why it stopped, and after how much of the way";
  (void)snprintf(title, sizeof title, "%s by %s: does it finish?", name, o->method);
  (void)snprintf(notes, sizeof notes,
                 "measured; tolerance %.0e. Hatched: not decided in %g s of CPU",
                 moves ? w.moving.limits.tol : w.forming.tol,
                 map_longer * (o->limit < 0 ? scene_limit : o->limit));
  p.cells = calloc((size_t)(p.rows * p.columns), sizeof *p.cells);
  if (!p.cells)
    (void)complain_of(name, &error);
  else if ((o->out = take_folder(o->out, "map", name))) {
    p.directory = o->out;
    const dls_status status = fill_walks(&p, &w, o, mesh, &all_done, &error);
    if (!status)
      result = draw_map(&p);
    else if (status != DLS_E_FILE)
      (void)complain_of(name, &error);
  }
  free(p.cells);
  if (result == EXIT_SOLVED && !all_done) result = EXIT_NOT_SOLVED;
  return end_table(result, "not every run finishes", "map", o->out, "map.csv");
}
