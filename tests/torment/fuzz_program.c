/*
 * fuzz_program.c: command lines and the files that they name. The first line of the bytes is the
 * command line; each line "---- NAME" starts a file.
 *
 * Words lose their slashes, so that all files stay in a fresh directory. solve and info run; the
 * other commands only read their options, because a mesh of any size may take any time.
 */
#define _GNU_SOURCE
#include <ftw.h>
#include <getopt.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include "fuzz.h"

int delassus_main(int argc, char **argv); /* main of src/cli/main.c */

enum { most_words = 24 };

static char program_directory[] = "/dev/shm/delassus-fuzz-XXXXXX";

static int remove_entry(const char *path, const struct stat *entry, int kind, struct FTW *where) {
  (void)entry, (void)kind;
  if (where->level > 0) (void)remove(path);
  return 0;
}

static void empty_directory(void) {
  (void)nftw(program_directory, remove_entry, 8, FTW_DEPTH | FTW_PHYS);
}

static void remove_program_directory(void) {
  empty_directory();
  (void)rmdir(program_directory);
}

/* Enters a directory of this process, where no program is found to draw with. */
static void enter_directory(void) {
  static int entered;
  if (entered++) return;
  if (!mkdtemp(program_directory) || chdir(program_directory)) abort();
  (void)atexit(remove_program_directory);
  (void)setenv("PATH", program_directory, 1);
}

/* Writes the files that come after the first line. */
static void write_parts(const char *at, const char *end) {
  FILE *file = NULL;
  while (at < end) {
    const char *stop = memchr(at, '\n', (size_t)(end - at));
    const char *next = stop ? stop + 1 : end;
    if (end - at > 5 && !memcmp(at, "---- ", 5)) {
      char name[32];
      (void)snprintf(name, sizeof name, "%.*s", (int)(next - at - 5), at + 5);
      name[strcspn(name, "/\n")] = '\0';
      if (file) (void)fclose(file);
      file = name[0] == '.' ? NULL : fopen(name, "wb");
    } else if (file)
      (void)fwrite(at, 1, (size_t)(next - at), file);
    at = next;
  }
  if (file) (void)fclose(file);
}

void fuzz_program(const unsigned char *data, size_t size) {
  char line[600], *words[most_words + 3], help[] = "--help", name[] = "delassus";
  const char *start = (const char *)data, *end = start + size;
  const char *stop = memchr(start, '\n', size);
  if (!stop || stop - start >= (long)sizeof line) return;
  memcpy(line, start, (size_t)(stop - start));
  line[stop - start] = '\0';
  int count = 0;
  words[count++] = name;
  for (char *word = strtok(line, " "); word && count < most_words; word = strtok(NULL, " ")) {
    char *to = word;
    for (const char *from = word; *from; from++)
      if (*from != '/') *to++ = *from;
    *to = '\0';
    if (!strstr(word, "..")) words[count++] = word;
  }
  if (count < 2) return;
  if (strcmp(words[1], "solve") != 0 && strcmp(words[1], "info") != 0) words[count++] = help;
  words[count] = NULL;
  enter_directory();
  write_parts(stop + 1, end);
  optind = 0;
  const int status = delassus_main(count, words);
  FUZZ_CHECK(status >= 0 && status <= 2);
  empty_directory();
}
