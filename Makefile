# delassus: one GNU Makefile. `make help` lists the targets.
#
# Variables: CC, CFLAGS, BUILD (build), PREFIX (/usr/local), LIBDIR (PREFIX/lib), DESTDIR, HARDEN= to leave the guards
# against overruns out, HDF5=0 to leave FCLIB files out,
# MUMPS=0 to leave sparse LU out, OPENMP= to leave threads out, MPI=1 for libdelassus-mpi and delassus-mpi,
# BLAS_LIBS to link another BLAS and LAPACK.

# the version stands in one place, the header
VERSION := $(shell sed -n 's/^.define DLS_VERSION  *"\(.*\)"/\1/p' include/delassus/status.h)
SOVERSION = 0

CC ?= cc
ifeq ($(origin CC),default)
CC = gcc
endif
CXX ?= c++
ifeq ($(origin FC),default)
FC = gfortran
endif
PYTHON ?= $(shell for p in python3 /usr/bin/python3; do $$p -c 'import numpy, scipy' 2>/dev/null && echo $$p && break; done)
AR ?= ar
OBJCOPY ?= $(shell $(CC) -print-prog-name=objcopy)
BUILD ?= build
PREFIX ?= /usr/local
LIBDIR ?= $(PREFIX)/lib
DESTDIR ?=
HDF5 ?= 1
MUMPS ?= 1
PKG_CONFIG ?= pkg-config
CFLAGS ?= -O3 -g

# one short line a file; V=1 shows the commands
ifneq ($(V),1)
Q = @
say = @echo '  $(1) $@'
endif

MAKEFLAGS += --no-builtin-rules
.SUFFIXES:
.DELETE_ON_ERROR:
.SECONDARY:

# integer constants are enums, which clang does not like beside a double; gcc does not know the name
WARNINGS = -Wall -Wextra -Wpedantic -Wshadow -Wconversion -Wstrict-prototypes \
           -Wmissing-prototypes -Wvla -Wno-enum-float-conversion $(WERROR)
# large files and directories on 32 bits, too
CPPFLAGS_ALL = -D_FILE_OFFSET_BITS=64 -Iinclude -Isrc -I. -MMD -MP $(CPP_OF) $(CPPFLAGS)
# i386 computes in double with SSE2 alone
X87 := $(if $(filter 1,$(shell echo __i386__ | $(CC) $(CFLAGS) -E -P -xc - 2>/dev/null)),-msse2 -mfpmath=sse)
# what guards against overruns: HARDEN= leaves it out; FORTIFY needs optimisation and no sanitizer. Of the methods only
# functions with texts have a guarded stack: they read no bytes of others, and with all guarded a solve of one contact
# takes 3 % more instructions in place of 1 %
takes = $(shell echo 'int main(void) { return 0; }' | $(CC) $(1) -xc - -o /dev/null 2>/dev/null && echo '$(1)')
ifeq ($(origin HARDEN),undefined)
HARDEN := $(foreach flag,-fcf-protection=full -fstack-protector,$(call takes,$(flag)))
BIND_NOW = -Wl,-z,relro,-z,now
HARDEN_LINK := $(call takes,$(BIND_NOW))
endif
FORTIFY = $(if $(and $(HARDEN),$(filter -O1 -O2 -O3 -Os,$(CFLAGS))),$(if $(SANITIZE)$(findstring FORTIFY,$(CFLAGS) $(CPPFLAGS)),,-D_FORTIFY_SOURCE=2))
# the folder of the source is not named in what is built: two builds are equal
PREFIX_MAP := $(call takes,-ffile-prefix-map=$(CURDIR)=.)
# no fused products: the same bits everywhere; nobody asks errno or the traps, which keep loops scalar
CFLAGS_ALL = -std=c11 $(CFLAGS) $(X87) $(WARNINGS) $(HARDEN) $(FORTIFY) $(PREFIX_MAP) -ffp-contract=off \
             -fno-math-errno -fno-trapping-math -pthread -fPIC -fvisibility=hidden -DDLS_BUILD_SHARED $(SANITIZE)

BLAS_LIBS ?= $(shell $(PKG_CONFIG) --silence-errors --libs openblas || echo -lopenblas)
ifeq ($(HDF5),1)
HDF5_CFLAGS := $(shell $(PKG_CONFIG) --silence-errors --cflags hdf5-serial || $(PKG_CONFIG) --silence-errors --cflags hdf5)
HDF5_LIBS := $(shell $(PKG_CONFIG) --silence-errors --libs hdf5-serial || $(PKG_CONFIG) --silence-errors --libs hdf5 || echo -lhdf5)
HDF5_CFLAGS += -DDLS_WITH_HDF5
endif
ifeq ($(MUMPS),1)
MUMPS_CFLAGS ?= -isystem /usr/include/mumps_seq
# the sequential MUMPS, static: it goes into libdelassus under one hidden name
MUMPS_A ?= $(foreach part,dmumps mumps_common pord mpiseq,$(shell $(CC) -print-file-name=lib$(part)_seq.a))
MUMPS_O := $(BUILD)/obj/mumps.o
MUMPS_LIBS ?= -l:libgfortran.so.5 -lmetis
endif
# sweeps on several threads, where the compiler has OpenMP; OPENMP= leaves it out
ifeq ($(origin OPENMP),undefined)
OPENMP := $(shell echo 'int main(void) { return 0; }' | $(CC) -fopenmp -xc - -o /dev/null 2>/dev/null && echo -fopenmp)
endif
OPENMP_LIBS := $(if $(OPENMP),$(if $(findstring clang,$(shell $(CC) --version)),-fopenmp,-lgomp))
# of libdelassus; of libdelassus-files; of a program
CORE_LIBS = $(MUMPS_LIBS) $(BLAS_LIBS) $(OPENMP_LIBS) -lm -pthread
FILES_LIBS = $(HDF5_LIBS) -lz -lm -pthread
LIBS = $(HDF5_LIBS) -lz $(CORE_LIBS)
CHECK_LIBS = $(shell $(PKG_CONFIG) --libs check)

MPI ?= 0
ifeq ($(MPI),1)
MPICC ?= mpicc
MPI_INCLUDES := $(shell $(MPICC) --showme:compile)
MPI_CFLAGS := $(patsubst -I%,-isystem %,$(MPI_INCLUDES)) -DDLSI_MPI
MPI_LIBS := -ldmumps -lscalapack-openmpi $(shell $(MPICC) --showme:link)
endif

