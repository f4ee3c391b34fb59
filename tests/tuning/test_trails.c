/*
 * test_trails.c: compares runs of the methods on problems of many kinds with recorded runs:
 * trails.txt has a line for each problem. It shows a change of a constant, a sign or an order in a
 * method, while a test of the answer alone would pass. Another trail is no defect; a worse one is:
 *
 *   worse    a run ends with a worse status, or with the same one for more than 5/4 of the cost of
 *            the file and 20 sweeps
 *   better   none is worse, and one is better by as much
 *   other    neither, but statuses, steps, iterations or stages are not those of the file
 *
 * It counts them, with all costs before and after, and fails on worse. The cost of a run: its
 * iterations in sweeps by auto's model of costs (src/auto/price.c), as if all contacts stuck; other
 * costs need a new file.
 *
 *   build/tests/tuning/test_trails print [REASON]
 *
 * compares, too, and writes the file. If a run is worse, it needs a reason, which becomes a line of
 * the file that begins with #. It solves each problem again with W and q disturbed by rounding:
 * counts that this changes would differ between processors, too. The line of a problem:
 *
 *   NAME HASH SWEEPS/FACTORISATIONS/STEPS FACTS RUN ..
 *   HASH   of all counts of the runs without ~
 *   FACTS  HASH[/MASK]: of facts known without solving; mask: hexadecimal, a bit for each figure
 *   RUN    STATUSES:COST[<LARGEST][~], or . for none; statuses: a letter for each solve, - where
 *          rounding decides; largest cost with rounding; ~: rounding changes counts
 */
#include "run.h"
#include "trails.h"

static const char trails_file[] = TEST_DATA "/../tests/tuning/trails.txt";

/* ---- hashes ---------------------------------------------------------------------------------- */

/* FNV-1a. */
static unsigned trails_hash(unsigned hash, long long x) {
  for (int k = 0; k < 8; k++)
    hash = (hash ^ (unsigned)((unsigned long long)x >> 8 * k & 255)) * 16777619u;
  return hash;
}

static const unsigned hash_start = 2166136261u;

static unsigned hash_counts(unsigned hash, const trail *t) {
  for (int i = 0; i < t->counts; i++)
    hash = trails_hash(hash, t->count[i]);
  for (int i = 0; i < t->solves; i++)
    hash = trails_hash(hash, t->status[i]);
  return hash;
}

/* Returns the digits of a sum that a hash sees: 1e-4 of max(1, |x|). */
static double digits_of(double x) {
  return 1e4 * asinh(x);
}

/* Returns figure i of the facts t as a whole number. */
static long long fact_of(const trail *t, int i) {
  return i < t->counts ? t->count[i] : llround(digits_of(t->sum[i - t->counts]));
}

/* Returns 1 if figure i of the facts is the same with rounding. */
static int fact_stands(const trail *t, int i, const trail *others, int n) {
  const double x = i < t->counts ? 0 : digits_of(t->sum[i - t->counts]);
  if (fabs(x - floor(x) - .5) < .05) return 0; /* between two whole numbers */
  for (int k = 0; k < n; k++)
    if (fact_of(&others[k], i) != fact_of(t, i)) return 0;
  return 1;
}

enum { most_facts = trails_counts + trails_sums };

/* stands[i] := 1 for the figures of a mask, hexadecimal, of n figures; all without one. */
static void read_mask(const char *mask, int n, int stands[most_facts]) {
  for (int i = 0; i < n; i++) {
    char digit[2] = {mask ? mask[i / 4] : 'f', 0};
    stands[i] = (int)(strtol(digit, NULL, 16) >> i % 4 & 1);
  }
}

static unsigned hash_facts(const trail *t, const int *stands) {
  unsigned hash = trails_hash(trails_hash(hash_start, t->counts), t->sums);
  for (int i = 0; i < t->counts + t->sums; i++)
    if (stands[i]) hash = trails_hash(hash, fact_of(t, i));
  return hash;
}

