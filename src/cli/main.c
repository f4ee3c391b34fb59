/* main.c: the program `delassus`: runs a command, prints help and version. */
#define _GNU_SOURCE /* MAP_ANONYMOUS */
#include <signal.h>
#include <string.h>
#include <sys/mman.h>
#include <unistd.h>

#include "charts/chart.h"
#include "charts/map.h"
#include "charts/profile.h"
#include "cli.h"
#include "linear/blas.h"
#include "report/report.h"

static void program_usage(FILE *out) {
  fputs("Usage: delassus COMMAND [OPTION]...\n"
        "Solves problems of unilateral contact with Coulomb friction.\n"
        "\n"
        "  delassus scene NAME   run a built-in scene ('delassus scene --list' names them)\n"
        "  delassus solve FILE   solve a problem from a file (FCLIB or text), or of a scene\n"
        "  delassus solve --stiffness=K --HN=N --HT=T --f=F --mu=MU\n"
        "                        solve a problem from the matrices of a host code\n"
        "  delassus solve --lcp M.mtx q.mtx\n"
        "                        solve an LCP given as two Matrix Market files\n"
        "  delassus info FILE    facts about a problem: symmetry, rank, friction bounds\n"
        "  delassus chart NAME   each method on one problem: accuracy against CPU, a picture\n"
        "  delassus map NAME...  which method works up to which friction: a picture\n"
        "  delassus profile NAME...   each method on many problems: performance profiles\n"
        "  delassus report NAME...    a page: how accurate, fast and stable, and what is enough\n"
        "  delassus study --table=CASES.csv ...   many cases: a line of JSON each, K factorised "
        "once\n"
        "\n"
        "  delassus help [COMMAND | methods | scenes]\n"
        "  -h, --help            this text; 'delassus COMMAND --help' for a command's options\n"
        "  -V, --version         version\n"
        "\n"
        "Exit status: 0 solved, 1 not solved, 2 bad input.\n",
        out);
}

/* Is in OpenBLAS alone; NULL with another BLAS. */
extern void openblas_set_num_threads(int count) __attribute__((weak));

/* OpenBLAS looks without end for the memory of its buffer if there is none (a limit on the address
 * space: ulimit -v, a batch system). Has it take that now, before anything else takes memory.
 * Returns 0 after a complaint. */
static int blas_takes_memory(void) {
  const size_t wanted = (size_t)160 << 20; /* its buffer of 128 MB, and its tables */
  const int one = 1;
  const double x = 1, zero = 0;
  double y = 0;
  if (!openblas_set_num_threads) return 1;
  void *const buffer =
      mmap(NULL, wanted, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
  if (buffer == MAP_FAILED)
    return refuse("no memory for the buffer of OpenBLAS: 160 MB of address space (ulimit -v)");
  (void)munmap(buffer, wanted);
  dsyrk_("L", "N", &one, &one, &x, &x, &one, &zero, &y, &one, 1, 1);
  return 1;
}

static int run_scene_command(int argc, char **argv) {
  const scene_kind kind = kind_among(argc, argv);
  return kind == SCENE_FORMING  ? command_forming(argc, argv)
         : kind == SCENE_MOVING ? command_moving(argc, argv)
                                : command_scene(argc, argv);
}

static const struct {
  const char *name;
  int (*run)(int argc, char **argv);
} commands[] = {{"scene", run_scene_command}, {"solve", command_solve},
                {"info", command_info},       {"chart", command_chart},
                {"map", command_map},         {"profile", command_profile},
                {"report", command_report},   {"study", command_study}};
enum { COMMANDS = sizeof commands / sizeof commands[0] };

/* Returns the place of a command, -1 for none. */
static int find_command(const char *name) {
  for (int k = 0; k < COMMANDS; k++)
    if (!strcmp(commands[k].name, name)) return k;
  return -1;
}

/* Complains of a word that is no command: it may be a file, a scene or a mistyped command. */
static int no_command(const char *word) {
  nearest near = {.word = word};
  for (int k = 0; k < COMMANDS; k++)
    nearest_try(&near, commands[k].name);
  static const char *const topics[] = {"help", "methods", "scenes", "commands"};
  for (int k = 0; k < 4; k++)
    nearest_try(&near, topics[k]);
  if (kind_of_scene(word)) return complain("'%s' is a scene: delassus scene %s", word, word);
  if (!near.count && access(word, F_OK) == 0)
    return is_no_problem(word) ? EXIT_BAD_INPUT
                               : complain("'%s' is a file: delassus solve %s", word, word);
  return complain("'%s' is no command%s", word,
                  near.count ? nearest_words(&near) : "; see 'delassus --help'");
}

/* delassus help [COMMAND | methods | scenes | commands] */
static int help_command(int argc, char **argv) {
  static char wanted[] = "--help";
  const char *word = argc > 1 ? argv[1] : "";
  if (!*word) return program_usage(stdout), EXIT_SOLVED;
  const int k = find_command(word);
  if (k >= 0) {
    char *words[] = {argv[1], wanted, NULL};
    return commands[k].run(2, words);
  }
  if (!strcmp(word, "methods")) {
    for (int i = 0; dls_method_name((dls_method)i); i++)
      printf("%-20s %s\n", dls_method_name((dls_method)i), dls_method_summary((dls_method)i));
  } else if (!strcmp(word, "scenes")) {
    for (int i = 0; scene_name(i); i++)
      printf("%-13s %s\n", scene_name(i), scene_description(i));
  } else if (!strcmp(word, "commands")) {
    for (int i = 0; i < COMMANDS; i++)
      puts(commands[i].name);
  } else
    return no_command(word);
  return EXIT_SOLVED;
}

int main(int argc, char **argv) {
  const char *name = argc > 1 ? argv[1] : "";
  const int k = find_command(name);
  int result;
  (void)signal(SIGXFSZ, SIG_IGN); /* beyond ulimit -f a write fails, as on a full disk */
  if (k >= 0 && !blas_takes_memory()) return EXIT_BAD_INPUT;
  if (k >= 0)
    result = commands[k].run(argc - 1, argv + 1);
  else if (!strcmp(name, "help"))
    result = help_command(argc - 1, argv + 1);
  else if (!strcmp(name, "--help") || !strcmp(name, "-h")) {
    program_usage(stdout);
    result = EXIT_SOLVED;
  } else if (!strcmp(name, "--version") || !strcmp(name, "-V")) {
    printf("delassus %s\n", dls_version());
    result = EXIT_SOLVED;
  } else
    result = *name ? no_command(name) : (program_usage(stderr), EXIT_BAD_INPUT);
  return end_program(result);
}
