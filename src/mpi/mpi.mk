# mpi.mk: what make MPI=1 adds; Makefile includes it from the top of the tree.

MPI_SRC := $(filter-out src/mpi/main.c,$(wildcard src/mpi/*.c))
MPI_OBJ := $(call obj,$(MPI_SRC)) $(LIB_OBJ)
MPI_A = $(BUILD)/libdelassus-mpi.a
MPI_SO = $(BUILD)/libdelassus-mpi.so
MPI_PROGRAM = $(BUILD)/delassus-mpi
# of the library; of a program that reads files
MPI_CORE_LIBS = $(MPI_LIBS) $(CORE_LIBS)
MPI_LIBS_ALL = $(HDF5_LIBS) -lz $(MPI_CORE_LIBS)
MPI_TESTS := $(patsubst tests/mpi/%.c,$(BUILD)/mpi/%,$(wildcard tests/mpi/test_*.c))
# PETSc's example where petsc-dev is there
PETSC_CFLAGS := $(patsubst -I%,-isystem %,$(shell $(PKG_CONFIG) --silence-errors --cflags petsc))
PETSC_LIBS := $(shell $(PKG_CONFIG) --silence-errors --libs petsc)
MPI_EXAMPLES := $(addprefix $(BUILD)/examples/mpi/,host_slabs $(if $(PETSC_LIBS),host_petsc))

all: $(MPI_A) $(MPI_SO) $(MPI_PROGRAM) $(MPI_EXAMPLES)

$(call obj,$(wildcard src/mpi/*.c)) $(call obj,$(wildcard tests/mpi/*.c bench/mpi*.c)): CPP_OF += $(MPI_CFLAGS)

$(MPI_A): $(MPI_OBJ)
	@rm -f $@
	$(call say,AR  )
	$(Q)$(AR) rcs $@ $^

$(MPI_SO).$(VERSION): $(MPI_OBJ) src/delassus.map
	$(call say,LINK)
	$(Q)$(CC) -shared $(SANITIZE) $(HARDEN_LINK) $(LDFLAGS) -Wl,-soname,$(notdir $(MPI_SO)).$(SOVERSION) \
	  -Wl,--version-script=src/delassus.map -o $@ $(MPI_OBJ) $(MPI_CORE_LIBS)

$(MPI_PROGRAM): $(call obj,src/mpi/main.c $(filter-out src/cli/main.c,$(CLI_SRC))) $(FE) $(FILES) $(MPI_A)
	$(call say,LINK)
	$(Q)$(CC) $(SANITIZE) $(LDFLAGS) -o $@ $^ $(LIBS) $(MPI_LIBS_ALL)

$(BUILD)/examples/mpi/host_petsc: EXAMPLE_CFLAGS = $(PETSC_CFLAGS)
$(BUILD)/examples/mpi/host_petsc: EXAMPLE_LIBS = $(PETSC_LIBS)
$(BUILD)/examples/mpi/%: examples/mpi/%.c $(MPI_A)
	@mkdir -p $(@D)
	$(call say,LINK)
	$(Q)$(CC) $(CPPFLAGS_ALL) $(MPI_CFLAGS) $(EXAMPLE_CFLAGS) $(CFLAGS_ALL) $(LDFLAGS) -o $@ $< $(MPI_A) $(EXAMPLE_LIBS) $(MPI_LIBS_ALL)

$(call obj,$(wildcard tests/mpi/*.c)): CPP_OF += -Itests/shared -D_GNU_SOURCE
$(BUILD)/mpi/%: $(BUILD)/obj/tests/mpi/%.o $(call obj,tests/mpi/shares.c tests/shared/malloc_fails.c tests/shared/errors.c tests/shared/solids.c bench/reduction_boxes.c) $(MPI_A)
	@mkdir -p $(@D)
	$(call say,LINK)
	$(Q)$(CC) $(SANITIZE) $(LDFLAGS) $(WRAP) -o $@ $^ $(CHECK_LIBS) $(MPI_LIBS_ALL)

# make check-mpi RANKS=2: on two ranks only
RANKS = 1 2 4
.PHONY: check-mpi
check-mpi: $(MPI_TESTS) $(MPI_PROGRAM) $(PROGRAM) $(MPI_EXAMPLES)
	@tests/mpi/run.sh $(BUILD) $(RANKS)

$(BUILD)/bench/mpi $(BUILD)/bench/mpi_global: $(BUILD)/bench/%: $(BUILD)/obj/bench/%.o $(call obj,bench/mpi_waits.c tests/mpi/shares.c bench/common.c bench/reduction_boxes.c tests/shared/solids.c) $(MPI_A)
	@mkdir -p $(@D)
	$(call say,LINK)
	$(Q)$(CC) $(SANITIZE) $(LDFLAGS) -Wl,--wrap=clock_gettime -o $@ $^ $(MPI_LIBS_ALL) -lmpi_mpifh

$(if $(shell command -v $(MPICC)),,$(error MPI=1 needs $(MPICC) and more: run .ci/deps mpi))

install: install-mpi
.PHONY: install-mpi
install-mpi: $(MPI_A) $(MPI_SO) $(MPI_PROGRAM) $(PROGRAM)
	install -d $(addprefix $(DESTDIR),$(LIBDIR)/pkgconfig $(PREFIX)/bin $(DATADIR)/man/man1 $(DOCDIR)/examples/mpi)
	install -m 644 $(MPI_A) $(DESTDIR)$(LIBDIR)/
	install -m 755 $(MPI_SO).$(VERSION) $(DESTDIR)$(LIBDIR)/
	for link in $(notdir $(MPI_SO) $(MPI_SO).$(SOVERSION)); do \
	  ln -sf $(notdir $(MPI_SO)).$(VERSION) $(DESTDIR)$(LIBDIR)/$$link; done
	$(FILL) src/delassus-mpi.pc.in > $(DESTDIR)$(LIBDIR)/pkgconfig/delassus-mpi.pc
	install -m 755 $(MPI_PROGRAM) $(DESTDIR)$(PREFIX)/bin/
	docs/man.sh delassus-mpi.1 $(PROGRAM) > $(DESTDIR)$(DATADIR)/man/man1/delassus-mpi.1
	install -m 644 examples/mpi/*.c $(DESTDIR)$(DOCDIR)/examples/mpi/

.PHONY: bench-mpi-global
bench-mpi-global: $(BUILD)/bench/mpi_global $(MPI_EXAMPLES)
	bench/mpi_global.sh $(BUILD) $(RESULTS) $(BENCH)

.PHONY: bench-mpi
bench-mpi: $(BUILD)/bench/mpi
	bench/mpi.sh $(BUILD) $(RESULTS) $(BENCH)
