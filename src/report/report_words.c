/* report_words.c: the words, the tables and the pictures of an error budget (report.h). */
#include <math.h>
#include <string.h>

#include "report.h"

const char *percent(double part, char text[24]) {
  (void)snprintf(text, 24,
                 !isfinite(part) ? "unknown"
                 : part < 0.1    ? "%.2g %%"
                                 : "%.0f %%",
                 100 * part);
  return text;
}

/* Writes what is asked: "friction force, its curve and pressure". */
static const char *asked_words(const budget *b, char text[120]) {
  static const char *const words[] = {"",          "its curve",   "pressure", "edge of contact",
                                      "slip zone", "energy drift"};
  size_t used = 0;
  for (quantity_of of = OF_FORCE; of < OF_COUNT; of++)
    if (b->of >> of & 1)
      used += (size_t)snprintf(text + used, 120 - used, "%s%s",
                               !used              ? ""
                               : b->of >> of == 1 ? " and "
                                                  : ", ",
                               of == OF_FORCE            ? b->scene->answer
                               : of == OF_CURVE && !used ? "curve"
                                                         : words[of]);
  return text;
}

/* Returns 0 if the scene did not finish, or has run but once. */
static int knows_error(const budget *b) {
  return !b->probe[b->take].got.status && isfinite(b->error);
}

void budget_verdict(const budget *b, char *text, size_t size) {
  const scene *s = b->scene;
  const probe *take = &b->probe[b->take];
  char words[SETTING_ROOM], wanted[24], error[24], of[120], worst[60] = "";
  (void)setting_text(s, &take->at, 0, words);
  (void)percent(b->accuracy, wanted);
  (void)percent(b->error, error);
  const quantity_of most = budget_worst(b, b->take);
  if (b->of & (b->of - 1))
    (void)snprintf(worst, sizeof worst, ", the %s the worst",
                   most == OF_FORCE ? s->answer : quantity_names[most]);
  if (take->got.status) {
    (void)snprintf(text, size, "%s does not finish: %s, after %.0f %% of the steps", s->name,
                   dls_status_text(take->got.status), 100 * take->got.part);
  } else if (!isfinite(b->error)) {
    (void)snprintf(text, size, "Take %s: its error is unknown, %s of CPU are too few (--cpu=S)",
                   words, in_words(b->limit).text);
  } else if (b->met) {
    (void)snprintf(text, size, "Take %s: %s within %s (estimated to: %s%s), %s of CPU", words,
                   asked_words(b, of), wanted, error, worst, in_words(take->got.seconds).text);
  } else {
    (void)snprintf(text, size, "Take %s: %s within %s%s, the best that %s of CPU found, not %s",
                   words, asked_words(b, of), error, worst, in_words(b->limit).text, wanted);
  }
}

void budget_accuracy(const budget *b, page *p) {
  static const char *const words[] = {"",
                                      "curve over the steps (L2)",
                                      "pressure (L2)",
                                      "edge of contact (of the length that touches)",
                                      "slip zone (of the length that touches)",
                                      "energy drift (of the energies in a step)"};
  char text[24], more[SETTING_ROOM];
  const scene *s = b->scene;
  if (!knows_error(b)) return;
  page_say(p, PAGE_PLAIN, "Accuracy, from %s, %.6g %s, and the finest run:",
           isfinite(s->exact) ? "the closed form"
           : b->mesh.low <= b->mesh.high || b->second.low <= b->second.high
               ? "the limit of the meshes"
               : "the limit of the steps",
           b->reference, s->unit);
  page_table(p, "what,within,estimated error of the reference,asked");
  for (quantity_of of = OF_FORCE; of < OF_COUNT; of++) {
    if (!(s->has >> of & 1)) continue;
    page_cell(p, "%s", of == OF_FORCE ? s->answer : words[of]);
    page_cell(p, "%s", percent(budget_within(b, b->take, of), text));
    page_cell(p, "%s", of == OF_DRIFT ? "" : percent(b->doubt[of], text));
    page_cell(p, "%s", b->of >> of & 1 ? "yes" : "no");
  }
  page_table_end(p);
  if (b->disagree && b->of & 1 << OF_FORCE)
    page_say(p, PAGE_PLAIN, "Not decided: the even mesh and the %s tend to answers %s apart.",
             b->second.part, percent(b->doubt[OF_FORCE], text));
  else if (!b->met && b->enough_seconds > 0)
    page_say(
        p, PAGE_PLAIN, "Not decided. By order %.2g it would take %s: a run of about %s of CPU.",
        b->enough_order, setting_text(s, &b->enough, 0, more), in_words(b->enough_seconds).text);
  else if (!b->met && b->enough_order > 0)
    page_say(p, PAGE_PLAIN, "Not decided. By order %.2g, 64 times as fine would not be enough.",
             b->enough_order);
}

