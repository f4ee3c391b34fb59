#!/bin/sh
# demo.sh BUILD: the elastic block of Jean (1988), Figs. 3 and 4, with concentrated and with weighted
# reactions, by each method beside the paper: one table and one picture, the reactions of each method
# node by node with their differences.
set -eu
build=$1
export OPENBLAS_NUM_THREADS=1
results=$build/demo
rm -rf "$results"

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
    done
  done
done

cat <<'END'
An elastic block is pressed onto a rough plane and pulled along it: Jean (1988), Figs. 3 and 4, 16 contact
nodes, friction 1 and 0.1 [m, N], reactions concentrated at the nodes or weighted. Each method solves it to
1e-14. Differences are relative to the largest value: of displacements Q and reactions R from the paper's
tables, which have 5 digits of sweeps stopped at 1e-4, and of reactions from Lemke's method, which is exact.

method                   Q: paper  R: paper  R: lemke  residual  work              ended
END
for scene in fig3 fig4; do
  for reactions in concentrated weighted; do
    echo "Fig. ${scene#fig}, $reactions reactions"
    columns=11 # of a contact.csv
    case $scene-$reactions in
    fig3-concentrated) paper=62 ;; fig3-weighted) paper=85 ;; fig4-concentrated) paper=42 ;; *) paper=146 ;;
    esac
    for method in $(methods $reactions); do
      out=$results/jean-$scene-$reactions-$method
      lemke=$results/jean-$scene-$reactions-lemke
      between=$(paste -d, "$out/contact.csv" "$lemke/contact.csv" | awk -F, -v columns=$columns '
        NR > 1 { for (k = 6; k <= 7; k++) { v = $(k + columns); d = $k - v; if (d < 0) d = -d; if (v < 0) v = -v
                 if (d > e) e = d; if (v > m) m = v } }
        END { printf("%.0e", (m > 0 ? e / m : 0)) }')
      case $method in
      jean) ended="stopped as the paper did (there: $paper)" ;;
      penalty) ended='one augmentation, its error stays' ;;
      *) ended= ;;
      esac
      awk -v name="$method" -v between="$between" -v ended="$ended" '
        NR == 1 { match($0, /, [0-9]+ [a-z]+, residual/); its = substr($0, RSTART + 2, RLENGTH - 12)
                  match($0, /residual [^ ,]+/); res = substr($0, RSTART + 9, RLENGTH - 9) }
        /^largest diff/ { for (k = 1; k < NF; k++) if ($k ~ /^(Q1|Q2|RT|RN)$/) { x = $(k + 2); sub(/,/, "", x)
                          c = substr($k, 1, 1); if (!(($k) in v)) { v[$k] = 1; if (x + 0 > far[c]) far[c] = x + 0 } } }
        END { if (ended == "") { ended = $0 }
              printf "  %-22s %9.0e %9.0e %9s %9.0e  %-16s  %s\n", name, far["Q"], far["R"], between, res, its, ended }' \
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
        file == 2 { lt[$1 + 1] = $6; ln[$1 + 1] = $7; next } # ours count from 0
        { k = $1 + 1; print name "," k "," $6 "," $7 "," t[k] "," n[k] "," far($6, t[k], $7, n[k]) "," \
                far($6, lt[k], $7, ln[k]) }
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
echo "The rest: the paper's tables beside ours $results/*/table.txt, deformed meshes for ParaView $results/*/*.vtu"
if command -v gnuplot >/dev/null && gnuplot -e "data='$results/reactions.csv'; picture='$results/reactions.png'" examples/demo.gp; then
  echo "Picture: $results/reactions.png"
else
  echo "The picture needs gnuplot: examples/demo.gp, $results/reactions.csv"
fi
