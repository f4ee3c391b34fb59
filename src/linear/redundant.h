/* redundant.h: takes out of K the joints that follow from others. */
#ifndef DLSI_REDUNDANT_H
#define DLSI_REDUNDANT_H

#include "base/columns.h"

/* K without its redundant joints. */
typedef struct dlsi_apart {
  dls_model model; /* the model itself where it has no joints */
  dlsi_columns K;  /* the arrays of the new K; of a dense one only x */
  int joints;      /* multipliers (base/body.h) */
  int count;       /* of these, of redundant joints: row and column j are 0, K_jj is 1 */
  int *redundant;  /* count: the multipliers j, ascending; NULL where there are no joints */
} dlsi_apart;

/* Takes a checked model, dense or sparse; any other one stays as it is. Ht: m x n, NULL: not known.
 * Of joints that depend on each other those of the first unknowns stay. Where there are joints, a
 * sparse K gets a diagonal entry for each: its pattern does not depend on values. Solve with f_j =
 * 0 at the redundant ones: their multipliers are 0. The caller calls dlsi_apart_free, also after an
 * error: DLS_E_MEMORY, DLS_E_SIZE. */
dls_status dlsi_apart_create(dlsi_apart *apart, const dls_model *model, const dls_sparse *Ht,
                             dls_error *error);
void dlsi_apart_free(dlsi_apart *apart);

#endif
