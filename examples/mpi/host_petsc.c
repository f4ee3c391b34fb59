/* host_petsc.c: PETSc as the host on several ranks: the rows of a distributed Mat go over as they
 * are owned, and PETSc's own KSP answers K x = f + H r beside dls_mpi_reduction_recover. A cube of
 * 10^3 nodes joined by springs, its top held by soft ones, stands on a rough floor and is pushed
 * near one edge of it.
 *
 * mpirun -np 4 build/examples/mpi/host_petsc
 * Output:
 *   3000 unknowns, 100 contact nodes: solved
 *   force of the floor: normal 844.8, shear along the push -182.9
 *   x of PETSc's solver agrees to 1e-8: yes
 */
#include <petscksp.h>
#include <stdio.h>

#include "delassus/mpi.h"

enum { side = 10, layer = side * side, n = 3 * layer * side };

/* Assembles K and f; the nodes are numbered layer by layer from the floor. */
static PetscErrorCode host_assemble(Mat *K, Vec *f, int *first, int *end) {
  const int step[] = {1, side, layer};
  PetscCall(MatCreateAIJ(PETSC_COMM_WORLD, PETSC_DECIDE, PETSC_DECIDE, n, n, 7, NULL, 6, NULL, K));
  PetscCall(MatGetOwnershipRange(*K, first, end));
  PetscCall(MatCreateVecs(*K, f, NULL));
  for (int j = *first; j < *end; j++) {
    const int node = j / 3, at[] = {node % side, node / side % side, node / layer};
    double diagonal = at[2] == side - 1 ? 0.05 : 0;
    for (int k = 0; k < 3; k++)
      for (int way = -1; way <= 1; way += 2) {
        if (at[k] + way < 0 || at[k] + way >= side) continue;
        diagonal += 1;
        PetscCall(MatSetValue(*K, j, j + 3 * way * step[k], -1, INSERT_VALUES));
      }
    PetscCall(MatSetValue(*K, j, j, diagonal, INSERT_VALUES));
    const double push = j % 3 == 0 && at[2] == 1 && at[1] == 0 ? 20 : 0;
    PetscCall(VecSetValue(*f, j, j % 3 == 2 ? -1 : push, INSERT_VALUES));
  }
  PetscCall(MatAssemblyBegin(*K, MAT_FINAL_ASSEMBLY));
  PetscCall(MatAssemblyEnd(*K, MAT_FINAL_ASSEMBLY));
  PetscCall(VecAssemblyBegin(*f));
  PetscCall(VecAssemblyEnd(*f));
  return 0;
}

/* Copies the rows first .. end-1 of K as entries; returns how many. */
static size_t take_rows(Mat K, int first, int end, int *row, int *col, double *x) {
  size_t count = 0;
  for (int i = first; i < end; i++) {
    int entries;
    const int *at;
    const double *value;
    if (MatGetRow(K, i, &entries, &at, &value)) PETSCABORT(PETSC_COMM_SELF, PETSC_ERR_PLIB);
    for (int k = 0; k < entries; k++, count++)
      row[count] = i, col[count] = at[k], x[count] = value[k];
    if (MatRestoreRow(K, i, &entries, &at, &value)) PETSCABORT(PETSC_COMM_SELF, PETSC_ERR_PLIB);
  }
  return count;
}

