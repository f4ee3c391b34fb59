#!/bin/sh
# charts.sh BUILD [OUT]: draws every picture of the docs from scratch into OUT (docs/pictures). Data, scripts
# and tables stay in BUILD/charts/NAME, and what each command printed in BUILD/charts/NAME/log.
#
# LONGER=10 draws them once more into BUILD/longer, with ten times the limits of CPU, copies nothing, and counts the
# cells whose verdict is another one than in BUILD/charts. Exit status 1 if there are any.
set -u
build=$1
out=${2:-docs/pictures}
longer=${LONGER:-1}
work=$build/charts
[ "$longer" = 1 ] || work=$build/longer
export OPENBLAS_NUM_THREADS=1
rm -rf "${work:?}"
mkdir -p "$out" "$work/problems" || exit 2

# compare PICTURE TABLE: counts the rows whose words and shares, from the verdict on, differ; CPU and iterations do not count
compare() {
  awk -F, -v name="$1" '
    FNR == 1 { for (k = 1; k <= NF; k++) if ($k == "verdict" || $k == "share") at = k; next }
    { key = $1; for (k = 2; k < at; k++) key = key "," $k; value = $at }
    NR == FNR { before[key] = value; next }
    { cells++; if (before[key] != value) { changed++; print name ": " key ": " before[key] " -> " value > "/dev/stderr" } }
    END { print cells + 0, changed + 0 }' "$build/charts/$1/$2" "$work/$1/$2"
}

# draw PICTURE LIMIT COMMAND...: runs `delassus COMMAND... --limit LIMIT -o DIRECTORY`, keeps its picture. Status 1 is a verdict.
draw() {
  picture=$1
  limit=$(awk "BEGIN { print $2 * $longer }")
  shift 2
  mkdir -p "$work/$picture"
  [ "$1" = info ] || set -- "$@" --limit "$limit"
  "$build/delassus" "$@" -o "$work/$picture" >"$work/$picture/log" 2>&1
  status=$?
  if [ $status -gt 1 ]; then
    cat "$work/$picture/log" >&2
    exit $status
  fi
  name=$1
  [ "$name" != info ] || name=sensitivity
  if [ "$longer" != 1 ]; then
    [ "$name" = sensitivity ] || compare "$picture" "$name.csv" >>"$work/counts"
    return
  fi
  [ "$picture" != profile ] || return # no page shows it
  cp "$work/$picture/$name.png" "$out/$picture.png" 2>/dev/null || { cat "$work/$picture/log" >&2; exit 2; }
  echo "$out/$picture.png"
}

p=$work/problems
"$build/bench/problems" "$p" wall-3x2 wall-6x5 t3-16 t3-64 h8-6 h8-12-tilt-mu0.3 || exit 2
"$build/bench/hard" --save "$p" || exit 2
"$build/delassus" scene indentation --method lemke --save "$p/indentation-step.hdf5" >/dev/null || exit 2

draw chart-jean 1 chart jean-fig3
draw chart-wall 1 chart "$p/wall-6x5-push0.3-mu1.hdf5"
draw chart-cube 1 chart "$p/h8-12-tilt-mu0.3.hdf5"
"$build/delassus" scene jean-fig3 --mesh 64x32 --quiet --save "$p/jean-fig3-64x32.hdf5" >/dev/null || exit 2
draw sensitivity-jean 0 info --sensitivity "$p/jean-fig3-64x32.hdf5"
draw map-wedge 1 map data/failures/c03-jam-below.txt --mu 0:3
draw map-catalogue 1 map data/failures/c*.txt
draw map-condition 0.5 map jean-fig3 --against condition
draw map-extrusion 3 map extrusion --rows 5 --mu 0.05:0.5
# takes half an hour of CPU and more: MESHES=1 asks for it
[ -z "${MESHES:-}" ] || draw map-extrusion-mesh 150 map extrusion --against mesh --rows 7 --mu 0.1:0.4
draw map-two-blocks 10 map two-blocks --rows 10 --mu 0.02:1
draw profile 1 profile -r 6 -b 1 jean-fig3 jean-fig4 data/fclib/*.hdf5 "$p"/*.hdf5
if [ "$longer" = 1 ]; then
  grep -e '^auto over' -e '^solved by' "$work/profile/log"
else
  awk '{ cells += $1; changed += $2 } END { print "cells that a longer limit changes: " changed " of " cells; exit changed > 0 }' "$work/counts"
fi
