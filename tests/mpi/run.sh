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
export OPENBLAS_NUM_THREADS=1
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

# problem files (H of this one touches every unknown), and one that is not there
for ranks in $counts; do
  run $ranks "$build/delassus-mpi" solve --gather 0 data/fclib/GFC3D_OneContact.hdf5 >/dev/null
  tell $? "GFC3D_OneContact on $ranks ranks"
done
dir=$(mktemp -d) || exit 1
trap 'rm -rf "$dir"' EXIT
printf '%%%%MatrixMarket matrix coordinate real symmetric\n3 3 5\n1 1 4\n2 2 4\n3 3 2\n2 1 -1\n3 2 -1\n' >"$dir/K.mtx"
printf '%%%%MatrixMarket matrix coordinate real general\n3 2 2\n1 1 1\n2 2 1\n' >"$dir/H.mtx"
printf '%%%%MatrixMarket matrix array real general\n3 1\n-1\n.2\n0\n' >"$dir/f.mtx"
printf '%%%%MatrixMarket matrix array real general\n2 1\n0\n0\n' >"$dir/w.mtx"
printf '%%%%MatrixMarket matrix array real general\n1 1\n.5\n' >"$dir/mu.mtx"
for kind in cholesky ldlt lu; do
  out=$(run 2 "$build/delassus-mpi" solve -r -k $kind -t 1e-12 "$dir"/[KH].mtx "$dir/f.mtx" "$dir/w.mtx" "$dir/mu.mtx" 2>&1)
  status=$?
  [ $status -eq 2 ] && echo "$out" | grep -q 'K, H and mu do not fit'
  tell $? "H in the place of K: status $status: $out"
  out=$(run 2 "$build/delassus-mpi" solve -r -k $kind -t 1e-12 "$dir/K.mtx" "$dir/H.mtx" "$dir/f.mtx" "$dir/w.mtx" "$dir/mu.mtx" 2>&1)
  status=$?
  [ $status -eq 0 ] && echo "$out" | grep -q 'rank 1: wall' && echo "$out" | grep -q '^solved$'
  tell $? "Matrix Market, $kind: status $status: $out"
done
# a square of four nodes on springs of 1e-8, pressed down: ADMM solves the problem on W, and not that of
# the body; on K it is solved
{
  printf '%%%%MatrixMarket matrix coordinate real symmetric\n8 8 16\n'
  for k in 1 2 3 4 5 6 7 8; do echo "$k $k 2.00000001"; done
  for at in '3 1' '5 1' '7 3' '7 5' '4 2' '6 2' '8 4' '8 6'; do echo "$at -1"; done
} >"$dir/Ks.mtx"
printf '%%%%MatrixMarket matrix coordinate real general\n8 4 4\n2 1 1\n1 2 1\n4 3 1\n3 4 1\n' >"$dir/Hs.mtx"
printf '%%%%MatrixMarket matrix array real general\n8 1\n0\n0\n0\n0\n0\n-5\n0\n-5\n' >"$dir/fs.mtx"
printf '%%%%MatrixMarket matrix array real general\n4 1\n0\n0\n0\n0\n' >"$dir/ws.mtx"
printf '%%%%MatrixMarket matrix array real general\n2 1\n.3\n.3\n' >"$dir/mus.mtx"
soft() {
  run 2 "$build/delassus-mpi" solve -g 0 -k cholesky "$@" "$dir/Ks.mtx" "$dir/Hs.mtx" "$dir/fs.mtx" "$dir/ws.mtx" "$dir/mus.mtx" 2>&1
}
out=$(soft --on W)
status=$?
[ $status -eq 1 ] && echo "$out" | grep -q '^not solved: '
tell $? "soft springs on W: status $status: $out"
out=$(soft --on K -r)
status=$?
[ $status -eq 0 ] && echo "$out" | grep -q '^solved$' && echo "$out" | grep -q 'on K, 2 ranks'
tell $? "soft springs on K: status $status: $out"
out=$(soft)
status=$?
[ $status -eq 0 ] && echo "$out" | grep -q '^solved$' && echo "$out" | grep -q 'rows of W'
tell $? "soft springs on W, then on K: status $status: $out"

out=$(seconds=10 run 2 "$build/delassus-mpi" solve nowhere.hdf5 2>&1)
status=$?
[ $status -eq 2 ] && echo "$out" | grep -q 'nowhere.hdf5'
tell $? "a file that is not there: status $status: $out"

echo "$passed passed, $failed failed"
[ "$failed" -eq 0 ] && [ "$passed" -gt 0 ]
