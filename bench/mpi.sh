#!/bin/sh
# mpi.sh BUILD RESULTS [ROUNDS]: reduction and solve of elastic cubes of 22^3, 26^3 and 30^3 elements on 1 and 2 ranks,
# ROUNDS times (3) in turn, the least of each time; writes RESULTS/mpi.csv, mpi.md and, by the model of docs/mpi.md,
# mpi.png. From the top of the repository.
set -eu
build=$1
results=$2
rounds=${3:-3}
mkdir -p "$build/bench"
export OPENBLAS_NUM_THREADS=1 OMPI_ALLOW_RUN_AS_ROOT=1 OMPI_ALLOW_RUN_AS_ROOT_CONFIRM=1
rows=$build/bench/mpi_rows.csv
: >"$rows"
head=
for round in $(seq "$rounds"); do
  for cells in 22 26 30; do
    for ranks in 1 2; do
      mpirun --oversubscribe --mca mpi_yield_when_idle 1 -np $ranks "$build/bench/mpi" $cells rows >"$build/bench/mpi_row.csv"
      tail -n 1 "$build/bench/mpi_row.csv" >>"$rows"
    done
  done
done
{
  head -n 1 "$build/bench/mpi_row.csv"
  # columns 5 to 28 are times: the least of the rounds; the others are those of the last round
  awk -F, -v OFS=, '
    { key = $1 "," $2; if (!(key in seen)) { seen[key] = 1; order[++count] = key; for (k = 5; k <= 28; k++) least[key, k] = $k }
      for (k = 5; k <= 28; k++) if ($k + 0 < least[key, k] + 0) least[key, k] = $k; row[key] = $0 }
    END { for (c = 1; c <= count; c++) { $0 = row[order[c]]; for (k = 5; k <= 28; k++) $k = least[order[c], k]; print } }' "$rows"
} >"$results/mpi.csv"
{
  echo "# Reduction and solve on MPI"
  echo
  echo "\`make MPI=1 bench-mpi\`, least of $rounds rounds; $(bench/where.sh), $(nproc) cores,"
  echo "load $(cut -d' ' -f1 /proc/loadavg) at the end (wall seconds count only where it is not above the number of ranks). Wall and CPU: of the slowest"
  echo "rank; CPU: outside of MPI, without messages and waiting. MUMPS: used by the largest rank; all: resident memory of the"
  echo "largest rank."
  echo
  echo "| cells | ranks | order | analyse | factor, Schur: wall | CPU | S^-1: CPU | W: CPU | solve: wall | CPU | iterations | residual | MUMPS MB | all MB | flops of a rank | size of r |"
  echo "|---|---|---|---|---|---|---|---|---|---|---|---|---|---|---|---|"
  tail -n +2 "$results/mpi.csv" | awk -F, '{ print "| " $1 "^3 | " $2 " | " $6 " | " $9 " | " $11 " | " $12 " | " $15 " | " $18 " | " $23 " | " $24 " | " $35 " | " $36 " | " $29 " | " $32 " | " $33 " | " $37 " |" }'
  echo
  echo "Two ranks over one:"
  echo
  echo "| cells | factor: wall | CPU | solve: wall | CPU | MUMPS | all memory | difference of the size of r |"
  echo "|---|---|---|---|---|---|---|---|"
  tail -n +2 "$results/mpi.csv" | awk -F, '
    $2 == 1 { fw = $11; fc = $12; sw = $23; sc = $24; mm = $29; rss = $32; size = $37 }
    $2 == 2 { e = $37 / size - 1; printf "| %s^3 | %.2f | %.2f | %.2f | %.2f | %.2f | %.2f | %.1e |\n", $1, $11 / fw, $12 / fc, $23 / sw, $24 / sc, $29 / mm, $32 / rss, e < 0 ? -e : e }'
} >"$results/mpi.md"
cat "$results/mpi.md"
gnuplot -e "dir='$results/'" bench/mpi.gp
