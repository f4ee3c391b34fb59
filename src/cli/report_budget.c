/*
 * report_budget.c: how far mesh, steps and tolerance move the answer of a scene, and the cheapest
 * setting that is accurate enough (report.h).
 *
 *   1  run the scene as it is
 *   2  ladders: mesh by sqrt(2), steps by 2, tolerance by 10: coarser ones, then finer ones
 *      until the limit of the ladder is known to a 20th of the accuracy, or its share of the CPU
 *      is gone
 *   3  reference := the limit of the mesh + what the limit of the steps adds
 *   4  predict the error of each (mesh, steps) as the sum of both envelopes: the largest error of
 *      a level and of all finer ones, so that no level passes by luck
 *   5  run those within the accuracy, the cheapest first, until one is within it as measured
 *   6  check: run half the mesh size and twice the steps; where the answers differ by more than the
 *      accuracy, go on with 5
 *   7  variants of the model at the scene's own setting: friction, weighting, penalty, mass
 *
 * The limit of a ladder is Richardson's where the last three values contract; else the mean of the
 * last three. Steps of a scene in time go with the mesh: their ratio to the element size stays.
 */
#include <math.h>
#include <stdlib.h>

#include "report.h"

/* Parts of the CPU limit: of a ladder of meshes, of steps, of tolerances; of one candidate. */
static const double mesh_share = 0.55, steps_share = 0.12, tol_share = 0.06;
static const double well_known = 0.05;  /* of the accuracy: a limit is not refined further */
static const double doubted = 0.25;     /* of the accuracy that is left to doubt, at most */
static const double tol_part = 0.02;    /* of the accuracy that the tolerance may take, ... */
static const double steps_part = 0.1;   /* ... and the steps on the ladder of meshes */
static const double slow = 0.01;        /* of the CPU: such a scene tries tolerances coarsely */
static const double contracts = 1.15;   /* least ratio of differences of a regular ladder */
static const double loosest_tol = 0.11; /* a tenth, with its rounding */
enum { MOST_LEVELS = 12, TIGHTER = 2 }; /* beyond a ladder, to extrapolate; digits of tol */

/* ---- runs ------------------------------------------------------------------------------------ */

static double seconds_left(const budget *b) {
  return b->limit - (cpu_seconds() - b->start);
}

/* Runs the scene, unless it has run so. Returns the probe; -1 if there is no room or time. */
static int run_probe(budget *b, const setting *at, const char *part, dls_error *error) {
  for (int k = 0; k < b->probes; k++)
    if (setting_is(&b->probe[k].at, at)) return k;
  if (b->probes == MOST_PROBES || b->status || was_interrupted() || seconds_left(b) <= 0) return -1;
  probe *p = &b->probe[b->probes];
  *p = (probe){.at = *at, .part = part};
  b->status = scene_run(b->scene, at, seconds_left(b), &p->got, error);
  return b->status || was_interrupted() ? -1 : b->probes++;
}

/* ---- ladders --------------------------------------------------------------------------------- */

static setting at_level(const budget *b, const ladder *l, int level) {
  return setting_scaled(b->scene, l == &b->mesh ? level : l->mesh,
                        l == &b->steps ? level : l->steps, l == &b->tol ? level : l->tol);
}

int ladder_probe(const budget *b, const ladder *l, int level) {
  if (level < l->low || level > l->high) return -1;
  const int k = l->run[level - LOWEST];
  return k >= 0 && isfinite(b->probe[k].got.value) ? k : -1;
}

static double ladder_value(const budget *b, const ladder *l, int level) {
  const int k = ladder_probe(b, l, level);
  return k < 0 ? (double)NAN : b->probe[k].got.value;
}

static double ladder_seconds(const budget *b, const ladder *l, int level) {
  const int k = ladder_probe(b, l, level);
  return k < 0 ? (double)NAN : b->probe[k].got.seconds;
}

