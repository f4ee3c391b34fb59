/*
 * test_names.c: names of files, directories and titles may have any bytes. With all of them chart,
 * map, profile, info and solve run no command in a name, every file is well formed, and printed
 * text has no control characters. DELASSUS_NAMES: rounds of 8 names.
 */
#define _GNU_SOURCE
#include <fcntl.h>
#include <spawn.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include "base/utf8.h"
#include "program.h"
#include "run.h"

extern char **environ;

enum { name_room = 200, text_room = 2000000, most_names = 8 };
static char text[text_room];

/* Pieces that mean something to a shell, gnuplot, XML, CSV, printf or a terminal. */
static const char *const pieces[] = {"'",
                                     "\"",
                                     "\\",
                                     "`touch pwned`",
                                     "$(touch pwned)",
                                     "'; system \"touch pwned\"; #",
                                     "\n!touch pwned\n",
                                     "\n",
                                     "\r",
                                     "\t",
                                     "%",
                                     "%d",
                                     "%s%n",
                                     "{",
                                     "}",
                                     "{/:Bold",
                                     "#",
                                     "@",
                                     "$",
                                     "&",
                                     "<",
                                     "]]>",
                                     "&#0;",
                                     ",",
                                     ";",
                                     "\033[31m",
                                     "\x7f",
                                     "\xff",
                                     "\xc3",
                                     "\xe2\x82",
                                     "\xed\xa0\x80",
                                     "\xef\xbf\xbe",
                                     "\xc2\x85",
                                     "\xe2\x80\xae",
                                     "\xc3\xa9\xe6\xbc\xa2",
                                     " ",
                                     "-",
                                     "=1+1",
                                     "a",
                                     "END\n",
                                     "|",
                                     "0"};
enum { piece_count = sizeof pieces / sizeof pieces[0] };

static unsigned draw_number(unsigned *state) {
  *state = *state * 1664525u + 1013904223u;
  return *state >> 8;
}

/* Makes a name of pieces, or of any bytes; the number keeps names apart. */
static void make_name(char name[name_room], unsigned *state, int number) {
  int used = snprintf(name, name_room, "./%d", number);
  if (draw_number(state) % 3 == 0)
    for (unsigned k = draw_number(state) % 40; k > 0; k--) {
      const char byte = (char)(1 + draw_number(state) % 255);
      if (byte != '/') name[used++] = byte;
    }
  else
    for (unsigned k = 1 + draw_number(state) % 6; k > 0; k--)
      used += snprintf(name + used, (size_t)(name_room - used), "%s",
                       pieces[draw_number(state) % piece_count]);
  for (int k = 2; k < used; k++) /* a piece has one, for titles */
    if (name[k] == '/') name[k] = ':';
  (void)snprintf(name + used, (size_t)(name_room - used), ".txt");
}

/* Writes a problem of one block with this title into the test's directory. */
static void make_titled(const char *name, const char *title) {
  FILE *file = open_file(name, "w");
  (void)fprintf(file, "title %s\ncontact 2 1\nW\n2 1/2\n1/2 1\nq -1 1/3\nmu 1/2\n", title);
  ck_assert_int_eq(fclose(file), 0);
}

static void make_problem(const char *name) {
  make_titled(name, "block");
}

/* Runs the program in the test's directory; standard output and error go into the file "said".
 * Returns its exit status. */
static int run_there(const char *const *arguments) {
  char program[PATH_MAX], *argv[most_names + 8] = {program};
  const char *given = getenv("DELASSUS_PROGRAM");
  ck_assert_ptr_nonnull(realpath(given ? given : "build/delassus", program));
  for (int k = 0; arguments[k]; k++)
    argv[k + 1] = (char *)(size_t)arguments[k];
  posix_spawn_file_actions_t actions;
  pid_t child;
  int status;
  ck_assert_int_eq(posix_spawn_file_actions_init(&actions), 0);
  ck_assert_int_eq(posix_spawn_file_actions_addchdir_np(&actions, directory), 0);
  ck_assert_int_eq(
      posix_spawn_file_actions_addopen(&actions, 1, "said", O_WRONLY | O_CREAT | O_TRUNC, 0666), 0);
  ck_assert_int_eq(posix_spawn_file_actions_adddup2(&actions, 1, 2), 0);
  ck_assert_int_eq(posix_spawn(&child, program, &actions, NULL, argv, environ), 0);
  (void)posix_spawn_file_actions_destroy(&actions);
  ck_assert_int_eq(waitpid(child, &status, 0), child);
  ck_assert(WIFEXITED(status));
  return WEXITSTATUS(status);
}

