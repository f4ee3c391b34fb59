/*
 * forming.c: delassus scene indentation, extrusion: runs load steps by a method of choice, and
 * writes files.
 *
 *   force.csv     at rest and every step: travel, force, forces of the tools, counts and CPU
 *                 seconds so far
 *   contact.csv   the candidates where --at asks, and at the end
 *   series.pvd    about 50 steps for ParaView, body and tools: step_NNNN.vtu, tools_NNNN.vtu
 *   pressure.dat  every step: travel, position, pressure, shear of the surface
 *   mesh, plastic, pressure, force (.dat or .csv, .gp, .png, .svg)
 */
#define _GNU_SOURCE
#include <errno.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "problem.h"

enum { MOST_AT = 64, VTU_FILES = 50 };

typedef struct forming_options {
  const char *name, *method;
  dls_forming_settings settings;
  double at[MOST_AT];
  int at_count;
  const char *out, *save; /* NULL: none */
} forming_options;

static void forming_usage(FILE *out) {
  char methods[METHOD_LIST_ROOM];
  fprintf(
      out,
      "Usage: delassus scene indentation|extrusion [OPTION]...\n"
      "Runs a forming scene of Chabrand, Dubois and Raous (1998) in load steps. Lengths in mm,\n"
      "forces in N (indentation: half of the block, per mm of thickness; extrusion: per radian).\n"
      "\n"
      "  -m, --method=METHOD   on the condensed problem: %s;\n"
      "                        in the equilibrium loop: augmented-lagrangian, penalty;\n"
      "                        on the displacements: gauss-seidel\n"
      "      --mesh=NXxNY      elements along x and y (20x20; 4x20)\n"
      "  -n, --steps=N         equal steps (100; 300)\n"
      "      --mu=MU           friction (0.2; 0.1)\n"
      "      --clamped         indentation: the bottom sticks to its support\n"
      "      --ram-mu=MU       extrusion: friction at the ram (0)\n"
      "      --penalty=FACTOR  augmented-lagrangian, penalty: springs over stiffness (30; 1000)\n"
      "      --augmentations=N augmented-lagrangian: at most N a step (no limit)\n"
      "      --relaxation=W    gauss-seidel: 0 < W < 2 (1)\n"
      "      --no-aitken       gauss-seidel: plain sweeps\n"
      "  -t, --tol=T           on equilibrium and certificate (1e-9)\n"
      "      --step-tol=T      compare each step with two halves, and halve it until their forces\n"
      "                        differ by at most T of the largest one; prints their sum\n"
      "  -l, --limit=S         CPU seconds of the whole run (none)\n"
      "      --at=D[,D..]      print the state, and write contact.csv, at the end of the step\n"
      "                        that reaches displacement D\n"
      "  -s, --save=FILE       write the last condensed contact problem as an FCLIB file (HDF5)\n"
      "  -o, --out=DIR         write force.csv, contact.csv, series.pvd, pictures\n" PICTURE_USAGE
          LAST_USAGE "\n"
      "A run ends early, with exit status 1, if the next step cannot be solved or leaves no body: "
      "a\n"
      "corner of an element inside out, a node inside a tool, a boundary that crosses itself, "
      "forces\n"
      "or energy that do not balance. It prints where, and writes all steps before.\n",
      method_list(methods, sizeof methods));
}

int forming_method(const char *name, dls_forming_settings *settings) {
  if (!strcmp(name, "gauss-seidel"))
    settings->contact = DLS_FORMING_GAUSS_SEIDEL;
  else if (!strcmp(name, "augmented-lagrangian"))
    settings->contact = DLS_FORMING_AUGMENTED_LAGRANGIAN;
  else if (!strcmp(name, "penalty"))
    settings->contact = DLS_FORMING_PENALTY;
  else
    return dls_method_find(name, &settings->method);
  return 1;
}

/* Counts the candidates that carry a reaction. */
static int count_contacts(const dls_forming_data *data) {
  int count = 0;
  for (int c = 0; c < data->candidates; c++)
    count += data->r[2 * c] > 0;
  return count;
}

