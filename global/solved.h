/* solved.h: gives the front what it needs to know of the last solve on K. */
#ifndef DLSI_SOLVED_H
#define DLSI_SOLVED_H

#include "delassus/global.h"

/* Returns 1 if the certificate is of the split problem (loads.c), which x in doubles hides. */
int dlsi_global_is_split(const dls_global *global);

/* unread: 1: the next solves leave info->error 0, which takes a factorisation. */
void dlsi_global_leave_error(dls_global *global, int unread);

/* Returns how many Newton steps from scattered states it took (scatter.c); *before := the residual
 * before them. */
int dlsi_global_scattered(const dls_global *global, double *before);

#endif
