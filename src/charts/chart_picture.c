/*
 * chart_picture.c: the files of delassus chart: chart.csv, history.csv, and the picture: four
 * panels, and under them the table, which is the key of all four.
 */
#include <math.h>

#include "chart.h"

static const double least_residual = 1e-17; /* 0 on a logarithmic axis */

/* Panels: left, right, lower and upper edge in parts of the picture. */
static const double panels[4][4] = {{0.06, 0.48, 0.655, 0.90},
                                    {0.56, 0.98, 0.655, 0.90},
                                    {0.06, 0.48, 0.335, 0.58},
                                    {0.56, 0.98, 0.335, 0.58}};

static double at_least(double x, double least) {
  return x > least ? x : least; /* NaN: least */
}

/* ---- tables ---------------------------------------------------------------------------------- */

static int write_chart_csv(const chart *c, const char *directory) {
  const race *a = &c->race;
  FILE *file = open_table(
      directory, "chart.csv",
      "method,tol,verdict,asked,cpu_s,times_fastest,iterations,residual,error,answer,longer\n");
  if (!file) return 0;
  for (int k = 0; k < a->count; k++)
    for (int rung = 0; rung < a->rungs; rung++) {
      const trial *t = race_trial(a, k, rung);
      const int solved = t->end == ENDED_SOLVED;
      fprintf(file, "%s,%.0e,%s,%d,%.4e,%.3f,%d,%.17g,%.3e,%c,%d\n", a->who[k].name, a->tol[rung],
              ending_word(t->end), t->asked, t->seconds,
              solved ? t->seconds / race_fastest(a, rung) : (double)NAN, t->iterations, t->residual,
              c->error[k * a->rungs + rung],
              solved && c->went_to[k] >= 0 ? 'A' + c->went_to[k] : '-', t->longer);
    }
  return close_file(file, "chart.csv");
}

static int write_history_csv(const chart *c, const char *directory) {
  FILE *file = open_table(directory, "history.csv", "method,iteration,cpu_s,residual\n");
  if (!file) return 0;
  for (int k = 0; k < c->race.count; k++)
    for (int i = 0; i < c->history[k].points; i++)
      fprintf(file, "%s,%d,%.4e,%.6e\n", c->race.who[k].name, c->history[k].iteration[i],
              c->history[k].seconds[i], c->history[k].residual[i]);
  return close_file(file, "history.csv");
}

/* ---- script ---------------------------------------------------------------------------------- */

/* The ranges of the axes. */
typedef struct ranges {
  double ms_min, ms_max, ratio_max, error_max, residual_max, iterations_max;
} ranges;

static void stretch_range(double x, double *lo, double *hi) {
  if (lo && x < *lo) *lo = x;
  if (hi && x > *hi) *hi = x;
}

static ranges find_ranges(const chart *c) {
  const race *a = &c->race;
  ranges g = {INFINITY, 0, 4, 0, 0, 10};
  for (int k = 0; k < a->count; k++) {
    for (int rung = 0; rung < a->rungs; rung++) {
      const trial *t = race_trial(a, k, rung);
      const double error = c->error[k * a->rungs + rung];
      stretch_range(1e3 * t->seconds, &g.ms_min, &g.ms_max);
      if (t->residual > 0) stretch_range(t->residual, NULL, &g.residual_max);
      if (t->end != ENDED_SOLVED) break;
      stretch_range(t->seconds / race_fastest(a, rung), NULL, &g.ratio_max);
      if (error > 0) stretch_range(error, NULL, &g.error_max);
    }
    const history *h = &c->history[k];
    for (int i = 0; i < h->points; i++) {
      stretch_range(h->iteration[i], NULL, &g.iterations_max);
      stretch_range(h->residual[i], NULL, &g.residual_max);
    }
  }
  g.ms_min = at_least(g.ms_min, 1e-5) / 1.5;
  g.ms_max = at_least(g.ms_max, g.ms_min) * 2.5;
  g.residual_max = fmin(at_least(g.residual_max, 1e-2) * 5, 1e3);
  g.error_max = at_least(g.error_max, 1e-2) * 5;
  g.ratio_max = fmin(g.ratio_max * 1.6, 1e4);
  return g;
}

static void begin_panel(FILE *s, int i, const char *title, const char *x, const char *y) {
  const double *p = panels[i];
  place_panel(s, p[0], p[1], p[2], p[3]);
  fprintf(s,
          "  unset label\n  unset arrow\n  unset object\n  set title '{/:Bold %s}' offset 0,-0.6\n"
          "  set xlabel '%s' offset 0,0.5\n  set ylabel '%s' offset 0.8,0\n",
          title, x, y);
}

