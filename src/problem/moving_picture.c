/* moving_picture.c: draws energies, contact and hysteresis of bodies that move. */
#include <math.h>

#include "problem.h"

/* Units of the axes: the bars have none, the blocks are in SI. Forces are per unit of thickness. A
 * path has no time. */
typedef struct axis_units {
  const char *time, *length, *force, *energy, *pressure;
} axis_units;

static const axis_units *units_of(const dls_moving_data *d) {
  static const axis_units none = {"-", "-", "-", "-", "-"}, si = {"s", "m", "N/m", "J/m", "Pa"},
                          path = {"-", "m", "N/m", "J/m", "Pa"};
  return d->has_exact ? &none : d->dynamic ? &si : &path;
}

/* Draws energies and works against time; those that stay below 1e-6 of the largest are left out.
 * `balance` is energy less all works: a straight line. */
static int write_energies(const char *directory, const dls_moving_data *d) {
  const dls_motion_energies *e = &d->energy;
  const struct {
    const char *title, *formula, *color;
    double size;
  } line[] = {
      {"kinetic", "$2", "#56b4e9", d->dynamic},
      {"elastic", "$3", "#009e73", 1},
      {"kinetic + elastic", "$2+$3", "#000000", d->dynamic},
      {"work of the loads", "$4", "#cc79a7", e->load},
      {"work of the obstacle", "$6", "#0072b2", e->obstacle},
      {"lost by friction", "-$7", "#e69f00", e->friction},
      {"lost by impacts", "-$8", "#d55e00", e->impact},
      {"lost by the scheme", "-$9", "#999999", e->numerical},
  };
  const double whole = fmax(fmax(d->energy_start, e->kinetic + e->elastic), fabs(e->load));
  FILE *script = open_script(directory, "energy");
  if (!script) return 0;
  fprintf(
      script,
      "set title %s.': energies and works'\nset datafile separator ','\nset grid\n"
      "set bmargin at screen 0.22\n"
      "set key at screen 0.5,0.01 center bottom horizontal maxcols 3\nset xlabel 'time [%s]'\nset "
      "ylabel 'energy [%s]'\n"
      "set xrange [0:%g]\nn = %d # about 2000 points, for a page\n",
      quote(AS_GNUPLOT, d->name).text, units_of(d)->time, units_of(d)->energy, d->state.t,
      1 + d->steps / 2000);
  begin_pictures(script, "energy", 1000, 640);
  fputs("  plot 'energy.csv' every n::1 using 1:10 with lines lw 5 lc rgb '#aaaaaa' title 'energy "
        "less all works'",
        script);
  for (size_t k = 0; k < sizeof line / sizeof line[0]; k++)
    if (fabs(line[k].size) > (k < 3 ? 0 : 1e-6 * whole))
      fprintf(script,
              ", \\\n       '' every n::1 using 1:(%s) with lines lw 2 lc rgb '%s' title '%s'",
              line[k].formula, line[k].color, line[k].title);
  return draw_script(script, directory, "energy");
}

/* Draws the pressure and the states over surface and time, from a little before the first contact
 * to a little after the last, in whole columns: an image covers what is beside it otherwise. */
