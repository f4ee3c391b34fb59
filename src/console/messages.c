/* messages.c: prints messages, JSON and progress on a terminal, and listens to signals. */
#define _GNU_SOURCE
#include <errno.h>
#include <float.h>
#include <math.h>
#include <signal.h>
#include <stdarg.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>
#include <unistd.h>

#include "console.h"

static int loudness, json; /* -1 quiet, 1 verbose; 1: --json */
static char *complaint;    /* of a command within another one (run_command), or NULL */

int complain(const char *format, ...) {
  char text[QUOTED_ROOM];
  va_list args;
  va_start(args, format);
  if (vsnprintf(text, sizeof text, format, args) < 0) text[0] = '\0';
  va_end(args);
  if (complaint)
    (void)snprintf(complaint, PATH_ROOM, "%s", text);
  else
    fprintf(stderr, "delassus: %s\n", quote(AS_SHOWN, text).text);
  return EXIT_BAD_INPUT;
}

int complain_of(const char *what, const dls_error *error) {
  const char *text = error->message; /* past the name of the function in C */
  if (error->function && *error->function) text += strlen(error->function) + 2;
  const char *said = strncmp(text, "path", 4) == 0 ? strstr(text, ": ") : NULL;
  if (said) return complain("%s: %s", what, said + 2); /* the name of the file says it */
  return complain("%s: %s (%s)", what, dls_status_text(error->status), text);
}

dls_status no_memory(dls_error *error) {
  *error = (dls_error){.status = DLS_E_MEMORY, .message = "out of memory"};
  return DLS_E_MEMORY;
}

static const double told_error = 1e-4; /* of the reactions: a larger one is printed */
static volatile sig_atomic_t interrupted;
static volatile sig_atomic_t ends_at_once; /* 1: there is nothing yet that a signal may not end */

int take_loudness(int key) {
  if (key == 0) loudness = json = 0;
  if (key == 'j') json = 1;
  if (key == 'v' || key == 'q') loudness = key == 'v' ? 1 : -1;
  return key == 0 || key == 'j' || key == 'v' || key == 'q';
}

int is_quiet(void) {
  return loudness < 0;
}

int is_verbose(void) {
  return loudness > 0;
}

int is_json(void) {
  return json;
}

int prints_text(void) {
  return loudness >= 0 && !json;
}

void tell(const char *format, ...) {
  va_list args;
  if (!prints_text()) return;
  va_start(args, format);
  vprintf(format, args);
  va_end(args);
}

/* Prints the last line: "solved" and how well, or why not (NULL where it is solved). */
static void print_last_line(const char *why, const char *how_well) {
  if (json || complaint) return;
  const char *no_color = getenv("NO_COLOR");
  const int color = isatty(STDOUT_FILENO) && !(no_color && *no_color);
  const char *on = !color ? "" : why ? "\033[31m" : "\033[32m", *off = color ? "\033[0m" : "";
  if (why)
    printf("%snot solved: %s%s\n", on, why, off);
  else
    printf("%ssolved%s%s\n", on, how_well, off);
}

int run_command(int (*run)(int argc, char **argv), char **argv, char *why) {
  const int own_loudness = loudness, own_json = json;
  int argc = 0;
  while (argv[argc])
    argc++;
  why[0] = '\0';
  complaint = why;
  optind = 0; /* getopt begins anew */
  const int result = run(argc, argv);
  complaint = NULL;
  loudness = own_loudness;
  json = own_json;
  return result;
}

/* Names the part of the answer with the largest rounding, and how well it holds. */
static void rounding_words(const dls_info *info, char *text, size_t size) {
  const dls_certificate *c = &info->certificate;
  const char *part = "positions";
  double held = fmax(4 * c->floor_u, c->residual_u);
  const double forces = fmax(4 * c->floor_r, c->residual_r);
  const double balance = fmax(4 * c->floor_e, c->equilibrium);
  if (forces > held) part = "forces", held = forces;
  if (balance > held) part = "equilibrium", held = balance;
  if (info->error > held) part = "reactions", held = info->error;
  (void)snprintf(text, size, " to rounding: %s to %.0e", part, held);
}

