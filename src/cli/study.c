/*
 * study.c: delassus study: many cases in one run, a line of JSON each.
 *
 *   cases   each name (file, scene) with each row of the table; the columns are options of solve
 *   key     {"case": {..}}: name and options; a case whose line stands in --out is skipped
 *   order   cases with the same matrices follow one another: K is factorised once
 */
#define _GNU_SOURCE
#include <errno.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <sys/file.h>
#include <unistd.h>

#include "cli.h"
#include "solve.h"

enum { MOST_VALUES = 40 };

/* The options of a case, in the order of solve's, as they were typed; NULL: not given. */
typedef struct values {
  const char *name; /* of a file or a scene */
  const char *of[MOST_VALUES];
} values;

typedef struct study_options {
  values given; /* on the command line, for all cases */
  const char *table, *out, *part;
  int print, triplets;
} study_options;

typedef struct one_case {
  values given;
  solve_options options;
  char *key;
  int done;
} one_case;

/* All cases, those that are there, and the ends of those that this run has solved. */
typedef struct study {
  one_case *cases;
  int count, first, end; /* of the part */
  char **texts;          /* of the table, which the values point to */
  int text_count;
  FILE *out;
  int print, solved, unsolved, failed, skipped;
} study;

static void study_usage(FILE *out) {
  fputs(
      "Usage: delassus study [OPTION]... FILE|SCENE...\n"
      "  or:  delassus study --table=CASES.csv [OPTION]... [FILE|SCENE]...\n"
      "Solves many cases: each file or scene, with each row of a table whose columns are options\n"
      "of 'delassus solve' (mu, f, g, stiffness, method, ...). Prints a line of JSON for each.\n"
      "Takes the options of 'delassus solve' that have a value and write no file; --mu also\n"
      "replaces the friction of a file or a scene.\n"
      "\n"
      "  -T, --table=CASES     CSV: the first line names options, each further line is a case\n"
      "  -o, --out=OUT         append the lines to OUT; cases that OUT holds are skipped\n"
      "      --part=K/N        solve the K-th of N parts of the cases, for a job array\n"
      "      --print           add r, u and x to each line\n"
      "      --triplets        tables of triplets, as for 'delassus solve'\n",
      out);
  fputs(LAST_USAGE, out);
  fputs("\nExit status: 0 all solved, 1 not all solved, 2 bad input.\n", out);
}

/* Returns 1 for an option of solve that a case may have: it has a value, writes no file, and asks
 * for an answer. */
static int is_of_case(const option_row *row) {
  static const char *const others[] = {"out", "output", "history", "plot", "csv", "limit"};
  for (size_t k = 0; k < sizeof others / sizeof others[0]; k++)
    if (!strcmp(row->name, others[k])) return 0;
  return row->has_value;
}

/* ---- cases ----------------------------------------------------------------------------------- */

static int finite_number(const char *text, double *value) {
  char *end;
  *value = strtod(text, &end);
  return end > text && !*end && isfinite(*value);
}

/* Writes a field of the key: a finite number as one, else a string. */
static void put_value(FILE *to, int first, const char *name, const char *text) {
  double number;
  if (!first) fputs(", ", to);
  print_json_string(to, name);
  fputs(": ", to);
  if (finite_number(text, &number)) {
    char digits[40];
    (void)snprintf(digits, sizeof digits, "%.15g", number);
    fprintf(to, strtod(digits, NULL) == number ? "%.15g" : "%.17g", number);
  } else
    print_json_string(to, text);
}

/* Makes the key of a case; NULL without memory. */
static char *make_key(const values *v) {
  char *key = NULL;
  size_t size;
  int fields = 0;
  FILE *to = open_memstream(&key, &size);
  if (!to) return NULL;
  fputs("{\"case\": {", to);
  if (v->name) put_value(to, !fields++, "problem", v->name);
  for (int k = 0; solve_command.options[k].name; k++)
    if (v->of[k]) put_value(to, !fields++, solve_command.options[k].name, v->of[k]);
  fputs("}, ", to);
  return fclose(to) ? NULL : key;
}

