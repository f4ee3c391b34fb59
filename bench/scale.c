/*
 * scale.c: compares every fast enough method of delassus with Siconos' Gauss-Seidel on rigid bodies
 * from 300 to 100,000 contacts, and two elastic ones up to 2000; shows how time grows.
 *
 *   scale [--kind KIND] [--sizes N,N,..] [--tol TOL] [--seed S] [--seeds COUNT] [--limit SECONDS]
 *         [--mu MU] [--bodies] [--no-peer] [--only METHOD,..] [--out DIR]
 *
 *   --kind    one of the first 24 of regret_kinds.c, or the beginning of its name; all. In full
 *             also the others
 *   --seeds   so many seeds: S, S + 2, ..
 *   --mu      friction; .5
 *   --bodies  kinds of rigid.h as bodies, W = H^T H, not by blocks; without the peer
 *   --only    these of delassus: auto, nlgs, momentum, anderson, admm, augmented
 *
 * Writes scale.md, the largest size of each kind, and, for scale.gp, scale.csv with all of them:
 * kind, contacts, CPU of auto, of the best other method, of the peer; empty for none. The screen
 * shows all.
 *
 * Time is CPU of the solve from r = 0 (solvers_call.c). A cell that is not a time shows how the
 * solve ended. The exponent of growth is the slope of log(time of auto) over log(contacts).
 */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "common.h"
#include "regret_kinds.h"
#include "solvers.h"

enum { most_sizes = 8, most_runs = 400 };

typedef struct plan {
  const char *kind;
  int sizes[most_sizes], size_count, seeds, no_peer, bodies;
  unsigned long seed;
  double tol, limit, mu;
  const char *only; /* NULL: all */
  FILE *page, *csv;
} plan;

enum { all = 1000000 };
static const own_method own[] = {
    {"auto", "auto", "none", .most = {all, all}},
    {"nlgs", "nlgs", "none", .most = {all, all}},
    {"momentum", "nlgs", "momentum", .most = {all, all}},
    {"anderson", "nlgs", "anderson", .most = {20000, 20000}},
    {"admm", "admm", "none", .most = {20000, 20000}},
    {"augmented", "augmented-lagrangian", "none", .most = {5000, 5000}}};
enum { own_count = sizeof own / sizeof own[0] };

/* Prints a cell of the table and returns the time, INFINITY if the target was not met. */
static double print_cell(FILE *page, const outcome *o, double tol) {
  static const char *const why[] = {"", "refused", "limit", "crash"};
  const double seconds = outcome_seconds(o, tol);
  if (isfinite(seconds)) {
    bench_print(page, " %.3g (%d) |", o->cpu, o->iterations);
    return seconds;
  }
  if (o->ended == ENDED)
    bench_print(page, " %s %.0e |", o->claim ? "WRONG" : "not", o->certificate.residual);
  else
    bench_print(page, " %s |", why[o->ended]);
  return INFINITY;
}

/* Returns 1 if the list of --only names the method. */
static int is_wanted(const plan *p, const char *name) {
  const size_t length = strlen(name);
  for (const char *next = p->only; next && *next; next += *next == ',') {
    if (strncmp(next, name, length) == 0 && (next[length] == ',' || !next[length])) return 1;
    next += strcspn(next, ",");
  }
  return !p->only;
}

/* Returns 1 if a method beside auto is wanted. */
static int has_other(const plan *p) {
  return !p->only || strcmp(p->only, "auto") != 0;
}

/* Prints a over b; nothing where neither is a time. */
static void print_ratio(FILE *page, double a, double b) {
  if (isfinite(a) && isfinite(b))
    bench_print(page, " %.2f |", a / b);
  else
    bench_print(page, isfinite(a) ? " alone |" : " |");
}

/* Returns the peer's sweeps for this dimension and storage. */
static const peer_method *sweeps_of_peer(const scene *s) {
  const char *storage = s->contact.W.a ? "dense" : "blocks";
  for (int k = 0; peer_at(k); k++)
    if (strcmp(peer_name(peer_at(k)), "siconos-nsgs") == 0 && peer_takes(peer_at(k), s, 0) &&
        strcmp(peer_storage(peer_at(k), s), storage) == 0)
      return peer_at(k);
  return NULL;
}

/* Measures one problem. page: NULL shows it on the screen alone. worst: the largest time of auto
 * over the peer's so far. Returns the time of auto. */
