/* main.c: the program `delassus`: runs a command, prints help and version. */
#define _GNU_SOURCE /* MAP_ANONYMOUS */
#include <string.h>
#include <sys/mman.h>

#include "cli.h"
#include "linear/blas.h"

static void program_usage(FILE *out) {
  fputs(
      "Usage: delassus COMMAND [OPTION]...\n"
      "Unilateral contact with dry friction: benchmark scenes and problem files.\n"
      "\n"
      "  delassus scene NAME   run a built-in scene ('delassus scene --list' names them)\n"
      "  delassus converge SCENE\n"
      "                        error of a moving bar against the length of an element\n"
      "  delassus tables       Tables 2 and 3 of Chabrand (1998) beside ours\n"
      "  delassus solve FILE   solve an FCLIB problem (HDF5, local or global)\n"
      "  delassus solve --stiffness=K --HN=N --HT=T --f=F --mu=MU\n"
      "                        solve a problem from the matrices of a host code\n"
      "  delassus solve --lcp M.mtx q.mtx\n"
      "                        solve an LCP given as two Matrix Market files\n"
      "  delassus info FILE    facts about an FCLIB problem: symmetry, rank, friction bounds\n"
      "  delassus chart NAME   every method on a file or scene: CPU against precision, a picture\n"
      "  delassus map NAME...  which method works up to which friction: a picture\n"
      "  delassus profile NAME...   every method on many of them: performance profiles\n"
      "\n"
      "  -h, --help            this text; 'delassus COMMAND --help' for a command's options\n"
      "  -V, --version         version\n"
      "\n"
      "Exit status: 0 solved, 1 not solved, 2 bad input.\n",
      out);
}

/* Is in OpenBLAS alone; NULL with another BLAS. */
extern void openblas_set_num_threads(int count) __attribute__((weak));

/* OpenBLAS looks for ever for the memory of its buffer if there is none (a limit on the address
 * space: ulimit -v, a batch system). Has it take that now, before anything else takes memory.
 * Returns 0 after a complaint. */
static int blas_takes_memory(void) {
  const size_t wanted = (size_t)160 << 20; /* its buffer of 128 MB, and its tables */
  const int one = 1;
  const double x = 1, zero = 0;
  double y = 0;
  if (!openblas_set_num_threads) return 1;
  void *const trial =
      mmap(NULL, wanted, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
  if (trial == MAP_FAILED) {
    (void)complain("no memory for the buffer of OpenBLAS: 160 MB of address space (ulimit -v)");
    return 0;
  }
  (void)munmap(trial, wanted);
  dsyrk_("L", "N", &one, &one, &x, &x, &one, &zero, &y, &one, 1, 1);
  return 1;
}

int main(int argc, char **argv) {
  const char *name = argc > 1 ? argv[1] : "";
  int result;
  if (name[0] && name[0] != '-' && !blas_takes_memory()) return EXIT_BAD_INPUT;
  if (!strcmp(name, "scene") && names_forming(argc - 1, argv + 1))
    result = command_forming(argc - 1, argv + 1);
  else if (!strcmp(name, "scene") && names_moving(argc - 1, argv + 1))
    result = command_moving(argc - 1, argv + 1);
  else if (!strcmp(name, "converge"))
    result = command_converge(argc - 1, argv + 1);
  else if (!strcmp(name, "tables"))
    result = command_tables(argc - 1, argv + 1);
  else if (!strcmp(name, "scene"))
    result = command_scene(argc - 1, argv + 1);
  else if (!strcmp(name, "solve"))
    result = command_solve(argc - 1, argv + 1);
  else if (!strcmp(name, "info"))
    result = command_info(argc - 1, argv + 1);
  else if (!strcmp(name, "chart"))
    result = command_chart(argc - 1, argv + 1);
  else if (!strcmp(name, "map"))
    result = command_map(argc - 1, argv + 1);
  else if (!strcmp(name, "profile"))
    result = command_profile(argc - 1, argv + 1);
  else if (!strcmp(name, "--help") || !strcmp(name, "-h")) {
    program_usage(stdout);
    result = EXIT_SOLVED;
  } else if (!strcmp(name, "--version") || !strcmp(name, "-V")) {
    printf("delassus %s\n", dls_version());
    result = EXIT_SOLVED;
  } else {
    result = name[0] ? complain("'%s' is no command; see 'delassus --help'", name)
                     : (program_usage(stderr), EXIT_BAD_INPUT);
  }
  drop_files();
  drop_inputs();
  if (fflush(stdout) || ferror(stdout)) return complain("cannot write to standard output");
  return result;
}
