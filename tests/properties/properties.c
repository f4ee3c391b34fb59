/*
 * properties.c: random problems whose answer is known, solved in many ways, and counted.
 *
 *   properties [--seed N] [--step K] [--count N] [--class NAME] [--seconds S] [--tol T] [--out DIR]
 *
 * Problem i has the seed N + i K, and the class that the seed selects, by shares that are even in
 * time; "--class each" takes the classes in turn (those with problems of a second every fourth
 * time), "--class stacks" the bodies of bodies.c on K itself, "--class rest", or one of its kinds,
 * those of rest.c. Exit 0: every rule kept; 1: some rule
 * broken; 2: the command line, or a file that cannot be written.
 */
#define _POSIX_C_SOURCE 200809L /* mkdir, clock_gettime */
#include <errno.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <time.h>

#include "bodies.h"
#include "check.h"
#include "rest.h"

enum { WAYS = DLS_HOMOTOPY + 2 };
enum { saved_most = 3 /* of a class and rule */, saved_rule = 15, text_size = 400 };

/* Of the symmetric solvable problems at most this share may stay unsolved by auto, besides
 * chance, and of each class at most that of the table. */
static const double unsolved_share = 1e-4;
static const struct {
  const char *class;
  double share;
} unsolved_of[] = {{"friction", 2e-3}, {"slight", 2e-3},     {"mixed", 0.05},  {"skew", 5e-3},
                   {"aspect", 5e-3},   {"zero-blocks", 0.1}, {"product", 0.2}, {"bonded", 0.05}};

enum { DRAWN = -1, EACH = -2, STACKS = -3, REST = -10 /* minus the kind */ };

