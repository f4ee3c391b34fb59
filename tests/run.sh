#!/bin/sh
# run.sh BUILD [RUNNER | --languages]: runs every test program of BUILD/tests under RUNNER (valgrind, say), from
# the top of the repository, then every example against the expected output in its first comment. --languages:
# those in C++, Fortran and Python alone. PYTHON: an interpreter with numpy and scipy, empty for none.
# HALF=1, HALF=2: side by side, each takes the next one that has not begun (a folder in BUILD/begun). BUILD/times, of a
# half BUILD/times.1 and .2: the CPU seconds of each; the ten longest are printed at the end.
set -u
build=$1
runner=${2:-}
languages=
[ "$runner" = --languages ] && languages=1 && runner=
passed=0
failed=0
times=$build/times${HALF:+.$HALF}
count=0
[ -z "${HALF:-}" ] || [ -w "$build/begun" ] || { echo "no $build/begun"; exit 1; }
: >"$times"
export OPENBLAS_NUM_THREADS=1
export CK_TIMEOUT_MULTIPLIER=5 # a busy machine is no failure
[ -n "$runner" ] && export CK_FORK=no
export PYTHONPATH=src/python PYTHONDONTWRITEBYTECODE=1 DELASSUS_LIBRARY=$build/libdelassus.so DELASSUS_PROGRAM=$build/delassus

# python SOURCE: runs it. A library with a sanitizer, or under a runner, does not go into an interpreter.
no_python=
if [ -z "${PYTHON:-}" ]; then no_python='no python3 with numpy and scipy'
elif [ -n "$runner" ] || nm -D "$build/libdelassus.so" | grep -q '__[atu]san_'; then no_python='left out of a checked build'
fi
have_python=${PYTHON:-}
[ -n "$no_python" ] && PYTHON=
skip() { tests/skip.sh "$@" || failed=$((failed + 1)); }
leave_out() { if [ -n "$have_python" ]; then echo "$1: $no_python"; else skip "$1, $no_python"; fi; }
export PYTHON DELASSUS_BUILD=$build
python() { "$PYTHON" "$@"; }

# clock: sets cpu to the CPU seconds of all programs so far
clock() {
  times >"$times.now"
  cpu=$(awk 'NR == 2 { split($1, u, /[ms]/); split($2, s, /[ms]/); printf "%.2f", 60 * (u[1] + s[1]) + u[2] + s[2] }' \
    "$times.now")
}

# run NAME COMMAND...: runs it unless the other half has begun it, counts it, writes its time
run() {
  name=$1
  shift
  count=$((count + 1))
  [ -z "${HALF:-}" ] || mkdir "$build/begun/$count" 2>/dev/null || return 0
  clock
  before=$cpu
  if "$@"; then passed=$((passed + 1)); else failed=$((failed + 1)); echo "FAILED: $name"; fi
  clock
  echo "$cpu $before $name" | awk '{ printf "%.2f %s\n", $1 - $2, $3 }' >>"$times"
}

for program in "$build"/tests/*/test_*; do
  [ -x "$program" ] || continue
  [ -n "$languages" ] && case $program in *-cpp | *-f90 | */test_door) ;; *) continue ;; esac
  run "${program#"$build"/}" $runner "$program"
done

for source in tests/languages/test_*.*; do
  case $source in
  *.c) ;;
  *.py)
    [ -n "$no_python" ] && leave_out "$source" && continue
    run "$source" python "$source" ;;
  *) [ -x "$build/${source%.*}-${source##*.}" ] || skip "$source, no compiler" ;;
  esac
done

# prints EXPECTED COMMAND...: succeeds if the command does and prints that
prints() {
  expected=$1
  shift
  actual=$("$@") && [ -n "$expected" ] && [ "$expected" = "$actual" ] && return 0
  echo "expected:"; echo "$expected"; echo "printed:"; echo "$actual"
  return 1
}

for source in examples/*.c examples/*.cpp examples/*.f90 examples/*.py examples/python/*.py; do
  name=$build/examples/$(basename "${source%.*}")
  case $source in
  *.py)
    [ -n "$no_python" ] && leave_out "$source" && continue
    set -- python "$source" ;;
  *.c)
    [ -n "$languages" ] && continue
    set -- $runner "$name" ;;
  *)
    [ -x "$name-${source##*.}" ] || { skip "$source, no compiler"; continue; }
    set -- $runner "$name-${source##*.}" ;;
  esac
  # expected output: the lines after "Output:" of the first comment, up to its end, without its marks
  expected=$(awk '/^( \*|!|#) *Output:/ { on = 1; next }
    on && /^( \*\/|[^ !#]|$)/ { exit }
    on { sub(/^( \*|!|#) ?/, ""); sub(/^  /, ""); print }' "$source")
  run "$source" prints "$expected" "$@"
  rounded=$build/rounded/${name##*/}
  case $source in *.c) [ -x "$rounded" ] && run "rounded/${name##*/}" prints \
    "$(echo "$expected" | sed 's/^solved:/solved to rounding:/')" $runner "$rounded" ;; esac
done
# the program of the first page is examples/point.c
if [ -z "$languages" ]; then
  run README.md prints "$(sed '1,/^ \*\/$/d' examples/point.c)" awk '/^```c$/ { on = 1; next } /^```/ { on = 0 } on' README.md
fi

rm -f "$times.now"
echo 'CPU seconds of the longest:'
sort -rn "$times" | head -10
echo "$passed passed, $failed failed"
[ "$failed" -eq 0 ] && [ "$count" -gt 0 ]