/* Reads the options of a case; 0 after a complaint. */
static int fill_case(const study_options *all, const values *v, one_case *c) {
  *c = (one_case){.given = *v, .key = make_key(v)};
  if (!c->key) return refuse("out of memory");
  solve_options_init(&c->options);
  for (int k = 0; solve_command.options[k].name; k++)
    if (v->of[k] && take_named(&solve_command, solve_command.options[k].name, v->of[k],
                               &c->options) != OPTION_TAKEN)
      return 0;
  c->options.from.matrices.triplets = all->triplets;
  if (!settle_solve_options(&c->options)) return 0;
  c->options.from = solve_source(&c->options);
  const char *matrix = matrices_name(&c->options.from.matrices);
  if (!v->name == !matrix)
    return refuse(matrix ? "a name and --stiffness, --flexibility or --W: one of them"
                         : "give a file, a scene, or --stiffness, --flexibility or --W");
  return 1;
}

/* Appends the case of a name with the row at hand (t NULL: no table). */
static int add_case(study *s, const study_options *o, const char *name, const csv_table *t,
                    const int *column) {
  values v = o->given;
  v.name = name;
  one_case *more = realloc(s->cases, ((size_t)s->count + 1) * sizeof *more);
  if (!more) return refuse("out of memory");
  s->cases = more;
  for (int k = 0; t && k < t->columns; k++)
    if (k < t->fields && *s->texts[s->text_count - t->columns + k])
      v.of[column[k]] = s->texts[s->text_count - t->columns + k];
  return fill_case(o, &v, &s->cases[s->count++]);
}

/* Keeps the fields of the row at hand. */
static int keep_texts(study *s, const csv_table *t) {
  const size_t room = (size_t)(s->text_count + t->columns);
  char **more = realloc(s->texts, room * sizeof *more);
  if (!more) return refuse("out of memory");
  s->texts = more;
  for (int k = 0; k < t->columns; k++) {
    s->texts[s->text_count] = strdup(k < t->fields ? t->field[k] : "");
    if (!s->texts[s->text_count]) return refuse("out of memory");
    s->text_count++;
  }
  return 1;
}

/* Finds the option of each column; 0 after a complaint. */
static int find_columns(const char *path, const csv_table *t, int *column) {
  for (int k = 0; k < t->columns; k++) {
    nearest near = {.word = t->column[k]};
    column[k] = -1;
    for (int i = 0; solve_command.options[i].name; i++) {
      if (!is_of_case(&solve_command.options[i])) continue;
      if (!strcmp(solve_command.options[i].name, t->column[k])) column[k] = i;
      nearest_try(&near, solve_command.options[i].name);
    }
    if (column[k] < 0)
      return refuse("%s: column '%s' is no option of a case%s", path, t->column[k],
                    nearest_words(&near));
  }
  return 1;
}

/* Makes all cases of the names, with each row of the table. */
static int list_cases(study *s, const study_options *o, int names, char **name) {
  csv_table t;
  int column[MOST_FIELDS], good = 1, row = 1;
  if (!o->table) {
    for (int k = 0; good && k < (names ? names : 1); k++)
      good = add_case(s, o, names ? name[k] : NULL, NULL, NULL);
    return good;
  }
  if (!csv_open(&t, NULL, input_path(o->table)))
    return refuse("%s: no table (CSV, names of options in the first line)", o->table);
  good = find_columns(o->table, &t, column);
  for (; good && csv_next(&t); row++) {
    if (t.fields > t.columns)
      good = refuse("%s: row %d has %d fields, %d names", o->table, row, t.fields, t.columns);
    good = good && keep_texts(s, &t);
    for (int k = 0; good && k < (names ? names : 1); k++)
      good = add_case(s, o, names ? name[k] : NULL, &t, column) ||
             refuse("%s: in row %d", o->table, row);
    if (!good) (void)fclose(t.file);
  }
  return good;
}

