/*
 * test_trails.c: pins how the methods go, step by step, on problems of many kinds: trails.txt has
 * a line for each problem and run. A change of a constant, a sign or an order in a method shows
 * there, where a test of its answer alone would pass. A change of tuning that is meant makes new
 * figures, which
 *
 *   build/tests/tuning/test_trails print
 *
 * writes. It solves each problem again with W and q disturbed by rounding, and writes - for a
 * figure that does not survive it: that one would differ between processors, too.
 */
#include <check.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "cases.h"
#include "delassus.h"
#include "failures.h"
#include "front_cases.h"
#include "rigid.h"
#include "run.h"

/* ---- problems -------------------------------------------------------------------------------- */

typedef struct trails_problem {
  char name[64];
  dls_contact p;
  rigid bodies; /* owns the arrays of p where bodies.p is set */
} trails_problem;

enum { half_cells = 60 };

/* a->p := problem k in storage that lasts until the next call. Returns 0 past the last one. */
static int trails_make(int k, trails_problem *a) {
  static model m, copy;
  static bodies_storage storage;
  static planted_problem plant;
  static double W[4 * half_cells * half_cells], q[2 * half_cells], mu[half_cells];
  memset(a, 0, sizeof *a);
  int at = k;
#define TRAILS(count, ...)                                                                         \
  do {                                                                                             \
    if (at >= 0 && at < (count)) {                                                                 \
      __VA_ARGS__;                                                                                 \
      return 1;                                                                                    \
    }                                                                                              \
    at -= (count);                                                                                 \
  } while (0)
  TRAILS(8, numbered_model(&m, at < 6 ? 3 * at + 2 : normal_models + at);
         (void)snprintf(a->name, sizeof a->name, "random-%d", at); a->p = m.p);
  TRAILS(4, deficient_model(&m, at); (void)snprintf(a->name, sizeof a->name, "deficient-%d", at);
         a->p = m.p);
  TRAILS(2, slow_model(&m, at); (void)snprintf(a->name, sizeof a->name, "slow-%d", at); a->p = m.p);
  TRAILS(1, slow_model(&copy, 1); scale_model(&m, &copy, 1e-3, 1e6);
         (void)snprintf(a->name, sizeof a->name, "other-units"); a->p = m.p);
  TRAILS(7, a->p = planted_case(&plant, at);
         (void)snprintf(a->name, sizeof a->name, "planted-%d", at));
  TRAILS(2, a->p = half_plane(W, q, mu, at ? half_cells : 24, 2, at ? .3 : .8, at ? 3 : .5, .4);
         (void)snprintf(a->name, sizeof a->name, "half-plane-%d", at));
  TRAILS(3, bodies_model(&m, &storage, &a->p, at + 3);
         (void)snprintf(a->name, sizeof a->name, "bodies-%d", at));
  int count;
  const failure *f = contact_failures(&count);
  TRAILS(count, a->p = failure_contact(&f[at]);
         (void)snprintf(a->name, sizeof a->name, "%.50s", f[at].name));
  int kinds = 0;
  while (rigid_kind(kinds))
    kinds++;
  /* every kind by blocks, of bodies, larger */
  static const struct {
    const char *name;
    int of_bodies, candidates;
  } size[] = {{"", 0, 36},
              {"-of-bodies", 1, 36},
              {"-150", 0, 150},
              {"-150-of-bodies", 1, 150},
              {"-500", 0, 500}};
  enum { sizes = sizeof size / sizeof size[0] };
  TRAILS(sizes * kinds, const char *kind = rigid_kind(at / sizes); const int s = at % sizes;
         ck_assert_int_eq(rigid_create(&a->bodies, kind, size[s].candidates, .5, 7), 0);
         a->p = size[s].of_bodies ? a->bodies.factored : a->bodies.contact;
         (void)snprintf(a->name, sizeof a->name, "%s%s", kind, size[s].name));
#undef TRAILS
  return 0;
}

static void trails_free(trails_problem *a) {
  if (a->bodies.p) rigid_free(&a->bodies);
}

/* ---- runs ------------------------------------------------------------------------------------ */

static const struct {
  const char *name;
  dls_method method;
  dls_acceleration acceleration;
  int max_iterations, most_rows, threads; /* threads > 1: of many candidates alone */
} runs[] = {
    {"nlgs", DLS_NLGS, DLS_ACCELERATION_NONE, 200, 1000, 1},
    {"aitken", DLS_NLGS, DLS_ACCELERATION_AITKEN, 200, 1000, 1},
    {"anderson", DLS_NLGS, DLS_ACCELERATION_ANDERSON, 200, 1000, 1},
    {"momentum", DLS_NLGS, DLS_ACCELERATION_MOMENTUM, 900, 1000, 1},
    {"newton", DLS_NEWTON, DLS_ACCELERATION_NONE, 12, 300, 1},
    {"admm", DLS_ADMM, DLS_ACCELERATION_NONE, 120, 300, 1},
    {"augmented", DLS_AUGMENTED_LAGRANGIAN, DLS_ACCELERATION_NONE, 12, 150, 1},
    {"penalty", DLS_PENALTY, DLS_ACCELERATION_NONE, 0, 150, 1},
    {"homotopy", DLS_HOMOTOPY, DLS_ACCELERATION_NONE, 60, 60, 1},
    {"lemke", DLS_LEMKE, DLS_ACCELERATION_NONE, 0, 60, 1},
    {"auto", DLS_AUTO, DLS_ACCELERATION_NONE, 300, 1000, 1},
    {"nlgs-2", DLS_NLGS, DLS_ACCELERATION_NONE, 60, 2000, 2},
    {"momentum-2", DLS_NLGS, DLS_ACCELERATION_MOMENTUM, 120, 2000, 2},
};
enum { run_count = sizeof runs / sizeof runs[0] };