/* Runs the next level, below (up = 0) or above; returns 0 if the ladder ends there. */
static int ladder_run(budget *b, ladder *l, int up, dls_error *error) {
  const int level = up ? l->high + 1 : l->low - 1;
  if (level < LOWEST || level > HIGHEST) return 0;
  const setting at = at_level(b, l, level), next = at_level(b, l, up ? l->high : l->low);
  if (setting_is(&at, &next) || at.tol > loosest_tol || (!up && l == &b->mesh && at.nx <= 2))
    return 0;
  const int k = run_probe(b, &at, l->part, error);
  if (k < 0) return 0;
  l->run[level - LOWEST] = k;
  *(up ? &l->high : &l->low) = level;
  return b->probe[k].got.status == DLS_OK;
}

/* Finds the limit of three values, the finest last, and the order; returns 0 if they do not
 * contract. factor: of the size between them. */
static int richardson(const double v[3], double factor, double *limit, double *order) {
  const double d1 = v[1] - v[0], d2 = v[2] - v[1], ratio = d1 / d2;
  if (!(ratio > contracts)) return 0; /* NaN, too */
  *order = log(ratio) / log(factor);
  *limit = v[2] + d2 / (ratio - 1);
  return 1;
}

/* Sets limit, order and doubt from the finest levels. */
static void ladder_settle(const budget *b, ladder *l) {
  const int apart = l == &b->mesh ? 2 : 1; /* levels of a factor 2 */
  double v[3], limit[2], order;
  int good = 1;
  for (int back = 0; back < 2 && good; back++) {
    for (int i = 0; i < 3; i++)
      v[2 - i] = ladder_value(b, l, l->high - back - apart * i);
    good = richardson(v, 2, &limit[back], back ? &order : &l->order);
  }
  if (good) {
    const double last = fabs(limit[0] - ladder_value(b, l, l->high));
    l->limit = limit[0];
    l->doubt = fmax(fabs(limit[0] - limit[1]), 0.1 * last) / fabs(limit[0]);
    return;
  }
  double lo = INFINITY, hi = -INFINITY, sum = 0;
  int count = 0;
  for (int level = l->high; level >= l->low && count < 3; level--) {
    const double value = ladder_value(b, l, level);
    if (!isfinite(value)) continue;
    lo = fmin(lo, value);
    hi = fmax(hi, value);
    sum += value;
    count++;
  }
  l->order = NAN;
  l->limit = count ? sum / count : (double)NAN;
  l->doubt = count > 1 ? (hi - lo) / 2 / fabs(l->limit) : count ? 0 : (double)INFINITY;
}

/* Returns the largest error of a level and of all finer ones, relative to the ladder's limit;
 * INFINITY for a level without an answer. */
static double ladder_error(const budget *b, const ladder *l, int level) {
  if (l->low > l->high) return 0;
  /* steps that go with the mesh have their limit there */
  const int with_mesh = l == &b->steps && b->scene->dynamic;
  const double limit = with_mesh ? ladder_value(b, l, 0) : l->limit;
  double worst = ladder_probe(b, l, level) < 0 ? INFINITY : 0;
  for (int k = level; k <= (with_mesh ? 0 : l->high); k++) {
    const double value = ladder_value(b, l, k);
    if (isfinite(value)) worst = fmax(worst, fabs(value - limit) / fabs(limit));
  }
  return worst;
}

/* Returns the cost of a level over that of the scene's own; beyond the ladder by its last ratio. */
static double ladder_cost(const budget *b, const ladder *l, int level) {
  if (l->low > l->high) return 1;
  const int last = level > l->high ? l->high : level;
  const double own = ladder_seconds(b, l, 0), seconds = ladder_seconds(b, l, last);
  const double before = ladder_seconds(b, l, last - 1);
  const double ratio = before > 0 ? fmax(1.1, seconds / before) : l == &b->mesh ? 2.5 : 2;
  return seconds / own * pow(ratio, level - last);
}

