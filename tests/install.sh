#!/bin/sh
# install.sh BUILD: installs into a fresh directory (DESTDIR), builds and runs an example in C (with pkg-config
# and with CMake, also from a moved tree), C++, Fortran and Python from what is there alone, looks at the man pages and
# the completion, and uninstalls. A host with a MUMPS of its own works. The version is the same everywhere. MPI=1 in the
# environment: libdelassus-mpi, too. tests/packages.sh does the same for Python's packages. PYTHON: an interpreter with numpy and scipy, empty for none.
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
run_make() { # target
  $make --no-print-directory "$1" BUILD="$build" DESTDIR="$tree" PREFIX=/usr LIBDIR=/usr/lib/here PYTHON="${PYTHON:-}" \
    > "$root/log" 2>&1 || { cat "$root/log"; fail "$1"; }
}
# the source of a fresh clone, without a build
if git rev-parse --git-dir > "$root/log" 2>&1; then
  git clone -q . "$root/clone"
  (cp Makefile "$root/clone/" && cd "$root/clone" && $make --no-print-directory dist > "$root/log" 2>&1) ||
    { cat "$root/log"; fail dist; }
  echo "dist: the source of a fresh clone"
fi
run_make install
[ -z "${PYTHON:-}" ] || run_make install-python
work=$(pwd)
cd "$root"
cp "$tree"/usr/share/doc/delassus/examples/point.* .
export LD_LIBRARY_PATH="$tree/usr/lib/here"
export PKG_CONFIG_SYSROOT_DIR="$tree" PKG_CONFIG_PATH="$tree/usr/lib/here/pkgconfig"
flags=$(pkg-config --cflags --libs delassus)
point='solved: r_n = 10.9375, r_t = -2.1875, x = 0.9375'
check() { # language, program and arguments: its first line has to be the point's
  language=$1
  shift
  "$@" > printed || fail "$language: exit status $?"
  [ "$(sed 1q printed | tr -s ' ')" = "$point" ] || fail "$language: $(cat printed)"
  echo "$language: builds and runs from the installed tree"
}
${CC:-cc} -o point-c point.c $flags -lm
check C ./point-c
# the core needs no HDF5; what reads files is a library of its own
if command -v ldd > /dev/null && ldd "$tree/usr/lib/here/libdelassus.so" | grep -i hdf5; then fail 'libdelassus.so needs HDF5'; fi
cat > files.c << 'END'
#include <stdio.h>
#include <delassus.h>
int main(void) {
  int rows, cols;
  double *a;
  dls_error error = {0};
  dls_status status = dls_mtx_read("two.mtx", &rows, &cols, &a, &error);
  if (status) return printf("%s\n", error.message), 1;
  printf("%d x %d, %g, %s\n", rows, cols, a[1], dls_status_text(status));
  dls_mtx_free(a);
  dls_fclib *file;
  status = dls_fclib_read(&file, "none.hdf5", &error);
  printf("%s\n", dls_status_name(status));
  return 0;
}
END
printf '%s\n' '%%MatrixMarket matrix array real general' '2 1' 3 4 > two.mtx
reads() { # way and program
  [ "$("$2" | sed 's/DLS_E_UNSUPPORTED/DLS_E_FILE/' | tr '\n' '/')" = '2 x 1, 4, solved/DLS_E_FILE/' ] ||
    fail "files by $1: $("$2")"
  echo "files by $1: libdelassus-files reads"
}
${CC:-cc} -o files-c files.c $(pkg-config --cflags --libs delassus-files)
reads pkg-config ./files-c
${CC:-cc} -o files-static files.c -I"$tree/usr/include" "$tree"/usr/lib/here/libdelassus-files.a "$tree"/usr/lib/here/libdelassus.a \
  $(sed -n 's/^Libs.private: //p' "$tree"/usr/lib/here/pkgconfig/delassus-files.pc "$tree"/usr/lib/here/pkgconfig/delassus.pc)
reads 'static libraries' ./files-static
if command -v "${CXX:-c++}" > /dev/null; then
  ${CXX:-c++} -std=c++17 -o point-cpp point.cpp $flags
  check C++ ./point-cpp
else
  "$work/tests/skip.sh" "C++, no ${CXX:-c++}"
fi
if command -v "${FC:-gfortran}" > /dev/null; then
  ${FC:-gfortran} -c "$tree/usr/include/delassus.f90"
  ${FC:-gfortran} -o point-f90 point.f90 delassus.o $flags
  check Fortran ./point-f90
else
  "$work/tests/skip.sh" "Fortran, no ${FC:-gfortran}"
