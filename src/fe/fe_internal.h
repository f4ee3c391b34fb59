/*
 * fe_internal.h: what the files of the FE module share. It stands apart from libdelassus, whose
 * hidden functions (but those of status.c, memory.c, file.c) it cannot call.
 */
#ifndef DLSI_FE_INTERNAL_H
#define DLSI_FE_INTERNAL_H

#include "delassus/fe.h"
#include "dlsi.h"

/* Pointers, counts, finite coordinates, node numbers; O(nodes + triangles). */
dls_status dlsi_fe_check_mesh(const char *function, const dls_fe_mesh *mesh, dls_error *error);

/* x (n) is there and finite. */
dls_status dlsi_fe_check_vector(const char *function, const char *argument, const double *x,
                                size_t n, dls_error *error);

#endif
