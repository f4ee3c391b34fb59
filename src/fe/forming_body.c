/*
 * forming_body.c: certifies that the positions of a forming scene are those of a body.
 *
 *   (FB1)  each corner of each element: the cross product of its edges > 0; but a corner whose
 *          three nodes touch one tool may be pressed flat
 *   (FB2)  x >= low, the planes of symmetry and of support; the axis is one of them
 *   (FB3)  no node of the boundary is inside an obstacle, except contacts of that obstacle: they
 *          obey the certificate instead (penalty method: with the depth of its springs)
 *   (FB4)  the boundary does not cross itself
 *
 * (FB1) and (FB4) together make the deformation one to one: positive corners in each element, a
 * simple boundary in the whole. Equilibrium does not ensure that: the elements only look at their
 * Gauss points, where an element that is folded at a corner may be sound.
 *
 * A flat corner: if friction carries the lateral surface up to the ram, its nodes come to lie on
 * the ram one after the other, and so does the edge of the billet between two neighbours. The
 * element there is a triangle with a node on its side. Its Jacobian is positive inside, and so are
 * both triangles of the diagonal from that corner: files hold these two triangles.
 *
 * Cost: O(elements + edges^2), far below an assembly. Lengths are compared with the size of the
 * mesh: rounding of positions passes (FB2) and (FB3).
 */
#include <math.h>
#include <stdio.h>

#include "forming_internal.h"

/* Returns the length below which distances are rounding. */
static double body_blur(const dls_forming *f) {
  return 1e-9 * dlsi_norm2(f->mesh.xy + 2 * (f->mesh.nodes - 1), 2);
}

void dlsi_forming_blame(dls_forming_fault *fault, dls_forming_fault_kind kind, int element,
                        int corner, int node, double value) {
  char *text = fault->text;
  const size_t room = sizeof fault->text;
  *fault = (dls_forming_fault){
      .kind = kind, .element = element, .corner = corner, .node = node, .value = value};
  switch (kind) {
  case DLS_FORMING_NO_FAULT:
    break;
  case DLS_FORMING_CORNER:
    (void)snprintf(text, room, "element %d, corner %d is inside out", element, corner);
    break;
  case DLS_FORMING_SIDE:
    (void)snprintf(text, room, "node %d is beyond the axis or a support by %.3g", node, value);
    break;
  case DLS_FORMING_INSIDE:
    (void)snprintf(text, room, "node %d is inside a tool by %.3g", node, value);
    break;
  case DLS_FORMING_CROSSING:
    (void)snprintf(text, room, "the boundary crosses itself at node %d", node);
    break;
  case DLS_FORMING_BALANCE:
    (void)snprintf(text, room, "the forces on the body do not balance, by %.1e", value);
    break;
  case DLS_FORMING_ENERGY:
    (void)snprintf(text, room, "the energy of the step does not balance, by %.2g", value);
    break;
  case DLS_FORMING_JUMP:
    (void)snprintf(text, room, "the force jumps by %.3g, halves of the step do not", value);
    break;
  case DLS_FORMING_ELEMENT:
    (void)snprintf(text, room, "Newton's method turns element %d inside out", element);
    break;
  case DLS_FORMING_NEWTON:
    (void)snprintf(text, room, "Newton's method leaves %.1e of the forces, most at node %d", value,
                   node);
    break;
  }
}

/* Returns the cross product of b - a and c - a. */
static double body_cross(const double *a, const double *b, const double *c) {
  return (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]);
}

/* Returns the gap of a point from an obstacle at its present place. */
static double body_gap(const dls_forming *f, const dlsi_rigid *rigid, const double *x) {
  const double seen[2] = {x[0] - f->load * rigid->way[0], x[1] - f->load * rigid->way[1]};
  double n[2], curvature;
  return dlsi_obstacle_gap(&rigid->profile, seen, n, &curvature);
}

/* Returns 1 if three nodes touch one obstacle. */
static int body_on_tool(const dls_forming *f, const double *const x[3], double blur) {
  for (int tool = 0; tool < f->rigids; tool++) {
    int touching = 0;
    for (int i = 0; i < 3; i++)
      touching += fabs(body_gap(f, &f->rigid[tool], x[i])) <= blur;
    if (touching == 3) return 1;
  }
  return 0;
}