int show_step(const dls_forming_data *data, int step) {
  char text[80] = "[....................]";
  memset(text + 1, '#', (size_t)(20 * step / data->steps));
  (void)snprintf(text + 22, sizeof text - 22, " %d Newton steps, %d in contact, step",
                 data->count.newton, count_contacts(data));
  const dls_progress progress = {
      .stage = text, .iteration = step, .max_iterations = data->steps, .residual = -1};
  return show_progress(NULL, &progress);
}

int stop_step(void *unused, const dls_progress *progress) {
  (void)unused;
  (void)progress;
  return was_interrupted();
}

/* ---- files of a step ------------------------------------------------------------------------ */

typedef struct outputs {
  FILE *force, *contact, *pressure; /* NULL: not wanted */
  dls_fe_series *series;
  double start;
} outputs;

static void print_state(const dls_forming_data *d) {
  double strain = 0;
  for (int k = 0; k < 4 * d->mesh->quads; k++)
    if (d->plastic_strain[k] > strain) strain = d->plastic_strain[k];
  printf("%10.4f  %12.6g  %8d  %10.4f  %9.1e  %9.1e\n", d->travel, d->force, count_contacts(d),
         strain, d->equilibrium, d->certificate.residual);
}

static void write_contacts(FILE *file, const dls_forming_data *d) {
  for (int c = 0; c < d->candidates; c++) {
    const int node = d->candidate_node[c];
    fprintf(file, "%.10g,%d", d->travel, c + 1);
    for (int i = 0; i < 2; i++)
      fprintf(file, ",%.17g", d->mesh->xy[2 * node + i] + d->displacement[2 * node + i]);
    fprintf(file, ",%.17g,%.17g,%.17g,%.17g,%.17g,%.17g\n", d->normal[2 * c], d->normal[2 * c + 1],
            d->u[2 * c], d->u[2 * c + 1], d->r[2 * c], d->r[2 * c + 1]);
  }
}

/* Returns the word for the way that solved a step. */
static const char *way_word(dls_forming_way way) {
  static const char *const words[] = {
      [DLS_FORMING_ON_K] = "newton-on-K",
      [DLS_FORMING_ON_W] = "auto-on-W",
      [DLS_FORMING_BY_LEMKE] = "lemke",
      [DLS_FORMING_BY_METHOD] = "method",
  };
  return words[way];
}

/* Writes a row of force.csv; by: in, the word for what solved the step. */
static void write_force(const outputs *o, const dls_forming_data *d, const char *by) {
  fprintf(o->force, "%.10g,%.17g,%d,%d,%d,%d,%d,%.3e,%.3e,%.4f,%.4f,%.4f,%.4f,%.3e,%s", d->travel,
          d->force, count_contacts(d), d->count.newton, d->count.frames, d->count.iterations,
          d->count.halvings, d->equilibrium, d->certificate.residual, d->cpu.assembly,
          d->cpu.reduction, d->cpu.contact, cpu_seconds() - o->start, d->balance, by);
  for (int k = 0; k < d->tools; k++)
    fprintf(o->force, ",%.9g,%.9g", d->tool[k].force[0], d->tool[k].force[1]);
  fputc('\n', o->force);
}

static int open_outputs(outputs *o, const char *directory, const dls_forming_data *d) {
  if (!(o->force = open_growing(directory, "force.csv", "")) ||
      !(o->contact = open_growing(directory, "contact.csv",
                                  "travel,candidate_from_0,x,y,n_x,n_y,gap,slip,rn,rt\n")) ||
      !(o->series = open_series(directory)) || !(o->pressure = open_in(directory, "pressure.dat")))
    return 0;
  fputs("travel,force,contacts,newton,frames,iterations,halvings,equilibrium,residual,"
        "assembly_cpu,reduction_cpu,contact_cpu,total_cpu,balance,by",
        o->force);
  for (int k = 0; k < d->tools; k++)
    fprintf(o->force, ",%s_x,%s_y", d->tool[k].name, d->tool[k].name);
  fputc('\n', o->force);
  write_force(o, d, "rest");
  return 1;
}

