#!/bin/sh
# check_arrows.sh BUILD [-v]: no arrow of the library runs up or sideways. The rooms, the floor first:
#
#   include <- src/base <- src/contact <- src/linear <- { lcp, vi } <- { reduction, global, src/files } <- src/facts <- src/auto <- src/front <- src/motion <- src/fe <- src/console <- src/problem <- src/charts <- src/report <- src/cli
#
# Read from the sources: every #include. Read from the objects under BUILD/obj: every symbol that one file
# defines and another uses. A public header belongs to the room whose file it names; a header that names none
# is the floor's. Two files that use each other's symbols, directly or around a corner, are a circle.
# -v lists the arrows.
set -u
build=$1
tmp=$(mktemp -d) || exit 1
trap 'rm -rf "$tmp"' EXIT

# ROOM LEVEL pairs; a room may use those of lower levels and itself
cat >"$tmp/rooms" <<'END'
include 0  src/base 1  src/contact 2  src/linear 3  src/geometry 3  lcp 4  vi 4  vi/sweep 5
vi/newton 6  vi/primal 6  vi/split 7  vi/path 8  reduction 9  global 9  src/files 9  src/facts 10
src/auto 11  src/front 12  src/motion 13  src/fe 14  src/console 15  src/problem 16  src/charts 17
src/report 18  src/cli 19  src/mpi 20  src/fortran 15
END

# the public headers and their rooms
cat >"$tmp/headers" <<'END'
lcp.h lcp  pivoting.h lcp  facets.h lcp  nlgs.h vi  newton.h vi  admm.h vi  augmented.h vi
primal.h vi  reduction.h reduction  global.h global  files.h src/files  pairs.h src/geometry
rigid.h src/geometry  trust.h src/facts  derive.h src/facts  solve.h src/front  diagnose.h src/front
layout.h src/front  limit.h src/front  motion.h src/motion  fe.h src/fe  forming.h src/fe
moving.h src/fe  mpi.h src/mpi
END

# includes: FILE HEADER, both from the top of the tree; a header is looked for beside its user, then in
# include, in src and at the top
sources=$(ls src/*/*.[ch] lcp/*.[ch] vi/*.[ch] vi/*/*.[ch] reduction/*.[ch] global/*.[ch] include/delassus/*.h)
ls include/*.h $sources | awk '
  FNR == NR { is[$1] = 1; next }
  /^#include "/ {
    split($0, part, "\""); place = FILENAME; sub(/[^\/]*$/, "", place)
    n = split(place " include/ src/ ./", places, " ")
    for (k = 1; k <= n; k++) {
      header = places[k] part[2]; sub(/^\.\//, "", header)
      if (header in is) { print FILENAME, header; break }
    }
  }' - $sources >"$tmp/includes"

# symbols: D or U, FILE, name
objects=$(echo "$sources" | sed -n 's/\.c$/.o/p') # a file that is gone may have left one
(cd "$build/obj" && ls $objects 2>/dev/null | xargs nm -A) | awk '
  { file = $1; sub(/\.o:.*/, ".c", file) }
  $(NF - 1) == "U" { print "U", file, $NF }
  $(NF - 1) ~ /^[TDRBWi]$/ { print "D", file, $NF }' >"$tmp/symbols"
# uses: FILE FILE, user and definer
awk '$1 == "D" { at[$3] = $2 } $1 == "U" { n++; user[n] = $2; name[n] = $3 }
  END { for (k = 1; k <= n; k++) if ((name[k] in at) && at[name[k]] != user[k]) print user[k], at[name[k]] }' \
  "$tmp/symbols" | sort -u >"$tmp/uses"

awk -v list="${2:-}" '
  function room(file,   k, name) {
    if (file ~ /^include\//) {
      name = file; sub(/.*\//, "", name)
      return name in header ? header[name] : "include"
    }
    sub(/\/[^\/]*$/, "", file)
    return file
  }
  FILENAME ~ /rooms$/ { for (k = 1; k < NF; k += 2) level[$k] = $(k + 1); next }
  FILENAME ~ /headers$/ { for (k = 1; k < NF; k += 2) header[$k] = $(k + 1); next }
  {
    from = room($1); to = room($2); arrows[from " " to] = 1
    if (!(from in level)) { print $1 ": " from " is no room"; bad = 1 }
    else if (!(to in level)) { print $2 ": " to " is no room"; bad = 1 }
    else if (from != to && level[to] >= level[from]) {
      print (FILENAME ~ /uses$/ ? "call: " : "include: ") $1 " -> " $2; bad = 1
    }
    # a circle within a room: calls of files
    if (FILENAME ~ /uses$/ && from == to) { n++; a[n] = $1; b[n] = $2; reach[$1, $2] = 1; file[$1] = file[$2] = 1 }
  }
  END {
    for (k in file) for (i in file) if ((i, k) in reach) for (j in file) if ((k, j) in reach) reach[i, j] = 1
    for (i in file) if ((i, i) in reach) { print "circle through " i; bad = 1 }
    for (k in arrows) {
      split(k, p, " ")
      if (p[1] == p[2]) continue
      count++
      if (list) print p[1] " -> " p[2]
    }
    if (!bad) print "arrows: " count " between rooms, none up or sideways, no circle"
    exit bad
  }' "$tmp/rooms" "$tmp/headers" "$tmp/includes" "$tmp/uses"
