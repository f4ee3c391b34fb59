#!/bin/sh
# check_lines.sh [DIRECTORY]: no room of the tree at DIRECTORY (here) has more lines than its budget below. What grows takes
# out as much elsewhere, or raises a number here: a change of its own, with the reason in its message.
cd "${1:-.}" || exit 2
while read -r room budget; do
  count=$(find "$room" -type f ! -path '*/build/*' | LC_ALL=C grep -E '\.(c|h|hpp|cpp|f90|py|awk|sh|gp)$' | tr '\n' '\0' | xargs -0 cat | wc -l)
  sum=$((${sum:-0} + count))
  [ "$count" -le "$budget" ] && continue
  echo "$room: $count lines, its budget is $budget (tests/check_lines.sh)"
  bad=1
done <<END
include 4671
src/base 1327
src/contact 3746
src/linear 4143
src/geometry 1174
lcp 3427
vi 9694
reduction 2057
global 3385
src/files 3698
src/facts 4051
src/auto 2448
src/front 2002
src/motion 1148
src/fe 4981
src/console 2297
src/problem 4595
src/charts 2713
src/report 2205
src/cli 2227
src/mpi 3847
src/python 2754
src/fortran 569
tests 66589
bench 12645
examples 2751
END
[ "${bad:-0}" = 0 ] && echo "lines: $sum, no room over its budget"
exit "${bad:-0}"
