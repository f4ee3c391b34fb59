/*
 * moving.c: delassus scene bar-impact, jean-moving, two-blocks, ...: runs bodies that move, step by
 * step, and writes files.
 *
 *   energy.csv    every step: energies, works, how well they balance
 *   contact.csv   every step, each candidate: t, candidate, r_n, r_t, u_n, u_t, state
 *   series.pvd    about 50 steps for ParaView, step_NNNN.vtu
 *   energy, map or bar, loop (.dat, .gp, .png, .svg)
 */
#include <errno.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "problem.h"

enum { SERIES_FILES = 50, MAP_COLUMNS = 400 };

typedef struct moving_options {
  const char *name;
  dls_moving_settings settings;
  const char *out; /* NULL: none */
} moving_options;

static void moving_usage(FILE *out) {
  char methods[METHOD_LIST_ROOM];
  fputs("Usage: delassus scene SCENE [OPTION]...\nRuns a scene of bodies that move:\n\n", out);
  for (int k = 0; dls_moving_name(k); k++)
    fprintf(out, "  %-13s %s\n", dls_moving_name(k), dls_moving_description(k));
  fputs("\n", out);
  fprintf(
      out,
      "      --law=LAW         velocity: impacts, a contact is active when it is closed;\n"
      "                        gap: no penetration at the end of a step; path: equilibria, no\n"
      "                        mass (velocity; jean-moving, two-blocks: path)\n"
      "      --theta=T         of the scheme, .5 to 1 (velocity: .5; gap: 1)\n"
      "      --mass=KIND       consistent or lumped (bar-bounce: lumped; else consistent)\n"
      "      --e=E             restitution of the velocity form, 0 to 1 (0)\n"
      "      --courant=NU      bars: steps of NU l / c (0.9)\n"
      "  -n, --steps=N         equal steps of the whole time, instead of --courant\n"
      "      --mesh=N|NXxNY    elements along the bar (100); along x and y (16x8; jean-moving has\n"
      "                        no other)\n"
      "      --upper=N         two-blocks: elements of the upper block along x (11)\n"
      "      --mu=MU           friction (0; jean-moving 1, jean-moving4 .1, block-drop .3,\n"
      "                        two-blocks .25)\n"
      "      --amplitude=A     jean-moving: amplitude of the obstacle (1e-5 m)\n"
      "      --frequency=F     jean-moving: cycles per unit of time (path: 1; else 1000)\n"
      "  -m, --method=METHOD   for the contact problems: %s\n"
      "  -t, --tol=T           on their certificates (1e-12)\n"
      "  -o, --out=DIR         write energy.csv, contact.csv, series.pvd, pictures\n" PICTURE_USAGE
          LAST_USAGE "\nCtrl-C ends the run after the step; what was computed is written.\n",
      method_list(methods, sizeof methods));
}

/* ---- options --------------------------------------------------------------------------------- */

static const char *const law_names[] = {"velocity", "gap", "path"}; /* from 1 */
static const char *const mass_names[] = {"consistent", "lumped"};   /* from 1 */

static taken moving_mesh(const char *text, dls_moving_settings *s) {
  if (read_mesh(text, &s->nx, &s->ny)) return OPTION_TAKEN;
  return (taken)refuse("--mesh: '%s' is neither N nor NXxNY, whole numbers >= 1", text);
}

enum { KEY_LAW = 300, KEY_MASS, KEY_THETA, KEY_MESH };

static taken take_moving_option(int key, const char *text, void *data) {
  dls_moving_settings *s = &((moving_options *)data)->settings;
  int word;
  switch (key) {
  case KEY_LAW:
    word = 1 + parse_word("law", text, law_names, 3);
    s->law = (dls_motion_law)word;
    return word ? OPTION_TAKEN : OPTION_WRONG;
  case KEY_MASS:
    word = 1 + parse_word("mass", text, mass_names, 2);
    s->mass = (dls_fe_mass_kind)word;
    return word ? OPTION_TAKEN : OPTION_WRONG;
  case KEY_THETA:
    if (!parse_number("theta", text, &s->theta)) return OPTION_WRONG;
    if (s->theta >= 0.5 && s->theta <= 1) return OPTION_TAKEN;
    return (taken)refuse("--theta: '%s' is not in .5 .. 1", text);
  case KEY_MESH:
    return moving_mesh(text, s);
  default: /* m */
    return dls_method_find(text, &s->method) ? OPTION_TAKEN : no_method(text, NULL);
  }
}

/* ---- files of a step ------------------------------------------------------------------------- */

typedef struct moving_files {
  FILE *energy, *contact, *map, *bar, *loop; /* NULL: not wanted */
  dls_fe_series *series;
} moving_files;

