/* fclib_joints.h: a global problem with joints as one with multipliers in K, and back. */
#ifndef DLSI_FCLIB_JOINTS_H
#define DLSI_FCLIB_JOINTS_H

#include "contact/columns.h"

/* *M := (M -G; -G^T 0) of M (n x n) and G (n x p). Unchanged after DLS_E_MEMORY, DLS_E_SIZE. */
dls_status dlsi_fclib_join(dlsi_triplets *M, const dlsi_triplets *G, dls_error *error);

/* The parts of such a K. */
typedef struct dlsi_fclib_split {
  int positions, joints; /* joints: 0 if K has not this form; then all else is empty */
  int *order;            /* n: the positions, then the multipliers */
  dlsi_columns M, G, H;
} dlsi_fclib_split;

/* Takes all entries of K (n x n) and of H (n x m). The caller calls dlsi_fclib_split_free, also
 * after an error: DLS_E_MEMORY. */
dls_status dlsi_fclib_split_create(dlsi_fclib_split *out, const dls_sparse *K, const dls_sparse *H,
                                   dls_error *error);
void dlsi_fclib_split_free(dlsi_fclib_split *split);

#endif