/* Climbs down to the coarsest level and up to where the limit is known, in `part` of the CPU. */
static void ladder_climb(budget *b, ladder *l, double part, dls_error *error) {
  const double start = cpu_seconds(), share = part * b->limit;
  const setting own = at_level(b, l, 0), up = at_level(b, l, 1);
  l->low = 1;
  l->high = 0;
  l->limit = l->order = NAN;
  if (setting_is(&up, &own)) return; /* the scene has no such part */
  const int k0 = run_probe(b, &own, l->part, error);
  if (k0 < 0) return;
  l->low = 0;
  for (int k = 0; k < LEVELS; k++)
    l->run[k] = -1;
  l->run[-LOWEST] = k0;
  while (cpu_seconds() - start < share / 2 && ladder_run(b, l, 0, error))
    ;
  for (;;) {
    ladder_settle(b, l);
    const double next = b->probe[k0].got.seconds * ladder_cost(b, l, l->high + 1);
    if (l->high >= (l == &b->tol ? 1 : 2) && l->doubt < well_known * b->accuracy) return;
    if (l == &b->tol && l->high == 1) return;
    if (cpu_seconds() - start + next > share || !ladder_run(b, l, 1, error)) return;
  }
}

/* ---- the search ------------------------------------------------------------------------------ */

double budget_error(const budget *b, int k) {
  return fabs(b->probe[k].got.value - b->reference) / fabs(b->reference);
}

/* Returns the error beside the reference that is within the accuracy. */
static double within(const budget *b) {
  return b->accuracy - fmin(b->doubt, doubted * b->accuracy);
}

/* A setting to try. */
typedef struct candidate {
  double seconds, error; /* as predicted; candidates are sorted by the first member */
  int mesh, steps;
  int failed; /* 1: it is not within the accuracy, as measured */
} candidate;

/* Returns the coarsest level, at most 0, whose error is below `part` of the accuracy. */
static int coarsest(const budget *b, const ladder *l, double part) {
  int level = 0;
  while (level > l->low && ladder_error(b, l, level - 1) < part * b->accuracy)
    level--;
  return level;
}

/* Returns the level of the tolerance to take: one tighter than the loosest that is good enough. */
static int choose_tol(const budget *b) {
  return coarsest(b, &b->tol, tol_part) < 0 ? coarsest(b, &b->tol, tol_part) + 1 : 0;
}

/* Returns what a setting would cost. */
static double foreseen_seconds(const budget *b, int mesh, int steps) {
  const double base = b->mesh.low > b->mesh.high
                          ? b->probe[b->own].got.seconds * ladder_cost(b, &b->steps, b->mesh.steps)
                          : ladder_seconds(b, &b->mesh, 0);
  return base * ladder_cost(b, &b->mesh, mesh) * ladder_cost(b, &b->steps, steps) /
         ladder_cost(b, &b->steps, b->mesh.steps);
}

static int list_candidates(const budget *b, candidate *list) {
  int count = 0;
  for (int i = b->mesh.low > b->mesh.high ? 0 : b->mesh.low; i <= fmax(0, b->mesh.high); i++)
    for (int j = b->steps.low > b->steps.high ? 0 : b->steps.low; j <= fmax(0, b->steps.high);
         j++) {
      const double error = ladder_error(b, &b->mesh, i) + ladder_error(b, &b->steps, j);
      if (error <= b->accuracy)
        list[count++] = (candidate){foreseen_seconds(b, i, j), error, i, j, 0};
    }
  qsort(list, (size_t)count, sizeof *list, ascending);
  return count;
}

/* Runs twice as fine a setting; returns its probe, -1 if there is no time for one. */
static int run_check(budget *b, const candidate *c, int tol, dls_error *error) {
  const int steps = b->scene->dynamic ? 0 : 1;
  for (int mesh = 2; mesh > 0; mesh--) {
    if (foreseen_seconds(b, c->mesh + mesh, c->steps + steps) > seconds_left(b)) continue;
    const setting at = setting_scaled(b->scene, c->mesh + mesh, c->steps + steps, tol + 1);
    return run_probe(b, &at, "check", error);
  }
  return -1;
}

/* Tries a candidate; returns 1 if it is within the accuracy and its check agrees. */
static int try_candidate(budget *b, const candidate *c, int tol, dls_error *error) {
  const setting at = setting_scaled(b->scene, c->mesh, c->steps, tol);
  const int k = run_probe(b, &at, "search", error);
  if (k < 0 || b->probe[k].got.status || budget_error(b, k) > within(b)) return 0;
  const int run = run_check(b, c, tol, error);
  const int check = run >= 0 && isfinite(b->probe[run].got.value) ? run : -1;
  /* without a check run the doubt of the reference stands for it */
  const double other = check < 0 ? budget_error(b, k) + b->doubt
                                 : fabs(b->probe[k].got.value / b->probe[check].got.value - 1);
  const double error_of = fmax(budget_error(b, k), other);
  if (b->take >= 0 && b->error <= error_of) return 0;
  b->take = k;
  b->check = check;
  b->error = error_of;
  return b->met = error_of <= b->accuracy;
}

