/* info.c: delassus info FILE: tells facts about a contact problem, in words or as JSON. */
#include <math.h>

#include "cli.h"
#include "problem/matrices.h"

static void info_usage(FILE *out) {
  fputs(
      "Usage: delassus info [OPTION]... FILE|SCENE\n"
      "  or:  delassus info [OPTION]... --W=W --q=Q --mu=MU (or --stiffness=K ...)\n"
      "Prints facts about a contact problem (FCLIB, local or global; text; of a scene; matrices):\n"
      "symmetry, rank and definiteness of W, scales, degenerate contacts, and how large friction\n"
      "may be; the fold, the friction below which each load has one solution (2D: up to 64\n"
      "contacts, 3D: up to 4); in 2D all solutions (up to 8). Contacts and rows count from 0.\n"
      "FILE may be a pipe, or - for standard input.\n"
      "\n"
      "      --limit=N         rank, eigenvalues and the bound on friction for up to N rows "
      "(2000)\n"
      "      --sensitivity     solve, and show which gaps and loads each reaction depends on, and\n"
      "                        how it changes with friction: a table, and a map in DIR (600 rows)\n"
      "  -o, --out=DIR         folder for the map (a new one under TMPDIR, which is "
      "printed)\n" LAST_USAGE "\nIn JSON null stands for: not known, none, or unbounded.\n\n",
      out);
  source_usage(out);
}

/* ---- words ----------------------------------------------------------------------------------- */

static void print_matrix(const problem *p, const dls_diagnosis *g) {
  const int m = p->contact.d * p->contact.nc;
  printf("  W: %d x %d, ", m, m);
  if (p->contact.Wb.x)
    printf("%d block%s; ", p->contact.Wb.p[p->contact.nc], plural(p->contact.Wb.p[p->contact.nc]));
  else
    fputs("dense; ", stdout);
  if (g->asymmetry <= m * 2.3e-16)
    puts(g->asymmetry > 0 ? "symmetric to rounding" : "symmetric");
  else
    printf("symmetric to %.1e of its largest entry, worst at rows %d and %d\n", g->asymmetry,
           g->row, g->col);
}

static void print_spectrum(int m, int limit, const dls_diagnosis *g) {
  if (!g->spectrum) {
    printf("  rank and eigenvalues: not computed for more than %d rows (--limit)\n", limit);
    return;
  }
  printf("  rank %d of %d: ", g->rank, m);
  if (g->negative)
    printf("indefinite, %d negative eigenvalue%s\n", g->negative, plural(g->negative));
  else if (g->rank < m)
    printf("positive semidefinite, statically indeterminate (%d self-stress%s)\n", m - g->rank,
           m - g->rank == 1 ? "" : "es");
  else
    puts("positive definite");
  printf("  eigenvalues of the scaled W: %.2e to %.2e", g->smallest, g->largest);
  if (g->smallest_positive > 0)
    printf(", condition%s %.1e", g->rank < m ? " on its range" : "",
           g->largest / g->smallest_positive);
  puts("");
  if (g->smallest < 0 && !g->negative && -g->smallest > 1e-12 * g->largest)
    printf(
        "    the slightly negative ones look like rounding of the file; below %.0e counts as 0\n",
        g->noise * g->largest);
}

static void print_scales(int nc, const dls_diagnosis *g) {
  printf("  weights w_c = trace(W_cc)/d: %.3g to %.3g; |q| = %.3g\n", g->weight_min, g->weight_max,
         g->q_norm);
  if (g->closing)
    printf("  without reactions, %d of %d contact%s would interpenetrate\n", g->closing, nc,
           plural(nc));
  else
    puts("  no contact would interpenetrate without reactions: r = 0 is a solution");
}

static void print_flaw(const dls_flaw *flaw, const char *one, const char *more,
                       const char *meaning) {
  if (flaw->count)
    printf("  degenerate: %d %s (first: %d): %s\n", flaw->count, flaw->count > 1 ? more : one,
           flaw->first, meaning);
}

