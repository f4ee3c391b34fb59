#!/bin/sh
# million.sh PROGRAM DIR [SEED [PIECES [COUNT]]]: runs the program of properties in pieces (20 of 50,000 problems, even
# seeds), prints each class summed over the pieces that are done, and every rule broken. A piece has a log of its own,
# DIR/SEED.txt; called again, it goes on where it was stopped. Exit 1 if a piece is not done or broke a rule.
program=$1 dir=$2 seed=${3:-980000000} pieces=${4:-20} count=${5:-50000} bad=0
export OPENBLAS_NUM_THREADS=1
mkdir -p "$dir" || exit 2
for k in $(seq 0 $((pieces - 1))); do
  at=$((seed + 2 * count * k))
  log=$dir/$at.txt
  tail -n 1 "$log" 2>/dev/null | grep -q '^status ' && continue
  "$program" --seed $at --step 2 --count "$count" --out "$dir/found" >"$log" 2>&1
  echo "status $?" >>"$log"
done
cat "$dir"/*.txt | awk '
  /^class / { table = 1; next }
  /^rules broken/ { table = 2; next }
  $2 !~ /^[0-9]+$/ { table = 0 }
  table && !($1 in of) { of[$1] = ++classes; name[classes] = $1 }
  table == 1 { problems[$1] += $2; solvable[$1] += $3; solved[$1] += $4; ms[$1] += $2 * $NF
               rounding[$1] += $6; proved[$1] += $9; likely[$1] += $8 }
  table == 2 { for (k = 2; k <= NF - 5; k++) broken[$1] += $k
               if ($NF > error[$1]) error[$1] = $NF }
  /^not solved: / { symmetric[$NF]++ }
  END {
    printf "| class | problems | solvable | solved | to rounding | symmetric, not solved | likely | proved | true error | rules broken | ms |\n"
    printf "|---|---|---|---|---|---|---|---|---|---|---|\n"
    for (k = 1; k <= classes; k++) {
      c = name[k]
      printf "| %s | %d | %d | %d | %d | %d | %d | %d | %.1e | %d | %.2f |\n", c, problems[c], solvable[c], solved[c],
             rounding[c], symmetric[c], likely[c], proved[c], error[c], broken[c], ms[c] / problems[c]
      all[1] += problems[c]; all[2] += solvable[c]; all[3] += solved[c]; all[4] += symmetric[c]
      all[5] += likely[c]; all[6] += proved[c]; all[7] += broken[c]; all[8] += rounding[c]; total += ms[c]
      if (error[c] > all[9]) all[9] = error[c]
    }
    printf "| all | %d | %d | %d | %d | %d | %d | %d | %.1e | %d | %.2f |\n", all[1], all[2], all[3], all[8], all[4],
           all[5], all[6], all[9], all[7], total / all[1]
    exit all[7] > 0
  }' || bad=1
grep -h '^broken in' "$dir"/*.txt && bad=1
for log in "$dir"/*.txt; do
  tail -n 1 "$log" | grep -q '^status 0' || { echo "$log: $(tail -n 1 "$log")"; bad=1; }
done
exit $bad
