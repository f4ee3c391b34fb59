#!/bin/sh
# check_public.sh [DIRECTORY]: two rules on the functions of include/delassus of the tree at DIRECTORY (here).
#
#   1 each has a user: Python, Fortran, C++, the program, an example or a page of the guide
#   2 each stands in docs/functions.md, in the row of its header, and each row names its header's functions alone
cd "${1:-.}" || exit 2
users="README.md include/delassus.hpp src/mpi/main.c $(find src/python/delassus src/fortran src/console src/problem src/charts src/report src/cli examples -type f)
  $(ls docs/*.md | grep -v -E '/(functions|contributing|decisions|source)\.md$')"
used=$(mktemp) && trap 'rm -f "$used"' EXIT || exit 2
LC_ALL=C grep -hoE 'dls_[a-z0-9_]+' $users | sort -u > "$used"
awk -v used="$used" '
  function report(text) { print text; bad = 1 }
  BEGIN { while ((getline name < used) > 0) is_used[name] = 1 }
  # rows of the page: | header | for | functions |
  FILENAME ~ /functions\.md$/ {
    if (!/^\| [a-z]*\.h /) next
    split($0, cell, /\|/); header = cell[2]; gsub(/ /, "", header)
    while (match(cell[4], /dls_[a-z0-9_]+/)) {
      row[substr(cell[4], RSTART, RLENGTH)] = header
      cell[4] = substr(cell[4], RSTART + RLENGTH)
    }
    next
  }
  FNR == 1 { header = FILENAME; sub(/.*\//, "", header); inside = 0 }
  /^DLS_API/ { inside = 1 }
  inside && match($0, /dls_[a-z0-9_]+\(/) {
    name = substr($0, RSTART, RLENGTH - 1); inside = 0; count++
    if (!(name in is_used)) report(FILENAME ":" FNR ": no language, program, example or page uses " name)
    if (row[name] != header) report(FILENAME ":" FNR ": docs/functions.md does not name " name " beside " header)
    delete row[name]
  }
  END {
    for (name in row) if (row[name] != "") report("docs/functions.md: " name " is not in " row[name])
    if (!bad) print "public: " count " functions, each with a user and a place in docs/functions.md"
    exit bad
  }' docs/functions.md include/delassus/*.h
