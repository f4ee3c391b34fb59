/*
 * auto.c: compares the method auto with the single methods.
 *
 *   auto NAME... [--out DIR]
 *       auto.md: for each problem and tolerance the CPU of the solve, ms, "-" for not solved, and
 *       the stages of auto; for each method how often it solved, and its CPU over that of the
 *       fastest other method
 *   auto --price [SEED] [--out DIR]
 *       price.md: the cost of a step of each method in sweeps, measured and assumed by auto
 *       (auto_price.c); fails if they differ by more than a factor of 2
 *   auto --total [SEED]
 *       on the screen: what auto solves of generated problems, and its cost (auto_price.c)
 *
 * NAME is one of
 *   FILE       an FCLIB file
 *   contact-N  a half-space under a flat stamp of N x N points that is pressed and turned
 *   plane-N    an elastic half-plane of N cells, held far below, pressed and pushed; most stick
 * The methods run in turn; the least of several times counts. At most 20000 sweeps.
 */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "auto_price.h"
#include "common.h"
#include "half_space.h"
#include "problem/matrices.h"
#include "regret_kinds.h"

enum { methods = 6, auto_at = 5, tolerances = 3, most_files = 100, most_sweeps = 20000 };

static const double tolerance[tolerances] = {1e-4, 1e-8, 1e-12};
static const char *const method_name[methods] = {"nlgs", "anderson", "newton",
                                                 "admm", "augm. L.", "auto"};
static const dls_method method_of[methods] = {
    DLS_NLGS, DLS_NLGS, DLS_NEWTON, DLS_ADMM, DLS_AUGMENTED_LAGRANGIAN, DLS_AUTO};

/* ---- problems -------------------------------------------------------------------------------- */

/* That of a file, or one that is made here. */
typedef struct either {
  problem file;
  regret_problem made;
  const dls_contact *contact;
} either;

static void make_stamp(int n, regret_problem *p) {
  const int nc = n * n;
  double *at = malloc(2 * (size_t)nc * sizeof *at);
  if (!at || regret_room(p, 3, nc)) exit(1);
  for (int c = 0; c < nc; c++) {
    const double x = at[2 * c] = (double)(c % n) / n - 0.5;
    const double y = at[2 * c + 1] = (double)(c / n) / n - 0.5;
    p->own.q[3 * c] = -0.1 + 0.15 * x;
    p->own.q[3 * c + 1] = 0.02 - 0.1 * y;
    p->own.q[3 * c + 2] = 0.1 * x;
    p->own.mu[c] = 0.5;
  }
  half_space(nc, at, 1. / n, p->W);
  free(at);
}

/* Returns 1 if the problem is there, 0 after a message. */
static int named_problem(const char *name, either *p) {
  int n;
  const source from = {.matrices = {.on = DLS_ON_W}};
  *p = (either){.contact = &p->made.contact};
  if (sscanf(name, "contact-%d", &n) == 1) {
    make_stamp(n, &p->made);
  } else if (sscanf(name, "plane-%d", &n) == 1) {
    if (regret_room(&p->made, 2, n)) exit(1);
    (void)half_plane(p->made.W, p->made.own.q, p->made.own.mu, n, 100, 0.5, 0, 1);
  } else {
    p->contact = &p->file.contact;
    return problem_open(name, &from, &p->file);
  }
  return 1;
}

static void drop_problem(either *p) {
  regret_free(&p->made);
  problem_free(&p->file);
}

static const char *short_name(const char *path) {
  const char *slash = strrchr(path, '/');
  return slash ? slash + 1 : path;
}

/* ---- the comparison -------------------------------------------------------------------------- */

typedef struct result {
  dls_status status;
  bench_clock clock;
  dls_info info;
} result;

/* Solves p by every method. all: one result a method. */
static void compare_methods(const dls_contact *p, double tol, result *all) {
  const size_t m = (size_t)p->d * (size_t)p->nc;
  double *r = malloc(m * sizeof *r), total = 0;
  dls_solver *solver[methods];
  for (int k = 0; k < methods; k++) {
    dls_solver_settings s;
    dls_solver_settings_init(&s);
    s.method = method_of[k];
    s.limits.tol = tol;
    s.limits.blocks = p->Wb.x ? p->Wb.p[p->nc] : 0;
    if (k == 1) s.acceleration = DLS_ACCELERATION_ANDERSON;
    if (k < 2) s.limits.max_iterations = most_sweeps;
    all[k] = (result){DLS_OK};
    if (!r || dls_solver_create(&solver[k], p->d, p->nc, &s, NULL)) exit(1);
  }
  for (int round = 0; round < 50 && (round < 2 || total < 0.1); round++)
    for (int k = 0; k < methods; k++) {
      if (round > 1 && all[k].status && all[k].clock.least > 0.1) continue; /* known */
      bench_start(&all[k].clock);
      all[k].status = dls_solver_solve(solver[k], p, r, NULL, &all[k].info, NULL);
      total += bench_stop(&all[k].clock);
    }
  for (int k = 0; k < methods; k++)
    dls_solver_destroy(solver[k]);
  free(r);
}

