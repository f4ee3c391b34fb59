/*
 * petsc.c: PETSc with the parallel MUMPS, and delassus, in turns in one process: delassus before
 * MPI_Init, PETSc on all ranks, delassus on rank 0 alone, PETSc once more.
 */
#include <petscksp.h>

#include "unsymmetric.h"

/* Solves a tridiagonal system by PETSc's MUMPS on all ranks. Adds 1 to *wrong unless its
 * residual is <= 1e-10. */
static PetscErrorCode petsc_solves(int *wrong) {
  const PetscInt n = 4000;
  PetscInt first, end;
  PetscReal residual;
  Mat A;
  Vec b, x;
  KSP ksp;
  PC pc;
  PetscCall(MatCreateAIJ(PETSC_COMM_WORLD, PETSC_DECIDE, PETSC_DECIDE, n, n, 3, NULL, 2, NULL, &A));
  PetscCall(MatGetOwnershipRange(A, &first, &end));
  for (PetscInt i = first; i < end; i++) {
    if (i > 0) PetscCall(MatSetValue(A, i, i - 1, -1, INSERT_VALUES));
    if (i < n - 1) PetscCall(MatSetValue(A, i, i + 1, -1, INSERT_VALUES));
    PetscCall(MatSetValue(A, i, i, 2.5, INSERT_VALUES));
  }
  PetscCall(MatAssemblyBegin(A, MAT_FINAL_ASSEMBLY));
  PetscCall(MatAssemblyEnd(A, MAT_FINAL_ASSEMBLY));
  PetscCall(MatCreateVecs(A, &x, &b));
  PetscCall(VecSet(b, 1));
  PetscCall(KSPCreate(PETSC_COMM_WORLD, &ksp));
  PetscCall(KSPSetOperators(ksp, A, A));
  PetscCall(KSPSetType(ksp, KSPPREONLY));
  PetscCall(KSPGetPC(ksp, &pc));
  PetscCall(PCSetType(pc, PCLU));
  PetscCall(PCFactorSetMatSolverType(pc, MATSOLVERMUMPS));
  PetscCall(KSPSolve(ksp, b, x));
  PetscCall(MatMult(A, x, b));
  PetscCall(VecShift(b, -1));
  PetscCall(VecNorm(b, NORM_2, &residual));
  if (!(residual <= 1e-10)) {
    PetscCall(PetscPrintf(PETSC_COMM_WORLD, "PETSc's MUMPS: residual %g\n", (double)residual));
    ++*wrong;
  }
  PetscCall(KSPDestroy(&ksp));
  PetscCall(VecDestroy(&b));
  PetscCall(VecDestroy(&x));
  PetscCall(MatDestroy(&A));
  return 0;
}

int main(int argc, char **argv) {
  int rank, wrong = unsymmetric_wrong();
  PetscCall(PetscInitialize(&argc, &argv, NULL, NULL));
  MPI_Comm_rank(PETSC_COMM_WORLD, &rank);
  PetscCall(petsc_solves(&wrong));
  if (rank == 0) wrong += unsymmetric_wrong();
  MPI_Barrier(PETSC_COMM_WORLD);
  PetscCall(petsc_solves(&wrong));
  PetscCall(PetscFinalize());
  return wrong;
}
