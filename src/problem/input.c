/* input.c: reads what can be read once only, standard input and pipes, into temporary files, for
 * readers that look at the first bytes and open again. They have names, for HDF5 wants one. */
#define _GNU_SOURCE
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include "problem.h"

enum { most_pipes = 16 };

/* The pipes that were read: their names, and those of their copies. */
static struct {
  char *name;
  char copy[PATH_ROOM];
} pipes[most_pipes];
static int pipe_count;

/* Copies all of `from` into a new file, whose name is returned in `copy`; 0 on failure. */
static int copy_pipe(FILE *from, char copy[PATH_ROOM]) {
  char bytes[1 << 12];
  if (snprintf(copy, PATH_ROOM, "%s/delassus-XXXXXX", temporary_place()) >= PATH_ROOM) return 0;
  end_at_once(0); /* the copy is to be removed */
  const int fd = mkstemp(copy);
  if (fd < 0) return 0;
  FILE *to = fdopen(fd, "wb");
  for (size_t got; to && (got = fread(bytes, 1, sizeof bytes, from)) > 0;)
    if (fwrite(bytes, 1, got, to) != got) break;
  const int good = to && !ferror(from) && !ferror(to);
  if ((to ? fclose(to) : close(fd)) == 0 && good) return 1;
  (void)unlink(copy);
  return 0;
}

const char *input_path(const char *path) {
  struct stat entry;
  const int is_standard = strcmp(path, "-") == 0;
  if (is_standard) path = "/dev/stdin";
  for (int k = 0; k < pipe_count; k++)
    if (strcmp(pipes[k].name, path) == 0) return pipes[k].copy;
  if (stat(path, &entry) || pipe_count == most_pipes) return path; /* opening tells what is wrong */
  const int is_terminal = is_standard && isatty(STDIN_FILENO);
  if (!S_ISFIFO(entry.st_mode) && !S_ISSOCK(entry.st_mode) && !is_terminal) return path;
  char *name = strdup(path);
  FILE *from = !name ? NULL : is_standard ? stdin : fopen(path, "rb");
  const int good = from && copy_pipe(from, pipes[pipe_count].copy);
  if (from && from != stdin) (void)fclose(from);
  if (!good) {
    free(name);
    return path;
  }
  pipes[pipe_count].name = name;
  return pipes[pipe_count++].copy;
}

void drop_inputs(void) {
  while (pipe_count > 0) {
    free(pipes[--pipe_count].name);
    (void)unlink(pipes[pipe_count].copy);
  }
}
