/*
 * forming_picture.c: draws the mesh with tools and contact forces, the plastic strain, pressure and
 * shear on the surface, the force. An axisymmetric body lies on its side, the ram on the left: u =
 * y downwards, v = x; else u = x, v = y.
 */
#include <math.h>
#include <string.h>

#include "problem.h"

/* Part of the plane that a picture shows, and its pixels. */
typedef struct view {
  int turned;          /* 1: axisymmetric */
  double lo[2], hi[2]; /* of u and v */
  double scale;        /* pixels per length */
} view;

/* Writes a point as u, v. */
static void put_point(FILE *data, const view *w, double x, double y) {
  fprintf(data, "%.9g %.9g", w->turned ? y : x, w->turned ? x : y);
}

/* Writes a node at rest or deformed. */
static void put_node(FILE *data, const view *w, const dls_forming_data *d, int node, int deformed) {
  const double *x = d->mesh->xy + 2 * node, *move = d->displacement + 2 * node;
  put_point(data, w, x[0] + deformed * move[0], x[1] + deformed * move[1]);
  fputc('\n', data);
}

/* Returns 1 for the tool that moves. */
static int moves(const dls_forming_tool *tool) {
  return !strcmp(tool->name, "ram") || !strcmp(tool->name, "cylinder");
}

/* Fits the view to the mesh, at rest and deformed, with room for tools. */
static void fit_view(const dls_forming_data *d, view *w) {
  double lo[2], hi[2];
  mesh_box(d->mesh->nodes, d->mesh->xy, d->displacement, lo, hi);
  w->turned = d->axisymmetric;
  const double room = 0.25 * fmin(hi[0] - lo[0], hi[1] - lo[1]);
  for (int i = 0; i < 2; i++) {
    const int from = w->turned ? 1 - i : i;
    w->lo[i] = lo[from] - (from == 0 ? 0 : 0.5 * room);
    w->hi[i] = hi[from] + room;
  }
  w->scale = (w->turned ? 1080 : 420) / (w->hi[0] - w->lo[0]);
}

static void put_ranges(FILE *script, const view *w) {
  const double left = w->turned ? w->hi[0] : w->lo[0], right = w->turned ? w->lo[0] : w->hi[0];
  fprintf(script,
          "set size ratio -1\nset key off\nset xrange [%g:%g]\nset yrange [%g:%g]\n"
          "set xlabel '%s'\nset ylabel '%s'\nset xtics %g\nset ytics %g\n",
          left, right, w->lo[1], w->hi[1], w->turned ? "z [mm]" : "x [mm]",
          w->turned ? "r [mm]" : "y [mm]", w->turned ? 50. : 10., w->turned ? 25. : 10.);
}

/* Writes the outlines of the tools; back: in, the way that the one that moves is put back. */
static void put_tools(FILE *data, const view *w, const dls_forming_data *d, double back) {
  for (int k = 0; k < d->tools; k++) {
    const dls_forming_tool *tool = &d->tool[k];
    for (int i = 0; i < tool->points; i++) {
      put_point(data, w, tool->outline[2 * i], tool->outline[2 * i + 1] + moves(tool) * back);
      fputc('\n', data);
    }
    if (tool->points) fputc('\n', data);
  }
  fputc('\n', data);
}

/* Draws Figs. 2 and 3 of the paper: the mesh at rest and the deformed one, tools, and an arrow for
 * each contact force. */
static int write_mesh(const char *directory, const char *title, const dls_forming_data *d) {
  double largest = 0;
  view w;
  fit_view(d, &w);
  for (int i = 0; i < d->mesh->nodes; i++)
    largest = fmax(largest, hypot(d->reaction[2 * i], d->reaction[2 * i + 1]));
  const double arrow = largest > 0 ? (w.turned ? 0.15 : 0.25) * (w.hi[1] - w.lo[1]) / largest : 0;
  FILE *data =
      open_table(directory, "mesh.dat",
                 "# blocks 0, 1: tools and elements at rest; 2, 3: deformed; 4: contact forces\n");
  if (!data) return 0;
  for (int deformed = 0; deformed < 2; deformed++) {
    put_tools(data, &w, d, deformed ? 0 : d->travel);
    for (int e = 0; e < d->mesh->quads; e++) {
      for (int k = 0; k < 5; k++)
        put_node(data, &w, d, d->mesh->node[4 * e + k % 4], deformed);
      fputc('\n', data);
    }
    fputc('\n', data);
  }
  for (int i = 0; i < d->mesh->nodes; i++) {
    const double *r = d->reaction + 2 * i, *x = d->mesh->xy + 2 * i, *u = d->displacement + 2 * i;
    if (hypot(r[0], r[1]) <= 1e-3 * largest) continue;
    put_point(data, &w, x[0] + u[0] - arrow * r[0], x[1] + u[1] - arrow * r[1]);
    fputc(' ', data);
    put_point(data, &w, arrow * r[0], arrow * r[1]);
    fputc('\n', data);
  }
  if (!close_file(data, "mesh.dat")) return 0;
  FILE *script = open_script(directory, "mesh");
  if (!script) return 0;
  put_ranges(script, &w);
  const double wide = w.scale * (w.hi[0] - w.lo[0]), high = w.scale * (w.hi[1] - w.lo[1]);
  begin_pictures(script, "mesh", w.turned ? wide + 120 : 2 * wide + 200,
                 w.turned ? 2 * high + 260 : high + 150);
  fprintf(script,
          "  set multiplot layout %s title %s.', longest arrow %.3g N'\n"
          "  set style fill solid 1 noborder\n"
          "  plot 'mesh.dat' index 0 with filledcurves closed lc rgb '#c8c8c8', \\\n"
          "       '' index 1 with lines lc rgb '#3060a0'\n"
          "  plot 'mesh.dat' index 2 with filledcurves closed lc rgb '#c8c8c8', \\\n"
          "       '' index 3 with lines lc rgb '#3060a0'%s\n",
          w.turned ? "2,1" : "1,2", quote(AS_GNUPLOT, title).text, largest,
          arrow > 0 ? ", \\\n       '' index 4 using 1:2:3:4 with vectors filled size screen "
                      "0.006,18 lw 1.2 lc rgb '#c03020'"
                    : "");
  return draw_script(script, directory, "mesh");
}

