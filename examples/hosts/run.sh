#!/bin/sh
# run.sh BUILD: builds and runs the hosts of this folder that are installed; each has to print what its head says. Then
# prints the lines of glue of each. PYTHON: an interpreter with getfem, numpy and scipy (/usr/bin/python3).
set -eu
build=$1
here=examples/hosts
out=$build/hosts
failed=0
mkdir -p "$out"
export OPENBLAS_NUM_THREADS=1 OMP_NUM_THREADS=1
export PYTHONPATH=src/python PYTHONDONTWRITEBYTECODE=1 DELASSUS_LIBRARY="$build/libdelassus.so"
python=${PYTHON:-/usr/bin/python3}
link="$build/libdelassus.so -Wl,-rpath,$PWD/$build -lm"
# check SOURCE COMMAND...: runs it and compares
check() {
  source=$1
  shift
  expected=$(sed -n '/Output:/,/^\( \*\/\|#$\|[^ #]\)/p' "$here/$source" | sed -e 1d -e '$d' -e 's/^ \* \{0,1\}//' -e 's/^# \{0,1\}//' -e 's/^  //')
  actual=$("$@") || failed=1
  echo "== $source"
  echo "$actual"
  [ "$expected" = "$actual" ] || { echo "FAILED: its head says"; echo "$expected"; failed=1; }
}
skip() { echo "== $1: skipped, $2 is not installed"; }
build_c() { ${CC:-cc} -std=c11 -O1 -Iinclude -o "$out/$1" "$here/$1.c" $2 $link; }
build_cc() { ${CXX:-c++} -std=c++17 -O1 -Iinclude -o "$out/$1" "$here/$1.cc" $2 $link; }
mpi() { mpicc --showme:compile; mpicc --showme:link; }

if pkg-config --exists petsc; then
  build_c petsc "$(pkg-config --cflags --libs petsc) $(mpi)"
  check petsc.c "$out/petsc"
else skip petsc.c petsc-dev; fi
if command -v ccx >/dev/null; then
  check calculix.sh $here/calculix.sh "$build" "$out/calculix"
else skip calculix.sh calculix-ccx; fi
if "$python" -c 'import getfem, numpy, scipy' 2>/dev/null; then
  check getfem_block.py "$python" $here/getfem_block.py
else skip getfem_block.py python3-getfem++; fi
if [ -e /usr/include/mujoco/mujoco.h ]; then
  build_cc mujoco -lmujoco
  check mujoco.cc "$out/mujoco" $here/slope.xml $here/capsule.xml
else skip mujoco.cc libmujoco-dev; fi
if [ -d /usr/include/deal.II ]; then
  build_cc dealii "-Wl,--copy-dt-needed-entries -isystem /usr/include/trilinos -isystem /usr/include/suitesparse $(pkg-config --cflags petsc) -ldeal.ii -ltbb $(mpi)"
  check dealii.cc "$out/dealii"
else skip dealii.cc libdeal.ii-dev; fi
if [ -e /usr/include/ode/ode.h ]; then
  build_c ode "$(pkg-config --cflags --libs ode)"
  check ode.c "$out/ode"
else skip ode.c libode-dev; fi
if command -v ccx >/dev/null && "$python" -c 'import numpy, scipy' 2>/dev/null; then
  check calculix_pairs.py "$python" $here/calculix_pairs.py "$out/calculix_pairs"
else skip calculix_pairs.py calculix-ccx; fi
if "$python" -c 'import dolfinx, numpy, scipy' 2>/dev/null; then
  check dolfinx_press.py env XDG_CACHE_HOME="$PWD/$out" "$python" $here/dolfinx_press.py 2>"$out/dolfinx.log"
else skip dolfinx_press.py python3-dolfinx; fi

# lines of code between the marks, without blank lines and comments
for source in "$here"/*.c "$here"/*.cc "$here"/*.py; do
  awk '/-> delassus/ { on = 1; next } /<- delassus/ { on = 0 } on && NF && !/^ *(\/\*|#)/ { n++ }
    END { if (n) printf "%s: %d lines of glue\n", FILENAME, n }' "$source"
done
awk '/^```c$/ { on = 1; next } /^```/ { on = 0 } on && NF && !/^#include/ { n++ }
  END { printf "%s: %d lines without includes\n", FILENAME, n }' README.md
exit $failed