/* Reads a file of the test's directory into text; returns 0 if there is none. */
static int read_there(const char *name) {
  char path[name_room + 100];
  (void)snprintf(path, sizeof path, "%s/%s", directory, name);
  FILE *file = fopen(path, "r");
  if (!file) return 0;
  text[fread(text, 1, sizeof text - 1, file)] = '\0';
  return fclose(file) == 0;
}

/* The text is UTF-8 without controls but line feeds and, with tabs = 1, tabs. */
static void expect_plain(const char *what, int tabs) {
  int length;
  for (const char *at = text; *at; at += length) {
    const long code = dlsi_utf8_next(at, &length);
    ck_assert_msg(code >= 0x20 ? code != 0xfffe && (code < 0x7f || code >= 0xa0)
                               : code == '\n' || (tabs && code == '\t'),
                  "%s: %lx at %.60s", what, (unsigned long)code, at);
  }
}

/* The text is a picture: tags begin with a letter, references are those of XML. */
static void expect_svg(const char *what) {
  expect_plain(what, 1);
  ck_assert_msg(strstr(text, "</svg>") != NULL, "%s: has no end", what);
  ck_assert_msg(strstr(text, "]]>") == NULL, "%s: ]]>", what);
  for (const char *at = text; (at = strchr(at, '<')) != NULL; at++)
    ck_assert_msg(strchr("?!/", at[1]) || (at[1] >= 'a' && at[1] <= 'z'), "%s: %.40s", what, at);
  for (const char *at = text; (at = strchr(at, '&')) != NULL; at++)
    ck_assert_msg(!strncmp(at, "&amp;", 5) || !strncmp(at, "&lt;", 4) || !strncmp(at, "&gt;", 4) ||
                      !strncmp(at, "&quot;", 6),
                  "%s: %.40s", what, at);
}

/* The text is a table: rows with as many fields as the first has. */
static void expect_csv(const char *what) {
  expect_plain(what, 0);
  int first = 0, count = 1, quoted = 0;
  for (const char *at = text; *at; at++) {
    if (*at == '"') quoted = !quoted;
    if (quoted) continue;
    count += *at == ',';
    if (*at != '\n') continue;
    if (!first) first = count;
    ck_assert_msg(count == first, "%s: %d of %d fields before %.40s", what, count, first, at);
    count = 1;
  }
  ck_assert(!quoted && first > 2);
}

/* The text is one JSON object: brackets in pairs, strings without controls, known escapes. */
static void expect_json(const char *what) {
  char open[40];
  int depth = 0, quoted = 0;
  expect_plain(what, 0);
  for (const char *at = text; *at; at++) {
    ck_assert_msg(at == text || depth > 0 || *at == '\n', "%s: %.40s", what, at);
    if (quoted && *at == '\\')
      ck_assert_msg(*++at && strchr("\"\\/bfnrtu", *at), "%s: %.40s", what, at);
    else if (*at == '"')
      quoted = !quoted;
    else if (quoted)
      ck_assert_msg(*at != '\n', "%s", what);
    else if (*at == '{' || *at == '[') {
      ck_assert_int_lt(depth, (int)sizeof open);
      open[depth++] = *at;
    } else if (*at == '}' || *at == ']')
      ck_assert_msg(depth > 0 && open[--depth] == *at - 2, "%s: %.40s", what, at);
  }
  ck_assert_msg(!depth && !quoted, "%s", what);
}

static void expect_nothing_run(void) {
  char command[200];
  (void)snprintf(command, sizeof command, "test -z \"$(find %s -name pwned)\"", directory);
  ck_assert_int_eq(system(command), 0);
}

/* Runs a command that works; what it says is plain and stands in text. */
static void expect_plain_run(const char *const *arguments) {
  const int status = run_there(arguments);
  ck_assert(read_there("said"));
  ck_assert_msg(status <= 1, "%s %s: %d, %s", arguments[0], arguments[1], status, text);
  expect_plain(arguments[0], 0);
}