LIB_SRC := $(wildcard $(addsuffix /*.c,src/base src/contact src/geometry src/linear src/facts src/auto src/front src/motion lcp vi vi/sweep vi/newton vi/split vi/path vi/primal reduction global))
NO_MUMPS := src/linear/mumps_none.c
WITH_MUMPS := $(addprefix src/linear/,sparse_lu.c schur.c dissection.c)
LIB_SRC := $(filter-out $(if $(MUMPS_LIBS),$(NO_MUMPS),$(WITH_MUMPS)),$(LIB_SRC))
FILES_SRC := $(filter-out $(if $(HDF5_CFLAGS),src/files/fclib_none.c,src/files/fclib_read.c src/files/fclib_write.c),$(wildcard src/files/*.c))
FE_SRC := $(wildcard src/fe/*.c)
CLI_SRC := $(wildcard $(patsubst %,src/%/*.c,console problem charts report cli))
# the rooms of tests that check-build builds; all of them
ROOMS ?= *
TEST_SRC := $(filter-out tests/mpi/% $(LEFT_OUT),$(wildcard $(ROOMS:%=tests/%/test_*.c)))
EXAMPLE_SRC := $(wildcard examples/*.c)
HEADERS := $(filter-out $(if $(MPI_LIBS),,include/delassus/mpi.h),$(wildcard include/*.h include/delassus/*.h))
ALL_CPP = $(wildcard include/*.hpp tests/*/*.cpp examples/*.cpp)
ALL_C = $(LIB_SRC) $(FILES_SRC) $(FE_SRC) $(CLI_SRC) src/fortran/types.c $(wildcard src/mpi/*.c examples/mpi/*.c) $(wildcard tests/*/*.c) $(EXAMPLE_SRC) $(wildcard bench/*.c)
ALL_H = $(HEADERS) $(wildcard src/*/*.h lcp/*.h vi/*.h vi/*/*.h reduction/*.h global/*.h tests/*/*.h bench/*.h)

obj = $(patsubst %.c,$(BUILD)/obj/%.o,$(1))
LIB_OBJ := $(call obj,$(LIB_SRC)) $(MUMPS_O)
# files and fe are libraries of their own: each carries the hidden functions that it shares with libdelassus
base_obj = $(call obj,$(foreach part,status memory number check columns environment utf8 $(1),$(wildcard src/base/$(part).c src/contact/$(part).c)))
FILES_OBJ := $(call obj,$(FILES_SRC)) $(call base_obj,bodies entries joints lock model)
FE_OBJ := $(call obj,$(FE_SRC) src/files/file.c src/files/output.c) $(call base_obj)
TESTS := $(patsubst tests/%.c,$(BUILD)/tests/%,$(TEST_SRC))
EXAMPLES := $(patsubst examples/%.c,$(BUILD)/examples/%,$(EXAMPLE_SRC))
# programs in other languages, where there is a compiler
LANGUAGE_SRC := $(if $(shell command -v $(CXX)),$(wildcard tests/languages/*.cpp examples/*.cpp)) \
                $(if $(shell command -v $(FC)),$(wildcard tests/languages/*.f90 examples/*.f90))
# point.c, point.cpp and point.f90 become three programs
LANGUAGES := $(patsubst %.cpp,$(BUILD)/%-cpp,$(patsubst %.f90,$(BUILD)/%-f90,$(LANGUAGE_SRC)))

$(call obj,$(FILES_SRC) $(FE_SRC) $(CLI_SRC)): HARDEN := $(HARDEN:-fstack-protector=-fstack-protector-strong)

A = $(BUILD)/libdelassus.a
SO = $(BUILD)/libdelassus.so
FILES = $(BUILD)/libdelassus-files.a
FILES_SO = $(BUILD)/libdelassus-files.so
FE = $(BUILD)/libdelassus-fe.a
PROGRAM = $(BUILD)/delassus

.PHONY: all
all: $(A) $(SO) $(FILES) $(FILES_SO) $(FE) $(PROGRAM) $(EXAMPLES)

# ---- MPI=1: a library that holds all of libdelassus, too, its sparse LU on the parallel MUMPS ------

ifeq ($(MPI),1)
include src/mpi/mpi.mk
endif

.PHONY: help
help:
	@echo 'make             libraries, program and examples, under $(BUILD)/'
	@echo 'make demo        the Jean block with every method, tables and pictures'
	@echo 'make refinement  its densities of reaction under refinement of the mesh'
	@echo 'make charts      every picture of docs/choosing.md, from scratch, in minutes'
	@echo 'make charts-longer   then: how many cells of them ten times the limits change'
	@echo 'make check       build and run all tests'
	@echo 'make install-python   the package delassus for PYTHON=python3'
	@echo 'make install     PREFIX=/usr/local LIBDIR=PREFIX/lib DESTDIR='
	@echo 'make uninstall   removes what install wrote; make dist: the source as build/delassus-VERSION.tar.gz'
	@echo 'make check-install   examples built and run from an installed tree alone'
	@echo 'make check-packages  wheel, source package and editable install of Python without network; mypy'
	@echo 'make check-debian    dpkg-buildpackage and lintian'
	@echo 'make docs        the guide as HTML with a search, build/docs/html (Doxygen)'
	@echo 'make check-docs      every command of the documents, in a copy of the tree; make check-links: dead links'
	@echo 'make check-hosts     GetFEM, CalculiX, PETSc, MuJoCo, deal.II, dolfinx and ODE hand their data over; PETSc and deal.II with a MUMPS of their own; installs them'
	@echo 'make properties  random problems with a known answer, solved in many ways; PROPERTIES="--seed 2 --count 100000"'
	@echo 'make check-properties   280 of them'
	@echo 'make asan        tests under the address and undefined sanitizers'
	@echo 'make threads     eight threads at once under the thread sanitizer; RUNS=20'
	@echo 'make mutants     changes of the code that no test sees; MUTANTS=100 SEED=n'
	@echo 'make coverage    lines and branches of the library that no test runs'
	@echo 'make valgrind    tests under valgrind, no leak'
	@echo 'make torment     faults, fuzz, threads, mutants; make fuzz FUZZ_SECONDS=600; make faults'
	@echo 'make check-fuzz check-faults   the short forms of two of them'
	@echo 'make check-languages   tests and examples in C++, Fortran and Python'
	@echo 'make check-build check-symbols check-arrows check-names check-headers   parts of it, and each header'
	@echo 'make check-abi       functions, structs and constants beside tests/abi.txt; make abi writes that'
	@echo 'make check-flags     flags that make a wrong library are refused; FLAGS=all: other flags and compilers, too'
	@echo 'make check-cross     the core for other processors under qemu; ARCHS="i386 arm64"'
	@echo 'make check-plain     a build with HDF5=0 MUMPS=0 OPENMP=, and the tests of what that changes'
	@echo 'make sequences       calls of Python in any order under the sanitizers; SEQUENCE=10000'
	@echo 'make names           names and titles of any bytes through every command; NAMES=1250 rounds of 8'
	@echo 'make check-all       all of this: other options, flags, compilers, processors; MPI, sanitizers, long fuzz; hours'
	@echo 'make lint format-check format      clang-tidy and cppcheck; layout and 100 columns'
	@echo 'make bench-solvers   every solver beside Siconos; BENCH=--full for all problems'
	@echo 'make bench-reduction K -> W beside CHOLMOD and UMFPACK; BENCH=--full, BENCH=--large'
	@echo 'make bench-lemke     Lemke beside Siconos; BENCH=--full, BENCH=--large'
	@echo 'make bench-scale     rigid bodies of 300 to 20,000 contacts beside Siconos; BENCH=options'
	@echo 'make bench-global    contact over whole surfaces on K beside W and CHOLMOD; BENCH="--table NAME"'
	@echo 'make bench-auto      auto beside the single methods; BENCH=files'
	@echo 'make bench-regret    auto beside the best of its methods and Siconos on generated problems; BENCH=options'
	@echo 'make bench-motion    load and recover of each step beside one solve by CHOLMOD'
	@echo 'make bench-bodies    rigid bodies as W = H^T H beside W by blocks, one and two threads'
	@echo 'make bench-lanes     a sweep over groups of eight contacts beside one by one'
	@echo 'make bench-steps     a batch of small problems; a load path, warm beside cold'
	@echo 'make bench-dynamics  columns of spheres that collapse, each step warm beside cold; BENCH=--large'
	@echo 'make bench-prove     proved share of answers, cost of a proof; FCLIB=DIR'
	@echo 'make bench-least     cost of the least reactions; FCLIB=DIR'
	@echo 'make bench-derive    cost of derivatives over that of the answer'
	@echo 'make bench-papers    the open questions of both papers, a picture each'
	@echo 'make bench-hard      where methods fail: hard problems in 3D; BENCH=--page'
	@echo 'make bench-trust     predicted error of an answer beside the true one'
	@echo 'make bench-tables    both forming scenes of Chabrand (1998) by each method, beside the paper'
	@echo 'make bench-report    the setting that delassus report advises beside a finer reference'
	@echo 'make bench-all       all of these; hours on an idle machine; FCLIB=DIR LCP=DIR'
	@echo 'make MPI=1       libdelassus-mpi and delassus-mpi, too; MPI=1 check-mpi, MPI=1 bench-mpi'
	@echo 'make clean'

# the Debian packages that these options need
DEPS = HDF5='$(HDF5)' MUMPS='$(MUMPS)' BLAS_LIBS='$(if $(filter file,$(origin BLAS_LIBS)),,$(BLAS_LIBS))' .ci/deps

# ---- libraries and program ----------------------------------------------------------------------

$(BUILD)/obj/%.o: %.c Makefile
	@mkdir -p $(@D)
	$(call say,CC  )
	$(Q)$(CC) $(CPPFLAGS_ALL) $(if $(filter src/files/fclib%,$<),$(HDF5_CFLAGS)) $(if $(filter $(WITH_MUMPS),$<),$(MUMPS_CFLAGS)) $(CFLAGS_ALL) -c -o $@ $<

# the one loop of the library that has to run at the speed of the memory: vectorise it
$(BUILD)/obj/src/contact/products.o: CFLAGS += -O3
$(BUILD)/obj/src/base/parallel.o: CFLAGS_ALL += $(OPENMP)

# MUMPS of our own, whatever MUMPS and MPI the host has (docs/decisions.md): its entry gets the name dlsi_dmumps, all
# other names become local. Its calls of SCOTCH, which no order of ours needs, may stay without a target
$(MUMPS_O): $(MUMPS_A)
	@mkdir -p $(@D)
	$(call say,LINK)
	$(Q)$(CC) -r -nostdlib -Wl,-d -Wl,--undefined=dmumps_c -o $@ $(MUMPS_A)
	$(Q)$(OBJCOPY) --redefine-sym dmumps_c=dlsi_dmumps --keep-global-symbol=dlsi_dmumps \
	  --wildcard --weaken-symbol='SCOTCH_*' --weaken-symbol='scotchf*' --weaken-symbol='esmumps*' $@
$(filter-out /%,$(MUMPS_A)):
	@echo '$@ is missing: MUMPS is linked as static archives (Debian: libmumps-seq-dev). MUMPS=0 builds without it'; exit 1

# the headers whose structs layout.c tells to other languages
LAYOUT_H := $(shell sed -n 's|^.include "\(delassus/.*\)"|include/\1|p' include/delassus.h)
$(BUILD)/layout/layout.inc: src/front/layout.awk include/delassus.h $(LAYOUT_H)
	@mkdir -p $(@D)
	$(Q)awk -f src/front/layout.awk $(LAYOUT_H) > $@
$(BUILD)/obj/src/front/layout.o: CPP_OF += -I$(BUILD)/layout
$(BUILD)/obj/src/front/layout.o: $(BUILD)/layout/layout.inc

$(A): $(LIB_OBJ)
	@rm -f $@
	$(call say,AR  )
	$(Q)$(AR) rcs $@ $^

$(SO).$(VERSION): $(LIB_OBJ) src/delassus.map
	$(call say,LINK)
	$(Q)$(CC) -shared $(SANITIZE) $(HARDEN_LINK) $(LDFLAGS) -Wl,-soname,libdelassus.so.$(SOVERSION) \
	  -Wl,--version-script=src/delassus.map -o $@ $(LIB_OBJ) $(CORE_LIBS)

$(FILES_SO).$(VERSION): $(FILES_OBJ) src/files/files.map
	$(call say,LINK)
	$(Q)$(CC) -shared $(SANITIZE) $(HARDEN_LINK) $(LDFLAGS) -Wl,-soname,libdelassus-files.so.$(SOVERSION) \
	  -Wl,--version-script=src/files/files.map -o $@ $(FILES_OBJ) $(FILES_LIBS)

$(SO) $(FILES_SO) $(MPI_SO): %: %.$(VERSION)
	@ln -sf $(<F) $@.$(SOVERSION)
	@ln -sf $(<F) $@

$(FILES): $(FILES_OBJ)
$(FE): $(FE_OBJ)
$(FILES) $(FE):
	@rm -f $@
	$(call say,AR  )
	$(Q)$(AR) rcs $@ $^

$(PROGRAM): $(call obj,$(CLI_SRC)) $(FE) $(FILES) $(A)
	$(call say,LINK)
	$(Q)$(CC) $(SANITIZE) $(HARDEN_LINK) $(LDFLAGS) -o $@ $^ $(LIBS)

# ---- other languages ----------------------------------------------------------------------------

CXX_WARNINGS = -Wall -Wextra -Wpedantic -Wshadow -Wconversion $(WERROR)
$(BUILD)/%-cpp: %.cpp include/delassus.hpp $(HEADERS) $(A)
	@mkdir -p $(@D)
	$(call say,CXX )
	$(Q)$(CXX) -std=c++17 -Iinclude $(CXX_WARNINGS) -O1 -g $(SANITIZE) $(LDFLAGS) -o $@ $< $(A) $(LIBS)

# the module with the types of this library, in one file that compiles by itself
F90 = $(BUILD)/fortran/delassus.f90
F90_FLAGS = -std=f2018 -Wall -Wextra -Wno-compare-reals $(WERROR)
$(F90): src/fortran/delassus.f90 src/fortran/types.c $(A)
	@mkdir -p $(@D)
	$(call say,GEN )
	$(Q)$(CC) $(CPPFLAGS_ALL) $(CFLAGS_ALL) $(LDFLAGS) -o $(@D)/types src/fortran/types.c $(A) $(LIBS)
	$(Q)$(@D)/types > $(@D)/types.inc
	$(Q)sed -e '/^!TYPES/{r $(@D)/types.inc' -e 'd}' $< > $@
$(BUILD)/fortran/delassus.o: $(F90)
	$(call say,FC  )
	$(Q)$(FC) $(F90_FLAGS) -J$(@D) -c -o $@ $<
$(BUILD)/%-f90: %.f90 $(BUILD)/fortran/delassus.o $(A)
	@mkdir -p $(@D)
	$(call say,FC  )
	$(Q)$(FC) $(F90_FLAGS) -I$(BUILD)/fortran -J$(@D) $(SANITIZE) $(LDFLAGS) -o $@ $^ $(LIBS)

$(BUILD)/examples/%: examples/%.c $(FE) $(FILES) $(A)
	@mkdir -p $(@D)
	$(call say,LINK)
	$(Q)$(CC) $(CPPFLAGS_ALL) $(CFLAGS_ALL) $(LDFLAGS) -o $@ $< $(FE) $(FILES) $(A) $(LIBS)

# the examples whose solves end "solved to rounding": they print the same (tests/examples/rounded.c)
ROUNDED := $(patsubst $(BUILD)/examples/%,$(BUILD)/rounded/%,$(filter-out %/lcp,$(EXAMPLES)))
$(BUILD)/rounded/%: examples/%.c $(BUILD)/obj/tests/examples/rounded.o $(FE) $(FILES) $(A)
	@mkdir -p $(@D)
	$(call say,LINK)
	$(Q)$(CC) $(CPPFLAGS_ALL) $(CFLAGS_ALL) $(LDFLAGS) $(addprefix -Wl$(comma)--wrap=dls_,solve solve_model solver_solve reduction_solve) -o $@ $^ $(LIBS)

# ---- tests --------------------------------------------------------------------------------------

# what test programs share
TEST_HELPERS := $(call obj,$(wildcard tests/shared/*.c))
# malloc and calloc of our own code (not of MUMPS) go through the wrappers of tests/shared/malloc_fails.c, its errors
# through the one of tests/shared/errors.c
WRAP = $(patsubst %,-Wl$(comma)--wrap=%,malloc calloc realloc free dlsi_dmumps dlsi_fail)
comma = ,

$(BUILD)/tests/%: $(BUILD)/obj/tests/%.o $(TEST_HELPERS) $(FE) $(FILES) $(A)
	@mkdir -p $(@D)
	$(call say,LINK)
	$(Q)$(CC) $(SANITIZE) $(LDFLAGS) $(WRAP) -o $@ $^ $(CHECK_LIBS) $(LIBS)

# 1: smaller problems in the longest tests, the same assertions: for a processor that qemu stands for
TEST_SMALL ?= 0
$(call obj,$(TEST_SRC)) $(TEST_HELPERS): CPP_OF += -Itests/shared -DTEST_DATA='"data"' -DWITH_MUMPS=$(if $(MUMPS_LIBS),1,0) -DWITH_HDF5=$(if $(HDF5_CFLAGS),1,0) -DTEST_SMALL=$(TEST_SMALL)
# building them costs more than running what is in them: 46 s of CPU in all, 79 by -O3
$(call obj,$(TEST_SRC)): CFLAGS_ALL += -O1
# a test of the program runs the program of this tree
$(patsubst tests/%.c,$(BUILD)/tests/%,$(wildcard tests/cli/test_*.c)): | $(PROGRAM)
$(BUILD)/tests/cli/test_budget: $(call obj,src/report/report_budget.c)
$(BUILD)/tests/cli/test_words: $(call obj,src/console/messages.c src/console/quote.c)
# test_files makes broken FCLIB files with HDF5 itself
$(BUILD)/obj/tests/files/test_files.o: CPP_OF += $(HDF5_CFLAGS)

.PHONY: check
check: deps
	@$(MAKE) --no-print-directory check-symbols check-arrows check-names check-flags check-build check-properties check-faults check-fuzz check-install check-links check-docs QUICK=--quick

.PHONY: check-build check-build-1 check-build-2
# the benchmarks that need nothing but the library; those beside others are in PEER_BENCHES
BENCHES = auto bodies derive dynamics hard lanes least papers problems prove report steps trust
TESTED = all $(TESTS) $(ROUNDED) $(LANGUAGES) $(addprefix $(BUILD)/bench/,$(BENCHES))
check-build: check-build-1 check-build-2
# two halves, for two cores
.PHONY: check-build-begun
check-build-begun: $(TESTED)
	@rm -rf $(BUILD)/begun && mkdir $(BUILD)/begun
check-build-1 check-build-2: check-build-%: check-build-begun
	@PYTHON='$(PYTHON)' HALF=$* tests/run.sh $(BUILD) $(TEST_RUNNER)

# the library as it is without HDF5, MUMPS and OpenMP, and the tests of what that changes
.PHONY: check-plain
PLAIN_ROOMS = files linear reduction cli catalogue
check-plain:
	@$(MAKE) --no-print-directory check-build BUILD=$(BUILD)/plain HDF5=0 MUMPS=0 OPENMP= ROOMS='$(PLAIN_ROOMS)' BENCHES= \
	  LEFT_OUT='$(patsubst %,tests/cli/test_%.c,charts report endings names budget moving_cli forming_cli)'

# tests and examples in other languages alone
.PHONY: check-languages
check-languages: all $(LANGUAGES) $(BUILD)/tests/languages/test_door
	@PYTHON='$(PYTHON)' tests/run.sh $(BUILD) --languages

.PHONY: asan
asan:
	$(MAKE) check-build BUILD=$(BUILD)/asan CFLAGS='-O1 -g -fno-omit-frame-pointer' \
	  SANITIZE='-fsanitize=address,undefined -fno-sanitize-recover=all'

# calls of Python in any order, good and bad, under the same sanitizers; nothing of the interpreter's own is looked at
.PHONY: sequences
SEQUENCE ?= 10000
sequences:
	@$(MAKE) --no-print-directory $(BUILD)/asan/libdelassus.so BUILD=$(BUILD)/asan CFLAGS='-O1 -g -fno-omit-frame-pointer' \
	  SANITIZE='-fsanitize=address,undefined -fno-sanitize-recover=all'
	LD_PRELOAD="$$($(CC) -print-file-name=libasan.so)" ASAN_OPTIONS=detect_leaks=0 OPENBLAS_NUM_THREADS=1 \
	  PYTHONDONTWRITEBYTECODE=1 PYTHONPATH=src/python DELASSUS_LIBRARY=$(BUILD)/asan/libdelassus.so \
	  DELASSUS_SEQUENCE=$(SEQUENCE) $(PYTHON) tests/languages/test_python.py Owners

# names and titles of any bytes, NAMES times 8 of them
.PHONY: names
NAMES ?= 1250
names: $(PROGRAM) $(BUILD)/tests/cli/test_names
	DELASSUS_NAMES=$(NAMES) DELASSUS_PROGRAM=$(PROGRAM) OPENBLAS_NUM_THREADS=1 $(BUILD)/tests/cli/test_names

# host threads under the thread sanitizer, RUNS times
.PHONY: threads
RUNS ?= 1
THREADS = $(addprefix $(BUILD)/tsan/tests/,reduction/test_threads contract/test_side_by_side)
threads:
	@$(MAKE) --no-print-directory $(THREADS) BUILD=$(BUILD)/tsan CFLAGS='-O1 -g' SANITIZE=-fsanitize=thread
	for run in $$(seq $(RUNS)); do for test in $(THREADS); do \
	  CK_FORK=no OPENBLAS_NUM_THREADS=1 TSAN_OPTIONS=halt_on_error=1 $$test || exit 1; done; done

# lines and branches of the library that no test runs; the slow tests of forming and reports are left out
.PHONY: coverage
COVERED = $(filter-out %/test_forming %/test_forming_body %/test_forming_cli %/test_charts %/test_report,$(TESTS))
coverage:
	@$(MAKE) --no-print-directory coverage-build BUILD=$(BUILD)/coverage CFLAGS='-O0 -g' SANITIZE=--coverage
	@python3 tests/torment/coverage.py $(BUILD)/coverage
.PHONY: coverage-build
coverage-build: $(PROGRAM) $(COVERED)
	@find $(BUILD) -name '*.gcda' -delete
	@for test in $(COVERED); do \
	  OPENBLAS_NUM_THREADS=1 CK_TIMEOUT_MULTIPLIER=10 DELASSUS_PROGRAM=$(PROGRAM) $$test || exit 1; done

# a change that no test sees: MUTANTS of them, by chance from SEED on; tests/torment/README.md
.PHONY: mutants
MUTANTS ?= 100
mutants: all
	@python3 tests/torment/mutants.py $(BUILD) --count $(MUTANTS) $(if $(SEED),--seed $(SEED))

.PHONY: valgrind
valgrind: all $(TESTS) $(LANGUAGES)
	@tests/run.sh $(BUILD) 'valgrind --quiet --leak-check=full --errors-for-leak-kinds=definite,possible --error-exitcode=9 --suppressions=tests/valgrind.supp'

.PHONY: check-symbols
check-symbols: $(SO) $(A) $(FILES_SO) $(FILES)
	@CC='$(CC)' tests/check_symbols.sh $(SO) $(A)
	@CC='$(CC)' tests/check_symbols.sh $(FILES_SO) $(FILES)

# what compiled hosts rely on, beside the table tests/abi.txt; make abi writes the table
.PHONY: check-abi abi
check-abi: $(SO) $(FILES_SO)
	@CC='$(CC)' tests/abi.sh $(BUILD)
abi: $(SO) $(FILES_SO)
	@CC='$(CC)' tests/abi.sh $(BUILD) write

.PHONY: check-arrows
check-arrows: $(A) $(FE) $(FILES) $(call obj,$(CLI_SRC))
	@tests/check_arrows.sh $(BUILD)

.PHONY: check-names
check-names:
	@tests/check_names.sh
	@tests/check_public.sh
	@tests/check_lines.sh

# flags that make a wrong library are refused; FLAGS=all: other flags and compilers without a warning, too
.PHONY: check-flags
check-flags: $(SO) $(PROGRAM)
	@tests/flags.sh '$(MAKE)' $(BUILD) '$(CC)' $(FLAGS)

# the core for other processors, tested under qemu; ARCHS, Debian's names
.PHONY: check-cross
ARCHS ?= i386 armhf arm64 s390x ppc64el
check-cross:
	@tests/cross.sh '$(MAKE)' $(BUILD)/cross $(ARCHS)

# what no check on each change has the time for: builds with other options, flags and compilers, for other
# processors; MPI; sanitizers; ten minutes of fuzz for each target. Hours. The first failure ends it, and is named
.PHONY: check-all
PEER_BENCHES = global lemke motion reduction regret scale solvers
CHECK_ALL = check check-abi '$(addprefix $(BUILD)/bench/,$(PEER_BENCHES))' 'check-flags FLAGS=all' 'check-build BUILD=$(BUILD)/plain HDF5=0 MUMPS=0 OPENMP=' \
  'check-mpi BUILD=$(BUILD)/mpi MPI=1' \
  'check-install BUILD=$(BUILD)/mpi MPI=1' 'check-hosts BUILD=$(BUILD)/mpi MPI=1' asan valgrind sequences names 'threads RUNS=5' 'fuzz FUZZ_SECONDS=600' check-cross check-debian check-docs
check-all:
	@$(DEPS) bench checks debian hosts languages mpi pictures
	@for part in $(CHECK_ALL); do echo "check-all: make $$part"; \
	  $(MAKE) --no-print-directory $$part || { echo "check-all: FAILED: make $$part"; exit 1; }; done; \
	  echo 'check-all: every part passed'

.PHONY: check-headers
check-headers:
	@for h in $(HEADERS); do \
	  echo "#include \"$${h#include/}\"" > $(BUILD)/header.c && \
	  $(CC) -std=c11 $(WARNINGS) -Werror -Iinclude $(MPI_CFLAGS) -fsyntax-only $(BUILD)/header.c && \
	  $(CXX) -std=c++17 -Wall -Wextra -Wpedantic -Werror -Iinclude $(MPI_CFLAGS) -fsyntax-only -x c++ $(BUILD)/header.c \
	  || exit 1; done; \
	  echo '#include "delassus.hpp"' > $(BUILD)/header.cpp && \
	  $(CXX) -std=c++17 $(CXX_WARNINGS) -Werror -Iinclude -fsyntax-only $(BUILD)/header.cpp || exit 1; \
	  echo "each of $(words $(HEADERS)) headers compiles alone, C11 and C++17"

.PHONY: lint
lint:
	clang-tidy --quiet --warnings-as-errors='*' $(LIB_SRC) $(FILES_SRC) $(FE_SRC) $(CLI_SRC) $(EXAMPLE_SRC) -- -std=c11 -Iinclude -Isrc -I. -I$(BUILD)/layout $(HDF5_CFLAGS) $(MUMPS_CFLAGS) 2>/dev/null
	cppcheck --quiet --error-exitcode=1 --std=c11 --enable=warning,performance,portability \
	  --inline-suppr -Iinclude -Isrc -I. src lcp vi reduction global examples

.PHONY: format format-check
format:
	clang-format -i $(ALL_C) $(ALL_H) $(ALL_CPP)
# clang-format does not see long lines in comments
format-check:
	clang-format --dry-run --Werror $(ALL_C) $(ALL_H) $(ALL_CPP)
	@awk 'length($$0) > 100 { print FILENAME ":" FNR ": " length($$0) " columns"; long = 1 } END { exit long }' $(ALL_C) $(ALL_H)

PROPERTIES_PROGRAM = $(BUILD)/tests/properties/properties
JUDGES = $(call obj,$(filter-out tests/properties/properties.c tests/properties/test_%,$(wildcard tests/properties/*.c)))
$(PROPERTIES_PROGRAM): $(call obj,tests/properties/properties.c) $(JUDGES) $(A)
	@mkdir -p $(@D)
	$(call say,LINK)
	$(Q)$(CC) $(SANITIZE) $(LDFLAGS) -o $@ $^ $(LIBS)

# the archive once more, behind the objects that need it
$(BUILD)/tests/properties/test_judges: LIBS := $(A) $(LIBS)
$(BUILD)/tests/properties/test_judges: $(JUDGES)
# what bench/ counts as solved
$(BUILD)/tests/front/test_measure: $(call obj,bench/common.c bench/solvers_call.c)

# PROPERTIES='--seed 2 --count 100000'
.PHONY: properties
properties: $(PROPERTIES_PROGRAM)
	OPENBLAS_NUM_THREADS=1 $(PROPERTIES_PROGRAM) --out $(BUILD)/properties $(PROPERTIES)

# the short form
.PHONY: check-properties
check-properties: $(PROPERTIES_PROGRAM)
	@OPENBLAS_NUM_THREADS=1 $(PROPERTIES_PROGRAM) --out $(BUILD)/properties --class each --count 280 --seed 1 --step 2

# ---- torments (tests/torment/README.md) ------------------------------------------------------------

.PHONY: torment
torment:
	@$(MAKE) --no-print-directory faults
	@$(MAKE) --no-print-directory fuzz
	@$(MAKE) --no-print-directory threads
	@$(MAKE) --no-print-directory mutants

# any bytes into every door: an engine of its own, or with clang libFuzzer's
FUZZ_OBJ = $(call obj,$(wildcard tests/torment/fuzz*.c)) $(BUILD)/obj/tests/torment/main.o
FUZZ_CLI = $(filter-out %/main.o,$(call obj,$(CLI_SRC)))
$(call obj,$(wildcard tests/torment/fuzz*.c)): CPP_OF += $(HDF5_CFLAGS) $(FUZZ_CPP)
$(BUILD)/obj/tests/torment/main.o: src/cli/main.c
	@mkdir -p $(@D)
	$(call say,CC  )
	$(Q)$(CC) $(CPPFLAGS_ALL) $(CFLAGS_ALL) -Dmain=delassus_main -Wno-missing-prototypes -c -o $@ $<
$(BUILD)/tests/torment/fuzz: $(FUZZ_OBJ) $(FUZZ_CLI) $(FE) $(FILES) $(A)
	@mkdir -p $(@D)
	$(call say,LINK)
	$(Q)$(CC) $(SANITIZE) $(FUZZ_LINK) $(LDFLAGS) -o $@ $^ $(LIBS)

# every k-th call of malloc, open, fsync, rename, close fails
FAULT_WRAP = $(patsubst %,-Wl$(comma)--wrap=%,malloc calloc realloc free dlsi_dmumps fopen open fdopen fsync rename fclose)
$(call obj,tests/torment/faults.c): CPP_OF += -DWITH_MUMPS=$(if $(MUMPS_LIBS),1,0)
$(BUILD)/tests/torment/faults: $(call obj,tests/torment/faults.c) $(BUILD)/obj/tests/torment/main.o $(FUZZ_CLI) $(FE) $(FILES) $(A)
	@mkdir -p $(@D)
	$(call say,LINK)
	$(Q)$(CC) $(SANITIZE) $(LDFLAGS) $(FAULT_WRAP) -o $@ $^ $(LIBS)
.PHONY: faults check-faults
FAULTS ?= --most=0
faults: $(BUILD)/tests/torment/faults
	OPENBLAS_NUM_THREADS=1 $< $(FAULTS)
check-faults: $(BUILD)/tests/torment/faults
	@OPENBLAS_NUM_THREADS=1 $< --most=16

.PHONY: fuzz check-fuzz
FUZZ_TARGETS = fclib sets mtx text calculix program tables numpy plans lcp contact reduction motion doors calls
FUZZ_SECONDS ?= 60
# under the sanitizers; a target of libFuzzer is told by the program's name
FUZZ_FLAGS = BUILD=$(BUILD)/fuzz CFLAGS='-O1 -g -fno-omit-frame-pointer'
fuzz:
	@if command -v clang >/dev/null; then tests/torment/fuzz.sh '$(MAKE)' $(BUILD)/fuzz $(FUZZ_SECONDS) $(FUZZ_TARGETS); else \
	  $(MAKE) --no-print-directory $(BUILD)/fuzz/tests/torment/fuzz $(FUZZ_FLAGS) SANITIZE='-fsanitize=address,undefined -fno-sanitize-recover=all' && \
	  OPENBLAS_NUM_THREADS=1 $(BUILD)/fuzz/tests/torment/fuzz --seconds=$(FUZZ_SECONDS) --sanitized --out=$(BUILD)/fuzz $(FUZZ_TARGETS); fi

# without clang and sanitizers: memory and time, too
FUZZ ?= --seconds=2
check-fuzz: $(BUILD)/tests/torment/fuzz
	@OPENBLAS_NUM_THREADS=1 $< --out=$(BUILD) $(FUZZ)

# ---- benchmarks, never part of all or check --------------------------------------------------------

# pages, tables and pictures go there
RESULTS ?= bench/results
PEER_CFLAGS = -isystem /usr/include/siconos -isystem /usr/include/siconos/numerics
bench_obj = $(call obj,bench/common.c $(sort $(wildcard bench/$(1).c bench/$(1)_*.c)))
# problems of the benchmarks, and the rule by which they count a solve
bench_scenes = $(call obj,$(addprefix bench/,$(addsuffix .c,solvers_scenes solvers_call solvers_own reduction_boxes regret_kinds regret_bodies regret_grains regret_elastic regret_nets)) $(addprefix tests/shared/,half_space.c rigid.c solids.c surfaces.c))
$(call obj,$(wildcard bench/*.c $(addprefix tests/shared/,half_space.c rigid.c solids.c surfaces.c))): CPP_OF += -Itests/shared
$(call obj,$(wildcard bench/*.c)): CPP_OF += -D_GNU_SOURCE
$(call bench_obj,lemke) $(call bench_obj,solvers): CPP_OF += $(PEER_CFLAGS)
$(call bench_obj,reduction): CPP_OF += -isystem /usr/include/suitesparse $(MUMPS_CFLAGS)
$(call bench_obj,motion) $(call bench_obj,global): CPP_OF += -isystem /usr/include/suitesparse

# what a benchmark links besides its own files and the scenes
bench_of = $(sort $(if $(filter problems,$(1)),$(call obj,bench/problems.c bench/common.c),$(call bench_obj,$(1))) $(bench_scenes)) $(2) $(FE) $(FILES) $(A)
$(BUILD)/bench/solvers: $(call bench_of,solvers,$(call obj,$(addprefix src/,charts/profile_picture.c $(addprefix console/,palette.c picture.c quote.c messages.c))))
$(BUILD)/bench/scale $(BUILD)/bench/regret: $(call obj,bench/solvers_peer.c)
$(BUILD)/bench/auto: $(call bench_of,auto,$(FUZZ_CLI))
$(BUILD)/bench/papers: $(call bench_of,papers,$(call obj,bench/lemke_problems.c))
$(BUILD)/bench/report: $(call bench_of,report,$(call obj,$(filter-out src/cli/main.c,$(CLI_SRC))))
$(foreach b,$(filter-out auto papers report solvers,$(BENCHES) $(PEER_BENCHES)),$(eval $(BUILD)/bench/$(b): $(call bench_of,$(b))))
$(BUILD)/bench/motion $(BUILD)/bench/global: PEER_LIBS = -lcholmod
$(BUILD)/bench/lemke $(BUILD)/bench/solvers $(BUILD)/bench/scale $(BUILD)/bench/regret: PEER_LIBS = -lsiconos_numerics
$(BUILD)/bench/reduction: PEER_LIBS = -lcholmod -lumfpack -ldmumps_seq
$(BUILD)/bench/%:
	@mkdir -p $(@D)
	$(call say,LINK)
	$(Q)$(CC) $(SANITIZE) $(LDFLAGS) -o $@ $^ $(PEER_LIBS) $(LIBS)

.PHONY: bench-lemke bench-solvers bench-reduction bench-auto bench-scale bench-motion bench-global
bench-lemke bench-solvers bench-reduction bench-global: bench-%:
	@$(DEPS) bench
	@$(MAKE) --no-print-directory $(BUILD)/bench/$*
	OPENBLAS_NUM_THREADS=1 $(BUILD)/bench/$* --out $(RESULTS) $(BENCH)
	$(if $(filter --large,$(BENCH)),,gnuplot -e "dir='$(RESULTS)/'" bench/$*.gp)
# without BENCH the page of all its tables
bench-scale:
	@$(DEPS) bench
	@$(MAKE) --no-print-directory $(BUILD)/bench/scale
	$(if $(BENCH),OPENBLAS_NUM_THREADS=1 $(BUILD)/bench/scale --out $(RESULTS) $(BENCH),bench/scale.sh $(BUILD) $(RESULTS))
	gnuplot -e "dir='$(RESULTS)/'" bench/scale.gp
# these need nothing but the library
FCLIB ?= data/fclib
# their programs take the problems of FCLIB, which the head of the page names as the command does
bench-auto bench-least bench-prove: export WRITTEN_BY = make $@$(if $(BENCH), BENCH='$(BENCH)',$(if $(filter file,$(origin FCLIB)),, FCLIB=DIR))
AUTO_PROBLEMS = $(FCLIB)/*.hdf5 plane-200 plane-500 contact-6 contact-10 contact-16 contact-22
bench-auto: $(BUILD)/bench/auto
	OPENBLAS_NUM_THREADS=1 $(BUILD)/bench/auto --out $(RESULTS) $(or $(BENCH),$(AUTO_PROBLEMS))
bench-motion:
	@$(DEPS) bench
	@$(MAKE) --no-print-directory $(BUILD)/bench/motion
	OPENBLAS_NUM_THREADS=1 $(BUILD)/bench/motion --out $(RESULTS) $(BENCH)
.PHONY: bench-bodies
bench-bodies: $(BUILD)/bench/bodies
	OPENBLAS_NUM_THREADS=1 $(BUILD)/bench/bodies --out $(RESULTS) $(BENCH)
.PHONY: bench-lanes
bench-lanes: $(BUILD)/bench/lanes
	OPENBLAS_NUM_THREADS=1 $(BUILD)/bench/lanes --out $(RESULTS) $(BENCH)
bench-regret:
	@$(DEPS) bench
	@$(MAKE) --no-print-directory $(BUILD)/bench/regret
	OPENBLAS_NUM_THREADS=1 $(BUILD)/bench/regret --out $(RESULTS) $(BENCH)
bench-steps: $(BUILD)/bench/steps
	OPENBLAS_NUM_THREADS=1 $(BUILD)/bench/steps --out $(RESULTS)
bench-dynamics: $(BUILD)/bench/dynamics
	OPENBLAS_NUM_THREADS=1 $(BUILD)/bench/dynamics --out $(RESULTS) $(BENCH)
.PHONY: bench-dynamics
.PHONY: bench-trust bench-derive bench-prove bench-least bench-steps bench-regret bench-report
bench-prove: $(BUILD)/bench/prove $(PROGRAM)
	@mkdir -p $(BUILD)/jean
	for scene in jean-fig3 jean-fig4; do for mesh in 8x4 16x8 32x16 64x32 128x64; do \
	  $(PROGRAM) scene $$scene --mesh $$mesh -q --save $(BUILD)/jean/$$scene-$$mesh.hdf5 || exit 1; done; done
	OPENBLAS_NUM_THREADS=1 $(BUILD)/bench/prove --out $(RESULTS) $(FCLIB) $(BUILD)/jean
bench-least: $(BUILD)/bench/least
	OPENBLAS_NUM_THREADS=1 $(BUILD)/bench/least --out $(RESULTS) $(FCLIB)
bench-derive: $(BUILD)/bench/derive
	OPENBLAS_NUM_THREADS=1 $(BUILD)/bench/derive --out $(RESULTS)
bench-trust: $(BUILD)/bench/trust
	OPENBLAS_NUM_THREADS=1 $(BUILD)/bench/trust --out $(RESULTS)
# pictures of benchmarks that the guide shows; of a trial they stay with its page
GUIDE_PICTURES = $(if $(filter bench/results,$(RESULTS)),docs/pictures,$(RESULTS))
.PHONY: bench-papers bench-hard
# BENCH=--page: the page and the picture alone
bench-hard: $(BUILD)/bench/hard
	$(if $(BENCH),,for part in 0 1 2 3 4 5 6 7 8; do OPENBLAS_NUM_THREADS=1 $< --part $$part --out $(RESULTS) || exit 1; done)
	OPENBLAS_NUM_THREADS=1 $< --page --out $(RESULTS)
	gnuplot -e "dir='$(RESULTS)/'; picture='$(GUIDE_PICTURES)/hard.png'" bench/hard.gp
bench-papers: $(BUILD)/bench/papers demo
	cp $(BUILD)/demo/reactions.csv $(RESULTS)/papers_reactions.csv
	cp $(BUILD)/demo/reactions.png $(GUIDE_PICTURES)/papers-reactions.png
	OPENBLAS_NUM_THREADS=1 $(BUILD)/bench/papers --out $(RESULTS) $(BENCH)
	gnuplot -e "dir='$(RESULTS)/'" bench/papers.gp

bench-report: $(BUILD)/bench/report
	OPENBLAS_NUM_THREADS=1 $(BUILD)/bench/report --out $(RESULTS) $(BENCH)

.PHONY: bench-limit
bench-limit: $(SO)
	OPENBLAS_NUM_THREADS=1 RESULTS=$(RESULTS) DELASSUS_LIBRARY=$(SO) $(PYTHON) bench/limit.py

.PHONY: bench-tables
bench-tables: $(PROGRAM)
	bench/tables.sh $(BUILD) $(RESULTS)

# every page that a program writes, on this machine, which should be idle; hours; JOBS=2: two pages at a time
.PHONY: bench-all
LCP ?= data/lcp
bench-all:
	@$(DEPS) bench
	@$(MAKE) --no-print-directory all $(addprefix $(BUILD)/bench/,$(BENCHES) $(PEER_BENCHES))
	@BUILD='$(BUILD)' bench/all.sh '$(FCLIB)' '$(LCP)'

# ---- demo, install ------------------------------------------------------------------------------

.PHONY: demo
demo:
	@$(DEPS) pictures
	@$(MAKE) --no-print-directory all
	@examples/demo.sh $(BUILD)

.PHONY: refinement
refinement: $(PROGRAM)
	@examples/refinement.sh $(BUILD)

# every picture of the docs, from scratch: data, scripts and tables under $(BUILD)/charts
.PHONY: charts
charts: $(PROGRAM) $(BUILD)/bench/problems $(BUILD)/bench/hard
	@docs/charts.sh $(BUILD)

# after charts: the same with ten times the limits of CPU; counts the cells that this changes
.PHONY: charts-longer
charts-longer: $(PROGRAM) $(BUILD)/bench/problems $(BUILD)/bench/hard
	@LONGER=10 docs/charts.sh $(BUILD)

.PHONY: deps
deps:
	@$(DEPS)

INCLUDEDIR = $(PREFIX)/include
DATADIR = $(PREFIX)/share
DOCDIR = $(DATADIR)/doc/delassus
MAN1 = delassus.1 $(patsubst %,delassus-%.1,scene solve info chart map profile report study)
# problems that the guide solves
DATA := $(wildcard data/fclib/*.hdf5 data/lcp/*.mtx data/failures/*.txt)
# the pages of the guide; the others are about the source
GUIDE := $(filter-out docs/contributing.md docs/decisions.md docs/source.md,$(wildcard docs/*.md))
ZSHDIR ?= $(DATADIR)/zsh/site-functions
FISHDIR ?= $(DATADIR)/fish/vendor_completions.d
FILL = sed -e 's|@PREFIX@|$(PREFIX)|' -e 's|@LIBDIR@|$(LIBDIR)|' -e 's|@VERSION@|$(VERSION)|' -e 's|@SOVERSION@|$(SOVERSION)|' -e 's|@LIBS@|$(CORE_LIBS)|' -e 's|@FILES_LIBS@|$(FILES_LIBS)|' -e 's|@MPI_LIBS@|$(MPI_CORE_LIBS)|' -e 's|@MPI_CFLAGS@|$(MPI_INCLUDES)|'

# the guide as HTML with a search, $(BUILD)/docs/html/index.html; installed by `make install` once it is there
.PHONY: docs docs-html
docs:
	@$(DEPS) docs
	@$(MAKE) --no-print-directory docs-html
	@python3 tests/guide.py $(BUILD)/docs/html $(BUILD)
	@python3 tests/links.py $(BUILD)/docs/html include
docs-html:
	@mkdir -p $(BUILD)/docs
	@{ cat docs/Doxyfile; echo 'PROJECT_NUMBER = $(VERSION)'; echo 'OUTPUT_DIRECTORY = $(BUILD)/docs'; \
	  echo 'INPUT = $(GUIDE) examples/README.md $(wildcard include/*.h include/delassus/*.h)'; } | doxygen -
	@python3 docs/search.py $(BUILD)/docs/html

.PHONY: install
install: $(A) $(SO) $(FILES) $(FILES_SO) $(FE) $(PROGRAM) $(F90)
	install -d $(addprefix $(DESTDIR),$(INCLUDEDIR)/delassus $(LIBDIR)/pkgconfig $(LIBDIR)/cmake/delassus $(PREFIX)/bin \
	  $(DATADIR)/man/man1 $(DATADIR)/man/man3 $(DATADIR)/bash-completion/completions $(ZSHDIR) $(FISHDIR) $(DOCDIR)/examples/python $(DOCDIR)/docs/pictures)
	install -m 644 include/delassus.h $(DESTDIR)$(INCLUDEDIR)/
	install -m 644 $(filter include/delassus/%,$(HEADERS)) $(DESTDIR)$(INCLUDEDIR)/delassus/
	install -m 644 include/delassus.hpp $(F90) $(DESTDIR)$(INCLUDEDIR)/
	install -m 644 $(A) $(FILES) $(FE) $(DESTDIR)$(LIBDIR)/
	install -m 755 $(SO).$(VERSION) $(FILES_SO).$(VERSION) $(DESTDIR)$(LIBDIR)/
	for so in $(notdir $(SO) $(FILES_SO)); do \
	  ln -sf $$so.$(VERSION) $(DESTDIR)$(LIBDIR)/$$so.$(SOVERSION); ln -sf $$so.$(VERSION) $(DESTDIR)$(LIBDIR)/$$so; done
	install -m 755 $(PROGRAM) $(DESTDIR)$(PREFIX)/bin/
	$(FILL) src/delassus.pc.in > $(DESTDIR)$(LIBDIR)/pkgconfig/delassus.pc
	$(FILL) src/delassus-files.pc.in > $(DESTDIR)$(LIBDIR)/pkgconfig/delassus-files.pc
	$(FILL) src/delassus-config.cmake.in > $(DESTDIR)$(LIBDIR)/cmake/delassus/delassus-config.cmake
	$(FILL) src/delassus-config-version.cmake.in > $(DESTDIR)$(LIBDIR)/cmake/delassus/delassus-config-version.cmake
	for page in $(MAN1); do docs/man.sh $$page $(PROGRAM) > $(DESTDIR)$(DATADIR)/man/man1/$$page || exit 1; done
	docs/man.sh delassus.3 $(PROGRAM) > $(DESTDIR)$(DATADIR)/man/man3/delassus.3
	install -m 644 src/cli/completion.bash $(DESTDIR)$(DATADIR)/bash-completion/completions/delassus
	install -m 644 src/cli/completion.zsh $(DESTDIR)$(ZSHDIR)/_delassus
	install -m 644 src/cli/completion.fish $(DESTDIR)$(FISHDIR)/delassus.fish
	for folder in $(sort $(dir $(DATA))); do install -d $(DESTDIR)$(DOCDIR)/$$folder; done
	for page in README.md CHANGELOG.md examples/README.md data/failures/README.md $(GUIDE); do \
	  awk -f docs/installed.awk $$page > $(DESTDIR)$(DOCDIR)/$$page && chmod 644 $(DESTDIR)$(DOCDIR)/$$page || exit 1; done
	install -m 644 LICENSE $(DESTDIR)$(DOCDIR)/
	install -m 644 docs/*.png $(DESTDIR)$(DOCDIR)/docs/
	install -m 644 docs/pictures/*.png $(DESTDIR)$(DOCDIR)/docs/pictures/
	install -m 644 examples/*.c examples/*.cpp examples/*.f90 examples/*.py $(DESTDIR)$(DOCDIR)/examples/
	for file in $(DATA); do install -m 644 $$file $(DESTDIR)$(DOCDIR)/$$file || exit 1; done
	install -m 644 $(filter-out %.md,$(wildcard examples/python/*)) $(DESTDIR)$(DOCDIR)/examples/python/
	if [ -f $(BUILD)/docs/html/index.html ]; then cp -r $(BUILD)/docs/html $(DESTDIR)$(DOCDIR)/; fi

# what install has written, of this version
.PHONY: uninstall
uninstall:
	rm -f $(addprefix $(DESTDIR),$(INCLUDEDIR)/delassus.h $(INCLUDEDIR)/delassus.hpp $(INCLUDEDIR)/delassus.f90 $(addprefix $(LIBDIR)/,libdelassus.a libdelassus-files.a libdelassus-fe.a libdelassus-mpi.a \
	  $(foreach so,$(addsuffix .so,libdelassus libdelassus-files libdelassus-mpi),$(so) $(so).$(SOVERSION) $(so).$(VERSION)) \
	  $(addprefix pkgconfig/,delassus.pc delassus-files.pc delassus-mpi.pc)) $(PREFIX)/bin/delassus $(PREFIX)/bin/delassus-mpi \
	  $(addprefix $(DATADIR)/man/man1/,$(MAN1) delassus-mpi.1) $(DATADIR)/man/man3/delassus.3 $(DATADIR)/bash-completion/completions/delassus $(ZSHDIR)/_delassus $(FISHDIR)/delassus.fish)
	rm -rf $(addprefix $(DESTDIR),$(INCLUDEDIR)/delassus $(LIBDIR)/cmake/delassus $(DOCDIR) $(if $(PYTHON),$(PYTHONDIR)/delassus))

# installs into a directory, builds and runs examples from there alone, uninstalls
.PHONY: check-install
check-install: $(A) $(SO) $(FILES) $(FILES_SO) $(FE) $(PROGRAM)
	@MAKE='$(MAKE)' MPI='$(MPI)' CC='$(CC)' CXX='$(CXX)' FC='$(FC)' PYTHON='$(PYTHON)' tests/install.sh $(BUILD)

# the wheel, the source package and an editable install of Python, without network; mypy
.PHONY: check-packages
check-packages: $(SO)
	@PYTHON='$(PYTHON)' tests/packages.sh $(SO).$(VERSION)

# packages for Debian, in a copy of the tree; no error of lintian
.PHONY: check-debian
check-debian:
	@tests/debian.sh

# every command and program of the documents, in a copy of the tree; QUICK=--quick: without the slow ones
.PHONY: check-docs
check-docs: $(TESTED) $(F90)
	@MAKE='$(MAKE)' PYTHON='$(PYTHON)' python3 tests/docs.py $(BUILD) $(QUICK)

# dead links and file names in the documents of the tree, and as they are installed, with the HTML guide if it is built
.PHONY: check-links
check-links: all
	@python3 tests/links.py .
	@root=$$(mktemp -d) && $(MAKE) -s install PREFIX=$$root > $$root/log 2>&1 && \
	  python3 tests/links.py $$root/share/doc/delassus $$root/include; status=$$?; rm -rf $$root; exit $$status

.PHONY: check-hosts
check-hosts:
	@$(DEPS) hosts
	@$(MAKE) --no-print-directory all
	@CC='$(CC)' CXX='$(CXX)' PYTHON='$(PYTHON)' examples/hosts/run.sh $(BUILD)
	@CC='$(CC)' tests/hosts/run.sh $(BUILD)

.PHONY: dist
dist:
	@mkdir -p $(BUILD)
	git archive --prefix=delassus-$(VERSION)/ -o $(BUILD)/delassus-$(VERSION).tar.gz HEAD
	@echo $(BUILD)/delassus-$(VERSION).tar.gz

# the Python package beside an installed library; without make install, pip install . does
PYTHONDIR ?= $(PREFIX)/lib/$(shell $(or $(PYTHON),python3) -c 'import sys, sysconfig as s; print("python%d.%d/" % sys.version_info[:2] + s.get_path("purelib").split("/")[-1])')
.PHONY: install-python
install-python:
	@test -n '$(PYTHON)' || { echo 'install-python: no python3 with numpy and scipy; PYTHON=... names one'; exit 2; }
	install -d $(DESTDIR)$(PYTHONDIR)/delassus
	install -m 644 src/python/delassus/*.py src/python/delassus/py.typed $(DESTDIR)$(PYTHONDIR)/delassus/

.PHONY: clean
clean:
	rm -rf $(BUILD)

-include $(shell find $(BUILD) -name '*.d' 2>/dev/null)
