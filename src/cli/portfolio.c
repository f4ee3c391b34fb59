/*
 * portfolio.c: delassus profile --portfolio NAME...: what each step of auto is worth on many
 * problems: how often auto takes it, how often it ends the solve, its CPU; and each step as a plan
 * of its own, from r = 0: how often it solves, and how often no other one is quicker.
 */
#include <math.h>
#include <stdlib.h>

#include "race.h"

enum { most_steps = 32, quick_repeats = 3 };
static const double patience_alone = 30;  /* CPU of a step alone, over that of auto */
static const double quick_seconds = 5e-3; /* of a solve that is timed again */

typedef struct step_worth {
  int tried, ended; /* problems */
  double seconds;
  int alone, first; /* problems */
} step_worth;

typedef struct portfolio {
  int problems, solved, none; /* none: proved that there is no solution */
  double seconds;             /* of auto */
  step_worth of[most_steps];
} portfolio;

/* Solves by auto, or by a plan of its; the clock runs. *seconds := CPU, the least of some times for
 * quick ones. */
static dls_status solve_by(const dls_contact *contact, const char *plan, double tol, double limit,
                           double *r, double *seconds, dls_info *info, dls_error *error) {
  dls_solver_settings s;
  dls_status status = DLS_OK;
  dls_solver_settings_init(&s);
  s.plan = plan;
  s.limits = (dls_limits){.tol = tol, .progress = show_progress, .cpu_seconds = limit};
  *seconds = INFINITY;
  for (int k = 0; k < quick_repeats && status >= 0 && (k == 0 || *seconds < quick_seconds); k++) {
    const double start = cpu_seconds();
    status = dls_solve(contact, &s, r, NULL, info, error);
    *seconds = fmin(*seconds, cpu_seconds() - start);
  }
  return status;
}

/* Adds what the steps of a solve by auto were worth. */
static void add_auto(portfolio *p, const dls_info *info, double seconds) {
  int tried[most_steps] = {0};
  for (int k = 0; k < info->stages; k++) {
    const dls_stage *s = &info->stage[k];
    p->of[s->step].tried += !tried[s->step];
    p->of[s->step].seconds += s->cpu_seconds;
    tried[s->step] = 1;
  }
  p->problems++;
  p->seconds += seconds;
  p->solved += is_solved(info->status);
  p->none += info->status == DLS_NO_SOLUTION;
  if (!is_solved(info->status) && info->status != DLS_NO_SOLUTION) return;
  if (info->stages) p->of[info->stage[info->stages - 1].step].ended++;
}

/* Returns 1 if the step is no word of a plan, stands for another, or would take too long. */
static int is_left_out(dls_step step, const dls_contact *contact) {
  const int searches = step == DLS_STEP_HOMOTOPY || step == DLS_STEP_SCATTER;
  if (step == DLS_STEP_SWEEPS || step == DLS_STEP_INTERIOR || step == DLS_STEP_ON_K) return 1;
  if (step != DLS_STEP_LEMKE && !searches) return 0;
  return race_is_too_large(searches ? DLS_HOMOTOPY : DLS_LEMKE, contact->d, contact->nc);
}

/* Runs each step alone. Returns an error of the library, or DLS_OK. */
static dls_status add_alone(portfolio *p, const dls_contact *contact, double tol, double limit,
                            double *r, dls_error *error) {
  double least = INFINITY, seconds;
  int first = -1;
  for (int k = 0; dls_step_name((dls_step)k) && k < most_steps && !was_interrupted(); k++) {
    dls_info info;
    if (is_left_out((dls_step)k, contact)) continue;
    const dls_status status =
        solve_by(contact, dls_step_name((dls_step)k), tol, limit, r, &seconds, &info, error);
    if (status < 0) return status;
    if (!is_solved(status)) continue;
    p->of[k].alone++;
    if (seconds < least) first = k;
    least = fmin(least, seconds);
  }
  if (first >= 0) p->of[first].first++;
  return DLS_OK;
}

static int add_problem(portfolio *p, const char *name, const source *from, double tol,
                       double limit) {
  problem subject = {0};
  dls_error error = {.status = DLS_E_MEMORY, .message = "out of memory"};
  dls_info info;
  double seconds = 0;
  const dls_contact *contact = &subject.contact;
  if (!problem_open(name, from, &subject)) {
    problem_free(&subject);
    return 0;
  }
  double *r = malloc((size_t)contact->d * (size_t)contact->nc * sizeof *r);
  dls_status status = r ? DLS_OK : DLS_E_MEMORY;
  if (!status) status = solve_by(contact, NULL, tol, 0, r, &seconds, &info, &error);
  if (status >= 0 && !was_interrupted()) {
    add_auto(p, &info, seconds);
    status = add_alone(p, contact, tol, fmax(limit, patience_alone * seconds), r, &error);
  }
  progress_end();
  if (status < 0) (void)complain_of(name, &error);
  free(r);
  problem_free(&subject);
  return status >= 0;
}

static void print_portfolio(const portfolio *p, double tol) {
  double all = 0;
  for (int k = 0; k < most_steps; k++)
    all += p->of[k].seconds;
  tell("auto on %d problem%s to %.0e: %d solved, %d proved to have no solution, %.3g s of CPU\n\n",
       p->problems, plural(p->problems), tol, p->solved, p->none, p->seconds);
  tell("%-21s  in auto: tried  ended it      CPU s  share   alone: solves  first\n", "step");
  for (int k = 0; k < most_steps && dls_step_name((dls_step)k); k++) {
    const step_worth *w = &p->of[k];
    if (!w->tried && !w->alone) continue;
    tell("%-21s  %14d  %8d  %9.3g  %3.0f %%  %14d  %5d\n", dls_step_name((dls_step)k), w->tried,
         w->ended, w->seconds, all > 0 ? 100 * w->seconds / all : 0., w->alone, w->first);
  }
}

static void portfolio_json(const portfolio *p, const char *why) {
  int rows = 0;
  print_json_head("profile", why ? "not_solved" : "solved", why);
  printf(",\n  \"problems\": %d,\n  \"solved\": %d,\n  \"no_solution\": %d", p->problems, p->solved,
         p->none);
  print_json_field(stdout, "cpu_seconds", p->seconds);
  fputs(",\n  \"rows\": [", stdout);
  for (int k = 0; k < most_steps && dls_step_name((dls_step)k); k++) {
    const step_worth *w = &p->of[k];
    if (!w->tried && !w->alone) continue;
    printf("%s\n    {\"step\": \"%s\", \"tried\": %d, \"ended\": %d, \"cpu_seconds\": ",
           rows++ ? "," : "", dls_step_name((dls_step)k), w->tried, w->ended);
    print_json_number(stdout, w->seconds);
    printf(", \"alone\": %d, \"first\": %d}", w->alone, w->first);
  }
  puts("\n  ]\n}");
}

int run_portfolio(int count, char **names, const source *from, double tol, double limit) {
  portfolio p = {0};
  char why[80];
  int good = 1;
  for (int i = 0; i < count && good && !was_interrupted(); i++)
    good = add_problem(&p, names[i], from, tol, limit);
  if (!good) return EXIT_BAD_INPUT;
  if (p.problems) print_portfolio(&p, tol);
  const int failed = p.problems - p.solved - p.none;
  (void)snprintf(why, sizeof why, "auto fails on %d of %d problem%s", failed, p.problems,
                 plural(p.problems));
  if (is_json()) portfolio_json(&p, failed ? why : NULL);
  return end_command(failed ? EXIT_NOT_SOLVED : EXIT_SOLVED, why);
}