/* Returns 1 if corner k of element e is right, (FB1), 2 if a tool presses it flat, else 0.
 *   value: out, cross product of its edges */
static int body_corner(const dls_forming *f, int e, int k, double *value) {
  const int *node = f->mesh.node + 4 * e;
  const double *const x[3] = {f->x + 2 * node[k], f->x + 2 * node[(k + 1) % 4],
                              f->x + 2 * node[(k + 3) % 4]};
  *value = body_cross(x[0], x[1], x[2]);
  const double a[2] = {x[1][0] - x[0][0], x[1][1] - x[0][1]};
  const double b[2] = {x[2][0] - x[0][0], x[2][1] - x[0][1]};
  const double blur = body_blur(f), size = fmax(dlsi_norm2(a, 2), dlsi_norm2(b, 2));
  if (*value > blur * size) return 1;
  /* three nodes in line, the corner in the middle */
  if (!(*value < -blur * size) && a[0] * b[0] + a[1] * b[1] < 0 && body_on_tool(f, x, blur))
    return 2;
  return *value > 0;
}

int dlsi_forming_flat_corner(const dls_forming *f, int element) {
  double value;
  for (int k = 0; k < 4; k++)
    if (body_corner(f, element, k, &value) == 2) return k;
  return -1;
}

/* Returns 1 if a node is a candidate for an obstacle. */
static int body_meets(const dls_forming *f, int node, int rigid) {
  for (int c = 0; c < f->nc; c++)
    if (f->candidate[c] == node && f->meets[c] == rigid) return 1;
  return 0;
}

/* Returns 1 if two edges cross or touch. */
static int body_edges_cross(const double *a, const double *b, const double *c, const double *d) {
  for (int i = 0; i < 2; i++)
    if (fmax(a[i], b[i]) < fmin(c[i], d[i]) || fmax(c[i], d[i]) < fmin(a[i], b[i])) return 0;
  return body_cross(a, b, c) * body_cross(a, b, d) <= 0 &&
         body_cross(c, d, a) * body_cross(c, d, b) <= 0;
}

/* Returns the first node of an edge that crosses a later one, -1 if there is none, (FB4). */
static int body_crossing(const dls_forming *f) {
  const int m = f->edges;
  for (int k = 0; k < m; k++)
    for (int l = k + 2; l < m && (k > 0 || l < m - 1); l++) {
      const double *a = f->x + 2 * f->edge[k], *b = f->x + 2 * f->edge[k + 1];
      const double *c = f->x + 2 * f->edge[l], *d = f->x + 2 * f->edge[(l + 1) % m];
      if (body_edges_cross(a, b, c, d)) return f->edge[k];
    }
  return -1;
}

int dlsi_forming_is_body(const dls_forming *f, dls_forming_fault *fault) {
  const double blur = body_blur(f);
  double value;
  for (int e = 0; e < f->mesh.quads; e++)
    for (int k = 0; k < 4; k++)
      if (!body_corner(f, e, k, &value))
        return dlsi_forming_blame(fault, DLS_FORMING_CORNER, e, k, f->mesh.node[4 * e + k], value),
               0;
  for (int i = 0; i < f->n; i++)
    if (!(f->x[i] >= f->low[i % 2] - blur))
      return dlsi_forming_blame(fault, DLS_FORMING_SIDE, -1, -1, i / 2, f->low[i % 2] - f->x[i]), 0;
  for (int k = 0; k < f->edges; k++)
    for (int tool = 0; tool < f->rigids; tool++) {
      const double gap = body_gap(f, &f->rigid[tool], f->x + 2 * f->edge[k]);
      if (!(gap >= -blur) && !body_meets(f, f->edge[k], tool))
        return dlsi_forming_blame(fault, DLS_FORMING_INSIDE, -1, -1, f->edge[k], -gap), 0;
    }
  const int crossing = body_crossing(f);
  if (crossing >= 0) return dlsi_forming_blame(fault, DLS_FORMING_CROSSING, -1, -1, crossing, 0), 0;
  return 1;
}
