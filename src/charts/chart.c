/*
 * chart.c: delassus chart FILE|SCENE: work against precision of every method on one problem: a
 * ladder of tolerances, a picture, a table, and the fastest method.
 *
 * The true error of an answer is its distance from a reference: of the methods that solve to 1e-8,
 * those whose answers agree share one reference, the answer with the least residual among them; how
 * well the next best agrees with it bounds what an error can mean. Where dls_contact_prove proves
 * the reference, errors are measured from the improved one, and the radius of the proof is added:
 * they are bounds then. Methods that do not agree found different solutions.
 */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "chart.h"

/* Answers closer than this, relative, are one: certified to 1e-8 they agree to this unless the
 * problem amplifies errors ten thousand times. */
static const double same_answer = 1e-4;
static const double certain = 1e-8; /* tolerance of answers that are compared */
enum { most_rows_of_rank = 1500, most_rows_of_prediction = 600 }; /* each takes a second there */

/* auto is the advice unless another method is faster by more than this on the whole. */
static const double prefer_auto = 1.25;

static void chart_usage(FILE *out) {
  fputs("Usage: delassus chart [OPTION]... FILE|SCENE\n"
        "  or:  delassus chart [OPTION]... --W=W --q=Q --mu=MU (or --stiffness=K ...)\n"
        "Runs each method on one contact problem (a file, a scene of 'delassus scene --list', or\n"
        "matrices) to tolerances 1e-2 to 1e-14, and compares CPU, residual, true error and\n"
        "convergence. Prints a table and the fastest method; writes chart.csv, history.csv,\n"
        "chart.png and chart.svg.\n"
        "\n"
        "  -r, --repeat=N        time each solve up to N times and use the least (25)\n"
        "  -l, --limit=S         CPU seconds for a solve (1), or 30 times the fastest if that is\n"
        "                        more; in need ten times as many\n"
        "  -b, --budget=S        approximate CPU seconds of all solves (12)\n"
        "  -o, --out=DIR         folder for the files (a new one under TMPDIR, which is "
        "printed)\n" LAST_USAGE "\n"
        "Exit status: 0, 1 if auto failed at a tolerance, 2 bad input.\n\n",
        out);
  source_usage(out);
}

/* ---- errors ---------------------------------------------------------------------------------- */

/* Returns the tightest rung that contender k solved, -1 if that is above `certain`. */
static int chart_best_rung(const chart *c, int k) {
  for (int rung = c->race.rungs - 1; rung >= 0; rung--)
    if (race_trial(&c->race, k, rung)->end == ENDED_SOLVED)
      return c->tol[rung] <= certain * 1.001 ? rung : -1;
  return -1;
}

/* Turns the answers r into u where errors are measured in u. Returns the scale of errors of u, |q|,
 * or 0 for r: the reference's own norm. */
static dls_status chart_to_u(chart *c, dls_error *error) {
  race *a = &c->race;
  dls_status status = DLS_OK;
  double *u = malloc((size_t)a->d * (size_t)a->nc * sizeof *u);
  if (!u) return DLS_E_MEMORY;
  for (int k = 0; k < a->count && !status; k++)
    for (int rung = 0; rung < a->rungs && !status; rung++) {
      dls_certificate certificate;
      if (race_trial(a, k, rung)->end != ENDED_SOLVED) continue;
      double *r = race_answer(a, k, rung);
      status = dls_contact_certify(a->problem, r, u, &certificate, error);
      if (!status) memcpy(r, u, (size_t)a->d * (size_t)a->nc * sizeof *u);
    }
  free(u);
  return status;
}

/* Returns the distance of two answers, relative to the second or, of u, to q. */
static double chart_distance(const chart *c, const double *x, const double *reference) {
  const size_t m = (size_t)c->race.d * (size_t)c->race.nc;
  const double scale = distance(m, c->in_u ? c->race.problem->q : reference, NULL);
  return distance(m, x, reference) / (scale > 0 ? scale : 1);
}

