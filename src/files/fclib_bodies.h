/* fclib_bodies.h: a global problem of rigid bodies. */
#ifndef DLSI_FCLIB_BODIES_H
#define DLSI_FCLIB_BODIES_H

#include "contact/contact.h"

/* A global problem, and its form for rigid bodies (fclib_bodies.c). */
typedef struct dlsi_fclib_global {
  int d, nc;
  dls_sparse M, HN, HT;
  const double *f, *w; /* n, d nc */
} dlsi_fclib_global;

typedef struct dlsi_fclib_bodies {
  int n, count;
  int *body;     /* NULL: the problem is not one of rigid bodies */
  double *H, *q; /* as in dls_bodies; d nc */
} dlsi_fclib_bodies;

/* Makes *out from a problem whose arrays have been checked. DLS_E_MEMORY. */
dls_status dlsi_fclib_bodies_create(dlsi_fclib_bodies *out, const dlsi_fclib_global *of,
                                    dls_error *error);
void dlsi_fclib_bodies_free(dlsi_fclib_bodies *bodies);

#endif
