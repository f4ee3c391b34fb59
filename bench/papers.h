/*
 * papers.h: shared by the files of bench/papers: the block of Jean, a question each.
 */
#ifndef BENCH_PAPERS_H
#define BENCH_PAPERS_H

#include <stdio.h>

#include "delassus.h"
#include "delassus/fe.h"

/* A block of Jean with its condensed contact problem; owns all three. */
typedef struct jean_block {
  dls_fe_scene *scene;
  dls_fe_scene_data data;
  dls_reduction *reduction;
  dls_contact contact;
} jean_block;

/* Makes the scene `name` on nx x nx/2 rectangles; mu < 0: the scene's own. Returns 0, or -1 after a
 * message. */
int jean_create(jean_block *b, const char *name, int weighted, int nx, double mu);
void jean_free(jean_block *b);

/* Solves by auto to 1e-13. Returns an array (m) to free, or NULL after a message. */
double *jean_solve(const dls_contact *contact);

/* Copies a temporary file of table rows to the page, and closes it. */
void table_copy(FILE *from, FILE *page);

/* 0: the library's radial return (12) of forming scenes; 1: the exponential return of (6). Read by
 * dlsi_solid_update of this program, which stands in the place of the library's. */
extern int papers_exponential;

/* The questions. Each writes its data into out/papers_NAME*.csv and its paragraph into the page.
 * Returns 0, or 1 after a message. */
int papers_reactions(FILE *page, const char *out);
int papers_refinement(FILE *page, const char *out);
int papers_aitken(FILE *page, const char *out);
int papers_penalty(FILE *page, const char *out);
int papers_lemke(FILE *page, const char *out);
int papers_flow(FILE *page, const char *out);
int papers_weighting(FILE *page, const char *out);

#endif
