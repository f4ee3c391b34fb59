/* redundant.h: takes out of K the joints that follow from other joints. */
#ifndef DLSI_REDUNDANT_H
#define DLSI_REDUNDANT_H

#include "contact/columns.h"

/* K without its redundant joints. */
typedef struct dlsi_apart {
  dls_model model; /* the model itself where it has no joints */
  dlsi_columns K;  /* the arrays of the new K; of a dense one only x */
  int joints;      /* multipliers (base/body.h) */
  int count;       /* redundant joints among them: row and column j are 0, K_jj is 1 */
  int *redundant;  /* count: the multipliers j, ascending; NULL where there are no joints */
} dlsi_apart;

/* Takes the redundant joints out of a checked model with dense or sparse K; other models stay
 * unchanged. Ht: m x n, or NULL if it is not known. Of joints that depend on each other it keeps
 * those of the first unknowns. A sparse K gets a diagonal entry for each joint, so that its pattern
 * does not depend on values. Solve with f_j = 0 at the redundant joints; their multipliers are 0.
 * Call dlsi_apart_free, also after an error. DLS_E_MEMORY, DLS_E_SIZE. */
dls_status dlsi_apart_create(dlsi_apart *apart, const dls_model *model, const dls_sparse *Ht,
                             dls_error *error);
void dlsi_apart_free(dlsi_apart *apart);

#endif