void print_ending(dls_status status, const dls_info *info) {
  char how_well[120] = "", why[160] = "";
  const dls_certificate *c = info ? &info->certificate : NULL;
  if (c && status == DLS_TO_ROUNDING && info->error <= DBL_MAX)
    rounding_words(info, how_well, sizeof how_well);
  else if (c && info->error > DBL_MAX)
    (void)snprintf(how_well, sizeof how_well, ": single reactions are not determined%s",
                   info->forces == DLS_FORCES_LEAST ? ", the least are given" : "");
  else if (c && info->error > told_error)
    (void)snprintf(how_well, sizeof how_well, ": reactions to about %.0e", info->error);
  if (c && status == DLS_NOT_IN_EQUILIBRIUM)
    (void)snprintf(why, sizeof why, "%s: a force of %.3g on body %d is not balanced",
                   dls_status_text(status), c->unbalanced, c->body);
  print_last_line(dls_solved(status) ? NULL : *why ? why : dls_status_text(status), how_well);
}

dls_status count_freedom(const dls_contact *contact, const double *r, int *freedom,
                         dls_error *error) {
  *freedom = FREEDOM_TOO_LARGE;
  if (contact->d * contact->nc > most_rows_of_freedom) return DLS_OK;
  return dls_contact_freedom(contact, r, freedom, error);
}

const char *freedom_words(int freedom, dls_forces forces, char *text) {
  text[0] = '\0';
  if (freedom == FREEDOM_ON_K)
    (void)snprintf(text, FREEDOM_ROOM,
                   "self-stresses: not counted on K; single reactions may not be determined");
  if (freedom == FREEDOM_TOO_LARGE)
    (void)snprintf(text, FREEDOM_ROOM, "self-stresses: not counted for more than %d rows",
                   most_rows_of_freedom);
  if (freedom > 0)
    (void)snprintf(
        text, FREEDOM_ROOM,
        "%d self-stress%s: positions determine the sum on each body, not single reactions; %s",
        freedom, freedom == 1 ? "" : "es",
        forces == DLS_FORCES_LEAST ? "these are the least" : "--forces=least gives the least");
  return text;
}

const char *proof_words(const dls_proof *proof, char *text, size_t size) {
  if (proof->kind == DLS_PROVED && proof->radius == 0)
    (void)snprintf(text, size, "proved: reactions exact");
  else if (proof->kind == DLS_PROVED)
    (void)snprintf(text, size, "proved: reactions within %.0e", proof->radius);
  else if (proof->kind == DLS_PROVED_POSITIONS)
    (void)snprintf(text, size, "proved: positions within %.0e; reactions have %d self-stress%s",
                   proof->radius_u, proof->freedom, proof->freedom > 1 ? "es" : "");
  else if (proof->border)
    (void)snprintf(text, size, "not proved: contact %d is at the border between %s and %s",
                   proof->contact, state_word(proof->state), state_word(proof->other));
  else
    (void)snprintf(text, size, "not proved");
  return text;
}

void print_proved(const dls_proof *proof) {
  char room[120], words[130];
  (void)snprintf(words, sizeof words, " (%s)", proof_words(proof, room, sizeof room));
  print_last_line(NULL, words);
}

int end_command(int result, const char *why) {
  if (result == EXIT_BAD_INPUT) return result;
  if (interrupted) {
    result = EXIT_NOT_SOLVED;
    why = dls_status_text(DLS_CANCELLED);
  }
  print_last_line(result == EXIT_SOLVED ? NULL : why, "");
  return result;
}

const char *plural(long long count) {
  return count == 1 ? "" : "s";
}

