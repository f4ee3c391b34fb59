/*
 * solvers.c: compares every method of delassus with the friction contact solvers of Siconos
 * Numerics, on the same problems, in one run.
 *
 *   solvers [--full] [--patient] [--dir DIR] [--set SET] [--method NAME] [--limit SECONDS]
 *           [--out DIR]
 *
 *   --full      all sizes and friction coefficients (solvers_scenes.c)
 *   --patient   all settings of the peer, 20 s for each solve; many hours
 *   --dir DIR   FCLIB files; data/fclib
 *   --set SET   fclib, block, cube or wall only
 *
 * A target is a residual of the certificate (contact.h), of positions and of forces: 1e-4, 1e-8,
 * 1e-12. A solver meets a target if the certificate of its answer, recomputed here from W, q and
 * mu, holds; its own claim does not count. Verdicts: `limit`, stopped by the CPU limit; `crash`, a
 * signal or exit(); `wrong`, it claims success with a tolerance not above the target, and the
 * certificate does not hold; `refused`, it returns an error.
 *
 * delassus runs with its default settings and the target as its tolerance. The peer measures its
 * error differently: it runs with a series of its own tolerances, and its cheapest run that meets
 * the target counts. The next tolerance of the series is a tenth of the last. Once 1e-4 is met, it
 * is the tolerance for the next target if the residual were proportional to the tolerance, less a
 * decade: (SO1). Only the CPU limit limits its iterations, except for its Newton and proximal
 * methods: their defaults, at least 1000.
 *
 * Time is the CPU of the solve, the least of up to 40 readings of the clock while they take less
 * than 20 ms together; calls are repeated between two readings until these are 50 us apart, each
 * from r = 0. The peer gets matrix and options again for each call; if calls are repeated, also
 * once for all of them; the faster counts. The peer allocates inside its call, delassus in
 * dls_solver_create: that is not in the ratios but in the column setup_s, as is the extra cost of
 * dls_solve over the solve on an existing solver.
 *
 * An impatient run stops a solver of delassus that takes 10 times as long as the best of delassus
 * so far, one of the peer that takes 3 times as long as the best of the peer so far, but neither
 * before 0.2 s: a stopped solver could not have been the best of its side. At the end auto and the
 * best of each side take turns three times more, up to 20 times while auto takes more than 0.8 of
 * the best of the peer: the clock of a machine can change from one solver to the next. The least
 * counts, as a row of its own.
 */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "common.h"
#include "solvers.h"
#include "solvers_report.h"

static const double targets[TARGETS] = {1e-4, 1e-8, 1e-12};
static const double first_step = 1e-3, last_step = 1e-16; /* of the ladder */
/* Limits of an impatient run: multiples of the best of the same side; s. */
static const double hopeless_own = 10, hopeless_peer = 3, patience = 0.2;

typedef struct plan {
  int full, patient;
  const char *set, *method; /* NULL for all */
  const char *files;        /* the directory of FCLIB files */
  const char *directory;    /* for what is written */
  double limit;             /* s */
  report *out;
} plan;

/* ---- delassus -------------------------------------------------------------------------------- */

enum { pivoting_2d = 400, pivoting_3d = 60, any = 1 << 30 }; /* contacts */

static const own_method own[] = {
    {"auto", "auto", "none", .most = {any, any}, .setup = 1},
    {"nlgs-anderson", "nlgs", "anderson", .most = {any, any}, .setup = 1},
    {"newton", "newton", "none", .most = {any, any}, .setup = 1},
    {"admm", "admm", "none", .most = {any, any}, .setup = 1},
    {"nlgs", "nlgs", "none", .most = {any, any}, .setup = 1},
    {"augmented-lagrangian", "augmented-lagrangian", "none", .most = {any, any}, .setup = 1},
    {"lemke", "lemke", "none", .most = {pivoting_2d, pivoting_3d}, .setup = 1}};
enum { own_count = sizeof own / sizeof own[0] };

/* ---- one scene ------------------------------------------------------------------------------- */

/* Returns the CPU allowed for a target. */
static double allowance(const plan *p, const record *best, double hopeless) {
  if (p->patient || best->status != SOLVED) return p->limit;
  return fmin(p->limit, fmax(patience, hopeless * best->cpu));
}

