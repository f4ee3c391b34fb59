/* hard_report.c: the tables of bench/hard, and the lines on top of them. */
#include <math.h>
#include <string.h>

#include "common.h"
#include "hard.h"

static const hard_row *rows;
static int row_count;

/* What to count: -1, NAN: any. most: contacts. */
typedef struct hard_pick {
  int method, flaw, nc, most;
  double condition, mu;
} hard_pick;

static const hard_pick any = {-1, -1, -1, 30, NAN, NAN};

/* Returns 1 for a problem of the grid that is run with 100 contacts, too. */
static int is_coarse(const hard_row *r) {
  return r->seed == 2 && (r->condition == 1 || r->condition == 1e4 || r->condition == 1e8) &&
         (r->mu == 0 || r->mu == 1 || r->mu == 5);
}

/* With a size given: of the problems that are run with 100 contacts, too. */
static int fits(const hard_row *r, const hard_pick *p) {
  if (p->nc >= 0 && !is_coarse(r)) return 0;
  return (p->method < 0 || r->method == p->method) && (p->flaw < 0 || (int)r->flaw == p->flaw) &&
         (p->nc < 0 ? r->nc <= p->most : r->nc == p->nc) &&
         (isnan(p->condition) || r->condition == p->condition) && (isnan(p->mu) || r->mu == p->mu);
}

static int count_of(hard_pick p, hard_end end) {
  int n = 0;
  for (int k = 0; k < row_count; k++)
    n += fits(&rows[k], &p) && rows[k].end == end;
  return n;
}

/* Per cent solved of the runs that the method takes; NAN if there is none. */
static double solved(hard_pick p) {
  int all = 0;
  for (int k = 0; k < row_count; k++)
    all += fits(&rows[k], &p) && rows[k].end != HARD_REFUSED;
  return all ? 100. * count_of(p, HARD_SOLVED) / all : NAN;
}

static int method_of(const char *name) {
  int k = 0;
  while (hard_method_name(k) && strcmp(hard_method_name(k), name) != 0)
    k++;
  return k;
}

static hard_pick of(const char *method) {
  hard_pick p = any;
  p.method = method_of(method);
  return p;
}
static hard_pick with_condition(hard_pick p, double condition) {
  p.condition = condition;
  return p;
}
static hard_pick with_mu(hard_pick p, double mu) {
  p.mu = mu;
  return p;
}
static hard_pick with_flaw(hard_pick p, planted_flaw flaw) {
  p.flaw = (int)flaw;
  return p;
}
static hard_pick with_size(hard_pick p, int nc) {
  p.nc = nc;
  return p;
}

static void hard_cell(FILE *page, double share) {
  if (isnan(share))
    bench_print(page, " |");
  else
    bench_print(page, " %.0f |", share);
}

/* Returns 1 if row r has a solved twin by another method. */
static int others_solve(const hard_row *r) {
  for (int k = 0; k < row_count; k++) {
    const hard_row *o = &rows[k];
    if (o->nc == r->nc && o->flaw == r->flaw && o->condition == r->condition && o->mu == r->mu &&
        o->seed == r->seed && o->end == HARD_SOLVED)
      return 1;
  }
  return 0;
}

static void report_endings(FILE *page) {
  bench_print(page,
              "\n## Endings\n\nProblems with 10 and 30 contacts: 5 conditionings x 5 frictions "
              "x 4 degeneracies x 2 seeds each.\n\n| method |");
  for (int e = 0; e < HARD_ENDS; e++)
    bench_print(page, " %s |", hard_end_name((hard_end)e));
  bench_print(page, "\n|---|---|---|---|---|---|---|---|\n");
  for (int k = 0; hard_method_name(k); k++) {
    bench_print(page, "| %s |", hard_method_name(k));
    for (int e = 0; e < HARD_ENDS; e++)
      bench_print(page, " %d |", count_of(of(hard_method_name(k)), (hard_end)e));
    bench_print(page, "\n");
  }
}