/* Writes the rows and files of a step. asked: 1 if the step reaches a displacement of --at. */
static int write_step(const outputs *o, const forming_options *options, const dls_forming *forming,
                      int step, int asked) {
  dls_forming_data d;
  dls_forming_get(forming, &d);
  write_force(o, &d, way_word(d.way));
  write_pressures(o->pressure, &d);
  if (asked) write_contacts(o->contact, &d);
  if (fflush(o->force) || fflush(o->contact))
    return refuse("%s: force.csv, contact.csv: %s", options->out, strerror(errno));
  const int every = (d.steps + VTU_FILES - 1) / VTU_FILES;
  if (step % every && !asked) return 1;
  static dls_status (*const write[])(const dls_forming *, const char *, dls_error *) = {
      dls_forming_write_vtu, dls_forming_write_tools};
  for (int part = 0; part < 2; part++) {
    char name[40], path[PATH_ROOM];
    dls_error error = {0};
    (void)snprintf(name, sizeof name, "%s_%04d.vtu", part ? "tools" : "step", step);
    if (!join_path(path, options->out, name)) return 0;
    if (write[part](forming, path, &error) ||
        dls_fe_series_add(o->series, d.travel, part, name, &error))
      return complain_of(path, &error), 0;
  }
  return 1;
}

/* ---- the run --------------------------------------------------------------------------------- */

static void print_forming_summary(const forming_options *o, const dls_forming_data *d,
                                  dls_status status, double seconds) {
  const dls_forming_energy *e = &d->energy;
  printf("\n%s by %s: %s at %.6g of %.6g mm\n", o->name, o->method, dls_status_text(status),
         d->travel, d->whole);
  if (d->fault.kind && status > 0)
    printf("refused at %.6g of %.6g mm: %s\n", d->fault.travel, d->whole, d->fault.text);
  printf("%d step%s, %d halved; %d frame update%s, %d Newton step%s, %d condensation%s, "
         "%d iteration%s of the method\n",
         d->count.parts, plural(d->count.parts), d->count.halvings, d->count.frames,
         plural(d->count.frames), d->count.newton, plural(d->count.newton), d->count.reductions,
         plural(d->count.reductions), d->count.iterations, plural(d->count.iterations));
  if (d->count.handed)
    printf("%d step%s solved by another method than Newton's on K\n", d->count.handed,
           plural(d->count.handed));
  printf("forces on the body [N]:");
  const char *comma = "";
  for (int k = 0; k < d->tools; k++) {
    if (d->axisymmetric && d->tool[k].force[1] != 0)
      printf("%s %s %.6g", comma, d->tool[k].name, d->tool[k].force[1]);
    else if (!d->axisymmetric)
      printf("%s %s (%.6g, %.6g)", comma, d->tool[k].name, d->tool[k].force[0],
             d->tool[k].force[1]);
    else
      continue;
    comma = ",";
  }
  printf("; sum over sizes %.1e, worst %.1e\n", d->balance, d->worst_balance);
  printf("worst equilibrium %.1e, worst residual %.1e\n", d->worst_equilibrium, d->worst_residual);
  if (o->settings.step_tol > 0)
    printf("error of the force by halved steps %.2g, %.1e of the force\n", d->step_error,
           d->step_error / d->force);
  printf("work %.6g = elastic %.6g + plastic %.6g + friction %.6g, to %.2g %%\n", e->external,
         e->elastic, e->plastic, e->friction,
         100 * fabs(e->elastic + e->plastic + e->friction - e->external) / e->external);
  printf("CPU %.2f s: assembly %.2f, factorisation and condensation %.2f, contact %.2f\n", seconds,
         d->cpu.assembly, d->cpu.reduction, d->cpu.contact);
}

static void print_json_fault(FILE *out, const dls_forming_fault *fault) {
  fprintf(out, ",\n  \"refused\": {\"element\": %d, \"corner\": %d, \"node\": %d", fault->element,
          fault->corner, fault->node);
  fputs(", \"travel\": ", out);
  print_json_number(out, fault->travel);
  fputs(", \"value\": ", out);
  print_json_number(out, fault->value);
  fputs(", \"reason\": ", out);
  print_json_string(out, fault->text);
  fputs("}", out);
}