fi
if [ -n "${PYTHON:-}" ]; then
  package=$(find "$tree" -type d -name delassus -path '*/python*')
  check Python env PYTHONPATH="${package%/delassus}" "$PYTHON" point.py
  # the wheel, the source package and an editable install: tests/packages.sh
  (cd "$work" && env -u LD_LIBRARY_PATH PYTHON="$PYTHON" tests/packages.sh "$tree/usr/lib/here/libdelassus.so.0") || fail packages
else
  "$work/tests/skip.sh" 'Python, no python3 with numpy and scipy'
fi
# a host's global symbols with the names of MUMPS, MPI and SCOTCH
cp "$work"/tests/hosts/poison.c "$work"/tests/hosts/unsymmetric.[ch] .
private=$(sed -n 's/^Libs.private: //p' "$tree"/usr/lib/here/pkgconfig/delassus.pc)
${CC:-cc} -rdynamic -o poison-so poison.c unsymmetric.c $flags -lm
${CC:-cc} -rdynamic -o poison-a poison.c unsymmetric.c -I"$tree/usr/include" "$tree"/usr/lib/here/libdelassus.a $private
for program in poison-so poison-a; do
  case $private in *gfortran*) ;; *) echo 'skipped: a host with its own MUMPS, a build without MUMPS'; break ;; esac
  ./$program > printed || fail "$program: $(cat printed)"
  echo "$program: a host's own MUMPS and MPI are not touched"
done
if command -v cmake > /dev/null; then
  # the tree moved to a prefix with letters that mean something to CMake, and reached by a link, as where /lib is /usr/lib
  mkdir "$root/c++ (1)"
  cp -r "$tree/usr" "$root/c++ (1)/usr"
  ln -s usr/lib "$root/c++ (1)/lib"
  cat > fe.c << 'END'
#include <delassus/fe.h>
int main(void) {
  dls_fe_mesh mesh;
  if (dls_fe_mesh_block(&mesh, 1, 1, 2, 2, 0)) return 1;
  dls_fe_mesh_free(&mesh);
  return 0;
}
END
  by_cmake() { # folder, where the package is
    mkdir "$1"
    printf '%s\n' 'cmake_minimum_required(VERSION 3.10)' 'project(point C)' "find_package(delassus 0.1 REQUIRED COMPONENTS files fe)" \
      'find_package(delassus 0.1 QUIET COMPONENTS nothing)' 'if(delassus_FOUND)' 'message(FATAL_ERROR "nothing is found")' 'endif()' \
      'add_executable(point ../point.c)' 'target_link_libraries(point delassus::delassus m)' \
      'add_executable(files ../files.c)' 'target_link_libraries(files delassus::files)' \
      'add_executable(fe ../fe.c)' 'target_link_libraries(fe delassus::fe)' > "$1/CMakeLists.txt"
    (cd "$1" && cmake -Ddelassus_DIR="$2/cmake/delassus" . && cmake --build .) > log 2>&1 || { cat log; fail "CMake, $1"; }
    check "C by CMake, $1" "$1/point"
    reads "CMake, $1" "$1/files"
    "$1/fe" || fail "the component fe by CMake, $1"
  }
  by_cmake cmake "$tree/usr/lib/here"
  LD_LIBRARY_PATH='' by_cmake moved "$root/c++ (1)/usr/lib/here"
  LD_LIBRARY_PATH='' by_cmake linked "$root/c++ (1)/lib/here"
else
  "$work/tests/skip.sh" 'CMake, no cmake'
fi
# MPI=1: libdelassus-mpi, its example on two ranks
if [ "${MPI:-0}" = 1 ]; then
  export OMPI_ALLOW_RUN_AS_ROOT=1 OMPI_ALLOW_RUN_AS_ROOT_CONFIRM=1
  slabs=$tree/usr/share/doc/delassus/examples/mpi/host_slabs.c
  wanted=$(sed -n '/^ \* Output:/,/^ \*\//p' "$slabs" | sed -e '1d' -e '$d' -e 's/^ \* \{0,1\}//' -e 's/^  //')
  on_ranks() { # way and program
    [ "$(mpirun --oversubscribe -np 2 "$2")" = "$wanted" ] || fail "host_slabs by $1"
    echo "host_slabs by $1: two ranks of the installed libdelassus-mpi"
  }
  ${CC:-cc} -o slabs-so "$slabs" $(env -u PKG_CONFIG_SYSROOT_DIR pkg-config --define-variable=prefix="$tree/usr" \
    --define-variable=libdir="$tree/usr/lib/here" --cflags --libs delassus-mpi) $(mpicc --showme:link) -lm
  on_ranks pkg-config ./slabs-so
  if command -v cmake > /dev/null; then
    mkdir mpi
    printf '%s\n' 'cmake_minimum_required(VERSION 3.10)' 'project(slabs C)' 'find_package(delassus REQUIRED COMPONENTS mpi)' \
      "add_executable(slabs $slabs)" 'target_link_libraries(slabs delassus::mpi m)' > mpi/CMakeLists.txt
    (cd mpi && cmake -Ddelassus_DIR="$tree/usr/lib/here/cmake/delassus" . && cmake --build .) > log 2>&1 || { cat log; fail 'CMake, mpi'; }
    on_ranks CMake mpi/slabs
  fi
