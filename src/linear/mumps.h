/*
 * mumps.h: what sparse_lu.c and reduction/schur.c ask of MUMPS alike. Codes, ICNTL and INFOG as the
 * users' guide of MUMPS 5.5 numbers them. Nothing is printed.
 */
#ifndef DLSI_MUMPS_H
#define DLSI_MUMPS_H

#include <dmumps_c.h>

#define ICNTL(k) icntl[(k)-1]
#define INFOG(k) infog[(k)-1]

/* jobs, and the values of INFOG(1) that mean something here */
enum { start = -1, end = -2, analyse = 1, factorise = 2, solve = 3 };
enum { singular_structure = -6, singular = -10, small_integers = -8, small_reals = -9 };

/* INFOG(1): < 0 for an error */
static inline int dlsi_mumps_run(DMUMPS_STRUC_C *M, int job) {
  M->job = job;
  dmumps_c(M);
  return M->INFOG(1);
}

/* M is all zero; sym as in the guide. 0 if it cannot start. */
static inline int dlsi_mumps_start(DMUMPS_STRUC_C *M, int sym) {
  enum { sequential_world = -987654 };
  M->par = 1;
  M->sym = sym;
  M->comm_fortran = sequential_world;
  if (dlsi_mumps_run(M, start) < 0) return 0;
  for (int k = 1; k <= 3; k++)
    M->ICNTL(k) = -1; /* no output unit for errors, warnings, statistics */
  M->ICNTL(4) = 0;
  return 1;
}

/* INFOG(1). Pivoting may take more room than was foreseen, by ICNTL(14) per cent: more is foreseen. */
static inline int dlsi_mumps_factor(DMUMPS_STRUC_C *M) {
  enum { most_relaxation = 1000 };
  const int usual = M->ICNTL(14);
  double *const schur = M->schur;
  int info;
  for (;;) {
    M->schur = schur;
    info = dlsi_mumps_run(M, factorise);
    if (info != small_integers && info != small_reals) break;
    if (M->ICNTL(14) >= most_relaxation) break;
    M->ICNTL(14) *= 2;
  }
  M->ICNTL(14) = usual;
  return info;
}

#endif
