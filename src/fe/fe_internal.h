/*
 * fe_internal.h: what the files of the FE module share. It stands apart from libdelassus, whose
 * hidden functions (but those of status.c, memory.c, file.c) it cannot call.
 */
#ifndef DLSI_FE_INTERNAL_H
#define DLSI_FE_INTERNAL_H

#include <stdio.h>

#include "base/base.h"
#include "delassus/fe.h"

/* Pointers, counts, finite coordinates, node numbers; O(nodes + triangles). */
dls_status dlsi_fe_check_mesh(const dls_fe_mesh *mesh, dls_error *error);

/* x (n) is there and finite. */
dls_status dlsi_fe_check_vector(const char *argument, const double *x, size_t n, dls_error *error);

/* Parts of a grid of VTK XML (vtu.c): the head up to the data of points; x, points in the plane or
 * vectors there, as VTK wants them, in space; and the end from the data of cells on: xy (2 nodes), node
 * (corners of each cell, 3 or 4). Numbers with `digits` of them. */
void dlsi_vtu_begin(FILE *file, int nodes, int cells);
void dlsi_vtu_plane(FILE *file, const char *name, const double *x, int nodes, int digits);
void dlsi_vtu_end(FILE *file, const double *xy, int nodes, const int *node, int corners, int cells,
                  int digits);

#endif
