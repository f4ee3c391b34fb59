/*
 * profile.c: delassus profile NAME...: every method on many problems: performance profiles, and how
 * far auto is from the fastest single method.
 */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "profile.h"
#include "race.h"

enum { PROFILE_RUNGS = 7, PROFILE_TARGETS = 3 };

static const double profile_tol[PROFILE_RUNGS] = {1e-2, 1e-4, 1e-6, 1e-8, 1e-10, 1e-12, 1e-14};
static const int profile_target[PROFILE_TARGETS] = {1, 3, 5};

static void profile_usage(FILE *out) {
  fputs(
      "Usage: delassus profile [OPTION]... FILE|SCENE...\n"
      "  or:  delassus profile [OPTION]... --W=W --q=Q --mu=MU (or --stiffness=K ...)\n"
      "Runs each method on many contact problems to tolerances 1e-2 to 1e-14: a table of\n"
      "each, the CPU of auto over that of the fastest single method, and a performance profile to\n"
      "1e-8. Writes profile.csv, profile.png and profile.svg.\n"
      "\n"
      "  -r, --repeat=N        time each solve up to N times and use the least (15)\n"
      "  -l, --limit=S         CPU seconds for a solve (0.5), or 30 times the fastest if that is\n"
      "                        more; in need ten times as many\n"
      "  -b, --budget=S        approximate CPU seconds for a problem (6)\n"
      "  -o, --out=DIR         folder for the files (a new one under TMPDIR, which is "
      "printed)\n" LAST_USAGE "\n"
      "Exit status: 0, 1 if auto failed on a problem, 2 bad input.\n\n",
      out);
  source_usage(out);
}

/* All that was measured; problems are counted as they are done. */
typedef struct profile {
  int solvers, problems, most;
  contender who[MOST_CONTENDERS];
  char (*name)[96];
  double *seconds; /* (rung * solvers + solver) * most + problem; as in profile.h */
  FILE *csv;
  int failed; /* problems that auto did not answer to every tolerance */
} profile;

static double *profile_seconds(const profile *p, int rung, int solver, int which) {
  return &p->seconds[(rung * p->solvers + solver) * p->most + which];
}

/* ---- measuring ------------------------------------------------------------------------------- */

/* Takes the times of a race. A proof that there is no solution is an answer. */
static void profile_take(profile *p, const race *a, const char *name) {
  int failed = 0;
  (void)snprintf(p->name[p->problems], sizeof p->name[0], "%s", name);
  for (int rung = 0; rung < PROFILE_RUNGS; rung++) {
    for (int k = 0; k < p->solvers; k++)
      *profile_seconds(p, rung, k, p->problems) = PROFILE_TOOK_NO_PART;
    for (int i = 0; i < a->count; i++) {
      const trial *t = race_trial(a, i, rung);
      for (int k = 0; k < p->solvers; k++)
        if (strcmp(p->who[k].name, a->who[i].name) == 0)
          *profile_seconds(p, rung, k, p->problems) = is_answer(t->end) ? t->seconds
                                                      : t->end == ENDED_UNDECIDED
                                                          ? PROFILE_NOT_DECIDED
                                                          : PROFILE_NOT_ANSWERED;
      fprintf(p->csv, "%s,%d,%d,%s,%.0e,%s,%.4e,%d,%.3e\n", quote(AS_CSV, name).text, a->d, a->nc,
              a->who[i].name, profile_tol[rung], ending_word(t->end), t->seconds, t->iterations,
              t->residual);
    }
    failed |= !is_answer(race_trial(a, 0, rung)->end);
  }
  fflush(p->csv);
  p->failed += failed;
  p->problems++;
}

static int profile_add(profile *p, const char *name, const race_options *o) {
  const race_plan plan = {.rungs = PROFILE_RUNGS,
                          .tol = profile_tol,
                          .repeat = o->repeat,
                          .limit = o->limit,
                          .budget = o->budget};
  problem subject = {0};
  race a = {0};
  dls_error error = {.status = DLS_E_MEMORY, .message = "out of memory"};
  if (!problem_open(name, &o->from, &subject)) {
    problem_free(&subject);
    return was_interrupted();
  }
  const dls_status status = race_run(&a, &subject.contact, &subject, &plan, &error);
  if (status)
    (void)complain_of(name, &error);
  else if (!a.interrupted)
    profile_take(p, &a, subject.name);
  race_free(&a);
  problem_free(&subject);
  return !status;
}

/* ---- what it says ---------------------------------------------------------------------------- */

static double fastest_of(const profile *p, int rung, int first, int which) {
  double fastest = INFINITY;
  for (int k = first; k < p->solvers; k++) {
    const double seconds = *profile_seconds(p, rung, k, which);
    if (seconds >= 0) fastest = fmin(fastest, seconds);
  }
  return fastest;
}

/* Prints for each method how many of those that it takes part in it answered to a tolerance, and
 * its CPU over the fastest. */
static void print_target(const profile *p, int rung, double *ratio) {
  printf("\n%-22s  to %.0e: solved   CPU/fastest: median     worst\n", "method", profile_tol[rung]);
  for (int k = 0; k < p->solvers; k++) {
    int count = 0, worst = 0, parts = 0, open = 0;
    double most = 0;
    for (int i = 0; i < p->problems; i++) {
      const double fastest = fastest_of(p, rung, 0, i), seconds = *profile_seconds(p, rung, k, i);
      parts += !isnan(seconds);
      open += seconds < 0;
      if (!isfinite(seconds) || seconds < 0) continue;
      if (seconds / fastest > most) {
        most = seconds / fastest;
        worst = i;
      }
      ratio[count++] = seconds / fastest;
    }
    qsort(ratio, (size_t)count, sizeof *ratio, ascending);
    if (count)
      printf("%-22s  %11d/%-3d  %18.2f  %8.1f on %s", p->who[k].name, count, parts,
             ratio[(count - 1) / 2], most, quote(AS_SHOWN, p->name[worst]).text);
    else if (parts)
      printf("%-22s  %11d/%-3d", p->who[k].name, 0, parts);
    else
      printf("%-22s  takes part in none", p->who[k].name);
    if (open) printf("; not decided: %d", open);
    putchar('\n');
  }
}