static void print_head(FILE *page) {
  bench_print(page, "CPU of the solve, ms; -: not solved. Problems with more than 20 contacts, to "
                    "1e-8; the screen has all.\n\n| problem | contacts |");
  for (int k = 0; k < methods; k++)
    bench_print(page, " %s |", method_name[k]);
  bench_print(page, " stages of auto |\n|---|---|---|---|---|---|---|---|---|\n");
}

static void print_row(FILE *page, const char *name, const dls_contact *p, double tol,
                      const result *all) {
  if (p->nc <= 20 || tol != 1e-8) page = NULL;
  if (page)
    bench_print(page, "| %s | %d |", name, p->nc);
  else
    bench_print(page, "| %s | %d, %g |", name, p->nc, tol);
  for (int k = 0; k < methods; k++) {
    if (all[k].status)
      bench_print(page, " - |");
    else
      bench_print(page, " %.3g |", 1e3 * all[k].clock.least);
  }
  const dls_info *info = &all[auto_at].info;
  for (int k = 0; k < info->stages; k++)
    bench_print(page, "%s%s %d", k ? ", " : " ", dls_method_name(info->stage[k].method),
                info->stage[k].iterations);
  bench_print(page, " |\n");
}

static void print_summary_head(FILE *page) {
  bench_print(page,
              "\nCPU over that of the fastest other single method that solves the problem.\n\n| "
              "tol | method | solved | median | largest |\n|---|---|---|---|---|\n");
}

/* Prints for each method how many problems it solved, and its CPU over that of the best other one.
 */
static void print_summary(FILE *page, double tol, int count, result (*all)[methods]) {
  for (int k = 0; k < methods; k++) {
    double ratio[most_files];
    size_t solved = 0, ratios = 0;
    for (int f = 0; f < count; f++) {
      double best = INFINITY;
      for (int l = 0; l < methods; l++)
        if (l != k && l != auto_at && !all[f][l].status) best = fmin(best, all[f][l].clock.least);
      if (all[f][k].status) continue;
      solved++;
      if (best < INFINITY) ratio[ratios++] = all[f][k].clock.least / best;
    }
    const double median = bench_median(ratios, ratio);
    bench_print(page, "| %g | %s | %zu/%d | %.2g | %.2g |\n", tol, method_name[k], solved, count,
                median, ratios ? ratio[ratios - 1] : NAN);
  }
}

static int run_comparison(FILE *page, int count, const char *const *name) {
  static result all[tolerances][most_files][methods];
  print_head(page);
  for (int f = 0; f < count; f++) {
    either p;
    if (!named_problem(name[f], &p)) return EXIT_BAD_INPUT;
    for (int t = 0; t < tolerances; t++) {
      compare_methods(p.contact, tolerance[t], all[t][f]);
      print_row(page, short_name(name[f]), p.contact, tolerance[t], all[t][f]);
    }
    drop_problem(&p);
  }
  print_summary_head(page);
  for (int t = 0; t < tolerances; t++)
    print_summary(page, tolerance[t], count, all[t]);
  return EXIT_SOLVED;
}

/* Returns 0 after a message if a name is none. */
static int can_read(int count, const char *const *name) {
  for (int f = 0; f < count; f++) {
    either p;
    if (!named_problem(name[f], &p)) return 0;
    drop_problem(&p);
  }
  return 1;
}

int main(int argc, char **argv) {
  static const char usage[] = "[--price] [--total] [--out DIR] [NAME... | SEED]";
  const char *name[most_files];
  int count = 0;
  if (!bench_options(argc, argv, usage)) return 2;
  while (count < most_files && (name[count] = bench_other(argc, argv, usage, count)))
    count++;
  const uint64_t seed = count ? strtoull(name[0], NULL, 10) : 1;
  const int price = bench_has(argc, argv, "--price");
  if (bench_has(argc, argv, "--total")) return total_report(seed), 0;
  if (!price && !count) return complain("name a file, contact-N or plane-N");
  if (!price && !can_read(count, name)) return EXIT_BAD_INPUT; /* the page stays */
  FILE *page =
      bench_program(argc, argv, usage, price ? "price" : "auto",
                    price ? "Cost of a step, in sweeps" : "auto against the single methods");
  const int status = !price                     ? run_comparison(page, count, name)
                     : price_report(page, seed) ? EXIT_NOT_SOLVED
                                                : EXIT_SOLVED;
  return fclose(page) ? EXIT_BAD_INPUT : status;
}
