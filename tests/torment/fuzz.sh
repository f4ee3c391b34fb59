#!/bin/sh
# fuzz.sh MAKE BUILD SECONDS TARGET...: builds the targets with clang's libFuzzer under the address and undefined
# sanitizers, and runs each for SECONDS from the seeds that the targets name, with what earlier runs have found in
# BUILD/corpus. An input of 10 s of CPU (fuzz.c; 5 minutes by the clock) or an allocation of 64 MB is a failure; the input
# that fails stays in BUILD.
set -u
make=$1
build=$(mkdir -p "$2" && cd "$2" && pwd) # targets change the directory
seconds=$3
$make --no-print-directory "$2/tests/torment/fuzz" BUILD="$2" CC=clang CFLAGS='-O1 -g -fno-omit-frame-pointer' \
  SANITIZE='-fsanitize=fuzzer-no-link,address,undefined -fno-sanitize-recover=all' FUZZ_LINK=-fsanitize=fuzzer \
  FUZZ_CPP=-DFUZZ_ENGINE || exit 1
shift 3
bad=0
export OPENBLAS_NUM_THREADS=1 ASAN_OPTIONS=quarantine_size_mb=16:allocator_may_return_null=1
echo leak:libhdf5 >"$build/leaks" # H5Fopen leaks 424 bytes of its own where a file is broken
export LSAN_OPTIONS=suppressions=$build/leaks:print_suppressions=0
for target in "$@"; do
  program=$build/tests/torment/fuzz-$target
  ln -f "$build/tests/torment/fuzz" "$program" || exit 1
  mkdir -p "$build/corpus/$target"
  for seed in $("$program" --seeds); do cp "data/$seed" "$build/corpus/$target/"; done
  "$program" -max_total_time="$seconds" -max_len=16384 -timeout=300 -malloc_limit_mb=64 -rss_limit_mb=1024 -len_control=0 \
    -close_fd_mask=3 -print_final_stats=1 -artifact_prefix="$build/$target-" "$build/corpus/$target" >"$build/$target.log" 2>&1
  status=$?
  runs=$(sed -n 's/^stat::number_of_executed_units: *//p' "$build/$target.log")
  slow=$(sed -n 's/^stat::slowest_unit_time_sec: *//p' "$build/$target.log")
  peak=$(sed -n 's/^stat::peak_rss_mb: *//p' "$build/$target.log")
  if [ $status -eq 0 ]; then word=good; else word="FAILED, see $build/$target.log"; bad=1; fi
  echo "$target: ${runs:-?} inputs, slowest ${slow:-?} s, peak ${peak:-?} MB under the sanitizers: $word"
done
exit $bad