int refuse_number(const char *option, const char *text, const char *what) {
  char room[64], *end, *comma;
  (void)snprintf(room, sizeof room, "%s", text);
  comma = strchr(room, ',');
  if (comma) *comma = '.';
  (void)strtod(room, &end);
  if (!comma || end == room || *end || strlen(text) >= sizeof room)
    return refuse("--%s: '%s' is %s", option, text, what);
  return refuse("--%s: '%s' is not a number; write the decimal point as '.': %s", option, text,
                room);
}

int read_real(const char **text, double *value) {
  char *end;
  errno = 0;
  const double v = strtod(*text, &end);
  if (end == *text || errno == ERANGE || !isfinite(v)) return 0;
  *value = v;
  *text = end;
  return 1;
}

taken parse_number(const char *option, const char *text, double *value) {
  const char *end = text;
  double v;
  if (!read_real(&end, &v) || *end || v < 0)
    return (taken)refuse_number(option, text, "not a number >= 0");
  *value = v;
  return OPTION_TAKEN;
}

int parse_word(const char *option, const char *text, const char *const *words, int count) {
  char all[100] = "";
  for (int k = 0; k < count; k++) {
    if (!strcmp(text, words[k])) return k;
    const size_t used = strlen(all);
    (void)snprintf(all + used, sizeof all - used, "%s%s", k ? ", " : "", words[k]);
  }
  complain("--%s: '%s' is none of %s", option, text, all);
  return -1;
}

double largest_entry(const double *v, int n) {
  double m = 0;
  for (int i = 0; i < n; i++)
    if (fabs(v[i]) > m) m = fabs(v[i]);
  return m;
}

double distance(size_t n, const double *x, const double *y) {
  double sum = 0;
  for (size_t i = 0; i < n; i++) {
    const double e = x[i] - (y ? y[i] : 0);
    sum += e * e;
  }
  return sqrt(sum);
}

int ascending(const void *a, const void *b) {
  const double x = *(const double *)a, y = *(const double *)b;
  return (x > y) - (x < y);
}

const char *status_word(dls_status status) {
  static const char *const words[] = {
      [DLS_OK] = "solved",
      [DLS_MAX_ITERATIONS] = "max_iterations",
      [DLS_CANCELLED] = "cancelled",
      [DLS_STALLED] = "stalled",
      [DLS_RAY] = "ray",
      [DLS_NO_SOLUTION] = "no_solution",
      [DLS_NO_SOLUTION_LIKELY] = "no_solution_likely",
      [DLS_TIME_LIMIT] = "time_limit",
      [DLS_FOLDED] = "folded",
      [DLS_TO_ROUNDING] = "to_rounding",
      [DLS_NOT_IN_EQUILIBRIUM] = "not_in_equilibrium",
  };
  return status < 0 ? "error" : words[status];
}

const char *unsolved_words(dls_status status, double residual, char *text, size_t size) {
  text[0] = '\0';
  if (!dls_solved(status))
    (void)snprintf(text, size, "not solved: %s, residual %.2e", dls_status_text(status), residual);
  return text;
}

const char *state_word(dls_contact_state state) {
  return state == DLS_FREE ? "free" : state == DLS_SLIP ? "slip" : "stick";
}

const char *iteration_word(dls_method method, int count) {
  const int one = count == 1;
  if (method == DLS_NLGS) return one ? "sweep" : "sweeps";
  if (method == DLS_LEMKE) return one ? "exchange" : "exchanges";
  if (method == DLS_NEWTON) return one ? "step" : "steps";
  if (method == DLS_AUGMENTED_LAGRANGIAN || method == DLS_PENALTY)
    return one ? "augmentation" : "augmentations";
  return one ? "iteration" : "iterations";
}

const char *method_word(const outcome *o) {
  return o->primal ? "gauss-seidel" : o->as_printed ? "jean" : dls_method_name(o->info.method);
}