/* Adds a row of the budget: a run beside the one of which a part was changed. */
static void add_change(const budget *b, page *p, const char *what, int from, int to) {
  char words[SETTING_ROOM], text[24];
  const probe *x = &b->probe[from], *y = &b->probe[to];
  page_cell(p, "%s", what);
  page_cell(p, "%s", setting_text(b->scene, &y->at, 0, words));
  if (y->got.status)
    page_cell(p, "%s", dls_status_text(y->got.status));
  else
    page_cell(p, "%.6g", y->got.value);
  page_cell(p, "%s", from == to ? "" : percent(fabs(y->got.value / x->got.value - 1), text));
  page_cell(p, "%s", in_words(y->got.seconds).text);
}

/* of: what stays at the scene's own. */
static void say_ladder(page *p, const ladder *l, const char *of) {
  char text[24];
  if (l->low >= l->high) return;
  (void)percent(l->doubt, text);
  const int levels = l->high - l->low + 1;
  if (isfinite(l->order))
    page_say(p, PAGE_PLAIN,
             "%s%s: %d levels. The answer tends to %.6g with order %.2g, estimated to %s.", l->part,
             of, levels, l->limit, l->order, text);
  else
    page_say(p, PAGE_PLAIN, "%s%s: %d levels. The answer %s, at %.6g, estimated to %s.", l->part,
             of, levels,
             l->monotone
                 ? "still moves in one direction, without an order that three limits agree on"
                 : "moves to and fro and has no order",
             l->limit, text);
}

static void add_tried(const budget *b, page *p) {
  enum { MOST_TRIED = 10 }; /* before the one to take */
  char words[SETTING_ROOM], text[24];
  page_table(p, "run,setting,answer,from the reference,CPU");
  for (int k = 0; k < b->probes; k++) {
    const probe *q = &b->probe[k];
    const int tried = !strcmp(q->part, "search") && k + MOST_TRIED > b->take;
    if (k != b->take && k != b->check && !tried) continue;
    page_cell(p, "%s", k == b->take ? "to take" : k == b->check ? "check" : "tried");
    page_cell(p, "%s", setting_text(b->scene, &q->at, 0, words));
    page_cell(p, "%.6g", q->got.value);
    page_cell(p, "%s", percent(budget_error(b, k, OF_FORCE), text));
    page_cell(p, "%s", in_words(q->got.seconds).text);
  }
  page_table_end(p);
}

void budget_tables(const budget *b, page *p) {
  char text[24];
  const scene *s = b->scene;
  char heads[120];
  page_say(p, PAGE_PLAIN,
           "The answer is the %s [%s]. Each row changes one thing of the scene as it is.",
           s->answer, s->unit);
  (void)snprintf(heads, sizeof heads, "changed,setting,answer [%s],moves by,CPU", s->unit);
  page_table(p, heads);
  add_change(b, p, "as it is", b->own, b->own);
  setting at;
  const char *name;
  for (int j = 0; (name = setting_variant(s, j, &at)); j++)
    for (int k = 0; k < b->probes && *name; k++)
      if (setting_is(&b->probe[k].at, &at)) add_change(b, p, name, b->own, k);
  page_table_end(p);
  if (!knows_error(b)) return;
  say_ladder(p, &b->mesh, "");
  say_ladder(p, &b->second, "");
  say_ladder(p, &b->steps, s->own.nx ? " on the mesh of the scene as it is" : "");
  if (isfinite(s->exact))
    page_say(p, PAGE_PLAIN, "Reference: %.6g, the closed form [Doyen, Ern, Piperno 2011].",
             b->reference);
  else
    page_say(p, PAGE_PLAIN, "Reference: %.6g, estimated to %s.", b->reference,
             percent(b->doubt[OF_FORCE], text));
  page_say(p, PAGE_NOTE, "%d runs, %s of CPU.", b->probes, in_words(cpu_seconds() - b->start).text);
  add_tried(b, p);
  if (b->met && b->check < 0)
    page_say(p, PAGE_NOTE, "There was no time for a check run with half the element size.");
}