/* The command drew, where there is gnuplot, and wrote its table. */
static void expect_files(const char *const *arguments, const char *picture, const char *table) {
  expect_plain_run(arguments);
  if (has_gnuplot()) {
    ck_assert_msg(!strstr(text, "did not draw") && !strstr(text, ".gp\" line"), "%s %s: %s",
                  arguments[0], arguments[1], text);
    ck_assert(read_there(picture));
    expect_svg(picture);
  }
  ck_assert(read_there(table));
  expect_csv(table);
  expect_nothing_run();
}

/* A report tells its page, which is as well formed as its pictures. */
static void expect_page(const char *name) {
  char page[220];
  const char *const report[] = {"report", "--cpu=0.2", "--out=r", name, NULL};
  expect_plain_run(report);
  const char *told = strstr(text, "\npage: ");
  ck_assert_msg(told && sscanf(told, "\npage: %219[^\n]", page) == 1, "%s", text);
  ck_assert(read_there(page));
  expect_plain(page, 1);
  ck_assert_msg(strstr(text, "</html>") != NULL, "%s: has no end", page);
  if (has_gnuplot()) expect_svg(page);
  expect_nothing_run();
}

static void expect_all_drawn(char names[most_names][name_room]) {
  const char *map[most_names + 3] = {"map", "--out=m"},
                               *profile[most_names + 3] = {"profile", "--out=p"};
  for (int k = 0; k < most_names; k++) {
    make_problem(names[k]);
    map[k + 2] = profile[k + 2] = names[k];
  }
  profile[3] = NULL; /* a problem costs a tenth of a second */
  expect_files(map, "m/map.svg", "m/map.csv");
  expect_files(profile, "p/profile.svg", "p/profile.csv");
  const char *const chart[] = {"chart", "--budget=0.1", "--out=c", names[0], NULL};
  expect_files(chart, "c/chart.svg", "c/chart.csv");
  const char *const solve[] = {"solve", "-q", names[1], "--plot=o", NULL};
  expect_files(solve, "o/history.svg", "o/history.csv");
  expect_page(names[0]);
}

/* The commands that draw nothing, with all these names; name 3 is a directory, 4 a history, 5 a
 * matrix. */
static void expect_all_written(char names[most_names][name_room]) {
  char option[3][name_room + 60], matrix[name_room + 20], csv[name_room + 20];
  make_titled(names[2], names[6] + 2); /* a title of several lines has lines of its own */
  make_problem(names[7]);
  const char *const info[] = {"info", names[2], NULL};
  (void)run_there(info);
  ck_assert(read_there("said"));
  expect_plain("info", 0);
  const char *const of_title[] = {"info", "--json", names[7], NULL};
  expect_plain_run(of_title);
  expect_json("info --json");
  (void)snprintf(option[0], sizeof option[0], "--csv=%s.d", names[3]);
  (void)snprintf(option[1], sizeof option[1], "--history=%s.csv", names[4]);
  (void)snprintf(matrix, sizeof matrix, "%s.mtx", names[5]);
  (void)snprintf(option[2], sizeof option[2], "--output=%s", matrix);
  const char *const solve[] = {"solve", "--json", option[0], option[1], option[2], names[7], NULL};
  expect_plain_run(solve);
  expect_json("solve --json");
  (void)snprintf(csv, sizeof csv, "%s.d/r.csv", names[3]);
  ck_assert(read_there(csv));
  expect_csv(csv);
  (void)snprintf(csv, sizeof csv, "%s.csv", names[4]);
  ck_assert(read_there(csv));
  expect_csv(csv);
  ck_assert(read_there(matrix));
  ck_assert_int_eq(strncmp(text, "%%MatrixMarket", 14), 0);
  (void)snprintf(option[0], sizeof option[0], "--plot=%s.d", names[3]);
  const char *const plot[] = {"solve", "-q", option[0], names[7], NULL};
  char picture[name_room + 20];
  (void)snprintf(picture, sizeof picture, "%s.d/history.svg", names[3]);
  (void)snprintf(csv, sizeof csv, "%s.d/history.csv", names[3]);
  expect_files(plot, picture, csv);
}

