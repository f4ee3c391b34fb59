/*
 * history_picture.c: draws history.csv of delassus solve --plot: the residual against iterations
 * and against CPU, each stage in the colour of its method.
 */
#include <string.h>

#include "cli.h"
#include "console/palette.h"

enum { PICTURE_STAGES = 12 };

/* Collects the names of the stages in a history.csv, its fourth column; returns how many, -1 after
 * a complaint. */
static int read_stages(const char *directory, char stage[PICTURE_STAGES][32]) {
  csv_table t;
  int count = 0;
  if (!csv_open(&t, directory, "history.csv")) {
    (void)complain("%s/history.csv: cannot be read again", directory);
    return -1;
  }
  while (csv_next(&t)) {
    const char *name = t.field[t.fields - 1];
    int k = 0;
    while (k < count && strncmp(stage[k], name, 31) != 0)
      k++;
    if (k == count && count < PICTURE_STAGES) (void)snprintf(stage[count++], 32, "%s", name);
  }
  return count;
}

int draw_history(const char *directory, const char *title) {
  char stage[PICTURE_STAGES][32];
  const int count = read_stages(directory, stage);
  if (count < 0) return 0;
  FILE *s = open_script(directory, "history");
  if (!s) return 0;
  fputs("set datafile separator ','\nset datafile missing ''\nset logscale y\n"
        "least(y) = y < 1e-17 ? 1e-17 : y\n" /* 0 on a logarithmic axis */
        "set format y '10^{%T}'\nset grid lc rgb '#d8d8d8'\n",
        s);
  begin_pictures(s, "history", 1300, 560);
  fprintf(s,
          "  set multiplot layout 1,2 title %s noenhanced\n  set key outside bottom center "
          "horizontal\n  set xrange [0:*]\n  set bmargin 6\n  set ylabel 'residual of the "
          "certificate'\n",
          quote(AS_GNUPLOT, title).text);
  for (int panel = 0; panel < 2; panel++) {
    fprintf(s,
            "  set xlabel '%s'\n  plot 'history.csv' every ::1 using %s:(least($3)) with lines lw "
            "1 lc rgb '#b0b0b0' notitle",
            panel ? "CPU [ms]" : "iterations of all stages", panel ? "(1e3*$2)" : "1");
    for (int k = 0; k < count; k++) {
      const quoted name = quote(AS_GNUPLOT, stage[k]);
      fprintf(s,
              ", \\\n       '' every ::1 using %s:(strcol(4) eq %s ? least($3) : 1/0) with points "
              "pt %d ps 1 lw 1.5 lc rgb '%s' title %s noenhanced",
              panel ? "(1e3*$2)" : "1", name.text, method_point(stage[k]), method_colour(stage[k]),
              name.text);
    }
    fputs("\n", s);
  }
  const int drawn = draw_script(s, directory, "history");
  if (drawn == 2) (void)fprintf(stderr, "drawn: %s/history.png\n", quote(AS_SHOWN, directory).text);
  return drawn;
}