/* ---- pictures -------------------------------------------------------------------------------- */

static int budget_csv(const budget *b, const char *directory) {
  char words[SETTING_ROOM];
  FILE *file = open_table(directory, "budget.csv", "part,setting,status,answer,error,cpu_s\n");
  if (!file) return 0;
  for (int k = 0; k < b->probes; k++) {
    const probe *p = &b->probe[k];
    fprintf(file, "%s,%s,%s,%.10g,%.3e,%.4e\n", quote(AS_CSV, p->part).text,
            setting_text(b->scene, &p->at, 1, words), status_word(p->got.status), p->got.value,
            budget_error(b, k, OF_FORCE), p->got.seconds);
  }
  return close_file(file, "budget.csv");
}

/* Writes a point, CPU and error; smaller errors than a hundredth of the accuracy stand there. */
static int write_point(FILE *s, const budget *b, int k, double error) {
  const probe *p = &b->probe[k];
  if (p->got.status || !isfinite(error)) return 0;
  fprintf(s, "%.4g %.4g\n", p->got.seconds, 100 * fmax(error, 0.01 * b->accuracy));
  return 1;
}

/* Writes budget.dat: a block for each ladder, from its own limit, and one of the settings that were
 * tried. points: out, of each block. */
static int budget_data(const budget *b, const char *directory, int points[4]) {
  const ladder *const ladders[] = {&b->mesh, &b->steps, &b->tol};
  FILE *s = open_in(directory, "budget.dat");
  if (!s) return 0;
  for (int j = 0; j < 3; j++) {
    fputs("NaN NaN\n", s); /* keeps a block of no rows */
    points[j] = 0;
    for (int level = ladders[j]->low; level <= ladders[j]->high; level++) {
      const int k = ladder_probe(b, ladders[j], level);
      if (k >= 0)
        points[j] += write_point(s, b, k, fabs(b->probe[k].got.value / ladders[j]->truth - 1));
    }
    fputs("\n\n", s);
  }
  fputs("NaN NaN\n", s);
  points[3] = 0;
  for (int k = 0; k < b->probes; k++)
    if (k == b->check || !strcmp(b->probe[k].part, "search"))
      points[3] += write_point(s, b, k, budget_error(b, k, OF_FORCE));
  return close_file(s, "budget.dat");
}

int budget_picture(const budget *b, const char *directory) {
  static const char *const looks[] = {
      "linespoints pt 7 ps 1 lw 2 lc rgb '#0072b2'", "linespoints pt 5 ps 1 lw 2 lc rgb '#e69f00'",
      "linespoints pt 9 ps 1 lw 2 lc rgb '#009e73'", "points pt 6 ps 1.6 lw 2 lc rgb '#000000'"};
  static const char *const titles[] = {"mesh alone", "steps alone", "tolerance alone",
                                       "tried together"};
  int points[4];
  if (!budget_csv(b, directory) || !budget_data(b, directory, points) || !knows_error(b)) return 0;
  FILE *s = open_script(directory, "budget");
  if (!s) return 0;
  fputs("set datafile missing 'NaN'\n", s);
  begin_pictures(s, "budget", 760, 480);
  const probe *take = &b->probe[b->take];
  fprintf(
      s,
      "  set logscale xy\n  set grid lc rgb '#d8d8d8'\n  set key outside top center horizontal\n"
      "  set format x '%%g'\n  set format y '%%g'\n  set xlabel 'CPU [s]'\n"
      "  set ylabel 'error of the %s [%%]'\n  set offsets graph 0.05, graph 0.12, graph 0.08, 0\n"
      "  set label 'take' at first %.5g,%.5g point pt 6 ps 3 lw 3 lc rgb '#d55e00' offset "
      "1.2,0.6 tc rgb '#d55e00' front\n",
      b->scene->answer, take->got.seconds,
      100 * fmax(budget_error(b, b->take, OF_FORCE), 0.01 * b->accuracy));
  fprintf(s, "  plot %g with lines lw 1.5 dt 2 lc rgb '#808080' title 'wanted'", 100 * b->accuracy);
  for (int k = 0; k < 4; k++)
    if (points[k] > 0)
      fprintf(s, ", \\\n       'budget.dat' index %d using 1:2 with %s title '%s'", k, looks[k],
              titles[k]);
  fputs("\n", s);
  return draw_script(s, directory, "budget") == 2;
}
