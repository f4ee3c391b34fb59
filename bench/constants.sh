#!/bin/sh
# constants.sh [NAME...]: what each constant of src/auto/constants.h is worth: build/bench/auto --total with the constant
# halved and doubled, in a copy of the tree. NAME: as in constants.h without dlsi_auto_; default: all. SEED: of the
# problems (1). Writes bench/results/constants.md to stdout. Half an hour of CPU for all. Costs in sweeps are the same in
# every run.
set -eu
cd "$(dirname "$0")/.."
names=${*:-$(sed -n 's/^.*dlsi_auto_\([a-z_]*\) *= .*/\1/p' src/auto/constants.h)}
seed=${SEED:-1}
copy=$(mktemp -d)
trap 'rm -rf "$copy"' EXIT
git ls-files -z | xargs -0 cp --parents -pt "$copy"
cp -pr build "$copy/build"
export OPENBLAS_NUM_THREADS=1

value_of() {
  sed -n -E "s/^.*dlsi_auto_$1 *= ([0-9.e-]+).*/\1/p" src/auto/constants.h
}

# total FACTOR NAME: "SOLVED MEAN" with NAME times FACTOR
total() {
  as=$(awk -v f="$1" -v x="$(value_of "$2")" 'BEGIN { printf x == int(x) && x < 1e6 ? "%d" : "%.17g", f * x }')
  sed -E "s/^(.*dlsi_auto_$2 *= )([0-9.e-]+)(.*)/\1$as\3/" src/auto/constants.h >"$copy/src/auto/constants.h"
  make -C "$copy" -s build/bench/auto >&2 || { echo "- -"; return; } # another constant bounds it
  "$copy/build/bench/auto" --total "$seed" | sed -E 's/^([0-9]+) of .* mean ([0-9.]+); .*/\1 \2/'
}

# shellcheck disable=SC2046
set -- $(build/bench/auto --total "$seed" | sed -E 's/^([0-9]+) of ([0-9]+) .* mean ([0-9.]+); .*/\1 \2 \3/')
solved=$1 all=$2 mean=$3
cat <<HEAD
# What each constant of auto is worth

Written by \`SEED=$seed bench/constants.sh\`: $(bench/where.sh).

$all generated problems (bench/auto_price.c), 24 to 500 contacts, to 1e-6 and
1e-8. Unchanged, auto solves $solved of them, at $mean sweeps (geometric mean of the cost by src/auto/price.c, which is
the same in every run). Change of that cost with half and twice the constant; in brackets the change of the number solved.
The table in src/auto/constants.h has the reason for each value.

| constant | value | halved | doubled |
|---|---|---|---|
HEAD
for name in $names; do
  line="| \`$name\` | $(value_of "$name") |"
  for factor in .5 2; do
    # shellcheck disable=SC2046
    set -- $(total $factor "$name")
    line="$line $(awk -v a="$1" -v b="$2" -v s="$solved" -v m="$mean" 'BEGIN {
      if (a == "-") { printf "does not build"; exit }
      x = 100 * (b / m - 1); if (x < .05 && x > -.05) x = 0
      printf (x ? "%+.1f %%" : "%d"), x; if (a - s) printf " (%+d)", a - s }') |"
  done
  case $line in *"| 0 | 0 |") idle="${idle:+$idle, }\`$name\`" ;; *) echo "$line" ;; esac
done
[ -z "${idle:-}" ] || printf '\nWithout an effect on these problems: %s.\n' "$idle"