void print_stages(const dls_info *info) {
  for (int k = 0; k < info->stages; k++) {
    const dls_stage *s = &info->stage[k];
    printf("    %s: %d %s", dls_step_name(s->step), s->iterations,
           iteration_word(s->method, s->iterations));
    if (s->factorisations != s->iterations && s->factorisations)
      printf(", %d factorisation%s", s->factorisations, plural(s->factorisations));
    printf(", residual %.2e: %s\n", s->residual, dls_reason_text(s->reason));
  }
}

/* ---- JSON ------------------------------------------------------------------------------------ */

void print_json_string(FILE *out, const char *text) {
  fputs(quote(AS_JSON, text).text, out);
}

void print_json_number(FILE *out, double value) {
  if (isfinite(value))
    fprintf(out, "%.17g", value);
  else
    fputs("null", out);
}

void print_json_field(FILE *out, const char *name, double value) {
  fprintf(out, ",\n  \"%s\": ", name);
  print_json_number(out, value);
}

void print_json_numbers(FILE *out, const char *name, int n, const double *x) {
  fprintf(out, "%s: [", name);
  for (int i = 0; i < n; i++) {
    if (i) fputs(", ", out);
    print_json_number(out, x[i]);
  }
  fputc(']', out);
}

void print_json_verdict(FILE *out, const verdict *v, int proof) {
  if (!v->says) return;
  fputs(",\n  \"verdict\": ", out);
  print_json_string(out, v->says);
  fputs(",\n  \"next\": ", out);
  print_json_string(out, v->next);
  if (proof && v->farkas)
    print_json_numbers(out, v->exact ? ",\n  \"farkas\"" : ",\n  \"farkas_to_rounding\"", v->rows,
                       v->farkas);
  if (proof && v->ray) print_json_numbers(out, ",\n  \"ray\"", v->rows * v->stride, v->ray);
}

static void print_json_stages(FILE *out, const dls_info *info) {
  fputs(",\n  \"stages\": [", out);
  for (int k = 0; k < info->stages; k++) {
    const dls_stage *s = &info->stage[k];
    fprintf(
        out,
        "%s\n    {\"method\": \"%s\", \"iterations\": %d, \"factorisations\": %d, \"residual\": ",
        k ? "," : "", dls_method_name(s->method), s->iterations, s->factorisations);
    print_json_number(out, s->residual);
    fprintf(out, ", \"step\": \"%s\", \"reason\": \"%s\", \"cpu_seconds\": %.6g}",
            dls_step_name(s->step), dls_reason_text(s->reason), s->cpu_seconds);
  }
  fputc(']', out);
}

void print_residuals(const char *indent, const dls_certificate *c) {
  printf(
      "%sposition residual %.2e (rounding level %.1e), force residual %.2e (rounding level %.1e)",
      indent, c->residual_u, c->floor_u, c->residual_r, c->floor_r);
  if (c->floor_e > 0)
    printf(", equilibrium %.2e (rounding level %.1e)", c->equilibrium, c->floor_e);
  putchar('\n');
}

static const char *uniqueness_word(dls_uniqueness unique) {
  return unique == DLS_UNIQUE_YES ? "yes" : unique == DLS_UNIQUE_NO ? "no" : "unknown";
}

static void print_json_unsettled(FILE *out, const unsettled *from) {
  if (from->count == 0) return;
  fputs(",\n  \"unsettled\": [", out);
  for (int k = 0; k < from->count; k++)
    fprintf(out, "%s%d", k ? ", " : "", from->candidate[k]);
  fputc(']', out);
  print_json_field(out, "unsettled_share", from->share);
  print_json_field(out, "sweep_growth", from->growth);
}

