/*
 * test_study.c: delassus study: a case's line has the answer of `delassus solve`, whatever the
 * order; cases that are there are skipped; parts join to the whole; wrong tables.
 */
#define _GNU_SOURCE
#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include "program.h"
#include "run.h"

static int line_feeds(const char *text) {
  int count = 0;
  for (; *text; text++)
    count += *text == '\n';
  return count;
}

/* One node on two springs, pressed and pushed: r_n = 3 f_n / 3, and |r_t| <= mu r_n by hand. */
static void write_springs(void) {
  write_file("K.txt", "3 0\n0 2\n");
  write_file("N.txt", "1\n0\n");
  write_file("T.txt", "0\n1\n");
  write_file("f.txt", "-6\n2\n");
  write_file("g.txt", "-12\n2\n"); /* twice the load */
}

#define POINT "study --stiffness=@/K.txt --HN=@/N.txt --HT=@/T.txt "

/* Reads the first number behind text on the line of `output` with `key`. */
static double number_on_line(const char *key, const char *text) {
  const char *line = strstr(output, key);
  ck_assert_msg(line != NULL, "no %s in %s", key, output);
  const char *at = strstr(line, text);
  ck_assert_msg(at && at < strchr(line, '\n'), "no %s behind %s in %s", text, key, output);
  return strtod(at + strlen(text), NULL);
}

/* A point by hand: r_n = -f_n, r_t = -min(mu r_n, f_t), x_t = (f_t + r_t) / 2. */
TEST(lines_hold_answers) {
  write_springs();
  char table[800];
  (void)snprintf(table, sizeof table, "mu,f\n0.1,%s/f.txt\n0.2,%s/g.txt\n.05,%s/f.txt\n", directory,
                 directory, directory);
  write_file("t.csv", table);
  ck_assert_int_eq(run(POINT "--table=@/t.csv --print"), 0);
  ck_assert_int_eq(line_feeds(output), 3);
  static const struct {
    const char *key;
    double r, x;
  } wanted[] = {{"\"mu\": 0.1}", 6, .7}, {"\"mu\": 0.2}", 12, -.2}, {"\"mu\": 0.05}", 6, .85}};
  for (int k = 0; k < 3; k++) {
    ck_assert_double_eq_tol(number_on_line(wanted[k].key, "\"r\": ["), wanted[k].r, 1e-7);
    const char *x = strstr(strstr(output, wanted[k].key), "\"x\": [");
    ck_assert_double_eq_tol(strtod(strchr(x, ',') + 1, NULL), k == 1 ? 0 : wanted[k].x, 1e-7);
  }
}

/* A study ends in the middle of a line, as kill -9 may leave it: the next run solves what is
 * missing, and no more; parts of it, in any order, join to the whole. */
TEST(a_study_goes_on) {
  write_springs();
  write_file("t.csv", "mu\n0.1\n0.2\n0.3\n0.4\n0.5\n");
  static const char call[] = POINT "--f=@/f.txt -T @/t.csv -o @/all.jsonl";
  ck_assert_int_eq(run(call), 0);
  ck_assert_ptr_nonnull(strstr(output, "5 cases: 5 solved, 0 not, 0 were there\nsolved\n"));
  char *whole = strdup(contents("all.jsonl")), *torn = strdup(whole);
  ck_assert_int_eq(line_feeds(whole), 5);
  char *cut = torn;
  for (int k = 0; k < 2; k++)
    cut = strchr(cut, '\n') + 1;
  cut[60] = '\0';
  write_file("all.jsonl", torn);
  ck_assert_int_eq(run(call), 0);
  ck_assert_ptr_nonnull(strstr(output, "5 cases: 3 solved, 0 not, 2 were there\n"));
  ck_assert_int_eq(line_feeds(contents("all.jsonl")), 5);
  ck_assert_int_eq(strncmp(contents("all.jsonl"), whole, (size_t)(cut - torn)), 0);
  ck_assert_int_eq(run(call), 0);
  ck_assert_ptr_nonnull(strstr(output, "5 cases: 0 solved, 0 not, 5 were there\n"));
  /* another tolerance is another case */
  ck_assert_int_eq(run(POINT "--f=@/f.txt -T @/t.csv -o @/all.jsonl --tol 1e-6"), 0);
  ck_assert_int_eq(line_feeds(contents("all.jsonl")), 10);
  int count = 0;
  for (int k = 3; k > 0; k--) {
    char arguments[200];
    (void)snprintf(arguments, sizeof arguments, POINT "--f=@/f.txt -T @/t.csv -o @/p --part=%d/3",
                   k);
    ck_assert_int_eq(run(arguments), 0);
    ck_assert_int_gt(line_feeds(contents("p")), count);
    count = line_feeds(contents("p"));
  }
  ck_assert_int_eq(count, 5);
  free(whole);
  free(torn);
}

