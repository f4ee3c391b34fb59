/* test_endings.c: the last line of every command, --quiet, --verbose, colours on a terminal. */
#define _GNU_SOURCE
#include <fcntl.h>
#include <sys/wait.h>
#include <unistd.h>

#include "program.h"
#include "run.h"

/* A call, its exit status and its last line. */
typedef struct ending {
  const char *arguments;
  int status;
  const char *line;
} ending;

static const ending endings[] = {
    {"solve data/failures/c20-scales.txt", 0, "solved"},
    {"solve data/failures/c04-squeezed.txt", 1, "not solved: no solution exists"},
    {"solve --lcp data/failures/c20-scales.txt", 2, ""},
    {"solve --lcp data/failures/l01-cycling.txt", 0, "solved"},
    {"solve data/failures/l05-no-solution.txt", 1, "not solved: no solution exists"},
    {"scene jean-fig3", 0, "solved"},
    {"scene jean-fig3 -m nlgs -i 3", 1, "not solved: iteration limit reached"},
    {"scene indentation --mesh 4x4 --steps 20", 0, "solved"},
    {"scene indentation --mesh 4x4 --tol 1e-16", 1, "not solved: no further progress"},
    {"scene block-drop --steps 50", 0, "solved"},
    {"scene two-blocks --mu 0.1", 1, "not solved: no solution exists"}, /* it slides off */
    {"chart -r 1 data/failures/c20-scales.txt -o @", 0, "solved"},
    {"chart -r 1 data/failures/c04-squeezed.txt -o @", 1, "not solved: auto to 1e-02: proved none"},
    {"map jean-fig4 --rows 2 --limit 0.05 -o @", 0, "solved"},
    {"map two-blocks --rows 2 --mu 0:0.3 -o @", 1, "not solved: not every run finishes"},
    {"map data/failures/c20-scales.txt --against rank --samples 1 --rows 1 -o @", 0, "solved"},
    {"study jean-fig4 -o @/s", 0, "solved"},
    {"profile -r 1 jean-fig4 data/failures/c03-jam-above.txt -o @", 1,
     "not solved: auto fails on 1 of 2 problems"},
};
enum { ENDINGS_OF_ALL = sizeof endings / sizeof endings[0] };

/* The last line tells what the exit status tells; with --quiet it is the only one. */
TEST_EACH(last_line_in_words, 0, ENDINGS_OF_ALL) {
  const ending *e = &endings[_i];
  char arguments[300], line[200];
  (void)snprintf(line, sizeof line, e->status == 2 ? "%s" : "%s\n", e->line);
  ck_assert_msg(run(e->arguments) == e->status, "%s: %s", e->arguments, output);
  const size_t length = strlen(output), tail = strlen(line);
  ck_assert_msg(length > tail && strcmp(output + length - tail, line) == 0, "%s: %s", e->arguments,
                output);
  if (e->status == 2) return;
  (void)snprintf(arguments, sizeof arguments, "%s --quiet", e->arguments);
  ck_assert_int_eq(run(arguments), e->status);
  ck_assert_str_eq(output, line);
}

/* One object, and nothing after it; what an option asks for is printed with --quiet, too. */
TEST(json_stands_alone) {
  static const char *const calls[] = {"solve -q --json data/failures/c20-scales.txt",
                                      "scene -q --json jean-fig3",
                                      "scene indentation --mesh 4x4 --steps 10 --json -q",
                                      "info -q --json data/failures/c20-scales.txt"};
  for (size_t k = 0; k < sizeof calls / sizeof calls[0]; k++) {
    ck_assert_int_eq(run(calls[k]), 0);
    const size_t length = strlen(output);
    ck_assert_msg(output[0] == '{' && length > 3 && strcmp(output + length - 3, "\n}\n") == 0,
                  "%s: %s", calls[k], output);
  }
  ck_assert_int_eq(run("info -q data/failures/c20-scales.txt"), 0);
  ck_assert_str_eq(output, "");
}

