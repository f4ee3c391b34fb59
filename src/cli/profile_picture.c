/*
 * profile_picture.c: draws performance profiles (profile.h).
 *
 * For target t and solver k, NAME.dat holds block 4 (t solvers + k) (tau, part of the problems: a
 * staircase), the next block (place of the problem, CPU over the fastest) and the next (place,
 * lane) of what it did not answer, and the next the same of what it did not decide.
 */
#include <math.h>
#include <stdlib.h>

#include "profile.h"
#include "race.h"

static const double most_tau = 1000; /* of the axis */
enum { blocks = 4 };                 /* of a solver in the file */

typedef struct place {
  double fastest; /* seconds; INFINITY: nobody answered it. First: places are sorted by it */
  int problem;
} place;

/* A target: problems from quick to slow, those that somebody answered first. */
typedef struct strip {
  place *places; /* problems */
  int solved;
  double most; /* of the axis of ratios */
} strip;

static double seconds_of(const profile_picture *p, int target, int solver, int which) {
  return p->seconds[(target * p->solvers + solver) * p->problems + which];
}

static int is_time(double seconds) {
  return isfinite(seconds) && seconds >= 0;
}

static void make_strip(const profile_picture *p, int target, strip *s) {
  s->solved = 0;
  s->most = 10;
  for (int i = 0; i < p->problems; i++) {
    double fastest = INFINITY, slowest = 0;
    for (int k = 0; k < p->solvers; k++) {
      const double seconds = seconds_of(p, target, k, i);
      if (!is_time(seconds)) continue;
      fastest = fmin(fastest, seconds);
      slowest = fmax(slowest, seconds);
    }
    s->places[i] = (place){fastest, i};
    s->solved += isfinite(fastest) != 0;
    if (isfinite(fastest)) s->most = fmax(s->most, slowest / fastest);
  }
  s->most = fmin(1.5 * s->most, 1e4);
  qsort(s->places, (size_t)p->problems, sizeof *s->places, ascending);
}

/* Returns the height of the crosses of solver k on the axis of ratios, above all ratios. */
static double lane(const profile_picture *p, const strip *s, int k) {
  return s->most * pow(s->most, 0.04 * (p->solvers - k));
}

/* ---- data ------------------------------------------------------------------------------------ */

/* Counts what a solver answered; taus (problems) receives its CPU over the fastest, sorted. */
static int find_taus(const profile_picture *p, int target, const strip *s, int k, double *taus) {
  int count = 0;
  for (int i = 0; i < s->solved; i++) {
    const double seconds = seconds_of(p, target, k, s->places[i].problem);
    if (is_time(seconds)) taus[count++] = seconds / s->places[i].fastest;
  }
  qsort(taus, (size_t)count, sizeof *taus, ascending);
  return count;
}

/* Counts the problems that a solver takes part in, those among them that it does not answer and
 * those that it does not decide. */
static int count_parts(const profile_picture *p, int target, int k, int *failed, int *open) {
  int parts = 0;
  *failed = *open = 0;
  for (int i = 0; i < p->problems; i++) {
    const double seconds = seconds_of(p, target, k, i);
    parts += !isnan(seconds);
    *failed += isinf(seconds) != 0;
    *open += seconds < 0;
  }
  return parts;
}

static void write_profile_blocks(FILE *file, const profile_picture *p, int target, const strip *s,
                                 double *taus) {
  for (int k = 0; k < p->solvers; k++) {
    const int count = find_taus(p, target, s, k, taus);
    int i = 0;
    fputs("1 0\n", file);
    for (; i < count && taus[i] <= most_tau; i++)
      fprintf(file, "%.4g %.4f\n", taus[i], (double)(i + 1) / p->problems);
    fprintf(file, "%g %.4f\n\n\n0 NaN\n", most_tau, (double)i / p->problems);
    for (i = 0; i < s->solved; i++) {
      const double seconds = seconds_of(p, target, k, s->places[i].problem);
      if (is_time(seconds))
        fprintf(file, "%d %.4g\n", i + 1, fmin(seconds / s->places[i].fastest, s->most));
    }
    for (int open = 0; open < 2; open++) {
      fputs("\n\n0 NaN\n", file);
      for (i = 0; i < p->problems; i++) {
        const double seconds = seconds_of(p, target, k, s->places[i].problem);
        if (open ? seconds < 0 : isinf(seconds)) fprintf(file, "%d %.4g\n", i + 1, lane(p, s, k));
      }
    }
    fputs("\n\n", file);
  }
}