/* The worst of all steps. */
typedef struct moving_worst {
  double residual, momentum; /* of the identity of energies over its scale; of momentum */
} moving_worst;

/* Returns 1 if two nodes of the mesh are neighbours on a horizontal line of the lattice. */
static int surface_joins(const dls_fe_mesh *mesh, int left, int right) {
  return left >= 0 && right < mesh->nodes && mesh->xy[2 * left + 1] == mesh->xy[2 * right + 1] &&
         mesh->xy[2 * left] < mesh->xy[2 * right];
}

/* Returns the length of the surface that belongs to candidate c: half way to both neighbours. */
static double surface_part(const dls_moving_data *d, int c) {
  const int node = d->candidate_node[c];
  const double *xy = d->mesh->xy;
  double part = 0;
  if (surface_joins(d->mesh, node - 1, node)) part += (xy[2 * node] - xy[2 * node - 2]) / 2;
  if (surface_joins(d->mesh, node, node + 1)) part += (xy[2 * node + 2] - xy[2 * node]) / 2;
  return part;
}

static int moving_open(moving_files *f, const char *directory, const dls_moving_data *d) {
  f->energy = open_growing(
      directory, "energy.csv",
      "t,kinetic,elastic,load,damping,obstacle,friction,impact,numerical,created,balance\n");
  if (f->energy)
    f->contact =
        open_growing(directory, "contact.csv", "t,candidate_from_0,r_n,r_t,u_n,u_t,state\n");
  if (!f->contact || !(f->series = open_series(directory))) return 0;
  if (d->has_exact)
    f->bar = open_growing(directory, "bar.dat", "# t gap exact_gap force exact_force\n");
  else
    f->map =
        open_growing(directory, "map.dat", "# t x r_n/length state(0 free, 1 slip, 2 stick)\n");
  if (d->obstacle_moves)
    f->loop =
        open_growing(directory, "loop.dat", "# obstacle sum_of_r_t; a blank line between cycles\n");
  return (f->bar || f->map) && (f->loop || !d->obstacle_moves);
}

static void write_energy(FILE *file, const dls_moving_data *d) {
  const dls_motion_energies *e = &d->energy;
  const double work = e->load + e->damping + e->obstacle + e->friction + e->impact + e->numerical;
  fprintf(file, "%.10g,%.17g,%.17g,%.17g,%.17g,%.17g,%.17g,%.17g,%.17g,%.17g,%.17g\n", d->state.t,
          e->kinetic, e->elastic, e->load, e->damping, e->obstacle, e->friction, e->impact,
          e->numerical, e->created, e->kinetic + e->elastic - work);
}

static void write_contact(const moving_files *f, const dls_moving_data *d) {
  const int every = (d->steps + MAP_COLUMNS - 1) / MAP_COLUMNS;
  const double *u = d->state.u, t = d->state.t;
  double sum = 0;
  for (int c = 0; c < d->candidates; c++) {
    const dls_contact_state state = d->state.state[c];
    fprintf(f->contact, "%.10g,%d,%.17g,%.17g,%.17g,%.17g,%s\n", t, c + 1, d->r[2 * c],
            d->r[2 * c + 1], u[2 * c], u[2 * c + 1], state_word(state));
    if (f->map && d->step % every == 0)
      fprintf(f->map, "%.9g %.9g %.9g %d\n", t, d->mesh->xy[2 * d->candidate_node[c]],
              d->r[2 * c] / surface_part(d, c), (int)state);
    sum += d->r[2 * c + 1];
  }
  if (f->bar)
    fprintf(f->bar, "%.9g %.9g %.9g %.9g %.9g\n", t, d->state.gap[0], d->exact_gap, d->r[0],
            d->exact_force);
  if (f->loop) fprintf(f->loop, "%.9g %.9g\n", d->obstacle, sum);
  if (f->loop && d->step % d->cycle == 0) /* the next cycle begins where this one ends */
    fprintf(f->loop, "\n\n%.9g %.9g\n", d->obstacle, sum);
}

