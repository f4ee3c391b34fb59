/* motion_peer.h: a solve by CHOLMOD, used by no other file of bench/motion. */
#ifndef MOTION_PEER_H
#define MOTION_PEER_H

#include "delassus.h"

/* A factor of K in one of two forms, and room for a solve, kept over the steps. */
typedef struct peer peer;

/* Factors K, whose lower triangle is given, in the order that CHOLMOD chooses. supernodal: 1 or 0.
 * Returns NULL if it fails. *seconds: CPU of analysis and factorisation. */
peer *peer_create(const dls_sparse *K, int supernodal, double *seconds);

/* Solves x := K^-1 b; returns x (n), which lives until the next call, or NULL. */
const double *peer_solve(peer *p, const double *b);

void peer_destroy(peer *p);

#endif
