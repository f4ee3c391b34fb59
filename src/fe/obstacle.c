/*
 * obstacle.c: signed distance of a point from a rigid profile of lines and arcs.
 *
 * Each piece is asked for its point nearest to x, on the piece itself: beyond an end that joins the
 * next piece, the end. The nearest piece wins. Where pieces join with one tangent, distance and
 * normal are continuous, whichever of the two wins: a node that passes the joint sees no jump. At a
 * sharp corner the normal jumps.
 */
#include <math.h>

#include "solid.h"

/* Distance from the piece, and n. joined: bit 1 at a, bit 2 at b; reach: |x - nearest point| */
static double project(const dlsi_piece *p, int joined, const double x[2], double n[2],
                      double *reach) {
  double foot[2], gap;
  if (p->side) {
    const double v[2] = {x[0] - p->c[0], x[1] - p->c[1]}, length = hypot(v[0], v[1]);
    n[0] = p->side * v[0] / length;
    n[1] = p->side * v[1] / length;
    gap = p->side * (length - p->radius);
    foot[0] = x[0] - gap * n[0];
    foot[1] = x[1] - gap * n[1];
  } else {
    const double t[2] = {p->b[0] - p->a[0], p->b[1] - p->a[1]}, length = hypot(t[0], t[1]);
    n[0] = -t[1] / length;
    n[1] = t[0] / length;
    gap = n[0] * (x[0] - p->a[0]) + n[1] * (x[1] - p->a[1]);
    foot[0] = x[0] - gap * n[0];
    foot[1] = x[1] - gap * n[1];
  }
  *reach = fabs(gap);
  /* beyond an end, seen along the chord (an arc is less than half a circle where it is joined) */
  const double chord[2] = {p->b[0] - p->a[0], p->b[1] - p->a[1]};
  const double from_a = (foot[0] - p->a[0]) * chord[0] + (foot[1] - p->a[1]) * chord[1];
  const double from_b = (foot[0] - p->b[0]) * chord[0] + (foot[1] - p->b[1]) * chord[1];
  const double *end = (joined & 1) && from_a < 0 ? p->a : (joined & 2) && from_b > 0 ? p->b : NULL;
  if (!end) return gap;
  const double v[2] = {x[0] - end[0], x[1] - end[1]};
  *reach = hypot(v[0], v[1]);
  return gap;
}

double dlsi_obstacle_gap(const dlsi_obstacle *obstacle, const double x[2], double n[2],
                         double *curvature) {
  double best = INFINITY, gap = INFINITY;
  for (int k = 0; k < obstacle->pieces; k++) {
    double m[2], reach;
    const int joined = (k > 0 ? 1 : 0) | (k + 1 < obstacle->pieces ? 2 : 0);
    const double g = project(&obstacle->piece[k], joined, x, m, &reach);
    if (!(reach < best)) continue;
    const dlsi_piece *p = &obstacle->piece[k];
    best = reach;
    *curvature = p->side ? p->side / hypot(x[0] - p->c[0], x[1] - p->c[1]) : 0;
    gap = g;
    n[0] = m[0];
    n[1] = m[1];
  }
  return gap;
}