/* --verbose tells each step on stderr and leaves stdout as it is. */
TEST(verbose_goes_to_stderr) {
  NEEDS_HDF5;
  static const char *const calls[][2] = {
      {"solve data/failures/c20-scales.txt", "s of CPU, residual"},
      {"scene jean-fig3", "s of CPU, residual"},
      {"scene indentation --mesh 4x4 --steps 10", "step: 10 of at most 10"},
      {"scene block-drop --steps 20", "block-drop: 20 of at most 20"},
      {"map data/failures/c20-scales.txt --rows 2 -o @", "s of CPU, residual"},
      {"info data/fclib/gfc2d_granularflowonwall_00069_00350.hdf5", "reduction: "}};
  char arguments[300];
  for (size_t k = 0; k < sizeof calls / sizeof calls[0]; k++) {
    (void)snprintf(arguments, sizeof arguments, "%s -v", calls[k][0]);
    ck_assert_int_eq(run(arguments), 0);
    ck_assert_msg(strstr(output, calls[k][1]) != NULL, "%s: %s", arguments, output);
    (void)snprintf(arguments, sizeof arguments, "%s -v 2>/dev/null | cat", calls[k][0]);
    ck_assert_int_eq(run(arguments), 0);
    ck_assert_msg(strstr(output, calls[k][1]) == NULL, "%s: %s", arguments, output);
  }
}

/* Runs a solve whose stdout is a terminal; text: room for 100 characters of it. */
static void run_on_terminal(const char *problem, char text[100]) {
  char arguments[200];
  const int master = posix_openpt(O_RDWR | O_NOCTTY);
  ck_assert(master >= 0 && grantpt(master) == 0 && unlockpt(master) == 0);
  const int held = open(ptsname(master), O_RDWR | O_NOCTTY); /* what is printed stays there */
  ck_assert_int_ge(held, 0);
  (void)snprintf(arguments, sizeof arguments, "solve -q %s >%s", problem, ptsname(master));
  (void)run(arguments);
  const ssize_t got = read(master, text, 99);
  ck_assert_int_gt(got, 0);
  text[got] = '\0';
  (void)close(held);
  (void)close(master);
}

TEST(colour_unless_no_color) {
  char text[100];
  unsetenv("NO_COLOR");
  run_on_terminal("data/failures/c20-scales.txt", text);
  ck_assert_str_eq(text, "\033[32msolved\033[0m\r\n");
  run_on_terminal("data/failures/c04-squeezed.txt", text);
  ck_assert_str_eq(text, "\033[31mnot solved: no solution exists\033[0m\r\n");
  ck_assert_int_eq(setenv("NO_COLOR", "1", 1), 0);
  run_on_terminal("data/failures/c20-scales.txt", text);
  ck_assert_str_eq(text, "solved\r\n");
}

/* Ctrl-C draws what is done, and the last line says that it is not all. */
TEST(interrupted_is_not_solved) {
  const char *program = getenv("DELASSUS_PROGRAM");
  char command[400], line[100];
  (void)snprintf(command, sizeof command,
                 "timeout --preserve-status -s INT 1 %s map jean-fig3 --against condition "
                 "--samples 100000 -q -o %s",
                 program ? program : "build/delassus", directory);
  FILE *pipe = popen(command, "r");
  ck_assert_ptr_nonnull(pipe);
  ck_assert_ptr_nonnull(fgets(line, sizeof line, pipe));
  ck_assert_str_eq(line, "not solved: cancelled\n");
  const int status = pclose(pipe);
  ck_assert(WIFEXITED(status) && WEXITSTATUS(status) == 1);
}

/* A signal ends the program while it reads, here a file without an end; `timeout` would kill it
 * 20 s later and return 137. */
TEST(reading_ends_at_once) {
  static const int signals[] = {SIGINT, SIGTERM};
  const char *program = getenv("DELASSUS_PROGRAM");
  char command[400];
  for (int k = 0; k < 2; k++) {
    (void)snprintf(command, sizeof command,
                   "timeout -k 20 -s %d 1 %s solve --lcp /dev/zero /dev/zero; test $? = 124",
                   signals[k], program ? program : "build/delassus");
    ck_assert_int_eq(system(command), 0);
  }
}