/* SIGINT in a long study: the lines that are there are whole, and the next run adds the rest. */
TEST(an_interrupted_study_keeps_its_lines) {
  enum { cases = 30000 };
  char *table = malloc(16 * cases), *at = table, path[100], matrix[100];
  write_springs();
  at += sprintf(at, "mu\n");
  for (int k = 0; k < cases; k++)
    at += sprintf(at, "%.5f\n", 1e-5 * k);
  write_file("t.csv", table);
  free(table);
  (void)snprintf(path, sizeof path, "%s/o", directory);
  char words[6][100];
  static const char *const names[] = {"--stiffness=%s/K.txt", "--HN=%s/N.txt",    "--HT=%s/T.txt",
                                      "--f=%s/f.txt",         "--table=%s/t.csv", "--out=%s/o"};
  const char *program = getenv("DELASSUS_PROGRAM");
  for (int k = 0; k < 6; k++)
    (void)snprintf(words[k], sizeof words[k], names[k], directory);
  (void)snprintf(matrix, sizeof matrix, "%s", program ? program : "build/delassus");
  const pid_t child = fork();
  if (!child) {
    (void)execl(matrix, matrix, "study", words[0], words[1], words[2], words[3], words[4], words[5],
                "--quiet", (char *)NULL);
    _exit(99);
  }
  while (access(path, F_OK) || !contents("o")[0])
    (void)usleep(1000);
  ck_assert_int_eq(kill(child, SIGINT), 0);
  int status;
  ck_assert_int_eq(waitpid(child, &status, 0), child);
  ck_assert(WIFEXITED(status) && WEXITSTATUS(status) == 1);
  FILE *file = fopen(path, "r");
  ck_assert_ptr_nonnull(file);
  char line[4000];
  int count = 0;
  for (; fgets(line, sizeof line, file); count++)
    ck_assert(!strncmp(line, "{\"case\": ", 9) && !strcmp(line + strlen(line) - 2, "}\n"));
  ck_assert_int_eq(fclose(file), 0);
  ck_assert(count > 0 && count < cases);
}

/* Files beside each other, with the friction of a table; one that is none is named, and the others
 * are solved. */
TEST(files_are_cases) {
  NEEDS_HDF5;
  write_file("t.csv", "mu\n\n0.3\n");
  ck_assert_int_eq(run("study data/fclib/FC3D_Example1.hdf5 jean-fig4 @/t.csv -o @/o"), 2);
  ck_assert_ptr_nonnull(strstr(output, "t.csv"));
  ck_assert_int_eq(line_feeds(contents("o")), 2);
  write_file("t.csv", "mu\n1e-3\n0.3\n");
  ck_assert_int_le(run("study data/fclib/*.hdf5 -T @/t.csv"), 1);
  ck_assert_int_eq(line_feeds(output), 14);
  /* a proof that there is no solution is an answer, too */
  ck_assert_int_eq(run("study data/failures/c04-squeezed.txt -q -o @/n"), 1);
  ck_assert_str_eq(output, "not solved: 1 of 1 cases\n");
  ck_assert_ptr_nonnull(strstr(contents("n"), "\"status\": \"no_solution\""));
}

static const struct {
  const char *table, *arguments, *answer;
} wrong[] = {{"mue\n1\n", "jean-fig4", "did you mean mu?"},
             {"mu\n1,2\n", "jean-fig4", "row 1 has 2 fields"},
             {"mu\n1\n-2\n", "jean-fig4", "-2"},
             {"tol\nx\n", "jean-fig4", "in row 1"},
             {"out\na\n", "jean-fig4", "column 'out' is no option of a case"},
             {"limit\nf1.txt\n", "jean-fig4", "column 'limit' is no option of a case"},
             {"method\nnewtn\n", "jean-fig4", "did you mean newton?"},
             {"stiffness\nK\n", "jean-fig4", "one of them"},
             {"mu\n1\n", "", "give a file, a scene"},
             {"mu\n1\n", "jean-fig4 --part 3/2", "--part: '3/2'"},
             {"mu\n1\n", "jean-fig4 --part 0/2", "--part: '0/2'"},
             {"mu\n1\n", "jean-fig4 -o @/no/such", "no/such"}};

TEST_EACH(wrong_tables, 0, (int)(sizeof wrong / sizeof wrong[0])) {
  char arguments[200];
  write_file("t.csv", wrong[_i].table);
  (void)snprintf(arguments, sizeof arguments, "study -T @/t.csv %s", wrong[_i].arguments);
  ck_assert_int_eq(run(arguments), 2);
  ck_assert_msg(strstr(output, wrong[_i].answer) != NULL, "%s: %s", arguments, output);
}

int main(void) {
  return run_tests("study", make_directory, remove_directory);
}
