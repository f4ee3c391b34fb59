/*
 * regret.c: how much time the method auto loses to the best of its own methods, on generated
 * problems of many kinds.
 *
 *   regret [--seed S] [--step N] [--count N] [--kinds A,B,..] [--tol TOL] [--seconds LIMIT]
 *          [--no-peer] [--info] [--out DIR] [--file X.hdf5]..
 *   regret --one KIND SIZE MU SEED [--tol TOL] [--seconds LIMIT]
 *   regret --list
 *
 *   --seed     of the first problem, the next ones have S + N, S + 2 N, ..; 2. Tune on odd seeds,
 *              report even ones
 *   --step     N; 2
 *   --count    number of problems; 3 of each kind: about 4 to 16 contacts, 17 to 100, up to 3000
 *   --tol      1e-4 and 1e-8
 *   --seconds  limit of CPU for each solve and 500 contacts; 0.5
 *   --info     solves that fill a dls_info: dense W of up to 300 rows have their error predicted
 *   --file     an FCLIB file (local problem) instead of generated problems; may be repeated
 *   --one      prints the CPU of all methods and the stages of auto
 *
 * regret = CPU of auto / CPU of the best single method whose answer the certificate accepts. A
 * solve is a child process (solvers_call.c): repeated up to 20 ms, the least counts. Methods: nlgs
 * plain, with momentum, with Anderson's acceleration, newton, admm, augmented Lagrangian; for small
 * problems lemke and homotopy; the steps of auto that are no methods, each as a plan of that step
 * alone: convex (with its joints), splitting, cold-splitting, near-splitting, scatter.
 *
 * Writes regret.md and regret.csv.
 */
#include "regret.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "common.h"
#include "regret_kinds.h"

enum { most_files = 64, most_tolerances = 2, most_kinds = 100 };

typedef struct plan {
  unsigned long seed, step;
  int count, files, kinds, tolerances;
  const char *file[most_files], *kind[most_kinds];
  double tol[most_tolerances];
  regret_how how;
  const char *one[4]; /* kind, size, mu, seed */
  result *results;
  int done;
  FILE *page, *csv;
} plan;

static void keep_row(FILE *csv, const result *r) {
  const double time[] = {r->automatic, r->best, r->peer};
  fprintf(csv, "%s,%d,%d,%g,%lu,%g", r->kind, r->size, r->nc, r->mu, r->seed, r->tol);
  for (int k = 0; k < 3; k++)
    fprintf(csv, isfinite(time[k]) ? ",%.4g" : ",", time[k]);
  fprintf(csv, ",%s,%s,\"%s\"\n", r->method, r->peer_method, r->stages);
  fflush(csv);
}

static void solve_to_all(plan *p, const dls_contact *problem, const result *named) {
  scene s = {.set = "regret", .contact = *problem};
  for (int t = 0; t < p->tolerances; t++) {
    result *r = &p->results[p->done++];
    *r = *named;
    r->nc = problem->nc;
    r->tol = p->tol[t];
    if (p->one[0])
      printf("%s, %dD, %d contacts, tol %g\n", r->kind, problem->d, problem->nc, r->tol);
    regret_solve(&s, r->tol, &p->how, r);
    if (p->how.all)
      printf("%s: regret %.2f\nstages of auto: %s\n\n", r->kind, regret_of(r), r->stages);
    if (p->csv) keep_row(p->csv, r);
  }
}

static void solve_generated(plan *p, const char *kind, int size, double mu, unsigned long seed) {
  regret_problem a;
  const result named = {.kind = kind, .size = size, .mu = mu, .seed = seed};
  if (regret_create(&a, kind, size, mu, seed)) {
    fprintf(stderr, "regret: %s %d %g %lu cannot be made\n", kind, size, mu, seed);
    return;
  }
  fprintf(stderr, "%s %d %g %lu: %d contacts\n", kind, size, mu, seed, a.contact.nc);
  solve_to_all(p, &a.contact, &named);
  regret_free(&a);
}

/* Draws size and friction of problem k. */
static void solve_drawn(plan *p, int k) {
  const unsigned long seed = p->seed + p->step * (unsigned long)k;
  const char *kind = p->kind[k % p->kinds];
  uint64_t state = regret_state(seed, 17);
  double at[2];
  char digits[32];
  for (int i = 0; i < 2; i++)
    at[i] = (1 + bench_draw(&state)) / 2;
  static const double from[] = {4, 17, 101}, up_to[] = {16, 100, 101};
  const int band = (k / p->kinds + k % p->kinds) % 3, most = regret_most(kind);
  const double to = fmax(band == 2 ? most : 0, up_to[band]);
  const double size = from[band] * pow(to / from[band], at[0]);
  (void)snprintf(digits, sizeof digits, "%.3g", 0.05 * pow(60, at[1])); /* .05 to 3 */
  solve_generated(p, kind, (int)fmin(size, most), strtod(digits, NULL), seed);
}