/* Draws the equivalent plastic strain, mean of each element, on the deformed mesh, and tools. */
static int write_plastic(const char *directory, const char *title, const dls_forming_data *d) {
  double largest = 0;
  view w;
  fit_view(d, &w);
  FILE *data = open_table(directory, "plastic.dat",
                          "# block 0: tools, 1: elements with their plastic strain\n");
  if (!data) return 0;
  put_tools(data, &w, d, 0);
  for (int e = 0; e < d->mesh->quads; e++) {
    const double *p = d->plastic_strain + 4 * e, mean = (p[0] + p[1] + p[2] + p[3]) / 4;
    largest = fmax(largest, mean);
    for (int k = 0; k < 5; k++) {
      const int node = d->mesh->node[4 * e + k % 4];
      put_point(data, &w, d->mesh->xy[2 * node] + d->displacement[2 * node],
                d->mesh->xy[2 * node + 1] + d->displacement[2 * node + 1]);
      fprintf(data, " %.6g\n", mean);
    }
    fputc('\n', data);
  }
  if (!close_file(data, "plastic.dat")) return 0;
  FILE *script = open_script(directory, "plastic");
  if (!script) return 0;
  put_ranges(script, &w);
  fprintf(script,
          "set title %s.': equivalent plastic strain [-]'\n"
          "set palette defined (0 '#f4f4f4', 0.4 '#f0b060', 0.7 '#c03020', 1 '#400020')\n"
          "set cbrange [0:%g]\nset style fill solid 1 noborder\n",
          quote(AS_GNUPLOT, title).text, largest > 0 ? largest : 1);
  if (w.turned)
    fputs("set colorbox horizontal user origin 0.25,0.12 size 0.5,0.045\nset bmargin 8\n", script);
  const double wide = w.scale * (w.hi[0] - w.lo[0]), high = w.scale * (w.hi[1] - w.lo[1]);
  const double grow = w.turned ? 1 : 1.4;
  begin_pictures(script, "plastic", grow * wide + (w.turned ? 120 : 220),
                 grow * high + (w.turned ? 230 : 120));
  fputs("  plot 'plastic.dat' index 0 with filledcurves closed lc rgb '#c8c8c8', \\\n"
        "       '' index 1 using 1:2:3 with filledcurves closed fc palette\n",
        script);
  return draw_script(script, directory, "plastic");
}

enum { MOST_CELLS = 2000 }; /* of the map: a quarter of a megabyte */

/* Draws pressure and shear along the surface at the end, and the pressure over the path: every
 * k-th step, to the last. */
static int write_pressure(const char *directory, const char *title, const dls_forming_data *d) {
  const int every = 1 + d->steps * d->candidates / MOST_CELLS;
  FILE *script = open_script(directory, "pressure");
  if (!script) return 0;
  fprintf(script, "set xlabel '%s'\n", d->axisymmetric ? "z [mm]" : "x [mm]");
  begin_pictures(script, "pressure", 1100, 520);
  fprintf(script,
          "  set multiplot layout 1,2 title %s\n"
          "  set key %s\n  set grid\n  set ylabel 'traction [MPa]'\n"
          "  set tmargin at screen 0.88\n  set bmargin at screen 0.14\n"
          "  set lmargin at screen 0.1\n  set rmargin at screen 0.45\n"
          "  plot 'pressure_end.dat' using 1:2 with linespoints pt 7 ps 0.5 lc rgb '#3060a0' "
          "title 'pressure', \\\n"
          "       '' using 1:3 with linespoints pt 5 ps 0.5 lc rgb '#c03020' title 'shear'\n"
          "  unset grid\n  set key off\n  set xtics %d\n  set ylabel 'travel "
          "[mm]' offset -1\n"
          "  set lmargin at screen 0.58\n  set rmargin at screen 0.86\n"
          "  set cblabel 'pressure [MPa]' offset 2\n  set view map\n"
          "  set palette defined (0 '#ffffff', 0.3 '#f0b060', 0.7 '#c03020', 1 '#400020')\n"
          "  set cbrange [0:*]\n"
          "  splot 'pressure.dat' every 1:%d:0:%d using 2:1:3 with pm3d\n",
          quote(AS_GNUPLOT, title).text, d->axisymmetric ? "top left" : "top right",
          d->axisymmetric ? 100 : 10, every, (d->steps - 1) % every);
  return draw_script(script, directory, "pressure");
}

