/*
 * obstacle.c: measures the signed distance of a point from a rigid profile of lines and arcs.
 *
 *   (OB1)  for each piece: distance to its line or circle, and the nearest point of the piece
 *          itself: beyond an end that joins another piece the nearest point is the end
 *   (OB2)  the piece with the nearest point wins, the first of two with the same nearest point
 *   (OB3)  beyond the centre the circle's nearest point lies across from the arc: the tangents at
 *          the ends of the arc replace it there
 *
 * If pieces join with one tangent, distance and normal are continuous whichever piece wins: a node
 * that passes the joint sees no jump. At a sharp corner the normal jumps, and beyond both pieces
 * the distance is that to the winner's line, not to the corner.
 */
#include <math.h>

#include "solid.h"

/* Returns the distance of x from the line or circle of a piece.
 *   joined: in, bit 1 if end a joins another piece, bit 2 if end b does
 *   n: out, unit normal towards the body, 2
 *   curvature: out; reach: out, |x - nearest point of the piece| */
static double obstacle_project(const dlsi_piece *p, int joined, const double x[2], double n[2],
                               double *curvature, double *reach) { /* (OB1) */
  const double chord[2] = {p->b[0] - p->a[0], p->b[1] - p->a[1]};
  double gap;
  *curvature = 0;
  if (p->side) {
    const double v[2] = {x[0] - p->c[0], x[1] - p->c[1]}, length = hypot(v[0], v[1]);
    const double bulge[2] = {(p->a[0] + p->b[0]) / 2 - p->c[0], (p->a[1] + p->b[1]) / 2 - p->c[1]};
    if (joined && !(v[0] * bulge[0] + v[1] * bulge[1] > 0)) { /* (OB3) */
      const double from[2] = {hypot(x[0] - p->a[0], x[1] - p->a[1]),
                              hypot(x[0] - p->b[0], x[1] - p->b[1])};
      const double *end = from[0] < from[1] ? p->a : p->b;
      for (int i = 0; i < 2; i++)
        n[i] = p->side * (end[i] - p->c[i]) / p->radius;
      *reach = fmin(from[0], from[1]);
      return n[0] * (x[0] - end[0]) + n[1] * (x[1] - end[1]);
    }
    *curvature = p->side / length;
    n[0] = p->side * v[0] / length;
    n[1] = p->side * v[1] / length;
    gap = p->side * (length - p->radius);
  } else {
    const double length = hypot(chord[0], chord[1]);
    n[0] = -chord[1] / length;
    n[1] = chord[0] / length;
    gap = n[0] * (x[0] - p->a[0]) + n[1] * (x[1] - p->a[1]);
  }
  const double foot[2] = {x[0] - gap * n[0], x[1] - gap * n[1]};
  /* beyond an end, seen along the chord (an arc is less than half a circle where it is joined) */
  const double from_a = (foot[0] - p->a[0]) * chord[0] + (foot[1] - p->a[1]) * chord[1];
  const double from_b = (foot[0] - p->b[0]) * chord[0] + (foot[1] - p->b[1]) * chord[1];
  const double *end = (joined & 1) && from_a < 0 ? p->a : (joined & 2) && from_b > 0 ? p->b : NULL;
  *reach = end ? hypot(x[0] - end[0], x[1] - end[1]) : fabs(gap);
  return gap;
}

double dlsi_obstacle_gap(const dlsi_obstacle *obstacle, const double x[2], double n[2],
                         double *curvature) {
  double best = INFINITY, gap = INFINITY;
  for (int k = 0; k < obstacle->pieces; k++) {
    const dlsi_piece *p = &obstacle->piece[k];
    const int joined = (k > 0 ? 1 : 0) | (k + 1 < obstacle->pieces ? 2 : 0);
    double m[2], bend, reach;
    const double g = obstacle_project(p, joined, x, m, &bend, &reach);
    if (!(reach < best)) continue; /* (OB2) */
    best = reach;
    *curvature = bend;
    gap = g;
    n[0] = m[0];
    n[1] = m[1];
  }
  return gap;
}
