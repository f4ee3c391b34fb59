#!/bin/sh
# tables.sh BUILD RESULTS: Tables 2 and 3 of Chabrand, Dubois and Raous (1998) beside ours, and the study of their section
# 6: both forming scenes by each method. Writes RESULTS/tables.md. Fails if a run of the two tables stops before its end.
# From the top of the repository; two minutes of CPU.
set -eu
build=$1
results=$2
out=$build/bench/tables
export OPENBLAS_NUM_THREADS=1
rm -rf "$out"
mkdir -p "$out"

# field RUN KEY: of the object that a run has printed
field() { sed -n "s/^  \"$2\": \"*\([^\",]*\).*/\1/p" "$out/$1.json"; }

# cpu RUN: seconds of assembly, of factorisation and condensation, of the contact method, and of all; not of files
cpu() {
  awk -F, '!/^#/ { a = $10; f = $11; c = $12 } END { printf "%.2f %.2f %.2f %.4f", a, f, c, a + f + c }' "$out/$1/force.csv"
}

# difference RUN LEMKE: largest difference of the force from Lemke's at the same travel, over Lemke's
difference() {
  awk -F, 'NR == FNR { force[$1] = $2; next }
    force[$1] > 0 { d = $2 / force[$1] - 1; if (d < 0) d = -d; if (d > most) most = d }
    END { printf "%.1e", most }' "$out/$2/force.csv" "$out/$1/force.csv"
}

# row FIRST SCENE METHOD OPTION..: runs a scene and prints a row, whose first cells are FIRST. 1, a run that stops early, is
# a result, too.
# shellcheck disable=SC2046
row() {
  first=$1
  shift
  run=$(echo "$*" | tr -d ' -')
  "$build/delassus" scene "$1" --method "$2" --json --no-pictures --out "$out/$run" \
    --tol $([ "$2" = gauss-seidel ] && echo 1e-10 || echo 1e-9) $(shift 2 && echo "$@") >"$out/$run.json" || [ $? -eq 1 ]
  set -- $(cpu "$run") $(cpu "$1lemke") "$1lemke"
  end=$(field "$run" status | tr _ ' ')
  [ "$end" = solved ] || end="$end at $(printf '%.4g of %.4g' "$(field "$run" travel)" "$(field "$run" whole)") mm"
  [ -z "$parts" ] || parts=" $2 | $3 | $(field "$run" newton_steps) | $(field "$run" iterations) |"
  echo "| $first | $(printf %.2f "$4") | $(awk "BEGIN { printf \"%.2f\", $4 / $8 }") |$parts $(difference "$run" "$9") | $end |"
}

# heads FIRST LINES [PARTS]: of a table, whose first columns are FIRST; PARTS: columns of the parts of the CPU and of counts
heads() {
  parts=${3:-}
  echo "| $1 | CPU | ratio |$parts force | end |"
  echo "$2|---|---|---|---|${3:+---|---|---|---|}"
}

# table SCENE MINUTES..: of the paper, for each method; -: none
table() {
  scene=$1 lemke=$2
  heads 'method | paper | ratio' '|---|---|---' ' LU and W | method | Newton steps | iterations |'
  for method in lemke gauss-seidel augmented-lagrangian penalty nlgs newton auto; do
    shift
    row "$method | $1 | $(echo "$1" "$lemke" | awk '$1 != "-" { $1 = sprintf("%.2f", $1 / $2) } { print $1 }')" "$scene" $method
    [ "$(field "$run" status)" = solved ] || { echo "tables.sh: $run stops before its end" >&2; exit 1; }
  done
}

# study SCENE: section 6; each run has ten times the CPU of Lemke's method
study() {
  scene=$1 limit=$(cpu "$1lemke" | awk '{ print 10 * $4 }')
  heads options '|---'
  trial() { row "\`$*\`" "$scene" "$@" --limit "$limit"; }
  for factor in 10 100 1000 10000; do trial penalty --penalty $factor; done
  for factor in 10 100; do
    for most in 1 5; do trial augmented-lagrangian --penalty $factor --augmentations $most; done
    trial augmented-lagrangian --penalty $factor
  done
  for omega in 1 1.5 1.8; do trial gauss-seidel --relaxation $omega --no-aitken; done
  for omega in 1 1.5; do trial gauss-seidel --relaxation $omega; done
}

{
  cat <<HEAD
# The tables of Chabrand, Dubois and Raous (1998)

Written by \`make bench-tables\`: $(bench/where.sh), one BLAS thread.

Paper: minutes, and their ratio to Lemke. Here: seconds of CPU without files, their ratio to Lemke, and two parts;
the rest is assembly.
Force: largest difference from Lemke's in any step, over Lemke's. Tolerance 1e-9, Gauss-Seidel 1e-10.
HEAD
  printf '\n## Table 2: indentation\n\n' && table indentation 9 77 28 11 - - -
  printf '\n## Table 3: extrusion\n\n' && table extrusion 2 8.5 6.5 1.75 - - -
  cat <<TEXT

With ten or twenty contacts the method's own share is small. Each condensation is a factorisation and a solve for each
column of W. Springs need no W, and neither does auto, which is Newton's method on K here: its iterations are LUs of K.

Section 6: penalty factors, augmentations, over-relaxation. A run ends after ten times the CPU of Lemke.
TEXT
  printf '\n## Section 6: indentation\n\n' && study indentation
  printf '\n## Section 6: extrusion\n\n' && study extrusion
} >"$out/tables.md"
mv "$out/tables.md" "$results/tables.md"
