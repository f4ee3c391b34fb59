/*
 * papers_reactions.c: how far are the reactions of each method from those that the paper prints,
 * and from each other? Reads papers_reactions.csv, which `make demo` computes node by node.
 */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "common.h"
#include "papers.h"

enum { most = 16 };

typedef struct reactions_row {
  char method[32];
  double paper, lemke; /* largest differences, relative */
} reactions_row;

/* Raises the maxima of the method by a line of the file; returns the number of methods. */
static int reactions_line(char *line, reactions_row *row, int count) {
  double value[10] = {0};
  char *field[10] = {0}, *rest = line;
  for (int k = 0; k < 10; k++) {
    field[k] = rest ? strsep(&rest, ",") : "";
    value[k] = strtod(field[k], NULL);
  }
  int k = 0;
  while (k < count && strcmp(row[k].method, field[2]) != 0)
    k++;
  if (k == most) return count;
  if (k == count) {
    row[k] = (reactions_row){0};
    snprintf(row[k].method, sizeof row[k].method, "%s", field[2]);
  }
  if (!(value[8] <= row[k].paper)) row[k].paper = value[8];
  if (!(value[9] <= row[k].lemke)) row[k].lemke = value[9];
  return k == count ? count + 1 : count;
}

int papers_reactions(FILE *page, const char *out) {
  char path[1024], line[512];
  snprintf(path, sizeof path, "%s/papers_reactions.csv", out);
  FILE *file = fopen(path, "r");
  if (!file) {
    perror(path);
    return 1;
  }
  reactions_row row[most];
  int count = 0, rows = 0;
  while (fgets(line, sizeof line, file))
    if (rows++) count = reactions_line(line, row, count);
  fclose(file);
  double converged = 0, apart = 0, as_printed = NAN;
  for (int k = 0; k < count; k++) {
    const int jean = strcmp(row[k].method, "jean") == 0;
    if (jean) as_printed = row[k].paper;
    if (jean || strcmp(row[k].method, "penalty") == 0) continue;
    converged = fmax(converged, row[k].paper);
    apart = fmax(apart, row[k].lemke);
  }
  bench_print(page,
              "## How far are the reactions of each method from the paper's, node by node?\n\nAt "
              "most %.1e of the largest reaction, and the methods differ from each other by at "
              "most %.0e. The paper stopped at\n1e-4: its own sweeps with its own stop reproduce "
              "its tables to %.0e.\n\nThe table has the largest difference over the nodes of Figs. "
              "3 and 4 of [Jean 1988], divided by the largest reaction.\n\n| method | from the "
              "paper | from Lemke's method |\n|---|---|---|\n",
              converged, apart, as_printed);
  for (int k = 0; k < count; k++)
    bench_print(page, "| %s | %.1e | %.0e |\n", row[k].method, row[k].paper, row[k].lemke);
  bench_print(page,
              "\n`make demo` computes it; penalty is one augmentation, and jean is the sweeps of "
              "the paper with its stop.\n\n![Reactions of every method beside the "
              "paper's](../../docs/pictures/papers-reactions.png)\n\n");
  return 0;
}