static void print_forming_json(const forming_options *o, const dls_forming_data *d,
                               dls_status status, double seconds) {
  FILE *out = stdout;
  fputs("{\n  \"scene\": ", out);
  print_json_string(out, o->name);
  fputs(",\n  \"method\": ", out);
  print_json_string(out, o->method);
  fprintf(out, ",\n  \"status\": \"%s\",\n  \"elements\": %d,\n  \"contacts\": %d",
          status_word(status), d->mesh->quads, count_contacts(d));
  print_json_field(out, "travel", d->travel);
  print_json_field(out, "whole", d->whole);
  print_json_field(out, "force", d->force);
  print_json_field(out, "balance", d->balance);
  print_json_field(out, "worst_balance", d->worst_balance);
  print_json_field(out, "worst_equilibrium", d->worst_equilibrium);
  print_json_field(out, "worst_residual", d->worst_residual);
  if (o->settings.step_tol > 0) print_json_field(out, "step_error", d->step_error);
  fprintf(out,
          ",\n  \"steps\": %d,\n  \"halved\": %d,\n  \"handed_on\": %d,\n  \"compared\": %d,\n"
          "  \"frames\": %d,\n  \"newton_steps\": %d,\n  \"condensations\": %d,\n"
          "  \"iterations\": %d",
          d->count.parts, d->count.halvings, d->count.handed, d->count.compared, d->count.frames,
          d->count.newton, d->count.reductions, d->count.iterations);
  print_json_field(out, "work", d->energy.external);
  print_json_field(out, "elastic", d->energy.elastic);
  print_json_field(out, "plastic", d->energy.plastic);
  print_json_field(out, "friction", d->energy.friction);
  fputs(",\n  \"tools\": [", out);
  for (int k = 0; k < d->tools; k++) {
    fprintf(out, "%s\n    {\"name\": \"%s\", ", k ? "," : "", d->tool[k].name);
    print_json_numbers(out, "\"force\"", 2, d->tool[k].force);
    fputs("}", out);
  }
  fputs("]", out);
  if (d->fault.kind && status > 0) print_json_fault(out, &d->fault);
  print_json_field(out, "cpu_seconds", seconds);
  fputs("\n}\n", out);
}

/* Runs all steps. *status: of the last one. Returns 0 after a complaint. */
static int run_steps(dls_forming *forming, const forming_options *o, outputs *out,
                     dls_status *status) {
  dls_forming_data d;
  dls_error error = {0};
  dls_forming_get(forming, &d);
  if (prints_text()) puts("    travel         force  contacts  max strain  equilibr.   residual");
  for (int step = 1; step <= d.steps; step++) {
    const double before = d.travel;
    *status = dls_forming_step(forming, &error);
    if (*status < 0) return complain_of(o->name, &error), 0;
    dls_forming_get(forming, &d);
    const double blur = 1e-9 * d.whole;
    int asked = *status || step == d.steps;
    for (int k = 0; k < o->at_count; k++)
      asked |= o->at[k] > before + blur && o->at[k] <= d.travel + blur;
    const int stop = show_step(&d, step);
    if (asked || stop) {
      progress_end();
      if (prints_text()) print_state(&d);
    }
    if (out->force && !write_step(out, o, forming, step, asked || stop)) return 0;
    if (stop && !*status) *status = DLS_CANCELLED;
    if (*status) break;
  }
  progress_end();
  return 1;
}

