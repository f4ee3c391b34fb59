/*
 * report_budget.c: how far mesh, steps and tolerance move the answer of a scene, and the cheapest
 * setting that is accurate enough (report.h).
 *
 *   1  run the scene as it is
 *   2  ladders: mesh by sqrt(2), an even one and one that is graded towards the fixed node or has
 *      tall elements, steps by 2, tolerance by 10: coarser ones, then finer ones until the limit
 *      of the ladder is estimated to a quarter of the accuracy, or its share of the CPU is gone
 *   3  reference := the closed form; else the limit of the mesh with the smaller doubt + what the
 *      limit of the steps adds
 *   4  predict the error of each (mesh, steps) as the sum of both envelopes: the largest error of
 *      a level and of all finer ones, so that no level passes by luck
 *   5  run those within the accuracy, the cheapest first, until one is within it as measured, the
 *      doubt of the reference added
 *   6  check at half the mesh size and twice the steps; beyond the accuracy go on with 5
 *   7  variants of the model at the scene's own setting: friction, weighting, penalty, mass
 *
 * The limit of a ladder is Richardson's with the doubt of the grid convergence index [Roache 1994],
 * 1.25 |limit - finest|, where three limits agree: those without the finest 0, 1 and 2 levels, the
 * orders of the first two within 0.3 and not below 0.5. Else it is the finest value, and the doubt
 * 3 times the largest difference over a factor 2 of the last levels.
 * Steps of a scene in time go with the mesh: their ratio to the element size stays.
 */
#include <math.h>
#include <stdlib.h>

#include "report.h"

/* Parts of the CPU limit: of the ladders of meshes, of tall ones, of steps, of tolerances. */
static const double mesh_share = 0.55, tall_share = 0.45, steps_share = 0.12, tol_share = 0.06;
static const double well_known = 0.25;      /* of the accuracy: a limit is not refined further */
static const double tol_part = 0.02;        /* of the accuracy that the tolerance may take, ... */
static const double steps_part = 0.1;       /* ... and the steps on the ladder of meshes */
static const double slow = 0.01, kept = 12; /* of the CPU: a slow scene; own runs for 7 */
static const double alike = 0.3, least_order = 0.5;  /* orders of a regular ladder */
static const double safe = 1.25, unsafe = 3;         /* factors of the grid convergence index */
static const double loosest_tol = 0.11;              /* a tenth, with its rounding */
static const double most_over = 2, most_part = 0.05; /* of what is foreseen; of the CPU: a level */
enum { MOST_LEVELS = 12, TIGHTER = 2 }; /* beyond a ladder, to extrapolate; digits of tol */

const char *const quantity_names[] = {"force", "curve", "pressure", "edge", "slip", "drift"};

/* ---- runs ------------------------------------------------------------------------------------ */

static double seconds_left(const budget *b) {
  return b->limit - (cpu_seconds() - b->start);
}

/* Runs the scene in so many CPU seconds, unless it has run so. Returns the probe; -1 if there is no
 * room or time. */
static int run_probe(budget *b, const setting *at, const char *part, double seconds,
                     dls_error *error) {
  for (int k = 0; k < b->probes; k++)
    if (setting_is(&b->probe[k].at, at)) return k;
  if (b->probes == MOST_PROBES || b->status || was_interrupted() || seconds <= 0) return -1;
  probe *p = &b->probe[b->probes];
  *p = (probe){.at = *at, .part = part};
  progress_part(part);
  b->status = scene_run(b->scene, at, seconds, &p->got, error);
  return b->status || was_interrupted() ? -1 : b->probes++;
}

/* ---- ladders --------------------------------------------------------------------------------- */

static int is_mesh(const budget *b, const ladder *l) {
  return l == &b->mesh || l == &b->second;
}

/* Returns the setting of these levels on the kind of mesh of a ladder. */
static setting on_mesh(const budget *b, const ladder *of, int mesh, int steps, int tol) {
  setting at = setting_scaled(b->scene, mesh, steps, tol);
  if (of != &b->second) return at;
  at.grade = b->scene->grade;
  at.nx *= 1 + b->scene->tall;
  at.ny = (at.ny + b->scene->tall) / (1 + b->scene->tall);
  return at;
}

