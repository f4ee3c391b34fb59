#!/bin/sh
# all.sh FCLIB LCP: every page that a program of bench/ writes, with the minutes of each; hours on a machine that should do
# nothing else. FCLIB, LCP: folders with problems. JOBS=2: two pages at a time, of two cores. The log of a page is
# BUILD/bench/NAME.log. Goes on where a page fails, and fails at the end.
# all.sh page NAME [OPTION..]: one of them
set -u
build=${BUILD:-build}
make=${MAKE:-make}

if [ "$1" = page ]; then
  name=$2
  shift 2
  start=$(date +%s)
  $make --no-print-directory "bench-$name" BENCH="$*" >>"$build/bench/$name.log" 2>&1
  status=$?
  echo "bench-$name $*: $((($(date +%s) - start + 30) / 60)) min$([ $status -eq 0 ] || echo ', failed')"
  exit $status
fi

fclib=$1
lcp=$2
export FCLIB="$fclib"
mkdir -p "$build/bench"
rm -f "$build"/bench/*.log
status=0
xargs -L 1 -P "${JOBS:-1}" "$0" page <<END || status=1
report
hard
global
scale
solvers --dir $fclib
regret --seed 2
reduction --full
reduction --large
papers
tables
prove
lemke --full --lcp $lcp
lemke --large
auto
auto --price
lanes --rounds 4
dynamics
motion
trust
derive
least
steps
limit
END
"$0" page bodies --rounds 7 || status=1 # alone, on two threads
exit $status