int main(int argc, char **argv) {
  static int row[7 * n], col[7 * n], each[2 * layer + 1], normal[layer], tangent[2 * layer];
  static double x[7 * n], one[2 * layer], mu[layer], r[3 * layer], ours[n];
  Mat K;
  Vec f, right, theirs;
  KSP solver;
  int rank, first, end, nodes = 0;
  const double *load;
  PetscCall(PetscInitialize(&argc, &argv, NULL, NULL));
  (void)MPI_Comm_rank(PETSC_COMM_WORLD, &rank);
  PetscCall(host_assemble(&K, &f, &first, &end));
  for (int c = 0; c < layer; c++) /* a contact node belongs to the rank of its normal's row */
    if (3 * c + 2 >= first && 3 * c + 2 < end) {
      normal[nodes] = 3 * c + 2;
      tangent[2 * nodes] = 3 * c;
      tangent[2 * nodes + 1] = 3 * c + 1;
      mu[nodes++] = 0.3;
    }
  for (int k = 0; k <= 2 * nodes; k++)
    each[k] = k, one[k < 2 * nodes ? k : 0] = 1;
  const dls_sparse HN = {n, nodes, each, normal, one}, HT = {n, 2 * nodes, each, tangent, one};
  const size_t entries = take_rows(K, first, end, row, col, x);
  const dls_mpi_model model = {3, DLS_CHOLESKY, end - first, entries, row, col, x, nodes, HN, HT};
  dls_mpi_reduction *reduction = NULL;
  dls_error error = {0};
  PetscCall(VecGetArrayRead(f, &load));
  dls_status status = dls_mpi_reduction_create(&reduction, PETSC_COMM_WORLD, &model, NULL, &error);
  if (!status) status = dls_mpi_reduction_load(reduction, load, NULL, &error);
  if (!status) status = dls_mpi_solve(reduction, mu, NULL, r, NULL, NULL, &error);
  if (!status) status = dls_mpi_reduction_recover(reduction, r, ours, &error);
  PetscCall(VecRestoreArrayRead(f, &load));
  PetscCall(PetscPrintf(PETSC_COMM_WORLD, "%d unknowns, %d contact nodes: %s\n", n, layer,
                        status < 0 ? error.message : dls_status_text(status)));
  PetscCall(VecDuplicate(f, &right));
  PetscCall(VecDuplicate(f, &theirs));
  PetscCall(VecCopy(f, right)); /* f + H r */
  double mine[2] = {0, 0}, sum[2], size, apart;
  for (int c = 0; c < nodes; c++) {
    const int at[] = {normal[c], tangent[2 * c], tangent[2 * c + 1]};
    PetscCall(VecSetValues(right, 3, at, r + 3 * c, ADD_VALUES));
    mine[0] += r[3 * c], mine[1] += r[3 * c + 1];
  }
  PetscCall(VecAssemblyBegin(right));
  PetscCall(VecAssemblyEnd(right));
  PetscCall(KSPCreate(PETSC_COMM_WORLD, &solver));
  PetscCall(KSPSetOperators(solver, K, K));
  PetscCall(KSPSetType(solver, KSPCG));
  PetscCall(KSPSetTolerances(solver, 1e-13, PETSC_DEFAULT, PETSC_DEFAULT, 10000));
  PetscCall(KSPSolve(solver, right, theirs));
  PetscCall(VecNorm(theirs, NORM_INFINITY, &size));
  for (int i = first; i < end; i++)
    PetscCall(VecSetValue(theirs, i, -ours[i - first], ADD_VALUES));
  PetscCall(VecAssemblyBegin(theirs));
  PetscCall(VecAssemblyEnd(theirs));
  PetscCall(VecNorm(theirs, NORM_INFINITY, &apart));
  (void)MPI_Allreduce(mine, sum, 2, MPI_DOUBLE, MPI_SUM, PETSC_COMM_WORLD);
  PetscCall(PetscPrintf(PETSC_COMM_WORLD,
                        "force of the floor: normal %.4g, shear along the push %.4g\n"
                        "x of PETSc's solver agrees to 1e-8: %s\n",
                        sum[0], sum[1], apart <= 1e-8 * size ? "yes" : "no"));
  dls_mpi_reduction_destroy(reduction);
  PetscCall(KSPDestroy(&solver));
  PetscCall(MatDestroy(&K));
  PetscCall(VecDestroy(&f));
  PetscCall(VecDestroy(&right));
  PetscCall(VecDestroy(&theirs));
  PetscCall(PetscFinalize());
  return status != DLS_OK;
}