/* Takes --part=K/N: equal parts of cases that follow one another. */
static int take_part(study *s, const char *text) {
  const char *at = text;
  int k = 1, n = 1;
  if (text && !(dlsi_read_whole(&at, 1, 1000000, &k) && *at++ == '/' &&
                dlsi_read_whole(&at, k, 1000000, &n) && !*at))
    return refuse("--part: '%s' is not K/N, 1 <= K <= N", text);
  s->first = (int)((long long)s->count * (k - 1) / n);
  s->end = (int)((long long)s->count * k / n);
  return 1;
}

/* ---- the file -------------------------------------------------------------------------------- */

static int by_text(const void *a, const void *b) {
  return strcmp(*(char *const *)a, *(char *const *)b);
}

/* Cuts a line behind its key, if it is a whole one. */
static int is_line(char *line) {
  char *end = strstr(line, "}, \"status\": ");
  if (!end) return 0;
  end[3] = '\0';
  return 1;
}

/* Opens OUT, marks the cases that it holds and cuts off a line that a run left unfinished. */
static int open_out(study *s, const char *path) {
  char **keys = NULL, *line = NULL;
  size_t count = 0, room = 0;
  off_t whole = 0;
  s->out = fopen(path, "a+");
  if (!s->out) return refuse("%s: %s", path, strerror(errno));
  if (flock(fileno(s->out), LOCK_EX | LOCK_NB) && errno == EWOULDBLOCK)
    return refuse("%s: another study writes it; a file for each part", path);
  int good = 1;
  for (ssize_t length; good && (length = getline(&line, &room, s->out)) > 0;) {
    if (line[length - 1] != '\n') break;
    whole += length;
    if (!is_line(line)) continue;
    char **more = realloc(keys, (count + 1) * sizeof *keys);
    if (more) keys = more;
    good = more && (keys[count] = strdup(line)) != NULL;
    count += (size_t)good;
  }
  if (!good) (void)refuse("out of memory");
  if (good && ftruncate(fileno(s->out), whole)) good = refuse("%s: %s", path, strerror(errno));
  if (count) qsort(keys, count, sizeof *keys, by_text);
  for (int i = s->first; good && count && i < s->end; i++)
    s->cases[i].done = bsearch(&s->cases[i].key, keys, count, sizeof *keys, by_text) != NULL;
  for (size_t k = 0; k < count; k++)
    free(keys[k]);
  free(keys);
  free(line);
  return good;
}

/* Writes a line: the outcome as --json prints it, on one line. */
static int write_line(study *s, const one_case *c, const outcome *o, const solution *a, int n) {
  char *text = NULL, *line = NULL;
  size_t size, length;
  FILE *to = open_memstream(&text, &size);
  if (!to) return refuse("out of memory");
  print_json(to, o);
  int good = fclose(to) == 0 && (to = open_memstream(&line, &length)) != NULL;
  if (good) {
    text[strlen(text) - 3] = '\0'; /* without "\n}\n" */
    fputs(c->key, to);
    for (const char *at = text + 1 + strspn(text + 1, "\n "); *at; at++) {
      if (*at != '\n') {
        fputc(*at, to);
        continue;
      }
      fputc(' ', to);
      at += strspn(at + 1, " ");
    }
    if (s->print) {
      print_json_numbers(to, ", \"r\"", o->d * o->nc, a->r);
      print_json_numbers(to, ", \"u\"", o->d * o->nc, a->u);
      if (a->x) print_json_numbers(to, ", \"x\"", n, a->x);
    }
    fputs("}\n", to);
    good = fclose(to) == 0;
  }
  if (good) good = fwrite(line, 1, length, s->out) == length && !fflush(s->out);
  free(text);
  free(line);
  return good ? 1 : refuse("the line of a case cannot be written: %s", strerror(errno));
}