static int regret_file(plan *p, const char *path) {
  dls_fclib *file = NULL;
  dls_contact problem;
  dls_error error = {0};
  if (dls_fclib_read(&file, path, &error) || dls_fclib_contact(file, &problem, &error)) {
    fprintf(stderr, "regret: %s: %s\n", path, error.message);
    dls_fclib_destroy(file);
    return -1;
  }
  const result named = {.kind = path, .mu = problem.nc ? problem.mu[0] : 0};
  solve_to_all(p, &problem, &named);
  dls_fclib_destroy(file);
  return 0;
}

/* Splits a list of kinds at its commas. Returns -1 after a message. */
static int read_kinds(plan *p, char *list) {
  for (char *name = strtok(list, ","); name; name = strtok(NULL, ",")) {
    int known = 0;
    for (int k = 0; regret_kind(k) && p->kinds < most_kinds; k++)
      if (strcmp(regret_kind(k), name) == 0) {
        p->kind[p->kinds++] = regret_kind(k);
        known = 1;
      }
    if (!known) {
      fprintf(stderr, "regret: no kind %s; --list has them\n", name);
      return -1;
    }
  }
  return 0;
}

static int regret_options(int argc, char **argv, plan *p) {
  if (!bench_options(argc, argv,
                     "[--list] [--seed SEED] [--step N] [--count N] [--kinds KIND,KIND..] "
                     "[--tol TOL] [--seconds LIMIT] [--no-peer] [--info] [--out DIR] "
                     "[--file X.hdf5] [--one KIND SIZE MU SEED ...]"))
    return -1;
  char list[1024];
  p->how.no_peer = bench_has(argc, argv, "--no-peer");
  p->how.info = bench_has(argc, argv, "--info");
  p->how.seconds = bench_number(argc, argv, "--seconds", 0.5);
  p->seed = (unsigned long)bench_number(argc, argv, "--seed", 2);
  p->step = (unsigned long)bench_number(argc, argv, "--step", 2);
  p->count = (int)bench_number(argc, argv, "--count", 0);
  p->tolerances = bench_has(argc, argv, "--tol") ? 1 : 2;
  if (p->tolerances == 1) p->tol[0] = bench_number(argc, argv, "--tol", 0);
  for (int k = 1; k < argc; k++) {
    for (int i = 0; i < 4 && k + 4 < argc && strcmp(argv[k], "--one") == 0; i++)
      p->one[i] = argv[k + 1 + i];
    if (strcmp(argv[k], "--file") == 0 && p->files < most_files) p->file[p->files++] = argv[k + 1];
  }
  (void)snprintf(list, sizeof list, "%s", bench_word(argc, argv, "--kinds", ""));
  return read_kinds(p, list);
}

/* Opens the page and says what is measured. */
static int open_page(plan *p, const char *out, int argc, char **argv) {
  p->page =
      bench_page(out, "regret", "Regret of auto: its time over the best method's", argc, argv);
  p->csv = p->page ? bench_open(out, "regret.csv") : NULL;
  if (!p->csv) return -1;
  fprintf(p->csv, "kind,size,contacts,mu,seed,tol,auto,best,peer,method,peer method,stages\n");
  fputs("Regret is the CPU of auto over the CPU of the best single method that solves the problem "
        "to the same tolerance. 1: auto loses nothing. Unsolved: auto fails, a method does not; "
        "such problems are in no median. Methods are stopped at twice the CPU of auto: if none "
        "solves by then, regret counts as 0.5. Slower than peer: auto takes longer than the best "
        "solver of Siconos; worst to peer: CPU of auto over it. The screen has a table by kind.\n",
        p->page);
  return 0;
}

int main(int argc, char **argv) {
  plan p = {.tol = {1e-4, 1e-8}};
  if (regret_options(argc, argv, &p)) return 2;
  if (bench_has(argc, argv, "--list")) {
    for (int k = 0; regret_kind(k); k++)
      printf("%s\n", regret_kind(k));
    return 0;
  }
  for (int k = 0; p.kinds == 0 || (k && regret_kind(k)); k++)
    p.kind[p.kinds++] = regret_kind(k);
  if (p.count <= 0) p.count = 3 * p.kinds;
  const int problems = p.files > p.count ? p.files : p.count;
  p.results = calloc((size_t)problems * most_tolerances + 1, sizeof *p.results);
  if (!p.results) return 1;
  int bad = 0;
  p.how.all = p.one[0] || p.files;
  if (p.one[0])
    solve_generated(&p, p.one[0], (int)strtol(p.one[1], NULL, 10), strtod(p.one[2], NULL),
                    strtoul(p.one[3], NULL, 10));
  else if (!(bad = open_page(&p, bench_word(argc, argv, "--out", "build"), argc, argv))) {
    for (int k = 0; k < p.files; k++)
      bad |= regret_file(&p, p.file[k]);
    for (int k = 0; !p.files && k < p.count; k++)
      solve_drawn(&p, k);
    regret_report(p.page, p.done, p.results);
    bad |= fclose(p.page) | fclose(p.csv);
  }
  free(p.results);
  return bad ? 1 : 0;
}