/* Draws a curve of each contender that solved a rung, y over x, expressions of gnuplot in the
 * columns of chart.csv, auto last and thick; below it the dotted curve of `beside`, or NULL. */
static void plot_curves(FILE *s, const chart *c, const char *x, const char *y, const char *beside) {
  const race *a = &c->race;
  for (int i = 1; i <= a->count; i++) {
    const int k = i % a->count; /* auto, 0, comes last */
    const contender *who = &a->who[k];
    if (race_trial(a, k, 0)->end != ENDED_SOLVED) continue;
    if (beside)
      fprintf(
          s,
          ", \\\n      'chart.csv' using (of('%s', %s)):(least(%s)) with lines lw 1.2 dt 3 lc rgb "
          "'%s'",
          who->name, x, beside, who->colour);
    fprintf(
        s,
        ", \\\n      'chart.csv' using (of('%s', %s)):(least(%s)) with linespoints lw %g lc rgb "
        "'%s' pt %d ps %g",
        who->name, x, y, k ? 1.8 : 4.0, who->colour, who->point, k ? 1.1 : 1.5);
  }
  fputs("\n", s);
}

/* Writes a mark for each contender that gave up, where it gave up: a cross, or a ring where that is
 * not decided. The table has the verdicts. */
static void write_marks(FILE *s, const chart *c, const ranges *g) {
  for (int k = 0; k < c->race.count; k++) {
    const trial *t = race_trial(&c->race, k, c->race.rungs - 1);
    if (t->end == ENDED_SOLVED) continue; /* else the first rung that failed stands there */
    fprintf(s, "  set label '' at first %.5g,%.5g point pt %d ps 1.8 lw 3 lc rgb '%s' front\n",
            1e3 * t->seconds, fmin(at_least(t->residual, 10 * least_residual), g->residual_max / 2),
            t->end == ENDED_UNDECIDED ? 6 : 2, c->race.who[k].colour);
  }
}

/* Writes the region within twice the fastest, a closed line. */
static void write_band(FILE *s, const chart *c) {
  fputs("  $band << END\n", s);
  int rungs = 0;
  while (rungs < c->race.rungs && isfinite(race_fastest(&c->race, rungs)))
    rungs++;
  for (int i = 0; i < rungs; i++)
    fprintf(s, "%.5g,%.0e\n", 1e3 * race_fastest(&c->race, i), c->tol[i]);
  for (int i = rungs - 1; i >= 0; i--)
    fprintf(s, "%.5g,%.0e\n", 2e3 * race_fastest(&c->race, i), c->tol[i]);
  fputs(rungs ? "END\n" : "1,NaN\nEND\n", s);
}

static void write_work(FILE *s, const chart *c, const ranges *g) {
  begin_panel(s, 0, "residual reached against CPU; grey: within 2 of the fastest", "CPU [ms]",
              "residual");
  fprintf(s,
          "  set logscale xy\n  set xrange [%g:%g]\n  set yrange [%g:%g]\n"
          "  set format x '10^{%%T}'\n  set format y '10^{%%T}'\n  set ytics 1e-16,1e4\n",
          g->ms_min, g->ms_max, least_residual, g->residual_max);
  write_marks(s, c, g);
  if (isfinite(race_fastest(&c->race, 0)))
    fputs("  plot $band using 1:2 with filledcurves closed fc rgb '#e4e4e4'", s);
  else
    fputs("  plot 1/0 with lines", s);
  plot_curves(s, c, "1e3*$5", "$8", NULL);
}

static void write_ratios(FILE *s, const chart *c, const ranges *g) {
  const race *a = &c->race;
  begin_panel(s, 1, "CPU / fastest; crosses: gave up; rings: not decided",
              "digits of the tolerance", "CPU / fastest");
  fprintf(
      s,
      "  unset logscale x\n  set xrange [1.5:14.5]\n  set yrange [0.9:%g]\n  set format x '%%g'\n"
      "  set format y '%%g'\n  set xtics 2\n  set ytics auto\n",
      2 * g->ratio_max);
  int shift[CHART_RUNGS] = {0};
  for (int k = 0; k < a->count; k++)
    for (int rung = 0; rung < a->rungs; rung++) {
      if (race_trial(a, k, rung)->end == ENDED_SOLVED) continue;
      fprintf(s, "  set label '' at first %.3f,%.5g point pt %d ps 1.8 lw 3 lc rgb '%s' front\n",
              -log10(a->tol[rung]) + 0.25 * shift[rung]++, 1.45 * g->ratio_max,
              race_trial(a, k, rung)->end == ENDED_UNDECIDED ? 6 : 2, a->who[k].colour);
      break;
    }
  fputs("  plot 2 with filledcurves y1=0.9 fc rgb '#e4e4e4'", s);
  plot_curves(s, c, "-log10($2)", "$6", NULL);
}

