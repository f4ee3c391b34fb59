#!/bin/sh
# scale.sh BUILD RESULTS: writes the page bench/results/scale.md, a run of BUILD/bench/scale for each table; the data of the
# picture are those of the first. From the top of the repository; a quarter of an hour of CPU.
set -eu
build=$1
results=$2
out=$build/bench/scale.run
export OPENBLAS_NUM_THREADS=1
mkdir -p "$out"

# run OPTION..: one run; its page is $out/scale.md: two lines and a blank each of title and command, then the table
run() { "$build/bench/scale" --out "$out" "$@"; }

# table TITLE OPTION..: a run as a section of the page
table() {
  title=$1
  shift
  run "$@"
  if [ ! -e "$out/page" ]; then
    sed -n "3s/ BENCH='[^']*'//; 1,4p" "$out/scale.md" >"$out/page"
    cat >>"$out/page" <<'END'
The largest size of each kind: CPU seconds (iterations) until the certificate holds; limit: not within --limit. Solved: by
auto, of all sizes and seeds. Exponent: of the time of auto against contacts, over all sizes. auto / own: its time over the
best other column of delassus; worst beside Siconos: the largest time of auto over Siconos' Gauss-Seidel, where both solve.
The screen shows every size.

END
    cp "$out/scale.csv" "$results/scale.csv"
  else
    echo >>"$out/page"
  fi
  # shellcheck disable=SC2016
  printf '## %s\n\n`build/bench/scale %s`: ' "$title" "$*" >>"$out/page"
  tail -n +5 "$out/scale.md" >>"$out/page"
}

# more OPTION..: the rows of a run below the last table
more() {
  run "$@"
  grep '^|' "$out/scale.md" | tail -n +3 >>"$out/page"
}

rm -f "$out/page"
table 'All kinds' --sizes 300,1000,3000,10000 --limit 2 --seed 4 --only auto
table 'Packings beside single methods and the peer' --kind packing --sizes 300,2500,20000 --seed 6 --limit 12 --only auto,nlgs,momentum

hard='--sizes 1000,3000,10000 --seed 2 --limit 12 --no-peer --only auto'
# shellcheck disable=SC2086
{
  table 'Hard kinds: sizes 1 to 10, densities 1 to 1000, a floor that moves, crates, pushed walls' $hard --kind sizes2-flow
  for kind in sizes3-flow mixed3-rest drum3 pyramid wall3-pushed wall-pushed; do more $hard --kind $kind; done
  table 'Hard kinds: ellipsoids' $hard --mu 0.8 --kind ell3-flow
}
mv "$out/page" "$results/scale.md"
