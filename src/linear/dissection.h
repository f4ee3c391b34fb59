/* dissection.h: a fill-reducing order of a sparse symmetric pattern (METIS). */
#ifndef DLSI_DISSECTION_H
#define DLSI_DISSECTION_H

#include <stddef.h>

#include "delassus/status.h"

/* order (n): receives the unknowns of the graph of the entries (row[k], col[k]), k < entries, in the
 * order of their elimination. Numbers in row and col begin with 1. DLS_E_MEMORY. */
dls_status dlsi_dissection(int n, size_t entries, const int *row, const int *col, int *order,
                           dls_error *error);

#endif