static void write_errors(FILE *s, const chart *c, const ranges *g) {
  char title[160];
  const int proved = c->answers > 0 && c->answer[0].proved;
  (void)snprintf(title, sizeof title, "%s error in %s against CPU; dots: residual",
                 proved ? "proved" : "true", c->in_u ? "u (W rank deficient)" : "r");
  begin_panel(s, 2, title, "CPU [ms]", c->in_u ? "|u - u*| / |q|" : "|r - r*| / |r*|");
  fprintf(s,
          "  set logscale xy\n  set xrange [%g:%g]\n  set yrange [%g:%g]\n"
          "  set format x '10^{%%T}'\n  set format y '10^{%%T}'\n  set xtics auto\n"
          "  set ytics 1e-16,1e4\n",
          g->ms_min, g->ms_max, least_residual, g->error_max);
  const double agreement = c->answers ? c->answer[0].agreement : (double)NAN;
  if (agreement > 0)
    fprintf(s,
            "  set label '%s' at graph 0.99,first %g right offset "
            "0,%g tc rgb '#606060' font ',11' front boxed\n",
            proved ? "the reference is proved to this" : "the two best answers agree to this",
            at_least(agreement, 3 * least_residual),
            agreement > 100 * least_residual ? -0.8 : 0.6); /* below, where no curve goes */
  if (c->answers > 1)
    fprintf(s,
            "  set label '%d different answers: each method from its own' at graph 0.98,0.93 right "
            "tc rgb '#d55e00'\n",
            c->answers);
  if (agreement > 0)
    fprintf(s, "  plot %g with lines dt 2 lc rgb '#808080'",
            at_least(agreement, 3 * least_residual));
  else
    fputs("  plot 1/0 with lines", s);
  if (c->answers)
    plot_curves(s, c, "1e3*$5", "$9", "$8");
  else
    fputs("\n", s);
}

/* Marks the first stages of auto, staggered, along the bottom. */
static void write_stages(FILE *s, const chart *c) {
  const history *h = &c->history[0];
  for (int i = 0; i < h->stages && i < 6 && h->stages > 1; i++) {
    const double at = h->begin[i] > 0 ? h->begin[i] : 1;
    const double height = 0.04 + 0.055 * (i % 3);
    fprintf(s,
            "  set arrow from first %g,graph 0 to first %g,graph %g nohead lw 1 dt 3 lc rgb "
            "'#000000'\n  set label ' %s' at first %g,graph %g left font ',11' noenhanced front "
            "boxed\n",
            at, at, height + 0.03, h->stage[i], at, height);
  }
}

static void write_convergence(FILE *s, const chart *c, const ranges *g) {
  const race *a = &c->race;
  begin_panel(s, 3, "convergence, and where the stages of auto begin",
              "iterations: sweeps, steps, pivots", "residual");
  fprintf(s,
          "  set xrange [0.9:%g]\n  set yrange [%g:%g]\n  set format x '10^{%%T}'\n"
          "  set format y '10^{%%T}'\n  set ytics 1e-16,1e4\n",
          1.3 * g->iterations_max, least_residual, g->residual_max);
  write_stages(s, c);
  fputs("  plot 1/0 with lines", s);
  for (int i = 1; i <= a->count; i++) {
    const int k = i % a->count, few = c->history[k].points < 25;
    if (!c->history[k].points) continue;
    fprintf(
        s,
        ", \\\n      'history.csv' using (strcol(1) eq '%s' ? ($2 > 0 ? $2 : 1) : NaN):(least($4)) "
        "with %s lw %g lc rgb '%s'",
        a->who[k].name, few ? "linespoints" : "lines", k ? 1.8 : 4.0, a->who[k].colour);
    if (few) fprintf(s, " pt %d ps 0.9", a->who[k].point);
  }
  fputs("\n", s);
}