static double chart_residual(const chart *c, int k) {
  return race_trial(&c->race, k, chart_best_rung(c, k))->residual;
}

/* Puts contender k, which comes in the order of growing residuals, to an answer it agrees with. */
static void chart_assign(chart *c, int k) {
  const double *x = race_answer(&c->race, k, chart_best_rung(c, k));
  int at = 0;
  for (; at < c->answers; at++) {
    const int of = c->answer[at].of;
    const double apart = chart_distance(c, x, race_answer(&c->race, of, chart_best_rung(c, of)));
    if (apart > same_answer) continue;
    if (c->answer[at].found_by++ == 1) c->answer[at].agreement = apart;
    break;
  }
  if (at == c->answers) c->answer[c->answers++] = (chart_answer){k, 1, NAN, NULL};
  c->went_to[k] = at;
}

/* Groups the answers by agreement. */
static void chart_group(chart *c) {
  const race *a = &c->race;
  int left = 0;
  for (int k = 0; k < a->count; k++) {
    c->went_to[k] = -1;
    left += chart_best_rung(c, k) >= 0;
  }
  while (left-- > 0) {
    int best = -1;
    for (int k = 0; k < a->count; k++)
      if (chart_best_rung(c, k) >= 0 && c->went_to[k] < 0 &&
          (best < 0 || chart_residual(c, k) < chart_residual(c, best)))
        best = k;
    chart_assign(c, best);
  }
}

static const double *chart_reference_of(const chart *c, int at) {
  const int of = c->answer[at].of;
  return c->answer[at].proved ? c->answer[at].proved
                              : race_answer(&c->race, of, chart_best_rung(c, of));
}

/* Proves the references of errors in r; without memory returns DLS_E_MEMORY. */
static dls_status chart_prove(chart *c, dls_error *error) {
  const size_t m = (size_t)c->race.d * (size_t)c->race.nc;
  if (c->in_u || m > most_rows_of_prediction) return DLS_OK;
  for (int at = 0; at < c->answers; at++) {
    chart_answer *answer = &c->answer[at];
    const double *r = race_answer(&c->race, answer->of, chart_best_rung(c, answer->of));
    dls_proof proof;
    double *improved = malloc(m * sizeof *improved);
    if (!improved) return DLS_E_MEMORY;
    const dls_status status = dls_contact_prove(c->race.problem, r, &proof, improved, error);
    if (status || proof.kind != DLS_PROVED) {
      free(improved);
      if (status) return status;
      continue;
    }
    answer->proved = improved;
    answer->agreement = proof.radius;
  }
  return DLS_OK;
}

/* Measures the errors of all from the nearest answer: a method may go to another one at another
 * tolerance. The error of a reference that is not proved is not known; its agreement takes its
 * place (fmax leaves NaN out). */
static void chart_errors(chart *c) {
  const race *a = &c->race;
  for (int k = 0; k < a->count; k++)
    for (int rung = 0; rung < a->rungs; rung++) {
      double *error = &c->error[k * a->rungs + rung];
      *error = NAN;
      if (race_trial(a, k, rung)->end != ENDED_SOLVED) continue;
      for (int at = 0; at < c->answers; at++) {
        const double apart = chart_distance(c, race_answer(a, k, rung), chart_reference_of(c, at));
        const double e = fmax(apart + (c->answer[at].proved ? c->answer[at].agreement : 0),
                              c->answer[at].agreement);
        if (!(*error <= e)) *error = e;
      }
    }
}

/* Finds the largest error over residual of each contender, where the reference is good enough. */
static void chart_amplify(chart *c) {
  for (int k = 0; k < c->race.count; k++) {
    c->amplification[k] = NAN;
    if (c->went_to[k] < 0) continue;
    const double noise = c->answer[c->went_to[k]].agreement;
    for (int rung = 0; rung < c->race.rungs; rung++) {
      const trial *t = race_trial(&c->race, k, rung);
      const double error = c->error[k * c->race.rungs + rung], ratio = error / t->residual;
      if (t->end == ENDED_SOLVED && error > 10 * noise && t->residual > 0 &&
          !(ratio <= c->amplification[k]))
        c->amplification[k] = ratio;
    }
  }
}