/* Prints the CPU of auto over the fastest single method, over all problems and tolerances. */
static void print_auto(const profile *p, double *ratio) {
  int count = 0, worst = 0, worst_rung = 0, only_others = 0, only_auto = 0;
  double most = 0;
  for (int rung = 0; rung < PROFILE_RUNGS; rung++)
    for (int i = 0; i < p->problems; i++) {
      const double single = fastest_of(p, rung, 1, i), own = *profile_seconds(p, rung, 0, i);
      const double seconds = own >= 0 ? own : INFINITY;
      only_others += isfinite(single) && !isfinite(seconds);
      only_auto += !isfinite(single) && isfinite(seconds);
      if (!isfinite(single) || !isfinite(seconds)) continue;
      if (seconds / single > most) {
        most = seconds / single;
        worst = i;
        worst_rung = rung;
      }
      ratio[count++] = seconds / single;
    }
  qsort(ratio, (size_t)count, sizeof *ratio, ascending);
  if (!count) return;
  printf("\nauto over the fastest single method, %d problem%s, 1e-2 to 1e-14: median %.2f, nine "
         "tenths below %.2f, worst %.1f (%s to %.0e)\n",
         p->problems, plural(p->problems), ratio[(count - 1) / 2], ratio[9 * (count - 1) / 10],
         most, quote(AS_SHOWN, p->name[worst]).text, profile_tol[worst_rung]);
  printf("solved by auto alone %d, by others only %d of %d\n", only_auto, only_others,
         PROFILE_RUNGS * p->problems);
}

/* Draws the profile of the middle target. */
static int draw_middle(const profile *p, const char *directory) {
  const int rung = profile_target[PROFILE_TARGETS / 2];
  const char *solvers[MOST_CONTENDERS];
  double *seconds = malloc((size_t)p->solvers * (size_t)p->problems * sizeof *seconds);
  char title[120];
  if (!seconds) return complain("out of memory");
  for (int k = 0; k < p->solvers; k++) {
    solvers[k] = p->who[k].name;
    for (int i = 0; i < p->problems; i++)
      seconds[k * p->problems + i] = *profile_seconds(p, rung, k, i);
  }
  (void)snprintf(title, sizeof title, "Every method on %d problem%s, to a residual of %.0e",
                 p->problems, plural(p->problems), profile_tol[rung]);
  const profile_picture picture = {.directory = directory,
                                   .name = "profile",
                                   .title = title,
                                   .solvers = p->solvers,
                                   .problems = p->problems,
                                   .solver = solvers,
                                   .seconds = seconds};
  const int good = draw_profile(&picture);
  free(seconds);
  return good;
}

/* ---- the command ----------------------------------------------------------------------------- */

static int run_profile(int count, char **list, const race_options *o) {
  profile p = {.most = count};
  p.solvers = list_contenders(p.who);
  const size_t cells = PROFILE_RUNGS * (size_t)p.solvers * (size_t)count;
  double *ratio = malloc(PROFILE_RUNGS * (size_t)count * sizeof *ratio);
  p.name = malloc((size_t)count * sizeof *p.name);
  p.seconds = malloc(cells * sizeof *p.seconds);
  int good = p.name && p.seconds && ratio;
  if (!good) (void)complain("out of memory");
  const char *out = good ? take_folder(o->out, "profile", NULL) : NULL;
  if (good)
    good = out &&
           (p.csv = open_growing(out, "profile.csv",
                                 "problem,d,nc,method,tol,verdict,cpu_s,iterations,residual\n"));
  for (int i = 0; i < count && good && !was_interrupted(); i++)
    good = profile_add(&p, list[i], o);
  if (good) good = close_file(p.csv, "profile.csv");
  if (good && p.problems) {
    for (int t = 0; t < PROFILE_TARGETS && prints_text(); t++)
      print_target(&p, profile_target[t], ratio);
    if (prints_text()) print_auto(&p, ratio);
    good = draw_middle(&p, out);
  }
  free(ratio);
  free(p.name);
  free(p.seconds);
  char why[80];
  (void)snprintf(why, sizeof why, "auto fails on %d of %d problem%s", p.failed, p.problems,
                 plural(p.problems));
  return end_table(!good      ? EXIT_BAD_INPUT
                   : p.failed ? EXIT_NOT_SOLVED
                              : EXIT_SOLVED,
                   why, "profile", out, "profile.csv");
}

int command_profile(int argc, char **argv) {
  static const command profile_command = {race_option_rows, profile_usage, NULL, 0};
  race_options o = {.repeat = 15, .limit = 0.5, .budget = 6};
  const int stop = take_options(argc, argv, &profile_command, &o);
  if (stop != GO_ON) return stop;
  int count = argc - optind;
  char **names = source_names(&count, argv, &o.from);
  if (!names) return EXIT_BAD_INPUT;
  watch_interrupt();
  if (!count) return EXIT_SOLVED;
  return run_profile(count, names, &o);
}