/* Writes step_NNNN.vtu and its row of series.pvd; returns 0 after a complaint. */
static int write_series(const moving_files *f, const char *directory, const dls_moving_data *d) {
  const int elements = d->mesh->triangles + d->mesh->quads;
  char name[40], path[PATH_ROOM];
  dls_error error = {0};
  (void)snprintf(name, sizeof name, "step_%04d.vtu", d->step);
  if (!join_path(path, directory, name)) return 0;
  double *stress = malloc(3 * (size_t)elements * sizeof *stress);
  if (!stress) return refuse("%s: out of memory", path);
  const dls_fe_fields fields = {.displacement = d->displacement,
                                .reaction = d->reaction,
                                .stress = stress,
                                .nu = d->nu,
                                .candidates = d->candidates,
                                .node = d->candidate_node,
                                .state = d->state.state,
                                .gap = d->state.gap,
                                .slip = d->state.slip};
  const int bad = dls_fe_stress(d->mesh, d->E, d->nu, d->displacement, stress, &error) ||
                  dls_fe_write_fields(path, d->mesh, &fields, &error) ||
                  dls_fe_series_add(f->series, d->state.t, 0, name, &error);
  free(stress);
  if (bad) complain_of(path, &error);
  return !bad;
}

static int write_moving_step(const moving_files *f, const char *directory, const dls_moving_data *d,
                             int last) {
  const int every = (d->steps + SERIES_FILES - 1) / SERIES_FILES;
  write_energy(f->energy, d);
  if (d->step > 0) write_contact(f, d);
  if (fflush(f->energy) || fflush(f->contact))
    return refuse("%s: energy.csv, contact.csv: %s", directory, strerror(errno));
  return d->step % every && !last ? 1 : write_series(f, directory, d);
}

/* ---- the run --------------------------------------------------------------------------------- */

static void print_moving_head(const dls_moving_data *d) {
  const dls_moving_settings *s = &d->settings;
  const int elements = d->mesh->triangles + d->mesh->quads;
  printf("%s: ", d->name);
  if (d->dynamic)
    printf("%s form, theta %g, %s mass, e %g, ", law_names[s->law - 1], s->theta,
           mass_names[s->mass - 1], s->restitution);
  else
    printf("path of equilibria, ");
  printf("mu %g, %d %s%s, %d candidate%s, %d step%s of %g\n", s->mu, elements,
         d->mesh->triangles ? "triangle" : "element", plural(elements), d->candidates,
         plural(d->candidates), d->steps, plural(d->steps), d->h);
}

static void print_contact_cost(const dls_moving_data *d) {
  if (d->cold_iterations == 0) return;
  printf("contact problems: %lld iterations in all; the last one of each step from r = 0: %lld, "
         "%.2g %% of the %s of CPU of the steps\n",
         d->iterations, d->cold_iterations, 100 * d->contact_seconds / d->step_seconds,
         in_words(d->step_seconds).text);
}

static void print_moving_summary(const dls_moving_data *d, const moving_worst *worst,
                                 dls_status status) {
  const dls_motion_energies *e = &d->energy;
  printf("%s after %d of %d step%s, t = %g\n", status ? dls_status_text(status) : "finished",
         d->step, d->steps, plural(d->steps), d->state.t);
  printf("energy: %.8g at the start; kinetic %.8g, elastic %.8g\n", d->energy_start, e->kinetic,
         e->elastic);
  printf("works: load %.8g, obstacle %.8g, friction %.8g, impact %.8g, numerical %.8g\n", e->load,
         e->obstacle, e->friction, e->impact, e->numerical);
  if (e->created > 0)
    printf("contact created %.8g: by restitution with friction, or slip that reverses in a step\n",
           e->created);
  printf("balance in the worst step: energy %.1e, momentum %.1e\n", worst->residual,
         worst->momentum);
  if (d->dynamic) printf("impulse: normal %.9g, tangential %.9g\n", d->impulse[0], d->impulse[1]);
  if (d->has_exact)
    printf("gap: L2 error %.4e of the closed form; variation of the force %.6g\n", d->gap_error,
           d->variation);
  print_contact_cost(d);
}

static void print_moving_json(const dls_moving_data *d, const moving_worst *worst,
                              dls_status status) {
  const dls_motion_energies *e = &d->energy;
  print_json_head("scene", status_word(status), NULL);
  fputs(",\n  \"scene\": ", stdout);
  print_json_string(stdout, d->name);
  printf(",\n  \"step\": %d,\n  \"steps\": %d,\n  \"candidates\": %d", d->step, d->steps,
         d->candidates);
  print_json_field(stdout, "t", d->state.t);
  print_json_field(stdout, "mu", d->settings.mu);
  print_json_field(stdout, "energy_start", d->energy_start);
  print_json_field(stdout, "kinetic", e->kinetic);
  print_json_field(stdout, "elastic", e->elastic);
  print_json_field(stdout, "load", e->load);
  print_json_field(stdout, "obstacle", e->obstacle);
  print_json_field(stdout, "friction", e->friction);
  print_json_field(stdout, "impact", e->impact);
  print_json_field(stdout, "numerical", e->numerical);
  print_json_field(stdout, "created", e->created);
  print_json_field(stdout, "balance_energy", worst->residual);
  print_json_field(stdout, "balance_momentum", worst->momentum);
  if (d->dynamic) print_json_field(stdout, "impulse_normal", d->impulse[0]);
  if (d->has_exact) print_json_field(stdout, "gap_error", d->gap_error);
  puts("\n}");
}

