#!/bin/sh
# install.sh BUILD: installs into a fresh directory (DESTDIR), builds and runs examples from what is there
# alone, with pkg-config and with CMake, looks at the man pages and the completion, and uninstalls.
set -eu
build=$1
root=$(mktemp -d)
trap 'rm -rf "$root"' EXIT
tree=$root/tree
make=${MAKE:-make}
export OPENBLAS_NUM_THREADS=1
fail() {
  echo "check-install: $*"
  exit 1
}
$make --no-print-directory install BUILD="$build" DESTDIR="$tree" PREFIX=/usr LIBDIR=/usr/lib/here > "$root/log" 2>&1 ||
  { cat "$root/log"; fail install; }
cp "$tree"/usr/share/doc/delassus/examples/point.c "$root"
cd "$root"
export LD_LIBRARY_PATH="$tree/usr/lib/here"
export PKG_CONFIG_SYSROOT_DIR="$tree" PKG_CONFIG_PATH="$tree/usr/lib/here/pkgconfig"
point='solved: r_n = 10.9375, r_t = -2.1875, x = 0.9375'
check() { # what, program
  [ "$("$2")" = "$point" ] || fail "$1: $("$2")"
  echo "$1: builds and runs from the installed tree"
}
${CC:-cc} -o point-c point.c $(pkg-config --cflags --libs delassus) -lm
check C ./point-c
if command -v cmake > /dev/null; then
  mkdir cmake
  printf '%s\n' 'cmake_minimum_required(VERSION 3.10)' 'project(point C)' 'find_package(delassus 0.1 REQUIRED)' \
    'add_executable(point ../point.c)' 'target_link_libraries(point delassus::delassus m)' > cmake/CMakeLists.txt
  (cd cmake && cmake -Ddelassus_DIR="$tree/usr/lib/here/cmake/delassus" . && cmake --build .) > log 2>&1 || { cat log; fail CMake; }
  check 'C by CMake' cmake/point
else
  echo 'no cmake: left out'
fi
"$tree/usr/bin/delassus" --version > /dev/null || fail program
for page in man1/delassus.1 man3/delassus.3; do
  grep -q '^.SH NAME' "$tree/usr/share/man/$page" || fail "$page"
  if command -v man > /dev/null; then
    man -l "$tree/usr/share/man/$page" > page 2> warnings || fail "$page"
    [ ! -s warnings ] || fail "$page: $(cat warnings)"
  fi
done
grep -q -e '\\-\\-stiffness' "$tree/usr/share/man/man1/delassus.1" || fail 'delassus.1 has no --stiffness'
if command -v bash > /dev/null; then
  PATH="$tree/usr/bin:$PATH" bash -c '. "$1"; COMP_WORDS=(delassus solve --stiff); COMP_CWORD=2; _delassus
    [ "${COMPREPLY[*]}" = --stiffness ]' - "$tree/usr/share/bash-completion/completions/delassus" || fail completion
fi
cd - > /dev/null
$make --no-print-directory uninstall BUILD="$build" DESTDIR="$tree" PREFIX=/usr LIBDIR=/usr/lib/here > "$root/log" 2>&1 || fail uninstall
left=$(find "$tree" ! -type d)
[ -z "$left" ] || fail "uninstall leaves $left"
echo 'man pages, completion, uninstall: fine'