/* ---- script ---------------------------------------------------------------------------------- */

/* Writes the style of solver k. */
static void write_style(FILE *s, const profile_picture *p, int k) {
  static const char *const reds[] = {"#b00020", "#7f0000", "#ff5a7a", "#a0522d", "#c71585"};
  int peers = 0;
  for (int i = 0; p->peer && i < k; i++)
    peers += p->peer[i];
  const int dashed = p->peer && p->peer[k];
  fprintf(s, "lw %g dt %d lc rgb '%s'", k ? 1.8 : 4.0, dashed ? 2 + peers % 4 : 1,
          dashed ? reds[peers % 5] : method_colour(p->solver[k]));
}

static void begin_plot(FILE *s, double left, double right, double bottom, double top) {
  place_panel(s, left, right, bottom, top);
  fputs("  unset label\n  unset arrow\n  unset title\n", s);
}

/* Draws the profiles of a target, and under them the key: a sample, and how many it solved. */
static void write_profile_curves(FILE *s, const profile_picture *p, int target, const strip *all,
                                 double left, double right, double *taus) {
  const int half = (p->solvers + 1) / 2;
  const double top = 0.517, line = fmin(0.021, 0.112 / half);
  begin_plot(s, left, right, 0.575, 0.92);
  fprintf(s,
          "  set title '{/:Bold %s}' offset 0,-0.6\n  set logscale x\n  unset logscale y\n"
          "  set xrange [1:%g]\n  set yrange [0:1.02]\n  set format x '%%g'\n"
          "  set format y '%%g'\n  set xtics 10\n  set ytics 0.2\n"
          "  set xlabel 'CPU / fastest, at most' offset 0,0.5\n"
          "  set ylabel '%s' offset 1,0\n",
          p->target[target], most_tau, target ? "" : "part of the problems");
  for (int k = 0; k < p->solvers; k++) {
    const double x = left + (k / half) * 0.53 * (right - left), y = top - k % half * line;
    fprintf(s, "  set arrow from screen %.4f,%.4f to screen %.4f,%.4f nohead ", x, y, x + 0.02, y);
    write_style(s, p, k);
    int failed, open;
    const int parts = count_parts(p, target, k, &failed, &open);
    fprintf(s, "\n  set label %s.'  ", quote(AS_GNUPLOT, p->solver[k]).text);
    if (parts)
      fprintf(s, "%d/%d", find_taus(p, target, all, k, taus), parts);
    else
      fputs(p->absent, s);
    fprintf(s, "' at screen %.4f,%.4f left font ',10' noenhanced\n", x + 0.025, y);
  }
  fputs("  plot -1 with lines", s);
  for (int i = 1; i <= p->solvers; i++) {
    const int k = i % p->solvers;
    if (!find_taus(p, target, all, k, taus)) continue;
    fprintf(s, ", \\\n       '%s.dat' index %d using 1:2 with steps ", p->name,
            blocks * (target * p->solvers + k));
    write_style(s, p, k);
  }
  fputs("\n", s);
}

