/*
 * solvers_report.c: DIR/solvers.csv; from it DIR/solvers.md, the performance profiles by the code
 * of delassus profile (solvers_profile_2d.*, solvers_profile_3d.*), and for solvers.gp
 *
 *   ratio_1e-04.dat ...       time of delassus over that of the best of the peer, by set, by nc
 */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "charts/profile.h"
#include "common.h"
#include "solvers_report.h"

typedef struct entry { /* a scene */
  char set[8], name[64];
  int d, nc;
  size_t first; /* of its records */
} entry;

struct report {
  const char *directory;
  FILE *csv, *page;
  entry *scenes;
  record *records;
  size_t scene_count, record_count;
};

static const char *const sets[] = {"tiny", "fclib", "global", "block", "cube", "wall"};
enum { set_count = sizeof sets / sizeof sets[0], tiny = 20 /* candidates */ };

/* ---- collecting ------------------------------------------------------------------------------ */

report *report_open(const char *directory, int argc, char *const *argv) {
  report *p = calloc(1, sizeof *p);
  if (!p) return NULL;
  p->directory = directory;
  p->csv = bench_open(directory, "solvers.csv");
  if (p->csv)
    p->page = bench_page(directory, "solvers", "Every solver against those of Siconos", argc, argv);
  if (!p->page) {
    if (p->csv) fclose(p->csv);
    free(p);
    return NULL;
  }
  fputs("set,problem,d,nc,m,method,setting,storage,target,status,own_tol,residual,cpu_s,setup_s,"
        "iterations\n",
        p->csv);
  return p;
}

/* Makes room for one more element of an array that doubles at each power of two. */
static void *report_grow(void *array, size_t count, size_t size) {
  if (count & (count - 1)) return array;
  array = realloc(array, (count ? 2 * count : 1) * size);
  if (!array) {
    fputs("solvers: out of memory\n", stderr);
    exit(1);
  }
  return array;
}

void report_scene(report *p, const scene *s) {
  p->scenes = report_grow(p->scenes, p->scene_count, sizeof *p->scenes);
  entry *e = &p->scenes[p->scene_count++];
  *e = (entry){.d = s->contact.d, .nc = s->contact.nc, .first = p->record_count};
  const int small = strcmp(s->set, "fclib") == 0 && s->contact.nc <= tiny;
  snprintf(e->set, sizeof e->set, "%s", small ? "tiny" : s->set);
  snprintf(e->name, sizeof e->name, "%s", s->name);
}

static const char *verdict_name(verdict s) {
  static const char *const names[] = {"not-run", "solved", "unsolved", "wrong",
                                      "limit",   "crash",  "refused"};
  return names[s];
}

void report_add(report *p, const record *a) {
  p->records = report_grow(p->records, p->record_count, sizeof *p->records);
  p->records[p->record_count++] = *a;
  const entry *e = &p->scenes[p->scene_count - 1];
  fprintf(p->csv, "%s,%s,%d,%d,%d,%s,%s,%s,%.0e,%s", e->set, e->name, e->d, e->nc, e->d * e->nc,
          a->method, a->setting, a->storage, a->target, verdict_name(a->status));
  if (a->status == SOLVED || a->status == UNSOLVED || a->status == WRONG)
    fprintf(p->csv, ",%.0e,%.3e,%.4e,%.4e,%d\n", a->own_tol, a->residual, a->cpu, a->setup,
            a->iterations);
  else
    fputs(",,,,,\n", p->csv);
  fflush(p->csv);
}

/* ---- looking up ------------------------------------------------------------------------------ */

/* Chooses records of a scene. */
typedef struct choice {
  const char *label;
  int peer;
  const char *method; /* NULL: all. Of the peer its beginning: NSGS with any local solver, say */
} choice;

static int is_chosen(const choice *w, const record *a) {
  if (a->peer != w->peer) return 0;
  if (!w->method) return 1;
  return w->peer ? strncmp(a->method, w->method, strlen(w->method)) == 0
                 : strcmp(a->method, w->method) == 0;
}

