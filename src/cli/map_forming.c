/*
 * map_forming.c: maps of scenes that go in steps: friction against the number of steps, or against
 * the mesh; a cell tells if the scene finished, and in how many seconds, or how far it came.
 */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "map.h"

enum { STEP_ROWS = 8, STEP_COLUMNS = 6 };

static const double scene_limit = 10; /* CPU seconds of a cell, unless --limit says */

/* How a scene went. */
typedef struct walk {
  dls_status status;
  double part, seconds; /* of the way, 0 to 1; CPU */
} walk;

/* Runs a scene to its end, to the first step that fails, or to the limit. */
static dls_status walk_forming(const char *name, const dls_forming_settings *s, double limit,
                               walk *w, dls_error *error) {
  dls_forming *forming;
  dls_forming_data d;
  dls_status status = dls_forming_create(&forming, name, s, error);
  if (status) return status;
  const double start = cpu_seconds();
  dls_forming_get(forming, &d);
  for (int step = 1; step <= d.steps && !status; step++) {
    status = dls_forming_step(forming, error);
    dls_forming_get(forming, &d);
    if (!status && show_step(&d, step)) status = DLS_CANCELLED;
    if (!status && step < d.steps && cpu_seconds() - start > limit) status = DLS_TIME_LIMIT;
  }
  *w = (walk){status, d.travel / d.whole, cpu_seconds() - start};
  progress_end();
  dls_forming_destroy(forming);
  return status < 0 ? status : DLS_OK;
}

/* Sets the cell of a walk: finished, out of time, stalled, or stopped for another reason, which is
 * named. */
static void show_walk(map_cell *cell, const walk *w) {
  const ending e = w->status == DLS_OK           ? ENDED_SOLVED
                   : w->status == DLS_TIME_LIMIT ? ENDED_TIME
                   : w->status == DLS_STALLED    ? ENDED_STALLED
                                                 : ENDED_LIKELY_NONE;
  map_verdict(cell, e, 1);
  if (e == ENDED_SOLVED)
    (void)snprintf(cell->text, sizeof cell->text, "%.2g s", w->seconds);
  else
    (void)snprintf(cell->text, sizeof cell->text, "%s %.0f %%",
                   e == ENDED_TIME      ? "time"
                   : e == ENDED_STALLED ? "at"
                                        : status_word(w->status),
                   floor(100 * w->part));
}

/* Sets column j: a number of steps, or a mesh. */
static void set_column(map_picture *p, int j, int mesh, const dls_forming_data *own,
                       dls_forming_settings *s) {
  const double factor = pow(2, mesh ? j - 3 : j - 5); /* of the scene's own */
  if (!mesh) {
    s->steps = (int)fmax(1, round(own->steps * factor));
    (void)snprintf(p->column[j], MAP_NAME, "%d", s->steps);
    return;
  }
  /* nx <= ny from (nx + 1) (ny + 1) nodes and nx ny elements */
  const int sum = own->mesh->nodes - own->mesh->quads - 1;
  const double apart = sqrt(fmax(0, (double)sum * sum - 4.0 * own->mesh->quads));
  s->nx = (int)fmax(2, round((sum - apart) / 2 * factor));
  s->ny = (int)fmax(2, round((sum + apart) / 2 * factor));
  (void)snprintf(p->column[j], MAP_NAME, "%dx%d", s->nx, s->ny);
}

static dls_status fill_walks(map_picture *p, const char *name, const map_options *o, int mesh,
                             int *all_done, dls_error *error) {
  dls_forming *forming;
  dls_forming_data own;
  dls_forming_settings s;
  dls_forming_settings_init(&s);
  if (!forming_method(o->method, &s)) {
    *error = (dls_error){.status = DLS_E_ARGUMENT, .message = "--method: no such method"};
    return DLS_E_ARGUMENT;
  }
  dls_status status = dls_forming_create(&forming, name, &s, error);
  if (status) return status;
  dls_forming_get(forming, &own);
  FILE *csv = open_in(o->out, "map.csv");
  if (csv) fprintf(csv, "mu,%s,status,part,cpu_s\n", mesh ? "mesh" : "steps");
  double mu[MAP_ROWS];
  spread_friction(o->from, o->to < 0 ? 1 : o->to, p->rows, mu);
  *all_done = csv != NULL;
  for (int i = 0; i < p->rows; i++)
    (void)snprintf(p->row[i], MAP_NAME, "%.2g", mu[i]);
  for (int j = 0; j < p->columns && csv && !status; j++) {
    set_column(p, j, mesh, &own, &s);
    for (int i = 0; i < p->rows && !status && !was_interrupted(); i++) {
      walk w;
      s.mu = mu[i];
      status = walk_forming(name, &s, o->limit < 0 ? scene_limit : o->limit, &w, error);
      if (status || was_interrupted()) continue;
      show_walk(map_at(p, 0, i, j), &w);
      *all_done &= w.status == DLS_OK;
      fprintf(csv, "%.9g,%s,%s,%.4f,%.4f\n", mu[i], p->column[j], status_word(w.status), w.part,
              w.seconds);
    }
  }
  if (csv && !close_file(csv, "map.csv")) *all_done = 0;
  dls_forming_destroy(forming);
  return status;
}

int map_forming(const char *name, const map_options *o) {
  const int mesh = o->against != NULL;
  char title[200];
  map_picture p = {.directory = o->out, .title = title, .panels = 1, .columns = STEP_COLUMNS};
  dls_error error = {.status = DLS_E_MEMORY, .message = "out of memory"};
  int all_done = 0, result = EXIT_BAD_INPUT;
  p.rows = o->rows ? o->rows : STEP_ROWS;
  if (p.rows > MAP_ROWS) p.rows = MAP_ROWS;
  p.x = mesh ? "elements" : "steps of the whole way";
  p.y = "friction";
  p.subtitle =
      "blue: finished, CPU seconds; orange: stalled; grey: out of time; red: folded or else";
  (void)snprintf(title, sizeof title, "%s by %s: does it finish?", name, o->method);
  p.cells = calloc((size_t)(p.rows * p.columns), sizeof *p.cells);
  if (!p.cells || !make_directory(o->out) || fill_walks(&p, name, o, mesh, &all_done, &error))
    (void)complain_of(name, &error);
  else
    result = draw_map(&p);
  free(p.cells);
  return result == EXIT_SOLVED && !all_done ? EXIT_NOT_SOLVED : result;
}
