#!/bin/sh
# charts.sh BUILD [OUT]: draws every picture of the docs from scratch into OUT (docs/pictures). Data, scripts
# and tables stay in BUILD/charts/NAME, and what each command printed in BUILD/charts/NAME/log.
set -u
build=$1
out=${2:-docs/pictures}
work=$build/charts
export OPENBLAS_NUM_THREADS=1
rm -rf "${work:?}"
mkdir -p "$out" "$work/problems" || exit 2

# draw PICTURE COMMAND...: runs `delassus COMMAND... -o DIRECTORY`, keeps its picture. Status 1 is a verdict.
draw() {
  picture=$1
  shift
  mkdir -p "$work/$picture"
  "$build/delassus" "$@" -o "$work/$picture" >"$work/$picture/log" 2>&1
  status=$?
  if [ $status -gt 1 ]; then
    cat "$work/$picture/log" >&2
    exit $status
  fi
  name=$1
  [ "$name" != info ] || name=sensitivity
  cp "$work/$picture/$name.png" "$out/$picture.png" 2>/dev/null || { cat "$work/$picture/log" >&2; exit 2; }
  echo "$out/$picture.png"
}

p=$work/problems
"$build/bench/problems" "$p" wall-3x2 wall-6x5 t3-16 t3-64 h8-6 h8-12-tilt-mu0.3 || exit 2
"$build/delassus" scene indentation --method lemke --save "$p/indentation-step.hdf5" >/dev/null || exit 2

draw profile profile -r 6 -b 1 -l 0.3 jean-fig3 jean-fig4 data/fclib/*.hdf5 "$p"/*.hdf5
draw chart-jean chart jean-fig3
draw chart-granular chart data/fclib/gfc2d_granularflowonwall_00069_00350.hdf5
draw chart-wall chart "$p/wall-6x5-push0.3-mu1.hdf5"
draw chart-cube chart "$p/h8-12-tilt-mu0.3.hdf5"
draw chart-indentation chart "$p/indentation-step.hdf5"
draw chart-scales chart data/failures/c20-scales.txt
"$build/delassus" scene jean-fig3 --mesh 64x32 --quiet --save "$p/jean-fig3-64x32.hdf5" >/dev/null || exit 2
draw sensitivity-jean info --sensitivity "$p/jean-fig3-64x32.hdf5"
draw map-jean map jean-fig3
draw map-wedge map data/failures/c03-jam-below.txt --mu 0:3
draw map-catalogue map data/failures/c*.txt
draw map-condition map jean-fig3 --against condition
draw map-extrusion map extrusion --rows 5 --mu 0.05:0.5 --limit 1
# takes half an hour of CPU and more: MESHES=1 asks for it
[ -z "${MESHES:-}" ] || draw map-extrusion-mesh map extrusion --against mesh --rows 7 --mu 0.1:0.4 --limit 1500
draw map-two-blocks map two-blocks --rows 10 --mu 0.02:1
tail -n 3 "$work/profile/log" | head -n 2
