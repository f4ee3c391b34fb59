/*
 * converge.c: delassus converge SCENE: runs a scene with a closed form on finer and finer meshes
 * and tells the order at which its error falls.
 *
 * The order over all meshes is the slope of a straight line through the logarithms, least squares.
 */
#define _GNU_SOURCE
#include <getopt.h>
#include <math.h>

#include "cli.h"

enum { MOST_MESHES = 12 };

typedef struct converge_options {
  dls_moving_settings settings;
  int from, meshes;
  const char *out; /* NULL: none */
} converge_options;

static void converge_usage(FILE *out) {
  fputs(
      "Usage: delassus converge SCENE [OPTION]...\n"
      "Runs bar-impact, bar-bounce or bar-fixed on meshes of N, 2 N, 4 N, ... elements and prints\n"
      "the L2 error of the gap relative to the closed form, and its order.\n"
      "\n"
      "      --from=N          elements of the first mesh (25)\n"
      "      --meshes=K        number of meshes, each with twice the elements (5)\n",
      out);
  moving_usage_options(out);
  fputs("  -o, --out=DIR         write converge.csv and a picture\n" LAST_USAGE, out);
}

/* Runs the scene to its end; *status: of the last step. Returns 0 after a complaint. */
static int converge_run(const char *name, const dls_moving_settings *settings, dls_moving_data *d,
                        dls_status *status) {
  dls_moving *moving;
  dls_error error = {0};
  *status = dls_moving_create(&moving, name, settings, &error);
  if (*status) return complain_of(name, &error), 0;
  dls_moving_get(moving, d);
  if (!d->has_exact) {
    complain("%s: has no closed form; bar-impact, bar-bounce and bar-fixed have one", name);
    *status = DLS_E_UNSUPPORTED;
  }
  while (!*status && d->step < d->steps) {
    *status = dls_moving_step(moving, &error);
    if (*status < 0) complain_of(name, &error);
    dls_moving_get(moving, d);
    const dls_progress progress = {.method = name,
                                   .stage = name,
                                   .iteration = d->step,
                                   .max_iterations = d->steps,
                                   .residual = -1};
    if (!*status && show_progress(NULL, &progress)) *status = DLS_CANCELLED;
  }
  progress_end();
  dls_moving_destroy(moving);
  return *status >= 0;
}

/* Returns the order of error = factor h^order, least squares of the logarithms. */
static double converge_fit(const double *h, const double *error, int count, double *factor) {
  double x = 0, y = 0, xx = 0, xy = 0;
  for (int k = 0; k < count; k++) {
    const double a = log(h[k]), b = log(error[k]);
    x += a / count;
    y += b / count;
    xx += a * a / count;
    xy += a * b / count;
  }
  const double order = (xy - x * y) / (xx - x * x);
  *factor = exp(y - order * x);
  return order;
}

static void converge_json(const char *name, dls_status status, int count, int from, const double *h,
                          const double *error) {
  double factor;
  print_json_head("converge", status_word(status), NULL);
  fputs(",\n  \"scene\": ", stdout);
  print_json_string(stdout, name);
  print_json_field(stdout, "order", count > 1 ? converge_fit(h, error, count, &factor) : NAN);
  fputs(",\n  \"rows\": [", stdout);
  for (int k = 0; k < count; k++) {
    printf("%s\n    {\"elements\": %d, \"h\": ", k ? "," : "", from << k);
    print_json_number(stdout, h[k]);
    fputs(", \"error\": ", stdout);
    print_json_number(stdout, error[k]);
    fputc('}', stdout);
  }
  puts("\n  ]\n}");
}

static int converge_scene(const char *name, const converge_options *o) {
  double h[MOST_MESHES], error[MOST_MESHES];
  dls_status status = DLS_OK;
  FILE *csv = NULL;
  if (o->out &&
      (!take_folder(o->out, "converge", name) || !(csv = open_in(o->out, "converge.csv"))))
    return EXIT_BAD_INPUT;
  if (csv) fputs("elements,h,error,order\n", csv);
  int count = 0, good = 1;
  for (; good && !status && count < o->meshes; count++) {
    dls_moving_settings settings = o->settings;
    dls_moving_data d;
    settings.nx = o->from << count;
    good = converge_run(name, &settings, &d, &status);
    if (!good || status) break;
    if (count == 0) tell("elements             h         error   order\n");
    h[count] = d.element;
    error[count] = d.gap_error;
    double factor;
    const double order =
        count > 0 ? converge_fit(h + count - 1, error + count - 1, 2, &factor) : NAN;
    tell("%8d  %12.6g  %12.5e", settings.nx, h[count], error[count]);
    if (count > 0) tell("  %6.3f", order);
    tell("\n");
    if (csv) fprintf(csv, "%d,%.17g,%.17g,%.6g\n", settings.nx, h[count], error[count], order);
    (void)fflush(stdout);
  }
  if (csv) good = good && close_file(csv, "converge.csv");
  if (!good) return EXIT_BAD_INPUT;
  if (count > 1) {
    double factor;
    const double order = converge_fit(h, error, count, &factor);
    tell("observed order %.3f over %d meshes\n", order, count);
    if (o->out && draw_convergence(o->out, name, order, factor) != EXIT_SOLVED)
      return EXIT_BAD_INPUT;
  }
  if (is_json()) converge_json(name, status, count, o->from, h, error);
  print_ending(status, NULL);
  return status ? EXIT_NOT_SOLVED : EXIT_SOLVED;
}

static taken take_converge_option(int key, const char *text, void *data) {
  return take_moving_setting(key, text, &((converge_options *)data)->settings);
}

int command_converge(int argc, char **argv) {
  static const option_row options[] = {ROW(A_COUNT, "from", 0, converge_options, from),
                                       ROW(A_COUNT, "meshes", 0, converge_options, meshes),
                                       MOVING_OPTIONS(converge_options, settings),
                                       ROW(A_TEXT, "out", 'o', converge_options, out),
                                       LAST_OPTIONS};
  static const command converge = {options, converge_usage, take_converge_option, 1};
  converge_options o = {.from = 25, .meshes = 5};
  dls_moving_settings_init(&o.settings);
  const int stop = take_options(argc, argv, &converge, &o);
  if (stop != GO_ON) return stop;
  if (o.meshes > MOST_MESHES || o.from > 100000)
    return complain("at most %d meshes, the first of at most 100000 elements", MOST_MESHES);
  if (kind_among(argc, argv) != SCENE_MOVING) {
    if (kind_of_scene(argv[optind]))
      return complain("%s: has no closed form; bar-impact, bar-bounce and bar-fixed have one",
                      argv[optind]);
    return no_scene(argv[optind]);
  }
  watch_interrupt();
  return converge_scene(argv[optind], &o);
}
