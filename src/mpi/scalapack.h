/*
 * scalapack.h: the only file that declares BLACS, PBLAS and ScaLAPACK. A descriptor `desc` is nine
 * ints (descinit_). Character arguments of ScaLAPACK carry no hidden lengths that it reads.
 */
#ifndef DLSI_SCALAPACK_H
#define DLSI_SCALAPACK_H

#include <mpi.h>

int Csys2blacs_handle(MPI_Comm comm);
void Cfree_blacs_system_handle(int handle);
void Cblacs_gridinit(int *context, const char *order, int rows, int cols);
void Cblacs_gridexit(int context);

int numroc_(const int *n, const int *block, const int *process, const int *first,
            const int *processes);
void descinit_(int *desc, const int *m, const int *n, const int *mb, const int *nb, const int *row,
               const int *col, const int *context, const int *ld, int *info);

void pdpotrf_(const char *uplo, const int *n, double *a, const int *ia, const int *ja,
              const int *desc, int *info);
void pdpotri_(const char *uplo, const int *n, double *a, const int *ia, const int *ja,
              const int *desc, int *info);
void pdgetrf_(const int *m, const int *n, double *a, const int *ia, const int *ja, const int *desc,
              int *pivot, int *info);
void pdgetri_(const int *n, double *a, const int *ia, const int *ja, const int *desc,
              const int *pivot, double *work, const int *lwork, int *iwork, const int *liwork,
              int *info);
void pdtran_(const int *m, const int *n, const double *alpha, const double *a, const int *ia,
             const int *ja, const int *desca, const double *beta, double *c, const int *ic,
             const int *jc, const int *descc);

#endif
