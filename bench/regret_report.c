/* regret_report.c: the tables of bench/regret (regret.h). */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "common.h"
#include "regret.h"

static const struct band { int least, most; } bands[] = {{1, 16}, {17, 100}, {101, 4000}};
enum { band_count = sizeof bands / sizeof bands[0], worst_shown = 2 };

/* Prints the command that solves a problem again. */
static void print_command(FILE *page, const result *r) {
  if (r->size)
    bench_print(page, "`build/bench/regret --one %s %d %g %lu --tol %g`", r->kind, r->size, r->mu,
                r->seed, r->tol);
  else
    bench_print(page, "`build/bench/regret --file %s --tol %g`", r->kind, r->tol);
}

static int is_in(const result *r, const struct band *b, double tol) {
  return r->nc >= b->least && r->nc <= b->most && r->tol == tol;
}

/* Figures of the problems that a table row is about. */
typedef struct figures {
  int count, unsolved, slower; /* than the peer */
  double median, tenths, worst, beside_peer;
} figures;

/* x: scratch, count. band, kind NULL: any. */
static figures figures_of(int count, const result *results, const struct band *b, const char *kind,
                          double tol, double *x) {
  figures f = {.median = NAN, .tenths = NAN, .worst = NAN};
  for (int k = 0; k < count; k++) {
    const result *r = &results[k];
    if ((b && !is_in(r, b, tol)) || r->tol != tol || (kind && strcmp(kind, r->kind) != 0)) continue;
    if (isinf(r->automatic) && isfinite(r->best)) f.unsolved++;
    const double fastest = isinf(r->automatic) ? r->limit : r->automatic;
    if (isfinite(r->peer) && r->peer < fastest) f.slower++;
    if (isfinite(r->peer)) f.beside_peer = fmax(f.beside_peer, fastest / r->peer);
    if (isfinite(r->automatic)) x[f.count++] = regret_of(r);
  }
  if (f.count == 0) return f;
  f.median = bench_median((size_t)f.count, x);
  f.tenths = x[(int)ceil(0.9 * f.count) - 1];
  f.worst = x[f.count - 1];
  return f;
}

static void print_figures(FILE *page, const figures *f) {
  if (f->count)
    bench_print(page, " %d | %.2f | %.2f | %.1f | %d |", f->count, f->median, f->tenths, f->worst,
                f->unsolved);
  else
    bench_print(page, " 0 | | | | %d |", f->unsolved);
  bench_print(page, " %d | %.2f |\n", f->slower, f->beside_peer);
}

/* Prints the worst of a band; taken: count, scratch. */
static void print_worst(FILE *page, int count, const result *results, const struct band *b,
                        double tol, char *taken) {
  memset(taken, 0, (size_t)count);
  for (int shown = 0; shown < worst_shown; shown++) {
    int at = -1;
    for (int k = 0; k < count; k++)
      if (!taken[k] && is_in(&results[k], b, tol) && isfinite(results[k].automatic) &&
          regret_of(&results[k]) > 1 &&
          (at < 0 || regret_of(&results[k]) > regret_of(&results[at])))
        at = k;
    if (at < 0) return;
    const result *r = &results[at];
    taken[at] = 1;
    bench_print(page, "| %.1f | %d | %.3g | %s %.3g | ", regret_of(r), r->nc, 1e3 * r->automatic,
                r->method, 1e3 * r->best);
    print_command(page, r);
    bench_print(page, " |\n");
  }
}

