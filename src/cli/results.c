/* results.c: the answer of a solve as a table for people and as CSV files. */
#include <stdlib.h>

#include "cli.h"

static const char local_names[] = "nts";

/* A table in one of its two dresses. */
typedef struct sheet {
  FILE *file;
  int csv;
} sheet;

static void put_number(const sheet *s, double value) {
  (void)fprintf(s->file, s->csv ? ",%.17g" : " %14.7g", value);
}

/* Writes a row for each candidate: index, the host's node where it is known, state, gap (u_n where
 * it is free), r, u. */
static void put_candidates(const sheet *s, const problem *p, const dls_contact_state *state,
                           const double *r, const double *u) {
  const int d = p->contact.d, parts = problem_parts(p), named = problem_node(p, 0) > 0;
  (void)fputs(s->csv ? "candidate_from_0" : "  candidate", s->file);
  if (named) (void)fputs(s->csv ? ",node" : "      node", s->file);
  (void)fputs(s->csv ? ",state,gap" : " state            gap", s->file);
  for (int of = 0; of < 2; of++)
    for (int i = 0; i < parts; i++)
      (void)fprintf(s->file, s->csv ? ",%c_%c" : "            %c_%c", "ru"[of], local_names[i]);
  (void)fputc('\n', s->file);
  for (int c = 0; c < p->contact.nc; c++) {
    (void)fprintf(s->file, s->csv ? "%d" : "  %9d", c);
    if (named) (void)fprintf(s->file, s->csv ? ",%d" : " %9d", problem_node(p, c));
    (void)fprintf(s->file, s->csv ? ",%s" : " %-5s",
                  parts == 1 && state[c] != DLS_FREE ? "touch" : state_word(state[c]));
    put_number(s, state[c] == DLS_FREE ? u[d * c] : 0);
    for (int i = 0; i < 2 * parts; i++)
      put_number(s, i < parts ? r[d * c + i] : u[d * c + i - parts]);
    (void)fputc('\n', s->file);
  }
}

/* Writes a row for each unknown: its index, or the host's node and direction, and its value. */
static void put_unknowns(const sheet *s, const problem *p, const double *x) {
  int node, direction;
  const int named = problem_unknown(p, 0, &node, &direction);
  (void)fputs(
      s->csv ? (named ? "node,direction,x\n" : "unknown_from_0,x\n")
             : (named ? "       node direction             x\n" : "    unknown              x\n"),
      s->file);
  for (int k = 0; k < p->model.n; k++) {
    if (problem_unknown(p, k, &node, &direction))
      (void)fprintf(s->file, s->csv ? "%d,%d" : "  %9d %9d", node, direction);
    else
      (void)fprintf(s->file, s->csv ? "%d" : "  %9d", k);
    put_number(s, x[k]);
    (void)fputc('\n', s->file);
  }
}

dls_contact_state *find_states(const problem *p, const double *r, const double *u) {
  const size_t count = p->contact.nc > 0 ? (size_t)p->contact.nc : 1;
  dls_contact_state *state = malloc(count * sizeof *state);
  dls_error error = {0};
  if (!state)
    (void)complain("out of memory");
  else if (p->on_K ? dls_reduction_states(p->reduction, p->mu, r, u, state, &error)
                   : dls_contact_states(&p->contact, r, u, state, &error)) {
    (void)complain_of("states", &error);
    free(state);
    state = NULL;
  }
  return state;
}

int print_results(const problem *p, const outcome *o, const double *r, const double *u,
                  const double *x) {
  dls_contact_state *state = find_states(p, r, u);
  char text[FREEDOM_ROOM];
  if (!state) return 0;
  const sheet s = {stdout, 0};
  if (is_quiet() && *freedom_words(o->freedom, o->info.forces, text)) printf("  %s\n", text);
  put_candidates(&s, p, state, r, u);
  if (x) put_unknowns(&s, p, x);
  free(state);
  return 1;
}

int write_results(const char *directory, const problem *p, const outcome *o, const double *r,
                  const double *u, const double *x, const char *unsolved) {
  char text[FREEDOM_ROOM];
  dls_contact_state *state = find_states(p, r, u);
  sheet s = {state ? open_in(directory, "r.csv") : NULL, 1};
  int good = s.file != NULL;
  if (good) {
    if (*unsolved) (void)fprintf(s.file, "# %s\n", unsolved);
    if (o->freedom > 0)
      (void)fprintf(s.file, "# %s\n", freedom_words(o->freedom, o->info.forces, text));
    put_candidates(&s, p, state, r, u);
    good = close_file(s.file, "r.csv");
  }
  good = good && write_surface(directory, p, state, r, u, x);
  free(state);
  if (!good || !x) return good;
  s.file = open_in(directory, "x.csv");
  if (!s.file) return 0;
  if (*unsolved) (void)fprintf(s.file, "# %s\n", unsolved);
  put_unknowns(&s, p, x);
  return close_file(s.file, "x.csv");
}