/* Returns the fastest of the chosen records of a scene that meets a target; NULL for none. */
static const record *fastest(const report *p, size_t index, double target, const choice *w) {
  const size_t end = index + 1 < p->scene_count ? p->scenes[index + 1].first : p->record_count;
  const record *best = NULL;
  for (size_t k = p->scenes[index].first; k < end; k++) {
    const record *a = &p->records[k];
    if (a->target == target && a->status == SOLVED && is_chosen(w, a) &&
        (!best || a->cpu < best->cpu))
      best = a;
  }
  return best;
}

static const choice best_own = {"best of delassus", 0, NULL};
static const choice best_peer = {"best of Siconos", 1, NULL};
static const double targets[TARGETS] = {1e-4, 1e-8, 1e-12};

void report_progress(const report *p) {
  const size_t last = p->scene_count - 1;
  const entry *e = &p->scenes[last];
  printf("%-6s %-40s %5d", e->set, e->name, e->nc);
  for (int k = 0; k < TARGETS; k++) {
    const record *a = fastest(p, last, targets[k], &best_own);
    const record *b = fastest(p, last, targets[k], &best_peer);
    printf("  |");
    if (a)
      printf(" %8.2e %-13.13s", a->cpu, a->method);
    else
      printf(" %8s %-13s", "-", "");
    if (b)
      printf(" %8.2e %-11.11s", b->cpu, b->method + strlen("siconos-"));
    else
      printf(" %8s %-11s", "-", "");
    if (a && b)
      printf(" %6.2f", a->cpu / b->cpu);
    else
      printf(" %6s", "");
  }
  putchar('\n');
}

/* ---- summary --------------------------------------------------------------------------------- */

static const choice front_door = {"auto", 0, "auto"};

/* The sets of the summary: name, range of candidates. */
typedef struct range {
  const char *set; /* NULL: all but global */
  int least, most;
} range;

static int in_range(const entry *e, const range *g) {
  if (e->nc < g->least || e->nc > g->most) return 0;
  return g->set ? strcmp(e->set, g->set) == 0 : strcmp(e->set, "global") != 0;
}

/* How often a choice and the peer meet a target on a set, and the ratios of their times. */
typedef struct summary {
  int scenes, solved, peer_solved;
  double median, largest;
  const char *worst; /* the scene of the largest */
} summary;

static summary summarise(const report *p, const range *g, double target, const choice *w,
                         double *ratios) {
  summary a = {.median = NAN, .worst = ""};
  size_t both = 0;
  for (size_t s = 0; s < p->scene_count; s++) {
    if (!in_range(&p->scenes[s], g)) continue;
    const record *own = fastest(p, s, target, w), *peer = fastest(p, s, target, &best_peer);
    a.scenes++;
    a.solved += own != NULL;
    a.peer_solved += peer != NULL;
    if (!own || !peer) continue;
    ratios[both] = own->cpu / peer->cpu;
    if (ratios[both] > a.largest) {
      a.largest = ratios[both];
      a.worst = p->scenes[s].name;
    }
    both++;
  }
  a.median = bench_median(both, ratios);
  return a;
}