static void print_friction(int d, int m, const dls_diagnosis *g) {
  static const double large = 1e6; /* no friction coefficient that anybody means */
  const double mu = g->friction_max;
  printf("  friction %.3g", g->friction_min);
  if (mu > g->friction_min) printf(" to %.3g", mu);
  if (g->friction_unique >= large)
    puts(": one solution, whatever the friction and the loads");
  else if (g->friction_unique > 0)
    printf("; below %.3g there is one solution, whatever the loads%s%s\n", g->friction_unique,
           d == 2 ? ", and Lemke's method finds it" : "",
           mu < g->friction_unique ? ": this is so here" : "");
  else if (g->spectrum && g->rank < m && !g->negative)
    puts("; with W singular the reactions need not be unique, whatever the friction");
  else
    puts("; no bound is known below which the solution is unique");
  if (g->friction_critical < large)
    printf("    above %.3g (contact %d) there are loads with several solutions\n",
           g->friction_critical, g->critical);
  if (g->wedged.count)
    printf("    %d contact%s (first: %d) %s above W_nn/|W_nt| and can jam alone\n", g->wedged.count,
           plural(g->wedged.count), g->wedged.first, g->wedged.count > 1 ? "are" : "is");
}

/* ---- trust ----------------------------------------------------------------------------------- */

enum { most_proved = 300 }; /* rows of a problem that is solved and proved */
enum {
  most_fold = 64,
  most_fold_3d = 4,
  most_listed = DLS_STATES_MAX,
  room = 32,
  listed_rows = 2 * most_listed
};

/* The fold, and all solutions of a problem in 2D, where it is small enough. */
typedef struct trust {
  int has_fold, has_list, has_proof;
  dls_proof proof; /* of the answer of auto */
  dls_fold fold;
  dls_status status; /* of the list */
  dls_solution_set set;
  double r[room * listed_rows], low[room * listed_rows], high[room * listed_rows];
} trust;

/* Solves by auto, and proves r (m): improves it. *solved: 1 where there is an answer. */
static dls_status solve_and_prove(const dls_contact *contact, double *r, dls_proof *proof,
                                  int *solved, dls_error *error) {
  dls_solver_settings settings;
  dls_solver_settings_init(&settings);
  settings.limits.cpu_seconds = 1;
  const dls_status status = dls_solve(contact, &settings, r, NULL, NULL, error);
  *solved = dls_solved(status);
  if (!*solved) return status == DLS_E_MEMORY ? status : DLS_OK;
  return dls_contact_prove(contact, r, proof, r, error);
}

/* Proves the answer where there is one; without memory returns DLS_E_MEMORY. */
static dls_status find_proof(const dls_contact *contact, trust *t, dls_error *error) {
  static double r[most_proved];
  const int m = contact->d * contact->nc;
  int solved = 0;
  if (m == 0 || m > most_proved) return DLS_OK;
  const dls_status status = solve_and_prove(contact, r, &t->proof, &solved, error);
  t->has_proof = solved && status == DLS_OK;
  return status;
}

/* Finds fold and solutions where the problem has them; without memory returns DLS_E_MEMORY. */
static dls_status find_trust(const dls_contact *contact, trust *t, dls_error *error) {
  dls_status status = contact->d > 1 && contact->nc <= (contact->d == 2 ? most_fold : most_fold_3d)
                          ? dls_contact_fold(contact, &t->fold, NULL, NULL, NULL, NULL, error)
                          : DLS_E_UNSUPPORTED;
  t->has_fold = status == DLS_OK;
  if (status != DLS_E_MEMORY) status = find_proof(contact, t, error);
  if (status) return status;
  if (contact->d != 2 || contact->nc > most_listed) return DLS_OK;
  t->status = dls_contact_enumerate(contact, 1e-8, room, t->r, t->low, t->high, &t->set, error);
  t->has_list = t->status >= 0;
  return t->status == DLS_E_MEMORY ? t->status : DLS_OK;
}

/* Returns how many solutions are in the list. */
static int listed(const trust *t) {
  const int all = t->set.isolated + t->set.continua;
  return all < room ? all : room;
}

static void print_solutions(int m, const trust *t) {
  const dls_solution_set *set = &t->set;
  if (t->status == DLS_NO_SOLUTION)
    puts("  this load has no solution (proved, state by state)");
  else if (t->status == DLS_NO_SOLUTION_LIKELY)
    puts("  this load has no solution, up to rounding");
  else
    printf("  all solutions for this load: %d isolated, %d continu%s%s\n", set->isolated,
           set->continua, set->continua == 1 ? "um" : "a",
           t->status == DLS_STALLED ? "; rounding may hide others" : "");
  for (int k = 0; k < listed(t); k++) {
    const double *r = t->r + k * m, *low = t->low + k * m, *high = t->high + k * m;
    fputs("    r =", stdout);
    for (int i = 0; i < m; i++)
      if (low[i] < high[i])
        printf(" [%.6g,%.6g]", low[i], high[i]);
      else
        printf(" %.6g", r[i]);
    puts("");
  }
}

