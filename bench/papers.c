/*
 * papers.c: answers the questions that [Jean 1988] and [Chabrand 1998] leave open, a paragraph and
 * a picture each. Writes papers.md and the data of the pictures, papers_*.csv; papers.gp draws
 * them.
 *
 *   papers [--only QUESTION] [--out DIR]
 *
 * QUESTION is a word of the table below: a trial, whose page has that question alone. `reactions`
 * reads DIR/papers_reactions.csv, the reactions.csv of `make demo`. CPU seconds are those of one
 * run on a busy machine.
 */
#include "papers.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "common.h"

int jean_create(jean_block *b, const char *name, int weighted, int nx, double mu) {
  *b = (jean_block){0};
  dls_error error = {0};
  dls_fe_scene_settings settings;
  dls_fe_scene_settings_init(&settings);
  settings.nx = nx;
  settings.ny = nx / 2;
  settings.mu = mu;
  dls_status status = dls_fe_scene_create_with(&b->scene, name, weighted, &settings, &error);
  if (!status) {
    dls_fe_scene_get(b->scene, &b->data);
    status = bench_reduce(&b->reduction, &b->data.model, &error);
  }
  if (!status) status = dls_reduction_load(b->reduction, b->data.f, b->data.g, &error);
  if (!status) status = dls_reduction_contact(b->reduction, b->data.mu, &b->contact, &error);
  if (!status) return 0;
  fprintf(stderr, "%s: %s\n", name, error.message);
  jean_free(b);
  return -1;
}

void jean_free(jean_block *b) {
  dls_reduction_destroy(b->reduction);
  dls_fe_scene_destroy(b->scene);
  *b = (jean_block){0};
}

double *jean_solve(const dls_contact *contact) {
  double *r = calloc((size_t)(contact->d * contact->nc), sizeof *r);
  dls_solver_settings settings;
  dls_solver_settings_init(&settings);
  settings.limits.tol = 1e-13;
  dls_info info = {0};
  dls_error error = {0};
  const dls_status status =
      r ? dls_solve(contact, &settings, r, NULL, &info, &error) : DLS_E_MEMORY;
  const dls_certificate *c = &info.certificate;
  if (dls_solved(status)) return r;
  fprintf(stderr, "not solved: %s (%s), %g, %g\n", dls_status_text(status), error.message,
          c->residual_u, c->residual_r);
  free(r);
  return NULL;
}

void table_copy(FILE *from, FILE *page) {
  char line[512];
  rewind(from);
  while (fgets(line, sizeof line, from))
    fputs(line, page);
  fclose(from);
}

static const struct {
  const char *word;
  int (*answer)(FILE *page, const char *out);
} questions[] = {
    {"reactions", papers_reactions}, {"refinement", papers_refinement}, {"aitken", papers_aitken},
    {"penalty", papers_penalty},     {"lemke", papers_lemke},           {"flow", papers_flow},
    {"weighting", papers_weighting},
};

int main(int argc, char **argv) {
  const char *out = bench_word(argc, argv, "--out", "build");
  const char *only = bench_word(argc, argv, "--only", NULL);
  FILE *page =
      bench_program(argc, argv, "[--out DIR] [--only QUESTION]", "papers", "The papers' questions");
  int bad = 0;
  for (size_t k = 0; k < sizeof questions / sizeof *questions; k++)
    if (!only || strcmp(only, questions[k].word) == 0) bad |= questions[k].answer(page, out);
  return fclose(page) != 0 || bad;
}