/* OpenBLAS looks without end for memory that is not there: the program ends at once. */
TEST(little_address_space) {
#ifdef __SANITIZE_ADDRESS__
  return; /* takes terabytes of it */
#endif
  const char *program = getenv("DELASSUS_PROGRAM");
  char command[400];
  for (int limit = 60000; limit <= 240000; limit += 30000) {
    (void)snprintf(command, sizeof command,
                   "ulimit -v %d; OPENBLAS_NUM_THREADS=1 timeout 60 %s solve -m newton "
                   "data/failures/c20-scales.txt >/dev/null 2>&1",
                   limit, program ? program : "build/delassus");
    const int status = system(command);
    ck_assert(WIFEXITED(status));
    ck_assert_msg(WEXITSTATUS(status) != 124, "ulimit -v %d: still at work after 60 s", limit);
  }
}

/* Returns the exit status of the program under a limit of the shell. */
static int run_within(const char *limit, const char *arguments) {
  const char *program = getenv("DELASSUS_PROGRAM");
  char command[600];
  (void)snprintf(command, sizeof command,
                 "cd %s && p=%s%s && ulimit %s && env -i PATH=$PATH "
                 "OPENBLAS_NUM_THREADS=1 timeout 100 $p %s >out 2>&1",
                 directory, program && program[0] == '/' ? "" : "$OLDPWD/",
                 program ? program : "build/delassus", limit, arguments);
  const int status = system(command);
  ck_assert(WIFEXITED(status));
  return WEXITSTATUS(status);
}

/* A file may not grow further, as on a full disk: the error has a name, the rows that were written
 * stay, and nothing else does. */
TEST(no_room_for_files) {
  static const struct {
    const char *limit, *arguments, *table, *head;
  } runs[] = {
      {"-f 6", "scene indentation --mesh 6x4 --no-pictures --out o", "o/force.csv", "travel,"},
      {"-f 1", "scene indentation --mesh 6x4 --no-pictures --out o", "o/force.csv", "travel,"},
      {"-f 20", "scene block-drop --no-pictures --out o", "o/energy.csv", "t,kinetic"},
      {"-f 2", "map jean-fig4 --rows 4 --limit 0.05 --out o", "o/map.csv", "row,mu"}};
  for (size_t k = 0; k < sizeof runs / sizeof *runs; k++) {
    ck_assert_int_eq(run_within(runs[k].limit, runs[k].arguments), 2);
    const char *text = contents("out");
    ck_assert_msg(strstr(text, "File too large") != NULL, "%zu: %s", k, text);
    text = contents(runs[k].table);
    const char *row = strchr(text, '\n');
    ck_assert_msg(strncmp(text, runs[k].head, strlen(runs[k].head)) == 0, "%zu: %s", k, text);
    ck_assert_msg(row && row[1] && text[strlen(text) - 1] == '\n', "%zu: %s", k, text);
    ck_assert_int_eq(
        run_within("-f 1000", "-V >/dev/null; test -z \"$(find . -name '.delassus*')\""), 0);
    ck_assert_int_eq(run_within("-f 1000", "-V >/dev/null; rm -r o"), 0);
  }
}

/* A stack of 96 kB is enough. */
TEST(little_stack) {
#ifdef __SANITIZE_ADDRESS__
  return; /* takes more of it */
#endif
  static const char *const calls[] = {"solve -q ", "report --quick -q --out o ", "info -q ",
                                      "chart -r 1 -q --out o2 ", "map --rows 2 -q --out o3 "};
  char arguments[300], cwd[200];
  ck_assert_ptr_nonnull(getcwd(cwd, sizeof cwd));
  for (size_t k = 0; k < sizeof calls / sizeof *calls; k++) {
    (void)snprintf(arguments, sizeof arguments, "%s%s/data/failures/c20-scales.txt", calls[k], cwd);
    ck_assert_msg(run_within("-s 96", arguments) == 0, "%s", arguments);
  }
}

int main(void) {
  return run_tests("endings", make_directory, remove_directory);
}
