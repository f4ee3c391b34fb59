/* dissection.h: orders the unknowns of a sparse symmetric pattern for little fill (METIS). */
#ifndef DLSI_DISSECTION_H
#define DLSI_DISSECTION_H

#include <stddef.h>

#include "delassus/status.h"

/* Orders the unknowns of the graph of the entries (row[k], col[k]), k < entries, counted from 1.
 * order: receives them, counted from 0, in the order of their elimination, n. DLS_E_MEMORY. */
dls_status dlsi_dissection(int n, size_t entries, const int *row, const int *col, int *order,
                           dls_error *error);

#endif
