#!/bin/sh
# run.sh BUILD [RUNNER]: runs every test program of BUILD/tests under RUNNER (valgrind, say), from the
# top of the repository, then every example against the expected output in its first comment.
set -u
build=$1
runner=${2:-}
passed=0
failed=0
export OPENBLAS_NUM_THREADS=1
export CK_TIMEOUT_MULTIPLIER=5 # a busy machine is no failure
[ -n "$runner" ] && export CK_FORK=no

for program in "$build"/tests/*/test_*; do
  [ -x "$program" ] || continue
  DELASSUS_PROGRAM=$build/delassus $runner "$program"
  if [ $? -eq 0 ]; then passed=$((passed + 1)); else failed=$((failed + 1)); echo "FAILED: $program"; fi
done

for source in examples/*.c; do
  program=$build/examples/$(basename "$source" .c)
  # expected output: the lines after " * Output:" of the first comment, up to its end
  expected=$(sed -n '/^ \* Output:/,/^ \*\//p' "$source" | sed -e '1d' -e '$d' -e 's/^ \* \{0,1\}//' -e 's/^  //')
  actual=$($runner "$program")
  if [ $? -eq 0 ] && [ -n "$expected" ] && [ "$expected" = "$actual" ]; then
    passed=$((passed + 1))
  else
    failed=$((failed + 1))
    echo "FAILED: $program"
    echo "expected:"; echo "$expected"; echo "printed:"; echo "$actual"
  fi
done

echo "$passed passed, $failed failed"
[ "$failed" -eq 0 ] && [ "$passed" -gt 0 ]