/* Writes HASH[/MASK], or . where rounding changes how many figures there are. */
static void print_facts(FILE *out, const trail *t, const trail *others, int n) {
  const int all = t->counts + t->sums;
  int stands[most_facts] = {0}, whole = 1;
  for (int k = 0; k < n; k++)
    if (others[k].counts != t->counts || others[k].sums != t->sums) {
      fprintf(out, " .");
      return;
    }
  for (int i = 0; i < all; i++)
    whole &= stands[i] = fact_stands(t, i, others, n);
  fprintf(out, " %08x", hash_facts(t, stands));
  for (int i = 0; i < all && !whole; i += 4) {
    int digit = 0;
    for (int j = i; j < i + 4 && j < all; j++)
      digit |= stands[j] << (j - i);
    fprintf(out, "%s%x", i ? "" : "/", (unsigned)digit);
  }
}

/* Returns 1 if the facts are those of the file. */
static int facts_are_the_same(const trail *t, const char *token) {
  if (strcmp(token, ".") == 0) return 1;
  const char *slash = strchr(token, '/');
  int stands[most_facts] = {0};
  if (slash && (int)strlen(slash + 1) != (t->counts + t->sums + 3) / 4) return 0;
  read_mask(slash ? slash + 1 : NULL, t->counts + t->sums, stands);
  return hash_facts(t, stands) == strtoul(token, NULL, 16);
}

/* ---- the file -------------------------------------------------------------------------------- */

/* What the file says of a run. */
typedef struct record {
  char status[trails_solves + 1];
  double cost, largest;
  int floats; /* rounding changes counts */
} record;

static void record_make(record *a, const trail *t, const trail *others, int n) {
  memset(a, 0, sizeof *a);
  memcpy(a->status, t->status, sizeof a->status);
  a->cost = a->largest = ceil(t->cost);
  for (int k = 0; k < n; k++) {
    a->largest = fmax(a->largest, ceil(others[k].cost));
    a->floats |= hash_counts(hash_start, &others[k]) != hash_counts(hash_start, t);
    for (int i = 0; i < t->solves; i++)
      if (others[k].status[i] != t->status[i]) a->status[i] = '-';
  }
}

static void record_print(FILE *out, const record *a) {
  fprintf(out, " %s:%.0f", a->status, a->cost);
  if (a->largest > a->cost) fprintf(out, "<%.0f", a->largest);
  if (a->floats) fprintf(out, "~");
}

static void record_read(record *a, const char *token) {
  memset(a, 0, sizeof *a);
  const char *colon = strchr(token, ':');
  ck_assert(colon && colon - token <= trails_solves);
  memcpy(a->status, token, (size_t)(colon - token));
  char *end;
  a->cost = a->largest = strtod(colon + 1, &end);
  if (*end == '<') a->largest = strtod(end + 1, &end);
  if (*end == '~') a->floats = *end++ == '~';
  ck_assert_int_eq(*end, 0);
}

/* Returns 1 where the run is better than the record, -1 where it is worse. */
static int record_judge(const record *a, const trail *t) {
  int better = 0;
  if (strlen(a->status) != strlen(t->status)) return -1;
  for (int i = 0; a->status[i]; i++) {
    if (a->status[i] == '-' || a->status[i] == t->status[i]) continue;
    const int was = trails_rank(a->status[i]), is = trails_rank(t->status[i]);
    if (is > was || (is == was && is == 0)) return -1;
    better |= is < was;
  }
  if (better) return 1;
  if (t->cost > 1.25 * a->largest + 20) return -1;
  return t->cost < a->cost / 1.25 - 20;
}

typedef struct totals {
  double sweeps, factorisations, steps, cost;
} totals;

static void totals_add(totals *a, const trail *t) {
  a->sweeps += t->sweeps;
  a->factorisations += t->factorisations;
  a->steps += t->steps;
  a->cost += ceil(t->cost);
}

enum { local_lines = 30, others = 16 };