static void report_shares(FILE *page) {
  static const double conditions[] = {1, 1e4, 1e8}, frictions[] = {0, 1, 5};
  bench_print(page,
              "\n## Per cent solved\n\nOf the same problems, those that a method takes; by size: "
              "of the grid of 100 contacts (conditions 1, 1e4, 1e8, frictions 0, 1, 5, one seed);\n"
              "300 and 1000 contacts: full rank alone, 1000 without condition 1e4 and friction 1.\n"
              "\n| method | condition 1 | 1e4 | 1e8 | friction 0 | 1 | 5 |");
  for (int f = 0; f < FLAWS; f++)
    bench_print(page, " %s |", hard_flaw_name((planted_flaw)f));
  bench_print(page, " 10 contacts | 30 | 100 | 300 | 1000 |\n|---|");
  for (int k = 0; k < 15; k++)
    bench_print(page, "---|");
  bench_print(page, "\n");
  for (int k = 0; hard_method_name(k); k++) {
    const hard_pick p = of(hard_method_name(k));
    bench_print(page, "| %s |", hard_method_name(k));
    for (int i = 0; i < 3; i++)
      hard_cell(page, solved(with_condition(p, conditions[i])));
    for (int i = 0; i < 3; i++)
      hard_cell(page, solved(with_mu(p, frictions[i])));
    for (int f = 0; f < FLAWS; f++)
      hard_cell(page, solved(with_flaw(p, (planted_flaw)f)));
    static const int sizes[] = {10, 30, 100, 300, 1000};
    for (int i = 0; i < 5; i++)
      hard_cell(page, solved(with_size(p, sizes[i])));
    bench_print(page, "\n");
  }
}

static void report_open(FILE *page) {
  int open = 0;
  bench_print(
      page,
      "\n## What auto does not solve\n\n`build/bench/hard --one DEGENERACY CONTACTS CONDITION "
      "FRICTION SEED SECONDS` runs one of them by every method. Seconds: of the second try.\nHere: "
      "up to 30 contacts, and what another method solves; the screen has all.\n\n| problem | auto "
      "| s | another method solves it |\n|---|---|---|---|\n");
  for (int k = 0; k < row_count; k++) {
    const hard_row *r = &rows[k];
    if (r->method || r->end == HARD_SOLVED) continue;
    const int others = others_solve(r);
    open++;
    bench_print(r->nc <= 30 || others ? page : NULL, "| %s %d %.0e %g %d | %s | %.2g | %s |\n",
                hard_flaw_name(r->flaw), r->nc, r->condition, r->mu, r->seed, hard_end_name(r->end),
                r->cpu, others ? "yes" : "no");
  }
  bench_print(page, "\nAll sizes: %d.\n", open);
}

/* Runs of sweeps, four methods, that ended so. */
static int of_sweeps(hard_end end) {
  static const char *const sweeps[] = {"nlgs", "nlgs+aitken", "nlgs+anderson", "nlgs+momentum"};
  int n = 0;
  for (int k = 0; k < 4; k++)
    n += count_of(of(sweeps[k]), end);
  return n;
}

