#!/bin/sh
# tolerance.sh [BUILD]: by how much the answer of jean-fig3 and jean-fig4 moves with the tolerance (against 1e-14) and with
# the mesh (against half the size): the table of docs/decisions.md, "The tolerance of a scene". Tolerances: nlgs,
# whose error is nearest to its tolerance. r: the largest change of a reaction over the largest reaction. Mesh: resultants.
set -eu
build=${1:-build}
export OPENBLAS_NUM_THREADS=1
out=$(mktemp -d)
trap 'rm -rf "$out"' EXIT

run() { # name, options
  name=$1
  shift
  "$build/delassus" scene "$@" --quiet --out "$out/$name" --no-pictures >"$out/log" || cat "$out/log" >&2
}
resultant() { sed -n "s/.*\"resultant_$2\": \([-0-9.e+]*\),*/\1/p" "$out/$1/result.json"; }
moves() { # name of one, of the other: r_t and r_n are columns 6 and 7 of contact.csv
  paste -d, "$out/$1/contact.csv" "$out/$2/contact.csv" | awk -F, '
    function size(x) { return x < 0 ? -x : x }
    NR > 1 { for (k = 6; k <= 7; k++) { d = size($k - $(k + 11)); if (d > most) most = d
                                        if (size($(k + 11)) > scale) scale = size($(k + 11)) } }
    END { printf "%.1e", most / scale }'
}
change() { awk "BEGIN { x = $1 / $2 - 1; printf \"%.1e\", x < 0 ? -x : x }"; }

for scene in jean-fig3 jean-fig4; do
  rm -rf "$out"/*
  run exact $scene --method nlgs --tol 1e-14
  for tol in 1e-4 1e-6 1e-8; do
    run $tol $scene --method nlgs --tol $tol
    echo "$scene, tolerance $tol: r $(moves $tol exact)," \
      "resultants $(change "$(resultant $tol n)" "$(resultant exact n)")" \
      "$(change "$(resultant $tol t)" "$(resultant exact t)")"
  done
  run coarse $scene --tol 1e-12
  for mesh in 32x16 64x32 128x64; do
    run fine $scene --tol 1e-12 --mesh $mesh
    echo "$scene, to a mesh of $mesh: resultants $(change "$(resultant coarse n)" "$(resultant fine n)")" \
      "$(change "$(resultant coarse t)" "$(resultant fine t)")"
    rm -rf "$out/coarse"
    mv "$out/fine" "$out/coarse"
  done
done