static void print_trust(const dls_contact *contact, const trust *t) {
  char words[120];
  if (t->has_fold && t->fold.friction <= 1e6)
    printf("  fold: %s friction %.6g each load has one solution, above it some have several\n"
           "    (%d matrices%s)\n",
           t->fold.exact ? "below" : "as far as a search can tell, below", t->fold.friction,
           t->fold.matrices, t->fold.exact ? ", all states" : "");
  else if (t->has_fold)
    puts(t->fold.unique > 1e6 ? "  fold: none, whatever the friction" : "  fold: none was found");
  if (t->has_list) print_solutions(2 * contact->nc, t);
  if (t->has_proof) printf("  answer of auto: %s\n", proof_words(&t->proof, words, sizeof words));
}

void print_hints(int hints) {
  if (hints & DLS_HINT_OUTWARD)
    puts(
        "  hint: nothing presses; if it should, normals point out of the bodies (the sign of H_N)");
  if (hints & DLS_HINT_TRANSPOSED)
    puts("  hint: the transpose of W has an answer; rows may have been given as columns");
}

static void print_facts(const char *path, const problem *p, int limit, const dls_diagnosis *g,
                        const trust *t) {
  const dls_contact *contact = &p->contact;
  problem_print(path, p);
  print_matrix(p, g);
  if (contact->nc == 0) return;
  print_spectrum(contact->d * contact->nc, limit, g);
  print_scales(contact->nc, g);
  print_flaw(&g->zero_block, "contact", "contacts", "W_cc = 0");
  print_flaw(&g->no_weight, "contact", "contacts", "trace(W_cc) <= 0");
  print_flaw(&g->no_normal, "contact", "contacts", "W_nn <= 0, pushing does not open it");
  print_flaw(&g->singular_block, "contact", "contacts", "W_cc is singular");
  print_flaw(&g->no_effect, "component of r", "components of r", "without effect on u");
  print_friction(contact->d, contact->d * contact->nc, g);
  print_trust(contact, t);
  print_hints(g->hints);
}

/* ---- JSON ------------------------------------------------------------------------------------ */

static void field(const char *name, double value) {
  print_json_field(stdout, name, value);
}

/* Prints an index, null for -1. */
static void index_field(const char *name, int index) {
  field(name, index < 0 ? (double)NAN : index);
}

static void flaw_field(const char *name, const dls_flaw *flaw) {
  printf(",\n  \"%s\": {\"count\": %d, \"first\": ", name, flaw->count);
  print_json_number(stdout, flaw->count ? flaw->first : (double)NAN);
  fputc('}', stdout);
}

/* Prints the fold, null if it is not known or at infinity, and the solutions, null if not known. */
static void print_trust_json(int m, const trust *t) {
  field("fold", t->has_fold ? t->fold.friction : (double)NAN);
  printf(",\n  \"fold_exact\": %s", t->has_fold && t->fold.exact ? "true" : "false");
  field("isolated", t->has_list ? (double)t->set.isolated : (double)NAN);
  field("continua", t->has_list ? (double)t->set.continua : (double)NAN);
  printf(",\n  \"no_solution_proved\": %s",
         t->has_list && t->status == DLS_NO_SOLUTION ? "true" : "false");
  const int proved = t->has_proof && t->proof.kind == DLS_PROVED;
  field("proved_radius", proved ? t->proof.radius : (double)NAN);
  fputs(",\n  \"solutions\": ", stdout);
  if (!t->has_list) {
    fputs("null", stdout);
    return;
  }
  fputc('[', stdout);
  for (int k = 0; k < listed(t); k++) {
    fputs(k ? ",\n    {" : "\n    {", stdout);
    print_json_numbers(stdout, "\"r\"", m, t->r + k * m);
    fputs(", ", stdout);
    print_json_numbers(stdout, "\"low\"", m, t->low + k * m);
    fputs(", ", stdout);
    print_json_numbers(stdout, "\"high\"", m, t->high + k * m);
    fputc('}', stdout);
  }
  fputc(']', stdout);
}