static double run_problem(const plan *p, FILE *page, const char *kind, const dls_contact *problem,
                          unsigned long seed, double *worst) {
  scene s = {.set = kind, .contact = *problem};
  double best = INFINITY, automatic = INFINITY;
  bench_print(page, "| %s | %lu | %d |", kind, seed, problem->nc);
  for (int k = 0; k < own_count; k++) {
    if (!is_wanted(p, own[k].name)) continue;
    if (problem->nc > own[k].most[0]) {
      bench_print(page, " |");
      continue;
    }
    const outcome o = measure(&s, own_solve, &own[k], p->tol, p->limit);
    const double t = print_cell(page, &o, p->tol);
    if (k == 0)
      automatic = t;
    else
      best = fmin(best, t);
  }
  double peer = INFINITY;
  if (!p->no_peer) {
    const peer_method *sweeps = sweeps_of_peer(&s);
    const outcome o =
        sweeps ? peer_reach(sweeps, &s, p->tol, p->limit) : (outcome){.ended = REFUSED};
    peer = print_cell(page, &o, p->tol);
  }
  if (has_other(p)) print_ratio(page, automatic, best);
  if (isfinite(automatic) && isfinite(peer)) *worst = fmax(*worst, automatic / peer);
  const double time[] = {automatic, best, peer};
  fprintf(p->csv, "%s,%d", kind, problem->nc);
  for (int k = 0; k < 3; k++)
    fprintf(p->csv, isfinite(time[k]) ? ",%.4g" : ",", time[k]);
  fprintf(p->csv, "\n");
  return automatic;
}

static void run_kind(const plan *p, const char *kind) {
  double contacts[most_runs], seconds[most_runs], worst = NAN;
  int count = p->size_count, solved = 0;
  size_t tried = 0;
  while (regret_is_pair(kind) && count > 0 && p->sizes[count - 1] > regret_most_of_pair)
    count--;
  for (int k = 0; k < count; k++)
    for (int s = 0; s < p->seeds; s++) {
      regret_problem a;
      const unsigned long seed = p->seed + 2 * (unsigned long)s;
      if (regret_create(&a, kind, p->sizes[k], p->mu, seed)) {
        fprintf(stderr, "%s: unknown, or out of memory\n", kind);
        continue;
      }
      if (p->bodies) a.contact = a.bodies.factored;
      FILE *page = k == count - 1 ? p->page : NULL;
      contacts[tried] = a.contact.nc;
      seconds[tried] = run_problem(p, page, kind, &a.contact, seed, &worst);
      solved += isfinite(seconds[tried++]);
      regret_free(&a);
      if (page && s == p->seeds - 1) {
        const double slope = bench_exponent(tried, contacts, seconds, tried);
        bench_print(page, " %d of %zu | ", solved, tried);
        bench_print(page, isfinite(slope) ? "%.2f |" : "|", slope);
        if (!p->no_peer) bench_print(page, isfinite(worst) ? " %.2f |" : " |", worst);
      } else
        bench_print(page, p->no_peer ? " | |" : " | | |");
      bench_print(page, "\n");
    }
}

int main(int argc, char **argv) {
  plan p = {.kind = bench_word(argc, argv, "--kind", ""),
            .only = bench_word(argc, argv, "--only", NULL),
            .sizes = {300, 2500, 20000, 100000},
            .seeds = (int)bench_number(argc, argv, "--seeds", 1),
            .seed = (unsigned long)bench_number(argc, argv, "--seed", 2),
            .tol = bench_number(argc, argv, "--tol", 1e-4),
            .limit = bench_number(argc, argv, "--limit", 60),
            .mu = bench_number(argc, argv, "--mu", 0.5),
            .bodies = bench_has(argc, argv, "--bodies")};
  if (p.seeds * most_sizes > most_runs) return 2;
  p.no_peer = p.bodies || bench_has(argc, argv, "--no-peer");
  p.size_count = bench_list(argc, argv, "--sizes", p.sizes, 4, most_sizes);
  const char *out = bench_word(argc, argv, "--out", "build");
  p.page = bench_program(argc, argv,
                         "[--kind KIND] [--sizes N,N..] [--tol TOL] [--seed SEED] [--seeds N] "
                         "[--mu MU] [--limit SECONDS] [--only METHOD] [--no-peer] [--bodies] "
                         "[--out DIR]",
                         "scale", "Rigid and elastic bodies: time against size");
  p.csv = bench_open(out, "scale.csv");
  if (!p.csv) return 1;
  fprintf(p.csv, "kind,candidates,auto,own,peer\n");
  bench_print(p.page, "residual %g.\n\n| kind | seed | contacts |", p.tol);
  int columns = 2;
  for (int k = 0; k < own_count; k++)
    if (is_wanted(&p, own[k].name)) bench_print(p.page, " %s |", own[k].name), columns++;
  if (!p.no_peer) bench_print(p.page, " Siconos |"), columns += 2;
  if (has_other(&p)) bench_print(p.page, " auto / own |"), columns++;
  bench_print(p.page, " solved | exponent |");
  if (!p.no_peer) bench_print(p.page, " worst beside Siconos |");
  bench_print(p.page, "\n|---|---|---|");
  for (int k = 0; k < columns; k++)
    bench_print(p.page, "---|");
  bench_print(p.page, "\n");
  int known = 0;
  for (int k = 0; k < regret_listed; k++)
    if (strncmp(regret_kind(k), p.kind, strlen(p.kind)) == 0)
      run_kind(&p, regret_kind(k)), known = 1;
  if (!known) run_kind(&p, p.kind);
  return fclose(p.page) + fclose(p.csv) ? 1 : 0;
}