static void report_lines(FILE *page) {
  const hard_pick automatic = of("auto"), nlgs = of("nlgs"), newton = of("newton");
  const hard_pick admm = of("admm"), augmented = of("augmented-lagrangian");
  const hard_pick homotopy = of("homotopy"), lemke = of("lemke"), anderson = of("nlgs+anderson");
  bench_print(page, "## What one learns\n\n");
  bench_print(page,
              "1. Take auto: it solves %d of the %d problems with 10 and 30 contacts; on the other "
              "%d it meets the limit of CPU, which is no verdict.\n",
              count_of(automatic, HARD_SOLVED),
              count_of(automatic, HARD_SOLVED) + count_of(automatic, HARD_UNDECIDED) +
                  count_of(automatic, HARD_STUCK) + count_of(automatic, HARD_WRONG),
              count_of(automatic, HARD_UNDECIDED));
  bench_print(page,
              "2. Friction and conditioning are hard together, not alone: at condition 1 sweeps "
              "solve %.0f %%, at friction 0 %.0f %%, at condition 1e8 and friction 5 %.0f %%.\n",
              solved(with_condition(nlgs, 1)), solved(with_mu(nlgs, 0)),
              solved(with_mu(with_condition(nlgs, 1e8), 5)));
  bench_print(
      page,
      "3. Sweeps fail with conditioning: %.0f %% are solved at 1e4, %.0f %% at 1e8 (plain), "
      "%.0f %% and %.0f %% with Anderson's acceleration. Aitken's and momentum gain less.\n",
      solved(with_condition(nlgs, 1e4)), solved(with_condition(nlgs, 1e8)),
      solved(with_condition(anderson, 1e4)), solved(with_condition(anderson, 1e8)));
  bench_print(page,
              "4. Where sweeps fail, %d runs cycle and %d make no progress: more sweeps do not "
              "help. %d met the limit while the residual fell.\n",
              of_sweeps(HARD_CYCLE), of_sweeps(HARD_STUCK), of_sweeps(HARD_UNDECIDED));
  bench_print(page,
              "5. Newton's method fails with friction: %.0f %% are solved at 0.3, %.0f %% at 1, "
              "%.0f %% at 5; and it fails at once, so that a try costs little.\n",
              solved(with_mu(newton, 0.3)), solved(with_mu(newton, 1)), solved(with_mu(newton, 5)));
  bench_print(page,
              "6. ADMM and the augmented Lagrangian hardly mind conditioning: %.0f %% and %.0f %% "
              "at 1e8, where Newton's method solves %.0f %%. Friction 5 leaves them %.0f %% and "
              "%.0f %%.\n",
              solved(with_condition(admm, 1e8)), solved(with_condition(augmented, 1e8)),
              solved(with_condition(newton, 1e8)), solved(with_mu(admm, 5)),
              solved(with_mu(augmented, 5)));
  bench_print(page,
              "7. The homotopy solves %d of the %d problems that it takes (no bonded contacts), "
              "more than any other single method; with 100 contacts %.0f %%.\n",
              count_of(homotopy, HARD_SOLVED),
              count_of(homotopy, HARD_SOLVED) + count_of(homotopy, HARD_STUCK) +
                  count_of(homotopy, HARD_UNDECIDED),
              solved(with_size(homotopy, 100)));
  bench_print(page,
              "8. Lemke's method on facets starts Newton's method well up to friction 1 (%.0f %%), "
              "badly at 5 (%.0f %%). %d runs ended in a ray, and none reports that there is no "
              "solution, which would be wrong here: %d.\n",
              solved(with_mu(lemke, 1)), solved(with_mu(lemke, 5)), count_of(any, HARD_RAY),
              count_of(any, HARD_WRONG));
  bench_print(page,
              "9. Half rank is the worst degeneracy for sweeps and Newton's method (%.0f %% and "
              "%.0f %%), half bonded for the augmented Lagrangian (%.0f %%). On the border of "
              "states nlgs solves %.0f %%, at full rank %.0f %%.\n",
              solved(with_flaw(nlgs, FLAW_RANK)), solved(with_flaw(newton, FLAW_RANK)),
              solved(with_flaw(augmented, FLAW_BONDED)), solved(with_flaw(nlgs, FLAW_BORDER)),
              solved(with_flaw(nlgs, FLAW_NONE)));
  bench_print(page,
              "10. Size makes it worse: of the problems that are run with 10, 30 and 100 contacts "
              "auto solves %.0f, %.0f and %.0f %%, nlgs %.0f, %.0f and %.0f %%.\n\n",
              solved(with_size(automatic, 10)), solved(with_size(automatic, 30)),
              solved(with_size(automatic, 100)), solved(with_size(nlgs, 10)),
              solved(with_size(nlgs, 30)), solved(with_size(nlgs, 100)));
  bench_print(
      page, "![The ending of each method on the problems with 30 "
            "contacts](../../docs/pictures/hard.png)\n\n"
            "A problem: W dense with eigenvalues from 1 to 1 / condition, spaced evenly in their "
            "logarithm; the answer is drawn first, contacts free,\nsticking or slipping, one in "
            "three each, so that a solution exists (bench/regret_elastic.c). Solved: certified at "
            "1e-8. A run that meets its limit is\nrepeated with ten times that; then it is a "
            "cycle (the reactions came back), no progress (the residual fell by less than half "
            "in the second\nhalf of the iterations), or not decided. Limits of the second try: "
            "0.2 s with 10 contacts, 0.4 s with 30, 2 s with 100, 4 s with 300, 10 s\nwith 1000. "
            "Not applicable: Lemke's method and the homotopy take no infinite friction.\n");
}

void hard_report(FILE *page, int count, const hard_row *row) {
  rows = row;
  row_count = count;
  report_lines(page);
  report_endings(page);
  report_shares(page);
  report_open(page);
}