/* Runs p, and n problems that differ from it by rounding. run < 0: the facts. */
static void run_disturbed(const dls_contact *p, int run, trail *t, trail *other, int n) {
  static unsigned seed = 5;
  for (int j = -1; j < n; j++) {
    double *storage[2] = {NULL, NULL};
    const dls_contact a = j < 0 ? *p : trails_disturbed(p, storage, &seed);
    trail *const to = j < 0 ? t : &other[j];
    memset(to, 0, sizeof *to);
    if (run < 0)
      trails_facts(&a, to);
    else
      trails_run(&a, run, to);
    free(storage[0]);
    free(storage[1]);
  }
}

static void print_problem(FILE *out, const trails_problem *a) {
  static trail t, other[others];
  static record of[trails_runs];
  unsigned hash = hash_start;
  totals all = {0, 0, 0, 0};
  for (int run = 0; run < trails_runs; run++) {
    if (!trails_has(&a->p, run)) continue;
    run_disturbed(&a->p, run, &t, other, others);
    record_make(&of[run], &t, other, others);
    if (!of[run].floats) hash = hash_counts(hash, &t);
    totals_add(&all, &t);
  }
  fprintf(out, "%s %08x %.0f/%.0f/%.0f", a->name, hash, all.sweeps, all.factorisations, all.steps);
  if (trails_has_facts(&a->p)) {
    run_disturbed(&a->p, -1, &t, other, others);
    print_facts(out, &t, other, others);
  } else {
    fprintf(out, " .");
  }
  for (int run = 0; run < trails_runs; run++)
    if (trails_has(&a->p, run))
      record_print(out, &of[run]);
    else
      fprintf(out, " .");
  fprintf(out, "\n");
}

static const char *reason; /* of print */

static void write_trails(void) {
  FILE *out = fopen(trails_file, "w");
  ck_assert_ptr_nonnull(out);
  static trails_problem a;
  static trail t, other[others];
  unsigned seed = 5;
  fprintf(out,
          "# test_trails.c says what stands here: name hash sweeps/factorisations/steps facts");
  for (int run = 0; run < trails_runs; run++)
    fprintf(out, " %s", trails_name(run));
  fprintf(out, "\n");
  if (reason) fprintf(out, "# %s\n", reason);
  for (int k = 0; trails_make(k, &a); k++) {
    print_problem(out, &a);
    trails_free(&a);
  }
  for (int k = 0; k < local_lines; k++) {
    memset(&t, 0, sizeof t);
    memset(other, 0, sizeof other);
    trails_local(k, NULL, &t);
    for (int j = 0; j < others; j++)
      trails_local(k, &seed, &other[j]);
    fprintf(out, "local-%d", k);
    print_facts(out, &t, other, others);
    fprintf(out, "\n");
  }
  ck_assert_int_eq(fclose(out), 0);
}

/* ---- the comparison -------------------------------------------------------------------------- */

typedef struct tally {
  int same, other, better, worse, facts, lines;
  totals before, after;
} tally;

/* Finds the line of a problem; save: where its words begin. Returns 0 if there is none. */
static int find_line(FILE *file, const char *name, char **save) {
  static char line[4000];
  rewind(file);
  while (fgets(line, sizeof line, file))
    if (line[0] != '#' && strcmp(strtok_r(line, " \n", save), name) == 0) return 1;
  printf("new: %s\n", name);
  return 0;
}

static const char *next_word(char **save) {
  const char *word = strtok_r(NULL, " \n", save);
  ck_assert_ptr_nonnull(word);
  return word;
}

/* Returns how run `run` went beside the file: 1, 0, -1, as record_judge; says so if not 0. */
static int compare_run(const trails_problem *a, int run, const char *token, tally *all,
                       unsigned *hash) {
  static trail t;
  record was;
  record_read(&was, token);
  run_disturbed(&a->p, run, &t, NULL, 0);
  if (!was.floats) *hash = hash_counts(*hash, &t);
  totals_add(&all->after, &t);
  all->before.cost += was.cost;
  const int judged = record_judge(&was, &t);
  if (judged)
    printf("%s: %s, %s: %s:%.0f, in the file %s\n", judged < 0 ? "worse" : "better", a->name,
           trails_name(run), t.status, ceil(t.cost), token);
  return judged;
}