int show_moving_step(const dls_moving_data *data) {
  const dls_progress progress = {.method = data->name,
                                 .stage = data->name,
                                 .iteration = data->step,
                                 .max_iterations = data->steps,
                                 .residual = -1};
  return show_progress(NULL, &progress);
}

/* Runs all steps. Returns 0 after a complaint; *status: of the last one. */
static int moving_steps(dls_moving *moving, const moving_options *o, const moving_files *f,
                        moving_worst *worst, dls_status *status) {
  dls_moving_data d;
  dls_error error = {0};
  dls_moving_get(moving, &d);
  if (f->energy && !write_moving_step(f, o->out, &d, 1)) return 0;
  while (d.step < d.steps && !*status) {
    *status = dls_moving_step(moving, &error);
    if (*status < 0) return complain_of(o->name, &error), 0;
    if (*status) break;
    dls_moving_get(moving, &d);
    worst->residual = fmax(worst->residual, d.energy.residual / d.energy.scale);
    worst->momentum = fmax(worst->momentum, d.energy.momentum);
    if (show_moving_step(&d)) *status = DLS_CANCELLED;
    if (f->energy && !write_moving_step(f, o->out, &d, *status || d.step == d.steps)) return 0;
  }
  progress_end();
  return 1;
}

static int run_moving(const moving_options *o) {
  dls_moving *moving;
  dls_moving_data d;
  dls_error error = {0};
  moving_files files = {0};
  moving_worst worst = {0};
  dls_status status = DLS_OK;
  int result = EXIT_BAD_INPUT;
  if (dls_moving_create(&moving, o->name, &o->settings, &error))
    return complain_of(o->name, &error);
  dls_moving_get(moving, &d);
  if (prints_text()) print_moving_head(&d);
  if (!o->out || (take_folder(o->out, "scene", o->name) && moving_open(&files, o->out, &d)))
    if (moving_steps(moving, o, &files, &worst, &status)) {
      dls_moving_get(moving, &d);
      if (is_json())
        print_moving_json(&d, &worst, status);
      else if (!is_quiet())
        print_moving_summary(&d, &worst, status);
      if (files.energy && status)
        fprintf(files.energy, "# %s after %d of %d steps\n", dls_status_text(status), d.step,
                d.steps);
      result = status ? EXIT_NOT_SOLVED : EXIT_SOLVED;
    }
  if (result == EXIT_BAD_INPUT) keep_tables(); /* its steps may be hours of work */
  if (!close_series(files.series) || !close_files()) result = EXIT_BAD_INPUT;
  if (o->out && d.step > 0 && result != EXIT_BAD_INPUT && draw_moving(o->out, &d) != EXIT_SOLVED)
    result = EXIT_BAD_INPUT;
  if (result != EXIT_BAD_INPUT) print_ending(status, NULL);
  dls_moving_destroy(moving);
  return result;
}

/* ---- the command ----------------------------------------------------------------------------- */

int command_moving(int argc, char **argv) {
  static const option_row options[] = {
      VALUE("law", KEY_LAW),
      VALUE("theta", KEY_THETA),
      VALUE("mass", KEY_MASS),
      ROW(A_NUMBER, "e", 0, moving_options, settings.restitution),
      ROW(A_NUMBER, "courant", 0, moving_options, settings.courant),
      ROW(A_COUNT, "steps", 'n', moving_options, settings.steps),
      VALUE("mesh", KEY_MESH),
      ROW(A_COUNT, "upper", 0, moving_options, settings.upper),
      ROW(A_NUMBER, "mu", 0, moving_options, settings.mu),
      ROW(A_NUMBER, "amplitude", 0, moving_options, settings.amplitude),
      ROW(A_NUMBER, "frequency", 0, moving_options, settings.frequency),
      VALUE("method", 'm'),
      ROW(A_NUMBER, "tol", 't', moving_options, settings.limits.tol),
      ROW(A_TEXT, "out", 'o', moving_options, out),
      PICTURE_OPTION,
      LAST_OPTIONS};
  static const command moving = {options, moving_usage, take_moving_option, 1};
  moving_options o = {0};
  dls_moving_settings_init(&o.settings);
  o.settings.measure = 1;
  const int stop = take_options(argc, argv, &moving, &o);
  if (stop != GO_ON) return stop;
  o.name = argv[optind];
  watch_interrupt();
  return run_moving(&o);
}