/* ---- the solves ------------------------------------------------------------------------------ */

static int same_text(const char *a, const char *b) {
  return a == b || (a && b && !strcmp(a, b));
}

/* The part of two cases that is compared. */
typedef enum likeness { SAME_MATRICES = 10, SAME_LOADS = 13, SAME_FRICTION = 14 } likeness;

/* Returns 1 if two cases have the same matrices, and loads, and friction. */
static int are_alike(const one_case *a, const one_case *b, likeness compared) {
  const matrix_options *x = &a->options.from.matrices, *y = &b->options.from.matrices;
  const char *const pairs[][2] = {{a->given.name, b->given.name},
                                  {x->stiffness, y->stiffness},
                                  {x->flexibility, y->flexibility},
                                  {x->W, y->W},
                                  {x->H, y->H},
                                  {x->HN, y->HN},
                                  {x->HT, y->HT},
                                  {x->nodes, y->nodes},
                                  {x->weights, y->weights},
                                  {x->where, y->where},
                                  {x->f, y->f},
                                  {x->g, y->g},
                                  {x->q, y->q},
                                  {x->mu, y->mu}};
  for (int k = 0; k < (int)compared; k++)
    if (!same_text(pairs[k][0], pairs[k][1])) return 0;
  /* a file's own friction is gone once another one was taken */
  if (a->given.name && !x->mu != !y->mu) return 0;
  return x->dim == y->dim && x->on == y->on && a->options.from.step == b->options.from.step;
}

/* Loads the problem of a case: all of it, or its data where `loaded` has the same matrices. */
static int load_case(const one_case *c, const one_case *loaded, problem *p) {
  source from = c->options.from;
  const char *matrix = matrices_name(&from.matrices), *name = matrix ? matrix : c->given.name;
  if (loaded && are_alike(c, loaded, SAME_FRICTION)) return 1;
  if (!loaded) {
    if (!matrix) from.matrices.mu = NULL; /* problem_open knows that of the matrices alone */
    if (!problem_open(name, &from, p)) return 0;
    problem_fit_threads(p);
    if (is_verbose()) print_reduction(stderr, p);
    if (matrix || !c->options.from.matrices.mu) return 1;
  }
  return problem_reload(name, &c->options.from, loaded && !are_alike(c, loaded, SAME_LOADS), p);
}

/* Solves a case; returns 0 to end the study, after a complaint or a signal. */
static int solve_case(study *s, one_case *c, problem *p) {
  solution a = {0};
  outcome o;
  dls_error error = {0};
  int good = 1;
  const dls_status status = problem_solve(p, &c->options, &a, &o, &error);
  if (status < 0) {
    (void)complain("not run: %.*s", (int)strlen(c->key) - 2, c->key);
    (void)complain_of("why", &error);
    s->failed++;
  } else if (status == DLS_CANCELLED)
    good = 0;
  else {
    good = write_line(s, c, &o, &a, p->model.n);
    s->failed += !good;
    *(dls_solved(status) ? &s->solved : &s->unsolved) += good;
  }
  c->done = 1;
  solution_free(&a);
  return good;
}

/* Solves case i and all that are left with its matrices; returns 0 to end the study. */
static int solve_alike(study *s, int i) {
  problem p = {0};
  const one_case *loaded = NULL;
  int good = 1;
  for (int j = i; good && j < s->end; j++) {
    one_case *c = &s->cases[j];
    if (c->done || (loaded && !are_alike(c, loaded, SAME_MATRICES))) continue;
    if (was_interrupted()) break;
    if (load_case(c, loaded, &p)) {
      good = solve_case(s, c, &p);
      loaded = c;
      continue;
    }
    if (was_interrupted()) break;
    (void)complain("not run: %.*s", (int)strlen(c->key) - 2, c->key);
    for (int k = j; k < s->end; k++) { /* without the matrices none of these can be solved */
      if (s->cases[k].done || !are_alike(&s->cases[k], c, loaded ? SAME_FRICTION : SAME_MATRICES))
        continue;
      s->cases[k].done = 1;
      s->failed++;
    }
    break; /* what stands in p is unknown */
  }
  problem_free(&p);
  return good && !was_interrupted();
}