static void print_summary(const report *p) {
  static const range ranges[] = {{"tiny", 0, 1 << 30},   {"fclib", 0, 1 << 30},
                                 {"global", 0, 1 << 30}, {"block", 0, 1 << 30},
                                 {"cube", 0, 1 << 30},   {"wall", 0, 1 << 30},
                                 {NULL, 0, tiny},        {NULL, tiny + 1, 1 << 30}};
  double *ratios = malloc((p->scene_count + 1) * sizeof *ratios);
  if (!ratios) return;
  bench_print(p->page, "%s",
              "Ratio: CPU of delassus over that of the best solver of Siconos for the problem, "
              "over the problems that both\nsolve.\n\n| set | target | of | solved: auto | Siconos "
              "| median ratio | worst | on |\n|---|---|---|---|---|---|---|---|\n");
  for (size_t i = 0; i < sizeof ranges / sizeof ranges[0]; i++)
    for (int k = 0; k < TARGETS; k++) {
      const range *g = &ranges[i];
      const summary a = summarise(p, g, targets[k], &front_door, ratios);
      if (!a.scenes) continue;
      bench_print(p->page, "| %s | %.0e | %d | %d | %d | %.2f | %.2f | %s |\n",
                  g->set     ? g->set
                  : g->least ? "more than 20 contacts"
                             : "at most 20",
                  targets[k], a.scenes, a.solved, a.peer_solved, a.median, a.largest, a.worst);
    }
  free(ratios);
}

/* Prints the scenes on which the best of the peer beats auto or the best of delassus by more than
 * noise. */
static void print_lost(const report *p) {
  static const double noise = 1.1;
  bench_print(
      p->page, "%s",
      "\nWhere the best of Siconos is ahead of auto by more than a tenth, each problem at its "
      "worst target:\n\n| set | problem | contacts | target | Siconos | s | auto s | best "
      "of delassus | s |\n|---|---|---|---|---|---|---|---|---|\n");
  for (size_t s = 0; s < p->scene_count; s++) {
    const entry *e = &p->scenes[s];
    double worst = noise, target = 0;
    for (int k = 0; k < TARGETS; k++) {
      const record *a = fastest(p, s, targets[k], &front_door),
                   *b = fastest(p, s, targets[k], &best_peer);
      const double ratio = !b ? 0 : a ? a->cpu / b->cpu : INFINITY;
      if (ratio > worst) worst = ratio, target = targets[k];
    }
    if (target == 0) continue;
    const record *a = fastest(p, s, target, &front_door), *o = fastest(p, s, target, &best_own),
                 *b = fastest(p, s, target, &best_peer);
    bench_print(p->page, "| %s | %s | %d | %.0e | %s (%s) | %.2e |", e->set, e->name, e->nc, target,
                b->method, b->setting, b->cpu);
    if (a)
      bench_print(p->page, " %.2e |", a->cpu);
    else
      bench_print(p->page, " - |");
    if (o)
      bench_print(p->page, " %s | %.2e |\n", o->method, o->cpu);
    else
      bench_print(p->page, " - | - |\n");
  }
}

/* Prints how often each verdict other than solved or unsolved fell, on either side. */
static void print_verdicts(const report *p) {
  int count[2][REFUSED_IT + 1] = {{0}};
  for (size_t k = 0; k < p->record_count; k++)
    count[p->records[k].peer][p->records[k].status]++;
  bench_print(p->page, "\n| rows | solved | unsolved | wrong | limit | crash | refused |\n"
                       "|---|---|---|---|---|---|---|\n");
  for (int peer = 0; peer < 2; peer++) {
    bench_print(p->page, "| %s |", peer ? "Siconos" : "delassus");
    for (int k = SOLVED; k <= REFUSED_IT; k++)
      bench_print(p->page, " %d |", count[peer][k]);
    bench_print(p->page, "\n");
  }
}

/* ---- pictures -------------------------------------------------------------------------------- */

/* The curves of the profiles. */
static const choice curves[] = {{"auto", 0, "auto"},
                                {"newton", 0, "newton"},
                                {"nlgs+anderson", 0, "nlgs-anderson"},
                                {"nlgs", 0, "nlgs"},
                                {"admm", 0, "admm"},
                                {"augmented-lagrangian", 0, "augmented-lagrangian"},
                                {"lemke", 0, "lemke"},
                                {"best of Siconos", 1, NULL},
                                {"Siconos NSGS", 1, "siconos-nsgs"},
                                {"Siconos NSN", 1, "siconos-nsn"},
                                {"Siconos ADMM", 1, "siconos-admm"},
                                {"Siconos PROX", 1, "siconos-prox"},
                                {"Siconos CPG", 1, "siconos-cpg"},
                                {"Siconos Lemke", 1, "siconos-lemke"}};
