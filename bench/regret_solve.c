/* regret_solve.c: one problem by auto, by each of its methods and by the peer (regret.h). */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "common.h"
#include "regret.h"

static const own_method automatic = {"auto", "auto", "none", .most = {1000000, 1000000}};
static const own_method own[] = {
    {"momentum", "nlgs", "momentum", .most = {1000000, 1000000}},
    {"anderson", "nlgs", "anderson", .most = {1000000, 1000000}},
    {"newton", "newton", "none", .most = {1000000, 1000000}},
    {"nlgs", "nlgs", "none", .most = {1000000, 1000000}},
    {"admm", "admm", "none", .most = {1000000, 1000000}},
    {"lemke", "lemke", "none", .most = {300, 60}},
    {"augmented", "augmented-lagrangian", "none", .most = {1000000, 1000000}},
    {"homotopy", "homotopy", "none", .most = {150, 100}},
    {"convex", "auto", "none", .most = {1000000, 1000000}, .step = "convex"},
    {"splitting", "auto", "none", .most = {2000, 2000}, .step = "splitting"},
    {"cold-splitting", "auto", "none", .most = {2000, 2000}, .step = "cold-splitting"},
    {"near-splitting", "auto", "none", .most = {2000, 2000}, .step = "near-splitting"},
    {"scatter", "auto", "none", .most = {150, 100}, .step = "scatter"}};
enum { own_count = sizeof own / sizeof own[0] };

static const double least_limit = 0.02; /* s: below, a limit would measure the clock */
static const double beside_auto = 2;    /* a method slower than so many times auto is stopped */
static const double hopeless = 20;      /* auto is stopped at so many times the best method */
static const double shown_from = 1.3;   /* regret from which the stages are kept */

/* Prints one line of --one. */
static void print_attempt(const char *name, const char *setting, const outcome *o, double tol) {
  static const char *const why[] = {"not solved", "refused", "limit", "crash"};
  const double t = outcome_seconds(o, tol);
  if (isfinite(t))
    printf("%-14s %-10s %10.3f ms\n", name, setting, 1e3 * t);
  else
    printf("%-14s %-10s %s, residual %.1e, %.3f ms\n", name, setting, why[o->ended],
           o->certificate.residual, 1e3 * o->cpu);
}

static outcome try_own(const own_method *w, const scene *s, double tol, double limit, int info) {
  own_method a = *w;
  a.limit = limit;
  a.no_info = !info;
  return measure(s, own_solve, &a, tol, 1.5 * limit + 0.1);
}

static int is_bonded(const dls_contact *problem) {
  for (int c = 0; c < problem->nc; c++)
    if (isinf(problem->mu[c])) return 1;
  return 0;
}

static void solve_by_peer(const scene *s, double tol, double limit, int all, result *r) {
  for (int k = 0; peer_at(k); k++) {
    const peer_method *p = peer_at(k);
    const double most = all ? limit : fmin(limit, r->peer);
    if (!peer_takes(p, s, 0)) continue;
    const outcome o = peer_reach(p, s, tol, most);
    const double cpu = outcome_seconds(&o, tol);
    if (all) print_attempt(peer_name(p), peer_setting(p), &o, tol);
    if (!(cpu < r->peer)) continue;
    r->peer = cpu;
    r->peer_method = peer_name(p);
  }
}

/* ---- stages ---------------------------------------------------------------------------------- */

enum { most_parts = 60 };

/* The parts of a solve, as the progress callback sees them. */
typedef struct journal {
  int count;
  struct part {
    char name[24];
    int iterations;
    double since, until, residual; /* CPU, s */
  } part[most_parts];
} journal;

static int note_progress(void *data, const dls_progress *p) {
  journal *j = data;
  struct part *at = j->count ? &j->part[j->count - 1] : NULL;
  if (p->last || !p->stage) return 0;
  if (!at || strcmp(at->name, p->stage) != 0 || p->iteration < at->iterations) {
    if (j->count == most_parts) return 0;
    const double since = at ? at->until : 0;
    at = &j->part[j->count++];
    snprintf(at->name, sizeof at->name, "%s", p->stage);
    at->since = since;
  }
  at->iterations = p->iteration;
  at->until = p->cpu_seconds;
  at->residual = p->residual;
  return 0;
}

/* Appends to text (size). */
static void append(char *text, size_t size, const char *more) {
  const size_t used = strlen(text);
  snprintf(text + used, size - used, "%s", more);
}

/* Writes the stages of a solve by auto: name, iterations, CPU in ms, residual. */
static void regret_stages(const dls_contact *problem, double tol, double limit, char *text,
                          size_t size) {
  const size_t m = (size_t)problem->d * (size_t)problem->nc;
  journal *j = calloc(1, sizeof *j);
  double *r = calloc(m, sizeof *r);
  dls_solver_settings settings;
  char line[96];
  text[0] = 0;
  own_settings(&settings, &automatic, problem, tol);
  settings.limits.cpu_seconds = limit;
  settings.limits.progress = note_progress;
  settings.limits.progress_data = j;
  if (j && r) (void)!dls_solve(problem, &settings, r, NULL, NULL, NULL);
  for (int k = 0; j && k < j->count; k++) {
    const struct part *at = &j->part[k];
    snprintf(line, sizeof line, "%s%s %d: %.3g ms, %.0e", k ? "; " : "", at->name, at->iterations,
             1e3 * (at->until - at->since), at->residual);
    append(text, size, line);
  }
  free(j);
  free(r);
}

/* ---- one problem ----------------------------------------------------------------------------- */

double regret_of(const result *r) {
  if (isinf(r->best)) return isinf(r->automatic) ? NAN : 1 / beside_auto;
  return (isinf(r->automatic) ? fmax(r->limit, r->best) : r->automatic) / r->best;
}

void regret_solve(const scene *s, double tol, const regret_how *how, result *r) {
  const int d = s->contact.d, all = how->all;
  r->limit = how->seconds * fmax(1, s->contact.nc / 500.);
  r->method = r->peer_method = "";
  r->best = r->peer = INFINITY;
  outcome o = try_own(&automatic, s, tol, r->limit, how->info);
  r->status = o.status;
  r->automatic = outcome_seconds(&o, tol);
  if (all) print_attempt("auto", "", &o, tol);
  for (int k = 0; k < own_count; k++) {
    const double least = fmin(beside_auto * r->automatic, r->best);
    const double limit = all ? r->limit : fmin(r->limit, fmax(least_limit, least));
    if (s->contact.nc > own[k].most[d - 2]) continue;
    o = try_own(&own[k], s, tol, limit, how->info);
    if (all) print_attempt(own[k].name, "", &o, tol);
    const double cpu = outcome_seconds(&o, tol);
    if (!(cpu < r->best)) continue;
    r->best = cpu;
    r->method = own[k].name;
  }
  if (isinf(r->automatic) && hopeless * r->best > r->limit && isfinite(r->best)) {
    r->limit = hopeless * r->best;
    o = try_own(&automatic, s, tol, r->limit, how->info);
    r->automatic = outcome_seconds(&o, tol);
  }
  const double quickest = fmin(r->automatic, r->best);
  if (!how->no_peer && isfinite(quickest) && !is_bonded(&s->contact))
    solve_by_peer(s, tol, all ? r->limit : fmax(least_limit, beside_auto * quickest), all, r);
  r->stages[0] = 0;
  if (all || !(regret_of(r) < shown_from))
    regret_stages(&s->contact, tol, r->limit, r->stages, sizeof r->stages);
}
