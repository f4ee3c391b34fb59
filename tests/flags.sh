#!/bin/sh
# flags.sh MAKE BUILD CC [all]: the flags that make a wrong library are refused: arithmetic that forgets NaN, sums in
# another order, the x87's precision. What is built has the guards against overruns, and does not name its folder: two
# folders give the same bytes. all: library and program compile and link without a warning under flags of every
# kind, with gcc and, where it is there, clang. From the top of the repository.
set -u
make=$1
build=$2
cc=$3
bad=0
compiles() { echo '#include "base/base.h"' | $cc -std=c11 "$@" -Iinclude -Isrc -fsyntax-only -xc - 2>/dev/null; }

compiles -O2 || { echo "base.h does not compile"; bad=1; }
refused=0
for flag in -Ofast -ffast-math -ffinite-math-only '-O2 -fassociative-math -fno-signed-zeros -fno-trapping-math' \
  '-m32 -mfpmath=387'; do
  case $flag in
  -m32*) echo 'int x;' | $cc -m32 -fsyntax-only -xc - 2>/dev/null || continue ;;
  *assoc*) $cc --version | grep -q clang && continue ;; # tells nobody
  esac
  refused=$((refused + 1))
  # shellcheck disable=SC2086
  compiles $flag && echo "not refused: $flag" && bad=1
done
echo "flags: $refused refused"

so=$build/libdelassus.so
has() { readelf -Ws "$1" | grep -q -e "$2" || { echo "flags: $1 has no $2"; bad=1; }; }
if [ -z "${HARDEN-guards}" ]; then echo "flags: built without guards"
elif command -v readelf >/dev/null; then
  readelf -d "$so" | grep -q -e BIND_NOW -e 'FLAGS.*NOW' || { echo "flags: $so is not bound at its start"; bad=1; }
  has "$so" __stack_chk_fail
  has "$build/delassus" __stack_chk_fail
  has "$build/delassus" '__[a-z]*printf_chk'
fi
folders=$(mktemp -d)
for folder in one two; do
  mkdir -p "$folders/$folder/src"
  cp -r Makefile include "$folders/$folder"
  cp -r src/base "$folders/$folder/src"
  $make -s --no-print-directory -C "$folders/$folder" BUILD=build build/obj/src/base/number.o >/dev/null || bad=1
done
cmp "$folders/one/build/obj/src/base/number.o" "$folders/two/build/obj/src/base/number.o" || bad=1
rm -rf "$folders"
[ "${4:-}" = all ] || exit $bad

# try NAME VARIABLE...: builds with these variables of make
try() {
  name=$1
  shift
  if $make --no-print-directory BUILD="$build/flags" WERROR=-Werror "$@" "$build/flags/libdelassus.so" \
    "$build/flags/delassus" >"$build/flags.log" 2>&1; then
    echo "flags: $name without a warning"
  else
    echo "flags: $name"; grep -E 'warning|error' "$build/flags.log" | head -20; bad=1
  fi
  rm -rf "$build/flags"
}
try 'gcc -O0' CC=gcc CFLAGS=-O0
try 'gcc -O3 -march=native' CC=gcc CFLAGS='-O3 -march=native'
try 'gcc -std=c17' CC=gcc CFLAGS='-O2 -std=c17'
try 'gcc -std=c2x' CC=gcc CFLAGS='-O2 -std=c2x'
try 'gcc -flto' CC=gcc AR=gcc-ar CFLAGS='-O2 -flto' LDFLAGS='-O2 -flto'
command -v clang >/dev/null && try clang CC=clang CFLAGS=-O2 && try 'clang -O0 -std=c2x' CC=clang CFLAGS='-O0 -std=c2x'
exit $bad