/* What a run leaves: counts are compared exactly, sums to sum_tol. */
enum { most_stages = DLS_STAGES_MAX, counts = 6 + 2 * most_stages, sums = 6 };
typedef struct trail {
  int count[counts];
  double sum[sums]; /* of early residuals, of all, of r, u; of stages; of the certificate */
  int calls;
} trail;

static const char trails_file[] = TEST_DATA "/../tests/tuning/trails.txt";
static const double sum_tol = 1e-5;

static double weight_of(int k) {
  return 1 + fmod(.6180339887498949 * (k + 1), 1);
}

static int trails_look(void *data, const dls_progress *progress) {
  trail *t = data;
  if (progress->last) return 0;
  const int k = t->calls++;
  /* what rounding leaves is noise */
  const double size = progress->residual > 1e-9 ? log10(progress->residual) : 0;
  if (k < 10) t->sum[0] += weight_of(k) * size;
  t->sum[1] += weight_of(k) * size;
  return 0;
}

static double sum_of(const double *x, int n) {
  double sum = 0;
  for (int i = 0; i < n; i++)
    sum += weight_of(i) * x[i];
  const double size = norm_of(x, n);
  return size > 0 ? sum / size : 0;
}

static void trails_run(const dls_contact *p, int run, trail *t) {
  memset(t, 0, sizeof *t);
  const int m = p->d * p->nc;
  double *r = calloc((size_t)m + 1, sizeof *r), *u = calloc((size_t)m + 1, sizeof *u);
  ck_assert_ptr_nonnull(r);
  ck_assert_ptr_nonnull(u);
  dls_solver_settings s = settings_of(runs[run].method);
  s.acceleration = runs[run].acceleration;
  s.limits.tol = 1e-10;
  s.limits.max_iterations = runs[run].max_iterations;
  s.limits.threads = runs[run].threads;
  s.limits.progress = trails_look;
  s.limits.progress_data = t;
  dls_info info = {0};
  t->count[0] = (int)dls_solve(p, &s, r, u, &info, NULL);
  if (t->count[0] >= 0) {
    t->count[1] = info.iterations;
    t->count[2] = info.factorisations;
    t->count[3] = info.sweeps;
    t->count[4] = info.ambiguous;
    t->count[5] = (int)info.unique;
    for (int k = 0; k < info.stages && k < most_stages; k++) {
      t->count[6 + 2 * k] = 1 + (int)info.stage[k].method;
      t->count[7 + 2 * k] = 1000 * info.stage[k].factorisations + info.stage[k].iterations;
      const double residual = info.stage[k].residual;
      t->sum[4] += weight_of(k) * (residual > 1e-9 ? log10(residual) : 0);
    }
    t->sum[2] = sum_of(r, m);
    t->sum[3] = sum_of(u, m);
    const dls_certificate *c = &info.certificate;
    t->sum[5] = c->residual > 1e-9 ? log10(c->residual_u + 2 * c->residual_r) : 0;
  }
  free(r);
  free(u);
}

/* ---- figures --------------------------------------------------------------------------------- */

/* Writes the figures of t, - for those that differ from another one of `others`. */
static void trails_print(FILE *out, const trail *t, const trail *others, int n) {
  int last = counts - 1;
  while (last > 5 && t->count[last] == 0)
    last--;
  for (int i = 0; i <= last; i++) {
    int same = 1;
    for (int k = 0; k < n; k++)
      same &= others[k].count[i] == t->count[i];
    if (same)
      fprintf(out, " %d", t->count[i]);
    else
      fprintf(out, " -");
  }
  fprintf(out, " :");
  for (int i = 0; i < sums; i++) {
    int same = 1;
    for (int k = 0; k < n; k++)
      same &= fabs(others[k].sum[i] - t->sum[i]) <= .01 * sum_tol * fmax(1, fabs(t->sum[i]));
    if (same)
      fprintf(out, " %.9g", t->sum[i]);
    else
      fprintf(out, " -");
  }
  fprintf(out, "\n");
}

