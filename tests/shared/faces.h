/* faces.h: the weighting P of a rectangular grid of four-node or nine-node faces. */
#ifndef FACES_H
#define FACES_H

/* A side of the grid: its nodes, as for dls_weighting_line (order 1) or dls_weighting_quadratic
 * (order 2). */
typedef struct face_line {
  int order, nodes;
  const double *s;      /* nodes: abscissae */
  const int *candidate; /* nodes; NULL: all */
} face_line;

/* Fills the Kronecker product of the P of two lines. Node (a, b) has the number a + b A, A the
 * nodes of the first line; candidates are numbered in the same way. A line of 1 node has the P 1.
 *   p, i, x   columns of P, compressed, for N nodes: room for N + 1, 16 N, 16 N
 *   area      measure of each cell, room for N
 * Returns the number of candidates, or -1: the lines are refused, or there is no memory. */
int faces_weighting(const face_line *first, const face_line *second, int *p, int *i, double *x,
                    double *area);

#endif