void print_json(FILE *out, const outcome *o) {
  const dls_certificate *c = &o->info.certificate;
  fputs("{\n", out);
  if (o->scene) {
    fputs("  \"scene\": ", out);
    print_json_string(out, o->scene);
    fprintf(out, ",\n  \"weighted\": %s,\n", o->weighted ? "true" : "false");
  }
  fprintf(out, "  \"status\": \"%s\",\n  \"method\": \"%s\",\n", status_word(o->info.status),
          method_word(o));
  fprintf(out, "  \"dimension\": %d,\n  \"contacts\": %d,\n  \"iterations\": %d", o->d, o->nc,
          o->info.iterations);
  if (o->info.regime) fprintf(out, ",\n  \"regime\": \"%s\"", dls_regime_name(o->info.regime));
  fprintf(out, ",\n  \"forces\": \"%s\"", o->info.forces == DLS_FORCES_LEAST ? "least" : "any");
  print_json_field(out, "freedom", o->freedom < 0 ? (double)NAN : o->freedom);
  fprintf(out, ",\n  \"unique\": \"%s\",\n  \"ambiguous\": %d", uniqueness_word(o->info.unique),
          o->info.ambiguous);
  print_json_field(out, "residual", c->residual);
  print_json_field(out, "residual_u", c->residual_u);
  print_json_field(out, "residual_r", c->residual_r);
  print_json_field(out, "floor_u", c->floor_u);
  print_json_field(out, "floor_r", c->floor_r);
  if (c->floor_e > 0) {
    print_json_field(out, "equilibrium", c->equilibrium);
    print_json_field(out, "floor_e", c->floor_e);
  }
  if (o->primal) {
    print_json_field(out, "equilibrium", o->primal->equilibrium);
    print_json_field(out, "equilibrium_floor", o->primal->equilibrium_floor);
    print_json_field(out, "laws", o->primal->laws.residual);
    print_json_field(out, "laws_floor_u", o->primal->laws.floor_u);
    print_json_field(out, "laws_floor_r", o->primal->laws.floor_r);
    fprintf(out, ",\n  \"thresholds\": %d", o->primal->thresholds);
  }
  print_json_field(out, "penetration", c->penetration);
  print_json_field(out, "adhesion", c->adhesion);
  print_json_field(out, "cone_violation", c->cone_violation);
  print_json_field(out, "slip_direction", c->slip_direction);
  print_json_field(out, "complementarity", c->complementarity);
  if (o->prove) {
    char words[120];
    fputs(",\n  \"proof\": ", out);
    print_json_string(out, proof_words(&o->proved, words, sizeof words));
    print_json_field(out, "radius", o->proved.kind ? o->proved.radius : NAN);
    print_json_field(out, "radius_u", o->proved.kind ? o->proved.radius_u : NAN);
  }
  if (o->scene) {
    print_json_field(out, "resultant_t", o->Rt);
    print_json_field(out, "resultant_n", o->Rn);
  }
  print_json_field(out, "solve_cpu_seconds", o->solve_cpu_seconds);
  if (o->info.stages) print_json_stages(out, &o->info);
  print_json_verdict(out, &o->verdict, o->proof);
  print_json_unsettled(out, &o->unsettled);
  fputs("\n}\n", out);
}

/* ---- time, progress, signals ----------------------------------------------------------------- */

