#!/bin/sh
# run.sh BUILD: hosts with a parallel MUMPS of their own, on 1 and 2 ranks: PETSc linked behind and before libdelassus,
# and with libdelassus-mpi where BUILD has it (make MPI=1); deal.II with Trilinos, from installed CMake packages.
set -eu
build=$(realpath "$1")
out=$(mktemp -d)
trap 'rm -rf "$out"' EXIT
here=tests/hosts
failed=0
export OPENBLAS_NUM_THREADS=1 OMP_NUM_THREADS=1 OMPI_ALLOW_RUN_AS_ROOT=1 OMPI_ALLOW_RUN_AS_ROOT_CONFIRM=1
on_ranks() { # program
  for ranks in 1 2; do
    if timeout 120 mpirun --oversubscribe -np $ranks "$out/$1" > "$out/printed" 2>&1; then echo "$1 on $ranks ranks: both right"
    else cat "$out/printed"; echo "FAILED: $1 on $ranks ranks"; failed=1; fi
  done
}
petsc="$(pkg-config --cflags --libs petsc) $(mpicc --showme:compile) $(mpicc --showme:link) -lm"
by_petsc() { # program, what it is linked with
  ${CC:-cc} -std=c11 -O1 -Iinclude -o "$out/$1" $here/petsc.c $here/unsymmetric.c $2 -Wl,-rpath,"$build"
  on_ranks "$1"
}
by_petsc petsc-behind "$build/libdelassus.so $petsc"
by_petsc petsc-before "$petsc $build/libdelassus.so"
if [ -f "$build/libdelassus-mpi.so" ]; then
  by_petsc petsc-mpi "$build/libdelassus-mpi.so $petsc"
  by_petsc petsc-all "$build/libdelassus.so $build/libdelassus-mpi.so $petsc"
fi
make --no-print-directory -s install BUILD="$1" PREFIX="$out/tree" PYTHON= > "$out/log" 2>&1 || { cat "$out/log"; exit 1; }
(cmake -S $here/dealii -B "$out/dealii.cmake" -DCMAKE_PREFIX_PATH="$out/tree" && cmake --build "$out/dealii.cmake") > "$out/log" 2>&1 ||
  { cat "$out/log"; exit 1; }
cp "$out/dealii.cmake/dealii" "$out/dealii"
on_ranks dealii
exit $failed
