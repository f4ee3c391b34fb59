/* forming_picture.c: draws the deformed mesh with contact forces, the plastic strain, the force. */
#include <math.h>

#include "cli.h"

/* Returns coordinate i of a node, at rest or deformed. */
static double corner(const dls_forming_data *d, int node, int i, int deformed) {
  return d->mesh->xy[2 * node + i] + (deformed ? d->displacement[2 * node + i] : 0);
}

/* Chooses the pixels of a picture of this shape, with room beside it. */
static void fit_picture(const double lo[2], const double hi[2], int panels, double size[2]) {
  const double wide = panels * (hi[0] - lo[0]), high = hi[1] - lo[1];
  const double scale = 760 / fmax(wide, high);
  size[0] = fmax(scale * wide + 200, 720);
  size[1] = fmax(scale * high + 160, 480);
}

/* Draws Figs. 2 and 3 of the paper: the mesh at rest beside the deformed one, with an arrow for
 * each contact force. */
static int write_mesh(const char *directory, const char *title, const dls_forming_data *d) {
  double lo[2], hi[2], largest = 0;
  mesh_box(d->mesh->nodes, d->mesh->xy, d->displacement, lo, hi);
  for (int i = 0; i < d->mesh->nodes; i++)
    largest = fmax(largest, hypot(d->reaction[2 * i], d->reaction[2 * i + 1]));
  const double span = fmin(hi[0] - lo[0], hi[1] - lo[1]);
  const double arrow = largest > 0 ? 0.35 * span / largest : 0;
  FILE *data = open_in(directory, "mesh.dat");
  if (!data) return 0;
  fputs("# block 0: elements at rest, 1: deformed, 2: contact forces on the body\n", data);
  for (int deformed = 0; deformed < 2; deformed++) {
    for (int e = 0; e < d->mesh->quads; e++) {
      for (int k = 0; k < 5; k++) {
        const int node = d->mesh->node[4 * e + k % 4];
        fprintf(data, "%.9g %.9g\n", corner(d, node, 0, deformed), corner(d, node, 1, deformed));
      }
      fputc('\n', data);
    }
    fputc('\n', data);
  }
  for (int i = 0; i < d->mesh->nodes; i++) {
    const double rx = arrow * d->reaction[2 * i], ry = arrow * d->reaction[2 * i + 1];
    if (rx != 0 || ry != 0)
      fprintf(data, "%.9g %.9g %.9g %.9g\n", corner(d, i, 0, 1) - rx, corner(d, i, 1, 1) - ry, rx,
              ry);
  }
  if (!close_file(data, "mesh.dat")) return 0;
  FILE *script = open_in(directory, "mesh.gp");
  if (!script) return 0;
  const double edge = 0.45 * span, from[2] = {lo[0] - 0.1 * span, lo[1] - 0.1 * span};
  const double to[2] = {hi[0] + edge, hi[1] + edge};
  double size[2];
  fit_picture(from, to, 2, size);
  begin_pictures(script, "mesh", size[0], size[1]);
  fprintf(script,
          "  set multiplot layout 1,2 title '%s, longest arrow %.3g N'\n"
          "  set size ratio -1\n  set key off\n  set xrange [%g:%g]\n  set yrange [%g:%g]\n"
          "  set xlabel 'mm'\n  set xtics %g\n"
          "  plot 'mesh.dat' index 0 with lines lc rgb '#3060a0'\n"
          "  plot 'mesh.dat' index 1 with lines lc rgb '#3060a0', \\\n"
          "       '' index 2 using 1:2:3:4 with vectors filled lw 2 lc rgb '#c03020'\n"
          "  unset multiplot\n  unset output\n}\n",
          title, largest, from[0], to[0], from[1], to[1], hi[0] > 30 ? 20.0 : 10.0);
  return close_file(script, "mesh.gp");
}

/* Draws the equivalent plastic strain, mean of each element, on the deformed mesh. */
static int write_plastic(const char *directory, const char *title, const dls_forming_data *d) {
  double lo[2], hi[2], size[2], largest = 0;
  mesh_box(d->mesh->nodes, d->mesh->xy, d->displacement, lo, hi);
  fit_picture(lo, hi, 1, size);
  FILE *script = open_in(directory, "plastic.gp");
  if (!script) return 0;
  for (int e = 0; e < d->mesh->quads; e++) {
    const double *p = d->plastic_strain + 4 * e, mean = (p[0] + p[1] + p[2] + p[3]) / 4;
    largest = fmax(largest, mean);
    for (int k = 0; k < 5; k++) {
      const int node = d->mesh->node[4 * e + k % 4];
      if (k == 0) fprintf(script, "set object %d polygon", e + 1);
      fprintf(script, " %s %.9g,%.9g", k == 0 ? "from" : "to", corner(d, node, 0, 1),
              corner(d, node, 1, 1));
    }
    fprintf(script, " fs solid 1 noborder fc palette cb %.6g\n", mean);
  }
  fprintf(script,
          "set title '%s: equivalent plastic strain'\nset size ratio -1\nset key off\n"
          "set palette defined (0 '#f4f4f4', 0.4 '#f0b060', 0.7 '#c03020', 1 '#400020')\n"
          "set xlabel 'mm'\nset xrange [%g:%g]\nset yrange [%g:%g]\nset cbrange [0:%g]\n",
          title, lo[0], hi[0], lo[1], hi[1], largest > 0 ? largest : 1);
  begin_pictures(script, "plastic", size[0], size[1]);
  fputs("  plot NaN with points palette\n  unset output\n}\n", script);
  return close_file(script, "plastic.gp");
}

/* Draws the force over the displacement. */
static int write_force(const char *directory, const char *title, const dls_forming_data *d) {
  FILE *script = open_in(directory, "force.gp");
  if (!script) return 0;
  fprintf(script,
          "set title '%s'\nset datafile separator ','\nset key off\nset grid\n"
          "set xlabel 'displacement [mm]'\nset ylabel 'force [%s]'\n",
          title, d->axisymmetric ? "N per radian" : "N per mm of thickness, half of the block");
  begin_pictures(script, "force", 900, 600);
  fputs("  plot 'force.csv' every ::1 using 1:2 with lines lw 2 lc rgb '#3060a0'\n"
        "  unset output\n}\n",
        script);
  return close_file(script, "force.gp");
}

int draw_forming(const char *directory, const char *title, const dls_forming_data *data) {
  if (!write_mesh(directory, title, data) || !write_plastic(directory, title, data) ||
      !write_force(directory, title, data))
    return EXIT_BAD_INPUT;
  /* without gnuplot the run is still good: data and scripts are there */
  if (run_gnuplot(directory, "mesh.gp") && run_gnuplot(directory, "plastic.gp"))
    (void)run_gnuplot(directory, "force.gp");
  return EXIT_SOLVED;
}