TEST(names_that_mean_something) {
  char names[most_names][name_room] = {"./x'; system \"touch pwned\"; #.hdf5",
                                       "./`touch pwned`'\"\\\n!touch pwned\n.txt",
                                       "./it's.hdf5",
                                       "./a,b\"c%d_{^}@&#;.txt",
                                       "./]]>&#0;\xff\xed\xa0\x80\033[31m.txt",
                                       "./'\\\xe2\x80\xae`touch pwned`\t.txt",
                                       "./\xc3\xa9\xe6\xbc\xa2}.txt",
                                       "./#END\n"};
  expect_all_drawn(names);
}

static int rounds(void) {
  const char *given = getenv("DELASSUS_NAMES");
  return given ? atoi(given) : 2;
}

TEST_EACH(names_of_any_bytes, 0, rounds()) {
  unsigned state = 77u + (unsigned)_i;
  char names[most_names][name_room];
  for (int k = 0; k < most_names; k++)
    make_name(names[k], &state, k);
  expect_all_drawn(names);
  expect_all_written(names);
}

/* An honest name stands in the picture as it is. */
TEST(an_apostrophe_is_drawn) {
  make_problem("it's 5% <&> {a_b}.txt");
  const char *const solve[] = {"solve", "-q", "it's 5% <&> {a_b}.txt", "--plot=o", NULL};
  expect_files(solve, "o/history.svg", "o/history.csv");
  if (!has_gnuplot()) return;
  ck_assert(read_there("o/history.svg"));
  ck_assert_ptr_nonnull(strstr(text, ">it's 5% &lt;&amp;> {a_b}.txt<"));
}

/* A spreadsheet takes no name for a formula; a page shows no mark that turns a line. */
TEST(names_that_compute_or_turn) {
  static const char *const signs[] = {"=", "+", "@"};
  make_problem("plain.txt");
  for (size_t k = 0; k < sizeof signs / sizeof *signs; k++) {
    char name[40], cell[40];
    (void)snprintf(name, sizeof name, "%scmd|x.txt", signs[k]);
    (void)snprintf(cell, sizeof cell, "\n'%scmd|x", signs[k]);
    make_problem(name);
    const char *const map[] = {"map", "-q", "--rows", "2", "--out=f", name, "plain.txt", NULL};
    ck_assert_int_eq(run_there(map), 0);
    ck_assert(read_there("f/map.csv"));
    ck_assert_msg(strstr(text, cell) != NULL, "%s", text);
  }
  make_titled("turned.txt", "exe.\xe2\x80\xaetxt.\xe2\x81\xa6");
  make_problem("a\xe2\x80\xaetxt.b");
  const char *const report[] = {"report", "-q", "--quick", "--out=h", "a\xe2\x80\xaetxt.b", NULL};
  const char *const titled[] = {"report", "-q", "--quick", "--out=h", "turned.txt", NULL};
  ck_assert_int_eq(run_there(report), 0);
  ck_assert_int_eq(run_there(titled), 0);
  char command[300];
  (void)snprintf(command, sizeof command,
                 "ls %s/h/*.html >/dev/null && ! cat %s/h/*.html | LC_ALL=C grep -q "
                 "$(printf '\\342\\200\\256')",
                 directory, directory);
  ck_assert_int_eq(system(command), 0);
}

/* Errors show the controls of what they are about; the words stand on one line. */
TEST(errors_escape_controls) {
  static const char strange[] = "no\033[31m\n\xff\xe2\x80\xae";
  static const char *const lines[][6] = {{"solve", strange},
                                         {"info", strange},
                                         {"chart", strange},
                                         {"map", strange},
                                         {"profile", strange},
                                         {"report", strange},
                                         {"scene", strange},
                                         {strange},
                                         {"solve", "-m", strange, "x"},
                                         {"solve", "-t", strange, "x"},
                                         {"solve", "--no\033\n\xff=1", "x"},
                                         {"solve", "--json=\033\n\xff", "x"},
                                         {"solve", "-\033", "x"}};
  for (size_t k = 0; k < sizeof lines / sizeof lines[0]; k++) {
    ck_assert_int_eq(run_there(lines[k]), 2);
    ck_assert(read_there("said"));
    expect_plain("said", 0);
    ck_assert_msg(strstr(text, "\\x1b"), "%s: %s", lines[k][0], text);
    ck_assert_msg(strchr(text, '\n') == text + strlen(text) - 1, "%s", text);
  }
}

int main(void) {
  return run_tests("names", make_directory, remove_directory);
}
