/*
 * forming_tools.c: names the tools that press on the body, sums up their forces, and draws them.
 *
 *   indentation   cylinder, symmetry (support of x), floor (support of y)
 *   extrusion     container and die (one profile), ram, axis (support of x)
 *
 * A force is the sum of the reactions of the candidates and of the supports, F - H r. In an
 * axisymmetric body the radial forces of a ring balance by themselves: only axial forces add up to
 * zero.
 */
#include <math.h>
#include <string.h>

#include "forming_internal.h"

enum { cylinder = 0, symmetry = 1, ground = 2, container = 0, axis = 1, ram = 2, die = 3 };

/* Returns the tool of a candidate. */
static int tool_of(const dls_forming *f, int c) {
  if (!f->axisymmetric) return cylinder;
  if (f->meets[c]) return ram;
  return f->normal[2 * c + 1] == 0 ? container : die;
}

void dlsi_forming_press(dls_forming *f) {
  dls_forming_data *d = &f->data;
  double sum[2] = {0}, sizes[2] = {0};
  for (int k = 0; k < d->tools; k++)
    f->tool[k].force[0] = f->tool[k].force[1] = 0;
  for (int c = 0; c < f->nc; c++) {
    f->candidate_tool[c] = tool_of(f, c);
    for (int i = 0; i < 2; i++)
      f->tool[f->candidate_tool[c]].force[i] +=
          f->normal[2 * c + i] * f->r[2 * c] + f->tangent[2 * c + i] * f->r[2 * c + 1];
  }
  for (int i = 0; i < f->n; i++) /* supports are the tools 1 and 2 */
    if (f->fixed[i]) f->tool[1 + i % 2].force[i % 2] += f->F[i] - f->reaction[i];
  for (int k = 0; k < d->tools; k++)
    for (int i = 0; i < 2; i++) {
      sum[i] += f->tool[k].force[i];
      sizes[i] += fabs(f->tool[k].force[i]);
    }
  d->balance = sizes[1] > 0 ? fabs(sum[1]) / sizes[1] : 0;
  const double size = sizes[0] + sizes[1];
  if (!f->axisymmetric && size > 0) d->balance = hypot(sum[0], sum[1]) / size;
}

/* ---- outlines -------------------------------------------------------------------------------- */

/* Adds a point to the outline of a tool. */
static void tool_add(dls_forming *f, int tool, double x, double y) {
  double *at = f->outline[tool] + 2 * f->tool[tool].points++;
  at[0] = x;
  at[1] = y;
}

/* Adds a rectangle. */
static void tool_rectangle(dls_forming *f, int tool, const double lo[2], const double hi[2]) {
  tool_add(f, tool, lo[0], lo[1]);
  tool_add(f, tool, hi[0], lo[1]);
  tool_add(f, tool, hi[0], hi[1]);
  tool_add(f, tool, lo[0], hi[1]);
}

/* Draws the half of the cylinder that is on the side of the body, and a slab under it. */
static void tool_draw_indentation(dls_forming *f, const double size[2]) {
  enum { arcs = 48 };
  const dlsi_piece *p = f->rigid[0].piece;
  for (int k = 0; k <= arcs; k++) {
    const double a = acos(-1) * ((double)k / arcs - 0.5);
    tool_add(f, cylinder, p->c[0] + p->radius * cos(a), p->c[1] + p->radius * sin(a));
  }
  tool_rectangle(f, ground, (double[2]){0, -0.1 * size[1]}, (double[2]){1.3 * size[0], 0});
}

/* Draws sections of the tools: walls a fifth of the billet's radius thick, the ram as a moving
 * plate, the die as long as the billet becomes. */
static void tool_draw_extrusion(dls_forming *f, const double size[2]) {
  enum { arcs = 8 };
  const dlsi_piece *cone = f->rigid[0].piece, *arc = cone + 1, *wall = cone + 2;
  const double outside = 1.2 * size[0], L = size[1], thick = 0.2 * size[0];
  const double way = f->load * f->rigid[1].way[1];
  tool_rectangle(f, container, wall->a, (double[2]){outside, L + thick});
  tool_rectangle(f, ram, (double[2]){0, L + way}, (double[2]){size[0], L + way + thick});
  double end[2];
  for (int i = 0; i < 2; i++)
    end[i] = cone->b[i] + 1.25 * (cone->a[i] - cone->b[i]);
  tool_add(f, die, end[0], end[1]);
  tool_add(f, die, outside, end[1]);
  tool_add(f, die, outside, wall->a[1]);
  for (int k = 0; k <= arcs; k++) { /* from b of the arc to its a */
    const double s = (double)k / arcs;
    double v[2];
    for (int i = 0; i < 2; i++)
      v[i] = (1 - s) * (arc->b[i] - arc->c[i]) + s * (arc->a[i] - arc->c[i]);
    const double stretch = arc->radius / hypot(v[0], v[1]);
    tool_add(f, die, arc->c[0] + stretch * v[0], arc->c[1] + stretch * v[1]);
  }
}

void dlsi_forming_move_tools(dls_forming *f) {
  static const char *const indentation[] = {"cylinder", "symmetry", "floor"};
  static const char *const extrusion[] = {"container", "axis", "ram", "die"};
  const double *size = f->mesh.xy + 2 * (f->mesh.nodes - 1); /* the corner opposite to the origin */
  f->data.tools = f->axisymmetric ? 4 : 3;
  f->data.tool = f->tool;
  for (int k = 0; k < f->data.tools; k++) {
    f->tool[k].name = f->axisymmetric ? extrusion[k] : indentation[k];
    f->tool[k].points = 0;
    f->tool[k].outline = f->outline[k];
  }
  if (f->axisymmetric)
    tool_draw_extrusion(f, size);
  else
    tool_draw_indentation(f, size);
  const double *way = f->rigid[0].way; /* of the cylinder; container and die do not move */
  for (int i = 0; i < 2 * f->tool[0].points; i++)
    f->outline[0][i] += f->load * way[i % 2];
}
