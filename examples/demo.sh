#!/bin/sh
# demo.sh BUILD: the elastic block of Jean (1988), Figs. 3 and 4, with concentrated and with weighted
# reactions, by each method: the tables of the paper's own sweeps and of Lemke beside the paper's, then
# counts of sweeps, a summary of all methods, and one picture: the reactions of each method beside the
# paper's, node by node, with the differences.
set -eu
build=$1
export OPENBLAS_NUM_THREADS=1
results=$build/demo
rm -rf "$results"
line='================================================================================================'

# gauss-seidel works on the displacements, where weighted reactions couple the contact nodes
methods() {
  echo auto nlgs lemke newton admm augmented-lagrangian penalty jean
  [ "$1" = weighted ] || echo gauss-seidel
}

for scene in fig3 fig4; do
  for reactions in concentrated weighted; do
    for method in $(methods $reactions); do
      out=$results/jean-$scene-$reactions-$method
      mkdir -p "$out"
      weighted=
      [ $reactions = concentrated ] || weighted=--weighted
      # 1: not solved, which is what the error of the penalty method and the paper's stop amount to
      "$build/delassus" scene jean-$scene --method $method $weighted --tol 1e-14 --out "$out" --no-pictures \
        --reference data/jean-1988/${scene}_$reactions.csv > "$out/table.txt" || [ $? -eq 1 ]
      case $method in jean | lemke)
        echo "$line"
        cat "$out/table.txt"
        echo ;;
      esac
    done
  done
done

echo "$line"
echo "Sweeps until one changes no reaction by more than 1e-4 of the largest (method jean), and the paper's IS:"
for case in 'fig3 concentrated 62' 'fig3 weighted 85' 'fig4 concentrated 42' 'fig4 weighted 146'; do
  set -- $case
  awk -v what="$1 $2" -v paper="$3" 'NR == 1 { match($0, /[0-9]+ sweeps/)
    printf "%-20s %4d %4d\n", what, substr($0, RSTART), paper }' "$results/jean-$1-$2-jean/table.txt"
done
echo
echo "$line"
echo "Summary. Differences from the paper are over the largest value of the paper's column; the paper"
echo "printed 5 digits of a computation stopped at 1e-4. 'r - lemke': largest difference of the reactions"
echo "from Lemke's, over the largest reaction. Penalty is one augmentation, jean stops as the paper did:"
echo "their errors are left as they are."
echo
printf '%-40s %8s %8s %8s %8s  %9s  %-18s %s\n' run Q1 Q2 RT RN residual iterations 'r - lemke'
for scene in fig3 fig4; do
  for reactions in concentrated weighted; do
    columns=11 # of a contact.csv
    for method in $(methods $reactions); do
      out=$results/jean-$scene-$reactions-$method
      lemke=$results/jean-$scene-$reactions-lemke
      between=$(paste -d, "$out/contact.csv" "$lemke/contact.csv" | awk -F, -v columns=$columns '
        NR > 1 { for (k = 6; k <= 7; k++) { v = $(k + columns); d = $k - v; if (d < 0) d = -d; if (v < 0) v = -v
                 if (d > e) e = d; if (v > m) m = v } }
        END { printf("%.1e", (m > 0 ? e / m : 0)) }')
      awk -v name="$scene $reactions $method" -v between="$between" '
        NR == 1 { match($0, /, [0-9]+ [a-z]+, residual/); its = substr($0, RSTART + 2, RLENGTH - 12)
                  match($0, /residual [^ ]+/); res = substr($0, RSTART + 9, RLENGTH - 9) }
        /^largest diff/ { for (k = 1; k < NF; k++) if ($k ~ /^(Q1|Q2|RT|RN)$/ && !(($k) in v)) { x = $(k + 2); sub(/,/, "", x); v[$k] = x } }
        END { printf "%-40s %8s %8s %8s %8s  %9s  %-18s %s\n", name, v["Q1"], v["Q2"], v["RT"], v["RN"], res, its, between }' \
        "$out/table.txt"
    done
  done
done

# node by node: the paper's reactions, those of each method, and their differences over the largest of
# the paper's: from the paper's, and from those of Lemke's method
for scene in fig3 fig4; do
  for reactions in concentrated weighted; do
    for method in $(methods $reactions); do
      awk -F, -v name="$scene,$reactions,$method" '
        FNR == 1 { file++; next }
        file == 1 { t[$1] = $4; n[$1] = $5; if ($5 > most) most = $5; next }
        file == 2 { lt[$1] = $6; ln[$1] = $7; next }
        { print name "," $1 "," $6 "," $7 "," t[$1] "," n[$1] "," far($6, t[$1], $7, n[$1]) "," \
                far($6, lt[$1], $7, ln[$1]) }
        # a field of the paper that could not be read is empty: the other one counts alone
        function far(a, b, c, d) {
          a = b == "" ? 0 : a < b ? b - a : a - b
          c = d == "" ? 0 : c < d ? d - c : c - d
          return (a > c ? a : c) / most
        }' \
        data/jean-1988/${scene}_$reactions.csv "$results/jean-$scene-$reactions-lemke/contact.csv" \
        "$results/jean-$scene-$reactions-$method/contact.csv"
    done
  done
done > "$results/reactions.rows"
{
  echo scene,reactions,method,node,RT,RN,paper_RT,paper_RN,from_paper,from_lemke
  cat "$results/reactions.rows"
} > "$results/reactions.csv"
rm "$results/reactions.rows"
echo
echo "Tables: $results/*/table.txt. Deformed meshes for ParaView: $results/*/*.vtu"
if command -v gnuplot >/dev/null && gnuplot -e "data='$results/reactions.csv'; picture='$results/reactions.png'" examples/demo.gp; then
  echo "Picture: $results/reactions.png"
else
  echo "The picture needs gnuplot: examples/demo.gp, $results/reactions.csv"
fi