static void print_info_json(const problem *p, const dls_diagnosis *g, const trust *t) {
  const double unknown = g->spectrum ? 0 : NAN;
  printf("{\n  \"dimension\": %d,\n  \"contacts\": %d,\n  \"global\": %s", p->contact.d,
         p->contact.nc, p->reduction ? "true" : "false");
  field("asymmetry", g->asymmetry);
  index_field("row", g->row);
  index_field("col", g->col);
  printf(",\n  \"spectrum\": %s", g->spectrum ? "true" : "false");
  field("rank", unknown + g->rank);
  field("negative", unknown + g->negative);
  field("noise", unknown + g->noise);
  field("smallest", unknown + g->smallest);
  field("largest", unknown + g->largest);
  field("smallest_positive", unknown + g->smallest_positive);
  field("weight_min", g->weight_min);
  field("weight_max", g->weight_max);
  field("q_norm", g->q_norm);
  field("closing", g->closing);
  field("friction_min", g->friction_min);
  field("friction_max", g->friction_max);
  field("friction_unique", unknown + g->friction_unique);
  field("friction_critical", g->friction_critical);
  index_field("critical", g->critical);
  flaw_field("wedged", &g->wedged);
  flaw_field("zero_block", &g->zero_block);
  flaw_field("no_weight", &g->no_weight);
  flaw_field("no_normal", &g->no_normal);
  flaw_field("singular_block", &g->singular_block);
  flaw_field("no_effect", &g->no_effect);
  print_trust_json(p->contact.d * p->contact.nc, t);
  printf(",\n  \"outward\": %s,\n  \"transposed\": %s",
         g->hints & DLS_HINT_OUTWARD ? "true" : "false",
         g->hints & DLS_HINT_TRANSPOSED ? "true" : "false");
  puts("\n}");
}

/* ---- the command ----------------------------------------------------------------------------- */

typedef struct info_options {
  source from;
  int limit, sensitivity;
  const char *out;
} info_options;

/* Does --sensitivity. */
static int map_answer(const char *path, const dls_contact *contact, const char *out) {
  static double r[most_rows_of_map];
  dls_error error = {0};
  dls_proof proof;
  int solved = 0;
  const int m = contact->d * contact->nc;
  if (m > most_rows_of_map || m == 0)
    return complain("--sensitivity: %s has %d rows, 1 to %d are mapped", path, m, most_rows_of_map);
  if (solve_and_prove(contact, r, &proof, &solved, &error)) return complain_of(path, &error);
  if (!solved) return complain("--sensitivity: %s: auto has no answer in a second", path);
  out = take_folder(out, "info", path);
  return out ? show_sensitivity(path, contact, r, out, prints_text()) : EXIT_BAD_INPUT;
}

int command_info(int argc, char **argv) {
  static const option_row options[] = {ROW(A_COUNT, "limit", 0, info_options, limit),
                                       ROW(A_FLAG, "sensitivity", 0, info_options, sensitivity),
                                       ROW(A_TEXT, "out", 'o', info_options, out),
                                       SOURCE_OPTIONS(info_options, from), LAST_OPTIONS};
  static const command info = {options, info_usage, NULL, 0};
  info_options o = {.limit = 2000};
  const int stop = take_options(argc, argv, &info, &o);
  if (stop != GO_ON) return stop;
  const char *given = matrices_name(&o.from.matrices), *path = given ? given : argv[optind];
  if (argc - optind != !given) return wrong_names(argv[0]);
  problem p = {0};
  dls_error error = {0};
  dls_diagnosis g;
  static trust t;
  int result = EXIT_SOLVED;
  if (!problem_open(path, &o.from, &p))
    result = EXIT_BAD_INPUT;
  else if (dls_contact_diagnose(&p.contact, o.limit, &g, &error) ||
           find_trust(&p.contact, &t, &error))
    result = complain_of(path, &error);
  else {
    if (is_verbose()) print_reduction(stderr, &p);
    if (is_json())
      print_info_json(&p, &g, &t);
    else if (!is_quiet())
      print_facts(path, &p, o.limit, &g, &t);
    if (o.sensitivity) result = map_answer(path, &p.contact, o.out);
  }
  problem_free(&p);
  return result;
}
