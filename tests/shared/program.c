/* program.c: program.h. */
#define _GNU_SOURCE
#include "program.h"

#include <check.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/wait.h>

char directory[64];
char output[200000];

void make_directory(void) {
  (void)snprintf(directory, sizeof directory, "/tmp/delassus-test-XXXXXX");
  ck_assert_ptr_nonnull(mkdtemp(directory));
}

void remove_directory(void) {
  char command[128];
  (void)snprintf(command, sizeof command, "rm -rf %s", directory);
  ck_assert_int_eq(system(command), 0);
}

int run(const char *arguments) {
  const char *program = getenv("DELASSUS_PROGRAM");
  char command[2000];
  int n = snprintf(command, sizeof command, "%s ", program ? program : "build/delassus");
  for (const char *a = arguments; *a; a++)
    n += snprintf(command + n, sizeof command - (size_t)n, *a == '@' ? "%s" : "%.1s",
                  *a == '@' ? directory : a);
  (void)snprintf(command + n, sizeof command - (size_t)n, " 2>&1");
  FILE *pipe = popen(command, "r");
  ck_assert_ptr_nonnull(pipe);
  const size_t got = fread(output, 1, sizeof output - 1, pipe);
  output[got] = '\0';
  const int status = pclose(pipe);
  ck_assert_msg(WIFEXITED(status), "%s: ended by a signal", arguments);
  return WEXITSTATUS(status);
}

int has_gnuplot(void) {
  const int has = system("command -v gnuplot >/dev/null") == 0;
  ck_assert_msg(has || !getenv("NO_SKIP"), "no gnuplot (Debian: gnuplot-nox)");
  return has;
}

const char *path_of(const char *name) {
  static char path[1000];
  (void)snprintf(path, sizeof path, "%s/%s", directory, name);
  return path;
}

FILE *open_file(const char *name, const char *mode) {
  FILE *file = fopen(path_of(name), mode);
  ck_assert_msg(file != NULL, "%s does not open", path_of(name));
  return file;
}

void write_file(const char *name, const char *text) {
  FILE *file = open_file(name, "w");
  ck_assert_int_ge(fputs(text, file), 0);
  ck_assert_int_eq(fclose(file), 0);
}

int lines_of(const char *name, char *last, int size) {
  FILE *file = open_file(name, "r");
  int lines = 0;
  while (fgets(last, size, file))
    lines++;
  (void)fclose(file);
  return lines;
}

const char *contents(const char *name) {
  static char text[1100000];
  FILE *file = open_file(name, "r");
  text[fread(text, 1, sizeof text - 1, file)] = '\0';
  (void)fclose(file);
  return text;
}

double number_after(const char *before) {
  const char *at = strstr(output, before);
  ck_assert_msg(at != NULL, "no %s in %s", before, output);
  return strtod(at + strlen(before), NULL);
}

double number_of(const char *name) {
  char key[64];
  (void)snprintf(key, sizeof key, "\"%s\": ", name);
  return number_after(key);
}
