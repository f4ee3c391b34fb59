/*
 * fe_internal.h: shares meshes and VTK output among the files of the FE module. The module is a
 * library of its own; of libdelassus' hidden functions it may call those of the objects that its
 * archive carries (Makefile, FE_OBJ): statuses, allocation, checks, norms, closing of files.
 */
#ifndef DLSI_FE_INTERNAL_H
#define DLSI_FE_INTERNAL_H

#include <stdio.h>

#include "base/base.h"
#include "delassus/fe.h"

/* Checks pointers, counts, finite coordinates and node numbers; O(nodes + triangles). */
dls_status dlsi_fe_check_mesh(const dls_fe_mesh *mesh, dls_error *error);

/* Places node i + j (nx + 1) at (i lx / nx, j ly / ny). xy: out, 2 (nx + 1) (ny + 1). */
void dlsi_fe_grid(double lx, double ly, int nx, int ny, double *xy);

/* Cells of a grid: cell e has the corners node[end[e - 1]] .. node[end[e] - 1], three (triangle),
 * four (quad) or more (polygon), and the data of cell from[e]; end and from NULL: triangles, each
 * with its own data. */
typedef struct dlsi_cells {
  int cells;
  const int *node, *end, *from;
} dlsi_cells;

/* Parts of a grid of VTK XML in the order of the file (vtu.c); numbers have `digits` digits.
 *
 * begin  opens `path` and writes everything up to the data of points; NULL and *error on failure
 * plane  one array of the data of points, or the points: vectors x of the plane (2 nodes), which
 *        VTK wants in space
 * cells  ends the data of points, begins the data of cells
 * means  one array of the data of cells: the mean over the points of each cell; head: Name and
 *        component attributes; x: components x points x cells
 * end    everything else: xy (2 nodes); closes the file */
FILE *dlsi_vtu_begin(const char *path, int nodes, int cells, dls_error *error);
void dlsi_vtu_plane(FILE *file, const char *name, const double *x, int nodes, int digits);
void dlsi_vtu_cells(FILE *file);
void dlsi_vtu_means(FILE *file, const char *head, const double *x, int components, int points,
                    const dlsi_cells *cells, int digits);
dls_status dlsi_vtu_end(const char *path, FILE *file, const double *xy, int nodes,
                        const dlsi_cells *cells, int digits, dls_error *error);

#endif