static int end_study(const study *s, const char *out) {
  char why[100] = "";
  const int wanted = s->end - s->first, there = s->skipped + s->solved + s->unsolved;
  int result = s->failed                       ? EXIT_BAD_INPUT
               : s->unsolved || there < wanted ? EXIT_NOT_SOLVED
                                               : EXIT_SOLVED;
  if (was_interrupted() && !s->failed) result = EXIT_NOT_SOLVED;
  if (!out) return result; /* nothing but lines on stdout */
  (void)snprintf(why, sizeof why, "%d of %d cases", s->unsolved, wanted - s->skipped);
  tell("files: %s\n", quote(AS_SHOWN, out).text);
  tell("  %d case%s: %d solved, %d not, %d were there\n", wanted, plural(wanted), s->solved,
       s->unsolved, s->skipped);
  if (!is_json()) return end_command(result, why);
  print_json_head("study", result == EXIT_SOLVED ? "solved" : "not_solved",
                  result == EXIT_SOLVED ? NULL : why);
  printf(",\n  \"cases\": %d,\n  \"solved\": %d,\n  \"not_solved\": %d,\n  \"were_there\": %d\n}\n",
         wanted, s->solved, s->unsolved, s->skipped);
  return result;
}

static int run_study(const study_options *o, int names, char **name) {
  study s = {.out = stdout, .print = o->print};
  int good = list_cases(&s, o, names, name) && take_part(&s, o->part);
  if (good && o->out) good = open_out(&s, o->out);
  for (int i = s.first; good && i < s.end; i++)
    s.skipped += s.cases[i].done;
  end_at_once(0);
  watch_interrupt();
  for (int i = s.first, on = good; on && i < s.end; i++)
    if (!s.cases[i].done) on = solve_alike(&s, i);
  const int result = good ? end_study(&s, o->out) : EXIT_BAD_INPUT;
  if (s.out && s.out != stdout) (void)fclose(s.out);
  for (int i = 0; i < s.count; i++)
    free(s.cases[i].key);
  for (int k = 0; k < s.text_count; k++)
    free(s.texts[k]);
  free(s.cases);
  free(s.texts);
  return result;
}

int command_study(int argc, char **argv) {
  const option_row own[] = {ROW(A_TEXT, "table", 'T', study_options, table),
                            ROW(A_TEXT, "out", 'o', study_options, out),
                            ROW(A_TEXT, "part", 0, study_options, part),
                            ROW(A_FLAG, "print", 0, study_options, print),
                            ROW(A_FLAG, "triplets", 0, study_options, triplets),
                            LAST_OPTIONS};
  option_row rows[MOST_VALUES + sizeof own / sizeof own[0]];
  int count = 0;
  for (int k = 0; solve_command.options[k].name; k++) { /* each is a text, parsed for each case */
    if (!is_of_case(&solve_command.options[k])) continue;
    rows[count] = solve_command.options[k];
    rows[count].key = rows[count].key < 128 ? rows[count].key : 0;
    rows[count].kind = A_TEXT;
    rows[count++].at = offsetof(study_options, given.of) + (size_t)k * sizeof(char *);
  }
  memcpy(rows + count, own, sizeof own);
  const command with_values = {rows, study_usage, NULL, 0};
  study_options o = {0};
  const int stop = take_options(argc, argv, &with_values, &o);
  if (stop != GO_ON) return stop;
  if (argc == optind && !o.table) return wrong_names(argv[0]);
  return run_study(&o, argc - optind, argv + optind);
}
