#!/bin/sh
# run.sh BUILD RANKS...: runs the tests of libdelassus-mpi on each of these numbers of ranks (1 2 4), the examples
# against the expected output in their first comment, and the program with a rank that is killed. From the top of the
# repository. More ranks than cores are fine. Root may run mpirun here.
set -u
build=$1
shift
counts=${*:-1 2 4}
passed=0
failed=0
export OPENBLAS_NUM_THREADS=1 NO_COLOR=1 # mpirun gives the program a terminal
export OMPI_ALLOW_RUN_AS_ROOT=1 OMPI_ALLOW_RUN_AS_ROOT_CONFIRM=1
# A waiting rank gives its core away only where ranks are more than cores: it comes back late where other programs run.
run() { # run RANKS COMMAND...
  ranks=$1
  shift
  idle=0
  [ "$ranks" -le "$(nproc)" ] || idle=1
  timeout "${seconds:-300}" mpirun --oversubscribe -np "$ranks" --mca mpi_yield_when_idle $idle "$@"
}
tell() { # tell STATUS NAME
  if [ "$1" -eq 0 ]; then passed=$((passed + 1)); else failed=$((failed + 1)); echo "FAILED: $2"; fi
}

for program in "$build"/mpi/test_*; do
  case $program in *.d) continue ;; esac
  for ranks in $counts; do
    run $ranks "$program"
    tell $? "$program on $ranks ranks"
  done
done

for source in examples/mpi/*.c; do
  program=$build/examples/mpi/$(basename "$source" .c)
  case $source in *petsc*) [ -x "$program" ] || { echo "no PETSc: $source left out"; continue; } ;; esac
  expected=$(sed -n '/^ \* Output:/,/^ \*\//p' "$source" | sed -e '1d' -e '$d' -e 's/^ \* \{0,1\}//' -e 's/^  //')
  for ranks in $counts; do
    [ -n "$expected" ] && [ "$(run $ranks "$program")" = "$expected" ]
    tell $? "$program on $ranks ranks"
  done
done

# a rank that is killed ends all in less than 10 s, and mpirun says so
out=$(seconds=10 run 2 sh -c 'if [ "$OMPI_COMM_WORLD_RANK" = 1 ]; then "$0" "$@" & p=$!; sleep 1; kill -9 $p; wait $p; else exec "$0" "$@"; fi' \
  "$build/examples/mpi/host_slabs" 26 2>&1)
status=$?
[ $status -ne 0 ] && [ $status -ne 124 ] && echo "$out" | grep -q -i 'rank.*exit\|terminated'
tell $? "a killed rank: status $status: $out"

# the program answers as `delassus solve` does: the last line and, if solved, r.csv and x.csv to a millionth
dir=$(mktemp -d) || exit 1
trap 'rm -rf "$dir"' EXIT
# same RANKS WORDS OPTION...: both programs; WORDS: of the parallel one's output
same() {
  ranks=$1 words=$2
  shift 2
  rm -rf "$dir/one" "$dir/all"
  one=$("$build/delassus" solve --csv="$dir/one" "$@" 2>&1)
  one_status=$?
  out=$(run "$ranks" "$build/delassus-mpi" solve --csv="$dir/all" "$@" 2>&1)
  status=$?
  [ $status -eq $one_status ] && echo "$out" | grep -q "$words" && echo "$out" | grep -q "^$(echo "$one" | tail -1 | sed 's/ within.*//')" &&
    { [ $status -ne 0 ] || (cd "$dir/one" && for file in *.csv; do paste -d ' ' "$file" "../all/$file"; done) | sed 's/,/ /g' | awk '
      /^#/ { next }
      { for (k = 1; k <= NF / 2; k++) { a = $k; b = $(k + NF / 2); d = a - b; s = a < 0 ? -a : a
          if (a + 0 != a || b + 0 != b) { bad += a != b; continue }
          if ((d < 0 ? -d : d) > 1e-6 * (s > 1 ? s : 1)) bad++ } }
      END { exit bad > 0 || NR == 0 }'; }
  tell $? "$* on $ranks ranks: status $status, alone $one_status: $out"
}
matrix() { # matrix FILE KIND ROWS COLS, entries on stdin
  sed '/^$/d' >"$dir/entries"
  { echo "%%MatrixMarket matrix coordinate real $2"; echo "$3 $4 $(wc -l <"$dir/entries")"; cat "$dir/entries"; } >"$dir/$1"
}
for ranks in $counts; do
  for file in GFC3D_OneContact GFC3D_Example0 CubeH8 FC3D_Example1; do same "$ranks" . data/fclib/$file.hdf5; done
