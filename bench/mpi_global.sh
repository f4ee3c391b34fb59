#!/bin/sh
# mpi_global.sh BUILD RESULTS [ROUNDS]: the problem on K of a plate of 100 x 100 x 3 elements on 1 and 2 ranks, ROUNDS
# times (3) in turn, the least of each time; then PETSc's multigrid (where petsc-dev is there) on cubes and plates of
# SIZES (20 30 40) elements a side. Writes RESULTS/mpi_global.md. From the top of the repository.
set -eu
build=$1
results=$2
rounds=${3:-3}
export OPENBLAS_NUM_THREADS=1 OMPI_ALLOW_RUN_AS_ROOT=1 OMPI_ALLOW_RUN_AS_ROOT_CONFIRM=1
rows=$build/bench/mpi_global_rows.csv
: >"$rows"
for round in $(seq "$rounds"); do
  for ranks in 1 2; do
    mpirun --oversubscribe -np $ranks "$build/bench/mpi_global" 100 3 | sed "s/^/$(cut -d' ' -f1 /proc/loadavg),/" >>"$rows"
  done
done
{
  echo "# The problem on K on MPI"
  echo
  echo "\`make MPI=1 bench-mpi-global\`: plate of 100 x 100 x 3 elements, all nodes below are contacts, friction .3, tolerance"
  echo "1e-8; least of $rounds rounds; $(bench/where.sh), $(nproc) cores, load at the begin of the"
  echo "runs: $(cut -d, -f1 "$rows" | tr '\n' ' '). Wall seconds count only where that is below the number of cores. CPU: of the"
  echo "slowest rank, outside of MPI. Memory: of the largest rank."
  echo
  echo "| ranks | n | m | all: wall | order, analyse: CPU | factor: CPU | iterations: CPU | all: CPU | MUMPS MB | all MB | iterations | residual | size of r |"
  echo "|---|---|---|---|---|---|---|---|---|---|---|---|---|"
  awk -F, '
    { k = $4; if (!(k in row)) for (c = 7; c <= 14; c++) least[k, c] = $c
      for (c = 7; c <= 14; c++) if ($c + 0 < least[k, c] + 0) least[k, c] = $c; row[k] = $0 }
    END {
      for (k = 1; k <= 2; k++) { $0 = row[k]
        printf "| %d | %d | %d | %s | %s | %s | %s | %s | %s | %s | %s | %s | %s |\n", k, $5, $6, least[k, 10], least[k, 11], least[k, 12], least[k, 13], least[k, 14], $15, $16, $18, $20, $21 }
      split(row[1], a, ","); split(row[2], b, ",")
      printf "| 2 over 1 | | | %.2f | %.2f | %.2f | %.2f | %.2f | %.2f | %.2f | | | |\n", least[2, 10] / least[1, 10], least[2, 11] / least[1, 11], least[2, 12] / least[1, 12], least[2, 13] / least[1, 13], least[2, 14] / least[1, 14], b[15] / a[15], b[16] / a[16]
    }' "$rows"
} >"$results/mpi_global.md"
[ -x "$build/examples/mpi/host_petsc" ] || exit 0
{
  echo
  echo "\`build/examples/mpi/host_petsc CELLS [HEIGHT]\`, one rank: conjugate gradients and algebraic multigrid in place of"
  echo "the factor, friction .3, tolerance 1e-8; memory of the process."
  echo
  echo "| elements | n | outer iterations | Krylov iterations a solve | MB |"
  echo "|---|---|---|---|---|"
  for shape in cube plate; do
    for cells in ${SIZES:-20 30 40}; do
      height=$([ $shape = plate ] && echo 3 || echo "$cells")
      mpirun -np 1 "$build/examples/mpi/host_petsc" "$cells" "$height" | awk -v name="$cells x $cells x $height" '
        /unknowns/ { n = $1 }
        /outer/ { for (k = 1; k <= NF; k++) { if ($k == "outer") o = $(k - 1); if ($k == "Krylov") s = $(k - 1); if ($k == "MB") mb = $(k - 1) }
          print "| " name " | " n " | " o " | " s " | " mb " |" }'
    done
  done
} >>"$results/mpi_global.md"
cat "$results/mpi_global.md"
