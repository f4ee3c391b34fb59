/*
 * mumps.h: calls MUMPS for sparse_lu.c and schur.c. Codes, ICNTL and INFOG are numbered as in the
 * users' guide of MUMPS 5.5. Nothing is printed. MUMPS keeps state of its own during a call: only
 * one thread at a time may call it.
 */
#ifndef DLSI_MUMPS_H
#define DLSI_MUMPS_H

#include <dmumps_c.h>

#include "contact/contact.h"

/* The sequential MUMPS is part of libdelassus under this name, and all its other names are local:
 * the host may have another MUMPS, and an MPI (Makefile). src/mpi calls the parallel one. */
#ifdef DLSI_MPI
#define dlsi_dmumps dmumps_c
#else
void dlsi_dmumps(DMUMPS_STRUC_C *M);
#endif

/* the one communicator of the sequential MUMPS */
enum { mumps_alone = -987654 };

#define ICNTL(k) icntl[(k)-1]
#define INFOG(k) infog[(k)-1]

/* jobs, and the values of INFOG(1) that are used here */
enum { start = -1, end = -2, analyse = 1, factorise = 2, solve = 3 };
enum { singular_structure = -6, singular = -10, small_integers = -8, small_reals = -9 };

/* Runs a job; returns INFOG(1) as a status, under the name of the matrix. */
static inline dls_status dlsi_mumps_run(DMUMPS_STRUC_C *M, int job, const char *matrix,
                                        dls_error *error) {
  M->job = job;
  dlsi_lock();
  dlsi_dmumps(M);
  dlsi_unlock();
  const int info = M->INFOG(1);
  if (info >= 0) return DLS_OK;
  if (info == singular || info == singular_structure)
    return dlsi_fail(error, DLS_E_SINGULAR, matrix, -1, 0, "singular: a pivot of 0");
  return dlsi_fail(error, DLS_E_MEMORY, "", -1, info, "out of memory in MUMPS, its codes %d, %d",
                   info, M->INFOG(2));
}

/* Starts M, which is all zero. sym: the kind of symmetry, as in the guide; comm: the communicator,
 * Fortran's number of it. */
static inline dls_status dlsi_mumps_start(DMUMPS_STRUC_C *M, int sym, int comm, dls_error *error) {
  M->par = 1;
  M->sym = sym;
  M->comm_fortran = comm;
  const dls_status status = dlsi_mumps_run(M, start, "", error);
  for (int k = 1; k <= 3; k++)
    M->ICNTL(k) = -1; /* no output unit for errors, warnings, statistics */
  M->ICNTL(4) = 0;
  return status;
}

static inline void dlsi_mumps_end(DMUMPS_STRUC_C *M) {
  (void)dlsi_mumps_run(M, end, "", NULL);
}

/* Factors. If pivoting takes more room than the estimate plus ICNTL(14) per cent, raises ICNTL(14)
 * and tries again. */
static inline dls_status dlsi_mumps_factor(DMUMPS_STRUC_C *M, const char *matrix,
                                           dls_error *error) {
  enum {
    most_relaxation = 50000
  }; /* per cent: of a sparse matrix whose pivots all wait for the last front */
  const int usual = M->ICNTL(14);
  double *const schur = M->schur;
  dls_status status;
  for (;;) {
    M->schur = schur;
    status = dlsi_mumps_run(M, factorise, matrix, error);
    if (M->INFOG(1) != small_integers && M->INFOG(1) != small_reals) break;
    if (M->ICNTL(14) >= most_relaxation) break;
    M->ICNTL(14) *= 2;
  }
  M->ICNTL(14) = usual;
  return status;
}

/* Solves with X (n x nrhs) in place. */
static inline dls_status dlsi_mumps_solve(DMUMPS_STRUC_C *M, double *X, int nrhs,
                                          dls_error *error) {
  M->rhs = X;
  M->nrhs = nrhs;
  M->lrhs = M->n;
  return dlsi_mumps_run(M, solve, "", error);
}

#endif
