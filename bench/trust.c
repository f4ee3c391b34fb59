/*
 * trust.c: compares the estimate of dls_contact_sensitivity with the true error, over files,
 * elastic blocks and cubes, and the contact problems of data/failures. Writes trust.md.
 *
 * r*: auto with tol = 1e-13. Answers r to judge: sweeps of Gauss-Seidel and ADMM, stopped at 1e-4,
 * 1e-5, 1e-6 and 1e-8. Predicted: sensitivity.error of r alone, without r*. Observed: |r - r*| /
 * |r*|. The row of a scene is the r with the smallest prediction over observation, the most
 * optimistic one.
 *
 * Besides, 11,000 random problems, W = A A^T / m + shift I with shift 0.1 or 0.001, d = 1, 2, 3, up
 * to 60 rows, even seeds: sweeps or ADMM at 1e-4 to 1e-8 compared with a proved r*.
 */
#include <dirent.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "common.h"
#include "delassus/trust.h"
#include "solvers.h"

enum { most_scenes = 400, most_rows = 900, randoms = 11000, random_rows = 60 };

typedef struct trust_row {
  char name[64];
  dls_sensitivity s;
  double residual, predicted, observed;
  int changed; /* candidates whose state is not that of r* */
} trust_row;

typedef struct trust_table {
  trust_row row[most_scenes];
  int count, skipped;
} trust_table;

static int solve_by(const dls_contact *p, dls_method method, double tol, double *r,
                    dls_info *info) {
  dls_solver_settings s;
  dls_solver_settings_init(&s);
  s.method = method;
  s.limits.tol = tol;
  s.limits.cpu_seconds = 20;
  return dls_solve(p, &s, r, NULL, info, NULL) == DLS_OK;
}

/* Returns how many candidates have other states in r than in exact; -1 if that is not known. */
static int count_changed(const dls_contact *p, const double *r, const double *exact) {
  const size_t nc = (size_t)p->nc, m = (size_t)p->d * nc;
  dls_contact_state *state = malloc(2 * nc * sizeof *state);
  double *u = malloc(m * sizeof *u);
  dls_certificate c;
  int changed = -1;
  if (state && u && !dls_contact_certify(p, r, u, &c, NULL) &&
      !dls_contact_states(p, r, u, state, NULL) && !dls_contact_certify(p, exact, u, &c, NULL) &&
      !dls_contact_states(p, exact, u, state + nc, NULL)) {
    changed = 0;
    for (size_t k = 0; k < nc; k++)
      changed += state[k] != state[nc + k];
  }
  free(state);
  free(u);
  return changed;
}

/* Judges one scene; leaves out what has no r* with reactions of full rank. */
static void judge_scene(void *data, const scene *s) {
  static const double tols[] = {1e-4, 1e-5, 1e-6, 1e-8};
  static const dls_method methods[] = {DLS_NLGS, DLS_ADMM};
  trust_table *t = data;
  const dls_contact *p = &s->contact;
  const size_t m = (size_t)p->d * (size_t)p->nc;
  double *exact = malloc(2 * m * sizeof *exact), *r = exact + m, least = INFINITY;
  trust_row row = {.name = ""};
  dls_sensitivity of;
  dls_info info;
  (void)snprintf(row.name, sizeof row.name, "%.8s: %.50s", s->set, s->name);
  if (!exact || t->count == most_scenes || m > most_rows) {
    free(exact);
    return;
  }
  if (!solve_by(p, DLS_AUTO, 1e-13, exact, &info) || dls_contact_sensitivity(p, exact, &of, NULL) ||
      !of.rows || of.rank < of.rows || of.border) {
    t->skipped++;
    free(exact);
    return;
  }
  for (int k = 0; k < 8; k++) {
    if (!solve_by(p, methods[k % 2], tols[k / 2], r, &info)) continue;
    if (dls_contact_sensitivity(p, r, &of, NULL)) continue;
    const double observed = bench_distance(m, r, exact), share = of.error / observed;
    if (!(observed > 1e-11 && info.certificate.residual > 1e-11) || !(share < least)) continue;
    least = share;
    row.s = of;
    row.residual = info.certificate.residual;
    row.predicted = of.error;
    row.observed = observed;
    row.changed = count_changed(p, r, exact);
  }
  if (least < INFINITY)
    t->row[t->count++] = row;
  else
    t->skipped++;
  free(exact);
}

/* ---- random problems ------------------------------------------------------------------------- */

typedef struct trust_tally {
  int judged, skipped, above_1, above_10;
  int same, same_above_1; /* of those whose states are all those of r* */
  double largest, same_largest;
} trust_tally;