enum { curve_count = sizeof curves / sizeof curves[0] };

/* Returns the time of the fastest of the chosen records that solves a scene to a target, or what
 * stands for it. */
static double time_of(const report *p, size_t index, double target, const choice *w) {
  const size_t end = index + 1 < p->scene_count ? p->scenes[index + 1].first : p->record_count;
  const record *a = fastest(p, index, target, w);
  double seconds = PROFILE_TOOK_NO_PART;
  for (size_t k = p->scenes[index].first; k < end && !a; k++) {
    const record *other = &p->records[k];
    if (other->target != target || !is_chosen(w, other)) continue;
    if (other->status == OVER_LIMIT) return PROFILE_NOT_DECIDED;
    seconds = PROFILE_NOT_ANSWERED;
  }
  return a ? a->cpu : seconds;
}

/* Draws the profile to 1e-8 of all scenes of dimension d. */
static int draw_dimension(const report *p, int d) {
  const char *labels[curve_count];
  int peer[curve_count], count = 0, good = 1;
  for (size_t s = 0; s < p->scene_count; s++)
    count += p->scenes[s].d == d;
  double *seconds = malloc(((size_t)count + 1) * curve_count * sizeof *seconds);
  for (int i = 0, at = 0; i < curve_count; i++) {
    labels[i] = curves[i].label;
    peer[i] = curves[i].peer;
    for (size_t s = 0; s < p->scene_count && seconds; s++)
      if (p->scenes[s].d == d) seconds[at++] = time_of(p, s, targets[TARGETS / 2], &curves[i]);
  }
  char name[40], title[80];
  snprintf(name, sizeof name, "solvers_profile_%dd", d);
  snprintf(title, sizeof title, "%d scenes in %dD to 1e-8: delassus, and dashed Siconos", count, d);
  const profile_picture picture = {.directory = p->directory,
                                   .name = name,
                                   .title = title,
                                   .solvers = curve_count,
                                   .problems = count,
                                   .solver = labels,
                                   .peer = peer,
                                   .seconds = seconds};
  if (count) good = seconds && draw_profile(&picture);
  free(seconds);
  return good ? 0 : -1;
}

static int write_ratios(const report *p) {
  for (int k = 0; k < TARGETS; k++) {
    char name[64];
    snprintf(name, sizeof name, "ratio_%.0e.dat", targets[k]);
    FILE *file = bench_open(p->directory, name);
    if (!file) return -1;
    for (int i = 0; i < set_count; i++) {
      fprintf(file, "\"%s\"\n", sets[i]);
      for (size_t s = 0; s < p->scene_count; s++) {
        const record *a = fastest(p, s, targets[k], &front_door),
                     *b = fastest(p, s, targets[k], &best_peer);
        if (strcmp(p->scenes[s].set, sets[i]) == 0 && a && b)
          fprintf(file, "%d %.4g\n", p->scenes[s].nc, a->cpu / b->cpu);
      }
      fputs("0.1 -1\n\n\n", file); /* out of the picture: a set without a point has a title, too */
    }
    if (fclose(file)) return -1;
  }
  return 0;
}

int report_close(report *p) {
  int bad = p->scene_count == 0;
  print_summary(p);
  print_lost(p);
  print_verdicts(p);
  bench_print(
      p->page,
      "\n![performance profiles, 2D](solvers_profile_2d.png)\n![and 3D](solvers_profile_3d.png)\n"
      "![ratio for each problem](solvers_ratio.png)\n");
  bad |= fclose(p->csv) != 0;
  bad |= fclose(p->page) != 0;
  bad |= draw_dimension(p, 2) != 0;
  bad |= draw_dimension(p, 3) != 0;
  bad |= write_ratios(p) != 0;
  free(p->scenes);
  free(p->records);
  free(p);
  return bad ? -1 : 0;
}