/* Takes the finest mesh, unless what was tried is better, and finds by the order of the mesh what
 * would be enough. */
static void take_the_best(budget *b) {
  int best = b->own;
  for (int level = b->mesh.low; level <= b->mesh.high; level++)
    if (ladder_probe(b, &b->mesh, level) >= 0) best = ladder_probe(b, &b->mesh, level);
  const double error = fmax(budget_error(b, best), b->doubt);
  if (b->take < 0 || !(b->error <= error)) {
    b->take = best;
    b->check = -1;
    b->error = error;
  }
  const double finest = ladder_error(b, &b->mesh, b->mesh.high);
  if (!isfinite(b->mesh.order) || !isfinite(finest)) return;
  const double rest = ladder_error(b, &b->steps, b->mesh.steps);
  for (int more = 1; more <= MOST_LEVELS; more++) {
    if (finest * pow(2, -0.5 * more * b->mesh.order) + rest > within(b)) continue;
    b->enough = setting_scaled(b->scene, b->mesh.high + more, b->mesh.steps, b->mesh.tol);
    b->enough_seconds = foreseen_seconds(b, b->mesh.high + more, b->mesh.steps);
    return;
  }
}

/* ---- all ------------------------------------------------------------------------------------- */

static void run_variants(budget *b, dls_error *error) {
  setting at;
  const char *name;
  for (int k = 0; (name = setting_variant(b->scene, k, &at)); k++)
    if (*name && b->probe[b->own].got.seconds < seconds_left(b))
      (void)run_probe(b, &at, name, error);
}

/* Climbs all ladders: that of the meshes, the most costly one, with as many steps and as tight a
 * tolerance as the other two ask for; and makes the reference. */
static void measure(budget *b, dls_error *error) {
  const probe *own = &b->probe[b->own];
  b->steps.part = "steps";
  ladder_climb(b, &b->steps, steps_share, error);
  b->tol.part = "tolerance";
  b->tol.steps = b->mesh.steps = b->scene->dynamic ? 0 : coarsest(b, &b->steps, steps_part);
  b->tol.mesh = own->got.seconds > slow * b->limit ? -2 : 0;
  ladder_climb(b, &b->tol, tol_share, error);
  b->mesh.part = "mesh";
  b->mesh.tol = (int)fmin(choose_tol(b) + TIGHTER, 0); /* a fine mesh asks for more */
  ladder_climb(b, &b->mesh, mesh_share, error);
  b->reference = isfinite(b->mesh.limit) ? b->mesh.limit : own->got.value;
  b->doubt = isfinite(b->mesh.limit) ? b->mesh.doubt : 0;
  if (b->scene->dynamic || !isfinite(b->steps.limit)) return;
  b->reference +=
      b->steps.limit -
      (isfinite(b->mesh.limit) ? ladder_value(b, &b->steps, b->mesh.steps) : own->got.value);
  b->doubt += b->steps.doubt;
}

dls_status budget_run(budget *b, dls_error *error) {
  b->start = cpu_seconds();
  b->take = b->check = -1;
  b->reference = b->doubt = b->error = b->enough_seconds = NAN;
  b->own = run_probe(b, &b->scene->own, "own", error);
  if (b->own < 0) return b->status;
  measure(b, error);
  static candidate list[LEVELS * LEVELS];
  const int count = list_candidates(b, list), tol = choose_tol(b);
  for (int k = 0; k < count && !b->met && list[k].seconds < seconds_left(b); k++) {
    int coarser = 0; /* than one that has failed */
    for (int i = 0; i < k && !coarser; i++)
      coarser = list[i].failed && list[k].mesh <= list[i].mesh && list[k].steps <= list[i].steps;
    list[k].failed = !coarser && !try_candidate(b, &list[k], tol, error);
  }
  if (!b->met) take_the_best(b);
  run_variants(b, error);
  return b->status;
}
