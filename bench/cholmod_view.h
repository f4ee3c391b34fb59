/*
 * cholmod_view.h: a symmetric K as CHOLMOD takes it, for the peers of the benches.
 */
#ifndef CHOLMOD_VIEW_H
#define CHOLMOD_VIEW_H

#include <cholmod.h>

#include "delassus/matrix.h"

/* Returns the lower triangle K, sharing its arrays. */
static inline cholmod_sparse cholmod_view(const dls_sparse *K) {
  return (cholmod_sparse){.nrow = (size_t)K->rows,
                          .ncol = (size_t)K->cols,
                          .nzmax = (size_t)K->p[K->cols],
                          .p = (void *)(size_t)K->p,
                          .i = (void *)(size_t)K->i,
                          .x = (void *)(size_t)K->x,
                          .stype = -1,
                          .itype = CHOLMOD_INT,
                          .xtype = CHOLMOD_REAL,
                          .dtype = CHOLMOD_DOUBLE,
                          .packed = 1};
}

#endif
