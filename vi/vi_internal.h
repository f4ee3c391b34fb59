/* vi_internal.h: what the files of vi/ share. */
#ifndef VI_INTERNAL_H
#define VI_INTERNAL_H

#include "delassus/nlgs.h"

/* dls_nlgs_local without the count, for the sweep. W is d x d, column-major, leading dimension d.
 * guess (3D): where to look first for l >= 0 in u_t = -l r_t, such as |u_t| / |r_t| before; 0 for none. */
dls_local_state dlsi_local_2d(const double *W, const double *q, double mu, double *r);
dls_local_state dlsi_local_3d(const double *W, const double *q, double mu, double guess, double *r);

#endif