static void print_unsolved(FILE *page, int count, const result *results) {
  bench_print(page, "\n## Unsolved by auto, solved by a method or alone\n\n"
                    "Regret: the limit of auto over the CPU of the method.\n\n"
                    "| regret | contacts | best method, ms | status of auto | command | stages |\n"
                    "|---|---|---|---|---|---|\n");
  int nobody = 0, alone = 0;
  for (int k = 0; k < count; k++) {
    const result *r = &results[k];
    nobody += isinf(r->automatic) && isinf(r->best);
    alone += isfinite(r->automatic) && isinf(r->best);
    if (isfinite(r->automatic) || isinf(r->best)) continue;
    bench_print(page, "| > %.0f | %d | %s %.3g | %d | ", regret_of(r), r->nc, r->method,
                1e3 * r->best, (int)r->status);
    print_command(page, r);
    bench_print(page, " | %s |\n", r->stages);
  }
  bench_print(
      page,
      "\nSolved by auto, by no method in twice its time: %d. Solved by none of them in their "
      "limits: %d, which the screen names.\n",
      alone, nobody);
  for (int k = 0; k < count; k++) {
    if (isfinite(results[k].automatic) || isfinite(results[k].best)) continue;
    bench_print(NULL, "%s ", "\n-");
    print_command(NULL, &results[k]);
    bench_print(NULL, ", auto: %s", dls_status_text(results[k].status));
  }
  bench_print(NULL, "\n");
}

/* Returns the k-th tolerance among the results; 0 past the last. */
static double tolerance_at(int count, const result *results, int k) {
  double last = INFINITY;
  for (; k >= 0; k--) {
    double next = 0;
    for (int i = 0; i < count; i++)
      if (results[i].tol < last) next = fmax(next, results[i].tol);
    last = next;
  }
  return last;
}

static void print_kinds(FILE *page, int count, const result *results, double *x) {
  bench_print(page,
              "\n## By kind\n\nThe worst regret of a kind, and the worst to the peer, at each "
              "tolerance; kinds with a regret\nof 3 or more, the screen has all.\n\n| kind |");
  int tols = 0;
  for (double tol; (tol = tolerance_at(count, results, tols)) > 0; tols++)
    bench_print(page, " %g | peer |", tol);
  bench_print(page, "\n|---|");
  for (int t = 0; t < 2 * tols; t++)
    bench_print(page, "---|");
  bench_print(page, "\n");
  for (int k = 0; k < count; k++) {
    int before = 0;
    for (int i = 0; i < k && !before; i++)
      before = strcmp(results[i].kind, results[k].kind) == 0;
    if (before) continue;
    double worst = 0;
    for (int t = 0; t < tols; t++)
      worst = fmax(worst, figures_of(count, results, NULL, results[k].kind,
                                     tolerance_at(count, results, t), x)
                              .worst);
    FILE *const kept = worst >= 3 ? page : NULL;
    bench_print(kept, "| %s |", results[k].kind);
    for (int t = 0; t < tols; t++) {
      const figures f =
          figures_of(count, results, NULL, results[k].kind, tolerance_at(count, results, t), x);
      bench_print(kept, f.count ? " %.1f | %.2f |" : " | |", f.worst, f.beside_peer);
    }
    bench_print(kept, "\n");
  }
}

void regret_report(FILE *page, int count, const result *results) {
  double *x = calloc((size_t)count + 1, sizeof *x);
  char *taken = calloc((size_t)count + 1, 1);
  if (!x || !taken) exit(1);
  bench_print(page,
              "\n| contacts | tol | solved | median | nine tenths | worst | unsolved | slower "
              "than peer | worst to peer |\n|---|---|---|---|---|---|---|---|---|\n");
  for (int b = 0; b < band_count; b++)
    for (int t = 0; tolerance_at(count, results, t) > 0; t++) {
      const double tol = tolerance_at(count, results, t);
      const figures f = figures_of(count, results, &bands[b], NULL, tol, x);
      bench_print(page, "| %d..%d | %g |", bands[b].least, bands[b].most, tol);
      print_figures(page, &f);
    }
  for (int b = 0; b < band_count; b++)
    for (int t = 0; tolerance_at(count, results, t) > 0; t++) {
      const double tol = tolerance_at(count, results, t);
      bench_print(page, "\n## The worst of %d to %d contacts at %g\n\n", bands[b].least,
                  bands[b].most, tol);
      bench_print(page, "| regret | contacts | auto, ms | best method, ms | command |\n"
                        "|---|---|---|---|---|\n");
      print_worst(page, count, results, &bands[b], tol, taken);
    }
  print_unsolved(page, count, results);
  print_kinds(NULL, count, results, x); /* the screen */
  free(x);
  free(taken);
}
