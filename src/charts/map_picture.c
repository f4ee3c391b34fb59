/* map_picture.c: draws maps of verdicts, and what all maps share (map.h). */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "map.h"

map_cell *map_at(const map_picture *p, int panel, int row, int column) {
  return &p->cells[(panel * p->rows + row) * p->columns + column];
}

void spread_friction(double from, double to, int rows, double *mu) {
  const double least = from > 0 ? from : to / 200;
  const int first = from > 0 ? 0 : 1;
  if (first) mu[0] = 0;
  for (int i = first; i < rows; i++) {
    const double part = rows - 1 > first ? (double)(i - first) / (rows - 1 - first) : 1;
    mu[i] = least * pow(to / least, part);
  }
}

/* Mixes a colour with white: part 1 is the colour, 0 is white. */
static void shade(map_cell *cell, const char *colour, double part) {
  const long rgb = strtol(colour + 1, NULL, 16);
  unsigned mixed = 0;
  for (int k = 16; k >= 0; k -= 8)
    mixed = mixed << 8 | (unsigned)lround(255 + part * (double)((rgb >> k & 255) - 255));
  (void)snprintf(cell->colour, sizeof cell->colour, "#%06x", mixed & 0xffffffu);
}

void map_verdict(map_cell *cell, ending e, double times_fastest) {
  cell->hatched = e == ENDED_UNDECIDED;
  if (e != ENDED_SOLVED) {
    shade(cell, ending_colour(e), 1);
    (void)snprintf(cell->text, sizeof cell->text, "%s", ending_word(e));
    return;
  }
  /* dark at the fastest, pale at a hundred times and more */
  shade(cell, ending_colour(e), 0.15 + 0.85 * fmax(0, 1 - log10(fmax(times_fastest, 1)) / 2));
  (void)snprintf(cell->text, sizeof cell->text, times_fastest < 9.95 ? "%.1f" : "%.0f",
                 times_fastest);
}

void map_share(map_cell *cell, double share, int hatched) {
  cell->hatched = hatched;
  if (share >= 0.5)
    shade(cell, ending_colour(ENDED_SOLVED), 2 * share - 1);
  else
    shade(cell, ending_colour(ENDED_LIKELY_NONE), 1 - 2 * share);
  (void)snprintf(cell->text, sizeof cell->text, "%.0f", 100 * share);
}

/* Returns white for the text of a dark cell, else black. */
static const char *ink(const char *colour) {
  const long rgb = strtol(colour + 1, NULL, 16);
  const double light =
      0.3 * (double)(rgb >> 16) + 0.59 * (double)(rgb >> 8 & 255) + 0.11 * (double)(rgb & 255);
  return light < 128 ? "#ffffff" : "#000000";
}

static int write_map_data(const map_picture *p) {
  FILE *file = open_in(p->directory, "map.dat");
  if (!file) return 0;
  fputs("# a block for each panel: column row colour ink text hatched; then: side row\n", file);
  for (int k = 0; k < p->panels; k++) {
    fputs("-9 -9 0xffffff 0xffffff x 0\n-9 -9 0xffffff 0xffffff x 1\n",
          file); /* keeps a block of no rows */
    for (int i = 0; i < p->rows; i++)
      for (int j = 0; j < p->columns; j++) {
        const map_cell *c = map_at(p, k, i, j);
        if (c->colour[0])
          fprintf(file, "%d %d 0x%s 0x%s \"%s\" %d\n", j, i, c->colour + 1, ink(c->colour) + 1,
                  c->text, c->hatched);
      }
    fputs("\n\n", file);
  }
  for (int i = 0; p->side && i < p->rows; i++)
    if (p->side[i] > 0 && isfinite(p->side[i]))
      fprintf(file, "%.5g %d\n", p->side[i], i);
    else
      fprintf(file, "NaN %d\n", i);
  return close_file(file, "map.dat");
}

static const double line_key = 21; /* pixels of a line in the key */

/* The layout in pixels. */
typedef struct layout {
  double width, height, cell_w, cell_h, left, top, side, gap_x, gap_y;
  int across, down; /* panels */
} layout;

