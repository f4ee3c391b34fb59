/* direct.h: the ways to W that a user has without delassus, for H that picks one unknown a column. */
#ifndef DIRECT_H
#define DIRECT_H

#include "delassus.h"

/* W (m x m) := H^T K^-1 H by solving for `batch` columns of H at once (0: all); order of the columns as
 * in dls_contact. 0, or -1. */
int cholmod_columns(const dls_model *model, int batch, double *W);
int umfpack_columns(const dls_model *model, int batch, double *W);

/* MUMPS and LAPACK alone on the Schur complement of a DLS_CHOLESKY model, METIS's order of the whole
 * graph given: *factor := CPU seconds of the factorisation, *inverse := of dpotrf and dpotri, *before :=
 * of ordering and analysis. 0, or -1. */
int mumps_schur(const dls_model *model, double *before, double *factor, double *inverse);

/* The unknown that column j of H picks. */
int picked(const dls_model *model, int j);

#endif