static void write_strip(FILE *s, const profile_picture *p, int target, const strip *all,
                        double left, double right, double *taus) {
  const int step = p->problems > 8 ? p->problems / 4 : p->problems > 1 ? p->problems - 1 : 1;
  begin_plot(s, left, right, 0.075, 0.36);
  fprintf(s,
          "  set title 'each problem, from quick to slow' offset 0,-0.6 font ',12'\n  unset "
          "logscale x\n  set logscale y\n  set xrange [0:%d]\n"
          "  set yrange [0.8:%.4g]\n  set format y '10^{%%T}'\n  set ytics 10\n  set ylabel '%s' "
          "offset "
          "0.5,0\n  set xlabel 'CPU of the fastest [ms]' offset 0,0.3\n  set xtics (",
          p->problems + 1, lane(p, all, -1), target ? "" : "CPU / fastest");
  for (int i = 0; i < all->solved; i += step)
    fprintf(s, "%s'%.2g' %d", i ? ", " : "", 1e3 * all->places[i].fastest, i + 1);
  fputs(")\n", s);
  if (!target)
    fprintf(s,
            "  set label 'diamonds: auto; crosses: not solved; rings: not decided; '.%s at screen "
            "0.04,0.012 left font ',12' noenhanced\n",
            quote(AS_GNUPLOT, p->notes).text);
  fputs("  plot 2 with filledcurves y1=0.8 fc rgb '#e4e4e4'", s);
  for (int i = 1; i <= p->solvers; i++) {
    const int k = i % p->solvers, block = blocks * (target * p->solvers + k);
    const int solved = find_taus(p, target, all, k, taus);
    int count[3] = {solved};
    (void)count_parts(p, target, k, &count[1], &count[2]);
    for (int kind = 0; kind < 3; kind++) {
      static const int points[] = {7, 2, 6};
      static const double sizes[] = {0.65, 0.55, 0.7};
      if (!count[kind]) continue;
      fprintf(s, ", \\\n      '%s.dat' index %d using 1:2 with points pt %d ps %g ", p->name,
              block + 1 + kind, k || kind ? points[kind] : 13, k ? sizes[kind] : 1.6);
      write_style(s, p, k);
    }
  }
  fputs("\n", s);
}

static void write_profile_target(FILE *s, const profile_picture *p, int target, const strip *all,
                                 double *taus) {
  const double width = 1.0 / p->targets, left = target * width + 0.05,
               right = (target + 1) * width - 0.018;
  write_profile_curves(s, p, target, all, left, right, taus);
  write_strip(s, p, target, all, left, right, taus);
}

/* ---- the picture ----------------------------------------------------------------------------- */

/* Returns what draw_script does. */
static int write_profile_files(const profile_picture *p, strip *s, double *taus) {
  char name[80];
  (void)snprintf(name, sizeof name, "%s.dat", p->name);
  FILE *data = open_in(p->directory, name), *gp = data ? open_script(p->directory, p->name) : NULL;
  if (!gp) return 0;
  fputs("set datafile missing 'NaN'\nset key off\nset grid lc rgb '#d8d8d8'\n", gp);
  begin_pictures(gp, p->name, 580 * p->targets + 60, 1100);
  fprintf(gp, "  set multiplot title %s font ',17' noenhanced\n", quote(AS_GNUPLOT, p->title).text);
  for (int t = 0; t < p->targets; t++) {
    make_strip(p, t, s);
    write_profile_blocks(data, p, t, s, taus);
    write_profile_target(gp, p, t, s, taus);
  }
  return close_file(data, name) ? draw_script(gp, p->directory, p->name) : 0;
}

int draw_profiles(const profile_picture *p) {
  const size_t n = (size_t)(p->problems > 0 ? p->problems : 1);
  strip s = {.places = malloc(n * sizeof *s.places)};
  double *taus = malloc(n * sizeof *taus);
  int drawn = 0;
  if (!s.places || !taus)
    (void)complain("%s: out of memory", p->name);
  else if (make_directory(p->directory))
    drawn = write_profile_files(p, &s, taus);
  if (drawn == 2) tell("drawn: %s/%s.png\n", quote(AS_SHOWN, p->directory).text, p->name);
  free(s.places);
  free(taus);
  return drawn;
}
