#!/bin/sh
# run.sh BUILD: builds and runs the hosts of this folder; each has to print what its head says.
set -eu
build=$1
here=examples/hosts
out=$build/hosts
failed=0
mkdir -p "$out"
export OPENBLAS_NUM_THREADS=1 OMP_NUM_THREADS=1
link="$build/libdelassus.so -Wl,-rpath,$PWD/$build -lm"
check() { # source, its output
  expected=$(sed -n '/Output:/,/^\( \*\/\|#$\|"""\)/p' "$here/$1" | sed -e 1d -e '$d' -e 's/^ \* \{0,1\}//' -e 's/^# \{0,1\}//' -e 's/^  //')
  echo "== $1"
  echo "$2"
  [ "$expected" = "$2" ] || { echo "FAILED: its head says"; echo "$expected"; failed=1; }
}
petsc=$(pkg-config --cflags petsc)
for flag in $(pkg-config --libs petsc) $(mpicc --showme:compile) $(mpicc --showme:link); do petsc="$petsc $flag"; done
${CC:-cc} -std=c11 -O1 -Iinclude -o "$out/petsc" $here/petsc.c $petsc $link
check petsc.c "$("$out/petsc")"
check calculix.sh "$($here/calculix.sh "$build" "$out/calculix")"
${CXX:-c++} -std=c++17 -O1 -Iinclude -o "$out/getfem" $here/getfem.cc -lgetfem -lopenblas $link
check getfem.cc "$("$out/getfem")"
ode=$(pkg-config --cflags --libs ode)
${CC:-cc} -std=c11 -O1 -Iinclude -o "$out/ode" $here/ode.c $ode $link
check ode.c "$("$out/ode")"
export PYTHONPATH="$PWD/src/python" PYTHONDONTWRITEBYTECODE=1 DELASSUS_LIBRARY="$PWD/$build/libdelassus.so"
check calculix_pairs.py "$(${PYTHON:-python3} $here/calculix_pairs.py "$out/calculix_pairs")"
check dolfinx_press.py "$(XDG_CACHE_HOME="$PWD/$out" ${PYTHON:-python3} $here/dolfinx_press.py 2>"$out/dolfinx.log")"
exit $failed
