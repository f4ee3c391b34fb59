/* options.c: reads the options of the commands, and those that scene and solve share: the method
 * and its settings. */
#include <limits.h>
#include <string.h>

#include "console.h"

enum { MOST_OPTIONS = 60, ROW_KEYS = 1000 }; /* getopt's value of the long option of a row */

/* Returns the row of getopt's value; NULL for none. */
static const option_row *option_of(const command *c, int value) {
  if (value >= ROW_KEYS) return &c->options[value - ROW_KEYS];
  for (const option_row *row = c->options; row->name; row++)
    if (row->key == value && value) return row;
  return NULL;
}

/* Complains of an option that getopt_long has not taken. key: '?', or ':' for a missing value. */
static int wrong_option(char **argv, const command *c, int key) {
  const char letter[] = {'-', (char)optopt, '\0'};
  const int known = option_of(c, optopt) != NULL;
  const char *given = optopt != 0 && !known ? letter : argv[optind - 1];
  if (key == ':' || known)
    return complain("%s: %s; see 'delassus %s --help'", given,
                    key == ':' ? "needs a value" : "takes no value", argv[0]);
  char word[64], name[MOST_OPTIONS][64];
  nearest near = {.word = word};
  (void)snprintf(word, sizeof word, "%s", given);
  word[strcspn(word, "=")] = '\0';
  for (int k = 0; c->options[k].name && k < MOST_OPTIONS && given != letter; k++) {
    (void)snprintf(name[k], sizeof name[k], "--%s", c->options[k].name);
    nearest_try(&near, name[k]);
  }
  if (near.count) return complain("%s: is no option%s", word, nearest_words(&near));
  return complain("%s: is no option; see 'delassus %s --help'", word, argv[0]);
}

/* Reads an integer from 1 to `most`. */
static taken parse_count(const char *option, const char *text, int most, int *value) {
  const char *end = text;
  if (dlsi_read_whole(&end, 1, most, value) && !*end) return OPTION_TAKEN;
  return (taken)refuse("--%s: '%s' is not a whole number from 1 to %d", option, text, most);
}

int read_mesh(const char *text, int *nx, int *ny) {
  *ny = 0;
  if (!dlsi_read_whole(&text, 1, INT_MAX, nx)) return 0;
  return !*text || (*text++ == 'x' && dlsi_read_whole(&text, 1, INT_MAX, ny) && !*text);
}

static taken parse_mesh(const char *text, int *nx, int *ny) {
  if (read_mesh(text, nx, ny) && *ny) return OPTION_TAKEN;
  return (taken)refuse("--mesh: '%s' is not NXxNY, two whole numbers >= 1", text);
}

/* Takes the value of a row. */
static taken take_row(const command *c, const option_row *row, const char *text, void *data) {
  void *to = (char *)data + row->at;
  if (row->key == 'h') return OPTION_HELP;
  if (row->key && take_loudness(row->key)) return OPTION_TAKEN;
  if (row->key == KEY_NO_PICTURES) return draw_pictures(0), OPTION_TAKEN;
  switch (row->kind) {
  case A_FLAG:
    return *(int *)to = 1, OPTION_TAKEN;
  case A_TEXT:
    return *(const char **)to = text, OPTION_TAKEN;
  case A_NUMBER:
    return parse_number(row->name, text, to);
  case A_COUNT:
    return parse_count(row->name, text, 1000000000, to);
  case A_MESH:
    return parse_mesh(text, to, (int *)to + 1);
  default:
    return c->take(row->key, text, data);
  }
}

taken take_named(const command *c, const char *name, const char *text, void *data) {
  nearest near = {.word = name};
  for (const option_row *row = c->options; row->name; row++) {
    if (row->has_value && !strcmp(row->name, name)) return take_row(c, row, text, data);
    if (row->has_value) nearest_try(&near, row->name);
  }
  return (taken)refuse("'%s' is no option with a value%s", name, nearest_words(&near));
}