static record record_of(solve_fn solve, const void *how, const outcome *o, double target,
                        double own_tol) {
  record a = {.solve = solve,
              .how = how,
              .target = target,
              .own_tol = own_tol,
              .residual = o->certificate.residual,
              .cpu = o->cpu,
              .setup = o->setup,
              .iterations = o->iterations};
  a.status = o->ended == REFUSED                                ? REFUSED_IT
             : o->ended == LIMIT                                ? OVER_LIMIT
             : o->ended == CRASH                                ? CRASHED
             : dls_certificate_holds(&o->certificate, a.target) ? SOLVED
             : o->claim && own_tol <= a.target                  ? WRONG
                                                                : UNSOLVED;
  return a;
}

/* Returns 1 if a comes before b as the answer of one solver: solved is better, faster is better,
 * and a wrong answer is remembered. */
static int replaces(const record *a, const record *b) {
  if (a->status == SOLVED) return b->status != SOLVED || a->cpu < b->cpu;
  return b->status != SOLVED && b->status != WRONG;
}

static void keep_faster(record *best, const record *a) {
  if (a->status == SOLVED && (best->status != SOLVED || a->cpu < best->cpu)) *best = *a;
}

/* The records that decide the ratios of a scene. */
typedef enum side { AUTO, OWN, PEER, SIDES } side;
typedef record leaders[SIDES][TARGETS];

static void run_own(const plan *p, const own_method *w, const scene *s, leaders best) {
  outcome o = {.ended = ENDED};
  double limit = 0;
  for (int k = 0; k < TARGETS; k++) {
    const double more = allowance(p, &best[OWN][k], hopeless_own);
    if (o.ended != LIMIT || more > limit) { /* else it would not get further either */
      limit = more;
      o = measure(s, own_solve, w, targets[k], limit);
    }
    record a = record_of(own_solve, w, &o, targets[k], targets[k]);
    a.method = w->name;
    a.setting = "default";
    a.storage = s->model || s->contact.W.a ? "dense" : "blocks";
    report_add(p->out, &a);
    keep_faster(&best[OWN][k], &a);
    if (strcmp(w->name, "auto") == 0) keep_faster(&best[AUTO][k], &a);
  }
}

/* Returns the tolerance (SO1) after `step` gave `residual`; target: the first that is not met. */
static double next_step(double step, double residual, double target, int met) {
  const double proportional = 10 * step * target / residual;
  return met && residual > target ? fmin(step / 10, proportional) : step / 10;
}

static void run_peer(const plan *p, const peer_method *w, const scene *s, leaders best) {
  record found[TARGETS] = {{.status = NOT_RUN}, {.status = NOT_RUN}, {.status = NOT_RUN}};
  int met = 0, failures = 0; /* targets met so far; runs that did not claim success */
  for (double step = first_step; step >= last_step && met < TARGETS && failures < 2;) {
    const double limit = allowance(p, &best[PEER][met], hopeless_peer);
    const outcome o = measure(s, peer_solve, w, step, limit);
    const int again = o.calls > 1; /* faster still on the same matrix and options? */
    const outcome same = again ? measure(s, peer_solve_again, w, step, limit) : o;
    for (int k = 0; k < TARGETS; k++) {
      const record a = record_of(peer_solve, w, &o, targets[k], step);
      const record b = record_of(peer_solve_again, w, &same, targets[k], step);
      if (replaces(&a, &found[k])) found[k] = a;
      if (again) keep_faster(&found[k], &b);
    }
    while (met < TARGETS && found[met].status == SOLVED)
      met++;
    if (o.ended != ENDED || peer_pivots(w)) break;
    if (!o.claim) failures++;
    if (met < TARGETS) step = next_step(step, o.certificate.residual, targets[met], met);
  }
  for (int k = 0; k < TARGETS; k++) {
    found[k].method = peer_name(w);
    found[k].setting = peer_setting(w);
    found[k].storage = peer_storage(w, s);
    found[k].peer = 1;
    report_add(p->out, &found[k]);
    keep_faster(&best[PEER][k], &found[k]);
  }
}

