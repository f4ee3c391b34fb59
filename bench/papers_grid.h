/*
 * papers_grid.h: elastic boxes of linear or quadratic elements on a rigid plane, in 2D and 3D, with
 * concentrated or weighted reactions.
 */
#ifndef BENCH_PAPERS_GRID_H
#define BENCH_PAPERS_GRID_H

#include "contact/columns.h"
#include "delassus.h"

/* A box and its condensed contact problem; owns all. */
typedef struct grid {
  int d, order;           /* of the elements: 1, 2 */
  int cells[3], nodes[3]; /* elements and nodes along each side; the last side is vertical */
  int unknowns, line;     /* line: nodes of the bottom face, the first of the grid */
  int *unknown;           /* d for each node: number, -1 where it is supported */
  double *f, *mu, *area;  /* area: candidates, length or area to divide r by, for a density */
  int *node;              /* candidates: node */
  int candidates;
  double least; /* entry of P */
  dlsi_columns K, HN, HT, P;
  dls_model model;
  dls_reduction *reduction;
  dls_contact contact;
} grid;

/* Makes the box of Jean's block, width 4, height 4 (3D: depth 4, height 4), E = 260, nu = 0.2,
 * pressure 1 on top and traction 1.8 to 5 on the left side; cells elements along the width, half of
 * them upwards. Returns 0, or -1 after a message. */
int grid_create(grid *g, int d, int order, int cells, int weighted, double mu);
void grid_free(grid *g);

/* Returns coordinate k of a node. */
double grid_coordinate(const grid *g, int node, int k);

#endif
