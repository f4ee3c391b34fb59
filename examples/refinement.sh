#!/bin/sh
# refinement.sh BUILD: Proposition 1 of Jean (1988), 4.3, as a table and a picture: densities of reaction of
# Fig. 3's block under refinement of the mesh. Weighted reactions are densities on the dual cells, r / M;
# concentrated ones are brought to densities in two ways: r / M, and P^-1 r / M, the second column pair of
# the paper's first table.
set -eu
build=$1
export OPENBLAS_NUM_THREADS=1
results=$build/refinement
rm -rf "$results"
mkdir -p "$results"
meshes='16x8 32x16 64x32 128x64'
finest=256x128

# rows x, half of the cell, R_N, R_T as densities
density() { # mesh, option, column of r_t, file
  "$build/delassus" scene jean-fig3 --mesh "$1" $2 --tol 1e-14 --out "$results/run" --no-pictures > /dev/null
  awk -F, -v k="$3" 'NR > 1 { print $2, $11 / 2, $(k + 1) / $11, $k / $11 }' "$results/run/contact.csv" > "$4"
}

for mesh in $meshes $finest; do
  density $mesh --weighted 6 "$results/weighted_$mesh.dat"
  density $mesh '' 6 "$results/concentrated_$mesh.dat"
  density $mesh '' 9 "$results/inverse_$mesh.dat"
done
rm -rf "$results/run"

echo "Densities of reaction of jean-fig3. Distance: L2 norm of the difference from the weighted densities on the"
echo "mesh $finest, over the norm of those. Smallest: least normal density over the largest."
echo
printf '%-8s' mesh
for kind in weighted concentrated inverse; do
  printf ' | %-12s %8s %8s %8s' $kind 'R_N' 'R_T' 'smallest'
done
echo
for mesh in $meshes; do
  printf '%-8s' $mesh
  for kind in weighted concentrated inverse; do
    # a coarse density at the middle of each fine cell
    awk 'NR == FNR { x[NR] = $1; n[NR] = $3; t[NR] = $4; count = NR
                     if (NR == 1 || $3 < least) least = $3
                     if (NR == 1 || $3 > most) most = $3
                     next }
         FNR == 1 { middle = $1 + $2; k = 1; half = $2 } # half a cell, at the free end
         FNR > 1 { middle = $1; half = $2 }
         { while (k < count && middle > (x[k] + x[k + 1]) / 2) k++
           N += half * (n[k] - $3) ^ 2; T += half * (t[k] - $4) ^ 2; N0 += half * $3 ^ 2; T0 += half * $4 ^ 2 }
         END { printf " | %-12s %8.4f %8.4f %8.0e", "", sqrt(N / N0), sqrt(T / T0), least / most }' \
      "$results/${kind}_$mesh.dat" "$results/weighted_$finest.dat"
  done
  echo
done

cat > "$results/refinement.gp" << END
set terminal pngcairo size 1500,1000 font ',12'
set output 'refinement.png'
set multiplot layout 2,3 title 'Normal density of reaction, jean-fig3: whole, and where contact begins'
set xlabel 'x [mm]'
set ylabel 'R_N [GPa]'
set grid
set key top left
kind = 'weighted concentrated inverse'
name = '"weighted, r / M" "concentrated, r / M" "concentrated, P^{-1} r / M"'
do for [row=1:2] {
  if (row == 1) { set xrange [0.8:4]; set yrange [-0.1:1.4] }
  else { set xrange [0.9:1.6]; set yrange [-0.05:0.45] }
  do for [k=1:3] {
    set title word(name, k)
    plot for [mesh in '$meshes'] word(kind, k).'_'.mesh.'.dat' using (\$1*1e3):(\$3*1e-9) \\
      with linespoints lw 1.5 pt 7 ps (mesh eq '16x8' ? 1.1 : mesh eq '32x16' ? 0.8 : 0.4*row) title mesh
  }
}
unset multiplot
END
echo
if (cd "$results" && gnuplot refinement.gp); then
  echo "Picture: $results/refinement.png"
else
  echo "The picture needs gnuplot: $results/refinement.gp"
fi