fi
# the version stands in delassus/status.h; two files repeat it, where nothing can fill it in
version=$("$tree/usr/bin/delassus" --version | sed 's/delassus //')
[ "$version" = "$(pkg-config --modversion delassus)" ] || fail "version of delassus.pc"
for part in files $([ "${MPI:-0}" = 0 ] || echo mpi); do
  [ "$version" = "$(pkg-config --modversion delassus-$part)" ] || fail "version of delassus-$part.pc"
done
[ "$version" = "$(sed -n 's/^version: //p' "$work/CITATION.cff")" ] || fail "version of CITATION.cff"
[ "$version" = "$(sed -n '1s/.*(\(.*\)).*/\1/p' "$work/debian/changelog")" ] || fail "version of debian/changelog"
grep -q "^## $version" "$work/CHANGELOG.md" || fail "version of CHANGELOG.md"
for command in $("$tree/usr/bin/delassus" help commands); do
  [ -f "$tree/usr/share/man/man1/delassus-$command.1" ] || fail "no man page of delassus $command"
done
command -v man > /dev/null || "$work/tests/skip.sh" 'pages as man shows them, no man'
for page in man1/delassus.1 $(cd "$tree/usr/share/man" && ls man1/delassus-*.1) man3/delassus.3; do
  grep -q '^.SH NAME' "$tree/usr/share/man/$page" || fail "$page"
  if command -v man > /dev/null; then
    man -l "$tree/usr/share/man/$page" > page 2> warnings || fail "$page"
    [ ! -s warnings ] || fail "$page: $(cat warnings)"
  fi
done
grep -q -e '\\-\\-stiffness' "$tree/usr/share/man/man1/delassus-solve.1" || fail 'delassus-solve.1 has no --stiffness'
grep -q 'fclib_local' "$tree/usr/share/man/man1/delassus-solve.1" || fail 'delassus-solve.1 has no layout of FCLIB'
for page in "$tree"/usr/share/man/man1/*.1; do
  [ "$(sed -n '/^.SH EXAMPLES/,/^.SH E/p' "$page" | grep -c '^.B .*delassus')" -gt 0 ] || fail "${page##*/} has no example"
done
# each function that a shared library exports
for name in $(nm -D --defined-only "$tree"/usr/lib/here/libdelassus*.so | sed -n 's/.* T \(dls_[a-z0-9_]*\).*/\1/p'); do
  grep -q "^.B $name()" "$tree/usr/share/man/man3/delassus.3" || fail "delassus.3 has no $name"
done
# completions: an option, a method, a scene, a command
export PATH="$tree/usr/bin:$PATH"
share=$tree/usr/share
completes() { # shell, what it offered for: --stiff, -m new, scene jean-f, sol
  [ "$(echo $2)" = '--stiffness newton jean-fig3 jean-fig4 solve' ] || fail "completion of $1: $2"
}
if command -v bash > /dev/null; then
  completes bash "$(bash -c '. "$1"
    try() { COMP_WORDS=("$@"); COMP_CWORD=$(($# - 1)); _delassus; echo "${COMPREPLY[@]}"; }
    try delassus solve --stiff; try delassus solve -m new; try delassus scene jean-f; try delassus sol' \
    - "$share/bash-completion/completions/delassus")"
fi
if command -v zsh > /dev/null; then
  completes zsh "$(zsh -f -c 'compadd() { [ "$1" = -a ] && print -l -- ${(PM)2:#${words[CURRENT]##*=}*} || print -l -- ${(M)@:#${words[CURRENT]}*}; }
    compset() { : ; }; _files() { : ; }
    try() { words=("$@"); CURRENT=$#; . "$file"; }; file=$1
    try delassus solve --stiff; try delassus solve -m new; try delassus scene jean-f; try delassus sol' \
    - "$share/zsh/site-functions/_delassus")"
fi
if command -v fish > /dev/null; then
  completes fish "$(HOME=$root fish --no-config -c '. $argv[1]
    for line in "delassus solve --stiff" "delassus solve -m new" "delassus scene jean-f" "delassus sol"
      complete -C $line | cut -f1
    end' "$share/fish/vendor_completions.d/delassus.fish")"
fi
cd "$work"
run_make uninstall
left=$(find "$tree" ! -type d)
[ -z "$left" ] || fail "uninstall leaves $left"
echo 'man pages, completion, uninstall: fine'
