#!/bin/sh
# CC=gcc check_symbols.sh LIB.so LIB.a: the shared library exports dls_* and nothing else, each symbol with the
# version DELASSUS_0; it binds no name of MUMPS or of MPI, so that the host may have its own (mumps.o, the MUMPS in the
# library, shows dlsi_dmumps alone); our own objects call nothing with a process-wide effect and hold no writable global but
# lock_of_others (src/base/lock.c), which lets one thread at a time into MUMPS, METIS and HDF5, and, one in each
# thread, host_of_thread (src/base/environment.c), the host's floating point environment.
set -u
bad=0
others=$(nm -D --defined-only "$1" | awk '$2 != "A" {print $3}' | grep -v '^dls_')
if [ -n "$others" ]; then echo "exported, not dls_*: $others"; bad=1; fi
plain=$(nm -D --with-symbol-versions --defined-only "$1" | awk '$2 != "A" {print $3}' | grep -v '@@DELASSUS_0$')
if [ -n "$plain" ]; then echo "without the version DELASSUS_0: $plain"; bad=1; fi
bound=$(nm -D "$1" | awk '{print $NF}' | grep -i -E '^([sdcz]?mumps|p?mpi_|blacs_)')
if [ -n "$bound" ]; then echo "bound to the host's MUMPS or MPI: $bound"; bad=1; fi
hidden=$(nm -A --defined-only --extern-only "$2" 2>/dev/null | awk '{print $NF}' | grep -v -E '^(dls_|dlsi_)')
if [ -n "$hidden" ]; then echo "neither dls_* nor dlsi_*: $hidden"; bad=1; fi
calls=$(nm -A --undefined-only "$2" 2>/dev/null | grep -v ':mumps.o:' | awk '{print $NF}' | sort -u |
  grep -x -E '_?exit|_Exit|abort|__assert_fail|printf|puts|putchar|vprintf|__printf_chk|__vprintf_chk|perror|signal|getenv|setenv|setlocale|s?rand|random|drand48|srandom|stdout|stderr|openblas_set_num_threads')
if [ -n "$calls" ]; then echo "process-wide effects: $calls"; bad=1; fi
# writable FILE: its writable globals, static, hidden or not
writable() {
  objdump -t "$1" | sed 's/ \.hidden / /' | awk '/file format/ { mumps = $1 == "mumps.o:" } !mumps && NF > 3 && $(NF-2) ~ /^(\.data|\.bss|\*COM\*|\.tbss|\.tdata)(\.|$)/ &&
    $(NF-2) !~ /^\.data\.rel\.ro/ && $NF !~ /^\./ && $NF != "lock_of_others" && $NF != "host_of_thread"'
}
seen=$(mktemp)
echo 'static int a; static _Thread_local int b = 1; int c, d = 1; int *e(void); int *e(void) { return a ? &a : &b; }' |
  ${CC:-cc} -fPIC -fvisibility=hidden -xc -c -o "$seen" - || bad=1
[ "$(writable "$seen" | wc -l)" = 4 ] || { echo 'check_symbols.sh does not see writable globals'; bad=1; }
rm -f "$seen"
globals=$(writable "$2")
if [ -n "$globals" ]; then echo "writable globals:"; echo "$globals"; bad=1; fi
[ $bad -eq 0 ] && echo "symbols: $(nm -D --defined-only "$1" | grep -c ' T dls_') functions dls_*, nothing else"
exit $bad