static void compare_facts(const trail *t, const char *token, const char *name, tally *all) {
  if (facts_are_the_same(t, token)) return;
  printf("other facts than in the file: %s\n", name);
  all->facts++;
}

static void compare_problem(const trails_problem *a, FILE *file, tally *all) {
  static trail t;
  char *save;
  if (!find_line(file, a->name, &save)) return;
  all->lines++;
  const unsigned was = (unsigned)strtoul(next_word(&save), NULL, 16);
  unsigned hash = hash_start;
  totals before;
  ck_assert_int_eq(sscanf(next_word(&save), "%lf/%lf/%lf", &before.sweeps, &before.factorisations,
                          &before.steps),
                   3);
  all->before.sweeps += before.sweeps;
  all->before.factorisations += before.factorisations;
  all->before.steps += before.steps;
  const char *word = next_word(&save);
  if (trails_has_facts(&a->p)) {
    run_disturbed(&a->p, -1, &t, NULL, 0);
    compare_facts(&t, word, a->name, all);
  }
  int better = 0, worse = 0;
  for (int run = 0; run < trails_runs; run++) {
    word = next_word(&save);
    ck_assert_int_eq(trails_has(&a->p, run), strcmp(word, ".") != 0);
    if (strcmp(word, ".") == 0) continue;
    const int judged = compare_run(a, run, word, all, &hash);
    better |= judged > 0;
    worse |= judged < 0;
  }
  ck_assert_ptr_null(strtok_r(NULL, " \n", &save));
  ++*(worse ? &all->worse : better ? &all->better : hash != was ? &all->other : &all->same);
}

/* Compares with the whole file. Returns the number of problems and local ones that there are. */
static int compare_trails(tally *all) {
  static trails_problem a;
  static trail t;
  int k = 0;
  FILE *file = fopen(trails_file, "r");
  ck_assert_ptr_nonnull(file);
  for (; trails_make(k, &a); k++) {
    compare_problem(&a, file, all);
    trails_free(&a);
  }
  for (int j = 0; j < local_lines; j++) {
    char name[20], *save;
    (void)snprintf(name, sizeof name, "local-%d", j);
    memset(&t, 0, sizeof t);
    trails_local(j, NULL, &t);
    if (!find_line(file, name, &save)) continue;
    all->lines++;
    compare_facts(&t, next_word(&save), name, all);
  }
  (void)fclose(file);
  const totals *b = &all->before, *c = &all->after;
  printf("trails: %d same, %d other, %d better, %d worse\n"
         "before: cost %.0f, %.0f sweeps, %.0f factorisations, %.0f steps\n"
         "after:  cost %.0f, %.0f sweeps, %.0f factorisations, %.0f steps\n",
         all->same, all->other, all->better, all->worse, b->cost, b->sweeps, b->factorisations,
         b->steps, c->cost, c->sweeps, c->factorisations, c->steps);
  (void)fflush(stdout); /* a failure ends this process */
  return k + local_lines;
}

TEST(trails_are_no_worse_than_those_of_the_file) {
  static tally all;
  const int problems = compare_trails(&all);
  ck_assert_int_eq(all.lines, problems);
  ck_assert_int_eq(all.facts, 0);
  ck_assert_msg(all.worse == 0, "%d problems are worse than in the file", all.worse);
}

TEST_ALONE(print_trails) {
  static tally all;
  (void)compare_trails(&all);
  ck_assert_msg(reason || (all.worse == 0 && all.facts == 0),
                "%d problems are worse, %d have other facts: print needs a reason", all.worse,
                all.facts);
  write_trails();
}

int main(int argc, char **argv) {
  if (argc > 1 && strcmp(argv[1], "print") == 0) {
    reason = argc > 2 ? argv[2] : NULL;
    return run_alone(print_trails, 0, 1);
  }
  return run_tests("trails", NULL, NULL);
}