/* Writes the table that is the key, too. */
static void write_key(FILE *s, const chart *c) {
  static const double column[] = {0.06, 0.10, 0.29, 0.45, 0.61, 0.75, 0.94}, top = 0.265;
  static const char *const head[] = {"1e-4", "1e-8", "1e-12"};
  const race *a = &c->race;
  const double line = 0.245 / (a->count + 1);
  char cell[400];
  place_panel(s, 0.01, 0.99, 0.005, 0.28);
  fputs("  unset label\n  unset arrow\n  unset title\n  unset xlabel\n"
        "  unset ylabel\n  unset border\n  unset tics\n  unset grid\n  unset logscale\n"
        "  set xrange [0:1]\n  set yrange [0:1]\n",
        s);
  for (int i = 0; i < CHART_TARGETS; i++)
    fprintf(s, "  set label '{/:Bold %s}' at screen %g,%g left font ',12'\n", head[i],
            column[2 + i], top);
  char predicted[40] = "";
  if (isfinite(c->predicted))
    (void)snprintf(predicted, sizeof predicted, " (predicted: %.2g)", c->predicted);
  fprintf(s, "  set label '{/:Bold error / residual}%s' at screen %g,%g left font ',12'\n",
          predicted, column[5], top);
  fprintf(s, "  set label '{/:Bold CPU (over fastest) to}' at screen %g,%g left font ',12'\n",
          column[1], top);
  if (c->answers > 1)
    fprintf(s, "  set label '{/:Bold answer}' at screen %g,%g left font ',12'\n", column[6], top);
  for (int k = 0; k < a->count; k++) {
    const double y = top - (k + 1) * line;
    const contender *who = &a->who[k];
    fprintf(s,
            "  set arrow from screen %g,%g to screen %g,%g nohead lw %g lc rgb '%s'\n"
            "  set label '' at screen %g,%g point pt %d ps 1.3 lc rgb '%s'\n"
            "  set label '%s' at screen %g,%g left tc rgb '%s' noenhanced\n",
            column[0], y, column[0] + 0.03, y, k ? 1.8 : 4.0, who->colour, column[0] + 0.015, y,
            who->point, who->colour, who->name, column[1], y, who->colour);
    for (int i = 0; i < CHART_TARGETS; i++) {
      chart_cell(c, k, chart_target[i], cell, sizeof cell);
      fprintf(s, "  set label '%s' at screen %g,%g left noenhanced%s\n", cell, column[2 + i], y,
              race_trial(a, k, chart_target[i])->end == ENDED_SOLVED ? "" : " tc rgb '#b00000'");
    }
    chart_amplification(c, k, cell, sizeof cell);
    fprintf(s, "  set label '%s' at screen %g,%g left\n", cell, column[5], y);
    if (c->answers > 1 && c->went_to[k] >= 0)
      fprintf(s, "  set label '%c' at screen %g,%g left\n", 'A' + c->went_to[k], column[6], y);
  }
  fputs("  plot -1 with lines\n", s);
}

/* Returns what draw_script does. */
static int write_chart_script(const chart *c, const char *directory) {
  FILE *s = open_script(directory, "chart");
  if (!s) return 0;
  char advice[400];
  const ranges g = find_ranges(c);
  chart_advice(c, advice, sizeof advice);
  fprintf(s,
          "set datafile separator ','\nset datafile missing 'nan'\n"
          "of(name, x) = strcol(1) eq name && strcol(3) eq 'solved' ? x : NaN\n"
          "least(y) = y > %g ? y : y == y ? %g : NaN\n",
          least_residual, least_residual);
  write_band(s, c);
  begin_pictures(s, "chart", 1180, 1120);
  fputs("  set key off\n  set border\n  set tics\n  set grid lc rgb '#d8d8d8'\n  set style textbox "
        "opaque noborder margins 0.3,0.3\n",
        s);
  fputs("  set multiplot\n", s);
  fprintf(s,
          "  set label 100 %s.': %dD, %d candidate%s; measured, CPU up to %g s a solve' at screen "
          "0.06,0.975 left font ',17' "
          "noenhanced\n  set label 101 %s at screen 0.06,0.947 left font ',15' noenhanced tc rgb "
          "'#0050a0'\n",
          quote(AS_GNUPLOT, c->subject.name).text, c->race.d, c->race.nc, plural(c->race.nc),
          10 * c->limit, quote(AS_GNUPLOT, advice).text);
  place_panel(s, 0, 1, 0.92, 1);
  fputs("  unset border\n  unset tics\n  set xrange [0:1]\n"
        "  set yrange [0:1]\n  plot -1 with lines\n  set border\n  set tics\n",
        s);
  write_work(s, c, &g);
  write_ratios(s, c, &g);
  write_errors(s, c, &g);
  write_convergence(s, c, &g);
  write_key(s, c);
  return draw_script(s, directory, "chart");
}

int draw_chart(const chart *c, const char *directory) {
  const int drawn = write_chart_csv(c, directory) && write_history_csv(c, directory)
                        ? write_chart_script(c, directory)
                        : 0;
  if (drawn == 2) tell("drawn: %s/chart.png\n", quote(AS_SHOWN, directory).text);
  return drawn ? EXIT_SOLVED : EXIT_BAD_INPUT;
}