static double wall_clock(void) {
  struct timespec t;
  clock_gettime(CLOCK_MONOTONIC, &t);
  return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

typedef struct tally {
  long problems, visible, symmetric, solved, fine, lost_symmetric;
  long status[DLS_TO_ROUNDING + 1]; /* of auto */
  long broken[RULES], both_true, doubtful;
  long by[RULES][WAYS]; /* method of the first run that shows it; the last: Lemke on an LCP */
  long unknown, other;  /* runs */
  double forces;        /* worst residual_r of a solved one */
  double amplified;     /* worst true error of a run, over tol and the condition */
  double seconds;       /* of CPU */
} tally;

typedef struct command {
  uint64_t seed, step;
  long count;
  int class; /* DRAWN, EACH, STACKS, REST - kind, or one */
  double seconds;
  options ask;
  const char *out;
} command;

static int print_usage(void) {
  fprintf(stderr, "properties [--seed N] [--step K] [--count N] [--class NAME] [--seconds S] "
                  "[--tol T] [--out DIR]\nclasses:");
  for (int k = 0; k < CLASSES; k++)
    fprintf(stderr, " %s", class_name[k]);
  fprintf(stderr, " each stacks rest\n");
  return 0;
}

/* Returns 0 and says why if the command line is not understood. */
static int read_command(int count, char **words, command *to) {
  for (int k = 1; k < count; k++) {
    const char *key = words[k], *text = k + 1 < count ? words[k + 1] : NULL;
    if (!text) return print_usage();
    k++;
    char *end = "";
    if (!strcmp(key, "--seed"))
      to->seed = strtoull(text, &end, 10);
    else if (!strcmp(key, "--step"))
      to->step = strtoull(text, &end, 10);
    else if (!strcmp(key, "--count"))
      to->count = strtol(text, &end, 10);
    else if (!strcmp(key, "--seconds"))
      to->seconds = strtod(text, &end);
    else if (!strcmp(key, "--tol"))
      to->ask.tol = strtod(text, &end);
    else if (!strcmp(key, "--out"))
      to->out = text;
    else if (!strcmp(key, "--class")) {
      for (to->class = CLASSES - 1; to->class >= 0; to->class --)
        if (!strcmp(class_name[to->class], text)) break;
      if (!strcmp(text, "each")) to->class = EACH;
      if (!strcmp(text, "stacks")) to->class = STACKS;
      if (rest_kind_of(text) >= 0) to->class = REST - rest_kind_of(text);
      if (to->class == DRAWN) return print_usage();
    } else
      return print_usage();
    if (*end || !(to->ask.tol > 0)) return print_usage();
  }
  return 1;
}

/* ---- failures -------------------------------------------------------------------------------- */

/* Makes the problem small and writes it to DIR/rule-class-seed.txt. */
static int save_finding(const command *of, problem *p, int class, uint64_t seed,
                        const finding *found) {
  static const char *const word[RULES] = {
      "",     "refused",  "likely", "proved", "held",     "forces", "unseen", "contradiction",
      "bits", "odd-bits", "units",  "order",  "no-proof", "true-r", "true-u"};
  char path[text_size], title[text_size], source[text_size];
  snprintf(path, sizeof path, "%s/%s-%s-%llu.txt", of->out, word[found->rule], class_name[class],
           (unsigned long long)seed);
  if (finding_stands(p, found)) reduce_problem(p, found, 5);
  snprintf(title, sizeof title, "%s, made small", class_name[class]);
  snprintf(source, sizeof source, "properties, seed %llu, class %s", (unsigned long long)seed,
           class_name[class]);
  const int good = write_problem(path, p, found, title, source);
  if (!good) fprintf(stderr, "properties: %s: %s\n", path, strerror(errno));
  printf("%s: --seed %llu --count 1 --class %s: %s\n", path, (unsigned long long)seed,
         class_name[class], rule_text[found->rule]);
  if (found->rule == TRUE_R || found->rule == TRUE_U)
    printf("  true error %.1e, predicted %.1e, condition %.1e\n", found->is_true.error,
           found->predicted, found->is_true.condition);
  fflush(stdout);
  return good;
}

/* ---- tables ---------------------------------------------------------------------------------- */

static void tally_print(const tally *t) {
  printf("\n%-20s%9s%9s%9s%9s%9s%10s%9s%9s%11s%9s\n", "class", "problems", "solvable", "solved",
         "fine", "rounding", "stalled", "likely", "proved", "forces", "ms");
  for (int k = 0; k < CLASSES; k++) {
    if (!t[k].problems) continue;
    const long other = t[k].problems - t[k].status[DLS_OK] - t[k].status[DLS_NO_SOLUTION_LIKELY] -
                       t[k].status[DLS_NO_SOLUTION] - t[k].status[DLS_TO_ROUNDING];
    printf("%-20s%9ld%9ld%9ld%9ld%9ld%10ld%9ld%9ld%11.1e%9.2f\n", class_name[k], t[k].problems,
           t[k].visible, t[k].solved, t[k].fine, t[k].status[DLS_TO_ROUNDING], other,
           t[k].status[DLS_NO_SOLUTION_LIKELY], t[k].status[DLS_NO_SOLUTION], t[k].forces,
           1e3 * t[k].seconds / (double)t[k].problems);
  }
  printf(
      "solvable: planted, not hidden by rounding; solved, fine: of these by auto at tol and tol / "
      "100;\n"
      "rounding, stalled, likely, proved: auto of all problems; forces: worst residual_r of a "
      "solved one;\n"
      "ms: CPU of a problem\n");
  printf("\n%-20s", "rules broken");
  static const char *const head[RULES] = {"",       "error",  "likely",   "proved", "hold u",
                                          "hold r", "unseen", "contra",   "bits",   "odd bits",
                                          "units",  "order",  "no proof", "true r", "true u"};
  for (int k = 1; k < RULES; k++)
    printf("%9s", head[k]);
  printf("%9s%9s%9s%9s%9s\n", "(both)", "(doubt)", "(unkn)", "(other)", "(error)");
  for (int k = 0; k < CLASSES; k++) {
    if (!t[k].problems) continue;
    printf("%-20s", class_name[k]);
    for (int b = 1; b < RULES; b++)
      printf("%9ld", t[k].broken[b]);
    printf("%9ld%9ld%9ld%9ld%9.1e\n", t[k].both_true, t[k].doubtful, t[k].unknown, t[k].other,
           t[k].amplified);
  }
  printf(
      "counted, not broken: (both) an exact proof beside an answer that holds to rounding;\n"
      "(doubt) \"likely\" where another run has an answer that holds, the problem not being "
      "planted;\n"
      "runs: (unkn) solved, and the true answer not determined; (other) solved by an answer that "
      "is not the planted one;\n"
      "(error) largest true error of r over tol and the condition, rule 8 allows 1000\n");
}

/* Returns how many of n problems may stay unsolved at this share: three standard deviations and one
 * more than expected. */
static double bound_of(double share, long n) {
  const double expected = share * (double)n;
  return expected + 3 * sqrt(expected) + 1;
}

/* Returns 1 if auto has left no more of any class unsolved than it may; else says of which. */
static int tally_rates(const tally *t) {
  int good = 1;
  for (int k = 0; k < CLASSES; k++) {
    double share = unsolved_share;
    for (size_t i = 0; i < sizeof unsolved_of / sizeof unsolved_of[0]; i++)
      if (!strcmp(unsolved_of[i].class, class_name[k])) share = unsolved_of[i].share;
    const long lost = t[k].visible - t[k].solved;
    const double bound = bound_of(share, t[k].visible);
    if ((double)lost <= bound) continue;
    printf("not solved of class %s: %ld, bound %.1f\n", class_name[k], lost, bound);
    good = 0;
  }
  return good;
}

/* Returns 1 if every rule was kept, and prints how many were not. */
static int tally_conclude(const tally *t, double seconds, long runs) {
  long broken[RULES] = {0}, symmetric = 0, lost = 0, problems = 0;
  int good = 1;
  for (int k = 0; k < CLASSES; k++) {
    for (int b = 1; b < RULES; b++)
      broken[b] += t[k].broken[b];
    problems += t[k].problems;
    if (!strcmp(class_name[k], "bonded")) continue; /* friction without a limit: by its own rate */
    symmetric += t[k].symmetric;
    lost += t[k].lost_symmetric;
  }
  const double cpu = (double)clock() / CLOCKS_PER_SEC;
  printf("\n%ld problems, %ld solves, %.0f s, %.0f s CPU: %.0f problems a minute of CPU\n",
         problems, runs, seconds, cpu, 60 * (double)problems / cpu);
  for (int k = 1; k < RULES; k++) {
    if (!broken[k]) continue;
    printf("broken in %ld problems: %s:", broken[k], rule_text[k]);
    for (int way = 0; way < WAYS; way++) {
      long by = 0;
      for (int c = 0; c < CLASSES; c++)
        by += t[c].by[k][way];
      if (by) printf(" %s %ld", way == WAYS - 1 ? "LCP" : dls_method_name((dls_method)way), by);
    }
    printf("\n");
    good = 0;
  }
  const double bound = bound_of(unsolved_share, symmetric);
  printf("not solved among %ld symmetric solvable: %ld, bound %.1f\n", symmetric, lost, bound);
  return tally_rates(t) && good && (double)lost <= bound;
}

static void tally_add(tally *t, const problem *p, const verdict *v) {
  t->problems++;
  if (v->status >= 0 && v->status <= DLS_TO_ROUNDING) t->status[v->status]++;
  t->visible += v->visible;
  t->solved += v->visible && v->solved;
  t->fine += v->visible && v->solved_fine;
  t->symmetric += v->visible && p->symmetric;
  t->lost_symmetric += v->visible && p->symmetric && !v->solved;
  t->both_true += v->both_true;
  t->doubtful += v->doubtful;
  t->unknown += v->unknown;
  t->other += v->other;
  if (v->amplified > t->amplified) t->amplified = v->amplified;
  if (v->visible && v->forces > t->forces) t->forces = v->forces;
  for (int k = 0; k < v->findings; k++) {
    const finding *found = &v->finding[k];
    const run *how = &found->second;
    t->broken[found->rule]++;
    t->by[found->rule][how->rows ? WAYS - 1 : (int)how->method]++;
  }
}

int main(int count, char **words) {
  static tally all[CLASSES];
  static long saved[RULES];
  static problem p, small;
  static verdict v;
  command of = {.seed = 1,
                .step = 1,
                .count = 2000,
                .class = DRAWN,
                .ask = {1e-8},
                .out = "build/properties"};
  of.seconds = INFINITY;
  if (!read_command(count, words, &of)) return 2;
  setvbuf(stdout, NULL, _IOLBF, 0);
  if (of.class == STACKS)
    return !stack_run(of.seed, of.step, of.count, of.ask.tol, stack_solve_global, NULL);
  if (of.class <= REST) return !rest_run(of.seed, of.step, of.count, REST - of.class);
  if (mkdir(of.out, 0777) && errno != EEXIST) {
    fprintf(stderr, "properties: %s: %s\n", of.out, strerror(errno));
    return 2;
  }
  printf("seeds from %llu, tol %g\n", (unsigned long long)of.seed, of.ask.tol);
  const double start = wall_clock();
  long runs = 0;
  int written = 1;
  for (long i = 0; i < of.count && wall_clock() - start < of.seconds; i++) {
    const uint64_t seed = of.seed + of.step * (uint64_t)i;
    const int class = of.class >= 0      ? of.class
                      : of.class == EACH ? (int)(i % CLASSES)
                                         : class_of_seed(seed);
    if (of.class == EACH && class_is_dear(class) && i / CLASSES % 4) continue;
    const clock_t began = clock();
    generate(class, seed, &p);
    check_problem(&p, seed, &of.ask, &v);
    all[class].seconds += (double)(clock() - began) / CLOCKS_PER_SEC;
    tally_add(&all[class], &p, &v);
    if (v.visible && p.symmetric && !v.solved)
      printf("not solved: --seed %llu --count 1 --class %s\n", (unsigned long long)seed,
             class_name[class]);
    runs += v.runs;
    for (int k = 0; k < v.findings; k++) {
      const rule broken = v.finding[k].rule;
      if (all[class].broken[broken] > saved_most || saved[broken]++ >= saved_rule) continue;
      problem_copy(&small, &p);
      written &= save_finding(&of, &small, class, seed, &v.finding[k]);
    }
  }
  tally_print(all);
  const int good = tally_conclude(all, wall_clock() - start, runs);
  return !written ? 2 : !good;
}