/* Forces of independent codes for the scenes as they come: travel, lowest, highest. */
static const double force_bands[2][3][3] = {
    {{1, 4809, 4891}, {5, 9123, 9188}, {10, 12709, 12842}},
    {{39.116, 40734, 42192}, {81.788, 176615, 183925}, {124.46, 612562, 637928}}};

/* Draws the force over the displacement; as_is: 1 for a scene as it comes, beside other codes. */
static int write_force(const char *directory, const char *title, const dls_forming_data *d,
                       int as_is) {
  FILE *script = open_script(directory, "force");
  if (!script) return 0;
  fprintf(script,
          "set title %s\nset datafile separator ','\nset key %s\nset grid\n"
          "set xrange [0:%g]\nset yrange [0:*]\n"
          "set xlabel 'displacement [mm]'\nset ylabel 'force [%s]'\n",
          quote(AS_GNUPLOT, title).text, as_is ? "top left" : "off", d->whole,
          d->axisymmetric ? "kN per radian" : "kN per mm of thickness, half of the block");
  if (as_is) {
    fputs("$codes << end\n", script);
    for (int k = 0; k < 3; k++) {
      const double *band = force_bands[d->axisymmetric][k];
      fprintf(script, "%g,%g,%g,%g\n", band[0], (band[1] + band[2]) / 2e3, band[1] / 1e3,
              band[2] / 1e3);
    }
    fputs("end\n", script);
  }
  begin_pictures(script, "force", 900, 600);
  fprintf(script,
          "  plot 'force.csv' every ::1 using 1:($2/1000) with lines lw 2 lc rgb '#3060a0' title "
          "'delassus'%s\n",
          as_is ? ", \\\n       $codes using 1:2:3:4 with yerrorbars pt 6 ps 1.4 lw 2 lc rgb "
                  "'#c03020' title 'band of independent codes'"
                : "");
  return draw_script(script, directory, "force");
}

/* Writes position, pressure and shear of the first candidates, which follow each other on the
 * surface: reactions over the lengths that their nodes stand for. */
static void put_pressures(FILE *data, const dls_forming_data *d, const char *head) {
  const int *node = d->candidate_node, along = d->axisymmetric;
  int count = 2;
  while (count < d->candidates && node[count] - node[count - 1] == node[1] - node[0])
    count++;
  for (int c = 0; c < count; c++) {
    double x[2], length = 0;
    for (int i = 0; i < 2; i++)
      x[i] = d->mesh->xy[2 * node[c] + i] + d->displacement[2 * node[c] + i];
    for (int other = c - 1; other <= c + 1; other += 2) {
      if (other < 0 || other >= count) continue;
      const int k = 2 * node[other];
      length += hypot(d->mesh->xy[k] + d->displacement[k] - x[0],
                      d->mesh->xy[k + 1] + d->displacement[k + 1] - x[1]) /
                2;
    }
    const double area = along ? length * x[0] : length;
    fprintf(data, "%s%.9g %.6g %.6g\n", head, x[along], d->r[2 * c] / area, d->r[2 * c + 1] / area);
  }
}

void write_pressures(FILE *data, const dls_forming_data *d) {
  char head[40];
  (void)snprintf(head, sizeof head, "%.9g ", d->travel);
  put_pressures(data, d, head);
  fputc('\n', data);
}

/* Writes pressure and shear at the end. */
static int write_end(const char *directory, const dls_forming_data *d) {
  FILE *data = open_table(directory, "pressure_end.dat", "# position, pressure, shear\n");
  if (!data) return 0;
  put_pressures(data, d, "");
  return close_file(data, "pressure_end.dat");
}

int draw_forming(const char *directory, const char *title, const dls_forming_data *data,
                 int as_is) {
  return write_mesh(directory, title, data) && write_plastic(directory, title, data) &&
                 write_end(directory, data) && write_pressure(directory, title, data) &&
                 write_force(directory, title, data, as_is)
             ? EXIT_SOLVED
             : EXIT_BAD_INPUT;
}