static int run_forming(const forming_options *o) {
  dls_forming *forming;
  dls_error error = {0};
  outputs out = {.start = cpu_seconds()};
  if (dls_forming_create(&forming, o->name, &o->settings, &error))
    return complain_of(o->name, &error);
  dls_status status = DLS_OK;
  int result = EXIT_BAD_INPUT;
  dls_forming_data first;
  dls_forming_get(forming, &first);
  if (!o->out || (take_folder(o->out, "scene", o->name) && open_outputs(&out, o->out, &first)))
    if (run_steps(forming, o, &out, &status)) {
      dls_forming_data d;
      dls_forming_get(forming, &d);
      const double seconds = cpu_seconds() - out.start;
      if (is_json())
        print_forming_json(o, &d, status, seconds);
      else if (!is_quiet())
        print_forming_summary(o, &d, status, seconds);
      if (out.force && status)
        fprintf(out.force, "# %s at %.6g of %.6g mm\n", dls_status_text(status), d.travel, d.whole);
      result = status ? EXIT_NOT_SOLVED : EXIT_SOLVED;
    }
  if (result == EXIT_BAD_INPUT) keep_tables(); /* its steps may be hours of work */
  if (!close_series(out.series) || !close_files()) result = EXIT_BAD_INPUT;
  if (o->save && result != EXIT_BAD_INPUT) {
    dls_contact last;
    if (dls_forming_problem(forming, &last, &error) ||
        dls_fclib_write_local(o->save, &last, o->name, NULL, NULL, &error))
      result = complain_of(o->save, &error);
  }
  if (o->out && result != EXIT_BAD_INPUT) {
    dls_forming_data d;
    char title[128];
    dls_forming_get(forming, &d);
    (void)snprintf(title, sizeof title, "%s by %s, %s%s%.6g mm", o->name, o->method,
                   status ? status_word(status) : "", status ? " at " : "", d.travel);
    const dls_forming_settings *own = &o->settings;
    const int as_is =
        !own->nx && !own->ny && own->mu < 0 && !own->steps && !own->clamped && own->ram_mu == 0;
    if (draw_forming(o->out, title, &d, as_is) != EXIT_SOLVED) result = EXIT_BAD_INPUT;
  }
  if (result != EXIT_BAD_INPUT && !is_json()) print_ending(status, NULL);
  dls_forming_destroy(forming);
  return result;
}

/* ---- the command ----------------------------------------------------------------------------- */

/* Reads numbers between commas, overwriting text. */
static taken parse_at(char *text, forming_options *o) {
  for (char *item; (item = strsep(&text, ","));) {
    if (o->at_count == MOST_AT)
      return complain("--at: more than %d displacements", MOST_AT), OPTION_WRONG;
    if (!parse_number("at", item, &o->at[o->at_count++])) return OPTION_WRONG;
  }
  return OPTION_TAKEN;
}

static const char *const equilibrium_methods[] = {"gauss-seidel", "augmented-lagrangian", "penalty",
                                                  NULL};

enum { KEY_NO_AITKEN = 256, KEY_AT };

static taken take_forming_option(int key, const char *text, void *data) {
  forming_options *o = data;
  if (key == KEY_AT) return parse_at(optarg, o);
  if (key == KEY_NO_AITKEN) return o->settings.aitken = 0, OPTION_TAKEN;
  o->method = text;
  if (forming_method(text, &o->settings)) return OPTION_TAKEN;
  return no_method(text, equilibrium_methods);
}

int command_forming(int argc, char **argv) {
  static const option_row options[] = {
      VALUE("method", 'm'),
      ROW(A_MESH, "mesh", 0, forming_options, settings.nx),
      ROW(A_COUNT, "steps", 'n', forming_options, settings.steps),
      ROW(A_NUMBER, "mu", 0, forming_options, settings.mu),
      ROW(A_FLAG, "clamped", 0, forming_options, settings.clamped),
      ROW(A_NUMBER, "tol", 't', forming_options, settings.tol),
      VALUE("at", KEY_AT),
      ROW(A_TEXT, "out", 'o', forming_options, out),
      PICTURE_OPTION,
      ROW(A_NUMBER, "penalty", 0, forming_options, settings.penalty),
      ROW(A_COUNT, "augmentations", 0, forming_options, settings.augmentations),
      ROW(A_NUMBER, "relaxation", 0, forming_options, settings.relaxation),
      FLAG("no-aitken", KEY_NO_AITKEN),
      ROW(A_NUMBER, "ram-mu", 0, forming_options, settings.ram_mu),
      ROW(A_NUMBER, "step-tol", 0, forming_options, settings.step_tol),
      ROW(A_TEXT, "save", 's', forming_options, save),
      ROW(A_NUMBER, "limit", 'l', forming_options, settings.cpu_seconds),
      LAST_OPTIONS};
  static const command forming = {options, forming_usage, take_forming_option, 1};
  forming_options o = {.method = "auto"};
  dls_forming_settings_init(&o.settings);
  o.settings.progress = stop_step;
  if (!forming_method(o.method, &o.settings)) o.method = dls_method_name(o.settings.method);
  const int stop = take_options(argc, argv, &forming, &o);
  if (stop != GO_ON) return stop;
  o.name = argv[optind];
  watch_interrupt();
  return run_forming(&o);
}