/* Asks the library how much larger than a residual the error of r may be; without memory returns
 * DLS_E_MEMORY. */
static dls_status chart_predict(chart *c, dls_error *error) {
  dls_sensitivity s;
  c->predicted = NAN;
  if (c->in_u || !c->answers || c->race.d * c->race.nc > most_rows_of_prediction) return DLS_OK;
  const int of = c->answer[0].of;
  const double *r = race_answer(&c->race, of, chart_best_rung(c, of));
  const dls_status status = dls_contact_sensitivity(c->race.problem, r, &s, error);
  if (!status) c->predicted = fmin(s.amplification, s.amplification_r);
  return status == DLS_E_MEMORY ? status : DLS_OK;
}

/* ---- the advice ------------------------------------------------------------------------------ */

/* Fills worst[] and returns the mean of log(CPU over the fastest) of contender k, INFINITY if a
 * rung is missing that another solved. */
static double chart_mean(chart *c, int k) {
  double sum = 0, worst = 1;
  int rungs = 0;
  for (int rung = 0; rung < c->race.rungs; rung++) {
    const double fastest = race_fastest(&c->race, rung);
    const trial *t = race_trial(&c->race, k, rung);
    if (!isfinite(fastest)) continue;
    const double ratio = t->end == ENDED_SOLVED ? t->seconds / fastest : INFINITY;
    worst = fmax(worst, ratio);
    sum += log(ratio);
    rungs++;
  }
  c->worst[k] = rungs ? worst : INFINITY;
  return rungs ? sum / rungs : INFINITY;
}

static void chart_choose(chart *c) {
  double best = INFINITY;
  c->take = -1;
  for (int k = 0; k < c->race.count; k++) {
    const double mean = chart_mean(c, k);
    const double least = c->take == 0 ? best - log(prefer_auto) : best; /* auto comes first */
    if (!(mean < least)) continue;
    best = mean;
    c->take = k;
  }
}

static void print_chart(const chart *c) {
  char text[400], cell[64];
  const race *a = &c->race;
  printf("%s: %dD, %d candidate%s; CPU, and in brackets CPU over the fastest\n\n%-22s",
         quote(AS_SHOWN, c->subject.name).text, a->d, a->nc, plural(a->nc), "method");
  for (int i = 0; i < CHART_TARGETS; i++)
    printf("  %-18.0e", c->tol[chart_target[i]]);
  puts("  error / residual");
  for (int k = 0; k < a->count; k++) {
    printf("%-22s", a->who[k].name);
    for (int i = 0; i < CHART_TARGETS; i++) {
      chart_cell(c, k, chart_target[i], cell, sizeof cell);
      printf("  %-18s", cell);
    }
    chart_amplification(c, k, cell, sizeof cell);
    printf("  %s", cell);
    if (c->answers > 1 && c->went_to[k] >= 0) printf("  answer %c", 'A' + c->went_to[k]);
    putchar('\n');
  }
  chart_reference(c, text, sizeof text);
  printf("\nerrors in %s; %s\n", c->in_u ? "u, W being rank deficient" : "r", text);
  if (isfinite(c->predicted))
    printf("error / residual as the sensitivity predicts: %.2g\n", c->predicted);
  chart_advice(c, text, sizeof text);
  puts(text);
}

/* ---- the command ----------------------------------------------------------------------------- */