static setting at_level(const budget *b, const ladder *l, int level) {
  return on_mesh(b, l, is_mesh(b, l) ? level : l->mesh, l == &b->steps ? level : l->steps,
                 l == &b->tol ? level : l->tol);
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

/* Runs the next level, below (up = 0) or above, in so many CPU seconds or a part of all; returns 0
 * if the ladder ends before it. */
static int ladder_run(budget *b, ladder *l, int up, double seconds, dls_error *error) {
  const int level = up ? l->high + 1 : l->low - 1;
  if (level < LOWEST || level > HIGHEST) return 0;
  const setting at = at_level(b, l, level), next = at_level(b, l, up ? l->high : l->low);
  if (setting_is(&at, &next) || at.tol > loosest_tol || (!up && is_mesh(b, l) && at.nx <= 2))
    return 0;
  const double most = fmax(seconds, most_part * b->limit);
  const int k = run_probe(b, &at, l->part, fmin(most, seconds_left(b)), error);
  if (k < 0 || !isfinite(b->probe[k].got.value)) return 0;
  l->run[level - LOWEST] = k;
  *(up ? &l->high : &l->low) = level;
  return 1;
}

/* Returns by how much the value changes over a factor 2 up to the level. */
static double change_to(const budget *b, const ladder *l, int level) {
  return ladder_value(b, l, level) - ladder_value(b, l, level - (is_mesh(b, l) ? 2 : 1));
}

/* Sets limit, order and doubt from the finest levels. */
static void ladder_settle(const budget *b, ladder *l) {
  const double finest = ladder_value(b, l, l->high);
  double limit[3], order[3], most = 0;
  int good = 1, up = 0, down = 0;
  for (int k = 0; k < 3; k++) {
    const double last = change_to(b, l, l->high - k);
    const double ratio = change_to(b, l, l->high - k - (is_mesh(b, l) ? 2 : 1)) / last;
    order[k] = log2(ratio); /* NaN: no order */
    limit[k] = ladder_value(b, l, l->high - k) + last / (ratio - 1);
    good = good && order[k] > least_order;
    if (k < 2 && fabs(last) > most) most = fabs(last);
  }
  for (int level = l->high; level > l->low && level > l->high - 4; level--) {
    const double step = ladder_value(b, l, level) - ladder_value(b, l, level - 1);
    up += step > 0;
    down += step < 0;
    most = fmax(most, fabs(step));
  }
  const double rest = safe * fabs(limit[0] - finest);
  good = good && fabs(order[0] - order[1]) < alike && fabs(limit[1] - limit[0]) <= rest &&
         fabs(limit[2] - limit[0]) <= rest;
  l->order = good ? order[0] : (double)NAN;
  l->limit = l->truth = good ? limit[0] : finest;
  l->doubt = (good ? rest : l->high > l->low ? unsafe * most : (double)INFINITY) / fabs(l->limit);
  l->monotone = !up || !down;
}

/* Returns the distance of two probes in a quantity; INFINITY without one of them. */
static double probes_apart(const budget *b, int one, int other, quantity_of of) {
  if (one < 0 || other < 0) return INFINITY;
  return answer_distance(&b->probe[one].got, &b->probe[other].got, of);
}

/* Returns the estimated error of a field of the finest level. */
static double field_doubt(const budget *b, const ladder *l, quantity_of of) {
  const int half = is_mesh(b, l) ? 2 : 1, last = ladder_probe(b, l, l->high);
  if (l->low > l->high || of == OF_DRIFT) return 0;
  return unsafe * fmax(probes_apart(b, ladder_probe(b, l, l->high - half), last, of),
                       probes_apart(b, ladder_probe(b, l, l->high - 1), last, of));
}

/* Returns the order by which a field of the last levels changes, between the least order and 1: at
 * a jump, as the pressure at the edge of contact, no field does better. */
static double field_order(const budget *b, const ladder *l, quantity_of of) {
  const int half = is_mesh(b, l) ? 2 : 1, middle = ladder_probe(b, l, l->high - half);
  const double before = probes_apart(b, ladder_probe(b, l, l->high - 2 * half), middle, of);
  const double order = log2(before / probes_apart(b, middle, ladder_probe(b, l, l->high), of));
  return order > least_order && isfinite(order) ? fmin(order, 1) : least_order;
}

/* Returns the largest estimated error of the fields that are asked. */
static double fields_doubt(const budget *b, const ladder *l) {
  double worst = 0;
  for (quantity_of of = OF_CURVE; of < OF_COUNT; of++)
    if (b->of >> of & 1) worst = fmax(worst, field_doubt(b, l, of));
  return worst;
}

/* Returns the largest error of a level and of all finer ones, relative to the ladder's limit;
 * INFINITY for a level without an answer. */
static double ladder_error(const budget *b, const ladder *l, int level) {
  if (l->low > l->high) return 0;
  /* steps that go with the mesh have their limit there */
  const int with_mesh = l == &b->steps && b->scene->dynamic;
  const double limit = with_mesh ? ladder_value(b, l, 0) : l->truth;
  double worst = ladder_probe(b, l, level) < 0 ? INFINITY : 0;
  for (int k = level; k <= (with_mesh ? 0 : l->high); k++) {
    const int last = ladder_probe(b, l, with_mesh ? 0 : l->high);
    const double value = ladder_value(b, l, k);
    if (!isfinite(value)) continue;
    if (b->of & 1 << OF_FORCE) worst = fmax(worst, fabs(value - limit) / fabs(limit));
    for (quantity_of of = OF_CURVE; of < OF_COUNT; of++)
      if (b->of >> of & 1) worst = fmax(worst, probes_apart(b, ladder_probe(b, l, k), last, of));
  }
  return worst;
}

/* Returns the cost of a level over that of the scene's own; beyond the ladder by its last ratio. */
static double ladder_cost(const budget *b, const ladder *l, int level) {
  if (l->low > l->high) return 1;
  const int last = level > l->high ? l->high : level;
  const double own = ladder_seconds(b, l, 0), seconds = ladder_seconds(b, l, last);
  const double before = ladder_seconds(b, l, last - 1);
  const double ratio = before > 0 ? fmax(1.1, seconds / before) : is_mesh(b, l) ? 2.5 : 2;
  return seconds / own * pow(ratio, level - last);
}

/* Returns 1 if the value of a level is within the accuracy of the closed form. */
static int beside_exact(const budget *b, const ladder *l, int level) {
  return fabs(ladder_value(b, l, level) / b->scene->exact - 1) <= b->accuracy;
}

/* Climbs down to the coarsest level and up to where the limit is known, in `part` of the CPU. */
static void ladder_climb(budget *b, ladder *l, double part, dls_error *error) {
  const double start = cpu_seconds(), share = part * b->limit;
  const setting own = at_level(b, l, 0), up = at_level(b, l, 1);
  l->low = 1;
  l->high = 0;
  l->limit = l->order = NAN;
  if (setting_is(&up, &own)) return; /* the scene has no such part */
  const int k0 = run_probe(b, &own, l->part, seconds_left(b), error);
  if (k0 < 0 || !isfinite(b->probe[k0].got.value)) return;
  l->low = 0;
  for (int k = 0; k < LEVELS; k++)
    l->run[k] = -1;
  l->run[-LOWEST] = k0;
  while (cpu_seconds() - start < share / 2 &&
         ladder_run(b, l, 0, most_over * ladder_seconds(b, l, l->low), error))
    ;
  for (;;) {
    ladder_settle(b, l);
    const double next = b->probe[k0].got.seconds * ladder_cost(b, l, l->high + 1);
    const double fields = fields_doubt(b, l);
    if (l->high >= (l == &b->tol ? 1 : 2) && fmax(l->doubt, fields) < well_known * b->accuracy)
      return;
    if (is_mesh(b, l) && l->high >= 2 && fields < well_known * b->accuracy &&
        beside_exact(b, l, l->high) && beside_exact(b, l, l->high - 1))
      return;
    if (l == &b->tol && l->high == 1) return;
    const double left = share - (cpu_seconds() - start);
    if (next > left || !ladder_run(b, l, 1, fmin(left, most_over * next), error)) return;
  }
}

/* ---- the search ------------------------------------------------------------------------------ */

double budget_error(const budget *b, int k, quantity_of of) {
  return of == OF_FORCE ? fabs(b->probe[k].got.value - b->reference) / fabs(b->reference)
                        : probes_apart(b, k, of == OF_DRIFT ? k : b->finest[of], of);
}

double budget_within(const budget *b, int k, quantity_of of) {
  const double error = budget_error(b, k, of) + b->doubt[of];
  return k == b->take && b->check >= 0 ? fmax(error, probes_apart(b, k, b->check, of)) : error;
}

quantity_of budget_worst(const budget *b, int k) {
  quantity_of worst = OF_COUNT;
  for (quantity_of of = OF_FORCE; of < OF_COUNT; of++)
    if (b->of >> of & 1 &&
        (worst == OF_COUNT || !(budget_within(b, k, of) <= budget_within(b, k, worst))))
      worst = of;
  return worst;
}

/* Returns the error of the worst of what is asked. */
static double asked_error(const budget *b, int k) {
  return budget_within(b, k, budget_worst(b, k));
}

/* Returns the largest doubt of what is asked. */
static double asked_doubt(const budget *b) {
  double worst = 0;
  for (quantity_of of = OF_FORCE; of < OF_COUNT; of++)
    if (b->of >> of & 1) worst = fmax(worst, b->doubt[of]);
  return worst;
}

/* Returns the kind of mesh whose limit is the less doubtful, of those that were run. */
static ladder *better_mesh(budget *b) {
  const ladder *m = &b->mesh, *g = &b->second;
  const int second = g->low <= g->high && (m->low > m->high || g->doubt < m->doubt);
  return second ? &b->second : &b->mesh;
}

/* A setting to try. */
typedef struct candidate {
  double seconds, error; /* as predicted; candidates are sorted by the first member */
  int mesh, steps;
  const ladder *of; /* the kind of mesh */
  int failed;       /* 1: it is not within the accuracy, as measured */
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
static double foreseen_seconds(const budget *b, const ladder *of, int mesh, int steps) {
  const double base = of->low > of->high
                          ? b->probe[b->own].got.seconds * ladder_cost(b, &b->steps, of->steps)
                          : ladder_seconds(b, of, 0);
  return base * ladder_cost(b, of, mesh) * ladder_cost(b, &b->steps, steps) /
         ladder_cost(b, &b->steps, of->steps);
}

static int list_candidates(budget *b, candidate *list) {
  const ladder *const meshes[] = {&b->mesh, &b->second}, *steps = &b->steps;
  int count = 0;
  for (int k = 0; k < 2; k++) {
    const ladder *of = meshes[k];
    if (of->low > of->high && better_mesh(b) != of) continue;
    for (int i = of->low > of->high ? 0 : of->low; i <= fmax(0, of->high); i++)
      for (int j = steps->low > steps->high ? 0 : steps->low; j <= fmax(0, steps->high); j++) {
        const double error = ladder_error(b, of, i) + ladder_error(b, steps, j);
        if (error + asked_doubt(b) <= b->accuracy)
          list[count++] = (candidate){foreseen_seconds(b, of, i, j), error, i, j, of, 0};
      }
  }
  qsort(list, (size_t)count, sizeof *list, ascending);
  return count;
}

/* Runs twice as fine a setting; returns its probe, -1 if there is no time for one. */
static int run_check(budget *b, const candidate *c, int tol, dls_error *error) {
  const int steps = b->scene->dynamic ? 0 : 1;
  for (int mesh = 2; mesh > 0; mesh--) {
    if (foreseen_seconds(b, c->of, c->mesh + mesh, c->steps + steps) > seconds_left(b)) continue;
    const setting at = on_mesh(b, c->of, c->mesh + mesh, c->steps + steps, tol + 1);
    return run_probe(b, &at, "check", seconds_left(b), error);
  }
  return -1;
}

/* Tries a candidate in half the CPU left, to a tolerance and, where that is too loose for so many
 * steps, to that of the ladders; returns 1 if it is within the accuracy and its check agrees. */
static int try_candidate(budget *b, const candidate *c, int tol, dls_error *error) {
  const setting at = on_mesh(b, c->of, c->mesh, c->steps, tol);
  const int k = run_probe(b, &at, "search", seconds_left(b) / 2, error);
  if (k < 0 || b->probe[k].got.status || !(asked_error(b, k) <= b->accuracy))
    return k >= 0 && tol < c->of->tol && try_candidate(b, c, c->of->tol, error);
  const int run = run_check(b, c, tol, error);
  const int check = run >= 0 && isfinite(b->probe[run].got.value) ? run : -1;
  double error_of = asked_error(b, k);
  for (quantity_of of = OF_FORCE; of < OF_COUNT && check >= 0; of++)
    if (b->of >> of & 1) error_of = fmax(error_of, probes_apart(b, k, check, of));
  if (b->take >= 0 && b->error <= error_of) return 0;
  b->take = k;
  b->check = check;
  b->error = error_of;
  return b->met = error_of <= b->accuracy;
}

/* Takes the finest level, unless what was tried is better, and finds by the order what would be
 * enough. */
static void take_the_best(budget *b) {
  const ladder *mesh = better_mesh(b), *of = mesh->low <= mesh->high ? mesh : &b->steps;
  int best = b->own;
  for (int level = of->low; level <= of->high; level++)
    if (ladder_probe(b, of, level) >= 0) best = ladder_probe(b, of, level);
  const double error = asked_error(b, best);
  if (b->take < 0 || !(b->error <= error)) {
    b->take = best;
    b->check = -1;
    b->error = error;
    b->met = error <= b->accuracy;
  }
  const quantity_of worst = budget_worst(b, b->take);
  const double order = b->enough_order = worst > OF_CURVE      ? field_order(b, of, worst)
                                         : isfinite(of->order) ? of->order
                                                               : least_order;
  const double factor = pow(2, is_mesh(b, of) ? -0.5 * order : -order);
  if (of->low > of->high || b->disagree || b->met) return;
  for (int more = 1; more <= MOST_LEVELS; more++) {
    const int level = of->high + more;
    if (b->error * pow(factor, more) > b->accuracy) continue;
    b->enough = at_level(b, of, level);
    b->enough_seconds = of == mesh ? foreseen_seconds(b, of, level, of->steps)
                                   : foreseen_seconds(b, mesh, 0, level);
    return;
  }
}

/* ---- all ------------------------------------------------------------------------------------- */

static void run_variants(budget *b, dls_error *error) {
  setting at;
  const char *name;
  for (int k = 0; (name = setting_variant(b->scene, k, &at)); k++)
    if (*name && b->probe[b->own].got.seconds < seconds_left(b))
      (void)run_probe(b, &at, name, seconds_left(b), error);
}

/* The closed form; else the limit of the mesh with the smaller doubt, which both meshes have in
 * common, and what the limit of the steps adds. */
static void make_reference(budget *b) {
  ladder *m = &b->mesh, *g = &b->second;
  const double own = b->probe[b->own].got.value;
  const int two = m->low <= m->high && g->low <= g->high;
  const ladder *best = better_mesh(b);
  b->reference = isfinite(best->limit) ? best->limit : own;
  double doubt = isfinite(best->limit) ? best->doubt : 0;
  /* grading that raises the order shows an edge that the even mesh does not resolve */
  b->disagree = two && !(g->order > m->order + alike) &&
                !(fabs(g->limit / m->limit - 1) <= g->doubt + m->doubt);
  if (b->disagree) doubt = fabs(g->limit / m->limit - 1);
  for (quantity_of of = OF_CURVE; of < OF_COUNT; of++) {
    const ladder *last = best;
    if (two) last = field_doubt(b, g, of) < field_doubt(b, m, of) ? g : m;
    if (last->low > last->high) last = &b->steps;
    b->finest[of] = last->low <= last->high ? ladder_probe(b, last, last->high) : b->own;
    b->doubt[of] = field_doubt(b, last, of);
    const double two_apart =
        two ? probes_apart(b, ladder_probe(b, m, m->high), ladder_probe(b, g, g->high), of) : 0;
    if (two_apart > field_doubt(b, m, of) + field_doubt(b, g, of)) b->doubt[of] = two_apart;
    if (!b->scene->dynamic && last != &b->steps) b->doubt[of] += field_doubt(b, &b->steps, of);
  }
  if (isfinite(b->scene->exact)) b->reference = b->scene->exact;
  b->doubt[OF_FORCE] = isfinite(b->scene->exact) ? 0 : doubt;
  m->truth = g->truth = b->reference;
  if (b->scene->dynamic || !isfinite(b->steps.limit)) return;
  b->reference +=
      b->steps.limit - (isfinite(best->limit) ? ladder_value(b, &b->steps, m->steps) : own);
  b->doubt[OF_FORCE] += b->steps.doubt;
}

/* Climbs all ladders: that of the meshes, the most costly one, with as many steps and as tight a
 * tolerance as the other two ask for; and makes the reference. */
static void measure(budget *b, dls_error *error) {
  const probe *own = &b->probe[b->own];
  b->steps.part = "steps";
  ladder_climb(b, &b->steps, own->at.nx ? steps_share : mesh_share, error);
  b->tol.part = "tolerance";
  b->tol.steps = b->mesh.steps = b->scene->dynamic ? 0 : coarsest(b, &b->steps, steps_part);
  b->tol.mesh = own->got.seconds > slow * b->limit ? -2 : 0;
  ladder_climb(b, &b->tol, tol_share, error);
  b->mesh.part = "mesh";
  b->mesh.tol = (int)fmin(choose_tol(b) + TIGHTER, 0); /* a fine mesh asks for more */
  b->second = b->mesh;
  b->second.part = b->scene->tall ? "mesh of tall elements" : "graded mesh";
  b->second.low = 1; /* not run */
  const double second = b->scene->tall ? tall_share : b->scene->grade > 0 ? mesh_share / 2 : 0;
  if (second > 0) ladder_climb(b, &b->second, second, error);
  ladder_climb(b, &b->mesh, mesh_share - second, error);
  make_reference(b);
  ladder *l = better_mesh(b); /* goes on while the doubt alone is more than the accuracy */
  while (asked_doubt(b) > b->accuracy &&
         kept * own->got.seconds + foreseen_seconds(b, l, l->high + 1, 0) < seconds_left(b) &&
         ladder_run(b, l, 1, most_over * foreseen_seconds(b, l, l->high + 1, 0), error))
    ladder_settle(b, l), make_reference(b);
}

dls_status budget_run(budget *b, dls_error *error) {
  b->start = cpu_seconds();
  b->take = b->check = -1;
  if (!b->of) b->of = 1 << OF_FORCE | 1 << OF_CURVE;
  /* momentum gives the impulse at the end for nothing: its curve chooses the mesh */
  if (b->scene->dynamic && b->of & 1 << OF_FORCE) b->of |= 1 << OF_CURVE;
  b->of &= b->scene->has;
  b->reference = b->error = b->enough_seconds = NAN;
  b->own = run_probe(b, &b->scene->own, "own", seconds_left(b), error);
  if (b->own < 0) return b->status;
  measure(b, error);
  static candidate list[2 * LEVELS * LEVELS];
  const int count = list_candidates(b, list), tol = choose_tol(b);
  for (int k = 0; k < count && !b->met && list[k].seconds < seconds_left(b); k++) {
    int coarser = 0; /* than one that has failed */
    for (int i = 0; i < k && !coarser; i++)
      coarser = list[i].failed && list[k].of == list[i].of && list[k].mesh <= list[i].mesh &&
                list[k].steps <= list[i].steps;
    list[k].failed = !coarser && !try_candidate(b, &list[k], tol, error);
  }
  if (!b->met) take_the_best(b);
  run_variants(b, error);
  return b->status;
}
