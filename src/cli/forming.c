/*
 * forming.c: delassus scene indentation, extrusion: runs load steps by a method of choice, and
 * writes files.
 *
 *   force.csv     every step: travel, force, counts and CPU seconds so far
 *   contact.csv   the candidates where --at asks, and at the end
 *   series.pvd    about 50 steps for ParaView, step_NNNN.vtu
 *   mesh, plastic, force (.dat or .csv, .gp, .png, .svg)
 */
#define _GNU_SOURCE
#include <errno.h>
#include <getopt.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "cli.h"

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
      "  -t, --tol=T           on equilibrium and certificate (1e-9)\n"
      "      --at=D[,D..]      print the state, and write contact.csv, at the end of the step\n"
      "                        that reaches displacement D\n"
      "  -s, --save=FILE       write the last condensed contact problem as an FCLIB file (HDF5)\n"
      "  -o, --out=DIR         write force.csv, contact.csv, series.pvd, pictures\n"
      "  -h, --help            this text\n",
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

int names_forming(int argc, char **argv) {
  for (int k = 1; k < argc; k++)
    for (int i = 0; dls_forming_name(i); i++)
      if (!strcmp(argv[k], dls_forming_name(i))) return 1;
  return 0;
}

int count_contacts(const dls_forming_data *data) {
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

/* ---- files of a step ------------------------------------------------------------------------ */

typedef struct outputs {
  FILE *force, *contact; /* NULL: not wanted */
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

static int open_outputs(outputs *o, const char *directory) {
  if (!make_directory(directory) || !(o->force = open_in(directory, "force.csv")) ||
      !(o->contact = open_in(directory, "contact.csv")) || !(o->series = open_series(directory)))
    return 0;
  fputs("travel,force,contacts,newton,frames,iterations,halvings,equilibrium,residual,"
        "assembly_cpu,reduction_cpu,contact_cpu,total_cpu\n",
        o->force);
  fputs("travel,candidate,x,y,n_x,n_y,gap,slip,rn,rt\n", o->contact);
  return 1;
}

/* Returns 1 if all was written. */
static int close_outputs(outputs *o) {
  int good = 1;
  if (o->force) good &= close_file(o->force, "force.csv");
  if (o->contact) good &= close_file(o->contact, "contact.csv");
  return close_series(o->series) && good;
}

/* Writes the rows and files of a step. asked: 1 if the step reaches a displacement of --at. */
static int write_step(const outputs *o, const forming_options *options, const dls_forming *forming,
                      int step, int asked) {
  dls_forming_data d;
  dls_forming_get(forming, &d);
  fprintf(o->force, "%.10g,%.17g,%d,%d,%d,%d,%d,%.3e,%.3e,%.4f,%.4f,%.4f,%.4f\n", d.travel, d.force,
          count_contacts(&d), d.count.newton, d.count.frames, d.count.iterations, d.count.halvings,
          d.equilibrium, d.certificate.residual, d.cpu.assembly, d.cpu.reduction, d.cpu.contact,
          cpu_seconds() - o->start);
  if (asked) write_contacts(o->contact, &d);
  const int every = (d.steps + VTU_FILES - 1) / VTU_FILES;
  if (step % every && !asked) return 1;
  char name[40], path[PATH_ROOM];
  dls_error error = {0};
  (void)snprintf(name, sizeof name, "step_%04d.vtu", step);
  if (!join_path(path, options->out, name)) return 0;
  if (dls_forming_write_vtu(forming, path, &error) ||
      dls_fe_series_add(o->series, d.travel, name, &error))
    return complain_of(path, &error), 0;
  return 1;
}

/* ---- the run --------------------------------------------------------------------------------- */

static void print_forming_summary(const forming_options *o, const dls_forming_data *d,
                                  dls_status status, double seconds) {
  const dls_forming_energy *e = &d->energy;
  printf("\n%s by %s: %s at %.6g of %.6g mm\n", o->name, o->method, dls_status_text(status),
         d->travel, d->whole);
  if (d->fault.kind && status > 0)
    printf("refused at %.6g mm: %s\n", d->fault.travel, d->fault.text);
  printf("%d steps, %d halved; %d frame updates, %d Newton steps, %d condensations, %d iterations "
         "of the method\n",
         d->count.parts, d->count.halvings, d->count.frames, d->count.newton, d->count.reductions,
         d->count.iterations);
  printf("worst equilibrium %.1e, worst residual %.1e\n", d->worst_equilibrium, d->worst_residual);
  printf("work %.6g = elastic %.6g + plastic %.6g + friction %.6g, to %.2g %%\n", e->external,
         e->elastic, e->plastic, e->friction,
         100 * fabs(e->elastic + e->plastic + e->friction - e->external) / e->external);
  printf("CPU %.2f s: assembly %.2f, factorisation and condensation %.2f, contact %.2f\n", seconds,
         d->cpu.assembly, d->cpu.reduction, d->cpu.contact);
}

/* Runs all steps. *status: of the last one. Returns 0 after a complaint. */
static int run_steps(dls_forming *forming, const forming_options *o, outputs *out,
                     dls_status *status) {
  dls_forming_data d;
  dls_error error = {0};
  dls_forming_get(forming, &d);
  puts("    travel         force  contacts  max strain  equilibr.   residual");
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
      print_state(&d);
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
  if (!o->out || open_outputs(&out, o->out))
    if (run_steps(forming, o, &out, &status)) {
      dls_forming_data d;
      dls_forming_get(forming, &d);
      print_forming_summary(o, &d, status, cpu_seconds() - out.start);
      result = status ? EXIT_NOT_SOLVED : EXIT_SOLVED;
    }
  if (!close_outputs(&out)) result = EXIT_BAD_INPUT;
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
    (void)snprintf(title, sizeof title, "%s by %s, %.6g mm", o->name, o->method, d.travel);
    if (draw_forming(o->out, title, &d) != EXIT_SOLVED) result = EXIT_BAD_INPUT;
  }
  if (result != EXIT_BAD_INPUT) print_ending(status);
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

static taken take_forming_option(int key, const char *text, void *data) {
  forming_options *o = data;
  switch (key) {
  case 'm':
    o->method = text;
    if (forming_method(text, &o->settings)) return OPTION_TAKEN;
    complain("--method: '%s' is no method", text);
    return OPTION_WRONG;
  case 'M':
    return parse_mesh(text, &o->settings.nx, &o->settings.ny);
  case 'n':
    return parse_count("steps", text, &o->settings.steps);
  case 'f':
    return parse_number("mu", text, &o->settings.mu);
  case 'c':
    o->settings.clamped = 1;
    return OPTION_TAKEN;
  case 't':
    return parse_number("tol", text, &o->settings.tol);
  case 'a':
    return parse_at(optarg, o);
  case 'o':
    o->out = text;
    return OPTION_TAKEN;
  case 's':
    o->save = text;
    return OPTION_TAKEN;
  default:
    return OPTION_UNKNOWN;
  }
}

int command_forming(int argc, char **argv) {
  static const struct option options[] = {
      VALUE("method", 'm'), VALUE("mesh", 'M'), VALUE("steps", 'n'), VALUE("mu", 'f'),
      FLAG("clamped", 'c'), VALUE("tol", 't'),  VALUE("at", 'a'),    VALUE("save", 's'),
      VALUE("out", 'o'),    LAST_OPTIONS};
  static const command forming = {"m:n:t:s:o:h", options, forming_usage, take_forming_option, 1};
  forming_options o = {.method = "auto"};
  dls_forming_settings_init(&o.settings);
  if (!forming_method(o.method, &o.settings)) o.method = dls_method_name(o.settings.method);
  const int stop = take_options(argc, argv, &forming, &o);
  if (stop != GO_ON) return stop;
  o.name = argv[optind];
  watch_interrupt();
  return run_forming(&o);
}
