#!/bin/sh
# cross.sh MAKE BUILD ARCH...: builds the core (no HDF5, MUMPS, OpenMP) for other processors with Debian's cross
# compilers and runs its tests under qemu. ARCH as Debian says it: i386, armhf, arm64,
# s390x, ppc64el. Compilers and qemu are installed when run as root; BLAS, LAPACK and Check of the architecture are
# unpacked under BUILD/ARCH/root and linked statically. libc is the cross compiler's, as a shared library: the calls of
# malloc that tests let fail are ours alone. Stress tests of threads are left out: under qemu their memory is ordered as
# the host's, and they take most of the time. i386 runs without qemu where the kernel takes it. Under qemu the longest
# tests make smaller problems (TEST_SMALL=1) and assert the same. ROOMS: the rooms of tests that run; TESTS: a pattern of
# the programs that run, '*' for all. BUILD/ARCH/times: the seconds of each test program.
set -u
make=$1
build=$2
shift 2
rooms=${ROOMS:-base linear lcp files reduction method contract}
wanted=${TESTS:-*}
bad=0

# one ARCH: sets triplet and qemu
one() {
  case $1 in
  i386) triplet=i686-linux-gnu lib=i386-linux-gnu qemu=qemu-i386 ;;
  armhf) triplet=arm-linux-gnueabihf lib=$triplet qemu=qemu-arm ;;
  arm64) triplet=aarch64-linux-gnu lib=$triplet qemu=qemu-aarch64 ;;
  s390x) triplet=s390x-linux-gnu lib=$triplet qemu=qemu-s390x ;;
  ppc64el) triplet=powerpc64le-linux-gnu lib=$triplet qemu=qemu-ppc64le ;;
  *) echo "cross: $1 is none of i386, armhf, arm64, s390x, ppc64el"; exit 2 ;;
  esac
}

# tools of all ARCHs
missing=
for arch in "$@"; do
  one "$arch"
  command -v $triplet-gcc >/dev/null || missing="$missing gcc-$(echo $triplet | tr _ -) libc6-dev-$arch-cross"
  command -v $qemu >/dev/null || missing="$missing qemu-user"
done
if [ -n "$missing" ]; then
  if [ "$(id -u)" -ne 0 ]; then echo "missing packages; please run:  sudo apt-get install$missing"; exit 1; fi
  # shellcheck disable=SC2086
  apt-get update -q >/dev/null && DEBIAN_FRONTEND=noninteractive apt-get install -y -q --no-install-recommends $missing >/dev/null || exit 1
fi

# unpack ARCH: libraries of the architecture, by an apt with a state of its own, into $root
unpack() {
  [ -e "$root/done" ] && return 0
  mkdir -p "$root/apt/lists/partial" "$root/apt/archives/partial" "$root/debs" || return 1
  : >"$root/apt/status"
  options="-o APT::Architecture=$1 -o APT::Architectures=$1 -o Dir::State=$root/apt -o Dir::State::status=$root/apt/status -o Dir::Cache=$root/apt -o APT::Sandbox::User=root"
  # shellcheck disable=SC2086
  apt-get $options update -q >/dev/null 2>&1 # a list that is missing may not be needed
  # shellcheck disable=SC2086
  (cd "$root/debs" && apt-get $options download -q libblas-dev liblapack-dev libgfortran-12-dev libgcc-12-dev check libsubunit-dev zlib1g-dev >/dev/null) || return 1
  for deb in "$root"/debs/*.deb; do dpkg -x "$deb" "$root" || return 1; done
  rm -rf "$root/debs" "$root/apt"
  touch "$root/done"
}

for arch in "$@"; do
  one "$arch"
  mkdir -p "$build/$arch" || exit 1
  root=$(cd "$build/$arch" && pwd)/root
  unpack "$arch" || { echo "cross: $arch: no libraries"; bad=1; continue; }
  fortran=$(dirname "$(find "$root" -name libgfortran.a)")
  libraries="-L$root/usr/lib/$lib/lapack -L$root/usr/lib/$lib/blas -L$root/usr/lib/$lib -L$fortran"
  gfortran=-l:libgfortran.a
  [ -e "$fortran/libquadmath.a" ] && gfortran="$gfortran -l:libquadmath.a"
  tests=$(for room in $rooms; do for t in tests/"$room"/test_*.c; do
    case $t in */test_threads.c | */test_side_by_side.c) continue ;; esac
    # shellcheck disable=SC2254
    case $(basename "$t" .c) in $wanted) ;; *) continue ;; esac
    echo "$build/$arch/${t%.c}"; done; done)
  [ -n "$tests" ] || { echo "cross: no test program is $wanted in $rooms"; exit 2; }
  small=1
  runner="$qemu -L /usr/$triplet"
  loader=/usr/$triplet/lib/ld-linux.so.2
  [ "$arch" = i386 ] && $loader --version >/dev/null 2>&1 && small=0 && runner="$loader --library-path /usr/$triplet/lib"
  # shellcheck disable=SC2086
  if ! $make --no-print-directory -s BUILD="$build/$arch" CC=$triplet-gcc AR=$triplet-ar HDF5=0 MUMPS=0 OPENMP= TEST_SMALL=$small \
    CFLAGS=-O2 WERROR=-Werror CPPFLAGS="-idirafter $root/usr/include" LDFLAGS="$libraries" \
    BLAS_LIBS="-l:liblapack.a -l:libblas.a $gfortran" CHECK_LIBS='-l:libcheck.a -l:libsubunit.a -lrt -lm -pthread' \
    "$build/$arch/libdelassus.a" "$build/$arch/libdelassus-fe.a" $tests >"$build/$arch/log" 2>&1; then
    echo "cross: $arch does not build"; grep -E 'warning|error|undefined' "$build/$arch/log" | head -10; bad=1
    continue
  fi
  passed=0
  failed=0
  : >"$build/$arch/times"
  for t in $tests; do
    start=$(date +%s)
    if CK_TIMEOUT_MULTIPLIER=50 CK_VERBOSITY=normal $runner "$t" >"$build/$arch/out" 2>&1; then
      passed=$((passed + 1))
    else
      failed=$((failed + 1)); echo "FAILED: $t"; head -20 "$build/$arch/out"
    fi
    echo "$(($(date +%s) - start)) $t" >>"$build/$arch/times"
  done
  echo "cross: $arch: $passed passed, $failed failed"
  [ $failed -eq 0 ] || bad=1
done
exit $bad
