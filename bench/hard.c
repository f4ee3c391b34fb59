/*
 * hard.c: where methods fail: hard contact problems in 3D by conditioning, friction, size and
 * degeneracy (regret_elastic.c), each method with the reason of its end (hard_solve.c).
 *
 *   hard --part K --out DIR    adds the runs of a part to DIR/hard.csv; 0: begins the file anew
 *   hard --page --out DIR      writes DIR/hard.md of these runs
 *   hard --one FLAW CONTACTS CONDITION MU SEED [SECONDS]    one problem, a line for each method
 *   hard --save DIR [SEED]     writes 30 of the problems as FCLIB files, for `delassus profile`
 *
 * Parts: the grid of conditioning and friction with 10 and with 30 contacts, two seeds of each
 * degeneracy; fewer problems with 100, 300 and 1000 contacts. A limit of CPU stands in each row.
 * Saved: all conditionings, frictions 0.3, 1 and 5, 30 and 100 contacts, seed 2 or
 * SEED, the degeneracies but bonded in turn.
 */
#include "hard.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "common.h"
#include "delassus/files.h"
#include "delassus/trust.h"

enum { most_rows = 20000 };

static const double conditions[] = {1, 1e2, 1e4, 1e6, 1e8}, frictions[] = {0, 0.3, 1, 2, 5};

/* A part: sizes, degeneracies first .. last, every step-th condition and friction, seeds 2, 4, ..;
 * limit of CPU seconds before the second try. */
static const struct {
  int nc, first, last, step, seeds;
  double seconds;
} parts[] = {{10, 0, 3, 1, 2, 0.02}, {30, 0, 0, 1, 2, 0.04}, {30, 1, 1, 1, 2, 0.04},
             {30, 2, 2, 1, 2, 0.04}, {30, 3, 3, 1, 2, 0.04}, {100, 0, 1, 2, 1, 0.2},
             {100, 2, 3, 2, 1, 0.2}, {300, 0, 0, 2, 1, 0.4}, {1000, 0, 0, 4, 1, 1}};
enum { part_count = sizeof parts / sizeof *parts };

/* Methods that are run from 300 contacts on. */
static int is_for_large(const char *method) {
  return strcmp(method, "auto") == 0 || strcmp(method, "nlgs+anderson") == 0 ||
         strcmp(method, "newton") == 0 || strcmp(method, "admm") == 0;
}

const char *hard_flaw_name(planted_flaw flaw) {
  static const char *const name[FLAWS] = {"none", "rank", "border", "bonded"};
  return name[flaw];
}

int hard_create(regret_problem *p, int nc, double condition, double mu, planted_flaw flaw,
                uint64_t seed) {
  uint64_t state = regret_state(seed, 77 + (uint64_t)flaw);
  *p = (regret_problem){0};
  if (!regret_planted(p, 3, nc, condition, mu, flaw, &state)) return 0;
  regret_free(p);
  return -1;
}

static int run_problem(FILE *csv, const hard_row *what) {
  regret_problem p;
  if (hard_create(&p, what->nc, what->condition, what->mu, what->flaw, (uint64_t)what->seed))
    return 1;
  for (int k = 0; hard_method_name(k); k++) {
    if (what->nc >= 300 && !is_for_large(hard_method_name(k))) continue;
    double cpu = 0;
    const hard_end end = hard_run(&p, k, what->limit, &cpu);
    fprintf(csv, "%d,%d,%g,%g,%d,%d,%d,%.3g,%g\n", (int)what->flaw, what->nc, what->condition,
            what->mu, what->seed, k, (int)end, cpu, what->limit);
  }
  fflush(csv);
  regret_free(&p);
  return 0;
}

static int run_part(int part, const char *out) {
  char path[1024];
  snprintf(path, sizeof path, "%s/hard.csv", out);
  FILE *csv = part < part_count ? fopen(path, part ? "a" : "w") : NULL;
  if (!csv) {
    perror(path);
    return 1;
  }
  if (!part) fprintf(csv, "flaw,contacts,condition,friction,seed,method,ending,cpu,limit\n");
  int bad = 0;
  for (int f = parts[part].first; f <= parts[part].last; f++)
    for (int i = 0; i < 5; i += parts[part].step)
      for (int j = 0; j < 5; j += parts[part].step)
        for (int s = 2; s <= 2 * parts[part].seeds && !bad; s += 2) {
          const hard_row what = {.flaw = (planted_flaw)f,
                                 .nc = parts[part].nc,
                                 .condition = conditions[i],
                                 .mu = frictions[j],
                                 .seed = s,
                                 .limit = parts[part].seconds};
          bad = run_problem(csv, &what);
        }
  return fclose(csv) != 0 || bad;
}

/* Writes the fold in 3D, the least friction at which some loads have two answers, between the proof
 * that there is one below and a pair of certified answers. Returns 1 after a failure. */
