/* global_peer.h: the splitting on K as a careful user writes it with CHOLMOD. */
#ifndef GLOBAL_PEER_H
#define GLOBAL_PEER_H

#include "surfaces.h"

/* Solves a scene whose K is regular with friction mu everywhere, until the residuals of positions
 * and forces are at most tol. r: d nc; x: n; *iterations: at most 20000. Returns 0, 1 if it did not
 * come there, -1 on an error. */
int peer_solve(const scene *S, double mu, double tol, double *r, double *x, int *iterations);

#endif