static layout lay_out(const map_picture *p) {
  size_t longest = 0, widest = 0;
  for (int i = 0; i < p->rows; i++)
    if (strlen(p->row[i]) > longest) longest = strlen(p->row[i]);
  for (int k = 0; k < p->panels * p->rows * p->columns; k++)
    if (strlen(p->cells[k].text) > widest) widest = strlen(p->cells[k].text);
  const int many = p->panels > 1;
  for (int j = 0; j < p->columns && !many; j++)
    if (strlen(p->column[j]) > widest) widest = strlen(p->column[j]);
  layout l = {.cell_w = many ? 46 : fmax(88, 10 + 8.4 * (double)widest),
              .cell_h = many           ? 26
                        : p->rows > 24 ? 22
                                       : 31};
  l.across = p->panels < 3 ? p->panels : 3;
  l.down = (p->panels + l.across - 1) / l.across;
  l.left = 55 + 7.2 * (double)longest;
  l.top = 95;
  l.side = p->side ? 190 : 0;
  l.gap_x = l.left;
  l.gap_y = 80;
  l.width = l.across * (l.left + p->columns * l.cell_w) + (l.side > 0 ? l.side + 60 : 25);
  l.width = fmax(l.width, 880); /* of the words on top */
  l.height =
      l.top + l.down * (p->rows * l.cell_h + l.gap_y) + (p->notes ? 25 : 0) + line_key * p->lines;
  return l;
}

static void set_pixels(FILE *s, const layout *l, double left, double right, double top,
                       double bottom) {
  place_panel(s, left / l->width, right / l->width, 1 - bottom / l->height, 1 - top / l->height);
}

/* Names every row and column. Rows have the names of files, which tics would take as formats of
 * printf: they are labels, and so is the name of their axis. */
static void write_names(FILE *s, const map_picture *p, const layout *l, double left, double top,
                        const char *y) {
  for (int i = 0; i < p->rows; i++)
    fprintf(s,
            "  set label %s at graph 0,first %d right offset -0.8,0 noenhanced tc rgb '#808080'\n",
            quote(AS_GNUPLOT, p->row[i]).text, i);
  fprintf(s, "  set label '%s' at screen %.5f,%.5f center rotate\n  set xtics scale 0 (", y,
          (left - l->left + 20) / l->width, 1 - (top + p->rows * l->cell_h / 2) / l->height);
  for (int j = 0; j < p->columns; j++)
    fprintf(s, "%s%s %d", j ? ", " : "", quote(AS_GNUPLOT, p->column[j]).text, j);
  fprintf(s, ") noenhanced font ',%d'\n", p->panels > 1 ? 10 : 11);
}

static void write_map_panel(FILE *s, const map_picture *p, const layout *l, int k) {
  const double left = l->left + k % l->across * (l->left + p->columns * l->cell_w),
               top = l->top + (k / l->across) * (p->rows * l->cell_h + l->gap_y);
  set_pixels(s, l, left, left + p->columns * l->cell_w, top, top + p->rows * l->cell_h);
  if (p->panel[k])
    fprintf(s, "  set title %s offset 0,-0.7 noenhanced tc rgb '%s'\n",
            quote(AS_GNUPLOT, p->panel[k]).text, method_colour(p->panel[k]));
  else
    fputs("  unset title\n", s);
  fprintf(s, "  set xlabel '%s'\n  unset label\n  set xrange [-0.5:%g]\n  set yrange [-0.5:%g]\n",
          k / l->across == l->down - 1 || k + l->across >= p->panels ? p->x : "", p->columns - 0.5,
          p->rows - 0.5);
  write_names(s, p, l, left, top, k % l->across ? "" : p->y);
  for (int i = 0; i < p->lines; i++)
    fprintf(s,
            "  set arrow from first %g,first %.4f to first %g,first %.4f nohead lw 2.5 dt 2 lc rgb "
            "'%s' front\n",
            -0.5, p->line[i].row, p->columns - 0.5, p->line[i].row, p->line[i].colour);
  fprintf(
      s,
      "  plot 'map.dat' index %d using 1:2:(0.49):(0.47):3 with boxxyerror fs solid noborder lc "
      "rgb variable, \\\n       '' index %d using ($6 > 0 ? $1 : NaN):2:(0.49):(0.47) with "
      "boxxyerror "
      "fs "
      "transparent pattern 4 noborder lc rgb '#909090', \\\n       '' index %d using 1:2:5:4 with "
      "labels font ',%d' tc rgb variable\n  unset arrow\n",
      k, k, k, p->panels > 1 ? 9 : 11);
}