static int hard_fold_table(FILE *page) {
  bench_print(page,
              "| contacts | condition | seed | one answer below | two answers at | quotient | "
              "matrices |\n|---|---|---|---|---|---|---|\n");
  for (int nc = 2; nc <= 6; nc += 2)
    for (double condition = 10; condition < 2e4; condition *= condition)
      for (uint64_t seed = 2; seed <= 4; seed += 2) {
        regret_problem h;
        dls_fold f = {0};
        if (hard_create(&h, nc, condition, 0, FLAW_NONE, seed)) return 1;
        if (dls_contact_fold(&h.contact, &f, NULL, NULL, NULL, NULL, NULL)) return 1;
        bench_print(page, "| %d | %.0e | %d | %.3g | %.3g | %.2f | %d |\n", nc, condition,
                    (int)seed, f.unique, f.friction, f.friction / f.unique, f.matrices);
        regret_free(&h);
      }
  return 0;
}

static int write_page(const char *out, int argc, char **argv) {
  char path[1024], line[256];
  snprintf(path, sizeof path, "%s/hard.csv", out);
  FILE *csv = fopen(path, "r");
  hard_row *row = calloc(most_rows, sizeof *row);
  int count = 0;
  while (csv && row && count < most_rows && fgets(line, sizeof line, csv)) {
    int flaw, end;
    hard_row *r = &row[count];
    count += sscanf(line, "%d,%d,%lf,%lf,%d,%d,%d,%lf,%lf", &flaw, &r->nc, &r->condition, &r->mu,
                    &r->seed, &r->method, &end, &r->cpu, &r->limit) == 9;
    r->flaw = (planted_flaw)flaw;
    r->end = (hard_end)end;
  }
  if (!csv || !count) {
    fprintf(stderr, "%s has no runs\n", path);
    return 1;
  }
  fclose(csv);
  FILE *page = bench_page(out, "hard", "Where methods fail: hard problems in 3D", 1, argv);
  (void)argc;
  if (!page) return 1;
  hard_report(page, count, row);
  bench_print(page,
              "\n## The fold in 3D\n\nFriction from which some loads have two answers: "
              "`dls_contact_fold`. Below the first number each load has one answer\n(proved). "
              "At the second one a load with two certified answers was found.\n\n");
  const int bad = hard_fold_table(page);
  free(row);
  return fclose(page) != 0 || bad;
}

static int run_one(char **argument, double seconds) {
  int flaw = 0;
  while (flaw < FLAWS && strcmp(argument[0], hard_flaw_name((planted_flaw)flaw)) != 0)
    flaw++;
  regret_problem p;
  if (flaw == FLAWS || hard_create(&p, atoi(argument[1]), atof(argument[2]), atof(argument[3]),
                                   (planted_flaw)flaw, strtoull(argument[4], NULL, 10)))
    return 1;
  for (int k = 0; hard_method_name(k); k++) {
    double cpu = 0;
    const hard_end end = hard_run(&p, k, seconds, &cpu);
    printf("%-22s %-12s %.3g s\n", hard_method_name(k), hard_end_name(end), cpu);
  }
  regret_free(&p);
  return 0;
}

/* Writes a problem as DIRECTORY/hard-FLAW-CONTACTS-CONDITION-muFRICTION.hdf5. */
static int save_problem(const char *directory, const hard_row *what) {
  char name[96], path[1024];
  regret_problem p;
  dls_error error = {0};
  if (hard_create(&p, what->nc, what->condition, what->mu, what->flaw, (uint64_t)what->seed))
    return 1;
  (void)snprintf(name, sizeof name, "hard-%s-%d-1e%.0f-mu%g", hard_flaw_name(what->flaw), what->nc,
                 log10(what->condition), what->mu);
  (void)snprintf(path, sizeof path, "%s/%s.hdf5", directory, name);
  const int bad = dls_fclib_write_local(path, &p.contact, name, NULL, NULL, &error) < 0;
  if (bad) fprintf(stderr, "%s: %s\n", path, error.message);
  regret_free(&p);
  return bad;
}

/* An FCLIB file holds no infinite friction: none of them is bonded. */
static int save_problems(const char *directory, int seed) {
  static const int sizes[] = {30, 100}, friction[] = {1, 2, 4}; /* 0.3, 1, 5 */
  int bad = 0;
  for (int n = 0; n < 2; n++)
    for (int i = 0; i < 5; i++)
      for (int j = 0; j < 3 && !bad; j++) {
        const hard_row what = {.flaw = (planted_flaw)((n + i + j) % FLAW_BONDED),
                               .nc = sizes[n],
                               .condition = conditions[i],
                               .mu = frictions[friction[j]],
                               .seed = seed};
        bad = save_problem(directory, &what);
      }
  return bad;
}

int main(int argc, char **argv) {
  const char *out = argc >= 3 && strcmp(argv[argc - 2], "--out") == 0 ? argv[argc - 1] : NULL;
  if (argc >= 7 && strcmp(argv[1], "--one") == 0)
    return run_one(argv + 2, argc > 7 ? atof(argv[7]) : 1);
  if ((argc == 3 || argc == 4) && strcmp(argv[1], "--save") == 0)
    return save_problems(argv[2], argc == 4 ? atoi(argv[3]) : 2);
  if (out && argc == 5 && strcmp(argv[1], "--part") == 0) return run_part(atoi(argv[2]), out);
  if (out && argc == 4 && strcmp(argv[1], "--page") == 0) return write_page(out, argc, argv);
  fprintf(stderr, "hard --part K --out DIR, hard --page --out DIR, hard --save DIR [SEED], or "
                  "hard --one FLAW CONTACTS CONDITION MU SEED [SECONDS]\n");
  return 2;
}