static void judge_random(void *data, const scene *s) {
  static double r[2 * random_rows];
  static const dls_method methods[] = {DLS_NLGS, DLS_ADMM};
  trust_tally *t = data;
  const dls_contact *p = &s->contact;
  double *exact = r + random_rows;
  const int k = atoi(s->name);
  dls_sensitivity of;
  dls_proof proof;
  dls_info info;
  const double tol = pow(10, -4 - k / 6 % 5);
  const int good = solve_by(p, DLS_AUTO, 1e-8, exact, &info) &&
                   !dls_contact_prove(p, exact, &proof, exact, NULL) && proof.kind == DLS_PROVED &&
                   solve_by(p, methods[k % 2], tol, r, &info) &&
                   !dls_contact_sensitivity(p, r, &of, NULL);
  const double observed = good ? bench_distance((size_t)(p->d * p->nc), r, exact) : NAN;
  if (!(observed > 1e-11 && info.certificate.residual > 1e-11)) {
    t->skipped++;
    return;
  }
  const double over = observed / of.error;
  const int same = count_changed(p, r, exact) == 0;
  t->judged++;
  t->above_1 += over > 1;
  t->above_10 += over > 10;
  t->largest = fmax(t->largest, over);
  t->same += same;
  t->same_above_1 += same && over > 1;
  if (same) t->same_largest = fmax(t->same_largest, over);
}

static void print_tally(FILE *page, const trust_tally *t) {
  bench_print(page,
              "\n%d random problems of up to %d rows, true / predicted: above 1 in %d (%.2f %%), "
              "above 10 in %d, largest %.3g; %d more have\nr = 0, no proved r*, or no error above "
              "rounding. Of the %d with the states of r*: above 1 in %d, largest %.3g.\n",
              t->judged, random_rows, t->above_1, 100.0 * t->above_1 / t->judged, t->above_10,
              t->largest, t->skipped, t->same, t->same_above_1, t->same_largest);
}

/* ---- files ----------------------------------------------------------------------------------- */

static int is_contact_text(const struct dirent *e) {
  const char *end = strrchr(e->d_name, '.');
  return e->d_name[0] == 'c' && end && strcmp(end, ".txt") == 0;
}

static void judge_text(const char *directory, const char *name, trust_table *t) {
  dls_text *text;
  scene s = {.set = "text"};
  char path[400];
  (void)snprintf(path, sizeof path, "%s/%s", directory, name);
  if (dls_text_read(&text, path, NULL)) return;
  (void)snprintf(s.name, sizeof s.name, "%.50s", name);
  if (!dls_text_is_lcp(text) && !dls_text_contact(text, &s.contact, NULL)) judge_scene(t, &s);
  dls_text_destroy(text);
}

static int judge_texts(const char *directory, trust_table *t) {
  struct dirent **entry;
  const int count = scandir(directory, &entry, is_contact_text, alphasort);
  for (int k = 0; k < count; k++) {
    judge_text(directory, entry[k]->d_name, t);
    free(entry[k]);
  }
  if (count >= 0) free(entry);
  return count < 0;
}

int main(int argc, char **argv) {
  static trust_table t;
  static double share[most_scenes];
  FILE *page =
      bench_program(argc, argv, "[--out DIR]", "trust", "What a residual means for the reactions");
  if (judge_texts("data/failures", &t) || scenes_files("data/fclib", judge_scene, &t) ||
      scenes_blocks(0, judge_scene, &t) || scenes_cubes(0, judge_scene, &t))
    return 1;
  trust_tally tally = {0};
  for (int k = 0; k < randoms; k++)
    if (scenes_random(k, 0, random_rows - 1, judge_random, &tally)) return 1;
  for (int k = 0; k < t.count; k++)
    share[k] = t.row[k].predicted / t.row[k].observed;
  const int count = t.count;
  int below = 0, close = 0;
  for (int k = 0; k < count; k++) {
    below += share[k] < 0.8;
    close += share[k] >= 0.8 && share[k] <= 10;
  }
  bench_print(page,
              "\nThe relative error of r that `dls_contact_sensitivity` predicts from r alone, and "
              "the true one, |r - r*| / |r*|;\nof the answers of sweeps and of ADMM at 1e-4 to "
              "1e-8 the one with the least predicted / true. %d scenes; %d more\nhave no r* to "
              "compare with: rank below rows, a contact on the border of two states, r = 0, or no\n"
              "answer with an error above rounding.\n\npredicted / true: below 0.8 in %d, 0.8 to "
              "10 in %d, median %.2f. The last column counts contacts whose state is another\none "
              "than in r*, a problem with several solutions for instance: there nothing is "
              "predicted. The page has the scenes below 0.8\nand above 3, the screen all.\n",
              count, t.skipped, below, close, bench_median((size_t)count, share));
  print_tally(page, &tally);
  bench_print(page, "\n| scene | rows | amplification | residual | predicted | true | predicted / "
                    "true | other states |\n|---|---|---|---|---|---|---|---|\n");
  for (int k = 0; k < count; k++) {
    const trust_row *row = &t.row[k];
    bench_print(share[k] < 0.8 || share[k] > 3 ? page : NULL,
                "| %s | %d | %.3g | %.1e | %.1e | %.1e | %.2f | %d |\n", row->name, row->s.rows,
                row->s.amplification, row->residual, row->predicted, row->observed,
                row->predicted / row->observed, row->changed);
  }
  return fclose(page) != 0;
}
