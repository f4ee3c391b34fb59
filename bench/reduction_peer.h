/* reduction_peer.h: W without delassus, for an H that picks one unknown per column. */
#ifndef REDUCTION_PEER_H
#define REDUCTION_PEER_H

#include "delassus.h"

/* Computes W = H^T K^-1 H (m x m, columns in the order of dls_contact) by a factorisation and a
 * solve for each column of H: CHOLMOD, supernodal, 64 columns at a time, K as for DLS_CHOLESKY;
 * UMFPACK, one column at a time, K as for DLS_LU. Returns 0 or -1. */
int cholmod_columns(const dls_model *model, double *W);
int umfpack_columns(const dls_model *model, double *W);

/* Times MUMPS and LAPACK alone on the Schur complement of a DLS_CHOLESKY model, in the order that
 * METIS gives the whole graph. before, factor, inverse: CPU seconds of ordering and analysis, of
 * the factorisation, of dpotrf and dpotri. Returns 0 or -1. */
int mumps_schur(const dls_model *model, double *before, double *factor, double *inverse);

/* Returns the unknown that column j of H picks. */
int picked(const dls_model *model, int j);

#endif