static int write_map(const char *directory, const dls_moving_data *d) {
  const double *xy = d->mesh->xy;
  const int *node = d->candidate_node;
  const double first = xy[2 * node[0]], last = xy[2 * node[d->candidates - 1]];
  const double half = (last - first) / (d->candidates - 1) / 2;
  FILE *script = open_script(directory, "map");
  if (!script) return 0;
  fprintf(script,
          "a = 1e300\nb = -1e300\nh = p = 0\n"
          "stats 'map.dat' using (a = $3 > 0 && $1 < a ? $1 : a, b = $3 > 0 && $1 > b ? $1 : b, "
          "h = $1 > p ? $1 - p : h, p = $1, 1) nooutput\n"
          "if (!(b > a)) { a = 0; b = %g }\nm = 0.15*(b - a)\n" /* no contact: all of it */
          "set xrange [a - m < h ? h/2 : (floor((a - m)/h) - 0.499)*h:"
          "b + m > %g ? %g + h/2 : (ceil((b + m)/h) + 0.499)*h]\n"
          "set xlabel 'time [%s]'\nset ylabel 'x along the surface [%s]'\n"
          "set yrange [%g:%g]\nset format y '%%.3g'\nset key off\n"
          "set lmargin at screen 0.11\nset rmargin at screen 0.85\n",
          d->state.t, d->state.t, d->state.t, units_of(d)->time, units_of(d)->length, first - half,
          last + half);
  begin_pictures(script, "map", 1000, 760);
  fprintf(script,
          "  set multiplot layout 2,1\n"
          "  set title %s.': pressure r_n / length [%s]'\n"
          "  set palette maxcolors 0 defined (0 '#ffffff', 0.01 '#fee8c8', 0.4 '#fdbb84', 0.7 "
          "'#e34a33', 1 '#7f0000')\n"
          "  set cbrange [0:*]\n  set cbtics auto\n  set format cb '%%.2g'\n"
          "  plot 'map.dat' using 1:2:3 with image\n"
          "  set title 'state of the candidates'\n"
          "  set palette maxcolors 3 defined (0 '%s', 1 '%s', 2 '%s')\n"
          "  set cbrange [-0.5:2.5]\n  set format cb '%%g'\n"
          "  set cbtics ('free' 0, 'slip' 1, 'stick' 2)\n"
          "  plot 'map.dat' using 1:2:4 with image\n",
          quote(AS_GNUPLOT, d->name).text, units_of(d)->pressure, state_colour(DLS_FREE),
          state_colour(DLS_SLIP), state_colour(DLS_STICK));
  return draw_script(script, directory, "map");
}

/* Draws gap and force of a bar beside the closed form. */
static int write_bar(const char *directory, const dls_moving_data *d) {
  FILE *script = open_script(directory, "bar");
  if (!script) return 0;
  fprintf(script,
          "set grid\nset xrange [0:%g]\nset lmargin at screen 0.09\nset rmargin at screen 0.97\n"
          "set key above right horizontal\nset offsets 0,0,graph 0.05,0\n",
          d->state.t);
  begin_pictures(script, "bar", 1000, 760);
  fprintf(script,
          "  set multiplot layout 2,1\n"
          "  set label 1 %s.', %d elements: gap, L2 error %.3g' at graph 0,1.06\n"
          "  set ylabel 'gap [-]'\n  set format x ''\n"
          "  n = %d\n  plot 'bar.dat' every n using 1:3 with lines lw 6 lc rgb '#f0b88a' title "
          "'closed form', \\\n"
          "       '' every n using 1:2 with lines lw 1.5 lc rgb '#0072b2' title 'computed'\n"
          "  set label 1 'force of the wall' at graph 0,1.06\n"
          "  set ylabel 'force [-]'\n  set xlabel 'time [-]'\n  set format x '%%g'\n"
          "  plot 'bar.dat' every n using 1:5 with lines lw 6 lc rgb '#f0b88a' title 'closed "
          "form', \\\n"
          "       '' every n using 1:4 with lines lw 1.2 lc rgb '#0072b2' title 'computed'\n"
          "  unset xlabel\n",
          quote(AS_GNUPLOT, d->name).text, d->mesh->quads, d->gap_error, 1 + d->steps / 2000);
  return draw_script(script, directory, "bar");
}

/* Draws the tangential force over the obstacle's way: the first cycle thin, later ones thick. */
static int write_loop(const char *directory, const dls_moving_data *d) {
  FILE *script = open_script(directory, "loop");
  if (!script) return 0;
  fprintf(script,
          "set title %s.': hysteresis'\nset grid\nset key top left\n"
          "set xlabel 'way of the obstacle [m]'\nset ylabel 'sum of r_t [N/m]'\n"
          "set xtics %g\nset format y '%%.3g'\n",
          quote(AS_GNUPLOT, d->name).text, d->settings.amplitude / 2);
  begin_pictures(script, "loop", 800, 640);
  fputs("  plot 'loop.dat' index 0 with lines lw 1.5 lc rgb '#56b4e9' title 'first cycle'", script);
  if (d->step > d->cycle)
    fputs(", \\\n       '' index 1 with lines lw 3 lc rgb '#d55e00' title 'second cycle'", script);
  return draw_script(script, directory, "loop");
}

int draw_moving(const char *directory, const dls_moving_data *d) {
  return write_energies(directory, d) && (d->has_exact ? write_bar : write_map)(directory, d) &&
                 (!d->obstacle_moves || write_loop(directory, d))
             ? EXIT_SOLVED
             : EXIT_BAD_INPUT;
}