/* Draws the panel beside. */
static void write_side(FILE *s, const map_picture *p, const layout *l) {
  const double left = l->left + p->columns * l->cell_w + 35, right = left + l->side;
  double lo = INFINITY, hi = 0;
  for (int i = 0; i < p->rows; i++)
    if (p->side[i] > 0 && isfinite(p->side[i])) {
      lo = fmin(lo, p->side[i]);
      hi = fmax(hi, p->side[i]);
    }
  if (!(hi > 0)) lo = hi = 1;
  if (hi < 10 * lo) {
    lo /= 2;
    hi *= 2;
  }
  set_pixels(s, l, left, right, l->top, l->top + p->rows * l->cell_h);
  fprintf(s,
          "  set title '%s' offset 0,-0.7\n  unset label\n  unset xlabel\n  set "
          "logscale x\n"
          "  set xrange [%g:%g]\n  set yrange [-0.5:%g]\n  set format x '10^{%%T}'\n  set grid "
          "xtics lc rgb '#d8d8d8'\n"
          "  set xtics norangelimit autofreq enhanced\n",
          p->side_title, lo / 1.5, hi * 1.5, p->rows - 0.5);
  for (int i = 0; i < p->lines; i++)
    fprintf(s,
            "  set arrow from graph 0,first %.4f to graph 1,first %.4f nohead lw 2.5 dt 2 lc rgb "
            "'%s'\n",
            p->line[i].row, p->line[i].row, p->line[i].colour);
  fprintf(s,
          "  plot 'map.dat' index %d using 1:2 with linespoints pt 7 ps 1.1 lw 2.5 lc rgb "
          "'#000000'\n  unset arrow\n  unset label\n  unset logscale\n",
          p->panels);
}

static int write_map_script(const map_picture *p) {
  FILE *s = open_script(p->directory, "map");
  if (!s) return 0;
  const layout l = lay_out(p);
  fputs("set datafile missing 'NaN'\nset key off\n", s);
  begin_pictures(s, "map", l.width, l.height);
  fputs("  set multiplot\n", s);
  set_pixels(s, &l, 0, l.width, 0, 60);
  fprintf(s,
          "  unset border\n  unset tics\n  set xrange [0:1]\n  set yrange [0:1]\n  unset title\n"
          "  unset xlabel\n  unset ylabel\n  unset grid\n"
          "  set label %s at screen %.5f,%.5f left font ',17' noenhanced\n"
          "  set label %s at screen %.5f,%.5f left font ',13' noenhanced tc rgb '#404040'\n",
          quote(AS_GNUPLOT, p->title).text, 20 / l.width, 1 - 22 / l.height,
          quote(AS_GNUPLOT, p->subtitle).text, 20 / l.width, 1 - 48 / l.height);
  if (p->notes)
    fprintf(s, "  set label %s at screen %.5f,%.5f left font ',12' noenhanced\n",
            quote(AS_GNUPLOT, p->notes).text, 20 / l.width, 14 / l.height);
  for (int i = 0; i < p->lines; i++) { /* their key */
    const double y = (14 + (p->notes ? 25 : 0) + line_key * i) / l.height;
    fprintf(s,
            "  set arrow from screen %.5f,%.5f to screen %.5f,%.5f nohead lw 2.5 dt 2 lc rgb '%s'\n"
            "  set label %s at screen %.5f,%.5f left font ',13'\n",
            20 / l.width, y, 60 / l.width, y, p->line[i].colour,
            quote(AS_GNUPLOT, p->line[i].text).text, 70 / l.width, y);
  }
  fputs("  plot -1 with lines\n  unset label\n  unset arrow\n  set border lc rgb '#808080'\n", s);
  for (int k = 0; k < p->panels; k++)
    write_map_panel(s, p, &l, k);
  if (p->side) write_side(s, p, &l);
  return draw_script(s, p->directory, "map");
}

/* Takes out the columns of a panel in which no cell is filled. */
static void drop_columns(map_picture *p) {
  const int columns = p->columns;
  int kept = 0, filled[MAP_COLUMNS] = {0};
  for (int k = 0; k < p->rows * columns; k++)
    filled[k % columns] |= p->cells[k].colour[0] != 0;
  for (int j = 0; j < columns; j++)
    if (filled[j]) memmove(p->column[kept++], p->column[j], MAP_NAME);
  p->columns = kept;
  for (int k = 0, to = 0; k < p->rows * columns; k++)
    if (filled[k % columns]) p->cells[to++] = p->cells[k];
}

int draw_map(const map_picture *given) {
  map_picture p = *given;
  if (p.panels == 1 && p.rows) drop_columns(&p);
  const int drawn = write_map_data(&p) ? write_map_script(&p) : 0;
  if (drawn == 2) tell("drawn: %s/map.png\n", quote(AS_SHOWN, p.directory).text);
  return drawn ? EXIT_SOLVED : EXIT_BAD_INPUT;
}