done
same 2 . jean-fig3 # a K whose entries are dense or of a scene
printf '1 1 4\n2 2 4\n3 3 2\n2 1 -1\n3 2 -1\n' | matrix K.mtx symmetric 3 3
printf '1 1 1\n2 2 1\n' | matrix H.mtx general 3 2
printf '%%%%MatrixMarket matrix array real general\n3 1\n-1\n.2\n0\n' >"$dir/f.mtx"
small="--stiffness=$dir/K.mtx --H=$dir/H.mtx --dim=2 --f=$dir/f.mtx --mu=.5 --tol=1e-12"
for more in --ranks --json --prove --method=nlgs --forces=least --on=K --gather=0; do
  [ "$more" = --ranks ] || [ "$more" = --gather=0 ] || { same 2 . $small $more; continue; }
  out=$(run 2 "$build/delassus-mpi" solve $small $more 2>&1)
  status=$?
  [ $status -eq 0 ] && echo "$out" | grep -q '^solved$'
  tell $? "$more: status $status: $out"
done
out=$(run 2 "$build/delassus-mpi" solve $small --gather=0 --method=nlgs 2>&1)
status=$?
[ $status -eq 2 ] && echo "$out" | grep -q 'method.*--gather=2'
tell $? "a method on a W that is spread: status $status: $out"

# a square of four nodes on springs of 1e-8, pressed down: ADMM solves the problem on W, and not that of the body; on
# K it is solved
{
  for k in 1 2 3 4 5 6 7 8; do echo "$k $k 2.00000001"; done
  for at in '3 1' '5 1' '7 3' '7 5' '4 2' '6 2' '8 4' '8 6'; do echo "$at -1"; done
} | matrix Ks.mtx symmetric 8 8
printf '2 1 1\n1 2 1\n4 3 1\n3 4 1\n' | matrix Hs.mtx general 8 4
printf '%%%%MatrixMarket matrix array real general\n8 1\n0\n0\n0\n0\n0\n-5\n0\n-5\n' >"$dir/fs.mtx"
soft="--stiffness=$dir/Ks.mtx --H=$dir/Hs.mtx --dim=2 --f=$dir/fs.mtx --mu=.3"
out=$(run 2 "$build/delassus-mpi" solve --gather=0 $soft 2>&1)
status=$?
[ $status -eq 0 ] && echo "$out" | grep -q '^solved$' && echo "$out" | grep -q 'on-K: '
tell $? "soft springs on W, then on K: status $status: $out"
same 2 'on-K: ' $soft --on=K

# a chain of four nodes that nothing holds, lifted off the floor (no equilibrium, with a proof), pushed along it, and
# pressed onto it (K is singular: solved on K)
{
  for k in 1 2 3 10 11 12; do echo "$k $k 1"; done
  for k in 4 5 6 7 8 9; do echo "$k $k 2"; done
  for k in 4 5 6 7 8 9 10 11 12; do echo "$k $((k - 3)) -1"; done
} | matrix Kf.mtx symmetric 12 12
printf '3 1 1\n1 2 1\n2 3 1\n6 4 1\n4 5 1\n5 6 1\n' | matrix Hf.mtx general 12 6
for load in '0 0 1' '2 0 -1' '.2 0 -1'; do
  { printf '%%%%MatrixMarket matrix array real general\n12 1\n'; for k in 1 2 3 4; do echo "$load" | tr ' ' '\n'; done; } >"$dir/ff.mtx"
  words='no equilibrium (proved)'
  [ "$load" = '.2 0 -1' ] && words='on-K'
  for ranks in $counts; do
    same "$ranks" "$words" --stiffness="$dir/Kf.mtx" --H="$dir/Hf.mtx" --dim=3 --f="$dir/ff.mtx" --mu=.3
  done
done

out=$(seconds=10 run 2 "$build/delassus-mpi" solve nowhere.hdf5 2>&1)
status=$?
[ $status -eq 2 ] && echo "$out" | grep -q 'nowhere.hdf5'
tell $? "a file that is not there: status $status: $out"

echo "$passed passed, $failed failed"
[ "$failed" -eq 0 ] && [ "$passed" -gt 0 ]