/* Returns 1 if auto is ahead of the best of the peer by more than noise. */
static int is_clear(const record *ours, const record *peer) {
  const double clear = 0.8;
  return ours->status != SOLVED || peer->status != SOLVED || ours->cpu < clear * peer->cpu;
}

static void take_turns(const plan *p, const scene *s, leaders best) {
  enum { least = 3, most = 20 };
  leaders first;
  for (int k = 0; k < TARGETS; k++) /* one solver, one turn */
    if (best[OWN][k].how == best[AUTO][k].how) best[OWN][k].status = NOT_RUN;
  memcpy(first, best, sizeof first);
  for (int round = 0; round < most; round++)
    for (int k = 0; k < TARGETS; k++) {
      if (round >= least && is_clear(&best[AUTO][k], &best[PEER][k])) continue;
      for (int i = 0; i < SIDES; i++) {
        record *a = &best[i][k];
        if (a->status != SOLVED) continue;
        const outcome o = measure(s, a->solve, a->how, a->own_tol, p->limit);
        const record b = record_of(a->solve, a->how, &o, a->target, a->own_tol);
        if (b.status != SOLVED || b.cpu >= a->cpu) continue;
        a->cpu = b.cpu;
        a->setup = b.setup;
      }
    }
  for (int k = 0; k < TARGETS; k++)
    for (int i = 0; i < SIDES; i++)
      if (best[i][k].cpu < first[i][k].cpu) report_add(p->out, &best[i][k]);
}

static int wanted(const plan *p, const char *method) {
  return !p->method || strcmp(p->method, method) == 0;
}

static void run_scene(void *data, const scene *s) {
  const plan *p = data;
  leaders best = {{{.status = NOT_RUN}}};
  report_scene(p->out, s);
  for (int k = 0; k < own_count; k++)
    if (wanted(p, own[k].name) && s->contact.nc <= own[k].most[s->contact.d == 3])
      run_own(p, &own[k], s, best);
  const peer_method *w;
  for (int k = 0; (w = peer_at(k)); k++)
    if (wanted(p, peer_name(w)) && peer_takes(w, s, p->patient)) run_peer(p, w, s, best);
  take_turns(p, s, best);
  report_progress(p->out);
}

/* ---- program --------------------------------------------------------------------------------- */

static int runs(const plan *p, const char *set) {
  return !p->set || strcmp(p->set, set) == 0;
}

/* Starts the program again with a BLAS of one thread, which OpenBLAS reads when it is loaded. */
static void one_thread(char **argv) {
  if (getenv("OPENBLAS_NUM_THREADS")) return;
  if (setenv("OPENBLAS_NUM_THREADS", "1", 1) == 0) (void)execv("/proc/self/exe", argv);
}

int main(int argc, char **argv) {
  one_thread(argv);
  if (!bench_options(argc, argv,
                     "[--full] [--patient] [--dir DIR] [--set SET] [--method NAME] "
                     "[--limit SECONDS] [--out DIR]"))
    return 2;
  plan p = {.full = bench_has(argc, argv, "--full"),
            .patient = bench_has(argc, argv, "--patient"),
            .files = bench_word(argc, argv, "--dir", "data/fclib"),
            .set = bench_word(argc, argv, "--set", NULL),
            .method = bench_word(argc, argv, "--method", NULL),
            .directory = bench_word(argc, argv, "--out", "bench/results")};
  p.limit = bench_number(argc, argv, "--limit", p.patient ? 20 : 3);
  p.out = report_open(p.directory, argc, argv);
  if (!p.out) return 1;
  int status = 0;
  if (runs(&p, "fclib")) status |= scenes_files(p.files, run_scene, &p);
  if (runs(&p, "block")) status |= scenes_blocks(p.full, run_scene, &p);
  if (runs(&p, "cube")) status |= scenes_cubes(p.full, run_scene, &p);
  if (runs(&p, "wall")) status |= scenes_walls(p.full, run_scene, &p);
  status |= report_close(p.out);
  if (status) fputs("solvers: not everything could be run\n", stderr);
  return status ? 1 : 0;
}
