/* equilibrate.h: finds factors for the rows and columns of a sparse matrix. */
#ifndef DLSI_EQUILIBRATE_H
#define DLSI_EQUILIBRATE_H

#include "contact/contact.h"

/* Finds powers of two that bring the largest entry of each row and column of R K C near 1. Entries
 * in one place count separately. symmetric: 1 gives R = C and skips the entries above the diagonal.
 * R, C: n; scratch: 2 n. */
void dlsi_find_scales(const dls_sparse *K, int symmetric, double *R, double *C, double *scratch);

#endif
