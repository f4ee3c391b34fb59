/*
 * fe_internal.h: shares meshes and VTK output among the files of the FE module. The module is a
 * library of its own. It may call only those hidden functions of libdelassus that its archive
 * carries (Makefile, FE_OBJ): statuses, allocation, checks, norms, columns, closing of
 * files.
 */
#ifndef DLSI_FE_INTERNAL_H
#define DLSI_FE_INTERNAL_H

#include <stdio.h>

#include "contact/contact.h"
#include "delassus/fe.h"
#include "files/output.h"

/* Checks pointers, counts, finite coordinates and node numbers; O(nodes + triangles). */
dls_status dlsi_fe_check_mesh(const dls_fe_mesh *mesh, dls_error *error);

/* Return the number of elements of a mesh, the corners of each (3 or 4), and those of element e. */
static inline int dlsi_fe_elements(const dls_fe_mesh *mesh) {
  return mesh->triangles != 0 ? mesh->triangles : mesh->quads;
}
static inline int dlsi_fe_corners(const dls_fe_mesh *mesh) {
  return mesh->triangles == 0 && mesh->quads != 0 ? 4 : 3;
}
static inline const int *dlsi_fe_corner(const dls_fe_mesh *mesh, int e) {
  return mesh->triangles != 0 ? mesh->node + 3 * (size_t)e : mesh->quad + 4 * (size_t)e;
}

/* Moduli of linear elasticity: s_ij = l tr(e) 1_ij + 2 G e_ij. */
typedef struct dlsi_lame {
  double l, G;
} dlsi_lame;

/* Parts of the elements (t3.c, quad.c), of element e of a mesh that has been checked, c corners:
 *
 * is_flat    returns 1 for an element that is flat, clockwise or not convex to rounding
 * stiffness  k (2c x 2c, column-major) := the integral of B^T D B
 * mass       m (c x c) := the integrals of rho N_a N_b, per component
 * stress     s (xx, yy, xy) of the displacement u (2 nodes) of the mesh; at the centre of a quad */
int dlsi_t3_is_flat(const dls_fe_mesh *mesh, int e);
int dlsi_quad_is_flat(const dls_fe_mesh *mesh, int e);
void dlsi_t3_stiffness(const dls_fe_mesh *mesh, int e, const dlsi_lame *D, double *k);
void dlsi_quad_stiffness(const dls_fe_mesh *mesh, int e, const dlsi_lame *D, double *k);
void dlsi_t3_mass(const dls_fe_mesh *mesh, int e, double rho, double *m);
void dlsi_quad_mass(const dls_fe_mesh *mesh, int e, double rho, double *m);
void dlsi_t3_stress(const dls_fe_mesh *mesh, int e, const dlsi_lame *D, const double *u, double *s);
void dlsi_quad_stress(const dls_fe_mesh *mesh, int e, const dlsi_lame *D, const double *u,
                      double *s);

/* Adds factor B_i^T D B_j of the hat functions with gradients (b_i, c_i) and (b_j, c_j) to the 2 x
 * 2 block k with leading dimension ld. Blocks (i, j) and (j, i) are transposes to the last bit: l
 * and G multiply after the symmetric products. */
static inline void dlsi_add_elastic(const dlsi_lame *D, double factor, double bi, double ci,
                                    double bj, double cj, double *k, size_t ld) {
  const double bb = bi * bj, bc = bi * cj, cb = ci * bj, cc = ci * cj;
  k[0] += factor * ((D->l + 2 * D->G) * bb + D->G * cc);
  k[1] += factor * (D->l * cb + D->G * bc);
  k[ld] += factor * (D->l * bc + D->G * cb);
  k[ld + 1] += factor * ((D->l + 2 * D->G) * cc + D->G * bb);
}

/* Cells of a grid: cell e has the corners node[end[e - 1]] .. node[end[e] - 1], three (triangle),
 * four (quad) or more (polygon), and the data of cell from[e]. end NULL: `corners` each; from NULL:
 * each its own data. */
typedef struct dlsi_cells {
  int cells, corners;
  const int *node, *end, *from;
} dlsi_cells;

/* Parts of a grid of VTK XML in the order of the file (vtu.c). Numbers are exact: an element
 * that is nearly flat stays the right way round.
 *
 * begin  opens `path` and writes everything up to the data of points
 * plane  one array of the data of points, or the points: vectors x of the plane (2 nodes), which
 *        VTK wants in space
 * cells  ends the data of points, begins the data of cells
 * contact  three arrays of the data of points: "contact", "gap", "slip" of the fields
 * means  one array of the data of cells: the mean over the points of each cell; head: Name and
 *        component attributes; x: components x points x cells
 * tensor  the array "stress": the mean over the points of each cell of x: xx, yy, xy, and zz = nu
 *        (xx + yy) (components = 3), or xx, yy, zz, xy (components = 4)
 * end    everything else: xy (2 nodes); finishes the file */
dls_status dlsi_vtu_begin(dlsi_output *out, const char *path, int nodes, int cells,
                          dls_error *error);
void dlsi_vtu_plane(FILE *file, const char *name, const double *x, int nodes);
void dlsi_vtu_cells(FILE *file);
void dlsi_vtu_means(FILE *file, const char *head, const double *x, int components, int points,
                    const dlsi_cells *cells);
void dlsi_vtu_contact(FILE *file, const dls_fe_fields *fields, int nodes);
void dlsi_vtu_tensor(FILE *file, const double *x, int components, double nu, int points,
                     const dlsi_cells *cells);
dls_status dlsi_vtu_end(dlsi_output *out, const double *xy, int nodes, const dlsi_cells *cells,
                        dls_error *error);

#endif
