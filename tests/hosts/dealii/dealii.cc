// dealii.cc: deal.II solves by Trilinos' Amesos with the parallel MUMPS, delassus on rank 0, in turns.
#include <deal.II/base/mpi.h>
#include <deal.II/lac/trilinos_solver.h>
#include <deal.II/lac/trilinos_sparse_matrix.h>
#include <deal.II/lac/trilinos_vector.h>

#include <iostream>

extern "C" {
#include "../unsymmetric.h"
}

using namespace dealii;

// Solves a tridiagonal system by Amesos on all ranks; returns 0 if its residual is <= 1e-10.
static int amesos_wrong() {
  const unsigned n = 4000;
  const unsigned rank = Utilities::MPI::this_mpi_process(MPI_COMM_WORLD);
  const unsigned ranks = Utilities::MPI::n_mpi_processes(MPI_COMM_WORLD);
  IndexSet own(n);
  own.add_range(n * rank / ranks, n * (rank + 1) / ranks);
  TrilinosWrappers::SparseMatrix A(own, MPI_COMM_WORLD, 3);
  for (const unsigned i : own) {
    if (i > 0) A.set(i, i - 1, -1);
    A.set(i, i, 2.5);
    if (i + 1 < n) A.set(i, i + 1, -1);
  }
  A.compress(VectorOperation::insert);
  TrilinosWrappers::MPI::Vector x(own, MPI_COMM_WORLD), b(own, MPI_COMM_WORLD), left(b);
  b = 1;
  SolverControl control;
  TrilinosWrappers::SolverDirect solver(
    control, TrilinosWrappers::SolverDirect::AdditionalData(false, "Amesos_Mumps"));
  solver.initialize(A);
  solver.solve(x, b);
  const double residual = A.residual(left, x, b);
  if (residual <= 1e-10) return 0;
  std::cout << "Amesos' MUMPS: residual " << residual << std::endl;
  return 1;
}

int main(int argc, char **argv) {
  int wrong = unsymmetric_wrong();
  Utilities::MPI::MPI_InitFinalize mpi(argc, argv, 1);
  wrong += amesos_wrong();
  if (Utilities::MPI::this_mpi_process(MPI_COMM_WORLD) == 0) wrong += unsymmetric_wrong();
  wrong += amesos_wrong();
  return wrong;
}