/* Compares t with the figures of a line. */
static void trails_compare(const trail *t, char *line, const char *name, const char *run) {
  char *save, *word = strtok_r(line, " \n", &save);
  for (int i = 0; i < counts; i++) {
    if (word && strcmp(word, ":") == 0) {
      ck_assert_msg(t->count[i] == 0, "%s, %s: count %d is %d, not 0", name, run, i, t->count[i]);
      continue;
    }
    ck_assert_ptr_nonnull(word);
    if (strcmp(word, "-") != 0)
      ck_assert_msg(atoi(word) == t->count[i], "%s, %s: count %d is %d, not %s", name, run, i,
                    t->count[i], word);
    word = strtok_r(NULL, " \n", &save);
  }
  for (int i = 0; i < sums; i++) {
    word = strtok_r(NULL, " \n", &save);
    ck_assert_ptr_nonnull(word);
    if (strcmp(word, "-") == 0) continue;
    const double wanted = strtod(word, NULL);
    ck_assert_msg(fabs(t->sum[i] - wanted) <= sum_tol * fmax(1, fabs(wanted)),
                  "%s, %s: sum %d is %.9g, not %.9g", name, run, i, t->sum[i], wanted);
  }
}

/* The runs of a problem that are worth their time. */
static int trails_has(const trails_problem *a, int run) {
  return a->p.d * a->p.nc <= runs[run].most_rows && (runs[run].threads == 1 || a->p.nc > 130);
}

/* Returns p with W and q disturbed by rounding, W in other units; of bodies, q alone. Its arrays:
 * storage[0], [1]. */
static dls_contact trails_disturbed(const dls_contact *p, double *storage[2], unsigned *seed) {
  dls_contact a = *p;
  const size_t m = (size_t)p->d * (size_t)p->nc;
  const double unit = 1.5 + draw(seed) / 2;
  double *q = storage[0] = malloc(m * sizeof *q);
  ck_assert_ptr_nonnull(q);
  for (size_t i = 0; i < m; i++)
    q[i] = p->q[i] * (1 + 1e-13 * draw(seed));
  a.q = q;
  const size_t entries = p->W.a    ? (size_t)p->W.ld * m
                         : p->Wb.x ? (size_t)(p->d * p->d) * (size_t)p->Wb.p[p->nc]
                                   : 0;
  double *x = storage[1] = malloc((entries + 1) * sizeof *x);
  ck_assert_ptr_nonnull(x);
  for (size_t k = 0; k < entries; k++)
    x[k] = unit * (p->W.a ? p->W.a[k] : p->Wb.x[k]);
  for (size_t j = 0; p->W.a && j < m; j++) /* W stays as symmetric as it is */
    for (size_t i = 0; i <= j; i++) {
      const double rounding = 1 + 4e-16 * draw(seed);
      x[i + (size_t)p->W.ld * j] *= rounding;
      if (i < j) x[j + (size_t)p->W.ld * i] *= rounding;
    }
  if (p->W.a) a.W.a = x;
  if (p->Wb.x) a.Wb.x = x;
  return a;
}

START_TEST(print_trails) {
  FILE *out = fopen(trails_file, "w");
  ck_assert_ptr_nonnull(out);
  enum { others = 8 };
  static trails_problem a;
  static trail t, other[others];
  unsigned seed = 5;
  for (int k = 0; trails_make(k, &a); k++) {
    for (int run = 0; run < run_count; run++) {
      if (!trails_has(&a, run)) continue;
      trails_run(&a.p, run, &t);
      for (int j = 0; j < others; j++) {
        double *storage[2];
        const dls_contact p = trails_disturbed(&a.p, storage, &seed);
        trails_run(&p, run, &other[j]);
        free(storage[0]);
        free(storage[1]);
      }
      fprintf(out, "%s %s", a.name, runs[run].name);
      trails_print(out, &t, other, others);
    }
    trails_free(&a);
  }
  ck_assert_int_eq(fclose(out), 0);
}
END_TEST

/* All runs of a fourth of the problems. */
enum { shares = 4 };
START_TEST(trails_are_those_of_the_file) {
  static trails_problem a;
  static trail t;
  static char line[2000];
  FILE *file = fopen(trails_file, "r");
  ck_assert_ptr_nonnull(file);
  for (int k = 0; trails_make(k, &a); k++) {
    for (int run = 0; run < run_count; run++) {
      if (!trails_has(&a, run)) continue;
      do
        ck_assert_ptr_nonnull(fgets(line, sizeof line, file));
      while (line[0] == '#');
      if (k % shares != _i) continue;
      const size_t name = strlen(a.name), length = name + 1 + strlen(runs[run].name);
      ck_assert_mem_eq(line, a.name, name);
      ck_assert_mem_eq(line + name + 1, runs[run].name, strlen(runs[run].name));
      trails_run(&a.p, run, &t);
      trails_compare(&t, line + length, a.name, runs[run].name);
    }
    trails_free(&a);
  }
  ck_assert_ptr_null(fgets(line, sizeof line, file));
  (void)fclose(file);
}
END_TEST

int main(int argc, char **argv) {
  if (argc > 1 && strcmp(argv[1], "print") == 0)
    return RUN("trails", NULL, NULL, ONCE(print_trails));
  return RUN("trails", NULL, NULL, EACH(trails_are_those_of_the_file, 0, shares));
}
