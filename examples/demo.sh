#!/bin/sh
# demo.sh BUILD: the elastic block of Jean (1988), Figs. 3 and 4, with concentrated and with weighted
# reactions, by each method: tables beside the paper's, then a summary and where the pictures are.
set -eu
build=$1
export OPENBLAS_NUM_THREADS=1
results=$build/demo
mkdir -p "$results"
for scene in fig3 fig4; do
  for reactions in concentrated weighted; do
    for method in nlgs lemke; do
      out=$results/jean-$scene-$reactions-$method
      rm -rf "$out"
      mkdir -p "$out"
      weighted=
      [ $reactions = weighted ] && weighted=--weighted
      echo "================================================================================================"
      "$build/delassus" scene jean-$scene --method $method $weighted --out "$out" \
        --reference data/jean-1988/${scene}_$reactions.csv > "$out/table.txt"
      cat "$out/table.txt"
      echo
    done
  done
done

echo "================================================================================================"
echo "Summary. Differences from the paper are over the largest value of the paper's column; the paper"
echo "printed 5 digits of a computation stopped at 1e-4. 'nlgs-lemke': the two methods' r over max |r|."
echo
printf '%-28s %9s %9s %9s %9s  %9s  %-18s %s\n' run Q1 Q2 RT RN residual iterations nlgs-lemke
for scene in fig3 fig4; do
  for reactions in concentrated weighted; do
    for method in nlgs lemke; do
      out=$results/jean-$scene-$reactions-$method
      other=$results/jean-$scene-$reactions-nlgs
      between=-
      [ $method = nlgs ] || between=$(paste -d, "$out/contact.csv" "$other/contact.csv" | awk -F, -v half=$([ $reactions = weighted ] && echo 10 || echo 8) '
        NR > 1 { for (k = 6; k <= 7; k++) { v = $(k + half); d = $k - v; if (d < 0) d = -d; if (v < 0) v = -v
                 if (d > e) e = d; if (v > m) m = v } }
        END { printf("%.1e", (m > 0 ? e / m : 0)) }')
      awk -v name="$scene $reactions $method" -v between="$between" '
        NR == 1 { match($0, /: [a-z ]+, [0-9]+ [a-z]+/); its = substr($0, RSTART, RLENGTH); sub(/.*, /, "", its)
                  match($0, /residual [^ ]+/); res = substr($0, RSTART + 9, RLENGTH - 9) }
        /^largest diff/ { for (k = 1; k < NF; k++) if ($k ~ /^(Q1|Q2|RT|RN)$/ && !(($k) in v)) { x = $(k + 2); sub(/,/, "", x); v[$k] = x } }
        END { printf "%-28s %9s %9s %9s %9s  %9s  %-18s %s\n", name, v["Q1"], v["Q2"], v["RT"], v["RN"], res, its, between }' \
        "$out/table.txt"
    done
  done
done
echo
echo "Pictures (PNG and SVG, data beside them): $results/*/deformed.png, $results/*/reactions.png"
echo "Deformed meshes for ParaView: $results/*/*.vtu"