static double clock_seconds(clockid_t clock_id) {
  struct timespec t;
  if (clock_gettime(clock_id, &t)) return 0;
  return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

double cpu_seconds(void) {
  return clock_seconds(CLOCK_PROCESS_CPUTIME_ID);
}

static double first_shown, last_shown; /* wall seconds; 0: nothing yet */
static int line_shown;

/* Ends the work where it next looks, or at once (end_at_once). A signal that comes two seconds
 * later or more, while it does not look, ends the program. `timeout` sends its signal twice, at the
 * same time. */
static void on_interrupt(int number) {
  static volatile sig_atomic_t first; /* seconds */
  struct timespec t;
  const sig_atomic_t now =
      clock_gettime(CLOCK_MONOTONIC, &t) ? 0 : (sig_atomic_t)(t.tv_sec % 1000000);
  if (ends_at_once || (interrupted && now > first + 1)) {
    (void)signal(number, SIG_DFL);
    (void)raise(number);
  }
  if (!interrupted) first = now;
  interrupted = 1;
}

void watch_interrupt(void) {
  static const int signals[] = {SIGINT, SIGTERM, SIGHUP, SIGXCPU};
  struct sigaction action, before;
  memset(&action, 0, sizeof action);
  action.sa_handler = on_interrupt;
  for (size_t k = 0; k < sizeof signals / sizeof signals[0]; k++) /* nohup stays as it is */
    if (signals[k] == SIGINT ||
        (sigaction(signals[k], NULL, &before) == 0 && before.sa_handler != SIG_IGN))
      (void)sigaction(signals[k], &action, NULL);
}

void end_at_once(int on) {
  ends_at_once = on;
}

int was_interrupted(void) {
  return interrupted;
}

static struct {
  const char *name, *part; /* NULL: none */
  double start, whole;     /* CPU seconds */
  double reached;          /* the share done at the start */
} task;

duration in_words(double seconds) {
  static const double unit[] = {1e-3, 1, 60, 3600};
  static const char *const names[] = {"ms", "s", "min", "h"};
  const int k = (seconds >= 0.0995) + (seconds >= 999.5) + (seconds >= 5970);
  const double count = seconds / unit[k];
  duration d;
  (void)snprintf(d.text, sizeof d.text, count < 99.5 ? "%.2g %s" : "%.0f %s", count, names[k]);
  return d;
}

void progress_task(const char *name, double whole, double reached) {
  task.name = name && !is_quiet() && !is_verbose() ? name : NULL;
  task.part = "";
  task.start = cpu_seconds();
  task.whole = whole;
  task.reached = reached;
}

void progress_part(const char *part) {
  task.part = part;
}

/* Returns 1 if a line is to be shown now: on a terminal after half a second, each tenth; else, of a
 * task, after 5 seconds, each 5. */
static int progress_due(void) {
  const int terminal = isatty(STDERR_FILENO);
  const double now = clock_seconds(CLOCK_MONOTONIC);
  if (first_shown == 0) first_shown = now;
  if ((!terminal && !task.name) || now - first_shown < (terminal ? 0.5 : 5) ||
      now - last_shown < (terminal ? 0.1 : 5))
    return 0;
  last_shown = now;
  line_shown = terminal;
  if (terminal) fputc('\r', stderr);
  return 1;
}

int show_progress(void *data, const dls_progress *p) {
  (void)data;
  ends_at_once = 0;
  if (interrupted) return 1;
  if (is_verbose()) {
    fprintf(stderr, "%s: %d", p->last ? p->method : p->stage, p->iteration);
    if (p->max_iterations > 0) fprintf(stderr, " of at most %d", p->max_iterations);
    if (p->cpu_seconds > 0) fprintf(stderr, ", %s of CPU", in_words(p->cpu_seconds).text);
    if (p->residual >= 0) fprintf(stderr, ", residual %.2e", p->residual);
    fputs(p->last ? ", end\n" : "\n", stderr);
    return 0;
  }
  if ((!task.name && (p->last || is_quiet())) || !progress_due()) return 0;
  if (task.name) {
    const double done = fmin(1, task.reached + (cpu_seconds() - task.start) / task.whole);
    fprintf(stderr, "%s: %s, %.0f %% done, at most %s of CPU left", task.name, task.part,
            100 * done, in_words(ceil((1 - done) * task.whole)).text);
  } else {
    fprintf(stderr, "%s: %d", p->stage, p->iteration);
    if (p->max_iterations > 0) fprintf(stderr, " of at most %d", p->max_iterations);
    if (p->residual >= 0) fprintf(stderr, ", residual %.2e", p->residual);
  }
  fputs(line_shown ? "\033[K" : "\n", stderr);
  fflush(stderr);
  return 0;
}

int show_reduction(void *data, const dls_progress *p) {
  ends_at_once = 0;
  if (p->last) progress_end();
  return is_verbose() ? interrupted : show_progress(data, p);
}

void progress_end(void) {
  if (line_shown) fputs("\r\033[K", stderr);
  line_shown = 0;
}
