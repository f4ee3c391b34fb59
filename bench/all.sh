#!/bin/sh
# all.sh FCLIB LCP: every page that a program of bench/ writes, one after the other; hours on a machine that should do nothing
# else. FCLIB, LCP: folders with problems. Prints the minutes of each page, the log is BUILD/bench/NAME.log. Goes on where
# a page fails, and fails at the end.
set -u
fclib=$1
lcp=$2
build=${BUILD:-build}
make=${MAKE:-make}
failed=
mkdir -p "$build/bench"

# page NAME [OPTION..]: make bench-NAME BENCH='OPTION..'
page() {
  name=$1
  shift
  start=$(date +%s)
  if $make --no-print-directory "bench-$name" FCLIB="$fclib" BENCH="$*" >"$build/bench/$name.log" 2>&1; then
    end=
  else
    end=', failed'
    failed="$failed $name"
  fi
  echo "bench-$name $*: $((($(date +%s) - start + 30) / 60)) min$end"
}

page hard
page report
page papers
page tables
page trust
page derive
page least
page prove
page auto
page auto --price
page blocks
page bodies --rounds 7
page lanes --rounds 4
page motion
page steps
page dynamics
page lemke --full --lcp "$lcp"
page lemke --large
page reduction --full
page reduction --large
page regret --seed 2
page solvers --dir "$fclib"
page scale
page global
[ -z "$failed" ] || { echo "failed:$failed" >&2; exit 1; }
