/*
 * profile_picture.c: draws a performance profile (profile.h).
 *
 * Block k of NAME.dat: the staircase of solver k, rows tau, fraction of the problems.
 */
#include <math.h>
#include <stdlib.h>

#include "profile.h"
#include "race.h"

static const double most_tau = 1000; /* of the axis */

static double seconds_of(const profile_picture *p, int solver, int which) {
  return p->seconds[solver * p->problems + which];
}

static int is_time(double seconds) {
  return isfinite(seconds) && seconds >= 0;
}

/* Fills tau (problems) with the CPU of solver k over the fastest, sorted; *parts: problems that it
 * takes part in. Returns how many it answered. */
static int find_taus(const profile_picture *p, int k, double *tau, int *parts) {
  int count = 0;
  *parts = 0;
  for (int i = 0; i < p->problems; i++) {
    double fastest = INFINITY;
    for (int j = 0; j < p->solvers; j++)
      if (is_time(seconds_of(p, j, i))) fastest = fmin(fastest, seconds_of(p, j, i));
    *parts += !isnan(seconds_of(p, k, i));
    if (is_time(seconds_of(p, k, i))) tau[count++] = seconds_of(p, k, i) / fastest;
  }
  qsort(tau, (size_t)count, sizeof *tau, ascending);
  return count;
}

/* Writes the staircase of a solver. */
static void write_stairs(FILE *file, const double *tau, int count, int problems) {
  int i = 0;
  fputs("1 0\n", file);
  for (; i < count && tau[i] <= most_tau; i++)
    fprintf(file, "%.4g %.4f\n", tau[i], (double)(i + 1) / problems);
  fprintf(file, "%g %.4f\n\n\n", most_tau, (double)i / problems);
}

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

/* Writes data and script; tau: room for all problems. Returns what draw_script does. */
static int write_profile_files(const profile_picture *p, double *tau) {
  char name[80];
  (void)snprintf(name, sizeof name, "%s.dat", p->name);
  FILE *data = open_in(p->directory, name), *s = data ? open_script(p->directory, p->name) : NULL;
  if (!s) return 0;
  begin_pictures(s, p->name, 860, 500);
  fprintf(
      s,
      "  set title %s noenhanced\n  set grid lc rgb '#d8d8d8'\n  set logscale x\n"
      "  set xrange [1:%g]\n  set yrange [0:1.02]\n  set format x '%%g'\n"
      "  set key outside right top Left reverse noenhanced\n"
      "  set xlabel \"CPU over that of the fastest, at most\\n(measured; n/m: answered of those "
      "that it takes)\"\n  set ylabel 'fraction of the problems'\n  plot -1 notitle",
      quote(AS_GNUPLOT, p->title).text, most_tau);
  for (int k = 0; k < p->solvers; k++) {
    int parts;
    const int count = find_taus(p, k, tau, &parts);
    write_stairs(data, tau, count, p->problems);
    if (!parts) continue;
    fprintf(s, ", \\\n       '%s.dat' index %d using 1:2 with steps ", p->name, k);
    write_style(s, p, k);
    fprintf(s, " title %s.' %d/%d'", quote(AS_GNUPLOT, p->solver[k]).text, count, parts);
  }
  return close_file(data, name) ? draw_script(s, p->directory, p->name) : 0;
}

int draw_profile(const profile_picture *p) {
  double *tau = malloc((size_t)(p->problems > 0 ? p->problems : 1) * sizeof *tau);
  int drawn = 0;
  if (!tau)
    (void)complain("%s: out of memory", p->name);
  else if (make_directory(p->directory))
    drawn = write_profile_files(p, tau);
  if (drawn == 2) tell("drawn: %s/%s.png\n", quote(AS_SHOWN, p->directory).text, p->name);
  free(tau);
  return drawn;
}