int take_options(int argc, char **argv, const command *c, void *data) {
  struct option rows[MOST_OPTIONS + 1] = {{0}};
  char keys[2 * MOST_OPTIONS + 2] = ":"; /* no words of getopt */
  (void)take_loudness(0);
  draw_pictures(1);
  for (int k = 0; c->options[k].name && k < MOST_OPTIONS; k++) {
    const option_row *row = &c->options[k];
    const char letter[] = {(char)row->key, row->has_value ? ':' : '\0', '\0'};
    rows[k] = (struct option){row->name, row->has_value, NULL, ROW_KEYS + k};
    if (row->key > 0 && row->key < 128) strcat(keys, letter);
  }
  for (int key; (key = getopt_long(argc, argv, keys, rows, NULL)) != -1;) {
    if (key == '?' || key == ':') return wrong_option(argv, c, key);
    const option_row *row = option_of(c, key);
    if (optarg && !*optarg) return complain("--%s: is empty", row->name);
    const taken result = take_row(c, row, optarg, data);
    if (result == OPTION_HELP) c->usage(stdout);
    if (result == OPTION_HELP || result == OPTION_DONE) return EXIT_SOLVED;
    if (result == OPTION_WRONG) return EXIT_BAD_INPUT;
  }
  return c->operands && argc - optind != c->operands ? wrong_names(argv[0]) : GO_ON;
}

int wrong_names(const char *name) {
  return complain("%s: too few or too many names; see 'delassus %s --help'", name, name);
}

void solver_options_init(solver_options *o, double tol) {
  memset(o, 0, sizeof *o);
  dls_solver_settings_init(&o->settings);
  o->settings.limits.tol = tol;
  o->settings.limits.progress = show_progress;
}

const char *method_list(char *text, size_t size) {
  size_t used = 0;
  text[0] = '\0';
  for (int k = 0; dls_method_name((dls_method)k) && used < size; k++)
    used += (size_t)snprintf(text + used, size - used, "%s%s", k > 0 ? ", " : "",
                             dls_method_name((dls_method)k));
  return text;
}

void solver_usage(FILE *out, const char *more, double tol) {
  char methods[METHOD_LIST_ROOM];
  fprintf(out,
          "  -m, --method=METHOD   one of: %s%s (auto)\n"
          "  -a, --accel=HOW       acceleration of nlgs (selects nlgs): none (default), aitken,\n"
          "                        anderson (elastic bodies), momentum (packings)\n"
          "  -t, --tol=T           tolerance on the certificate's residual (%g)\n"
          "  -i, --max-iter=N      limit of sweeps, pivots, steps or augmentations\n"
          "      --threads=N       threads for sweeps over a large W, 1 to 1024 (1)\n",
          method_list(methods, sizeof methods), more, tol);
}

taken no_method(const char *name, const char *const *more) {
  nearest near = {.word = name};
  char methods[METHOD_LIST_ROOM];
  for (int k = 0; dls_method_name((dls_method)k); k++)
    nearest_try(&near, dls_method_name((dls_method)k));
  for (int k = 0; more && more[k]; k++)
    nearest_try(&near, more[k]);
  if (near.count) return (taken)refuse("--method: '%s' is no method%s", name, nearest_words(&near));
  return (taken)refuse("--method: '%s' is no method; these are: %s%s%s", name,
                       method_list(methods, sizeof methods), more ? ", " : "", more ? more[0] : "");
}

/* Takes a method by its name, or gauss-seidel. */
static taken take_method(const char *name, solver_options *o) {
  o->method_given = 1;
  o->primal = strcmp(name, "gauss-seidel") == 0;
  if (o->primal || dls_method_find(name, &o->settings.method)) return OPTION_TAKEN;
  static const char *const more[] = {"gauss-seidel", NULL};
  return no_method(name, more);
}

static taken take_acceleration(const char *name, solver_options *o) {
  o->accel_given = 1;
  if (dls_acceleration_find(name, &o->settings.acceleration)) return OPTION_TAKEN;
  static const char *const all[] = {"none", "aitken", "anderson", "momentum"};
  nearest near = {.word = name};
  for (int k = 0; k < 4; k++)
    nearest_try(&near, all[k]);
  return (taken)refuse("--accel: '%s' is no acceleration (none, aitken, anderson, momentum)%s",
                       name, nearest_words(&near));
}

taken take_solver_option(int key, const char *text, solver_options *o) {
  switch (key) {
  case 'm':
    return take_method(text, o);
  case 'a':
    return take_acceleration(text, o);
  case KEY_THREADS:
    return parse_count("threads", text, most_threads, &o->settings.limits.threads);
  default:
    return OPTION_UNKNOWN;
  }
}

int settle_solver_options(solver_options *o) {
  if (!o->accel_given) return 1;
  if (!o->method_given) o->settings.method = DLS_NLGS;
  if (!o->primal && o->settings.method == DLS_NLGS) return 1;
  return refuse("--accel: is for nlgs");
}