/* Records how each contender converges, once more, down to the last tolerance. */
static dls_status chart_histories(chart *c, double limit, dls_error *error) {
  race *a = &c->race;
  const double tol = c->tol[a->rungs - 1];
  double *r = malloc((size_t)a->d * (size_t)a->nc * sizeof *r);
  dls_status status = r ? DLS_OK : DLS_E_MEMORY;
  for (int k = 0; k < a->count && status >= 0 && !was_interrupted(); k++) {
    const double seconds = fmax(limit, 4 * race_trial(a, k, a->rungs - 1)->seconds);
    status = record_history(&c->history[k], a, k, tol, seconds, r, error);
  }
  progress_end();
  free(r);
  return status < 0 ? status : DLS_OK;
}

static dls_status chart_measure(chart *c, const race_options *o, dls_error *error) {
  for (int rung = 0; rung < CHART_RUNGS; rung++)
    c->tol[rung] = pow(10, -2 - rung);
  const race_plan plan = {.rungs = CHART_RUNGS,
                          .tol = c->tol,
                          .repeat = o->repeat,
                          .limit = o->limit,
                          .budget = o->budget};
  dls_status status = race_run(&c->race, &c->subject.contact, &c->subject, &plan, error);
  if (status) return status;
  const size_t count = (size_t)c->race.count;
  c->error = malloc(count * CHART_RUNGS * sizeof *c->error);
  c->history = calloc(count, sizeof *c->history);
  if (!c->error || !c->history) return DLS_E_MEMORY;
  dls_diagnosis facts;
  status = dls_contact_diagnose(&c->subject.contact, most_rows_of_rank, &facts, error);
  c->in_u = !status && facts.rank != c->race.d * c->race.nc; /* not known: -1 */
  if (!status && c->in_u) status = chart_to_u(c, error);
  if (status) return status;
  chart_group(c);
  status = chart_prove(c, error);
  if (status) return status;
  chart_errors(c);
  chart_amplify(c);
  status = chart_predict(c, error);
  if (status) return status;
  chart_choose(c);
  return chart_histories(c, o->limit, error);
}

/* Returns the first rung that auto did not solve, -1 for none. */
static int chart_fails(const chart *c) {
  for (int rung = 0; rung < c->race.rungs; rung++)
    if (race_trial(&c->race, 0, rung)->end != ENDED_SOLVED) return rung;
  return -1;
}

static int run_chart(const char *name, const race_options *o) {
  const char *out = NULL;
  chart c = {.limit = o->limit};
  dls_error error = {.status = DLS_E_MEMORY, .message = "out of memory"};
  int result = EXIT_BAD_INPUT;
  dls_status status = DLS_OK;
  if (problem_open(name, &o->from, &c.subject) && (out = take_folder(o->out, "chart", name)))
    status = chart_measure(&c, o, &error);
  if (status)
    (void)complain_of(name, &error);
  else if (out) {
    if (prints_text()) print_chart(&c);
    result = draw_chart(&c, out);
    const int rung = chart_fails(&c);
    char why[80] = "";
    if (result == EXIT_SOLVED && rung >= 0) {
      result = EXIT_NOT_SOLVED;
      (void)snprintf(why, sizeof why, "auto to %.0e: %s", c.tol[rung],
                     ending_word(race_trial(&c.race, 0, rung)->end));
    }
    result = end_table(result, why, "chart", out, "chart.csv");
  }
  race_free(&c.race);
  problem_free(&c.subject);
  for (int at = 0; at < c.answers; at++)
    free(c.answer[at].proved);
  free(c.error);
  free(c.history);
  return result;
}

int command_chart(int argc, char **argv) {
  static const command chart_command = {race_option_rows, chart_usage, NULL, 0};
  race_options o = {.repeat = 25, .limit = 1, .budget = 12};
  const int stop = take_options(argc, argv, &chart_command, &o);
  if (stop != GO_ON) return stop;
  int count = argc - optind;
  if (count > 1) return wrong_names(argv[0]);
  char **names = source_names(&count, argv, &o.from);
  watch_interrupt();
  return !names ? EXIT_BAD_INPUT : count ? run_chart(names[0], &o) : EXIT_SOLVED;
}
