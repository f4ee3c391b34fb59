/* equilibrate.h: row and column factors. */
#ifndef DLSI_EQUILIBRATE_H
#define DLSI_EQUILIBRATE_H

#include "base/base.h"

/* R, C (n): powers of two that bring the largest entry of each row and column of R K C near 1, one of
 * several equal entries counting as one. symmetric: R = C, the entries above the diagonal are passed
 * over. room (2 n) */
void dlsi_find_scales(const dls_sparse *K, int symmetric, double *R, double *C, double *room);

#endif
